! SPDX-License-Identifier: BSD-3-Clause
!> Maps with shape functions that are products of functions of one coordinate, in one and two
!! dimensions: a layer along z is one line along x. Otherwise as in `transfer_spline_kernels`, whose
!! node
!! sums and node values these are; functions come as whole arrays, so that a particle finds them
!! without a look into what holds them.
module transfer_spline_plane
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line
   implicit none
   private

   public :: before_block, scatter_plane_loads, scatter_plane_columns

   integer, parameter, public :: columns = 4         !! Components of a node that are summed at once

contains

   !> Node before the block of a cell.
   pure integer function before_block(grid, cell) result(node)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0

      node = grid%first_node(cell) - sum(grid%stride) - 1
   end function before_block

   !> Add sum S_i value of four columns to the sums of the nodes.
   ! gate: long kernel because arrays are given by their sizes
   pure subroutine scatter_plane_columns(grid, after, start, rows, weight, low, values, numbers, &
      sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Lines after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next two
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      real(wp), contiguous, intent(in) :: values(:, :)       !! (column, particle of the tile)
      integer, intent(in) :: numbers                         !! Four a node of the tile
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

   !> Add the force of loads to the sums of the nodes.
   ! gate: long kernel because arrays are given by their sizes
   pure subroutine scatter_plane_loads(grid, after, start, rows, weight, slope, low, load, &
      numbers, sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Lines after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next three
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      real(wp), intent(in) :: slope(rows, line, 3)           !! The same: derivatives [1/m]
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      !> (component, direction, particle of the tile) [N m]
      real(wp), contiguous, intent(in) :: load(:, :, :)
      integer, intent(in) :: numbers                         !! Four a node of the tile
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
end module transfer_spline_plane
