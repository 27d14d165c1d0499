! SPDX-License-Identifier: BSD-3-Clause
!> Errors are values: a procedure that can fail returns one, and only the program prints and stops.
!!
!! The text of a message ends with its code, such as " [D209]". A text that is continued behind its
!! code gets the code at the end of the line by `code_last` when it is printed.
module base_error
   implicit none
   private

   public :: code_last, error_t, explain_hint, fail, with_hint, without_code

   integer, parameter, public :: code_length = 7       !! Length of " [D209]"
   character(len=*), parameter :: newline = new_line("a")

   !> The exit codes of the program, a part of its interface.
   integer, parameter, public :: exit_success = 0      !! Finished
   integer, parameter, public :: exit_input = 2        !! Error in the deck or command line
   integer, parameter, public :: exit_file = 3         !! Missing, unreadable, disk full, HDF5
   !> NaN, time step too small, particle outside the grid
   integer, parameter, public :: exit_physics = 4
   integer, parameter, public :: exit_internal = 5     !! A defect of the program
   integer, parameter, public :: exit_again = 75       !! Stopped with a checkpoint: run again

   !> An error. Not allocated: no error.
   type :: error_t
      integer :: code = exit_internal                  !! Exit code of the program
      character(len=:), allocatable :: message         !! One or more lines for the user
   end type error_t

contains

   !> Make an error.
   pure subroutine fail(error, code, message)
      type(error_t), allocatable, intent(out) :: error !! Allocated on return
      integer, intent(in) :: code                      !! One of the exit codes above
      character(len=*), intent(in) :: message          !! Error and its remedy

      allocate (error)
      error%code = code
      error%message = message
   end subroutine fail

   !> A text with the code of each line at the end of the line.
   pure function code_last(text) result(ordered)
      character(len=*), intent(in) :: text             !! One or more lines
      character(len=:), allocatable :: ordered

      ordered = with_codes_at_end(text, code_length)
   end function code_last

   !> A text without codes.
   pure function without_code(text) result(plain)
      character(len=*), intent(in) :: text             !! One or more lines
      character(len=:), allocatable :: plain

      plain = with_codes_at_end(text, 0)
   end function without_code

   !> A text with some letters of the code of each line at the end of the line.
   pure function with_codes_at_end(text, letters) result(ordered)
      character(len=*), intent(in) :: text             !! One or more lines
      integer, intent(in) :: letters                   !! Letters of the code that are kept
      character(len=:), allocatable :: ordered
      integer :: code, first, last

      ordered = ""
      first = 1
      do while (first <= len(text))
         last = first + index(text(first:)//newline, newline) - 2
         code = first - 1 + code_place(text(first:last))
         if (code < first) code = last + 1
         ordered = ordered//text(first:code - 1)//text(code + code_length:last)// &
            text(code:min(code + letters - 1, last))
         if (last < len(text)) ordered = ordered//newline
         first = last + 2
      end do
   end function with_codes_at_end

   !> How to read more about the first message of a text; empty if it has no code.
   pure function explain_hint(text) result(hint)
      character(len=*), intent(in) :: text             !! One or more lines
      character(len=:), allocatable :: hint
      integer :: code, first, last

      hint = ""
      first = 1
      do while (first <= len(text))
         last = first + index(text(first:)//newline, newline) - 2
         code = code_place(text(first:last))
         if (code > 0) then
            hint = "for cause and remedy: scree --explain "//text(first + code + 1:first + code + 4)
            return
         end if
         first = last + 2
      end do
   end function explain_hint

   !> A text followed by a line how to read more about its first message, if it has a code.
   pure function with_hint(text) result(whole)
      character(len=*), intent(in) :: text             !! One or more lines
      character(len=:), allocatable :: whole

      whole = text
      if (explain_hint(text) == "") return
      if (whole(len(whole):) /= newline) whole = whole//newline
      whole = whole//explain_hint(text)
   end function with_hint

   !> Place of the last code in a line; 0 without one.
   pure integer function code_place(line) result(place)
      character(len=*), intent(in) :: line

      do place = len(line) - code_length + 1, 1, -1
         associate (code => line(place:place + code_length - 1))
            if (code(:2) == " [" .and. code(7:) == "]" .and. scan(code(3:3), "CDFR") > 0 .and. &
               verify(code(4:6), "0123456789") == 0) return
         end associate
      end do
      place = 0
   end function code_place
end module base_error
