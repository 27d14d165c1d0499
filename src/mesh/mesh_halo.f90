! SPDX-License-Identifier: BSD-3-Clause
!> Patches of tiles at the borders of ranks, sent to the ranks that touch them.
!!
!! A rank that has the patches of all tiles around its own can do all the work on the nodes that
!! its particles see, so one exchange a transfer is enough, and no partial sum ever travels.
module mesh_halo
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use mesh_grid, only: grid_t
   use mesh_patch, only: ensure_patch
   use mesh_tiles, only: neighbors, tiles_t
   implicit none
   private

   public :: exchange_patches

contains

   !> Send the patches of border tiles and make those that arrive ghosts of this rank.
   subroutine exchange_patches(communicator, grid, tiles, patch)
      type(communicator_t), intent(inout) :: communicator !! The ranks
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(inout) :: tiles          !! Gets ghosts
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      integer(int64), allocatable :: outgoing(:), incoming(:)
      integer, allocatable :: destination(:), length(:)
      integer :: words

      if (communicator%size == 1) return
      words = 1 + size(patch, 1)*size(patch, 2)
      call pack_patches(communicator, grid, tiles, patch, destination, length, outgoing)
      call communicator%exchange(destination, length, outgoing, incoming)
      call unpack_patches(grid, tiles, words, incoming, patch)
   end subroutine exchange_patches

   !> Write key and patch of each border tile once for every rank that touches it.
   subroutine pack_patches(communicator, grid, tiles, patch, destination, length, outgoing)
      type(communicator_t), intent(in) :: communicator !! The ranks
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (component, node, tile)
      integer, allocatable, intent(out) :: destination(:)      !! Ranks
      integer, allocatable, intent(out) :: length(:)           !! Words for each
      integer(int64), allocatable, intent(out) :: outgoing(:)  !! Messages
      integer, allocatable :: to(:), from(:), ranks(:)
      integer :: tile, pairs, words, rank, pair, at

      allocate (to(neighbors*tiles%own), from(neighbors*tiles%own))
      pairs = 0
      do tile = 1, tiles%own
         call ranks_around(communicator, grid, tiles, tile, ranks)
         to(pairs + 1:pairs + size(ranks)) = ranks
         from(pairs + 1:pairs + size(ranks)) = tile
         pairs = pairs + size(ranks)
      end do
      words = 1 + size(patch, 1)*size(patch, 2)
      allocate (outgoing(int(pairs, int64)*words), destination(0), length(0))
      at = 0
      do rank = 0, communicator%size - 1
         if (.not. any(to(:pairs) == rank)) cycle
         destination = [destination, rank]
         length = [length, words*count(to(:pairs) == rank)]
         do pair = 1, pairs
            if (to(pair) /= rank) cycle
            outgoing(at + 1) = tiles%key(from(pair))
            outgoing(at + 2:at + words) = transfer(patch(:, :, from(pair)), outgoing, words - 1)
            at = at + words
         end do
      end do
   end subroutine pack_patches

   !> Other ranks that own a place around a tile, each once.
   pure subroutine ranks_around(communicator, grid, tiles, tile, ranks)
      type(communicator_t), intent(in) :: communicator !! The ranks
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(in) :: tiles             !! The tiles
      integer, intent(in) :: tile                    !! Whose surroundings
      integer, allocatable, intent(out) :: ranks(:)  !! Without this rank
      integer :: place, rank, found(neighbors), number
      integer(int64) :: key

      number = 0
      do place = 1, neighbors
         key = tiles%around(grid, tile, place)
         if (key < 0) cycle
         rank = tiles%owner(key)
         if (rank == communicator%rank) cycle
         if (any(found(:number) == rank)) cycle
         number = number + 1
         found(number) = rank
      end do
      ranks = found(:number)
   end subroutine ranks_around

   !> Make the tiles that arrived ghosts and put their patches behind the own ones.
   subroutine unpack_patches(grid, tiles, words, incoming, patch)
      type(grid_t), intent(in) :: grid               !! The grid
      type(tiles_t), intent(inout) :: tiles          !! Gets the ghosts
      integer, intent(in) :: words                   !! Words of one tile in a message
      integer(int64), contiguous, intent(in) :: incoming(:) !! What arrived
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      integer(int64), allocatable :: ghost(:), own(:)
      real(wp), allocatable :: larger(:, :, :)
      integer, allocatable :: order(:)
      integer :: number, message, tile

      number = size(incoming)/words
      allocate (ghost(number))
      do message = 1, number
         ghost(message) = incoming((message - 1)*words + 1)
      end do
      order = sort_order(ghost)
      ghost = ghost(order)
      if (.not. same(ghost, tiles%key(tiles%own + 1:tiles%all))) then
         own = tiles%key(:tiles%own)
         call tiles%set(grid, own, ghost)
      end if
      if (size(patch, 3) < tiles%all) then
         call ensure_patch(larger, size(patch, 1), size(patch, 2), tiles%all)
         larger(:, :, :tiles%own) = patch(:, :, :tiles%own)
         call move_alloc(larger, patch)
      end if
      do message = 1, number
         associate (at => (message - 1)*words)
            tile = tiles%table%find(incoming(at + 1))
            patch(:, :, tile) = reshape(transfer(incoming(at + 2:at + words), patch), &
               [size(patch, 1), size(patch, 2)])
         end associate
      end do
   end subroutine unpack_patches

   !> True if two lists of keys are equal.
   pure logical function same(one, other) result(equal)
      integer(int64), intent(in) :: one(:)           !! Keys
      integer(int64), intent(in) :: other(:)         !! Keys

      equal = size(one) == size(other)
      if (equal) equal = all(one == other)
   end function same
end module mesh_halo
