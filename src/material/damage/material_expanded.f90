! SPDX-License-Identifier: BSD-3-Clause
!> Solid material that has expanded to a multiple of its volume: a fluid without strength and
!! tension.
!!
!! Strength and shear modulus are per volume. In material that expands without failing they would do
!! work on ever more volume per mass: at 50 times its volume a flow stress of 1 GPa gives steel the
!! energy of an impact at 3.6 km/s in a strain of 1, and the wave speed of the shear modulus is
!! 26 km/s. See section "Elastic trial" of doc/theory/matter.md.
module material_expanded
   use base_kinds, only: wp
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: count_expanded, cut_expanded_tension, keep_expanded_speed, remove_expanded_deviator

   real(wp), parameter :: widest = 3.0_wp            !! Greatest volume of a solid over that at rest

contains

   !> Number of particles of a range that have expanded beyond a solid.
   pure integer function count_expanded(density, state, first, last) result(expanded)
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      type(material_state_t), intent(in) :: state    !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range

      expanded = count(density*state%volume(first:last) > widest*state%mass(first:last))
   end function count_expanded

   !> Set the trial deviator of these to zero.
   pure subroutine remove_expanded_deviator(density, state, first, last)
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      type(material_state_t), intent(inout) :: state !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range
      integer :: column, i

      do column = 1, 6
         do concurrent (i=first:last)
            state%stress(i, column) = merge(0.0_wp, state%stress(i, column), &
               density*state%volume(i) > widest*state%mass(i))
         end do
      end do
   end subroutine remove_expanded_deviator

   !> The wave speed of these is that without strength.
   pure subroutine keep_expanded_speed(density, state, square, deformation, first, last)
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      type(material_state_t), intent(in) :: state    !! State of the store
      real(wp), intent(in) :: square(:)              !! Square of the speed of sound [m2/s2]
      type(deformation_t), intent(inout) :: deformation !! Square of the wave speed [m2/s2]
      integer, intent(in) :: first, last             !! Particles of the range
      integer :: i

      do concurrent (i=1:last - first + 1)
         deformation%wave_speed(i) = merge(square(i), deformation%wave_speed(i), &
            density*state%volume(first - 1 + i) > widest*state%mass(first - 1 + i))
      end do
   end subroutine keep_expanded_speed

   !> These support no tension.
   pure subroutine cut_expanded_tension(density, state, deformation, first, last)
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      type(material_state_t), intent(in) :: state    !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Pressure and its floor [Pa]
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp) :: pressure
      integer :: i
      logical :: expanded

      do concurrent (i=1:last - first + 1)
         expanded = density*state%volume(first - 1 + i) > widest*state%mass(first - 1 + i)
         pressure = deformation%pressure(i)
         deformation%pressure_floor(i) = merge(0.0_wp, deformation%pressure_floor(i), expanded)
         deformation%pressure(i) = merge(max(0.0_wp, pressure), pressure, expanded)
      end do
   end subroutine cut_expanded_tension
end module material_expanded
