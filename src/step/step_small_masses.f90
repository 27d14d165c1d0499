! SPDX-License-Identifier: BSD-3-Clause
!> Bounds the straining velocity of nodes of small mass.
module step_small_masses
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: calm_light_nodes, light_may_gain

   real(wp), parameter :: small = 3.0e-3_wp          !! Share of a cell that is let pass

contains

   !> Does any node gain so much that the bound may apply? Most tiles have no such node and need no
   !! volumes.
   pure logical function light_may_gain(grid, dt, acceleration) result(may)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) [m/s2]

      may = dt**2*sqrt(maxval(acceleration(1, :)**2 + acceleration(2, :)**2 &
         + acceleration(3, :)**2)) > small*grid%spacing
   end function light_may_gain

   !> Bound the gain of a node of small mass in the velocity that strains: its force over its mass
   !! has no bound, while particles near it gain only their part of the force. Node volumes include
   !! the weights of cells, so they measure how empty a node and its cells are. Gains that move a
   !! node by less than a small fraction of a cell are kept. Equation (M.17) of
   !! doc/theory/method.md.
   pure subroutine calm_light_nodes(grid, coordinate, volume, dt, velocity, acceleration, strain)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      real(wp), intent(in) :: volume(:)              !! (node) With the weights of cells [m3]
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) Before the step [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp), contiguous, intent(inout) :: strain(:, :) !! (3, node) Velocity that strains [m/s]
      real(wp), parameter :: light = 0.125_wp        !! Below this share of the volume around
      real(wp) :: around(size(volume)), share, gain
      integer :: node

      if (.not. light_may_gain(grid, dt, acceleration)) return
      call grid%node_volume(coordinate, around)
      do node = 1, size(volume)
         if (.not. volume(node) < light*around(node)) cycle
         gain = dt**2*sqrt(acceleration(1, node)**2 + acceleration(2, node)**2 &
            + acceleration(3, node)**2)
         if (.not. gain > small*grid%spacing) cycle
         share = max(volume(node)/(light*around(node)), small*grid%spacing/gain)
         if (share < 1.0_wp) strain(:, node) = velocity(:, node) + share*dt*acceleration(:, node)
      end do
   end subroutine calm_light_nodes
end module step_small_masses
