! SPDX-License-Identifier: BSD-3-Clause
!> The options of a run, and the syntax of all options: --name, --name=value, --name value, -x,
!! -xvalue, -xyz. The library reads its arguments with this module; the program adds options of its
!! own by an extension of the type.
module run_options
   use base_error, only: error_t, exit_input, fail
   use base_hash, only: add_hash, hash_text, mix
   use base_kinds, only: int64
   use base_names, only: text_problem
   use base_text, only: append, closest, number, text_t
   use deck_override, only: removal_mark
   implicit none
   private

   public :: a_value, maybe_a_value, no_value, option_error, option_t, run_options_t

   !> One option.
   type :: option_t
      character(len=11) :: name                          !! After the two dashes
      character(len=1) :: letter                         !! After one dash, or blank
      integer :: takes                                   !! One of the constants below
   end type option_t

   integer, parameter :: no_value = 0, a_value = 1, maybe_a_value = 2, a_file = 3 !! What one takes
   type(option_t), parameter :: options_of_a_run(8) = [option_t("restart ", "r", &
      a_file), option_t("set     ", "s", a_value), option_t("unset   ", " ", a_value), &
      option_t("case    ", "c", a_value), option_t("outdir  ", "o", a_value), &
      option_t("quiet   ", "q", no_value), option_t("force   ", " ", no_value), &
      option_t("overwrite", " ", no_value)]

   !> Options of a run. Texts that were not given are not allocated.
   type :: run_options_t
      character(len=:), allocatable :: deck              !! Path of the deck
      logical :: restart = .false.                       !! Continue from a checkpoint
      character(len=:), allocatable :: checkpoint        !! Which one; default: the newest valid one
      type(text_t), allocatable :: overrides(:)          !! GROUP.KEY=VALUE, !GROUP.KEY
      logical :: force = .false.                         !! Override the limits on sizes
      character(len=:), allocatable :: case_name         !! Replaces the case of the deck
      character(len=:), allocatable :: folder            !! Replaces out/CASE
      logical :: overwrite = .false.                     !! Remove the results of a previous run
      logical :: quiet = .false.                         !! Print only warnings and errors
      integer(int64) :: hash = 0                         !! Hash of all words but the deck
      logical :: lines = .false.                         !! May an argument have several lines?
   contains
      procedure :: known => run_options_known            !! The options that may be given
      procedure :: set => run_options_set                !! Store an option
      procedure :: check => run_options_check            !! Check combinations
      procedure :: parse => run_options_parse            !! Read arguments
   end type run_options_t

contains

   !> The options that may be given.
   pure function run_options_known(self) result(options)
      class(run_options_t), intent(in) :: self
      type(option_t), allocatable :: options(:)

      options = options_of_a_run
   end function run_options_known

   !> Read and check the arguments.
   subroutine run_options_parse(self, arguments, error)
      class(run_options_t), intent(inout) :: self        !! As it was declared
      type(text_t), intent(in) :: arguments(:)           !! From `program_arguments`
      type(error_t), allocatable, intent(out) :: error   !! Unknown or conflicting options
      logical :: options_end
      integer :: n, next

      allocate (self%overrides(0))
      options_end = .false.
      next = 1
      do while (next <= size(arguments))
         associate (argument => arguments(next)%text)
            if (argument == "--" .and. .not. options_end) then
               options_end = .true.
               next = next + 1
            else if (index(argument, "-") == 1 .and. len(argument) > 1 .and. .not. options_end) then
               if (index(argument, "--") == 1) then
                  call parse_long(self, arguments, next, error)
               else
                  call parse_short(self, arguments, next, error)
               end if
            else
               next = next + 1
               if (argument == "") then
                  call option_error(error, "the name of the deck is empty [C115]")
               else if (allocated(self%deck)) then
                  call option_error(error, &
                     "one deck at a time, not '"//self%deck//"' and '"//argument//"' [C110]")
               else
                  self%deck = argument
               end if
            end if
         end associate
         if (allocated(error)) return
      end do
      do n = 1, size(arguments)
         ! a control character could end a line of a job script or of a log
         if (.not. (self%lines .or. text_problem(arguments(n)%text) == "")) then
            call option_error(error, "argument "//number(n)//" "//text_problem(arguments(n)%text))
            exit
         end if
         if (allocated(self%deck)) then
            if (arguments(n)%text == self%deck) cycle
         end if
         self%hash = mix(add_hash(self%hash, hash_text(arguments(n)%text)))
      end do
      if (.not. allocated(error)) call self%check(error)
      if (allocated(self%case_name)) call append(self%overrides, "run.case="//self%case_name)
   end subroutine run_options_parse

   !> Refuse options that exclude each other, and arguments without a deck.
   subroutine run_options_check(self, error)
      class(run_options_t), intent(inout) :: self
      type(error_t), allocatable, intent(out) :: error   !! One of these

      if (self%overwrite .and. self%restart) then
         call option_error(error, "--overwrite and --restart exclude each other: a run either "// &
            "starts again or continues; give --outdir to continue in another folder [C107]")
      else if (.not. allocated(self%deck)) then
         call option_error(error, &
            "no deck; usage: scree [options] DECK.nml, and scree --help for more [C115]")
      end if
   end subroutine run_options_check

   !> Store an option.
   subroutine run_options_set(self, option, value, error)
      class(run_options_t), intent(inout) :: self        !! Receives the option
      type(option_t), intent(in) :: option               !! A known one
      character(len=:), allocatable, intent(in) :: value !! Given if the option needs one
      type(error_t), allocatable, intent(out) :: error   !! The value is not valid

      select case (option%name)
      case ("restart")
         self%restart = .true.
         if (allocated(value)) self%checkpoint = value
      case ("overwrite")
         self%overwrite = .true.
      case ("set")
         call append(self%overrides, value)
      case ("unset")
         call append(self%overrides, removal_mark//value)
      case ("case")
         self%case_name = value
      case ("outdir")
         self%folder = value
      case ("quiet")
         self%quiet = .true.
      case default
         self%force = .true.
      end select
   end subroutine run_options_set

   !> An option with two dashes: --name, --name=value, --name value.
   subroutine parse_long(self, arguments, next, error)
      class(run_options_t), intent(inout) :: self        !! Receives the option
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of this one, then of the next
      type(error_t), allocatable, intent(out) :: error   !! Unknown, or its value is wrong
      character(len=:), allocatable :: name, value
      type(option_t), allocatable :: options(:)
      integer :: equals, which

      allocate (options, source=self%known())
      associate (argument => arguments(next)%text)
         equals = index(argument//"=", "=")
         name = argument(3:equals - 1)
         if (equals <= len(argument)) value = argument(equals + 1:)
      end associate
      next = next + 1
      do which = 1, size(options)
         if (options(which)%name == name) exit
      end do
      if (which > size(options)) then
         call option_error(error, "unknown option --"//name// &
            similar_option(options, name)//" [C101]")
      else if (options(which)%takes == no_value .and. allocated(value)) then
         call option_error(error, "--"//name//" takes no value [C106]")
      else
         call store_option(self, options(which), arguments, next, value, error)
      end if
   end subroutine parse_long

   !> Options with one dash: -x, -xvalue, -x value, -xyz.
   subroutine parse_short(self, arguments, next, error)
      class(run_options_t), intent(inout) :: self        !! Receives the options
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of this one, then of the next
      type(error_t), allocatable, intent(out) :: error   !! Unknown, or its value is wrong
      character(len=:), allocatable :: letters, near, value
      type(option_t), allocatable :: options(:)
      integer :: at, which

      allocate (options, source=self%known())
      letters = arguments(next)%text
      next = next + 1
      at = 2
      do which = 1, size(options)
         if (letters(2:) /= trim(options(which)%name)) cycle
         call option_error(error, &
            "unknown option "//letters//"; did you mean -"//letters//"? [C101]")
         return
      end do
      do while (at <= len(letters))
         do which = 1, size(options)
            if (options(which)%letter == letters(at:at) .and. letters(at:at) /= " ") exit
         end do
         if (which > size(options)) then
            near = ""
            if (len(letters) >= 4) near = similar_option(options, &
               letters(2:scan(letters//"=", "=") - 1))
            call option_error(error, &
               "unknown option -"//letters(at:at)//" in '"//letters//"'"//near//" [C101]")
            return
         end if
         at = at + 1
         if (allocated(value)) deallocate (value)
         if (options(which)%takes == a_value .and. at <= len(letters)) then
            value = letters(at:)
            if (value(1:1) == "=") value = value(2:)
            at = len(letters) + 1
         end if
         call store_option(self, options(which), arguments(:merge(size(arguments), next - 1, &
            at > len(letters))), next, value, error)
         if (allocated(error)) return
      end do
   end subroutine parse_short

   !> Suggestion of a known option for an unknown one.
   function similar_option(options, name) result(text)
      type(option_t), intent(in) :: options(:)           !! The known ones
      character(len=*), intent(in) :: name               !! Without dashes
      character(len=:), allocatable :: text
      type(text_t), allocatable :: names(:)
      integer :: i

      allocate (names(0))
      do i = 1, size(options)
         call append(names, trim(options(i)%name))
      end do
      text = closest(name, names)
      if (text /= "") text = "; did you mean --"//text//"?"
   end function similar_option

   !> Store an option; its value may be the next argument. The file of --restart is optional and
   !! must end in .h5, since the next argument may be the deck.
   subroutine store_option(self, option, arguments, next, value, error)
      class(run_options_t), intent(inout) :: self        !! Receives the option
      type(option_t), intent(in) :: option
      type(text_t), intent(in) :: arguments(:)           !! All arguments that may be its value
      integer, intent(inout) :: next                     !! Index of the one after the option
      character(len=:), allocatable, intent(inout) :: value !! Value
      type(error_t), allocatable, intent(out) :: error   !! The value is missing or not valid
      logical :: takes

      takes = .not. allocated(value) .and. option%takes /= no_value .and. next <= size(arguments)
      if (takes .and. option%takes == a_file) &
         takes = index(arguments(next)%text, ".h5", back=.true.) == len(arguments(next)%text) - 2 &
         .and. len(arguments(next)%text) > 2
      if (takes) then
         value = arguments(next)%text
         next = next + 1
      end if
      if (option%takes == a_value) then
         if (.not. allocated(value)) then
            call option_error(error, "--"//trim(option%name)//" needs a value [C112]")
         else if (value == "") then
            call option_error(error, "the value of --"//trim(option%name)//" is empty [C105]")
         end if
         if (allocated(error)) return
      end if
      call self%set(option, value, error)
   end subroutine store_option

   !> Make an error of the command line.
   subroutine option_error(error, message)
      type(error_t), allocatable, intent(out) :: error   !! Allocated on return
      character(len=*), intent(in) :: message            !! Error message

      call fail(error, exit_input, "command line: error: "//message)
   end subroutine option_error
end module run_options
