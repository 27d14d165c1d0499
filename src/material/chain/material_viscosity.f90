! SPDX-License-Identifier: BSD-3-Clause
!> Artificial viscosity of shocks, after von Neumann, Richtmyer and Landshoff.
module material_viscosity
   use base_kinds, only: wp
   implicit none
   private

   public :: add_viscous_pressure, viscosity_t, find_viscous_work

   !> Artificial viscosity of a material.
   type :: viscosity_t
      real(wp) :: linear = 0.06_wp                   !! Coefficient of the wave speed [1]
      real(wp) :: quadratic = 4.0_wp                 !! Coefficient of the rate [1]
      logical :: limited = .false.                   !! Is the jump given, or all compression?
   end type viscosity_t

contains

   !> Work of the viscous pressure that was part of the force of the step, so that it balances the
   !! work that the force did. It can be negative for the one step in which compression ends.
   !! Equation (L.4) of doc/theory/ledger.md.
   pure subroutine find_viscous_work(first, last, viscous_pressure, old_volume, dilatation, &
      viscous_work)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: viscous_pressure(:) !! Part of the force (store) [Pa]
      real(wp), contiguous, intent(in) :: old_volume(:)       !! Before the step (range) [m3]
      real(wp), contiguous, intent(in) :: dilatation(:)       !! Trace of strain (range) [1]
      real(wp), contiguous, intent(inout) :: viscous_work(:)  !! (range) [J]
      integer :: i

      do concurrent (i=1:last - first + 1)
         viscous_work(i) = -viscous_pressure(first - 1 + i)*dilatation(i)*old_volume(i)
      end do
   end subroutine find_viscous_work

   !> Viscous pressure q = rho h D (q2 h D + q1 c) where the rate of compression D is positive. D is
   !! that of the strain, or of its remainder after (V.2) of doc/theory/viscosity.md.
   !!
   !! The wave speed on return limits the time step to spacing/wave_speed. For the highest mode of
   !! a row of cells, frequency w = 2 c/h, the viscosity is a damping ratio Q/c with
   !! Q = q1 c + 2 q2 h D, the derivative of q to D. Explicit steps with a force that lags by
   !! half a step are stable up to 2/w (sqrt(1 + (Q/c)**2) - Q/c) = h/(Q + sqrt(Q**2 + c**2)).
   !! Equation (M.22) of doc/theory/method.md. Equation (S.2) of doc/theory/time_step.md.
   pure subroutine add_viscous_pressure(first, last, viscosity, rate, mass, volume, jump, &
      viscous_pressure, pressure, wave_speed)
      integer, intent(in) :: first, last             !! Particles of the range
      type(viscosity_t), intent(in) :: viscosity     !! Coefficients
      real(wp), intent(in) :: rate                   !! Cell size h over time step [m/s]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! After the step (store) [m3]
      real(wp), contiguous, intent(in) :: jump(:)    !! Trace of strain resisted (range) [1]
      real(wp), contiguous, intent(inout) :: viscous_pressure(:) !! After the step (store) [Pa]
      real(wp), contiguous, intent(inout) :: pressure(:)         !! Plus q on return (range) [Pa]
      real(wp), contiguous, intent(inout) :: wave_speed(:) !! Square in, speed out (range) [m/s]
      real(wp) :: sound, damping
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         sound = sqrt(wave_speed(i))
         damping = max(-jump(i), 0.0_wp)*rate
         viscous_pressure(k) = mass(k)/volume(k)*damping &
            *(viscosity%quadratic*damping + viscosity%linear*sound)
         pressure(i) = pressure(i) + viscous_pressure(k)
         damping = merge(viscosity%linear*sound + 2.0_wp*viscosity%quadratic*damping, 0.0_wp, &
            damping > 0.0_wp)
         wave_speed(i) = damping + sqrt(damping**2 + wave_speed(i))
      end do
   end subroutine add_viscous_pressure
end module material_viscosity
