! SPDX-License-Identifier: BSD-3-Clause
!> Cubic B-splines around the nodes: M. Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods
!! Eng. 76 (2008) 922.
module basis_cubic
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_shape_data, only: line, shape_data_t
   use transfer_tensor, only: basis_tensor_t
   implicit none
   private

   public :: basis_cubic_t

   !> Cubic B-splines.
   type, extends(basis_tensor_t) :: basis_cubic_t
   contains
      procedure :: at_wall => cubic_at_wall          !! Integral of the function of a wall
      procedure :: band_width => cubic_band_width        !! Width of a crack across a cell
      procedure :: reach => cubic_reach              !! Nodes of a line that are touched
      procedure :: weigh => cubic_weigh              !! Functions along one direction
   end type basis_cubic_t

contains

   !> Width of a crack in cells, see `basis_band_width`.
   pure real(wp) function cubic_band_width(self) result(width)
      class(basis_cubic_t), intent(in) :: self

      width = 2.0_wp
   end function cubic_band_width

   !> Integral of the function of a node on a face in cells: 1/2, and twice the 1/24 of that of
   !! the node beyond, which is folded in.
   pure real(wp) function cubic_at_wall(self) result(integral)
      class(basis_cubic_t), intent(in) :: self

      integral = 7.0_wp/12.0_wp
   end function cubic_at_wall

   !> Four nodes along a line.
   pure integer function cubic_reach(self) result(reach)
      class(basis_cubic_t), intent(in) :: self

      reach = line
   end function cubic_reach

   !> With the distance d from a node in cells: 2/3 - d**2 + d**3/2 up to 1, (2 - d)**3/6 up to 2.
   !! Equation (N.5) of doc/theory/node_functions.md.
   pure subroutine cubic_weigh(self, grid, store, tile, direction, shape)
      class(basis_cubic_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      integer, intent(in) :: direction                       !! 1 to 3
      type(shape_data_t), intent(inout) :: shape
      real(wp) :: x, y, inverse
      integer :: p

      inverse = 1.0_wp/grid%spacing
      do p = 1, store%count(tile)
         x = shape%local(p, direction)
         y = 1.0_wp - x
         shape%spline%low(p, direction) = 1
         shape%spline%weight(p, 1, direction) = y**3/6.0_wp
         shape%spline%weight(p, 2, direction) = 2.0_wp/3.0_wp - x**2*(1.0_wp - 0.5_wp*x)
         shape%spline%weight(p, 3, direction) = 2.0_wp/3.0_wp - y**2*(1.0_wp - 0.5_wp*y)
         shape%spline%weight(p, 4, direction) = x**3/6.0_wp
         shape%spline%slope(p, 1, direction) = -0.5_wp*inverse*y**2
         shape%spline%slope(p, 2, direction) = -inverse*x*(2.0_wp - 1.5_wp*x)
         shape%spline%slope(p, 3, direction) = inverse*y*(2.0_wp - 1.5_wp*y)
         shape%spline%slope(p, 4, direction) = 0.5_wp*inverse*x**2
      end do
   end subroutine cubic_weigh
end module basis_cubic
