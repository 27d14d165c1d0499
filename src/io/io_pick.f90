! SPDX-License-Identifier: BSD-3-Clause
!> Which particles an output takes: those of some bodies, in a region, near a plane, or every so
!! many. The choice goes by what a particle is and where it is, so that it does not depend on ranks.
module io_pick
   use base_kinds, only: int64, wp
   use io_order, only: tile_order
   use particle_shape, only: shape_holder_t
   use particle_store, only: store_t
   implicit none
   private

   public :: pick_rule_t

   !> What is asked of a particle. Without a word all are taken.
   type :: pick_rule_t
      integer :: stride = 1                              !! Only every so many identities
      integer(int64), allocatable :: bodies(:)           !! Only these, if allocated
      type(shape_holder_t), allocatable :: region        !! Only what lies in it, if allocated
      integer :: axis = 0                                !! Normal of a plane, 0 = there is none
      real(wp) :: lower = 0.0_wp                         !! Begin of what counts as on it [m]
      real(wp) :: upper = 0.0_wp                         !! End of it, itself outside [m]
      logical :: intact = .false.                        !! Only what has not failed
   contains
      procedure :: pick => rule_pick                     !! Places of the particles it takes
      procedure, private :: takes => rule_takes          !! Is a particle taken?
      procedure, private :: takes_all => rule_takes_all  !! Is nothing asked?
   end type pick_rule_t

contains

   !> Places of the particles of a store that are taken, tile after tile.
   pure subroutine rule_pick(self, store, order)
      class(pick_rule_t), intent(in) :: self             !! What is wanted
      type(store_t), intent(in) :: store
      integer, allocatable, intent(out) :: order(:)      !! Their places
      integer, allocatable :: shorter(:)
      integer :: kept, row

      call tile_order(store, order)
      if (self%takes_all()) return
      kept = 0
      do row = 1, size(order)
         if (.not. self%takes(store, order(row))) cycle
         kept = kept + 1
         order(kept) = order(row)
      end do
      allocate (shorter(kept))
      shorter(:) = order(:kept)
      call move_alloc(shorter, order)
   end subroutine rule_pick

   !> True if nothing is asked.
   pure logical function rule_takes_all(self) result(all_of_them)
      class(pick_rule_t), intent(in) :: self             !! What is wanted

      all_of_them = self%stride <= 1 .and. .not. allocated(self%bodies) .and. self%axis == 0 &
         .and. .not. allocated(self%region) .and. .not. self%intact
   end function rule_takes_all

   !> True if a particle is taken.
   pure logical function rule_takes(self, store, p) result(taken)
      class(pick_rule_t), intent(in) :: self             !! What is wanted
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp) :: position(3)

      taken = mod(store%identity(p), int(max(self%stride, 1), int64)) == 0_int64
      if (.not. taken) return
      if (allocated(self%bodies) .and. allocated(store%body)) &
         taken = any(self%bodies == store%body(p))
      if (self%intact .and. allocated(store%state%failed)) &
         taken = taken .and. store%state%failed(p) == 0_int64
      position = [store%position(p, 1), store%position(p, 2), store%position(p, 3)]
      if (self%axis > 0) taken = taken .and. position(self%axis) >= self%lower .and. &
         position(self%axis) < self%upper
      if (allocated(self%region) .and. taken) taken = self%region%contains(position)
   end function rule_takes
end module io_pick
