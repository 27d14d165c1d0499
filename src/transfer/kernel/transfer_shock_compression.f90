! SPDX-License-Identifier: BSD-3-Clause
!> The compression that artificial viscosity resists: the compression less the part that the
!! gradients of the nodes around predict.
!!
!! In a cell whose neighbours are compressed at the same rate the velocity is linear, and there is
!! no jump to resist, however fast the flow converges (R. B. Christensen, UCRL-JC-105269 (1990); E.
!! J. Caramana, M. J. Shashkov, P. P. Whalen, J. Comput. Phys. 144 (1998) 70). A shock compresses
!! one or two cells, so some neighbour is not compressed. In one dimension the node gradient is the
!! mean of the two adjacent cells, so twice the least node value less the cell value is the least
!! value of the neighbours, without another sum over nodes, and twice the mean of the node values
!! less the cell value is the mean of the neighbours. Equations (V.1) and (V.2) of
!! doc/theory/viscosity.md.
module transfer_shock_compression
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   implicit none
   private

   public :: find_jump, limit_compression, monotone

   !> Ratio of the least compression of a neighbour to that of the cell above which the flow counts
   !! as smooth; at a ratio of 1 viscosity resists nothing.
   real(wp), parameter :: onset = 0.5_wp
   !> Factor of the least compression of a neighbour in the limiter `monotone`, where the mean of
   !! the neighbours is the other bound: a slope that changes evenly is smooth [1]
   real(wp), parameter :: monotone = 1.5_wp
   !> Least fraction of a compression that viscosity resists, where sums are normalised [1]
   real(wp), parameter :: kept = 0.25_wp

contains

   !> Trace of the strain of the step that viscosity resists, for the particles of a tile. The hoop
   !! strain of axisymmetry is not part of it: it is uniform around the axis and has no jump.
   pure subroutine find_jump(grid, start, velocity, gradient, slack, strain, jump)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) That strains [m/s]
      real(wp), contiguous, intent(in) :: gradient(:, :)     !! (9, node) Node gradient [1/s]
      real(wp), intent(in) :: slack                          !! 1 or `monotone` [1]
      real(wp), contiguous, intent(in) :: strain(:, :)       !! (particle, 9) Strain of the step [1]
      real(wp), contiguous, intent(inout) :: jump(:)         !! (particle) [1]
      real(wp) :: left
      integer :: cell, p

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         left = shock_fraction(grid, grid%first_node(cell), velocity, gradient, slack)
         do p = start(cell) + 1, start(cell + 1)
            jump(p) = left*(strain(p, 1) + strain(p, 9))
         end do
         if (grid%axisymmetric) cycle
         do p = start(cell) + 1, start(cell + 1)
            jump(p) = jump(p) + left*strain(p, 5)
         end do
      end do
   end subroutine find_jump

   !> Trace of the strain of the step that viscosity resists where sums are normalised, for the
   !! particles of a tile: at most the compression of the edges of the cell, but at least a fourth
   !! of the strain. Particles that represent more than their own volume are strained more than
   !! their surroundings, and viscosity depends on the square of that. Hoop strains are not limited.
   pure subroutine limit_compression(grid, start, velocity, dt, strain, jump)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) That strains [m/s]
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: strain(:, :)       !! (particle, 9) Strain of the step [1]
      real(wp), contiguous, intent(inout) :: jump(:)         !! (particle) [1]
      real(wp) :: least, hoop, whole
      integer :: cell, p

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         least = -dt*edge_compression(grid, grid%first_node(cell), velocity)
         do p = start(cell) + 1, start(cell + 1)
            hoop = 0.0_wp
            if (grid%axisymmetric) hoop = min(0.0_wp, strain(p, 5))
            whole = strain(p, 1) + strain(p, 5) + strain(p, 9)
            jump(p) = max(whole, min(least + hoop, kept*whole))
         end do
      end do
   end subroutine limit_compression

   !> Rate at which the edges of a cell are compressed, the greatest along each direction [1/s].
   pure real(wp) function edge_compression(grid, base, velocity) result(rate)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: base                            !! First node of the cell
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      integer, parameter :: component(3) = [1, 3, 2]         ! of the bits of a lane
      real(wp) :: most
      integer :: lane, bit

      rate = 0.0_wp
      do bit = 0, grid%dimensions - 1
         most = 0.0_wp
         do lane = 1, 2**grid%dimensions
            if (btest(lane - 1, bit)) cycle
            most = max(most, velocity(component(bit + 1), base + grid%lane_offset(lane)) &
               - velocity(component(bit + 1), base + grid%lane_offset(lane + 2**bit)))
         end do
         rate = rate + most/grid%spacing
      end do
   end function edge_compression

   !> Rate at which a cell is compressed, the mean over its edges [1/s].
   pure real(wp) function compression(grid, base, velocity) result(rate)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: base                            !! First node of the cell
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      integer, parameter :: component(3) = [1, 3, 2]         ! of the bits of a lane
      integer :: lane, bit, last

      last = 2**grid%dimensions
      rate = 0.0_wp
      do lane = 1, last
         do bit = 0, grid%dimensions - 1
            rate = rate + merge(-1.0_wp, 1.0_wp, btest(lane - 1, bit)) &
               *velocity(component(bit + 1), base + grid%lane_offset(lane))
         end do
      end do
      rate = rate*2.0_wp/(real(last, wp)*grid%spacing)
   end function compression

   !> Fraction of the compression of a cell that is not smooth: 0 to 1. A node without cells of
   !! weight has no gradient, so for isolated particles the fraction is 1.
   pure real(wp) function shock_fraction(grid, base, velocity, gradient, slack) result(left)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: base                            !! First node of the cell
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: gradient(:, :)     !! (9, node) [1/s]
      real(wp), intent(in) :: slack                          !! Factor of the least neighbour [1]
      real(wp) :: own, least, mean, here, ratio
      integer :: lane, node

      left = 1.0_wp
      own = compression(grid, base, velocity)
      least = huge(least)
      mean = 0.0_wp
      do lane = 1, 2**grid%dimensions
         node = base + grid%lane_offset(lane)
         here = -(gradient(1, node) + gradient(5, node) + gradient(9, node))
         least = min(least, here)
         mean = mean + here
      end do
      if (.not. own > 0.0_wp) return
      mean = 2.0_wp*mean/(2**grid%dimensions*own) - 1.0_wp
      ratio = min(mean, slack*(2.0_wp*least/own - 1.0_wp))
      left = min(1.0_wp, max(0.0_wp, (1.0_wp - ratio)/(1.0_wp - onset)))
   end function shock_fraction
end module transfer_shock_compression
