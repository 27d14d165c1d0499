! SPDX-License-Identifier: BSD-3-Clause
!> Hoop terms of axisymmetry with a factor for each node of a cell.
!!
!! A ring of material around the axis is an edge along the missing direction, on which the slope of
!! the velocity is u_r/r. Four such edges, one through each node of a cell, have the factors that
!! edges along that direction have in space: their weights S_i/r are summed over the particles and
!! compared with the integral. Equations (Q.7) and (Q.9) of doc/theory/quadratures.md.
module transfer_hoop
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_edges, only: edges
   implicit none
   private

   public :: add_hoop_sums, gather_factored_hoop, scatter_factored_hoop

   integer, parameter :: corners = 4                 !! Nodes of a cell in a plane
   !> Indices of these edges among all edges of a cell, in the order of its nodes
   integer, parameter, public :: hoop_edges(corners) = edges + [1, 2, 3, 4]

contains

   !> Add the sums of v S_i/r of the particles of a tile to those of the edges of their cells.
   pure subroutine add_hoop_sums(grid, start, first, local, position, volume, sums)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: sums(:, 0:)     !! (edge, cell) [m2]
      integer :: cell, p, q

      do cell = 0, grid%tile_cells - 1
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            sums(hoop_edges, cell) = sums(hoop_edges, cell) &
               + volume(q)/position(q, 1)*shape_functions(local(p, 1), local(p, 3))
         end do
      end do
   end subroutine add_hoop_sums

   !> Add the force of the hoop stress, - sum a_i v sigma_yy S_i/r, to column 5.
   pure subroutine scatter_factored_hoop(grid, start, first, local, factor, position, volume, &
      stress, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: factor(:, 0:)      !! (edge, cell) [1]
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: force(corners)
      integer :: cell, p, q, n, node

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         force = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            force = force - volume(q)*stress(q, 2)/position(q, 1) &
               *shape_functions(local(p, 1), local(p, 3))
         end do
         do n = 1, corners
            node = grid%first_node(cell) + grid%lane_offset(n)
            patch(5, node) = patch(5, node) + factor(hoop_edges(n), cell)*force(n)
         end do
      end do
   end subroutine scatter_factored_hoop

   !> Hoop strain, scale sum a_i S_i u_i/r, into component (2, 2) of the gradient.
   pure subroutine gather_factored_hoop(grid, start, first, local, factor, position, nodes, scale, &
      gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: factor(:, 0:)      !! (edge, cell) [1]
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: u(corners)
      integer :: cell, p, n

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         do n = 1, corners
            u(n) = scale*factor(hoop_edges(n), cell) &
               *nodes(1, grid%first_node(cell) + grid%lane_offset(n))
         end do
         do p = start(cell) + 1, start(cell + 1)
            gradient(p, 5) = sum(u*shape_functions(local(p, 1), local(p, 3))) &
               /position(first + p - 1, 1)
         end do
      end do
   end subroutine gather_factored_hoop

   !> Shape functions of the nodes of a cell in a plane [1].
   pure function shape_functions(x, z) result(values)
      real(wp), intent(in) :: x, z                           !! Local coordinate, 0 to 1
      real(wp) :: values(corners)

      values = [(1.0_wp - x)*(1.0_wp - z), x*(1.0_wp - z), (1.0_wp - x)*z, x*z]
   end function shape_functions
end module transfer_hoop
