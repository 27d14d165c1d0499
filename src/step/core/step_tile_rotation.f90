! SPDX-License-Identifier: BSD-3-Clause
!> Rotation of material as a smooth field over the tiles (`turn_from = 'tiles'`).
!!
!! With RFLIP the rotation of particles adds velocities to the nodes that enter the strain but are
!! not kept by the particles: the work of the stress on them is lost. For the rotation of a whole
!! body this work is zero, as a rotation has no strain. But the rotation of single particles varies
!! from one to the next; a vibrating ring of five cells loses a third of its energy this way. Here
!! each particle gets the mass-weighted mean of the rotations around it, with weights that fall
!! linearly over the edge of a tile. Equation (T.8) of doc/theory/transfers.md.
module step_tile_rotation
   use base_kinds, only: wp
   use base_lane_sum, only: add_products
   use mesh_patch, only: assemble, clear_patch, ensure_patch, extent_of
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_simulation, only: machine_t, simulation_effects_t, space_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: smooth_tile_rotation

   integer, parameter :: corners = 8                 !! Number of corners of a tile
   integer, parameter :: columns = 4                 !! Mass times rotation, and mass
   integer, parameter :: chunk = 128                 !! Particles whose weights stay in cache

contains

   !> Give all particles the rotation of the material around them. The particles are sorted.
   subroutine smooth_tile_rotation(space, stores, effects, machine)
      type(space_t), intent(inout) :: space
      type(store_t), intent(inout) :: stores(:)
      type(simulation_effects_t), intent(inout) :: effects
      type(machine_t), intent(inout) :: machine
      integer, allocatable :: tiles(:)
      integer :: part, n, tile

      call machine%timer%start(machine%phase%scatter)
      call ensure_patch(effects%turn, columns, space%grid%tile_nodes, space%tiles%own)
      do part = edge_tiles, inner_tiles
         call next_tiles(space, machine%communicator, part, tiles)
         !$omp parallel do default(none) shared(space, stores, effects, machine, tiles) private(n) &
         !$omp schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(machine, tiles(n))
            call add_tile(space, stores, tiles(n), effects%turn(:, :, tiles(n)))
            call stop_cost(machine, tiles(n))
         end do
         !$omp end parallel do
         call send_patches(space, machine, part, effects%turn, 0)
      end do
      !$omp parallel do default(none) shared(space, stores, effects, machine) private(tile) &
      !$omp schedule(dynamic, 1)
      do tile = 1, space%tiles%own
         call start_cost(machine, tile)
         call turn_tile(space, stores, effects, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%scatter)
   end subroutine smooth_tile_rotation

   !> Mass and its rotation at the corners of a tile, from its particles.
   subroutine add_tile(space, stores, tile, patch)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node) Not zero at corners only
      real(wp) :: sums(columns, corners), lower(3), inverse(3)
      integer :: node(corners), index, corner

      call clear_patch(patch)
      call measure_tile(space, tile, lower, inverse)
      sums = 0.0_wp
      do index = 1, size(stores)
         associate (store => stores(index))
            if (store%count(tile) > 0) call add_store(store, tile, lower, inverse, sums)
         end associate
      end do
      call find_corners(space, tile, node)
      do corner = 1, corners
         patch(:, node(corner)) = patch(:, node(corner)) + sums(:, corner)
      end do
   end subroutine add_tile

   !> The same of one material, in chunks that stay in cache.
   pure subroutine add_store(store, tile, lower, inverse, sums)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: lower(3)               !! Lower corner of the tile [m]
      real(wp), intent(in) :: inverse(3)             !! One over its edges [1/m]
      real(wp), intent(inout) :: sums(columns, corners) !! Sums at the corners [kg/s], [kg]
      real(wp) :: weight(chunk, corners), value(chunk, columns), total
      integer :: before, count, corner, column, p

      do before = store%first(tile) - 1, store%first(tile) + store%count(tile) - 2, chunk
         count = min(chunk, store%first(tile) + store%count(tile) - 1 - before)
         call weigh_corners(count, before, store%position, lower, inverse, weight)
         do p = 1, count
            value(p, columns) = store%state%mass(before + p)
         end do
         do column = 1, columns - 1
            do p = 1, count
               value(p, column) = value(p, columns)*store%spin(before + p, column)
            end do
         end do
         do corner = 1, corners
            do column = 1, columns
               total = 0.0_wp
               call add_products(count, value(:, column), weight(:, corner), total)
               sums(column, corner) = sums(column, corner) + total
            end do
         end do
      end do
   end subroutine add_store

   !> Rotation of the particles of a tile, from its corners.
   subroutine turn_tile(space, stores, effects, tile)
      type(space_t), intent(in) :: space
      type(store_t), intent(inout) :: stores(:)
      type(simulation_effects_t), intent(in) :: effects
      integer, intent(in) :: tile
      real(wp) :: total(columns, space%grid%tile_nodes), turn(3, corners)
      real(wp) :: lower(3), inverse(3)
      integer :: node(corners), corner, index

      call assemble(space%grid, space%tiles, effects%turn, tile, total)
      call find_corners(space, tile, node)
      call measure_tile(space, tile, lower, inverse)
      turn = 0.0_wp
      do corner = 1, corners
         if (total(4, node(corner)) > 0.0_wp) &
            turn(:, corner) = total(1:3, node(corner))/total(4, node(corner))
      end do
      do index = 1, size(stores)
         if (stores(index)%count(tile) > 0) call turn_store(stores(index), tile, lower, &
            inverse, turn)
      end do
   end subroutine turn_tile

   !> The same of the particles of one material.
   pure subroutine turn_store(store, tile, lower, inverse, turn)
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: lower(3)               !! Lower corner of the tile [m]
      real(wp), intent(in) :: inverse(3)             !! One over its edges [1/m]
      real(wp), intent(in) :: turn(3, corners)       !! Rotation at the corners [1/s]
      real(wp) :: weight(chunk, corners), spin
      integer :: before, count, corner, k, p

      do before = store%first(tile) - 1, store%first(tile) + store%count(tile) - 2, chunk
         count = min(chunk, store%first(tile) + store%count(tile) - 1 - before)
         call weigh_corners(count, before, store%position, lower, inverse, weight)
         do k = 1, 3
            do p = 1, count
               spin = 0.0_wp
               do corner = 1, corners
                  spin = spin + weight(p, corner)*turn(k, corner)
               end do
               store%spin(before + p, k) = spin
            end do
         end do
      end do
   end subroutine turn_store

   !> Nodes at the corners of a tile; those along a missing direction coincide.
   pure subroutine find_corners(space, tile, node)
      type(space_t), intent(in) :: space
      integer, intent(in) :: tile
      integer, intent(out) :: node(corners)          !! Numbers of the nodes
      integer :: corner, extent(3), margin(3), bit(3), k

      associate (grid => space%grid)
         extent = extent_of(grid, space%tiles, tile)
         margin = merge(grid%margin, 0, grid%active)
         do corner = 1, corners
            bit = [(ibits(corner - 1, k - 1, 1), k=1, 3)]
            node(corner) = 1 + dot_product(bit*extent + margin, grid%stride)
         end do
      end associate
   end subroutine find_corners

   !> Lower corner of a tile, and the inverse of its edges; 0 for missing directions.
   pure subroutine measure_tile(space, tile, lower, inverse)
      type(space_t), intent(in) :: space
      integer, intent(in) :: tile
      real(wp), intent(out) :: lower(3)              !! [m]
      real(wp), intent(out) :: inverse(3)            !! [1/m]
      integer :: extent(3)

      associate (grid => space%grid)
         extent = max(1, extent_of(grid, space%tiles, tile))
         lower = grid%lower + real(space%tiles%coordinate(:, tile)*grid%width, wp)*grid%spacing
         inverse = merge(1.0_wp/(real(extent, wp)*grid%spacing), 0.0_wp, grid%active)
      end associate
   end subroutine measure_tile

   !> Weights of the corners of a tile at particles: products of linear functions, whose sum is 1;
   !! 0 for missing directions.
   pure subroutine weigh_corners(count, before, position, lower, inverse, weight)
      integer, intent(in) :: count                   !! Particles of the chunk
      integer, intent(in) :: before                  !! Index offset in the store
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) [m]
      real(wp), intent(in) :: lower(3)               !! Lower corner of the tile [m]
      real(wp), intent(in) :: inverse(3)             !! One over its edges [1/m]
      real(wp), intent(inout) :: weight(chunk, corners) !! (particle of the chunk, corner)
      real(wp) :: x, y, z
      integer :: p

      !$omp simd private(x, y, z)
      do p = 1, count
         x = min(1.0_wp, max(0.0_wp, (position(before + p, 1) - lower(1))*inverse(1)))
         y = min(1.0_wp, max(0.0_wp, (position(before + p, 2) - lower(2))*inverse(2)))
         z = min(1.0_wp, max(0.0_wp, (position(before + p, 3) - lower(3))*inverse(3)))
         weight(p, 1) = (1.0_wp - x)*(1.0_wp - y)*(1.0_wp - z)
         weight(p, 2) = x*(1.0_wp - y)*(1.0_wp - z)
         weight(p, 3) = (1.0_wp - x)*y*(1.0_wp - z)
         weight(p, 4) = x*y*(1.0_wp - z)
         weight(p, 5) = (1.0_wp - x)*(1.0_wp - y)*z
         weight(p, 6) = x*(1.0_wp - y)*z
         weight(p, 7) = (1.0_wp - x)*y*z
         weight(p, 8) = x*y*z
      end do
   end subroutine weigh_corners
end module step_tile_rotation
