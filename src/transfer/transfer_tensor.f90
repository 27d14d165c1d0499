! SPDX-License-Identifier: BSD-3-Clause
!> Node functions that are products of functions of one coordinate, on the nodes -1 to 2 of the cell
!! along each direction. A basis of this kind only says what these functions are (`weigh`).
!!
!! All particles of a cell share a block of 4 nodes along each direction. Particles to nodes: the
!! four nodes of a line along x are the lanes. Nodes to particles: the particles are the lanes, and
!! the sum over a line along x is taken first, so that a line costs little more than a node.
module transfer_tensor
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_basis, only: basis_t
   use transfer_gather, only: locate
   use transfer_places, only: line, places_t
   implicit none
   private

   public :: basis_tensor_t, fold_walls

   !> Node functions that are products.
   type, abstract, extends(basis_t) :: basis_tensor_t
   contains
      procedure :: margin => tensor_margin                   !! Layers of nodes beyond a tile
      procedure :: reach => tensor_reach                     !! Nodes of a line that are touched
      procedure :: locate => tensor_locate                   !! Places and functions
      procedure(weigh_i), deferred :: weigh                  !! Functions along the directions
      procedure :: spread => tensor_spread                   !! Values to nodes
      procedure :: spread_affine => tensor_spread_affine     !! Mass and a linear velocity field
      procedure :: spread_stress => tensor_spread_stress     !! Force of the stress
      procedure :: collect => tensor_collect                 !! Node values to particles
      procedure :: collect_gradient => tensor_collect_gradient !! Their gradients
      procedure :: collect_affine => tensor_collect_affine   !! Linear velocity field
   end type basis_tensor_t

   abstract interface
      !> Functions of the particles of a tile along one direction, from their places in the cell:
      !! weight, slope and low of `places`, as if there were no walls.
      pure subroutine weigh_i(self, grid, store, tile, direction, places)
         import :: basis_tensor_t, grid_t, places_t, store_t
         implicit none
         class(basis_tensor_t), intent(in) :: self
         type(grid_t), intent(in) :: grid                       !! The grid
         type(store_t), intent(in) :: store                     !! The particles
         integer, intent(in) :: tile                            !! Index of the tile
         integer, intent(in) :: direction                       !! 1 to 3
         type(places_t), intent(inout) :: places                !! Of the tile
      end subroutine weigh_i
   end interface

contains

   !> One layer of nodes beyond a tile.
   pure integer function tensor_margin(self) result(margin)
      class(basis_tensor_t), intent(in) :: self              !! The basis

      margin = 1
   end function tensor_margin

   !> Nodes along a line that a particle touches, counted from `low` on; three, unless the basis
   !! says
   !! otherwise.
   pure integer function tensor_reach(self) result(reach)
      class(basis_tensor_t), intent(in) :: self              !! The basis

      reach = 3
   end function tensor_reach

   !> Places in the cells and functions of all directions.
   pure subroutine tensor_locate(self, grid, coordinate, store, tile, places)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store                     !! The particles
      integer, intent(in) :: tile                            !! Index of the tile
      type(places_t), intent(inout) :: places                !! What the maps need
      integer :: direction

      call locate(grid, store%first(tile), store%count(tile), store%position, places%local)
      call places%reserve_wide(store%count(tile))
      do direction = 1, 3
         if (grid%active(direction)) then
            call self%weigh(grid, store, tile, direction, places)
            call fold_walls(grid, coordinate, store%cell_start(:, tile), direction, places%weight, &
               places%slope)
         else
            places%weight(:, :, direction) = 0.0_wp
            places%weight(:, 1, direction) = 1.0_wp
            places%slope(:, :, direction) = 0.0_wp
            places%low(:, direction) = 1
         end if
      end do
   end subroutine tensor_locate

   !> Give the function of a node outside a wall to the two nodes inside by linear extrapolation,
   !! 2 f to the node on the wall and -f to the next one. Linear fields stay exact, and the node on
   !! the wall has the only function that is not zero there. These are the boundary splines of M.
   !! Steffen, R. M. Kirby, M. Berzins, Int. J. Numer. Methods Eng. 76 (2008) 922.
   pure subroutine fold_walls(grid, coordinate, start, direction, weight, slope)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: direction                       !! 1 to 3
      real(wp), contiguous, intent(inout) :: weight(:, :, :) !! (particle of the tile, node, 3)
      real(wp), contiguous, intent(inout) :: slope(:, :, :)  !! The same
      integer :: cell, place, side, out, on, in

      if (.not. any(grid%wall(2*direction - 1:2*direction))) return
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         place = coordinate(direction)*grid%width(direction) + grid%cell_position(direction, cell)
         do side = 1, 2
            if (.not. grid%wall(2*direction - 2 + side)) cycle
            if (place /= merge(0, grid%cells(direction) - 1, side == 1)) cycle
            out = merge(1, 4, side == 1)
            on = merge(2, 3, side == 1)
            in = merge(3, 2, side == 1)
            call fold(weight(:, out, direction), weight(:, on, direction), weight(:, in, direction))
            call fold(slope(:, out, direction), slope(:, on, direction), slope(:, in, direction))
         end do
      end do

   contains

      !> Fold the functions of the particles of one cell.
      pure subroutine fold(outside, wall, inside)
         real(wp), intent(inout) :: outside(:)       !! Becomes zero
         real(wp), intent(inout) :: wall(:)          !! Gets twice as much
         real(wp), intent(inout) :: inside(:)        !! Loses it
         integer :: p

         do p = start(cell) + 1, start(cell + 1)
            wall(p) = wall(p) + 2.0_wp*outside(p)
            inside(p) = inside(p) - outside(p)
            outside(p) = 0.0_wp
         end do
      end subroutine fold
   end subroutine fold_walls

   !> Nodes along the lines of a block: 4, or 1 along a missing direction.
   pure function block_of(grid) result(length)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer :: length(3)

      length = merge(line, 1, grid%active)
   end function block_of

   !> First node of the block of a cell.
   pure integer function corner_of(grid, cell) result(node)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0

      node = grid%first_node(cell) - sum(grid%stride)
   end function corner_of

   !> Add the lines of a block to the patch.
   pure subroutine add_block(grid, cell, count, sums, before, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      integer, intent(in) :: count                           !! Number of columns
      real(wp), intent(in) :: sums(line, line, line, count)  !! (x, y, z, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: length(3), base, node, i, j, k, c

      length = block_of(grid)
      base = corner_of(grid, cell)
      do k = 1, length(3)
         do j = 1, length(2)
            do i = 1, line
               node = base + (i - 1) + (j - 1)*grid%stride(2) + (k - 1)*grid%stride(3)
               do c = 1, count
                  patch(before + c, node) = patch(before + c, node) + sums(i, j, k, c)
               end do
            end do
         end do
      end do
   end subroutine add_block

   !> Add sum S_i value to columns of a patch.
   pure subroutine tensor_spread(self, grid, start, places, count, values, before, patch)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(places_t), intent(in) :: places                   !! Of the tile
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(line, line, line, count), x(line), factor
      integer :: reach(3), cell, p, j, k, c

      reach = min(self%reach(), block_of(grid))
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            x = [places%weight(p, 1, 1), places%weight(p, 2, 1), places%weight(p, 3, 1), &
               places%weight(p, 4, 1)]
            do k = places%low(p, 3), places%low(p, 3) + reach(3) - 1
               do j = places%low(p, 2), places%low(p, 2) + reach(2) - 1
                  factor = places%weight(p, j, 2)*places%weight(p, k, 3)
                  do c = 1, count
                     sums(:, j, k, c) = sums(:, j, k, c) + x*(factor*values(p, c))
                  end do
               end do
            end do
         end do
         call add_block(grid, cell, count, sums, before, patch)
      end do
   end subroutine tensor_spread

   !> Add mass and momentum of linear velocity fields (C. Jiang, C. Schroeder, A. Selle, J. Teran,
   !! A.
   !! Stomakhin, ACM Trans. Graph. 34 (2015) 51).
   ! gate: long kernel because a tile is told by its grid, range and places
   pure subroutine tensor_spread_affine(self, grid, start, first, places, mass, velocity, affine, &
      patch)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(places_t), intent(in) :: places                   !! Of the tile
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(line, line, line, 4), x(line), away(line), factor, d2, d3, v(3)
      integer :: reach(3), cell, p, q, i, j, k, c

      reach = min(self%reach(), block_of(grid))
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            do i = 1, line
               x(i) = places%weight(p, i, 1)
               away(i) = grid%spacing*(real(i - 2, wp) - places%local(p, 1))
            end do
            do k = places%low(p, 3), places%low(p, 3) + reach(3) - 1
               d3 = merge(grid%spacing*(real(k - 2, wp) - places%local(p, 3)), 0.0_wp, reach(3) > 1)
               do j = places%low(p, 2), places%low(p, 2) + reach(2) - 1
                  d2 = merge(grid%spacing*(real(j - 2, wp) - places%local(p, 2)), 0.0_wp, &
                     reach(2) > 1)
                  factor = mass(q)*places%weight(p, j, 2)*places%weight(p, k, 3)
                  sums(:, j, k, 1) = sums(:, j, k, 1) + x*factor
                  do c = 1, 3
                     v(c) = velocity(q, c) + affine(q, c + 3)*d2 + affine(q, c + 6)*d3
                     sums(:, j, k, 1 + c) = sums(:, j, k, 1 + c) &
                        + x*(factor*(v(c) + affine(q, c)*away))
                  end do
               end do
            end do
         end do
         call add_block(grid, cell, 4, sums, 0, patch)
      end do
   end subroutine tensor_spread_affine

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
   pure subroutine tensor_spread_stress(self, grid, start, first, places, volume, stress, patch)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      type(places_t), intent(in) :: places                   !! Of the tile
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(line, line, line, 3), x(line), dx(line), s(6), a, b, c
      integer :: reach(3), cell, p, j, k

      reach = min(self%reach(), block_of(grid))
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            x = [places%weight(p, 1, 1), places%weight(p, 2, 1), places%weight(p, 3, 1), &
               places%weight(p, 4, 1)]
            dx = [places%slope(p, 1, 1), places%slope(p, 2, 1), places%slope(p, 3, 1), &
               places%slope(p, 4, 1)]
            associate (q => first + p - 1)
               s = -volume(q)*[stress(q, 1), stress(q, 2), stress(q, 3), stress(q, 4), &
                  stress(q, 5), stress(q, 6)]
            end associate
            do k = places%low(p, 3), places%low(p, 3) + reach(3) - 1
               do j = places%low(p, 2), places%low(p, 2) + reach(2) - 1
                  a = places%weight(p, j, 2)*places%weight(p, k, 3)
                  b = places%slope(p, j, 2)*places%weight(p, k, 3)
                  c = places%weight(p, j, 2)*places%slope(p, k, 3)
                  sums(:, j, k, 1) = sums(:, j, k, 1) + dx*(a*s(1)) + x*(b*s(4) + c*s(6))
                  sums(:, j, k, 2) = sums(:, j, k, 2) + dx*(a*s(4)) + x*(b*s(2) + c*s(5))
                  sums(:, j, k, 3) = sums(:, j, k, 3) + dx*(a*s(6)) + x*(b*s(5) + c*s(3))
               end do
            end do
         end do
         call add_block(grid, cell, 3, sums, 4, patch)
      end do
   end subroutine tensor_spread_stress

   !> Values sum S_i node_i.
   pure subroutine tensor_collect(self, grid, start, places, nodes, values)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(places_t), intent(in) :: places                   !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      integer :: length(3), cell, p, j, k, c, node
      real(wp) :: u1, u2, u3, u4

      length = block_of(grid)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         do c = 1, size(nodes, 1)
            values(start(cell) + 1:start(cell + 1), c) = 0.0_wp
            do k = 1, length(3)
               do j = 1, length(2)
                  node = corner_of(grid, cell) + (j - 1)*grid%stride(2) + (k - 1)*grid%stride(3)
                  u1 = nodes(c, node)
                  u2 = nodes(c, node + 1)
                  u3 = nodes(c, node + 2)
                  u4 = nodes(c, node + 3)
                  do concurrent (p=start(cell) + 1:start(cell + 1))
                     values(p, c) = values(p, c) + places%weight(p, j, 2)*places%weight(p, k, 3) &
                        *(places%weight(p, 1, 1)*u1 + places%weight(p, 2, 1)*u2 &
                        + places%weight(p, 3, 1)*u3 + places%weight(p, 4, 1)*u4)
                  end do
               end do
            end do
         end do
      end do
   end subroutine tensor_collect

   !> Scaled velocity gradient scale sum u_k dS_i/dx_l.
   pure subroutine tensor_collect_gradient(self, grid, start, places, nodes, scale, gradient)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(places_t), intent(in) :: places                   !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      integer :: length(3), cell, p, j, k, c, node
      real(wp) :: u1, u2, u3, u4, along, across

      length = block_of(grid)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         gradient(start(cell) + 1:start(cell + 1), :) = 0.0_wp
         do c = 1, 3
            do k = 1, length(3)
               do j = 1, length(2)
                  node = corner_of(grid, cell) + (j - 1)*grid%stride(2) + (k - 1)*grid%stride(3)
                  u1 = scale*nodes(c, node)
                  u2 = scale*nodes(c, node + 1)
                  u3 = scale*nodes(c, node + 2)
                  u4 = scale*nodes(c, node + 3)
                  !$omp simd private(along, across)
                  do p = start(cell) + 1, start(cell + 1)
                     along = places%slope(p, 1, 1)*u1 + places%slope(p, 2, 1)*u2 &
                        + places%slope(p, 3, 1)*u3 + places%slope(p, 4, 1)*u4
                     across = places%weight(p, 1, 1)*u1 + places%weight(p, 2, 1)*u2 &
                        + places%weight(p, 3, 1)*u3 + places%weight(p, 4, 1)*u4
                     gradient(p, c) = gradient(p, c) &
                        + places%weight(p, j, 2)*places%weight(p, k, 3)*along
                     gradient(p, c + 3) = gradient(p, c + 3) &
                        + places%slope(p, j, 2)*places%weight(p, k, 3)*across
                     gradient(p, c + 6) = gradient(p, c + 6) &
                        + places%weight(p, j, 2)*places%slope(p, k, 3)*across
                  end do
               end do
            end do
         end do
      end do
   end subroutine tensor_collect_gradient

   !> Linear velocity field: C_kl = sum S_i u_k (x_i - x)_l / sum S_i (x_i - x)_l**2, which keeps
   !! angular momentum (C. Jiang and others, 2015, as above). The second moments are a diagonal
   !! matrix, because the functions are products and have no first moments.
   pure subroutine tensor_collect_affine(self, grid, start, places, nodes, affine)
      class(basis_tensor_t), intent(in) :: self              !! The basis
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      type(places_t), intent(in) :: places                   !! Of the tile
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), contiguous, intent(inout) :: affine(:, :)    !! (particle of the tile, 9) [1/s]
      type(places_t) :: moments
      real(wp) :: away, moment, least
      integer :: p, direction, n

      ! least second moment that divides: on a wall there is one function and no gradient across it
      least = 1.0e-6_wp*grid%spacing**2
      moments = places
      do direction = 1, 3
         if (.not. grid%active(direction)) cycle
         do p = 1, start(grid%tile_cells)
            moment = 0.0_wp
            do n = 1, line
               away = grid%spacing*(real(n - 2, wp) - places%local(p, direction))
               moments%slope(p, n, direction) = places%weight(p, n, direction)*away
               moment = moment + places%weight(p, n, direction)*away**2
            end do
            do n = 1, line
               moments%slope(p, n, direction) = moments%slope(p, n, direction)/max(moment, least)
            end do
         end do
      end do
      call self%collect_gradient(grid, start, moments, nodes, 1.0_wp, affine)
   end subroutine tensor_collect_affine
end module transfer_tensor
