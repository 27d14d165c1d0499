! SPDX-License-Identifier: BSD-3-Clause
!> From nodes to particles in three dimensions, with shape functions that are products of functions
!! of one coordinate.
!!
!! Four columns of the nodes are the lanes, and the particles are processed one by one. Lines of
!! nodes are contracted along x first, with functions and derivatives, then lines along y, then
!! layers along z. There are kernels for particles that touch three and four nodes along each
!! direction. The functions of some particles are copied to an array with a compile-time stride.
module transfer_spline_gather
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line, spline_data_t
   implicit none
   private

   public :: gather_spline_gradient, gather_spline_motion, gather_spline_values

   integer, parameter :: lanes = 4                   !! Columns that are found at once
   integer, parameter :: batch = 60                  !! Particles whose functions are copied at once

contains

   !> Values sum S_i node_i of any number of columns.
   pure subroutine gather_spline_values(grid, count, spline, nodes, skip, values)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: count                           !! Particles of the tile
      type(spline_data_t), intent(in) :: spline
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      integer, intent(in) :: skip                            !! Column offset in the values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: wide(lanes, size(nodes, 2)), weight(batch, line, 3), found(lanes, batch)
      integer :: first, c, before, number, p, low, high

      call spline%touched(grid, count, low, high)
      do first = 1, size(nodes, 1), lanes
         call widen(size(nodes, 1), first, low, high, size(nodes, 2), nodes, wide)
         do before = 0, count - 1, batch
            number = min(batch, count - before)
            call copy_functions(spline%reach, before, number, size(spline%weight, 1), &
               spline%weight, weight)
            call find_values(spline%reach, number, weight, spline%node(before + 1:), &
               grid%stride, size(nodes, 2), wide, found)
            do c = first, min(first + lanes - 1, size(nodes, 1))
               do p = 1, number
                  values(before + p, skip + c) = found(c - first + 1, p)
               end do
            end do
         end do
      end do
   end subroutine gather_spline_values

   !> Velocities and positions of particles: a fraction of the old velocity plus the increment of
   !! the nodes, and the displacement with a node velocity. The functions are copied once for both.
   pure subroutine gather_spline_motion(grid, count, spline, first, increment, advection, kept, &
      dt, velocity, position)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: count                           !! Particles of the tile
      type(spline_data_t), intent(in) :: spline
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: increment(:, :)    !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: advection(:, :)    !! (3, node) [m/s]
      real(wp), intent(in) :: kept                           !! Fraction of the old velocity [1]
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]
      real(wp) :: push(lanes, size(increment, 2)), carry(lanes, size(advection, 2))
      real(wp) :: weight(batch, line, 3), gain(lanes, batch), way(lanes, batch)
      integer :: k, before, number, p, q, low, high

      call spline%touched(grid, count, low, high)
      call widen(3, 1, low, high, size(increment, 2), increment, push)
      call widen(3, 1, low, high, size(advection, 2), advection, carry)
      do before = 0, count - 1, batch
         number = min(batch, count - before)
         call copy_functions(spline%reach, before, number, size(spline%weight, 1), &
            spline%weight, weight)
         call find_values(spline%reach, number, weight, spline%node(before + 1:), grid%stride, &
            size(increment, 2), push, gain)
         call find_values(spline%reach, number, weight, spline%node(before + 1:), grid%stride, &
            size(advection, 2), carry, way)
         do k = 1, 3
            do p = 1, number
               q = first - 1 + before + p
               velocity(q, k) = kept*velocity(q, k) + 1.0_wp*gain(k, p)
               position(q, k) = 1.0_wp*position(q, k) + dt*way(k, p)
            end do
         end do
      end do
   end subroutine gather_spline_motion

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l.
   pure subroutine gather_spline_gradient(grid, count, spline, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: count                           !! Particles of the tile
      type(spline_data_t), intent(in) :: spline
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: wide(lanes, size(nodes, 2)), found(lanes, 3, batch)
      real(wp), dimension(batch, line, 3) :: weight, slope
      integer :: before, number, p, k, l, low, high

      call spline%touched(grid, count, low, high)
      call widen(3, 1, low, high, size(nodes, 2), nodes, wide)
      do before = 0, count - 1, batch
         number = min(batch, count - before)
         call copy_functions(spline%reach, before, number, size(spline%weight, 1), &
            spline%weight, weight)
         call copy_functions(spline%reach, before, number, size(spline%slope, 1), spline%slope, &
            slope)
         if (spline%reach == 3) then
            call find_slopes_three(number, weight, slope, spline%node(before + 1:), grid%stride, &
               size(nodes, 2), wide, found)
         else
            call find_slopes_four(number, weight, slope, spline%node(before + 1:), grid%stride, &
               size(nodes, 2), wide, found)
         end if
         do l = 1, 3
            do k = 1, 3
               do p = 1, number
                  gradient(before + p, k + 3*(l - 1)) = scale*found(k, l, p)
               end do
            end do
         end do
      end do
   end subroutine gather_spline_gradient

   !> Up to four columns of the nodes of a tile that particles touch; missing columns repeat the
   !! last one.
   pure subroutine widen(columns, first, low, high, number, nodes, wide)
      integer, intent(in) :: columns                         !! Columns of the nodes
      integer, intent(in) :: first                           !! First particle
      integer, intent(in) :: low, high                       !! First and last node
      integer, intent(in) :: number                          !! Nodes
      real(wp), intent(in) :: nodes(columns, number)         !! (column, node)
      real(wp), intent(inout) :: wide(lanes, number)         !! (lane, node)
      integer :: at(lanes), n

      at = min(first + [0, 1, 2, 3], columns)
      do n = low, high
         wide(1, n) = nodes(at(1), n)
         wide(2, n) = nodes(at(2), n)
         wide(3, n) = nodes(at(3), n)
         wide(4, n) = nodes(at(4), n)
      end do
   end subroutine widen

   !> Functions of some particles.
   pure subroutine copy_functions(reach, before, number, rows, functions, copy)
      integer, intent(in) :: reach                           !! Nodes along a line
      integer, intent(in) :: before                          !! Index offset
      integer, intent(in) :: number                          !! Their number
      integer, intent(in) :: rows                            !! Length of the next
      real(wp), intent(in) :: functions(rows, line, 3)       !! (particle, node, direction)
      real(wp), intent(inout) :: copy(batch, line, 3)        !! Functions of some particles
      integer :: p, n, direction

      do direction = 1, 3
         do n = 1, reach
            do p = 1, number
               copy(p, n, direction) = functions(before + p, n, direction)
            end do
         end do
      end do
   end subroutine copy_functions

   !> Values at some particles.
   pure subroutine find_values(reach, number, w, node, stride, nodes, u, found)
      integer, intent(in) :: reach                           !! Nodes along a line
      integer, intent(in) :: number                          !! Number of particles
      real(wp), intent(in) :: w(batch, line, 3)              !! (particle, node, direction)
      integer, contiguous, intent(in) :: node(:)             !! (particle) First node
      integer, intent(in) :: stride(3) !! Distance from node to node in the array
      integer, intent(in) :: nodes                           !! Nodes of the tile
      real(wp), intent(in) :: u(lanes, nodes)                !! (lane, node)
      real(wp), intent(inout) :: found(lanes, batch)         !! (lane, particle)

      if (reach == 3) then
         call find_values_three(number, w, node, stride, nodes, u, found)
      else
         call find_values_four(number, w, node, stride, nodes, u, found)
      end if
   end subroutine find_values

   !> Values at particles that touch three nodes along each direction.
   pure subroutine find_values_three(number, w, node, stride, nodes, u, found)
      integer, intent(in) :: number                          !! Number of particles
      real(wp), intent(in) :: w(batch, line, 3)              !! (particle, node, direction)
      integer, contiguous, intent(in) :: node(:)             !! (particle) First node
      integer, intent(in) :: stride(3) !! Distance from node to node in the array
      integer, intent(in) :: nodes                           !! Nodes of the tile
      real(wp), intent(in) :: u(lanes, nodes)                !! (lane, node)
      real(wp), intent(inout) :: found(lanes, batch)         !! (lane, particle)
      real(wp) :: layer(lanes, 3), a, b, c
      integer :: lane, p, k, at, up

      up = stride(2)
      do p = 1, number
         do k = 1, 3
            at = node(p) + (k - 1)*stride(3)
            !$omp simd private(a, b, c)
            do lane = 1, lanes
               a = (w(p, 1, 1)*u(lane, at) + w(p, 2, 1)*u(lane, at + 1)) &
                  + w(p, 3, 1)*u(lane, at + 2)
               b = (w(p, 1, 1)*u(lane, at + up) + w(p, 2, 1)*u(lane, at + up + 1)) &
                  + w(p, 3, 1)*u(lane, at + up + 2)
               c = (w(p, 1, 1)*u(lane, at + 2*up) + w(p, 2, 1)*u(lane, at + 2*up + 1)) &
                  + w(p, 3, 1)*u(lane, at + 2*up + 2)
               layer(lane, k) = (w(p, 1, 2)*a + w(p, 2, 2)*b) + w(p, 3, 2)*c
            end do
         end do
         !$omp simd
         do lane = 1, lanes
            found(lane, p) = (w(p, 1, 3)*layer(lane, 1) + w(p, 2, 3)*layer(lane, 2)) &
               + w(p, 3, 3)*layer(lane, 3)
         end do
      end do
   end subroutine find_values_three

   !> Derivatives at particles that touch three nodes along each direction.
   pure subroutine find_slopes_three(number, w, s, node, stride, nodes, u, found)
      integer, intent(in) :: number                          !! Number of particles
      real(wp), intent(in) :: w(batch, line, 3)              !! (particle, node, direction)
      real(wp), intent(in) :: s(batch, line, 3)              !! Derivatives of the functions [1/m]
      integer, contiguous, intent(in) :: node(:)             !! (particle) First node
      integer, intent(in) :: stride(3) !! Distance from node to node in the array
      integer, intent(in) :: nodes                           !! Nodes of the tile
      real(wp), intent(in) :: u(lanes, nodes)                !! (lane, node)
      real(wp), intent(inout) :: found(lanes, 3, batch)      !! (lane, direction, particle)
      real(wp), dimension(lanes, 3) :: even, odd, along
      real(wp) :: a, b, c, da, db, dc
      integer :: lane, p, k, at, up

      up = stride(2)
      do p = 1, number
         do k = 1, 3
            at = node(p) + (k - 1)*stride(3)
            !$omp simd private(a, b, c, da, db, dc)
            do lane = 1, lanes
               a = (w(p, 1, 1)*u(lane, at) + w(p, 2, 1)*u(lane, at + 1)) &
                  + w(p, 3, 1)*u(lane, at + 2)
               da = (s(p, 1, 1)*u(lane, at) + s(p, 2, 1)*u(lane, at + 1)) &
                  + s(p, 3, 1)*u(lane, at + 2)
               b = (w(p, 1, 1)*u(lane, at + up) + w(p, 2, 1)*u(lane, at + up + 1)) &
                  + w(p, 3, 1)*u(lane, at + up + 2)
               db = (s(p, 1, 1)*u(lane, at + up) + s(p, 2, 1)*u(lane, at + up + 1)) &
                  + s(p, 3, 1)*u(lane, at + up + 2)
               c = (w(p, 1, 1)*u(lane, at + 2*up) + w(p, 2, 1)*u(lane, at + 2*up + 1)) &
                  + w(p, 3, 1)*u(lane, at + 2*up + 2)
               dc = (s(p, 1, 1)*u(lane, at + 2*up) + s(p, 2, 1)*u(lane, at + 2*up + 1)) &
                  + s(p, 3, 1)*u(lane, at + 2*up + 2)
               even(lane, k) = (w(p, 1, 2)*a + w(p, 2, 2)*b) + w(p, 3, 2)*c
               odd(lane, k) = (s(p, 1, 2)*a + s(p, 2, 2)*b) + s(p, 3, 2)*c
               along(lane, k) = (w(p, 1, 2)*da + w(p, 2, 2)*db) + w(p, 3, 2)*dc
            end do
         end do
         !$omp simd
         do lane = 1, lanes
            found(lane, 1, p) = (w(p, 1, 3)*along(lane, 1) + w(p, 2, 3)*along(lane, 2)) &
               + w(p, 3, 3)*along(lane, 3)
            found(lane, 2, p) = (w(p, 1, 3)*odd(lane, 1) + w(p, 2, 3)*odd(lane, 2)) &
               + w(p, 3, 3)*odd(lane, 3)
            found(lane, 3, p) = (s(p, 1, 3)*even(lane, 1) + s(p, 2, 3)*even(lane, 2)) &
               + s(p, 3, 3)*even(lane, 3)
         end do
      end do
   end subroutine find_slopes_three

   !> Values at particles that touch four nodes along each direction.
   pure subroutine find_values_four(number, w, node, stride, nodes, u, found)
      integer, intent(in) :: number                          !! Number of particles
      real(wp), intent(in) :: w(batch, line, 3)              !! (particle, node, direction)
      integer, contiguous, intent(in) :: node(:)             !! (particle) First node
      integer, intent(in) :: stride(3) !! Distance from node to node in the array
      integer, intent(in) :: nodes                           !! Nodes of the tile
      real(wp), intent(in) :: u(lanes, nodes)                !! (lane, node)
      real(wp), intent(inout) :: found(lanes, batch)         !! (lane, particle)
      real(wp) :: layer(lanes, 4), a, b, c, d
      integer :: lane, p, k, at, up

      up = stride(2)
      do p = 1, number
         do k = 1, 4
            at = node(p) + (k - 1)*stride(3)
            !$omp simd private(a, b, c, d)
            do lane = 1, lanes
               a = (w(p, 1, 1)*u(lane, at) + w(p, 2, 1)*u(lane, at + 1)) &
                  + (w(p, 3, 1)*u(lane, at + 2) + w(p, 4, 1)*u(lane, at + 3))
               b = (w(p, 1, 1)*u(lane, at + up) + w(p, 2, 1)*u(lane, at + up + 1)) &
                  + (w(p, 3, 1)*u(lane, at + up + 2) + w(p, 4, 1)*u(lane, at + up + 3))
               c = (w(p, 1, 1)*u(lane, at + 2*up) + w(p, 2, 1)*u(lane, at + 2*up + 1)) &
                  + (w(p, 3, 1)*u(lane, at + 2*up + 2) + w(p, 4, 1)*u(lane, at + 2*up + 3))
               d = (w(p, 1, 1)*u(lane, at + 3*up) + w(p, 2, 1)*u(lane, at + 3*up + 1)) &
                  + (w(p, 3, 1)*u(lane, at + 3*up + 2) + w(p, 4, 1)*u(lane, at + 3*up + 3))
               layer(lane, k) = (w(p, 1, 2)*a + w(p, 2, 2)*b) + (w(p, 3, 2)*c + w(p, 4, 2)*d)
            end do
         end do
         !$omp simd
         do lane = 1, lanes
            found(lane, p) = (w(p, 1, 3)*layer(lane, 1) + w(p, 2, 3)*layer(lane, 2)) &
               + (w(p, 3, 3)*layer(lane, 3) + w(p, 4, 3)*layer(lane, 4))
         end do
      end do
   end subroutine find_values_four

   !> Derivatives at particles that touch four nodes along each direction.
   pure subroutine find_slopes_four(number, w, s, node, stride, nodes, u, found)
      integer, intent(in) :: number                          !! Number of particles
      real(wp), intent(in) :: w(batch, line, 3)              !! (particle, node, direction)
      real(wp), intent(in) :: s(batch, line, 3)              !! Derivatives of the functions [1/m]
      integer, contiguous, intent(in) :: node(:)             !! (particle) First node
      integer, intent(in) :: stride(3) !! Distance from node to node in the array
      integer, intent(in) :: nodes                           !! Nodes of the tile
      real(wp), intent(in) :: u(lanes, nodes)                !! (lane, node)
      real(wp), intent(inout) :: found(lanes, 3, batch)      !! (lane, direction, particle)
      real(wp), dimension(lanes, 4) :: even, odd, along
      real(wp) :: a, b, c, d, da, db, dc, dd
      integer :: lane, p, k, at, up

      up = stride(2)
      do p = 1, number
         do k = 1, 4
            at = node(p) + (k - 1)*stride(3)
            !$omp simd private(a, b, c, d, da, db, dc, dd)
            do lane = 1, lanes
               a = (w(p, 1, 1)*u(lane, at) + w(p, 2, 1)*u(lane, at + 1)) &
                  + (w(p, 3, 1)*u(lane, at + 2) + w(p, 4, 1)*u(lane, at + 3))
               da = (s(p, 1, 1)*u(lane, at) + s(p, 2, 1)*u(lane, at + 1)) &
                  + (s(p, 3, 1)*u(lane, at + 2) + s(p, 4, 1)*u(lane, at + 3))
               b = (w(p, 1, 1)*u(lane, at + up) + w(p, 2, 1)*u(lane, at + up + 1)) &
                  + (w(p, 3, 1)*u(lane, at + up + 2) + w(p, 4, 1)*u(lane, at + up + 3))
               db = (s(p, 1, 1)*u(lane, at + up) + s(p, 2, 1)*u(lane, at + up + 1)) &
                  + (s(p, 3, 1)*u(lane, at + up + 2) + s(p, 4, 1)*u(lane, at + up + 3))
               c = (w(p, 1, 1)*u(lane, at + 2*up) + w(p, 2, 1)*u(lane, at + 2*up + 1)) &
                  + (w(p, 3, 1)*u(lane, at + 2*up + 2) + w(p, 4, 1)*u(lane, at + 2*up + 3))
               dc = (s(p, 1, 1)*u(lane, at + 2*up) + s(p, 2, 1)*u(lane, at + 2*up + 1)) &
                  + (s(p, 3, 1)*u(lane, at + 2*up + 2) + s(p, 4, 1)*u(lane, at + 2*up + 3))
               d = (w(p, 1, 1)*u(lane, at + 3*up) + w(p, 2, 1)*u(lane, at + 3*up + 1)) &
                  + (w(p, 3, 1)*u(lane, at + 3*up + 2) + w(p, 4, 1)*u(lane, at + 3*up + 3))
               dd = (s(p, 1, 1)*u(lane, at + 3*up) + s(p, 2, 1)*u(lane, at + 3*up + 1)) &
                  + (s(p, 3, 1)*u(lane, at + 3*up + 2) + s(p, 4, 1)*u(lane, at + 3*up + 3))
               even(lane, k) = (w(p, 1, 2)*a + w(p, 2, 2)*b) + (w(p, 3, 2)*c + w(p, 4, 2)*d)
               odd(lane, k) = (s(p, 1, 2)*a + s(p, 2, 2)*b) + (s(p, 3, 2)*c + s(p, 4, 2)*d)
               along(lane, k) = (w(p, 1, 2)*da + w(p, 2, 2)*db) + (w(p, 3, 2)*dc + w(p, 4, 2)*dd)
            end do
         end do
         !$omp simd
         do lane = 1, lanes
            found(lane, 1, p) = (w(p, 1, 3)*along(lane, 1) + w(p, 2, 3)*along(lane, 2)) &
               + (w(p, 3, 3)*along(lane, 3) + w(p, 4, 3)*along(lane, 4))
            found(lane, 2, p) = (w(p, 1, 3)*odd(lane, 1) + w(p, 2, 3)*odd(lane, 2)) &
               + (w(p, 3, 3)*odd(lane, 3) + w(p, 4, 3)*odd(lane, 4))
            found(lane, 3, p) = (s(p, 1, 3)*even(lane, 1) + s(p, 2, 3)*even(lane, 2)) &
               + (s(p, 3, 3)*even(lane, 3) + s(p, 4, 3)*even(lane, 4))
         end do
      end do
   end subroutine find_slopes_four
end module transfer_spline_gather
