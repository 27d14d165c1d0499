! SPDX-License-Identifier: BSD-3-Clause
!> Quadratic B-splines round the nodes: M. Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods
!! Eng. 76 (2008) 922.
module basis_quadratic
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_places, only: places_t
   use transfer_tensor, only: basis_tensor_t
   implicit none
   private

   public :: basis_quadratic_t

   !> Quadratic B-splines.
   type, extends(basis_tensor_t) :: basis_quadratic_t
   contains
      procedure :: weigh => quadratic_weigh          !! Functions along one direction
   end type basis_quadratic_t

contains

   !> With the distance d from the nearest node in cells: 3/4 - d**2 there and (1/2 -+ d)**2/2 at
   !! its
   !! neighbours.
   pure subroutine quadratic_weigh(self, grid, store, tile, direction, places)
      class(basis_quadratic_t), intent(in) :: self           !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      type(store_t), intent(in) :: store                     !! The particles
      integer, intent(in) :: tile                            !! Index of the tile
      integer, intent(in) :: direction                       !! 1 to 3
      type(places_t), intent(inout) :: places                !! Of the tile
      real(wp) :: d, inverse
      integer :: p, upper

      inverse = 1.0_wp/grid%spacing
      do p = 1, store%count(tile)
         upper = merge(1, 0, places%local(p, direction) >= 0.5_wp)
         d = places%local(p, direction) - real(upper, wp)
         places%weight(p, :, direction) = 0.0_wp
         places%slope(p, :, direction) = 0.0_wp
         places%low(p, direction) = 1 + upper
         places%weight(p, 1 + upper, direction) = 0.5_wp*(0.5_wp - d)**2
         places%weight(p, 2 + upper, direction) = 0.75_wp - d**2
         places%weight(p, 3 + upper, direction) = 0.5_wp*(0.5_wp + d)**2
         places%slope(p, 1 + upper, direction) = inverse*(d - 0.5_wp)
         places%slope(p, 2 + upper, direction) = -2.0_wp*inverse*d
         places%slope(p, 3 + upper, direction) = inverse*(d + 0.5_wp)
      end do
   end subroutine quadratic_weigh
end module basis_quadratic
