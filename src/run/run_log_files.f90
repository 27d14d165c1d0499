! SPDX-License-Identifier: BSD-3-Clause
!> Opens the log of a run and writes its beginning: versions, effects, costs, and the resolved deck
!! in a separate file.
module run_log_files
   use base_agreement, only: agree
   use base_error, only: error_t
   use base_file, only: make_folder, remove_file, write_file
   use base_log, only: log_error, log_info, log_t, log_warn
   use base_text, only: number
   use base_communicator, only: message_passing_version
   use base_version, only: build_type, compiler_flags, compiler_name, compiler_version_text, &
      git_commit, version_text
   use deck_reader, only: deck_t, group_t
   use omp_lib, only: omp_get_max_threads
   use run_cost_report, only: cost_report
   use run_setup, only: run_setup_t
   use run_threads, only: threads_text
   use scene_effects, only: effects_text
   implicit none
   private

   public :: open_log, version_line

contains

   !> Make the output folder, open the log, and write the resolved deck. Called after all checks, so
   !! that a deck with errors leaves no files. Collective.
   subroutine open_log(setup, most_threads, log, error)
      class(run_setup_t), intent(inout) :: setup     !! Complete, without particles
      integer, intent(in) :: most_threads            !! Threads of a rank that are available
      type(log_t), intent(inout) :: log              !! Opened
      type(error_t), allocatable, intent(out) :: error !! Folder or file cannot be written
      character(len=:), allocatable :: line, stem

      associate (communicator => setup%simulation%machine%communicator, outputs => setup%outputs, &
         survey => setup%survey)
         if (communicator%rank == 0) call make_folder(outputs%folder, error)
         call agree(communicator, error)
         if (allocated(error)) return
         stem = outputs%folder//"/"//outputs%case
         ! a link of this name may lead to a file elsewhere, which must not change
         if (communicator%rank == 0) call remove_file(stem//".log")
         call log%open(communicator%rank, stem//".log", log_level(setup%deck), &
            setup%options%quiet, error)
         call agree(communicator, error)
         if (allocated(error)) return
         call log%info(version_line())
         call log%info("deck      "//setup%options%deck//"  case "//outputs%case//"  "// &
            number(communicator%size)//" ranks x "//number(omp_get_max_threads())// &
            " threads  results "//outputs%folder)
         line = threads_text(most_threads, &
            int((survey%tiles + communicator%size - 1)/communicator%size), &
            survey%particles/communicator%size)
         if (len(line) > 0) call log%info(line)
         if (setup%deck%warnings() > 0) call log%warn(setup%deck%report())
         call log%info(effects_text(setup%schema, setup%deck)// &
            cost_report(setup%simulation, setup%bodies, survey, setup%limits, &
            outputs%full_snapshots(setup%limits%time_end)))
         if (communicator%rank == 0) call write_file(stem//".echo.nml", setup%deck%echo(), error)
         call agree(communicator, error)
      end associate
   end subroutine open_log

   !> Greatest level of the lines in the log.
   integer function log_level(deck) result(level)
      type(deck_t), intent(in) :: deck
      type(group_t) :: group
      character(len=:), allocatable :: word

      group = deck%group("log")
      call group%get("level", word)
      select case (word)
      case ("error")
         level = log_error
      case ("warn")
         level = log_warn
      case default
         level = log_info
      end select
   end function log_level

   !> Versions of the program, the compiler and the message passing library, in one line.
   function version_line() result(text)
      character(len=:), allocatable :: text

      text = "scree "//version_text//" (git "//git_commit//")  "//compiler_name//" " &
         //compiler_version_text//" "//build_type//" "//compiler_flags()//"  " &
         //message_passing_version()
   end function version_line
end module run_log_files
