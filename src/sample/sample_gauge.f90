! SPDX-License-Identifier: BSD-3-Clause
!> A gauge: the signal of an instrument at one position of an experiment. The fields of a particle,
!! of the material around a fixed point, of a surface as a laser interferometer sees it, or the
!! means over bodies or a region.
!!
!! At a point and on a surface the value is that of a linear function that is fitted to the
!! particles around, equation (O.1) of doc/theory/instruments.md. All sums are exact, so they do not
!! depend on the order of the particles.
module sample_gauge
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_exact_totals, only: totals_over_ranks
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use sample_fields, only: picks_t
   use sample_means, only: added, by_volume, fill_mean, mean_t
   use sample_pick, only: pick_rule_t
   use sample_profile, only: half_size
   implicit none
   private

   public :: find_nearest, gauge_row, gauge_t

   integer, parameter, public :: at_point = 1            !! Fit around a fixed point
   integer, parameter, public :: on_particle = 2         !! One particle
   integer, parameter, public :: on_surface = 3          !! Fit below a surface
   integer, parameter, public :: over_selection = 4      !! Means
   integer, parameter, public :: gauge_before = 4        !! Columns before the fields: x y z, count
   !> The fit has no slope along directions in which particles spread less than this fraction of the
   !! radius.
   real(wp), parameter :: least_spread = 1.0e-3_wp
   integer, parameter :: basis_size = 4                  !! 1 and three coordinates
   integer, parameter :: products = 10 !! Number of products of two basis functions

   !> Definition of a gauge.
   type :: gauge_t
      integer :: kind = at_point                         !! One of the constants above
      real(wp) :: point(3) = 0.0_wp                      !! Position, or initial position [m]
      real(wp) :: radius = 0.0_wp                        !! Radius of the observed material [m]
      real(wp) :: depth = 0.0_wp !! Depth below a surface, instead of a height [m]
      integer :: axis = 1                                !! Axis closest to the surface normal
      real(wp) :: side = 1.0_wp                          !! 1: the upper side along it, -1: lower
      integer(int64) :: identity = -1_int64 !! Identity of the particle, -1 = not found yet
      type(mean_t), allocatable :: means(:)              !! Fields
      type(pick_rule_t) :: rule                          !! Visible particles
   end type gauge_t

contains

   !> Values of all columns but time and step. All are zero if there is no material. Collective.
   subroutine gauge_row(communicator, grid, coordinate, stores, gauge, row)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid                   !! The grid and its directions
      integer, intent(in) :: coordinate(:, :)            !! (3, tile) Coordinates of the tiles
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(gauge_t), intent(in) :: gauge                 !! Definition of the gauge
      real(wp), allocatable, intent(out) :: row(:)       !! (column)
      type(picks_t) :: picks(size(stores))
      real(wp), allocatable :: weight(:), offset(:, :)
      real(wp) :: centre(3)
      integer :: n

      allocate (row(gauge_before + sum(gauge%means%column%components)), source=0.0_wp)
      centre = gauge%point
      select case (gauge%kind)
      case (on_particle)
         do n = 1, size(stores)
            call pick_identity(stores(n), gauge%identity, picks(n)%order)
         end do
      case (over_selection)
         do n = 1, size(stores)
            call gauge%rule%pick(stores(n), picks(n)%order)
         end do
      case default
         if (gauge%kind == on_surface) call find_surface(communicator, grid, coordinate, stores, &
            gauge, centre)
         call pick_around(grid, coordinate, stores, gauge, centre, picks, weight, offset)
      end select
      if (gauge%kind == on_particle .or. gauge%kind == over_selection) then
         call find_means(communicator, stores, picks, gauge%kind == on_particle, gauge%means, row)
      else
         row(:3) = centre
         call fit(communicator, grid%active, stores, picks, weight, offset, gauge%means, row)
      end if
   end subroutine gauge_row

   !> The selected particle that is nearest to the point of a gauge; of several the one with the
   !! least identity. Collective.
   subroutine find_nearest(communicator, grid, stores, gauge, distance)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid                   !! The grid and its directions
      type(store_t), intent(in) :: stores(:)
      type(gauge_t), intent(inout) :: gauge              !! Gets the identity
      real(wp), intent(out) :: distance !! Distance of the particle; huge if there is none [m]
      integer, allocatable :: order(:)
      integer(int64) :: identity(1)
      real(wp) :: square, least
      integer :: n, p

      least = huge(least)
      identity = huge(identity)
      do n = 1, size(stores)
         call gauge%rule%pick(stores(n), order)
         do p = 1, size(order)
            square = sum((stores(n)%position(order(p), :) - gauge%point)**2, mask=grid%active)
            if (square > least) cycle
            if (square < least) identity = huge(identity)
            least = square
            identity = min(identity, stores(n)%identity(order(p)))
         end do
      end do
      square = communicator%minimum(least)
      if (least > square) identity = huge(identity)
      call communicator%least(identity)
      distance = sqrt(square)
      gauge%identity = identity(1)
   end subroutine find_nearest

   !> The particle of an identity, if it is in a store of this rank.
   pure subroutine pick_identity(store, identity, order)
      type(store_t), intent(in) :: store
      integer(int64), intent(in) :: identity
      integer, allocatable, intent(out) :: order(:)      !! Its index, or nothing
      integer :: p, tile

      if (allocated(store%count)) then
         do tile = 1, size(store%count)
            do p = store%first(tile), store%first(tile) + store%count(tile) - 1
               if (store%identity(p) /= identity) cycle
               allocate (order(1), source=p)
               return
            end do
         end do
      end if
      allocate (order(0))
   end subroutine pick_identity

   !> Position where the beam hits the material: the greatest end of the selected particles along
   !! the beam. Collective.
   subroutine find_surface(communicator, grid, coordinate, stores, gauge, centre)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid                   !! The grid and its directions
      integer, intent(in) :: coordinate(:, :)            !! (3, tile) Coordinates of the tiles
      type(store_t), intent(in) :: stores(:)
      type(gauge_t), intent(in) :: gauge
      real(wp), intent(inout) :: centre(3)               !! Gets the place along the axis [m]
      logical :: across(3)
      real(wp) :: farthest, reach(3)
      integer :: n, p, tile

      across = grid%active
      across(gauge%axis) = .false.
      reach = gauge%radius
      reach(gauge%axis) = huge(reach)
      farthest = -huge(farthest)
      do n = 1, size(stores)
         do tile = 1, size(stores(n)%count)
            if (.not. tile_near(grid, coordinate(:, tile), centre, reach)) cycle
            do p = stores(n)%first(tile), stores(n)%first(tile) + stores(n)%count(tile) - 1
               if (sum((stores(n)%position(p, :) - centre)**2, mask=across) > gauge%radius**2) cycle
               if (.not. gauge%rule%takes(stores(n), p)) cycle
               farthest = max(farthest, gauge%side*stores(n)%position(p, gauge%axis) &
                  + half_size(grid, stores(n), p, gauge%axis))
            end do
         end do
      end do
      farthest = communicator%maximum(farthest)
      if (farthest > -huge(farthest)) centre(gauge%axis) = gauge%side*farthest
   end subroutine find_surface

   !> Does a tile reach into the box around a point?
   pure logical function tile_near(grid, coordinate, centre, reach) result(near)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)               !! Position of the tile, from 0
      real(wp), intent(in) :: centre(3)                  !! The point [m]
      real(wp), intent(in) :: reach(3)                   !! Half the edges of the box [m]
      real(wp) :: lower(3)

      lower = grid%tile_corner(coordinate)
      near = all(.not. grid%active .or. (centre + reach >= lower .and. centre - reach <= lower &
         + real(grid%width, wp)*grid%spacing))
   end function tile_near

   !> The selected particles around a point, their weights V (1 - s**2)**2 at the distance s in
   !! units of the radius, and their offsets in these units.
   subroutine pick_around(grid, coordinate, stores, gauge, centre, picks, weight, offset)
      type(grid_t), intent(in) :: grid                   !! The grid and its directions
      integer, intent(in) :: coordinate(:, :)            !! (3, tile) Coordinates of the tiles
      type(store_t), intent(in) :: stores(:)
      type(gauge_t), intent(in) :: gauge
      real(wp), intent(in) :: centre(3)                  !! The point [m]
      type(picks_t), intent(inout) :: picks(:)           !! (store) Gets the particles
      real(wp), allocatable, intent(out) :: weight(:)    !! (row) [m3]
      real(wp), allocatable, intent(out) :: offset(:, :) !! (3, row) [1]
      real(wp) :: reach(3), s(3), square
      integer :: n, p, tile

      reach = gauge%radius
      if (gauge%kind == on_surface) reach(gauge%axis) = gauge%depth
      allocate (weight(0), offset(3, 0))
      do n = 1, size(stores)
         allocate (picks(n)%order(0))
         do tile = 1, size(stores(n)%count)
            if (.not. tile_near(grid, coordinate(:, tile), centre, reach)) cycle
            do p = stores(n)%first(tile), stores(n)%first(tile) + stores(n)%count(tile) - 1
               s = merge((stores(n)%position(p, :) - centre)/reach, 0.0_wp, grid%active)
               square = sum(s**2)
               if (square >= 1.0_wp) cycle
               if (.not. gauge%rule%takes(stores(n), p)) cycle
               picks(n)%order = [picks(n)%order, p]
               weight = [weight, stores(n)%state%volume(p)*(1.0_wp - square)**2]
               offset = reshape([offset, s], [3, size(weight)])
            end do
         end do
      end do
   end subroutine pick_around

   !> Values at the centre of linear functions that are fitted to the particles. Collective.
   subroutine fit(communicator, active, stores, picks, weight, offset, means, row)
      type(communicator_t), intent(in) :: communicator
      logical, intent(in) :: active(3)                   !! (direction) Does the scene have it?
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      real(wp), intent(in) :: weight(:)                  !! (row)
      real(wp), intent(in) :: offset(:, :)               !! (3, row)
      type(mean_t), intent(in) :: means(:)
      real(wp), intent(inout) :: row(:)                  !! Gets count and values
      type(exact_sum_t), allocatable :: total(:)
      real(wp), allocatable :: sums(:), values(:, :)
      real(wp) :: basis(basis_size), moment(basis_size, basis_size)
      integer :: at, column, i, j, n, r

      column = size(row) - gauge_before
      allocate (total(1 + products + basis_size*column), sums(1 + products + basis_size*column))
      do r = 1, size(weight)
         basis = [1.0_wp, merge(offset(:, r), 0.0_wp, active)]
         at = 1
         call total(at)%add(1.0_wp)
         do i = 1, basis_size
            do j = i, basis_size
               at = at + 1
               call total(at)%add(weight(r)*(basis(i)*basis(j)))
            end do
         end do
      end do
      at = 1 + products
      do n = 1, size(means)
         call fill_mean(stores, picks, means(n)%column, values)
         do column = 1, size(values, 1)
            do r = 1, size(weight)
               basis = [1.0_wp, merge(offset(:, r), 0.0_wp, active)]
               do i = 1, basis_size
                  call total(at + i)%add(weight(r)*basis(i)*values(column, r))
               end do
            end do
            at = at + basis_size
         end do
      end do
      call totals_over_ranks(communicator, total, sums)
      row(gauge_before) = sums(1)
      if (.not. sums(1) > 0.0_wp) return
      at = 1
      do i = 1, basis_size
         do j = i, basis_size
            at = at + 1
            moment(i, j) = sums(at)
            moment(j, i) = sums(at)
         end do
      end do
      do column = 1, size(row) - gauge_before
         row(gauge_before + column) = value_at_centre(moment, sums(at + 1:at + basis_size))
         at = at + basis_size
      end do
   end subroutine fit

   !> The constant of a fit: solution of moment x = right by elimination of the coordinates.
   !! Coordinates in which the particles do not spread are left out.
   pure real(wp) function value_at_centre(moment, right) result(value)
      real(wp), intent(in) :: moment(basis_size, basis_size) !! Symmetric
      real(wp), intent(in) :: right(basis_size)          !! Right side
      real(wp) :: a(basis_size, basis_size), b(basis_size), c(basis_size), factor
      logical :: used(basis_size)
      integer :: i, j, k

      a = moment
      b = right
      used = .true.
      do k = 1, basis_size
         if (k > 1) used(k) = a(k, k) > least_spread**2*moment(1, 1)
         if (.not. used(k)) cycle
         do i = k + 1, basis_size
            factor = a(i, k)/a(k, k)
            do j = k, basis_size
               a(i, j) = a(i, j) - factor*a(k, j)
            end do
            b(i) = b(i) - factor*b(k)
         end do
      end do
      c = 0.0_wp
      do k = basis_size, 1, -1
         if (.not. used(k)) cycle
         c(k) = b(k)
         do j = k + 1, basis_size
            c(k) = c(k) - a(k, j)*c(j)
         end do
         c(k) = c(k)/a(k, k)
      end do
      value = c(1)
   end function value_at_centre

   !> Mean position, number and means of the particles, weighted as in profiles. Collective.
   subroutine find_means(communicator, stores, picks, single, means, row)
      type(communicator_t), intent(in) :: communicator
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      logical, intent(in) :: single                      !! One particle: its values are not divided
      type(mean_t), intent(in) :: means(:)
      real(wp), intent(inout) :: row(:)                  !! Gets all
      type(exact_sum_t), allocatable :: total(:)
      real(wp), allocatable :: mass(:), position(:, :), values(:, :), volume(:), sums(:)
      integer :: at, k, n, part, r

      call copy_weights(stores, picks, mass, volume, position)
      if (single) then
         mass = 1.0_wp
         volume = 1.0_wp
      end if
      allocate (total(size(row) + 2), sums(size(row) + 2))
      do r = 1, size(mass)
         do k = 1, 3
            call total(k)%add(mass(r)*position(k, r))
         end do
         call total(gauge_before)%add(1.0_wp)
         call total(size(row) + 1)%add(mass(r))
         call total(size(row) + 2)%add(volume(r))
      end do
      at = gauge_before
      do n = 1, size(means)
         call fill_mean(stores, picks, means(n)%column, values)
         do part = 1, size(values, 1)
            at = at + 1
            select case (means(n)%weight)
            case (added)
               call total(at)%add_all(values(part, :))
            case (by_volume)
               call total(at)%add_all(volume*values(part, :))
            case default
               call total(at)%add_all(mass*values(part, :))
            end select
         end do
      end do
      call totals_over_ranks(communicator, total, sums)
      row = sums(:size(row))
      if (.not. sums(gauge_before) > 0.0_wp) return
      row(:3) = sums(:3)/sums(size(row) + 1)
      at = gauge_before
      do n = 1, size(means)
         part = means(n)%column%components
         if (means(n)%weight == by_volume) row(at + 1:at + part) = &
            row(at + 1:at + part)/sums(size(row) + 2)
         if (means(n)%weight /= by_volume .and. means(n)%weight /= added) &
            row(at + 1:at + part) = row(at + 1:at + part)/sums(size(row) + 1)
         at = at + part
      end do
   end subroutine find_means

   !> Mass, volume and position of the particles, store after store.
   pure subroutine copy_weights(stores, picks, mass, volume, position)
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      real(wp), allocatable, intent(out) :: mass(:)      !! (row) [kg]
      real(wp), allocatable, intent(out) :: volume(:)    !! (row) [m3]
      real(wp), allocatable, intent(out) :: position(:, :) !! (3, row) [m]
      integer :: filled, n, r

      filled = 0
      do n = 1, size(stores)
         filled = filled + size(picks(n)%order)
      end do
      allocate (mass(filled), volume(filled), position(3, filled))
      filled = 0
      do n = 1, size(stores)
         do r = 1, size(picks(n)%order)
            filled = filled + 1
            associate (p => picks(n)%order(r))
               mass(filled) = stores(n)%state%mass(p)
               volume(filled) = stores(n)%state%volume(p)
               position(:, filled) = stores(n)%position(p, :)
            end associate
         end do
      end do
   end subroutine copy_weights
end module sample_gauge
