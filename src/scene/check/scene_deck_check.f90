! SPDX-License-Identifier: BSD-3-Clause
!> Checks of a deck that compare keys with each other. `run_setup` calls it after reading
!! the deck and before `scene_setup`.
module scene_deck_check
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use scene_bodies, only: check_bodies
   use scene_boundary, only: check_boundaries
   use scene_effects, only: check_effects
   use scene_grid, only: check_grid
   use scene_regions, only: check_regions
   use scene_run, only: check_case, set_output_units
   use scene_time, only: check_time
   use scene_unit_warnings, only: check_friction, check_material_units
   implicit none
   private

   public :: check_deck

contains

   !> Check the whole deck: errors go into its list of problems, and defaults that depend on other
   !! keys are set.
   subroutine check_deck(deck)
      type(deck_t), intent(inout) :: deck                !! After `read`
      integer :: i

      do i = 1, deck%count("include")
         call deck%add_error("include", i, "the file was not read; end the group with a / [D111]", &
            "file")
      end do
      call check_case(deck)
      call set_output_units(deck)
      call check_effects(deck)
      call check_grid(deck)
      call check_time(deck)
      do i = 1, deck%count("material")
         call check_material_units(deck, deck%group("material", i))
      end do
      do i = 1, deck%count("contact")
         call check_friction(deck, deck%group("contact", i))
      end do
      do i = 1, deck%count("boundary")
         call check_friction(deck, deck%group("boundary", i))
      end do
      call check_regions(deck)
      call check_bodies(deck)
      call check_boundaries(deck)
   end subroutine check_deck
end module scene_deck_check
