! SPDX-License-Identifier: BSD-3-Clause
!> Rotation of matter as it varies from tile to tile (`turn_from = 'tiles'`).
!!
!! With RFLIP the rotation that particles carry brings velocities to the nodes that straining sees
!! and the particles do not keep: the work of the stress on them is lost. Where the rotation is that
!! of a body this work is nothing, as a rotation has no strain. The rotation of single particles
!! wavers from one to the next; a vibrating ring of five cells loses a third of its energy by it.
!! Here each particle gets the mean by mass of the rotations around it, with weights that fall
!! linearly over the edge of a tile. Equation (T.13) of doc/theory/transfers.md.
module driver_rotation
   use base_kinds, only: wp
   use driver_exchange, only: edge_tiles, inner_tiles, next_tiles, pass_patches
   use driver_simulation, only: simulation_t
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch, extent_of
   use particle_store, only: store_t
   implicit none
   private

   public :: smooth_rotation

   integer, parameter :: corners = 8                 !! Of a tile
   integer, parameter :: columns = 4                 !! Mass times rotation, and mass

contains

   !> Give all particles the rotation of the matter around them. The particles are sorted.
   subroutine smooth_rotation(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run, its particles carry a rotation
      integer, allocatable :: tiles(:)
      integer :: part, n, tile

      call simulation%timer%start(simulation%phase%scatter)
      call ensure_patch(simulation%nodes%turn, columns, simulation%grid%tile_nodes, &
         simulation%tiles%own)
      do part = edge_tiles, inner_tiles
         call next_tiles(simulation, part, tiles)
         !$omp parallel do default(none) shared(simulation, tiles) private(n) schedule(dynamic, 1)
         do n = 1, size(tiles)
            call add_tile(simulation, tiles(n), simulation%nodes%turn(:, :, tiles(n)))
         end do
         !$omp end parallel do
         call pass_patches(simulation, part, simulation%nodes%turn)
      end do
      !$omp parallel do default(none) shared(simulation) private(tile) schedule(dynamic, 1)
      do tile = 1, simulation%tiles%own
         call turn_tile(simulation, tile)
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%scatter)
   end subroutine smooth_rotation

   !> Mass and its rotation at the corners of a tile, from its particles.
   subroutine add_tile(simulation, tile, patch)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node) Not zero at corners only
      real(wp) :: sums(columns, corners), lower(3), inverse(3)
      integer :: node(corners), index, corner

      call clear_patch(patch)
      call measure_tile(simulation, tile, lower, inverse)
      sums = 0.0_wp
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            if (store%count(tile) > 0) call add_store(store, tile, lower, inverse, sums)
         end associate
      end do
      call find_corners(simulation, tile, node)
      do corner = 1, corners
         patch(:, node(corner)) = patch(:, node(corner)) + sums(:, corner)
      end do
   end subroutine add_tile

   !> Those of one material.
   pure subroutine add_store(store, tile, lower, inverse, sums)
      type(store_t), intent(in) :: store             !! The particles
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: lower(3)               !! Lower corner of the tile [m]
      real(wp), intent(in) :: inverse(3)             !! One over its edges [1/m]
      real(wp), intent(inout) :: sums(columns, corners) !! At the corners [kg/s], [kg]
      real(wp) :: weight(corners), value(columns), place(3)
      integer :: p, corner

      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         place = store%position(p, :)
         call weigh_corners(place, lower, inverse, weight)
         value(1:3) = store%matter%mass(p)*store%spin(p, :)
         value(4) = store%matter%mass(p)
         do corner = 1, corners
            sums(:, corner) = sums(:, corner) + weight(corner)*value
         end do
      end do
   end subroutine add_store

   !> Rotation of the particles of a tile, from its corners.
   subroutine turn_tile(simulation, tile)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp) :: total(columns, simulation%grid%tile_nodes), turn(3, corners), weight(corners)
      real(wp) :: lower(3), inverse(3), place(3), spin(3)
      integer :: node(corners), corner, index, p

      call assemble(simulation%grid, simulation%tiles, simulation%nodes%turn, tile, total)
      call find_corners(simulation, tile, node)
      call measure_tile(simulation, tile, lower, inverse)
      turn = 0.0_wp
      do corner = 1, corners
         if (total(4, node(corner)) > 0.0_wp) &
            turn(:, corner) = total(1:3, node(corner))/total(4, node(corner))
      end do
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            do p = store%first(tile), store%first(tile) + store%count(tile) - 1
               place = store%position(p, :)
               call weigh_corners(place, lower, inverse, weight)
               spin = 0.0_wp
               do corner = 1, corners
                  spin = spin + weight(corner)*turn(:, corner)
               end do
               store%spin(p, :) = spin
            end do
         end associate
      end do
   end subroutine turn_tile

   !> Nodes at the corners of a tile; those of a missing direction fall together.
   pure subroutine find_corners(simulation, tile, node)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      integer, intent(out) :: node(corners)          !! Their numbers
      integer :: corner, extent(3), margin(3), bit(3), k

      associate (grid => simulation%grid)
         extent = extent_of(grid, simulation%tiles, tile)
         margin = merge(grid%margin, 0, grid%active)
         do corner = 1, corners
            bit = [(ibits(corner - 1, k - 1, 1), k=1, 3)]
            node(corner) = 1 + dot_product(bit*extent + margin, grid%stride)
         end do
      end associate
   end subroutine find_corners

   !> Where a tile lies: its lower corner, and one over its edges; 0 for missing directions.
   pure subroutine measure_tile(simulation, tile, lower, inverse)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(out) :: lower(3)              !! [m]
      real(wp), intent(out) :: inverse(3)            !! [1/m]
      integer :: extent(3)

      associate (grid => simulation%grid)
         extent = max(1, extent_of(grid, simulation%tiles, tile))
         lower = grid%lower + real(simulation%tiles%coordinate(:, tile)*grid%width, wp)*grid%spacing
         inverse = merge(1.0_wp/(real(extent, wp)*grid%spacing), 0.0_wp, grid%active)
      end associate
   end subroutine measure_tile

   !> Weights of the corners of a tile at a place in it: products of linear functions.
   pure subroutine weigh_corners(place, lower, inverse, weight)
      real(wp), intent(in) :: place(3)               !! [m]
      real(wp), intent(in) :: lower(3)               !! Lower corner of the tile [m]
      real(wp), intent(in) :: inverse(3)             !! One over its edges [1/m]
      real(wp), intent(out) :: weight(corners)       !! Their sum is 1; 0 for missing directions
      real(wp) :: high(3), plane(4)

      high = min(1.0_wp, max(0.0_wp, (place - lower)*inverse))
      plane(1:2) = [1.0_wp - high(1), high(1)]
      plane(3:4) = plane(1:2)*high(2)
      plane(1:2) = plane(1:2) - plane(3:4)
      weight(5:8) = plane*high(3)
      weight(1:4) = plane - weight(5:8)
   end subroutine weigh_corners
end module driver_rotation
