! SPDX-License-Identifier: BSD-3-Clause
!> The dual gradient on the grid: one loop over the cells of a tile for force and for strain.
!!
!! With D_ji = sum_c w_c integral_c S_j grad S_i and V_j = sum_c w_c integral_c S_j the force of the
!! stress on the nodes is - sum_j sigma_j . D_ji and the gradient on the nodes sum_i u_i D_ji / V_j
!! (D. Z. Zhang, X. Ma, P. T. Giguere, J. Comput. Phys. 230 (2011) 6379). Both use the same D, V and
!! alpha, so the power of the force is that of the stress. Each cell satisfies sum_i D_ji = 0 and
!! sum_i x_i D_ji = V_j separately; so momentum is conserved and linear fields are exact for any
!! weights w_c >= 0. The weight is twice the least fill of the nodes of the cell, at most 1: a cell
!! with an empty node has weight zero, so a node without mass gets no force, and small variations of
!! the fill around 1 inside a body have no effect. The weight is also at most four times the least
!! density of the nodes over the greatest: a node of light material next to heavy material has too
!! little mass for the stress of the latter and would be unstable at any useful time step. A cell
!! without particles has no weight if its nodes lack the volume of a cell, because it is then a gap
!! in the material and not one between its particles. Equations (M.3), (M.13) and (M.14) of
!! doc/theory/method.md.
module ddmp_dual
   use base_constants, only: pi
   use base_kinds, only: wp
   use ddmp_operator, only: dual_operator_t, force_plane, force_space, gradient_plane, &
      gradient_space
   use mesh_grid, only: grid_t, lane_bit, lanes
   implicit none
   private

   public :: add_cell_moments, dual_t

   real(wp), parameter :: contrast = 4.0_wp          !! Densities of nodes over each other [1]
   integer, parameter :: half = lanes/2              !! Nodes of a cell in a plane
   integer, parameter :: hoop = 5                    !! Row of the hoop component of a tensor
   real(wp), parameter :: covers = 4.0_wp            !! Inverse of the cover that counts as full [1]
   integer, parameter, public :: surface_fill = 1    !! By the least fill of its nodes
   integer, parameter, public :: surface_cells = 2   !! 1 in cells without an empty node, else 0
   integer, parameter, public :: surface_none = 3    !! 1 in all cells
   character(len=5), parameter, public :: surface_names(3) = [character(len=5) :: "fill", "cells", &
      "none"]

   !> Integrals over one cell; in axisymmetry they depend on the radius of the cell.
   type :: dual_t
      integer :: columns = 1                         !! Cells along x with different integrals
      integer :: surface = surface_fill              !! Rule of the weights, one of those above
      logical :: hoops = .false.                     !! Does the node stress have a hoop component?
      real(wp) :: enough = 0.5_wp                    !! Fill of a node that counts as full
      type(dual_operator_t) :: products                    !! D_ji as products
      real(wp), allocatable :: volume(:, :)          !! (j, column) V_j [m3]
   contains
      procedure :: start => dual_start               !! Compute the integrals
      procedure :: find_covered => dual_find_covered !! Part of cells that particles cover
      procedure :: cell_weights => dual_cell_weights !! Weights of the cells of a tile
      procedure :: add_volume => dual_add_volume     !! V_j of a tile
      procedure :: add_force => dual_add_force       !! Force of the node stress
      procedure :: add_gradient => dual_add_gradient !! Node gradient before division by V_j
      procedure :: add_hoop_force => dual_add_hoop_force !! Radial force of the node hoop stress
      procedure :: add_hoop_rate => dual_add_hoop_rate !! Node hoop strain before division by V_j
   end type dual_t

contains

   !> Compute the integrals of the shape functions and of their products.
   subroutine dual_start(self, grid)
      class(dual_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      real(wp) :: line(0:1, 3)
      integer :: column, cell, j, direction, other, bit(3)

      self%columns = merge(grid%cells(1), 1, grid%axisymmetric)
      ! near the axis the volume of the particles of a node differs from that of the node, and the
      ! node stress is correct only with weights of the particle volume
      self%enough = merge(1.0_wp, 0.5_wp, grid%axisymmetric .and. .not. self%hoops)
      call self%products%start(grid)
      if (allocated(self%volume)) deallocate (self%volume)
      allocate (self%volume(lanes, self%columns))
      do column = 1, self%columns
         do direction = 1, 3
            cell = merge(column - 1, 0, direction == 1)
            line(:, direction) = grid%line_weight(direction, cell)
         end do
         do j = 1, lanes
            bit = [(ibits(j - 1, lane_bit(other), 1), other=1, 3)]
            self%volume(j, column) = grid%depth*line(bit(1), 1)*line(bit(2), 2)*line(bit(3), 3)
         end do
      end do
   end subroutine dual_start

   !> Add the volumes of particles in each cell to row 0, times local coordinates to rows 1 to 3.
   pure subroutine add_cell_moments(start, first, local, volume, moments)
      integer, contiguous, intent(in) :: start(0:)   !! (0:cells) Particles before a cell
      integer, intent(in) :: first                   !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)  !! (particle of the tile, 3) 0 to 1
      real(wp), contiguous, intent(in) :: volume(:)    !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: moments(0:, 0:) !! (row, cell) [m3]
      real(wp) :: sums(0:3)
      integer :: cell, p

      do cell = 0, size(moments, 2) - 1
         sums = moments(:, cell)
         do p = start(cell) + 1, start(cell + 1)
            sums(0) = sums(0) + volume(first + p - 1)
            sums(1:3) = sums(1:3) + volume(first + p - 1)*local(p, :)
         end do
         moments(:, cell) = sums
      end do
   end subroutine add_cell_moments

   !> Part of the volume of each cell that its particles cover. A particle adds to the two halves of
   !! its cell along each direction according to its place, nothing to the far half if it is on a
   !! face; the half with least counts. So no particle that crosses a face changes this part
   !! suddenly. Equation (M.13).
   pure subroutine dual_find_covered(self, grid, coordinate, moments, covered)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: moments(0:, 0:) !! (row, cell) Of `add_cell_moments` [m3]
      real(wp), contiguous, intent(inout) :: covered(0:)  !! (cell) [1]
      real(wp) :: least
      integer :: cell, k

      do cell = 0, grid%tile_cells - 1
         least = moments(0, cell)
         do k = 1, 3
            if (grid%active(k)) least = min(least, 2.0_wp*moments(k, cell), &
               2.0_wp*(moments(0, cell) - moments(k, cell)))
         end do
         covered(cell) = least/sum(self%volume(:2**grid%dimensions, &
            column_of(self, grid, coordinate, cell)))
      end do
   end subroutine dual_find_covered

   !> Weight of each cell of a tile: twice the least fill of its nodes, at most 1, and less where
   !! the densities of its nodes are very different or where it has no particles and its nodes lack
   !! volume; or by another rule. Cells beyond the box have weight zero. Equations (M.12) and
   !! (M.13).
   pure subroutine dual_cell_weights(self, grid, total, row, node_volume, weight, covered)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: total(:, :) !! (component, node) Sums of the particles
      integer, intent(in) :: row                     !! Component that is their volume [m3]
      real(wp), contiguous, intent(in) :: node_volume(:) !! (node) Volume of the node [m3]
      real(wp), contiguous, intent(inout) :: weight(0:)  !! (cell) 0 to 1
      !> (cell) Part that particles cover, of `find_covered`; without it all cells count as covered
      real(wp), contiguous, intent(in), optional :: covered(0:)
      real(wp) :: work(size(total, 2), 3)
      integer :: cell, node
      real(wp) :: density, inverse

      associate (least => work(:, 1), light => work(:, 2), heavy => work(:, 3))
         ! without branches, so that nodes are lanes; those beyond the box have no volume
         !$omp simd private(inverse, density)
         do node = 1, size(total, 2)
            inverse = 1.0_wp/merge(node_volume(node), 1.0_wp, node_volume(node) > 0.0_wp)
            least(node) = merge(min(1.0_wp, total(row, node)*inverse/self%enough), 0.0_wp, &
               node_volume(node) > 0.0_wp)
            density = total(1, node)*inverse
            light(node) = merge(min(huge(1.0_wp)/contrast, density), huge(1.0_wp)/contrast, &
               node_volume(node) > 0.0_wp)
            ! the least of these is minus the greatest density
            heavy(node) = merge(min(0.0_wp, -density), 0.0_wp, node_volume(node) > 0.0_wp)
         end do
         ! least value along each direction in turn: the first node of a cell gets that of its eight
         ! nodes
         call least_around(grid, least)
         call least_around(grid, light)
         call least_around(grid, heavy)
         do cell = 0, grid%tile_cells - 1
            node = grid%first_node(cell)
            weight(cell) = least(node)
            if (-heavy(node) > contrast*light(node)) weight(cell) = min(weight(cell), &
               contrast*light(node)/(-heavy(node)))
         end do
      end associate
      if (present(covered)) call limit_gaps(grid, total, row, node_volume, covered, weight)
      if (self%surface == surface_cells) weight(:) = merge(1.0_wp, 0.0_wp, weight(:) > 0.0_wp)
      if (self%surface == surface_none) call fill_box(grid, node_volume, weight)
   end subroutine dual_cell_weights

   !> Limit the weights of cells with few particles, by the two nodes of the edge with most fill: a
   !! hole of one cell takes a part of each that is the volume of this cell, a gap between bodies
   !! takes more. Where particles are farther apart than a cell, the nodes lack no volume; those at
   !! a free surface do, but not those of the edge inside. Equation (M.13).
   pure subroutine limit_gaps(grid, total, row, node_volume, covered, weight)
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: total(:, :) !! (component, node) Sums of the particles
      integer, intent(in) :: row                     !! Component that is their volume [m3]
      real(wp), contiguous, intent(in) :: node_volume(:) !! (node) Volume of the node [m3]
      real(wp), contiguous, intent(in) :: covered(0:)    !! (cell) Part that particles cover [1]
      real(wp), contiguous, intent(inout) :: weight(0:)  !! (cell) 0 to 1
      real(wp) :: fullest
      integer :: cell, lane, node, direction

      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > covers*covered(cell)) cycle
         fullest = 0.0_wp
         do lane = 1, 2**grid%dimensions
            node = grid%first_node(cell) + grid%lane_offset(lane)
            do direction = 1, 3
               if (ibits(lane - 1, lane_bit(direction), 1) == 1) fullest = max(fullest, &
                  fill(node) + fill(node - grid%stride(direction)))
            end do
         end do
         weight(cell) = min(weight(cell), max(covers*covered(cell), 0.0_wp, &
            2.0_wp - real(2**grid%dimensions, wp)*(2.0_wp - fullest)))
      end do

   contains

      !> Volume of the particles of a node over its volume.
      pure real(wp) function fill(node) result(share)
         integer, intent(in) :: node

         share = total(row, node)/node_volume(node)
      end function fill
   end subroutine limit_gaps

   !> Least of the values on the nodes of each cell, stored at its first node.
   pure subroutine least_around(grid, values)
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(inout) :: values(:) !! (node)
      integer :: direction, node

      do direction = 1, 3
         if (.not. grid%active(direction)) cycle
         !$omp simd
         do node = 1, size(values) - grid%stride(direction)
            values(node) = min(values(node), values(node + grid%stride(direction)))
         end do
      end do
   end subroutine least_around

   !> Weight 1 for all cells of the box.
   pure subroutine fill_box(grid, node_volume, weight)
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: node_volume(:) !! (node) 0 beyond the box [m3]
      real(wp), contiguous, intent(inout) :: weight(0:)  !! (cell) 0 or 1
      integer :: cell, lane

      do cell = 0, grid%tile_cells - 1
         weight(cell) = 1.0_wp
         do lane = 1, 2**grid%dimensions
            if (.not. node_volume(grid%first_node(cell) + grid%lane_offset(lane)) > 0.0_wp) &
               weight(cell) = 0.0_wp
         end do
      end do
   end subroutine fill_box

   !> Add w_c V_j of the cells of a tile to a patch.
   pure subroutine dual_add_volume(self, grid, coordinate, weight, patch)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (1, node) [m3]
      integer :: cell, lane, node, base, column

      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > 0.0_wp) cycle
         base = grid%first_node(cell)
         column = column_of(self, grid, coordinate, cell)
         ! upper lanes of missing directions have no volume
         do lane = 1, 2**grid%dimensions
            node = base + grid%lane_offset(lane)
            patch(1, node) = patch(1, node) + weight(cell)*self%volume(lane, column)
         end do
      end do
   end subroutine dual_add_volume

   !> Add the force of the node stress, - sum_j sigma_j . D_ji, of the cells of a tile to a patch.
   !! The last sum of (M.4).
   pure subroutine dual_add_force(self, grid, coordinate, weight, stress, patch)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: stress(:, :) !! (9, node) (k, l) in row k + 3 (l - 1) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [N]

      if (grid%dimensions == 3) then
         call force_space(self%products, grid, weight, stress, patch)
      else
         call force_plane(self%products, grid, merge(coordinate(1) + 1, 1, grid%axisymmetric), &
            weight, stress, patch)
      end if
   end subroutine dual_add_force

   !> Add sum_i u_i D_ji of the cells of a tile to a patch. The sum of (M.6).
   pure subroutine dual_add_gradient(self, grid, coordinate, weight, velocity, patch)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (9, node) (k, l) in row k + 3 (l - 1)

      if (grid%dimensions == 3) then
         call gradient_space(self%products, grid, weight, velocity, patch)
      else
         call gradient_plane(self%products, grid, merge(coordinate(1) + 1, 1, grid%axisymmetric), &
            weight, velocity, patch)
      end if
   end subroutine dual_add_gradient

   !> Add the radial force of the hoop stress of the nodes, - sum_j sigma_j int_c S_j S_i / r dv, of
   !! the cells of a tile to a patch; rings are 2 pi r thick, so the integrals are those of a plane.
   !! Equation (Q.6) of doc/theory/quadratures.md.
   pure subroutine dual_add_hoop_force(self, grid, weight, stress, patch)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: stress(:, :) !! (9, node) (k, l) in row k + 3 (l - 1) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [N]
      real(wp) :: sums(half)
      integer :: cell, node(half)

      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > 0.0_wp) cycle
         node = grid%first_node(cell) + grid%lane_offset(:half)
         sums = hoop_sums(grid, weight(cell), stress(hoop, node))
         patch(1, node) = patch(1, node) - sums
      end do
   end subroutine dual_add_hoop_force

   !> Add sum_i u_ir int_c S_j S_i / r dv of the cells of a tile to the hoop component of a patch:
   !! the transpose of the force of the hoop stress.
   pure subroutine dual_add_hoop_rate(self, grid, weight, velocity, patch)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: weight(0:) !! (cell) Weights
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (9, node) (k, l) in row k + 3 (l - 1)
      real(wp) :: sums(half)
      integer :: cell, node(half)

      do cell = 0, grid%tile_cells - 1
         if (.not. weight(cell) > 0.0_wp) cycle
         node = grid%first_node(cell) + grid%lane_offset(:half)
         sums = hoop_sums(grid, weight(cell), velocity(1, node))
         patch(hoop, node) = patch(hoop, node) + sums
      end do
   end subroutine dual_add_hoop_rate

   !> Integrals of the product of each function of a cell with a linear one, in a plane of 2 pi.
   pure function hoop_sums(grid, weight, values) result(sums)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: weight                 !! Of the cell [1]
      real(wp), intent(in) :: values(half)           !! On the nodes of the cell
      real(wp) :: sums(half)
      real(wp) :: share

      share = weight*2.0_wp*pi*(grid%spacing/6.0_wp)**2
      sums(1) = share*(4.0_wp*values(1) + 2.0_wp*(values(2) + values(3)) + values(4))
      sums(2) = share*(4.0_wp*values(2) + 2.0_wp*(values(1) + values(4)) + values(3))
      sums(3) = share*(4.0_wp*values(3) + 2.0_wp*(values(1) + values(4)) + values(2))
      sums(4) = share*(4.0_wp*values(4) + 2.0_wp*(values(2) + values(3)) + values(1))
   end function hoop_sums

   !> Index of the integrals of a cell. Cells beyond the box, which have no weight, have none of
   !! their own and get those of the last ones.
   pure integer function column_of(self, grid, coordinate, cell) result(column)
      class(dual_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: cell                    !! Cell of the tile, from 0

      column = 1
      if (self%columns > 1) column = min(self%columns, &
         1 + coordinate(1)*grid%width(1) + mod(cell, grid%width(1)))
   end function column_of
end module ddmp_dual
