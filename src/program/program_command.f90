! SPDX-License-Identifier: BSD-3-Clause
!> What the command line requests: the options of a run, and those of the program.
module program_command
   use base_clock, only: clock_seconds, is_clock
   use base_error, only: error_t
   use base_text, only: append, closest, text_t
   use program_job_templates, only: scheduler_list, schedulers
   use run_options, only: a_value, maybe_a_value, no_value, option_error, option_t, run_options_t
   implicit none
   private

   public :: command_t, example_request_t, information_request_t, job_options_t

   type(option_t), parameter :: options_of_the_program(19) = [ &
      option_t("help    ", "h", no_value), option_t("version ", "V", no_value), &
      option_t("check   ", "n", no_value), option_t("no-estimate", " ", no_value), &
      option_t("preview ", "p", no_value), option_t("echo    ", " ", no_value), &
      option_t("point   ", " ", no_value), option_t("grains  ", " ", no_value), &
      option_t("self-test", " ", no_value), option_t("template", " ", no_value), &
      option_t("digest  ", " ", a_value), option_t("explain ", " ", a_value), &
      option_t("list    ", " ", maybe_a_value), option_t("new     ", " ", a_value), &
      option_t("job     ", " ", a_value), option_t("ranks   ", " ", a_value), &
      option_t("nodes   ", " ", a_value), option_t("threads ", " ", a_value), &
      option_t("time    ", " ", a_value)]

   !> A text that is printed in place of a run. Texts that were not given are not allocated. All but
   !! `echo` need no deck; `is_set` is true for one of these.
   type :: information_request_t
      logical :: help = .false.                          !! Print the help
      logical :: version = .false.                       !! Print the version
      logical :: template = .false.                      !! Print all keys
      logical :: echo = .false.                          !! Print the deck with all keys
      character(len=:), allocatable :: explain           !! Key or group to explain
      character(len=:), allocatable :: list              !! Name of the list to print
      character(len=:), allocatable :: digest            !! Checkpoint whose digest is printed
   contains
      procedure :: is_set => information_request_is_set  !! Is there a request?
   end type information_request_t

   !> Options of a job script.
   type :: job_options_t
      character(len=:), allocatable :: scheduler         !! One of `schedulers`
      integer :: ranks = 0                               !! 0 = chosen by the program
      integer :: threads = 0 !! Number of threads of each rank, 0 = chosen by the program
      integer :: nodes = 0                               !! 0 = chosen by the scheduler
      character(len=:), allocatable :: time              !! Wall time, see base_clock
   end type job_options_t

   !> An example to copy.
   type :: example_request_t
      character(len=:), allocatable :: name              !! Name of the example
      character(len=:), allocatable :: folder            !! Folder of the copy
   end type example_request_t

   !> Content of the command line.
   type, extends(run_options_t) :: command_t
      logical :: check_only = .false.                    !! Check the deck, compute nothing
      logical :: estimate = .true.                       !! A check estimates the run time
      logical :: preview = .false.                       !! Write and draw the first state
      logical :: point = .false.                         !! Drive one material point
      logical :: grains = .false.                        !! Run a periodic cell of grains
      logical :: self_test = .false.                     !! Test this installation
      type(job_options_t) :: job                         !! Job script
      type(example_request_t) :: example                 !! Example to copy
      type(information_request_t) :: information         !! Text to print
   contains
      procedure :: known => command_known                !! All options
      procedure :: set => command_set                    !! Store an option
      procedure :: check => command_check                !! Check combinations
   end type command_t

   character(len=9), parameter :: lists(6) = [character(len=9) :: "materials", "fields", &
      "shapes", "units", "examples", "messages"]

contains

   !> True if a text is to be printed in place of a run.
   pure logical function information_request_is_set(self) result(set)
      class(information_request_t), intent(in) :: self

      set = self%help .or. self%version .or. self%template .or. allocated(self%explain) .or. &
         allocated(self%list) .or. allocated(self%digest)
   end function information_request_is_set

   !> All options: those of a run, and those of the program.
   pure function command_known(self) result(options)
      class(command_t), intent(in) :: self
      type(option_t), allocatable :: options(:)

      options = [self%run_options_t%known(), options_of_the_program]
   end function command_known

   !> Store an option.
   subroutine command_set(self, option, value, error)
      class(command_t), intent(inout) :: self            !! Receives the option
      type(option_t), intent(in) :: option               !! A known one
      character(len=:), allocatable, intent(in) :: value !! Given if the option needs one
      type(error_t), allocatable, intent(out) :: error   !! The value is not valid
      logical :: right

      select case (option%name)
      case ("help")
         self%information%help = .true.
      case ("version")
         self%information%version = .true.
      case ("check", "echo", "preview", "point", "grains", "self-test")
         self%check_only = self%check_only .or. option%name == "check"
         self%information%echo = self%information%echo .or. option%name == "echo"
         self%preview = self%preview .or. option%name == "preview"
         self%point = self%point .or. option%name == "point"
         self%grains = self%grains .or. option%name == "grains"
         self%self_test = self%self_test .or. option%name == "self-test"
      case ("no-estimate")
         self%estimate = .false.
      case ("digest")
         self%information%digest = value
      case ("template")
         self%information%template = .true.
      case ("explain")
         self%information%explain = value
         self%lines = .true.
      case ("list")
         self%information%list = ""
         if (allocated(value)) self%information%list = value
      case ("new")
         self%example%name = value
      case ("ranks")
         call read_count(option, value, self%job%ranks, error)
      case ("nodes")
         call read_count(option, value, self%job%nodes, error)
      case ("threads")
         call read_count(option, value, self%job%threads, error)
      case ("time")
         self%job%time = value
         right = is_clock(value)
         if (right) right = clock_seconds(value) > 0
         if (.not. right) call option_error(error, "--time = '"//value// &
            "' must be hours, minutes and seconds such as 04:00:00, or with days 2-00:00:00 [C113]")
      case ("job")
         self%job%scheduler = value
         if (all(schedulers /= value)) call option_error(error, &
            "--job knows "//scheduler_list("and")//", not '"//value//"' [C204]")
      case default
         call self%run_options_t%set(option, value, error)
      end select
   end subroutine command_set

   !> Read an integer above 0.
   subroutine read_count(option, value, count, error)
      type(option_t), intent(in) :: option
      character(len=*), intent(in) :: value              !! Value
      integer, intent(out) :: count                      !! Value of the option
      type(error_t), allocatable, intent(out) :: error   !! Not an integer above 0
      integer, parameter :: most_digits = 8

      count = 0
      if (verify(value, "0123456789") == 0 .and. len(value) <= most_digits) read (value, *) count
      if (count <= 0) call option_error(error, "--"//trim(option%name)//" = '"//value// &
         "' must be an integer above 0 [C113]")
   end subroutine read_count

   !> Check combinations of options.
   subroutine command_check(self, error)
      class(command_t), intent(inout) :: self
      type(error_t), allocatable, intent(out) :: error   !! Missing or conflicting options

      if (self%information%help .or. self%information%version) return
      if (self%self_test) then
         if (allocated(self%deck)) call option_error(error, &
            "--self-test takes no deck; it has its own scenes [C107]")
         return
      end if
      if (allocated(self%information%list)) then
         call check_list(self%information%list, error)
         return
      end if
      if (allocated(self%information%explain) .or. self%information%template .or. &
         allocated(self%information%digest)) return
      if (.not. (self%estimate .or. self%check_only)) then
         call option_error(error, &
            "--no-estimate needs --check; only a check makes an estimate [C108]")
      else if (allocated(self%example%name)) then
         call move_alloc(self%deck, self%example%folder)
         if (.not. allocated(self%example%folder)) call option_error(error, &
            "--new needs a folder after the example; usage: scree --new "//self%example%name// &
            " FOLDER [C114]")
      else if (self%point .and. (self%check_only .or. self%restart)) then
         call option_error(error, "--point excludes --check and --restart [C107]")
      else if (self%grains .and. (self%point .or. self%preview &
         .or. allocated(self%job%scheduler))) then
         call option_error(error, "--grains excludes --point, --preview and --job [C107]")
      else if (self%information%echo .and. (self%check_only .or. self%preview &
         .or. self%point .or. self%grains .or. self%restart &
         .or. allocated(self%job%scheduler))) then
         call option_error(error, "--echo excludes --check, --preview, --point, "// &
            "--grains, --restart and --job [C107]")
      else if (self%check_only .and. self%restart) then
         call option_error(error, "--check and --restart exclude each other [C107]")
      else if (self%preview .and. (self%check_only .or. self%point .or. self%restart &
         .or. allocated(self%job%scheduler))) then
         call option_error(error, &
            "--preview excludes --check, --point, --restart and --job; call "// &
            "scree twice [C107]")
      end if
      if (allocated(error) .or. allocated(self%example%folder)) return
      call self%run_options_t%check(error)
      if (.not. allocated(error)) call check_job(self, error)
   end subroutine command_check

   !> Check the name of a list; an empty name requests the list of lists.
   subroutine check_list(name, error)
      character(len=*), intent(in) :: name               !! Name of the list
      type(error_t), allocatable, intent(out) :: error   !! No such list
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
      call option_error(error, "--list knows materials, fields, shapes, units, "// &
         "examples and messages, not '"//name//"'"//near//" [C109]")
   end subroutine check_list

   !> Check the options of a job script, which is printed and not run.
   subroutine check_job(command, error)
      type(command_t), intent(in) :: command             !! Content of the command line
      type(error_t), allocatable, intent(out) :: error   !! Missing or conflicting options

      if (.not. allocated(command%job%scheduler)) then
         if (command%job%ranks > 0) call option_error(error, &
            "--ranks needs --job; a run uses the ranks of mpirun [C206]")
         if (command%job%threads > 0) call option_error(error, &
            "--threads needs --job; a run uses OMP_NUM_THREADS [C206]")
         if (command%job%nodes > 0) call option_error(error, &
            "--nodes needs --job; a run uses the nodes of mpirun [C206]")
         if (allocated(command%job%time)) call option_error(error, &
            "--time needs --job; a run uses wall_limit of &time [C206]")
      else if (command%check_only .or. command%point .or. command%restart .or. &
         command%overwrite) then
         call option_error(error, &
            "--job excludes --check, --point, --restart and --overwrite; the script "// &
            "starts a run or continues it and never removes results [C107]")
      else if (command%job%nodes > 0 .and. command%job%ranks > 0) then
         if (mod(command%job%ranks, command%job%nodes) > 0) call option_error(error, &
            "--ranks must be a multiple of --nodes, so that each node has as many ranks [C207]")
      end if
   end subroutine check_job
end module program_command
