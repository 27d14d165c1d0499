! SPDX-License-Identifier: BSD-3-Clause
!> Linear functions of the cell, of the material point method of D. Sulsky, Z. Chen, H. L. Schreyer,
!! Comput. Methods Appl. Mech. Eng. 118 (1994) 179. A particle touches only the nodes of its cell.
!! Equation (N.1) of doc/theory/node_functions.md.
!!
!! Sums and values are the same in all dimensions; the kernel, for space or plane, is chosen here
!! once a tile. Nodes of missing directions have no work.
module basis_linear
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_basis, only: basis_t
   use transfer_gather, only: gather_gradient, gather_hoop, gather_motion, gather_values
   use transfer_hoop, only: gather_factored_hoop
   use transfer_scatter, only: scatter_values
   use transfer_scatter_affine, only: scatter_affine, scatter_turning
   use transfer_scatter_plane, only: plane_force
   use transfer_scatter_space, only: space_force
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: basis_linear_t

   !> Linear shape functions. Each map has its own kernel.
   type, extends(basis_t) :: basis_linear_t
   contains
      procedure :: is_linear => linear_is_linear
      procedure :: suits_cell => linear_suits_cell
      procedure :: locate => linear_locate
      procedure :: scatter_values => linear_scatter_values
      procedure :: scatter_affine => linear_scatter_affine
      procedure :: scatter_stress => linear_scatter_stress
      procedure :: gather_values => linear_gather_values
      procedure :: gather_gradient => linear_gather_gradient
      procedure :: scatter_turning => linear_scatter_turning
      procedure :: gather_motion => linear_gather_motion
      procedure :: gather_hoop => linear_gather_hoop
   end type basis_linear_t

contains

   !> These are the linear functions.
   pure logical function linear_is_linear(self) result(yes)
      class(basis_linear_t), intent(in) :: self

      yes = .true.
   end function linear_is_linear

   !> Particles have no fields that follow the mesh.
   pure logical function linear_suits_cell(self) result(yes)
      class(basis_linear_t), intent(in) :: self

      yes = .true.
   end function linear_suits_cell

   !> Cells and local coordinates.
   pure subroutine linear_locate(self, grid, coordinate, store, tile, shape)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      type(shape_data_t), intent(inout) :: shape

      call shape%take_tile(grid, store, tile)
   end subroutine linear_locate

   !> Add sum S_i value to columns of a patch.
   pure subroutine linear_scatter_values(self, grid, shape, count, values, before, patch)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_values(grid, shape%start, shape%local, count, values, before, patch)
   end subroutine linear_scatter_values

   !> Add mass and momentum of linear velocity fields, sum m S_i (v + C (x_i - x)), to columns 1 to
   !! 4 of a patch (C. Jiang, C. Schroeder, A. Selle, J. Teran, A. Stomakhin, ACM Trans. Graph. 34
   !! (2015) 51). Equation (T.3) of doc/theory/transfers.md.
   pure subroutine linear_scatter_affine(self, grid, shape, first, mass, velocity, affine, patch)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_affine(grid, shape%start, first, shape%local, mass, velocity, affine, patch)
   end subroutine linear_scatter_affine

   !> Add mass and momentum of rotating particles, sum m S_i (v + w x (x_i - x)), to columns 1 to 4
   !! of a patch. Equation (T.4).
   pure subroutine linear_scatter_turning(self, grid, shape, first, mass, velocity, spin, patch)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(inout) :: shape
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) w [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_turning(grid, shape%start, first, shape%local, mass, velocity, spin, patch)
   end subroutine linear_scatter_turning

   !> Add the internal force of the plain method, - sum v sigma . grad S, to columns 5 to 7.
   !! Equation (M.4) of doc/theory/method.md.
   pure subroutine linear_scatter_stress(self, grid, shape, first, volume, stress, patch)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call space_force(grid, shape%start, first, shape%local, volume, stress, patch)
      else
         call plane_force(grid, shape%start, first, shape%local, volume, stress, patch)
      end if
   end subroutine linear_scatter_stress

   !> Values sum S_i node_i.
   pure subroutine linear_gather_values(self, grid, shape, nodes, values)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)

      call gather_values(grid, shape%start, shape%local, nodes, values)
   end subroutine linear_gather_values

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l.
   pure subroutine linear_gather_gradient(self, grid, shape, nodes, scale, gradient)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      call gather_gradient(grid, shape%start, shape%local, nodes, scale, gradient)
   end subroutine linear_gather_gradient

   !> Velocity and position at once.
   pure subroutine linear_gather_motion(self, grid, shape, first, increment, advection, &
      flip_fraction, dt, velocity, position)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(inout) :: shape
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: increment(:, :)    !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: advection(:, :)    !! (3, node) [m/s]
      real(wp), intent(in) :: flip_fraction                  !! Fraction of the old velocity [1]
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]

      call gather_motion(grid, shape%start, first, shape%local, increment, advection, &
         flip_fraction, dt, velocity, position)
   end subroutine linear_gather_motion

   !> Hoop rate into component (2, 2) of the gradient, with factors where sums are normalised.
   pure subroutine linear_gather_hoop(self, grid, shape, first, position, nodes, scale, gradient)
      class(basis_linear_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(inout) :: shape
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      if (allocated(shape%factor)) then
         call gather_factored_hoop(grid, shape%start, first, shape%local, shape%factor, position, &
            nodes, scale, gradient)
      else
         call gather_hoop(grid, shape%start, first, shape%local, position, nodes, scale, gradient)
      end if
   end subroutine linear_gather_hoop
end module basis_linear
