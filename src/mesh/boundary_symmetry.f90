! SPDX-License-Identifier: BSD-3-Clause
!> Mirror planes.
module boundary_symmetry
   use base_kinds, only: wp
   use mesh_boundary_condition, only: boundary_condition_t, no, normal_direction, yes
   implicit none
   private

   public :: boundary_symmetry_t

   !> The material beyond is the image of that inside.
   type, extends(boundary_condition_t) :: boundary_symmetry_t
   contains
      procedure, nopass :: meaning => symmetry_meaning
      procedure, nopass :: mirrors => yes
      procedure, nopass :: slides => yes
      procedure, nopass :: suits_part => no
      procedure :: constrain => symmetry_constrain
   end type boundary_symmetry_t

contains

   !> One line for the help on the key `type`.
   pure function symmetry_meaning() result(text)
      character(len=:), allocatable :: text

      text = "a mirror plane"
   end function symmetry_meaning

   !> Nothing moves through a mirror plane.
   pure subroutine symmetry_constrain(self, face, nodes, lead, velocity, acceleration)
      class(boundary_symmetry_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of a tile on the boundary
      real(wp), intent(in) :: lead                   !! From its velocity to those of nodes [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer :: n, normal

      normal = normal_direction(face)
      do n = 1, size(nodes)
         velocity(normal, nodes(n)) = 0.0_wp
         acceleration(normal, nodes(n)) = 0.0_wp
      end do
   end subroutine symmetry_constrain
end module boundary_symmetry
