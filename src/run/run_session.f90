! SPDX-License-Identifier: BSD-3-Clause
!> A run from its first state to its summary, step by step. The program scree and the library
!! (src/library) run every simulation with this module.
module run_session
   use base_agreement, only: agree
   use base_error, only: error_t, exit_again, exit_file, exit_physics, fail
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
   use run_resume_command, only: resume_command
   use run_binding, only: binding_warning
   use run_existing_results, only: lock_case, nothing_to_restart, protect_results
   use run_log_files, only: open_log
   use run_messages, only: with_code
   use run_restart, only: log_restart, restart_run
   use run_setup, only: run_setup_t
   use run_threads, only: choose_threads
   use run_time_loop, only: time_loop_t
   use scene_first_state, only: make_first_state
   use step_trust, only: number_lattices
   implicit none
   private

   public :: advance_run, begin_run, end_run, limit_threads, session_t

   !> State of one run, or of one call of the program.
   type, extends(run_setup_t) :: session_t
      type(log_t) :: log                             !! Screen and log file
      integer :: most_threads = 1                    !! Threads of a rank that are available
      character(len=:), allocatable :: preview_folder !! Preview that is to be drawn
      type(time_loop_t) :: loop                      !! Steps of the run
      type(error_t), allocatable :: failure          !! Error that ended the run
      real(wp) :: begin = 0.0_wp                     !! Wall time at its begin [s]
      character(len=:), allocatable :: losses        !! Rank 0: what earlier files have lost
   end type session_t

contains

   !> Limit the number of threads to what the scene can use.
   subroutine limit_threads(session)
      class(session_t), intent(inout) :: session

      session%most_threads = omp_get_max_threads()
      associate (survey => session%survey, ranks => session%simulation%machine%communicator%size)
         call choose_threads(session%most_threads, int((survey%tiles + ranks - 1)/ranks), &
            survey%particles/ranks)
      end associate
   end subroutine limit_threads

   !> Begin a run: particles, log, output files, output of the first state. Collective.
   subroutine begin_run(session, error)
      class(session_t), intent(inout) :: session     !! Complete, without particles
      type(error_t), allocatable, intent(out) :: error !! There is no run

      logical :: fresh

      session%begin = wall_seconds()
      call start_simulation(session, fresh, error)
      if (allocated(error)) return
      call session%loop%begin(session%simulation, session%outputs, session%limits, session%log, &
         session%failure)
      ! a job that is killed before its first checkpoint finds this one when it runs again
      if (fresh .and. .not. (session%loop%finished .or. allocated(session%failure))) &
         call session%loop%checkpoint(session%simulation, session%outputs, session%place, &
         session%log, session%failure)
      if (allocated(session%failure)) session%loop%finished = .true.
   end subroutine begin_run

   !> Do one step of a run that is not finished. An error finishes it. Collective.
   subroutine advance_run(session)
      class(session_t), intent(inout) :: session

      call session%lock%beat()
      session%loop%lost = session%lock%lost
      call session%loop%step(session%simulation, session%outputs, session%place, session%limits, &
         session%log, session%failure)
      if (allocated(session%failure)) session%loop%finished = .true.
   end subroutine advance_run

   !> End a run, finished or not: last output, summary, and the reason. Collective.
   subroutine end_run(session, code, error)
      class(session_t), intent(inout) :: session
      integer, intent(out) :: code                   !! Exit code
      type(error_t), allocatable, intent(out) :: error !! Reason of the failure
      type(error_t), allocatable :: late
      type(group_t) :: group
      logical :: timing

      if (allocated(session%failure)) then
         call move_alloc(session%failure, error)
      else if (session%loop%code == exit_file) then
         ! the files are those of another run, so nothing is written
         code = exit_file
         call fail(error, code, session%loop%reason)
         return
      else
         call session%loop%end(session%simulation, session%outputs, session%place, &
            session%limits, session%log, error)
         if (.not. allocated(error)) call require_progress(session, error)
      end if
      call session%outputs%close(session%simulation%machine%communicator, late)
      if (allocated(late) .and. .not. allocated(error)) call move_alloc(late, error)
      if (allocated(error)) then
         session%loop%code = error%code
         session%loop%reason = error%message
      end if
      group = session%deck%group("log")
      call group%get("timing", timing)
      associate (loop => session%loop, communicator => session%simulation%machine%communicator)
         code = loop%code
         call summarise(session%simulation, session%outputs, session%log, wall_seconds() - &
            session%begin, timing, code, loop%reason, late)
         call agree(communicator, late)
         call session%lock%release()
         ! the warning at the start is far above the end of a long log
         if (len(session%losses) > 0) call session%log%warn(session%losses)
         if (allocated(error)) return
         call session%log%info(with_code("ended     "//loop%reason))
         if (code == exit_again) call session%log%info("go on     "//resume_command( &
            communicator%size))
         call move_alloc(late, error)
      end associate
   end subroutine end_run

   !> End a chain of batch jobs each of which has time for one step only. Every run does one before
   !! it obeys a signal or its wall limit.
   subroutine require_progress(session, error)
      class(session_t), intent(in) :: session        !! At its end
      type(error_t), allocatable, intent(out) :: error !! A restart has done no more than one step
      character(len=12), parameter :: job_variables(4) = [character(len=12) :: "SLURM_JOB_ID", &
         "PBS_JOBID", "LSB_JOBID", "FLUX_JOB_ID"]
      integer :: n

      associate (loop => session%loop)
         if (loop%code /= exit_again .or. .not. session%command%restart .or. &
            session%simulation%clock%step > loop%clock%step_begin + 1) return
         if (.not. any([(is_set(trim(job_variables(n))), n=1, size(job_variables))])) return
         call fail(error, exit_physics, loop%reason//" during the first step after a restart, "// &
            "so further jobs would do one step each: give the job more time, or raise "// &
            "or raise wall_limit of &time; then run it again [R137]")
      end associate
   end subroutine require_progress

   !> Make or read the particles, and open the log and the output files.
   subroutine start_simulation(session, fresh, error)
      class(session_t), intent(inout) :: session
      logical, intent(out) :: fresh                  !! Is it a restart without results?
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: note, warning
      type(changes_t) :: changes

      ! before the log is opened: a run that is refused changes no file of the previous one
      call lock_case(session, session%log, error)
      if (allocated(error)) return
      call protect_results(session, fresh, error)
      if (allocated(error)) return
      if (session%command%restart) call restart_run(session, note, changes, error)
      if (allocated(error)) return
      call open_log(session, session%most_threads, session%log, error)
      if (allocated(error)) return
      warning = binding_warning(session%simulation%machine%communicator, session%most_threads)
      if (len(warning) > 0) call session%log%warn(warning)
      if (fresh) call session%log%info(nothing_to_restart)
      if (session%command%restart) then
         call log_restart(session%log, note, changes)
      else
         call make_first_state(session%simulation, session%bodies, session%survey, &
            session%shapes, error)
      end if
      if (allocated(error)) return
      call report_loads(session%simulation, session%log)
      call number_lattices(session%simulation, session%bodies)
      call free_shapes(session)
      call session%outputs%open(session%simulation, session%command%restart, session%losses, error)
      if (allocated(error)) return
      if (len(session%losses) > 0) call session%log%warn(session%losses)
      if (session%outputs%has_series()) call write_walls(session%simulation, &
         session%outputs, session%outputs%folder, session%limits%time_end, error)
   end subroutine start_simulation

   !> Free voxels, facets and lists of points and tiles, which only the first state needs.
   subroutine free_shapes(session)
      class(session_t), intent(inout) :: session
      integer :: n

      deallocate (session%shapes, session%survey%key, session%survey%particles_of)
      do n = 1, size(session%bodies)
         if (allocated(session%bodies(n)%shape%shape)) deallocate (session%bodies(n)%shape%shape)
         if (allocated(session%bodies(n)%given)) deallocate (session%bodies(n)%given)
      end do
   end subroutine free_shapes
end module run_session
