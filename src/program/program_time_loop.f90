! SPDX-License-Identifier: BSD-3-Clause
!> Runs a simulation to its end: steps, outputs, checkpoints, signals, progress.
module program_time_loop
   use base_constants, only: unset
   use base_deck, only: deck_t, group_t
   use base_deck_group, only: unset_integer
   use base_error, only: error_t, exit_again, exit_physics, exit_success, fail
   use base_kinds, only: int64, wp
   use base_log, only: log_t, progress_heading, progress_line, progress_t
   use base_timer, only: process_seconds, wall_seconds
   use io_checkpoint, only: checkpoint_place_t
   use omp_lib, only: omp_get_max_threads
   use output_checkpoint, only: write_checkpoint
   use output_streams, only: outputs_t
   use program_job_time, only: job_seconds_left, no_job, wall_limit_of
   use program_signals, only: signal_caught, watch_signal
   use program_threads, only: adjust_threads, is_starved, starved_text
   use scene_load_balance, only: read_balancing
   use step_advance, only: advance
   use step_bounds, only: rule_deck, rule_end
   use step_ledger, only: balance_t, kinetic
   use step_load_balance, only: balance_ranks, balancing_t, watch_costs
   use step_offending_particle, only: name_limiting, replay_text
   use step_simulation, only: requests_t, simulation_t
   use step_sort_particles, only: count_particles
   use step_trust, only: begin_trust, watch_trust
   implicit none
   private

   public :: choose_step, is_finished, limits_t, read_limits, run_to_end

   integer, parameter :: out_of_time = 1000          !! A call to leave that is no signal
   character(len=*), parameter :: none_left = "all material has left the grid"
   real(wp), parameter :: scheduler_reserve = 60.0_wp !! Kept before the end of a job [s]

   !> When a run ends and when it looks after itself.
   type :: limits_t
      real(wp) :: time_end = 0.0_wp                  !! [s]
      real(wp) :: dt_max = huge(1.0_wp)              !! Greatest time step [s]
      real(wp) :: dt_min = 0.0_wp                    !! Smaller: give up [s]
      real(wp) :: dt_fixed = 0.0_wp                  !! Always this one, 0 = stable one [s]
      integer(int64) :: max_steps = huge(1_int64)    !! Stop after so many
      real(wp) :: wall_limit = huge(1.0_wp)          !! Wall time to leave after [s]
      logical :: ask_scheduler = .false.             !! Does the scheduler know that time?
      real(wp) :: kinetic_below = -1.0_wp            !! Stop when the kinetic energy falls below [J]
      real(wp) :: rest_below = -1.0_wp               !! ... or below this share of its greatest [1]
      real(wp) :: checkpoint_wall = huge(1.0_wp)     !! Wall time between checkpoints [s]
      real(wp) :: checkpoint_time = 0.0_wp           !! Simulated time between them, 0 = none [s]
      logical :: checkpoint_at_end = .true.          !! One more at the end
      character(len=:), allocatable :: signals(:)    !! Signals that ask for one
      real(wp) :: progress = 10.0_wp                 !! Wall time between lines of progress [s]
      type(balancing_t) :: balancing                 !! When tiles move between ranks
   end type limits_t

   !> What a run remembers between steps.
   type :: watch_t
      real(wp) :: begin = 0.0_wp                     !! Wall time at the start of the loop [s]
      real(wp) :: wall_limit = huge(1.0_wp)          !! Wall time to leave after [s]
      real(wp) :: last_line = 0.0_wp                 !! Of the last line of progress [s]
      real(wp) :: last_checkpoint = 0.0_wp           !! Of the last checkpoint [s]
      real(wp) :: checkpoint_cost = 0.0_wp           !! Wall time that one took [s]
      real(wp) :: time_begin = 0.0_wp                !! Simulated time at the start [s]
      integer(int64) :: step_begin = 0               !! Steps done at the start
      integer(int64) :: checkpoints = 0 !! Simulated intervals between them that are over
      integer :: signal = 0                          !! The signal that came
      real(wp) :: greatest_kinetic = 0.0_wp          !! Kinetic energy so far [J]
      real(wp) :: stepped = 0.0_wp                   !! Wall time of the steps [s]
      real(wp) :: processor_begin = 0.0_wp           !! Processor time at the start [s]
      logical :: starved = .false.                   !! Has the warning of it been given?
   end type watch_t

contains

   !> Read the limits of a run.
   subroutine read_limits(deck, limits)
      type(deck_t), intent(in) :: deck               !! The deck
      type(limits_t), intent(out) :: limits          !! What it says
      type(group_t) :: group
      character(len=:), allocatable :: word
      real(wp) :: number
      integer :: steps

      group = deck%group("time", 1)
      call group%get("t_end", limits%time_end)
      call group%get("dt_max", number)
      if (number > unset) limits%dt_max = number
      call group%get("dt_min", number)
      if (number > unset) limits%dt_min = number
      call group%get("dt_fixed", number)
      if (number > unset) limits%dt_fixed = number
      call group%get("max_steps", steps)
      if (steps /= unset_integer) limits%max_steps = steps
      call group%get("wall_limit", word)
      limits%wall_limit = wall_limit_of(word)
      limits%ask_scheduler = word == "slurm"
      call group%get("stop_when", word)
      if (word == "kinetic_below") call group%get("stop_value", limits%kinetic_below)
      if (word == "at_rest") call group%get("stop_value", limits%rest_below)
      group = deck%group("checkpoint", 1)
      call group%get("wall_minutes", number)
      if (number > 0.0_wp) limits%checkpoint_wall = 60.0_wp*number
      call group%get("dt", number)
      if (number > unset) limits%checkpoint_time = number
      call group%get("at_end", limits%checkpoint_at_end)
      call group%get("on_signal", limits%signals)
      group = deck%group("log", 1)
      call group%get("progress_seconds", limits%progress)
      call read_balancing(deck, limits%balancing)
   end subroutine read_limits

   !> Run to the end. An error leaves the last good checkpoint as it is.
   subroutine run_to_end(simulation, outputs, place, limits, log, code, reason, error)
      type(simulation_t), intent(inout) :: simulation !! The run in its first state
      type(outputs_t), intent(inout) :: outputs      !! Open streams
      type(checkpoint_place_t), intent(inout) :: place !! Where checkpoints go
      type(limits_t), intent(in) :: limits           !! When to stop
      type(log_t), intent(inout) :: log              !! Gets progress
      integer, intent(out) :: code                   !! Exit code
      character(len=:), allocatable, intent(out) :: reason !! Why it ended
      type(error_t), allocatable, intent(out) :: error !! It failed
      type(watch_t) :: watch
      real(wp) :: dt
      logical :: finished, advanced

      call begin(simulation, limits, log, watch, error)
      if (allocated(error)) return
      call begin_trust(simulation)
      call write_outputs(simulation, outputs, .false., log, error)
      if (allocated(error)) return
      finished = .false.
      code = exit_success
      do
         call judge(simulation, limits, watch, finished, code, reason)
         if (finished) exit
         call choose_step(simulation, limits, dt, error)
         advanced = .not. allocated(error)
         if (allocated(error)) exit
         call ask(simulation, limits, watch)
         call watch_costs(simulation, limits%balancing)
         call adjust_threads(simulation)
         simulation%machine%worked = simulation%machine%worked - process_seconds()
         watch%stepped = watch%stepped - wall_seconds()
         call advance(simulation, dt, error)
         simulation%machine%worked = simulation%machine%worked + process_seconds()
         watch%stepped = watch%stepped + wall_seconds()
         if (simulation%machine%requests%line > 0.0_wp) call warn_if_starved(simulation, log, watch)
         if (allocated(error)) exit
         call watch_trust(simulation, log, error)
         if (allocated(error)) exit
         call balance_ranks(simulation, limits%balancing)
         call write_outputs(simulation, outputs, .false., log, error)
         if (allocated(error)) return
         if (simulation%machine%requests%line > 0.0_wp) call tell(simulation, limits, log, watch)
         if (checkpoint_due(simulation, limits, watch)) then
            call save(simulation, outputs, place, log, watch, error)
            if (allocated(error)) return
         end if
      end do
      if (allocated(error)) then
         call keep_state(simulation, outputs, place, log, watch, &
            step_allowed(simulation) .and. .not. advanced)
         return
      end if
      call warn_if_starved(simulation, log, watch)
      if (reason == none_left) call log%warn("warning: "//none_left//" before t_end, through "// &
         "open boundaries or as it was taken out; the ledger says where")
      if (code == exit_success) call write_outputs(simulation, outputs, .true., log, error)
      if (allocated(error)) return
      if (code == exit_again .or. limits%checkpoint_at_end) &
         call save(simulation, outputs, place, log, watch, error)
   end subroutine run_to_end

   !> Clocks, signals, heading.
   subroutine begin(simulation, limits, log, watch, error)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(limits_t), intent(in) :: limits           !! Signals
      type(log_t), intent(inout) :: log              !! Gets the heading
      type(watch_t), intent(out) :: watch            !! Clocks
      type(error_t), allocatable, intent(out) :: error !! No scheduler tells when the job ends
      integer :: n

      watch%begin = wall_seconds()
      watch%processor_begin = process_seconds()
      watch%last_line = watch%begin
      watch%last_checkpoint = watch%begin
      watch%time_begin = simulation%clock%time
      watch%step_begin = simulation%clock%step
      watch%wall_limit = limits%wall_limit
      if (limits%ask_scheduler) then
         call job_seconds_left(simulation%machine%communicator, watch%wall_limit, error)
         if (allocated(error)) return
         if (watch%wall_limit >= no_job) call log%warn("warning: wall_limit = 'slurm', but "// &
            "this is no job of Slurm: the run has no limit of time")
         watch%wall_limit = watch%wall_limit - scheduler_reserve
      end if
      if (limits%checkpoint_time > 0.0_wp) &
         watch%checkpoints = int(simulation%clock%time/limits%checkpoint_time, int64)
      do n = 1, size(limits%signals)
         call watch_signal(trim(limits%signals(n)))
      end do
      call log%info(progress_heading())
   end subroutine begin

   !> What this rank asks of all in the step that comes: to leave, and, from the clock of the first
   !! rank, lines of progress and checkpoints.
   subroutine ask(simulation, limits, watch)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(limits_t), intent(in) :: limits           !! How often
      type(watch_t), intent(in) :: watch             !! Clocks
      real(wp) :: now

      now = wall_seconds()
      associate (requests => simulation%machine%requests)
         requests = requests_t(leave=real(signal_caught(), wp), &
            present=merge(1.0_wp, 0.0_wp, count_particles(simulation) > 0))
         if (now - watch%begin + reserve(simulation, watch) > watch%wall_limit) &
            requests%leave = real(out_of_time, wp)
         if (simulation%machine%communicator%rank > 0) return
         if (now - watch%last_line >= limits%progress) requests%line = 1.0_wp
         if (now - watch%last_checkpoint >= limits%checkpoint_wall) requests%checkpoint = 1.0_wp
      end associate
   end subroutine ask

   !> Is the run over, and why? All ranks agree.
   subroutine judge(simulation, limits, watch, finished, code, reason)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(limits_t), intent(in) :: limits           !! When to stop
      type(watch_t), intent(inout) :: watch          !! Clocks
      logical, intent(out) :: finished               !! Leave the loop?
      integer, intent(out) :: code                   !! Exit code
      character(len=:), allocatable, intent(out) :: reason !! Why
      integer(int64), parameter :: look_every = 20
      type(balance_t) :: now

      finished = .true.
      code = exit_success
      ! before the first step nobody has counted yet
      if (simulation%machine%requests%present < 0.0_wp) simulation%machine%requests%present = &
         merge(1.0_wp, 0.0_wp, simulation%machine%communicator%any(count_particles(simulation) > 0))
      watch%signal = nint(simulation%machine%requests%leave)
      reason = "t_end reached"
      if (simulation%clock%time >= limits%time_end*(1.0_wp - epsilon(1.0_wp))) return
      reason = "max_steps reached"
      if (simulation%clock%step >= limits%max_steps) return
      code = exit_again
      reason = "wall_limit reached"
      if (watch%signal >= out_of_time) return
      reason = "signal "//name_of(watch%signal)
      if (watch%signal > 0) return
      code = exit_success
      reason = none_left
      if (.not. simulation%machine%requests%present > 0.0_wp) return
      reason = "kinetic energy below stop_value"
      if (max(limits%kinetic_below, limits%rest_below) >= 0.0_wp .and. &
         mod(simulation%clock%step, look_every) == 0) then
         call simulation%balance%ledger%balance(simulation%machine%communicator, &
            simulation%space%grid, &
            simulation%stores, simulation%materials, now)
         watch%greatest_kinetic = max(watch%greatest_kinetic, now%entry(kinetic))
         if (now%entry(kinetic) < limits%kinetic_below) return
         if (now%entry(kinetic) < limits%rest_below*watch%greatest_kinetic) return
      end if
      finished = .false.
   end subroutine judge

   !> Is the end of a run reached before its first step? Collective.
   logical function is_finished(simulation, limits) result(finished)
      type(simulation_t), intent(inout) :: simulation !! The run with particles
      type(limits_t), intent(in) :: limits           !! When to stop
      type(watch_t) :: watch
      character(len=:), allocatable :: reason
      integer :: code

      call judge(simulation, limits, watch, finished, code, reason)
   end function is_finished

   !> Wall time that must be left for the last checkpoint: twice the last one and three steps [s].
   real(wp) function reserve(simulation, watch) result(seconds)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(watch_t), intent(in) :: watch             !! Clocks

      seconds = 2.0_wp*watch%checkpoint_cost
      if (simulation%clock%step > watch%step_begin) seconds = seconds + 3.0_wp*(wall_seconds() &
         - watch%begin)/real(simulation%clock%step - watch%step_begin, wp)
   end function reserve

   !> Name of a signal that is caught.
   pure function name_of(number) result(name)
      integer, intent(in) :: number                  !! Which signal
      character(len=:), allocatable :: name

      select case (number)
      case (2)
         name = "INT"
      case (1)
         name = "HUP"
      case (10)
         name = "USR1"
      case (12)
         name = "USR2"
      case (15)
         name = "TERM"
      case default
         name = "of another kind"
      end select
   end function name_of

   !> Length of the next step.
   subroutine choose_step(simulation, limits, dt, error)
      type(simulation_t), intent(inout) :: simulation !! The run, notes what limits the step
      type(limits_t), intent(in) :: limits           !! Bounds
      real(wp), intent(out) :: dt                    !! [s]
      type(error_t), allocatable, intent(out) :: error !! Too small
      integer :: rule

      associate (guard => simulation%clock%guard)
         dt = min(simulation%clock%dt_next, limits%dt_max)
         guard%longest = max(guard%longest, dt)
         if (dt < limits%dt_min .or. .not. step_allowed(simulation)) then
            call refuse_step(simulation, limits, dt, error)
            return
         end if
         rule = guard%rule
         if (limits%dt_max < simulation%clock%dt_next .or. limits%dt_fixed > 0.0_wp) rule = &
            rule_deck
         if (limits%dt_fixed > 0.0_wp) dt = limits%dt_fixed
         ! the last step ends at t_end; no step is left over that is shorter than rounding
         if (simulation%clock%time + dt*(1.0_wp + 1.0e-9_wp) >= limits%time_end) then
            dt = limits%time_end - simulation%clock%time
            rule = rule_end
         end if
         guard%counted = rule
         guard%steps(rule) = guard%steps(rule) + 1
      end associate
   end subroutine choose_step

   !> Is the stable step longer than nothing, and than a small share of the longest so far?
   pure logical function step_allowed(simulation) result(allowed)
      type(simulation_t), intent(in) :: simulation   !! The run

      associate (guard => simulation%clock%guard)
         allowed = simulation%clock%dt_next > 0.0_wp .and. &
            simulation%clock%dt_next >= guard%bounds%collapse*guard%longest
      end associate
   end function step_allowed

   !> Say why a step is too short, and for which particle. Collective.
   subroutine refuse_step(simulation, limits, dt, error)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(limits_t), intent(in) :: limits           !! Bounds
      real(wp), intent(in) :: dt                     !! Stable step [s]
      type(error_t), allocatable, intent(out) :: error !! Always
      character(len=:), allocatable :: culprit
      character(len=160) :: text

      if (dt < limits%dt_min) then
         write (text, "(a,es10.3,a,es10.3,a)") "the stable time step", dt, &
            " s is below dt_min =", limits%dt_min, " s"
      else
         write (text, "(a,es10.3,a,es10.3,a,es10.3,a)") "the stable time step", dt, &
            " s has fallen below dt_collapse =", simulation%clock%guard%bounds%collapse, &
            " of the longest,", simulation%clock%guard%longest, " s"
      end if
      call name_limiting(simulation, culprit)
      if (.not. step_allowed(simulation)) culprit = culprit//new_line("a")//replay_text(simulation)
      call fail(error, exit_physics, trim(text)//new_line("a")//culprit)
   end subroutine refuse_step

   !> Write what is due and say so.
   subroutine write_outputs(simulation, outputs, last, log, error)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(outputs_t), intent(inout) :: outputs      !! The streams
      logical, intent(in) :: last                    !! Final state?
      type(log_t), intent(inout) :: log              !! Told of snapshots
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      character(len=:), allocatable :: note

      call outputs%write_due(simulation, last, note, error)
      if (len(note) > 0) call log%info(note)
   end subroutine write_outputs

   !> Say once that the steps take far longer than the processor works for them.
   subroutine warn_if_starved(simulation, log, watch)
      type(simulation_t), intent(in) :: simulation   !! For the processor time
      type(log_t), intent(inout) :: log              !! Gets the warning
      type(watch_t), intent(inout) :: watch          !! Clocks

      if (watch%starved) return
      ! steps use all threads; files and tables are written by one
      call compare_clocks("the steps", watch%stepped, simulation%machine%worked, &
         omp_get_max_threads())
      call compare_clocks("the run", wall_seconds() - watch%begin, &
         process_seconds() - watch%processor_begin, 1)

   contains

      !> Warn if one part of the run had too little of the processor.
      subroutine compare_clocks(what, wall, processor, threads)
         character(len=*), intent(in) :: what        !! Part of the run
         real(wp), intent(in) :: wall                !! Its wall time [s]
         real(wp), intent(in) :: processor           !! Its processor time [s]
         integer, intent(in) :: threads              !! Threads that it uses

         if (watch%starved) return
         watch%starved = is_starved(wall, processor, threads)
         if (watch%starved) call log%warn(starved_text(what, wall, processor, threads))
      end subroutine compare_clocks
   end subroutine warn_if_starved

   !> A line of progress.
   subroutine tell(simulation, limits, log, watch)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(limits_t), intent(in) :: limits           !! The end
      type(log_t), intent(inout) :: log              !! Gets the line
      type(watch_t), intent(inout) :: watch          !! Clocks
      type(progress_t) :: progress
      type(balance_t) :: now
      real(wp) :: wall, share
      integer(int64) :: counts(2)

      wall = wall_seconds()
      watch%last_line = wall
      call simulation%balance%ledger%balance(simulation%machine%communicator, &
         simulation%space%grid, simulation%stores, &
         simulation%materials, now)
      counts = [count_particles(simulation), simulation%clock%updates]
      call simulation%machine%communicator%total(counts)
      progress%wall = wall - watch%begin
      progress%time = simulation%clock%time
      progress%time_end = limits%time_end
      progress%step = simulation%clock%step
      progress%step_length = simulation%clock%dt
      progress%kinetic = now%entry(kinetic)
      progress%energy_error = now%energy_error
      progress%particles = counts(1)
      progress%updates_per_second = real(counts(2), wp)/progress%wall
      share = (simulation%clock%time - watch%time_begin)/(limits%time_end - watch%time_begin)
      progress%seconds_left = progress%wall*(1.0_wp/share - 1.0_wp)
      call log%info(progress_line(progress))
   end subroutine tell

   !> Is a checkpoint due? All ranks agree.
   logical function checkpoint_due(simulation, limits, watch) result(due)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(limits_t), intent(in) :: limits           !! How often
      type(watch_t), intent(inout) :: watch          !! Clocks

      due = simulation%machine%requests%checkpoint > 0.0_wp
      if (limits%checkpoint_time > 0.0_wp) then
         do while (simulation%clock%time >= real(watch%checkpoints + 1, wp)*limits%checkpoint_time)
            watch%checkpoints = watch%checkpoints + 1
            due = .true.
         end do
      end if
   end function checkpoint_due

   !> Write a checkpoint and say so.
   subroutine save(simulation, outputs, place, log, watch, error)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(outputs_t), intent(in) :: outputs         !! Their counters go along
      type(checkpoint_place_t), intent(inout) :: place !! Where
      type(log_t), intent(inout) :: log              !! Told of it
      type(watch_t), intent(inout) :: watch          !! Clocks
      type(error_t), allocatable, intent(out) :: error !! Not written; older ones are intact
      character(len=:), allocatable :: path
      character(len=24) :: step

      path = place%path()
      watch%last_checkpoint = wall_seconds()
      call write_checkpoint(simulation, outputs, place, error)
      if (allocated(error)) return
      watch%checkpoint_cost = wall_seconds() - watch%last_checkpoint
      write (step, "(i0)") simulation%clock%step
      call log%info("  checkpoint "//path(index(path, "/", back=.true.) + 1:)//" at step " &
         //trim(step))
   end subroutine save

   !> After an error of physics: keep a good state as a checkpoint if that is possible, a spoiled
   !! one only as a snapshot, so that good checkpoints stay.
   subroutine keep_state(simulation, outputs, place, log, watch, good)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(outputs_t), intent(inout) :: outputs      !! Their counters go along
      type(checkpoint_place_t), intent(inout) :: place !! Where
      type(log_t), intent(inout) :: log              !! Told of it
      type(watch_t), intent(inout) :: watch          !! Clocks
      logical, intent(in) :: good                    !! Is the state good?
      type(error_t), allocatable :: error

      if (good) then
         call save(simulation, outputs, place, log, watch, error)
      else
         call write_outputs(simulation, outputs, .true., log, error)
      end if
      if (allocated(error)) call log%warn(error%message)
   end subroutine keep_state
end module program_time_loop
