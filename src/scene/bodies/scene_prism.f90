! SPDX-License-Identifier: BSD-3-Clause
!> Regions that are prisms: a polygon of the deck, extruded normal to its plane.
module scene_prism
   use base_kinds, only: wp
   use base_text, only: number
   use deck_reader, only: deck_t, group_t
   use mesh_grid, only: grid_t
   use particle_prism, only: crossing_edges, polygon_area, prism
   use particle_shape, only: shape_holder_t
   implicit none
   private

   public :: build_prism

contains

   !> A prism. In a plane scene it is unbounded along y.
   subroutine build_prism(deck, grid, group, holder)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      type(shape_holder_t), intent(inout) :: holder  !! Receives the shape
      real(wp), allocatable :: corner(:, :)
      real(wp) :: span(2)
      integer :: axis
      real(wp), parameter :: far = 1.0e6_wp  ! extents of the box

      call find_axis(deck, grid, group, axis)
      ! extent along the axis
      span = [-far, far]*maxval(grid%upper - grid%lower)
      if (grid%dimensions < 3) then
         if (group%given("span")) call deck%add_error(group, "in a plane scene a prism is "// &
            "unbounded across the plane; remove span [D357]", "span")
      else if (.not. group%given("span")) then
         call deck%add_error(group, "in 3-D a prism needs span, its start and end along the "// &
            "axis [D357]", "span")
      else
         call group%get("span", span)
         if (.not. span(2) > span(1)) call deck%add_error(group, "the end of span must be "// &
            "above its start [D357]", "span")
      end if
      call find_corners(deck, group, corner)
      if (deck%sound("region", group%place)) call holder%set(prism(corner, axis, span))
   end subroutine build_prism

   !> Direction of the axis.
   subroutine find_axis(deck, grid, group, axis)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      integer, intent(out) :: axis                   !! 1 to 3
      real(wp) :: direction(3)

      call group%get("axis", direction)
      axis = maxloc(abs(direction), 1)
      if (count(abs(direction) > 0.0_wp) /= 1) call deck%add_error(group, "the axis of a "// &
         "prism must be a coordinate axis, such as 0 1 0; rotate it with rotate [D357]", "axis")
      if (grid%dimensions == 3) return
      if (grid%dimensions == 1) call deck%add_error(group, "a 1-D scene has no plane for a "// &
         "polygon; use a box [D357]", "shape")
      if (group%given("axis") .and. axis /= 2) call deck%add_error(group, "in a plane scene "// &
         "the axis of a prism is y, across the plane; remove axis [D357]", "axis")
      axis = 2
   end subroutine find_axis

   !> Corners of the polygon; a last one that repeats the first is left out.
   subroutine find_corners(deck, group, corner)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      real(wp), allocatable, intent(out) :: corner(:, :) !! (2, corner) [m]
      real(wp), allocatable :: values(:)
      integer :: corners, pair(2), n

      call group%list("polygon", values)
      corners = size(values)/2
      if (corners > 1) then
         if (all(abs(values(:2) - values(2*corners - 1:2*corners)) <= 0.0_wp)) corners = corners - 1
      end if
      allocate (corner(2, corners))
      do n = 1, corners
         corner(1, n) = values(2*n - 1)
         corner(2, n) = values(2*n)
      end do
      if (mod(size(values), 2) /= 0) then
         call deck%add_error(group, "polygon has "//number(size(values))//" numbers, but each "// &
            "corner needs two [D357]", "polygon")
         return
      end if
      if (corners < 3) then
         call deck%add_error(group, "a polygon needs at least three corners [D357]", "polygon")
         return
      end if
      pair = crossing_edges(corner)
      if (pair(1) > 0) then
         call deck%add_error(group, "the edges of the polygon after corners "//number(pair(1))// &
            " and "//number(pair(2))//" cross or touch; list the corners in order [D421]", &
            "polygon")
      else if (.not. polygon_area(corner) > 0.0_wp) then
         call deck%add_error(group, "the polygon has no area [D357]", "polygon")
      end if
   end subroutine find_corners
end module scene_prism
