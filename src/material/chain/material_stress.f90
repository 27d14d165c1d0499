! SPDX-License-Identifier: BSD-3-Clause
!> Kernels for the mean stress, and for the stress from deviator and pressure.
module material_stress
   use base_kinds, only: wp
   implicit none
   private

   public :: assemble_pressure, assemble_stress, integrate_pressure, take_square_root

contains

   !> Mean stress in rate form, dp = -K tr(strain), and the square of the bulk sound speed. Equation
   !! (A.4) of doc/theory/matter.md.
   pure subroutine integrate_pressure(first, last, bulk, mass, volume, dilatation, pressure, &
      wave_speed)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: bulk                   !! Bulk modulus [Pa]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(in) :: dilatation(:)    !! Trace of strain (range) [1]
      real(wp), contiguous, intent(inout) :: pressure(:)   !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: wave_speed(:) !! Its square (range) [m2/s2]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         pressure(i) = pressure(i) - bulk*dilatation(i)
         wave_speed(i) = bulk*volume(k)/mass(k)
      end do
   end subroutine integrate_pressure

   !> Wave speed from its square.
   pure subroutine take_square_root(count, wave_speed)
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), contiguous, intent(inout) :: wave_speed(:) !! Square in, speed out (range) [m/s]
      integer :: i

      do concurrent (i=1:count)
         wave_speed(i) = sqrt(wave_speed(i))
      end do
   end subroutine take_square_root

   !> Stress from deviator and pressure. Equation (A.6).
   pure subroutine assemble_stress(first, last, pressure, stress)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: pressure(:)     !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! Deviator in, stress out (store, 6) [Pa]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         stress(k, 1) = stress(k, 1) - pressure(i)
         stress(k, 2) = stress(k, 2) - pressure(i)
         stress(k, 3) = stress(k, 3) - pressure(i)
      end do
   end subroutine assemble_stress

   !> Stress from pressure alone.
   pure subroutine assemble_pressure(first, last, pressure, stress)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: pressure(:)     !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! (store, 6) [Pa]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         stress(k, 1) = -pressure(i)
         stress(k, 2) = -pressure(i)
         stress(k, 3) = -pressure(i)
      end do
   end subroutine assemble_pressure
end module material_stress
