! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles with the linear functions of the cell.
!!
!! Between its nodes a field is a polynomial with the terms 1, x, z, xz, y, xy, yz, xyz of the local
!! coordinates, in a plane the first four. Its coefficients are found once a cell, as differences,
!! so a uniform field has a gradient of exactly zero, with four components as lanes; then the
!! particles of the cell are the lanes, eight in three dimensions and four in a plane. A value costs
!! 7 products instead of 8 and no weights, a slope 3 instead of 8. The number of terms is a constant
!! at each call, so a plane has no work for the others; gradients and motion have kernels of their
!! own there.
!!
!! The last lanes of a cell may hold particles of the next cells or none. Their values are
!! overwritten when those cells are processed, so cells are processed in order, and columns have
!! `spare` rows after the last particle.
module transfer_gather
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   use transfer_gather_plane, only: dual_gradient_plane, linear_gradient_plane, motion_plane
   implicit none
   private

   public :: find_polynomial, gather_dual_gradient, gather_gradient, gather_hoop, gather_motion, &
      gather_values

   integer, parameter :: half = lanes/2              !! Terms in a plane, and particles at a time
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
         call linear_gradient_plane(grid, start, local, nodes, scale, gradient)
         return
      end if
      ways = 3*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_terms(lanes, 3, 4, grid%first_node(cell), ways, size(nodes), nodes, &
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
         call find_terms(lanes, 3, 4, grid%first_node(cell), ways, size(velocity), velocity, &
            scale/grid%spacing, u)
         call find_terms(lanes, 9, tensor, grid%first_node(cell), far, size(nodes), nodes, scale, w)
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
   ! The coefficients are scalars, so that they stay in registers.
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
         call find_terms(lanes, 3, 4, grid%first_node(cell), ways, size(increment), increment, &
            1.0_wp, u)
         call find_terms(lanes, 3, 4, grid%first_node(cell), ways, size(advection), advection, &
            dt, c)
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
      real(wp) :: x, z
      integer :: k, lane

      do k = 1, 3
         !$omp simd private(x, z)
         do lane = 1, lanes
            x = local(before + lane, 1)
            z = local(before + lane, 3)
            values(ahead + lane, k) = kept*values(ahead + lane, k) + (((u(k, 1) + u(k, 2)*x) &
               + (u(k, 3) + u(k, 4)*x)*z) + ((u(k, 5) + u(k, 6)*x) &
               + (u(k, 7) + u(k, 8)*x)*z)*local(before + lane, 2))
         end do
      end do
   end subroutine add_vectors

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
         do p = start(cell) + 1, start(cell + 1), half
            call evaluate(half, 1, 1, u, p - 1, size(local, 1), local, size(gradient, 1), &
               gradient(:, 5))
         end do
      end do
      do p = 1, start(grid%tile_cells)
         gradient(p, 5) = gradient(p, 5)/position(first + p - 1, 1)
      end do
   end subroutine gather_hoop

   !> Values sum S_i node_i of any number of columns.
   pure subroutine gather_values(grid, start, local, nodes, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      integer :: rows

      rows = 4*((size(nodes, 1) + 3)/4)
      if (grid%dimensions == 3) then
         call gather_columns(lanes, grid, start, local, rows, nodes, values)
      else
         call gather_columns(half, grid, start, local, rows, nodes, values)
      end if
   end subroutine gather_values

   !> The same for a compile-time number of terms.
   pure subroutine gather_columns(terms, grid, start, local, rows, nodes, values)
      integer, intent(in) :: terms !! Terms of a polynomial, and particles at a time
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      integer, intent(in) :: rows                            !! Columns, a multiple of four
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: u(rows, terms)
      integer :: cell, p, ways(lanes)

      ways = size(nodes, 1)*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_terms(terms, size(nodes, 1), rows, grid%first_node(cell), ways, size(nodes), &
            nodes, 1.0_wp, u)
         do p = start(cell) + 1, start(cell + 1), terms
            call evaluate(terms, size(nodes, 1), rows, u, p - 1, size(local, 1), local, &
               size(values, 1), values)
         end do
      end do
   end subroutine gather_columns

   !> Values of polynomials at eight particles in space, at four in a plane.
   pure subroutine evaluate(terms, columns, rows, u, before, length, local, depth, values)
      integer, intent(in) :: terms                           !! Terms, and particles
      integer, intent(in) :: columns                         !! Number of columns of the values
      integer, intent(in) :: rows !! Columns, rounded up to a multiple of four
      real(wp), intent(in) :: u(rows, terms)                 !! (column, term) Coefficients
      integer, intent(in) :: before                          !! Particles before them
      integer, intent(in) :: length                          !! Length of a column of `local`
      real(wp), intent(in) :: local(length, 3)               !! (particle, 3) Local coordinates
      integer, intent(in) :: depth                           !! Length of a column of `values`
      real(wp), intent(inout) :: values(depth, columns)      !! (particle, column)
      real(wp) :: x, z, value
      integer :: c, p

      do c = 1, columns
         !$omp simd private(x, z, value)
         do p = before + 1, before + terms
            x = local(p, 1)
            z = local(p, 3)
            value = (u(c, 1) + u(c, 2)*x) + (u(c, 3) + u(c, 4)*x)*z
            if (terms == lanes) value = value + ((u(c, 5) + u(c, 6)*x) &
               + (u(c, 7) + u(c, 8)*x)*z)*local(p, 2)
            values(p, c) = value
         end do
      end do
   end subroutine evaluate

   !> Coefficients of the polynomial of one component of a node field in a cell, by differences
   !! along x, then z, then y; those of a missing direction are not found.
   pure subroutine find_polynomial(grid, cell, component, scale, nodes, u)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      integer, intent(in) :: component                       !! Component of the field
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (component, node)
      real(wp), intent(inout) :: u(lanes) !! Coefficients of 1, x, z, xz, y, xy, yz, xyz
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

   !> Coefficients of the polynomials of the components of a field in a cell, the terms being 1, x,
   !! z, xz, y, xy, yz, xyz, in a plane the first four. The node field is a one-dimensional array
   !! with four elements as lanes: elements of the next node fill the lanes up to a multiple of
   !! four, and have no meaning.
   pure subroutine find_terms(terms, components, rows, node, ways, numbers, nodes, scale, u)
      integer, intent(in) :: terms                   !! Number of terms
      integer, intent(in) :: components              !! Numbers per node
      integer, intent(in) :: rows                    !! Columns, rounded up to a multiple of four
      integer, intent(in) :: node                    !! First node of the cell
      integer, intent(in) :: ways(lanes)             !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(rows, terms)      !! (component, term)
      integer :: part, before

      before = components*(node - 1)
      if (before + ways(terms) + rows > numbers) then
         call find_last_terms(terms, components, rows, before, ways, numbers, nodes, scale, u)
         return
      end if
      do part = 0, rows - 1, 4
         call take_differences(terms, before + part, ways, numbers, nodes, scale, rows, &
            u(part + 1, 1))
      end do
   end subroutine find_terms

   !> The same for a cell with the last node of the tile, at the end of the array.
   pure subroutine find_last_terms(terms, components, rows, before, ways, numbers, nodes, scale, u)
      integer, intent(in) :: terms                   !! Number of terms
      integer, intent(in) :: components              !! Numbers per node
      integer, intent(in) :: rows                    !! Columns, rounded up to a multiple of four
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(lanes)             !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(rows, terms)      !! (component, term)
      real(wp) :: padded(rows, lanes)
      integer :: part, lane

      padded = 0.0_wp
      do lane = 1, terms
         padded(:components, lane) = nodes(before + ways(lane) + 1:before + ways(lane) + components)
      end do
      do part = 0, rows - 1, 4
         call take_differences(terms, part, [(rows*(lane - 1), lane=1, lanes)], size(padded), &
            padded, scale, rows, u(part + 1, 1))
      end do
   end subroutine find_last_terms

   !> From the values on the nodes of a cell to the coefficients of its polynomial: differences
   !! along x, then z, then y. Four components are the lanes.
   pure subroutine take_differences(terms, before, ways, numbers, nodes, scale, rows, u)
      integer, intent(in) :: terms                   !! Number of terms
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(lanes)             !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      integer, intent(in) :: rows                    !! Distance between terms in the array
      real(wp), intent(inout) :: u(rows*(terms - 1) + 4) !! (component and term)
      real(wp) :: u1, u2, u3, u4, u5, u6, u7, u8
      integer :: c

      !$omp simd private(u1, u2, u3, u4, u5, u6, u7, u8)
      do c = 1, 4
         u1 = scale*nodes(before + c)
         u2 = scale*nodes(before + ways(2) + c) - u1
         u3 = scale*nodes(before + ways(3) + c)
         u4 = (scale*nodes(before + ways(4) + c) - u3) - u2
         u3 = u3 - u1
         u(c) = u1
         u(rows + c) = u2
         u(2*rows + c) = u3
         u(3*rows + c) = u4
         if (terms < lanes) cycle
         u5 = scale*nodes(before + ways(5) + c)
         u6 = scale*nodes(before + ways(6) + c) - u5
         u7 = scale*nodes(before + ways(7) + c)
         u8 = (scale*nodes(before + ways(8) + c) - u7) - u6
         u7 = u7 - u5
         u(4*rows + c) = u5 - u1
         u(5*rows + c) = u6 - u2
         u(6*rows + c) = u7 - u3
         u(7*rows + c) = u8 - u4
      end do
   end subroutine take_differences
end module transfer_gather
