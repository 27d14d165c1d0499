! SPDX-License-Identifier: BSD-3-Clause
!> Maps with linear functions at the corners of particles. Each corner is a point in a cell, whose
!! nodes are up to four lines along x with two nodes each. Components and nodes of a line are the
!! lanes. Patches and node fields are one-dimensional arrays.
module transfer_cpdi_kernels
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   integer, parameter :: lines = lanes/2             !! Lines of a cell

   public :: gather_corner_gradient, gather_corner_values, scatter_corner_stress, &
      scatter_corner_values

contains

   !> Add sum S_i value to columns of a patch.
   pure subroutine scatter_corner_values(grid, shape, count, values, before, rows, number, patch)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      integer, intent(in) :: rows                            !! Columns of the patch
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(inout) :: patch(rows*number)          !! (column, node), flat
      real(wp) :: a(lanes, 3), b(lanes, 3), weight(lines), lower(count), upper(count), x, share
      integer :: p, c, m, at, n, corners, offset(lines)

      a = grid%lane_constant
      b = grid%lane_slope
      offset = grid%lane_offset(1::2)
      corners = 2**grid%dimensions
      share = 1.0_wp/real(corners, wp)
      do p = 1, shape%count
         do c = 1, corners
            x = shape%corner%local(c, 1, p)
            call weigh_lines(a, b, shape%corner%local(c, 2, p), shape%corner%local(c, 3, p), weight)
            do n = 1, count
               lower(n) = (1.0_wp - x)*(values(p, n)*share)
               upper(n) = x*(values(p, n)*share)
            end do
            do m = 1, corners/2
               at = before + rows*(shape%corner%node(c, p) + offset(m) - 1)
               call add_line(count, weight(m), lower, upper, at, rows, rows*number, patch)
            end do
         end do
      end do
   end subroutine scatter_corner_values

   !> Functions of the lines of a cell at a corner.
   pure subroutine weigh_lines(a, b, y, z, weight)
      real(wp), intent(in) :: a(lanes, 3), b(lanes, 3)       !! (lane, direction) Constant and slope
      real(wp), intent(in) :: y, z                           !! Coordinates of the corner [1]
      real(wp), intent(out) :: weight(lines)                 !! (line)
      integer :: m

      !$omp simd
      do m = 1, lines
         weight(m) = (a(2*m, 2) + b(2*m, 2)*y)*(a(2*m, 3) + b(2*m, 3)*z)
      end do
   end subroutine weigh_lines

   !> Add columns to the two nodes of a line.
   pure subroutine add_line(count, weight, lower, upper, at, rows, numbers, patch)
      integer, intent(in) :: count                           !! Number of columns
      real(wp), intent(in) :: weight                         !! Function of the line
      real(wp), intent(in) :: lower(count), upper(count)     !! (column) For its two nodes
      integer, intent(in) :: at                              !! Index offset in the patch
      integer, intent(in) :: rows                            !! Columns of the patch
      integer, intent(in) :: numbers                         !! Numbers of the patch
      real(wp), intent(inout) :: patch(numbers)              !! (column, node), flat
      integer :: n

      ! a compile-time constant makes the columns one vector
      if (count == 4) then
         !$omp simd
         do n = 1, 4
            patch(at + n) = patch(at + n) + weight*lower(n)
            patch(at + rows + n) = patch(at + rows + n) + weight*upper(n)
         end do
      else
         do n = 1, count
            patch(at + n) = patch(at + n) + weight*lower(n)
            patch(at + rows + n) = patch(at + rows + n) + weight*upper(n)
         end do
      end if
   end subroutine add_line

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch: each corner gets
   !! a force, and distributes it to its nodes.
   pure subroutine scatter_corner_stress(grid, shape, first, volume, stress, rows, number, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      integer, intent(in) :: rows                            !! Columns of the patch
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(inout) :: patch(rows*number)          !! (column, node), flat
      integer, parameter :: symmetric(3, 3) = reshape([1, 4, 6, 4, 2, 5, 6, 5, 3], [3, 3])
      real(wp) :: a(lanes, 3), b(lanes, 3), weight(lines), along(3, 3), force(3), lower(3), upper(3)
      real(wp) :: x, v
      integer :: p, q, c, m, at, n, k, l, corners, offset(lines)

      a = grid%lane_constant
      b = grid%lane_slope
      offset = grid%lane_offset(1::2)
      corners = 2**grid%dimensions
      do p = 1, shape%count
         q = first + p - 1
         v = -volume(q)/(grid%spacing*real(corners, wp))
         ! the stress in the basis of the edges
         do l = 1, 3
            do k = 1, 3
               along(k, l) = v*(stress(q, symmetric(k, 1))*shape%corner%inverse(l, p) &
                  + stress(q, symmetric(k, 2))*shape%corner%inverse(l + 3, p) &
                  + stress(q, symmetric(k, 3))*shape%corner%inverse(l + 6, p))
            end do
         end do
         do c = 1, corners
            do k = 1, 3
               force(k) = b(c, 1)*along(k, 1) + b(c, 2)*along(k, 2) + b(c, 3)*along(k, 3)
            end do
            x = shape%corner%local(c, 1, p)
            call weigh_lines(a, b, shape%corner%local(c, 2, p), shape%corner%local(c, 3, p), weight)
            lower = (1.0_wp - x)*force
            upper = x*force
            do m = 1, corners/2
               at = rows*(shape%corner%node(c, p) + offset(m) - 1) + 4
               do n = 1, 3
                  patch(at + n) = patch(at + n) + weight(m)*lower(n)
                  patch(at + rows + n) = patch(at + rows + n) + weight(m)*upper(n)
               end do
            end do
         end do
      end do
   end subroutine scatter_corner_stress

   !> Values sum S_i node_i of three columns.
   pure subroutine gather_corner_values(grid, shape, number, nodes, skip, values)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(in) :: nodes(3*number)                !! (column, node), flat
      integer, intent(in) :: skip                            !! Column offset in the values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: a(lanes, 3), b(lanes, 3), weight(lines), sums(6), value(3), x, share
      integer :: p, c, m, at, n, corners, offset(lines)

      a = grid%lane_constant
      b = grid%lane_slope
      offset = grid%lane_offset(1::2)
      corners = 2**grid%dimensions
      share = 1.0_wp/real(corners, wp)
      do p = 1, shape%count
         value = 0.0_wp
         do c = 1, corners
            x = shape%corner%local(c, 1, p)
            call weigh_lines(a, b, shape%corner%local(c, 2, p), shape%corner%local(c, 3, p), weight)
            sums = 0.0_wp
            do m = 1, corners/2
               at = 3*(shape%corner%node(c, p) + offset(m) - 1)
               !$omp simd
               do n = 1, 6
                  sums(n) = sums(n) + weight(m)*nodes(at + n)
               end do
            end do
            do n = 1, 3
               value(n) = value(n) + ((1.0_wp - x)*sums(n) + x*sums(n + 3))
            end do
         end do
         do n = 1, 3
            values(p, skip + n) = share*value(n)
         end do
      end do
   end subroutine gather_corner_values

   !> Scaled velocity gradient: mean differences along the edges, times the inverse of the edges.
   pure subroutine gather_corner_gradient(grid, shape, number, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(in) :: nodes(3*number)                !! (3, node) Velocity, flat [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: a(lanes, 3), b(lanes, 3), weight(lines), sums(6), value(3), along(3, 3), x, factor
      integer :: p, c, m, at, n, k, l, corners, offset(lines)

      a = grid%lane_constant
      b = grid%lane_slope
      offset = grid%lane_offset(1::2)
      corners = 2**grid%dimensions
      factor = scale/(grid%spacing*real(corners, wp))
      do p = 1, shape%count
         along = 0.0_wp
         do c = 1, corners
            x = shape%corner%local(c, 1, p)
            call weigh_lines(a, b, shape%corner%local(c, 2, p), shape%corner%local(c, 3, p), weight)
            sums = 0.0_wp
            do m = 1, corners/2
               at = 3*(shape%corner%node(c, p) + offset(m) - 1)
               !$omp simd
               do n = 1, 6
                  sums(n) = sums(n) + weight(m)*nodes(at + n)
               end do
            end do
            do n = 1, 3
               value(n) = (1.0_wp - x)*sums(n) + x*sums(n + 3)
            end do
            do l = 1, 3
               do k = 1, 3
                  along(k, l) = along(k, l) + b(c, l)*value(k)
               end do
            end do
         end do
         do l = 1, 3
            do k = 1, 3
               gradient(p, k + 3*(l - 1)) = factor*(along(k, 1)*shape%corner%inverse(3*l - 2, p) &
                  + along(k, 2)*shape%corner%inverse(3*l - 1, p) &
                  + along(k, 3)*shape%corner%inverse(3*l, p))
            end do
         end do
      end do
   end subroutine gather_corner_gradient
end module transfer_cpdi_kernels
