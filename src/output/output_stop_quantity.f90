! SPDX-License-Identifier: BSD-3-Clause
!> The column of a table whose level ends a run (`stop_when = 'above'` and `'below'`). It is
!! compared whenever the table gets a row, so it costs nothing in other steps.
module output_stop_quantity
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: append, brief, closest, text_t
   use deck_reader, only: deck_t
   use io_state, only: state_t
   use output_stream, only: stream_holder_t
   use output_table_stream, only: heading_length, table_stream_t
   use scene_time, only: read_time_limits, time_limits_t
   implicit none
   private

   public :: stop_quantity_t

   character(len=*), parameter :: label = "stop_quantity_" !! Of the state in a checkpoint

   !> A column, its level, and its value in the last row.
   type :: stop_quantity_t
      character(len=:), allocatable :: name          !! As TABLE.COLUMN; empty without a criterion
      integer, private :: stream = 0                 !! Index of the table among the streams
      integer, private :: column = 0                 !! Index of the column
      type(time_limits_t), private :: limits         !! With the level
      real(wp), private :: value = 0.0_wp            !! In the last row
      integer(int64), private :: step = -1           !! Step of the last row
   contains
      procedure :: find => stop_quantity_find        !! Find the column
      procedure :: update => stop_quantity_update    !! Take the value of a new row
      procedure :: is_reached => stop_quantity_is_reached !! Compare with the level
      procedure :: reason => stop_quantity_reason    !! Why the run ended
      procedure :: save => stop_quantity_save        !! Into a checkpoint
      procedure :: load => stop_quantity_load        !! From a checkpoint
   end type stop_quantity_t

contains

   !> Find the column that the deck names.
   subroutine stop_quantity_find(self, deck, streams, case)
      class(stop_quantity_t), intent(out) :: self
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(stream_holder_t), intent(in) :: streams(:) !! All streams of the run
      character(len=*), intent(in) :: case           !! Beginning of the names of all files
      character(len=heading_length), allocatable :: headings(:)
      type(text_t), allocatable :: columns(:), tables(:)
      character(len=:), allocatable :: table
      integer :: dot, n

      call read_time_limits(deck, self%limits)
      self%name = self%limits%quantity
      if (self%name == "" .or. .not. deck%sound("output")) return
      dot = index(self%name, ".")
      table = self%name(:dot - 1)
      if (dot == 0) table = "history"
      allocate (columns(0), tables(0))
      do n = 1, size(streams)
         select type (stream => streams(n)%item)
         class is (table_stream_t)
            if (.not. stream%has_one_row()) cycle
            call append(tables, &
               stream%file(len(case) + 2:index(stream%file, ".csv", back=.true.) - 1))
            if (tables(size(tables))%text /= table) cycle
            self%stream = n
            call stream%list_columns(headings)
         end select
      end do
      if (self%stream == 0) then
         call deck%add_error("time", 1, "stop_quantity = '"//self%name// &
            "': this deck writes no table '"//table//"' with one row for each time; there are:"// &
            listed(tables, table)//" [D367]", "stop_quantity")
         return
      end if
      do n = 1, size(headings)
         call append(columns, trim(headings(n)(:scan(trim(headings(n))//" [", " [") - 1)))
         if (columns(n)%text == self%name(dot + 1:)) self%column = n
      end do
      if (self%column == 0) call deck%add_error("time", 1, "stop_quantity = '"//self%name// &
         "': the table '"//table//"' has no such column; there are:"// &
         listed(columns, self%name(dot + 1:))//" [D367]", "stop_quantity")
   end subroutine stop_quantity_find

   !> All names and the closest one, for a message.
   function listed(names, wanted) result(text)
      type(text_t), intent(in) :: names(:)
      character(len=*), intent(in) :: wanted         !! Name as in the deck
      character(len=:), allocatable :: near, text
      integer :: n

      text = ""
      do n = 1, size(names)
         text = text//" "//names(n)%text
      end do
      if (size(names) == 0) text = " none"
      near = closest(wanted, names)
      if (near /= "") text = text//"; did you mean '"//near//"'?"
   end function listed

   !> Take the value of the row that a stream has written.
   subroutine stop_quantity_update(self, streams, written, step)
      class(stop_quantity_t), intent(inout) :: self
      type(stream_holder_t), intent(in) :: streams(:) !! All streams of the run
      integer, intent(in) :: written                 !! Index of the stream
      integer(int64), intent(in) :: step             !! Present step

      if (written /= self%stream) return
      select type (stream => streams(written)%item)
      class is (table_stream_t)
         self%value = stream%table%latest(self%column)
         self%step = step
      end select
   end subroutine stop_quantity_update

   !> True if this step wrote a row, and its value is beyond the level.
   pure logical function stop_quantity_is_reached(self, step) result(is_reached)
      class(stop_quantity_t), intent(in) :: self
      integer(int64), intent(in) :: step             !! Present step

      is_reached = .false.
      if (self%stream == 0 .or. self%step /= step) return
      if (self%limits%above) then
         is_reached = self%value > self%limits%level
      else
         is_reached = self%value < self%limits%level
      end if
   end function stop_quantity_is_reached

   !> The reason for the end of the run.
   function stop_quantity_reason(self) result(text)
      class(stop_quantity_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = self%name//" = "//brief(self%value)//" is "//merge("above", "below", &
         self%limits%above)//" stop_level = "//brief(self%limits%level)
   end function stop_quantity_reason

   !> Put the last row into the state of a checkpoint, so that a restart of a run that has ended
   !! ends at once.
   subroutine stop_quantity_save(self, state)
      class(stop_quantity_t), intent(in) :: self
      type(state_t), intent(inout) :: state          !! State of the checkpoint

      if (self%stream > 0) call state%set(label//self%name, &
         [self%step, transfer(self%value, self%step)])
   end subroutine stop_quantity_save

   !> Restore the last row from the state of a checkpoint that has it.
   subroutine stop_quantity_load(self, state)
      class(stop_quantity_t), intent(inout) :: self
      type(state_t), intent(in) :: state             !! State of the checkpoint
      type(error_t), allocatable :: absent
      integer(int64), allocatable :: row(:)

      if (self%stream == 0) return
      call state%get(label//self%name, row, absent)
      if (allocated(absent)) return
      self%step = row(1)
      self%value = transfer(row(2), self%value)
   end subroutine stop_quantity_load
end module output_stop_quantity
