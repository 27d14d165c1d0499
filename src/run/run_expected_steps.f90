! SPDX-License-Identifier: BSD-3-Clause
!> First time step of a run, and the number of steps of this length.
module run_expected_steps
   use base_kinds, only: int64, wp
   use material_state, only: material_state_t
   use mesh_moving_cell, only: moving_cell_t
   use particle_body, only: body_t
   use run_limits, only: limits_t
   use step_bounds, only: rule_conduction
   use step_simulation, only: simulation_t
   use step_time_step, only: find_stable_step
   implicit none
   private

   public :: expected_steps, find_first_stable_step, find_first_step

contains

   !> Number of steps if all are as long as the first.
   pure real(wp) function expected_steps(simulation, bodies, limits) result(steps)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(limits_t), intent(in) :: limits           !! End of the run
      real(wp), parameter :: countless = 1.0e18_wp   ! fits a 64-bit integer
      character(len=:), allocatable :: cause
      real(wp) :: dt

      call find_first_step(simulation, bodies, limits, dt, cause)
      steps = 0.0_wp
      if (dt > 0.0_wp .and. dt < huge(dt)) steps = min(limits%time_end/dt, countless)
      if (limits%max_steps < huge(1_int64)) steps = min(steps, real(limits%max_steps, wp))
   end function expected_steps

   !> Find the first time step.
   pure subroutine find_first_step(simulation, bodies, limits, dt, cause)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(limits_t), intent(in) :: limits           !! Bounds of the step
      real(wp), intent(out) :: dt                    !! [s]
      !> Limit of the step, empty for the wave speed
      character(len=:), allocatable, intent(out) :: cause

      call find_first_stable_step(simulation, bodies, simulation%scheme%method%cfl, &
         simulation%clock%guard%bounds%strain_max, dt, cause)
      if (limits%dt_fixed > 0.0_wp) then
         dt = limits%dt_fixed
         cause = " (dt_fixed)"
      end if
      dt = min(dt, limits%dt_max)
   end subroutine find_first_step

   !> Stable time step of the first state, as `first_step` of scene_particles finds it from the
   !! particles.
   pure subroutine find_first_stable_step(simulation, bodies, courant, strain, dt, cause)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      real(wp), intent(in) :: courant                !! Courant number
      real(wp), intent(in) :: strain                 !! Greatest strain of a cell in a step [1]
      real(wp), intent(out) :: dt                    !! [s]
      !> Limit of the step, empty for the wave speed
      character(len=:), allocatable, intent(out) :: cause
      type(moving_cell_t) :: cell
      type(material_state_t) :: state
      real(wp) :: densest, fastest, diffusivity, greatest, signal, stable
      integer :: n, rule

      densest = 0.0_wp
      fastest = 0.0_wp
      greatest = 0.0_wp
      diffusivity = 0.0_wp
      do n = 1, size(bodies)
         associate (material => simulation%materials(bodies(n)%store))
            call material%allocate_state(state, 1)
            state%mass = material%density
            state%volume = 1.0_wp
            call material%start(state, 1, 1, bodies(n)%temperature)
            if (bodies(n)%energy > 0.0_wp .and. allocated(state%energy)) &
               state%energy = bodies(n)%energy
            signal = material%signal_speed(state, 1, 1)
            densest = max(densest, material%density)
            greatest = max(greatest, signal)
            fastest = max(fastest, signal + norm2(bodies(n)%velocity))
            if (allocated(material%heat)) diffusivity = max(diffusivity, &
               material%heat%conductivity/(material%density*material%heat%specific_heat))
         end associate
      end do
      call find_stable_step(simulation%space, courant, fastest, diffusivity, dt, rule)
      cause = ""
      if (rule == rule_conduction) cause = " (heat conduction)"
      if (.not. allocated(simulation%space%cell)) return
      ! the mass is only used where a servo holds the stress
      cell = simulation%space%cell
      cell%speed = greatest
      cell%mass = densest*cell%box%volume()
      stable = dt
      call cell%begin(strain, dt)
      if (dt < stable) cause = " (strain of the cell)"
   end subroutine find_first_stable_step
end module run_expected_steps
