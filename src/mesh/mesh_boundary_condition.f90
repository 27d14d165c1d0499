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
      procedure, nopass :: slides => no            !! May material move along it?
      procedure, nopass :: has_friction => no      !! Does it resist that motion?
      procedure, nopass :: absorbs_waves => no     !! Does it add forces?
      procedure, nopass :: acts_on_nodes => yes    !! Does it change velocities of nodes?
      procedure, nopass :: suits_part => yes       !! Allowed on a part of a boundary?
      procedure :: suits_region => condition_suits_region !! Allowed in a rigid region?
      procedure :: is_closed => condition_is_closed  !! Does it keep material in?

      procedure :: add_forces => condition_add_forces !! Add accelerations of nodes
      procedure :: constrain => condition_constrain  !! Set velocities, remove accelerations
      procedure :: apply_friction => condition_apply_friction !! Apply friction to pressed nodes
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

   !> Most conditions have no friction.
   pure subroutine condition_apply_friction(self, face, nodes, dt, pic, free, velocity, &
      acceleration)
      class(boundary_condition_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: pic                    !! Fraction of PIC in the transfer, 0 to 1
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) With the others [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
   end subroutine condition_apply_friction

   !> Most conditions do not depend on whether a node is pressed.
   pure subroutine condition_hold_pressed(self, face, nodes, ended, velocity)
      class(boundary_condition_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), contiguous, intent(in) :: ended(:, :) !! (3, node) Velocity after the step [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Changed [m/s]
   end subroutine condition_hold_pressed
end module mesh_boundary_condition
