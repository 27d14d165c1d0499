! SPDX-License-Identifier: BSD-3-Clause
!> What the command line requests, and the checks of combinations of options.
module run_command
   use base_error, only: error_t, exit_input, fail
   use base_kinds, only: int64
   use base_text, only: append, closest, text_t
   implicit none
   private

   public :: check_command, command_line_error, command_t, information_request_t

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

   !> Options of output.
   type :: output_options_t
      character(len=:), allocatable :: case_name         !! Replaces the case of the deck
      character(len=:), allocatable :: folder            !! Replaces out/CASE
      logical :: overwrite = .false.                     !! Remove the results of a previous run
      logical :: quiet = .false.                         !! Print only warnings and errors
   end type output_options_t

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

   !> Content of the command line. Texts that were not given are not allocated.
   type :: command_t
      character(len=:), allocatable :: deck              !! Path of the deck
      logical :: check = .false.                         !! Check the deck, compute nothing
      logical :: estimate = .true.                       !! A check estimates the run time
      logical :: preview = .false.                       !! Write and draw the first state
      logical :: point = .false.                         !! Drive one material point
      logical :: grains = .false.                        !! Run a periodic cell of grains
      logical :: self_test = .false.                     !! Test this installation
      logical :: restart = .false.                       !! Continue from a checkpoint
      character(len=:), allocatable :: checkpoint        !! Which one; default: the newest valid one
      type(text_t), allocatable :: overrides(:)          !! GROUP.KEY=VALUE, !GROUP.KEY
      logical :: force = .false.                         !! Override the limits on sizes
      type(output_options_t) :: output                   !! Case, folder, screen
      type(job_options_t) :: job                         !! Job script
      type(example_request_t) :: example                 !! Example to copy
      type(information_request_t) :: information         !! Text to print
      integer(int64) :: hash = 0                         !! Hash of all words but the deck
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

   !> Check combinations of options.
   subroutine check_command(command, error)
      type(command_t), intent(inout) :: command          !! Content of the command line
      type(error_t), allocatable, intent(out) :: error   !! Missing or conflicting options

      if (command%information%help .or. command%information%version) return
      if (command%self_test) then
         if (allocated(command%deck)) call command_line_error(error, &
            "--self-test takes no deck; it has its own scenes [C107]")
         return
      end if
      if (allocated(command%information%list)) then
         call check_list(command%information%list, error)
         return
      end if
      if (allocated(command%information%explain) .or. command%information%template .or. &
         allocated(command%information%digest)) return
      if (.not. (command%estimate .or. command%check)) then
         call command_line_error(error, &
            "--no-estimate needs --check; only a check makes an estimate [C108]")
      else if (allocated(command%example%name)) then
         call move_alloc(command%deck, command%example%folder)
         if (.not. allocated(command%example%folder)) call command_line_error(error, &
            "--new needs a folder after the example; usage: scree --new "//command%example%name// &
            " FOLDER")
      else if (command%point .and. (command%check .or. command%restart)) then
         call command_line_error(error, "--point excludes --check and --restart [C107]")
      else if (command%grains .and. (command%point .or. command%preview &
         .or. allocated(command%job%scheduler))) then
         call command_line_error(error, "--grains excludes --point, --preview and --job [C107]")
      else if (command%information%echo .and. (command%check .or. command%preview &
         .or. command%point .or. command%grains .or. command%restart &
         .or. allocated(command%job%scheduler))) then
         call command_line_error(error, "--echo excludes --check, --preview, --point, "// &
            "--grains, --restart and --job [C107]")
      else if (command%check .and. command%restart) then
         call command_line_error(error, "--check and --restart exclude each other [C107]")
      else if (command%output%overwrite .and. command%restart) then
         call command_line_error(error, &
            "--overwrite and --restart exclude each other: a run either "// &
            "starts again or continues; give --outdir to continue in another folder [C107]")
      else if (command%preview .and. (command%check .or. command%point .or. command%restart &
         .or. allocated(command%job%scheduler))) then
         call command_line_error(error, &
            "--preview excludes --check, --point, --restart and --job; call "// &
            "scree twice")
      else if (.not. allocated(command%deck)) then
         call command_line_error(error, &
            "no deck; usage: scree [options] DECK.nml, and scree --help for more [C115]")
      else
         call check_job(command, error)
      end if
      if (allocated(command%output%case_name)) &
         call append(command%overrides, "run.case="//command%output%case_name)
   end subroutine check_command

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
      call command_line_error(error, "--list knows materials, fields, shapes, units, "// &
         "examples and messages, not '"//name//"'"//near//" [C109]")
   end subroutine check_list

   !> Check the options of a job script, which is printed and not run.
   subroutine check_job(command, error)
      type(command_t), intent(in) :: command             !! Content of the command line
      type(error_t), allocatable, intent(out) :: error   !! Missing or conflicting options

      if (.not. allocated(command%job%scheduler)) then
         if (command%job%ranks > 0) call command_line_error(error, &
            "--ranks needs --job; a run uses the ranks of mpirun [C206]")
         if (command%job%threads > 0) call command_line_error(error, &
            "--threads needs --job; a run uses OMP_NUM_THREADS [C206]")
         if (command%job%nodes > 0) call command_line_error(error, &
            "--nodes needs --job; a run uses the nodes of mpirun [C206]")
         if (allocated(command%job%time)) call command_line_error(error, &
            "--time needs --job; a run uses wall_limit of &time [C206]")
      else if (command%check .or. command%point .or. command%restart .or. &
         command%output%overwrite) then
         call command_line_error(error, &
            "--job excludes --check, --point, --restart and --overwrite; the script "// &
            "starts a run or continues it and never removes results [C107]")
      else if (command%job%nodes > 0 .and. command%job%ranks > 0) then
         if (mod(command%job%ranks, command%job%nodes) > 0) call command_line_error(error, &
            "--ranks must be a multiple of --nodes, so that each node has as many ranks [C207]")
      end if
   end subroutine check_job

   !> Make an error of the command line.
   subroutine command_line_error(error, message)
      type(error_t), allocatable, intent(out) :: error   !! Allocated on return
      character(len=*), intent(in) :: message            !! Error message

      call fail(error, exit_input, "command line: error: "//message)
   end subroutine command_line_error
end module run_command
