! SPDX-License-Identifier: BSD-3-Clause
!> Matrices of three rows and three columns.
module base_matrix
   use base_kinds, only: wp
   implicit none
   private

   public :: determinant, inverse

contains

   !> Determinant of a matrix.
   pure real(wp) function determinant(matrix) result(value)
      real(wp), intent(in) :: matrix(3, 3)               !! Any matrix

      value = matrix(1, 1)*(matrix(2, 2)*matrix(3, 3) - matrix(2, 3)*matrix(3, 2)) &
         - matrix(1, 2)*(matrix(2, 1)*matrix(3, 3) - matrix(2, 3)*matrix(3, 1)) &
         + matrix(1, 3)*(matrix(2, 1)*matrix(3, 2) - matrix(2, 2)*matrix(3, 1))
   end function determinant

   !> Inverse of a matrix that has one.
   pure function inverse(matrix) result(dual)
      real(wp), intent(in) :: matrix(3, 3)               !! Matrix with a determinant that is not 0
      real(wp) :: dual(3, 3)
      integer :: i, j, i1, i2, j1, j2

      do j = 1, 3
         j1 = mod(j, 3) + 1
         j2 = mod(j + 1, 3) + 1
         do i = 1, 3
            ! the cofactor, with the indices that follow in cyclic order
            i1 = mod(i, 3) + 1
            i2 = mod(i + 1, 3) + 1
            dual(j, i) = matrix(i1, j1)*matrix(i2, j2) - matrix(i1, j2)*matrix(i2, j1)
         end do
      end do
      dual = dual/determinant(matrix)
   end function inverse
end module base_matrix
