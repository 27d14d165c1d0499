! SPDX-License-Identifier: BSD-3-Clause
!> Volume factors of bodies with randomly placed particles: the total volume of a body is exactly
!! that of its lattice sites, whatever the number of particles.
module particle_volume_factors
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use base_progress, only: progress_t
   use mesh_grid, only: grid_t
   use omp_lib, only: omp_get_thread_num
   use particle_body, only: belongs, body_t, site_position, tile_sites
   use particle_candidates, only: candidates_t
   use particle_fill, only: site_volume
   implicit none
   private

   public :: set_volume_factors

contains

   !> Find the volume factor of each body whose given particles have relative weights only.
   !! The sums are exact, so they do not depend on the ranks.
   subroutine set_volume_factors(communicator, grid, bodies)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(body_t), intent(inout) :: bodies(:)
      type(candidates_t) :: candidates
      type(exact_sum_t) :: lattice, given, own(2)
      type(progress_t) :: progress
      integer(int64) :: round, rounds
      real(wp) :: sums(2)
      integer :: body, coordinate(3)
      logical :: dealt

      do body = 1, size(bodies)
         if (bodies(body)%on_lattice()) cycle
         if (.not. bodies(body)%given%clipped) cycle
         call candidates%find(grid, bodies(body:body))
         call lattice%clear()
         call given%clear()
         rounds = candidates%rounds(communicator)
         call progress%start(communicator%rank)
         !$omp parallel default(none) private(round, coordinate, dealt, sums, own) &
         !$omp shared(communicator, grid, bodies, body, candidates, lattice, given, rounds) &
         !$omp shared(progress)
         call own(1)%clear()
         call own(2)%clear()
         !$omp do schedule(dynamic, 4)
         do round = 1, rounds
            if (omp_get_thread_num() == 0) call progress%show("placing the particles of '"// &
               bodies(body)%name//"'", round, rounds)
            call candidates%deal(communicator, round, coordinate, dealt)
            if (.not. dealt) cycle
            call sum_volumes(grid, bodies, body, coordinate, sums)
            call own(1)%add(sums(1))
            call own(2)%add(sums(2))
         end do
         !$omp end do nowait
         !$omp critical (volume_sums)
         call lattice%merge(own(1))
         call given%merge(own(2))
         !$omp end critical (volume_sums)
         !$omp end parallel
         call lattice%over_ranks(communicator)
         call given%over_ranks(communicator)
         bodies(body)%share = 0.0_wp
         if (given%value() > 0.0_wp) bodies(body)%share = lattice%value()/given%value()
      end do
   end subroutine set_volume_factors

   !> Sum the volume of the lattice sites of a body in a tile and the weights of its particles.
   pure subroutine sum_volumes(grid, bodies, body, coordinate, sums)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      real(wp), intent(out) :: sums(2)                !! [m3, 1 or m]
      real(wp), allocatable :: position(:, :), volume(:)
      integer(int64), allocatable :: number(:)
      real(wp) :: middle(3)
      integer :: later(size(bodies) - body), sites(3), x, y, z, n

      later = [(n, n=body + 1, size(bodies))]
      sums = 0.0_wp
      sites = tile_sites(grid, bodies(body), coordinate)
      do z = 0, sites(3) - 1
         do y = 0, sites(2) - 1
            do x = 0, sites(1) - 1
               middle = site_position(grid, bodies(body), coordinate, [x, y, z])
               if (belongs(bodies, body, middle, later)) &
                  sums(1) = sums(1) + site_volume(grid, bodies(body), middle)
            end do
         end do
      end do
      call bodies(body)%given%collect(grid, coordinate, position, volume, number)
      do n = 1, size(number)
         if (belongs(bodies, body, position(:, n), later)) sums(2) = sums(2) + volume(n)
      end do
   end subroutine sum_volumes
end module particle_volume_factors
