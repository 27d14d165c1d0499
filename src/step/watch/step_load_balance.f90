! SPDX-License-Identifier: BSD-3-Clause
!> Moves tiles between ranks when some rank has too much work. Results do not depend on it.
module step_load_balance
   use base_kinds, only: int64, wp
   use mesh_tiles, only: partition_distributed_keys
   use particle_store, only: moved_away, store_t
   use step_simulation, only: machine_t, simulation_t, space_t
   use step_sort_particles, only: count_particles, sort_particles
   implicit none
   private

   public :: balance_ranks, balancing_t, watch_costs

   integer(int64), parameter :: measured_steps = 4   !! Before loads are compared

   !> Conditions for moving tiles between ranks. By default tiles do not move.
   type :: balancing_t
      logical :: allowed = .false.                   !! True if tiles may move
      integer(int64) :: every = 1                    !! Steps between two comparisons
      real(wp) :: tolerance = 1.0_wp                 !! Accepted greatest over mean work [1]
   end type balancing_t

contains

   !> Switch on the measurement of work on tiles in the few steps before loads are compared.
   subroutine watch_costs(simulation, balancing)
      type(simulation_t), intent(inout) :: simulation
      type(balancing_t), intent(in) :: balancing     !! When
      real(wp), allocatable :: cost(:)

      if (simulation%machine%communicator%size == 1 .or. .not. balancing%allowed) return
      if (modulo(-simulation%clock%step - 1, balancing%every) >= measured_steps) return
      if (allocated(simulation%machine%cost)) then
         call carry_costs(simulation%space, simulation%machine, cost)
      else
         allocate (cost(simulation%space%tiles%own))
         cost = 0.0_wp
      end if
      call move_alloc(cost, simulation%machine%cost)
      simulation%machine%cost_key = simulation%space%tiles%key(:simulation%space%tiles%own)
   end subroutine watch_costs

   !> The measured work, for the present tiles; both lists of tiles ascend. New tiles have none.
   pure subroutine carry_costs(space, machine, cost)
      type(space_t), intent(in) :: space
      type(machine_t), intent(in) :: machine
      real(wp), allocatable, intent(out) :: cost(:)  !! (own tile) [s]
      integer :: tile, old

      allocate (cost(space%tiles%own))
      cost = 0.0_wp
      old = 1
      do tile = 1, space%tiles%own
         do while (old <= size(machine%cost))
            if (machine%cost_key(old) >= space%tiles%key(tile)) exit
            old = old + 1
         end do
         if (old > size(machine%cost)) return
         if (machine%cost_key(old) == space%tiles%key(tile)) &
            cost(tile) = machine%cost(old)
      end do
   end subroutine carry_costs

   !> Compare the work of the ranks in a step that was measured, and partition the Hilbert curve
   !! again if it differs too much.
   subroutine balance_ranks(simulation, balancing)
      type(simulation_t), intent(inout) :: simulation !! Particles in order
      type(balancing_t), intent(in) :: balancing     !! When
      integer(int64), allocatable :: weight(:), border(:)
      integer(int64) :: total(1)
      real(wp) :: ratio
      integer :: tile, index

      if (.not. allocated(simulation%machine%cost)) return
      if (mod(simulation%clock%step, balancing%every) /= 0) return
      call weigh_tiles(simulation, weight)
      deallocate (simulation%machine%cost, simulation%machine%cost_key)
      total = sum(weight)
      ratio = simulation%machine%communicator%maximum(real(total(1), wp))
      call simulation%machine%communicator%total(total)
      ratio = ratio*real(simulation%machine%communicator%size, wp)/real(max(total(1), 1_int64), wp)
      call simulation%machine%load%record(simulation%clock%step, ratio)
      if (ratio <= balancing%tolerance) return
      call simulation%machine%timer%start(simulation%machine%phase%sort)
      associate (tiles => simulation%space%tiles, rank => simulation%machine%communicator%rank)
         call partition_distributed_keys(simulation%machine%communicator, tiles%key(:tiles%own), &
            weight, &
            border)
         call tiles%cut(border)
         do tile = 1, tiles%own
            if (tiles%owner(tiles%key(tile)) == rank) cycle
            simulation%machine%load%sent = simulation%machine%load%sent + 1
            do index = 1, size(simulation%stores)
               call send_tile(simulation%stores(index), tile)
            end do
         end do
      end associate
      call simulation%machine%timer%stop(simulation%machine%phase%sort)
      simulation%machine%load%cuts = simulation%machine%load%cuts + 1
      call sort_particles(simulation)
   end subroutine balance_ranks

   !> Work of each tile in nanoseconds. Tiles created since the measurement get the mean work per
   !! particle.
   subroutine weigh_tiles(simulation, weight)
      type(simulation_t), intent(in) :: simulation   !! Measured
      integer(int64), allocatable, intent(out) :: weight(:) !! (own tile) [ns], 1 or more
      real(wp), parameter :: nano = 1.0e-9_wp
      real(wp), allocatable :: cost(:)
      real(wp) :: each
      integer(int64) :: particles
      integer :: tile, index

      call carry_costs(simulation%space, simulation%machine, cost)
      each = sum(cost)/real(max(count_particles(simulation), 1_int64), wp)
      allocate (weight(size(cost)))
      do tile = 1, size(cost)
         if (.not. cost(tile) > 0.0_wp) then
            particles = 0
            do index = 1, size(simulation%stores)
               particles = particles + simulation%stores(index)%count(tile)
            end do
            cost(tile) = each*real(particles, wp)
         end if
         weight(tile) = max(nint(cost(tile)/nano, int64), 1_int64)
      end do
   end subroutine weigh_tiles

   !> Mark all particles of a tile for migration to their new rank.
   pure subroutine send_tile(store, tile)
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      integer :: p

      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         store%home(p) = moved_away
      end do
      store%leaving(tile) = store%count(tile)
      store%unsorted(tile) = .true.
   end subroutine send_tile
end module step_load_balance
