! SPDX-License-Identifier: BSD-3-Clause
!> Sorts particles after they have moved: long particles are split, those of inflows enter, and all
!! move to their tiles and ranks.
module step_sort_particles
   use base_kinds, only: int64, wp
   use particle_inflow, only: fed_t
   use particle_migrate, only: migrate
   use particle_sort_tile, only: row_packer_t
   use particle_split, only: split_store
   use step_ledger, only: dissipated, lost_angular, lost_energy, lost_mass, lost_momentum
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
         if (.not. allocated(simulation%stores(index)%opening)) cycle
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
   subroutine sort_particles(simulation, began)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in), optional :: began        !! Begin of the step, in which inflows feed [s]
      type(fed_t), allocatable :: fed(:)
      real(wp) :: waited

      waited = simulation%machine%communicator%traffic%waiting
      call simulation%machine%timer%start(simulation%machine%phase%sort)
      call simulation%balance%ledger%record_lost(simulation%stores, simulation%materials)
      ! an array that is not allocated is an absent argument
      if (present(began) .and. allocated(simulation%effects%inflows)) &
         call feed_particles(simulation, began, fed)
      call migrate(simulation%machine%communicator, simulation%space%grid, &
         simulation%space%boundary, simulation%space%tiles, simulation%stores, fed)
      call simulation%machine%timer%stop(simulation%machine%phase%sort)
      if (simulation%machine%communicator%size > 1) call &
         simulation%machine%timer%move(simulation%machine%phase%sort, &
         simulation%machine%phase%wait, simulation%machine%communicator%traffic%waiting - waited)
   end subroutine sort_particles

   !> The particles that enter by inflows in a step. The ledger records them as negative losses.
   subroutine feed_particles(simulation, began, fed)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: began                  !! Begin of the step [s]
      type(fed_t), allocatable, intent(out) :: fed(:) !! (inflow)
      type(row_packer_t) :: packer
      integer :: n, row, p

      allocate (fed(size(simulation%effects%inflows)))
      do n = 1, size(fed)
         associate (inflow => simulation%effects%inflows(n))
            call inflow%enter(simulation%space%grid, began, simulation%clock%time, packer%particle)
            fed(n)%store = inflow%store
            allocate (fed(n)%rows(0, 0))
            if (size(packer%particle) == 0) cycle
            allocate (fed(n)%position(size(packer%particle), 3))
            do row = 1, size(packer%particle)
               p = packer%particle(row)
               call simulation%materials(inflow%store)%draw_strength(inflow%pattern%state, &
                  inflow%pattern%identity, p, p)
               call simulation%balance%ledger%record_particle(inflow%pattern, &
                  simulation%materials(inflow%store), p, [lost_mass, lost_momentum, lost_energy, &
                  lost_angular], enters=.true.)
               fed(n)%position(row, :) = inflow%pattern%position(p, :)
            end do
            allocate (packer%rows(inflow%pattern%words(), size(packer%particle)))
            packer%word = 0
            call inflow%pattern%walk(packer)
            call move_alloc(packer%rows, fed(n)%rows)
         end associate
      end do
   end subroutine feed_particles

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
