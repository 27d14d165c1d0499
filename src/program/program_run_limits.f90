! SPDX-License-Identifier: BSD-3-Clause
!> Limits of a run, read from the deck: its end, the bounds of the time step, and the intervals of
!! checkpoints and progress lines.
module program_run_limits
   use base_clock, only: clock_seconds, is_clock
   use base_constants, only: unset
   use base_deck, only: deck_t, group_t
   use base_deck_group, only: unset_integer
   use base_kinds, only: int64, wp
   use scene_load_balance, only: read_balancing
   use step_load_balance, only: balancing_t
   implicit none
   private

   public :: limits_t, read_limits

   !> Limits of a run.
   type :: limits_t
      real(wp) :: time_end = 0.0_wp                  !! [s]
      real(wp) :: dt_max = huge(1.0_wp)              !! Greatest time step [s]
      real(wp) :: dt_min = 0.0_wp                    !! A smaller time step is an error [s]
      real(wp) :: dt_fixed = 0.0_wp                  !! Constant time step, 0 = the stable one [s]
      integer(int64) :: max_steps = huge(1_int64)    !! Greatest number of steps
      real(wp) :: wall_limit = huge(1.0_wp)          !! Greatest wall time [s]
      logical :: use_job_end = .false.             !! Is the wall time that of the Slurm job?
      real(wp) :: kinetic_below = -1.0_wp            !! Stop below this kinetic energy [J]
      real(wp) :: rest_below = -1.0_wp               !! Stop below this fraction of its maximum [1]
      real(wp) :: checkpoint_wall = huge(1.0_wp)     !! Wall time between checkpoints [s]
      real(wp) :: checkpoint_time = 0.0_wp           !! Simulated time between them, 0 = none [s]
      logical :: checkpoint_at_end = .true.          !! Write one at the end as well?
      character(len=:), allocatable :: signals(:)    !! Signals that end the run with a checkpoint
      real(wp) :: progress = 10.0_wp                 !! Wall time between progress lines [s]
      type(balancing_t) :: balancing                 !! When tiles move between ranks
   end type limits_t

contains

   !> Read the limits of a run.
   subroutine read_limits(deck, limits)
      type(deck_t), intent(in) :: deck               !! Without errors
      type(limits_t), intent(out) :: limits          !! In SI units
      type(group_t) :: group
      character(len=:), allocatable :: word
      real(wp) :: number
      integer :: steps

      group = deck%group("time", 1)
      call group%get("t_end", limits%time_end)
      call group%get("dt_max", number)
      if (number > unset) limits%dt_max = number
      call group%get("dt_min", number)
      if (number > unset) limits%dt_min = number
      call group%get("dt_fixed", number)
      if (number > unset) limits%dt_fixed = number
      call group%get("max_steps", steps)
      if (steps /= unset_integer) limits%max_steps = steps
      call group%get("wall_limit", word)
      if (is_clock(word)) limits%wall_limit = real(clock_seconds(word), wp)
      limits%use_job_end = word == "slurm"
      call group%get("stop_when", word)
      if (word == "kinetic_below") call group%get("stop_value", limits%kinetic_below)
      if (word == "at_rest") call group%get("stop_value", limits%rest_below)
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
end module program_run_limits
