! SPDX-License-Identifier: BSD-3-Clause
!> Compares `dt_fixed` with the stability limit of the first state. Section "Fixed steps" of
!! doc/theory/time_step.md.
module run_fixed_step
   use base_constants, only: unset
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use particle_body, only: body_t
   use run_expected_steps, only: find_first_stable_step
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_fixed_step

   !> Courant numbers above which a fixed step is refused: the greatest that `cfl` may have, and
   !! with the dual gradient that above which no variant of it was stable.
   real(wp), parameter :: most = 1.0_wp, most_dual = 0.96_wp
   !> Courant number below which the dual gradient was stable with all options, and the usual one.
   real(wp), parameter :: sure_dual = 0.75_wp, usual = 0.4_wp
   real(wp), parameter :: rounding = 1.0e-9_wp

contains

   !> Refuse a fixed step above the stability limit, and warn of one that is close to it.
   subroutine check_fixed_step(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors and warnings
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(group_t) :: group
      character(len=:), allocatable :: cause, instead
      real(wp) :: dt, limit, sure

      group = deck%group("time", 1)
      call group%get("dt_fixed", dt)
      if (.not. dt > unset) return
      ! the strain of a cell limits the accuracy, not the stability
      call find_first_stable_step(simulation, bodies, usual, huge(dt), limit, cause)
      instead = deck%shown(limit, "s")
      associate (dual => simulation%scheme%method%dual)
         call find_first_stable_step(simulation, bodies, merge(sure_dual, most, dual), huge(dt), &
            sure, cause)
         call find_first_stable_step(simulation, bodies, merge(most_dual, most, dual), huge(dt), &
            limit, cause)
      end associate
      if (dt > limit*(1.0_wp + rounding)) then
         call deck%add_error(group, "dt_fixed is above the stability limit of the first state, "// &
            deck%shown(limit, "s")//cause//"; write dt_fixed = "//instead//" or less, remove "// &
            "it, so that cfl sets the step, or continue with --force [D230]", "dt_fixed")
      else if (dt > sure*(1.0_wp + rounding)) then
         call deck%warn(group, "dt_fixed is "//brief(dt/limit)//" times the stability limit of "// &
            "the first state, "//deck%shown(limit, "s")//cause//"; dt_fixed = "//instead// &
            " is that of cfl = 0.4 [D231]", "dt_fixed")
      end if
   end subroutine check_fixed_step
end module run_fixed_step
