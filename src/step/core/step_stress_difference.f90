! SPDX-License-Identifier: BSD-3-Clause
!> Local stress difference (`quadrature = 'lsd'`): the force of a node inside of a body becomes f -
!! s . (f[I] - f_w[I]) with its mean stress s, the force f[I] of the same particles under unit
!! stress, and the exact force f_w[I] of unit stress in cells with their weights, which vanishes
!! except at boundaries (A. Perez, M. Barclay, D. Z. Zhang, J. Comput. Phys. (2023) 112681). Towards
!! free surfaces the correction vanishes: there the force is that of the point rule. Equations (Q.4)
!! and (Q.5) of doc/theory/quadratures.md.
module step_stress_difference
   use base_kinds, only: wp
   use ddmp_dual, only: dual_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_node_fields, only: difference_columns, nodes_t
   use step_node_sums, only: divide_nodes
   use step_particles_to_nodes, only: locate_particles
   use step_simulation, only: machine_t, scheme_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_scatter, only: dual_columns
   implicit none
   private

   public :: find_stress_difference

   integer, parameter :: before = 4                  !! Columns before those of the force
   integer, parameter :: rest = 3                    !! Columns behind those of the force

contains

   !> Correction of the force of each node. Weights and volumes of the dual gradient are known.
   subroutine find_stress_difference(space, stores, scheme, machine, scratches, field)
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
         call ensure_patch(nodes%stress%mean, difference_columns, number, space%tiles%own)
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
         call ensure_patch(nodes%stress%star, 6, number, space%tiles%all)
         call ensure_patch(nodes%stress%unit, 3, number, space%tiles%all)
         call ensure_patch(nodes%stress%difference, 3, number, space%tiles%all)
         !$omp parallel do default(none) shared(space, scheme, machine, field) private(tile) &
         !$omp schedule(static)
         do tile = 1, space%tiles%all
            call start_cost(machine, tile)
            call unit_tile(space, scheme%dual, field%nodes, tile)
            call stop_cost(machine, tile)
         end do
         !$omp end parallel do
         !$omp parallel do default(none) shared(space, machine, field) private(tile) &
         !$omp schedule(static)
         do tile = 1, space%tiles%all
            call start_cost(machine, tile)
            call difference_tile(space, field%nodes, tile)
            call stop_cost(machine, tile)
         end do
         !$omp end parallel do
         call machine%timer%stop(machine%phase%grid)
      end associate
   end subroutine find_stress_difference

   !> Stress times volume of the particles of a tile, and their node forces under unit stress.
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
         associate (store => stores(index), grid => space%grid, method => scheme%method, &
            shape => scratch%shape, pushed => scratch%pushed)
            call locate_particles(space, scheme, field, scratch, store, tile)
            call pushed%copy(store%first(tile), store%count(tile), store%position, &
               store%state%volume, store%state%stress)
            ! the volume again: that of the quadrature need not use the shape functions of the basis
            do p = 1, store%count(tile)
               shape%values(p, before + rest) = pushed%volume(p)
            end do
            do k = 1, 6
               do p = 1, store%count(tile)
                  shape%values(p, k) = pushed%volume(p)*pushed%stress(p, k)
               end do
            end do
            call method%basis%scatter_values(grid, shape, before, shape%values, 0, patch)
            do k = 1, rest
               do p = 1, store%count(tile)
                  shape%values(p, k) = shape%values(p, before + k)
               end do
            end do
            call method%basis%scatter_values(grid, shape, rest, shape%values, dual_columns, patch)
            call pushed%make_unit(store%count(tile))
            call method%quadrature%scatter_force(grid, shape, 1, pushed%volume, &
               pushed%stress, patch)
         end associate
      end do
   end subroutine scatter_tile

   !> Mean stress of the nodes of a tile; force of the node stress of unit stress less unit stress.
   subroutine unit_tile(space, dual, nodes, tile)
      type(space_t), intent(in) :: space
      type(dual_t), intent(in) :: dual
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      real(wp) :: total(difference_columns, space%grid%tile_nodes)
      real(wp) :: stress(9, space%grid%tile_nodes)
      integer :: node, k

      call assemble(space%grid, space%tiles, nodes%stress%mean, tile, total)
      nodes%stress%star(:before, :, tile) = total(:before, :)
      nodes%stress%star(before + 1:, :, tile) = total(dual_columns + 1:difference_columns - 1, :)
      call divide_nodes(total, difference_columns, nodes%stress%star(:, :, tile))
      nodes%stress%difference(:, :, tile) = total(before + 1:before + 3, :)
      stress = total(before + 5:dual_columns, :)
      call divide_nodes(nodes%dual%volume(:, :, tile), 1, stress)
      do node = 1, size(stress, 2)
         do k = 1, 9, 4
            stress(k, node) = stress(k, node) - 1.0_wp
         end do
      end do
      nodes%stress%unit(:, :, tile) = 0.0_wp
      call dual%add_force(space%grid, space%tiles%coordinate(:, tile), nodes%dual%weight(:, tile), &
         stress, nodes%stress%unit(:, :, tile))
   end subroutine unit_tile

   !> Change of the force of the nodes of a tile. Equation (Q.4).
   subroutine difference_tile(space, nodes, tile)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      integer, parameter :: component(9) = [1, 4, 6, 4, 2, 5, 6, 5, 3]
      real(wp) :: unit(3, space%grid%tile_nodes), stress(9, space%grid%tile_nodes)
      real(wp) :: inside(space%grid%tile_nodes), around(size(inside)), cells
      integer :: node, k

      call assemble(space%grid, space%tiles, nodes%stress%unit, tile, unit)
      do node = 1, size(stress, 2)
         do k = 1, 9
            stress(k, node) = nodes%stress%star(component(k), node, tile)
         end do
      end do
      call space%boundary%mirror(space%grid, space%tiles%coordinate(:, tile), stress)
      ! weight of the nodes of a tile: 1 inside of bodies, where all cells around count in full, and
      ! 0 if one of them does not count. The weights do not give the position of a surface within
      ! its cells, so the exact force is wrong there. Equation (Q.6)
      call space%grid%node_volume(space%tiles%coordinate(:, tile), around)
      cells = real(2**space%grid%dimensions, wp)
      inside = 0.0_wp
      do node = 1, size(inside)
         if (around(node) > 0.0_wp) inside(node) = &
            max(0.0_wp, 1.0_wp - cells*(1.0_wp - nodes%dual%volume(1, node, tile)/around(node)))
      end do
      do node = 1, size(stress, 2)
         do k = 1, 3
            unit(k, node) = inside(node)*(unit(k, node) + nodes%stress%difference(k, node, tile))
         end do
         do k = 1, 3
            nodes%stress%difference(k, node, tile) = -(stress(k, node)*unit(1, node) &
               + stress(k + 3, node)*unit(2, node) + stress(k + 6, node)*unit(3, node))
         end do
      end do
   end subroutine difference_tile
end module step_stress_difference
