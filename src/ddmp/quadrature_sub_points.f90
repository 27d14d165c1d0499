! SPDX-License-Identifier: BSD-3-Clause
!> The mean of the modified gradient over sub-points with the stress of their particle: T. R.
!! Dhakal, D. Z. Zhang, J. Comput. Phys. 325 (2016) 301. Unlike there, sub-points are on a lattice
!! in the box of the particle, which stretches along the directions of the grid, so the means are
!! products of means along the directions. Mass and velocity go to the nodes by means over the same
!! box (basis cpgimp): otherwise a node at a free surface would get a force without mass. Equation
!! (Q.1) of doc/theory/quadratures.md.
module quadrature_sub_points
   use base_kinds, only: wp
   use ddmp_quadrature, only: quadrature_t
   use mesh_grid, only: grid_t
   use particle_store, only: store_t, traits_t
   use transfer_shape_data, only: line, shape_data_t
   use transfer_spline_gather, only: gather_spline_values
   use transfer_spline_kernels, only: scatter_spline_values
   implicit none
   private

   public :: quadrature_sub_points_t

   integer, parameter :: points = 4                  !! Sub-points along a direction
   !> Component (k, l) of a symmetric tensor
   integer, parameter :: component(3, 3) = reshape([1, 4, 6, 4, 2, 5, 6, 5, 3], [3, 3])

   !> Means over sub-points.
   type, extends(quadrature_t) :: quadrature_sub_points_t
   contains
      procedure :: margin => sub_margin              !! Nodes beyond a tile that boxes reach
      procedure :: request => sub_request            !! Particles carry boxes that stretch
      procedure :: needs_split => sub_needs_split    !! Its means are products
      procedure :: locate => sub_locate              !! Means along the directions
      procedure :: scatter_force => sub_scatter_force !! Force, volume and node stress
      procedure :: gather_gradient => sub_gather_gradient !! Velocity gradient
   end type quadrature_sub_points_t

contains

   !> Boxes extend into the cells next to that of the particle.
   pure integer function sub_margin(self) result(margin)
      class(quadrature_sub_points_t), intent(in) :: self

      margin = 1
   end function sub_margin

   !> Particles carry half the edges of their boxes, and these stretch.
   pure subroutine sub_request(self, traits)
      class(quadrature_sub_points_t), intent(in) :: self
      type(traits_t), intent(inout) :: traits

      traits%extent = .true.
      traits%stretching = .true.
   end subroutine sub_request

   !> The means over the box are products of means along the directions.
   pure logical function sub_needs_split(self) result(yes)
      class(quadrature_sub_points_t), intent(in) :: self

      yes = .true.
   end function sub_needs_split

   !> Means of the functions, of alpha times their derivative, and of 1 - alpha times the functions.
   pure subroutine sub_locate(self, grid, coordinate, store, tile, shape)
      class(quadrature_sub_points_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      type(shape_data_t), intent(inout) :: shape
      integer :: direction, cell, from, to

      call shape%mean%reserve(store%count(tile))
      call shape%mean%spline%take_cells(grid, shape%start)
      shape%mean%spline%low = 1
      shape%mean%spline%weight = 0.0_wp
      shape%mean%cell_slope = 0.0_wp
      shape%mean%node_value = 0.0_wp
      do direction = 1, 3
         if (.not. grid%active(direction)) then
            shape%mean%spline%weight(:, 1, direction) = 1.0_wp
            cycle
         end if
         do cell = 0, grid%tile_cells - 1
            from = store%cell_start(cell, tile) + 1
            to = store%cell_start(cell + 1, tile)
            if (to >= from) call mean_cell(self, grid, direction, &
               coordinate(direction)*grid%width(direction) + grid%cell_position(direction, cell), &
               store%first(tile), from, to, store%extent, shape)
         end do
      end do
   end subroutine sub_locate

   !> Means along one direction for the particles of a cell. Sub-points beyond the box of the grid,
   !! or more than a cell away, are moved to the border.
   pure subroutine mean_cell(rule, grid, direction, cell, first, from, to, extent, shape)
      class(quadrature_sub_points_t), intent(in) :: rule     !! alpha and blend
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: direction                       !! 1 to 3
      integer, intent(in) :: cell !! Index of the cell in the box along the direction, from 0
      integer, intent(in) :: first                           !! First particle of the tile
      integer, intent(in) :: from, to                        !! Particles of the cell, in the tile
      real(wp), contiguous, intent(in) :: extent(:, :)       !! (particle, 3) Half edges [m]
      type(shape_data_t), intent(inout) :: shape !! Gets the means
      real(wp) :: low, high, half, x, y, alpha, value(0:1), part
      integer :: p, n, k, node

      low = merge(0.0_wp, -1.0_wp, cell == 0 .and. .not. grid%periodic(direction))
      high = merge(1.0_wp, 2.0_wp, cell == grid%cells(direction) - 1 .and. &
         .not. grid%periodic(direction))
      part = 1.0_wp/real(points, wp)
      do p = from, to
         half = extent(first + p - 1, direction)/grid%spacing
         do n = 1, points
            x = shape%local(p, direction) + half*(2.0_wp*part*(real(n, wp) - 0.5_wp) - 1.0_wp)
            x = min(max(x, low), high)
            ! a point on the upper border counts as in the cell below it
            k = min(floor(x), int(high) - 1)
            y = x - real(k, wp)
            alpha = 4.0_wp*rule%alpha_centre*y*(1.0_wp - y)
            if (rule%smooth) y = y*y*(3.0_wp - 2.0_wp*y)
            value = [1.0_wp - y, y]
            do node = 0, 1
               associate (at => k + node + 2)
                  shape%mean%spline%weight(p, at, direction) = &
                     shape%mean%spline%weight(p, at, direction) + part*value(node)
                  shape%mean%cell_slope(p, at, direction) = &
                     shape%mean%cell_slope(p, at, direction) &
                     + part*alpha*real(2*node - 1, wp)/grid%spacing
                  shape%mean%node_value(p, at, direction) = &
                     shape%mean%node_value(p, at, direction) + part*(1.0_wp - alpha)*value(node)
               end associate
            end do
         end do
      end do
   end subroutine mean_cell

   !> Force, volume and node stress.
   pure subroutine sub_scatter_force(self, grid, shape, first, volume, stress, patch)
      class(quadrature_sub_points_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: value(shape%count, line)
      integer :: p, k, l, count

      count = shape%count
      shape%values(:count, 1) = volume(first:first + count - 1)
      call scatter_spline_values(grid, count, shape%mean%spline, 1, shape%values, 7, patch)
      do l = 1, 3
         if (.not. grid%active(l)) cycle
         do k = 1, 3
            do p = 1, count
               shape%values(p, k) = volume(first + p - 1)*stress(first + p - 1, component(k, l))
            end do
         end do
         value = shape%mean%spline%weight(:count, :, l)
         shape%mean%spline%weight(:count, :, l) = -shape%mean%cell_slope(:count, :, l)
         call scatter_spline_values(grid, count, shape%mean%spline, 3, shape%values, 4, patch)
         shape%mean%spline%weight(:count, :, l) = shape%mean%node_value(:count, :, l)
         call scatter_spline_values(grid, count, shape%mean%spline, 3, shape%values, 5 + 3*l, &
            patch)
         shape%mean%spline%weight(:count, :, l) = value
      end do
   end subroutine sub_scatter_force

   !> Velocity gradient.
   pure subroutine sub_gather_gradient(self, grid, shape, nodes, node_gradient, scale, gradient)
      class(quadrature_sub_points_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), contiguous, intent(in) :: node_gradient(:, :) !! (9, node) On the nodes [1/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: value(shape%count, line), column(3, size(nodes, 2))
      integer :: p, k, l, count

      count = shape%count
      do l = 1, 3
         if (.not. grid%active(l)) then
            gradient(:count, 3*l - 2:3*l) = 0.0_wp
            cycle
         end if
         column = node_gradient(3*l - 2:3*l, :)
         value = shape%mean%spline%weight(:count, :, l)
         shape%mean%spline%weight(:count, :, l) = shape%mean%cell_slope(:count, :, l)
         call gather_spline_values(grid, shape%start, shape%mean%spline, nodes, shape%values)
         shape%mean%spline%weight(:count, :, l) = shape%mean%node_value(:count, :, l)
         call gather_spline_values(grid, shape%start, shape%mean%spline, column, &
            shape%values(:, 4:))
         shape%mean%spline%weight(:count, :, l) = value
         do k = 1, 3
            do p = 1, count
               gradient(p, k + 3*(l - 1)) = scale*(shape%values(p, k) + shape%values(p, 3 + k))
            end do
         end do
      end do
   end subroutine sub_gather_gradient
end module quadrature_sub_points
