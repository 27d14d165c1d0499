! SPDX-License-Identifier: BSD-3-Clause
!> The group &boundary: its keys, their checks, and the boundaries of the domain, parts of them and
!! rigid regions that follow from it. The grid needs the whole boundaries, so these are read first.
module scene_boundary
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_physics, schema_t
   use io_motion, only: of_velocities
   use mesh_boundary_walls, only: face_names
   use mesh_boundary_catalogue, only: boundary_names, choose_boundary
   use mesh_boundary_condition, only: boundary_condition_t, normal_direction
   use mesh_rigid, only: rigid_t
   use mesh_wall, only: wall_t
   use scene_dimension, only: check_plane
   use scene_motion_table, only: read_motion_table
   use scene_regions, only: named_shape_t
   use scene_rigid_body, only: check_rigid_body, declare_rigid_body, read_rigid_body
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_boundaries, declare_boundary, read_boundaries, read_walls

contains

   !> Declare &boundary.
   subroutine declare_boundary(schema)
      type(schema_t), intent(inout) :: schema
      class(boundary_condition_t), allocatable :: condition
      character(len=:), allocatable :: meanings, walls
      integer :: n

      call schema%group("boundary", "condition at a boundary of the grid, at a part of it, "// &
         "or in a rigid region; boundaries without a condition are outflow", many=.true.)
      call schema%text("boundary", "face", &
         "a boundary of the grid; all: every one without its own &boundary", words="all")
      call schema%words("boundary", "face", face_names)
      call schema%text("boundary", "region", "without face: a rigid body with this condition "// &
         "at its nodes; with face: the part of the boundary in this region")
      meanings = ""
      walls = ""
      do n = 1, size(boundary_names)
         call choose_boundary(boundary_names(n), condition)
         meanings = meanings//"; "//trim(boundary_names(n))//": "//condition%meaning()
         if (condition%suits_region()) walls = walls//" "//trim(boundary_names(n))
      end do
      call schema%text("boundary", "type", meanings(3:))
      call schema%words("boundary", "type", boundary_names)
      call schema%real("boundary", "velocity(3)", &
         "velocity of the wall; at a face only with type = velocity", unit="m/s", default="0 0 0", &
         owner="type ="//walls)
      call schema%text("boundary", "table", "file with lines t, vx, vy, vz in the units of the "// &
         "deck, interpolated linearly and added to velocity; path relative to the deck", &
         owner="type ="//walls)
      do n = 1, size(boundary_names)
         call choose_boundary(boundary_names(n), condition)
         call condition%declare(schema)
      end do
      call declare_rigid_body(schema, "type ="//walls)
      call schema%real("boundary", "t_on", &
         "time from which the wall acts, and from which a region moves", unit="s", default="0.0", &
         range=">= 0", owner="type ="//walls)
      call schema%real("boundary", "t_off", &
         "time until which the wall acts; a face is outflow afterwards", unit="s", range="> 0", &
         owner="type ="//walls)
      call schema%real("boundary", "temperature", "fixed temperature of a whole face, for heat "// &
         "conduction; without it the face is insulated", unit="K", range=">= 0", &
         owner="effects.thermal")
      call schema%require("boundary", "type")
      call schema%refer("boundary", "region", "region")
      call schema%allow_change("boundary", "* + -", changes_physics)
      call schema%forbid_change("boundary", "region type velocity table t_on", "the position "// &
         "of a rigid region follows from its motion since the start", without="face")
   end subroutine declare_boundary

   !> All boundaries.
   subroutine check_boundaries(deck)
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: face, kind
      class(boundary_condition_t), allocatable :: condition
      integer :: owner(6), every, i, k
      logical :: periodic(6), joins
      type(group_t) :: boundary

      owner = 0
      every = 0
      periodic = .false.
      do i = 1, deck%count("boundary")
         boundary = deck%group("boundary", i)
         call boundary%get("face", face)
         call boundary%get("type", kind)
         call choose_boundary(kind, condition)
         call check_plane(deck, boundary, "velocity")
         call check_rigid_body(deck, boundary)
         call check_wall(deck, boundary, condition)
         joins = .false.
         if (allocated(condition)) joins = condition%joins_opposite()
         if (face == "all" .and. .not. boundary%given("region")) then
            if (every > 0) call deck%add_error(boundary, "face = 'all' is given twice [D114]", &
               "face")
            every = i
            if (joins) where (owner == 0) periodic = .true.
         end if
         do k = 1, 6
            if (face_names(k) /= face) cycle
            if (.not. boundary%given("region")) then
               if (owner(k) > 0) call deck%add_error(boundary, "face = '"//face// &
                  "' is given twice [D114]", "face")
               owner(k) = i
               periodic(k) = joins
            end if
            call check_face(deck, boundary, k, condition)
         end do
      end do
      do i = 1, deck%count("boundary")
         boundary = deck%group("boundary", i)
         if (boundary%given("region")) cycle
         call boundary%get("face", face)
         call check_pair(deck, boundary, face, periodic)
      end do
   end subroutine check_boundaries

   !> Check required and contradictory keys of a wall.
   subroutine check_wall(deck, boundary, condition)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary
      class(boundary_condition_t), allocatable, intent(in) :: condition !! Its type, if it is known
      real(wp) :: begin, end, velocity(3)
      character(len=:), allocatable :: fitting
      logical :: part, suits

      if (.not. (boundary%given("face") .or. boundary%given("region"))) call deck%add_error( &
         boundary, "face or region must be given (a face of the grid, or a rigid region) [D326]")
      ! the type must allow region, motion and temperature
      if (allocated(condition)) then
         part = boundary%given("face")
         suits = condition%suits_region()
         if (part) suits = condition%suits_part()
         fitting = fitting_types(part)
         if (boundary%given("region") .and. .not. suits) call deck%add_error(boundary, &
            "a region cannot be type = '"//trim(condition%name)//"'; use "//fitting//" [D328]", &
            "type")
         if (part .and. .not. condition%moves()) then
            ! an echo of the deck contains the default, a velocity of zero
            velocity = 0.0_wp
            if (boundary%given("velocity")) call boundary%get("velocity", velocity)
            if (any(abs(velocity) > 0.0_wp)) call deck%add_error(boundary, &
               "a face moves only with "// &
               "type = 'velocity'; remove velocity, or use a region [D329]", "velocity")
            if (boundary%given("table")) call deck%add_error(boundary, "a face moves only with "// &
               "type = 'velocity'; remove table, or use a region [D329]", "table")
         end if
         if (boundary%given("temperature") .and. condition%joins_opposite() .and. &
            .not. boundary%given("region")) call refuse_temperature(deck, boundary)
      end if
      if (boundary%given("temperature") .and. boundary%given("region")) call &
         refuse_temperature(deck, boundary)
      if (boundary%known("t_off") .and. boundary%known("t_on")) then
         call boundary%get("t_on", begin)
         call boundary%get("t_off", end)
         if (.not. end > begin) call deck%add_error(boundary, "t_off must be after t_on [D331]", &
            "t_off")
      end if
   end subroutine check_wall

   !> Only whole boundaries that are not periodic have a temperature.
   subroutine refuse_temperature(deck, boundary)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary

      call deck%add_error(boundary, "temperature is allowed only for a whole face that is not "// &
         "periodic; remove it [D330]", "temperature")
   end subroutine refuse_temperature

   !> The types allowed for a part of a boundary, or for a rigid region, for a message.
   function fitting_types(part) result(text)
      logical, intent(in) :: part                        !! A part of a boundary?
      character(len=:), allocatable :: text, last
      class(boundary_condition_t), allocatable :: condition
      logical :: suits
      integer :: n

      text = ""
      last = ""
      do n = 1, size(boundary_names)
         call choose_boundary(boundary_names(n), condition)
         suits = condition%suits_region()
         if (part) suits = condition%suits_part()
         if (.not. suits) cycle
         if (text /= "") text = text//", "
         text = text//last
         last = trim(boundary_names(n))
      end do
      text = text//" or "//last
   end function fitting_types

   !> A boundary must exist in the scene; the axis of symmetry is a mirror plane.
   subroutine check_face(deck, boundary, face, condition)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary
      integer, intent(in) :: face                        !! 1 to 6
      class(boundary_condition_t), allocatable, intent(in) :: condition !! Its type, if it is known
      character(len=:), allocatable :: dimension
      type(group_t) :: run
      integer :: direction

      run = deck%group("run")
      call run%get("dimension", dimension)
      direction = (face + 1)/2
      if (dimension == "") return
      if (allocated(condition)) then
         ! material in plane strain is between mirrors and does not move along y
         if (direction == 2 .and. dimension == "plane_strain" .and. condition%slides() .and. &
            condition%keeps() .and. .not. (boundary%given("region") .or. &
            boundary%given("temperature") .or. boundary%given("t_on") .or. &
            boundary%given("t_off"))) return
      end if
      if (direction == 2 .and. dimension /= "3d" .or. direction == 3 .and. dimension == "1d") then
         call deck%add_error(boundary, "dimension = '"//dimension//"' has no face "// &
            face_names(face)//" [D325]", "face")
         return
      end if
      if (direction /= 1 .or. dimension /= "axisymmetric" .or. .not. allocated(condition)) return
      if (condition%joins_opposite()) then
         call deck%add_error(boundary, "the radius cannot be periodic [D323]", "type")
      else if (face == 1 .and. .not. condition%mirrors()) then
         call deck%add_error(boundary, "the axis of an axisymmetric scene must be type = "// &
            "'symmetry' [D324]", &
            "type")
      end if
   end subroutine check_face

   !> A periodic boundary needs the opposite one.
   subroutine check_pair(deck, boundary, face, periodic)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary
      character(len=*), intent(in) :: face               !! Face of the boundary
      logical, intent(in) :: periodic(6)                 !! (face) Is it periodic?
      integer :: k, partner

      do k = 1, 6
         partner = k - 1 + 2*mod(k, 2)
         if (face_names(k) /= face .or. .not. periodic(k) .or. periodic(partner)) cycle
         call deck%add_error(boundary, "periodic needs both faces; make "//face_names(partner)// &
            " periodic too [D322]", "type")
      end do
   end subroutine check_pair

   !> Read the whole boundaries, and set the directions of the grid that are periodic or have walls.
   subroutine read_boundaries(deck, simulation)
      type(deck_t), intent(in) :: deck
      type(simulation_t), intent(inout) :: simulation
      integer :: face, k, index, n
      logical :: is_axis
      character(len=:), allocatable :: kind
      type(group_t) :: group

      associate (boundary => simulation%space%boundary, grid => simulation%space%grid)
         do face = 1, 6
            ! a boundary without a &boundary is open; the axis of symmetry mirrors
            is_axis = grid%axisymmetric .and. face == 1
            if (is_axis) call boundary%impose("symmetry", [face])
            index = group_of(deck, face)
            if (index == 0) cycle
            group = deck%group("boundary", index)
            boundary%warm(face) = group%given("temperature")
            if (boundary%warm(face)) call group%get("temperature", boundary%temperature(face))
            if (is_axis) cycle
            call group%get("type", kind)
            call boundary%impose(kind, [face])
            n = boundary%whole(face)
            associate (wall => boundary%wall(n))
               call wall%condition%read(group)
               call group%get("velocity", wall%motion%steady)
               wall%condition%velocity = wall%motion%steady
            end associate
         end do
         grid%wall = [(boundary%acts_on(face), face=1, 6)]
         do k = 1, 3
            grid%periodic(k) = boundary%is_periodic(2*k - 1) .and. boundary%is_periodic(2*k)
         end do
      end associate
   end subroutine read_boundaries

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
      integer :: index, face
      character(len=:), allocatable :: name

      allocate (rigid%wall(0))
      do index = 1, deck%count("boundary")
         group = deck%group("boundary", index)
         if (.not. (group%given("region") .or. group%given("table") .or. group%given("t_on") &
            .or. group%given("t_off"))) cycle
         call read_wall(deck, simulation, shapes, group, wall)
         if (group%given("region")) then
            ! a rigid region, or parts of boundaries; a region with an error has been reported
            if (.not. allocated(wall%region)) cycle
            call group%get("face", name)
            if (name == "") call rigid%add(wall)
            do face = 1, 6
               if (name /= face_names(face) .and. name /= "all") cycle
               if (.not. simulation%space%grid%active(normal_direction(face))) cycle
               wall%face = face
               call simulation%space%boundary%insert(wall)
               if (wall%condition%acts_on_nodes()) simulation%space%grid%wall(face) = .true.
            end do
         else
            ! motion of whole boundaries
            associate (boundary => simulation%space%boundary, grid => simulation%space%grid)
               do face = 1, 6
                  if (.not. grid%active(normal_direction(face))) cycle
                  if (group_of(deck, face) /= index) cycle
                  if (face == 1 .and. grid%axisymmetric) cycle
                  boundary%wall(boundary%whole(face))%motion = wall%motion
               end do
            end associate
         end if
      end do
      if (allocated(simulation%space%boundary%wall)) &
         call simulation%space%boundary%advance(0.0_wp, 0.0_wp, 0.0_wp, switched)
      if (size(rigid%wall) == 0) return
      allocate (simulation%space%rigid)
      call move_alloc(rigid%wall, simulation%space%rigid%wall)
   end subroutine read_walls

   !> Condition, motion and region of a &boundary.
   subroutine read_wall(deck, simulation, shapes, group, wall)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(in) :: simulation
      type(named_shape_t), intent(in) :: shapes(:)
      type(group_t), intent(in) :: group             !! The &boundary
      type(wall_t), intent(out) :: wall              !! The wall; its boundary is not set
      character(len=:), allocatable :: kind, region
      integer :: index

      call group%get("type", kind)
      call choose_boundary(kind, wall%condition)
      call wall%condition%read(group)
      ! its motion, and the time interval in which it acts
      call group%get("velocity", wall%motion%steady)
      call group%get("t_on", wall%motion%begin)
      if (group%given("t_off")) call group%get("t_off", wall%motion%end)
      if (group%given("table")) call read_motion_table(deck, simulation%machine%communicator, &
         group, "table", of_velocities, "m/s", wall%motion)
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
         if (allocated(shapes(index)%points)) call deck%add_error(group, "'"//region// &
            "' is a list of points, which has no interior; name another region [D414]", "region")
         allocate (wall%region, source=shapes(index)%shape%shape)
      end do
      if (allocated(wall%region) .and. .not. group%given("face")) call read_rigid_body(deck, &
         simulation%space%grid, group, wall)
   end subroutine read_wall
end module scene_boundary
