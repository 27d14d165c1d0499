! SPDX-License-Identifier: BSD-3-Clause
!> Checks of the regions and boundaries of a deck.
module scene_deck_check_scene
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use base_text, only: text_t
   use mesh_boundary, only: face_names
   use scene_deck_check_grid, only: axis_names, check_plane, dimension_of
   use scene_deck_check_units, only: check_angles
   implicit none
   private

   public :: check_boundaries, check_regions

contains

   !> All regions.
   subroutine check_regions(deck)
      type(deck_t), intent(inout) :: deck                !! The deck
      integer, allocatable :: state(:)
      integer :: i

      do i = 1, deck%count("region")
         call check_region(deck, deck%group("region", i))
      end do
      allocate (state(deck%count("region")), source=0)
      do i = 1, size(state)
         if (state(i) == 0) call follow(deck, i, state)
      end do
   end subroutine check_regions

   !> One region.
   subroutine check_region(deck, region)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: region                !! The region
      character(len=:), allocatable :: dimension, shape
      logical :: active(3)
      real(wp) :: axis(3), hi(3), lo(3)
      integer :: k, operands

      call check_angles(deck, region)
      call region%get("shape", shape)
      select case (shape)
      case ("box")
         if (.not. (region%known("lo") .and. region%known("hi"))) return
         call region%get("lo", lo)
         call region%get("hi", hi)
         call dimension_of(deck, dimension, active)
         do k = 1, 3
            if (hi(k) > lo(k) .or. .not. active(k)) cycle
            call deck%complain(region, "hi must be above lo in "//axis_names(k), "hi")
            return
         end do
      case ("halfspace")
         call region%get("normal", axis)
         if (region%known("normal") .and. sum(abs(axis)) <= 0.0_wp) &
            call deck%complain(region, "normal must not be 0", "normal")
      case ("cylinder", "cone", "torus")
         call region%get("axis", axis)
         if (region%known("axis") .and. sum(abs(axis)) <= 0.0_wp) &
            call deck%complain(region, "axis must not be 0", "axis")
      case ("difference", "intersection")
         operands = region%count("of")
         if (operands == 1) call deck%complain(region, &
            "of must name two regions or more for a "//shape, "of")
      case default
         continue
      end select
   end subroutine check_region

   !> Follow the operands of a region; one that leads back to itself has no shape.
   recursive subroutine follow(deck, place, state)
      type(deck_t), intent(inout) :: deck                !! The deck
      integer, intent(in) :: place                       !! Number of the region
      integer, intent(inout) :: state(:)                 !! (region) 0 new, 1 under way, 2 done
      type(group_t) :: region
      type(text_t), allocatable :: operands(:)
      integer :: i, next

      state(place) = 1
      region = deck%group("region", place)
      call region%list("of", operands)
      do i = 1, size(operands)
         next = deck%named("region", operands(i)%text)
         if (next == 0) cycle
         if (state(next) == 0) then
            call follow(deck, next, state)
         else if (state(next) == 1) then
            call deck%complain(region, "'"//operands(i)%text//"' is made of this region itself", &
               "of")
         end if
      end do
      state(place) = 2
   end subroutine follow

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
