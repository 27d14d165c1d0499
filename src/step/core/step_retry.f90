! SPDX-License-Identifier: BSD-3-Clause
!> Examines the node displacements before any particle moves: a step in which nodes would go too far
!! is repeated with a shorter time step.
module step_retry
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_physics, fail
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use step_bounds, only: rule_retry
   use step_ledger, only: external_work, impulse, torque
   use step_method, only: method_t
   use step_node_displacement, only: checks_displacement, examine_tile, is_worse
   use step_node_fields, only: motion_nodes_t
   use step_node_sums, only: renew_sums
   use step_offending_particle, only: broadcast_text, step_text
   use step_simulation, only: clock_t, machine_t, reach_t, scratch_t, simulation_t, space_t, &
      velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: check_node_displacement

   real(wp), parameter :: slack = 0.9_wp             !! Target fraction of the bounds
   real(wp), parameter :: least_cut = 0.1_wp         !! Least ratio of a step to that before

contains

   !> Find whether a node would move too far in the step, or two nodes of a cell too far apart. If
   !! so, restore the state before the nodes moved, so that the step can be repeated with a shorter
   !! time step. Collective. Equation (S.4) of doc/theory/time_step.md.
   subroutine check_node_displacement(simulation, dt, again, error)
      type(simulation_t), intent(inout) :: simulation !! State after the nodes have moved
      real(wp), intent(inout) :: dt                  !! Time step [s]
      logical, intent(out) :: again                  !! Must the step be repeated?
      type(error_t), allocatable, intent(out) :: error !! No step is short enough
      type(reach_t) :: worst, reach
      real(wp) :: excess
      integer :: n

      associate (machine => simulation%machine)
         again = .false.
         if (.not. checks_displacement(simulation%scheme%method, simulation%effects, &
            simulation%clock%guard)) return
         do n = 1, size(simulation%fields)
            call find_worst(simulation, simulation%fields(n)%nodes%motion, dt, reach)
            if (is_worse(reach, worst)) worst = reach
         end do
         excess = worst%excess
         if (machine%communicator%size > 1) then
            call machine%timer%start(machine%phase%wait)
            excess = machine%communicator%maximum(excess)
            call machine%timer%stop(machine%phase%wait)
         end if
         if (.not. excess > 1.0_wp) return
         again = .true.
         associate (guard => simulation%clock%guard, cut => max(slack/excess, least_cut))
            if (dt*cut < max(guard%bounds%dt_min, guard%bounds%collapse*guard%longest)) then
               call name_node(simulation%space%grid, simulation%clock, machine%communicator, dt, &
                  excess, worst, error)
               return
            end if
            dt = dt*cut
            simulation%clock%dt_next = dt
            guard%steps(guard%counted) = guard%steps(guard%counted) - 1
            guard%counted = rule_retry
            guard%steps(rule_retry) = guard%steps(rule_retry) + 1
         end associate
         call restore_state(simulation%space, simulation%fields, simulation%scheme%method, &
            machine, simulation%scratch)
      end associate
   end subroutine check_node_displacement

   !> Restore the sums of the nodes before they moved, and remove the work of walls and gravity from
   !! the ledger.
   subroutine restore_state(space, fields, method, machine, scratches)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(inout) :: fields(:)
      type(method_t), intent(in) :: method
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      integer :: thread, k, n

      do thread = 0, ubound(scratches, 1)
         associate (sums => scratches(thread)%ledger%sums)
            do k = 0, 2
               call sums(impulse + k)%clear()
               call sums(torque + k)%clear()
            end do
            call sums(external_work)%clear()
         end associate
         call scratches(thread)%ledger%walls%clear()
      end do
      if (.not. method%dual) return
      do n = 1, size(fields)
         call renew_sums(space, machine, fields(n)%nodes%motion)
      end do
   end subroutine restore_state

   !> The node of this rank that exceeds the bounds most.
   subroutine find_worst(simulation, motion, dt, worst)
      type(simulation_t), intent(inout) :: simulation !! State after the nodes have moved
      type(motion_nodes_t), intent(in) :: motion
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(reach_t), intent(out) :: worst
      type(reach_t) :: mine, reach
      integer :: tile, thread

      if (motion%lean) then
         ! the threads have tested this while moving the nodes
         do thread = 0, ubound(simulation%scratch, 1)
            if (is_worse(simulation%scratch(thread)%reach, worst)) worst = &
               simulation%scratch(thread)%reach
         end do
         return
      end if
      mine = reach_t()
      !$omp parallel default(none) shared(simulation, motion, dt, worst) firstprivate(mine) &
      !$omp private(tile, reach)
      !$omp do schedule(static)
      do tile = 1, simulation%space%tiles%own
         call start_cost(simulation%machine, tile)
         call examine_tile(simulation%space, simulation%stores, simulation%scheme%method, &
            simulation%clock%guard, motion, tile, simulation%space%mesh_time(dt), reach)
         if (is_worse(reach, mine)) mine = reach
         call stop_cost(simulation%machine, tile)
      end do
      !$omp end do
      !$omp critical
      if (is_worse(mine, worst)) worst = mine
      !$omp end critical
      !$omp end parallel
   end subroutine find_worst

   !> Report the node that moves too far. Of equal nodes the first of the grid is named. Collective.
   subroutine name_node(grid, clock, communicator, dt, excess, worst, error)
      type(grid_t), intent(in) :: grid
      type(clock_t), intent(in) :: clock
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(in) :: dt                     !! Time step that was tried [s]
      real(wp), intent(in) :: excess                 !! Excess of the worst node of all ranks
      type(reach_t), intent(in) :: worst             !! That of this rank
      type(error_t), allocatable, intent(out) :: error !! Always
      integer(int64) :: least(1), number
      character(len=:), allocatable :: text
      character(len=200) :: line

      number = huge(number)
      if (worst%excess >= excess) number = worst%number
      least = number
      text = ""
      call communicator%least(least)
      if (number == least(1) .and. number < huge(number)) then
         write (line, "(a,3es11.3,a)") "the node at", grid%lower + real(worst%place, &
            wp)*grid%spacing, " m"
         text = trim(line)
         if (worst%strain > 0.0_wp) then
            write (line, "(a,es10.3,a)") " and the next one would approach or separate by", &
               worst%strain, " of a cell [R103]"
         else
            write (line, "(a,es10.3,a)") " would move by", worst%moved, " of a cell [R103]"
         end if
         text = text//trim(line)
      end if
      call broadcast_text(communicator, text)
      write (line, "(a,es10.3,a)") " in a step of", dt, &
         " s, and a shorter one is below dt_min, or dt_collapse of the longest"
      call fail(error, exit_physics, step_text(clock)//": "//text//trim(line))
   end subroutine name_node
end module step_retry
