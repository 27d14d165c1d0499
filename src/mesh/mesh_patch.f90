! SPDX-License-Identifier: BSD-3-Clause
!> Node fields as private patches of tiles, and their sum over the tiles around a node.
!!
!! Each tile holds values of all its nodes, those on its faces included. The contributions of its
!! own particles are a patch; the sum of the patches of all tiles that contain a node, taken in the
!! order of the neighbours, is the same to the last bit on every tile, thread and rank. The
!! components of a node are contiguous in memory, because patches are added node by node.
module mesh_patch
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_tiles, only: neighbors, shift_to, tiles_t
   implicit none
   private

   public :: add_field, assemble, assemble_greatest, clear_patch, combine, empty_box, &
      ensure_patch, ensure_weights, extent_of, widen_box

contains

   !> Reserve memory for the patches of all tiles.
   pure subroutine ensure_patch(patch, components, nodes, tiles)
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      integer, intent(in) :: components              !! Fields
      integer, intent(in) :: nodes                   !! Nodes of a tile
      integer, intent(in) :: tiles                   !! Tiles, ghosts included

      if (allocated(patch)) then
         if (size(patch, 1) == components .and. size(patch, 2) == nodes .and. &
            size(patch, 3) >= tiles .and. size(patch, 3) <= 2*tiles + 16) return
         deallocate (patch)
      end if
      allocate (patch(components, nodes, tiles + tiles/32))
   end subroutine ensure_patch

   !> Reserve memory for the weights of the cells of all tiles.
   pure subroutine ensure_weights(weight, cells, tiles)
      real(wp), allocatable, intent(inout) :: weight(:, :) !! (cell, tile)
      integer, intent(in) :: cells                   !! Cells of a tile
      integer, intent(in) :: tiles                   !! Tiles, ghosts included

      if (allocated(weight)) then
         if (size(weight, 2) >= tiles) return
         deallocate (weight)
      end if
      allocate (weight(cells, tiles + tiles/32))
   end subroutine ensure_weights

   !> A box that holds no node.
   pure subroutine empty_box(box)
      integer, intent(out) :: box(3, 2)              !! Lowest and highest node, from 0
      integer, parameter :: nowhere = 1000000000     !! Far from any node of any tile

      box(:, 1) = nowhere
      box(:, 2) = -nowhere
   end subroutine empty_box

   !> Widen a box of nodes by those of some cells of a tile.
   pure subroutine widen_box(grid, used, box)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: used(0:)                !! (cell) Which cells
      integer, intent(inout) :: box(3, 2)            !! Lowest and highest node, from 0
      integer :: cell, upper(3), margin(3)

      ! the cells from the first to the last make up the whole tile
      if (grid%margin > 0 .or. (used(0) .and. used(grid%tile_cells - 1))) then
         margin = merge(grid%margin, 0, grid%active)
         box(:, 1) = -margin
         box(:, 2) = merge(grid%width, 0, grid%active) + margin
         return
      end if
      upper = merge(1, 0, grid%active)
      do cell = 0, grid%tile_cells - 1
         if (.not. used(cell)) cycle
         box(:, 1) = min(box(:, 1), grid%cell_position(:, cell))
         box(:, 2) = max(box(:, 2), grid%cell_position(:, cell) + upper)
      end do
   end subroutine widen_box

   !> Set the values of all nodes to zero as one contiguous array; a loop over nodes would take a
   !! tenth of the time of a step.
   pure subroutine clear_patch(values)
      real(wp), contiguous, intent(inout) :: values(:, :) !! (component, node)

      call clear_numbers(size(values), values)
   end subroutine clear_patch

   !> Set numbers to zero.
   pure subroutine clear_numbers(number, values)
      integer, intent(in) :: number                  !! Their number
      real(wp), intent(inout) :: values(number)      !! Flattened

      values = 0.0_wp
   end subroutine clear_numbers

   !> Sum of two fields of a tile with factors, as contiguous arrays; a loop over the nodes with
   !! three components each would take ten times as long.
   pure subroutine combine(factor, one, share, other, total)
      real(wp), intent(in) :: factor                 !! Factor of the first field
      real(wp), contiguous, intent(in) :: one(:, :)  !! (component, node)
      real(wp), intent(in) :: share                  !! Factor of the second field
      real(wp), contiguous, intent(in) :: other(:, :) !! (component, node)
      real(wp), contiguous, intent(inout) :: total(:, :) !! (component, node)

      call combine_numbers(size(total), factor, one, share, other, total)
   end subroutine combine

   !> Sum of two rows of numbers with factors.
   pure subroutine combine_numbers(number, factor, one, share, other, total)
      integer, intent(in) :: number                  !! Their number
      real(wp), intent(in) :: factor                 !! Factor of the first field
      real(wp), intent(in) :: one(number)            !! Flattened
      real(wp), intent(in) :: share                  !! Factor of the second field
      real(wp), intent(in) :: other(number)          !! Flattened
      real(wp), intent(inout) :: total(number)       !! Flattened
      integer :: n

      !$omp simd
      do n = 1, number
         total(n) = factor*one(n) + share*other(n)
      end do
   end subroutine combine_numbers

   !> Add a field of a tile to another one, as contiguous arrays.
   pure subroutine add_field(field, total)
      real(wp), contiguous, intent(in) :: field(:, :)    !! (component, node)
      real(wp), contiguous, intent(inout) :: total(:, :) !! (component, node)

      call add_numbers(size(total), field, total)
   end subroutine add_field

   !> Add a row of numbers to another.
   pure subroutine add_numbers(number, field, total)
      integer, intent(in) :: number                  !! Their number
      real(wp), intent(in) :: field(number)          !! Flattened
      real(wp), intent(inout) :: total(number)       !! Flattened
      integer :: n

      !$omp simd
      do n = 1, number
         total(n) = total(n) + field(n)
      end do
   end subroutine add_numbers

   !> Sum the patches that touch the nodes of one tile, its margin included.
   pure subroutine assemble(grid, tiles, patch, tile, total)
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (component, node, tile) Contributions
      integer, intent(in) :: tile                    !! Tile of the nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (component, node) Sums
      integer :: place, other, mine, theirs, length(3)

      call clear_patch(total)
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other == 0) cycle
         call common_box(grid, tiles, tile, other, place, mine, theirs, length)
         if (any(length < 0)) cycle
         call add_box(size(patch, 1), size(patch, 2), mine, theirs, length, grid%stride, &
            patch(:, :, other), total)
      end do
   end subroutine assemble

   !> Greatest values of the patches that touch the nodes of one tile, its margin included.
   pure subroutine assemble_greatest(grid, tiles, patch, tile, greatest)
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (component, node, tile) Values
      integer, intent(in) :: tile                    !! Tile of the nodes
      real(wp), contiguous, intent(inout) :: greatest(:, :) !! (component, node)
      integer :: place, other, mine, theirs, length(3), x, y, z, shift

      greatest = -huge(1.0_wp)
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other == 0) cycle
         call common_box(grid, tiles, tile, other, place, mine, theirs, length)
         do z = 0, length(3)
            do y = 0, length(2)
               do x = 0, length(1)
                  shift = 1 + x*grid%stride(1) + y*grid%stride(2) + z*grid%stride(3)
                  greatest(:, mine + shift) = max(greatest(:, mine + shift), &
                     patch(:, theirs + shift, other))
               end do
            end do
         end do
      end do
   end subroutine assemble_greatest

   !> The box of nodes that a tile has in common with one around it, margins included.
   pure subroutine common_box(grid, tiles, tile, other, place, mine, theirs, length)
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer, intent(in) :: tile                    !! Tile of the nodes
      integer, intent(in) :: other                   !! The tile around it
      integer, intent(in) :: place                   !! Its place, 1 to 27
      integer, intent(out) :: mine                   !! Nodes before the first one here
      integer, intent(out) :: theirs                 !! Nodes before the first one there
      integer, intent(out) :: length(3)              !! Nodes along a direction, less 1; < 0 = none
      integer :: shift(3), extent(3), reach(3), origin(3), margin(3), low(3)

      extent = extent_of(grid, tiles, tile)
      reach = extent_of(grid, tiles, other)
      margin = merge(grid%margin, 0, grid%active)
      shift = shift_to(:, place)
      ! lower corner of the other tile, and the overlap of both, relative to this one
      origin = merge(extent, merge(-reach, 0, shift == -1), shift == 1)
      low = max(0, origin) - margin
      length = min(extent, origin + reach) + margin - low
      mine = dot_product(low + margin, grid%stride)
      theirs = dot_product(low - origin + margin, grid%stride)
   end subroutine common_box

   !> Cells of a tile along the active directions.
   pure function extent_of(grid, tiles, index) result(cells)
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer, intent(in) :: index                   !! Index of the tile
      integer :: cells(3)

      cells = merge(min(grid%width, grid%cells - tiles%coordinate(:, index)*grid%width), 0, &
         grid%active)
   end function extent_of

   !> Add a box of nodes of one tile to a box of nodes of another. Nodes of a line along x and their
   !! components are one piece of memory, so a line is added as one vector.
   pure subroutine add_box(components, nodes, mine, theirs, length, stride, patch, total)
      integer, intent(in) :: components              !! Fields
      integer, intent(in) :: nodes                   !! Nodes of a tile
      integer, intent(in) :: mine                    !! Nodes before the first one here
      integer, intent(in) :: theirs                  !! Nodes before the first one there
      integer, intent(in) :: length(3)               !! Nodes of the box along a direction, less 1
      integer, intent(in) :: stride(3)               !! Steps in the node index
      real(wp), intent(in) :: patch(components*nodes) !! (component, node) of the other tile, flat
      real(wp), intent(inout) :: total(components*nodes) !! (component, node) Sums, flat
      integer :: n, y, z, shift, here, there, line

      line = components*(length(1) + 1)
      do z = 0, length(3)
         do y = 0, length(2)
            shift = y*stride(2) + z*stride(3)
            here = (mine + shift)*components
            there = (theirs + shift)*components
            do n = 1, line
               total(here + n) = total(here + n) + patch(there + n)
            end do
         end do
      end do
   end subroutine add_box
end module mesh_patch
