! SPDX-License-Identifier: BSD-3-Clause
!> Sorts particles after they have moved: long particles are split, and all go to their tiles and
!! ranks.
module step_sort_particles
   use base_kinds, only: int64, wp
   use particle_migrate, only: migrate
   use particle_split, only: split_store
   use step_ledger, only: dissipated
   use step_normalised_sums, only: find_full
   use step_simulation, only: simulation_t, velocity_field_t
   implicit none
   private

   public :: count_particles, sort_particles, split_particles

contains

   !> Halve the particles that have become long.
   subroutine split_particles(simulation)
      type(simulation_t), intent(inout) :: simulation
      integer :: n

      call simulation%machine%timer%start(simulation%machine%phase%sort)
      do n = 1, size(simulation%fields)
         call split_field(simulation, simulation%fields(n))
      end do
      call simulation%machine%timer%stop(simulation%machine%phase%sort)
   end subroutine split_particles

   !> One velocity field.
   subroutine split_field(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      real(wp), allocatable :: gain(:)
      logical, allocatable :: full(:, :)
      integer :: index, n

      do index = field%first_store, field%last_store
         call find_full(simulation%space, simulation%scheme, simulation%machine, field, index, &
            full)
         call split_store(simulation%scheme%method%splitting, full, simulation%space%grid, &
            simulation%space%boundary, simulation%space%tiles, simulation%stores(index), gain)
         simulation%clock%halved = simulation%clock%halved + size(gain)
         do n = 1, size(gain)
            call simulation%balance%ledger%sums(dissipated)%add(-gain(n))
         end do
      end do
   end subroutine split_field

   !> Record particles that left the domain, and sort the others into their tiles.
   subroutine sort_particles(simulation)
      type(simulation_t), intent(inout) :: simulation
      real(wp) :: waited

      waited = simulation%machine%communicator%traffic%waiting
      call simulation%machine%timer%start(simulation%machine%phase%sort)
      call simulation%balance%ledger%record_lost(simulation%stores, simulation%materials)
      call migrate(simulation%machine%communicator, simulation%space%grid, &
         simulation%space%boundary, &
         simulation%space%tiles, &
         simulation%stores)
      call simulation%machine%timer%stop(simulation%machine%phase%sort)
      if (simulation%machine%communicator%size > 1) call &
         simulation%machine%timer%move(simulation%machine%phase%sort, &
         simulation%machine%phase%wait, simulation%machine%communicator%traffic%waiting - waited)
   end subroutine sort_particles

   !> Number of particles of this rank.
   pure integer(int64) function count_particles(simulation) result(particles)
      type(simulation_t), intent(in) :: simulation
      integer :: index

      particles = 0
      do index = 1, size(simulation%stores)
         particles = particles + simulation%stores(index)%particles()
      end do
   end function count_particles
end module step_sort_particles
