! SPDX-License-Identifier: BSD-3-Clause
!> Job scripts for Slurm and PBS. Near the end of its time a job writes a checkpoint, ends with the
!! exit code for "run again", and is submitted again.
module program_batch_job
   use base_clock, only: clock_seconds, clock_text
   use base_deck_override, only: removal_mark
   use base_error, only: error_t, exit_again, exit_input, fail
   use base_kinds, only: int64, wp
   use base_text, only: number
   use io_file, only: join_path, program_path
   use program_command_line, only: program_arguments
   use program_run_setup, only: run_setup_t
   implicit none
   private

   public :: job_text, quoted, resume_command

   real(wp), parameter :: particles_of_rank = 1.0e6_wp !! reason: doc/developer/scaling.md
   integer, parameter :: usual_threads = 4           !! Threads per rank, if there are enough tiles
   character(len=*), parameter :: usual_time = "04:00:00" !! Of a job
   integer, parameter :: usual_notice = 300, least_notice = 60 !! Before the end of a job [s]
   character(len=*), parameter :: newline = new_line("a")

   !> Content of a job script.
   type :: job_t
      integer :: ranks = 1                           !! Ranks
      integer :: threads = 1                         !! Threads of each
      integer :: seconds = 0                         !! Wall time [s]
      integer :: notice = usual_notice               !! To write the last checkpoint [s]
      character(len=:), allocatable :: time          !! The wall time as a text
      character(len=:), allocatable :: case          !! Prefix of all files
      character(len=:), allocatable :: command       !! The program with its options
      character(len=:), allocatable :: checkpoints   !! Pattern of the checkpoint files
      character(len=:), allocatable :: summary !! Summary, which exists after the end of the run
      character(len=:), allocatable :: hints         !! Comments in the script
   end type job_t

contains

   !> Make the job script for a run.
   subroutine job_text(setup, deck, text, error)
      class(run_setup_t), intent(in) :: setup
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
            "add 'USR1' to on_signal in &checkpoint of "//setup%command%deck)
         return
      end if
      call choose_job(setup, deck, job)
      if (setup%command%job%scheduler == "pbs") then
         text = pbs_text(job)
      else
         text = slurm_text(job)
      end if
   end subroutine job_text

   !> Choose ranks, threads, times and file names of a job.
   subroutine choose_job(setup, deck, job)
      class(run_setup_t), intent(in) :: setup
      character(len=*), intent(in) :: deck           !! Path of the deck from the folder of the job
      type(job_t), intent(out) :: job
      integer :: tiles

      tiles = int(max(setup%survey%tiles, 1_int64))
      job%ranks = min(max(ceiling(real(setup%survey%particles, wp)/particles_of_rank), 1), tiles)
      if (setup%command%job%ranks > 0) job%ranks = setup%command%job%ranks
      job%threads = max(min(usual_threads, tiles/job%ranks), 1)
      if (setup%command%job%threads > 0) job%threads = setup%command%job%threads
      job%time = usual_time
      if (allocated(setup%command%job%time)) job%time = setup%command%job%time
      job%seconds = clock_seconds(job%time)
      job%notice = min(usual_notice, max(least_notice, job%seconds/10))
      job%case = setup%place%case
      job%checkpoints = quoted(join_path(setup%place%folder, job%case//"_chk_")//"*.h5")
      job%summary = quoted(join_path(setup%place%folder, job%case//".summary.json"))
      job%command = quoted(program_path())//options_text(setup)//" "//quoted(deck)
      job%hints = hints_text(setup, job)
   end subroutine choose_job

   !> Options of the command line that the script passes to the program.
   function options_text(setup) result(text)
      class(run_setup_t), intent(in) :: setup              !! With the command line
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      associate (command => setup%command)
         if (allocated(command%output%folder)) &
            text = text//" --outdir "//quoted(command%output%folder)
         do n = 1, size(command%overrides)
            associate (override => command%overrides(n)%text)
               if (index(override, removal_mark) == 1) then
                  text = text//" --unset "//quoted(override(2:))
               else
                  text = text//" --set "//quoted(override)
               end if
            end associate
         end do
         if (command%force) text = text//" --force"
      end associate
   end function options_text

   !> Comments of the script on size and wall time.
   function hints_text(setup, job) result(text)
      class(run_setup_t), intent(in) :: setup
      type(job_t), intent(in) :: job                 !! Content
      character(len=:), allocatable :: text

      text = "# "//number(setup%survey%particles)//" particles in "// &
         number(setup%survey%tiles)//" tiles; about a million particles a rank "// &
         "are efficient."//newline
      if (setup%command%job%scheduler == "pbs") then
         text = text//"# The limit below replaces wall_limit of the deck."
      else if (setup%limits%query_scheduler) then
         text = text//"# The run requests the end of the job from Slurm (wall_limit = 'slurm')."
      else if (setup%limits%wall_limit < real(job%seconds, wp)) then
         text = text//"# wall_limit of the deck ends the run before the job does."
      else if (setup%limits%wall_limit < huge(1.0_wp)) then
         text = text//"# wall_limit of the deck is longer than the job; the signal ends it."
      else
         text = text//"# With wall_limit = 'slurm' in &time the run also checks the wall time."
      end if
      text = text//newline
   end function hints_text

   !> Script for Slurm. The signal goes to the ranks, not to the shell.
   function slurm_text(job) result(text)
      type(job_t), intent(in) :: job
      character(len=:), allocatable :: text

      text = "#!/bin/bash"//newline// &
         "#SBATCH --job-name="//job%case//newline// &
         "#SBATCH --ntasks="//number(job%ranks)//newline// &
         "#SBATCH --cpus-per-task="//number(job%threads)//newline// &
         "#SBATCH --time="//job%time//newline// &
         "#SBATCH --signal=USR1@"//number(job%notice)//newline// &
         "#SBATCH --requeue"//newline// &
         "#SBATCH --open-mode=append"//newline// &
         "# Scree: USR1 requests a checkpoint "//number(job%notice)//" s before the end; exit "// &
         "code "//number(exit_again)//" means: run again."//newline//job%hints// &
         "export OMP_NUM_THREADS=""${SLURM_CPUS_PER_TASK:-"//number(job%threads)//"}"""//newline// &
         "export SRUN_CPUS_PER_TASK=""${OMP_NUM_THREADS}"""//newline//binding_text()// &
         restart_text(job)// &
         "srun "//job%command//" ""${restart[@]}"" || code=$?"//newline// &
         "if [ ""${code}"" -eq "//number(exit_again)//" ]; then"//newline// &
         "   scontrol requeue ""${SLURM_JOB_ID}"" || echo 'submit this script again' >&2"// &
         newline//"fi"//newline//"exit ""${code}"""//newline
   end function slurm_text

   !> Script for PBS, which sends no signal in advance: the run has a wall time limit, and the
   !! script submits itself again.
   function pbs_text(job) result(text)
      type(job_t), intent(in) :: job
      character(len=:), allocatable :: text

      text = "#!/bin/bash"//newline// &
         "#PBS -N "//job%case//newline// &
         "#PBS -l select="//number(job%ranks)//":ncpus="//number(job%threads)// &
         ":mpiprocs=1:ompthreads="//number(job%threads)//newline// &
         "#PBS -l walltime="//job%time//newline// &
         "#PBS -j oe"//newline// &
         "# Scree: a run stops "//number(job%notice)//" s before the end of the job with a "// &
         "checkpoint; exit"//newline// &
         "# code "//number(exit_again)//" means: run again."//newline//job%hints// &
         "cd ""${PBS_O_WORKDIR:-.}"" || exit 3"//newline// &
         "export OMP_NUM_THREADS="//number(job%threads)//newline//binding_text()// &
         restart_text(job)// &
         "mpirun -n "//number(job%ranks)//" "//job%command//" --set time.wall_limit="// &
         clock_text(job%seconds - job%notice)//" ""${restart[@]}"" || code=$?"//newline// &
         "if [ ""${code}"" -eq "//number(exit_again)//" ]; then"//newline// &
         "   qsub ""$0"" || echo 'submit this script again' >&2"//newline// &
         "fi"//newline//"exit ""${code}"""//newline
   end function pbs_text

   !> Binding of threads to cores; no HDF5 file locks, which some file systems lack.
   pure function binding_text() result(text)
      character(len=:), allocatable :: text

      text = "export OMP_PLACES=cores OMP_PROC_BIND=close HDF5_USE_FILE_LOCKING=FALSE"//newline
   end function binding_text

   !> Restart if there is a checkpoint. A run that was killed before its first checkpoint has no
   !! summary and starts again.
   pure function restart_text(job) result(text)
      type(job_t), intent(in) :: job
      character(len=:), allocatable :: text

      text = "restart=()"//newline// &
         "if compgen -G "//job%checkpoints//" > /dev/null; then restart=(--restart)"//newline// &
         "elif [ ! -e "//job%summary//" ]; then restart=(--overwrite); fi"//newline// &
         "code=0"//newline
   end function restart_text

   !> The command that continues a run that was stopped with a checkpoint: the command line, with
   !! --restart in place of one that may name an older file.
   function resume_command(ranks) result(text)
      integer, intent(in) :: ranks                   !! Of the run
      character(len=:), allocatable :: text
      character(len=16) :: digits
      integer :: n
      logical :: after

      text = ""
      write (digits, "(i0)") ranks
      if (ranks > 1) text = "mpirun -n "//trim(digits)//" "
      text = text//quoted(program_name())
      after = .false.
      associate (arguments => program_arguments())
         do n = 1, size(arguments)
            call add_word(arguments(n)%text, after, text)
         end do
      end associate
      text = text//" --restart"
   end function resume_command

   !> Add a word to the command, unless it is --restart, the file after it, or --overwrite.
   pure subroutine add_word(word, after, text)
      character(len=*), intent(in) :: word           !! From the command line
      logical, intent(inout) :: after                !! Was the previous word --restart?
      character(len=:), allocatable, intent(inout) :: text !! Extended
      logical :: file

      file = after .and. len(word) > 3 .and. index(word, ".h5", back=.true.) == len(word) - 2
      after = word == "--restart" .or. word == "-r"
      if (.not. (file .or. after .or. word == "--overwrite" .or. index(word, "--restart=") == 1)) &
         text = text//" "//quoted(word)
   end subroutine add_word

   !> The name under which the program was called.
   function program_name() result(name)
      character(len=:), allocatable :: name
      integer :: length

      call get_command_argument(0, length=length)
      allocate (character(len=length) :: name)
      if (length > 0) call get_command_argument(0, name)
   end function program_name

   !> A word in the quotes that the shell needs.
   pure function quoted(word) result(text)
      character(len=*), intent(in) :: word           !! Text
      character(len=:), allocatable :: text
      character(len=*), parameter :: plain = "abcdefghijklmnopqrstuvwxyz"// &
         "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+=:,@%"
      integer :: letter

      text = word
      if (len(word) > 0 .and. verify(word, plain) == 0) return
      text = "'"
      do letter = 1, len(word)
         if (word(letter:letter) == "'") then
            text = text//"'\''"
         else
            text = text//word(letter:letter)
         end if
      end do
      text = text//"'"
   end function quoted
end module program_batch_job
