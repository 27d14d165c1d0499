! SPDX-License-Identifier: BSD-3-Clause
!> Damages input files of a deck at random and reads the deck with all checks of `--check`, in one
!! process.
!!
!! Usage: fuzz_files FOLDER FIRST COUNT DECK FILE...
!! The deck names the files without their folder. Mutation number n is the same in every call.
!! FOLDER holds copies of all files; after a crash they are the files that caused it.
!! Requirement: the deck is accepted, or refused with a message and exit code 2 or 3.
program fuzz_files
   use base_error, only: error_t, exit_file, exit_input
   use base_kinds, only: wp
   use base_text, only: number, text_t
   use deck_schema, only: schema_t
   use fuzz_mutation, only: choice_t, damage, mutate
   use fuzz_session, only: give_up, read_arguments, read_scene, write_bytes
   use, intrinsic :: iso_fortran_env, only: output_unit
   use run_setup, only: declare_deck_keys, run_setup_t
   implicit none

   real(wp), parameter :: most_points = 1.0e5_wp

   call fuzz()

contains

   !> All mutations. All memory allocated here is freed before the program ends.
   subroutine fuzz()
      type(schema_t) :: schema
      type(text_t), allocatable :: names(:), whole(:)
      character(len=:), allocatable :: folder, text, fault
      type(choice_t) :: choice
      integer, allocatable :: refused(:)
      integer :: first, mutations, n, which, failures
      logical :: is_refused

      call read_arguments("fuzz_files FOLDER FIRST COUNT DECK FILE...", 2, folder, first, &
         mutations, names, whole)
      call declare_deck_keys(schema)
      do n = 1, size(whole)
         call write_bytes(folder//"/"//names(n)%text, whole(n)%text)
      end do
      call look_at(schema, folder//"/"//names(1)%text, is_refused, fault)
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
         call look_at(schema, folder//"/"//names(1)%text, is_refused, fault)
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

   !> Read the deck and check the result.
   subroutine look_at(schema, path, is_refused, fault)
      type(schema_t), intent(in) :: schema           !! What is allowed
      character(len=*), intent(in) :: path           !! The deck
      logical, intent(out) :: is_refused             !! With a message and exit code 2 or 3
      character(len=:), allocatable, intent(out) :: fault !! Message, or empty
      type(run_setup_t) :: setup
      type(error_t), allocatable :: error

      call read_scene(schema, path, .false., most_points, setup, error)
      fault = ""
      is_refused = .false.
      if (.not. allocated(error)) return
      fault = error%message
      is_refused = error%code == exit_input .or. error%code == exit_file
      if (.not. is_refused) fault = "exit code "//number(error%code)//": "//fault
   end subroutine look_at
end program fuzz_files
