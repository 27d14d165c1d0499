! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles with the linear functions of the cell.
!!
!! Between its nodes a field is a polynomial with the terms 1, x, z, xz, y, xy, yz, xyz of the local
!! coordinates. Its coefficients are found once a cell, as differences, so a uniform field has a
!! gradient of exactly zero; then the particles of the cell are the lanes. A
!! value costs 7 products instead of 8 and no weights, a slope 3 instead of 8. In a plane and on a
!! line most of this is zero, so they have kernels of their own, chosen once a tile.
module transfer_gather
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   use transfer_gather_plane, only: dual_gradient_plane, gradient_plane, motion_plane
   use transfer_gather_values, only: find_terms
   implicit none
   private

   public :: gather_gradient, gather_dual_gradient, gather_motion

   integer, parameter :: tensor = 12                 !! Nine components and three unused elements
   integer, parameter :: one(3) = [3, 1, 1]          !! First of the other directions
   integer, parameter :: other(3) = [2, 3, 2]        !! Second of them
   !> Terms with the coordinate along a direction: alone, with that of the first of the other
   !! directions, of the second. The last term has all.
   integer, parameter :: across(3, 3) = reshape([2, 4, 6, 5, 6, 7, 3, 4, 7], [3, 3])

contains

   !> Scaled velocity gradient of the plain method: gradient_kl = scale sum u_k dS/dx_l.
   pure subroutine gather_gradient(grid, start, local, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: gradient(:, :)
      real(wp) :: u(4, lanes)
      integer :: cell, p, ways(lanes)

      if (grid%dimensions < 3) then
         call gradient_plane(grid, start, local, nodes, scale, gradient)
         return
      end if
      ways = 3*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_terms(3, 4, grid%first_node(cell), ways, size(nodes), nodes, &
            scale/grid%spacing, u)
         do p = start(cell) + 1, start(cell + 1), lanes
            call find_slopes(u, p - 1, size(local, 1), local, size(gradient, 1), gradient)
         end do
      end do
   end subroutine gather_gradient

   !> The gradient of the cell, blended with that of the nodes:
   !! gradient_kl = alpha_l scale sum u_k dS/dx_l + (1 - alpha_l) scale sum S_j (grad u)_j,kl.
   !! Equation (M.7) of doc/theory/method.md.
   pure subroutine gather_dual_gradient(grid, start, local, alpha, velocity, nodes, scale, &
      gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Weight alpha
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (9, node) Node gradient [1/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: u(4, lanes), w(tensor, lanes)
      integer :: cell, p, ways(lanes), far(lanes)

      if (grid%dimensions < 3) then
         call dual_gradient_plane(grid, start, local, alpha, velocity, nodes, scale, gradient)
         return
      end if
      ways = 3*grid%lane_offset
      far = 9*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_terms(3, 4, grid%first_node(cell), ways, size(velocity), velocity, &
            scale/grid%spacing, u)
         call find_terms(9, tensor, grid%first_node(cell), far, size(nodes), nodes, scale, w)
         do p = start(cell) + 1, start(cell + 1), lanes
            call blend_slopes(u, w, p - 1, size(local, 1), local, size(alpha, 1), alpha, &
               size(gradient, 1), gradient)
         end do
      end do
   end subroutine gather_dual_gradient

   !> Fewer than eight particles of a cell as lanes. Lanes without a particle repeat the last one.
   pure subroutine fill_lanes(p, last, columns, values, filled)
      integer, intent(in) :: p                               !! First particle of the lanes
      integer, intent(in) :: last                            !! Last index
      integer, intent(in) :: columns                         !! Columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of tile, column)
      real(wp), intent(inout) :: filled(lanes, columns)      !! (lane, column)
      integer :: lane, k

      do k = 1, columns
         do lane = 1, lanes
            filled(lane, k) = values(min(p + lane - 1, last), k)
         end do
      end do
   end subroutine fill_lanes

   !> Gradients of the polynomials of a vector at eight particles, component (k, l) in column
   !! k + 3 (l - 1).
   pure subroutine find_slopes(u, before, rows, local, columns, slopes)
      real(wp), intent(in) :: u(4, lanes)                    !! (component, term) Coefficients
      integer, intent(in) :: before                          !! Rows before the lanes
      integer, intent(in) :: rows                            !! Length of the next
      real(wp), intent(in) :: local(rows, 3)                 !! (lane, 3) Local coordinates [1]
      integer, intent(in) :: columns                         !! Length of a column of the next
      real(wp), intent(inout) :: slopes(columns, 9)          !! (lane, component)
      integer :: k, l

      do l = 1, 3
         do k = 1, 3
            call find_slope(u(k, across(1, l)), u(k, across(2, l)), u(k, across(3, l)), &
               u(k, lanes), local(before + 1, one(l)), local(before + 1, other(l)), &
               slopes(before + 1, k + 3*(l - 1)))
         end do
      end do
   end subroutine find_slopes

   !> Slope along one direction from the terms that have its coordinate.
   pure subroutine find_slope(u1, u2, u3, u4, one, other, slopes)
      real(wp), intent(in) :: u1, u2, u3, u4                 !! Coefficients
      real(wp), intent(in) :: one(lanes)                     !! (lane) Coordinate along one [1]
      real(wp), intent(in) :: other(lanes)                   !! (lane) Along the other one [1]
      real(wp), intent(inout) :: slopes(lanes)               !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         slopes(lane) = (u1 + u2*one(lane)) + (u3 + u4*one(lane))*other(lane)
      end do
   end subroutine find_slope

   !> Gradients of the polynomials of a vector at eight particles, blended with the values of the
   !! polynomials of a tensor.
   ! gate: long kernel because its columns have lengths of their own
   pure subroutine blend_slopes(u, w, before, rows, local, shares, alpha, columns, slopes)
      real(wp), intent(in) :: u(4, lanes) !! (component, term) Coefficients of the vector
      real(wp), intent(in) :: w(tensor, lanes) !! (component, term) Coefficients of the tensor
      integer, intent(in) :: before                          !! Rows before the lanes
      integer, intent(in) :: rows                            !! Length of the next
      real(wp), intent(in) :: local(rows, 3)                 !! (lane, 3) Local coordinates [1]
      integer, intent(in) :: shares                          !! Length of a column of the next
      real(wp), intent(in) :: alpha(shares, 3)               !! (lane, 3) Weight of the vector [1]
      integer, intent(in) :: columns                         !! Length of a column of the next
      real(wp), intent(inout) :: slopes(columns, 9)          !! (lane, component)
      integer :: k, l

      ! one call, so that it is inlined: otherwise passing arguments costs as much as the work
      do l = 1, 3
         do k = 1, 3
            call blend(u(k, across(1, l)), u(k, across(2, l)), u(k, across(3, l)), u(k, lanes), &
               local(before + 1, one(l)), local(before + 1, other(l)), w(k + 3*(l - 1), 1), &
               local(before + 1, 1), local(before + 1, 2), local(before + 1, 3), &
               alpha(before + 1, l), slopes(before + 1, k + 3*(l - 1)))
         end do
      end do
   end subroutine blend_slopes

   !> Slope along one direction, blended with the value of another polynomial.
   ! gate: long kernel because coefficients in registers are twelve numbers
   pure subroutine blend(u1, u2, u3, u4, one, other, w, x, y, z, alpha, slopes)
      real(wp), intent(in) :: u1, u2, u3, u4                 !! Coefficients of the slope
      real(wp), intent(in) :: one(lanes)                     !! (lane) Coordinate along one [1]
      real(wp), intent(in) :: other(lanes)                   !! (lane) Along the other one [1]
      real(wp), intent(in) :: w(tensor*(lanes - 1) + 1)      !! Each twelfth a coefficient
      real(wp), intent(in) :: x(lanes), y(lanes), z(lanes)   !! (lane) Local coordinates [1]
      real(wp), intent(in) :: alpha(lanes)                   !! (lane) Fraction of the slope [1]
      real(wp), intent(inout) :: slopes(lanes)               !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         slopes(lane) = alpha(lane)*((u1 + u2*one(lane)) + (u3 + u4*one(lane))*other(lane)) &
            + (1.0_wp - alpha(lane))*(((w(1) + w(13)*x(lane)) &
            + (w(25) + w(37)*x(lane))*z(lane)) + ((w(49) + w(61)*x(lane)) &
            + (w(73) + w(85)*x(lane))*z(lane))*y(lane))
      end do
   end subroutine blend

   !> Velocity and position together: velocity = f velocity + sum S_i increment_i, position =
   !! position + dt sum S_i advection_i, f the flip fraction.
   pure subroutine gather_motion(grid, start, first, local, increment, advection, flip_fraction, &
      dt, velocity, position)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: increment(:, :)    !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: advection(:, :)    !! (3, node) [m/s]
      real(wp), intent(in) :: flip_fraction                  !! Fraction of the old velocity [1]
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]
      real(wp) :: u(4, lanes), c(4, lanes), place(lanes, 3), part(lanes, 3)
      integer :: cell, p, q, last, number, ways(lanes)

      if (grid%dimensions < 3) then
         call motion_plane(grid, start, first, local, increment, advection, flip_fraction, dt, &
            velocity, position)
         return
      end if
      ways = 3*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_terms(3, 4, grid%first_node(cell), ways, size(increment), increment, 1.0_wp, u)
         call find_terms(3, 4, grid%first_node(cell), ways, size(advection), advection, dt, c)
         do p = start(cell) + 1, start(cell + 1), lanes
            last = min(p + lanes - 1, start(cell + 1))
            q = first + p - 1
            if (last == p + lanes - 1) then
               call add_vectors(u, flip_fraction, p - 1, size(local, 1), local, q - 1, &
                  size(velocity, 1), velocity)
               call add_vectors(c, 1.0_wp, p - 1, size(local, 1), local, q - 1, &
                  size(position, 1), position)
               cycle
            end if
            number = last - p + 1
            call fill_lanes(p, last, 3, local, place)
            call fill_lanes(q, q + number - 1, 3, velocity, part)
            call add_vectors(u, flip_fraction, 0, lanes, place, 0, lanes, part)
            velocity(q:q + number - 1, :) = part(:number, :)
            call fill_lanes(q, q + number - 1, 3, position, part)
            call add_vectors(c, 1.0_wp, 0, lanes, place, 0, lanes, part)
            position(q:q + number - 1, :) = part(:number, :)
         end do
      end do
   end subroutine gather_motion

   !> Add the values of the polynomials of a vector to a fraction of the vectors of eight particles.
   pure subroutine add_vectors(u, kept, before, rows, local, ahead, columns, values)
      real(wp), intent(in) :: u(4, lanes)                    !! (component, term) Coefficients
      real(wp), intent(in) :: kept                           !! Fraction of the old values [1]
      integer, intent(in) :: before                          !! Rows before the lanes
      integer, intent(in) :: rows                            !! Length of the next
      real(wp), intent(in) :: local(rows, 3)                 !! (lane, 3) Local coordinates [1]
      integer, intent(in) :: ahead                           !! Rows of vectors before the lanes
      integer, intent(in) :: columns                         !! Length of a column of the next
      real(wp), intent(inout) :: values(columns, 3)          !! (lane, component)
      integer :: k

      do k = 1, 3
         call add_lanes(u(k, 1), kept, local(before + 1, 1), local(before + 1, 2), &
            local(before + 1, 3), values(ahead + 1, k))
      end do
   end subroutine add_vectors

   !> The same for one component.
   pure subroutine add_lanes(u, kept, x, y, z, values)
      real(wp), intent(in) :: u(4*(lanes - 1) + 1)           !! Each fourth a coefficient
      real(wp), intent(in) :: kept                           !! Fraction of the old values [1]
      real(wp), intent(in) :: x(lanes), y(lanes), z(lanes)   !! (lane) Local coordinates [1]
      real(wp), intent(inout) :: values(lanes)               !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         values(lane) = kept*values(lane) + (((u(1) + u(5)*x(lane)) &
            + (u(9) + u(13)*x(lane))*z(lane)) + ((u(17) + u(21)*x(lane)) &
            + (u(25) + u(29)*x(lane))*z(lane))*y(lane))
      end do
   end subroutine add_lanes

end module transfer_gather
