! SPDX-License-Identifier: BSD-3-Clause
!> Common parts of the programs that damage input: their command line, their files, the reading of a
!! deck with all checks of `--check`, and the end with a message.
module fuzz_session
   use base_error, only: error_t
   use base_file, only: read_file
   use base_kinds, only: wp
   use base_text, only: append, text_t
   use deck_schema, only: schema_t
   use grains_deck, only: check_grains
   use, intrinsic :: iso_fortran_env, only: output_unit
   use run_setup, only: a_grain_cell, a_scene, run_setup_t
   implicit none
   private

   public :: give_up, read_arguments, read_scene, write_bytes

contains

   !> Read FOLDER FIRST COUNT FILE... of the command line, and the files.
   subroutine read_arguments(usage, least, folder, first, mutations, names, whole)
      character(len=*), intent(in) :: usage          !! What to print if arguments are missing
      integer, intent(in) :: least                   !! Number of files that are needed
      character(len=:), allocatable, intent(out) :: folder !! Where to write
      integer, intent(out) :: first                  !! Number of the first mutation
      integer, intent(out) :: mutations              !! Number of mutations
      type(text_t), allocatable, intent(out) :: names(:) !! Of the files, without their folders
      type(text_t), allocatable, intent(out) :: whole(:) !! Contents of the files
      type(error_t), allocatable :: error
      character(len=1000) :: word
      integer :: i

      if (command_argument_count() < 3 + least) call give_up("usage: "//usage)
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
   end subroutine read_arguments

   !> Read a deck, and the files that it names, as `--check` does.
   subroutine read_scene(schema, path, grains, most_points, setup, error)
      type(schema_t), intent(in) :: schema           !! What is allowed
      character(len=*), intent(in) :: path           !! The deck
      logical, intent(in) :: grains                  !! True for a deck of --grains
      real(wp), intent(in) :: most_points            !! Bodies with more points are refused
      type(run_setup_t), intent(inout) :: setup !! Not set on entry; setup of the deck on return
      type(error_t), allocatable, intent(out) :: error !! Error in the deck or its files
      type(text_t), allocatable :: words(:)

      call append(words, path)
      setup%schema = schema
      setup%most_points = most_points
      call setup%options%parse(words, error)
      if (.not. allocated(error)) call setup%read(merge(a_grain_cell, a_scene, grains), error)
      if (allocated(error)) return
      if (grains) then
         call check_grains(setup%deck)
         call setup%deck%verdict(error)
      else
         call setup%build(.false., error)
      end if
   end subroutine read_scene

   !> Write the bytes of a file.
   subroutine write_bytes(path, text)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: text
      integer :: status, unit

      open (newunit=unit, file=path, access="stream", status="replace", action="write", &
         iostat=status)
      if (status /= 0) call give_up("cannot write "//path)
      write (unit) text
      close (unit)
   end subroutine write_bytes

   !> End with an exit code.
   subroutine give_up(message)
      character(len=*), intent(in) :: message        !! Message to print

      write (output_unit, "(a)") message
      stop 1
   end subroutine give_up
end module fuzz_session
