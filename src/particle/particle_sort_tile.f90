! SPDX-License-Identifier: BSD-3-Clause
!> Sorts the particles of a tile, with newcomers, by cell and then by identity.
module particle_sort_tile
   use base_field_worker, only: field_reader_t, field_worker_t
   use base_kinds, only: int64, wp
   use particle_store, only: store_t
   implicit none
   private

   public :: order_tile, sort_tile, tile_sorter_t, row_packer_t

   integer, parameter, public :: many = 1000 !! Least number of particles for several threads

   !> Packs listed particles into rows of integers, with the bit patterns of reals.
   type, extends(field_reader_t) :: row_packer_t
      integer, allocatable :: particle(:)             !! (row) Index in the store
      integer(int64), allocatable :: rows(:, :)       !! (word, row)
      integer :: word = 0                             !! Words filled so far
   contains
      procedure :: reals => packer_reals              !! Packs a field of real numbers
      procedure :: integers => packer_integers        !! Packs a field of integers
   end type row_packer_t

   !> Sorts the particles of one tile; scratch of one thread.
   type, extends(field_worker_t) :: tile_sorter_t
      integer :: first = 0                            !! First particle of the new range
      integer :: count = 0                            !! Particles of the new range
      integer :: word = 0                             !! Words of the rows used so far
      integer, allocatable :: source(:)               !! (new particle) Old index > 0 or row < 0
      integer, allocatable :: cell(:)                 !! Cell of each source
      integer, allocatable :: order(:)                !! Scratch
      integer(int64), pointer, contiguous :: rows(:, :) => null() !! (word, row) Newcomers
      real(wp), allocatable :: buffer(:)              !! Scratch
      integer(int64), allocatable :: integer_buffer(:)  !! Scratch
   contains
      procedure :: scalar => sorter_scalar           !! Sorts a scalar field
      procedure :: vector => sorter_vector           !! Sorts a vector or tensor field
      procedure :: whole => sorter_whole             !! Sorts an integer field
      procedure :: reserve => sorter_reserve     !! Allocates the scratch
   end type tile_sorter_t

contains

   !> Sort one tile: particles that stay and newcomers, by cell and then by identity.
   subroutine sort_tile(store, sorter, tile, now, newcomer, home)
      type(store_t), intent(inout) :: store           !! Gets the new count
      class(tile_sorter_t), intent(inout) :: sorter      !! Scratch, with the rows
      integer, intent(in) :: tile
      integer, intent(in) :: now                      !! Present first particle
      integer, intent(in) :: newcomer(:)              !! Rows that enter this tile
      integer, intent(in) :: home(:)                  !! (row) Cells of all rows
      integer :: p, cell

      call order_tile(store, sorter, tile, now, newcomer, home)
      sorter%first = store%first(tile)
      sorter%word = 0
      call store%walk(sorter)
      do cell = 0, ubound(store%cell_start, 1) - 1
         do p = store%cell_start(cell, tile), store%cell_start(cell + 1, tile) - 1
            store%home(store%first(tile) + p) = cell
         end do
      end do
      store%count(tile) = sorter%count
      store%unsorted(tile) = .false.
      store%leaving(tile) = 0
   end subroutine sort_tile

   !> Find the old row of each particle in the new range of a tile, and the range of each cell.
   subroutine order_tile(store, sorter, tile, now, newcomer, home)
      type(store_t), intent(inout) :: store           !! Gets the ranges of cells
      class(tile_sorter_t), intent(inout) :: sorter !! Scratch, with the rows; gets the sources
      integer, intent(in) :: tile
      integer, intent(in) :: now                      !! Present first particle
      integer, intent(in) :: newcomer(:)              !! Rows that enter this tile
      integer, intent(in) :: home(:)                  !! (row) Cells of all rows
      integer, parameter :: identity_word = 1
      integer :: p, n, cell, row

      call sorter%reserve(store%count(tile) + size(newcomer))
      n = 0
      do p = now, now + store%count(tile) - 1
         if (store%home(p) < 0) cycle
         n = n + 1
         sorter%order(n) = p
         sorter%cell(n) = store%home(p)
      end do
      do row = 1, size(newcomer)
         n = n + 1
         sorter%order(n) = -newcomer(row)
         sorter%cell(n) = home(newcomer(row))
      end do
      sorter%count = n
      call order_by_cell(sorter, n, store%cell_start(:, tile))
      do cell = 0, ubound(store%cell_start, 1) - 1
         if (store%cell_start(cell + 1, tile) - store%cell_start(cell, tile) < 2) cycle
         call order_by_identity(store, sorter, store%cell_start(cell, tile) + 1, &
            store%cell_start(cell + 1, tile), identity_word)
      end do
   end subroutine order_tile

   !> Group the sources of a tile by cell; in a cell they keep their order.
   pure subroutine order_by_cell(sorter, number, start)
      class(tile_sorter_t), intent(inout) :: sorter      !! Holds the list and gets the sources
      integer, intent(in) :: number                   !! Particles on the list
      integer, contiguous, intent(inout) :: start(0:) !! (0:cells) Particles before each cell
      integer :: p, cell, place

      start = 0
      do p = 1, number
         cell = sorter%cell(p) + 1
         start(cell) = start(cell) + 1
      end do
      do cell = 1, ubound(start, 1)
         start(cell) = start(cell) + start(cell - 1)
      end do
      do p = number, 1, -1
         ! backwards, with start as the cursor of each cell
         cell = sorter%cell(p)
         place = start(cell + 1)
         sorter%source(place) = sorter%order(p)
         start(cell + 1) = place - 1
      end do
      do cell = 0, ubound(start, 1) - 1
         start(cell) = start(cell + 1)
      end do
      start(ubound(start, 1)) = number
   end subroutine order_by_cell

   !> Sort the sources of one cell by identity, by insertion, because they are few and nearly
   !! sorted.
   pure subroutine order_by_identity(store, sorter, first, last, identity_word)
      type(store_t), intent(in) :: store
      class(tile_sorter_t), intent(inout) :: sorter      !! Holds the sources
      integer, intent(in) :: first                    !! First source of the cell
      integer, intent(in) :: last                     !! Last source of the cell
      integer, intent(in) :: identity_word            !! Word of the rows that holds the identity
      integer :: at, hole, held
      integer(int64) :: key

      do at = first + 1, last
         held = sorter%source(at)
         key = identity_of(held)
         hole = at
         do while (hole > first)
            if (identity_of(sorter%source(hole - 1)) <= key) exit
            sorter%source(hole) = sorter%source(hole - 1)
            hole = hole - 1
         end do
         sorter%source(hole) = held
      end do

   contains

      !> Identity of a source.
      pure integer(int64) function identity_of(source) result(number)
         integer, intent(in) :: source                !! Particle > 0 or row < 0

         if (source > 0) then
            number = store%identity(source)
         else
            number = sorter%rows(identity_word, -source)
         end if
      end function identity_of
   end subroutine order_by_identity

   !> Allocate the scratch for a number of particles.
   pure subroutine sorter_reserve(self, number)
      class(tile_sorter_t), intent(inout) :: self
      integer, intent(in) :: number                   !! Particles
      integer :: capacity

      if (allocated(self%source)) then
         if (size(self%source) >= number) return
         deallocate (self%source, self%cell, self%order, self%buffer, self%integer_buffer)
      end if
      capacity = number + number/4 + 16
      allocate (self%source(capacity), self%cell(capacity), self%order(capacity), &
         self%buffer(capacity), &
         self%integer_buffer(capacity))
   end subroutine sorter_reserve

   !> Sort a scalar field.
   subroutine sorter_scalar(self, name, unit, values)
      class(tile_sorter_t), intent(inout) :: self         !! Sources and scratch
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:) !! (particle)

      self%word = self%word + 1
      call reorder_reals(self, values)
   end subroutine sorter_scalar

   !> Sort a vector or tensor field.
   subroutine sorter_vector(self, name, unit, values)
      class(tile_sorter_t), intent(inout) :: self         !! Sources and scratch
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :) !! (particle, component)
      integer :: component

      do component = 1, size(values, 2)
         self%word = self%word + 1
         call reorder_reals(self, values(:, component))
      end do
   end subroutine sorter_vector

   !> Sort an integer field.
   subroutine sorter_whole(self, name, unit, values)
      class(tile_sorter_t), intent(inout) :: self         !! Sources and scratch
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:) !! (particle)
      integer :: p

      self%word = self%word + 1
      do p = 1, self%count
         if (self%source(p) > 0) then
            self%integer_buffer(p) = values(self%source(p))
         else
            self%integer_buffer(p) = self%rows(self%word, -self%source(p))
         end if
      end do
      values(self%first:self%first + self%count - 1) = self%integer_buffer(:self%count)
   end subroutine sorter_whole

   !> Sort one component.
   pure subroutine reorder_reals(self, values)
      class(tile_sorter_t), intent(inout) :: self         !! Sources and scratch
      real(wp), contiguous, intent(inout) :: values(:) !! (particle)
      integer :: p

      do p = 1, self%count
         if (self%source(p) > 0) then
            self%buffer(p) = values(self%source(p))
         else
            self%buffer(p) = transfer(self%rows(self%word, -self%source(p)), 0.0_wp)
         end if
      end do
      values(self%first:self%first + self%count - 1) = self%buffer(:self%count)
   end subroutine reorder_reals

   !> Pack a field of real numbers, one word a component.
   subroutine packer_reals(self, name, unit, is_scalar, values)
      class(row_packer_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)
      integer :: row, component

      !$omp parallel do default(none) shared(self, values) private(row, component) &
      !$omp if(size(self%particle) > many)
      do row = 1, size(self%particle)
         do component = 1, size(values, 2)
            self%rows(self%word + component, row) = &
               transfer(values(self%particle(row), component), 0_int64)
         end do
      end do
      !$omp end parallel do
      self%word = self%word + size(values, 2)
   end subroutine packer_reals

   !> Pack a field of integers, one word a row.
   subroutine packer_integers(self, name, unit, values)
      class(row_packer_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)
      integer :: row

      self%word = self%word + 1
      do row = 1, size(self%particle)
         self%rows(self%word, row) = values(self%particle(row))
      end do
   end subroutine packer_integers
end module particle_sort_tile
