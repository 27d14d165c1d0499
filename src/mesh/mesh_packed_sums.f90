! SPDX-License-Identifier: BSD-3-Clause
!> Sums of packed patches over their overlap with a tile.
module mesh_packed_sums
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: add_box, add_plane

contains

   !> Add a box of nodes of a packed patch to sums. A line along x is contiguous in both, and so are
   !! lines that follow one another in both.
   pure subroutine add_box(rows, low, high, margin, stride, corner, length, packed, numbers, sums)
      integer, intent(in) :: rows                    !! Numbers per node
      integer, intent(in) :: low(3), high(3)         !! Lowest and highest node that both have
      integer, intent(in) :: margin(3)               !! Layers before node 0
      integer, intent(in) :: stride(3)               !! Steps in the node index of the sums
      integer, intent(in) :: corner(3)               !! Lowest node of the packed patch
      integer, intent(in) :: length(3) !! Nodes of the packed patch along each direction
      real(wp), contiguous, intent(in) :: packed(:)   !! (row, node) Flat
      integer, intent(in) :: numbers                 !! Number of elements of the sums
      real(wp), intent(inout) :: sums(numbers)       !! (row, node) Flat
      integer :: y, z, here, there, line, top(2)

      line = high(1) - low(1) + 1
      top = high(2:3)
      if (line == length(1) .and. line == stride(2)) then
         line = line*(top(1) - low(2) + 1)
         top(1) = low(2)
      end if
      if (line == length(1)*length(2) .and. line == stride(3)) then
         line = line*(top(2) - low(3) + 1)
         top(2) = low(3)
      end if
      line = rows*line
      do z = low(3), top(2)
         do y = low(2), top(1)
            here = rows*((low(1) + margin(1))*stride(1) + (y + margin(2))*stride(2) &
               + (z + margin(3))*stride(3))
            there = rows*(low(1) - corner(1) + length(1)*(y - corner(2) &
               + length(2)*(z - corner(3))))
            ! compile-time lengths: one node with the rows of 2-D and of 3-D
            select case (line)
            case (2)
               call add_line(2, packed(there + 1:there + 2), sums(here + 1:here + 2))
            case (4)
               call add_line(4, packed(there + 1:there + 4), sums(here + 1:here + 4))
            case (6)
               call add_line(6, packed(there + 1:there + 6), sums(here + 1:here + 6))
            case (8)
               call add_line(8, packed(there + 1:there + 8), sums(here + 1:here + 8))
            case (9)
               call add_line(9, packed(there + 1:there + 9), sums(here + 1:here + 9))
            case default
               call add_line(line, packed(there + 1:there + line), sums(here + 1:here + line))
            end select
         end do
      end do
   end subroutine add_box

   !> Add a line of numbers to sums.
   pure subroutine add_line(numbers, packed, sums)
      integer, intent(in) :: numbers                 !! Number of numbers
      real(wp), intent(in) :: packed(numbers)         !! Flattened
      real(wp), intent(inout) :: sums(numbers)       !! Flattened

      sums = sums + packed
   end subroutine add_line

   !> Add a box of nodes in the plane of x and z to sums of all rows, or of the kept ones alone.
   pure subroutine add_plane(row, nodes, lines, here, stride, there, length, packed, total)
      integer, contiguous, intent(in) :: row(:)      !! Rows that are kept
      integer, intent(in) :: nodes                   !! Nodes along x
      integer, intent(in) :: lines                   !! Nodes along z
      integer, intent(in) :: here                    !! Nodes of the sums before the first one
      integer, intent(in) :: stride                  !! Nodes from line to line in the sums
      integer(int64), intent(in) :: there            !! Elements of packed patches before it
      integer, intent(in) :: length                  !! Nodes of a line of the packed patch
      real(wp), contiguous, intent(in) :: packed(:)  !! (row kept, node) Flat, all tiles
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums
      integer :: line, node
      integer(int64) :: at

      do line = 0, lines - 1
         at = there + int(size(row), int64)*(line*length)
         node = here + line*stride
         if (size(row) == size(total, 1)) then
            call add_numbers(size(row)*nodes, size(row)*node, &
               packed(at + 1:at + size(row)*nodes), size(total), total)
            cycle
         end if
         select case (size(row))
         case (2)
            call spread_rows(2, row, nodes, node, packed(at + 1:at + size(row)*nodes), &
               total)
         case (4)
            call spread_rows(4, row, nodes, node, packed(at + 1:at + size(row)*nodes), &
               total)
         case (6)
            call spread_rows(6, row, nodes, node, packed(at + 1:at + size(row)*nodes), &
               total)
         case default
            call spread_rows(size(row), row, nodes, node, packed(at + 1:at + size(row)*nodes), &
               total)
         end select
      end do
   end subroutine add_plane

   !> Add a line of numbers to sums.
   pure subroutine add_numbers(number, before, packed, numbers, sums)
      integer, intent(in) :: number                  !! Number
      integer, intent(in) :: before                  !! Index offset in the sums
      real(wp), intent(in) :: packed(number)         !! Flattened
      integer, intent(in) :: numbers                 !! Number of elements of the sums
      real(wp), intent(inout) :: sums(numbers)       !! Flattened
      integer :: n

      do n = 1, number
         sums(before + n) = sums(before + n) + packed(n)
      end do
   end subroutine add_numbers

   !> Add the kept rows of a line of nodes to sums of all rows. With a compile-time constant number
   !! there is no loop over them.
   pure subroutine spread_rows(kept, row, nodes, before, packed, total)
      integer, intent(in) :: kept                    !! How many rows
      integer, intent(in) :: row(kept)               !! Rows that are kept
      integer, intent(in) :: nodes                   !! Nodes of the line
      integer, intent(in) :: before                  !! Index offset in the sums
      real(wp), intent(in) :: packed(kept, nodes)    !! (row kept, node)
      real(wp), contiguous, intent(inout) :: total(:, :) !! (row, node) Sums
      integer :: node, k

      do node = 1, nodes
         do k = 1, kept
            total(row(k), before + node) = total(row(k), before + node) + packed(k, node)
         end do
      end do
   end subroutine spread_rows
end module mesh_packed_sums
