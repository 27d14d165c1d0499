! SPDX-License-Identifier: BSD-3-Clause
!> Single values from nodes to particles with the linear functions of the cell: the coefficients of
!! the polynomial of a cell are found once, then particles of the cell are the lanes, eight in three
!! dimensions and four in a plane.
!!
!! The terms are 1, x, z, xz, y, xy, yz, xyz of the local coordinates, in a plane the first four.
!! Coefficients are differences, so that a uniform field has slopes of exactly zero; four components
!! of the field are the lanes, whatever the number of particles in the cell.
!!
!! The last lanes of a cell may hold particles of the next cells or none. Their values are
!! overwritten when those cells are processed, so cells are processed in order, and columns have
!! `spare` rows after the last particle.
module transfer_gather_values
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   implicit none
   private

   public :: find_polynomial, find_terms, gather_hoop, gather_values, gather_vector

   integer, parameter :: half = lanes/2              !! Particles at a time in a plane
   integer, parameter :: plane_terms = 4             !! Terms of a polynomial in a plane

contains

   !> Hoop rate of axisymmetry, scale u_r / r, into component (2, 2) of the gradient. Equation
   !! (M.25) of doc/theory/method.md.
   pure subroutine gather_hoop(grid, start, first, local, position, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: u(lanes)
      integer :: cell, p

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_polynomial(grid, cell, 1, scale, nodes, u)
         do p = start(cell) + 1, start(cell + 1), half
            call find_plane(1, 1, u, p, size(local, 1), local, size(gradient, 1), gradient(:, 5))
         end do
      end do
      do p = 1, start(grid%tile_cells)
         gradient(p, 5) = gradient(p, 5)/position(first + p - 1, 1)
      end do
   end subroutine gather_hoop

   !> Particle vectors from node vectors: values = keep values + scale sum S_i nodes_i.
   pure subroutine gather_vector(grid, start, first, local, nodes, kept, scale, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node)
      real(wp), intent(in) :: kept                           !! Fraction of the old values [1]
      real(wp), intent(in) :: scale                          !! Factor of the node values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle, 3)
      real(wp) :: gain(size(local, 1), 3)
      integer :: p, k

      call gather_values(grid, start, local, nodes, gain)
      do k = 1, 3
         do p = 1, start(grid%tile_cells)
            values(first + p - 1, k) = kept*values(first + p - 1, k) + scale*gain(p, k)
         end do
      end do
   end subroutine gather_vector

   !> Values sum S_i node_i of any number of columns.
   pure subroutine gather_values(grid, start, local, nodes, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      integer :: rows

      rows = 4*((size(nodes, 1) + 3)/4)
      if (grid%dimensions == 3) then
         call gather_space(grid, start, local, rows, nodes, values)
      else
         call gather_plane(grid, start, local, rows, nodes, values)
      end if
   end subroutine gather_values

   !> The same in three dimensions.
   pure subroutine gather_space(grid, start, local, rows, nodes, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      integer, intent(in) :: rows                            !! Columns, a multiple of four
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: u(rows, lanes)
      integer :: cell, p, ways(lanes)

      ways = size(nodes, 1)*grid%lane_offset
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_terms(size(nodes, 1), rows, grid%first_node(cell), ways, size(nodes), nodes, &
            1.0_wp, u)
         do p = start(cell) + 1, start(cell + 1), lanes
            call find_space(size(nodes, 1), rows, u, p, size(local, 1), local, size(values, 1), &
               values)
         end do
      end do
   end subroutine gather_space

   !> The same in a plane or on a line.
   pure subroutine gather_plane(grid, start, local, rows, nodes, values)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      integer, intent(in) :: rows                            !! Columns, a multiple of four
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: u(rows, plane_terms)
      integer :: cell, p, ways(plane_terms)

      ways = size(nodes, 1)*grid%lane_offset(:plane_terms)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_plane_terms(size(nodes, 1), rows, grid%first_node(cell), ways, size(nodes), &
            nodes, u)
         do p = start(cell) + 1, start(cell + 1), half
            call find_plane(size(nodes, 1), rows, u, p, size(local, 1), local, size(values, 1), &
               values)
         end do
      end do
   end subroutine gather_plane

   !> Coefficients of the polynomial of one component of a node field in a cell, by differences
   !! along x, then z, then y; those of a missing direction are not found.
   pure subroutine find_polynomial(grid, cell, component, scale, nodes, u)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      integer, intent(in) :: component                       !! Component of the field
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (component, node)
      real(wp), intent(inout) :: u(lanes) !! Coefficients of 1, x, z, xz, y, xy, yz, xyz
      integer :: lane, base, last

      base = grid%first_node(cell)
      last = merge(lanes, lanes/2, grid%dimensions == 3)
      do lane = 1, last
         u(lane) = scale*nodes(component, base + grid%lane_offset(lane))
      end do
      u(2) = u(2) - u(1)
      u(4) = u(4) - u(3)
      u(3) = u(3) - u(1)
      u(4) = u(4) - u(2)
      if (last < lanes) return
      u(6) = u(6) - u(5)
      u(8) = u(8) - u(7)
      u(7) = u(7) - u(5)
      u(8) = u(8) - u(6)
      do lane = 1, 4
         u(lane + 4) = u(lane + 4) - u(lane)
      end do
   end subroutine find_polynomial

   !> Values of polynomials with all terms at eight particles.
   pure subroutine find_space(columns, rows, u, p, length, local, depth, values)
      integer, intent(in) :: columns                         !! Number of columns of the values
      integer, intent(in) :: rows !! Columns, rounded up to a multiple of four
      real(wp), intent(in) :: u(rows, lanes)                 !! (column, term) Coefficients
      integer, intent(in) :: p                               !! First of the particles
      integer, intent(in) :: length                          !! Length of a column of `local`
      real(wp), intent(in) :: local(length, 3)               !! (particle, 3) Local coordinates
      integer, intent(in) :: depth                           !! Length of a column of `values`
      real(wp), intent(inout) :: values(depth, columns)      !! (particle, column)
      integer :: c

      do c = 1, columns
         call evaluate_space(rows, u(c, 1), local(p, 1), local(p, 2), local(p, 3), values(p, c))
      end do
   end subroutine find_space

   !> Values of a polynomial at eight particles.
   pure subroutine evaluate_space(rows, u, x, y, z, values)
      integer, intent(in) :: rows                            !! Distance between terms in the array
      real(wp), intent(in) :: u(rows*(lanes - 1) + 1)        !! Coefficients
      real(wp), intent(in) :: x(lanes), y(lanes), z(lanes)   !! (lane) Local coordinates [1]
      real(wp), intent(inout) :: values(lanes)               !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         values(lane) = ((u(1) + u(rows + 1)*x(lane)) &
            + (u(2*rows + 1) + u(3*rows + 1)*x(lane))*z(lane)) &
            + ((u(4*rows + 1) + u(5*rows + 1)*x(lane)) &
            + (u(6*rows + 1) + u(7*rows + 1)*x(lane))*z(lane))*y(lane)
      end do
   end subroutine evaluate_space

   !> Values of polynomials of x and z at four particles.
   pure subroutine find_plane(columns, rows, u, p, length, local, depth, values)
      integer, intent(in) :: columns                         !! Number of columns of the values
      integer, intent(in) :: rows !! Columns, rounded up to a multiple of four
      real(wp), intent(in) :: u(rows, plane_terms)           !! (column, term) Coefficients
      integer, intent(in) :: p                               !! First of the particles
      integer, intent(in) :: length                          !! Length of a column of `local`
      real(wp), intent(in) :: local(length, 3)               !! (particle, 3) Local coordinates
      integer, intent(in) :: depth                           !! Length of a column of `values`
      real(wp), intent(inout) :: values(depth, columns)      !! (particle, column)
      integer :: c

      do c = 1, columns
         call evaluate_plane(u(c, 1), u(c, 2), u(c, 3), u(c, 4), local(p, 1), local(p, 3), &
            values(p, c))
      end do
   end subroutine find_plane

   !> Values of a polynomial at four particles.
   pure subroutine evaluate_plane(u1, u2, u3, u4, x, z, values)
      real(wp), intent(in) :: u1, u2, u3, u4                 !! Coefficients
      real(wp), intent(in) :: x(half), z(half)               !! (lane) Local coordinates [1]
      real(wp), intent(inout) :: values(half)                !! (lane)
      integer :: lane

      !$omp simd
      do lane = 1, half
         values(lane) = (u1 + u2*x(lane)) + (u3 + u4*x(lane))*z(lane)
      end do
   end subroutine evaluate_plane
   !> Coefficients of the polynomials of the components of a field in a cell, the terms being 1, x,
   !! z, xz, y, xy, yz, xyz. The node field is a one-dimensional array with four elements as lanes:
   !! elements of the next node fill the lanes up to a multiple of four, and have no meaning.
   pure subroutine find_terms(components, rows, node, ways, numbers, nodes, scale, u)
      integer, intent(in) :: components              !! Numbers per node
      integer, intent(in) :: rows                    !! Columns, rounded up to a multiple of four
      integer, intent(in) :: node                    !! First node of the cell
      integer, intent(in) :: ways(lanes)             !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(rows, lanes)      !! (component, term)
      integer :: part, before

      before = components*(node - 1)
      if (before + ways(lanes) + rows > numbers) then
         call find_last_terms(components, rows, before, ways, numbers, nodes, scale, u)
         return
      end if
      do part = 0, rows - 1, 4
         call take_differences(before + part, ways, numbers, nodes, scale, rows, u(part + 1, 1))
      end do
   end subroutine find_terms

   !> The same for a cell with the last node of the tile, at the end of the array.
   pure subroutine find_last_terms(components, rows, before, ways, numbers, nodes, scale, u)
      integer, intent(in) :: components              !! Numbers per node
      integer, intent(in) :: rows                    !! Columns, rounded up to a multiple of four
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(lanes)             !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(rows, lanes)      !! (component, term)
      real(wp) :: padded(rows, lanes)
      integer :: part, lane

      padded = 0.0_wp
      do lane = 1, lanes
         padded(:components, lane) = nodes(before + ways(lane) + 1:before + ways(lane) + components)
      end do
      do part = 0, rows - 1, 4
         call take_differences(part, [(rows*(lane - 1), lane=1, lanes)], size(padded), padded, &
            scale, rows, u(part + 1, 1))
      end do
   end subroutine find_last_terms

   !> From the values on the eight nodes of a cell to the coefficients of its polynomial:
   !! differences along x, then z, then y. Four components are the lanes.
   pure subroutine take_differences(before, ways, numbers, nodes, scale, rows, u)
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(lanes)             !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      integer, intent(in) :: rows                    !! Distance between terms in the array
      real(wp), intent(inout) :: u(rows*(lanes - 1) + 4) !! (component and term)
      real(wp) :: u1, u2, u3, u4, u5, u6, u7, u8
      integer :: c

      !$omp simd private(u1, u2, u3, u4, u5, u6, u7, u8)
      do c = 1, 4
         u1 = scale*nodes(before + c)
         u2 = scale*nodes(before + ways(2) + c) - u1
         u3 = scale*nodes(before + ways(3) + c)
         u4 = scale*nodes(before + ways(4) + c) - u3
         u5 = scale*nodes(before + ways(5) + c)
         u6 = scale*nodes(before + ways(6) + c) - u5
         u7 = scale*nodes(before + ways(7) + c)
         u8 = scale*nodes(before + ways(8) + c) - u7
         u3 = u3 - u1
         u4 = u4 - u2
         u7 = u7 - u5
         u8 = u8 - u6
         u(c) = u1
         u(rows + c) = u2
         u(2*rows + c) = u3
         u(3*rows + c) = u4
         u(4*rows + c) = u5 - u1
         u(5*rows + c) = u6 - u2
         u(6*rows + c) = u7 - u3
         u(7*rows + c) = u8 - u4
      end do
   end subroutine take_differences

   !> The same in a plane or on a line: the terms 1, x, z, xz, of which a line uses the first two.
   pure subroutine find_plane_terms(components, rows, node, ways, numbers, nodes, u)
      integer, intent(in) :: components              !! Numbers per node
      integer, intent(in) :: rows                    !! Columns, rounded up to a multiple of four
      integer, intent(in) :: node                    !! First node of the cell
      integer, intent(in) :: ways(plane_terms)       !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(inout) :: u(rows, plane_terms) !! (component, term)
      real(wp) :: padded(rows, plane_terms)
      integer :: part, before, lane

      before = components*(node - 1)
      if (before + ways(plane_terms) + rows > numbers) then
         padded = 0.0_wp
         do lane = 1, plane_terms
            padded(:components, lane) = nodes(before + ways(lane) + 1:before + ways(lane) &
               + components)
         end do
         do part = 0, rows - 1, 4
            call take_plane_differences(part, [0, rows, 2*rows, 3*rows], size(padded), padded, &
               rows, u(part + 1, 1))
         end do
         return
      end if
      do part = 0, rows - 1, 4
         call take_plane_differences(before + part, ways, numbers, nodes, rows, u(part + 1, 1))
      end do
   end subroutine find_plane_terms

   !> Differences along x, then z. Four components are the lanes.
   pure subroutine take_plane_differences(before, ways, numbers, nodes, rows, u)
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(plane_terms)       !! Offset of the numbers of a node
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      integer, intent(in) :: rows                    !! Distance between terms in the array
      real(wp), intent(inout) :: u(rows*(plane_terms - 1) + 4) !! (component and term)
      real(wp) :: u1, u2, u3
      integer :: c

      !$omp simd private(u1, u2, u3)
      do c = 1, 4
         u1 = nodes(before + c)
         u2 = nodes(before + ways(2) + c) - u1
         u3 = nodes(before + ways(3) + c)
         u(c) = u1
         u(rows + c) = u2
         u(2*rows + c) = u3 - u1
         u(3*rows + c) = (nodes(before + ways(4) + c) - u3) - u2
      end do
   end subroutine take_plane_differences
end module transfer_gather_values
