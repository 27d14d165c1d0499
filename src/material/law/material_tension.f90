! SPDX-License-Identifier: BSD-3-Clause
!> Limits of tension, and the remaining strength of failed and melted particles.
!!
!! A failed particle is rubble: it keeps mass and volume, has no deviator and supports no tension.
module material_tension
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: fail_as_rubble, cut_tension, fail_with_strength,  remove_failed_deviator, &
      remove_melted_deviator, fracture_t, drop_loose_pressure, spall_t, add_shear_speed, &
      add_intact_shear_speed

   !> Tension cut-off without failure.
   type :: spall_t
      real(wp) :: strength = huge(1.0_wp)            !! Greatest tension [Pa]
   end type spall_t

   !> Permanent failure, by damage and by tension.
   type :: fracture_t
      real(wp) :: strength = huge(1.0_wp)            !! Tension at failure [Pa]
      logical :: leaves_strength = .false.           !! Failed material follows a law
      logical :: leaves_nothing = .false.            !! Failed material has no stress
   end type fracture_t

contains

   !> Set the deviator of failed particles to zero.
   pure subroutine remove_failed_deviator(first, last, failed, stress)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      integer(int64), contiguous, intent(in) :: failed(:)     !! Flag of failure (store)
      real(wp), contiguous, intent(inout) :: stress(:, :)     !! Deviator (store, 6) [Pa]
      logical :: gone
      integer :: i

      if (sum(failed(first:last)) == 0) return
      !$omp simd private(gone)
      do i = first, last
         gone = failed(i) /= 0
         stress(i, 1) = merge(0.0_wp, stress(i, 1), gone)
         stress(i, 2) = merge(0.0_wp, stress(i, 2), gone)
         stress(i, 3) = merge(0.0_wp, stress(i, 3), gone)
         stress(i, 4) = merge(0.0_wp, stress(i, 4), gone)
         stress(i, 5) = merge(0.0_wp, stress(i, 5), gone)
         stress(i, 6) = merge(0.0_wp, stress(i, 6), gone)
      end do
   end subroutine remove_failed_deviator

   !> Set the deviator of melted particles to zero.
   pure subroutine remove_melted_deviator(first, last, melting, temperature, stress)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: melting                !! Temperature of melting [K]
      real(wp), contiguous, intent(in) :: temperature(:)      !! (store) [K]
      real(wp), contiguous, intent(inout) :: stress(:, :)     !! Deviator (store, 6) [Pa]
      real(wp) :: number
      logical :: gone
      integer :: i

      number = 0.0_wp
      !$omp simd reduction(+: number)
      do i = first, last
         number = number + merge(1.0_wp, 0.0_wp, temperature(i) >= melting)
      end do
      if (.not. number > 0.0_wp) return
      !$omp simd private(gone)
      do i = first, last
         gone = temperature(i) >= melting
         stress(i, 1) = merge(0.0_wp, stress(i, 1), gone)
         stress(i, 2) = merge(0.0_wp, stress(i, 2), gone)
         stress(i, 3) = merge(0.0_wp, stress(i, 3), gone)
         stress(i, 4) = merge(0.0_wp, stress(i, 4), gone)
         stress(i, 5) = merge(0.0_wp, stress(i, 5), gone)
         stress(i, 6) = merge(0.0_wp, stress(i, 6), gone)
      end do
   end subroutine remove_melted_deviator

   !> Keep the pressure above a limit.
   pure subroutine cut_tension(first, last, strength, pressure, pressure_floor)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: strength               !! Greatest tension [Pa]
      real(wp), contiguous, intent(inout) :: pressure(:)       !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: pressure_floor(:) !! Least pressure (range) [Pa]
      integer :: i

      do concurrent (i=1:last - first + 1)
         pressure_floor(i) = -strength
         pressure(i) = merge(-strength, pressure(i), pressure(i) < -strength)
      end do
   end subroutine cut_tension

   !> Particles that fail now; usually there are none.
   pure real(wp) function breaking(first, last, strength, pressure, damage, failed) &
      result(number)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: strength               !! Tension at failure [Pa]
      real(wp), contiguous, intent(in) :: pressure(:)          !! (range) [Pa]
      real(wp), contiguous, intent(in) :: damage(:)            !! (store) [1]
      integer(int64), contiguous, intent(in) :: failed(:)      !! Flag of failure (store)
      real(wp) :: least, whole
      integer :: i, k

      number = 0.0_wp
      least = -strength
      !$omp simd private(k, whole) reduction(+: number)
      do i = 1, last - first + 1
         k = first - 1 + i
         whole = merge(1.0_wp, 0.0_wp, damage(k) < 1.0_wp)
         whole = merge(whole, 0.0_wp, pressure(i) > least)
         number = number + merge(1.0_wp - whole, 0.0_wp, failed(k) == 0)
      end do
   end function breaking

   !> Set the least pressure: 0 for failed particles, minus the tensile strength for the others.
   !! Tension of failed particles is removed.
   pure subroutine drop_failed_tension(first, last, strength, failed, pressure, pressure_floor)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: strength               !! Tension at failure [Pa]
      integer(int64), contiguous, intent(in) :: failed(:)      !! Flag of failure (store)
      real(wp), contiguous, intent(inout) :: pressure(:)       !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: pressure_floor(:) !! Least pressure (range) [Pa]
      real(wp) :: cut, least
      integer :: i

      least = -strength
      do concurrent (i=1:last - first + 1)
         cut = merge(0.0_wp, pressure(i), pressure(i) < 0.0_wp)
         pressure_floor(i) = merge(0.0_wp, least, failed(first - 1 + i) /= 0)
         pressure(i) = merge(cut, pressure(i), failed(first - 1 + i) /= 0)
      end do
   end subroutine drop_failed_tension

   !> Mark particles with complete damage or with tension at the limit as failed, and turn failed
   !! particles into rubble. The elastic energy that a particle loses on failing is recorded as
   !! plastic work. Equations (A.7) and (A.8) of doc/theory/matter.md.
   pure subroutine fail_as_rubble(first, last, strength, shear, bulk, volume, stress, pressure, &
      pressure_floor, damage, failed, plastic_work)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: strength               !! Tension at failure [Pa]
      real(wp), intent(in) :: shear                  !! Shear modulus, 0 without deviator [Pa]
      real(wp), intent(in) :: bulk                   !! Bulk modulus, 0 for a gas [Pa]
      real(wp), contiguous, intent(in) :: volume(:)            !! (store) [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :)      !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: pressure(:)       !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: pressure_floor(:) !! Least pressure (range) [Pa]
      real(wp), contiguous, intent(inout) :: damage(:)         !! (store) [1]
      integer(int64), contiguous, intent(inout) :: failed(:)   !! Flag of failure (store)
      real(wp), contiguous, intent(inout) :: plastic_work(:) !! Plastic work of the step (range) [J]
      integer :: i, k

      if (breaking(first, last, strength, pressure, damage, failed) > 0.0_wp) then
         do i = 1, last - first + 1
            k = first - 1 + i
            if (failed(k) /= 0 .or. (damage(k) < 1.0_wp .and. pressure(i) > -strength)) cycle
            failed(k) = 1
            damage(k) = 1.0_wp
            if (bulk > 0.0_wp) plastic_work(i) = plastic_work(i) &
               + volume(k)*0.5_wp*min(pressure(i), 0.0_wp)**2/bulk
            if (shear > 0.0_wp) plastic_work(i) = plastic_work(i) + volume(k)*0.25_wp/shear &
               *(stress(k, 1)**2 + stress(k, 2)**2 + stress(k, 3)**2 &
               + 2.0_wp*(stress(k, 4)**2 + stress(k, 5)**2 + stress(k, 6)**2))
            stress(k, :) = 0.0_wp
         end do
      end if
      call drop_failed_tension(first, last, strength, failed, pressure, pressure_floor)
   end subroutine fail_as_rubble

   !> Mark particles as failed as above, but do not change the deviator, which the law of failed
   !! material updates. Only the elastic energy of the tension is lost.
   pure subroutine fail_with_strength(first, last, strength, bulk, volume, pressure, &
      pressure_floor, damage, failed, plastic_work)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: strength               !! Tension at failure [Pa]
      real(wp), intent(in) :: bulk                   !! Bulk modulus, 0 for a gas [Pa]
      real(wp), contiguous, intent(in) :: volume(:)            !! (store) [m3]
      real(wp), contiguous, intent(inout) :: pressure(:)       !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: pressure_floor(:) !! Least pressure (range) [Pa]
      real(wp), contiguous, intent(inout) :: damage(:)         !! (store) [1]
      integer(int64), contiguous, intent(inout) :: failed(:)   !! Flag of failure (store)
      real(wp), contiguous, intent(inout) :: plastic_work(:) !! Plastic work of the step (range) [J]
      integer :: i, k

      if (breaking(first, last, strength, pressure, damage, failed) > 0.0_wp) then
         do i = 1, last - first + 1
            k = first - 1 + i
            if (failed(k) /= 0 .or. (damage(k) < 1.0_wp .and. pressure(i) > -strength)) cycle
            failed(k) = 1
            damage(k) = 1.0_wp
            if (bulk > 0.0_wp) plastic_work(i) = plastic_work(i) &
               + volume(k)*0.5_wp*min(pressure(i), 0.0_wp)**2/bulk
         end do
      end if
      call drop_failed_tension(first, last, strength, failed, pressure, pressure_floor)
   end subroutine fail_with_strength

   !> Without equation of state the mean stress does not depend on voids: rubble less dense than the
   !! material supports no pressure, and its wave speed is at most that of the material.
   pure subroutine drop_loose_pressure(first, last, density, bulk, mass, volume, failed, pressure, &
      wave_speed)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: density                !! Density of the reference state [kg/m3]
      real(wp), intent(in) :: bulk                   !! Bulk modulus [Pa]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      integer(int64), contiguous, intent(in) :: failed(:)    !! Flag of failure (store)
      real(wp), contiguous, intent(inout) :: pressure(:)     !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: wave_speed(:)   !! Its square (range) [m2/s2]
      real(wp) :: excess, limit
      integer :: i, k

      limit = bulk/density
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         excess = merge(mass(k) - density*volume(k), 0.0_wp, failed(k) /= 0)
         pressure(i) = merge(0.0_wp, pressure(i), excess < 0.0_wp)
         wave_speed(i) = merge(limit, wave_speed(i), excess < 0.0_wp)
      end do
   end subroutine drop_loose_pressure

   !> Add the contribution of the shear modulus to the square of the wave speed. Equation (A.5).
   pure subroutine add_shear_speed(first, last, shear, mass, volume, wave_speed)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(inout) :: wave_speed(:)   !! Its square (range) [m2/s2]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         wave_speed(i) = wave_speed(i) + 4.0_wp/3.0_wp*shear*volume(k)/mass(k)
      end do
   end subroutine add_shear_speed

   !> Add the contribution of the shear modulus to the square of the wave speed where it has not
   !! failed. For failed particles the contribution would shorten the time step of a dispersing
   !! cloud of rubble without need.
   pure subroutine add_intact_shear_speed(first, last, shear, failed, mass, volume, wave_speed)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      integer(int64), contiguous, intent(in) :: failed(:)    !! Flag of failure (store)
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(inout) :: wave_speed(:)   !! Its square (range) [m2/s2]
      real(wp) :: share
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         share = 4.0_wp/3.0_wp*shear*volume(k)/mass(k)
         wave_speed(i) = wave_speed(i) + merge(0.0_wp, share, failed(k) /= 0)
      end do
   end subroutine add_intact_shear_speed
end module material_tension
