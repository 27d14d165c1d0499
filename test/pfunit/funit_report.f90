! SPDX-License-Identifier: BSD-3-Clause
!> Failures of the test that is running. The interface of pFUnit is global, hence this module state.
module funit_report
   use, intrinsic :: iso_fortran_env, only: output_unit
   implicit none
   private

   public :: sourcelocation, throw, anyexceptions, begin_test, failures_of_test, set_rank_text

   !> A line of a test file.
   type :: sourcelocation
      character(len=120) :: file                      !! Name of the file
      integer :: line                                 !! Number of the line
   end type sourcelocation

   interface sourcelocation
      module procedure new_location
   end interface sourcelocation

   character(len=80) :: current = ""
   character(len=40) :: rank_text = ""
   integer :: failures = 0

contains

   !> Make a location from the text and the number that the translator writes.
   pure function new_location(file, line) result(location)
      character(len=*), intent(in) :: file            !! Name of the file
      integer, intent(in) :: line                     !! Number of the line
      type(sourcelocation) :: location

      location%file = file
      location%line = line
   end function new_location

   !> Begin a test.
   subroutine begin_test(name)
      character(len=*), intent(in) :: name            !! Its name

      current = name
      failures = 0
   end subroutine begin_test

   !> Set the text that identifies the rank in messages.
   subroutine set_rank_text(text)
      character(len=*), intent(in) :: text            !! Such as " (rank 1 of 2)", or empty

      rank_text = text
   end subroutine set_rank_text

   !> Record a failure and print it at once, because another rank that waits for this one may hang.
   subroutine throw(reason, message, location)
      character(len=*), intent(in) :: reason          !! Result that was found
      character(len=*), intent(in), optional :: message !! Message of the test
      type(sourcelocation), intent(in), optional :: location !! Where

      failures = failures + 1
      if (present(location)) then
         write (output_unit, "(2a, i0, 5a)") trim(location%file), ":", location%line, ": ", &
            trim(current), trim(rank_text), ": ", reason
      else
         write (output_unit, "(4a)") trim(current), trim(rank_text), ": ", reason
      end if
      if (present(message)) write (output_unit, "(2a)") "   ", message
      flush (output_unit)
   end subroutine throw

   !> True if the test has failed.
   function anyexceptions() result(failed)
      logical :: failed

      failed = failures > 0
   end function anyexceptions

   !> Number of failures of this test on this rank.
   function failures_of_test() result(number)
      integer :: number

      number = failures
   end function failures_of_test
end module funit_report
