! SPDX-License-Identifier: BSD-3-Clause
!> What is wrong with a deck: collected as it is found, told in the order of the lines.
module base_deck_problems
   use base_text, only: buffer_t, number, text_t
   implicit none
   private

   public :: problems_t

   !> Name of the file that stands for `--set`.
   character(len=*), parameter, public :: command_line = "command line"
   integer, parameter :: most_told = 200                 !! Longer reports are cut

   !> One error or warning.
   type :: problem_t
      character(len=:), allocatable :: file              !! Where it is
      integer :: line = 0                                !! Line of the file, 0 = none
      logical :: is_error = .true.                       !! Or else a warning
      character(len=:), allocatable :: text              !! What is wrong and what to do
   end type problem_t

   !> All errors and warnings of a deck.
   type :: problems_t
      integer :: errors = 0                              !! Number of errors
      integer :: warnings = 0                            !! Number of warnings
      type(problem_t), allocatable, private :: entries(:) !! As found; longer than what is in use
   contains
      procedure :: error => problems_error               !! Something that stops the run
      procedure :: warning => problems_warning           !! Something that looks wrong
      procedure :: report => problems_report             !! All as text, in the order of the lines
      procedure :: within => problems_within             !! An error in some lines of a file
      procedure :: about => problems_about               !! An error that belongs to no line
   end type problems_t

contains

   !> Note an error.
   pure subroutine problems_error(self, file, line, text)
      class(problems_t), intent(inout) :: self           !! The list
      character(len=*), intent(in) :: file               !! Where it is
      integer, intent(in) :: line                        !! Line of the file, 0 = none
      character(len=*), intent(in) :: text               !! What is wrong and what to do

      self%errors = self%errors + 1
      call note(self, file, line, .true., text)
   end subroutine problems_error

   !> Note a warning.
   pure subroutine problems_warning(self, file, line, text)
      class(problems_t), intent(inout) :: self           !! The list
      character(len=*), intent(in) :: file               !! Where it is
      integer, intent(in) :: line                        !! Line of the file, 0 = none
      character(len=*), intent(in) :: text               !! What is wrong and what to do

      self%warnings = self%warnings + 1
      call note(self, file, line, .false., text)
   end subroutine problems_warning

   !> True if there is an error in some lines of a file.
   pure logical function problems_within(self, file, first, last) result(found)
      class(problems_t), intent(in) :: self              !! The list
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

   !> True if there is an error that begins with a word and belongs to no line, as it came with the
   !! command line or is about what is missing.
   pure logical function problems_about(self, word) result(found)
      class(problems_t), intent(in) :: self              !! The list
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

   !> Append an entry.
   pure subroutine note(self, file, line, is_error, text)
      class(problems_t), intent(inout) :: self           !! The list; the counts are right already
      character(len=*), intent(in) :: file               !! Where it is
      integer, intent(in) :: line                        !! Line of the file, 0 = none
      logical, intent(in) :: is_error                    !! Or else a warning
      character(len=*), intent(in) :: text               !! What is wrong and what to do
      type(problem_t), allocatable :: longer(:)
      integer :: filled, i

      filled = self%errors + self%warnings
      if (.not. allocated(self%entries)) allocate (self%entries(16))
      if (filled > size(self%entries)) then
         allocate (longer(2*filled))
         do i = 1, filled - 1
            call move(self%entries(i), longer(i))
         end do
         call move_alloc(longer, self%entries)
      end if
      self%entries(filled)%file = file
      self%entries(filled)%line = line
      self%entries(filled)%is_error = is_error
      self%entries(filled)%text = text
   end subroutine note

   !> Hand an entry on.
   pure subroutine move(from, to)
      type(problem_t), intent(inout) :: from             !! Emptied
      type(problem_t), intent(inout) :: to               !! Filled

      call move_alloc(from%file, to%file)
      call move_alloc(from%text, to%text)
      to%line = from%line
      to%is_error = from%is_error
   end subroutine move

   !> All errors and warnings, one a line, file by file in the order of the lines, and their count.
   function problems_report(self, files, groups) result(text)
      class(problems_t), intent(in) :: self              !! The list
      type(text_t), intent(in) :: files(:)               !! The files in the order of reading
      integer, intent(in) :: groups                      !! Number of groups in them
      character(len=:), allocatable :: text
      type(buffer_t) :: buffer
      integer, allocatable :: order(:)
      integer :: i

      call sort(self, files, order)
      do i = 1, min(size(order), most_told)
         call tell(self%entries(order(i)), buffer)
      end do
      if (size(order) > most_told) &
         call buffer%line("and "//number(size(order) - most_told)//" more")
      call buffer%add(files(1)%text//": "//number(groups)//" groups, "//number(self%errors)// &
         " errors, "//number(self%warnings)//" warnings")
      text = buffer%content()
   end function problems_report

   !> One entry as a line.
   subroutine tell(problem, buffer)
      type(problem_t), intent(in) :: problem             !! The entry
      type(buffer_t), intent(inout) :: buffer            !! Where to append it

      call buffer%add(problem%file//":")
      if (problem%line > 0) call buffer%add(number(problem%line)//":")
      if (problem%is_error) then
         call buffer%line(" error: "//problem%text)
      else
         call buffer%line(" warning: "//problem%text)
      end if
   end subroutine tell

   !> Order of the entries: by file, then by line, then as found. Merges ever longer runs.
   subroutine sort(self, files, order)
      type(problems_t), intent(in) :: self               !! The list
      type(text_t), intent(in) :: files(:)               !! The files in the order of reading
      integer, allocatable, intent(out) :: order(:)      !! Entry by place
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
   end subroutine sort

   !> Merge the sorted runs from bounds(1) to bounds(2) - 1 and from there to bounds(3) - 1.
   subroutine merge_runs(entries, place, order, merged, bounds)
      type(problem_t), intent(in) :: entries(:)          !! All entries
      integer, intent(in) :: place(:)                    !! Place of the file of each entry
      integer, intent(in) :: order(:)                    !! Entry by place, the runs sorted
      integer, intent(inout) :: merged(:)                !! The same, both runs sorted as one
      integer, intent(in) :: bounds(3)                   !! Where the runs begin and end
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

   !> Place of a file in the order of reading; what is no file comes last.
   pure integer function place_of(file, files) result(place)
      character(len=*), intent(in) :: file               !! The file
      type(text_t), intent(in) :: files(:)               !! The files in the order of reading

      do place = 1, size(files)
         if (files(place)%text == file) return
      end do
   end function place_of
end module base_deck_problems
