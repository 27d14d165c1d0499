! SPDX-License-Identifier: BSD-3-Clause
!> Hashes that are added, so that the hash of a set does not depend on the order of its elements.
!!
!! Each value is mixed with a key of its field and owner. Sums overflow and wrap around; the build
!! compiles this file with -fwrapv for that.
module base_hash
   use base_kinds, only: int32, int64, wp
   implicit none
   private

   public :: add_hash, digest_text, hash_reals, hash_text, hash_integers, mix

   !> Odd numbers of the splitmix64 generator.
   integer(int64), parameter :: golden = int(z"9E3779B97F4A7C15", int64)
   integer(int64), parameter :: first_factor = int(z"BF58476D1CE4E5B9", int64)
   integer(int64), parameter :: second_factor = int(z"94D049BB133111EB", int64)

contains

   !> Mix the bits of a word: the finaliser of splitmix64.
   !!
   !! G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators",
   !! OOPSLA 2014.
   elemental function mix(bits) result(mixed)
      integer(int64), intent(in) :: bits                !! Any word
      integer(int64) :: mixed

      mixed = bits + golden
      mixed = ieor(mixed, shiftr(mixed, 30))*first_factor
      mixed = ieor(mixed, shiftr(mixed, 27))*second_factor
      mixed = ieor(mixed, shiftr(mixed, 31))
   end function mix

   !> Sum of two hashes, with wrap-around.
   elemental function add_hash(first, second) result(hash)
      integer(int64), intent(in) :: first               !! First hash
      integer(int64), intent(in) :: second              !! Second hash
      integer(int64) :: hash

      hash = first + second
   end function add_hash

   !> Hash of a text, with its trailing blanks.
   pure function hash_text(text) result(hash)
      character(len=*), intent(in) :: text              !! Text
      integer(int64) :: hash
      integer :: letter

      hash = mix(int(len(text), int64))
      do letter = 1, len(text)
         hash = mix(hash + int(iachar(text(letter:letter)), int64))
      end do
   end function hash_text

   !> Sum of the hashes of real numbers, each keyed by its owner.
   pure function hash_reals(key, owners, values) result(hash)
      integer(int64), intent(in) :: key                 !! Key of the field
      integer(int64), contiguous, intent(in) :: owners(:) !! Identities of the owners
      real(wp), contiguous, intent(in) :: values(:)     !! Values of the field
      integer(int64) :: hash
      integer :: index

      hash = 0
      do index = 1, size(values)
         hash = hash + mix(ieor(mix(ieor(owners(index), key)), transfer(values(index), key)))
      end do
   end function hash_reals

   !> Sum of the hashes of integers, each keyed by its owner.
   pure function hash_integers(key, owners, values) result(hash)
      integer(int64), intent(in) :: key                 !! Key of the field
      integer(int64), contiguous, intent(in) :: owners(:) !! Identities of the owners
      integer(int64), contiguous, intent(in) :: values(:) !! Values of the field
      integer(int64) :: hash
      integer :: index

      hash = 0
      do index = 1, size(values)
         hash = hash + mix(ieor(mix(ieor(owners(index), key)), values(index)))
      end do
   end function hash_integers

   !> A hash as 16 hexadecimal digits.
   pure function digest_text(hash) result(text)
      integer(int64), intent(in) :: hash                !! Any word
      character(len=16) :: text
      character(len=*), parameter :: digits = "0123456789abcdef"
      integer :: place
      integer(int32) :: digit

      do place = 1, 16
         digit = int(ibits(hash, 64 - 4*place, 4), int32)
         text(place:place) = digits(digit + 1:digit + 1)
      end do
   end function digest_text
end module base_hash
