! SPDX-License-Identifier: BSD-3-Clause
!> Functions and operators of formulas. Operations without a finite result are errors, found before
!! a floating point exception.
module deck_formula_functions
   use base_constants, only: pi
   use base_kinds, only: wp
   implicit none
   private

   public :: apply_function, apply_operator, function_arguments, function_index

   !> The functions. Angles are in radians, those of sind, cosd and tand in degrees.
   character(len=7), parameter, public :: function_names(20) = [character(len=7) :: "sqrt", "exp", &
      "log", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "sind", "cosd", "tand", "abs", &
      "floor", "ceiling", "nint", "atan2", "min", "max"]
   integer, parameter, public :: takes_any = -1      !! Two arguments or more
   real(wp), parameter :: most = 1.0e307_wp          !! Greater results are an error
   !> Above this, real numbers need not be exact integers
   real(wp), parameter :: most_whole = 1.0e15_wp

contains

   !> Index of a function, 0 if there is none of that name.
   pure integer function function_index(name) result(which)
      character(len=*), intent(in) :: name           !! Lower case

      do which = size(function_names), 1, -1
         if (function_names(which) == name) return
      end do
   end function function_index

   !> Number of arguments of a function, or `takes_any`.
   pure integer function function_arguments(which) result(arguments)
      integer, intent(in) :: which                   !! Index

      select case (function_names(which))
      case ("min", "max")
         arguments = takes_any
      case ("atan2")
         arguments = 2
      case default
         arguments = 1
      end select
   end function function_arguments

   !> Replace the left value by the result of an operator.
   pure subroutine apply_operator(sign, left, right, fault)
      character(len=1), intent(in) :: sign           !! + - * / or ^ for a power
      real(wp), intent(inout) :: left                !! Left value, then the result
      real(wp), intent(in) :: right                  !! Right value
      character(len=:), allocatable, intent(inout) :: fault !! Allocated if there is no result

      select case (sign)
      case ("+")
         left = left + right
      case ("-")
         left = left - right
      case ("*")
         if (abs(right) > 1.0_wp .and. abs(left) > most/max(abs(right), 1.0_wp)) then
            fault = "the product is too large [D203]"
         else
            left = left*right
         end if
      case ("/")
         if (.not. abs(right) > 0.0_wp) then
            fault = "division by zero [D203]"
         else if (abs(right) < 1.0_wp .and. abs(left) > most*min(abs(right), 1.0_wp)) then
            fault = "the quotient is too large [D203]"
         else
            left = left/right
         end if
      case default
         call raise_to_power(left, right, fault)
      end select
      if (allocated(fault)) return
      if (abs(left) > most) fault = "the result is too large [D203]"
   end subroutine apply_operator

   !> Raise a base to a power, in place.
   pure subroutine raise_to_power(base, exponent, fault)
      real(wp), intent(inout) :: base                !! The base, then the power
      real(wp), intent(in) :: exponent               !! Exponent of the power
      character(len=:), allocatable, intent(inout) :: fault !! Allocated if there is no result
      real(wp) :: size
      logical :: odd, whole

      whole = abs(exponent) < most_whole
      if (whole) whole = .not. abs(exponent - anint(exponent)) > 0.0_wp
      odd = .false.
      if (whole) odd = modulo(exponent, 2.0_wp) > 0.0_wp
      if (.not. abs(base) > 0.0_wp) then
         if (exponent < 0.0_wp) then
            fault = "zero has no negative power [D203]"
         else
            base = merge(0.0_wp, 1.0_wp, exponent > 0.0_wp)
         end if
      else if (base < 0.0_wp .and. .not. whole) then
         fault = "a negative number has powers with integer exponents only [D203]"
      else if (exponent*log(abs(base)) > log(most)) then
         fault = "the power is too large [D203]"
      else
         size = abs(base)**exponent
         base = merge(-size, size, base < 0.0_wp .and. odd)
      end if
   end subroutine raise_to_power

   !> Replace the first argument by the value of a function.
   pure subroutine apply_function(which, first, second, fault)
      integer, intent(in) :: which                   !! Index
      real(wp), intent(inout) :: first               !! First argument, then the value
      real(wp), intent(in) :: second                 !! Second argument, if there are two
      character(len=:), allocatable, intent(inout) :: fault !! Allocated if there is no result

      select case (function_names(which))
      case ("sqrt")
         if (first < 0.0_wp) fault = "sqrt of a negative number [D203]"
         first = sqrt(max(first, 0.0_wp))
      case ("exp")
         if (first > log(most)) fault = "exp of it is too large [D203]"
         first = exp(min(first, log(most)))
      case ("log", "log10")
         if (.not. first > 0.0_wp) then
            fault = trim(function_names(which))//" of a number that is not positive [D203]"
         else if (function_names(which) == "log") then
            first = log(first)
         else
            first = log10(first)
         end if
      case ("asin", "acos")
         if (abs(first) > 1.0_wp) then
            fault = trim(function_names(which))//" of a number beyond 1 [D203]"
         else if (function_names(which) == "asin") then
            first = asin(first)
         else
            first = acos(first)
         end if
      case ("atan2")
         if (.not. (abs(first) > 0.0_wp .or. abs(second) > 0.0_wp)) then
            fault = "atan2 of two zeros [D203]"
         else
            first = atan2(first, second)
         end if
      case ("min")
         first = min(first, second)
      case ("max")
         first = max(first, second)
      case ("floor", "ceiling", "nint", "abs")
         first = rounded_value(function_names(which), first)
      case default
         call apply_angle(function_names(which), first, fault)
      end select
   end subroutine apply_function

   !> Rounded or absolute value of a number.
   pure real(wp) function rounded_value(name, value) result(near)
      character(len=*), intent(in) :: name           !! Name of the function
      real(wp), intent(in) :: value                  !! Argument of the function

      near = value
      if (name == "abs") near = abs(value)
      if (name == "abs" .or. abs(value) > most_whole) return
      near = anint(value)
      if (name == "floor" .and. near > value) near = near - 1.0_wp
      if (name == "ceiling" .and. near < value) near = near + 1.0_wp
   end function rounded_value

   !> Replace an argument by the value of a function of angles.
   pure subroutine apply_angle(name, value, fault)
      character(len=*), intent(in) :: name           !! Name of the function
      real(wp), intent(inout) :: value               !! The angle, then the value
      character(len=:), allocatable, intent(inout) :: fault !! Allocated if there is no result
      real(wp) :: below

      select case (name)
      case ("sin")
         value = sin(value)
      case ("cos")
         value = cos(value)
      case ("tan")
         value = tan(value)
      case ("atan")
         value = atan(value)
      case ("sind")
         value = sine_of_degrees(value)
      case ("cosd")
         value = sine_of_degrees(90.0_wp - modulo(value, 360.0_wp))
      case default
         below = sine_of_degrees(90.0_wp - modulo(value, 360.0_wp))
         if (.not. abs(below) > 0.0_wp) fault = "tand of an odd multiple of 90 [D203]"
         if (.not. allocated(fault)) value = sine_of_degrees(value)/below
      end select
   end subroutine apply_angle

   !> Sine of an angle in degrees; 0, 1/2 and 1 are exact, and so are the symmetries.
   pure real(wp) function sine_of_degrees(angle) result(sine)
      real(wp), intent(in) :: angle                  !! [deg]
      real(wp), parameter :: radian = pi/180.0_wp
      real(wp) :: rest
      logical :: negative

      rest = modulo(angle, 360.0_wp)
      negative = rest >= 180.0_wp
      if (negative) rest = rest - 180.0_wp
      if (rest > 90.0_wp) rest = 180.0_wp - rest
      if (.not. abs(rest - 30.0_wp) > 0.0_wp) then
         sine = 0.5_wp
      else if (rest <= 45.0_wp) then
         sine = sin(rest*radian)
      else
         sine = cos((90.0_wp - rest)*radian)
      end if
      if (negative) sine = -sine
   end function sine_of_degrees
end module deck_formula_functions
