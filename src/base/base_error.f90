! SPDX-License-Identifier: BSD-3-Clause
!> Errors are values: a procedure that can fail returns one, and only the driver prints and stops.
module base_error
   implicit none
   private

   public :: error_t, fail

   !> The exit codes of the program, a part of its interface.
   integer, parameter, public :: exit_success = 0      !! Finished
   integer, parameter, public :: exit_input = 2        !! Deck or command line wrong
   integer, parameter, public :: exit_file = 3         !! Missing, unreadable, disk full, HDF5
   integer, parameter, public :: exit_physics = 4      !! NaN, step too small, left closed domain
   integer, parameter, public :: exit_internal = 5     !! A defect of the program
   integer, parameter, public :: exit_again = 75       !! Stopped on purpose, checkpoint written

   !> What went wrong. Not allocated means that all is well.
   type :: error_t
      integer :: code = exit_internal                  !! Exit code that this error leads to
      character(len=:), allocatable :: message         !! One or more lines for the user
   end type error_t

contains

   !> Make an error.
   pure subroutine fail(error, code, message)
      type(error_t), allocatable, intent(out) :: error !! Allocated on return
      integer, intent(in) :: code                      !! One of the exit codes above
      character(len=*), intent(in) :: message          !! What is wrong and what to do instead

      allocate (error)
      error%code = code
      error%message = message
   end subroutine fail
end module base_error
