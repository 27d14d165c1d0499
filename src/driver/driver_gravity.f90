! SPDX-License-Identifier: BSD-3-Clause
!> Gravity, constant or with a table of time (`gravity_table` of &effects).
!!
!! In a step gravity is the mean of the table over the time in which the forces of this step act:
!! the integral of its straight lines, equation (R.4) of doc/theory/rigid.md. So the impulse of a
!! run is that of the table whatever the steps are, and work and impulse are recorded as those of
!! constant gravity. Between steps gravity is that of the present time; nothing is kept for a
!! restart.
module driver_gravity
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use driver_motion_table, only: read_motion_table
   use driver_simulation, only: simulation_t
   use io_motion, only: of_gravity
   implicit none
   private

   public :: act_gravity, note_gravity, read_gravity

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
      allocate (simulation%gravity(3))
      call group%get("gravity_vector", simulation%gravity)
      where (.not. simulation%grid%active) simulation%gravity = 0.0_wp
      if (.not. group%given("gravity_table")) return
      allocate (simulation%shaking)
      simulation%shaking%steady = simulation%gravity
      call read_motion_table(deck, simulation%communicator, group, "gravity_table", of_gravity, &
         "m/s2", simulation%shaking)
      if (.not. allocated(simulation%shaking%speed)) return
      do k = 1, 3
         if (simulation%grid%active(k)) cycle
         if (.not. any(abs(simulation%shaking%speed(k, :)) > 0.0_wp)) cycle
         call deck%complain(group, "gravity_table: the table must be 0 in "//axes(k)// &
            ", a direction that the scene lacks", "gravity_table")
      end do
      call note_gravity(simulation)
   end subroutine read_gravity

   !> Let gravity be its mean over the time in which the forces of a step act.
   pure subroutine act_gravity(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run, its kick is set
      real(wp) :: from

      if (.not. allocated(simulation%shaking)) return
      from = simulation%time - simulation%method%lag(simulation%dt)
      if (simulation%kick > 0.0_wp) &
         simulation%gravity = simulation%shaking%mean(from, simulation%kick)
   end subroutine act_gravity

   !> Let gravity be that of the present time.
   pure subroutine note_gravity(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run

      if (allocated(simulation%shaking)) &
         simulation%gravity = simulation%shaking%velocity(simulation%time)
   end subroutine note_gravity
end module driver_gravity
