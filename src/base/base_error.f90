! SPDX-License-Identifier: BSD-3-Clause
!> Errors are values: a procedure that can fail returns one, and only the program prints and stops.
module base_error
   implicit none
   private

   public :: error_t, fail

   !> The exit codes of the program, a part of its interface.
   integer, parameter, public :: exit_success = 0      !! Finished
   integer, parameter, public :: exit_input = 2        !! Error in the deck or command line
   integer, parameter, public :: exit_file = 3         !! Missing, unreadable, disk full, HDF5
   !> NaN, time step too small, particle outside the grid
   integer, parameter, public :: exit_physics = 4
   integer, parameter, public :: exit_internal = 5     !! A defect of the program
   integer, parameter, public :: exit_again = 75       !! Stopped with a checkpoint: run again

   !> An error. Not allocated: no error.
   type :: error_t
      integer :: code = exit_internal                  !! Exit code of the program
      character(len=:), allocatable :: message         !! One or more lines for the user
   end type error_t

contains

   !> Make an error.
   pure subroutine fail(error, code, message)
      type(error_t), allocatable, intent(out) :: error !! Allocated on return
      integer, intent(in) :: code                      !! One of the exit codes above
      character(len=*), intent(in) :: message          !! Error and its remedy

      allocate (error)
      error%code = code
      error%message = message
   end subroutine fail
end module base_error
