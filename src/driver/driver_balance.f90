! SPDX-License-Identifier: BSD-3-Clause
!> Moves tiles between ranks when some rank has too many particles. Results do not depend on it.
module driver_balance
   use base_deck, only: deck_t, group_t
   use base_kinds, only: int64, wp
   use driver_simulation, only: simulation_t
   use driver_step, only: count_particles, sort_particles
   use mesh_tiles, only: partition_keys
   use particle_store, only: moved_away, store_t
   implicit none
   private

   public :: balance_ranks, balancing_t, read_balancing

   !> When tiles move.
   type :: balancing_t
      logical :: allowed = .true.                    !! May they move at all?
      integer(int64) :: every = 200                  !! Steps between two looks
      real(wp) :: tolerance = 1.15_wp !! Greatest load over mean load that is borne [1]
   end type balancing_t

contains

   !> Read the group &parallel.
   subroutine read_balancing(deck, balancing)
      type(deck_t), intent(in) :: deck               !! The deck
      type(balancing_t), intent(out) :: balancing    !! What it says
      type(group_t) :: group
      character(len=:), allocatable :: word
      integer :: every

      group = deck%group("parallel")
      call group%get("balance", word)
      balancing%allowed = word == "auto"
      if (.not. balancing%allowed) return
      call group%get("balance_every", every)
      balancing%every = every
      call group%get("imbalance", balancing%tolerance)
   end subroutine read_balancing

   !> Cut the curve anew if it is time and the loads differ too much.
   subroutine balance_ranks(simulation, balancing)
      type(simulation_t), intent(inout) :: simulation !! The run, particles in order
      type(balancing_t), intent(in) :: balancing     !! When
      integer(int64), allocatable :: pairs(:), whole(:)
      integer(int64) :: total(1)
      real(wp) :: greatest
      integer :: tile, index, owner

      if (simulation%communicator%size == 1 .or. .not. balancing%allowed) return
      if (mod(simulation%step, balancing%every) /= 0) return
      total = count_particles(simulation)
      greatest = simulation%communicator%maximum(real(total(1), wp))
      call simulation%communicator%total(total)
      if (greatest*real(simulation%communicator%size, wp) <= &
         balancing%tolerance*real(total(1), wp)) return
      call simulation%timer%start(simulation%phase%sort)
      allocate (pairs(2*simulation%tiles%own))
      do tile = 1, simulation%tiles%own
         pairs(2*tile - 1) = simulation%tiles%key(tile)
         pairs(2*tile) = 0
         do index = 1, size(simulation%stores)
            pairs(2*tile) = pairs(2*tile) + simulation%stores(index)%count(tile)
         end do
      end do
      ! ranks own ascending pieces of the curve, so the whole list ascends too
      call simulation%communicator%gather(pairs, whole)
      call partition_keys(whole(1::2), whole(2::2), simulation%communicator%size, &
         simulation%tiles%border)
      do tile = 1, simulation%tiles%own
         owner = simulation%tiles%owner(simulation%tiles%key(tile))
         if (owner == simulation%communicator%rank) cycle
         do index = 1, size(simulation%stores)
            call send_tile(simulation%stores(index), tile)
         end do
      end do
      call simulation%timer%stop(simulation%phase%sort)
      call sort_particles(simulation)
   end subroutine balance_ranks

   !> Let all particles of a tile look for their new rank.
   pure subroutine send_tile(store, tile)
      type(store_t), intent(inout) :: store          !! The particles
      integer, intent(in) :: tile                    !! Which tile
      integer :: p

      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         store%home(p) = moved_away
      end do
      store%leaving(tile) = store%count(tile)
      store%restless(tile) = .true.
   end subroutine send_tile
end module driver_balance
