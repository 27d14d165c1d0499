! SPDX-License-Identifier: BSD-3-Clause
!> Removes particles that are out of bounds or have failed, and records their mass, momentum and
!! energy. Their memory is released when their tile is sorted.
module step_remove_particles
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_physics, fail
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: wp
   use material_type, only: material_t
   use particle_store, only: moved_away, moved_off, moved_out, store_t
   use step_bounds, only: bounds_t, count_bad, fault_inverted, fault_none, find_fault, guard_t
   use step_ledger, only: ledger_t, mass, removed_angular, removed_energy, removed_mass, &
      removed_momentum, removed_particles, retired_mass
   use step_offending_particle, only: step_text, tile_bounds
   use step_simulation, only: clock_t, scheme_t, scratch_t
   implicit none
   private

   public :: check_retired, erode_tile, fastest_left, judge_particles, retire_tile

contains

   !> Find particles that are out of bounds or have failed, and remove them if the deck says so. The
   !! remaining particles limit the next step.
   subroutine judge_particles(material, store, scheme, guard, scratch, tile, fastest, steepest)
      type(material_t), intent(in) :: material
      type(store_t), intent(inout) :: store
      type(scheme_t), intent(in) :: scheme
      type(guard_t), intent(in) :: guard
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(inout) :: fastest             !! Fastest signal and motion of tile [m/s]
      real(wp), intent(in) :: steepest               !! Square of |grad v|, tile excluded [1/s2]
      logical :: sound

      sound = count_bad(store, tile, material%density, tile_bounds(material, guard)) < 0.5_wp
      if (.not. sound .and. guard%bounds%retire) then
         call retire_tile(material, store, guard, scratch, tile, sound)
         scratch%retired = .true.
      end if
      scratch%sound = scratch%sound .and. sound
      if (scheme%erosion .and. allocated(store%state%failed)) call erode_tile(material, store, &
         scratch, tile)
      if (.not. (scheme%erosion .or. guard%bounds%retire)) return
      if (.not. any(store%home(store%first(tile):store%first(tile) + store%count(tile) - 1) == &
         moved_off)) return
      if (fastest > 0.0_wp) fastest = fastest_left(store, tile, scratch%deformation%wave_speed)
      scratch%steepest = steepest
   end subroutine judge_particles

   !> Remove the particles of a tile that have left their bounds. Particles with NaN are not removed
   !! and end the run, because the NaN has already reached their neighbours.
   subroutine retire_tile(material, store, guard, scratch, tile, sound)
      type(material_t), intent(in) :: material
      type(store_t), intent(inout) :: store
      type(guard_t), intent(in) :: guard
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile                    !! Tile after its particles moved
      logical, intent(out) :: sound                  !! Are all other particles in their bounds?
      type(bounds_t) :: bounds
      integer :: p, fault
      real(wp) :: value

      sound = .true.
      bounds = tile_bounds(material, guard)
      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         call find_fault(store, p, material%density, bounds, fault, value)
         if (fault == fault_none) cycle
         if (fault < fault_inverted) then
            sound = .false.
         else if (store%home(p) /= moved_out) then
            call scratch%ledger%sums(retired_mass)%add(store%state%mass(p))
            call take_out(scratch%ledger, material, store, tile, p)
         end if
      end do
   end subroutine retire_tile

   !> Remove the failed particles of a tile.
   subroutine erode_tile(material, store, scratch, tile)
      type(material_t), intent(in) :: material
      type(store_t), intent(inout) :: store
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile                    !! Tile after its particles moved
      integer :: p

      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         if (store%state%failed(p) == 0) cycle
         if (store%home(p) == moved_out .or. store%home(p) == moved_off) cycle
         call take_out(scratch%ledger, material, store, tile, p)
      end do
   end subroutine erode_tile

   !> Record a particle and mark it for removal.
   subroutine take_out(ledger, material, store, tile, p)
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      type(material_t), intent(in) :: material       !! Material of the particle
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile                    !! Tile of the particle
      integer, intent(in) :: p

      call ledger%record_particle(store, material, p, [removed_mass, removed_momentum, &
         removed_energy, removed_angular])
      call ledger%sums(removed_particles)%add(1.0_wp)
      if (store%home(p) /= moved_away) store%leaving(tile) = store%leaving(tile) + 1
      store%home(p) = moved_off
      store%unsorted(tile) = .true.
   end subroutine take_out

   !> Fastest signal and motion of the remaining particles of a tile [m/s].
   pure real(wp) function fastest_left(store, tile, wave_speed) result(fastest)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: wave_speed(:) !! (particle of the tile) [m/s]
      integer :: p, q

      fastest = 0.0_wp
      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         if (store%home(q) == moved_off) cycle
         fastest = max(fastest, wave_speed(p) + sqrt(store%velocity(q, 1)**2 &
            + store%velocity(q, 2)**2 + store%velocity(q, 3)**2))
      end do
   end function fastest_left

   !> Has more mass been removed than the deck allows? Collective.
   subroutine check_retired(clock, ledger, communicator, error)
      type(clock_t), intent(in) :: clock
      type(ledger_t), intent(in) :: ledger
      type(communicator_t), intent(in) :: communicator
      type(error_t), allocatable, intent(out) :: error !! If so
      type(exact_sum_t) :: sum
      real(wp) :: share
      character(len=160) :: text

      associate (bounds => clock%guard%bounds)
         call sum%merge(ledger%sums(retired_mass))
         call sum%over_ranks(communicator)
         share = sum%value()/ledger%start%entry(mass)
         if (share <= bounds%retire_max) return
         write (text, "(a,es10.3,a,es10.3)") "particles that exceeded their bounds had", share, &
            " of the mass, more than retire_max =", bounds%retire_max
         call fail(error, exit_physics, step_text(clock)//": "//trim(text)//" [R109]")
      end associate
   end subroutine check_retired
end module step_remove_particles
