! SPDX-License-Identifier: BSD-3-Clause
!> Length of the next time step: the stable one within the bounds of the deck, or an error with the
!! particle that limits it.
module run_next_step
   use base_error, only: error_t, exit_physics, fail
   use base_kinds, only: wp
   use run_limits, only: limits_t
   use step_bounds, only: rule_deck, rule_end
   use step_offending_particle, only: name_limiting, replay_text
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: choose_step, is_step_allowed

contains

   !> Choose the length of the next step. Collective if it fails.
   subroutine choose_step(simulation, limits, dt, error)
      type(simulation_t), intent(inout) :: simulation !! Counts the limits of steps
      type(limits_t), intent(in) :: limits           !! Bounds of the step
      real(wp), intent(out) :: dt                    !! [s]
      type(error_t), allocatable, intent(out) :: error !! The stable step is too short
      integer :: rule
      real(wp) :: stop

      stop = limits%time_end
      if (allocated(simulation%space%cell)) stop = min(stop, simulation%space%cell%next_end())
      associate (guard => simulation%clock%guard)
         dt = min(simulation%clock%dt_next, limits%dt_max)
         guard%longest = max(guard%longest, dt)
         if (dt < limits%dt_min .or. .not. is_step_allowed(simulation)) then
            call refuse_step(simulation, limits, dt, error)
            return
         end if
         rule = guard%rule
         if (limits%dt_max < simulation%clock%dt_next .or. limits%dt_fixed > 0.0_wp) rule = &
            rule_deck
         if (limits%dt_fixed > 0.0_wp) dt = limits%dt_fixed
         ! the last step of the run or of a stage ends exactly at its time, without a remainder of
         ! the size of rounding errors
         if (simulation%clock%time + dt*(1.0_wp + 1.0e-9_wp) >= stop) then
            dt = stop - simulation%clock%time
            rule = rule_end
         end if
         guard%counted = rule
         guard%steps(rule) = guard%steps(rule) + 1
      end associate
   end subroutine choose_step

   !> True if the stable step is positive and at least the fraction dt_collapse of the longest one.
   pure logical function is_step_allowed(simulation) result(allowed)
      type(simulation_t), intent(in) :: simulation   !! With the next stable step

      associate (guard => simulation%clock%guard)
         allowed = simulation%clock%dt_next > 0.0_wp .and. &
            simulation%clock%dt_next >= guard%bounds%collapse*guard%longest
      end associate
   end function is_step_allowed

   !> Error for a step that is too short; it names the limiting particle. Collective.
   subroutine refuse_step(simulation, limits, dt, error)
      type(simulation_t), intent(inout) :: simulation
      type(limits_t), intent(in) :: limits
      real(wp), intent(in) :: dt                     !! Stable step [s]
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: particle
      character(len=160) :: text

      if (dt < limits%dt_min) then
         write (text, "(a,es10.3,a,es10.3,a)") "the stable time step", dt, &
            " s is below dt_min =", limits%dt_min, " s [R101]"
      else
         write (text, "(a,es10.3,a,es10.3,a,es10.3,a)") "the stable time step", dt, &
            " s has fallen below dt_collapse =", simulation%clock%guard%bounds%collapse, &
            " of the longest,", simulation%clock%guard%longest, " s [R102]"
      end if
      call name_limiting(simulation, particle)
      if (.not. is_step_allowed(simulation)) particle = &
         particle//new_line("a")//replay_text(simulation%clock)
      call fail(error, exit_physics, trim(text)//new_line("a")//particle)
   end subroutine refuse_step
end module run_next_step
