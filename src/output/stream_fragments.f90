! SPDX-License-Identifier: BSD-3-Clause
!> Output of fragments: a table with a row for each connected piece of material.
module stream_fragments
   use base_constants, only: unset
   use base_error, only: error_t
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_contact_groups, only: separate_bodies_in_contact
   use output_selection, only: declare_selection, read_selection
   use output_table_stream, only: heading_length, table_stream_t
   use sample_fragments, only: fragment_columns, fragment_rows, fragments_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_fragments_t

   !> A table of fragments.
   type, extends(table_stream_t) :: stream_fragments_t
      type(fragments_t) :: fragments !! Selection of particles, and the separation criterion
   contains
      procedure :: about => fragments_about          !! For the help
      procedure :: ending => fragments_ending        !! Suffix of file names
      procedure :: declare => fragments_declare      !! Keys
      procedure :: read => fragments_read            !! Read the keys
      procedure :: offer_fragments => fragments_offer !! For the field `fragment`
      procedure :: list_columns => fragments_list_columns !! Names of columns
      procedure :: has_one_row => fragments_has_one_row  !! No
      procedure :: write_rows => fragments_write_rows !! Write the rows of a time
   end type stream_fragments_t

contains

   !> For the help of `kind`.
   pure function fragments_about(self) result(text)
      class(stream_fragments_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "a table of fragments"
   end function fragments_about

   !> Suffix of the file name, after the case.
   pure function fragments_ending(self) result(text)
      class(stream_fragments_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_fragments.csv"
   end function fragments_ending

   !> Declare the keys of the kind.
   subroutine fragments_declare(self, schema, kind)
      class(stream_fragments_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call declare_selection(schema, kind)
      call schema%real("output", "velocity_cut", "neighbouring cells are separate fragments "// &
         "where their mean velocities differ by more; default: never", unit="m/s", range="> 0", &
         owner="kind = "//kind)
      call schema%text("output", "matter", &
         "material that counts as part of a fragment; intact: "// &
         "material that has not failed", default="all", words="all intact", owner="kind = "//kind)
   end subroutine fragments_declare

   !> Read the keys of the kind.
   subroutine fragments_read(self, group, deck, simulation, shapes)
      class(stream_fragments_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Unused
      type(named_shape_t), intent(in) :: shapes(:)
      character(len=:), allocatable :: word
      real(wp) :: velocity_cut

      call read_selection(group, deck, shapes, self%fragments%rule)
      call group%get("matter", word)
      self%fragments%rule%intact = word == "intact"
      call group%get("velocity_cut", velocity_cut)
      if (velocity_cut > unset) self%fragments%velocity_cut = velocity_cut
   end subroutine fragments_read

   !> Define the fragments of the field `fragment` of snapshots, unless an earlier stream has.
   subroutine fragments_offer(self, fragments)
      class(stream_fragments_t), intent(in) :: self
      type(fragments_t), allocatable, intent(inout) :: fragments

      if (.not. allocated(fragments)) fragments = self%fragments
   end subroutine fragments_offer

   !> Each time has several rows.
   pure logical function fragments_has_one_row(self) result(has_one_row)
      class(stream_fragments_t), intent(in) :: self

      has_one_row = .false.
   end function fragments_has_one_row

   !> Names of the columns with units.
   subroutine fragments_list_columns(self, columns)
      class(stream_fragments_t), intent(in) :: self
      character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings

      columns = fragment_columns()
   end subroutine fragments_list_columns

   !> Write the rows of the present time. Collective.
   subroutine fragments_write_rows(self, simulation, error)
      class(stream_fragments_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      real(wp), allocatable :: rows(:, :)

      call separate_bodies_in_contact(simulation, self%fragments)
      call fragment_rows(simulation%machine%communicator, simulation%space%grid, &
         simulation%space%tiles%coordinate(:, :simulation%space%tiles%own), simulation%stores, &
         self%fragments, rows)
      call self%table%rows(simulation%machine%communicator, [simulation%clock%time, &
         real(simulation%clock%step, wp)], &
         rows, error)
   end subroutine fragments_write_rows
end module stream_fragments
