! SPDX-License-Identifier: BSD-3-Clause
!> Applies presets: values for the keys of a group that the deck does not give and that apply.
module deck_preset_lines
   use base_error, only: without_code
   use deck_check, only: applies
   use deck_group_values, only: group_t
   use deck_index, only: deck_index_t
   use deck_preset, only: preset_entry_t
   use deck_problems, only: problems_t
   use deck_schema, only: key_t, schema_t
   use deck_value, only: read_default, value_t
   implicit none
   private

   public :: apply_presets

contains

   !> Apply the presets of all groups. The words that choose models come first in a preset, so that
   !! the keys of these models apply.
   subroutine apply_presets(schema, index, problems, groups)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      type(deck_index_t), intent(in) :: index            !! Index of the groups
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: groups(:)          !! All groups, with their defaults
      character(len=:), allocatable :: name
      integer :: i, p, e

      if (.not. allocated(schema%presets)) return
      do i = 1, size(groups)
         if (.not. groups(i)%given("preset")) cycle
         call groups(i)%get("preset", name)
         do p = 1, size(schema%presets)
            if (schema%presets(p)%name /= name) cycle
            if (schema%presets(p)%group /= groups(i)%group) cycle
            do e = 1, size(schema%presets(p)%entries)
               call apply_entry(schema, index, schema%presets(p)%entries(e), i, problems, groups)
            end do
         end do
      end do
   end subroutine apply_presets

   !> Apply one value, unless the deck gives it.
   subroutine apply_entry(schema, index, entry, which, problems, groups)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      type(deck_index_t), intent(in) :: index            !! Index of the groups
      type(preset_entry_t), intent(in) :: entry
      integer, intent(in) :: which                       !! Index of the group
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), intent(inout) :: groups(:)          !! All groups
      type(key_t) :: key
      type(value_t) :: value
      character(len=:), allocatable :: problem, reason
      integer :: i, line, place, rule

      rule = schema%find(groups(which)%group)
      place = schema%groups(rule)%find(entry%key)
      line = groups(which)%line("preset")
      if (place == 0) then
         call problems%error(groups(which)%file("preset"), line, "the preset gives "// &
            entry%key//", which is not a key [D228]")
         return
      end if
      if (groups(which)%given(entry%key)) return
      do i = 1, size(entry%unless)
         if (groups(which)%given(entry%unless(i)%text)) return
      end do
      if (.not. switched_on(schema, index, entry%switch, groups)) return
      key = schema%groups(rule)%keys(place)
      if (.not. applies(schema, key, groups, index, which)) return
      key%default = entry%value
      call read_default(key, value, problem)
      reason = entry%key//" = "//entry%value
      if (problem /= "") call problems%error(groups(which)%file("preset"), line, &
         "the preset gives "//reason//without_code(problem)//" [D228]")
      value%given = .true.
      value%preset = .true.
      value%line = line
      value%file = groups(which)%file("preset")
      groups(which)%values(place) = value
   end subroutine apply_entry

   !> True if GROUP.KEY is .true. or empty.
   logical function switched_on(schema, group_index, switch, groups) result(on)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      type(deck_index_t), intent(in) :: group_index        !! Index of the groups
      character(len=*), intent(in) :: switch             !! GROUP.KEY or empty
      type(group_t), intent(in) :: groups(:)             !! All groups
      integer :: i, kind, dot

      on = switch == ""
      dot = index(switch, ".")
      if (on .or. dot == 0) return
      kind = schema%find(switch(:dot - 1))
      do i = 1, group_index%count(kind)
         if (on) return
         call groups(group_index%at(kind, i))%get(switch(dot + 1:), on)
      end do
   end function switched_on
end module deck_preset_lines
