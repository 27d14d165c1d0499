! SPDX-License-Identifier: BSD-3-Clause
!> Modified Cam-clay (K. H. Roscoe, J. B. Burland, "On the generalised stress-strain behaviour of
!! wet clay", in: Engineering plasticity, 1968; D. M. Wood, "Soil behaviour and critical state
!! soil mechanics", 1990): clay that hardens as it is compacted and softens as it dilates, until it
!! flows at constant volume in the critical state q = M p.
!!
!! Pressures are positive in compression and are those of the skeleton (effective). The pressure is
!! a function of the density and of the preconsolidation pressure, so that isotropic compression and
!! swelling follow their lines v = N - lambda ln p and v = v_k - kappa ln p in steps of any length,
!! and separated clay has no pressure until its density is restored. The shear modulus is constant,
!! so that the elastic part has a potential (M. Zytynski and others, Int. J. Numer. Anal. Meth.
!! Geomech. 2 (1978) 87). Equations (Y.33) to (Y.42) of doc/theory/strength.md.
module law_cam_clay
   use base_elementary, only: exponential, logarithm
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t, in_order
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_law, only: equivalent_stress, law_stored_energy, law_t, strain_trial
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_cam_clay_t

   !> Least logarithm of the pressure over that of the reference state: clay that has separated.
   real(wp), parameter :: separated = -60.0_wp
   !> Name of its field
   character(len=*), parameter :: field = "preconsolidation"

   !> Law of modified Cam-clay.
   type, extends(law_t) :: law_cam_clay_t
      real(wp) :: slope = 0.0_wp                     !! M, q over p in the critical state [1]
      real(wp) :: compression = 0.0_wp               !! lambda, slope of the compression line [1]
      real(wp) :: swelling = 0.0_wp                  !! kappa, slope of the swelling lines [1]
      real(wp) :: specific = 0.0_wp !! v0, volume over that of the grains at `density` [1]
      real(wp) :: pressure = 0.0_wp                  !! p0, pressure at `density` [Pa]
      real(wp) :: consolidated = 0.0_wp              !! pc0, preconsolidation pressure then [Pa]
      real(wp) :: ratio = 1.0_wp                     !! R, overconsolidation ratio, if given [1]
      real(wp) :: least = 0.0_wp                     !! pc0 if that is given itself [Pa]
   contains
      procedure :: declare => cam_clay_declare       !! Declares its keys
      procedure :: fault => cam_clay_fault           !! Keys that do not go together
      procedure :: read => cam_clay_read             !! Reads its keys
      procedure :: set => cam_clay_set               !! Sets its constants
      procedure :: gives_whole_stress => cam_clay_gives_whole_stress !! Returns true
      procedure :: sets_bulk => cam_clay_sets_bulk   !! Returns true
      procedure :: starts_with_stress => cam_clay_starts_with_stress !! Returns true
      procedure :: finds_rest_state => cam_clay_finds_rest_state !! Returns true
      !> Density and consolidation under a stress
      procedure :: find_rest_state => cam_clay_find_rest_state
      procedure :: least_pressure => cam_clay_least_pressure !! No tension
      procedure :: request => cam_clay_request       !! Requests the preconsolidation pressure
      procedure :: update => cam_clay_update         !! Pressure, and return to the yield surface
      procedure :: add_wave_speed => cam_clay_add_wave_speed !! Elastic waves
      procedure :: stored_energy => cam_clay_stored_energy !! Elastic energy of a particle
   end type law_cam_clay_t

   !> A trial state outside of the yield surface, and what its return needs.
   type :: trial_t
      real(wp) :: shear = 0.0_wp                     !! q of the trial [Pa]
      real(wp) :: ratio = 0.0_wp                     !! ln(p/pc) of the trial [1]
      real(wp) :: logarithm = 0.0_wp                 !! ln(p/p0) of the trial [1]
      real(wp) :: stiffness = 0.0_wp                 !! 6 G (lambda - kappa)/(v M) [Pa]
   end type trial_t

contains

   !> Declare the keys of the law.
   subroutine cam_clay_declare(self, schema)
      class(law_cam_clay_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = cam_clay"

      call schema%real("material", "mcc_m", "critical state ratio M of the equivalent stress "// &
         "to the pressure; 6 sin(phi)/(3 - sin(phi)) in triaxial compression", range="> 0 <= 3", &
         owner=owner)
      call schema%real("material", "mcc_lambda", "slope of the isotropic compression line, "// &
         "specific volume over natural logarithm of the pressure", range="> 0 <= 5", owner=owner)
      call schema%real("material", "mcc_kappa", "slope of the swelling lines, below mcc_lambda", &
         range="> 0 <= 5", owner=owner)
      call schema%real("material", "mcc_v0", "specific volume, 1 + void ratio, of the state of "// &
         "density", range="> 1 <= 20", owner=owner)
      call schema%real("material", "mcc_p0", "mean effective pressure of the state of density, "// &
         "with which the material starts where no weight gives another", unit="Pa", range="> 0", &
         owner=owner)
      call schema%real("material", "mcc_pc", "initial preconsolidation pressure, not below "// &
         "mcc_p0; instead of mcc_ocr", unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "mcc_ocr", "initial overconsolidation ratio, "// &
         "preconsolidation pressure over mcc_p0, or over that of the stress of a weight", &
         default="1", range=">= 1", owner=owner)
      call schema%require("material", "mcc_m mcc_lambda mcc_kappa mcc_v0 mcc_p0")
      call schema%forbid_change("material", "mcc_pc mcc_ocr mcc_lambda mcc_kappa mcc_v0 mcc_p0", &
         "density and preconsolidation pressure of the particles belong to it")
   end subroutine cam_clay_declare

   !> Error in the combination of the keys; empty if there is none.
   pure function cam_clay_fault(self, group, eos) result(text)
      class(law_cam_clay_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text

      text = ""
      if (.not. in_order(group, "mcc_kappa", "mcc_lambda")) then
         text = "mcc_kappa must be below mcc_lambda; otherwise compaction would gain energy [D363]"
      else if (group%given("mcc_pc") .and. group%given("mcc_ocr")) then
         text = "mcc_pc and mcc_ocr are both given; keep one [D307]"
      else if (group%given("mcc_pc")) then
         if (.not. in_order(group, "mcc_p0", "mcc_pc", equal=.true.)) text = "mcc_pc must not "// &
            "be below mcc_p0, which would be outside of the yield surface [D363]"
      end if
   end function cam_clay_fault

   !> Read the keys of the law. All plastic work becomes heat.
   pure subroutine cam_clay_read(self, group, effects)
      class(law_cam_clay_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects
      real(wp) :: slope, compression, swelling, specific, pressure, consolidated

      call group%get("mcc_m", slope)
      call group%get("mcc_lambda", compression)
      call group%get("mcc_kappa", swelling)
      call group%get("mcc_v0", specific)
      call group%get("mcc_p0", pressure)
      if (group%given("mcc_pc")) then
         call group%get("mcc_pc", consolidated)
         self%least = consolidated
      else
         call group%get("mcc_ocr", self%ratio)
         consolidated = self%ratio*pressure
      end if
      call self%set(slope, compression, swelling, specific, pressure, consolidated)
   end subroutine cam_clay_read

   !> Set the constants; density and shear modulus are set before. The bulk modulus is that of the
   !! state of the density. Equation (Y.35).
   pure subroutine cam_clay_set(self, slope, compression, swelling, specific, pressure, &
      consolidated)
      class(law_cam_clay_t), intent(inout) :: self
      real(wp), intent(in) :: slope                  !! M [1]
      real(wp), intent(in) :: compression            !! lambda [1]
      real(wp), intent(in) :: swelling               !! kappa [1]
      real(wp), intent(in) :: specific               !! v0 [1]
      real(wp), intent(in) :: pressure               !! p0 [Pa]
      real(wp), intent(in) :: consolidated           !! pc0 [Pa]

      self%slope = slope
      self%compression = compression
      self%swelling = swelling
      self%specific = specific
      self%pressure = pressure
      self%consolidated = consolidated
      self%bulk = specific*pressure/swelling
      self%heat_share = 1.0_wp
   end subroutine cam_clay_set

   !> Pressure and deviator belong together.
   pure logical function cam_clay_gives_whole_stress(self) result(whole)
      class(law_cam_clay_t), intent(in) :: self

      whole = .true.
   end function cam_clay_gives_whole_stress

   !> The bulk modulus is v p/kappa.
   pure logical function cam_clay_sets_bulk(self) result(sets)
      class(law_cam_clay_t), intent(in) :: self

      sets = .true.
   end function cam_clay_sets_bulk

   !> It has the pressure p0 at the start; without pressure clay has no stiffness.
   pure logical function cam_clay_starts_with_stress(self) result(starts)
      class(law_cam_clay_t), intent(in) :: self

      starts = .true.
   end function cam_clay_starts_with_stress

   !> It finds its state under a weight.
   pure logical function cam_clay_finds_rest_state(self) result(finds)
      class(law_cam_clay_t), intent(in) :: self

      finds = .true.
   end function cam_clay_finds_rest_state

   !> Preconsolidation pressure and density under a stress: R times the ellipse through the stress,
   !! or `mcc_pc` where that is larger, and the mass that (Y.34) gives to the volume. Equation
   !! (Y.42).
   pure subroutine cam_clay_find_rest_state(self, state, particle)
      class(law_cam_clay_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state !! With stress and volume
      integer, intent(in) :: particle                !! Index in the store
      real(wp) :: pressure, square, consolidated, specific

      pressure = -sum(state%stress(particle, 1:3))/3.0_wp
      square = 1.5_wp*(sum((state%stress(particle, 1:3) + pressure)**2) &
         + 2.0_wp*sum(state%stress(particle, 4:6)**2))
      consolidated = max(self%least, self%ratio*(pressure + square/(self%slope**2*pressure)))
      specific = self%specific - (self%compression - self%swelling) &
         *logarithm(consolidated/self%consolidated) &
         - self%swelling*logarithm(pressure/self%pressure)
      state%own(state%own_index(field))%values(particle) = consolidated
      state%mass(particle) = self%density*self%specific/specific*state%volume(particle)
   end subroutine cam_clay_find_rest_state

   !> It supports no tension.
   pure real(wp) function cam_clay_least_pressure(self) result(pressure)
      class(law_cam_clay_t), intent(in) :: self

      pressure = 0.0_wp
   end function cam_clay_least_pressure

   !> The size of the yield surface is a state variable.
   pure subroutine cam_clay_request(self, requests)
      class(law_cam_clay_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add_own(field, "Pa", "preconsolidation pressure of modified Cam-clay", &
         "strength model cam_clay", self%consolidated)
   end subroutine cam_clay_request

   !> Logarithm of the pressure over p0, that of the swelling line. Equation (Y.34).
   pure real(wp) function pressure_logarithm(law, specific, gain) result(value)
      class(law_cam_clay_t), intent(in) :: law
      real(wp), intent(in) :: specific               !! v [1]
      real(wp), intent(in) :: gain                   !! ln(pc/pc0) [1]

      value = max(separated, (law%specific - specific - (law%compression - law%swelling)*gain) &
         /law%swelling)
   end function pressure_logarithm

   !> Pressure of the new density, and return to the yield surface. The plastic work is that of the
   !! mean of the stresses before and after the step. Equations (Y.33), (Y.36) and (Y.41).
   pure subroutine cam_clay_update(self, state, deformation, first, last, dt)
      class(law_cam_clay_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(trial_t) :: trial
      real(wp) :: specific, before, pressure, scaling, hardening, grains, gain, excess
      integer :: i, k

      excess = logarithm(self%consolidated/self%pressure)
      call equivalent_stress(state, deformation, first, last)
      call strain_trial(state, deformation, first, last)
      associate (consolidated => state%own(state%own_index(field))%values)
         do i = 1, last - first + 1
            k = first - 1 + i
            grains = state%mass(k)/(self%density*self%specific)
            specific = state%volume(k)/grains
            before = deformation%pressure(i)
            if (allocated(state%viscous_pressure)) before = before - state%viscous_pressure(k)
            trial%shear = deformation%plastic_increment(i)
            gain = logarithm(consolidated(k)/self%consolidated)
            trial%logarithm = pressure_logarithm(self, specific, gain)
            trial%ratio = trial%logarithm - gain - excess
            trial%stiffness = 6.0_wp*self%shear*(self%compression - self%swelling) &
               /(specific*self%slope)
            call return_to_ellipse(self, trial, consolidated(k), pressure, scaling, hardening)
            deformation%plastic_increment(i) = (1.0_wp - scaling)*trial%shear/(3.0_wp*self%shear)
            deformation%plastic_work(i) = max(0.0_wp, &
               0.5_wp*(state%volume(k) + deformation%old_volume(i))*(1.0_wp - scaling) &
               *((1.0_wp + scaling)*trial%shear**2/(6.0_wp*self%shear) &
               - 0.5_wp*deformation%plastic_work(i)) &
               + 0.5_wp*(before + pressure)*grains*(self%compression - self%swelling)*hardening)
            deformation%pressure(i) = pressure
            state%stress(k, 1:6) = scaling*state%stress(k, 1:6)
            consolidated(k) = consolidated(k)*exponential(hardening)
         end do
      end associate
   end subroutine cam_clay_update

   !> State after the step. Outside of the yield surface it is the point t = q/(M p) of the surface
   !! at which the flow, normal to the surface, brings the trial state. Equations (Y.33), (Y.37),
   !! (Y.38) and (Y.39).
   pure subroutine return_to_ellipse(law, trial, consolidated, pressure, scaling, hardening)
      type(law_cam_clay_t), intent(in) :: law
      type(trial_t), intent(in) :: trial
      real(wp), intent(in) :: consolidated           !! pc before the step [Pa]
      real(wp), intent(out) :: pressure              !! p after the step [Pa]
      real(wp), intent(out) :: scaling               !! Deviator over that of the trial [1]
      real(wp), intent(out) :: hardening             !! Change of ln pc [1]
      real(wp), parameter :: half = -log(2.0_wp)     ! ln(p/pc) in the critical state
      real(wp) :: high, low, place

      hardening = 0.0_wp
      scaling = 1.0_wp
      pressure = 0.0_wp
      if (trial%ratio <= 0.0_wp) then
         pressure = law%pressure*exponential(trial%logarithm)
         if (trial%shear**2 <= law%slope**2*pressure*(consolidated - pressure)) return
      end if
      if (trial%ratio >= half) then
         low = 0.0_wp
         if (trial%ratio < 0.0_wp) low = sqrt(max(0.0_wp, exponential(-trial%ratio) - 1.0_wp))
         high = 1.0_wp
         if (.not. trial%shear > 0.0_wp) high = low
      else
         low = 1.0_wp/sqrt(exponential(-trial%ratio) - 1.0_wp)
         high = 1.0_wp
      end if
      call find_root(law, trial, trial%ratio < half, min(low, high), high, place)
      call find_state(law, trial, trial%ratio < half, place, hardening, pressure)
      if (trial%ratio < half) place = 1.0_wp/place
      if (trial%shear > 0.0_wp) &
         scaling = min(1.0_wp, law%slope*pressure*place/trial%shear)
   end subroutine return_to_ellipse

   !> Change of ln pc and pressure at a place of the yield surface. Equation (Y.38).
   pure subroutine find_state(law, trial, dry, place, hardening, pressure)
      type(law_cam_clay_t), intent(in) :: law
      type(trial_t), intent(in) :: trial
      logical, intent(in) :: dry                     !! The clay dilates: q > M p
      real(wp), intent(in) :: place                  !! t, or 1/t where it is dry [1]
      real(wp), intent(out) :: hardening             !! Change of ln pc [1]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp) :: rise

      rise = logarithm(1.0_wp + place**2)         ! ln(pc/p)
      if (dry) rise = rise - 2.0_wp*logarithm(place)
      hardening = law%swelling/law%compression*(trial%ratio + rise)
      pressure = law%pressure*exponential(trial%logarithm - (law%compression - law%swelling) &
         /law%swelling*hardening)
   end subroutine find_state

   !> Residual of the flow rule, negative below its root; in t, or in 1/t where it is dry, times
   !! -1/t**2. Equation (Y.39).
   pure real(wp) function residual(law, trial, dry, place) result(value)
      type(law_cam_clay_t), intent(in) :: law
      type(trial_t), intent(in) :: trial
      logical, intent(in) :: dry                     !! The clay dilates: q > M p
      real(wp), intent(in) :: place                  !! t, or 1/t where it is dry [1]
      real(wp) :: hardening, pressure

      call find_state(law, trial, dry, place, hardening, pressure)
      if (dry) then
         value = (1.0_wp - place**2)*(law%slope*pressure/place - trial%shear) &
            - trial%stiffness*hardening*place
      else
         value = (1.0_wp - place**2)*(law%slope*pressure*place - trial%shear) &
            + trial%stiffness*hardening*place
      end if
   end function residual

   !> Root of the residual in a bracket: regula falsi after G. Dahlquist and A. Bjoerck
   !! ("Illinois"), with a bisection in every third round, which bounds their number.
   pure subroutine find_root(law, trial, dry, from, upto, place)
      type(law_cam_clay_t), intent(in) :: law
      type(trial_t), intent(in) :: trial
      logical, intent(in) :: dry                     !! The clay dilates: q > M p
      real(wp), intent(in) :: from, upto             !! Bracket [1]
      real(wp), intent(out) :: place                 !! [1]
      integer, parameter :: most_rounds = 200
      real(wp) :: low, high, at_low, at_high, found
      integer :: round, side

      low = from
      high = upto
      place = low
      if (.not. high > low) return
      at_low = residual(law, trial, dry, low)
      at_high = residual(law, trial, dry, high)
      side = 0
      do round = 1, most_rounds
         place = (low*at_high - high*at_low)/(at_high - at_low)
         if (mod(round, 3) == 0 .or. .not. (place > low .and. place < high)) &
            place = 0.5_wp*(low + high)
         if (high - low <= 2.0_wp*epsilon(1.0_wp)*high) exit
         found = residual(law, trial, dry, place)
         if (found > 0.0_wp) then
            high = place
            at_high = found
            if (side > 0) at_low = 0.5_wp*at_low
            side = 1
         else if (found < 0.0_wp) then
            low = place
            at_low = found
            if (side < 0) at_high = 0.5_wp*at_high
            side = -1
         else
            exit
         end if
      end do
   end subroutine find_root

   !> Square of the speed of elastic waves, (v p/kappa + 4/3 G)/rho. Separated clay has that of the
   !! density of reference at most, otherwise a cloud of debris would shorten the time step.
   !! Equations (Y.34) and (Y.35).
   pure subroutine cam_clay_add_wave_speed(self, state, deformation, first, last)
      class(law_cam_clay_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), parameter :: loose = 1.0e-6_wp             ! of p0: separated
      real(wp) :: specific, pressure, share
      integer :: i, k, own

      own = state%own_index(field)
      do i = 1, last - first + 1
         k = first - 1 + i
         specific = self%specific*self%density*state%volume(k)/state%mass(k)
         pressure = self%pressure*exponential(pressure_logarithm(self, specific, &
            logarithm(state%own(own)%values(k)/self%consolidated)))
         share = state%volume(k)/state%mass(k)
         if (pressure < loose*self%pressure) share = min(share, 1.0_wp/self%density)
         deformation%wave_speed(i) = deformation%wave_speed(i) &
            + (specific*pressure/self%swelling + 4.0_wp/3.0_wp*self%shear)*share
      end do
   end subroutine cam_clay_add_wave_speed

   !> Elastic energy of a particle: kappa p for each volume of grains, and that of the deviator.
   !! Equation (Y.40).
   pure real(wp) function cam_clay_stored_energy(self, state, particle) result(energy)
      class(law_cam_clay_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: particle                       !! Index in the store
      real(wp) :: grains, specific, gain

      grains = state%mass(particle)/(self%density*self%specific)
      specific = state%volume(particle)/grains
      gain = logarithm(state%own(state%own_index(field))%values(particle)/self%consolidated)
      energy = law_stored_energy(self, state, particle) + grains*self%swelling*self%pressure &
         *exponential(pressure_logarithm(self, specific, gain))
   end function cam_clay_stored_energy
end module law_cam_clay
