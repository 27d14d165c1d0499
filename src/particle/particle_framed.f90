! SPDX-License-Identifier: BSD-3-Clause
!> Shapes in a local frame, which is scaled, rotated and translated as a whole.
!!
!! Points are tested in local coordinates only. So two adjacent shapes in the same frame have no
!! common point, wherever the frame is.
module particle_framed
   use base_kinds, only: wp
   use particle_shape, only: shape_t, transform_point
   implicit none
   private

   public :: framed_t

   real(wp), parameter :: straight(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

   !> A shape in a frame.
   type, abstract, extends(shape_t) :: framed_t
      real(wp), private :: factor = 1.0_wp               !! Scale of local lengths [1]
      real(wp), private :: origin(3) = 0.0_wp            !! Origin of local coordinates [m]
      real(wp), private :: frame(3, 3) = straight        !! Columns are the local directions [1]
   contains
      procedure :: contains => framed_contains           !! True for a point inside
      procedure :: bounds => framed_bounds               !! A bounding box
      procedure :: transform => framed_transform         !! Scale, rotate and translate
      procedure :: growth => framed_growth               !! Scale of local lengths
      procedure :: own_place => framed_own_place         !! Local coordinates of a point
      procedure(holds_i), deferred :: holds              !! Is a point in local coordinates inside?
      procedure(own_bounds_i), deferred :: own_bounds    !! A bounding box in local coordinates
   end type framed_t

   abstract interface
      pure logical function holds_i(self, own) result(inside)
         import :: framed_t, wp
         implicit none
         class(framed_t), intent(in) :: self
         real(wp), intent(in) :: own(3)                  !! Local coordinates [m]
      end function holds_i

      pure subroutine own_bounds_i(self, lo, hi)
         import :: framed_t, wp
         implicit none
         class(framed_t), intent(in) :: self
         real(wp), intent(out) :: lo(3), hi(3)           !! Corners [m]; lo > hi if it is empty
      end subroutine own_bounds_i
   end interface

contains

   !> True if a point is inside the shape.
   pure recursive logical function framed_contains(self, x) result(inside)
      class(framed_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                       !! Point [m]

      inside = self%holds(self%own_place(x))
   end function framed_contains

   !> Local coordinates of a point.
   pure function framed_own_place(self, x) result(own)
      class(framed_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                       !! Point [m]
      real(wp) :: own(3)                                 !! [m]
      real(wp) :: offset(3)
      integer :: k

      offset = x - self%origin
      do k = 1, 3
         own(k) = dot_product(self%frame(:, k), offset)/self%factor
      end do
   end function framed_own_place

   !> A bounding box, the smallest if the frame is aligned with the coordinates.
   pure recursive subroutine framed_bounds(self, lo, hi)
      class(framed_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)              !! Corners [m]
      real(wp) :: own_lo(3), own_hi(3), corner(3)
      integer :: number, k

      call self%own_bounds(own_lo, own_hi)
      lo = own_lo
      hi = own_hi
      if (any(own_lo > own_hi)) return
      do number = 0, 7
         do k = 1, 3
            corner(k) = merge(own_hi(k), own_lo(k), btest(number, k - 1))
         end do
         call transform_point(self%factor, self%frame, self%origin, corner)
         if (number == 0) then
            lo = corner
            hi = corner
         end if
         lo = min(lo, corner)
         hi = max(hi, corner)
      end do
   end subroutine framed_bounds

   !> Scale, rotate and translate the frame.
   pure recursive subroutine framed_transform(self, scale, rotation, translate)
      class(framed_t), intent(inout) :: self
      real(wp), intent(in) :: scale                      !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)             !! Orthogonal, applied after the factor [1]
      real(wp), intent(in) :: translate(3)               !! Displacement, applied last [m]
      integer :: k

      call transform_point(scale, rotation, translate, self%origin)
      do k = 1, 3
         call transform_point(1.0_wp, rotation, [0.0_wp, 0.0_wp, 0.0_wp], self%frame(:, k))
      end do
      self%factor = scale*self%factor
   end subroutine framed_transform

   !> Scale of local lengths.
   pure real(wp) function framed_growth(self) result(factor)
      class(framed_t), intent(in) :: self

      factor = self%factor
   end function framed_growth
end module particle_framed
