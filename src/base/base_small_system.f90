! SPDX-License-Identifier: BSD-3-Clause
!> Small systems of linear equations.
module base_small_system
   use base_kinds, only: wp
   implicit none
   private

   public :: solve_small

contains

   !> Solve a system by elimination with row pivots. A pivot of zero leaves its unknown at zero.
   pure subroutine solve_small(matrix, values)
      real(wp), intent(inout) :: matrix(:, :)        !! (row, column) Destroyed
      real(wp), intent(inout) :: values(:)           !! Right side in, solution out
      real(wp) :: row(size(values)), factor, value
      integer :: best, k, n

      do k = 1, size(values)
         best = k - 1 + maxloc(abs(matrix(k:, k)), 1)
         if (best /= k) then
            row = matrix(k, :)
            matrix(k, :) = matrix(best, :)
            matrix(best, :) = row
            value = values(k)
            values(k) = values(best)
            values(best) = value
         end if
         if (.not. abs(matrix(k, k)) > 0.0_wp) cycle
         do n = k + 1, size(values)
            factor = matrix(n, k)/matrix(k, k)
            matrix(n, :) = matrix(n, :) - factor*matrix(k, :)
            values(n) = values(n) - factor*values(k)
         end do
      end do
      do k = size(values), 1, -1
         do n = k + 1, size(values)
            values(k) = values(k) - matrix(k, n)*values(n)
         end do
         if (abs(matrix(k, k)) > 0.0_wp) then
            values(k) = values(k)/matrix(k, k)
         else
            values(k) = 0.0_wp
         end if
      end do
   end subroutine solve_small
end module base_small_system
