! SPDX-License-Identifier: BSD-3-Clause
!> Solids whose surface is given by triangles.
!!
!! A point is inside if the winding number of the surface around it is not 0: the signed crossings
!! of a ray from the point along z are counted. Corners are rounded to an integer lattice and all
!! side tests are exact, with more than 64 bits where needed. A ray through an edge or a corner is
!! shifted by an infinitesimal, so no crossing is lost or counted twice (simulation of simplicity,
!! H. Edelsbrunner and E. P. Mücke, ACM Trans. Graph. 9 (1990) 66). A grid over x and y finds the
!! facets above a point.
module particle_facets
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use mesh_hash_table, only: key_table_t
   use particle_shape, only: shape_t, transform_point
   implicit none
   private

   public :: facets_t, set_facets

   integer, parameter :: most_columns = 512 !! Largest number of columns of the grid along x or y
   integer(int64), parameter :: ticks = 2_int64**28      !! Lattice points along the longest edge

   !> A solid.
   type, extends(shape_t) :: facets_t
      real(wp), allocatable :: corner(:, :, :)           !! (3, corner, facet) As read [m]
      integer(int64), allocatable, private :: lattice(:, :, :) !! (3, corner, facet) Rounded corners
      real(wp), private :: lower(3) = 0.0_wp             !! Lower corner of the lattice [m]
      real(wp), private :: upper(3) = -1.0_wp            !! Upper corner of the facets [m]
      real(wp), private :: step = 1.0_wp                 !! Lattice constant [m]
      integer, private :: columns(2) = 1 !! Numbers of columns of the grid along x and y
      integer, allocatable, private :: first(:)          !! (column) First entry of its list
      integer, allocatable, private :: list(:)           !! Facets over each column
   contains
      procedure :: contains => facets_contains           !! True for a point inside
      procedure :: bounds => facets_bounds               !! Bounding box
      procedure :: transform => facets_transform         !! Scale, rotate and translate
      procedure :: volume => facets_volume               !! Volume that the facets enclose
      procedure :: faults => facets_faults               !! Defects of the surface
      procedure, private :: prepare => facets_prepare    !! Lattice and grid
   end type facets_t

contains

   !> Make a solid from the corners of its facets, counterclockwise as seen from outside.
   pure subroutine set_facets(shape, corner)
      type(facets_t), intent(out) :: shape
      real(wp), intent(in) :: corner(:, :, :)            !! (3, corner, facet) [m]

      allocate (shape%corner(3, 3, size(corner, 3)))
      shape%corner(:, :, :) = corner
      call shape%prepare()
   end subroutine set_facets

   !> Round the corners to lattice positions and list the facets of each column of the grid.
   pure subroutine facets_prepare(self)
      class(facets_t), intent(inout) :: self             !! Corners are set
      integer, allocatable :: filled(:)
      integer :: facet, from(2), to(2), k, x, y, column, pass

      if (size(self%corner, 3) == 0) return
      do k = 1, 3
         self%lower(k) = minval(self%corner(k, :, :))
         self%upper(k) = maxval(self%corner(k, :, :))
      end do
      self%step = max(maxval(self%upper - self%lower), tiny(1.0_wp))/real(ticks, wp)
      if (allocated(self%lattice)) deallocate (self%lattice)
      allocate (self%lattice(3, 3, size(self%corner, 3)))
      do k = 1, 3
         self%lattice(k, :, :) = nint((self%corner(k, :, :) - self%lower(k))/self%step, int64)
      end do
      self%columns = max(min(int(sqrt(real(size(self%corner, 3), wp))), most_columns), 1)
      if (allocated(self%first)) deallocate (self%first)
      allocate (self%first(product(self%columns) + 1), filled(product(self%columns)))
      filled = 0
      do pass = 1, 2
         do facet = 1, size(self%corner, 3)
            do k = 1, 2
               from(k) = column_of(self, k, minval(self%lattice(k, :, facet)))
               to(k) = column_of(self, k, maxval(self%lattice(k, :, facet)))
            end do
            do y = from(2), to(2)
               do x = from(1), to(1)
                  column = 1 + x + self%columns(1)*y
                  if (pass == 2) self%list(self%first(column) + filled(column)) = facet
                  filled(column) = filled(column) + 1
               end do
            end do
         end do
         if (pass == 2) exit
         self%first(1) = 1
         do column = 1, size(filled)
            self%first(column + 1) = self%first(column) + filled(column)
         end do
         if (allocated(self%list)) deallocate (self%list)
         allocate (self%list(sum(filled)))
         filled = 0
      end do
   end subroutine facets_prepare

   !> Column of a lattice coordinate along x or y, from 0.
   pure integer function column_of(self, direction, place) result(column)
      class(facets_t), intent(in) :: self
      integer, intent(in) :: direction                   !! 1 or 2
      integer(int64), intent(in) :: place                !! Lattice coordinate

      column = int(min(max(place*self%columns(direction)/(ticks + 1), 0_int64), &
         int(self%columns(direction) - 1, int64)))
   end function column_of

   !> True if a point is inside the solid.
   pure recursive logical function facets_contains(self, x) result(inside)
      class(facets_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                       !! Point [m]
      integer(int64) :: point(3)
      integer :: column, entry, winding

      inside = .false.
      if (any(x < self%lower) .or. any(x > self%upper)) return
      point = nint((x - self%lower)/self%step, int64)
      column = 1 + column_of(self, 1, point(1)) + self%columns(1)*column_of(self, 2, point(2))
      winding = 0
      do entry = self%first(column), self%first(column + 1) - 1
         winding = winding + crossing(self%lattice(:, :, self%list(entry)), point)
      end do
      inside = winding /= 0
   end function facets_contains

   !> Sign of the crossing of a facet by the ray upwards from a point, 0 without a crossing.
   pure integer function crossing(corner, point) result(sign_of_it)
      integer(int64), intent(in) :: corner(3, 3)         !! (3, corner) On the lattice
      integer(int64), intent(in) :: point(3)             !! Origin of the ray
      integer :: side(3), k

      sign_of_it = 0
      if (maxval(corner(3, :)) < point(3)) return
      do k = 1, 3
         side(k) = side_of(corner(1:2, k), corner(1:2, 1 + mod(k, 3)), point(1:2))
      end do
      if (side(1) /= side(2) .or. side(2) /= side(3)) return
      if (above(corner, point, side(1))) sign_of_it = side(1)
   end function crossing

   !> Side of an edge, seen from above, on which a point lies: 1 left, -1 right. A point on the edge
   !! counts as shifted by an infinitesimal along x and by one of higher order along y.
   pure integer function side_of(from, to, point) result(side)
      integer(int64), intent(in) :: from(2)              !! Start of the edge
      integer(int64), intent(in) :: to(2)                !! End of the edge
      integer(int64), intent(in) :: point(2)
      integer(int64) :: edge(2), turn

      edge = to - from
      turn = edge(1)*(point(2) - from(2)) - edge(2)*(point(1) - from(1))
      if (turn == 0) turn = -edge(2)
      if (turn == 0) turn = edge(1)
      side = int(sign(1_int64, turn))
      if (turn == 0) side = 0
   end function side_of

   !> True if a facet lies above a point that it covers. A facet through the point does not count,
   !! so solids are closed below and open above. The products have up to 87 bits and are computed in
   !! two parts.
   pure logical function above(corner, point, side) result(higher)
      integer(int64), intent(in) :: corner(3, 3)         !! (3, corner) On the lattice
      integer(int64), intent(in) :: point(3)
      integer, intent(in) :: side                        !! 1 if the facet is counterclockwise
      integer, parameter :: split = 25
      integer(int64), parameter :: half = 2_int64**split
      integer(int64) :: a(3), b(3), normal(3), offset(3), high, low
      integer :: k

      a = corner(:, 2) - corner(:, 1)
      b = corner(:, 3) - corner(:, 1)
      normal = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
      offset = corner(:, 1) - point
      ! normal times offset over normal(3), whose sign is `side`, is the height of the facet
      high = 0
      low = 0
      do k = 1, 3
         high = high + (shifta(normal(k), split))*offset(k)
         low = low + iand(normal(k), half - 1)*offset(k)
      end do
      high = high + shifta(low, split)
      low = iand(low, half - 1)
      if (side > 0) then
         higher = high > 0 .or. (high == 0 .and. low > 0)
      else
         higher = high < 0
      end if
   end function above

   !> A box around the solid.
   pure recursive subroutine facets_bounds(self, lo, hi)
      class(facets_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)              !! Corners [m]

      lo = self%lower
      hi = self%upper
   end subroutine facets_bounds

   !> Scale, turn and move the solid.
   pure recursive subroutine facets_transform(self, scale, rotation, translate)
      class(facets_t), intent(inout) :: self
      real(wp), intent(in) :: scale                      !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)             !! Orthogonal [1]
      real(wp), intent(in) :: translate(3)               !! Displacement [m]
      integer :: facet, k

      do facet = 1, size(self%corner, 3)
         do k = 1, 3
            call transform_point(scale, rotation, translate, self%corner(:, k, facet))
         end do
      end do
      call self%prepare()
   end subroutine facets_transform

   !> Volume that the facets enclose, negative if they face inwards [m3].
   pure real(wp) function facets_volume(self) result(volume)
      class(facets_t), intent(in) :: self
      real(wp) :: a(3), b(3), c(3)
      integer :: facet

      volume = 0.0_wp
      do facet = 1, size(self%corner, 3)
         a = self%corner(:, 1, facet) - self%lower
         b = self%corner(:, 2, facet) - self%lower
         c = self%corner(:, 3, facet) - self%lower
         volume = volume + (a(1)*(b(2)*c(3) - b(3)*c(2)) + a(2)*(b(3)*c(1) - b(1)*c(3)) &
            + a(3)*(b(1)*c(2) - b(2)*c(1)))/6.0_wp
      end do
   end function facets_volume

   !> Defects of the surface: edges with one facet, edges whose two facets have opposite
   !! orientations, edges with more than two facets, and facets without an area.
   pure subroutine facets_faults(self, open_edges, turned_edges, crowded_edges, flat)
      class(facets_t), intent(in) :: self
      integer, intent(out) :: open_edges                 !! Edges with one facet
      integer, intent(out) :: turned_edges               !! Edges between opposite orientations
      integer, intent(out) :: crowded_edges              !! Solids that touch, or duplicate facets
      integer, intent(out) :: flat                       !! Facets with two equal corners
      integer(int64), parameter :: base = 2_int64**31
      integer(int64), allocatable :: key(:)
      integer, allocatable :: vertex(:, :), order(:), way(:)
      integer :: facet, k, edges, first, last

      call number_corners(self%lattice, vertex)
      allocate (key(size(vertex)), way(size(vertex)))
      edges = 0
      flat = 0
      do facet = 1, size(vertex, 2)
         if (vertex(1, facet) == vertex(2, facet) .or. vertex(2, facet) == vertex(3, facet) .or. &
            vertex(3, facet) == vertex(1, facet)) then
            flat = flat + 1
            cycle
         end if
         do k = 1, 3
            associate (from => vertex(k, facet), to => vertex(1 + mod(k, 3), facet))
               edges = edges + 1
               key(edges) = min(from, to)*base + max(from, to)
               way(edges) = merge(1, -1, from < to)
            end associate
         end do
      end do
      order = sort_order(key(:edges))
      open_edges = 0
      turned_edges = 0
      crowded_edges = 0
      first = 1
      do while (first <= edges)
         last = first
         do while (last < edges)
            if (key(order(last + 1)) /= key(order(first))) exit
            last = last + 1
         end do
         if (last == first) then
            open_edges = open_edges + 1
         else if (last > first + 1) then
            crowded_edges = crowded_edges + 1
         else if (way(order(first)) == way(order(last))) then
            turned_edges = turned_edges + 1
         end if
         first = last + 1
      end do
   end subroutine facets_faults

   !> Number the corners; corners at the same lattice position have the same number.
   pure subroutine number_corners(place, vertex)
      integer(int64), intent(in) :: place(:, :, :)       !! (3, corner, facet)
      integer, allocatable, intent(out) :: vertex(:, :)  !! (corner, facet) From 1
      type(key_table_t) :: columns, corners
      integer(int64) :: key
      integer :: facet, k, column, number

      allocate (vertex(3, size(place, 3)))
      call columns%clear(2*size(vertex))
      call corners%clear(2*size(vertex))
      do facet = 1, size(place, 3)
         do k = 1, 3
            key = place(1, k, facet) + 2*ticks*place(2, k, facet)
            column = columns%find(key)
            if (column == 0) then
               column = columns%count() + 1
               call columns%insert(key, column)
            end if
            key = place(3, k, facet) + 2*ticks*column
            number = corners%find(key)
            if (number == 0) then
               number = corners%count() + 1
               call corners%insert(key, number)
            end if
            vertex(k, facet) = number
         end do
      end do
   end subroutine number_corners
end module particle_facets
