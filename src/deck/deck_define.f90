! SPDX-License-Identifier: BSD-3-Clause
!> Names of numbers, `&define v = 3.0 /`, and the expressions in braces that use them.
!!
!! An expression is replaced by its value as a decimal number with all digits, so that it is read
!! like a number in the deck, to the same bits.
module deck_define
   use base_decimal, only: decimal_good, read_decimal
   use base_kinds, only: wp
   use base_text, only: append, closest, lower, number, text_t
   use deck_formula, only: formula_t, is_reserved
   use deck_namelist, only: as_written, block_t, namelist_t, piece_t, token_t
   use deck_problems, only: command_line, problems_t
   use deck_units, only: read_unit, split_unit, unit_t, written_unit_t
   implicit none
   private

   public :: definitions_t, scan_value

   character(len=*), parameter :: group_name = "define"
   character(len=*), parameter :: letters_of_names = "abcdefghijklmnopqrstuvwxyz0123456789_"

   !> The names and their numbers.
   type :: definitions_t
      type(text_t), allocatable :: names(:)              !! In the order of the deck
      real(wp), allocatable :: values(:)                 !! Numbers in the units of the deck
      integer, allocatable, private :: lines(:)          !! Line of each definition
      logical, allocatable, private :: faulty(:)         !! Was an error in the value reported?
      integer, private :: system = 1                     !! Units of the deck
      type(text_t), allocatable, private :: later(:)     !! All names of the deck
   contains
      procedure :: read => definitions_read              !! Read the definitions of a deck
      procedure :: resolve => definitions_resolve        !! Replace the expressions of a value
      procedure, private :: add => definitions_add       !! Add one definition
   end type definitions_t

contains

   !> Read all definitions of a deck. Each may use those before it.
   subroutine definitions_read(self, namelist, overrides, system, problems)
      class(definitions_t), intent(out) :: self
      type(namelist_t), intent(in) :: namelist           !! As written
      type(text_t), intent(in) :: overrides(:)           !! GROUP.KEY=VALUE of the command line
      integer, intent(in) :: system                      !! Units of the numbers
      type(problems_t), intent(inout) :: problems        !! Collects errors
      integer :: i, k

      self%system = system
      allocate (self%names(0), self%values(0), self%lines(0), self%later(0), self%faulty(0))
      do i = 1, namelist%count
         if (namelist%blocks(i)%name /= group_name) cycle
         do k = 1, size(namelist%blocks(i)%pieces)
            call append(self%later, namelist%blocks(i)%pieces(k)%key)
         end do
      end do
      do i = 1, namelist%count
         if (namelist%blocks(i)%name /= group_name) cycle
         do k = 1, size(namelist%blocks(i)%pieces)
            call self%add(namelist%blocks(i), namelist%blocks(i)%pieces(k), overrides, problems)
         end do
      end do
      do i = 1, size(overrides)
         call check_override(self, overrides(i)%text, problems)
      end do
   end subroutine definitions_read

   !> Add one definition, with its value from the command line if there is one.
   subroutine definitions_add(self, block, piece, overrides, problems)
      class(definitions_t), intent(inout) :: self        !! Gets the name
      type(block_t), intent(in) :: block                 !! Its group
      type(piece_t), intent(in) :: piece                 !! As written
      type(text_t), intent(in) :: overrides(:)           !! GROUP.KEY=VALUE of the command line
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(piece_t) :: used
      character(len=:), allocatable :: fault, file, name
      real(wp) :: value
      integer :: i, line, n

      if (piece%key == "") return
      line = piece%line
      call check_name(self, piece, fault)
      used = piece
      used%broken = piece%broken .or. fault /= ""
      if (fault /= "") call problems%error(block%file, line, "&define: "//fault)
      file = block%file
      do i = 1, size(overrides)
         n = index(overrides(i)%text//"=", "=")
         name = lower(trim(adjustl(overrides(i)%text(:n - 1))))
         if (name /= group_name//"."//piece%key .or. n > len(overrides(i)%text)) cycle
         if (fault /= "") exit
         call scan_value(overrides(i)%text(n + 1:), used)
         file = command_line
         line = 0
         if (used%broken) call problems%error(file, line, "&define: "//piece%key//" = "// &
            overrides(i)%text(n + 1:)//"  <- is not a value [C104]")
      end do
      value = 0.0_wp
      if (.not. used%broken) call self%resolve("&define", file, used, problems)
      if (.not. used%broken) then
         call read_value(used%tokens, self%system, value, fault)
         used%broken = fault /= ""
         if (fault /= "") call problems%error(file, line, "&define: "//piece%key//" = "// &
            as_written(used%tokens)//"  <- "//fault)
      end if
      ! a name whose value is in error is known as well, so that its uses are not reported too
      call append(self%names, piece%key)
      self%values = [self%values, value]
      self%lines = [self%lines, piece%line]
      self%faulty = [self%faulty, used%broken]
   end subroutine definitions_add

   !> The error in a name; empty if it is valid.
   subroutine check_name(self, piece, fault)
      class(definitions_t), intent(in) :: self           !! The names before it
      type(piece_t), intent(in) :: piece                 !! As written
      character(len=:), allocatable, intent(out) :: fault !! Follows the group
      integer :: i

      fault = ""
      associate (name => piece%key)
         if (piece%subscript /= "") then
            fault = name//piece%subscript//": a name has one number; use a name for each [D204]"
         else if (verify(name, letters_of_names) > 0 .or. scan(name, "0123456789_") == 1) then
            fault = "'"//name//"' is not a name; names begin with a letter and continue with "// &
               "letters, digits and _ [D204]"
         else if (is_reserved(name)) then
            fault = "'"//name//"' is the name of a function or constant; use another name [D204]"
         end if
         do i = 1, size(self%names)
            if (self%names(i)%text == name .and. fault == "") fault = name// &
               " is given twice, first in line "//number(self%lines(i))//" [D114]"
         end do
      end associate
   end subroutine check_name

   !> Report a value of the command line for a name without a definition.
   subroutine check_override(self, text, problems)
      type(definitions_t), intent(in) :: self            !! All names
      character(len=*), intent(in) :: text               !! GROUP.KEY=VALUE
      type(problems_t), intent(inout) :: problems        !! Gets the error
      character(len=:), allocatable :: name, near
      integer :: i

      name = lower(trim(adjustl(text(:index(text//"=", "=") - 1))))
      if (index(name, group_name//".") /= 1) return
      name = name(len(group_name) + 2:)
      do i = 1, size(self%names)
         if (self%names(i)%text == name) return
      end do
      near = closest(name, self%names)
      if (near /= "") near = "; did you mean '"//near//"'?"
      call problems%error(command_line, 0, "&define: the deck defines no '"//name//"'"//near// &
         " [D204]")
   end subroutine check_override

   !> Cut a value of the command line into tokens.
   subroutine scan_value(text, piece)
      character(len=*), intent(in) :: text               !! Text as written
      type(piece_t), intent(inout) :: piece              !! Gets the tokens, or is marked as broken
      type(namelist_t) :: namelist
      type(problems_t) :: ignored

      call namelist%scan("&g k = "//text//new_line("a")//"/", command_line, ignored)
      piece%broken = ignored%errors > 0 .or. namelist%count /= 1
      if (.not. piece%broken) piece%broken = size(namelist%blocks(1)%pieces) /= 1
      if (.not. piece%broken) piece%tokens = namelist%blocks(1)%pieces(1)%tokens
   end subroutine scan_value

   !> The number of a definition, in the units of the deck.
   subroutine read_value(tokens, system, value, fault)
      type(token_t), intent(in) :: tokens(:)             !! A number, with or without a unit
      integer, intent(in) :: system                      !! Units of the deck
      real(wp), intent(out) :: value                     !! In the units of the deck
      character(len=:), allocatable, intent(out) :: fault !! Error, empty if there is none
      character(len=:), allocatable :: digits, unit
      type(written_unit_t) :: given
      type(unit_t) :: own
      real(wp) :: exponent
      integer :: i, verdict

      value = 0.0_wp
      fault = "expects one number, with or without a unit; expressions need braces, such as "// &
         "{2*pi} [D204]"
      if (size(tokens) == 0) return
      if (any(tokens%quoted) .or. any(tokens%comma)) return
      call split_unit(tokens(1)%text, digits, unit)
      do i = 2, size(tokens)
         if (tokens(i)%formula) return
         unit = trim(unit//" "//tokens(i)%text)
      end do
      call read_unit(given, trim(adjustl(unit)))
      exponent = 0.0_wp
      if (unit /= "" .and. given%fault == "") then
         own%power = given%power
         exponent = given%exponent - own%exponent(system)
      end if
      call read_decimal(digits, nint(exponent), value, verdict)
      if (verdict /= decimal_good) return
      fault = given%fault
      exponent = exponent - real(nint(exponent), wp)
      if (abs(exponent) > 0.0_wp) value = value*10.0_wp**exponent
      if (abs(given%factor - 1.0_wp) > 0.0_wp) value = value*given%factor
   end subroutine read_value

   !> Replace the expressions of a value by their numbers. An error marks the piece as broken.
   subroutine definitions_resolve(self, label, file, piece, problems, within)
      class(definitions_t), intent(in) :: self
      character(len=*), intent(in) :: label              !! The group, for messages
      character(len=*), intent(in) :: file               !! File
      type(piece_t), intent(inout) :: piece              !! As written
      type(problems_t), intent(inout) :: problems        !! Collects errors
      logical, intent(in), optional :: within            !! Also expressions within texts
      character(len=:), allocatable :: fault, where_is
      real(wp) :: value
      integer :: i, line, place, closing, opening
      logical :: faulty, inner

      inner = .false.
      if (present(within)) inner = within
      ! expressions within texts become numbers in brackets
      if (inner) then
         do i = 1, size(piece%tokens)
            associate (token => piece%tokens(i))
               opening = index(token%text, "{")
               do while (opening > 0 .and. .not. piece%broken)
                  closing = opening + index(token%text(opening:)//"}", "}") - 1
                  call evaluate_expression(self, token%text(opening + 1:closing - 1), value, &
                     fault, place, faulty)
                  piece%broken = faulty .or. fault /= ""
                  if (fault /= "") call problems%error(file, merge(0, token%line, &
                     file == command_line), label//": "//piece%key//" = "//token%raw// &
                     "  <- letter "//number(opening + place)//": "//fault)
                  token%text = token%text(:opening - 1)//"("//decimal_text(value)//")"// &
                     token%text(min(closing, len(token%text)) + 1:)
                  opening = index(token%text, "{")
               end do
            end associate
         end do
      end if
      if (.not. any(piece%tokens%formula)) return
      do i = 1, size(piece%tokens)
         associate (token => piece%tokens(i))
            if (.not. token%formula) cycle
            call evaluate_expression(self, token%raw(2:len(token%raw) - 1), value, fault, place, &
               faulty)
            token%text = decimal_text(value)
            piece%broken = piece%broken .or. faulty
            if (fault == "") cycle
            piece%broken = .true.
            line = token%line
            where_is = "column "//number(token%column + place)//": "
            if (file == command_line) then
               line = 0
               where_is = "place "//number(place)//": "
            end if
            call problems%error(file, line, label//": "//piece%key//piece%subscript//" = "// &
               token%raw//"  <- "//where_is//fault)
         end associate
      end do
   end subroutine definitions_resolve

   !> The value of one expression.
   subroutine evaluate_expression(self, text, value, fault, place, faulty)
      class(definitions_t), intent(in) :: self
      character(len=*), intent(in) :: text               !! Without its braces
      real(wp), intent(out) :: value                     !! The value, 0 if there is none
      character(len=:), allocatable, intent(out) :: fault !! Error, empty if there is none
      integer, intent(out) :: place                      !! Position of the error
      logical, intent(out) :: faulty !! Does it use a name whose error was reported?
      type(formula_t) :: formula
      integer :: i

      value = 0.0_wp
      faulty = .false.
      call formula%compile(text, self%names, fault, place)
      if (fault == "") then
         faulty = formula%uses(self%faulty)
         if (faulty) return
         call formula%evaluate(self%values, value, fault, place)
         if (.not. allocated(fault)) fault = ""
         return
      end if
      do i = size(self%names) + 1, size(self%later)
         if (index(fault, "no name '"//self%later(i)%text//"'") == 1) fault = &
            self%later(i)%text//" is defined later; move its definition before this one [D204]"
      end do
      if (any([(fault == "no name '"//"xyz"(i:i)//"' [D203]", i=1, 3)])) then
         fault = fault//"; a formula of the position is written without braces"
      else if (size(self%later) == 0 .and. index(fault, "no name '") == 1) then
         fault = fault//"; names are given by &define name = number /"
      end if
   end subroutine evaluate_expression

   !> A number with all its digits; integers without a decimal point, so that they are valid values
   !! of integer keys.
   pure function decimal_text(value) result(text)
      real(wp), intent(in) :: value                      !! Number
      character(len=:), allocatable :: text
      real(wp), parameter :: most = 2.0e9_wp

      text = number(value)
      if (abs(value) > most .or. sign(1.0_wp, value) < 0.0_wp .and. .not. value < 0.0_wp) return
      if (.not. abs(value - anint(value)) > 0.0_wp) text = number(nint(value))
   end function decimal_text
end module deck_define
