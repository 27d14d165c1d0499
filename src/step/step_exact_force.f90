! SPDX-License-Identifier: BSD-3-Clause
!> The body force of a manufactured solution.
module step_exact_force
   use base_kinds, only: wp
   use exact_solution, only: exact_t
   use omp_lib, only: omp_get_thread_num
   use step_ledger, only: cross, external_work, impulse, torque
   use step_particles_to_nodes, only: locate_particles
   use step_simulation, only: scratch_t, simulation_t, velocity_field_t
   implicit none
   private

   public :: record_body_force

contains

   !> Record impulse, its moment and work of the body force, particle by particle. The particles are
   !! at the positions at which they gave the force to the nodes, and the mean velocities are known.
   subroutine record_body_force(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      integer :: tile

      !$omp parallel do default(none) shared(simulation, field, dt) private(tile) &
      !$omp schedule(dynamic, 1)
      do tile = 1, simulation%space%tiles%own
         call record_tile(simulation, field, simulation%scratch(omp_get_thread_num()), tile, dt)
      end do
      !$omp end parallel do
   end subroutine record_body_force

   !> One tile.
   subroutine record_tile(simulation, field, scratch, tile, dt)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp) :: carry(3, simulation%space%grid%tile_nodes)
      real(wp) :: total(3), turn(3), work, point(3), force(3), place(3)
      integer :: index, p, q, k

      total = 0.0_wp
      turn = 0.0_wp
      work = 0.0_wp
      carry = field%nodes%velocity(:, :, tile) &
         + 0.5_wp*dt*field%nodes%acceleration(:, :, tile)
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
                  point(k) = store%reference(q, k)
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
end module step_exact_force
