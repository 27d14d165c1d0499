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
   use exact_solution, only: exact_t
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_ledger, only: external_work, impulse, torque
   use step_particles_to_nodes, only: find_loads, locate_particles
   use step_simulation, only: clock_t, scheme_t, scratch_t, simulation_effects_t, simulation_t, &
      velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   implicit none
   private

   public :: average_gravity, record_body_force, record_loads, update_gravity

contains

   !> Set gravity to its mean over the time in which the forces of a step act.
   pure subroutine average_gravity(scheme, effects, clock)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(inout) :: effects
      type(clock_t), intent(in) :: clock
      real(wp) :: from

      if (.not. allocated(effects%shaking)) return
      from = clock%time - scheme%method%lag(clock%dt)
      if (clock%kick > 0.0_wp) &
         effects%gravity = effects%shaking%mean(from, clock%kick)
   end subroutine average_gravity

   !> Set gravity to that of the present time.
   pure subroutine update_gravity(simulation)
      type(simulation_t), intent(inout) :: simulation

      if (allocated(simulation%effects%shaking)) &
         simulation%effects%gravity = simulation%effects%shaking%velocity(simulation%clock%time)
   end subroutine update_gravity

   !> Record impulse, its moment and work of the body force, particle by particle. The particles are
   !! at the positions at which they gave the force to the nodes, and the mean velocities are known.
   subroutine record_body_force(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: began
      integer :: tile

      !$omp parallel do default(none) shared(simulation, field, dt) private(began, tile) &
      !$omp schedule(dynamic, 1)
      do tile = 1, simulation%space%tiles%own
         began = cost_clock(simulation%machine)
         call record_tile(simulation, field, simulation%scratch(omp_get_thread_num()), tile, dt)
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
   end subroutine record_body_force

   !> One tile.
   subroutine record_tile(simulation, field, scratch, tile, dt)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: carry(3, simulation%space%grid%tile_nodes)
      real(wp) :: total(3), turn(3), work, point(3), force(3), place(3)
      integer :: index, p, q, k

      total = 0.0_wp
      turn = 0.0_wp
      work = 0.0_wp
      carry = field%nodes%motion%velocity(:, :, tile) &
         + 0.5_wp*dt*field%nodes%motion%acceleration(:, :, tile)
      do index = 1, size(simulation%stores)
         if (simulation%stores(index)%count(tile) == 0) cycle
         if (.not. allocated(simulation%effects%exact%material(index)%solution)) cycle
         associate (store => simulation%stores(index), &
            solution => simulation%effects%exact%material(index)%solution)
            call locate_particles(simulation%space, simulation%scheme, field, scratch, store, tile)
            call simulation%scheme%method%basis%gather_values(simulation%space%grid, &
               scratch%shape, carry, &
               scratch%shape%vector)
            do p = 1, store%count(tile)
               q = store%first(tile) + p - 1
               do k = 1, 3
                  point(k) = store%origin%reference(q, k)
                  place(k) = store%position(q, k)
               end do
               call solution%body_force(point, simulation%effects%exact%force_time, force)
               force = store%state%mass(q)*dt*force
               total = total + force
               turn = turn + cross(place, force)
               do k = 1, 3
                  work = work + force(k)*scratch%shape%vector(p, k)
               end do
            end do
         end associate
      end do
      do k = 1, 3
         call scratch%ledger%sums(impulse + k - 1)%add(total(k))
         call scratch%ledger%sums(torque + k - 1)%add(turn(k))
      end do
      call scratch%ledger%sums(external_work)%add(work)
   end subroutine record_tile

   !> Record impulse, its moment and work of the loads on surfaces, particle by particle, with the
   !! gradient that is adjoint to the force. Equation (O.6) of doc/theory/instruments.md.
   subroutine record_loads(simulation, scratch, store, tile, centre)
      type(simulation_t), intent(in) :: simulation   !! With loads
      !> Of this thread: particles located, and the gradient of the velocity times the kick
      type(scratch_t), intent(inout) :: scratch
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: centre(:, :) !! (3, node) Velocity, mid-step [m/s]
      real(wp) :: total(3), turn(3), work, force(3), place(3), given
      integer :: p, q, k

      call find_loads(simulation, scratch, store, tile)
      call simulation%scheme%method%basis%gather_values(simulation%space%grid, scratch%shape, &
         centre, scratch%shape%vector)
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
               force(k) = simulation%clock%kick*store%state%volume(q)*scratch%pushed%density(p, k)
               place(k) = store%position(q, k)
               given = given + force(k)*scratch%shape%vector(p, k)
            end do
            total = total + force
            turn = turn + cross(place, force)
            work = work + given
            scratch%load_work = max(scratch%load_work, given/store%state%mass(q))
         end do
      end associate
      do k = 1, 3
         call scratch%ledger%sums(impulse + k - 1)%add(total(k))
         call scratch%ledger%sums(torque + k - 1)%add(turn(k))
      end do
      call scratch%ledger%sums(external_work)%add(work)
   end subroutine record_loads
end module step_body_force
