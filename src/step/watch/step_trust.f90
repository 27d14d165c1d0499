! SPDX-License-Identifier: BSD-3-Clause
!> Watches whether the results of a run can be trusted beyond its balances: speeds and
!! energies, distances of neighbours, volumes and pressures. It warns once of each quantity and
!! stops the run if a value is physically impossible. The values and their limits are (L.8) to
!! (L.11) of doc/theory/ledger.md.
module step_trust
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_physics, fail
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use base_log, only: log_t
   use material_kinds, only: is_fluid
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use mesh_motion, only: motion_t
   use mesh_rigid_body, only: rigid_body_t
   use particle_body, only: body_t
   use particle_store, only: store_t
   use step_diagnostics, only: bounds_limits_t, bounds_sample_t, examine_bounds, examine_shapes, &
      find_greatest, measure_cold, measure_energy, measure_heat, measure_speed, measure_volume, &
      shapes_sample_t
   use step_ledger, only: balance_t, external_work, internal, ledger_t, mass, retired_mass, torque
   use step_offending_particle, only: fixed_step_text, name_particle, step_text
   use step_simulation, only: scheme_t, simulation_effects_t, simulation_t, space_t
   use step_trust_record, only: apart, trust_angular, trust_bad, trust_damped, trust_energy, &
      trust_heat, trust_mean, trust_momentum, trust_noise, trust_ok, trust_retired, trust_speed, &
      trust_stretch, trust_t, trust_volume, verdict_of
   implicit none
   private

   public :: begin_trust, final_trust, number_lattices, watch_trust

   !> Material slower than this fraction of the wave speed, or of the square root of its internal
   !! energy per mass where that is greater, as in a gas, is at rest, and its momentum is rounding
   !! [1]
   real(wp), parameter :: slow = 1.0e-3_wp
   integer(int64), parameter :: bounds_every = 5     !! Steps between checks of speed and energy
   integer(int64), parameter :: work_every = 50      !! ... between sums of the work
   !> Steps between checks of distances, volumes and noise; shorter at first, for short runs
   integer(int64), parameter :: shapes_every = 250, shapes_first = 50, shapes_later = 1000
   !> Particles beyond these multiples of the explained speed and energy are implausible [1]
   real(wp), parameter :: fast = 2.0_wp, hot = 4.0_wp, cold = 1.0_wp
   !> Speeds below this fraction of the wave speed are rounding [1]
   real(wp), parameter :: still = 1.0e-12_wp

contains

   !> Number the lattices of the bodies, which identify neighbours.
   subroutine number_lattices(grid, effects, trust, bodies)
      type(grid_t), intent(in) :: grid
      type(simulation_effects_t), intent(in) :: effects
      type(trust_t), intent(inout) :: trust
      type(body_t), intent(in) :: bodies(:)
      integer(int64) :: next
      integer :: n, other

      if (allocated(trust%lattices)) deallocate (trust%lattices)
      allocate (trust%lattices(size(bodies)))
      next = 1
      do n = 1, size(bodies)
         associate (lattice => trust%lattices(n))
            lattice%first = next
            lattice%sites = bodies(n)%sites(grid)
            lattice%regular = bodies(n)%on_lattice()
            next = next + product(lattice%sites)
            lattice%origin = lattice%first
            if (allocated(effects%contact) .or. .not. lattice%regular) cycle
            ! without contact bodies of one lattice that touch at the start move as one
            do other = 1, n - 1
               if (bodies(other)%store /= bodies(n)%store .or. .not. &
                  bodies(other)%on_lattice()) cycle
               if (any(bodies(other)%per_cell /= bodies(n)%per_cell)) cycle
               lattice%origin = trust%lattices(other)%origin
               exit
            end do
         end associate
      end do
   end subroutine number_lattices

   !> Record speeds and energies at the start of a run, the reference for later ones. Collective.
   subroutine begin_trust(simulation)
      type(simulation_t), intent(inout) :: simulation !! In its initial state
      type(bounds_sample_t) :: sample

      if (simulation%balance%trust%begun) return
      call examine_bounds(simulation%space%tiles, simulation%stores, &
         simulation%machine%communicator, 0.0_wp, bounds_limits_t(), sample)
      associate (trust => simulation%balance%trust)
         trust%begun = .true.
         trust%checked = simulation%clock%time
         trust%start_speed = sample%speed
         trust%start_energy = &
            simulation%machine%communicator%maximum(greatest_stored(simulation%materials, &
            simulation%stores))
         if (sample%cold < huge(sample%cold)) trust%least_energy = sample%cold
      end associate
   end subroutine begin_trust

   !> Greatest energy per mass that a particle of this rank carries or stores elastically [J/kg].
   function greatest_stored(materials, stores) result(greatest)
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      real(wp) :: greatest
      real(wp), allocatable :: energy(:)
      integer :: index, tile, first, last

      greatest = 0.0_wp
      do index = 1, size(stores)
         associate (store => stores(index))
            do tile = 1, size(store%count)
               if (store%count(tile) == 0) cycle
               first = store%first(tile)
               last = first + store%count(tile) - 1
               allocate (energy(store%count(tile)))
               call materials(index)%stored_energy(store%state, first, last, energy)
               greatest = max(greatest, maxval(energy/store%state%mass(first:last)))
               deallocate (energy)
            end do
         end associate
      end do
   end function greatest_stored

   !> Check the state after a step if a check is due. Collective.
   subroutine watch_trust(simulation, log, error)
      type(simulation_t), intent(inout) :: simulation !! After a step
      type(log_t), intent(inout) :: log              !! Gets each warning once
      type(error_t), allocatable, intent(out) :: error !! A number is impossible
      type(bounds_sample_t) :: bounds
      type(shapes_sample_t) :: shapes

      if (mod(simulation%clock%step, work_every) == 0) call note_work(simulation%balance%ledger, &
         simulation%machine%communicator, simulation%balance%trust)
      if (mod(simulation%clock%step, bounds_every) == 0) then
         call measure_bounds(simulation, simulation%balance%trust, bounds)
         call note_bounds(simulation%space, simulation%materials, simulation%effects, &
            simulation%balance%ledger, bounds, simulation%balance%trust)
         call warn_of_bounds(simulation, bounds, log)
         call refuse_impossible(simulation, bounds, error)
         if (allocated(error)) return
      end if
      if (mod(simulation%clock%step, merge(shapes_first, shapes_every, &
         simulation%clock%step < shapes_later)) == 0) then
         call examine_shapes(simulation%space, simulation%materials, simulation%stores, &
            simulation%balance%trust, simulation%machine%communicator, shapes)
         call note_shapes(shapes, simulation%clock%time, simulation%balance%trust)
         call warn_of_shapes(simulation, shapes, log)
      end if
   end subroutine watch_trust

   !> The record at the end, with the last state if a run could continue from it. The data of a
   !! checkpoint do not change, so that a continued run gives the same record as an uninterrupted
   !! one. Collective.
   subroutine final_trust(simulation, code, now, trust)
      type(simulation_t), intent(inout) :: simulation !! At the end of the run; not changed
      integer, intent(in) :: code                    !! Exit code
      type(balance_t), intent(in) :: now             !! Balance at this time
      type(trust_t), intent(out) :: trust            !! Measures of trust
      type(bounds_sample_t) :: bounds
      type(shapes_sample_t) :: shapes

      trust = simulation%balance%trust
      trust%failed = code == exit_physics
      if (trust%begun .and. code /= exit_physics) then
         call note_work(simulation%balance%ledger, simulation%machine%communicator, trust)
         call measure_bounds(simulation, trust, bounds)
         call note_bounds(simulation%space, simulation%materials, simulation%effects, &
            simulation%balance%ledger, bounds, trust)
         call examine_shapes(simulation%space, simulation%materials, simulation%stores, &
            simulation%balance%trust, simulation%machine%communicator, shapes)
         call note_shapes(shapes, simulation%clock%time, trust)
      end if
      trust%worst(trust_energy) = abs(now%energy_error)
      trust%worst(trust_damped) = now%damped_share
      associate (ledger => simulation%balance%ledger)
         if (ledger%momentum_scale > 0.0_wp) trust%worst(trust_momentum) = now%momentum_error &
            *ledger%momentum_scale/max(ledger%momentum_scale, slow*ledger%start%entry(mass) &
            *sqrt(max(greatest_wave_square(simulation%materials), &
            now%entry(internal)/ledger%start%entry(mass))))
      end associate
      call rate_turning(simulation%space, simulation%effects, now, trust)
      if (simulation%balance%ledger%start%entry(mass) > 0.0_wp) trust%worst(trust_retired) = &
         now%entry(retired_mass)/simulation%balance%ledger%start%entry(mass)
   end subroutine final_trust

   !> Error of the balance of angular momentum. Where walls, rigid regions or loads exert torques
   !! that cancel, as under a footing, a small part of them exceeds the slow motion: not measured.
   !! Gravity alone exerts none about the centre of mass. Equation (L.14).
   pure subroutine rate_turning(space, effects, now, trust)
      type(space_t), intent(in) :: space
      type(simulation_effects_t), intent(in) :: effects
      type(balance_t), intent(in) :: now             !! Balance at this time
      type(trust_t), intent(inout) :: trust          !! Gets the error
      logical :: held

      held = allocated(space%boundary%wall) .or. allocated(space%rigid) .or. &
         allocated(effects%loads)
      if (held) held = any(abs(now%entry(torque:torque + 2)) > 0.0_wp)
      if (held .or. allocated(effects%exact)) return
      trust%worst(trust_angular) = now%turn_error
   end subroutine rate_turning

   !> Update distances, volumes and pressures. Material that has separated stays apart, so its
   !! greatest fraction is rated; pressures fluctuate, so their mean over time is rated.
   !! Equation (L.9).
   pure subroutine note_shapes(sample, time, trust)
      type(shapes_sample_t), intent(in) :: sample        !! Measured values
      real(wp), intent(in) :: time                   !! Time of the sample [s]
      type(trust_t), intent(inout) :: trust          !! The values so far
      real(wp) :: passed

      passed = time - trust%checked
      trust%checked = time
      trust%integral([1, 2, 5]) = trust%integral([1, 2, 5]) + passed*[sample%overlap, &
         sample%share, sample%difference**2]
      trust%whole([1, 2, 5]) = trust%whole([1, 2, 5]) + passed*[1.0_wp, 1.0_wp, sample%stress**2]
      associate (greatest => trust%greatest, worst => trust%worst)
         greatest(trust_stretch) = max(greatest(trust_stretch), sample%longest)
         if (sample%stress > 0.0_wp) &
            greatest(trust_noise) = max(greatest(trust_noise), sample%difference/sample%stress)
         worst(trust_stretch) = max(worst(trust_stretch), sample%share)
         worst(trust_volume) = max(worst(trust_volume), sample%overlap)
         worst(trust_noise) = trust_mean(trust, 5)
      end associate
   end subroutine note_shapes

   !> Measure speeds and energies, with the limits of plausible ones: equations (L.10) and (L.11) of
   !! doc/theory/ledger.md. Collective.
   subroutine measure_bounds(simulation, trust, sample)
      type(simulation_t), intent(inout) :: simulation
      type(trust_t), intent(in) :: trust             !! Values so far
      type(bounds_sample_t), intent(out) :: sample       !! Measured values
      type(bounds_limits_t) :: limits
      real(wp) :: scale

      limits%square = fast**2*explained_square(simulation%space, simulation%materials, &
         simulation%effects, simulation%balance%ledger, trust)
      scale = explained_energy(simulation%space, simulation%materials, simulation%effects, &
         simulation%balance%ledger, trust)
      limits%hot = trust%least_energy + hot*scale
      limits%cold = trust%least_energy - cold*scale
      call examine_bounds(simulation%space%tiles, simulation%stores, &
         simulation%machine%communicator, trust%least_energy, limits, sample)
   end subroutine measure_bounds

   !> Update speeds and energies. The energy of implausible particles is rated by its mean over the
   !! steps: a few fast particles while hardly anything moves have no weight, and an instability,
   !! which grows while steps become short, dominates. Manufactured solutions have no limits.
   pure subroutine note_bounds(space, materials, effects, ledger, sample, trust)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(simulation_effects_t), intent(in) :: effects
      type(ledger_t), intent(in) :: ledger
      type(bounds_sample_t), intent(in) :: sample        !! Measured values
      type(trust_t), intent(inout) :: trust          !! The values so far
      real(wp) :: square, scale

      if (allocated(effects%exact)) return
      square = explained_square(space, materials, effects, ledger, trust)
      associate (greatest => trust%greatest, worst => trust%worst)
         trust%integral(3) = trust%integral(3) + sample%fast
         trust%integral(4) = trust%integral(4) + sample%odd
         trust%whole(3:4) = trust%whole(3:4) + sample%whole
         if (square > 0.0_wp) then
            greatest(trust_speed) = max(greatest(trust_speed), sample%speed/sqrt(square))
            worst(trust_speed) = trust_mean(trust, 3)
         end if
         scale = explained_energy(space, materials, effects, ledger, trust)
         if (sample%heat < sample%cold .or. .not. scale > 0.0_wp) return
         worst(trust_heat) = trust_mean(trust, 4)
         call take_worse(greatest(trust_heat), (sample%heat - trust%least_energy)/scale)
         call take_worse(greatest(trust_heat), (sample%cold - trust%least_energy)/scale)
      end associate
   end subroutine note_bounds

   !> Update the value of heat that is farthest beyond its limit.
   pure subroutine take_worse(worst, value)
      real(wp), intent(inout) :: worst               !! So far
      real(wp), intent(in) :: value                  !! Another one

      if (max(value/hot, -value/cold) > max(worst/hot, -worst/cold)) worst = value
   end subroutine take_worse

   !> Energy per mass that start, walls, gravity and work explain [J/kg].
   pure real(wp) function explained_energy(space, materials, effects, ledger, trust) result(energy)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(simulation_effects_t), intent(in) :: effects
      type(ledger_t), intent(in) :: ledger
      type(trust_t), intent(in) :: trust             !! Values so far

      energy = max(0.5_wp*explained_square(space, materials, effects, ledger, trust), &
         0.01_wp*greatest_wave_square(materials))
   end function explained_energy

   !> Update the greatest work of walls and gravity so far. Collective.
   subroutine note_work(ledger, communicator, trust)
      type(ledger_t), intent(in) :: ledger
      type(communicator_t), intent(in) :: communicator
      type(trust_t), intent(inout) :: trust          !! The greatest so far
      type(exact_sum_t) :: sum

      call sum%merge(ledger%sums(external_work))
      call sum%over_ranks(communicator)
      trust%work = max(trust%work, abs(sum%value()))
   end subroutine note_work

   !> Square of the greatest speed that start, walls, gravity, energy at the start and work explain
   !! [m2/s2]. Equation (L.10).
   pure real(wp) function explained_square(space, materials, effects, ledger, trust) result(square)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(simulation_effects_t), intent(in) :: effects
      type(ledger_t), intent(in) :: ledger
      type(trust_t), intent(in) :: trust             !! Values at the start
      integer :: n

      square = max(trust%start_speed**2, 2.0_wp*trust%start_energy, &
         still**2*greatest_wave_square(materials))
      associate (boundary => space%boundary, grid => space%grid)
         if (allocated(boundary%wall)) then
            do n = 1, size(boundary%wall)
               square = max(square, greatest_motion(boundary%wall(n)%motion)**2)
            end do
         end if
         do n = 1, 6
            if (boundary%warm(n)) square = max(square, 2.0_wp*boundary%temperature(n) &
               *greatest_capacity(materials))
         end do
         if (allocated(effects%gravity)) square = &
            max(square, 2.0_wp*sum(abs(effects%gravity)*(grid%upper - grid%lower), &
            mask=grid%active))
         if (allocated(effects%shaking)) square = &
            max(square, 2.0_wp* greatest_motion(effects%shaking)*norm2(grid%upper - grid%lower))
      end associate
      if (allocated(space%rigid)) then
         do n = 1, size(space%rigid%wall)
            square = max(square, greatest_motion(space%rigid%wall(n)%motion)**2)
            if (allocated(space%rigid%wall(n)%body)) square = max(square, &
               first_speed(space%rigid%wall(n)%body, space%grid)**2, &
               pushed_square(space%rigid%wall(n)%body, space%grid))
         end do
      end if
      associate (whole => ledger%start%entry(mass))
         if (whole > 0.0_wp) square = max(square, 2.0_wp*trust%work/whole)
      end associate
      ! loads may act on a small part of a body at rest, whose mean work is then small
      square = max(square, 2.0_wp*trust%load_work)
   end function explained_square

   !> Greatest speed of a point of a rigid body in the domain at the start, or more [m/s].
   pure real(wp) function first_speed(body, grid) result(speed)
      type(rigid_body_t), intent(in) :: body
      type(grid_t), intent(in) :: grid

      speed = norm2(body%first_velocity) + norm2(body%first_spin)*min(body%radius, &
         norm2(max(abs(grid%upper - body%home), abs(grid%lower - body%home))))
   end function first_speed

   !> Square of the greatest speed that its external force can give a rigid body [m2/s2].
   pure real(wp) function pushed_square(body, grid) result(square)
      type(rigid_body_t), intent(in) :: body
      type(grid_t), intent(in) :: grid

      square = 0.0_wp
      if (body%mass > 0.0_wp) square = 2.0_wp/body%mass*sum(abs(body%force)*(grid%upper &
         - grid%lower), mask=body%free)
   end function pushed_square

   !> Greatest speed of a wall, or more [m/s].
   pure real(wp) function greatest_motion(motion) result(speed)
      type(motion_t), intent(in) :: motion           !! Motion of the material

      speed = norm2(motion%steady)
      if (allocated(motion%time)) speed = speed + sqrt(maxval(sum(motion%speed**2, dim=1)))
   end function greatest_motion

   !> Greatest specific heat of the materials [J/(kg K)].
   pure real(wp) function greatest_capacity(materials) result(capacity)
      type(material_t), intent(in) :: materials(:)
      integer :: n

      capacity = 0.0_wp
      do n = 1, size(materials)
         if (allocated(materials(n)%heat)) &
            capacity = max(capacity, materials(n)%heat%specific_heat)
      end do
   end function greatest_capacity

   !> Square of the greatest wave speed of the materials at rest [m2/s2].
   pure real(wp) function greatest_wave_square(materials) result(square)
      type(material_t), intent(in) :: materials(:)
      integer :: n

      square = 0.0_wp
      do n = 1, size(materials)
         square = max(square, materials(n)%reference_speed()**2)
      end do
   end function greatest_wave_square

   !> Warn of a speed or an energy without a physical cause, with the particle that has it.
   !! Collective.
   subroutine warn_of_bounds(simulation, sample, log)
      type(simulation_t), intent(inout) :: simulation !! Set after the warning
      type(bounds_sample_t), intent(in) :: sample        !! Measured values
      type(log_t), intent(inout) :: log              !! Gets the warnings
      character(len=160) :: text

      associate (trust => simulation%balance%trust)
         if (is_warning_due(trust, trust_speed)) then
            write (text, "(a,es10.3,a,es9.2,a)") "its speed", sample%speed, " m/s is", &
               trust%greatest(trust_speed), " times the speed that initial "// &
               "state, walls, gravity and work explain"
            call warn_of_particle(simulation, log, find_greatest(simulation%materials, &
               simulation%stores, simulation%machine%communicator, measure_speed, &
               trust%least_energy), trim(text)//"; check units and constants of its material, "// &
               "try a smaller "//trim(merge("dt_fixed", "cfl     ", &
               simulation%clock%guard%bounds%dt_fixed > 0.0_wp))// &
               " or more particles per cell (ppc) [R112]")
         end if
         if (.not. is_warning_due(trust, trust_heat)) return
         if (trust%greatest(trust_heat) > 0.0_wp) then
            write (text, "(a,es10.3,a,es9.2,a)") "its internal energy", sample%heat, " J/kg is", &
               trust%greatest(trust_heat), " times the energy supplied"
            call warn_of_particle(simulation, log, find_greatest(simulation%materials, &
               simulation%stores, simulation%machine%communicator, measure_heat, &
               trust%least_energy), trim(text)//"; check its equation of state, or remove "// &
               "such particles with &time on_bad = 'retire' [R113]")
         else
            write (text, "(a,es10.3,a,es9.2,a)") "its internal energy ", sample%cold, &
               " J/kg is below the least initial energy by", -trust%greatest(trust_heat), &
               " times the energy supplied"
            call warn_of_particle(simulation, log, find_greatest(simulation%materials, &
               simulation%stores, simulation%machine%communicator, measure_cold, &
               trust%least_energy), trim(text)//"; check its equation of state in expansion, "// &
               "or give the material a spall strength [R113]")
         end if
      end associate
   end subroutine warn_of_bounds

   !> Warn of large gaps between neighbours, and of overlapping volumes. Collective.
   subroutine warn_of_shapes(simulation, sample, log)
      type(simulation_t), intent(inout) :: simulation !! Set after the warning
      type(shapes_sample_t), intent(in) :: sample        !! Measured values
      type(log_t), intent(inout) :: log              !! Gets the warnings
      character(len=200) :: text

      associate (trust => simulation%balance%trust)
         if (is_warning_due(trust, trust_stretch)) then
            write (text, "(a,f0.2,a,f0.1,a,f0.1,a)") "its neighbour is ", sample%longest, &
               " cells away, and in ", 100.0_wp*sample%share, &
               " % of the mass neighbours are more than ", apart, " cells apart"
            call warn_of_particle(simulation, log, sample%longest_identity, trim(text)//": "// &
               "they no longer interact; use more particles per cell (ppc), or &method split "// &
               "= .true. [R114]")
         end if
         if (verdict_of(trust_volume, trust%worst(trust_volume)) /= trust_bad) return
         if (.not. is_warning_due(trust, trust_volume)) return
         write (text, "(a,f0.1,a)") "its volume has grown most, and particles have ", &
            100.0_wp*sample%overlap, " % more volume than the cells that they fill"
         call warn_of_particle(simulation, log, find_greatest(simulation%materials, &
            simulation%stores, simulation%machine%communicator, measure_volume, &
            trust%least_energy), trim(text)//"; "//volume_remedy(simulation%materials, &
            simulation%scheme)//" [R115]")
      end associate
   end subroutine warn_of_shapes

   !> Remedy for volumes that exceed those of the cells.
   function volume_remedy(materials, scheme) result(remedy)
      type(material_t), intent(in) :: materials(:)
      type(scheme_t), intent(in) :: scheme
      character(len=:), allocatable :: remedy
      integer :: n

      remedy = "use a lattice or more particles per cell (ppc)"
      if (allocated(scheme%normalises) .or. .not. scheme%method%dual) return
      if (any([(is_fluid(materials(n)), n=1, size(materials))])) remedy = &
         "use &method normalise = 'fluids', a lattice or more particles per cell (ppc)"
   end function volume_remedy

   !> Is a warning due? It is given once, when a value is no longer ok.
   logical function is_warning_due(trust, entry) result(due)
      type(trust_t), intent(inout) :: trust          !! Notes that the warning is printed
      integer, intent(in) :: entry                   !! Subject of the warning

      due = .false.
      if (trust%warned(entry)) return
      due = verdict_of(entry, trust%worst(entry)) /= trust_ok
      trust%warned(entry) = due
   end function is_warning_due

   !> Print a warning with step, time and a particle. Collective.
   subroutine warn_of_particle(simulation, log, identity, words)
      type(simulation_t), intent(in) :: simulation
      type(log_t), intent(inout) :: log              !! Gets the warning
      integer(int64), intent(in) :: identity         !! Identity of the particle
      character(len=*), intent(in) :: words          !! Error message
      character(len=:), allocatable :: who

      call name_particle(simulation, identity, who)
      call log%warn("warning: "//step_text(simulation%clock)//": "//who//": "//words)
   end subroutine warn_of_particle

   !> A particle cannot have more than the total energy; with twice the total energy the run stops.
   !! Collective.
   subroutine refuse_impossible(simulation, sample, error)
      type(simulation_t), intent(in) :: simulation
      type(bounds_sample_t), intent(in) :: sample        !! Measured values
      type(error_t), allocatable, intent(out) :: error !! If so
      real(wp), parameter :: margin = 2.0_wp, rounding = 1.0e-9_wp
      real(wp) :: available
      character(len=:), allocatable :: who
      character(len=160) :: text

      if (allocated(simulation%effects%exact) .or. holds_heat(simulation%scheme, &
         simulation%materials)) return
      associate (trust => simulation%balance%trust, start => simulation%balance%ledger%start)
         available = start%total - min(0.0_wp, trust%least_energy)*start%entry(mass) + trust%work
         ! a body below t_ref has negative energy, and its sum leaves round-off
         if (.not. available > rounding*abs(start%total) .or. sample%energy <= margin*available) &
            return
         call name_particle(simulation, find_greatest(simulation%materials, simulation%stores, &
            simulation%machine%communicator, measure_energy, trust%least_energy), who)
         write (text, "(a,es10.3,a,es10.3,a)") "it has an energy of", sample%energy, &
            " J, more than the energy of the whole run,", available, " J"
      end associate
      call fail(error, exit_physics, step_text(simulation%clock)//": "//who//": "//trim(text)// &
         " [R111]"//fixed_step_text(simulation%scheme%method, simulation%clock))
   end subroutine refuse_impossible
   !> True if a material has a temperature and no internal energy, while others have one. Heat that
   !! is conducted between them is not in the energy balance.
   pure logical function holds_heat(scheme, materials) result(yes)
      type(scheme_t), intent(in) :: scheme
      type(material_t), intent(in) :: materials(:)
      integer :: n

      yes = .false.
      if (.not. scheme%carries_energy) return
      do n = 1, size(materials)
         yes = yes .or. (allocated(materials(n)%heat) .and. .not. &
            materials(n)%carries_energy())
      end do
   end function holds_heat
end module step_trust
