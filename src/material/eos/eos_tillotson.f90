! SPDX-License-Identifier: BSD-3-Clause
!> Equation of state of J. H. Tillotson (General Atomic report GA-3216, 1962) for impacts from solid
!! to vapour, in the form of H. J. Melosh, "Impact cratering", 1989, appendix II.
!!
!! With eta = rho/rho0, mu = eta - 1, w = 1 + e/(e0 eta**2): condensed, for mu >= 0 or e <= e_iv,
!! p = (a + b/w) rho e + A mu + B mu**2, where for mu < 0 the last two are A/2 eta (eta**2 - 1);
!! expanded, for mu < 0 and e >= e_cv, with x = 1/eta - 1, p = a rho e + (b rho e/w + A mu exp(-beta
!! x)) exp(-alpha x**2); between the two energies linear in e from one to the other. The published
!! form has A mu for all mu < 0: its tension does not vanish as the density tends to 0. Equations
!! (E.10), (E.11) and (E.12) of doc/theory/equations_of_state.md.
module eos_tillotson
   use base_elementary, only: exponential
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: in_order
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_tillotson_t

   !> Lower bound of the sound speed, relative to that of the reference state. The square of it is
   !! negative in material expanded beyond its greatest tension, which is unstable (spinodal).
   real(wp), parameter :: least_sound = 0.1_wp

   !> Equation of state of Tillotson.
   type, extends(eos_t) :: eos_tillotson_t
      real(wp) :: a = 0.5_wp                         !! a [1]
      real(wp) :: b = 0.0_wp                         !! b [1]
      real(wp) :: square = 0.0_wp                    !! B [Pa]; A is the bulk modulus
      real(wp) :: alpha = 5.0_wp                     !! alpha [1]
      real(wp) :: beta = 5.0_wp                      !! beta [1]
      real(wp) :: energy = 0.0_wp                    !! e0 [J/kg]
      real(wp) :: melt = 0.0_wp                      !! e_iv, vapour begins [J/kg]
      real(wp) :: vapour = 0.0_wp                    !! e_cv, vapour alone [J/kg]
   contains
      procedure :: declare => tillotson_declare      !! Declares its keys
      procedure :: fault => tillotson_fault          !! Energies in the wrong order
      procedure :: read => tillotson_read            !! Reads its keys
      procedure :: request => tillotson_request      !! Requests the energy field
      procedure :: update => tillotson_update        !! Pressure and square of the sound speed
      procedure :: find_gruneisen => tillotson_find_gruneisen !! Grueneisen number times density
      procedure :: cold_temperature => tillotson_cold_temperature !! Energy 0 at t_ref
   end type eos_tillotson_t

contains

   !> Declare the keys of the equation of state.
   subroutine tillotson_declare(self, schema)
      class(eos_tillotson_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.eos & eos_model = tillotson"

      call schema%real("material", "till_a", "Tillotson a", range="> 0", owner=owner)
      call schema%real("material", "till_b", "Tillotson b", range=">= 0", owner=owner)
      call schema%real("material", "till_bulk", "Tillotson A, bulk modulus", unit="Pa", &
         range="> 0", owner=owner)
      call schema%real("material", "till_square", "Tillotson B", unit="Pa", range=">= 0", &
         owner=owner)
      call schema%real("material", "till_alpha", "Tillotson alpha", range=">= 0", owner=owner)
      call schema%real("material", "till_beta", "Tillotson beta", range=">= 0", owner=owner)
      call schema%real("material", "till_e0", "Tillotson e0", unit="J/kg", range="> 0", owner=owner)
      call schema%real("material", "till_eiv", &
         "Tillotson eiv, energy at which expanded material begins to vaporise", unit="J/kg", &
         range="> 0", owner=owner)
      call schema%real("material", "till_ecv", &
         "Tillotson ecv, energy at which expanded material is completely vaporised", unit="J/kg", &
         range="> 0", owner=owner)
      call schema%require("material", "till_a till_b till_bulk till_square till_alpha "// &
         "till_beta till_e0 till_eiv till_ecv")
   end subroutine tillotson_declare

   !> Boiling must begin before it ends.
   pure function tillotson_fault(self, group) result(text)
      class(eos_tillotson_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: text

      text = ""
      if (.not. in_order(group, "till_eiv", "till_ecv")) &
         text = "till_ecv must be above till_eiv [D363]"
   end function tillotson_fault

   !> Read the keys of the equation of state.
   pure subroutine tillotson_read(self, group)
      class(eos_tillotson_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material

      call group%get("till_a", self%a)
      call group%get("till_b", self%b)
      call group%get("till_bulk", self%bulk)
      call group%get("till_square", self%square)
      call group%get("till_alpha", self%alpha)
      call group%get("till_beta", self%beta)
      call group%get("till_e0", self%energy)
      call group%get("till_eiv", self%melt)
      call group%get("till_ecv", self%vapour)
   end subroutine tillotson_read

   !> The pressure depends on energy.
   pure subroutine tillotson_request(self, requests)
      class(eos_tillotson_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "equation of state tillotson", 1)
   end subroutine tillotson_request

   !> Pressure and square of the sound speed, dp/drho + p/rho**2 dp/de: (E.1). Few particles boil or
   !! are vapour, and only these need exponentials, one by one.
   pure subroutine tillotson_update(self, state, deformation, first, last)
      class(eos_tillotson_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: density, to_density, to_energy
      integer :: i, k

      call condense(self, state, deformation, first, last)
      if (count(.not. state%energy(first:last) <= self%melt) == 0) return
      do i = 1, last - first + 1
         k = first - 1 + i
         if (state%energy(k) <= self%melt .or. state%mass(k) >= self%density*state%volume(k)) cycle
         density = state%mass(k)/state%volume(k)
         call find_state(self, density, state%energy(k), deformation%pressure(i), to_density, &
            to_energy)
         deformation%wave_speed(i) = max(least_sound**2*self%bulk/self%density, &
            to_density + deformation%pressure(i)/density**2*to_energy)
      end do
   end subroutine tillotson_update

   !> The same of condensed material. The loop becomes one of vectors only if the type is known.
   pure subroutine condense(eos, state, deformation, first, last)
      type(eos_tillotson_t), intent(in) :: eos             !! Constants
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: dense(3), density, inverse
      integer :: i, k

      !$omp simd private(dense, density, inverse, k)
      do i = 1, last - first + 1
         k = first - 1 + i
         density = state%mass(k)/state%volume(k)
         inverse = state%volume(k)/state%mass(k)
         call find_dense_state(eos, density, inverse, state%energy(k), dense)
         deformation%pressure(i) = dense(1)
         deformation%wave_speed(i) = max(least_sound**2*eos%bulk/eos%density, &
            dense(2) + dense(1)*inverse*inverse*dense(3))
      end do
   end subroutine condense

   !> Pressure of condensed material, and its derivatives to density and energy.
   pure subroutine find_dense_state(eos, density, inverse, given, dense)
      type(eos_tillotson_t), intent(in) :: eos       !! Constants
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: inverse                !! 1 over it [m3/kg]
      real(wp), intent(in) :: given                  !! Energy [J/kg]
      real(wp), intent(out) :: dense(3) !! Pressure [Pa], derivatives [m2/s2] and [kg/m3]
      real(wp) :: eta, mu, e, part, rest, cold, stiff

      ! Finite steps can leave a small negative energy.
      e = max(given, 0.0_wp)
      eta = density/eos%density
      mu = eta - 1.0_wp
      rest = e*(eos%density**2/eos%energy)*inverse*inverse
      part = 1.0_wp/(1.0_wp + rest)
      cold = eos%bulk*merge(1.0_wp, 0.5_wp*eta*(eta + 1.0_wp), mu >= 0.0_wp)*mu
      stiff = eos%bulk*merge(1.0_wp, 1.5_wp*eta*eta - 0.5_wp, mu >= 0.0_wp)/eos%density
      ! The square of compression, 0 in expansion.
      mu = max(mu, 0.0_wp)
      cold = cold + eos%square*mu*mu
      stiff = stiff + 2.0_wp*eos%square*mu/eos%density
      dense(1) = (eos%a + eos%b*part)*density*e + cold
      dense(2) = (eos%a + eos%b*part*(1.0_wp + 2.0_wp*rest*part))*e + stiff
      dense(3) = merge((eos%a + eos%b*part*part)*density, 0.0_wp, given >= 0.0_wp)
   end subroutine find_dense_state

   !> Grueneisen parameter (a + b/w**2) of condensed material times density at the middle of the
   !! step. In vapour b/w**2 is small.
   pure subroutine tillotson_find_gruneisen(self, state, deformation, first, last)
      class(eos_tillotson_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: density, w
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         density = 2.0_wp*state%mass(k)/(state%volume(k) + deformation%old_volume(i))
         w = 1.0_wp + max(state%energy(k), 0.0_wp)*(self%density/density)**2/self%energy
         deformation%gruneisen(i) = (self%a + self%b/w**2)*density
      end do
   end subroutine tillotson_find_gruneisen

   !> Pressure of a state, and its derivatives to density and energy.
   pure subroutine find_state(eos, density, given, pressure, to_density, to_energy)
      type(eos_tillotson_t), intent(in) :: eos       !! Constants
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: given                  !! Energy [J/kg]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp), intent(out) :: to_density            !! dp/drho [m2/s2]
      real(wp), intent(out) :: to_energy             !! dp/de [kg/m3]
      real(wp) :: eta, mu, e, w, dense(3), thin(3), share, fade, tail, x

      call find_dense_state(eos, density, 1.0_wp/density, given, dense)
      pressure = dense(1)
      to_density = dense(2)
      to_energy = dense(3)
      e = max(given, 0.0_wp)
      eta = density/eos%density
      mu = eta - 1.0_wp
      share = 0.0_wp
      if (mu < 0.0_wp) &
         share = min(1.0_wp, max(0.0_wp, (e - eos%melt)/(eos%vapour - eos%melt)))
      if (share <= 0.0_wp) return
      w = 1.0_wp + e/(eos%energy*eta**2)
      x = 1.0_wp/eta - 1.0_wp
      fade = exponential(-eos%alpha*x**2)
      tail = exponential(-eos%beta*x)
      thin(1) = (eos%b*density*e/w + eos%bulk*mu*tail)*fade
      thin(2) = eos%a*e + 2.0_wp*eos%alpha*x/(eos%density*eta**2)*thin(1) &
         + ((eos%b/w + 2.0_wp*eos%b*(w - 1.0_wp)/w**2)*e &
         + eos%bulk*tail/eos%density*(1.0_wp + eos%beta*mu/eta**2))*fade
      thin(1) = thin(1) + eos%a*density*e
      thin(3) = (eos%a + eos%b/w**2*fade)*density
      pressure = (1.0_wp - share)*dense(1) + share*thin(1)
      to_density = (1.0_wp - share)*dense(2) + share*thin(2)
      to_energy = (1.0_wp - share)*dense(3) + share*thin(3)
      if (share < 1.0_wp) to_energy = to_energy + (thin(1) - dense(1))/(eos%vapour - eos%melt)
   end subroutine find_state

   !> Heat above the reference temperature is part of the energy.
   pure real(wp) function tillotson_cold_temperature(self, reference) result(temperature)
      class(eos_tillotson_t), intent(in) :: self
      real(wp), intent(in) :: reference              !! Reference temperature of the material [K]

      temperature = reference
   end function tillotson_cold_temperature
end module eos_tillotson
