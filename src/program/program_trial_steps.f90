! SPDX-License-Identifier: BSD-3-Clause
!> Runs steps to measure their cost. The simulation is not used afterwards.
module program_trial_steps
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_timer, only: process_seconds, wall_seconds
   use run_limits, only: limits_t
   use run_next_step, only: choose_step
   use step_advance, only: advance
   use step_exact_error, only: measure_errors
   use step_ledger, only: balance_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: time_history_row, trial_t, run_trial

   integer, parameter, public :: warm_steps = 3      !! Not measured: the first steps load caches
   real(wp), parameter :: timeable = 0.1_wp          !! Least processor time of a measurement [s]

   !> Cost of a run from its start to a time.
   type :: mark_t
      real(wp) :: time = 0.0_wp                      !! [s]
      real(wp) :: processor = 0.0_wp !! Processor time of all threads since the start [s]
      real(wp) :: wall = 0.0_wp                      !! Wall time since then [s]
      integer :: steps = 0                           !! Steps done
   end type mark_t

   !> Costs of a trial.
   type :: trial_t
      type(mark_t) :: first                          !! After the warm steps, or at the time `from`
      type(mark_t) :: middle                         !! At the time `to`
      type(mark_t) :: clocked                        !! At `to` or later, after least time
      type(mark_t) :: last                           !! At the end of the trial
      logical :: whole = .false.                     !! Did the trial reach the end of the run?
   end type trial_t

contains

   !> Run steps to the end of the run or of the allowed wall time. Costs are processor time, which
   !! other programs on the machine hardly change.
   subroutine run_trial(simulation, limits, patience, trial, from, to)
      type(simulation_t), intent(inout) :: simulation !! In its initial state, which is lost
      type(limits_t), intent(in) :: limits           !! End of the run
      real(wp), intent(in) :: patience               !! Allowed wall time [s]
      type(trial_t), intent(out) :: trial            !! Costs of the steps
      real(wp), intent(in), optional :: from         !! Time of the first mark [s]
      real(wp), intent(in), optional :: to           !! Time of the middle one [s]
      type(error_t), allocatable :: error
      real(wp) :: begin, start, spent, dt
      logical :: marked(2), timed

      begin = wall_seconds()
      start = process_seconds()
      marked = .false.
      timed = .false.
      do
         if (simulation%clock%time >= limits%time_end*(1.0_wp - epsilon(1.0_wp)) .or. &
            simulation%clock%step >= limits%max_steps) then
            trial%whole = .true.
            exit
         end if
         spent = wall_seconds() - begin
         if (trial%last%steps > warm_steps .and. spent > patience) exit
         call choose_step(simulation, limits, dt, error)
         if (allocated(error)) exit
         call advance(simulation, dt, error)
         if (allocated(error)) exit
         trial%last = mark_t(simulation%clock%time, process_seconds() - start, wall_seconds() - &
            begin, &
            trial%last%steps + 1)
         if (present(from)) then
            if (simulation%clock%time >= from .and. .not. marked(1)) trial%first = trial%last
            if (simulation%clock%time >= to .and. .not. marked(2)) trial%middle = trial%last
            marked = marked .or. simulation%clock%time >= [from, to]
            if (.not. timed .and. marked(2)) then
               trial%clocked = trial%last
               timed = trial%last%processor - trial%first%processor >= timeable
            end if
         else if (trial%last%steps == warm_steps) then
            trial%first = trial%last
         end if
      end do
   end subroutine run_trial

   !> Processor time of one row of the history [s].
   real(wp) function time_history_row(simulation) result(seconds)
      type(simulation_t), intent(inout) :: simulation !! With particles
      type(balance_t) :: now
      real(wp) :: begin

      begin = process_seconds()
      call simulation%balance%ledger%balance(simulation%machine%communicator, &
         simulation%space%grid, simulation%stores, &
         simulation%materials, now)
      if (allocated(simulation%effects%exact)) call measure_errors(simulation)
      seconds = process_seconds() - begin
   end function time_history_row
end module program_trial_steps
