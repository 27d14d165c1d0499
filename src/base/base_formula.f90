! SPDX-License-Identifier: BSD-3-Clause
!> Formulas of a deck such as `v*sind(30)`: cut once into a list of operations, then evaluated.
!!
!! Operators are + - * / ** with the precedence of Fortran; `**` binds to the right, and -2**2 is
!! -4. Each operation is one of double precision in the order that this gives.
module base_formula
   use base_constants, only: pi
   use base_decimal, only: decimal_good, read_decimal
   use base_formula_functions, only: apply_function, apply_operator, function_arguments, &
      function_index, function_names, takes_any
   use base_kinds, only: wp
   use base_text, only: append, closest, is_letter, lower, number, text_t
   implicit none
   private

   public :: formula_t, is_reserved

   integer, parameter :: code_constant = 1           !! Push a constant
   integer, parameter :: code_variable = 2           !! Push a variable
   integer, parameter :: code_negate = 3             !! Change the sign of the top
   integer, parameter :: code_operator = 10          !! And above: + - * / ^ on the top two
   integer, parameter :: code_function = 20          !! And above: functions
   character(len=*), parameter :: operators = "+-*/^"
   character(len=*), parameter :: figures = "0123456789"

   !> A formula, ready to be evaluated.
   type :: formula_t
      integer, private :: count = 0                      !! Number of operations
      integer, private :: depth = 0                      !! Greatest number of values at a time
      integer, allocatable, private :: code(:)           !! (operation) What it does
      integer, allocatable, private :: operand(:)        !! (operation) Which variable
      integer, allocatable, private :: place(:)          !! (operation) Letter of the text
      real(wp), allocatable, private :: constant(:)      !! (operation) A constant
   contains
      procedure :: compile => formula_compile            !! Make it of a text
      procedure :: evaluate => formula_evaluate          !! Its value for values of the variables
      procedure :: uses => formula_uses                  !! It depends on some variable
   end type formula_t

   !> The text and how far it has been read.
   type :: parser_t
      character(len=:), allocatable :: text              !! Small letters
      integer :: at = 1                                  !! Next letter
      integer :: stack = 0                               !! Values that are left so far
      type(text_t), allocatable :: names(:)              !! The variables
      character(len=:), allocatable :: fault             !! First mistake, empty if there is none
      integer :: fault_place = 0                         !! Its letter
   end type parser_t

contains

   !> True if a name is that of a function or of a constant, so that no variable can have it.
   pure logical function is_reserved(name) result(yes)
      character(len=*), intent(in) :: name               !! Small letters

      yes = name == "pi" .or. function_index(name) > 0
   end function is_reserved

   !> Make a formula of a text.
   subroutine formula_compile(self, text, names, fault, place)
      class(formula_t), intent(out) :: self              !! The formula
      character(len=*), intent(in) :: text               !! Without braces
      type(text_t), intent(in) :: names(:)               !! The variables, in small letters
      character(len=:), allocatable, intent(out) :: fault !! What is wrong, empty if nothing is
      integer, intent(out) :: place                      !! Letter of the mistake
      type(parser_t) :: parser

      parser%text = lower(text)//" "
      parser%names = names
      parser%fault = ""
      allocate (self%code(len(text) + 1), self%operand(len(text) + 1), self%place(len(text) + 1), &
         source=0)
      allocate (self%constant(len(text) + 1), source=0.0_wp)
      if (text == "") then
         call blame(parser, "the expression is empty")
      else
         call parse_sum(self, parser)
         if (next_letter(parser) /= " ") call blame(parser, "cannot follow here: '"// &
            parser%text(parser%at:parser%at)//"'"//advice(parser%text(parser%at:parser%at)))
      end if
      call move_alloc(parser%fault, fault)
      place = parser%fault_place
   end subroutine formula_compile

   !> What to write in the place of a letter that no formula has.
   pure function advice(letter) result(text)
      character(len=1), intent(in) :: letter             !! The letter
      character(len=:), allocatable :: text

      text = ""
      if (letter == "^") text = "; a power is written **"
      if (scan(letter, "{}[]") == 1) text = "; brackets in an expression are ( )"
      if (letter == ",") text = "; give each number braces of its own"
      if (is_letter(letter) .or. scan(letter, figures//"(") == 1) text = "; is an operator missing?"
   end function advice

   !> Note the first mistake, at the present letter; nothing is read after it.
   pure subroutine blame(parser, fault, place)
      type(parser_t), intent(inout) :: parser            !! The text
      character(len=*), intent(in) :: fault              !! What is wrong
      integer, intent(in), optional :: place             !! Its letter, if not the present one

      if (parser%fault /= "") return
      parser%fault = fault
      parser%fault_place = parser%at
      if (present(place)) parser%fault_place = place
      parser%at = len(parser%text)
   end subroutine blame

   !> The next letter that is no blank; a blank at the end.
   character(len=1) function next_letter(parser) result(letter)
      type(parser_t), intent(inout) :: parser            !! Goes on to this letter

      do while (parser%at < len(parser%text))
         if (parser%text(parser%at:parser%at) > " ") exit
         parser%at = parser%at + 1
      end do
      letter = parser%text(parser%at:parser%at)
   end function next_letter

   !> Append an operation. `gain` is the number of values that it adds.
   subroutine emit(self, parser, code, gain, place, constant, operand)
      type(formula_t), intent(inout) :: self             !! The formula
      type(parser_t), intent(inout) :: parser            !! Counts the values
      integer, intent(in) :: code                        !! What it does
      integer, intent(in) :: gain                        !! 1, 0 or -1
      integer, intent(in) :: place                       !! Letter of the text
      real(wp), intent(in), optional :: constant         !! If it is one
      integer, intent(in), optional :: operand           !! If it is a variable

      if (parser%fault /= "") return
      self%count = self%count + 1
      self%code(self%count) = code
      self%place(self%count) = place
      if (present(constant)) self%constant(self%count) = constant
      if (present(operand)) self%operand(self%count) = operand
      parser%stack = parser%stack + gain
      self%depth = max(self%depth, parser%stack)
   end subroutine emit

   !> Terms with + and - between them.
   recursive subroutine parse_sum(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! The text
      character(len=1) :: sign
      integer :: place

      call parse_product(self, parser)
      do
         sign = next_letter(parser)
         if (scan(sign, "+-") /= 1) return
         place = parser%at
         parser%at = parser%at + 1
         call parse_product(self, parser)
         call emit(self, parser, code_operator + index(operators, sign), -1, place)
      end do
   end subroutine parse_sum

   !> Factors with * and / between them.
   recursive subroutine parse_product(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! The text
      character(len=1) :: sign
      integer :: place

      call parse_signed(self, parser)
      do
         sign = next_letter(parser)
         if (scan(sign, "*/") /= 1) return
         place = parser%at
         parser%at = parser%at + 1
         call parse_signed(self, parser)
         call emit(self, parser, code_operator + index(operators, sign), -1, place)
      end do
   end subroutine parse_product

   !> A power, perhaps with signs before it, which bind less than the power.
   recursive subroutine parse_signed(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! The text
      integer :: place

      select case (next_letter(parser))
      case ("-")
         place = parser%at
         parser%at = parser%at + 1
         call parse_signed(self, parser)
         call emit(self, parser, code_negate, 0, place)
      case ("+")
         parser%at = parser%at + 1
         call parse_signed(self, parser)
      case default
         call parse_power(self, parser)
      end select
   end subroutine parse_signed

   !> A value, perhaps with ** and its exponent.
   recursive subroutine parse_power(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! The text
      integer :: place

      call parse_value(self, parser)
      if (next_letter(parser) /= "*") return
      place = parser%at
      if (parser%text(place + 1:min(place + 1, len(parser%text))) /= "*") return
      parser%at = place + 2
      call parse_signed(self, parser)
      call emit(self, parser, code_operator + index(operators, "^"), -1, place)
   end subroutine parse_power

   !> A number, a name, a function, or a sum in brackets.
   recursive subroutine parse_value(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! The text
      character(len=1) :: letter
      integer :: opening

      letter = next_letter(parser)
      opening = parser%at
      if (letter == "(") then
         parser%at = parser%at + 1
         call parse_sum(self, parser)
         call close_bracket(parser, opening)
      else if (is_letter(letter)) then
         call parse_name(self, parser)
      else if (scan(letter, figures//".") == 1) then
         call parse_number(self, parser)
      else if (letter == " ") then
         call blame(parser, "ends where a number or a name is missing")
      else
         call blame(parser, "a number or a name is missing before '"//letter//"'"//advice(letter))
      end if
   end subroutine parse_value

   !> The closing bracket that belongs to an opening one.
   subroutine close_bracket(parser, opening)
      type(parser_t), intent(inout) :: parser            !! The text
      integer, intent(in) :: opening                     !! Letter of the opening one

      if (parser%fault /= "") return
      if (next_letter(parser) == ")") then
         parser%at = parser%at + 1
      else if (next_letter(parser) == " ") then
         call blame(parser, "the bracket ( is not closed", opening)
      else
         call blame(parser, "cannot follow here: '"//next_letter(parser)//"'"// &
            advice(next_letter(parser)))
      end if
   end subroutine close_bracket

   !> A number without a sign.
   subroutine parse_number(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operation
      type(parser_t), intent(inout) :: parser            !! At its first figure
      integer :: first, last, mark, verdict
      real(wp) :: value

      first = parser%at
      last = first + verify(parser%text(first:), figures//".") - 2
      mark = last + 1
      if (scan(parser%text(mark:mark), "ed") == 1) then
         if (scan(parser%text(mark + 1:mark + 1), "+-") == 1) mark = mark + 1
         if (mark < len(parser%text)) then
            if (scan(parser%text(mark + 1:mark + 1), figures) == 1) &
               last = mark + verify(parser%text(mark + 1:), figures) - 1
         end if
      end if
      call read_decimal(parser%text(first:last), 0, value, verdict)
      if (verdict /= decimal_good) then
         call blame(parser, "is no number: "//parser%text(first:last))
         return
      end if
      call emit(self, parser, code_constant, 1, first, constant=value)
      parser%at = last + 1
   end subroutine parse_number

   !> A variable, a constant, or a function with its arguments.
   recursive subroutine parse_name(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! At its first letter
      character(len=:), allocatable :: name
      integer :: first, n, which

      first = parser%at
      n = first
      do while (is_letter(parser%text(n:n)) .or. scan(parser%text(n:n), figures//"_") == 1)
         n = n + 1
      end do
      name = parser%text(first:n - 1)
      parser%at = n
      which = function_index(name)
      if (next_letter(parser) == "(" .and. which > 0) then
         call parse_function(self, parser, name, which, first)
         return
      end if
      do n = 1, size(parser%names)
         if (parser%names(n)%text /= name) cycle
         call emit(self, parser, code_variable, 1, first, operand=n)
         return
      end do
      if (name == "pi") then
         call emit(self, parser, code_constant, 1, first, constant=pi)
      else if (which > 0) then
         call blame(parser, name//" needs its argument in brackets, such as "//name//"(x)", first)
      else if (next_letter(parser) == "(") then
         call blame(parser, "no function '"//name//"'"//near_names(name, functions_known()), first)
      else
         call blame(parser, "no name '"//name//"'"//near_names(name, names_known(parser)), first)
      end if
   end subroutine parse_name

   !> The arguments of a function in their brackets.
   recursive subroutine parse_function(self, parser, name, which, first)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! At the opening bracket
      character(len=*), intent(in) :: name               !! The function
      integer, intent(in) :: which                       !! Its index
      integer, intent(in) :: first                       !! First letter of its name
      integer :: given, opening, wanted

      opening = parser%at
      wanted = function_arguments(which)
      given = 0
      do
         parser%at = parser%at + 1
         call parse_sum(self, parser)
         given = given + 1
         if (wanted == takes_any .and. given > 1) &
            call emit(self, parser, code_function + which, -1, first)
         if (next_letter(parser) /= ",") exit
      end do
      call close_bracket(parser, opening)
      if (wanted == takes_any) then
         if (given < 2) call blame(parser, name//" needs at least 2 arguments", first)
      else if (given /= wanted) then
         call blame(parser, name//" takes "//number(wanted)//" argument"// &
            trim(merge("s", " ", wanted > 1))//", not "//number(given), first)
      else
         call emit(self, parser, code_function + which, 1 - wanted, first)
      end if
   end subroutine parse_function

   !> A question behind a message if a name is near.
   function near_names(name, names) result(question)
      character(len=*), intent(in) :: name               !! As written
      type(text_t), intent(in) :: names(:)               !! Those that there are
      character(len=:), allocatable :: question

      question = closest(name, names)
      if (question /= "") question = "; did you mean '"//question//"'?"
   end function near_names

   !> All functions.
   function functions_known() result(names)
      type(text_t), allocatable :: names(:)
      integer :: n

      allocate (names(0))
      do n = 1, size(function_names)
         call append(names, trim(function_names(n)))
      end do
   end function functions_known

   !> All variables and constants.
   function names_known(parser) result(names)
      type(parser_t), intent(in) :: parser               !! Knows the variables
      type(text_t), allocatable :: names(:)

      names = parser%names
      call append(names, "pi")
   end function names_known

   !> True if a formula depends on one of some variables.
   pure logical function formula_uses(self, marked) result(yes)
      class(formula_t), intent(in) :: self               !! The formula
      logical, intent(in) :: marked(:)                   !! (variable) Is it one of them?
      integer :: n

      yes = .false.
      do n = 1, self%count
         if (self%code(n) == code_variable) yes = yes .or. marked(self%operand(n))
      end do
   end function formula_uses

   !> The value of a formula that has been compiled without a mistake.
   subroutine formula_evaluate(self, variables, value, fault, place)
      class(formula_t), intent(in) :: self               !! The formula
      real(wp), intent(in) :: variables(:)               !! Values in the order of the names
      real(wp), intent(out) :: value                     !! The result, 0 if there is none
      character(len=:), allocatable, intent(out) :: fault !! Not allocated if there is a result
      integer, intent(out) :: place                      !! Letter of the operation at fault
      real(wp) :: stack(max(self%depth, 1))
      integer :: n, top

      top = 0
      value = 0.0_wp
      place = 0
      do n = 1, self%count
         select case (self%code(n))
         case (code_constant)
            top = top + 1
            stack(top) = self%constant(n)
         case (code_variable)
            top = top + 1
            stack(top) = variables(self%operand(n))
         case (code_negate)
            stack(top) = -stack(top)
         case (code_operator:code_function - 1)
            top = top - 1
            call apply_operator(operators(self%code(n) - code_operator: &
               self%code(n) - code_operator), stack(top), stack(top + 1), fault)
         case default
            if (function_arguments(self%code(n) - code_function) /= 1) top = top - 1
            call apply_function(self%code(n) - code_function, stack(top), &
               stack(min(top + 1, size(stack))), fault)
         end select
         if (allocated(fault)) then
            place = self%place(n)
            return
         end if
      end do
      if (top > 0) value = stack(1)
   end subroutine formula_evaluate
end module base_formula
