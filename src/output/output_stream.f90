! SPDX-License-Identifier: BSD-3-Clause
!> A stream of output: the files of one &output. Each kind of output is a type that extends this
!! one, in a file stream_KIND.f90; CMakeLists.txt lists the kinds.
module output_stream
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use io_snapshot, only: snapshot_header_t
   use output_schedule, only: schedule_t
   use particle_store, only: store_t
   use sample_fragments, only: fragments_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_file, stream_holder_t, stream_t

   integer, parameter, public :: field_length = 64   !! Longest name in `fields`

   !> A stream of output of any kind.
   type, abstract :: stream_t
      integer :: place = 0                           !! Number of its &output, 0 = it has none
      character(len=:), allocatable :: file          !! Name of a table, beginning of other names
      type(schedule_t) :: schedule                   !! Times of output
      integer(int64) :: last_step = -1               !! Step that was written last
   contains
      procedure(about_i), deferred :: about          !! Description, for the help of `kind`
      procedure(about_i), deferred :: ending         !! Suffix of file names, after the case
      procedure(declare_i), deferred :: declare      !! Declare the keys of the kind
      procedure(read_i), deferred :: read            !! Read and check these keys
      procedure(open_i), deferred :: open            !! Open the files, new or after a restart
      procedure(write_i), deferred :: write          !! Write the present state
      procedure(close_i), deferred :: close          !! Close the files
      procedure(limit_i), deferred :: limit          !! Refuse implausible sizes
      procedure(list_i), deferred :: list            !! Key and file in the summary of a run
      procedure :: has_series => stream_has_series   !! Is there a file for each time?
      procedure :: always_named => stream_always_named !! Does its file always have its name?
      procedure :: default_count => stream_default_count !! Outputs of a run without &output
      procedure :: request_sums => stream_request_sums !! Let the simulation sum what it shows
      procedure :: read_default => stream_read_default !! Content in a run without &output
      procedure :: try_field => stream_try_field     !! Can a field be written?
      procedure :: offer_fragments => stream_offer_fragments !! Define the field `fragment`
      procedure :: take_fragments => stream_take_fragments !! Uses a given definition
      procedure :: full_snapshots => stream_full_snapshots !! Files with all particles
      procedure :: counters => stream_counters       !! State for a checkpoint
      procedure :: set_counters => stream_set_counters !! State from a checkpoint
      procedure :: save_table => stream_save_table   !! Content of a table for a checkpoint
      procedure :: expect_table => stream_expect_table !! Content of a table at a checkpoint
   end type stream_t

   !> Holds a stream of any kind.
   type :: stream_holder_t
      class(stream_t), allocatable :: item
   end type stream_holder_t

   abstract interface
      !> A word or a few about the kind.
      pure function about_i(self) result(text)
         import :: stream_t
         implicit none
         class(stream_t), intent(in) :: self
         character(len=:), allocatable :: text
      end function about_i

      !> Declare the keys of the kind in &output.
      subroutine declare_i(self, schema, kind)
         import :: schema_t, stream_t
         implicit none
         class(stream_t), intent(in) :: self
         type(schema_t), intent(inout) :: schema     !! Schema that receives the keys
         character(len=*), intent(in) :: kind        !! Word of the kind in the catalogue
      end subroutine declare_i

      !> Read the keys of the kind; the deck collects errors.
      subroutine read_i(self, group, deck, simulation, shapes)
         import :: deck_t, group_t, named_shape_t, simulation_t, stream_t
         implicit none
         class(stream_t), intent(inout) :: self
         type(group_t), intent(in) :: group          !! Group &output
         type(deck_t), intent(inout) :: deck         !! Collects errors
         type(simulation_t), intent(in) :: simulation !! With fields, for the names
         type(named_shape_t), intent(in) :: shapes(:)
      end subroutine read_i

      !> Open the files; rows later than the checkpoint of a restart are removed. Collective.
      subroutine open_i(self, simulation, folder, header, restarted, note, error)
         import :: error_t, simulation_t, snapshot_header_t, stream_t
         implicit none
         class(stream_t), intent(inout) :: self
         type(simulation_t), intent(in) :: simulation !! Ranks and present step
         character(len=*), intent(in) :: folder      !! Folder of the results
         type(snapshot_header_t), intent(in) :: header !! Units of the files
         logical, intent(in) :: restarted            !! Does the run continue from a checkpoint?
         character(len=:), allocatable, intent(out) :: note !! Files that cannot be read, or empty
         type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      end subroutine open_i

      !> Write the present state. Collective.
      subroutine write_i(self, simulation, header, note, error)
         import :: error_t, simulation_t, snapshot_header_t, stream_t
         implicit none
         class(stream_t), intent(inout) :: self
         type(simulation_t), intent(inout) :: simulation
         type(snapshot_header_t), intent(in) :: header !! Text and time for the files
         character(len=:), allocatable, intent(inout) :: note !! Lines for the log
         type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      end subroutine write_i

      !> Close the files. Collective.
      subroutine close_i(self, communicator, error)
         import :: communicator_t, error_t, stream_t
         implicit none
         class(stream_t), intent(inout) :: self
         type(communicator_t), intent(in) :: communicator
         type(error_t), allocatable, intent(out) :: error !! A file cannot be written
      end subroutine close_i

      !> Refuse a stream that would exceed the limits on size or number of files.
      subroutine limit_i(self, deck, particles, time_end, steps)
         import :: deck_t, int64, stream_t, wp
         implicit none
         class(stream_t), intent(in) :: self
         type(deck_t), intent(inout) :: deck         !! Collects errors
         integer(int64), intent(in) :: particles     !! Number of particles in all bodies
         real(wp), intent(in) :: time_end            !! End of the run [s]
         real(wp), intent(in) :: steps               !! Expected number of steps
      end subroutine limit_i

      !> Entry of the stream in the summary of a run.
      pure subroutine list_i(self, key, file)
         import :: stream_t
         implicit none
         class(stream_t), intent(in) :: self
         character(len=:), allocatable, intent(out) :: key !! Streams of one key are numbered
         character(len=:), allocatable, intent(out) :: file !! File to open
      end subroutine list_i
   end interface

contains

   !> Name of a table, or beginning of the names of files. The first stream of a kind does not show
   !! its own name.
   pure function stream_file(stream, case, name, number) result(file)
      class(stream_t), intent(in) :: stream          !! For the ending of its kind
      character(len=*), intent(in) :: case           !! Beginning of the names of all files
      character(len=*), intent(in) :: name           !! Name of the stream
      integer, intent(in) :: number                  !! Number among the streams of its kind
      character(len=:), allocatable :: file

      if (number == 1) then
         file = case//stream%ending()
      else
         file = case//"_"//name//stream%ending()
      end if
   end function stream_file

   !> True if there is a file for each time; otherwise the stream is one table.
   pure logical function stream_has_series(self) result(has)
      class(stream_t), intent(in) :: self

      has = .false.
   end function stream_has_series

   !> True if the name of the file has the name of the stream even if it is the first of its kind.
   pure logical function stream_always_named(self) result(always)
      class(stream_t), intent(in) :: self

      always = .false.
   end function stream_always_named

   !> Number of outputs of a run whose deck has no &output; 0: this kind is not written by default.
   pure integer function stream_default_count(self) result(number)
      class(stream_t), intent(in) :: self

      number = 0
   end function stream_default_count

   !> Request sums over the nodes of each step. Most streams need none.
   subroutine stream_request_sums(self, simulation)
      class(stream_t), intent(in) :: self
      type(simulation_t), intent(inout) :: simulation
   end subroutine stream_request_sums

   !> Set the content of a stream of a run without &output.
   subroutine stream_read_default(self, simulation)
      class(stream_t), intent(inout) :: self
      type(simulation_t), intent(in) :: simulation   !! For the columns that exist
   end subroutine stream_read_default

   !> Try one name of the key `fields`.
   subroutine stream_try_field(self, field, simulation, stores, error)
      class(stream_t), intent(in) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      type(simulation_t), intent(in) :: simulation   !! Grid, gravity, exact solution
      type(store_t), intent(in) :: stores(:)         !! Particles
      type(error_t), allocatable, intent(out) :: error !! The field cannot be written
   end subroutine stream_try_field

   !> Define the fragments of the field `fragment` of snapshots, unless an earlier stream has.
   subroutine stream_offer_fragments(self, fragments)
      class(stream_t), intent(in) :: self
      type(fragments_t), allocatable, intent(inout) :: fragments
   end subroutine stream_offer_fragments

   !> Use a given definition of fragments for the field `fragment`.
   subroutine stream_take_fragments(self, fragments)
      class(stream_t), intent(inout) :: self
      type(fragments_t), intent(in) :: fragments
   end subroutine stream_take_fragments

   !> Expected number of files with all particles, as far as known before the run.
   pure real(wp) function stream_full_snapshots(self, time_end) result(number)
      class(stream_t), intent(in) :: self
      real(wp), intent(in) :: time_end               !! End of the run [s]

      number = 0.0_wp
   end function stream_full_snapshots

   !> State of the stream for a checkpoint.
   pure function stream_counters(self) result(counters)
      class(stream_t), intent(in) :: self
      integer(int64), allocatable :: counters(:)

      counters = [self%last_step]
   end function stream_counters

   !> Set the state from a checkpoint.
   pure subroutine stream_set_counters(self, counters)
      class(stream_t), intent(inout) :: self
      integer(int64), intent(in) :: counters(:)      !! From stream_counters

      self%last_step = counters(1)
   end subroutine stream_set_counters

   !> Wait until the rows of a table are on disk, for a checkpoint. Collective.
   subroutine stream_save_table(self, communicator, mark, error)
      class(stream_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      integer(int64), allocatable, intent(out) :: mark(:) !! Content; not allocated: no table
      type(error_t), allocatable, intent(out) :: error !! Rows did not reach the disk
   end subroutine stream_save_table

   !> Set the content of the table at the checkpoint from which the run continues.
   pure subroutine stream_expect_table(self, mark)
      class(stream_t), intent(inout) :: self
      integer(int64), intent(in) :: mark(:)          !! From stream_save_table
   end subroutine stream_expect_table
end module output_stream
