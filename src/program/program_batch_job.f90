! SPDX-License-Identifier: BSD-3-Clause
!> Scripts for the schedulers of clusters. A job that comes to the end of its time writes a
!! checkpoint, leaves with the exit code that asks for another run, and is put into the queue again.
module program_batch_job
   use base_clock, only: clock_seconds, clock_text
   use base_deck_override, only: removal_mark
   use base_error, only: error_t, exit_again, exit_input, fail
   use base_kinds, only: int64, wp
   use base_text, only: number
   use io_file, only: join_path, program_path
   use program_command_line, only: program_arguments
   use program_plan, only: plan_t
   implicit none
   private

   public :: job_text, quoted, resume_command

   real(wp), parameter :: particles_of_rank = 1.0e6_wp !! doc/developer/scaling.md says why
   integer, parameter :: usual_threads = 4           !! Of a rank, where there are tiles for them
   character(len=*), parameter :: usual_time = "04:00:00" !! Of a job
   integer, parameter :: usual_notice = 300, least_notice = 60 !! Before the end of a job [s]
   character(len=*), parameter :: newline = new_line("a")

   !> What the script of a job says.
   type :: job_t
      integer :: ranks = 1                           !! Ranks
      integer :: threads = 1                         !! Threads of each
      integer :: seconds = 0                         !! Wall time [s]
      integer :: notice = usual_notice               !! To write the last checkpoint [s]
      character(len=:), allocatable :: time          !! The wall time as a text
      character(len=:), allocatable :: case          !! Prefix of all files
      character(len=:), allocatable :: command       !! The program with its options
      character(len=:), allocatable :: checkpoints   !! Pattern of the files to go on from
      character(len=:), allocatable :: summary       !! File of a run that has ended
      character(len=:), allocatable :: hints         !! Comments for the reader
   end type job_t

contains

   !> The script of a job.
   subroutine job_text(plan, deck, text, error)
      class(plan_t), intent(in) :: plan              !! What will run
      character(len=*), intent(in) :: deck           !! Deck, as seen from where the job starts
      character(len=:), allocatable, intent(out) :: text !! The script
      type(error_t), allocatable, intent(out) :: error !! The job could not be called back
      type(job_t) :: job
      integer :: n

      text = ""
      if (all([(trim(plan%limits%signals(n)) /= "USR1", n=1, size(plan%limits%signals))])) then
         call fail(error, exit_input, "the job is told of its end by the signal USR1; "// &
            "add 'USR1' to on_signal in &checkpoint of "//plan%command%deck)
         return
      end if
      call plan_job(plan, deck, job)
      if (plan%command%job == "pbs") then
         text = pbs_text(job)
      else
         text = slurm_text(job)
      end if
   end subroutine job_text

   !> Numbers and words of a job.
   subroutine plan_job(plan, deck, job)
      class(plan_t), intent(in) :: plan              !! What will run
      character(len=*), intent(in) :: deck           !! Deck, as seen from where the job starts
      type(job_t), intent(out) :: job                !! The job
      integer :: tiles

      tiles = max(size(plan%survey%key), 1)
      job%ranks = min(max(ceiling(real(plan%survey%particles, wp)/particles_of_rank), 1), tiles)
      if (plan%command%ranks > 0) job%ranks = plan%command%ranks
      job%threads = max(min(usual_threads, tiles/job%ranks), 1)
      if (plan%command%threads > 0) job%threads = plan%command%threads
      job%time = usual_time
      if (allocated(plan%command%job_time)) job%time = plan%command%job_time
      job%seconds = clock_seconds(job%time)
      job%notice = min(usual_notice, max(least_notice, job%seconds/10))
      job%case = plan%place%case
      job%checkpoints = quoted(join_path(plan%place%folder, job%case//"_chk_")//"*.h5")
      job%summary = quoted(join_path(plan%place%folder, job%case//".summary.json"))
      job%command = quoted(program_path())//options_text(plan)//" "//quoted(deck)
      job%hints = hints_text(plan, job)
   end subroutine plan_job

   !> Options of the command line that the script passes on.
   function options_text(plan) result(text)
      class(plan_t), intent(in) :: plan              !! With the command line
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      associate (command => plan%command)
         if (allocated(command%output_folder)) &
            text = text//" --outdir "//quoted(command%output_folder)
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

   !> What the reader of the script should know.
   function hints_text(plan, job) result(text)
      class(plan_t), intent(in) :: plan              !! What will run
      type(job_t), intent(in) :: job                 !! Its numbers
      character(len=:), allocatable :: text

      text = "# "//number(plan%survey%particles)//" particles in "// &
         number(size(plan%survey%key))//" tiles; about a million particles a rank use a "// &
         "machine well."//newline
      if (plan%command%job == "pbs") then
         text = text//"# The limit below takes the place of wall_limit in the deck."
      else if (plan%limits%ask_scheduler) then
         text = text//"# The run asks Slurm when the job ends (wall_limit = 'slurm' in the deck)."
      else if (plan%limits%wall_limit < real(job%seconds, wp)) then
         text = text//"# wall_limit of the deck ends the run before the job does."
      else if (plan%limits%wall_limit < huge(1.0_wp)) then
         text = text//"# wall_limit of the deck is longer than the job; the signal ends it."
      else
         text = text//"# With wall_limit = 'slurm' in &time the run watches its clock as well."
      end if
      text = text//newline
   end function hints_text

   !> A script for Slurm. The signal goes to the ranks, not to the shell.
   function slurm_text(job) result(text)
      type(job_t), intent(in) :: job                 !! The job
      character(len=:), allocatable :: text

      text = "#!/bin/bash"//newline// &
         "#SBATCH --job-name="//job%case//newline// &
         "#SBATCH --ntasks="//number(job%ranks)//newline// &
         "#SBATCH --cpus-per-task="//number(job%threads)//newline// &
         "#SBATCH --time="//job%time//newline// &
         "#SBATCH --signal=USR1@"//number(job%notice)//newline// &
         "#SBATCH --requeue"//newline// &
         "#SBATCH --open-mode=append"//newline// &
         "# Scree: USR1 asks for a checkpoint "//number(job%notice)//" s before the end; exit "// &
         "code "//number(exit_again)//" means: run again."//newline//job%hints// &
         "export OMP_NUM_THREADS=""${SLURM_CPUS_PER_TASK:-"//number(job%threads)//"}"""//newline// &
         "export SRUN_CPUS_PER_TASK=""${OMP_NUM_THREADS}"""//newline//places_text()// &
         restart_text(job)// &
         "srun "//job%command//" ""${restart[@]}"" || code=$?"//newline// &
         "if [ ""${code}"" -eq "//number(exit_again)//" ]; then"//newline// &
         "   scontrol requeue ""${SLURM_JOB_ID}"" || echo 'submit this script again' >&2"// &
         newline//"fi"//newline//"exit ""${code}"""//newline
   end function slurm_text

   !> A script for PBS, which sends no signal in advance: the run watches the clock, and the script
   !! submits itself anew.
   function pbs_text(job) result(text)
      type(job_t), intent(in) :: job                 !! The job
      character(len=:), allocatable :: text

      text = "#!/bin/bash"//newline// &
         "#PBS -N "//job%case//newline// &
         "#PBS -l select="//number(job%ranks)//":ncpus="//number(job%threads)// &
         ":mpiprocs=1:ompthreads="//number(job%threads)//newline// &
         "#PBS -l walltime="//job%time//newline// &
         "#PBS -j oe"//newline// &
         "# Scree: a run leaves "//number(job%notice)//" s before the end of the job with a "// &
         "checkpoint; exit"//newline// &
         "# code "//number(exit_again)//" means: run again."//newline//job%hints// &
         "cd ""${PBS_O_WORKDIR:-.}"" || exit 3"//newline// &
         "export OMP_NUM_THREADS="//number(job%threads)//newline//places_text()// &
         restart_text(job)// &
         "mpirun -n "//number(job%ranks)//" "//job%command//" --set time.wall_limit="// &
         clock_text(job%seconds - job%notice)//" ""${restart[@]}"" || code=$?"//newline// &
         "if [ ""${code}"" -eq "//number(exit_again)//" ]; then"//newline// &
         "   qsub ""$0"" || echo 'submit this script again' >&2"//newline// &
         "fi"//newline//"exit ""${code}"""//newline
   end function pbs_text

   !> Where threads run, and files on systems whose locks fail.
   pure function places_text() result(text)
      character(len=:), allocatable :: text

      text = "export OMP_PLACES=cores OMP_PROC_BIND=close HDF5_USE_FILE_LOCKING=FALSE"//newline
   end function places_text

   !> Go on if there is something to go on from. A run that was killed before its first checkpoint
   !! has no summary, and begins anew.
   pure function restart_text(job) result(text)
      type(job_t), intent(in) :: job                 !! The job
      character(len=:), allocatable :: text

      text = "restart=()"//newline// &
         "if compgen -G "//job%checkpoints//" > /dev/null; then restart=(--restart)"//newline// &
         "elif [ ! -e "//job%summary//" ]; then restart=(--overwrite); fi"//newline// &
         "code=0"//newline
   end function restart_text

   !> The command that goes on with a run that was stopped with a checkpoint: what was typed, with
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

   !> Add a word to the command, unless it is --restart, the file behind that, or --overwrite.
   pure subroutine add_word(word, after, text)
      character(len=*), intent(in) :: word           !! From the command line
      logical, intent(inout) :: after                !! Was the word before --restart?
      character(len=:), allocatable, intent(inout) :: text !! Grows
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

   !> A word as the shell takes it for one.
   pure function quoted(word) result(text)
      character(len=*), intent(in) :: word           !! Any text
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
