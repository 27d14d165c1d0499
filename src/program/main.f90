! SPDX-License-Identifier: BSD-3-Clause
!> Scree, dual domain material points for solids that break, fragment and flow.
program scree
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use program_main, only: run_program
   implicit none

   interface
      !> exit(3) of the C library: `stop` with a code prints additional text.
      subroutine c_exit(code) bind(c, name="exit")
         import :: c_int
         implicit none
         integer(c_int), value, intent(in) :: code
      end subroutine c_exit
   end interface

   integer(c_int) :: code

   call run_program(code)
   flush (output_unit)
   flush (error_unit)
   call c_exit(code)
end program scree
