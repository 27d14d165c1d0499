! SPDX-License-Identifier: BSD-3-Clause
!> The part of pFUnit's interface for several ranks that the tests use.
module pfunit
   use funit, only: anyexceptions, assertequal, assertfalse, assertgreaterthan, assertlessthan, &
      asserttrue, sourcelocation
   use pfunit_method, only: mpitestmethod
   implicit none
   private

   public :: anyexceptions, assertequal, assertfalse, assertgreaterthan, assertlessthan, &
      asserttrue, mpitestmethod, sourcelocation
end module pfunit
