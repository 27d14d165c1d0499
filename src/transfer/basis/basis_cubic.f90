! SPDX-License-Identifier: BSD-3-Clause
!> Cubic B-splines around the nodes: M. Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods
!! Eng. 76 (2008) 922.
module basis_cubic
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_shape_data, only: line
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
      procedure :: find_overhang => cubic_find_overhang !! Range of the functions beyond the cell
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

   !> Functions extend one cell beyond the cells adjacent to their node.
   pure subroutine cubic_find_overhang(self, grid, store, tile, direction, overhang)
      class(basis_cubic_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      integer, intent(in) :: direction                       !! 1 to 3
      real(wp), contiguous, intent(inout) :: overhang(:)     !! (particle of the tile) [cells]

      overhang(:store%count(tile)) = 1.0_wp
   end subroutine cubic_find_overhang

   !> With the distance d from a node in cells: 2/3 - d**2 + d**3/2 up to 1, (2 - d)**3/6 up to 2.
   !! Equation (N.5) of doc/theory/node_functions.md.
   pure subroutine cubic_weigh(self, count, nodes, inverse, local, overhang, weight, slope)
      class(basis_cubic_t), intent(in) :: self
      integer, intent(in) :: count                           !! Particles
      integer, intent(in) :: nodes                           !! Nodes, 3 or 4
      real(wp), intent(in) :: inverse                        !! 1 over the spacing [1/m]
      real(wp), contiguous, intent(in) :: local(:)           !! (particle) From the second node on
      real(wp), contiguous, intent(in) :: overhang(:)        !! (particle) [cells]
      real(wp), contiguous, intent(inout) :: weight(:, :)    !! (particle, node)
      real(wp), contiguous, intent(inout) :: slope(:, :)     !! (particle, node) [1/m]
      real(wp) :: x, y
      integer :: p

      !$omp simd private(x, y)
      do p = 1, count
         x = local(p)
         y = 1.0_wp - x
         weight(p, 1) = y*y*y*(1.0_wp/6.0_wp)
         weight(p, 2) = 2.0_wp/3.0_wp - x*x*(1.0_wp - 0.5_wp*x)
         weight(p, 3) = 2.0_wp/3.0_wp - y*y*(1.0_wp - 0.5_wp*y)
         weight(p, 4) = x*x*x*(1.0_wp/6.0_wp)
         slope(p, 1) = -0.5_wp*inverse*(y*y)
         slope(p, 2) = -inverse*x*(2.0_wp - 1.5_wp*x)
         slope(p, 3) = inverse*y*(2.0_wp - 1.5_wp*y)
         slope(p, 4) = 0.5_wp*inverse*(x*x)
      end do
   end subroutine cubic_weigh
end module basis_cubic
