! SPDX-License-Identifier: BSD-3-Clause
!> What a library with a strength law declares about itself: a text with one statement a line.
!!
!!     law NAME
!!     stress deviator | whole
!!     flow plastic | none
!!     work scree | library
!!     needs temperature | energy
!!     constant NAME [UNIT] RANGE default NUMBER : meaning
!!     field NAME [UNIT] start NUMBER : meaning
!!
!! RANGE is that of keys, such as `> 0 < 1`; range, default and start may be left out. Lines that
!! begin with # are comments.
module material_library_text
   use base_decimal, only: decimal_good, read_decimal
   use base_kinds, only: wp
   use base_text, only: is_letter, line_end, number, split, text_t
   use deck_key_rules, only: read_range
   use deck_schema, only: key_t, kind_real
   use deck_units, only: unit_of
   implicit none
   private

   public :: library_field_t, library_fields_text, library_text_t, read_library_text

   integer, parameter, public :: most_constants = 64     !! Of a library
   integer, parameter, public :: most_law_fields = 64        !! Of a library
   integer, parameter, public :: longest_text = 65536    !! Letters of a declaration
   integer, parameter :: longest_symbol = 31             !! Letters of the name of a constant
   !> Fields of particles that are not those of a library. The plastic strain is common to both.
   character(len=20), parameter :: reserved(36) = [character(len=20) :: "identity", "material", &
      "body", "mass", "volume", "density", "velocity", "speed", "reference", "stress", "pressure", &
      "mises", "viscous_pressure", "energy", "temperature", "equivalent_strain", &
      "inertial_number", "damage", "failed", "deformation_gradient", "plastic_dilation", &
      "porosity", "scatter", "overload", "bulking", "solid_fraction", "bond", "extent", "domain", &
      "affine", "spin", "ahead", "burn_time", "fragment", "position", "load_marks"]

   !> A history field of a library.
   type :: library_field_t
      character(len=:), allocatable :: name          !! Name in files
      character(len=:), allocatable :: unit          !! SI unit
      character(len=:), allocatable :: meaning       !! For the user
      real(wp) :: start = 0.0_wp                     !! Value of new particles
   end type library_field_t

   !> The declaration of a library.
   type :: library_text_t
      character(len=:), allocatable :: name          !! Name of the law
      logical :: whole = .false.                     !! It gives the whole stress
      logical :: plastic = .true.                    !! It flows
      logical :: own_work = .false.                  !! It gives the work of its flow
      logical :: needs_temperature = .false.         !! It reads the temperature
      logical :: needs_energy = .false.              !! It reads the internal energy
      type(key_t), allocatable :: constants(:)       !! As keys of a deck, in their order
      type(library_field_t), allocatable :: fields(:) !! In their order
   end type library_text_t

contains

   !> Read a declaration.
   subroutine read_library_text(text, declared, mistake)
      character(len=*), intent(in) :: text           !! Lines of the declaration
      type(library_text_t), intent(out) :: declared
      character(len=:), allocatable, intent(out) :: mistake !! Empty if there is none
      character(len=:), allocatable :: line
      integer :: first, last, row

      mistake = ""
      allocate (declared%constants(0), declared%fields(0))
      first = 1
      row = 0
      do while (first <= len(text))
         last = line_end(text, first)
         line = trim(adjustl(text(first:last)))
         first = last + 2
         row = row + 1
         if (line == "") cycle
         if (line(1:1) == "#") cycle
         call read_statement(line, declared, mistake)
         if (mistake == "") cycle
         mistake = "line "//number(row)//" of its declaration: "//mistake
         return
      end do
      if (.not. allocated(declared%name)) mistake = "its declaration has no line 'law NAME'"
   end subroutine read_library_text

   !> Names and units of the fields of a library, as the key library_fields has them.
   pure function library_fields_text(declared) result(text)
      type(library_text_t), intent(in) :: declared
      character(len=:), allocatable :: text
      integer :: n

      text = "none"
      do n = 1, size(declared%fields)
         if (n == 1) text = ""
         if (n > 1) text = text//", "
         text = text//declared%fields(n)%name//" ["//declared%fields(n)%unit//"]"
      end do
   end function library_fields_text

   !> Read one line.
   subroutine read_statement(line, declared, mistake)
      character(len=*), intent(in) :: line           !! Not empty
      type(library_text_t), intent(inout) :: declared
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none
      type(text_t), allocatable :: words(:)
      integer :: colon

      colon = index(line//" :", " :")
      call split(line(:min(colon, len(line))), words)
      if (size(words) < 2) then
         mistake = "'"//line//"' has a name or a word missing"
         return
      end if
      select case (words(1)%text)
      case ("constant")
         call read_constant(words, trim(adjustl(line(min(colon + 2, len(line) + 1):))), declared, &
            mistake)
      case ("field")
         call read_field(words, trim(adjustl(line(min(colon + 2, len(line) + 1):))), declared, &
            mistake)
      case default
         call read_property(words, declared, mistake)
      end select
   end subroutine read_statement

   !> Read a line that states a property of the law.
   subroutine read_property(words, declared, mistake)
      type(text_t), intent(in) :: words(:)           !! At least two
      type(library_text_t), intent(inout) :: declared
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none

      if (size(words) > 2) then
         mistake = "'"//words(1)%text//"' takes one word"
         return
      end if
      select case (words(1)%text//" "//words(2)%text)
      case ("stress deviator")
         declared%whole = .false.
      case ("stress whole")
         declared%whole = .true.
      case ("flow plastic")
         declared%plastic = .true.
      case ("flow none")
         declared%plastic = .false.
      case ("work scree")
         declared%own_work = .false.
      case ("work library")
         declared%own_work = .true.
      case ("needs temperature")
         declared%needs_temperature = .true.
      case ("needs energy")
         declared%needs_energy = .true.
      case default
         mistake = "'"//words(1)%text//" "//words(2)%text//"' is not one of law NAME, stress "// &
            "deviator, stress whole, flow plastic, flow none, work scree, work library, needs "// &
            "temperature, needs energy, constant, field"
         if (words(1)%text /= "law") return
         mistake = ""
         if (allocated(declared%name)) mistake = "'law' is given twice"
         if (mistake == "") call check_symbol(words(2)%text, mistake)
         declared%name = words(2)%text
      end select
   end subroutine read_property

   !> Read a line that declares a constant, as a key of a deck.
   subroutine read_constant(words, meaning, declared, mistake)
      type(text_t), intent(in) :: words(:)           !! At least two
      character(len=*), intent(in) :: meaning        !! Text after the colon
      type(library_text_t), intent(inout) :: declared
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none
      type(key_t), allocatable :: longer(:)
      type(key_t) :: key
      integer :: i, next
      logical :: known

      call read_head(words, key%unit_text, next, mistake)
      if (mistake /= "") return
      key%group = "material"
      key%kind = kind_real
      key%name = words(2)%text
      key%doc = meaning
      if (key%unit_text == "1") key%unit_text = ""
      call unit_of(key%unit_text, key%unit, known)
      key%range%hint = ""
      key%range%text = ""
      do while (next <= size(words))
         if (words(next)%text == "default") exit
         key%range%text = trim(key%range%text//" "//words(next)%text)
         next = next + 1
      end do
      if (len(key%range%text) > 0) call read_bounds(adjustl(key%range%text), key, mistake)
      if (mistake == "") call read_start(words, next, "default", key%default, mistake)
      if (mistake == "" .and. any([(declared%constants(i)%name == key%name, &
         i=1, size(declared%constants))])) mistake = "constant '"//key%name//"' is given twice"
      if (mistake == "" .and. size(declared%constants) == most_constants) &
         mistake = "there are more than "//number(most_constants)//" constants"
      if (mistake /= "") return
      allocate (longer(size(declared%constants) + 1))
      longer(:size(longer) - 1) = declared%constants
      longer(size(longer)) = key
      call move_alloc(longer, declared%constants)
   end subroutine read_constant

   !> Read the range of a constant.
   subroutine read_bounds(text, key, mistake)
      character(len=*), intent(in) :: text           !! Such as > 0
      type(key_t), intent(inout) :: key
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none
      logical :: known

      known = scan(text(1:1), "<>") == 1
      if (known) call read_range(trim(text), key%range, known)
      if (.not. known) mistake = "'"//trim(text)//"' is not a range such as > 0, or >= 0 <= 1"
   end subroutine read_bounds

   !> Read a line that declares a field.
   subroutine read_field(words, meaning, declared, mistake)
      type(text_t), intent(in) :: words(:)           !! At least two
      character(len=*), intent(in) :: meaning        !! Text after the colon
      type(library_text_t), intent(inout) :: declared
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none
      type(library_field_t), allocatable :: longer(:)
      type(library_field_t) :: field
      character(len=:), allocatable :: start
      integer :: i, next, verdict

      call read_head(words, field%unit, next, mistake)
      if (mistake == "") call read_start(words, next, "start", start, mistake)
      if (mistake /= "") return
      field%name = words(2)%text
      field%meaning = meaning
      if (allocated(start)) call read_decimal(start, 0, field%start, verdict)
      if (any([(declared%fields(i)%name == field%name, i=1, size(declared%fields))])) &
         mistake = "field '"//field%name//"' is given twice"
      if (any(reserved == field%name)) mistake = "field '"//field%name//"' has the name of a "// &
         "field of every material; choose another name"
      if (field%name == "plastic_strain" .and. (field%unit /= "1" .or. &
         abs(field%start) > 0.0_wp)) mistake = "field 'plastic_strain' is common to all laws; "// &
         "it has unit [1] and starts at 0"
      if (mistake == "" .and. size(declared%fields) == most_law_fields) &
         mistake = "there are more than "//number(most_law_fields)//" fields"
      if (mistake /= "") return
      allocate (longer(size(declared%fields) + 1))
      longer(:size(longer) - 1) = declared%fields
      longer(size(longer)) = field
      call move_alloc(longer, declared%fields)
   end subroutine read_field

   !> Read name and unit of a constant or field.
   subroutine read_head(words, unit, next, mistake)
      type(text_t), intent(in) :: words(:)           !! At least two
      character(len=:), allocatable, intent(out) :: unit !! SI unit, 1 without dimension
      integer, intent(out) :: next                   !! First word behind the unit
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none
      integer, parameter :: longest_unit = 16
      character(len=:), allocatable :: text
      logical :: known

      unit = "1"
      next = 3
      call check_symbol(words(2)%text, mistake)
      if (mistake /= "") return
      text = ""
      do while (next <= size(words))
         text = text//" "//words(next)%text
         next = next + 1
         if (index(text, "]") > 0) exit
      end do
      text = trim(adjustl(text))
      known = len(text) > 2 .and. index(text, "[") == 1 .and. index(text, "]") == len(text)
      if (.not. known) then
         mistake = "'"//words(2)%text//"' needs a unit in brackets, such as [Pa], or [1]"
         return
      end if
      unit = text(2:len(text) - 1)
      if (unit == "1") return
      known = len(unit) <= longest_unit
      if (known) call check_unit(unit, known)
      if (.not. known) mistake = "'"//unit//"' is not a unit of SI such as Pa, 1/s or J/(kg K)"
   end subroutine read_head

   !> True if a text is a unit of SI other than an angle.
   pure subroutine check_unit(text, known)
      use deck_units, only: unit_t
      character(len=*), intent(in) :: text
      logical, intent(out) :: known
      type(unit_t) :: unit

      call unit_of(text, unit, known)
      known = known .and. text /= "deg"
   end subroutine check_unit

   !> Read a word with a number behind it, at the end of a line.
   subroutine read_start(words, next, word, value, mistake)
      type(text_t), intent(in) :: words(:)           !! Words of the line
      integer, intent(in) :: next                    !! The first of them
      character(len=*), intent(in) :: word           !! What it must be
      character(len=:), allocatable, intent(out) :: value !! Not allocated: not given
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none
      real(wp) :: known
      integer :: verdict

      if (next > size(words)) return
      verdict = decimal_good + 1
      if (words(next)%text == word .and. size(words) == next + 1) &
         call read_decimal(words(next + 1)%text, 0, known, verdict)
      if (verdict == decimal_good) then
         value = words(next + 1)%text
      else
         mistake = "'"//words(next)%text//"' is not '"//word//"' with a number; the meaning "// &
            "stands behind ' : '"
      end if
   end subroutine read_start

   !> Check the name of a law, constant or field.
   subroutine check_symbol(name, mistake)
      character(len=*), intent(in) :: name
      character(len=:), allocatable, intent(inout) :: mistake !! Empty if there is none
      character(len=*), parameter :: others = "0123456789_"
      integer :: i

      if (len(name) > longest_symbol) then
         mistake = "name '"//name(:longest_symbol)//"...' is longer than "// &
            number(longest_symbol)//" letters"
         return
      end if
      do i = 1, len(name)
         if (is_letter(name(i:i))) cycle
         if (i > 1 .and. index(others, name(i:i)) > 0) cycle
         mistake = "name '"//name//"' must begin with a letter and have letters, digits and "// &
            "underscores only"
         return
      end do
   end subroutine check_symbol
end module material_library_text
