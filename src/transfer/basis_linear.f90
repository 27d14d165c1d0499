! SPDX-License-Identifier: BSD-3-Clause
!> Linear functions of the cell, of the material point method of D. Sulsky, Z. Chen, H. L. Schreyer,
!> Comput. Methods Appl. Mech. Eng. 118 (1994) 179. A particle touches only the nodes of its cell.
!! Equation (N.1) of doc/theory/node_functions.md.
module basis_linear
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_basis, only: basis_t
   use transfer_gather, only: gather_gradient, gather_hoop, gather_motion, gather_values, &
      gather_vector, locate
   use transfer_hoop, only: gather_factored_hoop
   use transfer_scatter, only: scatter_affine, scatter_force, scatter_motion, scatter_turning, &
      scatter_values
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: basis_linear_t

   !> Linear node functions; every map has a kernel of its own.
   type, extends(basis_t) :: basis_linear_t
   contains
      procedure :: locate => linear_locate                   !! Places in the cells
      procedure :: spread => linear_spread                   !! Values to nodes
      procedure :: spread_affine => linear_spread_affine     !! Mass and a linear velocity field
      procedure :: spread_stress => linear_spread_stress     !! Force of the stress
      procedure :: collect => linear_collect                 !! Node values to particles
      procedure :: collect_gradient => linear_collect_gradient !! Their gradients
      procedure :: scatter_motion => linear_scatter_motion   !! Mass and momentum
      procedure :: scatter_turning => linear_scatter_turning !! Those of particles that turn
      procedure :: gather_motion => linear_gather_motion     !! Velocity and position
      procedure :: gather_vector => linear_gather_vector     !! One particle vector
      procedure :: gather_hoop => linear_gather_hoop         !! Hoop rate
   end type basis_linear_t

contains

   !> Places in the cells.
   pure subroutine linear_locate(self, grid, coordinate, store, tile, shape)
      class(basis_linear_t), intent(in) :: self          !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store                     !! The particles
      integer, intent(in) :: tile                            !! Index of the tile
      type(shape_data_t), intent(inout) :: shape                !! What the maps need

      call locate(grid, store%first(tile), store%count(tile), store%position, shape%local)
   end subroutine linear_locate

   !> Add sum S_i value to columns of a patch.
   pure subroutine linear_spread(self, grid, start, shape, count, values, before, patch)
      class(basis_linear_t), intent(in) :: self          !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_values(grid, start, shape%local, count, values, before, patch)
   end subroutine linear_spread

   !> Add mass and momentum of linear velocity fields.
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine linear_spread_affine(self, grid, start, first, shape, mass, velocity, &
      affine, patch)
      class(basis_linear_t), intent(in) :: self          !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_affine(grid, start, first, shape%local, mass, velocity, affine, patch)
   end subroutine linear_spread_affine

   !> Add the internal force to columns 5 to 7 of a patch.
   pure subroutine linear_spread_stress(self, grid, start, first, shape, volume, stress, patch)
      class(basis_linear_t), intent(in) :: self          !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_force(grid, start, first, shape%local, volume, stress, patch)
   end subroutine linear_spread_stress

   !> Values sum S_i node_i.
   pure subroutine linear_collect(self, grid, start, shape, nodes, values)
      class(basis_linear_t), intent(in) :: self          !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)

      call gather_values(grid, start, shape%local, nodes, values)
   end subroutine linear_collect

   !> Scaled velocity gradient.
   pure subroutine linear_collect_gradient(self, grid, start, shape, nodes, scale, gradient)
      class(basis_linear_t), intent(in) :: self          !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(shape_data_t), intent(in) :: shape                   !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: gradient(:, :)

      call gather_gradient(grid, start, shape%local, nodes, scale, gradient)
   end subroutine linear_collect_gradient

   !> Add mass and momentum to columns 1 to 4 of a patch.
   pure subroutine linear_scatter_motion(self, grid, start, first, shape, mass, velocity, patch)
      class(basis_linear_t), intent(in) :: self                     !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape                !! Of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_motion(grid, start, first, shape%local, mass, velocity, patch)
   end subroutine linear_scatter_motion

   !> Add mass and momentum of particles that turn to columns 1 to 4 of a patch.
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine linear_scatter_turning(self, grid, start, first, shape, mass, velocity, spin, &
      patch)
      class(basis_linear_t), intent(in) :: self          !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape                !! Of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) w [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_turning(grid, start, first, shape%local, mass, velocity, spin, patch)
   end subroutine linear_scatter_turning

   !> Velocity and position at once.
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine linear_gather_motion(self, grid, start, first, shape, push, carry, keep, &
      dt, velocity, position)
      class(basis_linear_t), intent(in) :: self                     !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape                !! Of the tile
      real(wp), contiguous, intent(in) :: push(:, :)         !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: carry(:, :)        !! (3, node) [m/s]
      real(wp), intent(in) :: keep                           !! Share of the old velocity
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]

      call gather_motion(grid, start, first, shape%local, push, carry, keep, dt, velocity, &
         position)
   end subroutine linear_gather_motion

   !> Particle vectors from node vectors.
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine linear_gather_vector(self, grid, start, first, shape, nodes, keep, scale, &
      values)
      class(basis_linear_t), intent(in) :: self                     !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape                !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node)
      real(wp), intent(in) :: keep                           !! Share of the old value
      real(wp), intent(in) :: scale                          !! Factor of the node values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle, 3)

      call gather_vector(grid, start, first, shape%local, nodes, keep, scale, values)
   end subroutine linear_gather_vector

   !> Hoop rate into component (2, 2) of the gradient, with factors where sums are normalised.
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine linear_gather_hoop(self, grid, start, first, shape, position, nodes, &
      scale, gradient)
      class(basis_linear_t), intent(in) :: self                     !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape                !! Of the tile
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      if (allocated(shape%factor)) then
         call gather_factored_hoop(grid, start, first, shape%local, shape%factor, position, &
            nodes, scale, gradient)
      else
         call gather_hoop(grid, start, first, shape%local, position, nodes, scale, gradient)
      end if
   end subroutine linear_gather_hoop
end module basis_linear
