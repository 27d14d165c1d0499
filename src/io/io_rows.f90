! SPDX-License-Identifier: BSD-3-Clause
!> Rows of files: those of a rank follow those of the ranks before it, store after store.
module io_rows
   use base_communicator, only: communicator_t
   use base_kinds, only: int64
   use io_hdf5_write, only: rows_t
   implicit none
   private

   public :: store_rows

contains

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
end module io_rows
