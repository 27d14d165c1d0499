! SPDX-License-Identifier: BSD-3-Clause
!> Linear functions averaged over the box of a particle, which keeps its first size (uGIMP): S. G.
!! Bardenhagen, E. M. Kober, Comput. Model. Eng. Sci. 5 (2004) 477.
module basis_gimp
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t, traits_t
   use transfer_places, only: places_t
   use transfer_tensor, only: basis_tensor_t
   implicit none
   private

   public :: basis_gimp_t

   real(wp), parameter :: least = 1.0e-6_wp          !! Least half of a box [cells]

   !> Means of the linear functions over boxes.
   type, extends(basis_tensor_t) :: basis_gimp_t
   contains
      procedure :: request => gimp_request           !! Particles carry their size
      procedure :: weigh => gimp_weigh               !! Functions along one direction
   end type basis_gimp_t

contains

   !> Particles carry half the edges of their boxes.
   pure subroutine gimp_request(self, traits)
      class(basis_gimp_t), intent(in) :: self                !! The basis
      type(traits_t), intent(inout) :: traits                !! Fields of the stores

      traits%extent = .true.
   end subroutine gimp_request

   !> Means over the box. It is no longer than a cell, so that it touches three nodes along a line.
   pure subroutine gimp_weigh(self, grid, store, tile, direction, places)
      class(basis_gimp_t), intent(in) :: self                !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      type(store_t), intent(in) :: store                     !! The particles
      integer, intent(in) :: tile                            !! Index of the tile
      integer, intent(in) :: direction                       !! 1 to 3
      type(places_t), intent(inout) :: places                !! Of the tile
      real(wp) :: x, half, inverse, away
      integer :: p, n

      inverse = 1.0_wp/grid%spacing
      do p = 1, store%count(tile)
         x = places%local(p, direction)
         half = min(max(store%extent(store%first(tile) + p - 1, direction)*inverse, least), &
               0.5_wp)
         places%low(p, direction) = merge(1, 2, x < half)
         do n = 1, size(places%weight, 2)
            away = x - real(n - 2, wp)
            places%weight(p, n, direction) = mean_function(abs(away), half)
            places%slope(p, n, direction) = -sign(inverse*mean_fall(abs(away), half), away)
         end do
      end do
   end subroutine gimp_weigh

   !> Mean of the hat function over a box with its centre at a distance from the node, in cells.
   pure real(wp) function mean_function(away, half) result(mean)
      real(wp), intent(in) :: away                           !! Distance, not negative [cells]
      real(wp), intent(in) :: half                           !! Half the box [cells]

      if (away < half) then
         mean = 1.0_wp - (away**2 + half**2)/(2.0_wp*half)
      else if (away < 1.0_wp - half) then
         mean = 1.0_wp - away
      else
         mean = max(1.0_wp + half - away, 0.0_wp)**2/(4.0_wp*half)
      end if
   end function mean_function

   !> How fast this mean falls with the distance [1/cell].
   pure real(wp) function mean_fall(away, half) result(fall)
      real(wp), intent(in) :: away                           !! Distance, not negative [cells]
      real(wp), intent(in) :: half                           !! Half the box [cells]

      if (away < half) then
         fall = away/half
      else if (away < 1.0_wp - half) then
         fall = 1.0_wp
      else
         fall = max(1.0_wp + half - away, 0.0_wp)/(2.0_wp*half)
      end if
   end function mean_fall
end module basis_gimp
