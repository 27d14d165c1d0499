! SPDX-License-Identifier: BSD-3-Clause
!> Transfers between the particles of a body with self-contact and nodes with two separated sides,
!! with the linear functions of the cell.
!!
!! Tiles without separated nodes use the kernels of other bodies. Tiles with such nodes use them
!! too; then the sums of the separated nodes are computed again for each side, and particles on the
!! second side get the difference from the first side. Section "Failed material" of
!! doc/theory/contact.md.
module transfer_side_kernels
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_shape_data, only: shape_data_t
   use transfer_sides, only: is_cut, lane_place
   implicit none
   private

   public :: add_other_gradient, add_other_values, add_side_areas, find_side_reach, scatter_sides

contains

   !> Gradient of the function of a node in the cell of a particle [1/m].
   pure function lane_gradient(grid, lane, local) result(gradient)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: lane                    !! Number of a node of the cell
      real(wp), intent(in) :: local(3)               !! Local coordinates of the particle
      real(wp) :: gradient(3), weight(3)
      integer :: k

      weight = grid%lane_constant(lane, :) + grid%lane_slope(lane, :)*local
      do k = 1, 3
         gradient(k) = grid%lane_slope(lane, k)/grid%spacing &
            *weight(1 + mod(k, 3))*weight(1 + mod(k + 1, 3))
      end do
   end function lane_gradient

   !> Mass, momentum and force of the particles of a tile on its separated nodes, for both sides.
   !! Columns 1 mass, 2-4 momentum, 5-7 force, 8 volume if the patch has it. Equation (C.14).
   pure subroutine scatter_sides(grid, shape, store, tile, other, split, patches)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape        !! Particles of the tile, located
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer, intent(in) :: other(:)                !! (particle) Bits of the nodes
      logical, intent(in) :: split(:)                !! (node)
      real(wp), intent(inout) :: patches(:, :, 0:)   !! (column, node, side)
      real(wp) :: weight, away(3), columns(8), local(3), stress(6)
      integer :: cell, lane, node, p, q, side, rows

      rows = min(8, size(patches, 1))
      do cell = 0, grid%tile_cells - 1
         if (.not. is_cut(grid, cell, split)) cycle
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            q = store%first(tile) + p - 1
            local = shape%local(p, :)
            stress = store%state%stress(q, :)
            do lane = 1, 2**grid%dimensions
               node = grid%first_node(cell) + grid%lane_offset(lane)
               if (.not. split(node)) cycle
               side = ibits(other(q), lane - 1, 1)
               call lane_place(grid, lane, local, weight, away)
               columns(1) = weight*store%state%mass(q)
               columns(2:4) = columns(1)*velocity_at(store, q, -away)
               columns(5:7) = -store%state%volume(q)*pull(stress, lane_gradient(grid, lane, local))
               if (grid%axisymmetric) columns(5) = columns(5) - weight*store%state%volume(q) &
                  *store%state%stress(q, 2)/store%position(q, 1)
               columns(8) = weight*store%state%volume(q)
               patches(:rows, node, side) = patches(:rows, node, side) + columns(:rows)
            end do
         end do
      end do
   end subroutine scatter_sides

   !> Velocity field of a particle at a position near it [m/s].
   pure function velocity_at(store, particle, away) result(velocity)
      type(store_t), intent(in) :: store
      integer, intent(in) :: particle                !! Index in the store
      real(wp), intent(in) :: away(3)                !! Position relative to the particle [m]
      real(wp) :: velocity(3)
      integer :: l

      velocity = store%velocity(particle, :)
      if (allocated(store%affine)) then
         do l = 1, 3
            velocity = velocity + store%affine(particle, 3*l - 2:3*l)*away(l)
         end do
      else if (allocated(store%spin)) then
         associate (w => store%spin(particle, :))
            velocity = velocity + [w(2)*away(3) - w(3)*away(2), w(3)*away(1) - w(1)*away(3), &
               w(1)*away(2) - w(2)*away(1)]
         end associate
      end if
   end function velocity_at

   !> Stress times a vector.
   pure function pull(stress, vector) result(product)
      real(wp), intent(in) :: stress(6)              !! [Pa]
      real(wp), intent(in) :: vector(3)              !! [1/m]
      real(wp) :: product(3)

      product(1) = stress(1)*vector(1) + stress(4)*vector(2) + stress(6)*vector(3)
      product(2) = stress(4)*vector(1) + stress(2)*vector(2) + stress(5)*vector(3)
      product(3) = stress(6)*vector(1) + stress(5)*vector(2) + stress(3)*vector(3)
   end function pull

   !> Add sum S_i (theirs_i - mine_i), times a factor, to columns of the particles that are on the
   !! other side of node i. Equation (C.15).
   pure subroutine add_other_values(grid, shape, first, other, split, factor, mine, theirs, &
      before, values)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape        !! Particles of the tile, located
      integer, intent(in) :: first                   !! First particle of the tile
      integer, intent(in) :: other(:)                !! (particle) Bits of the nodes
      logical, intent(in) :: split(:)                !! (node)
      real(wp), intent(in) :: factor                 !! Such as the step [s]
      real(wp), intent(in) :: mine(:, :)             !! (column, node) Node values of the first side
      real(wp), intent(in) :: theirs(:, :)           !! (column, node) Node values of the other side
      integer, intent(in) :: before                  !! Rows of the values before the tile
      real(wp), intent(inout) :: values(:, :)        !! (particle, column)
      real(wp) :: weight, away(3), local(3)
      integer :: cell, lane, node, p, c

      do cell = 0, grid%tile_cells - 1
         if (.not. is_cut(grid, cell, split)) cycle
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            local = shape%local(p, :)
            do lane = 1, 2**grid%dimensions
               if (.not. btest(other(first + p - 1), lane - 1)) cycle
               node = grid%first_node(cell) + grid%lane_offset(lane)
               call lane_place(grid, lane, local, weight, away)
               do c = 1, size(mine, 1)
                  values(before + p, c) = values(before + p, c) + factor*weight*(theirs(c, node) &
                     - mine(c, node))
               end do
            end do
         end do
      end do
   end subroutine add_other_values

   !> The same for the gradient of a vector, scale sum (theirs_i - mine_i) grad S_i.
   pure subroutine add_other_gradient(grid, shape, store, tile, other, split, scale, difference, &
      gradient)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape        !! Particles of the tile, located
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer, intent(in) :: other(:)                !! (particle) Bits of the nodes
      logical, intent(in) :: split(:)                !! (node)
      real(wp), intent(in) :: scale                  !! Such as the step [s]
      real(wp), intent(in) :: difference(:, :)       !! (3, node) Other side less the first [m/s]
      real(wp), intent(inout) :: gradient(:, :)      !! (particle of the tile, 9)
      real(wp) :: slope(3), weight, away(3), local(3)
      integer :: cell, lane, node, p, l

      do cell = 0, grid%tile_cells - 1
         if (.not. is_cut(grid, cell, split)) cycle
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            local = shape%local(p, :)
            do lane = 1, 2**grid%dimensions
               if (.not. btest(other(store%first(tile) + p - 1), lane - 1)) cycle
               node = grid%first_node(cell) + grid%lane_offset(lane)
               slope = scale*lane_gradient(grid, lane, local)
               do l = 1, 3
                  gradient(p, 3*l - 2:3*l) = gradient(p, 3*l - 2:3*l) + difference(:, node)*slope(l)
               end do
               if (.not. grid%axisymmetric) cycle
               call lane_place(grid, lane, local, weight, away)
               gradient(p, 5) = gradient(p, 5) + scale*weight*difference(1, node) &
                  /store%position(store%first(tile) + p - 1, 1)
            end do
         end do
      end do
   end subroutine add_other_gradient

   !> Outward areas of one side on the separated nodes of a tile, (C.1) for its particles.
   pure subroutine add_side_areas(grid, shape, store, tile, other, split, side, area)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape        !! Particles of the tile, located
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer, intent(in) :: other(:)                !! (particle) Bits of the nodes
      logical, intent(in) :: split(:)                !! (node)
      integer, intent(in) :: side                    !! 0 or 1
      real(wp), intent(inout) :: area(:, :)          !! (3, node) [m2]
      real(wp) :: weight, away(3), local(3)
      integer :: cell, lane, node, p, q

      do cell = 0, grid%tile_cells - 1
         if (.not. is_cut(grid, cell, split)) cycle
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            q = store%first(tile) + p - 1
            local = shape%local(p, :)
            do lane = 1, 2**grid%dimensions
               node = grid%first_node(cell) + grid%lane_offset(lane)
               if (.not. split(node)) cycle
               if (ibits(other(q), lane - 1, 1) /= side) cycle
               area(:, node) = area(:, node) &
                  + store%state%volume(q)*lane_gradient(grid, lane, local)
               if (.not. grid%axisymmetric) cycle
               call lane_place(grid, lane, local, weight, away)
               area(1, node) = area(1, node) + weight*store%state%volume(q)/store%position(q, 1)
            end do
         end do
      end do
   end subroutine add_side_areas

   !> Extent of the particles of one side along the normals of the separated nodes of a tile: one
   !! side of (C.2).
   pure subroutine find_side_reach(grid, shape, first, other, split, side, half, normal, reach)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape        !! Particles of the tile, located
      integer, intent(in) :: first                   !! First particle of the tile
      integer, intent(in) :: other(:)                !! (particle) Bits of the nodes
      logical, intent(in) :: split(:)                !! (node)
      integer, intent(in) :: side                    !! 0 or 1
      real(wp), intent(in) :: half(:)                !! (particle of the tile) Half its width [m]
      real(wp), intent(in) :: normal(:, :)           !! (3, node) [1]
      real(wp), intent(inout) :: reach(:)            !! (node) So far [m]
      real(wp) :: weight, away(3), local(3)
      integer :: cell, lane, node, p

      do cell = 0, grid%tile_cells - 1
         if (.not. is_cut(grid, cell, split)) cycle
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            local = shape%local(p, :)
            do lane = 1, 2**grid%dimensions
               node = grid%first_node(cell) + grid%lane_offset(lane)
               if (.not. split(node) .or. all(abs(normal(:, node)) <= 0.0_wp)) cycle
               if (ibits(other(first + p - 1), lane - 1, 1) /= side) cycle
               call lane_place(grid, lane, local, weight, away)
               reach(node) = max(reach(node), dot_product(away, normal(:, node)) + half(p))
            end do
         end do
      end do
   end subroutine find_side_reach
end module transfer_side_kernels
