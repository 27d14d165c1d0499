! SPDX-License-Identifier: BSD-3-Clause
!> Which ranks send patches to each other while the ranks around the tiles stay as they are.
!!
!! A rank knows to whom it sends, but not from whom it receives: a rank with a tile beside it may
!! be new. An exchange that ends with a wait for all ranks finds the senders. Afterwards each rank
!! receives one message of each of them, without that wait, until some rank gets a receiver that
!! does not know it. Each rank tests before its particles arrive in other tiles whether that can
!! happen, and the ranks agree on it in a reduction that they need anyway.
module mesh_links
   use base_kinds, only: int64
   use mesh_grid, only: grid_t
   use mesh_tiles, only: neighbors, tiles_t
   implicit none
   private

   public :: links_t

   !> Receivers and senders of a rank. Receivers that are not needed any more get empty messages.
   type :: links_t
      integer, allocatable :: to(:)                  !! Ranks to which this one sends, ascending
      integer, allocatable :: from(:)                !! Ranks that send to this one
      logical :: in_use = .false.                    !! Do all ranks use them in an exchange?
      logical :: surplus = .false.                   !! Do some receivers need nothing any more?
   contains
      procedure :: record => links_record            !! Set both lists
      procedure :: trust => links_trust              !! Say whether they hold for changed tiles
      procedure :: forget => links_forget            !! Delete them
      procedure :: cover => links_cover              !! Do they suffice for a particle in a tile?
   end type links_t

contains

   !> Record the receivers and senders of an exchange in which every rank has sent to all its
   !! receivers. They are used until tiles change.
   pure subroutine links_record(self, to, from)
      class(links_t), intent(inout) :: self
      integer, intent(in) :: to(:)                   !! Receivers, ascending
      integer, intent(in) :: from(:)                 !! Senders, in any order

      self%to = to
      self%from = from
      self%surplus = .false.
      self%in_use = .true.
   end subroutine links_record

   !> Go on using the lists if they hold: tiles have changed, and no rank has got a receiver that is
   !! not recorded. All ranks must say the same. Otherwise the next exchange records them again.
   pure subroutine links_trust(self, hold)
      class(links_t), intent(inout) :: self
      logical, intent(in) :: hold                    !! Do they hold after this change of tiles?

      self%in_use = self%in_use .and. hold
   end subroutine links_trust

   !> Delete the lists, because tiles will belong to other ranks. All ranks must do so.
   pure subroutine links_forget(self)
      class(links_t), intent(inout) :: self

      if (allocated(self%to)) deallocate (self%to, self%from)
      self%in_use = .false.
   end subroutine links_forget

   !> True if a particle of this rank can arrive in a tile without any rank getting a receiver that
   !! is not recorded. This rank must have the ghosts of the last exchange: then it knows all tiles
   !! beside its own. False if it does not know.
   pure logical function links_cover(self, rank, grid, tiles, key) result(covered)
      class(links_t), intent(in) :: self
      integer, intent(in) :: rank                    !! This rank
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles             !! Before the particle arrives
      integer(int64), intent(in) :: key              !! Tile in which it arrives
      integer :: owner, place, other
      integer(int64) :: around(neighbors)

      covered = allocated(self%to)
      if (.not. covered) return
      ! the tile exists, on this rank or on another one
      if (tiles%table%find(key) > 0) return
      owner = tiles%owner(key)
      around = tiles%beside(grid, key)
      do place = 1, neighbors
         if (.not. covered) return
         if (around(place) < 0) cycle
         other = tiles%owner(around(place))
         if (other == owner) cycle
         if (owner == rank) then
            covered = any(self%to == other)
         else if (other == rank) then
            covered = any(self%from == owner)
         else
            covered = sends_to(owner, other, grid, tiles)
         end if
      end do
   end function links_cover

   !> True if another rank is known to send to a third one: it has a tile, of which this rank has a
   !! ghost, beside a position of the third one.
   pure logical function sends_to(sender, receiver, grid, tiles) result(known)
      integer, intent(in) :: sender                  !! Rank
      integer, intent(in) :: receiver                !! Another rank
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles             !! With ghosts
      integer :: tile, place
      integer(int64) :: around(neighbors)

      known = .true.
      do tile = tiles%own + 1, tiles%all
         if (tiles%owner(tiles%key(tile)) /= sender) cycle
         around = tiles%beside(grid, tiles%key(tile))
         do place = 1, neighbors
            if (around(place) < 0) cycle
            if (tiles%owner(around(place)) == receiver) return
         end do
      end do
      known = .false.
   end function sends_to
end module mesh_links
