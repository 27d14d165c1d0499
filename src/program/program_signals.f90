! SPDX-License-Identifier: BSD-3-Clause
!> Signals that ask a run to write a checkpoint and leave.
module program_signals
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int
   implicit none
   private

   public :: outlive_file_limit, signal_caught, watch_signal

   !> A signal handler has no arguments of its own, so this one number cannot live in a type.
   integer(c_int), volatile :: caught = 0

   interface
      !> signal(2) of the C library.
      function c_signal(number, handler) bind(c, name="signal") result(previous)
         import :: c_funptr, c_int
         implicit none
         integer(c_int), value, intent(in) :: number   !! Which signal
         type(c_funptr), value, intent(in) :: handler  !! What it calls
         type(c_funptr) :: previous
      end function c_signal
   end interface

contains

   !> Catch a signal by name: TERM, USR1, USR2, INT or HUP (Linux numbers).
   subroutine watch_signal(name)
      character(len=*), intent(in) :: name             !! Without SIG
      type(c_funptr) :: previous

      select case (name)
      case ("TERM")
         previous = c_signal(15_c_int, c_funloc(handle))
      case ("USR1")
         previous = c_signal(10_c_int, c_funloc(handle))
      case ("INT")
         previous = c_signal(2_c_int, c_funloc(handle))
      case ("USR2")
         previous = c_signal(12_c_int, c_funloc(handle))
      case ("HUP")
         previous = c_signal(1_c_int, c_funloc(handle))
      case default
         ! `none` and whatever this system does not know
      end select
   end subroutine watch_signal

   !> A write beyond the limit on the size of files (`ulimit -f`) becomes an error of that write, as
   !! on a full disk. Without this the signal SIGXFSZ ends the program.
   subroutine outlive_file_limit()
      integer(c_int), parameter :: file_limit = 25_c_int  ! SIGXFSZ of Linux
      type(c_funptr) :: previous

      previous = c_signal(file_limit, c_funloc(pass_over))
   end subroutine outlive_file_limit

   !> Do nothing: the write that caused the signal fails with a reason of its own.
   subroutine pass_over(number) bind(c)
      integer(c_int), value, intent(in) :: number      !! Which signal
   end subroutine pass_over

   !> Note the signal; the run looks at it between steps.
   subroutine handle(number) bind(c)
      integer(c_int), value, intent(in) :: number      !! Which signal

      caught = number
   end subroutine handle

   !> Number of the signal that came, 0 if none.
   integer function signal_caught() result(number)
      number = caught
   end function signal_caught
end module program_signals
