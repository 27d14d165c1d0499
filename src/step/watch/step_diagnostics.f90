! SPDX-License-Identifier: BSD-3-Clause
!> Examines all particles for errors that balances cannot show: how far neighbours are apart,
!! whether the volumes of particles fit into the cells, whether pressures follow those of the nodes,
!! and the greatest speed and energy. Sums are exact and sums of tiles are in the order of
!! particles, so all numbers are the same for any ranks and threads.
module step_diagnostics
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_exact_totals, only: totals_over_ranks
   use base_kinds, only: int64, wp
   use material_kinds, only: is_loose, may_lock
   use material_type, only: material_t
   use mesh_tiles, only: tiles_t
   use mesh_grid, only: grid_t
   use particle_crowding, only: add_to_nodes, measure_claims, measure_noise, nodes_alone
   use particle_neighbours, only: neighbour_table_t
   use particle_store, only: store_t
   use step_simulation, only: scratch_t, simulation_t, space_t
   use step_trust_record, only: apart, trust_t
   implicit none
   private

   public :: bounds_limits_t, bounds_sample_t, examine_bounds, examine_shapes, find_greatest, &
      find_unbalanced, shapes_sample_t, watch_unbalanced

   integer, parameter, public :: measure_speed = 1   !! Square of the speed [m2/s2]
   integer, parameter, public :: measure_heat = 2    !! Carried energy per mass [J/kg]
   integer, parameter, public :: measure_cold = 3    !! The same, negative
   integer, parameter, public :: measure_energy = 4  !! Kinetic and carried energy [J]
   integer, parameter, public :: measure_volume = 5  !! Volume over that at rest [1]

   !> Greatest and least of all particles.
   type :: bounds_sample_t
      real(wp) :: speed = 0.0_wp                     !! Greatest speed [m/s]
      real(wp) :: heat = -huge(1.0_wp)               !! Greatest carried energy per mass [J/kg]
      real(wp) :: cold = huge(1.0_wp)                !! Least of these [J/kg]
      real(wp) :: energy = 0.0_wp                    !! Greatest energy of one particle [J]
      real(wp) :: whole = 0.0_wp                     !! Energy of all particles [J]
      real(wp) :: fast = 0.0_wp                      !! Of those faster than the limit [J]
      real(wp) :: odd = 0.0_wp !! Of those with an energy per mass beyond the limits [J]
   end type bounds_sample_t

   !> Limits of plausible particles.
   type :: bounds_limits_t
      real(wp) :: square = huge(1.0_wp)              !! Square of the speed [m2/s2]
      real(wp) :: hot = huge(1.0_wp)                 !! Greatest energy per mass [J/kg]
      real(wp) :: cold = -huge(1.0_wp)               !! Least energy per mass [J/kg]
   end type bounds_limits_t

   !> Distances of neighbours, volumes in cells, and noise of pressures.
   type :: shapes_sample_t
      real(wp) :: longest = 0.0_wp                   !! Greatest distance of neighbours [cells]
      real(wp) :: share = 0.0_wp                     !! Mass fraction with separated neighbours [1]
      real(wp) :: overlap = 0.0_wp                   !! Volume in excess of the cells [1]
      real(wp) :: stress = 0.0_wp !! Root mean square of the stress that resists, with inertia [Pa]
      real(wp) :: difference = 0.0_wp                !! Root mean square from node means [Pa]
      integer(int64) :: longest_identity = huge(1_int64)    !! Particle with the farthest neighbour
   end type shapes_sample_t

   !> Columns of the results of a tile: sums, and the greatest distance.
   integer, parameter :: far_mass = 1, seen_mass = 2, claimed = 3, occupied = 4, noise = 5, &
      sums = 7, longest = 8

contains

   !> Let the steps record unbalanced forces.
   pure subroutine watch_unbalanced(scratches)
      type(scratch_t), intent(inout) :: scratches(0:)
      integer :: thread

      do thread = 0, ubound(scratches, 1)
         if (.not. allocated(scratches(thread)%unbalanced)) allocate (scratches(thread)%unbalanced)
      end do
   end subroutine watch_unbalanced

   !> Unbalanced force of the last step over the force of the stress, 1 if there is no stress.
   !! Equation (O.7) of doc/theory/instruments.md. Collective.
   subroutine find_unbalanced(simulation, ratio)
      type(simulation_t), intent(in) :: simulation   !! Unbalanced forces are watched
      real(wp), intent(out) :: ratio                 !! [1]
      type(exact_sum_t) :: force, strength
      real(wp) :: s(6)
      integer :: index, p, thread, tile

      do thread = 0, ubound(simulation%scratch, 1)
         call force%merge(simulation%scratch(thread)%unbalanced)
      end do
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  s = store%state%stress(p, :)
                  call strength%add(store%state%volume(p) &
                     *sqrt(sum(s(:3)**2) + 2.0_wp*sum(s(4:)**2)))
               end do
            end do
         end associate
      end do
      call force%over_ranks(simulation%machine%communicator)
      call strength%over_ranks(simulation%machine%communicator)
      ratio = 1.0_wp
      if (strength%value() > 0.0_wp) &
         ratio = force%value()*simulation%space%grid%spacing/strength%value()
   end subroutine find_unbalanced

   !> Greatest speed, energies of particles, and the energy of implausible ones. Collective.
   subroutine examine_bounds(tiles, stores, communicator, least_energy, limits, sample)
      type(tiles_t), intent(in) :: tiles
      type(store_t), intent(in) :: stores(:)
      type(communicator_t), intent(inout) :: communicator
      real(wp), intent(in) :: least_energy           !! Zero level of the energies [J/kg]
      type(bounds_limits_t), intent(in) :: limits    !! Of plausible particles
      type(bounds_sample_t), intent(out) :: sample       !! Measured values
      real(wp) :: greatest(4, max(1, tiles%own)), all(4)
      real(wp) :: energies(3, tiles%own), total(3)
      type(exact_sum_t) :: sum(3)
      integer :: index, n, tile

      greatest = -huge(1.0_wp)
      energies = 0.0_wp
      !$omp parallel do default(none) shared(tiles, stores, least_energy, limits) &
      !$omp shared(greatest, energies) private(tile, index) schedule(static)
      do tile = 1, tiles%own
         do index = 1, size(stores)
            associate (store => stores(index))
               if (store%count(tile) == 0) cycle
               call find_bounds(store, store%first(tile), store%first(tile) + store%count(tile) &
                  - 1, least_energy, limits, greatest(:, tile), energies(:, tile))
            end associate
         end do
      end do
      !$omp end parallel do
      all = maxval(greatest, dim=2)
      call communicator%maxima(all)
      sample%speed = sqrt(max(0.0_wp, all(1)))
      sample%heat = all(2)
      sample%cold = -all(3)
      sample%energy = max(0.0_wp, all(4))
      do n = 1, 3
         do tile = 1, tiles%own
            call sum(n)%add(energies(n, tile))
         end do
      end do
      call totals_over_ranks(communicator, sum, total)
      sample%whole = total(1)
      sample%fast = total(2)
      sample%odd = total(3)
   end subroutine examine_bounds

   !> The greatest values of a range of particles: square of the speed, energy per mass, its
   !! negative, energy. Adds up the energy of all, of fast, and of hot or cold particles.
   pure subroutine find_bounds(store, first, last, least_energy, limits, greatest, energies)
      type(store_t), intent(in) :: store
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: least_energy           !! Zero level of the energies [J/kg]
      type(bounds_limits_t), intent(in) :: limits    !! Of plausible particles
      real(wp), intent(inout) :: greatest(4)         !! As above
      real(wp), intent(inout) :: energies(3)         !! As above [J]
      real(wp) :: square, speed, hot, cold, energy, own
      integer :: p

      speed = greatest(1)
      hot = greatest(2)
      cold = greatest(3)
      energy = greatest(4)
      associate (v => store%velocity, state => store%state)
         if (allocated(state%energy)) then
            do p = first, last
               square = v(p, 1)**2 + v(p, 2)**2 + v(p, 3)**2
               speed = max(speed, square)
               hot = max(hot, state%energy(p))
               cold = max(cold, -state%energy(p))
               own = state%mass(p)*(0.5_wp*square + state%energy(p) - least_energy)
               energy = max(energy, own)
               energies(1) = energies(1) + state%mass(p)*(0.5_wp*square &
                  + abs(state%energy(p) - least_energy))
               if (square > limits%square) &
                  energies(2) = energies(2) + 0.5_wp*state%mass(p)*square
               if (state%energy(p) > limits%hot .or. state%energy(p) < limits%cold) &
                  energies(3) = energies(3) + state%mass(p)*abs(state%energy(p) - least_energy)
            end do
         else
            do p = first, last
               square = v(p, 1)**2 + v(p, 2)**2 + v(p, 3)**2
               speed = max(speed, square)
               own = 0.5_wp*state%mass(p)*square
               energy = max(energy, own)
               energies(1) = energies(1) + own
               if (square > limits%square) energies(2) = energies(2) + own
            end do
         end if
      end associate
      greatest = [speed, hot, cold, energy]
   end subroutine find_bounds

   !> Identity of the particle in which a measure is greatest, the lowest of several; huge if there
   !! is none. Collective.
   integer(int64) function find_greatest(materials, stores, communicator, measure, least_energy) &
      result(identity)
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: measure                 !! One of the measures above
      real(wp), intent(in) :: least_energy           !! Zero level of the energies [J/kg]
      real(wp) :: value, greatest
      integer :: index, tile, p

      identity = huge(identity)
      greatest = -huge(greatest)
      do index = 1, size(stores)
         associate (store => stores(index))
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  value = measure_of(store, p, materials(index)%density, measure, least_energy)
                  if (value < greatest) cycle
                  if (value > greatest) identity = huge(identity)
                  greatest = value
                  identity = min(identity, store%identity(p))
               end do
            end do
         end associate
      end do
      identity = lowest_of(communicator, greatest, identity)
   end function find_greatest

   !> A measure of a particle; the lowest number where it has no meaning.
   pure real(wp) function measure_of(store, p, density, measure, least_energy) result(value)
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp), intent(in) :: density                !! Density of its material at rest [kg/m3]
      integer, intent(in) :: measure                 !! One of the measures above
      real(wp), intent(in) :: least_energy           !! Zero level of the energies [J/kg]

      value = -huge(1.0_wp)
      associate (state => store%state, v => store%velocity)
         select case (measure)
         case (measure_speed)
            value = v(p, 1)**2 + v(p, 2)**2 + v(p, 3)**2
         case (measure_heat)
            if (allocated(state%energy)) value = state%energy(p)
         case (measure_cold)
            if (allocated(state%energy)) value = -state%energy(p)
         case (measure_energy)
            value = 0.5_wp*state%mass(p)*(v(p, 1)**2 + v(p, 2)**2 + v(p, 3)**2)
            if (allocated(state%energy)) &
               value = value + state%mass(p)*(state%energy(p) - least_energy)
         case default
            value = state%volume(p)*density/state%mass(p)
            if (allocated(state%failed)) then
               if (state%failed(p) /= 0) value = -huge(1.0_wp)
            end if
         end select
      end associate
   end function measure_of

   !> The lowest identity among the ranks that have the greatest value. Collective.
   integer(int64) function lowest_of(communicator, value, own) result(identity)
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(in) :: value                  !! Greatest of this rank
      integer(int64), intent(in) :: own              !! Particle on this rank
      integer(int64) :: least(1)

      least = own
      if (value < communicator%maximum(value)) least = huge(least)
      call communicator%least(least)
      identity = least(1)
   end function lowest_of

   !> Distances of neighbours, volumes, pressures. Collective.
   subroutine examine_shapes(space, materials, stores, trust, communicator, sample)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(trust_t), intent(in) :: trust
      type(communicator_t), intent(in) :: communicator
      type(shapes_sample_t), intent(out) :: sample       !! Measured values
      real(wp), allocatable :: found(:, :)
      integer(int64), allocatable :: who(:)
      type(exact_sum_t) :: sum
      real(wp) :: total(sums), greatest
      integer(int64) :: identity
      integer :: n, tile

      allocate (found(longest, space%tiles%own), source=0.0_wp)
      allocate (who(space%tiles%own), source=huge(1_int64))
      !$omp parallel default(none) shared(space, materials, stores, trust, found, who)
      call examine_sample(space, materials, stores, trust, found, who)
      !$omp end parallel
      do n = 1, sums
         call sum%clear()
         do tile = 1, space%tiles%own
            call sum%add(found(n, tile))
         end do
         call sum%over_ranks(communicator)
         total(n) = sum%value()
      end do
      greatest = 0.0_wp
      identity = huge(1_int64)
      do tile = 1, space%tiles%own
         if (found(longest, tile) < greatest) cycle
         if (found(longest, tile) > greatest) identity = huge(1_int64)
         greatest = found(longest, tile)
         identity = min(identity, who(tile))
      end do
      sample%longest_identity = lowest_of(communicator, greatest, identity)
      sample%longest = communicator%maximum(greatest)/space%grid%spacing
      if (total(seen_mass) > 0.0_wp) sample%share = total(far_mass)/total(seen_mass)
      if (total(occupied) > 0.0_wp) sample%overlap = (total(claimed) - total(occupied)) &
         /total(occupied)
      if (total(noise) > 0.0_wp) then
         sample%stress = sqrt(total(noise + 1)/total(noise))
         sample%difference = sqrt(total(noise + 2)/total(noise))
      end if
   end subroutine examine_shapes

   !> The tiles of one thread, with scratch space of its own.
   subroutine examine_sample(space, materials, stores, trust, found, who)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(trust_t), intent(in) :: trust
      real(wp), intent(inout) :: found(:, :)         !! (column, tile)
      integer(int64), intent(inout) :: who(:)        !! (tile) Particles of the greatest distance
      type(neighbour_table_t) :: table
      real(wp), allocatable :: patch(:, :), total(:, :)
      real(wp) :: all(sums - noise + 1)
      logical, allocatable :: alone(:)
      integer :: tile, index

      allocate (patch(2, space%grid%tile_nodes), total(2, space%grid%tile_nodes))
      !$omp do schedule(dynamic, 1)
      do tile = 1, space%tiles%own
         associate (grid => space%grid, coordinate => space%tiles%coordinate(:, tile))
            alone = nodes_alone(grid, coordinate)
            total = 0.0_wp
            do index = 1, size(stores)
               associate (store => stores(index), material => materials(index))
                  if (store%count(tile) == 0) cycle
                  patch = 0.0_wp
                  call add_to_nodes(grid, coordinate, store, tile, material%density, &
                     is_loose(material), patch)
                  total = total + patch
                  all = 0.0_wp
                  call measure_noise(grid, coordinate, alone, store, tile, &
                     may_lock(material), patch, all)
                  found(noise:sums, tile) = found(noise:sums, tile) + all
                  if (is_solid(material)) call examine_lengths(space%grid, trust, table, store, &
                     tile, found(:, tile), who(tile))
               end associate
            end do
            call measure_claims(grid, coordinate, alone, total, found(claimed, tile), &
               found(occupied, tile))
         end associate
      end do
      !$omp end do
   end subroutine examine_sample

   !> Distances of neighbours of a store in a tile.
   pure subroutine examine_lengths(grid, trust, table, store, tile, found, who)
      type(grid_t), intent(in) :: grid
      type(trust_t), intent(in) :: trust
      type(neighbour_table_t), intent(inout) :: table !! Scratch space
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(inout) :: found(:)            !! (column)
      integer(int64), intent(inout) :: who           !! Particle with the farthest neighbour
      real(wp) :: length(store%count(tile)), mass
      integer :: p

      call table%lengths(grid, trust%lattices, store, tile, length)
      do p = 1, size(length)
         if (length(p) < 0.0_wp) cycle
         mass = store%state%mass(store%first(tile) + p - 1)
         found(seen_mass) = found(seen_mass) + mass
         if (length(p) > apart*grid%spacing) found(far_mass) = found(far_mass) + mass
         if (length(p) < found(longest)) cycle
         if (length(p) > found(longest)) who = huge(1_int64)
         found(longest) = length(p)
         who = min(who, store%identity(store%first(tile) + p - 1))
      end do
   end subroutine examine_lengths

   !> True if particles of a material stay close to their neighbours, as those of fluids and loose
   !! grains do not.
   pure logical function is_solid(material) result(solid)
      type(material_t), intent(in) :: material

      solid = .false.
      if (allocated(material%law)) solid = material%law%has_shear() .and. .not. is_loose(material)
   end function is_solid
end module step_diagnostics
