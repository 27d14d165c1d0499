! SPDX-License-Identifier: BSD-3-Clause
!> Time histories and other tables as CSV: a heading with units, one or more rows per time,
!! truncated on restart. A column without a unit holds integers.
module io_history
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: int64, wp
   use base_text, only: buffer_t
   use base_units, only: output_units_t
   use io_file, only: file_exists, output_file_t, read_file, write_file
   use io_text, only: integer_text, real_text
   implicit none
   private

   public :: history_t

   character(len=*), parameter :: key = "step"           !! Column of integers
   integer, parameter :: unit_length = 16                !! Longest unit

   !> A file of histories. Rank 0 writes; the values must be the same on all ranks.
   type :: history_t
      integer, private :: key_place = 0                  !! Index of the column "step"
      logical, allocatable, private :: whole(:)          !! (column) Is it of integers?
      type(output_units_t) :: units                      !! Units of the columns
      real(wp), allocatable :: latest(:)                 !! (column) The last row of `row`, in SI
      character(len=unit_length), allocatable, private :: unit(:) !! (column) Unit of SI
      type(output_file_t), private :: file               !! Open on rank 0
   contains
      procedure :: open => history_open                  !! Creates or continues the file
      procedure :: row => history_row                    !! Write a row
      procedure :: rows => history_rows                  !! Write several rows of one time
      procedure :: close => history_close                !! Close
   end type history_t

contains

   !> Start a file, or continue that of a previous run. Collective.
   subroutine history_open(self, communicator, path, columns, resume_step, error)
      class(history_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path               !! Path
      character(len=*), intent(in) :: columns(:)         !! As "time [s]"; "step" holds the steps
      integer(int64), intent(in) :: resume_step          !! Later rows are cut away; < 0: all
      type(error_t), allocatable, intent(out) :: error   !! Cannot be written, or other columns
      character(len=:), allocatable :: heading
      integer :: bracket, column
      logical :: going_on

      self%key_place = 0
      if (allocated(self%whole)) deallocate (self%whole)
      if (allocated(self%unit)) deallocate (self%unit)
      allocate (self%whole(size(columns)), self%unit(size(columns)))
      heading = ""
      do column = 1, size(columns)
         if (columns(column) == key) self%key_place = column
         bracket = index(columns(column), "[")
         self%whole(column) = bracket == 0
         self%unit(column) = columns(column)(bracket + 1:len_trim(columns(column)) - 1)
         if (column > 1) heading = heading//","
         if (bracket == 0) then
            heading = heading//trim(columns(column))
         else
            heading = heading//columns(column)(:bracket)// &
               self%units%label(trim(self%unit(column)))//"]"
         end if
      end do
      if (communicator%rank == 0) then
         going_on = file_exists(path)
         if (resume_step >= 0 .and. going_on) then
            call cut_back(path, heading, self%key_place, resume_step, error)
            if (.not. allocated(error)) call self%file%append(path, error)
         else
            call self%file%create(path, error)
            if (.not. allocated(error)) call self%file%write(heading//new_line("a"), error)
         end if
      end if
      call agree(communicator, error)
   end subroutine history_open

   !> Remove the rows after a step, and an unfinished last line.
   subroutine cut_back(path, heading, key_place, resume_step, error)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: heading            !! Expected first line
      integer, intent(in) :: key_place                   !! Index of the column "step"
      integer(int64), intent(in) :: resume_step          !! Last step that is kept
      type(error_t), allocatable, intent(out) :: error   !! Another heading, or not writable
      character(len=:), allocatable :: text
      integer :: first, kept, length

      call read_file(path, text, error)
      if (allocated(error)) return
      length = index(text, new_line("a"))
      if (length == 0) length = len(text) + 1
      if (text(:length - 1) /= heading) then
         call fail(error, exit_file, "'"//path//"' has other columns than this run; "// &
            "rename it or choose another case name")
         return
      end if
      kept = length
      do
         first = kept + 1
         length = index(text(first:), new_line("a"))
         if (length == 0) exit
         if (step_of(text(first:first + length - 2), key_place) > resume_step) exit
         kept = kept + length
      end do
      call write_file(path, text(:kept), error)
   end subroutine cut_back

   !> The step of a row; a row that cannot be read is dropped.
   pure function step_of(line, key_place) result(step)
      character(len=*), intent(in) :: line               !! A row
      integer, intent(in) :: key_place                   !! Index of the column "step"
      integer(int64) :: step
      integer :: comma, first, place, status

      first = 1
      do place = 2, key_place
         comma = index(line(first:), ",")
         if (comma == 0) exit
         first = first + comma
      end do
      comma = index(line(first:)//",", ",")
      read (line(first:first + comma - 2), "(i20)", iostat=status) step
      if (status /= 0) step = huge(step)
   end function step_of

   !> Write a row, at once. Collective.
   subroutine history_row(self, communicator, values, error)
      class(history_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(in) :: values(:)                  !! (column)
      type(error_t), allocatable, intent(out) :: error   !! Not written, for example on a full disk

      self%latest = values
      if (communicator%rank == 0) &
         call self%file%write(line_of(self, values, 0)//new_line("a"), error)
      call agree(communicator, error)
   end subroutine history_row

   !> Write several rows with the same first columns in one call. Collective.
   subroutine history_rows(self, communicator, begin, values, error)
      class(history_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(in) :: begin(:)                   !! (column) First columns of all
      real(wp), intent(in) :: values(:, :)               !! (column behind them, row)
      type(error_t), allocatable, intent(out) :: error   !! Not written, for example on a full disk
      type(buffer_t) :: buffer
      character(len=:), allocatable :: front
      integer :: row

      if (communicator%rank == 0) then
         front = line_of(self, begin, 0)//","
         do row = 1, size(values, 2)
            call buffer%line(front//line_of(self, values(:, row), size(begin)))
         end do
         call self%file%write(buffer%content(), error)
      end if
      call agree(communicator, error)
   end subroutine history_rows

   !> Numbers with commas between them, in the units of the file.
   function line_of(self, values, before) result(line)
      class(history_t), intent(in) :: self
      real(wp), intent(in) :: values(:)                  !! (column)
      integer, intent(in) :: before                      !! Columns before the first
      character(len=:), allocatable :: line
      integer :: column

      line = ""
      do column = 1, size(values)
         if (column > 1) line = line//","
         if (self%whole(before + column)) then
            line = line//integer_text(nint(values(column), int64))
         else
            line = line//real_text(self%units%shown(values(column), &
               trim(self%unit(before + column))))
         end if
      end do
   end function line_of

   !> Close the file.
   subroutine history_close(self)
      class(history_t), intent(inout) :: self

      call self%file%close()
   end subroutine history_close
end module io_history
