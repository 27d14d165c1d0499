! SPDX-License-Identifier: BSD-3-Clause
!> Patches of tiles of which only what is not zero is kept.
!!
!! The particles of a tile that holds few of them touch a small box of its nodes, and in one or two
!! dimensions the components along missing directions are zero. The pieces of all tiles, each a box
!! of nodes with the rows that can be other than zero, lie one after another. Sums of pieces are
!! those of whole patches to the last bit, because a sum that begins with zero is the same without
!! further zeros.
module mesh_pieces
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: clear_patch, extent_of
   use mesh_tiles, only: neighbors, tiles_t
   implicit none
   private

   public :: boxes_t, move_pieces, pieces_t

   !> Boxes of nodes of tiles, and where their pieces lie.
   type :: boxes_t
      integer, allocatable :: box(:, :, :)           !! (3, lowest or highest node, tile)
      integer, allocatable :: before(:)              !! (tile + 1) Nodes of the tiles before
   contains
      procedure :: ensure => boxes_ensure            !! Make room for tiles
      procedure :: line_up => boxes_line_up          !! Find where the pieces lie
      procedure :: nodes => boxes_nodes              !! Nodes of all tiles
      procedure :: move_to => boxes_move_to          !! Hand over to another holder
   end type boxes_t

   !> Pieces of the patches of tiles.
   type :: pieces_t
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
   end type pieces_t

contains

   !> Make room for the boxes of tiles; those that are there stay.
   pure subroutine boxes_ensure(self, tiles)
      class(boxes_t), intent(inout) :: self          !! The boxes
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
      class(boxes_t), intent(inout) :: self          !! The boxes
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
      class(boxes_t), intent(inout) :: self          !! Empty afterwards
      type(boxes_t), intent(inout) :: other          !! Gets it

      call move_alloc(self%box, other%box)
      call move_alloc(self%before, other%before)
   end subroutine boxes_move_to

   !> Nodes of the boxes of all tiles.
   pure integer function boxes_nodes(self) result(nodes)
      class(boxes_t), intent(in) :: self             !! The boxes

      nodes = self%before(size(self%before))
   end function boxes_nodes

   !> Choose the rows that are kept.
   pure subroutine pieces_keep(self, rows, kept)
      class(pieces_t), intent(inout) :: self         !! The pieces
      integer, intent(in) :: rows                    !! Rows of a whole patch
      logical, intent(in) :: kept(:)                 !! (row) Which can be other than zero
      integer :: row

      self%rows = rows
      self%row = pack([(row, row=1, rows)], kept)
   end subroutine pieces_keep

   !> Make room for nodes. What was there is lost.
   pure subroutine pieces_ensure(self, nodes)
      class(pieces_t), intent(inout) :: self         !! The pieces
      integer, intent(in) :: nodes                   !! Nodes of all tiles
      integer :: needed

      needed = size(self%row)*nodes
      if (allocated(self%values)) then
         if (size(self%values) >= needed .and. size(self%values) <= 2*needed + 1000) return
         deallocate (self%values)
      end if
      allocate (self%values(needed + needed/128))
   end subroutine pieces_ensure

   !> Make room for nodes of further tiles. What is there stays.
   pure subroutine pieces_grow(self, nodes)
      class(pieces_t), intent(inout) :: self         !! The pieces
      integer, intent(in) :: nodes                   !! Nodes of all tiles
      real(wp), allocatable :: values(:)
      integer :: needed

      needed = size(self%row)*nodes
      if (size(self%values) >= needed) return
      allocate (values(needed + needed/128))
      values(:size(self%values)) = self%values
      call move_alloc(values, self%values)
   end subroutine pieces_grow

   !> Hand all over to another holder, without a copy.
   pure subroutine pieces_move_to(self, other)
      class(pieces_t), intent(inout) :: self         !! Empty afterwards
      type(pieces_t), intent(inout) :: other         !! Gets it

      other%rows = self%rows
      call move_alloc(self%row, other%row)
      call move_alloc(self%values, other%values)
   end subroutine pieces_move_to

   !> Numbers that there is room for.
   elemental integer function pieces_length(self) result(numbers)
      class(pieces_t), intent(in) :: self            !! The pieces

      numbers = 0
      if (allocated(self%values)) numbers = size(self%values)
   end function pieces_length

   !> Hand over memory, whatever it holds, to pieces that are needed only afterwards.
   pure subroutine move_pieces(from, to)
      type(pieces_t), intent(inout) :: from          !! No longer needed
      type(pieces_t), intent(inout) :: to            !! Must be given room before use

      if (allocated(from%values)) call move_alloc(from%values, to%values)
   end subroutine move_pieces

   !> Keep what is in the box of a tile.
   pure subroutine pieces_put(self, grid, boxes, tile, first, patch)
      class(pieces_t), intent(inout) :: self         !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(boxes_t), intent(in) :: boxes             !! Boxes of the tiles
      integer, intent(in) :: tile                    !! Which tile
      integer, intent(in) :: first                   !! Row of the patch with which these begin
      real(wp), contiguous, intent(in) :: patch(:, :) !! (row, node) Whole
      integer :: y, z, node, at, nodes, low(3), high(3), margin(3)

      margin = merge(grid%margin, 0, grid%active)
      low = boxes%box(:, 1, tile)
      high = boxes%box(:, 2, tile)
      nodes = high(1) - low(1) + 1
      at = boxes%before(tile)*size(self%row)
      do z = low(3), high(3)
         do y = low(2), high(2)
            node = (low(1) + margin(1))*grid%stride(1) + (y + margin(2))*grid%stride(2) &
               + (z + margin(3))*grid%stride(3)
            if (size(self%row) < self%rows) then
               call copy_some(self%row, first - 1, nodes, patch(:, node + 1:node + nodes), &
                  self%values(at + 1:at + nodes*size(self%row)))
            else
               call copy_line(self%rows, first - 1, size(patch, 1), nodes, &
                  patch(:, node + 1:node + nodes), self%values(at + 1:at + nodes*self%rows))
            end if
            at = at + nodes*size(self%row)
         end do
      end do
   end subroutine pieces_put

   !> Some rows of the nodes of a line.
   pure subroutine copy_some(row, before, nodes, patch, values)
      integer, contiguous, intent(in) :: row(:)      !! Which
      integer, intent(in) :: before                  !! Rows of the patch before them
      integer, intent(in) :: nodes                   !! Nodes of the line
      real(wp), contiguous, intent(in) :: patch(:, :) !! (row, node)
      real(wp), intent(inout) :: values(size(row), nodes) !! (row kept, node)
      integer :: node, k

      do node = 1, nodes
         do k = 1, size(row)
            values(k, node) = patch(before + row(k), node)
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
      class(pieces_t), intent(in) :: self            !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(boxes_t), intent(in) :: boxes             !! Boxes of the tiles
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      integer :: x, y, z, node, at, k, margin(3)

      call clear_patch(patch)
      margin = merge(grid%margin, 0, grid%active)
      at = boxes%before(tile)*size(self%row)
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
   !! places of the tiles.
   pure subroutine pieces_assemble(self, grid, tiles, boxes, tile, total)
      class(pieces_t), intent(in) :: self            !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      type(boxes_t), intent(in) :: boxes             !! Their boxes
      integer, intent(in) :: tile                    !! Whose nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all rows

      call clear_patch(total)
      call sum_places(self, grid, tiles, boxes, tile, total)
   end subroutine pieces_assemble

   !> Add the pieces of the tiles around.
   pure subroutine sum_places(self, grid, tiles, boxes, tile, total)
      class(pieces_t), intent(in) :: self            !! The pieces
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      type(boxes_t), intent(in) :: boxes             !! Their boxes
      integer, intent(in) :: tile                    !! Whose nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all rows
      integer :: place, other, shift(3), extent(3), theirs(3), origin(3), margin(3), low(3), &
         high(3), first(3), last(3), rows

      margin = merge(grid%margin, 0, grid%active)
      extent = extent_of(grid, tiles, tile)
      rows = size(self%row)
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other == 0) cycle
         shift(1) = mod(place - 1, 3) - 1
         shift(2) = mod((place - 1)/3, 3) - 1
         shift(3) = (place - 1)/9 - 1
         theirs = extent_of(grid, tiles, other)
         ! lower corner of the other tile seen from this one, and what its piece and this one share
         origin = merge(extent, merge(-theirs, 0, shift == -1), shift == 1)
         first = origin + boxes%box(:, 1, other)
         last = origin + boxes%box(:, 2, other)
         low = max(-margin, first)
         high = min(extent + margin, last)
         if (any(high < low)) cycle
         last = last - first + 1
         associate (piece => self%values(boxes%before(other)*rows + 1:boxes%before(other + 1)*rows))
            if (rows == size(total, 1)) then
               call add_piece(rows, low, high, margin, grid%stride, first, last, piece, &
                  size(total), total)
            else
               call add_rows(self%row, low, high, margin, grid%stride, first, last, piece, total)
            end if
         end associate
      end do
   end subroutine sum_places

   !> Add a box of nodes of a piece to sums. A line along x is one piece of memory in both.
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
      integer :: n, y, z, here, there, line

      line = rows*(high(1) - low(1) + 1)
      do z = low(3), high(3)
         do y = low(2), high(2)
            here = rows*dot_product([low(1), y, z] + margin, stride)
            there = rows*(low(1) - corner(1) + length(1)*(y - corner(2) &
               + length(2)*(z - corner(3))))
            do n = 1, line
               sums(here + n) = sums(here + n) + piece(there + n)
            end do
         end do
      end do
   end subroutine add_piece

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
end module mesh_pieces
