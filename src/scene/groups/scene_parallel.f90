! SPDX-License-Identifier: BSD-3-Clause
!> The group &parallel: its keys, the conditions for moving tiles between ranks, and hints to the
!! MPI library for files.
module scene_parallel
   use base_text, only: append, text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_nothing, schema_t
   use step_load_balance, only: balancing_t
   implicit none
   private

   public :: check_parallel, declare_parallel, read_balancing, read_hints

   ! at least these lengths are allowed by Open MPI and MPICH
   integer, parameter :: longest_name = 35           !! Letters of the name of a hint
   integer, parameter :: longest_value = 255         !! Letters of its value

contains

   !> Declare &parallel.
   subroutine declare_parallel(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("parallel", &
         "distribution over ranks (load balancing); results do not depend on it")
      call schema%text("parallel", "balance", "load balancing: move tiles between ranks", &
         default="auto", words="auto never")
      call schema%integer("parallel", "balance_every", &
         "steps between two comparisons of the load of the ranks", default="25", range="> 0", &
         owner="balance = auto")
      call schema%real("parallel", "imbalance", "greatest over mean load above which tiles move", &
         default="1.1", range=">= 1", owner="balance = auto")
      call schema%text("parallel", "io_hints", "hints to the MPI library for files of "// &
         "several ranks: auto (by file system), none, or pairs name=value in addition to "// &
         "those of auto", &
         default="auto")
      call schema%allow_change("parallel", "*", changes_nothing)
   end subroutine declare_parallel

   !> Check the group.
   subroutine check_parallel(deck)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t) :: group
      character(len=:), allocatable :: text
      type(text_t), allocatable :: names(:), values(:)
      logical :: right

      group = deck%group("parallel")
      call group%get("io_hints", text)
      call split_hints(text, names, values, right)
      if (.not. right) call deck%add_error(group, "io_hints = '"//text// &
         "' must be 'auto', 'none', or pairs such as 'romio_cb_write=enable; cb_nodes=4' [D230]", &
         "io_hints")
   end subroutine check_parallel

   !> Read the hints of the deck.
   subroutine read_hints(deck, automatic, names, values)
      type(deck_t), intent(in) :: deck               !! After `check_parallel`
      logical, intent(out) :: automatic              !! Use those for the file system too
      type(text_t), allocatable, intent(out) :: names(:) !! Names of further hints
      type(text_t), allocatable, intent(out) :: values(:) !! Value of each
      type(group_t) :: group
      character(len=:), allocatable :: text
      logical :: right

      group = deck%group("parallel")
      call group%get("io_hints", text)
      automatic = text /= "none"
      call split_hints(text, names, values, right)
   end subroutine read_hints

   !> Split name=value; name=value. The words auto and none are no hints.
   pure subroutine split_hints(text, names, values, right)
      character(len=*), intent(in) :: text           !! Value of io_hints
      type(text_t), allocatable, intent(out) :: names(:) !! Names of the hints
      type(text_t), allocatable, intent(out) :: values(:) !! Value of each
      logical, intent(out) :: right                  !! All pairs are complete and short enough
      character(len=:), allocatable :: pair, rest
      integer :: equals, semicolon

      allocate (names(0), values(0))
      right = .true.
      if (text == "auto" .or. text == "none") return
      rest = text//";"
      do while (len(rest) > 0)
         semicolon = index(rest, ";")
         pair = trim(adjustl(rest(:semicolon - 1)))
         rest = rest(semicolon + 1:)
         if (pair == "" .and. rest == "" .and. size(names) > 0) exit
         equals = index(pair, "=")
         right = right .and. equals > 1 .and. equals < len(pair) .and. &
            equals - 1 <= longest_name .and. len(pair) - equals <= longest_value
         if (.not. right) return
         call append(names, trim(pair(:equals - 1)))
         call append(values, trim(adjustl(pair(equals + 1:))))
      end do
   end subroutine split_hints

   !> Read the group &parallel.
   subroutine read_balancing(deck, balancing)
      type(deck_t), intent(in) :: deck
      type(balancing_t), intent(out) :: balancing    !! When tiles move
      type(group_t) :: group
      character(len=:), allocatable :: word
      integer :: every

      group = deck%group("parallel")
      call group%get("balance", word)
      balancing%allowed = word == "auto"
      if (.not. balancing%allowed) return
      call group%get("balance_every", every)
      balancing%every = every
      call group%get("imbalance", balancing%tolerance)
   end subroutine read_balancing
end module scene_parallel
