! SPDX-License-Identifier: BSD-3-Clause
!> The ranks of a run and all communication between them. The only module that uses MPI.
module base_communicator
   use base_kinds, only: int64, wp
   use base_process, only: prefer_romio, private_memory
   use base_sort, only: sort_order
   use mpi_f08, only: mpi_abort, mpi_allgather, mpi_allgatherv, mpi_allreduce, mpi_any_source, &
      mpi_barrier, mpi_bcast, mpi_character, mpi_comm, mpi_comm_dup, mpi_comm_free, mpi_comm_rank, &
      mpi_comm_set_errhandler, mpi_comm_size, mpi_comm_world, mpi_double_precision, &
      mpi_errors_are_fatal, mpi_exscan, mpi_finalize, mpi_finalized, mpi_get_count, &
      mpi_get_library_version, mpi_iallreduce, mpi_ibarrier, mpi_info_null, mpi_init_thread, &
      mpi_initialized, mpi_integer8, mpi_iprobe, mpi_isend, mpi_issend, mpi_max, &
      mpi_max_library_version_string, mpi_min, mpi_probe, mpi_recv, mpi_request, mpi_status, &
      mpi_status_ignore, mpi_statuses_ignore, mpi_sum, mpi_test, mpi_testall, &
      mpi_thread_funneled, mpi_wait, mpi_waitall
   implicit none
   private

   public :: communicator_t, message_passing_has_ended, message_passing_has_started, &
      message_passing_version, posted_t, traffic_t

   !> Messages of a rank so far, and its waiting time.
   type :: traffic_t
      integer(int64) :: messages = 0                  !! Messages sent
      integer(int64) :: words = 0                     !! Words of 8 bytes in the messages
      real(wp) :: waiting = 0.0_wp                    !! Wall time in calls that wait [s]
   end type traffic_t

   integer, parameter :: first_tag = 100              !! Tag of the first exchange
   integer, parameter :: tags = 16384                 !! Exchanges after which tags repeat

   !> Messages in transit to a few ranks.
   type :: posted_t
      integer(int64), allocatable :: outgoing(:)      !! Words to send; unchanged until received
      integer, allocatable :: source(:)               !! Sender of each message that has arrived
      type(mpi_request), allocatable, private :: sent(:) !! One request per message
      integer, private :: tag = 0                     !! Tag of the exchange
   end type posted_t

   !> A group of ranks. Without `start` it is a group of one that never calls MPI.
   type :: communicator_t
      integer :: rank = 0                             !! This rank, from 0
      integer :: size = 1                             !! Number of ranks
      type(mpi_comm), private :: handle = mpi_comm_world !! Communicator of MPI
      type(traffic_t) :: traffic = traffic_t()        !! Counts of messages
      integer(int64) :: memory = 0 !! Private memory just after MPI was started [byte]
      !> Numbers of collective calls and of the words of 8 bytes of their results; number of
      !! exchanges, for the tags of their messages. Copies of a communicator share these, so that
      !! messages of an exchange on a copy are not taken for those of another on the original.
      integer(int64), pointer, private :: called(:) => null()
   contains
      procedure :: start => communicator_start        !! Start MPI
      procedure :: adopt => communicator_adopt        !! Use an existing communicator
      procedure :: duplicate => communicator_duplicate !! Use a copy of an existing one
      procedure :: release => communicator_release    !! Free that copy
      procedure :: finish => communicator_finish      !! Finish MPI
      procedure :: native => communicator_native      !! Handles for parallel HDF5
      procedure :: counts => communicator_counts      !! Messages and collective calls so far
      procedure :: barrier => communicator_barrier    !! Barrier
      procedure :: meets => communicator_meets        !! Barrier that a failed rank can give up
      procedure :: abort => communicator_abort        !! End all ranks at once
      procedure :: minimum => communicator_minimum    !! Minimum over the ranks
      procedure :: maximum => communicator_maximum    !! Maximum over the ranks
      procedure :: maxima => communicator_maxima      !! Maxima, element by element
      procedure :: least => communicator_least        !! Minima of integers, element by element
      procedure :: any => communicator_any            !! True if true on some rank
      procedure :: total => communicator_total        !! Sums of integers, element by element
      procedure :: before => communicator_before      !! Sum over the lower ranks
      procedure :: gather => communicator_gather      !! Concatenate over the ranks, on all of them
      procedure :: broadcast => communicator_broadcast !! Text of rank 0 to all
      procedure :: exchange => communicator_exchange  !! Sparse exchange of messages
      procedure :: send_rows => communicator_send_rows !! Send rows of words to their ranks
      procedure :: post => communicator_post          !! First half of an exchange: send
      procedure :: post_rows => communicator_post_rows !! The same for rows of words
      procedure :: complete => communicator_complete  !! Second half: receive
      procedure :: receive => communicator_receive    !! Second half if the senders are known
   end type communicator_t

contains

   !> Start MPI. Without `mpirun` Open MPI makes a group of one rank.
   subroutine communicator_start(self)
      class(communicator_t), intent(out) :: self      !! The group of all ranks
      integer :: provided
      logical :: started

      self%handle = mpi_comm_world
      call prefer_romio()
      call mpi_initialized(started)
      if (.not. started) call mpi_init_thread(mpi_thread_funneled, provided)
      call mpi_comm_rank(self%handle, self%rank)
      call mpi_comm_size(self%handle, self%size)
      allocate (self%called(3), source=0_int64)
      self%memory = private_memory()
   end subroutine communicator_start

   !> Use the communicator of a host program, or of a test.
   subroutine communicator_adopt(self, handle)
      class(communicator_t), intent(out) :: self
      integer, intent(in) :: handle                   !! Fortran handle of its MPI communicator

      self%handle%mpi_val = handle
      call mpi_comm_rank(self%handle, self%rank)
      call mpi_comm_size(self%handle, self%size)
      allocate (self%called(3), source=0_int64)
   end subroutine communicator_adopt

   !> Use a copy of the communicator of a host program, so that messages of both are not mixed. An
   !! MPI failure ends the process, as in the program scree. Collective over the host's ranks.
   subroutine communicator_duplicate(self, handle)
      class(communicator_t), intent(inout) :: self
      integer, intent(in) :: handle                   !! Fortran handle of the host's communicator
      type(mpi_comm) :: other

      other%mpi_val = handle
      call prefer_romio()
      if (.not. associated(self%called)) allocate (self%called(3), source=0_int64)
      call mpi_comm_dup(other, self%handle)
      call mpi_comm_set_errhandler(self%handle, mpi_errors_are_fatal)
      call mpi_comm_rank(self%handle, self%rank)
      call mpi_comm_size(self%handle, self%size)
   end subroutine communicator_duplicate

   !> Free the copy that `duplicate` made. Collective.
   subroutine communicator_release(self)
      class(communicator_t), intent(inout) :: self

      self%rank = 0
      self%size = 1
      if (associated(self%called)) deallocate (self%called)
      if (message_passing_has_ended()) return
      if (self%handle%mpi_val /= mpi_comm_world%mpi_val) call mpi_comm_free(self%handle)
      self%handle = mpi_comm_world
   end subroutine communicator_release

   !> True if MPI has been started, by Scree or by a host program.
   logical function message_passing_has_started() result(started)
      call mpi_initialized(started)
   end function message_passing_has_started

   !> True if MPI has been finished, so that it cannot be used any more.
   logical function message_passing_has_ended() result(ended)
      call mpi_finalized(ended)
   end function message_passing_has_ended

   !> Finish MPI, if it was started and is not finished.
   subroutine communicator_finish(self)
      class(communicator_t), intent(inout) :: self

      self%rank = 0
      self%size = 1
      if (associated(self%called)) deallocate (self%called)
      if (.not. message_passing_has_started()) return
      if (.not. message_passing_has_ended()) call mpi_finalize()
   end subroutine communicator_finish

   !> The handles of the group and of no hints, as integers, for parallel HDF5.
   pure subroutine communicator_native(self, group, hints)
      class(communicator_t), intent(in) :: self
      integer, intent(out) :: group                   !! Fortran handle of the communicator
      integer, intent(out) :: hints                   !! Fortran handle of the info object

      group = self%handle%mpi_val
      hints = mpi_info_null%mpi_val
   end subroutine communicator_native

   !> Messages sent, their words, collective calls, and the words of their results, so far.
   pure function communicator_counts(self) result(counts)
      class(communicator_t), intent(in) :: self
      integer(int64) :: counts(4)

      counts = [self%traffic%messages, self%traffic%words, 0_int64, 0_int64]
      if (associated(self%called)) counts(3:) = self%called(:2)
   end function communicator_counts

   !> Count a collective call.
   subroutine count_call(self, words)
      class(communicator_t), intent(in) :: self       !! A group that uses MPI
      integer, intent(in) :: words                    !! Words of 8 bytes of the result

      self%called(:2) = self%called(:2) + [1, words]
   end subroutine count_call

   !> Wait until all ranks have reached this call.
   subroutine communicator_barrier(self)
      class(communicator_t), intent(in) :: self

      if (self%size == 1) return
      call count_call(self, 0)
      call mpi_barrier(self%handle)
   end subroutine communicator_barrier

   !> Wait until all ranks have reached this call. A rank on which a collective call of a library
   !! has failed waits for a time only, since the others may still be in that call, which never
   !! ends: false. Collective.
   logical function communicator_meets(self, failed, patience) result(met)
      class(communicator_t), intent(in) :: self
      logical, intent(in) :: failed                   !! Has the call failed on this rank?
      real(wp), intent(in) :: patience                !! How long it waits then [s]
      integer(int64) :: begin, now, rate
      type(mpi_request) :: request

      met = .true.
      if (self%size == 1) return
      call count_call(self, 0)
      call mpi_ibarrier(self%handle, request)
      if (.not. failed) then
         call mpi_wait(request, mpi_status_ignore)
         return
      end if
      call system_clock(begin, rate)
      do
         call mpi_test(request, met, mpi_status_ignore)
         call system_clock(now)
         if (met .or. real(now - begin, wp) > patience*real(rate, wp)) return
      end do
   end function communicator_meets

   !> End all ranks at once, with an exit code.
   subroutine communicator_abort(self, code)
      class(communicator_t), intent(in) :: self
      integer, intent(in) :: code                     !! Exit code

      call mpi_abort(self%handle, code)
   end subroutine communicator_abort

   !> Minimum over the ranks of one number per rank. Collective.
   real(wp) function communicator_minimum(self, value) result(least)
      class(communicator_t), intent(in) :: self
      real(wp), intent(in) :: value                   !! Number of this rank

      least = -self%maximum(-value)
   end function communicator_minimum

   !> Maximum over the ranks of one number per rank. Collective.
   real(wp) function communicator_maximum(self, value) result(greatest)
      class(communicator_t), intent(in) :: self
      real(wp), intent(in) :: value                   !! Number of this rank

      greatest = value
      if (self%size == 1) return
      call count_call(self, 1)
      call mpi_allreduce(value, greatest, 1, mpi_double_precision, mpi_max, self%handle)
   end function communicator_maximum

   !> Replace each number of an array by its maximum over the ranks. Collective.
   subroutine communicator_maxima(self, values)
      class(communicator_t), intent(inout) :: self
      real(wp), contiguous, intent(inout) :: values(:) !! Of this rank in, maxima over ranks out
      real(wp), allocatable :: greatest(:)
      integer(int64) :: begin

      if (self%size == 1) return
      call system_clock(begin)
      allocate (greatest, mold=values)
      call mpi_allreduce(values, greatest, size(values), mpi_double_precision, mpi_max, &
         self%handle)
      values = greatest
      call count_call(self, size(values))
      call add_wait(self%traffic, begin)
   end subroutine communicator_maxima

   !> Replace each integer of an array by its minimum over the ranks. Collective.
   subroutine communicator_least(self, values)
      class(communicator_t), intent(in) :: self
      integer(int64), contiguous, intent(inout) :: values(:) !! Of this rank in, minima out
      integer(int64), allocatable :: least(:)

      if (self%size == 1) return
      call count_call(self, size(values))
      allocate (least, mold=values)
      call mpi_allreduce(values, least, size(values), mpi_integer8, mpi_min, self%handle)
      values = least
   end subroutine communicator_least

   !> Add the time since `begin` to the waiting time.
   subroutine add_wait(traffic, begin)
      type(traffic_t), intent(inout) :: traffic       !! Gets the time
      integer(int64), intent(in) :: begin             !! Clock at the start
      integer(int64) :: now, rate

      call system_clock(now, rate)
      traffic%waiting = traffic%waiting + real(now - begin, wp)/real(rate, wp)
   end subroutine add_wait

   !> True on all ranks if true on at least one of them. Collective.
   logical function communicator_any(self, value) result(some)
      class(communicator_t), intent(in) :: self
      logical, intent(in) :: value                    !! Condition on this rank
      integer(int64) :: counts(1)

      counts = merge(1_int64, 0_int64, value)
      call self%total(counts)
      some = counts(1) > 0
   end function communicator_any

   !> Replace each integer of an array by its sum over the ranks. Collective.
   subroutine communicator_total(self, values)
      class(communicator_t), intent(in) :: self
      integer(int64), contiguous, intent(inout) :: values(:) !! Terms in, sums out
      integer(int64), allocatable :: sums(:)

      if (self%size == 1) return
      call count_call(self, size(values))
      allocate (sums, mold=values)
      call mpi_allreduce(values, sums, size(values), mpi_integer8, mpi_sum, self%handle)
      values = sums
   end subroutine communicator_total

   !> Sum of one integer over the ranks below this one; 0 on rank 0. Collective.
   function communicator_before(self, value) result(lower)
      class(communicator_t), intent(in) :: self
      integer(int64), intent(in) :: value             !! Term of this rank
      integer(int64) :: lower

      lower = 0
      if (self%size == 1) return
      call count_call(self, 1)
      call mpi_exscan(value, lower, 1, mpi_integer8, mpi_sum, self%handle)
      if (self%rank == 0) lower = 0
   end function communicator_before

   !> Concatenate arrays in the order of the ranks; every rank gets the whole.
   subroutine communicator_gather(self, values, whole)
      class(communicator_t), intent(in) :: self
      integer(int64), contiguous, intent(in) :: values(:)      !! Part of this rank
      integer(int64), allocatable, intent(out) :: whole(:)     !! All parts
      integer, allocatable :: counts(:), offsets(:)
      integer(int64), allocatable :: lengths(:)
      integer :: rank

      if (self%size == 1) then
         whole = values
         return
      end if
      allocate (lengths(self%size), offsets(self%size), counts(self%size))
      call mpi_allgather(size(values, kind=int64), 1, mpi_integer8, lengths, 1, mpi_integer8, &
         self%handle)
      counts(:) = int(lengths)
      offsets(1) = 0
      do rank = 2, self%size
         offsets(rank) = offsets(rank - 1) + counts(rank - 1)
      end do
      allocate (whole(sum(lengths)))
      call mpi_allgatherv(values, size(values), mpi_integer8, whole, counts, offsets, &
         mpi_integer8, self%handle)
      call count_call(self, size(lengths))
      call count_call(self, size(whole))
   end subroutine communicator_gather

   !> Give the text of rank 0 to all ranks.
   subroutine communicator_broadcast(self, text)
      class(communicator_t), intent(in) :: self
      character(len=:), allocatable, intent(inout) :: text !! In on rank 0, out on the others
      integer(int64) :: length(1)

      if (self%size == 1) return
      length = 0
      if (self%rank == 0) length = len(text)
      call self%total(length)
      if (self%rank /= 0) then
         if (allocated(text)) deallocate (text)
         allocate (character(len=length(1)) :: text)
      end if
      call count_call(self, (len(text) + 7)/8)
      call mpi_bcast(text, int(length(1)), mpi_character, 0, self%handle)
   end subroutine communicator_broadcast

   !> Send messages to ranks that do not expect them, and receive those to this rank. Incoming
   !! messages are concatenated in the order of arrival, which varies: the caller must sort them.
   subroutine communicator_exchange(self, destination, length, outgoing, incoming)
      class(communicator_t), intent(inout) :: self
      integer, contiguous, intent(in) :: destination(:)        !! Rank of each message
      integer, contiguous, intent(in) :: length(:)             !! Words of each message
      integer(int64), contiguous, intent(in) :: outgoing(:)    !! Messages, one after the other
      integer(int64), allocatable, intent(out) :: incoming(:)  !! Messages to this rank
      type(posted_t) :: posted
      integer :: words

      posted%outgoing = outgoing
      call self%post(destination, length, posted)
      call self%complete(posted, incoming, words)
      incoming = incoming(:words)
   end subroutine communicator_exchange

   !> Send each row of words to a rank, which may be this one. Rows of one sender arrive in their
   !! order; the order of the senders varies. The work depends on the rows only, not on the number
   !! of ranks.
   subroutine communicator_send_rows(self, owner, rows, arrived)
      class(communicator_t), intent(inout) :: self
      integer, contiguous, intent(in) :: owner(:)              !! (row) Receiving rank
      integer(int64), contiguous, intent(in) :: rows(:, :)     !! (word, row)
      integer(int64), allocatable, intent(out) :: arrived(:)   !! Words of the rows for this rank
      integer(int64), allocatable :: incoming(:)
      type(posted_t) :: posted
      integer :: words

      call self%post_rows(owner, rows, posted, arrived)
      if (self%size == 1) return
      call self%complete(posted, incoming, words)
      arrived = [arrived, incoming(:words)]
   end subroutine communicator_send_rows

   !> First half of `send_rows`.
   subroutine communicator_post_rows(self, owner, rows, posted, kept)
      class(communicator_t), intent(inout) :: self
      integer, contiguous, intent(in) :: owner(:)              !! (row) Receiving rank
      integer(int64), contiguous, intent(in) :: rows(:, :)     !! (word, row)
      type(posted_t), intent(inout) :: posted         !! Gets the messages
      integer(int64), allocatable, intent(out) :: kept(:)      !! Words of the rows of this rank
      integer, allocatable :: order(:), destination(:), length(:)
      integer :: row, rank, words, filled, sent, messages

      words = size(rows, 1)
      filled = count(owner == self%rank)
      allocate (kept(words*filled), destination(size(owner) - filled), length(size(owner) - filled))
      if (allocated(posted%outgoing)) deallocate (posted%outgoing)
      allocate (posted%outgoing(words*size(destination)))
      order = sort_order(int(owner, int64))
      filled = 0
      sent = 0
      messages = 0
      do row = 1, size(owner)
         rank = owner(order(row))
         if (rank == self%rank) then
            kept(filled + 1:filled + words) = rows(:, order(row))
            filled = filled + words
            cycle
         end if
         posted%outgoing(sent + 1:sent + words) = rows(:, order(row))
         sent = sent + words
         if (messages > 0) then
            if (destination(messages) == rank) then
               length(messages) = length(messages) + words
               cycle
            end if
         end if
         messages = messages + 1
         destination(messages) = rank
         length(messages) = words
      end do
      if (self%size > 1) call self%post(destination(:messages), length(:messages), posted)
   end subroutine communicator_post_rows

   !> Send messages. No other exchange may start before `complete` or `receive`; other work may be
   !! done.
   !!
   !! Each exchange has its own tag. A rank that receives from known senders does not wait for the
   !! others, so a sender may be some exchanges ahead of it.
   subroutine communicator_post(self, destination, length, posted, known)
      class(communicator_t), intent(inout) :: self
      integer, contiguous, intent(in) :: destination(:)        !! Rank of each message
      integer, contiguous, intent(in) :: length(:)             !! Words of each message
      type(posted_t), intent(inout) :: posted         !! Words in, requests of the messages out
      logical, intent(in), optional :: known !! Do the receivers expect the messages? Then `receive`
      integer :: message, first
      logical :: expected

      expected = .false.
      if (present(known)) expected = known
      self%called(3) = self%called(3) + 1
      posted%tag = first_tag + int(mod(self%called(3), int(tags, int64)))
      if (allocated(posted%sent)) deallocate (posted%sent, posted%source)
      allocate (posted%sent(size(destination)), posted%source(0))
      first = 1
      do message = 1, size(destination)
         if (expected) then
            call mpi_isend(posted%outgoing(first:), length(message), mpi_integer8, &
               destination(message), posted%tag, self%handle, posted%sent(message))
         else
            call mpi_issend(posted%outgoing(first:), length(message), mpi_integer8, &
               destination(message), posted%tag, self%handle, posted%sent(message))
         end if
         first = first + length(message)
      end do
      self%traffic%messages = self%traffic%messages + size(destination)
      self%traffic%words = self%traffic%words + first - 1
   end subroutine communicator_post

   !> Receive the messages to this rank from any sender. With `values` the end of the exchange
   !! is a reduction of these numbers, at no further cost. Collective.
   !!
   !! Non-blocking consensus: T. Hoefler, C. Siebert, A. Lumsdaine, "Scalable communication
   !! protocols for dynamic sparse data exchange", PPoPP 2010. A synchronous message is delivered
   !! once it is received; a rank enters a non-blocking barrier when all its messages are delivered,
   !! so the end of the barrier means that all messages of all ranks are delivered. The maxima over
   !! the ranks need the numbers of all of them, so they are known no earlier than that either.
   subroutine communicator_complete(self, posted, incoming, words, values)
      class(communicator_t), intent(inout) :: self
      type(posted_t), intent(inout) :: posted         !! From `post`; gets the senders
      integer(int64), allocatable, intent(inout) :: incoming(:) !! Grows as needed
      integer, intent(out) :: words                   !! Number of received words
      real(wp), contiguous, intent(inout), optional :: values(:) !! Of this rank in, maxima out
      type(mpi_request) :: consensus
      real(wp), allocatable :: greatest(:)
      integer(int64) :: begin
      logical :: done, agreeing

      call system_clock(begin)
      if (.not. allocated(incoming)) allocate (incoming(0))
      words = 0
      agreeing = .false.
      do
         call receive_one(self%handle, posted, incoming, words)
         if (agreeing) then
            call mpi_test(consensus, done, mpi_status_ignore)
            if (done) exit
         else
            call mpi_testall(size(posted%sent), posted%sent, done, mpi_statuses_ignore)
            if (done) then
               if (present(values)) then
                  allocate (greatest, mold=values)
                  call mpi_iallreduce(values, greatest, size(values), mpi_double_precision, &
                     mpi_max, self%handle, consensus)
               else
                  call mpi_ibarrier(self%handle, consensus)
               end if
               agreeing = .true.
            end if
         end if
      end do
      if (present(values)) then
         call count_call(self, size(values))
         values = greatest
      else
         call count_call(self, 0)
      end if
      call add_wait(self%traffic, begin)
   end subroutine communicator_complete

   !> Receive one message of each known sender. Not collective: no rank waits for others than its
   !! senders.
   subroutine communicator_receive(self, posted, senders, incoming, words)
      class(communicator_t), intent(inout) :: self
      type(posted_t), intent(inout) :: posted         !! From `post` with `known`; gets the senders
      integer, intent(in) :: senders                  !! Ranks that send a message to this one
      integer(int64), allocatable, intent(inout) :: incoming(:) !! Grows as needed
      integer, intent(out) :: words                   !! Number of received words
      integer(int64) :: begin
      type(mpi_status) :: status

      call system_clock(begin)
      if (.not. allocated(incoming)) allocate (incoming(0))
      words = 0
      do while (size(posted%source) < senders)
         call mpi_probe(mpi_any_source, posted%tag, self%handle, status)
         call take_message(self%handle, status, posted, incoming, words)
      end do
      call mpi_waitall(size(posted%sent), posted%sent, mpi_statuses_ignore)
      call add_wait(self%traffic, begin)
   end subroutine communicator_receive

   !> Receive one message if one is waiting, and append it.
   subroutine receive_one(handle, posted, buffer, filled)
      type(mpi_comm), intent(in) :: handle
      type(posted_t), intent(inout) :: posted         !! The exchange, gets the sender
      integer(int64), allocatable, intent(inout) :: buffer(:) !! Grows as needed
      integer, intent(inout) :: filled                !! Words in use
      type(mpi_status) :: status
      logical :: waiting

      call mpi_iprobe(mpi_any_source, posted%tag, handle, waiting, status)
      if (waiting) call take_message(handle, status, posted, buffer, filled)
   end subroutine receive_one

   !> Receive a message that is waiting, and append it.
   subroutine take_message(handle, status, posted, buffer, filled)
      type(mpi_comm), intent(in) :: handle
      type(mpi_status), intent(in) :: status          !! From a probe
      type(posted_t), intent(inout) :: posted         !! The exchange, gets the sender
      integer(int64), allocatable, intent(inout) :: buffer(:) !! Grows as needed
      integer, intent(inout) :: filled                !! Words in use
      integer(int64), allocatable :: larger(:)
      integer :: words

      call mpi_get_count(status, mpi_integer8, words)
      if (filled + words > size(buffer)) then
         allocate (larger(2*(filled + words)))
         larger(:filled) = buffer(:filled)
         call move_alloc(larger, buffer)
      end if
      call mpi_recv(buffer(filled + 1:), words, mpi_integer8, status%mpi_source, posted%tag, &
         handle, mpi_status_ignore)
      filled = filled + words
      posted%source = [posted%source, status%mpi_source]
   end subroutine take_message

   !> Name and version of the message passing library. May be called before `start`.
   function message_passing_version() result(text)
      character(len=:), allocatable :: text
      character(len=mpi_max_library_version_string) :: line
      integer :: length, stop_at

      call mpi_get_library_version(line, length)
      stop_at = scan(line(:length)//",", ","//new_line("a")//achar(0))
      text = line(:stop_at - 1)
   end function message_passing_version
end module base_communicator
