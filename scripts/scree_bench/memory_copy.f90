! SPDX-License-Identifier: BSD-3-Clause
!> What the memory gives: copy and triad of 8-byte numbers in arrays far larger than the caches.
!!
!! memory_copy [MEGABYTES] [REPEATS]   of each of three arrays; the best of the repeats counts.
!!
!! J. D. McCalpin's STREAM counts in the same way: what the loop names is moved once, 16 bytes an
!! element for a copy and 24 for a triad. Times are those that the processor worked on all threads,
!! over their number, so others on the machine disturb less than they would a clock on the wall.
program memory_copy
   use base_kinds, only: int64, wp
   use base_timer, only: process_seconds
   use omp_lib, only: omp_get_max_threads
   implicit none

   real(wp), allocatable :: a(:), b(:), c(:)
   real(wp) :: seconds(2), least(2), begin
   integer(int64) :: length
   integer :: megabytes, repeats, repeat
   character(len=32) :: word

   megabytes = 128
   repeats = 10
   call get_command_argument(1, word)
   if (len_trim(word) > 0) read (word, *) megabytes
   call get_command_argument(2, word)
   if (len_trim(word) > 0) read (word, *) repeats
   length = int(megabytes, int64)*131072_int64
   allocate (a(length), b(length), c(length))
   call fill(a, b, c)
   least = huge(1.0_wp)
   do repeat = 1, repeats
      begin = process_seconds()
      call copy(a, c)
      seconds(1) = process_seconds() - begin
      begin = process_seconds()
      call triad(b, c, 0.5_wp, a)
      seconds(2) = process_seconds() - begin
      least = min(least, seconds/real(omp_get_max_threads(), wp))
   end do
   if (.not. abs(a(length) - 0.0_wp) < huge(1.0_wp)) error stop "the triad gave no number"
   print "(a,f0.3)", "copy GB/s ", 16.0e-9_wp*real(length, wp)/least(1)
   print "(a,f0.3)", "triad GB/s ", 24.0e-9_wp*real(length, wp)/least(2)
   print "(a,i0)", "threads ", omp_get_max_threads()

contains

   !> First touch by the threads that work later.
   subroutine fill(first, second, third)
      real(wp), intent(out) :: first(:)              !! Any
      real(wp), intent(out) :: second(:)             !! Any
      real(wp), intent(out) :: third(:)              !! Any
      integer(int64) :: n

      !$omp parallel do default(none) shared(first, second, third) schedule(static)
      do n = 1, size(first, kind=int64)
         first(n) = 1.0_wp
         second(n) = 2.0_wp
         third(n) = 0.0_wp
      end do
      !$omp end parallel do
   end subroutine fill

   !> to = from.
   subroutine copy(from, to)
      real(wp), intent(in), contiguous :: from(:)    !! Any
      real(wp), intent(out), contiguous :: to(:)     !! The same
      integer(int64) :: n

      !$omp parallel do default(none) shared(from, to) schedule(static)
      do n = 1, size(from, kind=int64)
         to(n) = from(n)
      end do
      !$omp end parallel do
   end subroutine copy

   !> to = first + factor second.
   subroutine triad(first, second, factor, to)
      real(wp), intent(in), contiguous :: first(:)   !! Any
      real(wp), intent(in), contiguous :: second(:)  !! Any
      real(wp), intent(in) :: factor                 !! Any
      real(wp), intent(out), contiguous :: to(:)     !! The sum
      integer(int64) :: n

      !$omp parallel do default(none) shared(first, second, factor, to) schedule(static)
      do n = 1, size(first, kind=int64)
         to(n) = first(n) + factor*second(n)
      end do
      !$omp end parallel do
   end subroutine triad
end program memory_copy
