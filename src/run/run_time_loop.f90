! SPDX-License-Identifier: BSD-3-Clause
!> The time loop: steps, output, checkpoints, progress lines. The program scree makes all steps of a
!! run in one call; a host program makes them one by one.
module run_time_loop
   use base_error, only: error_t, exit_again, exit_success
   use base_kinds, only: int64, wp
   use base_log, only: log_t, progress_heading
   use base_timer, only: process_seconds, wall_seconds
   use io_checkpoint, only: checkpoint_place_t
   use output_checkpoint, only: write_checkpoint
   use output_streams, only: outputs_t
   use run_limits, only: limits_t
   use run_loop_clock, only: loop_clock_t
   use run_next_step, only: choose_step, is_step_allowed
   use run_progress, only: log_progress, log_stage, warn_if_starved
   use run_signals, only: caught_signal, watch_signal
   use run_stop_criteria, only: lost_request, none_left, stop_criteria_t, &
      wall_limit_request
   use run_threads, only: adjust_threads
   use step_advance, only: advance
   use step_load_balance, only: balance_ranks, watch_costs
   use step_simulation, only: requests_t, simulation_t
   use step_sort_particles, only: count_particles
   use step_trust, only: begin_trust, watch_trust
   implicit none
   private

   public :: time_loop_t

   character(len=*), parameter :: not_finished = "ended by the calling program"

   !> State of the time loop between two steps.
   type :: time_loop_t
      type(loop_clock_t) :: clock
      type(stop_criteria_t) :: criteria
      logical :: finished = .false.                  !! Has a criterion, or an error, ended the run?
      logical :: warned = .false.                    !! Was the lack of processor time reported?
      logical :: lost = .false. !! Has another run taken over the files? On rank 0 only
      integer :: code = exit_success                 !! Exit code
      character(len=:), allocatable :: reason        !! Why the run ended
   contains
      procedure :: begin => time_loop_begin          !! Write the first output
      procedure :: step => time_loop_step            !! Do one step
      procedure :: write_all => time_loop_write_all  !! Write all output now
      procedure :: checkpoint => time_loop_checkpoint !! Write a checkpoint now
      procedure :: end => time_loop_end              !! Write the last output
   end type time_loop_t

contains

   !> Start the clocks, write the output of the first state, and test whether it is the last one.
   !! Collective.
   subroutine time_loop_begin(self, simulation, outputs, limits, log, error)
      class(time_loop_t), intent(out) :: self
      type(simulation_t), intent(inout) :: simulation !! In its initial state
      type(outputs_t), intent(inout) :: outputs      !! Open streams
      type(limits_t), intent(in) :: limits           !! When to stop
      type(log_t), intent(inout) :: log              !! Gets progress
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written

      self%reason = not_finished
      call start_loop(simulation, limits, log, self%clock, error)
      if (allocated(error)) return
      call begin_trust(simulation)
      call write_outputs(simulation, outputs, .false., log, error)
      if (allocated(error)) return
      call test_criteria(self, simulation, outputs, limits)
   end subroutine time_loop_begin

   !> Do one step, write the outputs due after it, and test whether it was the last one. Without an
   !! error the state is the same as after a run with all steps in one call. After an error the last
   !! valid checkpoint is unchanged. Collective.
   subroutine time_loop_step(self, simulation, outputs, place, limits, log, error)
      class(time_loop_t), intent(inout) :: self      !! Not finished
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(inout) :: outputs      !! Open streams
      type(checkpoint_place_t), intent(inout) :: place !! Folder and numbers of checkpoints
      type(limits_t), intent(in) :: limits           !! When to stop
      type(log_t), intent(inout) :: log              !! Gets progress
      type(error_t), allocatable, intent(out) :: error !! The run failed
      logical :: advanced

      call advance_once(self, simulation, limits, log, advanced, error)
      if (allocated(error)) then
         call keep_state(simulation, outputs, place, log, self%clock, &
            is_step_allowed(simulation) .and. .not. advanced)
         return
      end if
      call balance_ranks(simulation, limits%balancing)
      call write_outputs(simulation, outputs, .false., log, error)
      if (allocated(error)) return
      if (simulation%machine%requests%line > 0.0_wp) call log_progress(simulation, limits, log, &
         self%clock)
      if (self%clock%is_checkpoint_due(simulation, limits)) &
         call write_logged_checkpoint(simulation, outputs, place, log, self%clock, error)
      if (allocated(error)) return
      call test_criteria(self, simulation, outputs, limits)
   end subroutine time_loop_step

   !> Advance the simulation by a step of the stable length, and check the result.
   subroutine advance_once(self, simulation, limits, log, advanced, error)
      class(time_loop_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(limits_t), intent(in) :: limits
      type(log_t), intent(inout) :: log
      logical, intent(out) :: advanced               !! Has the step begun?
      type(error_t), allocatable, intent(out) :: error !! The run failed
      real(wp) :: dt

      call choose_step(simulation, limits, dt, error)
      advanced = .not. allocated(error)
      if (allocated(error)) return
      call set_requests(simulation, limits, self%clock, self%lost)
      call watch_costs(simulation%space%tiles, simulation%clock, simulation%machine, &
         limits%balancing)
      call adjust_threads(simulation)
      call advance_timed(simulation, dt, self%clock, error)
      if (simulation%machine%requests%line > 0.0_wp) &
         call warn_if_starved(simulation, log, self%clock, self%warned)
      if (allocated(error)) return
      call watch_trust(simulation, log, error)
   end subroutine advance_once

   !> Test whether the run ends with the present state. Called once for each state.
   subroutine test_criteria(self, simulation, outputs, limits)
      class(time_loop_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(in) :: outputs         !! With the quantity of `stop_when`
      type(limits_t), intent(in) :: limits
      character(len=:), allocatable :: reason
      integer :: code

      call self%criteria%test(simulation, limits, self%finished, code, reason)
      if (.not. self%finished) then
         self%finished = outputs%stop_quantity%is_reached(simulation%clock%step)
         code = exit_success
         reason = outputs%stop_quantity%reason()
      end if
      if (.not. self%finished) return
      self%code = code
      self%reason = reason
   end subroutine test_criteria

   !> Write the present state to all streams that have not written it yet. Outputs due later do not
   !! change. Collective.
   subroutine time_loop_write_all(self, simulation, outputs, log, error)
      class(time_loop_t), intent(in) :: self
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(inout) :: outputs      !! Open streams
      type(log_t), intent(inout) :: log              !! Gets names of files
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written

      call write_outputs(simulation, outputs, .true., log, error)
   end subroutine time_loop_write_all

   !> Write a checkpoint of the present state. Collective.
   subroutine time_loop_checkpoint(self, simulation, outputs, place, log, error)
      class(time_loop_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(in) :: outputs         !! Their counters are part of the checkpoint
      type(checkpoint_place_t), intent(inout) :: place !! Folder and numbers of checkpoints
      type(log_t), intent(inout) :: log              !! Gets its name
      type(error_t), allocatable, intent(out) :: error !! Not written; older ones are unchanged

      call write_logged_checkpoint(simulation, outputs, place, log, self%clock, error)
   end subroutine time_loop_checkpoint

   !> Write the final state, and a checkpoint where one is due. Collective.
   subroutine time_loop_end(self, simulation, outputs, place, limits, log, error)
      class(time_loop_t), intent(inout) :: self      !! Without an error
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(inout) :: outputs      !! Open streams
      type(checkpoint_place_t), intent(inout) :: place !! Folder and numbers of checkpoints
      type(limits_t), intent(in) :: limits           !! When to write a checkpoint
      type(log_t), intent(inout) :: log              !! Gets warnings
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written

      call warn_if_starved(simulation, log, self%clock, self%warned)
      if (index(self%reason, none_left) == 1) call log%warn("warning: "//none_left// &
         " before t_end, through open boundaries or by removal; the ledger lists the amounts "// &
         "[R119]")
      if (self%code == exit_success) call write_outputs(simulation, outputs, .true., log, error)
      if (allocated(error)) return
      if (self%code == exit_again .or. limits%checkpoint_at_end) &
         call write_logged_checkpoint(simulation, outputs, place, log, self%clock, error)
   end subroutine time_loop_end

   !> Do one step and add its wall and processor time.
   subroutine advance_timed(simulation, dt, clock, error)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt                     !! [s]
      type(loop_clock_t), intent(inout) :: clock
      type(error_t), allocatable, intent(out) :: error
      integer(int64) :: counts(4)

      counts = simulation%machine%communicator%counts()
      simulation%machine%worked = simulation%machine%worked - process_seconds()
      clock%steps_wall = clock%steps_wall - wall_seconds()
      call advance(simulation, dt, error)
      simulation%machine%worked = simulation%machine%worked + process_seconds()
      clock%steps_wall = clock%steps_wall + wall_seconds()
      call simulation%machine%work%record(simulation%machine%communicator%counts() - counts, &
         simulation%space%tiles, simulation%fields)
   end subroutine advance_timed

   !> Start the clocks, watch the signals of the deck and write the heading of the progress lines.
   subroutine start_loop(simulation, limits, log, clock, error)
      type(simulation_t), intent(in) :: simulation
      type(limits_t), intent(in) :: limits
      type(log_t), intent(inout) :: log
      type(loop_clock_t), intent(out) :: clock
      type(error_t), allocatable, intent(out) :: error !! The end of the job is not known
      integer :: n

      call clock%start(simulation, limits, log, error)
      if (allocated(error)) return
      do n = 1, size(limits%signals)
         call watch_signal(trim(limits%signals(n)))
      end do
      call log%info(progress_heading())
   end subroutine start_loop

   !> Set the requests of this rank, which the next step sends to all ranks: to stop, and,
   !! from the clock of rank 0, a progress line or a checkpoint.
   subroutine set_requests(simulation, limits, clock, lost)
      type(simulation_t), intent(inout) :: simulation
      type(limits_t), intent(in) :: limits
      type(loop_clock_t), intent(in) :: clock
      logical, intent(in) :: lost                    !! Has another run taken over the files?
      real(wp) :: now

      now = wall_seconds()
      associate (requests => simulation%machine%requests)
         requests = requests_t(leave=real(caught_signal(), wp), present=merge(1.0_wp, 0.0_wp, &
            count_particles(simulation%stores) > 0))
         if (clock%is_wall_limit_near(simulation%clock%step)) &
            requests%leave = real(wall_limit_request, wp)
         if (lost) requests%leave = real(lost_request, wp)
         if (simulation%machine%communicator%rank > 0) return
         if (now - clock%last_line >= limits%progress) requests%line = 1.0_wp
         if (now - clock%last_checkpoint >= limits%checkpoint_wall) requests%checkpoint = 1.0_wp
      end associate
   end subroutine set_requests

   !> Write the output that is due and log its snapshots.
   subroutine write_outputs(simulation, outputs, last, log, error)
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(inout) :: outputs
      logical, intent(in) :: last                    !! Is this the final state?
      type(log_t), intent(inout) :: log
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      character(len=:), allocatable :: note

      call outputs%write_due(simulation, last, note, error)
      if (len(note) > 0) call log%info(note)
      if (allocated(simulation%space%cell)) call log_stage(simulation, log)
   end subroutine write_outputs

   !> Write a checkpoint and log it.
   subroutine write_logged_checkpoint(simulation, outputs, place, log, clock, error)
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(in) :: outputs         !! Their counters are part of the checkpoint
      type(checkpoint_place_t), intent(inout) :: place
      type(log_t), intent(inout) :: log
      type(loop_clock_t), intent(inout) :: clock     !! Gets the time and the cost
      type(error_t), allocatable, intent(out) :: error !! Not written; older ones are unchanged
      character(len=:), allocatable :: path
      character(len=24) :: step

      path = place%path()
      clock%last_checkpoint = wall_seconds()
      call write_checkpoint(simulation, outputs, place, error)
      if (allocated(error)) return
      clock%checkpoint_cost = wall_seconds() - clock%last_checkpoint
      write (step, "(i0)") simulation%clock%step
      call log%info("  checkpoint "//path(index(path, "/", back=.true.) + 1:)//" at step " &
         //trim(step))
   end subroutine write_logged_checkpoint

   !> After an error of physics: write a valid state as a checkpoint. An invalid one becomes a
   !! snapshot only, so that it does not replace valid checkpoints.
   subroutine keep_state(simulation, outputs, place, log, clock, valid)
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(inout) :: outputs
      type(checkpoint_place_t), intent(inout) :: place
      type(log_t), intent(inout) :: log
      type(loop_clock_t), intent(inout) :: clock
      logical, intent(in) :: valid                   !! Was the last step completed?
      type(error_t), allocatable :: error

      if (valid) then
         call write_logged_checkpoint(simulation, outputs, place, log, clock, error)
      else
         call write_outputs(simulation, outputs, .true., log, error)
      end if
      if (allocated(error)) call log%warn(error%message)
   end subroutine keep_state
end module run_time_loop
