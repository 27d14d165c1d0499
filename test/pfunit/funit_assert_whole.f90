! SPDX-License-Identifier: BSD-3-Clause
!> Assertions about integers, with the names and the order of arguments of pFUnit.
module funit_assert_whole
   use funit_report, only: sourcelocation, throw
   use, intrinsic :: iso_fortran_env, only: int32, int64
   implicit none
   private

   public :: assertequal, assertgreaterthan, assertlessthan

   !> Two integers are equal.
   interface assertequal
      module procedure equal_int32_0_0
      module procedure equal_int32_1_1
      module procedure equal_int32_0_1
      module procedure equal_int32_2_2
      module procedure equal_int32_0_2
      module procedure equal_int64_0_0
      module procedure equal_int64_1_1
      module procedure equal_int64_0_1
      module procedure equal_int64_2_2
      module procedure equal_int64_0_2
      module procedure equal_int32_int64_0_0
      module procedure equal_int32_int64_1_1
      module procedure equal_int32_int64_0_1
   end interface assertequal

   !> The first number is less than the second.
   interface assertlessthan
      module procedure less_int32
      module procedure less_int64
   end interface assertlessthan

   !> The first number is greater than the second.
   interface assertgreaterthan
      module procedure greater_int32
      module procedure greater_int64
   end interface assertgreaterthan

contains

   subroutine equal_int32_0_0(expected, found, message, location)
      integer(int32), intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         int([expected], int64), &
         int([found], int64), message, location)
   end subroutine equal_int32_0_0

   subroutine equal_int32_1_1(expected, found, message, location)
      integer(int32), intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         int(expected, int64), &
         int(found, int64), message, location)
   end subroutine equal_int32_1_1

   subroutine equal_int32_0_1(expected, found, message, location)
      integer(int32), intent(in) :: expected, found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(found), shape(found), &
         int(spread(expected, 1, size(found)), int64), &
         int(found, int64), message, location)
   end subroutine equal_int32_0_1

   subroutine equal_int32_2_2(expected, found, message, location)
      integer(int32), intent(in) :: expected(:, :), found(:, :)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         int(reshape(expected, [size(expected)]), int64), &
         int(reshape(found, [size(found)]), int64), message, location)
   end subroutine equal_int32_2_2

   subroutine equal_int32_0_2(expected, found, message, location)
      integer(int32), intent(in) :: expected, found(:, :)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(found), shape(found), &
         int(spread(expected, 1, size(found)), int64), &
         int(reshape(found, [size(found)]), int64), message, location)
   end subroutine equal_int32_0_2

   subroutine equal_int64_0_0(expected, found, message, location)
      integer(int64), intent(in) :: expected, found
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         [expected], &
         [found], message, location)
   end subroutine equal_int64_0_0

   subroutine equal_int64_1_1(expected, found, message, location)
      integer(int64), intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         expected, &
         found, message, location)
   end subroutine equal_int64_1_1

   subroutine equal_int64_0_1(expected, found, message, location)
      integer(int64), intent(in) :: expected, found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(found), shape(found), &
         spread(expected, 1, size(found)), &
         found, message, location)
   end subroutine equal_int64_0_1

   subroutine equal_int64_2_2(expected, found, message, location)
      integer(int64), intent(in) :: expected(:, :), found(:, :)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         reshape(expected, [size(expected)]), &
         reshape(found, [size(found)]), message, location)
   end subroutine equal_int64_2_2

   subroutine equal_int64_0_2(expected, found, message, location)
      integer(int64), intent(in) :: expected, found(:, :)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(found), shape(found), &
         spread(expected, 1, size(found)), &
         reshape(found, [size(found)]), message, location)
   end subroutine equal_int64_0_2

   subroutine equal_int32_int64_0_0(expected, found, message, location)
      integer(int32), intent(in) :: expected
      integer(int64), intent(in) :: found
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         int([expected], int64), &
         [found], message, location)
   end subroutine equal_int32_int64_0_0

   subroutine equal_int32_int64_1_1(expected, found, message, location)
      integer(int32), intent(in) :: expected(:)
      integer(int64), intent(in) :: found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         int(expected, int64), &
         found, message, location)
   end subroutine equal_int32_int64_1_1

   subroutine equal_int32_int64_0_1(expected, found, message, location)
      integer(int32), intent(in) :: expected
      integer(int64), intent(in) :: found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(found), shape(found), &
         int(spread(expected, 1, size(found)), int64), &
         found, message, location)
   end subroutine equal_int32_int64_0_1

   !> All comparisons for equality end here.
   subroutine compare(shape_expected, shape_found, expected, found, message, location)
      integer, intent(in) :: shape_expected(:), shape_found(:)
      integer(int64), intent(in) :: expected(:), found(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location
      character(len=200) :: text
      integer :: element

      if (any(shape_expected /= shape_found)) then
         call throw("the shapes differ", message, location)
         return
      end if
      do element = 1, size(expected)
         if (expected(element) == found(element)) cycle
         write (text, "(a, i0, a, i0)") "expected ", expected(element), ", found ", found(element)
         if (size(shape_found) > 0) &
            write (text(len_trim(text) + 1:), "(a, i0)") ", element ", element
         call throw(trim(text), message, location)
         return
      end do
   end subroutine compare

   subroutine less_int32(left, right, message, location)
      integer(int32), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(int(left, int64), int(right, int64), message, location)
   end subroutine less_int32

   subroutine greater_int32(left, right, message, location)
      integer(int32), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(int(right, int64), int(left, int64), message, location)
   end subroutine greater_int32

   subroutine less_int64(left, right, message, location)
      integer(int64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(left, right, message, location)
   end subroutine less_int64

   subroutine greater_int64(left, right, message, location)
      integer(int64), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(right, left, message, location)
   end subroutine greater_int64

   !> All order comparisons end here.
   subroutine order(lower, upper, message, location)
      integer(int64), intent(in) :: lower, upper
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location
      character(len=100) :: text

      if (lower < upper) return
      write (text, "(a, i0, a, i0)") "not less: ", lower, " < ", upper
      call throw(trim(text), message, location)
   end subroutine order
end module funit_assert_whole
