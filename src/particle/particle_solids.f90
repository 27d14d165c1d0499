! SPDX-License-Identifier: BSD-3-Clause
!> Ellipsoids, cones, tori and half spaces: solids in local coordinates along their axis.
module particle_solids
   use base_kinds, only: wp
   use particle_shape, only: shape_t, transform_point
   implicit none
   private

   public :: cone, ellipsoid, half_space, solid_t, torus

   integer, parameter :: is_ellipsoid = 1, is_cone = 2, is_torus = 3, is_half_space = 4
   real(wp), parameter :: far = 1.0e30_wp            !! Bounds of a half space [m]
   real(wp), parameter :: straight(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

   !> A solid of one of these kinds.
   type, extends(shape_t) :: solid_t
      private
      integer :: kind = is_ellipsoid
      real(wp) :: centre(3) = 0.0_wp !! Centre; of a cone, middle of its axis [m]
      real(wp) :: frame(3, 3) = straight                 !! Columns are the local directions [1]
      real(wp) :: size(3) = 0.0_wp !! Lengths as the procedures below set them [m]
   contains
      procedure :: contains => solid_contains            !! True for a point inside
      procedure :: bounds => solid_bounds                !! A bounding box
      procedure :: transform => solid_transform          !! Scale, rotate and translate
   end type solid_t

contains

   !> Make an ellipsoid without its surface, its axes along the coordinates.
   pure type(solid_t) function ellipsoid(centre, semi_axes) result(shape)
      real(wp), intent(in) :: centre(3)                  !! Centre [m]
      real(wp), intent(in) :: semi_axes(3)               !! Half its axes [m]

      shape%kind = is_ellipsoid
      shape%centre = centre
      shape%size = semi_axes
   end function ellipsoid

   !> Make a cone or a truncated one, without its lateral surface and half-open along its axis.
   pure type(solid_t) function cone(centre, axis, radius, upper_radius, height) result(shape)
      real(wp), intent(in) :: centre(3)                  !! Middle of the axis [m]
      real(wp), intent(in) :: axis(3)                    !! Direction, of any length
      real(wp), intent(in) :: radius                     !! Radius at the start of the axis [m]
      real(wp), intent(in) :: upper_radius               !! Radius at the end of the axis [m]
      real(wp), intent(in) :: height                     !! Length of the axis [m]

      shape%kind = is_cone
      shape%centre = centre
      shape%frame = frame_of(axis)
      shape%size = [radius, upper_radius, height]
   end function cone

   !> Make a torus without its surface.
   pure type(solid_t) function torus(centre, axis, radius, thickness) result(shape)
      real(wp), intent(in) :: centre(3)                  !! Centre [m]
      real(wp), intent(in) :: axis(3)                    !! Direction, of any length
      real(wp), intent(in) :: radius                     !! Radius of its centre line [m]
      real(wp), intent(in) :: thickness                  !! Radius of its cross-section [m]

      shape%kind = is_torus
      shape%centre = centre
      shape%frame = frame_of(axis)
      shape%size = [radius, thickness, 0.0_wp]
   end function torus

   !> Make the half space behind a plane; the plane itself is inside.
   pure type(solid_t) function half_space(point, normal) result(shape)
      real(wp), intent(in) :: point(3)                   !! A point of the plane [m]
      real(wp), intent(in) :: normal(3)                  !! Out of the half space, of any length

      shape%kind = is_half_space
      shape%centre = point
      shape%frame = frame_of(normal)
   end function half_space

   !> Three orthogonal directions, the third one along an axis.
   pure function frame_of(axis) result(frame)
      real(wp), intent(in) :: axis(3)                    !! Axis of any length
      real(wp) :: frame(3, 3)
      integer :: least

      frame = straight
      if (.not. maxval(abs(axis)) > 0.0_wp) return
      frame(:, 3) = axis/maxval(abs(axis))
      frame(:, 3) = frame(:, 3)/norm2(frame(:, 3))
      least = minloc(abs(frame(:, 3)), 1)
      frame(:, 1) = -frame(least, 3)*frame(:, 3)
      frame(least, 1) = frame(least, 1) + 1.0_wp
      frame(:, 1) = frame(:, 1)/norm2(frame(:, 1))
      frame(:, 2) = [frame(2, 3)*frame(3, 1) - frame(3, 3)*frame(2, 1), frame(3, 3)*frame(1, 1) &
         - frame(1, 3)*frame(3, 1), frame(1, 3)*frame(2, 1) - frame(2, 3)*frame(1, 1)]
   end function frame_of

   !> True if a point is inside the solid.
   pure recursive logical function solid_contains(self, x) result(inside)
      class(solid_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                       !! Point [m]
      real(wp) :: own(3), across, share
      integer :: k

      do k = 1, 3
         own(k) = dot_product(self%frame(:, k), x - self%centre)
      end do
      across = sqrt(own(1)**2 + own(2)**2)
      select case (self%kind)
      case (is_ellipsoid)
         inside = sum((own/self%size)**2) < 1.0_wp
      case (is_cone)
         share = own(3)/self%size(3) + 0.5_wp
         inside = share >= 0.0_wp .and. share < 1.0_wp .and. across < self%size(1) &
            + share*(self%size(2) - self%size(1))
      case (is_torus)
         inside = (across - self%size(1))**2 + own(3)**2 < self%size(2)**2
      case default
         inside = own(3) <= 0.0_wp
      end select
   end function solid_contains

   !> A bounding box of the solid.
   pure recursive subroutine solid_bounds(self, lo, hi)
      class(solid_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)              !! Corners [m]
      real(wp) :: reach(3), ring(3)
      integer :: k

      ! half edges of the bounding box of a circle of radius one around the axis
      ring = sqrt(max(1.0_wp - self%frame(:, 3)**2, 0.0_wp))
      select case (self%kind)
      case (is_ellipsoid)
         reach = [(norm2(self%frame(k, :)*self%size), k=1, 3)]
      case (is_cone)
         reach = 0.5_wp*self%size(3)*abs(self%frame(:, 3)) + maxval(self%size(:2))*ring
      case (is_torus)
         reach = self%size(1)*ring + self%size(2)
      case default
         reach = far
      end select
      lo = self%centre - reach
      hi = self%centre + reach
      if (self%kind /= is_half_space) return
      do k = 1, 3
         if (self%frame(k, 3) >= 1.0_wp) hi(k) = self%centre(k)
         if (self%frame(k, 3) <= -1.0_wp) lo(k) = self%centre(k)
      end do
   end subroutine solid_bounds

   !> Scale, rotate and translate the solid.
   pure recursive subroutine solid_transform(self, scale, rotation, translate)
      class(solid_t), intent(inout) :: self
      real(wp), intent(in) :: scale                      !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)             !! Orthogonal, applied after the factor [1]
      real(wp), intent(in) :: translate(3)               !! Displacement, applied last [m]
      integer :: k

      call transform_point(scale, rotation, translate, self%centre)
      do k = 1, 3
         call transform_point(1.0_wp, rotation, [0.0_wp, 0.0_wp, 0.0_wp], self%frame(:, k))
      end do
      self%size = scale*self%size
   end subroutine solid_transform
end module particle_solids
