! SPDX-License-Identifier: BSD-3-Clause
!> The argument of a test on several ranks.
module pfunit_method
   implicit none
   private

   !> The ranks of a test.
   type, public :: mpitestmethod
      integer :: communicator = 0                     !! Fortran handle of the group
      integer :: rank = 0                             !! This rank, from 0
      integer :: ranks = 1                            !! Their number
   contains
      procedure :: getprocessrank                     !! This rank, from 0
      procedure :: getnumprocesses                    !! Their number
      procedure :: getmpicommunicator                 !! Fortran handle of the group
   end type mpitestmethod

contains

   !> This rank, from 0.
   function getprocessrank(this) result(rank)
      class(mpitestmethod), intent(in) :: this        !! The ranks
      integer :: rank

      rank = this%rank
   end function getprocessrank

   !> Number of ranks.
   function getnumprocesses(this) result(number)
      class(mpitestmethod), intent(in) :: this        !! The ranks
      integer :: number

      number = this%ranks
   end function getnumprocesses

   !> Fortran handle of the group.
   function getmpicommunicator(this) result(handle)
      class(mpitestmethod), intent(in) :: this        !! The ranks
      integer :: handle

      handle = this%communicator
   end function getmpicommunicator
end module pfunit_method
