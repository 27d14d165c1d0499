! SPDX-License-Identifier: BSD-3-Clause
!> Warns of entries of a deck without effect: materials of no body, effects used by no material,
!! walls and loads that never act. All of them are allowed.
module scene_without_effect
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use material_stages, only: effect_damage, effect_voids
   use mesh_wall, only: wall_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: warn_without_effect

contains

   !> All warnings, once the scene is set up.
   subroutine warn_without_effect(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects warnings
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(group_t) :: body, load, time
      character(len=:), allocatable :: name
      logical, allocatable :: used(:)
      integer :: n, number
      real(wp), allocatable :: factors(:), times(:)
      real(wp) :: finish, pressure, traction(3)

      ! materials that no body uses
      allocate (used(deck%count("material")), source=.false.)
      do n = 1, deck%count("body")
         body = deck%group("body", n)
         call body%get("material", name)
         number = deck%named("material", name)
         if (number > 0) used(number) = .true.
      end do
      do n = 1, size(used)
         if (.not. used(n)) call deck%warn("material", n, "no body uses it; remove it, or "// &
            "use it in a &body [D445]", "name")
      end do
      call warn_of_effects(deck, simulation)
      call warn_of_walls(deck, simulation)
      ! loads that are 0 at all times of the run
      time = deck%group("time", 1)
      do n = 1, deck%count("load")
         load = deck%group("load", n)
         pressure = 0.0_wp
         traction = 0.0_wp
         if (load%given("pressure")) call load%get("pressure", pressure)
         if (load%given("traction")) call load%get("traction", traction)
         if (.not. any(abs([pressure, traction]) > 0.0_wp)) call deck%warn(load, "is 0; it "// &
            "does nothing [D445]", "pressure")
         if (.not. (load%given("factors") .and. time%given("t_end"))) cycle
         call load%list("times", times)
         call load%list("factors", factors)
         call time%get("t_end", finish)
         if (size(times) /= size(factors) .or. size(times) == 0) cycle
         ! linear between entries, so the first one after the end of the run counts too
         if (.not. any(abs(factors(:min(size(times), count(times < finish) + 1))) > 0.0_wp)) call &
            deck%warn(load, "its factors are 0 until the end of the run; it does nothing [D445]", &
            "factors")
      end do
   end subroutine warn_without_effect

   !> Effects that are on in &effects but used by no material or without anything to act on.
   subroutine warn_of_effects(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects warnings
      type(simulation_t), intent(in) :: simulation
      type(group_t) :: group
      real(wp) :: gravity(3)
      integer :: n

      group = deck%group("effects", 1)
      if (is_on(group, "damage")) then
         if (.not. any([(simulation%materials(n)%has(effect_damage), &
            n=1, size(simulation%materials))])) call deck%warn(group, "damage = .true. does "// &
            "nothing, as no material can fail; give one a damage_model or spall [D445]", "damage")
      end if
      if (is_on(group, "voids")) then
         if (.not. any([(simulation%materials(n)%has(effect_voids), &
            n=1, size(simulation%materials))])) call deck%warn(group, "voids = .true. does "// &
            "nothing, as no material has voids; give one alpha_m or solid_fraction [D445]", "voids")
      end if
      if (is_on(group, "contact") .and. size(simulation%fields) < 2) call deck%warn(group, &
         "contact = .true. does nothing, as all bodies have one velocity field; it needs two "// &
         "bodies [D445]", "contact")
      if (.not. is_on(group, "gravity") .or. group%given("gravity_table")) return
      call group%get("gravity_vector", gravity)
      if (.not. any(abs(gravity) > 0.0_wp)) call deck%warn(group, "gravity = .true. does "// &
         "nothing, as gravity_vector is 0 [D445]", "gravity_vector")
   end subroutine warn_of_effects

   !> Whether the deck turns a switch on.
   logical function is_on(group, key) result(on)
      type(group_t), intent(in) :: group             !! &effects
      character(len=*), intent(in) :: key

      on = group%given(key)
      if (on) call group%get(key, on)
   end function is_on

   !> Walls that start after the end of the run, and rigid regions at rest outside of the grid.
   subroutine warn_of_walls(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects warnings
      type(simulation_t), intent(in) :: simulation
      type(group_t) :: boundary, time
      character(len=:), allocatable :: name
      real(wp) :: begin, finish
      integer :: n, wall

      time = deck%group("time", 1)
      do n = 1, deck%count("boundary")
         boundary = deck%group("boundary", n)
         if (boundary%given("t_on") .and. time%given("t_end")) then
            call boundary%get("t_on", begin)
            call time%get("t_end", finish)
            if (begin >= finish) call deck%warn(boundary, "comes at t = "//brief(begin)// &
               " s and the run ends at "//brief(finish)//" s; it does nothing [D445]", "t_on")
         end if
         if (boundary%given("face") .or. .not. allocated(simulation%space%rigid)) cycle
         call boundary%get("region", name)
         do wall = 1, size(simulation%space%rigid%wall)
            associate (rigid => simulation%space%rigid%wall(wall))
               if (rigid%name /= name .or. rigid%stays .or. rigid%moves()) cycle
               if (is_outside(simulation, rigid)) call deck%warn(boundary, "the region '"// &
                  name//"' lies outside of the grid and does not move; it does nothing [D445]", &
                  "region")
            end associate
         end do
      end do
   end subroutine warn_of_walls

   !> True if the bounds of a region and the grid do not overlap.
   pure logical function is_outside(simulation, wall) result(outside)
      type(simulation_t), intent(in) :: simulation
      type(wall_t), intent(in) :: wall
      real(wp) :: high(3), low(3)

      outside = .false.
      if (.not. allocated(wall%region)) return
      call wall%region%bounds(low, high)
      associate (grid => simulation%space%grid)
         outside = any(grid%active .and. (low > grid%upper .or. high < grid%lower))
      end associate
   end function is_outside
end module scene_without_effect
