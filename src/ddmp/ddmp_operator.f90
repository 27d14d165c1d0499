! SPDX-License-Identifier: BSD-3-Clause
!> The integrals of the dual gradient as products of functions of one coordinate each, for all cells
!! of a tile together.
!!
!! D_ji of a cell is a derivative along one direction times integrals along the three, so it is
!! applied direction by direction: a dozen additions per component and cell instead of 64 products.
!! A tile is a one-dimensional array with three components per node, and the next node along a
!! direction has a constant offset. Elements that are not at the first node of a cell have weight
!! zero. In two and one dimensions vectors have no component along y, so a node has two elements,
!! and integrals of products are those along the single other direction. In three dimensions all
!! cells have the same integrals: those of products are 2 or 1 times h/6, so sums replace them, with
!! one common factor in the weights. Equation (M.3) of doc/theory/method.md.
module ddmp_operator
   use base_kinds, only: wp
   use ddmp_line_sums, only: add_change, add_difference, add_line, add_next, apply_line_mass, &
      apply_mass, difference_along, mean_along
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: dual_operator_t, force_plane, force_space, gradient_plane, gradient_space

   integer, parameter :: parts = 3                   !! Components of a vector
   integer, parameter :: plane = 2                   !! The same in a plane, along x and z

   !> Functions of one coordinate on the nodes of a tile, as one-dimensional arrays, for a plane or
   !! a line. In axisymmetry those along x depend on the radius and thus on the tile.
   type :: dual_operator_t
      integer :: parts = parts                       !! Components of a vector that count
      integer :: numbers = 0                         !! Elements per node
      integer :: shift(3) = 0                        !! (direction) Numbers to the next node
      !> (element, lower or upper node, direction, tile along x) Integral of a function [m]
      real(wp), allocatable :: line(:, :, :, :)
      !> (element, both lower / mixed / both upper, direction, tile along x) Of a product [m]
      real(wp), allocatable :: mass(:, :, :, :)
      real(wp) :: factor = 0.0_wp                    !! Depth of missing directions over the spacing
      real(wp) :: share = 0.0_wp                     !! In space: (h/6)**2 h/2 1/h [m2]
   contains
      procedure :: start => operator_start            !! Compute the functions
   end type dual_operator_t

contains

   !> Tabulate the weights of lines of nodes. They differ between the tiles along x if axisymmetric.
   subroutine operator_start(self, grid)
      class(dual_operator_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer :: direction, node, tile, tiles, at, along, place(3)
      real(wp) :: weight(0:1), products(0:1, 0:1)

      tiles = merge(grid%tiles(1), 1, grid%axisymmetric)
      self%parts = merge(parts, plane, grid%dimensions == 3)
      self%numbers = self%parts*grid%tile_nodes
      self%shift = self%parts*grid%stride
      self%factor = grid%depth/grid%spacing
      self%share = 0.5_wp*(grid%spacing/6.0_wp)**2
      if (allocated(self%line)) deallocate (self%line, self%mass)
      if (grid%dimensions == 3) return
      allocate (self%line(self%numbers, 2, 3, tiles), self%mass(self%numbers, 3, 3, tiles))
      self%line = 0.0_wp
      self%mass = 0.0_wp
      do tile = 1, tiles
         do node = 1, grid%tile_nodes
            at = self%parts*(node - 1)
            place = grid%node_position(node)
            do direction = 1, 3
               ! no nodes of the tile follow the last node of a line, or precede the first
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
   end subroutine operator_start

   !> Weights of cells as a one-dimensional array, at their first nodes, and the range of elements
   !! with weights: only the part of a sparse tile with material is used.
   pure subroutine lay_weights(grid, parts, weight, row, low, high)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: parts                   !! Numbers a node, two or three
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(inout) :: row(:)  !! (number)
      integer, intent(out) :: low                    !! First number of a cell with a weight
      integer, intent(out) :: high                   !! Last one; below the first if none
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

   !> Add the force of the node stress, - sum_j sigma_j . D_ji, of the cells of a tile in space.
   pure subroutine force_space(self, grid, weight, stress, patch)
      type(dual_operator_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: stress(:, :) !! (9, node) (k, l) in row k + 3 (l - 1) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [N]
      real(wp) :: row(self%numbers), field(self%numbers + 1), sums(1 - sum(self%shift):self%numbers)
      integer :: low, high, l, one, other, last

      call lay_weights(grid, parts, weight, row, low, high)
      if (high < low) return
      last = high + sum(self%shift)
      row(low:high) = self%share*row(low:high)
      do l = 1, 3
         call others(l, one, other)
         call pack_column((low + 2)/parts, (last + 2)/parts, parts*(l - 1), size(stress, 2), &
            stress, field)
         call add_next(low, last - self%shift(l), self%shift(l), self%numbers, field)
         call apply_mass(self%numbers, sum(self%shift), low, high, self%shift(one), &
            self%shift(other), self%shift(l), row, field, sums)
         call add_change(self%numbers, sum(self%shift), low, last, self%shift(l), sums, patch)
      end do
   end subroutine force_space

   !> Add sum_i u_i D_ji of the cells of a tile in space.
   pure subroutine gradient_space(self, grid, weight, velocity, patch)
      type(dual_operator_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (9, node) (k, l) in row k + 3 (l - 1)
      real(wp) :: row(self%numbers), field(self%numbers + 1), sums(1 - sum(self%shift):self%numbers)
      integer :: low, high, l, one, other, last, node, k, n

      call lay_weights(grid, parts, weight, row, low, high)
      if (high < low) return
      last = high + sum(self%shift)
      row(low:high) = self%share*row(low:high)
      do l = 1, 3
         call others(l, one, other)
         call difference_along(self%numbers, low, last - self%shift(l), self%shift(l), 1.0_wp, &
            velocity, field)
         call apply_mass(self%numbers, sum(self%shift), low, high, self%shift(one), &
            self%shift(other), self%shift(l), row, field, sums)
         do node = (low + 2)/parts, (last + 2)/parts
            do k = 1, parts
               n = parts*(node - 1) + k
               patch(k + parts*(l - 1), node) = patch(k + parts*(l - 1), node) &
                  + (sums(n) + sums(n - self%shift(l)))
            end do
         end do
      end do
   end subroutine gradient_space

   !> Three components of the tensors of some nodes as a one-dimensional array. Four are copied at a
   !! time, and the next node overwrites the fourth.
   pure subroutine pack_column(first, last, before, nodes, tensor, field)
      integer, intent(in) :: first                   !! First node
      integer, intent(in) :: last                    !! Last index
      integer, intent(in) :: before                  !! Components before the three
      integer, intent(in) :: nodes                   !! Number of nodes of the tile
      real(wp), intent(in) :: tensor(9*nodes)        !! (component and node)
      real(wp), intent(inout) :: field(parts*nodes + 1) !! (number)
      integer :: node, k

      do node = first, last - 1
         !$omp simd
         do k = 1, parts + 1
            field(parts*(node - 1) + k) = tensor(9*(node - 1) + before + k)
         end do
      end do
      do k = 1, parts
         field(parts*(last - 1) + k) = tensor(9*(last - 1) + before + k)
      end do
   end subroutine pack_column

   !> The force in a plane or on a line.
   pure subroutine force_plane(self, grid, tile, weight, stress, patch)
      type(dual_operator_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: tile                    !! Tile along x, from 1
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: stress(:, :) !! (9, node) (k, l) in row k + 3 (l - 1) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [N]
      ! one allocation: each costs as much as a loop over the tile
      real(wp) :: work(self%numbers, 5)
      integer :: low, high, l, last, node

      associate (row => work(:, 1), field => work(:, 2), means => work(:, 3), sums => work(:, 4), &
         force => work(:, 5))
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
            call add_difference(self%numbers, low, last - self%shift(l), self%shift(l), &
               self%factor, sums, force)
         end do
         do node = (low + 1)/plane, (last + 1)/plane
            patch(1, node) = patch(1, node) + force(2*node - 1)
            patch(3, node) = patch(3, node) + force(2*node)
         end do
      end associate
   end subroutine force_plane

   !> The node gradient in a plane or on a line.
   pure subroutine gradient_plane(self, grid, tile, weight, velocity, patch)
      type(dual_operator_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: tile                    !! Tile along x, from 1
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (9, node) (k, l) in row k + 3 (l - 1)
      real(wp) :: work(self%numbers, 4)
      integer :: low, high, l, last, node

      associate (row => work(:, 1), field => work(:, 2), slopes => work(:, 3), sums => work(:, 4))
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
      end associate
   end subroutine gradient_plane

   !> The two directions other than a given one.
   pure subroutine others(direction, one, other)
      integer, intent(in) :: direction               !! Direction of the derivative
      integer, intent(out) :: one                    !! The lower of the others
      integer, intent(out) :: other                  !! The higher one

      one = merge(2, 1, direction == 1)
      other = merge(2, 3, direction == 3)
   end subroutine others
end module ddmp_operator
