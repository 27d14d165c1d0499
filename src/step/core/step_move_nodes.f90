! SPDX-License-Identifier: BSD-3-Clause
!> Updates the nodes in a step. Every tile, own or ghost, updates all its nodes; nodes that several
!! tiles share get the same bits in each tile.
module step_move_nodes
   use base_kinds, only: wp
   use mesh_packed_patch, only: move_packed_patches
   use mesh_patch, only: add_field, assemble, clear_patch, combine, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_bounds, only: guard_t
   use step_dissipation, only: measures_damping
   use step_dual_gradient, only: limit_tile_gains, find_volumes, store_gradient
   use step_method, only: method_t
   use step_node_displacement, only: examine_tile, is_worse
   use step_node_fields, only: dual_nodes_t, empty_mass, motion_nodes_t, nodes_t, vector_rows
   use step_node_sums, only: divide_nodes, divide_motion, ensure_sums, find_sums, count_slots
   use step_simulation, only: clock_t, machine_t, reach_t, scheme_t, scratch_t, &
      simulation_effects_t, simulation_t, space_t
   use step_tile_cost, only: start_cost, stop_cost
   use step_walls, only: constrain_tile, hold_at_walls, record_push, record_stopped, &
      record_unbalanced, start_walls, stop_at_walls, walls_touch
   implicit none
   private

   public :: ensure_moved, find_free_motion, find_remapped_velocities, finish_node_motion, &
      move_nodes, records_later, restore_velocities, start_node_motion

contains

   !> Velocity and acceleration of the nodes, the velocity that strains the particles, and its node
   !! gradient. With a time step of zero the nodes do not change: the velocity before the step
   !! strains.
   subroutine move_nodes(simulation, nodes, dt, whole)
      type(simulation_t), intent(inout) :: simulation
      type(nodes_t), intent(inout) :: nodes
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      !> Time step, present if node displacements are examined and node fields are not kept [s]
      real(wp), intent(in), optional :: whole
      integer :: tile, last

      call simulation%machine%timer%start(simulation%machine%phase%grid)
      call ensure_moved(simulation%space, simulation%scheme, simulation%scratch, nodes)
      call start_walls(simulation%space, simulation%scheme%method, simulation%clock, &
         simulation%balance%ledger, simulation%machine, simulation%scratch, dt)
      ! of ghosts, only the dual gradient needs velocities
      last = merge(simulation%space%tiles%all, simulation%space%tiles%own, &
         simulation%scheme%method%dual)
      simulation%scratch%reach = reach_t()
      nodes%motion%acting = dt
      if (records_later(simulation%space, simulation%scheme, simulation%effects)) then
         ! allocate the fields for work that is recorded later
         associate (number => simulation%space%grid%tile_nodes, own => simulation%space%tiles%own)
            call ensure_patch(nodes%work%velocity_change, 3, number, own)
            call ensure_patch(nodes%work%velocity_removed, 3, number, own)
         end associate
      end if
      !$omp parallel do default(none) shared(simulation, nodes, dt, whole, last) private(tile) &
      !$omp schedule(static)
      do tile = 1, last
         call start_cost(simulation%machine, tile)
         associate (scratch => simulation%scratch(omp_get_thread_num()))
            call start_tile(simulation%space, simulation%scheme, simulation%effects, &
               simulation%clock, nodes, scratch, tile, dt)
            call finish_tile(simulation%space, simulation%scheme, nodes, tile, dt)
            if (nodes%motion%lean .and. tile <= simulation%space%tiles%own) &
               call keep_seen(simulation%space, simulation%stores, simulation%scheme%method, &
               simulation%clock%guard, nodes%motion, scratch, tile, whole)
         end associate
         call stop_cost(simulation%machine, tile)
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

   !> Keep the fields that the particles of a tile need, and examine the displacements of its nodes.
   subroutine keep_seen(space, stores, method, guard, motion, scratch, tile, whole)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(guard_t), intent(in) :: guard
      type(motion_nodes_t), intent(inout) :: motion
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in), optional :: whole        !! Time step [s]
      type(reach_t) :: reach
      integer :: slot

      associate (grid => space%grid)
         slot = motion%slot(tile)
         call motion%seen(1)%put(grid, motion%touched, tile, 1, motion%velocity(:, :, slot))
         call motion%seen(2)%put(grid, motion%touched, tile, 1, motion%acceleration(:, :, slot))
         if (.not. present(whole)) return
         call examine_tile(space, stores, method, guard, motion, tile, &
            space%mesh_time(whole), reach)
         if (is_worse(reach, scratch%reach)) scratch%reach = reach
      end associate
   end subroutine keep_seen

   !> Restore the fields that the particles of a tile need, if they are kept as packed patches.
   subroutine restore_velocities(space, method, nodes, tile)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      integer :: slot

      associate (motion => nodes%motion, grid => space%grid)
         if (.not. motion%lean) return
         slot = motion%slot(tile)
         call motion%seen(1)%get(grid, motion%touched, tile, motion%velocity(:, :, slot))
         call motion%seen(2)%get(grid, motion%touched, tile, motion%acceleration(:, :, slot))
         if (method%dual) call find_volumes(space, nodes%dual, tile, slot)
         ! the same numbers as in the first computation, so that the bits are the same
         call combine(1.0_wp, motion%velocity(:, :, slot), motion%acting, &
            motion%acceleration(:, :, slot), motion%strain(:, :, slot))
         call limit_tile_gains(space, method, nodes, tile, slot, motion%acting)
      end associate
   end subroutine restore_velocities

   !> First part of the node motion, for a velocity field that contact with other bodies may change.
   subroutine start_node_motion(simulation, nodes, dt)
      type(simulation_t), intent(inout) :: simulation
      type(nodes_t), intent(inout) :: nodes
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile

      call simulation%machine%timer%start(simulation%machine%phase%grid)
      call ensure_moved(simulation%space, simulation%scheme, simulation%scratch, nodes)
      call start_walls(simulation%space, simulation%scheme%method, simulation%clock, &
         simulation%balance%ledger, simulation%machine, simulation%scratch, dt)
      call ensure_patch(nodes%work%velocity_change, 3, simulation%space%grid%tile_nodes, &
         simulation%space%tiles%own)
      !$omp parallel do default(none) shared(simulation, nodes, dt) private(tile) schedule(static)
      do tile = 1, simulation%space%tiles%all
         call start_cost(simulation%machine, tile)
         if (tile <= simulation%space%tiles%own) &
            call clear_patch(nodes%work%velocity_change(:, :, tile))
         call start_tile(simulation%space, simulation%scheme, simulation%effects, &
            simulation%clock, nodes, simulation%scratch(omp_get_thread_num()), tile, dt)
         call stop_cost(simulation%machine, tile)
      end do
      !$omp end parallel do
      call simulation%machine%timer%stop(simulation%machine%phase%grid)
   end subroutine start_node_motion

   !> Second part of the node motion, after contact: ledger and gradients.
   subroutine finish_node_motion(space, scheme, machine, scratches, nodes, dt)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(nodes_t), intent(inout) :: nodes
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile

      call machine%timer%start(machine%phase%grid)
      !$omp parallel do default(none) shared(space, scheme, machine, scratches, nodes, dt) &
      !$omp private(tile) schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         if (dt > 0.0_wp .and. tile <= space%tiles%own) call record_tile(space, nodes, &
            scratches(omp_get_thread_num()), tile, dt)
         call finish_tile(space, scheme, nodes, tile, dt)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%grid)
   end subroutine finish_node_motion

   !> Record the work of walls and gravity on the nodes of a tile, at the velocity after contact.
   subroutine record_tile(space, nodes, scratch, tile, dt)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(in) :: nodes
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: centre(3, space%grid%tile_nodes)

      centre = nodes%motion%velocity(:, :, tile) + 0.5_wp*dt*nodes%motion%acceleration(:, :, tile)
      call record_push(space, nodes%motion, scratch%ledger, tile, &
         nodes%work%velocity_change(:, :, tile), centre)
   end subroutine record_tile

   !> Allocate the fields that move and strain the particles. The node stress is no longer needed,
   !! so the gradient uses its memory.
   subroutine ensure_moved(space, scheme, scratches, nodes)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(scratch_t), intent(inout) :: scratches(0:)
      type(nodes_t), intent(inout) :: nodes
      integer :: n, held

      associate (motion => nodes%motion, dual => nodes%dual, grid => space%grid)
         if (.not. scheme%method%dual) call ensure_sums(space, scratches, motion)
         call ensure_patch(motion%strain, 3, grid%tile_nodes, count_slots(space%tiles, &
            scratches, motion))
         held = 0
         if (motion%lean) held = motion%touched%before(space%tiles%own + 1)
         do n = 1, size(motion%seen)
            if (.not. allocated(motion%seen(n)%row)) call motion%seen(n)%keep(3, vector_rows(grid))
            call motion%seen(n)%ensure(held)
         end do
         if (.not. scheme%method%dual) return
         call move_packed_patches(motion%packed(2), dual%gradient)
         call dual%gradient%ensure(dual%weighted%nodes())
         if (scheme%works) call dual%middle_gradient%ensure(dual%weighted%nodes())
         if (scheme%method%averages()) call dual%gradient_before%ensure(dual%weighted%nodes())
      end associate
   end subroutine ensure_moved

   !> Velocity and acceleration of the nodes of a tile, and the velocity that strains. Equation
   !! (M.16) of doc/theory/method.md.
   subroutine start_tile(space, scheme, effects, clock, nodes, scratch, tile, dt)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(clock_t), intent(in) :: clock
      type(nodes_t), intent(inout) :: nodes
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      integer :: slot

      slot = nodes%motion%slot(tile)
      if (nodes%motion%lean .or. .not. scheme%method%dual) call find_sums(space, &
         nodes%motion, tile, slot)
      associate (velocity => nodes%motion%velocity(:, :, slot), &
         acceleration => nodes%motion%acceleration(:, :, slot))
         call find_free_motion(space, scheme, effects, nodes%dual, tile, &
            nodes%motion%mass(:, :, slot), velocity, acceleration)
         if (allocated(space%cell)) call turn_nodes(space, nodes%motion, scratch, tile, dt, &
            velocity, acceleration)
         call constrain_tile(space, scheme, effects, clock, nodes, scratch, tile, dt, &
            velocity, acceleration)
         call combine(1.0_wp, velocity, dt, acceleration, nodes%motion%strain(:, :, slot))
         if (allocated(scratch%unbalanced) .and. tile <= space%tiles%own) &
            call record_unbalanced(space%grid, nodes%motion, scratch, tile, acceleration)
      end associate
   end subroutine start_tile

   !> Velocity and acceleration of the nodes of a tile before walls act, from momentum and force.
   pure subroutine find_free_motion(space, scheme, effects, dual, tile, mass, velocity, &
      acceleration)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(dual_nodes_t), intent(in) :: dual         !! Forces of the dual gradient
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: mass(:, :) !! (1, node) [kg]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) In: momentum [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) In: force [m/s2]
      real(wp) :: force(3, space%grid%tile_nodes)
      integer :: component

      if (scheme%method%dual) then
         call dual%force%assemble(space%grid, space%tiles, dual%weighted, tile, force)
         call add_field(force, acceleration)
      end if
      call divide_motion(mass, velocity, acceleration)
      if (allocated(effects%gravity)) then
         do component = 1, 3
            where (mass(1, :) > empty_mass) acceleration(component, :) = &
               acceleration(component, :) + effects%gravity(component)
         end do
      end if
      if (effects%damping > 0.0_wp) acceleration = acceleration - effects%damping*velocity
   end subroutine find_free_motion

   !> Acceleration of the nodes of a tile in a cell that deforms, and the work of its flow on them.
   subroutine turn_nodes(space, motion, scratch, tile, dt, velocity, acceleration)
      type(space_t), intent(in) :: space
      type(motion_nodes_t), intent(in) :: motion
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: push(3, size(velocity, 2)), centre(3, size(velocity, 2))

      call space%cell%turn_nodes(dt, velocity, acceleration, push, centre)
      if (dt > 0.0_wp .and. tile <= space%tiles%own) call record_push(space, motion, &
         scratch%ledger, tile, push, centre)
   end subroutine turn_nodes

   !> Gradients of the velocities that strain the particles of a tile.
   subroutine finish_tile(space, scheme, nodes, tile, dt)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: centre(3, space%grid%tile_nodes)
      integer :: slot

      if (.not. scheme%method%dual) return
      slot = nodes%motion%slot(tile)
      call limit_tile_gains(space, scheme%method, nodes, tile, slot, dt)
      if (scheme%method%averages()) then
         ! the strain velocity at the end of the step is mapped later
         call store_gradient(space, scheme%dual, nodes, tile, &
            nodes%motion%velocity(:, :, slot), nodes%dual%gradient_before)
      else
         call store_gradient(space, scheme%dual, nodes, tile, &
            nodes%motion%strain(:, :, slot), nodes%dual%gradient)
      end if
      if (.not. scheme%works) return
      call combine(1.0_wp, nodes%motion%velocity(:, :, slot), 0.5_wp*dt, &
         nodes%motion%acceleration(:, :, slot), centre)
      call store_gradient(space, scheme%dual, nodes, tile, centre, nodes%dual%middle_gradient)
   end subroutine finish_tile

   !> Record the work of boundaries and gravity on the nodes of a tile at the mean of the velocity
   !! before the step and the one that strains: with the strain of `musl` the stress works with this
   !! mean, and the kinetic energy of particles grows by its product with the forces. Equation (L.7)
   !! of doc/theory/ledger.md.
   subroutine record_strained(space, scheme, effects, clock, nodes, scratch, tile, mapped)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(clock_t), intent(in) :: clock
      type(nodes_t), intent(in) :: nodes
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: mapped(:, :) !! (3, node) Velocity that strains, without faces [m/s]
      real(wp) :: gain(3, size(mapped, 2)), work(size(mapped, 2))
      real(wp) :: centre(3, size(mapped, 2))
      logical :: ruled

      ruled = walls_touch(space, tile)
      if (.not. (ruled .or. allocated(effects%gravity) .or. effects%damping > 0.0_wp)) return
      associate (share => 1.0_wp - scheme%method%transfer%flip_fraction())
         centre = 0.5_wp*(nodes%motion%velocity(:, :, tile) + nodes%motion%strain(:, :, tile))
         if (.not. ruled) then
            call record_push(space, nodes%motion, scratch%ledger, tile, &
               nodes%work%velocity_change(:, :, tile), centre)
            return
         end if
         ! particles get the gain of a node with the velocities that it had without the faces
         gain = clock%kick*nodes%motion%acceleration(:, :, tile) &
            - share*nodes%work%velocity_removed(:, :, tile)
         work = 0.5_wp*sum(gain*(nodes%work%velocity_removed(:, :, tile) + mapped &
            - nodes%motion%strain(:, :, tile)), dim=1)
         call record_push(space, nodes%motion, scratch%ledger, tile, &
            nodes%work%velocity_change(:, :, tile), centre, work)
         if (measures_damping(scheme%method, scheme%carries_energy)) &
            call record_stopped(space%grid, scheme%method, nodes%motion, scratch%ledger, tile, &
            -nodes%work%velocity_removed(:, :, tile), 0.5_wp*(nodes%motion%velocity(:, :, tile) &
            + nodes%work%velocity_removed(:, :, tile) + mapped))
      end associate
   end subroutine record_strained

   !> Node velocities from the momentum that was mapped a second time, or from the previous momentum
   !! and the gain. It is the velocity that strains the particles, unless contact changes it.
   subroutine find_remapped_velocities(space, scheme, effects, clock, machine, scratches, nodes)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(clock_t), intent(in) :: clock
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(nodes_t), intent(inout) :: nodes
      integer :: tile, last

      call machine%timer%start(machine%phase%grid)
      last = merge(space%tiles%all, space%tiles%own, scheme%method%dual .or. &
         allocated(effects%contact))
      !$omp parallel do default(none) shared(space, scheme, effects, clock, machine, scratches, &
      !$omp nodes, last) private(tile) schedule(static)
      do tile = 1, last
         call start_cost(machine, tile)
         call remap_tile(space, scheme, effects, clock, nodes, scratches(omp_get_thread_num()), &
            tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%grid)
      call strain_nodes(space, scheme, machine, nodes)
   end subroutine find_remapped_velocities

   !> One tile.
   subroutine remap_tile(space, scheme, effects, clock, nodes, scratch, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(clock_t), intent(in) :: clock
      type(nodes_t), intent(inout) :: nodes
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), allocatable :: none(:, :), mapped(:, :), momentum(:, :)

      associate (strain => nodes%motion%strain(:, :, tile))
         if (size(nodes%remap, 1) == 3) then
            call assemble(space%grid, space%tiles, nodes%remap, tile, strain)
         else
            ! with linear velocity fields the patch also has the mass, in its first row
            allocate (momentum(4, size(strain, 2)))
            call assemble(space%grid, space%tiles, nodes%remap, tile, momentum)
            strain = momentum(2:, :)
         end if
         call divide_nodes(nodes%motion%mass(:, :, tile), 1, strain)
         if (scheme%method%averages()) then
            ! the velocity of the nodes of a tile at the end of a step, from the gain of the
            ! particles. Equation (T.9) of doc/theory/transfers.md
            strain = nodes%motion%velocity(:, :, tile) + strain
         end if
         if (allocated(nodes%work%velocity_removed)) mapped = strain
         if (walls_touch(space, tile)) then
            allocate (none(3, size(strain, 2)), source=0.0_wp)
            call stop_at_walls(space, tile, strain, none)
            call hold_at_walls(space, clock, nodes%motion, tile, strain)
         end if
      end associate
      if (.not. allocated(mapped) .or. tile > space%tiles%own) return
      ! the gain is added to a velocity that walls have changed already
      if (scheme%method%averages()) mapped = mapped + nodes%work%velocity_removed(:, :, tile)
      call record_strained(space, scheme, effects, clock, nodes, scratch, tile, mapped)
   end subroutine remap_tile

   !> Node gradient of the velocity that strains the particles, which was mapped again.
   subroutine strain_nodes(space, scheme, machine, nodes)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(nodes_t), intent(inout) :: nodes
      integer :: tile

      if (.not. scheme%method%dual) return
      call machine%timer%start(machine%phase%grid)
      !$omp parallel do default(none) shared(space, scheme, machine, nodes) private(tile) &
      !$omp schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call store_gradient(space, scheme%dual, nodes, tile, &
            nodes%motion%strain(:, :, tile), nodes%dual%gradient)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%grid)
   end subroutine strain_nodes
end module step_move_nodes
