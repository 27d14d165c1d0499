! SPDX-License-Identifier: BSD-3-Clause
!> Files of a run of a cell of grains: history, snapshots of grains and contacts, moduli.
module grains_output
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use grains_cell, only: cell_t, interval_means_t
   use grains_measures, only: history_columns, history_values
   use grains_path, only: path_t
   use grains_probe, only: probe_cell, probe_columns
   use grains_snapshot, only: write_contacts, write_grains
   use io_history, only: history_t
   use io_series, only: series_t
   use io_snapshot, only: snapshot_header_t
   use io_state, only: state_t
   use io_table_rows, only: mark_size
   implicit none
   private

   public :: grains_output_t

   !> The files.
   type :: grains_output_t
      character(len=:), allocatable :: folder
      character(len=:), allocatable :: case          !! Prefix of all files
      type(snapshot_header_t) :: header              !! Provenance and units
      real(wp) :: energy_at_start = 0.0_wp           !! [J]
      integer :: snapshots = 0                       !! Written so far
      type(history_t), private :: history
      type(history_t), private :: moduli
      logical, private :: has_moduli = .false.
      type(series_t), private :: grains
      type(series_t), private :: contacts
   contains
      procedure :: open => output_open               !! Create or continue the files
      procedure :: row => output_row                 !! Write a row of the history
      procedure :: snapshot => output_snapshot       !! Write grains and contacts
      procedure :: probe => output_probe             !! Measure and write moduli
      procedure :: close => output_close             !! Complete the files
      procedure :: save => output_save               !! Content of tables for a checkpoint
      procedure :: load => output_load               !! Content of tables at a checkpoint
   end type grains_output_t

contains

   !> Create the files, or continue those of a previous run. Collective.
   subroutine output_open(self, cell, path, restarts, note, error)
      class(grains_output_t), intent(inout) :: self
      type(cell_t), intent(in) :: cell
      type(path_t), intent(in) :: path
      logical, intent(in) :: restarts                !! Restart from a checkpoint?
      character(len=:), allocatable, intent(out) :: note !! Snapshots that cannot be read, or empty
      type(error_t), allocatable, intent(out) :: error
      character(len=:), allocatable :: stem, more
      integer(int64) :: resume_step

      stem = self%folder//"/"//self%case
      resume_step = -1
      if (restarts) resume_step = cell%step
      self%history%units = self%header%units
      call self%history%open(cell%communicator, stem//"_history.csv", history_columns(), &
         resume_step, error)
      if (allocated(error)) return
      self%has_moduli = any(path%stages%probe)
      if (self%has_moduli) then
         self%moduli%units = self%header%units
         call self%moduli%open(cell%communicator, stem//"_moduli.csv", probe_columns(), &
            resume_step, error)
         if (allocated(error)) return
      end if
      call self%grains%open(cell%communicator, self%folder, self%case//"_grains", &
         self%snapshots, note, error)
      if (allocated(error)) return
      ! an index of a series is written for particles only, and contacts are lines
      self%contacts%of_grids = .true.
      call self%contacts%open(cell%communicator, self%folder, self%case//"_contacts", &
         self%snapshots, more, error)
      if (allocated(error)) return
      note = self%history%lost//note//more
      if (self%has_moduli) note = self%moduli%lost//note
   end subroutine output_open

   !> Wait until all rows are on disk and record the content of the tables. Collective.
   subroutine output_save(self, cell, state, error)
      class(grains_output_t), intent(in) :: self
      type(cell_t), intent(in) :: cell
      type(state_t), intent(inout) :: state
      type(error_t), allocatable, intent(out) :: error !! Rows did not reach the disk
      integer(int64) :: mark(mark_size)

      call self%history%save(cell%communicator, mark, error)
      if (allocated(error)) return
      call state%set("table_history", mark)
      if (.not. self%has_moduli) return
      call self%moduli%save(cell%communicator, mark, error)
      if (.not. allocated(error)) call state%set("table_moduli", mark)
   end subroutine output_save

   !> Set the content of the tables at the checkpoint from which the run continues.
   subroutine output_load(self, state)
      class(grains_output_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      integer(int64), allocatable :: mark(:)
      type(error_t), allocatable :: error

      call state%get("table_history", mark, error)
      if (.not. allocated(error)) self%history%wanted = mark
      call state%get("table_moduli", mark, error)
      if (.not. allocated(error)) self%moduli%wanted = mark
   end subroutine output_load

   !> Write a row of the history, and begin new means. Collective.
   subroutine output_row(self, cell, stage, error)
      class(grains_output_t), intent(inout) :: self
      type(cell_t), intent(inout) :: cell
      integer, intent(in) :: stage                   !! Number
      type(error_t), allocatable, intent(out) :: error
      real(wp), allocatable :: values(:)

      call history_values(cell, stage, self%energy_at_start, values)
      call self%history%row(cell%communicator, values, error)
      cell%mean = interval_means_t()
   end subroutine output_row

   !> Write the grains and the contacts. Collective.
   subroutine output_snapshot(self, cell, error)
      class(grains_output_t), intent(inout) :: self
      type(cell_t), intent(inout) :: cell
      type(error_t), allocatable, intent(out) :: error

      self%header%time = cell%time
      self%header%step = cell%step
      self%header%dt = cell%dt
      self%header%dt_next = cell%dt
      call write_grains(cell, self%grains%path(self%snapshots), self%header, error)
      if (.not. allocated(error)) call self%grains%add(cell%communicator, &
         self%grains%path(self%snapshots), error)
      if (.not. allocated(error)) call write_contacts(cell, self%contacts%path(self%snapshots), &
         self%header, error)
      if (.not. allocated(error)) call self%contacts%add(cell%communicator, &
         self%contacts%path(self%snapshots), error)
      self%snapshots = self%snapshots + 1
   end subroutine output_snapshot

   !> Measure the elastic moduli of the state and write them. Collective.
   subroutine output_probe(self, cell, stage, error)
      class(grains_output_t), intent(inout) :: self
      type(cell_t), intent(in) :: cell
      integer, intent(in) :: stage                   !! Number
      type(error_t), allocatable, intent(out) :: error
      real(wp), allocatable :: rows(:, :)
      integer :: row

      call probe_cell(cell, rows)
      do row = 1, size(rows, 2)
         call self%moduli%row(cell%communicator, [real(cell%step, wp), real(stage, wp), &
            cell%time, rows(:, row)], error)
         if (allocated(error)) return
      end do
   end subroutine output_probe

   !> Complete the files. Collective.
   subroutine output_close(self, cell, error)
      class(grains_output_t), intent(inout) :: self
      type(cell_t), intent(in) :: cell
      type(error_t), allocatable, intent(out) :: error

      call self%history%close()
      if (self%has_moduli) call self%moduli%close()
      call self%grains%close(cell%communicator, error)
      if (.not. allocated(error)) call self%contacts%close(cell%communicator, error)
   end subroutine output_close
end module grains_output
