! SPDX-License-Identifier: BSD-3-Clause
!> Temperature of particles: heat of plastic flow and of shocks, adiabatic compression, melting.
module material_heat
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use material_state, only: deformation_t, material_state_t
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
      type(melting_range_t), allocatable, intent(out) :: range

      allocate (range)
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
   !! Equations (A.13) and (A.14) of doc/theory/matter.md.
   pure subroutine heat_particles(specific_heat, plastic_share, state, deformation, first, last)
      real(wp), intent(in) :: specific_heat          !! Specific heat at constant volume [J/(kg K)]
      real(wp), intent(in) :: plastic_share !! Fraction of plastic work that becomes heat [1]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), parameter :: twelfth = 1.0_wp/12.0_wp
      real(wp) :: closed, compression, growth, inverse, plastic, viscous
      integer :: i, k

      plastic = plastic_share/specific_heat
      viscous = 1.0_wp/specific_heat
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         ! 1 above the floor and 0 on it; a merge here would prevent vectorisation.
         closed = 0.5_wp - sign(0.5_wp, deformation%pressure_floor(i) - deformation%pressure(i))
         inverse = 1.0_wp/state%mass(k)
         compression = closed*(deformation%old_volume(i) - state%volume(k)) &
            *deformation%gruneisen(i)*inverse
         ! The exponential function, by its positive Pade approximant of order (2, 2).
         growth = 1.0_wp + compression/(1.0_wp - compression*(0.5_wp - twelfth*compression))
         ! Artificial viscosity lags by a step and can remove heat where material begins to expand.
         state%temperature(k) = max(0.0_wp, state%temperature(k)*growth &
            + (plastic*deformation%plastic_work(i) + viscous*deformation%viscous_work(i))*inverse)
      end do
   end subroutine heat_particles

   !> Temperature on a scale from 0 at the reference to 1 at melting, clipped to it; 0 without
   !! range. Equation (A.12).
   pure subroutine homologous_temperature(range, state, deformation, first, last)
      type(melting_range_t), allocatable, intent(in) :: range
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Gets it in `strength%homologous`
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: factor, reference
      integer :: i

      if (.not. allocated(range)) then
         deformation%strength%homologous(1:last - first + 1) = 0.0_wp
         return
      end if
      reference = range%reference
      factor = 1.0_wp/(range%melt - reference)
      do concurrent (i=1:last - first + 1)
         deformation%strength%homologous(i) = &
            min(1.0_wp, max(0.0_wp, (state%temperature(first - 1 + i) - reference)*factor))
      end do
   end subroutine homologous_temperature

   !> A melted particle supports no tension.
   pure subroutine cut_melted_tension(melting, state, deformation, first, last)
      real(wp), intent(in) :: melting                      !! Temperature of melting [K]
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: least, pressure
      integer :: i

      do concurrent (i=1:last - first + 1)
         least = deformation%pressure_floor(i)
         least = merge(max(least, 0.0_wp), least, state%temperature(first - 1 + i) >= melting)
         pressure = deformation%pressure(i)
         deformation%pressure_floor(i) = least
         deformation%pressure(i) = merge(least, pressure, pressure < least)
      end do
   end subroutine cut_melted_tension
end module material_heat
