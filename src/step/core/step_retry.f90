! SPDX-License-Identifier: BSD-3-Clause
!> Examines the node displacements before any particle moves: a step in which nodes would go too far
!! is repeated with a shorter time step.
module step_retry
   use base_error, only: error_t, exit_physics, fail
   use base_kinds, only: int64, wp
   use step_bounds, only: rule_retry
   use step_ledger, only: external_work, impulse, torque
   use step_node_displacement, only: checks_displacement, examine_tile, worse
   use step_node_sums, only: renew_sums
   use step_offending_particle, only: spread, step_text
   use step_simulation, only: reach_t, simulation_t, velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
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

      again = .false.
      if (.not. checks_displacement(simulation)) return
      do n = 1, size(simulation%fields)
         call find_worst(simulation, simulation%fields(n), dt, reach)
         if (worse(reach, worst)) worst = reach
      end do
      excess = worst%excess
      if (simulation%machine%communicator%size > 1) then
         call simulation%machine%timer%start(simulation%machine%phase%wait)
         excess = simulation%machine%communicator%maximum(excess)
         call simulation%machine%timer%stop(simulation%machine%phase%wait)
      end if
      if (.not. excess > 1.0_wp) return
      again = .true.
      associate (guard => simulation%clock%guard, cut => max(slack/excess, least_cut))
         if (dt*cut < max(guard%bounds%dt_min, guard%bounds%collapse*guard%longest)) then
            call name_node(simulation, dt, excess, worst, error)
            return
         end if
         dt = dt*cut
         simulation%clock%dt_next = dt
         guard%steps(guard%counted) = guard%steps(guard%counted) - 1
         guard%counted = rule_retry
         guard%steps(rule_retry) = guard%steps(rule_retry) + 1
      end associate
      call put_back(simulation)
   end subroutine check_node_displacement

   !> Restore the sums of the nodes before they moved, and remove the work of walls and gravity from
   !! the ledger.
   subroutine put_back(simulation)
      type(simulation_t), intent(inout) :: simulation
      integer :: thread, k, n

      do thread = 0, ubound(simulation%scratch, 1)
         associate (sums => simulation%scratch(thread)%ledger%sums)
            do k = 0, 2
               call sums(impulse + k)%clear()
               call sums(torque + k)%clear()
            end do
            call sums(external_work)%clear()
         end associate
         call simulation%scratch(thread)%ledger%walls%clear()
      end do
      if (.not. simulation%scheme%method%dual) return
      do n = 1, size(simulation%fields)
         call renew_sums(simulation%space, simulation%machine, simulation%fields(n))
      end do
   end subroutine put_back

   !> The node of this rank that exceeds the bounds most.
   subroutine find_worst(simulation, field, dt, worst)
      type(simulation_t), intent(inout) :: simulation !! State after the nodes have moved
      type(velocity_field_t), intent(in) :: field
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(reach_t), intent(out) :: worst
      type(reach_t) :: mine, reach
      real(wp) :: began
      integer :: tile, thread

      if (field%nodes%motion%lean) then
         ! the threads have tested this while moving the nodes
         do thread = 0, ubound(simulation%scratch, 1)
            if (worse(simulation%scratch(thread)%reach, worst)) &
               worst = simulation%scratch(thread)%reach
         end do
         return
      end if
      mine = reach_t()
      !$omp parallel default(none) shared(simulation, field, dt, worst) &
      !$omp firstprivate(mine) private(began, tile, reach)
      !$omp do schedule(static)
      do tile = 1, simulation%space%tiles%own
         began = cost_clock(simulation%machine)
         call examine_tile(simulation, field, tile, tile, simulation%space%mesh_time(dt), reach)
         if (worse(reach, mine)) mine = reach
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end do
      !$omp critical
      if (worse(mine, worst)) worst = mine
      !$omp end critical
      !$omp end parallel
   end subroutine find_worst

   !> Report the node that moves too far. Of equal nodes the first of the grid is named. Collective.
   subroutine name_node(simulation, dt, excess, worst, error)
      type(simulation_t), intent(in) :: simulation
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
      call simulation%machine%communicator%least(least)
      if (number == least(1) .and. number < huge(number)) then
         write (line, "(a,3es11.3,a)") "the node at", simulation%space%grid%lower &
            + real(worst%place, wp)*simulation%space%grid%spacing, " m"
         text = trim(line)
         if (worst%strain > 0.0_wp) then
            write (line, "(a,es10.3,a)") " and the next one would approach or separate by", &
               worst%strain, " of a cell"
         else
            write (line, "(a,es10.3,a)") " would move by", worst%moved, " of a cell [R103]"
         end if
         text = text//trim(line)
      end if
      call spread(simulation, text)
      write (line, "(a,es10.3,a)") " in a step of", dt, &
         " s, and a shorter one is below dt_min, or dt_collapse of the longest"
      call fail(error, exit_physics, step_text(simulation%clock)//": "//text//trim(line))
   end subroutine name_node
end module step_retry
