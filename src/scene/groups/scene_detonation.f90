! SPDX-License-Identifier: BSD-3-Clause
!> The group &detonation: where and when explosives are ignited.
module scene_detonation
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use material_burn, only: detonator_line, detonator_plane, detonator_point, detonator_t
   use material_catalogue, only: choose_eos
   use material_eos, only: eos_t
   use mesh_grid, only: grid_t
   use particle_body, only: body_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: declare_detonation, read_detonations

contains

   !> Declare &detonation.
   subroutine declare_detonation(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("detonation", &
         "where and when an explosive is ignited; the earliest arrival is used", many=.true.)
      call schema%text("detonation", "shape", "shape of the part that is ignited at once", &
         default="point", words="point line plane")
      call schema%real("detonation", "point(3)", &
         "ignition point; start of a line; any point of a plane", unit="m")
      call schema%real("detonation", "point2(3)", "end of the line", unit="m", owner="shape = line")
      call schema%real("detonation", "normal(3)", "normal of the plane", owner="shape = plane")
      call schema%real("detonation", "time", "time of ignition", unit="s", default="0")
      call schema%real("detonation", "speed", &
         "detonation speed; default: detonation_speed of the material", unit="m/s", range="> 0")
      call schema%text("detonation", "material", "the only explosive that is ignited; default: all")
      call schema%require("detonation", "point point2 normal")
      call schema%refer("detonation", "material", "material")
      call schema%forbid_change("detonation", "* + -", "the particles of the checkpoint "// &
         "have the times at which they are ignited")
   end subroutine declare_detonation

   !> Assign to explosives the detonations that reach them, and warn of explosives without a
   !! detonation and of detonations without an explosive.
   subroutine read_detonations(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! Grid, materials and stores are known
      type(body_t), intent(in) :: bodies(:)
      type(detonator_t) :: detonator
      type(group_t) :: group
      integer :: index
      character(len=:), allocatable :: word

      call warn_of_materials(deck, simulation)
      do index = 1, size(simulation%materials)
         if (.not. allocated(simulation%materials(index)%burn)) cycle
         associate (burn => simulation%materials(index)%burn)
            allocate (burn%detonators(0))
            burn%rate = burn%speed/(burn%cells*simulation%space%grid%spacing)
         end associate
      end do
      do index = 1, deck%count("detonation")
         group = deck%group("detonation", index)
         ! inactive directions are 0
         detonator = detonator_t()
         call group%get("shape", word)
         call group%get("point", detonator%point)
         call group%get("time", detonator%time)
         if (group%given("speed")) call group%get("speed", detonator%speed)
         select case (word)
         case ("line")
            detonator%shape = detonator_line
            call group%get("point2", detonator%other)
         case ("plane")
            detonator%shape = detonator_plane
            call group%get("normal", detonator%other)
         case default
            detonator%shape = detonator_point
         end select
         detonator%point = merge(detonator%point, 0.0_wp, simulation%space%grid%active)
         detonator%other = merge(detonator%other, 0.0_wp, simulation%space%grid%active)
         if (detonator%shape == detonator_plane .and. group%known("normal") .and. .not. &
            any(abs(detonator%other) > 0.0_wp)) call deck%add_error(group, &
            "a plane needs a normal along the directions of the scene [D320]", "normal")
         if (.not. deck%sound("detonation", index)) cycle
         call ignite_explosives(deck, group, detonator, simulation, bodies)
      end do
   end subroutine read_detonations

   !> Warn of explosives without ignition, and of a detonation speed that differs from that of their
   !! products.
   subroutine warn_of_materials(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects warnings
      type(simulation_t), intent(in) :: simulation
      real(wp), parameter :: most = 0.03_wp
      type(group_t) :: group
      character(len=:), allocatable :: word, name
      class(eos_t), allocatable :: eos
      real(wp) :: least, speed
      integer :: n, material

      do n = 1, deck%count("material")
         group = deck%group("material", n)
         call group%get("eos_model", word)
         call choose_eos(word, eos)
         if (.not. allocated(eos) .or. .not. deck%sound("material", n)) cycle
         if (.not. eos%detonates()) cycle
         if (deck%count("detonation") == 0) call deck%warn(group, "is an explosive that no "// &
            "&detonation ignites: it starts as hot products at their full pressure; add a "// &
            "&detonation with the point where it starts [D320]", "eos_model")
         if (.not. group%given("detonation_speed")) cycle
         call group%get("detonation_speed", speed)
         ! speed of the Chapman-Jouguet state of the constants
         call group%get("name", name)
         call group%get("detonation_speed", least)
         do material = 1, size(simulation%materials)
            if (simulation%materials(material)%name /= name) cycle
            if (allocated(simulation%materials(material)%eos)) least = &
               simulation%materials(material)%eos%chapman_jouguet_speed()
            exit
         end do
         if (abs(speed - least) > most*least) call deck%warn(group, "detonation_speed = "// &
            brief(speed)//" m/s, but the constants jwl_* give a detonation speed "// &
            "of "//brief(least)// &
            " m/s; one of the constants belongs to another explosive [D320]", "detonation_speed")
      end do
   end subroutine warn_of_materials

   !> Add a detonation to the explosives that it ignites.
   subroutine ignite_explosives(deck, group, detonator, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &detonation
      type(detonator_t), intent(in) :: detonator
      type(simulation_t), intent(inout) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(detonator_t) :: own
      character(len=:), allocatable :: only
      logical :: lights, touches
      integer :: index, n

      only = ""
      if (group%given("material")) call group%get("material", only)
      lights = .false.
      touches = .false.
      do index = 1, size(simulation%materials)
         if (.not. allocated(simulation%materials(index)%burn)) cycle
         if (only /= "" .and. only /= simulation%materials(index)%name) cycle
         lights = .true.
         own = detonator
         if (.not. own%speed > 0.0_wp) own%speed = simulation%materials(index)%burn%speed
         simulation%materials(index)%burn%detonators = &
            [simulation%materials(index)%burn%detonators, own]
         do n = 1, size(bodies)
            if (bodies(n)%store == index) touches = touches .or. &
               touches_body(simulation%space%grid, bodies(n), own)
         end do
      end do
      if (.not. lights) then
         call deck%add_error(group, "ignites no explosive; write eos_model = 'jwl' in the "// &
            "&material that burns, or remove the group [D320]", "material")
      else if (.not. touches) then
         call deck%warn(group, "lies outside every explosive, more than a cell from the box "// &
            "around it; it ignites all explosive in its line of sight, as if the space "// &
            "between were explosive [D320]", "point")
      end if
   end subroutine ignite_explosives

   !> Is a detonation within a cell of the box around a body? The nearest points of two convex sets
   !! are found by alternating projections.
   function touches_body(grid, body, detonator) result(touches)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      type(detonator_t), intent(in) :: detonator
      integer, parameter :: rounds = 200
      logical :: touches
      real(wp) :: low(3), high(3), place(3), foot(3)
      integer :: round

      call body%shape%bounds(low, high)
      low = merge(max(low, grid%lower), 0.0_wp, grid%active)
      high = merge(min(high, grid%upper), 0.0_wp, grid%active)
      place = 0.5_wp*(low + high)
      do round = 1, rounds
         foot = detonator%foot(place)
         place = max(low, min(high, foot))
      end do
      touches = all(abs(place - detonator%foot(place)) <= grid%spacing)
   end function touches_body
end module scene_detonation
