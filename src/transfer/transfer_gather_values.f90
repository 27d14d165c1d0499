! SPDX-License-Identifier: BSD-3-Clause
!> Single values from nodes to particles with the linear functions of the cell: the nodes of a cell
!! are loaded once, then the particles of the cell are the lanes.
module transfer_gather_values
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   implicit none
   private

   public :: gather_hoop, gather_values, gather_vector

contains

   !> Hoop rate of axisymmetry, scale u_r / r, into component (2, 2) of the gradient.
   pure subroutine gather_hoop(grid, start, first, local, position, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: a(lanes, 3), b(lanes, 3), u(lanes, 3), radial
      integer :: cell, p, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call load_cell(grid, cell, nodes, scale, u)
         do p = start(cell) + 1, start(cell + 1)
            radial = 0.0_wp
            do lane = 1, lanes
               radial = radial + (a(lane, 1) + b(lane, 1)*local(p, 1)) &
                  *(a(lane, 2) + b(lane, 2)*local(p, 2))*(a(lane, 3) + b(lane, 3)*local(p, 3)) &
                  *u(lane, 1)
            end do
            gradient(p, 5) = radial/position(first + p - 1, 1)
         end do
      end do
   end subroutine gather_hoop

   !> Particle vectors from node vectors: values = keep values + scale sum S_i nodes_i.
   pure subroutine gather_vector(grid, start, first, local, nodes, keep, scale, values)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node)
      real(wp), intent(in) :: keep                           !! Share of the old value
      real(wp), intent(in) :: scale                          !! Factor of the node values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle, 3)
      real(wp) :: a(lanes, 3), b(lanes, 3), u(lanes, 3), shape, v1, v2, v3, x1, x2, x3
      integer :: cell, p, lane, q

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call load_cell(grid, cell, nodes, scale, u)
         !$omp simd private(x1, x2, x3, shape, v1, v2, v3, lane, q)
         do p = start(cell) + 1, start(cell + 1)
            x1 = local(p, 1)
            x2 = local(p, 2)
            x3 = local(p, 3)
            v1 = 0.0_wp
            v2 = 0.0_wp
            v3 = 0.0_wp
            do lane = 1, lanes
               shape = (a(lane, 1) + b(lane, 1)*x1)*(a(lane, 2) + b(lane, 2)*x2) &
                  *(a(lane, 3) + b(lane, 3)*x3)
               v1 = v1 + shape*u(lane, 1)
               v2 = v2 + shape*u(lane, 2)
               v3 = v3 + shape*u(lane, 3)
            end do
            q = first + p - 1
            values(q, 1) = keep*values(q, 1) + v1
            values(q, 2) = keep*values(q, 2) + v2
            values(q, 3) = keep*values(q, 3) + v3
         end do
      end do
   end subroutine gather_vector

   !> Values sum S_i node_i of any number of columns, three at a time.
   pure subroutine gather_values(grid, start, local, nodes, values)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      !> (particle of the tile, column) Columns up to the next multiple of three are written
      real(wp), contiguous, intent(inout) :: values(:, :)
      integer, parameter :: most = 9
      real(wp) :: a(lanes, 3), b(lanes, 3), u(lanes, most + 2), shape, v1, v2, v3, x1, x2, x3
      integer :: cell, p, lane, c, n

      a = grid%lane_constant
      b = grid%lane_slope
      n = size(nodes, 1)
      u = 0.0_wp
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         do lane = 1, lanes
            do c = 1, n
               u(lane, c) = nodes(c, grid%first_node(cell) + grid%lane_offset(lane))
            end do
         end do
         do c = 1, n, 3
            !$omp simd private(x1, x2, x3, shape, v1, v2, v3, lane)
            do p = start(cell) + 1, start(cell + 1)
               x1 = local(p, 1)
               x2 = local(p, 2)
               x3 = local(p, 3)
               v1 = 0.0_wp
               v2 = 0.0_wp
               v3 = 0.0_wp
               do lane = 1, lanes
                  shape = (a(lane, 1) + b(lane, 1)*x1)*(a(lane, 2) + b(lane, 2)*x2) &
                     *(a(lane, 3) + b(lane, 3)*x3)
                  v1 = v1 + shape*u(lane, c)
                  v2 = v2 + shape*u(lane, c + 1)
                  v3 = v3 + shape*u(lane, c + 2)
               end do
               values(p, c) = v1
               values(p, c + 1) = v2
               values(p, c + 2) = v3
            end do
         end do
      end do
   end subroutine gather_values

   !> Load the node values of a cell as lanes.
   pure subroutine load_cell(grid, cell, nodes, scale, values)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (component, node)
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (lane, component)
      integer :: component, lane, base

      base = grid%first_node(cell)
      do lane = 1, lanes
         do component = 1, size(values, 2)
            values(lane, component) = scale*nodes(component, base + grid%lane_offset(lane))
         end do
      end do
   end subroutine load_cell
end module transfer_gather_values
