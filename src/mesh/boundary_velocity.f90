! SPDX-License-Identifier: BSD-3-Clause
!> Walls with a prescribed velocity.
module boundary_velocity
   use base_kinds, only: wp
   use mesh_boundary_condition, only: boundary_condition_t, yes
   implicit none
   private

   public :: boundary_velocity_t

   !> Material moves with such a wall.
   type, extends(boundary_condition_t) :: boundary_velocity_t
   contains
      procedure, nopass :: meaning => velocity_meaning
      procedure, nopass :: moves => yes
      procedure :: constrain => velocity_constrain
   end type boundary_velocity_t

contains

   !> One line for the help on the key `type`.
   pure function velocity_meaning() result(text)
      character(len=:), allocatable :: text

      text = "a wall with a given velocity, to which material sticks"
   end function velocity_meaning

   !> Material moves with the wall.
   pure subroutine velocity_constrain(self, face, nodes, lead, velocity, acceleration)
      class(boundary_velocity_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: lead                   !! Time from wall to node velocities [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer :: n

      do n = 1, size(nodes)
         velocity(:, nodes(n)) = self%velocity + lead*self%acceleration
         acceleration(:, nodes(n)) = merge(0.0_wp, self%acceleration, lead > 0.0_wp)
      end do
   end subroutine velocity_constrain
end module boundary_velocity
