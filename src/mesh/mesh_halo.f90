! SPDX-License-Identifier: BSD-3-Clause
!> Patches of tiles at the borders of ranks, sent to the ranks that touch them.
!!
!! A rank that has the patches of all tiles around its own can compute all nodes that its particles
!! need, so one exchange per transfer is enough, and partial sums are never sent. The lists of
!! messages are computed once for as long as tiles and cuts stay as they are; each neighbouring rank
!! receives one message per exchange. Tiles that no other rank uses are computed during the
!! exchange.
module mesh_halo
   use base_communicator, only: communicator_t, posted_t
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use mesh_grid, only: grid_t
   use mesh_node_boxes, only: node_boxes_t
   use mesh_packed_patch, only: packed_patch_t
   use mesh_patch, only: ensure_patch, ensure_weights, extent_of
   use mesh_tiles, only: neighbors, tiles_t
   implicit none
   private

   public :: exchange_patches, halo_t

   !> Which tiles go to which ranks.
   type :: halo_t
      integer, allocatable :: edge(:)                !! Own tiles that other ranks may need
      integer, allocatable :: inner(:)               !! Tiles that no other rank needs
      integer, allocatable :: rank(:)                !! Ranks around
      integer, allocatable :: before(:)              !! (rank around + 1) Entries before it
      integer, allocatable :: tile(:)                !! Own tiles to send, grouped by rank
      integer(int64) :: messages = 0                 !! Messages sent so far
      integer(int64) :: words = 0                    !! Words of 8 bytes in the messages
      integer(int64), private :: version = -1        !! Version of the tiles in these lists
      type(posted_t), private :: posted              !! Messages in transit
      integer(int64), allocatable, private :: incoming(:) !! Received data
   contains
      procedure :: plan => halo_plan                 !! Build the lists of messages
      procedure :: post => halo_post                 !! Send
      procedure :: complete => halo_complete         !! Receive
      procedure :: post_packed => halo_post_packed   !! Send packed patches
      procedure :: complete_packed => halo_complete_packed !! Receive them
   end type halo_t

contains

   !> Send the patches of border tiles, and store received ones as ghosts of this rank.
   subroutine exchange_patches(communicator, grid, tiles, halo, patch)
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles          !! Gets ghosts
      type(halo_t), intent(inout) :: halo            !! Lists of messages; updated
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)

      call halo%plan(communicator, grid, tiles)
      call halo%post(communicator, tiles, patch)
      call halo%complete(communicator, grid, tiles, patch)
   end subroutine exchange_patches

   !> Rebuild the lists of messages, if tiles or cuts have changed.
   subroutine halo_plan(self, communicator, grid, tiles)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer :: ranks(neighbors, tiles%own), number(tiles%own), tile

      if (self%version == tiles%version) return
      self%version = tiles%version
      number = 0
      if (communicator%size > 1) then
         !$omp parallel do default(none) shared(communicator, grid, tiles, ranks, number) &
         !$omp private(tile) schedule(static)
         do tile = 1, tiles%own
            call ranks_around(communicator, grid, tiles, tile, ranks(:, tile), number(tile))
         end do
         !$omp end parallel do
      end if
      self%edge = pack([(tile, tile=1, tiles%own)], number > 0)
      self%inner = pack([(tile, tile=1, tiles%own)], number == 0)
      call group_by_rank(self, ranks, number)
   end subroutine halo_plan

   !> Group the pairs of tile and rank by rank; tiles of a rank ascend.
   subroutine group_by_rank(self, ranks, number)
      type(halo_t), intent(inout) :: self            !! Gets the groups
      integer, intent(in) :: ranks(:, :)             !! (entry, tile) Ranks that need a tile
      integer, intent(in) :: number(:)               !! (tile) Entries
      integer(int64), allocatable :: to(:)
      integer, allocatable :: from(:), order(:)
      integer :: tile, entry, pairs, groups

      allocate (to(sum(number)), from(sum(number)))
      pairs = 0
      do tile = 1, size(number)
         do entry = 1, number(tile)
            pairs = pairs + 1
            to(pairs) = ranks(entry, tile)
            from(pairs) = tile
         end do
      end do
      order = sort_order(to)
      self%tile = from(order)
      to = to(order)
      groups = 0
      do entry = 1, pairs
         if (starts(to, entry)) groups = groups + 1
      end do
      if (allocated(self%rank)) deallocate (self%rank, self%before)
      allocate (self%rank(groups), self%before(groups + 1))
      groups = 0
      do entry = 1, pairs
         if (.not. starts(to, entry)) cycle
         groups = groups + 1
         self%rank(groups) = int(to(entry))
         self%before(groups) = entry - 1
      end do
      self%before(groups + 1) = pairs
   end subroutine group_by_rank

   !> True where the value in a sorted list differs from the one before it.
   pure logical function starts(list, entry) result(first)
      integer(int64), intent(in) :: list(:)          !! Sorted
      integer, intent(in) :: entry                   !! Index in the list

      first = entry == 1
      if (.not. first) first = list(entry) /= list(entry - 1)
   end function starts

   !> Other ranks that own a neighbour of a tile, each once. A neighbour on this rank needs no
   !! search.
   pure subroutine ranks_around(communicator, grid, tiles, tile, ranks, number)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer, intent(in) :: tile                    !! Tile in the centre
      integer, intent(out) :: ranks(neighbors)       !! Without this rank
      integer, intent(out) :: number                 !! Number
      integer :: place, rank, other
      integer(int64) :: key

      ranks = 0
      number = 0
      do place = 1, neighbors
         other = tiles%neighbor(place, tile)
         if (other > 0 .and. other <= tiles%own) then
            ! after new cuts some own tiles belong to others already
            key = tiles%key(other)
         else
            key = tiles%around(grid, tile, place)
            if (key < 0) cycle
         end if
         if (key >= tiles%border(communicator%rank) .and. &
            key < tiles%border(communicator%rank + 1)) cycle
         rank = tiles%owner(key)
         if (any(ranks(:number) == rank)) cycle
         number = number + 1
         ranks(number) = rank
      end do
   end subroutine ranks_around

   !> Send key and patch of each border tile once to every rank that needs it.
   subroutine halo_post(self, communicator, tiles, patch)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(tiles_t), intent(in) :: tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (component, node, tile)
      integer :: entry, words, at

      if (communicator%size == 1) return
      words = 1 + size(patch, 1)*size(patch, 2)
      call ensure_outgoing(self, words*size(self%tile))
      do entry = 1, size(self%tile)
         at = (entry - 1)*words
         self%posted%outgoing(at + 1) = tiles%key(self%tile(entry))
         call as_words(words - 1, patch(:, :, self%tile(entry)), self%posted%outgoing(at + 2))
      end do
      call send_words(self, communicator, words)
   end subroutine halo_post

   !> Reserve memory for words to be sent.
   pure subroutine ensure_outgoing(self, words)
      type(halo_t), intent(inout) :: self            !! Gets the memory
      integer, intent(in) :: words                   !! Number of words

      if (allocated(self%posted%outgoing)) then
         if (size(self%posted%outgoing) < words) deallocate (self%posted%outgoing)
      end if
      if (.not. allocated(self%posted%outgoing)) allocate (self%posted%outgoing(words))
   end subroutine ensure_outgoing

   !> Send the words of all entries to their ranks.
   subroutine send_words(self, communicator, words)
      type(halo_t), intent(inout) :: self            !! The plan, with the words
      type(communicator_t), intent(inout) :: communicator
      integer, intent(in) :: words                   !! Number of words of an entry

      associate (length => words*(self%before(2:) - self%before(:size(self%rank))))
         call communicator%post(self%rank, length, self%posted)
      end associate
      self%messages = self%messages + size(self%rank)
      self%words = self%words + int(words, int64)*size(self%tile)
   end subroutine send_words

   !> Send key, packed patches and values of the cells of each border tile once to every rank that
   !! needs it. Patches are sent whole, because the boxes of tiles at a border change from step to
   !! step and the length of a message must not.
   subroutine halo_post_packed(self, communicator, grid, tiles, boxes, packed, cells)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes             !! Bounding boxes
      type(packed_patch_t), intent(in) :: packed(:)        !! Packed patches to send
      real(wp), allocatable, intent(in) :: cells(:, :)     !! (cell, tile) If there are any
      real(wp), allocatable :: patch(:, :)
      integer :: entry, words, at, n

      if (communicator%size == 1) return
      words = 1 + sum(packed%rows)*grid%tile_nodes
      if (allocated(cells)) words = words + size(cells, 1)
      call ensure_outgoing(self, words*size(self%tile))
      do n = 1, size(packed)
         allocate (patch(packed(n)%rows, grid%tile_nodes))
         do entry = 1, size(self%tile)
            at = (entry - 1)*words
            self%posted%outgoing(at + 1) = tiles%key(self%tile(entry))
            call packed(n)%get(grid, boxes, self%tile(entry), patch)
            call as_words(size(patch), patch, self%posted%outgoing(at + 2 &
               + sum(packed(:n - 1)%rows)*grid%tile_nodes))
         end do
         deallocate (patch)
      end do
      if (allocated(cells)) then
         do entry = 1, size(self%tile)
            call as_words(size(cells, 1), cells(:, self%tile(entry)), &
               self%posted%outgoing(entry*words - size(cells, 1) + 1))
         end do
      end if
      call send_words(self, communicator, words)
   end subroutine halo_post_packed

   !> Receive packed patches, and store their tiles as ghosts after the own tiles.
   subroutine halo_complete_packed(self, communicator, grid, tiles, boxes, packed, cells)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles          !! Gets the ghosts
      type(node_boxes_t), intent(inout) :: boxes          !! Get those of the ghosts, whole tiles
      type(packed_patch_t), intent(inout) :: packed(:)     !! Get those of the ghosts
      real(wp), allocatable, intent(inout) :: cells(:, :)  !! (cell, tile) Get those of the ghosts
      real(wp), allocatable :: patch(:, :)
      integer :: words, length, message, at, n, tile, margin(3)

      if (communicator%size == 1) return
      call communicator%complete(self%posted, self%incoming, length)
      words = 1 + sum(packed%rows)*grid%tile_nodes
      if (allocated(cells)) words = words + size(cells, 1)
      call set_ghosts(grid, tiles, self%incoming(1:length:words))
      call boxes%ensure(tiles%all)
      margin = merge(grid%margin, 0, grid%active)
      do tile = tiles%own + 1, tiles%all
         boxes%box(:, 1, tile) = -margin
         boxes%box(:, 2, tile) = extent_of(grid, tiles, tile) + margin
      end do
      call boxes%line_up(grid, tiles)
      do n = 1, size(packed)
         call packed(n)%grow(boxes%nodes())
         allocate (patch(packed(n)%rows, grid%tile_nodes))
         do message = 1, length/words
            at = (message - 1)*words
            call as_numbers(size(patch), self%incoming(at + 2 &
               + sum(packed(:n - 1)%rows)*grid%tile_nodes), patch)
            call packed(n)%put(grid, boxes, tiles%table%find(self%incoming(at + 1)), 1, patch)
         end do
         deallocate (patch)
      end do
      if (.not. allocated(cells)) return
      if (size(cells, 2) < tiles%all) then
         patch = cells(:, :tiles%own)
         call ensure_weights(cells, size(patch, 1), tiles%all)
         cells(:, :tiles%own) = patch
      end if
      do message = 1, length/words
         at = message*words - size(cells, 1)
         call as_numbers(size(cells, 1), self%incoming(at + 1), &
            cells(:, tiles%table%find(self%incoming((message - 1)*words + 1))))
      end do
   end subroutine halo_complete_packed

   !> Copy numbers to words of the same bits.
   pure subroutine as_words(number, values, words)
      integer, intent(in) :: number                  !! Their number
      real(wp), intent(in) :: values(number)         !! Numbers
      integer(int64), intent(inout) :: words(number) !! Words
      integer :: n

      do n = 1, number
         words(n) = transfer(values(n), words(n))
      end do
   end subroutine as_words

   !> Copy words to numbers of the same bits.
   pure subroutine as_numbers(number, words, values)
      integer, intent(in) :: number                  !! Their number
      integer(int64), intent(in) :: words(number)    !! Words
      real(wp), intent(inout) :: values(number)      !! Numbers
      integer :: n

      do n = 1, number
         values(n) = transfer(words(n), values(n))
      end do
   end subroutine as_numbers

   !> Receive patches, and store their tiles as ghosts after the own tiles.
   subroutine halo_complete(self, communicator, grid, tiles, patch)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles          !! Gets the ghosts
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      real(wp), allocatable :: larger(:, :, :)
      integer :: words, length, message, at

      if (communicator%size == 1) return
      call communicator%complete(self%posted, self%incoming, length)
      words = 1 + size(patch, 1)*size(patch, 2)
      call set_ghosts(grid, tiles, self%incoming(1:length:words))
      if (size(patch, 3) < tiles%all) then
         call ensure_patch(larger, size(patch, 1), size(patch, 2), tiles%all)
         larger(:, :, :tiles%own) = patch(:, :, :tiles%own)
         call move_alloc(larger, patch)
      end if
      do message = 1, length/words
         at = (message - 1)*words
         call as_numbers(words - 1, self%incoming(at + 2), &
            patch(:, :, tiles%table%find(self%incoming(at + 1))))
      end do
   end subroutine halo_complete

   !> Make the tiles of these keys the ghosts, if they are not already.
   subroutine set_ghosts(grid, tiles, key)
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles          !! Gets the ghosts
      integer(int64), intent(in) :: key(:)           !! In the order of arrival
      integer(int64), allocatable :: own(:)
      integer(int64) :: ghost(size(key))

      ghost = key(sort_order(key))
      if (size(ghost) == tiles%all - tiles%own) then
         if (all(ghost == tiles%key(tiles%own + 1:tiles%all))) return
      end if
      own = tiles%key(:tiles%own)
      call tiles%set(grid, own, ghost)
   end subroutine set_ghosts
end module mesh_halo
