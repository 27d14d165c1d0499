! SPDX-License-Identifier: BSD-3-Clause
!> Differences between the deck of a checkpoint and that of the run that restarts from it.
!!
!! The echoes of both are compared, so a changed default is found too, and a checkpoint of an older
!! version can be compared.
module deck_changes
   use base_text, only: append, number_text => number, shortened, text_t
   use deck_key_rules, only: change_rule_t, changes_end, changes_extent, changes_nothing, &
      changes_physics, find_change, group_added, group_removed
   use deck_schema, only: kind_real, schema_t
   implicit none
   private

   public :: changes_t, compare_decks, echo_streams

   integer, parameter :: shown = 40                      !! Characters of a value in a message
   integer, parameter :: key_indent = 3                  !! Blanks before a key in an echo
   character(len=*), parameter :: default_mark = "! default"
   character(len=*), parameter :: not_given = "not given"

   !> One key of an echo.
   type :: echo_entry_t
      character(len=:), allocatable :: key
      character(len=:), allocatable :: value             !! Its values in SI, as in the echo
      logical :: default = .false.                       !! Not given in the deck
   end type echo_entry_t

   !> One group of an echo.
   type :: echo_group_t
      character(len=:), allocatable :: kind              !! Name in the deck, without &
      character(len=:), allocatable :: label             !! Unique in the echo, for messages
      integer :: count = 0                               !! Keys
      type(echo_entry_t), allocatable :: entries(:)           !! The keys; longer than `count`
   end type echo_group_t

   !> All groups of an echo.
   type :: echo_groups_t
      integer :: count = 0                               !! Groups
      type(echo_group_t), allocatable :: group(:)             !! The groups; longer than `count`
   end type echo_groups_t

   !> The differences, one line per key, by class of the change.
   type :: changes_t
      character(len=:), allocatable :: refused           !! Keys that may not change
      character(len=:), allocatable :: physics           !! Keys that change the rest of the run
      character(len=:), allocatable :: end               !! Keys that change its end
      character(len=:), allocatable :: extent            !! Keys that change its files and limits
      character(len=:), allocatable :: nothing           !! Keys that change no result
   contains
      procedure :: state => changes_results              !! Will results differ?
   end type changes_t

contains

   !> Compare the echo of a checkpoint with that of this run.
   pure subroutine compare_decks(old, new, schema, changes)
      character(len=*), intent(in) :: old                !! Echo of the checkpoint
      character(len=*), intent(in) :: new                !! Echo of this run
      type(schema_t), intent(in) :: schema               !! Declares what may change
      type(changes_t), intent(out) :: changes            !! The keys that differ
      type(echo_groups_t) :: was, is
      integer :: n, other

      changes%refused = ""
      changes%physics = ""
      changes%end = ""
      changes%extent = ""
      changes%nothing = ""
      if (old == new) return
      call read_echo(old, was)
      call read_echo(new, is)
      do n = 1, is%count
         other = index_of_group(was, is%group(n)%label)
         if (other == 0) then
            call add_line(changes, schema, is%group(n), group_added, &
               is%group(n)%label//" is new")
         else
            call compare_groups(was%group(other), is%group(n), schema, changes)
         end if
      end do
      do n = 1, was%count
         if (index_of_group(is, was%group(n)%label) == 0) call add_line(changes, schema, &
            was%group(n), group_removed, was%group(n)%label//" is gone")
      end do
   end subroutine compare_decks

   !> Output streams of a deck.
   pure subroutine echo_streams(echo, name, kind, number)
      character(len=*), intent(in) :: echo               !! All keys of the deck
      type(text_t), allocatable, intent(out) :: name(:)  !! (stream) Names
      type(text_t), allocatable, intent(out) :: kind(:)  !! (stream) Words of the key `kind`
      integer, allocatable, intent(out) :: number(:)     !! (stream) Number among those of its kind
      type(echo_groups_t) :: groups
      integer :: alike, earlier, n

      allocate (name(0), kind(0), number(0))
      call read_echo(echo, groups)
      do n = 1, groups%count
         if (groups%group(n)%kind /= "output") cycle
         call append(name, plain_value(groups%group(n), "name"))
         call append(kind, plain_value(groups%group(n), "kind"))
         alike = 0
         do earlier = 1, size(kind)
            if (kind(earlier)%text == kind(size(kind))%text) alike = alike + 1
         end do
         number = [number, alike]
      end do
   end subroutine echo_streams

   !> Value of a key with one text, without its quotes; empty if the group lacks the key.
   pure function plain_value(group, key) result(value)
      type(echo_group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: value
      integer :: place

      value = ""
      place = index_of_key(group, key)
      if (place == 0) return
      associate (text => group%entries(place)%value)
         if (len(text) > 1) value = text(2:len(text) - 1)
      end associate
   end function plain_value

   !> True if results before the end depend on one of the keys that differ.
   pure logical function changes_results(self) result(state)
      class(changes_t), intent(in) :: self               !! The keys that differ

      state = len(self%refused) + len(self%physics) + len(self%extent) > 0
   end function changes_results

   !> Compare the keys of a group that both decks have.
   pure subroutine compare_groups(was, is, schema, changes)
      type(echo_group_t), intent(in) :: was                   !! Value in the checkpoint
      type(echo_group_t), intent(in) :: is                    !! Value in this run
      type(schema_t), intent(in) :: schema               !! Declares what may change
      type(changes_t), intent(inout) :: changes          !! Gets the keys that differ
      integer :: n, other

      do n = 1, is%count
         other = index_of_key(was, is%entries(n)%key)
         if (other == 0) then
            ! a difference of defaults follows from another key, which is reported itself
            if (.not. is%entries(n)%default) call add_key(changes, schema, is, is%entries(n)%key, &
               not_given, is%entries(n)%value)
         else if (was%entries(other)%value /= is%entries(n)%value) then
            call add_key(changes, schema, is, is%entries(n)%key, &
               was%entries(other)%value, is%entries(n)%value)
         end if
      end do
      do n = 1, was%count
         if (was%entries(n)%default) cycle
         if (index_of_key(is, was%entries(n)%key) == 0) call add_key(changes, schema, &
            is, was%entries(n)%key, was%entries(n)%value, not_given)
      end do
   end subroutine compare_groups

   !> Record a key that differs.
   pure subroutine add_key(changes, schema, group, key, old, new)
      type(changes_t), intent(inout) :: changes          !! Gets a line
      type(schema_t), intent(in) :: schema               !! Declares what may change
      type(echo_group_t), intent(in) :: group                 !! Group of the key
      character(len=*), intent(in) :: key
      character(len=*), intent(in) :: old                !! Value of the checkpoint
      character(len=*), intent(in) :: new                !! Value of this run

      call add_line(changes, schema, group, key, group%label//" "//key//" = "// &
         shortened(new, shown)//", was "//shortened(old, shown))
   end subroutine add_key

   !> Add a line to the list of its class.
   pure subroutine add_line(changes, schema, group, key, line)
      type(changes_t), intent(inout) :: changes          !! Gets the line
      type(schema_t), intent(in) :: schema               !! Declares what may change
      type(echo_group_t), intent(in) :: group            !! Group of the key
      character(len=*), intent(in) :: key                !! Key, `group_added` or `group_removed`
      character(len=*), intent(in) :: line               !! Differences
      character(len=:), allocatable :: text
      type(change_rule_t) :: rule

      text = new_line("a")//"  &"//line
      call find_rule(schema, group, key, rule)
      select case (rule%meaning)
      case (changes_nothing)
         changes%nothing = changes%nothing//text
      case (changes_end)
         changes%end = changes%end//text
      case (changes_extent)
         changes%extent = changes%extent//text
      case (changes_physics)
         changes%physics = changes%physics//text
      case default
         changes%refused = changes%refused//text//": "//rule%why
      end select
   end subroutine add_line

   !> What the schema declares about the change of a key. A key that it lacks must not change.
   pure subroutine find_rule(schema, group, key, rule)
      type(schema_t), intent(in) :: schema
      type(echo_group_t), intent(in) :: group            !! Group of the key
      character(len=*), intent(in) :: key                !! Key, `group_added` or `group_removed`
      type(change_rule_t), intent(out) :: rule
      type(text_t), allocatable :: given(:)
      integer :: n, place(2)
      logical :: is_number

      rule%why = "this version has no such key"
      place = [schema%find(group%kind), 0]
      if (place(1) == 0) return
      is_number = .false.
      if (key /= group_added .and. key /= group_removed) then
         place(2) = schema%groups(place(1))%find(key)
         if (place(2) == 0) return
         is_number = schema%groups(place(1))%keys(place(2))%kind == kind_real
      end if
      allocate (given(0))
      do n = 1, group%count
         call append(given, group%entries(n)%key)
      end do
      call find_change(schema%groups(place(1))%changes, key, is_number, given, rule)
   end subroutine find_rule

   !> Index of a group, 0 if there is none of that label.
   pure integer function index_of_group(groups, label) result(place)
      type(echo_groups_t), intent(in) :: groups
      character(len=*), intent(in) :: label

      do place = groups%count, 1, -1
         if (groups%group(place)%label == label) return
      end do
   end function index_of_group

   !> Index of a key, 0 if there is none of that name.
   pure integer function index_of_key(group, key) result(place)
      type(echo_group_t), intent(in) :: group
      character(len=*), intent(in) :: key

      do place = group%count, 1, -1
         if (group%entries(place)%key == key) return
      end do
   end function index_of_key

   !> Parse an echo. deck_echo_text defines its form: the name and the end of a group are separate
   !! lines, keys are indented by three blanks, continuation lines of long lists by more.
   pure subroutine read_echo(text, groups)
      character(len=*), intent(in) :: text
      type(echo_groups_t), intent(out) :: groups              !! Content
      integer :: first, last, n, name, earlier, alike

      allocate (groups%group(8))
      first = 1
      do while (first <= len(text))
         last = first + index(text(first:), new_line("a")) - 2
         if (last < first - 1) last = len(text)
         if (last >= first) call read_line(text(first:last), groups)
         first = last + 2
      end do
      ! groups are labelled by their name if they have one, else by their number within their kind
      do n = 1, groups%count
         associate (group => groups%group(n))
            name = index_of_key(group, "name")
            alike = 0
            do earlier = 1, n
               if (groups%group(earlier)%kind == group%kind) alike = alike + 1
            end do
            if (name > 0) then
               group%label = group%kind//" "//group%entries(name)%value
            else if (group%kind == "boundary" .or. alike > 1) then
               group%label = group%kind//"["//number_text(alike)//"]"
            else
               group%label = group%kind
            end if
         end associate
      end do
   end subroutine read_echo

   !> Parse one line of an echo.
   pure subroutine read_line(line, groups)
      character(len=*), intent(in) :: line               !! Not empty
      type(echo_groups_t), intent(inout) :: groups            !! Gets a group, a key, or more values
      type(echo_group_t), allocatable :: longer(:)
      integer :: indent, equals, mark
      character(len=:), allocatable :: rest
      logical :: continued, default
      type(echo_entry_t), allocatable :: more(:)
      character(len=:), allocatable :: value

      indent = verify(line//"x", " ") - 1
      if (line(1:1) == "&") then
         if (groups%count == size(groups%group)) then
            allocate (longer(2*groups%count))
            longer(:groups%count) = groups%group
            call move_alloc(longer, groups%group)
         end if
         groups%count = groups%count + 1
         groups%group(groups%count)%kind = trim(line(2:))
         allocate (groups%group(groups%count)%entries(8))
      else if (indent >= key_indent .and. groups%count > 0) then
         ! a key, or further values of the last one
         rest = line(indent + 1:)
         continued = indent > key_indent
         associate (group => groups%group(groups%count))
            mark = len_trim(rest) - len(default_mark) + 1
            default = .false.
            if (mark > 0) default = rest(mark:len_trim(rest)) == default_mark
            equals = 0
            if (.not. continued) equals = index(rest, " =")
            value = trim(adjustl(rest(merge(equals + 2, 1, equals > 0):merge(mark - 1, len(rest), &
               default))))
            if (continued) then
               if (group%count == 0) return
               group%entries(group%count)%value = group%entries(group%count)%value//" "//value
               group%entries(group%count)%default = default
               return
            end if
            if (equals == 0) return
            if (group%count == size(group%entries)) then
               allocate (more(2*group%count))
               more(:group%count) = group%entries
               call move_alloc(more, group%entries)
            end if
            group%count = group%count + 1
            ! gfortran 13 makes an empty component of a substring in a constructor
            group%entries(group%count)%key = rest(:equals - 1)
            group%entries(group%count)%value = value
            group%entries(group%count)%default = default
         end associate
      end if
   end subroutine read_line
end module deck_changes
