! SPDX-License-Identifier: BSD-3-Clause
!> Delay of failure under a load above the strength: cracks nucleate and grow, and a greater load
!! makes them grow faster. F. R. Tuler, B. M. Butcher, Int. J. Fract. Mech. 4 (1968) 431:
!!
!!    dD/dt = x**n/tau,    x = load over strength - 1 > 0,    failed at D = 1.
!!
!! n = 0 gives a constant delay; then the overload x is not a field of the particles. Equations
!! (F.3) and (F.4) of doc/theory/failure.md.
module material_delay
   use base_elementary, only: power
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_field_requests, only: field_requests_t
   implicit none
   private

   public :: age_damage, declare_delay, delay_fault, delay_t, mean_power

   !> Upper bound of the overload. Material at this bound fails at once, and powers remain finite.
   real(wp), parameter :: most_overload = 1.0e9_wp

   !> Delay of failure.
   type :: delay_t
      real(wp) :: time = 0.0_wp !! Time to failure at twice the strength, tau [s]
      real(wp) :: power = 0.0_wp                     !! n [1]
   contains
      procedure :: read => delay_read                !! Reads its keys
      procedure :: request => delay_request          !! Requests the overload, if it is needed
      procedure :: grow_damage => delay_grow_damage  !! Growth of damage by the overload
   end type delay_t

contains

   !> Declare the keys.
   subroutine declare_delay(schema)
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = principal_stress "// &
         "principal_strain"

      call schema%real("material", "failure_delay", &
         "time to failure under a load above the strength", unit="s", default="0", range=">= 0", &
         owner=owner)
      call schema%real("material", "failure_delay_power", "exponent p of the time to failure, "// &
         "failure_delay / (load/strength - 1)**p; with 0 it does not depend on the load", &
         default="0", range=">= 0 <= 30", owner=owner)
   end subroutine declare_delay

   !> Error in the combination of the keys; empty if there is none.
   pure function delay_fault(group) result(text)
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: text
      real(wp) :: time, power

      text = ""
      if (.not. (group%known("failure_delay") .and. group%known("failure_delay_power"))) return
      call group%get("failure_delay", time)
      call group%get("failure_delay_power", power)
      if (power > 0.0_wp .and. .not. time > 0.0_wp) text = "failure_delay_power needs "// &
         "failure_delay [s], the time to failure at twice the strength; without it failure "// &
         "is immediate"
   end function delay_fault

   !> Read the keys.
   pure subroutine delay_read(self, group)
      class(delay_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material

      call group%get("failure_delay", self%time)
      call group%get("failure_delay_power", self%power)
   end subroutine delay_read

   !> Overload of particles, if the delay depends on it.
   pure subroutine delay_request(self, requests)
      class(delay_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      if (self%power > 0.0_wp) call requests%add("overload", "failure_delay_power", 1)
   end subroutine delay_request

   !> Damage of a particle that was above its strength for a step, with a constant delay. Equation
   !! (F.3).
   pure real(wp) function age_damage(damage, delay, dt) result(grown)
      real(wp), intent(in) :: damage                 !! Before the step [1]
      real(wp), intent(in) :: delay                  !! Time to failure [s]
      real(wp), intent(in) :: dt                     !! Time step [s]

      grown = 1.0_wp
      if (delay > dt) grown = min(1.0_wp, damage + dt/delay)
   end function age_damage

   !> Mean over a step of the power of an overload that changes linearly; negative
   !! values count as zero. Equation (F.4).
   pure real(wp) function mean_power(before, now, n) result(mean)
      real(wp), intent(in) :: before                 !! Overload before the step [1]
      real(wp), intent(in) :: now                    !! After it [1]
      real(wp), intent(in) :: n                      !! Exponent [1]
      ! For a smaller relative change the rounding error of the difference of powers exceeds the
      ! truncation error of the series.
      real(wp), parameter :: narrow = 1.0e-3_wp
      real(wp) :: lower, upper, middle, width

      mean = 0.0_wp
      upper = min(max(before, now), most_overload)
      if (.not. upper > 0.0_wp) return
      lower = min(before, now, most_overload)
      middle = 0.5_wp*(lower + upper)
      width = upper - lower
      if (width < narrow*middle) then
         mean = power(middle, n)*(1.0_wp + n*(n - 1.0_wp)/24.0_wp*(width/middle)**2)
      else
         mean = power(upper, n)*(1.0_wp - power(max(lower, 0.0_wp)/upper, n + 1.0_wp)) &
            *upper/((n + 1.0_wp)*width)
      end if
   end function mean_power

   !> Growth of damage in a step whose load is known at its end.
   pure subroutine delay_grow_damage(self, first, last, dt, load, overload, damage)
      class(delay_t), intent(in) :: self
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(in) :: load(:)    !! Over strength, after the step (range) [1]
      real(wp), contiguous, intent(inout) :: overload(:) !! Of the last step in, of this step out
      real(wp), contiguous, intent(inout) :: damage(:) !! (store) [1]
      integer :: i, k

      do i = 1, last - first + 1
         k = first - 1 + i
         if (load(i) > 1.0_wp .or. overload(k) > 0.0_wp) damage(k) = min(1.0_wp, damage(k) &
            + dt/self%time*mean_power(overload(k), load(i) - 1.0_wp, self%power))
         overload(k) = load(i) - 1.0_wp
      end do
   end subroutine delay_grow_damage
end module material_delay
