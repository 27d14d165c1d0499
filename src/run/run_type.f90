! SPDX-License-Identifier: BSD-3-Clause
!> A run from its first state to its summary, step by step. The program scree and the library
!! (src/library) run every simulation with this module.
module run_type
   use base_agreement, only: agree
   use base_error, only: code_last, error_t, exit_again, exit_file, exit_physics, fail, &
      without_code
   use base_kinds, only: wp
   use base_log, only: log_t
   use base_process, only: is_set
   use base_timer, only: wall_seconds
   use deck_changes, only: changes_t
   use deck_reader, only: group_t
   use omp_lib, only: omp_get_max_threads
   use output_loads, only: report_loads
   use output_summary, only: summarise
   use output_walls, only: write_walls
   use run_binding, only: binding_warning
   use run_existing_results, only: lock_case, nothing_to_restart, protect_results
   use run_log_files, only: open_log
   use run_restart, only: log_restart, restart_run
   use run_resume_command, only: resume_command
   use run_setup, only: run_setup_t
   use run_threads, only: choose_threads
   use run_time_loop, only: time_loop_t
   use scene_first_state, only: make_first_state
   use step_trust, only: number_lattices
   implicit none
   private

   public :: run_t

   !> A run, or one call of the program.
   type, extends(run_setup_t) :: run_t
      type(log_t) :: log                             !! Screen and log file
      integer :: most_threads = 1                    !! Threads of a rank that are available
      type(time_loop_t) :: loop                      !! Steps of the run
      type(error_t), allocatable :: failure          !! Error that ended the run
      real(wp) :: begin = 0.0_wp                     !! Wall time at its begin [s]
      character(len=:), allocatable :: losses        !! Rank 0: what earlier files have lost
   contains
      procedure :: limit_threads => run_limit_threads !! Threads that the scene can use
      procedure :: start => run_start                !! First state, log, files
      procedure :: advance => run_advance            !! Do one step
      procedure :: end => run_end                    !! Last output and summary
   end type run_t

contains

   !> Limit the number of threads to what the scene can use.
   subroutine run_limit_threads(run)
      class(run_t), intent(inout) :: run

      run%most_threads = omp_get_max_threads()
      associate (survey => run%survey, ranks => run%simulation%machine%communicator%size)
         call choose_threads(run%most_threads, int((survey%tiles + ranks - 1)/ranks), &
            survey%particles/ranks)
      end associate
   end subroutine run_limit_threads

   !> Begin a run: particles, log, output files, output of the first state. Collective.
   subroutine run_start(run, error)
      class(run_t), intent(inout) :: run     !! Complete, without particles
      type(error_t), allocatable, intent(out) :: error !! There is no run

      logical :: fresh

      run%begin = wall_seconds()
      call start_simulation(run, fresh, error)
      if (allocated(error)) return
      call run%loop%begin(run%simulation, run%outputs, run%limits, run%log, &
         run%failure)
      ! a job that is killed before its first checkpoint finds this one when it runs again
      if (fresh .and. .not. (run%loop%finished .or. allocated(run%failure))) &
         call run%loop%checkpoint(run%simulation, run%outputs, run%place, &
         run%log, run%failure)
      if (allocated(run%failure)) run%loop%finished = .true.
   end subroutine run_start

   !> Do one step of a run that is not finished. An error finishes it. Collective.
   subroutine run_advance(run)
      class(run_t), intent(inout) :: run

      call run%lock%beat()
      run%loop%lost = run%lock%lost
      call run%loop%step(run%simulation, run%outputs, run%place, run%limits, &
         run%log, run%failure)
      if (allocated(run%failure)) run%loop%finished = .true.
   end subroutine run_advance

   !> End a run, finished or not: last output, summary, and the reason. Collective.
   subroutine run_end(run, code, error)
      class(run_t), intent(inout) :: run
      integer, intent(out) :: code                   !! Exit code
      type(error_t), allocatable, intent(out) :: error !! Reason of the failure
      type(error_t), allocatable :: late
      type(group_t) :: group
      logical :: timing

      if (allocated(run%failure)) then
         call move_alloc(run%failure, error)
      else if (run%loop%code == exit_file) then
         ! the files are those of another run, so nothing is written
         code = exit_file
         call fail(error, code, run%loop%reason)
         return
      else
         call run%loop%end(run%simulation, run%outputs, run%place, &
            run%limits, run%log, error)
         if (.not. allocated(error)) call require_progress(run, error)
      end if
      call run%outputs%close(run%simulation%machine%communicator, late)
      if (allocated(late) .and. .not. allocated(error)) call move_alloc(late, error)
      if (allocated(error)) then
         run%loop%code = error%code
         run%loop%reason = error%message
      end if
      group = run%deck%group("log")
      call group%get("timing", timing)
      associate (loop => run%loop, communicator => run%simulation%machine%communicator)
         code = loop%code
         call summarise(run%simulation, run%outputs, run%log, wall_seconds() - &
            run%begin, timing, code, without_code(loop%reason), late)
         call agree(communicator, late)
         call run%lock%release()
         ! the warning at the start is far above the end of a long log
         if (len(run%losses) > 0) call run%log%warn(run%losses)
         if (allocated(error)) return
         call run%log%info(code_last("ended     "//loop%reason))
         if (code == exit_again) call run%log%info("go on     "//resume_command( &
            communicator%size))
         call move_alloc(late, error)
      end associate
   end subroutine run_end

   !> End a chain of batch jobs each of which has time for one step only. Every run does one before
   !! it obeys a signal or its wall limit.
   subroutine require_progress(run, error)
      class(run_t), intent(in) :: run        !! At its end
      type(error_t), allocatable, intent(out) :: error !! A restart has done no more than one step
      character(len=12), parameter :: job_variables(4) = [character(len=12) :: "SLURM_JOB_ID", &
         "PBS_JOBID", "LSB_JOBID", "FLUX_JOB_ID"]
      integer :: n

      associate (loop => run%loop)
         if (loop%code /= exit_again .or. .not. run%options%restart .or. &
            run%simulation%clock%step > loop%clock%step_begin + 1) return
         if (.not. any([(is_set(trim(job_variables(n))), n=1, size(job_variables))])) return
         call fail(error, exit_physics, without_code(loop%reason)//" during the first step "// &
            "after a restart, so further jobs would do one step each: give the job more time, "// &
            "or raise wall_limit of &time; then run it again [R137]")
      end associate
   end subroutine require_progress

   !> Make or read the particles, and open the log and the output files.
   subroutine start_simulation(run, fresh, error)
      class(run_t), intent(inout) :: run
      logical, intent(out) :: fresh                  !! Is it a restart without results?
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: note, warning
      type(changes_t) :: changes

      ! before the log is opened: a run that is refused changes no file of the previous one
      call lock_case(run, run%log, error)
      if (allocated(error)) return
      call protect_results(run, fresh, error)
      if (allocated(error)) return
      if (run%options%restart) call restart_run(run, note, changes, error)
      if (allocated(error)) return
      call open_log(run, run%most_threads, run%log, error)
      if (allocated(error)) return
      warning = binding_warning(run%simulation%machine%communicator, run%most_threads)
      if (len(warning) > 0) call run%log%warn(warning)
      if (fresh) call run%log%info(nothing_to_restart)
      if (run%options%restart) then
         call log_restart(run%log, note, changes)
      else
         call make_first_state(run%simulation, run%bodies, run%survey, &
            run%shapes, error)
      end if
      if (allocated(error)) return
      call report_loads(run%simulation, run%log)
      call number_lattices(run%simulation%space%grid, run%simulation%effects, &
         run%simulation%balance%trust, run%bodies)
      call free_shapes(run)
      call run%outputs%open(run%simulation, run%options%restart, run%losses, error)
      if (allocated(error)) return
      if (len(run%losses) > 0) call run%log%warn(run%losses)
      if (run%outputs%has_series()) call write_walls(run%simulation, &
         run%outputs, run%outputs%folder, run%limits%time_end, error)
   end subroutine start_simulation

   !> Free voxels, facets and lists of points and tiles, which only the first state needs.
   subroutine free_shapes(run)
      class(run_t), intent(inout) :: run
      integer :: n

      deallocate (run%shapes, run%survey%key, run%survey%particles_of)
      do n = 1, size(run%bodies)
         if (allocated(run%bodies(n)%shape%shape)) deallocate (run%bodies(n)%shape%shape)
         if (allocated(run%bodies(n)%given)) deallocate (run%bodies(n)%given)
      end do
   end subroutine free_shapes
end module run_type
