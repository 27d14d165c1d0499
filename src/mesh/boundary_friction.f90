! SPDX-License-Identifier: BSD-3-Clause
!> Rigid walls with Coulomb friction, from which material may separate. Equation (M.24) of
!! doc/theory/method.md.
module boundary_friction
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use mesh_boundary_condition, only: boundary_condition_t, inward_sign, normal_direction, yes
   implicit none
   private

   public :: boundary_friction_t

   !> Pressed material is slowed along such a wall; material that moves away is free.
   type, extends(boundary_condition_t) :: boundary_friction_t
   contains
      procedure, nopass :: meaning => friction_meaning
      procedure, nopass :: waits => yes
      procedure :: declare => friction_declare
      procedure :: read => friction_read
      procedure, nopass :: slides => yes
      procedure, nopass :: has_friction => yes
      procedure :: constrain => friction_constrain
      procedure :: apply_friction => friction_apply
      procedure :: hold_pressed => friction_hold_pressed
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

   !> Nothing moves into the wall.
   pure subroutine friction_constrain(self, face, nodes, lead, velocity, acceleration)
      class(boundary_friction_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: lead                   !! Time from wall to node velocities [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer :: n, node, normal

      normal = normal_direction(face)
      do n = 1, size(nodes)
         node = nodes(n)
         velocity(normal, node) = merge(max(velocity(normal, node), 0.0_wp), &
            min(velocity(normal, node), 0.0_wp), mod(face, 2) == 1)
      end do
   end subroutine friction_constrain

   !> Where the forces of a step press a node on the wall, the wall removes its normal velocity and
   !! acceleration, and up to mu times that from its tangential velocity at the end of the step, at
   !! most all of it: then the node sticks. A node that moves away is free. Equation (M.24) of
   !! doc/theory/method.md.
   pure subroutine friction_apply(self, face, nodes, dt, pic, free, velocity, acceleration)
      class(boundary_friction_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: pic                    !! Fraction of PIC in the transfer, 0 to 1
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) With all other walls [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: along(3), inward, taken, speed
      integer :: n, node, normal

      normal = normal_direction(face)
      inward = inward_sign(face)
      do n = 1, size(nodes)
         node = nodes(n)
         ! velocity gain of particles from the node if the wall constrains it
         taken = -inward*(dt*acceleration(normal, node) + pic*free(normal, node))
         if (.not. taken > 0.0_wp) cycle
         if (inward*(free(normal, node) + dt*acceleration(normal, node)) > 0.0_wp) cycle
         velocity(normal, node) = 0.0_wp
         acceleration(normal, node) = 0.0_wp
         along = velocity(:, node) + dt*acceleration(:, node)
         if (.not. dt > 0.0_wp) cycle
         taken = self%friction*taken
         speed = norm2(along)
         if (taken < speed) then
            taken = taken/speed
         else
            taken = 1.0_wp
         end if
         acceleration(:, node) = acceleration(:, node) - taken/dt*along
      end do
   end subroutine friction_apply

   !> Remove the normal velocity of nodes that the wall constrained in the step, unless they
   !! separate.
   pure subroutine friction_hold_pressed(self, face, nodes, ended, velocity)
      class(boundary_friction_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), contiguous, intent(in) :: ended(:, :) !! (3, node) Velocity after the step [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Changed [m/s]
      integer :: n, normal

      normal = normal_direction(face)
      do n = 1, size(nodes)
         if (.not. inward_sign(face)*ended(normal, nodes(n)) > 0.0_wp) &
            velocity(normal, nodes(n)) = 0.0_wp
      end do
   end subroutine friction_hold_pressed
end module boundary_friction
