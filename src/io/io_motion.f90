! SPDX-License-Identifier: BSD-3-Clause
!> Reads tables of velocities or accelerations: lines of a time and three components, separated by
!! commas or blanks.
module io_motion
   use base_decimal, only: file_numbers, without_commas
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: wp
   use base_text, only: line_end, number, shortened
   implicit none
   private

   public :: meaning_t, read_motion

   !> Contents of a table, for messages.
   type :: meaning_t
      character(len=36) :: fault                         !! Start of a message on a file
      character(len=16) :: columns                       !! Such as t, vx, vy, vz
   end type meaning_t

   type(meaning_t), parameter, public :: of_velocities = &
      meaning_t("cannot read the velocities of", "t, vx, vy, vz") !! Of walls
   type(meaning_t), parameter, public :: of_gravity = &
      meaning_t("cannot read the accelerations of", "t, gx, gy, gz") !! Of gravity_table
   integer, parameter :: columns = 4                     !! Time and three components
   integer, parameter :: shown = 40                      !! Characters of a wrong line in a message

contains

   !> Parse a table. Empty lines, lines that begin with # and a first line of words are
   !! skipped.
   subroutine read_motion(text, path, meaning, time, velocity, error)
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: path               !! For messages
      type(meaning_t), intent(in) :: meaning             !! For messages
      real(wp), allocatable, intent(out) :: time(:)      !! As written; unset on an error
      real(wp), allocatable, intent(out) :: velocity(:, :) !! (3, entry) As written
      type(error_t), allocatable, intent(out) :: error   !! A line is not valid
      character(len=:), allocatable :: line
      real(wp), allocatable :: entries_read(:, :)
      real(wp) :: values(columns)
      logical :: sound
      integer :: first, last, row, entries

      allocate (entries_read(columns, 1 + count([(text(first:first) == new_line("a"), &
         first=1, len(text))])))
      first = 1
      row = 0
      entries = 0
      do while (first <= len(text))
         last = line_end(text, first)
         line = without_commas(text(first:last))
         first = last + 2
         row = row + 1
         if (len_trim(line) == 0 .or. index(adjustl(line), "#") == 1) cycle
         call file_numbers(line, values, sound)
         if (.not. sound .and. entries == 0 .and. is_title(line)) cycle
         if (.not. sound) then
            call fail_reading(error, path, meaning, "line "//number(row)// &
               ": expected four numbers "//trim(meaning%columns)//", not '"// &
               shortened(trim(adjustl(line)), shown)//"'")
            return
         end if
         if (entries > 0) sound = values(1) > entries_read(1, max(entries, 1))
         if (.not. sound) then
            call fail_reading(error, path, meaning, "line "//number(row)// &
               ": times must ascend; t = "//number(values(1))//" follows "// &
               number(entries_read(1, entries)))
            return
         end if
         entries = entries + 1
         entries_read(:, entries) = values
      end do
      if (entries == 0) then
         call fail_reading(error, path, meaning, &
            "it holds no line of four numbers "//trim(meaning%columns))
         return
      end if
      time = entries_read(1, :entries)
      velocity = entries_read(2:, :entries)
   end subroutine read_motion

   !> Make the error message on a file.
   subroutine fail_reading(error, path, meaning, what)
      type(error_t), allocatable, intent(out) :: error
      character(len=*), intent(in) :: path
      type(meaning_t), intent(in) :: meaning             !! Contents of the table
      character(len=*), intent(in) :: what               !! Error message

      call fail(error, exit_file, trim(meaning%fault)//" '"//path//"': "//what//" [F118]")
   end subroutine fail_reading

   !> True if a line has column names: its first word begins with a letter.
   pure logical function is_title(line) result(title)
      character(len=*), intent(in) :: line               !! Not empty
      character(len=1) :: first

      first = adjustl(line)
      title = scan(first, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ") == 1
   end function is_title
end module io_motion
