! SPDX-License-Identifier: BSD-3-Clause
!> Metals at high rates after D. J. Steinberg, S. G. Cochran, M. W. Guinan, J. Appl. Phys. 51 (1980)
!! 1498: shear modulus and yield stress grow with pressure, fall with temperature, and vanish at
!! melting.
!!
!!    G/G0 = 1 + A p/eta**(1/3) - B (T - 300 K),     eta = rho/rho0
!!    Y = min(Y0 (1 + beta (ep + ei))**n, Ymax) G/G0
!!    Tm = Tm0 exp(2 a (1 - 1/eta)) eta**(2 (gamma - a - 1/3))
!!
!! Without temperature B is 0 and nothing melts. Equations (Y.6), (Y.7) and (Y.8) of
!! doc/theory/strength.md.
module law_steinberg_guinan
   use base_constants, only: most_lanes
   use base_elementary, only: take_exponentials, take_fast_powers
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t, in_order
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_hardening, only: collect_lanes, flow_lanes_t, hardening_power_t, &
      move_flow_results, solve_hardening
   use material_kinematics, only: predict_deviator
   use material_law, only: equivalent_stress, law_stored_energy, law_t, strain_trial
   use material_state, only: deformation_t, material_state_t
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

   !> Least fraction of G0 in the trial stress, which divides by the modulus; molten material has no
   !! yield stress.
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
      call schema%real("material", "scg_ymax", &
         "Steinberg-Cochran-Guinan Ymax, greatest yield stress from hardening", unit="Pa", &
         range="> 0", owner=owner)
      call schema%real("material", "scg_beta", "Steinberg-Cochran-Guinan beta, hardening", &
         range=">= 0", owner=owner)
      call schema%real("material", "scg_n", "Steinberg-Cochran-Guinan n, exponent of hardening", &
         range=">= 0 <= 1", owner=owner)
      call schema%real("material", "scg_strain", "initial plastic strain", default="0", &
         range=">= 0", owner=owner)
      call schema%real("material", "scg_gp", "increase of the shear modulus with pressure, "// &
         "G'P/G0; where tables give it per Mbar, 6.52 per Mbar is 6.52e-11 per Pa", unit="1/Pa", &
         range=">= 0", owner=owner)
      call schema%real("material", "scg_gt", &
         "decrease of the shear modulus with temperature, -G'T/G0", unit="1/K", range=">= 0", &
         owner=warm)
      call schema%real("material", "scg_tm", "melting temperature at the reference density", &
         unit="K", range="> 300", owner=warm)
      call schema%real("material", "scg_a", "Steinberg-Cochran-Guinan a of the melting curve", &
         range=">= 0", owner=warm)
      call schema%real("material", "scg_gamma", "Grueneisen parameter of the melting curve", &
         range="> 0", owner=warm)
      call schema%require("material", "scg_y0 scg_ymax scg_beta scg_n scg_gp scg_gt scg_tm "// &
         "scg_a scg_gamma")
   end subroutine steinberg_guinan_declare

   !> A modulus that doubles within 1 MPa is probably given per Mbar.
   pure function steinberg_guinan_fault(self, group, eos) result(text)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text
      real(wp) :: number

      text = ""
      if (group%known("scg_gp")) then
         call group%get("scg_gp", number)
         if (number > 1.0e-6_wp) text = "scg_gp is per Pa; was it given per Mbar? Then "// &
            "write it with e-11 (1 Mbar = 1e11 Pa) [D505]"
      end if
      if (.not. in_order(group, "scg_y0", "scg_ymax", equal=.true.)) &
         text = "scg_ymax must not be below scg_y0 [D363]"
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
      real(wp) :: one(1)

      call find_moduli(self, state, particle, particle, [pressure], one)
      ratio = one(1)
   end function steinberg_guinan_modulus

   !> Shear moduli of the particles of a range over that of the reference state. Equations (Y.6) and
   !! (Y.8).
   pure subroutine find_moduli(law, state, first, last, pressure, ratio)
      class(law_steinberg_guinan_t), intent(in) :: law
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: pressure(:)   !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: ratio(:)   !! (range) [1]
      real(wp), parameter :: third = 1.0_wp/3.0_wp
      real(wp), dimension(most_lanes) :: compression, root, melting, exponent
      integer :: count, k, l, offset

      do offset = 0, last - first, most_lanes
         count = min(most_lanes, last - first + 1 - offset)
         !$omp simd private(k)
         do l = 1, count
            k = first - 1 + offset + l
            compression(l) = state%mass(k)/(law%density*state%volume(k))
            root(l) = compression(l)
         end do
         call take_fast_powers(count, -third, root)
         !$omp simd
         do l = 1, count
            ratio(offset + l) = 1.0_wp + law%stiffening*pressure(offset + l)*root(l)
         end do
         if (allocated(law%curve)) then
            !$omp simd
            do l = 1, count
               melting(l) = compression(l)
               exponent(l) = 2.0_wp*law%curve%volume*(1.0_wp - 1.0_wp/compression(l))
            end do
            call take_exponentials(count, exponent)
            call take_fast_powers(count, 2.0_wp*(law%curve%gamma - law%curve%volume - third), &
               melting)
            !$omp simd private(k)
            do l = 1, count
               k = first - 1 + offset + l
               ratio(offset + l) = ratio(offset + l) &
                  - law%curve%softening*(state%temperature(k) - 300.0_wp)
               ratio(offset + l) = merge(0.0_wp, ratio(offset + l), &
                  state%temperature(k) >= law%curve%reference*exponent(l)*melting(l))
            end do
         end if
         !$omp simd
         do l = 1, count
            ratio(offset + l) = max(ratio(offset + l), 0.0_wp)
         end do
      end do
   end subroutine find_moduli

   !> Elastic trial with the modulus of the state before the step, at its pressure without
   !! artificial viscosity. The trial is linear in stress and modulus, so that with r = G/G0 it is r
   !! times that of the stress over r with G0.
   pure subroutine steinberg_guinan_predict_trial(self, state, deformation, first, last)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      deformation%pressure(:last - first + 1) = -(state%stress(first:last, 1) &
         + state%stress(first:last, 2) + state%stress(first:last, 3))/3.0_wp
      if (allocated(state%viscous_pressure)) deformation%pressure(:last - first + 1) = &
         deformation%pressure(:last - first + 1) - state%viscous_pressure(first:last)
      call find_moduli(self, state, first, last, deformation%pressure, &
         deformation%strength%shear_ratio)
      deformation%strength%shear_ratio(:last - first + 1) = &
         max(deformation%strength%shear_ratio(:last - first + 1), least_modulus)
      call scale_stress(first, last, deformation%strength%shear_ratio, state%stress, .true.)
      call predict_deviator(self%shear, state, deformation, first, last)
      call scale_stress(first, last, deformation%strength%shear_ratio, state%stress, .false.)
      deformation%pressure(:last - first + 1) = deformation%pressure(:last - first + 1) &
         *deformation%strength%shear_ratio(:last - first + 1)
   end subroutine steinberg_guinan_predict_trial

   !> Multiply or divide stresses by the ratio of moduli.
   pure subroutine scale_stress(first, last, ratio, stress, divides)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: ratio(:)   !! (range) [1]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! (store, 6) [Pa]
      logical, intent(in) :: divides                 !! Divide, else multiply
      real(wp) :: factor
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         factor = 1.0_wp/ratio(i)
         if (.not. divides) factor = ratio(i)
         stress(k, 1:6) = factor*stress(k, 1:6)
      end do
   end subroutine scale_stress

   !> Return to the yield surface of the new pressure, group by group. Without hardening it is a
   !! bound of the yield stress.
   pure subroutine steinberg_guinan_update(self, state, deformation, first, last, dt)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      type(flow_lanes_t) :: lanes
      type(hardening_power_t) :: power
      integer :: count, offset

      count = last - first + 1
      call strain_trial(state, deformation, first, last)
      call equivalent_stress(state, deformation, first, last)
      call find_moduli(self, state, first, last, deformation%pressure, deformation%strength%tangent)
      deformation%strength%dilation(:count) = self%yield*deformation%strength%tangent(:count)
      power%exponent = self%exponent
      power%growth = self%hardening
      do offset = 0, count - 1, most_lanes
         call collect_lanes(offset, min(most_lanes, count - offset), &
            deformation%strength%dilation, deformation, lanes)
         if (lanes%count == 0) cycle
         call fill_lanes(self, offset, first - 1 + offset, state, deformation, lanes)
         call solve_hardening(power, lanes)
         call move_flow_results(offset, first - 1 + offset, lanes, state, deformation)
      end do
   end subroutine steinberg_guinan_update

   !> Strength of the lanes at their strain, pressure and temperature.
   pure subroutine fill_lanes(law, offset, before, state, deformation, lanes)
      class(law_steinberg_guinan_t), intent(in) :: law
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: before                  !! Index offset in the store
      type(material_state_t), intent(in) :: state    !! State of the store
      type(deformation_t), intent(in) :: deformation !! With the moduli of the range
      type(flow_lanes_t), intent(inout) :: lanes
      real(wp) :: modulus
      integer :: i, l

      do l = 1, lanes%count
         i = offset + lanes%place(l)
         ! freezing material uses the modulus after the step, because the modulus of its trial is
         ! almost zero
         modulus = max(deformation%strength%tangent(i), least_modulus)
         if (deformation%strength%shear_ratio(i) > least_modulus) modulus = &
            deformation%strength%shear_ratio(i)
         lanes%stiffness(l) = 3.0_wp*law%shear*modulus
         lanes%fixed(l) = 0.0_wp
         lanes%amplitude(l) = law%yield*deformation%strength%tangent(i)
         lanes%argument(l) = 1.0_wp &
            + law%hardening*(state%plastic_strain(before + lanes%place(l)) + law%strain)
         lanes%greatest(l) = law%greatest*deformation%strength%tangent(i)
      end do
   end subroutine fill_lanes

   !> Modulus of the state in the square of the wave speed.
   pure subroutine steinberg_guinan_add_wave_speed(self, state, deformation, first, last)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      call find_moduli(self, state, first, last, deformation%pressure, &
         deformation%strength%shear_ratio)
      if (allocated(state%failed)) deformation%strength%shear_ratio(:last - first + 1) = merge( &
         0.0_wp, deformation%strength%shear_ratio(:last - first + 1), state%failed(first:last) /= 0)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%wave_speed(i) = deformation%wave_speed(i) + 4.0_wp/3.0_wp*self%shear &
            *deformation%strength%shear_ratio(i)*state%volume(k)/state%mass(k)
      end do
   end subroutine steinberg_guinan_add_wave_speed

   !> Energy in the deviator with the modulus of the state, at its pressure without artificial
   !! viscosity.
   pure real(wp) function steinberg_guinan_stored_energy(self, state, particle) result(energy)
      class(law_steinberg_guinan_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: particle                       !! Index in the store
      real(wp) :: pressure

      pressure = -sum(state%stress(particle, 1:3))/3.0_wp
      if (allocated(state%viscous_pressure)) &
         pressure = pressure - state%viscous_pressure(particle)
      energy = law_stored_energy(self, state, particle) &
         /max(self%modulus(state, particle, pressure), least_modulus)
   end function steinberg_guinan_stored_energy
end module law_steinberg_guinan
