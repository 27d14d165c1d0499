! SPDX-License-Identifier: BSD-3-Clause
!> Units of the numbers in a deck, and their way to SI.
!!
!! All systems differ from SI by powers of ten, so a conversion shifts the decimal exponent of the
!! written number before it is read: 2.79 g/cm3 and 2790 kg/m3 become the same bits.
module base_units
   use base_kinds, only: wp
   use base_text, only: is_letter
   implicit none
   private

   public :: system_number, unit_of, unit_t

   !> The systems by name.
   character(len=8), parameter, public :: system_names(6) = [character(len=8) :: "si", "cgs", &
      "mm-ms-kg", "mm-ms-g", "cm-us-g", "mm-us-mg"]
   integer, parameter, public :: system_si = 1           !! Place of SI in the list

   !> Decimal exponent of the units of length, time, mass and temperature of each system in SI.
   integer, parameter :: system_exponents(4, 6) = reshape([ &
      0, 0, 0, 0, &
      -2, 0, -3, 0, &
      -3, -3, 0, 0, &
      -3, -3, -3, 0, &
      -2, -6, -3, 0, &
      -3, -6, -6, 0], [4, 6])

   !> A unit of SI as powers of its base units. Angles stay in degrees and have no dimension here.
   type :: unit_t
      real(wp) :: power(4) = 0.0_wp                      !! Of length, time, mass, temperature
   contains
      procedure :: exponent => unit_exponent             !! Decimal exponent of the way to SI
   end type unit_t

   !> Symbols that a unit may be made of, and the powers of length, time, mass, temperature.
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
      character(len=*), intent(in) :: name               !! As in the deck

      do system = size(system_names), 1, -1
         if (system_names(system) == name) return
      end do
   end function system_number

   !> The unit that a text such as J/(kg K), kg/m3 or Pa m0.5 stands for.
   pure subroutine unit_of(text, unit, known)
      character(len=*), intent(in) :: text               !! Symbols with powers; one slash at most
      type(unit_t), intent(out) :: unit                  !! The unit
      logical, intent(out) :: known                      !! All symbols are known
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

   !> Decimal exponent that turns a number in a system into SI.
   pure real(wp) function unit_exponent(self, system) result(exponent)
      class(unit_t), intent(in) :: self                  !! The unit
      integer, intent(in) :: system                      !! From `system_number`

      exponent = sum(self%power*real(system_exponents(:, system), wp))
   end function unit_exponent
end module base_units
