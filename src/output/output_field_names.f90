! SPDX-License-Identifier: BSD-3-Clause
!> The key `fields` of &output. Each name is checked, so that all wrong names are reported.
module output_field_names
   use base_error, only: error_t
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_stream, only: field_length, stream_t
   use particle_store, only: store_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_field_names, declare_fields, read_fields

   !> In messages on a name that no scene has.
   character(len=*), parameter :: unknown = "is unknown"

contains

   !> Declare the key.
   subroutine declare_fields(schema, kind)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the key
      character(len=*), intent(in) :: kind           !! Word of the kind of output

      if (.not. schema%extend_owner("output", "fields", kind)) call schema%text("output", &
         "fields(:40)", "field names, see scree --list fields; default: the usual fields; "// &
         "state: all fields needed to continue in another run", default="default", &
         owner="kind = "//kind)
   end subroutine declare_fields

   !> Names of the fields of a stream that the scene has; each of the others is an error.
   subroutine read_fields(group, deck, simulation, stream, fields)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Its stores hold the fields
      class(stream_t), intent(in) :: stream          !! Word of the kind of output
      character(len=field_length), allocatable, intent(out) :: fields(:) !! Names, or "default"
      character(len=field_length), allocatable :: names(:)
      type(error_t), allocatable :: error
      integer :: n

      call list_fields(group, names)
      allocate (fields(0))
      do n = 1, size(names)
         call stream%try_field(names(n), simulation, simulation%stores, error)
         if (allocated(error)) then
            call deck%add_error(group, error%message, "fields")
         else
            fields = [fields, names(n)]
         end if
      end do
   end subroutine read_fields

   !> Report names of fields that no scene has, in a deck with errors that leave the stores of the
   !! scene unknown. Whether a field fits the scene is then not checked.
   subroutine check_field_names(group, deck, simulation, stream)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Possibly incomplete after errors
      class(stream_t), intent(in) :: stream          !! Word of the kind of output
      type(group_t) :: material
      type(store_t) :: none(0)
      character(len=field_length), allocatable :: names(:)
      type(error_t), allocatable :: error
      integer :: n

      ! a library that could not be loaded declares fields too
      do n = 1, deck%count("material")
         material = deck%group("material", n)
         if (material%given("library")) return
      end do
      call list_fields(group, names)
      do n = 1, size(names)
         call stream%try_field(names(n), simulation, none, error)
         if (.not. allocated(error)) cycle
         if (index(error%message, unknown) > 0) call deck%add_error(group, error%message, "fields")
      end do
   end subroutine check_field_names

   !> Names of the fields as in the deck.
   subroutine list_fields(group, fields)
      type(group_t), intent(in) :: group             !! The &output
      character(len=field_length), allocatable, intent(out) :: fields(:) !! Names, or "default"
      type(text_t), allocatable :: names(:)
      integer :: n

      call group%list("fields", names)
      allocate (fields(max(size(names), 1)))
      fields = "default"
      do n = 1, size(names)
         fields(n) = names(n)%text
      end do
   end subroutine list_fields
end module output_field_names
