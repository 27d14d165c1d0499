! SPDX-License-Identifier: BSD-3-Clause
!> Keys of &output that select particles: bodies, region, stride, and a plane or an axis. Several
!! kinds of output have them.
module output_selection
   use base_constants, only: unset
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use mesh_grid, only: grid_t
   use sample_pick, only: pick_rule_t
   use scene_regions, only: named_shape_t
   implicit none
   private

   public :: declare_axis, declare_selection, declare_stride, read_axis, read_plane, read_selection

contains

   !> Declare the keys that select by body and region.
   subroutine declare_selection(schema, kind)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind of output

      if (.not. schema%extend_owner("output", "bodies", kind)) then
         call schema%text("output", "bodies(:20)", "only particles of these bodies; default: all", &
            owner="kind = "//kind)
         call schema%refer("output", "bodies", "body")
      end if
      if (.not. schema%extend_owner("output", "region", kind)) then
         call schema%text("output", "region", "only particles in this region; default: "// &
            "everywhere", owner="kind = "//kind)
         call schema%refer("output", "region", "region")
      end if
   end subroutine declare_selection

   !> Declare the key that selects every n-th particle.
   subroutine declare_stride(schema, kind)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the key
      character(len=*), intent(in) :: kind           !! Word of the kind of output

      if (.not. schema%extend_owner("output", "stride", kind)) call schema%integer("output", &
         "stride", "keeps every n-th particle, by id", default="1", range="> 0", &
         owner="kind = "//kind)
   end subroutine declare_stride

   !> Declare the key of a direction.
   subroutine declare_axis(schema, kind)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the key
      character(len=*), intent(in) :: kind           !! Word of the kind of output

      if (.not. schema%extend_owner("output", "axis", kind)) call schema%text("output", "axis", &
         "normal of a slice; direction of a profile", default="x", words="x y z", &
         owner="kind = "//kind)
   end subroutine declare_axis

   !> Read bodies and region.
   subroutine read_selection(group, deck, shapes, rule)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! For the bodies; collects errors
      type(named_shape_t), intent(in) :: shapes(:)
      type(pick_rule_t), intent(inout) :: rule       !! Gets the selection
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: region
      integer :: n, place

      call group%get("region", region)
      do n = 1, size(shapes)
         if (region == "" .or. shapes(n)%name /= region) cycle
         if (allocated(shapes(n)%points)) call deck%add_error(group, "'"//region// &
            "' is a list of points, which has no interior; name another region [D414]", "region")
         rule%region = shapes(n)%shape
      end do
      call group%list("bodies", names)
      if (size(names) == 0) return
      allocate (rule%bodies(0))
      do n = 1, size(names)
         place = deck%named("body", names(n)%text)
         if (place > 0) rule%bodies = [rule%bodies, int(place, int64)]
      end do
   end subroutine read_selection

   !> Read the number of the axis, which the scene must have.
   subroutine read_axis(group, deck, grid, axis)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      integer, intent(out) :: axis                   !! 1 to 3
      character(len=:), allocatable :: word

      call group%get("axis", word)
      axis = max(index("xyz", word(:1)), 1)
      if (.not. grid%active(axis)) call deck%add_error(group, &
         "axis = '"//word//"' is a direction that the scene does not have; use another "// &
         "one [D433]", "axis")
   end subroutine read_axis

   !> Read a plane, as the layer that is less than half a cell away from it.
   subroutine read_plane(group, deck, grid, rule)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      type(pick_rule_t), intent(inout) :: rule       !! Gets the layer
      real(wp) :: at

      call read_axis(group, deck, grid, rule%axis)
      call group%get("at", at)
      if (at <= unset) return
      rule%lower = at - 0.5_wp*grid%spacing
      rule%upper = at + 0.5_wp*grid%spacing
      if (at < grid%lower(rule%axis) .or. at > grid%upper(rule%axis)) call deck%add_error(group, &
         "the plane lies outside of the grid, from "//deck%shown(grid%lower(rule%axis), "m")// &
         " to "//deck%shown(grid%upper(rule%axis), "m")//" [D432]", "at")
   end subroutine read_plane
end module output_selection
