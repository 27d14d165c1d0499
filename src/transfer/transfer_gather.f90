! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles with the linear functions of the cell: the nodes of a cell are loaded once,
!! then the particles of the cell are the lanes.
module transfer_gather
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   implicit none
   private

   public :: gather_gradient, gather_dual_gradient, gather_hoop, gather_motion, gather_values, &
      gather_vector, locate

contains

   !> Place of each particle in its cell, 0 to 1 along each active direction. The same arithmetic as
   !! that which found the cell, so that both agree to the last bit.
   pure subroutine locate(grid, first, count, position, local)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: first                           !! First particle of the tile
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) [m]
      real(wp), contiguous, intent(inout) :: local(:, :)     !! (particle of the tile, 3)
      real(wp) :: inverse, lower, place
      integer :: p, direction

      inverse = 1.0_wp/grid%spacing
      do direction = 1, 3
         if (.not. grid%active(direction)) then
            local(:count, direction) = 0.0_wp
            cycle
         end if
         lower = grid%lower(direction)
         do p = 1, count
            place = (position(first + p - 1, direction) - lower)*inverse
            local(p, direction) = place - aint(place)
         end do
      end do
   end subroutine locate

   !> Scaled velocity gradient of the plain method: gradient_kl = scale sum u_k dS/dx_l.
   pure subroutine gather_gradient(grid, start, local, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: gradient(:, :)
      real(wp) :: a(lanes, 3), b(lanes, 3), u(lanes, 3), x1, x2, x3, s1, s2, s3, g1, g2, g3
      real(wp) :: l11, l21, l31, l12, l22, l32, l13, l23, l33
      integer :: cell, p, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call load_cell(grid, cell, nodes, scale/grid%spacing, u)
         !$omp simd private(x1, x2, x3, s1, s2, s3, g1, g2, g3, lane) &
         !$omp private(l11, l21, l31, l12, l22, l32, l13, l23, l33)
         do p = start(cell) + 1, start(cell + 1)
            x1 = local(p, 1)
            x2 = local(p, 2)
            x3 = local(p, 3)
            l11 = 0.0_wp; l21 = 0.0_wp; l31 = 0.0_wp
            l12 = 0.0_wp; l22 = 0.0_wp; l32 = 0.0_wp
            l13 = 0.0_wp; l23 = 0.0_wp; l33 = 0.0_wp
            do lane = 1, lanes
               s1 = a(lane, 1) + b(lane, 1)*x1
               s2 = a(lane, 2) + b(lane, 2)*x2
               s3 = a(lane, 3) + b(lane, 3)*x3
               g1 = b(lane, 1)*(s2*s3)
               g2 = b(lane, 2)*(s1*s3)
               g3 = b(lane, 3)*(s1*s2)
               l11 = l11 + g1*u(lane, 1)
               l21 = l21 + g1*u(lane, 2)
               l31 = l31 + g1*u(lane, 3)
               l12 = l12 + g2*u(lane, 1)
               l22 = l22 + g2*u(lane, 2)
               l32 = l32 + g2*u(lane, 3)
               l13 = l13 + g3*u(lane, 1)
               l23 = l23 + g3*u(lane, 2)
               l33 = l33 + g3*u(lane, 3)
            end do
            gradient(p, 1) = l11
            gradient(p, 2) = l21
            gradient(p, 3) = l31
            gradient(p, 4) = l12
            gradient(p, 5) = l22
            gradient(p, 6) = l32
            gradient(p, 7) = l13
            gradient(p, 8) = l23
            gradient(p, 9) = l33
         end do
      end do
   end subroutine gather_gradient

   !> Blend the gradient of the cell, already in place, with the gradient on the nodes:
   !! gradient_kl = alpha_l gradient_kl + (1 - alpha_l) scale sum S_j (grad u)_j,kl.
   pure subroutine gather_dual_gradient(grid, start, local, alpha, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Share of cell
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (9, node) Node gradient [1/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: a(lanes, 3), b(lanes, 3), u(lanes, 9), shape, x1, x2, x3
      real(wp) :: n1, n2, n3, n4, n5, n6, n7, n8, n9, a1, a2, a3
      integer :: cell, p, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call load_cell(grid, cell, nodes, scale, u)
         !$omp simd private(x1, x2, x3, shape, n1, n2, n3, n4, n5, n6, n7, n8, n9, a1, a2, a3, lane)
         do p = start(cell) + 1, start(cell + 1)
            x1 = local(p, 1)
            x2 = local(p, 2)
            x3 = local(p, 3)
            n1 = 0.0_wp; n2 = 0.0_wp; n3 = 0.0_wp
            n4 = 0.0_wp; n5 = 0.0_wp; n6 = 0.0_wp
            n7 = 0.0_wp; n8 = 0.0_wp; n9 = 0.0_wp
            do lane = 1, lanes
               shape = (a(lane, 1) + b(lane, 1)*x1)*(a(lane, 2) + b(lane, 2)*x2) &
                  *(a(lane, 3) + b(lane, 3)*x3)
               n1 = n1 + shape*u(lane, 1)
               n2 = n2 + shape*u(lane, 2)
               n3 = n3 + shape*u(lane, 3)
               n4 = n4 + shape*u(lane, 4)
               n5 = n5 + shape*u(lane, 5)
               n6 = n6 + shape*u(lane, 6)
               n7 = n7 + shape*u(lane, 7)
               n8 = n8 + shape*u(lane, 8)
               n9 = n9 + shape*u(lane, 9)
            end do
            a1 = alpha(p, 1)
            a2 = alpha(p, 2)
            a3 = alpha(p, 3)
            gradient(p, 1) = a1*gradient(p, 1) + (1.0_wp - a1)*n1
            gradient(p, 2) = a1*gradient(p, 2) + (1.0_wp - a1)*n2
            gradient(p, 3) = a1*gradient(p, 3) + (1.0_wp - a1)*n3
            gradient(p, 4) = a2*gradient(p, 4) + (1.0_wp - a2)*n4
            gradient(p, 5) = a2*gradient(p, 5) + (1.0_wp - a2)*n5
            gradient(p, 6) = a2*gradient(p, 6) + (1.0_wp - a2)*n6
            gradient(p, 7) = a3*gradient(p, 7) + (1.0_wp - a3)*n7
            gradient(p, 8) = a3*gradient(p, 8) + (1.0_wp - a3)*n8
            gradient(p, 9) = a3*gradient(p, 9) + (1.0_wp - a3)*n9
         end do
      end do
   end subroutine gather_dual_gradient

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

   !> Velocity and position at once: velocity = keep velocity + sum S_i push_i, position = position
   !! + dt sum S_i carry_i.
   pure subroutine gather_motion(grid, start, first, local, push, carry, keep, dt, velocity, &
      position)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: push(:, :)         !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: carry(:, :)        !! (3, node) [m/s]
      real(wp), intent(in) :: keep                           !! Share of the old velocity
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]
      real(wp) :: a(lanes, 3), b(lanes, 3), u(lanes, 3), c(lanes, 3), shape, x1, x2, x3
      real(wp) :: v1, v2, v3, c1, c2, c3
      integer :: cell, p, lane, q

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call load_cell(grid, cell, push, 1.0_wp, u)
         call load_cell(grid, cell, carry, dt, c)
         !$omp simd private(x1, x2, x3, shape, v1, v2, v3, c1, c2, c3, lane, q)
         do p = start(cell) + 1, start(cell + 1)
            x1 = local(p, 1)
            x2 = local(p, 2)
            x3 = local(p, 3)
            v1 = 0.0_wp; v2 = 0.0_wp; v3 = 0.0_wp
            c1 = 0.0_wp; c2 = 0.0_wp; c3 = 0.0_wp
            do lane = 1, lanes
               shape = (a(lane, 1) + b(lane, 1)*x1)*(a(lane, 2) + b(lane, 2)*x2) &
                  *(a(lane, 3) + b(lane, 3)*x3)
               v1 = v1 + shape*u(lane, 1)
               v2 = v2 + shape*u(lane, 2)
               v3 = v3 + shape*u(lane, 3)
               c1 = c1 + shape*c(lane, 1)
               c2 = c2 + shape*c(lane, 2)
               c3 = c3 + shape*c(lane, 3)
            end do
            q = first + p - 1
            velocity(q, 1) = keep*velocity(q, 1) + v1
            velocity(q, 2) = keep*velocity(q, 2) + v2
            velocity(q, 3) = keep*velocity(q, 3) + v3
            position(q, 1) = position(q, 1) + c1
            position(q, 2) = position(q, 2) + c2
            position(q, 3) = position(q, 3) + c3
         end do
      end do
   end subroutine gather_motion

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
end module transfer_gather
