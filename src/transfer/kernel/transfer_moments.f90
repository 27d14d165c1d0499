! SPDX-License-Identifier: BSD-3-Clause
!> Means of a particle field around nodes with the positions of these means, and the slope of the
!! field in a cell from them.
!!
!! The mean around a node is the value of a linear field at the centre of the averaged particles,
!! not at the node. The difference of two means over the distance of their centres is the slope of
!! the field for any positions of particles. Equation (Q.10) of doc/theory/quadratures.md.
module transfer_moments
   use base_kinds, only: wp
   use base_matrix, only: determinant
   use mesh_grid, only: grid_t, lane_bit, lanes
   implicit none
   private

   public :: add_moments, cell_slope, divide_moments

   !> They are in columns: weight, weight times value, weight times the distances from the node in
   !! cells
   integer, parameter, public :: moments = 5
   real(wp), parameter :: flattest = 0.01_wp         !! Least determinant of the centres [1]

contains

   !> Add the moments of the particles of a tile to columns of a patch.
   pure subroutine add_moments(grid, start, first, local, weight, stress, before, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: weight(:)          !! (particle) Volume [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) [Pa]
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: sums(lanes, moments), ends(lanes, 3), share(lanes), pressure
      integer :: cell, p, q, k, lane, node

      do k = 1, 3
         ends(:, k) = [(real(ibits(lane - 1, lane_bit(k), 1), wp), lane=1, lanes)]
      end do
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            pressure = -(stress(q, 1) + stress(q, 2) + stress(q, 3))/3.0_wp
            !$omp simd
            do lane = 1, lanes
               share(lane) = weight(q)*(1.0_wp - abs(ends(lane, 1) - local(p, 1))) &
                  *(1.0_wp - abs(ends(lane, 2) - local(p, 2))) &
                  *(1.0_wp - abs(ends(lane, 3) - local(p, 3)))
               sums(lane, 1) = sums(lane, 1) + share(lane)
               sums(lane, 2) = sums(lane, 2) + share(lane)*pressure
               sums(lane, 3) = sums(lane, 3) + share(lane)*(local(p, 1) - ends(lane, 1))
               sums(lane, 4) = sums(lane, 4) + share(lane)*(local(p, 2) - ends(lane, 2))
               sums(lane, 5) = sums(lane, 5) + share(lane)*(local(p, 3) - ends(lane, 3))
            end do
         end do
         do lane = 1, lanes
            ! ends along a direction that is missing have no particles
            if (.not. present_lane(grid, lane)) cycle
            node = grid%first_node(cell) + grid%lane_offset(lane)
            patch(before + 1:before + moments, node) = &
               patch(before + 1:before + moments, node) + sums(lane, :)
         end do
      end do
   end subroutine add_moments

   !> Does the scene have all directions in which a lane is an upper end?
   pure logical function present_lane(grid, lane) result(yes)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: lane                            !! 1 to 8
      integer :: k

      yes = .true.
      do k = 1, 3
         if (.not. grid%active(k)) yes = yes .and. ibits(lane - 1, lane_bit(k), 1) == 0
      end do
   end function present_lane

   !> Means from the moments of nodes: value, and distances of the centre from the node in cells.
   pure subroutine divide_moments(sums, means)
      real(wp), intent(in) :: sums(:, :)                     !! (moments, node)
      real(wp), intent(inout) :: means(:, :)                 !! (moments - 1, node) 0 if empty
      integer :: node

      do node = 1, size(sums, 2)
         means(:, node) = 0.0_wp
         if (sums(1, node) > 0.0_wp) means(:, node) = sums(2:moments, node)/sums(1, node)
      end do
   end subroutine divide_moments

   !> Slope of the field in a cell [of the field, over a cell], 0 along missing directions and where
   !! the centres do not determine it.
   pure function cell_slope(grid, node, means) result(slope)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: node                            !! First node of the cell
      real(wp), intent(in) :: means(:, :) !! (4, node) Means from `divide_moments`
      real(wp) :: slope(3)
      real(wp) :: rise(4, 3), matrix(3, 3), changed(3, 3), whole, sense
      integer :: lane, l, k

      rise = 0.0_wp
      do lane = 1, lanes
         if (.not. present_lane(grid, lane)) cycle
         do l = 1, 3
            if (.not. grid%active(l)) cycle
            sense = merge(1.0_wp, -1.0_wp, ibits(lane - 1, lane_bit(l), 1) == 1) &
               /real(2**(grid%dimensions - 1), wp)
            rise(:, l) = rise(:, l) + sense*means(:, node + grid%lane_offset(lane))
         end do
      end do
      ! (k, l): distance along k from the centres of the lower ends of l to those of the upper ends
      do l = 1, 3
         do k = 1, 3
            matrix(k, l) = rise(1 + k, l)
         end do
         matrix(l, l) = matrix(l, l) + 1.0_wp
      end do
      slope = 0.0_wp
      whole = determinant(matrix)
      if (.not. whole > flattest) return
      do k = 1, 3
         if (.not. grid%active(k)) cycle
         changed = matrix
         do l = 1, 3
            changed(k, l) = rise(1, l)
         end do
         slope(k) = determinant(changed)/whole
      end do
   end function cell_slope
end module transfer_moments
