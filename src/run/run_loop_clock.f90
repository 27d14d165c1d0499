! SPDX-License-Identifier: BSD-3-Clause
!> Clocks of the time loop: wall and processor time, and when the last checkpoint and progress line
!! were written.
module run_loop_clock
   use base_constants, only: unset
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_log, only: log_t
   use base_timer, only: process_seconds, wall_seconds
   use output_schedule, only: intervals_until
   use run_job_time, only: job_seconds_left, no_job
   use run_limits, only: limits_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: loop_clock_t

   real(wp), parameter :: scheduler_reserve = 60.0_wp !! Wall time left to the job at its end [s]

   !> Clocks of the time loop.
   type :: loop_clock_t
      real(wp) :: begin = 0.0_wp                     !! Wall time at the start of the loop [s]
      real(wp) :: processor_begin = 0.0_wp           !! Processor time at the start [s]
      real(wp) :: time_begin = 0.0_wp                !! Simulated time at the start [s]
      integer(int64) :: step_begin = 0               !! Steps done at the start
      real(wp) :: wall_limit = huge(1.0_wp)          !! Greatest wall time of the loop [s]
      real(wp) :: steps_wall = 0.0_wp                !! Wall time of the steps [s]
      real(wp) :: last_line = unset                  !! Wall time of the last progress line [s]
      real(wp) :: last_checkpoint = unset            !! Wall time of the last checkpoint [s]
      real(wp) :: checkpoint_cost = 0.0_wp           !! Wall time to write one [s]
      integer(int64) :: checkpoint_intervals = 0     !! Complete intervals of checkpoint_time
   contains
      procedure :: start => loop_clock_start         !! Start the clocks
      procedure :: is_wall_limit_near => loop_clock_is_wall_limit_near !! Does the run end now?
      procedure :: is_checkpoint_due => loop_clock_is_checkpoint_due !! Write one now?
   end type loop_clock_t

contains

   !> Start the clocks. Collective.
   subroutine loop_clock_start(self, simulation, limits, log, error)
      class(loop_clock_t), intent(out) :: self
      type(simulation_t), intent(in) :: simulation   !! In its initial state
      type(limits_t), intent(in) :: limits           !! Wall time and intervals
      type(log_t), intent(inout) :: log              !! Gets a warning outside of Slurm
      type(error_t), allocatable, intent(out) :: error !! The end of the job is not known

      self%begin = wall_seconds()
      self%processor_begin = process_seconds()
      self%last_line = self%begin
      self%last_checkpoint = self%begin
      self%time_begin = simulation%clock%time
      self%step_begin = simulation%clock%step
      self%wall_limit = limits%wall_limit
      if (limits%query_scheduler) then
         call job_seconds_left(simulation%machine%communicator, self%wall_limit, error)
         if (allocated(error)) return
         if (self%wall_limit >= no_job) call log%warn("warning: wall_limit = 'slurm' has no "// &
            "effect: this is not a Slurm job, and the wall time is not limited [R123]")
         self%wall_limit = self%wall_limit - scheduler_reserve
      end if
      if (limits%checkpoint_time > 0.0_wp) &
         self%checkpoint_intervals = intervals_until(simulation%clock%time, &
         limits%checkpoint_time, 1_int64) - 1
   end subroutine loop_clock_start

   !> True if the remaining wall time is needed for the last checkpoint. The reserve is twice the
   !! time of the last checkpoint and three steps.
   logical function loop_clock_is_wall_limit_near(self, step) result(near)
      class(loop_clock_t), intent(in) :: self
      integer(int64), intent(in) :: step             !! Steps done so far
      real(wp) :: elapsed, reserve

      elapsed = wall_seconds() - self%begin
      reserve = 2.0_wp*self%checkpoint_cost
      if (step > self%step_begin) &
         reserve = reserve + 3.0_wp*elapsed/real(step - self%step_begin, wp)
      near = elapsed + reserve > self%wall_limit
   end function loop_clock_is_wall_limit_near

   !> True if a checkpoint is due, by wall time or by simulated time. The same on all ranks.
   logical function loop_clock_is_checkpoint_due(self, simulation, limits) result(due)
      class(loop_clock_t), intent(inout) :: self     !! Counts the intervals
      type(simulation_t), intent(in) :: simulation   !! After a step
      type(limits_t), intent(in) :: limits           !! Intervals of checkpoints
      integer(int64) :: passed

      due = simulation%machine%requests%checkpoint > 0.0_wp
      if (.not. limits%checkpoint_time > 0.0_wp) return
      passed = intervals_until(simulation%clock%time, limits%checkpoint_time, &
         self%checkpoint_intervals + 1) - 1
      due = due .or. passed > self%checkpoint_intervals
      self%checkpoint_intervals = passed
   end function loop_clock_is_checkpoint_due
end module run_loop_clock
