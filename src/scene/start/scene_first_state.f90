! SPDX-License-Identifier: BSD-3-Clause
!> First state of a simulation: particles of all bodies and the first time step. `program_main`
!! calls it after `scene_setup` and before `run_time_loop`, where no checkpoint is read.
module scene_first_state
   use base_error, only: error_t
   use particle_body, only: body_t
   use scene_burn_times, only: light_explosives
   use scene_exact_start, only: place_exact, strain_exact
   use scene_lithostatic, only: add_weight_stress
   use scene_load, only: mark_particles
   use scene_particles, only: fill_simulation, first_step, spin_bodies, survey_t
   use scene_points_clock, only: continue_clock
   use scene_points_fields, only: read_point_fields
   use scene_regions, only: named_shape_t
   use scene_velocity_formula, only: add_formula_velocities
   use step_body_force, only: update_gravity
   use step_simulation, only: simulation_t
   use step_rigid_bodies, only: describe_bodies
   implicit none
   private

   public :: make_first_state

contains

   !> Create the particles of the bodies in their first state, the first time step and the ledger.
   subroutine make_first_state(simulation, bodies, survey, shapes, error)
      type(simulation_t), intent(inout) :: simulation !! The run, gets particles
      type(body_t), intent(inout) :: bodies(:)       !! The bodies; get their first identities
      type(survey_t), intent(in) :: survey           !! Counts of them
      type(named_shape_t), intent(in) :: shapes(:)
      !> Bodies do not match the exact solution, or a file has become unreadable
      type(error_t), allocatable, intent(out) :: error

      call fill_simulation(simulation, bodies, survey)
      call read_point_fields(simulation, bodies, shapes, error)
      if (allocated(error)) return
      call light_explosives(simulation)
      call spin_bodies(simulation, bodies)
      call add_formula_velocities(simulation, bodies, error)
      if (allocated(error)) return
      call add_weight_stress(simulation, bodies)
      call place_exact(simulation, error)
      if (allocated(error)) return
      call strain_exact(simulation)
      call mark_particles(simulation)
      call first_step(simulation)
      call continue_clock(simulation, bodies, shapes)
      call update_gravity(simulation%effects, simulation%clock)
      if (allocated(simulation%space%rigid)) call describe_bodies(simulation%space%rigid, &
         simulation%balance%ledger)
      call simulation%balance%ledger%balance(simulation%machine%communicator, &
         simulation%space%grid, &
         simulation%stores, simulation%materials, simulation%balance%ledger%start)
   end subroutine make_first_state
end module scene_first_state
