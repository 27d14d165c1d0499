! SPDX-License-Identifier: BSD-3-Clause
!> The streams of files that a run writes: snapshots of particles and histories.
module driver_output
   use base_communicator, only: communicator_t
   use base_deck, only: deck_t, group_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: brief, size_text, text_t
   use driver_exact_error, only: error_columns, take_errors
   use driver_ledger, only: balance_t, entries, entry_names, entry_units
   use driver_schedule, only: read_schedule, schedule_t
   use driver_simulation, only: simulation_t
   use io_fields, only: choose_columns, column_t
   use io_history, only: history_t
   use io_snapshot, only: snapshot_format_t, snapshot_header_t, snapshot_write
   use io_state, only: state_t
   use io_xdmf, only: series_t
   use particle_store, only: store_t
   implicit none
   private

   public :: outputs_t

   real(wp), parameter, public :: snapshot_bytes = 60.0_wp !! Default fields, compressed
   real(wp), parameter :: most_bytes = 1.0e12_wp     !! A stream with more needs --force
   real(wp), parameter :: most_files = 1.0e6_wp      !! The same for its files
   real(wp), parameter :: most_rows = 1.0e9_wp       !! The same for rows of a history
   integer, parameter :: column_width = 40           !! Longest name of a column

   !> One stream of snapshots.
   type :: snapshots_t
      integer :: place = 0                           !! Number of its &output, 0 = none
      character(len=:), allocatable :: prefix        !! CASE_p, or CASE_NAME_p for further streams
      character(len=64), allocatable :: fields(:)    !! Names, or "default"
      type(snapshot_format_t) :: format              !! Precision, compression
      type(schedule_t) :: schedule                   !! When
      type(series_t) :: series                       !! Index files
      integer :: next = 0                            !! Number of the next snapshot
      integer(int64) :: last_step = -1               !! Step of the last snapshot
   end type snapshots_t

   !> One history.
   type :: histories_t
      integer :: place = 0                           !! Number of its &output, 0 = none
      character(len=:), allocatable :: path          !! CASE_history.csv
      type(schedule_t) :: schedule                   !! When
      type(history_t) :: file                        !! The file
      integer(int64) :: last_step = -1               !! Step of the last row
   end type histories_t

   !> All streams of a run.
   type :: outputs_t
      character(len=:), allocatable :: folder        !! Where results go
      character(len=:), allocatable :: case          !! Prefix of all files
      type(snapshots_t), allocatable :: snapshots(:) !! Streams of particles
      type(histories_t), allocatable :: histories(:) !! Histories
      type(snapshot_header_t) :: header              !! What every snapshot says of the run
   contains
      procedure :: plan => outputs_plan              !! Read the streams from the deck
      procedure :: limit => outputs_limit            !! Refuse sizes that are hardly meant
      procedure :: open => outputs_open              !! Open files, new or after a restart
      procedure :: write_due => outputs_write_due    !! Write what is due
      procedure :: expected => outputs_expected      !! Snapshots that will be written
      procedure :: close => outputs_close            !! Close files
      procedure :: save => outputs_save              !! Counters into a checkpoint
      procedure :: load => outputs_load              !! Counters from a checkpoint
   end type outputs_t

contains

   !> Read the streams. Without any, a run still keeps a history and its first and last state.
   subroutine outputs_plan(self, deck, stores, time_end)
      class(outputs_t), intent(inout) :: self        !! The streams; folder and case are set
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(store_t), intent(inout) :: stores(:)      !! With their fields, for the names
      real(wp), intent(in) :: time_end               !! End of the run [s]
      type(group_t) :: group
      character(len=:), allocatable :: kind, name
      integer :: index, snapshots, histories

      snapshots = 0
      histories = 0
      do index = 1, deck%count("output")
         group = deck%group("output", index)
         call group%get("kind", kind)
         if (kind == "particles") snapshots = snapshots + 1
         if (kind == "history") histories = histories + 1
      end do
      allocate (self%snapshots(snapshots), self%histories(histories))
      snapshots = 0
      histories = 0
      do index = 1, deck%count("output")
         group = deck%group("output", index)
         call group%get("kind", kind)
         call group%get("name", name)
         if (kind == "particles") then
            snapshots = snapshots + 1
            self%snapshots(snapshots)%place = index
            call plan_snapshots(group, deck, stores, self%snapshots(snapshots))
            self%snapshots(snapshots)%prefix = self%case//"_p"
            if (snapshots > 1) self%snapshots(snapshots)%prefix = self%case//"_"//name//"_p"
            call read_schedule(group, time_end, self%snapshots(snapshots)%schedule)
         else if (kind == "history") then
            histories = histories + 1
            self%histories(histories)%place = index
            self%histories(histories)%path = self%folder//"/"//self%case//"_history.csv"
            if (histories > 1) self%histories(histories)%path = &
               self%folder//"/"//self%case//"_"//name//"_history.csv"
            call read_schedule(group, time_end, self%histories(histories)%schedule)
         end if
      end do
      if (size(self%snapshots) + size(self%histories) > 0) return
      deallocate (self%snapshots, self%histories)
      allocate (self%snapshots(1), self%histories(1))
      self%snapshots(1)%prefix = self%case//"_p"
      self%snapshots(1)%fields = [character(len=64) :: "default"]
      self%snapshots(1)%schedule%interval = time_end
      self%histories(1)%path = self%folder//"/"//self%case//"_history.csv"
      self%histories(1)%schedule%interval = time_end/100.0_wp
   end subroutine outputs_plan

   !> Fields and format of one stream of snapshots.
   subroutine plan_snapshots(group, deck, stores, stream)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! The deck, for bodies and complaints
      type(store_t), intent(inout) :: stores(:)      !! With their fields, for the names
      type(snapshots_t), intent(inout) :: stream     !! The stream
      character(len=:), allocatable :: word
      type(text_t), allocatable :: names(:)
      type(column_t), allocatable :: columns(:)
      type(error_t), allocatable :: error
      integer :: n, place

      call group%list("fields", names)
      allocate (stream%fields(max(size(names), 1)))
      stream%fields = "default"
      do n = 1, size(names)
         stream%fields(n) = names(n)%text
      end do
      call choose_columns(stores, stream%fields, columns, error)
      if (allocated(error)) call deck%complain(group, error%message, "fields")
      call group%get("precision", word)
      stream%format%single = word == "single"
      call group%get("compress", stream%format%compress)
      call group%get("stride", stream%format%stride)
      call group%list("bodies", names)
      if (size(names) == 0) return
      allocate (stream%format%bodies(0))
      do n = 1, size(names)
         place = deck%named("body", names(n)%text)
         if (place > 0) stream%format%bodies = [stream%format%bodies, int(place, int64)]
      end do
   end subroutine plan_snapshots

   !> Open the streams; after a restart what was written later than the checkpoint is cut away.
   subroutine outputs_open(self, simulation, restarted, note, error)
      class(outputs_t), intent(inout) :: self        !! The streams
      type(simulation_t), intent(inout) :: simulation !! The run
      logical, intent(in) :: restarted               !! Does the run go on from a checkpoint?
      character(len=:), allocatable, intent(out) :: note !! Snapshots left out, or empty
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      character(len=column_width) :: columns(entries + 8 &
         + merge(size(error_columns), 0, allocated(simulation%exact)))
      character(len=:), allocatable :: left_out
      integer :: n

      note = ""
      columns(:entries + 8) = column_names()
      if (allocated(simulation%exact)) columns(entries + 9:) = error_columns
      do n = 1, size(self%snapshots)
         call self%snapshots(n)%series%open(simulation%communicator, self%folder, &
            self%snapshots(n)%prefix, self%snapshots(n)%next, left_out, error)
         if (allocated(error)) return
         note = note//left_out
      end do
      do n = 1, size(self%histories)
         call self%histories(n)%file%open(simulation%communicator, self%histories(n)%path, &
            columns, &
            merge(simulation%step, -1_int64, restarted), error)
         if (allocated(error)) return
      end do
   end subroutine outputs_open

   !> Columns of a history, names with units.
   pure function column_names() result(columns)
      character(len=column_width) :: columns(entries + 8)
      integer, parameter :: before = 3
      integer :: n

      columns(:before) = [character(len=column_width) :: "time [s]", "step", "dt [s]"]
      do n = 1, entries
         columns(before + n) = trim(entry_names(n))//" ["//trim(entry_units(n))//"]"
      end do
      columns(before + entries + 1:) = [character(len=column_width) :: "total [J]", &
         "mass_error [1]", "momentum_error [1]", "angular_momentum_error [1]", "energy_error [1]"]
   end function column_names

   !> Write what is due. With `last` every stream writes the final state, once.
   subroutine outputs_write_due(self, simulation, last, note, error)
      class(outputs_t), intent(inout) :: self        !! The streams
      type(simulation_t), intent(inout) :: simulation !! The run
      logical, intent(in) :: last                    !! Is this the final state?
      character(len=:), allocatable, intent(out) :: note !! What the log should say
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      type(balance_t) :: now
      logical :: due
      integer :: n

      note = ""
      do n = 1, size(self%histories)
         associate (stream => self%histories(n))
            due = stream%schedule%due(simulation%step, simulation%time)
            if (.not. (due .or. last) .or. stream%last_step == simulation%step) cycle
            call simulation%timer%start(simulation%phase%ledger)
            call simulation%ledger%balance(simulation%communicator, simulation%grid, &
               simulation%stores, simulation%materials, now)
            if (allocated(simulation%exact)) call take_errors(simulation)
            call stream%file%row(simulation%communicator, row_of(simulation, now), error)
            call simulation%timer%stop(simulation%phase%ledger)
            if (allocated(error)) return
            stream%last_step = simulation%step
         end associate
      end do
      do n = 1, size(self%snapshots)
         associate (stream => self%snapshots(n))
            due = stream%schedule%due(simulation%step, simulation%time)
            if (.not. (due .or. last) .or. stream%last_step == simulation%step) cycle
            call simulation%timer%start(simulation%phase%output)
            call write_snapshot(self, stream, simulation, note, error)
            call simulation%timer%stop(simulation%phase%output)
            if (allocated(error)) return
         end associate
      end do
   end subroutine outputs_write_due

   !> Write one snapshot and bring the index files up to date.
   subroutine write_snapshot(self, stream, simulation, note, error)
      class(outputs_t), intent(inout) :: self        !! For the header
      type(snapshots_t), intent(inout) :: stream     !! The stream
      type(simulation_t), intent(inout) :: simulation !! The run
      character(len=:), allocatable, intent(inout) :: note !! What the log should say
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      character(len=:), allocatable :: path
      character(len=16) :: text

      self%header%time = simulation%time
      self%header%dt = simulation%dt
      self%header%step = simulation%step
      path = stream%series%path(stream%next)
      call snapshot_write(simulation%communicator, path, simulation%stores, stream%fields, &
         stream%format, self%header, error)
      if (allocated(error)) return
      call stream%series%add(simulation%communicator, path, error)
      if (allocated(error)) return
      stream%next = stream%next + 1
      stream%last_step = simulation%step
      write (text, "(es12.5)") simulation%time
      if (len(note) > 0) note = note//new_line("a")
      note = note//"  wrote "//path(index(path, "/", back=.true.) + 1:)//"  t = "// &
         trim(adjustl(text))//" s"
   end subroutine write_snapshot

   !> Values of one row of a history.
   pure function row_of(simulation, now) result(row)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(balance_t), intent(in) :: now             !! The books
      real(wp), allocatable :: row(:)

      row = [simulation%time, real(simulation%step, wp), simulation%dt, now%entry, now%total, &
         now%mass_error, now%momentum_error, now%angular_error, now%energy_error]
      if (allocated(simulation%exact)) row = [row, simulation%exact%error]
   end function row_of

   !> Snapshots that the run will write, as far as that is known before it.
   pure integer(int64) function outputs_expected(self, time_end) result(number)
      class(outputs_t), intent(in) :: self           !! The streams
      real(wp), intent(in) :: time_end               !! End of the run [s]
      integer :: n

      number = 0
      do n = 1, size(self%snapshots)
         number = number + int(self%snapshots(n)%schedule%expected(time_end, 0.0_wp), int64)
      end do
   end function outputs_expected

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
            if (stream%place == 0 .or. (bytes <= most_bytes .and. rows <= most_files)) cycle
            call deck%complain("output", stream%place, "would write "//size_text(bytes)//" in "// &
               brief(rows)//" files; write less often, or continue with --force")
         end associate
      end do
      do n = 1, size(self%histories)
         associate (stream => self%histories(n))
            rows = stream%schedule%expected(time_end, steps)
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

      if (.not. allocated(self%histories)) return
      do n = 1, size(self%histories)
         call self%histories(n)%file%close()
      end do
      do n = 1, size(self%snapshots)
         call self%snapshots(n)%series%close(communicator, error)
         if (allocated(error)) return
      end do
   end subroutine outputs_close

   !> Put the counters of the streams into the state of a checkpoint.
   subroutine outputs_save(self, state)
      class(outputs_t), intent(in) :: self           !! The streams
      type(state_t), intent(inout) :: state          !! Of the checkpoint
      integer(int64) :: counters(3*size(self%snapshots) + 2*size(self%histories))
      integer :: n, at

      at = 0
      do n = 1, size(self%snapshots)
         counters(at + 1:at + 3) = [self%snapshots(n)%schedule%done, &
            int(self%snapshots(n)%next, int64), self%snapshots(n)%last_step]
         at = at + 3
      end do
      do n = 1, size(self%histories)
         counters(at + 1:at + 2) = [self%histories(n)%schedule%done, self%histories(n)%last_step]
         at = at + 2
      end do
      call state%set("output_counters", counters)
   end subroutine outputs_save

   !> Take the counters from a checkpoint. Streams that the deck got or lost since then start anew.
   subroutine outputs_load(self, state)
      class(outputs_t), intent(inout) :: self        !! The streams
      type(state_t), intent(in) :: state             !! Of the checkpoint
      integer(int64), allocatable :: counters(:)
      type(error_t), allocatable :: error
      integer :: n, at

      call state%get("output_counters", counters, error)
      if (allocated(error)) return
      if (size(counters) /= 3*size(self%snapshots) + 2*size(self%histories)) return
      at = 0
      do n = 1, size(self%snapshots)
         self%snapshots(n)%schedule%done = counters(at + 1)
         self%snapshots(n)%next = int(counters(at + 2))
         self%snapshots(n)%last_step = counters(at + 3)
         at = at + 3
      end do
      do n = 1, size(self%histories)
         self%histories(n)%schedule%done = counters(at + 1)
         self%histories(n)%last_step = counters(at + 2)
         at = at + 2
      end do
   end subroutine outputs_load
end module driver_output
