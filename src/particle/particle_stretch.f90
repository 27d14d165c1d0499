! SPDX-License-Identifier: BSD-3-Clause
!> Updates the sizes of particles, and the functions of loads, with their deformation.
module particle_stretch
   use base_kinds, only: wp
   use mesh_surface_load, only: turn_marks
   use particle_store, only: store_t
   implicit none
   private

   public :: stretch_tile

contains

   !> Stretch the particles of a tile by the deformation of a step, if the method requests sizes,
   !! and transform the functions of loads.
   !! The displacement gradient is that of the whole step, with respect to the positions before it.
   pure subroutine stretch_tile(store, tile, gradient)
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1) [1]
      real(wp), contiguous, intent(in) :: gradient(:, :)

      if (store%stretching) call stretch_boxes(store%first(tile), store%count(tile), gradient, &
         store%extent)
      if (allocated(store%domain)) call stretch_domains(store%first(tile), store%count(tile), &
         gradient, store%domain)
      if (allocated(store%origin%marks)) call turn_marks(store%cell_start(:, tile), &
         store%first(tile), gradient, store%origin%marks)
   end subroutine stretch_tile

   !> Stretch boxes (P. C. Wallstedt, J. E. Guilkey, J. Comput. Phys. 227 (2008) 9628). Equation
   !! (N.3) of doc/theory/node_functions.md.
   pure subroutine stretch_boxes(first, count, gradient, extent)
      integer, intent(in) :: first                           !! First particle of the tile
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(in) :: gradient(:, :)     !! (particle of the tile, 9) [1]
      real(wp), contiguous, intent(inout) :: extent(:, :)    !! (particle, 3) Half edges [m]
      integer :: p, k

      do k = 1, 3
         do p = 1, count
            extent(first + p - 1, k) = extent(first + p - 1, k)*(1.0_wp + gradient(p, 4*k - 3))
         end do
      end do
   end subroutine stretch_boxes

   !> Map each edge of a parallelepiped, r <- r + G r (A. Sadeghirad, R. M. Brannon, J. Burghardt,
   !! Int. J. Numer. Methods Eng. 86 (2011) 1435). Equation (N.8).
   pure subroutine stretch_domains(first, count, gradient, domain)
      integer, intent(in) :: first                           !! First particle of the tile
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(in) :: gradient(:, :)     !! (particle of the tile, 9) [1]
      real(wp), contiguous, intent(inout) :: domain(:, :)    !! (particle, 9) Half edges [m]
      real(wp) :: x, y, z
      integer :: p, q, edge

      do edge = 1, 7, 3
         !$omp simd private(q, x, y, z)
         do p = 1, count
            q = first + p - 1
            x = domain(q, edge)
            y = domain(q, edge + 1)
            z = domain(q, edge + 2)
            domain(q, edge) = x + (gradient(p, 1)*x + gradient(p, 4)*y + gradient(p, 7)*z)
            domain(q, edge + 1) = y + (gradient(p, 2)*x + gradient(p, 5)*y + gradient(p, 8)*z)
            domain(q, edge + 2) = z + (gradient(p, 3)*x + gradient(p, 6)*y + gradient(p, 9)*z)
         end do
      end do
   end subroutine stretch_domains
end module particle_stretch
