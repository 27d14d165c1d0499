! SPDX-License-Identifier: BSD-3-Clause
!> Boundaries of the domain and rigid regions of a deck: whole boundaries first, which the grid
!! needs,
!! then parts of them, rigid regions, and walls that move by a table or act for a time.
module scene_walls
   use base_communicator, only: communicator_t
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use io_motion, only: of_velocities
   use mesh_boundary, only: boundary_t, face_names
   use mesh_boundary_catalogue, only: choose_boundary
   use mesh_boundary_condition, only: normal_direction
   use mesh_motion, only: motion_t
   use mesh_rigid, only: rigid_t
   use mesh_wall, only: wall_t
   use scene_motion_table, only: read_motion_table
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: read_boundaries, read_walls

contains

   !> Read the whole boundaries, and set the directions of the grid that are periodic or have walls.
   subroutine read_boundaries(deck, simulation)
      type(deck_t), intent(in) :: deck
      type(simulation_t), intent(inout) :: simulation
      integer :: face, k

      associate (boundary => simulation%space%boundary, grid => simulation%space%grid)
         do face = 1, 6
            call read_boundary(deck, face, grid%axisymmetric .and. face == 1, boundary)
         end do
         grid%wall = [(boundary%acts_on(face), face=1, 6)]
         do k = 1, 3
            grid%periodic(k) = boundary%is_periodic(2*k - 1) .and. boundary%is_periodic(2*k)
         end do
      end associate
   end subroutine read_boundaries

   !> Read one whole boundary; open without a &boundary.
   subroutine read_boundary(deck, face, is_axis, boundary)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: face                    !! 1 to 6
      logical, intent(in) :: is_axis                 !! The axis of symmetry mirrors
      type(boundary_t), intent(inout) :: boundary    !! Gets the condition
      character(len=:), allocatable :: kind
      type(group_t) :: group
      integer :: index, n

      if (is_axis) call boundary%impose("symmetry", [face])
      index = group_of(deck, face)
      if (index == 0) return
      group = deck%group("boundary", index)
      boundary%warm(face) = group%given("temperature")
      if (boundary%warm(face)) call group%get("temperature", boundary%temperature(face))
      if (is_axis) return
      call group%get("type", kind)
      call boundary%impose(kind, [face])
      n = boundary%whole(face)
      associate (wall => boundary%wall(n))
         call wall%condition%read(group)
         call group%get("velocity", wall%motion%steady)
         wall%condition%velocity = wall%motion%steady
      end associate
   end subroutine read_boundary

   !> Index of the &boundary of a whole boundary, 0 = none: one that names it, or else one for all.
   integer function group_of(deck, face) result(found)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: face                    !! 1 to 6
      character(len=:), allocatable :: name
      type(group_t) :: group
      integer :: index

      found = 0
      do index = 1, deck%count("boundary")
         group = deck%group("boundary", index)
         if (group%given("region")) cycle
         call group%get("face", name)
         if (name == face_names(face)) then
            found = index
            return
         end if
         if (name == "all") found = index
      end do
   end function group_of

   !> Read parts of boundaries, rigid regions, tables and times. Collective.
   subroutine read_walls(deck, simulation, shapes)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! Grid and whole boundaries are read
      type(named_shape_t), intent(in) :: shapes(:)
      type(rigid_t) :: rigid
      type(wall_t) :: wall
      type(group_t) :: group
      logical :: switched
      integer :: index

      allocate (rigid%wall(0))
      do index = 1, deck%count("boundary")
         group = deck%group("boundary", index)
         if (.not. (group%given("region") .or. group%given("table") .or. group%given("t_on") &
            .or. group%given("t_off"))) cycle
         call read_wall(deck, simulation, shapes, group, wall)
         if (group%given("region")) then
            call add_region(group, wall, simulation, rigid)
         else
            call set_motion(deck, index, wall%motion, simulation)
         end if
      end do
      if (allocated(simulation%space%boundary%wall)) &
         call simulation%space%boundary%advance(0.0_wp, 0.0_wp, 0.0_wp, switched)
      if (size(rigid%wall) == 0) return
      allocate (simulation%space%rigid)
      call move_alloc(rigid%wall, simulation%space%rigid%wall)
   end subroutine read_walls

   !> What a &boundary does, how it moves, and its region.
   subroutine read_wall(deck, simulation, shapes, group, wall)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(in) :: simulation
      type(named_shape_t), intent(in) :: shapes(:)
      type(group_t), intent(in) :: group             !! The &boundary
      type(wall_t), intent(out) :: wall              !! Its boundary is not set
      character(len=:), allocatable :: kind, region
      integer :: index

      call group%get("type", kind)
      call choose_boundary(kind, wall%condition)
      call wall%condition%read(group)
      call read_times(deck, simulation%machine%communicator, group, wall%motion)
      where (.not. simulation%space%grid%active) wall%motion%steady = 0.0_wp
      if (allocated(wall%motion%speed)) then
         do index = 1, 3
            if (.not. simulation%space%grid%active(index)) wall%motion%speed(index, :) = 0.0_wp
         end do
      end if
      call group%get("region", region)
      wall%name = region
      do index = 1, size(shapes)
         if (shapes(index)%name /= region .or. .not. allocated(shapes(index)%shape%shape)) cycle
         if (allocated(shapes(index)%points)) call deck%complain(group, "'"//region// &
            "' is a list of points, which has no inside; name another region", "region")
         allocate (wall%region, source=shapes(index)%shape%shape)
      end do
   end subroutine read_wall

   !> Add a wall with a region: a rigid region, or parts of boundaries.
   subroutine add_region(group, wall, simulation, rigid)
      type(group_t), intent(in) :: group             !! The &boundary
      type(wall_t), intent(inout) :: wall            !! Its boundary is set
      type(simulation_t), intent(inout) :: simulation
      type(rigid_t), intent(inout) :: rigid          !! Rigid regions
      character(len=:), allocatable :: name
      integer :: face

      ! a region with an error has been reported
      if (.not. allocated(wall%region)) return
      call group%get("face", name)
      if (name == "") call rigid%add(wall)
      do face = 1, 6
         if (name /= face_names(face) .and. name /= "all") cycle
         if (.not. simulation%space%grid%active(normal_direction(face))) cycle
         wall%face = face
         call simulation%space%boundary%insert(wall)
         if (wall%condition%acts_on_nodes()) simulation%space%grid%wall(face) = .true.
      end do
   end subroutine add_region

   !> Set how whole boundaries move, and when they act.
   subroutine set_motion(deck, index, motion, simulation)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: index                   !! Number of the &boundary
      type(motion_t), intent(in) :: motion           !! Its motion
      type(simulation_t), intent(inout) :: simulation
      integer :: face

      associate (boundary => simulation%space%boundary, grid => simulation%space%grid)
         do face = 1, 6
            if (.not. grid%active(normal_direction(face)) .or. group_of(deck, face) /= index) cycle
            if (face == 1 .and. grid%axisymmetric) cycle
            boundary%wall(boundary%whole(face))%motion = motion
         end do
      end associate
   end subroutine set_motion

   !> How a wall moves, and from when to when it acts. Collective.
   subroutine read_times(deck, communicator, group, motion)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      type(group_t), intent(in) :: group             !! The &boundary
      type(motion_t), intent(inout) :: motion        !! Gets them

      call group%get("velocity", motion%steady)
      call group%get("t_on", motion%begin)
      if (group%given("t_off")) call group%get("t_off", motion%end)
      if (.not. group%given("table")) return
      call read_motion_table(deck, communicator, group, "table", of_velocities, "m/s", motion)
   end subroutine read_times
end module scene_walls
