! SPDX-License-Identifier: BSD-3-Clause
!> Node fields as private patches of tiles, and their sum over the tiles around a node.
!!
!! Each tile holds values of all its nodes, those on its faces included. What its particles gave
!! to them stands in a patch; the sum of the patches of all tiles that share a node, taken in the
!! order of the places of the tiles, is the same to the last bit on every tile, thread and rank.
!! The components of a node lie together, because whole nodes are added to whole nodes.
module mesh_patch
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_tiles, only: neighbors, tiles_t
   implicit none
   private

   public :: assemble, assemble_greatest, clear_patch, ensure_patch

contains

   !> Make room for the patches of all tiles.
   pure subroutine ensure_patch(patch, components, nodes, tiles)
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      integer, intent(in) :: components              !! Fields
      integer, intent(in) :: nodes                   !! Nodes of a tile
      integer, intent(in) :: tiles                   !! Tiles, ghosts included

      if (allocated(patch)) then
         if (size(patch, 1) == components .and. size(patch, 2) == nodes .and. &
            size(patch, 3) >= tiles) return
         deallocate (patch)
      end if
      allocate (patch(components, nodes, tiles + tiles/16))
   end subroutine ensure_patch

   !> Set the values of all nodes to zero, as one piece of memory: node by node it costs as much as
   !! a tenth of a step.
   pure subroutine clear_patch(values)
      real(wp), contiguous, intent(inout) :: values(:, :) !! (component, node)

      call clear_numbers(size(values), values)
   end subroutine clear_patch

   !> Set numbers to zero.
   pure subroutine clear_numbers(number, values)
      integer, intent(in) :: number                  !! Of them
      real(wp), intent(inout) :: values(number)      !! Flat

      values = 0.0_wp
   end subroutine clear_numbers

   !> Sum the patches that touch the nodes of one tile, its margin included.
   pure subroutine assemble(grid, tiles, patch, tile, total)
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (component, node, tile) Contributions
      integer, intent(in) :: tile                    !! Whose nodes
      real(wp), contiguous, intent(inout) :: total(:, :) !! (component, node) Sums
      integer :: place, other, shift(3), extent(3), theirs(3), origin(3), margin(3), low(3), high(3)

      extent = extent_of(tile)
      margin = merge(grid%margin, 0, grid%active)
      call clear_patch(total)
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other == 0) cycle
         ! as in common_box, whose call would cost 0.7 % of the instructions of a step
         shift(1) = mod(place - 1, 3) - 1
         shift(2) = mod((place - 1)/3, 3) - 1
         shift(3) = (place - 1)/9 - 1
         theirs = extent_of(other)
         ! lower corner of the other tile, and the box that both have, seen from this one
         origin = merge(extent, merge(-theirs, 0, shift == -1), shift == 1)
         low = max(0, origin) - margin
         high = min(extent, origin + theirs) + margin
         if (any(high < low)) cycle
         call add_box(size(patch, 1), size(patch, 2), dot_product(low + margin, grid%stride), &
            dot_product(low - origin + margin, grid%stride), high - low, grid%stride, &
            patch(:, :, other), total)
      end do

   contains

      !> Cells of a tile along the active directions.
      pure function extent_of(index) result(cells)
         integer, intent(in) :: index                !! Which tile
         integer :: cells(3)

         cells = merge(min(grid%width, grid%cells - tiles%coordinate(:, index)*grid%width), 0, &
            grid%active)
      end function extent_of
   end subroutine assemble

   !> Greatest values of the patches that touch the nodes of one tile, its margin included.
   pure subroutine assemble_greatest(grid, tiles, patch, tile, greatest)
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (component, node, tile) Values
      integer, intent(in) :: tile                    !! Whose nodes
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
   ! gate: long kernel because a box is told by two corners and its lengths
   pure subroutine common_box(grid, tiles, tile, other, place, mine, theirs, length)
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      integer, intent(in) :: tile                    !! Whose nodes
      integer, intent(in) :: other                   !! The tile around it
      integer, intent(in) :: place                   !! Its place, 1 to 27
      integer, intent(out) :: mine                   !! Nodes before the first one here
      integer, intent(out) :: theirs                 !! Nodes before the first one there
      integer, intent(out) :: length(3)              !! Nodes along a direction, less 1; < 0 = none
      integer :: shift(3), extent(3), reach(3), origin(3), margin(3), low(3)

      extent = extent_of(tile)
      reach = extent_of(other)
      margin = merge(grid%margin, 0, grid%active)
      shift(1) = mod(place - 1, 3) - 1
      shift(2) = mod((place - 1)/3, 3) - 1
      shift(3) = (place - 1)/9 - 1
      ! lower corner of the other tile, and the box that both have, seen from this one
      origin = merge(extent, merge(-reach, 0, shift == -1), shift == 1)
      low = max(0, origin) - margin
      length = min(extent, origin + reach) + margin - low
      mine = dot_product(low + margin, grid%stride)
      theirs = dot_product(low - origin + margin, grid%stride)

   contains

      !> Cells of a tile along the active directions.
      pure function extent_of(index) result(cells)
         integer, intent(in) :: index                !! Which tile
         integer :: cells(3)

         cells = merge(min(grid%width, grid%cells - tiles%coordinate(:, index)*grid%width), 0, &
            grid%active)
      end function extent_of
   end subroutine common_box

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
