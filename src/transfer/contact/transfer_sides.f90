! SPDX-License-Identifier: BSD-3-Clause
!> The two sides of failed material in a body that has contact with itself.
!!
!! A particle belongs to one of two sides at each node: by the sign of its gradient of intact volume
!! along the axis of the node, so that the two sides of a crack have separate velocities
!! (M. A. Homel, E. B. Herbold, Int. J. Numer. Meth. Engng 109 (2017) 1013). The node has two
!! velocities only where failed material lies between its sides. Section "Failed material" of
!! doc/theory/contact.md.
module transfer_sides
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lane_bit
   use particle_store, only: store_t
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: add_cell_slopes, choose_sides, find_axis, is_cut, is_split, join_sides, lane_place, &
      measure_failed, measure_intact, set_products, sides_t, weigh_sides

   integer, parameter, public :: product_rows = 11   !! Rows of sums that give the axis
   integer, parameter, public :: part_rows = 4       !! Rows of sums of both sides
   !> Least failed or void fraction of the volume of a node for its sides to separate. In a cell
   !! with two rows of particles one row has a fourth of the volume of a node half a cell away
   real(wp), parameter :: enough = 0.2_wp
   real(wp), parameter :: few = 1.0e-3_wp            !! Ignored fraction of a side

   !> Nodes of the cell of a particle at which the particle is on the second side.
   type :: lane_bits_t
      integer, allocatable :: other(:)               !! (particle) Bit lane - 1: on the second side
   end type lane_bits_t

   !> The two sides of one velocity field. The second side uses a velocity field of its own, to
   !! which no particles are assigned.
   type :: sides_t
      integer :: before = 0                          !! Stores before those of the field
      type(lane_bits_t), allocatable :: store(:)     !! (store of the field)
      real(wp), allocatable :: patch(:, :, :)        !! Sums of the particles of a tile
      real(wp), allocatable :: intact(:, :)          !! (node, own tile) Intact volume fraction [1]
      real(wp), allocatable :: slope(:, :, :)        !! (3, node, own tile) grad intact [1/m]
      real(wp), allocatable :: axis(:, :, :)         !! (3, node, own tile) Axis of the sides [1]
      logical, allocatable :: split(:, :)            !! (node, tile) Are its sides separated?
      logical, allocatable :: cut(:)                 !! (tile) Has it a node with split sides?
   contains
      procedure :: reserve => sides_reserve          !! Memory for a number of tiles
      procedure :: take_cells => sides_take_cells    !! Plain gradient in cells with split nodes
      procedure :: drop_cells => sides_drop_cells    !! No weight for cells with split nodes
   end type sides_t

contains

   !> Reserve memory for the nodes of tiles.
   pure subroutine sides_reserve(self, nodes, all)
      class(sides_t), intent(inout) :: self
      integer, intent(in) :: nodes                   !! Nodes of a tile
      integer, intent(in) :: all                     !! Tiles, ghosts included

      if (allocated(self%cut)) then
         if (size(self%cut) >= all) return
         deallocate (self%cut, self%split)
      end if
      allocate (self%cut(all + all/16), self%split(nodes, all + all/16))
   end subroutine sides_reserve

   !> True if a cell has a node whose sides are separated.
   pure logical function is_cut(grid, cell, split) result(cut)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                    !! Cell of the tile, from 0
      logical, intent(in) :: split(:)                !! (node)
      integer :: lane

      cut = .false.
      do lane = 1, 2**grid%dimensions
         cut = cut .or. split(grid%first_node(cell) + grid%lane_offset(lane))
      end do
   end function is_cut

   !> Use the gradient of the cell alone for particles in cells with separated sides.
   pure subroutine sides_take_cells(self, grid, tile, shape)
      class(sides_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: tile
      type(shape_data_t), intent(inout) :: shape     !! Particles of the tile, located
      integer :: cell, p

      if (.not. self%cut(tile)) return
      do cell = 0, grid%tile_cells - 1
         if (.not. is_cut(grid, cell, self%split(:, tile))) cycle
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            shape%alpha(p, :) = 1.0_wp
            shape%blend(p, :) = shape%local(p, :)
         end do
      end do
   end subroutine sides_take_cells

   !> Give cells with separated sides no weight in the dual gradient.
   pure subroutine sides_drop_cells(self, grid, tile, weight)
      class(sides_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: weight(0:) !! (cell) Weights of the dual gradient
      integer :: cell

      if (.not. self%cut(tile)) return
      do cell = 0, grid%tile_cells - 1
         if (is_cut(grid, cell, self%split(:, tile))) weight(cell) = 0.0_wp
      end do
   end subroutine sides_drop_cells

   !> Weight of a node of the cell of a particle, and the position of the particle relative to that
   !! node.
   pure subroutine lane_place(grid, lane, local, weight, away)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: lane                    !! Number of a node of the cell
      real(wp), intent(in) :: local(3)               !! Local coordinates of the particle
      real(wp), intent(out) :: weight                !! Function of the node [1]
      real(wp), intent(out) :: away(3)               !! Vector from the node to the particle [m]
      integer :: k

      weight = product(grid%lane_constant(lane, :) + grid%lane_slope(lane, :)*local)
      do k = 1, 3
         away(k) = 0.0_wp
         if (grid%active(k)) away(k) = grid%spacing*(local(k) &
            - real(ibits(lane - 1, lane_bit(k), 1), wp))
      end do
   end subroutine lane_place

   !> Intact volume and total volume of the particles of a tile: the sums of (C.9).
   pure subroutine measure_intact(store, tile, volume)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(inout) :: volume(:, :)        !! (particle of the tile, column) Two [m3]
      integer :: p, q

      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         volume(p, 2) = store%state%volume(q)
         volume(p, 1) = volume(p, 2)
         if (allocated(store%state%damage)) volume(p, 1) = volume(p, 1)*(1.0_wp &
            - min(1.0_wp, max(0.0_wp, store%state%damage(q))))
         if (allocated(store%state%failed)) volume(p, 1) = merge(0.0_wp, volume(p, 1), &
            store%state%failed(q) /= 0)
      end do
   end subroutine measure_intact

   !> Failed volume of a particle [m3].
   pure real(wp) function measure_failed(store, particle) result(volume)
      type(store_t), intent(in) :: store
      integer, intent(in) :: particle                !! Index in the store

      volume = 0.0_wp
      if (.not. allocated(store%state%failed)) return
      if (store%state%failed(particle) /= 0) volume = store%state%volume(particle)
   end function measure_failed

   !> Contribution of the cells of a tile to the gradient of the intact fraction at their nodes:
   !! differences along the edges that end there and have material at both ends, and the number of
   !! these edges. Equation (C.10).
   pure subroutine add_cell_slopes(grid, intact, patch)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: intact(:)              !! (node) Negative without material [1]
      real(wp), intent(inout) :: patch(:, :)         !! (row, node) Gradients [1/m], edges [1]
      integer :: cell, lane, node, k, low, high

      do cell = 0, grid%tile_cells - 1
         do lane = 1, 2**grid%dimensions
            node = grid%first_node(cell) + grid%lane_offset(lane)
            do k = 1, 3
               if (.not. grid%active(k)) cycle
               low = node
               if (btest(lane - 1, lane_bit(k))) low = node - grid%stride(k)
               high = low + grid%stride(k)
               if (min(intact(low), intact(high)) < 0.0_wp) cycle
               patch(k, node) = patch(k, node) + (intact(high) - intact(low))/grid%spacing
               patch(3 + k, node) = patch(3 + k, node) + 1.0_wp
            end do
         end do
      end do
   end subroutine add_cell_slopes

   !> Contribution of the particles of a tile to the axis of their nodes: volume times the products
   !! of their gradient, volume that has not failed, failed volume. Equation (C.11).
   pure subroutine set_products(store, tile, slope, values)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: slope(:, :)            !! (particle of the tile, 3) [1/m]
      real(wp), intent(inout) :: values(:, :)        !! (particle of the tile, row)
      integer, parameter :: first(6) = [1, 2, 3, 1, 2, 3], second(6) = [1, 2, 3, 2, 3, 1]
      integer :: p, q, k

      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         do k = 1, 6
            values(p, k) = store%state%volume(q)*slope(p, first(k))*slope(p, second(k))
         end do
         values(p, 8) = measure_failed(store, q)
         values(p, 7) = store%state%volume(q) - values(p, 8)
      end do
   end subroutine set_products

   !> Axis of a node: the direction along which the gradients around it differ most. Zero where
   !! nothing or too little has failed. Its sign is that of its greatest component. Equation (C.11).
   pure function find_axis(sums, volume) result(axis)
      real(wp), intent(in) :: sums(product_rows)     !! Sums over the particles
      real(wp), intent(in) :: volume                 !! Volume of the node [m3]
      real(wp) :: axis(3), a(3, 3), v(3, 3), all
      integer :: turn, k

      axis = 0.0_wp
      if (.not. sums(8) > 0.0_wp .or. sums(7) > (1.0_wp - enough)*volume) return
      all = sums(7) + sums(8)
      a = reshape([sums(1), sums(4), sums(6), sums(4), sums(2), sums(5), sums(6), sums(5), &
         sums(3)], [3, 3])
      do k = 1, 3
         a(:, k) = a(:, k)/all - (sums(9:11)/all)*(sums(8 + k)/all)
      end do
      if (.not. maxval(abs(a)) > 0.0_wp) return
      a = a/maxval(abs(a))
      v = 0.0_wp
      do k = 1, 3
         v(k, k) = 1.0_wp
      end do
      do turn = 1, 8
         call rotate(1, 2, a, v)
         call rotate(2, 3, a, v)
         call rotate(1, 3, a, v)
      end do
      k = maxloc([a(1, 1), a(2, 2), a(3, 3)], dim=1)
      axis = v(:, k)
      if (axis(maxloc(abs(axis), dim=1)) < 0.0_wp) axis = -axis
   end function find_axis

   !> Jacobi rotation that makes one pair of elements of a symmetric matrix zero.
   pure subroutine rotate(i, j, a, v)
      integer, intent(in) :: i, j                    !! Row and column
      real(wp), intent(inout) :: a(3, 3)             !! Updated
      real(wp), intent(inout) :: v(3, 3)             !! Rotations so far, in columns
      real(wp) :: theta, t, c, s, column(3)

      if (.not. abs(a(i, j)) > tiny(1.0_wp)) return
      theta = 0.5_wp*(a(j, j) - a(i, i))/a(i, j)
      t = sign(1.0_wp, theta)/(abs(theta) + sqrt(theta*theta + 1.0_wp))
      c = 1.0_wp/sqrt(t*t + 1.0_wp)
      s = t*c
      column = a(:, i)
      a(:, i) = c*column - s*a(:, j)
      a(:, j) = s*column + c*a(:, j)
      column = a(i, :)
      a(i, :) = c*column - s*a(j, :)
      a(j, :) = s*column + c*a(j, :)
      column = v(:, i)
      v(:, i) = c*column - s*v(:, j)
      v(:, j) = s*column + c*v(:, j)
   end subroutine rotate

   !> Sides of the particles of a tile at the nodes of their cells. Equation (C.12).
   pure subroutine choose_sides(grid, shape, first, slope, axis, other)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape        !! Particles of the tile, located
      integer, intent(in) :: first                   !! First particle of the tile
      real(wp), intent(in) :: slope(:, :)            !! (particle of the tile, 3) [1/m]
      real(wp), intent(in) :: axis(:, :)             !! (3, node) 0 if not separated [1]
      integer, intent(inout) :: other(:)             !! (particle) Bits of the nodes
      integer :: cell, lane, node, p

      do cell = 0, grid%tile_cells - 1
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            other(first + p - 1) = 0
            do lane = 1, 2**grid%dimensions
               node = grid%first_node(cell) + grid%lane_offset(lane)
               if (axis(1, node)*slope(p, 1) + axis(2, node)*slope(p, 2) &
                  + axis(3, node)*slope(p, 3) < 0.0_wp) &
                  other(first + p - 1) = ibset(other(first + p - 1), lane - 1)
            end do
         end do
      end do
   end subroutine choose_sides

   !> Data that decide whether the sides of nodes separate: the volumes of both, and their positions
   !! along the axis times volume.
   pure subroutine weigh_sides(grid, shape, store, tile, axis, other, patch)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape        !! Particles of the tile, located
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: axis(:, :)             !! (3, node) 0 if not separated [1]
      integer, intent(in) :: other(:)                !! (particle) Bits of the nodes
      real(wp), intent(inout) :: patch(:, :)         !! (row, node)
      real(wp) :: weight, away(3), local(3)
      integer :: cell, lane, node, p, q, side

      do cell = 0, grid%tile_cells - 1
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            q = store%first(tile) + p - 1
            local = shape%local(p, :)
            do lane = 1, 2**grid%dimensions
               node = grid%first_node(cell) + grid%lane_offset(lane)
               if (all(abs(axis(:, node)) <= 0.0_wp)) cycle
               call lane_place(grid, lane, local, weight, away)
               side = ibits(other(q), lane - 1, 1)
               weight = weight*store%state%volume(q)
               patch(1 + side, node) = patch(1 + side, node) + weight
               patch(3 + side, node) = patch(3 + side, node) + weight*dot_product(away, &
                  axis(:, node))
            end do
         end do
      end do
   end subroutine weigh_sides

   !> True if the two sides of a node separate: each has material, and the first is ahead along the
   !! axis, as is its gradient; sides whose gradients point towards each other are one body.
   !! Equation (C.13).
   pure logical function is_split(sums) result(split)
      real(wp), intent(in) :: sums(part_rows)        !! Sums over the particles

      split = min(sums(1), sums(2)) > few*(sums(1) + sums(2))
      if (split) split = sums(3)/sums(1) > sums(4)/sums(2)
   end function is_split

   !> Assign the particles of a tile to the first side again at nodes whose sides have not
   !! separated.
   pure subroutine join_sides(grid, start, first, split, other)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: start(0:)               !! (0:cells) Particles before a cell
      integer, intent(in) :: first                   !! First particle of the tile
      logical, intent(in) :: split(:)                !! (node)
      integer, intent(inout) :: other(:)             !! (particle) Bits of the nodes
      integer :: cell, lane, p, parted

      do cell = 0, grid%tile_cells - 1
         parted = 0
         do lane = 1, 2**grid%dimensions
            if (split(grid%first_node(cell) + grid%lane_offset(lane))) parted = ibset(parted, &
               lane - 1)
         end do
         do p = start(cell) + 1, start(cell + 1)
            other(first + p - 1) = iand(other(first + p - 1), parted)
         end do
      end do
   end subroutine join_sides
end module transfer_sides
