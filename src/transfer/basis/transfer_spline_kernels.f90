! SPDX-License-Identifier: BSD-3-Clause
!> From particles to nodes with shape functions that are products of functions of one coordinate.
!!
!! Particles are added one by one, with four columns as lanes, and only to the nodes that they
!! touch. In three dimensions products of functions along y and z of some particles are found at
!! once, with particles as lanes; a particle touches three or four nodes along each direction, a
!! compile-time constant of the kernels. In a plane a layer along z is one line of four nodes along
!! x. The sums of a tile are kept in a separate array, four per node, and are added to the patch at
!! the end. So cells with few particles cost little more than cells with many, and the bits of a
!! particle do not depend on others.
module transfer_spline_kernels
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_shape_data, only: line, shape_data_t, spline_data_t
   implicit none
   private

   public :: scatter_spline_affine, scatter_spline_stress, scatter_spline_values

   integer, parameter :: columns = 4                 !! Components of a node that are summed at once
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

   !> Add sum S_i value to columns of a patch, four columns at a time.
   pure subroutine scatter_spline_values(grid, particles, spline, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: particles                       !! Particles of the tile
      type(spline_data_t), intent(in) :: spline
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      type(lines_t) :: lines
      real(wp) :: part(columns, batch), sums(columns*size(patch, 2))
      integer :: skipped, number, p, skip, at(columns), low, high

      call spline%touched(grid, particles, low, high)
      do skip = 0, count - 1, columns
         ! missing columns repeat the last one, which is not added
         at = min(skip + [1, 2, 3, 4], count)
         sums(columns*(low - 1) + 1:columns*high) = 0.0_wp
         do skipped = 0, particles - 1, batch
            number = min(batch, particles - skipped)
            do p = 1, number
               part(1, p) = values(skipped + p, at(1))
               part(2, p) = values(skipped + p, at(2))
               part(3, p) = values(skipped + p, at(3))
               part(4, p) = values(skipped + p, at(4))
            end do
            if (.not. grid%active(2)) then
               call add_plane_values(spline%after, skipped, number, size(spline%node), &
                  spline%node, spline%low, spline%weight, part, columns*grid%stride(3), &
                  size(sums), sums)
               cycle
            end if
            call multiply_lines(spline, skipped, number, lines)
            if (spline%reach == 3) then
               call add_values(3, number, lines, part, columns*grid%stride, size(sums), sums)
            else
               call add_values(line, number, lines, part, columns*grid%stride, size(sums), sums)
            end if
         end do
         call add_nodes(low, high, size(patch, 2), min(count - skip, columns), sums, &
            before + skip, patch)
      end do
   end subroutine scatter_spline_values

   !> Functions along x, and products of functions along y and z, of some particles.
   pure subroutine multiply_lines(spline, skipped, number, lines)
      type(spline_data_t), intent(in) :: spline
      integer, intent(in) :: skipped                         !! Index offset
      integer, intent(in) :: number                          !! Their number
      type(lines_t), intent(inout) :: lines
      integer :: p, i, j, k, reach

      reach = spline%reach
      do p = 1, number
         lines%before(p) = columns*(spline%node(skipped + p) - 1)
      end do
      do i = 1, reach
         do p = 1, number
            lines%x(p, i) = spline%weight(skipped + p, i, 1)
         end do
      end do
      do k = 1, reach
         do j = 1, reach
            !$omp simd
            do p = 1, number
               lines%yz(p, j, k) = spline%weight(skipped + p, j, 2) &
                  *spline%weight(skipped + p, k, 3)
            end do
         end do
      end do
   end subroutine multiply_lines

   !> The same with derivatives along one of the directions.
   pure subroutine multiply_slopes(spline, skipped, number, lines)
      type(spline_data_t), intent(in) :: spline
      integer, intent(in) :: skipped                         !! Index offset
      integer, intent(in) :: number                          !! Their number
      type(lines_t), intent(inout) :: lines
      integer :: p, i, j, k, reach

      reach = spline%reach
      do i = 1, reach
         do p = 1, number
            lines%slope_x(p, i) = spline%slope(skipped + p, i, 1)
         end do
      end do
      do k = 1, reach
         do j = 1, reach
            !$omp simd
            do p = 1, number
               lines%slope_y(p, j, k) = spline%slope(skipped + p, j, 2) &
                  *spline%weight(skipped + p, k, 3)
               lines%slope_z(p, j, k) = spline%weight(skipped + p, j, 2) &
                  *spline%slope(skipped + p, k, 3)
            end do
         end do
      end do
   end subroutine multiply_slopes

   !> Add sum S_i value of four columns of some particles to the sums of the nodes, for a
   !! compile-time number of nodes along a line.
   pure subroutine add_values(reach, number, lines, values, up, numbers, sums)
      integer, intent(in) :: reach                           !! Nodes along a line
      integer, intent(in) :: number                          !! Number of particles
      type(lines_t), intent(in) :: lines
      real(wp), intent(in) :: values(columns, batch)         !! (column, particle)
      integer, intent(in) :: up(3)                           !! Numbers from node to node
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      integer :: p, j, k

      do p = 1, number
         do k = 1, reach
            do j = 1, reach
               call add_line(reach, lines%yz(p, j, k), lines%x(p, 1), lines%x(p, 2), &
                  lines%x(p, 3), lines%x(p, 4), values(1, p), &
                  lines%before(p) + (j - 1)*up(2) + (k - 1)*up(3), numbers, sums)
            end do
         end do
      end do
   end subroutine add_values

   !> The same in planes and on lines. Functions are whole arrays, which are indexed directly.
   pure subroutine add_plane_values(after, skipped, number, rows, node, low, weight, values, up, &
      numbers, sums)
      integer, intent(in) :: after                           !! Layers after the first one
      integer, intent(in) :: skipped                         !! Index offset
      integer, intent(in) :: number                          !! Number of particles
      integer, intent(in) :: rows                            !! Length of the next three
      integer, intent(in) :: node(rows)                      !! (particle) First node
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First in use
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      real(wp), intent(in) :: values(columns, batch)         !! (column, particle)
      integer, intent(in) :: up                              !! Numbers from layer to layer
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      integer :: p, q, k, at

      do p = 1, number
         q = skipped + p
         at = columns*(node(q) - 1) + (low(q, 3) - 1)*up
         do k = low(q, 3), low(q, 3) + after
            call add_line(line, weight(q, k, 3), weight(q, 1, 1), weight(q, 2, 1), &
               weight(q, 3, 1), weight(q, 4, 1), values(1, p), at, numbers, sums)
            at = at + up
         end do
      end do
   end subroutine add_plane_values

   !> Add values to the nodes of a line.
   pure subroutine add_line(reach, factor, w1, w2, w3, w4, values, before, numbers, sums)
      integer, intent(in) :: reach                           !! Number of its nodes
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
         if (reach == line) sums(before + 3*columns + c) = sums(before + 3*columns + c) + w4*value
      end do
   end subroutine add_line

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
   pure subroutine scatter_spline_stress(grid, particles, spline, first, volume, stress, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: particles                       !! Particles of the tile
      type(spline_data_t), intent(in) :: spline
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      type(lines_t) :: lines
      real(wp) :: load(columns, 3, batch)   !! (component, direction, particle) [N m]
      real(wp) :: sums(columns*size(patch, 2)), share
      integer :: skipped, number, p, q, low, high

      call spline%touched(grid, particles, low, high)
      sums(columns*(low - 1) + 1:columns*high) = 0.0_wp
      load = 0.0_wp
      do skipped = 0, particles - 1, batch
         number = min(batch, particles - skipped)
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
         if (.not. grid%active(2)) then
            call add_plane_loads(spline%after, skipped, number, size(spline%node), spline%node, &
               spline%low, spline%weight, spline%slope, load, columns*grid%stride(3), &
               size(sums), sums)
            cycle
         end if
         call multiply_lines(spline, skipped, number, lines)
         call multiply_slopes(spline, skipped, number, lines)
         if (spline%reach == 3) then
            call add_loads(3, number, lines, load, columns*grid%stride, size(sums), sums)
         else
            call add_loads(line, number, lines, load, columns*grid%stride, size(sums), sums)
         end if
      end do
      call add_nodes(low, high, size(patch, 2), 3, sums, 4, patch)
   end subroutine scatter_spline_stress

   !> Add the force of the loads of some particles, for a compile-time number of nodes along a line.
   pure subroutine add_loads(reach, number, lines, load, up, numbers, sums)
      integer, intent(in) :: reach                           !! Nodes along a line
      integer, intent(in) :: number                          !! Number of particles
      type(lines_t), intent(in) :: lines
      real(wp), intent(in) :: load(columns, 3, batch)        !! (component, direction, particle)
      integer, intent(in) :: up(3)                           !! Numbers from node to node
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp), dimension(columns) :: along, across
      real(wp), dimension(line) :: w, s
      integer :: p, j, k, c

      do p = 1, number
         w = lines%x(p, :)
         s = lines%slope_x(p, :)
         do k = 1, reach
            do j = 1, reach
               !$omp simd
               do c = 1, columns
                  along(c) = lines%yz(p, j, k)*load(c, 1, p)
                  across(c) = lines%slope_y(p, j, k)*load(c, 2, p) &
                     + lines%slope_z(p, j, k)*load(c, 3, p)
               end do
               call add_force(reach, w, s, along, across, &
                  lines%before(p) + (j - 1)*up(2) + (k - 1)*up(3), numbers, sums)
            end do
         end do
      end do
   end subroutine add_loads

   !> The same in planes and on lines.
   pure subroutine add_plane_loads(after, skipped, number, rows, node, low, weight, slope, load, &
      up, numbers, sums)
      integer, intent(in) :: after                           !! Layers after the first one
      integer, intent(in) :: skipped                         !! Index offset
      integer, intent(in) :: number                          !! Number of particles
      integer, intent(in) :: rows                            !! Length of the next four
      integer, intent(in) :: node(rows)                      !! (particle) First node
      integer, intent(in) :: low(rows, 3)                    !! (particle, direction) First in use
      real(wp), intent(in) :: weight(rows, line, 3)          !! (particle, node, direction)
      real(wp), intent(in) :: slope(rows, line, 3)           !! Derivatives of the functions [1/m]
      real(wp), intent(in) :: load(columns, 3, batch)        !! (component, direction, particle)
      integer, intent(in) :: up                              !! Numbers from layer to layer
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      real(wp), dimension(columns) :: along, across
      real(wp), dimension(line) :: w, s
      integer :: p, q, k, c, at

      do p = 1, number
         q = skipped + p
         at = columns*(node(q) - 1) + (low(q, 3) - 1)*up
         w = weight(q, :, 1)
         s = slope(q, :, 1)
         do k = low(q, 3), low(q, 3) + after
            !$omp simd
            do c = 1, columns
               along(c) = weight(q, k, 3)*load(c, 1, p)
               across(c) = slope(q, k, 3)*load(c, 3, p)
            end do
            call add_force(line, w, s, along, across, at, numbers, sums)
            at = at + up
         end do
      end do
   end subroutine add_plane_loads

   !> Add the force on the nodes of a line.
   pure subroutine add_force(reach, w, s, along, across, before, numbers, sums)
      integer, intent(in) :: reach                           !! Number of its nodes
      real(wp), intent(in) :: w(line), s(line)               !! Functions and derivatives [1/m]
      real(wp), intent(in) :: along(columns)                 !! Load of the derivatives
      real(wp), intent(in) :: across(columns)                !! Load of the functions
      integer, intent(in) :: before                          !! Numbers before the line
      integer, intent(in) :: numbers                         !! Four per node of the tile
      real(wp), intent(inout) :: sums(numbers)               !! (column, node), flat
      integer :: c

      !$omp simd
      do c = 1, columns
         sums(before + c) = sums(before + c) + (s(1)*along(c) + w(1)*across(c))
         sums(before + columns + c) = sums(before + columns + c) &
            + (s(2)*along(c) + w(2)*across(c))
         sums(before + 2*columns + c) = sums(before + 2*columns + c) &
            + (s(3)*along(c) + w(3)*across(c))
         if (reach == line) sums(before + 3*columns + c) = sums(before + 3*columns + c) &
            + (s(4)*along(c) + w(4)*across(c))
      end do
   end subroutine add_force

   !> Add mass and momentum of linear velocity fields (C. Jiang, C. Schroeder, A. Selle, J. Teran,
   !! A. Stomakhin, ACM Trans. Graph. 34 (2015) 51).
   pure subroutine scatter_spline_affine(grid, shape, first, mass, velocity, affine, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(columns*(size(patch, 2) + 1)), x(columns, line), y(columns, line)
      real(wp) :: z(columns, line), d, d_y, d_z, weight
      integer :: p, q, i, j, k, n, base, at, up, lines_after

      lines_after = merge(shape%spline%after, 0, grid%active(2))
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
         do k = shape%spline%low(p, 3), shape%spline%low(p, 3) + shape%spline%after
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
end module transfer_spline_kernels
