! SPDX-License-Identifier: BSD-3-Clause
!> Units of decks and outputs: after a number, such as km/s or J/(kg K), and systems of units.
!!
!! Prefixes, most units and all systems differ from SI by powers of ten, so a conversion shifts the
!! decimal exponent of the written number before it is read: 2.79 g/cm3 and 2790 kg/m3 become the
!! same bits. Minutes, hours and angles have a factor as well.
module deck_units
   use base_constants, only: pi
   use base_decimal, only: decimal_none, read_decimal
   use base_kinds, only: int32, wp
   use base_text, only: append, closest, is_letter, text_t
   implicit none
   private

   public :: begins_unit, dimension_of, output_units_t, read_unit, split_unit, system_number, &
      unit_list, unit_of, unit_t, written_unit_t

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

   character(len=*), parameter :: figures = "0123456789"

   !> A unit as the user wrote it.
   type :: written_unit_t
      real(wp) :: power(4) = 0.0_wp !! Powers of length, time, mass, temperature
      real(wp) :: angle = 0.0_wp                         !! Power of the angle
      real(wp) :: exponent = 0.0_wp                      !! Decimal exponent of the conversion to SI
      real(wp) :: factor = 1.0_wp                        !! Other factor; angles in radians
      character(len=:), allocatable :: fault             !! Error, empty if there is none
   end type written_unit_t

   !> One symbol.
   type :: symbol_t
      character(len=3) :: name                           !! As written, in letters of its case
      integer :: power(4) !! Powers of length, time, mass, temperature
      integer :: exponent                                !! Decimal exponent of the conversion to SI
      logical :: prefix                                  !! May have a prefix
   end type symbol_t

   type(symbol_t), parameter :: symbols(16) = [ &
      symbol_t("m  ", [1, 0, 0, 0], 0, .true.), symbol_t("s  ", [0, 1, 0, 0], 0, .true.), &
      symbol_t("g  ", [0, 0, 1, 0], -3, .true.), symbol_t("K  ", [0, 0, 0, 1], 0, .true.), &
      symbol_t("N  ", [1, -2, 1, 0], 0, .true.), symbol_t("J  ", [2, -2, 1, 0], 0, .true.), &
      symbol_t("W  ", [2, -3, 1, 0], 0, .true.), symbol_t("Pa ", [-1, -2, 1, 0], 0, .true.), &
      symbol_t("bar", [-1, -2, 1, 0], 5, .true.), symbol_t("dyn", [1, -2, 1, 0], -5, .false.), &
      symbol_t("erg", [2, -2, 1, 0], -7, .false.), symbol_t("t  ", [0, 0, 1, 0], 3, .false.), &
      symbol_t("min", [0, 1, 0, 0], 0, .false.), symbol_t("h  ", [0, 1, 0, 0], 0, .false.), &
      symbol_t("deg", [0, 0, 0, 0], 0, .false.), symbol_t("rad", [0, 0, 0, 0], 0, .true.)]
   character(len=1), parameter :: prefixes(9) = ["p", "n", "u", "m", "c", "k", "M", "G", "T"]
   integer, parameter :: prefix_exponents(9) = [-12, -9, -6, -3, -2, 3, 6, 9, 12]
   !> Suggestions for an unknown unit.
   character(len=5), parameter :: common(40) = [character(len=5) :: "m", "mm", "cm", "um", "km", &
      "s", "ms", "us", "ns", "min", "h", "kg", "g", "mg", "t", "K", "Pa", "kPa", "MPa", "GPa", &
      "bar", "kbar", "Mbar", "N", "kN", "J", "kJ", "MJ", "W", "kW", "erg", "dyn", "deg", "rad", &
      "m/s", "km/s", "m3", "m2", "kg/m3", "g/cm3"]

contains

   !> Number of a system of units, 0 if there is none of that name.
   pure integer function system_number(name) result(system)
      character(len=*), intent(in) :: name               !! Name as in the deck

      do system = size(system_names), 1, -1
         if (system_names(system) == name) return
      end do
   end function system_number

   !> The unit of a text of SI such as J/(kg K), kg/m3 or Pa m0.5.
   pure subroutine unit_of(text, unit, known)
      character(len=*), intent(in) :: text               !! Symbols with powers; one slash at most
      type(unit_t), intent(out) :: unit
      logical, intent(out) :: known                      !! Is it a unit of SI, or deg?
      type(written_unit_t) :: written

      call read_unit(written, text)
      known = written%fault == "" .and. nint(written%exponent) == 0
      if (known) unit%power = written%power
   end subroutine unit_of

   !> Powers of length, mass, time, current, temperature, amount and light in a unit of SI, as files
   !! store them.
   pure function dimension_of(text) result(powers)
      character(len=*), intent(in) :: text               !! Unit of SI
      integer(int32) :: powers(7)
      type(unit_t) :: unit
      logical :: known

      call unit_of(text, unit, known)
      powers = 0
      powers([1, 3, 2, 5]) = nint(unit%power, int32)
   end function dimension_of

   !> True for the first letters of a unit: a letter, the micro sign, or 1 and a slash.
   pure logical function begins_unit(text) result(yes)
      character(len=*), intent(in) :: text               !! A word of a deck

      yes = .false.
      if (len(text) == 0) return
      yes = is_letter(text(1:1)) .or. index(text, char(194)//char(181)) == 1 .or. &
         index(text, char(206)//char(188)) == 1
      if (len(text) > 2) yes = yes .or. text(1:2) == "1/" .and. is_letter(text(3:3))
   end function begins_unit

   !> Split 15us into 15 and us, and 3/s into 3 and 1/s. Any other text is not changed.
   pure subroutine split_unit(text, digits, unit)
      character(len=*), intent(in) :: text               !! A word of a deck
      character(len=:), allocatable, intent(out) :: digits !! Text of the number
      character(len=:), allocatable, intent(out) :: unit !! The unit, empty if there is none
      type(written_unit_t) :: known
      real(wp) :: value
      integer :: last, verdict

      digits = text
      unit = ""
      last = verify(text//"x", "+-."//figures) - 1
      if (last < 1 .or. last >= len(text)) return
      if (scan(text(last + 1:last + 1), "eEdD") == 1) then
         verdict = last + 1 + merge(1, 0, scan(text(last + 2:)//" ", "+-") == 1)
         if (scan(text(verdict + 1:)//" ", figures) == 1) &
            last = verdict + verify(text(verdict + 1:)//"x", figures) - 1
      end if
      if (last >= len(text)) return
      call read_decimal(text(:last), 0, value, verdict)
      if (verdict == decimal_none) return
      unit = text(last + 1:)
      if (unit(1:1) == "/") unit = "1"//unit
      if (begins_unit(unit)) call read_unit(known, unit)
      if (.not. allocated(known%fault)) known%fault = "none"
      if (known%fault == "") then
         digits = text(:last)
      else
         unit = ""
      end if
   end subroutine split_unit

   !> Read a unit. All symbols after the first slash divide.
   pure subroutine read_unit(self, text)
      type(written_unit_t), intent(out) :: self         !! The unit, or its fault
      character(len=*), intent(in) :: text               !! Symbols with powers
      character(len=:), allocatable :: word
      integer :: first, last, at, n
      logical :: below
      character(len=2), parameter :: micro(2) = [char(194)//char(181), char(206)//char(188)]

      ! u for the micro sign of UTF-8
      word = text
      do n = 1, size(micro)
         at = index(word, micro(n))
         do while (at > 0)
            word = word(:at - 1)//"u"//word(at + 2:)
            at = index(word, micro(n))
         end do
      end do
      self%fault = ""
      below = .false.
      first = 1
      do while (first <= len(word))
         select case (word(first:first))
         case ("/")
            below = .true.
         case (" ", "(", ")", "*", "1")
            continue
         case default
            last = first
            do while (last < len(word))
               if (.not. is_letter(word(last + 1:last + 1))) exit
               last = last + 1
            end do
            call take_symbol(self, word(first:last), word(last + 1:), below, first)
            if (self%fault /= "") return
            first = last + first
         end select
         first = first + 1
      end do
   end subroutine read_unit

   !> Multiply a unit by a symbol and its power.
   pure subroutine take_symbol(self, name, behind, below, letters)
      type(written_unit_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! The symbol with its prefix
      character(len=*), intent(in) :: behind             !! Remaining text
      logical, intent(in) :: below                       !! Is it after the slash?
      integer, intent(out) :: letters                    !! Letters of the power
      real(wp) :: power
      integer :: first, last, prefix, status, which

      call find_symbol(name, which, prefix)
      letters = 0
      if (which == 0) then
         self%fault = "'"//name//"' is not a unit"//suggested_unit(name)//" [D202]"
         return
      end if
      first = 1
      if (index(behind, "**") == 1) first = 3
      if (index(behind, "^") == 1) first = 2
      last = first + merge(1, 0, scan(behind(first:)//" ", "+-") == 1)
      last = last + verify(behind(last:)//"x", figures//".") - 2
      power = 1.0_wp
      if (scan(behind(first:last), figures) > 0) then
         read (behind(first:last), *, iostat=status) power
         if (status /= 0) self%fault = "'"//behind(first:last)//"' is not a power "// &
            "of a unit [D202]"
         letters = last
      end if
      if (below) power = -power
      self%power = self%power + power*real(symbols(which)%power, wp)
      self%exponent = self%exponent + power*real(symbols(which)%exponent + prefix, wp)
      select case (symbols(which)%name)
      case ("min")
         self%factor = self%factor*60.0_wp**power
      case ("h")
         self%factor = self%factor*3600.0_wp**power
      case ("deg")
         self%factor = self%factor*(pi/180.0_wp)**power
         self%angle = self%angle + power
      case ("rad")
         self%angle = self%angle + power
      case default
         continue
      end select
   end subroutine take_symbol

   !> The symbol and the decimal exponent of its prefix.
   pure subroutine find_symbol(name, which, exponent)
      character(len=*), intent(in) :: name               !! With its prefix
      integer, intent(out) :: which                      !! The symbol, 0 if there is none
      integer, intent(out) :: exponent                   !! Exponent of the prefix
      integer :: n

      exponent = 0
      do which = size(symbols), 1, -1
         if (symbols(which)%name == name) return
      end do
      if (len(name) < 2) return
      do n = 1, size(prefixes)
         if (prefixes(n) /= name(1:1)) cycle
         exponent = prefix_exponents(n)
         do which = size(symbols), 1, -1
            if (symbols(which)%prefix .and. symbols(which)%name == name(2:)) return
         end do
      end do
   end subroutine find_symbol

   !> Suggestion for an unknown unit.
   pure function suggested_unit(name) result(question)
      character(len=*), intent(in) :: name               !! Text as written
      character(len=:), allocatable :: question
      type(text_t), allocatable :: names(:)
      integer :: n

      allocate (names(0))
      do n = 1, size(common)
         call append(names, trim(common(n)))
      end do
      question = closest(name, names)
      if (question == "") then
         question = "; scree --list units lists all units"
      else
         question = "; did you mean '"//question//"'?"
      end if
   end function suggested_unit

   !> All units and prefixes, for --list.
   pure function unit_list() result(text)
      character(len=:), allocatable :: text
      integer :: n

      text = "symbols:"
      do n = 1, size(symbols)
         text = text//" "//trim(symbols(n)%name)
      end do
      text = text//new_line("a")//"prefixes of m s g K N J W Pa bar rad:"
      do n = 1, size(prefixes)
         text = text//" "//prefixes(n)
      end do
      text = text//new_line("a")//"compositions: km/s  g/cm3  J/(kg K)  1/s  m2  MPa*m0.5"
   end function unit_list

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
end module deck_units
