! SPDX-License-Identifier: BSD-3-Clause
!> Cells that rigid regions cut, for normalised sums: the fraction of the weight of each edge
!! that is outside of the regions.
!!
!! Material fills the part of a cell outside of the region. Normal to the surface it transmits the
!! pressure of the whole cell, because the node inside the region moves with the wall. Along the
!! surface it transmits the fraction of the cell outside, which follows from the intersections of
!! the surface with the edges that end in the region.
module transfer_cut_cells
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lane_bit, lanes
   use mesh_rigid, only: rigid_t
   use mesh_surface_normal, only: covers
   use mesh_wall, only: node_place, wall_t
   use transfer_edges, only: edges, low_end
   use transfer_hoop, only: hoop_edges
   implicit none
   private

   public :: cut_cells, ramp

   integer, parameter :: halvings = 30               !! Bisections to find the cut of an edge
   !> Position of the cut on an edge, from 0 at the node outside to 1 at the node inside of the
   !! region, from which on the node inside transmits pressure along the surface, and the node
   !! outside transmits the rest [1]
   real(wp), parameter :: half = 0.5_wp
   !> Cut edges with a smaller fraction outside transmit no pressure along the surface, those with
   !! more than twice this fraction all of it [1]
   real(wp), parameter :: thin = 0.25_wp

contains

   !> Fractions of the edges of the cells that regions cut.
   pure subroutine cut_cells(grid, coordinate, rigid, tile, smooth, shares, ring)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      type(rigid_t), intent(in) :: rigid             !! Rigid regions, with their nodes
      integer, intent(in) :: tile                    !! Index of the tile
      logical, intent(in) :: smooth                  !! Are local coordinates smoothed?
      real(wp), intent(inout) :: shares(:, 0:)       !! (edge, cell) [1]
      !> (lane in a plane, cell) Factor of the hoop terms of nodes beyond the surface. With it the
      !! flux through the end of the cell is replaced by that through the surface at its radius [1]
      real(wp), intent(inout) :: ring(:, 0:)
      integer :: owner(grid%tile_nodes), ends(lanes), cell, n

      owner = 0
      ! only nodes inside of the regions; other held nodes are up to half a cell outside
      do n = 1, size(rigid%held(tile)%node)
         associate (node => rigid%held(tile)%node(n), wall => rigid%held(tile)%wall(n))
            if (covers(rigid%wall(wall), grid, node_place(grid, coordinate, node))) &
               owner(node) = wall
         end associate
      end do
      do cell = 0, grid%tile_cells - 1
         ends = owner(grid%first_node(cell) + grid%lane_offset)
         if (all(ends == 0)) cycle
         if (all(ends > 0)) then
            if (all(ends == ends(1)) .and. covers(rigid%wall(ends(1)), grid, cell_centre(grid, &
               coordinate, cell))) shares(:, cell) = 0.0_wp
            cycle
         end if
         call cut_cell(grid, coordinate, rigid%wall, grid%first_node(cell), ends, smooth, &
            shares(:, cell), ring(:, cell))
      end do
   end subroutine cut_cells

   !> Weights of the edges of one cell: along each of the two other directions the mean over the
   !! ends of an edge of the fraction outside of the region, weighted with the function of the end.
   pure subroutine cut_cell(grid, coordinate, wall, node, ends, smooth, share, ring)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      type(wall_t), intent(in) :: wall(:)            !! All regions
      integer, intent(in) :: node                    !! First node of the cell
      integer, intent(in) :: ends(lanes)             !! (lane) Region that covers the node, 0 = none
      logical, intent(in) :: smooth                  !! Are local coordinates smoothed?
      real(wp), intent(inout) :: share(:)            !! (edge) [1]
      real(wp), intent(inout) :: ring(:)             !! (lane in a plane) As of `cut_cells` [1]
      real(wp) :: outside(lanes, 3), place(3), at, far
      integer :: lane, next, l, e, k, low

      outside = 1.0_wp
      do l = 1, 3
         if (.not. grid%active(l)) cycle
         do lane = 1, lanes
            next = 1 + ieor(lane - 1, ishft(1, lane_bit(l)))
            if (ends(lane) > 0 .and. ends(next) > 0) outside(lane, l) = 0.0_wp
            if (ends(lane) > 0 .or. ends(next) == 0) cycle
            place = node_place(grid, coordinate, node + grid%lane_offset(lane))
            at = cut_at(grid, wall(ends(next)), place, l, sign(1.0_wp, real(next - lane, wp)))
            far = (2.0_wp*at - near_share(at, smooth))*ramp((at - half)/half)
            outside(lane, l) = 2.0_wp*at*ramp((at - thin)/thin) - far
            outside(next, l) = far
            ! lanes beyond those of a plane are the same nodes again
            if (l == 1 .and. next <= size(ring)) ring(next) = 2.0_wp*at - 1.0_wp
         end do
      end do
      do l = 1, 3
         if (.not. grid%active(l)) cycle
         do e = 1, edges
            low = low_end(l, e)
            next = low + ishft(1, lane_bit(l))
            ! an edge that ends in the region is traversed from its end outside
            if (ends(low) > 0 .and. ends(next) == 0) low = next
            if (ends(next) > 0 .and. ends(low) == 0) next = low
            do k = 1, 3
               if (k == l .or. .not. grid%active(k)) cycle
               share(edges*(l - 1) + e) = share(edges*(l - 1) + e)*0.5_wp &
                  *(outside(low, k) + outside(next, k))
            end do
         end do
      end do
      ! hoop terms balance the radial ones of the same edge
      if (grid%axisymmetric) share(hoop_edges) = share([1, 1, 2, 2])
   end subroutine cut_cell

   !> Smooth step from 0 to 1 [1].
   pure real(wp) function ramp(x) result(y)
      real(wp), intent(in) :: x                      !! Below 0: 0, above 1: 1

      y = min(1.0_wp, max(0.0_wp, x))
      y = y**2*(3.0_wp - 2.0_wp*y)
   end function ramp

   !> Centre of a cell [m].
   pure function cell_centre(grid, coordinate, cell) result(centre)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      integer, intent(in) :: cell                    !! Cell of the tile, from 0
      real(wp) :: centre(3)

      centre = 0.5_wp*(node_place(grid, coordinate, grid%first_node(cell)) &
         + node_place(grid, coordinate, grid%first_node(cell) + grid%lane_offset(lanes)))
   end function cell_centre

   !> Fraction of the integral of the function of the near end of an edge up to a position along it
   !! [1].
   pure real(wp) function near_share(place, smooth) result(share)
      real(wp), intent(in) :: place                  !! 0 to 1
      logical, intent(in) :: smooth                  !! Is the local coordinate smoothed?

      if (smooth) then
         share = 2.0_wp*(place - place**3 + 0.5_wp*place**4)
      else
         share = 2.0_wp*(place - 0.5_wp*place**2)
      end if
   end function near_share

   !> Intersection with a region of an edge from a node outside to a node inside, 0 to 1 [1].
   pure real(wp) function cut_at(grid, wall, place, direction, sense) result(at)
      type(grid_t), intent(in) :: grid
      type(wall_t), intent(in) :: wall
      real(wp), intent(in) :: place(3)               !! Position of the node outside [m]
      integer, intent(in) :: direction               !! Direction of the edge
      real(wp), intent(in) :: sense                  !! 1 upwards, -1 downwards [1]
      real(wp) :: low, high, x(3)
      integer :: n

      low = 0.0_wp
      high = 1.0_wp
      do n = 1, halvings
         at = 0.5_wp*(low + high)
         x = place
         x(direction) = x(direction) + sense*at*grid%spacing
         if (covers(wall, grid, x)) then
            high = at
         else
            low = at
         end if
      end do
      at = 0.5_wp*(low + high)
   end function cut_at
end module transfer_cut_cells
