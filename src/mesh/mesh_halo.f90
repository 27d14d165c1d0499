! SPDX-License-Identifier: BSD-3-Clause
!> Patches of tiles at the borders of ranks, sent to the ranks that touch them.
!!
!! A rank that has the patches of all tiles around its own can compute all nodes that its particles
!! need, so one exchange per transfer is enough, and partial sums are never sent. The lists of
!! messages are computed once for as long as tiles and cuts stay as they are; each neighbouring rank
!! receives one message per exchange, which it expects if `mesh_links` says so. Tiles that no other
!! rank uses are computed during the exchange.
module mesh_halo
   use, intrinsic :: iso_fortran_env, only: error_unit
   use base_communicator, only: communicator_t, posted_t
   use base_error, only: exit_internal
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use mesh_grid, only: grid_t
   use mesh_links, only: links_t
   use mesh_node_boxes, only: node_boxes_t
   use mesh_packed_patch, only: packed_patch_t
   use mesh_patch, only: clear_patch, ensure_patch, ensure_weights, extent_of
   use mesh_tiles, only: neighbors, shift_to, tiles_t
   implicit none
   private

   public :: exchange_patches, halo_t

   integer, parameter :: header = 3                  !! Words of an entry before its numbers
   integer, parameter :: bits = 20                   !! Of a position in a tile in a word
   integer, parameter :: offset = 1000               !! Added to it, because margins are below 0

   !> Which tiles go to which ranks.
   type :: halo_t
      integer, allocatable :: edge(:)                !! Own tiles that other ranks may need
      integer, allocatable :: inner(:)               !! Tiles that no other rank needs
      integer, allocatable :: rank(:)                !! Ranks around
      integer, allocatable :: before(:)              !! (rank around + 1) Entries before it
      integer, allocatable :: tile(:)                !! Own tiles to send, grouped by rank
      !> (3, lower or upper end, entry) Does its rank need the nodes up to there, however far from
      !! its own tiles?
      logical, allocatable, private :: reach(:, :, :)
      integer(int64) :: messages = 0                 !! Messages sent so far
      integer(int64) :: words = 0                    !! Words of 8 bytes in the messages
      type(links_t) :: links                         !! Ranks that expect messages of each other
      integer(int64), private :: version = -1        !! Version of the tiles in these lists
      type(posted_t), private :: posted              !! Messages in transit
      integer(int64), allocatable, private :: incoming(:) !! Received data
   contains
      procedure :: plan => halo_plan                 !! Build the lists of messages
      procedure, private :: box => halo_box          !! Nodes that the rank of an entry needs
      procedure :: post => halo_post                 !! Send
      procedure :: complete => halo_complete         !! Receive
      procedure :: post_packed => halo_post_packed   !! Send packed patches
      procedure :: complete_packed => halo_complete_packed !! Receive them
   end type halo_t

contains

   !> Send the patches of border tiles, and store received ones as ghosts of this rank.
   subroutine exchange_patches(communicator, grid, tiles, halo, patch, layers)
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles          !! Gets ghosts
      type(halo_t), intent(inout) :: halo            !! Lists of messages; updated
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      integer, intent(in) :: layers                  !! Of cells beside own tiles that are needed

      call halo%plan(communicator, grid, tiles)
      call halo%post(communicator, grid, tiles, patch, layers)
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
      call find_reach(self, grid, tiles)
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

   !> Send the patch of each border tile once to every rank that needs it, in the box of the nodes
   !! that the rank needs.
   subroutine halo_post(self, communicator, grid, tiles, patch, layers)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (component, node, tile)
      integer, intent(in) :: layers                  !! Of cells that the receivers need
      integer, allocatable :: first(:), box(:, :, :)
      integer :: entry, at, y, z, node, number

      if (communicator%size == 1) return
      call start_entries(self, grid, tiles, layers, size(patch, 1), first, box)
      !$omp parallel do default(none) shared(self, grid, patch, first, box) &
      !$omp private(entry, at, y, z, node, number) schedule(static)
      do entry = 1, size(self%tile)
         at = first(entry) + header
         number = box(1, 2, entry) - box(1, 1, entry) + 1
         do z = box(3, 1, entry), box(3, 2, entry)
            do y = box(2, 1, entry), box(2, 2, entry)
               node = node_index(grid, [box(1, 1, entry), y, z])
               call as_words(size(patch, 1)*number, &
                  patch(:, node + 1:node + number, self%tile(entry)), self%posted%outgoing(at + 1))
               at = at + size(patch, 1)*number
            end do
         end do
      end do
      !$omp end parallel do
      call send_words(self, communicator, first)
   end subroutine halo_post

   !> Nodes of a tile before one of them.
   pure integer function node_index(grid, node) result(before)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: node(3)                 !! Position, from 0; margins are below

      before = dot_product(node + merge(grid%margin, 0, grid%active), grid%stride)
   end function node_index

   !> Reserve memory for words to be sent.
   pure subroutine ensure_outgoing(self, words)
      type(halo_t), intent(inout) :: self            !! Gets the memory
      integer, intent(in) :: words                   !! Number of words

      if (allocated(self%posted%outgoing)) then
         if (size(self%posted%outgoing) < words) deallocate (self%posted%outgoing)
      end if
      if (.not. allocated(self%posted%outgoing)) allocate (self%posted%outgoing(words))
   end subroutine ensure_outgoing

   !> Send the words of all entries to their ranks. Ranks that expect a message and need no tile
   !! any more get an empty one.
   subroutine send_words(self, communicator, first)
      type(halo_t), intent(inout) :: self            !! The plan, with the words
      type(communicator_t), intent(inout) :: communicator
      integer, intent(in) :: first(:)                !! (entry + 1) Words before it
      integer, allocatable :: to(:), length(:)
      integer :: group, n

      if (self%links%in_use) then
         to = self%links%to
      else
         to = self%rank
      end if
      allocate (length(size(to)), source=0)
      group = 0
      do n = 1, size(to)
         if (group == size(self%rank)) exit
         if (self%rank(group + 1) /= to(n)) cycle
         group = group + 1
         length(n) = first(self%before(group + 1) + 1) - first(self%before(group) + 1)
      end do
      if (group < size(self%rank)) call refuse_receiver(communicator, self%rank(group + 1))
      self%links%surplus = size(self%rank) < size(to)
      call communicator%post(to, length, self%posted, self%links%in_use)
      self%messages = self%messages + size(to)
      self%words = self%words + first(size(first))
   end subroutine send_words

   !> End all ranks: a rank must send to one that does not expect it, which `cover` of the links
   !! should have found. To go on would be a deadlock.
   subroutine refuse_receiver(communicator, rank)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: rank                    !! Receiver

      write (error_unit, "(a,i0,a,i0,a)") "internal error: rank ", communicator%rank, &
         " has tiles for rank ", rank, ", which does not expect them"
      flush (error_unit)
      call communicator%abort(exit_internal)
   end subroutine refuse_receiver

   !> Send packed patches and values of the cells of each border tile once to every rank that needs
   !! it. A rank needs the nodes of some layers of cells next to its own tiles. The boxes of these
   !! nodes are those of the positions of tiles, with particles or without, because the boxes that
   !! particles touch change from step to step and the length of a message must not.
   subroutine halo_post_packed(self, communicator, grid, tiles, boxes, packed, cells, layers)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes             !! Bounding boxes
      type(packed_patch_t), intent(in) :: packed(:)        !! Packed patches to send
      real(wp), allocatable, intent(in) :: cells(:, :)     !! (cell, tile) If there are any
      integer, intent(in) :: layers                  !! Of cells that the receivers need
      integer, allocatable :: first(:), box(:, :, :)
      integer :: entry, more

      if (communicator%size == 1) return
      more = 0
      if (allocated(cells)) more = size(cells, 1)
      call start_entries(self, grid, tiles, layers, sum(kept_rows(packed)), first, box, more)
      !$omp parallel do default(none) shared(self, boxes, packed, cells, first, box) &
      !$omp private(entry) schedule(static)
      do entry = 1, size(self%tile)
         call write_entry(self, boxes, packed, cells, entry, first(entry), box(:, :, entry))
      end do
      !$omp end parallel do
      call send_words(self, communicator, first)
   end subroutine halo_post_packed

   !> Find the boxes of the entries and where their words begin, and write their headings.
   subroutine start_entries(self, grid, tiles, layers, rows, first, box, more)
      type(halo_t), intent(inout) :: self            !! The plan, gets the memory of the words
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer, intent(in) :: layers                  !! Of cells that the receivers need
      integer, intent(in) :: rows                    !! Numbers of a node
      integer, allocatable, intent(out) :: first(:)  !! (entry + 1) Words before it
      integer, allocatable, intent(out) :: box(:, :, :) !! (3, 2, entry) Nodes
      !> Numbers of an entry besides, with packed patches; these end with a thin tile
      integer, intent(in), optional :: more
      integer :: entry

      allocate (first(size(self%tile) + 1), box(3, 2, size(self%tile)))
      first(1) = 0
      do entry = 1, size(self%tile)
         box(:, :, entry) = self%box(grid, tiles, entry, layers, .not. present(more))
         first(entry + 1) = first(entry) + header + nodes_of(box(:, :, entry))*rows
         if (present(more)) first(entry + 1) = first(entry + 1) + more
      end do
      call ensure_outgoing(self, first(size(first)))
      do entry = 1, size(self%tile)
         self%posted%outgoing(first(entry) + 1) = tiles%key(self%tile(entry))
         self%posted%outgoing(first(entry) + 2) = word_of_node(box(:, 1, entry))
         self%posted%outgoing(first(entry) + 3) = word_of_node(box(:, 2, entry))
      end do
   end subroutine start_entries

   !> Write the numbers of an entry: packed patches, values of cells.
   pure subroutine write_entry(self, boxes, packed, cells, entry, before, box)
      type(halo_t), intent(inout) :: self            !! The plan, with the words
      type(node_boxes_t), intent(in) :: boxes
      type(packed_patch_t), intent(in) :: packed(:)
      real(wp), allocatable, intent(in) :: cells(:, :)
      integer, intent(in) :: entry
      integer, intent(in) :: before                  !! Words before it
      integer, intent(in) :: box(3, 2)               !! Its nodes
      real(wp), allocatable :: values(:)
      integer :: n, at

      associate (tile => self%tile(entry), words => self%posted%outgoing)
         at = before + header
         do n = 1, size(packed)
            allocate (values(size(packed(n)%row)*nodes_of(box)))
            call packed(n)%cut(boxes, tile, box, values)
            call as_words(size(values), values, words(at + 1))
            at = at + size(values)
            deallocate (values)
         end do
         if (allocated(cells)) call as_words(size(cells, 1), cells(:, tile), words(at + 1))
      end associate
   end subroutine write_entry

   !> Find up to which ends of its border tiles the receivers need nodes: those next to their tiles,
   !! and those of directions in which they have a tile beside it.
   subroutine find_reach(self, grid, tiles)
      type(halo_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer :: group, entry, place, shift(3)
      integer(int64) :: key

      if (allocated(self%reach)) deallocate (self%reach)
      allocate (self%reach(3, 2, size(self%tile)), source=.false.)
      !$omp parallel do default(none) shared(self, grid, tiles) &
      !$omp private(group, entry, place, shift, key) schedule(dynamic, 1)
      do group = 1, size(self%rank)
         do entry = self%before(group) + 1, self%before(group + 1)
            do place = 1, neighbors
               key = tiles%around(grid, self%tile(entry), place)
               if (key < 0) cycle
               if (tiles%owner(key) /= self%rank(group)) cycle
               shift = shift_to(:, place)
               ! functions that reach beyond their cells need more; they have the whole tile
               if (grid%margin > 0) shift = 0
               self%reach(:, 1, entry) = self%reach(:, 1, entry) .or. shift <= 0
               self%reach(:, 2, entry) = self%reach(:, 2, entry) .or. shift >= 0
            end do
         end do
      end do
      !$omp end parallel do
   end subroutine find_reach

   !> The box of the nodes of an entry that its rank needs.
   pure function halo_box(self, grid, tiles, entry, layers, beyond) result(box)
      class(halo_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(in) :: tiles
      integer, intent(in) :: entry                   !! Tile and rank
      integer, intent(in) :: layers                  !! Of cells next to the tiles of the rank
      logical, intent(in) :: beyond                  !! With nodes beyond the end of a thin tile?
      integer :: box(3, 2)                           !! Lowest and highest node, from 0
      integer :: extent(3), last(3), margin(3)

      extent = extent_of(grid, tiles, self%tile(entry))
      margin = merge(grid%margin, 0, grid%active)
      last = extent
      if (beyond) last = merge(grid%width, 0, grid%active)
      box(:, 1) = merge(-margin, max(extent - layers, 0), self%reach(:, 1, entry))
      box(:, 2) = merge(last + margin, min(layers, last), self%reach(:, 2, entry))
   end function halo_box

   !> Nodes of a box.
   pure integer function nodes_of(box) result(nodes)
      integer, intent(in) :: box(3, 2)               !! Lowest and highest node

      nodes = product(box(:, 2) - box(:, 1) + 1)
   end function nodes_of

   !> Rows of a node in packed patches.
   elemental integer function kept_rows(packed) result(rows)
      type(packed_patch_t), intent(in) :: packed

      rows = size(packed%row)
   end function kept_rows

   !> Three small numbers as a word.
   pure integer(int64) function word_of_node(node) result(word)
      integer, intent(in) :: node(3)                 !! Position in a tile

      word = (node(1) + offset) + ishft(int(node(2) + offset, int64), bits) &
         + ishft(int(node(3) + offset, int64), 2*bits)
   end function word_of_node

   !> The numbers of such a word.
   pure function node_of_word(word) result(node)
      integer(int64), intent(in) :: word
      integer :: node(3), direction

      node = [(int(ibits(word, (direction - 1)*bits, bits)), direction=1, 3)] - offset
   end function node_of_word

   !> Receive packed patches, and store their tiles as ghosts after the own tiles.
   subroutine halo_complete_packed(self, communicator, grid, tiles, boxes, packed, cells)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles          !! Gets the ghosts
      type(node_boxes_t), intent(inout) :: boxes     !! Get those of the ghosts: nodes that are sent
      type(packed_patch_t), intent(inout) :: packed(:)     !! Get those of the ghosts
      real(wp), allocatable, intent(inout) :: cells(:, :)  !! (cell, tile) Get those of the ghosts
      real(wp), allocatable :: patch(:, :)
      integer, allocatable :: first(:)
      integer :: n, entry, tile, more

      if (communicator%size == 1) return
      more = 0
      if (allocated(cells)) more = size(cells, 1)
      call receive_entries(self, communicator, sum(kept_rows(packed)), more, first)
      call set_ghosts(grid, tiles, self%incoming(first + 1))
      call boxes%ensure(tiles%all)
      do entry = 1, size(first)
         tile = tiles%table%find(self%incoming(first(entry) + 1))
         boxes%box(:, 1, tile) = node_of_word(self%incoming(first(entry) + 2))
         boxes%box(:, 2, tile) = node_of_word(self%incoming(first(entry) + 3))
      end do
      call boxes%line_up(grid, tiles)
      do n = 1, size(packed)
         call packed(n)%grow(boxes%nodes())
      end do
      if (allocated(cells)) then
         if (size(cells, 2) < tiles%all) then
            patch = cells(:, :tiles%own)
            call ensure_weights(cells, size(patch, 1), tiles%all)
            cells(:, :tiles%own) = patch
         end if
      end if
      !$omp parallel do default(none) shared(self, tiles, boxes, packed, cells, first) &
      !$omp private(entry) schedule(static)
      do entry = 1, size(first)
         call read_entry(self, tiles, boxes, packed, cells, first(entry))
      end do
      !$omp end parallel do
   end subroutine halo_complete_packed

   !> Receive the messages, and find where their entries begin.
   subroutine receive_entries(self, communicator, rows, more, first)
      type(halo_t), intent(inout) :: self            !! Gets the words
      type(communicator_t), intent(inout) :: communicator
      integer, intent(in) :: rows                    !! Numbers of a node
      integer, intent(in) :: more                    !! Numbers of an entry besides
      integer, allocatable, intent(out) :: first(:)  !! Words before each entry
      integer :: at, pass, number, length, box(3, 2)

      if (self%links%in_use) then
         call communicator%receive(self%posted, size(self%links%from), self%incoming, length)
      else
         call communicator%complete(self%posted, self%incoming, length)
         call self%links%record(self%rank, self%posted%source)
      end if
      do pass = 1, 2
         at = 0
         number = 0
         do while (at < length)
            number = number + 1
            if (pass == 2) first(number) = at
            box(:, 1) = node_of_word(self%incoming(at + 2))
            box(:, 2) = node_of_word(self%incoming(at + 3))
            at = at + header + nodes_of(box)*rows + more
         end do
         if (pass == 1) allocate (first(number))
      end do
   end subroutine receive_entries

   !> Packed patches and values of cells of a ghost.
   subroutine read_entry(self, tiles, boxes, packed, cells, before)
      type(halo_t), intent(in) :: self
      type(tiles_t), intent(in) :: tiles
      type(node_boxes_t), intent(in) :: boxes
      type(packed_patch_t), intent(inout) :: packed(:)
      real(wp), allocatable, intent(inout) :: cells(:, :)
      integer, intent(in) :: before                  !! Words before the entry
      integer :: n, at, tile, nodes, number
      integer(int64) :: begin

      tile = tiles%table%find(self%incoming(before + 1))
      nodes = boxes%before(tile + 1) - boxes%before(tile)
      at = before + header
      do n = 1, size(packed)
         number = nodes*size(packed(n)%row)
         begin = int(boxes%before(tile), int64)*size(packed(n)%row)
         call as_numbers(number, self%incoming(at + 1), &
            packed(n)%values(begin + 1:begin + number))
         at = at + number
      end do
      if (allocated(cells)) call as_numbers(size(cells, 1), self%incoming(at + 1), cells(:, tile))
   end subroutine read_entry

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

   !> Receive patches, and store their tiles as ghosts after the own tiles. Nodes that are not
   !! needed have zeros.
   subroutine halo_complete(self, communicator, grid, tiles, patch)
      class(halo_t), intent(inout) :: self
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid
      type(tiles_t), intent(inout) :: tiles          !! Gets the ghosts
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      real(wp), allocatable :: larger(:, :, :)
      integer, allocatable :: first(:)
      integer :: entry

      if (communicator%size == 1) return
      call receive_entries(self, communicator, size(patch, 1), 0, first)
      call set_ghosts(grid, tiles, self%incoming(first + 1))
      if (size(patch, 3) < tiles%all) then
         call ensure_patch(larger, size(patch, 1), size(patch, 2), tiles%all)
         larger(:, :, :tiles%own) = patch(:, :, :tiles%own)
         call move_alloc(larger, patch)
      end if
      !$omp parallel do default(none) shared(self, grid, tiles, patch, first) private(entry) &
      !$omp schedule(static)
      do entry = 1, size(first)
         call read_box(grid, self%incoming(first(entry) + 2:), &
            patch(:, :, tiles%table%find(self%incoming(first(entry) + 1))))
      end do
      !$omp end parallel do
   end subroutine halo_complete

   !> Patch of a ghost from the words of its box and of the numbers of its nodes.
   pure subroutine read_box(grid, words, patch)
      type(grid_t), intent(in) :: grid
      integer(int64), contiguous, intent(in) :: words(:) !! Lowest node, highest node, numbers
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (component, node)
      integer :: box(3, 2), at, y, z, node, number

      box(:, 1) = node_of_word(words(1))
      box(:, 2) = node_of_word(words(2))
      number = box(1, 2) - box(1, 1) + 1
      at = header - 1
      call clear_patch(patch)
      do z = box(3, 1), box(3, 2)
         do y = box(2, 1), box(2, 2)
            node = node_index(grid, [box(1, 1), y, z])
            call as_numbers(size(patch, 1)*number, words(at + 1:at + size(patch, 1)*number), &
               patch(:, node + 1:node + number))
            at = at + size(patch, 1)*number
         end do
      end do
   end subroutine read_box

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
