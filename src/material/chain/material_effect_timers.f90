! SPDX-License-Identifier: BSD-3-Clause
!> Time of each effect of the material update, as a part of the phase from nodes to particles. In
!! every 32nd step each stage is timed for each tile; these samples divide the time of the phase at
!! the end. In tiles with one or two particles, timing every step would cost as much as the stages.
module material_effect_timers
   use base_kinds, only: int64, wp
   use base_timer, only: timer_t, wall_seconds
   use material_failed, only: failed_subset_t
   use material_stages, only: effect_count, effect_of_stage, stage_count
   use material_state, only: deformation_t, material_state_t
   use material_update, only: chain_t
   implicit none
   private

   public :: stage_clock_t, divide_phase_time

   integer(int64), parameter :: every = 32           !! Steps between timed steps

   !> Samples of one thread.
   type :: stage_clock_t
      logical :: on = .false.                        !! True if this step is timed
      real(wp) :: whole = 0.0_wp                     !! Nodes to particles in those steps [s]
      real(wp) :: effect(effect_count) = 0.0_wp      !! Each effect in them [s]
   contains
      procedure :: start_step => stage_clock_start_step !! Decides whether a step is timed
      procedure :: read_clock => stage_clock_read    !! Clock at the start of a tile
      procedure :: record => stage_clock_record      !! Adds the work on a tile since then
      procedure :: update => stage_clock_update      !! Material update, stage by stage
   end type stage_clock_t

contains

   !> Decide whether a step is timed.
   pure subroutine stage_clock_start_step(self, step)
      class(stage_clock_t), intent(inout) :: self
      integer(int64), intent(in) :: step             !! Steps done

      self%on = modulo(step, every) == 0
   end subroutine stage_clock_start_step

   !> Clock at the start of the work on a tile; 0 in steps that are not timed [s].
   real(wp) function stage_clock_read(self) result(seconds)
      class(stage_clock_t), intent(in) :: self

      seconds = 0.0_wp
      if (self%on) seconds = wall_seconds()
   end function stage_clock_read

   !> Add the work on a tile since a reading of the clock.
   subroutine stage_clock_record(self, began)
      class(stage_clock_t), intent(inout) :: self
      real(wp), intent(in) :: began                  !! Clock at the start [s]

      if (self%on) self%whole = self%whole + wall_seconds() - began
   end subroutine stage_clock_record

   !> Material update of a range of particles; in steps that are timed the clock is read after each
   !! stage.
   subroutine stage_clock_update(self, chain, state, deformation, first, last, dt, spacing)
      class(stage_clock_t), intent(inout) :: self
      class(chain_t), intent(in) :: chain
      type(material_state_t), intent(inout) :: state        !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: spacing                !! Cell size [m]
      type(failed_subset_t) :: subset
      real(wp) :: began, now
      integer :: stage

      if (last < first) return
      if (.not. self%on) then
         call chain%update(state, deformation, first, last, dt, spacing)
         return
      end if
      began = wall_seconds()
      do stage = 1, stage_count
         call chain%run_stage(stage, state, deformation, first, last, dt, spacing, subset)
         now = wall_seconds()
         associate (effect => self%effect(effect_of_stage(stage)))
            effect = effect + now - began
         end associate
         began = now
      end do
   end subroutine stage_clock_update

   !> Subtract the time of each effect with a separate row from the phase that includes it.
   subroutine divide_phase_time(laps, from, rows, timer)
      type(stage_clock_t), intent(in) :: laps(:)    !! Times of all threads
      integer, intent(in) :: from                    !! The phase that holds them all
      integer, intent(in) :: rows(effect_count)     !! Phase of each effect, 0 = off
      type(timer_t), intent(inout) :: timer
      real(wp) :: whole, seconds
      integer :: effect, thread

      whole = sum(laps%whole)
      if (.not. whole > 0.0_wp) return
      seconds = timer%seconds(from)
      do effect = 1, effect_count
         if (rows(effect) > 0) call timer%move(from, rows(effect), &
            seconds*sum([(laps(thread)%effect(effect), thread=1, size(laps))])/whole)
      end do
   end subroutine divide_phase_time
end module material_effect_timers
