! SPDX-License-Identifier: BSD-3-Clause
!> From nodes to particles in scenes of one and two dimensions, with shape functions that are
!! products of functions of one coordinate, given along x and z on the nodes -1 to 2 of the cell.
!!
!! All particles of a cell use the same block of 4 x 4 nodes, and are the lanes. On a line all
!! layers are the same nodes, and only the first has a function that is not zero. Components of
!! vectors along y are not used.
module transfer_spline_gather_plane
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line, shape_data_t, spline_data_t
   implicit none
   private

   public :: gather_plane_values, gather_plane_gradient

contains

   !> Values sum S_i node_i of any number of columns.
   pure subroutine gather_plane_values(grid, start, spline, nodes, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(spline_data_t), intent(in) :: spline
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: block(line, line)
      integer :: cell, c

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         do c = 1, size(nodes, 1)
            call load_block(grid, cell, c, 1.0_wp, nodes, block)
            call add_values(start(cell) + 1, start(cell + 1), size(spline%weight, 1), &
               spline%weight(:, :, 1), spline%weight(:, :, 3), block, values(:, c))
         end do
      end do
   end subroutine gather_plane_values

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l.
   pure subroutine gather_plane_gradient(grid, shape, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: block(line, line)
      integer :: cell, k

      do k = 1, 9
         if (k == 1 .or. k == 3 .or. k == 7 .or. k == 9) cycle
         gradient(:shape%count, k) = 0.0_wp
      end do
      do cell = 0, grid%tile_cells - 1
         if (shape%start(cell + 1) == shape%start(cell)) cycle
         do k = 1, 3, 2
            call load_block(grid, cell, k, scale, nodes, block)
            call add_slopes(shape%start(cell) + 1, shape%start(cell + 1), &
               size(shape%spline%weight, 1), shape%spline%weight(:, :, 1), &
               shape%spline%weight(:, :, 3), shape%spline%slope(:, :, 1), &
               shape%spline%slope(:, :, 3), block, gradient(:, k), gradient(:, k + 6))
         end do
      end do
   end subroutine gather_plane_gradient

   !> Values of a column on the nodes of the block of a cell.
   pure subroutine load_block(grid, cell, column, scale, nodes, block)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      integer, intent(in) :: column                          !! Index of the column
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), intent(out) :: block(line, line)             !! (along x, along z)
      integer :: base, i, k

      base = grid%first_node(cell) - sum(grid%stride) - 1
      do k = 1, line
         do i = 1, line
            block(i, k) = scale*nodes(column, base + i + (k - 1)*grid%stride(3))
         end do
      end do
   end subroutine load_block

   !> Values of a column at the particles of a cell.
   pure subroutine add_values(low, high, rows, x, z, u, values)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last index
      integer, intent(in) :: rows                            !! Length of columns
      real(wp), intent(in) :: x(rows, line), z(rows, line)   !! (particle, node) Functions
      real(wp), intent(in) :: u(line, line) !! (along x, along z) Values on the nodes
      real(wp), contiguous, intent(inout) :: values(:)       !! (particle)
      integer :: p

      !$omp simd
      do p = low, high
         values(p) = (z(p, 1)*((x(p, 1)*u(1, 1) + x(p, 2)*u(2, 1)) + (x(p, 3)*u(3, 1) &
            + x(p, 4)*u(4, 1))) + z(p, 2)*((x(p, 1)*u(1, 2) + x(p, 2)*u(2, 2)) &
            + (x(p, 3)*u(3, 2) + x(p, 4)*u(4, 2)))) + (z(p, 3)*((x(p, 1)*u(1, 3) &
            + x(p, 2)*u(2, 3)) + (x(p, 3)*u(3, 3) + x(p, 4)*u(4, 3))) &
            + z(p, 4)*((x(p, 1)*u(1, 4) + x(p, 2)*u(2, 4)) + (x(p, 3)*u(3, 4) + x(p, 4)*u(4, 4))))
      end do
   end subroutine add_values

   !> Slopes of a column along x and z at the particles of a cell.
   pure subroutine add_slopes(low, high, rows, x, z, dx, dz, u, along_x, along_z)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last index
      integer, intent(in) :: rows                            !! Length of columns
      real(wp), intent(in) :: x(rows, line), z(rows, line)   !! (particle, node) Functions
      real(wp), intent(in) :: dx(rows, line), dz(rows, line) !! Derivatives of the functions [1/m]
      real(wp), intent(in) :: u(line, line) !! (along x, along z) Values on the nodes
      real(wp), contiguous, intent(inout) :: along_x(:)      !! (particle)
      real(wp), contiguous, intent(inout) :: along_z(:)      !! (particle)
      real(wp) :: s1, s2, s3, s4
      integer :: p

      ! sums over z of each column of nodes, with functions and with derivatives
      !$omp simd private(s1, s2, s3, s4)
      do p = low, high
         s1 = (z(p, 1)*u(1, 1) + z(p, 2)*u(1, 2)) + (z(p, 3)*u(1, 3) + z(p, 4)*u(1, 4))
         s2 = (z(p, 1)*u(2, 1) + z(p, 2)*u(2, 2)) + (z(p, 3)*u(2, 3) + z(p, 4)*u(2, 4))
         s3 = (z(p, 1)*u(3, 1) + z(p, 2)*u(3, 2)) + (z(p, 3)*u(3, 3) + z(p, 4)*u(3, 4))
         s4 = (z(p, 1)*u(4, 1) + z(p, 2)*u(4, 2)) + (z(p, 3)*u(4, 3) + z(p, 4)*u(4, 4))
         along_x(p) = (dx(p, 1)*s1 + dx(p, 2)*s2) + (dx(p, 3)*s3 + dx(p, 4)*s4)
         s1 = (dz(p, 1)*u(1, 1) + dz(p, 2)*u(1, 2)) + (dz(p, 3)*u(1, 3) + dz(p, 4)*u(1, 4))
         s2 = (dz(p, 1)*u(2, 1) + dz(p, 2)*u(2, 2)) + (dz(p, 3)*u(2, 3) + dz(p, 4)*u(2, 4))
         s3 = (dz(p, 1)*u(3, 1) + dz(p, 2)*u(3, 2)) + (dz(p, 3)*u(3, 3) + dz(p, 4)*u(3, 4))
         s4 = (dz(p, 1)*u(4, 1) + dz(p, 2)*u(4, 2)) + (dz(p, 3)*u(4, 3) + dz(p, 4)*u(4, 4))
         along_z(p) = (x(p, 1)*s1 + x(p, 2)*s2) + (x(p, 3)*s3 + x(p, 4)*s4)
      end do
   end subroutine add_slopes
end module transfer_spline_gather_plane
