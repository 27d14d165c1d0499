! SPDX-License-Identifier: BSD-3-Clause
!> One group of a deck with the values of all its keys.
module deck_group_values
   use base_constants, only: unset
   use base_kinds, only: wp
   use base_text, only: text_t
   use deck_value, only: value_t
   implicit none
   private

   public :: group_t

   integer, parameter, public :: unset_integer = -huge(1) !! Value of an integer key that is not set

   !> One group. A key that is not declared is treated as a key without a value.
   type :: group_t
      character(len=:), allocatable :: group             !! Which group, without &
      character(len=:), allocatable :: title             !! Value of its key `name`, or empty
      character(len=:), allocatable :: path              !! File where it begins
      integer :: place = 0                               !! Number among the groups of its kind
      integer :: first_line = 0                          !! Line where it begins, 0: not in the deck
      logical :: present = .false.                       !! Is it in the deck?
      logical :: broken = .false.                        !! May keys be missing after an error?
      type(value_t), allocatable :: values(:)            !! (key of the schema)
   contains
      !> Value of a key; `unset`, `unset_integer`, .false. or an empty text if it has none.
      generic :: get => get_number, get_numbers, get_integer, get_integers, get_switch, get_text, &
         get_texts
      !> All values of a key with a variable number of them; an array of size 0 if it has none.
      generic :: list => list_numbers, list_integers, list_texts
      procedure :: given => group_given                  !! Is the key given in the deck?
      procedure :: known => group_known                  !! Has the key a value, given or default?
      procedure :: valid => group_valid                  !! Are these keys without an error?
      procedure :: count => group_count                  !! Number of values of a key
      procedure :: line => group_line                    !! Line of a key or of the group
      procedure :: file => group_file                    !! File of a key or of the group
      procedure :: find => group_find                    !! Index of a key
      procedure, private :: get_number, get_numbers, get_integer, get_integers, get_switch, &
         get_text, &
         get_texts, list_numbers, list_integers, list_texts
   end type group_t

contains

   !> Index of a key, 0 if there is none of that name.
   pure integer function group_find(self, key) result(place)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key

      do place = size(self%values), 1, -1
         if (self%values(place)%key == key) return
      end do
   end function group_find

   !> True if a key is given, in the deck or on the command line.
   pure logical function group_given(self, key) result(given)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      integer :: place

      place = self%find(key)
      given = place > 0
      if (given) given = self%values(place)%given
   end function group_given

   !> True if a key has a value, given or default.
   pure logical function group_known(self, key) result(known)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key

      known = self%count(key) > 0
   end function group_known

   !> True if no key of a list has an error, so that their values can be compared.
   pure logical function group_valid(self, keys) result(valid)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: keys(:)            !! Names of keys
      integer :: i, place

      valid = .true.
      do i = 1, size(keys)
         place = self%find(trim(keys(i)))
         if (place == 0) cycle
         valid = valid .and. self%values(place)%valid
      end do
   end function group_valid

   !> Number of values of a key.
   pure integer function group_count(self, key) result(count)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      integer :: place

      count = 0
      place = self%find(key)
      if (place == 0) return
      if (self%values(place)%valid) count = self%values(place)%count()
   end function group_count

   !> Line of a key that is given; otherwise the line of the group.
   pure integer function group_line(self, key) result(line)
      class(group_t), intent(in) :: self
      character(len=*), intent(in), optional :: key
      integer :: place

      line = self%first_line
      if (.not. present(key)) return
      place = self%find(key)
      if (place == 0) return
      if (self%values(place)%given) line = self%values(place)%line
   end function group_line

   !> File of a key that is given; otherwise the file of the group.
   pure function group_file(self, key) result(file)
      class(group_t), intent(in) :: self
      character(len=*), intent(in), optional :: key
      character(len=:), allocatable :: file
      integer :: place

      file = self%path
      if (.not. present(key)) return
      place = self%find(key)
      if (place == 0) return
      if (self%values(place)%given) file = self%values(place)%file
   end function group_file

   !> One number.
   pure subroutine get_number(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      real(wp), intent(out) :: value                     !! Value of the key [SI]
      real(wp), allocatable :: values(:)

      call self%list(key, values)
      value = unset
      if (size(values) > 0) value = values(1)
   end subroutine get_number

   !> Several numbers.
   pure subroutine get_numbers(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      real(wp), intent(out) :: value(:)                  !! Values of the key [SI]
      real(wp), allocatable :: values(:)
      integer :: filled

      call self%list(key, values)
      filled = min(size(value), size(values))
      value = unset
      value(:filled) = values(:filled)
   end subroutine get_numbers

   !> All numbers.
   pure subroutine list_numbers(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      real(wp), allocatable, intent(out) :: value(:)     !! Values of the key [SI]
      integer :: place

      allocate (value(0))
      place = self%find(key)
      if (self%count(key) == 0) return
      if (allocated(self%values(place)%numbers)) &
         value = self%values(place)%numbers(:self%count(key))
   end subroutine list_numbers

   !> One integer.
   pure subroutine get_integer(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      integer, intent(out) :: value                      !! Value
      integer, allocatable :: values(:)

      call self%list(key, values)
      value = unset_integer
      if (size(values) > 0) value = values(1)
   end subroutine get_integer

   !> Several integers.
   pure subroutine get_integers(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      integer, intent(out) :: value(:)                   !! Values
      integer, allocatable :: values(:)
      integer :: filled

      call self%list(key, values)
      filled = min(size(value), size(values))
      value = unset_integer
      value(:filled) = values(:filled)
   end subroutine get_integers

   !> All integers.
   pure subroutine list_integers(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      integer, allocatable, intent(out) :: value(:)      !! Values
      integer :: place

      allocate (value(0))
      place = self%find(key)
      if (self%count(key) == 0) return
      if (allocated(self%values(place)%integers)) &
         value = self%values(place)%integers(:self%count(key))
   end subroutine list_integers

   !> A switch.
   pure subroutine get_switch(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      logical, intent(out) :: value                      !! Value
      integer :: place

      value = .false.
      place = self%find(key)
      if (self%count(key) == 0) return
      if (allocated(self%values(place)%switches)) value = self%values(place)%switches(1)
   end subroutine get_switch

   !> One text.
   pure subroutine get_text(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      character(len=:), allocatable, intent(out) :: value !! Value
      type(text_t), allocatable :: values(:)

      call self%list(key, values)
      value = ""
      if (size(values) > 0) value = values(1)%text
   end subroutine get_text

   !> Several texts, all as long as the longest.
   pure subroutine get_texts(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      character(len=:), allocatable, intent(out) :: value(:) !! Values
      type(text_t), allocatable :: values(:)
      integer :: i, longest

      call self%list(key, values)
      longest = 1
      do i = 1, size(values)
         longest = max(longest, len(values(i)%text))
      end do
      allocate (character(len=longest) :: value(size(values)))
      do i = 1, size(values)
         value(i) = values(i)%text
      end do
   end subroutine get_texts

   !> All texts.
   pure subroutine list_texts(self, key, value)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: key
      type(text_t), allocatable, intent(out) :: value(:) !! Values
      integer :: count, i, place

      count = 0
      place = self%find(key)
      if (place > 0) then
         if (allocated(self%values(place)%texts)) count = self%count(key)
      end if
      allocate (value(count))
      do i = 1, count
         value(i)%text = self%values(place)%texts(i)%text
      end do
   end subroutine list_texts
end module deck_group_values
