! SPDX-License-Identifier: BSD-3-Clause
!> Assertions about real numbers, with the names and the order of arguments of pFUnit.
module funit_assert_real
   use funit_report, only: sourcelocation, throw
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use, intrinsic :: iso_fortran_env, only: wp => real64
   implicit none
   private

   public :: assertequal, assertgreaterthan, assertlessthan

   !> Two numbers differ by no more than a tolerance, zero unless given.
   interface assertequal
      module procedure equal_0_0
      module procedure equal_1_1
      module procedure equal_0_1
      module procedure equal_2_2
      module procedure equal_0_2
   end interface assertequal

   !> The first number is less than the second.
   interface assertlessthan
      module procedure less_0_0
      module procedure less_1_1
      module procedure less_0_1
   end interface assertlessthan

   !> The first number is greater than the second.
   interface assertgreaterthan
      module procedure greater_0_0
      module procedure greater_1_1
      module procedure greater_0_1
   end interface assertgreaterthan

contains

   subroutine equal_0_0(expected, found, tolerance, message, location)
      real(wp), intent(in) :: expected, found
      real(wp), intent(in), optional :: tolerance
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         [expected], &
         [found], tolerance, message, location)
   end subroutine equal_0_0

   subroutine equal_1_1(expected, found, tolerance, message, location)
      real(wp), intent(in) :: expected(:), found(:)
      real(wp), intent(in), optional :: tolerance
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         expected, &
         found, tolerance, message, location)
   end subroutine equal_1_1

   subroutine equal_0_1(expected, found, tolerance, message, location)
      real(wp), intent(in) :: expected, found(:)
      real(wp), intent(in), optional :: tolerance
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(found), shape(found), &
         spread(expected, 1, size(found)), &
         found, tolerance, message, location)
   end subroutine equal_0_1

   subroutine equal_2_2(expected, found, tolerance, message, location)
      real(wp), intent(in) :: expected(:, :), found(:, :)
      real(wp), intent(in), optional :: tolerance
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(expected), shape(found), &
         reshape(expected, [size(expected)]), &
         reshape(found, [size(found)]), tolerance, message, location)
   end subroutine equal_2_2

   subroutine equal_0_2(expected, found, tolerance, message, location)
      real(wp), intent(in) :: expected, found(:, :)
      real(wp), intent(in), optional :: tolerance
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call compare(shape(found), shape(found), &
         spread(expected, 1, size(found)), &
         reshape(found, [size(found)]), tolerance, message, location)
   end subroutine equal_0_2

   !> All comparisons for equality end here.
   subroutine compare(shape_expected, shape_found, expected, found, tolerance, message, location)
      integer, intent(in) :: shape_expected(:), shape_found(:)
      real(wp), intent(in) :: expected(:), found(:)
      real(wp), intent(in), optional :: tolerance
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location
      real(wp) :: limit
      character(len=200) :: text
      integer :: element

      if (any(shape_expected /= shape_found)) then
         call throw("the shapes differ", message, location)
         return
      end if
      limit = 0
      if (present(tolerance)) limit = tolerance
      do element = 1, size(expected)
         if (agree(expected(element), found(element), limit)) cycle
         write (text, "(a, es24.16, a, es24.16, a, es10.3)") "expected", &
            expected(element), ", found", found(element), ", tolerance", limit
         if (size(shape_found) > 0) &
            write (text(len_trim(text) + 1:), "(a, i0)") ", element ", element
         call throw(trim(text), message, location)
         return
      end do
   end subroutine compare

   !> True if two numbers differ by no more than a limit. A NaN equals nothing. It is tested first,
   !! because a comparison would raise a floating point exception in a Debug build.
   pure function agree(expected, found, limit) result(good)
      real(wp), intent(in) :: expected, found, limit
      logical :: good

      good = .false.
      if (ieee_is_nan(expected) .or. ieee_is_nan(found)) return
      good = expected <= found .and. expected >= found
      if (good .or. .not. (ieee_is_finite(expected) .and. ieee_is_finite(found))) return
      good = abs(expected - found) <= limit
   end function agree

   subroutine less_0_0(left, right, message, location)
      real(wp), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(shape(left), shape(right), [left], [right], message, location)
   end subroutine less_0_0

   subroutine less_1_1(left, right, message, location)
      real(wp), intent(in) :: left(:), right(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(shape(left), shape(right), left, right, message, location)
   end subroutine less_1_1

   subroutine less_0_1(left, right, message, location)
      real(wp), intent(in) :: left, right(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(shape(right), shape(right), spread(left, 1, size(right)), right, message, location)
   end subroutine less_0_1

   subroutine greater_0_0(left, right, message, location)
      real(wp), intent(in) :: left, right
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(shape(left), shape(right), [right], [left], message, location)
   end subroutine greater_0_0

   subroutine greater_1_1(left, right, message, location)
      real(wp), intent(in) :: left(:), right(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(shape(left), shape(right), right, left, message, location)
   end subroutine greater_1_1

   subroutine greater_0_1(left, right, message, location)
      real(wp), intent(in) :: left, right(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location

      call order(shape(right), shape(right), right, spread(left, 1, size(right)), message, location)
   end subroutine greater_0_1

   !> All order comparisons end here.
   subroutine order(shape_left, shape_right, lower, upper, message, location)
      integer, intent(in) :: shape_left(:), shape_right(:)
      real(wp), intent(in) :: lower(:), upper(:)
      character(len=*), intent(in), optional :: message
      type(sourcelocation), intent(in), optional :: location
      character(len=200) :: text
      integer :: element

      if (any(shape_left /= shape_right)) then
         call throw("the shapes differ", message, location)
         return
      end if
      do element = 1, size(lower)
         if (.not. (ieee_is_nan(lower(element)) .or. ieee_is_nan(upper(element)))) then
            if (lower(element) < upper(element)) cycle
         end if
         write (text, "(a, es24.16, a, es24.16)") "not less:", lower(element), " <", &
            upper(element)
         call throw(trim(text), message, location)
         return
      end do
   end subroutine order
end module funit_assert_real
