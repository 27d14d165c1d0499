! SPDX-License-Identifier: BSD-3-Clause
!> Rigid walls with Coulomb friction, from which material may separate. Equation (M.24) of
!! doc/theory/method.md.
module boundary_friction
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use mesh_boundary_condition, only: boundary_condition_t, no, yes
   implicit none
   private

   public :: boundary_friction_t

   !> Pressed material is slowed along such a wall; material that moves away is free.
   type, extends(boundary_condition_t) :: boundary_friction_t
   contains
      procedure, nopass :: meaning => friction_meaning
      procedure, nopass :: waits => yes
      procedure, nopass :: keeps => no
      procedure :: declare => friction_declare
      procedure :: read => friction_read
      procedure, nopass :: slides => yes
   end type boundary_friction_t

contains

   !> One line for the help on the key `type`.
   pure function friction_meaning() result(text)
      character(len=:), allocatable :: text

      text = "a wall with Coulomb friction, from which material can separate"
   end function friction_meaning

   !> Declare the coefficient.
   subroutine friction_declare(self, schema)
      class(boundary_friction_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call schema%real("boundary", "friction", "friction coefficient of the wall", range=">= 0", &
         owner="type = friction")
      call schema%require("boundary", "friction")
   end subroutine friction_declare

   !> Read the coefficient.
   subroutine friction_read(self, group)
      class(boundary_friction_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! The &boundary

      call group%get("friction", self%friction)
   end subroutine friction_read
end module boundary_friction
