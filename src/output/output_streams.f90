! SPDX-License-Identifier: BSD-3-Clause
!> All streams of output of a run: planned from the deck, opened, written when due, closed.
module output_streams
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: number, text_t
   use deck_reader, only: deck_t, group_t
   use io_snapshot, only: snapshot_header_t
   use io_state, only: state_t
   use output_catalogue, only: choose_stream, stream_names
   use output_schedule, only: read_schedule
   use output_stop_quantity, only: stop_quantity_t
   use output_stream, only: stream_file, stream_holder_t, stream_t
   use sample_fragments, only: fragments_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: outputs_t

   !> All streams of a run.
   type :: outputs_t
      character(len=:), allocatable :: folder        !! Folder and case of results
      character(len=:), allocatable :: case          !! Beginning of the names of all files
      type(stream_holder_t), allocatable :: streams(:) !! In the order of the deck
      type(snapshot_header_t) :: header              !! Description of the run for every snapshot
      type(stop_quantity_t) :: stop_quantity         !! Column of a table that ends the run
   contains
      procedure :: plan => outputs_plan              !! Read the streams from the deck
      procedure :: limit => outputs_limit            !! Refuse implausible sizes
      procedure :: open => outputs_open              !! Open files, new or after a restart
      procedure :: write_due => outputs_write_due    !! Write the streams that are due
      procedure :: has_series => outputs_has_series  !! Are there snapshots?
      procedure :: full_snapshots => outputs_full_snapshots !! Files with all particles
      procedure :: list => outputs_list              !! Keys and files for the summary
      procedure :: close => outputs_close            !! Close files
      procedure :: save => outputs_save              !! Counters into a checkpoint
      procedure :: load => outputs_load              !! Counters from a checkpoint
   end type outputs_t

contains

   !> Read the streams. Without any, the default outputs of the kinds are written.
   subroutine outputs_plan(self, deck, simulation, shapes, time_end)
      class(outputs_t), intent(inout) :: self        !! The streams; folder and case are set
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! Gets the sums that streams request
      type(named_shape_t), intent(in) :: shapes(:)
      real(wp), intent(in) :: time_end               !! End of the run [s]
      type(stream_holder_t) :: next
      type(group_t) :: group
      character(len=:), allocatable :: name, word
      integer :: alike, earlier, n

      allocate (self%streams(0))
      do n = 1, deck%count("output")
         group = deck%group("output", n)
         call group%get("kind", word)
         call choose_stream(word, next%item)
         if (.not. allocated(next%item)) cycle
         next%item%place = n
         call next%item%read(group, deck, simulation, shapes)
         call next%item%request_sums(simulation)
         alike = merge(2, 1, next%item%always_named())
         do earlier = 1, size(self%streams)
            associate (other => self%streams(earlier)%item)
               if (same_type_as(other, next%item) .and. .not. other%always_named()) &
                  alike = alike + 1
            end associate
         end do
         call group%get("name", name)
         next%item%file = stream_file(next%item, self%case, name, alike)
         call read_schedule(group, time_end, next%item%schedule)
         self%streams = [self%streams, next]
      end do
      if (deck%count("output") == 0) call plan_default(self, simulation, time_end)
      call share_fragments(self%streams)
      call self%stop_quantity%find(deck, self%streams, self%case)
   end subroutine outputs_plan

   !> Streams of a deck without &output.
   subroutine plan_default(self, simulation, time_end)
      class(outputs_t), intent(inout) :: self        !! Gets the streams
      type(simulation_t), intent(in) :: simulation   !! For the columns that exist
      real(wp), intent(in) :: time_end               !! End of the run [s]
      type(stream_holder_t) :: next
      integer :: n

      do n = 1, size(stream_names)
         call choose_stream(stream_names(n), next%item)
         if (next%item%default_count() == 0) cycle
         next%item%file = stream_file(next%item, self%case, "", 1)
         next%item%schedule%interval = time_end/real(next%item%default_count(), wp)
         call next%item%read_default(simulation)
         self%streams = [self%streams, next]
      end do
   end subroutine plan_default

   !> Use the definition of fragments of the first table of fragments for all snapshots.
   subroutine share_fragments(streams)
      type(stream_holder_t), intent(inout) :: streams(:)
      type(fragments_t), allocatable :: fragments
      integer :: n

      do n = 1, size(streams)
         call streams(n)%item%offer_fragments(fragments)
      end do
      if (.not. allocated(fragments)) return
      do n = 1, size(streams)
         call streams(n)%item%take_fragments(fragments)
      end do
   end subroutine share_fragments

   !> Open the streams; after a restart rows later than the checkpoint are removed. Collective.
   subroutine outputs_open(self, simulation, restarted, note, error)
      class(outputs_t), intent(inout) :: self
      type(simulation_t), intent(in) :: simulation   !! Ranks and present step
      logical, intent(in) :: restarted               !! Does the run continue from a checkpoint?
      character(len=:), allocatable, intent(out) :: note !! Files that lost data, or empty
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      character(len=:), allocatable :: left_out
      integer :: n

      note = ""
      do n = 1, size(self%streams)
         call self%streams(n)%item%open(simulation, self%folder, self%header, restarted, left_out, &
            error)
         if (allocated(error)) return
         note = note//left_out
      end do
   end subroutine outputs_open

   !> Write the streams that are due. With `last` every stream writes the final state, once.
   !! Collective.
   subroutine outputs_write_due(self, simulation, last, note, error)
      class(outputs_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      logical, intent(in) :: last                    !! Is this the final state?
      character(len=:), allocatable, intent(out) :: note !! Lines for the log
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      logical :: due
      integer :: n

      note = ""
      self%header%time = simulation%clock%time
      self%header%dt = simulation%clock%dt
      self%header%dt_next = simulation%clock%dt_next
      self%header%velocity_lag = simulation%scheme%method%lag(simulation%clock%dt)
      if (allocated(simulation%space%cell)) self%header%stretch = reshape( &
         [simulation%space%cell%stretch%before, simulation%space%grid%lower], [3, 4])
      self%header%step = simulation%clock%step
      do n = 1, size(self%streams)
         associate (stream => self%streams(n)%item)
            due = stream%schedule%due(simulation%clock%step, simulation%clock%time)
            if (.not. (due .or. last) .or. stream%last_step == simulation%clock%step) cycle
            call stream%write(simulation, self%header, note, error)
            if (allocated(error)) return
            stream%last_step = simulation%clock%step
         end associate
         call self%stop_quantity%update(self%streams, n, simulation%clock%step)
      end do
   end subroutine outputs_write_due

   !> True if a stream writes snapshots.
   pure logical function outputs_has_series(self) result(has)
      class(outputs_t), intent(in) :: self
      integer :: n

      has = .false.
      do n = 1, size(self%streams)
         has = has .or. self%streams(n)%item%has_series()
      end do
   end function outputs_has_series

   !> Expected number of files with all particles, as far as known before the run.
   pure integer(int64) function outputs_full_snapshots(self, time_end) result(number)
      class(outputs_t), intent(in) :: self
      real(wp), intent(in) :: time_end               !! End of the run [s]
      integer :: n

      number = 0
      do n = 1, size(self%streams)
         number = number + int(self%streams(n)%item%full_snapshots(time_end), int64)
      end do
   end function outputs_full_snapshots

   !> Refuse streams that would exceed the limits on size or number of files.
   subroutine outputs_limit(self, deck, particles, time_end, steps)
      class(outputs_t), intent(in) :: self
      type(deck_t), intent(inout) :: deck            !! Collects errors
      integer(int64), intent(in) :: particles        !! Number of particles in all bodies
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Expected number of steps
      integer :: n

      do n = 1, size(self%streams)
         call self%streams(n)%item%limit(deck, particles, time_end, steps)
      end do
   end subroutine outputs_limit

   !> Keys and files of all streams, for the summary; a key ends with the number of the stream among
   !! those of the key.
   subroutine outputs_list(self, keys, files)
      class(outputs_t), intent(in) :: self
      type(text_t), allocatable, intent(out) :: keys(:) !! (stream) As particles_1
      type(text_t), allocatable, intent(out) :: files(:) !! (stream) File to open
      type(text_t) :: begin(size(self%streams))
      integer :: alike, earlier, n

      allocate (keys(size(begin)), files(size(begin)))
      do n = 1, size(begin)
         call self%streams(n)%item%list(begin(n)%text, files(n)%text)
         alike = 0
         do earlier = 1, n
            if (begin(earlier)%text == begin(n)%text) alike = alike + 1
         end do
         keys(n)%text = begin(n)%text//"_"//number(alike)
      end do
   end subroutine outputs_list

   !> Close all files. Collective.
   subroutine outputs_close(self, communicator, error)
      class(outputs_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      type(error_t), allocatable, intent(out) :: error !! An index cannot be written
      integer :: n

      if (.not. allocated(self%streams)) return
      do n = 1, size(self%streams)
         call self%streams(n)%item%close(communicator, error)
         if (allocated(error)) return
      end do
   end subroutine outputs_close

   !> Put the counters of the streams into the state of a checkpoint, each under the name of its
   !! files, so that a deck with more or fewer streams finds those that it has. All rows of tables
   !! are on disk afterwards. Collective.
   subroutine outputs_save(self, communicator, state, error)
      class(outputs_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      type(state_t), intent(inout) :: state          !! State of the checkpoint
      type(error_t), allocatable, intent(out) :: error !! Rows did not reach the disk
      integer(int64), allocatable :: mark(:)
      integer :: n

      do n = 1, size(self%streams)
         associate (stream => self%streams(n)%item)
            call state%set("output"//suffix(self, stream), stream%counters())
            call stream%save_table(communicator, mark, error)
            if (allocated(error)) return
            if (allocated(mark)) call state%set("table"//suffix(self, stream), mark)
         end associate
      end do
      call self%stop_quantity%save(state)
   end subroutine outputs_save

   !> End of the names of a stream in a checkpoint; another case has the same.
   pure function suffix(self, stream) result(name)
      class(outputs_t), intent(in) :: self           !! For the case
      class(stream_t), intent(in) :: stream
      character(len=:), allocatable :: name

      name = stream%file(len(self%case) + 1:)
   end function suffix

   !> Restore the counters from a checkpoint. Streams added to the deck since then start from zero.
   !! The state of the schedules follows from the time, because intervals may have changed.
   subroutine outputs_load(self, state, has_tables)
      class(outputs_t), intent(inout) :: self
      type(state_t), intent(in) :: state             !! State of the checkpoint
      logical, intent(in) :: has_tables              !! Are its tables in the folder of this run?
      integer(int64), allocatable :: counters(:), mark(:)
      type(error_t), allocatable :: error
      integer :: n

      do n = 1, size(self%streams)
         associate (stream => self%streams(n)%item)
            call state%get("output"//suffix(self, stream), counters, error)
            if (allocated(error)) cycle
            call stream%set_counters(counters)
            if (has_tables .and. state%has("table"//suffix(self, stream))) then
               call state%get("table"//suffix(self, stream), mark, error)
               call stream%expect_table(mark)
            end if
            call stream%schedule%catch_up(state%time)
         end associate
      end do
      call self%stop_quantity%load(state)
   end subroutine outputs_load
end module output_streams
