! SPDX-License-Identifier: BSD-3-Clause
!> All groups of a deck: each is declared by the module that checks and reads it.
module scene_deck_schema
   use deck_schema, only: changes_nothing, schema_t
   use material_keys, only: declare_material_keys
   use scene_bodies, only: declare_body
   use scene_boundary, only: declare_boundary
   use scene_contact, only: declare_contact
   use scene_detonation, only: declare_detonation
   use scene_effects, only: declare_effects
   use scene_exact, only: declare_exact
   use scene_grid, only: declare_grid
   use scene_inflow, only: declare_inflow
   use scene_load, only: declare_load
   use scene_method, only: declare_method
   use scene_parallel, only: declare_parallel
   use scene_regions, only: declare_region
   use scene_run, only: declare_run, declare_units
   use scene_time, only: declare_time
   implicit none
   private

   public :: declare_deck

contains

   !> Declare the groups and their keys in the order of the echo. Materials add keys to &effects.
   subroutine declare_deck(schema)
      type(schema_t), intent(inout) :: schema            !! Schema that receives the keys

      call schema%group("include", "read more groups from another file", many=.true.)
      call schema%text("include", "file", "path, relative to the file that includes it")
      call schema%group("define", "names for numbers, for use in expressions in braces: {2*name}", &
         many=.true.)
      call declare_run(schema)
      call declare_units(schema)
      call declare_grid(schema)
      call declare_time(schema)
      call declare_method(schema)
      call declare_effects(schema)
      call declare_material_keys(schema)
      call declare_region(schema)
      call declare_body(schema)
      call declare_boundary(schema)
      call declare_contact(schema)
      call declare_load(schema)
      call declare_inflow(schema)
      call declare_detonation(schema)
      call declare_exact(schema)
      call declare_parallel(schema)
      ! the echo contains the groups and numbers that these two provide
      call schema%allow_change("include", "* + -", changes_nothing)
      call schema%allow_change("define", "+ -", changes_nothing)
   end subroutine declare_deck
end module scene_deck_schema
