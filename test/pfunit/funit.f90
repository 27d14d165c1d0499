! SPDX-License-Identifier: BSD-3-Clause
!> The part of pFUnit's serial interface that the tests use.
module funit
   use funit_assert_plain, only: assertequal, assertfalse, asserttrue
   use funit_assert_real, only: assertequal, assertgreaterthan, assertlessthan
   use funit_assert_whole, only: assertequal, assertgreaterthan, assertlessthan
   use funit_report, only: anyexceptions, sourcelocation
   implicit none
   private

   public :: anyexceptions, assertequal, assertfalse, assertgreaterthan, assertlessthan, &
      asserttrue, sourcelocation
end module funit
