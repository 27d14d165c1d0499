! SPDX-License-Identifier: BSD-3-Clause
!> Equation of state of Mie and Grueneisen about a linear Hugoniot Us = c0 + s up.
!!
!! With eta = 1 - rho0/rho and Gamma rho = Gamma0 rho0: in compression
!! p = pH (1 - Gamma0 eta/2) + Gamma0 rho0 e with pH = rho0 c0**2 eta/(1 - s eta)**2, in expansion
!! p = rho0 c0**2 (rho/rho0 - 1) + Gamma0 rho0 e. Equation (E.5) of
!! doc/theory/equations_of_state.md.
module eos_mie_gruneisen
   use base_deck_group, only: group_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use material_eos, only: eos_t
   use material_matter, only: deformation_t, matter_t
   use material_wishes, only: wishes_t
   implicit none
   private

   public :: eos_mie_gruneisen_t, mie_gruneisen_state

   !> Beyond this share of the greatest compression 1/s the cold pressure goes on along its tangent,
   !! as 1 - s eta would come too close to 0.
   real(wp), parameter :: share_of_limit = 0.9_wp
   !> The sound speed is not let fall below this share of c0, in states that no matter reaches.
   real(wp), parameter :: least_sound = 0.1_wp

   !> Equation of state of Mie and Grueneisen.
   type, extends(eos_t) :: eos_mie_gruneisen_t
      real(wp) :: sound = 0.0_wp                     !! c0 [m/s]
      real(wp) :: slope = 0.0_wp                     !! s [1]
      real(wp) :: gamma = 0.0_wp                     !! Gamma0 [1]
   contains
      procedure :: declare => mie_gruneisen_declare  !! Declares its keys
      procedure :: read => mie_gruneisen_read        !! Reads its keys
      procedure :: sets_bulk => mie_gruneisen_sets_bulk !! It does
      procedure :: request => mie_gruneisen_request  !! Asks for energy
      procedure :: update => mie_gruneisen_update    !! Pressure and square of the sound speed
      procedure :: stored => mie_gruneisen_stored    !! Nothing, energy is carried
   end type eos_mie_gruneisen_t

   interface eos_mie_gruneisen_t
      module procedure mie_gruneisen_of
   end interface eos_mie_gruneisen_t

contains

   !> Equation of state with derived numbers.
   pure function mie_gruneisen_of(density, sound, slope, gamma) result(eos)
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      real(wp), intent(in) :: sound                  !! c0 [m/s]
      real(wp), intent(in) :: slope                  !! s [1]
      real(wp), intent(in) :: gamma                  !! Gamma0 [1]
      type(eos_mie_gruneisen_t) :: eos

      eos%density = density
      eos%sound = sound
      eos%slope = slope
      eos%gamma = gamma
      eos%bulk = density*sound**2
      eos%gamma_density = gamma*density
   end function mie_gruneisen_of

   !> Declare the keys of the equation of state.
   subroutine mie_gruneisen_declare(self, schema)
      class(eos_mie_gruneisen_t), intent(in) :: self !! The equation of state
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      character(len=*), parameter :: owner = "effects.eos & eos_model = mie_gruneisen p_alpha"

      call schema%real("material", "mg_c0", "Mie-Grueneisen c0 of Us = c0 + s up", unit="m/s", &
         range="> 0", owner=owner)
      call schema%real("material", "mg_s", "Mie-Grueneisen s of Us = c0 + s up", &
         range=">= 0", owner=owner)
      call schema%real("material", "mg_gamma", "Grueneisen number at the reference density", &
         range=">= 0", owner=owner)
      call schema%require("material", "mg_c0 mg_s mg_gamma")
   end subroutine mie_gruneisen_declare

   !> Read the keys of the equation of state.
   pure subroutine mie_gruneisen_read(self, group)
      class(eos_mie_gruneisen_t), intent(inout) :: self !! The equation of state
      type(group_t), intent(in) :: group                !! &material

      call group%get("mg_c0", self%sound)
      call group%get("mg_s", self%slope)
      call group%get("mg_gamma", self%gamma)
      self%bulk = self%density*self%sound**2
      self%gamma_density = self%gamma*self%density
   end subroutine mie_gruneisen_read

   !> The bulk modulus is that of c0.
   pure logical function mie_gruneisen_sets_bulk(self) result(sets)
      class(eos_mie_gruneisen_t), intent(in) :: self !! The equation of state

      sets = .true.
   end function mie_gruneisen_sets_bulk

   !> The pressure depends on energy.
   pure subroutine mie_gruneisen_request(self, wishes)
      class(eos_mie_gruneisen_t), intent(in) :: self     !! The equation of state
      class(wishes_t), intent(inout) :: wishes       !! Fields to be carried

      call wishes%ask("energy", "equation of state mie_gruneisen", 1)
   end subroutine mie_gruneisen_request

   !> Pressure and square of the sound speed.
   pure subroutine mie_gruneisen_update(self, matter, deformation, first, last)
      class(eos_mie_gruneisen_t), intent(in) :: self           !! The equation of state
      type(matter_t), intent(in) :: matter                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range

      call pressure_of_state(first, last, self%density, self%sound, self%slope, self%gamma, &
         matter%mass, matter%volume, matter%energy, deformation%pressure, deformation%wave_speed)
   end subroutine mie_gruneisen_update

   !> Kernel of the above.
   pure subroutine pressure_of_state(first, last, density, sound, slope, gamma, mass, volume, &
      energy, pressure, wave_speed)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      real(wp), intent(in) :: sound                  !! c0 [m/s]
      real(wp), intent(in) :: slope                  !! s [1]
      real(wp), intent(in) :: gamma                  !! Gamma0 [1]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(in) :: energy(:)  !! (store) [J/kg]
      real(wp), contiguous, intent(inout) :: pressure(:)   !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: wave_speed(:) !! Square of sound speed (range) [m2/s2]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         call mie_gruneisen_state(density, sound, slope, gamma, density*volume(k)/mass(k), &
            energy(k), pressure(i), wave_speed(i))
      end do
   end subroutine pressure_of_state

   !> Pressure and square of the sound speed, dp/drho + max(p, 0)/rho**2 dp/de, of one state.
   !! Equations (E.1), (E.5) and (E.6).
   pure subroutine mie_gruneisen_state(density, sound, slope, gamma, ratio, energy, pressure, &
      square)
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      real(wp), intent(in) :: sound                  !! c0 [m/s]
      real(wp), intent(in) :: slope                  !! s [1]
      real(wp), intent(in) :: gamma                  !! Gamma0 [1]
      real(wp), intent(in) :: ratio                  !! rho0/rho [1]
      real(wp), intent(in) :: energy                 !! [J/kg]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp), intent(out) :: square                !! Square of the sound speed [m2/s2]
      real(wp) :: bulk, most, eta, clipped, reserve, tangent, cold

      bulk = density*sound**2
      most = share_of_limit/max(slope, 1.0_wp)
      eta = 1.0_wp - ratio
      clipped = max(0.0_wp, min(eta, most))
      reserve = 1.0_wp/(1.0_wp - slope*clipped)
      ! Derivative of pH (1 - Gamma0 eta/2) to eta; at eta = 0 it is K.
      tangent = bulk*(1.0_wp + (slope - gamma)*clipped)*reserve**3
      cold = bulk*clipped*reserve**2*(1.0_wp - 0.5_wp*gamma*clipped) &
         + tangent*max(eta - most, 0.0_wp) + bulk*min(eta, 0.0_wp)/ratio
      pressure = cold + gamma*density*energy
      ! deta/drho = ratio**2/rho0 in compression, and in expansion dp/drho = K/rho0.
      square = max(least_sound**2*sound**2, (tangent*min(1.0_wp, ratio)**2 &
         + max(pressure, 0.0_wp)*gamma*ratio**2)/density)
   end subroutine mie_gruneisen_state

   !> The energy is carried by the particles.
   pure real(wp) function mie_gruneisen_stored(self, mass, volume, limit) result(energy)
      class(eos_mie_gruneisen_t), intent(in) :: self     !! The equation of state
      real(wp), intent(in) :: mass                   !! [kg]
      real(wp), intent(in) :: volume                 !! [m3]
      real(wp), intent(in) :: limit                  !! Least pressure [Pa]

      energy = 0.0_wp
   end function mie_gruneisen_stored
end module eos_mie_gruneisen
