! SPDX-License-Identifier: BSD-3-Clause
!> Strength of brittle material after G. R. Johnson, T. J. Holmquist, "An improved computational
!! constitutive model for brittle materials" (AIP Conf. Proc. 309 (1994) 981), known as JH-2.
!!
!! In units of the elastic limit (HEL), with p* = p/p_HEL, T* = T/p_HEL:
!!
!!    intact     A (p* + T*)**N (1 + C ln(rate))
!!    fractured  B p***M (1 + C ln(rate)), not above a limit
!!
!! and the strength is (1 - D) intact + D fractured. Damage is that of damage_model = 'jh2'; without
!! it material stays intact. Damaged material supports less tension, T (1 - D). Equations (F.12) and
!! (F.13) of doc/theory/failure.md.
module law_jh2
   use base_elementary, only: take_fast_powers, take_logarithms
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_damaged_law, only: damaged_law_t
   use material_effects, only: effects_t, in_order
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   implicit none
   private

   public :: jh2_t, law_jh2_t

   !> Constants.
   type :: jh2_t
      real(wp) :: intact = 0.0_wp                    !! A [1]
      real(wp) :: intact_exponent = 1.0_wp           !! N [1]
      real(wp) :: fractured = 0.0_wp                 !! B [1]
      real(wp) :: fractured_exponent = 1.0_wp        !! M [1]
      real(wp) :: fractured_limit = huge(1.0_wp)     !! Greatest fractured strength [1]
      real(wp) :: rate_coefficient = 0.0_wp          !! C [1]
      real(wp) :: reference_rate = 1.0_wp            !! Rate of the static strength [1/s]
      real(wp) :: tension = 0.0_wp                   !! T, greatest hydrostatic tension [Pa]
      real(wp) :: pressure = 1.0_wp                  !! p_HEL [Pa]
      real(wp) :: stress = 1.0_wp                    !! Equivalent stress at the limit [Pa]
   contains
      procedure :: read => jh2_read                  !! Reads the keys
      procedure :: strength => jh2_strength          !! Equivalent stress at yield
      procedure :: find_strengths => jh2_find_strengths !! Strengths of many particles
   end type jh2_t

   !> Law of Johnson and Holmquist.
   type, extends(damaged_law_t) :: law_jh2_t
      type(jh2_t) :: constants                       !! Constants of strength
   contains
      procedure :: declare => law_jh2_declare        !! Declares its keys
      procedure :: fault => law_jh2_fault            !! Checks its constants
      procedure :: read => law_jh2_read              !! Reads its keys
      procedure :: request => law_jh2_request        !! Requests the energy field
      procedure :: find_strengths => law_jh2_find_strengths !! Equivalent stress at yield
      procedure :: least_pressure => law_jh2_least_pressure !! That of the tension
   end type law_jh2_t

contains

   !> Declare the keys of the law.
   subroutine law_jh2_declare(self, schema)
      class(law_jh2_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = jh2"

      call schema%real("material", "jh2_a", "JH-2 A, intact strength", range="> 0", owner=owner)
      call schema%real("material", "jh2_n", "JH-2 N, exponent of intact strength", range=">= 0", &
         owner=owner)
      call schema%real("material", "jh2_b", "JH-2 B, fractured strength", range=">= 0", owner=owner)
      call schema%real("material", "jh2_m", "JH-2 M, exponent of fractured strength", &
         range=">= 0", owner=owner)
      call schema%real("material", "jh2_fmax", &
         "JH-2 greatest fractured strength over the strength at the elastic limit", range="> 0", &
         owner=owner)
      call schema%real("material", "jh2_c", "JH-2 C, rate dependence", default="0", range=">= 0", &
         owner=owner//" & effects.rate")
      call schema%real("material", "jh2_rate", "JH-2 reference strain rate", unit="1/s", &
         default="1.0", range="> 0", owner=owner//" & effects.rate")
      call schema%real("material", "jh2_t", "JH-2 T, greatest hydrostatic tension", unit="Pa", &
         range=">= 0", owner=owner)
      call schema%real("material", "jh2_hel", "JH-2 HEL, stress at the Hugoniot elastic limit", &
         unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "jh2_phel", &
         "JH-2 PHEL, pressure at the Hugoniot elastic limit", unit="Pa", range="> 0", owner=owner)
      call schema%require("material", "jh2_a jh2_n jh2_b jh2_m jh2_t jh2_hel jh2_phel")
   end subroutine law_jh2_declare

   !> The Hugoniot elastic limit includes a deviator, so it must exceed the pressure at the limit.
   pure function law_jh2_fault(self, group, eos) result(text)
      class(law_jh2_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text

      text = ""
      if (.not. in_order(group, "jh2_phel", "jh2_hel")) &
         text = "jh2_hel must be above jh2_phel [D363]"
   end function law_jh2_fault

   !> Read the keys of the law.
   pure subroutine law_jh2_read(self, group, effects)
      class(law_jh2_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call self%constants%read(group, effects)
   end subroutine law_jh2_read

   !> The pressure made by fracture is not a function of the density, so particles carry their
   !! energy.
   pure subroutine law_jh2_request(self, requests)
      class(law_jh2_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "strength model jh2", 1)
   end subroutine law_jh2_request

   !> Equivalent stress at yield of many particles.
   pure subroutine law_jh2_find_strengths(self, count, pressure, rate, damage, stress)
      class(law_jh2_t), intent(in) :: self
      integer, intent(in) :: count                     !! Particles of the range
      real(wp), contiguous, intent(in) :: pressure(:)  !! (range) [Pa]
      real(wp), contiguous, intent(in) :: rate(:)      !! Equivalent, of strain (range) [1/s]
      real(wp), contiguous, intent(in) :: damage(:)    !! D (range) [1]
      real(wp), contiguous, intent(inout) :: stress(:) !! (range) [Pa]

      call self%constants%find_strengths(count, pressure, rate, damage, stress)
   end subroutine law_jh2_find_strengths

   !> Least pressure that the law supports [Pa].
   pure real(wp) function law_jh2_least_pressure(self) result(pressure)
      class(law_jh2_t), intent(in) :: self

      pressure = -self%constants%tension
   end function law_jh2_least_pressure

   !> Read the keys.
   pure subroutine jh2_read(self, group, effects)
      class(jh2_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects
      real(wp) :: limit

      call group%get("jh2_a", self%intact)
      call group%get("jh2_n", self%intact_exponent)
      call group%get("jh2_b", self%fractured)
      call group%get("jh2_m", self%fractured_exponent)
      if (group%given("jh2_fmax")) call group%get("jh2_fmax", self%fractured_limit)
      if (effects%rate) then
         call group%get("jh2_c", self%rate_coefficient)
         call group%get("jh2_rate", self%reference_rate)
      end if
      call group%get("jh2_t", self%tension)
      call group%get("jh2_phel", self%pressure)
      call group%get("jh2_hel", limit)
      self%stress = 1.5_wp*(limit - self%pressure)
   end subroutine jh2_read

   !> Equivalent stress at yield [Pa].
   pure real(wp) function jh2_strength(self, pressure, rate, damage) result(stress)
      class(jh2_t), intent(in) :: self
      real(wp), intent(in) :: pressure               !! [Pa]
      real(wp), intent(in) :: rate                   !! Equivalent rate of strain [1/s]
      real(wp), intent(in) :: damage                 !! D [1]
      real(wp) :: one(1)

      call self%find_strengths(1, [pressure], [rate], [damage], one)
      stress = one(1)
   end function jh2_strength

   !> Equivalent stress at yield of many particles.
   pure subroutine jh2_find_strengths(self, count, pressure, rate, damage, stress)
      class(jh2_t), intent(in) :: self
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), contiguous, intent(in) :: pressure(:)    !! (range) [Pa]
      real(wp), contiguous, intent(in) :: rate(:)        !! Equivalent, of strain (range) [1/s]
      real(wp), contiguous, intent(in) :: damage(:)      !! D (range) [1]
      real(wp), contiguous, intent(inout) :: stress(:)   !! (range) [Pa]
      integer, parameter :: most_lanes = 64
      real(wp), dimension(most_lanes) :: factor, whole, broken
      real(wp) :: intact, fractured, most, least
      integer :: i, l, number, offset

      intact = self%intact
      fractured = self%fractured
      most = self%fractured_limit
      least = -self%tension
      do offset = 0, count - 1, most_lanes
         number = min(most_lanes, count - offset)
         !$omp simd private(i)
         do l = 1, number
            i = offset + l
            factor(l) = max(rate(i)/self%reference_rate, 1.0_wp)
            whole(l) = max((pressure(i) + self%tension)/self%pressure, 0.0_wp)
            broken(l) = max(pressure(i)/self%pressure, 0.0_wp)
         end do
         if (self%rate_coefficient > 0.0_wp) then
            call take_logarithms(number, factor)
         else
            factor(:number) = 0.0_wp
         end if
         call take_fast_powers(number, self%intact_exponent, whole)
         if (any(damage(offset + 1:offset + number) > 0.0_wp)) &
            call take_fast_powers(number, self%fractured_exponent, broken)
         !$omp simd private(i)
         do l = 1, number
            i = offset + l
            factor(l) = 1.0_wp + self%rate_coefficient*factor(l)
            whole(l) = merge(factor(l)*whole(l), 0.0_wp, pressure(i) > least)
            broken(l) = merge(min(most, fractured*(factor(l)*broken(l))), 0.0_wp, &
               pressure(i) > 0.0_wp)
            stress(i) = self%stress*((1.0_wp - damage(i))*(intact*whole(l)) &
               + damage(i)*broken(l))
         end do
      end do
   end subroutine jh2_find_strengths
end module law_jh2
