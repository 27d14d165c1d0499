! SPDX-License-Identifier: BSD-3-Clause
!> Displacement of the nodes of a tile in a step, and of neighbours relative to each other.
module step_node_displacement
   use base_kinds, only: int64, wp
   use mesh_grid, only: lane_bit
   use step_bounds, only: are_nodes_slow
   use step_method, only: stress_after
   use step_node_fields, only: empty_mass
   use step_simulation, only: reach_t, simulation_t, velocity_field_t
   implicit none
   private

   public :: checks_displacement, examine_tile, worse

   real(wp), parameter :: part_moved = 0.5_wp        !! Displacement [cells]; cfl if greater
   real(wp), parameter :: strain_share = 2.0_wp      !! Strain between nodes over strain_max

contains

   !> True if one node exceeds the bounds by more than another. Of equal nodes the first one of the
   !! grid is the worse one.
   elemental logical function worse(reach, other) result(is_worse)
      type(reach_t), intent(in) :: reach             !! The node that may be worse
      type(reach_t), intent(in) :: other             !! The node that it is compared with

      is_worse = reach%excess > other%excess .or. (reach%node > 0 .and. &
         reach%number < other%number .and. reach%excess >= other%excess)
   end function worse

   !> Are the node displacements of the coming step checked? They are not if particles are strained
   !! before the force or receive the gain of nodes of any mass, because a shorter step does not
   !! help; if the deck fixes the step; or with contact, because bonds may have broken, so the step
   !! cannot be repeated.
   pure logical function checks_displacement(simulation) result(checked)
      type(simulation_t), intent(in) :: simulation

      associate (method => simulation%scheme%method)
         checked = method%remaps() .or. (method%dual .and. &
            method%stress == stress_after)
      end associate
      checked = checked .and. simulation%clock%guard%bounds%dt_free .and. &
         .not. allocated(simulation%effects%contact)
   end function checks_displacement

   !> Displacement of the nodes of a tile that its particles use. In most tiles the greatest
   !! velocity is so small that nodes need not be examined one by one; in tiles that move as rigid
   !! bodies only displacements are examined. Equation (S.4) of doc/theory/time_step.md.
   pure subroutine examine_tile(simulation, field, tile, slot, dt, reach)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      integer, intent(in) :: slot                    !! Index of its fields
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(reach_t), intent(out) :: reach            !! The worst of the tile
      real(wp) :: far, apart

      far = max(part_moved, simulation%scheme%method%cfl)
      apart = strain_share*simulation%clock%guard%bounds%strain_max
      associate (velocity => field%nodes%motion%strain(:, :, slot), grid => simulation%space%grid, &
         mass => field%nodes%motion%mass(1, :, slot))
         ! bounds for each component that are independent of the others
         if (are_nodes_slow(size(velocity), velocity, min(far/sqrt(3.0_wp), apart/sqrt(12.0_wp)) &
            *grid%spacing/dt)) return
         call examine_nodes(velocity, mass, far*grid%spacing/dt, reach)
         if (.not. flies(velocity, mass, apart/sqrt(12.0_wp)*grid%spacing/dt)) &
            call examine_cells(simulation, tile, velocity, apart*grid%spacing/dt, reach)
      end associate
      reach%moved = reach%moved*dt/simulation%space%grid%spacing
      reach%strain = reach%strain*dt/simulation%space%grid%spacing
      if (reach%node == 0) return
      associate (grid => simulation%space%grid, coordinate => &
         simulation%space%tiles%coordinate(:, tile))
         reach%place = coordinate*grid%width + grid%node_position(reach%node)
         reach%number = reach%place(1) + (grid%cells(1) + 1_int64)*(reach%place(2) &
            + (grid%cells(2) + 1_int64)*reach%place(3))
      end associate
   end subroutine examine_tile

   !> The fastest node with mass.
   pure subroutine examine_nodes(velocity, mass, bound, reach)
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: mass(:)    !! (node) [kg]
      real(wp), intent(in) :: bound                  !! Speed at which a node moves too far [m/s]
      type(reach_t), intent(inout) :: reach          !! Gets speeds as displacements [m/s]
      real(wp) :: speed
      integer :: node

      do node = 1, size(mass)
         if (.not. mass(node) > empty_mass) cycle
         speed = norm2(velocity(:, node))
         if (.not. speed > reach%excess*bound) cycle
         reach = reach_t(excess=speed/bound, moved=speed, node=node)
      end do
   end subroutine examine_nodes

   !> Do all nodes with mass move together, each component within a bound of that of the first?
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

   !> The greatest velocity difference of two neighbouring nodes of a cell with particles.
   pure subroutine examine_cells(simulation, tile, velocity, bound, reach)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), intent(in) :: bound                  !! Difference that is too much [m/s]
      type(reach_t), intent(inout) :: reach          !! Gets differences as strains [m/s]
      real(wp) :: difference
      integer :: cell, lane, direction, low, high

      associate (grid => simulation%space%grid)
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
   end subroutine examine_cells

   !> Are there particles in a cell of a tile?
   pure logical function filled(simulation, tile, cell) result(some)
      type(simulation_t), intent(in) :: simulation   !! Sorted
      integer, intent(in) :: tile
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
end module step_node_displacement
