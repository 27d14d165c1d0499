! SPDX-License-Identifier: BSD-3-Clause
!> The order of particles in files: by store, then by tile along the Hilbert curve, so that it
!! depends neither on ranks nor on the positions of particles in the arrays.
module io_order
   use base_communicator, only: communicator_t
   use base_kinds, only: int64
   use io_hdf5_write, only: rows_t
   use particle_store, only: store_t
   implicit none
   private

   public :: store_rows, tile_order

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

   !> Rows of a file for selected particles of each store, one range a store. Collective.
   function store_rows(communicator, counts, compress) result(rows)
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(in) :: counts(:)            !! (store) Particles of this rank
      integer, intent(in) :: compress                    !! gzip level
      type(rows_t) :: rows
      integer(int64) :: totals(size(counts))
      integer :: store

      totals = counts
      call communicator%total(totals)
      rows%total = sum(totals)
      rows%compress = compress
      allocate (rows%before(size(counts)), rows%count(size(counts)))
      rows%count(:) = counts
      do store = 1, size(counts)
         rows%before(store) = sum(totals(:store - 1)) + communicator%before(counts(store))
      end do
   end function store_rows
end module io_order
