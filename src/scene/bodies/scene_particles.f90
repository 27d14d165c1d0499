! SPDX-License-Identifier: BSD-3-Clause
!> Stores and particles of a simulation: empty ones for `scene_setup`, filled ones for
!! `scene_first_state`, and particles of a checkpoint distributed over ranks.
module scene_particles
   use base_communicator, only: communicator_t
   use base_elementary, only: cross
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use material_flaws, only: flaw_blocks_t
   use material_kinds, only: is_fluid, is_gas, is_loose
   use material_stages, only: effect_count, effect_names
   use material_state, only: has_energy
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_key
   use mesh_surface_load, only: mark_columns
   use mesh_tiles, only: partition_keys, partition_scattered_keys
   use omp_lib, only: omp_get_max_threads
   use particle_body, only: body_t, find_box
   use particle_fill, only: fill_bodies
   use particle_place, only: find_place
   use particle_store, only: store_t, traits_t
   use particle_survey, only: survey_bodies
   use particle_volume_factors, only: set_volume_factors
   use scene_cell, only: start_cell
   use scene_contact, only: bond_stores, store_name
   use step_normalised_sums, only: choose_normalised
   use step_simulation, only: simulation_t
   use step_sort_particles, only: sort_particles
   use step_time_step, only: find_stable_step, greatest_diffusivity
   implicit none
   private

   public :: body_of, count_tiles, distribute_particles, fill_simulation, fill_store, first_step, &
      make_stores, number_bodies, prepare_simulation, spin_bodies, survey_t, take_survey

   !> Counts of particles that the bodies will have, found before particles exist.
   type :: survey_t
      integer(int64) :: particles = 0                !! Number of particles in all bodies
      integer(int64) :: tiles = 0                    !! Tiles with particles, on all ranks
      integer(int64), allocatable :: body(:)         !! (body) Particles
      real(wp), allocatable :: volume(:)             !! (body) Volume of its particles [m3]
      !> (tile) Tiles with particles that this rank has counted, ascending. They can be anywhere in
      !! the domain; each tile is on the list of one rank.
      integer(int64), allocatable :: key(:)
      integer(int64), allocatable :: particles_of(:) !! (tile) Their particles
   end type survey_t

contains

   !> Allocate scratch, timers and the dual gradient, which do not depend on particles. Grid,
   !! boundary, materials and method are set.
   subroutine prepare_simulation(simulation)
      type(simulation_t), intent(inout) :: simulation
      integer(int64) :: none(0)
      integer(int64), allocatable :: border(:)
      integer :: material, effect, n

      allocate (simulation%scratch(0:omp_get_max_threads() - 1))
      if (simulation%scheme%method%dual) then
         simulation%scheme%dual%surface = simulation%scheme%method%surface
         simulation%scheme%dual%hoops = simulation%space%grid%axisymmetric .and. &
            simulation%scheme%method%controlled()
         call simulation%scheme%dual%start(simulation%space%grid)
      end if
      call partition_keys(none, none, simulation%machine%communicator%size, border)
      call simulation%space%tiles%cut(border)
      call simulation%space%tiles%set(simulation%space%grid, none, none)
      do material = 1, size(simulation%materials)
         if (.not. allocated(simulation%materials(material)%heat)) cycle
         if (simulation%materials(material)%heat%conductivity > 0.0_wp .and. &
            .not. allocated(simulation%effects%conduction)) allocate (simulation%effects%conduction)
      end do
      simulation%scheme%repacks = any(simulation%materials%repacks)
      call choose_normalised(simulation%space%grid, simulation%materials, simulation%scheme)
      ! names of the timed phases, in the order of the table
      associate (timer => simulation%machine%timer, phase => simulation%machine%phase)
         phase%sort = timer%phase("sort, move tiles")
         phase%scatter = timer%phase("points to nodes")
         phase%exchange = timer%phase("exchange")
         phase%wait = timer%phase("waiting for ranks")
         phase%grid = timer%phase("grid")
         phase%gather = timer%phase("nodes to points")
         do effect = 1, effect_count
            if (any([(simulation%materials(n)%has(effect), n=1, size(simulation%materials))])) &
               phase%effect(effect) = timer%phase(trim(effect_names(effect)))
         end do
         if (allocated(simulation%effects%conduction)) phase%conduction = &
            timer%phase("heat conduction")
         if (allocated(simulation%effects%contact)) phase%contact = timer%phase("contact")
         phase%ledger = timer%phase("ledger, history")
         phase%output = timer%phase("output")
         phase%checkpoint = timer%phase("checkpoint")
      end associate
   end subroutine prepare_simulation

   !> Make empty stores for the materials, with the fields that they need.
   subroutine make_stores(simulation, several)
      type(simulation_t), intent(inout) :: simulation
      logical, intent(in) :: several                 !! Are there several bodies?
      type(traits_t) :: traits
      logical :: waits(6)
      integer :: index, slots, face

      if (allocated(simulation%stores)) deallocate (simulation%stores)
      allocate (simulation%stores(size(simulation%materials)))
      if (.not. allocated(simulation%effects%contact)) then
         if (allocated(simulation%fields)) deallocate (simulation%fields)
         allocate (simulation%fields(1))
         simulation%fields(1)%last_store = size(simulation%stores)
      end if
      waits = [(simulation%space%boundary%waits(simulation%space%grid, face), face=1, 6)]
      simulation%scheme%carries_energy = .false.
      simulation%scheme%loose = .false.
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            traits = traits_t(body=several, arrives=any(waits))
            call simulation%scheme%method%request(traits, is_gas(simulation%materials(index)))
            call simulation%materials(index)%allocate_state(store%state)
            call store%start(store_name(simulation%materials, index), &
               simulation%space%grid%tile_cells, &
               traits)
            store%material = index
            store%wets = is_fluid(simulation%materials(index))
            if (allocated(simulation%effects%contact)) store%material = &
               simulation%effects%contact%material(index)
            if (allocated(simulation%effects%exact)) then
               if (allocated(simulation%effects%exact%material(index)%solution)) &
                  allocate (store%origin%reference(0, 3))
            end if
            ! the functions of the loads that follow the material
            slots = 0
            if (allocated(simulation%effects%loads)) slots = maxval(simulation%effects%loads%slot)
            if (slots > 0) allocate (store%origin%marks(0, mark_columns*slots))
            simulation%scheme%carries_energy = simulation%scheme%carries_energy .or. &
               allocated(store%state%energy)
            simulation%scheme%loose = simulation%scheme%loose .or. &
               is_loose(simulation%materials(index))
         end associate
      end do
      simulation%scheme%works = simulation%scheme%carries_energy .or. &
         allocated(simulation%effects%loads)
      if (allocated(simulation%effects%contact)) call bond_stores(simulation)
   end subroutine make_stores

   !> Count the particles of bodies and tiles, and find the volumes of randomly placed ones.
   subroutine take_survey(simulation, bodies, survey)
      type(simulation_t), intent(in) :: simulation   !! The run without particles
      type(body_t), intent(inout) :: bodies(:)       !! The bodies; get factors of volumes
      type(survey_t), intent(out) :: survey
      integer(int64) :: total(1)

      call set_volume_factors(simulation%machine%communicator, simulation%space%grid, bodies)
      allocate (survey%body(size(bodies)), survey%volume(size(bodies)))
      call survey_bodies(simulation%machine%communicator, simulation%space%grid, bodies, &
         survey%key, &
         survey%particles_of, survey%body, survey%volume)
      total = size(survey%key)
      call simulation%machine%communicator%total(total)
      survey%tiles = total(1)
      survey%particles = sum(survey%body)
   end subroutine take_survey

   !> Fill the bodies with particles, each rank its own tiles.
   subroutine fill_simulation(simulation, bodies, survey)
      type(simulation_t), intent(inout) :: simulation
      type(body_t), intent(inout) :: bodies(:)       !! The bodies; get their first identities
      type(survey_t), intent(in) :: survey           !! Counts of them
      integer(int64), allocatable :: own(:), none(:), border(:), rows(:, :)
      integer :: index, tile
      integer, allocatable :: owner(:)

      call number_bodies(simulation%space%grid, bodies)
      ! the curve is cut so that ranks get equal numbers of particles; each rank gets its tiles
      associate (machine => simulation%machine)
         call partition_scattered_keys(machine%communicator, survey%key, survey%particles_of, &
            border)
         call simulation%space%tiles%cut(border)
         allocate (owner(size(survey%key)), rows(1, size(survey%key)))
         do tile = 1, size(owner)
            rows(1, tile) = survey%key(tile)
            owner(tile) = simulation%space%tiles%owner(survey%key(tile))
         end do
         call machine%communicator%send_rows(owner, rows, own)
         own = own(sort_order(own))
         machine%load%listed = max(size(survey%key, kind=int64), size(own, kind=int64))
      end associate
      allocate (none(0))
      call simulation%space%tiles%set(simulation%space%grid, own, none)
      do index = 1, size(simulation%stores)
         call fill_store(simulation%space%grid, simulation%materials(index), bodies, &
            simulation%space%tiles%coordinate(:, :size(own)), index, simulation%stores(index))
      end do
      call sort_particles(simulation)
   end subroutine fill_simulation

   !> Assign ranges of identities to bodies, one after another.
   pure subroutine number_bodies(grid, bodies, next)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(inout) :: bodies(:)
      integer(int64), intent(out), optional :: next  !! The first that no body has
      integer(int64) :: first
      integer :: body

      first = 1
      do body = 1, size(bodies)
         bodies(body)%first_identity = first
         first = first + product(bodies(body)%sites(grid))
      end do
      if (present(next)) next = first
   end subroutine number_bodies

   !> Fill an empty store with the particles of its bodies in some tiles, in their first state.
   subroutine fill_store(grid, material, bodies, coordinates, index, store)
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: material       !! That of the store
      type(body_t), intent(in) :: bodies(:)          !! With their first identities
      integer, contiguous, intent(in) :: coordinates(:, :) !! (3, tile) Tiles, counted from 0
      integer, intent(in) :: index                   !! Index of the store
      type(store_t), intent(inout) :: store
      integer :: tile

      call store%remap([(0, tile=1, size(coordinates, 2))], grid%tile_cells)
      call fill_bodies(grid, bodies, coordinates, index, store)
      do tile = 1, size(store%count)
         call start_tile(bodies, material, tile, store)
         if (any(bodies%energy > 0.0_wp .and. bodies%store == index) .or. &
            material%starts_with_stress() .or. has_energy(store%state, store%first(tile), &
            store%first(tile) + store%count(tile) - 1)) call material%find_rest_stress( &
            store%state, store%first(tile), store%first(tile) + store%count(tile) - 1)
      end do
      if (allocated(store%state%brittle%scatter)) call draw_strengths(grid, material, bodies, store)
   end subroutine fill_store

   !> Random strength of the particles of a store, from the boxes that they fill.
   subroutine draw_strengths(grid, material, bodies, store)
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: material       !! That of the store
      type(body_t), intent(in) :: bodies(:)
      type(store_t), intent(inout) :: store
      integer :: tile

      !$omp parallel do schedule(dynamic, 16) default(none) &
      !$omp shared(grid, material, bodies, store)
      do tile = 1, size(store%count)
         call draw_strengths_of_tile(grid, material, bodies, tile, store)
      end do
      !$omp end parallel do
   end subroutine draw_strengths

   !> Those of one tile. The blocks of flaws around its particles are found once for all of them.
   subroutine draw_strengths_of_tile(grid, material, bodies, tile, store)
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: material       !! That of the store
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: tile
      type(store_t), intent(inout) :: store
      real(wp), allocatable :: low(:, :), high(:, :)
      type(flaw_blocks_t) :: blocks
      integer :: n, p

      if (store%count(tile) == 0) return
      allocate (low(3, store%count(tile)), high(3, store%count(tile)))
      do n = 1, store%count(tile)
         p = store%first(tile) + n - 1
         call find_box(grid, bodies(body_of(bodies, store%identity(p))), store%identity(p), &
            [store%position(p, 1), store%position(p, 2), store%position(p, 3)], &
            store%state%volume(p), low(:, n), high(:, n))
      end do
      blocks = material%failure%flaws%cover(minval(low, 2), maxval(high, 2))
      do n = 1, store%count(tile)
         call material%draw_strength(store%state, store%first(tile) + n - 1, low(:, n), &
            high(:, n), blocks)
      end do
   end subroutine draw_strengths_of_tile

   !> Set the state of the particles of a tile at the start. The particles of a body are contiguous.
   subroutine start_tile(bodies, material, tile, store)
      type(body_t), intent(in) :: bodies(:)
      type(material_t), intent(in) :: material
      integer, intent(in) :: tile
      type(store_t), intent(inout) :: store
      integer :: body, first, last, most

      first = store%first(tile)
      most = first + store%count(tile) - 1
      do while (first <= most)
         body = body_of(bodies, store%identity(first))
         last = first
         do while (last < most)
            if (body_of(bodies, store%identity(last + 1)) /= body) exit
            last = last + 1
         end do
         call material%start(store%state, first, last, bodies(body)%temperature)
         if (bodies(body)%energy > 0.0_wp) &
            store%state%energy(first:last) = bodies(body)%energy
         first = last + 1
      end do
   end subroutine start_tile

   !> Add the rotation of bodies about their centres of mass, which are found from the particles.
   !! Particles with a linear velocity field rotate like their body.
   subroutine spin_bodies(simulation, bodies)
      type(simulation_t), intent(inout) :: simulation !! With particles
      type(body_t), intent(in) :: bodies(:)
      real(wp) :: arm(3), centre(3), spin(3)
      integer(int64) :: first, last
      integer :: body, k, p, tile

      do body = 1, size(bodies)
         spin = bodies(body)%spin
         if (.not. any(abs(spin) > 0.0_wp)) cycle
         first = bodies(body)%first_identity
         last = first + product(bodies(body)%sites(simulation%space%grid)) - 1
         associate (store => simulation%stores(bodies(body)%store))
            call find_centre(simulation%machine%communicator, store, first, last, centre)
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (store%identity(p) < first .or. store%identity(p) > last) cycle
                  do k = 1, 3
                     arm(k) = store%position(p, k) - centre(k)
                  end do
                  arm = cross(spin, arm)
                  do k = 1, 3
                     store%velocity(p, k) = store%velocity(p, k) + arm(k)
                  end do
                  if (allocated(store%affine)) store%affine(p, :) = [0.0_wp, spin(3), -spin(2), &
                     -spin(3), 0.0_wp, spin(1), spin(2), -spin(1), 0.0_wp]
                  if (allocated(store%spin)) store%spin(p, :) = spin
               end do
            end do
         end associate
      end do
   end subroutine spin_bodies

   !> Centre of mass of the particles of a range of identities, on all ranks [m].
   subroutine find_centre(communicator, store, first, last, centre)
      type(communicator_t), intent(in) :: communicator !! Its ranks hold the particles
      type(store_t), intent(in) :: store
      integer(int64), intent(in) :: first, last      !! Least and greatest identity
      real(wp), intent(out) :: centre(3)             !! [m]
      type(exact_sum_t) :: sums(4)
      integer :: tile, p, k

      do k = 1, 4
         call sums(k)%clear()
      end do
      do tile = 1, size(store%count)
         do p = store%first(tile), store%first(tile) + store%count(tile) - 1
            if (store%identity(p) < first .or. store%identity(p) > last) cycle
            do k = 1, 3
               call sums(k)%add(store%state%mass(p)*store%position(p, k))
            end do
            call sums(4)%add(store%state%mass(p))
         end do
      end do
      do k = 1, 4
         call sums(k)%over_ranks(communicator)
      end do
      centre = [sums(1)%value(), sums(2)%value(), sums(3)%value()]/sums(4)%value()
   end subroutine find_centre

   !> Index of the body of a particle.
   pure integer function body_of(bodies, identity) result(body)
      type(body_t), intent(in) :: bodies(:)
      integer(int64), intent(in) :: identity         !! Identity of the particle
      integer :: last, middle

      body = 1
      last = size(bodies)
      do while (body < last)
         middle = (body + last + 1)/2
         if (identity >= bodies(middle)%first_identity) then
            body = middle
         else
            last = middle - 1
         end if
      end do
   end function body_of

   !> Redistribute the particles over the ranks and sort each into its tile; the old tiles are
   !! discarded. For particles that were just read, each store in one range.
   subroutine distribute_particles(simulation)
      type(simulation_t), intent(inout) :: simulation
      integer(int64), allocatable :: key(:), particles(:), border(:)
      integer :: n

      call count_tiles(simulation, key, particles)
      simulation%machine%load%listed = size(key, kind=int64)
      call partition_scattered_keys(simulation%machine%communicator, key, particles, border)
      call simulation%space%tiles%cut(border)
      call simulation%space%halo%links%forget()
      do n = 1, size(simulation%stores)
         call simulation%stores(n)%mark_all_leaving(simulation%space%grid%tile_cells)
      end do
      call sort_particles(simulation)
   end subroutine distribute_particles

   !> Count the particles of this rank in each tile. Successive particles are usually in the same
   !! tile, so the lists that are sorted are about as long as the tiles, not the particles.
   subroutine count_tiles(simulation, key, particles)
      type(simulation_t), intent(in) :: simulation
      integer(int64), allocatable, intent(out) :: key(:)       !! Tiles with particles, ascending
      integer(int64), allocatable, intent(out) :: particles(:) !! (tile) Number of particles
      integer(int64), allocatable :: run(:, :)
      integer, allocatable :: order(:)
      integer :: n, filled

      call list_runs(simulation, run)
      order = sort_order(run(1, :))
      allocate (key(size(order)), particles(size(order)))
      filled = 0
      do n = 1, size(order)
         if (filled > 0) then
            if (key(filled) == run(1, order(n))) then
               particles(filled) = particles(filled) + run(2, order(n))
               cycle
            end if
         end if
         filled = filled + 1
         key(filled) = run(1, order(n))
         particles(filled) = run(2, order(n))
      end do
      key = key(:filled)
      particles = particles(:filled)
   end subroutine count_tiles

   !> Runs of successive particles in the same tile.
   subroutine list_runs(simulation, run)
      type(simulation_t), intent(in) :: simulation
      integer(int64), allocatable, intent(out) :: run(:, :) !! (2, run) Tile, and particles
      integer(int64), allocatable :: whole(:, :), longer(:, :)
      integer(int64) :: key
      integer :: index, n, filled, owner(3), cells(3)
      logical :: again, lost

      allocate (run(2, 64))
      filled = 0
      do index = 1, size(simulation%stores)
         associate (position => simulation%stores(index)%position)
            do n = 1, simulation%stores(index)%particles()
               call find_place(simulation%space%grid, simulation%space%boundary, [position(n, 1), &
                  position(n, 2), position(n, 3)], owner, cells, lost)
               key = hilbert_key(owner, simulation%space%grid%dimensions)
               ! it belongs to the last run, or begins a new one in another tile
               again = filled > 0
               if (again) again = run(1, filled) == key
               if (again) then
                  run(2, filled) = run(2, filled) + 1
                  cycle
               end if
               if (filled == size(run, 2)) then
                  allocate (longer(2, 2*filled))
                  longer(:, :filled) = run
                  call move_alloc(longer, run)
               end if
               filled = filled + 1
               run(:, filled) = [key, 1_int64]
            end do
         end associate
      end do
      allocate (whole(2, filled), source=run(:, :filled))
      call move_alloc(whole, run)
   end subroutine list_runs

   !> Stable time step for the initial state [s].
   subroutine first_step(simulation)
      type(simulation_t), intent(inout) :: simulation
      real(wp) :: diffusivity, fastest, signal, greatest, speed
      integer :: index, tile, p

      fastest = 0.0_wp
      greatest = 0.0_wp
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            do tile = 1, size(store%count)
               signal = simulation%materials(index)%signal_speed(store%state, &
                  store%first(tile), store%first(tile) + store%count(tile) - 1)
               greatest = max(greatest, signal)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  speed = sqrt(store%velocity(p, 1)**2 + store%velocity(p, 2)**2 &
                     + store%velocity(p, 3)**2)
                  fastest = max(fastest, signal + speed)
               end do
            end do
         end associate
      end do
      fastest = simulation%machine%communicator%maximum(fastest)
      diffusivity = 0.0_wp
      if (allocated(simulation%effects%conduction)) diffusivity = &
         simulation%machine%communicator%maximum(greatest_diffusivity(simulation%materials, &
         simulation%stores))
      call find_stable_step(simulation%space, simulation%scheme%method%cfl, fastest, diffusivity, &
         simulation%clock%dt_next, simulation%clock%guard%rule)
      if (allocated(simulation%space%cell)) call start_cell(simulation, &
         simulation%machine%communicator%maximum(greatest))
   end subroutine first_step
end module scene_particles
