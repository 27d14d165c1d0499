! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles with the linear functions of the cell.
!!
!! Between its nodes a field is a polynomial with the terms 1, x, z, xz, y, xy, yz, xyz of the place
!! in the cell. Its coefficients are found once a cell, as differences, so a uniform field has a
!! gradient of exactly zero; then eight particles of the cell at a time are the lanes. A
!! value costs 7 products instead of 8 and no weights, a slope 3 instead of 8.
module transfer_gather
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   use transfer_gather_values, only: gather_hoop, gather_values, gather_vector
   implicit none
   private

   public :: gather_gradient, gather_dual_gradient, gather_hoop, gather_motion, gather_values, &
      gather_vector, locate

   integer, parameter :: products = 7   !! Of places: x, z, xz, y, xy, yz, xyz

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
            local(p, direction) = place - real(int(place), wp)
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
      real(wp) :: u(4, lanes), terms(lanes, products), slopes(lanes, 9)
      integer :: cell, p, last, column, lane, offset(lanes)

      offset = 3*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_vectors(3*(grid%first_node(cell) - 1), offset, size(nodes), nodes, &
            scale/grid%spacing, u)
         do p = start(cell) + 1, start(cell + 1), lanes
            last = min(p + lanes - 1, start(cell + 1))
            ! the choice stands at each call of find_terms: within, it costs a hundredth of a step
            if (last == p + lanes - 1) then
               call multiply(p - 1, size(local, 1), local, terms)
               call find_slopes(u, terms, p - 1, size(gradient, 1), gradient)
            else
               call find_terms(p, last, local, terms)
               call find_slopes(u, terms, 0, lanes, slopes)
               do column = 1, 9
                  do lane = 1, last - p + 1
                     gradient(p + lane - 1, column) = slopes(lane, column)
                  end do
               end do
            end if
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
      real(wp) :: u(9, lanes), terms(lanes, products), means(lanes, 9)
      integer :: cell, p, last, column, lane, l, offset(lanes)

      offset = 9*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_tensors(9*(grid%first_node(cell) - 1), offset, size(nodes), nodes, &
            scale, u)
         do p = start(cell) + 1, start(cell + 1), lanes
            last = min(p + lanes - 1, start(cell + 1))
            if (last == p + lanes - 1) then
               call multiply(p - 1, size(local, 1), local, terms)
            else
               call find_terms(p, last, local, terms)
            end if
            call evaluate(grid%dimensions, 9, 9, u, terms, means)
            do column = 1, 9
               l = (column + 2)/3
               if (last == p + lanes - 1) then
                  call blend(p - 1, size(alpha, 1), alpha(:, l), means(1, column), &
                     size(gradient, 1), gradient(:, column))
               else
                  do lane = 1, last - p + 1
                     gradient(p + lane - 1, column) = alpha(p + lane - 1, l) &
                        *gradient(p + lane - 1, column) &
                        + (1.0_wp - alpha(p + lane - 1, l))*means(lane, column)
                  end do
               end if
            end do
         end do
      end do
   end subroutine gather_dual_gradient

   !> Blend two values of eight particles.
   pure subroutine blend(before, alphas, alpha, other, rows, values)
      integer, intent(in) :: before                          !! Particles before them
      integer, intent(in) :: alphas                          !! Length of the next
      real(wp), intent(in) :: alpha(alphas)                  !! (particle) Share of the values
      real(wp), intent(in) :: other(lanes)                   !! (lane) Takes the rest
      integer, intent(in) :: rows                            !! Length of the next
      real(wp), intent(inout) :: values(rows)                !! (particle)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         values(before + lane) = alpha(before + lane)*values(before + lane) &
            + (1.0_wp - alpha(before + lane))*other(lane)
      end do
   end subroutine blend

   !> Add to values of eight particles, of which a share is kept.
   pure subroutine add_lanes(keep, gain, before, rows, values)
      real(wp), intent(in) :: keep                           !! Share that is kept
      real(wp), intent(in) :: gain(lanes)                    !! (lane) What is added
      integer, intent(in) :: before                          !! Particles before them
      integer, intent(in) :: rows                            !! Length of the next
      real(wp), intent(inout) :: values(rows)                !! (particle)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         values(before + lane) = keep*values(before + lane) + gain(lane)
      end do
   end subroutine add_lanes

   !> Products of the places of fewer than eight particles of a cell, the lanes: x, z, xz, y, xy,
   !! yz, xyz. Lanes without a particle repeat the last one.
   pure subroutine find_terms(p, last, local, terms)
      integer, intent(in) :: p                               !! First particle of the lanes
      integer, intent(in) :: last                            !! Last one
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), intent(inout) :: terms(lanes, products)      !! (lane, product) [1]
      real(wp) :: place(lanes, 3)
      integer :: lane, q, k

      do k = 1, 3
         do lane = 1, lanes
            q = min(p + lane - 1, last)
            place(lane, k) = local(q, k)
         end do
      end do
      call multiply(0, lanes, place, terms)
   end subroutine find_terms

   !> Products of the places of eight particles.
   pure subroutine multiply(before, rows, local, terms)
      integer, intent(in) :: before                          !! Particles before them
      integer, intent(in) :: rows                            !! Length of a column
      real(wp), intent(in) :: local(rows, 3)                 !! (particle, 3) Places in the cell [1]
      real(wp), intent(inout) :: terms(lanes, products)      !! (lane, product) [1]
      real(wp) :: x, y, z
      integer :: lane

      !$omp simd private(x, y, z)
      do lane = 1, lanes
         x = local(before + lane, 1)
         y = local(before + lane, 2)
         z = local(before + lane, 3)
         terms(lane, 1) = x
         terms(lane, 2) = z
         terms(lane, 3) = x*z
         terms(lane, 4) = y
         terms(lane, 5) = x*y
         terms(lane, 6) = z*y
         terms(lane, 7) = x*z*y
      end do
   end subroutine multiply

   !> Values of polynomials of a cell.
   pure subroutine evaluate(dimensions, number, rows, u, terms, values)
      integer, intent(in) :: dimensions                      !! Directions that the scene has
      integer, intent(in) :: number                          !! Of polynomials
      integer, intent(in) :: rows                            !! Rows of the coefficients
      real(wp), intent(in) :: u(rows, lanes)                 !! (polynomial, term) Coefficients
      real(wp), intent(in) :: terms(lanes, products)         !! (lane, product) of the places [1]
      real(wp), intent(inout) :: values(lanes, number)       !! (lane, polynomial)
      integer :: c

      ! products with the place along a missing direction are zero, and left out
      do c = 1, number
         if (dimensions == 3) then
            call evaluate_space(u(c, 1), u(c, 2), u(c, 3), u(c, 4), u(c, 5), u(c, 6), u(c, 7), &
               u(c, 8), terms, values(1, c))
         else
            call evaluate_plane(u(c, 1), u(c, 2), u(c, 3), u(c, 4), terms, values(1, c))
         end if
      end do
   end subroutine evaluate

   !> Values of a polynomial with all terms.
   ! gate: long kernel because coefficients in registers are eight numbers
   pure subroutine evaluate_space(u1, u2, u3, u4, u5, u6, u7, u8, terms, values)
      real(wp), intent(in) :: u1, u2, u3, u4, u5, u6, u7, u8 !! Coefficients
      real(wp), intent(in) :: terms(lanes, products)         !! (lane, product) of the places [1]
      real(wp), intent(inout) :: values(lanes)               !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         values(lane) = ((u1 + u2*terms(lane, 1)) + (u3*terms(lane, 2) + u4*terms(lane, 3))) &
            + ((u5*terms(lane, 4) + u6*terms(lane, 5)) + (u7*terms(lane, 6) + u8*terms(lane, 7)))
      end do
   end subroutine evaluate_space

   !> Values of a polynomial of x and z.
   pure subroutine evaluate_plane(u1, u2, u3, u4, terms, values)
      real(wp), intent(in) :: u1, u2, u3, u4                 !! Coefficients
      real(wp), intent(in) :: terms(lanes, products)         !! (lane, product) of the places [1]
      real(wp), intent(inout) :: values(lanes)               !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         values(lane) = (u1 + u2*terms(lane, 1)) + (u3*terms(lane, 2) + u4*terms(lane, 3))
      end do
   end subroutine evaluate_plane

   !> Gradients of the polynomials of a vector, component (k, l) in column k + 3 (l - 1).
   pure subroutine find_slopes(u, terms, before, rows, slopes)
      real(wp), intent(in) :: u(4, lanes)                    !! (component, term) Coefficients
      real(wp), intent(in) :: terms(lanes, products)         !! (lane, product) of the places [1]
      integer, intent(in) :: before                          !! Rows before the lanes
      integer, intent(in) :: rows                            !! Length of a column
      real(wp), intent(inout) :: slopes(rows, 9)             !! (lane, component)
      integer :: k

      do k = 1, 3
         call find_slope(u(k, 2), u(k, 4), u(k, 6), u(k, 8), terms(1, 2), terms(1, 4), &
            terms(1, 6), slopes(before + 1, k))
         call find_slope(u(k, 5), u(k, 6), u(k, 7), u(k, 8), terms(1, 1), terms(1, 2), &
            terms(1, 3), slopes(before + 1, k + 3))
         call find_slope(u(k, 3), u(k, 4), u(k, 7), u(k, 8), terms(1, 1), terms(1, 4), &
            terms(1, 5), slopes(before + 1, k + 6))
      end do
   end subroutine find_slopes

   !> Slope along one direction from the terms that have its place.
   pure subroutine find_slope(u1, u2, u3, u4, one, other, both, slopes)
      real(wp), intent(in) :: u1, u2, u3, u4                 !! Coefficients
      real(wp), intent(in) :: one(lanes)                     !! (lane) Place along one direction [1]
      real(wp), intent(in) :: other(lanes)                   !! (lane) Along the other one [1]
      real(wp), intent(in) :: both(lanes)                    !! (lane) Their product [1]
      real(wp), intent(inout) :: slopes(lanes)               !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         slopes(lane) = (u1 + u2*one(lane)) + (u3*other(lane) + u4*both(lane))
      end do
   end subroutine find_slope

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
      real(wp) :: u(4, lanes), c(4, lanes), terms(lanes, products), gain(lanes, 3), way(lanes, 3)
      integer :: cell, p, q, last, lane, k, offset(lanes)

      offset = 3*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_vectors(3*(grid%first_node(cell) - 1), offset, size(push), push, 1.0_wp, u)
         call find_vectors(3*(grid%first_node(cell) - 1), offset, size(carry), carry, dt, c)
         do p = start(cell) + 1, start(cell + 1), lanes
            last = min(p + lanes - 1, start(cell + 1))
            q = first + p - 2
            if (last == p + lanes - 1) then
               call multiply(p - 1, size(local, 1), local, terms)
            else
               call find_terms(p, last, local, terms)
            end if
            call evaluate(grid%dimensions, 3, 4, u, terms, gain)
            call evaluate(grid%dimensions, 3, 4, c, terms, way)
            do k = 1, 3
               if (last == p + lanes - 1) then
                  call add_lanes(keep, gain(1, k), q, size(velocity, 1), velocity(:, k))
                  call add_lanes(1.0_wp, way(1, k), q, size(position, 1), position(:, k))
               else
                  do lane = 1, last - p + 1
                     velocity(q + lane, k) = keep*velocity(q + lane, k) + gain(lane, k)
                     position(q + lane, k) = position(q + lane, k) + way(lane, k)
                  end do
               end if
            end do
         end do
      end do
   end subroutine gather_motion

   !> Coefficients of the polynomials of the three components of a vector in a cell, the terms being
   !! 1, x, z, xz, y, xy, yz, xyz. The nodes come as one row of numbers: with the first number
   !! of the next node a vector has four, which are the lanes. The fourth has no meaning.
   pure subroutine find_vectors(before, offset, numbers, nodes, scale, u)
      integer, intent(in) :: before                          !! Numbers before the first node
      integer, intent(in) :: offset(lanes)                   !! Numbers from there to a node
      integer, intent(in) :: numbers                         !! Three a node of the tile
      real(wp), intent(in) :: nodes(numbers)                 !! (component and node)
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), intent(inout) :: u(4, lanes)                 !! (component, term)
      integer :: lane, c

      if (before + offset(lanes) + 4 <= numbers) then
         do lane = 1, lanes
            !$omp simd
            do c = 1, 4
               u(c, lane) = scale*nodes(before + offset(lane) + c)
            end do
         end do
      else
         do lane = 1, lanes
            do c = 1, 3
               u(c, lane) = scale*nodes(before + offset(lane) + c)
            end do
            u(4, lane) = 0.0_wp
         end do
      end if
      !$omp simd
      do c = 1, 4
         call take_differences(u(c, 1), u(c, 2), u(c, 3), u(c, 4), u(c, 5), u(c, 6), u(c, 7), &
            u(c, 8))
      end do
   end subroutine find_vectors

   !> Coefficients of the polynomials of the nine components of a tensor in a cell, terms as above.
   pure subroutine find_tensors(before, offset, numbers, nodes, scale, u)
      integer, intent(in) :: before                          !! Numbers before the first node
      integer, intent(in) :: offset(lanes)                   !! Numbers from there to a node
      integer, intent(in) :: numbers                         !! Nine a node of the tile
      real(wp), intent(in) :: nodes(numbers)                 !! (component and node)
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), intent(inout) :: u(9, lanes)                 !! (component, term)
      integer :: lane, c

      do lane = 1, lanes
         !$omp simd
         do c = 1, 9
            u(c, lane) = scale*nodes(before + offset(lane) + c)
         end do
      end do
      !$omp simd
      do c = 1, 9
         call take_differences(u(c, 1), u(c, 2), u(c, 3), u(c, 4), u(c, 5), u(c, 6), u(c, 7), &
            u(c, 8))
      end do
   end subroutine find_tensors

   !> From the values on the eight nodes of a cell to the coefficients of its polynomial:
   !! differences along x, then z, then y, of which a missing direction has none.
   pure subroutine take_differences(u1, u2, u3, u4, u5, u6, u7, u8)
      real(wp), intent(inout) :: u1, u2, u3, u4, u5, u6, u7, u8 !! Node in, term out

      u2 = u2 - u1
      u4 = u4 - u3
      u6 = u6 - u5
      u8 = u8 - u7
      u3 = u3 - u1
      u4 = u4 - u2
      u7 = u7 - u5
      u8 = u8 - u6
      u5 = u5 - u1
      u6 = u6 - u2
      u7 = u7 - u3
      u8 = u8 - u4
   end subroutine take_differences
end module transfer_gather
