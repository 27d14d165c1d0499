! SPDX-License-Identifier: BSD-3-Clause
!> Rigid walls without friction.
module boundary_slip
   use base_kinds, only: wp
   use mesh_boundary_condition, only: boundary_condition_t, normal_direction, yes
   implicit none
   private

   public :: boundary_slip_t

   !> Material that began on such a wall stays on it; it moves along it.
   type, extends(boundary_condition_t) :: boundary_slip_t
   contains
      procedure, nopass :: meaning => slip_meaning
      procedure, nopass :: waits => yes
      procedure, nopass :: slides => yes
      procedure :: constrain => slip_constrain
   end type boundary_slip_t

contains

   !> One line for the help on the key `type`.
   pure function slip_meaning() result(text)
      character(len=:), allocatable :: text

      text = "a wall without friction"
   end function slip_meaning

   !> Nothing moves through the wall, or away from it.
   pure subroutine slip_constrain(self, face, nodes, lead, velocity, acceleration)
      class(boundary_slip_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: lead                   !! Time from wall to node velocities [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer :: n, normal

      normal = normal_direction(face)
      do n = 1, size(nodes)
         velocity(normal, nodes(n)) = 0.0_wp
         acceleration(normal, nodes(n)) = 0.0_wp
      end do
   end subroutine slip_constrain
end module boundary_slip
