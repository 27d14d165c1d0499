! SPDX-License-Identifier: BSD-3-Clause
!> Checks of the boundaries of a deck.
module scene_deck_check_scene
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use mesh_boundary, only: face_names
   use scene_dimension, only: check_plane
   implicit none
   private

   public :: check_boundaries

contains

   !> All boundaries.
   subroutine check_boundaries(deck)
      type(deck_t), intent(inout) :: deck                !! The deck
      character(len=:), allocatable :: dimension, face, kind
      integer :: owner(6), every, i, k
      logical :: periodic(6)
      type(group_t) :: boundary, run

      run = deck%group("run")
      call run%get("dimension", dimension)
      owner = 0
      every = 0
      periodic = .false.
      do i = 1, deck%count("boundary")
         boundary = deck%group("boundary", i)
         call boundary%get("face", face)
         call boundary%get("type", kind)
         call check_plane(deck, boundary, "velocity")
         call check_wall(deck, boundary, face, kind)
         if (boundary%given("region")) then
            do k = 1, 6
               if (face_names(k) == face) call check_face(deck, boundary, dimension, k, kind)
            end do
            cycle
         end if
         if (face == "all") then
            if (every > 0) call deck%complain(boundary, "face = 'all' is given twice", "face")
            every = i
            if (kind == "periodic") where (owner == 0) periodic = .true.
         end if
         do k = 1, 6
            if (face_names(k) /= face) cycle
            if (owner(k) > 0) call deck%complain(boundary, "face = '"//face//"' is given twice", &
               "face")
            owner(k) = i
            periodic(k) = kind == "periodic"
            call check_face(deck, boundary, dimension, k, kind)
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
   subroutine check_wall(deck, boundary, face, kind)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: boundary              !! One boundary
      character(len=*), intent(in) :: face               !! Its face, may be empty
      character(len=*), intent(in) :: kind               !! Its type
      real(wp) :: begin, end, velocity(3)

      if (.not. (boundary%given("face") .or. boundary%given("region"))) then
         call deck%complain(boundary, "face or region must be given (a face of the grid, or a "// &
            "rigid region)")
      else if (boundary%given("region") .and. (kind == "symmetry" .or. kind == "periodic" .or. &
         kind == "absorbing" .or. (kind == "outflow" .and. .not. boundary%given("face")))) then
         call deck%complain(boundary, "a region cannot be type = '"//kind//"'; "//trim(merge( &
            "use outflow, stick, slip, friction or velocity", &
            "use stick, slip, friction or velocity         ", boundary%given("face"))), "type")
      end if
      if (boundary%given("face") .and. kind /= "velocity" .and. kind /= "") then
         ! an echo of the deck names the default, a velocity of zero
         velocity = 0.0_wp
         if (boundary%given("velocity")) call boundary%get("velocity", velocity)
         if (any(abs(velocity) > 0.0_wp)) call deck%complain(boundary, "a face moves only with "// &
            "type = 'velocity'; remove velocity, or use a region", "velocity")
         if (boundary%given("table")) call deck%complain(boundary, "a face moves only with "// &
            "type = 'velocity'; remove table, or use a region", "table")
      end if
      if (boundary%given("temperature") .and. (boundary%given("region") .or. kind == "periodic")) &
         call deck%complain(boundary, "temperature is that of a whole face that is not "// &
         "periodic; remove it", "temperature")
      if (boundary%known("t_off") .and. boundary%known("t_on")) then
         call boundary%get("t_on", begin)
         call boundary%get("t_off", end)
         if (.not. end > begin) call deck%complain(boundary, "t_off must be after t_on", "t_off")
      end if
   end subroutine check_wall

   !> A face must exist in the scene; on the axis only mirrors make sense.
   subroutine check_face(deck, boundary, dimension, face, kind)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: boundary              !! One boundary
      character(len=*), intent(in) :: dimension          !! As in the deck
      integer, intent(in) :: face                        !! 1 to 6
      character(len=*), intent(in) :: kind               !! Type of the boundary
      integer :: direction

      direction = (face + 1)/2
      if (dimension == "") return
      ! matter in plane strain lies between mirrors and does not move along y
      if (direction == 2 .and. dimension == "plane_strain" .and. (kind == "symmetry" .or. &
         kind == "slip") .and. .not. (boundary%given("region") .or. boundary%given("temperature") &
         .or. boundary%given("t_on") .or. boundary%given("t_off"))) return
      if (direction == 2 .and. dimension /= "3d" .or. direction == 3 .and. dimension == "1d") then
         call deck%complain(boundary, "dimension = '"//dimension//"' has no face "// &
            face_names(face), "face")
      else if (direction == 1 .and. dimension == "axisymmetric" .and. kind == "periodic") then
         call deck%complain(boundary, "the radius cannot be periodic", "type")
      else if (face == 1 .and. dimension == "axisymmetric" .and. kind /= "symmetry" .and. &
         kind /= "") then
         call deck%complain(boundary, "the axis of axisymmetric can only be type = 'symmetry'", &
            "type")
      end if
   end subroutine check_face

   !> A periodic face needs its partner.
   subroutine check_pair(deck, boundary, face, periodic)
      type(deck_t), intent(inout) :: deck                !! The deck
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
