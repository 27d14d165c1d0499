! SPDX-License-Identifier: BSD-3-Clause
!> How long a run will take, found by doing a little of it.
module driver_trial
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_timer, only: wall_seconds
   use driver_run, only: choose_step, limits_t
   use driver_simulation, only: simulation_t
   use driver_step, only: advance
   use omp_lib, only: omp_get_max_threads
   implicit none
   private

   public :: trial_text

   integer(int64), parameter, public :: most_particles = 2000000_int64 !! A login node bears them
   integer, parameter :: warm_steps = 3              !! Before the clock runs: memory is fetched
   integer, parameter :: most_steps = 50             !! Timed
   real(wp), parameter :: patience = 2.0_wp          !! Wall time for them [s]

contains

   !> Time some steps of a filled run and tell how long all of them take. The state of the run is
   !! spoilt by it. Output, and what changes as the run goes on, are not in the estimate.
   function trial_text(simulation, limits) result(text)
      type(simulation_t), intent(inout) :: simulation !! The run in its first state
      type(limits_t), intent(in) :: limits           !! End of the run
      character(len=:), allocatable :: text
      type(error_t), allocatable :: error
      character(len=160) :: line
      real(wp) :: begin, dt, seconds, steps
      integer :: step, timed

      timed = 0
      begin = wall_seconds()
      seconds = 0.0_wp
      do step = 1, warm_steps + most_steps
         call choose_step(simulation, limits, dt, error)
         if (allocated(error)) exit
         if (simulation%time + dt >= limits%time_end) exit
         call advance(simulation, dt, error)
         if (allocated(error)) exit
         if (step <= warm_steps) then
            begin = wall_seconds()
         else
            timed = timed + 1
            seconds = wall_seconds() - begin
            if (seconds > patience) exit
         end if
      end do
      text = ""
      if (timed == 0) return
      seconds = seconds/real(timed, wp)
      steps = (limits%time_end - simulation%time)/simulation%dt + real(step, wp)
      if (limits%max_steps < huge(1_int64)) steps = min(steps, real(limits%max_steps, wp))
      write (line, "(a,i0,a,i0,a,es8.1,a)") " on 1 rank x ", omp_get_max_threads(), &
         " threads, from ", timed, " steps of ", seconds, " s"
      text = "estimate   "//span_text(steps*seconds)//trim(line)//new_line("a")
   end function trial_text

   !> A span of time for people.
   pure function span_text(seconds) result(text)
      real(wp), intent(in) :: seconds                !! [s]
      character(len=:), allocatable :: text
      character(len=24) :: line

      if (seconds < 100.0_wp) then
         write (line, "(i0,a)") max(nint(seconds), 1), " s"
      else if (seconds < 6000.0_wp) then
         write (line, "(i0,a)") nint(seconds/60.0_wp), " min"
      else if (seconds < 360000.0_wp) then
         write (line, "(f0.1,a)") seconds/3600.0_wp, " h"
      else
         write (line, "(f0.1,a)") seconds/86400.0_wp, " days"
      end if
      text = trim(line)
   end function span_text
end module driver_trial
