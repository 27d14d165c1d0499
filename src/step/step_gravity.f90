! SPDX-License-Identifier: BSD-3-Clause
!> Gravity, constant or with a table of time (`gravity_table` of &effects).
!!
!! In a step gravity is the mean of the table over the time in which the forces of this step act:
!! the integral of its straight lines, equation (R.4) of doc/theory/rigid.md. So the impulse of a
!! run is that of the table whatever the steps are, and work and impulse are recorded as those of
!! constant gravity. Between steps gravity is that of the present time; nothing is kept for a
!! restart.
module step_gravity
   use base_kinds, only: wp
   use step_simulation, only: clock_t, effects_t, scheme_t, simulation_t
   implicit none
   private

   public :: act_gravity, update_gravity

contains

   !> Set gravity to its mean over the time in which the forces of a step act.
   pure subroutine act_gravity(scheme, effects, clock)
      type(scheme_t), intent(in) :: scheme
      type(effects_t), intent(inout) :: effects
      type(clock_t), intent(in) :: clock
      real(wp) :: from

      if (.not. allocated(effects%shaking)) return
      from = clock%time - scheme%method%lag(clock%dt)
      if (clock%kick > 0.0_wp) &
         effects%gravity = effects%shaking%mean(from, clock%kick)
   end subroutine act_gravity

   !> Set gravity to its value at the present time.
   pure subroutine update_gravity(simulation)
      type(simulation_t), intent(inout) :: simulation

      if (allocated(simulation%effects%shaking)) &
         simulation%effects%gravity = simulation%effects%shaking%velocity(simulation%clock%time)
   end subroutine update_gravity
end module step_gravity
