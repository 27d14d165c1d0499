! SPDX-License-Identifier: BSD-3-Clause
!> The part of MPI that Scree uses, for a single rank: what a build without MPI compiles in place of
!! the library. Names and arguments are those of the standard (MPI: A Message-Passing Interface
!! Standard, version 3.1), so that the modules which use MPI are the same in both builds, and a call
!! that is missing here does not compile. A rank alone has no other rank to send to: `mpi_isend`,
!! `mpi_issend`, `mpi_probe` and `mpi_recv` are never called.
module mpi_f08
   use, intrinsic :: iso_fortran_env, only: int64, real64
   implicit none
   private

   public :: mpi_abort, mpi_allgather, mpi_allgatherv, mpi_allreduce, mpi_barrier, mpi_bcast, &
      mpi_comm_dup, mpi_comm_free, mpi_comm_rank, mpi_comm_set_errhandler, mpi_comm_size, &
      mpi_comm_split, mpi_exscan, mpi_finalize, mpi_finalized, mpi_get_count, &
      mpi_get_library_version, mpi_iallreduce, mpi_ibarrier, mpi_init_thread, mpi_initialized, &
      mpi_iprobe, mpi_isend, mpi_issend, mpi_probe, mpi_recv, mpi_test, mpi_testall, mpi_wait, &
      mpi_waitall

   !> A group of ranks.
   type, public :: mpi_comm
      integer :: mpi_val = 0                          !! Fortran handle
   end type mpi_comm

   !> Type of the words of a message.
   type, public :: mpi_datatype
      integer :: mpi_val = 0                          !! Fortran handle
   end type mpi_datatype

   !> What happens after a failure.
   type, public :: mpi_errhandler
      integer :: mpi_val = 0                          !! Fortran handle
   end type mpi_errhandler

   !> Hints to the library.
   type, public :: mpi_info
      integer :: mpi_val = 0                          !! Fortran handle
   end type mpi_info

   !> An operation of a reduction.
   type, public :: mpi_op
      integer :: mpi_val = 0                          !! Fortran handle
   end type mpi_op

   !> A message in transit.
   type, public :: mpi_request
      integer :: mpi_val = 0                          !! Fortran handle
   end type mpi_request

   !> Where a message came from.
   type, public :: mpi_status
      integer :: mpi_source = 0                       !! Rank
      integer :: mpi_tag = 0                          !! Tag
      integer :: mpi_error = 0                        !! Code
   end type mpi_status

   integer, parameter, public :: mpi_any_source = -1, mpi_max_library_version_string = 64, &
      mpi_thread_funneled = 1, mpi_undefined = -32766
   type(mpi_comm), parameter, public :: mpi_comm_world = mpi_comm(0)
   type(mpi_datatype), parameter, public :: mpi_character = mpi_datatype(1), &
      mpi_double_precision = mpi_datatype(2), mpi_integer = mpi_datatype(3), &
      mpi_integer8 = mpi_datatype(4)
   type(mpi_errhandler), parameter, public :: mpi_errors_are_fatal = mpi_errhandler(1)
   type(mpi_info), parameter, public :: mpi_info_null = mpi_info(0)
   type(mpi_op), parameter, public :: mpi_max = mpi_op(1), mpi_min = mpi_op(2), mpi_sum = mpi_op(3)
   type(mpi_status), parameter, public :: mpi_status_ignore = mpi_status(), &
      mpi_statuses_ignore(1) = mpi_status()

   !> Reduction over the ranks: of one rank, a copy.
   interface mpi_allreduce
      module procedure reduce_integer, reduce_real, reduce_long, reduce_longs, reduce_reals
   end interface mpi_allreduce

   logical :: has_started = .false.                   !! Was mpi_init_thread called?
   logical :: has_ended = .false.                     !! Was mpi_finalize called?

contains

   !> Start.
   subroutine mpi_init_thread(required, provided)
      integer, intent(in) :: required                 !! Use of threads
      integer, intent(out) :: provided                !! Use that is allowed: as required

      provided = required
      has_started = .true.
   end subroutine mpi_init_thread

   !> Was it started?
   subroutine mpi_initialized(flag)
      logical, intent(out) :: flag

      flag = has_started
   end subroutine mpi_initialized

   !> Finish.
   subroutine mpi_finalize()
      has_ended = .true.
   end subroutine mpi_finalize

   !> Was it finished?
   subroutine mpi_finalized(flag)
      logical, intent(out) :: flag

      flag = has_ended
   end subroutine mpi_finalized

   !> Name in place of that of a library.
   subroutine mpi_get_library_version(version, length)
      character(len=*), intent(out) :: version        !! Text
      integer, intent(out) :: length                  !! Its length

      version = "without MPI"
      length = len_trim(version)
   end subroutine mpi_get_library_version

   !> The rank: 0.
   subroutine mpi_comm_rank(comm, rank)
      type(mpi_comm), intent(in) :: comm
      integer, intent(out) :: rank

      rank = 0
   end subroutine mpi_comm_rank

   !> The number of ranks: 1.
   subroutine mpi_comm_size(comm, size)
      type(mpi_comm), intent(in) :: comm
      integer, intent(out) :: size

      size = 1
   end subroutine mpi_comm_size

   !> A copy of a group.
   subroutine mpi_comm_dup(comm, newcomm)
      type(mpi_comm), intent(in) :: comm
      type(mpi_comm), intent(out) :: newcomm

      newcomm = comm
   end subroutine mpi_comm_dup

   !> Parts of a group: the rank itself.
   subroutine mpi_comm_split(comm, color, key, newcomm)
      type(mpi_comm), intent(in) :: comm
      integer, intent(in) :: color                    !! Part of this rank
      integer, intent(in) :: key                      !! Order in the part
      type(mpi_comm), intent(out) :: newcomm

      newcomm = comm
   end subroutine mpi_comm_split

   !> Free a group: nothing is held.
   subroutine mpi_comm_free(comm)
      type(mpi_comm), intent(inout) :: comm

      comm = mpi_comm_world
   end subroutine mpi_comm_free

   !> Set what happens after a failure: none can occur.
   subroutine mpi_comm_set_errhandler(comm, errhandler)
      type(mpi_comm), intent(in) :: comm
      type(mpi_errhandler), intent(in) :: errhandler
   end subroutine mpi_comm_set_errhandler

   !> End the program. Never called with one rank.
   subroutine mpi_abort(comm, errorcode)
      type(mpi_comm), intent(in) :: comm
      integer, intent(in) :: errorcode

      error stop
   end subroutine mpi_abort

   !> Wait until a request is complete: it is.
   subroutine mpi_wait(request, status)
      type(mpi_request), intent(inout) :: request
      type(mpi_status), intent(in) :: status          !! mpi_status_ignore
   end subroutine mpi_wait

   !> Wait for the other ranks: there are none.
   subroutine mpi_barrier(comm)
      type(mpi_comm), intent(in) :: comm
   end subroutine mpi_barrier

   !> Begin to wait for the other ranks: there are none.
   subroutine mpi_ibarrier(comm, request)
      type(mpi_comm), intent(in) :: comm
      type(mpi_request), intent(out) :: request

      request = mpi_request()
   end subroutine mpi_ibarrier

   !> Begin a reduction: of one rank, a copy.
   subroutine mpi_iallreduce(sendbuf, recvbuf, count, datatype, op, comm, request)
      real(real64), intent(in) :: sendbuf(:)
      real(real64), intent(inout) :: recvbuf(:)
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      type(mpi_op), intent(in) :: op
      type(mpi_comm), intent(in) :: comm
      type(mpi_request), intent(out) :: request

      recvbuf(:count) = sendbuf(:count)
      request = mpi_request()
   end subroutine mpi_iallreduce

   !> Is a request complete? Always.
   subroutine mpi_test(request, flag, status)
      type(mpi_request), intent(inout) :: request
      logical, intent(out) :: flag
      type(mpi_status), intent(in) :: status          !! mpi_status_ignore

      flag = .true.
   end subroutine mpi_test

   !> Are all requests complete? Always.
   subroutine mpi_testall(count, array_of_requests, flag, array_of_statuses)
      integer, intent(in) :: count
      type(mpi_request), intent(inout) :: array_of_requests(count)
      logical, intent(out) :: flag
      type(mpi_status), intent(in) :: array_of_statuses(:) !! mpi_statuses_ignore

      flag = .true.
   end subroutine mpi_testall

   !> Wait until all requests are complete: they are.
   subroutine mpi_waitall(count, array_of_requests, array_of_statuses)
      integer, intent(in) :: count
      type(mpi_request), intent(inout) :: array_of_requests(count)
      type(mpi_status), intent(in) :: array_of_statuses(:) !! mpi_statuses_ignore
   end subroutine mpi_waitall

   !> Is a message waiting? Never.
   subroutine mpi_iprobe(source, tag, comm, flag, status)
      integer, intent(in) :: source
      integer, intent(in) :: tag
      type(mpi_comm), intent(in) :: comm
      logical, intent(out) :: flag
      type(mpi_status), intent(out) :: status

      flag = .false.
      status = mpi_status()
   end subroutine mpi_iprobe

   !> Wait for a message: never called.
   subroutine mpi_probe(source, tag, comm, status)
      integer, intent(in) :: source
      integer, intent(in) :: tag
      type(mpi_comm), intent(in) :: comm
      type(mpi_status), intent(out) :: status

      status = mpi_status()
   end subroutine mpi_probe

   !> Words of a message: none was received.
   subroutine mpi_get_count(status, datatype, count)
      type(mpi_status), intent(in) :: status
      type(mpi_datatype), intent(in) :: datatype
      integer, intent(out) :: count

      count = 0
   end subroutine mpi_get_count

   !> Send to another rank: never called.
   subroutine mpi_isend(buf, count, datatype, dest, tag, comm, request)
      integer(int64), intent(in) :: buf(*)
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      integer, intent(in) :: dest
      integer, intent(in) :: tag
      type(mpi_comm), intent(in) :: comm
      type(mpi_request), intent(out) :: request

      request = mpi_request()
   end subroutine mpi_isend

   !> Send to another rank, until it receives: never called.
   subroutine mpi_issend(buf, count, datatype, dest, tag, comm, request)
      integer(int64), intent(in) :: buf(*)
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      integer, intent(in) :: dest
      integer, intent(in) :: tag
      type(mpi_comm), intent(in) :: comm
      type(mpi_request), intent(out) :: request

      request = mpi_request()
   end subroutine mpi_issend

   !> Receive from another rank: never called.
   subroutine mpi_recv(buf, count, datatype, source, tag, comm, status)
      integer(int64), intent(inout) :: buf(*)
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      integer, intent(in) :: source
      integer, intent(in) :: tag
      type(mpi_comm), intent(in) :: comm
      type(mpi_status), intent(in) :: status          !! mpi_status_ignore
   end subroutine mpi_recv

   !> Give a text to all ranks: they have it.
   subroutine mpi_bcast(buffer, count, datatype, root, comm)
      character(len=*), intent(inout) :: buffer
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      integer, intent(in) :: root
      type(mpi_comm), intent(in) :: comm
   end subroutine mpi_bcast

   !> Sum over the lower ranks, undefined on rank 0 as in the standard.
   subroutine mpi_exscan(sendbuf, recvbuf, count, datatype, op, comm)
      integer(int64), intent(in) :: sendbuf
      integer(int64), intent(inout) :: recvbuf
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      type(mpi_op), intent(in) :: op
      type(mpi_comm), intent(in) :: comm
   end subroutine mpi_exscan

   !> One integer of each rank.
   subroutine mpi_allgather(sendbuf, sendcount, sendtype, recvbuf, recvcount, recvtype, comm)
      integer(int64), intent(in) :: sendbuf
      integer, intent(in) :: sendcount
      type(mpi_datatype), intent(in) :: sendtype
      integer(int64), intent(inout) :: recvbuf(:)
      integer, intent(in) :: recvcount
      type(mpi_datatype), intent(in) :: recvtype
      type(mpi_comm), intent(in) :: comm

      recvbuf(1) = sendbuf
   end subroutine mpi_allgather

   !> Integers of each rank, one after the other.
   subroutine mpi_allgatherv(sendbuf, sendcount, sendtype, recvbuf, recvcounts, displs, recvtype, &
      comm)
      integer(int64), intent(in) :: sendbuf(:)
      integer, intent(in) :: sendcount
      type(mpi_datatype), intent(in) :: sendtype
      integer(int64), intent(inout) :: recvbuf(:)
      integer, intent(in) :: recvcounts(:)
      integer, intent(in) :: displs(:)
      type(mpi_datatype), intent(in) :: recvtype
      type(mpi_comm), intent(in) :: comm

      recvbuf(:sendcount) = sendbuf(:sendcount)
   end subroutine mpi_allgatherv

   !> Reduction of an integer.
   subroutine reduce_integer(sendbuf, recvbuf, count, datatype, op, comm)
      integer, intent(in) :: sendbuf
      integer, intent(inout) :: recvbuf
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      type(mpi_op), intent(in) :: op
      type(mpi_comm), intent(in) :: comm

      recvbuf = sendbuf
   end subroutine reduce_integer

   !> Reduction of a real.
   subroutine reduce_real(sendbuf, recvbuf, count, datatype, op, comm)
      real(real64), intent(in) :: sendbuf
      real(real64), intent(inout) :: recvbuf
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      type(mpi_op), intent(in) :: op
      type(mpi_comm), intent(in) :: comm

      recvbuf = sendbuf
   end subroutine reduce_real

   !> Reduction of a long integer.
   subroutine reduce_long(sendbuf, recvbuf, count, datatype, op, comm)
      integer(int64), intent(in) :: sendbuf
      integer(int64), intent(inout) :: recvbuf
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      type(mpi_op), intent(in) :: op
      type(mpi_comm), intent(in) :: comm

      recvbuf = sendbuf
   end subroutine reduce_long

   !> Reduction of long integers, element by element.
   subroutine reduce_longs(sendbuf, recvbuf, count, datatype, op, comm)
      integer(int64), intent(in) :: sendbuf(:)
      integer(int64), intent(inout) :: recvbuf(:)
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      type(mpi_op), intent(in) :: op
      type(mpi_comm), intent(in) :: comm

      recvbuf(:count) = sendbuf(:count)
   end subroutine reduce_longs

   !> Reduction of reals, element by element.
   subroutine reduce_reals(sendbuf, recvbuf, count, datatype, op, comm)
      real(real64), intent(in) :: sendbuf(:)
      real(real64), intent(inout) :: recvbuf(:)
      integer, intent(in) :: count
      type(mpi_datatype), intent(in) :: datatype
      type(mpi_op), intent(in) :: op
      type(mpi_comm), intent(in) :: comm

      recvbuf(:count) = sendbuf(:count)
   end subroutine reduce_reals
end module mpi_f08
