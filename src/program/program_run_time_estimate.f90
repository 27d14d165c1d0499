! SPDX-License-Identifier: BSD-3-Clause
!> Estimate of the time of a run, from its first steps.
module program_run_time_estimate
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_log, only: duration
   use base_text, only: number
   use base_timer, only: wall_seconds
   use omp_lib, only: omp_get_max_threads
   use run_expected_steps, only: expected_steps
   use run_next_step, only: choose_step
   use run_setup, only: run_setup_t
   use scene_first_state, only: make_first_state
   use step_advance, only: advance
   implicit none
   private

   public :: estimate_text

   !> More would take too long on a login node
   integer(int64), parameter, public :: most_particles = 2000000_int64
   real(wp), parameter :: patience = 2.0_wp          !! Wall time of the steps [s]
   integer, parameter :: warm_steps = 3              !! Not measured: the first steps load caches

contains

   !> The estimate in one line: the remaining steps are taken to cost as much as the first ones, and
   !! to be as long as the very first, since the steps of an impact at the start are shorter.
   subroutine estimate_text(setup, text, error)
      class(run_setup_t), intent(inout) :: setup     !! Without particles; its state is lost
      character(len=:), allocatable, intent(out) :: text !! The line; empty if no step is possible
      type(error_t), allocatable, intent(out) :: error !! The first state cannot be built
      type(error_t), allocatable :: failure
      character(len=24) :: cost
      real(wp) :: begin, dt, expected, left, seconds, wall(2)
      integer(int64) :: steps
      logical :: whole

      text = ""
      expected = expected_steps(setup%simulation, setup%bodies, setup%limits)
      call make_first_state(setup%simulation, setup%bodies, setup%survey, setup%shapes, error)
      if (allocated(error)) return
      associate (clock => setup%simulation%clock, limits => setup%limits)
         begin = wall_seconds()
         wall = 0.0_wp
         do
            whole = clock%time >= limits%time_end*(1.0_wp - epsilon(1.0_wp)) .or. &
               clock%step >= limits%max_steps
            if (whole .or. (clock%step > warm_steps .and. wall(2) > patience)) exit
            call choose_step(setup%simulation, limits, dt, failure)
            if (.not. allocated(failure)) call advance(setup%simulation, dt, failure)
            if (allocated(failure)) exit
            wall(2) = wall_seconds() - begin
            if (clock%step == warm_steps) wall(1) = wall(2)
         end do
         if (clock%step <= merge(0, warm_steps, whole)) return
         seconds = wall(2)
         steps = clock%step
         if (.not. whole) then
            left = min(expected*(1.0_wp - clock%time/limits%time_end), &
               real(limits%max_steps - clock%step, wp))
            seconds = seconds + left/real(clock%step - warm_steps, wp)*(wall(2) - wall(1))
            steps = steps + nint(left, int64)
         end if
         write (cost, "(es8.1)") wall(2)/real(clock%step, wp)
         text = "estimate   about "//number(steps)//" steps, wall time "// &
            trim(adjustl(duration(seconds)))//" on 1 rank x "//number(omp_get_max_threads())// &
            " threads, from "//number(clock%step)//" steps of "//trim(adjustl(cost))//" s"
         if (.not. whole) text = text//", if the others are like these"
         text = text//new_line("a")
      end associate
   end subroutine estimate_text
end module program_run_time_estimate
