! SPDX-License-Identifier: BSD-3-Clause
!> Sums in an order that does not depend on the processor.
!!
!! A loop with `!$omp simd reduction(+:)` has as many partial sums as the vectors of the processor
!! have numbers, so the last bits of a sum of reals differ between processors. Here they are always
!! eight.
module base_lane_sum
   use base_kinds, only: wp
   implicit none
   private

   public :: add_products

   integer, parameter :: lanes = 8                         !! Partial sums

contains

   !> Add the products of two lists of numbers to a sum. Those beyond the last eight are added to
   !! the first partial sum.
   pure subroutine add_products(number, a, b, total)
      integer, intent(in) :: number                        !! Number of products
      real(wp), intent(in) :: a(number), b(number)         !! Factors
      real(wp), intent(inout) :: total                     !! Increased by the sum of the products
      real(wp) :: lane(lanes)
      integer :: whole, i, p

      whole = number - modulo(number, lanes)
      lane = 0.0_wp
      do p = 0, whole - lanes, lanes
         !$omp simd
         do i = 1, lanes
            lane(i) = lane(i) + a(p + i)*b(p + i)
         end do
      end do
      do p = whole + 1, number
         lane(1) = lane(1) + a(p)*b(p)
      end do
      do i = 1, lanes
         total = total + lane(i)
      end do
   end subroutine add_products
end module base_lane_sum
