! SPDX-License-Identifier: BSD-3-Clause
!> Damages input files of a deck at random and reads the deck with all checks of `--check`, in one
!! process.
!!
!! Usage: fuzz_files FOLDER FIRST COUNT DECK FILE...
!! The deck names the files without their folder. Mutation number n is the same in every call.
!! FOLDER holds copies of all files; what a crash leaves there are the files that caused it.
!! What must hold: the deck is accepted, or refused with a message and exit code 2 or 3.
program fuzz_files
   use base_error, only: error_t, exit_file, exit_input
   use base_text, only: append, number, text_t
   use fuzz_mutation, only: choice_t, damage, mutate
   use io_file, only: read_file
   use, intrinsic :: iso_fortran_env, only: output_unit
   use program_command_line, only: parse_command_line
   use program_run_setup, only: build_setup, declare_deck_keys, read_setup, run_setup_t
   implicit none

   call fuzz()

contains

   !> All mutations. What is allocated here is freed before the program ends.
   subroutine fuzz()
      type(text_t), allocatable :: names(:), whole(:)
      character(len=:), allocatable :: folder, text, fault
      type(choice_t) :: choice
      integer, allocatable :: refused(:)
      integer :: first, mutations, n, which, failures
      logical :: is_refused

      call arguments(folder, first, mutations, names, whole)
      do n = 1, size(whole)
         call write_bytes(folder//"/"//names(n)%text, whole(n)%text)
      end do
      call look_at(folder//"/"//names(1)%text, is_refused, fault)
      if (is_refused) call give_up("the deck is refused with whole files: "//fault)
      allocate (refused(size(whole)), source=0)
      failures = 0
      do n = first, first + mutations - 1
         call choice%start(n)
         which = 1 + choice%upto(size(whole) - 1)
         text = whole(which)%text
         if (choice%upto(3) == 1) then
            call damage(choice, text)
         else
            call mutate(choice, text)
         end if
         call write_bytes(folder//"/"//names(which)%text, text)
         call look_at(folder//"/"//names(1)%text, is_refused, fault)
         if (is_refused) refused(which) = refused(which) + 1
         call write_bytes(folder//"/"//names(which)%text, whole(which)%text)
         if (fault == "" .or. is_refused .and. index(fault, ": error: ") > 0) cycle
         failures = failures + 1
         write (output_unit, "(a)") "mutation "//number(n)//" of "//names(which)%text//": "//fault
         if (failures == 10) exit
      end do
      do n = 2, size(whole)
         write (output_unit, "(a)") names(n)%text//": "//number(refused(n))//" refused"
      end do
      write (output_unit, "(a)") number(mutations)//" mutations, "//number(failures)//" failures"
      flush (output_unit)
      if (failures > 0) call give_up("FAILED")
   end subroutine fuzz

   !> Read the command line and the files.
   subroutine arguments(folder, first, mutations, names, whole)
      character(len=:), allocatable, intent(out) :: folder !! Where to write
      integer, intent(out) :: first                  !! Number of the first mutation
      integer, intent(out) :: mutations              !! How many
      type(text_t), allocatable, intent(out) :: names(:) !! Of deck and files, without folder
      type(text_t), allocatable, intent(out) :: whole(:) !! Their bytes
      type(error_t), allocatable :: error
      character(len=1000) :: word
      integer :: i

      if (command_argument_count() < 5) &
         call give_up("usage: fuzz_files FOLDER FIRST COUNT DECK FILE...")
      call get_command_argument(1, word)
      folder = trim(word)
      call get_command_argument(2, word)
      read (word, *) first
      call get_command_argument(3, word)
      read (word, *) mutations
      allocate (names(command_argument_count() - 3), whole(command_argument_count() - 3))
      do i = 1, size(names)
         call get_command_argument(i + 3, word)
         names(i)%text = trim(word(index(word, "/", back=.true.) + 1:))
         call read_file(trim(word), whole(i)%text, error)
         if (allocated(error)) call give_up(error%message)
      end do
   end subroutine arguments

   !> Read the deck as `--check` does.
   subroutine look_at(path, is_refused, fault)
      character(len=*), intent(in) :: path           !! The deck
      logical, intent(out) :: is_refused             !! With a message and exit code 2 or 3
      character(len=:), allocatable, intent(out) :: fault !! Message, or empty
      type(run_setup_t) :: setup
      type(error_t), allocatable :: error
      type(text_t), allocatable :: words(:)

      call append(words, "--check")
      call append(words, path)
      fault = ""
      is_refused = .false.
      call declare_deck_keys(setup%schema)
      setup%most_points = 1.0e5
      call parse_command_line(words, setup%command, error)
      if (.not. allocated(error)) call read_setup(setup, error)
      if (.not. allocated(error)) call build_setup(setup, error)
      if (.not. allocated(error)) return
      fault = error%message
      is_refused = error%code == exit_input .or. error%code == exit_file
      if (.not. is_refused) fault = "exit code "//number(error%code)//": "//fault
   end subroutine look_at

   !> Write a file, bytes as they are.
   subroutine write_bytes(path, text)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: text
      integer :: status, unit

      open (newunit=unit, file=path, access="stream", status="replace", iostat=status)
      if (status /= 0) call give_up("cannot write "//path)
      write (unit) text
      close (unit)
   end subroutine write_bytes

   !> End with an exit code.
   subroutine give_up(message)
      character(len=*), intent(in) :: message        !! Last words

      write (output_unit, "(a)") message
      stop 1
   end subroutine give_up
end program fuzz_files
