! SPDX-License-Identifier: BSD-3-Clause
!> Walls that a deck describes with more than a face and a type: rigid regions, parts of faces, and
!! what moves by a table or comes and goes.
module scene_walls
   use base_communicator, only: communicator_t
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use base_text, only: text_t
   use io_motion, only: of_velocities
   use mesh_boundary, only: face_names, face_outflow, face_types
   use mesh_motion, only: motion_t
   use mesh_wall, only: wall_t
   use scene_motion_table, only: read_motion_table
   use scene_shapes, only: named_shape_t
   use step_method, only: position_of
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: read_walls

contains

   !> Read them; plain faces are read before.
   subroutine read_walls(deck, simulation, shapes)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! The run, its grid and plain faces are read
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      type(wall_t), allocatable :: bodies(:), faces(:)
      type(group_t) :: group
      logical :: switched
      integer :: index

      allocate (bodies(0), faces(0))
      do index = 1, deck%count("boundary")
         group = deck%group("boundary", index)
         call read_wall(deck, simulation, shapes, group, bodies, faces)
      end do
      if (size(faces) > 0) then
         call move_alloc(faces, simulation%space%boundary%wall)
         associate (boundary => simulation%space%boundary)
            do index = 1, size(boundary%wall)
               associate (wall => boundary%wall(index))
                  if (.not. allocated(wall%region)) cycle
                  boundary%divided(wall%face) = .true.
                  if (wall%kind /= face_outflow) simulation%space%grid%wall(wall%face) = .true.
               end associate
            end do
            call boundary%advance(0.0_wp, 0.0_wp, 0.0_wp, switched)
         end associate
      end if
      if (size(bodies) == 0) return
      allocate (simulation%space%rigid)
      call move_alloc(bodies, simulation%space%rigid%wall)
   end subroutine read_walls

   !> One &boundary: a rigid region, parts of faces, or whole faces that move or come and go.
   subroutine read_wall(deck, simulation, shapes, group, bodies, faces)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(in) :: simulation   !! The run, its grid and plain faces are read
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      type(group_t), intent(in) :: group             !! The &boundary
      type(wall_t), allocatable, intent(inout) :: bodies(:) !! Grows by a rigid region
      type(wall_t), allocatable, intent(inout) :: faces(:)  !! Grows by parts and moving faces
      character(len=:), allocatable :: face, kind, region
      type(wall_t) :: wall
      logical :: wins
      integer :: index

      if (.not. (group%given("region") .or. group%given("table") .or. group%given("t_on") &
         .or. group%given("t_off"))) return
      call group%get("face", face)
      call group%get("type", kind)
      wall%kind = position_of(kind, face_types)
      if (kind == "friction") call group%get("friction", wall%friction)
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
      if (face == "" .and. allocated(wall%region)) bodies = [bodies, wall]
      do index = 1, size(face_names)
         if (face /= face_names(index) .and. face /= "all") cycle
         if (.not. simulation%space%grid%active(ishft(index + 1, -1))) cycle
         ! a face that is named for itself wins over all
         wins = .false.
         if (face == "all" .and. .not. group%given("region")) wins = named(deck, face_names(index))
         if (wins) cycle
         wall%face = index
         faces = [faces, wall]
      end do
   end subroutine read_wall

   !> Whether some &boundary names a whole face.
   logical function named(deck, face) result(is_named)
      type(deck_t), intent(in) :: deck               !! The deck
      character(len=*), intent(in) :: face           !! Name of the face
      character(len=:), allocatable :: other
      type(group_t) :: group
      integer :: index

      is_named = .false.
      do index = 1, deck%count("boundary")
         group = deck%group("boundary", index)
         call group%get("face", other)
         is_named = is_named .or. (other == face .and. .not. group%given("region"))
      end do
   end function named

   !> How a wall moves, and while it is there. Collective.
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
