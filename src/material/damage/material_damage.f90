! SPDX-License-Identifier: BSD-3-Clause
!> Abstract damage model: the damage of a particle grows from 0 to 1.
module material_damage
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: damage_t

   !> A damage model. The material sets the flag of failure where damage has reached 1.
   type, abstract :: damage_t
      real(wp) :: shear = 0.0_wp                     !! Shear modulus of the material [Pa]
      real(wp) :: bulk = 0.0_wp                      !! Bulk modulus of the reference state [Pa]
      real(wp) :: density = 0.0_wp                   !! Density of the reference state [kg/m3]
   contains
      procedure :: declare => damage_declare         !! Declares its keys, if it has any
      procedure :: fault => damage_fault             !! Error in the combination of its keys
      procedure :: needs_flow => damage_needs_flow   !! True if it uses plastic strain
      procedure :: needs_weibull => damage_needs_weibull !! True if it needs a Weibull modulus
      procedure :: uses_jc_rate => damage_uses_jc_rate !! True if it reads the key jc_rate
      !> True if the law of strength also gives the stress of failed material
      procedure :: leaves_strength => damage_leaves_strength
      procedure(read_i), deferred :: read            !! Reads its keys
      procedure(request_i), deferred :: request      !! Requests the fields it needs
      procedure :: strength_of => damage_strength_of !! Strength of material with a flaw
      procedure(update_i), deferred :: update        !! Damage after the step
   end type damage_t

   abstract interface
      pure subroutine read_i(self, group, effects)
         import :: damage_t, effects_t, group_t
         implicit none
         class(damage_t), intent(inout) :: self
         type(group_t), intent(in) :: group                    !! &material
         type(effects_t), intent(in) :: effects
      end subroutine read_i

      pure subroutine request_i(self, requests)
         import :: damage_t, field_requests_t
         implicit none
         class(damage_t), intent(in) :: self
         class(field_requests_t), intent(inout) :: requests
      end subroutine request_i

      !> On entry the stress holds the deviator that the law of strength has corrected; pressure and
      !! plastic increment are those after the step.
      pure subroutine update_i(self, state, deformation, first, last, dt)
         import :: damage_t, deformation_t, material_state_t, wp
         implicit none
         class(damage_t), intent(in) :: self
         type(material_state_t), intent(inout) :: state               !! State of the store
         type(deformation_t), intent(inout) :: deformation     !! Step of the range
         integer, intent(in) :: first, last                    !! Particles of the range
         real(wp), intent(in) :: dt                            !! Time step [s]
      end subroutine update_i
   end interface

contains

   !> Declare the keys of &material that belong to the model. Most models override this.
   subroutine damage_declare(self, schema)
      class(damage_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine damage_declare

   !> Error in the combination of the keys of the model; empty if there is none.
   pure function damage_fault(self, group, law) result(text)
      class(damage_t), intent(in) :: self
      type(group_t), intent(in) :: group                       !! &material
      class(law_t), allocatable, intent(in) :: law             !! Law of strength, if there is one
      character(len=:), allocatable :: text

      text = ""
   end function damage_fault

   !> True if the model uses the plastic strain, so that it needs a law with plastic flow.
   pure logical function damage_needs_flow(self) result(needs)
      class(damage_t), intent(in) :: self

      needs = .true.
   end function damage_needs_flow

   !> True if the model needs a Weibull modulus.
   pure logical function damage_needs_weibull(self, scatter) result(needs)
      class(damage_t), intent(in) :: self
      logical, intent(in) :: scatter                           !! Switch size_scatter of &effects

      needs = .false.
   end function damage_needs_weibull

   !> True if the model reads the key jc_rate, common to several models.
   pure logical function damage_uses_jc_rate(self) result(uses)
      class(damage_t), intent(in) :: self

      uses = .false.
   end function damage_uses_jc_rate

   !> True if the law of strength itself gives the stress of failed material.
   pure logical function damage_leaves_strength(self) result(leaves)
      class(damage_t), intent(in) :: self

      leaves = .false.
   end function damage_leaves_strength

   !> Strength of a particle from the level of its weakest flaw, for the field `scatter` where the
   !! model requests it.
   pure real(wp) function damage_strength_of(self, level) result(strength)
      class(damage_t), intent(in) :: self
      real(wp), intent(in) :: level                            !! Of its weakest flaw [1/m3]

      strength = 1.0_wp
   end function damage_strength_of
end module material_damage
