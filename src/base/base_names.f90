! SPDX-License-Identifier: BSD-3-Clause
!> Rules for the texts of users. A name becomes a part of file names, groups of HDF5, columns and
!! scripts; a value becomes a part of lines, of JSON and of scripts.
module base_names
   use base_text, only: number
   implicit none
   private

   public :: name_problem, suggested_name, text_problem

   character(len=*), parameter, public :: name_rule = &
      "names have letters, digits, '_', '.', '+' and '-', and do not begin with '.' or '-'"
   character(len=*), parameter :: plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"// &
      "0123456789_.+-"
   integer, parameter :: longest_name_of_user = 100 !! A file name has 255 bytes at most
   integer, parameter :: malformed = -1              !! In place of the code of a character

contains

   !> What is wrong with a text: a control character, or bytes that are not UTF-8. Empty if nothing
   !! is.
   pure function text_problem(text) result(problem)
      character(len=*), intent(in) :: text               !! Text of the user
      character(len=:), allocatable :: problem
      integer :: at, code, last

      problem = ""
      at = 1
      do while (at <= len(text) .and. problem == "")
         call read_character(text, at, code, last)
         if (code == malformed) then
            problem = "has bytes that are not UTF-8 text, the first one at place "//number(at)// &
               "; save the file as UTF-8 [D232]"
         else if (code < 32 .or. (code >= 127 .and. code < 160)) then
            problem = "has a control character, number "//number(code)//" at place "//number(at)// &
               "; only printable characters are allowed [D232]"
         end if
         at = last + 1
      end do
   end function text_problem

   !> What is wrong with a name; empty if nothing is.
   pure function name_problem(name) result(problem)
      character(len=*), intent(in) :: name               !! Name of the user
      character(len=:), allocatable :: problem
      integer :: at, code, last

      problem = text_problem(name)
      if (problem /= "") return
      if (len(name) > longest_name_of_user) then
         problem = "is longer than "//number(longest_name_of_user)//" letters [D225]"
         return
      end if
      problem = "is not a name: "//name_rule//" [D215]"
      if (name == "") return
      if (scan(name(1:1), ".-") == 1) return
      at = 1
      do while (at <= len(name))
         call read_character(name, at, code, last)
         if (.not. belongs_to_name(name(at:at), code)) return
         at = last + 1
      end do
      problem = ""
   end function name_problem

   !> A name that is close to a text: other characters become an underscore.
   pure function suggested_name(text) result(name)
      character(len=*), intent(in) :: text               !! Not a name
      character(len=:), allocatable :: name
      integer :: at, code, last

      name = ""
      at = 1
      do while (at <= len(text) .and. len(name) < longest_name_of_user/2)
         call read_character(text, at, code, last)
         if (belongs_to_name(text(at:at), code)) then
            name = name//text(at:last)
         else
            name = name//"_"
         end if
         at = last + 1
      end do
      if (name == "") name = "case"
      if (scan(name(1:1), ".-") == 1) name = "_"//name(2:)
   end function suggested_name

   !> True for a character that a name may have. Beyond ASCII these are letters; of signs, spaces
   !! and marks of direction only those in blocks that also have letters are accepted.
   pure logical function belongs_to_name(first, code) result(yes)
      character(len=1), intent(in) :: first              !! First byte
      integer, intent(in) :: code                        !! Code point
      integer, parameter :: signs(2, 9) = reshape([ &
         int(z"D7"), int(z"D7"), int(z"F7"), int(z"F7"), &     ! signs for times and divided by
         int(z"2000"), int(z"2BFF"), int(z"3000"), int(z"3004"), & ! punctuation, arrows, spaces
         int(z"D800"), int(z"F8FF"), int(z"FE00"), int(z"FE0F"), & ! no characters, selectors
         int(z"FEFF"), int(z"FFFF"), int(z"1F000"), int(z"1FFFF"), & ! order of bytes, pictures
         int(z"E0000"), int(z"10FFFF")], [2, 9])               ! tags, no characters

      if (code < 128) then
         yes = code /= malformed .and. index(plain, first) > 0
      else
         yes = code >= int(z"C0") .and. &
            .not. any(signs(1, :) <= code .and. code <= signs(2, :))
      end if
   end function belongs_to_name

   !> Code point of the character at a place of a text in UTF-8, and its last byte.
   pure subroutine read_character(text, at, code, last)
      character(len=*), intent(in) :: text               !! In UTF-8
      integer, intent(in) :: at                          !! First byte
      integer, intent(out) :: code                       !! Code point, or `malformed`
      integer, intent(out) :: last                       !! Last byte
      integer, parameter :: least(0:3) = [0, 128, 2048, 65536] ! shorter forms exist below these
      integer :: byte, more, n

      last = at
      code = ichar(text(at:at))
      if (code < 128) return
      select case (code)
      case (192:223)
         more = 1
      case (224:239)
         more = 2
      case (240:247)
         more = 3
      case default
         more = len(text)
      end select
      code = iand(code, 2**(6 - min(more, 3)) - 1)
      if (at + more > len(text)) code = malformed
      do n = at + 1, at + more
         if (code == malformed) return
         byte = ichar(text(n:n))
         code = 64*code + iand(byte, 63)
         if (iand(byte, 192) /= 128) code = malformed
      end do
      last = at + more
      if (code < least(more) .or. code > int(z"10FFFF") .or. &
         (code >= int(z"D800") .and. code <= int(z"DFFF"))) code = malformed
      if (code == malformed) last = at
   end subroutine read_character
end module base_names
