! SPDX-License-Identifier: BSD-3-Clause
!> Counts the particles of bodies and tiles, and sums their volumes, before particles exist.
module particle_survey
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_exact_totals, only: totals_over_ranks
   use base_kinds, only: int64, wp
   use base_progress, only: progress_t
   use base_sort, only: sort_order
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_key
   use omp_lib, only: omp_get_thread_num
   use particle_body, only: body_t, find_boxes, find_near
   use particle_candidates, only: candidates_t
   use particle_fill, only: count_sites
   implicit none
   private

   public :: survey_bodies

contains

   !> Count the particles of each body, and those of each tile assigned to this rank. Each tile is
   !! on the list of exactly one rank; no rank has a list of all. Volumes are exact sums, the same
   !! for any ranks and threads. Collective.
   subroutine survey_bodies(communicator, grid, bodies, key, particles, body_count, body_volume)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer(int64), allocatable, intent(out) :: key(:)       !! Tiles with particles, ascending
      integer(int64), allocatable, intent(out) :: particles(:) !! (tile) Number of particles
      integer(int64), intent(out) :: body_count(:)    !! (body) Particles of each, on all ranks
      real(wp), intent(out) :: body_volume(:)         !! (body) Volume of these particles [m3]
      type(candidates_t) :: candidates
      type(exact_sum_t), allocatable :: volumes(:), own_volumes(:)
      integer(int64), allocatable :: own(:), pairs(:, :)
      integer, allocatable :: order(:)
      real(wp), allocatable :: low(:, :), high(:, :)
      integer(int64) :: round, found, rounds
      integer :: coordinate(3), filled, body
      logical :: dealt
      type(progress_t) :: progress

      call candidates%find(grid, bodies)
      call find_boxes(grid, bodies, low, high)
      allocate (key(0), particles(0))
      body_count = 0
      allocate (volumes(size(bodies)))
      rounds = candidates%rounds(communicator)
      call progress%start(communicator%rank)
      !$omp parallel default(none) private(round, coordinate, dealt, own, pairs, filled, found) &
      !$omp private(own_volumes, body) shared(communicator, grid, bodies, low, high, candidates) &
      !$omp shared(key, particles, body_count, volumes, rounds, progress)
      allocate (own(size(bodies)), pairs(64, 2), own_volumes(size(bodies)))
      own = 0
      filled = 0
      !$omp do schedule(dynamic, 16)
      do round = 1, rounds
         if (omp_get_thread_num() == 0) call progress%show("counting particles", round, rounds)
         call candidates%deal(communicator, round, coordinate, dealt)
         if (.not. dealt) cycle
         call count_tile(grid, bodies, low, high, coordinate, own, own_volumes, found)
         if (found > 0) call append_pair(hilbert_key(coordinate, grid%dimensions), found, pairs, &
            filled)
      end do
      !$omp end do nowait
      !$omp critical (survey_counts)
      body_count = body_count + own
      key = [key, pairs(:filled, 1)]
      particles = [particles, pairs(:filled, 2)]
      do body = 1, size(bodies)
         if (own(body) > 0) call volumes(body)%merge(own_volumes(body))
      end do
      !$omp end critical (survey_counts)
      !$omp end parallel
      call communicator%total(body_count)
      call totals_over_ranks(communicator, volumes, body_volume)
      order = sort_order(key)
      key = key(order)
      particles = particles(order)
   end subroutine survey_bodies

   !> Append a tile and its particles to a list, which grows as needed.
   pure subroutine append_pair(key, particles, pairs, filled)
      integer(int64), intent(in) :: key               !! Position of the tile on the curve
      integer(int64), intent(in) :: particles         !! Particles in it
      integer(int64), allocatable, intent(inout) :: pairs(:, :) !! (entry, 2) The list
      integer, intent(inout) :: filled                !! Entries in use
      integer(int64), allocatable :: larger(:, :)

      if (filled == size(pairs, 1)) then
         allocate (larger(2*filled, 2))
         larger(:filled, :) = pairs
         call move_alloc(larger, pairs)
      end if
      filled = filled + 1
      pairs(filled, :) = [key, particles]
   end subroutine append_pair

   !> Count the particles of all bodies in a tile, and add their volumes.
   pure subroutine count_tile(grid, bodies, low, high, coordinate, body_count, body_volume, &
      particles)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), contiguous, intent(in) :: low(:, :)   !! (direction, body) Boxes of the bodies [m]
      real(wp), contiguous, intent(in) :: high(:, :)  !! (direction, body) [m]
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer(int64), intent(inout) :: body_count(:)  !! (body) Grows by its particles
      type(exact_sum_t), intent(inout) :: body_volume(:) !! (body) Grows by their volume
      integer(int64), intent(out) :: particles        !! Number of particles of all bodies
      integer(int64) :: found
      integer :: near(size(bodies)), number, n
      real(wp) :: volume

      call find_near(grid, low, high, coordinate, near, number)
      particles = 0
      do n = 1, number
         call count_sites(grid, bodies, near(n), near(n + 1:number), coordinate, found, volume)
         if (found == 0) cycle
         body_count(near(n)) = body_count(near(n)) + found
         call body_volume(near(n))%add(volume)
         particles = particles + found
      end do
   end subroutine count_tile
end module particle_survey
