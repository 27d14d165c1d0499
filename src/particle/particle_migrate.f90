! SPDX-License-Identifier: BSD-3-Clause
!> Moves particles that left their tiles to their new tiles and ranks.
module particle_migrate
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_key
   use mesh_tiles, only: tiles_t
   use particle_inflow, only: fed_t
   use particle_place, only: find_place
   use particle_sort_store, only: sort_store
   use particle_sort_tile, only: many, row_packer_t, sort_tile, tile_sorter_t
   use particle_store, only: moved_away, store_t
   implicit none
   private

   public :: migrate

   integer, parameter :: heading = 3                 !! Words before a row: store, key, cell

   !> Particles of one store that arrive at tiles of this rank.
   type :: newcomers_t
      integer(int64), allocatable :: key(:)           !! (row) Tile on the curve
      integer, allocatable :: cell(:)                 !! (row) Cell in the tile, from 0
      integer(int64), allocatable :: rows(:, :)       !! (word, row) Fields
      integer, allocatable :: row(:)                  !! Rows grouped by tile
      integer, allocatable :: before(:)               !! (tile + 1) Rows of lower tiles
   end type newcomers_t

contains

   !> Move every particle that left its tile to its new one, create tiles in empty space, remove
   !! empty tiles, and sort the particles of each tile. Particles that left the domain are removed;
   !! the balance must have recorded them before.
   subroutine migrate(communicator, grid, boundary, tiles, stores, fed)
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(tiles_t), intent(inout) :: tiles          !! The tiles of this rank
      type(store_t), intent(inout) :: stores(:)
      type(fed_t), intent(in), optional :: fed(:)    !! Particles that enter, for any tiles
      type(newcomers_t), allocatable :: newcomers(:)
      integer(int64), allocatable :: messages(:, :), arrived(:)
      integer :: index

      allocate (newcomers(size(stores)))
      call collect_leavers(communicator, grid, boundary, tiles, stores, newcomers, messages, fed)
      if (communicator%size > 1) then
         call send_rows(communicator, tiles, messages, arrived)
         call receive_rows(stores, arrived, size(messages, 1), newcomers)
      end if
      call update_tiles(grid, tiles, stores, newcomers)
      do index = 1, size(stores)
         call group_by_tile(tiles, newcomers(index))
         call sort_tiles(stores(index), newcomers(index))
      end do
   end subroutine migrate

   !> Extract the particles that left their tiles: those that stay on the rank become newcomers, the
   !! others messages.
   subroutine collect_leavers(communicator, grid, boundary, tiles, stores, newcomers, messages, fed)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(tiles_t), intent(in) :: tiles
      type(store_t), intent(inout) :: stores(:)
      type(newcomers_t), intent(inout) :: newcomers(:) !! (store) Particles that stay on the rank
      integer(int64), allocatable, intent(out) :: messages(:, :) !! (word, row) The others
      type(fed_t), intent(in), optional :: fed(:)    !! Particles that enter
      integer(int64), allocatable :: more(:, :)
      logical, allocatable :: here(:)
      type(row_packer_t) :: packer
      integer :: index, words, row, remote, filled

      words = heading
      do index = 1, size(stores)
         words = max(words, heading + stores(index)%words())
      end do
      allocate (messages(words, 0))
      do index = 1, size(stores)
         call list_leavers(stores(index), packer%particle)
         associate (n => size(packer%particle), come => newcomers(index))
            if (allocated(packer%rows)) deallocate (packer%rows)
            allocate (packer%rows(stores(index)%words(), n))
            packer%word = 0
            if (n > 0) call stores(index)%show(packer)
            allocate (come%key(n), come%cell(n))
            call find_destinations(grid, boundary, stores(index)%position, packer%particle, come)
            if (present(fed)) call append_fed(grid, boundary, fed, index, packer%rows, come)
            allocate (here(size(come%key)))
            do row = 1, size(here)
               here(row) = tiles%owner(come%key(row)) == communicator%rank
            end do
            remote = count(.not. here)
            filled = size(messages, 2)
            allocate (more(words, filled + remote))
            more(:, :filled) = messages
            do row = 1, size(here)
               if (here(row)) cycle
               filled = filled + 1
               more(:, filled) = 0
               more(:heading, filled) = [int(index, int64), come%key(row), &
                  int(come%cell(row), int64)]
               more(heading + 1:heading + size(packer%rows, 1), filled) = packer%rows(:, row)
            end do
            call move_alloc(more, messages)
            if (remote > 0) then
               come%rows = pack_columns(packer%rows, here)
               come%key = pack(come%key, here)
               come%cell = pack(come%cell, here)
            else
               call move_alloc(packer%rows, come%rows)
            end if
            deallocate (here)
         end associate
      end do
   end subroutine collect_leavers

   !> Append the particles that enter a store to those that left their tiles.
   subroutine append_fed(grid, boundary, fed, index, rows, come)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(fed_t), intent(in) :: fed(:)
      integer, intent(in) :: index                   !! Index of the store
      integer(int64), allocatable, intent(inout) :: rows(:, :) !! (word, row) Fields
      type(newcomers_t), intent(inout) :: come       !! Tiles and cells
      integer(int64), allocatable :: longer(:, :), key(:)
      integer, allocatable :: cell(:)
      integer :: n, filled, row

      do n = 1, size(fed)
         if (fed(n)%store /= index .or. size(fed(n)%rows, 2) == 0) cycle
         filled = size(come%key)
         allocate (longer(size(rows, 1), filled + size(fed(n)%rows, 2)))
         allocate (key(size(longer, 2)), cell(size(longer, 2)))
         longer(:, :filled) = rows
         longer(:, filled + 1:) = fed(n)%rows
         key(:filled) = come%key
         cell(:filled) = come%cell
         do row = 1, size(fed(n)%rows, 2)
            call find_destination(grid, boundary, [fed(n)%position(row, 1), &
               fed(n)%position(row, 2), fed(n)%position(row, 3)], key(filled + row), &
               cell(filled + row))
         end do
         call move_alloc(longer, rows)
         call move_alloc(key, come%key)
         call move_alloc(cell, come%cell)
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

   !> Send rows to the owners of their tiles.
   subroutine send_rows(communicator, tiles, messages, arrived)
      type(communicator_t), intent(inout) :: communicator
      type(tiles_t), intent(in) :: tiles
      integer(int64), contiguous, intent(in) :: messages(:, :) !! (word, row)
      !> Rows for this rank, one after another
      integer(int64), allocatable, intent(out) :: arrived(:)
      integer, allocatable :: owner(:)
      integer :: row

      allocate (owner(size(messages, 2)))
      do row = 1, size(owner)
         owner(row) = tiles%owner(messages(2, row))
      end do
      call communicator%send_rows(owner, messages, arrived)
   end subroutine send_rows

   !> Add the rows that arrived to the newcomers of their stores.
   subroutine receive_rows(stores, arrived, words, newcomers)
      type(store_t), intent(inout) :: stores(:)
      integer(int64), intent(in) :: arrived(:)       !! Rows, one after another
      integer, intent(in) :: words                   !! Words of a row
      type(newcomers_t), intent(inout) :: newcomers(:) !! (store)
      integer(int64), allocatable :: rows(:, :), key(:)
      integer, allocatable :: cell(:)
      integer :: index, number, row, filled, n

      number = size(arrived)/words
      do index = 1, size(stores)
         associate (come => newcomers(index))
            filled = size(come%key)
            n = filled
            do row = 1, number
               if (arrived((row - 1)*words + 1) == index) n = n + 1
            end do
            if (n == filled) cycle
            allocate (rows(stores(index)%words(), n), key(n), cell(n))
            rows(:, :filled) = come%rows
            key(:filled) = come%key
            cell(:filled) = come%cell
            do row = 1, number
               associate (at => (row - 1)*words)
                  if (arrived(at + 1) /= index) cycle
                  filled = filled + 1
                  key(filled) = arrived(at + 2)
                  cell(filled) = int(arrived(at + 3))
                  rows(:, filled) = arrived(at + heading + 1:at + heading + size(rows, 1))
               end associate
            end do
            call move_alloc(rows, come%rows)
            call move_alloc(key, come%key)
            call move_alloc(cell, come%cell)
         end associate
      end do
   end subroutine receive_rows

   !> Create tiles for newcomers in empty space and remove empty tiles.
   subroutine update_tiles(grid, tiles, stores, newcomers)
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles
      type(store_t), intent(inout) :: stores(:)
      type(newcomers_t), intent(in) :: newcomers(:)  !! (store)
      integer(int64), allocatable :: key(:), ghost(:)
      integer, allocatable :: old(:)
      logical, allocatable :: kept(:)
      integer :: index, tile, row, number

      allocate (kept(tiles%own))
      kept = .false.
      number = 0
      do index = 1, size(stores)
         do tile = 1, tiles%own
            kept(tile) = kept(tile) .or. stores(index)%count(tile) > stores(index)%leaving(tile)
         end do
         number = number + size(newcomers(index)%key)
      end do
      allocate (key(number))
      number = 0
      do index = 1, size(stores)
         do row = 1, size(newcomers(index)%key)
            tile = tiles%table%find(newcomers(index)%key(row))
            if (tile > 0 .and. tile <= tiles%own) then
               kept(tile) = .true.
            else
               number = number + 1
               key(number) = newcomers(index)%key(row)
            end if
         end do
      end do
      ! particles that were just read are in one range, which is no tile
      if (number == 0 .and. all(kept) .and. size(stores(1)%count) == tiles%own) return
      ghost = tiles%key(tiles%own + 1:tiles%all)
      call merge_keys(pack(tiles%key(:tiles%own), kept), pack([(tile, tile=1, tiles%own)], kept), &
         key(:number), old)
      call tiles%set(grid, merged_keys(tiles%key, key(:number), old), &
         ghost_without(ghost, key(:number)))
      do index = 1, size(stores)
         call stores(index)%remap(old_index(old), grid%tile_cells)
      end do

   contains

      !> Old tile, or 0 for a new one.
      pure function old_index(marks) result(old_tile)
         integer, intent(in) :: marks(:)             !! Old tile > 0 or new key < 0
         integer :: old_tile(size(marks))

         old_tile = max(marks, 0)
      end function old_index
   end subroutine update_tiles

   !> Merge kept tiles and new keys into one ascending list: old index, or minus the new key's.
   pure subroutine merge_keys(kept_key, kept_tile, new_key, mark)
      integer(int64), intent(in) :: kept_key(:)      !! Ascending
      integer, intent(in) :: kept_tile(:)            !! Indices of these tiles
      integer(int64), intent(in) :: new_key(:)       !! In any order, with repetitions
      integer, allocatable, intent(out) :: mark(:)   !! (tile) > 0 old tile, < 0 index in new_key
      integer :: order(size(new_key)), i, j, n
      integer(int64) :: before

      order = sort_order(new_key)
      allocate (mark(size(kept_key) + size(new_key)))
      i = 1
      n = 0
      before = -1
      do j = 1, size(order)
         if (new_key(order(j)) == before) cycle
         before = new_key(order(j))
         do while (i <= size(kept_key))
            if (kept_key(i) > new_key(order(j))) exit
            n = n + 1
            mark(n) = kept_tile(i)
            i = i + 1
         end do
         n = n + 1
         mark(n) = -order(j)
      end do
      do i = i, size(kept_key)
         n = n + 1
         mark(n) = kept_tile(i)
      end do
      mark = mark(:n)
   end subroutine merge_keys

   !> Keys in the merged order.
   pure function merged_keys(key, new_key, mark) result(merged)
      integer(int64), intent(in) :: key(:)           !! Old tiles
      integer(int64), intent(in) :: new_key(:)       !! New tiles
      integer, intent(in) :: mark(:)                 !! (tile) > 0 old tile, < 0 index in new_key
      integer(int64) :: merged(size(mark))
      integer :: tile

      do tile = 1, size(mark)
         if (mark(tile) > 0) then
            merged(tile) = key(mark(tile))
         else
            merged(tile) = new_key(-mark(tile))
         end if
      end do
   end function merged_keys

   !> Ghost tiles that did not become tiles of this rank.
   pure function ghost_without(ghost, key) result(rest)
      integer(int64), intent(in) :: ghost(:)         !! Keys of ghost tiles
      integer(int64), intent(in) :: key(:)           !! Keys of new tiles
      integer(int64), allocatable :: rest(:)
      integer :: tile
      logical :: keep(size(ghost))

      do tile = 1, size(ghost)
         keep(tile) = .not. any(key == ghost(tile))
      end do
      rest = pack(ghost, keep)
   end function ghost_without

   !> Group the rows of newcomers by tile.
   pure subroutine group_by_tile(tiles, come)
      type(tiles_t), intent(in) :: tiles
      type(newcomers_t), intent(inout) :: come
      integer, allocatable :: tile(:), cursor(:)
      integer :: row

      allocate (tile(size(come%key)), come%row(size(come%key)), come%before(tiles%own + 1))
      come%before = 0
      do row = 1, size(come%key)
         tile(row) = tiles%table%find(come%key(row))
         come%before(tile(row) + 1) = come%before(tile(row) + 1) + 1
      end do
      do row = 1, tiles%own
         come%before(row + 1) = come%before(row + 1) + come%before(row)
      end do
      cursor = come%before
      do row = 1, size(come%key)
         cursor(tile(row)) = cursor(tile(row)) + 1
         come%row(cursor(tile(row))) = row
      end do
   end subroutine group_by_tile

   !> Sort the particles of all tiles of a store.
   subroutine sort_tiles(store, come)
      type(store_t), intent(inout) :: store
      type(newcomers_t), target, intent(in) :: come
      type(tile_sorter_t) :: sorter
      integer, allocatable :: new_count(:), now(:)
      integer :: tile

      allocate (new_count(size(store%count)), now(size(store%count)))
      do tile = 1, size(new_count)
         new_count(tile) = store%count(tile) - store%leaving(tile) + come%before(tile + 1) &
            - come%before(tile)
      end do
      if (.not. store%fits(new_count)) then
         call sort_store(store, new_count, come%rows, come%before, come%row, come%cell)
         return
      end if
      call store%reserve(new_count, now)
      !$omp parallel default(none) shared(store, come, new_count, now) private(tile, sorter)
      sorter%rows => come%rows
      !$omp do schedule(dynamic, 4)
      do tile = 1, size(new_count)
         if (.not. store%unsorted(tile) .and. come%before(tile + 1) == come%before(tile) .and. &
            store%first(tile) == now(tile)) cycle
         call sort_tile(store, sorter, tile, now(tile), &
            come%row(come%before(tile) + 1:come%before(tile + 1)), come%cell)
      end do
      !$omp end do
      !$omp end parallel
   end subroutine sort_tiles
end module particle_migrate
