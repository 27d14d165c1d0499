! SPDX-License-Identifier: BSD-3-Clause
!> Gravity as the deck gives it: constant, or with a table of time.
module scene_gravity
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use io_motion, only: of_gravity
   use scene_motion_table, only: read_motion_table
   use step_gravity, only: update_gravity
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: read_gravity

contains

   !> Read gravity, if it acts. Collective.
   subroutine read_gravity(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! Gets it; its grid is read
      type(group_t) :: group
      character(len=1), parameter :: axes(3) = ["x", "y", "z"]
      logical :: acts
      integer :: k

      group = deck%group("effects", 1)
      call group%get("gravity", acts)
      if (.not. acts) return
      allocate (simulation%effects%gravity(3))
      call group%get("gravity_vector", simulation%effects%gravity)
      where (.not. simulation%space%grid%active) simulation%effects%gravity = 0.0_wp
      if (.not. group%given("gravity_table")) return
      allocate (simulation%effects%shaking)
      simulation%effects%shaking%steady = simulation%effects%gravity
      call read_motion_table(deck, simulation%machine%communicator, group, "gravity_table", &
         of_gravity, &
         "m/s2", simulation%effects%shaking)
      if (.not. allocated(simulation%effects%shaking%speed)) return
      do k = 1, 3
         if (simulation%space%grid%active(k)) cycle
         if (.not. any(abs(simulation%effects%shaking%speed(k, :)) > 0.0_wp)) cycle
         call deck%complain(group, "gravity_table: the table must be 0 in "//axes(k)// &
            ", a direction that the scene lacks", "gravity_table")
      end do
      call update_gravity(simulation)
   end subroutine read_gravity
end module scene_gravity
