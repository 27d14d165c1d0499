! SPDX-License-Identifier: BSD-3-Clause
!> Equation of state of the products of a detonation, of Jones, Wilkins and Lee: with V = rho0/rho
!! and E the energy per volume of the reference state,
!!
!!    p = A (1 - w/(R1 V)) exp(-R1 V) + B (1 - w/(R2 V)) exp(-R2 V) + w E/V.
!!
!! E. L. Lee, H. C. Hornig, J. W. Kury, "Adiabatic expansion of high explosive detonation products",
!! UCRL-50422, 1968. Particles carry the chemical energy E0 from the start. Equations (X.1),
!! (X.2), (X.3), (X.4), (X.5) and (X.6) of doc/theory/explosives.md.
module eos_jwl
   use base_elementary, only: exponential, take_exponentials
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use material_effects, only: in_order
   use material_eos, only: eos_t, take_gruneisen
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_jwl_t

   !> Equation of state of detonation products.
   type, extends(eos_t) :: eos_jwl_t
      real(wp) :: stiff = 0.0_wp                     !! A [Pa]
      real(wp) :: soft = 0.0_wp                      !! B [Pa]
      real(wp) :: r1 = 1.0_wp                        !! R1 [1]
      real(wp) :: r2 = 1.0_wp                        !! R2 [1]
      real(wp) :: omega = 0.0_wp                     !! w, the Grueneisen number [1]
      real(wp) :: chemical = 0.0_wp                  !! E0, energy per reference volume [J/m3]
      real(wp) :: speed = 0.0_wp                     !! Detonation speed [m/s]
      real(wp) :: detonated = 1.0_wp                 !! V of the Chapman-Jouguet state [1]
   contains
      procedure :: declare => jwl_declare            !! Declares its keys
      procedure :: fault => jwl_fault                !! Constants in the wrong order
      procedure :: read => jwl_read                  !! Reads its keys
      procedure :: request => jwl_request            !! Requests the energy field
      procedure :: update => jwl_update              !! Pressure and square of the sound speed
      procedure :: find_gruneisen => jwl_find_gruneisen !! Grueneisen number times density
      procedure :: cold_temperature => jwl_cold_temperature !! Chemical energy alone at t_ref
      procedure :: starts_with_energy => jwl_starts_with_energy !! Returns true
      procedure :: start_energy => jwl_start_energy  !! Chemical energy
      procedure :: detonates => jwl_detonates        !! Returns true
      procedure :: detonation => jwl_detonation      !! Speed, and volume behind the front
      procedure :: chapman_jouguet_speed => jwl_chapman_jouguet_speed !! D of the constants
      procedure :: find_detonation => jwl_find_detonation !! Chapman-Jouguet state
   end type eos_jwl_t

contains

   !> Declare the keys of the equation of state.
   subroutine jwl_declare(self, schema)
      class(eos_jwl_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.eos & eos_model = jwl"

      call schema%real("material", "jwl_a", "JWL A", unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "jwl_b", "JWL B", unit="Pa", range=">= 0", owner=owner)
      call schema%real("material", "jwl_r1", "JWL R1", range="> 0", owner=owner)
      call schema%real("material", "jwl_r2", "JWL R2", range="> 0", owner=owner)
      call schema%real("material", "jwl_omega", "JWL omega, Grueneisen parameter of the products", &
         range="> 0 < 1", owner=owner)
      call schema%real("material", "jwl_e0", &
         "JWL E0, chemical energy per initial volume of the explosive", unit="Pa", range="> 0", &
         owner=owner)
      call schema%real("material", "detonation_speed", "detonation speed; default: that of the "// &
         "Chapman-Jouguet state given by the other constants", unit="m/s", range="> 0", owner=owner)
      call schema%real("material", "burn_cells", "width of the burn front in cells", &
         default="2.5", range=">= 0.5 <= 20", owner=owner)
      call schema%text("material", "burn_rule", "what burns the explosive: time, the arrival "// &
         "of a &detonation; both, the arrival or the compression, as in an overdriven detonation", &
         default="time", words="time both", owner=owner)
      call schema%allow_change("material", "burn_rule", changes_physics)
      call schema%forbid_change("material", "detonation_speed", "the particles of the "// &
         "checkpoint have the times at which they are ignited")
      call schema%forbid_change("material", "jwl_e0", "the particles of the checkpoint store "// &
         "this chemical energy")
      call schema%require("material", "jwl_a jwl_b jwl_r1 jwl_r2 jwl_omega jwl_e0")
   end subroutine jwl_declare

   !> The term of high pressure must fall the faster.
   pure function jwl_fault(self, group) result(text)
      class(eos_jwl_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: text

      text = ""
      if (.not. in_order(group, "jwl_r2", "jwl_r1")) text = &
         "jwl_r1 must be above jwl_r2; jwl_a and jwl_r1 are the term of high pressure [D320]"
   end function jwl_fault

   !> Read the keys of the equation of state.
   pure subroutine jwl_read(self, group)
      class(eos_jwl_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      real(wp) :: pressure, square

      call group%get("jwl_a", self%stiff)
      call group%get("jwl_b", self%soft)
      call group%get("jwl_r1", self%r1)
      call group%get("jwl_r2", self%r2)
      call group%get("jwl_omega", self%omega)
      call group%get("jwl_e0", self%chemical)
      call self%find_detonation(self%speed, pressure, self%detonated)
      if (group%given("detonation_speed")) call group%get("detonation_speed", self%speed)
      call find_state(self, 1.0_wp, self%chemical, pressure, square)
      self%bulk = self%density*square
   end subroutine jwl_read

   !> The pressure depends on energy.
   pure subroutine jwl_request(self, requests)
      class(eos_jwl_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "equation of state jwl", 1)
   end subroutine jwl_request

   !> Pressure and square of the sound speed.
   pure subroutine jwl_update(self, state, deformation, first, last)
      class(eos_jwl_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call product_pressure(first, last, self, state%mass, state%volume, state%energy, &
         deformation%pressure, deformation%wave_speed)
   end subroutine jwl_update

   !> Kernel of the above, equations (X.1) and (X.2). Finite steps can remove more energy than
   !! products of low density have; the energy term is then 0.
   pure subroutine product_pressure(first, last, eos, mass, volume, energy, pressure, wave_speed)
      integer, intent(in) :: first, last             !! Particles of the range
      type(eos_jwl_t), intent(in) :: eos             !! Constants
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(in) :: energy(:)  !! (store) [J/kg]
      real(wp), contiguous, intent(inout) :: pressure(:)   !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: wave_speed(:) !! Square of sound speed (range) [m2/s2]
      real(wp) :: relative, first_term, second_term, hot, share
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         relative = eos%density*volume(k)/mass(k)
         pressure(i) = -eos%r1*relative
         wave_speed(i) = -eos%r2*relative
      end do
      call take_exponentials(last - first + 1, pressure)
      call take_exponentials(last - first + 1, wave_speed)
      !$omp simd private(relative, first_term, second_term, hot, share, k)
      do i = 1, last - first + 1
         k = first - 1 + i
         relative = eos%density*volume(k)/mass(k)
         share = eos%omega/relative
         first_term = eos%stiff*pressure(i)
         second_term = eos%soft*wave_speed(i)
         hot = share*eos%density*max(energy(k), 0.0_wp)
         pressure(i) = first_term*(1.0_wp - share/eos%r1) &
            + second_term*(1.0_wp - share/eos%r2) + hot
         wave_speed(i) = max(0.0_wp, relative*relative/eos%density*( &
            first_term*(eos%r1 - share - share/(eos%r1*relative)) &
            + second_term*(eos%r2 - share - share/(eos%r2*relative)) &
            + hot/relative + merge(share*pressure(i), 0.0_wp, energy(k) >= 0.0_wp)))
      end do
   end subroutine product_pressure

   !> Pressure and square of the sound speed of one state.
   pure subroutine find_state(eos, relative, energy, pressure, square)
      type(eos_jwl_t), intent(in) :: eos
      real(wp), intent(in) :: relative               !! V [1]
      real(wp), intent(in) :: energy                 !! E, per reference volume [J/m3]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp), intent(out) :: square                !! [m2/s2]
      real(wp) :: found(1), speed(1)

      call product_pressure(1, 1, eos, [eos%density], [relative], [energy/eos%density], found, &
         speed)
      pressure = found(1)
      square = speed(1)
   end subroutine find_state

   !> Chapman-Jouguet state: where the Rayleigh line from the explosive at rest touches the
   !! Hugoniot of the products, D is least and D - u is the speed of sound. Equations (X.4), (X.5)
   !! and (X.6). The root is bracketed by states of strong and of weak detonations.
   pure subroutine jwl_find_detonation(self, speed, pressure, relative)
      class(eos_jwl_t), intent(in) :: self
      real(wp), intent(out) :: speed                 !! D [m/s]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp), intent(out) :: relative              !! V [1]
      integer, parameter :: halvings = 60
      real(wp) :: dense, thin, square
      integer :: n

      ! Below this volume shocks of any strength cannot compress the products.
      dense = 1.02_wp*self%omega/(2.0_wp + self%omega)
      thin = 1.0_wp
      do n = 1, halvings
         relative = 0.5_wp*(dense + thin)
         pressure = hugoniot_pressure(self, relative)
         call find_state(self, relative, &
            self%chemical + 0.5_wp*pressure*(1.0_wp - relative), pressure, square)
         if (self%density*square*(1.0_wp - relative) > pressure*relative**2) then
            dense = relative
         else
            thin = relative
         end if
      end do
      speed = sqrt(pressure/(self%density*(1.0_wp - relative)))
   end subroutine jwl_find_detonation

   !> Pressure [Pa] of the Hugoniot of the products that starts at the explosive: E = E0 + p (1 -
   !! V)/2 in the equation of state, solved for p.
   pure real(wp) function hugoniot_pressure(eos, relative) result(pressure)
      class(eos_jwl_t), intent(in) :: eos
      real(wp), intent(in) :: relative               !! V [1]
      real(wp) :: share

      share = eos%omega/relative
      pressure = (eos%stiff*(1.0_wp - share/eos%r1)*exponential(-eos%r1*relative) &
         + eos%soft*(1.0_wp - share/eos%r2)*exponential(-eos%r2*relative) &
         + share*eos%chemical)/(1.0_wp - 0.5_wp*share*(1.0_wp - relative))
   end function hugoniot_pressure

   !> Grueneisen parameter w times density at the middle of the step: (X.3).
   pure subroutine jwl_find_gruneisen(self, state, deformation, first, last)
      class(eos_jwl_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call take_gruneisen(self%omega, state, deformation, first, last)
   end subroutine jwl_find_gruneisen

   !> Products hold the chemical energy at the start.
   pure logical function jwl_starts_with_energy(self) result(does)
      class(eos_jwl_t), intent(in) :: self

      does = .true.
   end function jwl_starts_with_energy

   !> Chemical energy per mass [J/kg].
   pure real(wp) function jwl_start_energy(self, temperature) result(energy)
      class(eos_jwl_t), intent(in) :: self
      real(wp), optional, intent(in) :: temperature  !! Not used [K]

      energy = self%chemical/self%density
   end function jwl_start_energy

   !> The equation of state describes detonation products.
   pure logical function jwl_detonates(self) result(does)
      class(eos_jwl_t), intent(in) :: self

      does = .true.
   end function jwl_detonates

   !> Speed of a detonation, and the relative volume behind the front.
   pure subroutine jwl_detonation(self, speed, relative)
      class(eos_jwl_t), intent(in) :: self
      real(wp), intent(out) :: speed                 !! [m/s]
      real(wp), intent(out) :: relative              !! [1]

      speed = self%speed
      relative = self%detonated
   end subroutine jwl_detonation

   !> Speed of the Chapman-Jouguet state of the constants [m/s].
   pure real(wp) function jwl_chapman_jouguet_speed(self) result(speed)
      class(eos_jwl_t), intent(in) :: self
      real(wp) :: pressure, relative

      call self%find_detonation(speed, pressure, relative)
   end function jwl_chapman_jouguet_speed

   !> Heat above the reference temperature is part of the energy.
   pure real(wp) function jwl_cold_temperature(self, reference) result(temperature)
      class(eos_jwl_t), intent(in) :: self
      real(wp), intent(in) :: reference              !! Reference temperature of the material [K]

      temperature = reference
   end function jwl_cold_temperature
end module eos_jwl
