! SPDX-License-Identifier: BSD-3-Clause
!> Nodes of a tile on a boundary of the domain. Boundaries are numbered from 1 to 6: xlo,
!! xhi, ylo, yhi, zlo, zhi.
module mesh_boundary_nodes
   use mesh_boundary_condition, only: normal_direction
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: boundary_nodes, has_boundary_nodes

contains

   !> Whether a tile has nodes on a boundary, its margin included.
   pure logical function has_boundary_nodes(grid, coordinate, face) result(has)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      integer :: first, length(3)

      call nodes_box(grid, coordinate, face, has, first, length)
   end function has_boundary_nodes

   !> The nodes of a tile, its margin included, on a boundary; x runs fastest.
   pure subroutine boundary_nodes(grid, coordinate, face, nodes, number)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      integer, intent(out) :: nodes(:)               !! The nodes; capacity for a tile
      integer, intent(out) :: number                 !! How many, 0 = the tile has none
      integer :: first, length(3), x, y, z
      logical :: here

      number = 0
      call nodes_box(grid, coordinate, face, here, first, length)
      if (.not. here) return
      do z = 0, length(3)
         do y = 0, length(2)
            do x = 0, length(1)
               number = number + 1
               nodes(number) = first + x*grid%stride(1) + y*grid%stride(2) + z*grid%stride(3)
            end do
         end do
      end do
   end subroutine boundary_nodes

   !> The box of nodes of a tile, its margin included, on a boundary.
   pure subroutine nodes_box(grid, coordinate, face, here, first, length)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      logical, intent(out) :: here                   !! Does the tile touch the boundary?
      integer, intent(out) :: first                  !! First node of the box
      integer, intent(out) :: length(3)              !! Nodes of the box along a direction, less 1
      integer :: normal, layer

      normal = normal_direction(face)
      first = 1
      length = merge(grid%tile_extent(coordinate) + 2*grid%margin, 0, grid%active)
      here = grid%active(normal)
      if (.not. here) return
      layer = grid%margin - coordinate(normal)*grid%width(normal)
      if (mod(face, 2) == 0) layer = layer + grid%cells(normal)
      here = layer >= 0 .and. layer <= length(normal)
      if (.not. here) return
      first = 1 + layer*grid%stride(normal)
      length(normal) = 0
   end subroutine nodes_box
end module mesh_boundary_nodes
