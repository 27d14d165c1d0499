! SPDX-License-Identifier: BSD-3-Clause
!> Limits of a run, read from the deck: its end, the bounds of the time step, and the intervals of
!! checkpoints and progress lines.
module run_limits
   use base_constants, only: unset
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use scene_parallel, only: read_balancing
   use scene_time, only: read_time_limits, time_limits_t
   use step_load_balance, only: balancing_t
   implicit none
   private

   public :: limits_t, read_limits

   !> Limits of a run: those of &time, and the intervals of checkpoints, progress lines and load
   !! balancing.
   type, extends(time_limits_t) :: limits_t
      real(wp) :: checkpoint_wall = huge(1.0_wp)     !! Wall time between checkpoints [s]
      real(wp) :: checkpoint_time = 0.0_wp           !! Simulated time between them, 0 = none [s]
      logical :: checkpoint_at_end = .false.         !! Write one at the end as well?
      character(len=:), allocatable :: signals(:)    !! Signals that end the run with a checkpoint
      real(wp) :: progress = 0.0_wp                  !! Wall time between progress lines [s]
      type(balancing_t) :: balancing                 !! When tiles move between ranks
   end type limits_t

contains

   !> Read the limits of a run.
   subroutine read_limits(deck, limits)
      type(deck_t), intent(in) :: deck               !! Without errors
      type(limits_t), intent(out) :: limits          !! In SI units
      type(group_t) :: group
      real(wp) :: number

      call read_time_limits(deck, limits%time_limits_t)
      group = deck%group("checkpoint", 1)
      call group%get("wall_minutes", number)
      if (number > 0.0_wp) limits%checkpoint_wall = 60.0_wp*number
      call group%get("dt", number)
      if (number > unset) limits%checkpoint_time = number
      call group%get("at_end", limits%checkpoint_at_end)
      call group%get("on_signal", limits%signals)
      group = deck%group("log", 1)
      call group%get("progress_seconds", limits%progress)
      call read_balancing(deck, limits%balancing)
   end subroutine read_limits
end module run_limits
