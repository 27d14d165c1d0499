! SPDX-License-Identifier: BSD-3-Clause
!> From nodes to particles in three dimensions, with shape functions that are products of functions
!! of one coordinate.
!!
!! Four columns of the nodes are the lanes, and the particles are processed one by one. Lines of
!! nodes are contracted along x first, with functions and derivatives, then lines along y, then
!! layers along z. Particles touch three or four nodes along each direction, a compile-time constant
!! of the kernels. The functions of some particles are copied to an array with a compile-time
!! stride.
module transfer_spline_gather
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line, spline_data_t
   use transfer_spline_gather_plane, only: gather_plane_values
   implicit none
   private

   public :: gather_spline_gradient, gather_spline_values

   integer, parameter :: lanes = 4                   !! Columns that are found at once
   integer, parameter :: batch = 60                  !! Particles whose functions are copied at once

contains

   !> Values sum S_i node_i of any number of columns.
   pure subroutine gather_spline_values(grid, start, spline, nodes, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(spline_data_t), intent(in) :: spline
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: wide(lanes, size(nodes, 2)), weight(batch, line, 3), found(lanes, batch)
      integer :: first, c, before, number, p, low, high, count

      if (.not. grid%active(2)) then
         call gather_plane_values(grid, start, spline, nodes, values)
         return
      end if
      count = start(grid%tile_cells)
      call spline%touched(grid, count, low, high)
      do first = 1, size(nodes, 1), lanes
         call widen(size(nodes, 1), first, low, high, size(nodes, 2), nodes, wide)
         do before = 0, count - 1, batch
            number = min(batch, count - before)
            call copy_functions(spline%reach, before, number, size(spline%weight, 1), &
               spline%weight, weight)
            if (spline%reach == 3) then
               call find_values(3, number, weight, spline%node(before + 1:), grid%stride, &
                  size(nodes, 2), wide, found)
            else
               call find_values(line, number, weight, spline%node(before + 1:), grid%stride, &
                  size(nodes, 2), wide, found)
            end if
            do c = first, min(first + lanes - 1, size(nodes, 1))
               do p = 1, number
                  values(before + p, c) = found(c - first + 1, p)
               end do
            end do
         end do
      end do
   end subroutine gather_spline_values

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
            call find_slopes(3, number, weight, slope, spline%node(before + 1:), grid%stride, &
               size(nodes, 2), wide, found)
         else
            call find_slopes(line, number, weight, slope, spline%node(before + 1:), grid%stride, &
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

   !> Values at some particles, for a compile-time number of nodes along a line.
   pure subroutine find_values(reach, number, w, node, stride, nodes, u, found)
      integer, intent(in) :: reach                           !! Nodes along a line
      integer, intent(in) :: number                          !! Number of particles
      real(wp), intent(in) :: w(batch, line, 3)              !! (particle, node, direction)
      integer, contiguous, intent(in) :: node(:)             !! (particle) First node
      integer, intent(in) :: stride(3) !! Distance from node to node in the array
      integer, intent(in) :: nodes                           !! Nodes of the tile
      real(wp), intent(in) :: u(lanes, nodes)                !! (lane, node)
      real(wp), intent(inout) :: found(lanes, batch)         !! (lane, particle)
      real(wp), dimension(lanes, line) :: lines, layers
      integer :: p, j, k

      do p = 1, number
         do k = 1, reach
            do j = 1, reach
               call contract(reach, w(p, 1, 1), &
                  u(1, node(p) + (j - 1)*stride(2) + (k - 1)*stride(3)), lines(1, j))
            end do
            call contract(reach, w(p, 1, 2), lines, layers(1, k))
         end do
         call contract(reach, w(p, 1, 3), layers, found(1, p))
      end do
   end subroutine find_values

   !> Derivatives at some particles, for a compile-time number of nodes.
   pure subroutine find_slopes(reach, number, w, s, node, stride, nodes, u, found)
      integer, intent(in) :: reach                           !! Nodes along a line
      integer, intent(in) :: number                          !! Number of particles
      real(wp), intent(in) :: w(batch, line, 3)              !! (particle, node, direction)
      real(wp), intent(in) :: s(batch, line, 3)              !! Derivatives of the functions [1/m]
      integer, contiguous, intent(in) :: node(:)             !! (particle) First node
      integer, intent(in) :: stride(3) !! Distance from node to node in the array
      integer, intent(in) :: nodes                           !! Nodes of the tile
      real(wp), intent(in) :: u(lanes, nodes)                !! (lane, node)
      real(wp), intent(inout) :: found(lanes, 3, batch)      !! (lane, direction, particle)
      real(wp), dimension(lanes, line) :: lines, slopes, even, odd, along
      integer :: p, j, k, at

      do p = 1, number
         do k = 1, reach
            do j = 1, reach
               at = node(p) + (j - 1)*stride(2) + (k - 1)*stride(3)
               call contract(reach, w(p, 1, 1), u(1, at), lines(1, j))
               call contract(reach, s(p, 1, 1), u(1, at), slopes(1, j))
            end do
            call contract(reach, w(p, 1, 2), lines, even(1, k))
            call contract(reach, s(p, 1, 2), lines, odd(1, k))
            call contract(reach, w(p, 1, 2), slopes, along(1, k))
         end do
         call contract(reach, w(p, 1, 3), along, found(1, 1, p))
         call contract(reach, w(p, 1, 3), odd, found(1, 2, p))
         call contract(reach, s(p, 1, 3), even, found(1, 3, p))
      end do
   end subroutine find_slopes

   !> Sums over three or four values with the functions of a particle.
   pure subroutine contract(reach, w, u, sums)
      integer, intent(in) :: reach                           !! Number of values
      real(wp), intent(in) :: w(batch*(line - 1) + 1)        !! Each of a batch a function
      real(wp), intent(in) :: u(lanes, line)                 !! (lane, value)
      real(wp), intent(inout) :: sums(lanes)                 !! (lane)
      real(wp) :: rest
      integer :: lane

      !$omp simd private(rest)
      do lane = 1, lanes
         rest = w(2*batch + 1)*u(lane, 3)
         if (reach == line) rest = rest + w(3*batch + 1)*u(lane, 4)
         sums(lane) = (w(1)*u(lane, 1) + w(batch + 1)*u(lane, 2)) + rest
      end do
   end subroutine contract
end module transfer_spline_gather
