! SPDX-License-Identifier: BSD-3-Clause
!> The program: from the command line to the exit code. The only place that prints errors.
module program_main
   use base_agreement, only: agree
   use base_communicator, only: communicator_t, message_passing_version
   use base_deck, only: group_t
   use base_error, only: error_t, exit_again, exit_file, exit_success, fail
   use base_kinds, only: wp
   use base_log, only: log_debug, log_error, log_info, log_t, log_warn
   use base_schema_text, only: explain, template
   use base_text, only: append
   use base_timer, only: wall_seconds
   use base_version, only: build_type, compiler_flags, compiler_name, compiler_version_text, &
      git_commit, version_text
   use io_deck_changes, only: changes_t
   use io_digest, only: file_digest
   use io_file, only: join_path, make_folder, write_file
   use io_former_run, only: find_former_run, former_run_t, is_own_checkpoint, remove_former_run
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use omp_lib, only: omp_get_max_threads
   use output_checkpoint, only: resume
   use output_summary, only: summarise
   use output_walls, only: write_walls
   use program_batch_job, only: job_text, resume_command
   use program_command_line, only: command_t, help_text, parse, program_arguments
   use program_cost, only: cost_text
   use program_examples, only: copied_t, copy_example, examples_text, next_steps
   use program_lists, only: list_text
   use program_material_point, only: drive_point
   use program_plan, only: declare_all, lay_out, plan_t, read_plan
   use program_preview, only: draw_preview, write_preview
   use program_signals, only: outlive_file_limit
   use program_step_count, only: expected_steps
   use program_threads, only: choose_threads, share_cores, threads_text, yield_when_waiting
   use program_time_estimate, only: estimate_text, most_particles
   use program_time_loop, only: is_finished, run_to_end
   use scene_deck_check, only: check_case
   use scene_effects, only: effects_text
   use scene_first_state, only: begin_run
   use step_trust, only: number_lattices
   implicit none
   private

   public :: run_program

   !> All that one call of the program holds.
   type, extends(plan_t) :: session_t
      type(log_t) :: log                             !! Screen and log file
      integer :: most_threads = 1                    !! Threads of a rank at most
      character(len=:), allocatable :: previewed     !! Folder of a preview that is to be drawn
   end type session_t

contains

   !> Do what the command line says.
   subroutine run_program(code)
      integer, intent(out) :: code                   !! Exit code
      type(session_t) :: session
      type(error_t), allocatable :: error

      code = exit_success
      call outlive_file_limit()
      call parse(program_arguments(), session%command, error)
      if (.not. allocated(error)) then
         if (only_talks(session%command)) then
            call talk(session, error)
         else if (allocated(session%command%example)) then
            call begin_folder(session, error)
         else
            call compute(session, code, error)
         end if
      end if
      if (allocated(error)) then
         code = error%code
         if (session%simulation%machine%communicator%rank == 0) call &
            session%log%error(error%message)
      end if
      call session%log%close()
      call session%simulation%machine%communicator%finish()
      if (allocated(session%previewed) .and. session%simulation%machine%communicator%rank == 0) &
         call draw(session)
   end subroutine run_program

   !> Draw a preview.
   subroutine draw(session)
      type(session_t), intent(in) :: session         !! Its files are written
      character(len=:), allocatable :: text

      flush (output_unit)
      call draw_preview(session%previewed, session%command%quiet, text)
      if (len(text) > 0) write (output_unit, "(a)") text
   end subroutine draw

   !> Is nothing asked for but text?
   pure logical function only_talks(command) result(talks)
      type(command_t), intent(in) :: command         !! The command line

      talks = command%help .or. command%version .or. command%template .or. &
         allocated(command%explain) .or. allocated(command%list) .or. allocated(command%digest)
   end function only_talks

   !> Print what was asked for. Needs no message passing.
   subroutine talk(session, error)
      type(session_t), intent(inout) :: session      !! The command line
      type(error_t), allocatable, intent(out) :: error !! Nothing to say
      character(len=:), allocatable :: text
      character(len=16) :: digest

      call declare_all(session%schema)
      associate (command => session%command)
         if (command%help) then
            text = help_text()
         else if (command%version) then
            text = version_line()
         else if (command%template) then
            text = template(session%schema)
         else if (allocated(command%explain)) then
            call explain(session%schema, command%explain, text, error)
         else if (allocated(command%list)) then
            if (command%list == "examples") then
               call examples_text(text, error)
            else
               text = list_text(command%list, session%schema)
            end if
         else
            call file_digest(session%simulation%machine%communicator, command%digest, digest, error)
            text = digest
         end if
      end associate
      if (allocated(error)) return
      if (text(max(len(text), 1):) == new_line("a")) text = text(:len(text) - 1)
      write (output_unit, "(a)") text
   end subroutine talk

   !> Copy an example into a folder of its own, with the script of a job.
   subroutine begin_folder(session, error)
      type(session_t), intent(inout) :: session      !! The command line
      type(error_t), allocatable, intent(out) :: error !! No such example, or not writable
      character(len=*), parameter :: job_file = "job.slurm"
      character(len=:), allocatable :: text
      type(copied_t) :: copied

      call copy_example(session%command%example, session%command%folder, copied, error)
      if (allocated(error)) return
      session%command%deck = join_path(copied%folder, copied%deck)
      session%command%job = "slurm"
      call read_plan(session, error)
      if (.not. allocated(error)) call lay_out(session, error)
      if (.not. allocated(error)) call job_text(session, copied%deck, text, error)
      if (.not. allocated(error)) &
         call write_file(join_path(copied%folder, job_file), text, error)
      if (allocated(error)) return
      call append(copied%files, job_file)
      write (output_unit, "(a)", advance="no") next_steps(copied)
   end subroutine begin_folder

   !> Print the script of a job.
   subroutine print_job(session, error)
      type(session_t), intent(in) :: session         !! The deck
      type(error_t), allocatable, intent(out) :: error !! It could not be called back
      character(len=:), allocatable :: text

      call job_text(session, session%command%deck, text, error)
      if (.not. allocated(error)) write (output_unit, "(a)", advance="no") text
   end subroutine print_job

   !> Version of everything that decides the numbers.
   function version_line() result(text)
      character(len=:), allocatable :: text

      text = "scree "//version_text//" (git "//git_commit//")  "//compiler_name//" " &
         //compiler_version_text//" "//build_type//" "//compiler_flags//"  " &
         //message_passing_version()
   end function version_line

   !> Read the deck, build the run, and run or check it.
   subroutine compute(session, code, error)
      type(session_t), intent(inout) :: session      !! The command line is known
      integer, intent(out) :: code                   !! Exit code
      type(error_t), allocatable, intent(out) :: error !! What stopped it

      code = exit_success
      call share_cores()
      call yield_when_waiting(program_arguments())
      if (.not. (session%command%check .or. session%command%point .or. &
         allocated(session%command%job))) call session%simulation%machine%communicator%start()
      call read_plan(session, error)
      if (allocated(error)) return
      if (session%command%point) then
         call move_point(session, error)
         return
      end if
      call lay_out(session, error)
      if (allocated(error)) return
      call limit_threads(session)
      if (allocated(session%command%job)) then
         call print_job(session, error)
         return
      end if
      if (session%command%check) then
         write (output_unit, "(a)") session%deck%report()
         write (output_unit, "(a)", advance="no") effects_text(session%deck)
         write (output_unit, "(a)", advance="no") cost_text(session%simulation, session%bodies, &
            session%survey, session%limits, session%outputs%expected(session%limits%time_end))
         call warn_of_results(session)
         if (session%command%estimate .and. session%survey%particles <= most_particles) &
            call try_out(session, error)
         return
      end if
      if (session%command%preview) then
         call write_preview(session, session%previewed, error)
         if (allocated(error)) deallocate (session%previewed)
         return
      end if
      call perform(session, code, error)
   end subroutine compute

   !> No more threads than the scene keeps busy.
   subroutine limit_threads(session)
      type(session_t), intent(inout) :: session      !! Laid out

      session%most_threads = omp_get_max_threads()
      associate (survey => session%survey, ranks => session%simulation%machine%communicator%size)
         call choose_threads(session%most_threads, (size(survey%key) + ranks - 1)/ranks, &
            survey%particles/ranks)
      end associate
   end subroutine limit_threads

   !> Run a few steps, write nothing, and say how long the whole will take.
   subroutine try_out(session, error)
      type(session_t), intent(inout) :: session      !! Checked
      type(error_t), allocatable, intent(out) :: error !! The bodies cannot begin
      character(len=:), allocatable :: text

      call estimate_text(session, text, error)
      if (.not. allocated(error)) write (output_unit, "(a)", advance="no") text
   end subroutine try_out

   !> Drive one material point.
   subroutine move_point(session, error)
      type(session_t), intent(inout) :: session      !! The deck
      type(error_t), allocatable, intent(out) :: error !! What stopped it
      character(len=:), allocatable :: note

      call check_case(session%deck)
      call session%deck%verdict(error)
      if (allocated(error)) return
      call drive_point(session%deck, session%command%output_folder, note, error)
      if (.not. allocated(error)) write (output_unit, "(a)") note
   end subroutine move_point

   !> Make or read the particles, run, and sum up.
   subroutine perform(session, code, error)
      type(session_t), intent(inout) :: session      !! Everything but particles
      integer, intent(out) :: code                   !! Exit code
      type(error_t), allocatable, intent(out) :: error !! What stopped it
      character(len=:), allocatable :: note, reason
      type(error_t), allocatable :: late
      type(changes_t) :: changes
      type(group_t) :: group
      logical :: timing
      real(wp) :: begin

      begin = wall_seconds()
      code = exit_success
      session%simulation%clock%guard%expected = expected_steps(session%simulation, session%bodies, &
         session%limits)
      ! a run that cannot go on leaves the files of the one before as they are
      call guard_results(session, error)
      if (allocated(error)) return
      if (session%command%restart) call go_on(session, note, changes, error)
      if (allocated(error)) return
      call open_files(session, error)
      if (allocated(error)) return
      if (session%command%restart) then
         call tell_restart(session%log, note, changes)
      else
         call begin_run(session%simulation, session%bodies, session%survey, session%shapes, error)
      end if
      if (allocated(error)) return
      call number_lattices(session%simulation, session%bodies)
      call forget_shapes(session)
      call session%outputs%open(session%simulation, session%command%restart, note, error)
      if (allocated(error)) return
      if (len(note) > 0) call session%log%warn(note//"left out of the series; the run goes on")
      if (size(session%outputs%snapshots) > 0) call write_walls(session%simulation, &
         session%outputs, session%outputs%folder, session%limits%time_end, error)
      if (allocated(error)) return
      call run_to_end(session%simulation, session%outputs, session%place, session%limits, &
         session%log, code, reason, error)
      if (allocated(error)) then
         code = error%code
         reason = error%message
      end if
      call session%outputs%close(session%simulation%machine%communicator, late)
      if (allocated(late) .and. .not. allocated(error)) then
         call move_alloc(late, error)
         code = error%code
         reason = error%message
      end if
      group = session%deck%group("log")
      call group%get("timing", timing)
      call summarise(session%simulation, session%outputs, session%log, wall_seconds() - begin, &
         timing, code, reason, late)
      call agree(session%simulation%machine%communicator, late)
      if (.not. allocated(error)) then
         call session%log%info("ended     "//reason)
         if (code == exit_again) call session%log%info("go on     "//resume_command( &
            session%simulation%machine%communicator%size))
         call move_alloc(late, error)
      end if
   end subroutine perform

   !> From where a run goes on, and with what changes of its deck.
   subroutine tell_restart(log, note, changes)
      type(log_t), intent(inout) :: log              !! Gets the lines
      character(len=*), intent(in) :: note           !! From where, after files passed over
      type(changes_t), intent(in) :: changes         !! What differs in the deck of the checkpoint

      if (index(note, new_line("a")) > 0) then
         call log%warn(note)
      else
         call log%info(note)
      end if
      if (len(changes%physics) > 0) call log%warn("warning: the rest of the run follows other "// &
         "rules than its beginning (in SI):"//changes%physics)
      if (len(changes%end//changes%extent//changes%nothing) > 0) call log%info( &
         "the deck has changed since (in SI):"//changes%end//changes%extent//changes%nothing)
   end subroutine tell_restart

   !> Folder, log and echo. Nothing is written before the deck is known to be right.
   subroutine open_files(session, error)
      type(session_t), intent(inout) :: session      !! Gets a log
      type(error_t), allocatable, intent(out) :: error !! Folder or file cannot be written
      character(len=:), allocatable :: line, stem
      character(len=16) :: ranks, threads

      associate (communicator => session%simulation%machine%communicator, outputs => &
         session%outputs)
         if (communicator%rank == 0) call make_folder(outputs%folder, error)
         call agree(communicator, error)
         if (allocated(error)) return
         stem = outputs%folder//"/"//outputs%case
         call session%log%open(communicator%rank, stem//".log", log_level(session), &
            session%command%quiet, error)
         call agree(communicator, error)
         if (allocated(error)) return
         write (ranks, "(i0)") communicator%size
         write (threads, "(i0)") omp_get_max_threads()
         call session%log%info(version_line())
         call session%log%info("deck      "//session%command%deck//"  case "//outputs%case//"  "// &
            trim(ranks)//" ranks x "//trim(threads)//" threads  results "//outputs%folder)
         associate (survey => session%survey)
            line = threads_text(session%most_threads, &
               (size(survey%key) + communicator%size - 1)/communicator%size, &
               survey%particles/communicator%size)
         end associate
         if (len(line) > 0) call session%log%info(line)
         if (session%deck%warnings() > 0) call session%log%warn(session%deck%report())
         call session%log%info(effects_text(session%deck)// &
            cost_text(session%simulation, session%bodies, session%survey, &
            session%limits, outputs%expected(session%limits%time_end)))
         if (communicator%rank == 0) call write_file(stem//".echo.nml", session%deck%echo(), error)
         call agree(communicator, error)
      end associate
   end subroutine open_files

   !> Greatest level that the log keeps.
   integer function log_level(session) result(level)
      type(session_t), intent(in) :: session         !! Deck and command line
      type(group_t) :: group
      character(len=:), allocatable :: word

      group = session%deck%group("log")
      call group%get("level", word)
      select case (word)
      case ("error")
         level = log_error
      case ("warn")
         level = log_warn
      case ("debug")
         level = log_debug
      case default
         level = log_info
      end select
      if (session%command%verbose) level = log_debug
   end function log_level

   !> Results of a former run are lost only if the user says so: refuse to begin, or remove them.
   subroutine guard_results(session, error)
      type(session_t), intent(in) :: session         !! Ready to begin
      type(error_t), allocatable, intent(out) :: error !! There are results, or they cannot go
      type(former_run_t) :: former

      associate (communicator => session%simulation%machine%communicator, command => &
         session%command, &
         outputs => session%outputs)
         if (communicator%rank == 0) then
            call find_former_run(outputs%folder, outputs%case, outputs%header%echo, former)
            if (command%restart) then
               if (former%results .and. allocated(command%checkpoint)) then
                  if (.not. is_own_checkpoint(outputs%folder, outputs%case, &
                     command%checkpoint)) call fail(error, exit_file, results_text(session)// &
                     " and '"//command%checkpoint//"' is not of that run; give another "// &
                     "--outdir or --case")
               end if
            else if (command%overwrite) then
               call remove_former_run(outputs%folder, former, error)
            else if (former%results) then
               call fail(error, exit_file, results_text(session)//ways_on(former))
            end if
         end if
         call agree(communicator, error)
      end associate
   end subroutine guard_results

   !> Say in a check that a run would find results.
   subroutine warn_of_results(session)
      type(session_t), intent(in) :: session         !! Checked
      type(former_run_t) :: former

      if (session%command%overwrite) return
      call find_former_run(session%outputs%folder, session%outputs%case, &
         session%outputs%header%echo, former)
      if (former%results) write (output_unit, "(a)") "warning: "//results_text(session)// &
         ways_on(former)
   end subroutine warn_of_results

   !> Whose results are where.
   function results_text(session) result(text)
      type(session_t), intent(in) :: session         !! For case and folder
      character(len=:), allocatable :: text

      text = "results of case '"//session%outputs%case//"' are in '"// &
         session%outputs%folder//"' already"
   end function results_text

   !> What a user can do where there are results.
   pure function ways_on(former) result(text)
      type(former_run_t), intent(in) :: former       !! The results
      character(len=:), allocatable :: text

      if (former%checkpoints) then
         text = ": go on with --restart, or remove them with --overwrite"
      else
         text = ", without a checkpoint to go on from: remove them with --overwrite"
      end if
      text = text//"; or give another --outdir or --case"
   end function ways_on

   !> Particles from a checkpoint.
   subroutine go_on(session, note, changes, error)
      type(session_t), intent(inout) :: session      !! Gets particles
      character(len=:), allocatable, intent(out) :: note !! What the log should say
      type(changes_t), intent(out) :: changes        !! What differs in the deck of the checkpoint
      type(error_t), allocatable, intent(out) :: error !! No checkpoint can be read, or no step
      character(len=:), allocatable :: file
      logical :: late

      file = ""
      if (allocated(session%command%checkpoint)) file = session%command%checkpoint
      call resume(session%simulation, session%outputs, session%place, file, note, changes, error)
      if (allocated(error)) return
      associate (now => session%simulation, limits => session%limits)
         ! a state at the very end that is asked for is the result; one behind it is not
         late = len(changes%end) > 0 .and. (now%clock%step > limits%max_steps .or. &
            now%clock%time > limits%time_end*(1.0_wp + 1.0e-9_wp))
         if (changes%state() .and. .not. late) late = is_finished(now, limits)
      end associate
      if (late) call fail(error, exit_file, note//": the run is finished, so what has changed "// &
         "in the deck since would have no effect (in SI):"//changes%physics//changes%end// &
         changes%extent//new_line("a")// &
         "raise the end of the run (t_end, max_steps), or begin anew in another folder "// &
         "(--outdir) or with --overwrite")
   end subroutine go_on

   !> Particles are there: nobody needs voxels, facets and lists of points any more.
   subroutine forget_shapes(session)
      type(session_t), intent(inout) :: session      !! Loses its regions
      integer :: n

      deallocate (session%shapes)
      do n = 1, size(session%bodies)
         if (allocated(session%bodies(n)%shape%shape)) deallocate (session%bodies(n)%shape%shape)
         if (allocated(session%bodies(n)%given)) deallocate (session%bodies(n)%given)
      end do
   end subroutine forget_shapes
end module program_main
