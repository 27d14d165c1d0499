! SPDX-License-Identifier: BSD-3-Clause
!> Rigid walls to which material sticks.
module boundary_stick
   use base_kinds, only: wp
   use mesh_boundary_condition, only: boundary_condition_t, yes
   implicit none
   private

   public :: boundary_stick_t

   !> Material that began on such a wall stays there; what presses on it does not move along it.
   type, extends(boundary_condition_t) :: boundary_stick_t
   contains
      procedure, nopass :: meaning => stick_meaning
      procedure, nopass :: waits => yes
      procedure :: constrain => stick_constrain
      procedure :: grip => stick_grip
   end type boundary_stick_t

contains

   !> One line for the help on the key `type`.
   pure function stick_meaning() result(text)
      character(len=:), allocatable :: text

      text = "a wall to which material sticks"
   end function stick_meaning

   !> Nothing moves.
   pure subroutine stick_constrain(self, face, nodes, lead, velocity, acceleration)
      class(boundary_stick_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: lead                   !! Time from wall to node velocities [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer :: n

      do n = 1, size(nodes)
         velocity(:, nodes(n)) = 0.0_wp
         acceleration(:, nodes(n)) = 0.0_wp
      end do
   end subroutine stick_constrain

   !> More friction than pressure can overcome.
   pure real(wp) function stick_grip(self) result(friction)
      class(boundary_stick_t), intent(in) :: self

      friction = 1.0e30_wp
   end function stick_grip
end module boundary_stick
