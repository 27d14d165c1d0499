! SPDX-License-Identifier: BSD-3-Clause
!> The functions of a shape that boundaries and rigid regions use.
module mesh_point_set
   use base_kinds, only: wp
   implicit none
   private

   public :: point_set_t

   !> A set of points.
   type, abstract :: point_set_t
   contains
      procedure(contains_i), deferred :: contains    !! True if a point is inside
      procedure(bounds_i), deferred :: bounds        !! Bounding box
   end type point_set_t

   abstract interface
      pure recursive logical function contains_i(self, x) result(inside)
         import :: point_set_t, wp
         implicit none
         class(point_set_t), intent(in) :: self
         real(wp), intent(in) :: x(3)                !! Point [m]
      end function contains_i

      pure recursive subroutine bounds_i(self, lo, hi)
         import :: point_set_t, wp
         implicit none
         class(point_set_t), intent(in) :: self
         real(wp), intent(out) :: lo(3), hi(3)       !! Corners [m]; lo > hi if it is surely empty
      end subroutine bounds_i
   end interface
end module mesh_point_set
