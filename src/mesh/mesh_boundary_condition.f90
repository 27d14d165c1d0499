! SPDX-License-Identifier: BSD-3-Clause
!> The abstract boundary condition: the type of a &boundary, on a boundary of the domain, on a part
!! of one, or in a rigid region.
!!
!! One call applies a condition to all nodes of a tile on one boundary, so the cost of dynamic
!! dispatch is negligible. The defaults are those of a closed wall without further action.
module mesh_boundary_condition
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: boundary_condition_t, inward_sign, no, normal_direction, yes

   !> A boundary condition. Boundaries are numbered from 1 to 6: xlo, xhi, ylo, yhi, zlo, zhi.
   type, abstract :: boundary_condition_t
      character(len=16) :: name = ""                 !! Word of the deck
      real(wp) :: velocity(3) = 0.0_wp !! At the time of the node velocities [m/s]
      real(wp) :: acceleration(3) = 0.0_wp           !! Acceleration of the wall in this step [m/s2]
      real(wp) :: friction = 0.0_wp                  !! Coefficient of friction [1]
   contains
      procedure(meaning_i), deferred, nopass :: meaning !! One line for the help on the key `type`
      procedure :: declare => condition_declare      !! Declare its own keys
      procedure :: read => condition_read            !! Read the keys

      procedure, nopass :: lets_out => no          !! Do particles leave through it?
      procedure, nopass :: joins_opposite => no    !! Is it joined to the opposite boundary?
      procedure, nopass :: mirrors => no           !! Is it a mirror plane?
      procedure, nopass :: moves => no             !! May it move as a boundary of the domain?
      procedure, nopass :: waits => no             !! Does it act from the contact on?
      procedure, nopass :: keeps => yes            !! Does it hold material that began on it?
      procedure, nopass :: slides => no            !! May material move along it?
      procedure, nopass :: absorbs_waves => no     !! Does it add forces?
      procedure, nopass :: acts_on_nodes => yes    !! Does it change velocities of nodes?
      procedure, nopass :: suits_part => yes       !! Allowed on a part of a boundary?
      procedure :: suits_region => condition_suits_region !! Allowed in a rigid region?
      procedure :: is_closed => condition_is_closed  !! Does it keep material in?

      procedure :: add_forces => condition_add_forces !! Add accelerations of nodes
      procedure :: constrain => condition_constrain  !! Set velocities, remove accelerations
      procedure :: grip => condition_grip            !! Friction on material that presses on it
      ! the same for material that may separate from it
      procedure :: keep_out => condition_keep_out    !! Let nothing move into it
      procedure :: press => condition_press          !! Hold nodes that forces press on it
      procedure :: hold_pressed => condition_hold_pressed !! Hold nodes that were pressed on it
   end type boundary_condition_t

   abstract interface
      pure function meaning_i() result(text)
         implicit none
         character(len=:), allocatable :: text
      end function meaning_i
   end interface

contains

   !> Direction along the normal of a boundary, 1 to 3.
   elemental integer function normal_direction(face) result(normal)
      integer, intent(in) :: face                    !! 1 to 6

      normal = (face + 1)/2
   end function normal_direction

   !> Sign of the normal of a boundary that points into the domain.
   elemental real(wp) function inward_sign(face) result(inward)
      integer, intent(in) :: face                    !! 1 to 6

      inward = merge(1.0_wp, -1.0_wp, mod(face, 2) == 1)
   end function inward_sign

   !> By default a condition declares no keys.
   subroutine condition_declare(self, schema)
      class(boundary_condition_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine condition_declare

   !> By default a condition reads no keys.
   subroutine condition_read(self, group)
      class(boundary_condition_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! The &boundary
   end subroutine condition_read

   !> Answer of a condition: no.
   pure logical function no() result(answer)
      answer = .false.
   end function no

   !> Answer of a condition: yes.
   pure logical function yes() result(answer)
      answer = .true.
   end function yes

   !> Conditions that release material, or that apply to whole boundaries only, are not allowed for
   !! rigid regions.
   pure logical function condition_suits_region(self) result(suits)
      class(boundary_condition_t), intent(in) :: self

      suits = self%suits_part() .and. .not. self%lets_out()
   end function condition_suits_region

   !> A boundary is closed if it acts on nodes and does not release particles.
   pure logical function condition_is_closed(self) result(closed)
      class(boundary_condition_t), intent(in) :: self

      closed = self%acts_on_nodes() .and. .not. self%lets_out()
   end function condition_is_closed

   !> Most conditions add no forces.
   pure subroutine condition_add_forces(self, grid, coordinate, face, nodes, dt, velocity, &
      acceleration)
      class(boundary_condition_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of the tile on the boundary
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
   end subroutine condition_add_forces

   !> Set the velocity of nodes and remove their acceleration, except those of the wall itself. Open
   !! boundaries change neither.
   pure subroutine condition_constrain(self, face, nodes, lead, velocity, acceleration)
      class(boundary_condition_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: lead                   !! Time from wall to node velocities [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
   end subroutine condition_constrain

   !> Coefficient of friction between the boundary and material that may separate from it [1].
   pure real(wp) function condition_grip(self) result(friction)
      class(boundary_condition_t), intent(in) :: self

      friction = self%friction
   end function condition_grip

   !> Nothing moves into the wall.
   pure subroutine condition_keep_out(self, face, nodes, velocity)
      class(boundary_condition_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) [m/s]
      integer :: n, node, normal

      normal = normal_direction(face)
      do n = 1, size(nodes)
         node = nodes(n)
         velocity(normal, node) = merge(max(velocity(normal, node), 0.0_wp), &
            min(velocity(normal, node), 0.0_wp), mod(face, 2) == 1)
      end do
   end subroutine condition_keep_out

   !> Where the forces of a step press a node on the wall, the wall removes its normal velocity and
   !! acceleration, and up to mu times that from its tangential velocity at the end of the step, at
   !! most all of it: then the node sticks. A node that moves away is free. Equation (M.24) of
   !! doc/theory/method.md.
   pure subroutine condition_press(self, face, nodes, dt, pic, free, velocity, acceleration)
      class(boundary_condition_t), intent(in) :: self
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
         taken = self%grip()*taken
         speed = norm2(along)
         if (taken < speed) then
            taken = taken/speed
         else
            taken = 1.0_wp
         end if
         acceleration(:, node) = acceleration(:, node) - taken/dt*along
      end do
   end subroutine condition_press

   !> Remove the normal velocity of nodes that the wall constrained in the step, unless they
   !! separate.
   pure subroutine condition_hold_pressed(self, face, nodes, ended, velocity)
      class(boundary_condition_t), intent(in) :: self
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
   end subroutine condition_hold_pressed
end module mesh_boundary_condition
