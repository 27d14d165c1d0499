! SPDX-License-Identifier: BSD-3-Clause
!> Sums over the edges of cells, and the velocity gradient with a factor for each of them.
!!
!! Along a direction the slope of a linear function is the difference of its values on the two ends
!! of an edge, and the weight of the edges of that direction is a product of functions of the two
!! other directions. Edges along x are counted along z and y, those along y along x and z, those
!! along z along x and y. A missing direction has the coordinate zero, so edges that differ in it
!! only have no weight. Equations (Q.7) and (Q.9) of doc/theory/quadratures.md.
module transfer_edges
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lane_bit, lanes
   use transfer_gather, only: find_polynomial
   implicit none
   private

   public :: add_edge_sums, edge_integrals, gather_edge_gradient, low_end

   integer, parameter, public :: edges = lanes/2     !! Number of edges of a cell along a direction
   integer, parameter, public :: cell_edges = 3*edges !! Edges of a cell, by direction
   integer, parameter :: one(3) = [3, 1, 1]          !! First of the other directions
   integer, parameter :: other(3) = [2, 3, 2]        !! Second of them

contains

   !> Add the volume that particles have around each edge of their cells, sum v alpha_l N_e.
   pure subroutine add_edge_sums(grid, start, first, local, alpha, volume, sums)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Weight alpha
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: sums(:, 0:)     !! (edge, cell) [m3]
      real(wp) :: share, near, far
      integer :: cell, p, l, at

      do l = 1, 3
         if (.not. grid%active(l)) cycle
         at = edges*(l - 1)
         do cell = 0, grid%tile_cells - 1
            do p = start(cell) + 1, start(cell + 1)
               share = volume(first + p - 1)*alpha(p, l)
               far = share*local(p, other(l))
               near = share - far
               sums(at + 1, cell) = sums(at + 1, cell) + near*(1.0_wp - local(p, one(l)))
               sums(at + 2, cell) = sums(at + 2, cell) + near*local(p, one(l))
               sums(at + 3, cell) = sums(at + 3, cell) + far*(1.0_wp - local(p, one(l)))
               sums(at + 4, cell) = sums(at + 4, cell) + far*local(p, one(l))
            end do
         end do
      end do
   end subroutine add_edge_sums

   !> Velocity gradient of the cell with a factor for each edge, blended with that of the nodes:
   !! gradient_kl = alpha_l scale sum_e a_e N_e (change of u_k along e)/h + (1 - alpha_l) scale sum
   !! S_j (grad u)_j,kl. With factors of one it is that without them.
   pure subroutine gather_edge_gradient(grid, start, local, alpha, factor, velocity, nodes, scale, &
      gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Weight alpha
      real(wp), contiguous, intent(in) :: factor(:, 0:)      !! (edge, cell) Factor of each edge [1]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (9, node) Node gradient [1/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: u(edges), w(lanes)
      integer :: cell, k, l, node

      gradient(:start(grid%tile_cells), :) = 0.0_wp
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         node = grid%first_node(cell)
         do l = 1, 3
            if (.not. grid%active(l)) cycle
            do k = 1, 3
               if (.not. grid%active(k)) cycle
               call find_slope(grid, l, k, node, factor(edges*(l - 1) + 1:edges*l, cell), &
                  velocity, scale/grid%spacing, u)
               call find_polynomial(grid, cell, k + 3*(l - 1), scale, nodes, w)
               ! a compile-time constant removes the terms that a plane lacks
               if (grid%dimensions == 3) then
                  call blend(.true., start(cell) + 1, start(cell + 1), u, w, local(:, one(l)), &
                     local(:, other(l)), local(:, 1), local(:, 2), local(:, 3), alpha(:, l), &
                     gradient(:, k + 3*(l - 1)))
               else
                  call blend(.false., start(cell) + 1, start(cell + 1), u, w, local(:, one(l)), &
                     local(:, other(l)), local(:, 1), local(:, 2), local(:, 3), alpha(:, l), &
                     gradient(:, k + 3*(l - 1)))
               end if
            end do
         end do
      end do
   end subroutine gather_edge_gradient

   !> Integrals over a cell of the weights of its edges, 0 for edges that the scene lacks. In
   !! axisymmetry edges along the missing direction are rings through the nodes of the cell, with
   !! the weight of one over the radius.
   pure function edge_integrals(grid, cell) result(whole)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the box along x, from 0
      real(wp) :: whole(cell_edges)                          !! (edge) [m3], of rings [m2]
      real(wp) :: line(0:1, 3)
      integer :: l, e

      whole = 0.0_wp
      do l = 1, 3
         line(:, l) = grid%line_weight(l, merge(cell, 0, l == 1))
      end do
      do l = 1, 3
         if (.not. grid%active(l)) cycle
         do e = 1, edges
            whole(edges*(l - 1) + e) = grid%depth*(sum(line(:, l)) &
               *line(ibits(e - 1, 0, 1), one(l))*line(ibits(e - 1, 1, 1), other(l)))
         end do
      end do
      if (.not. grid%axisymmetric) return
      whole(edges + 1:2*edges) = grid%depth*(0.5_wp*grid%spacing)**2
   end function edge_integrals

   !> Lane of the lower end of an edge; that of the upper end has one bit more.
   pure integer function low_end(direction, edge) result(lane)
      integer, intent(in) :: direction                       !! Direction of the edge
      integer, intent(in) :: edge                            !! 1 to 4

      lane = 1 + ishft(ibits(edge - 1, 0, 1), lane_bit(one(direction))) &
         + ishft(ibits(edge - 1, 1, 1), lane_bit(other(direction)))
   end function low_end

   !> Coefficients of the slope along a direction: of 1, of one other coordinate, the second, and
   !! their product.
   pure subroutine find_slope(grid, direction, component, node, factor, velocity, scale, u)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: direction                       !! Direction of the slope
      integer, intent(in) :: component                       !! Component of the velocity
      integer, intent(in) :: node                            !! First node of the cell
      real(wp), intent(in) :: factor(edges)                  !! (edge) [1]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), intent(in) :: scale                          !! Time step over spacing [s/m]
      real(wp), intent(out) :: u(edges)                      !! (term)
      integer :: e, low, ends(0:1)

      do e = 1, edges
         low = low_end(direction, e)
         ends = node + grid%lane_offset([low, low + ishft(1, lane_bit(direction))])
         u(e) = factor(e)*scale*(velocity(component, ends(1)) - velocity(component, ends(0)))
      end do
      u(2) = u(2) - u(1)
      u(4) = u(4) - u(3)
      u(3) = u(3) - u(1)
      u(4) = u(4) - u(2)
   end subroutine find_slope

   !> Slopes at the particles of a cell, blended with values of a polynomial.
   pure subroutine blend(space, low, high, u, w, across, aside, x, y, z, alpha, slopes)
      logical, intent(in) :: space                           !! Three dimensions, or a plane?
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last index
      real(wp), intent(in) :: u(edges)                       !! (term) Coefficients of the slope
      real(wp), intent(in) :: w(lanes) !! (term) Coefficients of the polynomial
      real(wp), contiguous, intent(in) :: across(:), aside(:) !! (particle) Coordinates across
      real(wp), contiguous, intent(in) :: x(:), y(:), z(:)   !! (particle) Local coordinates [1]
      real(wp), contiguous, intent(in) :: alpha(:)           !! (particle) Weight of the slope [1]
      real(wp), contiguous, intent(inout) :: slopes(:)       !! (particle)
      real(wp) :: slope, value
      integer :: p, lane

      do p = low, high, 4
         !$omp simd private(slope, value)
         do lane = p, p + 3
            slope = u(1) + u(2)*across(lane)
            value = (w(1) + w(2)*x(lane)) + (w(3) + w(4)*x(lane))*z(lane)
            if (space) then
               slope = slope + (u(3) + u(4)*across(lane))*aside(lane)
               value = value + ((w(5) + w(6)*x(lane)) + (w(7) + w(8)*x(lane))*z(lane))*y(lane)
            end if
            slopes(lane) = alpha(lane)*slope + (1.0_wp - alpha(lane))*value
         end do
      end do
   end subroutine blend
end module transfer_edges
