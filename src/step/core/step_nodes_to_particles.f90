! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles, tile by tile: work, strain and stress, velocity and position. A tile stays in
!! cache throughout.
module step_nodes_to_particles
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use omp_lib, only: omp_get_thread_num
   use particle_place, only: place_tile
   use particle_store, only: store_t
   use step_body_force, only: record_loads
   use step_contact, only: add_contact_heat
   use step_dissipation, only: measures_damping, measures_update, record_damping, &
      record_unresolved
   use step_grid_volumes, only: correct_volumes
   use step_method, only: method_t
   use step_move_nodes, only: restore_velocities
   use step_node_fields, only: motion_nodes_t
   use step_node_view, only: gather_parts_t, set_view, view_t
   use step_particles_to_nodes, only: locate_particles, nodes_seen
   use step_remove_particles, only: judge_particles
   use step_simulation, only: scratch_t, simulation_t, space_t, velocity_field_t
   use step_strain_particles, only: add_gradient, affine_from_strain, find_gradient, &
      strain_particles
   use step_tile_cost, only: start_cost, stop_cost
   use step_velocity_remap, only: find_slopes
   use transfer_affine, only: gather_affine_heat, keep_affine
   use transfer_basis, only: expand_spin
   use transfer_shape_data, only: spare
   use transfer_side_kernels, only: add_other_values
   implicit none
   private

   public :: nodes_to_particles

contains

   !> Transfer the node fields to the particles.
   subroutine nodes_to_particles(simulation, field, parts, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer :: index

      associate (machine => simulation%machine)
         call machine%timer%start(machine%phase%gather)
         if (allocated(simulation%scheme%method%splitting) .and. parts%strain) then
            ! the growth rates of particles; those of other velocity fields are kept
            do index = field%first_store, field%last_store
               associate (store => simulation%stores(index))
                  if (.not. allocated(store%opening)) cycle
                  deallocate (store%opening)
                  allocate (store%opening(size(store%home)))
               end associate
            end do
         end if
         !$omp parallel default(none) shared(simulation, field, parts, dt)
         call gather_some(simulation, field, parts, dt)
         !$omp end parallel
         call machine%timer%stop(machine%phase%gather)
      end associate
   end subroutine nodes_to_particles

   !> The tiles of one thread. The view keeps its memory from tile to tile, because allocating it
   !! again costs as much as the transfer itself for a tile of one or two particles.
   subroutine gather_some(simulation, field, parts, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(view_t) :: view, other
      integer :: tile
      real(wp) :: lap

      associate (scratch => simulation%scratch(omp_get_thread_num()))
         call scratch%laps%start_step(simulation%clock%step)
         !$omp do schedule(dynamic, 1)
         do tile = 1, simulation%space%tiles%own
            call start_cost(simulation%machine, tile)
            lap = scratch%laps%read_clock()
            call gather_tile(simulation, field, scratch, tile, parts, dt, view, other)
            call scratch%laps%record(lap)
            call stop_cost(simulation%machine, tile)
         end do
         !$omp end do
      end associate
   end subroutine gather_some

   !> One tile.
   subroutine gather_tile(simulation, field, scratch, tile, parts, dt, view, other)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(view_t), intent(inout) :: view            !! Node fields for its particles
      type(view_t), intent(inout) :: other           !! The same of the other side, if it has one
      real(wp) :: fastest, steepest
      integer :: index

      associate (space => simulation%space, scheme => simulation%scheme, &
         effects => simulation%effects, materials => simulation%materials, &
         stores => simulation%stores, clock => simulation%clock)
         if (allocated(effects%contact)) then
            if (all([(stores(index)%count(tile) == 0, index=field%first_store, &
               field%last_store)])) return
         end if
         call restore_velocities(space, scheme%method, field%nodes, tile)
         call set_view(space, stores, scheme, clock, field%nodes, tile, parts, view)
         other%slot = 0
         if (allocated(field%sides)) then
            if (field%sides%cut(tile)) call set_view(space, stores, scheme, clock, &
               simulation%fields(field%other)%nodes, tile, parts, other)
         end if
         do index = field%first_store, field%last_store
            if (stores(index)%count(tile) == 0) cycle
            call locate_particles(space, scheme, field, scratch, stores(index), tile)
            call scratch%deformation%reserve(stores(index)%count(tile) + spare)
            if (parts%work) call add_particle_work(simulation, field, scratch, index, &
               tile, view, other)
            if (parts%motion) call gather_increments(simulation, field, scratch, index, &
               tile, view, other)
            fastest = 0.0_wp
            steepest = scratch%steepest
            if (parts%strain) call strain_particles(simulation, field, scratch, index, tile, &
               view, dt, fastest)
            if (parts%motion) then
               call move_particles(simulation, field, scratch, index, tile, view, other, dt)
               call place_tile(space%grid, space%boundary, space%tiles%coordinate(:, tile), &
                  stores(index), tile)
               call judge_particles(materials(index), stores(index), scheme, clock%guard, scratch, &
                  tile, fastest, steepest)
            end if
            scratch%fastest = max(scratch%fastest, fastest)
         end do
      end associate
   end subroutine gather_tile

   !> Work of the stress and of the loads on the particles of a tile.
   subroutine add_particle_work(simulation, field, scratch, index, tile, view, other)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      type(view_t), intent(in) :: other !! Node fields of the other side, if the tile has one

      associate (space => simulation%space, method => simulation%scheme%method, &
         effects => simulation%effects, store => simulation%stores(index), &
         clock => simulation%clock)
         call find_gradient(space, method, scratch, store, tile, view%middle_velocity, &
            view%middle_gradient, view%middle_surplus, clock%kick, .true.)
         if (other%slot > 0) call add_gradient(space%grid, simulation%stores, field%sides, &
            scratch, index, tile, other%middle_velocity - view%middle_velocity, clock%kick)
         if (allocated(store%state%energy)) call add_work(scratch, store, tile)
         if (allocated(effects%loads)) call record_loads(space, method, effects, clock, scratch, &
            store, tile, view%middle_velocity)
      end associate
   end subroutine add_particle_work

   !> Increments of velocity and position, if they are gathered at once, and what changes the energy
   !! and volume of the particles of a tile before the strain, which may renew the linear velocity
   !! fields.
   subroutine gather_increments(simulation, field, scratch, index, tile, view, other)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      type(view_t), intent(in) :: other !! Node fields of the other side, if the tile has one

      associate (grid => simulation%space%grid, method => simulation%scheme%method, &
         store => simulation%stores(index), material => simulation%materials(index))
         if (view%at_once) call view%increments%gather(grid, method%basis, scratch%shape)
         if (view%at_once .and. other%slot > 0) call add_other_values(grid, scratch%shape, &
            store%first(tile), field%sides%store(index - field%sides%before)%other, &
            field%sides%split(:, tile), 1.0_wp, view%increments%nodes, other%increments%nodes, 0, &
            scratch%shape%increments)
         if (allocated(store%state%energy)) call add_heat(grid, method, scratch, store, tile, view)
         if (material%repacks) then
            ! volumes of loose particles from the fill of the nodes
            call method%basis%gather_values(grid, scratch%shape, view%excess, scratch%shape%values)
            call correct_volumes(store, tile, material, scratch%shape%values, scratch%ledger)
         end if
         if (allocated(simulation%effects%contact)) call add_contact_heat(grid, method, &
            field%nodes, scratch, store, tile)
      end associate
   end subroutine gather_increments

   !> Heat from the kinetic energy that the transfers to the nodes and back lose.
   subroutine add_heat(grid, method, scratch, store, tile, view)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      integer :: p, k

      associate (shape => scratch%shape, first => store%first(tile))
         if (view%at_once) then
            call view%increments%add_heat(grid, shape, first, store%velocity, store%spin, &
               store%affine, store%state%energy)
            return
         end if
         call method%transfer%heat(grid, method%basis, shape, first, view%loss%heat, &
            store%velocity, store%state%energy)
         if (.not. method%transfer%affine()) return
         call shape%reserve_affine(store%count(tile))
         if (allocated(store%spin)) then
            call expand_spin(first, store%count(tile), store%spin, shape%affine)
         else
            do k = 1, 9
               do p = 1, store%count(tile)
                  shape%affine(p, k) = store%affine(first + p - 1, k)
               end do
            end do
         end if
         call gather_affine_heat(grid, method%basis, shape, first, view%loss%turn, &
            view%loss%moments, &
            store%state%energy)
      end associate
   end subroutine add_heat

   !> New velocities and positions of the particles of a tile.
   subroutine move_particles(simulation, field, scratch, index, tile, view, other, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      type(view_t), intent(in) :: other !! Node fields of the other side, if the tile has one
      real(wp), intent(in) :: dt                     !! Time step [s]

      associate (space => simulation%space, grid => simulation%space%grid, &
         scheme => simulation%scheme, method => simulation%scheme%method, shape => scratch%shape, &
         store => simulation%stores(index), first => simulation%stores(index)%first(tile))
         if (view%at_once) then
            call view%increments%move(shape, first, dt, store%velocity, store%position)
         else
            call method%basis%gather_motion(grid, shape, first, view%velocity_increment, &
               view%advection_velocity, method%transfer%flip_fraction(), dt, store%velocity, &
               store%position)
            if (other%slot > 0) then
               associate (sides => field%sides, split => field%sides%split(:, tile))
                  call add_other_values(grid, shape, first, &
                     sides%store(index - sides%before)%other, split, 1.0_wp, &
                     view%velocity_increment, other%velocity_increment, first - 1, store%velocity)
                  call add_other_values(grid, shape, first, &
                     sides%store(index - sides%before)%other, split, dt, view%advection_velocity, &
                     other%advection_velocity, first - 1, store%position)
               end associate
            end if
         end if
         if (allocated(space%cell)) call carry_particles(space, scheme%method, scratch, store, &
            tile, view, dt)
         if (measures_damping(method, allocated(store%state%energy))) then
            if (view%at_once) then
               call view%increments%find_way(shape)
            else
               call method%basis%gather_values(grid, shape, view%advection_velocity, shape%vector)
            end if
            call record_damping(scratch%ledger, store, tile, shape%vector, &
               method%transfer%flip_fraction())
         end if
         if (scheme%loose .and. measures_update(method, allocated(store%state%energy))) &
            call record_gain(space, method, field%nodes%motion, scratch, store, tile, &
            simulation%clock%kick)
         if (.not. method%transfer%affine() .or. affine_from_strain(scheme, index)) return
         call find_slopes(space%grid, scheme%method, shape, view%velocity_new, view%gradient, &
            scratch%deformation%gradient)
         if (other%slot > 0) call add_gradient(space%grid, simulation%stores, field%sides, &
            scratch, index, tile, other%velocity_new - view%velocity_new, 1.0_wp)
         call keep_affine(store, tile, 1.0_wp, scratch%deformation%gradient)
      end associate
   end subroutine move_particles

   !> Record the work of the stress on the gain of the nodes that the particles of a tile do not
   !! get. Equation (L.13) of doc/theory/ledger.md.
   subroutine record_gain(space, method, motion, scratch, store, tile, dt)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(motion_nodes_t), intent(in) :: motion
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: gain(space%grid%dimensions + 1, space%grid%tile_nodes)
      integer :: axis(space%grid%dimensions), low, high, slot, node, last

      last = space%grid%dimensions + 1
      axis = pack([1, 2, 3], space%grid%active)
      slot = motion%slot(tile)
      call nodes_seen(space%grid, motion, tile, low, high)
      gain = 0.0_wp
      do node = low, high
         gain(:last - 1, node) = dt*motion%acceleration(axis, node, slot)
         gain(last, node) = sum(gain(:last - 1, node)*(motion%strain(axis, node, slot) &
            - motion%velocity(axis, node, slot)))
      end do
      call method%basis%gather_values(space%grid, scratch%shape, gain, scratch%shape%values)
      call record_unresolved(scratch%ledger, store, tile, last - 1, scratch%shape%values)
   end subroutine record_gain

   !> Positions on the mesh of a cell that deforms.
   subroutine carry_particles(space, method, scratch, store, tile, view, dt)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time step [s]

      associate (shape => scratch%shape)
         if (view%at_once) then
            call view%increments%find_way(shape)
         else
            call method%basis%gather_values(space%grid, shape, &
               view%advection_velocity, shape%vector)
         end if
         call space%cell%carry(store%first(tile), store%count(tile), dt, shape%vector, &
            store%position)
      end associate
   end subroutine carry_particles

   !> Work of the stress that made the force on the mean of the velocities of the nodes, so that
   !! particles gain the kinetic energy that nodes lose: (T.5) of doc/theory/transfers.md.
   pure subroutine add_work(scratch, store, tile)
      type(scratch_t), intent(in) :: scratch !! Scratch memory of this thread, with the gradient
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      integer :: p, q, first

      first = store%first(tile)
      associate (stress => store%state%stress, gradient => scratch%deformation%gradient)
         do p = 1, store%count(tile)
            q = first + p - 1
            store%state%energy(q) = store%state%energy(q) + store%state%volume(q) &
               /store%state%mass(q)*(stress(q, 1)*gradient(p, 1) + stress(q, 2)*gradient(p, 5) &
               + stress(q, 3)*gradient(p, 9) + stress(q, 4)*(gradient(p, 2) + gradient(p, 4)) &
               + stress(q, 5)*(gradient(p, 6) + gradient(p, 8)) &
               + stress(q, 6)*(gradient(p, 3) + gradient(p, 7)))
         end do
      end associate
   end subroutine add_work
end module step_nodes_to_particles
