! SPDX-License-Identifier: BSD-3-Clause
!> The modified gradient at the particle itself: D. Z. Zhang, X. Ma, P. T. Giguere, J. Comput. Phys.
!! 230 (2011) 6379, in the two-step form. Equation (M.2) of doc/theory/method.md.
module quadrature_point
   use base_kinds, only: wp
   use ddmp_alpha, only: find_alpha, find_blend
   use ddmp_quadrature, only: quadrature_t
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_edges, only: gather_edge_gradient
   use transfer_gather, only: gather_dual_gradient
   use transfer_scatter, only: scatter_dual_force
   use transfer_shape_data, only: shape_data_t, spare
   implicit none
   private

   public :: quadrature_point_t

   !> The gradient at one point.
   type, extends(quadrature_t) :: quadrature_point_t
   contains
      procedure :: suits_cell => point_suits_cell    !! Particles have no fields of the mesh
      procedure :: locate => point_locate            !! alpha at the particles
      procedure :: scatter_force => point_scatter_force !! Force, volume and node stress
      procedure :: gather_gradient => point_gather_gradient !! Velocity gradient
   end type quadrature_point_t

contains

   !> Particles have no fields that follow the mesh.
   pure logical function point_suits_cell(self) result(yes)
      class(quadrature_point_t), intent(in) :: self

      yes = .true.
   end function point_suits_cell

   !> alpha of the particles of a tile.
   pure subroutine point_locate(self, grid, coordinate, store, tile, shape)
      class(quadrature_point_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      type(shape_data_t), intent(inout) :: shape

      call find_alpha(grid, self%alpha, self%alpha_centre, shape%count, shape%local, &
         shape%alpha)
      if (self%smooth) then
         call find_blend(grid, shape%count, shape%local, shape%blend)
      else
         shape%blend(:shape%count, :) = shape%local(:shape%count, :)
      end if
      shape%alpha(shape%count + 1:shape%count + spare, :) = 1.0_wp
      shape%blend(shape%count + 1:shape%count + spare, :) = 0.0_wp
   end subroutine point_locate

   !> Force, volume and node stress.
   pure subroutine point_scatter_force(self, grid, shape, first, volume, stress, patch)
      class(quadrature_point_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      ! if `factor` is not allocated, the optional argument is absent
      call scatter_dual_force(grid, shape%start, first, shape%blend, shape%alpha, volume, stress, &
         patch, shape%factor)
   end subroutine point_scatter_force

   !> Velocity gradient: that of the cell, blended with that of the nodes.
   pure subroutine point_gather_gradient(self, grid, shape, nodes, node_gradient, scale, gradient)
      class(quadrature_point_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), contiguous, intent(in) :: node_gradient(:, :) !! (9, node) On the nodes [1/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      if (allocated(shape%factor)) then
         call gather_edge_gradient(grid, shape%start, shape%blend, shape%alpha, shape%factor, &
            nodes, node_gradient, scale, gradient)
         return
      end if
      call gather_dual_gradient(grid, shape%start, shape%blend, shape%alpha, nodes, node_gradient, &
         scale, gradient)
   end subroutine point_gather_gradient
end module quadrature_point
