! SPDX-License-Identifier: BSD-3-Clause
!> Sums of real numbers without any rounding but the last, so that no order of terms matters.
!!
!! A sum is one long whole number in units of the smallest real number, 2^-1074, cut into limbs of
!! 32 bits: U. Kulisch, "Very fast and exact accumulation of products", Computing 91 (2011) 397.
module base_exact_sum
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_positive_inf, ieee_quiet_nan, &
      ieee_value
   implicit none
   private

   public :: exact_sum_t

   integer, parameter :: top = 68                        !! Last limb, room for 2^70 greatest terms
   integer, parameter, public :: exact_sum_words = top + 4 !! Whole numbers that hold a sum
   integer, parameter :: mantissa_bits = 52              !! Stored bits of a real number
   integer(int64), parameter :: limb_mask = 2_int64**32 - 1_int64
   integer(int64), parameter :: hidden_bit = 2_int64**52
   !> Terms between two carries; each adds less than 2^32 to a limb of 63 bits.
   integer(int64), parameter :: most_terms = 2_int64**29

   !> A sum.
   type :: exact_sum_t
      integer(int64), private :: limbs(0:top) = 0_int64  !! Signed digits of base 2^32
      integer(int64), private :: odd(3) = 0_int64        !! Terms that were NaN, infinite, -infinite
      integer(int64), private :: terms = 0_int64         !! Terms since the last carry
   contains
      procedure :: add => exact_sum_add                  !! Add one number
      procedure :: add_all => exact_sum_add_all          !! Add all numbers of an array
      procedure :: merge => exact_sum_merge              !! Add another sum
      procedure :: over_ranks => exact_sum_over_ranks    !! Add the sums of all ranks
      procedure :: value => exact_sum_value              !! The sum, correctly rounded
      procedure :: clear => exact_sum_clear              !! Begin anew
      procedure :: save => exact_sum_save                !! The sum as whole numbers
      procedure :: load => exact_sum_load                !! The sum from whole numbers
   end type exact_sum_t

contains

   !> Add one number.
   pure subroutine exact_sum_add(self, number)
      class(exact_sum_t), intent(inout) :: self          !! The sum
      real(wp), intent(in) :: number                     !! The term
      integer(int64) :: bits, mantissa, sign_mask, low
      integer :: exponent_field, limb, shift

      bits = transfer(number, bits)
      exponent_field = int(ibits(bits, mantissa_bits, 11))
      mantissa = ibits(bits, 0, mantissa_bits)
      if (exponent_field == 2047) then
         call add_odd(self%odd, mantissa /= 0_int64, bits < 0_int64)
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
      if (self%terms >= most_terms) call carry(self)
   end subroutine exact_sum_add

   !> Count a term that is no finite number.
   pure subroutine add_odd(odd, undefined, negative)
      integer(int64), intent(inout) :: odd(3)            !! Counts
      logical, intent(in) :: undefined                   !! Not a number
      logical, intent(in) :: negative                    !! Sign of an infinite term

      if (undefined) then
         odd(1) = odd(1) + 1_int64
      else if (negative) then
         odd(3) = odd(3) + 1_int64
      else
         odd(2) = odd(2) + 1_int64
      end if
   end subroutine add_odd

   !> Add all numbers of an array.
   pure subroutine exact_sum_add_all(self, numbers)
      class(exact_sum_t), intent(inout) :: self          !! The sum
      real(wp), intent(in) :: numbers(:)                 !! The terms
      integer :: index

      do index = 1, size(numbers)
         call self%add(numbers(index))
      end do
   end subroutine exact_sum_add_all

   !> Bring all limbs but the last to 0 ... 2^32 - 1.
   pure subroutine carry(self)
      class(exact_sum_t), intent(inout) :: self          !! The sum
      integer :: limb

      do limb = 0, top - 1
         self%limbs(limb + 1) = self%limbs(limb + 1) + shifta(self%limbs(limb), 32)
         self%limbs(limb) = iand(self%limbs(limb), limb_mask)
      end do
      self%terms = 0_int64
   end subroutine carry

   !> Add another sum.
   pure subroutine exact_sum_merge(self, other)
      class(exact_sum_t), intent(inout) :: self          !! The sum
      type(exact_sum_t), intent(in) :: other             !! What is added

      if (self%terms + other%terms + 1_int64 >= most_terms) call carry(self)
      self%limbs = self%limbs + other%limbs
      self%odd = self%odd + other%odd
      self%terms = self%terms + other%terms + 1_int64
      if (self%terms >= most_terms) call carry(self)
   end subroutine exact_sum_merge

   !> Add the sums of all ranks; every rank gets the whole. Collective.
   subroutine exact_sum_over_ranks(self, communicator)
      class(exact_sum_t), intent(inout) :: self          !! Part of this rank in, whole out
      type(communicator_t), intent(in) :: communicator   !! The ranks
      integer(int64) :: words(exact_sum_words)

      call self%save(words)
      call communicator%total(words)
      call self%load(words)
      call carry(self)
   end subroutine exact_sum_over_ranks

   !> The sum, rounded once, to nearest and ties to even.
   pure function exact_sum_value(self) result(number)
      class(exact_sum_t), intent(in) :: self             !! The sum
      real(wp) :: number
      type(exact_sum_t) :: work
      logical :: negative

      if (self%odd(1) > 0_int64 .or. (self%odd(2) > 0_int64 .and. self%odd(3) > 0_int64)) then
         number = ieee_value(number, ieee_quiet_nan)
         return
      end if
      if (self%odd(2) > 0_int64) number = ieee_value(number, ieee_positive_inf)
      if (self%odd(3) > 0_int64) number = ieee_value(number, ieee_negative_inf)
      if (any(self%odd > 0_int64)) return
      work%limbs = self%limbs
      call carry(work)
      negative = work%limbs(top) < 0_int64
      if (negative) then
         work%limbs = -work%limbs
         call carry(work)
      end if
      number = rounded(work%limbs)
      if (negative) number = -number
   end function exact_sum_value

   !> A long whole number that is not negative, rounded to a real number.
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
      mantissa = cut(limbs, last)
      if (last > 0) then
         half = btest(limbs((last - 1)/32), mod(last - 1, 32))
         rest = any(limbs(:(last - 1)/32 - 1) /= 0_int64) .or. &
            ibits(limbs((last - 1)/32), 0, mod(last - 1, 32)) /= 0_int64
         if (half .and. (rest .or. btest(mantissa, 0))) mantissa = mantissa + 1_int64
      end if
      ! The hidden bit, if there, raises the exponent by one, as does a carry out of the mantissa.
      number = transfer(shiftl(int(last, int64), mantissa_bits) + mantissa, number)
   end function rounded

   !> The 53 bits from a place upwards.
   pure function cut(limbs, last) result(bits)
      integer(int64), intent(in) :: limbs(0:top)         !! Digits of base 2^32
      integer, intent(in) :: last                        !! Lowest bit wanted
      integer(int64) :: bits
      integer :: limb, shift

      limb = last/32
      shift = mod(last, 32)
      bits = shiftr(limbs(limb), shift)
      if (limb < top) bits = ior(bits, shiftl(limbs(limb + 1), 32 - shift))
      if (limb + 1 < top .and. shift > 0) bits = ior(bits, shiftl(limbs(limb + 2), 64 - shift))
      bits = ibits(bits, 0, mantissa_bits + 1)
   end function cut

   !> Begin anew.
   pure subroutine exact_sum_clear(self)
      class(exact_sum_t), intent(inout) :: self          !! The sum

      self%limbs = 0_int64
      self%odd = 0_int64
      self%terms = 0_int64
   end subroutine exact_sum_clear

   !> The sum as whole numbers; equal sums give equal numbers.
   pure subroutine exact_sum_save(self, words)
      class(exact_sum_t), intent(in) :: self             !! The sum
      integer(int64), intent(out) :: words(exact_sum_words) !! Its limbs and counts
      type(exact_sum_t) :: work

      work%limbs = self%limbs
      call carry(work)
      words(:top + 1) = work%limbs
      words(top + 2:) = self%odd
   end subroutine exact_sum_save

   !> The sum from whole numbers.
   pure subroutine exact_sum_load(self, words)
      class(exact_sum_t), intent(inout) :: self          !! The sum
      integer(int64), intent(in) :: words(exact_sum_words) !! From `save`, or the sum of several

      self%limbs = words(:top + 1)
      self%odd = words(top + 2:)
      self%terms = 1_int64
   end subroutine exact_sum_load
end module base_exact_sum
