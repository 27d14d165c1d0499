! SPDX-License-Identifier: BSD-3-Clause
!> Job scripts, from the templates in src/program/job. Near the end of its time a job writes a
!! checkpoint, ends with the exit code for "run again", and is submitted again.
module program_batch_job
   use base_clock, only: clock_seconds, clock_text
   use base_error, only: error_t, exit_again, exit_input, fail
   use base_file, only: program_path
   use base_kinds, only: int64, wp
   use base_text, only: line_end, number
   use deck_override, only: removal_mark
   use program_command, only: job_options_t
   use run_resume_command, only: program_arguments, quoted
   use program_job_templates, only: job_template
   use run_cost_report, only: memory_bytes
   use run_launcher, only: launch_text, srun_setting
   use run_setup, only: run_setup_t
   implicit none
   private

   public :: job_text

   real(wp), parameter :: particles_of_rank = 1.0e6_wp !! reason: doc/developer/scaling.md
   integer, parameter :: usual_threads = 4           !! Threads per rank, if there are enough tiles
   character(len=*), parameter :: usual_time = "04:00:00" !! Usual wall time of a job
   integer, parameter :: usual_notice = 300, least_notice = 60 !! Before the end of a job [s]
   character(len=*), parameter :: newline = new_line("a")

   !> Content of a job script.
   type :: job_t
      integer :: nodes = 0                           !! Nodes, 0 = chosen by the scheduler
      integer :: ranks = 1                           !! Ranks on all nodes
      integer :: threads = 1                         !! Threads of each
      integer :: seconds = 0                         !! Wall time [s]
      integer :: notice = usual_notice               !! To write the last checkpoint [s]
      character(len=:), allocatable :: time          !! The wall time as a text
      character(len=:), allocatable :: case          !! Prefix of all files
      character(len=:), allocatable :: command       !! The program with its options
      integer(int64) :: megabytes = 0                !! Memory for each thread [MB]
      character(len=:), allocatable :: size          !! Comment on the size of the run
      character(len=:), allocatable :: limit         !! Comment on the wall time
   end type job_t

contains

   !> Make the job script for a run.
   subroutine job_text(setup, options, deck, text, error)
      class(run_setup_t), intent(in) :: setup
      type(job_options_t), intent(in) :: options     !! From the command line
      character(len=*), intent(in) :: deck           !! Path of the deck from the folder of the job
      character(len=:), allocatable, intent(out) :: text !! Lines of the script
      !> The deck does not watch the signal of the scheduler
      type(error_t), allocatable, intent(out) :: error
      type(job_t) :: job
      integer :: n

      text = ""
      if (all([(trim(setup%limits%signals(n)) /= "USR1", n=1, size(setup%limits%signals))])) then
         call fail(error, exit_input, &
            "the scheduler announces the end of the job with signal USR1; "// &
            "add 'USR1' to on_signal in &checkpoint of "//setup%options%deck//" [C205]")
         return
      end if
      call choose_job(setup, options, deck, job)
      text = filled_text(job_template(options%scheduler), job)
   end subroutine job_text

   !> Choose ranks, threads, times and file names of a job.
   subroutine choose_job(setup, options, deck, job)
      class(run_setup_t), intent(in) :: setup
      type(job_options_t), intent(in) :: options     !! From the command line
      character(len=*), intent(in) :: deck           !! Path of the deck from the folder of the job
      type(job_t), intent(out) :: job
      integer :: tiles

      tiles = int(max(setup%survey%tiles, 1_int64))
      job%ranks = min(max(ceiling(real(setup%survey%particles, wp)/particles_of_rank), 1), tiles)
      if (options%ranks > 0) job%ranks = options%ranks
      job%nodes = options%nodes
      ! without --ranks the number becomes a multiple of the nodes
      if (job%nodes > 0) job%ranks = job%nodes*((job%ranks + job%nodes - 1)/job%nodes)
      job%threads = max(min(usual_threads, tiles/job%ranks), 1)
      if (options%threads > 0) job%threads = options%threads
      job%time = usual_time
      if (allocated(options%time)) job%time = options%time
      job%seconds = clock_seconds(job%time)
      job%notice = min(usual_notice, max(least_notice, job%seconds/10))
      job%case = setup%place%case
      job%command = quoted(program_path())//options_text(setup)//" "
      ! a word that begins with a dash would be an option
      if (index(deck, "-") == 1) job%command = job%command//"./"
      job%command = job%command//quoted(deck)//" --restart"
      job%megabytes = megabytes_of_thread(setup, job)
      job%size = "# "//number(setup%survey%particles)//" particles in "// &
         number(setup%survey%tiles)//" tiles; about a million particles a rank are efficient."
      job%limit = limit_text(setup, job)
   end subroutine choose_job

   !> Options of the command line that the script passes to the program.
   function options_text(setup) result(text)
      class(run_setup_t), intent(in) :: setup              !! With the options
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      associate (options => setup%options)
         if (allocated(options%folder)) text = text//" --outdir "//quoted(options%folder)
         do n = 1, size(options%overrides)
            associate (override => options%overrides(n)%text)
               if (index(override, removal_mark) == 1) then
                  text = text//" --unset "//quoted(override(2:))
               else
                  text = text//" --set "//quoted(override)
               end if
            end associate
         end do
         if (options%force) text = text//" --force"
      end associate
   end function options_text

   !> Memory to request for each thread [MB]: four times that of the fields of the first state, as
   !! debris that spreads over more tiles needs up to three times as much and loads differ, and what
   !! MPI, HDF5 and the program use without particles.
   integer(int64) function megabytes_of_thread(setup, job) result(megabytes)
      class(run_setup_t), intent(in) :: setup        !! Without particles
      type(job_t), intent(in) :: job                 !! Ranks and threads
      real(wp), parameter :: margin = 4.0_wp, fixed = 256.0_wp, megabyte = 1.0e6_wp

      megabytes = ceiling((margin*memory_bytes(setup%simulation, setup%survey)/megabyte &
         /real(job%ranks, wp) + fixed)/real(job%threads, wp), int64)
   end function megabytes_of_thread

   !> Comment of the script on the wall time, for schedulers that send a signal.
   function limit_text(setup, job) result(text)
      class(run_setup_t), intent(in) :: setup
      type(job_t), intent(in) :: job                 !! Content
      character(len=:), allocatable :: text

      if (setup%limits%query_scheduler) then
         text = "# The run requests the end of the job from Slurm (wall_limit = 'slurm')."
      else if (setup%limits%wall_limit < real(job%seconds, wp)) then
         text = "# wall_limit of the deck ends the run before the job does."
      else if (setup%limits%wall_limit < huge(1.0_wp)) then
         text = "# wall_limit of the deck is longer than the job; the signal ends it."
      else
         text = "# With wall_limit = 'slurm' in &time the run also checks the wall time."
      end if
   end function limit_text

   !> Replace the names in double braces of a template by values. A line with only an empty value is
   !! left out, and so is a line with a name node_* if no number of nodes is given.
   function filled_text(template, job) result(text)
      character(len=*), intent(in) :: template       !! Template of a scheduler
      type(job_t), intent(in) :: job                 !! Values
      character(len=:), allocatable :: text
      character(len=:), allocatable :: value
      integer :: begin, last
      logical :: at_begin

      text = ""
      begin = 1
      do
         last = index(template(begin:), "{{")
         if (last == 0) exit
         text = text//template(begin:begin + last - 2)
         at_begin = text(len(text):) == newline
         begin = begin + last + 1
         last = index(template(begin:), "}}")
         associate (name => template(begin:begin + last - 2))
            if (index(name, "node_") == 1 .and. job%nodes == 0) then
               text = text(:index(text, newline, back=.true.))
               begin = line_end(template, begin) + 2
               cycle
            end if
            value = value_text(name, job)
         end associate
         text = text//value
         begin = begin + last + 1
         if (value == "" .and. at_begin .and. template(begin:begin) == newline) begin = begin + 1
      end do
      text = text//template(begin:)
   end function filled_text

   !> Value of a name in a template. An unknown name remains visible.
   function value_text(name, job) result(text)
      character(len=*), intent(in) :: name           !! Without braces
      type(job_t), intent(in) :: job                 !! Values
      character(len=:), allocatable :: text

      select case (name)
      case ("case")
         text = job%case
      case ("ranks")
         text = number(job%ranks)
      case ("threads")
         text = number(job%threads)
      case ("node_count")
         text = number(job%nodes)
      case ("node_ranks", "chunk_ranks")
         text = number(job%ranks/chunks_of(job))
      case ("node_each")
         text = ""
      case ("chunks")
         text = number(chunks_of(job))
      case ("chunk_cores")
         text = number(job%threads*(job%ranks/chunks_of(job)))
      case ("chunk_mb")
         text = number(job%megabytes*job%threads*(job%ranks/chunks_of(job)))
      case ("thread_megabytes")
         text = number(job%megabytes)
      case ("again")
         text = number(exit_again)
      case ("size")
         text = job%size
      case ("memory")
         text = "# A rank uses up to about "//number(job%megabytes*job%threads)//" MB."
      case ("limit")
         text = job%limit
      case ("environment")
         ! some file systems have no locks, which HDF5 would use
         text = "export OMP_PLACES=cores OMP_PROC_BIND=close HDF5_USE_FILE_LOCKING=FALSE"
      case ("command")
         text = job%command
      case ("srun_mpi")
         text = srun_setting()
      case ("bound_mpirun")
         text = launch_text(job%ranks, job%threads)
      case default
         text = time_text(name, job)
      end select
   end function value_text

   !> Value of a name in a template that is a time. The signal comes `notice` before the end of the
   !! job.
   function time_text(name, job) result(text)
      character(len=*), intent(in) :: name           !! Without braces
      type(job_t), intent(in) :: job                 !! Values
      character(len=:), allocatable :: text

      select case (name)
      case ("time")
         text = job%time
      case ("clock_time")
         text = clock_text(job%seconds)
      case ("notice")
         text = number(job%notice)
      case ("wall_limit")
         text = clock_text(job%seconds - job%notice)
      case default
         text = "{{"//name//"}}"
      end select
   end function time_text

   !> Parts of a job with equal numbers of ranks: nodes, or else ranks.
   pure integer function chunks_of(job) result(chunks)
      type(job_t), intent(in) :: job

      chunks = merge(job%nodes, job%ranks, job%nodes > 0)
   end function chunks_of
end module program_batch_job
