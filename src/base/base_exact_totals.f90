! SPDX-License-Identifier: BSD-3-Clause
!> Many exact sums over all ranks in one message.
module base_exact_totals
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t, exact_sum_words
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: total_words, totals_over_ranks

contains

   !> Add the words of sums over all ranks; equal sums have equal words on any ranks. Collective.
   subroutine total_words(communicator, words)
      type(communicator_t), intent(in) :: communicator
      integer(int64), contiguous, intent(inout) :: words(:) !! From `save` of each sum
      type(exact_sum_t) :: sum
      integer :: first

      call communicator%total(words)
      ! added words are not carried: a sum that is loaded and saved is
      do first = 1, size(words), exact_sum_words
         call sum%load(words(first:first + exact_sum_words - 1))
         call sum%save(words(first:first + exact_sum_words - 1))
      end do
   end subroutine total_words

   !> Values of sums over all ranks, each rounded once. Collective.
   subroutine totals_over_ranks(communicator, total, values)
      type(communicator_t), intent(in) :: communicator
      type(exact_sum_t), intent(inout) :: total(:)       !! Parts of this rank in, whole out
      real(wp), intent(out) :: values(:)                 !! Rounded to one number each
      integer(int64), allocatable :: words(:)
      integer :: first, n

      if (communicator%size > 1) then
         allocate (words(exact_sum_words*size(total)))
         do n = 1, size(total)
            first = exact_sum_words*(n - 1)
            call total(n)%save(words(first + 1:first + exact_sum_words))
         end do
         call communicator%total(words)
         do n = 1, size(total)
            first = exact_sum_words*(n - 1)
            call total(n)%load(words(first + 1:first + exact_sum_words))
         end do
      end if
      do n = 1, size(total)
         values(n) = total(n)%value()
      end do
   end subroutine totals_over_ranks
end module base_exact_totals
