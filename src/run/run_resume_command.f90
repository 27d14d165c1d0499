! SPDX-License-Identifier: BSD-3-Clause
!> The command that continues a run, from the words with which the program was called.
module run_resume_command
   use base_text, only: text_t
   implicit none
   private

   public :: program_arguments, quoted, resume_command

contains

   !> The arguments of the program.
   function program_arguments() result(arguments)
      type(text_t), allocatable :: arguments(:)
      character(len=:), allocatable :: argument
      integer :: i, length

      allocate (arguments(command_argument_count()))
      do i = 1, size(arguments)
         call get_command_argument(i, length=length)
         allocate (character(len=length) :: argument)
         if (length > 0) call get_command_argument(i, argument)
         call move_alloc(argument, arguments(i)%text)
      end do
   end function program_arguments

   !> The command that continues a run that was stopped with a checkpoint: the command line, with
   !! --restart in place of one that may name an older file.
   function resume_command(ranks) result(text)
      integer, intent(in) :: ranks                   !! Number of ranks of the run
      character(len=:), allocatable :: text
      type(text_t), allocatable :: arguments(:)
      character(len=16) :: digits
      integer :: n
      logical :: after

      text = ""
      write (digits, "(i0)") ranks
      if (ranks > 1) text = "mpirun -n "//trim(digits)//" "
      text = text//quoted(program_name())
      after = .false.
      allocate (arguments, source=program_arguments())
      do n = 1, size(arguments)
         call add_word(arguments(n)%text, after, text)
      end do
      text = text//" --restart"
   end function resume_command

   !> Add a word to the command, unless it is --restart, the file after it, or --overwrite.
   pure subroutine add_word(word, after, text)
      character(len=*), intent(in) :: word           !! From the command line
      logical, intent(inout) :: after                !! Was the previous word --restart?
      character(len=:), allocatable, intent(inout) :: text !! Extended
      logical :: file

      file = after .and. len(word) > 3 .and. index(word, ".h5", back=.true.) == len(word) - 2
      after = word == "--restart" .or. word == "-r"
      if (.not. (file .or. after .or. word == "--overwrite" .or. index(word, "--restart=") == 1)) &
         text = text//" "//quoted(word)
   end subroutine add_word

   !> The name under which the program was called.
   function program_name() result(name)
      character(len=:), allocatable :: name
      integer :: length

      call get_command_argument(0, length=length)
      allocate (character(len=length) :: name)
      if (length > 0) call get_command_argument(0, name)
   end function program_name

   !> A word in the quotes that the shell needs.
   pure function quoted(word) result(text)
      character(len=*), intent(in) :: word           !! Text
      character(len=:), allocatable :: text
      character(len=*), parameter :: plain = "abcdefghijklmnopqrstuvwxyz"// &
         "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+=:,@%"
      integer :: letter

      text = word
      if (len(word) > 0 .and. verify(word, plain) == 0) return
      text = "'"
      do letter = 1, len(word)
         if (word(letter:letter) == "'") then
            text = text//"'\''"
         else
            text = text//word(letter:letter)
         end if
      end do
      text = text//"'"
   end function quoted
end module run_resume_command
