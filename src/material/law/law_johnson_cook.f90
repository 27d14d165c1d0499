! SPDX-License-Identifier: BSD-3-Clause
!> Flow stress of Johnson and Cook (1983): (A + B ep**n) (1 + C ln(rate/rate0)) (1 - T***m).
!!
!! The logarithm is not less than 0, so that slow flow is not weaker than the static yield stress.
!! Equation (Y.4) of doc/theory/strength.md.
module law_johnson_cook
   use base_constants, only: most_lanes
   use base_elementary, only: take_fast_powers
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_hardening, only: collect_lanes, flow_lanes_t, hardening_power_t, &
      move_flow_results, solve_hardening
   use material_heat, only: homologous_temperature, melting_range_t, read_melting_range
   use material_law, only: equivalent_stress, law_t, strain_trial
   use material_state, only: deformation_t, material_state_t
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
      procedure :: uses_jc_rate => johnson_cook_uses_jc_rate !! Returns true
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

   !> Return to the yield surface, group by group.
   pure subroutine johnson_cook_update(self, state, deformation, first, last, dt)
      class(law_johnson_cook_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      type(flow_lanes_t) :: lanes
      type(hardening_power_t) :: power
      real(wp) :: least
      integer :: i, n, offset

      n = last - first + 1
      call equivalent_stress(state, deformation, first, last)
      call homologous_temperature(self%range, state, deformation, first, last)
      ! Bound of the yield stress without its powers. In most tiles nothing is above it.
      least = merge(self%yield, 0.0_wp, self%softening_exponent >= 1.0_wp)
      do concurrent (i=1:n)
         deformation%strength%tangent(i) = least*(1.0_wp - deformation%strength%homologous(i))
      end do
      if (count(deformation%plastic_increment(1:n) > deformation%strength%tangent(1:n)) == 0) then
         deformation%plastic_increment(1:n) = 0.0_wp
         return
      end if
      call strain_trial(state, deformation, first, last)
      power%exponent = self%exponent
      power%rate_coefficient = self%rate_coefficient
      if (power%rate_coefficient > 0.0_wp) power%rest = dt*self%reference_rate
      do offset = 0, n - 1, most_lanes
         call collect_lanes(offset, min(most_lanes, n - offset), deformation%strength%tangent, &
            deformation, lanes)
         if (lanes%count == 0) cycle
         call fill_lanes(self, offset, first - 1 + offset, state, deformation, lanes)
         call solve_hardening(power, lanes)
         call move_flow_results(offset, first - 1 + offset, lanes, state, deformation)
      end do
   end subroutine johnson_cook_update

   !> Yield stress and hardening of the lanes at their strain and temperature: factor 1 - T***m of
   !! the homologous temperature.
   pure subroutine fill_lanes(law, offset, before, state, deformation, lanes)
      class(law_johnson_cook_t), intent(in) :: law
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: before                  !! Index offset in the store
      type(material_state_t), intent(in) :: state    !! State of the store
      type(deformation_t), intent(in) :: deformation !! With the homologous temperature
      type(flow_lanes_t), intent(inout) :: lanes
      real(wp), parameter :: unbounded = 1.0e200_wp
      integer :: l

      do l = 1, lanes%count
         lanes%factor(l) = deformation%strength%homologous(offset + lanes%place(l))
         lanes%argument(l) = state%plastic_strain(before + lanes%place(l))
      end do
      lanes%stiffness(:lanes%count) = 3.0_wp*law%shear
      lanes%greatest(:lanes%count) = unbounded
      ! A power of one changes no bit.
      if (allocated(law%range) .and. abs(law%softening_exponent - 1.0_wp) > 0.0_wp) &
         call take_fast_powers(lanes%count, law%softening_exponent, lanes%factor)
      do concurrent (l=1:lanes%count)
         lanes%fixed(l) = law%yield*(1.0_wp - lanes%factor(l))
         lanes%amplitude(l) = law%hardening*(1.0_wp - lanes%factor(l))
      end do
   end subroutine fill_lanes
end module law_johnson_cook
