! SPDX-License-Identifier: BSD-3-Clause
!> Wall times as text, hours:minutes:seconds or days-hours:minutes:seconds, in decks, on the command
!! line and in job scripts.
module base_clock
   implicit none
   private

   public :: clock_seconds, clock_text, is_clock

contains

   !> True for hours:minutes:seconds with one to three digits of hours, and also with days before
   !! them, as in 2-00:00:00.
   pure logical function is_clock(text) result(valid)
      character(len=*), intent(in) :: text               !! Text of the user
      integer :: dash, last

      last = len(text)
      dash = index(text, "-")
      valid = .false.
      if (dash == 1 .or. dash > 4 .or. last - dash < 7 .or. last - dash > 9) return
      if (verify(text(:max(dash - 1, 0)), "0123456789") > 0) return
      if (verify(text(dash + 1:last - 6), "0123456789") > 0) return
      valid = text(last - 5:last - 5) == ":" .and. text(last - 2:last - 2) == ":" .and. &
         is_below_sixty(text(last - 4:last - 3)) .and. is_below_sixty(text(last - 1:))
   end function is_clock

   !> True for two digits of a number below 60.
   pure logical function is_below_sixty(text) result(valid)
      character(len=*), intent(in) :: text               !! Two characters

      valid = verify(text, "0123456789") == 0 .and. llt(text, "60")
   end function is_below_sixty

   !> Seconds of a time [s].
   pure integer function clock_seconds(text) result(seconds)
      character(len=*), intent(in) :: text               !! `is_clock` is true
      integer :: dash, days, hours, minutes, rest, last

      last = len(text)
      dash = index(text, "-")
      days = 0
      if (dash > 0) read (text(:dash - 1), *) days
      read (text(dash + 1:last - 6), *) hours
      read (text(last - 4:last - 3), *) minutes
      read (text(last - 1:), *) rest
      seconds = 86400*days + 3600*hours + 60*minutes + rest
   end function clock_seconds

   !> Hours:minutes:seconds of a time of at least one second.
   pure function clock_text(seconds) result(text)
      integer, intent(in) :: seconds                     !! [s]
      character(len=:), allocatable :: text
      character(len=24) :: line
      integer :: left

      left = max(seconds, 1)
      write (line, "(i0.2, 2(':', i2.2))") left/3600, mod(left/60, 60), mod(left, 60)
      text = trim(line)
   end function clock_text
end module base_clock
