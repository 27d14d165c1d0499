! SPDX-License-Identifier: BSD-3-Clause
!> The box of nodes that the particles of each tile touch.
module mesh_node_boxes
   use mesh_grid, only: grid_t
   use mesh_patch, only: extent_of
   use mesh_tiles, only: tiles_t
   implicit none
   private

   public :: node_boxes_t

   !> Boxes of nodes that the particles of each tile touch, and where their packed patches begin.
   type :: node_boxes_t
      integer, allocatable :: box(:, :, :)           !! (3, lowest or highest node, tile)
      integer, allocatable :: before(:)              !! (tile + 1) Nodes of all tiles before
   contains
      procedure :: ensure => boxes_ensure            !! Reserve memory for tiles
      procedure :: line_up => boxes_find_offsets    !! Find where the packed patches begin
      procedure :: nodes => boxes_nodes              !! Nodes of all tiles
   end type node_boxes_t

contains

   !> Reserve memory for the boxes of tiles; existing ones are kept.
   pure subroutine boxes_ensure(self, tiles)
      class(node_boxes_t), intent(inout) :: self
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

   !> Find where the packed patches of tiles begin. Boxes are cut at the ends of thin tiles.
   pure subroutine boxes_find_offsets(self, grid, tiles)
      class(node_boxes_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles             !! The tiles; some may have no box yet
      integer :: tile

      self%before(1) = 0
      do tile = 1, size(self%box, 3)
         self%box(:, 2, tile) = min(self%box(:, 2, tile), extent_of(grid, tiles, tile) &
            + merge(grid%margin, 0, grid%active))
         self%before(tile + 1) = self%before(tile) &
            + product(max(self%box(:, 2, tile) - self%box(:, 1, tile) + 1, 0))
      end do
   end subroutine boxes_find_offsets

   !> Nodes of the boxes of all tiles.
   pure integer function boxes_nodes(self) result(nodes)
      class(node_boxes_t), intent(in) :: self

      nodes = self%before(size(self%before))
   end function boxes_nodes
end module mesh_node_boxes
