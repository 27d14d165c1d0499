! SPDX-License-Identifier: BSD-3-Clause
!> Linear equation of state: p = K (rho/rho0 - 1). Equation (E.4) of
!! doc/theory/equations_of_state.md.
module eos_linear
   use base_elementary, only: logarithm
   use base_kinds, only: wp
   use material_eos, only: eos_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_linear_t, linear_energy

   !> Linear equation of state.
   type, extends(eos_t) :: eos_linear_t
   contains
      procedure :: sets_bulk => linear_sets_bulk     !! Returns false
      procedure :: update => linear_update           !! Pressure and square of the sound speed
      procedure :: stored_energy => linear_stored_energy !! Energy stored in the change of volume
   end type eos_linear_t

contains

   !> The bulk modulus is a key of the material.
   pure logical function linear_sets_bulk(self) result(sets)
      class(eos_linear_t), intent(in) :: self

      sets = .false.
   end function linear_sets_bulk

   !> Pressure and square of the sound speed.
   pure subroutine linear_update(self, state, deformation, first, last)
      class(eos_linear_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         ! The difference is computed before the division, so that the result at rest is exactly 0.
         deformation%pressure(i) = self%bulk*(state%mass(k) - self%density*state%volume(k)) &
            /(self%density*state%volume(k))
         deformation%wave_speed(i) = self%bulk/self%density
      end do
   end subroutine linear_update

   !> Energy stored in the change of volume.
   pure real(wp) function linear_stored_energy(self, mass, volume, limit) result(energy)
      class(eos_linear_t), intent(in) :: self
      real(wp), intent(in) :: mass                   !! [kg]
      real(wp), intent(in) :: volume                 !! [m3]
      real(wp), intent(in) :: limit                  !! Least pressure [Pa]

      energy = linear_energy(self%density, self%bulk, mass, volume, limit)
   end function linear_stored_energy

   !> Energy stored by p = K (rho/rho0 - 1). With x = V rho0/m it is K m/rho0 (x - 1 - ln x), and
   !! beyond the x at which the pressure would be less than its limit it grows linearly.
   pure real(wp) function linear_energy(density, bulk, mass, volume, limit) result(energy)
      real(wp), intent(in) :: density                !! Density of the reference state [kg/m3]
      real(wp), intent(in) :: bulk                   !! Bulk modulus [Pa]
      real(wp), intent(in) :: mass                   !! [kg]
      real(wp), intent(in) :: volume                 !! [m3]
      real(wp), intent(in) :: limit                  !! Least pressure [Pa]
      real(wp) :: ratio, largest

      ratio = volume*density/mass - 1.0_wp
      largest = ratio
      if (limit > -bulk) largest = -limit/(bulk + limit)
      energy = mass/density*(bulk*excess(min(ratio, largest)) - limit*max(0.0_wp, ratio - largest))
   end function linear_energy

   !> x - ln(1 + x), by its series where the difference would lose digits.
   pure real(wp) function excess(x) result(over)
      real(wp), intent(in) :: x                      !! Above -1 [1]
      integer :: power

      if (abs(x) > 0.01_wp) then
         over = x - logarithm(1.0_wp + x)
         return
      end if
      over = 0.0_wp
      do power = 9, 2, -1
         over = 1.0_wp/real(power, wp) - x*over
      end do
      over = x*x*over
   end function excess
end module eos_linear
