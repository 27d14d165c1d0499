! SPDX-License-Identifier: BSD-3-Clause
!> Bodies that have common nodes at the start, found from the cells that their particles are in.
!!
!! Particles in cells that touch have common nodes, so such bodies have common velocities there.
!! With the dual gradient bodies also act on each other across an empty row of cells.
module particle_joined
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use particle_body, only: belongs, body_t, find_boxes, find_near, site_position, tile_sites
   implicit none
   private

   public :: find_joined, joined_t

   !> Two bodies, and the distance of their cells.
   type :: joined_t
      integer :: one = 0                              !! Index of a body
      integer :: other = 0                            !! Index of a later body
      integer :: distance = 1                         !! 1 = cells touch, 2 = a row between them
   end type joined_t

   !> Tiles that are visited at most for all pairs; further pairs are not examined.
   integer(int64), parameter :: most_tiles = 20000

contains

   !> List the pairs of bodies with the same velocity field whose particles are in cells that touch
   !! or, if the reach is 2, have a row of cells between them.
   subroutine find_joined(grid, bodies, field, reach, joined)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: field(:)                 !! (body) Velocity field
      integer, intent(in) :: reach                    !! Greatest distance of cells
      type(joined_t), allocatable, intent(out) :: joined(:)
      real(wp), allocatable :: low(:, :), high(:, :)
      integer(int64) :: visited
      integer :: one, other, distance

      allocate (joined(0))
      call find_boxes(grid, bodies, low, high)
      visited = 0
      do other = 2, size(bodies)
         do one = 1, other - 1
            if (field(one) /= field(other)) cycle
            call find_distance(grid, bodies, low, high, [one, other], reach, visited, distance)
            if (distance <= reach) joined = [joined, joined_t(one, other, distance)]
            if (visited > most_tiles) return
         end do
      end do
   end subroutine find_joined

   !> Distance of the nearest cells of two bodies, if it is within the reach.
   subroutine find_distance(grid, bodies, low, high, pair, reach, visited, distance)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), contiguous, intent(in) :: low(:, :)   !! (direction, body) Boxes of the bodies [m]
      real(wp), contiguous, intent(in) :: high(:, :)  !! (direction, body) [m]
      integer, intent(in) :: pair(2)                  !! Their indices
      integer, intent(in) :: reach
      integer(int64), intent(inout) :: visited        !! Number of tiles that were visited
      integer, intent(out) :: distance                !! reach + 1 = beyond it
      real(wp) :: bottom(3), top(3)
      integer :: first(3), last(3), x, y, z

      distance = reach + 1
      ! a cell of distance n is less than n + 1 cells away
      bottom = max(low(:, pair(1)), low(:, pair(2))) - real(reach + 1, wp)*grid%spacing
      top = min(high(:, pair(1)), high(:, pair(2))) + real(reach + 1, wp)*grid%spacing
      if (any(grid%active .and. bottom > top)) return
      first = tile_of(grid, bottom)
      last = tile_of(grid, top)
      do z = first(3), last(3)
         do y = first(2), last(2)
            do x = first(1), last(1)
               call compare_tile(grid, bodies, low, high, pair, [x, y, z], visited, distance)
               if (distance <= 1 .or. visited > most_tiles) return
            end do
         end do
      end do
   end subroutine find_distance

   !> Tile of a position, clipped to the domain.
   pure function tile_of(grid, position) result(coordinate)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: position(3)             !! [m]
      integer :: coordinate(3)
      real(wp) :: place(3)

      coordinate = 0
      place = 0.0_wp
      where (grid%active) place = (position - grid%lower)/grid%spacing
      where (grid%active) coordinate = min(int(max(min(place, real(grid%cells, wp)), 0.0_wp)), &
         grid%cells - 1)/grid%width
   end function tile_of

   !> Compare the cells of the first body in a tile with those of the second in it and around it.
   subroutine compare_tile(grid, bodies, low, high, pair, coordinate, visited, distance)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), contiguous, intent(in) :: low(:, :)   !! (direction, body) Boxes of the bodies [m]
      real(wp), contiguous, intent(in) :: high(:, :)  !! (direction, body) [m]
      integer, intent(in) :: pair(2)                  !! Their indices
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer(int64), intent(inout) :: visited !! Tiles visited; one takes longer among many bodies
      integer, intent(inout) :: distance              !! Least so far
      integer, allocatable :: mine(:, :), theirs(:, :)
      integer :: n, x, y, z, beside(3), steps(3)

      visited = visited + 1 + size(bodies)/500
      call list_cells(grid, bodies, low, high, pair(1), coordinate, mine)
      if (size(mine, 2) == 0) return
      steps = merge(1, 0, grid%active)
      do z = -steps(3), steps(3)
         do y = -steps(2), steps(2)
            do x = -steps(1), steps(1)
               beside = coordinate + [x, y, z]
               if (any(beside < 0 .or. beside*grid%width >= grid%cells)) cycle
               call list_cells(grid, bodies, low, high, pair(2), beside, theirs)
               do n = 1, size(theirs, 2)
                  distance = min(distance, least_distance(mine, theirs(1, n), theirs(2, n), &
                     theirs(3, n)))
               end do
               if (distance <= 1) return
            end do
         end do
      end do
   end subroutine compare_tile

   !> Distance of a cell from the nearest one of a list, at least 1.
   pure integer function least_distance(cells, x, y, z) result(distance)
      integer, intent(in) :: cells(:, :)              !! (direction, cell) Counted from 0
      integer, intent(in) :: x, y, z
      integer :: n

      distance = huge(distance)
      do n = 1, size(cells, 2)
         distance = min(distance, max(1, abs(cells(1, n) - x), abs(cells(2, n) - y), &
            abs(cells(3, n) - z)))
      end do
   end function least_distance

   !> List the cells of a tile in which a body has particles.
   subroutine list_cells(grid, bodies, low, high, body, coordinate, cells)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), contiguous, intent(in) :: low(:, :)   !! (direction, body) Boxes of the bodies [m]
      real(wp), contiguous, intent(in) :: high(:, :)  !! (direction, body) [m]
      integer, intent(in) :: body                     !! Its index
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer, allocatable, intent(out) :: cells(:, :) !! (direction, cell) Counted from 0
      real(wp), allocatable :: position(:, :)
      integer :: near(size(bodies)), number, place, n, cell(3)
      logical :: used(0:grid%width(1), 0:grid%width(2), 0:grid%width(3))

      used = .false.
      call find_near(grid, low, high, coordinate, near, number)
      place = findloc(near(:number), body, 1)
      if (place > 0) then
         call list_sites(grid, bodies(body), coordinate, position)
         do n = 1, size(position, 2)
            if (.not. belongs(bodies, body, position(:, n), near(place + 1:number))) cycle
            cell = 0
            where (grid%active) cell = min(max(floor((position(:, n) - grid%lower)/grid%spacing) &
               - coordinate*grid%width, 0), grid%width)
            used(cell(1), cell(2), cell(3)) = .true.
         end do
      end if
      allocate (cells(3, count(used)))
      number = 0
      do n = 0, size(used) - 1
         cell = [modulo(n, size(used, 1)), modulo(n/size(used, 1), size(used, 2)), &
            n/(size(used, 1)*size(used, 2))]
         if (.not. used(cell(1), cell(2), cell(3))) cycle
         number = number + 1
         cells(:, number) = coordinate*grid%width + cell
      end do
   end subroutine list_cells

   !> List the positions in a tile at which a body has particles if it contains them.
   subroutine list_sites(grid, body, coordinate, position)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      real(wp), allocatable, intent(out) :: position(:, :) !! (direction, site) [m]
      real(wp), allocatable :: volume(:)
      integer(int64), allocatable :: identity(:)
      integer :: n, x, y, z, sites(3)

      if (allocated(body%given)) then
         call body%given%collect(grid, coordinate, position, volume, identity)
         return
      end if
      sites = tile_sites(grid, body, coordinate)
      allocate (position(3, product(sites)))
      n = 0
      do z = 0, sites(3) - 1
         do y = 0, sites(2) - 1
            do x = 0, sites(1) - 1
               n = n + 1
               position(:, n) = site_position(grid, body, coordinate, [x, y, z])
            end do
         end do
      end do
   end subroutine list_sites
end module particle_joined
