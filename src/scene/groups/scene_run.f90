! SPDX-License-Identifier: BSD-3-Clause
!> The groups &run and &units: their keys, and the defaults that depend on the name of the deck.
module scene_run
   use base_file, only: name_of
   use base_names, only: name_problem, suggested_name
   use base_text, only: number
   use base_version, only: version_text
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_extent, changes_nothing, schema_t
   use deck_units, only: system_names
   implicit none
   private

   public :: check_case, declare_run, declare_units, set_output_units

   !> Format of decks. It increases with each change that alters the meaning of older decks without
   !! an error.
   integer, parameter :: deck_version = 1

contains

   !> Declare &run.
   subroutine declare_run(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("run", "title, dimension and method")
      call schema%text("run", "title", "one line of text, written to every "// &
         "output", default="untitled")
      call schema%text("run", "case", "prefix of all output files; default: name of the deck")
      call schema%text("run", "dimension", &
         "problem class; plane_strain and axisymmetric use x and z", &
         default="3d", words="3d plane_strain axisymmetric 1d")
      call schema%text("run", "method", "gradient: ddmp, dual domain, continuous at cell "// &
         "faces; mpm, of the shape functions", default="ddmp", &
         words="ddmp mpm")
      call schema%integer("run", "deck_version", "version of the deck format", default="1", &
         range="> 0 <= "//number(deck_version))
      call schema%explain_range("run", "deck_version", "scree "//version_text//" "// &
         "supports decks up to deck_version "//number(deck_version)//"; use a later scree "// &
         "for this deck [D219]")
      call schema%allow_change("run", "title case deck_version", changes_nothing)
      call schema%forbid_change("run", "dimension method", "the particles of the checkpoint "// &
         "have the fields of this choice")
   end subroutine declare_run

   !> Declare &units.
   subroutine declare_units(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("units", "units of the numbers in this deck and in outputs")
      call schema%text("units", "system", "system of units, length-time-mass; in all systems "// &
         "temperatures are in K and angles in degrees", default="si")
      call schema%words("units", "system", system_names)
      call schema%text("units", "output_units", "units of snapshots and tables: deck, those "// &
         "of this deck, or a system of units; the files contain the name of each "// &
         "unit", default="si", &
         words="deck")
      call schema%words("units", "output_units", system_names)
      ! the echo of a deck is always in SI
      call schema%allow_change("units", "system", changes_nothing)
      call schema%allow_change("units", "output_units", changes_extent)
   end subroutine declare_units

   !> The case is part of file names. Without one it is the name of the deck.
   subroutine check_case(deck)
      type(deck_t), intent(inout) :: deck
      character(len=*), parameter :: suffix = ".nml"
      character(len=:), allocatable :: case_name
      type(group_t) :: run
      integer :: last

      run = deck%group("run")
      if (.not. run%valid(["case"]) .or. run%given("case")) return
      case_name = name_of(deck%file)
      last = len(case_name)
      if (last > len(suffix)) then
         if (case_name(last - len(suffix) + 1:) == suffix) last = last - len(suffix)
      end if
      case_name = case_name(:last)
      call deck%set_default("run", 1, "case", case_name)
      if (name_problem(case_name) /= "") call deck%add_error(run, "the name of the deck would "// &
         "be the case, but it "//name_problem(case_name)//"; write case = '"// &
         suggested_name(case_name)//"', or --case "//suggested_name(case_name))
   end subroutine check_case

   !> Replace `deck` by the name of its system of units, as the echo of the deck is in SI.
   subroutine set_output_units(deck)
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: word
      type(group_t) :: units

      units = deck%group("units")
      call units%get("output_units", word)
      if (word == "deck") call deck%set_default("units", 1, "output_units", &
         trim(system_names(deck%system)))
   end subroutine set_output_units
end module scene_run
