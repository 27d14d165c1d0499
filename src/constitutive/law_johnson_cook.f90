! SPDX-License-Identifier: BSD-3-Clause
!> Flow stress of Johnson and Cook (1983): (A + B ep**n) (1 + C ln(rate/rate0)) (1 - T***m).
!!
!! The logarithm is not less than 0, so that slow flow is not weaker than the static yield stress.
!! Equation (Y.4) of doc/theory/strength.md.
module law_johnson_cook
   use base_deck_group, only: group_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use constitutive_effects, only: effects_t
   use constitutive_field_requests, only: field_requests_t
   use constitutive_heat, only: homologous_temperature, melting_range_t, read_melting_range
   use constitutive_law, only: equivalent_stress, law_t, mean_work, strain_trial
   use constitutive_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_johnson_cook_t

   !> Law of Johnson and Cook. Without rate dependence the rate coefficient is 0.
   type, extends(law_t) :: law_johnson_cook_t
      real(wp) :: yield = 0.0_wp                     !! A, static yield stress [Pa]
      real(wp) :: hardening = 0.0_wp                 !! B [Pa]
      real(wp) :: exponent = 1.0_wp                  !! n [1]
      real(wp) :: rate_coefficient = 0.0_wp          !! C [1]
      real(wp) :: reference_rate = 1.0_wp            !! Rate of the static yield stress [1/s]
      real(wp) :: softening_exponent = 1.0_wp        !! m [1]
      type(melting_range_t), allocatable :: range    !! Only if temperature softens
   contains
      procedure :: declare => johnson_cook_declare   !! Declares its keys
      procedure :: uses_jc_rate => johnson_cook_uses_jc_rate !! It does
      procedure :: read => johnson_cook_read         !! Reads its keys
      procedure :: request => johnson_cook_request   !! Requests plastic strain and temperature
      procedure :: update => johnson_cook_update     !! Radial return
   end type law_johnson_cook_t

contains

   !> Declare the keys of the law.
   subroutine johnson_cook_declare(self, schema)
      class(law_johnson_cook_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = johnson_cook"

      call schema%real("material", "jc_a", "Johnson-Cook A, static yield stress", unit="Pa", &
         range="> 0", owner=owner)
      call schema%real("material", "jc_b", "Johnson-Cook B, hardening", unit="Pa", &
         range=">= 0", owner=owner)
      call schema%real("material", "jc_n", "Johnson-Cook n, exponent of plastic strain", &
         range=">= 0", owner=owner)
      call schema%real("material", "jc_c", "Johnson-Cook C, rate dependence", range=">= 0", &
         owner=owner//" & effects.rate")
      call schema%real("material", "jc_m", "Johnson-Cook m, exponent of thermal softening", &
         range="> 0", owner=owner//" & effects.thermal")
      call schema%require("material", "jc_a jc_b jc_n jc_c jc_m")
   end subroutine johnson_cook_declare

   !> The flow stress depends on the rate.
   pure logical function johnson_cook_uses_jc_rate(self) result(uses)
      class(law_johnson_cook_t), intent(in) :: self

      uses = .true.
   end function johnson_cook_uses_jc_rate

   !> Read the keys of the law.
   pure subroutine johnson_cook_read(self, group, effects)
      class(law_johnson_cook_t), intent(inout) :: self
      type(group_t), intent(in) :: group               !! &material
      type(effects_t), intent(in) :: effects

      call group%get("jc_a", self%yield)
      call group%get("jc_b", self%hardening)
      call group%get("jc_n", self%exponent)
      if (effects%rate) then
         call group%get("jc_c", self%rate_coefficient)
         call group%get("jc_rate", self%reference_rate)
      end if
      if (effects%thermal) then
         call group%get("jc_m", self%softening_exponent)
         allocate (self%range)
         call read_melting_range(group, self%range)
      end if
   end subroutine johnson_cook_read

   !> Hardening needs the plastic strain, softening the temperature.
   pure subroutine johnson_cook_request(self, requests)
      class(law_johnson_cook_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("plastic_strain", "hardening of johnson_cook", 1)
      if (allocated(self%range)) call requests%add("temperature", "softening of johnson_cook", 1)
   end subroutine johnson_cook_request

   !> Return to the yield surface. Few particles flow at a time, and these need powers and
   !! logarithms, so they are treated one by one after a pass over all.
   pure subroutine johnson_cook_update(self, state, deformation, first, last, dt)
      class(law_johnson_cook_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: limit, increment
      integer :: i, k

      if (allocated(self%range)) then
         call homologous_temperature(first, last, self%range, state%temperature, &
            deformation%strength%homologous)
      else
         deformation%strength%homologous(1:last - first + 1) = 0.0_wp
      end if
      call strain_trial(first, last, deformation%gradient, state%stress, deformation%plastic_work)
      call equivalent_stress(first, last, state%stress, deformation%plastic_increment)
      do i = 1, last - first + 1
         associate (trial => deformation%plastic_increment(i))
            k = first - 1 + i
            call flow(self, trial, state%plastic_strain(k), dt, &
               deformation%strength%homologous(i), limit, increment)
            if (limit < trial) state%stress(k, :) = limit/trial*state%stress(k, :)
            state%plastic_strain(k) = state%plastic_strain(k) + increment
            deformation%plastic_work(i) = state%volume(k)*mean_work(self%shear, trial, limit, &
               increment, deformation%plastic_work(i))
            trial = increment
         end associate
      end do
   end subroutine johnson_cook_update

   !> Plastic increment x of one particle from trial - 3 G x = Y(ep + x, x/dt, T).
   !!
   !! The left side falls and the right side grows, so the root lies between 0 and the increment of
   !! a stress at rest, and Newton steps that leave the bracket are replaced by bisection. A melted
   !! particle flows without resistance and its plastic strain is left alone. Equation (Y.5).
   pure subroutine flow(law, trial, strain, dt, homologous, limit, increment)
      class(law_johnson_cook_t), intent(in) :: law
      real(wp), intent(in) :: trial                  !! Equivalent trial stress [Pa]
      real(wp), intent(in) :: strain                 !! Equivalent plastic strain before [1]
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: homologous             !! Homologous temperature, 0 to 1 [1]
      real(wp), intent(out) :: limit                 !! Equivalent stress after the step [Pa]
      real(wp), intent(out) :: increment             !! Increment of plastic strain [1]
      real(wp), parameter :: tolerance = 1.0e-12_wp
      integer, parameter :: most_iterations = 200
      real(wp) :: lower, upper, residual, slope, softening
      integer :: iteration

      limit = trial
      increment = 0.0_wp
      ! A bound of the yield stress without its powers.
      if (law%softening_exponent >= 1.0_wp .and. trial <= law%yield*(1.0_wp - homologous)) return
      softening = 1.0_wp
      if (homologous > 0.0_wp) softening = 1.0_wp - homologous**law%softening_exponent
      limit = (law%yield + law%hardening*strain**law%exponent)*softening
      if (trial <= limit) limit = trial
      if (trial <= limit .or. limit <= 0.0_wp) return
      lower = 0.0_wp
      upper = (trial - limit)/(3.0_wp*law%shear)
      increment = upper
      do iteration = 1, most_iterations
         call yield_stress(law, strain + increment, increment, dt, softening, limit, slope)
         residual = trial - 3.0_wp*law%shear*increment - limit
         if (abs(residual) <= tolerance*limit + 4.0_wp*epsilon(1.0_wp)*trial) exit
         if (residual > 0.0_wp) then
            lower = increment
         else
            upper = increment
         end if
         increment = increment + residual/(3.0_wp*law%shear + slope)
         if (.not. (increment > lower .and. increment < upper)) increment = 0.5_wp*(lower + upper)
      end do
   end subroutine flow

   !> Yield stress, and its derivative to the plastic increment.
   pure subroutine yield_stress(law, strain, increment, dt, softening, limit, slope)
      class(law_johnson_cook_t), intent(in) :: law
      real(wp), intent(in) :: strain                 !! Equivalent plastic strain after [1]
      real(wp), intent(in) :: increment              !! Increment of plastic strain, above 0 [1]
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: softening              !! Factor of temperature [1]
      real(wp), intent(out) :: limit                 !! Yield stress [Pa]
      real(wp), intent(out) :: slope                 !! Its derivative [Pa]
      real(wp) :: hardening, rate, factor

      hardening = law%hardening*strain**law%exponent
      rate = increment/(dt*law%reference_rate)
      factor = softening
      slope = 0.0_wp
      if (rate > 1.0_wp) then
         factor = softening*(1.0_wp + law%rate_coefficient*log(rate))
         slope = softening*law%rate_coefficient/increment
      end if
      slope = slope*(law%yield + hardening) + factor*law%exponent*hardening/strain
      limit = factor*(law%yield + hardening)
   end subroutine yield_stress
end module law_johnson_cook
