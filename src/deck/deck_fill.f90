! SPDX-License-Identifier: BSD-3-Clause
!> Fills groups with the values of a deck, and reports every unknown, repeated or wrong assignment.
module deck_fill
   use base_text, only: number, shortened
   use deck_define, only: definitions_t
   use deck_group_values, only: group_t
   use deck_namelist, only: as_written, block_t, namelist_t, piece_t, token_t
   use deck_problems, only: problems_t
   use deck_schema, only: group_rule_t, key_t, kind_integer, kind_logical, kind_real, kind_text, &
      schema_t
   use deck_schema_text, only: unknown_group, unknown_key
   use deck_value, only: convert, read_default, value_t
   implicit none
   private

   public :: fill_defaults, fill_groups, start_group, store, written

   integer, parameter :: longest_quotation = 60          !! Longer values are cut in messages

contains

   !> Make a group of each block of the deck.
   subroutine fill_groups(schema, namelist, definitions, system, problems, groups, filled)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(namelist_t), intent(in) :: namelist           !! Namelist to write
      type(definitions_t), intent(in) :: definitions     !! Names in expressions
      integer, intent(in) :: system                      !! Units of the numbers
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: groups(:)          !! Gets the groups
      integer, intent(inout) :: filled                   !! Number of groups so far
      integer, allocatable :: counts(:)
      integer :: i, rule

      allocate (counts(size(schema%groups)), source=0)
      do i = 1, namelist%count
         associate (block => namelist%blocks(i))
            if (block%name == "define") cycle
            rule = schema%find(block%name)
            if (rule == 0) then
               call problems%error(block%file, block%line, unknown_group(schema, block%name))
               cycle
            end if
            counts(rule) = counts(rule) + 1
            if (counts(rule) > 1 .and. .not. schema%groups(rule)%many) then
               call problems%error(block%file, block%line, "&"//block%name// &
                  " appears twice; only one is allowed [D115]")
               cycle
            end if
            filled = filled + 1
            call start_group(schema%groups(rule), counts(rule), groups(filled))
            call fill_group(schema, schema%groups(rule), block, definitions, system, problems, &
               groups(filled))
         end associate
      end do
   end subroutine fill_groups

   !> Make a group with all its keys and no values.
   subroutine start_group(rule, place, group)
      type(group_rule_t), intent(in) :: rule             !! Allowed keys
      integer, intent(in) :: place                       !! Number among the groups of its kind
      type(group_t), intent(out) :: group
      integer :: i

      group%group = rule%name
      group%title = ""
      group%path = ""
      group%place = place
      allocate (group%values(size(rule%keys)))
      do i = 1, size(rule%keys)
         group%values(i)%key = rule%keys(i)%name
      end do
   end subroutine start_group

   !> Store the assignments of a block in its group.
   subroutine fill_group(schema, rule, block, definitions, system, problems, group)
      type(schema_t), intent(in) :: schema               !! All groups, for a suggestion
      type(group_rule_t), intent(in) :: rule             !! Allowed keys
      type(block_t), intent(in) :: block                 !! Block of the deck
      type(definitions_t), intent(in) :: definitions     !! Names in expressions
      integer, intent(in) :: system                      !! Units of the numbers
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: group              !! Gets the values
      type(piece_t) :: resolved
      integer :: i, place

      group%present = .true.
      group%path = block%file
      group%first_line = block%line
      group%broken = block%broken
      do i = 1, size(block%pieces)
         associate (piece => block%pieces(i))
            place = rule%find(piece%key)
            if (piece%key == "") cycle
            if (place == 0) then
               call problems%error(block%file, piece%line, unknown_key(schema, rule, piece%key))
               cycle
            end if
            if (group%values(place)%given .and. piece%subscript == "") then
               call problems%error(block%file, piece%line, "&"//rule%name//": "//piece%key// &
                  " is given twice, first in line "//number(group%values(place)%line)//" [D114]")
               cycle
            end if
            resolved = piece
            call definitions%resolve("&"//rule%name, block%file, resolved, problems, &
               rule%keys(place)%kind == kind_text .and. rule%keys(place)%unit_text /= "")
            call store(rule, place, resolved, block%file, system, problems, group)
         end associate
      end do
   end subroutine fill_group

   !> Convert a piece and keep its value.
   subroutine store(rule, place, piece, file, system, problems, group)
      type(group_rule_t), intent(in) :: rule             !! Allowed values
      integer, intent(in) :: place                       !! Index of the key
      type(piece_t), intent(in) :: piece                 !! Part to write
      character(len=*), intent(in) :: file               !! File
      integer, intent(in) :: system                      !! Units of the numbers
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: group              !! Gets the value
      character(len=:), allocatable :: problem, hint
      integer :: subscript

      associate (key => rule%keys(place), value => group%values(place))
         value%given = .true.
         value%line = piece%line
         value%file = file
         if (piece%broken) then
            value%valid = .false.
            return
         end if
         subscript = number_in(piece%subscript)
         if (subscript < 0 .or. subscript > key%number_of_values) then
            value%valid = .false.
            call problems%error(file, piece%line, "&"//rule%name//": "//key%name// &
               piece%subscript//"  <- the subscript must be from 1 to "// &
               number(key%number_of_values)//" [D213]")
            return
         end if
         call convert(key, piece%tokens, subscript, system, value, problem)
         if (problem == "") return
         hint = lost_sign(rule, piece%tokens)//lost_braces(key, piece%tokens)// &
            decimal_comma(key, piece%tokens)
         call problems%error(file, piece%line, "&"//rule%name//": "//key%name//piece%subscript// &
            " = "//written(piece%tokens)//problem//hint)
      end associate
   end subroutine store

   !> The number in brackets, 0 without brackets, -1 for any other text in brackets.
   pure integer function number_in(subscript) result(place)
      character(len=*), intent(in) :: subscript          !! Such as (3), or empty
      integer :: status

      place = 0
      if (subscript == "") return
      place = -1
      if (len(subscript) < 3 .or. len(subscript) > 8) return
      if (verify(subscript(2:len(subscript) - 1), "0123456789 ") > 0) return
      read (subscript(2:len(subscript) - 1), *, iostat=status) place
      if (status /= 0 .or. place == 0) place = -1
   end function number_in

   !> A hint at the end of a message if one of the values is the name of a key.
   function lost_sign(rule, tokens) result(hint)
      type(group_rule_t), intent(in) :: rule             !! Allowed values
      type(token_t), intent(in) :: tokens(:)
      character(len=:), allocatable :: hint
      integer :: i

      hint = ""
      do i = 1, size(tokens)
         if (tokens(i)%quoted) cycle
         if (rule%find(tokens(i)%raw) == 0) cycle
         hint = "; is the = after "//tokens(i)%raw//" missing?"
         return
      end do
   end function lost_sign

   !> Hint for a message about numbers: missing braces, or the results of expressions.
   function lost_braces(key, tokens) result(hint)
      type(key_t), intent(in) :: key
      type(token_t), intent(in) :: tokens(:)
      character(len=:), allocatable :: hint
      character(len=*), parameter :: numeric = "+-.0123456789eEdD"
      integer :: i, star

      hint = ""
      if (key%kind /= kind_real .and. key%kind /= kind_integer) return
      do i = 1, size(tokens)
         if (tokens(i)%formula) hint = hint//"; "//tokens(i)%raw//" is "//tokens(i)%text
         if (tokens(i)%formula .or. tokens(i)%quoted .or. tokens(i)%comma .or. hint /= "") cycle
         associate (raw => tokens(i)%raw)
            star = scan(raw, "*(")
            if (star < 2 .or. star == len(raw)) cycle
            if (verify(raw(:star - 1), "0123456789") == 0 .and. &
               verify(raw(star + 1:), numeric) == 0) cycle
            hint = "; write expressions in braces: {"//raw//"}"
         end associate
      end do
   end function lost_braces

   !> Hint for a message about numbers that would be as many as the key has if the commas directly
   !! between two digits were decimal points.
   function decimal_comma(key, tokens) result(hint)
      type(key_t), intent(in) :: key
      type(token_t), intent(in) :: tokens(:)
      character(len=:), allocatable :: hint
      character(len=*), parameter :: digits = "0123456789"
      integer :: i, values

      hint = ""
      if (key%kind /= kind_real) return
      values = 0
      i = 1
      do while (i <= size(tokens))
         if (scan(tokens(i)%raw, digits) > 0) values = values + 1
         if (i + 2 <= size(tokens)) then
            if (tokens(i + 1)%comma .and. scan(tokens(i)%raw, digits, back=.true.) == &
               len(tokens(i)%raw) .and. scan(tokens(i + 2)%raw, digits) == 1 .and. &
               tokens(i + 2)%column == tokens(i)%column + len(tokens(i)%raw) + 1) then
               if (hint == "") hint = "; the decimal mark is a point: "//tokens(i)%raw//"."// &
                  tokens(i + 2)%raw
               i = i + 2
            end if
         end if
         i = i + 1
      end do
      if (values /= key%number_of_values) hint = ""
   end function decimal_comma

   !> The values as written, truncated if they are long.
   function written(tokens) result(text)
      type(token_t), intent(in) :: tokens(:)
      character(len=:), allocatable :: text

      text = shortened(as_written(tokens, longest_quotation), longest_quotation)
   end function written

   !> Give the default to all values that are not set, and report those that are required.
   subroutine fill_defaults(rule, problems, group)
      type(group_rule_t), intent(in) :: rule             !! Allowed values
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: group              !! Gets the values
      type(value_t) :: default
      character(len=:), allocatable :: problem
      integer :: i, missing, k, last

      do i = 1, size(rule%keys)
         associate (key => rule%keys(i), value => group%values(i))
            if (.not. value%valid) cycle
            if (value%given) then
               if (all(value%filled)) cycle
            end if
            call read_default(key, default, problem)
            if (.not. value%given) then
               value = default
               cycle
            end if
            if (allocated(key%default) .and. key%exact) call complete(key, default, value)
            ! the first value that is missing; without `exact` only those before the last are needed
            last = merge(size(value%filled), value%count(), key%exact)
            missing = 0
            do k = last, 1, -1
               if (.not. value%filled(k)) missing = k
            end do
            if (missing == 0) cycle
            value%valid = .false.
            call problems%error(value%file, value%line, "&"//rule%name//": "//key%name// &
               " has no value in place "//number(missing)//" [D224]")
         end associate
      end do
   end subroutine fill_defaults

   !> Set the values that are missing to the default.
   subroutine complete(key, default, value)
      type(key_t), intent(in) :: key
      type(value_t), intent(in) :: default
      type(value_t), intent(inout) :: value
      integer :: i

      do i = 1, key%number_of_values
         if (value%filled(i)) cycle
         select case (key%kind)
         case (kind_real)
            value%numbers(i) = default%numbers(i)
         case (kind_integer)
            value%integers(i) = default%integers(i)
         case (kind_logical)
            value%switches(i) = default%switches(i)
         case default
            value%texts(i) = default%texts(i)
         end select
         value%filled(i) = .true.
      end do
   end subroutine complete
end module deck_fill
