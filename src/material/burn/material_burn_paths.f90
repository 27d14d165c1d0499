! SPDX-License-Identifier: BSD-3-Clause
!> Arrival times of detonations: along straight lines of sight, and around obstacles on shortest
!! paths with bends at the corners of cells. Equations (X.10), (X.11) and (X.12) of
!! doc/theory/explosives.md.
!!
!! Each corner of a cell stores the last bend of its path. A neighbour with a line of sight to this
!! bend continues from it, otherwise from the corner itself, so straight parts are straight and not
!! along the grid (A. Nash, K. Daniel, S. Koenig, A. Felner, "Theta*: any-angle path planning on
!! grids", AAAI 2007). Every rank computes the same paths.
module material_burn_paths
   use base_kinds, only: wp
   use material_burn, only: detonator_t, never_burns
   use material_burn_sight, only: sight_map_t
   implicit none
   private

   public :: detonation_paths_t

   !> Bend from which a straight part of a path begins.
   type :: bend_t
      real(wp) :: place(3) = 0.0_wp                  !! [m]
      real(wp) :: time = never_burns                 !! Arrival time of the detonation [s]
      real(wp) :: speed = 1.0_wp                     !! Detonation speed from this point on [m/s]
   end type bend_t

   !> Arrival at the corners of the cells of a map.
   type :: detonation_paths_t
      real(wp), allocatable :: time(:)               !! (corner from 0) [s]
      type(bend_t), allocatable :: bend(:)           !! (corner from 0) Last bend before it
   contains
      procedure :: find => detonation_paths_find     !! Shortest paths to all corners
      procedure :: arrival => detonation_paths_arrival !! At a point in an open cell
      procedure, nopass :: straight => straight_arrival !! At a point in sight of detonators
   end type detonation_paths_t

   !> Paths whose lengths differ by less than this fraction are equal, so that rounding does not add
   !! bends.
   real(wp), parameter :: gain = 1.0e-12_wp

contains

   !> Earliest arrival at a point from the detonators in its line of sight, and the bend of the
   !! path. The point is hidden if a detonator out of sight might arrive first.
   pure subroutine straight_arrival(map, detonators, point, time, hidden, bend)
      type(sight_map_t), intent(in) :: map
      type(detonator_t), intent(in) :: detonators(:)
      real(wp), intent(in) :: point(3)               !! [m]
      real(wp), intent(out) :: time                  !! [s]; never_burns without line of sight
      logical, intent(out) :: hidden                 !! True if a hidden detonator may be first
      type(bend_t), intent(out), optional :: bend    !! The detonator's nearest point
      type(bend_t) :: foot
      real(wp) :: least, arrival
      integer :: n

      time = never_burns
      least = never_burns
      do n = 1, size(detonators)
         foot%place = detonators(n)%foot(point)
         foot%time = detonators(n)%time
         foot%speed = detonators(n)%speed
         arrival = reach(foot, point)
         least = min(least, arrival)
         if (arrival >= time) cycle
         if (.not. map%sees(foot%place, point)) cycle
         time = arrival
         if (present(bend)) bend = foot
      end do
      hidden = least < time
   end subroutine straight_arrival

   !> Time at which a detonation from a bend arrives at a point [s].
   pure real(wp) function reach(bend, point) result(time)
      type(bend_t), intent(in) :: bend
      real(wp), intent(in) :: point(3)               !! [m]

      time = bend%time + sqrt((point(1) - bend%place(1))**2 + (point(2) - bend%place(2))**2 &
         + (point(3) - bend%place(3))**2)/bend%speed
   end function reach

   !> Corners along each direction.
   pure function corner_counts(map) result(counts)
      type(sight_map_t), intent(in) :: map
      integer :: counts(3)

      counts = merge(map%cells + 1, 1, map%active)
   end function corner_counts

   !> Position of a corner [m]; 0 in inactive directions.
   pure function corner_position(map, place) result(position)
      type(sight_map_t), intent(in) :: map
      integer, intent(in) :: place(3)                !! Counted from 0
      real(wp) :: position(3)

      position = merge(map%lower + real(place, wp)*map%spacing, 0.0_wp, map%active)
   end function corner_position

   !> Shortest paths to all corners: from each to its neighbours, up and down the grid, until
   !! nothing becomes earlier.
   subroutine detonation_paths_find(self, map, detonators)
      class(detonation_paths_t), intent(out) :: self
      type(sight_map_t), intent(in) :: map
      type(detonator_t), intent(in) :: detonators(:)
      integer :: counts(3), n, last, place(3)
      logical :: hidden, changed

      counts = corner_counts(map)
      last = product(counts) - 1
      allocate (self%time(0:last), self%bend(0:last))
      self%time = never_burns
      do n = 0, last
         place = place_of(counts, n)
         if (touches_open(map, place)) call straight_arrival(map, detonators, &
            corner_position(map, place), self%time(n), hidden, self%bend(n))
      end do
      do
         changed = .false.
         do n = 0, last
            call improve(self, map, counts, n, changed)
         end do
         do n = last, 0, -1
            call improve(self, map, counts, n, changed)
         end do
         if (.not. changed) exit
      end do
   end subroutine detonation_paths_find

   !> Position of a corner from its number.
   pure function place_of(counts, number) result(place)
      integer, intent(in) :: counts(3)               !! Corners along each direction
      integer, intent(in) :: number                  !! Counted from 0
      integer :: place(3)

      place = [modulo(number, counts(1)), modulo(number/counts(1), counts(2)), &
         number/(counts(1)*counts(2))]
   end function place_of

   !> Is one of the cells around a corner open?
   pure logical function touches_open(map, place) result(does)
      type(sight_map_t), intent(in) :: map
      integer, intent(in) :: place(3)                !! Counted from 0
      integer :: i, j, k, low(3), high(3)

      low = merge(max(place - 1, 0), 0, map%active)
      high = merge(min(place, map%cells - 1), 0, map%active)
      does = .false.
      do k = low(3), high(3)
         do j = low(2), high(2)
            do i = low(1), high(1)
               does = does .or. map%is_open([i, j, k])
            end do
         end do
      end do
   end function touches_open

   !> Route the path of a corner through a neighbour if the detonation then arrives earlier.
   subroutine improve(paths, map, counts, number, changed)
      type(detonation_paths_t), intent(inout) :: paths
      type(sight_map_t), intent(in) :: map
      integer, intent(in) :: counts(3)               !! Corners along each direction
      integer, intent(in) :: number                  !! Number of the corner
      logical, intent(inout) :: changed              !! Becomes true if the path has changed
      integer :: place(3), beside(3), i, j, k, n
      real(wp) :: here(3)
      type(bend_t) :: corner

      place = place_of(counts, number)
      here = corner_position(map, place)
      do k = max(place(3) - 1, 0), min(place(3) + 1, counts(3) - 1)
         do j = max(place(2) - 1, 0), min(place(2) + 1, counts(2) - 1)
            do i = max(place(1) - 1, 0), min(place(1) + 1, counts(1) - 1)
               beside = [i, j, k]
               n = i + counts(1)*(j + counts(2)*k)
               if (n == number .or. .not. paths%time(n) < paths%time(number)) cycle
               call try(paths%bend(n))
               corner%place = corner_position(map, beside)
               corner%time = paths%time(n)
               corner%speed = paths%bend(n)%speed
               call try(corner)
            end do
         end do
      end do

   contains

      !> Use a path from a bend if the detonation arrives earlier by it and the line is open.
      subroutine try(bend)
         type(bend_t), intent(in) :: bend            !! Whole part before the line to the corner
         real(wp) :: time

         time = reach(bend, here)
         if (time >= paths%time(number) - gain*abs(paths%time(number))) return
         if (.not. map%sees(bend%place, here)) return
         paths%time(number) = time
         paths%bend(number) = bend
         changed = .true.
      end subroutine try
   end subroutine improve

   !> Earliest arrival at a point by the corners of its cell and by their last bends [s].
   pure real(wp) function detonation_paths_arrival(self, map, point) result(time)
      class(detonation_paths_t), intent(in) :: self
      type(sight_map_t), intent(in) :: map
      real(wp), intent(in) :: point(3)               !! In a cell of the map [m]
      type(bend_t) :: corner
      integer :: counts(3), place(3), low(3), i, j, k, n

      time = never_burns
      counts = corner_counts(map)
      low = min(max(map%cell_of(point), 0), map%cells - 1)
      do k = low(3), min(low(3) + 1, counts(3) - 1)
         do j = low(2), min(low(2) + 1, counts(2) - 1)
            do i = low(1), min(low(1) + 1, counts(1) - 1)
               place = [i, j, k]
               n = i + counts(1)*(j + counts(2)*k)
               if (.not. self%time(n) < never_burns) cycle
               if (reach(self%bend(n), point) < time) then
                  if (map%sees(self%bend(n)%place, point)) time = reach(self%bend(n), point)
               end if
               corner%place = corner_position(map, place)
               corner%time = self%time(n)
               corner%speed = self%bend(n)%speed
               time = min(time, reach(corner, point))
            end do
         end do
      end do
   end function detonation_paths_arrival
end module material_burn_paths
