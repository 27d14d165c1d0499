! SPDX-License-Identifier: BSD-3-Clause
!> Reads decimal numbers. Their magnitude is checked before the conversion, since an overflow is a
!! floating point exception in a build with checks.
module base_decimal
   use base_kinds, only: wp
   use base_text, only: number, split, text_t
   implicit none
   private

   public :: file_number, file_numbers, read_decimal, without_commas

   integer, parameter, public :: decimal_good = 0    !! A valid number
   integer, parameter, public :: decimal_none = 1    !! Not a number
   integer, parameter, public :: decimal_large = 2   !! Above 1e307
   integer, parameter, public :: decimal_small = 3   !! Below 1e-306, but not 0

   integer, parameter :: most = 306                  !! Greatest decimal magnitude
   character(len=*), parameter :: figures = "0123456789"

contains

   !> Read a number and shift its decimal exponent. Exponent letters are e, E, d and D.
   pure subroutine read_decimal(text, shift, value, verdict)
      character(len=*), intent(in) :: text           !! Text as written
      integer, intent(in) :: shift                   !! Added to the decimal exponent
      real(wp), intent(out) :: value                 !! The number, 0 if it cannot be read
      integer, intent(out) :: verdict                !! One of the constants above
      character(len=:), allocatable :: shifted
      integer :: digits, exponent, first, magnitude, mark, point, status

      value = 0.0_wp
      verdict = decimal_none
      first = merge(2, 1, scan(text//" ", "+-") == 1)
      mark = scan(text//"e", "eEdD")
      if (verify(text(first:mark - 1), figures//".") > 0) return
      if (scan(text(first:mark - 1), figures) == 0) return
      point = index(text(:mark - 1)//".", ".")
      if (index(text(point + 1:mark - 1), ".") > 0) return
      exponent = 0
      if (mark <= len(text)) then
         digits = mark + merge(2, 1, scan(text(mark + 1:), "+-") == 1)
         if (verify(text(digits:), figures) > 0 .or. digits > len(text)) return
         if (verify(text(digits:), "0") > 0 .and. len(text) - digits >= 6) then
            verdict = merge(decimal_small, decimal_large, text(mark + 1:mark + 1) == "-")
            return
         end if
         read (text(mark + 1:), *, iostat=status) exponent
      end if
      verdict = decimal_good
      if (text(1:1) == "-") value = sign(0.0_wp, -1.0_wp)
      digits = scan(text(:mark - 1), "123456789")
      if (digits == 0) return
      exponent = exponent + shift
      magnitude = exponent + point - digits - merge(1, 0, point > digits)
      if (magnitude > most) verdict = decimal_large
      if (magnitude < -most) verdict = decimal_small
      if (verdict /= decimal_good) return
      shifted = text(:mark - 1)//"e"//number(exponent)
      read (shifted, *, iostat=status) value
      if (status /= 0) verdict = decimal_none
   end subroutine read_decimal

   !> Read a number from a file of another program; one below 1e-306 becomes 0.
   pure subroutine file_number(text, value, sound)
      character(len=*), intent(in) :: text           !! Text as written
      real(wp), intent(out) :: value                 !! Value of the text
      logical, intent(out) :: sound                  !! Is it valid?
      integer :: verdict

      call read_decimal(text, 0, value, verdict)
      sound = verdict == decimal_good .or. verdict == decimal_small
   end subroutine file_number

   !> Read exactly `size(values)` finite numbers from a line of a file of another program.
   subroutine file_numbers(line, values, sound)
      character(len=*), intent(in) :: line           !! With blanks between the numbers
      real(wp), intent(out) :: values(:)             !! The numbers; 0 from the first error on
      logical, intent(out) :: sound                  !! True if all of them are valid
      type(text_t), allocatable :: words(:)
      integer :: k

      values = 0.0_wp
      call split(line, words)
      sound = size(words) == size(values)
      if (.not. sound) return
      do k = 1, size(values)
         call file_number(words(k)%text, values(k), sound)
         if (.not. sound) return
      end do
   end subroutine file_numbers

   !> A line of a file of another program with blanks in place of commas and control characters.
   pure function without_commas(line) result(clean)
      character(len=*), intent(in) :: line           !! Any line
      character(len=len(line)) :: clean
      integer :: n

      do n = 1, len(line)
         clean(n:n) = merge(" ", line(n:n), line(n:n) == "," .or. iachar(line(n:n)) < iachar(" "))
      end do
   end function without_commas
end module base_decimal
