! SPDX-License-Identifier: BSD-3-Clause
!> Numbers as text that gives the same number when read back.
module base_number_text
   use base_kinds, only: int64, wp
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   implicit none
   private

   public :: real_text, integer_text

contains

   !> A real with the fewest digits that give the same bits when read back.
   function real_text(number) result(text)
      real(wp), intent(in) :: number                     !! Number
      character(len=:), allocatable :: text
      character(len=32) :: line
      character(len=16) :: form
      real(wp) :: back
      integer :: digits
      integer, parameter :: enough = 16, usual = 8

      if (.not. ieee_is_finite(number)) then
         write (line, "(g0)") number
         text = trim(adjustl(line))
         return
      end if
      do digits = usual, enough
         write (form, "(a, i0, a)") "(es32.", digits, "e3)"
         write (line, form) number
         read (line, *) back
         if (transfer(back, 0_int64) == transfer(number, 0_int64)) exit
      end do
      text = without_zeros(trim(adjustl(line)))
   end function real_text

   !> A number in exponent form without trailing zeros.
   pure function without_zeros(line) result(text)
      character(len=*), intent(in) :: line               !! As 1.2500E+003
      character(len=:), allocatable :: text
      integer :: exponent, last

      exponent = index(line, "E")
      last = exponent - 1
      do while (line(last:last) == "0" .and. line(last - 1:last - 1) /= ".")
         last = last - 1
      end do
      text = line(:last)//line(exponent:)
   end function without_zeros

   !> An integer.
   pure function integer_text(number) result(text)
      integer(int64), intent(in) :: number               !! Number
      character(len=:), allocatable :: text
      character(len=24) :: line

      write (line, "(i0)") number
      text = trim(line)
   end function integer_text
end module base_number_text
