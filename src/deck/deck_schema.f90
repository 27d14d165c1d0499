! SPDX-License-Identifier: BSD-3-Clause
!> The schema of decks: groups and keys with kind, unit, default, range and meaning.
!!
!! Each part of the program declares its own keys. Reading, checking, the echo, the template and the
!! explanations all walk this one table. The meanings of a change at a restart, `changes_*`, are
!! public here as well, because a declaration of keys needs them.
module deck_schema
   use base_text, only: append, split, text_t
   use deck_key_rules, only: change_rule_t, changes_end, changes_extent, changes_nothing, &
      changes_physics, condition_t, holds, may_not_change, range_t, read_conditions, read_range
   use deck_preset, only: preset_t, read_presets
   use deck_units, only: unit_of, unit_t
   implicit none
   private

   public :: changes_end, changes_extent, changes_nothing, changes_physics, group_rule_t, key_t, &
      schema_t

   integer, parameter, public :: kind_real = 1           !! Numbers
   integer, parameter, public :: kind_integer = 2        !! Integers
   integer, parameter, public :: kind_logical = 3        !! .true. or .false.
   integer, parameter, public :: kind_text = 4           !! Texts in quotes

   !> One key.
   type :: key_t
      character(len=:), allocatable :: group             !! Group of the key
      character(len=:), allocatable :: name              !! Name as in the deck
      integer :: kind = kind_real                        !! One of the constants above
      integer :: number_of_values = 1                    !! Greatest number of values
      logical :: exact = .true.                          !! All values must be given
      character(len=:), allocatable :: doc               !! Meaning
      character(len=:), allocatable :: unit_text         !! Unit of SI as text
      type(unit_t) :: unit                               !! The same to count with
      character(len=:), allocatable :: default           !! In SI; not allocated: none
      type(range_t) :: range                             !! Values that are allowed
      logical :: required = .false.                      !! Must be given where it applies
      character(len=:), allocatable :: target            !! Group whose names it refers to
      type(text_t), allocatable :: words(:)              !! Texts that are allowed, empty: any
      type(text_t), allocatable :: meanings(:)           !! Names and titles of presets, for hints
      type(condition_t), allocatable :: owners(:)        !! All must be true
   end type key_t

   !> One group.
   type :: group_rule_t
      character(len=:), allocatable :: name              !! Name as in the deck, without &
      character(len=:), allocatable :: doc               !! Meaning
      logical :: many = .false.                          !! May be given more than once
      type(key_t), allocatable :: keys(:)                !! In the order of the echo
      type(change_rule_t), allocatable :: changes(:)     !! What a restart may change
   contains
      procedure :: find => group_rule_find               !! Index of a key
      procedure :: names => group_rule_names             !! Names of all keys
   end type group_rule_t

   !> All groups.
   type :: schema_t
      type(group_rule_t), allocatable :: groups(:)       !! In the order of the echo
      type(preset_t), allocatable :: presets(:) !! Sets of values that a deck selects by name
      character(len=:), allocatable :: fault             !! First mistake in a declaration
   contains
      procedure :: group => schema_group                 !! Declare a group
      procedure :: real => schema_real                   !! Declare a key of numbers
      procedure :: integer => schema_integer             !! Declare a key of integers
      procedure :: logical => schema_logical             !! Declare a switch
      procedure :: text => schema_text                   !! Declare a key of texts
      procedure :: words => schema_words                 !! Allow more words for a key of texts
      procedure :: extend_owner => schema_extend_owner   !! Allow one more word for a key
      procedure :: require => schema_require             !! Keys that must be given
      procedure :: refer => schema_refer                 !! Names of which group a key refers to
      procedure :: explain_range => schema_explain_range !! Reason for the range
      procedure :: preset => schema_preset               !! Declare presets of a group
      procedure :: allow_change => schema_allow_change   !! A restart may change keys
      procedure :: forbid_change => schema_forbid_change !! A restart must not change keys
      procedure :: find => schema_find                   !! Index of a group
      procedure :: names => schema_names                 !! Names of all groups
      procedure, private :: add => schema_add            !! Append a key
      procedure, private :: locate => schema_locate      !! Indices of a declared key
   end type schema_t

contains

   !> Declare a group, or add to it if it is declared already.
   subroutine schema_group(self, name, doc, many)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name as in the deck, without &
      character(len=*), intent(in) :: doc                !! Meaning
      logical, intent(in), optional :: many              !! May be given more than once
      type(group_rule_t), allocatable :: longer(:)
      integer :: known

      if (self%find(name) > 0) return
      known = 0
      if (allocated(self%groups)) known = size(self%groups)
      allocate (longer(known + 1))
      if (known > 0) longer(:known) = self%groups
      longer(known + 1)%name = name
      longer(known + 1)%doc = doc
      if (present(many)) longer(known + 1)%many = many
      allocate (longer(known + 1)%keys(0), longer(known + 1)%changes(0))
      call move_alloc(longer, self%groups)
   end subroutine schema_group

   !> Declare a key of numbers: name x for one, x(3) for three, x(:50) for up to fifty.
   subroutine schema_real(self, group, name, doc, unit, default, range, owner)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name               !! Name and number of values
      character(len=*), intent(in) :: doc                !! Meaning
      character(len=*), intent(in), optional :: unit     !! Unit in SI, or deg; default: 1
      character(len=*), intent(in), optional :: default  !! Default in SI
      character(len=*), intent(in), optional :: range    !! In SI: > 0, >= 0 < 1
      character(len=*), intent(in), optional :: owner    !! Condition under which it applies
      type(key_t) :: key
      logical :: known

      key%kind = kind_real
      key%unit_text = ""
      if (present(unit)) then
         if (unit /= "1") key%unit_text = unit
         call unit_of(unit, key%unit, known)
         if (.not. known) call record_mistake(self, "unit "//unit//" of "//name)
      end if
      call self%add(key, group, name, doc, default, range, owner)
   end subroutine schema_real

   !> Declare a key of integers: name n for one, n(3) for three, n(:50) for up to fifty.
   subroutine schema_integer(self, group, name, doc, default, range, owner)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name               !! Name and number of values
      character(len=*), intent(in) :: doc                !! Meaning
      character(len=*), intent(in), optional :: default  !! As in the deck
      character(len=*), intent(in), optional :: range    !! Such as > 0, >= 0 <= 9
      character(len=*), intent(in), optional :: owner    !! Condition under which it applies
      type(key_t) :: key

      key%kind = kind_integer
      call self%add(key, group, name, doc, default, range, owner)
   end subroutine schema_integer

   !> Declare a switch.
   subroutine schema_logical(self, group, name, doc, default, owner)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name               !! Name
      character(len=*), intent(in) :: doc                !! Meaning
      character(len=*), intent(in), optional :: default  !! .true. or .false.
      character(len=*), intent(in), optional :: owner    !! Condition under which it applies
      type(key_t) :: key

      key%kind = kind_logical
      call self%add(key, group, name, doc, default, owner=owner)
   end subroutine schema_logical

   !> Declare a key of texts: name t for one, t(2) for two, t(:40) for up to forty. With a unit they
   !! are formulas of the place.
   subroutine schema_text(self, group, name, doc, default, words, owner, unit)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name               !! Name and number of values
      character(len=*), intent(in) :: doc                !! Meaning
      character(len=*), intent(in), optional :: default  !! Without quotes
      character(len=*), intent(in), optional :: words    !! Allowed words, separated by blanks
      character(len=*), intent(in), optional :: owner    !! Condition under which it applies
      character(len=*), intent(in), optional :: unit     !! Unit of the value of a formula
      type(key_t) :: key
      logical :: known

      key%kind = kind_text
      if (present(words)) call split(words, key%words)
      if (present(unit)) then
         key%unit_text = unit
         call unit_of(unit, key%unit, known)
         if (.not. known) call record_mistake(self, "unit "//unit//" of "//name)
      end if
      call self%add(key, group, name, doc, default, owner=owner)
   end subroutine schema_text

   !> Append a key to its group.
   subroutine schema_add(self, key, group, name, doc, default, range, owner)
      class(schema_t), intent(inout) :: self
      type(key_t), intent(inout) :: key                  !! Kind, unit and words are set
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name               !! Name and number of values
      character(len=*), intent(in) :: doc                !! Meaning
      character(len=*), intent(in), optional :: default  !! Default in SI
      character(len=*), intent(in), optional :: range    !! Range in SI
      character(len=*), intent(in), optional :: owner    !! Condition under which it applies
      type(key_t), allocatable :: longer(:)
      integer :: place, bracket, status
      logical :: known

      key%group = group
      key%doc = doc
      key%range%text = ""
      key%target = ""
      key%range%hint = ""
      if (.not. allocated(key%unit_text)) key%unit_text = ""
      if (.not. allocated(key%words)) allocate (key%words(0))
      if (present(default)) key%default = default
      ! the name without its number of values, such as lo(3), times(:50)
      bracket = index(name, "(")
      key%name = name
      if (bracket > 0) then
         key%name = name(:bracket - 1)
         key%exact = name(bracket + 1:bracket + 1) /= ":"
         if (.not. key%exact) bracket = bracket + 1
         read (name(bracket + 1:len(name) - 1), *, iostat=status) key%number_of_values
         if (status /= 0) call record_mistake(self, "number of values of "//name)
      end if
      if (present(range)) then
         call read_range(range, key%range, known)
         if (.not. known) call record_mistake(self, "range of "//key%name)
      end if
      allocate (key%owners(0))
      if (present(owner)) call read_conditions(owner, group, key%owners)
      place = self%find(group)
      if (place == 0) then
         call record_mistake(self, "group of "//group//"."//key%name)
         return
      end if
      associate (rule => self%groups(place))
         if (rule%find(key%name) > 0) call record_mistake(self, "second "//group//"."//key%name)
         allocate (longer(size(rule%keys) + 1))
         longer(:size(rule%keys)) = rule%keys
         longer(size(longer)) = key
         call move_alloc(longer, rule%keys)
      end associate
   end subroutine schema_add

   !> Allow more words for a key of texts.
   subroutine schema_words(self, group, name, words)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: words(:)           !! Words that are allowed
      integer :: i, place(2)

      place = self%locate(group, name)
      if (place(1) == 0) return
      associate (key => self%groups(place(1))%keys(place(2)))
         do i = 1, size(words)
            if (holds(key%words, trim(words(i)))) cycle
            call append(key%words, trim(words(i)))
         end do
      end associate
   end subroutine schema_words

   !> True if a key is declared already; then its first condition accepts one more word.
   logical function schema_extend_owner(self, group, name, word) result(declared)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group, name, word  !! Group and key; the further word
      integer :: rule, key

      rule = self%find(group)
      key = self%groups(rule)%find(name)
      declared = key > 0
      if (declared) call append(self%groups(rule)%keys(key)%owners(1)%words, word)
   end function schema_extend_owner

   !> Declare presets of a group, whose key `preset` must be declared.
   subroutine schema_preset(self, group, lines)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Name of the group
      character(len=*), intent(in) :: lines(:)           !! See deck_preset
      type(preset_t), allocatable :: read(:), longer(:)
      integer :: i, known, place(2)

      call read_presets(group, lines, read)
      known = 0
      if (allocated(self%presets)) known = size(self%presets)
      allocate (longer(known + size(read)))
      do i = 1, known
         longer(i) = self%presets(i)
      end do
      do i = 1, size(read)
         longer(known + i) = read(i)
         call self%words(group, "preset", [read(i)%name])
         place = self%locate(group, "preset")
         associate (key => self%groups(place(1))%keys(place(2)))
            if (.not. allocated(key%meanings)) allocate (key%meanings(0))
            call append(key%meanings, read(i)%name//" "//read(i)%title)
         end associate
      end do
      call move_alloc(longer, self%presets)
   end subroutine schema_preset

   !> Declare that some keys of a group must be given where they apply.
   subroutine schema_require(self, group, names)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Their group
      character(len=*), intent(in) :: names              !! The keys, blanks between
      type(text_t), allocatable :: keys(:)
      integer :: i, place(2)

      call split(names, keys)
      do i = 1, size(keys)
         place = self%locate(group, keys(i)%text)
         if (place(1) > 0) self%groups(place(1))%keys(place(2))%required = .true.
      end do
   end subroutine schema_require

   !> Give the reason for the range of a key, for the message about a value outside of it.
   subroutine schema_explain_range(self, group, name, hint)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: hint               !! Ends a message, with its code
      integer :: place(2)

      place = self%locate(group, name)
      if (place(1) > 0) self%groups(place(1))%keys(place(2))%range%hint = hint
   end subroutine schema_explain_range

   !> Declare that the texts of a key are names of groups of another kind.
   subroutine schema_refer(self, group, name, target)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: target             !! Repeated group with a key `name`
      integer :: place(2)

      place = self%locate(group, name)
      if (place(1) > 0) self%groups(place(1))%keys(place(2))%target = target
   end subroutine schema_refer

   !> Declare that a restart may change keys of a group, and what depends on them.
   subroutine schema_allow_change(self, group, keys, meaning)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Their group
      character(len=*), intent(in) :: keys               !! As in `change_rule_t`, blanks between
      integer, intent(in) :: meaning                     !! One of the constants of deck_key_rules

      call add_changes(self, group, keys, change_rule_t(meaning, "", "", ""))
   end subroutine schema_allow_change

   !> Declare that a restart must not change keys of a group.
   subroutine schema_forbid_change(self, group, keys, why, without)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Their group
      character(len=*), intent(in) :: keys               !! As in `change_rule_t`, blanks between
      character(len=*), intent(in) :: why                !! Reason, for the message
      character(len=*), intent(in), optional :: without  !! Only in groups that lack this key

      if (present(without)) then
         call add_changes(self, group, keys, change_rule_t(may_not_change, "", why, without))
      else
         call add_changes(self, group, keys, change_rule_t(may_not_change, "", why, ""))
      end if
   end subroutine schema_forbid_change

   !> Append one rule for each key.
   subroutine add_changes(self, group, keys, rule)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Their group
      character(len=*), intent(in) :: keys               !! The keys, blanks between
      type(change_rule_t), intent(in) :: rule            !! The rule, without its key
      type(change_rule_t), allocatable :: longer(:)
      type(text_t), allocatable :: names(:)
      integer :: i, number, place(2)

      call split(keys, names)
      do i = 1, size(names)
         place = [self%find(group), 0]
         if (scan(names(i)%text, "*+-#") == 0) place = self%locate(group, names(i)%text)
         if (place(1) == 0) cycle
         associate (known => self%groups(place(1))%changes)
            number = size(known)
            allocate (longer(number + 1))
            longer(:number) = known
         end associate
         longer(number + 1) = rule
         longer(number + 1)%key = names(i)%text
         call move_alloc(longer, self%groups(place(1))%changes)
      end do
   end subroutine add_changes

   !> Indices of the group and of a key that must have been declared.
   function schema_locate(self, group, name) result(place)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: group              !! Group of the key
      character(len=*), intent(in) :: name
      integer :: place(2)

      place(1) = self%find(group)
      place(2) = 0
      if (place(1) > 0) place(2) = self%groups(place(1))%find(name)
      if (place(2) > 0) return
      place = 0
      call record_mistake(self, group//"."//name//", which is not declared")
   end function schema_locate

   !> Record a mistake in a declaration. Only the first one is kept.
   subroutine record_mistake(self, what)
      class(schema_t), intent(inout) :: self
      character(len=*), intent(in) :: what               !! Error message

      if (.not. allocated(self%fault)) self%fault = "declaration of the deck: "//what//" [R124]"
   end subroutine record_mistake

   !> Index of a group, 0 if there is none of that name.
   pure integer function schema_find(self, name) result(place)
      class(schema_t), intent(in) :: self
      character(len=*), intent(in) :: name

      place = 0
      if (.not. allocated(self%groups)) return
      do place = size(self%groups), 1, -1
         if (self%groups(place)%name == name) return
      end do
   end function schema_find

   !> Index of a key, 0 if there is none of that name.
   pure integer function group_rule_find(self, name) result(place)
      class(group_rule_t), intent(in) :: self
      character(len=*), intent(in) :: name

      do place = size(self%keys), 1, -1
         if (self%keys(place)%name == name) return
      end do
   end function group_rule_find

   !> Names of all keys.
   pure function group_rule_names(self) result(names)
      class(group_rule_t), intent(in) :: self
      type(text_t), allocatable :: names(:)
      integer :: i

      allocate (names(size(self%keys)))
      do i = 1, size(names)
         names(i)%text = self%keys(i)%name
      end do
   end function group_rule_names

   !> Names of all groups.
   pure function schema_names(self) result(names)
      class(schema_t), intent(in) :: self
      type(text_t), allocatable :: names(:)
      integer :: i

      allocate (names(size(self%groups)))
      do i = 1, size(names)
         names(i)%text = self%groups(i)%name
      end do
   end function schema_names
end module deck_schema
