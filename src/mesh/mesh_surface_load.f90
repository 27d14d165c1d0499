! SPDX-License-Identifier: BSD-3-Clause
!> Loads on surfaces: pressures and tractions that act where the surface of a body is in a region.
!!
!! No surface is built. A stress T with T n = t on the surface, times a function f that is 1 in the
!! region and falls to 0 within a cell around it, gives the nodes the force of equation (O.3) of
!! doc/theory/instruments.md: Gauss's theorem turns the integral of t over the surface into one over
!! the body, so the load follows the surface as the body moves. Virtual stress after J. Liang and
!! others, Comput. Methods Appl. Mech. Eng. 410 (2023) 116048.
!!
!! The function is part of the material unless the deck says otherwise: particles store f and its
!! gradient, which are those of the region at the start and follow the deformation.
module mesh_surface_load
   use base_constants, only: xx, xy, xz, yy, yz, zz
   use base_elementary, only: cross
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t, lanes
   use mesh_motion, only: motion_t
   use mesh_point_set, only: point_set_t
   use mesh_wall, only: node_place
   implicit none
   private

   public :: add_loads, hold_t, mark_tile, surface_load_t, set_loads, turn_marks

   integer, parameter, public :: mark_columns = 4    !! Of f and its gradient, for each load

   !> What keeps the resultants of a load on a closed surface at zero: the force density
   !! |grad f| (a + b x (x - c)). Equation (O.5) of doc/theory/instruments.md.
   type :: hold_t
      logical :: closed = .false.                    !! Has the load no resultants at the start?
      real(wp) :: push(3) = 0.0_wp                   !! a, at a factor of 1 [Pa]
      real(wp) :: turn(3) = 0.0_wp                   !! b, at a factor of 1 [Pa/m]
      real(wp) :: centre(3) = 0.0_wp                 !! c [m]
   end type hold_t

   !> A load.
   type :: surface_load_t
      character(len=:), allocatable :: name          !! For messages
      real(wp) :: stress(6) = 0.0_wp                 !! Stress tensor at a factor of 1 [Pa]
      real(wp) :: factor = 1.0_wp                    !! Factor of this step [1]
      type(motion_t), allocatable :: course          !! Factor over time in its first component
      class(point_set_t), allocatable :: region      !! Where it acts, if not everywhere
      !> Its place among the loads whose function is stored by the particles, 0 = the region is
      !! fixed in space
      integer :: slot = 0
      integer(int64) :: region_key = 0               !! Hash of the region, to compare at a restart
      !> Hash of region, bodies and direction of the stress, to compare at a restart
      integer(int64) :: surface_key = 0
      type(hold_t) :: hold                           !! Of a load on a closed surface
      integer(int64), allocatable :: bodies(:)       !! Bodies on which the load acts, if not on all
   end type surface_load_t

contains

   !> Set the factors of all loads: means over the time in which the forces of a step act.
   pure subroutine set_loads(loads, from, length)
      type(surface_load_t), intent(inout) :: loads(:)
      real(wp), intent(in) :: from                   !! Begin of that time [s]
      real(wp), intent(in) :: length                 !! Length of the time span, 0 = an instant [s]
      real(wp) :: value(3)
      integer :: n

      do n = 1, size(loads)
         if (.not. allocated(loads(n)%course)) cycle
         if (length > 0.0_wp) then
            value = loads(n)%course%mean(from, length)
         else
            value = loads(n)%course%velocity(from)
         end if
         loads(n)%factor = value(1)
      end do
   end subroutine set_loads

   !> Stress f T and force density T grad f of all loads at the particles of a tile.
   pure subroutine add_loads(loads, grid, coordinate, first, count, position, body, marks, &
      stress, force)
      type(surface_load_t), intent(in) :: loads(:)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: first                   !! First particle of the tile in the arrays
      integer, intent(in) :: count                   !! Particles of the tile
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) [m]
      !> (particle) Its body; not allocated if there is one body
      integer(int64), allocatable, intent(in) :: body(:)
      !> (particle, 4 slots) f and its gradient for each slot; not allocated if no load has a slot
      real(wp), allocatable, intent(in) :: marks(:, :)
      real(wp), intent(out) :: stress(:, :)          !! (particle of the tile, 6) [Pa]
      real(wp), intent(out) :: force(:, :)           !! (particle of the tile, 3) [N/m3]
      real(wp) :: inside(grid%tile_nodes), point(3), share, slope(3), tensor(6)
      integer :: n, p, q, k

      stress(:count, :) = 0.0_wp
      force(:count, :) = 0.0_wp
      do n = 1, size(loads)
         if (.not. abs(loads(n)%factor) > 0.0_wp) cycle
         tensor = loads(n)%factor*loads(n)%stress
         if (in_space(loads(n))) then
            call mark_nodes(loads(n)%region, grid, coordinate, inside)
            if (.not. any(inside > 0.0_wp)) cycle
         end if
         share = 1.0_wp
         slope = 0.0_wp
         do p = 1, count
            q = first + p - 1
            if (allocated(loads(n)%bodies) .and. allocated(body)) then
               if (all(loads(n)%bodies /= body(q))) cycle
            end if
            if (in_space(loads(n))) then
               point = [position(q, 1), position(q, 2), position(q, 3)]
               call interpolate(grid, coordinate, inside, point, share, slope)
            else if (allocated(loads(n)%region)) then
               k = mark_columns*(loads(n)%slot - 1) + 1
               share = marks(q, k)
               slope = [marks(q, k + 1), marks(q, k + 2), marks(q, k + 3)]
            end if
            do k = 1, 6
               stress(p, k) = stress(p, k) + share*tensor(k)
            end do
            force(p, 1) = force(p, 1) + tensor(xx)*slope(1) + tensor(xy)*slope(2) &
               + tensor(xz)*slope(3)
            force(p, 2) = force(p, 2) + tensor(xy)*slope(1) + tensor(yy)*slope(2) &
               + tensor(yz)*slope(3)
            force(p, 3) = force(p, 3) + tensor(xz)*slope(1) + tensor(yz)*slope(2) &
               + tensor(zz)*slope(3)
            if (loads(n)%hold%closed) then
               point = [position(q, 1), position(q, 2), position(q, 3)] - loads(n)%hold%centre
               point = loads(n)%hold%push + cross(loads(n)%hold%turn, point)
               force(p, :) = force(p, :) + loads(n)%factor*norm2(slope)*point
            end if
         end do
      end do
   end subroutine add_loads

   !> Is the function f of a load that of a region that is fixed in space?
   pure logical function in_space(load) result(yes)
      type(surface_load_t), intent(in) :: load

      yes = allocated(load%region) .and. load%slot == 0
   end function in_space

   !> Set f and its gradient at the particles of a tile from the regions of the loads.
   pure subroutine mark_tile(loads, grid, coordinate, first, count, position, marks)
      type(surface_load_t), intent(in) :: loads(:)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: first                   !! First particle of the tile in the arrays
      integer, intent(in) :: count                   !! Particles of the tile
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) [m]
      real(wp), contiguous, intent(inout) :: marks(:, :) !! (particle, 4 slots)
      real(wp) :: inside(grid%tile_nodes), point(3), slope(3)
      integer :: n, q, k

      do n = 1, size(loads)
         if (loads(n)%slot == 0) cycle
         call mark_nodes(loads(n)%region, grid, coordinate, inside)
         k = mark_columns*(loads(n)%slot - 1) + 1
         do q = first, first + count - 1
            point = [position(q, 1), position(q, 2), position(q, 3)]
            call interpolate(grid, coordinate, inside, point, marks(q, k), slope)
            marks(q, k + 1:k + 3) = slope
         end do
      end do
   end subroutine mark_tile

   !> Transform the gradients with the deformation of a step: g <- (1 + G^T)^-1 g with the gradient
   !! G of the displacement in it, the mean of the particles of the cell, so that g.dx of
   !! neighbouring particles does not change. Equation (O.4) of doc/theory/instruments.md.
   pure subroutine turn_marks(start, first, gradient, marks)
      integer, intent(in) :: start(0:)               !! (cell) Particles in the cells up to it
      integer, intent(in) :: first                   !! First particle of the tile in the arrays
      !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1) [1]
      real(wp), contiguous, intent(in) :: gradient(:, :)
      real(wp), contiguous, intent(inout) :: marks(:, :) !! (particle, 4 slots)
      real(wp) :: mean(9), normal(3, 3), ratio
      integer :: cell, low, high, k

      do cell = 1, ubound(start, 1)
         low = start(cell - 1) + 1
         high = start(cell)
         if (high < low) cycle
         if (all(abs(marks(first + low - 1:first + high - 1, :)) <= 0.0_wp)) cycle
         do k = 1, 9
            mean(k) = sum(gradient(low:high, k))/real(high - low + 1, wp)
         end do
         call invert(mean, normal, ratio)
         if (.not. ratio > 0.0_wp) cycle
         call turn_cell(normal, first + low - 1, first + high - 1, marks)
      end do
   end subroutine turn_marks

   !> (1 + G^T)^-1 and the determinant.
   pure subroutine invert(gradient, inverse, ratio)
      real(wp), intent(in) :: gradient(9)            !! Component (k, l) in k + 3 (l - 1) [1]
      real(wp), intent(out) :: inverse(3, 3)         !! Only if the determinant is positive [1]
      real(wp), intent(out) :: ratio                 !! Determinant of 1 + G [1]
      real(wp) :: map(3, 3)
      integer :: k

      map = reshape(gradient, [3, 3])
      do k = 1, 3
         map(k, k) = map(k, k) + 1.0_wp
      end do
      inverse(:, 1) = cross(map(:, 2), map(:, 3))
      inverse(:, 2) = cross(map(:, 3), map(:, 1))
      inverse(:, 3) = cross(map(:, 1), map(:, 2))
      ratio = dot_product(map(:, 1), inverse(:, 1))
      if (ratio > 0.0_wp) inverse = inverse/ratio
   end subroutine invert

   !> Transform the gradients of the particles of a cell.
   pure subroutine turn_cell(normal, low, high, marks)
      real(wp), intent(in) :: normal(3, 3)           !! (1 + G^T)^-1 [1]
      integer, intent(in) :: low, high               !! First and last particle in the arrays
      real(wp), contiguous, intent(inout) :: marks(:, :) !! (particle, 4 slots)
      real(wp) :: slope(3)
      integer :: q, k

      do k = 2, size(marks, 2), mark_columns
         do q = low, high
            slope = [marks(q, k), marks(q, k + 1), marks(q, k + 2)]
            marks(q, k:k + 2) = normal(:, 1)*slope(1) + normal(:, 2)*slope(2) &
               + normal(:, 3)*slope(3)
         end do
      end do
   end subroutine turn_cell

   !> The function f at the nodes of a tile: 1 in the region, else 0.
   pure subroutine mark_nodes(region, grid, coordinate, inside)
      class(point_set_t), intent(in) :: region
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(out) :: inside(:)             !! (node)
      real(wp) :: low(3), high(3), corner(3), edge(3)
      integer :: node

      inside = 0.0_wp
      call region%bounds(low, high)
      corner = grid%tile_corner(coordinate)
      edge = real(grid%width, wp)*grid%spacing
      if (any(grid%active .and. (corner > high .or. corner + edge < low))) return
      do node = 1, grid%tile_nodes
         if (region%contains(node_place(grid, coordinate, node))) inside(node) = 1.0_wp
      end do
   end subroutine mark_nodes

   !> The linear function between the nodes and its gradient at a point of a tile.
   pure subroutine interpolate(grid, coordinate, inside, point, share, slope)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(in) :: inside(:)              !! (node) Its values
      real(wp), intent(in) :: point(3)               !! [m]
      real(wp), intent(out) :: share                 !! The function [1]
      real(wp), intent(out) :: slope(3)              !! Gradient [1/m]
      real(wp) :: place(3), weight(3), corner(3)
      integer :: cell(3), k, lane, node

      corner = grid%tile_corner(coordinate)
      place = merge((point - corner)/grid%spacing, 0.0_wp, grid%active)
      cell = min(max(floor(place), 0), grid%width - 1)
      place = place - real(cell, wp)
      share = 0.0_wp
      slope = 0.0_wp
      do lane = 1, lanes
         weight = grid%lane_constant(lane, :) + grid%lane_slope(lane, :)*place
         node = 1 + dot_product(cell + merge(grid%margin, 0, grid%active), grid%stride) &
            + grid%lane_offset(lane)
         if (.not. inside(node) > 0.0_wp) cycle
         share = share + inside(node)*product(weight)
         do k = 1, 3
            slope(k) = slope(k) + inside(node)*grid%lane_slope(lane, k)/grid%spacing &
               *product(weight, mask=[1, 2, 3] /= k)
         end do
      end do
   end subroutine interpolate
end module mesh_surface_load
