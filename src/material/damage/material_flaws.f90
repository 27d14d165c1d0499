! SPDX-License-Identifier: BSD-3-Clause
!> Flaws of brittle material: a Poisson process in space, so that the strength of a place does not
!! depend on the cells or particles that compute it (W. Weibull, Ingenioersvetenskapsakad. Handl.
!! 151 (1939); D. E. Grady, M. E. Kipp, Int. J. Rock Mech. Min. Sci. 17 (1980) 147).
!!
!! A flaw has a place and a level l [1/m3]: a volume V has a mean number l V of flaws below the
!! level l. The weakest flaw of V then has a level with the distribution exp(-l V). Equation (F.5)
!! of doc/theory/failure.md gives its strength.
!!
!! The weakest flaw of any box is found by halving blocks of space, from a few that contain every
!! scene down to the smallest. The weakest flaw of a block is in one of its parts with a probability
!! in proportion to their volumes; that of any other part V' is higher by x/V' with x of the
!! distribution exp(-x), because the exponential distribution has no memory. The random numbers of
!! a block depend on the seed, its size and its place alone.
module material_flaws
   use base_constants, only: pi
   use base_elementary, only: logarithm
   use base_hash, only: add_hash, mix
   use base_kinds, only: int64, wp
   use base_random, only: random_uniform
   implicit none
   private

   public :: flaw_blocks_t, flaws_t

   !> Blocks of equal size that cover a region, for the search of its flaws.
   type :: flaw_blocks_t
      integer :: count = 0
      integer :: power = 0                           !! Edge over that of the smallest block, log2
      integer(int64) :: place(3, 8) = 0              !! (direction, block) In edges of a block
      real(wp) :: level(8) = 0.0_wp                  !! (block) Of its weakest flaw [1/m3]
   end type flaw_blocks_t

   !> Flaws of a material.
   type :: flaws_t
      integer(int64) :: seed = 0                     !! Seed of the random numbers
      real(wp) :: size = 0.0_wp !! Edge of the smallest blocks; 0: no smallest block [m]
      logical :: active(3) = .true.                  !! Directions that are computed
      logical :: axisymmetric = .false.              !! Is a block a ring around z?
      real(wp) :: depth = 1.0_wp !! Extent in the other directions [m**(3 - d)]
   contains
      procedure :: cover => flaws_cover              !! Blocks that cover a region
      procedure :: weakest => flaws_weakest          !! Level of the weakest flaw of a box
   end type flaws_t

   !> Edges of the smallest and of the largest blocks, as powers of two [m]. The smallest ones are
   !! smaller than an atom; coordinates in them fit into 64 bits.
   integer, parameter :: least_power = -34, most_power = 24

contains

   !> At most eight blocks that contain a region. The search of all boxes in the region can begin
   !! there instead of at the largest blocks; the result is the same.
   pure function flaws_cover(self, low, high) result(blocks)
      class(flaws_t), intent(in) :: self
      real(wp), intent(in) :: low(3), high(3)        !! Corners of the region [m]
      type(flaw_blocks_t) :: blocks
      integer(int64) :: first(3), last(3), longest, x, y, z
      integer :: top, k

      first = 0
      last = 0
      do k = 1, 3
         if (.not. self%active(k)) cycle
         first(k) = floor(low(k)/smallest_edge(self), int64)
         if (self%axisymmetric .and. k == 1) first(k) = max(first(k), 0_int64)
         last(k) = floor(high(k)/smallest_edge(self), int64)
      end do
      longest = maxval(last - first) + 1_int64
      top = top_power(self)
      do while (shiftl(1_int64, blocks%power) < longest .and. blocks%power < top)
         blocks%power = blocks%power + 1
      end do
      do z = shifta(first(3), blocks%power), shifta(last(3), blocks%power)
         do y = shifta(first(2), blocks%power), shifta(last(2), blocks%power)
            do x = shifta(first(1), blocks%power), shifta(last(1), blocks%power)
               blocks%count = blocks%count + 1
               blocks%place(:, blocks%count) = [x, y, z]
               blocks%level(blocks%count) = block_level(self, blocks%power, [x, y, z])
            end do
         end do
      end do
   end function flaws_cover

   !> Level [1/m3] of the weakest flaw of a box: of the blocks of the smallest size whose centres it
   !! contains, or, if there are none, of that at its centre.
   pure real(wp) function flaws_weakest(self, low, high, blocks) result(level)
      class(flaws_t), intent(in) :: self
      real(wp), intent(in) :: low(3)                 !! Corner of the box [m]
      real(wp), intent(in) :: high(3)                !! Opposite corner [m]
      !> Blocks that cover the box; default: found here
      type(flaw_blocks_t), optional, intent(in) :: blocks
      type(flaw_blocks_t) :: around
      integer(int64) :: first(3), last(3)
      real(wp) :: volume, limit
      integer :: n

      if (present(blocks)) then
         around = blocks
      else
         around = self%cover(low, high)
      end if
      call find_range(self, low, high, first, last)
      volume = self%depth*product(real(last - first + 1_int64, wp)*smallest_edge(self), &
         mask=self%active)
      if (self%axisymmetric) volume = volume*pi*(low(1) + high(1))/self%depth
      ! blocks at the surface of the box are searched in vain until a flaw inside is known, so the
      ! search begins below a level at which there is probably one
      limit = 2.0_wp/volume
      do
         level = limit
         do n = 1, around%count
            call descend(self, around%power, around%place(:, n), around%level(n), first, last, &
               level)
         end do
         if (level < limit) return
         limit = 4.0_wp*limit
      end do
   end function flaws_weakest

   !> First and last of the smallest blocks whose centres a box contains, or that at its centre.
   pure subroutine find_range(flaws, low, high, first, last)
      class(flaws_t), intent(in) :: flaws
      real(wp), intent(in) :: low(3), high(3)        !! Corners of the box [m]
      integer(int64), intent(out) :: first(3), last(3) !! 0 in directions that are not computed
      real(wp) :: edge, lower
      integer :: k

      edge = smallest_edge(flaws)
      first = 0
      last = 0
      do k = 1, 3
         if (.not. flaws%active(k)) cycle
         lower = low(k)
         if (flaws%axisymmetric .and. k == 1) lower = max(lower, 0.0_wp)
         first(k) = ceiling(lower/edge - 0.5_wp, int64)
         last(k) = ceiling(high(k)/edge - 0.5_wp, int64) - 1_int64
         if (last(k) >= first(k)) cycle
         first(k) = floor(0.5_wp*(lower + high(k))/edge, int64)
         last(k) = first(k)
      end do
   end subroutine find_range

   !> Edge of the smallest blocks [m].
   pure real(wp) function smallest_edge(flaws) result(edge)
      class(flaws_t), intent(in) :: flaws

      edge = max(flaws%size, 2.0_wp**least_power)
   end function smallest_edge

   !> Edge of the largest blocks over that of the smallest, log2.
   pure integer function top_power(flaws) result(power)
      class(flaws_t), intent(in) :: flaws

      power = max(most_power + 1 - exponent(smallest_edge(flaws)), 0)
   end function top_power

   !> Level of the weakest flaw of one block, from the largest block around it down [1/m3].
   pure real(wp) function block_level(flaws, power, place) result(level)
      class(flaws_t), intent(in) :: flaws
      integer, intent(in) :: power                   !! Edge of the block over the smallest, log2
      integer(int64), intent(in) :: place(3)         !! Place of the block, in its edges
      integer(int64) :: around(3), within(3), key
      integer :: now, part, k, bit

      now = top_power(flaws)
      around = shifta(place, now - power)
      level = exponential_number(flaws, block_key(now, around), 0)/block_volume(flaws, now, around)
      do now = now, power + 1, -1
         key = block_key(now, around)
         within = shifta(place, now - 1 - power)
         part = 0
         bit = 0
         do k = 1, 3
            if (.not. flaws%active(k)) cycle
            part = part + shiftl(int(iand(within(k), 1_int64)), bit)
            bit = bit + 1
         end do
         if (part /= part_with_weakest(flaws, now, around, key)) level = level &
            + exponential_number(flaws, key, part + 1)/block_volume(flaws, now - 1, within)
         around = within
      end do
   end function block_level

   !> Search the weakest flaw of a box in a block and its parts.
   pure recursive subroutine descend(flaws, power, place, level, first, last, weakest)
      class(flaws_t), intent(in) :: flaws
      integer, intent(in) :: power                   !! Edge of the block over the smallest, log2
      integer(int64), intent(in) :: place(3)         !! Place of the block, in its edges
      real(wp), intent(in) :: level                  !! Of its weakest flaw [1/m3]
      integer(int64), intent(in) :: first(3), last(3) !! The box, in smallest blocks
      real(wp), intent(inout) :: weakest             !! Lowest level in the box so far [1/m3]
      integer(int64) :: from(3), to(3), part(3), key
      real(wp) :: number, volume
      integer :: holder, n

      if (.not. level < weakest) return
      from = merge(shiftl(place, power), 0_int64, flaws%active)
      to = merge(from + shiftl(1_int64, power) - 1_int64, 0_int64, flaws%active)
      if (any(to < first .or. from > last)) return
      if (power == 0 .or. all(from >= first .and. to <= last)) then
         weakest = level
         return
      end if
      key = block_key(power, place)
      holder = part_with_weakest(flaws, power, place, key)
      call descend(flaws, power - 1, place_of_part(flaws, place, holder), level, first, last, &
         weakest)
      do n = 0, 2**count(flaws%active) - 1
         if (n == holder) cycle
         part = place_of_part(flaws, place, n)
         from = merge(shiftl(part, power - 1), 0_int64, flaws%active)
         to = merge(from + shiftl(1_int64, power - 1) - 1_int64, 0_int64, flaws%active)
         if (any(to < first .or. from > last)) cycle
         ! -ln u >= 1 - u excludes most small blocks without a logarithm
         volume = block_volume(flaws, power - 1, part)
         number = random_uniform(flaws%seed, key, int(n + 1, int64))
         if (.not. level + (1.0_wp - number)/volume < weakest) cycle
         call descend(flaws, power - 1, part, level - logarithm(number)/volume, first, last, &
            weakest)
      end do
   end subroutine descend

   !> Part of a block that contains its weakest flaw, by chance in proportion to the volumes.
   pure integer function part_with_weakest(flaws, power, place, key) result(part)
      class(flaws_t), intent(in) :: flaws
      integer, intent(in) :: power                   !! Edge of the block over the smallest, log2
      integer(int64), intent(in) :: place(3)         !! Place of the block, in its edges
      integer(int64), intent(in) :: key              !! Key of the block
      real(wp) :: rest
      integer :: parts

      parts = 2**count(flaws%active)
      rest = random_uniform(flaws%seed, key, int(parts + 1, int64))
      if (.not. flaws%axisymmetric) then
         part = min(int(rest*real(parts, wp)), parts - 1)
         return
      end if
      rest = rest*block_volume(flaws, power, place)
      do part = 0, parts - 2
         rest = rest - block_volume(flaws, power - 1, place_of_part(flaws, place, part))
         if (rest < 0.0_wp) return
      end do
   end function part_with_weakest

   !> Place of a part of a block, in its edges: each bit of its number is the half of a direction.
   pure function place_of_part(flaws, place, part) result(place_of)
      class(flaws_t), intent(in) :: flaws
      integer(int64), intent(in) :: place(3)         !! Place of the block, in its edges
      integer, intent(in) :: part                    !! From 0
      integer(int64) :: place_of(3)
      integer :: k, bit

      place_of = place
      bit = 0
      do k = 1, 3
         if (.not. flaws%active(k)) cycle
         place_of(k) = shiftl(place(k), 1) + int(ibits(part, bit, 1), int64)
         bit = bit + 1
      end do
   end function place_of_part

   !> Volume of a block [m3], with the extent in directions that are not computed; of a ring around
   !! the axis in axisymmetry.
   pure real(wp) function block_volume(flaws, power, place) result(volume)
      class(flaws_t), intent(in) :: flaws
      integer, intent(in) :: power                   !! Edge of the block over the smallest, log2
      integer(int64), intent(in) :: place(3)         !! Place of the block, in its edges
      real(wp) :: edge

      edge = smallest_edge(flaws)*real(shiftl(1_int64, power), wp)
      volume = flaws%depth
      if (flaws%axisymmetric) volume = 2.0_wp*pi*edge*(real(place(1), wp) + 0.5_wp)
      volume = volume*edge
      if (flaws%active(2)) volume = volume*edge
      if (flaws%active(3)) volume = volume*edge
   end function block_volume

   !> Exponentially distributed random number of mean 1.
   pure real(wp) function exponential_number(flaws, key, draw) result(number)
      class(flaws_t), intent(in) :: flaws
      integer(int64), intent(in) :: key              !! Key of the block
      integer, intent(in) :: draw                    !! 0 for its own, else number of a part + 1

      number = -logarithm(random_uniform(flaws%seed, key, int(draw, int64)))
   end function exponential_number

   !> Key of the random numbers of a block.
   pure function block_key(power, place) result(key)
      integer, intent(in) :: power                   !! Edge of the block over the smallest, log2
      integer(int64), intent(in) :: place(3)         !! Place of the block, in its edges
      integer(int64) :: key
      integer :: k

      key = mix(int(power, int64))
      do k = 1, 3
         key = mix(add_hash(key, place(k)))
      end do
   end function block_key
end module material_flaws
