! SPDX-License-Identifier: BSD-3-Clause
!> Moves particles that left their tiles to their new tiles and ranks.
module particle_migrate
   use base_communicator, only: communicator_t
   use base_kinds, only: int64
   use base_sort, only: sort_order
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use mesh_links, only: links_t
   use mesh_tiles, only: tiles_t
   use particle_inflow, only: fed_t
   use particle_leavers, only: leavers_t, newcomers_t
   use particle_sort_store, only: sort_store
   use particle_sort_tile, only: sort_tile, tile_sorter_t
   use particle_store, only: store_t
   implicit none
   private

   public :: migrate

contains

   !> Move every particle that left its tile to its new one, create tiles in empty space, remove
   !! empty tiles, and sort the particles of each tile. Particles that left the domain are removed;
   !! the balance must have recorded them before. Collective, unless the particles that left have
   !! arrived already and none enter.
   subroutine migrate(communicator, grid, boundary, tiles, stores, links, leavers, fed)
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(tiles_t), intent(inout) :: tiles          !! The tiles of this rank
      type(store_t), intent(inout) :: stores(:)
      type(links_t), intent(inout) :: links          !! Ranks that expect messages of each other
      type(leavers_t), intent(inout) :: leavers      !! Those on the way, if they were sent before
      type(fed_t), intent(in), optional :: fed(:)    !! Particles that enter, for any tiles
      logical :: hold
      integer :: index

      hold = .true.
      if (leavers%sent) hold = .not. leavers%renew
      if (.not. leavers%sent .or. leavers%further) then
         call leavers%send(communicator, grid, boundary, tiles, stores, links, fed)
         call leavers%receive(communicator, stores)
         hold = hold .and. .not. leavers%renew
      end if
      call links%trust(hold)
      call update_tiles(grid, tiles, stores, leavers%newcomers)
      do index = 1, size(stores)
         call group_by_tile(tiles, leavers%newcomers(index))
         call sort_tiles(stores(index), leavers%newcomers(index))
      end do
      deallocate (leavers%newcomers)
      leavers%sent = .false.
   end subroutine migrate

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
