! SPDX-License-Identifier: BSD-3-Clause
!> The order of particles in outputs: by tile along the Hilbert curve, so that it depends neither on
!! ranks nor on the positions of particles in the arrays.
module sample_order
   use particle_store, only: store_t
   implicit none
   private

   public :: tile_order

contains

   !> Indices of the particles of a store, tile after tile.
   pure subroutine tile_order(store, order)
      type(store_t), intent(in) :: store
      integer, allocatable, intent(out) :: order(:)      !! Indices
      integer :: filled, particle, tile

      allocate (order(store%particles()))
      filled = 0
      if (.not. allocated(store%count)) return
      do tile = 1, size(store%count)
         do particle = 1, store%count(tile)
            order(filled + particle) = store%first(tile) + particle - 1
         end do
         filled = filled + store%count(tile)
      end do
   end subroutine tile_order
end module sample_order
