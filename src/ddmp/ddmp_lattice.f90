! SPDX-License-Identifier: BSD-3-Clause
!> The integrals of the dual gradient as products of functions of one coordinate each, for all cells
!! of a tile at once.
!!
!! D_ji of a cell is a derivative along one direction times integrals along the three, so it is
!! applied direction by direction: a dozen additions a component of a cell instead of 64 products.
!! A tile is one row of numbers, three components a node, and the next node along a direction is a
!! fixed number of places away. Places that are no cell's first node have the weight zero.
!! In a plane and on a line vectors have no component along y, so a node has two numbers, and
!! integrals of products are those along a single other direction.
module ddmp_lattice
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: lattice_t, spread_force, spread_gradient

   integer, parameter :: parts = 3                   !! Components of a vector
   integer, parameter :: plane = 2                   !! The same in a plane, along x and z

   !> Functions of one coordinate on the nodes of a tile, as rows of numbers. In axisymmetry those
   !! along x depend on the radius and thus on the tile.
   type :: lattice_t
      integer :: parts = parts                       !! Components of a vector that count
      integer :: numbers = 0                         !! So many a node
      integer :: shift(3) = 0                        !! (direction) Numbers to the next node
      !> (number, lower or upper node, direction, tile along x) Integral of a function [m]
      real(wp), allocatable :: line(:, :, :, :)
      !> (number, both lower / mixed / both upper, direction, tile along x) Of a product [m]
      real(wp), allocatable :: mass(:, :, :, :)
      real(wp) :: factor = 0.0_wp                    !! Depth of missing directions over the spacing
   contains
      procedure :: start => lattice_start            !! Compute the functions
   end type lattice_t

contains

   !> Compute the functions of all tiles along x that differ.
   subroutine lattice_start(self, grid)
      class(lattice_t), intent(inout) :: self        !! The functions
      type(grid_t), intent(in) :: grid               !! The grid
      integer :: direction, node, tile, tiles, at, along, place(3)
      real(wp) :: weight(0:1), products(0:1, 0:1)

      tiles = merge(grid%tiles(1), 1, grid%axisymmetric)
      self%parts = merge(parts, plane, grid%dimensions == 3)
      self%numbers = self%parts*grid%tile_nodes
      self%shift = self%parts*grid%stride
      self%factor = grid%depth/grid%spacing
      if (allocated(self%line)) deallocate (self%line, self%mass)
      allocate (self%line(self%numbers, 2, 3, tiles), self%mass(self%numbers, 3, 3, tiles))
      self%line = 0.0_wp
      self%mass = 0.0_wp
      do tile = 1, tiles
         do node = 1, grid%tile_nodes
            at = self%parts*(node - 1)
            place = grid%node_position(node)
            do direction = 1, 3
               ! nothing of the tile lies after the last node of a line, or before the first
               if (place(direction) < 0 .or. place(direction) >= grid%width(direction)) cycle
               along = place(direction)
               if (direction == 1) along = along + (tile - 1)*grid%width(1)
               weight = grid%line_weight(direction, along)
               products = grid%mass_weight(direction, along)
               self%line(at + 1:at + self%parts, 1, direction, tile) = weight(0)
               self%line(at + 1:at + self%parts, 2, direction, tile) = weight(1)
               self%mass(at + 1:at + self%parts, 1, direction, tile) = products(0, 0)
               self%mass(at + 1:at + self%parts, 2, direction, tile) = products(0, 1)
               self%mass(at + 1:at + self%parts, 3, direction, tile) = products(1, 1)
            end do
         end do
      end do
   end subroutine lattice_start

   !> Weights of cells as rows of numbers, on their first nodes, and the numbers between which there
   !! are some: sparse tiles are looked at only where they have matter.
   pure subroutine lay_weights(grid, parts, weight, row, low, high)
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: parts                   !! Numbers a node, two or three
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(inout) :: row(:)  !! (number)
      integer, intent(out) :: low                    !! First number of a cell with a weight
      integer, intent(out) :: high                   !! Last one; below the first if there is none
      integer :: cell, at

      row = 0.0_wp
      low = size(row) + 1
      high = 0
      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > 0.0_wp) cycle
         at = parts*(grid%first_node(cell) - 1)
         row(at + 1) = weight(cell)
         row(at + 2) = weight(cell)
         row(at + parts) = weight(cell)
         low = min(low, at + 1)
         high = at + parts
      end do
   end subroutine lay_weights

   !> Add the force of the node stress, - sum_j sigma_j . D_ji, of the cells of a tile.
   pure subroutine spread_force(self, grid, tile, weight, stress, patch)
      type(lattice_t), intent(in) :: self            !! The functions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: tile                    !! Tile along x, from 1
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: stress(:, :) !! (9, node) (k, l) in row k + 3 (l - 1) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [N]
      real(wp) :: row(self%numbers), field(self%numbers), means(self%numbers), sums(self%numbers)
      integer :: low, high, l, one, other, last, node, k

      if (grid%dimensions < 3) then
         call force_plane(self, grid, tile, weight, stress, patch)
         return
      end if
      call lay_weights(grid, parts, weight, row, low, high)
      if (high < low) return
      last = high + sum(self%shift)
      do l = 1, 3
         if (.not. grid%active(l)) cycle
         call others(l, one, other)
         do node = (low + 2)/parts, (last + 2)/parts
            do k = 1, parts
               field(parts*(node - 1) + k) = stress(k + 3*(l - 1), node)
            end do
         end do
         call mean_along(self%numbers, low, last - self%shift(l), self%shift(l), &
            self%line(:, :, l, tile), field, means)
         call apply_mass(self%numbers, low, high, self%shift(one), self%shift(other), &
            self%mass(:, :, one, tile), self%mass(:, :, other, tile), row, means, sums)
         call add_difference(self%numbers, low, last - self%shift(l), self%shift(l), self%factor, &
            sums, patch)
      end do
   end subroutine spread_force

   !> Add sum_i u_i D_ji of the cells of a tile.
   pure subroutine spread_gradient(self, grid, tile, weight, velocity, patch)
      type(lattice_t), intent(in) :: self            !! The functions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: tile                    !! Tile along x, from 1
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (9, node) (k, l) in row k + 3 (l - 1)
      real(wp) :: row(self%numbers), field(self%numbers), sums(self%numbers)
      integer :: low, high, l, one, other, last, node, k

      if (grid%dimensions < 3) then
         call gradient_plane(self, grid, tile, weight, velocity, patch)
         return
      end if
      call lay_weights(grid, parts, weight, row, low, high)
      if (high < low) return
      last = high + sum(self%shift)
      do l = 1, 3
         if (.not. grid%active(l)) cycle
         call others(l, one, other)
         call difference_along(self%numbers, low, last - self%shift(l), self%shift(l), &
            self%factor, velocity, field)
         call apply_mass(self%numbers, low, high, self%shift(one), self%shift(other), &
            self%mass(:, :, one, tile), self%mass(:, :, other, tile), row, field, sums)
         field(low:last) = 0.0_wp
         call add_line(self%numbers, low, last - self%shift(l), self%shift(l), &
            self%line(:, :, l, tile), sums, field)
         do node = (low + 2)/parts, (last + 2)/parts
            do k = 1, parts
               patch(k + 3*(l - 1), node) = patch(k + 3*(l - 1), node) + field(parts*(node - 1) + k)
            end do
         end do
      end do
   end subroutine spread_gradient

   !> The force in a plane or on a line.
   pure subroutine force_plane(self, grid, tile, weight, stress, patch)
      type(lattice_t), intent(in) :: self            !! The functions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: tile                    !! Tile along x, from 1
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: stress(:, :) !! (9, node) (k, l) in row k + 3 (l - 1) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [N]
      real(wp) :: row(self%numbers), field(self%numbers), means(self%numbers), sums(self%numbers)
      real(wp) :: force(self%numbers)
      integer :: low, high, l, last, node

      call lay_weights(grid, plane, weight, row, low, high)
      if (high < low) return
      last = high + sum(self%shift)
      force(low:last) = 0.0_wp
      do l = 1, 3, 2
         if (.not. grid%active(l)) cycle
         do node = (low + 1)/plane, (last + 1)/plane
            field(2*node - 1) = stress(3*l - 2, node)
            field(2*node) = stress(3*l, node)
         end do
         call mean_along(self%numbers, low, last - self%shift(l), self%shift(l), &
            self%line(:, :, l, tile), field, means)
         call apply_line_mass(self%numbers, low, high, self%shift(4 - l), &
            self%mass(:, :, 4 - l, tile), row, means, sums)
         call add_difference(self%numbers, low, last - self%shift(l), self%shift(l), self%factor, &
            sums, force)
      end do
      do node = (low + 1)/plane, (last + 1)/plane
         patch(1, node) = patch(1, node) + force(2*node - 1)
         patch(3, node) = patch(3, node) + force(2*node)
      end do
   end subroutine force_plane

   !> The node gradient in a plane or on a line.
   pure subroutine gradient_plane(self, grid, tile, weight, velocity, patch)
      type(lattice_t), intent(in) :: self            !! The functions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: tile                    !! Tile along x, from 1
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (9, node) (k, l) in row k + 3 (l - 1)
      real(wp) :: row(self%numbers), field(self%numbers), slopes(self%numbers), sums(self%numbers)
      integer :: low, high, l, last, node

      call lay_weights(grid, plane, weight, row, low, high)
      if (high < low) return
      last = high + sum(self%shift)
      do node = (low + 1)/plane, (last + 1)/plane
         field(2*node - 1) = velocity(1, node)
         field(2*node) = velocity(3, node)
      end do
      do l = 1, 3, 2
         if (.not. grid%active(l)) cycle
         call difference_along(self%numbers, low, last - self%shift(l), self%shift(l), &
            self%factor, field, slopes)
         call apply_line_mass(self%numbers, low, high, self%shift(4 - l), &
            self%mass(:, :, 4 - l, tile), row, slopes, sums)
         slopes(low:last) = 0.0_wp
         call add_line(self%numbers, low, last - self%shift(l), self%shift(l), &
            self%line(:, :, l, tile), sums, slopes)
         do node = (low + 1)/plane, (last + 1)/plane
            patch(3*l - 2, node) = patch(3*l - 2, node) + slopes(2*node - 1)
            patch(3*l, node) = patch(3*l, node) + slopes(2*node)
         end do
      end do
   end subroutine gradient_plane

   !> The two directions besides one.
   pure subroutine others(direction, one, other)
      integer, intent(in) :: direction               !! Of the derivative
      integer, intent(out) :: one                    !! The lower of the others
      integer, intent(out) :: other                  !! The higher

      one = merge(2, 1, direction == 1)
      other = merge(2, 3, direction == 3)
   end subroutine others

   !> Integrals along a direction of what stands on the nodes.
   pure subroutine mean_along(numbers, low, high, shift, line, field, means)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First of those looked at
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: shift                   !! Numbers to the next node
      real(wp), intent(in) :: line(numbers, 2)       !! Integrals of the two functions [m]
      real(wp), intent(in) :: field(numbers)         !! On the nodes
      real(wp), intent(inout) :: means(numbers)      !! Between a node and the next [field m]
      integer :: n

      !$omp simd
      do n = low, high
         means(n) = line(n, 1)*field(n) + line(n, 2)*field(n + shift)
      end do
   end subroutine mean_along

   !> The transpose of that.
   pure subroutine add_line(numbers, low, high, shift, line, sums, field)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First of those looked at
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: shift                   !! Numbers to the next node
      real(wp), intent(in) :: line(numbers, 2)       !! Integrals of the two functions [m]
      real(wp), intent(in) :: sums(numbers)          !! Between a node and the next
      real(wp), intent(inout) :: field(numbers)      !! On the nodes
      integer :: n

      !$omp simd
      do n = low, high
         field(n) = field(n) + line(n, 1)*sums(n)
      end do
      call add_shifted(numbers, low, high, shift, line(1, 2), sums, field)
   end subroutine add_line

   !> Add products to the numbers a few places on.
   pure subroutine add_shifted(numbers, low, high, shift, line, sums, field)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First of those looked at
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: shift                   !! Places
      real(wp), intent(in) :: line(numbers)          !! Factors
      real(wp), intent(in) :: sums(numbers)          !! Multiplied by them
      real(wp), intent(inout) :: field(numbers)      !! Gets the products
      integer :: n

      !$omp simd
      do n = low, high
         field(n + shift) = field(n + shift) + line(n)*sums(n)
      end do
   end subroutine add_shifted

   !> Differences along a direction, times a factor.
   pure subroutine difference_along(numbers, low, high, shift, factor, field, differences)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First of those looked at
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: shift                   !! Numbers to the next node
      real(wp), intent(in) :: factor                 !! Factor
      real(wp), intent(in) :: field(numbers)         !! On the nodes
      real(wp), intent(inout) :: differences(numbers) !! Between a node and the next
      integer :: n

      !$omp simd
      do n = low, high
         differences(n) = factor*(field(n + shift) - field(n))
      end do
   end subroutine difference_along

   !> Minus the transpose of that: what one node gains the other loses.
   pure subroutine add_difference(numbers, low, high, shift, factor, sums, field)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First of those looked at
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: shift                   !! Numbers to the next node
      real(wp), intent(in) :: factor                 !! Factor
      real(wp), intent(in) :: sums(numbers)          !! Between a node and the next
      real(wp), intent(inout) :: field(numbers)      !! On the nodes
      integer :: n

      !$omp simd
      do n = low, high
         field(n) = field(n) + factor*sums(n)
      end do
      !$omp simd
      do n = low, high
         field(n + shift) = field(n + shift) - factor*sums(n)
      end do
   end subroutine add_difference

   !> Integrals of products with both functions along two directions, times the weights of cells,
   !! summed over the cells around.
   ! gate: long kernel because two directions are told by their shifts and integrals
   pure subroutine apply_mass(numbers, low, high, one, other, first, second, weight, field, sums)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First number of a cell
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: one                     !! Numbers to the next node, first direction
      integer, intent(in) :: other                   !! The same, second direction
      real(wp), intent(in) :: first(numbers, 3)      !! Integrals of products, first direction [m]
      real(wp), intent(in) :: second(numbers, 3)     !! The same, second direction
      real(wp), intent(in) :: weight(numbers)        !! Weights of cells on their first nodes
      real(wp), intent(in) :: field(numbers)         !! On the four corners of a face
      real(wp), intent(inout) :: sums(numbers)       !! The same
      real(wp) :: part(numbers, 4), a0, a1, b0, b1
      integer :: n

      !$omp simd private(a0, a1, b0, b1)
      do n = low, high
         a0 = first(n, 1)*field(n) + first(n, 2)*field(n + one)
         a1 = first(n, 2)*field(n) + first(n, 3)*field(n + one)
         b0 = first(n, 1)*field(n + other) + first(n, 2)*field(n + one + other)
         b1 = first(n, 2)*field(n + other) + first(n, 3)*field(n + one + other)
         part(n, 1) = weight(n)*(second(n, 1)*a0 + second(n, 2)*b0)
         part(n, 2) = weight(n)*(second(n, 1)*a1 + second(n, 2)*b1)
         part(n, 3) = weight(n)*(second(n, 2)*a0 + second(n, 3)*b0)
         part(n, 4) = weight(n)*(second(n, 2)*a1 + second(n, 3)*b1)
      end do
      sums(low:high + one + other) = 0.0_wp
      call add_part(numbers, low, high, 0, part(1, 1), sums)
      call add_part(numbers, low, high, one, part(1, 2), sums)
      call add_part(numbers, low, high, other, part(1, 3), sums)
      call add_part(numbers, low, high, one + other, part(1, 4), sums)
   end subroutine apply_mass

   !> The same along a single direction.
   ! gate: long kernel because a direction is told by its shift and integrals
   pure subroutine apply_line_mass(numbers, low, high, shift, mass, weight, field, sums)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First number of a cell
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: shift                   !! Numbers to the next node, 0 if missing
      real(wp), intent(in) :: mass(numbers, 3)       !! Integrals of products [m]
      real(wp), intent(in) :: weight(numbers)        !! Weights of cells on their first nodes
      real(wp), intent(in) :: field(numbers)         !! On the two corners of an edge
      real(wp), intent(inout) :: sums(numbers)       !! The same
      real(wp) :: part(numbers)
      integer :: n

      !$omp simd
      do n = low, high
         sums(n) = weight(n)*(mass(n, 1)*field(n) + mass(n, 2)*field(n + shift))
         part(n) = weight(n)*(mass(n, 2)*field(n) + mass(n, 3)*field(n + shift))
      end do
      sums(high + 1:high + shift) = 0.0_wp
      call add_part(numbers, low, high, shift, part, sums)
   end subroutine apply_line_mass

   !> Add numbers a few places on.
   pure subroutine add_part(numbers, low, high, shift, part, sums)
      integer, intent(in) :: numbers                 !! Of the tile
      integer, intent(in) :: low                     !! First of those looked at
      integer, intent(in) :: high                    !! Last one
      integer, intent(in) :: shift                   !! Places
      real(wp), intent(in) :: part(numbers)          !! What is added
      real(wp), intent(inout) :: sums(numbers)       !! Gets it
      integer :: n

      !$omp simd
      do n = low, high
         sums(n + shift) = sums(n + shift) + part(n)
      end do
   end subroutine add_part
end module ddmp_lattice
