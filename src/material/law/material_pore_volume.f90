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

   public :: to_matrix_volume, to_matrix_volumes, to_whole_volume, take_matrix_pressure

contains

   !> Replace the volume by that of the matrix, and save that of the motion.
   pure subroutine to_matrix_volume(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call deformation%voids%reserve(last - first + 1)
      call shrink(first, last, state%plastic_dilation, deformation%voids%alpha, &
         deformation%voids%total_volume, state%volume)
   end subroutine to_matrix_volume

   !> Kernel of the above.
   pure subroutine shrink(first, last, gained, share, whole, volume)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: gained(:)  !! Logarithm of the volume gained (store) [1]
      real(wp), contiguous, intent(inout) :: share(:) !! Matrix over whole volume (range) [1]
      real(wp), contiguous, intent(inout) :: whole(:) !! Volume of the motion (range) [m3]
      real(wp), contiguous, intent(inout) :: volume(:) !! (store) [m3]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         share(i) = -gained(k)
         whole(i) = volume(k)
      end do
      call take_exponentials(last - first + 1, share)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         volume(k) = share(i)*whole(i)
      end do
   end subroutine shrink

   !> The same for the volumes before and after the step, where the law has stored the fraction of
   !! volume gained by flow.
   pure subroutine to_matrix_volumes(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i

      call to_matrix_volume(state, deformation, first, last)
      associate (old => deformation%old_volume, gained => deformation%strength%dilation, &
         share => deformation%voids%alpha)
         do concurrent (i=1:last - first + 1)
            old(i) = old(i)*share(i)/(1.0_wp - gained(i))
         end do
      end associate
   end subroutine to_matrix_volumes

   !> Restore the volume of the motion.
   pure subroutine to_whole_volume(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      state%volume(first:last) = deformation%voids%total_volume(:last - first + 1)
   end subroutine to_whole_volume

   !> Convert the pressure of the matrix to that on the whole surface, and the volume to that of the
   !! motion. The square of the sound speed does not change: p = share p_m(rho/share) has the
   !! derivative of p_m.
   pure subroutine take_matrix_pressure(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i

      associate (pressure => deformation%pressure, share => deformation%voids%alpha)
         do concurrent (i=1:last - first + 1)
            pressure(i) = share(i)*pressure(i)
         end do
      end associate
      call to_whole_volume(state, deformation, first, last)
   end subroutine take_matrix_pressure
end module material_pore_volume
