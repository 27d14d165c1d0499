! SPDX-License-Identifier: BSD-3-Clause
!> The mean stress of the nodes that is subtracted from the particles and integrated exactly on the
!! grid (`quadrature = 'control'`), and the means of the particles that belong to it: equations
!! (Q.2) to (Q.4) of doc/theory/quadratures.md.
module step_mean_stress
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_node_fields, only: empty_mass, mean_columns, nodes_t
   use step_particles_to_nodes, only: copy_stress, locate_particles
   use step_simulation, only: machine_t, scheme_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: find_mean_stress

   integer, parameter :: before = 2                  !! Columns before those of the stress
   real(wp), parameter :: contrast = 4.0_wp          !! Densities of nodes over each other [1]

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
         call ensure_patch(nodes%stress%star, mean_columns - before, number, space%tiles%all)
         call ensure_patch(nodes%stress%share, 1, number, space%tiles%all)
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

   !> Mass, volume and stress of the particles of a tile.
   subroutine scatter_tile(space, stores, scheme, field, scratch, tile, patch)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      integer :: index, p, k

      call clear_patch(patch)
      do index = field%first_store, field%last_store
         if (stores(index)%count(tile) == 0) cycle
         associate (store => stores(index), shape => scratch%shape, pushed => scratch%pushed)
            call locate_particles(space, scheme, field, scratch, store, tile)
            call copy_stress(space, scheme%method, scratch, store, tile)
            do p = 1, store%count(tile)
               shape%values(p, 1) = store%state%mass(store%first(tile) + p - 1)
               shape%values(p, before) = pushed%volume(p)
            end do
            do k = 1, mean_columns - before
               do p = 1, store%count(tile)
                  shape%values(p, before + k) = pushed%volume(p)*pushed%stress(p, k)
               end do
            end do
            call scheme%method%basis%scatter_values(space%grid, shape, mean_columns, &
               shape%values, 0, patch)
         end associate
      end do
   end subroutine scatter_tile

   !> Mean stress of the nodes of a tile, and the factor of its sums: the least fill of all nodes
   !! around over the volume of the particles. Equation (Q.2). Nodes beyond the domain are ignored.
   subroutine divide_tile(space, nodes, tile)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      integer, parameter :: component(9) = [1, 4, 6, 4, 2, 5, 6, 5, 3]
      integer, parameter :: row(6) = [1, 5, 9, 4, 8, 7]
      real(wp) :: total(mean_columns, space%grid%tile_nodes)
      real(wp) :: around(space%grid%tile_nodes), fill(space%grid%tile_nodes)
      real(wp) :: light(space%grid%tile_nodes), heavy(space%grid%tile_nodes)
      real(wp) :: tensor(9, space%grid%tile_nodes), share
      integer :: node, direction, k

      call assemble(space%grid, space%tiles, nodes%stress%mean, tile, total)
      call space%grid%node_volume(space%tiles%coordinate(:, tile), around)
      fill = 1.0_wp
      light = huge(1.0_wp)/contrast
      heavy = 0.0_wp
      do node = 1, size(fill)
         if (.not. around(node) > 0.0_wp) cycle
         fill(node) = min(1.0_wp, 2.0_wp*total(before, node)/around(node))
         ! the least of these is minus the greatest density
         light(node) = total(1, node)/around(node)
         heavy(node) = -light(node)
      end do
      do direction = 1, 3
         if (.not. space%grid%active(direction)) cycle
         call take_least(space%grid, direction, fill)
         call take_least(space%grid, direction, light)
         call take_least(space%grid, direction, heavy)
      end do
      do node = 1, size(fill)
         share = fill(node)
         if (-heavy(node) > contrast*light(node)) share = min(share, &
            contrast*light(node)/(-heavy(node)))
         if (total(before, node) > empty_mass) then
            share = share/total(before, node)
         else
            share = 0.0_wp
         end if
         nodes%stress%share(1, node, tile) = share
         do k = 1, 9
            tensor(k, node) = share*total(before + component(k), node)
         end do
      end do
      call space%boundary%mirror(space%grid, space%tiles%coordinate(:, tile), tensor)
      do node = 1, size(fill)
         do k = 1, 6
            nodes%stress%star(k, node, tile) = tensor(row(k), node)
         end do
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
