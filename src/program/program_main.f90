! SPDX-License-Identifier: BSD-3-Clause
!> The program: from the command line to the exit code. The only place that prints errors.
module program_main
   use base_error, only: error_t, exit_again, exit_input, exit_success, fail
   use base_file, only: join_path, occupy_streams, print_text, write_file
   use base_process, only: ranks_of_launcher
   use base_text, only: append
   use base_version, only: has_ranks
   use io_hdf5, only: leave_library
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: output_unit
   use program_batch_job, only: job_text
   use program_command_line, only: parse_command_line
   use run_resume_command, only: program_arguments
   use program_examples, only: copied_t, copy_example, next_steps
   use program_grains, only: run_grains
   use program_information, only: print_information
   use program_preview, only: draw_preview, write_preview
   use program_run_time_estimate, only: estimate_text, most_particles
   use program_self_test, only: run_self_test
   use run_cost_report, only: cost_report, memory_bytes
   use run_existing_results, only: existing_results_text
   use run_material_point, only: drive_point
   use run_memory, only: memory_suffices
   use run_messages, only: add_codes, coded
   use run_session, only: advance_run, begin_run, end_run, limit_threads, session_t
   use run_setup, only: build_setup, declare_deck_keys, read_setup
   use run_signals, only: ignore_file_size_limit
   use run_threads, only: share_cores, sleep_when_waiting, yield_when_waiting
   use scene_effects, only: effects_text
   use scene_run, only: check_case
   implicit none
   private

   public :: run_program

contains

   !> Run the command line of the program. With a name of C, because it can be in a shared library
   !! of which nothing else is visible.
   subroutine run_program(code) bind(c, name="scree_run_program")
      integer(c_int), intent(out) :: code            !! Exit code
      type(session_t) :: session
      type(error_t), allocatable :: error

      code = exit_success
      call occupy_streams()
      call ignore_file_size_limit()
      session%log%annotate => add_codes
      call parse_command_line(program_arguments(), session%command, error)
      if (.not. allocated(error)) then
         if (session%command%information%is_set()) then
            call declare_deck_keys(session%schema)
            call print_information(session%command%information, session%schema, error)
         else if (allocated(session%command%example%name)) then
            call create_example_folder(session, error)
         else if (session%command%self_test) then
            call test_installation(session, error)
         else
            call process_deck(session, code, error)
         end if
      end if
      if (allocated(error)) then
         code = error%code
         if (session%simulation%machine%communicator%rank == 0) call &
            session%log%error(error%message)
      end if
      call session%lock%release()
      call session%log%close()
      if (allocated(error)) call leave_library()
      call session%simulation%machine%communicator%finish()
      if (allocated(session%preview_folder) .and. session%simulation%machine%communicator%rank == &
         0) &
         call print_preview(session)
   end subroutine run_program

   !> Draw a preview from its files, and print its path.
   subroutine print_preview(session)
      type(session_t), intent(in) :: session
      character(len=:), allocatable :: text

      flush (output_unit)
      call draw_preview(session%preview_folder, session%command%output%quiet, text)
      if (len(text) > 0) write (output_unit, "(a)") text
   end subroutine print_preview

   !> Copy an example into a new folder, with a job script if it is a scene.
   subroutine create_example_folder(session, error)
      type(session_t), intent(inout) :: session
      type(error_t), allocatable, intent(out) :: error !! No such example, or not writable
      character(len=*), parameter :: job_file = "job.slurm"
      character(len=:), allocatable :: text
      type(copied_t) :: copied

      call copy_example(session%command%example%name, session%command%example%folder, copied, error)
      if (allocated(error)) return
      if (copied%has_grains) then
         call print_text(next_steps(copied), error)
         return
      end if
      session%command%deck = join_path(copied%folder, copied%deck)
      session%command%job%scheduler = "slurm"
      call read_setup(session, error)
      if (.not. allocated(error)) call build_setup(session, error)
      if (.not. allocated(error)) call job_text(session, copied%deck, text, error)
      if (.not. allocated(error)) &
         call write_file(join_path(copied%folder, job_file), text, error)
      if (allocated(error)) return
      call append(copied%files, job_file)
      call print_text(next_steps(copied), error)
   end subroutine create_example_folder

   !> Run the self-test on all ranks.
   subroutine test_installation(session, error)
      type(session_t), intent(inout) :: session
      type(error_t), allocatable, intent(out) :: error !! A check failed

      call check_launcher(error)
      if (allocated(error)) return
      call sleep_when_waiting(program_arguments())
      call session%simulation%machine%communicator%start()
      call run_self_test(session%simulation%machine%communicator, session%command%output%quiet, &
         error)
   end subroutine test_installation

   !> Read the deck and do what the command line requests: check, preview, job script, run.
   subroutine process_deck(session, code, error)
      type(session_t), intent(inout) :: session
      integer, intent(out) :: code                   !! Exit code without an error
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: text

      code = exit_success
      call check_launcher(error)
      if (allocated(error)) return
      call share_cores()
      call yield_when_waiting(program_arguments())
      associate (command => session%command)
         if (.not. (command%check .or. command%information%echo .or. command%point .or. &
            allocated(command%job%scheduler))) &
            call session%simulation%machine%communicator%start()
         call read_setup(session, error)
         if (allocated(error)) return
         if (command%point) then
            call run_point(session, error)
            return
         end if
         if (command%grains) then
            call run_grains(session, session%log, code, error)
            return
         end if
         call build_setup(session, error)
         if (allocated(error)) return
         call limit_threads(session)
         if (command%information%echo) then
            call print_text(session%deck%echo(), error)
         else if (allocated(command%job%scheduler)) then
            call job_text(session, command%deck, text, error)
            if (.not. allocated(error)) call print_text(text, error)
         else if (command%check) then
            call print_check(session, error)
         else if (command%preview) then
            call write_preview(session, session%preview_folder, error)
            if (allocated(error)) deallocate (session%preview_folder)
         else
            call run_simulation(session, code, error)
         end if
      end associate
   end subroutine process_deck

   !> Refuse several processes of a program without MPI: each would compute and write the whole.
   subroutine check_launcher(error)
      type(error_t), allocatable, intent(out) :: error !! Several processes, without MPI

      if (has_ranks) return
      if (ranks_of_launcher() == 1) return
      call fail(error, exit_input, "this scree was built without MPI, for one rank: start it "// &
         "without mpirun or srun, with threads (OMP_NUM_THREADS), or use a build with MPI [C117]")
   end subroutine check_launcher

   !> Print warnings, effects, costs and an estimate of the run time.
   subroutine print_check(session, error)
      type(session_t), intent(inout) :: session
      type(error_t), allocatable, intent(out) :: error !! The first state cannot be built
      character(len=:), allocatable :: existing, text

      text = coded(session%deck%report())//new_line("a")// &
         effects_text(session%schema, session%deck)// &
         cost_report(session%simulation, session%bodies, session%survey, session%limits, &
         session%outputs%full_snapshots(session%limits%time_end))
      existing = existing_results_text(session)
      if (len(existing) > 0) text = text//existing//new_line("a")
      call print_text(text, error)
      if (allocated(error)) return
      if (.not. session%command%estimate .or. session%survey%particles > most_particles) return
      if (.not. memory_suffices(memory_bytes(session%simulation, session%survey))) return
      call estimate_text(session, text, error)
      if (.not. allocated(error)) call print_text(text, error)
   end subroutine print_check

   !> Drive one material point.
   subroutine run_point(session, error)
      type(session_t), intent(inout) :: session
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: note

      call check_case(session%deck)
      call session%deck%verdict(error)
      if (allocated(error)) return
      call drive_point(session%deck, session%command%output%folder, note, error)
      if (.not. allocated(error)) call print_text(note//new_line("a"), error)
   end subroutine run_point

   !> Run the simulation from its first state or a checkpoint to its end.
   subroutine run_simulation(session, code, error)
      type(session_t), intent(inout) :: session      !! Complete, without particles
      integer, intent(out) :: code                   !! Exit code
      type(error_t), allocatable, intent(out) :: error

      code = exit_success
      call begin_run(session, error)
      if (allocated(error)) return
      do while (.not. session%loop%finished)
         call advance_run(session)
      end do
      call end_run(session, code, error)
   end subroutine run_simulation
end module program_main
