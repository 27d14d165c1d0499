! SPDX-License-Identifier: BSD-3-Clause
!> Systems of units of decks and outputs, and their conversion to SI.
!!
!! All systems differ from SI by powers of ten, so a conversion shifts the decimal exponent of the
!! written number before it is read: 2.79 g/cm3 and 2790 kg/m3 become the same bits.
module base_units
   use base_kinds, only: wp
   use base_text, only: is_letter
   implicit none
   private

   public :: output_units_t, system_number, unit_of, unit_t

   !> The systems by name.
   character(len=8), parameter, public :: system_names(6) = [character(len=8) :: "si", "cgs", &
      "mm-ms-kg", "mm-ms-g", "cm-us-g", "mm-us-mg"]
   integer, parameter, public :: system_si = 1           !! Index of SI

   !> Decimal exponent of the units of length, time, mass and temperature of each system in SI.
   integer, parameter :: system_exponents(4, 6) = reshape([ &
      0, 0, 0, 0, &
      -2, 0, -3, 0, &
      -3, -3, 0, 0, &
      -3, -3, -3, 0, &
      -2, -6, -3, 0, &
      -3, -6, -6, 0], [4, 6])

   !> Names of the units of length, time, mass and temperature of each system.
   character(len=2), parameter :: system_symbols(4, 6) = reshape([ &
      "m ", "s ", "kg", "K ", &
      "cm", "s ", "g ", "K ", &
      "mm", "ms", "kg", "K ", &
      "mm", "ms", "g ", "K ", &
      "cm", "us", "g ", "K ", &
      "mm", "us", "mg", "K "], [4, 6])

   !> The system of units of outputs.
   type :: output_units_t
      integer :: system = system_si                      !! From `system_number`
   contains
      procedure :: label => output_label                 !! Name of a unit in it
      procedure :: factor => output_factor               !! One unit of it in SI
      procedure :: shown => output_shown                 !! A number in it
   end type output_units_t

   !> A unit of SI as powers of its base units. Angles stay in degrees and have no dimension here.
   type :: unit_t
      real(wp) :: power(4) = 0.0_wp !! Powers of length, time, mass, temperature
   contains
      procedure :: exponent => unit_exponent             !! Decimal exponent of the conversion to SI
   end type unit_t

   !> Symbols of units, and their powers of length, time, mass, temperature.
   character(len=3), parameter :: symbols(10) = [character(len=3) :: "m", "s", "kg", "K", "N", &
      "J", &
      "W", "Pa", "deg", "1"]
   integer, parameter :: symbol_powers(4, 10) = reshape([ &
      1, 0, 0, 0, &
      0, 1, 0, 0, &
      0, 0, 1, 0, &
      0, 0, 0, 1, &
      1, -2, 1, 0, &
      2, -2, 1, 0, &
      2, -3, 1, 0, &
      -1, -2, 1, 0, &
      0, 0, 0, 0, &
      0, 0, 0, 0], [4, 10])

contains

   !> Number of a system of units, 0 if there is none of that name.
   pure integer function system_number(name) result(system)
      character(len=*), intent(in) :: name               !! Name as in the deck

      do system = size(system_names), 1, -1
         if (system_names(system) == name) return
      end do
   end function system_number

   !> The unit of a text such as J/(kg K), kg/m3 or Pa m0.5.
   pure subroutine unit_of(text, unit, known)
      character(len=*), intent(in) :: text               !! Symbols with powers; one slash at most
      type(unit_t), intent(out) :: unit
      logical, intent(out) :: known                      !! Are all symbols known?
      real(wp) :: power, side
      integer :: first, last, place, status

      known = .true.
      side = 1.0_wp
      first = 1
      do while (first <= len_trim(text) .and. known)
         select case (text(first:first))
         case ("/")
            side = -1.0_wp
         case (" ", "(", ")", "1")
            continue
         case default
            last = first
            do while (last < len_trim(text))
               if (.not. is_letter(text(last + 1:last + 1))) exit
               last = last + 1
            end do
            place = size(symbols)
            do while (place > 0)
               if (symbols(place) == text(first:last)) exit
               place = place - 1
            end do
            known = place > 0
            if (.not. known) exit
            first = last + 1
            last = last + max(verify(text(first:)//"/", "0123456789.") - 1, 0)
            power = 1.0_wp
            if (last >= first) read (text(first:last), *, iostat=status) power
            unit%power = unit%power + side*power*real(symbol_powers(:, place), wp)
            first = last
         end select
         first = first + 1
      end do
   end subroutine unit_of

   !> Name of the unit of a system for a unit of SI, such as mg/(mm us2) for Pa.
   pure function output_label(self, unit_text) result(label)
      class(output_units_t), intent(in) :: self
      character(len=*), intent(in) :: unit_text          !! Unit of SI
      character(len=:), allocatable :: label
      character(len=:), allocatable :: above, below, symbol
      character(len=8) :: power
      type(unit_t) :: unit
      integer, parameter :: order(4) = [3, 1, 2, 4]      ! mass, length, time, temperature
      integer :: n, exponent
      logical :: known

      label = unit_text
      call unit_of(unit_text, unit, known)
      if (self%system == system_si .or. .not. known .or. all(nint(unit%power) == 0)) return
      above = ""
      below = ""
      do n = 1, size(order)
         exponent = nint(unit%power(order(n)))
         if (exponent == 0) cycle
         symbol = " "//trim(system_symbols(order(n), self%system))
         write (power, "(i0)") abs(exponent)
         if (abs(exponent) > 1) symbol = symbol//trim(power)
         if (exponent > 0) above = above//symbol
         if (exponent < 0) below = below//symbol
      end do
      label = "1"
      if (len(above) > 0) label = above(2:)
      if (index(below, " ", back=.true.) > 1) then
         label = label//"/("//below(2:)//")"
      else if (len(below) > 0) then
         label = label//"/"//below(2:)
      end if
   end function output_label

   !> One unit of a system in the unit of SI.
   pure real(wp) function output_factor(self, unit_text) result(factor)
      class(output_units_t), intent(in) :: self
      character(len=*), intent(in) :: unit_text          !! Unit of SI
      type(unit_t) :: unit
      logical :: known

      call unit_of(unit_text, unit, known)
      factor = 1.0_wp
      if (known .and. self%system /= system_si) factor = 10.0_wp**nint(unit%exponent(self%system))
   end function output_factor

   !> A number in SI converted to the unit of a system. It is multiplied or divided by a power of
   !! ten that is exact, so that it is rounded only once.
   elemental real(wp) function output_shown(self, value, unit_text) result(shown)
      class(output_units_t), intent(in) :: self
      real(wp), intent(in) :: value                      !! The number [SI]
      character(len=*), intent(in) :: unit_text          !! SI unit of the key
      type(unit_t) :: unit
      integer :: exponent
      logical :: known

      shown = value
      if (self%system == system_si) return
      call unit_of(unit_text, unit, known)
      if (.not. known) return
      exponent = nint(unit%exponent(self%system))
      if (exponent > 0) then
         shown = value/10.0_wp**exponent
      else
         shown = value*10.0_wp**(-exponent)
      end if
   end function output_shown

   !> Decimal exponent that converts a number of a system to SI.
   pure real(wp) function unit_exponent(self, system) result(exponent)
      class(unit_t), intent(in) :: self
      integer, intent(in) :: system                      !! From `system_number`

      exponent = sum(self%power*real(system_exponents(:, system), wp))
   end function unit_exponent
end module base_units
