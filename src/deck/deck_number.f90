! SPDX-License-Identifier: BSD-3-Clause
!> Converts numbers of a deck to SI, from the unit after them or from the units of the deck.
module deck_number
   use base_constants, only: pi
   use base_decimal, only: decimal_good, decimal_none, read_decimal
   use base_kinds, only: int64, wp
   use base_text, only: join, number, split, text_t
   use deck_schema, only: key_t, kind_integer, kind_logical, kind_real
   use deck_units, only: read_unit, written_unit_t
   implicit none
   private

   public :: check_range, convert_number, expectation, item_t, read_integer

   !> One value as written, repeat counts resolved.
   type :: item_t
      character(len=:), allocatable :: text              !! Without quotes
      logical :: quoted = .false.                        !! Was it in quotes?
      character(len=:), allocatable :: unit              !! Unit after a number, or empty
   end type item_t

   real(wp), parameter :: radian = pi/180.0_wp           !! A degree in radians

contains

   !> Convert a number with its own unit, or in that of the deck.
   subroutine convert_number(key, item, system, number_read, problem)
      type(key_t), intent(in) :: key
      type(item_t), intent(in) :: item                   !! As written
      integer, intent(in) :: system                      !! Units of numbers without a unit
      real(wp), intent(out) :: number_read               !! The number [SI]
      character(len=:), allocatable, intent(inout) :: problem !! Empty without an error
      type(written_unit_t) :: own
      real(wp) :: exponent, factor
      integer :: verdict

      exponent = key%unit%exponent(system)
      factor = 1.0_wp
      if (item%unit /= "") then
         call read_unit(own, item%unit)
         problem = unfit_unit(key, own, item%unit)
         if (problem /= "") return
         exponent = own%exponent
         factor = own%factor
         ! the angles of a deck are in degrees, those of a unit in radians
         if (key%unit_text == "deg") factor = &
            merge(1.0_wp, factor/radian, .not. abs(factor - radian) > 0.0_wp)
      end if
      ! its decimal exponent is shifted to that of SI
      call read_decimal(item%text, nint(exponent), number_read, verdict)
      select case (verdict)
      case (decimal_good)
         problem = ""
      case (decimal_none)
         problem = expectation(key)
      case default
         problem = "is too large or too small for a number [D218]"
      end select
      if (problem /= "") return
      exponent = exponent - real(nint(exponent), wp)
      if (abs(exponent) > 0.0_wp) number_read = number_read*10.0_wp**exponent
      if (abs(factor - 1.0_wp) > 0.0_wp) number_read = number_read*factor
      call check_range(key, number_read, problem)
   end subroutine convert_number

   !> The error in the unit after the number of a key; empty if it fits.
   function unfit_unit(key, own, written) result(problem)
      type(key_t), intent(in) :: key
      type(written_unit_t), intent(in) :: own
      character(len=*), intent(in) :: written            !! The same as written
      character(len=:), allocatable :: problem
      real(wp), parameter :: grain = 1.0e-9_wp           ! rounding of a sum of powers
      logical :: fits

      problem = own%fault
      if (problem /= "") return
      fits = all(abs(own%power - key%unit%power) < grain)
      if (key%unit_text == "deg") then
         fits = fits .and. abs(own%angle - 1.0_wp) < grain
      else if (all(abs(key%unit%power) < grain)) then
         problem = "takes a number without a unit, not '"//written//"' [D202]"
         return
      else if (abs(own%angle) > grain) then
         fits = fits .and. key%unit_text == "1/s"
      end if
      if (fits) return
      problem = "expects "//key%unit_text//" or a unit of the same kind [D202]"
      select case (key%unit_text)
      case ("m")
         problem = problem//" such as mm"
      case ("s")
         problem = problem//" such as us"
      case ("m/s")
         problem = problem//" such as km/s"
      case ("kg/m3")
         problem = problem//" such as g/cm3"
      case ("Pa")
         problem = problem//" such as GPa"
      case ("deg")
         problem = problem//" such as rad"
      case default
         continue
      end select
      problem = problem//", not '"//written//"'"
   end function unfit_unit

   !> Check the range of a number.
   subroutine check_range(key, value, problem)
      type(key_t), intent(in) :: key
      real(wp), intent(in) :: value                      !! The number [SI]
      character(len=:), allocatable, intent(inout) :: problem !! Empty without an error
      type(text_t), allocatable :: parts(:)
      logical :: inside

      inside = value >= key%range%least .and. value <= key%range%most
      if (inside .and. key%range%least_open) inside = value > key%range%least
      if (inside .and. key%range%most_open) inside = value < key%range%most
      if (inside) return
      call split(key%range%text, parts)
      if (size(parts) == 4) then
         problem = "must be "//join(parts(:2), " ")//" and "//join(parts(3:), " ")
      else
         problem = "must be "//key%range%text
      end if
      if (key%unit_text /= "") problem = problem//" "//key%unit_text
      if (key%range%hint == "") then
         problem = problem//" [D214]"
      else
         problem = problem//"; "//key%range%hint
      end if
   end subroutine check_range

   !> Read an integer.
   subroutine read_integer(text, whole, problem)
      character(len=*), intent(in) :: text               !! Text as written
      integer, intent(out) :: whole                      !! Value of the text
      character(len=:), allocatable, intent(inout) :: problem !! "?" if it is not an integer
      character(len=*), parameter :: figures = "0123456789"
      integer(int64) :: long
      integer :: first, status

      whole = 0
      problem = "?"
      first = merge(2, 1, scan(text//" ", "+-") == 1)
      if (first > len(text) .or. verify(text(first:), figures) > 0) return
      problem = "must not be beyond "//number(huge(whole))//" [D217]"
      if (len(text) > 12) return
      read (text, *, iostat=status) long
      if (status /= 0 .or. abs(long) > huge(whole)) return
      problem = ""
      whole = int(long)
   end subroutine read_integer

   !> Description of the values that a key expects.
   function expectation(key) result(text)
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: text

      select case (key%kind)
      case (kind_real)
         text = counted(key, "a number [D201]", "numbers [D209]")
         if (.not. key%exact .and. key%number_of_values > 1) &
            text = counted(key, "", "numbers [D210]")
      case (kind_integer)
         text = counted(key, "an integer [D206]", "integers [D209]")
      case (kind_logical)
         text = "expects .true. or .false. [D208]"
      case default
         text = counted(key, "a text in quotes [D207]", "texts in quotes [D207]")
      end select
   end function expectation

   !> The number of values that a key expects, in words.
   function counted(key, one, several) result(text)
      type(key_t), intent(in) :: key
      character(len=*), intent(in) :: one                !! A single value
      character(len=*), intent(in) :: several            !! Several values
      character(len=:), allocatable :: text

      text = "expects "
      if (key%number_of_values == 1) then
         text = text//one
      else if (key%exact) then
         text = text//number(key%number_of_values)//" "//several
      else
         text = text//"up to "//number(key%number_of_values)//" "//several
      end if
   end function counted
end module deck_number
