! SPDX-License-Identifier: BSD-3-Clause
!> Particles to nodes with the linear functions of the cell.
!!
!! For each cell the values of its eight nodes are kept as vectors of eight lanes, particles are
!! added one by one in their order, and the cell is added to the patch of the tile once.
!! Columns of the patch: 1 mass, 2-4 momentum, 5-7 internal force, and for the dual domain method
!! 8 volume, 9-17 stress that stays on the nodes.
module transfer_scatter
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   implicit none
   private

   public :: scatter_affine, scatter_dual_force, scatter_force, scatter_hoop, scatter_motion, &
      scatter_product, scatter_turning, scatter_values

   integer, parameter, public :: motion_columns = 7  !! Mass, momentum, force
   integer, parameter, public :: dual_columns = 17   !! With volume and node stress
   integer, parameter :: edges = 4                   !! Of a cell along a direction

contains

   !> Add mass and momentum to columns 1 to 4 of a patch.
   pure subroutine scatter_motion(grid, start, first, local, mass, velocity, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: a(lanes, 3), b(lanes, 3), sums(lanes, 4), weight
      integer :: cell, p, q, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            do lane = 1, lanes
               weight = (a(lane, 1) + b(lane, 1)*local(p, 1)) &
                  *(a(lane, 2) + b(lane, 2)*local(p, 2)) &
                  *(a(lane, 3) + b(lane, 3)*local(p, 3))*mass(q)
               sums(lane, 1) = sums(lane, 1) + weight
               sums(lane, 2) = sums(lane, 2) + weight*velocity(q, 1)
               sums(lane, 3) = sums(lane, 3) + weight*velocity(q, 2)
               sums(lane, 4) = sums(lane, 4) + weight*velocity(q, 3)
            end do
         end do
         call add_cell(grid, cell, sums, 0, patch)
      end do
   end subroutine scatter_motion

   !> Add sum S_i value to columns of a patch.
   pure subroutine scatter_values(grid, start, local, count, values, before, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: a(lanes, 3), b(lanes, 3), sums(lanes, count), shape(lanes)
      integer :: cell, p, c, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            do lane = 1, lanes
               shape(lane) = (a(lane, 1) + b(lane, 1)*local(p, 1)) &
                  *(a(lane, 2) + b(lane, 2)*local(p, 2))*(a(lane, 3) + b(lane, 3)*local(p, 3))
            end do
            do c = 1, count
               do lane = 1, lanes
                  sums(lane, c) = sums(lane, c) + shape(lane)*values(p, c)
               end do
            end do
         end do
         call add_cell(grid, cell, sums, before, patch)
      end do
   end subroutine scatter_values

   !> Add mass and momentum of linear velocity fields, sum m S_i (v + C (x_i - x)), to columns 1 to
   !! 4 of a patch (C. Jiang, C. Schroeder, A. Selle, J. Teran, A. Stomakhin, ACM Trans. Graph. 34
   !! (2015) 51).
   pure subroutine scatter_affine(grid, start, first, local, mass, velocity, affine, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: a(lanes, 3), b(lanes, 3), sums(lanes, 4), weight, d1, d2, d3, h
      integer :: cell, p, q, lane

      a = grid%lane_constant
      b = grid%lane_slope
      h = grid%spacing
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            do lane = 1, lanes
               weight = (a(lane, 1) + b(lane, 1)*local(p, 1)) &
                  *(a(lane, 2) + b(lane, 2)*local(p, 2)) &
                  *(a(lane, 3) + b(lane, 3)*local(p, 3))*mass(q)
               ! the constant of a lane is 1 on the lower node, and the slope 0 without a direction
               d1 = h*b(lane, 1)**2*(1.0_wp - a(lane, 1) - local(p, 1))
               d2 = h*b(lane, 2)**2*(1.0_wp - a(lane, 2) - local(p, 2))
               d3 = h*b(lane, 3)**2*(1.0_wp - a(lane, 3) - local(p, 3))
               sums(lane, 1) = sums(lane, 1) + weight
               sums(lane, 2) = sums(lane, 2) + weight*(velocity(q, 1) + affine(q, 1)*d1 &
                  + affine(q, 4)*d2 + affine(q, 7)*d3)
               sums(lane, 3) = sums(lane, 3) + weight*(velocity(q, 2) + affine(q, 2)*d1 &
                  + affine(q, 5)*d2 + affine(q, 8)*d3)
               sums(lane, 4) = sums(lane, 4) + weight*(velocity(q, 3) + affine(q, 3)*d1 &
                  + affine(q, 6)*d2 + affine(q, 9)*d3)
            end do
         end do
         call add_cell(grid, cell, sums, 0, patch)
      end do
   end subroutine scatter_affine

   !> Add mass and momentum of particles that turn, sum m S_i (v + w x (x_i - x)), to columns 1 to 4
   !! of a patch.
   pure subroutine scatter_turning(grid, start, first, local, mass, velocity, spin, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) w [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: a(lanes, 3), b(lanes, 3), upper(lanes, 3), sums(lanes, 4), weight, v(3), w(3)
      integer :: cell, p, q, lane

      a = grid%lane_constant
      b = grid%lane_slope
      ! place of each lane in its cell; a missing direction has none
      upper = grid%spacing*b**2*(1.0_wp - a)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            w = [spin(q, 1), spin(q, 2), spin(q, 3)]
            ! the velocity field at the lower corner of the cell
            v(1) = velocity(q, 1) - grid%spacing*(w(2)*local(p, 3) - w(3)*local(p, 2))
            v(2) = velocity(q, 2) - grid%spacing*(w(3)*local(p, 1) - w(1)*local(p, 3))
            v(3) = velocity(q, 3) - grid%spacing*(w(1)*local(p, 2) - w(2)*local(p, 1))
            do lane = 1, lanes
               weight = (a(lane, 1) + b(lane, 1)*local(p, 1)) &
                  *(a(lane, 2) + b(lane, 2)*local(p, 2)) &
                  *(a(lane, 3) + b(lane, 3)*local(p, 3))*mass(q)
               sums(lane, 1) = sums(lane, 1) + weight
               sums(lane, 2) = sums(lane, 2) &
                  + weight*(v(1) + w(2)*upper(lane, 3) - w(3)*upper(lane, 2))
               sums(lane, 3) = sums(lane, 3) &
                  + weight*(v(2) + w(3)*upper(lane, 1) - w(1)*upper(lane, 3))
               sums(lane, 4) = sums(lane, 4) &
                  + weight*(v(3) + w(1)*upper(lane, 2) - w(2)*upper(lane, 1))
            end do
         end do
         call add_cell(grid, cell, sums, 0, patch)
      end do
   end subroutine scatter_turning

   !> Add mass times a vector to three columns of a patch, one a component.
   pure subroutine scatter_product(grid, start, first, local, mass, vector, before, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: vector(:, :)       !! (particle of the tile, 3) [m/s]
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node) [kg m/s]
      real(wp) :: a(lanes, 3), b(lanes, 3), sums(lanes, 3), weight
      integer :: cell, p, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            do lane = 1, lanes
               weight = (a(lane, 1) + b(lane, 1)*local(p, 1)) &
                  *(a(lane, 2) + b(lane, 2)*local(p, 2)) &
                  *(a(lane, 3) + b(lane, 3)*local(p, 3))*mass(first + p - 1)
               sums(lane, 1) = sums(lane, 1) + weight*vector(p, 1)
               sums(lane, 2) = sums(lane, 2) + weight*vector(p, 2)
               sums(lane, 3) = sums(lane, 3) + weight*vector(p, 3)
            end do
         end do
         call add_cell(grid, cell, sums, before, patch)
      end do
   end subroutine scatter_product

   !> Add the internal force of the plain method, - sum v sigma . grad S, to columns 5 to 7.
   !!
   !! The slope of a function along a direction is the same on both ends of an edge, with opposite
   !! signs, so the sums are those of the twelve edges: half the work of eight nodes, and each cell
   !! by itself keeps momentum exactly.
   pure subroutine scatter_force(grid, start, first, local, volume, stress, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: kept(edges, 9), sums(lanes, 3), load(6), scale
      integer :: cell, p, q, k

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         kept = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            scale = volume(q)/grid%spacing
            do k = 1, 6
               load(k) = scale*stress(q, k)
            end do
            call add_edges(local(p, 1), local(p, 2), local(p, 3), load, kept)
         end do
         call join_edges(grid%active, kept, sums)
         call add_cell(grid, cell, sums, 4, patch)
      end do
   end subroutine scatter_force

   !> Add the load of a particle to the edges of its cell, which are the lanes. Edges along x are
   !! counted along z and y, those along y along x and z, those along z along x and y; upper edges
   !! of a missing direction get nothing.
   pure subroutine add_edges(x, y, z, load, kept)
      real(wp), intent(in) :: x, y, z                        !! Place in the cell [1]
      real(wp), intent(in) :: load(6)                        !! Stress times volume over spacing [N]
      real(wp), intent(inout) :: kept(edges, 9) !! (edge, component k + 3 (direction - 1)) [N]
      ! function of an edge: constant and slope along the first of its two directions, then second
      real(wp), parameter :: a1(edges) = [1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]
      real(wp), parameter :: b1(edges) = [-1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp]
      real(wp), parameter :: a2(edges) = [1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
      real(wp), parameter :: b2(edges) = [-1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp]
      real(wp) :: along_x, along_y, along_z
      integer :: edge

      !$omp simd private(along_x, along_y, along_z)
      do edge = 1, edges
         along_x = (a1(edge) + b1(edge)*z)*(a2(edge) + b2(edge)*y)
         along_y = (a1(edge) + b1(edge)*x)*(a2(edge) + b2(edge)*z)
         along_z = (a1(edge) + b1(edge)*x)*(a2(edge) + b2(edge)*y)
         kept(edge, 1) = kept(edge, 1) + along_x*load(1)
         kept(edge, 2) = kept(edge, 2) + along_x*load(4)
         kept(edge, 3) = kept(edge, 3) + along_x*load(6)
         kept(edge, 4) = kept(edge, 4) + along_y*load(4)
         kept(edge, 5) = kept(edge, 5) + along_y*load(2)
         kept(edge, 6) = kept(edge, 6) + along_y*load(5)
         kept(edge, 7) = kept(edge, 7) + along_z*load(6)
         kept(edge, 8) = kept(edge, 8) + along_z*load(5)
         kept(edge, 9) = kept(edge, 9) + along_z*load(3)
      end do
   end subroutine add_edges

   !> Force on the nodes: what an edge gives to its lower node it takes from its upper one.
   pure subroutine join_edges(active, kept, sums)
      logical, intent(in) :: active(3)                       !! Directions that the scene has
      real(wp), intent(in) :: kept(2, 2, 9)                  !! (edge, component) as above [N]
      real(wp), intent(out) :: sums(2, 2, 2, 3)              !! (along x, z, y, component) [N]
      integer :: k

      do k = 1, 3
         sums(1, :, :, k) = kept(:, :, k)
         sums(2, :, :, k) = -kept(:, :, k)
         if (active(2)) then
            sums(:, :, 1, k) = sums(:, :, 1, k) + kept(:, :, k + 3)
            sums(:, :, 2, k) = sums(:, :, 2, k) - kept(:, :, k + 3)
         end if
         if (active(3)) then
            sums(:, 1, :, k) = sums(:, 1, :, k) + kept(:, :, k + 6)
            sums(:, 2, :, k) = sums(:, 2, :, k) - kept(:, :, k + 6)
         end if
      end do
   end subroutine join_edges

   !> Add the part of the internal force that stays on the cell to columns 5 to 7, the volume to
   !! column 8, and the stress handed to the nodes, sum v (1 - alpha_l) sigma_kl S, to column
   !! 8 + k + 3 (l - 1).
   !!
   !! D. Z. Zhang, X. Ma, P. T. Giguere, J. Comput. Phys. 230 (2011) 6379, in the two-step form.
   pure subroutine scatter_dual_force(grid, start, first, local, alpha, volume, stress, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Share of cell
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: a(lanes, 3), b(lanes, 3), sums(lanes, 13), s1, s2, s3, g(3), n(9), scale
      real(wp) :: v, shape
      integer :: cell, p, q, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            v = volume(q)
            scale = v/grid%spacing
            n(1) = v*(1.0_wp - alpha(p, 1))*stress(q, 1)
            n(2) = v*(1.0_wp - alpha(p, 1))*stress(q, 4)
            n(3) = v*(1.0_wp - alpha(p, 1))*stress(q, 6)
            n(4) = v*(1.0_wp - alpha(p, 2))*stress(q, 4)
            n(5) = v*(1.0_wp - alpha(p, 2))*stress(q, 2)
            n(6) = v*(1.0_wp - alpha(p, 2))*stress(q, 5)
            n(7) = v*(1.0_wp - alpha(p, 3))*stress(q, 6)
            n(8) = v*(1.0_wp - alpha(p, 3))*stress(q, 5)
            n(9) = v*(1.0_wp - alpha(p, 3))*stress(q, 3)
            do lane = 1, lanes
               s1 = a(lane, 1) + b(lane, 1)*local(p, 1)
               s2 = a(lane, 2) + b(lane, 2)*local(p, 2)
               s3 = a(lane, 3) + b(lane, 3)*local(p, 3)
               shape = s1*s2*s3
               g(1) = alpha(p, 1)*scale*b(lane, 1)*(s2*s3)
               g(2) = alpha(p, 2)*scale*b(lane, 2)*(s1*s3)
               g(3) = alpha(p, 3)*scale*b(lane, 3)*(s1*s2)
               sums(lane, 1) = sums(lane, 1) &
                  - (g(1)*stress(q, 1) + g(2)*stress(q, 4) + g(3)*stress(q, 6))
               sums(lane, 2) = sums(lane, 2) &
                  - (g(1)*stress(q, 4) + g(2)*stress(q, 2) + g(3)*stress(q, 5))
               sums(lane, 3) = sums(lane, 3) &
                  - (g(1)*stress(q, 6) + g(2)*stress(q, 5) + g(3)*stress(q, 3))
               sums(lane, 4) = sums(lane, 4) + v*shape
               sums(lane, 5) = sums(lane, 5) + n(1)*shape
               sums(lane, 6) = sums(lane, 6) + n(2)*shape
               sums(lane, 7) = sums(lane, 7) + n(3)*shape
               sums(lane, 8) = sums(lane, 8) + n(4)*shape
               sums(lane, 9) = sums(lane, 9) + n(5)*shape
               sums(lane, 10) = sums(lane, 10) + n(6)*shape
               sums(lane, 11) = sums(lane, 11) + n(7)*shape
               sums(lane, 12) = sums(lane, 12) + n(8)*shape
               sums(lane, 13) = sums(lane, 13) + n(9)*shape
            end do
         end do
         call add_cell(grid, cell, sums, 4, patch)
      end do
   end subroutine scatter_dual_force

   !> Add the force of the hoop stress in axisymmetry, - sum v sigma_yy S / r, to column 5.
   pure subroutine scatter_hoop(grid, start, first, local, position, volume, stress, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: a(lanes, 3), b(lanes, 3), sums(lanes, 1), force
      integer :: cell, p, q, lane

      a = grid%lane_constant
      b = grid%lane_slope
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            force = volume(q)*stress(q, 2)/position(q, 1)
            do lane = 1, lanes
               sums(lane, 1) = sums(lane, 1) - force*(a(lane, 1) + b(lane, 1)*local(p, 1)) &
                  *((a(lane, 2) + b(lane, 2)*local(p, 2))*(a(lane, 3) + b(lane, 3)*local(p, 3)))
            end do
         end do
         call add_cell(grid, cell, sums, 4, patch)
      end do
   end subroutine scatter_hoop

   !> Add the lanes of a cell to the patch.
   pure subroutine add_cell(grid, cell, sums, before, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      real(wp), contiguous, intent(in) :: sums(:, :)         !! (lane, column)
      integer, intent(in) :: before                          !! Columns of the patch before them
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: column, lane, node, base

      base = grid%first_node(cell)
      do lane = 1, lanes
         node = base + grid%lane_offset(lane)
         do column = 1, size(sums, 2)
            patch(before + column, node) = patch(before + column, node) + sums(lane, column)
         end do
      end do
   end subroutine add_cell
end module transfer_scatter
