! SPDX-License-Identifier: BSD-3-Clause
!> Lines of progress in the log, and a warning if the run gets too little processor time.
module run_progress
   use base_kinds, only: int64, wp
   use base_log, only: log_t, progress_line, progress_row_t
   use base_text, only: number
   use base_timer, only: process_seconds, wall_seconds
   use omp_lib, only: omp_get_max_threads
   use run_limits, only: limits_t
   use run_loop_clock, only: loop_clock_t
   use run_threads, only: is_starved, starved_text
   use step_ledger, only: balance_t, kinetic, ledger_t
   use step_simulation, only: simulation_t
   use step_sort_particles, only: count_particles
   implicit none
   private

   public :: log_progress, log_stage, warn_if_starved

contains

   !> Write a line of progress to the log. Collective.
   subroutine log_progress(simulation, limits, log, clock)
      type(simulation_t), intent(in) :: simulation   !! After a step
      type(limits_t), intent(in) :: limits           !! End of the run
      type(log_t), intent(inout) :: log              !! Gets the line
      type(loop_clock_t), intent(inout) :: clock     !! Gets the time of the line
      type(progress_row_t) :: progress
      type(balance_t) :: balance
      type(ledger_t) :: ledger
      real(wp) :: wall, done
      integer(int64) :: counts(2)

      wall = wall_seconds()
      clock%last_line = wall
      ! A copy: the greatest momentum so far must not depend on the wall time of a line.
      ledger = simulation%balance%ledger
      call ledger%balance(simulation%machine%communicator, simulation%space%grid, &
         simulation%stores, simulation%materials, balance)
      counts = [count_particles(simulation%stores), simulation%clock%updates]
      call simulation%machine%communicator%total(counts)
      progress%wall = wall - clock%begin
      progress%time = simulation%clock%time
      progress%time_end = limits%time_end
      progress%step = simulation%clock%step
      progress%step_length = simulation%clock%dt
      progress%kinetic = balance%entry(kinetic)
      progress%energy_error = balance%energy_error
      progress%particles = counts(1)
      progress%updates_per_second = real(counts(2), wp)/progress%wall
      done = (simulation%clock%time - clock%time_begin)/(limits%time_end - clock%time_begin)
      progress%seconds_left = progress%wall*(1.0_wp/done - 1.0_wp)
      call log%info(progress_line(progress))
   end subroutine log_progress

   !> Log the stage of a cell that deforms when it begins.
   subroutine log_stage(simulation, log)
      type(simulation_t), intent(inout) :: simulation !! With a cell
      type(log_t), intent(inout) :: log
      character(len=24) :: time

      associate (cell => simulation%space%cell, stage => simulation%space%cell%now)
         if (cell%logged == stage) return
         cell%logged = stage
         write (time, "(es12.5)") simulation%clock%time
         if (stage > size(cell%legs)) then
            call log%info("  all stages finished  t = "//trim(adjustl(time))//" s")
         else
            call log%info("  stage "//number(stage)//" "//cell%legs(stage)%name//"  t = "// &
               trim(adjustl(time))//" s")
         end if
      end associate
   end subroutine log_stage

   !> Warn once if the wall time is much longer than the processor time, of the steps or of the
   !! whole run.
   subroutine warn_if_starved(simulation, log, clock, warned)
      type(simulation_t), intent(in) :: simulation   !! With the processor time of its steps
      type(log_t), intent(inout) :: log              !! Gets the warning
      type(loop_clock_t), intent(in) :: clock        !! Wall times
      logical, intent(inout) :: warned               !! Has the warning been given?
      real(wp) :: wall(2), processor(2)
      integer :: threads(2), part
      character(len=9), parameter :: parts(2) = [character(len=9) :: "the steps", "the run"]

      wall = [clock%steps_wall, wall_seconds() - clock%begin]
      processor = [simulation%machine%worked, process_seconds() - clock%processor_begin]
      ! the steps use all threads, output only one
      threads = [omp_get_max_threads(), 1]
      do part = 1, 2
         if (warned) return
         warned = is_starved(wall(part), processor(part), threads(part))
         if (warned) call log%warn(starved_text(trim(parts(part)), wall(part), processor(part), &
            threads(part)))
      end do
   end subroutine warn_if_starved
end module run_progress
