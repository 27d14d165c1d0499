! SPDX-License-Identifier: BSD-3-Clause
!> The dual gradient on the grid: one loop over the cells of a tile for force and for strain.
!!
!! With D_ji = sum_c w_c integral_c S_j grad S_i and V_j = sum_c w_c integral_c S_j the force of the
!! stress on the nodes is - sum_j sigma_j . D_ji and the gradient on the nodes sum_i u_i D_ji / V_j
!! (D. Z. Zhang, X. Ma, P. T. Giguere, J. Comput. Phys. 230 (2011) 6379). The same D, V and
!! alpha serve both, so the power of the force is that of the stress. Each cell satisfies
!! sum_i D_ji = 0 and sum_i x_i D_ji = V_j for itself; hence momentum is kept and linear fields
!! are exact for any weights w_c >= 0. The weight is twice the least fill of the nodes of the cell,
!! at most 1: a cell with an empty node takes no part, so no force falls on a node without mass, and
!! the fill may waver round one inside of a body without any effect. Nor is it above four times the
!! least density of the nodes over the greatest: a node of light matter beside heavy matter has
!! no mass for the stress of the latter, which would tear it away at any useful time step.
module ddmp_dual
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lane_bit, lanes
   implicit none
   private

   public :: dual_t

   real(wp), parameter :: contrast = 4.0_wp          !! Densities of nodes over each other [1]
   integer, parameter, public :: surface_fill = 1    !! By the least fill of its nodes
   integer, parameter, public :: surface_cells = 2   !! 1 in cells without an empty node, else 0
   integer, parameter, public :: surface_none = 3    !! 1 in all cells
   character(len=5), parameter, public :: surface_names(3) = [character(len=5) :: "fill", "cells", &
      "none"]

   !> Integrals over one cell; in axisymmetry they depend on the radius of the cell.
   type :: dual_t
      integer :: columns = 1                         !! Cells along x with integrals of their own
      integer :: surface = surface_fill              !! Rule of the weights, one of those above
      real(wp) :: enough = 0.5_wp                    !! Fill of a node that counts as full
      real(wp), allocatable :: force(:, :, :, :)     !! (i, j, direction, column) D_ji [m2]
      real(wp), allocatable :: strain(:, :, :, :)    !! (j, i, direction, column) D_ji [m2]
      real(wp), allocatable :: volume(:, :)          !! (j, column) V_j [m3]
   contains
      procedure :: start => dual_start               !! Compute the integrals
      procedure :: cell_weights => dual_cell_weights !! Fill of the cells of a tile
      procedure :: add_volume => dual_add_volume     !! V_j of a tile
      procedure :: add_force => dual_add_force       !! Force of the node stress
      procedure :: add_gradient => dual_add_gradient !! Node gradient before division by V_j
   end type dual_t

contains

   !> Compute the integrals of products of the node functions and their gradients.
   subroutine dual_start(self, grid)
      class(dual_t), intent(inout) :: self           !! The integrals
      type(grid_t), intent(in) :: grid               !! The grid
      real(wp) :: line(0:1, 3), mass(0:1, 0:1, 3), value
      integer :: column, cell, i, j, direction, other, bit_i(3), bit_j(3)

      self%columns = merge(grid%cells(1), 1, grid%axisymmetric)
      ! near the axis the volume of the particles of a node is not that of the node, and only
      ! weights
      ! that follow it keep the node stress right
      self%enough = merge(1.0_wp, 0.5_wp, grid%axisymmetric)
      if (allocated(self%force)) deallocate (self%force, self%strain, self%volume)
      allocate (self%force(lanes, lanes, 3, self%columns), self%volume(lanes, self%columns))
      do column = 1, self%columns
         do direction = 1, 3
            cell = merge(column - 1, 0, direction == 1)
            line(:, direction) = grid%line_weight(direction, cell)
            mass(:, :, direction) = grid%mass_weight(direction, cell)
         end do
         do j = 1, lanes
            bit_j = [(ibits(j - 1, lane_bit(other), 1), other=1, 3)]
            self%volume(j, column) = grid%depth*line(bit_j(1), 1)*line(bit_j(2), 2) &
               *line(bit_j(3), 3)
            do i = 1, lanes
               bit_i = [(ibits(i - 1, lane_bit(other), 1), other=1, 3)]
               do direction = 1, 3
                  value = grid%depth*grid%lane_slope(i, direction)/grid%spacing
                  do other = 1, 3
                     if (other == direction) then
                        value = value*line(bit_j(other), other)
                     else
                        value = value*mass(bit_j(other), bit_i(other), other)
                     end if
                  end do
                  self%force(i, j, direction, column) = value
               end do
            end do
         end do
      end do
      allocate (self%strain, mold=self%force)
      do j = 1, lanes
         do i = 1, lanes
            self%strain(j, i, :, :) = self%force(i, j, :, :)
         end do
      end do
   end subroutine dual_start

   !> Weight of each cell of a tile: twice the least fill of its nodes, at most 1, and less where
   !! the densities of its nodes are very different; or by another rule. Cells beyond the box count
   !! nothing.
   pure subroutine dual_cell_weights(self, grid, total, row, node_volume, weight)
      class(dual_t), intent(in) :: self              !! The integrals
      type(grid_t), intent(in) :: grid               !! The grid
      real(wp), contiguous, intent(in) :: total(:, :) !! (component, node) Sums of the particles
      integer, intent(in) :: row                     !! Component that is their volume [m3]
      real(wp), contiguous, intent(in) :: node_volume(:) !! (node) Volume of the node [m3]
      real(wp), contiguous, intent(inout) :: weight(0:)  !! (cell) 0 to 1
      integer :: cell, lane, node, base
      real(wp) :: least, light, heavy, density

      do cell = 0, grid%tile_cells - 1
         base = grid%first_node(cell)
         least = 1.0_wp
         light = huge(1.0_wp)/contrast
         heavy = 0.0_wp
         do lane = 1, lanes
            node = base + grid%lane_offset(lane)
            if (node_volume(node) > 0.0_wp) then
               least = min(least, total(row, node)/(self%enough*node_volume(node)))
               density = total(1, node)/node_volume(node)
               light = min(light, density)
               heavy = max(heavy, density)
            else
               least = 0.0_wp
            end if
         end do
         if (heavy > contrast*light) least = min(least, contrast*light/heavy)
         weight(cell) = least
      end do
      if (self%surface == surface_cells) weight(:) = merge(1.0_wp, 0.0_wp, weight(:) > 0.0_wp)
      if (self%surface == surface_none) call fill_box(grid, node_volume, weight)
   end subroutine dual_cell_weights

   !> Weight 1 for all cells of the box.
   pure subroutine fill_box(grid, node_volume, weight)
      type(grid_t), intent(in) :: grid               !! The grid
      real(wp), contiguous, intent(in) :: node_volume(:) !! (node) 0 beyond the box [m3]
      real(wp), contiguous, intent(inout) :: weight(0:)  !! (cell) 0 or 1
      integer :: cell, lane

      do cell = 0, grid%tile_cells - 1
         weight(cell) = 1.0_wp
         do lane = 1, lanes
            if (.not. node_volume(grid%first_node(cell) + grid%lane_offset(lane)) > 0.0_wp) &
               weight(cell) = 0.0_wp
         end do
      end do
   end subroutine fill_box

   !> Add w_c V_j of the cells of a tile to a patch.
   pure subroutine dual_add_volume(self, grid, coordinate, weight, patch)
      class(dual_t), intent(in) :: self              !! The integrals
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (1, node) [m3]
      integer :: cell, lane, node, base, column

      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > 0.0_wp) cycle
         base = grid%first_node(cell)
         column = column_of(self, grid, coordinate, cell)
         do lane = 1, lanes
            node = base + grid%lane_offset(lane)
            patch(1, node) = patch(1, node) + weight(cell)*self%volume(lane, column)
         end do
      end do
   end subroutine dual_add_volume

   !> Add the force of the node stress, - sum_j sigma_j . D_ji, of the cells of a tile to a patch.
   pure subroutine dual_add_force(self, grid, coordinate, weight, stress, patch)
      class(dual_t), intent(in) :: self              !! The integrals
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: stress(:, :) !! (9, node) (k, l) in row k + 3 (l - 1) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [N]
      real(wp) :: force(lanes, 3), s(9, lanes)
      integer :: cell, i, j, k, node, base

      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > 0.0_wp) cycle
         base = grid%first_node(cell)
         do j = 1, lanes
            node = base + grid%lane_offset(j)
            do k = 1, 9
               s(k, j) = weight(cell)*stress(k, node)
            end do
         end do
         call apply_force(self%force(:, :, :, column_of(self, grid, coordinate, cell)), s, force)
         do i = 1, lanes
            node = base + grid%lane_offset(i)
            do k = 1, 3
               patch(k, node) = patch(k, node) - force(i, k)
            end do
         end do
      end do
   end subroutine dual_add_force

   !> Product of the integrals of a cell with the stress of its nodes; the nodes i are the lanes.
   pure subroutine apply_force(d, s, force)
      real(wp), intent(in) :: d(lanes, lanes, 3)     !! (i, j, direction) [m2]
      real(wp), intent(in) :: s(9, lanes)            !! (component, j) [Pa]
      real(wp), intent(out) :: force(lanes, 3)       !! (i, component) [N]
      real(wp) :: f1, f2, f3
      integer :: i, j

      !$omp simd private(f1, f2, f3, j)
      do i = 1, lanes
         f1 = 0.0_wp
         f2 = 0.0_wp
         f3 = 0.0_wp
         do j = 1, lanes
            f1 = f1 + (s(1, j)*d(i, j, 1) + s(4, j)*d(i, j, 2) + s(7, j)*d(i, j, 3))
            f2 = f2 + (s(2, j)*d(i, j, 1) + s(5, j)*d(i, j, 2) + s(8, j)*d(i, j, 3))
            f3 = f3 + (s(3, j)*d(i, j, 1) + s(6, j)*d(i, j, 2) + s(9, j)*d(i, j, 3))
         end do
         force(i, 1) = f1
         force(i, 2) = f2
         force(i, 3) = f3
      end do
   end subroutine apply_force

   !> Add sum_i u_i D_ji of the cells of a tile to a patch.
   pure subroutine dual_add_gradient(self, grid, coordinate, weight, velocity, patch)
      class(dual_t), intent(in) :: self              !! The integrals
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (9, node) (k, l) in row k + 3 (l - 1)
      real(wp) :: gradient(lanes, 9), u(3, lanes)
      integer :: cell, i, j, k, node, base

      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > 0.0_wp) cycle
         base = grid%first_node(cell)
         do i = 1, lanes
            node = base + grid%lane_offset(i)
            do k = 1, 3
               u(k, i) = weight(cell)*velocity(k, node)
            end do
         end do
         call apply_strain(self%strain(:, :, :, column_of(self, grid, coordinate, cell)), u, &
            gradient)
         do j = 1, lanes
            node = base + grid%lane_offset(j)
            do k = 1, 9
               patch(k, node) = patch(k, node) + gradient(j, k)
            end do
         end do
      end do
   end subroutine dual_add_gradient

   !> Product of the integrals of a cell with the velocities of its nodes; nodes j are the lanes.
   pure subroutine apply_strain(d, u, gradient)
      real(wp), intent(in) :: d(lanes, lanes, 3)     !! (j, i, direction) [m2]
      real(wp), intent(in) :: u(3, lanes)            !! (component, i) [m/s]
      real(wp), intent(out) :: gradient(lanes, 9)    !! (j, component) [m3/s]
      real(wp) :: g1, g2, g3, g4, g5, g6, g7, g8, g9
      integer :: i, j

      !$omp simd private(g1, g2, g3, g4, g5, g6, g7, g8, g9, i)
      do j = 1, lanes
         g1 = 0.0_wp; g2 = 0.0_wp; g3 = 0.0_wp
         g4 = 0.0_wp; g5 = 0.0_wp; g6 = 0.0_wp
         g7 = 0.0_wp; g8 = 0.0_wp; g9 = 0.0_wp
         do i = 1, lanes
            g1 = g1 + u(1, i)*d(j, i, 1)
            g2 = g2 + u(2, i)*d(j, i, 1)
            g3 = g3 + u(3, i)*d(j, i, 1)
            g4 = g4 + u(1, i)*d(j, i, 2)
            g5 = g5 + u(2, i)*d(j, i, 2)
            g6 = g6 + u(3, i)*d(j, i, 2)
            g7 = g7 + u(1, i)*d(j, i, 3)
            g8 = g8 + u(2, i)*d(j, i, 3)
            g9 = g9 + u(3, i)*d(j, i, 3)
         end do
         gradient(j, 1) = g1
         gradient(j, 2) = g2
         gradient(j, 3) = g3
         gradient(j, 4) = g4
         gradient(j, 5) = g5
         gradient(j, 6) = g6
         gradient(j, 7) = g7
         gradient(j, 8) = g8
         gradient(j, 9) = g9
      end do
   end subroutine apply_strain

   !> Which integrals a cell uses.
   pure integer function column_of(self, grid, coordinate, cell) result(column)
      class(dual_t), intent(in) :: self              !! The integrals
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: cell                    !! Cell of the tile, from 0

      column = 1
      if (self%columns > 1) column = 1 + coordinate(1)*grid%width(1) + mod(cell, grid%width(1))
   end function column_of
end module ddmp_dual
