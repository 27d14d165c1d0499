! SPDX-License-Identifier: BSD-3-Clause
!> Rules of the keys of a deck: the range of a number, the conditions under which a key is accepted,
!! and whether a restart from a checkpoint may change it.
module deck_key_rules
   use base_kinds, only: wp
   use base_text, only: split, text_t
   implicit none
   private

   public :: change_rule_t, condition_t, find_change, holds, range_t, read_conditions, read_range

   integer, parameter, public :: change_undeclared = 0   !! Nothing is declared; not allowed
   integer, parameter, public :: may_not_change = 1      !! The state depends on the key
   integer, parameter, public :: changes_physics = 2     !! Physics of the rest of the run
   integer, parameter, public :: changes_end = 3         !! End of the run
   integer, parameter, public :: changes_extent = 4      !! Output and limits
   integer, parameter, public :: changes_nothing = 5     !! No result depends on it

   !> Names in rules of changes: all keys of a group, all its numbers, and a group that only one of
   !! the two decks has.
   character(len=*), parameter, public :: all_keys = "*", all_numbers = "#", group_added = "+", &
      group_removed = "-"

   !> Condition on another key under which a key is accepted.
   type :: condition_t
      character(len=:), allocatable :: group             !! Group of the other key
      character(len=:), allocatable :: key               !! The other key
      type(text_t), allocatable :: words(:)              !! Accepted values; empty: .true.
   end type condition_t

   !> Range of the numbers that a key allows.
   type :: range_t
      character(len=:), allocatable :: text              !! As declared, such as > 0 < 1
      real(wp) :: least = -huge(1.0_wp)                  !! Lower bound [SI]
      real(wp) :: most = huge(1.0_wp)                    !! Upper bound [SI]
      logical :: least_open = .false.                    !! The lower bound itself is out of range
      logical :: most_open = .false.                     !! The upper bound itself is out of range
      character(len=:), allocatable :: hint              !! Reason for the range, or empty
   end type range_t

   !> What follows from a change of a key between the deck of a checkpoint and that of a restart.
   type :: change_rule_t
      integer :: meaning = change_undeclared             !! One of the constants above
      character(len=:), allocatable :: key               !! Name, or one of those above
      character(len=:), allocatable :: why               !! Reason why it must not change
      character(len=:), allocatable :: without           !! Only in groups without this key
   end type change_rule_t

contains

   !> The rule for a key: that of its name, or that of the numbers of its group, or that of all keys
   !! of its group. Of several rules the last one applies.
   pure subroutine find_change(rules, key, is_number, given, rule)
      type(change_rule_t), intent(in) :: rules(:)        !! Rules of the group
      character(len=*), intent(in) :: key                !! Name, `group_added` or `group_removed`
      logical, intent(in) :: is_number                   !! Has the key numbers as values?
      type(text_t), intent(in) :: given(:)               !! Names of the keys of the group
      type(change_rule_t), intent(out) :: rule
      integer :: n, rank, best

      rule = change_rule_t(change_undeclared, key, "", "")
      best = 0
      do n = 1, size(rules)
         rank = 0
         if (rules(n)%key == all_keys .and. key /= group_added .and. key /= group_removed) rank = 1
         if (rules(n)%key == all_numbers .and. is_number) rank = 2
         if (rules(n)%key == key) rank = 3
         if (rank == 0 .or. rank < best) cycle
         if (len(rules(n)%without) > 0) then
            if (holds(given, rules(n)%without)) cycle
         end if
         best = rank
         rule = rules(n)
      end do
   end subroutine find_change

   !> True if a word is in a list.
   pure logical function holds(list, word) result(found)
      type(text_t), intent(in) :: list(:)
      character(len=*), intent(in) :: word               !! Word to find
      integer :: i

      found = .false.
      do i = 1, size(list)
         found = found .or. list(i)%text == word
      end do
   end function holds

   !> Parse a range such as >= 0 < 1.
   pure subroutine read_range(text, range, known)
      character(len=*), intent(in) :: text               !! One or two signs with a number
      type(range_t), intent(inout) :: range              !! Gets the bounds
      logical, intent(out) :: known                      !! Are the numbers readable?
      integer :: at, i, last, status
      real(wp) :: bound
      logical :: closed

      known = .true.
      range%text = text
      at = 1
      do i = 1, 2
         at = at + verify(text(at:)//"x", " ") - 1
         if (at >= len(text)) exit
         closed = text(at + 1:at + 1) == "="
         last = at + scan(text(at + 1:)//"<", "<>") - 1
         read (text(at + merge(2, 1, closed):last), *, iostat=status) bound
         known = known .and. status == 0
         if (text(at:at) == ">") then
            range%least = bound
            range%least_open = .not. closed
         else
            range%most = bound
            range%most_open = .not. closed
         end if
         at = last + 1
      end do
   end subroutine read_range

   !> Parse conditions such as `strength_model = mu_i & effects.thermal`.
   pure subroutine read_conditions(text, group, conditions)
      character(len=*), intent(in) :: text               !! Conditions with & between them
      character(len=*), intent(in) :: group              !! Group of keys without a group
      type(condition_t), allocatable, intent(inout) :: conditions(:) !! Extended
      type(condition_t), allocatable :: longer(:)
      type(condition_t) :: condition
      character(len=:), allocatable :: name, part
      integer :: dot, equals, first, last

      first = 1
      do while (first <= len(text))
         last = first + index(text(first:)//"&", "&") - 2
         part = trim(adjustl(text(first:last)))
         equals = index(part//"=", "=")
         name = trim(part(:equals - 1))
         call split(part(equals + 1:), condition%words)
         dot = index(name, ".")
         condition%group = group
         if (dot > 0) condition%group = name(:dot - 1)
         condition%key = name(dot + 1:)
         allocate (longer(size(conditions) + 1))
         longer(:size(conditions)) = conditions
         longer(size(longer)) = condition
         call move_alloc(longer, conditions)
         first = last + 2
      end do
   end subroutine read_conditions
end module deck_key_rules
