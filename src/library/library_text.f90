! SPDX-License-Identifier: BSD-3-Clause
!> Texts between Fortran and C.
! allow(C071): texts of C have no length
module library_text
   use base_text, only: append, text_t
   use, intrinsic :: iso_c_binding, only: c_char, c_null_char
   implicit none
   private

   public :: from_c, to_c, words_from_c

contains

   !> A text of Fortran as an array that ends with a null.
   pure function to_c(text) result(letters)
      character(len=*), intent(in) :: text
      character(kind=c_char), allocatable :: letters(:)
      integer :: n

      allocate (letters(len(text) + 1))
      do n = 1, len(text)
         letters(n) = text(n:n)
      end do
      letters(len(text) + 1) = c_null_char
   end function to_c

   !> A text of C that ends with a null.
   pure function from_c(letters) result(text)
      character(kind=c_char), intent(in) :: letters(*) !! From C
      character(len=:), allocatable :: text
      integer :: length, n

      length = 0
      do while (letters(length + 1) /= c_null_char)
         length = length + 1
      end do
      allocate (character(len=length) :: text)
      do n = 1, length
         text(n:n) = letters(n)
      end do
   end function from_c

   !> Words of C, each of which ends with a null.
   subroutine words_from_c(letters, count, words)
      character(kind=c_char), intent(in) :: letters(*) !! From C
      integer, intent(in) :: count                     !! Number of words
      type(text_t), allocatable, intent(out) :: words(:)
      character(len=:), allocatable :: word
      integer :: at, n

      allocate (words(0))
      at = 1
      do n = 1, count
         word = from_c(letters(at))
         call append(words, word)
         at = at + len(word) + 1
      end do
   end subroutine words_from_c
end module library_text
