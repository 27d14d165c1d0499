! SPDX-License-Identifier: BSD-3-Clause
!> Checks of a deck that compare keys with each other. Each says what to write instead.
module scene_deck_check
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use base_units, only: system_names
   use io_file, only: name_of
   use scene_deck_check_grid, only: check_grid, check_plane
   use scene_deck_check_scene, only: check_boundaries, check_regions
   use scene_deck_check_units, only: check_kelvin, check_material_units
   implicit none
   private

   public :: check_case, check_deck

contains

   !> Check the whole deck. What is wrong is noted in it; defaults that depend on it are settled.
   subroutine check_deck(deck)
      type(deck_t), intent(inout) :: deck                !! After `read`
      integer :: i

      do i = 1, deck%count("include")
         call deck%complain("include", i, "the file was not read; end the group with a /", "file")
      end do
      call check_case(deck)
      call settle_output_units(deck)
      call check_grid(deck)
      call check_time(deck)
      do i = 1, deck%count("material")
         call check_material_units(deck, deck%group("material", i))
      end do
      call check_regions(deck)
      if (deck%count("body") == 0) call deck%complain("body", 1, &
         "there is none, so nothing to compute")
      do i = 1, deck%count("body")
         call check_plane(deck, deck%group("body", i), "velocity")
         call check_plane(deck, deck%group("body", i), "direction")
         call check_plane(deck, deck%group("body", i), "repeat_step")
         call check_speed(deck, deck%group("body", i))
         call check_spin(deck, deck%group("body", i))
         call check_kelvin(deck, deck%group("body", i))
      end do
      call check_boundaries(deck)
   end subroutine check_deck

   !> A speed needs a direction, and takes the place of a velocity.
   subroutine check_speed(deck, body)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: body                  !! The &body
      real(wp) :: direction(3), velocity(3)

      if (.not. body%valid([character(len=9) :: "velocity", "speed", "direction"])) return
      if (body%given("speed") .neqv. body%given("direction")) then
         call deck%complain(body, "speed and direction belong together; give both, or velocity", &
            merge("speed    ", "direction", body%given("speed")))
      else if (body%given("speed")) then
         ! an echo of the deck names the default, a velocity of zero
         call body%get("velocity", velocity)
         call body%get("direction", direction)
         if (any(abs(velocity) > 0.0_wp)) call deck%complain(body, &
            "speed and velocity are both given; keep one", "speed")
         if (.not. any(abs(direction) > 0.0_wp)) call deck%complain(body, &
            "direction must not be 0 in all components", "direction")
      end if
   end subroutine check_speed

   !> Outputs in the units of the deck are in a system of that name: the echo is in SI.
   subroutine settle_output_units(deck)
      type(deck_t), intent(inout) :: deck                !! The deck
      character(len=:), allocatable :: word
      type(group_t) :: units

      units = deck%group("units")
      call units%get("output_units", word)
      if (word == "deck") call deck%settle("units", 1, "output_units", &
         trim(system_names(deck%system)))
   end subroutine settle_output_units

   !> The case is part of file names. Without one it is the name of the deck.
   subroutine check_case(deck)
      type(deck_t), intent(inout) :: deck                !! The deck
      character(len=*), parameter :: suffix = ".nml"
      character(len=:), allocatable :: case_name
      type(group_t) :: run
      integer :: last

      run = deck%group("run")
      if (.not. run%valid(["case"])) return
      if (.not. run%given("case")) then
         case_name = name_of(deck%file)
         last = len(case_name)
         if (last > len(suffix)) then
            if (case_name(last - len(suffix) + 1:) == suffix) last = last - len(suffix)
         end if
         call deck%settle("run", 1, "case", case_name(:last))
         return
      end if
      call run%get("case", case_name)
      if (scan(case_name, "/ *?'""") > 0) call deck%complain(run, "case = '"//case_name// &
         "' is part of file names: no blanks, slashes, quotes; the folder is --outdir", "case")
      if (len(case_name) > 100) call deck%complain(run, "case is longer than 100 letters", "case")
   end subroutine check_case

   !> Steps and limits of time.
   subroutine check_time(deck)
      type(deck_t), intent(inout) :: deck                !! The deck
      character(len=:), allocatable :: limit
      real(wp) :: dt_fixed, dt_max, dt_min
      type(group_t) :: time

      time = deck%group("time")
      call time%get("dt_min", dt_min)
      call time%get("dt_max", dt_max)
      call time%get("dt_fixed", dt_fixed)
      if (time%given("dt_max") .and. time%valid(["dt_max"]) .and. dt_max <= dt_min) &
         call deck%complain(time, "dt_max must be above dt_min", "dt_max")
      if (time%given("dt_fixed") .and. time%valid(["dt_fixed"])) then
         if (dt_fixed < dt_min) call deck%complain(time, "dt_fixed is below dt_min", "dt_fixed")
         if (time%given("dt_max")) call deck%complain(time, &
            "dt_fixed and dt_max are both given; keep one", "dt_fixed")
         if (time%given("cfl")) call deck%warn(time, "cfl is not used, as dt_fixed is given", "cfl")
      end if
      call time%get("wall_limit", limit)
      if (time%given("wall_limit") .and. limit /= "none" .and. limit /= "slurm" .and. &
         limit /= "") then
         if (.not. is_clock(limit)) call deck%complain(time, "wall_limit = '"//limit// &
            "' must be 'none', 'slurm', or hours, minutes and seconds such as '03:30:00'", &
            "wall_limit")
      end if
   end subroutine check_time

   !> True for hh:mm:ss.
   pure logical function is_clock(text) result(right)
      character(len=*), intent(in) :: text               !! Perhaps a time
      integer :: last

      last = len(text)
      right = .false.
      if (last < 7 .or. last > 9) return
      if (verify(text(:last - 6), "0123456789") > 0) return
      right = text(last - 5:last - 5) == ":" .and. text(last - 2:last - 2) == ":" .and. &
         verify(text(last - 4:last - 3)//text(last - 1:), "0123456789") == 0 .and. &
         scan(text(last - 4:last - 4)//text(last - 1:last - 1), "6789") == 0
   end function is_clock

   !> In a plane or on a line bodies turn only in the plane.
   subroutine check_spin(deck, body)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: body                  !! One body
      character(len=:), allocatable :: dimension
      real(wp) :: spin(3)
      type(group_t) :: run

      run = deck%group("run")
      call run%get("dimension", dimension)
      if (dimension == "3d" .or. .not. (body%given("spin") .and. body%known("spin"))) return
      call body%get("spin", spin)
      if (dimension == "plane_strain") spin(2) = 0.0_wp
      if (any(abs(spin) > 0.0_wp)) call deck%complain(body, &
         "spin leaves the plane of dimension = '"// &
         dimension//"'; only plane_strain can turn, about y", "spin")
   end subroutine check_spin
end module scene_deck_check
