! SPDX-License-Identifier: BSD-3-Clause
!> scree --check: tests of the strength laws that are in libraries.
module run_library_tests
   use base_error, only: error_t, exit_input, fail
   use material_library_contract, only: test_library
   use material_type, only: material_t
   implicit none
   private

   public :: test_libraries

contains

   !> Test all libraries; an error if one is unfit for a run.
   subroutine test_libraries(materials, text, error)
      type(material_t), intent(in) :: materials(:)   !! Complete
      character(len=:), allocatable, intent(out) :: text !! Lines with what is doubtful
      type(error_t), allocatable, intent(out) :: error !! A library fails a test
      character(len=:), allocatable :: fault, doubt
      integer :: n

      text = ""
      do n = 1, size(materials)
         if (.not. allocated(materials(n)%law)) cycle
         if (.not. materials(n)%law%is_in_library()) cycle
         call test_library(materials(n), fault, doubt)
         if (len(doubt) > 0) text = text//"warning: the library of &material '"// &
            materials(n)%name//"': "//doubt//" [F128]"//new_line("a")
         if (len(fault) == 0) cycle
         call fail(error, exit_input, "the library of &material '"//materials(n)%name// &
            "' fails a test: "//fault//" [F128]")
         return
      end do
   end subroutine test_libraries
end module run_library_tests
