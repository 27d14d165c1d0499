! SPDX-License-Identifier: BSD-3-Clause
!> Moves tiles between ranks when some rank has too much work. Results do not depend on it.
module step_load_balance
   use base_kinds, only: int64, wp
   use mesh_tiles, only: partition_distributed_keys, tiles_t
   use particle_store, only: moved_away, store_t
   use step_simulation, only: clock_t, machine_t, simulation_t
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
   subroutine watch_costs(tiles, clock, machine, balancing)
      type(tiles_t), intent(in) :: tiles
      type(clock_t), intent(in) :: clock
      type(machine_t), intent(inout) :: machine
      type(balancing_t), intent(in) :: balancing     !! When
      real(wp), allocatable :: cost(:)

      if (machine%communicator%size == 1 .or. .not. balancing%allowed) return
      if (modulo(-clock%step - 1, balancing%every) >= measured_steps) return
      if (allocated(machine%cost)) then
         call carry_costs(tiles, machine, cost)
      else
         allocate (cost(tiles%own))
         cost = 0.0_wp
      end if
      call move_alloc(cost, machine%cost)
      machine%cost_key = tiles%key(:tiles%own)
      if (allocated(machine%cause)) deallocate (machine%cause)
   end subroutine watch_costs

   !> The measured work, for the present tiles; both lists of tiles ascend. New tiles have none.
   pure subroutine carry_costs(tiles, machine, cost)
      type(tiles_t), intent(in) :: tiles
      type(machine_t), intent(in) :: machine
      real(wp), allocatable, intent(out) :: cost(:)  !! (own tile) [s]
      integer :: tile, old

      allocate (cost(tiles%own))
      cost = 0.0_wp
      old = 1
      do tile = 1, tiles%own
         do while (old <= size(machine%cost))
            if (machine%cost_key(old) >= tiles%key(tile)) exit
            old = old + 1
         end do
         if (old > size(machine%cost)) return
         if (machine%cost_key(old) == tiles%key(tile)) cost(tile) = machine%cost(old)
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

      associate (machine => simulation%machine)
         if (.not. allocated(machine%cost)) return
         if (mod(simulation%clock%step, balancing%every) /= 0) return
         call weigh_tiles(simulation%space%tiles, simulation%stores, machine, weight)
         deallocate (machine%cost, machine%cost_key)
         total = sum(weight)
         ratio = machine%communicator%maximum(real(total(1), wp))
         call machine%communicator%total(total)
         ratio = ratio*real(machine%communicator%size, wp)/real(max(total(1), 1_int64), wp)
         call machine%load%record(simulation%clock%step, ratio)
         if (ratio <= balancing%tolerance) return
         call machine%timer%start(machine%phase%sort)
         associate (tiles => simulation%space%tiles, rank => machine%communicator%rank)
            call partition_distributed_keys(machine%communicator, tiles%key(:tiles%own), &
               weight, border)
            call tiles%cut(border)
            call simulation%space%halo%links%forget()
            do tile = 1, tiles%own
               if (tiles%owner(tiles%key(tile)) == rank) cycle
               machine%load%sent = machine%load%sent + 1
               do index = 1, size(simulation%stores)
                  call send_tile(simulation%stores(index), tile)
               end do
            end do
         end associate
         call machine%timer%stop(machine%phase%sort)
         machine%load%cuts = machine%load%cuts + 1
         call sort_particles(simulation)
      end associate
   end subroutine balance_ranks

   !> Work of each tile in nanoseconds. Tiles created since the measurement get the mean work per
   !! particle.
   subroutine weigh_tiles(tiles, stores, machine, weight)
      type(tiles_t), intent(in) :: tiles
      type(store_t), intent(in) :: stores(:)
      type(machine_t), intent(in) :: machine
      integer(int64), allocatable, intent(out) :: weight(:) !! (own tile) [ns], 1 or more
      real(wp), parameter :: nano = 1.0e-9_wp
      real(wp), allocatable :: cost(:)
      real(wp) :: each
      integer(int64) :: particles
      integer :: tile, index

      call carry_costs(tiles, machine, cost)
      each = sum(cost)/real(max(count_particles(stores), 1_int64), wp)
      allocate (weight(size(cost)))
      do tile = 1, size(cost)
         if (.not. cost(tile) > 0.0_wp) then
            particles = 0
            do index = 1, size(stores)
               particles = particles + stores(index)%count(tile)
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
