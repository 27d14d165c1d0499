! SPDX-License-Identifier: BSD-3-Clause
!> Brittle failure where the greatest principal value of the elastic strain, s/(2 G) - p/(3 K),
!! reaches a limit. Equation (F.2) of doc/theory/failure.md.
module damage_principal_strain
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_overload, only: no_limit, overload_t, read_overload
   implicit none
   private

   public :: damage_principal_strain_t

   !> Failure by principal strain.
   type, extends(overload_t) :: damage_principal_strain_t
   contains
      procedure :: declare => principal_declare      !! Declares its keys
      procedure :: read => principal_read            !! Reads its keys
   end type damage_principal_strain_t

contains

   !> Declare the keys of the model.
   subroutine principal_declare(self, schema)
      class(damage_principal_strain_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = principal_strain"

      call schema%real("material", "failure_strain", "greatest principal elastic strain at "// &
         "failure", range="> 0", owner=owner)
      call schema%require("material", "failure_strain")
   end subroutine principal_declare

   !> Read the keys of the model.
   pure subroutine principal_read(self, group, effects)
      class(damage_principal_strain_t), intent(inout) :: self
      type(group_t), intent(in) :: group                  !! &material
      type(effects_t), intent(in) :: effects

      call group%get("failure_strain", self%limit)
      ! With a fracture energy cracks open gradually, so that particles do not fail at a strain
      if (group%given("fracture_energy")) self%limit = no_limit
      call read_overload(self, group, effects)
   end subroutine principal_read
end module damage_principal_strain
