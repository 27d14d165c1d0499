! SPDX-License-Identifier: BSD-3-Clause
!> scree --grains: runs a periodic cell of grains along the stages of a deck.
module program_grains
   use base_agreement, only: agree
   use base_error, only: code_last, error_t, exit_success, with_hint, without_code
   use base_file, only: make_folder, remove_file, write_file
   use base_hash, only: digest_text
   use base_kinds, only: int64, wp
   use base_log, only: log_t
   use base_text, only: number
   use base_timer, only: wall_seconds
   use base_version, only: compiler_flags, compiler_name, compiler_version_text, git_commit, &
      version_text
   use deck_reader, only: group_t
   use deck_units, only: system_number, system_si
   use grains_cell, only: cell_t
   use grains_checkpoint, only: cell_hash, save_cell
   use grains_deck, only: check_grains, grains_memory, read_grains_cell
   use grains_measures, only: energy_t, find_energy
   use grains_output, only: grains_output_t
   use grains_path, only: check_lengths, path_t, read_stages
   use io_state, only: state_t
   use io_summary, only: json_t
   use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use program_grains_loop, only: follow_path, grains_run_t, restart_cell, start_run
   use run_log_files, only: version_line
   use run_existing_results, only: lock_case, nothing_to_restart, protect_results
   use run_limits, only: read_limits
   use run_memory, only: check_memory
   use run_setup, only: run_setup_t
   use scene_run, only: check_case, set_output_units
   implicit none
   private

   public :: run_grains

   real(wp), parameter :: grain_steps_per_second = 5.0e6_wp !! For estimates, of one core
   integer, parameter :: grains_per_thread = 300     !! Fewest for a speed-up

contains

   !> Read the cell, check it, and run it unless --check is given.
   subroutine run_grains(setup, check_only, log, code, error)
      class(run_setup_t), intent(inout) :: setup     !! With the deck
      logical, intent(in) :: check_only              !! Without a run
      type(log_t), intent(inout) :: log
      integer, intent(out) :: code                   !! Exit code without an error
      type(error_t), allocatable, intent(out) :: error
      type(grains_run_t) :: run
      real(wp) :: begin
      integer :: most_threads
      logical :: fresh

      code = exit_success
      begin = wall_seconds()
      call check_case(setup%deck)
      call check_grains(setup%deck)
      call setup%deck%verdict(error)
      if (allocated(error)) return
      associate (communicator => setup%simulation%machine%communicator)
         call check_memory(setup%deck, communicator, grains_memory(setup%deck, &
            communicator%size), setup%deck%group("grains"), "number", "use fewer grains", &
            refuses=.not. setup%options%force)
      end associate
      call setup%deck%verdict(error)
      if (allocated(error)) return
      most_threads = omp_get_max_threads()
      call set_output_units(setup%deck)
      run%cell%communicator = setup%simulation%machine%communicator
      call read_grains_cell(setup%deck, run%cell)
      call read_stages(setup%deck, run%cell, run%cell%law%friction, run%path)
      call check_lengths(setup%deck, run%path, run%cell%dt)
      call setup%deck%verdict(error)
      if (allocated(error)) return
      call read_limits(setup%deck, run%limits)
      ! with fewer grains per thread, waiting takes longer than the work
      call omp_set_num_threads(max(1, min(most_threads, run%cell%grains%count &
         /(grains_per_thread*run%cell%communicator%size))))
      call describe_run(setup, run)
      if (check_only) then
         call log%info(with_hint(setup%deck%report()))
         call log%info(cost_text(run))
         return
      end if
      call lock_case(setup, log, error)
      if (allocated(error)) return
      call protect_results(setup, fresh, error)
      if (allocated(error)) return
      if (setup%options%restart) then
         call restart_cell(setup, run, error)
      else
         call start_run(run)
         if (fresh) run%note = nothing_to_restart
      end if
      if (allocated(error)) return
      call open_grains_log(setup, run, log, error)
      if (allocated(error)) return
      call follow_path(run, log, setup%lock, code, error)
      call finish_run(run, log, wall_seconds() - begin, code, error)
   end subroutine run_grains

   !> Names and provenance of the files.
   subroutine describe_run(setup, run)
      class(run_setup_t), intent(inout) :: setup
      type(grains_run_t), intent(inout) :: run
      type(group_t) :: group
      character(len=:), allocatable :: word

      group = setup%deck%group("run")
      associate (output => run%output, header => run%output%header)
         call group%get("case", output%case)
         output%folder = "out/"//output%case
         if (allocated(setup%options%folder)) output%folder = setup%options%folder
         header%code = "scree"
         header%version = version_text
         header%git = git_commit
         header%compiler = compiler_name//" "//compiler_version_text
         header%flags = compiler_flags()
         header%case = output%case
         call group%get("title", header%title)
         header%dimension = number(run%cell%box%dimension)//"d"
         header%deck = setup%deck_text
         header%echo = setup%deck%echo()
         group = setup%deck%group("units")
         call group%get("output_units", word)
         header%units%system = max(system_number(word), system_si)
         setup%outputs%folder = output%folder
         setup%outputs%case = output%case
         setup%outputs%header%echo = header%echo
         run%place%folder = output%folder
         run%place%case = output%case
         run%place%version = version_text
         run%place%deck = header%deck
         run%place%echo = header%echo
         run%place%schema = setup%schema
         group = setup%deck%group("checkpoint")
         call group%get("keep", run%place%keep)
      end associate
   end subroutine describe_run

   !> Stages with their steps, and the expected cost.
   function cost_text(run) result(text)
      type(grains_run_t), intent(in) :: run
      character(len=:), allocatable :: text
      character(len=*), parameter :: newline = new_line("a")
      type(path_t) :: path
      character(len=100) :: line
      integer(int64) :: steps
      integer :: n

      text = "grains    "//number(run%cell%grains%count)
      write (line, "(a, es9.2, a, es9.2, a)") "   step", run%cell%dt, " s   cell", &
         run%cell%box%edges(1, 1), " m"
      text = text//trim(line)//newline
      path = run%path
      steps = 0
      do n = 1, size(path%stages)
         path%now = n
         write (line, "(a, i3, 2a, t30, i12, a)") "stage  ", n, "  ", path%stages(n)%name, &
            path%steps(run%cell%dt), " steps at most"
         text = text//trim(line)//newline
         steps = steps + path%steps(run%cell%dt)
      end do
      write (line, "(a, es9.2, a, f8.1, a)") "total  ", real(steps, wp) &
         *real(run%cell%grains%count, wp), " grain steps, about", real(steps, wp) &
         *real(run%cell%grains%count, wp)/grain_steps_per_second/60.0_wp, &
         " minutes at 5 million/s on one core"
      text = text//trim(line)
   end function cost_text

   !> Open the log and write its beginning. Collective.
   subroutine open_grains_log(setup, run, log, error)
      class(run_setup_t), intent(inout) :: setup
      type(grains_run_t), intent(inout) :: run
      type(log_t), intent(inout) :: log
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: stem

      associate (communicator => run%cell%communicator, output => run%output)
         if (communicator%rank == 0) call make_folder(output%folder, error)
         call agree(communicator, error)
         if (allocated(error)) return
         stem = output%folder//"/"//output%case
         if (communicator%rank == 0) call remove_file(stem//".log")
         call log%open(communicator%rank, stem//".log", quiet=setup%options%quiet, &
            error=error)
         call agree(communicator, error)
         if (allocated(error)) return
         call log%info(version_line())
         call log%info("deck      "//setup%options%deck//"  case "//output%case//"  "// &
            number(communicator%size)//" ranks x "//number(omp_get_max_threads())// &
            " threads  results "//output%folder)
         if (setup%deck%warnings() > 0) call log%warn(setup%deck%report())
         call log%info(cost_text(run))
         if (len(run%note) > 0) call log%info(run%note)
         if (communicator%rank == 0) call write_file(stem//".echo.nml", setup%deck%echo(), error)
         call agree(communicator, error)
         if (allocated(error)) return
         call output%open(run%cell, run%path, setup%options%restart, run%losses, error)
         if (.not. allocated(error) .and. len(run%losses) > 0) call log%warn(run%losses)
      end associate
   end subroutine open_grains_log

   !> Write the end of the log and the summary. Collective.
   subroutine finish_run(run, log, wall, code, error)
      type(grains_run_t), intent(inout) :: run
      type(log_t), intent(inout) :: log
      real(wp), intent(in) :: wall                   !! [s]
      integer, intent(inout) :: code
      type(error_t), allocatable, intent(inout) :: error
      type(error_t), allocatable :: late
      type(energy_t) :: energy
      type(state_t) :: state
      type(json_t) :: json
      character(len=200) :: line
      character(len=16) :: digest
      real(wp) :: rate

      call run%output%close(run%cell, late)
      if (allocated(late) .and. .not. allocated(error)) call move_alloc(late, error)
      if (allocated(error)) code = error%code
      call find_energy(run%cell, energy)
      call save_cell(run%cell, run%path, run%output%energy_at_start, state)
      digest = digest_text(cell_hash(state))
      rate = real(run%cell%step - run%first_step, wp)*real(run%cell%grains%count, wp) &
         /max(run%steps_wall, tiny(1.0_wp))
      write (line, "(a, es10.3, a, es10.3, a, es10.3, a, es9.2)") "energy    work ", energy%work, &
         " J   dashpots", energy%lost(1), " J   friction", energy%lost(2), " J   error", &
         energy%total - run%output%energy_at_start - energy%work
      call log%info(trim(line)//" J")
      write (line, "(a, f8.2, a, i0, a, i0, a)") "speed     ", rate*1.0e-6_wp, &
         " million grain steps/s   neighbour searches ", run%cell%searches, " in ", run%cell%step, &
         " steps"
      call log%info(trim(line))
      if (len(run%losses) > 0) call log%warn(run%losses)
      call log%info(code_last("ended     "//run%reason))
      if (run%cell%communicator%rank == 0) then
         call json%add("version", version_text)
         call json%add("git", git_commit)
         call json%add("case", run%output%case)
         call json%add("exit_code", code)
         call json%add("reason", without_code(run%reason))
         call json%add("steps", run%cell%step)
         call json%add("time", run%cell%time)
         call json%add("grains", int(run%cell%grains%count, int64))
         call json%add("strain", run%cell%box%strain)
         call json%add("wall_s", wall)
         call json%add("grain_steps_per_s", rate)
         call json%add("ranks", run%cell%communicator%size)
         call json%add("threads", omp_get_max_threads())
         call json%add("digest", digest)
         call json%add("work", energy%work)
         call json%add("energy_error", energy%total - run%output%energy_at_start - energy%work)
         call json%write(run%output%folder//"/"//run%output%case//".summary.json", late)
      end if
      call agree(run%cell%communicator, late)
      if (allocated(late) .and. .not. allocated(error)) call move_alloc(late, error)
   end subroutine finish_run
end module program_grains
