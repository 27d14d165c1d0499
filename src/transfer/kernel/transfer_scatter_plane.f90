! SPDX-License-Identifier: BSD-3-Clause
!> Particles to nodes with the linear functions of the cell, in one and two dimensions.
!!
!! The four nodes of a cell in the plane of x and z are the lanes, two of which are in use on a line
!! along x. The particles of a cell are added one by one in their order to sums that stay in
!! registers, and the cell is added to the patch of the tile once. Stress along y gives no force,
!! because the functions do not vary along y.
!!
!! The sum over particles has two loops over the lanes: with a single loop the compiler would
!! process two particles at a time (unroll and jam) and keep the sums in memory. Equations (M.1),
!! (M.4) and (M.5) of doc/theory/method.md.
module transfer_scatter_plane
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_edges, only: cell_edges, edges
   implicit none
   private

   public :: plane_dual_force, plane_force, plane_values

   integer, parameter :: corners = 4                 !! Lanes that carry weight

contains

   !> Add sum S_i value to columns of a patch.
   pure subroutine plane_values(grid, start, local, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: a(corners, 3), b(corners, 3), weight(corners), sums(corners, 4)
      integer :: skip, cell, p, n, at(4)

      a = grid%lane_constant(:corners, :)
      b = grid%lane_slope(:corners, :)
      do skip = 0, count - 1, 4
         ! missing columns repeat the last one, which is not added again
         at = min(skip + [1, 2, 3, 4], count)
         do cell = 0, grid%tile_cells - 1
            if (start(cell + 1) == start(cell)) cycle
            sums = 0.0_wp
            do p = start(cell) + 1, start(cell + 1)
               !$omp simd
               do n = 1, corners
                  weight(n) = (a(n, 1) + b(n, 1)*local(p, 1))*(a(n, 3) + b(n, 3)*local(p, 3))
               end do
               !$omp simd
               do n = 1, corners
                  sums(n, 1) = sums(n, 1) + weight(n)*values(p, at(1))
                  sums(n, 2) = sums(n, 2) + weight(n)*values(p, at(2))
                  sums(n, 3) = sums(n, 3) + weight(n)*values(p, at(3))
                  sums(n, 4) = sums(n, 4) + weight(n)*values(p, at(4))
               end do
            end do
            call add_corners(grid, cell, min(count - skip, 4), before + skip, sums, patch)
         end do
      end do
   end subroutine plane_values

   !> Add the internal force of the plain method, - sum v sigma . grad S, to columns 5 to 7.
   pure subroutine plane_force(grid, start, first, local, volume, stress, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp), dimension(corners, 3) :: c, d
      real(wp) :: sums(corners, 3), x(corners), z(corners)
      integer :: cell, p, q, n

      call signed_lanes(grid, c, d)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            !$omp simd
            do n = 1, corners
               x(n) = (c(n, 3) + d(n, 3)*local(p, 3))*volume(q)
               z(n) = (c(n, 1) + d(n, 1)*local(p, 1))*volume(q)
            end do
            !$omp simd
            do n = 1, corners
               sums(n, 1) = sums(n, 1) - (x(n)*stress(q, 1) + z(n)*stress(q, 6))
               sums(n, 2) = sums(n, 2) - (x(n)*stress(q, 4) + z(n)*stress(q, 5))
               sums(n, 3) = sums(n, 3) - (x(n)*stress(q, 6) + z(n)*stress(q, 3))
            end do
         end do
         call add_corners(grid, cell, 3, 4, sums, patch)
      end do
   end subroutine plane_force

   !> Add the part of the internal force on the cell to columns 5 to 7, the volume to column 8, and
   !! the stress mapped to the nodes, sum v (1 - alpha_l) sigma_kl S, to column 8 + k + 3 (l - 1).
   !! Without factors those of the edges are one.
   pure subroutine plane_dual_force(grid, start, first, local, alpha, volume, stress, patch, &
      factor)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Weight alpha
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp), contiguous, intent(in), optional :: factor(:, 0:) !! (edge, cell) Factor of edges
      integer, parameter :: columns(10) = [5, 6, 7, 8, 9, 10, 11, 15, 16, 17]
      real(wp), dimension(corners, 3) :: a, b, c, d, constant, slope
      real(wp) :: sums(corners, 10), x(corners), z(corners), rest_x(corners), rest_z(corners)
      real(wp) :: part(corners)
      integer :: cell, p, q, n, k, node

      a = grid%lane_constant(:corners, :)
      b = grid%lane_slope(:corners, :)
      call signed_lanes(grid, constant, slope)
      c = constant
      d = slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         if (present(factor)) call weigh_edges(factor(:, cell), constant, slope, c, d)
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            !$omp simd
            do n = 1, corners
               part(n) = (a(n, 1) + b(n, 1)*local(p, 1))*(a(n, 3) + b(n, 3)*local(p, 3))*volume(q)
               rest_x(n) = part(n)*(1.0_wp - alpha(p, 1))
               rest_z(n) = part(n)*(1.0_wp - alpha(p, 3))
               x(n) = (c(n, 3) + d(n, 3)*local(p, 3))*(volume(q)*alpha(p, 1))
               z(n) = (c(n, 1) + d(n, 1)*local(p, 1))*(volume(q)*alpha(p, 3))
            end do
            !$omp simd
            do n = 1, corners
               sums(n, 1) = sums(n, 1) - (x(n)*stress(q, 1) + z(n)*stress(q, 6))
               sums(n, 2) = sums(n, 2) - (x(n)*stress(q, 4) + z(n)*stress(q, 5))
               sums(n, 3) = sums(n, 3) - (x(n)*stress(q, 6) + z(n)*stress(q, 3))
               sums(n, 4) = sums(n, 4) + part(n)
               sums(n, 5) = sums(n, 5) + rest_x(n)*stress(q, 1)
               sums(n, 6) = sums(n, 6) + rest_x(n)*stress(q, 4)
               sums(n, 7) = sums(n, 7) + rest_x(n)*stress(q, 6)
               sums(n, 8) = sums(n, 8) + rest_z(n)*stress(q, 6)
               sums(n, 9) = sums(n, 9) + rest_z(n)*stress(q, 5)
               sums(n, 10) = sums(n, 10) + rest_z(n)*stress(q, 3)
            end do
         end do
         do n = 1, corners
            node = grid%first_node(cell) + grid%lane_offset(n)
            do k = 1, 10
               patch(columns(k), node) = patch(columns(k), node) + sums(n, k)
            end do
         end do
      end do
   end subroutine plane_dual_force

   !> Add the sums of a cell to columns of its nodes.
   pure subroutine add_corners(grid, cell, number, before, sums, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      integer, intent(in) :: number                          !! Columns
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), intent(in) :: sums(corners, number)          !! (lane, column)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: n, c, node

      do n = 1, corners
         node = grid%first_node(cell) + grid%lane_offset(n)
         do c = 1, number
            patch(before + c, node) = patch(before + c, node) + sums(n, c)
         end do
      end do
   end subroutine add_corners

   !> Lanes with the factors of their edges: a node of an edge along x has its factor along z, and
   !! vice versa.
   pure subroutine weigh_edges(factor, constant, slope, c, d)
      real(wp), intent(in) :: factor(cell_edges)             !! (edge) [1]
      real(wp), intent(in) :: constant(corners, 3)           !! (lane, direction) [1/m]
      real(wp), intent(in) :: slope(corners, 3)              !! (lane, direction) [1/m]
      real(wp), intent(inout) :: c(corners, 3), d(corners, 3) !! Coefficients times the factors
      integer, parameter :: low(corners) = [1, 1, 2, 2]      ! (lane) edge along x
      integer, parameter :: across(corners) = 2*edges + [1, 2, 1, 2] ! (lane) edge along z

      c(:, 3) = constant(:, 3)*factor(low)
      d(:, 3) = slope(:, 3)*factor(low)
      c(:, 1) = constant(:, 1)*factor(across)
      d(:, 1) = slope(:, 1)*factor(across)
   end subroutine weigh_edges

   !> Constants and slopes of the lanes along one direction, times the slope of the lane along the
   !! other: together the slope along the other.
   pure subroutine signed_lanes(grid, constant, slope)
      type(grid_t), intent(in) :: grid
      real(wp), intent(out) :: constant(corners, 3)          !! (lane, direction) [1/m]
      real(wp), intent(out) :: slope(corners, 3)             !! (lane, direction) [1/m]
      integer :: n

      constant = 0.0_wp
      slope = 0.0_wp
      do n = 1, corners
         constant(n, 1) = grid%lane_constant(n, 1)*grid%lane_slope(n, 3)/grid%spacing
         constant(n, 3) = grid%lane_constant(n, 3)*grid%lane_slope(n, 1)/grid%spacing
         slope(n, 1) = grid%lane_slope(n, 1)*grid%lane_slope(n, 3)/grid%spacing
         slope(n, 3) = grid%lane_slope(n, 3)*grid%lane_slope(n, 1)/grid%spacing
      end do
   end subroutine signed_lanes
end module transfer_scatter_plane
