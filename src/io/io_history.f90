! SPDX-License-Identifier: BSD-3-Clause
!> Time histories and other tables as CSV: a heading with units, one or more rows per time,
!! truncated on restart. A column without a unit holds integers.
module io_history
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_file, only: file_exists, output_file_t, read_file, write_file
   use base_kinds, only: int64, wp
   use base_text, only: buffer_t, exponent_text, number
   use deck_units, only: output_units_t
   use io_table_rows, only: add_to_mark, keep_rows, mark_size
   implicit none
   private

   public :: history_t

   integer, parameter :: unit_length = 16                !! Longest unit

   !> A file of histories. Rank 0 writes; the values must be the same on all ranks.
   type :: history_t
      integer(int64) :: wanted(mark_size) = 0            !! Content at the checkpoint, 0 = unknown
      character(len=:), allocatable :: lost              !! Rank 0: message on lost rows, or empty
      integer(int64), private :: mark(mark_size) = 0     !! Content on rank 0
      logical, allocatable, private :: whole(:)          !! (column) Is it of integers?
      type(output_units_t) :: units                      !! Units of the columns
      real(wp), allocatable :: latest(:)                 !! (column) The last row of `row`, in SI
      character(len=unit_length), allocatable, private :: unit(:) !! (column) Unit of SI
      type(output_file_t), private :: file               !! Open on rank 0
   contains
      procedure :: open => history_open                  !! Creates or continues the file
      procedure :: row => history_row                    !! Write a row
      procedure :: rows => history_rows                  !! Write several rows of one time
      procedure, private :: add => history_add           !! Write lines
      procedure :: save => history_save                  !! Wait for the disk
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

      self%mark = 0
      self%lost = ""
      if (allocated(self%whole)) deallocate (self%whole)
      if (allocated(self%unit)) deallocate (self%unit)
      allocate (self%whole(size(columns)), self%unit(size(columns)))
      heading = ""
      do column = 1, size(columns)
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
         if (resume_step >= 0) then
            call cut_back(self, path, heading, resume_step, error)
         else
            call self%file%create(path, error)
            if (.not. allocated(error)) call self%file%write(heading//new_line("a"), error)
            call add_to_mark(heading//new_line("a"), self%mark)
         end if
      end if
      call agree(communicator, error)
   end subroutine history_open

   !> Remove the rows after a step, and damaged ones.
   subroutine cut_back(self, path, heading, resume_step, error)
      class(history_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: heading            !! Expected first line
      integer(int64), intent(in) :: resume_step          !! Last step that is kept
      type(error_t), allocatable, intent(out) :: error   !! Another heading, or not writable
      character(len=:), allocatable :: kept, text
      logical :: matches

      text = ""
      if (file_exists(path)) call read_file(path, text, error)
      if (allocated(error)) return
      call keep_rows(path, text, heading, resume_step, self%wanted, kept, self%lost, matches)
      if (.not. matches) then
         call fail(error, exit_file, "'"//path//"' has other columns than this run; "// &
            "rename it or choose another case name [F120]")
         return
      end if
      call add_to_mark(kept, self%mark)
      call write_file(path, kept, error)
      if (.not. allocated(error)) call self%file%append(path, error)
   end subroutine cut_back

   !> Write lines at once. Collective.
   subroutine history_add(self, communicator, text, error)
      class(history_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: text               !! Rank 0: whole lines
      type(error_t), allocatable, intent(out) :: error   !! Not written, for example on a full disk

      if (communicator%rank == 0) then
         call self%file%write(text, error)
         if (.not. allocated(error)) call add_to_mark(text, self%mark)
      end if
      call agree(communicator, error)
   end subroutine history_add

   !> Wait until all rows are on disk, for a checkpoint. Collective.
   subroutine history_save(self, communicator, mark, error)
      class(history_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(out) :: mark(mark_size)     !! Content of the file, on all ranks
      type(error_t), allocatable, intent(out) :: error   !! Rows did not reach the disk

      mark = 0
      if (communicator%rank == 0) then
         mark = self%mark
         if (any(mark /= 0)) call self%file%sync(error)
      end if
      call agree(communicator, error)
      call communicator%total(mark)
   end subroutine history_save

   !> Write a row, at once. Collective.
   subroutine history_row(self, communicator, values, error)
      class(history_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(in) :: values(:)                  !! (column)
      type(error_t), allocatable, intent(out) :: error   !! Not written, for example on a full disk

      self%latest = values
      call self%add(communicator, line_of(self, values, 0)//new_line("a"), error)
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
      end if
      call self%add(communicator, buffer%content(), error)
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
            line = line//number(nint(values(column), int64))
         else
            line = line//exponent_text(self%units%shown(values(column), &
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
