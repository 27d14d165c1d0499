! SPDX-License-Identifier: BSD-3-Clause
!> The direction out of rigid regions.
!!
!! It uses only the test whether a point is inside, so it works for any shape and any set operation:
!! the seam between two regions, and the side of a region on a boundary of the domain, do not count
!! as surfaces.
module mesh_surface_normal
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_wall, only: wall_t
   implicit none
   private

   public :: covers, find_surface_normal, touches

   real(wp), parameter :: pace = 0.5_wp              !! Step of the search along a ray [cells]
   integer, parameter :: paces = 8                   !! Number of steps: maximum search distance
   real(wp), parameter :: aside = 0.05_wp            !! Distance of the positions for slopes [cells]
   integer, parameter :: halvings = 40               !! Bisections of a part of a ray
   real(wp), parameter :: beside = 0.499999_wp       !! Distance that touches a wall [cells]
   integer, parameter :: most_rays = 124             !! Most rays from a position
   integer, parameter :: rounds = 12                 !! Most improvements of a normal
   real(wp), parameter :: converged = 1.0e-9_wp      !! Change of a normal that is good enough
   real(wp), parameter :: within = 1.0e-6_wp         !! Distance from faces in tests [cells]
   real(wp), parameter :: steep = 0.7_wp             !! Part of a normal along a face that is enough

contains

   !> Outward normal of the surface nearest to a position that touches the walls. Rays in all
   !! directions give a first estimate, the mean of the shortest exits; the slopes of the surface
   !! where this normal crosses it improve it. On one closed face of a domain of three dimensions
   !! the caller needs the part along this face: the search stays on the face, because beyond it
   !! there are no slopes.
   pure subroutine find_surface_normal(walls, grid, position, on_face, normal, found)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: position(3)            !! [m]
      logical, intent(in) :: on_face(3)              !! On a closed face across a direction?
      real(wp), intent(out) :: normal(3)             !! Unit vector [1]
      logical, intent(out) :: found                  !! Is a surface nearby?
      real(wp) :: place(3), inside(3), below(3), before(3)
      integer :: round, across
      logical :: smooth

      place = position
      call start_on_face(walls, grid, on_face, place, inside, normal, across)
      found = across > 0
      if (across == 0) then
         call step_in(walls, grid, place, 0, inside, found)
         if (.not. found) inside = place
         call guess_outward(walls, grid, inside, normal, found)
      end if
      if (.not. found) return
      do round = 1, rounds
         ! below the position itself, if it is outside, so that the normal passes through it
         below = place - grid%spacing*normal
         if (any(abs(inside - place) > 0.0_wp) .and. closed(walls, grid, below)) inside = below
         before = normal
         call improve(walls, grid, inside, across, normal, smooth)
         if (.not. smooth .or. maxval(abs(normal - before)) < converged) exit
      end do
   end subroutine find_surface_normal

   !> Start the search on a closed face, if the position is on one of them and the surface is steep
   !! enough there.
   pure subroutine start_on_face(walls, grid, on_face, place, inside, normal, across)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: on_face(3)              !! On a closed face across a direction?
      real(wp), intent(inout) :: place(3)            !! Moved to the face by rounding [m]
      real(wp), intent(out) :: inside(3)             !! A position in the walls on the face [m]
      real(wp), intent(out) :: normal(3)             !! Unit vector along the face [1]
      integer, intent(out) :: across                 !! Direction across the face, 0 = none
      real(wp) :: on_it(3)
      logical :: found

      across = 0
      normal = 0.0_wp
      inside = place
      if (grid%dimensions < 3 .or. count(on_face) /= 1) return
      across = findloc(on_face, .true., 1)
      on_it = min(max(place, grid%lower), grid%upper)
      call step_in(walls, grid, on_it, across, inside, found)
      if (found) call guess_outward(walls, grid, inside, normal, found)
      normal(across) = 0.0_wp
      if (found .and. norm2(normal) > steep) then
         normal = normal/norm2(normal)
         place = on_it
      else
         across = 0
      end if
   end subroutine start_on_face

   !> True if a wall covers a position, or one less than half a cell away.
   pure logical function touches(wall, grid, place) result(touch)
      type(wall_t), intent(in) :: wall               !! A rigid region
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]
      integer :: n, number
      real(wp) :: direction(3, most_rays)

      touch = wall%acts
      if (.not. touch) return
      touch = covers(wall, grid, place)
      if (touch) return
      call rays(grid, 1, direction, number)
      do n = 1, number
         touch = covers(wall, grid, place + beside*grid%spacing*direction(:, n))
         if (touch) return
      end do
   end function touches

   !> A position inside the walls: the given one, or a neighbouring one if the given one only
   !! touches them.
   pure subroutine step_in(walls, grid, place, across, inside, found)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]
      integer, intent(in) :: across                  !! Direction that stays the same, 0 = none
      real(wp), intent(out) :: inside(3)             !! [m]
      logical, intent(out) :: found                  !! Is there one?
      integer :: n, number, wall
      real(wp) :: direction(3, most_rays), shift(3)

      call rays(grid, 1, direction, number)
      do n = 0, number
         shift = 0.0_wp
         if (n > 0) shift = beside*grid%spacing*direction(:, n)
         if (across > 0) then
            if (abs(shift(across)) > 0.0_wp) cycle
         end if
         inside = place + shift
         do wall = 1, size(walls)
            found = covers(walls(wall), grid, inside)
            if (found) return
         end do
      end do
      found = .false.
   end subroutine step_in

   !> Directions to all sides, from the middle of a cube to the nodes on its faces.
   pure subroutine rays(grid, side, direction, number)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: side                    !! Half the edge of the cube
      real(wp), intent(out) :: direction(3, most_rays) !! Unit vector [1]
      integer, intent(out) :: number                 !! Number
      integer :: x, y, z, last(3)

      last = merge(side, 0, grid%active)
      number = 0
      do z = -last(3), last(3)
         do y = -last(2), last(2)
            do x = -last(1), last(1)
               if (maxval(abs([x, y, z])) < side) cycle
               number = number + 1
               direction(:, number) = real([x, y, z], wp)/norm2(real([x, y, z], wp))
            end do
         end do
      end do
   end subroutine rays

   !> Whether a position is closed to material: in some wall, or outside of the domain.
   pure logical function closed(walls, grid, place) result(yes)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]
      integer :: n

      yes = any(grid%active .and. .not. grid%periodic .and. (place < grid%lower .or. &
         place > grid%upper))
      do n = 1, size(walls)
         if (yes) return
         yes = covers(walls(n), grid, place)
      end do
   end function closed

   !> Whether a wall covers a position, or its image through periodic boundaries. On boundaries of
   !! the domain the test uses a position just inside, because a region that ends there may include
   !! only one of its two faces.
   pure logical function covers(wall, grid, place) result(yes)
      type(wall_t), intent(in) :: wall               !! A rigid region
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]
      real(wp) :: inside(3)

      inside = place
      where (grid%active .and. grid%periodic) inside = grid%lower + modulo(place - grid%lower, &
         grid%upper - grid%lower)
      where (grid%active) inside = min(max(inside, grid%lower + within*grid%spacing), &
         grid%upper - within*grid%spacing)
      yes = wall%covers(inside)
   end function covers

   !> Mean of the directions whose exits are nearly the shortest.
   pure subroutine guess_outward(walls, grid, place, normal, found)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]
      real(wp), intent(out) :: normal(3)             !! Unit vector [1]
      logical, intent(out) :: found                  !! Is a surface nearby?
      integer, parameter :: around(3) = [1, 2, 2]    ! half the edge of the cube of rays
      real(wp), parameter :: next = 0.1_wp           ! tolerance of the shortest distance [cells]
      integer :: n, number
      real(wp) :: way(most_rays), direction(3, most_rays), shortest

      normal = 0.0_wp
      call rays(grid, around(grid%dimensions), direction, number)
      do n = 1, number
         way(n) = surface_distance(walls, grid, place, direction(:, n))
      end do
      shortest = minval(way(:number))
      found = shortest < huge(shortest)
      if (.not. found) return
      do n = 1, number
         if (way(n) <= shortest + next*grid%spacing) normal = normal + direction(:, n)
      end do
      ! the directions to both sides of a plate cancel in its middle: use the first one
      if (norm2(normal) < 0.5_wp) normal = direction(:, minloc(way(:number), 1))
      normal = normal/norm2(normal)
   end subroutine guess_outward

   !> Distance to the surface along a direction, huge if it is long or leaves the domain [m].
   pure real(wp) function surface_distance(walls, grid, place, direction) result(way)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]
      real(wp), intent(in) :: direction(3)           !! Unit vector [1]
      integer :: step

      do step = 1, paces
         way = pace*grid%spacing*real(step, wp)
         if (closed(walls, grid, place + way*direction)) cycle
         way = surface_on(walls, grid, place, direction, way - pace*grid%spacing, way)
         return
      end do
      way = huge(way)
   end function surface_distance

   !> Distance at which a line leaves the walls, between a point inside and one outside [m].
   pure real(wp) function surface_on(walls, grid, place, direction, inside, outside) result(way)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! Start of the line [m]
      real(wp), intent(in) :: direction(3)           !! Unit vector [1]
      real(wp), intent(in) :: inside, outside        !! Two distances along it [m]
      real(wp) :: low, high
      integer :: n

      low = inside
      high = outside
      do n = 1, halvings
         way = 0.5_wp*(low + high)
         if (closed(walls, grid, place + way*direction)) then
            low = way
         else
            high = way
         end if
      end do
   end function surface_on

   !> Turn a normal with the slopes of the surface where it leaves it.
   pure subroutine improve(walls, grid, place, across, normal, smooth)
      type(wall_t), intent(in) :: walls(:)           !! The rigid regions
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]
      integer, intent(in) :: across                  !! Direction without a slope, 0 = none
      real(wp), intent(inout) :: normal(3)           !! Unit vector [1]
      logical, intent(out) :: smooth                 !! Has the surface slopes there?
      real(wp) :: along(3, 2), foot(3), height(2), reach, way
      integer :: k, side, directions

      smooth = grid%dimensions > 1
      if (.not. smooth) return
      way = surface_distance(walls, grid, place, normal)
      smooth = way < huge(way)
      if (.not. smooth) return
      call tangents(grid, normal, across, along, directions)
      reach = 4.0_wp*aside*grid%spacing
      do k = 1, directions
         do side = 1, 2
            foot = place + way*normal + real(2*side - 3, wp)*aside*grid%spacing*along(:, k)
            smooth = closed(walls, grid, foot - reach*normal) .and. &
               .not. closed(walls, grid, foot + reach*normal)
            if (.not. smooth) return
            height(side) = surface_on(walls, grid, foot, normal, -reach, reach)
         end do
         along(:, k) = (height(2) - height(1))/(2.0_wp*aside*grid%spacing)*along(:, k)
      end do
      do k = 1, directions
         normal = normal - along(:, k)
      end do
      normal = normal/norm2(normal)
   end subroutine improve

   !> Directions at right angles to a normal that the scene has, or of them the one along a face.
   pure subroutine tangents(grid, normal, across, along, directions)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: normal(3)              !! Unit vector [1]
      integer, intent(in) :: across                  !! Direction across the face, 0 = none
      real(wp), intent(out) :: along(3, 2)           !! Unit vector [1]
      integer, intent(out) :: directions             !! Number of directions
      integer :: least

      along = 0.0_wp
      directions = grid%dimensions - 1
      if (directions == 1) then
         along(:, 1) = [-normal(3), 0.0_wp, normal(1)]
         return
      end if
      if (across > 0) then
         directions = 1
         along(1 + mod(across, 3), 1) = -normal(1 + mod(across + 1, 3))
         along(1 + mod(across + 1, 3), 1) = normal(1 + mod(across, 3))
         return
      end if
      least = minloc(abs(normal), 1)
      along(:, 1) = -normal(least)*normal
      along(least, 1) = along(least, 1) + 1.0_wp
      along(:, 1) = along(:, 1)/norm2(along(:, 1))
      along(:, 2) = [normal(2)*along(3, 1) - normal(3)*along(2, 1), normal(3)*along(1, 1) &
         - normal(1)*along(3, 1), normal(1)*along(2, 1) - normal(2)*along(1, 1)]
   end subroutine tangents
end module mesh_surface_normal
