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
      integer(int64), allocatable :: codes(:), letters(:), whole(:)
      integer(int64) :: own(1)
      character(len=:), allocatable :: message
      character(len=12) :: label
      integer :: letter, speaker

      if (communicator%size == 1) return
      own = -1
      if (allocated(error)) own = error%code
      call communicator%gather(own, codes)
      if (all(codes < 0)) return
      speaker = 0
      do while (codes(speaker + 1) < 0)
         speaker = speaker + 1
      end do
      message = ""
      if (communicator%rank == speaker) message = error%message
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
      write (label, "(i0)") speaker
      if (any(codes < 0)) message = "rank "//trim(label)//": "//message
      if (allocated(error)) deallocate (error)
      call fail(error, int(codes(speaker + 1)), message)
   end subroutine agree
end module base_agreement
