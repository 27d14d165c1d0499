! SPDX-License-Identifier: BSD-3-Clause
!> Checks that follow from the schema alone: owners, required keys, names, references.
module deck_check
   use base_error, only: error_t, exit_internal, fail, without_code
   use base_text, only: append, closest, join, number, text_t
   use deck_group_values, only: group_t
   use deck_index, only: deck_index_t
   use deck_key_rules, only: condition_t
   use deck_problems, only: command_line, problems_t
   use deck_schema, only: key_t, kind_logical, schema_t
   use deck_value, only: read_default, value_t
   implicit none
   private

   public :: applies, check_groups, check_schema, label_of

contains

   !> Find mistakes of the program in the declarations.
   subroutine check_schema(schema, error)
      type(schema_t), intent(in) :: schema
      type(error_t), allocatable, intent(out) :: error   !! The first mistake
      type(value_t) :: value
      character(len=:), allocatable :: problem
      integer :: i, k, other, owner

      if (allocated(schema%fault)) then
         call fail(error, exit_internal, schema%fault)
         return
      end if
      do i = 1, size(schema%groups)
         do k = 1, size(schema%groups(i)%keys)
            associate (key => schema%groups(i)%keys(k))
               call read_default(key, value, problem)
               do owner = 1, size(key%owners)
                  other = schema%find(key%owners(owner)%group)
                  if (other > 0) other = schema%groups(other)%find(key%owners(owner)%key)
                  if (other == 0) problem = "owner"
               end do
               if (key%target /= "" .and. schema%find(key%target) == 0) problem = "target"
               if (problem == "") cycle
               call fail(error, exit_internal, "declaration of the deck: "//key%group//"."// &
                  key%name//": "//without_code(problem)//" [R124]")
               return
            end associate
         end do
      end do
   end subroutine check_schema

   !> Check all groups. Keys with an error do not cause follow-up errors.
   subroutine check_groups(schema, groups, index, deck_file, problems)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(group_t), intent(inout) :: groups(:)          !! All groups; unused keys are dropped
      type(deck_index_t), intent(in) :: index            !! Positions of groups and keys
      character(len=*), intent(in) :: deck_file          !! Name of the deck
      type(problems_t), intent(inout) :: problems        !! Collects errors
      integer :: i, k, rule
      logical :: unused
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: problem

      do i = 1, size(groups)
         rule = schema%find(groups(i)%group)
         if (.not. groups(i)%present) then
            ! a group that is not in the deck lacks its required keys
            if (allocated(names)) deallocate (names)
            allocate (names(0))
            do k = 1, size(schema%groups(rule)%keys)
               if (schema%groups(rule)%keys(k)%required .and. &
                  size(schema%groups(rule)%keys(k)%owners) == 0) call append(names, &
                  schema%groups(rule)%keys(k)%name)
            end do
            if (size(names) > 0) call problems%error(deck_file, 0, "&"//schema%groups(rule)%name// &
               " is missing; it must give "//join(names, ", ")//" [D303]")
            cycle
         end if
         do k = 1, size(schema%groups(rule)%keys)
            call check_key(schema, schema%groups(rule)%keys(k), k, groups, index, i, problems, &
               unused)
            ! a value that the command line made invalid is replaced by its default; keys that
            ! depend on it become invalid as well
            if (unused) then
               call read_default(schema%groups(rule)%keys(k), groups(i)%values(k), problem)
               groups(i)%values(k)%file = command_line
            end if
         end do
         if (schema%groups(rule)%find("name") > 0) call check_name(groups, index, i, problems)
      end do
   end subroutine check_groups

   !> Check one key of one group: does it apply, must it be given, is the name known?
   subroutine check_key(schema, key, place, groups, index, which, problems, unused)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(key_t), intent(in) :: key
      integer, intent(in) :: place                       !! Index
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(deck_index_t), intent(in) :: index            !! Positions of groups and keys
      integer, intent(in) :: which                       !! Index of the group
      type(problems_t), intent(inout) :: problems        !! Collects errors
      logical, intent(out) :: unused                     !! Switched off by the command line
      character(len=:), allocatable :: reason
      logical :: sure

      unused = .false.
      associate (group => groups(which), value => groups(which)%values(place))
         if (.not. value%valid) return
         call weigh(schema, key, groups, index, which, reason, sure, unused)
         unused = unused .and. sure .and. value%given .and. reason /= ""
         if (unused) unused = value%file /= command_line
         if (.not. sure) return
         if (unused) then
            call problems%warning(value%file, value%line, label_of(group)//": "//key%name//" "// &
               without_code(reason)//"; it is ignored, as the command line turned it off [D304]")
         else if (value%given .and. reason /= "") then
            call problems%error(value%file, value%line, label_of(group)//": "//key%name//" "// &
               reason)
         else if (key%required .and. reason == "" .and. value%count() == 0) then
            ! an incomplete group or an unknown preset might have set it
            if (.not. group%broken .and. group%valid(["preset"])) call problems%error( &
               group%path, group%first_line, label_of(group)//": "//key%name// &
               " must be given ("//key%doc//") [D301]")
         else if (key%target /= "" .and. value%given .and. reason == "") then
            call check_references(schema, key, groups, index, which, value, problems)
         end if
      end associate
   end subroutine check_key

   !> True if a key means something in its group.
   logical function applies(schema, key, groups, index, which) result(holds)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(key_t), intent(in) :: key
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(deck_index_t), intent(in) :: index            !! Positions of groups and keys
      integer, intent(in) :: which                       !! Index of the group
      character(len=:), allocatable :: reason
      logical :: sure

      call weigh(schema, key, groups, index, which, reason, sure)
      holds = reason == ""
   end function applies

   !> Why a key has no effect in its group; empty if it has one.
   subroutine weigh(schema, key, groups, index, which, reason, sure, commanded)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(key_t), intent(in) :: key
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(deck_index_t), intent(in) :: index            !! Positions of groups and keys
      integer, intent(in) :: which                       !! Index of the group
      character(len=:), allocatable, intent(out) :: reason !! Follows the name of the key
      logical, intent(out) :: sure                       !! False: depends on a key that is in error
      logical, intent(out), optional :: commanded !! Is it due to a value of the command line?
      integer :: i, other, owner, rule

      reason = ""
      sure = .true.
      if (present(commanded)) commanded = .false.
      do i = 1, size(key%owners)
         associate (condition => key%owners(i))
            other = which
            rule = schema%find(condition%group)
            if (condition%group /= key%group) other = index%at(rule, 1)
            if (other == 0) cycle
            owner = schema%groups(rule)%find(condition%key)
            sure = sure .and. groups(other)%values(owner)%valid
            ! an unknown preset might have set it
            if (.not. groups(other)%values(owner)%given) &
               sure = sure .and. groups(other)%valid(["preset"])
            call compare(schema%groups(rule)%keys(owner), condition, groups(other)%values(owner), &
               other == which, reason)
            if (reason == "") cycle
            if (present(commanded) .and. allocated(groups(other)%values(owner)%file)) &
               commanded = groups(other)%values(owner)%file == command_line
            return
         end associate
      end do
   end subroutine weigh

   !> Compare a value with a condition.
   subroutine compare(owner, condition, value, same_group, reason)
      type(key_t), intent(in) :: owner                   !! The key of the condition
      type(condition_t), intent(in) :: condition         !! Expected value
      type(value_t), intent(in) :: value                 !! Actual value
      logical, intent(in) :: same_group                  !! Is it in the group of the key?
      character(len=:), allocatable, intent(inout) :: reason !! Reason why the condition is false
      character(len=:), allocatable :: place, word
      integer :: i

      if (.not. value%valid) return
      place = ""
      if (.not. same_group) place = "&"//owner%group//" "
      if (owner%kind == kind_logical) then
         if (value%switches(1)) return
         if (same_group) then
            reason = "given but "//owner%name//" = .false. [D305]"
         else
            reason = "needs "//place//owner%name//" = .true. [D306]"
         end if
         return
      end if
      word = ""
      if (value%count() > 0) word = value%texts(1)%text
      do i = 1, size(condition%words)
         if (condition%words(i)%text == word) return
      end do
      if (word == "") then
         reason = "needs "//place//owner%name//" = '"//join(condition%words, "' or '")//"' [D304]"
      else
         reason = "given but "//place//owner%name//" = '"//word//"' does not use it [D304]"
      end if
   end subroutine compare

   !> Names must not be used twice.
   subroutine check_name(groups, index, which, problems)
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(deck_index_t), intent(in) :: index            !! Positions of groups and keys
      integer, intent(in) :: which                       !! Index of the group
      type(problems_t), intent(inout) :: problems        !! Collects errors
      integer :: first

      associate (group => groups(which))
         if (group%title == "") return
         first = index%named(groups, group%group, group%title)
         if (first == which) return
         call problems%error(group%file("name"), group%line("name"), label_of(group)// &
            ": the name is taken by the &"//group%group//" of "//groups(first)%path//":"// &
            number(groups(first)%first_line)//" [D116]")
      end associate
   end subroutine check_name

   !> Each name must be that of a group of the right kind, or the default. No error is reported if
   !! one of those groups has an invalid name.
   subroutine check_references(schema, key, groups, index, which, value, problems)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(key_t), intent(in) :: key
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(deck_index_t), intent(in) :: index            !! Positions of groups and keys
      integer, intent(in) :: which                       !! Index of the group
      type(value_t), intent(in) :: value
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: near
      integer :: i, k, kind

      kind = schema%find(key%target)
      if (.not. index%all_named(kind)) return
      do k = 1, value%count()
         associate (name => value%texts(k)%text)
            if (allocated(key%default)) then
               if (name == key%default) cycle
            end if
            if (index%named(groups, key%target, name) > 0) cycle
            allocate (names(index%count(kind)))
            do i = 1, size(names)
               names(i)%text = groups(index%at(kind, i))%title
            end do
            near = closest(name, names)
            if (near /= "") near = "; did you mean '"//near//"'?"
            if (size(names) == 0) near = "; there is no &"//key%target//" [D223]"
            if (size(names) > 0) near = "; defined: "//join(names, ", ")//near// &
               " [D222]"
            call problems%error(value%file, value%line, label_of(groups(which))//": no "// &
               key%target//" '"//name//"'"//near)
            deallocate (names)
         end associate
      end do
   end subroutine check_references

   !> Group and name for messages.
   pure function label_of(group) result(label)
      type(group_t), intent(in) :: group
      character(len=:), allocatable :: label

      label = "&"//group%group
      if (group%title /= "") label = label//" '"//group%title//"'"
   end function label_of
end module deck_check
