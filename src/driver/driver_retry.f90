! SPDX-License-Identifier: BSD-3-Clause
!> Looks at the nodes before they move any particle: a step in which they would go too far is done
!! again with a shorter time.
module driver_retry
   use base_error, only: error_t, exit_physics, fail
   use base_kinds, only: int64, wp
   use driver_bounds, only: rule_retry, slow_nodes
   use driver_culprit, only: spread, step_text
   use driver_ledger, only: external_work, impulse, torque
   use driver_method, only: method_t, stress_after, stress_remapped
   use driver_nodes, only: empty_mass, renew_sums
   use driver_simulation, only: simulation_t
   use mesh_grid, only: grid_t, lane_bit
   implicit none
   private

   public :: judge_nodes

   real(wp), parameter :: part_moved = 0.5_wp        !! Cells that a node may go, or more if cfl is
   real(wp), parameter :: strain_share = 2.0_wp      !! Strain between nodes over strain_max
   real(wp), parameter :: slack = 0.9_wp             !! Share of the bounds to be aimed at
   real(wp), parameter :: least_cut = 0.1_wp         !! Least ratio of a step to that before

   !> How far the nodes of a tile would go.
   type :: reach_t
      real(wp) :: excess = 0.0_wp                    !! Over the bounds, the worst of both [1]
      real(wp) :: moved = 0.0_wp                     !! Displacement of that node over a cell [1]
      real(wp) :: strain = 0.0_wp                    !! Or difference of two over a cell, else 0 [1]
      integer :: node = 0                            !! The node, in the tile
   end type reach_t

contains

   !> Would a node go too far in the step, or two of a cell too far apart? Then all is put back to
   !! where the nodes are to be moved again, and the step is shorter. Collective.
   subroutine judge_nodes(simulation, dt, again, error)
      type(simulation_t), intent(inout) :: simulation !! The run, its nodes just moved
      real(wp), intent(inout) :: dt                  !! Time step [s]
      logical, intent(out) :: again                  !! Is the step to be done again?
      type(error_t), allocatable, intent(out) :: error !! No step is short enough
      real(wp) :: excess
      integer :: tile
      type(reach_t) :: reach

      again = .false.
      if (.not. asks(simulation)) return
      excess = 0.0_wp
      !$omp parallel do default(none) shared(simulation, dt) private(tile, reach) &
      !$omp reduction(max:excess) schedule(static)
      do tile = 1, simulation%tiles%own
         call look_at_tile(simulation, tile, dt, reach)
         excess = max(excess, reach%excess)
      end do
      !$omp end parallel do
      if (simulation%communicator%size > 1) then
         call simulation%timer%start(simulation%phase%wait)
         excess = simulation%communicator%maximum(excess)
         call simulation%timer%stop(simulation%phase%wait)
      end if
      if (.not. excess > 1.0_wp) return
      again = .true.
      associate (guard => simulation%guard, cut => max(slack/excess, least_cut))
         if (dt*cut < max(guard%bounds%dt_min, guard%bounds%collapse*guard%longest)) then
            call name_node(simulation, dt, excess, error)
            return
         end if
         dt = dt*cut
         simulation%dt_next = dt
         guard%steps(guard%counted) = guard%steps(guard%counted) - 1
         guard%counted = rule_retry
         guard%steps(rule_retry) = guard%steps(rule_retry) + 1
      end associate
      call put_back(simulation)
   end subroutine judge_nodes

   !> Is the step that comes to be looked at? Where particles have been strained before the force,
   !! or see the gain of nodes however light, a shorter step does not help; and a step that the deck
   !! fixes stays.
   pure logical function asks(simulation) result(asked)
      type(simulation_t), intent(in) :: simulation   !! The run

      associate (method => simulation%method)
         asked = method%stress == stress_remapped .or. (method%dual .and. &
            method%stress == stress_after)
      end associate
      asked = asked .and. simulation%guard%bounds%dt_free
   end function asks

   !> How far the nodes of a tile would go that its particles see. Most tiles are so slow that their
   !! greatest velocity tells, others fly as a whole.
   pure subroutine look_at_tile(simulation, tile, dt, reach)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(reach_t), intent(out) :: reach            !! The worst of the tile
      real(wp) :: far, apart

      far = max(part_moved, simulation%method%cfl)
      apart = strain_share*simulation%guard%bounds%strain_max
      associate (velocity => simulation%nodes%strain(:, :, tile), grid => simulation%grid, &
         mass => simulation%nodes%mass(1, :, tile))
         ! bounds for each component that hold whatever the other components are
         if (slow_nodes(size(velocity), velocity, min(far/sqrt(3.0_wp), apart/sqrt(12.0_wp)) &
            *grid%spacing/dt)) return
         call look_at_places(velocity, mass, far*grid%spacing/dt, reach)
         if (.not. flies(velocity, mass, apart/sqrt(12.0_wp)*grid%spacing/dt)) &
            call look_at_cells(simulation, tile, velocity, apart*grid%spacing/dt, reach)
      end associate
      reach%moved = reach%moved*dt/simulation%grid%spacing
      reach%strain = reach%strain*dt/simulation%grid%spacing
   end subroutine look_at_tile

   !> The fastest node with mass.
   pure subroutine look_at_places(velocity, mass, bound, reach)
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: mass(:)    !! (node) [kg]
      real(wp), intent(in) :: bound                  !! Speed at which a node goes too far [m/s]
      type(reach_t), intent(inout) :: reach          !! Gets speeds as displacements [m/s]
      real(wp) :: speed
      integer :: node

      do node = 1, size(mass)
         if (.not. mass(node) > empty_mass) cycle
         speed = norm2(velocity(:, node))
         if (.not. speed > reach%excess*bound) cycle
         reach = reach_t(excess=speed/bound, moved=speed, node=node)
      end do
   end subroutine look_at_places

   !> Do all nodes with mass fly together, each component within a bound of that of the first?
   pure logical function flies(velocity, mass, bound) result(together)
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: mass(:)    !! (node) [kg]
      real(wp), intent(in) :: bound                  !! [m/s]
      integer :: node, first

      together = .true.
      first = 0
      do node = 1, size(mass)
         if (.not. mass(node) > empty_mass) cycle
         if (first == 0) first = node
         together = together .and. all(abs(velocity(:, node) - velocity(:, first)) <= bound)
      end do
   end function flies

   !> The greatest difference of two neighbouring nodes of a cell with particles.
   pure subroutine look_at_cells(simulation, tile, velocity, bound, reach)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), intent(in) :: bound                  !! Difference that is too much [m/s]
      type(reach_t), intent(inout) :: reach          !! Gets differences as strains [m/s]
      real(wp) :: difference
      integer :: cell, lane, direction, low, high

      associate (grid => simulation%grid)
         do cell = 0, grid%tile_cells - 1
            if (.not. filled(simulation, tile, cell)) cycle
            do direction = 1, 3
               if (.not. grid%active(direction)) cycle
               do lane = 1, 2**grid%dimensions
                  if (btest(lane - 1, lane_bit(direction))) cycle
                  low = grid%first_node(cell) + grid%lane_offset(lane)
                  high = low + grid%stride(direction)
                  difference = norm2(velocity(:, high) - velocity(:, low))
                  if (.not. difference > reach%excess*bound) cycle
                  reach = reach_t(excess=difference/bound, strain=difference, node=low)
               end do
            end do
         end do
      end associate
   end subroutine look_at_cells

   !> Are there particles in a cell of a tile?
   pure logical function filled(simulation, tile, cell) result(some)
      type(simulation_t), intent(in) :: simulation   !! The run, sorted
      integer, intent(in) :: tile                    !! Which tile
      integer, intent(in) :: cell                    !! Which cell, from 0
      integer :: index

      some = .false.
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            if (store%count(tile) == 0) cycle
            some = some .or. store%cell_start(cell + 1, tile) > store%cell_start(cell, tile)
         end associate
      end do
   end function filled

   !> Sums of the nodes as before they moved, and books without what faces and gravity did then.
   subroutine put_back(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: thread, k

      do thread = 0, ubound(simulation%scratch, 1)
         associate (sums => simulation%scratch(thread)%ledger%sums)
            do k = 0, 2
               call sums(impulse + k)%clear()
               call sums(torque + k)%clear()
            end do
            call sums(external_work)%clear()
         end associate
      end do
      if (simulation%method%dual) call renew_sums(simulation)
   end subroutine put_back

   !> Say which node goes too far in any step that is long enough. Of equal ones the first of the
   !! grid is named. Collective.
   subroutine name_node(simulation, dt, excess, error)
      type(simulation_t), intent(in) :: simulation   !! The run
      real(wp), intent(in) :: dt                     !! Time step that was tried [s]
      real(wp), intent(in) :: excess                 !! Of the worst node of all ranks
      type(error_t), allocatable, intent(out) :: error !! Always
      type(reach_t) :: reach, worst
      integer(int64) :: least(1), number
      integer :: tile, place(3)
      character(len=:), allocatable :: text
      character(len=200) :: line

      least = huge(least)
      text = ""
      do tile = 1, simulation%tiles%own
         call look_at_tile(simulation, tile, dt, reach)
         if (reach%excess < excess) cycle
         number = node_number(simulation%grid, simulation%tiles%coordinate(:, tile), reach%node)
         if (number >= least(1)) cycle
         least = number
         worst = reach
         place = simulation%tiles%coordinate(:, tile)*simulation%grid%width &
            + simulation%grid%node_position(reach%node)
      end do
      number = least(1)
      call simulation%communicator%least(least)
      if (number == least(1) .and. number < huge(number)) then
         write (line, "(a,3es11.3,a)") "the node at", simulation%grid%lower &
            + real(place, wp)*simulation%grid%spacing, " m"
         text = trim(line)
         if (worst%strain > 0.0_wp) then
            write (line, "(a,es10.3,a)") " and the next one would come nearer or part by", &
               worst%strain, " of a cell"
         else
            write (line, "(a,es10.3,a)") " would move by", worst%moved, " of a cell"
         end if
         text = text//trim(line)
      end if
      call spread(simulation, text)
      write (line, "(a,es10.3,a)") " in a step of", dt, &
         " s, and a shorter one is below dt_min, or dt_collapse of the longest"
      call fail(error, exit_physics, step_text(simulation)//": "//text//trim(line))
   end subroutine name_node

   !> Number of a node in the whole grid.
   pure integer(int64) function node_number(grid, coordinate, node) result(number)
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Its tile, counted from 0
      integer, intent(in) :: node                    !! Node of the tile
      integer(int64) :: place(3)

      place = coordinate*grid%width + grid%node_position(node)
      number = place(1) + (grid%cells(1) + 1_int64)*(place(2) + (grid%cells(2) + 1_int64)*place(3))
   end function node_number
end module driver_retry
