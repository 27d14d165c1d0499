! SPDX-License-Identifier: BSD-3-Clause
!> Errors and warnings of a deck, reported together in the order of the lines.
module deck_problems
   use base_error, only: code_last
   use base_text, only: buffer_t, number, text_t
   implicit none
   private

   public :: problems_t

   !> File name of values from the command line.
   character(len=*), parameter, public :: command_line = "command line"
   integer, parameter :: most_reported = 200                 !! Longer reports are cut

   !> A repeated body. The same error would otherwise be reported for each of its copies.
   type :: repeated_t
      character(len=:), allocatable :: body !! Name, the start of the names of its copies
      character(len=:), allocatable :: region !! Name of its region, which is repeated too
      integer :: copies = 0                              !! Number of copies
   end type repeated_t

   !> One error or warning.
   type :: problem_t
      character(len=:), allocatable :: file              !! File and line
      integer :: line = 0                                !! Line of the file, 0 = none
      logical :: is_error = .true.                       !! False: it is a warning
      character(len=:), allocatable :: text              !! Error and its remedy
      character(len=:), allocatable :: common            !! Part of the text common to all copies
      integer :: copies = 1                              !! Number of copies with this message
   end type problem_t

   !> All errors and warnings of a deck.
   type :: problems_t
      integer :: errors = 0                              !! Number of errors
      integer :: warnings = 0                            !! Number of warnings
      !> As found; may be longer than the number of entries
      type(problem_t), allocatable, private :: entries(:)
      type(repeated_t), allocatable, private :: repeated(:) !! Repeated bodies
   contains
      procedure :: repeat => problems_repeat             !! Report errors of copies only once
      procedure :: error => problems_error               !! Record an error
      procedure :: warning => problems_warning           !! Record a warning
      procedure :: report => problems_report             !! All as text, in the order of the lines
      procedure :: within => problems_within !! Is there an error in some lines of a file?
      procedure :: about => problems_about               !! Is there an error without a line?
   end type problems_t

contains

   !> Record an error.
   pure subroutine problems_error(self, file, line, text)
      class(problems_t), intent(inout) :: self
      character(len=*), intent(in) :: file               !! File and line
      integer, intent(in) :: line                        !! Line of the file, 0 = none
      character(len=*), intent(in) :: text               !! Error and its remedy
      logical :: joined

      call join_copies(self, file, line, .true., text, joined)
      if (joined) return
      self%errors = self%errors + 1
      call record_problem(self, file, line, .true., text)
   end subroutine problems_error

   !> Record a warning.
   pure subroutine problems_warning(self, file, line, text)
      class(problems_t), intent(inout) :: self
      character(len=*), intent(in) :: file               !! File and line
      integer, intent(in) :: line                        !! Line of the file, 0 = none
      character(len=*), intent(in) :: text               !! Error and its remedy
      logical :: joined

      call join_copies(self, file, line, .false., text, joined)
      if (joined) return
      self%warnings = self%warnings + 1
      call record_problem(self, file, line, .false., text)
   end subroutine problems_warning

   !> True if there is an error in some lines of a file.
   pure logical function problems_within(self, file, first, last) result(found)
      class(problems_t), intent(in) :: self
      character(len=*), intent(in) :: file               !! Name of the file
      integer, intent(in) :: first                       !! First line
      integer, intent(in) :: last                        !! Last line
      integer :: i

      found = .false.
      do i = 1, self%errors + self%warnings
         associate (entry => self%entries(i))
            if (entry%is_error .and. entry%line >= first .and. entry%line <= last) &
               found = found .or. entry%file == file
         end associate
      end do
   end function problems_within

   !> True if there is an error without a line whose text begins with a word: an error of the
   !! command line, or of something that is missing.
   pure logical function problems_about(self, word) result(found)
      class(problems_t), intent(in) :: self
      character(len=*), intent(in) :: word               !! Such as &grid
      integer :: i

      found = .false.
      do i = 1, self%errors + self%warnings
         associate (entry => self%entries(i))
            if (entry%is_error .and. entry%line == 0) &
               found = found .or. index(entry%text, word) == 1
         end associate
      end do
   end function problems_about

   !> Report an error in the copies of a body, NAME_1, NAME_2 and so on, or in their regions of the
   !! same names, only once from now on.
   pure subroutine problems_repeat(self, body, region, copies)
      class(problems_t), intent(inout) :: self
      character(len=*), intent(in) :: body               !! Name of the body
      character(len=*), intent(in) :: region             !! Name of its region
      integer, intent(in) :: copies                      !! How many there are
      type(repeated_t), allocatable :: longer(:)
      integer :: known

      known = 0
      if (allocated(self%repeated)) known = size(self%repeated)
      allocate (longer(known + 1))
      if (known > 0) longer(:known) = self%repeated
      longer(known + 1)%body = body
      longer(known + 1)%region = region
      longer(known + 1)%copies = copies
      call move_alloc(longer, self%repeated)
   end subroutine problems_repeat

   !> Join a message with that of another copy of the same body, if there is one.
   pure subroutine join_copies(self, file, line, is_error, text, joined)
      class(problems_t), intent(inout) :: self
      character(len=*), intent(in) :: file               !! File and line
      integer, intent(in) :: line                        !! Line of the file
      logical, intent(in) :: is_error                    !! False: it is a warning
      character(len=*), intent(in) :: text               !! Text of the message
      logical, intent(out) :: joined                     !! False: it is a new entry
      character(len=:), allocatable :: label, rest
      integer :: i, which

      joined = .false.
      if (.not. allocated(self%repeated)) return
      call split_copy_message(self%repeated, text, which, label, rest)
      if (which == 0) return
      rest = label//without_numbers(rest)
      do i = 1, self%errors + self%warnings
         associate (entry => self%entries(i))
            if (.not. allocated(entry%common)) cycle
            if (entry%line /= line .or. (entry%is_error .neqv. is_error)) cycle
            if (entry%file /= file .or. entry%common /= rest) cycle
            entry%copies = entry%copies + 1
            joined = .true.
            return
         end associate
      end do
   end subroutine join_copies

   !> Split a message of a repeated body into the common label of its copies and the rest.
   pure subroutine split_copy_message(repeated, text, which, label, rest)
      type(repeated_t), intent(in) :: repeated(:)        !! Repeated bodies
      character(len=*), intent(in) :: text               !! A message
      integer, intent(out) :: which                      !! Index, 0 = none
      character(len=:), allocatable, intent(out) :: label !! Such as &body 'name'
      character(len=:), allocatable, intent(out) :: rest !! The message after the label
      character(len=9), parameter :: kinds(2) = ["&body '  ", "&region '"]
      character(len=:), allocatable :: name
      integer :: first, kind, last

      do kind = 1, size(kinds)
         first = len_trim(kinds(kind)) + 1
         if (index(text, trim(kinds(kind))) /= 1) cycle
         last = first + index(text(first:), "'") - 2
         name = text(first:last)
         rest = text(last + 1:)
         do which = 1, size(repeated)
            if (kind == 1) label = trim(kinds(kind))//repeated(which)%body
            if (kind == 2) label = trim(kinds(kind))//repeated(which)%region
            if (kind == 2 .and. name == repeated(which)%region) return
            if (is_copy(name, repeated(which)%body)) return
         end do
      end do
      which = 0
   end subroutine split_copy_message

   !> True for NAME_2, NAME_2_1 and so on.
   pure logical function is_copy(name, body) result(yes)
      character(len=*), intent(in) :: name               !! Name of a group
      character(len=*), intent(in) :: body               !! Name of the repeated body

      yes = index(name, body//"_") == 1
      if (yes) yes = verify(name(len(body) + 1:), "_0123456789") == 0
   end function is_copy

   !> A message with a placeholder for each number, so that those of copies can be compared.
   pure function without_numbers(text) result(words)
      character(len=*), intent(in) :: text               !! A message
      character(len=:), allocatable :: words
      integer :: i, last

      words = ""
      i = 1
      do while (i <= len(text))
         last = i
         if (scan(text(i:i), "0123456789") == 1) then
            last = verify(text(i:)//"&", "0123456789.eE+-") + i - 2
            words = words//"#"
         else if (text(i:i) /= "-") then
            words = words//text(i:i)
         end if
         i = last + 1
      end do
   end function without_numbers

   !> Text of an entry, with the number of copies.
   pure function entry_text(self, entry) result(text)
      class(problems_t), intent(in) :: self
      type(problem_t), intent(in) :: entry               !! One of its entries
      character(len=:), allocatable :: text, label, rest
      integer :: which

      text = entry%text
      if (entry%copies == 1) return
      call split_copy_message(self%repeated, text, which, label, rest)
      associate (all_copies => self%repeated(which)%copies)
         if (entry%copies == all_copies) then
            text = label//rest//" (all "//number(all_copies)//" copies)"
         else
            text = text//" (and "//number(entry%copies - 1)//" more among the "// &
               number(all_copies)//" copies)"
         end if
      end associate
   end function entry_text

   !> Append an entry.
   pure subroutine record_problem(self, file, line, is_error, text)
      class(problems_t), intent(inout) :: self           !! The list, with the new counts
      character(len=*), intent(in) :: file               !! File and line
      integer, intent(in) :: line                        !! Line of the file, 0 = none
      logical, intent(in) :: is_error                    !! False: it is a warning
      character(len=*), intent(in) :: text               !! Error and its remedy
      type(problem_t), allocatable :: longer(:)
      character(len=:), allocatable :: label, rest
      integer :: filled, i, which

      filled = self%errors + self%warnings
      if (.not. allocated(self%entries)) allocate (self%entries(16))
      if (filled > size(self%entries)) then
         allocate (longer(2*filled))
         do i = 1, filled - 1
            associate (from => self%entries(i), to => longer(i))
               call move_alloc(from%file, to%file)
               call move_alloc(from%text, to%text)
               if (allocated(from%common)) call move_alloc(from%common, to%common)
               to%copies = from%copies
               to%line = from%line
               to%is_error = from%is_error
            end associate
         end do
         call move_alloc(longer, self%entries)
      end if
      self%entries(filled)%file = file
      self%entries(filled)%line = line
      self%entries(filled)%is_error = is_error
      self%entries(filled)%text = text
      if (.not. allocated(self%repeated)) return
      call split_copy_message(self%repeated, text, which, label, rest)
      if (which > 0) self%entries(filled)%common = label//without_numbers(rest)
   end subroutine record_problem

   !> All errors and warnings, one a line, file by file in the order of the lines, and their count.
   function problems_report(self, files, groups) result(text)
      class(problems_t), intent(in) :: self
      type(text_t), intent(in) :: files(:)               !! The files in the order of reading
      integer, intent(in) :: groups                      !! Number of groups in them
      character(len=:), allocatable :: text
      type(buffer_t) :: buffer
      integer, allocatable :: order(:)
      integer :: i
      character(len=:), allocatable :: line

      call sort_problems(self, files, order)
      do i = 1, min(size(order), most_reported)
         line = entry_text(self, self%entries(order(i)))
         associate (problem => self%entries(order(i)))
            call buffer%add(problem%file//":")
            if (problem%line > 0) call buffer%add(number(problem%line)//":")
            if (problem%is_error) then
               call buffer%line(" error: "//code_last(line))
            else
               call buffer%line(" warning: "//code_last(line))
            end if
         end associate
      end do
      if (size(order) > most_reported) &
         call buffer%line("and "//number(size(order) - most_reported)//" more")
      call buffer%add(files(1)%text//": "//number(groups)//" groups, "//number(self%errors)// &
         " errors, "//number(self%warnings)//" warnings")
      text = buffer%content()
   end function problems_report

   !> Order of the entries: by file, then by line, then as found. Bottom-up merge sort.
   subroutine sort_problems(self, files, order)
      type(problems_t), intent(in) :: self
      type(text_t), intent(in) :: files(:)               !! The files in the order of reading
      integer, allocatable, intent(out) :: order(:)      !! Entries by position in the deck
      integer, allocatable :: merged(:), place(:)
      integer :: i, left, middle, run, right, total

      total = self%errors + self%warnings
      allocate (order(total), merged(total), place(total))
      do i = 1, total
         order(i) = i
         place(i) = place_of(self%entries(i)%file, files)
      end do
      run = 1
      do while (run < total)
         do left = 1, total, 2*run
            middle = min(left + run, total + 1)
            right = min(left + 2*run, total + 1)
            call merge_runs(self%entries, place, order, merged, [left, middle, right])
         end do
         order = merged
         run = 2*run
      end do
   end subroutine sort_problems

   !> Merge the sorted runs from bounds(1) to bounds(2) - 1 and from there to bounds(3) - 1.
   subroutine merge_runs(entries, place, order, merged, bounds)
      type(problem_t), intent(in) :: entries(:)          !! All entries
      integer, intent(in) :: place(:)                    !! Index of the file of each entry
      integer, intent(in) :: order(:)                    !! Entry by place, the runs sorted
      integer, intent(inout) :: merged(:)                !! The same, both runs sorted as one
      integer, intent(in) :: bounds(3)                   !! Bounds of the runs
      integer :: i, left, right
      logical :: take_right

      left = bounds(1)
      right = bounds(2)
      do i = bounds(1), bounds(3) - 1
         take_right = left >= bounds(2)
         if (.not. take_right .and. right < bounds(3)) then
            if (place(order(right)) /= place(order(left))) then
               take_right = place(order(right)) < place(order(left))
            else
               take_right = entries(order(right))%line < entries(order(left))%line
            end if
         end if
         if (take_right) then
            merged(i) = order(right)
            right = right + 1
         else
            merged(i) = order(left)
            left = left + 1
         end if
      end do
   end subroutine merge_runs

   !> Index of a file in the order of reading; texts that are not files come last.
   pure integer function place_of(file, files) result(place)
      character(len=*), intent(in) :: file               !! Name
      type(text_t), intent(in) :: files(:)               !! The files in the order of reading

      do place = 1, size(files)
         if (files(place)%text == file) return
      end do
   end function place_of
end module deck_problems
