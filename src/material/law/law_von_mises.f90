! SPDX-License-Identifier: BSD-3-Clause
!> Plasticity of von Mises with linear isotropic hardening: Y = yield + hardening ep. Equation (Y.3)
!! of doc/theory/strength.md.
module law_von_mises
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_law, only: equivalent_stress, law_t, return_radially, strain_trial
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_von_mises_t

   !> Law of von Mises.
   type, extends(law_t) :: law_von_mises_t
      real(wp) :: yield = 0.0_wp                     !! Initial yield stress [Pa]
      real(wp) :: hardening = 0.0_wp                 !! Slope of yield stress to plastic strain [Pa]
   contains
      procedure :: declare => von_mises_declare      !! Declares its keys
      procedure :: read => von_mises_read            !! Reads its keys
      procedure :: request => von_mises_request      !! Requests plastic strain for hardening
      procedure :: update => von_mises_update        !! Radial return
   end type law_von_mises_t

contains

   !> Declare the keys of the law.
   subroutine von_mises_declare(self, schema)
      class(law_von_mises_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = von_mises "// &
         "gurson"

      call schema%real("material", "yield", &
         "yield stress of von_mises; of the matrix with gurson", unit="Pa", range="> 0", &
         owner=owner)
      call schema%real("material", "hardening", &
         "hardening modulus: increase of the yield stress per plastic strain", unit="Pa", &
         default="0", range=">= 0", owner=owner)
      call schema%require("material", "yield")
   end subroutine von_mises_declare

   !> Read the keys of the law.
   pure subroutine von_mises_read(self, group, effects)
      class(law_von_mises_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call group%get("yield", self%yield)
      call group%get("hardening", self%hardening)
   end subroutine von_mises_read

   !> Perfect plasticity has no state variables; hardening needs the plastic strain.
   pure subroutine von_mises_request(self, requests)
      class(law_von_mises_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      if (self%hardening > 0.0_wp) call requests%add("plastic_strain", "hardening of von_mises", 1)
   end subroutine von_mises_request

   !> Return to the yield surface.
   pure subroutine von_mises_update(self, state, deformation, first, last, dt)
      class(law_von_mises_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: count

      count = last - first + 1
      call strain_trial(state, deformation, first, last)
      call equivalent_stress(state, deformation, first, last)
      if (allocated(state%plastic_strain)) then
         deformation%strength%tangent(:count) = self%yield &
            + self%hardening*state%plastic_strain(first:last)
      else
         deformation%strength%tangent(:count) = self%yield
      end if
      call return_radially(self%shear, self%hardening, state, deformation, first, last)
      if (allocated(state%plastic_strain)) state%plastic_strain(first:last) = &
         state%plastic_strain(first:last) + deformation%plastic_increment(:count)
   end subroutine von_mises_update
end module law_von_mises
