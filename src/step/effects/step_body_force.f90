! SPDX-License-Identifier: BSD-3-Clause
!> Body forces: gravity, constant or with a table of time (`gravity_table` of &effects), the force
!! that makes a manufactured solution true, and impulse and work of loads on surfaces.
!!
!! In a step gravity is the mean of the table over the time in which the forces of this step act:
!! the integral of its straight lines, equation (R.4) of doc/theory/rigid.md. So the impulse of a
!! run is that of the table for any time steps, and work and impulse are recorded as those of
!! constant gravity. Between steps gravity is that of the present time; nothing is kept for a
!! restart.
module step_body_force
   use base_elementary, only: cross
   use base_kinds, only: wp
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_method, only: method_t
   use step_particles_to_nodes, only: find_loads, locate_particles
   use step_simulation, only: clock_t, machine_t, scheme_t, scratch_t, simulation_effects_t, &
      space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: average_gravity, record_body_force, record_loads, update_gravity

contains

   !> Set gravity to its mean over the time in which the forces of a step act.
   pure subroutine average_gravity(method, effects, clock)
      type(method_t), intent(in) :: method
      type(simulation_effects_t), intent(inout) :: effects
      type(clock_t), intent(in) :: clock
      real(wp) :: from

      if (.not. allocated(effects%shaking)) return
      from = clock%time - method%lag(clock%dt)
      if (clock%kick > 0.0_wp) &
         effects%gravity = effects%shaking%mean(from, clock%kick)
   end subroutine average_gravity

   !> Set gravity to that of the present time.
   pure subroutine update_gravity(effects, clock)
      type(simulation_effects_t), intent(inout) :: effects
      type(clock_t), intent(in) :: clock

      if (allocated(effects%shaking)) effects%gravity = effects%shaking%velocity(clock%time)
   end subroutine update_gravity

   !> Record impulse, its moment and work of the body force, particle by particle. The particles are
   !! at the positions at which they gave the force to the nodes, and the mean velocities are known.
   subroutine record_body_force(space, stores, scheme, effects, machine, scratches, field, dt)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(velocity_field_t), intent(in) :: field
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      integer :: tile

      !$omp parallel do default(none) shared(space, stores, scheme, effects, machine, scratches, &
      !$omp field, dt) private(tile) schedule(dynamic, 1)
      do tile = 1, space%tiles%own
         call start_cost(machine, tile)
         call record_tile(space, stores, scheme, effects, field, scratches(omp_get_thread_num()), &
            tile, dt)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine record_body_force

   !> One tile.
   subroutine record_tile(space, stores, scheme, effects, field, scratch, tile, dt)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: carry(3, space%grid%tile_nodes)
      real(wp) :: total(3), turn(3), work, point(3), force(3), place(3)
      integer :: index, p, q, k

      associate (exact => effects%exact, motion => field%nodes%motion, method => scheme%method)
         total = 0.0_wp
         turn = 0.0_wp
         work = 0.0_wp
         carry = motion%velocity(:, :, tile) + 0.5_wp*dt*motion%acceleration(:, :, tile)
         do index = 1, size(stores)
            if (stores(index)%count(tile) == 0) cycle
            if (.not. allocated(exact%material(index)%solution)) cycle
            associate (store => stores(index), solution => exact%material(index)%solution)
               call locate_particles(space, scheme, field, scratch, store, tile)
               call method%basis%gather_values(space%grid, scratch%shape, carry, &
                  scratch%shape%vector)
               do p = 1, store%count(tile)
                  q = store%first(tile) + p - 1
                  point = [(store%origin%reference(q, k), k=1, 3)]
                  place = [(store%position(q, k), k=1, 3)]
                  call solution%body_force(point, exact%force_time, force)
                  force = store%state%mass(q)*dt*force
                  total = total + force
                  turn = turn + cross(place, force)
                  work = work + force(1)*scratch%shape%vector(p, 1) &
                     + force(2)*scratch%shape%vector(p, 2) + force(3)*scratch%shape%vector(p, 3)
               end do
            end associate
         end do
         call scratch%ledger%record_impulse(total, turn, work)
      end associate
   end subroutine record_tile

   !> Record impulse, its moment and work of the loads on surfaces, particle by particle, with the
   !! gradient that is adjoint to the force. Equation (O.6) of doc/theory/instruments.md.
   subroutine record_loads(space, method, effects, clock, scratch, store, tile, centre)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(simulation_effects_t), intent(in) :: effects
      type(clock_t), intent(in) :: clock
      !> Of this thread: particles located, and the gradient of the velocity times the kick
      type(scratch_t), intent(inout) :: scratch
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: centre(:, :) !! (3, node) Velocity, mid-step [m/s]
      real(wp) :: total(3), turn(3), work, force(3), place(3), given
      integer :: p, q, k

      call find_loads(space, effects, scratch, store, tile)
      call method%basis%gather_values(space%grid, scratch%shape, centre, scratch%shape%vector)
      total = 0.0_wp
      turn = 0.0_wp
      work = 0.0_wp
      associate (load => scratch%pushed%load, gradient => scratch%deformation%gradient)
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            given = store%state%volume(q)*(load(p, 1)*gradient(p, 1) &
               + load(p, 2)*gradient(p, 5) + load(p, 3)*gradient(p, 9) &
               + load(p, 4)*(gradient(p, 2) + gradient(p, 4)) &
               + load(p, 5)*(gradient(p, 6) + gradient(p, 8)) &
               + load(p, 6)*(gradient(p, 3) + gradient(p, 7)))
            do k = 1, 3
               force(k) = clock%kick*store%state%volume(q)*scratch%pushed%density(p, k)
               place(k) = store%position(q, k)
               given = given + force(k)*scratch%shape%vector(p, k)
            end do
            total = total + force
            turn = turn + cross(place, force)
            work = work + given
            scratch%load_work = max(scratch%load_work, given/store%state%mass(q))
         end do
      end associate
      call scratch%ledger%record_impulse(total, turn, work)
   end subroutine record_loads
end module step_body_force
