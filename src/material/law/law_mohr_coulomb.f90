! SPDX-License-Identifier: BSD-3-Clause
!> Material with friction and cohesion after Mohr and Coulomb: on no plane is the shear above c +
!! tan(phi) times the pressure on it. In principal stresses, s1 the greatest tension, (s1 - s3) +
!! (s1 + s3) sin(phi) is not above 2 c cos(phi).
!!
!! Flow follows the same surface with the angle of dilation in place of that of friction. Equation
!! (Y.26) of doc/theory/strength.md.
module law_mohr_coulomb
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use material_effects, only: effects_t
   use material_friction, only: add_dilation, add_dilation_pressure, angles_t, &
      frictional_t, read_angles
   use material_law, only: equivalent_stress
   use material_principal, only: compose, principal
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_mohr_coulomb_t

   !> Law of Mohr and Coulomb.
   type, extends(frictional_t) :: law_mohr_coulomb_t
      real(wp) :: friction = 0.0_wp                  !! Sine of the angle of friction [1]
      real(wp) :: dilation = 0.0_wp                  !! Sine of the angle of dilation [1]
      real(wp) :: strength = 0.0_wp                  !! 2 c cos(phi) [Pa]
   contains
      procedure :: read => mohr_coulomb_read         !! Reads its keys
      procedure :: set => mohr_coulomb_set           !! Surface from the angles
      procedure :: update => mohr_coulomb_update     !! Return to plane, edge or apex
   end type law_mohr_coulomb_t

contains

   !> Read the keys of the law, which those of Drucker and Prager declare.
   pure subroutine mohr_coulomb_read(self, group, effects)
      class(law_mohr_coulomb_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects
      type(angles_t) :: angles

      call read_angles(group, angles)
      call self%set(angles)
   end subroutine mohr_coulomb_read

   !> Yield surface of the angles. All frictional work becomes heat.
   pure subroutine mohr_coulomb_set(self, angles)
      class(law_mohr_coulomb_t), intent(inout) :: self
      type(angles_t), intent(in) :: angles

      self%friction = sin(angles%friction)
      self%dilation = sin(angles%dilation)
      self%strength = 2.0_wp*angles%cohesion*cos(angles%friction)
      self%apex = -huge(1.0_wp)
      if (self%friction > 0.0_wp) self%apex = -0.5_wp*self%strength/self%friction
      self%dilates = self%dilation > 0.0_wp
      self%heat_share = 1.0_wp
   end subroutine mohr_coulomb_set

   !> Return to the surface. States inside the inscribed Drucker-Prager cone do not flow; the others
   !! are treated one at a time, because they need their principal stresses.
   pure subroutine mohr_coulomb_update(self, state, deformation, first, last, dt)
      class(law_mohr_coulomb_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: s(6), strain(6), pressure, bulk, inside, inner, offset
      integer :: i, k

      call add_dilation_pressure(state, deformation, first, last)
      call equivalent_stress(state, deformation, first, last)
      inner = 1.0_wp/sqrt(1.0_wp + self%friction**2/3.0_wp)
      offset = 0.5_wp*sqrt(3.0_wp)*self%strength*inner
      inner = sqrt(3.0_wp)*self%friction*inner
      do i = 1, last - first + 1
         k = first - 1 + i
         inside = inner*deformation%pressure(i) + offset - deformation%plastic_increment(i)
         deformation%plastic_increment(i) = 0.0_wp
         deformation%strength%dilation(i) = 0.0_wp
         if (inside >= 0.0_wp) cycle
         s = state%stress(k, :)
         strain = [deformation%gradient(i, [1, 5, 9]), 0.5_wp*(deformation%gradient(i, [2, 6, 3]) &
            + deformation%gradient(i, [4, 8, 7]))]
         pressure = deformation%pressure(i)
         bulk = state%mass(k)/state%volume(k)*deformation%strength%tangent(i)
         call flow(self, bulk, strain, s, pressure, deformation%plastic_increment(i), &
            deformation%plastic_work(i), deformation%strength%dilation(i))
         state%stress(k, :) = s
         deformation%pressure(i) = pressure
         deformation%plastic_work(i) = deformation%plastic_work(i)*state%volume(k)
      end do
      call add_dilation(state, deformation, first, last)
   end subroutine mohr_coulomb_update

   !> One particle: deviator and pressure after the flow, and the plastic work.
   !!
   !! The work is that of the mean of the stresses before and after the step on the plastic strain,
   !! (s + s') : (s* - s')/(4 G) - x (p + p')/2, with s = s* - 2 G e but for the rotation, and with
   !! p = p* + K tr(e).
   pure subroutine flow(law, bulk, strain, s, pressure, increment, work, dilation)
      type(law_mohr_coulomb_t), intent(in) :: law    !! Constants
      real(wp), intent(in) :: bulk                   !! Tangent bulk modulus [Pa]
      real(wp), intent(in) :: strain(6)              !! Increment of strain [1]
      real(wp), intent(inout) :: s(6)                !! Deviator [Pa]
      real(wp), intent(inout) :: pressure            !! [Pa]
      real(wp), intent(inout) :: increment           !! Equivalent plastic strain, 0 on entry [1]
      real(wp), intent(inout) :: work                !! Plastic work, 0 on entry [J/m3]
      real(wp), intent(inout) :: dilation            !! Volume gained, 0 on entry [1]
      real(wp) :: trial(3), values(3), axes(3, 3), both(6), change(6), multipliers, before

      call principal(s, trial, axes)
      if (excess(law, trial(1), trial(3), pressure) <= 0.0_wp) return
      before = max(law%apex, pressure + bulk*(strain(1) + strain(2) + strain(3)))
      call return_principal(law, bulk, pressure, trial, values, multipliers)
      dilation = 2.0_wp*law%dilation*multipliers
      pressure = pressure + bulk*dilation
      if (pressure < law%apex) then
         dilation = 0.0_wp
         pressure = law%apex
         values = 0.0_wp
      else
         call shrink_deviator(law, pressure, values)
      end if
      increment = sqrt(sum((trial - values)**2)/6.0_wp)/law%shear
      both = s - 2.0_wp*law%shear*strain
      s = compose(values, axes)
      both = both + s
      change = compose(trial - values, axes)
      work = max(0.0_wp, (sum(both(1:3)*change(1:3)) + 2.0_wp*sum(both(4:6)*change(4:6))) &
         /(4.0_wp*law%shear) - 0.5_wp*(before + pressure)*dilation)
   end subroutine flow

   !> Excess of two principal values of a deviator over the yield surface [Pa].
   pure real(wp) function excess(law, greatest, least, pressure) result(outside)
      type(law_mohr_coulomb_t), intent(in) :: law    !! Constants
      real(wp), intent(in) :: greatest               !! Greatest value of the deviator [Pa]
      real(wp), intent(in) :: least                  !! Least value of the deviator [Pa]
      real(wp), intent(in) :: pressure               !! [Pa]

      outside = (greatest - least) + (greatest + least)*law%friction &
         - (2.0_wp*pressure*law%friction + law%strength)
   end function excess

   !> Deviator after the return to the plane of the greatest and the least stress, or, where that
   !! would change their order, to the edge with the plane next to it (E. A. de Souza Neto, D.
   !! Peric, D. R. J. Owen, "Computational methods for plasticity", 2008, section 8.2; here without
   !! hardening and so in closed form). Equation (Y.27).
   pure subroutine return_principal(law, bulk, pressure, trial, values, multipliers)
      type(law_mohr_coulomb_t), intent(in) :: law    !! Constants
      real(wp), intent(in) :: bulk                   !! Tangent bulk modulus [Pa]
      real(wp), intent(in) :: pressure               !! Trial [Pa]
      real(wp), intent(in) :: trial(3)               !! Trial deviator in falling order [Pa]
      real(wp), intent(out) :: values(3)             !! Deviator [Pa]
      real(wp), intent(out) :: multipliers           !! Sum of the plastic multipliers [1]
      real(wp) :: a, b, main, side, one, other, up, down, middle

      associate (g => law%shear, f => law%friction, d => law%dilation)
         a = 4.0_wp*g*(1.0_wp + f*d/3.0_wp) + 4.0_wp*bulk*f*d
         main = excess(law, trial(1), trial(3), pressure)
         multipliers = main/a
         up = 2.0_wp*g*(1.0_wp - d/3.0_wp)
         down = 2.0_wp*g*(1.0_wp + d/3.0_wp)
         middle = 4.0_wp/3.0_wp*g*d
         values = trial + multipliers*[-down, middle, up]
         if (values(1) >= values(2) .and. values(2) >= values(3)) return
         if ((1.0_wp - d)*trial(1) - 2.0_wp*trial(2) + (1.0_wp + d)*trial(3) > 0.0_wp) then
            b = 2.0_wp*g*(1.0_wp + f + d - f*d/3.0_wp) + 4.0_wp*bulk*f*d
            side = excess(law, trial(1), trial(2), pressure)
            one = (a*main - b*side)/(a**2 - b**2)
            other = (a*side - b*main)/(a**2 - b**2)
            values = trial + one*[-down, middle, up] + other*[-down, up, middle]
         else
            b = 2.0_wp*g*(1.0_wp - f - d - f*d/3.0_wp) + 4.0_wp*bulk*f*d
            side = excess(law, trial(2), trial(3), pressure)
            one = (a*main - b*side)/(a**2 - b**2)
            other = (a*side - b*main)/(a**2 - b**2)
            values = trial + one*[-down, middle, up] + other*[middle, -down, up]
         end if
         multipliers = max(0.0_wp, one + other)
      end associate
   end subroutine return_principal

   !> Shrink a deviator that is outside the surface due to round-off.
   pure subroutine shrink_deviator(law, pressure, values)
      type(law_mohr_coulomb_t), intent(in) :: law    !! Constants
      real(wp), intent(in) :: pressure               !! [Pa]
      real(wp), intent(inout) :: values(3)           !! Principal values of the deviator [Pa]
      real(wp) :: limit, taken

      limit = max(0.0_wp, 2.0_wp*pressure*law%friction + law%strength)
      taken = (1.0_wp + law%friction)*maxval(values) - (1.0_wp - law%friction)*minval(values)
      if (taken > limit) values = values*(limit/taken)
   end subroutine shrink_deviator
end module law_mohr_coulomb
