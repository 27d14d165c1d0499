! SPDX-License-Identifier: BSD-3-Clause
!> An input deck, read against the schema with all its errors found in one pass.
!!
!! Usage: `read`, further checks with `add_error` and `warn`, then `verdict`. The type of its
!! groups, `group_t`, is public here as well, because every module that reads a deck needs both.
module deck_reader
   use base_error, only: error_t, exit_input, fail
   use base_kinds, only: wp
   use base_text, only: brief, lower, number, text_t
   use deck_check, only: check_groups, check_schema, label_of
   use deck_define, only: definitions_t
   use deck_echo_text, only: echo
   use deck_fill, only: fill_defaults, fill_groups, start_group
   use deck_group_values, only: group_t, unset_integer
   use deck_index, only: deck_index_t
   use deck_namelist, only: namelist_t
   use deck_override, only: override, removal_mark, split_assignment
   use deck_preset_lines, only: apply_presets
   use deck_problems, only: problems_t
   use deck_repeat, only: repeat_groups
   use deck_schema, only: kind_integer, kind_logical, kind_real, kind_text, schema_t
   use deck_units, only: system_names, system_number, system_si, unit_of, unit_t
   use deck_value, only: read_default, value_t
   implicit none
   private

   public :: deck_t, group_t

   !> A deck.
   type :: deck_t
      character(len=:), allocatable :: file              !! Name
      integer :: system = system_si                      !! Units of its numbers
      type(schema_t), private :: schema                  !! Keys that are allowed
      type(problems_t) :: problems                       !! Errors and warnings
      type(definitions_t), private :: definitions        !! Names defined by `&define`
      type(group_t), allocatable, private :: groups(:)   !! All groups
      type(deck_index_t), private :: index               !! Index of the groups
      type(text_t), allocatable, private :: files(:)     !! Its files in the order of reading
      integer, private :: written = 0                    !! Number of groups in the text
   contains
      procedure :: read => deck_read                     !! Read it
      procedure :: count => deck_count                   !! Number of groups of a kind
      procedure :: group => deck_group                   !! One group
      procedure :: departs => deck_departs               !! Is a key given, and not its default?
      procedure :: take_back => deck_take_back           !! Remove a value that a preset gives
      procedure :: unit => deck_unit                     !! Unit of SI of a key
      procedure :: named => deck_named                   !! Index of the group with a given name
      !> Record an error or a warning about a group, at the line of a key if it is given.
      generic :: add_error => report_group_error, report_place_error
      generic :: warn => warn_of_group, warn_of_place    !! The same for a warning
      !> Replace a default that depends on other keys by the value that is used.
      generic :: set_default => set_default_numbers, set_default_number, set_default_integer, &
         set_default_integers, &
         set_default_switch, set_default_text
      procedure :: errors => deck_errors                 !! Number of errors so far
      procedure :: sound => deck_sound                   !! No error in groups of a kind
      procedure :: warnings => deck_warnings             !! Number of warnings so far
      procedure :: report => deck_report                 !! All errors and warnings, and their count
      procedure :: verdict => deck_verdict               !! An error if there were any
      procedure :: shown => deck_shown                   !! A number in the units of the deck
      procedure :: echo => deck_echo                     !! The deck with all values used, in SI
      procedure, private :: report_group_error, report_place_error, warn_of_group, warn_of_place
      procedure, private :: set_default_numbers, set_default_number, set_default_integer, &
         set_default_integers, &
         set_default_switch, set_default_text
      procedure, private :: locate => deck_locate        !! Index of a group
      procedure, private :: slot => deck_slot            !! Indices of a group and a key
   end type deck_t

contains

   !> Read a deck. Its errors are stored in it; `error` is a defect of the schema.
   subroutine deck_read(self, schema, text, file, overrides, error)
      class(deck_t), intent(out) :: self
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      character(len=*), intent(in) :: text               !! All lines
      character(len=*), intent(in) :: file               !! Name of the file, for messages
      type(text_t), intent(in) :: overrides(:)           !! GROUP.KEY=VALUE of the command line
      type(error_t), allocatable, intent(out) :: error   !! An error in the schema
      type(namelist_t) :: namelist
      type(group_t), allocatable :: groups(:)
      integer :: filled, i

      self%file = file
      self%schema = schema
      call check_schema(schema, error)
      if (allocated(error)) return
      call namelist%scan(text, file, self%problems)
      self%written = namelist%count
      call move_alloc(namelist%files, self%files)
      self%system = chosen_system(namelist, overrides)
      call self%definitions%read(namelist, overrides, self%system, self%problems)
      allocate (groups(namelist%count + size(overrides) + size(schema%groups)))
      filled = 0
      call fill_groups(schema, namelist, self%definitions, self%system, self%problems, groups, &
         filled)
      do i = 1, size(overrides)
         call override(schema, overrides(i)%text, self%definitions, self%system, self%problems, &
            groups, filled)
      end do
      call add_absent(schema, file, groups, filled)
      do i = 1, filled
         call fill_defaults(schema%groups(schema%find(groups(i)%group)), self%problems, groups(i))
         call groups(i)%get("name", groups(i)%title)
      end do
      self%groups = groups(:filled)
      call repeat_groups(schema, self%problems, self%groups)
      call self%index%build(schema, self%groups)
      call apply_presets(schema, self%index, self%problems, self%groups)
      call check_groups(schema, self%groups, self%index, file, self%problems)
   end subroutine deck_read

   !> The system of units of the deck or of the command line; SI if it is not valid.
   integer function chosen_system(namelist, overrides) result(system)
      type(namelist_t), intent(in) :: namelist           !! As written
      type(text_t), intent(in) :: overrides(:)           !! GROUP.KEY=VALUE of the command line
      character(len=:), allocatable :: choice, group, key, name, value
      integer :: i, k

      name = "si"
      do i = namelist%count, 1, -1
         if (namelist%blocks(i)%name /= "units") cycle
         do k = 1, size(namelist%blocks(i)%pieces)
            associate (piece => namelist%blocks(i)%pieces(k))
               if (piece%key == "system" .and. size(piece%tokens) == 1) name = piece%tokens(1)%text
            end associate
         end do
      end do
      do i = 1, size(overrides)
         if (overrides(i)%text == removal_mark//"units.system") name = "si"
         call split_assignment(overrides(i)%text, group, choice, key, value)
         if (group == "units" .and. key == "system") name = value
      end do
      if (scan(name//" ", "'""") == 1) name = name(2:len(name) - 1)
      system = system_number(lower(name))
      if (system == 0) system = system_si
   end function chosen_system

   !> Add each group that may be given once and is absent from the deck, so that its keys have their
   !! defaults.
   subroutine add_absent(schema, file, groups, filled)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      character(len=*), intent(in) :: file               !! Name of the deck
      type(group_t), intent(inout) :: groups(:)          !! All groups
      integer, intent(inout) :: filled                   !! Number of groups
      integer :: i, rule

      do rule = 1, size(schema%groups)
         if (schema%groups(rule)%many) cycle
         do i = 1, filled
            if (groups(i)%group == schema%groups(rule)%name) exit
         end do
         if (i <= filled) cycle
         filled = filled + 1
         call start_group(schema%groups(rule), 1, groups(filled))
         groups(filled)%path = file
      end do
   end subroutine add_absent

   !> Number of groups of a kind. A kind that may be given only once always counts as one.
   pure integer function deck_count(self, name) result(count)
      class(deck_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Kind, without &

      count = self%index%count(self%schema%find(name))
   end function deck_count

   !> Index of a group in the list, 0 if there is none.
   pure integer function deck_locate(self, name, place) result(index)
      class(deck_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Kind, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind

      index = self%index%at(self%schema%find(name), place)
   end function deck_locate

   !> One group; a group without values if there is none.
   function deck_group(self, name, place) result(group)
      class(deck_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Kind, without &
      integer, intent(in), optional :: place             !! Number among those of its kind, or 1
      type(group_t) :: group
      integer :: index

      index = 1
      if (present(place)) index = place
      index = self%locate(name, index)
      if (index > 0) then
         group = self%groups(index)
         return
      end if
      group%group = name
      group%title = ""
      group%path = self%file
      allocate (group%values(0))
   end function deck_group

   !> Index of the group with a given name among the groups of its kind, 0 if there is none.
   pure integer function deck_named(self, name, title) result(place)
      class(deck_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Kind, without &
      character(len=*), intent(in) :: title              !! Value of its key `name`
      integer :: which

      place = 0
      which = self%index%named(self%groups, name, title)
      if (which > 0) place = self%groups(which)%place
   end function deck_named

   !> Record an error about a group.
   subroutine report_group_error(self, group, message, key)
      class(deck_t), intent(inout) :: self
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: message            !! Error and its remedy
      character(len=*), intent(in), optional :: key      !! The key whose line is reported

      call self%problems%error(group%file(key), group%line(key), label_of(group)//": "//message)
   end subroutine report_group_error

   !> Record an error about a group.
   subroutine report_place_error(self, name, place, message, key)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Kind, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: message            !! Error and its remedy
      character(len=*), intent(in), optional :: key      !! The key whose line is reported

      call self%add_error(self%group(name, place), message, key)
   end subroutine report_place_error

   !> Record a warning about a group.
   subroutine warn_of_group(self, group, message, key)
      class(deck_t), intent(inout) :: self
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: message            !! Possible error and its remedy
      character(len=*), intent(in), optional :: key      !! The key whose line is reported

      call self%problems%warning(group%file(key), group%line(key), label_of(group)//": "//message)
   end subroutine warn_of_group

   !> Record a warning about a group.
   subroutine warn_of_place(self, name, place, message, key)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Kind, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: message            !! Possible error and its remedy
      character(len=*), intent(in), optional :: key      !! The key whose line is reported

      call self%warn(self%group(name, place), message, key)
   end subroutine warn_of_place

   !> Number of errors so far.
   pure integer function deck_errors(self) result(errors)
      class(deck_t), intent(in) :: self
      errors = self%problems%errors
   end function deck_errors

   !> True if no group of a kind (or the one at `place`) has an error, and no error elsewhere can
   !! have removed keys from it. Such groups can be checked further although other groups have
   !! errors.
   pure logical function deck_sound(self, name, place) result(sound)
      class(deck_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Kind, without &
      integer, intent(in), optional :: place !! Index among those of its kind, default: all
      integer :: first, last, seen, which

      sound = .not. self%problems%about("&"//name)
      first = 1
      last = self%count(name)
      if (present(place)) then
         first = place
         last = min(place, last)
      end if
      do seen = first, last
         which = self%locate(name, seen)
         associate (group => self%groups(which))
            if (group%first_line == 0) cycle
            if (group%broken .or. .not. all(group%values%valid)) sound = .false.
            if (self%problems%within(group%path, group%first_line, &
               max(self%index%last_line(which), group%first_line))) sound = .false.
         end associate
      end do
   end function deck_sound

   !> Number of warnings so far.
   pure integer function deck_warnings(self) result(warnings)
      class(deck_t), intent(in) :: self
      warnings = self%problems%warnings
   end function deck_warnings

   !> All errors and warnings in the order of the lines, and a last line with their count.
   function deck_report(self) result(text)
      class(deck_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = self%problems%report(self%files, self%written)
   end function deck_report

   !> An error with the report, if there are errors.
   subroutine deck_verdict(self, error)
      class(deck_t), intent(in) :: self
      type(error_t), allocatable, intent(out) :: error   !! The deck has errors

      if (self%errors() > 0) call fail(error, exit_input, self%report())
   end subroutine deck_verdict

   !> A number in the units of the deck, for messages.
   function deck_shown(self, value, unit_text) result(text)
      class(deck_t), intent(in) :: self
      real(wp), intent(in) :: value                      !! The number [SI]
      character(len=*), intent(in) :: unit_text          !! SI unit of the key
      character(len=:), allocatable :: text
      type(unit_t) :: unit
      logical :: known

      call unit_of(unit_text, unit, known)
      text = brief(value*10.0_wp**(-unit%exponent(self%system)))
   end function deck_shown

   !> The deck with all values that are used, in SI; reading it gives the same bits.
   function deck_echo(self) result(text)
      class(deck_t), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: i

      text = "! Written in SI ("//trim(system_names(system_si))//"); the deck was in "// &
         trim(system_names(self%system))//"."//new_line("a")
      do i = 1, size(self%definitions%names)
         text = text//"! &define "//self%definitions%names(i)%text//" = "// &
            number(self%definitions%values(i))//" in the units of the deck"//new_line("a")
      end do
      text = text//echo(self%schema, self%groups, self%index)
   end function deck_echo

   !> Unit of SI of a key, for messages.
   pure function deck_unit(self, group, key) result(unit)
      class(deck_t), intent(in) :: self
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: unit
      integer :: rule

      rule = self%schema%find(group%group)
      unit = self%schema%groups(rule)%keys(self%schema%groups(rule)%find(key))%unit_text
   end function deck_unit

   !> True if a key is given with a value other than its default. A key that has its default is not
   !! enough, because the echo of a deck can be run as a deck and gives all defaults.
   logical function deck_departs(self, group, key) result(departs)
      class(deck_t), intent(in) :: self
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      type(value_t) :: default
      character(len=:), allocatable :: problem
      integer :: rule, k, i

      departs = group%given(key)
      if (.not. departs) return
      rule = self%schema%find(group%group)
      k = self%schema%groups(rule)%find(key)
      call read_default(self%schema%groups(rule)%keys(k), default, problem)
      associate (value => group%values(group%find(key)))
         if (default%count() /= value%count()) return
         departs = .false.
         do i = 1, value%count()
            select case (self%schema%groups(rule)%keys(k)%kind)
            case (kind_real)
               departs = departs .or. abs(value%numbers(i) - default%numbers(i)) > 0.0_wp
            case (kind_integer)
               departs = departs .or. value%integers(i) /= default%integers(i)
            case (kind_logical)
               departs = departs .or. (value%switches(i) .neqv. default%switches(i))
            case default
               departs = departs .or. value%texts(i)%text /= default%texts(i)%text
            end select
         end do
      end associate
   end function deck_departs

   !> Remove the value of a key that a preset gives and the models of the deck do not need. It is no
   !! mistake of the deck, and the echo does not give it.
   subroutine deck_take_back(self, group, key)
      class(deck_t), intent(inout) :: self
      type(group_t), intent(inout) :: group              !! One group of the deck, changed too
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: problem
      integer :: rule, k

      k = group%find(key)
      if (k == 0) return
      if (.not. group%values(k)%preset) return
      rule = self%schema%find(group%group)
      call read_default(self%schema%groups(rule)%keys(k), group%values(k), problem)
      self%groups(self%locate(group%group, group%place))%values(k) = group%values(k)
   end subroutine deck_take_back

   !> Indices of a group and a key of a certain kind; 0 if there is no such key.
   pure function deck_slot(self, name, place, key, kind) result(slot)
      class(deck_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Kind of the group, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: key
      integer, intent(in) :: kind                        !! Kind of its values
      integer :: slot(2)
      integer :: group, index, rule

      slot = 0
      group = self%locate(name, place)
      rule = self%schema%find(name)
      if (group == 0 .or. rule == 0) return
      index = self%schema%groups(rule)%find(key)
      if (index == 0) return
      if (self%schema%groups(rule)%keys(index)%kind == kind) slot = [group, index]
   end function deck_slot

   !> Set the derived value of a key of numbers.
   pure subroutine set_default_numbers(self, group, place, key, value)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Kind of the group, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: value(:)                   !! Values of the key [SI]
      integer :: slot(2)

      slot = self%slot(group, place, key, kind_real)
      if (slot(1) == 0) return
      associate (slot_value => self%groups(slot(1))%values(slot(2)))
         call prepare_default(slot_value, size(value))
         slot_value%numbers = value
      end associate
   end subroutine set_default_numbers

   !> Set the derived value of a key of one number.
   pure subroutine set_default_number(self, group, place, key, value)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Kind of the group, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: value                      !! Value of the key [SI]

      call self%set_default(group, place, key, [value])
   end subroutine set_default_number

   !> Set the derived value of a key of integers.
   pure subroutine set_default_integers(self, group, place, key, value)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Kind of the group, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: key
      integer, intent(in) :: value(:)                    !! Values
      integer :: slot(2)

      slot = self%slot(group, place, key, kind_integer)
      if (slot(1) == 0) return
      associate (slot_value => self%groups(slot(1))%values(slot(2)))
         call prepare_default(slot_value, size(value))
         slot_value%integers = value
      end associate
   end subroutine set_default_integers

   !> Set the derived value of a key of one integer.
   pure subroutine set_default_integer(self, group, place, key, value)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Kind of the group, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: key
      integer, intent(in) :: value                       !! Value

      call self%set_default(group, place, key, [value])
   end subroutine set_default_integer

   !> Set the derived value of a switch.
   pure subroutine set_default_switch(self, group, place, key, value)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Kind of the group, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: key
      logical, intent(in) :: value                       !! Value
      integer :: slot(2)

      slot = self%slot(group, place, key, kind_logical)
      if (slot(1) == 0) return
      associate (slot_value => self%groups(slot(1))%values(slot(2)))
         call prepare_default(slot_value, 1)
         slot_value%switches = [value]
      end associate
   end subroutine set_default_switch

   !> Set the derived value of a text.
   pure subroutine set_default_text(self, group, place, key, value)
      class(deck_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Kind of the group, without &
      integer, intent(in) :: place                       !! Index among the groups of its kind
      character(len=*), intent(in) :: key
      character(len=*), intent(in) :: value              !! Value
      integer :: slot(2)

      slot = self%slot(group, place, key, kind_text)
      if (slot(1) == 0) return
      associate (slot_value => self%groups(slot(1))%values(slot(2)))
         call prepare_default(slot_value, 1)
         allocate (slot_value%texts(1))
         slot_value%texts(1)%text = value
      end associate
   end subroutine set_default_text

   !> Clear a value that was not given, before the derived one is set.
   pure subroutine prepare_default(value, number_of_values)
      type(value_t), intent(inout) :: value
      integer, intent(in) :: number_of_values            !! Number of values

      value%derived = .true.
      value%valid = .true.
      if (allocated(value%filled)) deallocate (value%filled)
      if (allocated(value%texts)) deallocate (value%texts)
      allocate (value%filled(number_of_values), source=.true.)
   end subroutine prepare_default
end module deck_reader
