! SPDX-License-Identifier: BSD-3-Clause
!> Splits namelist text into words: names, quoted texts, commas and other signs.
module deck_namelist_words
   use base_text, only: is_letter, number, shortened
   use deck_problems, only: problems_t
   implicit none
   private

   public :: file_mark, lexeme_t, scanner_t

   integer, parameter, public :: word_nothing = 0        !! End of the text or of an included file
   integer, parameter, public :: word_group = 1          !! Name of a group with its &
   integer, parameter, public :: word_slash = 2          !! End of a group
   integer, parameter, public :: word_equals = 3         !! The sign =
   integer, parameter, public :: word_comma = 4          !! The sign ,
   integer, parameter, public :: word_quoted = 5         !! Text in quotes
   integer, parameter, public :: word_plain = 6          !! Anything else
   integer, parameter, public :: word_broken = 7         !! Its closing quote or brace is missing
   integer, parameter, public :: word_formula = 8        !! An expression in braces

   integer, parameter :: longest_line = 512              !! Longer ones are an error
   character(len=1), parameter :: mark = achar(1)        !! Begins a line that names file and line
   character(len=1), parameter :: newline = achar(10)

   !> One word: its kind and position.
   type :: lexeme_t
      integer :: kind = word_nothing                     !! One of the constants above
      integer :: first = 0                               !! First letter in the text
      integer :: last = 0                                !! Last letter in the text
      integer :: line = 0                                !! Line of the file
      integer :: column = 0                              !! Column of its first character
   end type lexeme_t

   !> A text and the position of the scanner in it.
   type :: scanner_t
      character(len=:), allocatable :: file              !! File of the current line
      integer :: line = 1                                !! Current line
      character(len=:), allocatable :: inside            !! Name of the open group, for messages
      character(len=:), allocatable, private :: text     !! All lines
      integer, private :: at = 1                         !! Next letter
      integer, private :: line_start = 1                 !! First letter of the current line
   contains
      procedure :: start => scanner_start                !! Begin with a text
      procedure :: next => scanner_next                  !! Next word
      procedure :: back => scanner_back                  !! Go back to before a word
      procedure :: letters => scanner_letters            !! Part of the text
      procedure :: rest_of_line => scanner_rest_of_line  !! Rest of the line, for messages
   end type scanner_t

contains

   !> A mark with the file and number of the next line.
   pure function file_mark(file, line) result(text)
      character(len=*), intent(in) :: file               !! Name of the file
      integer, intent(in) :: line                        !! Next line of the file
      character(len=:), allocatable :: text

      text = mark//number(line)//" "//file//newline
   end function file_mark

   !> Begin with a text.
   subroutine scanner_start(self, text, file)
      class(scanner_t), intent(out) :: self
      character(len=*), intent(in) :: text               !! The whole text
      character(len=*), intent(in) :: file               !! File of its first line

      self%text = text//newline
      self%file = file
      self%inside = ""
      call skip_marks(self)
   end subroutine scanner_start

   !> Part of the text.
   pure function scanner_letters(self, first, last) result(letters)
      class(scanner_t), intent(in) :: self
      integer, intent(in) :: first                       !! First letter
      integer, intent(in) :: last                        !! Last letter
      character(len=:), allocatable :: letters

      letters = self%text(first:last)
   end function scanner_letters

   !> Rest of the line, cut if it is long.
   pure function scanner_rest_of_line(self, first) result(letters)
      class(scanner_t), intent(in) :: self
      integer, intent(in) :: first                       !! First letter
      character(len=:), allocatable :: letters
      integer, parameter :: most = 40
      integer :: last

      last = first + index(self%text(first:), newline) - 2
      do while (last > first)
         if (self%text(last:last) > " ") exit
         last = last - 1
      end do
      letters = shortened(self%text(first:last), most)
   end function scanner_rest_of_line

   !> Go back to the position before a word of the current line.
   subroutine scanner_back(self, word)
      class(scanner_t), intent(inout) :: self
      type(lexeme_t), intent(in) :: word                 !! The last word

      self%at = word%first
   end subroutine scanner_back

   !> Next word. Within a group the end of an included file gives `word_nothing`, so that no group
   !! continues beyond its file.
   subroutine scanner_next(self, word, problems)
      class(scanner_t), intent(inout) :: self
      type(lexeme_t), intent(out) :: word
      type(problems_t), intent(inout) :: problems        !! Collects errors
      logical :: crossed
      character(len=*), parameter :: others = "_0123456789"

      call skip_blanks(self, crossed, problems)
      word%line = self%line
      word%column = self%at - self%line_start + 1
      word%first = self%at
      word%last = self%at
      if (crossed .or. self%at > len(self%text)) return
      select case (self%text(self%at:self%at))
      case ("/")
         word%kind = word_slash
      case ("=")
         word%kind = word_equals
      case (",")
         word%kind = word_comma
      case ("'", """")
         call read_quoted(self, word, problems)
      case ("{")
         call read_formula(self, word, problems)
      case ("&")
         if (is_letter(self%text(self%at + 1:self%at + 1))) then
            word%kind = word_group
            word%last = self%at + 1
            do while (is_letter(self%text(word%last + 1:word%last + 1)) .or. &
               scan(self%text(word%last + 1:word%last + 1), others) == 1)
               word%last = word%last + 1
            end do
         else
            call read_plain(self, word)
         end if
      case default
         call read_plain(self, word)
      end select
      self%at = word%last + 1
   end subroutine scanner_next

   !> Skip blanks, comments and line ends.
   subroutine skip_blanks(self, crossed, problems)
      class(scanner_t), intent(inout) :: self
      logical, intent(out) :: crossed !! Does another file begin here within a group?
      type(problems_t), intent(inout) :: problems        !! Collects errors

      crossed = .false.
      do while (self%at <= len(self%text))
         associate (letter => self%text(self%at:self%at))
            if (letter == "!") then
               self%at = self%at + index(self%text(self%at:), newline) - 1
            else if (letter == newline) then
               if (self%at < len(self%text) .and. self%inside /= "") then
                  crossed = self%text(self%at + 1:self%at + 1) == mark
                  if (crossed) return
               end if
               ! the next line
               if (self%at - self%line_start > longest_line + 1) then
                  call problems%error(self%file, self%line, "the line is longer than "// &
                     number(longest_line)//" characters; break it after a comma [D108]")
               end if
               self%at = self%at + 1
               self%line = self%line + 1
               self%line_start = self%at
               call skip_marks(self)
            else if (letter > " ") then
               return
            else
               self%at = self%at + 1
            end if
         end associate
      end do
   end subroutine skip_blanks

   !> Read the marks at the start of a line.
   subroutine skip_marks(self)
      class(scanner_t), intent(inout) :: self            !! At the start of a line
      integer :: blank, last, status

      do while (self%at <= len(self%text))
         if (self%text(self%at:self%at) /= mark) exit
         last = self%at + index(self%text(self%at:), newline) - 1
         blank = self%at + index(self%text(self%at:last), " ") - 1
         if (blank > self%at) then
            read (self%text(self%at + 1:blank), *, iostat=status) self%line
            self%file = self%text(blank + 1:last - 1)
         end if
         self%at = last + 1
         self%line_start = self%at
      end do
   end subroutine skip_marks

   !> Read a text in quotes. It must end in its line; if it does not, the rest of the line is
   !! skipped and, within a group, an error is reported.
   subroutine read_quoted(self, word, problems)
      class(scanner_t), intent(in) :: self               !! At the opening quote
      type(lexeme_t), intent(inout) :: word              !! The word, with its start
      type(problems_t), intent(inout) :: problems        !! Collects errors
      integer :: at

      at = self%at + 1
      do
         if (self%text(at:at) == newline) exit
         if (self%text(at:at) == self%text(self%at:self%at)) then
            if (self%text(at + 1:at + 1) /= self%text(self%at:self%at)) exit
            at = at + 1
         end if
         at = at + 1
      end do
      word%last = at
      word%kind = word_quoted
      if (self%text(at:at) /= newline) return
      word%last = at - 1
      word%kind = word_broken
      if (self%inside == "") return
      call problems%error(self%file, self%line, "&"//self%inside//": the quote is not closed: "// &
         self%rest_of_line(self%at)//" [D101]")
   end subroutine read_quoted

   !> Read an expression in braces. It must end in its line; if it does not, the rest of the line is
   !! skipped.
   subroutine read_formula(self, word, problems)
      class(scanner_t), intent(in) :: self               !! At the opening brace
      type(lexeme_t), intent(inout) :: word              !! The word, with its start
      type(problems_t), intent(inout) :: problems        !! Collects errors

      word%last = self%at + scan(self%text(self%at:), "}"//newline) - 1
      word%kind = word_formula
      if (self%text(word%last:word%last) == "}") return
      word%last = word%last - 1
      word%kind = word_broken
      if (self%inside == "") return
      call problems%error(self%file, self%line, "&"//self%inside//": the brace is not closed: "// &
         self%rest_of_line(self%at)//"; an expression ends with } in its line [D101]")
   end subroutine read_formula

   !> Read any other word up to a blank or sign. Blanks and commas in brackets are a part of it, and
   !! so is the slash of a unit such as km/s.
   subroutine read_plain(self, word)
      class(scanner_t), intent(in) :: self               !! At its first letter
      type(lexeme_t), intent(inout) :: word              !! The word, with its start
      integer :: at, closing

      word%kind = word_plain
      at = self%at
      do
         if (self%text(at:at) == "(") then
            closing = scan(self%text(at:), ")=/&!'"""//newline) + at - 1
            if (self%text(closing:closing) == ")") at = closing
         end if
         if (scan(self%text(at + 1:at + 1), ",=!{'""") == 1) exit
         if (self%text(at + 1:at + 1) == "/" .and. .not. is_unit_slash(self%text, at + 1)) exit
         if (self%text(at + 1:at + 1) <= " ") exit
         if (self%text(at + 1:at + 1) == "&" .and. is_letter(self%text(at + 2:at + 2))) exit
         at = at + 1
      end do
      word%last = at
   end subroutine read_plain

   !> True for a slash within a unit: a letter or bracket follows at once, no blank is before it.
   pure logical function is_unit_slash(text, at) result(yes)
      character(len=*), intent(in) :: text               !! The whole text, a newline at its end
      integer, intent(in) :: at                          !! Position of the slash, not the first
      character(len=*), parameter :: before = "0123456789.)"

      yes = text(at + 1:at + 1) == "(" .or. is_letter(text(at + 1:at + 1))
      yes = yes .and. (is_letter(text(at - 1:at - 1)) .or. scan(text(at - 1:at - 1), before) == 1)
   end function is_unit_slash
end module deck_namelist_words
