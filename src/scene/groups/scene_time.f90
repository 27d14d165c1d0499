! SPDX-License-Identifier: BSD-3-Clause
!> The group &time: its keys, their checks, and the limits of steps and of the simulation.
module scene_time
   use base_clock, only: clock_seconds, is_clock
   use base_constants, only: unset
   use base_kinds, only: int64, wp
   use deck_group_values, only: unset_integer
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_end, changes_extent, changes_nothing, changes_physics, schema_t
   use step_bounds, only: bounds_t
   implicit none
   private

   public :: check_time, declare_time, read_bounds, read_time_limits, time_limits_t

   !> Length of steps and end of the simulation.
   type :: time_limits_t
      real(wp) :: time_end = 0.0_wp                  !! [s]
      real(wp) :: dt_max = huge(1.0_wp)              !! Greatest time step [s]
      real(wp) :: dt_min = 0.0_wp !! Least time step; a smaller one is an error [s]
      real(wp) :: dt_fixed = 0.0_wp                  !! The time step, 0 = the stable one [s]
      integer(int64) :: max_steps = huge(1_int64)    !! Steps after which the simulation ends
      real(wp) :: wall_limit = huge(1.0_wp)          !! Wall time after which it ends [s]
      logical :: query_scheduler = .false.           !! Is the wall time that of the Slurm job?
      real(wp) :: kinetic_below = -1.0_wp            !! It ends at a kinetic energy below this [J]
      real(wp) :: rest_below = -1.0_wp               !! ... below this fraction of the greatest [1]
      real(wp) :: unbalanced_below = -1.0_wp         !! ... below this ratio of forces [1]
      character(len=:), allocatable :: quantity      !! ... at a level of this TABLE.COLUMN
      real(wp) :: level = 0.0_wp                     !! Level of the quantity [unit of the column]
      logical :: above = .false.                     !! Does it end above the level?
   end type time_limits_t

contains

   !> Declare &time.
   subroutine declare_time(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("time", "time stepping")
      call schema%real("time", "t_end", "end of the simulated time", unit="s", range="> 0")
      call schema%real("time", "cfl", "factor on the stable time step (Courant number)", &
         default="0.4", range="> 0 <= 1")
      call schema%real("time", "dt_max", "upper limit of the time step", unit="s", range="> 0")
      call schema%real("time", "dt_min", &
         "lower limit of the time step; a smaller one ends the run with exit code 4", unit="s", &
         range="> 0")
      call schema%real("time", "dt_fixed", &
         "fixed time step, in place of cfl times the stable one", unit="s", range="> 0")
      call schema%real("time", "dt_collapse", "a stable step below this fraction of the "// &
         "longest one so far ends the run with exit code 4", default="1e-3", range=">= 0 < 1")
      call schema%real("time", "strain_max", "greatest strain and rotation of a particle in "// &
         "one step; the step is shortened to stay below it", default="0.3", range="> 0 <= 1")
      call schema%logical("time", "retry", "repeat a step with a shorter time step if a node "// &
         "would move by more than half a cell, or the strain of a cell would exceed twice "// &
         "strain_max", default=".true.")
      call schema%real("time", "speed_max", &
         "speed limit: a faster particle ends the run with exit code 4", unit="m/s", range="> 0")
      call schema%real("time", "volume_ratio_min", "least volume of a particle over its volume "// &
         "at rest; a smaller one ends the run with exit code 4", default="1e-3", range=">= 0 < 1")
      call schema%real("time", "volume_ratio_max", "greatest volume of a particle over its "// &
         "volume at rest; a larger one ends the run with exit code 4", default="1e12", range="> 1")
      call schema%text("time", "on_bad", "action for a particle that exceeds speed_max, "// &
         "volume_ratio_min or volume_ratio_max: stop ends the run; retire removes and "// &
         "records the particle", &
         default="stop", words="stop retire")
      call schema%real("time", "retire_max", &
         "fraction of the initial mass that may be retired; more ends the run with exit code 4", &
         default="0.01", range=">= 0 <= 1", owner="on_bad = retire")
      call schema%integer("time", "max_steps", "number of steps after which the run stops", &
         range=">= 0")
      call schema%text("time", "wall_limit", "limit of the wall time as hh:mm:ss, or slurm for "// &
         "the end of the job; then a checkpoint is written and the exit code is 75", default="none")
      call schema%text("time", "stop_when", "condition for an early end, with stop_value: "// &
         "kinetic_below, low kinetic energy; at_rest, low kinetic energy relative to its "// &
         "maximum; balanced, forces in balance; above and below, stop_quantity above or below "// &
         "stop_level", default="never", words="never kinetic_below at_rest balanced above below")
      call schema%real("time", "stop_value", "threshold: kinetic_below: energy in J; at_rest: "// &
         "fraction of the greatest kinetic energy; balanced: unbalanced force over the force "// &
         "of stress", range="> 0", owner="stop_when = kinetic_below at_rest balanced")
      call schema%text("time", "stop_quantity", "column of a table that an &output of the deck "// &
         "writes, as TABLE.COLUMN: gauge.velocity_x", owner="stop_when = above below")
      call schema%real("time", "stop_level", "level of stop_quantity in the unit of the "// &
         "column in SI", owner="stop_when = above below")
      call schema%require("time", "t_end stop_value stop_quantity stop_level")
      call schema%allow_change("time", "t_end max_steps stop_when stop_value "// &
         "stop_quantity stop_level", changes_end)
      call schema%allow_change("time", "dt_min dt_collapse speed_max volume_ratio_min "// &
         "volume_ratio_max on_bad retire_max", changes_extent)
      call schema%allow_change("time", "cfl dt_max dt_fixed strain_max retry", changes_physics)
      call schema%allow_change("time", "wall_limit", changes_nothing)
   end subroutine declare_time

   !> Steps and limits of time.
   subroutine check_time(deck)
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: limit
      real(wp) :: dt_fixed, dt_max, dt_min
      type(group_t) :: time

      time = deck%group("time")
      call time%get("dt_min", dt_min)
      call time%get("dt_max", dt_max)
      call time%get("dt_fixed", dt_fixed)
      if (time%given("dt_max") .and. time%valid(["dt_max"]) .and. dt_max <= dt_min) &
         call deck%add_error(time, "dt_max must be above dt_min [D312]", "dt_max")
      if (time%given("dt_fixed") .and. time%valid(["dt_fixed"])) then
         if (dt_fixed < dt_min) call deck%add_error(time, "dt_fixed is below dt_min [D313]", &
            "dt_fixed")
         if (time%given("dt_max")) call deck%add_error(time, &
            "dt_fixed and dt_max are both given; keep one [D307]", "dt_fixed")
         if (time%given("cfl")) call deck%warn(time, "cfl is not used, as dt_fixed is "// &
            "given [D314]", "cfl")
      end if
      call time%get("wall_limit", limit)
      if (time%given("wall_limit") .and. limit /= "none" .and. limit /= "slurm" .and. &
         limit /= "") then
         if (.not. is_clock(limit)) call deck%add_error(time, "wall_limit = '"//limit// &
            "' must be 'none', 'slurm', or hours, minutes and seconds such as '03:30:00' [D216]", &
            "wall_limit")
      end if
   end subroutine check_time

   !> Read the bounds of steps and particles, and the CFL number.
   subroutine read_bounds(deck, bounds, cfl)
      type(deck_t), intent(in) :: deck
      type(bounds_t), intent(out) :: bounds          !! Bounds of every step
      real(wp), intent(out) :: cfl                   !! Fraction of the stable step [1]
      type(group_t) :: group
      character(len=:), allocatable :: word
      real(wp) :: number

      group = deck%group("time", 1)
      call group%get("cfl", cfl)
      call group%get("volume_ratio_min", bounds%ratio_min)
      call group%get("volume_ratio_max", bounds%ratio_max)
      call group%get("speed_max", number)
      if (number > unset) bounds%speed_max = number
      call group%get("strain_max", bounds%strain_max)
      call group%get("dt_collapse", bounds%collapse)
      call group%get("dt_min", number)
      if (number > unset) bounds%dt_min = number
      call group%get("dt_fixed", number)
      if (number > unset) bounds%dt_fixed = number
      call group%get("retry", bounds%dt_free)
      if (number > unset) bounds%dt_free = .false.
      call group%get("on_bad", word)
      bounds%retire = word == "retire"
      call group%get("retire_max", bounds%retire_max)
   end subroutine read_bounds

   !> Read the length of steps and the end of the simulation.
   subroutine read_time_limits(deck, limits)
      type(deck_t), intent(in) :: deck               !! Without errors
      type(time_limits_t), intent(out) :: limits     !! Huge or 0 where the deck sets none
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
      limits%query_scheduler = word == "slurm"
      call group%get("stop_when", word)
      if (word == "kinetic_below") call group%get("stop_value", limits%kinetic_below)
      if (word == "at_rest") call group%get("stop_value", limits%rest_below)
      if (word == "balanced") call group%get("stop_value", limits%unbalanced_below)
      limits%quantity = ""
      limits%above = word == "above"
      if (.not. (limits%above .or. word == "below")) return
      call group%get("stop_quantity", limits%quantity)
      call group%get("stop_level", limits%level)
   end subroutine read_time_limits
end module scene_time
