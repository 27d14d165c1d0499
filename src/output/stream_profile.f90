! SPDX-License-Identifier: BSD-3-Clause
!> Output of a profile: a table of means over the particles in bins along an axis.
module stream_profile
   use base_error, only: error_t
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_field_names, only: declare_fields, read_fields
   use output_selection, only: declare_axis, declare_selection, read_axis, read_selection
   use output_stream, only: field_length
   use output_table_stream, only: heading_length, table_stream_t
   use particle_store, only: store_t
   use sample_means, only: choose_means, highest, in_bins, mean_t
   use sample_profile, only: profile_columns, profile_rows, profile_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_profile_t

   !> A profile.
   type, extends(table_stream_t) :: stream_profile_t
      type(profile_t) :: profile                     !! Bins, fields and particles
   contains
      procedure :: about => profile_about            !! For the help
      procedure :: ending => profile_ending          !! Suffix of file names
      procedure :: declare => profile_declare        !! Keys
      procedure :: read => profile_read              !! Read the keys
      procedure :: try_field => profile_try_field    !! Check a name
      procedure :: rows_of_time => profile_rows_of_time !! A row for each bin
      procedure :: list_columns => profile_list_columns !! Names of columns
      procedure :: has_one_row => profile_has_one_row    !! No
      procedure :: write_rows => profile_write_rows  !! Write the rows of a time
   end type stream_profile_t

contains

   !> For the help of `kind`.
   pure function profile_about(self) result(text)
      class(stream_profile_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "a table of means in bins along an axis"
   end function profile_about

   !> Suffix of the file name, after the case.
   pure function profile_ending(self) result(text)
      class(stream_profile_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_profile.csv"
   end function profile_ending

   !> Declare the keys of the kind.
   subroutine profile_declare(self, schema, kind)
      class(stream_profile_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call declare_fields(schema, kind)
      call declare_selection(schema, kind)
      call declare_axis(schema, kind)
      call schema%integer("output", "bins", &
         "number of bins of equal width over the length of the grid", default="100", &
         range="> 0 <= 10000", owner="kind = "//kind)
   end subroutine profile_declare

   !> Read the keys of the kind.
   subroutine profile_read(self, group, deck, simulation, shapes)
      class(stream_profile_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! For the names of its fields
      type(named_shape_t), intent(in) :: shapes(:)
      character(len=field_length), allocatable :: fields(:)
      type(error_t), allocatable :: error

      associate (profile => self%profile, grid => simulation%space%grid)
         call read_fields(group, deck, simulation, self, fields)
         ! read_fields has removed each invalid name
         call choose_means(simulation%stores, fields, in_bins, profile%means, error)
         call read_selection(group, deck, shapes, profile%rule)
         call read_axis(group, deck, grid, profile%axis)
         profile%lower = grid%lower(profile%axis)
         profile%upper = grid%upper(profile%axis)
         call group%get("bins", profile%bins)
         if (any(profile%means%weight == highest) .and. (profile%axis == 3 .or. &
            .not. grid%active(3))) call deck%add_error(group, "surface_height is a height "// &
            "along z and needs bins along x or y in a scene that has a z [D434]", "fields")
      end associate
   end subroutine profile_read

   !> Try one name of the key `fields`.
   subroutine profile_try_field(self, field, simulation, stores, error)
      class(stream_profile_t), intent(in) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      type(simulation_t), intent(in) :: simulation   !! Unused
      type(store_t), intent(in) :: stores(:)         !! Particles
      type(error_t), allocatable, intent(out) :: error !! The field has no mean
      type(mean_t), allocatable :: means(:)

      call choose_means(stores, [field], in_bins, means, error)
   end subroutine profile_try_field

   !> A row for each bin.
   pure real(wp) function profile_rows_of_time(self) result(rows)
      class(stream_profile_t), intent(in) :: self

      rows = real(self%profile%bins, wp)
   end function profile_rows_of_time

   !> Each time has several rows.
   pure logical function profile_has_one_row(self) result(has_one_row)
      class(stream_profile_t), intent(in) :: self

      has_one_row = .false.
   end function profile_has_one_row

   !> Names of the columns with units.
   subroutine profile_list_columns(self, columns)
      class(stream_profile_t), intent(in) :: self
      character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings

      columns = profile_columns(self%profile)
   end subroutine profile_list_columns

   !> Write the rows of the present time. Collective.
   subroutine profile_write_rows(self, simulation, error)
      class(stream_profile_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      real(wp), allocatable :: rows(:, :)

      call profile_rows(simulation%machine%communicator, simulation%space%grid, simulation%stores, &
         self%profile, rows)
      call self%table%rows(simulation%machine%communicator, [simulation%clock%time, &
         real(simulation%clock%step, wp)], &
         rows, error)
   end subroutine profile_write_rows
end module stream_profile
