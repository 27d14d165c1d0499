! SPDX-License-Identifier: BSD-3-Clause
!> Grains that flow (P. Jop, Y. Forterre, O. Pouliquen, Nature 441 (2006) 727): the shear stress
!! is the cohesion and mu(I) times the pressure with mu = mu_s + (mu_2 - mu_s)/(1 + I0/I), where the
!! inertial number I = rate d sqrt(rho_s/p) has the diameter d and the density rho_s of a grain.
!!
!! Below mu_s the grains are an elastic solid, and without pressure and cohesion they support
!! nothing (S. Dunatunga, K. Kamrin, J. Fluid Mech. 779 (2015) 483). Equation (Y.25) of
!! doc/theory/strength.md.
module law_mu_i
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
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
      real(wp) :: slow, fast

      text = ""
      if (.not. (group%known("mu_s") .and. group%known("mu_2"))) return
      call group%get("mu_s", slow)
      call group%get("mu_2", fast)
      if (fast < slow) text = "mu_2 must not be below mu_s"
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

   !> Return to the flow stress.
   pure subroutine mu_i_update(self, state, deformation, first, last, dt)
      class(law_mu_i_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]

      call equivalent_stress(first, last, state%stress, deformation%plastic_increment)
      call strain_trial(first, last, deformation%gradient, state%stress, deformation%plastic_work)
      call return_to_flow(first, last, self, dt, state%volume, state%stress, &
         deformation%pressure, deformation%plastic_increment, deformation%plastic_work)
      if (allocated(state%recorded%inertial_number)) call note_inertial_number(first, last, &
         self%grain/dt, deformation%pressure, deformation%plastic_increment, &
         state%recorded%inertial_number)
   end subroutine mu_i_update

   !> Inertial number of the step, that of the shear rate of the flow, 0 where no pressure holds
   !! grains together. Equation (Y.25).
   pure subroutine note_inertial_number(first, last, scale, pressure, plastic_increment, number)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: scale                  !! d sqrt(rho_s) over the time step [Pa^1/2]
      real(wp), contiguous, intent(in) :: pressure(:)          !! After the step (range) [Pa]
      real(wp), contiguous, intent(in) :: plastic_increment(:) !! (range) [1]
      real(wp), contiguous, intent(inout) :: number(:)         !! (store) [1]
      ! An initial state above the strength, as files may contain, flows in a step of zero length.
      real(wp), parameter :: root = sqrt(3.0_wp), most = 1.0e30_wp
      integer :: i

      do concurrent (i=1:last - first + 1)
         number(first - 1 + i) = merge(min(root*plastic_increment(i)*scale &
            /sqrt(max(pressure(i), tiny(most))), most), 0.0_wp, pressure(i) > 0.0_wp)
      end do
   end subroutine note_inertial_number

   !> Kernel of the above. The shear stress t after the step, t' before the flow, solves both t' - t
   !! = G dt rate and t = c + mu(I) p: with a = G dt I0/d sqrt(p/rho_s) and the strengths l = c +
   !! mu_s p of slow and h = c + mu_2 p of fast flow it is the smaller root of t**2 - (h + t' + a) t
   !! + h t' + l a = 0 (Dunatunga and Kamrin, as above, without c). In tension the friction is mu_s,
   !! up to the apex at p = -c/mu_s. Equation (Y.26).
   pure subroutine return_to_flow(first, last, law, dt, volume, stress, pressure, &
      plastic_increment, plastic_work)
      integer, intent(in) :: first, last             !! Particles of the range
      type(law_mu_i_t), intent(in) :: law            !! Constants
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :)  !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: pressure(:)   !! (range) [Pa]
      !> Equivalent trial stress [Pa] in, plastic increment [1] out (range).
      real(wp), contiguous, intent(inout) :: plastic_increment(:)
      !> Trial deviator times strain [Pa] in, plastic work [J] out (range).
      real(wp), contiguous, intent(inout) :: plastic_work(:)
      real(wp), parameter :: root = sqrt(3.0_wp)
      real(wp) :: load, trial, shear, delay, half, low, high, scaling, cohesion, fast
      integer :: i, k

      cohesion = law%cohesion
      fast = law%fast
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         pressure(i) = max(pressure(i), law%apex)
         load = max(pressure(i), 0.0_wp)
         trial = plastic_increment(i)/root
         low = max(law%cohesion + law%slow*pressure(i), 0.0_wp)
         high = merge(cohesion + fast*load, low, pressure(i) > 0.0_wp)
         delay = law%shear*dt*law%scale*sqrt(load)
         half = 0.5_wp*(high + trial + delay)
         ! The discriminant, as a sum of terms that are not negative where trial is above low.
         shear = sqrt(max(0.0_wp, 0.25_wp*(high - trial)**2 + 0.25_wp*delay**2 &
            + 0.5_wp*delay*(high + trial - 2.0_wp*low)))
         shear = (high*trial + low*delay)/max(half + shear, tiny(1.0_wp))
         shear = merge(trial, min(shear, trial, high), trial <= low)
         plastic_increment(i) = (trial - shear)/(root*law%shear)
         scaling = shear/max(trial, tiny(1.0_wp))
         scaling = merge(1.0_wp, scaling, trial <= low)
         plastic_work(i) = volume(k)*max(0.0_wp, 0.5_wp*(1.0_wp - scaling) &
            *((1.0_wp + scaling)*trial**2/law%shear - plastic_work(i)))
         stress(k, 1) = scaling*stress(k, 1)
         stress(k, 2) = scaling*stress(k, 2)
         stress(k, 3) = scaling*stress(k, 3)
         stress(k, 4) = scaling*stress(k, 4)
         stress(k, 5) = scaling*stress(k, 5)
         stress(k, 6) = scaling*stress(k, 6)
      end do
   end subroutine return_to_flow
end module law_mu_i
