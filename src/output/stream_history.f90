! SPDX-License-Identifier: BSD-3-Clause
!> Output of a history: a table with a row for each time, by default the whole ledger.
module stream_history
   use base_error, only: error_t
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_field_names, only: declare_fields, read_fields
   use output_history_columns, only: choose_history, history_columns_t, history_row
   use output_selection, only: declare_selection, read_selection
   use output_stream, only: field_length
   use output_table_stream, only: heading_length, table_stream_t
   use particle_store, only: store_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_history_t

   !> A history.
   type, extends(table_stream_t) :: stream_history_t
      type(history_columns_t) :: columns             !! Columns of a row
   contains
      procedure :: about => history_about            !! For the help
      procedure :: ending => history_ending          !! Suffix of file names
      procedure :: declare => history_declare        !! Keys
      procedure :: read => history_read              !! Read the keys
      procedure :: read_default => history_read_default !! Without &output
      procedure :: always_named => history_always_named !! Name of a file of some particles
      procedure :: default_count => history_default_count !! Rows without &output
      procedure :: try_field => history_try_field    !! Check a name
      procedure :: list_columns => history_list_columns !! Names of columns
      procedure :: write_rows => history_write_rows  !! Write a row
   end type stream_history_t

contains

   !> For the help of `kind`.
   pure function history_about(self) result(text)
      class(stream_history_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "a table of the ledger over time, or of mass, momentum and energy of bodies"
   end function history_about

   !> Suffix of the file name, after the case.
   pure function history_ending(self) result(text)
      class(stream_history_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_history.csv"
   end function history_ending

   !> Declare the keys of the kind.
   subroutine history_declare(self, schema, kind)
      class(stream_history_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call declare_fields(schema, kind)
      call declare_selection(schema, kind)
   end subroutine history_declare

   !> Read the keys of the kind.
   subroutine history_read(self, group, deck, simulation, shapes)
      class(stream_history_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Read for the names of fields
      type(named_shape_t), intent(in) :: shapes(:)
      character(len=field_length), allocatable :: fields(:)
      type(error_t), allocatable :: error

      call read_selection(group, deck, shapes, self%columns%rule)
      call read_fields(group, deck, simulation, self, fields)
      ! read_fields has removed each invalid name
      call choose_history(fields, allocated(simulation%effects%exact), simulation%space%grid, &
         allocated(simulation%effects%gravity), self%columns, error, has_free_bodies(simulation))
   end subroutine history_read

   !> Whether forces move rigid regions, so that the ledger has their momentum and energy.
   pure logical function has_free_bodies(simulation) result(has)
      type(simulation_t), intent(in) :: simulation

      has = allocated(simulation%space%rigid)
      if (has) has = simulation%space%rigid%responds()
   end function has_free_bodies

   !> Without &output the ledger is written.
   subroutine history_read_default(self, simulation)
      class(stream_history_t), intent(inout) :: self
      type(simulation_t), intent(in) :: simulation   !! For the columns that exist
      type(error_t), allocatable :: error

      call choose_history(["default"], allocated(simulation%effects%exact), simulation%space%grid, &
         allocated(simulation%effects%gravity), self%columns, error, has_free_bodies(simulation))
   end subroutine history_read_default

   !> The file of some of the particles always has the name of the stream: CASE_history.csv is the
   !! ledger.
   pure logical function history_always_named(self) result(always)
      class(stream_history_t), intent(in) :: self

      always = .not. self%columns%rule%takes_all()
   end function history_always_named

   !> Rows without &output.
   pure integer function history_default_count(self) result(number)
      class(stream_history_t), intent(in) :: self

      number = 100
   end function history_default_count

   !> Try one name of the key `fields`.
   subroutine history_try_field(self, field, simulation, stores, error)
      class(stream_history_t), intent(in) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      type(simulation_t), intent(in) :: simulation   !! Grid, gravity, exact solution
      type(store_t), intent(in) :: stores(:)         !! Unused
      type(error_t), allocatable, intent(out) :: error !! There is no such column
      type(history_columns_t) :: columns

      columns%rule = self%columns%rule
      call choose_history([field], allocated(simulation%effects%exact), simulation%space%grid, &
         allocated(simulation%effects%gravity), columns, error)
   end subroutine history_try_field

   !> Names of the columns with units.
   subroutine history_list_columns(self, columns)
      class(stream_history_t), intent(in) :: self
      character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings

      columns = self%columns%headings()
   end subroutine history_list_columns

   !> Write a row. Collective.
   subroutine history_write_rows(self, simulation, error)
      class(stream_history_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      real(wp), allocatable :: row(:)

      call history_row(simulation, self%columns, row)
      call self%table%row(simulation%machine%communicator, row, error)
   end subroutine history_write_rows
end module stream_history
