! SPDX-License-Identifier: BSD-3-Clause
!> Checks of a deck that compare keys with each other. `program_plan` calls it after reading the
!! deck
!! and before `scene_setup`.
module scene_deck_check
   use base_constants, only: unset
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use base_text, only: brief, number
   use scene_bodies, only: check_bodies
   use scene_deck_check_scene, only: check_boundaries
   use scene_effects, only: check_effects
   use scene_grid, only: check_grid
   use scene_regions, only: check_regions
   use scene_run, only: check_case, set_output_units
   use scene_time, only: check_time
   use scene_unit_warnings, only: check_material_units
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
         call deck%complain("include", i, "the file was not read; end the group with a /", "file")
      end do
      call check_case(deck)
      call set_output_units(deck)
      call check_effects(deck)
      call check_grid(deck)
      call check_time(deck)
      call check_checkpoint(deck)
      do i = 1, deck%count("material")
         call check_material_units(deck, deck%group("material", i))
      end do
      call check_regions(deck)
      call check_bodies(deck)
      call check_boundaries(deck)
      do i = 1, deck%count("output")
         call check_output(deck, deck%group("output", i))
      end do
   end subroutine check_deck

   !> Checkpoints at so short intervals that a run would do nothing else.
   subroutine check_checkpoint(deck)
      type(deck_t), intent(inout) :: deck                !! The deck
      real(wp), parameter :: most = 1.0e6_wp             ! checkpoints
      real(wp) :: dt, t_end
      type(group_t) :: checkpoint, time

      checkpoint = deck%group("checkpoint")
      time = deck%group("time")
      if (.not. (checkpoint%known("dt") .and. time%known("t_end"))) return
      call checkpoint%get("dt", dt)
      call time%get("t_end", t_end)
      if (t_end/most > dt) call deck%complain(checkpoint, "dt gives "//brief(t_end/dt)// &
         " checkpoints until t_end; take a longer dt, or wall_minutes", "dt")
   end subroutine check_checkpoint

   !> When an output is written.
   subroutine check_output(deck, output)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: output                !! One output
      character(len=5), parameter :: ways(4) = ["dt   ", "every", "times", "count"]
      real(wp), allocatable :: times(:)
      character(len=:), allocatable :: given
      real(wp) :: t_end
      type(group_t) :: time
      integer :: i, total

      total = 0
      given = ""
      do i = 1, size(ways)
         if (.not. output%given(trim(ways(i)))) cycle
         total = total + 1
         given = given//" "//trim(ways(i))
      end do
      if (total == 0) call deck%complain(output, "give one of dt, every, times, count")
      if (total > 1) call deck%complain(output, "give one of dt, every, times, count, not"//given, &
         given(2:index(given(2:)//" ", " ")))
      time = deck%group("time")
      call time%get("t_end", t_end)
      if (t_end <= unset) return
      call output%list("times", times)
      do i = 1, size(times)
         if (times(i) <= t_end) cycle
         call deck%warn(output, "time "//number(i)//" of "//number(size(times))// &
            " is after t_end and will not be written", "times")
         return
      end do
   end subroutine check_output
end module scene_deck_check
