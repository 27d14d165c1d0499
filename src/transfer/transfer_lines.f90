! SPDX-License-Identifier: BSD-3-Clause
!> Maps with node functions that are products of functions of one coordinate, given along each
!! direction on the nodes -1 to 2 of the cell.
!!
!! All particles of a cell share a block of 4 nodes along each direction. The components of the four
!! nodes of a line along x lie together and are the lanes. Of the lines of a layer, all four are
!! taken, of the layers those that the particle touches. So few particles in a cell cost hardly more
!! than many, and the bits of a particle do not depend on others.
module transfer_lines
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_places, only: line, places_t
   implicit none
   private

   public :: collect_lines, collect_slopes, spread_affine_lines, spread_lines, spread_stress_lines

contains

   !> Node before the block of a cell.
   pure integer function before_block(grid, cell) result(node)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0

      node = grid%first_node(cell) - sum(grid%stride) - 1
   end function before_block

   !> Add a block to columns of the patch, which comes as one row of numbers.
   ! gate: long kernel because block and patch are told by their sizes
   pure subroutine add_block(grid, cell, count, columns, sums, before, rows, number, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      integer, intent(in) :: count                           !! Columns that are added
      integer, intent(in) :: columns                         !! Columns of the block
      real(wp), intent(in) :: sums(columns, line, line, line) !! (column, x, y, z)
      integer, intent(in) :: before                          !! Columns of the patch before them
      integer, intent(in) :: rows                            !! Columns of the patch
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(inout) :: patch(rows*number)          !! (column, node), flat
      integer :: length(3), base, at, i, j, k, c

      length = merge(line, 1, grid%active)
      base = before_block(grid, cell)
      do k = 1, length(3)
         do j = 1, length(2)
            at = before + rows*(base - 1 + (j - 1)*grid%stride(2) + (k - 1)*grid%stride(3))
            ! numbers that the compiler knows make the columns one vector
            select case (count)
            case (4)
               do i = 1, line
                  do c = 1, 4
                     patch(at + rows*i + c) = patch(at + rows*i + c) + sums(c, i, j, k)
                  end do
               end do
            case (3)
               do i = 1, line
                  do c = 1, 3
                     patch(at + rows*i + c) = patch(at + rows*i + c) + sums(c, i, j, k)
                  end do
               end do
            case default
               do i = 1, line
                  do c = 1, count
                     patch(at + rows*i + c) = patch(at + rows*i + c) + sums(c, i, j, k)
                  end do
               end do
            end select
         end do
      end do
   end subroutine add_block

   !> Add sum S_i value to columns of a patch, four columns at a time.
   pure subroutine spread_lines(grid, after, start, places, count, values, before, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(places_t), intent(in) :: places                   !! Of the tile
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(4*line, line, line), x(4, line), y(line), z, part(4)
      integer :: cell, p, i, k, c, skip

      part = 0.0_wp
      do skip = 0, count - 1, 4
         do cell = 0, grid%tile_cells - 1
            if (start(cell + 1) == start(cell)) cycle
            sums = 0.0_wp
            do p = start(cell) + 1, start(cell + 1)
               do c = 1, min(count - skip, 4)
                  part(c) = values(p, skip + c)
               end do
               do i = 1, line
                  y(i) = places%weight(p, i, 2)
                  do c = 1, 4
                     x(c, i) = places%weight(p, i, 1)*part(c)
                  end do
               end do
               do k = places%low(p, 3), places%low(p, 3) + after
                  z = places%weight(p, k, 3)
                  call add_layer(z, x, y, sums(1, 1, k))
               end do
            end do
            call add_block(grid, cell, min(count - skip, 4), 4, sums, before + skip, &
               size(patch, 1), size(patch, 2), patch)
         end do
      end do
   end subroutine spread_lines

   !> Add the values of a line, times a factor, to four lines with their weights.
   pure subroutine add_layer(z, x, y, sums)
      real(wp), intent(in) :: z                              !! Weight of the layer
      real(wp), intent(in) :: x(4*line)                      !! (column and node) A line
      real(wp), intent(in) :: y(line)                        !! Weights of the lines
      real(wp), intent(inout) :: sums(4*line, line)          !! (column and node, line)
      real(wp) :: value
      integer :: n

      !$omp simd private(value)
      do n = 1, 4*line
         value = z*x(n)
         sums(n, 1) = sums(n, 1) + y(1)*value
         sums(n, 2) = sums(n, 2) + y(2)*value
         sums(n, 3) = sums(n, 3) + y(3)*value
         sums(n, 4) = sums(n, 4) + y(4)*value
      end do
   end subroutine add_layer

   !> Add mass and momentum of linear velocity fields (C. Jiang, C. Schroeder, A. Selle, J. Teran,
   !! A. Stomakhin, ACM Trans. Graph. 34 (2015) 51).
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine spread_affine_lines(grid, after, start, first, places, mass, velocity, affine, &
      patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(places_t), intent(in) :: places                   !! Of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(4, line, line, line), x(4, line), y(4, line), z(4, line), plain(4, line)
      real(wp) :: d, weight
      integer :: cell, p, q, i, j, k, n

      y = 0.0_wp
      z = 0.0_wp
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            do i = 1, line
               weight = mass(q)*places%weight(p, i, 1)
               d = grid%spacing*(real(i - 2, wp) - places%local(p, 1))
               x(1, i) = weight
               do n = 1, 3
                  x(1 + n, i) = weight*(velocity(q, n) + affine(q, n)*d)
                  y(1 + n, i) = weight*affine(q, n + 3)
                  z(1 + n, i) = weight*affine(q, n + 6)
               end do
            end do
            do k = places%low(p, 3), places%low(p, 3) + after
               d = merge(grid%spacing*(real(k - 2, wp) - places%local(p, 3)), 0.0_wp, &
                  grid%active(3))
               plain = x + d*z
               do j = 1, line
                  d = merge(grid%spacing*(real(j - 2, wp) - places%local(p, 2)), 0.0_wp, &
                     grid%active(2))
                  weight = places%weight(p, j, 2)*places%weight(p, k, 3)
                  sums(:, :, j, k) = sums(:, :, j, k) + weight*(plain + d*y)
               end do
            end do
         end do
         call add_block(grid, cell, 4, 4, sums, 0, size(patch, 1), size(patch, 2), patch)
      end do
   end subroutine spread_affine_lines

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
   pure subroutine spread_stress_lines(grid, after, start, first, places, volume, stress, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(places_t), intent(in) :: places                   !! Of the tile
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer, parameter :: at(3, 3) = reshape([1, 4, 6, 4, 2, 5, 6, 5, 3], [3, 3])
      real(wp) :: sums(3*line, line, line), x(3, line), y(3, line), z(3, line), b(line), db(line), v
      integer :: cell, p, q, i, k, n

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            v = -volume(q)
            do i = 1, line
               b(i) = places%weight(p, i, 2)
               db(i) = places%slope(p, i, 2)
               do n = 1, 3
                  x(n, i) = places%slope(p, i, 1)*(v*stress(q, at(n, 1)))
                  y(n, i) = places%weight(p, i, 1)*(v*stress(q, at(n, 2)))
                  z(n, i) = places%weight(p, i, 1)*(v*stress(q, at(n, 3)))
               end do
            end do
            do k = places%low(p, 3), places%low(p, 3) + after
               call add_forces(places%weight(p, k, 3), places%slope(p, k, 3), b, db, x, y, z, &
                  sums(1, 1, k))
            end do
         end do
         call add_block(grid, cell, 3, 3, sums, 4, size(patch, 1), size(patch, 2), patch)
      end do
   end subroutine spread_stress_lines

   !> Add forces to four lines.
   pure subroutine add_forces(c, dc, b, db, x, y, z, sums)
      real(wp), intent(in) :: c                              !! Function of the layer
      real(wp), intent(in) :: dc                             !! Its derivative [1/m]
      real(wp), intent(in) :: b(line)                        !! Functions of the lines
      real(wp), intent(in) :: db(line)                       !! Their derivatives [1/m]
      real(wp), intent(in) :: x(3*line)                      !! (component and node) By S_x' [N]
      real(wp), intent(in) :: y(3*line)                      !! By S_y' [Nm]
      real(wp), intent(in) :: z(3*line)                      !! By S_z' [Nm]
      real(wp), intent(inout) :: sums(3*line, line)          !! (component and node, line) [N]
      real(wp) :: even, odd
      integer :: n

      !$omp simd private(even, odd)
      do n = 1, 3*line
         even = c*x(n) + dc*z(n)
         odd = c*y(n)
         sums(n, 1) = sums(n, 1) + (b(1)*even + db(1)*odd)
         sums(n, 2) = sums(n, 2) + (b(2)*even + db(2)*odd)
         sums(n, 3) = sums(n, 3) + (b(3)*even + db(3)*odd)
         sums(n, 4) = sums(n, 4) + (b(4)*even + db(4)*odd)
      end do
   end subroutine add_forces

   !> Values sum S_i node_i of three columns. The nodes come as one row of numbers, in which those
   !! of a line lie together.
   pure subroutine collect_lines(grid, after, start, places, number, nodes, skip, values)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(places_t), intent(in) :: places                   !! Of the tile
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(in) :: nodes(3*number)                !! (column, node), flat
      integer, intent(in) :: skip                            !! Columns of the values before them
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: sums(3*line), y(line), z
      integer :: cell, p, k, n, base, at

      do cell = 0, grid%tile_cells - 1
         base = before_block(grid, cell)
         do p = start(cell) + 1, start(cell + 1)
            sums = 0.0_wp
            do n = 1, line
               y(n) = places%weight(p, n, 2)
            end do
            do k = places%low(p, 3), places%low(p, 3) + after
               at = 3*(base + (k - 1)*grid%stride(3))
               z = places%weight(p, k, 3)
               associate (up => 3*grid%stride(2))
                  !$omp simd
                  do n = 1, 3*line
                     sums(n) = sums(n) + z*((y(1)*nodes(at + n) + y(2)*nodes(at + up + n)) &
                        + (y(3)*nodes(at + 2*up + n) + y(4)*nodes(at + 3*up + n)))
                  end do
               end associate
            end do
            do n = 1, 3
               values(p, skip + n) = (places%weight(p, 1, 1)*sums(n) &
                  + places%weight(p, 2, 1)*sums(n + 3)) + (places%weight(p, 3, 1)*sums(n + 6) &
                  + places%weight(p, 4, 1)*sums(n + 9))
            end do
         end do
      end do
   end subroutine collect_lines

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l. The nodes come as one row of numbers.
   pure subroutine collect_slopes(grid, after, start, places, number, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: after                           !! Layers after the first one
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(places_t), intent(in) :: places                   !! Of the tile
      integer, intent(in) :: number                          !! Nodes of the tile
      real(wp), intent(in) :: nodes(3*number)                !! (3, node) Velocity, flat [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: x(3*line), y(3*line), z(3*line), b(line), db(line), c, dc, even, odd
      integer :: cell, p, k, n, base, at

      do cell = 0, grid%tile_cells - 1
         base = before_block(grid, cell)
         do p = start(cell) + 1, start(cell + 1)
            x = 0.0_wp
            y = 0.0_wp
            z = 0.0_wp
            do n = 1, line
               b(n) = places%weight(p, n, 2)
               db(n) = places%slope(p, n, 2)
            end do
            do k = places%low(p, 3), places%low(p, 3) + after
               at = 3*(base + (k - 1)*grid%stride(3))
               c = scale*places%weight(p, k, 3)
               dc = scale*places%slope(p, k, 3)
               associate (up => 3*grid%stride(2))
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
               end associate
            end do
            do n = 1, line
               b(n) = places%weight(p, n, 1)
               db(n) = places%slope(p, n, 1)
            end do
            do n = 1, 3
               gradient(p, n) = (db(1)*x(n) + db(2)*x(n + 3)) + (db(3)*x(n + 6) + db(4)*x(n + 9))
               gradient(p, n + 3) = (b(1)*y(n) + b(2)*y(n + 3)) + (b(3)*y(n + 6) + b(4)*y(n + 9))
               gradient(p, n + 6) = (b(1)*z(n) + b(2)*z(n + 3)) + (b(3)*z(n + 6) + b(4)*z(n + 9))
            end do
         end do
      end do
   end subroutine collect_slopes
end module transfer_lines
