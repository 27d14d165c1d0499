! SPDX-License-Identifier: BSD-3-Clause
!> Damage of Johnson and Holmquist (JH-2): the sum of plastic increments over the strain to fracture
!! D1 (p* + T*)**D2, and the pressure that fractured material gains because it cannot keep the
!! elastic energy of its shear (bulking).
!!
!! With D1 = 0 material fractures at once when it flows. Failed material has the fractured strength
!! unless failed_as selects another law. Equations (F.14) and (F.16) of doc/theory/failure.md.
module damage_jh2
   use base_elementary, only: power
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use law_jh2, only: jh2_t, law_jh2_t
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_kinematics, only: strain_rate
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: damage_jh2_t

   !> Damage of Johnson and Holmquist.
   type, extends(damage_t) :: damage_jh2_t
      type(jh2_t) :: constants                       !! Constants of strength
      real(wp) :: factor = 0.0_wp                    !! D1 [1]
      real(wp) :: exponent = 1.0_wp                  !! D2 [1]
      real(wp) :: share = 0.0_wp !! beta, fraction of lost energy that makes pressure [1]
   contains
      procedure :: declare => damage_jh2_declare     !! Declares its keys
      procedure :: fault => damage_jh2_fault         !! Error without strength_model jh2
      procedure :: leaves_strength => damage_jh2_leaves_strength !! Returns true
      procedure :: read => damage_jh2_read           !! Reads its keys
      procedure :: request => damage_jh2_request     !! Requests damage and bulking
      procedure :: update => damage_jh2_update       !! Increases the damage
   end type damage_jh2_t

contains

   !> Declare the keys of the model.
   subroutine damage_jh2_declare(self, schema)
      class(damage_jh2_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = jh2"

      call schema%real("material", "jh2_d1", &
         "JH-2 D1, factor of the plastic strain to fracture; 0: fracture at once", range=">= 0", &
         owner=owner)
      call schema%real("material", "jh2_d2", &
         "JH-2 D2, exponent of the plastic strain to fracture", default="1", range=">= 0", &
         owner=owner)
      call schema%real("material", "jh2_beta", &
         "JH-2 beta, fraction of the elastic energy lost in fracture that becomes pressure", &
         default="0", range=">= 0 <= 1", owner=owner)
      call schema%require("material", "jh2_d1")
   end subroutine damage_jh2_declare

   !> The model needs the law of strength jh2.
   pure function damage_jh2_fault(self, group, law) result(text)
      class(damage_jh2_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(law_t), allocatable, intent(in) :: law   !! Law of strength, if there is one
      character(len=:), allocatable :: text
      logical :: fits

      text = ""
      fits = .false.
      if (allocated(law)) then
         select type (law)
         class is (law_jh2_t)
            fits = .true.
         end select
      end if
      if (.not. fits) text = "damage_model = 'jh2' needs strength_model = 'jh2' [D364]"
   end function damage_jh2_fault

   !> Failed material has the fractured strength.
   pure logical function damage_jh2_leaves_strength(self) result(leaves)
      class(damage_jh2_t), intent(in) :: self

      leaves = .true.
   end function damage_jh2_leaves_strength

   !> Read the keys of the model.
   pure subroutine damage_jh2_read(self, group, effects)
      class(damage_jh2_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call self%constants%read(group, effects)
      call group%get("jh2_d1", self%factor)
      call group%get("jh2_d2", self%exponent)
      call group%get("jh2_beta", self%share)
   end subroutine damage_jh2_read

   !> Damage, and the pressure due to fracture.
   pure subroutine damage_jh2_request(self, requests)
      class(damage_jh2_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model jh2", 1)
      if (self%share > 0.0_wp) call requests%add("bulking", "jh2_beta", 1)
   end subroutine damage_jh2_request

   !> Let the damage of flowing particles grow.
   pure subroutine damage_jh2_update(self, state, deformation, first, last, dt)
      class(damage_jh2_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: strain
      integer :: i, k

      ! Data for the bulking: the damage before the step, and the rate factor of the strength.
      deformation%strength%old_damage(:last - first + 1) = state%damage(first:last)
      associate (increment => deformation%plastic_increment, damage => state%damage)
         do i = 1, last - first + 1
            if (.not. increment(i) > 0.0_wp) cycle
            k = first - 1 + i
            strain = self%factor*power(max(0.0_wp, deformation%pressure(i) &
               + self%constants%tension)/self%constants%pressure, self%exponent)
            if (increment(i) < (1.0_wp - damage(k))*strain) then
               damage(k) = damage(k) + increment(i)/strain
            else
               damage(k) = 1.0_wp
            end if
         end do
      end associate
      if (.not. allocated(state%brittle%bulking)) return
      call strain_rate(last - first + 1, deformation%gradient, dt, &
         deformation%strength%strain_rate)
      call gain_pressure(self, state, deformation, first, last)
   end subroutine damage_jh2_update

   !> Pressure dp that the energy dU = (Y**2(D) - Y**2(D'))/(6 G) lost from the shear makes; in
   !! compressed material dp' = -K mu + sqrt((K mu + dp)**2 + 2 beta K dU), mu = rho/rho0 - 1.
   !! Equation (F.16).
   pure subroutine gain_pressure(model, state, deformation, first, last)
      class(damage_jh2_t), intent(in) :: model
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: before, after, linear, gained
      integer :: i, k

      associate (pressure => deformation%pressure, rate => deformation%strength%strain_rate, &
         old_damage => deformation%strength%old_damage, bulking => state%brittle%bulking)
         do i = 1, last - first + 1
            k = first - 1 + i
            linear = model%bulk*(state%mass(k)/(model%density*state%volume(k)) - 1.0_wp)
            if (.not. (state%damage(k) > old_damage(i) .and. linear > 0.0_wp)) cycle
            before = model%constants%strength(pressure(i), rate(i), old_damage(i))
            after = model%constants%strength(pressure(i), rate(i), state%damage(k))
            gained = sqrt((linear + bulking(k))**2 + 2.0_wp*model%share*model%bulk &
               *max(0.0_wp, before**2 - after**2)/(6.0_wp*model%shear)) - linear - bulking(k)
            bulking(k) = bulking(k) + gained
            pressure(i) = pressure(i) + gained
         end do
      end associate
   end subroutine gain_pressure
end module damage_jh2
