! SPDX-License-Identifier: BSD-3-Clause
!> Writes the resolved deck: all values that are used, in SI, to the last bit.
module deck_echo_text
   use base_text, only: buffer_t, number
   use deck_check, only: applies
   use deck_group_values, only: group_t
   use deck_index, only: deck_index_t
   use deck_schema, only: key_t, kind_integer, kind_logical, kind_real, schema_t
   use deck_value, only: value_t
   implicit none
   private

   public :: echo

   integer, parameter :: comment_column = 48             !! Column of comments after short lines
   integer, parameter :: longest_row = 100               !! Longer lists are broken

contains

   !> The groups as a deck.
   function echo(schema, groups, index) result(text)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(deck_index_t), intent(in) :: index            !! Index of the groups
      character(len=:), allocatable :: text
      type(buffer_t) :: buffer
      integer :: i, rule

      do rule = 1, size(schema%groups)
         if (size(schema%groups(rule)%keys) == 0) cycle
         do i = 1, index%count(rule)
            call echo_group(schema, rule, groups, index, index%at(rule, i), buffer)
         end do
      end do
      text = buffer%content()
   end function echo

   !> One group.
   subroutine echo_group(schema, rule, groups, index, which, buffer)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      integer, intent(in) :: rule                        !! Index of its rule
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(deck_index_t), intent(in) :: index            !! Index of the groups
      integer, intent(in) :: which                       !! Index of the group
      type(buffer_t), intent(inout) :: buffer            !! Extended by the text
      integer :: k

      call buffer%line("&"//schema%groups(rule)%name)
      do k = 1, size(schema%groups(rule)%keys)
         associate (key => schema%groups(rule)%keys(k), value => groups(which)%values(k))
            if (key%group == "units" .and. key%name == "system") then
               call buffer%line("   system = 'si'")
            else if (value%count() > 0) then
               if (applies(schema, key, groups, index, which)) call echo_key(key, value, buffer)
            end if
         end associate
      end do
      call buffer%line("/")
   end subroutine echo_group

   !> One key.
   subroutine echo_key(key, value, buffer)
      type(key_t), intent(in) :: key
      type(value_t), intent(in) :: value                 !! Value
      type(buffer_t), intent(inout) :: buffer            !! Extended by the text
      character(len=:), allocatable :: line, word
      integer :: i

      line = "   "//key%name//" ="
      do i = 1, value%count()
         select case (key%kind)
         case (kind_real)
            word = number(value%numbers(i))
         case (kind_integer)
            word = number(value%integers(i))
         case (kind_logical)
            word = ".false."
            if (value%switches(i)) word = ".true."
         case default
            word = "'"//doubled_quotes(value%texts(i)%text)//"'"
         end select
         if (i < value%count()) word = word//","
         if (len(line) + len(word) > longest_row .and. i > 1) then
            call buffer%line(line)
            line = "     "
         end if
         line = line//" "//word
      end do
      if (.not. value%given .or. value%derived) line = line// &
         repeat(" ", max(comment_column - len(line) - 1, 1))//"! default"
      call buffer%line(line)
   end subroutine echo_key

   !> A text with its quotes doubled.
   pure function doubled_quotes(text) result(more)
      character(len=*), intent(in) :: text               !! Text without quotes
      character(len=:), allocatable :: more
      integer :: i

      more = ""
      do i = 1, len(text)
         more = more//text(i:i)
         if (text(i:i) == "'") more = more//"'"
      end do
   end function doubled_quotes
end module deck_echo_text
