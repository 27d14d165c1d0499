! SPDX-License-Identifier: BSD-3-Clause
!> The weight alpha of the gradient on the particle's own cell in the modified gradient.
!!
!! alpha vanishes on the faces of the cell, so the modified gradient has no jump there
!! (D. Z. Zhang, X. Ma, P. T. Giguere, J. Comput. Phys. 230 (2011) 6379).
module ddmp_alpha
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: find_alpha, find_blend, mean_alpha

   integer, parameter, public :: alpha_split = 1     !! One bubble per direction, for its derivative
   integer, parameter, public :: alpha_product = 2   !! Product of the bubbles, for all derivatives
   integer, parameter, public :: alpha_squared = 3   !! Square of that product
   character(len=14), parameter, public :: alpha_names(3) = [character(len=14) :: "split", &
      "product", "bubble_squared"]

contains

   !> alpha of each particle of a tile for the derivative along each direction. Equations (M.8),
   !! (M.9) and (M.10) of doc/theory/method.md.
   pure subroutine find_alpha(grid, kind, centre, number, local, alpha)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: kind                    !! One of the kinds above
      real(wp), intent(in) :: centre                 !! Value at the centre of the cell
      integer, intent(in) :: number                  !! Particles of the tile
      real(wp), contiguous, intent(in) :: local(:, :)    !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(inout) :: alpha(:, :) !! (particle of the tile, 3)
      real(wp) :: factor
      integer :: p, direction

      factor = merge(centre, 1.0_wp, kind == alpha_split)
      do direction = 1, 3
         if (.not. grid%active(direction)) then
            alpha(:number, direction) = 1.0_wp
            cycle
         end if
         do p = 1, number
            alpha(p, direction) = factor*(4.0_wp*local(p, direction) &
               *(1.0_wp - local(p, direction)))
         end do
      end do
      if (kind == alpha_split) return
      if (kind == alpha_product .or. kind == alpha_squared) then
         do p = 1, number
            alpha(p, 1) = alpha(p, 1)*alpha(p, 2)*alpha(p, 3)
            alpha(p, 2) = alpha(p, 1)
            alpha(p, 3) = alpha(p, 1)
         end do
      end if
      if (kind == alpha_squared) then
         do p = 1, number
            alpha(p, 1) = alpha(p, 1)**2
            alpha(p, 2) = alpha(p, 1)
            alpha(p, 3) = alpha(p, 1)
         end do
      end if
      do direction = 1, 3
         if (.not. grid%active(direction)) cycle
         do p = 1, number
            alpha(p, direction) = centre*alpha(p, direction)
         end do
      end do
   end subroutine find_alpha

   !> Mean of alpha over a cell [1]. As alpha is even about the centre of the cell along each
   !! direction, and the functions of the nodes add up to one, the integral of its product with the
   !! function of any corner or edge is the mean times the integral of that function.
   pure real(wp) function mean_alpha(kind, centre, dimensions) result(mean)
      integer, intent(in) :: kind                    !! One of the kinds above
      real(wp), intent(in) :: centre                 !! Value at the centre of the cell
      integer, intent(in) :: dimensions              !! Dimensions of the scene

      select case (kind)
      case (alpha_product)
         mean = centre*(2.0_wp/3.0_wp)**dimensions
      case (alpha_squared)
         mean = centre*(8.0_wp/15.0_wp)**dimensions
      case default
         mean = centre*2.0_wp/3.0_wp
      end select
   end function mean_alpha

   !> Local coordinate along each direction for mapping stress to the nodes and gradients from them:
   !! 3 x**2 - 2 x**3 instead of x.
   !!
   !! With it the modified gradient also has no kink where a particle changes its cell: the
   !! bubbles of neighbouring cells cancel there, and only a linear interpolation of the node
   !! gradient would leave a kink. Conservation holds, because the functions still sum to one and
   !! force and strain use the same functions. Equation (M.11).
   pure subroutine find_blend(grid, number, local, blend)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: number                  !! Particles of the tile
      real(wp), contiguous, intent(in) :: local(:, :)    !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(inout) :: blend(:, :) !! (particle of the tile, 3)
      integer :: p, direction

      do direction = 1, 3
         if (.not. grid%active(direction)) then
            blend(:number, direction) = 0.0_wp
            cycle
         end if
         do p = 1, number
            blend(p, direction) = local(p, direction)**2*(3.0_wp - 2.0_wp*local(p, direction))
         end do
      end do
   end subroutine find_blend
end module ddmp_alpha
