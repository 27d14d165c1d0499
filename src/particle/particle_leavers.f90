! SPDX-License-Identifier: BSD-3-Clause
!> Particles on the way to other tiles: those that left their tiles, and those that enter. They are
!! packed and sent before the state of this rank changes, so that the messages can arrive during a
!! reduction, and a step that fails afterwards leaves the particles as they were.
module particle_leavers
   use base_communicator, only: communicator_t, posted_t
   use base_kinds, only: int64, wp
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_key
   use mesh_links, only: links_t
   use mesh_tiles, only: tiles_t
   use particle_inflow, only: fed_t
   use particle_place, only: find_place
   use particle_sort_tile, only: many, row_packer_t
   use particle_store, only: moved_away, store_t
   implicit none
   private

   public :: leavers_t, newcomers_t

   integer, parameter :: heading = 3                 !! Words before a row: store, key, cell

   !> Particles of one store that arrive at tiles of this rank.
   type :: newcomers_t
      integer(int64), allocatable :: key(:)           !! (row) Tile on the curve
      integer, allocatable :: cell(:)                 !! (row) Cell in the tile, from 0
      integer(int64), allocatable :: rows(:, :)       !! (word, row) Fields
      integer, allocatable :: row(:)                  !! Rows grouped by tile
      integer, allocatable :: before(:)               !! (tile + 1) Rows of lower tiles
   end type newcomers_t

   !> Particles between two tiles.
   type :: leavers_t
      type(newcomers_t), allocatable :: newcomers(:)  !! (store) Those for tiles of this rank
      logical :: sent = .false.                       !! Were the particles that left sent already?
      logical :: further = .false.                    !! Will particles enter on some rank?
      !> May a rank get receivers of patches that do not expect it? Of this rank after `send`, of
      !! all ranks after `receive`
      logical :: renew = .true.
      type(posted_t), private :: posted               !! Messages in transit
   contains
      procedure :: send => leavers_send               !! Pack and send
      procedure :: send_none => leavers_send_none     !! Take part in the exchange only
      procedure :: receive => leavers_receive         !! Receive
   end type leavers_t

contains

   !> Pack the particles for other tiles. Those that stay on the rank become newcomers, the others
   !! are sent. The stores do not change.
   subroutine leavers_send(self, communicator, grid, boundary, tiles, stores, links, fed)
      class(leavers_t), intent(inout) :: self        !! With `sent` only those that enter are added
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(tiles_t), intent(in) :: tiles
      type(store_t), intent(in) :: stores(:)
      type(links_t), intent(in) :: links             !! Ranks that expect messages of each other
      type(fed_t), intent(in), optional :: fed(:)    !! Particles that enter
      integer(int64), allocatable :: messages(:, :), none(:)
      integer, allocatable :: owner(:)
      type(newcomers_t) :: come
      integer :: index, row

      if (.not. self%sent) then
         if (allocated(self%newcomers)) deallocate (self%newcomers)
         allocate (self%newcomers(size(stores)))
      end if
      ! new lists have no receivers that get empty messages
      self%renew = links%surplus
      allocate (messages(row_words(stores), 0))
      do index = 1, size(stores)
         call pack_store(grid, boundary, stores(index), .not. self%sent, come)
         if (present(fed)) call append_fed(grid, boundary, fed, index, come)
         if (communicator%size > 1) then
            do row = 1, size(come%key)
               if (self%renew) exit
               self%renew = .not. links%cover(communicator%rank, grid, tiles, come%key(row))
            end do
            call take_remote(communicator%rank, tiles, index, come, messages)
         end if
         call add(self%newcomers(index), come)
      end do
      if (communicator%size == 1) return
      owner = [(tiles%owner(messages(2, row)), row=1, size(messages, 2))]
      call communicator%post_rows(owner, messages, self%posted, none)
   end subroutine leavers_send

   !> Take part in the exchange without particles of this rank.
   subroutine leavers_send_none(self, communicator, stores)
      class(leavers_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(store_t), intent(in) :: stores(:)
      integer(int64), allocatable :: none(:), nothing(:, :)
      integer :: nobody(0), index

      if (allocated(self%newcomers)) deallocate (self%newcomers)
      allocate (self%newcomers(size(stores)), nothing(row_words(stores), 0))
      do index = 1, size(stores)
         allocate (self%newcomers(index)%key(0), self%newcomers(index)%cell(0), &
            self%newcomers(index)%rows(stores(index)%words(), 0))
      end do
      self%renew = .false.
      call communicator%post_rows(nobody, nothing, self%posted, none)
   end subroutine leavers_send_none

   !> Receive the particles for this rank. With `values`, which then contain `renew` of this rank,
   !! the exchange ends with their reduction; the caller sets `renew` to the result. Collective.
   subroutine leavers_receive(self, communicator, stores, values)
      class(leavers_t), intent(inout) :: self        !! After `send`
      type(communicator_t), intent(inout) :: communicator
      type(store_t), intent(in) :: stores(:)
      real(wp), contiguous, intent(inout), optional :: values(:) !! Of this rank in, maxima out
      integer(int64), allocatable :: incoming(:)
      real(wp) :: renew(1)
      integer :: words

      if (communicator%size == 1) return
      if (present(values)) then
         call communicator%complete(self%posted, incoming, words, values)
      else
         renew = merge(1.0_wp, 0.0_wp, self%renew)
         call communicator%complete(self%posted, incoming, words, renew)
         self%renew = renew(1) > 0.0_wp
      end if
      ! after a start or new cuts these are most particles of the rank
      deallocate (self%posted%outgoing)
      call take_rows(stores, incoming(:words), self%newcomers)
   end subroutine leavers_receive

   !> Tiles, cells and fields of the particles that left their tiles of a store.
   subroutine pack_store(grid, boundary, store, moved, come)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(store_t), intent(in) :: store
      logical, intent(in) :: moved                   !! If not, none
      type(newcomers_t), intent(out) :: come
      type(row_packer_t) :: packer

      allocate (packer%particle(0))
      if (moved) call list_leavers(store, packer%particle)
      associate (n => size(packer%particle))
         allocate (packer%rows(store%words(), n), come%key(n), come%cell(n))
         packer%word = 0
         if (n > 0) call store%show(packer)
         call find_destinations(grid, boundary, store%position, packer%particle, come)
      end associate
      call move_alloc(packer%rows, come%rows)
   end subroutine pack_store

   !> Move the particles for tiles of other ranks from the newcomers to the messages.
   subroutine take_remote(rank, tiles, index, come, messages)
      integer, intent(in) :: rank                    !! This rank
      type(tiles_t), intent(in) :: tiles
      integer, intent(in) :: index                   !! Index of the store
      type(newcomers_t), intent(inout) :: come       !! All in, those of this rank out
      integer(int64), allocatable, intent(inout) :: messages(:, :) !! (word, row) Gets the others
      integer(int64), allocatable :: more(:, :)
      logical, allocatable :: here(:)
      integer :: row, filled

      allocate (here(size(come%key)))
      do row = 1, size(here)
         here(row) = tiles%owner(come%key(row)) == rank
      end do
      if (all(here)) return
      filled = size(messages, 2)
      allocate (more(size(messages, 1), filled + count(.not. here)))
      more(:, :filled) = messages
      do row = 1, size(here)
         if (here(row)) cycle
         filled = filled + 1
         more(:, filled) = 0
         more(:heading, filled) = [int(index, int64), come%key(row), int(come%cell(row), int64)]
         more(heading + 1:heading + size(come%rows, 1), filled) = come%rows(:, row)
      end do
      call move_alloc(more, messages)
      come%rows = pack_columns(come%rows, here)
      come%key = pack(come%key, here)
      come%cell = pack(come%cell, here)
   end subroutine take_remote

   !> Add newcomers to others.
   subroutine add(newcomers, come)
      type(newcomers_t), intent(inout) :: newcomers  !! Of one store
      type(newcomers_t), intent(inout) :: come       !! Those to add; undefined afterwards
      integer(int64), allocatable :: rows(:, :)
      integer :: filled

      if (.not. allocated(newcomers%key)) then
         call move_alloc(come%key, newcomers%key)
         call move_alloc(come%cell, newcomers%cell)
         call move_alloc(come%rows, newcomers%rows)
         return
      end if
      if (size(come%key) == 0) return
      filled = size(newcomers%key)
      allocate (rows(size(come%rows, 1), filled + size(come%key)))
      rows(:, :filled) = newcomers%rows
      rows(:, filled + 1:) = come%rows
      call move_alloc(rows, newcomers%rows)
      newcomers%key = [newcomers%key, come%key]
      newcomers%cell = [newcomers%cell, come%cell]
   end subroutine add

   !> Append the particles that enter a store to those that left their tiles.
   subroutine append_fed(grid, boundary, fed, index, come)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(fed_t), intent(in) :: fed(:)
      integer, intent(in) :: index                   !! Index of the store
      type(newcomers_t), intent(inout) :: come       !! Tiles, cells and fields
      type(newcomers_t) :: more
      integer :: n, row

      do n = 1, size(fed)
         if (fed(n)%store /= index .or. size(fed(n)%rows, 2) == 0) cycle
         more%rows = fed(n)%rows
         allocate (more%key(size(more%rows, 2)), more%cell(size(more%rows, 2)))
         do row = 1, size(more%key)
            call find_destination(grid, boundary, [fed(n)%position(row, 1), &
               fed(n)%position(row, 2), fed(n)%position(row, 3)], more%key(row), more%cell(row))
         end do
         call add(come, more)
         deallocate (more%rows, more%key, more%cell)
      end do
   end subroutine append_fed

   !> Find the tiles and cells of the particles that left theirs.
   subroutine find_destinations(grid, boundary, position, particle, come)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) [m]
      integer, intent(in) :: particle(:)             !! (row) Indices
      type(newcomers_t), intent(inout) :: come
      integer :: row

      !$omp parallel do default(none) shared(grid, boundary, position, particle, come) &
      !$omp private(row) schedule(static) if(size(particle) > many)
      do row = 1, size(particle)
         call find_destination(grid, boundary, [position(particle(row), 1), &
            position(particle(row), 2), position(particle(row), 3)], come%key(row), come%cell(row))
      end do
      !$omp end parallel do
   end subroutine find_destinations

   !> Columns of an array that a mask selects.
   pure function pack_columns(rows, mask) result(chosen)
      integer(int64), intent(in) :: rows(:, :)       !! (word, row)
      logical, intent(in) :: mask(:)                 !! (row)
      integer(int64), allocatable :: chosen(:, :)
      integer :: row, filled

      allocate (chosen(size(rows, 1), count(mask)))
      filled = 0
      do row = 1, size(mask)
         if (.not. mask(row)) cycle
         filled = filled + 1
         chosen(:, filled) = rows(:, row)
      end do
   end function pack_columns

   !> List the particles that left their tiles but not the domain.
   pure subroutine list_leavers(store, particle)
      type(store_t), intent(in) :: store
      integer, allocatable, intent(out) :: particle(:) !! Indices
      integer :: tile, p, number

      allocate (particle(sum(store%leaving)))
      number = 0
      do tile = 1, size(store%count)
         if (store%leaving(tile) == 0) cycle
         do p = store%first(tile), store%first(tile) + store%count(tile) - 1
            if (store%home(p) /= moved_away) cycle
            number = number + 1
            particle(number) = p
         end do
      end do
      particle = particle(:number)
   end subroutine list_leavers

   !> Find tile and cell of a position.
   pure subroutine find_destination(grid, boundary, position, key, cell)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      real(wp), intent(in) :: position(3)            !! [m]
      integer(int64), intent(out) :: key             !! Tile on the curve
      integer, intent(out) :: cell                   !! Cell in the tile, from 0
      integer :: owner(3), cells(3)
      logical :: lost

      call find_place(grid, boundary, position, owner, cells, lost)
      key = hilbert_key(owner, grid%dimensions)
      cell = cells(1) + grid%width(1)*(cells(2) + grid%width(2)*cells(3))
   end subroutine find_destination

   !> Words of a row of any store in a message.
   integer function row_words(stores) result(words)
      type(store_t), intent(in) :: stores(:)
      integer :: index

      words = heading
      do index = 1, size(stores)
         words = max(words, heading + stores(index)%words())
      end do
   end function row_words

   !> Add the rows that arrived to the newcomers of their stores.
   subroutine take_rows(stores, arrived, newcomers)
      type(store_t), intent(in) :: stores(:)
      integer(int64), intent(in) :: arrived(:)       !! Rows, one after another
      type(newcomers_t), intent(inout) :: newcomers(:) !! (store)
      type(newcomers_t) :: come
      integer :: index, number, row, filled, words

      words = row_words(stores)
      number = size(arrived)/words
      do index = 1, size(stores)
         filled = 0
         do row = 1, number
            if (arrived((row - 1)*words + 1) == index) filled = filled + 1
         end do
         if (filled == 0) cycle
         allocate (come%rows(stores(index)%words(), filled), come%key(filled), come%cell(filled))
         filled = 0
         do row = 1, number
            associate (at => (row - 1)*words)
               if (arrived(at + 1) /= index) cycle
               filled = filled + 1
               come%key(filled) = arrived(at + 2)
               come%cell(filled) = int(arrived(at + 3))
               come%rows(:, filled) = arrived(at + heading + 1:at + heading + size(come%rows, 1))
            end associate
         end do
         call add(newcomers(index), come)
         deallocate (come%rows, come%key, come%cell)
      end do
   end subroutine take_rows
end module particle_leavers
