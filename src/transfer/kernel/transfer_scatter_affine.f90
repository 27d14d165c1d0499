! SPDX-License-Identifier: BSD-3-Clause
!> Particles to nodes with the linear functions of the cell, where particles carry linear velocity
!! fields.
!!
!! Every node gets another velocity, so the four edges of a cell along y are the lanes here, with a
!! lower and an upper node; in a plane, where the particles have no coordinate along y, there are
!! the lower nodes only: `space` is a compile-time constant. Sums stay in registers, for which there
!! are two loops over the lanes (`transfer_scatter_space`). Equations (T.3) and (T.4) of
!! doc/theory/transfers.md.
module transfer_scatter_affine
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_edges, only: edges
   use transfer_scatter_space, only: a1, a2, b1, b2
   implicit none
   private

   public :: scatter_affine, scatter_turning

contains

   !> Add mass and momentum of linear velocity fields to columns 1 to 4 of a patch.
   pure subroutine scatter_affine(grid, start, first, local, mass, velocity, affine, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call add_fields(.true., grid, start, first, local, mass, velocity, affine, patch)
      else
         call add_fields(.false., grid, start, first, local, mass, velocity, affine, patch)
      end if
   end subroutine scatter_affine

   !> The same for a compile-time choice.
   pure subroutine add_fields(space, grid, start, first, local, mass, velocity, affine, patch)
      logical, intent(in) :: space                           !! Three dimensions, or a plane?
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp), dimension(edges) :: lower, upper, x, z
      real(wp) :: sums(edges, 2, 4), along, v, h, below, above
      integer :: cell, p, q, e

      h = grid%spacing
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            !$omp simd private(along)
            do e = 1, edges
               along = (a1(e) + b1(e)*local(p, 1))*(a2(e) + b2(e)*local(p, 3))*mass(q)
               lower(e) = along*(1.0_wp - local(p, 2))
               upper(e) = along*local(p, 2)
               ! the constant of a lane is 1 on the lower node
               x(e) = h*(1.0_wp - a1(e) - local(p, 1))
               z(e) = h*(1.0_wp - a2(e) - local(p, 3))
            end do
            below = -h*local(p, 2)
            above = h*(1.0_wp - local(p, 2))
            !$omp simd private(v)
            do e = 1, edges
               sums(e, 1, 1) = sums(e, 1, 1) + lower(e)
               if (space) sums(e, 2, 1) = sums(e, 2, 1) + upper(e)
               v = velocity(q, 1) + affine(q, 1)*x(e) + affine(q, 7)*z(e)
               sums(e, 1, 2) = sums(e, 1, 2) + lower(e)*(v + affine(q, 4)*below)
               if (space) sums(e, 2, 2) = sums(e, 2, 2) + upper(e)*(v + affine(q, 4)*above)
               v = velocity(q, 2) + affine(q, 2)*x(e) + affine(q, 8)*z(e)
               sums(e, 1, 3) = sums(e, 1, 3) + lower(e)*(v + affine(q, 5)*below)
               if (space) sums(e, 2, 3) = sums(e, 2, 3) + upper(e)*(v + affine(q, 5)*above)
               v = velocity(q, 3) + affine(q, 3)*x(e) + affine(q, 9)*z(e)
               sums(e, 1, 4) = sums(e, 1, 4) + lower(e)*(v + affine(q, 6)*below)
               if (space) sums(e, 2, 4) = sums(e, 2, 4) + upper(e)*(v + affine(q, 6)*above)
            end do
         end do
         call add_edges(merge(2, 1, space), grid, cell, sums, patch)
      end do
   end subroutine add_fields

   !> Add mass and momentum of rotating particles to columns 1 to 4 of a patch.
   pure subroutine scatter_turning(grid, start, first, local, mass, velocity, spin, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) w [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call add_rotations(.true., grid, start, first, local, mass, velocity, spin, patch)
      else
         call add_rotations(.false., grid, start, first, local, mass, velocity, spin, patch)
      end if
   end subroutine scatter_turning

   !> The same for a compile-time choice.
   pure subroutine add_rotations(space, grid, start, first, local, mass, velocity, spin, patch)
      logical, intent(in) :: space                           !! Three dimensions, or a plane?
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) w [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp), dimension(edges) :: lower, upper, x, z
      real(wp) :: sums(edges, 2, 4), along, v(3), w(3), h, value
      integer :: cell, p, q, e

      h = grid%spacing
      ! place of each lane in its cell: the constant of a lane is 1 on the lower node
      x = 1.0_wp - a1
      z = 1.0_wp - a2
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         sums = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            if (space) then
               ! the velocity field at the lower corner of the cell
               w = [h*spin(q, 1), h*spin(q, 2), h*spin(q, 3)]
               v(1) = velocity(q, 1) - (w(2)*local(p, 3) - w(3)*local(p, 2))
               v(2) = velocity(q, 2) - (w(3)*local(p, 1) - w(1)*local(p, 3))
               v(3) = velocity(q, 3) - (w(1)*local(p, 2) - w(2)*local(p, 1))
            else
               w = [spin(q, 1), spin(q, 2), spin(q, 3)]
               v = [velocity(q, 1), velocity(q, 2), velocity(q, 3)]
            end if
            !$omp simd private(along)
            do e = 1, edges
               along = (a1(e) + b1(e)*local(p, 1))*(a2(e) + b2(e)*local(p, 3))*mass(q)
               lower(e) = along*(1.0_wp - local(p, 2))
               upper(e) = along*local(p, 2)
               if (space) cycle
               x(e) = h*(1.0_wp - a1(e) - local(p, 1))
               z(e) = h*(1.0_wp - a2(e) - local(p, 3))
            end do
            !$omp simd private(value)
            do e = 1, edges
               sums(e, 1, 1) = sums(e, 1, 1) + lower(e)
               if (space) sums(e, 2, 1) = sums(e, 2, 1) + upper(e)
               value = v(1) + w(2)*z(e)
               sums(e, 1, 2) = sums(e, 1, 2) + lower(e)*value
               if (space) sums(e, 2, 2) = sums(e, 2, 2) + upper(e)*(value - w(3))
               value = v(2) + (w(3)*x(e) - w(1)*z(e))
               sums(e, 1, 3) = sums(e, 1, 3) + lower(e)*value
               if (space) sums(e, 2, 3) = sums(e, 2, 3) + upper(e)*value
               value = v(3) - w(2)*x(e)
               sums(e, 1, 4) = sums(e, 1, 4) + lower(e)*value
               if (space) sums(e, 2, 4) = sums(e, 2, 4) + upper(e)*(value + w(1))
            end do
         end do
         call add_edges(merge(2, 1, space), grid, cell, sums, patch)
      end do
   end subroutine add_rotations

   !> Add the sums of a cell to its nodes.
   pure subroutine add_edges(ends, grid, cell, sums, patch)
      integer, intent(in) :: ends                            !! Ends of an edge, 1 in a plane
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      real(wp), intent(in) :: sums(edges, 2, 4)              !! (edge, end, column)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: e, c, n, node

      do n = 1, ends
         do e = 1, edges
            node = grid%first_node(cell) + grid%lane_offset(e + edges*(n - 1))
            do c = 1, 4
               patch(c, node) = patch(c, node) + sums(e, n, c)
            end do
         end do
      end do
   end subroutine add_edges
end module transfer_scatter_affine
