! SPDX-License-Identifier: BSD-3-Clause
!> Shared libraries with a strength law of the user: loading, and the interface in C.
!!
!! `scree_law.h` states the same interface for authors of libraries; the two change together, with
!! the version of the interface.
! allow(C071, C072): the texts of C have no length of their own
module material_library
   use base_elementary, only: take_exponentials, take_fast_powers, take_logarithms, take_powers
   use base_error, only: error_t, exit_input, fail
   use base_file, only: read_file
   use base_hash, only: digest_text, hash_text
   use base_libc, only: c_dlopen, c_dlsym, load_now, loading_failure, text_at
   use base_text, only: number
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_procpointer, &
      c_funloc, c_funptr, c_int32_t, c_int64_t, c_null_char, c_ptr
   use material_library_text, only: library_text_t, longest_text, read_library_text
   implicit none
   private

   public :: fill_library, law_update_i, library_rows_t, library_t, open_library

   integer(c_int32_t), parameter :: interface_version = 1 !! SCREE_LAW_INTERFACE of scree_law.h
   integer, parameter, public :: longest_message = 200   !! Letters of a message of a library

   !> Rows of particles of a call, struct scree_rows. Addresses are those of the first row.
   type, bind(c) :: library_rows_t
      integer(c_int64_t) :: count                    !! Rows
      real(c_double) :: dt                           !! Time step [s]
      real(c_double) :: shear                        !! Shear modulus of the material [Pa]
      real(c_double) :: bulk                         !! Bulk modulus at the reference [Pa]
      real(c_double) :: density                      !! Density of the reference state [kg/m3]
      type(c_ptr) :: constants                       !! In the order of the declaration, SI
      type(c_ptr) :: stress(6)                       !! xx, yy, zz, xy, yz, xz [Pa]
      type(c_ptr) :: gradient(9)                     !! dt du_k/dx_l at k + 3 (l - 1) [1]
      type(c_ptr) :: pressure                        !! After the step; null: whole stress [Pa]
      type(c_ptr) :: volume                          !! After the step [m3]
      type(c_ptr) :: old_volume                      !! Before the step [m3]
      type(c_ptr) :: mass                            !! [kg]
      type(c_ptr) :: energy                          !! Null: there is none [J/kg]
      type(c_ptr) :: temperature                     !! Null: there is none [K]
      type(c_ptr) :: damage                          !! Null: there is none [1]
      type(c_ptr) :: plastic_increment               !! (out) [1]
      type(c_ptr) :: plastic_work                    !! (out) [J]
      type(c_ptr) :: history                         !! Addresses of the fields
      type(c_ptr) :: tools                           !! library_tools_t
      integer(c_int64_t) :: error_row                !! Row of the error, -1: all (out)
      integer(c_int32_t) :: error                    !! 0: none (out)
      integer(c_int32_t) :: unused                   !! Fills up to eight bytes
   end type library_rows_t

   !> Functions for libraries whose bits do not depend on the processor, struct scree_tools.
   type, bind(c) :: library_tools_t
      type(c_funptr) :: exponentials                 !! x(:) = exp(x)
      type(c_funptr) :: logarithms                   !! x(:) = ln(x)
      type(c_funptr) :: powers                       !! x(:) = x**exponent
      type(c_funptr) :: fast_powers                  !! The same as exp(exponent ln(x))
   end type library_tools_t

   abstract interface
      !> Updates rows, scree_law_update. Pure: a library has no state of its own.
      pure subroutine law_update_i(rows) bind(c)
         import :: c_ptr
         implicit none
         type(c_ptr), value :: rows                  !! library_rows_t
      end subroutine law_update_i

      !> Checks the constants, scree_law_check; 0 if they are valid.
      function law_check_i(constants, message, length) bind(c) result(status)
         import :: c_char, c_double, c_int32_t, c_int64_t
         implicit none
         real(c_double), intent(in) :: constants(*)  !! In the order of the declaration, SI
         character(kind=c_char), intent(inout) :: message(*) !! Gets a text with its null
         integer(c_int64_t), value :: length         !! Of the message, with its null
         integer(c_int32_t) :: status
      end function law_check_i

      !> Text of an error, scree_law_explain.
      function law_explain_i(error) bind(c) result(text)
         import :: c_int32_t, c_ptr
         implicit none
         integer(c_int32_t), value :: error          !! That of the rows
         type(c_ptr) :: text                         !! Null-terminated, or null
      end function law_explain_i

      !> Version of the interface, scree_law_interface.
      function law_version_i() bind(c) result(version)
         import :: c_int32_t
         implicit none
         integer(c_int32_t) :: version
      end function law_version_i

      !> The declaration, scree_law_declaration.
      function law_declaration_i() bind(c) result(text)
         import :: c_ptr
         implicit none
         type(c_ptr) :: text                         !! Null-terminated
      end function law_declaration_i
   end interface

   !> A loaded library. It is never closed, since copies of a law hold its addresses.
   type :: library_t
      character(len=:), allocatable :: path          !! As in messages
      character(len=:), allocatable :: digest        !! Hash of the bytes of the file
      type(library_text_t) :: declared               !! What it declares
      type(library_tools_t), pointer :: tools => null() !! Functions that it may call
      procedure(law_update_i), pointer, nopass :: update => null() !! Null: no library
      procedure(law_check_i), pointer, nopass :: check => null() !! Null: it has none
      procedure(law_explain_i), pointer, nopass :: explain => null() !! Null: it has none
   end type library_t

contains

   !> Load a library and read what it declares.
   subroutine open_library(path, library, error)
      character(len=*), intent(in) :: path           !! File
      type(library_t), intent(out) :: library
      type(error_t), allocatable, intent(out) :: error !! The file is no library with a law
      procedure(law_version_i), pointer :: version
      procedure(law_declaration_i), pointer :: declaration
      character(len=:), allocatable :: bytes, fault, file
      type(c_ptr) :: handle
      type(c_funptr) :: place(3)

      library%path = path
      fault = ""
      ! a name without a folder would be searched in the folders of the system
      file = path
      if (index(path, "/") == 0) file = "./"//path
      handle = c_dlopen(file//c_null_char, load_now)
      if (.not. c_associated(handle)) fault = loading_failure()
      if (fault == "") call find_procedure(handle, "scree_law_interface", place(1), fault)
      if (fault == "") then
         call c_f_procpointer(place(1), version)
         if (version() /= interface_version) fault = "it has version "// &
            number(int(version()))//" of the interface of laws and this program has version "// &
            number(int(interface_version))//"; compile it with the scree_law.h of this program"
      end if
      if (fault == "") call find_procedure(handle, "scree_law_declaration", place(2), fault)
      if (fault == "") call find_procedure(handle, "scree_law_update", place(3), fault)
      if (fault == "") then
         call c_f_procpointer(place(2), declaration)
         call fill_library(text_at(declaration(), longest_text), place(3), library, fault)
      end if
      if (fault == "") then
         call find_options(handle, library)
         call read_file(path, bytes, error)
         if (allocated(error)) return
         library%digest = digest_text(hash_text(bytes))
      end if
      if (fault /= "") call fail(error, exit_input, "cannot use the library '"//path//"': "// &
         fault//" [F127]")
   end subroutine open_library

   !> Fill a library from its declaration and the address of its update; also for tests, whose laws
   !! are procedures of the program.
   subroutine fill_library(text, update, library, fault)
      character(len=*), intent(in) :: text           !! Lines of the declaration
      type(c_funptr), intent(in) :: update           !! Address of a `law_update_i`
      type(library_t), intent(inout) :: library      !! With its path
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      procedure(law_update_i), pointer :: rows

      if (.not. allocated(library%path)) library%path = "none"
      if (.not. allocated(library%digest)) library%digest = "none"
      call read_library_text(text, library%declared, fault)
      if (fault /= "") return
      call c_f_procpointer(update, rows)
      library%update => rows
      allocate (library%tools)
      library%tools%exponentials = c_funloc(library_exponentials)
      library%tools%logarithms = c_funloc(library_logarithms)
      library%tools%powers = c_funloc(library_powers)
      library%tools%fast_powers = c_funloc(library_fast_powers)
   end subroutine fill_library

   !> Address of a procedure that a library must have.
   subroutine find_procedure(handle, name, place, fault)
      type(c_ptr), intent(in) :: handle              !! Loaded library
      character(len=*), intent(in) :: name           !! Name of the procedure
      type(c_funptr), intent(out) :: place
      character(len=:), allocatable, intent(inout) :: fault !! Empty if it is found
      type(c_ptr) :: address

      address = c_dlsym(handle, name//c_null_char)
      place = transfer(address, place)
      if (.not. c_associated(address)) fault = "it has no procedure "//name
   end subroutine find_procedure

   !> Addresses of the procedures that a library may have.
   subroutine find_options(handle, library)
      type(c_ptr), intent(in) :: handle              !! Loaded library
      type(library_t), intent(inout) :: library
      procedure(law_check_i), pointer :: check
      procedure(law_explain_i), pointer :: explain
      type(c_funptr) :: place
      character(len=:), allocatable :: fault

      fault = ""
      call find_procedure(handle, "scree_law_check", place, fault)
      if (fault == "") then
         call c_f_procpointer(place, check)
         library%check => check
      end if
      fault = ""
      call find_procedure(handle, "scree_law_explain", place, fault)
      if (fault == "") then
         call c_f_procpointer(place, explain)
         library%explain => explain
      end if
   end subroutine find_options

   !> Exponential functions in place of numbers.
   subroutine library_exponentials(count, x) bind(c, name="")
      integer(c_int64_t), value :: count             !! Numbers
      real(c_double), intent(inout) :: x(count)      !! Arguments, results

      call take_exponentials(int(count), x)
   end subroutine library_exponentials

   !> Natural logarithms in place of numbers.
   subroutine library_logarithms(count, x) bind(c, name="")
      integer(c_int64_t), value :: count             !! Numbers
      real(c_double), intent(inout) :: x(count)      !! Arguments, results

      call take_logarithms(int(count), x)
   end subroutine library_logarithms

   !> Powers in place of their bases.
   subroutine library_powers(count, exponent, x) bind(c, name="")
      integer(c_int64_t), value :: count             !! Numbers
      real(c_double), value :: exponent              !! Common exponent
      real(c_double), intent(inout) :: x(count)      !! Bases, results

      call take_powers(int(count), exponent, x)
   end subroutine library_powers

   !> Powers in place of their bases, in less time and with less precision.
   subroutine library_fast_powers(count, exponent, x) bind(c, name="")
      integer(c_int64_t), value :: count             !! Numbers
      real(c_double), value :: exponent              !! Common exponent
      real(c_double), intent(inout) :: x(count)      !! Bases, results

      call take_fast_powers(int(count), exponent, x)
   end subroutine library_fast_powers
end module material_library
