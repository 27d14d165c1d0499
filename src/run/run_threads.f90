! SPDX-License-Identifier: BSD-3-Clause
!> Number of threads of a rank, and their waiting policy. Environment variables that the
!! user has set have precedence.
module run_threads
   use base_file, only: program_path
   use base_kinds, only: int64, wp
   use base_process, only: cores_here, is_set, ranks_here, restart_process, set_default
   use base_text, only: number, text_t
   use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_set_num_threads
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: adjust_threads, choose_threads, is_starved, share_cores, sleep_when_waiting, &
      starved_text, threads_text, warranted_threads, yield_when_waiting

   integer, parameter :: adjust_every = 25           !! Steps between adjustments

   !> Least number of particles for each thread. Threads wait for each other about 25 times a step,
   !! 5 us each on an idle node, and a particle takes about 0.3 us: below 800 particles for two
   !! threads, waiting takes longer than the second thread saves.
   integer(int64), parameter :: particles_a_thread = 500

   !> Iterations of the loop in which a thread waits before it releases its core: 0.1 to 0.5 ms on
   !! common processors, longer than most waits in a step and shorter than the time slice of another
   !! program. With the default of libgomp, 30 times as long, a thread that waits for one without a
   !! core delays both.
   character(len=*), parameter :: spin_count = "10000"

contains

   !> Divide the cores of a node among its ranks, unless OMP_NUM_THREADS is set.
   subroutine share_cores()
      if (is_set("OMP_NUM_THREADS")) return
      call omp_set_num_threads(max(1, min(omp_get_num_procs(), cores_here()/ranks_here())))
   end subroutine share_cores

   !> Have threads release their cores after a short wait. The OpenMP library reads the setting
   !! before the program starts, so the program restarts itself once with it in the environment.
   subroutine yield_when_waiting(arguments)
      type(text_t), intent(in) :: arguments(:)       !! Of the command line

      if (ranks_here()*omp_get_max_threads() > cores_here()) &
         call set_default("OMPI_MCA_mpi_yield_when_idle", "1")
      if (omp_get_max_threads() == 1) return
      if (is_set("OMP_WAIT_POLICY")) return
      if (is_set("GOMP_SPINCOUNT")) return
      call set_default("GOMP_SPINCOUNT", spin_count)
      ! set_default keeps an empty value of the user: without this test the restart would be
      ! repeated
      if (.not. is_set("GOMP_SPINCOUNT")) return
      call restart_with_environment(arguments)
   end subroutine yield_when_waiting

   !> Have threads release their cores at once when they wait, for runs with more threads than
   !! cores.
   subroutine sleep_when_waiting(arguments)
      type(text_t), intent(in) :: arguments(:)       !! Arguments of the command line

      if (is_set("OMP_WAIT_POLICY")) return
      call set_default("OMP_WAIT_POLICY", "passive")
      if (is_set("OMP_WAIT_POLICY")) call restart_with_environment(arguments)
   end subroutine sleep_when_waiting

   !> Restart the program, so that the OpenMP library reads the environment again. Returns only if
   !! that is not possible.
   subroutine restart_with_environment(arguments)
      type(text_t), intent(in) :: arguments(:)       !! Arguments of the command line
      character(len=:), allocatable :: name
      integer :: length

      call get_command_argument(0, length=length)
      allocate (character(len=length) :: name)
      if (length > 0) call get_command_argument(0, name)
      if (len(program_path()) > 0) call restart_process(program_path(), name, arguments)
   end subroutine restart_with_environment

   !> Number of threads for which there are enough tiles and particles.
   pure integer function warranted_threads(most, tiles, particles) result(threads)
      integer, intent(in) :: most                    !! Greatest number
      integer, intent(in) :: tiles                   !! Tiles with particles of this rank
      integer(int64), intent(in) :: particles        !! Particles of this rank

      threads = int(min(int(most, int64), int(tiles, int64), particles/particles_a_thread))
      threads = max(threads, 1)
   end function warranted_threads

   !> Set the number of threads, unless OMP_NUM_THREADS is set.
   subroutine choose_threads(most, tiles, particles)
      integer, intent(in) :: most                    !! Greatest number
      integer, intent(in) :: tiles                   !! Tiles with particles of a rank
      integer(int64), intent(in) :: particles        !! Particles of a rank

      if (is_set("OMP_NUM_THREADS")) return
      call omp_set_num_threads(warranted_threads(most, tiles, particles))
   end subroutine choose_threads

   !> Adjust the number of threads to the load of this rank, which changes as material spreads and
   !! tiles move between ranks. Results do not depend on it.
   subroutine adjust_threads(simulation)
      type(simulation_t), intent(in) :: simulation   !! With particles
      integer(int64) :: particles
      integer :: index

      if (size(simulation%scratch) == 1) return
      if (mod(simulation%clock%step, int(adjust_every, int64)) /= 0) return
      particles = 0
      do index = 1, size(simulation%stores)
         particles = particles + simulation%stores(index)%particles()
      end do
      call choose_threads(size(simulation%scratch), simulation%space%tiles%own, particles)
   end subroutine adjust_threads

   !> A line on the threads of a rank; empty if all are busy.
   function threads_text(most, tiles, particles) result(text)
      integer, intent(in) :: most                    !! Greatest number
      integer, intent(in) :: tiles                   !! Tiles with particles of a rank
      integer(int64), intent(in) :: particles        !! Particles of a rank
      character(len=:), allocatable :: text
      integer :: busy

      text = ""
      busy = warranted_threads(most, tiles, particles)
      if (busy == most) return
      text = "threads   "//number(particles)//" particles in "//number(tiles)// &
         " tiles of a rank occupy "//number(busy)//" of "//number(most)// &
         " threads at the start; "
      if (is_set("OMP_NUM_THREADS")) then
         text = text//"the number of OMP_NUM_THREADS is used"
      else
         text = text//"the number follows the load, OMP_NUM_THREADS sets another one"
      end if
   end function threads_text

   !> True if the threads were without a core, or idle, for at least half of the wall time.
   pure logical function is_starved(wall, processor, threads) result(starved)
      real(wp), intent(in) :: wall                   !! Wall time of the part [s]
      real(wp), intent(in) :: processor              !! Processor time of all threads [s]
      integer, intent(in) :: threads                 !! Threads that it uses
      real(wp), parameter :: least = 5.0_wp          ! no warning for shorter runs [s]

      starved = wall > least .and. wall*real(threads, wp) > 2.0_wp*processor
   end function is_starved

   !> Warning for a part of a run with too little processor time.
   function starved_text(what, wall, processor, threads) result(text)
      character(len=*), intent(in) :: what           !! Part of the run
      real(wp), intent(in) :: wall                   !! Wall time of the part [s]
      real(wp), intent(in) :: processor              !! Processor time of all threads [s]
      integer, intent(in) :: threads                 !! Threads that it uses
      character(len=:), allocatable :: text
      character(len=96) :: line

      write (line, "(a,f0.1,a,f0.1,a)") " took ", wall, " s of wall time and ", processor, &
         " s of processor time on "
      text = "warning: "//what//trim(line)//" "//number(threads)//" threads: other programs "// &
         "share the cores, the run was suspended, "
      if (threads > 1) then
         text = text//"or threads wait for each other; use OMP_NUM_THREADS="// &
            number(max(threads/2, 1))//" [R118]"
      else
         text = text//"or files are slow; give the run a core of its own and a local disk [R118]"
      end if
   end function starved_text
end module run_threads
