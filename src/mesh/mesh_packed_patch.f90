! SPDX-License-Identifier: BSD-3-Clause
!> Patches of tiles without their zeros: packed patches.
!!
!! The particles of a sparse tile touch a small box of its nodes, and in one or two dimensions the
!! components along inactive directions are zero. The packed patches of all tiles, each a box of
!! nodes with the rows that can differ from zero, follow one another in memory. Sums of packed
!! patches equal those of whole patches to the last bit, because further zeros change no sum that
!! begins with zero.
module mesh_packed_patch
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use mesh_node_boxes, only: node_boxes_t
   use mesh_packed_sums, only: add_box, add_plane
   use mesh_patch, only: clear_patch, extent_of
   use mesh_tiles, only: neighbors, shift_to, tiles_t
   implicit none
   private

   public :: move_packed_patches, packed_patch_t

   integer, parameter :: middle = (neighbors + 1)/2  !! The tile itself among its neighbours

   !> The packed patches of all tiles.
   type :: packed_patch_t
      integer :: rows = 0                            !! Rows of a whole patch
      integer, allocatable :: row(:)                 !! Kept ones
      real(wp), allocatable :: values(:)             !! Node by node, tile by tile
   contains
      procedure :: keep => packed_keep               !! Choose the rows
      procedure :: ensure => packed_ensure           !! Reserve memory for nodes
      procedure :: grow => packed_grow               !! Reserve memory for more nodes
      procedure :: put => packed_pack                 !! Pack the patch of a tile
      procedure :: get => packed_unpack                 !! Unpack the patch of a tile
      procedure :: cut => packed_cut                 !! Numbers of a box of nodes of a tile
      procedure :: assemble => packed_assemble       !! Sum the patches of a tile and its neighbours
      procedure :: length => packed_length           !! Capacity in numbers
   end type packed_patch_t

contains

   !> Choose the rows that are kept.
   pure subroutine packed_keep(self, rows, kept)
      class(packed_patch_t), intent(inout) :: self
      integer, intent(in) :: rows                    !! Rows of a whole patch
      logical, intent(in) :: kept(:)                 !! (row) Can it be nonzero?
      integer :: row

      self%rows = rows
      self%row = pack([(row, row=1, rows)], kept)
   end subroutine packed_keep

   !> Reserve memory for nodes. Previous values are lost.
   pure subroutine packed_ensure(self, nodes)
      class(packed_patch_t), intent(inout) :: self
      integer, intent(in) :: nodes                   !! Nodes of all tiles
      integer(int64) :: needed

      needed = size(self%row, kind=int64)*nodes
      if (allocated(self%values)) then
         if (self%length() >= needed .and. self%length() <= 2*needed + 1000) return
         deallocate (self%values)
      end if
      allocate (self%values(needed + needed/128))
   end subroutine packed_ensure

   !> Reserve memory for nodes of further tiles. Previous values are kept.
   pure subroutine packed_grow(self, nodes)
      class(packed_patch_t), intent(inout) :: self
      integer, intent(in) :: nodes                   !! Nodes of all tiles
      real(wp), allocatable :: values(:)
      integer(int64) :: needed

      needed = size(self%row, kind=int64)*nodes
      if (self%length() >= needed) return
      allocate (values(needed + needed/128))
      values(:self%length()) = self%values
      call move_alloc(values, self%values)
   end subroutine packed_grow

   !> Capacity in numbers.
   elemental integer(int64) function packed_length(self) result(numbers)
      class(packed_patch_t), intent(in) :: self

      numbers = 0
      if (allocated(self%values)) numbers = size(self%values, kind=int64)
   end function packed_length

   !> Reuse memory for packed patches that are needed only later.
   pure subroutine move_packed_patches(from, to)
      type(packed_patch_t), intent(inout) :: from          !! No longer needed
      type(packed_patch_t), intent(inout) :: to !! Its capacity must be ensured before use

      if (allocated(from%values)) call move_alloc(from%values, to%values)
   end subroutine move_packed_patches

   !> Pack the patch of a tile. A box that is the whole tile is one line.
   pure subroutine packed_pack(self, grid, boxes, tile, first, patch)
      class(packed_patch_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      type(node_boxes_t), intent(in) :: boxes             !! Boxes of the tiles
      integer, intent(in) :: tile
      integer, intent(in) :: first                   !! First row of the patch for this call
      real(wp), contiguous, intent(in) :: patch(:, :) !! (row, node) Whole
      integer :: y, z, node, at, nodes, low(3), high(3), margin(3)

      at = boxes%before(tile)
      if (boxes%before(tile + 1) == at) return
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
   end subroutine packed_pack

   !> Keep the rows of the nodes of a line.
   pure subroutine put_line(self, before, at, node, nodes, patch)
      class(packed_patch_t), intent(inout) :: self
      integer, intent(in) :: before !! Number of patch rows before the first packed one
      integer, intent(in) :: at                      !! Packed nodes before the line
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
            call copy_rows(2, self%row, before, node, nodes, patch, self%values(begin + 1))
         case (4)
            call copy_rows(4, self%row, before, node, nodes, patch, self%values(begin + 1))
         case (6)
            call copy_rows(6, self%row, before, node, nodes, patch, self%values(begin + 1))
         case default
            call copy_rows(kept, self%row, before, node, nodes, patch, self%values(begin + 1))
         end select
      end if
   end subroutine put_line

   !> Some rows of the nodes of a line. With a compile-time constant number there is no loop over
   !! them.
   pure subroutine copy_rows(kept, row, before, first, nodes, patch, values)
      integer, intent(in) :: kept                    !! How many rows
      integer, intent(in) :: row(kept)               !! Rows that are kept
      integer, intent(in) :: before                  !! Index offset in the patch
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
   end subroutine copy_rows

   !> All rows of the nodes of a line. Compile-time constants make them one vector.
   pure subroutine copy_line(rows, before, all_rows, nodes, patch, values)
      integer, intent(in) :: rows                    !! Number of rows
      integer, intent(in) :: before                  !! Index offset in the patch
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

   !> Numbers of the kept rows in a box of nodes of a tile; zero where it has no packed nodes.
   pure subroutine packed_cut(self, boxes, tile, box, values)
      class(packed_patch_t), intent(in) :: self
      type(node_boxes_t), intent(in) :: boxes        !! Boxes of the tiles
      integer, intent(in) :: tile
      integer, intent(in) :: box(3, 2)               !! Lowest and highest node, from 0
      real(wp), intent(out) :: values(:)             !! (row kept, node) Flat
      integer :: low(3), high(3), y, z, here, number
      integer(int64) :: there

      values = 0.0_wp
      if (boxes%before(tile + 1) == boxes%before(tile)) return
      associate (have => boxes%box(:, :, tile), kept => size(self%row))
         low = max(box(:, 1), have(:, 1))
         high = min(box(:, 2), have(:, 2))
         number = kept*(high(1) - low(1) + 1)
         if (number <= 0) return
         do z = low(3), high(3)
            do y = low(2), high(2)
               here = kept*nodes_before(box, [low(1), y, z])
               there = int(kept, int64)*(boxes%before(tile) + nodes_before(have, [low(1), y, z]))
               values(here + 1:here + number) = self%values(there + 1:there + number)
            end do
         end do
      end associate
   end subroutine packed_cut

   !> Nodes of a box before one of them.
   pure integer function nodes_before(box, node) result(number)
      integer, intent(in) :: box(3, 2)               !! Lowest and highest node
      integer, intent(in) :: node(3)                 !! One of its nodes

      number = node(1) - box(1, 1) + (box(1, 2) - box(1, 1) + 1)*(node(2) - box(2, 1) &
         + (box(2, 2) - box(2, 1) + 1)*(node(3) - box(3, 1)))
   end function nodes_before

   !> Unpack the patch of a tile.
   pure subroutine packed_unpack(self, grid, boxes, tile, patch)
      class(packed_patch_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(node_boxes_t), intent(in) :: boxes             !! Boxes of the tiles
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      integer(int64) :: at
      integer :: y, z, node, nodes, margin(3)

      ! rows that are not kept are zero too
      if (boxes%before(tile + 1) - boxes%before(tile) < size(patch, 2) .or. &
         size(self%row) < size(patch, 1)) call clear_patch(patch)
      margin = merge(grid%margin, 0, grid%active)
      at = size(self%row, kind=int64)*boxes%before(tile)
      associate (low => boxes%box(:, 1, tile), high => boxes%box(:, 2, tile), &
         rows => size(self%row))
         nodes = high(1) - low(1) + 1
         do z = low(3), high(3)
            do y = low(2), high(2)
               node = dot_product([low(1), y, z] + margin, grid%stride)
               if (rows == size(patch, 1)) then
                  call copy_numbers(rows*nodes, self%values(at + 1:at + rows*nodes), rows*node, &
                     size(patch), patch)
                  at = at + rows*nodes
               else
                  call unpack_line(self, node, nodes, at, patch)
               end if
            end do
         end do
      end associate
   end subroutine packed_unpack

   !> Copy contiguous numbers.
   pure subroutine copy_numbers(number, values, before, numbers, patch)
      integer, intent(in) :: number                  !! Number
      real(wp), intent(in) :: values(number)         !! Flattened
      integer, intent(in) :: before                  !! Index offset in the patch
      integer, intent(in) :: numbers                 !! Number of elements of the patch
      real(wp), intent(inout) :: patch(numbers)      !! Flattened

      patch(before + 1:before + number) = values
   end subroutine copy_numbers

   !> Unpack a line of nodes.
   pure subroutine unpack_line(self, first, nodes, at, patch)
      class(packed_patch_t), intent(in) :: self
      integer, intent(in) :: first                   !! Nodes of the patch before the line
      integer, intent(in) :: nodes                   !! Nodes of the line
      integer(int64), intent(inout) :: at            !! Packed numbers before the line, and after it
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      integer :: node, k

      do node = first + 1, first + nodes
         do k = 1, size(self%row)
            patch(self%row(k), node) = self%values(at + k)
         end do
         at = at + size(self%row)
      end do
   end subroutine unpack_line

   !> Sum the packed patches that touch the nodes of one tile, its margin included, in the order of
   !! the neighbours. Where some rows are missing and most nodes are touched, sums of the kept rows
   !! are found first, because lines of them are added as vectors; so they are in three dimensions,
   !! where no field of a step lacks rows.
   pure subroutine packed_assemble(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes             !! Bounding boxes
      integer, intent(in) :: tile                    !! Tile of the nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all rows

      call clear_patch(total)
      if (size(self%row) < size(total, 1) .and. (grid%dimensions == 3 .or. &
         2*(boxes%before(tile + 1) - boxes%before(tile)) > size(total, 2))) then
         call assemble_kept(self, grid, tiles, boxes, tile, total)
      else
         call sum_neighbours(self, grid, tiles, boxes, tile, total)
      end if
   end subroutine packed_assemble

   !> Sum the rows that are kept, then copy them to the rows of the whole patch.
   pure subroutine assemble_kept(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes             !! Bounding boxes
      integer, intent(in) :: tile                    !! Tile of the nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Zero in rows not kept
      real(wp) :: sums(size(self%row), size(total, 2))

      call clear_patch(sums)
      call sum_neighbours(self, grid, tiles, boxes, tile, sums)
      select case (size(self%row))
      case (2)
         call scatter_rows(2, self%row, size(total, 1), size(total, 2), sums, total)
      case (4)
         call scatter_rows(4, self%row, size(total, 1), size(total, 2), sums, total)
      case (6)
         call scatter_rows(6, self%row, size(total, 1), size(total, 2), sums, total)
      case default
         call scatter_rows(size(self%row), self%row, size(total, 1), size(total, 2), sums, total)
      end select
   end subroutine assemble_kept

   !> Copy rows that are kept to the rows of the whole patch, without a loop over them as above.
   pure subroutine scatter_rows(kept, row, all_rows, nodes, sums, total)
      integer, intent(in) :: kept                    !! How many rows
      integer, intent(in) :: row(kept)               !! Rows that are kept
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
   end subroutine scatter_rows

   !> Add the packed patches of the tile and its neighbours.
   pure subroutine sum_neighbours(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes             !! Bounding boxes
      integer, intent(in) :: tile                    !! Tile of the nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all or kept rows

      if (grid%dimensions == 3) then
         call sum_space(self, grid, tiles, boxes, tile, total)
      else
         call sum_plane(self, grid, tiles, boxes, tile, total)
      end if
   end subroutine sum_neighbours

   !> The same in scenes of one or two dimensions, along x and z. Where tiles are sparse, finding
   !! the overlap of two boxes costs more than adding it, so this is done with scalars.
   pure subroutine sum_plane(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes             !! Bounding boxes
      integer, intent(in) :: tile                    !! Tile of the nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all or kept rows
      integer :: margin(3), extent(3), x(-1:1), z(-1:1), i, k, other, rows
      integer :: low_x, high_x, low_z, high_z, from, here, there

      margin = merge(grid%margin, 0, grid%active)
      extent = extent_of(grid, tiles, tile)
      x = lower_corners(grid, tiles, 1, tile, extent(1))
      z = lower_corners(grid, tiles, 3, tile, extent(3))
      rows = size(self%row)
      do k = -1, 1
         do i = -1, 1
            other = tiles%neighbor(middle + i + 9*k, tile)
            if (other == 0) cycle
            from = x(i) + boxes%box(1, 1, other)
            low_x = max(-margin(1), from)
            high_x = min(extent(1) + margin(1), x(i) + boxes%box(1, 2, other))
            if (high_x < low_x) cycle
            low_z = max(-margin(3), z(k) + boxes%box(3, 1, other))
            high_z = min(extent(3) + margin(3), z(k) + boxes%box(3, 2, other))
            if (high_z < low_z) cycle
            here = low_x + margin(1) + (low_z + margin(3))*grid%stride(3)
            there = boxes%before(other) + low_x - from &
               + (low_z - z(k) - boxes%box(3, 1, other)) &
               *(boxes%box(1, 2, other) - boxes%box(1, 1, other) + 1)
            call add_plane(self%row, high_x - low_x + 1, high_z - low_z + 1, here, &
               grid%stride(3), int(rows, int64)*there, &
               boxes%box(1, 2, other) - boxes%box(1, 1, other) + 1, self%values, total)
         end do
      end do
   end subroutine sum_plane

   !> Lower corners of the tiles before, at and after a tile along one direction, relative to it.
   !! The tile before the first one is the last one (periodic).
   pure function lower_corners(grid, tiles, direction, tile, extent) result(corners)
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer, intent(in) :: direction               !! 1 to 3
      integer, intent(in) :: tile
      integer, intent(in) :: extent                  !! Its cells along the direction
      integer :: corners(-1:1)

      corners = [-grid%width(direction), 0, extent]
      if (tiles%coordinate(direction, tile) == 0) corners(-1) = &
         (grid%tiles(direction) - 1)*grid%width(direction) - grid%cells(direction)
      if (.not. grid%active(direction)) corners = 0
   end function lower_corners

   !> The same in three dimensions; the sums have the rows that are kept.
   pure subroutine sum_space(self, grid, tiles, boxes, tile, total)
      class(packed_patch_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes             !! Bounding boxes
      integer, intent(in) :: tile                    !! Tile of the nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums, all or kept rows
      integer :: place, other, direction, shift(3), extent(3), origin(3, -1:1), margin(3), low(3), &
         high(3), first(3), last(3), rows
      logical :: apart

      margin = merge(grid%margin, 0, grid%active)
      extent = extent_of(grid, tiles, tile)
      do direction = 1, 3
         origin(direction, :) = lower_corners(grid, tiles, direction, tile, extent(direction))
      end do
      rows = size(self%row)
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other == 0) cycle
         shift = shift_to(:, place)
         apart = .false.
         do direction = 1, 3
            ! the box of the neighbour, and its intersection with this tile
            first(direction) = origin(direction, shift(direction)) + boxes%box(direction, 1, other)
            last(direction) = origin(direction, shift(direction)) + boxes%box(direction, 2, other)
            low(direction) = max(-margin(direction), first(direction))
            high(direction) = min(extent(direction) + margin(direction), last(direction))
            apart = apart .or. high(direction) < low(direction)
            last(direction) = last(direction) - first(direction) + 1
         end do
         if (apart) cycle
         associate (packed => self%values(int(rows, int64)*boxes%before(other) + 1: &
            int(rows, int64)*boxes%before(other + 1)))
            call add_box(rows, low, high, margin, grid%stride, first, last, packed, size(total), &
               total)
         end associate
      end do
   end subroutine sum_space
end module mesh_packed_patch
