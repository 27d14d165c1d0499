! SPDX-License-Identifier: BSD-3-Clause
!> How long a run will take: its first steps are done and timed, and a copy of the scene with larger
!! cells is run to its end, which shows by how much time becomes dearer as it goes on: steps shorten
!! where matter is struck, and cost more where it spreads over many tiles.
module program_time_estimate
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: number
   use mesh_grid, only: grid_t
   use omp_lib, only: omp_get_max_threads
   use output_streams, only: snapshot_bytes
   use program_plan, only: plan_t, read_plan
   use program_time_loop, only: read_limits
   use program_trial_run, only: row_seconds, trial_t, try_steps, warm_steps
   use scene_build, only: build_scene
   use scene_check_bodies, only: check_places
   use scene_first_state, only: begin_run
   use scene_particles, only: take_survey
   implicit none
   private

   public :: estimate_text

   integer(int64), parameter, public :: most_particles = 2000000_int64 !! A login node bears them
   real(wp), parameter :: patience = 2.0_wp          !! Wall time for the first steps [s]
   real(wp), parameter :: copy_patience = 8.0_wp     !! The same for the copy [s]
   real(wp), parameter :: copy_seconds = 3.0_wp      !! That it should take if nothing changes [s]
   integer, parameter :: most_coarse = 8             !! Times the cells of the deck
   real(wp), parameter :: snapshot_speed = 25.0e6_wp !! Compressed and written [byte/s]

contains

   !> The estimate in a line. The state of the run is spoilt by it.
   subroutine estimate_text(plan, text, error)
      class(plan_t), intent(inout) :: plan           !! Laid out, without particles
      character(len=:), allocatable, intent(out) :: text !! The line; empty if no step can be done
      type(error_t), allocatable, intent(out) :: error !! The bodies cannot begin
      type(trial_t) :: trial
      character(len=:), allocatable :: basis
      character(len=120) :: line
      real(wp) :: row, seconds, files, steps, share

      text = ""
      call begin_run(plan%simulation, plan%bodies, plan%survey, plan%shapes, error)
      if (allocated(error)) return
      row = row_seconds(plan%simulation)
      call try_steps(plan%simulation, plan%limits, patience, trial)
      if (trial%last%steps == 0) return
      if (trial%last%steps <= warm_steps .and. .not. trial%whole) return
      seconds = trial%last%processor
      steps = real(trial%last%steps, wp)
      basis = "all of them"
      if (.not. trial%whole) call extend(plan, trial, seconds, steps, basis)
      ! rows and files are the work of one thread
      files = row*plan%outputs%rows(plan%limits%time_end, steps) &
         + real(plan%outputs%expected(plan%limits%time_end), wp)*snapshot_bytes &
         *real(plan%survey%particles, wp)/snapshot_speed
      share = wall_share(trial%last%wall, trial%last%processor, omp_get_max_threads())
      write (line, "(a,i0,a,i0,a,es8.1,a)") " on 1 rank x ", omp_get_max_threads(), &
         " threads, from ", trial%last%steps, " steps of ", trial%last%processor*share &
         /real(trial%last%steps, wp), " s, "
      text = "estimate   about "//number(nint(steps, int64))//" steps; processor time "// &
         span_text(seconds + files)//", wall time "//span_text(seconds*share + files) &
         //trim(line)//" "//basis//new_line("a")
   end subroutine estimate_text

   !> Wall time over processor time of all threads. Threads that wait for others work too little for
   !! what they take; but if most of their time is lost, other programs have the cores, and the
   !! estimate is for a machine that is free.
   pure real(wp) function wall_share(wall, processor, threads) result(share)
      real(wp), intent(in) :: wall                   !! Of the first steps [s]
      real(wp), intent(in) :: processor              !! The same of all threads [s]
      integer, intent(in) :: threads                 !! How many
      real(wp), parameter :: most = 1.5_wp           ! of the share if no thread ever waits

      share = 1.0_wp/real(threads, wp)
      if (processor > 0.0_wp .and. wall/max(processor, tiny(processor)) < most*share) &
         share = max(share, wall/processor)
   end function wall_share

   !> Processor time and steps of the whole run from those of its first steps.
   subroutine extend(plan, trial, seconds, steps, basis)
      class(plan_t), intent(in) :: plan              !! The run
      type(trial_t), intent(in) :: trial             !! Its first steps
      real(wp), intent(inout) :: seconds             !! Of the first steps in, of the run out [s]
      real(wp), intent(inout) :: steps               !! The same
      character(len=:), allocatable, intent(out) :: basis !! What it rests on
      type(trial_t) :: copy
      real(wp) :: left, cost, more, most
      integer :: coarser
      logical :: found

      cost = (trial%last%processor - trial%first%processor) &
         /real(trial%last%steps - trial%first%steps, wp)
      left = (plan%limits%time_end - trial%last%time)/(trial%last%time - trial%first%time)
      more = left*real(trial%last%steps - trial%first%steps, wp)
      basis = "as if all others cost the same"
      coarser = wished_cells(plan%simulation%space%grid, more*cost/real(omp_get_max_threads(), wp))
      do
         call run_copy(plan, coarser, trial, copy, found)
         if (found .or. coarser == 2) exit
         ! thin bodies may have no particles left; smaller cells keep more of them
         coarser = max(coarser/2, 2)
      end do
      if (found) then
         basis = "and a copy with cells "//number(coarser)//" times as large"
         if (.not. copy%whole) basis = basis//", not run to its end"
         more = steps_left(plan, trial, copy, coarser)
         if (copy%last%steps > copy%clocked%steps) &
            cost = cost*(copy%last%processor - copy%clocked%processor) &
            /real(copy%last%steps - copy%clocked%steps, wp) &
            *real(copy%clocked%steps - copy%first%steps, wp) &
            /(copy%clocked%processor - copy%first%processor)
      end if
      seconds = seconds + more*cost
      steps = steps + more
      most = real(plan%limits%max_steps, wp)
      if (steps <= most) return
      seconds = seconds*most/steps
      steps = most
   end subroutine extend

   !> Steps after the first ones, from those of the copy after the same time. Signals take a cell of
   !! the copy so many times as long, shocks with artificial viscosity too as they are so many cells
   !! wide in both. Where something else sets the steps, they compare as those before do.
   pure real(wp) function steps_left(plan, trial, copy, coarser) result(steps)
      class(plan_t), intent(in) :: plan              !! The run
      type(trial_t), intent(in) :: trial             !! Its first steps
      type(trial_t), intent(in) :: copy              !! The copy
      integer, intent(in) :: coarser                 !! Cells are so many times as large
      integer, parameter :: countable = 20           ! fewer steps are no measure
      real(wp) :: early, late, scale
      integer :: first

      first = copy%middle%steps - copy%first%steps
      early = real(trial%last%steps - trial%first%steps, wp)
      late = (plan%limits%time_end - copy%middle%time)/(copy%last%time - copy%middle%time) &
         *real(copy%last%steps - copy%middle%steps, wp)
      scale = real(coarser, wp)
      if (first >= countable) scale = early/real(first, wp)*(copy%middle%time - copy%first%time) &
         /(trial%last%time - trial%first%time)
      steps = scale*late
   end function steps_left

   !> How many times as large the cells of the copy should be, so that it takes about a second. The
   !! box holds a whole number of them, if there is such a number near by.
   pure integer function wished_cells(grid, seconds) result(coarser)
      type(grid_t), intent(in) :: grid               !! Of the run
      real(wp), intent(in) :: seconds                !! That the run takes if nothing changes [s]
      integer :: wish, trial, side

      wish = ceiling((seconds/copy_seconds)**(1.0_wp/real(grid%dimensions + 1, wp)))
      wish = min(max(wish, 2), most_coarse)
      coarser = wish
      do trial = 0, wish
         side = merge(-(trial + 1)/2, trial/2, mod(trial, 2) == 1)
         if (wish + side < 2) cycle
         if (any(mod(grid%cells, wish + side) /= 0 .and. grid%active)) cycle
         coarser = wish + side
         return
      end do
   end function wished_cells

   !> Run a copy of the scene with larger cells.
   subroutine run_copy(plan, coarser, trial, copy, found)
      class(plan_t), intent(in) :: plan              !! The run
      integer, intent(in) :: coarser                 !! Cells are so many times as large
      type(trial_t), intent(in) :: trial             !! Its first steps
      type(trial_t), intent(out) :: copy             !! What the copy cost, from the same times on
      logical, intent(out) :: found                  !! Does it tell anything?
      type(plan_t) :: small
      type(error_t), allocatable :: error

      found = .false.
      small%command = plan%command
      call read_plan(small, error)
      if (allocated(error)) return
      call build_scene(small%deck, small%simulation, small%bodies, small%shapes, coarser)
      if (.not. allocated(small%bodies)) return
      call take_survey(small%simulation, small%bodies, small%survey)
      call check_places(small%deck, small%simulation, small%bodies, small%survey)
      call small%deck%verdict(error)
      if (allocated(error)) return
      call read_limits(small%deck, small%limits)
      small%limits%max_steps = huge(1_int64)
      call begin_run(small%simulation, small%bodies, small%survey, small%shapes, error)
      if (allocated(error)) return
      call try_steps(small%simulation, small%limits, copy_patience, copy, trial%first%time, &
         trial%last%time)
      found = copy%middle%steps > copy%first%steps .and. copy%last%steps > copy%middle%steps
   end subroutine run_copy

   !> A span of time for people.
   pure function span_text(seconds) result(text)
      real(wp), intent(in) :: seconds                !! [s]
      character(len=:), allocatable :: text
      character(len=24) :: line

      if (seconds < 300.0_wp) then
         write (line, "(i0,a)") max(nint(seconds), 1), " s"
      else if (seconds < 18000.0_wp) then
         write (line, "(i0,a)") nint(seconds/60.0_wp), " min"
      else if (seconds < 360000.0_wp) then
         write (line, "(f0.1,a)") seconds/3600.0_wp, " h"
      else
         write (line, "(f0.1,a)") seconds/86400.0_wp, " days"
      end if
      text = trim(line)
   end function span_text
end module program_time_estimate
