! SPDX-License-Identifier: BSD-3-Clause
!> The command line: what the user asks the program to do.
module program_command_line
   use base_clock, only: clock_seconds, is_clock
   use base_deck_override, only: removal_mark
   use base_error, only: error_t, exit_input, fail
   use base_text, only: append, closest, text_t
   implicit none
   private

   public :: command_t, help_text, parse, program_arguments

   !> What the command line says. Texts that were not given are not allocated.
   type :: command_t
      character(len=:), allocatable :: deck              !! Name of the deck
      logical :: check = .false.                         !! Read and check, compute nothing
      logical :: estimate = .true.                       !! A check times the first steps
      logical :: preview = .false.                       !! Write and draw the first state
      logical :: point = .false.                         !! Drive one material point
      logical :: restart = .false.                       !! Go on from a checkpoint
      logical :: overwrite = .false.                     !! Replace the results of a former run
      character(len=:), allocatable :: checkpoint        !! Which; without it the newest valid one
      type(text_t), allocatable :: overrides(:)          !! GROUP.KEY=VALUE, !GROUP.KEY
      character(len=:), allocatable :: case_name         !! In place of the case of the deck
      character(len=:), allocatable :: output_folder     !! In place of out/CASE
      logical :: quiet = .false.                         !! Only warnings and errors on the screen
      logical :: verbose = .false.                       !! Details too
      logical :: force = .false.                         !! Sizes that are hardly meant are meant
      character(len=:), allocatable :: digest            !! Checkpoint whose digest is wanted
      logical :: template = .false.                      !! Print all keys
      character(len=:), allocatable :: explain           !! Key to be explained
      character(len=:), allocatable :: list              !! What is to be listed
      character(len=:), allocatable :: example           !! Example to be copied
      character(len=:), allocatable :: folder            !! Where the copy goes
      character(len=:), allocatable :: job               !! Scheduler that wants a script
      integer :: ranks = 0                               !! Ranks of the job, 0 = a suggestion
      integer :: threads = 0                             !! Threads of each, 0 = a suggestion
      character(len=:), allocatable :: job_time          !! Its wall time, hours:minutes:seconds
      logical :: help = .false.                          !! Print the help
      logical :: version = .false.                       !! Print the version
   end type command_t

   !> One option.
   type :: option_t
      character(len=11) :: name                          !! After the two dashes
      character(len=1) :: letter                         !! After one dash, or blank
      integer :: takes                                   !! One of the constants below
   end type option_t

   integer, parameter :: nothing = 0, a_value = 1, perhaps_a_value = 2
   type(option_t), parameter :: options(24) = [ &
      option_t("help    ", "h", nothing), option_t("version ", "V", nothing), &
      option_t("check   ", "n", nothing), option_t("restart ", "r", perhaps_a_value), &
      option_t("set     ", "s", a_value), option_t("case    ", "c", a_value), &
      option_t("outdir  ", "o", a_value), option_t("quiet   ", "q", nothing), &
      option_t("verbose ", "v", nothing), option_t("digest  ", " ", a_value), &
      option_t("template", " ", nothing), option_t("explain ", " ", a_value), &
      option_t("list    ", " ", a_value), option_t("point   ", " ", nothing), &
      option_t("force   ", " ", nothing), option_t("new     ", " ", a_value), &
      option_t("job     ", " ", a_value), option_t("ranks   ", " ", a_value), &
      option_t("threads ", " ", a_value), option_t("time    ", " ", a_value), &
      option_t("no-estimate", " ", nothing), option_t("overwrite", " ", nothing), &
      option_t("preview ", "p", nothing), option_t("unset   ", " ", a_value)]
   character(len=9), parameter :: lists(5) = [character(len=9) :: "materials", "fields", &
      "shapes", "units", "examples"]
   character(len=5), parameter :: schedulers(2) = [character(len=5) :: "slurm", "pbs"]

contains

   !> The arguments of the program.
   function program_arguments() result(arguments)
      type(text_t), allocatable :: arguments(:)
      character(len=:), allocatable :: argument
      integer :: i, length

      allocate (arguments(command_argument_count()))
      do i = 1, size(arguments)
         call get_command_argument(i, length=length)
         allocate (character(len=length) :: argument)
         if (length > 0) call get_command_argument(i, argument)
         call move_alloc(argument, arguments(i)%text)
      end do
   end function program_arguments

   !> Understand the arguments.
   subroutine parse(arguments, command, error)
      type(text_t), intent(in) :: arguments(:)           !! From `program_arguments`
      type(command_t), intent(out) :: command            !! What they say
      type(error_t), allocatable, intent(out) :: error   !! They cannot be understood
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
               call take_deck(argument, command, error)
               next = next + 1
            end if
         end associate
         if (allocated(error)) return
      end do
      call check_command(command, error)
   end subroutine parse

   !> The one argument that is no option.
   subroutine take_deck(argument, command, error)
      character(len=*), intent(in) :: argument           !! The argument
      type(command_t), intent(inout) :: command          !! Gets the deck
      type(error_t), allocatable, intent(out) :: error   !! There is one already

      if (argument == "") then
         call complain(error, "the name of the deck is empty")
      else if (allocated(command%deck)) then
         call complain(error, "one deck at a time, not '"//command%deck//"' and '"//argument//"'")
      else
         command%deck = argument
      end if
   end subroutine take_deck

   !> An option with two dashes: --name, --name=value, --name value.
   subroutine parse_long(arguments, next, command, error)
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of this one, then of the next
      type(command_t), intent(inout) :: command          !! Gets what it says
      type(error_t), allocatable, intent(out) :: error   !! It cannot be understood
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
         call complain(error, "unknown option --"//name//near)
      else if (options(which)%takes == nothing .and. allocated(value)) then
         call complain(error, "--"//name//" takes no value")
      else
         call find_value(arguments, next, options(which), value)
         call apply_option(options(which), value, command, error)
      end if
   end subroutine parse_long

   !> Options with one dash: -x, -xvalue, -x value, -xyz.
   subroutine parse_short(arguments, next, command, error)
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of this one, then of the next
      type(command_t), intent(inout) :: command          !! Gets what they say
      type(error_t), allocatable, intent(out) :: error   !! One cannot be understood
      character(len=:), allocatable :: letters, value
      integer :: at, which

      letters = arguments(next)%text
      next = next + 1
      at = 2
      do which = 1, size(options)
         if (letters(2:) /= trim(options(which)%name)) cycle
         call complain(error, "unknown option "//letters//"; did you mean -"//letters//"?")
         return
      end do
      do while (at <= len(letters))
         do which = 1, size(options)
            if (options(which)%letter == letters(at:at) .and. letters(at:at) /= " ") exit
         end do
         if (which > size(options)) then
            call complain(error, "unknown option -"//letters(at:at)//" in '"//letters//"'"// &
               long_name(letters))
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

   !> A question behind a message if a word with one dash is the name of an option with two.
   function long_name(word) result(text)
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
   end function long_name

   !> Take the next argument as value where the option wants one. The file of --restart is optional:
   !! it must end in .h5, since what follows may be the deck.
   subroutine find_value(arguments, next, option, value)
      type(text_t), intent(in) :: arguments(:)           !! All arguments
      integer, intent(inout) :: next                     !! Index of the one after the option
      type(option_t), intent(in) :: option               !! The option
      character(len=:), allocatable, intent(inout) :: value !! Its value
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

   !> Do what an option says.
   subroutine apply_option(option, value, command, error)
      type(option_t), intent(in) :: option               !! The option
      character(len=:), allocatable, intent(in) :: value !! Its value
      type(command_t), intent(inout) :: command          !! Gets what it says
      type(error_t), allocatable, intent(out) :: error   !! The value is missing

      if (option%name == "list" .and. .not. allocated(value)) then
         command%list = ""
         return
      end if
      call require_value(option, value, error)
      if (allocated(error)) return
      select case (option%name)
      case ("help")
         command%help = .true.
      case ("version")
         command%version = .true.
      case ("check")
         command%check = .true.
      case ("no-estimate")
         command%estimate = .false.
      case ("preview")
         command%preview = .true.
      case ("point")
         command%point = .true.
      case ("restart")
         command%restart = .true.
         if (allocated(value)) command%checkpoint = value
      case ("overwrite")
         command%overwrite = .true.
      case ("set")
         call append(command%overrides, value)
      case ("unset")
         call append(command%overrides, removal_mark//value)
      case ("case")
         command%case_name = value
      case ("outdir")
         command%output_folder = value
      case ("quiet")
         command%quiet = .true.
      case ("verbose")
         command%verbose = .true.
      case ("force")
         command%force = .true.
      case ("digest")
         command%digest = value
      case ("template")
         command%template = .true.
      case ("explain")
         command%explain = value
      case ("list")
         command%list = value
      case ("new")
         command%example = value
      case default
         call apply_job_option(option, value, command, error)
      end select
   end subroutine apply_option

   !> Refuse an option without the value that it takes.
   subroutine require_value(option, value, error)
      type(option_t), intent(in) :: option               !! The option
      character(len=:), allocatable, intent(in) :: value !! Its value
      type(error_t), allocatable, intent(out) :: error   !! The value is missing

      if (option%takes /= a_value) return
      if (.not. allocated(value)) then
         call complain(error, "--"//trim(option%name)//" needs a value")
      else if (value == "") then
         call complain(error, "the value of --"//trim(option%name)//" is empty")
      end if
   end subroutine require_value

   !> Do what an option says of the script of a job.
   subroutine apply_job_option(option, value, command, error)
      type(option_t), intent(in) :: option               !! The option
      character(len=*), intent(in) :: value              !! Its value
      type(command_t), intent(inout) :: command          !! Gets what it says
      type(error_t), allocatable, intent(out) :: error   !! The value is none of its kind
      logical :: right

      select case (option%name)
      case ("ranks")
         call read_count(option, value, command%ranks, error)
      case ("threads")
         call read_count(option, value, command%threads, error)
      case ("time")
         command%job_time = value
         right = is_clock(value)
         if (right) right = clock_seconds(value) > 0
         if (.not. right) call complain(error, "--time = '"//value// &
            "' must be hours, minutes and seconds such as 04:00:00")
      case default
         command%job = value
         if (all(schedulers /= value)) call complain(error, &
            "--job knows slurm and pbs, not '"//value//"'")
      end select
   end subroutine apply_job_option

   !> A whole number above 0.
   subroutine read_count(option, value, count, error)
      type(option_t), intent(in) :: option               !! The option
      character(len=*), intent(in) :: value              !! Its value
      integer, intent(out) :: count                      !! The number
      type(error_t), allocatable, intent(out) :: error   !! It is none
      integer, parameter :: most_digits = 8

      count = 0
      if (verify(value, "0123456789") == 0 .and. len(value) <= most_digits) read (value, *) count
      if (count <= 0) call complain(error, "--"//trim(option%name)//" = '"//value// &
         "' must be a whole number above 0")
   end subroutine read_count

   !> The parts must fit each other.
   subroutine check_command(command, error)
      type(command_t), intent(inout) :: command          !! What the command line says
      type(error_t), allocatable, intent(out) :: error   !! Something is missing or too much

      if (command%help .or. command%version) return
      if (allocated(command%list)) then
         call check_list(command%list, error)
         return
      end if
      if (allocated(command%explain) .or. command%template .or. allocated(command%digest)) return
      if (.not. (command%estimate .or. command%check)) then
         call complain(error, "--no-estimate needs --check; nothing else makes an estimate")
      else if (allocated(command%example)) then
         call move_alloc(command%deck, command%folder)
         if (.not. allocated(command%folder)) call complain(error, &
            "--new needs a folder behind the example; usage: scree --new "//command%example// &
            " FOLDER")
      else if (command%quiet .and. command%verbose) then
         call complain(error, "--quiet and --verbose exclude each other")
      else if (command%point .and. (command%check .or. command%restart)) then
         call complain(error, "--point excludes --check and --restart")
      else if (command%check .and. command%restart) then
         call complain(error, "--check and --restart exclude each other")
      else if (command%overwrite .and. command%restart) then
         call complain(error, "--overwrite and --restart exclude each other: a run either "// &
            "begins anew or goes on; give --outdir to go on in another folder")
      else if (command%preview .and. (command%check .or. command%point .or. command%restart &
         .or. allocated(command%job))) then
         call complain(error, "--preview excludes --check, --point, --restart and --job; call "// &
            "scree twice")
      else if (.not. allocated(command%deck)) then
         call complain(error, "no deck; usage: scree [options] DECK.nml, and scree --help for more")
      else
         call check_job(command, error)
      end if
      if (allocated(command%case_name)) &
         call append(command%overrides, "run.case="//command%case_name)
   end subroutine check_command

   !> There must be a list of that name; without a name the lists themselves are listed.
   subroutine check_list(name, error)
      character(len=*), intent(in) :: name               !! What is to be listed
      type(error_t), allocatable, intent(out) :: error   !! There is none
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: near
      integer :: i

      if (name == "" .or. any(lists == name)) return
      allocate (names(0))
      do i = 1, size(lists)
         call append(names, trim(lists(i)))
      end do
      near = closest(name, names)
      if (near /= "") near = "; did you mean "//near//"?"
      call complain(error, "--list knows materials, fields, shapes, units and "// &
         "examples, not '"//name//"'"//near)
   end subroutine check_list

   !> A job is printed, not run; numbers of it need it.
   subroutine check_job(command, error)
      type(command_t), intent(in) :: command             !! What the command line says
      type(error_t), allocatable, intent(out) :: error   !! Something is missing or too much

      if (.not. allocated(command%job)) then
         if (command%ranks > 0) call complain(error, &
            "--ranks needs --job; a run has those of mpirun")
         if (command%threads > 0) call complain(error, &
            "--threads needs --job; a run takes OMP_NUM_THREADS")
         if (allocated(command%job_time)) call complain(error, &
            "--time needs --job; a run takes wall_limit of &time")
      else if (command%check .or. command%point .or. command%restart) then
         call complain(error, "--job excludes --check, --point and --restart; the script goes "// &
            "on from checkpoints by itself")
      end if
   end subroutine check_job

   !> Make an error of the command line.
   subroutine complain(error, message)
      type(error_t), allocatable, intent(out) :: error   !! Allocated on return
      character(len=*), intent(in) :: message            !! What is wrong

      call fail(error, exit_input, "command line: error: "//message)
   end subroutine complain

   !> One screen of help.
   function help_text() result(text)
      character(len=:), allocatable :: text
      character(len=*), parameter :: newline = new_line("a")

      text = "usage: scree [options] DECK.nml"//newline//newline// &
         "  -n, --check            read and check the deck, say what a run will cost"//newline// &
         "  -p, --preview          draw the first state and the walls into OUTDIR_preview"// &
         newline// &
         "      --no-estimate      with --check: do not estimate the time of the run"//newline// &
         "  -s, --set G.K=VALUE    value in place of the deck's; --unset G.K removes it"// &
         newline// &
         "  -c, --case NAME        prefix of all output files"//newline// &
         "  -o, --outdir DIR       folder of all output files, default out/CASE"//newline// &
         "  -r, --restart [FILE]   go on from FILE.h5 or the newest valid checkpoint"//newline// &
         "      --overwrite        remove the results of a former run of this case"//newline// &
         "  -q, --quiet            only warnings and errors on the screen"//newline// &
         "  -v, --verbose          details too"//newline// &
         "      --force            take sizes that are hardly meant: points, files"//newline// &
         "      --template         print a deck with all keys and defaults"//newline// &
         "      --explain KEY      what a key or group of the deck means"//newline// &
         "      --point            drive one material along &point, write CASE_point.csv"// &
         newline// &
         "      --list [WHAT]      materials, fields, shapes, units, examples"//newline// &
         "      --new EXAMPLE DIR  copy an example into a new folder"//newline// &
         "      --job SCHEDULER    print a job script for slurm or pbs, with --ranks N,"// &
         newline//"                         --threads N and --time HH:MM:SS"//newline// &
         "      --digest FILE      digest of the state in a checkpoint"//newline// &
         "  -h, --help; -V, --version  this text; version, compiler and libraries"//newline//newline
      text = text//"exit codes: 0 finished, 2 deck or command line wrong, 3 file problem or "// &
         "results"//newline//"  in the way, 4 physics gave up, 5 internal error, 75 "// &
         "stopped: run again"//newline//newline//"examples:"//newline// &
         "  mpirun -n 4 scree scene.nml --set grid.dx=0.1 --case fine"//newline// &
         "  scree scene.nml --restart --set 'material[sheet].poisson=0.3'"//newline// &
         "The README and doc/guide explain the rest."
   end function help_text
end module program_command_line
