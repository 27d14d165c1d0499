! SPDX-License-Identifier: BSD-3-Clause
!> Lines on the screen during long preparations, before the log is open.
module base_progress
   use base_kinds, only: int64, wp
   use base_timer, only: wall_seconds
   use, intrinsic :: iso_fortran_env, only: error_unit
   implicit none
   private

   public :: progress_t

   real(wp), parameter :: first_after = 5.0_wp, next_after = 20.0_wp !! Between lines [s]

   !> Progress of one preparation.
   type :: progress_t
      real(wp), private :: begin = 0.0_wp                !! Wall time at its begin [s]
      real(wp), private :: next = huge(1.0_wp)           !! Wall time of the next line [s]
      logical, private :: shows = .false.                !! Does this rank print lines?
   contains
      procedure :: start => progress_start               !! Begin
      procedure :: show => progress_show                 !! Print a line if it is time for one
   end type progress_t

contains

   !> Begin a preparation.
   subroutine progress_start(self, rank)
      class(progress_t), intent(out) :: self
      integer, intent(in) :: rank                        !! Rank 0 prints

      self%begin = wall_seconds()
      self%next = self%begin + first_after
      self%shows = rank == 0
   end subroutine progress_start

   !> Print how much is done, if it is time for a line. Only one thread may call it.
   subroutine progress_show(self, what, done, all)
      class(progress_t), intent(inout) :: self
      character(len=*), intent(in) :: what               !! What is being done
      integer(int64), intent(in) :: done, all            !! Done so far, and in all
      real(wp) :: now, share
      character(len=80) :: line

      if (.not. self%shows) return
      now = wall_seconds()
      if (now < self%next) return
      self%next = now + next_after
      share = real(max(done, 1_int64), wp)/real(max(all, 1_int64), wp)
      write (line, "(a, i0, a, i0, a, i0, a)") ": ", int(100.0_wp*share), " % after ", &
         nint(now - self%begin), " s, about ", &
         nint(min((now - self%begin)*(1.0_wp/share - 1.0_wp), 1.0e9_wp)), " s left"
      write (error_unit, "(a)") what//trim(line)
   end subroutine progress_show
end module base_progress
