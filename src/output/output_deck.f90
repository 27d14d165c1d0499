! SPDX-License-Identifier: BSD-3-Clause
!> The groups &output, &checkpoint and &log: declared and checked. The keys of a kind of output
!! belong to its own module.
module output_deck
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_extent, changes_nothing, schema_t
   use output_catalogue, only: choose_stream, stream_names
   use output_field_names, only: check_field_names
   use output_schedule, only: check_schedule, declare_schedule
   use output_stream, only: stream_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_output_fields, check_output_groups, declare_output_groups

contains

   !> Declare the three groups.
   subroutine declare_output_groups(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys

      call declare_output(schema)
      call declare_checkpoint(schema)
      call declare_log(schema)
   end subroutine declare_output_groups

   !> Declare &output: keys of all kinds, then those of each.
   subroutine declare_output(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      class(stream_t), allocatable :: stream
      character(len=:), allocatable :: kinds
      integer :: n

      kinds = ""
      do n = 1, size(stream_names)
         call choose_stream(stream_names(n), stream)
         kinds = kinds//merge("; ", ", ", n == 1)//trim(stream_names(n))//": "//stream%about()
      end do
      call schema%group("output", "one output stream; give one of dt, every, times, count", &
         many=.true.)
      call schema%text("output", "name", "name of the stream, part of file names")
      call schema%text("output", "kind", "what is written"//kinds)
      call schema%words("output", "kind", stream_names)
      call schema%require("output", "name kind")
      call declare_schedule(schema)
      do n = 1, size(stream_names)
         call choose_stream(stream_names(n), stream)
         call stream%declare(schema, trim(stream_names(n)))
      end do
      call schema%allow_change("output", "* + -", changes_extent)
   end subroutine declare_output

   !> Declare &checkpoint.
   subroutine declare_checkpoint(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys

      call schema%group("checkpoint", "restart files")
      call schema%real("checkpoint", "wall_minutes", &
         "wall time between two checkpoints in minutes; 0 = never", default="30.0", range=">= 0")
      call schema%real("checkpoint", "dt", "simulated time between two checkpoints", unit="s", &
         range="> 0")
      call schema%integer("checkpoint", "keep", "number of checkpoints kept; 0 = all", &
         default="2", range=">= 0")
      call schema%logical("checkpoint", "at_end", "write a checkpoint at the end", default=".true.")
      call schema%text("checkpoint", "on_signal(:4)", "signals that request a checkpoint and "// &
         "exit code 75", default="TERM USR1 INT", words="TERM USR1 USR2 INT HUP none")
      call schema%allow_change("checkpoint", "*", changes_nothing)
   end subroutine declare_checkpoint

   !> Declare &log.
   subroutine declare_log(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys

      call schema%group("log", "screen output and log file")
      call schema%real("log", "progress_seconds", &
         "wall time between two progress lines, in seconds", default="10.0", range="> 0")
      call schema%text("log", "level", "level of the log file", default="info", &
         words="error warn info")
      call schema%logical("log", "timing", "print a table of timings at the end", default=".true.")
      call schema%allow_change("log", "*", changes_nothing)
   end subroutine declare_log

   !> Check keys of &output and &checkpoint against other keys.
   subroutine check_output_groups(deck)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      integer :: n

      call check_checkpoint(deck)
      do n = 1, deck%count("output")
         call check_schedule(deck, deck%group("output", n))
      end do
   end subroutine check_output_groups

   !> Refuse checkpoints at intervals so short that writing them would dominate the run.
   subroutine check_checkpoint(deck)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      real(wp), parameter :: most = 1.0e6_wp         ! checkpoints
      real(wp) :: dt, t_end
      type(group_t) :: checkpoint, time

      checkpoint = deck%group("checkpoint")
      time = deck%group("time")
      if (.not. (checkpoint%known("dt") .and. time%known("t_end"))) return
      call checkpoint%get("dt", dt)
      call time%get("t_end", t_end)
      if (t_end/most > dt) call deck%add_error(checkpoint, "dt gives "//brief(t_end/dt)// &
         " checkpoints until t_end; use a longer dt, or wall_minutes [D438]", "dt")
   end subroutine check_checkpoint

   !> Check the names of fields in a deck with errors that leave the stores of the scene unknown.
   subroutine check_output_fields(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Possibly incomplete after errors
      class(stream_t), allocatable :: stream
      type(group_t) :: group
      character(len=:), allocatable :: word
      integer :: n

      do n = 1, deck%count("output")
         group = deck%group("output", n)
         call group%get("kind", word)
         call choose_stream(word, stream)
         if (allocated(stream)) call check_field_names(group, deck, simulation, stream)
      end do
   end subroutine check_output_fields
end module output_deck
