! SPDX-License-Identifier: BSD-3-Clause
!> Reads a deck and the files that it includes into one text.
!!
!! One rank reads. The text can be sent to the others, which parse it to the same messages.
module deck_source
   use base_error, only: error_t, exit_file, exit_input, fail
   use base_file, only: file_exists, file_size, folder_of, join_path, read_file
   use base_kinds, only: int64
   use base_text, only: append, buffer_t, join, number, text_t
   use deck_namelist, only: block_t, namelist_t
   use deck_namelist_words, only: file_mark
   use deck_problems, only: problems_t
   implicit none
   private

   public :: read_deck_file

   integer(int64), parameter :: largest_file = 64_int64*1024_int64**2 !! [byte]
   character(len=*), parameter :: own_error = ": error: " !! Between file and message
   character(len=3), parameter :: byte_order_mark = char(239)//char(187)//char(191)
   character(len=1), parameter :: newline = achar(10), carriage_return = achar(13)

contains

   !> Read a deck with all included files.
   subroutine read_deck_file(path, text, error)
      character(len=*), intent(in) :: path
      character(len=:), allocatable, intent(out) :: text !! All lines, with marks at includes
      type(error_t), allocatable, intent(out) :: error   !! A file is unreadable or not a deck
      type(text_t), allocatable :: chain(:)
      type(buffer_t) :: buffer

      call append(chain, path)
      call append_file(path, chain, buffer, error)
      text = buffer%content()
      if (allocated(error)) return
      if (scan(text, "&") == 0) call fail(error, exit_input, path//own_error// &
         "the deck is empty; "// &
         "scree --template prints one with all keys [D109]")
   end subroutine read_deck_file

   !> Append a file to the text, with the files that it includes.
   recursive subroutine append_file(path, chain, buffer, error)
      character(len=*), intent(in) :: path
      type(text_t), intent(in) :: chain(:)               !! The file and those that include it
      type(buffer_t), intent(inout) :: buffer            !! Extended by the text
      type(error_t), allocatable, intent(out) :: error   !! A file is unreadable or not a deck
      type(namelist_t) :: namelist
      type(problems_t) :: ignored
      character(len=:), allocatable :: text
      integer :: at, i, k, lines

      call read_plain_text(path, text, error)
      if (allocated(error)) return
      call namelist%scan(text, path, ignored)
      at = 1
      do i = 1, namelist%count
         associate (block => namelist%blocks(i))
            if (block%name /= "include" .or. block%last == 0) cycle
            call buffer%add(text(at:block%first - 1)//newline)
            call include_file(block, path, chain, buffer, error)
            if (allocated(error)) return
            at = block%last + 1
            lines = count([(text(k:k) == newline, k=1, block%last)])
            call buffer%add(file_mark(path, 1 + lines))
         end associate
      end do
      call buffer%line(text(at:))
   end subroutine append_file

   !> Append the file that an &include names.
   recursive subroutine include_file(block, path, chain, buffer, error)
      type(block_t), intent(in) :: block
      character(len=*), intent(in) :: path               !! File of the group
      type(text_t), intent(in) :: chain(:)               !! That file and those that include it
      type(buffer_t), intent(inout) :: buffer            !! Extended by the text
      type(error_t), allocatable, intent(out) :: error   !! A file is unreadable or not a deck
      type(text_t), allocatable :: longer(:)
      character(len=:), allocatable :: name, place
      integer :: i

      place = path//":"//number(block%line)//": error: &include: "
      call file_of(block, name)
      if (name == "") then
         call fail(error, exit_input, place//"expects file = 'name' and nothing else [D110]")
         return
      end if
      if (name(1:1) /= "/" .and. folder_of(path) /= ".") name = join_path(folder_of(path), name)
      longer = chain
      call append(longer, name)
      do i = 1, size(chain)
         if (chain(i)%text /= name) cycle
         call fail(error, exit_input, place//"a file cannot include itself: "//join(longer, &
            " > ")//" [D335]")
         return
      end do
      if (size(longer) > 20) then
         call fail(error, exit_input, place//"more than 20 files include each other [F123]")
         return
      end if
      call buffer%add(file_mark(name, 1))
      call append_file(name, longer, buffer, error)
      if (.not. allocated(error)) return
      if (index(error%message, name//own_error) /= 1) return
      error%message = place//error%message(len(name//own_error) + 1:)
   end subroutine include_file

   !> File name of an &include; empty if the group is malformed.
   subroutine file_of(block, name)
      type(block_t), intent(in) :: block
      character(len=:), allocatable, intent(out) :: name

      name = ""
      if (size(block%pieces) /= 1) return
      associate (piece => block%pieces(1))
         if (piece%key /= "file" .or. piece%subscript /= "" .or. size(piece%tokens) /= 1) return
         if (piece%tokens(1)%quoted) name = trim(adjustl(piece%tokens(1)%text))
      end associate
   end subroutine file_of

   !> Read one file, check that it is plain text, and convert its line ends to those of Unix.
   subroutine read_plain_text(path, text, error)
      character(len=*), intent(in) :: path
      character(len=:), allocatable, intent(out) :: text
      type(error_t), allocatable, intent(out) :: error   !! If the file cannot be read or is no text
      character(len=:), allocatable :: raw
      integer :: i, lines, start, filled

      if (file_exists(path//"/.")) then
         call fail(error, exit_file, path//own_error//"this is a folder, not a deck [F101]")
         return
      end if
      if (file_size(path) > largest_file) then
         call fail(error, exit_file, path//own_error//"too large for a deck [F123]")
         return
      end if
      call read_file(path, raw, error)
      if (allocated(error)) then
         error%message = path//own_error//error%message
         return
      end if
      start = 1
      if (index(raw, byte_order_mark) == 1) start = 4
      lines = 1
      do i = start, len(raw)
         if (raw(i:i) == newline) lines = lines + 1
         if (iachar(raw(i:i)) >= 32 .or. scan(raw(i:i), newline//carriage_return//achar(9)) == 1) &
            cycle
         call fail(error, exit_input, path//":"//number(lines)//": error: character number "// &
            number(iachar(raw(i:i)))//" is not allowed; a deck is plain text [D107]")
         return
      end do
      ! line feeds alone at the ends of lines
      raw = raw(start:)
      allocate (character(len=len(raw)) :: text)
      filled = 0
      do i = 1, len(raw)
         if (raw(i:i) == newline .and. i > 1) then
            if (raw(i - 1:i - 1) == carriage_return) cycle
         end if
         filled = filled + 1
         text(filled:filled) = raw(i:i)
         if (raw(i:i) == carriage_return) text(filled:filled) = newline
      end do
      text = text(:filled)
   end subroutine read_plain_text
end module deck_source
