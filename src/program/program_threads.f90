! SPDX-License-Identifier: BSD-3-Clause
!> How many threads a rank uses, and how they wait for each other. What the user has set in the
!! environment stays as it is.
module program_threads
   use base_kinds, only: int64, wp
   use base_process, only: cores_here, is_set, ranks_here, restart_process, set_default
   use base_text, only: number, text_t
   use io_file, only: program_path
   use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_set_num_threads
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: adjust_threads, choose_threads, is_starved, share_cores, starved_text, &
      threads_text, warranted_threads, yield_when_waiting

   integer, parameter :: adjust_every = 25           !! Steps between two looks at the load

   !> Fewest particles that occupy a thread. A step has about 25 places where threads wait for each
   !! other, 5 us each on a quiet node, and a particle takes about 0.3 us: below 800 particles for
   !! two threads, waiting takes longer than what the second one saves.
   integer(int64), parameter :: particles_a_thread = 500

   !> Turns of the loop in which a thread waits before it gives its core away. On common processors
   !! it lasts 0.1 to 0.5 ms, longer than most waits in a step and shorter than the time slice of
   !! another program. The default of libgomp is 30 times as long, and a thread that waits for one
   !! without a core then holds up both.
   character(len=*), parameter :: spin_count = "10000"

contains

   !> Give each rank on a machine its share of the cores, if the user does not say how many threads.
   subroutine share_cores()
      if (is_set("OMP_NUM_THREADS")) return
      call omp_set_num_threads(max(1, min(omp_get_num_procs(), cores_here()/ranks_here())))
   end subroutine share_cores

   !> Have threads that wait for long give their core away. The library of OpenMP reads how before
   !! the program begins, so the program begins again, once, with this in its environment.
   subroutine yield_when_waiting(arguments)
      type(text_t), intent(in) :: arguments(:)       !! Of the command line
      character(len=:), allocatable :: name
      integer :: length

      if (ranks_here()*omp_get_max_threads() > cores_here()) &
         call set_default("OMPI_MCA_mpi_yield_when_idle", "1")
      if (omp_get_max_threads() == 1) return
      if (is_set("OMP_WAIT_POLICY")) return
      if (is_set("GOMP_SPINCOUNT")) return
      call set_default("GOMP_SPINCOUNT", spin_count)
      ! an empty word of the user, which set_default leaves, must not lead here for ever
      if (.not. is_set("GOMP_SPINCOUNT")) return
      call get_command_argument(0, length=length)
      allocate (character(len=length) :: name)
      if (length > 0) call get_command_argument(0, name)
      if (len(program_path()) > 0) call restart_process(program_path(), name, arguments)
   end subroutine yield_when_waiting

   !> Threads that tiles and particles can keep busy.
   pure integer function warranted_threads(most, tiles, particles) result(threads)
      integer, intent(in) :: most                    !! Greatest number
      integer, intent(in) :: tiles                   !! Tiles with particles of this rank
      integer(int64), intent(in) :: particles        !! Particles of this rank

      threads = int(min(int(most, int64), int(tiles, int64), particles/particles_a_thread))
      threads = max(threads, 1)
   end function warranted_threads

   !> Choose the threads from what the bodies will fill, before there are particles.
   subroutine choose_threads(most, tiles, particles)
      integer, intent(in) :: most                    !! Greatest number
      integer, intent(in) :: tiles                   !! Tiles with particles of a rank
      integer(int64), intent(in) :: particles        !! Particles of a rank

      if (is_set("OMP_NUM_THREADS")) return
      call omp_set_num_threads(warranted_threads(most, tiles, particles))
   end subroutine choose_threads

   !> Follow the load of this rank, which changes as material spreads over tiles and tiles move
   !! between ranks. The numbers that are computed do not depend on it.
   subroutine adjust_threads(simulation)
      type(simulation_t), intent(in) :: simulation   !! The run with particles
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

   !> A line on the threads of a rank; empty if all its cores have one.
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

   !> True if a part of a run took far more wall time than the processor worked for it: half of the
   !! time or more its threads had no core, or nothing to do.
   pure logical function is_starved(wall, processor, threads) result(starved)
      real(wp), intent(in) :: wall                   !! Wall time of the part [s]
      real(wp), intent(in) :: processor              !! Processor time of all threads [s]
      integer, intent(in) :: threads                 !! Threads that it uses
      real(wp), parameter :: least = 5.0_wp          ! shorter runs are not worth a remark [s]

      starved = wall > least .and. wall*real(threads, wp) > 2.0_wp*processor
   end function is_starved

   !> The warning that says so.
   function starved_text(what, wall, processor, threads) result(text)
      character(len=*), intent(in) :: what           !! Part of the run
      real(wp), intent(in) :: wall                   !! Wall time of the part [s]
      real(wp), intent(in) :: processor              !! Processor time of all threads [s]
      integer, intent(in) :: threads                 !! Threads that it uses
      character(len=:), allocatable :: text
      character(len=96) :: line

      write (line, "(a,f0.1,a,f0.1,a)") " took ", wall, " s of wall time and ", processor, &
         " s of processor time on "
      text = "warning: "//what//trim(line)//" "//number(threads)//" threads: other work shares "// &
         "the cores, the run was suspended, "
      if (threads > 1) then
         text = text//"or threads wait for each other; try OMP_NUM_THREADS="// &
            number(max(threads/2, 1))
      else
         text = text//"or files are slow; give the run a core of its own and a local disk"
      end if
   end function starved_text
end module program_threads
