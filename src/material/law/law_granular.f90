! SPDX-License-Identifier: BSD-3-Clause
!> Granular material whose stress relaxes as its contacts break (D. Z. Zhang, R. M. Rauenzahn, J.
!! Rheol. 41 (1997) 1275 and 44 (2000) 1019):
!!
!!    dsigma/dt - W sigma + sigma W = -sigma/tau + lambda tr(D) I + 2 G D
!!
!! with the spin W and the rate of strain D, and 1/tau = 1/gr_tau + rate/gr_gamma_c, where the rate
!! is sqrt(2 D' : D'). With gr_gamma_c alone the stress does not depend on the rate and does not
!! relax at rest. In mode total the whole stress relaxes, in mode deviator the equation of state
!! gives the pressure. Equations (Y.18) and (Y.19) of doc/theory/strength.md.
module law_granular
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use material_effects, only: effects_t
   use material_eos, only: eos_t
   use material_kinematics, only: follow_motion
   use material_law, only: law_add_wave_speed, law_stored_energy, law_t
   use material_relaxation, only: relax_deviator, relax_pressure
   use material_state, only: deformation_t, material_state_t
   use material_tension, only: remove_failed_deviator
   implicit none
   private

   public :: inverse_key, law_granular_t

   !> Law of stress relaxation.
   type, extends(law_t) :: law_granular_t
      real(wp) :: relaxation_rate = 0.0_wp           !! 1/gr_tau, 0 if unset [1/s]
      real(wp) :: inverse_contact_strain = 0.0_wp    !! 1/gr_gamma_c, 0 if unset [1]
      logical :: relaxes_pressure = .false.          !! Mode total
   contains
      procedure :: declare => granular_declare       !! Declares its keys
      procedure :: read_mode => granular_read_mode   !! Reads the mode
      procedure :: fault => granular_fault           !! Error if no relaxation is given
      procedure :: read => granular_read             !! Reads its keys
      procedure :: is_loose => granular_is_loose     !! Always
      procedure :: gives_whole_stress => granular_gives_whole_stress !! In mode total
      procedure :: predict_trial => granular_predict_trial !! Updates the volume, keeps the deviator
      procedure :: update => granular_update         !! Relaxes
      !> Waves are those of the intact contacts
      procedure :: add_wave_speed => granular_add_wave_speed
      procedure :: stored_energy => granular_stored_energy !! Elastic energy
   end type law_granular_t

contains

   !> Declare the keys of the law.
   subroutine granular_declare(self, schema)
      class(law_granular_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = granular"

      call schema%real("material", "gr_tau", &
         "relaxation time of the stress of granular material at rest", unit="s", range="> 0", &
         owner=owner)
      call schema%real("material", "gr_gamma_c", &
         "strain at which contacts of granular material are lost", range="> 0", owner=owner)
      call schema%text("material", "gr_mode", "part of the stress that relaxes: total, the "// &
         "whole stress; deviator, all but the pressure, which follows the equation of state", &
         default="deviator", words="total deviator", owner=owner)
      call schema%allow_change("material", "gr_mode", changes_physics)
   end subroutine granular_declare

   !> The mode decides whether there is an equation of state.
   pure subroutine granular_read_mode(self, group)
      class(law_granular_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: mode

      call group%get("gr_mode", mode)
      self%relaxes_pressure = mode == "total"
   end subroutine granular_read_mode

   !> At least one of the two relaxations must be given.
   pure function granular_fault(self, group, eos) result(text)
      class(law_granular_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text

      text = ""
      if (.not. (group%given("gr_tau") .or. group%given("gr_gamma_c"))) &
         text = "strength_model = 'granular' needs gr_tau [s], gr_gamma_c or both [D364]"
   end function granular_fault

   !> Read the keys of the law. All energy lost by relaxation becomes heat.
   pure subroutine granular_read(self, group, effects)
      class(law_granular_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      self%heat_share = 1.0_wp
      self%relaxation_rate = inverse_key(group, "gr_tau")
      self%inverse_contact_strain = inverse_key(group, "gr_gamma_c")
   end subroutine granular_read

   !> One over the value of a key, 0 if it is not given.
   pure real(wp) function inverse_key(group, key) result(inverse)
      type(group_t), intent(in) :: group             !! &material
      character(len=*), intent(in) :: key

      inverse = 0.0_wp
      if (.not. group%given(key)) return
      call group%get(key, inverse)
      inverse = 1.0_wp/inverse
   end function inverse_key

   !> Grains flow at any stress.
   pure logical function granular_is_loose(self) result(loose)
      class(law_granular_t), intent(in) :: self

      loose = .true.
   end function granular_is_loose

   !> In mode total the pressure is a part of the law.
   pure logical function granular_gives_whole_stress(self) result(whole)
      class(law_granular_t), intent(in) :: self

      whole = self%relaxes_pressure
   end function granular_gives_whole_stress

   !> Volume after the step; the stress becomes its deviator.
   pure subroutine granular_predict_trial(self, state, deformation, first, last)
      class(law_granular_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call follow_motion(state, deformation, first, last)
   end subroutine granular_predict_trial

   !> Deviator after the step, and in mode total the pressure.
   pure subroutine granular_update(self, state, deformation, first, last, dt)
      class(law_granular_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: count

      count = last - first + 1
      call relax_deviator(self%shear, dt*self%relaxation_rate, self%inverse_contact_strain, &
         state, deformation, first, last)
      if (self%relaxes_pressure) then
         if (allocated(state%viscous_pressure)) deformation%pressure(:count) = &
            deformation%pressure(:count) - state%viscous_pressure(first:last)
         call relax_pressure(self%bulk, dt*self%relaxation_rate, self%inverse_contact_strain, &
            state, deformation, first, last)
      end if
      call remove_failed_deviator(state, first, last)
   end subroutine granular_update

   !> Shear, and in mode total the bulk modulus too.
   pure subroutine granular_add_wave_speed(self, state, deformation, first, last)
      class(law_granular_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call law_add_wave_speed(self, state, deformation, first, last)
      if (self%relaxes_pressure) deformation%wave_speed(:last - first + 1) = &
         deformation%wave_speed(:last - first + 1) &
         + self%bulk*state%volume(first:last)/state%mass(first:last)
   end subroutine granular_add_wave_speed

   !> Energy of the active contacts.
   pure real(wp) function granular_stored_energy(self, state, particle) result(energy)
      class(law_granular_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: particle                       !! Index in the store
      real(wp) :: pressure

      energy = law_stored_energy(self, state, particle)
      if (.not. self%relaxes_pressure) return
      pressure = -sum(state%stress(particle, 1:3))/3.0_wp
      if (allocated(state%viscous_pressure)) &
         pressure = pressure - state%viscous_pressure(particle)
      energy = energy + state%volume(particle)*pressure**2/(2.0_wp*self%bulk)
   end function granular_stored_energy
end module law_granular
