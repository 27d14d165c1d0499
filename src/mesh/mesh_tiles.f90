! SPDX-License-Identifier: BSD-3-Clause
!> The tiles that exist on a rank: those with its particles, in the order of the space-filling
!! curve, followed by ghosts, the tiles of other ranks that touch them.
module mesh_tiles
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use mesh_hash_table, only: key_table_t
   use mesh_hilbert, only: hilbert_coordinate, hilbert_key
   implicit none
   private

   public :: tiles_t, partition_keys, partition_distributed_keys, partition_scattered_keys

   integer, parameter, public :: neighbors = 27      !! Neighbours of a tile, itself included
   integer, parameter, public :: itself = 14         !! Index of the tile itself among neighbours
   !> Tiles from a tile to each neighbour along the directions, x fastest
   integer, parameter, public :: shift_to(3, neighbors) = reshape([ &
      -1, -1, -1, 0, -1, -1, 1, -1, -1, -1, 0, -1, 0, 0, -1, 1, 0, -1, &
      -1, 1, -1, 0, 1, -1, 1, 1, -1, -1, -1, 0, 0, -1, 0, 1, -1, 0, &
      -1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 1, 0, 0, 1, 0, 1, 1, 0, &
      -1, -1, 1, 0, -1, 1, 1, -1, 1, -1, 0, 1, 0, 0, 1, 1, 0, 1, &
      -1, 1, 1, 0, 1, 1, 1, 1, 1], [3, neighbors])

   !> The tiles of one rank.
   type :: tiles_t
      integer :: own = 0                             !! Tiles with particles of this rank
      integer :: all = 0                             !! Own tiles and ghosts
      integer(int64), allocatable :: key(:)          !! (tile) Place on the curve, own ones ascend
      integer, allocatable :: coordinate(:, :)       !! (3, tile) Position in the grid, from 0
      integer, allocatable :: neighbor(:, :)         !! (27, tile) Index of a neighbour, 0 = none
      integer(int64), allocatable :: border(:)       !! (0:ranks) r owns border(r) <= key < next
      integer(int64) :: version = 0                  !! Grows when own tiles or cuts change
      type(key_table_t) :: table                     !! Table from keys to indices
      integer, private :: shape(7) = -1 !! Shape of the grid to which the neighbours belong
   contains
      procedure :: set => tiles_set                  !! Give the tiles and find their neighbours
      procedure :: cut => tiles_cut                  !! Divide the curve among the ranks
      procedure :: owner => tiles_owner              !! Rank that owns a key
      procedure :: around => tiles_around            !! Key of a neighbour
      procedure, nopass :: beside => tiles_beside    !! Keys of the neighbours of any tile
   end type tiles_t

contains

   !> Set the tiles of this rank and the ghosts, and find the neighbours of each. Existing tiles
   !! only renumber their neighbours: most of them remain, and a new search would cost as much as
   !! sorting the particles.
   subroutine tiles_set(self, grid, own, ghost)
      class(tiles_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer(int64), intent(in) :: own(:)           !! Keys of tiles with particles, ascending
      integer(int64), intent(in) :: ghost(:)         !! Keys of tiles of other ranks, ascending
      integer, allocatable :: former(:), renumbered(:), coordinate(:, :), neighbor(:, :)
      integer :: tile

      if (.not. same_own(self, own)) self%version = self%version + 1
      call know_grid(self, grid)
      allocate (renumbered(0:size(self%neighbor, 2)), source=0)
      self%own = size(own)
      self%all = size(own) + size(ghost)
      self%key = [own, ghost]
      allocate (former(self%all), coordinate(3, self%all), neighbor(neighbors, self%all))
      do tile = 1, self%all
         former(tile) = self%table%find(self%key(tile))
         if (former(tile) > 0) then
            renumbered(former(tile)) = tile
            coordinate(:, tile) = self%coordinate(:, former(tile))
         else
            coordinate(:, tile) = hilbert_coordinate(self%key(tile), grid%dimensions)
         end if
      end do
      call self%table%clear(2*self%all)
      do tile = 1, self%all
         call self%table%insert(self%key(tile), tile)
      end do
      call move_alloc(coordinate, self%coordinate)
      call find_neighbors(self, grid, former, renumbered, neighbor)
      call move_alloc(neighbor, self%neighbor)
   end subroutine tiles_set

   !> Delete all tiles if they belong to another grid.
   subroutine know_grid(self, grid)
      class(tiles_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer :: shape(7)

      shape = [grid%dimensions, grid%tiles, merge(1, 0, grid%periodic)]
      if (all(shape == self%shape)) return
      self%shape = shape
      call self%table%clear(0)
      if (allocated(self%neighbor)) deallocate (self%coordinate, self%neighbor)
      allocate (self%coordinate(3, 0), self%neighbor(neighbors, 0))
   end subroutine know_grid

   !> Neighbours of the tiles, from those before.
   subroutine find_neighbors(self, grid, former, renumbered, neighbor)
      class(tiles_t), intent(in) :: self             !! The tiles, with their former neighbours
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: former(:)               !! (tile) Former index, 0 = new
      integer, intent(in) :: renumbered(0:)          !! (former tile) Current index, 0 = removed
      integer, intent(inout) :: neighbor(:, :)       !! (27, tile) Index of a neighbour, 0 = none
      integer :: tile, place

      !$omp parallel do default(none) shared(self, grid, former, renumbered, neighbor) &
      !$omp private(tile, place) schedule(static)
      do tile = 1, self%all
         if (former(tile) > 0) then
            do place = 1, neighbors
               neighbor(place, tile) = renumbered(self%neighbor(place, former(tile)))
            end do
         else
            do place = 1, neighbors
               neighbor(place, tile) = self%table%find(self%around(grid, tile, place))
            end do
         end if
      end do
      !$omp end parallel do
      do tile = 1, self%all
         if (former(tile) > 0) cycle
         do place = 1, neighbors
            ! this tile is the opposite neighbour of that neighbour
            if (neighbor(place, tile) > 0) neighbor(neighbors + 1 - place, &
               neighbor(place, tile)) = tile
         end do
      end do
   end subroutine find_neighbors

   !> True if these are the tiles with particles already.
   pure logical function same_own(self, own) result(same)
      class(tiles_t), intent(in) :: self
      integer(int64), intent(in) :: own(:)           !! Keys, ascending

      same = allocated(self%key) .and. size(own) == self%own
      if (same) same = all(self%key(:self%own) == own)
   end function same_own

   !> Set the cuts of the curve. Tiles and particles are not moved to other ranks here.
   pure subroutine tiles_cut(self, border)
      class(tiles_t), intent(inout) :: self
      integer(int64), intent(in) :: border(0:)       !! (0:ranks) r owns border(r) <= key < next

      if (allocated(self%border)) deallocate (self%border)
      allocate (self%border(0:ubound(border, 1)))
      self%border = border
      self%version = self%version + 1
   end subroutine tiles_cut

   !> Key of one of the 27 neighbours of a tile; -1 outside of the domain.
   pure integer(int64) function tiles_around(self, grid, tile, place) result(key)
      class(tiles_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: tile                    !! Index of a tile
      integer, intent(in) :: place                   !! 1 to 27, x fastest

      key = key_beside(grid, self%coordinate(:, tile), place)
   end function tiles_around

   !> Keys of the 27 neighbours of a tile that need not exist here; -1 outside of the domain.
   pure function tiles_beside(grid, key) result(keys)
      type(grid_t), intent(in) :: grid
      integer(int64), intent(in) :: key              !! Position on the curve
      integer(int64) :: keys(neighbors)
      integer :: coordinate(3), place

      coordinate = hilbert_coordinate(key, grid%dimensions)
      do place = 1, neighbors
         keys(place) = key_beside(grid, coordinate, place)
      end do
   end function tiles_beside

   !> Key of the neighbour of a position in the grid of tiles; -1 outside of the domain.
   pure integer(int64) function key_beside(grid, centre, place) result(key)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: centre(3)               !! Position, from 0
      integer, intent(in) :: place                   !! 1 to 27, x fastest
      integer :: coordinate(3)

      key = -1
      if (any(shift_to(:, place) /= 0 .and. .not. grid%active)) return
      coordinate = centre + shift_to(:, place)
      where (grid%periodic .and. grid%active) coordinate = modulo(coordinate, grid%tiles)
      if (any(coordinate < 0 .or. coordinate >= grid%tiles)) return
      key = hilbert_key(coordinate, grid%dimensions)
   end function key_beside

   !> Rank that owns a key.
   pure integer function tiles_owner(self, key) result(rank)
      class(tiles_t), intent(in) :: self
      integer(int64), intent(in) :: key              !! Position on the curve
      integer :: low, high, middle

      low = 0
      high = ubound(self%border, 1)
      do while (high - low > 1)
         middle = (low + high)/2
         if (self%border(middle) <= key) then
            low = middle
         else
            high = middle
         end if
      end do
      rank = low
   end function tiles_owner

   !> Cut the curve so that the ranks get equal weights.
   pure subroutine partition_keys(key, weight, ranks, border)
      integer(int64), intent(in) :: key(:)           !! Occupied tiles, ascending
      integer(int64), intent(in) :: weight(:)        !! Weights of the tiles
      integer, intent(in) :: ranks                   !! Number of ranks
      integer(int64), allocatable, intent(out) :: border(:) !! (0:ranks) Cuts

      call find_cuts(key, weight, 0_int64, sum(weight), ranks, border)
   end subroutine partition_keys

   !> The same if each rank has the tiles of its part of the curve only; no rank ever has the list
   !! of all tiles. Collective.
   subroutine partition_distributed_keys(communicator, key, weight, border)
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(in) :: key(:)           !! Tiles of this rank, ascending
      integer(int64), intent(in) :: weight(:)        !! Weights of the tiles
      integer(int64), allocatable, intent(out) :: border(:) !! (0:ranks) Cuts
      integer(int64) :: total(1)

      total = sum(weight)
      call communicator%total(total)
      call find_cuts(key, weight, communicator%before(sum(weight)), total(1), communicator%size, &
         border)
      ! a cut is at the first tile with enough accumulated weight, on any rank
      call communicator%least(border)
   end subroutine partition_distributed_keys

   !> The same if a rank has tiles anywhere on the curve, and several ranks may have a part of the
   !! weight of a tile. All cuts are found together by bisection of the curve: about as many sums
   !! over the ranks as the greatest key has bits. Collective.
   subroutine partition_scattered_keys(communicator, key, weight, border)
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(in) :: key(:)           !! Tiles stored on this rank, ascending
      integer(int64), intent(in) :: weight(:)        !! Weights of the tiles, or parts of these
      integer(int64), allocatable, intent(out) :: border(:) !! (0:ranks) Cuts
      integer(int64), allocatable :: before(:), low(:), high(:), sums(:)
      integer(int64) :: middle, total(1), most(1)
      integer :: ranks, cut, tile

      ranks = communicator%size
      allocate (before(size(key) + 1), low(ranks - 1), high(ranks - 1), sums(2*ranks - 2))
      before(1) = 0
      do tile = 1, size(key)
         before(tile + 1) = before(tile) + weight(tile)
      end do
      total = before(size(before))
      call communicator%total(total)
      most = 0
      if (size(key) > 0) most = -key(size(key)) - 1
      call communicator%least(most)
      low = 0
      high = -most(1)
      do while (any(low < high))
         do cut = 1, ranks - 1
            middle = low(cut) + (high(cut) - low(cut))/2
            sums(2*cut - 1) = before(first_at(key, middle))
            sums(2*cut) = before(first_at(key, middle + 1)) - sums(2*cut - 1)
         end do
         call communicator%total(sums)
         do cut = 1, ranks - 1
            middle = low(cut) + (high(cut) - low(cut))/2
            if (lies_before(sums(2*cut - 1), sums(2*cut), total(1), cut, ranks)) then
               low(cut) = middle + 1
            else
               high(cut) = middle
            end if
         end do
      end do
      allocate (border(0:ranks))
      border = huge(1_int64)
      border(0) = 0
      do cut = 1, ranks - 1
         tile = first_at(key, low(cut))
         if (tile <= size(key)) border(cut) = key(tile)
      end do
      call communicator%least(border)
   end subroutine partition_scattered_keys

   !> Index of the first key that is not below a place; size + 1 if all are below.
   pure integer function first_at(key, place) result(first)
      integer(int64), intent(in) :: key(:)           !! Ascending
      integer(int64), intent(in) :: place            !! On the curve
      integer :: above, middle

      first = 1
      above = size(key) + 1
      do while (first < above)
         middle = first + (above - first)/2
         if (key(middle) < place) then
            first = middle + 1
         else
            above = middle
         end if
      end do
   end function first_at

   !> True if the middle of a tile is before a cut, by accumulated weight.
   pure logical function lies_before(before, weight, total, cut, ranks) result(lower)
      integer(int64), intent(in) :: before           !! Weight of the tiles before
      integer(int64), intent(in) :: weight           !! Weight of the tile
      integer(int64), intent(in) :: total            !! Weight of all tiles
      integer, intent(in) :: cut                     !! Ranks before the cut
      integer, intent(in) :: ranks                   !! Number of ranks

      lower = real(before, wp) + 0.5_wp*real(weight, wp) < &
         real(total, wp)*real(cut, wp)/real(ranks, wp)
   end function lies_before

   !> The first tile of each part, if it is among these: the one whose middle is beyond the
   !! accumulated weight of the previous ranks.
   pure subroutine find_cuts(key, weight, start, total, ranks, border)
      integer(int64), intent(in) :: key(:)           !! Occupied tiles, ascending
      integer(int64), intent(in) :: weight(:)        !! Weights of the tiles
      integer(int64), intent(in) :: start            !! Weight of the tiles before
      integer(int64), intent(in) :: total            !! Weight of all tiles
      integer, intent(in) :: ranks                   !! Number of ranks
      integer(int64), allocatable, intent(out) :: border(:) !! (0:ranks) Cuts
      integer(int64) :: before
      integer :: rank, tile

      allocate (border(0:ranks))
      border = huge(1_int64)
      border(0) = 0
      before = start
      rank = 1
      do tile = 1, size(key)
         do while (rank < ranks)
            if (lies_before(before, weight(tile), total, rank, ranks)) exit
            border(rank) = key(tile)
            rank = rank + 1
         end do
         before = before + weight(tile)
      end do
   end subroutine find_cuts
end module mesh_tiles
