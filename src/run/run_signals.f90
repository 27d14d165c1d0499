! SPDX-License-Identifier: BSD-3-Clause
!> Signals that make a run write a checkpoint and stop, by their Linux numbers.
module run_signals
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int
   implicit none
   private

   public :: caught_signal, ignore_file_size_limit, signal_name, watch_signal

   character(len=4), parameter :: names(5) = [character(len=4) :: "HUP", "INT", "USR1", "USR2", &
      "TERM"]
   integer, parameter :: numbers(5) = [1, 2, 10, 12, 15]

   !> A signal handler has no arguments, so this number cannot be a component of a type.
   integer(c_int), volatile :: caught = 0

   interface
      !> signal(2) of the C library.
      function c_signal(number, handler) bind(c, name="signal") result(previous)
         import :: c_funptr, c_int
         implicit none
         integer(c_int), value, intent(in) :: number
         type(c_funptr), value, intent(in) :: handler
         type(c_funptr) :: previous
      end function c_signal
   end interface

contains

   !> Catch a signal. A name that is not in the list, such as `none`, has no effect.
   subroutine watch_signal(name)
      character(len=*), intent(in) :: name             !! TERM, USR1, USR2, INT or HUP
      type(c_funptr) :: previous
      integer :: n

      do n = 1, size(names)
         if (names(n) == name) previous = c_signal(int(numbers(n), c_int), c_funloc(store_signal))
      end do
   end subroutine watch_signal

   !> Make a write beyond the limit on file sizes (`ulimit -f`) an error of that write, as on a full
   !! disk. By default the signal SIGXFSZ ends the program.
   subroutine ignore_file_size_limit()
      integer(c_int), parameter :: sigxfsz = 25_c_int
      type(c_funptr) :: previous

      previous = c_signal(sigxfsz, c_funloc(ignore_signal))
   end subroutine ignore_file_size_limit

   !> Do nothing: the write that caused the signal fails with its own error.
   subroutine ignore_signal(number) bind(c)
      integer(c_int), value, intent(in) :: number
   end subroutine ignore_signal

   !> Store the number of the signal; the time loop reads it between steps.
   subroutine store_signal(number) bind(c)
      integer(c_int), value, intent(in) :: number

      caught = number
   end subroutine store_signal

   !> Number of the signal that was caught last, 0 if none.
   integer function caught_signal() result(number)
      number = caught
   end function caught_signal

   !> Name of a signal accepted by `watch_signal`.
   pure function signal_name(number) result(name)
      integer, intent(in) :: number                    !! From `caught_signal`
      character(len=:), allocatable :: name
      integer :: n

      name = "of another kind"
      do n = 1, size(numbers)
         if (numbers(n) == number) name = trim(names(n))
      end do
   end function signal_name
end module run_signals
