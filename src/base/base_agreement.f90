! SPDX-License-Identifier: BSD-3-Clause
!> Makes an error of one rank the error of all, so that all ranks stop together and no rank waits
!! forever.
module base_agreement
   use base_communicator, only: communicator_t
   use base_error, only: error_t, fail
   use base_kinds, only: int64
   implicit none
   private

   public :: agree

contains

   !> Distribute the error of the lowest rank that has one. The message names this rank unless all
   !! ranks failed. Collective.
   subroutine agree(communicator, error)
      type(communicator_t), intent(in) :: communicator
      type(error_t), allocatable, intent(inout) :: error     !! Own error in, common error out
      integer(int64), allocatable :: letters(:), whole(:)
      integer(int64) :: least(2), code(1)
      character(len=:), allocatable :: message
      character(len=12) :: label
      integer :: letter

      if (communicator%size == 1) return
      ! the lowest rank with an error, and 1 if all ranks have one
      least = [communicator%size, 0]
      if (allocated(error)) least = [communicator%rank, 1]
      call communicator%least(least)
      if (least(1) == communicator%size) return
      message = ""
      code = 0
      if (communicator%rank == least(1)) then
         message = error%message
         code = error%code
      end if
      call communicator%total(code)
      allocate (letters(len(message)))
      do letter = 1, len(message)
         letters(letter) = iachar(message(letter:letter))
      end do
      call communicator%gather(letters, whole)
      deallocate (message)
      allocate (character(len=size(whole)) :: message)
      do letter = 1, size(whole)
         message(letter:letter) = achar(int(whole(letter)))
      end do
      write (label, "(i0)") least(1)
      if (least(2) == 0) message = "rank "//trim(label)//": "//message
      if (allocated(error)) deallocate (error)
      call fail(error, int(code(1)), message)
   end subroutine agree
end module base_agreement
