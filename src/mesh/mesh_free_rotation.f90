! SPDX-License-Identifier: BSD-3-Clause
!> Rotation of a rigid body on which no torque acts, and quaternions.
!!
!! The angular momentum in space is constant; the body turns around it. In the frame of the body it
!! follows Euler's equations, whose invariants, its square and the energy, are quadratic: a Gauss
!! method conserves both (Hairer, Lubich, Wanner, Geometric Numerical Integration, section IV.2).
!! Equations (R.11) and (R.12) of doc/theory/rigid.md.
module mesh_free_rotation
   use base_elementary, only: cross
   use base_kinds, only: wp
   implicit none
   private

   public :: product_of_turns, rotate_freely, matrix_of_turn, turn_by, turned, turned_back

   real(wp), parameter :: longest_turn = 0.1_wp      !! Bound on the angle of a part of a step [rad]
   integer, parameter :: stages = 3                  !! Of the Gauss method of order 6
   integer, parameter :: rounds = 40                 !! Most iterations for the stages
   real(wp), parameter :: root = 3.8729833462074169_wp !! Square root of 15
   real(wp), parameter :: weights(stages) = [5.0_wp, 8.0_wp, 5.0_wp]/18.0_wp
   !> (stage, stage) Coefficients of the Gauss method; a column are the weights for one stage.
   real(wp), parameter :: coefficients(stages, stages) = reshape([ &
      5.0_wp/36.0_wp, 2.0_wp/9.0_wp - root/15.0_wp, 5.0_wp/36.0_wp - root/30.0_wp, &
      5.0_wp/36.0_wp + root/24.0_wp, 2.0_wp/9.0_wp, 5.0_wp/36.0_wp - root/24.0_wp, &
      5.0_wp/36.0_wp + root/30.0_wp, 2.0_wp/9.0_wp + root/15.0_wp, 5.0_wp/36.0_wp], &
      [stages, stages])

contains

   !> Matrix of a unit quaternion: turns a vector of the body into space.
   pure function matrix_of_turn(turn) result(matrix)
      real(wp), intent(in) :: turn(4)                !! Scalar part first
      real(wp) :: matrix(3, 3)

      associate (a => turn(1), b => turn(2), c => turn(3), d => turn(4))
         matrix(:, 1) = [a*a + b*b - c*c - d*d, 2.0_wp*(b*c + a*d), 2.0_wp*(b*d - a*c)]
         matrix(:, 2) = [2.0_wp*(b*c - a*d), a*a - b*b + c*c - d*d, 2.0_wp*(c*d + a*b)]
         matrix(:, 3) = [2.0_wp*(b*d + a*c), 2.0_wp*(c*d - a*b), a*a - b*b - c*c + d*d]
      end associate
   end function matrix_of_turn

   !> Product of a matrix and a vector. The sums are written out: the library's `matmul` has kernels
   !! for several processors, whose last bits differ.
   pure function turned(matrix, vector) result(product)
      real(wp), intent(in) :: matrix(3, 3)           !! Any
      real(wp), intent(in) :: vector(3)              !! In the body, if the matrix is a rotation
      real(wp) :: product(3)

      product = matrix(:, 1)*vector(1) + matrix(:, 2)*vector(2) + matrix(:, 3)*vector(3)
   end function turned

   !> Product of the transpose of a matrix and a vector: from space into the body.
   pure function turned_back(matrix, vector) result(product)
      real(wp), intent(in) :: matrix(3, 3)           !! Rotation
      real(wp), intent(in) :: vector(3)              !! In space
      real(wp) :: product(3)

      product = matrix(1, :)*vector(1) + matrix(2, :)*vector(2) + matrix(3, :)*vector(3)
   end function turned_back

   !> Sum of the rates of the stages with the weights of one of them.
   pure function combined(rates, shares) result(sum_of_rates)
      real(wp), intent(in) :: rates(:, :)            !! (component, stage)
      real(wp), intent(in) :: shares(stages)
      real(wp) :: sum_of_rates(size(rates, 1))

      sum_of_rates = rates(:, 1)*shares(1) + rates(:, 2)*shares(2) + rates(:, 3)*shares(3)
   end function combined

   !> Product of two quaternions: the turn by the second, then by the first.
   pure function product_of_turns(first, second) result(turn)
      real(wp), intent(in) :: first(4)               !! Scalar part first
      real(wp), intent(in) :: second(4)              !! Scalar part first
      real(wp) :: turn(4)

      turn(1) = first(1)*second(1) - dot_product(first(2:), second(2:))
      turn(2:) = first(1)*second(2:) + second(1)*first(2:) + cross(first(2:), second(2:))
   end function product_of_turns

   !> The unit quaternion of a turn about a vector by its length. The series of sine and cosine are
   !! summed for the angle divided by a power of two, and the turn is squared as often.
   pure function turn_by(vector) result(turn)
      real(wp), intent(in) :: vector(3)              !! Angle along the axis [rad]
      real(wp) :: turn(4)
      real(wp), parameter :: small = 0.1_wp          ! half angle for the series
      integer, parameter :: terms = 7                ! the next one is below rounding
      real(wp) :: half(3), square, sine, cosine
      integer :: n, halvings

      half = 0.5_wp*vector
      halvings = 0
      do while (maxval(abs(half)) > small)
         half = 0.5_wp*half
         halvings = halvings + 1
      end do
      square = dot_product(half, half)
      sine = 1.0_wp
      cosine = 1.0_wp
      do n = terms, 1, -1
         cosine = 1.0_wp - square/real((2*n - 1)*(2*n), wp)*cosine
         sine = 1.0_wp - square/real((2*n)*(2*n + 1), wp)*sine
      end do
      turn = [cosine, sine*half]
      do n = 1, halvings
         turn = product_of_turns(turn, turn)
      end do
      turn = turn/norm2(turn)
   end function turn_by

   !> Turn a body for a time without torque. The energy is that of the start of the free motion, so
   !! rounding does not accumulate in it.
   pure subroutine rotate_freely(mobility, momentum, energy, time, turn)
      real(wp), intent(in) :: mobility(3, 3)         !! Inverse inertia, body frame [1/(kg m2)]
      real(wp), intent(in) :: momentum(3)            !! Angular momentum, in space [kg m2/s]
      real(wp), intent(in) :: energy                 !! Of the rotation [J]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(inout) :: turn(4)             !! Unit quaternion, body to space
      real(wp) :: own(3), step
      integer :: n, parts

      if (.not. maxval(abs(momentum)) > 0.0_wp) return
      ! a bound on the angular velocity: the norm of the inverse inertia
      parts = 1 + int(sqrt(sum(mobility**2))*norm2(momentum)*time/longest_turn)
      step = time/real(parts, wp)
      do n = 1, parts
         own = turned_back(matrix_of_turn(turn), momentum)
         call gauss_step(mobility, step, own, turn)
         call restore_invariants(mobility, norm2(momentum), energy, own)
         call align(momentum, own, turn)
      end do
   end subroutine rotate_freely

   !> A step of the Gauss method for angular momentum and quaternion.
   pure subroutine gauss_step(mobility, step, own, turn)
      real(wp), intent(in) :: mobility(3, 3)         !! Inverse inertia [1/(kg m2)]
      real(wp), intent(in) :: step                   !! [s]
      real(wp), intent(inout) :: own(3)              !! Angular momentum in the body [kg m2/s]
      real(wp), intent(inout) :: turn(4)             !! Quaternion
      real(wp) :: rate(3, stages), spin(3, stages), swing(4, stages), before, change
      real(wp) :: place(4)
      integer :: n, k

      rate = 0.0_wp
      before = huge(before)
      do n = 1, rounds
         change = 0.0_wp
         do k = 1, stages
            place(:3) = own + step*combined(rate, coefficients(:, k))
            spin(:, k) = turned(mobility, place(:3))
            place(:3) = cross(place(:3), spin(:, k))
            change = max(change, maxval(abs(place(:3) - rate(:, k))))
            rate(:, k) = place(:3)
         end do
         ! it has converged when rounding lets changes shrink no more
         if (.not. change < before) exit
         before = change
      end do
      swing = 0.0_wp
      before = huge(before)
      do n = 1, rounds
         change = 0.0_wp
         do k = 1, stages
            place = turn + step*combined(swing, coefficients(:, k))
            place = 0.5_wp*product_of_turns(place, [0.0_wp, spin(:, k)])
            change = max(change, maxval(abs(place - swing(:, k))))
            swing(:, k) = place
         end do
         if (.not. change < before) exit
         before = change
      end do
      own = own + step*combined(rate, weights)
      turn = turn + step*combined(swing, weights)
   end subroutine gauss_step

   !> Remove the rounding from the two invariants of the angular momentum in the body. Where their
   !! gradients are nearly parallel, near a principal axis, the energy follows from the length.
   pure subroutine restore_invariants(mobility, length, energy, own)
      real(wp), intent(in) :: mobility(3, 3)         !! Inverse inertia [1/(kg m2)]
      real(wp), intent(in) :: length                 !! Of the angular momentum [kg m2/s]
      real(wp), intent(in) :: energy                 !! [J]
      real(wp), intent(inout) :: own(3)              !! Angular momentum in the body [kg m2/s]
      real(wp), parameter :: parallel = 1.0e-6_wp    ! square of the sine of their angle
      real(wp) :: spin(3), products(3), missing(2), determinant

      spin = turned(mobility, own)
      products = [dot_product(own, own), dot_product(own, spin), dot_product(spin, spin)]
      missing = [0.5_wp*(length**2 - products(1)), energy - 0.5_wp*products(2)]
      determinant = products(1)*products(3) - products(2)**2
      if (determinant > parallel*products(1)*products(3)) own = own &
         + (missing(1)*products(3) - missing(2)*products(2))/determinant*own &
         + (missing(2)*products(1) - missing(1)*products(2))/determinant*spin
      own = length/norm2(own)*own
   end subroutine restore_invariants

   !> Correct a turn by the smallest rotation after which the angular momentum in space is the given
   !! one, and make it a unit quaternion.
   pure subroutine align(momentum, own, turn)
      real(wp), intent(in) :: momentum(3)            !! In space
      real(wp), intent(in) :: own(3)                 !! In the body, of the same length
      real(wp), intent(inout) :: turn(4)             !! Nearly a unit quaternion
      real(wp) :: there(3), correction(4)

      turn = turn/norm2(turn)
      there = turned(matrix_of_turn(turn), own)
      correction = [dot_product(momentum, momentum) + dot_product(momentum, there), &
         cross(there, momentum)]
      turn = product_of_turns(correction/norm2(correction), turn)
      turn = turn/norm2(turn)
   end subroutine align
end module mesh_free_rotation
