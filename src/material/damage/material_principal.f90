! SPDX-License-Identifier: BSD-3-Clause
!> Principal values and axes of symmetric tensors.
module material_principal
   use base_kinds, only: wp
   implicit none
   private

   public :: compose, principal

contains

   !> Principal values in falling order, and their axes, by the rotations of C. G. J. Jacobi, which
   !! keep the axes orthogonal to round-off even for nearly equal values.
   pure subroutine principal(tensor, values, axes)
      real(wp), intent(in) :: tensor(6)              !! xx, yy, zz, xy, yz, xz
      real(wp), intent(out) :: values(3)             !! The greatest first
      real(wp), intent(out) :: axes(3, 3)            !! Axis j in (:, j)
      integer, parameter :: most_sweeps = 12
      real(wp) :: a(3, 3), column(3), scale
      integer :: sweep, i, j

      a(:, 1) = tensor([1, 4, 6])
      a(:, 2) = tensor([4, 2, 5])
      a(:, 3) = tensor([6, 5, 3])
      axes = 0.0_wp
      do i = 1, 3
         axes(i, i) = 1.0_wp
      end do
      scale = epsilon(1.0_wp)*maxval(abs(a))
      do sweep = 1, most_sweeps
         if (abs(a(1, 2)) + abs(a(1, 3)) + abs(a(2, 3)) <= 0.01_wp*scale) exit
         call turn(a, axes, 1, 2)
         call turn(a, axes, 1, 3)
         call turn(a, axes, 2, 3)
      end do
      do i = 1, 3
         values(i) = a(i, i)
      end do
      do i = 1, 2
         do j = 1, 3 - i
            if (values(j) >= values(j + 1)) cycle
            column = axes(:, j)
            axes(:, j) = axes(:, j + 1)
            axes(:, j + 1) = column
            column(1) = values(j)
            values(j) = values(j + 1)
            values(j + 1) = column(1)
         end do
      end do
   end subroutine principal

   !> One rotation in the plane of two axes that makes their component zero (W. H. Press and others,
   !! "Numerical Recipes", section 11.1).
   pure subroutine turn(a, axes, p, q)
      real(wp), intent(inout) :: a(3, 3)             !! Symmetric tensor
      real(wp), intent(inout) :: axes(3, 3)          !! Axes so far
      integer, intent(in) :: p                       !! One axis of the plane
      integer, intent(in) :: q                       !! Column of the rotation
      real(wp) :: ratio, t, c, s, column(3)

      if (.not. abs(a(p, q)) > 0.0_wp) return
      ratio = 0.5_wp*(a(q, q) - a(p, p))/a(p, q)
      t = 1.0_wp/(abs(ratio) + sqrt(ratio**2 + 1.0_wp))
      ! Its square can overflow; then the angle is small.
      if (abs(ratio) > 1.0e100_wp) t = 0.5_wp/abs(ratio)
      t = sign(t, ratio)
      c = 1.0_wp/sqrt(t**2 + 1.0_wp)
      s = t*c
      column = a(:, p)
      a(:, p) = c*column - s*a(:, q)
      a(:, q) = s*column + c*a(:, q)
      column = a(p, :)
      a(p, :) = c*column - s*a(q, :)
      a(q, :) = s*column + c*a(q, :)
      a(p, q) = 0.0_wp
      a(q, p) = 0.0_wp
      column = axes(:, p)
      axes(:, p) = c*column - s*axes(:, q)
      axes(:, q) = s*column + c*axes(:, q)
   end subroutine turn

   !> Tensor of given values along given axes.
   pure function compose(values, axes) result(tensor)
      real(wp), intent(in) :: values(3)              !! Principal values
      real(wp), intent(in) :: axes(3, 3)             !! Axis j in (:, j)
      real(wp) :: tensor(6)

      tensor(1) = sum(values*axes(1, :)**2)
      tensor(2) = sum(values*axes(2, :)**2)
      tensor(3) = sum(values*axes(3, :)**2)
      tensor(4) = sum(values*axes(1, :)*axes(2, :))
      tensor(5) = sum(values*axes(2, :)*axes(3, :))
      tensor(6) = sum(values*axes(1, :)*axes(3, :))
   end function compose
end module material_principal
