! SPDX-License-Identifier: BSD-3-Clause
!> Cells through which a detonation can run, and lines of sight through them.
module material_burn_sight
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: sight_map_t

   !> Content of a cell. Where ranks differ the least value applies.
   integer(int64), parameter, public :: cell_explosive = 1, cell_other = 2, cell_empty = 3

   !> A box of cells around the explosives.
   type :: sight_map_t
      logical :: active(3) = .true.                  !! Active directions
      real(wp) :: lower(3) = 0.0_wp                  !! Lower corner [m]
      real(wp) :: spacing = 1.0_wp                   !! Edge of a cell [m]
      integer :: cells(3) = 1                        !! Along each direction, 1 if inactive
      logical, allocatable :: open(:)                !! (cell from 0) Can a detonation pass?
   contains
      procedure :: start => sight_map_start          !! Set up from the content of the cells
      procedure :: cell_of => sight_map_cell_of      !! Position of the cell of a point
      procedure :: is_open => sight_map_is_open      !! Is a cell open? True outside of the box
      procedure :: sees => sight_map_sees            !! Is a straight line open?
   end type sight_map_t

   !> Fraction of a cell that counts as zero: a line along a face of two cells is in both.
   real(wp), parameter :: slack = 1.0e-7_wp

contains

   !> Open the cells with explosive, and empty neighbours of these that the boundary of the
   !! explosive may cut.
   pure subroutine sight_map_start(self, content)
      class(sight_map_t), intent(inout) :: self      !! Corner, spacing and counts are set
      integer(int64), intent(in) :: content(0:)      !! (cell) Content
      integer :: i, j, k, n

      allocate (self%open(0:size(content) - 1))
      self%open = content == cell_explosive
      n = -1
      do k = 0, self%cells(3) - 1
         do j = 0, self%cells(2) - 1
            do i = 0, self%cells(1) - 1
               n = n + 1
               if (content(n) == cell_empty) self%open(n) = has_neighbour(self, content, [i, j, k])
            end do
         end do
      end do
   end subroutine sight_map_start

   !> True if a neighbour of the cell across a face contains explosive.
   pure logical function has_neighbour(map, content, place) result(has)
      type(sight_map_t), intent(in) :: map
      integer(int64), intent(in) :: content(0:)      !! (cell) Content
      integer, intent(in) :: place(3)                !! Counted from 0
      integer :: beside(3), direction, side

      has = .false.
      do direction = 1, 3
         do side = -1, 1, 2
            beside = place
            beside(direction) = place(direction) + side
            if (any(beside < 0 .or. beside >= map%cells)) cycle
            has = has .or. content(number_of(map, beside)) == cell_explosive
         end do
      end do
   end function has_neighbour

   !> Number of a cell from its position.
   pure integer function number_of(map, place) result(number)
      type(sight_map_t), intent(in) :: map
      integer, intent(in) :: place(3)                !! Index from 0, inside the box

      number = place(1) + map%cells(1)*(place(2) + map%cells(2)*place(3))
   end function number_of

   !> Position of the cell of a point, counted from 0; outside the box it is outside the range of
   !! cells.
   pure function sight_map_cell_of(self, point) result(place)
      class(sight_map_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! [m]
      integer :: place(3), k

      place = 0
      do k = 1, 3
         if (self%active(k)) place(k) = floor(max(-1.0_wp, min(real(self%cells(k), wp), &
            (point(k) - self%lower(k))/self%spacing)))
      end do
   end function sight_map_cell_of

   !> True if a cell is open; cells outside of the box are.
   pure logical function sight_map_is_open(self, place) result(is_open)
      class(sight_map_t), intent(in) :: self
      integer, intent(in) :: place(3)                !! Counted from 0

      is_open = .true.
      if (any(place < 0 .or. place >= self%cells)) return
      is_open = self%open(number_of(self, place))
   end function sight_map_is_open

   !> Is the straight line between two points open? Each segment of it between two faces of cells
   !! must be in an open cell; for a segment in a face the cell on either side is enough.
   pure logical function sight_map_sees(self, from, to) result(open)
      class(sight_map_t), intent(in) :: self
      real(wp), intent(in) :: from(3)                !! [m]
      real(wp), intent(in) :: to(3)                  !! [m]
      real(wp) :: share, next, plane(3), first(3), along(3)
      integer :: k

      do k = 1, 3
         first(k) = 0.5_wp
         along(k) = 0.0_wp
         if (.not. self%active(k)) cycle
         first(k) = (from(k) - self%lower(k))/self%spacing
         along(k) = (to(k) - from(k))/self%spacing
         plane(k) = first_plane(first(k), along(k))
      end do
      open = .true.
      share = 0.0_wp
      do while (share < 1.0_wp)
         next = 1.0_wp
         do k = 1, 3
            if (abs(along(k)) > slack) next = min(next, (plane(k) - first(k))/along(k))
         end do
         if ((next - share)*maxval(abs(along)) > slack) then
            if (.not. piece_is_open(self, first + 0.5_wp*(share + next)*along)) then
               open = .false.
               return
            end if
         end if
         share = max(share, next)
         do k = 1, 3
            if (.not. abs(along(k)) > slack) cycle
            if ((plane(k) - first(k))/along(k) <= next) plane(k) = plane(k) + &
               sign(1.0_wp, along(k))
         end do
      end do
   end function sight_map_sees

   !> First plane between cells that a line crosses after its start.
   pure real(wp) function first_plane(first, along) result(plane)
      real(wp), intent(in) :: first                  !! Begin in cells
      real(wp), intent(in) :: along                  !! Its extent in cells

      if (along > 0.0_wp) then
         plane = real(floor(first), wp) + 1.0_wp
      else
         plane = real(ceiling(first), wp) - 1.0_wp
      end if
   end function first_plane

   !> Is a point in an open cell, or on a face of one? On faces of the box cells outside do not
   !! count; otherwise paths would run along the face past all obstacles that touch it.
   pure logical function piece_is_open(map, point) result(open)
      type(sight_map_t), intent(in) :: map
      real(wp), intent(in) :: point(3)               !! In cells, 0.5 in inactive directions
      integer :: low(3), high(3), i, j, k

      open = any(point < -slack .or. point > real(map%cells, wp) + slack)
      if (open) return
      do k = 1, 3
         low(k) = floor(point(k) - slack)
         high(k) = floor(point(k) + slack)
      end do
      low = max(low, 0)
      high = min(high, map%cells - 1)
      do k = low(3), high(3)
         do j = low(2), high(2)
            do i = low(1), high(1)
               open = open .or. map%is_open([i, j, k])
            end do
         end do
      end do
   end function piece_is_open
end module material_burn_sight
