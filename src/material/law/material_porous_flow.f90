! SPDX-License-Identifier: BSD-3-Clause
!> Return of stresses to the yield surface of porous metal, for groups of particles that are the
!! lanes of vectors. Equations (D.1) to (D.7) of doc/theory/ductile.md.
!!
!! The flow is described by one unknown s >= 0; pressure, deviator, porosity and strength follow
!! from it in closed form. Converged lanes do not change, so their bits do not depend on their
!! neighbours.
module material_porous_flow
   use base_constants, only: most_lanes
   use base_elementary, only: take_exponentials, take_logarithms
   use base_kinds, only: wp
   implicit none
   private

   public :: find_excess, pore_lanes_t, porous_t, solve_flow

   !> Upper limit of the porosity, and of the fraction of strength that voids remove.
   real(wp), parameter :: most_porosity = 0.999_wp, most_weakening = 0.99_wp
   real(wp), parameter :: steepest = 300.0_wp        !! Argument of the hyperbolic functions [1]
   real(wp), parameter :: unbounded = 1.0e200_wp     !! No upper bound of s is known [1]
   real(wp), parameter :: tolerance = 1.0e-13_wp     !! Tolerance of the yield function [1]

   !> Constants of the material.
   type :: porous_t
      real(wp) :: shear = 0.0_wp                     !! Shear modulus [Pa]
      real(wp) :: hardening = 0.0_wp                 !! Slope of the strength of the matrix [Pa]
      real(wp) :: q1 = 1.5_wp                        !! Factor q1 of the porosity [1]
      real(wp) :: q2 = 1.0_wp                        !! Factor q2 of the pressure [1]
      real(wp) :: critical = 1.0_wp                  !! Porosity from which on voids join [1]
      real(wp) :: joining = 1.0_wp                   !! Growth of the weakening from there on [1]
      real(wp) :: least = 1.0e-6_wp                  !! Least porosity on closing [1]
   end type porous_t

   !> Particles of a group that flow.
   type :: pore_lanes_t
      integer :: count = 0                           !! Lanes in use
      integer :: particle(most_lanes)                !! Position of a lane in its group
      real(wp) :: trial(most_lanes)                  !! Equivalent trial stress [Pa]
      real(wp) :: trial_pressure(most_lanes)         !! [Pa]
      real(wp) :: bulk(most_lanes)                   !! Growth of p with the volume gained [Pa]
      real(wp) :: porosity(most_lanes)               !! Before the step in, after it out [1]
      real(wp) :: strength(most_lanes)               !! Strength of the matrix before the step [Pa]
      !> New pores per unit of strain; 0 without pores, because their volume cannot grow [1]
      real(wp) :: making(most_lanes)
      real(wp) :: making_later(most_lanes) !! New pores that count from the next step on [1]
      real(wp) :: scaling(most_lanes)                !! Factor of the deviator, on return [1]
      real(wp) :: pressure(most_lanes)               !! After the step (out) [Pa]
      real(wp) :: gained(most_lanes)                 !! Volume gained over that after it (out) [1]
      real(wp) :: strain(most_lanes)                 !! Plastic increment of the matrix (out) [1]
   end type pore_lanes_t

   !> Unknowns of the lanes.
   type :: search_t
      real(wp) :: start(most_lanes)                  !! Effective porosity before the step [1]
      real(wp) :: unit(most_lanes)                   !! Flow at s = 1 [1/Pa]
      real(wp) :: s(most_lanes)                      !! Present value [1]
      real(wp) :: last(most_lanes)                   !! Value before [1]
      real(wp) :: miss(most_lanes)                   !! Residual of the yield function at s [1]
      real(wp) :: last_miss(most_lanes)              !! Residual at the value before [1]
      real(wp) :: lower(most_lanes)                  !! Lower bound of s [1]
      real(wp) :: upper(most_lanes)                  !! Upper bound of s, huge: unknown [1]
      real(wp) :: going(most_lanes)                  !! 1 if s is to be found, else 0
      real(wp) :: porosity(most_lanes)               !! After the step [1]
   end type search_t

contains

   !> Effective porosity f*. Above the critical porosity voids coalesce and it increases faster.
   !! Equation (D.2).
   elemental real(wp) function effective(porosity, critical, joining, most) result(weakening)
      real(wp), intent(in) :: porosity               !! [1]
      real(wp), intent(in) :: critical               !! [1]
      real(wp), intent(in) :: joining                !! [1]
      real(wp), intent(in) :: most                   !! Bound of the result [1]

      weakening = min(most, porosity + (joining - 1.0_wp)*max(porosity - critical, 0.0_wp))
   end function effective

   !> Excess of the trial stresses of a group over the yield surface: the sum of its terms that load
   !! over those that resist, less 1. Equation (D.1).
   pure subroutine find_excess(porous, count, lanes, excess)
      type(porous_t), intent(in) :: porous
      integer, intent(in) :: count                   !! Particles
      type(pore_lanes_t), intent(in) :: lanes        !! Trial stresses, porosity and strength
      real(wp), intent(inout) :: excess(most_lanes)  !! [1]
      real(wp) :: most, weakening, q1, critical, joining, slope
      integer :: l

      q1 = porous%q1
      critical = porous%critical
      joining = porous%joining
      most = most_weakening/q1
      slope = 1.5_wp*porous%q2
      !$omp simd
      do l = 1, count
         excess(l) = min(steepest, slope*abs(lanes%trial_pressure(l))/lanes%strength(l))
      end do
      call take_exponentials(count, excess)
      !$omp simd private(weakening)
      do l = 1, count
         weakening = q1*effective(lanes%porosity(l), critical, joining, most)
         excess(l) = ((lanes%trial(l)/lanes%strength(l))**2 + weakening*(excess(l) &
            + 1.0_wp/excess(l)))/(1.0_wp + weakening**2) - 1.0_wp
      end do
   end subroutine find_excess

   !> Stress, porosity and strain after the step of lanes that flow, whose excess is positive.
   pure subroutine solve_flow(porous, lanes)
      type(porous_t), intent(in) :: porous
      type(pore_lanes_t), intent(inout) :: lanes
      integer, parameter :: most_iterations = 200
      type(search_t) :: search
      integer :: iteration

      call start_search(porous, lanes, search)
      call evaluate(porous, lanes, search)
      call close_pores(porous, lanes, search)
      do iteration = 1, most_iterations
         if (.not. any(search%going(:lanes%count) > 0.0_wp)) exit
         call evaluate(porous, lanes, search)
         call improve(lanes%count, search)
      end do
      lanes%porosity(:lanes%count) = search%porosity(:lanes%count)
   end subroutine solve_flow

   !> Bracket and unit of s of each lane. The unit is the step of Newton's method from the trial; s
   !! ends where pores close, if they do.
   pure subroutine start_search(porous, lanes, search)
      type(porous_t), intent(in) :: porous
      type(pore_lanes_t), intent(inout) :: lanes
      type(search_t), intent(inout) :: search
      real(wp) :: growth(most_lanes), miss(most_lanes), factor, argument, sinh_over, square, &
         steepness, closing, margin, excess, most, q1, critical, joining, slope, least, shear
      integer :: l

      q1 = porous%q1
      critical = porous%critical
      joining = porous%joining
      least = porous%least
      shear = porous%shear
      most = most_weakening/q1
      slope = 1.5_wp*porous%q2
      factor = 4.5_wp*q1*porous%q2**2
      call find_excess(porous, lanes%count, lanes, miss)
      !$omp simd
      do l = 1, lanes%count
         miss(l) = 1.0_wp + miss(l)
         growth(l) = min(steepest, slope*abs(lanes%trial_pressure(l))/lanes%strength(l))
      end do
      call take_logarithms(lanes%count, miss)
      call take_exponentials(lanes%count, growth)
      !$omp simd private(argument, sinh_over, square, steepness, closing, margin, excess)
      do l = 1, lanes%count
         search%start(l) = effective(lanes%porosity(l), critical, joining, most)
         argument = min(steepest, slope*abs(lanes%trial_pressure(l))/lanes%strength(l))
         sinh_over = sinh_ratio(argument, growth(l))
         square = (lanes%trial(l)/lanes%strength(l))**2
         excess = square + q1*search%start(l)*(growth(l) + 1.0_wp/growth(l))
         steepness = (12.0_wp*shear*square/sinh_over + 2.0_wp*q1*search%start(l)*argument**2 &
            *sinh_over*factor*search%start(l)*lanes%bulk(l))/excess
         search%unit(l) = miss(l)/max(steepness, tiny(1.0_wp))
         ! Volume to lose until pores are closed, and the plastic flow that closes them.
         closing = max(lanes%porosity(l) - least, 0.0_wp)/(1.0_wp - lanes%porosity(l))
         margin = factor*search%start(l)*(lanes%trial_pressure(l) - closing*lanes%bulk(l))
         search%upper(l) = closing/max(search%unit(l)*max(margin, 0.0_wp), tiny(1.0_wp))
         search%upper(l) = merge(search%upper(l), unbounded, margin > 0.0_wp)
         search%s(l) = merge(search%upper(l), 1.0_wp, margin > 0.0_wp)
         search%last(l) = 0.0_wp
         search%last_miss(l) = miss(l)
         search%lower(l) = 0.0_wp
         search%going(l) = 1.0_wp
         search%porosity(l) = lanes%porosity(l)
      end do
   end subroutine start_search

   !> sinh(x)/x from x and exp(x).
   elemental real(wp) function sinh_ratio(argument, growth) result(ratio)
      real(wp), intent(in) :: argument               !! x, not negative [1]
      real(wp), intent(in) :: growth                 !! exp(x) [1]
      real(wp), parameter :: small = 0.3_wp
      real(wp) :: square

      square = argument*argument
      ratio = 1.0_wp + square/6.0_wp*(1.0_wp + square/20.0_wp*(1.0_wp + square/42.0_wp*(1.0_wp &
         + square/72.0_wp*(1.0_wp + square/110.0_wp))))
      ratio = merge(ratio, 0.5_wp*(growth - 1.0_wp/growth)/max(argument, small), argument < small)
   end function sinh_ratio

   !> State at s and the residual of the yield function there, the logarithm of loading over
   !! resisting terms, in the lanes that have not converged. Equations (D.3), (D.4), (D.5), (D.6)
   !! and (D.7).
   pure subroutine evaluate(porous, lanes, search)
      type(porous_t), intent(in) :: porous
      type(pore_lanes_t), intent(inout) :: lanes
      type(search_t), intent(inout) :: search
      real(wp) :: growth(most_lanes), now(most_lanes), pressure(most_lanes), gained(most_lanes), &
         shrinking(most_lanes), weakening(most_lanes), strain(most_lanes), square(most_lanes)
      real(wp) :: flow, amount, argument, work, most, q1, critical, joining, slope, shear, &
         hardening, factor
      integer :: l, count

      count = lanes%count
      q1 = porous%q1
      critical = porous%critical
      joining = porous%joining
      shear = porous%shear
      hardening = porous%hardening
      most = most_weakening/q1
      slope = 1.5_wp*porous%q2
      factor = 4.5_wp*q1*porous%q2**2
      !$omp simd private(flow, amount)
      do l = 1, count
         flow = search%unit(l)*search%s(l)
         amount = flow*factor*search%start(l)
         pressure(l) = lanes%trial_pressure(l)/(1.0_wp + amount*lanes%bulk(l))
         gained(l) = -amount*pressure(l)
         now(l) = min(most_porosity, lanes%porosity(l) + (1.0_wp - lanes%porosity(l))*gained(l))
         weakening(l) = effective(now(l), critical, joining, most)
         growth(l) = min(steepest, slope*abs(pressure(l))/lanes%strength(l))
      end do
      call take_exponentials(count, growth)
      !$omp simd private(flow, amount, argument, work)
      do l = 1, count
         flow = search%unit(l)*search%s(l)
         argument = min(steepest, slope*abs(pressure(l))/lanes%strength(l))
         amount = merge(weakening(l)/max(search%start(l), tiny(1.0_wp)), 1.0_wp, &
            search%start(l) > 0.0_wp)
         flow = flow/max(amount*sinh_ratio(argument, growth(l)), tiny(1.0_wp))
         shrinking(l) = 1.0_wp/(1.0_wp + 6.0_wp*shear*flow)
         work = max(0.0_wp, 2.0_wp*flow*(shrinking(l)*lanes%trial(l))**2 &
            - pressure(l)*gained(l))/(1.0_wp - now(l))
         strain(l) = 2.0_wp*work/(lanes%strength(l) + sqrt(lanes%strength(l)**2 &
            + 4.0_wp*hardening*work))
         now(l) = min(most_porosity, now(l) + lanes%making(l)*strain(l))
         weakening(l) = effective(now(l), critical, joining, most)
         work = lanes%strength(l) + hardening*strain(l)
         square(l) = (shrinking(l)*lanes%trial(l)/work)**2
         growth(l) = min(steepest, slope*abs(pressure(l))/work)
      end do
      call take_exponentials(count, growth)
      !$omp simd
      do l = 1, count
         growth(l) = (square(l) + q1*weakening(l)*(growth(l) + 1.0_wp/growth(l))) &
            /(1.0_wp + (q1*weakening(l))**2)
         growth(l) = max(growth(l), tiny(1.0_wp))
      end do
      call take_logarithms(count, growth)
      !$omp simd
      do l = 1, count
         search%miss(l) = merge(growth(l), search%miss(l), search%going(l) > 0.0_wp)
         search%porosity(l) = merge(now(l), search%porosity(l), search%going(l) > 0.0_wp)
         lanes%scaling(l) = merge(shrinking(l), lanes%scaling(l), search%going(l) > 0.0_wp)
         lanes%pressure(l) = merge(pressure(l), lanes%pressure(l), search%going(l) > 0.0_wp)
         lanes%gained(l) = merge(gained(l), lanes%gained(l), search%going(l) > 0.0_wp)
         lanes%strain(l) = merge(strain(l), lanes%strain(l), search%going(l) > 0.0_wp)
      end do
   end subroutine evaluate

   !> Lanes in which pressure closes the pores: they lose their volume, and the matrix flows alone.
   !! The others start at s = 1, or in the middle of a smaller bracket.
   pure subroutine close_pores(porous, lanes, search)
      type(porous_t), intent(in) :: porous
      type(pore_lanes_t), intent(inout) :: lanes
      type(search_t), intent(inout) :: search        !! With the residual at its first s
      real(wp) :: remaining, share, lost, limit, increment, q1, least, shear, hardening
      logical :: bounded, closed
      integer :: l

      q1 = porous%q1
      least = porous%least
      shear = porous%shear
      hardening = porous%hardening
      !$omp simd private(remaining, share, lost, limit, increment, bounded, closed)
      do l = 1, lanes%count
         bounded = search%upper(l) < unbounded
         closed = bounded .and. search%miss(l) > 0.0_wp
         remaining = min(lanes%porosity(l), least)
         lost = (remaining - lanes%porosity(l))/(1.0_wp - lanes%porosity(l))
         share = 1.0_wp - q1*remaining
         limit = share*lanes%strength(l)
         increment = max(lanes%trial(l) - limit, 0.0_wp)/(3.0_wp*shear + share**2*hardening)
         limit = min(lanes%trial(l), limit + share**2*hardening*increment)
         lanes%scaling(l) = merge(limit/max(lanes%trial(l), tiny(1.0_wp)), lanes%scaling(l), closed)
         lanes%pressure(l) = merge(lanes%trial_pressure(l) + lanes%bulk(l)*lost, &
            lanes%pressure(l), closed)
         lanes%gained(l) = merge(lost, lanes%gained(l), closed)
         lanes%strain(l) = merge(share*increment, lanes%strain(l), closed)
         search%porosity(l) = merge(remaining, search%porosity(l), closed)
         search%going(l) = merge(0.0_wp, 1.0_wp, closed)
         search%s(l) = min(1.0_wp, 0.5_wp*search%upper(l))
      end do
   end subroutine close_pores

   !> Next s of each lane: a secant step if it remains in the bracket and the residual was halved,
   !! otherwise the middle of the bracket, or twice the value while the bracket has no upper end.
   pure subroutine improve(count, search)
      integer, intent(in) :: count                   !! Lanes
      type(search_t), intent(inout) :: search
      real(wp) :: next, middle, slope, change
      logical :: fits
      integer :: l

      !$omp simd private(next, middle, slope, change, fits)
      do l = 1, count
         search%lower(l) = merge(search%s(l), search%lower(l), search%miss(l) > 0.0_wp)
         search%upper(l) = merge(search%upper(l), search%s(l), search%miss(l) > 0.0_wp)
         middle = merge(0.5_wp*(search%lower(l) + search%upper(l)), 2.0_wp*search%lower(l) &
            + 1.0_wp, search%upper(l) < unbounded)
         slope = search%miss(l) - search%last_miss(l)
         change = search%miss(l)*(search%s(l) - search%last(l))
         next = search%s(l) - change/merge(slope, 1.0_wp, abs(slope) > 0.0_wp)
         fits = abs(slope) > 0.0_wp .and. next > search%lower(l) .and. next < search%upper(l) &
            .and. abs(search%miss(l)) <= 0.5_wp*abs(search%last_miss(l))
         search%going(l) = merge(0.0_wp, search%going(l), abs(search%miss(l)) <= tolerance .or. &
            search%upper(l) - search%lower(l) <= 4.0_wp*epsilon(1.0_wp)*search%upper(l))
         search%last(l) = search%s(l)
         search%last_miss(l) = search%miss(l)
         search%s(l) = merge(next, middle, fits)
      end do
   end subroutine improve
end module material_porous_flow
