! SPDX-License-Identifier: BSD-3-Clause
!> From particles to nodes with shape functions that are products of functions of one coordinate.
!!
!! In three dimensions products of functions along y and z of some particles are found at once, with
!! particles as lanes. Then the particles are added one by one, with four columns as lanes, and only
!! to the nodes that they touch: there are kernels for three and for four along each direction. The
!! sums of a tile are kept in a separate array, four per node, and are added to the patch at
!! the end. So cells with few particles cost little more than cells with many, and the bits of a
!! particle do not depend on others.
module transfer_spline_kernels
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line, shape_data_t
   use transfer_spline_plane, only: add_nodes, columns, scatter_plane_stress, scatter_plane_values
   implicit none
   private

   public :: scatter_spline_affine, scatter_spline_motion, scatter_spline_stress, &
      scatter_spline_values

   integer, parameter :: batch = 60                  !! Particles that are prepared at once

   !> Functions of some particles, as the particles are added.
   type :: lines_t
      integer :: before(batch)                       !! (particle) Numbers before the first node
      real(wp) :: x(batch, line)                     !! (particle, node) Functions along x
      real(wp) :: slope_x(batch, line)               !! Derivatives along x [1/m]
      real(wp) :: yz(batch, line, line)              !! (particle, y, z) Products along y and z
      real(wp) :: slope_y(batch, line, line)         !! Functions with derivatives along y [1/m]
      real(wp) :: slope_z(batch, line, line)         !! Functions with derivatives along z [1/m]
   end type lines_t

contains

   !> Add mass and momentum to columns 1 to 4 of a patch, in three dimensions.
   pure subroutine scatter_spline_motion(grid, shape, first, mass, velocity, patch)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      type(lines_t) :: lines
      real(wp) :: values(columns, batch), sums(columns*size(patch, 2))
      integer :: skipped, number, p, q, low, high

      call shape%spline%touched(grid, shape%count, low, high)
      sums(columns*(low - 1) + 1:columns*high) = 0.0_wp
      do skipped = 0, shape%count - 1, batch
         number = min(batch, shape%count - skipped)
         call multiply_lines(shape, skipped, number, lines)
         do p = 1, number
            q = first - 1 + skipped + p
            values(1, p) = mass(q)
            values(2, p) = mass(q)*velocity(q, 1)
            values(3, p) = mass(q)*velocity(q, 2)
            values(4, p) = mass(q)*velocity(q, 3)
         end do
         call add_values(shape%spline%reach, number, lines, values, columns*grid%stride, &
            size(sums), sums)
      end do
      call add_nodes(low, high, size(patch, 2), columns, sums, 0, patch)
   end subroutine scatter_spline_motion

   !> Add sum S_i value to columns of a patch.
   pure subroutine scatter_spline_values(grid, after, shape, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one in planes
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%active(2)) then
         call scatter_space_values(grid, shape, count, values, before, patch)
      else
         call scatter_plane_values(grid, after, shape, count, values, before, patch)
      end if
   end subroutine scatter_spline_values

   !> Add sum S_i value to columns of a patch in three dimensions, four columns at a time.
   pure subroutine scatter_space_values(grid, shape, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      type(lines_t) :: lines
      real(wp) :: part(columns, batch), sums(columns*size(patch, 2))
      integer :: skipped, number, p, skip, at(columns), low, high

      call shape%spline%touched(grid, shape%count, low, high)
      do skip = 0, count - 1, columns
         ! missing columns repeat the last one, which is not added
         at = min(skip + [1, 2, 3, 4], count)
         sums(columns*(low - 1) + 1:columns*high) = 0.0_wp
         do skipped = 0, shape%count - 1, batch
            number = min(batch, shape%count - skipped)
            call multiply_lines(shape, skipped, number, lines)
            do p = 1, number
               part(1, p) = values(skipped + p, at(1))
               part(2, p) = values(skipped + p, at(2))
               part(3, p) = values(skipped + p, at(3))
               part(4, p) = values(skipped + p, at(4))
            end do
            call add_values(shape%spline%reach, number, lines, part, columns*grid%stride, &
               size(sums), sums)
         end do
         call add_nodes(low, high, size(patch, 2), min(count - skip, columns), sums, &
            before + skip, patch)
      end do
   end subroutine scatter_space_values

   !> Functions along x, and products of functions along y and z, of some particles.
   pure subroutine multiply_lines(shape, skipped, number, lines)
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: skipped                         !! Index offset
      integer, intent(in) :: number                          !! Their number
      type(lines_t), intent(inout) :: lines
      integer :: p, i, j, k, reach

      reach = shape%spline%reach
      do p = 1, number
         lines%before(p) = columns*(shape%spline%node(skipped + p) - 1)
      end do
      do i = 1, reach
         do p = 1, number
            lines%x(p, i) = shape%spline%weight(skipped + p, i, 1)
         end do
      end do
      do k = 1, reach
         do j = 1, reach
            !$omp simd
            do p = 1, number
               lines%yz(p, j, k) = shape%spline%weight(skipped + p, j, 2) &
                  *shape%spline%weight(skipped + p, k, 3)
            end do
         end do
      end do
   end subroutine multiply_lines

   !> The same with derivatives along one of the directions.
   pure subroutine multiply_slopes(shape, skipped, number, lines)
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: skipped                         !! Index offset
      integer, intent(in) :: number                          !! Their number
      type(lines_t), intent(inout) :: lines
      integer :: p, i, j, k, reach

      reach = shape%spline%reach
      do i = 1, reach
         do p = 1, number
            lines%slope_x(p, i) = shape%spline%slope(skipped + p, i, 1)
         end do
      end do
      do k = 1, reach
         do j = 1, reach
            !$omp simd
            do p = 1, number
               lines%slope_y(p, j, k) = shape%spline%slope(skipped + p, j, 2) &
                  *shape%spline%weight(skipped + p, k, 3)
               lines%slope_z(p, j, k) = shape%spline%weight(skipped + p, j, 2) &
                  *shape%spline%slope(skipped + p, k, 3)
            end do
         end do
      end do
   end subroutine multiply_slopes

   !> Add sum S_i value of four columns of some particles to the sums of the nodes.
   pure subroutine add_values(reach, number, lines, values, up, numbers, sums)
      integer, intent(in) :: reach                           !! Nodes along a line
      integer, intent(in) :: number                          !! Number of particles
      type(lines_t), intent(in) :: lines
      real(wp), intent(in) :: values(columns, batch)         !! (column, particle)
      integer, intent(in) :: up(3)                           !! Numbers from node to node
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      integer :: p, j, k

      if (reach == 3) then
         do p = 1, number
            do k = 1, 3
               do j = 1, 3
                  call add_three(lines%yz(p, j, k), lines%x(p, 1), lines%x(p, 2), lines%x(p, 3), &
                     values(1, p), lines%before(p) + (j - 1)*up(2) + (k - 1)*up(3), numbers, sums)
               end do
            end do
         end do
      else
         do p = 1, number
            do k = 1, line
               do j = 1, line
                  call add_four(lines%yz(p, j, k), lines%x(p, 1), lines%x(p, 2), lines%x(p, 3), &
                     lines%x(p, 4), values(1, p), lines%before(p) + (j - 1)*up(2) &
                     + (k - 1)*up(3), numbers, sums)
               end do
            end do
         end do
      end if
   end subroutine add_values

   !> Add values to the three nodes of a line.
   ! The functions are scalars, so that they stay in registers.
   pure subroutine add_three(factor, w1, w2, w3, values, before, numbers, sums)
      real(wp), intent(in) :: factor                         !! Function of the line
      real(wp), intent(in) :: w1, w2, w3                     !! Functions of its nodes
      real(wp), intent(in) :: values(columns)                !! (column)
      integer, intent(in) :: before                          !! Numbers before the line
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp) :: value
      integer :: c

      !$omp simd private(value)
      do c = 1, columns
         value = factor*values(c)
         sums(before + c) = sums(before + c) + w1*value
         sums(before + columns + c) = sums(before + columns + c) + w2*value
         sums(before + 2*columns + c) = sums(before + 2*columns + c) + w3*value
      end do
   end subroutine add_three

   !> Add values to the four nodes of a line.
   ! The functions are scalars, so that they stay in registers.
   pure subroutine add_four(factor, w1, w2, w3, w4, values, before, numbers, sums)
      real(wp), intent(in) :: factor                         !! Function of the line
      real(wp), intent(in) :: w1, w2, w3, w4                 !! Functions of its nodes
      real(wp), intent(in) :: values(columns)                !! (column)
      integer, intent(in) :: before                          !! Numbers before the line
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp) :: value
      integer :: c

      !$omp simd private(value)
      do c = 1, columns
         value = factor*values(c)
         sums(before + c) = sums(before + c) + w1*value
         sums(before + columns + c) = sums(before + columns + c) + w2*value
         sums(before + 2*columns + c) = sums(before + 2*columns + c) + w3*value
         sums(before + 3*columns + c) = sums(before + 3*columns + c) + w4*value
      end do
   end subroutine add_four

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
   pure subroutine scatter_spline_stress(grid, after, shape, first, volume, stress, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: after                           !! Layers after the first one in planes
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%active(2)) then
         call scatter_space_stress(grid, shape, first, volume, stress, patch)
      else
         call scatter_plane_stress(grid, after, shape, first, volume, stress, patch)
      end if
   end subroutine scatter_spline_stress

   !> Add the internal force in three dimensions.
   pure subroutine scatter_space_stress(grid, shape, first, volume, stress, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      type(lines_t) :: lines
      real(wp) :: load(columns, 3, batch)   !! (component, direction, particle) [N m]
      real(wp) :: sums(columns*size(patch, 2)), share
      integer :: skipped, number, p, q, low, high

      call shape%spline%touched(grid, shape%count, low, high)
      sums(columns*(low - 1) + 1:columns*high) = 0.0_wp
      load = 0.0_wp
      do skipped = 0, shape%count - 1, batch
         number = min(batch, shape%count - skipped)
         call multiply_lines(shape, skipped, number, lines)
         call multiply_slopes(shape, skipped, number, lines)
         do p = 1, number
            q = first - 1 + skipped + p
            share = -volume(q)
            load(1, 1, p) = share*stress(q, 1)
            load(2, 1, p) = share*stress(q, 4)
            load(3, 1, p) = share*stress(q, 6)
            load(1, 2, p) = share*stress(q, 4)
            load(2, 2, p) = share*stress(q, 2)
            load(3, 2, p) = share*stress(q, 5)
            load(1, 3, p) = share*stress(q, 6)
            load(2, 3, p) = share*stress(q, 5)
            load(3, 3, p) = share*stress(q, 3)
         end do
         if (shape%spline%reach == 3) then
            call add_loads_three(number, lines, load, columns*grid%stride, size(sums), sums)
         else
            call add_loads_four(number, lines, load, columns*grid%stride, size(sums), sums)
         end if
      end do
      call add_nodes(low, high, size(patch, 2), 3, sums, 4, patch)
   end subroutine scatter_space_stress

   !> Add the force of the loads of some particles that touch three nodes along each direction.
   pure subroutine add_loads_three(number, lines, load, up, numbers, sums)
      integer, intent(in) :: number                          !! Number of particles
      type(lines_t), intent(in) :: lines
      real(wp), intent(in) :: load(columns, 3, batch)        !! (component, direction, particle)
      integer, intent(in) :: up(3)                           !! Numbers from node to node
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp) :: along, across, w1, w2, w3, s1, s2, s3
      integer :: p, j, k, c, at

      do p = 1, number
         w1 = lines%x(p, 1)
         w2 = lines%x(p, 2)
         w3 = lines%x(p, 3)
         s1 = lines%slope_x(p, 1)
         s2 = lines%slope_x(p, 2)
         s3 = lines%slope_x(p, 3)
         do k = 1, 3
            at = lines%before(p) + (k - 1)*up(3)
            do j = 1, 3
               !$omp simd private(along, across)
               do c = 1, columns
                  along = lines%yz(p, j, k)*load(c, 1, p)
                  across = lines%slope_y(p, j, k)*load(c, 2, p) &
                     + lines%slope_z(p, j, k)*load(c, 3, p)
                  sums(at + c) = sums(at + c) + (s1*along + w1*across)
                  sums(at + columns + c) = sums(at + columns + c) + (s2*along + w2*across)
                  sums(at + 2*columns + c) = sums(at + 2*columns + c) + (s3*along + w3*across)
               end do
               at = at + up(2)
            end do
         end do
      end do
   end subroutine add_loads_three

   !> Add the force of the loads of some particles that touch four nodes along each direction.
   pure subroutine add_loads_four(number, lines, load, up, numbers, sums)
      integer, intent(in) :: number                          !! Number of particles
      type(lines_t), intent(in) :: lines
      real(wp), intent(in) :: load(columns, 3, batch)        !! (component, direction, particle)
      integer, intent(in) :: up(3)                           !! Numbers from node to node
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp) :: along, across, w1, w2, w3, w4, s1, s2, s3, s4
      integer :: p, j, k, c, at

      do p = 1, number
         w1 = lines%x(p, 1)
         w2 = lines%x(p, 2)
         w3 = lines%x(p, 3)
         w4 = lines%x(p, 4)
         s1 = lines%slope_x(p, 1)
         s2 = lines%slope_x(p, 2)
         s3 = lines%slope_x(p, 3)
         s4 = lines%slope_x(p, 4)
         do k = 1, line
            at = lines%before(p) + (k - 1)*up(3)
            do j = 1, line
               !$omp simd private(along, across)
               do c = 1, columns
                  along = lines%yz(p, j, k)*load(c, 1, p)
                  across = lines%slope_y(p, j, k)*load(c, 2, p) &
                     + lines%slope_z(p, j, k)*load(c, 3, p)
                  sums(at + c) = sums(at + c) + (s1*along + w1*across)
                  sums(at + columns + c) = sums(at + columns + c) + (s2*along + w2*across)
                  sums(at + 2*columns + c) = sums(at + 2*columns + c) + (s3*along + w3*across)
                  sums(at + 3*columns + c) = sums(at + 3*columns + c) + (s4*along + w4*across)
               end do
               at = at + up(2)
            end do
         end do
      end do
   end subroutine add_loads_four

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
      real(wp) :: sums(columns*(size(patch, 2) + 1)), x(columns, line), y(columns, line)
      real(wp) :: z(columns, line), d, d_y, d_z, weight
      integer :: p, q, i, j, k, n, base, at, up, lines_after

      lines_after = merge(after, 0, grid%active(2))
      up = columns*grid%stride(2)
      sums = 0.0_wp
      x = 0.0_wp
      y = 0.0_wp
      z = 0.0_wp
      do p = 1, shape%count
         base = columns*(shape%spline%node(p) - 1)
         q = first + p - 1
         do i = 1, shape%spline%reach
            weight = mass(q)*shape%spline%weight(p, i, 1)
            d = grid%spacing*(real(i - 2, wp) - shape%spline%local(p, 1))
            x(1, i) = weight
            do n = 1, 3
               x(1 + n, i) = weight*(velocity(q, n) + affine(q, n)*d)
               y(1 + n, i) = weight*affine(q, n + 3)
               z(1 + n, i) = weight*affine(q, n + 6)
            end do
         end do
         do k = shape%spline%low(p, 3), shape%spline%low(p, 3) + after
            d_z = merge(grid%spacing*(real(k - 2, wp) - shape%spline%local(p, 3)), 0.0_wp, &
               grid%active(3))
            at = base + columns*(k - 1)*grid%stride(3)
            do j = shape%spline%low(p, 2), shape%spline%low(p, 2) + lines_after
               d_y = merge(grid%spacing*(real(j - 2, wp) - shape%spline%local(p, 2)), 0.0_wp, &
                  grid%active(2))
               weight = shape%spline%weight(p, j, 2)*shape%spline%weight(p, k, 3)
               call add_field(weight*[1.0_wp, d_y, d_z], x, y, z, at + (j - 1)*up, size(sums), &
                  sums)
            end do
         end do
      end do
      call add_nodes(1, size(patch, 2), size(patch, 2), columns, sums, 0, patch)
   end subroutine scatter_spline_affine

   !> Add three fields of a line with their factors.
   pure subroutine add_field(factor, x, y, z, before, numbers, sums)
      real(wp), intent(in) :: factor(3)                      !! Factor of each of the three fields
      real(wp), intent(in) :: x(columns*line)                !! (column and node) First field
      real(wp), intent(in) :: y(columns*line)                !! Second one
      real(wp), intent(in) :: z(columns*line)                !! Third one
      integer, intent(in) :: before                          !! Numbers before the line
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      integer :: n

      !$omp simd
      do n = 1, columns*line
         sums(before + n) = sums(before + n) + ((factor(1)*x(n) + factor(2)*y(n)) &
            + factor(3)*z(n))
      end do
   end subroutine add_field
end module transfer_spline_kernels
