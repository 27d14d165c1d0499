! SPDX-License-Identifier: BSD-3-Clause
!> Counter-based random numbers: each is a function of the seed, its owner, and its index.
!!
!! They do not depend on ranks, threads, the order of particles, or a restart. Sums and products
!! overflow and wrap around; the build compiles this file with -fwrapv for that.
module base_random
   use base_constants, only: pi
   use base_hash, only: mix
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: random_bits, random_normal, random_uniform

contains

   !> Sixty-four random bits.
   elemental function random_bits(seed, identity, draw) result(bits)
      integer(int64), intent(in) :: seed                !! Seed of the run
      integer(int64), intent(in) :: identity            !! Identity of the owner
      integer(int64), intent(in) :: draw                !! Index of the number
      integer(int64) :: bits

      bits = mix(mix(mix(seed) + identity) + draw)
   end function random_bits

   !> A uniformly distributed number in the open interval (0, 1).
   elemental function random_uniform(seed, identity, draw) result(number)
      integer(int64), intent(in) :: seed                !! Seed of the run
      integer(int64), intent(in) :: identity            !! Identity of the owner
      integer(int64), intent(in) :: draw                !! Index of the number
      real(wp) :: number

      number = (real(shiftr(random_bits(seed, identity, draw), 12), wp) + 0.5_wp)*2.0_wp**(-52)
   end function random_uniform

   !> A normally distributed number of mean 0 and variance 1 (Box and Muller 1958).
   elemental function random_normal(seed, identity, draw) result(number)
      integer(int64), intent(in) :: seed                !! Seed of the run
      integer(int64), intent(in) :: identity            !! Identity of the owner
      integer(int64), intent(in) :: draw                !! Index of the number
      real(wp) :: number
      real(wp) :: angle, radius

      radius = sqrt(-2.0_wp*log(random_uniform(seed, identity, 2_int64*draw)))
      angle = 2.0_wp*pi*random_uniform(seed, identity, 2_int64*draw + 1_int64)
      number = radius*cos(angle)
   end function random_normal
end module base_random
