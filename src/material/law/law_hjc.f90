! SPDX-License-Identifier: BSD-3-Clause
!> Strength of concrete after T. J. Holmquist, G. R. Johnson, W. H. Cook, "A computational
!! constitutive model for concrete subjected to large strains, high strain rates, and high
!! pressures" (14th International Symposium on Ballistics, Quebec, 1993), known as HJC.
!!
!! In units of the unconfined strength f_c, with p* = p/f_c:
!!
!!    pressure   (A (1 - D) + B p***N) (1 + C ln(rate)), not above S_max
!!    tension    A (1 - D) (1 + p/T) (1 + C ln(rate))
!!
!! Damage is that of damage_model = 'hjc'; without it material stays intact. Damaged material has no
!! cohesion and supports less tension, T (1 - D). The line in tension is that which codes with this
!! law use; the paper has none. Equations (F.17), (F.18) and (F.19) of doc/theory/failure.md.
module law_hjc
   use base_elementary, only: take_fast_powers, take_logarithms
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_damaged_law, only: damaged_law_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   implicit none
   private

   public :: hjc_t, law_hjc_t

   !> Constants.
   type :: hjc_t
      real(wp) :: cohesion = 0.0_wp                  !! A [1]
      real(wp) :: hardening = 0.0_wp                 !! B [1]
      real(wp) :: exponent = 1.0_wp                  !! N [1]
      real(wp) :: limit = huge(1.0_wp)               !! S_max, greatest strength [1]
      real(wp) :: rate_coefficient = 0.0_wp          !! C [1]
      real(wp) :: reference_rate = 1.0_wp            !! Rate of the static strength [1/s]
      real(wp) :: compression = 1.0_wp               !! f_c, unconfined strength [Pa]
      real(wp) :: tension = 0.0_wp                   !! T, greatest hydrostatic tension [Pa]
   contains
      procedure :: read => hjc_read                  !! Reads the keys
      procedure :: find_strengths => hjc_find_strengths !! Equivalent stress at yield
   end type hjc_t

   !> Law of Holmquist, Johnson and Cook.
   type, extends(damaged_law_t) :: law_hjc_t
      type(hjc_t) :: constants                       !! Constants of strength
   contains
      procedure :: declare => law_hjc_declare        !! Declares its keys
      procedure :: read => law_hjc_read              !! Reads its keys
      procedure :: request => law_hjc_request        !! Requests the energy field
      procedure :: find_strengths => law_hjc_find_strengths !! Equivalent stress at yield
      procedure :: least_pressure => law_hjc_least_pressure !! That of the tension
   end type law_hjc_t

contains

   !> Declare the keys of the law.
   subroutine law_hjc_declare(self, schema)
      class(law_hjc_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = hjc"

      call schema%real("material", "hjc_a", "HJC A, cohesive strength over hjc_fc", &
         range=">= 0", owner=owner)
      call schema%real("material", "hjc_b", "HJC B, factor of the strength from pressure", &
         range=">= 0", owner=owner)
      call schema%real("material", "hjc_n", "HJC N, exponent of pressure over hjc_fc", &
         range="> 0", owner=owner)
      call schema%real("material", "hjc_smax", "HJC greatest strength over hjc_fc", range="> 0", &
         owner=owner)
      call schema%real("material", "hjc_c", "HJC C, rate dependence", default="0", range=">= 0", &
         owner=owner//" & effects.rate")
      call schema%real("material", "hjc_rate", "HJC reference strain rate", unit="1/s", &
         default="1.0", range="> 0", owner=owner//" & effects.rate")
      call schema%real("material", "hjc_fc", "HJC fc, strength in uniaxial compression", &
         unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "hjc_t", "HJC T, greatest hydrostatic tension", unit="Pa", &
         range=">= 0", owner=owner)
      call schema%require("material", "hjc_a hjc_b hjc_n hjc_fc hjc_t")
   end subroutine law_hjc_declare

   !> Read the keys of the law.
   pure subroutine law_hjc_read(self, group, effects)
      class(law_hjc_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call self%constants%read(group, effects)
   end subroutine law_hjc_read

   !> The tension that damaged material supports is not a function of the density, so particles
   !! carry their energy.
   pure subroutine law_hjc_request(self, requests)
      class(law_hjc_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "strength model hjc", 1)
   end subroutine law_hjc_request

   !> Equivalent stress at yield of many particles.
   pure subroutine law_hjc_find_strengths(self, count, pressure, rate, damage, stress)
      class(law_hjc_t), intent(in) :: self
      integer, intent(in) :: count                     !! Particles of the range
      real(wp), contiguous, intent(in) :: pressure(:)  !! (range) [Pa]
      real(wp), contiguous, intent(in) :: rate(:)      !! Equivalent, of strain (range) [1/s]
      real(wp), contiguous, intent(in) :: damage(:)    !! D (range) [1]
      real(wp), contiguous, intent(inout) :: stress(:) !! (range) [Pa]

      call self%constants%find_strengths(count, pressure, rate, damage, stress)
   end subroutine law_hjc_find_strengths

   !> Least pressure that the law supports [Pa].
   pure real(wp) function law_hjc_least_pressure(self) result(pressure)
      class(law_hjc_t), intent(in) :: self

      pressure = -self%constants%tension
   end function law_hjc_least_pressure

   !> Read the keys.
   pure subroutine hjc_read(self, group, effects)
      class(hjc_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call group%get("hjc_a", self%cohesion)
      call group%get("hjc_b", self%hardening)
      call group%get("hjc_n", self%exponent)
      if (group%given("hjc_smax")) call group%get("hjc_smax", self%limit)
      if (effects%rate) then
         call group%get("hjc_c", self%rate_coefficient)
         call group%get("hjc_rate", self%reference_rate)
      end if
      call group%get("hjc_fc", self%compression)
      call group%get("hjc_t", self%tension)
   end subroutine hjc_read

   !> Equivalent stress at yield of many particles. Equations (F.17) and (F.18).
   pure subroutine hjc_find_strengths(self, count, pressure, rate, damage, stress)
      class(hjc_t), intent(in) :: self
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), contiguous, intent(in) :: pressure(:)    !! Not below -T (range) [Pa]
      real(wp), contiguous, intent(in) :: rate(:)        !! Equivalent, of strain (range) [1/s]
      real(wp), contiguous, intent(in) :: damage(:)      !! D (range) [1]
      real(wp), contiguous, intent(inout) :: stress(:)   !! (range) [Pa]
      integer, parameter :: most_lanes = 64
      real(wp), dimension(most_lanes) :: factor, power
      real(wp) :: cohesion, per_tension
      integer :: i, l, number, offset

      ! Material without tension has no pressure below 0.
      per_tension = 0.0_wp
      if (self%tension > 0.0_wp) per_tension = 1.0_wp/self%tension
      do offset = 0, count - 1, most_lanes
         number = min(most_lanes, count - offset)
         !$omp simd private(i)
         do l = 1, number
            i = offset + l
            factor(l) = max(rate(i)/self%reference_rate, 1.0_wp)
            power(l) = max(pressure(i)/self%compression, 0.0_wp)
         end do
         if (self%rate_coefficient > 0.0_wp) then
            call take_logarithms(number, factor)
         else
            factor(:number) = 0.0_wp
         end if
         call take_fast_powers(number, self%exponent, power)
         !$omp simd private(i, cohesion)
         do l = 1, number
            i = offset + l
            factor(l) = 1.0_wp + self%rate_coefficient*factor(l)
            cohesion = self%cohesion*(1.0_wp - damage(i)) &
               *max(0.0_wp, 1.0_wp + min(0.0_wp, pressure(i))*per_tension)
            power(l) = merge(self%hardening*power(l), 0.0_wp, pressure(i) > 0.0_wp)
            stress(i) = self%compression*min(self%limit, factor(l)*(cohesion + power(l)))
         end do
      end do
   end subroutine hjc_find_strengths
end module law_hjc
