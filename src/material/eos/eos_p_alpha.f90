! SPDX-License-Identifier: BSD-3-Clause
!> Porous material that crushes (W. Herrmann, J. Appl. Phys. 40 (1969) 2490; M. M. Carroll, A. C.
!! Holt, J. Appl. Phys. 43 (1972) 1626).
!!
!! The distension alpha is the density of the solid over that of the material, and p = ps(alpha rho,
!! e)/alpha with the pressure ps of the solid, here that of Mie and Grueneisen. Up to the elastic
!! limit alpha is constant; beyond it the pressure follows the curve alpha = 1 + (alpha0 - 1) ((pc -
!! p)/(pc - pe))**2 to the pressure pc at which all pores are closed. Crushing is permanent.
!! Equations (E.13) and (E.14) of doc/theory/equations_of_state.md.
module eos_p_alpha
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use eos_mie_gruneisen, only: eos_mie_gruneisen_t, mie_gruneisen_state
   use material_effects, only: in_order
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_p_alpha_t

   !> Equation of state of porous material. Its density is that of the porous material at the start.
   type, extends(eos_t) :: eos_p_alpha_t
      type(eos_mie_gruneisen_t) :: solid             !! Without pores
      real(wp) :: elastic = 0.0_wp                   !! pe, crushing begins [Pa]
      real(wp) :: crushed = 0.0_wp                   !! pc, all pores closed [Pa]
   contains
      procedure :: declare => p_alpha_declare        !! Declares its keys
      procedure :: fault => p_alpha_fault            !! Keys that do not fit each other
      procedure :: read => p_alpha_read              !! Reads its keys
      procedure :: set => p_alpha_set                !! Sets its constants
      procedure :: has_pores => p_alpha_has_pores    !! Returns true
      procedure :: request => p_alpha_request        !! Requests energy and distension
      procedure :: update => p_alpha_update          !! Pressure and square of the sound speed
      procedure :: keep_state => p_alpha_keep_state  !! Keeps the distension
   end type eos_p_alpha_t

contains

   !> Declare the keys of the equation of state; those of the solid are shared with mie_gruneisen.
   subroutine p_alpha_declare(self, schema)
      class(eos_p_alpha_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.eos & eos_model = p_alpha"

      call schema%real("material", "pa_solid", &
         "density of the solid without pores; density is that of the porous material", &
         unit="kg/m3", range="> 0", owner=owner)
      call schema%forbid_change("material", "pa_solid", "the particles have stored their pores "// &
         "since, as a part of it")
      call schema%real("material", "pa_pe", "pressure at which pores begin to crush", unit="Pa", &
         range=">= 0", owner=owner)
      call schema%real("material", "pa_pc", "pressure at which all pores are closed", unit="Pa", &
         range="> 0", owner=owner)
      call schema%require("material", "pa_solid pa_pe pa_pc")
   end subroutine p_alpha_declare

   !> Porous material must be less dense than the solid, and crushing must end at a higher pressure
   !! than it begins.
   pure function p_alpha_fault(self, group) result(text)
      class(eos_p_alpha_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: text

      text = ""
      if (.not. in_order(group, "pa_pe", "pa_pc")) text = "pa_pc must be above pa_pe [D363]"
      if (.not. in_order(group, "density", "pa_solid", equal=.true.)) &
         text = "density of porous material must not be above pa_solid [D363]"
      if (group%given("specific_heat")) text = "eos_model = 'p_alpha' has no model of the "// &
         "heat of crushing; set thermal = .false. [D364]"
   end function p_alpha_fault

   !> Read the keys of the equation of state.
   pure subroutine p_alpha_read(self, group)
      class(eos_p_alpha_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(eos_mie_gruneisen_t) :: solid
      real(wp) :: elastic, crushed

      call group%get("pa_solid", solid%density)
      call solid%read(group)
      call group%get("pa_pe", elastic)
      call group%get("pa_pc", crushed)
      call self%set(solid, elastic, crushed)
   end subroutine p_alpha_read

   !> Set the constants; the density is set before.
   pure subroutine p_alpha_set(self, solid, elastic, crushed)
      class(eos_p_alpha_t), intent(inout) :: self
      type(eos_mie_gruneisen_t), intent(in) :: solid !! Without pores
      real(wp), intent(in) :: elastic                !! pe [Pa]
      real(wp), intent(in) :: crushed                !! pc [Pa]

      self%solid = solid
      self%elastic = elastic
      self%crushed = crushed
      self%distension = solid%density/self%density
      ! At constant distension the wave speed is that of the solid.
      self%bulk = self%density*solid%sound**2
   end subroutine p_alpha_set

   !> Its material is porous.
   pure logical function p_alpha_has_pores(self) result(has)
      class(eos_p_alpha_t), intent(in) :: self

      has = .true.
   end function p_alpha_has_pores

   !> The pressure depends on energy and on the crushing so far.
   pure subroutine p_alpha_request(self, requests)
      class(eos_p_alpha_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "equation of state p_alpha", 1)
      call requests%add_own("distension", "1", "density of the solid over density", &
         "equation of state p_alpha", self%distension)
   end subroutine p_alpha_request

   !> Pressure and square of the sound speed at constant distension, the greatest wave speed.
   pure subroutine p_alpha_update(self, state, deformation, first, last)
      class(eos_p_alpha_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: density, alpha
      integer :: i, k, own

      own = state%own_index("distension")
      do i = 1, last - first + 1
         k = first - 1 + i
         density = state%mass(k)/state%volume(k)
         alpha = state%own(own)%values(k)
         call crush(self, density, state%energy(k), alpha)
         deformation%distension(i) = alpha
         call mie_gruneisen_state(self%solid%density, self%solid%sound, self%solid%slope, &
            self%solid%gamma, self%solid%density/(alpha*density), state%energy(k), &
            deformation%pressure(i), deformation%wave_speed(i))
         deformation%pressure(i) = deformation%pressure(i)/alpha
      end do
   end subroutine p_alpha_update

   !> Distension after the step: intersection of p(alpha) = ps(alpha rho, e)/alpha with the crush
   !! curve between the old distension and 1. The first increases with alpha and the second
   !! decreases, so there is one root; regula falsi after G. Dahlquist and A. Bjoerck ("Illinois").
   pure subroutine crush(eos, density, energy, alpha)
      type(eos_p_alpha_t), intent(in) :: eos         !! Constants
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: energy                 !! [J/kg]
      real(wp), intent(inout) :: alpha               !! Distension [1]
      integer, parameter :: most_iterations = 100
      real(wp) :: low, high, at_low, at_high, middle, at_middle
      integer :: iteration, side

      if (alpha <= 1.0_wp) return
      high = alpha
      at_high = excess(eos, density, energy, high)
      if (at_high <= 0.0_wp) return
      low = 1.0_wp
      at_low = excess(eos, density, energy, low)
      alpha = low
      if (at_low >= 0.0_wp) return
      side = 0
      do iteration = 1, most_iterations
         middle = (low*at_high - high*at_low)/(at_high - at_low)
         if (.not. (middle > low .and. middle < high)) middle = 0.5_wp*(low + high)
         at_middle = excess(eos, density, energy, middle)
         alpha = middle
         if (abs(at_middle) <= 1.0e-13_wp*eos%crushed) exit
         if (high - low <= 4.0_wp*epsilon(1.0_wp)) exit
         if (at_middle > 0.0_wp) then
            high = middle
            at_high = at_middle
            if (side > 0) at_low = 0.5_wp*at_low
            side = 1
         else
            low = middle
            at_low = at_middle
            if (side < 0) at_high = 0.5_wp*at_high
            side = -1
         end if
      end do
   end subroutine crush

   !> Pressure at a distension, above that of the crush curve [Pa].
   pure real(wp) function excess(eos, density, energy, alpha) result(above)
      type(eos_p_alpha_t), intent(in) :: eos         !! Constants
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: energy                 !! [J/kg]
      real(wp), intent(in) :: alpha                  !! Distension [1]
      real(wp) :: pressure, square

      call mie_gruneisen_state(eos%solid%density, eos%solid%sound, eos%solid%slope, &
         eos%solid%gamma, eos%solid%density/(alpha*density), energy, pressure, square)
      above = pressure/alpha - eos%crushed + (eos%crushed - eos%elastic) &
         *sqrt(max(0.0_wp, alpha - 1.0_wp)/(eos%distension - 1.0_wp))
   end function excess

   !> Keep the distension.
   pure subroutine p_alpha_keep_state(self, state, deformation, first, last)
      class(eos_p_alpha_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      state%own(state%own_index("distension"))%values(first:last) = &
         deformation%distension(:last - first + 1)
   end subroutine p_alpha_keep_state
end module eos_p_alpha
