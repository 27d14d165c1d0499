! SPDX-License-Identifier: BSD-3-Clause
!> The command line: options and their values.
module program_command_line
   use base_clock, only: clock_seconds, is_clock
   use base_error, only: error_t
   use base_hash, only: add_hash, hash_text, mix
   use base_names, only: text_problem
   use base_text, only: append, closest, number, text_t
   use deck_override, only: removal_mark
   use program_job_templates, only: scheduler_list, schedulers
   use run_command, only: check_command, command_line_error, command_t
   implicit none
   private

   public :: parse_command_line

   !> One option.
   type :: option_t
      character(len=11) :: name                          !! After the two dashes
      character(len=1) :: letter                         !! After one dash, or blank
      integer :: takes                                   !! One of the constants below
   end type option_t

   integer, parameter :: nothing = 0, a_value = 1, perhaps_a_value = 2
   type(option_t), parameter :: options(27) = [ &
      option_t("help    ", "h", nothing), option_t("version ", "V", nothing), &
      option_t("check   ", "n", nothing), option_t("restart ", "r", perhaps_a_value), &
      option_t("set     ", "s", a_value), option_t("case    ", "c", a_value), &
      option_t("outdir  ", "o", a_value), option_t("quiet   ", "q", nothing), &
      option_t("digest  ", " ", a_value), &
      option_t("template", " ", nothing), option_t("explain ", " ", a_value), &
      option_t("list    ", " ", a_value), option_t("point   ", " ", nothing), &
      option_t("force   ", " ", nothing), option_t("new     ", " ", a_value), &
      option_t("job     ", " ", a_value), option_t("ranks   ", " ", a_value), &
      option_t("nodes   ", " ", a_value), &
      option_t("threads ", " ", a_value), option_t("time    ", " ", a_value), &
      option_t("no-estimate", " ", nothing), option_t("overwrite", " ", nothing), &
      option_t("preview ", "p", nothing), option_t("unset   ", " ", a_value), &
      option_t("grains  ", " ", nothing), option_t("self-test", " ", nothing), &
      option_t("echo    ", " ", nothing)]

contains

   !> Parse and check the arguments.
   subroutine parse_command_line(arguments, command, error)
      type(text_t), intent(in) :: arguments(:)           !! From `program_arguments`
      type(command_t), intent(out) :: command            !! Content
      type(error_t), allocatable, intent(out) :: error   !! Unknown or conflicting options
      logical :: options_end
      integer :: next

      allocate (command%overrides(0))
      options_end = .false.
      next = 1
      do while (next <= size(arguments))
         associate (argument => arguments(next)%text)
            if (argument == "--" .and. .not. options_end) then
               options_end = .true.
               next = next + 1
            else if (index(argument, "-") == 1 .and. len(argument) > 1 .and. .not. options_end) then
               if (index(argument, "--") == 1) then
                  call parse_long(arguments, next, command, error)
               else
                  call parse_short(arguments, next, command, error)
               end if
            else
               call set_deck(argument, command, error)
               next = next + 1
            end if
         end associate
         if (allocated(error)) return
      end do
      call check_arguments(arguments, command, error)
      if (.not. allocated(error)) call check_command(command, error)
   end subroutine parse_command_line

   !> Refuse control characters, which could end a line of a job script or of a log, and find the
   !! hash of the arguments. The argument of --explain may be a message of several lines.
   subroutine check_arguments(arguments, command, error)
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      type(command_t), intent(inout) :: command          !! Gets the hash
      type(error_t), allocatable, intent(out) :: error   !! An argument has such a character
      integer :: n

      if (allocated(command%information%explain)) return
      do n = 1, size(arguments)
         if (text_problem(arguments(n)%text) == "") cycle
         call command_line_error(error, "argument "//number(n)//" "// &
            text_problem(arguments(n)%text))
         return
      end do
      do n = 1, size(arguments)
         if (allocated(command%deck)) then
            if (arguments(n)%text == command%deck) cycle
         end if
         command%hash = mix(add_hash(command%hash, hash_text(arguments(n)%text)))
      end do
   end subroutine check_arguments

   !> Use the argument that is not an option as the deck.
   subroutine set_deck(argument, command, error)
      character(len=*), intent(in) :: argument           !! Path of a deck
      type(command_t), intent(inout) :: command          !! Gets the deck
      type(error_t), allocatable, intent(out) :: error   !! There is one already

      if (argument == "") then
         call command_line_error(error, "the name of the deck is empty [C115]")
      else if (allocated(command%deck)) then
         call command_line_error(error, &
            "one deck at a time, not '"//command%deck//"' and '"//argument//"' [C110]")
      else
         command%deck = argument
      end if
   end subroutine set_deck

   !> An option with two dashes: --name, --name=value, --name value.
   subroutine parse_long(arguments, next, command, error)
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of this one, then of the next
      type(command_t), intent(inout) :: command          !! Receives the options
      type(error_t), allocatable, intent(out) :: error   !! Unknown, or its value is wrong
      character(len=:), allocatable :: name, near, value
      type(text_t), allocatable :: names(:)
      integer :: equals, i, which

      associate (argument => arguments(next)%text)
         equals = index(argument//"=", "=")
         name = argument(3:equals - 1)
         if (equals <= len(argument)) value = argument(equals + 1:)
      end associate
      allocate (names(0))
      which = 0
      do i = 1, size(options)
         call append(names, trim(options(i)%name))
         if (options(i)%name == name) which = i
      end do
      next = next + 1
      if (which == 0) then
         near = closest(name, names)
         if (near /= "") near = "; did you mean --"//near//"?"
         call command_line_error(error, "unknown option --"//name//near//" [C101]")
      else if (options(which)%takes == nothing .and. allocated(value)) then
         call command_line_error(error, "--"//name//" takes no value [C106]")
      else
         call find_value(arguments, next, options(which), value)
         call apply_option(options(which), value, command, error)
      end if
   end subroutine parse_long

   !> Options with one dash: -x, -xvalue, -x value, -xyz.
   subroutine parse_short(arguments, next, command, error)
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of this one, then of the next
      type(command_t), intent(inout) :: command          !! Receives the options
      type(error_t), allocatable, intent(out) :: error   !! Unknown, or its value is wrong
      character(len=:), allocatable :: letters, value
      integer :: at, which

      letters = arguments(next)%text
      next = next + 1
      at = 2
      do which = 1, size(options)
         if (letters(2:) /= trim(options(which)%name)) cycle
         call command_line_error(error, &
            "unknown option "//letters//"; did you mean -"//letters//"? [C101]")
         return
      end do
      do while (at <= len(letters))
         do which = 1, size(options)
            if (options(which)%letter == letters(at:at) .and. letters(at:at) /= " ") exit
         end do
         if (which > size(options)) then
            call command_line_error(error, &
               "unknown option -"//letters(at:at)//" in '"//letters//"'"// &
               suggested_option(letters))
            return
         end if
         at = at + 1
         if (allocated(value)) deallocate (value)
         if (options(which)%takes == a_value .and. at <= len(letters)) then
            value = letters(at:)
            if (value(1:1) == "=") value = value(2:)
            at = len(letters) + 1
         else if (at > len(letters)) then
            call find_value(arguments, next, options(which), value)
         end if
         call apply_option(options(which), value, command, error)
         if (allocated(error)) return
      end do
   end subroutine parse_short

   !> Suggestion for a word with one dash that is close to the name of an option with two.
   function suggested_option(word) result(text)
      character(len=*), intent(in) :: word               !! With its dash
      character(len=:), allocatable :: text
      type(text_t), allocatable :: names(:)
      integer :: i

      allocate (names(0))
      do i = 1, size(options)
         call append(names, trim(options(i)%name))
      end do
      text = closest(word(2:scan(word//"=", "=") - 1), names)
      if (len(word) < 4) text = ""
      if (text /= "") text = "; did you mean --"//text//"?"
   end function suggested_option

   !> Use the next argument as value of an option that needs one. The file of --restart is optional
   !! and must end in .h5, since the next argument may be the deck.
   subroutine find_value(arguments, next, option, value)
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of the one after the option
      type(option_t), intent(in) :: option
      character(len=:), allocatable, intent(inout) :: value !! Value
      integer :: last

      if (allocated(value) .or. option%takes == nothing .or. next > size(arguments)) return
      last = len(arguments(next)%text)
      if (option%takes == perhaps_a_value) then
         if (last < 3) return
         if (arguments(next)%text(last - 2:) /= ".h5") return
      end if
      value = arguments(next)%text
      next = next + 1
   end subroutine find_value

   !> Store an option in the command.
   subroutine apply_option(option, value, command, error)
      type(option_t), intent(in) :: option
      character(len=:), allocatable, intent(in) :: value !! Value
      type(command_t), intent(inout) :: command          !! Receives the options
      type(error_t), allocatable, intent(out) :: error   !! The value is missing

      if (option%name == "list" .and. .not. allocated(value)) then
         command%information%list = ""
         return
      end if
      call require_value(option, value, error)
      if (allocated(error)) return
      select case (option%name)
      case ("help")
         command%information%help = .true.
      case ("version")
         command%information%version = .true.
      case ("check", "echo", "preview", "point", "grains", "self-test")
         command%check = command%check .or. option%name == "check"
         command%information%echo = command%information%echo .or. option%name == "echo"
         command%preview = command%preview .or. option%name == "preview"
         command%point = command%point .or. option%name == "point"
         command%grains = command%grains .or. option%name == "grains"
         command%self_test = command%self_test .or. option%name == "self-test"
      case ("no-estimate")
         command%estimate = .false.
      case ("restart")
         command%restart = .true.
         if (allocated(value)) command%checkpoint = value
      case ("overwrite")
         command%output%overwrite = .true.
      case ("set")
         call append(command%overrides, value)
      case ("unset")
         call append(command%overrides, removal_mark//value)
      case ("case")
         command%output%case_name = value
      case ("outdir")
         command%output%folder = value
      case ("quiet")
         command%output%quiet = .true.
      case ("force")
         command%force = .true.
      case ("digest")
         command%information%digest = value
      case ("template")
         command%information%template = .true.
      case ("explain")
         command%information%explain = value
      case ("list")
         command%information%list = value
      case ("new")
         command%example%name = value
      case default
         call apply_job_option(option, value, command, error)
      end select
   end subroutine apply_option

   !> Refuse an option without its value.
   subroutine require_value(option, value, error)
      type(option_t), intent(in) :: option
      character(len=:), allocatable, intent(in) :: value !! Value
      type(error_t), allocatable, intent(out) :: error   !! The value is missing

      if (option%takes /= a_value) return
      if (.not. allocated(value)) then
         call command_line_error(error, "--"//trim(option%name)//" needs a value [C112]")
      else if (value == "") then
         call command_line_error(error, "the value of --"//trim(option%name)//" is empty [C105]")
      end if
   end subroutine require_value

   !> Store an option of the job script in the command.
   subroutine apply_job_option(option, value, command, error)
      type(option_t), intent(in) :: option
      character(len=*), intent(in) :: value              !! Value
      type(command_t), intent(inout) :: command          !! Receives the options
      type(error_t), allocatable, intent(out) :: error   !! The value is not valid
      logical :: right

      select case (option%name)
      case ("ranks")
         call read_count(option, value, command%job%ranks, error)
      case ("nodes")
         call read_count(option, value, command%job%nodes, error)
      case ("threads")
         call read_count(option, value, command%job%threads, error)
      case ("time")
         command%job%time = value
         right = is_clock(value)
         if (right) right = clock_seconds(value) > 0
         if (.not. right) call command_line_error(error, "--time = '"//value// &
            "' must be hours, minutes and seconds such as 04:00:00, or with days 2-00:00:00 [C113]")
      case default
         command%job%scheduler = value
         if (all(schedulers /= value)) call command_line_error(error, &
            "--job knows "//scheduler_list("and")//", not '"//value//"' [C204]")
      end select
   end subroutine apply_job_option

   !> Read an integer above 0.
   subroutine read_count(option, value, count, error)
      type(option_t), intent(in) :: option
      character(len=*), intent(in) :: value              !! Value
      integer, intent(out) :: count                      !! Value of the option
      type(error_t), allocatable, intent(out) :: error   !! Not an integer above 0
      integer, parameter :: most_digits = 8

      count = 0
      if (verify(value, "0123456789") == 0 .and. len(value) <= most_digits) read (value, *) count
      if (count <= 0) call command_line_error(error, "--"//trim(option%name)//" = '"//value// &
         "' must be an integer above 0")
   end subroutine read_count
end module program_command_line
