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
   !> Masks that spread bits over every second and over every third bit, step by step.
   integer(int64), parameter :: second(5) = [int(z"0000ffff0000ffff", int64), &
      int(z"00ff00ff00ff00ff", int64), int(z"0f0f0f0f0f0f0f0f", int64), &
      int(z"3333333333333333", int64), int(z"5555555555555555", int64)]
   integer(int64), parameter :: third(5) = [int(z"001f00000000ffff", int64), &
      int(z"001f0000ff0000ff", int64), int(z"100f00f00f00f00f", int64), &
      int(z"10c30c30c30c30c3", int64), int(z"1249249249249249", int64)]
   integer(int64), parameter :: all_bits = 2_int64**curve_bits - 1

contains

   !> Place of a tile on the curve, 0 or more.
   pure integer(int64) function hilbert_key(coordinate, dimensions) result(key)
      integer, intent(in) :: coordinate(3)           !! Position of the tile, 0 to 2^21 - 1
      integer, intent(in) :: dimensions              !! 1 of x, 2 of x and z, or 3

      select case (dimensions)
      case (1)
         key = int(coordinate(1), int64)
      case (2)
         key = key_plane(coordinate(1), coordinate(3))
      case default
         key = key_space(coordinate(1), coordinate(2), coordinate(3))
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
         call point_plane(key, coordinate(1), coordinate(3))
      case default
         call point_space(key, coordinate(1), coordinate(2), coordinate(3))
      end select
   end function hilbert_coordinate

   !> Key in two dimensions.
   pure integer(int64) function key_plane(x, z) result(key)
      integer, intent(in) :: x, z                    !! Position of the tile
      integer :: a, b, level, gray

      level = levels_used(ior(x, z))
      if (mod(curve_bits - level, 2) == 0) then
         a = x
         b = z
      else
         a = z
         b = x
      end if
      do level = level - 1, 1, -1
         call turn_self(a, level)
         call turn(a, b, level)
      end do
      b = ieor(b, a)
      gray = parity_above(b)
      key = ior(shiftl(spread_second(ieor(a, gray)), 1), spread_second(ieor(b, gray)))
   end function key_plane

   !> Key in three dimensions.
   pure integer(int64) function key_space(x, y, z) result(key)
      integer, intent(in) :: x, y, z                 !! Position of the tile
      integer :: a, b, c, level, gray

      level = levels_used(ior(ior(x, y), z))
      a = x
      b = y
      c = z
      call move_round(a, b, c, mod(2*(curve_bits - level), 3))
      do level = level - 1, 1, -1
         call turn_self(a, level)
         call turn(a, b, level)
         call turn(a, c, level)
      end do
      b = ieor(b, a)
      c = ieor(c, b)
      gray = parity_above(c)
      key = ior(ior(shiftl(spread_third(ieor(a, gray)), 2), &
         shiftl(spread_third(ieor(b, gray)), 1)), spread_third(ieor(c, gray)))
   end function key_space

   !> Tile of a key in two dimensions.
   pure subroutine point_plane(key, x, z)
      integer(int64), intent(in) :: key              !! Position on the curve
      integer, intent(out) :: x, z                   !! Position of the tile
      integer :: a, b, level, used, gray

      a = gather_second(shiftr(key, 1))
      b = gather_second(key)
      gray = shiftr(b, 1)
      b = ieor(b, a)
      a = ieor(a, gray)
      used = levels_used(ior(a, b))
      do level = 1, used - 1
         call turn(a, b, level)
         call turn_self(a, level)
      end do
      if (mod(curve_bits - used, 2) == 0) then
         x = a
         z = b
      else
         x = b
         z = a
      end if
   end subroutine point_plane

   !> Tile of a key in three dimensions.
   pure subroutine point_space(key, x, y, z)
      integer(int64), intent(in) :: key              !! Position on the curve
      integer, intent(out) :: x, y, z                !! Position of the tile
      integer :: level, used, gray

      x = gather_third(shiftr(key, 2))
      y = gather_third(shiftr(key, 1))
      z = gather_third(key)
      gray = shiftr(z, 1)
      z = ieor(z, y)
      y = ieor(y, x)
      x = ieor(x, gray)
      used = levels_used(ior(ior(x, y), z))
      do level = 1, used - 1
         call turn(x, z, level)
         call turn(x, y, level)
         call turn_self(x, level)
      end do
      call move_round(x, y, z, mod(curve_bits - used, 3))
   end subroutine point_space

   !> Number of levels that do more than exchange directions: the lowest level, which changes
   !! nothing, counts as one of them.
   pure integer function levels_used(bits) result(levels)
      integer, intent(in) :: bits                    !! All bits that occur in the coordinates

      levels = max(bit_size(bits) - leadz(bits), 1)
   end function levels_used

   !> Rotate three numbers to the left.
   pure subroutine move_round(a, b, c, shift)
      integer, intent(inout) :: a, b, c              !! Coordinates in bits
      integer, intent(in) :: shift                   !! 0 to 2
      integer :: first, last

      first = a
      last = c
      select case (shift)
      case (1)
         a = b
         b = last
         c = first
      case (2)
         a = last
         c = b
         b = first
      case default
         return
      end select
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

   !> Bits moved to every second bit.
   pure integer(int64) function spread_second(bits) result(spaced)
      integer, intent(in) :: bits                    !! 21 bits

      spaced = int(bits, int64)
      spaced = iand(ior(spaced, shiftl(spaced, 16)), second(1))
      spaced = iand(ior(spaced, shiftl(spaced, 8)), second(2))
      spaced = iand(ior(spaced, shiftl(spaced, 4)), second(3))
      spaced = iand(ior(spaced, shiftl(spaced, 2)), second(4))
      spaced = iand(ior(spaced, shiftl(spaced, 1)), second(5))
   end function spread_second

   !> Bits moved to every third bit.
   pure integer(int64) function spread_third(bits) result(spaced)
      integer, intent(in) :: bits                    !! 21 bits

      spaced = int(bits, int64)
      spaced = iand(ior(spaced, shiftl(spaced, 32)), third(1))
      spaced = iand(ior(spaced, shiftl(spaced, 16)), third(2))
      spaced = iand(ior(spaced, shiftl(spaced, 8)), third(3))
      spaced = iand(ior(spaced, shiftl(spaced, 4)), third(4))
      spaced = iand(ior(spaced, shiftl(spaced, 2)), third(5))
   end function spread_third

   !> Collect every second bit, starting with the lowest, in the low bits of an integer.
   pure integer function gather_second(spaced) result(bits)
      integer(int64), intent(in) :: spaced           !! Bits in between are ignored
      integer(int64) :: packed

      packed = iand(spaced, second(5))
      packed = iand(ior(packed, shiftr(packed, 1)), second(4))
      packed = iand(ior(packed, shiftr(packed, 2)), second(3))
      packed = iand(ior(packed, shiftr(packed, 4)), second(2))
      packed = iand(ior(packed, shiftr(packed, 8)), second(1))
      packed = iand(ior(packed, shiftr(packed, 16)), all_bits)
      bits = int(packed)
   end function gather_second

   !> Every third bit, from the lowest on, moved together.
   pure integer function gather_third(spaced) result(bits)
      integer(int64), intent(in) :: spaced           !! Bits in between are ignored
      integer(int64) :: packed

      packed = iand(spaced, third(5))
      packed = iand(ior(packed, shiftr(packed, 2)), third(4))
      packed = iand(ior(packed, shiftr(packed, 4)), third(3))
      packed = iand(ior(packed, shiftr(packed, 8)), third(2))
      packed = iand(ior(packed, shiftr(packed, 16)), third(1))
      packed = iand(ior(packed, shiftr(packed, 32)), all_bits)
      bits = int(packed)
   end function gather_third
end module mesh_hilbert
