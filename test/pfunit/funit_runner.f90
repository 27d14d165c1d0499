! SPDX-License-Identifier: BSD-3-Clause
!> Runs tests on one rank.
module funit_runner
   use funit_report, only: anyexceptions, begin_test, failures_of_test
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: output_unit
   implicit none
   private

   public :: finish_tests, is_wanted, quit, run_test, summary_t

   !> Results so far.
   type :: summary_t
      integer :: tests = 0                            !! Number of tests
      integer :: failed = 0                           !! Those that failed
   contains
      procedure :: add => summary_add                 !! Record a test and print its line
      procedure :: print => summary_print             !! Print the totals
   end type summary_t

   abstract interface
      subroutine method_i()
         implicit none
      end subroutine method_i
   end interface

   interface
      subroutine quit(code) bind(c, name="exit")
         import :: c_int
         implicit none
         integer(c_int), value :: code
      end subroutine quit
   end interface

contains

   !> Record a test and print its line.
   subroutine summary_add(self, name, failed)
      class(summary_t), intent(inout) :: self         !! Results so far
      character(len=*), intent(in) :: name            !! Name of the test
      logical, intent(in) :: failed                   !! True if it failed on some rank

      self%tests = self%tests + 1
      if (failed) self%failed = self%failed + 1
      if (failed) write (output_unit, "(2a)") "FAIL ", name
      if (.not. failed) write (output_unit, "(2a)") "ok   ", name
      flush (output_unit)
   end subroutine summary_add

   !> Print the totals.
   subroutine summary_print(self)
      class(summary_t), intent(in) :: self            !! What has run so far

      write (output_unit, "(i0, a, i0, a)") self%tests, " tests, ", self%failed, " failed"
      flush (output_unit)
   end subroutine summary_print

   !> True if the arguments of the program name this module, or if there are none.
   function is_wanted(module_name) result(wanted)
      character(len=*), intent(in) :: module_name     !! Such as test_base_text
      logical :: wanted
      character(len=80) :: word
      integer :: number

      wanted = command_argument_count() == 0
      do number = 1, command_argument_count()
         call get_command_argument(number, word)
         wanted = wanted .or. word == module_name
      end do
   end function is_wanted

   !> Run one test. It does not run if its setup fails.
   subroutine run_test(summary, name, method, before, after)
      type(summary_t), intent(inout) :: summary       !! What has run so far
      character(len=*), intent(in) :: name            !! Name of the test
      procedure(method_i) :: method                   !! The test
      procedure(method_i), optional :: before         !! Runs before it
      procedure(method_i), optional :: after          !! Runs after it

      call begin_test(name)
      if (present(before)) call before()
      if (.not. anyexceptions()) then
         call method()
         if (present(after)) call after()
      end if
      call summary%add(name, failures_of_test() > 0)
   end subroutine run_test

   !> Print the totals and end with exit code 1 if a test failed or none ran.
   subroutine finish_tests(summary)
      type(summary_t), intent(in) :: summary          !! Results of all tests

      call summary%print()
      if (summary%failed > 0 .or. summary%tests == 0) call quit(1_c_int)
   end subroutine finish_tests
end module funit_runner
