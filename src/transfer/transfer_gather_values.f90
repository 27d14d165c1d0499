! SPDX-License-Identifier: BSD-3-Clause
!> Single values from nodes to particles with the linear functions of the cell: the coefficients of
!! the polynomial of a cell are found once, then four particles of the cell at a time are the lanes.
!!
!! The last lanes of a cell may hold particles of the next cells or none. What they get is
!! overwritten when those cells come, so cells are taken in order, and columns have `spare` rows
!! after the last particle.
module transfer_gather_values
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   implicit none
   private

   public :: find_polynomial, gather_hoop, gather_values, gather_vector

contains

   !> Hoop rate of axisymmetry, scale u_r / r, into component (2, 2) of the gradient. Equation
   !! (M.25) of doc/theory/method.md.
   pure subroutine gather_hoop(grid, start, first, local, position, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: u(lanes)
      integer :: cell, p

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_polynomial(grid, cell, 1, scale, nodes, u)
         call evaluate_plane(start(cell) + 1, start(cell + 1), u, local(:, 1), local(:, 3), &
            gradient(:, 5))
      end do
      do p = 1, start(grid%tile_cells)
         gradient(p, 5) = gradient(p, 5)/position(first + p - 1, 1)
      end do
   end subroutine gather_hoop

   !> Particle vectors from node vectors: values = keep values + scale sum S_i nodes_i.
   pure subroutine gather_vector(grid, start, first, local, nodes, kept, scale, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node)
      real(wp), intent(in) :: kept                           !! Fraction of the old values [1]
      real(wp), intent(in) :: scale                          !! Factor of the node values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle, 3)
      real(wp) :: gain(size(local, 1), 3)
      integer :: p, k

      call gather_values(grid, start, local, nodes, gain)
      do k = 1, 3
         do p = 1, start(grid%tile_cells)
            values(first + p - 1, k) = kept*values(first + p - 1, k) + scale*gain(p, k)
         end do
      end do
   end subroutine gather_vector

   !> Values sum S_i node_i of any number of columns.
   pure subroutine gather_values(grid, start, local, nodes, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: u(lanes)
      integer :: cell, c

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         do c = 1, size(nodes, 1)
            call find_polynomial(grid, cell, c, 1.0_wp, nodes, u)
            if (grid%dimensions == 3) then
               call evaluate_space(start(cell) + 1, start(cell + 1), u, local(:, 1), &
                  local(:, 2), local(:, 3), values(:, c))
            else
               call evaluate_plane(start(cell) + 1, start(cell + 1), u, local(:, 1), &
                  local(:, 3), values(:, c))
            end if
         end do
      end do
   end subroutine gather_values

   !> Coefficients of the polynomial of one component of a node field in a cell, by differences
   !! along x, then z, then y; those of a missing direction are not found.
   pure subroutine find_polynomial(grid, cell, component, scale, nodes, u)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      integer, intent(in) :: component                       !! Of the field
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (component, node)
      real(wp), intent(inout) :: u(lanes)                    !! Of 1, x, z, xz, y, xy, yz, xyz
      integer :: lane, base, last

      base = grid%first_node(cell)
      last = merge(lanes, lanes/2, grid%dimensions == 3)
      do lane = 1, last
         u(lane) = scale*nodes(component, base + grid%lane_offset(lane))
      end do
      u(2) = u(2) - u(1)
      u(4) = u(4) - u(3)
      u(3) = u(3) - u(1)
      u(4) = u(4) - u(2)
      if (last < lanes) return
      u(6) = u(6) - u(5)
      u(8) = u(8) - u(7)
      u(7) = u(7) - u(5)
      u(8) = u(8) - u(6)
      do lane = 1, 4
         u(lane + 4) = u(lane + 4) - u(lane)
      end do
   end subroutine find_polynomial

   !> Values of a polynomial with all terms at the particles of a cell.
   pure subroutine evaluate_space(low, high, u, x, y, z, values)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last one
      real(wp), intent(in) :: u(lanes)                       !! Coefficients
      real(wp), contiguous, intent(in) :: x(:), y(:), z(:)   !! (particle) Local coordinates [1]
      real(wp), contiguous, intent(inout) :: values(:)       !! (particle)
      integer :: p, lane

      do p = low, high, 4
         !$omp simd
         do lane = p, p + 3
            values(lane) = ((u(1) + u(2)*x(lane)) + (u(3) + u(4)*x(lane))*z(lane)) &
               + ((u(5) + u(6)*x(lane)) + (u(7) + u(8)*x(lane))*z(lane))*y(lane)
         end do
      end do
   end subroutine evaluate_space

   !> Values of a polynomial of x and z at the particles of a cell.
   pure subroutine evaluate_plane(low, high, u, x, z, values)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last one
      real(wp), intent(in) :: u(lanes)                       !! Coefficients, of which four count
      real(wp), contiguous, intent(in) :: x(:), z(:)         !! (particle) Local coordinates [1]
      real(wp), contiguous, intent(inout) :: values(:)       !! (particle)
      integer :: p, lane

      do p = low, high, 4
         !$omp simd
         do lane = p, p + 3
            values(lane) = (u(1) + u(2)*x(lane)) + (u(3) + u(4)*x(lane))*z(lane)
         end do
      end do
   end subroutine evaluate_plane
end module transfer_gather_values
