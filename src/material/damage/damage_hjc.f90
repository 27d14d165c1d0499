! SPDX-License-Identifier: BSD-3-Clause
!> Damage of Holmquist, Johnson and Cook (HJC), see law_hjc: the sum of the increments of plastic
!! strain and of the compression that crushes pores, over the strain to fracture D1 (p* + T*)**D2,
!! which is not below a limit.
!!
!! Pores are crushed only by eos_model = 'hjc'. Failed material has the strength of the law without
!! cohesion unless failed_as selects another law. Equation (F.20) of doc/theory/failure.md.
module damage_hjc
   use base_elementary, only: power
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use law_hjc, only: hjc_t, law_hjc_t
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: damage_hjc_t

   !> Damage of Holmquist, Johnson and Cook.
   type, extends(damage_t) :: damage_hjc_t
      type(hjc_t) :: constants                       !! Constants of strength
      real(wp) :: factor = 0.0_wp                    !! D1 [1]
      real(wp) :: exponent = 1.0_wp                  !! D2 [1]
      real(wp) :: least = 0.0_wp                     !! EFMIN, least strain to fracture [1]
   contains
      procedure :: declare => damage_hjc_declare     !! Declares its keys
      procedure :: fault => damage_hjc_fault         !! Error without strength_model hjc
      procedure :: leaves_strength => damage_hjc_leaves_strength !! Returns true
      procedure :: read => damage_hjc_read           !! Reads its keys
      procedure :: request => damage_hjc_request     !! Requests damage
      procedure :: update => damage_hjc_update       !! Increases the damage
   end type damage_hjc_t

contains

   !> Declare the keys of the model.
   subroutine damage_hjc_declare(self, schema)
      class(damage_hjc_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = hjc"

      call schema%real("material", "hjc_d1", "HJC D1, factor of the plastic strain to fracture", &
         range=">= 0", owner=owner)
      call schema%real("material", "hjc_d2", "HJC D2, exponent of the plastic strain to "// &
         "fracture", default="1", range=">= 0", owner=owner)
      call schema%real("material", "hjc_efmin", "HJC EFMIN, least plastic strain to fracture", &
         range="> 0", owner=owner)
      call schema%require("material", "hjc_d1 hjc_efmin")
   end subroutine damage_hjc_declare

   !> The model needs the law of strength hjc.
   pure function damage_hjc_fault(self, group, law) result(text)
      class(damage_hjc_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(law_t), allocatable, intent(in) :: law   !! Law of strength, if there is one
      character(len=:), allocatable :: text
      logical :: fits

      text = ""
      fits = .false.
      if (allocated(law)) then
         select type (law)
         class is (law_hjc_t)
            fits = .true.
         end select
      end if
      if (.not. fits) text = "damage_model = 'hjc' needs strength_model = 'hjc' [D364]"
   end function damage_hjc_fault

   !> Failed material has the strength of the law without cohesion.
   pure logical function damage_hjc_leaves_strength(self) result(leaves)
      class(damage_hjc_t), intent(in) :: self

      leaves = .true.
   end function damage_hjc_leaves_strength

   !> Read the keys of the model.
   pure subroutine damage_hjc_read(self, group, effects)
      class(damage_hjc_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call self%constants%read(group, effects)
      call group%get("hjc_d1", self%factor)
      call group%get("hjc_d2", self%exponent)
      call group%get("hjc_efmin", self%least)
   end subroutine damage_hjc_read

   !> Damage.
   pure subroutine damage_hjc_request(self, requests)
      class(damage_hjc_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model hjc", 1)
   end subroutine damage_hjc_request

   !> Let the damage of particles grow that flow or whose pores are crushed.
   pure subroutine damage_hjc_update(self, state, deformation, first, last, dt)
      class(damage_hjc_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: increment, strain
      integer :: i, k
      logical :: crushes

      ! Only the equation of state hjc has set the crushing of the step.
      crushes = state%own_index("compaction") > 0
      do i = 1, last - first + 1
         increment = deformation%plastic_increment(i)
         if (crushes) increment = increment + deformation%damage%crushing(i)
         if (.not. increment > 0.0_wp) cycle
         k = first - 1 + i
         strain = max(self%least, self%factor*power(max(0.0_wp, deformation%pressure(i) &
            + self%constants%tension)/self%constants%compression, self%exponent))
         state%damage(k) = min(1.0_wp, state%damage(k) + increment/strain)
      end do
   end subroutine damage_hjc_update
end module damage_hjc
