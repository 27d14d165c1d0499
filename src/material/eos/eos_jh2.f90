! SPDX-License-Identifier: BSD-3-Clause
!> Pressure of brittle material after Johnson and Holmquist (JH-2), see law_jh2: with
!! mu = rho/rho0 - 1 it is K1 mu + K2 mu**2 + K3 mu**3 in compression and K1 mu in tension.
!!
!! The material update adds the pressure from bulking, in tension too, so that the sum has no jump.
!! Equation (F.15) of doc/theory/failure.md.
module eos_jh2
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use eos_linear, only: linear_energy
   use material_eos, only: eos_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_jh2_t

   !> Polynomial of the density.
   type, extends(eos_t) :: eos_jh2_t
      real(wp) :: square = 0.0_wp                    !! K2 [Pa]
      real(wp) :: cube = 0.0_wp                      !! K3 [Pa]
   contains
      procedure :: declare => jh2_declare            !! Declares its keys
      procedure :: fault => jh2_fault                !! A pressure that falls
      procedure :: read => jh2_read                  !! Reads its keys
      procedure :: update => jh2_update              !! Pressure and square of the sound speed
      procedure :: stored_energy => jh2_stored_energy !! Energy stored in the change of volume
   end type eos_jh2_t

contains

   !> Declare the keys of the equation of state.
   subroutine jh2_declare(self, schema)
      class(eos_jh2_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.eos & eos_model = jh2"

      call schema%real("material", "jh2_k1", "JH-2 K1, bulk modulus", unit="Pa", range="> 0", &
         owner=owner)
      call schema%real("material", "jh2_k2", "JH-2 K2, coefficient of the square of compression", &
         unit="Pa", default="0", owner=owner)
      call schema%real("material", "jh2_k3", "JH-2 K3, coefficient of the cube of compression", &
         unit="Pa", default="0", range=">= 0", owner=owner)
      call schema%require("material", "jh2_k1")
   end subroutine jh2_declare

   !> The pressure must increase with the density, otherwise the sound speed is not real.
   pure function jh2_fault(self, group) result(text)
      class(eos_jh2_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: text
      real(wp) :: linear, square, cube

      text = ""
      if (.not. (group%given("jh2_k1") .and. group%known("jh2_k2") .and. &
         group%known("jh2_k3"))) return
      call group%get("jh2_k1", linear)
      call group%get("jh2_k2", square)
      call group%get("jh2_k3", cube)
      if (square < 0.0_wp .and. square**2 >= 3.0_wp*linear*cube) text = "the pressure of "// &
         "jh2_k1, jh2_k2 and jh2_k3 decreases with the density in some range [D363]"
   end function jh2_fault

   !> Read the keys of the equation of state.
   pure subroutine jh2_read(self, group)
      class(eos_jh2_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material

      call group%get("jh2_k1", self%bulk)
      call group%get("jh2_k2", self%square)
      call group%get("jh2_k3", self%cube)
   end subroutine jh2_read

   !> Pressure and square of the sound speed.
   pure subroutine jh2_update(self, state, deformation, first, last)
      class(eos_jh2_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: excess, compression
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         excess = (state%mass(k) - self%density*state%volume(k))/(self%density*state%volume(k))
         compression = max(0.0_wp, excess)
         deformation%pressure(i) = self%bulk*excess &
            + compression**2*(self%square + self%cube*compression)
         deformation%wave_speed(i) = (self%bulk &
            + compression*(2.0_wp*self%square + 3.0_wp*self%cube*compression))/self%density
      end do
   end subroutine jh2_update

   !> Energy stored in the change of volume: in tension that of a linear equation of state, in
   !! compression m/rho0 times the integral of p/(1 + mu)**2, by Gauss.
   pure real(wp) function jh2_stored_energy(self, mass, volume, limit) result(energy)
      class(eos_jh2_t), intent(in) :: self
      real(wp), intent(in) :: mass                   !! [kg]
      real(wp), intent(in) :: volume                 !! [m3]
      real(wp), intent(in) :: limit                  !! Least pressure [Pa]
      real(wp), parameter :: place(4) = [0.0694318442029737_wp, 0.3300094782075719_wp, &
         0.6699905217924281_wp, 0.9305681557970263_wp]
      real(wp), parameter :: weight(4) = [0.1739274225687269_wp, 0.3260725774312731_wp, &
         0.3260725774312731_wp, 0.1739274225687269_wp]
      integer, parameter :: pieces = 4
      real(wp) :: excess, x
      integer :: i, j

      excess = mass/(self%density*volume) - 1.0_wp
      if (excess <= 0.0_wp) then
         energy = linear_energy(self%density, self%bulk, mass, volume, limit)
         return
      end if
      energy = 0.0_wp
      do j = 0, pieces - 1
         do i = 1, 4
            x = excess*(real(j, wp) + place(i))/real(pieces, wp)
            energy = energy + weight(i)/real(pieces, wp)*excess*(self%bulk*x &
               + x**2*(self%square + self%cube*x))/(1.0_wp + x)**2
         end do
      end do
      energy = mass/self%density*energy
   end function jh2_stored_energy
end module eos_jh2
