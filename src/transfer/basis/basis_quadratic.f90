! SPDX-License-Identifier: BSD-3-Clause
!> Quadratic B-splines around the nodes: M. Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods
!! Eng. 76 (2008) 922.
module basis_quadratic
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_tensor, only: basis_tensor_t
   implicit none
   private

   public :: basis_quadratic_t

   !> Quadratic B-splines.
   type, extends(basis_tensor_t) :: basis_quadratic_t
   contains
      procedure :: at_wall => quadratic_at_wall      !! Integral of the function of a wall
      procedure :: band_width => quadratic_band_width        !! Width of a crack across a cell
      procedure :: find_overhang => quadratic_find_overhang !! How far functions reach
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

   !> Functions extend half a cell beyond the cells adjacent to their node.
   pure subroutine quadratic_find_overhang(self, grid, store, tile, direction, overhang)
      class(basis_quadratic_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      integer, intent(in) :: direction                       !! 1 to 3
      real(wp), contiguous, intent(inout) :: overhang(:)     !! (particle of the tile) [cells]

      overhang(:store%count(tile)) = 0.5_wp
   end subroutine quadratic_find_overhang

   !> With the distance d from a node in cells: (3/2 - d)**2/2, less 3 (1/2 - d)**2/2 where d < 1/2,
   !! which is 3/4 - d**2. Equation (N.4) of doc/theory/node_functions.md.
   pure subroutine quadratic_weigh(self, count, nodes, inverse, local, overhang, weight, slope)
      class(basis_quadratic_t), intent(in) :: self
      integer, intent(in) :: count                           !! Particles
      integer, intent(in) :: nodes                           !! Nodes, 3 or 4
      real(wp), intent(in) :: inverse                        !! 1 over the spacing [1/m]
      real(wp), contiguous, intent(in) :: local(:)           !! (particle) From the second node on
      real(wp), contiguous, intent(in) :: overhang(:)        !! (particle) [cells]
      real(wp), contiguous, intent(inout) :: weight(:, :)    !! (particle, node)
      real(wp), contiguous, intent(inout) :: slope(:, :)     !! (particle, node) [1/m]
      real(wp) :: away, outer, inner, lower, upper
      integer :: p, n

      if (nodes == 3) then
         ! none is further from the middle node than half a cell
         !$omp simd private(lower, upper)
         do p = 1, count
            lower = 0.5_wp - local(p)
            upper = 0.5_wp + local(p)
            weight(p, 1) = 0.5_wp*lower*lower
            weight(p, 2) = 0.75_wp - local(p)*local(p)
            weight(p, 3) = 0.5_wp*upper*upper
            slope(p, 1) = -inverse*lower
            slope(p, 2) = -2.0_wp*inverse*local(p)
            slope(p, 3) = inverse*upper
         end do
         return
      end if
      do n = 1, nodes
         !$omp simd private(away, outer, inner)
         do p = 1, count
            away = local(p) - real(n - 2, wp)
            outer = max(1.5_wp - abs(away), 0.0_wp)
            inner = max(0.5_wp - abs(away), 0.0_wp)
            weight(p, n) = 0.5_wp*outer**2 - 1.5_wp*inner**2
            slope(p, n) = -sign(inverse*(outer - 3.0_wp*inner), away)
         end do
      end do
   end subroutine quadratic_weigh
end module basis_quadratic
