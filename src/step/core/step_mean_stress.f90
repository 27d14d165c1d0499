! SPDX-License-Identifier: BSD-3-Clause
!> The mean stress of the nodes that is subtracted from the particles and integrated exactly on the
!! grid (`quadrature = 'control'`), and the means of the particles that belong to it: equations
!! (Q.2) to (Q.4) of doc/theory/quadratures.md.
module step_mean_stress
   use base_kinds, only: wp
   use ddmp_dual, only: add_cell_moments
   use mesh_patch, only: assemble, clear_patch, ensure_patch, ensure_weights
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_dual_gradient, only: ensure_dual, find_volumes, share_cells, widen_weighted
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_node_fields, only: before => mean_before, empty_mass, nodes_t, stress_rows
   use step_particles_to_nodes, only: copy_stress, locate_particles
   use step_simulation, only: machine_t, scheme_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: find_mean_stress

   integer, parameter :: steep = 4                   !! Steepness kappa of (Q.5)

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
      integer :: tile, part, n, rows

      rows = size(stress_rows(space%grid))
      associate (nodes => field%nodes, number => space%grid%tile_nodes)
         call machine%timer%start(machine%phase%scatter)
         call ensure_patch(nodes%stress%mean, before + rows + 1, number, space%tiles%own)
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
         call ensure_dual(space, scheme, scratches, nodes)
         call ensure_weights(nodes%motion%covered, space%grid%tile_cells, space%tiles%all)
         call ensure_patch(nodes%stress%star, rows, number, space%tiles%all)
         call ensure_patch(nodes%stress%share, 1, number, space%tiles%all)
         !$omp parallel do default(none) shared(space, scheme, machine, field) private(tile) &
         !$omp schedule(static)
         do tile = 1, space%tiles%all
            call start_cost(machine, tile)
            call weigh_tile(space, scheme, field%nodes, tile)
            call stop_cost(machine, tile)
         end do
         !$omp end parallel do
         call share_cells(space, scheme%dual, machine, nodes%dual)
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

   !> Mass, volume and stress of the particles of a tile, and how far they cover its cells: the last
   !! column has a value for each cell in place of the nodes, so that ghosts get it with the sums.
   subroutine scatter_tile(space, stores, scheme, field, scratch, tile, patch)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp) :: moments(0:3, space%grid%tile_cells)
      integer, allocatable :: rows(:)
      integer :: index, p, k

      call clear_patch(patch)
      moments = 0.0_wp
      allocate (rows, source=stress_rows(space%grid))
      do index = field%first_store, field%last_store
         if (stores(index)%count(tile) == 0) cycle
         associate (store => stores(index), shape => scratch%shape, pushed => scratch%pushed)
            call locate_particles(space, scheme, field, scratch, store, tile)
            call copy_stress(space, scheme%method, scratch, store, tile)
            do p = 1, store%count(tile)
               shape%values(p, 1) = store%state%mass(store%first(tile) + p - 1)
               shape%values(p, before) = pushed%volume(p)
            end do
            do k = 1, size(rows)
               do p = 1, store%count(tile)
                  shape%values(p, before + k) = pushed%volume(p)*pushed%stress(p, rows(k))
               end do
            end do
            call scheme%method%basis%scatter_values(space%grid, shape, before + size(rows), &
               shape%values, 0, patch)
            call add_cell_moments(shape%start, store%first(tile), shape%local, &
               store%state%volume, moments)
         end associate
      end do
      call scheme%dual%find_covered(space%grid, space%tiles%coordinate(:, tile), moments, &
         patch(size(patch, 1), :space%grid%tile_cells))
   end subroutine scatter_tile

   !> Weights of the cells of a tile, and the sums of its nodes until they are divided.
   subroutine weigh_tile(space, scheme, nodes, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      real(wp) :: total(size(nodes%stress%mean, 1), space%grid%tile_nodes)
      real(wp) :: around(space%grid%tile_nodes)

      call assemble(space%grid, space%tiles, nodes%stress%mean, tile, total)
      nodes%stress%share(1, :, tile) = total(before, :)
      nodes%stress%star(:, :, tile) = total(before + 1:size(total, 1) - 1, :)
      nodes%motion%covered(:, tile) = &
         nodes%stress%mean(size(total, 1), :space%grid%tile_cells, tile)
      call space%grid%node_volume(space%tiles%coordinate(:, tile), around)
      call scheme%dual%cell_weights(space%grid, total, before, around, nodes%dual%weight(:, tile), &
         nodes%motion%covered(:, tile))
      call widen_weighted(space%grid, nodes%dual, tile)
   end subroutine weigh_tile

   !> Mean stress of the nodes of a tile, and the factor of its sums: 1 over the volume of the
   !! particles inside of bodies, where all cells around count in full, and 0 if one of them counts
   !! with less than 3/4. Equations (Q.2) and (Q.5).
   subroutine divide_tile(space, nodes, tile)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      integer, parameter :: column(6) = [1, 5, 9, 4, 8, 7] !! In a tensor of nine components
      real(wp) :: around(space%grid%tile_nodes), tensor(9, space%grid%tile_nodes), share, cells
      integer, allocatable :: rows(:)
      integer :: node, k

      allocate (rows, source=stress_rows(space%grid))
      tensor = 0.0_wp
      call find_volumes(space, nodes%dual, tile, tile)
      call space%grid%node_volume(space%tiles%coordinate(:, tile), around)
      cells = real(steep*2**space%grid%dimensions, wp)
      associate (filled => nodes%stress%share(1, :, tile), star => nodes%stress%star(:, :, tile), &
         volume => nodes%dual%volume(1, :, tile))
         do node = 1, size(around)
            share = 0.0_wp
            if (around(node) > 0.0_wp .and. filled(node) > empty_mass) share = max(0.0_wp, &
               1.0_wp - cells*(1.0_wp - volume(node)/around(node)))/filled(node)
            filled(node) = share
            do k = 1, size(rows)
               tensor(column(rows(k)), node) = share*star(k, node)
            end do
         end do
         call space%boundary%mirror(space%grid, space%tiles%coordinate(:, tile), tensor)
         do node = 1, size(around)
            do k = 1, size(rows)
               star(k, node) = tensor(column(rows(k)), node)
            end do
         end do
      end associate
   end subroutine divide_tile
end module step_mean_stress
