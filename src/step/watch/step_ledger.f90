! SPDX-License-Identifier: BSD-3-Clause
!> The ledger of a run: mass, momentum and energy in the box, lost through its boundaries, and
!! brought in from outside. All sums are exact, so they are the same for any ranks and threads.
!! Equations (L.5) and (L.6) of doc/theory/ledger.md.
module step_ledger
   use base_communicator, only: communicator_t
   use base_elementary, only: cross
   use base_error, only: error_t, exit_file, fail
   use base_exact_sum, only: exact_sum_t, exact_sum_words
   use base_exact_totals, only: total_words
   use base_kinds, only: int64, wp
   use io_state, only: state_t
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use mesh_wall_sums, only: wall_sums_t
   use particle_store, only: moved_out, store_t
   use sample_pick, only: pick_rule_t
   implicit none
   private

   public :: balance_t, clear_meaningless, ledger_entries, ledger_t, sum_store

   !> A column of the ledger. Entries that accumulate are sums since the start, the others are sums
   !! over the particles in the box.
   type :: ledger_entry_t
      character(len=26) :: name                      !! As in histories
      character(len=7) :: unit                       !! SI unit
      logical :: accumulates                         !! Kept in running sums and checkpoints
      integer :: axis = 0                            !! Direction of a component, 0: not a vector
      logical :: is_moment = .false.                 !! Component of a moment about the origin
   end type ledger_entry_t

   ! Indices of entries; a vector has three. The list below is in this order, as
   ! test_step_ledger checks: flang 19 takes no search of the names as a constant.
   !> Mass in the box.
   integer, parameter, public :: mass = 1
   !> First of three components of momentum.
   integer, parameter, public :: momentum = mass + 1
   !> First of three components of angular momentum.
   integer, parameter, public :: angular = momentum + 3
   !> Kinetic energy.
   integer, parameter, public :: kinetic = angular + 3
   !> Internal energy.
   integer, parameter, public :: internal = kinetic + 1
   !> Work into artificial viscosity.
   integer, parameter, public :: viscous = internal + 1
   !> Work into plastic flow.
   integer, parameter, public :: plastic = viscous + 1
   !> Mass that has left the box.
   integer, parameter, public :: lost_mass = plastic + 1
   !> First of three components of its momentum.
   integer, parameter, public :: lost_momentum = lost_mass + 1
   !> Its energy.
   integer, parameter, public :: lost_energy = lost_momentum + 3
   !> First of three components from walls and gravity.
   integer, parameter, public :: impulse = lost_energy + 1
   !> Work of walls and gravity.
   integer, parameter, public :: external_work = impulse + 3
   !> Mass of failed particles.
   integer, parameter, public :: failed_mass = external_work + 1
   !> First of three components of the angular momentum that has left the box.
   integer, parameter, public :: lost_angular = failed_mass + 1
   !> First of three components of the moment of the impulse.
   integer, parameter, public :: torque = lost_angular + 3
   !> Viscous and plastic work and damping in materials without internal energy.
   integer, parameter, public :: dissipated = torque + 3
   !> Mass of removed particles.
   integer, parameter, public :: removed_mass = dissipated + 1
   !> First of three components of its momentum.
   integer, parameter, public :: removed_momentum = removed_mass + 1
   !> Its energy.
   integer, parameter, public :: removed_energy = removed_momentum + 3
   !> First of three components of its angular momentum.
   integer, parameter, public :: removed_angular = removed_energy + 1
   !> Number of these particles.
   integer, parameter, public :: removed_particles = removed_angular + 3
   !> Mass of those that had left their bounds.
   integer, parameter, public :: retired_mass = removed_particles + 1
   !> Energy removed by the PIC fraction, and by the strain of `usl` in scenes with loose grains,
   !! that no internal energy gains.
   integer, parameter, public :: damped = retired_mass + 1
   !> First of three components of the momentum of rigid bodies.
   integer, parameter, public :: rigid_momentum = damped + 1
   !> First of three components of their angular momentum about the origin.
   integer, parameter, public :: rigid_angular = rigid_momentum + 3
   !> Their kinetic energy.
   integer, parameter, public :: rigid_kinetic = rigid_angular + 3

   !> All entries, in the order of columns and checkpoints.
   type(ledger_entry_t), parameter :: ledger_entries(rigid_kinetic) = [ &
      ledger_entry_t("mass", "kg", .false.), &
      ledger_entry_t("momentum_x", "kg m/s", .false., 1, .false.), &
      ledger_entry_t("momentum_y", "kg m/s", .false., 2, .false.), &
      ledger_entry_t("momentum_z", "kg m/s", .false., 3, .false.), &
      ledger_entry_t("angular_momentum_x", "kg m2/s", .false., 1, .true.), &
      ledger_entry_t("angular_momentum_y", "kg m2/s", .false., 2, .true.), &
      ledger_entry_t("angular_momentum_z", "kg m2/s", .false., 3, .true.), &
      ledger_entry_t("kinetic", "J", .false.), &
      ledger_entry_t("internal", "J", .false.), &
      ledger_entry_t("viscous", "J", .true.), &
      ledger_entry_t("plastic", "J", .true.), &
      ledger_entry_t("lost_mass", "kg", .true.), &
      ledger_entry_t("lost_momentum_x", "kg m/s", .true., 1, .false.), &
      ledger_entry_t("lost_momentum_y", "kg m/s", .true., 2, .false.), &
      ledger_entry_t("lost_momentum_z", "kg m/s", .true., 3, .false.), &
      ledger_entry_t("lost_energy", "J", .true.), &
      ledger_entry_t("impulse_x", "N s", .true., 1, .false.), &
      ledger_entry_t("impulse_y", "N s", .true., 2, .false.), &
      ledger_entry_t("impulse_z", "N s", .true., 3, .false.), &
      ledger_entry_t("external_work", "J", .true.), &
      ledger_entry_t("failed_mass", "kg", .false.), &
      ledger_entry_t("lost_angular_momentum_x", "kg m2/s", .true., 1, .true.), &
      ledger_entry_t("lost_angular_momentum_y", "kg m2/s", .true., 2, .true.), &
      ledger_entry_t("lost_angular_momentum_z", "kg m2/s", .true., 3, .true.), &
      ledger_entry_t("torque_impulse_x", "N m s", .true., 1, .true.), &
      ledger_entry_t("torque_impulse_y", "N m s", .true., 2, .true.), &
      ledger_entry_t("torque_impulse_z", "N m s", .true., 3, .true.), &
      ledger_entry_t("dissipated", "J", .true.), &
      ledger_entry_t("removed_mass", "kg", .true.), &
      ledger_entry_t("removed_momentum_x", "kg m/s", .true., 1, .false.), &
      ledger_entry_t("removed_momentum_y", "kg m/s", .true., 2, .false.), &
      ledger_entry_t("removed_momentum_z", "kg m/s", .true., 3, .false.), &
      ledger_entry_t("removed_energy", "J", .true.), &
      ledger_entry_t("removed_angular_momentum_x", "kg m2/s", .true., 1, .true.), &
      ledger_entry_t("removed_angular_momentum_y", "kg m2/s", .true., 2, .true.), &
      ledger_entry_t("removed_angular_momentum_z", "kg m2/s", .true., 3, .true.), &
      ledger_entry_t("removed_particles", "1", .true.), &
      ledger_entry_t("retired_mass", "kg", .true.), &
      ledger_entry_t("damped", "J", .true.), &
      ledger_entry_t("rigid_momentum_x", "kg m/s", .false., 1, .false.), &
      ledger_entry_t("rigid_momentum_y", "kg m/s", .false., 2, .false.), &
      ledger_entry_t("rigid_momentum_z", "kg m/s", .false., 3, .false.), &
      ledger_entry_t("rigid_angular_momentum_x", "kg m2/s", .false., 1, .true.), &
      ledger_entry_t("rigid_angular_momentum_y", "kg m2/s", .false., 2, .true.), &
      ledger_entry_t("rigid_angular_momentum_z", "kg m2/s", .false., 3, .true.), &
      ledger_entry_t("rigid_kinetic", "J", .false.)]

   !> Turning motion relative to that about the origin below which its error is rounding [1]
   real(wp), parameter :: least_turn = 1.0e-6_wp
   !> Further sums over particles: m |v|, m |x||v|, m x, m |x|**2.
   integer, parameter, public :: scale_count = 6
   !> Number of entries that accumulate.
   integer, parameter :: running = count(ledger_entries%accumulates)

   !> The entries at one time and the errors of the balance.
   type :: balance_t
      real(wp) :: entry(size(ledger_entries)) = 0.0_wp      !! Values in SI
      real(wp) :: total = 0.0_wp !! Kinetic, internal, dissipated, lost, removed energy [J]
      real(wp) :: mass_error = 0.0_wp                !! Relative to the mass at the start
      real(wp) :: momentum_error = 0.0_wp            !! Relative to the greatest sum of m |v| so far
      real(wp) :: angular_error = 0.0_wp !! Relative to the greatest sum of m |x||v| so far
      real(wp) :: turn_error = 0.0_wp    !! The same error, relative to the greatest turning motion
      real(wp) :: energy_error = 0.0_wp              !! Relative to the energy at the start
      real(wp) :: damped_share = 0.0_wp              !! Damped energy, relative to the same
   end type balance_t

   !> Running sums since the start of the run.
   type :: ledger_t
      !> Only entries that accumulate are used
      type(exact_sum_t) :: sums(size(ledger_entries))
      type(balance_t) :: start                       !! At the start of the run
      type(wall_sums_t) :: walls                     !! Action of each wall, if an output shows it
      real(wp) :: momentum_scale = 0.0_wp            !! Greatest sum of mass times speed [kg m/s]
      real(wp) :: angular_scale = 0.0_wp !! Greatest sum of mass, arm and speed [kg m2/s]
      real(wp) :: turn_scale = 0.0_wp    !! Greatest turning motion [kg m2/s], equation (L.14)
      logical :: has_bodies = .false.                !! Are there rigid bodies with a mass?
      real(wp) :: bodies(7) = 0.0_wp !! Their momentum, angular momentum and kinetic energy
      real(wp) :: body_scales(2) = 0.0_wp            !! Their parts of the scales
   contains
      procedure :: record_lost => ledger_record_lost     !! Record the particles that left the box
      procedure :: record_particle => ledger_record_particle     !! Record a particle that leaves
      procedure :: record_impulse => ledger_record_impulse !! Record the action of an external force
      procedure :: merge => ledger_merge             !! Add the sums of another ledger
      procedure :: clear => ledger_clear             !! Set the sums to zero
      procedure :: balance => ledger_balance         !! Present entries and errors
      procedure :: save => ledger_save               !! Into a checkpoint
      procedure :: load => ledger_load               !! From a checkpoint
   end type ledger_t

contains

   !> Record the particles that left the box, before they are deleted.
   subroutine ledger_record_lost(self, stores, materials)
      class(ledger_t), intent(inout) :: self
      type(store_t), intent(in) :: stores(:)
      type(material_t), intent(in) :: materials(:)   !! Their materials
      integer :: index, tile, p

      do index = 1, size(stores)
         associate (store => stores(index))
            do tile = 1, size(store%count)
               if (store%leaving(tile) == 0) cycle
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (store%home(p) /= moved_out) cycle
                  call self%record_particle(store, materials(index), p, [lost_mass, lost_momentum, &
                     lost_energy, lost_angular])
               end do
            end do
         end associate
      end do
   end subroutine ledger_record_lost

   !> Record a particle that leaves or is removed, or one that enters as a negative loss.
   subroutine ledger_record_particle(self, store, material, p, rows, enters)
      class(ledger_t), intent(inout) :: self
      type(store_t), intent(in) :: store
      type(material_t), intent(in) :: material       !! Their material
      integer, intent(in) :: p                       !! Index
      integer, intent(in) :: rows(4) !! Entries for mass, momentum, energy, angular momentum
      logical, intent(in), optional :: enters        !! Does it enter?
      real(wp) :: energy(1), turn(3), mass_of_it
      integer :: k

      call material%stored_energy(store%state, p, p, energy)
      mass_of_it = store%state%mass(p)
      if (present(enters)) then
         if (enters) then
            mass_of_it = -mass_of_it
            energy = -energy
         end if
      end if
      call self%sums(rows(1))%add(mass_of_it)
      do k = 1, 3
         call self%sums(rows(2) + k - 1)%add(mass_of_it*store%velocity(p, k))
         energy = energy + 0.5_wp*mass_of_it*store%velocity(p, k)**2
      end do
      call self%sums(rows(3))%add(energy(1))
      turn = mass_of_it*cross([store%position(p, 1), store%position(p, 2), &
         store%position(p, 3)], [store%velocity(p, 1), store%velocity(p, 2), store%velocity(p, 3)])
      do k = 1, 3
         call self%sums(rows(4) + k - 1)%add(turn(k))
      end do
   end subroutine ledger_record_particle

   !> Record the impulse of an external force, its moment and its work.
   subroutine ledger_record_impulse(self, push, moment, work)
      class(ledger_t), intent(inout) :: self
      real(wp), intent(in) :: push(3)                !! Impulse [N s]
      real(wp), intent(in) :: moment(3)              !! Its moment about the origin [N m s]
      real(wp), intent(in) :: work                   !! [J]
      integer :: k

      do k = 1, 3
         call self%sums(impulse + k - 1)%add(push(k))
         call self%sums(torque + k - 1)%add(moment(k))
      end do
      call self%sums(external_work)%add(work)
   end subroutine ledger_record_impulse

   !> Add the sums of another ledger, such as that of a thread.
   subroutine ledger_merge(self, other)
      class(ledger_t), intent(inout) :: self
      class(ledger_t), intent(in) :: other           !! Ledger to add
      integer :: n

      do n = 1, size(ledger_entries)
         if (ledger_entries(n)%accumulates) call self%sums(n)%merge(other%sums(n))
      end do
      call self%walls%merge(other%walls)
   end subroutine ledger_merge

   !> Set the sums to zero.
   pure subroutine ledger_clear(self)
      class(ledger_t), intent(inout) :: self
      integer :: n

      do n = 1, size(self%sums)
         call self%sums(n)%clear()
      end do
      call self%walls%clear()
   end subroutine ledger_clear

   !> Present entries, summed over all particles and ranks, and the errors against the start.
   !!
   !! In axisymmetric scenes particles are rings, so only the axial momentum has a meaning.
   !! Equations (L.5)
   !! and (L.6).
   subroutine ledger_balance(self, communicator, grid, stores, materials, now)
      class(ledger_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: stores(:)
      type(material_t), intent(in) :: materials(:)   !! Their materials
      type(balance_t), intent(out) :: now            !! Entries and errors
      type(exact_sum_t) :: sums(size(ledger_entries)), scales(scale_count), total
      real(wp) :: drift(3)
      integer :: index, n

      do index = 1, size(stores)
         call sum_store(stores(index), materials(index), sums, scales)
      end do
      do n = 1, size(ledger_entries)
         if (ledger_entries(n)%accumulates) call sums(n)%merge(self%sums(n))
         call sums(n)%over_ranks(communicator)
         now%entry(n) = sums(n)%value()
      end do
      now%entry(rigid_momentum:) = self%bodies
      call clear_meaningless(grid, now%entry)
      do n = 1, scale_count
         call scales(n)%over_ranks(communicator)
      end do
      call total%merge(sums(kinetic))
      call total%merge(sums(internal))
      call total%merge(sums(lost_energy))
      call total%merge(sums(removed_energy))
      call total%merge(sums(dissipated))
      call total%add(now%entry(rigid_kinetic))
      now%total = total%value()
      self%momentum_scale = max(self%momentum_scale, scales(1)%value() &
         + self%body_scales(1))
      self%angular_scale = max(self%angular_scale, scales(2)%value() &
         + self%body_scales(2))
      now%mass_error = quotient_of(now%entry(mass) + now%entry(lost_mass) &
         + now%entry(removed_mass) - self%start%entry(mass), self%start%entry(mass))
      drift = now%entry(momentum:momentum + 2) + now%entry(lost_momentum:lost_momentum + 2) &
         + now%entry(removed_momentum:removed_momentum + 2) - now%entry(impulse:impulse + 2) &
         - self%start%entry(momentum:momentum + 2) + now%entry(rigid_momentum:rigid_momentum + 2) &
         - self%start%entry(rigid_momentum:rigid_momentum + 2)
      now%momentum_error = quotient_of(norm2(drift), self%momentum_scale)
      drift = now%entry(angular:angular + 2) + now%entry(lost_angular:lost_angular + 2) &
         + now%entry(removed_angular:removed_angular + 2) &
         - now%entry(torque:torque + 2) - self%start%entry(angular:angular + 2) &
         + now%entry(rigid_angular:rigid_angular + 2) &
         - self%start%entry(rigid_angular:rigid_angular + 2)
      ! in a periodic box angular momentum has no meaning
      if (any(grid%periodic)) drift = 0.0_wp
      now%angular_error = quotient_of(norm2(drift), self%angular_scale)
      self%turn_scale = max(self%turn_scale, turning_motion(scales, now%entry), &
         least_turn*self%angular_scale)
      now%turn_error = quotient_of(norm2(drift), self%turn_scale)
      now%energy_error = quotient_of(now%total - self%start%total - now%entry(external_work), &
         max(abs(self%start%total), abs(now%entry(external_work))))
      now%damped_share = quotient_of(now%entry(damped), max(abs(self%start%total), &
         abs(now%entry(external_work))))
   end subroutine ledger_balance

   !> Turning motion about the centre of mass [kg m2/s]: the angular momentum, or a tenth of its
   !! upper bound, which a body that turns in a plane attains. Equation (L.14).
   real(wp) function turning_motion(scales, entry) result(motion)
      type(exact_sum_t), intent(in) :: scales(scale_count) !! As `sum_tile` adds them
      real(wp), intent(in) :: entry(:)               !! Entries at this time
      real(wp), parameter :: part = 0.1_wp !! Motion with less angular momentum does not turn [1]
      real(wp) :: centre(3), turn(3), distance, speed
      integer :: k

      motion = 0.0_wp
      if (.not. entry(mass) > 0.0_wp) return
      do k = 1, 3
         centre(k) = scales(2 + k)%value()/entry(mass)
      end do
      ! squares of the distance from the centre of mass and of the speed relative to it
      distance = max(0.0_wp, scales(6)%value()/entry(mass) - sum(centre**2))
      associate (p => entry(momentum:momentum + 2), total => entry(angular:angular + 2))
         speed = max(0.0_wp, 2.0_wp*entry(kinetic)/entry(mass) - sum((p/entry(mass))**2))
         turn = total - merge(cross(centre, p), 0.0_wp, abs(total) > 0.0_wp)
      end associate
      motion = max(norm2(turn), part*entry(mass)*sqrt(distance*speed))
   end function turning_motion

   !> Clear components that the scene does not have. In axisymmetric scenes particles are rings:
   !! only the axial
   !! momentum has a meaning, and none of the angular momentum.
   pure subroutine clear_meaningless(grid, entry)
      type(grid_t), intent(in) :: grid
      real(wp), intent(inout) :: entry(:)            !! Entries
      logical :: keep(3), turns(3)
      integer :: axis, n

      keep = grid%active
      if (grid%axisymmetric) keep(1) = .false.
      turns = .true.
      if (grid%dimensions == 2) turns = [.false., .true., .false.]
      if (grid%axisymmetric .or. grid%dimensions == 1) turns = .false.
      do n = 1, size(ledger_entries)
         axis = ledger_entries(n)%axis
         if (axis == 0) cycle
         if (.not. merge(turns(axis), keep(axis), ledger_entries(n)%is_moment)) entry(n) = 0.0_wp
      end do
   end subroutine clear_meaningless

   !> Add the sums over the particles of a store, or over those that a rule selects, tiles in
   !! threads.
   subroutine sum_store(store, material, sums, scales, rule)
      type(store_t), intent(in) :: store
      type(material_t), intent(in) :: material       !! Their material
      type(exact_sum_t), intent(inout) :: sums(:)    !! (entry) Of the state only
      type(exact_sum_t), intent(inout) :: scales(scale_count) !! As `sum_tile`
      type(pick_rule_t), intent(in), optional :: rule !! Selects particles; default: all
      type(exact_sum_t), allocatable :: part(:)
      real(wp) :: tile_sum(size(ledger_entries)), tile_scale(scale_count)
      integer :: n, tile

      !$omp parallel default(none) shared(store, material, sums, scales, rule) &
      !$omp private(part, tile_sum, tile_scale, n, tile)
      allocate (part(size(sums) + scale_count))
      !$omp do schedule(dynamic, 16)
      do tile = 1, size(store%count)
         if (store%count(tile) == 0) cycle
         call sum_tile(store, material, tile, tile_sum, tile_scale, rule)
         do n = 1, size(sums)
            if (.not. ledger_entries(n)%accumulates) call part(n)%add(tile_sum(n))
         end do
         do n = 1, scale_count
            call part(size(sums) + n)%add(tile_scale(n))
         end do
      end do
      !$omp end do nowait
      !$omp critical (ledger_sums)
      do n = 1, size(sums)
         call sums(n)%merge(part(n))
      end do
      do n = 1, scale_count
         call scales(n)%merge(part(size(sums) + n))
      end do
      !$omp end critical (ledger_sums)
      !$omp end parallel
   end subroutine sum_store

   !> Sums over the particles of one tile in their order. Equation (L.1).
   subroutine sum_tile(store, material, tile, sums, scales, rule)
      type(store_t), intent(in) :: store
      type(material_t), intent(in) :: material       !! Their material
      integer, intent(in) :: tile                    !! Index
      real(wp), intent(out) :: sums(:)               !! Entries of the state
      real(wp), intent(out) :: scales(scale_count)   !! Sums of m |v|, m |x||v|, m x, m |x|**2
      type(pick_rule_t), intent(in), optional :: rule !! Selects particles; default: all
      real(wp) :: energy(store%count(tile)), m, x(3), v(3), speed
      integer :: p, first, last

      first = store%first(tile)
      last = first + store%count(tile) - 1
      sums = 0.0_wp
      scales = 0.0_wp
      call material%stored_energy(store%state, first, last, energy)
      do p = first, last
         if (present(rule)) then
            if (.not. rule%takes(store, p)) cycle
         end if
         m = store%state%mass(p)
         x = [store%position(p, 1), store%position(p, 2), store%position(p, 3)]
         v = [store%velocity(p, 1), store%velocity(p, 2), store%velocity(p, 3)]
         speed = norm2(v)
         sums(mass) = sums(mass) + m
         sums(momentum:momentum + 2) = sums(momentum:momentum + 2) + m*v
         sums(angular:angular + 2) = sums(angular:angular + 2) + m*cross(x, v)
         sums(kinetic) = sums(kinetic) + 0.5_wp*m*speed**2
         sums(internal) = sums(internal) + energy(p - first + 1)
         scales = scales + m*[speed, speed*norm2(x), x, sum(x**2)]
         if (.not. allocated(store%state%failed)) cycle
         if (store%state%failed(p) /= 0) sums(failed_mass) = sums(failed_mass) + m
      end do
   end subroutine sum_tile

   !> Quotient, 0 if the scale is 0.
   pure real(wp) function quotient_of(part, whole) result(quotient)
      real(wp), intent(in) :: part                   !! Difference
      real(wp), intent(in) :: whole                  !! Scale

      quotient = 0.0_wp
      if (abs(whole) > 0.0_wp) quotient = part/whole
   end function quotient_of

   !> Write the running sums of all ranks to the state of a checkpoint.
   subroutine ledger_save(self, communicator, state)
      class(ledger_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      type(state_t), intent(inout) :: state          !! Of the checkpoint
      type(exact_sum_t) :: sum
      integer(int64) :: limbs(exact_sum_words, running)
      integer(int64), allocatable :: words(:)
      integer :: filled, n

      filled = 0
      do n = 1, size(ledger_entries)
         if (.not. ledger_entries(n)%accumulates) cycle
         filled = filled + 1
         sum = self%sums(n)
         call sum%over_ranks(communicator)
         call sum%save(limbs(:, filled))
      end do
      call state%set("ledger_sums", reshape(limbs, [size(limbs)]))
      if (allocated(self%walls%total)) then
         words = self%walls%words()
         call total_words(communicator, words)
         call state%set("ledger_walls", words)
      end if
      call state%set("ledger_start", [self%start%entry, self%start%total])
      call state%set("ledger_scales", [self%momentum_scale, self%angular_scale, self%turn_scale])
   end subroutine ledger_save

   !> Read the running sums from a checkpoint; rank 0 holds them all.
   subroutine ledger_load(self, communicator, state, error)
      class(ledger_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      type(state_t), intent(in) :: state             !! Of the checkpoint
      type(error_t), allocatable, intent(out) :: error !! If something is missing
      type(error_t), allocatable :: missing
      integer(int64), allocatable :: limbs(:)
      real(wp), allocatable :: start(:), scales(:)
      integer :: first, n

      call state%get("ledger_sums", limbs, error)
      if (allocated(error)) return
      call state%get("ledger_start", start, error)
      if (allocated(error)) return
      call state%get("ledger_scales", scales, error)
      if (allocated(error)) return
      if (size(start) /= size(ledger_entries) + 1 .or. size(scales) /= 3) then
         call fail(error, exit_file, "the checkpoint has the ledger of another version of "// &
            "scree [F109]")
         return
      end if
      self%start%entry = start(:size(ledger_entries))
      self%start%total = start(size(ledger_entries) + 1)
      self%momentum_scale = scales(1)
      self%angular_scale = scales(2)
      self%turn_scale = scales(3)
      first = 1
      do n = 1, size(ledger_entries)
         if (.not. ledger_entries(n)%accumulates) cycle
         call self%sums(n)%clear()
         if (communicator%rank == 0) &
            call self%sums(n)%load(limbs(first:first + exact_sum_words - 1))
         first = first + exact_sum_words
      end do
      if (.not. allocated(self%walls%total)) return
      ! an output that was added since begins with 0
      call self%walls%clear()
      call state%get("ledger_walls", limbs, missing)
      if (.not. allocated(missing) .and. communicator%rank == 0) call self%walls%set_words(limbs)
   end subroutine ledger_load
end module step_ledger
