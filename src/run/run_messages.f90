! SPDX-License-Identifier: BSD-3-Clause
!> What `scree --explain` and `scree --list messages` print about messages and their codes, such as
!! D209. The texts are those of src/run/messages. A message contains its code where it is reported;
!! here a code is found only for the words of a message that a user gives to `scree --explain`.
module run_messages
   use base_error, only: error_t, exit_input, fail
   use base_text, only: append, buffer_t, join, lower, split, text_t
   use run_message_table, only: example_lines, line_length, message_codes, message_lines
   implicit none
   private

   public :: explain_message, is_message, message_code, message_list

   character(len=*), parameter :: newline = new_line("a")
   character(len=*), parameter :: wildcard = "..."  !! Any text in a pattern
   integer, parameter :: columns = 80               !! Width of explanations
   integer, parameter :: most_similar = 5           !! Messages that are suggested

   !> Code and pattern of a message.
   type :: message_t
      character(len=:), allocatable :: code         !! Such as D209
      type(text_t), allocatable :: patterns(:)      !! Texts of the message
   end type message_t

contains

   !> Code of a line; empty if it is not a message.
   function message_code(line) result(code)
      character(len=*), intent(in) :: line          !! As printed
      character(len=:), allocatable :: code
      type(message_t), allocatable :: messages(:)
      integer :: which

      call load_messages(messages)
      which = find_message(messages, line)
      code = ""
      if (which > 0) code = messages(which)%code
   end function message_code

   !> True for a code, or for a text of several words, which cannot be a key of a deck.
   pure logical function is_message(text) result(yes)
      character(len=*), intent(in) :: text          !! Argument of --explain

      yes = index(trim(adjustl(text)), " ") > 0 .or. is_code(trim(adjustl(text)))
   end function is_message

   !> True for a text with the form of a code, such as D209.
   pure logical function is_code(text) result(yes)
      character(len=*), intent(in) :: text

      yes = .false.
      if (len(text) /= len(message_codes)) return
      yes = any(upper_letter(text(1:1)) == message_codes(:)(1:1)) .and. &
         verify(text(2:), "0123456789") == 0
   end function is_code

   !> A letter as a capital letter.
   pure character function upper_letter(letter) result(capital)
      character, intent(in) :: letter

      capital = letter
      if (letter >= "a" .and. letter <= "z") capital = achar(iachar(letter) - 32)
   end function upper_letter

   !> Explain a message: its cause, the remedy, an example.
   subroutine explain_message(words, text, error)
      character(len=*), intent(in) :: words         !! A code, or a line as the program prints it
      character(len=:), allocatable, intent(out) :: text !! Cause, remedy, example
      type(error_t), allocatable, intent(out) :: error !! There is no such message
      character(len=:), allocatable :: code
      type(message_t), allocatable :: messages(:)

      call find_code(trim(adjustl(words)), code)
      if (any(message_codes == code)) then
         text = explanation(code)
         return
      end if
      text = ""
      if (is_code(trim(adjustl(words)))) then
         call fail(error, exit_input, "no message has the code '"//trim(adjustl(words))// &
            "'; scree --list messages [C116]")
         return
      end if
      call load_messages(messages)
      call fail(error, exit_input, "no message with these words; scree --list messages "// &
         "[C116]"//similar_messages(messages, words))
   end subroutine explain_message

   !> The code in a text: alone, in brackets at the end of a line, or that of the message.
   subroutine find_code(words, code)
      character(len=*), intent(in) :: words         !! Words of the user
      character(len=:), allocatable, intent(out) :: code !! Empty without one
      integer :: i

      do i = 1, size(message_codes)
         code = message_codes(i)
         if (index(words, "["//code//"]") > 0) return
      end do
      if (is_code(words)) then
         code = upper_letter(words(1:1))//words(2:)
      else
         code = message_code(words)
      end if
   end subroutine find_code

   !> Up to five messages that share words with a text, one per line.
   function similar_messages(messages, text) result(lines)
      type(message_t), intent(in) :: messages(:)    !! All messages
      character(len=*), intent(in) :: text          !! Text of the user
      character(len=:), allocatable :: lines
      type(text_t), allocatable :: words(:)
      integer, allocatable :: shared(:)
      integer :: i, n, best

      call split(lower(text), words)
      allocate (shared(size(messages)), source=0)
      do n = 1, size(messages)
         do i = 1, size(words)
            if (len(words(i)%text) < 4) cycle
            if (index(lower(join(messages(n)%patterns, " ")), words(i)%text) > 0) &
               shared(n) = shared(n) + len(words(i)%text)
         end do
      end do
      lines = ""
      do n = 1, most_similar
         best = maxloc(shared, dim=1)
         if (shared(best) == 0) return
         if (n == 1) lines = newline//"similar messages:"
         lines = lines//newline//summary(messages(best))
         shared(best) = 0
      end do
   end function similar_messages

   !> All messages, one a line.
   function message_list() result(text)
      character(len=:), allocatable :: text
      type(message_t), allocatable :: messages(:)
      type(buffer_t) :: buffer
      integer :: n

      call load_messages(messages)
      do n = 1, size(messages)
         call buffer%line(summary(messages(n)))
      end do
      text = buffer%content()
   end function message_list

   !> Code and words of a message in one line.
   pure function summary(message) result(line)
      type(message_t), intent(in) :: message
      character(len=:), allocatable :: line

      line = message%code//"  "//message%patterns(1)%text
      if (size(message%patterns) > 1) line = line//"; and similar ones"
   end function summary

   !> Codes and patterns of all messages.
   subroutine load_messages(messages)
      type(message_t), allocatable, intent(out) :: messages(:)
      character(len=line_length), allocatable :: lines(:)
      character(len=*), parameter :: mark = "says: "
      integer :: i, n

      allocate (messages(size(message_codes)))
      do n = 1, size(messages)
         messages(n)%code = message_codes(n)
         call message_lines(message_codes(n), lines)
         allocate (messages(n)%patterns(0))
         do i = 1, size(lines)
            if (index(lines(i), mark) == 1) &
               call append(messages(n)%patterns, trim(lines(i)(len(mark) + 1:)))
         end do
      end do
   end subroutine load_messages

   !> The message whose pattern fits a line with the most letters; 0 if none does.
   pure integer function find_message(messages, line) result(which)
      type(message_t), intent(in) :: messages(:)    !! All messages
      character(len=*), intent(in) :: line          !! As printed
      integer :: best, i, n, score

      which = 0
      best = 0
      do n = 1, size(messages)
         do i = 1, size(messages(n)%patterns)
            score = fitting_letters(messages(n)%patterns(i)%text, line)
            if (score <= best) cycle
            best = score
            which = n
         end do
      end do
   end function find_message

   !> Letters of a pattern, wildcards apart, if its parts are in a line in their order; else 0.
   pure integer function fitting_letters(pattern, line) result(letters)
      character(len=*), intent(in) :: pattern       !! Parts, separated by wildcards
      character(len=*), intent(in) :: line          !! As printed
      integer :: first, from, last, place

      letters = 0
      first = 1
      from = 1
      do while (first <= len(pattern))
         last = first + index(pattern(first:)//wildcard, wildcard) - 2
         place = index(line(from:), pattern(first:last))
         if (place == 0) then
            letters = 0
            return
         end if
         from = from + place + last - first
         letters = letters + last - first + 1
         first = last + len(wildcard) + 1
      end do
   end function fitting_letters

   !> Everything about a message, for a terminal.
   function explanation(code) result(text)
      character(len=*), intent(in) :: code          !! One of message_codes
      character(len=:), allocatable :: text
      character(len=line_length), allocatable :: lines(:)
      type(buffer_t) :: buffer
      integer :: first, last

      call message_lines(code, lines)
      first = 1
      do while (first <= size(lines))
         last = first
         do while (last < size(lines))
            if (lines(last + 1)(1:1) /= " ") exit
            last = last + 1
         end do
         call add_field(joined_lines(lines, first, last), code, buffer)
         first = last + 1
      end do
      call example_lines(code, lines)
      if (size(lines) > 0) call buffer%line("")
      do first = 1, size(lines)
         call buffer%line(trim(lines(first)))
      end do
      text = buffer%content()
   end function explanation

   !> Join lines into one.
   pure function joined_lines(lines, first, last) result(text)
      character(len=*), intent(in) :: lines(:)      !! Lines of a message
      integer, intent(in) :: first                  !! The first of them
      integer, intent(in) :: last                   !! The last of them
      character(len=:), allocatable :: text
      integer :: i

      text = trim(lines(first))
      do i = first + 1, last
         text = text//" "//trim(adjustl(lines(i)))
      end do
   end function joined_lines

   !> One field of a message: its name and its words.
   subroutine add_field(field, code, buffer)
      character(len=*), intent(in) :: field         !! NAME: words
      character(len=*), intent(in) :: code          !! Code of the message
      type(buffer_t), intent(inout) :: buffer       !! Gets the lines
      character(len=:), allocatable :: name, words
      integer :: colon

      colon = index(field, ": ")
      name = field(:colon - 1)
      words = without_links(field(colon + 2:))
      select case (name)
      case ("says")
         call buffer%line(code//"  "//words)
      case ("note")
         call buffer%line("")
         call add_wrapped("", words, buffer)
      case default
         call add_wrapped(name//":"//repeat(" ", max(8 - len(name) - 1, 1)), words, buffer)
      end select
   end subroutine add_field

   !> Add words in lines of at most 80 columns, those after the first one with an indent.
   subroutine add_wrapped(label, text, buffer)
      character(len=*), intent(in) :: label         !! In front of the first line
      character(len=*), intent(in) :: text          !! Words
      type(buffer_t), intent(inout) :: buffer       !! Gets the lines
      character(len=:), allocatable :: line
      type(text_t), allocatable :: words(:)
      integer :: i

      call split(text, words)
      line = label
      do i = 1, size(words)
         if (len(line) > len(label)) then
            if (len(line) + 1 + len(words(i)%text) > columns) then
               call buffer%line(line)
               line = repeat(" ", len(label))
            else
               line = line//" "
            end if
         end if
         line = line//words(i)%text
      end do
      call buffer%line(line)
   end subroutine add_wrapped

   !> A Markdown text as plain text: links as their words, and no code marks.
   pure function without_links(text) result(plain)
      character(len=*), intent(in) :: text          !! Such as [the deck](../guide/deck.md)
      character(len=:), allocatable :: plain
      integer :: bracket, i

      plain = ""
      i = 1
      do while (i <= len(text))
         bracket = index(text(i:), "]")
         if (text(i:i) == "[" .and. bracket > 0 .and. bracket == index(text(i:), "](")) then
            plain = plain//text(i + 1:i + bracket - 2)
            i = i + bracket - 1 + index(text(i + bracket - 1:), ")")
         else
            if (text(i:i) /= "`") plain = plain//text(i:i)
            i = i + 1
         end if
      end do
   end function without_links
end module run_messages
