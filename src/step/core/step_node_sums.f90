! SPDX-License-Identifier: BSD-3-Clause
!> Sums over the particles around the nodes of a tile, and their storage.
module step_node_sums
   use base_kinds, only: wp
   use mesh_patch, only: ensure_patch
   use step_node_fields, only: empty_mass, nodes_t
   use step_simulation, only: machine_t, simulation_t, space_t, velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   implicit none
   private

   public :: divide, divide_motion, ensure_sums, find_sums, keep_sums, renew_sums, slots

   integer, parameter :: most = 64                   !! Nodes at a time: needs no allocation

contains

   !> Number of buffers for the fields of the tiles in work.
   pure integer function slots(simulation, field) result(number)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field

      number = simulation%space%tiles%all
      if (field%nodes%motion%lean) number = size(simulation%scratch)
   end function slots

   !> Allocate the sums over the particles around the nodes.
   pure subroutine ensure_sums(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field

      associate (nodes => field%nodes, number => simulation%space%grid%tile_nodes)
         call ensure_patch(nodes%motion%mass, 1, number, slots(simulation, field))
         call ensure_patch(nodes%motion%velocity, 3, number, slots(simulation, field))
         call ensure_patch(nodes%motion%acceleration, 3, number, slots(simulation, field))
      end associate
   end subroutine ensure_sums

   !> Find the sums of the nodes of a tile: mass, momentum in the array of the velocity, force in
   !! the array of the acceleration.
   pure subroutine find_sums(space, field, tile, slot)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      integer, intent(in) :: slot                    !! Index of its fields
      real(wp) :: sums(field%nodes%motion%packed(1)%rows, space%grid%tile_nodes)

      call field%nodes%motion%packed(1)%assemble(space%grid, space%tiles, &
         field%nodes%motion%touched, tile, sums)
      call keep_sums(field%nodes, slot, sums)
   end subroutine find_sums

   !> Keep the sums of the nodes of a tile.
   pure subroutine keep_sums(nodes, slot, sums)
      type(nodes_t), intent(inout) :: nodes          !! Receives them
      integer, intent(in) :: slot                    !! Index of the fields of the tile
      real(wp), intent(in) :: sums(:, :)             !! (column, node) Mass, momentum, force, more

      nodes%motion%mass(1, :, slot) = sums(1, :)
      nodes%motion%velocity(:, :, slot) = sums(2:4, :)
      nodes%motion%acceleration(:, :, slot) = sums(5:7, :)
   end subroutine keep_sums

   !> Sums over the particles around the nodes as before the nodes were moved, if they are kept.
   subroutine renew_sums(space, machine, field)
      type(space_t), intent(in) :: space
      type(machine_t), intent(inout) :: machine
      type(velocity_field_t), intent(inout) :: field
      integer :: tile
      real(wp) :: began

      if (field%nodes%motion%lean) return
      !$omp parallel do default(none) shared(space, machine, field) private(tile, began) &
      !$omp schedule(static)
      do tile = 1, space%tiles%all
         began = cost_clock(machine)
         call find_sums(space, field, tile, tile)
         call record_cost(machine, tile, began)
      end do
      !$omp end parallel do
   end subroutine renew_sums

   !> Divide node values by a volume or mass; nodes without any get zero.
   pure subroutine divide(by, row, values)
      real(wp), contiguous, intent(in) :: by(:, :)         !! (component, node)
      integer, intent(in) :: row                           !! Component that divides
      real(wp), contiguous, intent(inout) :: values(:, :)  !! (component, node)
      real(wp) :: inverse(most)
      integer :: before, nodes

      do before = 0, size(by, 2) - 1, most
         nodes = min(most, size(by, 2) - before)
         call invert(nodes, size(by, 1), by(:, before + 1:before + nodes), row, inverse)
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
   end subroutine divide

   !> Divide momentum and force of nodes by their mass; nodes without any get zero.
   pure subroutine divide_motion(mass, velocity, acceleration)
      real(wp), contiguous, intent(in) :: mass(:, :)       !! (1, node) [kg]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Momentum, velocity [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) Force, [m/s2]
      real(wp) :: inverse(most)
      integer :: before, nodes

      do before = 0, size(mass, 2) - 1, most
         nodes = min(most, size(mass, 2) - before)
         call invert(nodes, 1, mass(:, before + 1:before + nodes), 1, inverse)
         call multiply_nodes(3, nodes, inverse, velocity(:, before + 1:before + nodes))
         call multiply_nodes(3, nodes, inverse, acceleration(:, before + 1:before + nodes))
      end do
   end subroutine divide_motion

   !> One over a component of some nodes; zero where it is too small.
   pure subroutine invert(nodes, components, by, row, inverse)
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
   end subroutine invert

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
