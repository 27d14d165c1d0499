! SPDX-License-Identifier: BSD-3-Clause
!> Formulas of the position, such as `100*x` for a velocity, converted to SI.
!!
!! In a deck x, y, z and the result are in its units. The formula is rewritten for SI, with powers
!! of ten at the coordinates and at the result; the echo shows the formula that is evaluated.
module deck_place_formula
   use base_text, only: is_letter, lower, number, split, text_t
   use deck_formula, only: formula_t
   use deck_schema, only: key_t
   use deck_units, only: unit_of, unit_t
   implicit none
   private

   public :: compile_place_formula, convert_formula

   character(len=*), parameter :: variables = "x y z"    !! Variables of all such formulas

contains

   !> Compile a formula of the position. Its variables are x, y, z in this order.
   subroutine compile_place_formula(text, formula, fault, place)
      character(len=*), intent(in) :: text               !! Text as written
      type(formula_t), intent(out) :: formula
      character(len=:), allocatable, intent(out) :: fault !! Error, empty if there is none
      integer, intent(out) :: place                      !! Position of the error
      type(text_t), allocatable :: names(:)

      call split(variables, names)
      call formula%compile(text, names, fault, place)
   end subroutine compile_place_formula

   !> Rewrite the formula of a key for SI.
   subroutine convert_formula(key, system, longest, text, problem)
      type(key_t), intent(in) :: key                     !! The key; its unit is that of the result
      integer, intent(in) :: system                      !! Units of the deck
      integer, intent(in) :: longest                     !! Longest text of the echo
      !> Formula in the units of the deck, then in SI
      character(len=:), allocatable, intent(inout) :: text
      character(len=:), allocatable, intent(inout) :: problem !! Empty without an error
      type(formula_t) :: formula
      type(unit_t) :: length
      character(len=:), allocatable :: fault, letters, written
      integer :: last, place
      logical :: known

      call compile_place_formula(text, formula, fault, place)
      if (fault /= "") then
         problem = "letter "//number(place)//": "//fault
         return
      end if
      call unit_of("m", length, known)
      if (nint(length%exponent(system)) == 0 .and. nint(key%unit%exponent(system)) == 0) return
      letters = lower(text)//" "
      written = ""
      place = 1
      do while (place < len(letters))
         last = place
         if (is_letter(letters(place:place))) then
            last = place + verify(letters(place:), "abcdefghijklmnopqrstuvwxyz0123456789_") - 2
         else if (scan(letters(place:place), "0123456789.") == 1) then
            ! the e of an exponent is not a variable
            last = place + verify(letters(place:), "0123456789.ed") - 2
         end if
         if (index(" "//variables//" ", " "//letters(place:last)//" ") > 0) then
            written = written//shifted(letters(place:last), -nint(length%exponent(system)))
         else
            written = written//letters(place:last)
         end if
         place = last + 1
      end do
      text = shifted(written, nint(key%unit%exponent(system)))
      if (len(text) > longest) problem = "is longer than "//number(longest)// &
         " letters when it is written in SI; shorten it or write the deck in SI [D229]"
   end subroutine convert_formula

   !> A formula times a power of ten.
   pure function shifted(formula, exponent) result(text)
      character(len=*), intent(in) :: formula            !! Value
      integer, intent(in) :: exponent                    !! Power of ten
      character(len=:), allocatable :: text

      text = formula
      if (exponent > 0) text = "("//formula//")*1e"//number(exponent)
      if (exponent < 0) text = "("//formula//")/1e"//number(-exponent)
      if (exponent /= 0) text = "("//text//")"
   end function shifted
end module deck_place_formula
