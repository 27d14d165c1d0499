! SPDX-License-Identifier: BSD-3-Clause
!> The books of a run: mass, momentum and energy in the box, lost through its faces, and brought in
!! from outside. All sums are exact, so they are the same for any ranks and threads. Equations (L.5)
!! and (L.6) of doc/theory/ledger.md.
module step_ledger
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_exact_sum, only: exact_sum_t, exact_sum_words
   use base_kinds, only: int64, wp
   use io_state, only: state_t
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use particle_store, only: moved_out, store_t
   implicit none
   private

   public :: balance_t, cross, entry_names, entry_units, ledger_t

   integer, parameter, public :: mass = 1            !! Mass in the box
   integer, parameter, public :: momentum = 2        !! First of three components of momentum
   integer, parameter, public :: angular = 5 !! First of three components of angular momentum
   integer, parameter, public :: kinetic = 8         !! Kinetic energy
   integer, parameter, public :: internal = 9        !! Internal energy
   integer, parameter, public :: viscous = 10 !! Work into artificial viscosity since the start
   integer, parameter, public :: plastic = 11        !! Work into plastic flow since the start
   integer, parameter, public :: lost_mass = 12      !! Mass that left the box
   integer, parameter, public :: lost_momentum = 13  !! First of three components of its momentum
   integer, parameter, public :: lost_energy = 16    !! Its energy
   integer, parameter, public :: impulse = 17 !! First of three components from walls and gravity
   integer, parameter, public :: external_work = 20  !! Work of walls and gravity
   integer, parameter, public :: failed_mass = 21    !! Mass of failed particles
   integer, parameter, public :: lost_angular = 22   !! First of three components of what left
   integer, parameter, public :: torque = 25 !! First of three components from walls and gravity
   !> Viscous and plastic work and what is damped in materials that carry no internal energy, since
   !! the start
   integer, parameter, public :: dissipated = 28
   integer, parameter, public :: removed_mass = 29   !! Mass of particles that were taken out
   integer, parameter, public :: removed_momentum = 30 !! First of three components of its momentum
   integer, parameter, public :: removed_energy = 33 !! Its energy
   integer, parameter, public :: removed_angular = 34 !! First of three components of the same
   integer, parameter, public :: removed_particles = 37 !! Number of these particles
   integer, parameter, public :: retired_mass = 38   !! Mass of those that had left their bounds
   !> Kinetic energy that the share of PIC took, where no internal energy takes it, since the start
   integer, parameter, public :: damped = 39
   integer, parameter, public :: entries = 39        !! Number of entries

   character(len=26), parameter :: entry_names(entries) = [character(len=26) :: "mass", &
      "momentum_x", "momentum_y", "momentum_z", "angular_momentum_x", "angular_momentum_y", &
      "angular_momentum_z", "kinetic", "internal", "viscous", "plastic", "lost_mass", &
      "lost_momentum_x", "lost_momentum_y", "lost_momentum_z", "lost_energy", "impulse_x", &
      "impulse_y", "impulse_z", "external_work", "failed_mass", "lost_angular_momentum_x", &
      "lost_angular_momentum_y", "lost_angular_momentum_z", "torque_impulse_x", &
      "torque_impulse_y", "torque_impulse_z", "dissipated", "removed_mass", "removed_momentum_x", &
      "removed_momentum_y", "removed_momentum_z", "removed_energy", "removed_angular_momentum_x", &
      "removed_angular_momentum_y", "removed_angular_momentum_z", "removed_particles", &
      "retired_mass", "damped"]
   character(len=7), parameter :: entry_units(entries) = [character(len=7) :: "kg", &
      "kg m/s", "kg m/s", "kg m/s", "kg m2/s", "kg m2/s", "kg m2/s", "J", "J", "J", "J", "kg", &
      "kg m/s", "kg m/s", "kg m/s", "J", "N s", "N s", "N s", "J", "kg", "kg m2/s", "kg m2/s", &
      "kg m2/s", "N m s", "N m s", "N m s", "J", "kg", "kg m/s", "kg m/s", "kg m/s", "J", &
      "kg m2/s", "kg m2/s", "kg m2/s", "1", "kg", "J"]

   !> The entries at one time and the errors of the books.
   type :: balance_t
      real(wp) :: entry(entries) = 0.0_wp            !! Values in SI
      real(wp) :: speed_scale = 0.0_wp               !! Sum of mass times speed, for errors [kg m/s]
      real(wp) :: total = 0.0_wp !! Kinetic, internal, dissipated, lost, removed energy [J]
      real(wp) :: mass_error = 0.0_wp                !! Relative to the mass at the start
      real(wp) :: momentum_error = 0.0_wp            !! Relative to the greatest sum of m |v| so far
      real(wp) :: angular_error = 0.0_wp !! Relative to the greatest sum of m |x||v| so far
      real(wp) :: energy_error = 0.0_wp              !! Relative to the energy at the start
      real(wp) :: damped_share = 0.0_wp              !! Of what the share of PIC took, the same
   end type balance_t

   !> Running sums since the start of the run.
   type :: ledger_t
      type(exact_sum_t) :: sums(entries)             !! Only entries that accumulate are used
      type(balance_t) :: start                       !! At the start of the run
      real(wp) :: momentum_scale = 0.0_wp            !! Greatest sum of mass times speed [kg m/s]
      real(wp) :: angular_scale = 0.0_wp !! Greatest sum of mass, arm and speed [kg m2/s]
   contains
      procedure :: record_lost => ledger_book_lost     !! Book the particles that left the box
      procedure :: book_gone => ledger_book_gone     !! Book one particle that goes
      procedure :: merge => ledger_merge             !! Add the sums of another ledger
      procedure :: balance => ledger_balance         !! Entries and errors of now
      procedure :: save => ledger_save               !! Into a checkpoint
      procedure :: load => ledger_load               !! From a checkpoint
   end type ledger_t

   integer, parameter :: accumulated(29) = [viscous, plastic, lost_mass, lost_momentum, &
      lost_momentum + 1, lost_momentum + 2, lost_energy, impulse, impulse + 1, impulse + 2, &
      external_work, lost_angular, lost_angular + 1, lost_angular + 2, torque, torque + 1, &
      torque + 2, dissipated, removed_mass, removed_momentum, removed_momentum + 1, &
      removed_momentum + 2, removed_energy, removed_angular, removed_angular + 1, &
      removed_angular + 2, removed_particles, retired_mass, damped]

contains

   !> Book the particles that left the box, before they are forgotten.
   subroutine ledger_book_lost(self, stores, materials)
      class(ledger_t), intent(inout) :: self         !! The books
      type(store_t), intent(in) :: stores(:)         !! The particles
      type(material_t), intent(in) :: materials(:)   !! Their materials
      integer :: index, tile, p

      do index = 1, size(stores)
         associate (store => stores(index))
            do tile = 1, size(store%count)
               if (store%leaving(tile) == 0) cycle
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (store%home(p) /= moved_out) cycle
                  call self%book_gone(store, materials(index), p, [lost_mass, lost_momentum, &
                     lost_energy, lost_angular])
               end do
            end do
         end associate
      end do
   end subroutine ledger_book_lost

   !> Book a particle that goes.
   subroutine ledger_book_gone(self, store, material, p, rows)
      class(ledger_t), intent(inout) :: self         !! The books
      type(store_t), intent(in) :: store             !! The particles
      type(material_t), intent(in) :: material       !! Their material
      integer, intent(in) :: p                       !! Which one
      integer, intent(in) :: rows(4) !! Entries for mass, momentum, energy, angular momentum
      real(wp) :: energy(1), turn(3)
      integer :: k

      call material%stored_energy(store%state, p, p, energy)
      call self%sums(rows(1))%add(store%state%mass(p))
      do k = 1, 3
         call self%sums(rows(2) + k - 1)%add(store%state%mass(p)*store%velocity(p, k))
         energy = energy + 0.5_wp*store%state%mass(p)*store%velocity(p, k)**2
      end do
      call self%sums(rows(3))%add(energy(1))
      turn = store%state%mass(p)*cross([store%position(p, 1), store%position(p, 2), &
         store%position(p, 3)], [store%velocity(p, 1), store%velocity(p, 2), store%velocity(p, 3)])
      do k = 1, 3
         call self%sums(rows(4) + k - 1)%add(turn(k))
      end do
   end subroutine ledger_book_gone

   !> Add the sums of another ledger, such as that of a thread.
   subroutine ledger_merge(self, other)
      class(ledger_t), intent(inout) :: self         !! The books
      class(ledger_t), intent(in) :: other           !! What is added
      integer :: n

      do n = 1, size(accumulated)
         call self%sums(accumulated(n))%merge(other%sums(accumulated(n)))
      end do
   end subroutine ledger_merge

   !> Entries of now, summed over all particles and ranks, and the errors against the start.
   !!
   !! In axisymmetry particles are rings, so only the axial momentum has a meaning. Equations (L.5)
   !! and (L.6).
   subroutine ledger_balance(self, communicator, grid, stores, materials, now)
      class(ledger_t), intent(inout) :: self         !! The books
      type(communicator_t), intent(in) :: communicator !! The ranks
      type(grid_t), intent(in) :: grid               !! The grid
      type(store_t), intent(in) :: stores(:)         !! The particles
      type(material_t), intent(in) :: materials(:)   !! Their materials
      type(balance_t), intent(out) :: now            !! Entries and errors
      type(exact_sum_t) :: sums(entries), scales(2), total
      real(wp) :: tile_sum(entries), tile_scale(2), drift(3)
      integer :: index, tile, n

      do index = 1, size(stores)
         do tile = 1, size(stores(index)%count)
            if (stores(index)%count(tile) == 0) cycle
            call sum_tile(stores(index), materials(index), tile, tile_sum, tile_scale)
            do n = 1, internal
               call sums(n)%add(tile_sum(n))
            end do
            call sums(failed_mass)%add(tile_sum(failed_mass))
            call scales(1)%add(tile_scale(1))
            call scales(2)%add(tile_scale(2))
         end do
      end do
      do n = 1, size(accumulated)
         call sums(accumulated(n))%merge(self%sums(accumulated(n)))
      end do
      do n = 1, entries
         call sums(n)%over_ranks(communicator)
         now%entry(n) = sums(n)%value()
      end do
      call clear_meaningless(grid, now%entry)
      call scales(1)%over_ranks(communicator)
      call scales(2)%over_ranks(communicator)
      call total%merge(sums(kinetic))
      call total%merge(sums(internal))
      call total%merge(sums(lost_energy))
      call total%merge(sums(removed_energy))
      call total%merge(sums(dissipated))
      now%total = total%value()
      self%momentum_scale = max(self%momentum_scale, scales(1)%value())
      self%angular_scale = max(self%angular_scale, scales(2)%value())
      now%mass_error = ratio(now%entry(mass) + now%entry(lost_mass) + now%entry(removed_mass) &
         - self%start%entry(mass), self%start%entry(mass))
      drift = now%entry(momentum:momentum + 2) + now%entry(lost_momentum:lost_momentum + 2) &
         + now%entry(removed_momentum:removed_momentum + 2) - now%entry(impulse:impulse + 2) &
         - self%start%entry(momentum:momentum + 2)
      now%momentum_error = ratio(norm2(drift), self%momentum_scale)
      drift = now%entry(angular:angular + 2) + now%entry(lost_angular:lost_angular + 2) &
         + now%entry(removed_angular:removed_angular + 2) &
         - now%entry(torque:torque + 2) - self%start%entry(angular:angular + 2)
      ! in a periodic box angular momentum has no meaning
      if (any(grid%periodic)) drift = 0.0_wp
      now%angular_error = ratio(norm2(drift), self%angular_scale)
      now%energy_error = ratio(now%total - self%start%total - now%entry(external_work), &
         max(abs(self%start%total), abs(now%entry(external_work))))
      now%damped_share = ratio(now%entry(damped), max(abs(self%start%total), &
         abs(now%entry(external_work))))
   end subroutine ledger_balance

   !> Components that the scene does not have. In axisymmetry particles are rings: only the axial
   !! momentum has a meaning, and none of the angular momentum.
   pure subroutine clear_meaningless(grid, entry)
      type(grid_t), intent(in) :: grid               !! The grid
      real(wp), intent(inout) :: entry(:)            !! Entries of the books
      logical :: keep(3), turns(3)
      integer, parameter :: vectors(4) = [momentum, lost_momentum, impulse, removed_momentum]
      integer, parameter :: moments(4) = [angular, lost_angular, torque, removed_angular]
      integer :: n

      keep = grid%active
      if (grid%axisymmetric) keep(1) = .false.
      turns = .true.
      if (grid%dimensions == 2) turns = [.false., .true., .false.]
      if (grid%axisymmetric .or. grid%dimensions == 1) turns = .false.
      do n = 1, 4
         where (.not. keep) entry(vectors(n):vectors(n) + 2) = 0.0_wp
         where (.not. turns) entry(moments(n):moments(n) + 2) = 0.0_wp
      end do
   end subroutine clear_meaningless

   !> Sums over the particles of one tile in their order. Equation (L.1).
   subroutine sum_tile(store, material, tile, sums, scales)
      type(store_t), intent(in) :: store             !! The particles
      type(material_t), intent(in) :: material       !! Their material
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(out) :: sums(:)               !! Entries of the state
      real(wp), intent(out) :: scales(2)             !! Sums of m |v| and m |x||v|
      real(wp) :: energy(store%count(tile)), m, x(3), v(3), speed
      integer :: p, first, last

      first = store%first(tile)
      last = first + store%count(tile) - 1
      sums = 0.0_wp
      scales = 0.0_wp
      call material%stored_energy(store%state, first, last, energy)
      do p = first, last
         m = store%state%mass(p)
         x = [store%position(p, 1), store%position(p, 2), store%position(p, 3)]
         v = [store%velocity(p, 1), store%velocity(p, 2), store%velocity(p, 3)]
         speed = norm2(v)
         sums(mass) = sums(mass) + m
         sums(momentum:momentum + 2) = sums(momentum:momentum + 2) + m*v
         sums(angular:angular + 2) = sums(angular:angular + 2) + m*cross(x, v)
         sums(kinetic) = sums(kinetic) + 0.5_wp*m*speed**2
         sums(internal) = sums(internal) + energy(p - first + 1)
         scales = scales + m*speed*[1.0_wp, norm2(x)]
      end do
      if (.not. allocated(store%state%failed)) return
      do p = first, last
         if (store%state%failed(p) == 0) cycle
         sums(failed_mass) = sums(failed_mass) + store%state%mass(p)
      end do
   end subroutine sum_tile

   !> Vector product.
   pure function cross(a, b) result(product)
      real(wp), intent(in) :: a(3)                   !! Left factor
      real(wp), intent(in) :: b(3)                   !! Right factor
      real(wp) :: product(3)

      product = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross

   !> Quotient, 0 where there is nothing to compare with.
   pure real(wp) function ratio(part, whole) result(quotient)
      real(wp), intent(in) :: part                   !! Difference
      real(wp), intent(in) :: whole                  !! Scale

      quotient = 0.0_wp
      if (abs(whole) > 0.0_wp) quotient = part/whole
   end function ratio

   !> Put the running sums of all ranks into the state of a checkpoint.
   subroutine ledger_save(self, communicator, state)
      class(ledger_t), intent(in) :: self            !! The books
      type(communicator_t), intent(in) :: communicator !! The ranks
      type(state_t), intent(inout) :: state          !! Of the checkpoint
      type(exact_sum_t) :: sum
      integer(int64) :: limbs(exact_sum_words, size(accumulated))
      integer :: n

      do n = 1, size(accumulated)
         sum = self%sums(accumulated(n))
         call sum%over_ranks(communicator)
         call sum%save(limbs(:, n))
      end do
      call state%set("ledger_sums", reshape(limbs, [size(limbs)]))
      call state%set("ledger_start", [self%start%entry, self%start%total])
      call state%set("ledger_scales", [self%momentum_scale, self%angular_scale])
   end subroutine ledger_save

   !> Take the running sums from a checkpoint; rank 0 holds them all.
   subroutine ledger_load(self, communicator, state, error)
      class(ledger_t), intent(inout) :: self         !! The books
      type(communicator_t), intent(in) :: communicator !! The ranks
      type(state_t), intent(in) :: state             !! Of the checkpoint
      type(error_t), allocatable, intent(out) :: error !! If something is missing
      integer(int64), allocatable :: limbs(:)
      real(wp), allocatable :: start(:), scales(:)
      integer :: n

      call state%get("ledger_sums", limbs, error)
      if (allocated(error)) return
      call state%get("ledger_start", start, error)
      if (allocated(error)) return
      call state%get("ledger_scales", scales, error)
      if (allocated(error)) return
      if (size(start) /= entries + 1) then
         call fail(error, exit_file, "the checkpoint has the books of another version of scree")
         return
      end if
      self%start%entry = start(:entries)
      self%start%total = start(entries + 1)
      self%momentum_scale = scales(1)
      self%angular_scale = scales(2)
      do n = 1, size(accumulated)
         call self%sums(accumulated(n))%clear()
         if (communicator%rank == 0) call self%sums(accumulated(n))%load( &
            limbs((n - 1)*exact_sum_words + 1:n*exact_sum_words))
      end do
   end subroutine ledger_load
end module step_ledger
