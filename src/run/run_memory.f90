! SPDX-License-Identifier: BSD-3-Clause
!> Memory of a run: refuses one that needs more than there is, before it allocates anything, and
!! ends the program with a message where the system refuses memory nevertheless.
module run_memory
   use base_communicator, only: communicator_t
   use base_error, only: exit_file
   use base_kinds, only: wp
   use base_memory, only: address_space, available_memory
   use base_process, only: ranks_here
   use base_text, only: size_text
   use deck_reader, only: deck_t, group_t
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_ptr, c_size_t
   implicit none
   private

   public :: check_memory, end_without_memory, memory_suffices

   interface
      !> Write bytes to a file of the process, without a buffer.
      function c_write(file, text, length) bind(c, name="write") result(written)
         import :: c_char, c_int, c_size_t
         implicit none
         integer(c_int), value :: file                   !! 2: standard error
         integer(c_size_t), value :: length
         character(kind=c_char), intent(in) :: text(length)
         integer(c_size_t) :: written
      end function c_write

      !> End the process at once, without procedures that might need memory.
      subroutine c_exit(code) bind(c, name="_exit")
         import :: c_int
         implicit none
         integer(c_int), value :: code
      end subroutine c_exit
   end interface

contains

   !> Refuse a run that needs more memory than the node of some rank has, or than the limit of the
   !! address space of its process leaves; or only warn, if it will not run here and now.
   !! Collective.
   subroutine check_memory(deck, communicator, bytes, group, key, remedy, refuses)
      type(deck_t), intent(inout) :: deck                !! Collects errors and warnings
      type(communicator_t), intent(in) :: communicator   !! All ranks have equal parts
      real(wp), intent(in) :: bytes                      !! Need of all ranks together
      type(group_t), intent(in) :: group                 !! Whose line is reported
      character(len=*), intent(in) :: key                !! Key of the group
      character(len=*), intent(in) :: remedy             !! What to write instead
      logical, intent(in) :: refuses                     !! Is it an error?
      character(len=:), allocatable :: text
      real(wp) :: left

      left = communicator%minimum(memory_left(communicator))
      if (bytes <= left*real(communicator%size, wp)) return
      text = "the run needs about "//size_text(bytes)//" of memory, and "// &
         size_text(left*real(communicator%size, wp))//" are available"
      if (communicator%size > 1) text = text//" for equal parts of all ranks"
      text = text//"; "//remedy//", or use more nodes [R134]"
      if (refuses) then
         text = text//", or continue with --force"
         call deck%add_error(group, text, key)
      else
         call deck%warn(group, text, key)
      end if
   end subroutine check_memory

   !> True if this process has memory for so many bytes.
   logical function memory_suffices(bytes) result(yes)
      real(wp), intent(in) :: bytes                      !! Need of the process
      type(communicator_t) :: alone

      yes = bytes <= memory_left(alone)
   end function memory_suffices

   !> Memory that is left for this rank [byte].
   real(wp) function memory_left(communicator) result(bytes)
      type(communicator_t), intent(in) :: communicator

      bytes = min(real(available_memory(), wp)/real(max(min(ranks_here(), communicator%size), 1), &
         wp), real(address_space(), wp))
   end function memory_left

   !> End the program where an array cannot be allocated. The run-time library of gfortran calls its
   !! procedure of this name there, which prints a list of addresses and ends with exit code 1; in
   !! the program and in the library of Scree this one takes its place. It allocates nothing.
   subroutine end_without_memory(place, form) bind(c, name="_gfortran_os_error_at")
      type(c_ptr), value :: place                        !! Text: file and line, if known
      type(c_ptr), value :: form                         !! Text: size of the array, a format of C
      character(len=*), parameter :: text = "error: out of memory: an array cannot be "// &
         "allocated; use larger cells or fewer ppc, fewer ranks on a node, or more nodes "// &
         "(scree --check DECK prints the memory of a run) [R135]"//new_line("a")
      character(kind=c_char) :: letters(len(text))
      integer(c_size_t) :: ignored
      integer :: n

      do n = 1, len(text)
         letters(n) = text(n:n)
      end do
      ignored = c_write(2_c_int, letters, int(len(text), c_size_t))
      call c_exit(int(exit_file, c_int))
   end subroutine end_without_memory
end module run_memory
