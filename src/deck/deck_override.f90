! SPDX-License-Identifier: BSD-3-Clause
!> Applies the options `--set GROUP.KEY=VALUE`, which replaces a value of the deck, and `--unset
!! GROUP.KEY`, which removes it.
module deck_override
   use base_text, only: append, join, lower, number, text_t
   use deck_define, only: definitions_t, scan_value
   use deck_fill, only: start_group, store
   use deck_group_values, only: group_t
   use deck_namelist, only: piece_t
   use deck_problems, only: command_line, problems_t
   use deck_schema, only: group_rule_t, kind_text, schema_t
   use deck_schema_text, only: unknown_group, unknown_key
   use deck_value, only: value_t
   implicit none
   private

   public :: override, removal_mark, split_assignment

   !> Character before the GROUP.KEY that `--unset` removes.
   character(len=1), parameter :: removal_mark = "!"

contains

   !> Apply one `--set` or `--unset` of the command line to the groups.
   subroutine override(schema, text, definitions, system, problems, groups, filled)
      type(schema_t), intent(in) :: schema               !! Allowed values
      !> GROUP.KEY=VALUE or GROUP[NAME].KEY=VALUE; or, after `removal_mark`, the key to remove
      character(len=*), intent(in) :: text
      type(definitions_t), intent(in) :: definitions     !! Names in expressions
      integer, intent(in) :: system                      !! Units of the numbers
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: groups(:)          !! All groups, with capacity for one more
      integer, intent(inout) :: filled                   !! Number of groups
      character(len=:), allocatable :: choice, group, key, value
      integer :: place, rule, which
      type(value_t) :: empty
      logical :: removes

      removes = index(text, removal_mark) == 1
      if (removes) then
         call split_assignment(text(2:)//"=", group, choice, key, value)
      else
         call split_assignment(text, group, choice, key, value)
      end if
      if (removes .and. (key == "" .or. scan(text, "=") > 0)) then
         call problems%error(command_line, 0, text(2:)//"  <- --unset expects GROUP.KEY [C102]")
         return
      else if (key == "") then
         call problems%error(command_line, 0, text//"  <- expects GROUP.KEY=VALUE [C102]")
         return
      end if
      if (group == "define") then
         ! values of definitions are already replaced
         if (removes) call problems%error(command_line, 0, "&define: "//key// &
            " cannot be removed; --set gives it another value [C102]")
         return
      end if
      rule = schema%find(group)
      if (rule == 0) then
         call problems%error(command_line, 0, unknown_group(schema, group))
         return
      end if
      place = schema%groups(rule)%find(key(:index(key//"(", "(") - 1))
      if (place == 0) then
         call problems%error(command_line, 0, unknown_key(schema, schema%groups(rule), key))
         return
      end if
      call choose(schema%groups(rule), choice, problems, groups, filled, which)
      if (which == 0) return
      if (removes) then
         if (.not. groups(which)%values(place)%given) call problems%warning(command_line, 0, &
            "&"//group//": "//key//" is not given, so --unset changes nothing [C102]")
         ! not by a constructor: gfortran 12 loses the length of the name
         empty%key = schema%groups(rule)%keys(place)%name
         groups(which)%values(place) = empty
         return
      end if
      call put(schema%groups(rule), place, key, value, definitions, system, &
         problems, groups(which))
   end subroutine override

   !> Split GROUP[CHOICE].KEY=VALUE into its parts. The key is empty if the text does not have this
   !! form.
   pure subroutine split_assignment(text, group, choice, key, value)
      character(len=*), intent(in) :: text               !! Text as written
      character(len=:), allocatable, intent(out) :: group  !! Lower case
      character(len=:), allocatable, intent(out) :: choice !! Text in brackets
      character(len=:), allocatable, intent(out) :: key    !! Lower case
      character(len=:), allocatable, intent(out) :: value  !! Text as written
      integer :: bracket, closing, dot, equals

      group = ""
      choice = ""
      key = ""
      value = ""
      bracket = scan(text//".", "[.")
      closing = bracket
      if (text(bracket:min(bracket, len(text))) == "[") then
         closing = index(text, "]")
         if (closing < bracket) return
         choice = trim(adjustl(text(bracket + 1:closing - 1)))
         closing = closing + 1
      end if
      dot = closing
      if (dot > len(text)) return
      if (text(dot:dot) /= ".") return
      equals = index(text(dot:), "=") + dot - 1
      if (equals < dot) return
      group = lower(trim(adjustl(text(:bracket - 1))))
      if (group == "") return
      key = lower(trim(adjustl(text(dot + 1:equals - 1))))
      value = trim(adjustl(text(equals + 1:)))
   end subroutine split_assignment

   !> Find the selected group; a group that may be given once is created if it is absent.
   subroutine choose(rule, choice, problems, groups, filled, which)
      type(group_rule_t), intent(in) :: rule             !! Allowed values
      character(len=*), intent(in) :: choice             !! Name or number in brackets, or empty
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: groups(:)          !! All groups
      integer, intent(inout) :: filled                   !! Number of groups
      integer, intent(out) :: which                      !! Index of the group, 0 if there is none
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: name
      integer :: i, total

      which = 0
      total = 0
      allocate (names(filled))
      do i = 1, filled
         if (groups(i)%group /= rule%name) cycle
         total = total + 1
         call groups(i)%get("name", name)
         if (name == "") name = number(total)
         names(total)%text = name
         if (choice == "" .or. choice == name .or. choice == number(total)) which = i
         if (choice /= "" .and. choice == name) exit
      end do
      if (rule%many .and. choice == "" .and. total > 1) then
         which = 0
         call problems%error(command_line, 0, "&"//rule%name// &
            ": write which one is meant, such as "// &
            rule%name//"["//names(1)%text//"]; there are: "//join(names(:total), ", ")//" [C111]")
      else if (which == 0 .and. rule%many) then
         call problems%error(command_line, 0, "no &"//rule%name//" '"//choice//"'; there are: "// &
            join(names(:total), ", ")//" [C103]")
      else if (which == 0) then
         filled = filled + 1
         which = filled
         call start_group(rule, 1, groups(which))
         groups(which)%path = command_line
         groups(which)%present = .true.
      end if
   end subroutine choose

   !> Replace the value of a key.
   subroutine put(rule, place, key, value, definitions, system, problems, group)
      type(group_rule_t), intent(in) :: rule             !! Allowed values
      integer, intent(in) :: place                       !! Index of the key
      character(len=*), intent(in) :: key                !! The key with its subscript
      character(len=*), intent(in) :: value              !! Text as written
      type(definitions_t), intent(in) :: definitions     !! Names in expressions
      integer, intent(in) :: system                      !! Units of the numbers
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: group              !! Gets the value
      type(piece_t) :: piece
      type(text_t), allocatable :: parts(:)
      integer :: comma, first, i

      piece%key = rule%keys(place)%name
      piece%subscript = key(index(key//"(", "("):)
      if (rule%keys(place)%kind == kind_text .and. scan(value, "'""") == 0) then
         ! texts without quotes, with commas between them where there may be several
         allocate (parts(0))
         first = 1
         do
            comma = first + index(value(first:)//",", ",") - 1
            if (rule%keys(place)%number_of_values == 1) comma = len(value) + 1
            call append(parts, trim(adjustl(value(first:comma - 1))))
            first = comma + 1
            if (first > len(value)) exit
         end do
         allocate (piece%tokens(size(parts)))
         do i = 1, size(parts)
            piece%tokens(i)%raw = parts(i)%text
            piece%tokens(i)%text = parts(i)%text
            piece%tokens(i)%quoted = .true.
         end do
      else
         call scan_value(value, piece)
      end if
      if (piece%broken) then
         call problems%error(command_line, 0, "&"//rule%name//": "//key//" = "//value// &
            "  <- is not a value [C104]")
      else
         call definitions%resolve("&"//rule%name, command_line, piece, problems, &
            rule%keys(place)%kind == kind_text .and. rule%keys(place)%unit_text /= "")
      end if
      if (piece%broken) then
         continue
      else if (piece%subscript == "") then
         if (allocated(group%values(place)%filled)) group%values(place)%filled = .false.
         group%values(place)%valid = .true.
      end if
      call store(rule, place, piece, command_line, system, problems, group)
   end subroutine put
end module deck_override
