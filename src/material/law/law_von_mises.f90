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
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]

      call strain_trial(first, last, deformation%gradient, state%stress, deformation%plastic_work)
      call equivalent_stress(first, last, state%stress, deformation%plastic_increment)
      associate (limit => deformation%strength%tangent, increment => deformation%strength%dilation)
         if (allocated(state%plastic_strain)) then
            call harden(first, last, self%shear, self%yield, self%hardening, &
               deformation%plastic_increment, state%plastic_strain, limit, increment)
         else
            call keep_yield_stress(last - first + 1, self%shear, self%yield, &
               deformation%plastic_increment, limit, increment)
         end if
         call return_radially(first, last, self%shear, limit, increment, state%volume, &
            state%stress, deformation%plastic_increment, deformation%plastic_work)
      end associate
   end subroutine von_mises_update

   !> Yield stress and plastic increment without hardening. Equations (Y.1) and (Y.2).
   pure subroutine keep_yield_stress(count, shear, yield, trial, limit, increment)
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: yield                  !! Yield stress [Pa]
      real(wp), contiguous, intent(in) :: trial(:)   !! Equivalent trial stress (range) [Pa]
      real(wp), contiguous, intent(inout) :: limit(:) !! Equivalent stress at yield (range) [Pa]
      real(wp), contiguous, intent(inout) :: increment(:) !! Plastic strain (range) [1]
      real(wp) :: softness
      integer :: i

      softness = 1.0_wp/(3.0_wp*shear)
      do concurrent (i=1:count)
         limit(i) = yield
         increment(i) = max(trial(i) - yield, 0.0_wp)*softness
      end do
   end subroutine keep_yield_stress

   !> Yield stress and plastic increment with linear hardening (M. L. Wilkins, "Calculation of
   !! elastic-plastic flow", 1964; closed form). Equations (Y.1) and (Y.3).
   pure subroutine harden(first, last, shear, yield, hardening, trial, plastic_strain, limit, &
      increment)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: yield                  !! Initial yield stress [Pa]
      real(wp), intent(in) :: hardening              !! Slope of yield stress to plastic strain [Pa]
      real(wp), contiguous, intent(in) :: trial(:)   !! Equivalent trial stress (range) [Pa]
      real(wp), contiguous, intent(inout) :: plastic_strain(:)     !! (store) [1]
      real(wp), contiguous, intent(inout) :: limit(:) !! Equivalent stress at yield (range) [Pa]
      real(wp), contiguous, intent(inout) :: increment(:) !! Plastic strain (range) [1]
      real(wp) :: softness
      integer :: i, k

      softness = 1.0_wp/(3.0_wp*shear + hardening)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         limit(i) = yield + hardening*plastic_strain(k)
         increment(i) = max(trial(i) - limit(i), 0.0_wp)*softness
         plastic_strain(k) = plastic_strain(k) + increment(i)
         limit(i) = limit(i) + hardening*increment(i)
      end do
   end subroutine harden
end module law_von_mises
