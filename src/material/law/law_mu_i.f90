! SPDX-License-Identifier: BSD-3-Clause
!> Grains that flow (P. Jop, Y. Forterre, O. Pouliquen, Nature 441 (2006) 727): the shear stress
!! is the cohesion and mu(I) times the pressure with mu = mu_s + (mu_2 - mu_s)/(1 + I0/I), where the
!! inertial number I = rate d sqrt(rho_s/p) has the diameter d and the density rho_s of a grain.
!!
!! Below mu_s the grains are an elastic solid, and without pressure and cohesion they support
!! nothing (S. Dunatunga, K. Kamrin, J. Fluid Mech. 779 (2015) 483). Equation (Y.28) of
!! doc/theory/strength.md.
module law_mu_i
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t, in_order
   use material_eos, only: eos_t
   use material_friction, only: frictional_t
   use material_law, only: equivalent_stress, strain_trial
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_mu_i_t

   !> Law of mu(I).
   type, extends(frictional_t) :: law_mu_i_t
      real(wp) :: slow = 0.0_wp                      !! mu_s [1]
      real(wp) :: fast = 0.0_wp                      !! mu_2 [1]
      real(wp) :: scale = 0.0_wp !! I0/(d sqrt(rho_s)), rate over root of pressure [1/(s Pa^1/2)]
      real(wp) :: grain = 0.0_wp                     !! d sqrt(rho_s), I over rate/p^1/2 [s Pa^1/2]
      real(wp) :: cohesion = 0.0_wp                  !! Shear strength without pressure [Pa]
   contains
      procedure :: declare => mu_i_declare           !! Declares its keys
      procedure :: fault => mu_i_fault               !! Friction that falls with the rate
      procedure :: read => mu_i_read                 !! Reads its keys
      procedure :: has_grains => mu_i_has_grains     !! It has an inertial number
      procedure :: update => mu_i_update             !! Return to the flow stress
   end type law_mu_i_t

contains

   !> Declare the keys of the law.
   subroutine mu_i_declare(self, schema)
      class(law_mu_i_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = mu_i"

      call schema%real("material", "mu_s", "friction coefficient of slow flow", range="> 0", &
         owner=owner)
      call schema%real("material", "mu_2", "friction coefficient of fast flow", range="> 0", &
         owner=owner)
      call schema%real("material", "mu_i0", &
         "inertial number at which friction is half way between mu_s and mu_2", range="> 0", &
         owner=owner)
      call schema%real("material", "grain_diameter", "grain diameter", unit="m", range="> 0", &
         owner=owner)
      call schema%real("material", "grain_density", "grain density", unit="kg/m3", range="> 0", &
         owner=owner)
      call schema%require("material", "mu_s mu_2 mu_i0 grain_diameter grain_density")
   end subroutine mu_i_declare

   !> Friction must not decrease with the rate.
   pure function mu_i_fault(self, group, eos) result(text)
      class(law_mu_i_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text

      text = ""
      if (.not. in_order(group, "mu_s", "mu_2", equal=.true.)) &
         text = "mu_2 must not be below mu_s [D363]"
   end function mu_i_fault

   !> Read the keys of the law. All frictional work becomes heat.
   pure subroutine mu_i_read(self, group, effects)
      class(law_mu_i_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects
      real(wp) :: diameter, density

      call group%get("mu_s", self%slow)
      call group%get("mu_2", self%fast)
      call group%get("mu_i0", self%scale)
      call group%get("cohesion", self%cohesion)
      call group%get("grain_diameter", diameter)
      call group%get("grain_density", density)
      self%grain = diameter*sqrt(density)
      self%scale = self%scale/self%grain
      if (self%cohesion > 0.0_wp) self%apex = -self%cohesion/self%slow
      self%heat_share = 1.0_wp
   end subroutine mu_i_read

   !> Its grains have an inertial number.
   pure logical function mu_i_has_grains(self) result(has)
      class(law_mu_i_t), intent(in) :: self

      has = .true.
   end function mu_i_has_grains

   !> Return to the flow stress. The shear stress t after the step, t' before the flow, solves both
   !! t' - t = G dt rate and t = c + mu(I) p: with a = G dt I0/d sqrt(p/rho_s) and the strengths l =
   !! c + mu_s p of slow and h = c + mu_2 p of fast flow it is the smaller root of t**2 - (h + t' +
   !! a) t + h t' + l a = 0 (Dunatunga and Kamrin, as above, without c). In tension the friction is
   !! mu_s, up to the apex at p = -c/mu_s. Equation (Y.29).
   pure subroutine mu_i_update(self, state, deformation, first, last, dt)
      class(law_mu_i_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp), parameter :: root = sqrt(3.0_wp)
      real(wp) :: load, trial, tau, delay, half, low, high, scaling, cohesion, fast, slow, apex, &
         shear, scale
      integer :: i, k

      call equivalent_stress(state, deformation, first, last)
      call strain_trial(state, deformation, first, last)
      cohesion = self%cohesion
      fast = self%fast
      slow = self%slow
      apex = self%apex
      shear = self%shear
      scale = self%scale
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%pressure(i) = max(deformation%pressure(i), apex)
         load = max(deformation%pressure(i), 0.0_wp)
         trial = deformation%plastic_increment(i)/root
         low = max(cohesion + slow*deformation%pressure(i), 0.0_wp)
         high = merge(cohesion + fast*load, low, deformation%pressure(i) > 0.0_wp)
         delay = shear*dt*scale*sqrt(load)
         half = 0.5_wp*(high + trial + delay)
         ! The discriminant, as a sum of terms that are not negative where trial is above low.
         tau = sqrt(max(0.0_wp, 0.25_wp*(high - trial)**2 + 0.25_wp*delay**2 &
            + 0.5_wp*delay*(high + trial - 2.0_wp*low)))
         tau = (high*trial + low*delay)/max(half + tau, tiny(1.0_wp))
         tau = merge(trial, min(tau, trial, high), trial <= low)
         deformation%plastic_increment(i) = (trial - tau)/(root*shear)
         scaling = tau/max(trial, tiny(1.0_wp))
         scaling = merge(1.0_wp, scaling, trial <= low)
         deformation%plastic_work(i) = state%volume(k)*max(0.0_wp, 0.5_wp*(1.0_wp - scaling) &
            *((1.0_wp + scaling)*trial**2/shear - deformation%plastic_work(i)))
         state%stress(k, 1:6) = scaling*state%stress(k, 1:6)
      end do
      if (allocated(state%recorded%inertial_number)) &
         call note_inertial_number(self%grain/dt, state, deformation, first, last)
   end subroutine mu_i_update

   !> Inertial number of the step, that of the shear rate of the flow, 0 where no pressure holds
   !! grains together. Equation (Y.28).
   pure subroutine note_inertial_number(scale, state, deformation, first, last)
      real(wp), intent(in) :: scale                  !! d sqrt(rho_s) over the time step [Pa^1/2]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      ! An initial state above the strength, as files may contain, flows in a step of zero length.
      real(wp), parameter :: root = sqrt(3.0_wp), most = 1.0e30_wp
      real(wp) :: number, pressure
      integer :: i

      do concurrent (i=1:last - first + 1)
         pressure = deformation%pressure(i)
         number = min(root*deformation%plastic_increment(i)*scale &
            /sqrt(max(pressure, tiny(most))), most)
         state%recorded%inertial_number(first - 1 + i) = merge(number, 0.0_wp, pressure > 0.0_wp)
      end do
   end subroutine note_inertial_number
end module law_mu_i
