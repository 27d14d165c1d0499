! SPDX-License-Identifier: BSD-3-Clause
!> Work, communication and memory of the ranks in CASE.summary.json: mean and greatest value of each
!! count. They do not depend on the speed of the machine, so they show how a run scales where only
!! a few of its ranks have a core.
module output_rank_counts
   use base_kinds, only: int64, wp
   use base_process, only: peak_memory, private_memory
   use io_summary, only: json_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: add_rank_counts, find_rank_counts, rank_counts_t

   integer, parameter :: counts = 12                 !! Number of counts
   integer(int64), parameter :: word = 8             !! Bytes of a word
   character(len=26), parameter :: names(counts) = [character(len=26) :: "messages", "bytes", &
      "collective_calls", "collective_bytes", "particle_updates", "tiles", "ghost_tiles", &
      "nodes", "memory_peak_bytes", "memory_private_bytes", "memory_of_mpi_bytes", &
      "memory_by_ranks_bytes"]

   !> Counts over the ranks. Those of work and communication are sums over the steps.
   type :: rank_counts_t
      integer(int64) :: steps = 0                    !! Steps of these counts
      integer(int64) :: least(counts) = 0            !! Least values over all ranks
      integer(int64) :: total(counts) = 0            !! Sum over the ranks
      integer(int64) :: greatest(counts) = 0         !! Greatest values over all ranks
   end type rank_counts_t

contains

   !> Find the counts. Collective.
   subroutine find_rank_counts(simulation, found)
      type(simulation_t), intent(in) :: simulation
      type(rank_counts_t), intent(out) :: found
      integer(int64) :: bounds(2*counts)

      associate (machine => simulation%machine, work => simulation%machine%work)
         found%steps = work%steps
         found%total = [work%sent(1), word*work%sent(2), work%sent(3), word*work%sent(4), &
            simulation%clock%updates, work%tiles, work%ghosts, work%nodes, peak_memory(), &
            private_memory(), machine%communicator%memory, &
            word*size(simulation%space%tiles%border, kind=int64)]
         bounds = [found%total, -found%total]
         call machine%communicator%least(bounds)
         found%least = bounds(:counts)
         found%greatest = -bounds(counts + 1:)
         call machine%communicator%total(found%total)
      end associate
   end subroutine find_rank_counts

   !> Write the counts.
   subroutine add_rank_counts(json, found, ranks)
      type(json_t), intent(inout) :: json
      type(rank_counts_t), intent(in) :: found
      integer, intent(in) :: ranks                   !! Number of ranks
      integer :: n

      call json%begin("rank_counts")
      call json%add("steps", found%steps)
      do n = 1, counts
         call json%begin(trim(names(n)))
         call json%add("min", found%least(n))
         call json%add("avg", real(found%total(n), wp)/real(ranks, wp))
         call json%add("max", found%greatest(n))
         call json%end()
      end do
      call json%end()
   end subroutine add_rank_counts
end module output_rank_counts
