! SPDX-License-Identifier: BSD-3-Clause
!> Patches of tiles of which only what is not zero is kept.
!!
!! The particles of a sparse tile touch a small box of its nodes, and in one or two dimensions the
!! components along missing directions are zero. The pieces of all tiles, each a box of nodes with
!! the rows that can be other than zero, lie one after another. Sums of pieces are those of whole
!! patches to the last bit, because further zeros change no sum that begins with zero.
module mesh_packed_patch
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: clear_patch, extent_of
   use mesh_tiles, only: neighbors, tiles_t
   implicit none
   private

   public :: node_boxes_t, move_packed_patches, packed_patch_t

   !> Boxes of nodes of tiles, and where their pieces lie.
   type :: node_boxes_t
      integer, allocatable :: box(:, :, :)           !! (3, lowest or highest node, tile)
      integer, allocatable :: before(:)              !! (tile + 1) Nodes of the tiles before
   contains
      procedure :: ensure => boxes_ensure            !! Make room for tiles
      procedure :: line_up => boxes_line_up          !! Find where the pieces lie
      procedure :: nodes => boxes_nodes              !! Nodes of all tiles
      procedure :: move_to => boxes_move_to          !! Hand over to another holder
   end type node_boxes_t

   !> Pieces of the patches of tiles.
   type :: packed_patch_t
      integer :: rows = 0                            !! Rows of a whole patch
      integer, allocatable :: row(:)                 !! Those that are kept
      real(wp), allocatable :: values(:)             !! Node by node, tile by tile
   contains
      procedure :: keep => pieces_keep               !! Choose the rows
      procedure :: ensure => pieces_ensure           !! Make room for nodes
      procedure :: grow => pieces_grow               !! Make room for more nodes
      procedure :: move_to => pieces_move_to         !! Hand over to another holder
      procedure :: put => pieces_put                 !! Keep what is in a patch
      procedure :: get => pieces_get                 !! Make a whole patch of it
      procedure :: assemble => pieces_assemble       !! Sum of all tiles around the nodes of one
      procedure :: length => pieces_length           !! Numbers that there is room for
   end type packed_patch_t

contains

   !> Make room for the boxes of tiles; those that are there stay.
   pure subroutine boxes_ensure(self, tiles)
      class(node_boxes_t), intent(inout) :: self          !! The boxes
      integer, intent(in) :: tiles                   !! Number of tiles
      integer, allocatable :: box(:, :, :)
      integer :: kept

      if (allocated(self%box)) then
         if (size(self%box, 3) == tiles) return
      end if
      allocate (box(3, 2, tiles))
      if (allocated(self%box)) then
         kept = min(tiles, size(self%box, 3))
         box(:, :, :kept) = self%box(:, :, :kept)
         deallocate (self%before)
      end if
      call move_alloc(box, self%box)
      allocate (self%before(tiles + 1))
   end subroutine boxes_ensure

   !> Find where the pieces of tiles lie. What boxes hold beyond the ends of thin tiles is cut.
   pure subroutine boxes_line_up(self, grid, tiles)
      class(node_boxes_t), intent(inout) :: self          !! The boxes
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles, perhaps more than have boxes
      integer :: tile

      self%before(1) = 0
      do tile = 1, size(self%box, 3)
         self%box(:, 2, tile) = min(self%box(:, 2, tile), extent_of(grid, tiles, tile) &
            + merge(grid%margin, 0, grid%active))
         self%before(tile + 1) = self%before(tile) &
            + product(max(self%box(:, 2, tile) - self%box(:, 1, tile) + 1, 0))
      end do
   end subroutine boxes_line_up

   !> Hand all over to another holder, without a copy.
   pure subroutine boxes_move_to(self, other)
      class(node_boxes_t), intent(inout) :: self          !! Empty afterwards
      type(node_boxes_t), intent(inout) :: other          !! Gets it

      call move_alloc(self%box, other%box)
      call move_alloc(self%before, other%before)
   end subroutine boxes_move_to

   !> Nodes of the boxes of all tiles.
   pure integer function boxes_nodes(self) result(nodes)
      class(node_boxes_t), intent(in) :: self             !! The boxes

      nodes = self%before(size(self%before))
   end function boxes_nodes

   !> Choose the rows that are kept.
   pure subroutine pieces_keep(self, rows, kept)
      class(packed_patch_t), intent(inout) :: self         !! The pieces
      integer, intent(in) :: rows                    !! Rows of a whole patch
      logical, intent(in) :: kept(:)                 !! (row) Which can be other than zero
      integer :: row

      self%rows = rows
      self%row = pack([(row, row=1, rows)], kept)
   end subroutine pieces_keep

   !> Make room for nodes. What was there is lost.
   pure subroutine pieces_ensure(self, nodes)
      class(packed_patch_t), intent(inout) :: self         !! The pieces
      integer, intent(in) :: nodes                   !! Nodes of all tiles
      integer(int64) :: needed

      needed = size(self%row, kind=int64)*nodes
      if (allocated(self%values)) then
         if (self%length() >= needed .and. self%length() <= 2*needed + 1000) return
         deallocate (self%values)
      end if
      allocate (self%values(needed + needed/128))
   end subroutine pieces_ensure

   !> Make room for nodes of further tiles. What is there stays.
   pure subroutine pieces_grow(self, nodes)
      class(packed_patch_t), intent(inout) :: self         !! The pieces
      integer, intent(in) :: nodes                   !! Nodes of all tiles
      real(wp), allocatable :: values(:)
      integer(int64) :: needed

      needed = size(self%row, kind=int64)*nodes
      if (self%length() >= needed) return
      allocate (values(needed + needed/128))
      values(:self%length()) = self%values
      call move_alloc(values, self%values)
   end subroutine pieces_grow

   !> Hand all over to another holder, without a copy.
   pure subroutine pieces_move_to(self, other)
      class(packed_patch_t), intent(inout) :: self         !! Empty afterwards
      type(packed_patch_t), intent(inout) :: other         !! Gets it

      other%rows = self%rows
      call move_alloc(self%row, other%row)
      call move_alloc(self%values, other%values)
   end subroutine pieces_move_to

   !> Numbers that there is room for.
   elemental integer(int64) function pieces_length(self) result(numbers)
      class(packed_patch_t), intent(in) :: self            !! The pieces

      numbers = 0
      if (allocated(self%values)) numbers = size(self%values, kind=int64)
   end function pieces_length

   !> Hand over memory, whatever it holds, to pieces that are needed only afterwards.
   pure subroutine move_packed_patches(from, to)
      type(packed_patch_t), intent(inout) :: from          !! No longer needed
      type(packed_patch_t), intent(inout) :: to            !! Must be given room before use

      if (allocated(from%values)) call move_alloc(from%values, to%values)
   end subroutine move_packed_patches

   !> Keep what is in the box of a tile. A box that is the whole tile is one line.
   pure subroutine pieces_put(self, grid, boxes, tile, first, patch)
      class(packed_patch_t), intent(inout) :: self         !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(node_boxes_t), intent(in) :: boxes             !! Boxes of the tiles
      integer, intent(in) :: tile                    !! Which tile
      integer, intent(in) :: first                   !! Row of the patch with which these begin
      real(wp), contiguous, intent(in) :: patch(:, :) !! (row, node) Whole
      integer :: y, z, node, at, nodes, low(3), high(3), margin(3)

      at = boxes%before(tile)
      if (boxes%before(tile + 1) - at == size(patch, 2)) then
         call put_line(self, first - 1, at, 0, size(patch, 2), patch)
         return
      end if
      margin = merge(grid%margin, 0, grid%active)
      low = boxes%box(:, 1, tile)
      high = boxes%box(:, 2, tile)
      nodes = high(1) - low(1) + 1
      do z = low(3), high(3)
         do y = low(2), high(2)
            node = dot_product([low(1), y, z] + margin, grid%stride)
            call put_line(self, first - 1, at, node, nodes, patch)
            at = at + nodes
         end do
      end do
   end subroutine pieces_put

   !> Keep the rows of the nodes of a line.
   pure subroutine put_line(self, before, at, node, nodes, patch)
      class(packed_patch_t), intent(inout) :: self         !! The pieces
      integer, intent(in) :: before                  !! Rows of the patch before those of the pieces
      integer, intent(in) :: at                      !! Nodes of the pieces before the line
      integer, intent(in) :: node                    !! Nodes of the patch before the line
      integer, intent(in) :: nodes                   !! Nodes of the line
      real(wp), contiguous, intent(in) :: patch(:, :) !! (row, node) Whole
      integer(int64) :: begin
      integer :: kept

      kept = size(self%row)
      begin = int(at, int64)*kept
      if (kept == self%rows) then
         call copy_line(kept, before, size(patch, 1), nodes, patch(:, node + 1:node + nodes), &
            self%values(begin + 1:begin + nodes*kept))
      else
         select case (kept)
         case (2)
            call copy_some(2, self%row, before, node, nodes, patch, self%values(begin + 1))
         case (4)
            call copy_some(4, self%row, before, node, nodes, patch, self%values(begin + 1))
         case (6)
            call copy_some(6, self%row, before, node, nodes, patch, self%values(begin + 1))
         case default
            call copy_some(kept, self%row, before, node, nodes, patch, self%values(begin + 1))
         end select
      end if
   end subroutine put_line

   !> Some rows of the nodes of a line. A number that the compiler knows leaves no loop over them.
   pure subroutine copy_some(kept, row, before, first, nodes, patch, values)
      integer, intent(in) :: kept                    !! How many rows
      integer, intent(in) :: row(kept)               !! Which
      integer, intent(in) :: before                  !! Rows of the patch before them
      integer, intent(in) :: first                   !! Nodes of the patch before the line
      integer, intent(in) :: nodes                   !! Nodes of the line
      real(wp), contiguous, intent(in) :: patch(:, :) !! (row, node) Whole
      real(wp), intent(inout) :: values(kept, nodes) !! (row kept, node)
      integer :: node, k

      do node = 1, nodes
         do k = 1, kept
            values(k, node) = patch(before + row(k), first + node)
         end do
      end do
   end subroutine copy_some

   !> All rows of the nodes of a line. Numbers that the compiler knows make them one vector.
   pure subroutine copy_line(rows, before, all_rows, nodes, patch, values)
      integer, intent(in) :: rows                    !! How many
      integer, intent(in) :: before                  !! Rows of the patch before them
      integer, intent(in) :: all_rows                !! Rows of the patch
      integer, intent(in) :: nodes                   !! Nodes of the line
      real(wp), intent(in) :: patch(all_rows*nodes)  !! (row, node) Flat
      real(wp), intent(inout) :: values(rows*nodes)  !! (row, node) Flat
      integer :: node

      if (rows == all_rows) then
         values = patch
         return
      end if
      select case (rows)
      case (8)
         do node = 0, nodes - 1
            values(8*node + 1:8*node + 8) = patch(all_rows*node + before + 1:all_rows*node &
               + before + 8)
         end do
      case (9)
         do node = 0, nodes - 1
            values(9*node + 1:9*node + 9) = patch(all_rows*node + before + 1:all_rows*node &
               + before + 9)
         end do
      case default
         do node = 0, nodes - 1
            values(rows*node + 1:rows*node + rows) = patch(all_rows*node + before + 1: &
               all_rows*node + before + rows)
         end do
      end select
   end subroutine copy_line

   !> Make a whole patch of what is kept of a tile.
   pure subroutine pieces_get(self, grid, boxes, tile, patch)
      class(packed_patch_t), intent(in) :: self            !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(node_boxes_t), intent(in) :: boxes             !! Boxes of the tiles
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      integer(int64) :: at
      integer :: x, y, z, node, k, margin(3)

      call clear_patch(patch)
      margin = merge(grid%margin, 0, grid%active)
      at = size(self%row, kind=int64)*boxes%before(tile)
      associate (low => boxes%box(:, 1, tile), high => boxes%box(:, 2, tile))
         do z = low(3), high(3)
            do y = low(2), high(2)
               node = 1 + dot_product([low(1), y, z] + margin, grid%stride)
               do x = low(1), high(1)
                  do k = 1, size(self%row)
                     patch(self%row(k), node) = self%values(at + k)
                  end do
                  at = at + size(self%row)
                  node = node + 1
               end do
            end do
         end do
      end associate
   end subroutine pieces_get

   !> Sum the pieces that touch the nodes of one tile, its margin included, in the order of the
   !! places of the tiles. Where some rows are missing and most nodes are touched, sums of the kept
   !! rows are found first, because lines of them are added as vectors.
   pure subroutine pieces_assemble(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self            !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      type(node_boxes_t), intent(in) :: boxes             !! Their boxes
      integer, intent(in) :: tile                    !! Whose nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all rows

      call clear_patch(total)
      if (size(self%row) < size(total, 1) .and. &
         2*(boxes%before(tile + 1) - boxes%before(tile)) > size(total, 2)) then
         call assemble_kept(self, grid, tiles, boxes, tile, total)
      else
         call sum_places(self, grid, tiles, boxes, tile, total)
      end if
   end subroutine pieces_assemble

   !> Sum the rows that are kept and bring them to their places.
   pure subroutine assemble_kept(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self            !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      type(node_boxes_t), intent(in) :: boxes             !! Their boxes
      integer, intent(in) :: tile                    !! Whose nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Zero in rows not kept
      real(wp) :: sums(size(self%row), size(total, 2))

      call clear_patch(sums)
      call sum_places(self, grid, tiles, boxes, tile, sums)
      select case (size(self%row))
      case (2)
         call spread_some(2, self%row, size(total, 1), size(total, 2), sums, total)
      case (4)
         call spread_some(4, self%row, size(total, 1), size(total, 2), sums, total)
      case (6)
         call spread_some(6, self%row, size(total, 1), size(total, 2), sums, total)
      case default
         call spread_some(size(self%row), self%row, size(total, 1), size(total, 2), sums, total)
      end select
   end subroutine assemble_kept

   !> Bring rows that are kept to their places, without a loop over them as above.
   pure subroutine spread_some(kept, row, all_rows, nodes, sums, total)
      integer, intent(in) :: kept                    !! How many rows
      integer, intent(in) :: row(kept)               !! Which
      integer, intent(in) :: all_rows                !! Rows of the whole
      integer, intent(in) :: nodes                   !! Nodes of the tile
      real(wp), intent(in) :: sums(kept, nodes)      !! (row kept, node)
      real(wp), intent(inout) :: total(all_rows, nodes) !! (row, node)
      integer :: node, k

      do node = 1, nodes
         do k = 1, kept
            total(row(k), node) = sums(k, node)
         end do
      end do
   end subroutine spread_some

   !> Add the pieces of the tiles around.
   pure subroutine sum_places(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self            !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      type(node_boxes_t), intent(in) :: boxes             !! Their boxes
      integer, intent(in) :: tile                    !! Whose nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all or kept rows
      integer :: place, other, direction, shift(3), extent(3), origin(3, -1:1), margin(3), low(3), &
         high(3), first(3), last(3), rows
      logical :: apart

      margin = merge(grid%margin, 0, grid%active)
      extent = extent_of(grid, tiles, tile)
      ! lower corners of the tiles around seen from this one; before the first tile lies the last
      origin(:, -1) = -merge(merge(grid%cells - (grid%tiles - 1)*grid%width, grid%width, &
         tiles%coordinate(:, tile) == 0), 0, grid%active)
      origin(:, 0) = 0
      origin(:, 1) = extent
      rows = size(self%row)
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other == 0) cycle
         shift = [mod(place - 1, 3), mod((place - 1)/3, 3), (place - 1)/9] - 1
         apart = .false.
         do direction = 1, 3
            ! the piece, and what it and this tile share
            first(direction) = origin(direction, shift(direction)) + boxes%box(direction, 1, other)
            last(direction) = origin(direction, shift(direction)) + boxes%box(direction, 2, other)
            low(direction) = max(-margin(direction), first(direction))
            high(direction) = min(extent(direction) + margin(direction), last(direction))
            apart = apart .or. high(direction) < low(direction)
            last(direction) = last(direction) - first(direction) + 1
         end do
         if (apart) cycle
         associate (piece => self%values(int(rows, int64)*boxes%before(other) + 1: &
            int(rows, int64)*boxes%before(other + 1)))
            if (rows == size(total, 1)) then
               call add_piece(rows, low, high, margin, grid%stride, first, last, piece, &
                  size(total), total)
            else
               call add_rows(self%row, low, high, margin, grid%stride, first, last, piece, total)
            end if
         end associate
      end do
   end subroutine sum_places

   !> Add a box of nodes of a piece to sums. A line along x is one piece of memory in both, and so
   !! are lines that follow one another in both.
   ! gate: long kernel because a box in a box is told by its corners and lengths
   pure subroutine add_piece(rows, low, high, margin, stride, corner, length, piece, numbers, sums)
      integer, intent(in) :: rows                    !! Numbers a node
      integer, intent(in) :: low(3), high(3)         !! Lowest and highest node that both have
      integer, intent(in) :: margin(3)               !! Layers before node 0
      integer, intent(in) :: stride(3)               !! Steps in the node index of the sums
      integer, intent(in) :: corner(3)               !! Lowest node of the piece
      integer, intent(in) :: length(3)               !! Its nodes along each direction
      real(wp), contiguous, intent(in) :: piece(:)   !! (row, node) Flat
      integer, intent(in) :: numbers                 !! Of the sums
      real(wp), intent(inout) :: sums(numbers)       !! (row, node) Flat
      integer :: y, z, here, there, line, top(2)

      line = high(1) - low(1) + 1
      top = high(2:3)
      if (line == length(1) .and. line == stride(2)) then
         line = line*(top(1) - low(2) + 1)
         top(1) = low(2)
      end if
      if (line == length(1)*length(2) .and. line == stride(3)) then
         line = line*(top(2) - low(3) + 1)
         top(2) = low(3)
      end if
      line = rows*line
      do z = low(3), top(2)
         do y = low(2), top(1)
            here = rows*((low(1) + margin(1))*stride(1) + (y + margin(2))*stride(2) &
               + (z + margin(3))*stride(3))
            there = rows*(low(1) - corner(1) + length(1)*(y - corner(2) &
               + length(2)*(z - corner(3))))
            ! lengths that the compiler knows: one node with the rows of planes and of space
            select case (line)
            case (2)
               call add_line(2, piece(there + 1:there + 2), sums(here + 1:here + 2))
            case (4)
               call add_line(4, piece(there + 1:there + 4), sums(here + 1:here + 4))
            case (6)
               call add_line(6, piece(there + 1:there + 6), sums(here + 1:here + 6))
            case (8)
               call add_line(8, piece(there + 1:there + 8), sums(here + 1:here + 8))
            case (9)
               call add_line(9, piece(there + 1:there + 9), sums(here + 1:here + 9))
            case default
               call add_line(line, piece(there + 1:there + line), sums(here + 1:here + line))
            end select
         end do
      end do
   end subroutine add_piece

   !> Add a line of numbers to sums.
   pure subroutine add_line(numbers, piece, sums)
      integer, intent(in) :: numbers                 !! How many
      real(wp), intent(in) :: piece(numbers)         !! Flat
      real(wp), intent(inout) :: sums(numbers)       !! Flat

      sums = sums + piece
   end subroutine add_line

   !> The same where only some rows are kept.
   ! gate: long kernel because a box in a box is told by its corners and lengths
   pure subroutine add_rows(row, low, high, margin, stride, corner, length, piece, total)
      integer, contiguous, intent(in) :: row(:)      !! Rows that are kept
      integer, intent(in) :: low(3), high(3)         !! Lowest and highest node that both have
      integer, intent(in) :: margin(3)               !! Layers before node 0
      integer, intent(in) :: stride(3)               !! Steps in the node index of the sums
      integer, intent(in) :: corner(3)               !! Lowest node of the piece
      integer, intent(in) :: length(3)               !! Its nodes along each direction
      real(wp), contiguous, intent(in) :: piece(:)   !! (row kept, node) Flat
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all rows
      integer :: k, y, z, node, last, there

      do z = low(3), high(3)
         do y = low(2), high(2)
            last = 1 + (high(1) + margin(1))*stride(1) + (y + margin(2))*stride(2) &
               + (z + margin(3))*stride(3)
            there = size(row)*(low(1) - corner(1) + length(1)*(y - corner(2) &
               + length(2)*(z - corner(3))))
            do node = last - (high(1) - low(1)), last
               do k = 1, size(row)
                  total(row(k), node) = total(row(k), node) + piece(there + k)
               end do
               there = there + size(row)
            end do
         end do
      end do
   end subroutine add_rows
end module mesh_packed_patch
