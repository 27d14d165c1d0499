! SPDX-License-Identifier: BSD-3-Clause
!> Equation of state of Tait and Murnaghan: p = K/n ((rho/rho0)**n - 1). Equation (E.5) of
!! doc/theory/equations_of_state.md.
module eos_tait
   use base_elementary, only: logarithm, power, take_fast_powers
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_eos, only: eos_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_tait_t

   !> Equation of state of Tait.
   type, extends(eos_t) :: eos_tait_t
      real(wp) :: exponent = 7.0_wp                  !! n [1]
   contains
      procedure :: declare => tait_declare           !! Declares its key
      procedure :: read => tait_read                 !! Reads its key
      procedure :: sets_bulk => tait_sets_bulk       !! Returns false
      procedure :: update => tait_update             !! Pressure and square of the sound speed
      procedure :: stored_energy => tait_stored_energy !! Energy stored in the change of volume
   end type eos_tait_t

contains

   !> Declare the key of the equation of state.
   subroutine tait_declare(self, schema)
      class(eos_tait_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call schema%real("material", "tait_n", "exponent of Tait's equation of state, 7 for water", &
         range="> 0", owner="effects.eos & eos_model = tait")
      call schema%require("material", "tait_n")
   end subroutine tait_declare

   !> Read the key of the equation of state.
   pure subroutine tait_read(self, group)
      class(eos_tait_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material

      call group%get("tait_n", self%exponent)
   end subroutine tait_read

   !> The bulk modulus is a key of the material.
   pure logical function tait_sets_bulk(self) result(sets)
      class(eos_tait_t), intent(in) :: self

      sets = .false.
   end function tait_sets_bulk

   !> Pressure, and square of the sound speed K/rho0 (rho/rho0)**(n - 1).
   pure subroutine tait_update(self, state, deformation, first, last)
      class(eos_tait_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: stiffness, square
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         ! At rest the result is exactly 1, so the pressure is exactly 0.
         deformation%wave_speed(i) = 1.0_wp + (state%mass(k) - self%density*state%volume(k)) &
            /(self%density*state%volume(k))
         deformation%pressure(i) = deformation%wave_speed(i)
      end do
      call take_fast_powers(last - first + 1, self%exponent, deformation%pressure)
      stiffness = self%bulk/self%exponent
      square = self%bulk/self%density
      do concurrent (i=1:last - first + 1)
         deformation%wave_speed(i) = square*deformation%pressure(i)/deformation%wave_speed(i)
         deformation%pressure(i) = stiffness*(deformation%pressure(i) - 1.0_wp)
      end do
   end subroutine tait_update

   !> Energy stored in the change of volume. With x = V rho0/m it is m K/(n rho0) times (x**(1 - n)
   !! - 1)/(n - 1) + x - 1, and beyond the x at which the pressure would be less than its limit it
   !! grows linearly.
   pure real(wp) function tait_stored_energy(self, mass, volume, limit) result(energy)
      class(eos_tait_t), intent(in) :: self
      real(wp), intent(in) :: mass                   !! [kg]
      real(wp), intent(in) :: volume                 !! [m3]
      real(wp), intent(in) :: limit                  !! Least pressure [Pa]
      real(wp) :: ratio, largest

      ratio = volume*self%density/mass - 1.0_wp
      largest = ratio
      if (limit > -self%bulk/self%exponent) &
         largest = power(1.0_wp + self%exponent*limit/self%bulk, -1.0_wp/self%exponent) - 1.0_wp
      energy = mass/self%density*(self%bulk/self%exponent*excess(min(ratio, largest), &
         self%exponent) - limit*max(0.0_wp, ratio - largest))
   end function tait_stored_energy

   !> ((1 + y)**(1 - n) - 1)/(n - 1) + y, by its series where the difference would lose digits; for
   !! n = 1 the first term is -ln(1 + y).
   pure real(wp) function excess(y, n) result(over)
      real(wp), intent(in) :: y                      !! Above -1 [1]
      real(wp), intent(in) :: n                      !! Exponent [1]
      integer, parameter :: terms = 14
      real(wp) :: term
      integer :: k

      if (abs(y)*max(n, 1.0_wp) > 0.05_wp) then
         if (abs(n - 1.0_wp) > 1.0e-6_wp) then
            over = (power(1.0_wp + y, 1.0_wp - n) - 1.0_wp)/(n - 1.0_wp) + y
         else
            over = y - logarithm(1.0_wp + y)
         end if
         return
      end if
      term = 0.5_wp*n*y*y
      over = term
      do k = 2, terms
         term = -term*y*(n + real(k - 1, wp))/real(k + 1, wp)
         over = over + term
      end do
   end function excess
end module eos_tait
