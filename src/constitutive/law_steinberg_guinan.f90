! SPDX-License-Identifier: BSD-3-Clause
!> Metals at high rates after D. J. Steinberg, S. G. Cochran, M. W. Guinan, J. Appl. Phys. 51 (1980)
!! 1498: shear modulus and yield stress grow with pressure, fall with temperature, and
!! remove_failed_stress at
!! melting.
!!
!!    G/G0 = 1 + A p/eta**(1/3) - B (T - 300 K),     eta = rho/rho0
!!    Y = min(Y0 (1 + beta (ep + ei))**n, Ymax) G/G0
!!    Tm = Tm0 exp(2 a (1 - 1/eta)) eta**(2 (gamma - a - 1/3))
!!
!! Without temperature B is 0 and nothing melts. Equations (Y.6), (Y.7) and (Y.8) of
!! doc/theory/strength.md.
module law_steinberg_guinan
   use base_deck_group, only: group_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use constitutive_effects, only: effects_t
   use constitutive_eos, only: eos_t
   use constitutive_field_requests, only: field_requests_t
   use constitutive_kinematics, only: predict_deviator
   use constitutive_law, only: equivalent_stress, law_stored_energy, law_t, mean_work, strain_trial
   use constitutive_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_steinberg_guinan_t, melting_curve_t

   !> Temperature of melting.
   type :: melting_curve_t
      real(wp) :: softening = 0.0_wp                 !! B = -G'T/G0 [1/K]
      real(wp) :: reference = 0.0_wp                 !! Tm0 [K]
      real(wp) :: volume = 0.0_wp                    !! a [1]
      real(wp) :: gamma = 0.0_wp                     !! Grueneisen number at the reference [1]
   end type melting_curve_t

   !> Law of Steinberg, Cochran and Guinan.
   type, extends(law_t) :: law_steinberg_guinan_t
      real(wp) :: yield = 0.0_wp                     !! Y0 [Pa]
      real(wp) :: greatest = 0.0_wp                  !! Ymax [Pa]
      real(wp) :: hardening = 0.0_wp                 !! beta [1]
      real(wp) :: exponent = 1.0_wp                  !! n [1]
      real(wp) :: strain = 0.0_wp                    !! ei, plastic strain to begin with [1]
      real(wp) :: stiffening = 0.0_wp                !! A = G'P/G0 [1/Pa]
      type(melting_curve_t), allocatable :: curve    !! Only if temperature softens
   contains
      procedure :: declare => steinberg_guinan_declare !! Declares its keys
      procedure :: fault => steinberg_guinan_fault   !! Constants of other units
      procedure :: read => steinberg_guinan_read     !! Reads its keys
      procedure :: request => steinberg_guinan_request !! Requests plastic strain and temperature
      !> Trial with the modulus of the state
      procedure :: predict_trial => steinberg_guinan_predict_trial
      procedure :: update => steinberg_guinan_update !! Radial return
      procedure :: add_wave_speed => steinberg_guinan_add_wave_speed !! Modulus of the state
      !> Energy with the modulus of the state
      procedure :: stored_energy => steinberg_guinan_stored_energy
      procedure :: modulus => steinberg_guinan_modulus !! G/G0 of a particle
   end type law_steinberg_guinan_t

   !> Material softer than this share of G0 is given this modulus in the trial, which divides by it;
   !! it has no yield stress when melted.
   real(wp), parameter :: least_modulus = 1.0e-6_wp

contains

   !> Declare the keys of the law.
   subroutine steinberg_guinan_declare(self, schema)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = "// &
         "steinberg_guinan"
      character(len=*), parameter :: warm = owner//" & effects.thermal"

      call schema%real("material", "scg_y0", "Steinberg-Cochran-Guinan Y0, yield stress", &
         unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "scg_ymax", "greatest yield stress by hardening", unit="Pa", &
         range="> 0", owner=owner)
      call schema%real("material", "scg_beta", "Steinberg-Cochran-Guinan beta, hardening", &
         range=">= 0", owner=owner)
      call schema%real("material", "scg_n", "Steinberg-Cochran-Guinan n, exponent of hardening", &
         range=">= 0 <= 1", owner=owner)
      call schema%real("material", "scg_strain", "plastic strain to begin with", default="0", &
         range=">= 0", owner=owner)
      call schema%real("material", "scg_gp", "growth of the shear modulus with pressure, "// &
         "G'P/G0; tables give it per Mbar, 6.52 per Mbar is 6.52e-11 per Pa", unit="1/Pa", &
         range=">= 0", owner=owner)
      call schema%real("material", "scg_gt", "fall of the shear modulus with temperature, "// &
         "-G'T/G0", unit="1/K", range=">= 0", owner=warm)
      call schema%real("material", "scg_tm", "temperature of melting at the reference density", &
         unit="K", range="> 300", owner=warm)
      call schema%real("material", "scg_a", "Steinberg-Cochran-Guinan a of the melting curve", &
         range=">= 0", owner=warm)
      call schema%real("material", "scg_gamma", "Grueneisen number of the melting curve", &
         range="> 0", owner=warm)
      call schema%require("material", "scg_y0 scg_ymax scg_beta scg_n scg_gp scg_gt scg_tm "// &
         "scg_a scg_gamma")
   end subroutine steinberg_guinan_declare

   !> A modulus that doubles within 1 MPa was given per Mbar.
   pure function steinberg_guinan_fault(self, group, eos) result(text)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text
      real(wp) :: number, other

      text = ""
      if (group%known("scg_gp")) then
         call group%get("scg_gp", number)
         if (number > 1.0e-6_wp) text = "scg_gp is per Pa; was it given per Mbar? Then "// &
            "write it with e-11 (1 Mbar = 1e11 Pa)"
      end if
      if (group%known("scg_y0") .and. group%known("scg_ymax")) then
         call group%get("scg_y0", number)
         call group%get("scg_ymax", other)
         if (other < number) text = "scg_ymax must not be below scg_y0"
      end if
   end function steinberg_guinan_fault

   !> Read the keys of the law.
   pure subroutine steinberg_guinan_read(self, group, effects)
      class(law_steinberg_guinan_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call group%get("scg_y0", self%yield)
      call group%get("scg_ymax", self%greatest)
      call group%get("scg_beta", self%hardening)
      call group%get("scg_n", self%exponent)
      call group%get("scg_strain", self%strain)
      call group%get("scg_gp", self%stiffening)
      if (.not. effects%thermal) return
      allocate (self%curve)
      call group%get("scg_gt", self%curve%softening)
      call group%get("scg_tm", self%curve%reference)
      call group%get("scg_a", self%curve%volume)
      call group%get("scg_gamma", self%curve%gamma)
   end subroutine steinberg_guinan_read

   !> Hardening needs the plastic strain, softening the temperature.
   pure subroutine steinberg_guinan_request(self, requests)
      class(law_steinberg_guinan_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("plastic_strain", "hardening of steinberg_guinan", 1)
      if (allocated(self%curve)) call requests%add("temperature", &
         "softening of steinberg_guinan", 1)
   end subroutine steinberg_guinan_request

   !> Shear modulus of a particle over that of the reference state, 0 if it has melted.
   pure real(wp) function steinberg_guinan_modulus(self, state, particle, pressure) result(ratio)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: particle                       !! Index in the store
      real(wp), intent(in) :: pressure               !! Its pressure [Pa]
      real(wp) :: compression, melting

      compression = state%mass(particle)/(self%density*state%volume(particle))
      ratio = 1.0_wp + self%stiffening*pressure/compression**(1.0_wp/3.0_wp)
      if (allocated(self%curve)) then
         associate (curve => self%curve, temperature => state%temperature(particle))
            ratio = ratio - curve%softening*(temperature - 300.0_wp)
            melting = curve%reference*exp(2.0_wp*curve%volume*(1.0_wp - 1.0_wp/compression)) &
               *compression**(2.0_wp*(curve%gamma - curve%volume - 1.0_wp/3.0_wp))
            if (temperature >= melting) ratio = 0.0_wp
         end associate
      end if
      ratio = max(ratio, 0.0_wp)
   end function steinberg_guinan_modulus

   !> Elastic trial with the modulus of the state before the step. The trial is linear in stress and
   !! modulus, so that with r = G/G0 it is r times that of the stress over r with G0.
   pure subroutine steinberg_guinan_predict_trial(self, state, deformation, first, last)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp) :: pressure
      integer :: i, k

      associate (ratio => deformation%strength%shear_ratio, stress => state%stress)
         do i = 1, last - first + 1
            k = first - 1 + i
            pressure = -(stress(k, 1) + stress(k, 2) + stress(k, 3))/3.0_wp
            ratio(i) = max(self%modulus(state, k, pressure), least_modulus)
            stress(k, :) = stress(k, :)/ratio(i)
         end do
         call predict_deviator(first, last, deformation%plane, self%shear, deformation%gradient, &
            state%volume, stress, deformation%old_volume, deformation%dilatation, &
            deformation%pressure)
         do i = 1, last - first + 1
            k = first - 1 + i
            stress(k, :) = stress(k, :)*ratio(i)
            deformation%pressure(i) = deformation%pressure(i)*ratio(i)
         end do
      end associate
   end subroutine steinberg_guinan_predict_trial

   !> Return to the yield surface of the new pressure. Few particles flow at a time, so they are
   !! treated one by one.
   pure subroutine steinberg_guinan_update(self, state, deformation, first, last, dt)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: ratio, limit, increment, stiffness
      integer :: i, k

      call strain_trial(first, last, deformation%gradient, state%stress, deformation%plastic_work)
      call equivalent_stress(first, last, state%stress, deformation%plastic_increment)
      do i = 1, last - first + 1
         k = first - 1 + i
         associate (trial => deformation%plastic_increment(i))
            ratio = self%modulus(state, k, deformation%pressure(i))
            ! material that freezes has the modulus after the step: its trial had almost none
            stiffness = 3.0_wp*self%shear*merge(deformation%strength%shear_ratio(i), ratio, &
               deformation%strength%shear_ratio(i) > least_modulus)
            call flow(self, trial, state%plastic_strain(k), ratio, stiffness, limit, increment)
            if (limit < trial) state%stress(k, :) = limit/trial*state%stress(k, :)
            state%plastic_strain(k) = state%plastic_strain(k) + increment
            deformation%plastic_work(i) = state%volume(k)*mean_work( &
               stiffness/3.0_wp, trial, limit, increment, deformation%plastic_work(i))
            trial = increment
         end associate
      end do
   end subroutine steinberg_guinan_update

   !> Plastic increment x of one particle from trial - 3 G x = Y(ep + x). The difference of the two
   !! falls and is convex, as Y is concave, so that Newton's method climbs to the root from x = 0. A
   !! melted particle flows without resistance and its plastic strain is left alone.
   pure subroutine flow(law, trial, strain, ratio, stiffness, limit, increment)
      type(law_steinberg_guinan_t), intent(in) :: law !! Constants
      real(wp), intent(in) :: trial                  !! Equivalent trial stress [Pa]
      real(wp), intent(in) :: strain                 !! Equivalent plastic strain before [1]
      real(wp), intent(in) :: ratio                  !! G/G0 after the step [1]
      real(wp), intent(in) :: stiffness              !! 3 G of the trial [Pa]
      real(wp), intent(out) :: limit                 !! Equivalent stress after the step [Pa]
      real(wp), intent(out) :: increment             !! Increment of plastic strain [1]
      real(wp), parameter :: tolerance = 1.0e-12_wp
      integer, parameter :: most_iterations = 100
      real(wp) :: residual, slope, argument
      integer :: iteration

      increment = 0.0_wp
      limit = trial
      if (trial <= law%yield*ratio) return
      do iteration = 1, most_iterations
         argument = 1.0_wp + law%hardening*(strain + law%strain + increment)
         limit = law%yield*argument**law%exponent
         slope = limit*law%exponent*law%hardening/argument
         if (limit >= law%greatest) then
            limit = law%greatest
            slope = 0.0_wp
         end if
         limit = limit*ratio
         residual = trial - stiffness*increment - limit
         if (residual <= tolerance*limit .or. .not. ratio > 0.0_wp) exit
         increment = increment + residual/(stiffness + ratio*slope)
      end do
      if (iteration == 1) limit = min(limit, trial)
   end subroutine flow

   !> Modulus of the state in the square of the wave speed.
   pure subroutine steinberg_guinan_add_wave_speed(self, state, deformation, first, last)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      integer :: i, k

      do i = 1, last - first + 1
         deformation%strength%shear_ratio(i) = self%modulus(state, first - 1 + i, &
            deformation%pressure(i))
      end do
      if (allocated(state%failed)) then
         do concurrent (i=1:last - first + 1)
            deformation%strength%shear_ratio(i) = merge(0.0_wp, &
               deformation%strength%shear_ratio(i), &
               state%failed(first - 1 + i) /= 0)
         end do
      end if
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%wave_speed(i) = deformation%wave_speed(i) + 4.0_wp/3.0_wp*self%shear &
            *deformation%strength%shear_ratio(i)*state%volume(k)/state%mass(k)
      end do
   end subroutine steinberg_guinan_add_wave_speed

   !> Energy in the deviator with the modulus of the state.
   pure real(wp) function steinberg_guinan_stored_energy(self, state, particle) result(energy)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: particle                       !! Index in the store
      real(wp) :: pressure

      pressure = -sum(state%stress(particle, 1:3))/3.0_wp
      energy = law_stored_energy(self, state, particle) &
         /max(self%modulus(state, particle, pressure), least_modulus)
   end function steinberg_guinan_stored_energy
end module law_steinberg_guinan
