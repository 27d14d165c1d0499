! SPDX-License-Identifier: BSD-3-Clause
!> Tiles that bodies may fill, distributed over the ranks without a list of them.
module particle_candidates
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use base_random, only: random_bits
   use mesh_grid, only: grid_t
   use particle_body, only: body_t
   implicit none
   private

   public :: candidates_t

   !> The tiles in the bounding boxes of bodies, numbered body by body.
   type :: candidates_t
      integer, allocatable :: first(:, :)             !! (direction, body) Lowest tile of its box
      integer, allocatable :: last(:, :)              !! (direction, body) Highest tile
      integer(int64), allocatable :: before(:)        !! (body + 1) Tiles in the boxes before
   contains
      procedure :: find => candidates_find            !! From the bodies
      procedure :: rounds => candidates_rounds        !! Rounds until all are dealt out
      procedure :: deal => candidates_deal            !! The tile that a rank gets in a round
   end type candidates_t

contains

   !> Find the boxes of bodies in tiles, clipped to the domain.
   subroutine candidates_find(self, grid, bodies)
      class(candidates_t), intent(out) :: self
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp) :: low(3), high(3)
      integer :: body

      allocate (self%first(3, size(bodies)), self%last(3, size(bodies)), &
         self%before(size(bodies) + 1))
      self%before(1) = 0
      do body = 1, size(bodies)
         call bodies(body)%shape%bounds(low, high)
         self%first(:, body) = tile_of(grid, low)
         self%last(:, body) = tile_of(grid, high)
         self%before(body + 1) = self%before(body) + product(int(max(self%last(:, body) &
            - self%first(:, body) + 1, 0), int64))
      end do
   end subroutine candidates_find

   !> Tile of a corner, clipped to the domain.
   pure function tile_of(grid, corner) result(coordinate)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: corner(3)               !! [m]
      integer :: coordinate(3)
      real(wp) :: place(3)

      coordinate = 0
      place = (corner - grid%lower)/grid%spacing
      where (grid%active) coordinate = min(int(max(min(place, real(grid%cells, wp)), 0.0_wp)), &
         grid%cells - 1)/grid%width
   end function tile_of

   !> Number of rounds until all tiles are distributed, one per rank and round.
   pure integer(int64) function candidates_rounds(self, communicator) result(rounds)
      class(candidates_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator

      rounds = (self%before(size(self%before)) + communicator%size - 1)/communicator%size
   end function candidates_rounds

   !> The tile that this rank gets in a round, if any. Which rank is the first in a round is chosen
   !! at random: if it were always the same, a rank could get whole layers of full or empty tiles. A
   !! tile in the boxes of several bodies is assigned with the first of these bodies only. The
   !! search starts with the last body because bodies with common tiles usually have successive
   !! numbers.
   pure subroutine candidates_deal(self, communicator, round, coordinate, dealt)
      class(candidates_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(in) :: round             !! From 1
      integer, intent(out) :: coordinate(3)           !! Tile, counted from 0
      logical, intent(out) :: dealt                   !! Does the rank get a tile?
      integer(int64), parameter :: seed = 20_int64
      integer(int64) :: ranks, place
      integer :: width(3), body, n

      ranks = communicator%size
      place = (round - 1)*ranks + modulo(communicator%rank &
         + modulo(random_bits(seed, round, 0_int64), ranks), ranks)
      coordinate = 0
      dealt = place < self%before(size(self%before))
      if (.not. dealt) return
      body = body_at(self%before, place)
      width = self%last(:, body) - self%first(:, body) + 1
      place = place - self%before(body)
      coordinate(1) = int(modulo(place, int(width(1), int64)))
      place = place/width(1)
      coordinate(2) = int(modulo(place, int(width(2), int64)))
      coordinate(3) = int(place/width(2))
      coordinate = coordinate + self%first(:, body)
      do n = body - 1, 1, -1
         if (coordinate(1) < self%first(1, n) .or. coordinate(1) > self%last(1, n)) cycle
         if (coordinate(2) < self%first(2, n) .or. coordinate(2) > self%last(2, n)) cycle
         if (coordinate(3) < self%first(3, n) .or. coordinate(3) > self%last(3, n)) cycle
         dealt = .false.
         return
      end do
   end subroutine candidates_deal

   !> Body whose box holds a number.
   pure integer function body_at(before, place) result(body)
      integer(int64), intent(in) :: before(:)         !! (body + 1) Numbers of the boxes before
      integer(int64), intent(in) :: place             !! Counted from 0
      integer :: above, middle

      body = 1
      above = size(before)
      do while (above - body > 1)
         middle = (body + above)/2
         if (before(middle) <= place) then
            body = middle
         else
            above = middle
         end if
      end do
   end function body_at
end module particle_candidates
