! SPDX-License-Identifier: BSD-3-Clause
!> Hilbert's space-filling curve through tiles: numbers that keep neighbours together.
!!
!! J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707 (2004) 381. The curve always
!! fills the box of 2^21 tiles per direction, so a key does not depend on the size of the grid, and
!! a cube of 2^k tiles at the origin has the first keys. Levels above the highest bit in use only
!! exchange the directions in turn; they are processed in one operation.
module mesh_hilbert
   use base_kinds, only: int64
   implicit none
   private

   public :: hilbert_coordinate, hilbert_key

   integer, parameter, public :: curve_bits = 21     !! Coordinates: 0 to 2^21 - 1
   !> Masks of bits that are spread over every second and over every third bit, step by step.
   integer(int64), parameter :: masks(0:5, 2:3) = reshape([2_int64**curve_bits - 1, &
      int(z"0000ffff0000ffff", int64), int(z"00ff00ff00ff00ff", int64), &
      int(z"0f0f0f0f0f0f0f0f", int64), int(z"3333333333333333", int64), &
      int(z"5555555555555555", int64), 2_int64**curve_bits - 1, &
      int(z"001f00000000ffff", int64), int(z"001f0000ff0000ff", int64), &
      int(z"100f00f00f00f00f", int64), int(z"10c30c30c30c30c3", int64), &
      int(z"1249249249249249", int64)], [6, 2])

contains

   !> Place of a tile on the curve, 0 or more.
   pure integer(int64) function hilbert_key(coordinate, dimensions) result(key)
      integer, intent(in) :: coordinate(3)           !! Position of the tile, 0 to 2^21 - 1
      integer, intent(in) :: dimensions              !! 1 of x, 2 of x and z, or 3

      select case (dimensions)
      case (1)
         key = int(coordinate(1), int64)
      case (2)
         key = key_of(2, [coordinate(1), coordinate(3)])
      case default
         key = key_of(3, coordinate)
      end select
   end function hilbert_key

   !> The tile at a position on the curve; the inverse of hilbert_key.
   pure function hilbert_coordinate(key, dimensions) result(coordinate)
      integer(int64), intent(in) :: key              !! Position on the curve
      integer, intent(in) :: dimensions              !! 1 of x, 2 of x and z, or 3
      integer :: coordinate(3)                       !! Position of the tile, 0 if inactive

      coordinate = 0
      select case (dimensions)
      case (1)
         coordinate(1) = int(key)
      case (2)
         coordinate(1:3:2) = point_of(2, key)
      case default
         coordinate = point_of(3, key)
      end select
   end function hilbert_coordinate

   !> Key in two or three dimensions.
   pure integer(int64) function key_of(dimensions, place) result(key)
      integer, intent(in) :: dimensions              !! 2 or 3
      integer, intent(in) :: place(dimensions)       !! Position of the tile
      integer :: a(3), level, gray, k

      level = levels_used(dimensions, place)
      do k = 1, dimensions
         a(k) = place(k)
      end do
      call move_round(dimensions, (dimensions - 1)*(curve_bits - level), a)
      do level = level - 1, 1, -1
         call turn_self(a(1), level)
         do k = 2, dimensions
            call turn(a(1), a(k), level)
         end do
      end do
      do k = 2, dimensions
         a(k) = ieor(a(k), a(k - 1))
      end do
      gray = parity_above(a(dimensions))
      key = 0
      do k = 1, dimensions
         key = ior(shiftl(key, 1), spread_bits(dimensions, ieor(a(k), gray)))
      end do
   end function key_of

   !> Tile of a key in two or three dimensions.
   pure function point_of(dimensions, key) result(place)
      integer, intent(in) :: dimensions              !! 2 or 3
      integer(int64), intent(in) :: key              !! Position on the curve
      integer :: place(dimensions)                   !! Position of the tile
      integer :: a(3), level, used, gray, k

      do k = 1, dimensions
         a(k) = gather_bits(dimensions, shiftr(key, dimensions - k))
      end do
      gray = shiftr(a(dimensions), 1)
      do k = dimensions, 2, -1
         a(k) = ieor(a(k), a(k - 1))
      end do
      a(1) = ieor(a(1), gray)
      used = levels_used(dimensions, a)
      do level = 1, used - 1
         do k = dimensions, 2, -1
            call turn(a(1), a(k), level)
         end do
         call turn_self(a(1), level)
      end do
      call move_round(dimensions, curve_bits - used, a)
      do k = 1, dimensions
         place(k) = a(k)
      end do
   end function point_of

   !> Number of levels that do more than exchange directions: the lowest level, which changes
   !! nothing, counts as one of them.
   pure integer function levels_used(dimensions, place) result(levels)
      integer, intent(in) :: dimensions              !! 2 or 3
      integer, intent(in) :: place(dimensions)       !! Coordinates in bits

      levels = ior(place(1), place(2))
      if (dimensions == 3) levels = ior(levels, place(3))
      levels = max(bit_size(levels) - leadz(levels), 1)
   end function levels_used

   !> Move the coordinates to the directions before, in turn.
   pure subroutine move_round(dimensions, steps, a)
      integer, intent(in) :: dimensions              !! 2 or 3
      integer, intent(in) :: steps                   !! Number of moves
      integer, intent(inout) :: a(dimensions)        !! Coordinates in bits
      integer :: first, step

      do step = 1, mod(steps, dimensions)
         first = a(1)
         a(1) = a(2)
         if (dimensions == 3) a(2) = a(3)
         a(dimensions) = first
      end do
   end subroutine move_round

   !> Skilling's step for the first direction: if its bit at the level is set, reverse it below.
   pure subroutine turn_self(first, level)
      integer, intent(inout) :: first                !! First direction
      integer, intent(in) :: level                   !! Number of the bit, from 0

      first = ieor(first, iand(maskr(level), -ibits(first, level, 1)))
   end subroutine turn_self

   !> Skilling's step for another direction: below the level, reverse the first direction if the bit
   !! of the other is set, else exchange the two. Masks instead of a branch: the bits of a
   !! coordinate are as good as random, so a branch would be mispredicted half the time.
   pure subroutine turn(first, other, level)
      integer, intent(inout) :: first                !! First direction
      integer, intent(inout) :: other                !! Another one
      integer, intent(in) :: level                   !! Number of the bit, from 0
      integer :: below, reverse, exchange

      below = maskr(level)
      reverse = -ibits(other, level, 1)
      exchange = iand(iand(ieor(first, other), below), not(reverse))
      first = ieor(first, ior(exchange, iand(below, reverse)))
      other = ieor(other, exchange)
   end subroutine turn

   !> For each bit the parity of the bits above it.
   pure integer function parity_above(bits) result(parity)
      integer, intent(in) :: bits                    !! At most 31 bits

      parity = shiftr(bits, 1)
      parity = ieor(parity, shiftr(parity, 1))
      parity = ieor(parity, shiftr(parity, 2))
      parity = ieor(parity, shiftr(parity, 4))
      parity = ieor(parity, shiftr(parity, 8))
      parity = ieor(parity, shiftr(parity, 16))
   end function parity_above

   !> Bits moved to every second or third bit.
   pure integer(int64) function spread_bits(dimensions, bits) result(spaced)
      integer, intent(in) :: dimensions              !! 2 or 3
      integer, intent(in) :: bits                    !! 21 bits
      integer :: k

      spaced = int(bits, int64)
      do k = 1, 5
         spaced = iand(ior(spaced, shiftl(spaced, (dimensions - 1)*2**(5 - k))), &
            masks(k, dimensions))
      end do
   end function spread_bits

   !> Every second or third bit, from the lowest on, moved together.
   pure integer function gather_bits(dimensions, spaced) result(bits)
      integer, intent(in) :: dimensions              !! 2 or 3
      integer(int64), intent(in) :: spaced           !! Bits in between are ignored
      integer(int64) :: packed
      integer :: k

      packed = iand(spaced, masks(5, dimensions))
      do k = 4, 0, -1
         packed = iand(ior(packed, shiftr(packed, (dimensions - 1)*2**(4 - k))), &
            masks(k, dimensions))
      end do
      bits = int(packed)
   end function gather_bits
end module mesh_hilbert
