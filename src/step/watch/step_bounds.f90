! SPDX-License-Identifier: BSD-3-Clause
!> Bounds on the state of particles, and the search for particles outside of them.
module step_bounds
   use base_kinds, only: int64, wp
   use particle_store, only: store_t
   implicit none
   private

   public :: bounds_t, count_bad, find_fault, find_steepest, guard_t, are_nodes_slow, &
      limiting_gradient

   integer, parameter, public :: rule_signal = 1      !! Limited by wave speed and motion
   integer, parameter, public :: rule_growth = 2      !! ... by growth from the previous step
   integer, parameter, public :: rule_strain = 3      !! ... by the velocity gradient
   integer, parameter, public :: rule_conduction = 4  !! ... by heat conduction
   integer, parameter, public :: rule_deck = 5        !! ... by dt_max or dt_fixed
   integer, parameter, public :: rule_end = 6         !! ... by t_end
   integer, parameter, public :: rule_retry = 7       !! ... by nodes that would move too far
   integer, parameter, public :: rules = 7            !! Number of these
   !> Their names in the summary.
   character(len=10), parameter, public :: rule_names(rules) = [character(len=10) :: "signal", &
      "growth", "strain", "conduction", "deck", "end", "retry"]

   integer, parameter, public :: fault_none = 0       !! No error
   integer, parameter, public :: fault_velocity = 1   !! Velocity is not a finite number
   integer, parameter, public :: fault_stress = 2     !! Stress is not a finite number
   integer, parameter, public :: fault_volume = 3     !! Volume is not a finite number
   integer, parameter, public :: fault_inverted = 4   !! Turned inside out
   integer, parameter, public :: fault_small = 5      !! Compressed beyond the bound
   integer, parameter, public :: fault_large = 6      !! Expanded beyond the bound
   integer, parameter, public :: fault_fast = 7       !! Faster than the bound

   !> Bounds in every step; unlimited until the deck sets them.
   type :: bounds_t
      real(wp) :: ratio_min = 0.0_wp                 !! Least volume over that at rest [1]
      real(wp) :: ratio_max = sqrt(huge(1.0_wp))     !! Greatest volume over that at rest [1]
      real(wp) :: speed_max = sqrt(huge(1.0_wp))     !! Greatest speed of a particle [m/s]
      real(wp) :: strain_max = sqrt(huge(1.0_wp))    !! Greatest dt |grad v| of a step [1]
      real(wp) :: collapse = 0.0_wp                  !! Least step over the longest so far [1]
      real(wp) :: dt_min = 0.0_wp                    !! Least step [s]
      real(wp) :: dt_fixed = 0.0_wp                  !! Fixed step, 0 = none [s]
      logical :: dt_free = .true.                    !! May a step be shortened?
      logical :: retire = .false.                    !! Are bad particles removed?
      real(wp) :: retire_max = 0.0_wp !! Greatest fraction of the mass that may be retired [1]
   end type bounds_t

   !> State of the time step control.
   type :: guard_t
      type(bounds_t) :: bounds                       !! Bounds of the state
      real(wp) :: longest = 0.0_wp                   !! Longest stable step so far [s]
      real(wp) :: rate = 0.0_wp                      !! Steepest velocity gradient of the step [1/s]
      integer(int64) :: steepest = huge(1_int64)     !! Identity of that particle if on this rank
      integer :: rule = rule_signal                  !! Limit of the next step
      integer(int64) :: steps(rules) = 0             !! Steps that each rule has limited
      integer :: counted = rule_signal               !! Rule by which the current step was counted
   end type guard_t

contains

   !> Number of particles of a tile with an invalid state. Comparisons with NaN are false, so NaN
   !! needs no test.
   pure real(wp) function count_bad(store, tile, density, bounds) result(bad)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: density                !! Density of their material at rest [kg/m3]
      type(bounds_t), intent(in) :: bounds           !! Bounds of the state
      integer :: first, last

      first = store%first(tile)
      last = first + store%count(tile) - 1
      bad = count_states(first, last, store%velocity, store%state%stress, store%state%volume, &
         store%state%mass, bounds%speed_max**2, bounds%ratio_min/density, bounds%ratio_max/density)
      if (allocated(store%state%deformation_gradient)) &
         bad = bad + count_inverted(first, last, store%state%deformation_gradient)
   end function count_bad

   !> Number of velocities and volumes of a range that are out of bounds, and one more if the sum of
   !! all stresses is not finite, as it is if any of them is NaN. Each comparison counts separately,
   !! so that the loop vectorises.
   pure real(wp) function count_states(first, last, velocity, stress, volume, mass, fastest, &
      least, most) result(bad)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: stress(:, :)   !! (particle, 6) [Pa]
      real(wp), contiguous, intent(in) :: volume(:)  !! (particle) [m3]
      real(wp), contiguous, intent(in) :: mass(:)    !! (particle) [kg]
      real(wp), intent(in) :: fastest                !! Square of the greatest speed [m2/s2]
      real(wp), intent(in) :: least                  !! Least volume per mass [m3/kg]
      real(wp), intent(in) :: most                   !! Greatest volume per mass [m3/kg]
      real(wp) :: square, load
      integer :: p

      bad = 0.0_wp
      load = 0.0_wp
      !$omp simd private(square) reduction(+:bad, load)
      do p = first, last
         square = velocity(p, 1)**2 + velocity(p, 2)**2 + velocity(p, 3)**2
         load = load + (stress(p, 1) + stress(p, 2) + stress(p, 3) + stress(p, 4) &
            + stress(p, 5) + stress(p, 6))
         bad = bad + merge(0.0_wp, 1.0_wp, square <= fastest) &
            + merge(0.0_wp, 1.0_wp, volume(p) >= mass(p)*least) &
            + merge(0.0_wp, 1.0_wp, volume(p) <= mass(p)*most)
      end do
      if (.not. abs(load) <= huge(load)) bad = bad + 1.0_wp
   end function count_states

   !> Number of inverted particles in a range.
   pure real(wp) function count_inverted(first, last, f) result(bad)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), contiguous, intent(in) :: f(:, :)    !! (particle, 9) Deformation gradient [1]
      integer :: p

      bad = 0.0_wp
      !$omp simd reduction(+:bad)
      do p = first, last
         bad = bad + merge(0.0_wp, 1.0_wp, f(p, 1)*(f(p, 5)*f(p, 9) - f(p, 8)*f(p, 6)) &
            - f(p, 4)*(f(p, 2)*f(p, 9) - f(p, 8)*f(p, 3)) &
            + f(p, 7)*(f(p, 2)*f(p, 6) - f(p, 5)*f(p, 3)) > 0.0_wp)
      end do
   end function count_inverted

   !> The fault of a particle as text, with its value.
   pure subroutine find_fault(store, p, density, bounds, fault, value)
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp), intent(in) :: density                !! Density of its material at rest [kg/m3]
      type(bounds_t), intent(in) :: bounds           !! Bounds of the state
      integer, intent(out) :: fault                  !! One of the faults above
      real(wp), intent(out) :: value                 !! Speed, stress or ratio of volumes
      real(wp) :: speed, stress, ratio, determinant

      determinant = 1.0_wp
      if (allocated(store%state%deformation_gradient)) then
         associate (f => store%state%deformation_gradient)
            determinant = f(p, 1)*(f(p, 5)*f(p, 9) - f(p, 8)*f(p, 6)) - f(p, 4)*(f(p, 2)*f(p, 9) &
               - f(p, 8)*f(p, 3)) + f(p, 7)*(f(p, 2)*f(p, 6) - f(p, 5)*f(p, 3))
         end associate
      end if
      speed = sqrt(store%velocity(p, 1)**2 + store%velocity(p, 2)**2 + store%velocity(p, 3)**2)
      stress = sum(abs(store%state%stress(p, :)))
      ratio = store%state%volume(p)*density/store%state%mass(p)
      fault = fault_none
      value = speed
      if (.not. speed <= huge(1.0_wp)) then
         fault = fault_velocity
      else if (.not. stress <= huge(1.0_wp)) then
         fault = fault_stress
         value = stress
      else if (.not. abs(ratio) <= huge(1.0_wp)) then
         fault = fault_volume
         value = ratio
      else if (.not. determinant > 0.0_wp) then
         fault = fault_inverted
         value = determinant
      else if (ratio < bounds%ratio_min) then
         fault = fault_small
         value = ratio
      else if (ratio > bounds%ratio_max) then
         fault = fault_large
         value = ratio
      else if (speed > bounds%speed_max) then
         fault = fault_fast
      end if
   end subroutine find_fault

   !> Record the steepest velocity gradient of a tile if it is the steepest so far and may limit the
   !! next step. Of particles with equal gradients the one with the lowest identity is recorded, so
   !! that the order of tiles has no effect. Most tiles have no such gradient; a vectorised count
   !! finds these tiles.
   pure subroutine find_steepest(gradient, identity, dt, matters, steepest, who)
      real(wp), contiguous, intent(in) :: gradient(:, :)    !! (particle, 9) dt du_k/dx_l [1]
      integer(int64), contiguous, intent(in) :: identity(:) !! (particle) Identities
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: matters                !! Smaller |grad v| do not limit steps [1/s]
      real(wp), intent(inout) :: steepest            !! Square of |grad v| so far [1/s2]
      integer(int64), intent(inout) :: who           !! Particle with this gradient
      real(wp), parameter :: rounding = 1.0e-12_wp
      real(wp) :: most, enough
      integer :: p

      enough = (1.0_wp - rounding)*max(steepest, matters**2)*dt**2
      if (.not. count_steep(size(identity), gradient, enough) > 0.5_wp) return
      most = 0.0_wp
      do p = 1, size(identity)
         most = max(most, norm_square(gradient, p))
      end do
      if (.not. (most > 0.0_wp .and. most/dt**2 >= steepest)) return
      if (most/dt**2 > steepest) who = huge(who)
      steepest = most/dt**2
      do p = 1, size(identity)
         if (norm_square(gradient, p) >= most) who = min(who, identity(p))
      end do
   end subroutine find_steepest

   !> Number of particles whose gradient has at least a given norm.
   pure real(wp) function count_steep(count, gradient, enough) result(steep)
      integer, intent(in) :: count                   !! Particles
      real(wp), contiguous, intent(in) :: gradient(:, :) !! (particle, 9)
      real(wp), intent(in) :: enough                 !! Square of the norm
      integer :: p

      steep = 0.0_wp
      !$omp simd reduction(+:steep)
      do p = 1, count
         steep = steep + merge(1.0_wp, 0.0_wp, gradient(p, 1)**2 + gradient(p, 2)**2 &
            + gradient(p, 3)**2 + gradient(p, 4)**2 + gradient(p, 5)**2 + gradient(p, 6)**2 &
            + gradient(p, 7)**2 + gradient(p, 8)**2 + gradient(p, 9)**2 >= enough)
      end do
   end function count_steep

   !> Is every component of the velocities of nodes within a bound? Counted in vectors.
   pure logical function are_nodes_slow(components, velocity, most) result(slow)
      integer, intent(in) :: components              !! Three for each node
      real(wp), intent(in) :: velocity(components)   !! One node after another [m/s]
      real(wp), intent(in) :: most                   !! The bound [m/s]
      real(wp) :: fast
      integer :: k

      fast = 0.0_wp
      !$omp simd reduction(+:fast)
      do k = 1, components
         fast = fast + merge(0.0_wp, 1.0_wp, abs(velocity(k)) <= most)
      end do
      slow = fast < 0.5_wp
   end function are_nodes_slow

   !> Least velocity gradient that can limit the next step, which is at most the previous step times
   !! its allowed growth [1/s].
   pure real(wp) function limiting_gradient(bounds, growth, dt) result(rate)
      type(bounds_t), intent(in) :: bounds           !! Bounds of the state
      real(wp), intent(in) :: growth                 !! Greatest ratio of two steps [1]
      real(wp), intent(in) :: dt                     !! Previous stable step [s]
      real(wp), parameter :: rounding = 1.0e-12_wp

      rate = 0.0_wp
      if (dt < huge(dt)/growth) rate = (1.0_wp - rounding)*bounds%strain_max/(growth*dt)
   end function limiting_gradient

   !> Square of the norm of a gradient.
   pure real(wp) function norm_square(gradient, p) result(norm)
      real(wp), contiguous, intent(in) :: gradient(:, :) !! (particle, 9)
      integer, intent(in) :: p

      norm = gradient(p, 1)**2 + gradient(p, 2)**2 + gradient(p, 3)**2 + gradient(p, 4)**2 &
         + gradient(p, 5)**2 + gradient(p, 6)**2 + gradient(p, 7)**2 + gradient(p, 8)**2 &
         + gradient(p, 9)**2
   end function norm_square
end module step_bounds
