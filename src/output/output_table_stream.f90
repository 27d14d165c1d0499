! SPDX-License-Identifier: BSD-3-Clause
!> A stream that is one table, which grows by rows at each time.
module output_table_stream
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_reader, only: deck_t
   use io_history, only: history_t
   use io_snapshot, only: snapshot_header_t
   use io_table_rows, only: mark_size
   use output_stream, only: stream_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: table_stream_t

   integer, parameter, public :: heading_length = 100 !! Longest name of a column with its unit
   real(wp), parameter :: most_rows = 1.0e9_wp       !! A table with more needs --force

   !> A table.
   type, abstract, extends(stream_t) :: table_stream_t
      type(history_t) :: table
   contains
      procedure(list_columns_i), deferred :: list_columns !! Names of the columns with units
      procedure(write_rows_i), deferred :: write_rows !! Write the rows of the present time
      procedure :: rows_of_time => table_rows_of_time !! Expected rows of one time
      procedure :: has_one_row => table_has_one_row      !! One row for each time?
      procedure :: prepare => table_prepare          !! Before the rows of a time
      procedure :: open => table_open                !! Open the file
      procedure :: write => table_write              !! Write rows
      procedure :: close => table_close              !! Close the file
      procedure :: limit => table_limit              !! Refuse implausible sizes
      procedure :: list => table_list                !! For the summary
      procedure :: save_table => table_save_table    !! Content for a checkpoint
      procedure :: expect_table => table_expect_table !! Content at a checkpoint
   end type table_stream_t

   abstract interface
      !> Names of the columns with units, as "time [s]".
      subroutine list_columns_i(self, columns)
         import :: heading_length, table_stream_t
         implicit none
         class(table_stream_t), intent(in) :: self
         character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings
      end subroutine list_columns_i

      !> Write the rows of the present time. Collective.
      subroutine write_rows_i(self, simulation, error)
         import :: error_t, simulation_t, table_stream_t
         implicit none
         class(table_stream_t), intent(inout) :: self
         type(simulation_t), intent(inout) :: simulation
         type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      end subroutine write_rows_i
   end interface

contains

   !> Expected rows of one time. Most tables have one.
   pure real(wp) function table_rows_of_time(self) result(rows)
      class(table_stream_t), intent(in) :: self

      rows = 1.0_wp
   end function table_rows_of_time

   !> True if there is one row for each time, so that a column is a function of time.
   pure logical function table_has_one_row(self) result(has_one_row)
      class(table_stream_t), intent(in) :: self

      has_one_row = .true.
   end function table_has_one_row

   !> Prepare to write the rows of a time. By default nothing is done. Collective.
   subroutine table_prepare(self, simulation, note)
      class(table_stream_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      character(len=:), allocatable, intent(inout) :: note !! Lines for the log
   end subroutine table_prepare

   !> Open the file; after a restart without the rows that are later than the checkpoint.
   subroutine table_open(self, simulation, folder, header, restarted, note, error)
      class(table_stream_t), intent(inout) :: self
      type(simulation_t), intent(in) :: simulation   !! Ranks and present step
      character(len=*), intent(in) :: folder         !! Folder of the results
      type(snapshot_header_t), intent(in) :: header  !! Units of the columns
      logical, intent(in) :: restarted               !! Does the run continue from a checkpoint?
      character(len=:), allocatable, intent(out) :: note !! Rank 0: lost rows, or empty
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      character(len=heading_length), allocatable :: columns(:)

      self%table%units = header%units
      call self%list_columns(columns)
      call self%table%open(simulation%machine%communicator, folder//"/"//self%file, &
         columns, merge(simulation%clock%step, -1_int64, restarted), error)
      note = self%table%lost
   end subroutine table_open

   !> Write the rows of the present time. Collective.
   subroutine table_write(self, simulation, header, note, error)
      class(table_stream_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(snapshot_header_t), intent(in) :: header  !! Unused
      character(len=:), allocatable, intent(inout) :: note !! Lines for the log
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written

      call simulation%machine%timer%start(simulation%machine%phase%ledger)
      call self%prepare(simulation, note)
      call self%write_rows(simulation, error)
      call simulation%machine%timer%stop(simulation%machine%phase%ledger)
   end subroutine table_write

   !> Close the file.
   subroutine table_close(self, communicator, error)
      class(table_stream_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator !! Unused
      type(error_t), allocatable, intent(out) :: error !! Never set

      call self%table%close()
   end subroutine table_close

   !> Wait until all rows are on disk, for a checkpoint. Collective.
   subroutine table_save_table(self, communicator, mark, error)
      class(table_stream_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      integer(int64), allocatable, intent(out) :: mark(:) !! Content of the table
      type(error_t), allocatable, intent(out) :: error !! Rows did not reach the disk

      allocate (mark(mark_size))
      call self%table%save(communicator, mark, error)
   end subroutine table_save_table

   !> Set the content of the table at the checkpoint from which the run continues.
   pure subroutine table_expect_table(self, mark)
      class(table_stream_t), intent(inout) :: self
      integer(int64), intent(in) :: mark(:)          !! From table_save_table

      if (size(mark) == mark_size) self%table%wanted = mark
   end subroutine table_expect_table

   !> Refuse implausible sizes.
   subroutine table_limit(self, deck, particles, time_end, steps)
      class(table_stream_t), intent(in) :: self
      type(deck_t), intent(inout) :: deck            !! Collects errors
      integer(int64), intent(in) :: particles        !! Unused
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Expected number of steps
      real(wp) :: rows

      rows = self%schedule%expected(time_end, steps)*self%rows_of_time()
      if (self%place == 0 .or. rows <= most_rows) return
      call deck%add_error("output", self%place, "would write "//brief(rows)// &
         " rows; write less often, or continue with --force [D437]")
   end subroutine table_limit

   !> Entry of the stream in the summary: its kind, as in the name of its file.
   pure subroutine table_list(self, key, file)
      class(table_stream_t), intent(in) :: self
      character(len=:), allocatable, intent(out) :: key !! Such as gauge of _gauge.csv
      character(len=:), allocatable, intent(out) :: file !! Path of the table

      key = self%ending()
      key = key(2:index(key, ".") - 1)
      file = self%file
   end subroutine table_list
end module output_table_stream
