! SPDX-License-Identifier: BSD-3-Clause
!> Advice on material that keeps its volume: to lower the bulk modulus of a slow flow, where a high
!! modulus causes many steps (section "Stiffness of slow flows" of doc/theory/time_step.md), and to
!! avoid locking (section "Locking: B-bar" of doc/theory/method.md).
module run_bulk_modulus_advice
   use base_kinds, only: int64, wp
   use base_text, only: number
   use law_drucker_prager, only: law_drucker_prager_t
   use law_mohr_coulomb, only: law_mohr_coulomb_t
   use law_mu_i, only: law_mu_i_t
   use law_newtonian, only: law_newtonian_t
   use material_kinds, only: may_lock
   use material_type, only: material_t
   use mesh_motion, only: motion_t
   use particle_body, only: body_t
   use run_expected_steps, only: expected_steps
   use run_limits, only: limits_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: bulk_modulus_advice, locking_advice

   real(wp), parameter :: compression = 0.01_wp      !! Proposed change of volume [1]
   real(wp), parameter :: many_steps = 10000.0_wp    !! No advice for fewer steps
   real(wp), parameter :: worthwhile = 0.25_wp       !! Greatest fraction of steps that remains

contains

   !> A line of advice, or empty.
   function bulk_modulus_advice(simulation, bodies, limits) result(text)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(limits_t), intent(in) :: limits           !! End of the run
      character(len=:), allocatable :: text
      character(len=12) :: now, then
      real(wp) :: steps, fewer, bulk
      integer :: stiffest

      text = ""
      if (limits%dt_fixed > 0.0_wp) return
      if (has_wave_loads(simulation, bodies)) return
      stiffest = fastest_body(simulation, bodies)
      if (stiffest == 0) return
      steps = expected_steps(simulation, bodies, limits)
      if (steps < many_steps) return
      associate (material => simulation%materials(bodies(stiffest)%store))
         if (.not. is_flow_material(material)) return
         bulk = load_pressure(simulation, bodies, material)/compression
         ! without loads there is no pressure from which to choose a modulus
         if (.not. bulk > 0.0_wp) return
         fewer = steps*remaining_steps(simulation, bodies, stiffest, bulk/material%bulk)
         if (.not. fewer < worthwhile*steps) return
         write (now, "(es8.1)") material%bulk
         write (then, "(es8.1)") bulk
         text = "stiffness  the bulk modulus of '"//material%name//"',"//trim(now)// &
            " Pa, sets the number of steps;"//trim(then)//" Pa"
         if (material%shear > 0.0_wp) text = text//", with the shear modulus in proportion,"
         text = text//" would take about "//number(nint(fewer, int64))//" steps, and loads "// &
            "would change volumes by about 1 % (doc/guide/running.md)"//new_line("a")
      end associate
   end function bulk_modulus_advice

   !> A line for the first material that may lock, or empty. Materials with an internal energy are
   !! left out: they are those of shocks, whose pressure exceeds the strength.
   function locking_advice(simulation) result(text)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      if (simulation%scheme%method%even .or. simulation%space%grid%dimensions == 1) return
      ! contact of a body with itself excludes it
      if (any([(allocated(simulation%fields(n)%sides), n=1, size(simulation%fields))])) return
      do n = 1, size(simulation%materials)
         associate (material => simulation%materials(n))
            if (.not. may_lock(material) .or. material%carries_energy()) cycle
            text = "locking    '"//material%name//"' keeps its volume while it deforms: few "// &
               "cells are too stiff and their pressure is noisy; antilock = 'bbar' in &method "// &
               "prevents this (doc/theory/verification_bodies.md)"//new_line("a")
            return
         end associate
      end do
   end function locking_advice

   !> True if waves or initial stresses may determine the result: then the loads are unknown here.
   pure logical function has_wave_loads(simulation, bodies) result(state)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      integer :: n

      state = allocated(simulation%effects%shaking) .or. &
         simulation%space%boundary%absorbs_waves() .or. &
         allocated(simulation%effects%exact)
      do n = 1, size(bodies)
         state = state .or. allocated(bodies(n)%formula) .or. allocated(bodies(n)%given)
      end do
   end function has_wave_loads

   !> The body with the highest signal speed, 0 without bodies.
   pure integer function fastest_body(simulation, bodies) result(fastest)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      real(wp) :: signal, greatest
      integer :: n

      fastest = 0
      greatest = 0.0_wp
      do n = 1, size(bodies)
         signal = simulation%materials(bodies(n)%store)%reference_speed() &
            + norm2(bodies(n)%velocity)
         if (signal <= greatest) cycle
         greatest = signal
         fastest = n
      end do
   end function fastest_body

   !> True for granular materials and liquids, whose bulk modulus only keeps the volume. The results
   !! of elastic bodies and gases depend on the modulus.
   pure logical function is_flow_material(material) result(flow)
      type(material_t), intent(in) :: material

      flow = .false.
      if (material%carries_energy()) return
      if (allocated(material%eos)) then
         if (material%eos%sets_bulk()) return
      end if
      if (.not. allocated(material%law)) then
         flow = .true.
         return
      end if
      select type (law => material%law)
      type is (law_drucker_prager_t)
         flow = .true.
      type is (law_mohr_coulomb_t)
         flow = .true.
      type is (law_mu_i_t)
         flow = .true.
      type is (law_newtonian_t)
         flow = .true.
      end select
   end function is_flow_material

   !> Sum of hydrostatic pressure, dynamic pressure and cohesion [Pa]. Equation (S.6).
   pure real(wp) function load_pressure(simulation, bodies, material) result(pressure)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(material_t), intent(in) :: material       !! Material of the flow
      real(wp) :: speed, head, low(3), high(3), reach(3)
      integer :: n, k

      speed = 0.0_wp
      if (allocated(simulation%space%boundary%wall)) then
         do n = 1, size(simulation%space%boundary%wall)
            speed = max(speed, wall_speed(simulation%space%boundary%wall(n)%motion))
         end do
      end if
      if (allocated(simulation%space%rigid)) then
         do n = 1, size(simulation%space%rigid%wall)
            speed = max(speed, wall_speed(simulation%space%rigid%wall(n)%motion))
         end do
      end if
      head = 0.0_wp
      do n = 1, size(bodies)
         call bodies(n)%shape%bounds(low, high)
         low = max(low, simulation%space%grid%lower)
         high = min(high, simulation%space%grid%upper)
         speed = max(speed, norm2(bodies(n)%velocity) + norm2(bodies(n)%spin)*norm2(high - low))
         if (.not. allocated(simulation%effects%gravity)) cycle
         do k = 1, 3
            reach(k) = merge(high(k) - simulation%space%grid%lower(k), &
               simulation%space%grid%upper(k) - low(k), simulation%effects%gravity(k) < 0.0_wp)
            if (simulation%space%boundary%is_periodic(2*k)) reach(k) = 0.0_wp
         end do
         head = max(head, dot_product(abs(simulation%effects%gravity), reach))
      end do
      pressure = material%density*(0.5_wp*speed**2 + head) + cohesion(material)
   end function load_pressure

   !> Shear strength of a material at zero pressure [Pa].
   pure real(wp) function cohesion(material) result(strength)
      type(material_t), intent(in) :: material

      strength = 0.0_wp
      if (.not. allocated(material%law)) return
      select type (law => material%law)
      type is (law_drucker_prager_t)
         strength = law%strength
      type is (law_mohr_coulomb_t)
         strength = law%strength
      type is (law_mu_i_t)
         strength = law%cohesion
      end select
   end function cohesion

   !> Greatest speed of a wall [m/s].
   pure real(wp) function wall_speed(motion) result(speed)
      type(motion_t), intent(in) :: motion           !! Motion of the material

      speed = norm2(motion%steady)
      if (allocated(motion%speed)) speed = speed + maxval(norm2(motion%speed, dim=1))
   end function wall_speed

   !> Fraction of the steps that remains if one material is softer.
   pure real(wp) function remaining_steps(simulation, bodies, stiffest, factor) result(fraction)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: stiffest                !! A body of this material
      real(wp), intent(in) :: factor                 !! Factor of its moduli
      real(wp) :: sound, before, after
      integer :: n

      before = 0.0_wp
      after = 0.0_wp
      do n = 1, size(bodies)
         sound = simulation%materials(bodies(n)%store)%reference_speed()
         before = max(before, sound + norm2(bodies(n)%velocity))
         if (simulation%materials(bodies(n)%store)%name == &
            simulation%materials(bodies(stiffest)%store)%name) sound = sound*sqrt(factor)
         after = max(after, sound + norm2(bodies(n)%velocity))
      end do
      fraction = after/before
   end function remaining_steps
end module run_bulk_modulus_advice
