! SPDX-License-Identifier: BSD-3-Clause
!> Volume of the matrix of a porous metal: the volume from the motion minus the growth of its pores.
!! The equation of state is that of the matrix, whose pressure acts on its fraction of a surface.
!! Equation (D.8) of doc/theory/ductile.md.
module material_pore_volume
   use base_elementary, only: take_exponentials
   use base_kinds, only: wp
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: to_matrix_volume, to_matrix_volumes, take_matrix_pressure

contains

   !> Replace the volume by that of the matrix, and save that of the motion.
   pure subroutine to_matrix_volume(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count

      count = last - first + 1
      deformation%voids%alpha(:count) = -state%plastic_dilation(first:last)
      deformation%voids%total_volume(:count) = state%volume(first:last)
      call take_exponentials(count, deformation%voids%alpha)
      state%volume(first:last) = deformation%voids%alpha(:count)*state%volume(first:last)
   end subroutine to_matrix_volume

   !> The same for the volumes before and after the step, where the law has stored the fraction of
   !! volume gained by flow.
   pure subroutine to_matrix_volumes(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count

      call to_matrix_volume(state, deformation, first, last)
      count = last - first + 1
      deformation%old_volume(:count) = deformation%old_volume(:count) &
         *deformation%voids%alpha(:count)/(1.0_wp - deformation%strength%dilation(:count))
   end subroutine to_matrix_volumes

   !> Convert the pressure of the matrix to that on the whole surface, and the volume to that of the
   !! motion. The square of the sound speed does not change: p = share p_m(rho/share) has the
   !! derivative of p_m.
   pure subroutine take_matrix_pressure(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count

      count = last - first + 1
      deformation%pressure(:count) = deformation%voids%alpha(:count)*deformation%pressure(:count)
      state%volume(first:last) = deformation%voids%total_volume(:last - first + 1)
   end subroutine take_matrix_pressure
end module material_pore_volume
