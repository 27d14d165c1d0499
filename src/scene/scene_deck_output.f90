! SPDX-License-Identifier: BSD-3-Clause
!> Keys of the deck that say what is written.
module scene_deck_output
   use base_schema, only: schema_t
   implicit none
   private

   public :: declare_checkpoint, declare_log, declare_output

   character(len=*), parameter :: files = "kind = particles slice grid" !! Outputs of many files
   character(len=*), parameter :: points = "kind = particles slice" !! Outputs of single particles
   character(len=*), parameter :: state = "kind = particles slice grid profile fragments"

contains

   !> Declare &output.
   subroutine declare_output(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("output", "one stream of files; give one of dt, every, times, count", &
         many=.true.)
      call schema%text("output", "name", "name of the stream")
      call schema%text("output", "kind", "what is written: particles, those near a plane, "// &
         "means on cells, the ledger, means in bins along an axis, or a table of fragments", &
         words="particles slice grid history profile fragments")
      call schema%real("output", "dt", "time between two outputs", unit="s", range="> 0")
      call schema%integer("output", "every", "steps between two outputs", range="> 0")
      call schema%real("output", "times(:50)", "times of output", unit="s", range=">= 0")
      call schema%integer("output", "count", "number of outputs, evenly over t_end", range="> 0")
      call schema%text("output", "fields(:40)", "names from scree --list fields; default: "// &
         "the usual ones; state: all from which another run can go on", &
         default="default", owner="kind = particles slice grid history profile")
      call schema%text("output", "bodies(:20)", "only points of these bodies; default: all", &
         owner=state)
      call schema%text("output", "region", "only points in this region; default: everywhere", &
         owner=state)
      call schema%integer("output", "stride", "every so many points, by identity", default="1", &
         range="> 0", owner=points)
      call schema%text("output", "axis", "normal of the plane of a slice; direction of a profile", &
         default="x", words="x y z", owner="kind = slice profile")
      call schema%real("output", "at", "where the plane is; points within half a cell of it", &
         unit="m", owner="kind = slice")
      call schema%integer("output", "bins", "bins of equal width from one end of the grid to "// &
         "the other", default="100", range="> 0 <= 10000", owner="kind = profile")
      call schema%real("output", "velocity_cut", "cells part where their mean velocities "// &
         "differ by more; default: never", unit="m/s", range="> 0", owner="kind = fragments")
      call schema%text("output", "matter", "what fragments are made of; intact: what has not "// &
         "failed", default="all", words="all intact", owner="kind = fragments")
      call schema%text("output", "precision", "kind of numbers", default="single", &
         words="single double", owner=files)
      call schema%integer("output", "compress", "level of gzip, 0 = off", default="1", &
         range=">= 0 <= 9", owner=files)
      call schema%require("output", "name kind at")
      call schema%refer("output", "bodies", "body")
      call schema%refer("output", "region", "region")
   end subroutine declare_output

   !> Declare &checkpoint.
   subroutine declare_checkpoint(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("checkpoint", "restart files")
      call schema%real("checkpoint", "wall_minutes", &
         "minutes of wall time between two; 0 = never", &
         default="30.0", range=">= 0")
      call schema%real("checkpoint", "dt", "simulated time between two", unit="s", range="> 0")
      call schema%integer("checkpoint", "keep", "number of files kept; 0 = all", default="2", &
         range=">= 0")
      call schema%logical("checkpoint", "at_end", "write one at the end", default=".true.")
      call schema%text("checkpoint", "on_signal(:4)", &
         "signals that ask for a checkpoint and exit "// &
         "code 75", default="TERM USR1 INT", words="TERM USR1 USR2 INT HUP none")
   end subroutine declare_checkpoint

   !> Declare &log.
   subroutine declare_log(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("log", "screen and log file")
      call schema%real("log", "progress_seconds", "wall time between two lines of progress", &
         default="10.0", range="> 0")
      call schema%text("log", "level", "what the log file holds", default="info", &
         words="error warn info debug")
      call schema%logical("log", "timing", "table of phases at the end", default=".true.")
   end subroutine declare_log
end module scene_deck_output
