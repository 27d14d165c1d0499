! SPDX-License-Identifier: BSD-3-Clause
!> Warnings of values that are implausible beside others: stresses beside the bulk modulus of the
!! material, speeds beside its wave speed, the end of the run beside the first time step. Most are
!! numbers in other units than those of the deck. The limits are ratios, so that they are the same
!! in all systems of units and in decks without dimensions.
module run_plausible
   use base_kinds, only: int64, wp
   use base_text, only: brief, number
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use material_kinds, only: is_gas
   use material_type, only: material_t
   use particle_body, only: body_t
   use run_expected_steps, only: find_first_step
   use run_limits, only: limits_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_plausible

   !> Ratios to the bulk modulus. A yield stress in MPa or GPa that is read as Pa is below 1e-8 of
   !! it in all solids; the least real ones are those of gels, 1e-7. No strength is above it. The
   !! shear modulus of rubber is 5e-4 of the bulk modulus; an isotropic material with a ratio above
   !! 1.5 is wider under tension.
   real(wp), parameter :: least_ratio = 1.0e-7_wp, most_strength = 1.0_wp, most_shear = 10.0_wp
   real(wp), parameter :: most_load = 10.0_wp            !! Pressures of explosives on porous bodies
   real(wp), parameter :: usual_strength = 3.0e-3_wp, usual_shear = 0.4_wp
   real(wp), parameter :: slowest = 0.3_wp, fastest = 5.0e4_wp !! Waves in materials [m/s]
   real(wp), parameter :: usual_speed = 3.0e3_wp         !! Waves in solids [m/s]
   real(wp), parameter :: most_mach = 10.0_wp            !! Speed over the wave speed
   !> Centrifuges for models of soil reach 500 times the gravity of the earth.
   real(wp), parameter :: most_gravity = 6.0e3_wp        !! [m/s2]
   real(wp), parameter :: fewest = 5.0_wp                !! Steps that show a motion
   !> 1e8 steps of 1e4 particles take three days on a core.
   real(wp), parameter :: most_steps = 1.0e8_wp
   !> Beyond this number of steps a step is no longer than the rounding error of the time.
   real(wp), parameter :: countable = 1.0e15_wp
   !> Pressures of equations of state, which have no usual ratio to the bulk modulus.
   character(len=4), parameter :: other_prefixes(5) = ["jh2_", "hjc_", "till", "jwl_", "pa_p"]
   character(len=7), parameter :: strengths(2) = [character(len=7) :: "jh2_hel", "hjc_fc"]
   character(len=9), parameter :: moduli(10) = [character(len=9) :: "young", "bulk", "jh2_k1", &
      "jh2_k2", "jh2_k3", "hjc_k1", "hjc_k2", "hjc_k3", "till_bulk", "mg_c0"]

contains

   !> Warn of implausible values of materials, bodies and walls, and of the number of steps.
   subroutine check_plausible(schema, deck, simulation, bodies, limits)
      type(schema_t), intent(in) :: schema               !! Units of the keys
      type(deck_t), intent(inout) :: deck                !! Collects errors and warnings
      type(simulation_t), intent(in) :: simulation       !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(limits_t), intent(in) :: limits               !! End of the run
      real(wp) :: wave, largest, bulk, pressure
      type(group_t) :: load
      integer :: n, place
      logical :: plausible, checked(deck%count("material"))

      checked = .false.
      largest = 0.0_wp
      bulk = 0.0_wp
      plausible = .true.
      do n = 1, size(simulation%materials)
         ! with contact a material has a store for each of its velocity fields
         place = deck%named("material", simulation%materials(n)%name)
         if (.not. checked(place)) call check_stresses(schema, deck, deck%group("material", &
            place), simulation%materials(n), plausible)
         checked(place) = .true.
         bulk = max(bulk, simulation%materials(n)%bulk)
         if (.not. is_gas(simulation%materials(n))) &
            largest = max(largest, simulation%materials(n)%reference_speed())
      end do
      do n = 1, size(bodies)
         wave = simulation%materials(bodies(n)%store)%reference_speed()
         if (is_gas(simulation%materials(bodies(n)%store))) cycle
         call check_speed(deck, deck%group("body", n), "velocity", wave)
         call check_speed(deck, deck%group("body", n), "speed", wave)
      end do
      do n = 1, deck%count("boundary")
         call check_speed(deck, deck%group("boundary", n), "velocity", largest)
      end do
      do n = 1, deck%count("inflow")
         call check_speed(deck, deck%group("inflow", n), "velocity", largest)
      end do
      do n = 1, deck%count("load")
         load = deck%group("load", n)
         if (.not. (load%given("pressure") .and. bulk > 0.0_wp)) cycle
         call load%get("pressure", pressure)
         if (abs(pressure) > most_load*bulk) &
            call warn_ratio(deck, load, "pressure", pressure, bulk, usual_strength)
      end do
      call check_gravity(deck, deck%group("effects", 1))
      if (deck%sound("time") .and. limits%time_end > 0.0_wp) &
         call check_steps(deck, simulation, bodies, limits, plausible)
   end subroutine check_plausible

   !> Compare all stresses of a material with its bulk modulus.
   subroutine check_stresses(schema, deck, group, material, plausible)
      type(schema_t), intent(in) :: schema
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group                 !! The &material
      type(material_t), intent(in) :: material
      logical, intent(inout) :: plausible                !! False without a possible wave speed
      real(wp) :: value, ratio
      integer :: k
      logical :: possible

      if (.not. material%bulk > 0.0_wp) return
      call check_wave(deck, group, material, possible)
      plausible = plausible .and. possible
      if (.not. possible) return
      associate (keys => schema%groups(schema%find("material"))%keys)
         do k = 1, size(keys)
            if (keys(k)%unit_text /= "Pa" .or. keys(k)%number_of_values > 1) cycle
            if (any(keys(k)%name == moduli) .or. .not. group%given(keys(k)%name)) cycle
            if (any(index(keys(k)%name, other_prefixes) == 1) .and. .not. &
               any(keys(k)%name == strengths)) cycle
            call group%get(keys(k)%name, value)
            ratio = value/material%bulk
            if (keys(k)%name == "shear") then
               if (outside(ratio, most_shear)) call warn_ratio(deck, group, keys(k)%name, value, &
                  material%bulk, usual_shear)
            else if (outside(ratio, most_strength)) then
               call warn_ratio(deck, group, keys(k)%name, value, material%bulk, usual_strength)
            end if
         end do
      end associate
   end subroutine check_stresses

   !> True for a positive ratio outside the range.
   pure logical function outside(ratio, most) result(yes)
      real(wp), intent(in) :: ratio
      real(wp), intent(in) :: most                       !! End of the range

      yes = ratio > most .or. (ratio > 0.0_wp .and. ratio < least_ratio)
   end function outside

   !> Warn of a stress that does not fit the bulk modulus.
   subroutine warn_ratio(deck, group, key, value, bulk, usual)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group                 !! The &material
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: value, bulk                !! [Pa]
      real(wp), intent(in) :: usual                      !! Usual ratio of the two

      call deck%warn(group, key//" = "//brief(value)//" Pa is "//brief(value/bulk)// &
         " times the bulk modulus of "//brief(bulk)//" Pa"// &
         meant(value, abs(value)/bulk/usual, "Pa")//" [D508]", key)
   end subroutine warn_ratio

   !> Warn of a bulk modulus from an equation of state that gives no possible wave speed. Moduli
   !! given as such are checked before materials are read.
   subroutine check_wave(deck, group, material, plausible)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group                 !! The &material
      type(material_t), intent(in) :: material
      logical, intent(out) :: plausible                  !! Is the wave speed possible?
      real(wp) :: speed
      character(len=:), allocatable :: key
      integer :: k

      speed = sqrt(material%bulk/material%density)
      plausible = speed > slowest .and. speed < fastest
      if (plausible) return
      if (any([group%given("young"), group%given("bulk"), group%given("mg_c0")])) return
      key = "density"
      do k = 1, size(moduli)
         if (.not. group%given(trim(moduli(k)))) cycle
         key = trim(moduli(k))
         exit
      end do
      call deck%warn(group, key//": the bulk modulus of "//brief(material%bulk)// &
         " Pa with density = "//brief(material%density)//" kg/m3 gives a wave speed of "// &
         brief(speed)//" m/s"//meant(material%bulk, (speed/usual_speed)**2, "Pa")//" [D503]", key)
   end subroutine check_wave

   !> Warn of a velocity far above the wave speed.
   subroutine check_speed(deck, group, key, wave)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group                 !! A body, wall or inflow
      character(len=*), intent(in) :: key                !! Velocity or speed
      real(wp), intent(in) :: wave                       !! Wave speed of the material [m/s]
      real(wp) :: velocity(3)

      if (.not. (group%given(key) .and. wave > 0.0_wp)) return
      velocity = 0.0_wp
      if (key == "speed") then
         call group%get(key, velocity(1))
      else
         call group%get(key, velocity)
      end if
      associate (speed => norm2(velocity))
         if (speed <= most_mach*wave) return
         call deck%warn(group, key//" = "//brief(speed)//" m/s is "//brief(speed/wave)// &
            " times the wave speed of the material, "//brief(wave)//" m/s"// &
            meant(speed, speed/wave, "m/s")//" [D509]", key)
      end associate
   end subroutine check_speed

   !> Warn of a gravity that no planet and no centrifuge has.
   subroutine check_gravity(deck, effects)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: effects               !! &effects
      real(wp), parameter :: standard = 9.80665_wp       ! [m/s2]
      real(wp) :: gravity(3)
      logical :: acts

      call effects%get("gravity", acts)
      if (.not. (acts .and. effects%given("gravity_vector"))) return
      call effects%get("gravity_vector", gravity)
      associate (strength => norm2(gravity))
         if (strength <= most_gravity) return
         call deck%warn(effects, "gravity_vector = "//brief(strength)//" m/s2 is "// &
            brief(strength/standard)//" times that of the earth"// &
            meant(strength, strength/standard, "m/s2")//" [D512]", "gravity_vector")
      end associate
   end subroutine check_gravity

   !> The value that was probably meant: the power of a thousand that brings it closest to what is
   !! usual.
   pure function meant(value, excess, unit) result(text)
      real(wp), intent(in) :: value                      !! [SI]
      real(wp), intent(in) :: excess                     !! Value over its usual value
      character(len=*), intent(in) :: unit               !! Unit of SI
      character(len=:), allocatable :: text
      character(len=4), parameter :: factors(7) = ["1e-9", "1e-6", "1e-3", "1   ", "1e3 ", "1e6 ", &
         "1e9 "]
      integer :: power

      power = max(min(nint(-log10(excess)/3.0_wp), 3), -3)
      if (power == 0) power = merge(-1, 1, excess > 1.0_wp)
      text = "; did you mean "//brief(value*1.0e3_wp**power)//" "//unit//" (factor "// &
         trim(factors(power + 4))//")?"
   end function meant

   !> Warn of a run that makes next to no step or that does not end, and refuse one whose time could
   !! not advance.
   subroutine check_steps(deck, simulation, bodies, limits, plausible)
      type(deck_t), intent(inout) :: deck
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(limits_t), intent(in) :: limits
      logical, intent(in) :: plausible                   !! Are the wave speeds possible?
      type(group_t) :: time
      character(len=:), allocatable :: cause, word
      real(wp) :: dt, steps

      call find_first_step(simulation, bodies, limits, dt, cause)
      if (.not. (dt > 0.0_wp .and. dt < huge(dt))) return
      time = deck%group("time", 1)
      steps = limits%time_end/dt
      if (steps < fewest) then
         ! a wrong modulus is reported already
         if (plausible) call deck%warn(time, "t_end = "//brief(limits%time_end)//" s is "// &
            brief(steps)//" times the first time step, "//brief(dt)//" s"//cause// &
            ": the run makes next to no step; write a later t_end [D510]", "t_end")
         return
      end if
      call time%get("stop_when", word)
      if (time%given("max_steps") .or. time%given("wall_limit") .or. word /= "never") return
      if (steps > countable) then
         call deck%add_error(time, "t_end = "//brief(limits%time_end)//" s is "//brief(steps)// &
            " times the first time step, "//brief(dt)//" s"//cause//", so that the time could "// &
            "not advance; write an earlier t_end, or give max_steps or stop_when [D511]", "t_end")
         return
      end if
      if (plausible .and. steps > most_steps) call deck%warn(time, "t_end = "// &
         brief(limits%time_end)//" s needs about "//number(nint(steps, int64))// &
         " steps, the first of "//brief(dt)// &
         " s"//cause//"; write an earlier t_end, use larger cells, or give max_steps or "// &
         "stop_when [D511]", "t_end")
   end subroutine check_steps
end module run_plausible
