! SPDX-License-Identifier: BSD-3-Clause
!> Shape functions that are products of functions of one coordinate, on the nodes -1 to 2 of the
!! cell along each direction. A basis of this kind only defines these functions (`weigh`).
module transfer_tensor
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_basis, only: basis_t
   use transfer_shape_data, only: line, shape_data_t
   use transfer_spline_gather_plane, only: gather_plane_gradient, gather_plane_values
   use transfer_spline_kernels, only: gather_spline_gradient, gather_spline_values, &
      scatter_spline_affine, scatter_spline_stress, scatter_spline_values
   implicit none
   private

   public :: basis_tensor_t, fold_walls

   !> Shape functions that are products.
   type, abstract, extends(basis_t) :: basis_tensor_t
   contains
      procedure :: margin => tensor_margin           !! Layers of nodes beyond a tile
      procedure :: reach => tensor_reach             !! Nodes of a line that are touched
      procedure :: locate => tensor_locate           !! Local coordinates and functions
      procedure(weigh_i), deferred :: weigh          !! Functions along the directions
      procedure :: scatter_values => tensor_scatter_values !! Values to nodes
      procedure :: scatter_affine => tensor_scatter_affine !! Mass and a linear velocity field
      procedure :: scatter_stress => tensor_scatter_stress !! Force of the stress
      procedure :: gather_values => tensor_gather_values !! Node values to particles
      procedure :: gather_gradient => tensor_gather_gradient !! Their gradients
      procedure :: gather_affine => tensor_gather_affine !! Linear velocity field
   end type basis_tensor_t

   abstract interface
      !> Functions of the particles of a tile along one direction, from their local coordinates:
      !! weight, slope and low of `spline_data_t`, as if there were no walls.
      pure subroutine weigh_i(self, grid, store, tile, direction, shape)
         import :: basis_tensor_t, grid_t, shape_data_t, store_t
         implicit none
         class(basis_tensor_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         type(store_t), intent(in) :: store
         integer, intent(in) :: tile                            !! Index of the tile
         integer, intent(in) :: direction                       !! 1 to 3
         type(shape_data_t), intent(inout) :: shape
      end subroutine weigh_i
   end interface

contains

   !> One layer of nodes beyond a tile.
   pure integer function tensor_margin(self) result(margin)
      class(basis_tensor_t), intent(in) :: self

      margin = 1
   end function tensor_margin

   !> Nodes along a line that a particle touches, counted from `low` on; three, unless the basis
   !! says otherwise.
   pure integer function tensor_reach(self) result(reach)
      class(basis_tensor_t), intent(in) :: self

      reach = 3
   end function tensor_reach

   !> Local coordinates and functions of all directions.
   pure subroutine tensor_locate(self, grid, coordinate, store, tile, shape)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      type(shape_data_t), intent(inout) :: shape
      integer :: direction

      call shape%take_tile(grid, store, tile)
      call shape%spline%reserve(store%count(tile))
      do direction = 1, 3
         if (grid%active(direction)) then
            call self%weigh(grid, store, tile, direction, shape)
            call fold_walls(grid, coordinate, store%cell_start(:, tile), direction, &
               shape%spline%weight, shape%spline%slope)
         else
            shape%spline%weight(:, :, direction) = 0.0_wp
            shape%spline%weight(:, 1, direction) = 1.0_wp
            shape%spline%slope(:, :, direction) = 0.0_wp
            shape%spline%low(:, direction) = 1
         end if
      end do
   end subroutine tensor_locate

   !> Give the function of a node outside a wall to the two nodes inside by linear extrapolation,
   !! 2 f to the node on the wall and -f to the next one. Linear fields stay exact, and the node on
   !! the wall has the only function that is not zero there. These are the boundary splines of M.
   !! Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods Eng. 76 (2008) 922. Equation (N.6) of
   !! doc/theory/node_functions.md.
   pure subroutine fold_walls(grid, coordinate, start, direction, weight, slope)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: direction                       !! 1 to 3
      real(wp), contiguous, intent(inout) :: weight(:, :, :) !! (particle of the tile, node, 3)
      real(wp), contiguous, intent(inout) :: slope(:, :, :)  !! The same indices
      integer :: cell, place, side, out, on, in

      if (.not. any(grid%wall(2*direction - 1:2*direction))) return
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         place = coordinate(direction)*grid%width(direction) + grid%cell_position(direction, cell)
         do side = 1, 2
            if (.not. grid%wall(2*direction - 2 + side)) cycle
            if (place /= merge(0, grid%cells(direction) - 1, side == 1)) cycle
            out = merge(1, 4, side == 1)
            on = merge(2, 3, side == 1)
            in = merge(3, 2, side == 1)
            call fold(weight(:, out, direction), weight(:, on, direction), weight(:, in, direction))
            call fold(slope(:, out, direction), slope(:, on, direction), slope(:, in, direction))
         end do
      end do

   contains

      !> Fold the functions of the particles of one cell.
      pure subroutine fold(outside, wall, inside)
         real(wp), intent(inout) :: outside(:)       !! Becomes zero
         real(wp), intent(inout) :: wall(:)          !! Gets twice as much
         real(wp), intent(inout) :: inside(:)        !! Loses it
         integer :: p

         do p = start(cell) + 1, start(cell + 1)
            wall(p) = wall(p) + 2.0_wp*outside(p)
            inside(p) = inside(p) - outside(p)
            outside(p) = 0.0_wp
         end do
      end subroutine fold
   end subroutine fold_walls

   !> Layers of lines that a particle touches after the first one.
   pure integer function layers_after(self, grid) result(layers)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid

      layers = merge(self%reach() - 1, 0, grid%active(3))
   end function layers_after

   !> Add sum S_i value to columns of a patch.
   pure subroutine tensor_scatter_values(self, grid, shape, count, values, before, patch)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_spline_values(grid, layers_after(self, grid), shape, count, values, before, &
         patch)
   end subroutine tensor_scatter_values

   !> Add mass and momentum of linear velocity fields.
   pure subroutine tensor_scatter_affine(self, grid, shape, first, mass, velocity, affine, patch)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_spline_affine(grid, layers_after(self, grid), shape, first, mass, velocity, &
         affine, patch)
   end subroutine tensor_scatter_affine

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
   pure subroutine tensor_scatter_stress(self, grid, shape, first, volume, stress, patch)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_spline_stress(grid, layers_after(self, grid), shape, first, volume, stress, &
         patch)
   end subroutine tensor_scatter_stress

   !> Values sum S_i node_i, three columns at a time.
   pure subroutine tensor_gather_values(self, grid, shape, nodes, values)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: part(3, size(nodes, 2))
      integer :: skip, count

      if (grid%dimensions < 3) then
         call gather_plane_values(grid, shape, nodes, values)
         return
      end if
      if (size(nodes, 1) == 3) then
         call gather_spline_values(grid, layers_after(self, grid), shape%start, &
            size(shape%spline%weight, 1), shape%spline%weight, shape%spline%low, size(nodes, 2), &
            nodes, 0, values)
         return
      end if
      part = 0.0_wp
      do skip = 0, size(nodes, 1) - 1, 3
         count = min(size(nodes, 1) - skip, 3)
         part(:count, :) = nodes(skip + 1:skip + count, :)
         call gather_spline_values(grid, layers_after(self, grid), shape%start, &
            size(shape%spline%weight, 1), shape%spline%weight, shape%spline%low, size(nodes, 2), &
            part, skip, values)
      end do
   end subroutine tensor_gather_values

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l.
   pure subroutine tensor_gather_gradient(self, grid, shape, nodes, scale, gradient)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      if (grid%dimensions < 3) then
         call gather_plane_gradient(grid, shape, nodes, scale, gradient)
         return
      end if
      call gather_spline_gradient(grid, layers_after(self, grid), shape%start, &
         size(shape%spline%weight, 1), shape%spline%weight, shape%spline%slope, shape%spline%low, &
         size(nodes, 2), nodes, scale, gradient)
   end subroutine tensor_gather_gradient

   !> Linear velocity field: C_kl = sum S_i u_k (x_i - x)_l / sum S_i (x_i - x)_l**2, which keeps
   !! angular momentum (C. Jiang and others, 2015, as above). The second moments are a diagonal
   !! matrix, because the functions are products and have no first moments. Equation (N.10).
   pure subroutine tensor_gather_affine(self, grid, shape, nodes, affine)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), contiguous, intent(inout) :: affine(:, :)    !! (particle of the tile, 9) [1/s]
      type(shape_data_t) :: moments
      real(wp) :: away, moment, least
      integer :: p, direction, n

      ! least second moment that divides: on a wall there is one function and no gradient across it
      least = 1.0e-6_wp*grid%spacing**2
      moments = shape
      do direction = 1, 3
         if (.not. grid%active(direction)) cycle
         do p = 1, shape%count
            moment = 0.0_wp
            do n = 1, line
               away = grid%spacing*(real(n - 2, wp) - shape%local(p, direction))
               moments%spline%slope(p, n, direction) = shape%spline%weight(p, n, direction)*away
               moment = moment + shape%spline%weight(p, n, direction)*away**2
            end do
            do n = 1, line
               moments%spline%slope(p, n, direction) = &
                  moments%spline%slope(p, n, direction)/max(moment, least)
            end do
         end do
      end do
      call self%gather_gradient(grid, moments, nodes, 1.0_wp, affine)
   end subroutine tensor_gather_affine
end module transfer_tensor
