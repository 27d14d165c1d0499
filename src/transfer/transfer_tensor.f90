! SPDX-License-Identifier: BSD-3-Clause
!> Node functions that are products of functions of one coordinate, on the nodes -1 to 2 of the cell
!! along each direction. A basis of this kind only says what these functions are (`weigh`).
module transfer_tensor
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_basis, only: basis_t
   use transfer_gather, only: locate
   use transfer_shape_data, only: line, shape_data_t
   use transfer_spline_gather_plane, only: collect_plane, collect_slopes_plane
   use transfer_spline_kernels, only: collect_lines, collect_slopes, spread_affine_lines, &
      spread_lines, spread_stress_lines
   implicit none
   private

   public :: basis_tensor_t, fold_walls

   !> Node functions that are products.
   type, abstract, extends(basis_t) :: basis_tensor_t
   contains
      procedure :: margin => tensor_margin                   !! Layers of nodes beyond a tile
      procedure :: reach => tensor_reach                     !! Nodes of a line that are touched
      procedure :: locate => tensor_locate                   !! Places and functions
      procedure(weigh_i), deferred :: weigh                  !! Functions along the directions
      procedure :: spread => tensor_spread                   !! Values to nodes
      procedure :: spread_affine => tensor_spread_affine     !! Mass and a linear velocity field
      procedure :: spread_stress => tensor_spread_stress     !! Force of the stress
      procedure :: collect => tensor_collect                 !! Node values to particles
      procedure :: collect_gradient => tensor_collect_gradient !! Their gradients
      procedure :: collect_affine => tensor_collect_affine   !! Linear velocity field
   end type basis_tensor_t

   abstract interface
      !> Functions of the particles of a tile along one direction, from their places in the cell:
      !! weight, slope and low of `places`, as if there were no walls.
      pure subroutine weigh_i(self, grid, store, tile, direction, shape)
         import :: basis_tensor_t, grid_t, shape_data_t, store_t
         implicit none
         class(basis_tensor_t), intent(in) :: self
         type(grid_t), intent(in) :: grid                       !! The grid
         type(store_t), intent(in) :: store                     !! The particles
         integer, intent(in) :: tile                            !! Index of the tile
         integer, intent(in) :: direction                       !! 1 to 3
         type(shape_data_t), intent(inout) :: shape                !! Of the tile
      end subroutine weigh_i
   end interface

contains

   !> One layer of nodes beyond a tile.
   pure integer function tensor_margin(self) result(margin)
      class(basis_tensor_t), intent(in) :: self              !! The basis

      margin = 1
   end function tensor_margin

   !> Nodes along a line that a particle touches, counted from `low` on; three, unless the basis
   !! says otherwise.
   pure integer function tensor_reach(self) result(reach)
      class(basis_tensor_t), intent(in) :: self              !! The basis

      reach = 3
   end function tensor_reach

   !> Places in the cells and functions of all directions.
   pure subroutine tensor_locate(self, grid, coordinate, store, tile, shape)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store                     !! The particles
      integer, intent(in) :: tile                            !! Index of the tile
      type(shape_data_t), intent(inout) :: shape                !! What the maps need
      integer :: direction

      call locate(grid, store%first(tile), store%count(tile), store%position, shape%local)
      call shape%reserve_wide(store%count(tile))
      do direction = 1, 3
         if (grid%active(direction)) then
            call self%weigh(grid, store, tile, direction, shape)
            call fold_walls(grid, coordinate, store%cell_start(:, tile), direction, shape%weight, &
               shape%slope)
         else
            shape%weight(:, :, direction) = 0.0_wp
            shape%weight(:, 1, direction) = 1.0_wp
            shape%slope(:, :, direction) = 0.0_wp
            shape%low(:, direction) = 1
         end if
      end do
   end subroutine tensor_locate

   !> Give the function of a node outside a wall to the two nodes inside by linear extrapolation,
   !! 2 f to the node on the wall and -f to the next one. Linear fields stay exact, and the node on
   !! the wall has the only function that is not zero there. These are the boundary splines of M.
   !! Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods Eng. 76 (2008) 922. Equation (N.6) of
   !! doc/theory/node_functions.md.
   pure subroutine fold_walls(grid, coordinate, start, direction, weight, slope)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: direction                       !! 1 to 3
      real(wp), contiguous, intent(inout) :: weight(:, :, :) !! (particle of the tile, node, 3)
      real(wp), contiguous, intent(inout) :: slope(:, :, :)  !! The same
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
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid

      layers = merge(self%reach() - 1, 0, grid%active(3))
   end function layers_after

   !> Add sum S_i value to columns of a patch.
   pure subroutine tensor_spread(self, grid, start, shape, count, values, before, patch)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call spread_lines(grid, layers_after(self, grid), start, shape, count, values, before, patch)
   end subroutine tensor_spread

   !> Add mass and momentum of linear velocity fields.
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine tensor_spread_affine(self, grid, start, first, shape, mass, velocity, affine, &
      patch)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call spread_affine_lines(grid, layers_after(self, grid), start, first, shape, mass, &
         velocity, affine, patch)
   end subroutine tensor_spread_affine

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
   pure subroutine tensor_spread_stress(self, grid, start, first, shape, volume, stress, patch)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call spread_stress_lines(grid, layers_after(self, grid), start, first, shape, volume, &
         stress, patch)
   end subroutine tensor_spread_stress

   !> Values sum S_i node_i, three columns at a time.
   pure subroutine tensor_collect(self, grid, start, shape, nodes, values)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: part(3, size(nodes, 2))
      integer :: skip, count

      if (grid%dimensions < 3) then
         call collect_plane(grid, start, shape, nodes, values)
         return
      end if
      if (size(nodes, 1) == 3) then
         call collect_lines(grid, layers_after(self, grid), start, size(shape%weight, 1), &
            shape%weight, shape%low, size(nodes, 2), nodes, 0, values)
         return
      end if
      part = 0.0_wp
      do skip = 0, size(nodes, 1) - 1, 3
         count = min(size(nodes, 1) - skip, 3)
         part(:count, :) = nodes(skip + 1:skip + count, :)
         call collect_lines(grid, layers_after(self, grid), start, size(shape%weight, 1), &
            shape%weight, shape%low, size(nodes, 2), part, skip, values)
      end do
   end subroutine tensor_collect

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l.
   pure subroutine tensor_collect_gradient(self, grid, start, shape, nodes, scale, gradient)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      if (grid%dimensions < 3) then
         call collect_slopes_plane(grid, start, shape, nodes, scale, gradient)
         return
      end if
      call collect_slopes(grid, layers_after(self, grid), start, size(shape%weight, 1), &
         shape%weight, shape%slope, shape%low, size(nodes, 2), nodes, scale, gradient)
   end subroutine tensor_collect_gradient

   !> Linear velocity field: C_kl = sum S_i u_k (x_i - x)_l / sum S_i (x_i - x)_l**2, which keeps
   !! angular momentum (C. Jiang and others, 2015, as above). The second moments are a diagonal
   !! matrix, because the functions are products and have no first moments. Equation (N.10).
   pure subroutine tensor_collect_affine(self, grid, start, shape, nodes, affine)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
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
         do p = 1, start(grid%tile_cells)
            moment = 0.0_wp
            do n = 1, line
               away = grid%spacing*(real(n - 2, wp) - shape%local(p, direction))
               moments%slope(p, n, direction) = shape%weight(p, n, direction)*away
               moment = moment + shape%weight(p, n, direction)*away**2
            end do
            do n = 1, line
               moments%slope(p, n, direction) = moments%slope(p, n, direction)/max(moment, least)
            end do
         end do
      end do
      call self%collect_gradient(grid, start, moments, nodes, 1.0_wp, affine)
   end subroutine tensor_collect_affine
end module transfer_tensor
