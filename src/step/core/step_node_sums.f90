! SPDX-License-Identifier: BSD-3-Clause
!> Sums over the particles around the nodes of a tile, and their storage.
module step_node_sums
   use base_kinds, only: wp
   use mesh_patch, only: ensure_patch
   use mesh_tiles, only: tiles_t
   use step_node_fields, only: empty_mass, motion_nodes_t
   use step_simulation, only: machine_t, scratch_t, space_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: divide_nodes, divide_motion, ensure_sums, find_sums, keep_sums, renew_sums, count_slots

   integer, parameter :: most = 64                   !! Nodes at a time: needs no allocation

contains

   !> Number of buffers for the fields of the tiles in work.
   pure integer function count_slots(tiles, scratches, motion) result(number)
      type(tiles_t), intent(in) :: tiles
      type(scratch_t), intent(in) :: scratches(0:)
      type(motion_nodes_t), intent(in) :: motion

      number = tiles%all
      if (motion%lean) number = size(scratches)
   end function count_slots

   !> Allocate the sums over the particles around the nodes.
   pure subroutine ensure_sums(space, scratches, motion)
      type(space_t), intent(in) :: space
      type(scratch_t), intent(inout) :: scratches(0:)
      type(motion_nodes_t), intent(inout) :: motion

      associate (number => space%grid%tile_nodes)
         call ensure_patch(motion%mass, 1, number, count_slots(space%tiles, scratches, motion))
         call ensure_patch(motion%velocity, 3, number, count_slots(space%tiles, scratches, motion))
         call ensure_patch(motion%acceleration, 3, number, count_slots(space%tiles, &
            scratches, motion))
      end associate
   end subroutine ensure_sums

   !> Find the sums of the nodes of a tile: mass, momentum in the array of the velocity, force in
   !! the array of the acceleration.
   pure subroutine find_sums(space, motion, tile, slot)
      type(space_t), intent(in) :: space
      type(motion_nodes_t), intent(inout) :: motion
      integer, intent(in) :: tile
      integer, intent(in) :: slot                    !! Index of its fields
      real(wp) :: sums(motion%packed(1)%rows, space%grid%tile_nodes)

      call motion%packed(1)%assemble(space%grid, space%tiles, motion%touched, tile, sums)
      call keep_sums(motion, slot, sums)
   end subroutine find_sums

   !> Keep the sums of the nodes of a tile.
   pure subroutine keep_sums(motion, slot, sums)
      type(motion_nodes_t), intent(inout) :: motion
      integer, intent(in) :: slot                    !! Index of the fields of the tile
      real(wp), intent(in) :: sums(:, :)             !! (column, node) Mass, momentum, force, more

      motion%mass(1, :, slot) = sums(1, :)
      motion%velocity(:, :, slot) = sums(2:4, :)
      motion%acceleration(:, :, slot) = sums(5:7, :)
   end subroutine keep_sums

   !> Sums over the particles around the nodes as before the nodes were moved, if they are kept.
   subroutine renew_sums(space, machine, motion)
      type(space_t), intent(in) :: space
      type(machine_t), intent(inout) :: machine
      type(motion_nodes_t), intent(inout) :: motion
      integer :: tile

      if (motion%lean) return
      !$omp parallel do default(none) shared(space, machine, motion) private(tile) schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call find_sums(space, motion, tile, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine renew_sums

   !> Divide node values by a volume or mass; nodes without any get zero.
   pure subroutine divide_nodes(by, row, values)
      real(wp), contiguous, intent(in) :: by(:, :)         !! (component, node)
      integer, intent(in) :: row                           !! Component that divides
      real(wp), contiguous, intent(inout) :: values(:, :)  !! (component, node)
      real(wp) :: inverse(most)
      integer :: before, nodes

      do before = 0, size(by, 2) - 1, most
         nodes = min(most, size(by, 2) - before)
         call invert_nodes(nodes, size(by, 1), by(:, before + 1:before + nodes), row, inverse)
         ! constant sizes let the compiler vectorise over components
         select case (size(values, 1))
         case (3)
            call multiply_nodes(3, nodes, inverse, values(:, before + 1:before + nodes))
         case (9)
            call multiply_tensors(nodes, inverse, values(:, before + 1:before + nodes))
         case default
            call multiply_nodes(size(values, 1), nodes, inverse, &
               values(:, before + 1:before + nodes))
         end select
      end do
   end subroutine divide_nodes

   !> Divide momentum and force of nodes by their mass; nodes without any get zero.
   pure subroutine divide_motion(mass, velocity, acceleration)
      real(wp), contiguous, intent(in) :: mass(:, :)       !! (1, node) [kg]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Momentum, velocity [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) Force, [m/s2]
      real(wp) :: inverse(most)
      integer :: before, nodes

      do before = 0, size(mass, 2) - 1, most
         nodes = min(most, size(mass, 2) - before)
         call invert_nodes(nodes, 1, mass(:, before + 1:before + nodes), 1, inverse)
         call multiply_nodes(3, nodes, inverse, velocity(:, before + 1:before + nodes))
         call multiply_nodes(3, nodes, inverse, acceleration(:, before + 1:before + nodes))
      end do
   end subroutine divide_motion

   !> One over a component of some nodes; zero where it is too small.
   pure subroutine invert_nodes(nodes, components, by, row, inverse)
      integer, intent(in) :: nodes                   !! Number of nodes
      integer, intent(in) :: components              !! Numbers per node
      real(wp), intent(in) :: by(components, nodes)  !! (component, node)
      integer, intent(in) :: row                     !! Component that divides
      real(wp), intent(inout) :: inverse(nodes)      !! (node)
      integer :: node

      !$omp simd
      do node = 1, nodes
         inverse(node) = merge(1.0_wp/max(by(row, node), empty_mass), 0.0_wp, &
            by(row, node) > empty_mass)
      end do
   end subroutine invert_nodes

   !> Multiply tensors of nodes by a factor of each node: eight of the nine components are lanes.
   pure subroutine multiply_tensors(nodes, factor, values)
      integer, intent(in) :: nodes                   !! Nodes of the tile
      real(wp), intent(in) :: factor(nodes)          !! (node)
      real(wp), intent(inout) :: values(9, nodes)    !! (component, node)
      integer :: node, component

      do node = 1, nodes
         !$omp simd
         do component = 1, 8
            values(component, node) = values(component, node)*factor(node)
         end do
         values(9, node) = values(9, node)*factor(node)
      end do
   end subroutine multiply_tensors

   !> Multiply the values of each node by a factor of this node.
   pure subroutine multiply_nodes(components, nodes, factor, values)
      integer, intent(in) :: components              !! Numbers per node
      integer, intent(in) :: nodes                   !! Nodes of the tile
      real(wp), intent(in) :: factor(nodes)          !! (node)
      real(wp), intent(inout) :: values(components, nodes) !! (component, node)
      integer :: node, component

      do node = 1, nodes
         do component = 1, components
            values(component, node) = values(component, node)*factor(node)
         end do
      end do
   end subroutine multiply_nodes
end module step_node_sums
