! SPDX-License-Identifier: BSD-3-Clause
!> A stream that writes a file for each time: snapshots of particles or of the grid.
module output_snapshot_stream
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: brief, size_text
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use io_series, only: series_t
   use io_snapshot, only: snapshot_format_t, snapshot_header_t
   use output_stream, only: field_length, stream_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: limit_files, snapshot_stream_t

   real(wp), parameter :: most_bytes = 1.0e12_wp     !! A stream with more needs --force
   real(wp), parameter :: most_files = 1.0e6_wp      !! Limit of the number of files

   !> A stream of files.
   type, abstract, extends(stream_t) :: snapshot_stream_t
      character(len=field_length), allocatable :: fields(:) !! Names, or "default"
      type(snapshot_format_t) :: format              !! Precision, compression, which particles
      type(series_t) :: series                       !! The files written so far
      integer :: next = 0                            !! Number of the next file
   contains
      procedure(write_file_i), deferred :: write_file !! Write one file
      procedure(bytes_i), deferred :: bytes_of_file  !! Expected size
      procedure :: declare_format                    !! Keys of the format of files
      procedure :: read_format                       !! Read the keys
      procedure :: open => snapshot_open             !! Find the files of the run so far
      procedure :: write => snapshot_stream_write    !! Write a file, update the series
      procedure :: close => snapshot_close           !! Complete the index
      procedure :: limit => snapshot_limit           !! Refuse implausible sizes
      procedure :: list => snapshot_list             !! For the summary
      procedure :: has_series => snapshot_has_series !! True
      procedure :: counters => snapshot_counters     !! For a checkpoint
      procedure :: set_counters => snapshot_set_counters !! From a checkpoint
   end type snapshot_stream_t

   abstract interface
      !> Write one file. Collective.
      subroutine write_file_i(self, simulation, path, header, error)
         import :: error_t, simulation_t, snapshot_header_t, snapshot_stream_t
         implicit none
         class(snapshot_stream_t), intent(inout) :: self
         type(simulation_t), intent(inout) :: simulation
         character(len=*), intent(in) :: path
         type(snapshot_header_t), intent(in) :: header !! Text and time for the file
         type(error_t), allocatable, intent(out) :: error !! If the file cannot be written
      end subroutine write_file_i

      !> Expected size of a file [byte].
      pure real(wp) function bytes_i(self, particles) result(bytes)
         import :: int64, snapshot_stream_t, wp
         implicit none
         class(snapshot_stream_t), intent(in) :: self
         integer(int64), intent(in) :: particles     !! Number of particles in all bodies
      end function bytes_i
   end interface

contains

   !> Declare the keys of the format of files.
   subroutine declare_format(self, schema, kind)
      class(snapshot_stream_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      if (.not. schema%extend_owner("output", "precision", kind)) call schema%text("output", &
         "precision", "floating-point precision in files", default="single", &
         words="single double", owner="kind = "//kind)
      if (.not. schema%extend_owner("output", "compress", kind)) call schema%integer("output", &
         "compress", "gzip level, 0 = off", default="1", range=">= 0 <= 9", owner="kind = "//kind)
   end subroutine declare_format

   !> Read the keys of the format of files.
   subroutine read_format(self, group)
      class(snapshot_stream_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      character(len=:), allocatable :: word

      call group%get("precision", word)
      self%format%single = word == "single"
      call group%get("compress", self%format%compress)
   end subroutine read_format

   !> Find the files of the run so far.
   subroutine snapshot_open(self, simulation, folder, header, restarted, note, error)
      class(snapshot_stream_t), intent(inout) :: self
      type(simulation_t), intent(in) :: simulation
      character(len=*), intent(in) :: folder         !! Folder of the results
      type(snapshot_header_t), intent(in) :: header  !! Unused
      logical, intent(in) :: restarted               !! Not used: a new run has no earlier files
      character(len=:), allocatable, intent(out) :: note !! Files that cannot be read, or empty
      type(error_t), allocatable, intent(out) :: error !! The folder cannot be read

      call self%series%open(simulation%machine%communicator, folder, self%file, self%next, note, &
         error)
   end subroutine snapshot_open

   !> Write a file and update the series. Collective.
   subroutine snapshot_stream_write(self, simulation, header, note, error)
      class(snapshot_stream_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(snapshot_header_t), intent(in) :: header  !! Text and time for the file
      character(len=:), allocatable, intent(inout) :: note !! Gets a line for the log
      type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      character(len=:), allocatable :: path
      character(len=16) :: text

      call simulation%machine%timer%start(simulation%machine%phase%output)
      path = self%series%path(self%next)
      call self%write_file(simulation, path, header, error)
      if (.not. allocated(error)) call self%series%add(simulation%machine%communicator, path, error)
      call simulation%machine%timer%stop(simulation%machine%phase%output)
      if (allocated(error)) return
      self%next = self%next + 1
      write (text, "(es12.5)") simulation%clock%time
      if (len(note) > 0) note = note//new_line("a")
      note = note//"  wrote "//path(index(path, "/", back=.true.) + 1:)//"  t = "// &
         trim(adjustl(text))//" s"
   end subroutine snapshot_stream_write

   !> Complete the index. Collective.
   subroutine snapshot_close(self, communicator, error)
      class(snapshot_stream_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      type(error_t), allocatable, intent(out) :: error !! The index cannot be written

      call self%series%close(communicator, error)
   end subroutine snapshot_close

   !> Refuse implausible sizes.
   subroutine snapshot_limit(self, deck, particles, time_end, steps)
      class(snapshot_stream_t), intent(in) :: self
      type(deck_t), intent(inout) :: deck            !! Collects errors
      integer(int64), intent(in) :: particles        !! Number of particles in all bodies
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Expected number of steps

      call limit_files(deck, self%place, self%schedule%expected(time_end, steps), &
         self%bytes_of_file(particles))
   end subroutine snapshot_limit

   !> Refuse too many files, or too large ones.
   subroutine limit_files(deck, place, files, bytes)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      integer, intent(in) :: place                   !! Number of the &output, 0 = it has none
      real(wp), intent(in) :: files                  !! Expected number of files
      real(wp), intent(in) :: bytes                  !! Expected size of one

      if (place == 0 .or. (files*bytes <= most_bytes .and. files <= most_files)) return
      call deck%add_error("output", place, "would write "//size_text(files*bytes)//" in "// &
         brief(files)//" files; write less often, or continue with --force [D430]")
   end subroutine limit_files

   !> Entry in the summary: the file that ParaView opens.
   pure subroutine snapshot_list(self, key, file)
      class(snapshot_stream_t), intent(in) :: self
      character(len=:), allocatable, intent(out) :: key !! For all streams of files
      character(len=:), allocatable, intent(out) :: file !! List of the series

      key = "particles"
      file = self%file//".hdf.series"
   end subroutine snapshot_list

   !> There is a file for each time.
   pure logical function snapshot_has_series(self) result(has)
      class(snapshot_stream_t), intent(in) :: self

      has = .true.
   end function snapshot_has_series

   !> Number of the next file and step of the last one.
   pure function snapshot_counters(self) result(counters)
      class(snapshot_stream_t), intent(in) :: self
      integer(int64), allocatable :: counters(:)

      counters = [int(self%next, int64), self%last_step]
   end function snapshot_counters

   !> Set them from a checkpoint.
   pure subroutine snapshot_set_counters(self, counters)
      class(snapshot_stream_t), intent(inout) :: self
      integer(int64), intent(in) :: counters(:)      !! Counters from snapshot_counters

      self%next = int(counters(1))
      self%last_step = counters(2)
   end subroutine snapshot_set_counters
end module output_snapshot_stream
