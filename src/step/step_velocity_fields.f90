! SPDX-License-Identifier: BSD-3-Clause
!> The way of a step from particles to nodes and back: once without contact, and for each velocity
!! field with contact, whose bodies push each other in between.
module step_velocity_fields
   use base_error, only: error_t
   use base_kinds, only: wp
   use step_contact, only: break_bonds, touch_bodies
   use step_contact_surface, only: find_surfaces
   use step_dual_gradient, only: dual_fields
   use step_exact_force, only: record_body_force
   use step_gravity, only: act_gravity
   use step_mean_stress, only: find_star
   use step_move_nodes, only: finish_nodes, move_nodes, remap_nodes, start_nodes, strain_nodes
   use step_nodes_to_particles, only: gather_parts_t, nodes_to_particles
   use step_normalised_sums, only: find_factors
   use step_particles_to_nodes, only: particles_to_nodes
   use step_retry, only: judge_nodes
   use step_simulation, only: simulation_t
   use step_stress_difference, only: find_difference
   use step_velocity_remap, only: filter_nodes, scatter_again
   implicit none
   private

   public :: gather_all, push_nodes, strain_before

contains

   !> Strain the particles with the node velocities before the forces act. Each field has its own:
   !! bodies that touched have no approach left, but for what their particles keep.
   subroutine strain_before(simulation, moved)
      type(simulation_t), intent(inout) :: simulation !! The run
      real(wp), intent(in) :: moved                  !! Time for which they have moved already [s]
      integer :: field

      if (.not. allocated(simulation%contact)) then
         call strain_field(simulation, moved)
         return
      end if
      do field = 1, size(simulation%contact%field)
         call simulation%take_field(field)
         call strain_field(simulation, moved)
         call simulation%return_field(field)
      end do
   end subroutine strain_before

   !> One velocity field, or all particles.
   subroutine strain_field(simulation, moved)
      type(simulation_t), intent(inout) :: simulation !! The run
      real(wp), intent(in) :: moved                  !! Time for which they have moved already [s]

      call find_force(simulation)
      call move_nodes(simulation, 0.0_wp)
      call nodes_to_particles(simulation, gather_parts_t(strain=.true.), moved)
   end subroutine strain_field

   !> Forces, accelerations of the nodes, and what strains and moves the particles. Where nodes
   !! would go too far the step becomes shorter; with contact it does not, as bonds may have broken.
   subroutine push_nodes(simulation, dt, error)
      type(simulation_t), intent(inout) :: simulation !! The run
      real(wp), intent(inout) :: dt                  !! Time step [s]
      type(error_t), allocatable, intent(out) :: error !! No step is short enough
      logical :: again

      if (allocated(simulation%contact)) then
         simulation%kick = simulation%method%kick(simulation%dt, dt)
         call act_gravity(simulation)
         call push_fields(simulation, simulation%kick)
         return
      end if
      call find_force(simulation)
      do
         simulation%kick = simulation%method%kick(simulation%dt, dt)
         call act_gravity(simulation)
         call move_nodes(simulation, simulation%kick, dt)
         if (simulation%method%transfer%sweeps() > 0) &
            call filter_nodes(simulation, simulation%kick)
         if (simulation%method%remaps()) call map_again(simulation)
         call judge_nodes(simulation, dt, again, error)
         if (allocated(error)) return
         if (.not. again) exit
      end do
      if (allocated(simulation%exact)) call record_body_force(simulation, simulation%kick)
   end subroutine push_nodes

   !> The same for all velocity fields, whose bodies push each other.
   subroutine push_fields(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run with contact
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: field

      call find_velocities(simulation, dt)
      call touch_bodies(simulation, dt)
      if (simulation%contact%bonded) call break_bonds(simulation)
      call finish_velocities(simulation, dt)
      if (.not. simulation%method%remaps()) return
      do field = 1, size(simulation%contact%field)
         call simulation%take_field(field)
         call map_again(simulation)
         call simulation%return_field(field)
      end do
   end subroutine push_fields

   !> Velocities of the nodes from the new ones of the particles.
   subroutine map_again(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run, perhaps one velocity field of it

      call scatter_again(simulation, simulation%kick)
      call remap_nodes(simulation)
   end subroutine map_again

   !> Velocities and accelerations of all fields as if they did not touch, and where they do.
   subroutine find_velocities(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run with contact
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: field

      do field = 1, size(simulation%contact%field)
         call simulation%take_field(field)
         call find_force(simulation)
         call start_nodes(simulation, dt)
         call simulation%return_field(field)
      end do
      call find_surfaces(simulation)
   end subroutine find_velocities

   !> Books, gradients and filtered velocities of all fields after they touched.
   subroutine finish_velocities(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run with contact
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: field

      do field = 1, size(simulation%contact%field)
         call simulation%take_field(field)
         call finish_nodes(simulation, dt)
         if (dt > 0.0_wp .and. simulation%method%transfer%sweeps() > 0) &
            call filter_nodes(simulation, dt)
         call simulation%return_field(field)
      end do
   end subroutine finish_velocities

   !> Give the particles of all fields what their nodes hold.
   subroutine gather_all(simulation, parts, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(gather_parts_t), intent(in) :: parts      !! What is to be done
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer :: field

      if (.not. allocated(simulation%contact)) then
         call nodes_to_particles(simulation, parts, dt)
         return
      end if
      do field = 1, size(simulation%contact%field)
         call simulation%take_field(field)
         call nodes_to_particles(simulation, parts, dt)
         call simulation%return_field(field)
      end do
   end subroutine gather_all

   !> Mass, momentum and force of the nodes from the particles.
   subroutine find_force(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run, perhaps one velocity field of it

      if (simulation%method%controlled()) call find_star(simulation)
      if (allocated(simulation%normalises)) call find_factors(simulation)
      call particles_to_nodes(simulation)
      if (simulation%method%dual) call dual_fields(simulation)
      if (simulation%method%differing()) call find_difference(simulation)
   end subroutine find_force
end module step_velocity_fields
