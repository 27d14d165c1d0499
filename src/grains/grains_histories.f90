! SPDX-License-Identifier: BSD-3-Clause
!> Carries the histories of contacts from one list of pairs to the next, to other ranks and to
!! files.
module grains_histories
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use grains_cell, only: losses
   use grains_pairs, only: dashpot_loss, history_words, pairs_t
   use grains_state, only: grains_t
   implicit none
   private

   public :: collect_records, drop_parted, give_records, is_own_pair, share_records

   integer, parameter, public :: record_words = history_words + 2 !! Both identities first

contains

   !> Histories to keep, with the identities of their grains. Pairs that do not touch keep only
   !! their losses.
   subroutine collect_records(grains, pairs, home_only, records)
      type(grains_t), intent(in) :: grains
      type(pairs_t), intent(in) :: pairs
      logical, intent(in) :: home_only               !! Only pairs whose first row is of this rank?
      real(wp), allocatable, intent(out) :: records(:, :) !! (word, record)
      logical :: wanted(pairs%count)
      integer :: pair, n

      do pair = 1, pairs%count
         wanted(pair) = pairs%touches(pair) .or. any(abs(pairs%history(dashpot_loss: &
            dashpot_loss + losses - 1, pair)) > 0.0_wp)
         if (home_only) wanted(pair) = wanted(pair) .and. is_own_pair(grains, pairs, pair)
      end do
      allocate (records(record_words, count(wanted)))
      n = 0
      do pair = 1, pairs%count
         if (.not. wanted(pair)) cycle
         n = n + 1
         records(1, n) = real(grains%identity(pairs%first(pair)), wp)
         records(2, n) = real(grains%identity(pairs%second(pair)), wp)
         records(3:, n) = pairs%history(:, pair)
      end do
   end subroutine collect_records

   !> True if this rank owns a pair.
   pure logical function is_own_pair(grains, pairs, pair) result(is_own)
      type(grains_t), intent(in) :: grains
      type(pairs_t), intent(in) :: pairs
      integer, intent(in) :: pair                    !! Number

      is_own = pairs%first(pair) >= grains%first .and. pairs%first(pair) <= grains%last
   end function is_own_pair

   !> Add the losses of pairs of this rank that do not touch to the sums, and delete their
   !! histories.
   subroutine drop_parted(grains, pairs, lost)
      type(grains_t), intent(in) :: grains
      type(pairs_t), intent(inout) :: pairs
      type(exact_sum_t), intent(inout) :: lost(losses)
      integer :: pair, loss

      do pair = 1, pairs%count
         if (pairs%touches(pair)) cycle
         if (is_own_pair(grains, pairs, pair)) then
            do loss = 1, losses
               call lost(loss)%add(pairs%history(dashpot_loss + loss - 1, pair))
            end do
         end if
         pairs%history(:, pair) = 0.0_wp
      end do
   end subroutine drop_parted

   !> Give every rank the records of all. Collective.
   subroutine share_records(communicator, records)
      type(communicator_t), intent(in) :: communicator
      real(wp), allocatable, intent(inout) :: records(:, :) !! (word, record)
      integer(int64), allocatable :: own(:), whole(:)

      if (communicator%size == 1) return
      own = transfer(records, own)
      call communicator%gather(own, whole)
      deallocate (records)
      allocate (records(record_words, size(whole)/record_words))
      records = reshape(transfer(whole, records), shape(records))
   end subroutine share_records

   !> Give histories to the pairs of this rank.
   subroutine give_records(grains, records, pairs)
      type(grains_t), intent(in) :: grains
      real(wp), intent(in) :: records(:, :)          !! (word, record) In any order
      type(pairs_t), intent(inout) :: pairs
      integer, allocatable :: start(:), order(:), next(:)
      integer :: n, pair, low, high

      allocate (start(grains%count + 1), order(size(records, 2)))
      start = 0
      do n = 1, size(records, 2)
         low = nint(records(1, n))
         start(low + 1) = start(low + 1) + 1
      end do
      start(1) = 1
      do n = 2, size(start)
         start(n) = start(n - 1) + start(n)
      end do
      next = start
      do n = 1, size(records, 2)
         low = nint(records(1, n))
         order(next(low)) = n
         next(low) = next(low) + 1
      end do
      !$omp parallel do default(none) shared(grains, records, pairs, start, order) &
      !$omp private(pair, low, high, n) schedule(static)
      do pair = 1, pairs%count
         low = grains%identity(pairs%first(pair))
         high = grains%identity(pairs%second(pair))
         do n = start(low), start(low + 1) - 1
            if (nint(records(2, order(n))) /= high) cycle
            pairs%history(:, pair) = records(3:, order(n))
            exit
         end do
      end do
      !$omp end parallel do
   end subroutine give_records
end module grains_histories
