! SPDX-License-Identifier: BSD-3-Clause
!> Wall time of the phases of a run. A phase that starts inside another one pauses it, so the times
!! of all phases add up to the total.
module base_timer
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use, intrinsic :: iso_c_binding, only: c_int, c_long
   implicit none
   private

   public :: process_seconds, thread_seconds, timer_t, wall_seconds

   integer, parameter :: name_length = 32                !! Longest name of a phase
   integer, parameter :: most_phases = 32                !! Phases of a timer
   integer, parameter :: most_deep = 8                   !! Phases inside one another

   !> Time of the C library.
   type, bind(c) :: time_t
      integer(c_long) :: seconds                         !! [s]
      integer(c_long) :: nanoseconds                     !! [ns]
   end type time_t

   interface
      !> Read a clock of POSIX.
      function clock_gettime(clock, time) bind(c, name="clock_gettime") result(status)
         import :: c_int, time_t
         implicit none
         integer(c_int), value :: clock                  !! Name
         type(time_t), intent(out) :: time               !! Time of the clock
         integer(c_int) :: status
      end function clock_gettime
   end interface

   !> One phase.
   type :: phase_t
      character(len=name_length) :: name = ""            !! As in the table
      integer(int64) :: started = 0                      !! Clock at the last start
      integer(int64) :: ticks = 0                        !! Clock ticks so far
      integer(int64) :: calls = 0                        !! Number of calls
   end type phase_t

   !> Times of named phases on this rank.
   type :: timer_t
      type(phase_t), private :: phases(most_phases)      !! In the order of their first use
      integer, private :: filled = 0                     !! Phases in use
      integer, private :: open(0:most_deep) = 0          !! (depth) Running phases, inner last
      integer, private :: depth = 0                      !! Number of running phases
   contains
      procedure :: phase => timer_phase                  !! Number of a phase, new or known
      procedure :: start => timer_start                  !! Start a phase
      procedure :: stop => timer_stop                    !! Stop a phase
      procedure :: move => timer_move                    !! Move seconds of a phase to another one
      procedure :: count => timer_count                  !! Number of phases
      procedure :: name => timer_name                    !! Name of a phase
      procedure :: calls => timer_calls                  !! How often a phase ended
      procedure :: seconds => timer_seconds              !! Seconds on this rank
      procedure :: spread => timer_spread                !! Minimum, mean, maximum over the ranks
      procedure :: table => timer_table                  !! A table of them
   end type timer_t

contains

   !> Seconds of the monotonic clock.
   function wall_seconds() result(seconds)
      real(wp) :: seconds
      integer(int64) :: rate, ticks

      call system_clock(ticks, rate)
      seconds = real(ticks, wp)/real(rate, wp)
   end function wall_seconds

   !> Processor time of the calling thread [s].
   function thread_seconds() result(seconds)
      integer(c_int), parameter :: of_this_thread = 3_c_int
      real(wp) :: seconds

      seconds = clock_seconds(of_this_thread)
   end function thread_seconds

   !> Processor time of all threads of this process [s].
   function process_seconds() result(seconds)
      integer(c_int), parameter :: of_this_process = 2_c_int
      real(wp) :: seconds

      seconds = clock_seconds(of_this_process)
   end function process_seconds

   !> Time of a POSIX clock, 0 if there is none [s].
   function clock_seconds(clock) result(seconds)
      integer(c_int), intent(in) :: clock                !! Name
      real(wp), parameter :: nano = 1.0e-9_wp
      type(time_t) :: now
      real(wp) :: seconds

      seconds = 0.0_wp
      if (clock_gettime(clock, now) == 0) &
         seconds = real(now%seconds, wp) + nano*real(now%nanoseconds, wp)
   end function clock_seconds

   !> Index of a phase. All names beyond the capacity have the last index.
   function timer_phase(self, name) result(index)
      class(timer_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! As in the table
      integer :: index

      do index = 1, self%filled
         if (self%phases(index)%name == name) return
      end do
      index = min(self%filled + 1, most_phases)
      if (self%filled < most_phases) self%phases(index)%name = name
      self%filled = index
   end function timer_phase

   !> Start a phase.
   subroutine timer_start(self, index)
      class(timer_t), intent(inout) :: self
      integer, intent(in) :: index                       !! From `phase`

      integer(int64) :: ticks

      call system_clock(ticks)
      if (self%depth > 0) call close_interval(self%phases(self%open(self%depth)), ticks)
      self%depth = min(self%depth + 1, most_deep)
      self%open(self%depth) = index
      self%phases(index)%started = ticks
   end subroutine timer_start

   !> Add the time since the last start of a phase.
   pure subroutine close_interval(phase, ticks)
      type(phase_t), intent(inout) :: phase              !! Name
      integer(int64), intent(in) :: ticks                !! Clock now

      phase%ticks = phase%ticks + ticks - phase%started
   end subroutine close_interval

   !> Move seconds of one phase to another, for work whose phase is known only afterwards.
   subroutine timer_move(self, from, to, seconds)
      class(timer_t), intent(inout) :: self
      integer, intent(in) :: from                        !! Loses them
      integer, intent(in) :: to                          !! Receives them
      real(wp), intent(in) :: seconds                    !! [s]
      integer(int64) :: rate, now, ticks

      call system_clock(now, rate)
      ticks = nint(seconds*real(rate, wp), int64)
      self%phases(from)%ticks = self%phases(from)%ticks - ticks
      self%phases(to)%ticks = self%phases(to)%ticks + ticks
      self%phases(to)%calls = self%phases(to)%calls + 1_int64
   end subroutine timer_move

   !> Stop a phase and continue the one that it paused.
   subroutine timer_stop(self, index)
      class(timer_t), intent(inout) :: self
      integer, intent(in) :: index                       !! From `phase`
      integer(int64) :: ticks

      call system_clock(ticks)
      call close_interval(self%phases(index), ticks)
      self%phases(index)%calls = self%phases(index)%calls + 1_int64
      self%depth = max(self%depth - 1, 0)
      if (self%depth > 0) self%phases(self%open(self%depth))%started = ticks
   end subroutine timer_stop

   !> Number of phases.
   pure integer function timer_count(self) result(count)
      class(timer_t), intent(in) :: self
      count = self%filled
   end function timer_count

   !> Name of a phase.
   pure function timer_name(self, index) result(name)
      class(timer_t), intent(in) :: self
      integer, intent(in) :: index                       !! From 1 to `count`
      character(len=:), allocatable :: name

      name = trim(self%phases(index)%name)
   end function timer_name

   !> How often a phase ended on this rank.
   pure function timer_calls(self, index) result(calls)
      class(timer_t), intent(in) :: self
      integer, intent(in) :: index                       !! From 1 to `count`
      integer(int64) :: calls

      calls = self%phases(index)%calls
   end function timer_calls

   !> Seconds of a phase on this rank.
   function timer_seconds(self, index) result(seconds)
      class(timer_t), intent(in) :: self
      integer, intent(in) :: index                       !! From 1 to `count`
      real(wp) :: seconds
      integer(int64) :: rate, ticks

      call system_clock(ticks, rate)
      seconds = real(self%phases(index)%ticks, wp)/real(rate, wp)
   end function timer_seconds

   !> Seconds of all phases, their minimum, mean and maximum over the ranks; the last element of
   !! each is the time outside of all phases. Collective; all ranks must know the same phases.
   subroutine timer_spread(self, communicator, total, least, mean, greatest)
      class(timer_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(in) :: total                      !! Seconds of the whole on this rank
      real(wp), allocatable, intent(out) :: least(:)     !! (phase, and the rest) [s]
      real(wp), allocatable, intent(out) :: mean(:)      !! (phase, and the rest) [s]
      real(wp), allocatable, intent(out) :: greatest(:)  !! (phase, and the rest) [s]
      real(wp), parameter :: nano = 1.0e-9_wp
      integer(int64), allocatable :: sums(:)
      real(wp), allocatable :: own(:)
      integer :: index, last

      last = self%filled + 1
      allocate (least(last), mean(last), greatest(last), own(last), sums(last))
      do index = 1, self%filled
         own(index) = self%seconds(index)
      end do
      own(last) = max(total - sum(own(:last - 1)), 0.0_wp)
      sums = nint(own/nano, int64)
      call communicator%total(sums)
      mean = real(sums, wp)*nano/real(communicator%size, wp)
      do index = 1, last
         least(index) = communicator%minimum(own(index))
         greatest(index) = communicator%maximum(own(index))
      end do
   end subroutine timer_spread

   !> A table of all phases, with the time outside of them as "other". Collective.
   function timer_table(self, communicator, total) result(text)
      class(timer_t), intent(in) :: self
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(in) :: total                      !! Seconds of the whole on this rank
      character(len=:), allocatable :: text
      real(wp), allocatable :: greatest(:), least(:), mean(:)
      character(len=88) :: line
      real(wp) :: share, whole
      integer :: index

      call self%spread(communicator, total, least, mean, greatest)
      whole = max(sum(mean), tiny(1.0_wp))
      write (line, "(a, t28, a)") "timing (s)", "    min        avg        max      %        calls"
      text = trim(line)
      do index = 1, self%filled + 1
         share = 100.0_wp*mean(index)/whole
         if (index <= self%filled) then
            write (line, "(2x, a, t25, 3f11.3, f7.1, i13)") self%phases(index)%name(:22), &
               least(index), mean(index), greatest(index), share, self%phases(index)%calls
         else
            write (line, "(2x, a, t25, 3f11.3, f7.1)") "other", least(index), mean(index), &
               greatest(index), share
         end if
         text = text//new_line("a")//trim(line)
      end do
   end function timer_table
end module base_timer
