! SPDX-License-Identifier: BSD-3-Clause
!> The surface of a set of points as triangles, in a plane as segments, along a line as points.
!!
!! A lattice is laid over the set and each of its cells is split into simplices (H. W. Kuhn, IBM J.
!! Res. Dev. 4 (1960) 518). Edges with one end inside are bisected, so the corners of the facets are
!! on the surface to rounding; edges and corners of the set are cut off by less than a lattice cell.
module mesh_surface_cut
   use base_kinds, only: wp
   use mesh_point_set, only: point_set_t
   implicit none
   private

   public :: cut_surface

   integer, parameter :: halvings = 40 !! Number of halvings of an edge: below rounding of positions
   real(wp), parameter :: most_points = 2.0e6_wp      !! Points of the lattice, at most
   real(wp), parameter :: parts = 16.0_wp             !! Least number of steps across a set
   !> Steps of the lattice before the set: surfaces that follow the lattice give flat facets
   real(wp), parameter :: offset = 0.6180339887_wp

   !> The set whose surface is found.
   type :: lattice_t
      logical :: active(3) = .true.                  !! Active directions
      real(wp) :: lower(3) = 0.0_wp                  !! Corner of the bounds [m]
      real(wp) :: upper(3) = 0.0_wp                  !! The other corner [m]
      real(wp) :: origin(3) = 0.0_wp                 !! First point of the lattice [m]
      real(wp) :: step(3) = 0.0_wp                   !! Distance of its points [m]
      integer :: last(3) = 0                         !! Index of the last point
   end type lattice_t

contains

   !> Facets of the surface of a set inside a box. None if the set and the box do not overlap.
   pure subroutine cut_surface(set, lower, upper, active, spacing, piece)
      class(point_set_t), intent(in) :: set
      real(wp), intent(in) :: lower(3)               !! Corner of the box [m]
      real(wp), intent(in) :: upper(3) !! The other; the same along inactive directions [m]
      logical, intent(in) :: active(3)               !! Active directions
      real(wp), intent(in) :: spacing                !! Greatest step of the lattice [m]
      real(wp), allocatable, intent(out) :: piece(:, :, :) !! (3, corner, piece) Its corners [m]
      type(lattice_t) :: lattice
      logical, allocatable :: inside(:, :, :)
      real(wp), allocatable :: shorter(:, :, :)
      real(wp) :: low(3), high(3), x(3)
      integer :: directions, found, i, j, k

      directions = count(active)
      allocate (piece(3, directions, 64))
      found = 0
      call set%bounds(low, high)
      low = max(low, lower)
      high = min(high, upper)
      if (all(low <= high .or. .not. active)) then
         call lay(lattice, low, high, active, spacing)
         lattice%lower = lower
         lattice%upper = upper
         allocate (inside(0:lattice%last(1), 0:lattice%last(2), 0:lattice%last(3)))
         do k = 0, lattice%last(3)
            do j = 0, lattice%last(2)
               do i = 0, lattice%last(1)
                  x = place_of(lattice, [i, j, k])
                  inside(i, j, k) = holds(set, lattice, x)
               end do
            end do
         end do
         do k = 0, max(lattice%last(3) - 1, 0)
            do j = 0, max(lattice%last(2) - 1, 0)
               do i = 0, max(lattice%last(1) - 1, 0)
                  call cut_cell(set, lattice, inside, [i, j, k], piece, found)
               end do
            end do
         end do
      end if
      allocate (shorter(3, directions, found))
      shorter(:, :, :) = piece(:, :, :found)
      call move_alloc(shorter, piece)
   end subroutine cut_surface

   !> A lattice around a box, one step wider on each side.
   pure subroutine lay(lattice, low, high, active, spacing)
      type(lattice_t), intent(inout) :: lattice
      real(wp), intent(in) :: low(3)                 !! Corner of the box [m]
      real(wp), intent(in) :: high(3)                !! The other corner [m]
      logical, intent(in) :: active(3)               !! Active directions
      real(wp), intent(in) :: spacing                !! Greatest step [m]
      real(wp) :: number

      lattice%active = active
      lattice%step = max(min(spacing, (high - low)/parts), 1.0e-6_wp*spacing)
      number = product(max((high - low)/lattice%step, 1.0_wp), mask=active)
      if (number > most_points) lattice%step = lattice%step &
         *(number/most_points)**(1.0_wp/real(count(active), wp))
      lattice%origin = low
      where (active)
         lattice%last = ceiling((high - low)/lattice%step) + 2
         lattice%origin = low - offset*lattice%step
      end where
   end subroutine lay

   !> A point of the lattice, the same bits for all cells around it [m].
   pure function place_of(lattice, index) result(place)
      type(lattice_t), intent(in) :: lattice
      integer, intent(in) :: index(3)                !! Index of the point, from 0
      real(wp) :: place(3)

      place = lattice%origin
      where (lattice%active) place = place + lattice%step*real(index, wp)
   end function place_of

   !> True if a point is inside the set and the box.
   pure logical function holds(set, lattice, x) result(inside)
      class(point_set_t), intent(in) :: set
      type(lattice_t), intent(in) :: lattice         !! Has the box
      real(wp), intent(in) :: x(3)                   !! [m]

      inside = all((x >= lattice%lower .and. x <= lattice%upper) .or. .not. lattice%active)
      if (inside) inside = set%contains(x)
   end function holds

   !> Cut the simplices of a cell.
   pure subroutine cut_cell(set, lattice, inside, cell, piece, found)
      class(point_set_t), intent(in) :: set
      type(lattice_t), intent(in) :: lattice
      logical, intent(in) :: inside(0:, 0:, 0:)      !! Its points inside the set
      integer, intent(in) :: cell(3)                 !! First point of the cell
      real(wp), allocatable, intent(inout) :: piece(:, :, :) !! Extended
      integer, intent(inout) :: found                !! Number of facets in it
      integer, parameter :: orders(3, 6) = reshape([1, 2, 3, 1, 3, 2, 2, 1, 3, 2, 3, 1, 3, 1, 2, &
         3, 2, 1], [3, 6])
      integer :: corner(3, 0:3), n, number, order
      logical :: within(0:3)

      associate (reach => cell + merge(1, 0, lattice%active))
         associate (part => inside(cell(1):reach(1), cell(2):reach(2), cell(3):reach(3)))
            if (all(part) .or. .not. any(part)) return
         end associate
      end associate
      do order = 1, size(orders, 2)
         if (.not. in_order(orders(:, order), lattice%active)) cycle
         corner(:, 0) = cell
         number = 0
         do n = 1, 3
            if (.not. lattice%active(orders(n, order))) cycle
            number = number + 1
            corner(:, number) = corner(:, number - 1)
            corner(orders(n, order), number) = corner(orders(n, order), number) + 1
         end do
         do n = 0, number
            within(n) = inside(corner(1, n), corner(2, n), corner(3, n))
         end do
         call cut_simplex(set, lattice, corner(:, :number), within(:number), piece, found)
      end do
   end subroutine cut_cell

   !> True for one of the permutations of the directions that differ only in inactive ones: that in
   !! which the inactive directions come last, in ascending order.
   pure logical function in_order(order, active) result(counts)
      integer, intent(in) :: order(3)                !! A permutation of 1, 2, 3
      logical, intent(in) :: active(3)               !! Active directions
      integer :: n

      counts = .true.
      do n = 1, 2
         if (active(order(n))) cycle
         counts = counts .and. .not. active(order(n + 1)) .and. order(n) < order(n + 1)
      end do
   end function in_order

   !> The facet of the surface in a simplex, two facets if the cut of a tetrahedron is a quadrangle.
   pure subroutine cut_simplex(set, lattice, corner, within, piece, found)
      class(point_set_t), intent(in) :: set
      type(lattice_t), intent(in) :: lattice
      integer, contiguous, intent(in) :: corner(:, 0:) !! (3, corner) Its points
      logical, intent(in) :: within(0:)              !! Points inside the set
      real(wp), allocatable, intent(inout) :: piece(:, :, :) !! Extended
      integer, intent(inout) :: found                !! Number of facets in it
      real(wp) :: cut(3, 4), inner(3), outer(3)
      integer :: a, b, number

      number = 0
      do a = 0, ubound(corner, 2)
         do b = 0, ubound(corner, 2)
            if (.not. within(a) .or. within(b)) cycle
            number = number + 1
            inner = place_of(lattice, corner(:, a))
            outer = place_of(lattice, corner(:, b))
            cut(:, number) = crossing(set, lattice, inner, outer)
         end do
      end do
      if (number < count(lattice%active)) return
      call append(cut(:, :size(piece, 2)), piece, found)
      ! the four cuts come in the order of two pairs with an inner corner each
      if (number == 4) call append(cut(:, 2:4), piece, found)
   end subroutine cut_simplex

   !> Where an edge leaves the set [m].
   pure function crossing(set, lattice, from, until) result(place)
      class(point_set_t), intent(in) :: set
      type(lattice_t), intent(in) :: lattice         !! Has the box
      real(wp), intent(in) :: from(3)                !! An end inside [m]
      real(wp), intent(in) :: until(3)               !! An end outside [m]
      real(wp) :: place(3), inner(3), outer(3)
      integer :: n

      inner = from
      outer = until
      do n = 1, halvings
         place = 0.5_wp*(inner + outer)
         if (holds(set, lattice, place)) then
            inner = place
         else
            outer = place
         end if
      end do
      place = 0.5_wp*(inner + outer)
   end function crossing

   !> Add a piece.
   pure subroutine append(corner, piece, found)
      real(wp), intent(in) :: corner(:, :)           !! (3, corner) [m]
      real(wp), allocatable, intent(inout) :: piece(:, :, :) !! Extended
      integer, intent(inout) :: found                !! Number of facets in it
      real(wp), allocatable :: longer(:, :, :)

      if (found == size(piece, 3)) then
         allocate (longer(3, size(piece, 2), 2*found))
         longer(:, :, :found) = piece
         call move_alloc(longer, piece)
      end if
      found = found + 1
      piece(:, :, found) = corner
   end subroutine append
end module mesh_surface_cut
