! SPDX-License-Identifier: BSD-3-Clause
!> All groups of a deck and the keys that are not those of materials.
module scene_deck_schema
   use base_schema, only: schema_t
   use base_text, only: number
   use base_units, only: system_names
   use base_version, only: version_text
   use scene_deck_groups, only: declare_body, declare_boundary, declare_contact, declare_region
   use scene_deck_output, only: declare_checkpoint, declare_log, declare_output, declare_parallel
   implicit none
   private

   public :: declare_deck

   !> Format of decks. It rises where a deck of before would mean something else without a word;
   !! names that were given up are told by the reader anyway.
   integer, parameter, public :: deck_version = 1

contains

   !> Declare the groups in the order of the echo, and their keys. Those of &material and the ones
   !! of
   !! &effects that concern materials are added by the materials themselves, those of &method by the
   !! methods, those of &exact by the solutions.
   subroutine declare_deck(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("include", "read more groups from another file", many=.true.)
      call schema%text("include", "file", "path, relative to the file that includes it")
      call schema%group("define", "names for numbers that expressions in braces use: {2*name}", &
         many=.true.)
      call declare_run(schema)
      call declare_units(schema)
      call declare_grid(schema)
      call declare_time(schema)
      call schema%group("method", "numerical method")
      call declare_effects(schema)
      call schema%group("material", "one material; flat keys, prefix = model", many=.true.)
      call declare_region(schema)
      call declare_body(schema)
      call declare_boundary(schema)
      call declare_contact(schema)
      call schema%group("exact", "a solution that is known: it gives the first state and, if "// &
         "it was made up, a body force; histories get its errors")
      call declare_output(schema)
      call declare_checkpoint(schema)
      call declare_parallel(schema)
      call declare_log(schema)
   end subroutine declare_deck

   !> Declare &run.
   subroutine declare_run(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("run", "identity and problem class")
      call schema%text("run", "title", "one line, goes into every output", default="untitled")
      call schema%text("run", "case", "prefix of all output files; default: name of the deck")
      call schema%text("run", "dimension", &
         "problem class; plane_strain and axisymmetric use x and z", &
         default="3d", words="3d plane_strain axisymmetric 1d")
      call schema%text("run", "method", "gradient of the node functions", default="ddmp", &
         words="ddmp mpm")
      call schema%integer("run", "deck_version", "format of this deck", default="1", &
         range="> 0 <= "//number(deck_version))
      call schema%explain_range("run", "deck_version", "this is scree "//version_text//", "// &
         "which knows decks up to deck_version "//number(deck_version)//"; a deck of a "// &
         "higher one needs a later scree")
   end subroutine declare_run

   !> Declare &units.
   subroutine declare_units(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("units", "units of the numbers in this deck, and of those in outputs")
      call schema%text("units", "system", &
         "length-time-mass; temperature in K and angles in degrees "// &
         "always", default="si")
      call schema%words("units", "system", system_names)
      call schema%text("units", "output_units", "units of the numbers in snapshots and tables: "// &
         "deck: those of this deck, or a system; each is named in the files", default="si", &
         words="deck")
      call schema%words("units", "output_units", system_names)
   end subroutine declare_units

   !> Declare &grid.
   subroutine declare_grid(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("grid", "background grid")
      call schema%real("grid", "lo(3)", "lower corner", unit="m")
      call schema%real("grid", "hi(3)", "upper corner", unit="m")
      call schema%real("grid", "dx", "edge of a cell; (hi-lo)/dx must be whole", unit="m", &
         range="> 0")
      call schema%integer("grid", "cells(3)", "cells along x, y, z instead of dx", range="> 0")
      call schema%integer("grid", "block", "cells along the edge of a tile, 0 = automatic", &
         default="0", range=">= 0 <= 64")
      call schema%require("grid", "lo hi")
   end subroutine declare_grid

   !> Declare &time.
   subroutine declare_time(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("time", "time stepping")
      call schema%real("time", "t_end", "end of simulated time", unit="s", range="> 0")
      call schema%real("time", "cfl", "fraction of the stable step", default="0.4", &
         range="> 0 <= 1")
      call schema%real("time", "dt_max", "upper bound of the step", unit="s", range="> 0")
      call schema%real("time", "dt_min", "a smaller step ends the run with exit code 4", unit="s", &
         range="> 0")
      call schema%real("time", "dt_fixed", "the step, whatever cfl says", unit="s", range="> 0")
      call schema%real("time", "dt_collapse", "a stable step below this share of the longest "// &
         "so far ends the run with exit code 4", default="1e-3", range=">= 0 < 1")
      call schema%real("time", "strain_max", "greatest strain and rotation of a particle in a "// &
         "step; shorter steps where more would come", default="0.3", range="> 0 <= 1")
      call schema%logical("time", "retry", "a step in which nodes would move by more than half "// &
         "a cell, or part by more than twice strain_max of one, is done again with a shorter "// &
         "time", &
         default=".true.")
      call schema%real("time", "speed_max", "a faster particle ends the run with exit code 4", &
         unit="m/s", range="> 0")
      call schema%real("time", "volume_ratio_min", "a particle of less than this share of its "// &
         "volume at rest ends the run with exit code 4", default="1e-3", range=">= 0 < 1")
      call schema%real("time", "volume_ratio_max", "a particle of more ends it too", &
         default="1e12", range="> 1")
      call schema%text("time", "on_bad", "what becomes of a particle that leaves these bounds: "// &
         "it ends the run, or is taken out and booked", default="stop", words="stop retire")
      call schema%real("time", "retire_max", "share of the mass at the start that may be taken "// &
         "out so before the run ends with exit code 4", default="0.01", range=">= 0 <= 1", &
         owner="on_bad = retire")
      call schema%integer("time", "max_steps", "stop after so many steps", range=">= 0")
      call schema%text("time", "wall_limit", "hh:mm:ss of wall time, or slurm for the end of "// &
         "the job, then checkpoint and exit code 75", default="none")
      call schema%text("time", "stop_when", "early end", default="never", &
         words="never kinetic_below at_rest")
      call schema%real("time", "stop_value", &
         "kinetic_below: energy in J; at_rest: fraction of the "// &
         "greatest kinetic energy", range="> 0", owner="stop_when = kinetic_below at_rest")
      call schema%require("time", "t_end stop_value")
   end subroutine declare_time

   !> Declare the part of &effects that does not concern materials.
   subroutine declare_effects(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("effects", &
         "physics switches; a switched-off effect costs nothing and its "// &
         "keys are refused")
      call schema%logical("effects", "gravity", "acceleration of all matter", default=".false.")
      call schema%real("effects", "gravity_vector(3)", "the acceleration", unit="m/s2", &
         default="0 0 -9.80665", owner="gravity")
      call schema%text("effects", "gravity_table", "file of lines t, gx, gy, gz in the units "// &
         "of the deck, added to gravity_vector, straight between; path relative to the deck", &
         owner="gravity")
      call schema%logical("effects", "contact", "bodies have velocities of their own, and touch", &
         default=".false.")
      call schema%logical("effects", "erosion", "failed particles are taken out and booked", &
         default=".false.", owner="effects.damage")
   end subroutine declare_effects
end module scene_deck_schema
