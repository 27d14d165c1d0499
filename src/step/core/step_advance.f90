! SPDX-License-Identifier: BSD-3-Clause
!> One step of time.
module step_advance
   use base_error, only: error_t
   use base_kinds, only: wp
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
   use step_mean_stress, only: find_mean_stress
   use step_method, only: stress_before
   use step_move_nodes, only: find_remapped_velocities, finish_node_motion, move_nodes, &
      start_node_motion
   use step_node_view, only: gather_parts_t
   use step_nodes_to_particles, only: nodes_to_particles
   use step_normalised_sums, only: find_edge_factors
   use step_particles_to_nodes, only: particles_to_nodes
   use step_retry, only: check_node_displacement
   use step_sides, only: find_sides
   use step_simulation, only: simulation_t, velocity_field_t
   use step_sort_particles, only: count_particles, sort_particles, split_particles
   use step_stress_difference, only: find_stress_difference
   use step_tile_rotation, only: smooth_tile_rotation
   use step_time_step, only: finish_step
   use step_velocity_remap, only: filter_velocities, remap_momentum
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
      if (allocated(simulation%effects%exact)) simulation%effects%exact%force_time = &
         simulation%clock%time
      if (allocated(simulation%effects%loads)) call set_loads(simulation%effects%loads, &
         simulation%clock%time - simulation%scheme%method%lag(simulation%clock%dt), &
         simulation%scheme%method%kick(simulation%clock%dt, dt))
      if (simulation%scheme%method%smooth_turn) call smooth_tile_rotation(simulation)
      if (allocated(simulation%effects%contact)) call find_sides(simulation)
      if (simulation%scheme%method%strains_first()) call strain_before(simulation, dt)
      if (allocated(simulation%effects%loads)) call balance_loads( &
         simulation%machine%communicator, simulation%space%grid, &
         simulation%space%tiles%coordinate, simulation%stores, simulation%effects%loads)
      do n = 1, size(simulation%fields)
         call find_forces(simulation, simulation%fields(n))
      end do
      call move_all_nodes(simulation, dt, error)
      if (allocated(error)) return
      call set_burn_clock(simulation, simulation%clock%time + dt)
      if (allocated(simulation%space%cell)) call simulation%space%cell%prepare(dt)
      if (allocated(simulation%effects%conduction)) call conduct_heat(simulation, dt)
      if (simulation%scheme%method%heat_flux > 0.0_wp) call add_artificial_heat_flux(simulation, dt)
      do n = 1, size(simulation%fields)
         call nodes_to_particles(simulation, simulation%fields(n), gather_parts_t( &
            work=simulation%scheme%works, motion=.true., &
            strain=simulation%scheme%method%stress /= stress_before), dt)
      end do
      call advance_clock(simulation, dt)
      if (allocated(simulation%space%cell)) call simulation%space%cell%complete( &
         simulation%clock%time)
      call finish_step(simulation, error)
      if (allocated(error)) return
      if (allocated(simulation%scheme%method%splitting)) call split_particles(simulation)
      call sort_particles(simulation, began)
      if (allocated(simulation%space%cell)) call deform_cell(simulation)
   end subroutine advance

   !> The end of a step of a cell that deforms: particles are wrapped to the mesh of the equivalent
   !! edges, and the stress of the cell gives the next velocity gradient. Collective.
   subroutine deform_cell(simulation)
      type(simulation_t), intent(inout) :: simulation
      real(wp) :: work

      associate (cell => simulation%space%cell)
         if (any(abs(cell%steps) > 0.0_wp)) then
            call shift_particles(simulation%space%grid, simulation%space%boundary, &
               simulation%space%tiles, cell, simulation%stores)
            call sort_particles(simulation)
         end if
         call measure_cell(simulation%machine%communicator, simulation%stores, cell)
         work = cell%step_work(cell%box%gradient, simulation%clock%kick)
         cell%work = cell%work + work
         if (simulation%machine%communicator%rank == 0) &
            call simulation%balance%ledger%sums(external_work)%add(work)
         ! the momentum error is relative to the momentum of the uniform flow at the distance of one
         ! edge
         simulation%balance%ledger%momentum_scale = max(simulation%balance%ledger%momentum_scale, &
            cell%mass*norm2(cell%box%gradient)*maxval(cell%mesh))
         call cell%steer(simulation%clock%dt_next)
         simulation%clock%dt_next = min(simulation%clock%dt_next, &
            cell%longest_step(simulation%clock%guard%bounds%strain_max))
      end associate
   end subroutine deform_cell

   !> Strain the particles with the node velocities before the forces act. Each velocity field has
   !! separate velocities: after contact bodies do not approach each other.
   subroutine strain_before(simulation, dt)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: moved
      integer :: n

      ! time for which positions have moved already with the velocity before the step
      moved = merge(simulation%clock%dt, dt, simulation%scheme%method%leapfrog)
      if (.not. moved > 0.0_wp) return
      call set_burn_clock(simulation, simulation%clock%time + merge(0.0_wp, dt, &
         simulation%scheme%method%leapfrog))
      do n = 1, size(simulation%fields)
         call find_forces(simulation, simulation%fields(n))
         call move_nodes(simulation, simulation%fields(n), 0.0_wp)
         call nodes_to_particles(simulation, simulation%fields(n), gather_parts_t(strain=.true.), &
            moved)
      end do
   end subroutine strain_before

   !> Set the time of explosives to that of the next stress update.
   subroutine set_burn_clock(simulation, time)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: time                   !! [s]
      integer :: n

      do n = 1, size(simulation%materials)
         if (allocated(simulation%materials(n)%burn)) simulation%materials(n)%burn%time = time
      end do
   end subroutine set_burn_clock

   !> Particles to nodes: mass, momentum and force, with the stress of the dual gradient.
   subroutine find_forces(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field

      if (simulation%scheme%method%controlled()) call find_mean_stress(simulation, field)
      if (allocated(simulation%scheme%normalises)) call find_edge_factors(simulation, field)
      call particles_to_nodes(simulation, field)
      if (simulation%scheme%method%dual) call apply_dual_gradient(simulation, field)
      if (simulation%scheme%method%differing()) call find_stress_difference(simulation, field)
   end subroutine find_forces

   !> Move the nodes, and find the velocities that strain and move the particles. A step in which
   !! nodes would move too far is repeated with a shorter time.
   subroutine move_all_nodes(simulation, dt, error)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(inout) :: dt                  !! Time step [s]
      type(error_t), allocatable, intent(out) :: error !! If no step is short enough
      logical :: again
      integer :: n

      do
         simulation%clock%kick = simulation%scheme%method%kick(simulation%clock%dt, dt)
         call average_gravity(simulation%scheme, simulation%effects, simulation%clock)
         if (allocated(simulation%effects%contact)) then
            call move_in_contact(simulation, simulation%clock%kick)
         else
            call move_nodes(simulation, simulation%fields(1), simulation%clock%kick, dt)
         end if
         do n = 1, size(simulation%fields)
            call remap_velocities(simulation, simulation%fields(n), simulation%clock%kick)
         end do
         if (allocated(simulation%effects%contact) .and. &
            dissipation_after_remap(simulation%scheme)) &
            call find_later_heat(simulation)
         call check_node_displacement(simulation, dt, again, error)
         if (allocated(error)) return
         if (.not. again) exit
      end do
      if (allocated(simulation%effects%exact)) &
         call record_body_force(simulation, simulation%fields(1), simulation%clock%kick)
   end subroutine move_all_nodes

   !> Move the nodes of all velocity fields, with contact forces between their bodies.
   subroutine move_in_contact(simulation, dt)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      integer :: n

      do n = 1, size(simulation%fields)
         call start_node_motion(simulation, simulation%fields(n), dt)
      end do
      call find_contact_surfaces(simulation)
      call apply_contact(simulation, dt)
      if (simulation%effects%contact%bonded) call break_bonds(simulation)
      do n = 1, size(simulation%fields)
         call finish_node_motion(simulation, simulation%fields(n), dt)
      end do
   end subroutine move_in_contact

   !> Filter the node velocities (XPIC, FMPM), or map those of the particles once more (MUSL).
   subroutine remap_velocities(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]

      if (simulation%scheme%method%transfer%sweeps() > 0) call filter_velocities(simulation, &
         field, dt)
      if (.not. simulation%scheme%method%remaps()) return
      call remap_momentum(simulation, field, dt)
      call find_remapped_velocities(simulation, field)
   end subroutine remap_velocities

   !> Time, gravity and counters at the end of the step.
   subroutine advance_clock(simulation, dt)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt                     !! Time step [s]

      simulation%clock%updates = simulation%clock%updates + count_particles(simulation)
      simulation%clock%time = simulation%clock%time + dt
      simulation%clock%step = simulation%clock%step + 1
      simulation%clock%dt = dt
      call update_gravity(simulation)
   end subroutine advance_clock
end module step_advance
