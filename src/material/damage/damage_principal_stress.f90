! SPDX-License-Identifier: BSD-3-Clause
!> Brittle failure where the greatest principal stress reaches the strength, or, in compression,
!! where half the difference of the principal stresses reaches that of shear. Equation (F.1) of
!! doc/theory/failure.md.
module damage_principal_stress
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_brittle, only: declare_brittle
   use material_effects, only: effects_t
   use material_overload, only: no_limit, overload_t, read_overload
   use material_softening, only: declare_softening
   implicit none
   private

   public :: damage_principal_stress_t

   !> Failure by principal stress.
   type, extends(overload_t) :: damage_principal_stress_t
   contains
      procedure :: declare => principal_declare      !! Declares its keys
      procedure :: read => principal_read            !! Reads its keys
   end type damage_principal_stress_t

contains

   !> Declare the keys of the model.
   subroutine principal_declare(self, schema)
      class(damage_principal_stress_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = principal_stress"

      call schema%real("material", "failure_stress", "greatest principal stress at failure", &
         unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "failure_shear", "greatest shear stress at failure, half "// &
         "the difference of the principal stresses", unit="Pa", range="> 0", owner=owner)
      call schema%require("material", "failure_stress")
      call declare_brittle(schema)
      call declare_softening(schema)
   end subroutine principal_declare

   !> Read the keys of the model.
   pure subroutine principal_read(self, group, effects)
      class(damage_principal_stress_t), intent(inout) :: self
      type(group_t), intent(in) :: group                  !! &material
      type(effects_t), intent(in) :: effects

      call group%get("failure_stress", self%strength)
      ! With cracks that open by tension, this model applies to compression only.
      if (group%given("fracture_energy")) self%strength = no_limit
      if (group%given("failure_shear")) call group%get("failure_shear", self%crushing)
      call read_overload(self, group, effects)
   end subroutine principal_read
end module damage_principal_stress
