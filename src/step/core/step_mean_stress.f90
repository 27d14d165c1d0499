! SPDX-License-Identifier: BSD-3-Clause
!> The mean stress of the nodes that is subtracted from the particles (`quadrature = 'control'`).
!! Equations (Q.2) and (Q.3) of doc/theory/quadratures.md.
module step_mean_stress
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_node_fields, only: empty_mass, mean_columns, nodes_t
   use step_particles_to_nodes, only: locate_particles
   use step_simulation, only: machine_t, scheme_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: find_mean_stress

contains

   !> Mean stress on the nodes inside of bodies, decreasing to zero at their surfaces.
   subroutine find_mean_stress(space, stores, scheme, machine, scratches, field)
      type(space_t), intent(inout) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(velocity_field_t), intent(inout) :: field
      integer, allocatable :: tiles(:)
      integer :: tile, part, n

      associate (nodes => field%nodes, number => space%grid%tile_nodes)
         call machine%timer%start(machine%phase%scatter)
         call ensure_patch(nodes%stress%mean, mean_columns, number, space%tiles%own)
         do part = edge_tiles, inner_tiles
            call next_tiles(space, machine%communicator, part, tiles)
            !$omp parallel do default(none) private(n) schedule(dynamic, 1) &
            !$omp shared(space, stores, scheme, machine, scratches, field, tiles)
            do n = 1, size(tiles)
               call start_cost(machine, tiles(n))
               call scatter_tile(space, stores, scheme, field, scratches(omp_get_thread_num()), &
                  tiles(n), field%nodes%stress%mean(:, :, tiles(n)))
               call stop_cost(machine, tiles(n))
            end do
            !$omp end parallel do
            call send_patches(space, machine, part, nodes%stress%mean)
         end do
         call machine%timer%stop(machine%phase%scatter)
         call machine%timer%start(machine%phase%grid)
         call ensure_patch(nodes%stress%star, mean_columns - 1, number, space%tiles%all)
         !$omp parallel do default(none) shared(space, machine, field) private(tile) &
         !$omp schedule(static)
         do tile = 1, space%tiles%all
            call start_cost(machine, tile)
            call divide_tile(space, field%nodes, tile)
            call stop_cost(machine, tile)
         end do
         !$omp end parallel do
         call machine%timer%stop(machine%phase%grid)
      end associate
   end subroutine find_mean_stress

   !> Volume and stress of the particles of a tile.
   subroutine scatter_tile(space, stores, scheme, field, scratch, tile, patch)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      integer :: index, p, q, k

      call clear_patch(patch)
      do index = field%first_store, field%last_store
         if (stores(index)%count(tile) == 0) cycle
         associate (store => stores(index))
            call locate_particles(space, scheme, field, scratch, store, tile)
            do p = 1, store%count(tile)
               q = store%first(tile) + p - 1
               scratch%shape%values(p, 1) = store%state%volume(q)
            end do
            do k = 1, 6
               do p = 1, store%count(tile)
                  q = store%first(tile) + p - 1
                  scratch%shape%values(p, 1 + k) = store%state%volume(q) &
                     *store%state%stress(q, k)
               end do
            end do
            call scheme%method%basis%scatter_values(space%grid, scratch%shape, mean_columns, &
               scratch%shape%values, 0, patch)
         end associate
      end do
   end subroutine scatter_tile

   !> Mean stress of the nodes of a tile, times the least fill of all nodes around: twice their
   !! volume of particles over their own, at most 1. Nodes beyond the domain are ignored. Equation
   !! (Q.2).
   subroutine divide_tile(space, nodes, tile)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      real(wp) :: total(mean_columns, space%grid%tile_nodes)
      real(wp) :: around(space%grid%tile_nodes), fill(space%grid%tile_nodes)
      integer :: node, direction

      call assemble(space%grid, space%tiles, nodes%stress%mean, tile, total)
      call space%grid%node_volume(space%tiles%coordinate(:, tile), around)
      do node = 1, size(fill)
         fill(node) = 1.0_wp
         if (around(node) > 0.0_wp) fill(node) = min(1.0_wp, 2.0_wp*total(1, node)/around(node))
      end do
      do direction = 1, 3
         if (space%grid%active(direction)) call take_least(space%grid, direction, fill)
      end do
      do node = 1, size(fill)
         nodes%stress%star(:, node, tile) = 0.0_wp
         if (total(1, node) > empty_mass) nodes%stress%star(:, node, tile) = fill(node)*total(2:, &
            node)/total(1, node)
      end do
   end subroutine divide_tile

   !> Least of each node and its neighbours along a direction. Nodes at the end of the margin keep
   !! their value; no particle of the tile uses them.
   pure subroutine take_least(grid, direction, values)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: direction               !! 1 to 3
      real(wp), intent(inout) :: values(:)           !! (node of the tile)
      real(wp) :: old(size(values))
      integer :: node, stride, position(3)

      old = values
      stride = grid%stride(direction)
      do node = 1, size(values)
         position = grid%node_position(node)
         if (position(direction) == -grid%margin) cycle
         if (position(direction) == grid%width(direction) + grid%margin) cycle
         values(node) = min(old(node - stride), old(node), old(node + stride))
      end do
   end subroutine take_least
end module step_mean_stress
