! SPDX-License-Identifier: BSD-3-Clause
!> Assertions about conditions and texts, with the names and the order of arguments of pFUnit.
module funit_assert_plain
   use funit_report, only: sourcelocation, throw
   implicit none
   private

   public :: assertequal, assertfalse, asserttrue

   !> Two conditions, or two texts without their leading and trailing blanks, are equal.
   interface assertequal
      module procedure equal_logical
      module procedure equal_logicals
      module procedure equal_text
   end interface assertequal

   !> A condition holds; of an array, everywhere.
   interface asserttrue
      module procedure true_scalar
      module procedure true_array
   end interface asserttrue

   !> A condition does not hold; of an array, nowhere.
   interface assertfalse
      module procedure false_scalar
      module procedure false_array
   end interface assertfalse

contains

   subroutine equal_logical(expected, found, message, location)
      logical, intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      if (expected .neqv. found) then
         if (expected) call throw("expected true, found false", message, location)
         if (found) call throw("expected false, found true", message, location)
      end if
   end subroutine equal_logical

   subroutine equal_logicals(expected, found, message, location)
      logical, intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      if (size(expected) /= size(found)) then
         call throw("the shapes differ", message, location)
      else if (any(expected .neqv. found)) then
         call throw("the conditions differ", message, location)
      end if
   end subroutine equal_logicals

   subroutine equal_text(expected, found, message, location)
      character(len=*), intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      if (trim(adjustl(expected)) == trim(adjustl(found))) return
      call throw("expected """//expected//""", found """//found//"""", message, location)
   end subroutine equal_text

   subroutine true_scalar(condition, message, location)
      logical, intent(in) :: condition
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      if (.not. condition) call throw("not true", message, location)
   end subroutine true_scalar

   subroutine true_array(condition, message, location)
      logical, intent(in) :: condition(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      if (.not. all(condition)) call throw("not true everywhere", message, location)
   end subroutine true_array

   subroutine false_scalar(condition, message, location)
      logical, intent(in) :: condition
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      if (condition) call throw("not false", message, location)
   end subroutine false_scalar

   subroutine false_array(condition, message, location)
      logical, intent(in) :: condition(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      if (any(condition)) call throw("not false everywhere", message, location)
   end subroutine false_array
end module funit_assert_plain
