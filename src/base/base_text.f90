! SPDX-License-Identifier: BSD-3-Clause
!> Lists of texts, spelling suggestions, and numbers as text that reads back to the same bits.
module base_text
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: append, brief, buffer_t, closest, closest_meaning, distance, exponent_text, &
      is_letter, join, line_end, lower, number, shared_words, shortened, size_text, split, text_t

   !> A text of any length, for arrays of texts.
   type :: text_t
      character(len=:), allocatable :: text              !! Any number of letters
   end type text_t

   !> A text that grows without a copy for each addition.
   type :: buffer_t
      integer, private :: filled = 0                     !! Letters in use
      character(len=:), allocatable, private :: letters  !! Buffer, longer than the text
   contains
      procedure :: add => buffer_add                     !! Append letters
      procedure :: line => buffer_line                   !! Append a line
      procedure :: content => buffer_content             !! All letters so far
   end type buffer_t

   !> A number as text. A real number reads back as exactly the same number.
   interface number
      module procedure number_of_real
      module procedure number_of_integer
      module procedure number_of_long_integer
   end interface number

contains

   !> Append letters to a buffer.
   pure subroutine buffer_add(self, letters)
      class(buffer_t), intent(inout) :: self
      character(len=*), intent(in) :: letters            !! Text to append
      character(len=:), allocatable :: longer
      integer :: needed

      needed = self%filled + len(letters)
      if (.not. allocated(self%letters)) allocate (character(len=max(256, needed)) :: self%letters)
      if (needed > len(self%letters)) then
         allocate (character(len=2*needed) :: longer)
         longer(:self%filled) = self%letters(:self%filled)
         call move_alloc(longer, self%letters)
      end if
      self%letters(self%filled + 1:needed) = letters
      self%filled = needed
   end subroutine buffer_add

   !> Append a line, with its end, to a buffer.
   pure subroutine buffer_line(self, letters)
      class(buffer_t), intent(inout) :: self
      character(len=*), intent(in) :: letters            !! The line without its end

      call self%add(letters)
      call self%add(new_line("a"))
   end subroutine buffer_line

   !> All letters of a buffer.
   pure function buffer_content(self) result(letters)
      class(buffer_t), intent(in) :: self
      character(len=:), allocatable :: letters

      letters = ""
      if (self%filled > 0) letters = self%letters(:self%filled)
   end function buffer_content

   !> Append one text to a list.
   pure subroutine append(list, text)
      type(text_t), allocatable, intent(inout) :: list(:) !! Not allocated counts as empty
      character(len=*), intent(in) :: text               !! The new last one
      type(text_t), allocatable :: longer(:)
      integer :: i, known

      known = 0
      if (allocated(list)) known = size(list)
      allocate (longer(known + 1))
      do i = 1, known
         call move_alloc(list(i)%text, longer(i)%text)
      end do
      longer(known + 1)%text = text
      call move_alloc(longer, list)
   end subroutine append

   !> True for the letters of names, a to z of either case.
   pure elemental logical function is_letter(letter) result(yes)
      character(len=1), intent(in) :: letter             !! Any character

      yes = ("a" <= letter .and. letter <= "z") .or. ("A" <= letter .and. letter <= "Z")
   end function is_letter

   !> A text in lower case.
   pure function lower(text) result(small)
      character(len=*), intent(in) :: text               !! Text
      character(len=len(text)) :: small
      integer :: i

      do i = 1, len(text)
         if ("A" <= text(i:i) .and. text(i:i) <= "Z") then
            small(i:i) = achar(iachar(text(i:i)) + 32)
         else
            small(i:i) = text(i:i)
         end if
      end do
   end function lower

   !> A text for a message, cut if it is long, but not within a multibyte character.
   pure function shortened(text, most) result(short)
      character(len=*), intent(in) :: text               !! Text
      integer, intent(in) :: most                        !! Greatest number of bytes kept
      character(len=:), allocatable :: short
      integer :: last

      short = text
      if (len(text) <= most) return
      do last = most, 1, -1
         if (iand(ichar(text(last + 1:last + 1)), 192) /= 128) exit
      end do
      short = text(:last)//"..."
   end function shortened

   !> Last place of the line that begins at a place of a text; the text is not copied.
   pure integer function line_end(text, first) result(last)
      character(len=*), intent(in) :: text           !! Lines
      integer, intent(in) :: first                   !! Place of the first letter of a line

      last = first + index(text(first:), new_line("a")) - 2
      if (last < first - 1) last = len(text)
   end function line_end

   !> Words of a text that blanks separate.
   pure subroutine split(text, words)
      character(len=*), intent(in) :: text               !! Words and blanks
      type(text_t), allocatable, intent(out) :: words(:)
      integer :: first, last

      allocate (words(0))
      first = 1
      do while (first <= len(text))
         if (text(first:first) == " ") then
            first = first + 1
            cycle
         end if
         last = index(text(first:), " ") + first - 2
         if (last < first) last = len(text)
         call append(words, text(first:last))
         first = last + 1
      end do
   end subroutine split

   !> Texts joined with a separator.
   pure function join(words, separator) result(row)
      type(text_t), intent(in) :: words(:)
      character(len=*), intent(in) :: separator          !! Text between two of them
      character(len=:), allocatable :: row
      type(buffer_t) :: buffer
      integer :: i

      do i = 1, size(words)
         if (i > 1) call buffer%add(separator)
         call buffer%add(words(i)%text)
      end do
      row = buffer%content()
   end function join

   !> Number of letters to insert, delete, change, or swap to turn one word into another.
   !!
   !! Levenshtein's distance with swaps (optimal string alignment).
   pure integer function distance(from, to) result(changes)
      character(len=*), intent(in) :: from               !! One word
      character(len=*), intent(in) :: to                 !! The other word
      integer :: before(0:len(to)), now(0:len(to)), earlier(0:len(to))
      integer :: i, j

      now = [(j, j=0, len(to))]
      before = 0
      do i = 1, len(from)
         earlier = before
         before = now
         now(0) = i
         do j = 1, len(to)
            now(j) = min(before(j) + 1, now(j - 1) + 1, &
               before(j - 1) + merge(0, 1, from(i:i) == to(j:j)))
            if (min(i, j) == 1) cycle
            if (from(i:i) == to(j - 1:j - 1) .and. from(i - 1:i - 1) == to(j:j)) &
               now(j) = min(now(j), earlier(max(j - 2, 0)) + 1)
         end do
      end do
      changes = now(len(to))
   end function distance

   !> The closest word of a list, or an empty text if none is close.
   pure function closest(word, candidates) result(best)
      character(len=*), intent(in) :: word               !! Text of the user
      type(text_t), intent(in) :: candidates(:)          !! Valid words
      character(len=:), allocatable :: best
      integer :: changes, i, least

      best = ""
      if (len(word) > 64) return
      least = max(1, (len(word) + 2)/3) + 1
      do i = 1, size(candidates)
         if (abs(len(candidates(i)%text) - len(word)) >= least) cycle
         changes = distance(lower(word), lower(candidates(i)%text))
         if (changes >= least .or. changes >= max(len(word), len(candidates(i)%text))) cycle
         least = changes
         best = candidates(i)%text
      end do
   end function closest

   !> The name in the entry that has most words in common with a text, or an empty text:
   !! aluminium_6061 is closest to "al_6061_t6 aluminium 6061-T6".
   pure function closest_meaning(word, meanings) result(best)
      character(len=*), intent(in) :: word               !! Text of the user
      type(text_t), intent(in) :: meanings(:)            !! A name and what it means
      character(len=:), allocatable :: best
      integer :: i, most, shared

      best = ""
      most = 0
      if (len(word) > 64) return
      do i = 1, size(meanings)
         shared = shared_words(word, meanings(i)%text)
         if (shared <= most) cycle
         most = shared
         best = meanings(i)%text
      end do
      best = best(:index(best//" ", " ") - 1)
   end function closest_meaning

   !> The number of words of a text that another one contains, but for typing errors.
   pure integer function shared_words(text, other) result(shared)
      character(len=*), intent(in) :: text               !! Words, also joined by underscores
      character(len=*), intent(in) :: other              !! Is searched for them
      type(text_t), allocatable :: parts(:), words(:)
      integer :: j, k

      call split(word_parts(text), parts)
      call split(word_parts(other), words)
      shared = 0
      do j = 1, size(parts)
         do k = 1, size(words)
            if (.not. are_similar(parts(j)%text, words(k)%text)) cycle
            shared = shared + 1
            exit
         end do
      end do
   end function shared_words

   !> A text in lower case with blanks for signs, and between letters and digits.
   pure function word_parts(text) result(words)
      character(len=*), intent(in) :: text               !! Value
      character(len=:), allocatable :: words
      character(len=*), parameter :: digits = "0123456789"
      character(len=1) :: letter
      logical :: digit
      integer :: i

      words = ""
      digit = .false.
      do i = 1, len(text)
         letter = lower(text(i:i))
         if (is_letter(letter) .or. index(digits, letter) > 0) then
            if (digit .neqv. index(digits, letter) > 0) words = words//" "
            digit = index(digits, letter) > 0
            words = words//letter
         else
            words = words//" "
         end if
      end do
   end function word_parts

   !> True for two words that are the same except for a typing error, or if one begins with the
   !! other.
   pure logical function are_similar(one, other) result(yes)
      character(len=*), intent(in) :: one                !! A word in small letters
      character(len=*), intent(in) :: other              !! Another one
      integer, parameter :: telling = 3                  ! shortest common start
      integer :: shorter

      yes = one == other
      shorter = min(len(one), len(other))
      if (yes .or. shorter < telling .or. .not. is_letter(one(1:1))) return
      yes = one(:shorter) == other(:shorter)
      if (.not. yes .and. shorter > telling) yes = distance(one, other) <= shorter/4
   end function are_similar

   !> An integer as text.
   pure function number_of_integer(value) result(text)
      integer, intent(in) :: value                       !! Any integer
      character(len=:), allocatable :: text
      character(len=12) :: line

      write (line, "(i0)") value
      text = trim(line)
   end function number_of_integer

   !> A long integer as text.
   pure function number_of_long_integer(value) result(text)
      integer(int64), intent(in) :: value                !! Any integer
      character(len=:), allocatable :: text
      character(len=21) :: line

      write (line, "(i0)") value
      text = trim(line)
   end function number_of_long_integer

   !> The shortest of 15 to 17 digits that reads back as exactly the same number.
   pure function number_of_real(value) result(text)
      real(wp), intent(in) :: value                      !! A finite number
      character(len=:), allocatable :: text

      text = tidied(exact_digits(value))
   end function number_of_real

   !> The same digits in the form of tables and summaries: an exponent of three digits, 1.25E+003.
   pure function exponent_text(value) result(text)
      real(wp), intent(in) :: value                      !! Any number
      character(len=:), allocatable :: text
      character(len=32) :: line
      integer :: last, mark

      line = exact_digits(value)
      mark = index(line, "E")
      if (mark == 0) then
         write (line, "(g0)") value
         text = trim(adjustl(line))
         return
      end if
      last = verify(line(:mark - 1), "0", back=.true.)
      text = line(:merge(last + 1, last, line(last:last) == "."))//trim(line(mark:))
   end function exponent_text

   !> Digits of a number that give the same bits when read back, with an exponent.
   pure function exact_digits(value) result(line)
      real(wp), intent(in) :: value                      !! Any number
      character(len=32) :: line
      character(len=12) :: layout
      real(wp) :: again
      integer :: digits, status

      do digits = 14, 16
         write (layout, "(a, i0, a)") "(es32.", digits, "e3)"
         write (line, layout) value
         read (line, *, iostat=status) again
         if (status == 0 .and. transfer(again, 0_int64) == transfer(value, 0_int64)) exit
      end do
      line = adjustl(line)
   end function exact_digits

   !> A number rounded to six digits.
   pure function brief(value) result(text)
      real(wp), intent(in) :: value                      !! A finite number
      character(len=:), allocatable :: text
      character(len=32) :: line

      write (line, "(es32.5e3)") value
      text = tidied(adjustl(line))
      if (len(text) < 3) return
      if (text(len(text) - 1:) == ".0") text = text(:len(text) - 2)
   end function brief

   !> A number of bytes in kB, MB and so on.
   pure function size_text(bytes) result(text)
      real(wp), intent(in) :: bytes                      !! Value
      character(len=:), allocatable :: text
      character(len=24) :: line

      if (bytes < 1.0e9_wp) then
         write (line, "(f12.1)") bytes*1.0e-6_wp
         text = trim(adjustl(line))//" MB"
      else if (bytes < 1.0e12_wp) then
         write (line, "(f12.2)") bytes*1.0e-9_wp
         text = trim(adjustl(line))//" GB"
      else
         text = brief(bytes*1.0e-12_wp)//" TB"
      end if
   end function size_text

   !> A number such as 1.2300E+002 as 123.0: no trailing zeros, an exponent only for short text.
   pure function tidied(line) result(text)
      character(len=*), intent(in) :: line               !! One digit, point, digits, E, exponent
      character(len=:), allocatable :: text
      character(len=:), allocatable :: digits, sign
      integer :: exponent, last, mark

      mark = scan(line, "E")
      if (mark == 0) then
         text = trim(line)
         return
      end if
      read (line(mark + 1:), *) exponent
      sign = ""
      if (line(1:1) == "-") sign = "-"
      digits = line(len(sign) + 1:len(sign) + 1)//line(len(sign) + 3:mark - 1)
      last = max(verify(digits, "0", back=.true.), 1)
      digits = digits(:last)
      if (digits == "0") then
         text = sign//"0.0"
      else if (exponent < -4 .or. exponent > 6) then
         if (last == 1) digits = digits//"0"
         text = sign//digits(1:1)//"."//digits(2:)//"e"//number(exponent)
      else if (exponent < 0) then
         text = sign//"0."//repeat("0", -exponent - 1)//digits
      else
         digits = digits//repeat("0", max(exponent + 2 - last, 0))
         text = sign//digits(:exponent + 1)//"."//digits(exponent + 2:)
      end if
   end function tidied
end module base_text
