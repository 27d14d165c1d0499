! SPDX-License-Identifier: BSD-3-Clause
!> One step of time.
module step_advance
   use base_error, only: error_t
   use base_kinds, only: wp
   use material_type, only: material_t
   use mesh_surface_load, only: set_loads
   use particle_closed_loads, only: balance_loads
   use particle_moving_cell, only: measure_cell, shift_particles
   use step_body_force, only: average_gravity, record_body_force, update_gravity
   use step_conduction, only: conduct_heat
   use step_contact, only: apply_contact, break_bonds, find_later_heat, dissipation_after_remap
   use step_contact_surface, only: find_contact_surfaces
   use step_dual_gradient, only: apply_dual_gradient
   use step_heat_flux, only: add_artificial_heat_flux
   use step_ledger, only: external_work
   use step_mean_strain, only: find_mean_strain
   use step_mean_stress, only: find_mean_stress
   use step_method, only: stress_before
   use step_move_nodes, only: find_remapped_velocities, finish_node_motion, move_nodes, &
      start_node_motion
   use step_node_view, only: gather_parts_t
   use step_nodes_to_particles, only: nodes_to_particles
   use step_normalised_sums, only: find_edge_factors
   use step_particles_to_nodes, only: particles_to_nodes
   use step_retry, only: check_node_displacement
   use step_rigid_bodies, only: describe_bodies, move_bodies, solve_bodies, start_bodies
   use step_sides, only: find_sides
   use step_simulation, only: simulation_t, velocity_field_t
   use step_sort_particles, only: count_particles, sort_particles, split_particles
   use step_tile_rotation, only: smooth_tile_rotation
   use step_time_step, only: finish_step
   use step_velocity_remap, only: remap_momentum
   use step_wall_contact, only: find_reached_walls
   implicit none
   private

   public :: advance

contains

   !> Advance the simulation by one time step. The particles are sorted before and after.
   subroutine advance(simulation, dt_preferred, error)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt_preferred           !! Time step, unless nodes move too far [s]
      type(error_t), allocatable, intent(out) :: error
      real(wp) :: dt, began
      integer :: n

      dt = dt_preferred
      began = simulation%clock%time
      associate (space => simulation%space, stores => simulation%stores, &
         fields => simulation%fields, scheme => simulation%scheme, &
         method => simulation%scheme%method, effects => simulation%effects, &
         clock => simulation%clock, machine => simulation%machine, scratch => simulation%scratch)
         if (allocated(effects%exact)) effects%exact%force_time = clock%time
         call find_reached_walls(simulation, dt)
         if (allocated(effects%loads)) call set_loads(effects%loads, &
            clock%time - method%lag(clock%dt), method%kick(clock%dt, dt))
         if (method%smooth_turn) call smooth_tile_rotation(space, stores, effects, machine)
         if (allocated(effects%contact)) call find_sides(space, stores, fields, method, &
            machine, scratch)
         if (method%strains_first()) call strain_before(simulation, dt)
         if (allocated(effects%loads)) call balance_loads(machine%communicator, space%grid, &
            space%tiles%coordinate, stores, effects%loads)
         do n = 1, size(fields)
            call find_forces(simulation, fields(n))
         end do
         call move_all_nodes(simulation, dt, error)
         if (allocated(error)) return
         call set_burn_clock(simulation%materials, clock%time + dt)
         if (allocated(space%cell)) call space%cell%prepare(dt)
         if (allocated(effects%conduction)) call conduct_heat(space, simulation%materials, stores, &
            fields, scheme, effects%conduction, machine, scratch, dt)
         if (method%heat_flux > 0.0_wp) call add_artificial_heat_flux(simulation, dt)
         do n = 1, size(fields)
            call give_to_particles(simulation, fields(n), gather_parts_t(work=scheme%works, &
               motion=.true., strain=method%stress /= stress_before), dt)
         end do
         call move_bodies(simulation, dt)
         if (allocated(space%rigid)) call describe_bodies(space%rigid, simulation%balance%ledger)
         ! time, gravity and counters at the end of the step
         clock%updates = clock%updates + count_particles(stores)
         clock%time = clock%time + dt
         clock%step = clock%step + 1
         clock%dt = dt
         call update_gravity(effects, clock)
         if (allocated(space%cell)) call space%cell%complete(clock%time)
         call finish_step(simulation, began, error)
         if (allocated(error)) return
         if (allocated(method%splitting)) call split_particles(simulation)
         call sort_particles(simulation, began)
         if (allocated(space%cell)) call deform_cell(simulation)
      end associate
   end subroutine advance

   !> The end of a step of a cell that deforms: particles are wrapped to the mesh of the equivalent
   !! edges, and the stress of the cell gives the next velocity gradient. Collective.
   subroutine deform_cell(simulation)
      type(simulation_t), intent(inout) :: simulation
      real(wp) :: work

      associate (cell => simulation%space%cell, clock => simulation%clock, &
         ledger => simulation%balance%ledger, communicator => simulation%machine%communicator)
         if (any(abs(cell%steps) > 0.0_wp)) then
            call shift_particles(simulation%space%grid, simulation%space%boundary, &
               simulation%space%tiles, cell, simulation%stores)
            call sort_particles(simulation)
         end if
         call measure_cell(communicator, simulation%stores, cell)
         work = cell%step_work(cell%box%gradient, clock%kick)
         cell%work = cell%work + work
         if (communicator%rank == 0) call ledger%sums(external_work)%add(work)
         ! the momentum error is relative to the momentum of the uniform flow at the distance of one
         ! edge
         ledger%momentum_scale = max(ledger%momentum_scale, &
            cell%mass*norm2(cell%box%gradient)*maxval(cell%mesh))
         call cell%steer(clock%dt_next)
         clock%dt_next = min(clock%dt_next, cell%longest_step(clock%guard%bounds%strain_max))
      end associate
   end subroutine deform_cell

   !> Strain the particles with the node velocities before the forces act. Each velocity field has
   !! separate velocities: after contact bodies do not approach each other.
   subroutine strain_before(simulation, dt)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: moved
      integer :: n

      associate (clock => simulation%clock, method => simulation%scheme%method)
         ! time for which positions have moved already with the velocity before the step
         moved = merge(clock%dt, dt, method%leapfrog)
         if (.not. moved > 0.0_wp) return
         call set_burn_clock(simulation%materials, clock%time + merge(0.0_wp, dt, method%leapfrog))
      end associate
      ! particles at a crack use the nodes of both of its sides
      do n = 1, size(simulation%fields)
         call find_forces(simulation, simulation%fields(n))
         call move_nodes(simulation, simulation%fields(n)%nodes, 0.0_wp)
      end do
      do n = 1, size(simulation%fields)
         call give_to_particles(simulation, simulation%fields(n), gather_parts_t(strain=.true.), &
            moved)
      end do
   end subroutine strain_before

   !> Nodes to particles, with the strain that belongs to the force.
   subroutine give_to_particles(simulation, field, parts, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      real(wp), intent(in) :: dt                     !! Time step [s]

      if (simulation%scheme%method%controlled() .and. (parts%strain .or. parts%work)) &
         call find_mean_strain(simulation, field, parts)
      call nodes_to_particles(simulation, field, parts, dt)
   end subroutine give_to_particles

   !> Set the time of explosives to that of the next stress update.
   subroutine set_burn_clock(materials, time)
      type(material_t), intent(inout) :: materials(:)
      real(wp), intent(in) :: time                   !! [s]
      integer :: n

      do n = 1, size(materials)
         if (allocated(materials(n)%burn)) materials(n)%burn%time = time
      end do
   end subroutine set_burn_clock

   !> Particles to nodes: mass, momentum and force, with the stress of the dual gradient.
   subroutine find_forces(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field

      associate (space => simulation%space, stores => simulation%stores, &
         scheme => simulation%scheme, method => simulation%scheme%method, &
         machine => simulation%machine, scratch => simulation%scratch)
         if (method%controlled()) call find_mean_stress(space, stores, scheme, machine, &
            scratch, field)
         if (allocated(scheme%normalises)) call find_edge_factors(space, stores, scheme, &
            simulation%clock, simulation%balance%ledger, machine, scratch, field)
         call particles_to_nodes(space, stores, simulation%fields, scheme, simulation%effects, &
            machine, scratch, field)
         if (method%dual) call apply_dual_gradient(space, simulation%fields, scheme, machine, &
            scratch, field)
      end associate
   end subroutine find_forces

   !> Move the nodes, and find the velocities that strain and move the particles. A step in which
   !! nodes would move too far is repeated with a shorter time.
   subroutine move_all_nodes(simulation, dt, error)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(inout) :: dt                  !! Time step [s]
      type(error_t), allocatable, intent(out) :: error !! If no step is short enough
      logical :: again
      integer :: n

      associate (space => simulation%space, fields => simulation%fields, &
         scheme => simulation%scheme, effects => simulation%effects, clock => simulation%clock, &
         machine => simulation%machine)
         do
            clock%kick = scheme%method%kick(clock%dt, dt)
            call average_gravity(scheme%method, effects, clock)
            call start_bodies(simulation)
            call solve_bodies(simulation, clock%kick)
            if (allocated(effects%contact)) then
               call move_in_contact(simulation, clock%kick)
            else
               call move_nodes(simulation, fields(1)%nodes, clock%kick, dt)
            end if
            do n = 1, size(fields)
               call remap_velocities(simulation, fields(n), clock%kick)
            end do
            if (allocated(effects%contact) .and. dissipation_after_remap(scheme)) &
               call find_later_heat(space, fields, effects%contact, machine)
            call check_node_displacement(simulation, dt, again, error)
            if (allocated(error)) return
            if (.not. again) exit
         end do
         if (allocated(effects%exact)) call record_body_force(space, simulation%stores, scheme, &
            effects, machine, simulation%scratch, fields(1), clock%kick)
      end associate
   end subroutine move_all_nodes

   !> Move the nodes of all velocity fields, with contact forces between their bodies.
   subroutine move_in_contact(simulation, dt)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      integer :: n

      associate (space => simulation%space, fields => simulation%fields, &
         scheme => simulation%scheme, contact => simulation%effects%contact, &
         machine => simulation%machine, scratch => simulation%scratch)
         do n = 1, size(fields)
            call start_node_motion(simulation, fields(n)%nodes, dt)
         end do
         call find_contact_surfaces(simulation)
         call apply_contact(space, fields, scheme, contact, simulation%balance%ledger, &
            machine, scratch, dt)
         if (contact%bonded) call break_bonds(space, simulation%stores, fields, scheme%method, &
            contact, machine, scratch)
         do n = 1, size(fields)
            call finish_node_motion(space, scheme, machine, scratch, fields(n)%nodes, dt)
         end do
      end associate
   end subroutine move_in_contact

   !> Map the velocities of the particles once more, if the strain uses them (MUSL).
   subroutine remap_velocities(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]

      associate (space => simulation%space, stores => simulation%stores, &
         scheme => simulation%scheme, method => simulation%scheme%method, &
         machine => simulation%machine, scratch => simulation%scratch)
         if (.not. method%remaps()) return
         call remap_momentum(space, stores, scheme, machine, scratch, field, dt)
         call find_remapped_velocities(space, scheme, simulation%effects, simulation%clock, &
            machine, scratch, field%nodes)
      end associate
   end subroutine remap_velocities
end module step_advance
