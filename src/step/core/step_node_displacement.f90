! SPDX-License-Identifier: BSD-3-Clause
!> Displacement of the nodes of a tile in a step, and of neighbours relative to each other.
module step_node_displacement
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t, lane_bit
   use particle_store, only: store_t
   use step_bounds, only: are_nodes_slow, guard_t
   use step_method, only: method_t, stress_after
   use step_node_fields, only: empty_mass, motion_nodes_t
   use step_simulation, only: reach_t, simulation_effects_t, space_t
   implicit none
   private

   public :: checks_displacement, examine_tile, is_worse

   real(wp), parameter :: part_moved = 0.5_wp        !! Displacement [cells]; cfl if greater
   real(wp), parameter :: strain_share = 2.0_wp      !! Strain between nodes over strain_max

contains

   !> True if one node exceeds the bounds by more than another. Of equal nodes the first one of the
   !! grid is the worse one.
   elemental logical function is_worse(reach, other) result(worse)
      type(reach_t), intent(in) :: reach             !! The node that may be worse
      type(reach_t), intent(in) :: other             !! The node that it is compared with

      worse = reach%excess > other%excess .or. (reach%node > 0 .and. &
         reach%number < other%number .and. reach%excess >= other%excess)
   end function is_worse

   !> Are the node displacements of the coming step checked? They are not if particles are strained
   !! before the force or receive the gain of nodes of any mass, because a shorter step does not
   !! help; if the deck fixes the step; or with contact, because bonds may have broken, so the step
   !! cannot be repeated.
   pure logical function checks_displacement(method, effects, guard) result(checked)
      type(method_t), intent(in) :: method
      type(simulation_effects_t), intent(in) :: effects
      type(guard_t), intent(in) :: guard

      checked = method%remaps() .or. (method%dual .and. method%stress == stress_after)
      checked = checked .and. guard%bounds%dt_free .and. .not. allocated(effects%contact)
   end function checks_displacement

   !> Displacement of the nodes of a tile that its particles use. In most tiles the greatest
   !! velocity is so small that nodes need not be examined one by one; in tiles that move as rigid
   !! bodies only displacements are examined. Equation (S.4) of doc/theory/time_step.md.
   subroutine examine_tile(space, stores, method, guard, motion, tile, dt, reach)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(guard_t), intent(in) :: guard
      type(motion_nodes_t), intent(in) :: motion
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(reach_t), intent(out) :: reach            !! The worst of the tile
      real(wp) :: far, apart, bound, speed
      integer :: node

      far = max(part_moved, method%cfl)
      apart = strain_share*guard%bounds%strain_max
      associate (velocity => motion%strain(:, :, motion%slot(tile)), grid => space%grid, &
         mass => motion%mass(1, :, motion%slot(tile)))
         ! bounds for each component that are independent of the others
         if (are_nodes_slow(size(velocity), velocity, min(far/sqrt(3.0_wp), apart/sqrt(12.0_wp)) &
            *grid%spacing/dt)) return
         ! the fastest node with mass; speeds stand for displacements until the end
         bound = far*grid%spacing/dt
         do node = 1, size(mass)
            if (.not. mass(node) > empty_mass) cycle
            speed = norm2(velocity(:, node))
            if (.not. speed > reach%excess*bound) cycle
            reach = reach_t(excess=speed/bound, moved=speed, node=node)
         end do
         if (.not. moves_together(velocity, mass, apart/sqrt(12.0_wp)*grid%spacing/dt)) &
            call examine_cells(space%grid, stores, tile, velocity, apart*grid%spacing/dt, reach)
      end associate
      reach%moved = reach%moved*dt/space%grid%spacing
      reach%strain = reach%strain*dt/space%grid%spacing
      if (reach%node == 0) return
      associate (grid => space%grid, coordinate => space%tiles%coordinate(:, tile))
         reach%place = coordinate*grid%width + grid%node_position(reach%node)
         reach%number = reach%place(1) + (grid%cells(1) + 1_int64)*(reach%place(2) &
            + (grid%cells(2) + 1_int64)*reach%place(3))
      end associate
   end subroutine examine_tile

   !> Do all nodes with mass move together, each component within a bound of that of the first?
   pure logical function moves_together(velocity, mass, bound) result(together)
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
   end function moves_together

   !> The greatest velocity difference of two neighbouring nodes of a cell with particles.
   pure subroutine examine_cells(grid, stores, tile, velocity, bound, reach)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: stores(:)
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), intent(in) :: bound                  !! Difference that is too much [m/s]
      type(reach_t), intent(inout) :: reach          !! Gets differences as strains [m/s]
      real(wp) :: difference
      integer :: cell, lane, direction, low, high

      do cell = 0, grid%tile_cells - 1
         if (.not. has_particles(stores, tile, cell)) cycle
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
   end subroutine examine_cells

   !> Are there particles in a cell of a tile?
   pure logical function has_particles(stores, tile, cell) result(some)
      type(store_t), intent(in) :: stores(:)
      integer, intent(in) :: tile
      integer, intent(in) :: cell                    !! Which cell, from 0
      integer :: index

      some = .false.
      do index = 1, size(stores)
         associate (store => stores(index))
            if (store%count(tile) == 0) cycle
            some = some .or. store%cell_start(cell + 1, tile) > store%cell_start(cell, tile)
         end associate
      end do
   end function has_particles
end module step_node_displacement
