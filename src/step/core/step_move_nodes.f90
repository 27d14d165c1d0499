! SPDX-License-Identifier: BSD-3-Clause
!> Updates the nodes in a step. Every tile, own or ghost, updates all its nodes; nodes that several
!! tiles share get the same bits in each tile.
module step_move_nodes
   use base_kinds, only: wp
   use mesh_packed_patch, only: move_packed_patches
   use mesh_patch, only: add_field, assemble, clear_patch, combine, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use step_dissipation, only: damps
   use step_dual_gradient, only: limit_tile_gains, find_volumes, store_gradient
   use step_node_displacement, only: examine_tile, worse
   use step_node_fields, only: empty_mass
   use step_node_sums, only: divide, divide_motion, ensure_sums, find_sums, slots
   use step_particles_to_nodes, only: vector_rows
   use step_simulation, only: clock_t, machine_t, reach_t, scheme_t, scratch_t, &
      simulation_effects_t, simulation_t, space_t, velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   use step_walls, only: constrain_tile, hold_at_walls, record_push, record_stopped, &
      record_unbalanced, start_walls, stop_at_walls, walls_touch
   use transfer_scatter, only: motion_columns
   implicit none
   private

   public :: records_later, finish_node_motion, move_nodes, restore_velocities, &
      find_remapped_velocities, start_node_motion, &
      strain_nodes

contains

   !> Velocity and acceleration of the nodes, the velocity that strains the particles, and its node
   !! gradient. With a time step of zero the nodes do not change: the velocity before the step
   !! strains.
   subroutine move_nodes(simulation, field, dt, whole)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      !> Time step, present if node displacements are examined and node fields are not kept [s]
      real(wp), intent(in), optional :: whole
      integer :: tile, last
      real(wp) :: began

      call simulation%machine%timer%start(simulation%machine%phase%grid)
      call ensure_moved(simulation, field)
      call start_walls(simulation, dt)
      ! of ghosts, only the dual gradient needs velocities
      last = merge(simulation%space%tiles%all, simulation%space%tiles%own, &
         simulation%scheme%method%dual)
      simulation%scratch%reach = reach_t()
      field%nodes%motion%acting = dt
      if (records_later(simulation%space, simulation%scheme, simulation%effects)) call &
         ensure_later(simulation%space, field)
      !$omp parallel do default(none) shared(simulation, field, dt, whole, last) &
      !$omp private(tile, began) schedule(static)
      do tile = 1, last
         began = cost_clock(simulation%machine)
         associate (scratch => simulation%scratch(omp_get_thread_num()))
            call start_tile(simulation, field, scratch, tile, dt)
            call finish_tile(simulation, field, tile, dt)
            if (field%nodes%motion%lean .and. tile <= simulation%space%tiles%own) &
               call keep_seen(simulation, field, scratch, tile, whole)
         end associate
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
      call simulation%machine%timer%stop(simulation%machine%phase%grid)
   end subroutine move_nodes

   !> Is the work of walls and gravity recorded with the velocity that strains, which `musl`
   !! computes after the particles have received their velocities? If materials carry internal
   !! energy, energy and work both use the velocities of the forces.
   pure logical function records_later(space, scheme, effects) result(later)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      integer :: face

      later = scheme%method%remaps() .and. .not. scheme%carries_energy
      if (later) later = allocated(effects%gravity) .or. allocated(space%rigid) &
         .or. effects%damping > 0.0_wp &
         .or. any([(space%boundary%acts_on(face), face=1, 6)])
   end function records_later

   !> Allocate the fields for work that is recorded later.
   subroutine ensure_later(space, field)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(inout) :: field

      associate (nodes => field%nodes, number => space%grid%tile_nodes, &
         own => space%tiles%own)
         call ensure_patch(nodes%work%push, 3, number, own)
         call ensure_patch(nodes%work%taken, 3, number, own)
      end associate
   end subroutine ensure_later

   !> Keep the fields that the particles of a tile need, and examine the displacements of its nodes.
   subroutine keep_seen(simulation, field, scratch, tile, whole)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in), optional :: whole        !! Time step [s]
      type(reach_t) :: reach
      integer :: slot

      associate (nodes => field%nodes, grid => simulation%space%grid)
         slot = nodes%slot(tile)
         call nodes%motion%seen(1)%put(grid, nodes%motion%touched, tile, 1, &
            nodes%motion%velocity(:, :, slot))
         call nodes%motion%seen(2)%put(grid, nodes%motion%touched, tile, 1, &
            nodes%motion%acceleration(:, :, slot))
         if (.not. present(whole)) return
         call examine_tile(simulation, field, tile, slot, simulation%space%mesh_time(whole), reach)
         if (worse(reach, scratch%reach)) scratch%reach = reach
      end associate
   end subroutine keep_seen

   !> Restore the fields that the particles of a tile need, if they are kept as packed patches.
   subroutine restore_velocities(simulation, field, tile)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      integer :: slot

      associate (nodes => field%nodes, grid => simulation%space%grid)
         if (.not. nodes%motion%lean) return
         slot = nodes%slot(tile)
         call nodes%motion%seen(1)%get(grid, nodes%motion%touched, tile, nodes%motion%velocity(:, &
            :, slot))
         call nodes%motion%seen(2)%get(grid, nodes%motion%touched, tile, &
            nodes%motion%acceleration(:, :, slot))
         if (simulation%scheme%method%dual) call find_volumes(simulation, field, tile, slot)
         ! the same numbers as in the first computation, so that the bits are the same
         call combine(1.0_wp, nodes%motion%velocity(:, :, slot), nodes%motion%acting, &
            nodes%motion%acceleration(:, :, slot), nodes%motion%strain(:, :, slot))
         call limit_tile_gains(simulation, field, tile, slot, nodes%motion%acting)
      end associate
   end subroutine restore_velocities

   !> First part of the node motion, for a velocity field that contact with other bodies may change.
   subroutine start_node_motion(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile
      real(wp) :: began

      call simulation%machine%timer%start(simulation%machine%phase%grid)
      call ensure_moved(simulation, field)
      call start_walls(simulation, dt)
      call ensure_patch(field%nodes%work%push, 3, simulation%space%grid%tile_nodes, &
         simulation%space%tiles%own)
      !$omp parallel do default(none) shared(simulation, field, dt) private(tile, began) &
      !$omp schedule(static)
      do tile = 1, simulation%space%tiles%all
         began = cost_clock(simulation%machine)
         if (tile <= simulation%space%tiles%own) call clear_patch(field%nodes%work%push(:, :, tile))
         call start_tile(simulation, field, simulation%scratch(omp_get_thread_num()), tile, dt)
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
      call simulation%machine%timer%stop(simulation%machine%phase%grid)
   end subroutine start_node_motion

   !> Second part of the node motion, after contact: ledger and gradients.
   subroutine finish_node_motion(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile
      real(wp) :: began

      call simulation%machine%timer%start(simulation%machine%phase%grid)
      !$omp parallel do default(none) shared(simulation, field, dt) private(tile, began) &
      !$omp schedule(static)
      do tile = 1, simulation%space%tiles%all
         began = cost_clock(simulation%machine)
         if (dt > 0.0_wp .and. tile <= simulation%space%tiles%own) &
            call record_tile(simulation, field, simulation%scratch(omp_get_thread_num()), tile, dt)
         call finish_tile(simulation, field, tile, dt)
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
      call simulation%machine%timer%stop(simulation%machine%phase%grid)
   end subroutine finish_node_motion

   !> Record the work of walls and gravity on the nodes of a tile, at the velocity after contact.
   subroutine record_tile(simulation, field, scratch, tile, dt)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: centre(3, simulation%space%grid%tile_nodes)

      associate (nodes => field%nodes)
         centre = nodes%motion%velocity(:, :, tile) + 0.5_wp*dt*nodes%motion%acceleration(:, :, &
            tile)
         call record_push(simulation%space, field, scratch%ledger, tile, nodes%work%push(:, :, &
            tile), &
            centre)
      end associate
   end subroutine record_tile

   !> Allocate the fields that move and strain the particles. The node stress is no longer needed,
   !! so the gradient uses its memory.
   subroutine ensure_moved(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer :: n, held

      associate (nodes => field%nodes, grid => simulation%space%grid)
         if (.not. simulation%scheme%method%dual) call ensure_sums(simulation, field)
         call ensure_patch(nodes%motion%strain, 3, grid%tile_nodes, slots(simulation, field))
         held = 0
         if (nodes%motion%lean) held = nodes%motion%touched%before(simulation%space%tiles%own + 1)
         do n = 1, size(nodes%motion%seen)
            if (.not. allocated(nodes%motion%seen(n)%row)) call nodes%motion%seen(n)%keep(3, &
               vector_rows(grid))
            call nodes%motion%seen(n)%ensure(held)
         end do
         if (.not. simulation%scheme%method%dual) return
         call move_packed_patches(nodes%motion%packed(2), nodes%dual%gradient)
         call nodes%dual%gradient%ensure(nodes%dual%weighted%nodes())
         if (simulation%scheme%works) call &
            nodes%dual%middle%ensure(nodes%dual%weighted%nodes())
         if (simulation%scheme%method%averages()) call &
            nodes%dual%earlier%ensure(nodes%dual%weighted%nodes())
      end associate
   end subroutine ensure_moved

   !> Velocity and acceleration of the nodes of a tile, and the velocity that strains. Equation
   !! (M.16) of doc/theory/method.md.
   subroutine start_tile(simulation, field, scratch, tile, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: force(3, simulation%space%grid%tile_nodes)
      integer :: component, slot

      slot = field%nodes%slot(tile)
      if (field%nodes%motion%lean .or. .not. simulation%scheme%method%dual) &
         call find_sums(simulation%space, field, tile, slot)
      associate (grid => simulation%space%grid, nodes => field%nodes, &
         velocity => field%nodes%motion%velocity(:, :, slot), &
         acceleration => field%nodes%motion%acceleration(:, :, slot), &
         mass => field%nodes%motion%mass(1, :, slot))
         if (simulation%scheme%method%dual) then
            call nodes%dual%force%assemble(grid, simulation%space%tiles, nodes%dual%weighted, &
               tile, force)
            call add_field(force, acceleration)
         end if
         if (simulation%scheme%method%differing()) &
            acceleration = acceleration + nodes%stress%difference(:, :, tile)
         call divide_motion(nodes%motion%mass(:, :, slot), velocity, acceleration)
         if (allocated(simulation%effects%gravity)) then
            do component = 1, 3
               where (mass > empty_mass) acceleration(component, :) = &
                  acceleration(component, :) + simulation%effects%gravity(component)
            end do
         end if
         if (simulation%effects%damping > 0.0_wp) &
            acceleration = acceleration - simulation%effects%damping*velocity
         if (allocated(simulation%space%cell)) call turn_nodes(simulation%space, field, scratch, &
            tile, dt, velocity, acceleration)
         call constrain_tile(simulation, field, scratch, tile, dt, mass, velocity, acceleration)
         call combine(1.0_wp, velocity, dt, acceleration, nodes%motion%strain(:, :, slot))
         if (allocated(scratch%unbalanced) .and. tile <= simulation%space%tiles%own) &
            call record_unbalanced(simulation%space, field, scratch, tile, acceleration)
      end associate
   end subroutine start_tile

   !> Acceleration of the nodes of a tile in a cell that deforms, and the work of its flow on them.
   subroutine turn_nodes(space, field, scratch, tile, dt, velocity, acceleration)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: push(3, size(velocity, 2)), centre(3, size(velocity, 2))

      call space%cell%turn_nodes(dt, velocity, acceleration, push, centre)
      if (dt > 0.0_wp .and. tile <= space%tiles%own) call record_push(space, field, &
         scratch%ledger, tile, push, centre)
   end subroutine turn_nodes

   !> Gradients of the velocities that strain the particles of a tile.
   subroutine finish_tile(simulation, field, tile, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: centre(3, simulation%space%grid%tile_nodes)
      integer :: slot

      if (.not. simulation%scheme%method%dual) return
      slot = field%nodes%slot(tile)
      call limit_tile_gains(simulation, field, tile, slot, dt)
      associate (nodes => field%nodes)
         if (simulation%scheme%method%averages()) then
            ! the strain velocity at the end of the step is mapped later
            call store_gradient(simulation%space, simulation%scheme, field, tile, &
               nodes%motion%velocity(:, &
               :, slot), nodes%dual%earlier)
         else
            call store_gradient(simulation%space, simulation%scheme, field, tile, &
               nodes%motion%strain(:, &
               :, slot), nodes%dual%gradient)
         end if
         if (.not. simulation%scheme%works) return
         call combine(1.0_wp, nodes%motion%velocity(:, :, slot), 0.5_wp*dt, &
            nodes%motion%acceleration(:, :, slot), centre)
         call store_gradient(simulation%space, simulation%scheme, field, tile, centre, &
            nodes%dual%middle)
      end associate
   end subroutine finish_tile

   !> Record the work of boundaries and gravity on the nodes of a tile at the mean of the velocity
   !! before the step and the one that strains: with the strain of `musl` the stress works with this
   !! mean, and the kinetic energy of particles grows by its product with the forces. Equation (L.7)
   !! of doc/theory/ledger.md.
   subroutine record_strained(simulation, field, scratch, tile, mapped)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: mapped(:, :) !! (3, node) Velocity that strains, without faces [m/s]
      real(wp) :: gain(3, size(mapped, 2)), work(size(mapped, 2))
      real(wp) :: centre(3, size(mapped, 2))
      logical :: ruled

      ruled = walls_touch(simulation, tile)
      if (.not. (ruled .or. allocated(simulation%effects%gravity) .or. &
         simulation%effects%damping > 0.0_wp)) return
      associate (nodes => field%nodes, share => 1.0_wp &
         - simulation%scheme%method%transfer%flip_fraction())
         centre = 0.5_wp*(nodes%motion%velocity(:, :, tile) + nodes%motion%strain(:, :, tile))
         if (.not. ruled) then
            call record_push(simulation%space, field, scratch%ledger, tile, nodes%work%push(:, :, &
               tile), &
               centre)
            return
         end if
         ! particles get the gain of a node with the velocities that it had without the faces
         gain = simulation%clock%kick*nodes%motion%acceleration(:, :, tile) - &
            share*nodes%work%taken(:, :, tile)
         work = 0.5_wp*sum(gain*(nodes%work%taken(:, :, tile) + mapped - nodes%motion%strain(:, &
            :, tile)), &
            dim=1)
         call record_push(simulation%space, field, scratch%ledger, tile, nodes%work%push(:, :, &
            tile), &
            centre, work)
         if (damps(simulation%scheme%method, simulation%scheme%carries_energy)) call &
            record_stopped(simulation%space, simulation%scheme, &
            field, &
            scratch%ledger, tile, -nodes%work%taken(:, :, tile), 0.5_wp*(nodes%motion%velocity(:, &
               :, tile) &
            + nodes%work%taken(:, :, tile) + mapped))
      end associate
   end subroutine record_strained

   !> Node velocities from the momentum that was mapped a second time, or from the previous momentum
   !! and the gain. It is the velocity that strains the particles, unless contact changes it.
   subroutine find_remapped_velocities(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp) :: began
      integer :: tile, last

      call simulation%machine%timer%start(simulation%machine%phase%grid)
      last = merge(simulation%space%tiles%all, simulation%space%tiles%own, &
         simulation%scheme%method%dual .or. allocated(simulation%effects%contact))
      !$omp parallel do default(none) shared(simulation, field, last) private(tile, began) &
      !$omp schedule(static)
      do tile = 1, last
         began = cost_clock(simulation%machine)
         call remap_tile(simulation, field, simulation%scratch(omp_get_thread_num()), tile)
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
      call simulation%machine%timer%stop(simulation%machine%phase%grid)
      call strain_nodes(simulation%space, simulation%scheme, simulation%machine, field)
   end subroutine find_remapped_velocities

   !> One tile.
   subroutine remap_tile(simulation, field, scratch, tile)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), allocatable :: none(:, :), mapped(:, :), momentum(:, :)

      associate (strain => field%nodes%motion%strain(:, :, tile))
         if (size(field%nodes%series%extra, 1) == 3) then
            call assemble(simulation%space%grid, simulation%space%tiles, &
               field%nodes%series%extra, tile, strain)
         else
            ! with linear velocity fields the patch also has the mass, in its first row
            allocate (momentum(4, size(strain, 2)))
            call assemble(simulation%space%grid, simulation%space%tiles, &
               field%nodes%series%extra, tile, momentum)
            strain = momentum(2:, :)
         end if
         call divide(field%nodes%motion%mass(:, :, tile), 1, strain)
         if (simulation%scheme%method%averages()) call add_gained(simulation%scheme, &
            simulation%clock, field, tile, strain)
         if (allocated(field%nodes%work%taken)) mapped = strain
         if (walls_touch(simulation, tile)) then
            allocate (none(3, size(strain, 2)), source=0.0_wp)
            call stop_at_walls(simulation, tile, strain, none)
            call hold_at_walls(simulation, field, tile, strain)
         end if
      end associate
      if (.not. allocated(mapped) .or. tile > simulation%space%tiles%own) return
      ! the gain is added to a velocity that walls have changed already
      if (simulation%scheme%method%averages()) mapped = mapped + field%nodes%work%taken(:, :, tile)
      call record_strained(simulation, field, scratch, tile, mapped)
   end subroutine remap_tile

   !> The velocity of the nodes of a tile at the end of a step, from the gain of the particles and a
   !! fraction of the gain that they did not receive. Equation (T.14) of doc/theory/transfers.md.
   pure subroutine add_gained(scheme, clock, field, tile, velocity)
      type(scheme_t), intent(in) :: scheme
      type(clock_t), intent(in) :: clock
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Gain [m/s]

      associate (nodes => field%nodes, share => scheme%method%unseen)
         velocity = nodes%motion%velocity(:, :, tile) + (1.0_wp - share)*velocity &
            + share*clock%kick*nodes%motion%acceleration(:, :, tile)
      end associate
   end subroutine add_gained

   !> Node gradient of the velocity that strains the particles, which was mapped again.
   subroutine strain_nodes(space, scheme, machine, field)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(velocity_field_t), intent(inout) :: field
      integer :: tile
      real(wp) :: began

      if (.not. scheme%method%dual) return
      call machine%timer%start(machine%phase%grid)
      !$omp parallel do default(none) shared(space, scheme, machine, field) private(tile, began) &
      !$omp schedule(static)
      do tile = 1, space%tiles%all
         began = cost_clock(machine)
         call store_gradient(space, scheme, field, tile, field%nodes%motion%strain(:, :, tile), &
            field%nodes%dual%gradient)
         call record_cost(machine, tile, began)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%grid)
   end subroutine strain_nodes
end module step_move_nodes
