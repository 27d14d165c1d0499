! SPDX-License-Identifier: BSD-3-Clause
!> Equation of state of Mie and Grueneisen about a linear Hugoniot Us = c0 + s up.
!!
!! With y = rho/rho0, eta = 1 - 1/y and K = rho0 c0**2, in compression (y > 1) p = pH (1 - Gamma0
!! eta/2) + Gamma0 rho0 e with pH = K eta/(1 - s eta)**2. In expansion (y < 1) the cold material has
!! the energy c0**2 (1 - y)**2/2 and the pressure K y**2 (y - 1), and heat above it adds Gamma rho
!! heat, where Gamma changes from Gamma0 to its value in the vapour. Equations (E.6), (E.7),
!! (E.8) and (E.9) of doc/theory/equations_of_state.md.
module eos_mie_gruneisen
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_mie_gruneisen_t, mie_gruneisen_state

   !> Beyond this fraction of the greatest compression the reference curve continues linearly in the
   !! density, because 1 - s eta, or the slope of the curve, would come too close to 0.
   real(wp), parameter :: share_of_limit = 0.9_wp
   !> Lower bound of the sound speed, relative to c0. The square of it is negative in cold material
   !! expanded beyond its greatest tension, which is unstable (spinodal).
   real(wp), parameter :: least_sound = 0.1_wp
   !> Grueneisen parameter of vapour, at most 2 Gamma0. It is the least value for which the sound
   !! speed of expanded material without tension is real (for Gamma0 >= 1/2).
   real(wp), parameter :: gamma_of_vapour = 1.0_wp

   !> Equation of state of Mie and Grueneisen.
   type, extends(eos_t) :: eos_mie_gruneisen_t
      real(wp) :: sound = 0.0_wp                     !! c0 [m/s]
      real(wp) :: slope = 0.0_wp                     !! s [1]
      real(wp) :: gamma = 0.0_wp                     !! Gamma0 [1]
   contains
      procedure :: declare => mie_gruneisen_declare  !! Declares its keys
      procedure :: read => mie_gruneisen_read        !! Reads its keys
      procedure :: request => mie_gruneisen_request  !! Requests the energy field
      procedure :: update => mie_gruneisen_update    !! Pressure and square of the sound speed
      procedure :: find_gruneisen => mie_gruneisen_find_gruneisen !! Grueneisen number times density
      procedure :: cold_temperature => mie_gruneisen_cold_temperature !! Energy 0 at t_ref
   end type eos_mie_gruneisen_t

   interface eos_mie_gruneisen_t
      module procedure mie_gruneisen_of
   end interface eos_mie_gruneisen_t

contains

   !> Equation of state with derived numbers.
   pure function mie_gruneisen_of(density, sound, slope, gamma) result(eos)
      real(wp), intent(in) :: density                !! Density of the reference state [kg/m3]
      real(wp), intent(in) :: sound                  !! c0 [m/s]
      real(wp), intent(in) :: slope                  !! s [1]
      real(wp), intent(in) :: gamma                  !! Gamma0 [1]
      type(eos_mie_gruneisen_t) :: eos

      eos%density = density
      eos%sound = sound
      eos%slope = slope
      eos%gamma = gamma
      eos%bulk = density*sound**2
   end function mie_gruneisen_of

   !> Declare the keys of the equation of state.
   subroutine mie_gruneisen_declare(self, schema)
      class(eos_mie_gruneisen_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.eos & eos_model = mie_gruneisen p_alpha"

      call schema%real("material", "mg_c0", "Mie-Grueneisen c0 of Us = c0 + s up", unit="m/s", &
         range="> 0", owner=owner)
      call schema%real("material", "mg_s", "Mie-Grueneisen s of Us = c0 + s up", &
         range=">= 0", owner=owner)
      call schema%real("material", "mg_gamma", "Grueneisen parameter at the reference density", &
         range=">= 0", owner=owner)
      call schema%require("material", "mg_c0 mg_s mg_gamma")
   end subroutine mie_gruneisen_declare

   !> Read the keys of the equation of state.
   pure subroutine mie_gruneisen_read(self, group)
      class(eos_mie_gruneisen_t), intent(inout) :: self
      type(group_t), intent(in) :: group                !! &material

      call group%get("mg_c0", self%sound)
      call group%get("mg_s", self%slope)
      call group%get("mg_gamma", self%gamma)
      self%bulk = self%density*self%sound**2
   end subroutine mie_gruneisen_read

   !> The pressure depends on energy.
   pure subroutine mie_gruneisen_request(self, requests)
      class(eos_mie_gruneisen_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "equation of state mie_gruneisen", 1)
   end subroutine mie_gruneisen_request

   !> Pressure and square of the sound speed.
   pure subroutine mie_gruneisen_update(self, state, deformation, first, last)
      class(eos_mie_gruneisen_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: density, sound, slope, gamma
      integer :: i, k

      density = self%density
      sound = self%sound
      slope = self%slope
      gamma = self%gamma
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         call mie_gruneisen_state(density, sound, slope, gamma, density*state%volume(k) &
            /state%mass(k), state%energy(k), deformation%pressure(i), deformation%wave_speed(i))
      end do
   end subroutine mie_gruneisen_update

   !> Pressure and square of the sound speed, dp/drho + p/rho**2 dp/de, of one state. Without
   !! branches, so that loops over it vectorise. Equations (E.1) and (E.6) to (E.9).
   pure subroutine mie_gruneisen_state(density, sound, slope, gamma, ratio, energy, pressure, &
      square)
      real(wp), intent(in) :: density                !! Density of the reference state [kg/m3]
      real(wp), intent(in) :: sound                  !! c0 [m/s]
      real(wp), intent(in) :: slope                  !! s [1]
      real(wp), intent(in) :: gamma                  !! Gamma0 [1]
      real(wp), intent(in) :: ratio                  !! rho0/rho [1]
      real(wp), intent(in) :: energy                 !! [J/kg]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp), intent(out) :: square                !! Square of the sound speed [m2/s2]
      real(wp) :: stiff, curvature, vapour, most, y, z, d, clipped, reserve, tangent, shock
      real(wp) :: number, heat, warm

      stiff = sound**2
      curvature = max(2.0_wp*gamma - gamma_of_vapour, 0.0_wp)
      vapour = 2.0_wp*gamma - curvature
      most = share_of_limit/max(slope, 1.0_wp, gamma - slope)
      y = 1.0_wp/ratio
      ! Expansion d, 0 in compression. All pressures are over rho0 up to the last line.
      z = min(y, 1.0_wp)
      d = max(1.0_wp - y, 0.0_wp)
      ! Compression, clipped to the limit and 0 in expansion.
      clipped = max(0.0_wp, min(1.0_wp - ratio, most))
      reserve = 1.0_wp/(1.0_wp - slope*clipped)
      ! Derivative of pH (1 - Gamma0 eta/2) to eta; at eta = 0 it is K.
      tangent = stiff*(1.0_wp + (slope - gamma)*clipped)*reserve**3
      shock = stiff*clipped*reserve**2*(1.0_wp - 0.5_wp*gamma*clipped) &
         + tangent*(1.0_wp - most)**2*max(y - 1.0_wp/(1.0_wp - most), 0.0_wp)
      number = gamma*(1.0_wp + d) - curvature*d*d
      heat = energy - 0.5_wp*stiff*d*d
      warm = shock + z*number*heat
      pressure = density*(warm - stiff*z*z*d)
      ! d eta/dy = ratio**2 in compression.
      square = tangent*max(min(1.0_wp, ratio), 1.0_wp - most)**2*z*(3.0_wp*z - 2.0_wp) &
         + heat*d*(vapour + 3.0_wp*curvature*z) + number*warm*ratio*min(1.0_wp, ratio)
      square = max(least_sound**2*stiff, square)
   end subroutine mie_gruneisen_state

   !> Grueneisen parameter times density at the middle of the step. Equation (E.8).
   pure subroutine mie_gruneisen_find_gruneisen(self, state, deformation, first, last)
      class(eos_mie_gruneisen_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: curvature, z, d
      integer :: i, k

      curvature = max(2.0_wp*self%gamma - gamma_of_vapour, 0.0_wp)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         z = min(2.0_wp*state%mass(k)/(self%density*(state%volume(k) &
            + deformation%old_volume(i))), 1.0_wp)
         d = 1.0_wp - z
         deformation%gruneisen(i) = self%density*z*(self%gamma*(1.0_wp + d) - curvature*d*d)
      end do
   end subroutine mie_gruneisen_find_gruneisen

   !> Heat above the reference temperature is part of the energy.
   pure real(wp) function mie_gruneisen_cold_temperature(self, reference) result(temperature)
      class(eos_mie_gruneisen_t), intent(in) :: self
      real(wp), intent(in) :: reference              !! Reference temperature of the material [K]

      temperature = reference
   end function mie_gruneisen_cold_temperature
end module eos_mie_gruneisen
