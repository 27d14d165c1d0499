! SPDX-License-Identifier: BSD-3-Clause
!> Sums, differences and integrals along a direction for all nodes of a tile, for `ddmp_operator`.
!!
!! A field of a tile is a one-dimensional array; the next node along a direction has a constant
!! offset in it (`shift`). A value between a node and the next is stored at the index of the node.
module ddmp_line_sums
   use base_kinds, only: wp
   implicit none
   private

   public :: add_change, add_difference, add_line, add_next, apply_line_mass, apply_mass, &
      difference_along, mean_along

contains

   !> Add to each element that of the next node along a direction.
   pure subroutine add_next(low, high, shift, numbers, field)
      integer, intent(in) :: low                     !! First index in use
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Distance to the next node in the array
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(inout) :: field(numbers)      !! On the nodes in, between them out
      integer :: n

      !$omp simd
      do n = low, high
         field(n) = field(n) + field(n + shift)
      end do
   end subroutine add_next

   !> Add the value at the next node, minus that at the previous node.
   pure subroutine add_change(numbers, pad, low, high, shift, sums, patch)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: pad                     !! Offset in memory
      integer, intent(in) :: low                     !! First index in use
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Distance to the next node in the array
      real(wp), intent(in) :: sums(1 - pad:numbers)  !! Between a node and the next
      real(wp), intent(inout) :: patch(numbers)      !! Values on the nodes
      integer :: n

      !$omp simd
      do n = low, high
         patch(n) = patch(n) + (sums(n) - sums(n - shift))
      end do
   end subroutine add_change

   !> Integrals along a direction of the node values.
   pure subroutine mean_along(numbers, low, high, shift, line, field, means)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: low                     !! First index in use
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Distance to the next node in the array
      real(wp), intent(in) :: line(numbers, 2)       !! Integrals of the two functions [m]
      real(wp), intent(in) :: field(numbers)         !! Values on the nodes
      real(wp), intent(inout) :: means(numbers)      !! Between a node and the next [field m]
      integer :: n

      !$omp simd
      do n = low, high
         means(n) = line(n, 1)*field(n) + line(n, 2)*field(n + shift)
      end do
   end subroutine mean_along

   !> The transpose of that.
   pure subroutine add_line(numbers, low, high, shift, line, sums, field)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: low                     !! First index in use
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Distance to the next node in the array
      real(wp), intent(in) :: line(numbers, 2)       !! Integrals of the two functions [m]
      real(wp), intent(in) :: sums(numbers)          !! Between a node and the next
      real(wp), intent(inout) :: field(numbers)      !! Values on the nodes
      integer :: n

      !$omp simd
      do n = low, high
         field(n) = field(n) + line(n, 1)*sums(n)
      end do
      call add_shifted(numbers, low, high, shift, line(1, 2), sums, field)
   end subroutine add_line

   !> Add products to the numbers of the next node.
   pure subroutine add_shifted(numbers, low, high, shift, line, sums, field)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: low                     !! First index in use
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Distance to the next node in the array
      real(wp), intent(in) :: line(numbers)          !! Factors
      real(wp), intent(in) :: sums(numbers)          !! Multiplied by them
      real(wp), intent(inout) :: field(numbers)      !! Gets the products
      integer :: n

      !$omp simd
      do n = low, high
         field(n + shift) = field(n + shift) + line(n)*sums(n)
      end do
   end subroutine add_shifted

   !> Differences along a direction, times a factor.
   pure subroutine difference_along(numbers, low, high, shift, factor, field, differences)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: low                     !! First index in use
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Distance to the next node in the array
      real(wp), intent(in) :: factor                 !! Factor
      real(wp), intent(in) :: field(numbers)         !! Values on the nodes
      real(wp), intent(inout) :: differences(numbers) !! Between a node and the next
      integer :: n

      !$omp simd
      do n = low, high
         differences(n) = factor*(field(n + shift) - field(n))
      end do
   end subroutine difference_along

   !> Minus its transpose: the gain of one node is the loss of the other.
   pure subroutine add_difference(numbers, low, high, shift, factor, sums, field)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: low                     !! First index in use
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Distance to the next node in the array
      real(wp), intent(in) :: factor                 !! Factor
      real(wp), intent(in) :: sums(numbers)          !! Between a node and the next
      real(wp), intent(inout) :: field(numbers)      !! Values on the nodes
      integer :: n

      !$omp simd
      do n = low, high
         field(n) = field(n) + factor*sums(n)
      end do
      !$omp simd
      do n = low, high
         field(n + shift) = field(n + shift) - factor*sums(n)
      end do
   end subroutine add_difference

   !> Integrals of products with both functions along two directions, times the weights of cells,
   !! summed over the cells around, in space. The sums begin and end with zeros over the distance of
   !! the next node along the third direction.
   pure subroutine apply_mass(numbers, pad, low, high, one, other, third, weight, field, sums)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: pad                     !! Offset in memory
      integer, intent(in) :: low                     !! First number of a cell
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: one                     !! Numbers to the next node, first direction
      integer, intent(in) :: other                   !! The same, second direction
      integer, intent(in) :: third                   !! The same, third direction
      real(wp), intent(in) :: weight(numbers)        !! Weights of cells on their first nodes
      real(wp), intent(in) :: field(numbers)         !! On the four corners of a face
      real(wp), intent(inout) :: sums(1 - pad:numbers) !! Sums on the same corners
      real(wp) :: part(1 - pad:numbers, 4), a, a0, a1, b, b0, b1
      integer :: n, k

      !$omp simd private(a, a0, a1, b, b0, b1)
      do n = low, high
         a = field(n) + field(n + one)
         a0 = a + field(n)
         a1 = a + field(n + one)
         b = field(n + other) + field(n + one + other)
         b0 = b + field(n + other)
         b1 = b + field(n + one + other)
         a = a0 + b0
         b = a1 + b1
         part(n, 1) = weight(n)*(a + a0)
         part(n, 2) = weight(n)*(b + a1)
         part(n, 3) = weight(n)*(a + b0)
         part(n, 4) = weight(n)*(b + b1)
      end do
      do k = 1, 4
         part(low - one - other:low - 1, k) = 0.0_wp
         part(high + 1:high + one + other, k) = 0.0_wp
      end do
      sums(low - third:low - 1) = 0.0_wp
      sums(high + one + other + 1:high + one + other + third) = 0.0_wp
      !$omp simd
      do n = low, high + one + other
         sums(n) = (part(n, 1) + part(n - one, 2)) + (part(n - other, 3) + part(n - one - other, 4))
      end do
   end subroutine apply_mass

   !> The same along a single direction.
   pure subroutine apply_line_mass(numbers, low, high, shift, mass, weight, field, sums)
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      integer, intent(in) :: low                     !! First number of a cell
      integer, intent(in) :: high                    !! Last index
      integer, intent(in) :: shift                   !! Numbers to the next node, 0 if missing
      real(wp), intent(in) :: mass(numbers, 3)       !! Integrals of products [m]
      real(wp), intent(in) :: weight(numbers)        !! Weights of cells on their first nodes
      real(wp), intent(in) :: field(numbers)         !! On the two corners of an edge
      real(wp), intent(inout) :: sums(numbers)       !! Sums on the same corners
      integer :: n

      !$omp simd
      do n = low, high
         sums(n) = weight(n)*(mass(n, 1)*field(n) + mass(n, 2)*field(n + shift))
      end do
      sums(high + 1:high + shift) = 0.0_wp
      ! without an intermediate field, which would have to be allocated
      !$omp simd
      do n = low, high
         sums(n + shift) = sums(n + shift) &
            + weight(n)*(mass(n, 2)*field(n) + mass(n, 3)*field(n + shift))
      end do
   end subroutine apply_line_mass
end module ddmp_line_sums
