! SPDX-License-Identifier: BSD-3-Clause
!> Runs tests on several ranks.
module pfunit_runner
   use funit_report, only: anyexceptions, begin_test, failures_of_test, set_rank_text, throw
   use funit_runner, only: quit, summary_t
   use, intrinsic :: iso_c_binding, only: c_int
   use mpi_f08, only: mpi_allreduce, mpi_barrier, mpi_comm, mpi_comm_free, mpi_comm_rank, &
      mpi_comm_size, mpi_comm_split, mpi_comm_world, mpi_finalize, mpi_init_thread, mpi_integer, &
      mpi_sum, mpi_thread_funneled, mpi_undefined
   use pfunit_method, only: mpitestmethod
   implicit none
   private

   public :: finish_ranks, run_on_ranks, run_on_root, start_ranks

   abstract interface
      subroutine method_i()
         implicit none
      end subroutine method_i

      subroutine ranks_method_i(this)
         import :: mpitestmethod
         implicit none
         class(mpitestmethod), intent(inout) :: this
      end subroutine ranks_method_i
   end interface

contains

   !> Start all ranks.
   subroutine start_ranks()
      integer :: provided

      call mpi_init_thread(mpi_thread_funneled, provided)
   end subroutine start_ranks

   !> Run one test on the first few ranks while the others wait.
   subroutine run_on_ranks(summary, name, method, ranks, before, after)
      type(summary_t), intent(inout) :: summary       !! What has run so far
      character(len=*), intent(in) :: name            !! Name of the test
      procedure(ranks_method_i) :: method             !! The test
      integer, intent(in) :: ranks                    !! Number of ranks
      procedure(ranks_method_i), optional :: before   !! Runs before it
      procedure(ranks_method_i), optional :: after    !! Runs after it
      type(mpitestmethod) :: this
      type(mpi_comm) :: group
      character(len=40) :: text
      integer :: rank, available, colour, members

      call begin_test(name)
      call mpi_comm_rank(mpi_comm_world, rank)
      call mpi_comm_size(mpi_comm_world, available)
      colour = merge(1, mpi_undefined, rank < ranks)
      call mpi_comm_split(mpi_comm_world, colour, rank, group)
      if (available < ranks) then
         if (rank == 0) call throw("not enough ranks were started")
      else if (rank < ranks) then
         write (text, "(a, i0, a, i0, a)") " (rank ", rank, " of ", ranks, ")"
         call set_rank_text(text)
         call mpi_comm_size(group, members)
         this = mpitestmethod(communicator=group%mpi_val, rank=rank, ranks=members)
         if (present(before)) call before(this)
         if (.not. anyexceptions()) then
            call method(this)
            if (present(after)) call after(this)
         end if
         call set_rank_text("")
      end if
      if (rank < ranks) call mpi_comm_free(group)
      write (text, "(a, i0, a)") " [", ranks, " ranks]"
      call book(summary, name//trim(text))
   end subroutine run_on_ranks

   !> Run a test without a number of ranks on the first rank while the others wait.
   subroutine run_on_root(summary, name, method)
      type(summary_t), intent(inout) :: summary       !! What has run so far
      character(len=*), intent(in) :: name            !! Name of the test
      procedure(method_i) :: method                   !! The test
      integer :: rank

      call begin_test(name)
      call mpi_comm_rank(mpi_comm_world, rank)
      if (rank == 0) call method()
      call book(summary, name)
   end subroutine run_on_root

   !> Find out from all ranks whether the test failed, and record it on all of them.
   subroutine book(summary, name)
      type(summary_t), intent(inout) :: summary
      character(len=*), intent(in) :: name
      integer :: here, everywhere, rank

      here = failures_of_test()
      call mpi_allreduce(here, everywhere, 1, mpi_integer, mpi_sum, mpi_comm_world)
      call mpi_comm_rank(mpi_comm_world, rank)
      if (rank == 0) then
         call summary%add(name, everywhere > 0)
      else
         summary%tests = summary%tests + 1
         if (everywhere > 0) summary%failed = summary%failed + 1
      end if
      call mpi_barrier(mpi_comm_world)
   end subroutine book

   !> Print the totals and end with exit code 1 if a test failed or none ran.
   subroutine finish_ranks(summary)
      type(summary_t), intent(in) :: summary          !! What has run
      integer :: rank

      call mpi_comm_rank(mpi_comm_world, rank)
      call mpi_finalize()
      if (rank > 0) return
      call summary%print()
      if (summary%failed > 0 .or. summary%tests == 0) call quit(1_c_int)
   end subroutine finish_ranks
end module pfunit_runner
