! SPDX-License-Identifier: BSD-3-Clause
!> Shape functions that are products of functions of one coordinate, on the nodes -1 to 2 of the
!! cell along each direction. A basis of this kind only defines these functions (`weigh`) and their
!! reach (`find_overhang`).
module transfer_tensor
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_basis, only: basis_t
   use transfer_shape_data, only: line, shape_data_t, spline_data_t
   use transfer_spline_gather, only: gather_spline_gradient, gather_spline_values
   use transfer_spline_gather_plane, only: gather_plane_gradient
   use transfer_spline_kernels, only: scatter_spline_affine, scatter_spline_stress, &
      scatter_spline_values
   implicit none
   private

   public :: basis_tensor_t

   !> Shape functions that are products.
   type, abstract, extends(basis_t) :: basis_tensor_t
   contains
      procedure :: margin => tensor_margin           !! Layers of nodes beyond a tile
      procedure :: suits_cell => tensor_suits_cell   !! May the mesh deform with its cell?
      procedure :: reach => tensor_reach             !! Nodes of a line that are touched
      procedure :: locate => tensor_locate           !! Local coordinates and functions
      procedure(find_overhang_i), deferred :: find_overhang !! How far functions reach
      procedure(weigh_i), deferred :: weigh          !! Functions along a direction
      procedure :: scatter_values => tensor_scatter_values !! Values to nodes
      procedure :: scatter_affine => tensor_scatter_affine !! Mass and a linear velocity field
      procedure :: scatter_stress => tensor_scatter_stress !! Force of the stress
      procedure :: gather_values => tensor_gather_values !! Node values to particles
      procedure :: gather_gradient => tensor_gather_gradient !! Gradients of the values
      procedure :: gather_affine => tensor_gather_affine !! Linear velocity field
   end type basis_tensor_t

   abstract interface
      !> Extent of the function of a node beyond its adjacent cells, for each particle of a tile
      !! [cells]: a particle with a smaller local coordinate touches the node before its cell.
      pure subroutine find_overhang_i(self, grid, store, tile, direction, overhang)
         import :: basis_tensor_t, grid_t, store_t, wp
         implicit none
         class(basis_tensor_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         type(store_t), intent(in) :: store
         integer, intent(in) :: tile                            !! Index of the tile
         integer, intent(in) :: direction                       !! 1 to 3
         real(wp), contiguous, intent(inout) :: overhang(:)     !! (particle of the tile) [cells]
      end subroutine find_overhang_i

      !> Functions of nodes along one direction, and their mean derivatives, as if there were no
      !! walls. If nodes is 3, no particle touches a fourth node.
      pure subroutine weigh_i(self, count, nodes, inverse, local, overhang, weight, slope)
         import :: basis_tensor_t, wp
         implicit none
         class(basis_tensor_t), intent(in) :: self
         integer, intent(in) :: count                           !! Particles
         integer, intent(in) :: nodes                           !! Nodes, 3 or 4
         real(wp), intent(in) :: inverse                        !! 1 over the spacing [1/m]
         !> (particle) Coordinate from the second of the nodes on [cells]
         real(wp), contiguous, intent(in) :: local(:)
         real(wp), contiguous, intent(in) :: overhang(:)        !! (particle) [cells]
         real(wp), contiguous, intent(inout) :: weight(:, :)    !! (particle, node)
         real(wp), contiguous, intent(inout) :: slope(:, :)     !! (particle, node) [1/m]
      end subroutine weigh_i
   end interface

contains

   !> Products of functions along the edges of the mesh deform with it.
   pure logical function tensor_suits_cell(self) result(yes)
      class(basis_tensor_t), intent(in) :: self

      yes = .true.
   end function tensor_suits_cell

   !> One layer of nodes beyond a tile.
   pure integer function tensor_margin(self) result(margin)
      class(basis_tensor_t), intent(in) :: self

      margin = 1
   end function tensor_margin

   !> Nodes along a line that a particle touches, counted from `low` on; default: three.
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
      call shape%spline%take_cells(grid, shape%start)
      shape%spline%after = merge(self%reach() - 1, 0, grid%active(3))
      do direction = 1, 3
         if (.not. grid%active(direction)) then
            shape%spline%weight(:, :, direction) = 0.0_wp
            shape%spline%weight(:, 1, direction) = 1.0_wp
            shape%spline%slope(:, :, direction) = 0.0_wp
            shape%spline%local(:, direction) = 0.0_wp
            shape%spline%low(:, direction) = 1
            cycle
         end if
         call self%find_overhang(grid, store, tile, direction, shape%spline%overhang(:, direction))
         call find_first(self%reach(), grid, direction, shape)
         call self%weigh(shape%count, shape%spline%reach, 1.0_wp/grid%spacing, &
            shape%spline%local(:, direction), shape%spline%overhang(:, direction), &
            shape%spline%weight(:, :, direction), shape%spline%slope(:, :, direction))
         call fold_walls(grid, coordinate, store%cell_start(:, tile), direction, shape%spline)
      end do
   end subroutine tensor_locate

   !> First nodes of particles along one direction. In three dimensions functions are given from the
   !! first node that counts on. In planes and on lines they are given for four nodes, and `low` is
   !! the first that counts.
   pure subroutine find_first(reach, grid, direction, shape)
      integer, intent(in) :: reach                           !! Nodes of a line that are touched
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: direction                       !! 1 to 3
      type(shape_data_t), intent(inout) :: shape
      integer :: p, stride
      real(wp) :: x

      stride = grid%stride(direction)
      associate (spline => shape%spline)
         if (grid%active(2)) spline%reach = reach
         if (spline%reach == line) then
            do p = 1, shape%count
               spline%local(p, direction) = shape%local(p, direction)
            end do
            do p = 1, shape%count
               spline%low(p, direction) = merge(1, 2, &
                  shape%local(p, direction) < spline%overhang(p, direction))
            end do
         else
            !$omp simd private(x)
            do p = 1, shape%count
               x = merge(0.0_wp, 1.0_wp, shape%local(p, direction) < spline%overhang(p, direction))
               spline%local(p, direction) = shape%local(p, direction) - x
               spline%low(p, direction) = 1
               spline%node(p) = spline%node(p) + stride*int(x)
            end do
         end if
      end associate
   end subroutine find_first

   !> Give the function of a node outside a wall to the two nodes inside by linear extrapolation,
   !! 2 f to the node on the wall and -f to the next one. Linear fields stay exact, and the node on
   !! the wall has the only function that is not zero there. These are the boundary splines of M.
   !! Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods Eng. 76 (2008) 922. Equation (N.6) of
   !! doc/theory/node_functions.md.
   pure subroutine fold_walls(grid, coordinate, start, direction, spline)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: direction                       !! 1 to 3
      type(spline_data_t), intent(inout) :: spline
      integer :: cell, place, side, out, inward, p

      if (.not. any(grid%wall(2*direction - 1:2*direction))) return
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         place = coordinate(direction)*grid%width(direction) + grid%cell_position(direction, cell)
         do side = 1, 2
            if (.not. grid%wall(2*direction - 2 + side)) cycle
            if (place /= merge(0, grid%cells(direction) - 1, side == 1)) cycle
            inward = merge(1, -1, side == 1)
            do p = start(cell) + 1, start(cell + 1)
               ! the coordinate is negative where functions are given from the first node of the
               ! cell on
               out = merge(1, line, side == 1) - merge(1, 0, spline%local(p, direction) < 0.0_wp)
               if (out < 1 .or. out > spline%reach) cycle
               call fold(spline%weight(p, :, direction), out, inward)
               call fold(spline%slope(p, :, direction), out, inward)
            end do
         end do
      end do
   end subroutine fold_walls

   !> Fold the functions of one particle.
   pure subroutine fold(f, out, inward)
      real(wp), intent(inout) :: f(:)                        !! (node)
      integer, intent(in) :: out                             !! Node outside
      integer, intent(in) :: inward                          !! Offset to the next node inside

      f(out + inward) = f(out + inward) + 2.0_wp*f(out)
      f(out + 2*inward) = f(out + 2*inward) - f(out)
      f(out) = 0.0_wp
   end subroutine fold

   !> Add sum S_i value to columns of a patch.
   pure subroutine tensor_scatter_values(self, grid, shape, count, values, before, patch)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_spline_values(grid, shape%count, shape%spline, count, values, before, patch)
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

      call scatter_spline_affine(grid, shape, first, mass, velocity, affine, patch)
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

      call scatter_spline_stress(grid, shape%count, shape%spline, first, volume, stress, patch)
   end subroutine tensor_scatter_stress

   !> Values sum S_i node_i.
   pure subroutine tensor_gather_values(self, grid, shape, nodes, values)
      class(basis_tensor_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)

      call gather_spline_values(grid, shape%start, shape%spline, nodes, values)
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
      else
         call gather_spline_gradient(grid, shape%count, shape%spline, nodes, scale, gradient)
      end if
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
      moments%count = shape%count
      moments%start = shape%start
      moments%spline = shape%spline
      do direction = 1, 3
         if (.not. grid%active(direction)) cycle
         do p = 1, shape%count
            moment = 0.0_wp
            do n = 1, shape%spline%reach
               away = grid%spacing*(real(n - 2, wp) - shape%spline%local(p, direction))
               moments%spline%slope(p, n, direction) = shape%spline%weight(p, n, direction)*away
               moment = moment + shape%spline%weight(p, n, direction)*away**2
            end do
            do n = 1, shape%spline%reach
               moments%spline%slope(p, n, direction) = &
                  moments%spline%slope(p, n, direction)/max(moment, least)
            end do
         end do
      end do
      call self%gather_gradient(grid, moments, nodes, 1.0_wp, affine)
   end subroutine tensor_gather_affine
end module transfer_tensor
