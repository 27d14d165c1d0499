! SPDX-License-Identifier: BSD-3-Clause
!> Lists of the rows that ranks exchange, and messages between ranks about their grains.
module grains_exchange
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t, exact_sum_words
   use base_kinds, only: int64, wp
   use grains_pairs, only: pairs_t
   use grains_state, only: block_rows, grains_t
   implicit none
   private

   public :: exchange_grains, first_row_of, gather_rows, grain_halo_t, link_halo, own_rows, total_of

   integer, parameter :: grain_words = 12            !! Position, velocity, spin, force

   !> Rows that other ranks need, and rows of others that this rank needs, each rank by rank and
   !! ascending. Both ranks of a pair find the same lists.
   type :: grain_halo_t
      integer, allocatable :: rank(:)                !! Ranks around
      integer, allocatable :: give_start(:)          !! (rank + 1) First index in `give`
      integer, allocatable :: give(:)                !! Own rows
      integer, allocatable :: take_start(:)          !! (rank + 1) First index in `take`
      integer, allocatable :: take(:)                !! Rows of others
   end type grain_halo_t

contains

   !> First row of a rank: whole blocks, as even as possible. For rank `ranks` it is one after the
   !! last row.
   pure integer function first_row_of(count, rank, ranks) result(row)
      integer, intent(in) :: count                   !! Rows
      integer, intent(in) :: rank, ranks             !! Number of the rank, number of ranks
      integer(int64) :: blocks

      blocks = (count + block_rows - 1)/block_rows
      row = int(min(int(count, int64), block_rows*(blocks*rank/ranks))) + 1
      if (rank == ranks) row = count + 1
   end function first_row_of

   !> Choose the own rows.
   pure subroutine own_rows(communicator, grains)
      type(communicator_t), intent(in) :: communicator
      type(grains_t), intent(inout) :: grains

      grains%first = first_row_of(grains%count, communicator%rank, communicator%size)
      grains%last = first_row_of(grains%count, communicator%rank + 1, communicator%size) - 1
   end subroutine own_rows

   !> Give every rank the values of all rows. Collective.
   subroutine gather_rows(communicator, first, last, values)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: first, last             !! Own rows
      real(wp), contiguous, intent(inout) :: values(:, :) !! (word, row)
      integer(int64), allocatable :: own(:), whole(:)

      if (communicator%size == 1) return
      own = transfer(values(:, first:last), own)
      call communicator%gather(own, whole)
      values = reshape(transfer(whole, values), shape(values))
   end subroutine gather_rows

   !> Find which ranks need which rows, from the pairs of the rows of this rank.
   subroutine link_halo(communicator, grains, pairs, halo)
      type(communicator_t), intent(in) :: communicator
      type(grains_t), intent(in) :: grains
      type(pairs_t), intent(in) :: pairs
      type(grain_halo_t), intent(out) :: halo
      logical, allocatable :: give(:), take(:)
      integer :: rank, pair, mine, other, first, last

      allocate (halo%rank(0), halo%give(0), halo%take(0))
      halo%give_start = [1]
      halo%take_start = [1]
      if (communicator%size == 1) return
      do rank = 0, communicator%size - 1
         if (rank == communicator%rank) cycle
         first = first_row_of(grains%count, rank, communicator%size)
         last = first_row_of(grains%count, rank + 1, communicator%size) - 1
         allocate (give(grains%first:grains%last), take(first:last))
         give = .false.
         take = .false.
         do pair = 1, pairs%count
            mine = pairs%first(pair)
            other = pairs%second(pair)
            if (mine >= first .and. mine <= last) then
               mine = pairs%second(pair)
               other = pairs%first(pair)
            end if
            if (other < first .or. other > last) cycle
            give(mine) = .true.
            take(other) = .true.
         end do
         if (any(take)) then
            halo%rank = [halo%rank, rank]
            call append_rows(give, grains%first, halo%give, halo%give_start)
            call append_rows(take, first, halo%take, halo%take_start)
         end if
         deallocate (give, take)
      end do
   end subroutine link_halo

   !> Append the rows that are marked.
   pure subroutine append_rows(marked, first, rows, start)
      logical, intent(in) :: marked(:)
      integer, intent(in) :: first                   !! Row of the first mark
      integer, allocatable, intent(inout) :: rows(:)
      integer, allocatable, intent(inout) :: start(:)
      integer :: n

      rows = [rows, pack([(first + n - 1, n=1, size(marked))], marked)]
      start = [start, size(rows) + 1]
   end subroutine append_rows

   !> Update positions, velocities and previous forces of the rows of other ranks. Collective.
   subroutine exchange_grains(communicator, halo, grains)
      type(communicator_t), intent(inout) :: communicator
      type(grain_halo_t), intent(in) :: halo
      type(grains_t), intent(inout) :: grains
      integer(int64), allocatable :: outgoing(:), incoming(:)
      integer, allocatable :: length(:)
      integer :: n, place, next, row

      if (communicator%size == 1) return
      allocate (length(size(halo%rank)))
      allocate (outgoing(size(halo%rank) + grain_words*size(halo%give)))
      next = 1
      do n = 1, size(halo%rank)
         length(n) = 1 + grain_words*(halo%give_start(n + 1) - halo%give_start(n))
         outgoing(next) = communicator%rank
         next = next + 1
         do place = halo%give_start(n), halo%give_start(n + 1) - 1
            row = halo%give(place)
            outgoing(next:next + grain_words - 1) = transfer([grains%position(:, row), &
               grains%velocity(:, row), grains%spin(:, row), grains%force(:, row)], outgoing)
            next = next + grain_words
         end do
      end do
      call communicator%exchange(halo%rank, length, outgoing, incoming)
      next = 1
      do while (next <= size(incoming))
         n = findloc(halo%rank, int(incoming(next)), dim=1)
         next = next + 1
         do place = halo%take_start(n), halo%take_start(n + 1) - 1
            call take_grain(incoming(next:next + grain_words - 1), halo%take(place), grains)
            next = next + grain_words
         end do
      end do
   end subroutine exchange_grains

   !> Unpack a grain of another rank from a message.
   pure subroutine take_grain(words, row, grains)
      integer(int64), intent(in) :: words(grain_words)
      integer, intent(in) :: row
      type(grains_t), intent(inout) :: grains
      real(wp) :: numbers(grain_words)

      numbers = transfer(words, numbers)
      grains%position(:, row) = numbers(1:3)
      grains%velocity(:, row) = numbers(4:6)
      grains%spin(:, row) = numbers(7:9)
      grains%force(:, row) = numbers(10:12)
   end subroutine take_grain

   !> Sums over all blocks of all ranks, rounded once: the same bits for any ranks. Collective.
   subroutine total_of(communicator, terms, sums)
      type(communicator_t), intent(in) :: communicator
      real(wp), contiguous, intent(in) :: terms(:, :) !! (quantity, own block)
      real(wp), intent(out) :: sums(:)               !! (quantity)
      type(exact_sum_t) :: sum
      integer(int64) :: words(exact_sum_words, size(terms, 1))
      integer(int64) :: flat(size(words))
      integer :: quantity, block

      do quantity = 1, size(terms, 1)
         call sum%clear()
         do block = 1, size(terms, 2)
            call sum%add(terms(quantity, block))
         end do
         if (communicator%size == 1) sums(quantity) = sum%value()
         if (communicator%size > 1) call sum%save(words(:, quantity))
      end do
      if (communicator%size == 1) return
      flat = reshape(words, [size(words)])
      call communicator%total(flat)
      words = reshape(flat, shape(words))
      do quantity = 1, size(terms, 1)
         call sum%load(words(:, quantity))
         sums(quantity) = sum%value()
      end do
   end subroutine total_of
end module grains_exchange
