! SPDX-License-Identifier: BSD-3-Clause
!> Splits namelist text into groups and assignments `key = value`, each with its file and line.
!!
!! Compilers report an error in a namelist with the wrong name, without a line, or not at all. Here
!! each error is found, has a line, and does not hide the next one. A quoted text ends in the line
!! in which it begins. Marks in the text give the file and line of the next line, so that included
!! files can be part of one text.
module deck_namelist
   use base_text, only: append, lower, number, text_t
   use deck_namelist_words, only: lexeme_t, scanner_t, word_broken, word_comma, word_equals, &
      word_formula, word_group, word_nothing, word_plain, word_quoted, word_slash
   use deck_problems, only: problems_t
   implicit none
   private

   public :: as_written, block_t, namelist_t, piece_t, token_t

   !> One value of an assignment.
   type :: token_t
      character(len=:), allocatable :: raw               !! Text as written
      character(len=:), allocatable :: text              !! The same without its quotes
      logical :: quoted = .false.                        !! Was it in quotes?
      logical :: comma = .false.                         !! Is it a comma?
      logical :: formula = .false.                       !! Is it an expression in braces?
      integer :: line = 0                                !! Line of the file
      integer :: column = 0                              !! Column of its first character
   end type token_t

   !> One `key = value`.
   type :: piece_t
      character(len=:), allocatable :: key               !! Lower case
      character(len=:), allocatable :: subscript         !! Text in brackets after the key
      integer :: line = 0                                !! Line of the key
      logical :: broken = .false.                        !! Has its error been reported?
      type(token_t), allocatable :: tokens(:)            !! Values and commas
   end type piece_t

   !> One group.
   type :: block_t
      character(len=:), allocatable :: name              !! Lower case
      character(len=:), allocatable :: file              !! File of the group
      integer :: line = 0                                !! Line of its name
      integer :: first = 0                               !! First letter of the group in the text
      integer :: last = 0                                !! Last letter of the group in the text
      logical :: broken = .false.                        !! May parts be missing after an error?
      type(piece_t), allocatable :: pieces(:)            !! Assignments of the group
   end type block_t

   !> All groups of a text.
   type :: namelist_t
      integer :: count = 0                               !! Number of groups
      type(block_t), allocatable :: blocks(:)            !! The groups; longer than `count`
      type(text_t), allocatable :: files(:)              !! The files in the order of reading
   contains
      procedure :: scan => namelist_scan                 !! Split a text into groups
   end type namelist_t

contains

   !> Split a text into groups.
   subroutine namelist_scan(self, text, file, problems)
      class(namelist_t), intent(out) :: self
      character(len=*), intent(in) :: text               !! All lines
      character(len=*), intent(in) :: file               !! Name of the file, for messages
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(scanner_t) :: scanner
      type(lexeme_t) :: found
      logical :: reported
      integer :: line

      call append(self%files, file)
      allocate (self%blocks(16))
      call scanner%start(text, file)
      reported = .false.
      line = 0
      do
         call scanner%next(found, problems)
         if (found%kind == word_nothing) exit
         if (found%kind == word_group) then
            call scan_group(self, scanner, found, problems)
            reported = .false.
            line = scanner%line
         else if (.not. reported) then
            ! text outside the groups is reported once between two groups
            if (found%line == line) then
               call problems%error(scanner%file, found%line, "text after the / that ends the "// &
                  "group: "//scanner%rest_of_line(found%first)// &
                  "; texts need quotes, expressions braces [D103]")
            else
               call problems%error(scanner%file, found%line, "text outside a group: "// &
                  scanner%rest_of_line(found%first)// &
                  "; a group begins with &name and ends with / [D104]")
            end if
            reported = .true.
         end if
         call add_file(self%files, scanner%file)
      end do
   end subroutine namelist_scan

   !> Add a file to the list unless it is there.
   subroutine add_file(files, file)
      type(text_t), allocatable, intent(inout) :: files(:) !! The known ones
      character(len=*), intent(in) :: file               !! Name of a file
      integer :: i

      do i = size(files), 1, -1
         if (files(i)%text == file) return
      end do
      call append(files, file)
   end subroutine add_file

   !> Read one group up to its slash. If the slash is missing, the group ends before the next group
   !! or at the end of the file.
   subroutine scan_group(self, scanner, head, problems)
      class(namelist_t), intent(inout) :: self           !! Gets the group
      type(scanner_t), intent(inout) :: scanner          !! After the name of the group
      type(lexeme_t), intent(in) :: head                 !! The name of the group
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(block_t) :: group
      type(lexeme_t), allocatable :: words(:)
      integer :: filled, i
      type(block_t), allocatable :: longer(:)

      group%name = lower(scanner%letters(head%first + 1, head%last))
      group%file = scanner%file
      group%line = head%line
      group%first = head%first
      scanner%inside = group%name
      allocate (words(32))
      filled = 0
      do
         filled = filled + 1
         if (filled > size(words)) words = [words, words]
         call scanner%next(words(filled), problems)
         select case (words(filled)%kind)
         case (word_slash)
            group%last = words(filled)%last
            exit
         case (word_group)
            if (lower(scanner%letters(words(filled)%first, words(filled)%last)) == "&end") exit
            if (.not. group%broken) call problems%error(group%file, words(filled)%line, &
               "&"//group%name//" opened in line "//number(group%line)// &
               " is not closed before this group [D102]")
            call scanner%back(words(filled))
            exit
         case (word_nothing)
            if (.not. group%broken) call problems%error(group%file, group%line, &
               "&"//group%name//" is not closed by a / before the end of the file [D102]")
            exit
         case (word_broken)
            group%broken = .true.
         case default
            continue
         end select
      end do
      scanner%inside = ""
      call cut_pieces(group, scanner, words(:filled - 1), problems)
      ! append it to the list
      if (self%count == size(self%blocks)) then
         allocate (longer(2*self%count))
         do i = 1, self%count
            call move_block(self%blocks(i), longer(i))
         end do
         call move_alloc(longer, self%blocks)
      end if
      self%count = self%count + 1
      call move_block(group, self%blocks(self%count))
   end subroutine scan_group

   !> Move a group.
   subroutine move_block(from, to)
      type(block_t), intent(inout) :: from               !! Emptied
      type(block_t), intent(inout) :: to                 !! Filled

      call move_alloc(from%name, to%name)
      call move_alloc(from%file, to%file)
      call move_alloc(from%pieces, to%pieces)
      to%line = from%line
      to%first = from%first
      to%last = from%last
      to%broken = from%broken
   end subroutine move_block

   !> Split the words of a group into assignments: the word before each `=` is a key.
   subroutine cut_pieces(group, scanner, words, problems)
      type(block_t), intent(inout) :: group              !! Gets the assignments
      type(scanner_t), intent(in) :: scanner
      type(lexeme_t), intent(in) :: words(:)             !! All words of the group
      type(problems_t), intent(inout) :: problems        !! Collects errors
      integer, allocatable :: key_at(:), value_at(:)
      integer :: i, last, pieces

      allocate (key_at(count(words%kind == word_equals) + 1), source=0)
      value_at = key_at
      pieces = 0
      last = 0
      do i = 1, size(words)
         if (words(i)%kind /= word_equals) cycle
         pieces = pieces + 1
         key_at(pieces) = key_before(scanner, words, i, last)
         value_at(pieces) = i + 1
         last = i
      end do
      key_at(pieces + 1) = size(words) + 1
      do i = 1, key_at(1) - 1
         if (words(i)%kind == word_comma .or. words(i)%kind == word_broken) cycle
         call problems%error(group%file, words(i)%line, "&"//group%name// &
            ": expects key = value, not "//scanner%letters(words(i)%first, words(i)%last)// &
            " [D105]")
         exit
      end do
      allocate (group%pieces(pieces))
      do i = 1, pieces
         call cut_piece(group, i, scanner, words(key_at(i):value_at(i) - 1), &
            words(value_at(i):key_at(i + 1) - 1), problems)
      end do
   end subroutine cut_pieces

   !> Index of the first word of the key before an equals sign; that of the sign if there is none.
   integer function key_before(scanner, words, equals, last) result(first)
      type(scanner_t), intent(in) :: scanner
      type(lexeme_t), intent(in) :: words(:)             !! All words of the group
      integer, intent(in) :: equals                      !! Index of the equals sign
      integer, intent(in) :: last                        !! Index of the equals sign before it, or 0

      first = equals
      if (equals - 1 <= last) return
      if (words(equals - 1)%kind /= word_plain) return
      first = equals - 1
      if (scanner%letters(words(first)%first, words(first)%first) /= "(") return
      if (first - 1 <= last) return
      if (words(first - 1)%kind == word_plain) first = first - 1
   end function key_before

   !> Make an assignment of its key and values.
   subroutine cut_piece(group, place, scanner, key, values, problems)
      type(block_t), intent(inout) :: group !! The group, with its assignments allocated
      integer, intent(in) :: place                       !! Index of the assignment
      type(scanner_t), intent(in) :: scanner
      type(lexeme_t), intent(in) :: key(:)               !! Words of the key and the equals sign
      type(lexeme_t), intent(in) :: values(:)            !! Words of the value
      type(problems_t), intent(inout) :: problems        !! Collects errors
      character(len=:), allocatable :: name
      integer :: bracket, i, total

      associate (piece => group%pieces(place))
         name = ""
         do i = 1, size(key) - 1
            name = name//scanner%letters(key(i)%first, key(i)%last)
         end do
         bracket = scan(name//"(", "(")
         piece%key = lower(name(:bracket - 1))
         piece%subscript = name(bracket:)
         piece%line = key(1)%line
         piece%broken = any(values%kind == word_broken)
         if (piece%key == "") then
            call problems%error(group%file, piece%line, "&"//group%name// &
               ": an equals sign without a key before it [D106]")
            piece%broken = .true.
         end if
         total = size(values)
         if (total > 0) then
            if (values(total)%kind == word_comma) total = total - 1
         end if
         allocate (piece%tokens(total))
         do i = 1, total
            associate (word => values(i), token => piece%tokens(i))
               token%raw = scanner%letters(word%first, word%last)
               token%text = token%raw
               token%comma = word%kind == word_comma
               token%quoted = word%kind == word_quoted
               token%formula = word%kind == word_formula
               token%line = word%line
               token%column = word%column
               if (token%quoted) token%text = unquoted_text(token%raw)
            end associate
         end do
      end associate
   end subroutine cut_piece

   !> Values and commas as written.
   pure function as_written(tokens, most) result(text)
      type(token_t), intent(in) :: tokens(:)
      integer, intent(in), optional :: most !! Number of letters after which it may be cut
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      do i = 1, size(tokens)
         if (i > 1 .and. .not. tokens(i)%comma) text = text//" "
         text = text//tokens(i)%raw
         if (present(most)) then
            if (len(text) > most) exit
         end if
      end do
   end function as_written

   !> A quoted text without its quotes; a doubled quote in it is one quote.
   pure function unquoted_text(raw) result(text)
      character(len=*), intent(in) :: raw                !! With quotes
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      i = 2
      do while (i < len(raw))
         text = text//raw(i:i)
         i = i + merge(2, 1, raw(i:i) == raw(1:1))
      end do
   end function unquoted_text
end module deck_namelist
