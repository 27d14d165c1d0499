! SPDX-License-Identifier: BSD-3-Clause
!> Sorts particles after they have moved: long particles are split, those of inflows enter, and all
!! move to their tiles and ranks.
module step_sort_particles
   use base_kinds, only: int64, wp
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use particle_inflow, only: fed_t
   use particle_migrate, only: migrate
   use particle_sort_tile, only: row_packer_t
   use particle_split, only: split_store
   use particle_store, only: store_t
   use step_ledger, only: dissipated, ledger_t, lost_angular, lost_energy, lost_mass, lost_momentum
   use step_normalised_sums, only: find_full
   use step_simulation, only: clock_t, machine_t, scheme_t, simulation_effects_t, simulation_t, &
      space_t, velocity_field_t
   implicit none
   private

   public :: count_particles, sort_particles, split_particles

contains

   !> Halve the particles that have become long.
   subroutine split_particles(simulation)
      type(simulation_t), intent(inout) :: simulation
      integer :: n

      associate (machine => simulation%machine)
         call machine%timer%start(machine%phase%sort)
         do n = 1, size(simulation%fields)
            call split_field(simulation%space, simulation%stores, simulation%scheme, &
               simulation%clock, simulation%balance%ledger, machine, simulation%fields(n))
         end do
         call machine%timer%stop(machine%phase%sort)
      end associate
   end subroutine split_particles

   !> One velocity field.
   subroutine split_field(space, stores, scheme, clock, ledger, machine, field)
      type(space_t), intent(in) :: space
      type(store_t), intent(inout) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(clock_t), intent(inout) :: clock
      type(ledger_t), intent(inout) :: ledger
      type(machine_t), intent(inout) :: machine
      type(velocity_field_t), intent(in) :: field
      real(wp), allocatable :: gain(:)
      logical, allocatable :: full(:, :)
      integer :: index, n

      do index = field%first_store, field%last_store
         if (.not. allocated(stores(index)%opening)) cycle
         call find_full(space, scheme, machine, field%nodes%sums, index, full)
         call split_store(scheme%method%splitting, full, space%grid, space%boundary, space%tiles, &
            stores(index), gain)
         clock%halved = clock%halved + size(gain)
         do n = 1, size(gain)
            call ledger%sums(dissipated)%add(-gain(n))
         end do
      end do
   end subroutine split_field

   !> Record particles that left the domain, and sort the others into their tiles. Those that left
   !! their tiles may be on the way already (`agree_with_ranks`). Collective.
   subroutine sort_particles(simulation, began)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in), optional :: began        !! Begin of the step, in which inflows feed [s]
      type(fed_t), allocatable :: fed(:)
      real(wp) :: waited

      associate (machine => simulation%machine, effects => simulation%effects)
         waited = machine%communicator%traffic%waiting
         call machine%timer%start(machine%phase%sort)
         call simulation%balance%ledger%record_lost(simulation%stores, simulation%materials)
         ! an array that is not allocated is an absent argument
         if (present(began) .and. allocated(effects%inflows)) &
            call feed_particles(simulation%space%grid, simulation%materials, effects, &
            simulation%clock, simulation%balance%ledger, began, fed)
         call migrate(machine%communicator, simulation%space%grid, simulation%space%boundary, &
            simulation%space%tiles, simulation%stores, simulation%space%halo%links, &
            simulation%leavers, fed)
         call machine%timer%stop(machine%phase%sort)
         if (machine%communicator%size > 1) call machine%timer%move(machine%phase%sort, &
            machine%phase%wait, machine%communicator%traffic%waiting - waited)
      end associate
   end subroutine sort_particles

   !> The particles that enter by inflows in a step. The ledger records them as negative losses.
   subroutine feed_particles(grid, materials, effects, clock, ledger, began, fed)
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: materials(:)
      type(simulation_effects_t), intent(inout) :: effects
      type(clock_t), intent(in) :: clock
      type(ledger_t), intent(inout) :: ledger
      real(wp), intent(in) :: began                  !! Begin of the step [s]
      type(fed_t), allocatable, intent(out) :: fed(:) !! (inflow)
      type(row_packer_t) :: packer
      real(wp) :: low(3), high(3)
      integer :: n, row, p

      allocate (fed(size(effects%inflows)))
      do n = 1, size(fed)
         associate (inflow => effects%inflows(n))
            call inflow%enter(grid, began, clock%time, packer%particle)
            fed(n)%store = inflow%store
            allocate (fed(n)%rows(0, 0))
            if (size(packer%particle) == 0) cycle
            allocate (fed(n)%position(size(packer%particle), 3))
            do row = 1, size(packer%particle)
               p = packer%particle(row)
               if (allocated(inflow%back)) then
                  call inflow%find_box(p, low, high)
                  call materials(inflow%store)%draw_strength(inflow%pattern%state, p, low, high)
               end if
               call ledger%record_particle(inflow%pattern, materials(inflow%store), p, &
                  [lost_mass, lost_momentum, lost_energy, lost_angular], enters=.true.)
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
   pure integer(int64) function count_particles(stores) result(particles)
      type(store_t), intent(in) :: stores(:)
      integer :: index

      particles = 0
      do index = 1, size(stores)
         particles = particles + stores(index)%particles()
      end do
   end function count_particles
end module step_sort_particles
