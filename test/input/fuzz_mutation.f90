! SPDX-License-Identifier: BSD-3-Clause
!> Random damage to the text of a deck.
module fuzz_mutation
   use base_kinds, only: int64
   use base_random, only: random_bits
   use base_text, only: is_letter, lower, text_t
   use deck_schema, only: schema_t
   implicit none
   private

   public :: choice_t, damage, mutate, respell

   character(len=*), parameter :: newline = new_line("a")
   character(len=*), parameter :: letters = "'""&/!=,()*.+-eEdD0123456789abcxyz_ "//achar(9)// &
      newline//achar(13)//achar(0)//achar(127)//char(233)//"%$;:#"
   character(len=*), parameter :: spelling = "abcdefghijklmnopqrstuvwxyz_0123456789"
   character(len=24), parameter :: words(24) = [character(len=24) :: "&end", "&run /", "='", "''", &
      "(1)", "999999999*1", "..", "1e", "&", "&include file = 'x' /", "a%b = 3", "= 1 =", "1,,2", &
      "/ /", "2*", "3*'a'", ".true.", "name = 'a'", "/"//newline, "!", "&body /", "&material", &
      "(0)", "'"//newline]
   character(len=24), parameter :: numbers(24) = [character(len=24) :: "0", "-0", "-1", "1e306", &
      "-1e306", "1e-306", "5e-324", "1e999", "nan", "inf", "-inf", "1", "2", "7", "0.5", "1e9", &
      "1e-9", "2147483647", "-2147483648", "2147483648", "99999999999999999999", "1d0", "0.1e", &
      "1000001"]

   !> Random choices, the same for the same number of a mutation.
   type :: choice_t
      integer(int64), private :: owner = 0           !! Number of the mutation
      integer(int64), private :: draw = 0            !! Random numbers drawn so far
   contains
      procedure :: start => choice_start             !! Start with a mutation
      procedure :: upto => choice_upto               !! An integer from 1 upwards
   end type choice_t

   !> A word of a deck that may be misspelt.
   type :: word_t
      integer :: first = 0, last = 0                 !! Where it is in the text
      character(len=1) :: kind = " "                 !! g: group, k: key, w: word, n: a name
      integer :: rule = 0, key = 0                   !! Group and key in the schema
   end type word_t

contains

   !> Start the choices of a mutation.
   subroutine choice_start(self, number)
      class(choice_t), intent(inout) :: self         !! The choices
      integer, intent(in) :: number                  !! Of the mutation

      self%owner = number
      self%draw = 0
   end subroutine choice_start

   !> An integer from 1 to a greatest one.
   integer function choice_upto(self, most) result(chosen)
      class(choice_t), intent(inout) :: self         !! The choices
      integer, intent(in) :: most                    !! At least 1

      self%draw = self%draw + 1
      chosen = 1 + int(modulo(random_bits(20261_int64, self%owner, self%draw), int(most, int64)))
   end function choice_upto

   !> Change a text at one or a few positions.
   subroutine mutate(choice, text)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck
      integer, parameter :: how_many(8) = [1, 1, 1, 1, 2, 3, 5, 20]
      integer :: i

      do i = 1, how_many(choice%upto(size(how_many)))
         if (len(text) < 2) return
         select case (choice%upto(9))
         case (1)
            call flip(choice, text)
         case (2)
            call cut(choice, text, choice%upto(30))
         case (3)
            call replace(choice, text, letter(choice), 0)
         case (4)
            call replace(choice, text, trim(words(choice%upto(size(words)))), 0)
         case (5)
            call copy(choice, text)
         case (6)
            call swap_lines(choice, text)
         case (7)
            call swap_tokens(choice, text)
         case (8)
            call mangle_number(choice, text)
         case default
            call replace(choice, text, letter(choice), 1)
         end select
      end do
   end subroutine mutate

   !> Change the bytes of a file that is not text: flip bits, write a number of 1, 2, 4 or 8 bytes
   !! with an extreme value, remove or repeat bytes, or cut the end.
   subroutine damage(choice, text)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The file
      integer, parameter :: how_many(6) = [1, 1, 1, 2, 5, 20], widths(4) = [1, 2, 4, 8]
      integer :: at, i, width

      do i = 1, how_many(choice%upto(size(how_many)))
         if (len(text) < 16) return
         select case (choice%upto(6))
         case (1, 2)
            call flip(choice, text)
         case (3)
            width = widths(choice%upto(size(widths)))
            at = choice%upto(len(text) - width)
            text(at:at + width - 1) = repeat(char(merge(0, 255, choice%upto(2) == 1)), width)
            ! the greatest positive number, in either order of bytes
            if (choice%upto(2) == 1) text(at:at) = char(127)
            if (choice%upto(2) == 1) text(at + width - 1:at + width - 1) = char(127)
         case (4)
            call cut(choice, text, choice%upto(30))
         case (5)
            call copy(choice, text)
         case default
            text = text(:choice%upto(len(text)))
         end select
      end do
   end subroutine damage

   !> A random character with a meaning in decks.
   function letter(choice) result(one)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=1) :: one
      integer :: at

      at = choice%upto(len(letters))
      one = letters(at:at)
   end function letter

   !> Flip one bit of one byte.
   subroutine flip(choice, text)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck
      integer :: at

      at = choice%upto(len(text))
      text(at:at) = char(ieor(ichar(text(at:at)), 2**(choice%upto(8) - 1)))
   end subroutine flip

   !> Remove some characters.
   subroutine cut(choice, text, amount)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck
      integer, intent(in) :: amount                  !! How many at most
      integer :: at

      at = choice%upto(len(text))
      text = text(:at - 1)//text(min(at + amount, len(text) + 1):)
   end subroutine cut

   !> Replace some characters.
   subroutine replace(choice, text, new, old)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck
      character(len=*), intent(in) :: new            !! New characters
      integer, intent(in) :: old                     !! Number of characters to remove
      integer :: at

      at = choice%upto(len(text))
      text = text(:at - 1)//new//text(at + old:)
   end subroutine replace

   !> Copy a part of the text to another position.
   subroutine copy(choice, text)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck
      integer :: from

      from = choice%upto(len(text))
      call replace(choice, text, text(from:min(from + choice%upto(60), len(text))), 0)
   end subroutine copy

   !> Swap two lines.
   subroutine swap_lines(choice, text)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck

      call swap_pieces(choice, text, newline)
   end subroutine swap_lines

   !> Swap two words.
   subroutine swap_tokens(choice, text)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck

      call swap_pieces(choice, text, " ,="//newline)
   end subroutine swap_tokens

   !> Swap two parts of the text that are delimited by certain characters.
   subroutine swap_pieces(choice, text, marks)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck
      character(len=*), intent(in) :: marks          !! Delimiting characters
      integer :: first(2), last(2), positions(2), i

      positions = [choice%upto(len(text)), choice%upto(len(text))]
      positions = [minval(positions), maxval(positions)]
      do i = 1, 2
         first(i) = scan(text(:positions(i)), marks, back=.true.) + 1
         last(i) = positions(i) + scan(text(positions(i):)//marks, marks) - 2
      end do
      if (last(1) >= first(2) .or. any(last > len(text))) return
      text = text(:first(1) - 1)//text(first(2):last(2))//text(last(1) + 1:first(2) - 1)// &
         text(first(1):last(1))//text(last(2) + 1:)
   end subroutine swap_pieces

   !> Replace a number by an unusual one.
   subroutine mangle_number(choice, text)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=:), allocatable, intent(inout) :: text !! The deck
      character(len=*), parameter :: part_of_number = "0123456789.+-eE"
      integer :: at, first, last

      at = choice%upto(len(text))
      first = scan(text(at:), "0123456789") + at - 1
      if (first < at) return
      last = verify(text(first:)//" ", part_of_number) + first - 2
      first = verify(text(:first), part_of_number, back=.true.) + 1
      text = text(:first - 1)//trim(numbers(choice%upto(size(numbers))))//text(last + 1:)
   end subroutine mangle_number

   !> Misspell a key, a group, a word or a name so that it is unknown. `unknown` returns the
   !! misspelt word, or an empty text if there is none.
   subroutine respell(choice, schema, text, unknown)
      type(choice_t), intent(inout) :: choice        !! Random choices
      type(schema_t), intent(in) :: schema           !! What is allowed
      character(len=:), allocatable, intent(inout) :: text !! The deck
      character(len=:), allocatable, intent(inout) :: unknown !! The new word
      type(word_t), allocatable :: list(:)
      integer :: at, which

      call find_words(schema, text, list)
      if (size(list) == 0) return
      which = choice%upto(size(list))
      associate (word => list(which))
         unknown = text(word%first:word%last)
         at = choice%upto(len(unknown))
         select case (choice%upto(3))
         case (1)
            unknown = unknown(:at - 1)//one_of(choice)//unknown(at + 1:)
         case (2)
            unknown = unknown(:at)//one_of(choice)//unknown(at + 1:)
         case default
            unknown = unknown(:at - 1)//unknown(at + 1:)
         end select
         if (.not. is_unknown(schema, text, word, list, unknown)) then
            unknown = ""
            return
         end if
         text = text(:word%first - 1)//unknown//text(word%last + 1:)
      end associate
   end subroutine respell

   !> A random character of names.
   function one_of(choice) result(one)
      type(choice_t), intent(inout) :: choice        !! Random choices
      character(len=1) :: one
      integer :: at

      at = choice%upto(len(spelling))
      one = spelling(at:at)
   end function one_of

   !> True if no known word has this name and the text is still one word.
   logical function is_unknown(schema, text, word, list, name) result(unknown)
      type(schema_t), intent(in) :: schema           !! What is allowed
      character(len=*), intent(in) :: text           !! The deck
      type(word_t), intent(in) :: word               !! Word before the change
      type(word_t), intent(in) :: list(:)            !! All words of the deck
      character(len=*), intent(in) :: name           !! Word after the change
      integer :: i

      unknown = len(name) > 0
      if (.not. unknown) return
      unknown = is_letter(name(1:1))
      select case (word%kind)
      case ("g")
         unknown = unknown .and. schema%find(lower(name)) == 0
      case ("k")
         unknown = unknown .and. schema%groups(word%rule)%find(lower(name)) == 0
      case ("w")
         associate (key => schema%groups(word%rule)%keys(word%key))
            do i = 1, size(key%words)
               unknown = unknown .and. lower(key%words(i)%text) /= lower(name)
            end do
         end associate
      case default
         do i = 1, size(list)
            unknown = unknown .and. text(list(i)%first:list(i)%last) /= name
         end do
      end select
   end function is_unknown

   !> Words of a deck that can be misspelt, with the group and key that they belong to. The deck has
   !! no error, and no quotes within quotes.
   subroutine find_words(schema, text, list)
      type(schema_t), intent(in) :: schema           !! What is allowed
      character(len=*), intent(in) :: text           !! The deck
      type(word_t), allocatable, intent(out) :: list(:) !! The words
      type(word_t) :: word, all(2000)
      integer :: at, found

      found = 0
      at = 1
      do while (at <= len(text))
         word%first = at
         word%kind = " "
         select case (text(at:at))
         case ("!")
            at = at + scan(text(at:)//newline, newline)
         case ("'", '"')
            at = at + scan(text(at + 1:), text(at:at)) + 1
            call name_quoted(schema, word, at)
         case ("&")
            at = at + verify(text(at + 1:)//" ", spelling)
            word%first = word%first + 1
            word%last = at - 1
            word%kind = "g"
            word%rule = schema%find(text(word%first:word%last))
         case ("a":"z")
            at = at + verify(text(at + 1:)//" ", spelling)
            word%last = at - 1
            if (index(adjustl(text(at:)), "=") == 1 .and. word%rule > 0) then
               word%kind = "k"
               word%key = schema%groups(word%rule)%find(text(word%first:word%last))
            end if
         case ("0":"9", ".")
            at = at + verify(text(at + 1:)//" ", "0123456789.+-eEdD")
         case default
            at = at + 1
         end select
         if (word%kind == " " .or. word%rule == 0 .or. found == size(all)) cycle
         found = found + 1
         all(found) = word
      end do
      list = all(:found)
   end subroutine find_words

   !> Classify a quoted text: a word or a name that must exist, or free text.
   subroutine name_quoted(schema, word, at)
      type(schema_t), intent(in) :: schema           !! What is allowed
      type(word_t), intent(inout) :: word            !! Its group and key are known
      integer, intent(in) :: at                      !! Position after the closing quote

      word%first = word%first + 1
      word%last = at - 2
      if (word%rule == 0 .or. word%key == 0 .or. word%last < word%first) return
      associate (key => schema%groups(word%rule)%keys(word%key))
         if (size(key%words) > 0) word%kind = "w"
         if (key%target /= "") word%kind = "n"
         if (key%group == "output" .and. key%name == "fields") word%kind = "n"
      end associate
   end subroutine name_quoted
end module fuzz_mutation
