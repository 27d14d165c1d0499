! SPDX-License-Identifier: BSD-3-Clause
!> Starts the time steps of a run where those of the run that wrote its points ended.
!!
!! Velocities of a snapshot are half of the last step behind its positions. The first forces must
!! lead from there to the middle of the first step: half a step alone, as at the start of other
!! runs, would leave an error of half an increment in the velocities for the whole run.
module scene_points_clock
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_reader, only: deck_t
   use particle_body, only: body_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_clocks, continue_clock

contains

   !> Does a body have its velocities from a snapshot?
   pure logical function has_clock(body, shapes) result(has)
      type(body_t), intent(in) :: body
      type(named_shape_t), intent(in) :: shapes(:)
      integer :: n

      has = .false.
      if (body%on_lattice()) return
      if (.not. allocated(shapes(body%region)%points)) return
      associate (points => shapes(body%region)%points)
         if (.not. points%snapshot) return
         do n = 1, size(points%list%fields)
            has = has .or. points%list%fields(n)%text == "velocity"
         end do
      end associate
   end function has_clock

   !> Warn of a snapshot whose velocities are of another time than the first step expects.
   subroutine check_clocks(deck, simulation, bodies, shapes)
      type(deck_t), intent(inout) :: deck            !! Collects warnings
      type(simulation_t), intent(in) :: simulation   !! Read for its method
      type(body_t), intent(in) :: bodies(:)
      type(named_shape_t), intent(in) :: shapes(:)
      real(wp), parameter :: little = 1.0e-9_wp
      real(wp) :: lag, taken
      integer :: n

      taken = 0.5_wp*step_before(simulation, bodies, shapes)
      do n = 1, size(bodies)
         if (.not. has_clock(bodies(n), shapes)) cycle
         lag = shapes(bodies(n)%region)%points%list%lag
         if (abs(lag - taken) <= little*max(lag, taken)) cycle
         call deck%warn("body", n, "the velocities of '"//shapes(bodies(n)%region)%points%path// &
            "' are "//brief(lag)//" s earlier than the positions, but the first step expects "// &
            brief(taken)//" s; use snapshots of one run and one time, and the same paper of "// &
            "&method [D418]", "region")
      end do
   end subroutine check_clocks

   !> Twice the time by which the velocities of the bodies are behind their positions, from the
   !! first snapshot; 0 if velocities and positions are of the same time [s].
   pure real(wp) function step_before(simulation, bodies, shapes) result(dt)
      type(simulation_t), intent(in) :: simulation   !! Read for its method
      type(body_t), intent(in) :: bodies(:)
      type(named_shape_t), intent(in) :: shapes(:)
      integer :: n

      dt = 0.0_wp
      if (.not. simulation%scheme%method%leapfrog .or. allocated(simulation%effects%exact)) return
      do n = 1, size(bodies)
         if (.not. has_clock(bodies(n), shapes)) cycle
         dt = 2.0_wp*shapes(bodies(n)%region)%points%list%lag
         return
      end do
   end function step_before

   !> Set the previous time step, and the first one to the next step of the run that wrote the
   !! snapshot, unless this exceeds the allowed growth over the step that the particles permit.
   subroutine continue_clock(simulation, bodies, shapes)
      type(simulation_t), intent(inout) :: simulation !! The run, its first step is known
      type(body_t), intent(in) :: bodies(:)
      type(named_shape_t), intent(in) :: shapes(:)
      real(wp) :: dt
      integer :: n

      simulation%clock%dt = step_before(simulation, bodies, shapes)
      dt = huge(dt)
      do n = 1, size(bodies)
         if (.not. has_clock(bodies(n), shapes)) cycle
         associate (next => shapes(bodies(n)%region)%points%list%dt_next)
            if (next > 0.0_wp) dt = min(dt, next)
         end associate
      end do
      if (dt <= simulation%scheme%method%step_growth*simulation%clock%dt_next) &
         simulation%clock%dt_next = dt
   end subroutine continue_clock
end module scene_points_clock
