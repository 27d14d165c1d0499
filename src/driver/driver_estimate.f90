! SPDX-License-Identifier: BSD-3-Clause
!> How long a run will take: its first steps are done and timed, and a copy of the scene with larger
!! cells is run to its end, which shows by how much time becomes dearer as it goes on: steps shorten
!! where matter is struck, and cost more where it spreads over many tiles.
module driver_estimate
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: number
   use driver_begin, only: begin_run
   use driver_check_scene, only: check_places
   use driver_output, only: snapshot_bytes
   use driver_plan, only: plan_t, read_plan
   use driver_run, only: read_limits
   use driver_scene, only: build_scene
   use driver_start, only: take_survey
   use driver_trial, only: row_seconds, trial_t, try_steps, warm_steps
   use mesh_grid, only: grid_t
   use omp_lib, only: omp_get_max_threads
   implicit none
   private

   public :: estimate_text

   integer(int64), parameter, public :: most_particles = 2000000_int64 !! A login node bears them
   real(wp), parameter :: patience = 2.0_wp          !! Wall time for the first steps [s]
   real(wp), parameter :: copy_patience = 6.0_wp     !! The same for the copy [s]
   real(wp), parameter :: copy_seconds = 1.5_wp      !! That it should take if nothing changes [s]
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
      real(wp) :: row, seconds, steps

      text = ""
      call begin_run(plan%simulation, plan%bodies, plan%survey, plan%shapes, error)
      if (allocated(error)) return
      row = row_seconds(plan%simulation)
      call try_steps(plan%simulation, plan%limits, patience, trial)
      if (trial%last%steps == 0) return
      if (trial%last%steps <= warm_steps .and. .not. trial%whole) return
      seconds = trial%last%seconds
      steps = real(trial%last%steps, wp)
      basis = "all of them"
      if (.not. trial%whole) call extend(plan, trial, seconds, steps, basis)
      seconds = seconds + row*plan%outputs%rows(plan%limits%time_end, steps) &
         + real(plan%outputs%expected(plan%limits%time_end), wp)*snapshot_bytes &
         *real(plan%survey%particles, wp)/snapshot_speed
      write (line, "(a,i0,a,i0,a,es8.1,a)") " on 1 rank x ", omp_get_max_threads(), &
         " threads, from ", trial%last%steps, " steps of ", trial%last%seconds &
         /real(trial%last%steps, wp), " s, "
      text = "estimate   "//span_text(seconds)//trim(line)//" "//basis//new_line("a")
   end subroutine estimate_text

   !> Seconds and steps of the whole run from those of its first steps.
   subroutine extend(plan, trial, seconds, steps, basis)
      class(plan_t), intent(in) :: plan              !! The run
      type(trial_t), intent(in) :: trial             !! Its first steps
      real(wp), intent(inout) :: seconds             !! Of the first steps in, of the run out [s]
      real(wp), intent(inout) :: steps               !! The same
      character(len=:), allocatable, intent(out) :: basis !! What it rests on
      type(trial_t) :: copy
      real(wp) :: left, rest, more, most
      integer :: coarser
      logical :: found

      left = (plan%limits%time_end - trial%last%time)/(trial%last%time - trial%first%time)
      rest = left*(trial%last%seconds - trial%first%seconds)
      more = left*real(trial%last%steps - trial%first%steps, wp)
      basis = "as if all others cost the same"
      coarser = wished_cells(plan%simulation%grid, rest)
      do
         call run_copy(plan, coarser, trial, copy, found)
         if (found .or. coarser == 2) exit
         ! thin bodies may have no particles left; smaller cells keep more of them
         coarser = max(coarser/2, 2)
      end do
      if (found) then
         basis = "and a copy with cells "//number(coarser)//" times as large"
         if (.not. copy%whole) basis = basis//", not run to its end"
         associate (early => copy%middle%time - copy%first%time, &
            late => copy%last%time - copy%middle%time)
            rest = rest*(copy%last%seconds - copy%middle%seconds)/late &
               *early/(copy%middle%seconds - copy%first%seconds)
            more = more*real(copy%last%steps - copy%middle%steps, wp)/late &
               *early/real(copy%middle%steps - copy%first%steps, wp)
         end associate
      end if
      seconds = seconds + rest
      steps = steps + more
      most = real(plan%limits%max_steps, wp)
      if (steps <= most) return
      seconds = seconds*most/steps
      steps = most
   end subroutine extend

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
end module driver_estimate
