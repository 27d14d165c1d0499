! SPDX-License-Identifier: BSD-3-Clause
!> Selects the particles of an output: by body, region, distance from a plane, or every n-th. The
!! selection uses identity, state and position only, so that it does not depend on ranks.
module sample_pick
   use base_kinds, only: int64, wp
   use sample_order, only: tile_order
   use particle_shape, only: shape_holder_t
   use particle_store, only: store_t
   implicit none
   private

   public :: pick_rule_t

   !> Criteria of a selection; by default all particles are selected.
   type :: pick_rule_t
      integer :: stride = 1                              !! Every n-th particle, by identity
      integer(int64), allocatable :: bodies(:)           !! These bodies only, if allocated
      type(shape_holder_t), allocatable :: region        !! Inside this region only, if allocated
      integer :: axis = 0                                !! Normal of a plane, 0 = no plane
      real(wp) :: lower = 0.0_wp                         !! Lower bound of the layer around it [m]
      real(wp) :: upper = 0.0_wp                         !! Upper bound of the layer, exclusive [m]
      logical :: intact = .false.                        !! Only particles that have not failed
   contains
      procedure :: pick => rule_pick                     !! Indices of the selected particles
      procedure :: takes => rule_takes                   !! Is a particle selected?
      procedure :: takes_all => rule_takes_all           !! Are all particles selected?
   end type pick_rule_t

contains

   !> Indices of the selected particles of a store, tile after tile.
   pure subroutine rule_pick(self, store, order)
      class(pick_rule_t), intent(in) :: self
      type(store_t), intent(in) :: store
      integer, allocatable, intent(out) :: order(:)      !! Indices
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

   !> True if there is no criterion.
   pure logical function rule_takes_all(self) result(all_of_them)
      class(pick_rule_t), intent(in) :: self

      all_of_them = self%stride <= 1 .and. .not. allocated(self%bodies) .and. self%axis == 0 &
         .and. .not. allocated(self%region) .and. .not. self%intact
   end function rule_takes_all

   !> True if a particle is selected.
   pure logical function rule_takes(self, store, p) result(taken)
      class(pick_rule_t), intent(in) :: self
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
end module sample_pick
