! SPDX-License-Identifier: BSD-3-Clause
!> Redistributes the rows of a data set evenly over the ranks before they are compressed.
!!
!! The positions of compressed chunks in an HDF5 file depend on the ranks that write to them, unless
!! every rank writes one range of rows in the order of the ranks. Also, a chunk of one rank only is
!! compressed without messages.
module io_level
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use io_hdf5_write, only: rows_t
   implicit none
   private

   public :: even_chunks, level_reals, level_rows, level_integers, owner_of

   integer, parameter :: heading = 2                     !! Words before the rows of a message

contains

   !> Rows distributed by full chunks; unchanged if they are not compressed.
   pure function level_rows(communicator, rows) result(even)
      type(communicator_t), intent(in) :: communicator
      type(rows_t), intent(in) :: rows                   !! Distribution of the particles
      type(rows_t) :: even

      if (rows%compress == 0 .or. communicator%size == 1) then
         even = rows
         return
      end if
      even = even_chunks(communicator, rows%total, rows%compress)
   end function level_rows

   !> Rows distributed by full chunks.
   pure function even_chunks(communicator, total, compress, chunk) result(even)
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(in) :: total                !! Rows on all ranks
      integer, intent(in) :: compress                    !! gzip level
      integer(int64), intent(in), optional :: chunk      !! Rows of a chunk
      type(rows_t) :: even

      even%total = total
      even%compress = compress
      if (present(chunk)) even%chunk = chunk
      allocate (even%before(1), even%count(1))
      even%before = first_row(communicator, even, communicator%rank)
      even%count = first_row(communicator, even, communicator%rank + 1) - even%before
   end function even_chunks

   !> Number of rows before those of a rank.
   pure function first_row(communicator, rows, rank) result(row)
      type(communicator_t), intent(in) :: communicator
      type(rows_t), intent(in) :: rows                   !! Total and rows of a chunk
      integer, intent(in) :: rank                        !! From 0 to the number of ranks
      integer(int64) :: row
      integer(int64) :: chunks

      chunks = (rows%total + rows%chunk - 1)/rows%chunk
      row = min(rows%total, rows%chunk*(chunks*rank/communicator%size))
   end function first_row

   !> Rank of a row that is distributed by `even_chunks`: the last one whose first row is not after
   !! it.
   pure integer function owner_of(communicator, rows, row) result(rank)
      type(communicator_t), intent(in) :: communicator
      type(rows_t), intent(in) :: rows                   !! Total and rows of a chunk
      integer(int64), intent(in) :: row                  !! Counted from 0
      integer :: above, middle

      rank = 0
      above = communicator%size
      do while (above - rank > 1)
         middle = (rank + above)/2
         if (first_row(communicator, rows, middle) <= row) then
            rank = middle
         else
            above = middle
         end if
      end do
   end function owner_of

   !> Redistribute reals. Collective.
   subroutine level_reals(communicator, rows, even, values)
      type(communicator_t), intent(inout) :: communicator
      type(rows_t), intent(in) :: rows                   !! Present distribution
      type(rows_t), intent(in) :: even                   !! New distribution, from `level_rows`
      real(wp), allocatable, intent(inout) :: values(:, :) !! (component, row)
      integer(int64), allocatable :: words(:, :)
      integer :: component, components, row

      if (rows%compress == 0 .or. communicator%size == 1) return
      components = size(values, 1)
      allocate (words(components, size(values, 2)))
      do row = 1, size(values, 2)
         do component = 1, components
            words(component, row) = transfer(values(component, row), 0_int64)
         end do
      end do
      call redistribute(communicator, rows, even, words)
      deallocate (values)
      allocate (values(components, size(words, 2)))
      do row = 1, size(words, 2)
         do component = 1, components
            values(component, row) = transfer(words(component, row), 0.0_wp)
         end do
      end do
   end subroutine level_reals

   !> Redistribute integers. Collective.
   subroutine level_integers(communicator, rows, even, values)
      type(communicator_t), intent(inout) :: communicator
      type(rows_t), intent(in) :: rows                   !! Present distribution
      type(rows_t), intent(in) :: even                   !! New distribution, from `level_rows`
      integer(int64), allocatable, intent(inout) :: values(:) !! (row)
      integer(int64), allocatable :: words(:, :)

      if (rows%compress == 0 .or. communicator%size == 1) return
      allocate (words(1, size(values)))
      words(1, :) = values
      call redistribute(communicator, rows, even, words)
      deallocate (values)
      allocate (values(size(words, 2)))
      values(:) = words(1, :)
   end subroutine level_integers

   !> Redistribute words. Collective.
   subroutine redistribute(communicator, rows, even, words)
      type(communicator_t), intent(inout) :: communicator
      type(rows_t), intent(in) :: rows                   !! Present distribution
      type(rows_t), intent(in) :: even                   !! New distribution
      integer(int64), allocatable, intent(inout) :: words(:, :) !! (component, row)
      integer(int64), allocatable :: incoming(:), outgoing(:)
      integer, allocatable :: destination(:), length(:)
      integer :: at, component, components, row, size_of
      integer(int64) :: place

      components = size(words, 1)
      call pack_messages(communicator, rows, words, destination, length, outgoing)
      deallocate (words)
      call communicator%exchange(destination, length, outgoing, incoming)
      allocate (words(components, even%count(1)))
      at = 0
      do while (at < size(incoming))
         place = incoming(at + 1) - even%before(1)
         size_of = int(incoming(at + 2))
         at = at + heading
         do row = 1, size_of
            do component = 1, components
               words(component, place + row) = incoming(at + component)
            end do
            at = at + components
         end do
      end do
   end subroutine redistribute

   !> Pack the rows of this rank into messages, one for each range and receiving rank.
   subroutine pack_messages(communicator, rows, words, destination, length, outgoing)
      type(communicator_t), intent(in) :: communicator
      type(rows_t), intent(in) :: rows                   !! Present distribution
      integer(int64), contiguous, intent(in) :: words(:, :) !! (component, row)
      integer, allocatable, intent(out) :: destination(:) !! (message) Rank
      integer, allocatable, intent(out) :: length(:)     !! (message) Words
      integer(int64), allocatable, intent(out) :: outgoing(:) !! All messages
      integer :: at, component, count, messages, own, piece, row
      integer(int64) :: most
      integer(int64) :: last, place

      ! a range begins and ends within chunks, and each chunk is on one rank
      most = min(sum(rows%count/rows%chunk + 2), &
         size(rows%count, kind=int64)*communicator%size)
      allocate (destination(most), length(most), outgoing(size(words) + heading*most))
      messages = 0
      at = 0
      own = 0
      do piece = 1, size(rows%count)
         place = rows%before(piece)
         last = place + rows%count(piece)
         do while (place < last)
            messages = messages + 1
            destination(messages) = owner_of(communicator, rows, place)
            count = int(min(last, first_row(communicator, rows, &
               destination(messages) + 1)) - place)
            length(messages) = heading + count*size(words, 1)
            outgoing(at + 1) = place
            outgoing(at + 2) = count
            at = at + heading
            do row = own + 1, own + count
               do component = 1, size(words, 1)
                  outgoing(at + component) = words(component, row)
               end do
               at = at + size(words, 1)
            end do
            own = own + count
            place = place + count
         end do
      end do
      call shorten(destination, messages)
      call shorten(length, messages)
   end subroutine pack_messages

   !> Shorten an array to its first elements.
   pure subroutine shorten(array, count)
      integer, allocatable, intent(inout) :: array(:)
      integer, intent(in) :: count                       !! Number of elements to keep
      integer, allocatable :: shorter(:)

      allocate (shorter(count))
      shorter(:) = array(:count)
      call move_alloc(shorter, array)
   end subroutine shorten
end module io_level
