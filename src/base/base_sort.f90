! SPDX-License-Identifier: BSD-3-Clause
!> Sorts keys.
module base_sort
   use base_kinds, only: int64
   implicit none
   private

   public :: sort_order

contains

   !> Order in which keys ascend; equal keys keep their order. Merge sort.
   pure function sort_order(key) result(order)
      integer(int64), intent(in) :: key(:)            !! In any order
      integer :: order(size(key))
      integer :: scratch(size(key)), width, low, middle, high, i, j, n

      do n = 1, size(key)
         order(n) = n
      end do
      width = 1
      do while (width < size(key))
         do low = 1, size(key), 2*width
            middle = min(low + width, size(key) + 1)
            high = min(low + 2*width, size(key) + 1)
            i = low
            j = middle
            do n = low, high - 1
               if (j >= high) then
                  scratch(n) = order(i)
                  i = i + 1
               else if (i >= middle) then
                  scratch(n) = order(j)
                  j = j + 1
               else if (key(order(j)) < key(order(i))) then
                  scratch(n) = order(j)
                  j = j + 1
               else
                  scratch(n) = order(i)
                  i = i + 1
               end if
            end do
         end do
         order = scratch
         width = 2*width
      end do
   end function sort_order
end module base_sort
