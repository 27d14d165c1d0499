! SPDX-License-Identifier: BSD-3-Clause
!> Plasticity of von Mises with linear isotropic hardening: Y = yield + hardening ep. Equation (Y.3)
!! of doc/theory/strength.md.
module law_von_mises
   use base_deck_group, only: group_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use constitutive_effects, only: effects_t
   use constitutive_field_requests, only: field_requests_t
   use constitutive_law, only: equivalent_stress, law_t, mean_work, strain_trial
   use constitutive_state, only: deformation_t, material_state_t
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
      procedure :: request => von_mises_request      !! Requests plastic strain if it hardens
      procedure :: update => von_mises_update        !! Radial return
   end type law_von_mises_t

contains

   !> Declare the keys of the law.
   subroutine von_mises_declare(self, schema)
      class(law_von_mises_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = von_mises"

      call schema%real("material", "yield", "yield stress of von Mises", unit="Pa", range="> 0", &
         owner=owner)
      call schema%real("material", "hardening", "slope of the yield stress to plastic strain", &
         unit="Pa", default="0", range=">= 0", owner=owner)
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

   !> Perfect plasticity needs no memory, hardening needs the plastic strain.
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
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]

      call strain_trial(first, last, deformation%gradient, state%stress, deformation%plastic_work)
      call equivalent_stress(first, last, state%stress, deformation%plastic_increment)
      if (allocated(state%plastic_strain)) then
         call return_hardening(first, last, self%shear, self%yield, self%hardening, state%volume, &
            state%stress, state%plastic_strain, deformation%plastic_increment, &
            deformation%plastic_work)
      else
         call return_perfect(first, last, self%shear, self%yield, state%volume, state%stress, &
            deformation%plastic_increment, deformation%plastic_work)
      end if
   end subroutine von_mises_update

   !> Radial return without hardening. Equations (Y.1) and (Y.2).
   pure subroutine return_perfect(first, last, shear, yield, volume, stress, plastic_increment, &
      plastic_work)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: yield                  !! Yield stress [Pa]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :)          !! Deviator (store, 6) [Pa]
      !> Equivalent trial stress [Pa] in, plastic increment [1] out (range).
      real(wp), contiguous, intent(inout) :: plastic_increment(:)
      !> Trial deviator times strain increment [Pa] in, plastic work [J] out (range).
      real(wp), contiguous, intent(inout) :: plastic_work(:)
      real(wp) :: trial, scaling
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trial = plastic_increment(i)
         plastic_increment(i) = max(trial - yield, 0.0_wp)/(3.0_wp*shear)
         plastic_work(i) = volume(k)*mean_work(shear, trial, yield, plastic_increment(i), &
            plastic_work(i))
         scaling = yield/max(trial, yield)
         stress(k, 1) = scaling*stress(k, 1)
         stress(k, 2) = scaling*stress(k, 2)
         stress(k, 3) = scaling*stress(k, 3)
         stress(k, 4) = scaling*stress(k, 4)
         stress(k, 5) = scaling*stress(k, 5)
         stress(k, 6) = scaling*stress(k, 6)
      end do
   end subroutine return_perfect

   !> Radial return with linear hardening (M. L. Wilkins, "Calculation of elastic-plastic flow",
   !! 1964; closed form). Equations (Y.1) and (Y.3).
   pure subroutine return_hardening(first, last, shear, yield, hardening, volume, stress, &
      plastic_strain, plastic_increment, plastic_work)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: yield                  !! Initial yield stress [Pa]
      real(wp), intent(in) :: hardening              !! Slope of yield stress to plastic strain [Pa]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :)          !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: plastic_strain(:)     !! (store) [1]
      !> Equivalent trial stress [Pa] in, plastic increment [1] out (range).
      real(wp), contiguous, intent(inout) :: plastic_increment(:)
      !> Trial deviator times strain increment [Pa] in, plastic work [J] out (range).
      real(wp), contiguous, intent(inout) :: plastic_work(:)
      real(wp) :: trial, limit, scaling
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trial = plastic_increment(i)
         limit = yield + hardening*plastic_strain(k)
         plastic_increment(i) = max(trial - limit, 0.0_wp)/(3.0_wp*shear + hardening)
         plastic_strain(k) = plastic_strain(k) + plastic_increment(i)
         limit = limit + hardening*plastic_increment(i)
         plastic_work(i) = volume(k)*mean_work(shear, trial, limit, plastic_increment(i), &
            plastic_work(i))
         scaling = limit/max(trial, limit)
         stress(k, 1) = scaling*stress(k, 1)
         stress(k, 2) = scaling*stress(k, 2)
         stress(k, 3) = scaling*stress(k, 3)
         stress(k, 4) = scaling*stress(k, 4)
         stress(k, 5) = scaling*stress(k, 5)
         stress(k, 6) = scaling*stress(k, 6)
      end do
   end subroutine return_hardening
end module law_von_mises
