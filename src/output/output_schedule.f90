! SPDX-License-Identifier: BSD-3-Clause
!> Times of an output: at equal intervals of time, at listed times, or every n-th step. The
!! time step is not adapted to it: an output is written after the first step that reaches its time.
module output_schedule
   use base_constants, only: unset
   use base_kinds, only: int64, wp
   use base_text, only: number
   use deck_group_values, only: unset_integer
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   implicit none
   private

   public :: check_schedule, declare_schedule, intervals_until, read_schedule, schedule_t

   real(wp), parameter :: grain = 1.0e-12_wp !! Rounding must not delay an output by a step

   !> A schedule.
   type :: schedule_t
      real(wp) :: interval = 0.0_wp                  !! Time between, 0 = none [s]
      integer(int64) :: every = 0                    !! Steps between, 0 = none
      real(wp), allocatable :: times(:)              !! Listed times, ascending [s]
      integer(int64) :: done = 0                     !! Intervals or listed times that have passed
   contains
      procedure :: due => schedule_due               !! Is it due now? If so, it counts as done
      procedure :: catch_up => schedule_catch_up     !! Count outputs due before a time as done
      procedure :: expected => schedule_expected     !! How often it will be due
   end type schedule_t

contains

   !> Declare the keys dt, every, times and count of &output.
   subroutine declare_schedule(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys

      call schema%real("output", "dt", "interval of time between two outputs", unit="s", &
         range="> 0")
      call schema%integer("output", "every", "interval in steps between two outputs", range="> 0")
      call schema%real("output", "times(:50)", "output times", unit="s", range=">= 0")
      call schema%integer("output", "count", "number of outputs, evenly spaced over t_end", &
         range="> 0")
   end subroutine declare_schedule

   !> Check that one of the keys is given, and that the listed times are in the run.
   subroutine check_schedule(deck, output)
      type(deck_t), intent(inout) :: deck            !! Collects errors and warnings
      type(group_t), intent(in) :: output            !! An &output
      character(len=5), parameter :: keys(4) = ["dt   ", "every", "times", "count"]
      real(wp), allocatable :: times(:)
      character(len=:), allocatable :: given
      real(wp) :: t_end
      type(group_t) :: time
      integer :: i, total

      total = 0
      given = ""
      do i = 1, size(keys)
         if (.not. output%given(trim(keys(i)))) cycle
         total = total + 1
         given = given//" "//trim(keys(i))
      end do
      if (total == 0) call deck%add_error(output, "give one of dt, every, times, count [D319]")
      if (total > 1) call deck%add_error(output, "give one of dt, every, times, count, not"// &
         given//" [D319]", given(2:index(given(2:)//" ", " ")))
      time = deck%group("time")
      call time%get("t_end", t_end)
      if (t_end <= unset) return
      call output%list("times", times)
      do i = 1, size(times)
         if (times(i) <= t_end) cycle
         call deck%warn(output, "time "//number(i)//" of "//number(size(times))// &
            " is after t_end and will not be written [D315]", "times")
         return
      end do
   end subroutine check_schedule

   !> Read the keys dt, every, times and count of a group.
   subroutine read_schedule(group, time_end, schedule)
      type(group_t), intent(in) :: group             !! An &output
      real(wp), intent(in) :: time_end               !! End of the run [s]
      type(schedule_t), intent(out) :: schedule      !! Schedule
      integer :: count, steps

      call group%get("dt", schedule%interval)
      if (schedule%interval <= unset) schedule%interval = 0.0_wp
      call group%get("every", steps)
      if (steps /= unset_integer) schedule%every = steps
      call group%get("count", count)
      if (count /= unset_integer .and. count > 0) schedule%interval = time_end/real(count, wp)
      call group%list("times", schedule%times)
      if (size(schedule%times) == 0) deallocate (schedule%times)
   end subroutine read_schedule

   !> Is it due after this step? At step 0 it always is, unless it has listed times.
   logical function schedule_due(self, step, time) result(due)
      class(schedule_t), intent(inout) :: self
      integer(int64), intent(in) :: step             !! Steps done
      real(wp), intent(in) :: time                   !! Time reached [s]
      integer(int64) :: before

      before = self%done
      call self%catch_up(time)
      due = self%done > before
      if (self%every > 0) due = due .or. mod(step, self%every) == 0
   end function schedule_due

   !> Mark outputs due up to a time as written.
   pure subroutine schedule_catch_up(self, time)
      class(schedule_t), intent(inout) :: self
      real(wp), intent(in) :: time                   !! Time reached [s]

      if (self%interval > 0.0_wp) then
         self%done = intervals_until(time, self%interval, self%done)
      else if (allocated(self%times)) then
         do while (self%done < size(self%times))
            if (time*(1.0_wp + grain) < self%times(self%done + 1)) exit
            self%done = self%done + 1
         end do
      end if
   end subroutine schedule_catch_up

   !> The least number from `done` on whose multiple of the interval is after a time. It is found
   !! without a loop over all multiples: a time may be any number times the interval.
   pure integer(int64) function intervals_until(time, interval, done) result(number)
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(in) :: interval               !! Positive [s]
      integer(int64), intent(in) :: done             !! Number before
      real(wp), parameter :: countable = 1.0e15_wp   ! beyond it multiples are rounded

      number = max(done, int(min(time*(1.0_wp + grain)/interval, countable), int64) - 1)
      do while (time*(1.0_wp + grain) >= real(number, wp)*interval)
         if (real(number, wp) >= countable) return
         number = number + 1
      end do
   end function intervals_until

   !> Expected number of outputs in a run, as far as known before it.
   pure real(wp) function schedule_expected(self, time_end, steps) result(times)
      class(schedule_t), intent(in) :: self
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Expected steps, 0 = unknown
      real(wp), parameter :: countless = 1.0e18_wp   ! still a 64-bit integer

      times = 0.0_wp
      if (self%interval > 0.0_wp) times = 1.0_wp + aint(min(time_end/self%interval, countless))
      if (allocated(self%times)) times = times + real(size(self%times), wp)
      if (self%every > 0 .and. steps > 0.0_wp) times = times + 1.0_wp &
         + aint(steps/real(self%every, wp))
   end function schedule_expected
end module output_schedule
