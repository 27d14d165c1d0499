! SPDX-License-Identifier: BSD-3-Clause
!> Sums of real numbers with a single rounding at the end, independent of the order of the terms.
!!
!! A sum is a long integer in units of the smallest real number, 2^-1074, cut into limbs of
!! 32 bits: U. Kulisch, "Very fast and exact accumulation of products", Computing 91 (2011) 397.
module base_exact_sum
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_positive_inf, ieee_quiet_nan, &
      ieee_value
   implicit none
   private

   public :: exact_sum_t

   integer, parameter :: top = 68 !! Index of the last limb; holds 2^70 largest terms
   integer, parameter, public :: exact_sum_words = top + 4 !! Integers that store a sum
   integer, parameter :: mantissa_bits = 52              !! Stored bits of a real number
   integer(int64), parameter :: limb_mask = 2_int64**32 - 1_int64
   integer(int64), parameter :: hidden_bit = 2_int64**52
   !> Terms between two carries; each adds less than 2^32 to a limb of 63 bits.
   integer(int64), parameter :: most_terms = 2_int64**29

   !> A sum.
   type :: exact_sum_t
      integer(int64), private :: limbs(0:top) = 0_int64  !! Signed digits of base 2^32
      integer(int64), private :: special(3) = 0_int64 !! Terms that were NaN, infinite, -infinite
      integer(int64), private :: terms = 0_int64         !! Terms since the last carry
   contains
      procedure :: add => exact_sum_add                  !! Add one number
      procedure :: add_all => exact_sum_add_all          !! Add all numbers of an array
      procedure :: merge => exact_sum_merge              !! Add another sum
      procedure :: over_ranks => exact_sum_over_ranks    !! Add the sums of all ranks
      procedure :: value => exact_sum_value              !! The sum, correctly rounded
      procedure :: clear => exact_sum_clear              !! Set to zero
      procedure :: save => exact_sum_save                !! The sum as integers
      procedure :: load => exact_sum_load                !! The sum from integers
   end type exact_sum_t

contains

   !> Add one number.
   pure subroutine exact_sum_add(self, number)
      class(exact_sum_t), intent(inout) :: self
      real(wp), intent(in) :: number                     !! Term to add
      integer(int64) :: bits, mantissa, sign_mask, low
      integer :: exponent_field, limb, shift

      bits = transfer(number, bits)
      exponent_field = int(ibits(bits, mantissa_bits, 11))
      mantissa = ibits(bits, 0, mantissa_bits)
      if (exponent_field == 2047) then
         call count_special(self%special, mantissa /= 0_int64, bits < 0_int64)
         return
      end if
      if (exponent_field > 0) then
         mantissa = mantissa + hidden_bit
         exponent_field = exponent_field - 1
      end if
      limb = exponent_field/32
      shift = iand(exponent_field, 31)
      ! All ones for a negative number: (x xor mask) - mask is then -x.
      sign_mask = shifta(bits, 63)
      low = iand(shiftl(mantissa, shift), limb_mask)
      mantissa = shiftr(mantissa, 32 - shift)
      self%limbs(limb) = self%limbs(limb) + (ieor(low, sign_mask) - sign_mask)
      low = iand(mantissa, limb_mask)
      self%limbs(limb + 1) = self%limbs(limb + 1) + (ieor(low, sign_mask) - sign_mask)
      low = shiftr(mantissa, 32)
      self%limbs(limb + 2) = self%limbs(limb + 2) + (ieor(low, sign_mask) - sign_mask)
      self%terms = self%terms + 1_int64
      if (self%terms >= most_terms) call carry_limbs(self)
   end subroutine exact_sum_add

   !> Count a term that is not finite.
   pure subroutine count_special(special, undefined, negative)
      integer(int64), intent(inout) :: special(3)            !! Counts
      logical, intent(in) :: undefined                   !! Is the sum NaN?
      logical, intent(in) :: negative                    !! Is the sum negative?

      if (undefined) then
         special(1) = special(1) + 1_int64
      else if (negative) then
         special(3) = special(3) + 1_int64
      else
         special(2) = special(2) + 1_int64
      end if
   end subroutine count_special

   !> Add all numbers of an array.
   pure subroutine exact_sum_add_all(self, numbers)
      class(exact_sum_t), intent(inout) :: self
      real(wp), intent(in) :: numbers(:)                 !! Terms to add
      integer :: index

      do index = 1, size(numbers)
         call self%add(numbers(index))
      end do
   end subroutine exact_sum_add_all

   !> Carry between limbs, so that all but the last are 0 ... 2^32 - 1.
   pure subroutine carry_limbs(self)
      class(exact_sum_t), intent(inout) :: self
      integer :: limb

      do limb = 0, top - 1
         self%limbs(limb + 1) = self%limbs(limb + 1) + shifta(self%limbs(limb), 32)
         self%limbs(limb) = iand(self%limbs(limb), limb_mask)
      end do
      self%terms = 0_int64
   end subroutine carry_limbs

   !> Add another sum.
   pure subroutine exact_sum_merge(self, other)
      class(exact_sum_t), intent(inout) :: self
      type(exact_sum_t), intent(in) :: other             !! Number to add

      if (self%terms + other%terms + 1_int64 >= most_terms) call carry_limbs(self)
      self%limbs = self%limbs + other%limbs
      self%special = self%special + other%special
      self%terms = self%terms + other%terms + 1_int64
      if (self%terms >= most_terms) call carry_limbs(self)
   end subroutine exact_sum_merge

   !> Add the sums of all ranks; every rank gets the whole. Collective.
   subroutine exact_sum_over_ranks(self, communicator)
      class(exact_sum_t), intent(inout) :: self          !! Part of this rank in, whole out
      type(communicator_t), intent(in) :: communicator
      integer(int64) :: words(exact_sum_words)

      call self%save(words)
      call communicator%total(words)
      call self%load(words)
      call carry_limbs(self)
   end subroutine exact_sum_over_ranks

   !> The sum, rounded once, to nearest and ties to even.
   pure function exact_sum_value(self) result(number)
      class(exact_sum_t), intent(in) :: self
      real(wp) :: number
      type(exact_sum_t) :: work
      logical :: negative

      if (self%special(1) > 0_int64 .or. (self%special(2) > 0_int64 .and. self%special(3) > &
         0_int64)) then
         number = ieee_value(number, ieee_quiet_nan)
         return
      end if
      if (self%special(2) > 0_int64) number = ieee_value(number, ieee_positive_inf)
      if (self%special(3) > 0_int64) number = ieee_value(number, ieee_negative_inf)
      if (any(self%special > 0_int64)) return
      work%limbs = self%limbs
      call carry_limbs(work)
      negative = work%limbs(top) < 0_int64
      if (negative) then
         work%limbs = -work%limbs
         call carry_limbs(work)
      end if
      number = rounded(work%limbs)
      if (negative) number = -number
   end function exact_sum_value

   !> A non-negative long integer, rounded to a real number.
   pure function rounded(limbs) result(number)
      integer(int64), intent(in) :: limbs(0:top)         !! Digits of base 2^32
      real(wp) :: number
      integer(int64) :: mantissa
      integer :: highest, last, limb
      logical :: half, rest

      highest = -1
      do limb = top, 0, -1
         if (limbs(limb) == 0_int64) cycle
         highest = 32*limb + 63 - leadz(limbs(limb))
         exit
      end do
      last = max(highest - mantissa_bits, 0)
      if (last > 2045) then
         number = ieee_value(number, ieee_positive_inf)
         return
      end if
      mantissa = extract_bits(limbs, last)
      if (last > 0) then
         half = btest(limbs((last - 1)/32), mod(last - 1, 32))
         rest = any(limbs(:(last - 1)/32 - 1) /= 0_int64) .or. &
            ibits(limbs((last - 1)/32), 0, mod(last - 1, 32)) /= 0_int64
         if (half .and. (rest .or. btest(mantissa, 0))) mantissa = mantissa + 1_int64
      end if
      ! The hidden bit, if it is set, raises the exponent by one, and so does a carry out of the
      ! mantissa.
      number = transfer(shiftl(int(last, int64), mantissa_bits) + mantissa, number)
   end function rounded

   !> The 53 bits from a given bit upwards.
   pure function extract_bits(limbs, last) result(bits)
      integer(int64), intent(in) :: limbs(0:top)         !! Digits of base 2^32
      integer, intent(in) :: last                        !! Lowest bit
      integer(int64) :: bits
      integer :: limb, shift

      limb = last/32
      shift = mod(last, 32)
      bits = shiftr(limbs(limb), shift)
      if (limb < top) bits = ior(bits, shiftl(limbs(limb + 1), 32 - shift))
      if (limb + 1 < top .and. shift > 0) bits = ior(bits, shiftl(limbs(limb + 2), 64 - shift))
      bits = ibits(bits, 0, mantissa_bits + 1)
   end function extract_bits

   !> Set the sum to zero.
   pure subroutine exact_sum_clear(self)
      class(exact_sum_t), intent(inout) :: self
      self%limbs = 0_int64
      self%special = 0_int64
      self%terms = 0_int64
   end subroutine exact_sum_clear

   !> The sum as integers; equal sums give equal numbers.
   pure subroutine exact_sum_save(self, words)
      class(exact_sum_t), intent(in) :: self
      integer(int64), intent(out) :: words(exact_sum_words) !! Its limbs and counts
      type(exact_sum_t) :: work

      work%limbs = self%limbs
      call carry_limbs(work)
      words(:top + 1) = work%limbs
      words(top + 2:) = self%special
   end subroutine exact_sum_save

   !> The sum from integers.
   pure subroutine exact_sum_load(self, words)
      class(exact_sum_t), intent(inout) :: self
      integer(int64), intent(in) :: words(exact_sum_words) !! From `save`, or the sum of several

      self%limbs = words(:top + 1)
      self%special = words(top + 2:)
      self%terms = 1_int64
   end subroutine exact_sum_load
end module base_exact_sum
