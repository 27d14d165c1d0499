! SPDX-License-Identifier: BSD-3-Clause
!> Quadratic B-splines around the nodes: M. Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods
!! Eng. 76 (2008) 922.
module basis_quadratic
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_shape_data, only: line, shape_data_t
   use transfer_tensor, only: basis_tensor_t
   implicit none
   private

   public :: basis_quadratic_t

   !> Quadratic B-splines.
   type, extends(basis_tensor_t) :: basis_quadratic_t
   contains
      procedure :: at_wall => quadratic_at_wall      !! Integral of the function of a wall
      procedure :: band_width => quadratic_band_width        !! Width of a crack across a cell
      procedure :: weigh => quadratic_weigh          !! Functions along one direction
   end type basis_quadratic_t

contains

   !> Width of a crack in cells, see `basis_band_width`.
   pure real(wp) function quadratic_band_width(self) result(width)
      class(basis_quadratic_t), intent(in) :: self

      width = 1.9_wp
   end function quadratic_band_width

   !> Integral of the function of a node on a face in cells: 1/2, and twice the 1/48 of that of
   !! the node beyond, which is folded in.
   pure real(wp) function quadratic_at_wall(self) result(integral)
      class(basis_quadratic_t), intent(in) :: self

      integral = 13.0_wp/24.0_wp
   end function quadratic_at_wall

   !> With the distance d from a node in cells: (3/2 - d)**2/2, less 3 (1/2 - d)**2/2 where d < 1/2,
   !! which is 3/4 - d**2. Equation (N.4) of doc/theory/node_functions.md.
   pure subroutine quadratic_weigh(self, grid, store, tile, direction, shape)
      class(basis_quadratic_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      integer, intent(in) :: direction                       !! 1 to 3
      type(shape_data_t), intent(inout) :: shape
      real(wp) :: away, outer, inner, inverse
      integer :: p, n

      inverse = 1.0_wp/grid%spacing
      do p = 1, store%count(tile)
         shape%spline%low(p, direction) = merge(1, 2, shape%local(p, direction) < 0.5_wp)
      end do
      do n = 1, line
         do p = 1, store%count(tile)
            away = shape%local(p, direction) - real(n - 2, wp)
            outer = max(1.5_wp - abs(away), 0.0_wp)
            inner = max(0.5_wp - abs(away), 0.0_wp)
            shape%spline%weight(p, n, direction) = 0.5_wp*outer**2 - 1.5_wp*inner**2
            shape%spline%slope(p, n, direction) = -sign(inverse*(outer - 3.0_wp*inner), away)
         end do
      end do
   end subroutine quadratic_weigh
end module basis_quadratic
