! SPDX-License-Identifier: BSD-3-Clause
!> Reasons to end a run: the end of its time or of its steps, wall time, signals, kinetic energy, or
!! no remaining material.
module run_stop_criteria
   use base_error, only: exit_again, exit_file, exit_success
   use base_kinds, only: int64, wp
   use run_limits, only: limits_t
   use run_signals, only: signal_name
   use step_diagnostics, only: find_unbalanced, watch_unbalanced
   use step_ledger, only: balance_t, kinetic
   use step_simulation, only: simulation_t
   use step_sort_particles, only: count_particles
   implicit none
   private

   public :: is_finished, stop_criteria_t

   !> Stop requests other than signals
   integer, parameter, public :: wall_limit_request = 1000, lost_request = 2000
   character(len=*), parameter, public :: none_left = "all material has left the grid"
   integer(int64), parameter :: kinetic_interval = 20 !! Steps between tests of kinetic energy

   !> State of the criteria between steps.
   type :: stop_criteria_t
      real(wp) :: greatest_kinetic = 0.0_wp          !! Maximum of the kinetic energy so far [J]
      integer(int64) :: began = huge(1_int64)        !! Step since which forces are watched
   contains
      procedure :: test => stop_criteria_test        !! Test all criteria
   end type stop_criteria_t

contains

   !> Test whether the run ends before the next step. Collective; the same result on all ranks.
   subroutine stop_criteria_test(self, simulation, limits, finished, code, reason)
      class(stop_criteria_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation !! With the requests of all ranks
      type(limits_t), intent(in) :: limits           !! When to stop
      logical, intent(out) :: finished               !! Does the run end?
      integer, intent(out) :: code                   !! Exit code
      character(len=:), allocatable, intent(out) :: reason !! Reason for the end
      type(balance_t) :: balance
      real(wp) :: ratio
      integer :: request

      finished = .true.
      ! no step has counted the particles yet
      if (simulation%machine%requests%present < 0.0_wp) simulation%machine%requests%present = &
         merge(1.0_wp, 0.0_wp, &
         simulation%machine%communicator%any(count_particles(simulation%stores) > 0))
      request = nint(simulation%machine%requests%leave)
      code = exit_file
      reason = "another run took over the files of this case, so this run ended [F125]"
      if (request >= lost_request) return
      code = exit_success
      reason = "t_end reached"
      if (simulation%clock%time >= limits%time_end*(1.0_wp - epsilon(1.0_wp))) return
      reason = "max_steps reached"
      if (simulation%clock%step >= limits%max_steps) return
      code = exit_again
      reason = "wall_limit reached [R120]"
      if (request >= wall_limit_request) return
      reason = "signal "//signal_name(request)//" [R121]"
      if (request > 0) return
      code = exit_success
      reason = none_left//" [R119]"
      if (.not. simulation%machine%requests%present > 0.0_wp) return
      reason = "kinetic energy below stop_value"
      if (max(limits%kinetic_below, limits%rest_below) >= 0.0_wp .and. &
         mod(simulation%clock%step, kinetic_interval) == 0) then
         call simulation%balance%ledger%balance(simulation%machine%communicator, &
            simulation%space%grid, &
            simulation%stores, simulation%materials, balance)
         self%greatest_kinetic = max(self%greatest_kinetic, balance%entry(kinetic))
         if (balance%entry(kinetic) < limits%kinetic_below) return
         if (balance%entry(kinetic) < limits%rest_below*self%greatest_kinetic) return
      end if
      reason = "unbalanced force below stop_value"
      if (limits%unbalanced_below > 0.0_wp) then
         call watch_unbalanced(simulation%scratch)
         if (mod(simulation%clock%step, kinetic_interval) == 0 .and. &
            simulation%clock%step > self%began) then
            call find_unbalanced(simulation, ratio)
            if (ratio < limits%unbalanced_below) return
         end if
         self%began = min(self%began, simulation%clock%step)
      end if
      finished = .false.
   end subroutine stop_criteria_test

   !> True if a run ends before its first step. Collective.
   logical function is_finished(simulation, limits) result(finished)
      type(simulation_t), intent(inout) :: simulation !! With particles
      type(limits_t), intent(in) :: limits           !! When to stop
      type(stop_criteria_t) :: criteria
      character(len=:), allocatable :: reason
      integer :: code

      call criteria%test(simulation, limits, finished, code, reason)
   end function is_finished
end module run_stop_criteria
