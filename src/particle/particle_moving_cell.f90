! SPDX-License-Identifier: BSD-3-Clause
!> Particles of a moving cell: the sums for its stress, and their positions when its
!! edges are replaced by equivalent ones.
module particle_moving_cell
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: wp
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use mesh_moving_cell, only: moving_cell_t
   use mesh_tiles, only: tiles_t
   use particle_place, only: place_tile
   use particle_store, only: store_t
   implicit none
   private

   public :: find_mass, measure_cell, shift_particles

   integer, parameter :: sums = 18                   !! As in the cell

contains

   !> Sums over all particles for the stress of the cell; the previous sums are kept. The sum of a
   !! tile is in the order of its particles, the sum of tiles is exact. Collective.
   subroutine measure_cell(communicator, stores, cell)
      type(communicator_t), intent(in) :: communicator
      type(store_t), intent(in) :: stores(:)         !! Sorted
      type(moving_cell_t), intent(inout) :: cell     !! Gets the sums
      real(wp), allocatable :: part(:, :)
      type(exact_sum_t) :: total(sums)
      integer :: index, tile, k

      do index = 1, size(stores)
         allocate (part(sums, size(stores(index)%count)))
         !$omp parallel do default(none) shared(stores, index, part) private(tile) schedule(static)
         do tile = 1, size(stores(index)%count)
            call sum_tile(stores(index), tile, part(:, tile))
         end do
         !$omp end parallel do
         do tile = 1, size(part, 2)
            do k = 1, sums
               call total(k)%add(part(k, tile))
            end do
         end do
         deallocate (part)
      end do
      cell%sums%former = cell%sums%now
      do k = 1, sums
         call total(k)%over_ranks(communicator)
         cell%sums%now(k) = total(k)%value()
      end do
   end subroutine measure_cell

   !> Stress times volume and mass times squares of velocities of a tile [J].
   pure subroutine sum_tile(store, tile, part)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(out) :: part(:)               !! (sum)
      integer, parameter :: one(6) = [1, 2, 3, 1, 2, 1], two(6) = [1, 2, 3, 2, 3, 3]
      integer :: p, k, first

      part = 0.0_wp
      first = merge(1, 7, allocated(store%state%energy))
      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         do k = 1, 6
            part(first + k - 1) = part(first + k - 1) + store%state%volume(p) &
               *store%state%stress(p, k)
            part(12 + k) = part(12 + k) + store%state%mass(p)*store%velocity(p, one(k)) &
               *store%velocity(p, two(k))
         end do
      end do
   end subroutine sum_tile

   !> Mass of all particles [kg]. Collective.
   real(wp) function find_mass(communicator, stores) result(mass)
      type(communicator_t), intent(in) :: communicator
      type(store_t), intent(in) :: stores(:)
      type(exact_sum_t) :: total
      integer :: index, tile, p

      do index = 1, size(stores)
         associate (store => stores(index))
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  call total%add(store%state%mass(p))
               end do
            end do
         end associate
      end do
      call total%over_ranks(communicator)
      mass = total%value()
   end function find_mass

   !> Convert the positions of all particles to the mesh of the equivalent edges. The caller must
   !! sort them afterwards.
   subroutine shift_particles(grid, boundary, tiles, cell, stores)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(tiles_t), intent(in) :: tiles
      type(moving_cell_t), intent(in) :: cell        !! Its edges have been replaced
      type(store_t), intent(inout) :: stores(:)      !! Sorted
      integer :: index, tile

      do index = 1, size(stores)
         !$omp parallel do default(none) shared(grid, boundary, tiles, cell, stores, index) &
         !$omp private(tile) schedule(static)
         do tile = 1, size(stores(index)%count)
            associate (store => stores(index))
               call cell%shift(grid%lower, store%first(tile), &
                  store%first(tile) + store%count(tile) - 1, store%position)
               call place_tile(grid, boundary, tiles%coordinate(:, tile), store, tile)
            end associate
         end do
         !$omp end parallel do
      end do
   end subroutine shift_particles
end module particle_moving_cell
