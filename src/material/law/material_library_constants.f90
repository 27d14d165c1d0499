! SPDX-License-Identifier: BSD-3-Clause
!> Constants of a law in a library: texts of the deck such as 'A = 90 MPa', with the names, units
!! and ranges that the library declares.
module material_library_constants
   use base_kinds, only: wp
   use base_text, only: append, closest, join, number, split, text_t
   use deck_group_values, only: group_t
   use deck_number, only: convert_number, item_t
   use deck_schema, only: key_t
   use deck_units, only: split_unit, system_si
   implicit none
   private

   public :: read_library_constants

   integer, parameter :: named = 8                   !! Constants that a message lists

contains

   !> Read library_constants. Each error is one text with its code.
   subroutine read_library_constants(keys, group, system, values, faults)
      type(key_t), intent(in) :: keys(:)             !! As the library declares them
      type(group_t), intent(in) :: group             !! &material
      integer, intent(in) :: system                  !! Units of the deck
      real(wp), allocatable, intent(out) :: values(:) !! In the order of the keys [SI]
      type(text_t), allocatable, intent(inout) :: faults(:) !! Extended
      type(text_t), allocatable :: texts(:)
      character(len=:), allocatable :: fault
      logical :: given(size(keys))
      integer :: n, place

      allocate (values(size(keys)), source=0.0_wp)
      given = .false.
      call group%list("library_constants", texts)
      do n = 1, size(texts)
         call read_one(keys, texts(n)%text, system, given, values, fault)
         if (fault /= "") call append(faults, fault)
      end do
      do place = 1, size(keys)
         if (given(place)) cycle
         if (allocated(keys(place)%default)) then
            call convert(keys(place), keys(place)%default, "", system_si, values(place), fault)
         else
            fault = "library_constants: '"//keys(place)%name//" = "//example(keys(place))// &
               "' must be given: "//keys(place)%doc//" [D376]"
         end if
         if (fault /= "") call append(faults, fault)
      end do
   end subroutine read_library_constants

   !> Read one text.
   subroutine read_one(keys, text, system, given, values, fault)
      type(key_t), intent(in) :: keys(:)             !! As the library declares them
      character(len=*), intent(in) :: text           !! Such as A = 90 MPa
      integer, intent(in) :: system                  !! Units of the deck
      logical, intent(inout) :: given(:)             !! Constants read before
      real(wp), intent(inout) :: values(:)           !! In the order of the keys [SI]
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      type(text_t), allocatable :: words(:)
      character(len=:), allocatable :: digits, name, unit
      integer :: equals, place

      fault = ""
      equals = index(text, "=")
      name = trim(adjustl(text(:max(equals - 1, 0))))
      call split(text(equals + 1:), words)
      if (equals < 2 .or. name == "" .or. size(words) == 0) then
         fault = "library_constants: '"//text//"' is not of the form 'NAME = NUMBER UNIT' [D376]"
         return
      end if
      do place = size(keys), 1, -1
         if (keys(place)%name == name) exit
      end do
      if (place == 0) then
         fault = unknown(keys, name)
      else if (given(place)) then
         fault = "library_constants: '"//name//"' is given twice [D376]"
      else
         given(place) = .true.
         call split_unit(words(1)%text, digits, unit)
         if (size(words) > 1) unit = trim(unit//" "//join(words(2:), " "))
         call convert(keys(place), digits, trim(adjustl(unit)), system, values(place), fault)
      end if
   end subroutine read_one

   !> Convert a number of a constant to SI. A number without a unit is in SI: the echo of a deck
   !! keeps the text and has other units.
   subroutine convert(key, digits, unit, system, value, fault)
      type(key_t), intent(in) :: key
      character(len=*), intent(in) :: digits         !! Without the unit
      character(len=*), intent(in) :: unit           !! Behind the number, or empty
      integer, intent(in) :: system                  !! Units of the deck
      real(wp), intent(out) :: value                 !! [SI]
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      character(len=:), allocatable :: problem
      type(item_t) :: item

      item%text = digits
      item%unit = unit
      value = 0.0_wp
      problem = ""
      fault = ""
      if (unit == "" .and. key%unit_text /= "" .and. system /= system_si) then
         fault = "library_constants: '"//key%name//" = "//digits//"' needs a unit, such as "// &
            key%unit_text//", in a deck with &units [D376]"
         return
      end if
      call convert_number(key, item, system_si, value, problem)
      if (problem /= "") fault = "library_constants: "//key%name//" "//problem
   end subroutine convert

   !> Message on a name that the library does not declare.
   function unknown(keys, name) result(fault)
      type(key_t), intent(in) :: keys(:)             !! As the library declares them
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: fault
      type(text_t) :: names(size(keys))
      character(len=:), allocatable :: near
      integer :: i

      do i = 1, size(keys)
         names(i)%text = keys(i)%name
      end do
      near = closest(name, names)
      fault = "library_constants: the library has no constant '"//name//"'"
      if (size(keys) == 0) then
         fault = fault//"; it has none"
      else if (near /= "") then
         fault = fault//"; did you mean "//near//"?"
      else
         fault = fault//"; it has "//join(names(:min(named, size(keys))), ", ")
         if (size(keys) > named) fault = fault//" and "//number(size(keys) - named)//" others"
      end if
      fault = fault//" [D376]"
   end function unknown

   !> A number of a constant for a message: its unit after NUMBER.
   pure function example(key) result(text)
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: text

      text = trim("NUMBER "//key%unit_text)
   end function example
end module material_library_constants
