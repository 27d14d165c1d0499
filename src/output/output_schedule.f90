! SPDX-License-Identifier: BSD-3-Clause
!> When something is due: at equal intervals of time, at listed times, or every so many steps. The
!! time steps do not bend to it: what is due is done after the first step that reaches its time.
module output_schedule
   use base_constants, only: unset
   use base_deck, only: group_t
   use base_deck_group, only: unset_integer
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: read_schedule, schedule_t

   !> A schedule.
   type :: schedule_t
      real(wp) :: interval = 0.0_wp                  !! Time between, 0 = none [s]
      integer(int64) :: every = 0                    !! Steps between, 0 = none
      real(wp), allocatable :: times(:)              !! Listed times, ascending [s]
      integer(int64) :: done = 0                     !! Intervals or listed times that are over
   contains
      procedure :: due => schedule_due               !! Is it due now? Then it counts as done
      procedure :: catch_up => schedule_catch_up     !! Count what was due before a time as done
      procedure :: expected => schedule_expected     !! How often it will be due
   end type schedule_t

contains

   !> Read the keys dt, every, times and count of a group.
   subroutine read_schedule(group, time_end, schedule)
      type(group_t), intent(in) :: group             !! An &output
      real(wp), intent(in) :: time_end               !! End of the run [s]
      type(schedule_t), intent(out) :: schedule      !! What was asked for
      integer :: number

      call group%get("dt", schedule%interval)
      if (schedule%interval <= unset) schedule%interval = 0.0_wp
      call group%get("every", number)
      if (number /= unset_integer) schedule%every = number
      call group%get("count", number)
      if (number /= unset_integer .and. number > 0) schedule%interval = time_end/real(number, wp)
      call group%list("times", schedule%times)
      if (size(schedule%times) == 0) deallocate (schedule%times)
   end subroutine read_schedule

   !> Is it due after this step? At step 0 it always is, unless it has listed times.
   logical function schedule_due(self, step, time) result(due)
      class(schedule_t), intent(inout) :: self       !! The schedule
      integer(int64), intent(in) :: step             !! Steps done
      real(wp), intent(in) :: time                   !! Time reached [s]
      integer(int64) :: before

      before = self%done
      call self%catch_up(time)
      due = self%done > before
      if (self%every > 0) due = due .or. mod(step, self%every) == 0
   end function schedule_due

   !> Count what is due up to a time as done.
   pure subroutine schedule_catch_up(self, time)
      class(schedule_t), intent(inout) :: self       !! The schedule
      real(wp), intent(in) :: time                   !! Time reached [s]
      ! a time that is reached but for rounding is reached
      real(wp), parameter :: grain = 1.0e-12_wp

      if (self%interval > 0.0_wp) then
         do while (time*(1.0_wp + grain) >= real(self%done, wp)*self%interval)
            self%done = self%done + 1
         end do
      else if (allocated(self%times)) then
         do while (self%done < size(self%times))
            if (time*(1.0_wp + grain) < self%times(self%done + 1)) exit
            self%done = self%done + 1
         end do
      end if
   end subroutine schedule_catch_up

   !> How often it will be due in a run, as far as that is known before it.
   pure real(wp) function schedule_expected(self, time_end, steps) result(number)
      class(schedule_t), intent(in) :: self          !! The schedule
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Steps that it will take, 0 = unknown
      real(wp), parameter :: countless = 1.0e18_wp   ! still a long whole number

      number = 0.0_wp
      if (self%interval > 0.0_wp) number = 1.0_wp + aint(min(time_end/self%interval, countless))
      if (allocated(self%times)) number = number + real(size(self%times), wp)
      if (self%every > 0 .and. steps > 0.0_wp) number = number + 1.0_wp &
         + aint(steps/real(self%every, wp))
   end function schedule_expected
end module output_schedule
