! SPDX-License-Identifier: BSD-3-Clause
!> Temperature of particles: heat of plastic flow and of shocks, adiabatic compression, melting.
module material_heat
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   implicit none
   private

   public :: heat_particles, heat_t, homologous_temperature, cut_melted_tension, melting_range_t, &
      read_melting_range

   !> Heating of a material.
   type :: heat_t
      real(wp) :: specific_heat = 0.0_wp             !! Specific heat at constant volume [J/(kg K)]
      real(wp) :: reference = 293.0_wp               !! Temperature of the reference state [K]
      real(wp) :: conductivity = 0.0_wp !! Thermal conductivity; 0: no conduction [W/(m K)]
   end type heat_t

   !> Temperatures between which a material softens.
   type :: melting_range_t
      real(wp) :: reference = 293.0_wp               !! Full strength up to here [K]
      real(wp) :: melt = 0.0_wp                      !! No strength from here [K]
   end type melting_range_t

contains

   !> Read the temperatures between which a material softens.
   pure subroutine read_melting_range(group, range)
      type(group_t), intent(in) :: group             !! &material
      type(melting_range_t), intent(out) :: range

      call group%get("t_ref", range%reference)
      call group%get("t_melt", range%melt)
   end subroutine read_melting_range

   !> Temperature after the step.
   !!
   !! From T ds = c_v dT + T Gamma rho c_v dv: at constant entropy dT = -T Gamma rho dv, with Gamma
   !! rho at the middle of the step. For constant Gamma rho this is exactly T exp(Gamma rho (v -
   !! v')); for constant Gamma, as in a gas, it is T (v/v')**Gamma to third order. The heat of
   !! plastic work and of artificial viscosity is added. Where the material is at its least
   !! pressure, voids open or close and the material itself keeps its volume and temperature.
   !! Equations (A.12) and (A.13) of doc/theory/matter.md.
   pure subroutine heat_particles(first, last, specific_heat, plastic_share, gruneisen, mass, &
      volume, old_volume, pressure, pressure_floor, plastic_work, viscous_work, temperature)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: specific_heat          !! Specific heat at constant volume [J/(kg K)]
      real(wp), intent(in) :: plastic_share !! Fraction of plastic work that becomes heat [1]
      real(wp), contiguous, intent(in) :: gruneisen(:) !! Gamma rho (range) [kg/m3]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! After the step (store) [m3]
      real(wp), contiguous, intent(in) :: old_volume(:)     !! Before the step (range) [m3]
      real(wp), contiguous, intent(in) :: pressure(:)       !! After the step (range) [Pa]
      real(wp), contiguous, intent(in) :: pressure_floor(:) !! Least pressure (range) [Pa]
      real(wp), contiguous, intent(in) :: plastic_work(:)   !! Plastic work of the step (range) [J]
      real(wp), contiguous, intent(in) :: viscous_work(:)   !! Viscous work of the step (range) [J]
      real(wp), contiguous, intent(inout) :: temperature(:) !! (store) [K]
      real(wp), parameter :: twelfth = 1.0_wp/12.0_wp
      real(wp) :: closed, compression, growth, inverse, plastic, viscous
      integer :: i, k

      plastic = plastic_share/specific_heat
      viscous = 1.0_wp/specific_heat
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         ! 1 above the floor and 0 on it; a merge here would prevent vectorisation.
         closed = 0.5_wp - sign(0.5_wp, pressure_floor(i) - pressure(i))
         inverse = 1.0_wp/mass(k)
         compression = closed*(old_volume(i) - volume(k))*gruneisen(i)*inverse
         ! The exponential function, by its positive Pade approximant of order (2, 2).
         growth = 1.0_wp + compression/(1.0_wp - compression*(0.5_wp - twelfth*compression))
         ! Artificial viscosity lags by a step and can remove heat where material begins to expand.
         temperature(k) = max(0.0_wp, temperature(k)*growth &
            + (plastic*plastic_work(i) + viscous*viscous_work(i))*inverse)
      end do
   end subroutine heat_particles

   !> Temperature on a scale from 0 at the reference to 1 at melting, clipped to it. Equation
   !! (A.11).
   pure subroutine homologous_temperature(first, last, range, temperature, homologous)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      type(melting_range_t), intent(in) :: range
      real(wp), contiguous, intent(in) :: temperature(:)    !! (store) [K]
      real(wp), contiguous, intent(inout) :: homologous(:)  !! (range) [1]
      real(wp) :: factor
      integer :: i

      factor = 1.0_wp/(range%melt - range%reference)
      do concurrent (i=1:last - first + 1)
         homologous(i) = min(1.0_wp, &
            max(0.0_wp, (temperature(first - 1 + i) - range%reference)*factor))
      end do
   end subroutine homologous_temperature

   !> A melted particle supports no tension.
   pure subroutine cut_melted_tension(first, last, melting, temperature, pressure, pressure_floor)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: melting                !! Temperature of melting [K]
      real(wp), contiguous, intent(in) :: temperature(:)       !! (store) [K]
      real(wp), contiguous, intent(inout) :: pressure(:)       !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: pressure_floor(:) !! Least pressure (range) [Pa]
      integer :: i

      do concurrent (i=1:last - first + 1)
         pressure_floor(i) = merge(max(pressure_floor(i), 0.0_wp), pressure_floor(i), &
            temperature(first - 1 + i) >= melting)
         pressure(i) = merge(pressure_floor(i), pressure(i), pressure(i) < pressure_floor(i))
      end do
   end subroutine cut_melted_tension
end module material_heat
