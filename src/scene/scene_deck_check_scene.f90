! SPDX-License-Identifier: BSD-3-Clause
!> Checks of the boundaries of a deck.
module scene_deck_check_scene
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use mesh_boundary, only: face_names
   use mesh_boundary_catalogue, only: boundary_names, choose_boundary
   use mesh_boundary_condition, only: boundary_condition_t
   use scene_dimension, only: axis_names, check_plane, dimension_of
   implicit none
   private

   public :: check_boundaries

contains

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
         call check_wall(deck, boundary, condition)
         joins = .false.
         if (allocated(condition)) joins = condition%joins_opposite()
         if (face == "all" .and. .not. boundary%given("region")) then
            if (every > 0) call deck%complain(boundary, "face = 'all' is given twice", "face")
            every = i
            if (joins) where (owner == 0) periodic = .true.
         end if
         do k = 1, 6
            if (face_names(k) /= face) cycle
            if (.not. boundary%given("region")) then
               if (owner(k) > 0) call deck%complain(boundary, "face = '"//face// &
                  "' is given twice", "face")
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

   !> What a wall must have, and what does not go together.
   subroutine check_wall(deck, boundary, condition)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary
      class(boundary_condition_t), allocatable, intent(in) :: condition !! Its type, if it is known
      real(wp) :: begin, end

      if (.not. (boundary%given("face") .or. boundary%given("region"))) call deck%complain( &
         boundary, "face or region must be given (a face of the grid, or a rigid region)")
      if (allocated(condition)) call check_type(deck, boundary, condition)
      if (boundary%given("temperature") .and. boundary%given("region")) call &
         refuse_temperature(deck, boundary)
      if (boundary%known("t_off") .and. boundary%known("t_on")) then
         call boundary%get("t_on", begin)
         call boundary%get("t_off", end)
         if (.not. end > begin) call deck%complain(boundary, "t_off must be after t_on", "t_off")
      end if
   end subroutine check_wall

   !> Whether a type suits a region, a motion and a temperature.
   subroutine check_type(deck, boundary, condition)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary
      class(boundary_condition_t), intent(in) :: condition !! Its type
      character(len=:), allocatable :: fitting
      real(wp) :: velocity(3)
      logical :: part, suits

      part = boundary%given("face")
      suits = condition%suits_region()
      if (part) suits = condition%suits_part()
      fitting = fitting_types(part)
      if (boundary%given("region") .and. .not. suits) call deck%complain(boundary, &
         "a region cannot be type = '"//trim(condition%name)//"'; use "//fitting, "type")
      if (part .and. .not. condition%moves()) then
         ! an echo of the deck names the default, a velocity of zero
         velocity = 0.0_wp
         if (boundary%given("velocity")) call boundary%get("velocity", velocity)
         if (any(abs(velocity) > 0.0_wp)) call deck%complain(boundary, "a face moves only with "// &
            "type = 'velocity'; remove velocity, or use a region", "velocity")
         if (boundary%given("table")) call deck%complain(boundary, "a face moves only with "// &
            "type = 'velocity'; remove table, or use a region", "table")
      end if
      if (boundary%given("temperature") .and. condition%joins_opposite() .and. &
         .not. boundary%given("region")) call refuse_temperature(deck, boundary)
   end subroutine check_type

   !> Only whole boundaries that are not periodic have a temperature.
   subroutine refuse_temperature(deck, boundary)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary

      call deck%complain(boundary, "temperature is that of a whole face that is not "// &
         "periodic; remove it", "temperature")
   end subroutine refuse_temperature

   !> The types that suit a part of a boundary, or a rigid region, for a message.
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

   !> A boundary must exist in the scene; the axis of symmetry mirrors.
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
         ! material in plane strain lies between mirrors and does not move along y
         if (direction == 2 .and. dimension == "plane_strain" .and. condition%slides() .and. &
            .not. (condition%has_friction() .or. boundary%given("region") .or. &
            boundary%given("temperature") .or. boundary%given("t_on") .or. &
            boundary%given("t_off"))) return
      end if
      if (direction == 2 .and. dimension /= "3d" .or. direction == 3 .and. dimension == "1d") then
         call deck%complain(boundary, "dimension = '"//dimension//"' has no face "// &
            face_names(face), "face")
         return
      end if
      if (direction /= 1 .or. dimension /= "axisymmetric" .or. .not. allocated(condition)) return
      if (condition%joins_opposite()) then
         call deck%complain(boundary, "the radius cannot be periodic", "type")
      else if (face == 1 .and. .not. condition%mirrors()) then
         call deck%complain(boundary, "the axis of axisymmetric can only be type = 'symmetry'", &
            "type")
      end if
   end subroutine check_face

   !> A periodic face needs its partner.
   subroutine check_pair(deck, boundary, face, periodic)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary              !! One boundary
      character(len=*), intent(in) :: face               !! Its face
      logical, intent(in) :: periodic(6)                 !! (face) Is it periodic?
      integer :: k, partner

      do k = 1, 6
         partner = k - 1 + 2*mod(k, 2)
         if (face_names(k) /= face .or. .not. periodic(k) .or. periodic(partner)) cycle
         call deck%complain(boundary, "periodic needs both faces; make "//face_names(partner)// &
            " periodic too", "type")
      end do
   end subroutine check_pair
end module scene_deck_check_scene
