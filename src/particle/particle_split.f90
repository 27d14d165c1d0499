! SPDX-License-Identifier: BSD-3-Clause
!> Splits elongated particles into halves, so that stretched material does not separate numerically
!! where its particles no longer reach a common node.
!!
!! A half has half the mass and volume of the whole and the same state, and is a quarter of the edge
!! to one side of it. In axisymmetry halves are rings of half the cross-section, with mass and
!! volume in proportion to their radii. The velocities of the halves differ along the line between
!! them by the velocity gradient, which conserves momentum and angular momentum; its kinetic energy
!! is subtracted from the internal energy, or returned for the energy balance. The upper bits of an
!! identity are the path from the whole to the half, which needs no counter and does not depend on
!! ranks.
module particle_split
   use base_field_worker, only: field_worker_t
   use base_kinds, only: int64, wp
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use mesh_tiles, only: tiles_t
   use particle_place, only: place_particle
   use particle_store, only: store_t
   implicit none
   private

   public :: find_opening, generation_of, half_of, root_of, fractions_of_halves, split_store, &
      splitting_t

   integer, parameter, public :: root_bits = 40      !! Lower bits: the identity of the first whole
   integer, parameter, public :: most_generations = 20 !! Limit of the upper bits

   !> Greatest fraction of the internal energy of a gas that a split may convert to kinetic energy:
   !! the pressure keeps its order of magnitude [1]
   real(wp), parameter :: greatest_share = 0.5_wp

   !> Criteria for the splitting of particles.
   type :: splitting_t
      real(wp) :: longest = huge(1.0_wp)             !! Greatest edge of a particle [cells]
      integer :: generations = 0                     !! Most splits from the start to a particle
      logical :: gases = .false.                     !! Only particles of gases?
   end type splitting_t

   !> Copies particles to others.
   type, extends(field_worker_t) :: copier_t
      integer, allocatable :: from(:)                !! Indices of the copied particles
      integer, allocatable :: to(:)                  !! Indices of the copies
   contains
      procedure :: scalar => copier_scalar           !! Copies a scalar field
      procedure :: vector => copier_vector           !! Copies a vector or tensor field
      procedure :: whole => copier_whole             !! Copies an integer field
   end type copier_t

contains

   !> Split the particles of a store that are too long, before it is sorted.
   subroutine split_store(splitting, full, grid, boundary, tiles, store, gain)
      type(splitting_t), intent(in) :: splitting
      !> (0:cells - 1, tile) Cells that are full, of a material without strength; else not allocated
      logical, allocatable, intent(in) :: full(:, :)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      type(tiles_t), intent(in) :: tiles             !! The tiles of this rank
      type(store_t), intent(inout) :: store
      real(wp), allocatable, intent(out) :: gain(:)  !! (split particle) Kinetic energy gained [J]
      integer, allocatable :: new_count(:), edge(:)
      real(wp), allocatable :: opening(:)
      type(copier_t) :: copier
      integer :: tile, p, n, halved

      call list_long(splitting, full, grid, store, copier%from, edge, new_count)
      halved = size(edge)
      allocate (gain(halved))
      if (halved == 0) return
      if (has_opening(store)) then
         opening = store%opening(copier%from)
      else
         ! in the first step of a run that strains before the force, no edge has grown yet
         allocate (opening(halved), source=0.0_wp)
      end if
      if (any(new_count > store%capacity)) then
         ! ranges of particles have moved, so list them again
         call store%layout(new_count)
         call list_long(splitting, full, grid, store, copier%from, edge, new_count)
      end if
      allocate (copier%to(halved))
      n = 0
      do tile = 1, size(store%count)
         do p = store%first(tile) + store%count(tile), store%first(tile) + new_count(tile) - 1
            n = n + 1
            copier%to(n) = p
         end do
      end do
      call store%walk(copier)
      n = 0
      do tile = 1, size(store%count)
         do p = store%count(tile) + 1, new_count(tile)
            n = n + 1
            call halve_particle(grid, allocated(full), store, copier%from(n), copier%to(n), &
               edge(n), &
               opening(n), gain(n))
            store%count(tile) = p
            call place_particle(grid, boundary, tiles%coordinate(:, tile), store, tile, &
               copier%from(n))
            call place_particle(grid, boundary, tiles%coordinate(:, tile), store, tile, &
               copier%to(n))
            store%unsorted(tile) = .true.
         end do
      end do
   end subroutine split_store

   !> Has the step computed the growth rates of edges?
   pure logical function has_opening(store) result(has)
      type(store_t), intent(in) :: store

      has = allocated(store%opening)
      if (has) has = size(store%opening) > 0
   end function has_opening

   !> Growth rates of the longest edges of the particles of a tile, for those that may be split.
   pure subroutine find_opening(splitting, spacing, store, tile, gradient, dt)
      type(splitting_t), intent(in) :: splitting
      real(wp), intent(in) :: spacing                !! Edge of a cell [m]
      type(store_t), intent(inout) :: store          !! Stretched by the step
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: gradient(:, :) !! (particle of the tile, 9) [1]
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: edge(3), square, growth
      integer :: p, q, k, l

      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         store%opening(q) = 0.0_wp
         call find_longest(store, q, k, square)
         if (.not. 4.0_wp*square > (splitting%longest*spacing)**2) cycle
         do l = 1, 3
            edge(l) = store%domain(q, 3*(k - 1) + l)
         end do
         growth = 0.0_wp
         do l = 1, 3
            growth = growth + edge(l)*(gradient(p, l)*edge(1) + gradient(p, l + 3)*edge(2) &
               + gradient(p, l + 6)*edge(3))
         end do
         store%opening(q) = growth/(square*dt)
      end do
   end subroutine find_opening

   !> The longest half edge of a particle.
   pure subroutine find_longest(store, p, edge, square)
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      integer, intent(out) :: edge
      real(wp), intent(out) :: square                !! Square of its length [m2]
      real(wp) :: squares(3)
      integer :: k

      do k = 1, 3
         squares(k) = store%domain(p, 3*k - 2)**2 + store%domain(p, 3*k - 1)**2 &
            + store%domain(p, 3*k)**2
      end do
      edge = maxloc(squares, 1)
      square = squares(edge)
   end subroutine find_longest

   !> List the particles that are too long, by tile, and the new counts of the tiles.
   subroutine list_long(splitting, full, grid, store, particle, edge, new_count)
      type(splitting_t), intent(in) :: splitting
      logical, allocatable, intent(in) :: full(:, :) !! As above
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, allocatable, intent(out) :: particle(:) !! Indices
      integer, allocatable, intent(out) :: edge(:)   !! Longest edge of each particle
      integer, allocatable, intent(out) :: new_count(:)   !! (tile) With the halves
      integer, allocatable :: longest(:)
      integer :: tile, p, n

      allocate (longest(size(store%home)), new_count(size(store%count)))
      !$omp parallel do default(none) shared(splitting, full, grid, store, longest, new_count) &
      !$omp private(tile, p) schedule(static)
      do tile = 1, size(store%count)
         new_count(tile) = store%count(tile)
         do p = store%first(tile), store%first(tile) + store%count(tile) - 1
            longest(p) = too_long(splitting, grid, store, p)
            if (allocated(full) .and. longest(p) > 0) then
               if (.not. (full(store%home(p), tile) .and. is_large(splitting, grid, store, p))) &
                  longest(p) = 0
            end if
            if (longest(p) > 0) new_count(tile) = new_count(tile) + 1
         end do
      end do
      !$omp end parallel do
      allocate (particle(sum(new_count - store%count)), edge(sum(new_count - store%count)))
      n = 0
      do tile = 1, size(store%count)
         if (new_count(tile) == store%count(tile)) cycle
         do p = store%first(tile), store%first(tile) + store%count(tile) - 1
            if (longest(p) == 0) cycle
            n = n + 1
            particle(n) = p
            edge(n) = longest(p)
         end do
      end do
   end subroutine list_long

   !> Edge along which a particle is to be split, 0 = none. A particle is not split outside its
   !! tile, where a half would be outside the domain or close to the axis, or when it has failed.
   !! Equation (P.1) of doc/theory/splitting.md.
   pure integer function too_long(splitting, grid, store, p) result(edge)
      type(splitting_t), intent(in) :: splitting
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp) :: square, reach
      real(wp), parameter :: least_share = 0.1_wp    ! of the mass of the whole
      integer :: k

      edge = 0
      if (allocated(store%state%failed)) then
         if (store%state%failed(p) /= 0) return
      end if
      call find_longest(store, p, k, square)
      if (.not. 4.0_wp*square > (splitting%longest*grid%spacing)**2) return
      if (store%home(p) < 0) return
      if (generation_of(store%identity(p)) >= splitting%generations) return
      edge = k
      do k = 1, 3
         if (.not. grid%active(k) .or. grid%periodic(k)) cycle
         reach = 0.5_wp*abs(store%domain(p, 3*(edge - 1) + k))
         if (store%position(p, k) - reach < grid%lower(k) .or. &
            store%position(p, k) + reach > grid%upper(k)) then
            edge = 0
            return
         end if
      end do
      if (.not. grid%axisymmetric) return
      reach = 0.5_wp*abs(store%domain(p, 3*(edge - 1) + 1))
      if (minval(fractions_of_halves(grid, store%position(p, 1), reach)) < least_share) edge = 0
   end function too_long

   !> True if a particle is larger than a cube with the longest edge. Material without strength
   !! shears without limit while its particles remain close, so only large ones are split.
   pure logical function is_large(splitting, grid, store, p) result(yes)
      type(splitting_t), intent(in) :: splitting
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp) :: large

      large = grid%depth*(splitting%longest*grid%spacing)**grid%dimensions
      if (grid%axisymmetric) large = large*store%position(p, 1)
      yes = store%state%volume(p) > large
   end function is_large

   !> Mass and volume fractions of the half against the edge and the half along it. Equation (P.4).
   pure function fractions_of_halves(grid, radius, shift) result(share)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: radius                 !! Radius of the whole particle, along x [m]
      real(wp), intent(in) :: shift                  !! Along x, of the half along the edge [m]
      real(wp) :: share(2)

      share = 0.5_wp
      if (grid%axisymmetric) share = 0.5_wp*[1.0_wp - shift/radius, 1.0_wp + shift/radius]
   end function fractions_of_halves

   !> Turn two equal particles into halves, whose velocities conserve the momentum of the whole.
   !! Equations (P.2) and (P.3).
   pure subroutine halve_particle(grid, flows, store, low, high, edge, opening, gain)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: flows                   !! Is the material without strength?
      type(store_t), intent(inout) :: store
      integer, intent(in) :: low                     !! The whole; becomes the half against the edge
      integer, intent(in) :: high                    !! Copy that becomes the half along the edge
      integer, intent(in) :: edge
      real(wp), intent(in) :: opening                !! Rate at which it grows [1/s]
      real(wp), intent(out) :: gain !! Kinetic energy not taken from internal energy [J]
      integer(int64) :: whole
      real(wp) :: half(3), share(2), part, rate, most
      integer :: k

      whole = store%identity(low)
      store%identity(low) = half_of(whole, 0)
      store%identity(high) = half_of(whole, 1)
      do k = 1, 3
         half(k) = 0.5_wp*store%domain(low, 3*(edge - 1) + k)
      end do
      where (.not. grid%active) half = 0.0_wp
      share = fractions_of_halves(grid, store%position(low, 1), half(1))
      rate = opening
      if (flows .and. allocated(store%state%energy)) then
         ! in a thin, cold gas the velocity difference needs more than the internal energy
         most = greatest_share*max(store%state%energy(low), 0.0_wp)
         if (2.0_wp*share(1)*share(2)*opening**2*sum(half**2) > most) rate = sign(sqrt(most &
            /(2.0_wp*share(1)*share(2)*sum(half**2))), opening)
      end if
      do k = 1, 3
         store%position(high, k) = store%position(low, k) + half(k)
         store%position(low, k) = store%position(low, k) - half(k)
         store%domain([low, high], 3*(edge - 1) + k) = half(k)
         store%velocity(high, k) = store%velocity(low, k) + 2.0_wp*share(1)*rate*half(k)
         store%velocity(low, k) = store%velocity(low, k) - 2.0_wp*share(2)*rate*half(k)
      end do
      part = 2.0_wp*share(1)*share(2)*rate**2*sum(half**2)
      gain = store%state%mass(low)*part
      if (allocated(store%state%energy)) then
         store%state%energy([low, high]) = store%state%energy(low) - part
         gain = 0.0_wp
      end if
      store%state%mass([low, high]) = share*store%state%mass(low)
      store%state%volume([low, high]) = share*store%state%volume(low)
      if (.not. allocated(store%extent)) return
      k = maxloc(abs(half), 1)
      store%extent([low, high], k) = 0.5_wp*store%extent(low, k)
   end subroutine halve_particle

   !> Identity of a half: its number in the binary tree of halves, 1 for the root, in the upper
   !! bits.
   pure integer(int64) function half_of(whole, side) result(identity)
      integer(int64), intent(in) :: whole            !! Identity of the whole
      integer, intent(in) :: side                    !! 0 or 1
      integer(int64) :: place

      place = 2_int64*max(shiftr(whole, root_bits), 1_int64) + side
      identity = root_of(whole) + shiftl(place, root_bits)
   end function half_of

   !> Identity of the initial particle that a particle is a part of.
   pure integer(int64) function root_of(identity) result(root)
      integer(int64), intent(in) :: identity         !! Identity of a particle

      root = ibits(identity, 0, root_bits)
   end function root_of

   !> Number of splits from the initial particle to a particle.
   pure integer function generation_of(identity) result(generation)
      integer(int64), intent(in) :: identity         !! Identity of a particle

      generation = max(int(bit_size(identity)) - leadz(identity) - root_bits - 1, 0)
   end function generation_of

   !> Copy a scalar field.
   subroutine copier_scalar(self, name, unit, values)
      class(copier_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:) !! (particle)

      values(self%to) = values(self%from)
   end subroutine copier_scalar

   !> Copy a vector or tensor field.
   subroutine copier_vector(self, name, unit, values)
      class(copier_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :) !! (particle, component)
      integer :: component

      do component = 1, size(values, 2)
         values(self%to, component) = values(self%from, component)
      end do
   end subroutine copier_vector

   !> Copy an integer field.
   subroutine copier_whole(self, name, unit, values)
      class(copier_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:) !! (particle)

      values(self%to) = values(self%from)
   end subroutine copier_whole
end module particle_split
