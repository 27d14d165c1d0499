! SPDX-License-Identifier: BSD-3-Clause
!> Names of the fields that streams of output hold, checked one by one, so that each wrong one is
!! reported, and as far as they can be checked in a deck that has other errors.
module output_field_names
   use base_deck, only: deck_t, group_t
   use base_error, only: error_t
   use base_text, only: text_t
   use io_fields, only: choose_columns, column_t
   use io_means, only: choose_means, mean_t
   use io_stream_names, only: of_bins, of_cells, of_fragments, of_ledger, stream_kind
   use output_history, only: choose_history, history_columns_t
   use particle_store, only: store_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_field_names, read_fields

   !> In messages on a name that no scene has.
   character(len=*), parameter :: unknown = "is unknown"

contains

   !> Names of the fields of a stream that the scene has; each of the others is an error.
   subroutine read_fields(group, deck, simulation, kind, fields)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects complaints
      type(simulation_t), intent(inout) :: simulation !! Its stores hold the fields; not changed
      integer, intent(in) :: kind                    !! A constant of io_stream_names
      character(len=64), allocatable, intent(out) :: fields(:) !! Names, or "default"
      character(len=64), allocatable :: names(:)
      type(error_t), allocatable :: error
      integer :: n

      call list_fields(group, names)
      allocate (fields(0))
      do n = 1, size(names)
         call try_field(names(n), simulation, simulation%stores, kind, error)
         if (allocated(error)) then
            call deck%complain(group, error%message, "fields")
         else
            fields = [fields, names(n)]
         end if
      end do
   end subroutine read_fields

   !> Report names of fields that no scene has, in a deck whose errors keep its stores from being
   !! known. What fits the scene is then not checked.
   subroutine check_field_names(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! As far as it is built; not changed
      type(group_t) :: group
      type(store_t) :: none(0)
      character(len=:), allocatable :: word
      character(len=64), allocatable :: names(:)
      type(error_t), allocatable :: error
      integer :: kind, n, place

      do place = 1, deck%count("output")
         group = deck%group("output", place)
         call group%get("kind", word)
         kind = stream_kind(word)
         if (kind == 0 .or. kind == of_fragments) cycle
         call list_fields(group, names)
         do n = 1, size(names)
            call try_field(names(n), simulation, none, kind, error)
            if (.not. allocated(error)) cycle
            if (index(error%message, unknown) > 0) &
               call deck%complain(group, error%message, "fields")
         end do
      end do
   end subroutine check_field_names

   !> Names of the fields as in the deck.
   subroutine list_fields(group, fields)
      type(group_t), intent(in) :: group             !! The &output
      character(len=64), allocatable, intent(out) :: fields(:) !! Names, or "default"
      type(text_t), allocatable :: names(:)
      integer :: n

      call group%list("fields", names)
      allocate (fields(max(size(names), 1)))
      fields = "default"
      do n = 1, size(names)
         fields(n) = names(n)%text
      end do
   end subroutine list_fields

   !> Choose one field alone.
   subroutine try_field(field, simulation, stores, kind, error)
      character(len=*), intent(in) :: field          !! Its name
      type(simulation_t), intent(in) :: simulation   !! Grid, gravity, exact solution
      type(store_t), intent(inout) :: stores(:)      !! The particles, not changed
      integer, intent(in) :: kind                    !! A constant of io_stream_names
      type(error_t), allocatable, intent(out) :: error !! The field cannot be written
      type(column_t), allocatable :: columns(:)
      type(mean_t), allocatable :: means(:)
      type(history_columns_t) :: history

      select case (kind)
      case (of_cells, of_bins)
         call choose_means(stores, [field], kind == of_cells, means, error)
      case (of_ledger)
         call choose_history([field], allocated(simulation%effects%exact), simulation%space%grid, &
            allocated(simulation%effects%gravity), history, error)
      case default
         call choose_columns(stores, [field], columns, error)
      end select
   end subroutine try_field
end module output_field_names
