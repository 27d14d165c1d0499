! SPDX-License-Identifier: BSD-3-Clause
!> Estimate of the time of a run, from its first steps and from a copy of the scene with larger
!! cells, which is run to its end. The copy shows how steps become shorter in impacts and more
!! costly as material spreads over tiles. Section Interface of doc/developer/decisions.md compares
!! both.
module program_run_time_estimate
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: number
   use mesh_grid, only: grid_t
   use omp_lib, only: omp_get_max_threads
   use program_trial_steps, only: run_trial, time_history_row, trial_t, warm_steps
   use run_limits, only: read_limits
   use run_setup, only: a_scene, run_setup_t
   use scene_body_placement, only: check_placement
   use scene_first_state, only: make_first_state
   use scene_particles, only: take_survey
   use scene_setup, only: set_up_scene
   use stream_particles, only: snapshot_bytes
   implicit none
   private

   public :: estimate_text

   !> More would take too long on a login node
   integer(int64), parameter, public :: most_particles = 2000000_int64
   real(wp), parameter :: patience = 2.0_wp          !! Allowed wall time of the first steps [s]
   real(wp), parameter :: copy_patience = 8.0_wp     !! Allowed wall time of the copy [s]
   real(wp), parameter :: copy_seconds = 3.0_wp      !! Target for the time of the copy [s]
   integer, parameter :: most_coarse = 8             !! Greatest ratio of cell sizes
   real(wp), parameter :: snapshot_speed = 25.0e6_wp !! Compressed and written [byte/s]

contains

   !> The estimate in one line.
   subroutine estimate_text(setup, text, error)
      class(run_setup_t), intent(inout) :: setup           !! Without particles; its state is lost
      character(len=:), allocatable, intent(out) :: text !! The line; empty if no step is possible
      type(error_t), allocatable, intent(out) :: error !! The first state cannot be built
      type(trial_t) :: trial
      character(len=:), allocatable :: basis
      character(len=120) :: line
      real(wp) :: row, seconds, files, steps, share

      text = ""
      call make_first_state(setup%simulation, setup%bodies, setup%survey, setup%shapes, error)
      if (allocated(error)) return
      row = time_history_row(setup%simulation)
      call run_trial(setup%simulation, setup%limits, patience, trial)
      if (trial%last%steps == 0) return
      if (trial%last%steps <= warm_steps .and. .not. trial%whole) return
      seconds = trial%last%processor
      steps = real(trial%last%steps, wp)
      basis = "all of them"
      if (.not. trial%whole) call extrapolate_costs(setup, trial, seconds, steps, basis)
      ! rows and files use one thread
      files = row*setup%outputs%ledger_rows(setup%limits%time_end, steps) &
         + real(setup%outputs%full_snapshots(setup%limits%time_end), wp)*snapshot_bytes &
         *real(setup%survey%particles, wp)/snapshot_speed
      share = wall_time_ratio(trial%last%wall, trial%last%processor, omp_get_max_threads())
      write (line, "(a,i0,a,i0,a,es8.1,a)") " on 1 rank x ", omp_get_max_threads(), &
         " threads, from ", trial%last%steps, " steps of ", trial%last%processor*share &
         /real(trial%last%steps, wp), " s, "
      text = "estimate   about "//number(nint(steps, int64))//" steps; processor time "// &
         duration_text(seconds + files)//", wall time "//duration_text(seconds*share + files) &
         //trim(line)//" "//basis//new_line("a")
   end subroutine estimate_text

   !> Ratio of wall time to processor time of all threads. A ratio above that of busy threads is due
   !! to waiting; a much higher ratio means that other programs use the cores; the estimate is then
   !! for an idle machine.
   pure real(wp) function wall_time_ratio(wall, processor, threads) result(share)
      real(wp), intent(in) :: wall                   !! Wall time of the first steps [s]
      real(wp), intent(in) :: processor              !! Processor time of all threads [s]
      integer, intent(in) :: threads                 !! Number of threads
      real(wp), parameter :: most = 1.5_wp           ! times the ratio without waiting

      share = 1.0_wp/real(threads, wp)
      if (processor > 0.0_wp .and. wall/max(processor, tiny(processor)) < most*share) &
         share = max(share, wall/processor)
   end function wall_time_ratio

   !> Extrapolate processor time and steps from the first steps to the whole run.
   subroutine extrapolate_costs(setup, trial, seconds, steps, basis)
      class(run_setup_t), intent(in) :: setup
      type(trial_t), intent(in) :: trial             !! First steps of the run
      real(wp), intent(inout) :: seconds !! Time of the first steps in, of the run out [s]
      real(wp), intent(inout) :: steps               !! Number of steps, scaled too
      character(len=:), allocatable, intent(out) :: basis !! Basis of the estimate, for the user
      type(trial_t) :: copy
      real(wp) :: left, cost, more, most
      integer :: coarser
      logical :: found

      cost = (trial%last%processor - trial%first%processor) &
         /real(trial%last%steps - trial%first%steps, wp)
      left = (setup%limits%time_end - trial%last%time)/(trial%last%time - trial%first%time)
      more = left*real(trial%last%steps - trial%first%steps, wp)
      basis = "assuming that the remaining steps cost the same"
      coarser = cell_size_ratio(setup%simulation%space%grid, &
         more*cost/real(omp_get_max_threads(), wp))
      do
         call run_copy(setup, coarser, trial, copy, found)
         if (found .or. coarser == 2) exit
         ! thin bodies may have no particles in large cells
         coarser = max(coarser/2, 2)
      end do
      if (found) then
         basis = "and from a coarser copy, with cells "//number(coarser)//" times as large"
         if (.not. copy%whole) basis = basis//", stopped early"
         more = steps_left(setup, trial, copy, coarser)
         if (copy%last%steps > copy%clocked%steps) &
            cost = cost*(copy%last%processor - copy%clocked%processor) &
            /real(copy%last%steps - copy%clocked%steps, wp) &
            *real(copy%clocked%steps - copy%first%steps, wp) &
            /(copy%clocked%processor - copy%first%processor)
      end if
      seconds = seconds + more*cost
      steps = steps + more
      most = real(setup%limits%max_steps, wp)
      if (steps <= most) return
      seconds = seconds*most/steps
      steps = most
   end subroutine extrapolate_costs

   !> Steps that remain, from those of the copy after the same time. The stable step is proportional
   !! to the cell size, for waves and for shocks with artificial viscosity, which are a number of
   !! cells wide. If the ratio of the first steps differs from this, it is used instead.
   pure real(wp) function steps_left(setup, trial, copy, coarser) result(steps)
      class(run_setup_t), intent(in) :: setup
      type(trial_t), intent(in) :: trial             !! First steps of the run
      type(trial_t), intent(in) :: copy
      integer, intent(in) :: coarser                 !! Ratio of cell sizes
      integer, parameter :: countable = 20           ! fewer steps give no ratio
      real(wp) :: early, late, scale
      integer :: first

      first = copy%middle%steps - copy%first%steps
      early = real(trial%last%steps - trial%first%steps, wp)
      late = (setup%limits%time_end - copy%middle%time)/(copy%last%time - copy%middle%time) &
         *real(copy%last%steps - copy%middle%steps, wp)
      scale = real(coarser, wp)
      if (first >= countable) scale = early/real(first, wp)*(copy%middle%time - copy%first%time) &
         /(trial%last%time - trial%first%time)
      steps = scale*late
   end function steps_left

   !> Ratio of cell sizes for which the copy runs about `copy_seconds`. If possible an integer
   !! number of its cells fits the grid.
   pure integer function cell_size_ratio(grid, seconds) result(coarser)
      type(grid_t), intent(in) :: grid               !! Grid of the run
      real(wp), intent(in) :: seconds                !! Linear estimate of the time of the run [s]
      integer :: target, trial, side

      target = ceiling((seconds/copy_seconds)**(1.0_wp/real(grid%dimensions + 1, wp)))
      target = min(max(target, 2), most_coarse)
      coarser = target
      do trial = 0, target
         side = merge(-(trial + 1)/2, trial/2, mod(trial, 2) == 1)
         if (target + side < 2) cycle
         if (any(mod(grid%cells, target + side) /= 0 .and. grid%active)) cycle
         coarser = target + side
         return
      end do
   end function cell_size_ratio

   !> Run a copy of the scene with larger cells.
   subroutine run_copy(setup, coarser, trial, copy, found)
      class(run_setup_t), intent(in) :: setup
      integer, intent(in) :: coarser                 !! Ratio of cell sizes
      type(trial_t), intent(in) :: trial             !! First steps of the run
      type(trial_t), intent(out) :: copy             !! Costs of the copy from the same times on
      logical, intent(out) :: found                  !! Did it run long enough?
      type(run_setup_t) :: small
      type(error_t), allocatable :: error

      found = .false.
      small%options = setup%options
      call small%read(a_scene, error)
      if (allocated(error)) return
      call set_up_scene(small%deck, small%simulation, small%bodies, small%shapes, coarser)
      if (.not. allocated(small%bodies)) return
      call take_survey(small%simulation, small%bodies, small%survey)
      call check_placement(small%deck, small%simulation, small%bodies, small%survey)
      call small%deck%verdict(error)
      if (allocated(error)) return
      call read_limits(small%deck, small%limits)
      small%limits%max_steps = huge(1_int64)
      call make_first_state(small%simulation, small%bodies, small%survey, small%shapes, error)
      if (allocated(error)) return
      call run_trial(small%simulation, small%limits, copy_patience, copy, trial%first%time, &
         trial%last%time)
      found = copy%middle%steps > copy%first%steps .and. copy%last%steps > copy%middle%steps
   end subroutine run_copy

   !> A duration in a suitable unit.
   pure function duration_text(seconds) result(text)
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
   end function duration_text
end module program_run_time_estimate
