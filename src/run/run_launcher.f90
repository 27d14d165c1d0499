! SPDX-License-Identifier: BSD-3-Clause
!> Commands that start the program on several ranks, each on cores of its own, with the MPI library
!! of this build.
module run_launcher
   use base_communicator, only: message_passing_version
   use base_text, only: number
   use base_version, only: has_ranks
   implicit none
   private

   public :: launch_text, srun_setting

contains

   !> The command before the program, with a blank at its end; empty in a build without MPI. It
   !! binds each rank to as many cores as it has threads.
   function launch_text(ranks, threads) result(text)
      integer, intent(in) :: ranks                   !! Number of ranks
      integer, intent(in) :: threads                 !! Threads of each rank
      character(len=:), allocatable :: text
      character(len=:), allocatable :: version

      text = ""
      if (.not. has_ranks) return
      text = "mpirun -n "//number(ranks)//" "
      version = message_passing_version()
      if (index(version, "Open MPI") > 0) then
         text = text//"--map-by slot:PE="//number(threads)//" --bind-to core "
      else if (index(version, "Intel") > 0) then
         text = "I_MPI_PIN_DOMAIN=omp "//text
      else if (index(version, "MPICH") > 0) then
         text = text//"-bind-to core:"//number(threads)//" "
      end if
   end function launch_text

   !> Line of a job script that lets `srun` start the ranks of Open MPI with PMIx, if Slurm has it
   !! and the user has not chosen anything else; empty with other MPI libraries.
   function srun_setting() result(text)
      character(len=:), allocatable :: text

      text = ""
      if (.not. has_ranks) return
      if (index(message_passing_version(), "Open MPI") == 0) return
      text = "if srun --mpi=list 2>&1 | grep -qw pmix; then "// &
         "export SLURM_MPI_TYPE=""${SLURM_MPI_TYPE:-pmix}""; fi"
   end function srun_setting
end module run_launcher
