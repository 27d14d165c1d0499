! SPDX-License-Identifier: BSD-3-Clause
!> Sorts all tiles of a store at once, into new arrays without gaps.
!!
!! Where tiles have few particles, almost every tile gains or loses some in a step. One pass through
!! each field then costs less than a pass through all fields for each tile, and no tile needs spare
!! capacity.
module particle_sort_store
   use base_field_worker, only: field_worker_t
   use base_kinds, only: int64, wp
   use particle_sort_tile, only: many, order_tile, tile_sorter_t
   use particle_store, only: store_t
   implicit none
   private

   public :: sort_store

   !> Copies fields into new arrays in sorted order.
   type, extends(field_worker_t) :: store_sorter_t
      integer, allocatable :: source(:) !! (particle) Old index > 0, row < 0, 0 = unused
      integer(int64), pointer, contiguous :: rows(:, :) => null() !! (word, row) Newcomers
      integer :: word = 0                             !! Words of the rows used so far
      ! the old array of a field is reused as the new array of the next field of the same shape
      real(wp), allocatable :: spare(:)               !! (particle) For scalars
      real(wp), allocatable :: spare_vector(:, :)     !! (particle, component) For vectors
      integer(int64), allocatable :: spare_whole(:)   !! (particle) For integers
   contains
      procedure :: scalar => store_sorter_scalar          !! Sorts a scalar field
      procedure :: vector => store_sorter_vector          !! Sorts a vector or tensor field
      procedure :: whole => store_sorter_whole            !! Sorts an integer field
   end type store_sorter_t

contains

   !> Sort all tiles of a store: particles that stay and newcomers, by cell and then by identity.
   subroutine sort_store(store, new_count, rows, before, row, home)
      type(store_t), intent(inout) :: store
      integer, intent(in) :: new_count(:)                  !! (tile) Counts with newcomers
      integer(int64), target, contiguous, intent(in) :: rows(:, :) !! (word, row) Newcomers
      integer, intent(in) :: before(:)                !! (tile + 1) Rows of lower tiles
      integer, intent(in) :: row(:)                   !! Rows grouped by tile
      integer, intent(in) :: home(:)                  !! (row) Cells of the rows
      type(store_sorter_t) :: store_sorter
      integer, allocatable :: first(:), cells(:)
      integer :: length

      call store%plan_ranges(new_count, first, length)
      if (keeps_length(store%used, size(store%identity))) length = size(store%identity)
      allocate (store_sorter%source(length), cells(length))
      store_sorter%source = 0
      cells = 0
      store_sorter%rows => rows
      call find_sources(store, first, rows, before, row, home, store_sorter%source, cells)
      call store%walk(store_sorter)
      call move_alloc(cells, store%home)
      call move_alloc(first, store%first)
      store%count = new_count
      store%unsorted = .false.
      store%leaving = 0
   end subroutine sort_store

   !> True if arrays of the old length have enough spare capacity, and not too much. New memory
   !! costs more than sorting, because the system clears it page by page.
   pure logical function keeps_length(used, length) result(keeps)
      integer, intent(in) :: used                     !! End of the last range
      integer, intent(in) :: length                   !! Length of the old arrays

      keeps = length >= used + used/64 + 64 .and. length <= used + used/24 + 64
   end function keeps_length

   !> Find the old index or the row of each particle, and its cell.
   subroutine find_sources(store, first, rows, before, row, home, source, cells)
      type(store_t), intent(inout) :: store           !! Gets the ranges of cells
      integer, intent(in) :: first(:)                 !! (tile) First particle of the new range
      integer(int64), target, contiguous, intent(in) :: rows(:, :) !! (word, row) Newcomers
      integer, intent(in) :: before(:)                !! (tile + 1) Rows of lower tiles
      integer, intent(in) :: row(:)                   !! Rows grouped by tile
      integer, intent(in) :: home(:)                  !! (row) Cells of the rows
      integer, intent(inout) :: source(:)             !! (particle) Old index > 0, row < 0
      integer, intent(inout) :: cells(:)              !! (particle) Cells
      type(tile_sorter_t) :: sorter
      integer :: tile, at, p

      !$omp parallel default(none) shared(store, first, rows, before, row, home, source, cells) &
      !$omp private(tile, at, p, sorter)
      sorter%rows => rows
      !$omp do schedule(dynamic, 64)
      do tile = 1, size(first)
         at = first(tile) - 1
         if (.not. store%unsorted(tile) .and. before(tile + 1) == before(tile)) then
            do p = 1, store%count(tile)
               source(at + p) = store%first(tile) + p - 1
               cells(at + p) = store%home(store%first(tile) + p - 1)
            end do
            cycle
         end if
         call order_tile(store, sorter, tile, store%first(tile), &
            row(before(tile) + 1:before(tile + 1)), home)
         do p = 1, sorter%count
            source(at + p) = sorter%source(p)
         end do
         call list_cells(store%cell_start(:, tile), cells(at + 1:at + sorter%count))
      end do
      !$omp end do
      !$omp end parallel
   end subroutine find_sources

   !> List the cells of the particles of a tile from the ranges of the cells.
   pure subroutine list_cells(start, cells)
      integer, contiguous, intent(in) :: start(0:)    !! (0:cells) Particles before each cell
      integer, intent(inout) :: cells(0:)             !! (particle, from 0)
      integer :: cell

      do cell = 0, ubound(start, 1) - 1
         cells(start(cell):start(cell + 1) - 1) = cell
      end do
   end subroutine list_cells

   !> Sort a scalar field.
   subroutine store_sorter_scalar(self, name, unit, values)
      class(store_sorter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:) !! (particle)
      real(wp), allocatable :: sorted(:)

      self%word = self%word + 1
      if (allocated(self%spare)) call move_alloc(self%spare, sorted)
      if (.not. allocated(sorted)) allocate (sorted(size(self%source)))
      call take_reals(self%source, self%rows, self%word, values, sorted)
      if (size(values) == size(sorted)) call move_alloc(values, self%spare)
      call move_alloc(sorted, values)
   end subroutine store_sorter_scalar

   !> Sort a vector or tensor field.
   subroutine store_sorter_vector(self, name, unit, values)
      class(store_sorter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :) !! (particle, component)
      real(wp), allocatable :: sorted(:, :)
      integer :: component

      if (allocated(self%spare_vector)) then
         if (size(self%spare_vector, 2) == size(values, 2)) then
            call move_alloc(self%spare_vector, sorted)
         else
            deallocate (self%spare_vector)
         end if
      end if
      if (.not. allocated(sorted)) allocate (sorted(size(self%source), size(values, 2)))
      do component = 1, size(values, 2)
         call take_reals(self%source, self%rows, self%word + component, values(:, component), &
            sorted(:, component))
      end do
      self%word = self%word + size(values, 2)
      if (size(values, 1) == size(sorted, 1)) call move_alloc(values, self%spare_vector)
      call move_alloc(sorted, values)
   end subroutine store_sorter_vector

   !> Sort an integer field.
   subroutine store_sorter_whole(self, name, unit, values)
      class(store_sorter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:) !! (particle)
      integer(int64), allocatable :: sorted(:)

      self%word = self%word + 1
      if (allocated(self%spare_whole)) call move_alloc(self%spare_whole, sorted)
      if (.not. allocated(sorted)) allocate (sorted(size(self%source)))
      call take_integers(self%source, self%rows, self%word, values, sorted)
      if (size(values) == size(sorted)) call move_alloc(values, self%spare_whole)
      call move_alloc(sorted, values)
   end subroutine store_sorter_whole

   !> Copy integers from the old arrays or the rows.
   subroutine take_integers(source, rows, word, values, sorted)
      integer, intent(in) :: source(:) !! (particle) Old index > 0, row < 0, 0 = unused
      integer(int64), contiguous, intent(in) :: rows(:, :) !! (word, row) Newcomers
      integer, intent(in) :: word                     !! Word of the rows
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)
      integer(int64), contiguous, intent(inout) :: sorted(:) !! (new particle)
      integer :: p

      !$omp parallel do default(none) shared(source, rows, word, values, sorted) private(p) &
      !$omp schedule(static) if(size(source) > many)
      do p = 1, size(source)
         if (source(p) > 0) then
            sorted(p) = values(source(p))
         else if (source(p) < 0) then
            sorted(p) = rows(word, -source(p))
         else
            sorted(p) = 0
         end if
      end do
      !$omp end parallel do
   end subroutine take_integers

   !> Copy reals from the old arrays or the rows.
   subroutine take_reals(source, rows, word, values, sorted)
      integer, intent(in) :: source(:) !! (particle) Old index > 0, row < 0, 0 = unused
      integer(int64), contiguous, intent(in) :: rows(:, :) !! (word, row) Newcomers
      integer, intent(in) :: word                     !! Word of the rows
      real(wp), contiguous, intent(in) :: values(:)   !! (particle)
      real(wp), contiguous, intent(inout) :: sorted(:) !! (new particle)
      integer :: p

      !$omp parallel do default(none) shared(source, rows, word, values, sorted) private(p) &
      !$omp schedule(static) if(size(source) > many)
      do p = 1, size(source)
         if (source(p) > 0) then
            sorted(p) = values(source(p))
         else if (source(p) < 0) then
            sorted(p) = transfer(rows(word, -source(p)), 0.0_wp)
         else
            sorted(p) = 0.0_wp
         end if
      end do
      !$omp end parallel do
   end subroutine take_reals
end module particle_sort_store
