! SPDX-License-Identifier: BSD-3-Clause
!> Values of keys: strict conversion of text into numbers, switches and texts in SI.
module deck_value
   use base_kinds, only: wp
   use base_names, only: name_problem, text_problem
   use base_text, only: closest, closest_meaning, join, lower, number, split, text_t
   use deck_namelist, only: token_t
   use deck_number, only: check_range, convert_number, expectation, item_t, read_integer
   use deck_place_formula, only: convert_formula
   use deck_schema, only: key_t, kind_integer, kind_logical, kind_real, kind_text
   use deck_units, only: begins_unit, split_unit, system_si
   implicit none
   private

   public :: convert, read_default, value_t

   !> The value of one key of one group.
   type :: value_t
      character(len=:), allocatable :: key               !! Name
      logical :: given = .false.                         !! In the deck, a preset or a command
      logical :: preset = .false.                        !! By a preset
      logical :: valid = .true.                          !! No error so far
      logical :: derived = .false.                       !! Derived from other keys
      integer :: line = 0                                !! Line of the key
      character(len=:), allocatable :: file              !! File of the key
      logical, allocatable :: filled(:)                  !! (index) Has a value
      real(wp), allocatable :: numbers(:)                !! (index) Values of a key of numbers [SI]
      integer, allocatable :: integers(:)                  !! (index) Values of a key of integers
      logical, allocatable :: switches(:)                !! (index) Values of a switch
      type(text_t), allocatable :: texts(:)              !! (index) Values of a key of texts
   contains
      procedure :: count => value_count                  !! Number of values
   end type value_t

   integer, parameter :: longest_text = 240 !! Fits into a line even with all quotes doubled
   character(len=*), parameter :: points_at = "  <- "    !! Between value and problem

contains

   !> Number of values: index of the last place with a value.
   pure integer function value_count(self) result(count)
      class(value_t), intent(in) :: self
      count = 0
      if (.not. allocated(self%filled)) return
      do count = size(self%filled), 1, -1
         if (self%filled(count)) return
      end do
   end function value_count

   !> Set the value of a key to its default.
   subroutine read_default(key, value, problem)
      type(key_t), intent(in) :: key
      type(value_t), intent(out) :: value                !! Value
      character(len=:), allocatable, intent(out) :: problem !! Empty without an error
      type(token_t), allocatable :: tokens(:)
      type(text_t), allocatable :: words(:)
      integer :: i

      problem = ""
      value%key = key%name
      if (.not. allocated(key%default)) then
         allocate (value%filled(key%number_of_values), source=.false.)
         return
      end if
      if (key%kind == kind_text .and. key%number_of_values == 1) then
         allocate (words(1))
         words(1)%text = key%default
      else
         call split(key%default, words)
      end if
      allocate (tokens(size(words)))
      do i = 1, size(words)
         tokens(i)%raw = words(i)%text
         tokens(i)%text = words(i)%text
         tokens(i)%quoted = key%kind == kind_text
      end do
      call convert(key, tokens, 0, system_si, value, problem)
   end subroutine read_default

   !> Convert text into values in SI.
   subroutine convert(key, tokens, subscript, system, value, problem)
      type(key_t), intent(in) :: key
      type(token_t), intent(in) :: tokens(:)             !! As written
      integer, intent(in) :: subscript                   !! First value to set, 0 = all
      integer, intent(in) :: system                      !! Units of numbers without a unit
      type(value_t), intent(inout) :: value              !! Gets the values
      character(len=:), allocatable, intent(out) :: problem !! Empty without an error
      type(item_t), allocatable :: items(:)
      integer :: first, i, number_of_values

      problem = ""
      ! arrays are added unless present
      if (.not. allocated(value%filled)) allocate (value%filled(key%number_of_values), &
         source=.false.)
      select case (key%kind)
      case (kind_real)
         if (.not. allocated(value%numbers)) allocate (value%numbers(key%number_of_values), &
            source=0.0_wp)
      case (kind_integer)
         if (.not. allocated(value%integers)) allocate (value%integers(key%number_of_values), &
            source=0)
      case (kind_logical)
         if (.not. allocated(value%switches)) allocate (value%switches(key%number_of_values), &
            source=.false.)
      case default
         if (.not. allocated(value%texts)) allocate (value%texts(key%number_of_values))
      end select
      first = max(subscript, 1)
      number_of_values = key%number_of_values - first + 1
      call expand_repeats(key, tokens, number_of_values, items, problem)
      if (problem == "" .and. size(items) == 0) problem = expectation(key)
      ! units of values beyond the last one are not kept
      if (problem == "" .and. key%kind == kind_real) problem = &
         mixed_units(items(:min(size(items), number_of_values)))
      do i = 1, min(size(items), number_of_values)
         if (problem /= "") exit
         call convert_item(key, items(i), system, first + i - 1, value, problem)
      end do
      if (problem == "") then
         if (size(items) > number_of_values) then
            problem = too_many(key, subscript, tokens, items)
         else if (key%exact .and. subscript == 0 .and. size(items) < number_of_values) then
            problem = expectation(key)//", not "//values_text(size(items))
         end if
      end if
      if (problem == "") return
      value%valid = .false.
      if (problem(1:1) /= " ") problem = points_at//problem
   end subroutine convert

   !> The error if there are more values than the key allows.
   function too_many(key, subscript, tokens, items) result(problem)
      type(key_t), intent(in) :: key
      integer, intent(in) :: subscript                   !! First value to set, 0 = all
      type(token_t), intent(in) :: tokens(:)             !! As written
      type(item_t), intent(in) :: items(:)
      character(len=:), allocatable :: problem
      integer :: i

      problem = expectation(key)//", not "//values_text(size(items))
      if (subscript > 0) problem = expectation(key)//"; there is no value "// &
         number(key%number_of_values + 1)
      do i = 1, size(tokens)
         if (.not. tokens(i)%quoted .and. index(tokens(i)%raw, "*") > 0) &
            problem = expectation(key)
      end do
      do i = 1, size(items)
         if (key%kind == kind_text .and. items(i)%quoted) cycle
         if (key%kind /= kind_text .and. verify(items(i)%text, "+-.0123456789eEdD") == 0) cycle
         problem = expectation(key)
      end do
   end function too_many

   !> A number of values.
   function values_text(values) result(text)
      integer, intent(in) :: values
      character(len=:), allocatable :: text

      text = number(values)//" values"
      if (values == 1) text = "1 value"
   end function values_text

   !> Resolve commas and repeat counts such as 3*0.0. Copies beyond the last value are left out.
   subroutine expand_repeats(key, tokens, number_of_values, items, problem)
      type(key_t), intent(in) :: key
      type(token_t), intent(in) :: tokens(:)             !! As written
      integer, intent(in) :: number_of_values            !! Number of values to set
      type(item_t), allocatable, intent(out) :: items(:)
      character(len=:), allocatable, intent(inout) :: problem !! Empty without an error
      type(item_t) :: item
      logical :: after_comma
      integer :: before, copies, i, mark, pending

      allocate (items(0))
      before = 0
      after_comma = .true.
      pending = 1
      do i = 1, size(tokens)
         if (tokens(i)%comma) then
            if (after_comma) problem = "lacks a value before a comma [D212]"
            after_comma = .true.
            cycle
         end if
         if (.not. after_comma .and. size(items) > before .and. is_unit(key, tokens(i))) then
            do copies = before + 1, size(items)
               items(copies)%unit = trim(adjustl(items(copies)%unit//" "//tokens(i)%text))
            end do
            cycle
         end if
         after_comma = .false.
         before = size(items)
         copies = pending
         pending = 1
         item%text = tokens(i)%text
         item%quoted = tokens(i)%quoted
         if (.not. item%quoted) then
            mark = index(item%text, "*")
            copies = copies*copies_of(item%text(:max(mark - 1, 0)))
            if (copies > 0) item%text = item%text(mark + 1:)
            if (copies > 0 .and. mark > 0 .and. item%text == "" .and. i < size(tokens)) then
               if (tokens(i + 1)%quoted .or. tokens(i + 1)%formula) then
                  pending = copies
                  cycle
               end if
            end if
         end if
         item%unit = ""
         if (key%kind == kind_real .and. .not. item%quoted) &
            call split_unit(item%text//"", item%text, item%unit)
         do copies = 1, min(max(copies, 1), number_of_values + 1 - size(items))
            call add_item(items, item)
         end do
         if (size(items) > number_of_values) call add_rest(key, items, tokens(i + 1:))
         if (size(items) > number_of_values) exit
      end do
   end subroutine expand_repeats

   !> True if a word after a number is its unit.
   pure logical function is_unit(key, token) result(yes)
      type(key_t), intent(in) :: key
      type(token_t), intent(in) :: token
      yes = key%kind == kind_real .and. .not. (token%quoted .or. token%formula .or. token%comma)
      if (yes) yes = begins_unit(token%raw)
   end function is_unit

   !> The error if some numbers of a list have a unit and others, except 0, have none.
   function mixed_units(items) result(problem)
      type(item_t), intent(in) :: items(:)
      character(len=:), allocatable :: problem
      logical :: bare, united
      integer :: i

      problem = ""
      bare = .false.
      united = .false.
      do i = 1, size(items)
         if (items(i)%quoted) return
         united = united .or. items(i)%unit /= ""
         if (items(i)%unit == "") bare = bare .or. &
            scan(items(i)%text(:scan(items(i)%text//"e", "eEdD") - 1), "123456789") > 0
      end do
      if (bare .and. united) problem = &
         "has numbers with and without a unit; write one after each number that is not 0 [D202]"
   end function mixed_units

   !> Count the values that follow if there are too many, for the message.
   subroutine add_rest(key, items, tokens)
      type(key_t), intent(in) :: key
      type(item_t), allocatable, intent(inout) :: items(:)
      type(token_t), intent(in) :: tokens(:)             !! Values that follow
      type(item_t) :: item
      integer :: i

      do i = 1, size(tokens)
         if (tokens(i)%comma .or. is_unit(key, tokens(i))) cycle
         item%text = tokens(i)%text
         item%quoted = tokens(i)%quoted
         item%unit = ""
         call add_item(items, item)
      end do
   end subroutine add_rest

   !> Append a value.
   subroutine add_item(items, item)
      type(item_t), allocatable, intent(inout) :: items(:)
      type(item_t), intent(in) :: item                   !! The new last one
      type(item_t), allocatable :: longer(:)

      allocate (longer(size(items) + 1))
      longer(:size(items)) = items
      longer(size(longer)) = item
      call move_alloc(longer, items)
   end subroutine add_item

   !> Repeat count before the asterisk: 1 if there is none, 0 if it is not valid.
   pure integer function copies_of(text) result(copies)
      character(len=*), intent(in) :: text               !! Text before the asterisk
      integer :: status

      copies = 1
      if (len(text) == 0) return
      copies = 0
      if (verify(text, "0123456789") > 0) return
      copies = 1000
      if (len(text) > 3) return
      read (text, *, iostat=status) copies
   end function copies_of

   !> Convert one value.
   subroutine convert_item(key, item, system, place, value, problem)
      type(key_t), intent(in) :: key
      type(item_t), intent(in) :: item                   !! As written
      integer, intent(in) :: system                      !! Units of numbers without a unit
      integer, intent(in) :: place                       !! Index of the value
      type(value_t), intent(inout) :: value              !! Gets the value
      character(len=:), allocatable, intent(inout) :: problem !! Empty without an error

      if (item%quoted .neqv. key%kind == kind_text) then
         problem = expectation(key)
         return
      end if
      select case (key%kind)
      case (kind_real)
         call convert_number(key, item, system, value%numbers(place), problem)
      case (kind_integer)
         call read_integer(item%text, value%integers(place), problem)
         if (problem == "?") problem = expectation(key)
         if (problem == "") call check_range(key, real(value%integers(place), wp), problem)
      case (kind_logical)
         select case (lower(item%text))
         case (".true.", ".t.", "true", "t")
            value%switches(place) = .true.
         case (".false.", ".f.", "false", "f")
            value%switches(place) = .false.
         case default
            problem = expectation(key)
         end select
      case default
         call check_words(key, item%text, value%texts(place)%text, problem)
         if (problem == "" .and. key%unit_text /= "") &
            call convert_formula(key, system, longest_text, value%texts(place)%text, &
            problem)
      end select
      if (problem == "") value%filled(place) = .true.
   end subroutine convert_item

   !> Check a text against the words that are allowed, in letters of either case.
   subroutine check_words(key, written, text, problem)
      type(key_t), intent(in) :: key
      character(len=*), intent(in) :: written            !! Text as written
      character(len=:), allocatable, intent(out) :: text !! In the case of the key
      character(len=:), allocatable, intent(inout) :: problem !! Empty without an error
      character(len=:), allocatable :: near
      integer :: i

      text = trim(written)
      if (text == "") problem = "expects a text that is not empty [D211]"
      if (len(text) > longest_text) problem = "is longer than "//number(longest_text)// &
         " letters [D229]"
      if (problem == "") problem = text_problem(text)
      ! these become a part of file names
      if (problem == "" .and. (key%name == "name" .or. key%name == "case")) &
         problem = name_problem(text)
      if (problem /= "" .or. size(key%words) == 0) return
      do i = 1, size(key%words)
         if (lower(key%words(i)%text) /= lower(text)) cycle
         text = key%words(i)%text
         return
      end do
      problem = " is none of: "//join(key%words, " ")//" [D220]"
      near = closest(text, key%words)
      if (near == "" .and. allocated(key%meanings)) near = closest_meaning(text, key%meanings)
      if (near /= "") problem = problem//"; did you mean '"//near//"'?"
   end subroutine check_words
end module deck_value
