! SPDX-License-Identifier: BSD-3-Clause
!> Failure of porous metal: the damage is the greatest porosity so far over the porosity at which
!! the strength vanishes. Equation (D.12) of doc/theory/ductile.md.
module damage_porosity
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: damage_porosity_t

   !> Failure at a porosity.
   type, extends(damage_t) :: damage_porosity_t
      real(wp) :: final = 1.0_wp                     !! Porosity of failure [1]
   contains
      procedure :: fault => porosity_fault           !! A law without pores
      procedure :: read => porosity_read             !! Reads the porosity of failure
      procedure :: request => porosity_request       !! Requests damage
      procedure :: update => porosity_update         !! Damage after the step
   end type damage_porosity_t

contains

   !> Error in the combination of the keys; empty if there is none.
   pure function porosity_fault(self, group, law) result(text)
      class(damage_porosity_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(law_t), allocatable, intent(in) :: law   !! Law of strength, if there is one
      character(len=:), allocatable :: text
      logical :: porous

      text = ""
      porous = .false.
      if (allocated(law)) porous = law%grows_pores()
      if (.not. porous) then
         text = "damage_model = 'porosity' needs strength_model = 'gurson', which has pores [D439]"
      else if (.not. group%given("gtn_ff")) then
         text = "damage_model = 'porosity' needs gtn_ff, the porosity of failure [D439]"
      end if
   end function porosity_fault

   !> Read the porosity of failure.
   pure subroutine porosity_read(self, group, effects)
      class(damage_porosity_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call group%get("gtn_ff", self%final)
   end subroutine porosity_read

   !> Damage follows the porosity, which the law carries.
   pure subroutine porosity_request(self, requests)
      class(damage_porosity_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model porosity", 1)
   end subroutine porosity_request

   !> Damage after the step.
   pure subroutine porosity_update(self, state, deformation, first, last, dt)
      class(damage_porosity_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer :: i

      do concurrent (i=first:last)
         state%damage(i) = min(1.0_wp, max(state%damage(i), state%porosity(i)/self%final))
      end do
   end subroutine porosity_update
end module damage_porosity
