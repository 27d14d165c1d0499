! SPDX-License-Identifier: BSD-3-Clause
!> Volume factors of bodies whose particles lie at random: the total volume of a body is exactly
!! that
!! of its lattice sites, whatever the number of particles.
module particle_volume_factors
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_coordinate
   use particle_body, only: belongs, body_t, site_position, tile_sites
   use particle_fill, only: candidate_tiles, site_volume
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
      type(exact_sum_t) :: lattice, given
      integer(int64), allocatable :: key(:)
      real(wp), allocatable :: sums(:, :)
      integer :: body, tile

      do body = 1, size(bodies)
         if (bodies(body)%on_lattice()) cycle
         if (.not. bodies(body)%given%clipped) cycle
         call candidate_tiles(grid, bodies(body:body), key)
         allocate (sums(2, size(key)))
         sums = 0.0_wp
         !$omp parallel do default(none) shared(communicator, grid, bodies, body, key, sums) &
         !$omp private(tile) schedule(dynamic, 4)
         do tile = communicator%rank + 1, size(key), communicator%size
            call sum_volumes(grid, bodies, body, hilbert_coordinate(key(tile), grid%dimensions), &
               sums(:, tile))
         end do
         !$omp end parallel do
         call lattice%clear()
         call given%clear()
         call lattice%add_all(sums(1, :))
         call given%add_all(sums(2, :))
         call lattice%over_ranks(communicator)
         call given%over_ranks(communicator)
         bodies(body)%share = 0.0_wp
         if (given%value() > 0.0_wp) bodies(body)%share = lattice%value()/given%value()
         deallocate (sums)
      end do
   end subroutine set_volume_factors

   !> Sum the volume of the lattice sites of a body in a tile and the weights of its particles.
   pure subroutine sum_volumes(grid, bodies, body, coordinate, sums)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      real(wp), intent(inout) :: sums(2)              !! Grows [m3, 1 or m]
      real(wp), allocatable :: position(:, :), volume(:)
      integer(int64), allocatable :: number(:)
      real(wp) :: middle(3)
      integer :: later(size(bodies) - body), sites(3), x, y, z, n

      later = [(n, n=body + 1, size(bodies))]
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
