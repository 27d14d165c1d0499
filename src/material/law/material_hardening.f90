! SPDX-License-Identifier: BSD-3-Clause
!> Radial return to a yield stress that hardens with a power of the plastic strain, for groups of
!! particles that are the lanes of vectors.
!!
!! Newton's method iterates all lanes of a group until the last one has converged. Converged lanes
!! do not change, so their bits do not depend on their neighbours.
module material_hardening
   use base_constants, only: most_lanes
   use base_elementary, only: take_fast_powers, take_logarithms
   use base_kinds, only: wp
   use material_law, only: mean_work
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: collect_lanes, flow_lanes_t, move_flow_results, solve_hardening

   integer, parameter :: width = 8                   !! Lanes are filled up to a multiple of it

   !> Floor of strains in divisors; two such divisions must not overflow in a converged lane.
   real(wp), parameter :: least_strain = 1.0e-100_wp

   !> Particles of a group that may flow. The yield stress of an increment x is
   !! min(fixed + amplitude (argument + growth x)**exponent, greatest), times a rate factor.
   type :: flow_lanes_t
      integer :: count = 0                           !! Lanes in use
      integer :: place(most_lanes)                   !! Position of a lane in its group
      real(wp) :: trial(most_lanes)                  !! Equivalent trial stress, above 0 [Pa]
      real(wp) :: stiffness(most_lanes)              !! 3 G of the trial, above 0 [Pa]
      real(wp) :: fixed(most_lanes) !! Part of the yield stress without hardening [Pa]
      real(wp) :: amplitude(most_lanes)              !! Factor of the power [Pa]
      real(wp) :: argument(most_lanes)               !! Base of the power at the start [1]
      real(wp) :: greatest(most_lanes)               !! Bound of the static yield stress [Pa]
      real(wp) :: increment(most_lanes)              !! Plastic increment (out) [1]
      real(wp) :: limit(most_lanes)                  !! Equivalent stress after the step (out) [Pa]
      real(wp) :: lower(most_lanes)                  !! Increment that is too small [1]
      real(wp) :: upper(most_lanes)                  !! Increment that is too large [1]
      real(wp) :: factor(most_lanes)                 !! Rate factor [1]
      real(wp) :: tilt(most_lanes)                   !! Derivative of the rate factor [1]
      real(wp) :: going(most_lanes) !! 1 until the lane has converged, then 0
   end type flow_lanes_t

   !> Constants of hardening, the same for all lanes.
   type, public :: hardening_power_t
      real(wp) :: exponent = 1.0_wp                  !! Exponent of the power [1]
      real(wp) :: growth = 1.0_wp                    !! Growth of the base per plastic increment [1]
      real(wp) :: rate_coefficient = 0.0_wp          !! C of the factor 1 + C ln(x/x0), 0: none [1]
      real(wp) :: rest = 0.0_wp !! x0, increment below which the factor is 1 [1]
   end type hardening_power_t

contains

   !> Collect the particles of a group whose trial stress is above a bound of the yield stress; the
   !! others do not flow. In most groups there are none.
   pure subroutine collect_lanes(offset, particles, bound, deformation, lanes)
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: particles               !! Of the group
      real(wp), contiguous, intent(in) :: bound(:)   !! Of the yield stress (range) [Pa]
      type(deformation_t), intent(inout) :: deformation !! With trial stresses of the range
      type(flow_lanes_t), intent(inout) :: lanes
      integer :: i, last, n

      lanes%count = 0
      last = offset + particles
      if (count(deformation%plastic_increment(offset + 1:last) > bound(offset + 1:last)) == 0) then
         deformation%plastic_increment(offset + 1:last) = 0.0_wp
         deformation%plastic_work(offset + 1:last) = 0.0_wp
         return
      end if
      do n = 1, particles
         i = offset + n
         if (deformation%plastic_increment(i) > bound(i)) then
            lanes%count = lanes%count + 1
            lanes%place(lanes%count) = n
            lanes%trial(lanes%count) = deformation%plastic_increment(i)
         else
            deformation%plastic_increment(i) = 0.0_wp
            deformation%plastic_work(i) = 0.0_wp
         end if
      end do
   end subroutine collect_lanes

   !> Plastic increment x of each lane from trial - 3 G x = Y(x), and the stress after the step.
   !!
   !! The left side decreases with x and the right side increases, so the root lies between 0 and
   !! the increment for the static yield stress before the step. A particle without strength flows
   !! without resistance and keeps its plastic strain. Equation (Y.5) of doc/theory/strength.md.
   pure subroutine solve_hardening(power, lanes)
      type(hardening_power_t), intent(in) :: power
      type(flow_lanes_t), intent(inout) :: lanes
      integer, parameter :: most_iterations = 200
      real(wp) :: base(most_lanes), hardening(most_lanes)
      integer :: filled, iteration

      filled = width*((lanes%count + width - 1)/width)
      call fill_lanes(filled, lanes)
      call raise(filled, power, lanes%amplitude, lanes%argument, hardening)
      call start_lanes(filled, power, hardening, lanes)
      do iteration = 1, most_iterations
         if (.not. any(lanes%going(:filled) > 0.0_wp)) exit
         base(:filled) = lanes%argument(:filled) + power%growth*lanes%increment(:filled)
         call raise(filled, power, lanes%amplitude, base, hardening)
         if (power%rate_coefficient > 0.0_wp) call find_rate_factor(filled, power, lanes)
         call improve(filled, power, base, hardening, lanes)
      end do
   end subroutine solve_hardening

   !> Fill lanes that are not in use with the first one.
   pure subroutine fill_lanes(filled, lanes)
      integer, intent(in) :: filled                  !! Lanes, a multiple of the width
      type(flow_lanes_t), intent(inout) :: lanes
      integer :: l

      do l = lanes%count + 1, filled
         lanes%trial(l) = lanes%trial(1)
         lanes%stiffness(l) = lanes%stiffness(1)
         lanes%fixed(l) = lanes%fixed(1)
         lanes%amplitude(l) = lanes%amplitude(1)
         lanes%argument(l) = lanes%argument(1)
         lanes%greatest(l) = lanes%greatest(1)
      end do
   end subroutine fill_lanes

   !> Hardening amplitude base**exponent.
   pure subroutine raise(filled, power, amplitude, base, hardening)
      integer, intent(in) :: filled                  !! Lanes
      type(hardening_power_t), intent(in) :: power
      real(wp), intent(in) :: amplitude(most_lanes)  !! [Pa]
      real(wp), intent(in) :: base(most_lanes)       !! [1]
      real(wp), intent(inout) :: hardening(most_lanes) !! [Pa]
      integer :: l

      hardening(:filled) = base(:filled)
      call take_fast_powers(filled, power%exponent, hardening)
      !$omp simd
      do l = 1, filled
         hardening(l) = amplitude(l)*hardening(l)
      end do
   end subroutine raise

   !> Lanes that flow, with the increment for linear hardening at the initial slope.
   pure subroutine start_lanes(filled, power, hardening, lanes)
      integer, intent(in) :: filled                  !! Lanes
      type(hardening_power_t), intent(in) :: power
      real(wp), intent(in) :: hardening(most_lanes)  !! Hardening at the start [Pa]
      type(flow_lanes_t), intent(inout) :: lanes
      real(wp) :: limit, slope, excess
      logical :: flows
      integer :: l

      !$omp simd private(limit, slope, excess, flows)
      do l = 1, filled
         limit = min(lanes%fixed(l) + hardening(l), lanes%greatest(l))
         excess = max(lanes%trial(l) - limit, 0.0_wp)
         flows = excess > 0.0_wp .and. limit > 0.0_wp
         lanes%going(l) = merge(1.0_wp, 0.0_wp, flows)
         lanes%limit(l) = min(limit, lanes%trial(l))
         lanes%lower(l) = 0.0_wp
         lanes%upper(l) = excess/lanes%stiffness(l)
         slope = power%exponent*power%growth*hardening(l)/max(lanes%argument(l), least_strain)
         slope = merge(slope, 0.0_wp, lanes%argument(l) > 0.0_wp .and. limit < lanes%greatest(l))
         slope = max(excess/(lanes%stiffness(l) + slope), least_strain)
         lanes%increment(l) = merge(slope, 0.0_wp, flows)
         lanes%factor(l) = 1.0_wp
         lanes%tilt(l) = 0.0_wp
      end do
   end subroutine start_lanes

   !> Factor of the rate, 1 + C ln(x/x0) but not below 1, and its derivative.
   pure subroutine find_rate_factor(filled, power, lanes)
      integer, intent(in) :: filled                  !! Lanes
      type(hardening_power_t), intent(in) :: power
      type(flow_lanes_t), intent(inout) :: lanes
      logical :: fast
      integer :: l

      !$omp simd
      do l = 1, filled
         lanes%factor(l) = max(lanes%increment(l)/power%rest, 1.0_wp)
      end do
      call take_logarithms(filled, lanes%factor)
      !$omp simd private(fast)
      do l = 1, filled
         fast = lanes%increment(l) > power%rest
         lanes%factor(l) = 1.0_wp + power%rate_coefficient*lanes%factor(l)
         lanes%tilt(l) = merge(power%rate_coefficient, 0.0_wp, fast) &
            /max(lanes%increment(l), tiny(1.0_wp))
      end do
   end subroutine find_rate_factor

   !> One step of Newton's method in the lanes that have not converged.
   !!
   !! A lane has converged if its stress is right to the tolerance, or if the second derivative of
   !! the yield stress bounds the error after a step that is short compared with the increment. A
   !! step beyond the upper end of the bracket is replaced by bisection. A step beyond the lower end
   !! is due to steep initial hardening far below; it shortens the bracket by a larger factor,
   !! because steps from below do not pass the root.
   pure subroutine improve(filled, power, base, hardening, lanes)
      integer, intent(in) :: filled                  !! Lanes
      type(hardening_power_t), intent(in) :: power
      real(wp), intent(in) :: base(most_lanes)       !! Base of the power [1]
      real(wp), intent(in) :: hardening(most_lanes)  !! [Pa]
      type(flow_lanes_t), intent(inout) :: lanes
      real(wp), parameter :: tolerance = 1.0e-12_wp, short = 0.25_wp, back = 1.0_wp/128.0_wp
      real(wp) :: exponent, growth, rest, at_rest, limit, slope, curvature, residual, change, x, &
         next
      real(wp) :: enough, lower, upper, margin, right, smooth
      integer :: l

      ! Constants in a conditional expression would be loaded lane by lane and prevent
      ! vectorisation.
      exponent = power%exponent
      growth = power%growth
      rest = power%rest
      !$omp simd private(at_rest, limit, slope, curvature, residual, change, x, next, enough) &
      !$omp& private(lower, upper, margin, right, smooth)
      do l = 1, filled
         x = lanes%increment(l)
         at_rest = min(lanes%fixed(l) + hardening(l), lanes%greatest(l))
         slope = merge(exponent*hardening(l)*growth, 0.0_wp, at_rest < lanes%greatest(l)) &
            /max(base(l), least_strain)
         limit = lanes%factor(l)*at_rest
         curvature = lanes%factor(l)*slope*abs(1.0_wp - exponent)*growth &
            /max(base(l), least_strain) + lanes%tilt(l)*(2.0_wp*slope + at_rest/max(x, &
               least_strain))
         slope = lanes%tilt(l)*at_rest + lanes%factor(l)*slope
         residual = lanes%trial(l) - lanes%stiffness(l)*x - limit
         enough = tolerance*limit
         right = merge(1.0_wp, 0.0_wp, abs(residual) <= enough &
            + 4.0_wp*epsilon(1.0_wp)*lanes%trial(l))
         lower = merge(x, lanes%lower(l), residual > 0.0_wp)
         upper = merge(lanes%upper(l), x, residual > 0.0_wp)
         change = residual/(lanes%stiffness(l) + slope)
         next = x + change
         ! no kink between x and next: neither at the greatest yield stress nor that of the rate
         ! factor
         margin = merge(lanes%greatest(l)*lanes%factor(l) - (limit + slope*change), residual, &
            at_rest < lanes%greatest(l))
         margin = min(margin, (x - rest)*(next - rest), short*x - abs(change), &
            enough - 2.0_wp*curvature*change*change)
         smooth = merge(1.0_wp - right, 0.0_wp, margin >= 0.0_wp)
         smooth = merge(smooth, 0.0_wp, min(next - lower, upper - next) > 0.0_wp)
         margin = next - lower
         next = merge(next, 0.5_wp*(lower + upper), next < upper)
         next = merge(next, lower + back*(upper - lower), margin > 0.0_wp)
         limit = limit + smooth*slope*change
         lanes%limit(l) = merge(limit, lanes%limit(l), lanes%going(l) > 0.0_wp)
         lanes%increment(l) = merge(next, x, lanes%going(l)*(1.0_wp - right) > 0.0_wp)
         lanes%lower(l) = lower
         lanes%upper(l) = upper
         lanes%going(l) = lanes%going(l)*(1.0_wp - right)*(1.0_wp - smooth)
      end do
   end subroutine improve

   !> Move results of lanes to the particles of a group: the plastic increment in place of the trial
   !! stress, and work, stress and plastic strain. Equations (Y.1) and (Y.2).
   pure subroutine move_flow_results(offset, before, lanes, state, deformation)
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: before                  !! Index offset in the store
      type(flow_lanes_t), intent(in) :: lanes
      type(material_state_t), intent(inout) :: state !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      real(wp) :: scaling
      integer :: i, k, l, component

      do l = 1, lanes%count
         i = offset + lanes%place(l)
         k = before + lanes%place(l)
         deformation%plastic_increment(i) = lanes%increment(l)
         state%plastic_strain(k) = state%plastic_strain(k) + lanes%increment(l)
         deformation%plastic_work(i) = state%volume(k)*mean_work(lanes%stiffness(l)/3.0_wp, &
            lanes%trial(l), lanes%limit(l), lanes%increment(l), deformation%plastic_work(i))
         scaling = lanes%limit(l)/lanes%trial(l)
         do component = 1, 6
            state%stress(k, component) = scaling*state%stress(k, component)
         end do
      end do
   end subroutine move_flow_results
end module material_hardening
