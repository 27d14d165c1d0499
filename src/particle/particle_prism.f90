! SPDX-License-Identifier: BSD-3-Clause
!> Prisms, which are polygons extruded along an axis.
module particle_prism
   use base_kinds, only: wp
   use particle_framed, only: framed_t
   implicit none
   private

   public :: crossing_edges, polygon_area, prism, prism_t

   !> A prism. Its sides and ends are half-open, so adjacent prisms have no common point.
   type, extends(framed_t) :: prism_t
      integer :: axis = 3                                !! Direction of extrusion
      real(wp), allocatable, private :: corner(:, :)     !! (2, corner) Polygon, in order [m]
      real(wp), private :: span(2) = 0.0_wp              !! Lower and upper end [m]
   contains
      procedure :: holds => prism_holds                  !! Is a point in local coordinates inside?
      procedure :: own_bounds => prism_own_bounds        !! A bounding box in local coordinates
   end type prism_t

contains

   !> Extrude a polygon. Its coordinates are those other than the axis, in order.
   pure type(prism_t) function prism(corner, axis, span) result(shape)
      real(wp), intent(in) :: corner(:, :)               !! (2, corner) In either orientation [m]
      integer, intent(in) :: axis                        !! 1 to 3
      real(wp), intent(in) :: span(2)                    !! Lower and upper end [m]

      allocate (shape%corner(2, size(corner, 2)))
      shape%corner(:, :) = corner
      shape%axis = axis
      shape%span = span
   end function prism

   !> True if a point in local coordinates is inside: a ray from it along the first coordinate
   !! crosses the polygon an odd number of times. The crossing of an edge is computed from its lower
   !! end in either orientation, so that adjacent prisms get the same result.
   pure logical function prism_holds(self, own) result(inside)
      class(prism_t), intent(in) :: self
      real(wp), intent(in) :: own(3)                     !! Local coordinates [m]
      real(wp) :: place(2), low(2), high(2), swap(2)
      integer :: from, to

      inside = .false.
      if (.not. (own(self%axis) >= self%span(1) .and. own(self%axis) < self%span(2))) return
      place = pack(own, [1, 2, 3] /= self%axis)
      from = size(self%corner, 2)
      do to = 1, size(self%corner, 2)
         low = self%corner(:, from)
         high = self%corner(:, to)
         from = to
         if ((low(2) <= place(2)) .eqv. (high(2) <= place(2))) cycle
         if (low(2) > high(2)) then
            swap = low
            low = high
            high = swap
         end if
         if (place(1) < low(1) + (high(1) - low(1))*((place(2) - low(2))/(high(2) - low(2)))) &
            inside = .not. inside
      end do
   end function prism_holds

   !> A bounding box of the prism.
   pure subroutine prism_own_bounds(self, lo, hi)
      class(prism_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)              !! Corners [m]
      integer :: k, row

      row = 0
      do k = 1, 3
         if (k == self%axis) then
            lo(k) = self%span(1)
            hi(k) = self%span(2)
         else
            row = row + 1
            lo(k) = minval(self%corner(row, :))
            hi(k) = maxval(self%corner(row, :))
         end if
      end do
   end subroutine prism_own_bounds

   !> Area of a polygon in either orientation [m2].
   pure real(wp) function polygon_area(corner) result(area)
      real(wp), intent(in) :: corner(:, :)               !! (2, corner) [m]
      real(wp) :: a(2), b(2)
      integer :: n

      area = 0.0_wp
      do n = 2, size(corner, 2) - 1
         a = corner(:, n) - corner(:, 1)
         b = corner(:, n + 1) - corner(:, 1)
         area = area + 0.5_wp*(a(1)*b(2) - a(2)*b(1))
      end do
      area = abs(area)
   end function polygon_area

   !> First two edges of a polygon that cross or touch elsewhere than at a common corner, else 0.
   !! Edge n begins at corner n.
   pure function crossing_edges(corner) result(pair)
      real(wp), contiguous, intent(in) :: corner(:, :)   !! (2, corner) [m]
      integer :: pair(2)
      integer :: first, second, corners

      corners = size(corner, 2)
      do first = 1, corners - 1
         do second = first + 1, corners
            pair = [first, second]
            if (second == first + 1 .or. (first == 1 .and. second == corners)) cycle
            if (cross(corner(:, first), corner(:, 1 + mod(first, corners)), corner(:, second), &
               corner(:, 1 + mod(second, corners)))) return
         end do
      end do
      pair = 0
   end function crossing_edges

   !> True if two line segments have a common point.
   pure logical function cross(a, b, c, d) result(meet)
      real(wp), intent(in) :: a(2), b(2)                 !! Ends of the first [m]
      real(wp), intent(in) :: c(2), d(2)                 !! Ends of the second [m]
      real(wp) :: sides(4)

      sides = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)]
      meet = sides(1)*sides(2) <= 0.0_wp .and. sides(3)*sides(4) <= 0.0_wp .and. &
         all(max(min(a, b), min(c, d)) <= min(max(a, b), max(c, d)))
   end function cross

   !> Orientation of three points: 1 counterclockwise, -1 clockwise, 0 on a line.
   pure real(wp) function turn(a, b, c) result(way)
      real(wp), intent(in) :: a(2), b(2), c(2)           !! The points [m]

      way = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
      if (abs(way) > 0.0_wp) way = sign(1.0_wp, way)
   end function turn
end module particle_prism
