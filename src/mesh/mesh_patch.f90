! SPDX-License-Identifier: BSD-3-Clause
!> Node fields as private patches of tiles, and their sum over the tiles around a node.
!!
!! Each tile holds values of all its nodes, those on its faces included. What its particles gave
!! to them stands in a patch; the sum of the patches of all tiles that share a node, taken in the
!! order of the places of the tiles, is the same to the last bit on every tile, thread and rank.
module mesh_patch
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_tiles, only: neighbors, tiles_t
   implicit none
   private

   public :: assemble, ensure_patch

contains

   !> Make room for the patches of all tiles.
   pure subroutine ensure_patch(patch, nodes, components, tiles)
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (node, component, tile)
      integer, intent(in) :: nodes                   !! Nodes of a tile
      integer, intent(in) :: components              !! Fields
      integer, intent(in) :: tiles                   !! Tiles, ghosts included

      if (allocated(patch)) then
         if (size(patch, 1) == nodes .and. size(patch, 2) == components .and. &
            size(patch, 3) >= tiles) return
         deallocate (patch)
      end if
      allocate (patch(nodes, components, tiles + tiles/8))
   end subroutine ensure_patch

   !> Sum the patches that touch the nodes of one tile.
   pure subroutine assemble(grid, tiles, patch, tile, first, last, total)
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (node, component, tile) Contributions
      integer, intent(in) :: tile                    !! Whose nodes
      integer, intent(in) :: first                   !! First component
      integer, intent(in) :: last                    !! Last component
      real(wp), contiguous, intent(inout) :: total(:, :) !! (node, component - first + 1) Sums
      integer :: place, other, extent(3), theirs(3), shift(3), mine_at(3), theirs_at(3), length(3)

      extent = merge(grid%tile_extent(tiles%coordinate(:, tile)), 0, grid%active)
      total(:, 1:last - first + 1) = 0.0_wp
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other == 0) cycle
         shift = [mod(place - 1, 3), mod((place - 1)/3, 3), (place - 1)/9] - 1
         theirs = merge(grid%tile_extent(tiles%coordinate(:, other)), 0, grid%active)
         mine_at = merge(extent, 0, shift == 1)
         theirs_at = merge(theirs, 0, shift == -1)
         length = merge(extent, 0, shift == 0)
         call add_box(patch(:, :, other), first, last, 1 + dot_product(mine_at, grid%stride), &
            1 + dot_product(theirs_at, grid%stride), length, grid%stride, total)
      end do
   end subroutine assemble

   !> Add a box of nodes of one tile to a box of nodes of another.
   pure subroutine add_box(patch, first, last, mine, theirs, length, stride, total)
      real(wp), contiguous, intent(in) :: patch(:, :)    !! (node, component) of the other tile
      integer, intent(in) :: first                   !! First component
      integer, intent(in) :: last                    !! Last component
      integer, intent(in) :: mine                    !! First node here
      integer, intent(in) :: theirs                  !! First node there
      integer, intent(in) :: length(3)               !! Nodes of the box along each direction, less 1
      integer, intent(in) :: stride(3)               !! Steps in the node index
      real(wp), contiguous, intent(inout) :: total(:, :) !! (node, component) Sums
      integer :: component, x, y, z, shift, here, there

      do component = first, last
         do z = 0, length(3)
            do y = 0, length(2)
               shift = y*stride(2) + z*stride(3)
               here = mine + shift
               there = theirs + shift
               do x = 0, length(1)
                  total(here + x, component - first + 1) = total(here + x, component - first + 1) &
                     + patch(there + x, component)
               end do
            end do
         end do
      end do
   end subroutine add_box
end module mesh_patch
