! SPDX-License-Identifier: BSD-3-Clause
!> Contact laws of grains: a spring and a dashpot along the line of centres, a spring with a slider
!! across it.
!!
!! Both laws are one formula, (G.4), with a stiffness factor q of the overlap: the normal spring is
!! k_n = normal q, the tangential one k_t = tangential q, the dashpot g = damping sqrt(q m) with the
!! reduced mass m. Linear: q = 1 (P. A. Cundall, O. D. L. Strack, Geotechnique 29 (1979) 47). Hertz
!! and Mindlin: q = sqrt(R overlap) with the reduced radius R, normal = 4/3 E, tangential = 8 G of
!! the pair (K. L. Johnson, Contact Mechanics, 1985, eq. 4.23 and 7.42); its damping gives a
!! restitution that does not depend on the speed (Y. Tsuji and others, Powder Technology 71 (1992)
!! 239).
!!
!! Equations of doc/theory/grains.md.
module grains_law
   use base_constants, only: pi
   use base_kinds, only: wp
   implicit none
   private

   public :: contact_law_t, hertz_law, linear_law

   !> A contact law.
   type :: contact_law_t
      logical :: hertz = .false.                     !! Does q depend on the overlap?
      real(wp) :: normal = 0.0_wp                    !! k_n/q: linear [N/m], Hertz [Pa]
      real(wp) :: tangential = 0.0_wp                !! k_t/q, in the same units
      real(wp) :: damping = 0.0_wp                   !! g/sqrt(q m), from the restitution
      real(wp) :: friction = 0.0_wp                  !! Coefficient of Coulomb friction [1]
      real(wp) :: stored = 0.5_wp                    !! Energy of the normal spring/(k_n overlap^2)
   contains
      procedure :: duration => law_duration          !! Duration of a collision [s]
      procedure :: modulus => law_modulus            !! Approximate modulus of a dense packing [Pa]
   end type contact_law_t

contains

   !> Linear springs. A collision multiplies the speed of approach by the restitution
   !! e = exp(-g t/2m).
   pure function linear_law(stiffness, ratio, restitution, friction) result(law)
      real(wp), intent(in) :: stiffness              !! k_n [N/m]
      real(wp), intent(in) :: ratio                  !! k_t/k_n [1]
      real(wp), intent(in) :: restitution            !! e, > 0 and <= 1
      real(wp), intent(in) :: friction               !! [1]
      type(contact_law_t) :: law

      law%normal = stiffness
      law%tangential = ratio*stiffness
      law%damping = -2.0_wp*log(restitution)*sqrt(stiffness/(pi**2 + log(restitution)**2))
      law%friction = friction
   end function linear_law

   !> Hertz spheres of one elastic material.
   pure function hertz_law(young, poisson, restitution, friction) result(law)
      real(wp), intent(in) :: young !! Young's modulus of the material of the grains [Pa]
      real(wp), intent(in) :: poisson                !! [1]
      real(wp), intent(in) :: restitution            !! e, > 0 and <= 1
      real(wp), intent(in) :: friction               !! [1]
      type(contact_law_t) :: law
      real(wp) :: pair, shear

      pair = 0.5_wp*young/(1.0_wp - poisson**2)
      shear = 0.25_wp*young/((1.0_wp + poisson)*(2.0_wp - poisson))
      law%hertz = .true.
      law%normal = 4.0_wp/3.0_wp*pair
      law%tangential = 8.0_wp*shear
      ! the dashpot of Tsuji and others on the tangent stiffness 3/2 k_n
      law%damping = -2.0_wp*sqrt(5.0_wp/6.0_wp)*log(restitution) &
         /sqrt(pi**2 + log(restitution)**2)*sqrt(1.5_wp*law%normal)
      law%friction = friction
      law%stored = 0.4_wp
   end function hertz_law

   !> Duration of a collision [s]. Linear: half a period of the damped oscillator. Hertz: 2.868
   !! (m^2/(E^2 R v))^(1/5) (K. L. Johnson, Contact Mechanics, eq. 11.24).
   pure real(wp) function law_duration(self, mass, radius, speed) result(duration)
      class(contact_law_t), intent(in) :: self
      real(wp), intent(in) :: mass                   !! Reduced mass of the pair [kg]
      real(wp), intent(in) :: radius                 !! Reduced radius of the pair [m]
      real(wp), intent(in) :: speed                  !! Speed of approach, needed for Hertz [m/s]
      real(wp), parameter :: hertz_factor = 2.86802_wp
      real(wp) :: pair

      if (self%hertz) then
         pair = 0.75_wp*self%normal
         duration = hertz_factor*(mass**2/(pair**2*radius*speed))**0.2_wp
      else
         duration = pi/sqrt(self%normal/mass - 0.25_wp*self%damping**2/mass)
      end if
   end function law_duration

   !> Modulus of a dense packing, roughly: stress over strain of one contact per grain [Pa].
   pure real(wp) function law_modulus(self, dimension, diameter, pressure) result(modulus)
      class(contact_law_t), intent(in) :: self
      integer, intent(in) :: dimension               !! 2: discs of 1 m thickness
      real(wp), intent(in) :: diameter               !! [m]
      real(wp), intent(in) :: pressure               !! For Hertz [Pa]
      real(wp), parameter :: third = 1.0_wp/3.0_wp

      if (self%hertz) then
         modulus = self%normal*(pressure/self%normal)**third
      else if (dimension == 2) then
         modulus = self%normal
      else
         modulus = self%normal/diameter
      end if
   end function law_modulus
end module grains_law
