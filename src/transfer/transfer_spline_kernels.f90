! SPDX-License-Identifier: BSD-3-Clause
!> Maps with shape functions that are products of functions of one coordinate, given along each
!! direction on the nodes -1 to 2 of the cell.
!!
!! All particles of a cell share a block of 4 nodes along each direction. The components of the four
!! nodes of a line along x lie together, and these of a node are the lanes. Of the lines and layers
!! those are taken that the particle touches. The sums of a tile lie by themselves, four a node, and
!! are added to the patch at once. So few particles in a cell cost hardly more than many, and the
!! bits of a particle do not depend on others.
module transfer_spline_kernels
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line, shape_data_t
   use transfer_spline_plane, only: before_block, columns, scatter_plane_columns, &
      scatter_plane_loads
   implicit none
   private

   public :: gather_spline_values, gather_spline_gradient, scatter_spline_affine, &
      scatter_spline_values, scatter_spline_stress

contains

   !> Add sum S_i value to columns of a patch, four columns at a time.
   pure subroutine scatter_spline_values(grid, after, shape, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
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
         if (grid%active(2)) then
            call scatter_space_columns(grid, after, shape%start, size(shape%spline%weight, 1), &
               shape%spline%weight, shape%spline%low, part, size(sums), sums)
         else
            call scatter_plane_columns(grid, after, shape%start, size(shape%spline%weight, 1), &
               shape%spline%weight, shape%spline%low, part, size(sums), sums)
         end if
         call add_nodes(size(patch, 2), min(count - skip, columns), sums, before + skip, patch)
      end do
   end subroutine scatter_spline_values

   !> Add sum S_i value of four columns to the sums of the nodes.
   ! gate: long kernel because arrays are given by their sizes
   pure subroutine scatter_space_columns(grid, after, start, rows, weight, low, values, numbers, &
      sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Lines and layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next two
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      real(wp), contiguous, intent(in) :: values(:, :)       !! (column, particle of the tile)
      integer, intent(in) :: numbers                         !! Four a node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp) :: functions(line)
      integer :: cell, p, j, k, base, at, up

      up = columns*grid%stride(2)
      do cell = 0, grid%tile_cells - 1
         do p = start(cell) + 1, start(cell + 1)
            base = columns*before_block(grid, cell) + (low(p, 2) - 1)*up
            functions = weight(p, :, 1)
            do k = low(p, 3), low(p, 3) + after
               at = base + columns*(k - 1)*grid%stride(3)
               do j = low(p, 2), low(p, 2) + after
                  call add_columns(weight(p, k, 3)*weight(p, j, 2), functions, values(:, p), at, &
                     numbers, sums)
                  at = at + up
               end do
            end do
         end do
      end do
   end subroutine scatter_space_columns

   !> Add values to the four nodes of a line.
   pure subroutine add_columns(factor, weight, values, before, numbers, sums)
      real(wp), intent(in) :: factor                         !! Function of the line
      real(wp), intent(in) :: weight(line)                   !! Functions of its nodes
      real(wp), intent(in) :: values(columns)                !! (column)
      integer, intent(in) :: before                          !! Numbers before the line
      integer, intent(in) :: numbers                         !! Four a node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp) :: value
      integer :: c

      !$omp simd private(value)
      do c = 1, columns
         value = factor*values(c)
         sums(before + c) = sums(before + c) + weight(1)*value
         sums(before + columns + c) = sums(before + columns + c) + weight(2)*value
         sums(before + 2*columns + c) = sums(before + 2*columns + c) + weight(3)*value
         sums(before + 3*columns + c) = sums(before + 3*columns + c) + weight(4)*value
      end do
   end subroutine add_columns

   !> Add sums of all nodes of a tile to columns of the patch.
   pure subroutine add_nodes(nodes, number, sums, before, patch)
      integer, intent(in) :: nodes                           !! Nodes of the tile
      integer, intent(in) :: number                          !! Columns that are added
      real(wp), intent(in) :: sums(columns, nodes)           !! (column, node)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: node, c

      if (number == columns) then
         ! a number that the compiler knows makes the columns one vector
         do node = 1, nodes
            !$omp simd
            do c = 1, columns
               patch(before + c, node) = patch(before + c, node) + sums(c, node)
            end do
         end do
      else
         do node = 1, nodes
            do c = 1, number
               patch(before + c, node) = patch(before + c, node) + sums(c, node)
            end do
         end do
      end if
   end subroutine add_nodes

   !> Add mass and momentum of linear velocity fields (C. Jiang, C. Schroeder, A. Selle, J. Teran,
   !! A. Stomakhin, ACM Trans. Graph. 34 (2015) 51).
   pure subroutine scatter_spline_affine(grid, after, shape, first, mass, velocity, affine, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(columns*size(patch, 2)), x(columns, line), y(columns, line)
      real(wp) :: z(columns, line), d, d_y, d_z, weight
      integer :: cell, p, q, i, j, k, n, base, at, up, lines_after

      lines_after = merge(after, 0, grid%active(2))
      up = columns*grid%stride(2)
      sums = 0.0_wp
      y = 0.0_wp
      z = 0.0_wp
      do cell = 0, grid%tile_cells - 1
         base = columns*before_block(grid, cell)
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            q = first + p - 1
            do i = 1, line
               weight = mass(q)*shape%spline%weight(p, i, 1)
               d = grid%spacing*(real(i - 2, wp) - shape%local(p, 1))
               x(1, i) = weight
               do n = 1, 3
                  x(1 + n, i) = weight*(velocity(q, n) + affine(q, n)*d)
                  y(1 + n, i) = weight*affine(q, n + 3)
                  z(1 + n, i) = weight*affine(q, n + 6)
               end do
            end do
            do k = shape%spline%low(p, 3), shape%spline%low(p, 3) + after
               d_z = merge(grid%spacing*(real(k - 2, wp) - shape%local(p, 3)), 0.0_wp, &
                  grid%active(3))
               at = base + columns*(k - 1)*grid%stride(3)
               do j = shape%spline%low(p, 2), shape%spline%low(p, 2) + lines_after
                  d_y = merge(grid%spacing*(real(j - 2, wp) - shape%local(p, 2)), 0.0_wp, &
                     grid%active(2))
                  weight = shape%spline%weight(p, j, 2)*shape%spline%weight(p, k, 3)
                  call add_field(weight*[1.0_wp, d_y, d_z], x, y, z, at + (j - 1)*up, size(sums), &
                     sums)
               end do
            end do
         end do
      end do
      call add_nodes(size(patch, 2), columns, sums, 0, patch)
   end subroutine scatter_spline_affine

   !> Add three fields of a line with their factors.
   pure subroutine add_field(factor, x, y, z, before, numbers, sums)
      real(wp), intent(in) :: factor(3)                      !! Of the three fields
      real(wp), intent(in) :: x(columns*line)                !! (column and node) First field
      real(wp), intent(in) :: y(columns*line)                !! Second one
      real(wp), intent(in) :: z(columns*line)                !! Third one
      integer, intent(in) :: before                          !! Numbers before the line
      integer, intent(in) :: numbers                         !! Four a node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      integer :: n

      !$omp simd
      do n = 1, columns*line
         sums(before + n) = sums(before + n) + ((factor(1)*x(n) + factor(2)*y(n)) &
            + factor(3)*z(n))
      end do
   end subroutine add_field

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
   pure subroutine scatter_spline_stress(grid, after, shape, first, volume, stress, patch)
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
      if (grid%active(2)) then
         call scatter_space_loads(grid, after, shape%start, size(shape%spline%weight, 1), &
            shape%spline%weight, shape%spline%slope, shape%spline%low, load, size(sums), sums)
      else
         call scatter_plane_loads(grid, after, shape%start, size(shape%spline%weight, 1), &
            shape%spline%weight, shape%spline%slope, shape%spline%low, load, size(sums), sums)
      end if
      call add_nodes(size(patch, 2), 3, sums, 4, patch)
   end subroutine scatter_spline_stress

   !> Add the force of loads to the sums of the nodes.
   ! gate: long kernel because arrays are given by their sizes
   pure subroutine scatter_space_loads(grid, after, start, rows, weight, slope, low, load, &
      numbers, sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Lines and layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next three
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      real(wp), intent(in) :: slope(rows, line, 3)           !! The same: derivatives [1/m]
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      !> (component, direction, particle of the tile) [N m]
      real(wp), contiguous, intent(in) :: load(:, :, :)
      integer, intent(in) :: numbers                         !! Four a node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (component, node), flat
      real(wp) :: functions(line), slopes(line)
      integer :: cell, p, j, k, base, at, up

      up = columns*grid%stride(2)
      do cell = 0, grid%tile_cells - 1
         do p = start(cell) + 1, start(cell + 1)
            base = columns*before_block(grid, cell) + (low(p, 2) - 1)*up
            functions = weight(p, :, 1)
            slopes = slope(p, :, 1)
            do k = low(p, 3), low(p, 3) + after
               at = base + columns*(k - 1)*grid%stride(3)
               do j = low(p, 2), low(p, 2) + after
                  call add_forces(weight(p, j, 2)*weight(p, k, 3), slope(p, j, 2)*weight(p, k, 3), &
                     weight(p, j, 2)*slope(p, k, 3), functions, slopes, load(:, :, p), at, &
                     numbers, sums)
                  at = at + up
               end do
            end do
         end do
      end do
   end subroutine scatter_space_loads

   !> Add forces to the four nodes of a line.
   ! gate: long kernel because factors in registers are three numbers
   pure subroutine add_forces(x, y, z, weight, slope, load, before, numbers, sums)
      real(wp), intent(in) :: x, y, z                        !! Factors of the line by direction
      real(wp), intent(in) :: weight(line)                   !! Functions of the nodes
      real(wp), intent(in) :: slope(line)                    !! Their derivatives [1/m]
      real(wp), intent(in) :: load(columns, 3)               !! (component, direction) [N m]
      integer, intent(in) :: before                          !! Numbers before the line
      integer, intent(in) :: numbers                         !! Four a node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (component, node), flat
      real(wp) :: along, across
      integer :: c

      !$omp simd private(along, across)
      do c = 1, columns
         along = x*load(c, 1)
         across = y*load(c, 2) + z*load(c, 3)
         sums(before + c) = sums(before + c) + (slope(1)*along + weight(1)*across)
         sums(before + columns + c) = sums(before + columns + c) &
            + (slope(2)*along + weight(2)*across)
         sums(before + 2*columns + c) = sums(before + 2*columns + c) &
            + (slope(3)*along + weight(3)*across)
         sums(before + 3*columns + c) = sums(before + 3*columns + c) &
            + (slope(4)*along + weight(4)*across)
      end do
   end subroutine add_forces

   !> Values sum S_i node_i of three columns in three dimensions. The nodes come as one row of
   !! numbers, in which those of a line lie together.
   ! gate: long kernel because arrays are given by their sizes
   pure subroutine gather_spline_values(grid, after, start, rows, weight, low, number, nodes, &
      skip, values)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next two
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(in) :: nodes(3*number)                !! (column, node), flat
      integer, intent(in) :: skip                            !! Columns of the values before them
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: sums(3*line), y(line), z
      integer :: cell, p, k, n, base, at, up

      up = 3*grid%stride(2)
      do cell = 0, grid%tile_cells - 1
         base = before_block(grid, cell)
         do p = start(cell) + 1, start(cell + 1)
            sums = 0.0_wp
            do n = 1, line
               y(n) = weight(p, n, 2)
            end do
            do k = low(p, 3), low(p, 3) + after
               at = 3*(base + (k - 1)*grid%stride(3))
               z = weight(p, k, 3)
               !$omp simd
               do n = 1, 3*line
                  sums(n) = sums(n) + z*((y(1)*nodes(at + n) + y(2)*nodes(at + up + n)) &
                     + (y(3)*nodes(at + 2*up + n) + y(4)*nodes(at + 3*up + n)))
               end do
            end do
            do n = 1, 3
               values(p, skip + n) = (weight(p, 1, 1)*sums(n) &
                  + weight(p, 2, 1)*sums(n + 3)) + (weight(p, 3, 1)*sums(n + 6) &
                  + weight(p, 4, 1)*sums(n + 9))
            end do
         end do
      end do
   end subroutine gather_spline_values

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l in three dimensions. The nodes come as one
   !! row of numbers.
   ! gate: long kernel because arrays are given by their sizes
   pure subroutine gather_spline_gradient(grid, after, start, rows, weight, slope, low, number, &
      nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: rows                            !! Length of the next three
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      real(wp), intent(in) :: slope(rows, line, 3)           !! The same: derivatives [1/m]
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First node
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(in) :: nodes(3*number)                !! (3, node) Velocity, flat [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: x(3*line), y(3*line), z(3*line), b(line), db(line), c, dc, even, odd
      integer :: cell, p, k, n, base, at, up

      up = 3*grid%stride(2)
      do cell = 0, grid%tile_cells - 1
         base = before_block(grid, cell)
         do p = start(cell) + 1, start(cell + 1)
            x = 0.0_wp
            y = 0.0_wp
            z = 0.0_wp
            do n = 1, line
               b(n) = weight(p, n, 2)
               db(n) = slope(p, n, 2)
            end do
            do k = low(p, 3), low(p, 3) + after
               at = 3*(base + (k - 1)*grid%stride(3))
               c = scale*weight(p, k, 3)
               dc = scale*slope(p, k, 3)
               !$omp simd private(even, odd)
               do n = 1, 3*line
                  even = (b(1)*nodes(at + n) + b(2)*nodes(at + up + n)) &
                     + (b(3)*nodes(at + 2*up + n) + b(4)*nodes(at + 3*up + n))
                  odd = (db(1)*nodes(at + n) + db(2)*nodes(at + up + n)) &
                     + (db(3)*nodes(at + 2*up + n) + db(4)*nodes(at + 3*up + n))
                  x(n) = x(n) + c*even
                  y(n) = y(n) + c*odd
                  z(n) = z(n) + dc*even
               end do
            end do
            do n = 1, line
               b(n) = weight(p, n, 1)
               db(n) = slope(p, n, 1)
            end do
            do n = 1, 3
               gradient(p, n) = (db(1)*x(n) + db(2)*x(n + 3)) + (db(3)*x(n + 6) + db(4)*x(n + 9))
               gradient(p, n + 3) = (b(1)*y(n) + b(2)*y(n + 3)) + (b(3)*y(n + 6) + b(4)*y(n + 9))
               gradient(p, n + 6) = (b(1)*z(n) + b(2)*z(n + 3)) + (b(3)*z(n + 6) + b(4)*z(n + 9))
            end do
         end do
      end do
   end subroutine gather_spline_gradient
end module transfer_spline_kernels
