! SPDX-License-Identifier: BSD-3-Clause
!> Random numbers without a state: each is a function of the seed, of whose it is, and of its place.
!!
!! So no number depends on ranks, threads, the order of particles, or a restart. Sums and products
!! wrap round, which this file relies on (the build gives it the option that allows that).
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
      integer(int64), intent(in) :: identity            !! Whose number this is
      integer(int64), intent(in) :: draw                !! Which number of this owner
      integer(int64) :: bits

      bits = mix(mix(mix(seed) + identity) + draw)
   end function random_bits

   !> A number between 0 and 1, both excluded, evenly distributed.
   elemental function random_uniform(seed, identity, draw) result(number)
      integer(int64), intent(in) :: seed                !! Seed of the run
      integer(int64), intent(in) :: identity            !! Whose number this is
      integer(int64), intent(in) :: draw                !! Which number of this owner
      real(wp) :: number

      number = (real(shiftr(random_bits(seed, identity, draw), 12), wp) + 0.5_wp)*2.0_wp**(-52)
   end function random_uniform

   !> A normally distributed number of mean 0 and variance 1 (Box and Muller 1958).
   elemental function random_normal(seed, identity, draw) result(number)
      integer(int64), intent(in) :: seed                !! Seed of the run
      integer(int64), intent(in) :: identity            !! Whose number this is
      integer(int64), intent(in) :: draw                !! Which number of this owner
      real(wp) :: number
      real(wp) :: angle, radius

      radius = sqrt(-2.0_wp*log(random_uniform(seed, identity, 2_int64*draw)))
      angle = 2.0_wp*pi*random_uniform(seed, identity, 2_int64*draw + 1_int64)
      number = radius*cos(angle)
   end function random_normal
end module base_random
