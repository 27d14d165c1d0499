! SPDX-License-Identifier: BSD-3-Clause
!> The streams of files that a run writes: snapshots of particles and histories.
module output_streams
   use base_communicator, only: communicator_t
   use base_deck, only: deck_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: brief, size_text
   use io_fragments, only: fragment_columns, fragment_labels, fragment_rows, labels_t
   use io_grid, only: grid_write
   use io_profile, only: profile_columns, profile_rows
   use io_snapshot, only: snapshot_header_t, snapshot_write
   use io_state, only: state_t
   use io_stream_names, only: of_bins, of_cells, of_fragments, of_particles
   use output_history, only: choose_history, heading_length, history_row
   use output_stream_deck, only: plan_streams, snapshots_t, tables_t
   use scene_shapes, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: outputs_t

   real(wp), parameter, public :: snapshot_bytes = 60.0_wp !! Default fields, compressed
   real(wp), parameter :: most_bytes = 1.0e12_wp     !! A stream with more needs --force
   real(wp), parameter :: most_files = 1.0e6_wp      !! The same for its files
   real(wp), parameter :: most_rows = 1.0e9_wp       !! The same for rows of a table
   real(wp), parameter :: most_cells = 1.0e9_wp      !! The same for cells of a file
   real(wp), parameter :: cell_bytes = 0.5_wp        !! A number of a cell, most of them empty

   !> All streams of a run.
   type :: outputs_t
      character(len=:), allocatable :: folder        !! Where results go
      character(len=:), allocatable :: case          !! Prefix of all files
      type(snapshots_t), allocatable :: snapshots(:) !! Streams of particles and grids
      type(tables_t), allocatable :: tables(:)       !! Histories, profiles, fragments
      type(snapshot_header_t) :: header              !! What every snapshot says of the run
   contains
      procedure :: plan => outputs_plan              !! Read the streams from the deck
      procedure :: limit => outputs_limit            !! Refuse sizes that are hardly meant
      procedure :: open => outputs_open              !! Open files, new or after a restart
      procedure :: write_due => outputs_write_due    !! Write what is due
      procedure :: expected => outputs_expected      !! Snapshots that will be written
      procedure :: rows => outputs_rows              !! Rows of histories that will be written
      procedure :: close => outputs_close            !! Close files
      procedure :: save => outputs_save              !! Counters into a checkpoint
      procedure :: load => outputs_load              !! Counters from a checkpoint
   end type outputs_t

contains

   !> Read the streams. Without any, a run still keeps a history and its first and last state.
   subroutine outputs_plan(self, deck, simulation, shapes, time_end)
      class(outputs_t), intent(inout) :: self        !! The streams; folder and case are set
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! With fields, for the names; not changed
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      real(wp), intent(in) :: time_end               !! End of the run [s]
      type(error_t), allocatable :: error

      call plan_streams(deck, simulation, shapes, time_end, self%case, self%snapshots, &
         self%tables)
      if (size(self%snapshots) + size(self%tables) > 0) return
      deallocate (self%snapshots, self%tables)
      allocate (self%snapshots(1), self%tables(1))
      self%snapshots(1)%prefix = self%case//"_p"
      self%snapshots(1)%fields = [character(len=64) :: "default"]
      self%snapshots(1)%schedule%interval = time_end
      self%tables(1)%name = self%case//"_history.csv"
      self%tables(1)%schedule%interval = time_end/100.0_wp
      call choose_history(["default"], allocated(simulation%effects%exact), simulation%space%grid, &
         allocated(simulation%effects%gravity), self%tables(1)%columns, error)
   end subroutine outputs_plan

   !> Open the streams; after a restart what was written later than the checkpoint is cut away.
   subroutine outputs_open(self, simulation, restarted, note, error)
      class(outputs_t), intent(inout) :: self        !! The streams
      type(simulation_t), intent(inout) :: simulation !! The run
      logical, intent(in) :: restarted               !! Does the run go on from a checkpoint?
      character(len=:), allocatable, intent(out) :: note !! Snapshots left out, or empty
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      character(len=:), allocatable :: left_out
      integer :: n

      note = ""
      do n = 1, size(self%snapshots)
         self%snapshots(n)%series%of_grids = self%snapshots(n)%kind == of_cells
         call self%snapshots(n)%series%open(simulation%machine%communicator, self%folder, &
            self%snapshots(n)%prefix, self%snapshots(n)%next, left_out, error)
         if (allocated(error)) return
         note = note//left_out
      end do
      do n = 1, size(self%tables)
         self%tables(n)%file%units = self%header%units
         call self%tables(n)%file%open(simulation%machine%communicator, &
            self%folder//"/"//self%tables(n)%name, headings(self%tables(n)), &
            merge(simulation%clock%step, -1_int64, restarted), error)
         if (allocated(error)) return
      end do
   end subroutine outputs_open

   !> Headings of the columns of a table.
   function headings(table) result(columns)
      type(tables_t), intent(in) :: table            !! Which one
      character(len=heading_length), allocatable :: columns(:)

      select case (table%kind)
      case (of_bins)
         columns = profile_columns(table%profile)
      case (of_fragments)
         columns = fragment_columns()
      case default
         columns = table%columns%headings()
      end select
   end function headings

   !> Write what is due. With `last` every stream writes the final state, once.
   subroutine outputs_write_due(self, simulation, last, note, error)
      class(outputs_t), intent(inout) :: self        !! The streams
      type(simulation_t), intent(inout) :: simulation !! The run
      logical, intent(in) :: last                    !! Is this the final state?
      character(len=:), allocatable, intent(out) :: note !! What the log should say
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      logical :: due
      integer :: n

      note = ""
      do n = 1, size(self%tables)
         associate (stream => self%tables(n))
            due = stream%schedule%due(simulation%clock%step, simulation%clock%time)
            if (.not. (due .or. last) .or. stream%last_step == simulation%clock%step) cycle
            call simulation%machine%timer%start(simulation%machine%phase%ledger)
            call write_rows(stream, simulation, error)
            call simulation%machine%timer%stop(simulation%machine%phase%ledger)
            if (allocated(error)) return
            stream%last_step = simulation%clock%step
         end associate
      end do
      do n = 1, size(self%snapshots)
         associate (stream => self%snapshots(n))
            due = stream%schedule%due(simulation%clock%step, simulation%clock%time)
            if (.not. (due .or. last) .or. stream%last_step == simulation%clock%step) cycle
            call simulation%machine%timer%start(simulation%machine%phase%output)
            call write_snapshot(self, stream, simulation, note, error)
            call simulation%machine%timer%stop(simulation%machine%phase%output)
            if (allocated(error)) return
         end associate
      end do
   end subroutine outputs_write_due

   !> Write the rows of a table for this time.
   subroutine write_rows(stream, simulation, error)
      type(tables_t), intent(inout) :: stream        !! The table
      type(simulation_t), intent(inout) :: simulation !! The run
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      real(wp), allocatable :: row(:), rows(:, :)

      select case (stream%kind)
      case (of_bins)
         call profile_rows(simulation%machine%communicator, simulation%space%grid, &
            simulation%stores, &
            stream%profile, rows)
      case (of_fragments)
         call fragment_rows(simulation%machine%communicator, simulation%space%grid, &
            simulation%space%tiles%coordinate(:, :simulation%space%tiles%own), simulation%stores, &
            stream%fragments, rows)
      case default
         call history_row(simulation, stream%columns, row)
         call stream%file%row(simulation%machine%communicator, row, error)
         return
      end select
      call stream%file%rows(simulation%machine%communicator, [simulation%clock%time, &
         real(simulation%clock%step, &
         wp)], rows, error)
   end subroutine write_rows

   !> Write one snapshot and bring the index files up to date.
   subroutine write_snapshot(self, stream, simulation, note, error)
      class(outputs_t), intent(inout) :: self        !! For the header
      type(snapshots_t), intent(inout) :: stream     !! The stream
      type(simulation_t), intent(inout) :: simulation !! The run
      character(len=:), allocatable, intent(inout) :: note !! What the log should say
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      type(labels_t), allocatable :: labels(:)
      character(len=:), allocatable :: path
      character(len=16) :: text

      self%header%time = simulation%clock%time
      self%header%dt = simulation%clock%dt
      self%header%dt_next = simulation%clock%dt_next
      self%header%velocity_lag = simulation%scheme%method%lag(simulation%clock%dt)
      self%header%step = simulation%clock%step
      path = stream%series%path(stream%next)
      if (stream%kind == of_cells) then
         call grid_write(simulation%machine%communicator, path, simulation%space%grid, &
            simulation%space%tiles%coordinate(:, :simulation%space%tiles%own), simulation%stores, &
            stream%means, stream%format, self%header, error)
      else
         if (any(stream%fields == "fragment")) call &
            fragment_labels(simulation%machine%communicator, &
            simulation%space%grid, simulation%space%tiles%coordinate(:, &
               :simulation%space%tiles%own), &
            simulation%stores, stream%fragments, labels)
         call snapshot_write(simulation%machine%communicator, path, simulation%stores, &
            stream%fields, &
            stream%format, self%header, error, labels)
      end if
      if (allocated(error)) return
      call stream%series%add(simulation%machine%communicator, path, error)
      if (allocated(error)) return
      stream%next = stream%next + 1
      stream%last_step = simulation%clock%step
      write (text, "(es12.5)") simulation%clock%time
      if (len(note) > 0) note = note//new_line("a")
      note = note//"  wrote "//path(index(path, "/", back=.true.) + 1:)//"  t = "// &
         trim(adjustl(text))//" s"
   end subroutine write_snapshot

   !> Snapshots that the run will write, as far as that is known before it.
   pure integer(int64) function outputs_expected(self, time_end) result(number)
      class(outputs_t), intent(in) :: self           !! The streams
      real(wp), intent(in) :: time_end               !! End of the run [s]
      integer :: n

      number = 0
      do n = 1, size(self%snapshots)
         if (self%snapshots(n)%kind == of_particles) &
            number = number + int(self%snapshots(n)%schedule%expected(time_end, 0.0_wp), int64)
      end do
   end function outputs_expected

   !> Rows of histories that the run will write.
   pure real(wp) function outputs_rows(self, time_end, steps) result(rows)
      class(outputs_t), intent(in) :: self           !! The streams
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Steps that it will take
      integer :: n

      rows = 0.0_wp
      do n = 1, size(self%tables)
         if (self%tables(n)%kind == of_bins .or. self%tables(n)%kind == of_fragments) cycle
         rows = rows + self%tables(n)%schedule%expected(time_end, steps)
      end do
   end function outputs_rows

   !> Refuse streams that would fill a disk or a folder, which are hardly meant.
   subroutine outputs_limit(self, deck, particles, time_end, steps)
      class(outputs_t), intent(in) :: self           !! The streams
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      integer(int64), intent(in) :: particles        !! In all bodies
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Steps that it will take
      real(wp) :: bytes, rows
      integer :: n

      do n = 1, size(self%snapshots)
         associate (stream => self%snapshots(n))
            rows = stream%schedule%expected(time_end, steps)
            bytes = rows*real(particles, wp)*snapshot_bytes
            if (stream%kind == of_cells) bytes = rows*stream%cells &
               *real(sum(stream%means%column%components), wp)*cell_bytes
            if (stream%kind == of_cells .and. stream%cells > most_cells) call deck%complain( &
               "output", stream%place, "would write up to "//brief(stream%cells)// &
               " cells at a time; give a region to stay in, or continue with --force")
            if (stream%place == 0 .or. (bytes <= most_bytes .and. rows <= most_files)) cycle
            call deck%complain("output", stream%place, "would write "//size_text(bytes)//" in "// &
               brief(rows)//" files; write less often, or continue with --force")
         end associate
      end do
      do n = 1, size(self%tables)
         associate (stream => self%tables(n))
            rows = stream%schedule%expected(time_end, steps)
            if (stream%kind == of_bins) rows = rows*real(stream%profile%bins, wp)
            if (stream%place == 0 .or. rows <= most_rows) cycle
            call deck%complain("output", stream%place, "would write "//brief(rows)// &
               " rows; write less often, or continue with --force")
         end associate
      end do
   end subroutine outputs_limit

   !> Close all files.
   subroutine outputs_close(self, communicator, error)
      class(outputs_t), intent(inout) :: self        !! The streams
      type(communicator_t), intent(in) :: communicator !! The ranks
      type(error_t), allocatable, intent(out) :: error !! An index cannot be written
      integer :: n

      if (.not. allocated(self%tables)) return
      do n = 1, size(self%tables)
         call self%tables(n)%file%close()
      end do
      do n = 1, size(self%snapshots)
         call self%snapshots(n)%series%close(communicator, error)
         if (allocated(error)) return
      end do
   end subroutine outputs_close

   !> Put the counters of the streams into the state of a checkpoint, each under the name of its
   !! files, so that a deck with more or fewer streams finds those that it has.
   subroutine outputs_save(self, state)
      class(outputs_t), intent(in) :: self           !! The streams
      type(state_t), intent(inout) :: state          !! Of the checkpoint
      integer :: n

      do n = 1, size(self%snapshots)
         associate (stream => self%snapshots(n))
            call state%set(counter_name(self, stream%prefix), [int(stream%next, int64), &
               stream%last_step])
         end associate
      end do
      do n = 1, size(self%tables)
         associate (stream => self%tables(n))
            call state%set(counter_name(self, stream%name), [stream%last_step])
         end associate
      end do
   end subroutine outputs_save

   !> Name of the counters of a stream in a checkpoint; the case may have another name after it.
   pure function counter_name(self, file) result(name)
      class(outputs_t), intent(in) :: self           !! For the case
      character(len=*), intent(in) :: file           !! A table, or the beginning of names
      character(len=:), allocatable :: name

      name = "output"//file(len(self%case) + 1:)
   end function counter_name

   !> Take the counters from a checkpoint. Streams that the deck got since then start anew. What
   !! the schedules have done follows from the time, since intervals may have changed.
   subroutine outputs_load(self, state)
      class(outputs_t), intent(inout) :: self        !! The streams
      type(state_t), intent(in) :: state             !! Of the checkpoint
      integer(int64), allocatable :: counters(:)
      type(error_t), allocatable :: error
      integer :: n

      do n = 1, size(self%snapshots)
         associate (stream => self%snapshots(n))
            call state%get(counter_name(self, stream%prefix), counters, error)
            if (allocated(error)) cycle
            stream%next = int(counters(1))
            stream%last_step = counters(2)
            call stream%schedule%catch_up(state%time)
         end associate
      end do
      do n = 1, size(self%tables)
         associate (stream => self%tables(n))
            call state%get(counter_name(self, stream%name), counters, error)
            if (allocated(error)) cycle
            stream%last_step = counters(1)
            call stream%schedule%catch_up(state%time)
         end associate
      end do
   end subroutine outputs_load
end module output_streams
