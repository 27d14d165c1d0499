! SPDX-License-Identifier: BSD-3-Clause
!> Quadrature of the modified gradient at a particle: its part on the cell, and its part through the
!! nodes. Force and strain use the same rule, so that the power of the force is that of the stress.
!! Equations (M.2) and (M.15) of doc/theory/method.md.
module ddmp_quadrature
   use base_kinds, only: wp
   use ddmp_alpha, only: alpha_split
   use mesh_grid, only: grid_t
   use particle_store, only: store_t, traits_t
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: quadrature_t

   !> Rule for the modified gradient.
   type, abstract :: quadrature_t
      integer :: alpha = alpha_split                 !! Form of alpha
      real(wp) :: alpha_centre = 1.0_wp              !! alpha at the centre of a cell [1]
      logical :: smooth = .true.                     !! Does the gradient have no kinks?
   contains
      procedure :: margin => quadrature_margin       !! Layers of nodes reached beyond a tile
      procedure :: controlled => quadrature_controlled !! Is a mean stress integrated exactly?
      procedure :: is_plain => quadrature_is_plain   !! Does it need no other particles?
      procedure :: suits_cell => quadrature_suits_cell !! May the mesh deform with its cell?
      procedure :: needs_split => quadrature_needs_split !! Does it need the split form of alpha?
      procedure :: request => quadrature_request !! Requests fields of particles
      procedure(locate_i), deferred :: locate        !! Finds the shape data of a tile
      procedure(scatter_i), deferred :: scatter_force !! Force, volume and node stress
      procedure(gather_i), deferred :: gather_gradient !! Velocity gradient
   end type quadrature_t

   abstract interface
      !> Shape data of the particles of a tile. Those of the basis are computed before.
      pure subroutine locate_i(self, grid, coordinate, store, tile, shape)
         import :: grid_t, shape_data_t, quadrature_t, store_t
         implicit none
         class(quadrature_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
         type(store_t), intent(in) :: store
         integer, intent(in) :: tile                            !! Index of the tile
         type(shape_data_t), intent(inout) :: shape
      end subroutine locate_i

      !> Add the part of the internal force on the cell to columns 5 to 7, the volume to column 8,
      !! and the stress mapped to the nodes to columns 9 to 17 of a patch.
      pure subroutine scatter_i(self, grid, shape, first, volume, stress, patch)
         import :: grid_t, shape_data_t, quadrature_t, wp
         implicit none
         class(quadrature_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         integer, intent(in) :: first                           !! First particle of the tile
         type(shape_data_t), intent(inout) :: shape
         real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
         real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
         real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      end subroutine scatter_i

      !> Scaled velocity gradient at the particles, component (k, l) in column k + 3 (l - 1).
      pure subroutine gather_i(self, grid, shape, nodes, node_gradient, scale, gradient)
         import :: grid_t, shape_data_t, quadrature_t, wp
         implicit none
         class(quadrature_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         type(shape_data_t), intent(inout) :: shape
         real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
         real(wp), contiguous, intent(in) :: node_gradient(:, :) !! (9, node) On the nodes [1/s]
         real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
         real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      end subroutine gather_i
   end interface

contains

   !> Layers of nodes beyond a tile that its particles reach; default: none.
   pure integer function quadrature_margin(self) result(margin)
      class(quadrature_t), intent(in) :: self

      margin = 0
   end function quadrature_margin

   !> True if the mean stress of the nodes is subtracted from the particles and integrated exactly
   !! on the grid.
   pure logical function quadrature_controlled(self) result(controlled)
      class(quadrature_t), intent(in) :: self

      controlled = .false.
   end function quadrature_controlled

   !> True if the rule evaluates the whole stress of a particle in its own cell: only this allows a
   !! second velocity of a body, and sums that are divided by those of the weights.
   pure logical function quadrature_is_plain(self) result(yes)
      class(quadrature_t), intent(in) :: self

      yes = .not. (self%controlled() .or. self%margin() > 0)
   end function quadrature_is_plain

   !> May the mesh deform with a periodic cell?
   pure logical function quadrature_suits_cell(self) result(yes)
      class(quadrature_t), intent(in) :: self

      yes = .false.
   end function quadrature_suits_cell

   !> Must alpha be a product of one function per direction, the split form?
   pure logical function quadrature_needs_split(self) result(yes)
      class(quadrature_t), intent(in) :: self

      yes = .false.
   end function quadrature_needs_split

   !> Request fields of particles. Most request none.
   pure subroutine quadrature_request(self, traits)
      class(quadrature_t), intent(in) :: self
      type(traits_t), intent(inout) :: traits
   end subroutine quadrature_request
end module ddmp_quadrature
