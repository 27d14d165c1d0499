! SPDX-License-Identifier: BSD-3-Clause
!> The tiles that exist on a rank: those that hold its particles, in the order of the space-filling
!! curve, and behind them ghosts, the tiles of other ranks that touch them.
module mesh_tiles
   use base_kinds, only: int64, wp
   use mesh_curve, only: curve_coordinate, curve_key
   use mesh_grid, only: grid_t
   use mesh_table, only: key_table_t
   implicit none
   private

   public :: tiles_t, partition_keys

   integer, parameter, public :: neighbors = 27      !! Places around a tile, itself included
   integer, parameter, public :: itself = 14         !! Its own place among them

   !> The tiles of one rank.
   type :: tiles_t
      integer :: own = 0                             !! Tiles with particles of this rank
      integer :: all = 0                             !! Own tiles and ghosts
      integer(int64), allocatable :: key(:)          !! (tile) Place on the curve, own ones ascend
      integer, allocatable :: coordinate(:, :)       !! (3, tile) Place in the grid, from 0
      integer, allocatable :: neighbor(:, :)         !! (27, tile) Index of a neighbour, 0 = none
      integer(int64), allocatable :: border(:)       !! (0:ranks) r owns border(r) <= key < next
      type(key_table_t) :: table                     !! From key to index
   contains
      procedure :: set => tiles_set                  !! Give the tiles and find their neighbours
      procedure :: owner => tiles_owner              !! Rank that owns a key
      procedure :: around => tiles_around            !! Key of a neighbouring place
   end type tiles_t

contains

   !> Give the tiles of this rank and the ghosts, and find who touches whom.
   subroutine tiles_set(self, grid, own, ghost)
      class(tiles_t), intent(inout) :: self          !! The tiles
      type(grid_t), intent(in) :: grid               !! The grid
      integer(int64), intent(in) :: own(:)           !! Keys of tiles with particles, ascending
      integer(int64), intent(in) :: ghost(:)         !! Keys of tiles of other ranks, ascending
      integer :: tile, place
      integer(int64) :: key

      self%own = size(own)
      self%all = size(own) + size(ghost)
      self%key = [own, ghost]
      if (allocated(self%coordinate)) deallocate (self%coordinate, self%neighbor)
      allocate (self%coordinate(3, self%all), self%neighbor(neighbors, self%all))
      call self%table%clear(2*self%all)
      do tile = 1, self%all
         self%coordinate(:, tile) = curve_coordinate(self%key(tile), grid%dimensions)
         call self%table%insert(self%key(tile), tile)
      end do
      !$omp parallel do default(none) shared(self, grid) private(tile, place, key) schedule(static)
      do tile = 1, self%all
         do place = 1, neighbors
            self%neighbor(place, tile) = 0
            key = self%around(grid, tile, place)
            if (key >= 0) self%neighbor(place, tile) = self%table%find(key)
         end do
      end do
      !$omp end parallel do
   end subroutine tiles_set

   !> Key of the tile at one of the 27 places around a tile; -1 outside the box.
   pure integer(int64) function tiles_around(self, grid, tile, place) result(key)
      class(tiles_t), intent(in) :: self             !! The tiles
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: tile                    !! Index of a tile
      integer, intent(in) :: place                   !! 1 to 27, x fastest
      integer :: coordinate(3), shift(3)

      key = -1
      shift = [mod(place - 1, 3), mod((place - 1)/3, 3), (place - 1)/9] - 1
      if (any(shift /= 0 .and. .not. grid%active)) return
      coordinate = self%coordinate(:, tile) + shift
      where (grid%periodic .and. grid%active) coordinate = modulo(coordinate, grid%tiles)
      if (any(coordinate < 0 .or. coordinate >= grid%tiles)) return
      key = curve_key(coordinate, grid%dimensions)
   end function tiles_around

   !> Rank that owns a key.
   pure integer function tiles_owner(self, key) result(rank)
      class(tiles_t), intent(in) :: self             !! The tiles
      integer(int64), intent(in) :: key              !! Place on the curve
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

   !> Cut the curve so that the ranks get equal shares of weight.
   pure subroutine partition_keys(key, weight, ranks, border)
      integer(int64), intent(in) :: key(:)           !! Occupied tiles, ascending
      integer(int64), intent(in) :: weight(:)        !! Their weights (particles)
      integer, intent(in) :: ranks                   !! Number of ranks
      integer(int64), allocatable, intent(out) :: border(:) !! (0:ranks) Cuts
      integer(int64) :: total, before
      integer :: rank, tile

      allocate (border(0:ranks))
      border = huge(1_int64)
      border(0) = 0
      total = sum(weight)
      before = 0
      rank = 1
      do tile = 1, size(key)
         do while (rank < ranks)
            if (real(before, wp) + 0.5_wp*real(weight(tile), wp) < &
               real(total, wp)*real(rank, wp)/real(ranks, wp)) exit
            border(rank) = key(tile)
            rank = rank + 1
         end do
         before = before + weight(tile)
      end do
   end subroutine partition_keys
end module mesh_tiles
