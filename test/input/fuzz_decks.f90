! SPDX-License-Identifier: BSD-3-Clause
!> Damages decks at random and reads each with all checks of `--check`, in one process.
!!
!! Usage: fuzz_decks FOLDER FIRST COUNT DECK...
!! Mutation number n is the same in every call, so a failing one can be repeated alone. The deck
!! that is being read is FOLDER/deck.nml; after a crash it is the deck that caused it.
!! Requirements: a deck with an error has a message and exit code 2 or 3; the echo of a deck without
!! an error reads back without an error and to the same echo; an unknown key, group, word or name is
!! always an error that quotes it.
program fuzz_decks
   use base_error, only: error_t, exit_file, exit_input
   use base_kinds, only: wp
   use base_text, only: buffer_t, lower, number, text_t
   use deck_schema, only: schema_t
   use fuzz_mutation, only: choice_t, mutate, respell
   use fuzz_session, only: give_up, read_arguments, read_scene, write_bytes
   use, intrinsic :: iso_fortran_env, only: output_unit
   use run_setup, only: declare_deck_keys, run_setup_t
   implicit none

   real(wp), parameter :: most_points = 1.0e6_wp

   call fuzz()

contains

   !> All mutations. All memory allocated here is freed before the program ends.
   subroutine fuzz()
      type(schema_t) :: schema
      type(text_t), allocatable :: decks(:), names(:)
      character(len=:), allocatable :: folder, text, unknown, fault
      type(choice_t) :: choice
      integer :: first, mutations, n, refused, words, failures, which

      call read_arguments("fuzz_decks FOLDER FIRST COUNT DECK...", 1, folder, first, mutations, &
         names, decks)
      call declare_deck_keys(schema)
      refused = 0
      do which = 1, size(decks)
         call look_at(schema, folder, decks(which)%text, "", refused, fault)
         if (refused > 0) fault = "it is refused as it is: "//fault
         if (fault /= "") call give_up("deck "//number(which)//": "//fault)
      end do
      refused = 0
      words = 0
      failures = 0
      do n = first, first + mutations - 1
         call choice%start(n)
         which = choice%upto(size(decks))
         unknown = ""
         text = decks(which)%text
         if (choice%upto(4) == 1) then
            call respell(choice, schema, text, unknown)
            if (unknown /= "") words = words + 1
         end if
         if (unknown == "") call mutate(choice, text)
         call look_at(schema, folder, text, unknown, refused, fault)
         if (fault == "") cycle
         failures = failures + 1
         write (output_unit, "(a)") "mutation "//number(n)//" of deck "//number(which)//": "// &
            fault
         if (failures == 10) exit
      end do
      write (output_unit, "(a)") number(mutations)//" mutations of "//number(size(decks))// &
         " decks: "//number(refused)//" refused, "//number(words)//" unknown words, "// &
         number(failures)//" failures"
      flush (output_unit)
      if (failures > 0) call give_up("FAILED")
   end subroutine fuzz

   !> Read a deck as `--check` does and check the result.
   subroutine look_at(schema, folder, text, unknown, refused, fault)
      type(schema_t), intent(in) :: schema           !! What is allowed
      character(len=*), intent(in) :: folder         !! Where to write
      character(len=*), intent(in) :: text           !! The deck
      character(len=*), intent(in) :: unknown        !! Word that must be refused, or empty
      integer, intent(inout) :: refused              !! Decks refused so far
      character(len=:), allocatable, intent(out) :: fault !! Requirement that is violated, or empty
      type(run_setup_t) :: setup
      type(error_t), allocatable :: error

      fault = ""
      call write_bytes(folder//"/deck.nml", text)
      call read_scene(schema, folder//"/deck.nml", index(text, "&grains") > 0, most_points, setup, &
         error)
      if (allocated(error)) then
         refused = refused + 1
         if (error%code /= exit_input .and. error%code /= exit_file) then
            fault = "exit code "//number(error%code)//": "//error%message
         else if (index(error%message, ": error: ") == 0) then
            fault = "no message: "//error%message
         else if (index(lower(error%message), lower(unknown)) == 0) then
            fault = "'"//unknown//"' is not quoted: "//error%message
         end if
      else if (unknown /= "") then
         fault = "'"//unknown//"' is accepted"
      else
         call read_echo(schema, folder, setup, index(text, "&grains") > 0, fault)
      end if
   end subroutine look_at

   !> Check that an echo reads back to the same echo.
   subroutine read_echo(schema, folder, setup, grains, fault)
      type(schema_t), intent(in) :: schema           !! What is allowed
      character(len=*), intent(in) :: folder         !! Where to write
      type(run_setup_t), intent(in) :: setup               !! Without errors
      logical, intent(in) :: grains                  !! True for a deck of --grains
      character(len=:), allocatable, intent(inout) :: fault !! What does not hold, or empty
      type(run_setup_t) :: again
      type(error_t), allocatable :: error
      character(len=:), allocatable :: echo, second

      echo = setup%deck%echo()
      call write_bytes(folder//"/deck.nml", echo)
      call read_scene(schema, folder//"/deck.nml", grains, most_points, again, error)
      if (allocated(error)) then
         fault = "the echo is refused: "//error%message
         return
      end if
      second = again%deck%echo()
      if (bare(echo) /= bare(second)) fault = "the echo does not read back to itself"
   end subroutine read_echo

   !> An echo without its first line and without the marks of defaults: a further echo gives the
   !! defaults.
   function bare(echo) result(text)
      character(len=*), intent(in) :: echo           !! As written
      character(len=:), allocatable :: text
      character(len=*), parameter :: newline = new_line("a")
      type(buffer_t) :: buffer
      integer :: start, last, mark

      start = index(echo, newline) + 1
      do while (start <= len(echo))
         last = start + index(echo(start:)//newline, newline) - 2
         mark = index(echo(start:last), " ! default", back=.true.)
         if (mark > 0) then
            call buffer%line(trim(echo(start:start + mark - 1)))
         else
            call buffer%line(echo(start:last))
         end if
         start = last + 2
      end do
      text = buffer%content()
   end function bare
end program fuzz_decks
