! SPDX-License-Identifier: BSD-3-Clause
!> A strength law in a shared library: the interface of scree_law.h for Fortran.
!!
!!     gfortran -O2 -ffp-contract=off -fPIC -shared scree_law.f90 my_law.f90 -o my_law.so
!!
!! The library has the procedures scree_law_interface, scree_law_declaration and scree_law_update,
!! each with bind(c), see voce.f90. They are called from several threads at once: no variable of a
!! module and none with `save` may be written.
module scree_law
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_f_procpointer, &
      c_funptr, c_int32_t, c_int64_t, c_ptr
   implicit none
   private

   public :: scree_column, scree_exponentials, scree_fast_powers, scree_history, scree_logarithms, &
      scree_powers, scree_rows_t, scree_tools_t

   integer(c_int32_t), parameter, public :: scree_law_version = 1_c_int32_t

   !> Particles of one call; scree_law.h explains the components.
   type, bind(c) :: scree_rows_t
      integer(c_int64_t) :: count
      real(c_double) :: dt
      real(c_double) :: shear
      real(c_double) :: bulk
      real(c_double) :: density
      type(c_ptr) :: constants
      type(c_ptr) :: stress(6)
      type(c_ptr) :: gradient(9)
      type(c_ptr) :: pressure
      type(c_ptr) :: volume
      type(c_ptr) :: old_volume
      type(c_ptr) :: mass
      type(c_ptr) :: energy
      type(c_ptr) :: temperature
      type(c_ptr) :: damage
      type(c_ptr) :: plastic_increment
      type(c_ptr) :: plastic_work
      type(c_ptr) :: history
      type(c_ptr) :: tools
      integer(c_int64_t) :: error_row
      integer(c_int32_t) :: error
      integer(c_int32_t) :: unused
   end type scree_rows_t

   !> Functions with the same bits on all processors.
   type, bind(c) :: scree_tools_t
      type(c_funptr) :: exponentials
      type(c_funptr) :: logarithms
      type(c_funptr) :: powers
      type(c_funptr) :: fast_powers
   end type scree_tools_t

   abstract interface
      subroutine function_i(count, x) bind(c)
         import :: c_double, c_int64_t
         integer(c_int64_t), value :: count
         real(c_double), intent(inout) :: x(count)
      end subroutine function_i

      subroutine power_i(count, exponent, x) bind(c)
         import :: c_double, c_int64_t
         integer(c_int64_t), value :: count
         real(c_double), value :: exponent
         real(c_double), intent(inout) :: x(count)
      end subroutine power_i
   end interface

contains

   !> Numbers at an address of the rows, such as rows%stress(1); not associated if it is null.
   function scree_column(address, count) result(values)
      type(c_ptr), intent(in) :: address
      integer(c_int64_t), intent(in) :: count        !! Rows, or constants
      real(c_double), pointer :: values(:)

      values => null()
      if (c_associated(address)) call c_f_pointer(address, values, [count])
   end function scree_column

   !> A field of the history.
   function scree_history(rows, field) result(values)
      type(scree_rows_t), intent(in) :: rows
      integer, intent(in) :: field                   !! Its number in the declaration, from 1
      real(c_double), pointer :: values(:)
      type(c_ptr), pointer :: fields(:)

      call c_f_pointer(rows%history, fields, [field])
      values => scree_column(fields(field), rows%count)
   end function scree_history

   !> Exponential functions in place of numbers.
   subroutine scree_exponentials(rows, x)
      type(scree_rows_t), intent(in) :: rows
      real(c_double), contiguous, intent(inout) :: x(:)
      type(scree_tools_t), pointer :: tools
      procedure(function_i), pointer :: take

      call c_f_pointer(rows%tools, tools)
      call c_f_procpointer(tools%exponentials, take)
      call take(size(x, kind=c_int64_t), x)
   end subroutine scree_exponentials

   !> Natural logarithms in place of numbers.
   subroutine scree_logarithms(rows, x)
      type(scree_rows_t), intent(in) :: rows
      real(c_double), contiguous, intent(inout) :: x(:)
      type(scree_tools_t), pointer :: tools
      procedure(function_i), pointer :: take

      call c_f_pointer(rows%tools, tools)
      call c_f_procpointer(tools%logarithms, take)
      call take(size(x, kind=c_int64_t), x)
   end subroutine scree_logarithms

   !> Powers in place of their bases.
   subroutine scree_powers(rows, exponent, x)
      type(scree_rows_t), intent(in) :: rows
      real(c_double), intent(in) :: exponent
      real(c_double), contiguous, intent(inout) :: x(:)
      type(scree_tools_t), pointer :: tools
      procedure(power_i), pointer :: take

      call c_f_pointer(rows%tools, tools)
      call c_f_procpointer(tools%powers, take)
      call take(size(x, kind=c_int64_t), exponent, x)
   end subroutine scree_powers

   !> Powers in place of their bases, as exp(exponent ln(x)).
   subroutine scree_fast_powers(rows, exponent, x)
      type(scree_rows_t), intent(in) :: rows
      real(c_double), intent(in) :: exponent
      real(c_double), contiguous, intent(inout) :: x(:)
      type(scree_tools_t), pointer :: tools
      procedure(power_i), pointer :: take

      call c_f_pointer(rows%tools, tools)
      call c_f_procpointer(tools%fast_powers, take)
      call take(size(x, kind=c_int64_t), exponent, x)
   end subroutine scree_fast_powers
end module scree_law
