! SPDX-License-Identifier: BSD-3-Clause
!> Brittle failure where the greatest principal stress reaches the strength, or, in compression,
!! where half the difference of the principal stresses reaches that of shear. Equation (F.1) of
!! doc/theory/failure.md.
module damage_principal_stress
   use base_kinds, only: int64, wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_brittle, only: bound_deviator, declare_brittle, draw_weibull, find_extremes, &
      read_weibull, weibull_t
   use material_damage, only: damage_t
   use material_delay, only: age_damage, delay_fault, delay_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_t
   use material_softening, only: declare_softening
   use material_state, only: damage_scratch_t, deformation_t, material_state_t
   implicit none
   private

   public :: damage_principal_stress_t

   !> Failure by principal stress.
   type, extends(damage_t) :: damage_principal_stress_t
      real(wp) :: strength = huge(1.0_wp)            !! Greatest principal stress [Pa]
      !> Greatest shear stress; the default for no limit does not overflow when multiplied by random
      !! factors [Pa]
      real(wp) :: crushing = sqrt(huge(1.0_wp))
      type(delay_t) :: delay                         !! Time from load to failure
      type(weibull_t), allocatable :: weibull        !! Only if strength scatters
   contains
      procedure :: declare => principal_declare      !! Declares its keys
      procedure :: fault => principal_fault          !! Error in the combination of its keys
      procedure :: needs_flow => principal_needs_flow !! Returns false
      procedure :: takes_scatter => principal_takes_scatter !! Returns true
      procedure :: read => principal_read            !! Reads its keys
      procedure :: request => principal_request      !! Requests damage and scatter
      procedure :: draw_strength => principal_draw_strength !! Random strength
      procedure :: update => principal_update        !! Failure
   end type damage_principal_stress_t

contains

   !> Declare the keys of the model.
   subroutine principal_declare(self, schema)
      class(damage_principal_stress_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = principal_stress"

      call schema%real("material", "failure_stress", "greatest principal stress at failure", &
         unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "failure_shear", "greatest shear stress at failure, half "// &
         "the difference of the principal stresses", unit="Pa", range="> 0", owner=owner)
      call schema%require("material", "failure_stress")
      call declare_brittle(schema)
      call declare_softening(schema)
   end subroutine principal_declare

   !> Error in the combination of its keys; empty if there is none.
   pure function principal_fault(self, group, law) result(text)
      class(damage_principal_stress_t), intent(in) :: self
      type(group_t), intent(in) :: group                  !! &material
      class(law_t), allocatable, intent(in) :: law        !! Law of strength, if there is one
      character(len=:), allocatable :: text

      text = delay_fault(group)
   end function principal_fault

   !> It does not use the plastic strain.
   pure logical function principal_needs_flow(self) result(needs)
      class(damage_principal_stress_t), intent(in) :: self

      needs = .false.
   end function principal_needs_flow

   !> Its strength may scatter.
   pure logical function principal_takes_scatter(self) result(takes)
      class(damage_principal_stress_t), intent(in) :: self

      takes = .true.
   end function principal_takes_scatter

   !> Read the keys of the model.
   pure subroutine principal_read(self, group, effects)
      class(damage_principal_stress_t), intent(inout) :: self
      type(group_t), intent(in) :: group                  !! &material
      type(effects_t), intent(in) :: effects

      call group%get("failure_stress", self%strength)
      ! With cracks that open by tension, this model applies to compression only.
      if (group%given("fracture_energy")) self%strength = sqrt(huge(1.0_wp))
      if (group%given("failure_shear")) call group%get("failure_shear", self%crushing)
      call self%delay%read(group)
      if (.not. effects%size_scatter) return
      allocate (self%weibull)
      call read_weibull(group, self%weibull)
   end subroutine principal_read

   !> Damage, and a separate strength for each particle.
   pure subroutine principal_request(self, requests)
      class(damage_principal_stress_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model principal_stress", 1)
      call self%delay%request(requests)
      if (allocated(self%weibull)) call requests%add("scatter", "size_scatter", 1)
   end subroutine principal_request

   !> Random strength.
   pure subroutine principal_draw_strength(self, seed, identity, first, last, mass, scatter)
      class(damage_principal_stress_t), intent(in) :: self
      integer(int64), intent(in) :: seed                   !! Seed of the random numbers
      integer(int64), contiguous, intent(in) :: identity(:) !! Identities of the particles (store)
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), contiguous, intent(in) :: mass(:)          !! (store) [kg]
      real(wp), contiguous, intent(inout) :: scatter(:)    !! (store) [1]

      if (allocated(self%weibull)) call draw_weibull(self%weibull, self%slice, self%density, seed, &
         identity, first, last, mass, scatter)
   end subroutine principal_draw_strength

   !> Mark overloaded particles as failed. Few particles are near their strength, and only these are
   !! processed one by one.
   pure subroutine principal_update(self, state, deformation, first, last, dt)
      class(damage_principal_stress_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: count

      count = last - first + 1
      call deformation%damage%reserve(count)
      call bound_deviator(first, last, state%stress, deformation%damage%bound)
      if (allocated(self%weibull)) then
         deformation%damage%scatter(:count) = state%brittle%scatter(first:last)
      else
         deformation%damage%scatter(:count) = 1.0_wp
      end if
      if (allocated(state%brittle%overload)) then
         call find_load(self, first, last, deformation%pressure, deformation%damage, &
            state%stress, state%brittle%overload)
         call self%delay%grow_damage(first, last, dt, deformation%damage%load, &
            state%brittle%overload, state%damage)
      else
         call overload(self, first, last, dt, deformation%pressure, deformation%damage, &
            state%stress, state%damage)
      end if
   end subroutine principal_update

   !> Kernel of the above.
   pure subroutine overload(model, first, last, dt, pressure, scratch, stress, damage)
      class(damage_principal_stress_t), intent(in) :: model
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp), contiguous, intent(in) :: pressure(:)      !! (range) [Pa]
      type(damage_scratch_t), intent(in) :: scratch        !! Bound and random strength
      real(wp), contiguous, intent(in) :: stress(:, :)     !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: damage(:)     !! (store) [1]
      real(wp) :: greatest, least
      integer :: i, k

      do i = 1, last - first + 1
         if (scratch%bound(i) - pressure(i) < model%strength*scratch%scatter(i) .and. &
            scratch%bound(i) < model%crushing*scratch%scatter(i)) cycle
         k = first - 1 + i
         call find_extremes(stress, k, greatest, least)
         if (greatest - pressure(i) < model%strength*scratch%scatter(i) .and. &
            0.5_wp*(greatest - least) < model%crushing*scratch%scatter(i)) cycle
         damage(k) = age_damage(damage(k), model%delay%time, dt)
      end do
   end subroutine overload

   !> Load over strength, the greater one of tension and shear. Where it is below 1, and was below 1
   !! before, an upper bound is sufficient. Equation (F.3).
   pure subroutine find_load(model, first, last, pressure, scratch, stress, overload)
      class(damage_principal_stress_t), intent(in) :: model
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), contiguous, intent(in) :: pressure(:)      !! (range) [Pa]
      type(damage_scratch_t), intent(inout) :: scratch     !! Bound and random strength in, load out
      real(wp), contiguous, intent(in) :: stress(:, :)     !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(in) :: overload(:)      !! Before the step (store) [1]
      real(wp) :: greatest, least, factor
      integer :: i, k

      do i = 1, last - first + 1
         k = first - 1 + i
         factor = scratch%scatter(i)
         scratch%load(i) = max((scratch%bound(i) - pressure(i))/(model%strength*factor), &
            scratch%bound(i)/(model%crushing*factor))
         if (scratch%load(i) < 1.0_wp .and. .not. overload(k) > 0.0_wp) cycle
         call find_extremes(stress, k, greatest, least)
         scratch%load(i) = max((greatest - pressure(i))/(model%strength*factor), &
            0.5_wp*(greatest - least)/(model%crushing*factor))
      end do
   end subroutine find_load
end module damage_principal_stress
