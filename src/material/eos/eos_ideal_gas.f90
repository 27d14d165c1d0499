! SPDX-License-Identifier: BSD-3-Clause
!> Equation of state of an ideal gas with constant heat capacities: p = (gamma - 1) rho e.
!!
!! It has no reference state without pressure: bodies of gas need an initial energy. Equation (E.15)
!! of doc/theory/equations_of_state.md.
module eos_ideal_gas
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_eos, only: eos_t, take_gruneisen
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_ideal_gas_t

   !> Equation of state of an ideal gas.
   type, extends(eos_t) :: eos_ideal_gas_t
      real(wp) :: heat_ratio = 1.4_wp                !! gamma, of the heat capacities [1]
   contains
      procedure :: declare => ideal_gas_declare      !! Declares its key
      procedure :: read => ideal_gas_read            !! Reads its key
      procedure :: request => ideal_gas_request      !! Requests the energy field
      procedure :: update => ideal_gas_update        !! Pressure and square of the sound speed
      procedure :: find_gruneisen => ideal_gas_find_gruneisen !! Grueneisen number times density
      procedure :: cold_temperature => ideal_gas_cold_temperature !! 0
   end type eos_ideal_gas_t

contains

   !> Declare the key of the equation of state.
   subroutine ideal_gas_declare(self, schema)
      class(eos_ideal_gas_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call schema%real("material", "ig_gamma", "heat capacity ratio of an ideal gas", range="> 1", &
         owner="effects.eos & eos_model = ideal_gas")
      call schema%require("material", "ig_gamma")
   end subroutine ideal_gas_declare

   !> Read the key of the equation of state.
   pure subroutine ideal_gas_read(self, group)
      class(eos_ideal_gas_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material

      call group%get("ig_gamma", self%heat_ratio)
      self%bulk = 0.0_wp
   end subroutine ideal_gas_read

   !> The pressure depends on energy.
   pure subroutine ideal_gas_request(self, requests)
      class(eos_ideal_gas_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "equation of state ideal_gas", 1)
   end subroutine ideal_gas_request

   !> Pressure, and square of the sound speed c**2 = gamma p/rho. In finite steps the work of a
   !! particle of cold gas can exceed its energy; its pressure is then zero.
   pure subroutine ideal_gas_update(self, state, deformation, first, last)
      class(eos_ideal_gas_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: share
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         share = (self%heat_ratio - 1.0_wp)*max(state%energy(k), 0.0_wp)
         deformation%pressure(i) = share*state%mass(k)/state%volume(k)
         deformation%wave_speed(i) = self%heat_ratio*share
      end do
   end subroutine ideal_gas_update

   !> Grueneisen parameter gamma - 1 times density at the middle of the step. Equation (A.14) of
   !! doc/theory/matter.md.
   pure subroutine ideal_gas_find_gruneisen(self, state, deformation, first, last)
      class(eos_ideal_gas_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call take_gruneisen(self%heat_ratio - 1.0_wp, state, deformation, first, last)
   end subroutine ideal_gas_find_gruneisen

   !> The energy is c_v T.
   pure real(wp) function ideal_gas_cold_temperature(self, reference) result(temperature)
      class(eos_ideal_gas_t), intent(in) :: self
      real(wp), intent(in) :: reference              !! Reference temperature of the material [K]

      temperature = 0.0_wp
   end function ideal_gas_cold_temperature
end module eos_ideal_gas
