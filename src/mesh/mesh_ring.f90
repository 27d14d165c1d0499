! SPDX-License-Identifier: BSD-3-Clause
!> Rings with a square section, whose particle is at the centroid. Equation (M.25) of
!! doc/theory/method.md.
module mesh_ring
   use base_constants, only: pi
   use base_kinds, only: wp
   implicit none
   private

   public :: ring_centre, ring_middle

contains

   !> Radius of the centroid of a ring. With its particles there, the mass of each node is the
   !! density times its volume, also on the axis.
   elemental real(wp) function ring_centre(middle, width) result(radius)
      real(wp), intent(in) :: middle                  !! Radius of the middle of the ring [m]
      real(wp), intent(in) :: width                   !! Outer less inner radius [m]

      radius = middle + width**2/(12.0_wp*middle)
   end function ring_centre

   !> Radius of the middle of a ring with a square section: the greatest root of (M.25) with the
   !! width from the volume. Without a root, it is the radius of the centroid.
   elemental real(wp) function ring_middle(radius, volume) result(middle)
      real(wp), intent(in) :: radius                  !! Radius of the centroid [m]
      real(wp), intent(in) :: volume                  !! [m3]
      real(wp) :: cosine

      middle = radius
      if (.not. radius > 0.0_wp) return
      cosine = 1.0_wp - 9.0_wp*volume/(16.0_wp*pi*radius**3)
      if (cosine > -1.0_wp) middle = radius*(1.0_wp + 2.0_wp*cos(acos(cosine)/3.0_wp))/3.0_wp
   end function ring_middle
end module mesh_ring
