! SPDX-License-Identifier: BSD-3-Clause
!> Artificial viscosity of shocks, after von Neumann, Richtmyer and Landshoff.
module material_viscosity
   use base_kinds, only: wp
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: add_viscous_pressure, viscosity_t

   !> Artificial viscosity of a material.
   type :: viscosity_t
      real(wp) :: linear = 0.06_wp                   !! Coefficient of the wave speed [1]
      real(wp) :: quadratic = 4.0_wp                 !! Coefficient of the rate [1]
      logical :: limited = .false.                   !! Is the jump given, or all compression?
   end type viscosity_t

contains

   !> Viscous pressure q = rho h D (q2 h D + q1 c) where the rate of compression D is positive. D is
   !! that of the strain, or of its remainder after (V.2) of doc/theory/viscosity.md.
   !!
   !! The wave speed on return limits the time step to spacing/wave_speed. For the highest mode of
   !! a row of cells, frequency w = 2 c/h, the viscosity is a damping ratio Q/c with
   !! Q = q1 c + 2 q2 h D, the derivative of q to D. Explicit steps with a force that lags by
   !! half a step are stable up to 2/w (sqrt(1 + (Q/c)**2) - Q/c) = h/(Q + sqrt(Q**2 + c**2)).
   !! Equation (M.22) of doc/theory/method.md. Equation (S.2) of doc/theory/time_step.md.
   pure subroutine add_viscous_pressure(viscosity, rate, jump, state, deformation, first, last)
      type(viscosity_t), intent(in) :: viscosity           !! Coefficients
      real(wp), intent(in) :: rate                         !! Cell size h over time step [m/s]
      real(wp), contiguous, intent(in) :: jump(:)          !! Trace of strain resisted (range) [1]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Wave speed: its square in
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: sound, damping
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         sound = sqrt(deformation%wave_speed(i))
         damping = max(-jump(i), 0.0_wp)*rate
         state%viscous_pressure(k) = state%mass(k)/state%volume(k)*damping &
            *(viscosity%quadratic*damping + viscosity%linear*sound)
         deformation%pressure(i) = deformation%pressure(i) + state%viscous_pressure(k)
         damping = merge(viscosity%linear*sound + 2.0_wp*viscosity%quadratic*damping, 0.0_wp, &
            damping > 0.0_wp)
         deformation%wave_speed(i) = damping + sqrt(damping**2 + deformation%wave_speed(i))
      end do
   end subroutine add_viscous_pressure
end module material_viscosity
