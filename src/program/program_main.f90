! SPDX-License-Identifier: BSD-3-Clause
!> The program: from the command line to the exit code. The only place that prints errors.
module program_main
   use base_error, only: error_t, exit_again, exit_input, exit_success, fail, with_hint
   use base_file, only: join_path, occupy_streams, print_text, write_file
   use base_process, only: ranks_of_launcher
   use base_text, only: append
   use base_version, only: has_ranks
   use io_hdf5, only: leave_library
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: output_unit
   use program_batch_job, only: job_text
   use program_command, only: command_t, example_request_t, job_options_t
   use program_examples, only: copied_t, copy_example, next_steps
   use program_grains, only: run_grains
   use program_information, only: print_information
   use program_preview, only: draw_preview, write_preview
   use program_run_time_estimate, only: estimate_text, most_particles
   use program_self_test, only: run_self_test
   use run_cost_report, only: cost_report, memory_bytes
   use run_existing_results, only: existing_results_text
   use run_library_tests, only: test_libraries
   use run_material_point, only: drive_point
   use run_memory, only: memory_suffices
   use run_resume_command, only: program_arguments
   use run_setup, only: a_grain_cell, a_material_point, a_scene, declare_deck_keys
   use run_signals, only: ignore_file_size_limit
   use run_threads, only: share_cores, sleep_when_waiting, yield_when_waiting
   use run_type, only: run_t
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
      type(command_t) :: command
      type(run_t) :: run
      type(error_t), allocatable :: error
      character(len=:), allocatable :: preview, text

      code = exit_success
      call occupy_streams()
      call ignore_file_size_limit()
      call command%parse(program_arguments(), error)
      run%options = command%run_options_t
      if (allocated(error)) then
      else if (command%information%is_set()) then
         call declare_deck_keys(run%schema)
         call print_information(command%information, run%schema, error)
      else if (allocated(command%example%name)) then
         call create_example_folder(command%example, run, error)
      else if (command%self_test) then
         call test_installation(run, error)
      else
         call process_deck(command, run, preview, code, error)
      end if
      associate (communicator => run%simulation%machine%communicator)
         if (allocated(error)) then
            code = error%code
            if (communicator%rank == 0) call run%log%error(error%message)
         end if
         call run%lock%release()
         call run%log%close()
         if (allocated(error)) call leave_library()
         call communicator%finish()
         if (allocated(preview) .and. communicator%rank == 0) then
            flush (output_unit)
            call draw_preview(preview, command%quiet, text)
            if (len(text) > 0) write (output_unit, "(a)") text
         end if
      end associate
   end subroutine run_program

   !> Copy an example into a new folder, with a job script if it is a scene.
   subroutine create_example_folder(example, run, error)
      type(example_request_t), intent(in) :: example
      type(run_t), intent(inout) :: run
      type(error_t), allocatable, intent(out) :: error !! No such example, or not writable
      character(len=*), parameter :: job_file = "job.slurm"
      character(len=:), allocatable :: text
      type(copied_t) :: copied
      type(job_options_t) :: job

      call copy_example(example%name, example%folder, copied, error)
      if (allocated(error)) return
      if (.not. copied%has_grains) then
         run%options%deck = join_path(copied%folder, copied%deck)
         job%scheduler = "slurm"
         call run%read(a_scene, error)
         if (.not. allocated(error)) call run%build(.false., error)
         if (.not. allocated(error)) call job_text(run, job, copied%deck, text, error)
         if (.not. allocated(error)) &
            call write_file(join_path(copied%folder, job_file), text, error)
         if (allocated(error)) return
         call append(copied%files, job_file)
      end if
      call print_text(next_steps(copied), error)
   end subroutine create_example_folder

   !> Run the self-test on all ranks.
   subroutine test_installation(run, error)
      type(run_t), intent(inout) :: run
      type(error_t), allocatable, intent(out) :: error !! A check failed

      call check_launcher(error)
      if (allocated(error)) return
      call sleep_when_waiting(program_arguments())
      call run%simulation%machine%communicator%start()
      call run_self_test(run%simulation%machine%communicator, run%options%quiet, error)
   end subroutine test_installation

   !> Read the deck and do what the command line requests: check, preview, job script, run.
   subroutine process_deck(command, run, preview, code, error)
      type(command_t), intent(in) :: command
      type(run_t), intent(inout) :: run
      character(len=:), allocatable, intent(out) :: preview !! Folder of a preview to be drawn
      integer, intent(out) :: code                   !! Exit code without an error
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: text
      logical :: lone                                !! Without ranks
      integer :: subject

      code = exit_success
      call check_launcher(error)
      if (allocated(error)) return
      call share_cores()
      call yield_when_waiting(program_arguments())
      lone = command%check_only .or. command%information%echo .or. command%point .or. &
         allocated(command%job%scheduler)
      if (.not. lone) call run%simulation%machine%communicator%start()
      subject = a_scene
      if (command%point) subject = a_material_point
      if (command%grains) subject = a_grain_cell
      call run%read(subject, error)
      if (allocated(error)) return
      if (command%point) then
         call check_case(run%deck)
         call run%deck%verdict(error)
         if (.not. allocated(error)) call drive_point(run%deck, run%options%folder, text, error)
         if (.not. allocated(error)) call print_text(text//new_line("a"), error)
         return
      else if (command%grains) then
         call run_grains(run, command%check_only, run%log, code, error)
         return
      end if
      call run%build(.not. lone, error)
      if (allocated(error)) return
      call run%limit_threads()
      if (command%information%echo) then
         call print_text(run%deck%echo(), error)
      else if (allocated(command%job%scheduler)) then
         call job_text(run, command%job, command%deck, text, error)
         if (.not. allocated(error)) call print_text(text, error)
      else if (command%check_only) then
         call print_check(run, command%estimate, error)
      else if (command%preview) then
         call write_preview(run, preview, error)
         if (allocated(error)) deallocate (preview)
      else
         call run%start(error)
         if (allocated(error)) return
         do while (.not. run%loop%finished)
            call run%advance()
         end do
         call run%end(code, error)
      end if
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
   subroutine print_check(run, estimate, error)
      type(run_t), intent(inout) :: run
      logical, intent(in) :: estimate                !! Estimate the run time?
      type(error_t), allocatable, intent(out) :: error !! The first state cannot be built
      character(len=:), allocatable :: existing, text

      text = with_hint(run%deck%report())//new_line("a")//effects_text(run%schema, run%deck)// &
         cost_report(run%simulation, run%bodies, run%survey, run%limits, &
         run%outputs%full_snapshots(run%limits%time_end))
      existing = existing_results_text(run)
      if (len(existing) > 0) text = text//existing//new_line("a")
      call test_libraries(run%simulation%materials, existing, error)
      if (allocated(error)) return
      text = text//existing
      call print_text(text, error)
      if (allocated(error)) return
      if (.not. estimate .or. run%survey%particles > most_particles) return
      if (.not. memory_suffices(memory_bytes(run%simulation, run%survey))) return
      call estimate_text(run, text, error)
      if (.not. allocated(error)) call print_text(text, error)
   end subroutine print_check
end module program_main
