! SPDX-License-Identifier: BSD-3-Clause
!> Output of particles: a file for each time.
module stream_particles
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use io_snapshot, only: snapshot_header_t, snapshot_write
   use output_contact_groups, only: separate_bodies_in_contact
   use output_field_names, only: declare_fields, read_fields
   use output_selection, only: declare_selection, declare_stride, read_selection
   use output_snapshot_stream, only: snapshot_stream_t
   use particle_store, only: store_t
   use sample_fields, only: choose_columns, column_t
   use sample_fragments, only: fragment_labels, fragments_t, labels_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_particles_t

   real(wp), parameter, public :: snapshot_bytes = 60.0_wp !! Default fields, compressed

   !> Snapshots of particles.
   type, extends(snapshot_stream_t) :: stream_particles_t
      type(fragments_t) :: fragments                 !! Definition of the field `fragment`
   contains
      procedure :: about => particles_about          !! For the help
      procedure :: ending => particles_ending        !! End of file names
      procedure :: declare => particles_declare      !! Keys
      procedure :: read => particles_read            !! Read the keys
      procedure :: read_default => particles_read_default !! Without &output
      procedure :: default_count => particles_default_count !! First and last state
      procedure :: try_field => particles_try_field  !! Check a name
      procedure :: take_fragments => particles_take_fragments !! Define `fragment`
      procedure :: full_snapshots => particles_full_snapshots !! For the cost of a run
      procedure :: write_file => particles_write_file !! Write a snapshot
      procedure :: bytes_of_file => particles_bytes_of_file !! Expected size
   end type stream_particles_t

contains

   !> For the help of `kind`.
   pure function particles_about(self) result(text)
      class(stream_particles_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "particles"
   end function particles_about

   !> Suffix of file names, after the case.
   pure function particles_ending(self) result(text)
      class(stream_particles_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_p"
   end function particles_ending

   !> Declare the keys of the kind.
   subroutine particles_declare(self, schema, kind)
      class(stream_particles_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call declare_fields(schema, kind)
      call declare_selection(schema, kind)
      call declare_stride(schema, kind)
      call self%declare_format(schema, kind)
   end subroutine particles_declare

   !> Read the keys of the kind.
   subroutine particles_read(self, group, deck, simulation, shapes)
      class(stream_particles_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Read for the names of fields
      type(named_shape_t), intent(in) :: shapes(:)

      call read_fields(group, deck, simulation, self, self%fields)
      call self%read_format(group)
      call read_selection(group, deck, shapes, self%format%pick_rule_t)
      call group%get("stride", self%format%stride)
   end subroutine particles_read

   !> Without &output the usual fields of all particles are written.
   subroutine particles_read_default(self, simulation)
      class(stream_particles_t), intent(inout) :: self
      type(simulation_t), intent(in) :: simulation   !! Unused

      self%fields = [character(len=len(self%fields)) :: "default"]
   end subroutine particles_read_default

   !> Without &output the first and the last state are written.
   pure integer function particles_default_count(self) result(number)
      class(stream_particles_t), intent(in) :: self

      number = 1
   end function particles_default_count

   !> Try one name of the key `fields`.
   subroutine particles_try_field(self, field, simulation, stores, error)
      class(stream_particles_t), intent(in) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      type(simulation_t), intent(in) :: simulation   !! Unused
      type(store_t), intent(in) :: stores(:)         !! Particles
      type(error_t), allocatable, intent(out) :: error !! The field cannot be written
      type(column_t), allocatable :: columns(:)

      call choose_columns(stores, [field], columns, error)
   end subroutine particles_try_field

   !> The field `fragment` is the row number in the first table of fragments. Without such a table,
   !! fragments are connected parts of the material.
   subroutine particles_take_fragments(self, fragments)
      class(stream_particles_t), intent(inout) :: self
      type(fragments_t), intent(in) :: fragments     !! Definition of that table

      self%fragments = fragments
   end subroutine particles_take_fragments

   !> Expected number of files with all particles.
   pure real(wp) function particles_full_snapshots(self, time_end) result(number)
      class(stream_particles_t), intent(in) :: self
      real(wp), intent(in) :: time_end               !! End of the run [s]

      number = self%schedule%expected(time_end, 0.0_wp)
   end function particles_full_snapshots

   !> Write a snapshot. Collective.
   subroutine particles_write_file(self, simulation, path, header, error)
      class(stream_particles_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      character(len=*), intent(in) :: path
      type(snapshot_header_t), intent(in) :: header  !! Description and time of the snapshot
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      type(labels_t), allocatable :: labels(:)

      if (any(self%fields == "fragment")) then
         call separate_bodies_in_contact(simulation, self%fragments)
         call fragment_labels(simulation%machine%communicator, simulation%space%grid, &
            simulation%space%tiles%coordinate(:, :simulation%space%tiles%own), &
            simulation%stores, self%fragments, labels)
      end if
      call snapshot_write(simulation%machine%communicator, path, simulation%stores, self%fields, &
         self%format, header, error, labels)
   end subroutine particles_write_file

   !> Expected size of a file [byte].
   pure real(wp) function particles_bytes_of_file(self, particles) result(bytes)
      class(stream_particles_t), intent(in) :: self
      integer(int64), intent(in) :: particles        !! Number of particles in all bodies

      bytes = real(particles, wp)*snapshot_bytes
   end function particles_bytes_of_file
end module stream_particles
