! SPDX-License-Identifier: BSD-3-Clause
!> What laws have in common whose strength follows pressure, rate of strain and damage: the radial
!! return, the tension that damaged material supports, and the wave speed.
module material_damaged_law
   use base_kinds, only: wp
   use material_kinematics, only: strain_rate
   use material_law, only: equivalent_stress, law_t, return_radially, strain_trial
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: damaged_law_t

   !> Such a law. It gives its strengths, and by `least_pressure` the tension of intact material.
   type, abstract, extends(law_t) :: damaged_law_t
   contains
      procedure(find_strengths_i), deferred :: find_strengths !! Equivalent stress at yield
      procedure :: needs_eos => damaged_needs_eos    !! Returns true
      procedure :: supports_voids => damaged_supports_voids !! Returns false
      procedure :: softens_by_damage => damaged_softens_by_damage !! Returns true
      procedure :: update => damaged_update          !! Radial return
      procedure :: add_wave_speed => damaged_add_wave_speed !! Fractured material is stiff too
   end type damaged_law_t

   abstract interface
      !> Equivalent stress at yield of many particles.
      pure subroutine find_strengths_i(self, count, pressure, rate, damage, stress)
         import :: damaged_law_t, wp
         implicit none
         class(damaged_law_t), intent(in) :: self
         integer, intent(in) :: count                     !! Particles of the range
         real(wp), contiguous, intent(in) :: pressure(:)  !! (range) [Pa]
         real(wp), contiguous, intent(in) :: rate(:)      !! Equivalent, of strain (range) [1/s]
         real(wp), contiguous, intent(in) :: damage(:)    !! D (range) [1]
         real(wp), contiguous, intent(inout) :: stress(:) !! (range) [Pa]
      end subroutine find_strengths_i
   end interface

contains

   !> Strength follows a pressure that depends on the density.
   pure logical function damaged_needs_eos(self) result(needs)
      class(damaged_law_t), intent(in) :: self

      needs = .true.
   end function damaged_needs_eos

   !> The constants are those of material without pores, or with those of its equation of state.
   pure logical function damaged_supports_voids(self) result(supports)
      class(damaged_law_t), intent(in) :: self

      supports = .false.
   end function damaged_supports_voids

   !> The strength decreases with the damage.
   pure logical function damaged_softens_by_damage(self) result(softens)
      class(damaged_law_t), intent(in) :: self

      softens = .true.
   end function damaged_softens_by_damage

   !> Return to the yield surface, which does not change in the step. The pressure stays above the
   !! tension that damaged material supports. Equation (F.19) of doc/theory/failure.md.
   pure subroutine damaged_update(self, state, deformation, first, last, dt)
      class(damaged_law_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: least
      integer :: count, i

      count = last - first + 1
      least = self%least_pressure()
      call strain_trial(state, deformation, first, last)
      call equivalent_stress(state, deformation, first, last)
      call strain_rate(count, deformation%gradient, dt, deformation%strength%strain_rate)
      deformation%strength%old_damage(:count) = 0.0_wp
      if (allocated(state%damage)) deformation%strength%old_damage(:count) = &
         state%damage(first:last)
      do concurrent (i=1:count)
         deformation%pressure(i) = max(deformation%pressure(i), &
            least*(1.0_wp - deformation%strength%old_damage(i)))
      end do
      call self%find_strengths(count, deformation%pressure, deformation%strength%strain_rate, &
         deformation%strength%old_damage, deformation%strength%tangent)
      call return_radially(self%shear, 0.0_wp, state, deformation, first, last)
   end subroutine damaged_update

   !> Add the shear modulus to the square of the wave speed, for intact and fractured material. It
   !! does not increase with the volume, otherwise a cloud of fragments would shorten the time step.
   pure subroutine damaged_add_wave_speed(self, state, deformation, first, last)
      class(damaged_law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%wave_speed(i) = deformation%wave_speed(i) + 4.0_wp/3.0_wp*self%shear &
            *min(state%volume(k)/state%mass(k), 1.0_wp/self%density)
      end do
   end subroutine damaged_add_wave_speed
end module material_damaged_law
