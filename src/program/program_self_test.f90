! SPDX-License-Identifier: BSD-3-Clause
!> `scree --self-test`: small scenes run in a temporary folder, and their digests are compared with
!! those of src/program/self_test/digests.csv. A build whose digests are not recorded, such as one
!! of a newer compiler, is tested by comparisons of its own runs: restart, threads, balance, files.
module program_self_test
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_internal, fail
   use base_file, only: join_path, make_folder, make_temporary_folder, remove_folder, write_file
   use base_kinds, only: wp
   use base_process, only: is_set, set_default
   use base_text, only: number, text_t
   use base_timer, only: wall_seconds
   use base_version, only: compiler_name, compiler_version_text, processor_family, version_text
   use, intrinsic :: iso_fortran_env, only: output_unit
   use omp_lib, only: omp_get_max_threads
   use program_self_test_run, only: outcome_t, run_scene
   use program_self_test_scenes, only: deck_line_length, deck_lines, recorded_digest, scene_names
   use step_ledger, only: balance_t
   implicit none
   private

   public :: balance_text, build_kind, compared, is_balanced, run_self_test, self_test_t

   !> Greatest relative error of a balance that is rounding
   real(wp), parameter :: rounding = 1.0e-12_wp
   !> Scenes without a material whose lost energy is recorded nowhere, so that the energy balance
   !! must close
   character(len=9), parameter :: closed_scenes(3) = [character(len=9) :: "charge", "fracture", &
      "shock"]
   character(len=*), parameter :: newline = new_line("a")

   !> The test so far.
   type :: self_test_t
      type(communicator_t) :: communicator
      logical :: quiet = .false.                     !! Print only failures
      integer :: threads = 1                         !! Threads of most runs
      integer :: other_threads = 2                   !! Threads of the run that is compared
      integer :: checks = 0                          !! Checks so far
      integer :: failures = 0                        !! Failed checks
      character(len=:), allocatable :: folder        !! Temporary folder
      character(len=:), allocatable :: details       !! A line for each failed check
   contains
      procedure :: check => self_test_check          !! Count a check
   end type self_test_t

contains

   !> Run all scenes and print a table. Collective.
   subroutine run_self_test(communicator, quiet, error)
      type(communicator_t), intent(in) :: communicator !! All ranks
      logical, intent(in) :: quiet                   !! Print only failures
      type(error_t), allocatable, intent(out) :: error !! A check failed, or no folder can be made
      type(self_test_t) :: test
      type(error_t), allocatable :: late
      real(wp) :: start
      integer :: n

      test%communicator = communicator
      test%quiet = quiet
      test%details = ""
      start = wall_seconds()
      call fix_threads(test)
      if (communicator%rank == 0) call make_temporary_folder("scree_self_test_", test%folder, error)
      call agree(test%communicator, error)
      if (allocated(error)) return
      call test%communicator%broadcast(test%folder)
      call print_line(test, heading(test))
      do n = 1, size(scene_names)
         call test_scene(test, trim(scene_names(n)))
      end do
      call test%communicator%barrier()
      if (communicator%rank == 0) call remove_folder(test%folder, late)
      call agree(test%communicator, late)
      if (test%failures > 0) then
         call fail(error, exit_internal, "self-test: error: "//number(test%failures)//" of "// &
            number(test%checks)//" checks failed: [R132]"//test%details)
      else if (allocated(late)) then
         call move_alloc(late, error)
      else
         call print_line(test, "passed    "//number(test%checks)//" checks in "// &
            number(nint(wall_seconds() - start))//" s")
      end if
   end subroutine run_self_test

   !> Fix the number of threads: no run of the test changes it.
   subroutine fix_threads(test)
      type(self_test_t), intent(inout) :: test

      if (is_set("OMP_NUM_THREADS")) test%threads = omp_get_max_threads()
      call set_default("OMP_NUM_THREADS", "1")
      test%other_threads = merge(2, 1, test%threads == 1)
   end subroutine fix_threads

   !> Processor and generation of the compiler: between these, bits may differ.
   pure function build_kind() result(kind)
      character(len=:), allocatable :: kind

      kind = processor_family//" "//compiler_name//" "// &
         compiler_version_text(:index(compiler_version_text//".", ".") - 1)
   end function build_kind

   !> Lines above the table.
   function heading(test) result(text)
      type(self_test_t), intent(in) :: test
      character(len=:), allocatable :: text

      text = "self-test scree "//version_text//", "//build_kind()//", "// &
         count_of_ranks(test%communicator%size)//", files in "//test%folder//newline
      if (recorded_digest(build_kind(), scene_names(1)) == "") text = text// &
         "note      no digests are recorded for this kind of build; its runs are compared with "// &
         "each other"//newline
      text = text//"scene      particles  steps  digest            recorded  restart  threads"// &
         "  checkpoint  snapshot  balance     s"
   end function heading

   !> Number of ranks with its word.
   pure function count_of_ranks(ranks) result(text)
      integer, intent(in) :: ranks
      character(len=:), allocatable :: text

      text = "1 rank"
      if (ranks > 1) text = number(ranks)//" ranks"
   end function count_of_ranks

   !> Run one scene: from its start, from its checkpoint, and with other threads. Collective.
   subroutine test_scene(test, scene)
      type(self_test_t), intent(inout) :: test
      character(len=*), intent(in) :: scene          !! One of scene_names
      type(outcome_t) :: whole, rest, threaded
      type(error_t), allocatable :: error
      character(len=8) :: words(5)
      character(len=16) :: known
      real(wp) :: start

      start = wall_seconds()
      call write_deck(test, scene, error)
      if (.not. allocated(error)) call run_scene(arguments_of(test, scene, "whole", ""), &
         test%threads, whole, error)
      if (.not. allocated(error)) call run_scene(arguments_of(test, scene, "rest", &
         whole%checkpoint), test%threads, rest, error)
      if (.not. allocated(error)) call run_scene(arguments_of(test, scene, "threads", ""), &
         test%other_threads, threaded, error)
      call test%check(scene//" runs", .not. allocated(error), words(1))
      if (allocated(error)) then
         test%details = test%details//newline//"    "//without(error%message, test%folder//"/")
         return
      end if
      known = recorded_digest(build_kind(), scene)
      words(1) = "unknown"
      if (known /= "") call test%check(compared(scene//", digest and the recorded one", &
         whole%digest, known), whole%digest == known, words(1))
      call test%check(compared(scene//", digest after a restart", rest%digest, whole%digest), &
         rest%digest == whole%digest, words(2))
      call test%check(compared(scene//", digest with "//number(test%other_threads)//" threads", &
         threaded%digest, whole%digest), threaded%digest == whole%digest, words(3))
      call test%check(compared(scene//", digest of the checkpoint", whole%stored, whole%halfway), &
         whole%stored == whole%halfway .and. whole%halfway /= "", words(4))
      call test%check(scene//", positions in the last snapshot", whole%same_snapshot, words(5))
      call print_line(test, row(test, scene, whole, words, wall_seconds() - start))
   end subroutine test_scene

   !> A text without a word: paths in the temporary folder, which is removed, without its name.
   pure function without(text, word) result(rest)
      character(len=*), intent(in) :: text
      character(len=*), intent(in) :: word
      character(len=:), allocatable :: rest
      integer :: first

      rest = text
      do
         first = index(rest, word)
         if (first == 0) exit
         rest = rest(:first - 1)//rest(first + len(word):)
      end do
   end function without

   !> A row of the table. Counts the check of the balance.
   function row(test, scene, outcome, words, seconds) result(text)
      type(self_test_t), intent(inout) :: test
      character(len=*), intent(in) :: scene          !! One of scene_names
      type(outcome_t), intent(in) :: outcome         !! Outcome of the run from its start
      character(len=*), intent(in) :: words(:)       !! Results of the other checks
      real(wp), intent(in) :: seconds                !! Wall time of all runs of the scene [s]
      character(len=:), allocatable :: text
      character(len=120) :: line
      character(len=8) :: word
      logical :: closed

      closed = any(closed_scenes == scene)
      call test%check(scene//", balance of "//balance_text(outcome%balance, closed), &
         is_balanced(outcome%balance, closed), word)
      write (line, "(a, i9, i7, 2x, a16, 2x, a8, 2x, a7, 2x, a7, 2x, a10, 2x, a8, 2x, a7, f6.1)") &
         scene//repeat(" ", max(11 - len(scene), 1)), outcome%particles, outcome%steps, &
         outcome%digest, words, word, seconds
      text = trim(line)
   end function row

   !> True if the errors of mass and momentum, and of energy where it is closed, are rounding.
   pure logical function is_balanced(balance, closed) result(balanced)
      type(balance_t), intent(in) :: balance
      logical, intent(in) :: closed                  !! Must the energy balance close?

      balanced = abs(balance%mass_error) <= rounding .and. abs(balance%momentum_error) <= rounding
      if (closed) balanced = balanced .and. abs(balance%energy_error) <= rounding
   end function is_balanced

   !> The errors of a balance.
   function balance_text(balance, closed) result(text)
      type(balance_t), intent(in) :: balance
      logical, intent(in) :: closed                  !! Must the energy balance close?
      character(len=:), allocatable :: text
      character(len=80) :: line

      write (line, "(a, es9.1, a, es9.1)") "mass", balance%mass_error, ", momentum", &
         balance%momentum_error
      text = trim(line)
      if (.not. closed) return
      write (line, "(a, es9.1)") ", energy", balance%energy_error
      text = text//trim(line)
   end function balance_text

   !> Description of two digests that should be equal.
   pure function compared(what, one, other) result(text)
      character(len=*), intent(in) :: what           !! Scene and check
      character(len=*), intent(in) :: one, other     !! Digests
      character(len=:), allocatable :: text

      text = what//": "//trim(one)//" instead of "//trim(other)
   end function compared

   !> Count a check, and record it if it failed.
   subroutine self_test_check(self, what, passed, word)
      class(self_test_t), intent(inout) :: self
      character(len=*), intent(in) :: what           !! For the list of failures
      logical, intent(in) :: passed                  !! Result of the check
      character(len=8), intent(out) :: word          !! For the table

      self%checks = self%checks + 1
      word = "same"
      if (passed) return
      word = "DIFFERS"
      self%failures = self%failures + 1
      self%details = self%details//newline//"  "//what
   end subroutine self_test_check

   !> Write the deck of a scene into its folder. Collective.
   subroutine write_deck(test, scene, error)
      type(self_test_t), intent(in) :: test
      character(len=*), intent(in) :: scene          !! One of scene_names
      type(error_t), allocatable, intent(out) :: error !! Cannot be written
      character(len=deck_line_length), allocatable :: lines(:)
      character(len=:), allocatable :: text
      integer :: n

      if (test%communicator%rank == 0) then
         call deck_lines(scene, lines)
         text = ""
         do n = 1, size(lines)
            text = text//trim(lines(n))//newline
         end do
         call make_folder(join_path(test%folder, scene), error)
         if (.not. allocated(error)) call write_file(deck_path(test, scene), text, error)
      end if
      call agree(test%communicator, error)
   end subroutine write_deck

   !> Path of the deck of a scene.
   pure function deck_path(test, scene) result(path)
      type(self_test_t), intent(in) :: test
      character(len=*), intent(in) :: scene          !! One of scene_names
      character(len=:), allocatable :: path

      path = join_path(test%folder, scene//"/"//scene//".nml")
   end function deck_path

   !> Arguments of a run.
   pure function arguments_of(test, scene, run, checkpoint) result(arguments)
      type(self_test_t), intent(in) :: test
      character(len=*), intent(in) :: scene          !! One of scene_names
      character(len=*), intent(in) :: run            !! Output folder of the run
      character(len=*), intent(in) :: checkpoint     !! Where it begins; empty: at the start
      type(text_t), allocatable :: arguments(:)

      allocate (arguments(merge(6, 4, checkpoint /= "")))
      arguments(1)%text = "--quiet"
      arguments(2)%text = "--outdir"
      arguments(3)%text = join_path(test%folder, scene//"/"//run)
      arguments(4)%text = deck_path(test, scene)
      if (checkpoint == "") return
      arguments(5)%text = "--restart"
      arguments(6)%text = checkpoint
   end function arguments_of

   !> Print lines on rank 0.
   subroutine print_line(test, text)
      type(self_test_t), intent(in) :: test
      character(len=*), intent(in) :: text
      integer :: status

      if (test%quiet .or. test%communicator%rank > 0) return
      write (output_unit, "(a)", iostat=status) text
      flush (output_unit, iostat=status)
   end subroutine print_line
end module program_self_test
