! SPDX-License-Identifier: BSD-3-Clause
!> Loads on closed surfaces, such as a pressure in a bore: their force and moment are zero.
!!
!! On the initial lattice the sums over particles are exactly zero. Later the gradients at particles
!! have errors, whose resultants would push and turn the body; they are distributed over the
!! particles where the function of the load changes. Equation (O.5) of doc/theory/instruments.md.
module particle_closed_loads
   use base_communicator, only: communicator_t
   use base_elementary, only: cross
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_surface_load, only: add_loads, hold_t, mark_columns, surface_load_t
   use particle_store, only: store_t
   implicit none
   private

   public :: balance_loads, find_closed_loads

   !> Sums over the particles, with the weight w = V |grad f|: force, moment about the origin, w,
   !! w x, w times xx yy zz xy yz xz of x, and the magnitudes of all forces.
   integer, parameter :: force = 1, moment = 4, weight = 7, first = 8, second = 11, magnitude = 17
   integer, parameter :: sums_of_load = 17

contains

   !> Find the loads that have no resultants, at the start. Collective.
   subroutine find_closed_loads(communicator, grid, tiles, stores, loads)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)  !! (direction, tile) Tiles, counted from 0
      type(store_t), intent(in) :: stores(:)          !! With functions of loads
      type(surface_load_t), intent(inout) :: loads(:)
      real(wp), parameter :: rounding = 1.0e-9_wp
      real(wp) :: total(sums_of_load), push(3), turn(3), centre(3), spread
      integer :: n

      do n = 1, size(loads)
         loads(n)%hold = hold_t()
         if (loads(n)%slot == 0) cycle
         call sum_load(communicator, grid, tiles, stores, loads(n), total)
         if (.not. total(magnitude) > 0.0_wp) cycle
         centre = total(first:first + 2)/total(weight)
         push = total(force:force + 2)
         turn = total(moment:moment + 2) - cross(centre, push)
         if (grid%axisymmetric) then
            push(1) = 0.0_wp
            turn = 0.0_wp
         end if
         spread = sqrt(max(0.0_wp, sum(total(second:second + 2))/total(weight) - sum(centre**2)))
         loads(n)%hold%closed = norm2(push) <= rounding*total(magnitude) .and. &
            norm2(turn) <= rounding*total(magnitude)*spread
      end do
   end subroutine find_closed_loads

   !> Set the force densities that keep the resultants of closed loads at zero in this step.
   !! Collective if there are such loads.
   subroutine balance_loads(communicator, grid, tiles, stores, loads)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)  !! (direction, tile) Tiles, counted from 0
      type(store_t), intent(in) :: stores(:)          !! With functions of loads
      type(surface_load_t), intent(inout) :: loads(:)
      type(surface_load_t) :: load
      real(wp) :: total(sums_of_load)
      integer :: n

      do n = 1, size(loads)
         if (.not. loads(n)%hold%closed) cycle
         load = loads(n)
         load%factor = 1.0_wp
         load%hold = hold_t()
         call sum_load(communicator, grid, tiles, stores, load, total)
         loads(n)%hold = hold_of(total, grid%axisymmetric)
      end do
   end subroutine balance_loads

   !> The force density that removes the resultants of sums.
   pure type(hold_t) function hold_of(total, axisymmetric) result(hold)
      real(wp), intent(in) :: total(sums_of_load)
      logical, intent(in) :: axisymmetric
      real(wp), parameter :: least = 1.0e-9_wp       ! of the determinant: particles on a line
      real(wp) :: inertia(3, 3), inverse(3, 3), about(3), trace, determinant
      integer :: k

      hold%closed = .true.
      if (.not. total(weight) > 0.0_wp) return
      hold%push = -total(force:force + 2)/total(weight)
      if (axisymmetric) then
         hold%push(1) = 0.0_wp
         return
      end if
      hold%centre = total(first:first + 2)/total(weight)
      about = total(moment:moment + 2) - cross(hold%centre, total(force:force + 2))
      inertia = -reshape(total(second + [0, 3, 5, 3, 1, 4, 5, 4, 2]), [3, 3])
      do k = 1, 3
         inertia(:, k) = inertia(:, k) + total(weight)*hold%centre*hold%centre(k)
      end do
      trace = -(inertia(1, 1) + inertia(2, 2) + inertia(3, 3))
      do k = 1, 3
         inertia(k, k) = inertia(k, k) + trace
      end do
      inverse(:, 1) = cross(inertia(:, 2), inertia(:, 3))
      inverse(:, 2) = cross(inertia(:, 3), inertia(:, 1))
      inverse(:, 3) = cross(inertia(:, 1), inertia(:, 2))
      determinant = dot_product(inertia(:, 1), inverse(:, 1))
      ! symmetric, so the inverse is that of the transpose
      if (determinant > least*trace**3) hold%turn = -matmul(inverse, about)/determinant
   end function hold_of

   !> Sums of a load at a factor of 1, over all ranks. Collective.
   subroutine sum_load(communicator, grid, tiles, stores, load, total)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)  !! (direction, tile) Tiles, counted from 0
      type(store_t), intent(in) :: stores(:)
      type(surface_load_t), intent(in) :: load       !! With a function of the particles
      real(wp), intent(out) :: total(sums_of_load)
      type(exact_sum_t) :: sums(sums_of_load)
      type(surface_load_t) :: unit(1)
      integer :: index, tile, k

      unit(1) = load
      unit(1)%factor = 1.0_wp
      do k = 1, sums_of_load
         call sums(k)%clear()
      end do
      do index = 1, size(stores)
         do tile = 1, size(stores(index)%count)
            if (changes(stores(index), tile, load%slot)) call sum_tile(grid, tiles(:, tile), unit, &
               stores(index), tile, sums)
         end do
      end do
      do k = 1, sums_of_load
         call sums(k)%over_ranks(communicator)
         total(k) = sums(k)%value()
      end do
   end subroutine sum_load

   !> Does the function of a load change in a tile?
   pure logical function changes(store, tile, slot) result(yes)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer, intent(in) :: slot                    !! Of the load
      integer :: column

      column = mark_columns*(slot - 1)
      yes = any(abs(store%origin%marks(store%first(tile):store%first(tile) &
         + store%count(tile) - 1, column + 2:column + 4)) > 0.0_wp)
   end function changes

   !> Add the particles of a tile.
   pure subroutine sum_tile(grid, coordinate, load, store, tile, sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      type(surface_load_t), intent(in) :: load(1)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      type(exact_sum_t), intent(inout) :: sums(sums_of_load)
      real(wp) :: stress(store%count(tile), 6), density(store%count(tile), 3)
      real(wp) :: push(3), x(3), w, slope(3), terms(sums_of_load)
      integer :: p, q, k

      call add_loads(load, grid, coordinate, store%first(tile), store%count(tile), &
         store%position, store%body, store%origin%marks, stress, density)
      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         if (all(abs(density(p, :)) <= 0.0_wp)) cycle
         k = mark_columns*(load(1)%slot - 1)
         slope = store%origin%marks(q, k + 2:k + 4)
         w = store%state%volume(q)*norm2(slope)
         push = store%state%volume(q)*density(p, :)
         x = store%position(q, :)
         terms = [push, cross(x, push), w, w*x, w*x**2, w*x(1)*x(2), w*x(2)*x(3), w*x(1)*x(3), &
            norm2(push)]
         do k = 1, sums_of_load
            call sums(k)%add(terms(k))
         end do
      end do
   end subroutine sum_tile
end module particle_closed_loads
