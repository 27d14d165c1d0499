! SPDX-License-Identifier: BSD-3-Clause
!> Brittle failure where the load of a particle reaches 1: the greatest principal stress over the
!! strength, or in compression half the difference of the principal stresses over that of shear; or
!! the greatest principal value of the elastic strain, s/(2 G) - p/(3 K), over its limit.
!!
!! Failure under a load is delayed: cracks nucleate and grow, and a greater load makes them grow
!! faster. F. R. Tuler, B. M. Butcher, Int. J. Fract. Mech. 4 (1968) 431:
!!
!!    dD/dt = x**n/tau,    x = load over strength - 1 > 0,    failed at D = 1.
!!
!! n = 0 gives a constant delay; then the overload x is not a field of the particles. Equations
!! (F.1) to (F.4) of doc/theory/failure.md.
module material_overload
   use base_elementary, only: power
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use material_brittle, only: bound_deviator, find_extremes, weibull_t
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: mean_power, overload_t, read_overload

   !> Upper bound of the overload. Material at this bound fails at once, and powers remain finite.
   real(wp), parameter :: most_overload = 1.0e9_wp

   !> A limit that does not overflow when multiplied by random factors.
   real(wp), parameter, public :: no_limit = sqrt(huge(1.0_wp))

   !> Failure by a principal stress or strain.
   type, abstract, extends(damage_t) :: overload_t
      real(wp) :: strength = no_limit                !! Greatest principal stress [Pa]
      real(wp) :: crushing = no_limit                !! Greatest shear stress [Pa]
      real(wp) :: limit = 0.0_wp !! Greatest principal strain; 0: the limits are stresses [1]
      real(wp) :: delay = 0.0_wp !! Time to failure at twice the strength, tau [s]
      real(wp) :: power = 0.0_wp                     !! Exponent n of the delay [1]
      type(weibull_t), allocatable :: weibull        !! Only if strength scatters
   contains
      procedure :: fault => overload_fault           !! Error in the combination of its keys
      procedure :: needs_flow => overload_needs_flow !! Returns false
      procedure :: needs_weibull => overload_needs_weibull !! If its strength scatters
      procedure :: request => overload_request       !! Requests damage and scatter
      procedure :: strength_of => overload_strength_of !! Strength of material with a flaw
      procedure :: update => overload_update         !! Failure
   end type overload_t

contains

   !> Error in the combination of its keys; empty if there is none.
   pure function overload_fault(self, group, law) result(text)
      class(overload_t), intent(in) :: self
      type(group_t), intent(in) :: group                  !! &material
      class(law_t), allocatable, intent(in) :: law        !! Law of strength, if there is one
      character(len=:), allocatable :: text
      real(wp) :: time, power

      text = ""
      if (.not. (group%known("failure_delay") .and. group%known("failure_delay_power"))) return
      call group%get("failure_delay", time)
      call group%get("failure_delay_power", power)
      if (power > 0.0_wp .and. .not. time > 0.0_wp) text = "failure_delay_power needs "// &
         "failure_delay [s], the time to failure at twice the strength; without it failure "// &
         "is immediate [D442]"
   end function overload_fault

   !> It does not use the plastic strain.
   pure logical function overload_needs_flow(self) result(needs)
      class(overload_t), intent(in) :: self

      needs = .false.
   end function overload_needs_flow

   !> Its strength may scatter.
   pure logical function overload_needs_weibull(self, scatter) result(needs)
      class(overload_t), intent(in) :: self
      logical, intent(in) :: scatter                      !! Switch size_scatter of &effects

      needs = scatter
   end function overload_needs_weibull

   !> Read the keys of delay and scatter.
   pure subroutine read_overload(model, group, effects)
      class(overload_t), intent(inout) :: model
      type(group_t), intent(in) :: group                  !! &material
      type(effects_t), intent(in) :: effects

      call group%get("failure_delay", model%delay)
      call group%get("failure_delay_power", model%power)
      if (.not. effects%size_scatter) return
      allocate (model%weibull)
      if (group%given("weibull_m")) call group%get("weibull_m", model%weibull%modulus)
      if (group%given("weibull_volume")) call group%get("weibull_volume", model%weibull%volume)
   end subroutine read_overload

   !> Damage, and a separate strength for each particle.
   pure subroutine overload_request(self, requests)
      class(overload_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model "//merge("principal_strain", &
         "principal_stress", self%limit > 0.0_wp), 1)
      if (self%power > 0.0_wp) call requests%add("overload", "failure_delay_power", 1)
      if (allocated(self%weibull)) call requests%add("scatter", "size_scatter", 1)
   end subroutine overload_request

   !> Strength of a particle divided by the characteristic strength, from the level of its weakest
   !! flaw. Equation (F.5).
   pure real(wp) function overload_strength_of(self, level) result(strength)
      class(overload_t), intent(in) :: self
      real(wp), intent(in) :: level                        !! [1/m3]

      strength = 1.0_wp
      if (allocated(self%weibull)) strength = power(level*self%weibull%volume, &
         1.0_wp/self%weibull%modulus)
   end function overload_strength_of

   !> Growth of damage in a step whose load is known at its end. Where a load is below 1, and was
   !! below 1 before, an upper bound of it is sufficient: few particles are near their strength, and
   !! only these need principal values. Equations (F.3) and (F.4).
   pure subroutine overload_update(self, state, deformation, first, last, dt)
      class(overload_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: load, before, factor, greatest, least
      integer :: i, k

      call bound_loads(self, state, deformation, first, last)
      before = 0.0_wp
      if (.not. allocated(state%brittle%overload)) then
         if (count(deformation%damage%load(:last - first + 1) >= 1.0_wp) == 0) return
      end if
      factor = 1.0_wp
      do i = 1, last - first + 1
         k = first - 1 + i
         load = deformation%damage%load(i)
         if (allocated(state%brittle%overload)) before = state%brittle%overload(k)
         if (load >= 1.0_wp .or. before > 0.0_wp) then
            if (allocated(self%weibull)) factor = state%brittle%scatter(k)
            call find_extremes(state%stress, k, greatest, least)
            load = max((greatest - deformation%pressure(i))/(self%strength*factor), &
               0.5_wp*(greatest - least)/(self%crushing*factor))
            if (self%limit > 0.0_wp) load = (0.5_wp*greatest/self%shear &
               - deformation%pressure(i)/(3.0_wp*self%bulk))/(self%limit*factor)
         end if
         if (allocated(state%brittle%overload)) then
            if (load > 1.0_wp .or. before > 0.0_wp) state%damage(k) = min(1.0_wp, &
               state%damage(k) + dt/self%delay*mean_power(before, load - 1.0_wp, self%power))
            state%brittle%overload(k) = load - 1.0_wp
         else if (load >= 1.0_wp .and. self%delay > dt) then
            state%damage(k) = min(1.0_wp, state%damage(k) + dt/self%delay)
         else if (load >= 1.0_wp) then
            state%damage(k) = 1.0_wp
         end if
      end do
   end subroutine overload_update

   !> Upper bounds of the loads; of stresses the greater one of tension and shear.
   pure subroutine bound_loads(model, state, deformation, first, last)
      class(overload_t), intent(in) :: model
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Gets the loads
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: strength, crushing, limit, shear, bulk, factor
      integer :: i

      call bound_deviator(first, last, state%stress, deformation%damage%bound)
      deformation%damage%load(:last - first + 1) = 1.0_wp
      if (allocated(model%weibull)) &
         deformation%damage%load(:last - first + 1) = state%brittle%scatter(first:last)
      strength = model%strength
      crushing = model%crushing
      limit = model%limit
      shear = model%shear
      bulk = model%bulk
      if (limit > 0.0_wp .and. .not. bulk > 0.0_wp) then
         ! A gas has no bulk modulus at rest and no elastic strain.
         deformation%damage%load(:last - first + 1) = 0.0_wp
      else if (limit > 0.0_wp) then
         do concurrent (i=1:last - first + 1)
            factor = deformation%damage%load(i)
            deformation%damage%load(i) = (0.5_wp*deformation%damage%bound(i)/shear &
               - deformation%pressure(i)/(3.0_wp*bulk))/(limit*factor)
         end do
      else
         do concurrent (i=1:last - first + 1)
            factor = deformation%damage%load(i)
            deformation%damage%load(i) = max((deformation%damage%bound(i) &
               - deformation%pressure(i))/(strength*factor), &
               deformation%damage%bound(i)/(crushing*factor))
         end do
      end if
   end subroutine bound_loads

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
end module material_overload
