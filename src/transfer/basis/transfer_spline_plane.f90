! SPDX-License-Identifier: BSD-3-Clause
!> Maps with shape functions that are products of functions of one coordinate, in one and two
!! dimensions: a layer along z is one line along x. Otherwise as in `transfer_spline_kernels`, with
!! the same node sums and node values; functions are passed as whole arrays, so that they are
!! indexed directly.
module transfer_spline_plane
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line, shape_data_t
   implicit none
   private

   public :: add_nodes, scatter_plane_stress, scatter_plane_values

   integer, parameter, public :: columns = 4         !! Components of a node that are summed at once

contains

   !> Node before the block of a cell.
   pure integer function before_block(grid, cell) result(node)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0

      node = grid%first_node(cell) - sum(grid%stride) - 1
   end function before_block

   !> Add sum S_i value to columns of a patch in planes and on lines.
   pure subroutine scatter_plane_values(grid, after, shape, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: part(columns, shape%count), sums(columns*size(patch, 2))
      integer :: p, c, skip

      do skip = 0, count - 1, columns
         part = 0.0_wp
         do c = 1, min(count - skip, columns)
            do p = 1, shape%count
               part(c, p) = values(p, skip + c)
            end do
         end do
         sums = 0.0_wp
         call scatter_plane_columns(grid, after, shape%start, size(shape%spline%weight, 1), &
            shape%spline%weight, shape%spline%low, part, size(sums), sums)
         call add_nodes(1, size(patch, 2), size(patch, 2), min(count - skip, columns), sums, &
            before + skip, patch)
      end do
   end subroutine scatter_plane_values

   !> Add sum S_i value of four columns to the sums of the nodes.
   pure subroutine scatter_plane_columns(grid, after, start, rows, weight, low, values, numbers, &
      sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Lines after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next two
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      real(wp), contiguous, intent(in) :: values(:, :)       !! (column, particle of the tile)
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp) :: w1, w2, w3, w4, value
      integer :: cell, p, k, c, at, up

      up = columns*grid%stride(3)
      do cell = 0, grid%tile_cells - 1
         do p = start(cell) + 1, start(cell + 1)
            at = columns*before_block(grid, cell) + (low(p, 3) - 1)*up
            w1 = weight(p, 1, 1)
            w2 = weight(p, 2, 1)
            w3 = weight(p, 3, 1)
            w4 = weight(p, 4, 1)
            do k = low(p, 3), low(p, 3) + after
               !$omp simd private(value)
               do c = 1, columns
                  value = weight(p, k, 3)*values(c, p)
                  sums(at + c) = sums(at + c) + w1*value
                  sums(at + columns + c) = sums(at + columns + c) + w2*value
                  sums(at + 2*columns + c) = sums(at + 2*columns + c) + w3*value
                  sums(at + 3*columns + c) = sums(at + 3*columns + c) + w4*value
               end do
               at = at + up
            end do
         end do
      end do
   end subroutine scatter_plane_columns

   !> Add the internal force to columns 5 to 7 of a patch in planes and on lines.
   pure subroutine scatter_plane_stress(grid, after, shape, first, volume, stress, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer, parameter :: component(3, 3) = reshape([1, 4, 6, 4, 2, 5, 6, 5, 3], [3, 3])
      real(wp) :: load(columns, 3, shape%count), sums(columns*size(patch, 2))
      integer :: p, k, l

      load(columns, :, :) = 0.0_wp
      do l = 1, 3
         do k = 1, 3
            do p = 1, shape%count
               load(k, l, p) = -volume(first + p - 1)*stress(first + p - 1, component(k, l))
            end do
         end do
      end do
      sums = 0.0_wp
      call scatter_plane_loads(grid, after, shape%start, size(shape%spline%weight, 1), &
         shape%spline%weight, shape%spline%slope, shape%spline%low, load, size(sums), sums)
      call add_nodes(1, size(patch, 2), size(patch, 2), 3, sums, 4, patch)
   end subroutine scatter_plane_stress

   !> Add the force of loads to the sums of the nodes.
   pure subroutine scatter_plane_loads(grid, after, start, rows, weight, slope, low, load, &
      numbers, sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Lines after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next three
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      real(wp), intent(in) :: slope(rows, line, 3)           !! Derivatives of the functions [1/m]
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      !> (component, direction, particle of the tile) [N m]
      real(wp), contiguous, intent(in) :: load(:, :, :)
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (component, node), flat
      real(wp) :: along, across, w1, w2, w3, w4, s1, s2, s3, s4, z, slope_z
      integer :: cell, p, k, c, at, up

      up = columns*grid%stride(3)
      do cell = 0, grid%tile_cells - 1
         do p = start(cell) + 1, start(cell + 1)
            at = columns*before_block(grid, cell) + (low(p, 3) - 1)*up
            w1 = weight(p, 1, 1)
            w2 = weight(p, 2, 1)
            w3 = weight(p, 3, 1)
            w4 = weight(p, 4, 1)
            s1 = slope(p, 1, 1)
            s2 = slope(p, 2, 1)
            s3 = slope(p, 3, 1)
            s4 = slope(p, 4, 1)
            do k = low(p, 3), low(p, 3) + after
               z = weight(p, k, 3)
               slope_z = slope(p, k, 3)
               !$omp simd private(along, across)
               do c = 1, columns
                  along = z*load(c, 1, p)
                  across = slope_z*load(c, 3, p)
                  sums(at + c) = sums(at + c) + (s1*along + w1*across)
                  sums(at + columns + c) = sums(at + columns + c) + (s2*along + w2*across)
                  sums(at + 2*columns + c) = sums(at + 2*columns + c) + (s3*along + w3*across)
                  sums(at + 3*columns + c) = sums(at + 3*columns + c) + (s4*along + w4*across)
               end do
               at = at + up
            end do
         end do
      end do
   end subroutine scatter_plane_loads

   !> Add sums of all nodes of a tile to columns of the patch.
   pure subroutine add_nodes(low, high, nodes, number, sums, before, patch)
      integer, intent(in) :: low, high                       !! First and last node that get them
      integer, intent(in) :: nodes                           !! Nodes of the tile
      integer, intent(in) :: number                          !! Columns that are added
      real(wp), intent(in) :: sums(columns, nodes)           !! (column, node)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: node, c

      if (number == columns) then
         ! a compile-time constant makes the columns one vector
         do node = low, high
            !$omp simd
            do c = 1, columns
               patch(before + c, node) = patch(before + c, node) + sums(c, node)
            end do
         end do
      else
         do node = low, high
            do c = 1, number
               patch(before + c, node) = patch(before + c, node) + sums(c, node)
            end do
         end do
      end if
   end subroutine add_nodes
end module transfer_spline_plane
