! SPDX-License-Identifier: BSD-3-Clause
!> Linear functions averaged over the box of a particle, which keeps its first size (uGIMP): S. G.
!! Bardenhagen, E. M. Kober, Comput. Model. Eng. Sci. 5 (2004) 477.
module basis_gimp
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t, traits_t
   use transfer_tensor, only: basis_tensor_t
   implicit none
   private

   public :: basis_gimp_t

   real(wp), parameter :: least = 1.0e-6_wp          !! Least half of a box [cells]

   !> Means of the linear functions over boxes.
   type, extends(basis_tensor_t) :: basis_gimp_t
   contains
      procedure :: request => gimp_request           !! Particles carry their size
      procedure :: find_overhang => gimp_find_overhang !! Half the box of a particle
      procedure :: weigh => gimp_weigh               !! Functions along one direction
   end type basis_gimp_t

contains

   !> Particles carry half the edges of their boxes.
   pure subroutine gimp_request(self, traits)
      class(basis_gimp_t), intent(in) :: self
      type(traits_t), intent(inout) :: traits

      traits%extent = .true.
   end subroutine gimp_request

   !> Functions extend half the box of a particle beyond the cells adjacent to their node. The box
   !! is no longer than a cell, so that it touches three nodes along a line.
   pure subroutine gimp_find_overhang(self, grid, store, tile, direction, overhang)
      class(basis_gimp_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      integer, intent(in) :: direction                       !! 1 to 3
      real(wp), contiguous, intent(inout) :: overhang(:)     !! (particle of the tile) [cells]
      real(wp) :: inverse
      integer :: p, before

      inverse = 1.0_wp/grid%spacing
      before = store%first(tile) - 1
      !$omp simd
      do p = 1, store%count(tile)
         overhang(p) = min(max(store%extent(before + p, direction)*inverse, least), 0.5_wp)
      end do
   end subroutine gimp_find_overhang

   !> Means over the box, half of which is the overhang. With the distance d from a node and half
   !! the box l in cells the mean is the hat function 1 - d, less (l - d)**2/(2 l) where the box
   !! holds the top, more (l - |1 - d|)**2/(4 l) where it holds the foot. That is the form without
   !! branches of 1 - (d**2 + l**2)/(2 l), 1 - d and (1 + l - d)**2/(4 l). Equation (N.2) of
   !! doc/theory/node_functions.md. A box that touches three nodes holds at most the top of the
   !! function of the middle one, which is the foot of both others.
   pure subroutine gimp_weigh(self, count, nodes, inverse, local, overhang, weight, slope)
      class(basis_gimp_t), intent(in) :: self
      integer, intent(in) :: count                           !! Particles
      integer, intent(in) :: nodes                           !! Nodes, 3 or 4
      real(wp), intent(in) :: inverse                        !! 1 over the spacing [1/m]
      real(wp), contiguous, intent(in) :: local(:)           !! (particle) From the second node on
      real(wp), contiguous, intent(in) :: overhang(:)        !! (particle) [cells]
      real(wp), contiguous, intent(inout) :: weight(:, :)    !! (particle, node)
      real(wp), contiguous, intent(inout) :: slope(:, :)     !! (particle, node) [1/m]
      real(wp) :: away, top, foot, step
      integer :: p, n

      if (nodes == 3) then
         !$omp simd private(top, step)
         do p = 1, count
            top = max(overhang(p) - abs(local(p)), 0.0_wp)*(1.0_wp/overhang(p))
            step = sign(0.5_wp, local(p))
            weight(p, 1) = max(-local(p), 0.0_wp) + 0.25_wp*overhang(p)*top*top
            weight(p, 2) = (1.0_wp - abs(local(p))) - 0.5_wp*overhang(p)*top*top
            weight(p, 3) = max(local(p), 0.0_wp) + 0.25_wp*overhang(p)*top*top
            slope(p, 1) = -inverse*((0.5_wp - step) + step*top)
            slope(p, 2) = inverse*(-2.0_wp*step*(1.0_wp - top))
            slope(p, 3) = inverse*((0.5_wp + step) - step*top)
         end do
         return
      end if
      do n = 1, nodes
         !$omp simd private(away, top, foot, step)
         do p = 1, count
            away = local(p) - real(n - 2, wp)
            ! parts of the box beyond its upper and lower node, as fractions of its half width
            top = max(overhang(p) - abs(away), 0.0_wp)*(1.0_wp/overhang(p))
            foot = max(overhang(p) - abs(1.0_wp - abs(away)), 0.0_wp)*(1.0_wp/overhang(p))
            step = sign(0.5_wp, 1.0_wp - abs(away))
            weight(p, n) = max(1.0_wp - abs(away), 0.0_wp) &
               + overhang(p)*(0.25_wp*foot*foot - 0.5_wp*top*top)
            slope(p, n) = -sign(inverse, away)*((0.5_wp + step) - step*foot - top)
         end do
      end do
   end subroutine gimp_weigh
end module basis_gimp
