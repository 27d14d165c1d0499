! SPDX-License-Identifier: BSD-3-Clause
!> Formulas of a deck such as `v*sind(30)`: compiled once into a list of operations, then evaluated.
!!
!! Operators are + - * / ** with the precedence of Fortran; `**` binds to the right, and -2**2 is
!! -4. All operations are in double precision, in this order.
module deck_formula
   use base_constants, only: pi
   use base_decimal, only: decimal_good, read_decimal
   use base_kinds, only: wp
   use base_text, only: append, closest, is_letter, lower, number, text_t
   use deck_formula_functions, only: apply_function, apply_operator, function_arguments, &
      function_index, function_names, takes_any
   implicit none
   private

   public :: formula_t, is_reserved

   integer, parameter :: code_constant = 1           !! Push a constant
   integer, parameter :: code_variable = 2           !! Push a variable
   integer, parameter :: code_negate = 3             !! Change the sign of the top
   integer, parameter :: code_operator = 10          !! First code above: + - * / ^ on the top two
   integer, parameter :: code_function = 20          !! First code above: functions
   character(len=*), parameter :: operators = "+-*/^"
   character(len=*), parameter :: figures = "0123456789"

   !> A compiled formula.
   type :: formula_t
      integer, private :: count = 0                      !! Number of operations
      integer, private :: depth = 0                      !! Greatest number of values at a time
      integer, allocatable, private :: code(:)           !! (operation) Operation code
      integer, allocatable, private :: operand(:)        !! (operation) Which variable
      integer, allocatable, private :: place(:)          !! (operation) Position in the text
      real(wp), allocatable, private :: constant(:)      !! (operation) A constant
   contains
      procedure :: compile => formula_compile            !! Compile a text
      procedure :: evaluate => formula_evaluate          !! Its value for values of the variables
      procedure :: uses => formula_uses                  !! Does it depend on some variables?
   end type formula_t

   !> State of the parser.
   type :: parser_t
      character(len=:), allocatable :: text              !! Lower case
      integer :: at = 1                                  !! Next letter
      integer :: stack = 0                               !! Values on the stack so far
      type(text_t), allocatable :: names(:)              !! Names of the variables
      character(len=:), allocatable :: fault             !! First error, empty if there is none
      integer :: fault_place = 0                         !! Position of the wrong letter
   end type parser_t

contains

   !> True if a name is that of a function or of a constant, so that no variable can have it.
   pure logical function is_reserved(name) result(yes)
      character(len=*), intent(in) :: name               !! Lower case

      yes = name == "pi" .or. function_index(name) > 0
   end function is_reserved

   !> Compile a text.
   subroutine formula_compile(self, text, names, fault, place)
      class(formula_t), intent(out) :: self
      character(len=*), intent(in) :: text               !! Without braces
      type(text_t), intent(in) :: names(:)               !! The variables, in small letters
      character(len=:), allocatable, intent(out) :: fault !! Error, empty if there is none
      integer, intent(out) :: place                      !! Position of the error
      type(parser_t) :: parser

      parser%text = lower(text)//" "
      parser%names = names
      parser%fault = ""
      allocate (self%code(len(text) + 1), self%operand(len(text) + 1), self%place(len(text) + 1), &
         source=0)
      allocate (self%constant(len(text) + 1), source=0.0_wp)
      if (text == "") then
         call set_fault(parser, "the expression is empty [D203]")
      else
         call parse_sum(self, parser)
         if (next_letter(parser) /= " ") call set_fault(parser, "cannot follow here: '"// &
            parser%text(parser%at:parser%at)//"'"//advice(parser%text(parser%at:parser%at))// &
            " [D203]")
      end if
      call move_alloc(parser%fault, fault)
      place = parser%fault_place
   end subroutine formula_compile

   !> Advice for a character that is not valid at its position.
   pure function advice(letter) result(text)
      character(len=1), intent(in) :: letter             !! Character at its position
      character(len=:), allocatable :: text

      text = ""
      if (letter == "^") text = "; a power is written **"
      if (scan(letter, "{}[]") == 1) text = "; brackets in an expression are ( )"
      if (letter == ",") text = "; write separate braces for each number"
      if (is_letter(letter) .or. scan(letter, figures//"(") == 1) text = "; is an operator missing?"
   end function advice

   !> Record the first error and end the parsing.
   pure subroutine set_fault(parser, fault, place)
      type(parser_t), intent(inout) :: parser
      character(len=*), intent(in) :: fault              !! Errors and warnings
      integer, intent(in), optional :: place             !! Its position, default: the current one

      if (parser%fault /= "") return
      parser%fault = fault
      parser%fault_place = parser%at
      if (present(place)) parser%fault_place = place
      parser%at = len(parser%text)
   end subroutine set_fault

   !> The next character that is not blank; a blank at the end.
   character(len=1) function next_letter(parser) result(letter)
      type(parser_t), intent(inout) :: parser            !! Moves to this character

      do while (parser%at < len(parser%text))
         if (parser%text(parser%at:parser%at) > " ") exit
         parser%at = parser%at + 1
      end do
      letter = parser%text(parser%at:parser%at)
   end function next_letter

   !> Append an operation.
   subroutine append_operation(self, parser, code, gain, place, constant, operand)
      type(formula_t), intent(inout) :: self
      type(parser_t), intent(inout) :: parser            !! Counts the values
      integer, intent(in) :: code                        !! Operation code
      integer, intent(in) :: gain                        !! Change of the stack: 1, 0 or -1
      integer, intent(in) :: place                       !! Letter of the text
      real(wp), intent(in), optional :: constant         !! Value of a constant
      integer, intent(in), optional :: operand           !! Index of a variable

      if (parser%fault /= "") return
      self%count = self%count + 1
      self%code(self%count) = code
      self%place(self%count) = place
      if (present(constant)) self%constant(self%count) = constant
      if (present(operand)) self%operand(self%count) = operand
      parser%stack = parser%stack + gain
      self%depth = max(self%depth, parser%stack)
   end subroutine append_operation

   !> Parse terms with + and - between them.
   recursive subroutine parse_sum(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser
      character(len=1) :: sign
      integer :: place

      call parse_product(self, parser)
      do
         sign = next_letter(parser)
         if (scan(sign, "+-") /= 1) return
         place = parser%at
         parser%at = parser%at + 1
         call parse_product(self, parser)
         call append_operation(self, parser, code_operator + index(operators, sign), -1, place)
      end do
   end subroutine parse_sum

   !> Parse factors with * and / between them.
   recursive subroutine parse_product(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser
      character(len=1) :: sign
      integer :: place

      call parse_signed(self, parser)
      do
         sign = next_letter(parser)
         if (scan(sign, "*/") /= 1) return
         place = parser%at
         parser%at = parser%at + 1
         call parse_signed(self, parser)
         call append_operation(self, parser, code_operator + index(operators, sign), -1, place)
      end do
   end subroutine parse_product

   !> Parse a power with optional signs, which have lower precedence than the power.
   recursive subroutine parse_signed(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser
      integer :: place

      select case (next_letter(parser))
      case ("-")
         place = parser%at
         parser%at = parser%at + 1
         call parse_signed(self, parser)
         call append_operation(self, parser, code_negate, 0, place)
      case ("+")
         parser%at = parser%at + 1
         call parse_signed(self, parser)
      case default
         ! a value with an optional exponent
         call parse_value(self, parser)
         if (next_letter(parser) /= "*") return
         place = parser%at
         if (parser%text(place + 1:min(place + 1, len(parser%text))) /= "*") return
         parser%at = place + 2
         call parse_signed(self, parser)
         call append_operation(self, parser, code_operator + index(operators, "^"), -1, place)
      end select
   end subroutine parse_signed

   !> Parse a number, a name, a function, or a sum in brackets.
   recursive subroutine parse_value(self, parser)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser
      character(len=1) :: letter
      integer :: opening, first, last, mark, verdict
      real(wp) :: value

      letter = next_letter(parser)
      opening = parser%at
      if (letter == "(") then
         parser%at = parser%at + 1
         call parse_sum(self, parser)
         call close_bracket(parser, opening)
      else if (is_letter(letter)) then
         call parse_name(self, parser)
      else if (scan(letter, figures//".") == 1) then
         ! a number without a sign
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
            call set_fault(parser, "is not a number: "//parser%text(first:last)//" [D203]")
            return
         end if
         call append_operation(self, parser, code_constant, 1, first, constant=value)
         parser%at = last + 1
      else if (letter == " ") then
         call set_fault(parser, "ends where a number or a name is missing [D203]")
      else
         call set_fault(parser, &
            "a number or a name is missing before '"//letter//"'"//advice(letter)//" [D203]")
      end if
   end subroutine parse_value

   !> Parse the closing bracket of an opening one.
   subroutine close_bracket(parser, opening)
      type(parser_t), intent(inout) :: parser
      integer, intent(in) :: opening                     !! Position of the opening one

      if (parser%fault /= "") return
      if (next_letter(parser) == ")") then
         parser%at = parser%at + 1
      else if (next_letter(parser) == " ") then
         call set_fault(parser, "the bracket ( is not closed [D203]", opening)
      else
         call set_fault(parser, "cannot follow here: '"//next_letter(parser)//"'"// &
            advice(next_letter(parser))//" [D203]")
      end if
   end subroutine close_bracket

   !> Parse a variable, a constant, or a function with its arguments.
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
         call append_operation(self, parser, code_variable, 1, first, operand=n)
         return
      end do
      if (name == "pi") then
         call append_operation(self, parser, code_constant, 1, first, constant=pi)
      else if (which > 0) then
         call set_fault(parser, name//" needs its argument in brackets, such as "//name// &
            "(x) [D203]", first)
      else if (next_letter(parser) == "(") then
         call set_fault(parser, "no function '"//name//"'"//suggestion(name, function_list())// &
            " [D203]", first)
      else
         call set_fault(parser, "no name '"//name//"'"//suggestion(name, name_list(parser))// &
            " [D203]", first)
      end if
   end subroutine parse_name

   !> Parse the arguments of a function.
   recursive subroutine parse_function(self, parser, name, which, first)
      type(formula_t), intent(inout) :: self             !! Gets the operations
      type(parser_t), intent(inout) :: parser            !! At the opening bracket
      character(len=*), intent(in) :: name               !! Name of the function
      integer, intent(in) :: which                       !! Index
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
            call append_operation(self, parser, code_function + which, -1, first)
         if (next_letter(parser) /= ",") exit
      end do
      call close_bracket(parser, opening)
      if (wanted == takes_any) then
         if (given < 2) call set_fault(parser, name//" needs at least 2 arguments [D203]", first)
      else if (given /= wanted) then
         call set_fault(parser, name//" takes "//number(wanted)//" argument"// &
            trim(merge("s", " ", wanted > 1))//", not "//number(given)//" [D203]", first)
      else
         call append_operation(self, parser, code_function + which, 1 - wanted, first)
      end if
   end subroutine parse_function

   !> Suggestion of a name that is close.
   function suggestion(name, names) result(question)
      character(len=*), intent(in) :: name               !! Text as written
      type(text_t), intent(in) :: names(:)               !! Valid names
      character(len=:), allocatable :: question

      question = closest(name, names)
      if (question /= "") question = "; did you mean '"//question//"'?"
   end function suggestion

   !> All functions.
   function function_list() result(names)
      type(text_t), allocatable :: names(:)
      integer :: n

      allocate (names(0))
      do n = 1, size(function_names)
         call append(names, trim(function_names(n)))
      end do
   end function function_list

   !> All variables and constants.
   function name_list(parser) result(names)
      type(parser_t), intent(in) :: parser               !! Has the names of the variables
      type(text_t), allocatable :: names(:)

      names = parser%names
      call append(names, "pi")
   end function name_list

   !> True if a formula depends on one of some variables.
   pure logical function formula_uses(self, marked) result(yes)
      class(formula_t), intent(in) :: self
      logical, intent(in) :: marked(:)                   !! (variable) Is it one of them?
      integer :: n

      yes = .false.
      do n = 1, self%count
         if (self%code(n) == code_variable) yes = yes .or. marked(self%operand(n))
      end do
   end function formula_uses

   !> The value of a formula that was compiled without an error.
   subroutine formula_evaluate(self, variables, value, fault, place)
      class(formula_t), intent(in) :: self
      real(wp), intent(in) :: variables(:)               !! Values in the order of the names
      real(wp), intent(out) :: value                     !! The result, 0 if there is none
      character(len=:), allocatable, intent(out) :: fault !! Not allocated if there is a result
      integer, intent(out) :: place                      !! Position of the operation with the error
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
end module deck_formula
