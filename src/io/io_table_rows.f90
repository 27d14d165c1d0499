! SPDX-License-Identifier: BSD-3-Clause
!> Rows of a table that a restart keeps. A file that is not the one that was written before the
!! checkpoint has lost rows, or has damaged ones: those that can be read are kept.
module io_table_rows
   use base_hash, only: add_hash, hash_text, mix
   use base_kinds, only: int64
   use base_text, only: buffer_t, number
   implicit none
   private

   public :: add_to_mark, intact_bytes, keep_rows

   !> Content of a table: bytes, lines, hash of the lines, hash of the heading
   integer, parameter, public :: mark_size = 4
   integer, parameter :: bytes = 1, lines = 2, hash = 3, heading_hash = 4
   integer, parameter :: listed_gaps = 3                 !! Gaps that a message lists
   character(len=*), parameter :: of_rows = "0123456789+-.E,NaInfity"

   !> A line of a file.
   type :: line_t
      integer :: first = 1                               !! Its first letter
      integer :: last = 0                                !! Its last one, without the end of line
      integer(int64) :: step = -1                        !! Step of a row, -1: it cannot be read
   end type line_t

contains

   !> Add lines to the mark of a table.
   pure subroutine add_to_mark(text, mark)
      character(len=*), intent(in) :: text               !! Whole lines
      integer(int64), intent(inout) :: mark(mark_size)   !! Content so far
      integer :: first, length

      first = 1
      do
         length = index(text(first:), new_line("a"))
         if (length == 0) return
         mark(hash) = mix(add_hash(mark(hash), hash_text(text(first:first + length - 2))))
         if (mark(lines) == 0) mark(heading_hash) = mark(hash)
         mark(lines) = mark(lines) + 1
         mark(bytes) = mark(bytes) + length
         first = first + length
      end do
   end subroutine add_to_mark

   !> Bytes of a file that are the table of a mark, 0: the file has lost or damaged lines.
   pure integer function intact_bytes(text, wanted) result(length)
      character(len=*), intent(in) :: text               !! Content of the file
      integer(int64), intent(in) :: wanted(mark_size)    !! Mark of the table
      integer(int64) :: mark(mark_size)

      length = 0
      if (len(text) < wanted(bytes)) return
      mark = 0
      call add_to_mark(text(:wanted(bytes)), mark)
      if (all(mark == wanted)) length = int(wanted(bytes))
   end function intact_bytes

   !> Find the rows to keep, up to a step.
   subroutine keep_rows(path, text, heading, resume_step, wanted, kept, lost, matches)
      character(len=*), intent(in) :: path               !! For the message
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: heading            !! Expected first line
      integer(int64), intent(in) :: resume_step          !! Last step that is kept
      integer(int64), intent(in) :: wanted(mark_size)    !! Mark at the checkpoint, 0 = unknown
      character(len=:), allocatable, intent(out) :: kept !! Heading and rows
      character(len=:), allocatable, intent(out) :: lost !! Message on lost rows, or empty
      logical, intent(out) :: matches                    !! Has the file the columns of this run?
      type(line_t), allocatable :: rows(:)
      type(buffer_t) :: buffer
      integer(int64) :: mark(mark_size)
      integer :: n, taken
      logical :: known

      lost = ""
      mark = 0
      call add_to_mark(heading//new_line("a"), mark)
      ! of a table that had other columns at the checkpoint nothing is known
      known = wanted(lines) > 0 .and. mark(heading_hash) == wanted(heading_hash)
      matches = known .or. len(text) == 0 .or. index(text, heading//new_line("a")) == 1
      n = 0
      if (known) n = intact_bytes(text, wanted)
      kept = text(:n)
      if (n > 0 .or. .not. matches) return
      call find_rows(text, heading, resume_step, rows)
      if (known) call drop_partial_times(int(wanted(lines)) - 1, rows)
      call buffer%line(heading)
      taken = 0
      do n = 1, size(rows)
         if (rows(n)%step < 0) cycle
         taken = taken + 1
         ! the row of the step of the checkpoint can have been written after it
         if (known .and. taken >= wanted(lines)) exit
         call buffer%line(text(rows(n)%first:rows(n)%last))
      end do
      kept = buffer%content()
      if (known) lost = loss_text(path, text, heading, rows, int(wanted(lines)) - 1)
   end subroutine keep_rows

   !> Find the lines after the heading. Rows after a step, and such that are less than the step of a
   !! row before them, count as unreadable.
   subroutine find_rows(text, heading, resume_step, rows)
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: heading            !! For the columns
      integer(int64), intent(in) :: resume_step          !! Last step that is kept
      type(line_t), allocatable, intent(out) :: rows(:)  !! In the order of the file
      integer(int64) :: step
      integer :: count, first, length, pass

      do pass = 1, 2
         count = 0
         step = 0
         first = index(text, new_line("a")) + 1
         do
            length = index(text(first:), new_line("a"))
            if (length == 0) exit
            count = count + 1
            if (pass == 2) then
               rows(count)%first = first
               rows(count)%last = first + length - 2
               if (rows(count)%last >= first) then
                  ! an editor of another system may have changed the ends of lines
                  if (text(rows(count)%last:rows(count)%last) == achar(13)) &
                     rows(count)%last = rows(count)%last - 1
               end if
               rows(count)%step = step_of(text(first:rows(count)%last), heading)
               if (rows(count)%step < step .or. rows(count)%step > resume_step) &
                  rows(count)%step = -1
               step = max(step, rows(count)%step)
            end if
            first = first + length
         end do
         if (pass == 1) allocate (rows(count))
      end do
   end subroutine find_rows

   !> Drop the readable rows of a time that may have lost others: of a time beside lost rows that
   !! has fewer rows than another time.
   subroutine drop_partial_times(wanted, rows)
      integer, intent(in) :: wanted                      !! Rows at the checkpoint
      type(line_t), intent(inout) :: rows(:)             !! In the order of the file
      integer :: alike, most, n
      logical :: read(size(rows))

      read = rows%step >= 0
      if (count(read) >= wanted .or. count(read) == 0) return
      most = 1
      alike = 1
      do n = 2, size(rows)
         alike = merge(alike + 1, 1, read(n) .and. rows(n)%step == rows(n - 1)%step)
         most = max(most, alike)
      end do
      do n = 2, size(rows)
         if (read(n) .and. .not. read(n - 1)) call drop_time(rows(n)%step)
         if (read(n - 1) .and. .not. read(n)) call drop_time(rows(n - 1)%step)
      end do
      if (read(size(rows))) call drop_time(rows(size(rows))%step)

   contains

      !> Drop the rows of a step.
      subroutine drop_time(step)
         integer(int64), value, intent(in) :: step

         if (step < 0 .or. count(rows%step == step) == most) return
         where (rows%step == step) rows%step = -1
      end subroutine drop_time
   end subroutine drop_partial_times

   !> The step of a row, -1: it is damaged.
   pure function step_of(line, heading) result(step)
      character(len=*), intent(in) :: line               !! A row
      character(len=*), intent(in) :: heading            !! Names of the columns
      integer(int64) :: step
      character(len=:), allocatable :: digits
      integer :: status

      step = -1
      if (verify(line, of_rows) > 0) return
      if (commas(line) /= commas(heading)) return
      digits = cell(line, column_of(heading, "step"))
      read (digits, "(i20)", iostat=status) step
      if (status /= 0) step = -1
   end function step_of

   !> Number of commas.
   pure integer function commas(line) result(count)
      character(len=*), intent(in) :: line
      integer :: n

      count = 0
      do n = 1, len(line)
         if (line(n:n) == ",") count = count + 1
      end do
   end function commas

   !> Index of the column whose heading begins with a word, 1 if there is none.
   pure integer function column_of(heading, word) result(column)
      character(len=*), intent(in) :: heading
      character(len=*), intent(in) :: word

      column = index(","//heading, ","//word)
      column = 1 + commas(heading(:max(column - 1, 0)))
   end function column_of

   !> A cell of a row.
   pure function cell(line, column) result(text)
      character(len=*), intent(in) :: line
      integer, intent(in) :: column
      character(len=:), allocatable :: text
      integer :: comma, first, place

      first = 1
      do place = 2, column
         first = first + index(line(first:), ",")
      end do
      comma = index(line(first:)//",", ",")
      text = line(first:first + comma - 2)
   end function cell

   !> Message on lost or changed rows.
   function loss_text(path, text, heading, rows, wanted) result(message)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: heading
      type(line_t), intent(in) :: rows(:)
      integer, intent(in) :: wanted                      !! Rows at the checkpoint
      character(len=:), allocatable :: message
      character(len=:), allocatable :: before, gaps
      integer :: gap, kept, n
      logical :: open

      kept = count(rows%step >= 0)
      if (kept >= wanted) then
         message = "warning: rows of '"//path//"' are not those that were written: the file "// &
            "was changed or damaged since; the run continues [F126]"//new_line("a")
         return
      end if
      gaps = ""
      gap = 0
      before = "the start of the table"
      open = .false.
      do n = 1, size(rows)
         if (rows(n)%step < 0) then
            open = .true.
            cycle
         end if
         if (open) call add_gap(time_of(n))
         before = time_of(n)
         open = .false.
      end do
      if (open .or. gap == 0) call add_gap("the checkpoint")
      if (gap > listed_gaps) gaps = gaps//" and in "//number(gap - listed_gaps)//" other intervals"
      message = "warning: '"//path//"' has lost "//number(wanted - kept)//" of "// &
         number(wanted)//" rows"//gaps//": the file was damaged or cut after it was written; "// &
         "the run continues [F126]"//new_line("a")

   contains

      !> Time of a row.
      function time_of(row) result(time)
         integer, intent(in) :: row
         character(len=:), allocatable :: time
         integer :: column

         column = column_of(heading, "time")
         time = cell(heading, column)//" = "//cell(text(rows(row)%first:rows(row)%last), column)
      end function time_of

      !> List a gap.
      subroutine add_gap(after)
         character(len=*), intent(in) :: after

         gap = gap + 1
         if (gap > listed_gaps) return
         if (gap > 1) gaps = gaps//","
         gaps = gaps//" between "//before//" and "//after
      end subroutine add_gap
   end function loss_text
end module io_table_rows
