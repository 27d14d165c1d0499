! SPDX-License-Identifier: BSD-3-Clause
!> Particles to nodes with the linear functions of the cell, in three dimensions.
!!
!! Sums of a cell are products of matrices: weights of its nodes at its particles times columns of
!! the particles. Weights and columns of some particles are found at once, with particles as lanes.
!! Then the particles of a cell are added one by one in their order, with four columns as lanes and
!! the sums of all eight nodes in registers; they are added to the patch of the tile once, or twice
!! where a cell continues in the next group of particles.
!!
!! The sum over particles has two loops over the lanes: with a single loop the compiler would
!! process two particles at a time (unroll and jam) and keep the sums in memory. Equations (M.1),
!! (M.4) and (M.5) of doc/theory/method.md.
module transfer_scatter_space
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   use transfer_edges, only: edges
   implicit none
   private

   public :: space_dual_force, space_force, space_values

   integer, parameter :: batch = 64                   !! Particles that are prepared at once
   integer, parameter :: block = 4                   !! Columns that are added at once
   !> Function of an edge: constant and slope along the first of the two other directions, then
   !! along the second.
   real(wp), parameter, public :: a1(edges) = [1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]
   real(wp), parameter, public :: b1(edges) = [-1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp]
   real(wp), parameter, public :: a2(edges) = [1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter, public :: b2(edges) = [-1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp]

contains

   !> Add sum S_i value to columns of a patch.
   pure subroutine space_values(grid, start, local, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: weight(batch, lanes), part(block, batch)
      integer :: skipped, number, cell, p, skip, at(block)

      cell = 0
      do skipped = 0, start(grid%tile_cells) - 1, batch
         call next_particles(grid%tile_cells, start, skipped, cell, number)
         call weigh_lanes(skipped, number, size(local, 1), local, weight)
         do skip = 0, count - 1, block
            ! missing columns repeat the last one, which is not added again
            at = min(skip + [1, 2, 3, 4], count)
            do p = 1, number
               part(1, p) = values(skipped + p, at(1))
               part(2, p) = values(skipped + p, at(2))
               part(3, p) = values(skipped + p, at(3))
               part(4, p) = values(skipped + p, at(4))
            end do
            if (count - skip >= block) then
               call add_weighted(grid, start, cell, skipped, number, weight, block, part, &
                  before + skip, size(patch, 1), size(patch), patch)
            else
               call add_weighted(grid, start, cell, skipped, number, weight, count - skip, part, &
                  before + skip, size(patch, 1), size(patch), patch)
            end if
         end do
      end do
   end subroutine space_values

   !> Add the internal force of the plain method, - sum v sigma . grad S, to columns 5 to 7.
   pure subroutine space_force(grid, start, first, local, volume, stress, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: share(start(grid%tile_cells))
      integer :: p

      do p = 1, start(grid%tile_cells)
         share(p) = volume(first + p - 1)*(1.0_wp/grid%spacing)
      end do
      call add_edges(grid, start, first, local, share, share, share, stress, patch)
   end subroutine space_force

   !> Add the part of the internal force on the cell to columns 5 to 7, the volume to column 8, and
   !! the stress mapped to the nodes, sum v (1 - alpha_l) sigma_kl S, to column 8 + k + 3 (l - 1).
   pure subroutine space_dual_force(grid, start, first, local, alpha, volume, stress, patch, &
      factor)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Weight alpha
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp), contiguous, intent(in), optional :: factor(:, 0:) !! (edge, cell) Factor of edges
      !> The third block begins with two zeros, so that no column after the last one is touched
      integer, parameter :: before(3) = [7, 11, 13]
      real(wp) :: share(start(grid%tile_cells), 3)
      real(wp) :: weight(batch, lanes), values(block, batch, 3)
      integer :: skipped, number, cell, p, l

      cell = 0
      do skipped = 0, start(grid%tile_cells) - 1, batch
         call next_particles(grid%tile_cells, start, skipped, cell, number)
         call weigh_lanes(skipped, number, size(local, 1), local, weight)
         call share_stress(skipped, first - 1, number, alpha, volume, stress, values)
         do l = 1, 3
            call add_weighted(grid, start, cell, skipped, number, weight, block, values(:, :, l), &
               before(l), size(patch, 1), size(patch), patch)
         end do
      end do
      do l = 1, 3
         do p = 1, start(grid%tile_cells)
            share(p, l) = alpha(p, l)*(volume(first + p - 1)*(1.0_wp/grid%spacing))
         end do
      end do
      call add_edges(grid, start, first, local, share(:, 1), share(:, 2), share(:, 3), &
         stress, patch, factor)
   end subroutine space_dual_force

   !> Volume and stress of some particles for the sums of the nodes, in blocks of columns: volume,
   !! stress xx, xy and xz; then stress components along y and xz; then two zeros, yz and zz.
   pure subroutine share_stress(skipped, before, number, alpha, volume, stress, values)
      integer, intent(in) :: skipped                         !! Index offset in the tile
      integer, intent(in) :: before                          !! Particles before the tile
      integer, intent(in) :: number                          !! Their number
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Weight alpha
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), intent(inout) :: values(block, batch, 3)      !! (column, particle, block)
      real(wp) :: rest
      integer :: p, q

      do p = 1, number
         q = before + skipped + p
         rest = volume(q)*(1.0_wp - alpha(skipped + p, 1))
         values(1, p, 1) = volume(q)
         values(2, p, 1) = rest*stress(q, 1)
         values(3, p, 1) = rest*stress(q, 4)
         values(4, p, 1) = rest*stress(q, 6)
      end do
      do p = 1, number
         q = before + skipped + p
         rest = volume(q)*(1.0_wp - alpha(skipped + p, 2))
         values(1, p, 2) = rest*stress(q, 4)
         values(2, p, 2) = rest*stress(q, 2)
         values(3, p, 2) = rest*stress(q, 5)
         rest = volume(q)*(1.0_wp - alpha(skipped + p, 3))
         values(4, p, 2) = rest*stress(q, 6)
      end do
      do p = 1, number
         q = before + skipped + p
         rest = volume(q)*(1.0_wp - alpha(skipped + p, 3))
         values(1, p, 3) = 0.0_wp
         values(2, p, 3) = 0.0_wp
         values(3, p, 3) = rest*stress(q, 5)
         values(4, p, 3) = rest*stress(q, 3)
      end do
   end subroutine share_stress

   !> The next particles of a tile that are prepared at once.
   pure subroutine next_particles(cells, start, skipped, cell, number)
      integer, intent(in) :: cells                           !! Cells of a tile
      integer, intent(in) :: start(0:cells)                  !! (0:cells) Particles before a cell
      integer, intent(in) :: skipped                         !! Index offset in the tile
      integer, intent(inout) :: cell                         !! A cell not after that of the first
      integer, intent(out) :: number                         !! Number of particles

      do while (start(cell + 1) <= skipped)
         cell = cell + 1
      end do
      number = min(batch, start(cells) - skipped)
   end subroutine next_particles

   !> Weights of the eight lanes at some particles.
   pure subroutine weigh_lanes(before, number, rows, local, weight)
      integer, intent(in) :: before                          !! Index offset in the tile
      integer, intent(in) :: number                          !! Their number
      integer, intent(in) :: rows                            !! Length of the next
      real(wp), intent(in) :: local(rows, 3)                 !! (particle, 3) Local coordinates
      real(wp), intent(inout) :: weight(batch, lanes)         !! (particle, lane) [1]
      real(wp) :: x, y, z, w1, w2, w3, w4
      integer :: p

      !$omp simd private(x, y, z, w1, w2, w3, w4)
      do p = 1, number
         x = local(before + p, 1)
         y = local(before + p, 2)
         z = local(before + p, 3)
         w1 = (1.0_wp - x)*(1.0_wp - z)
         w2 = x*(1.0_wp - z)
         w3 = (1.0_wp - x)*z
         w4 = x*z
         weight(p, 1) = w1*(1.0_wp - y)
         weight(p, 2) = w2*(1.0_wp - y)
         weight(p, 3) = w3*(1.0_wp - y)
         weight(p, 4) = w4*(1.0_wp - y)
         weight(p, 5) = w1*y
         weight(p, 6) = w2*y
         weight(p, 7) = w3*y
         weight(p, 8) = w4*y
      end do
   end subroutine weigh_lanes

   !> Add sum weight value of up to four columns of some particles to the patch, which is a
   !! one-dimensional array.
   pure subroutine add_weighted(grid, start, cell, skipped, number, weight, columns, values, &
      before, rows, numbers, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: cell                            !! Cell of the first of them
      integer, intent(in) :: skipped                         !! Index offset in the tile
      integer, intent(in) :: number                          !! Their number
      real(wp), intent(in) :: weight(batch, lanes)            !! (particle, lane) [1]
      integer, intent(in) :: columns                         !! Columns that are added
      real(wp), intent(in) :: values(block, batch)            !! (column, particle)
      integer, intent(in) :: before                          !! Column offset in the patch
      integer, intent(in) :: rows                            !! Columns of the patch
      integer, intent(in) :: numbers                         !! Numbers of the patch
      real(wp), intent(inout) :: patch(numbers)              !! (column, node), flat
      real(wp), dimension(block) :: s1, s2, s3, s4, s5, s6, s7, s8
      integer :: n, from, p, c, at, offset(lanes)

      offset = rows*grid%lane_offset
      do n = cell, grid%tile_cells - 1
         if (start(n) >= skipped + number) exit
         if (start(n + 1) <= max(start(n), skipped)) cycle
         ! the first of its particles begins the sums, which costs less than zeros do
         from = max(start(n) - skipped, 0) + 1
         !$omp simd
         do c = 1, block
            s1(c) = weight(from, 1)*values(c, from)
            s2(c) = weight(from, 2)*values(c, from)
            s3(c) = weight(from, 3)*values(c, from)
            s4(c) = weight(from, 4)*values(c, from)
            s5(c) = weight(from, 5)*values(c, from)
            s6(c) = weight(from, 6)*values(c, from)
            s7(c) = weight(from, 7)*values(c, from)
            s8(c) = weight(from, 8)*values(c, from)
         end do
         do p = from + 1, min(start(n + 1) - skipped, number)
            !$omp simd
            do c = 1, block
               s1(c) = s1(c) + weight(p, 1)*values(c, p)
               s2(c) = s2(c) + weight(p, 2)*values(c, p)
               s3(c) = s3(c) + weight(p, 3)*values(c, p)
               s4(c) = s4(c) + weight(p, 4)*values(c, p)
            end do
            !$omp simd
            do c = 1, block
               s5(c) = s5(c) + weight(p, 5)*values(c, p)
               s6(c) = s6(c) + weight(p, 6)*values(c, p)
               s7(c) = s7(c) + weight(p, 7)*values(c, p)
               s8(c) = s8(c) + weight(p, 8)*values(c, p)
            end do
         end do
         at = before + rows*(grid%first_node(n) - 1)
         call add_node(columns, s1, at + offset(1), numbers, patch)
         call add_node(columns, s2, at + offset(2), numbers, patch)
         call add_node(columns, s3, at + offset(3), numbers, patch)
         call add_node(columns, s4, at + offset(4), numbers, patch)
         call add_node(columns, s5, at + offset(5), numbers, patch)
         call add_node(columns, s6, at + offset(6), numbers, patch)
         call add_node(columns, s7, at + offset(7), numbers, patch)
         call add_node(columns, s8, at + offset(8), numbers, patch)
      end do
   end subroutine add_weighted

   !> Add columns to a node; four of them are one vector.
   pure subroutine add_node(columns, sums, at, numbers, patch)
      integer, intent(in) :: columns                         !! Number of columns
      real(wp), intent(in) :: sums(block)                    !! (column)
      integer, intent(in) :: at                              !! Index offset in the patch
      integer, intent(in) :: numbers                         !! Numbers of the patch
      real(wp), intent(inout) :: patch(numbers)              !! (column, node), flat
      integer :: c

      if (columns == block) then
         !$omp simd
         do c = 1, block
            patch(at + c) = patch(at + c) + sums(c)
         end do
      else
         do c = 1, columns
            patch(at + c) = patch(at + c) + sums(c)
         end do
      end if
   end subroutine add_node

   !> Add the force - sum share sigma . grad S to columns 5 to 7 of a patch.
   !!
   !! The slope of a function along a direction is the same on both ends of an edge, with opposite
   !! signs, so the sums are those of the twelve edges: half the work of eight nodes, and each cell
   !! conserves momentum exactly. Edges along x are counted along z and y, those along y along x and
   !! z, those along z along x and y.
   pure subroutine add_edges(grid, start, first, local, x_share, y_share, z_share, stress, &
      patch, factor)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: x_share(:)         !! Volume along x over spacing [m2]
      real(wp), contiguous, intent(in) :: y_share(:)         !! Along y
      real(wp), contiguous, intent(in) :: z_share(:)         !! Along z
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp), contiguous, intent(in), optional :: factor(:, 0:) !! (edge, cell) Of the edges [1]
      real(wp) :: kept(edges, 3, 3), x(edges), y(edges), z(edges)
      integer :: cell, p, q, e, k, l

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         kept = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            q = first + p - 1
            !$omp simd
            do e = 1, edges
               x(e) = (a1(e) + b1(e)*local(p, 3))*(a2(e) + b2(e)*local(p, 2))*x_share(p)
               y(e) = (a1(e) + b1(e)*local(p, 1))*(a2(e) + b2(e)*local(p, 3))*y_share(p)
               z(e) = (a1(e) + b1(e)*local(p, 1))*(a2(e) + b2(e)*local(p, 2))*z_share(p)
            end do
            !$omp simd
            do e = 1, edges
               kept(e, 1, 1) = kept(e, 1, 1) + x(e)*stress(q, 1)
               kept(e, 2, 1) = kept(e, 2, 1) + x(e)*stress(q, 4)
               kept(e, 3, 1) = kept(e, 3, 1) + x(e)*stress(q, 6)
               kept(e, 1, 2) = kept(e, 1, 2) + y(e)*stress(q, 4)
               kept(e, 2, 2) = kept(e, 2, 2) + y(e)*stress(q, 2)
               kept(e, 3, 2) = kept(e, 3, 2) + y(e)*stress(q, 5)
               kept(e, 1, 3) = kept(e, 1, 3) + z(e)*stress(q, 6)
               kept(e, 2, 3) = kept(e, 2, 3) + z(e)*stress(q, 5)
               kept(e, 3, 3) = kept(e, 3, 3) + z(e)*stress(q, 3)
            end do
         end do
         if (present(factor)) then
            do l = 1, 3
               do k = 1, 3
                  kept(:, k, l) = kept(:, k, l)*factor(edges*(l - 1) + 1:edges*l, cell)
               end do
            end do
         end if
         call join_edges(grid, cell, kept, size(patch, 1), size(patch), patch)
      end do
   end subroutine add_edges

   !> Force on the nodes of a cell: an edge adds to its lower node the opposite of its upper one.
   pure subroutine join_edges(grid, cell, kept, rows, numbers, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                            !! Cell of the tile, from 0
      real(wp), intent(in) :: kept(edges, 3, 3)              !! (edge, component, direction) [N]
      integer, intent(in) :: rows                            !! Columns of the patch
      integer, intent(in) :: numbers                         !! Numbers of the patch
      real(wp), intent(inout) :: patch(numbers)              !! (column, node), flat
      real(wp) :: sums(2, edges, 3)
      integer :: k, e, lane, at

      do k = 1, 3
         !$omp simd
         do e = 1, edges
            sums(1, e, k) = kept(e, k, 1)
            sums(2, e, k) = -kept(e, k, 1)
         end do
         call add_ends(kept(1, k, 2), kept(1, k, 3), sums(1, 1, k))
      end do
      do lane = 1, lanes
         at = 4 + rows*(grid%first_node(cell) - 1 + grid%lane_offset(lane))
         e = (lane + 1)/2
         do k = 1, 3
            patch(at + k) = patch(at + k) + sums(1 + mod(lane - 1, 2), e, k)
         end do
      end do
   end subroutine join_edges

   !> Add the forces of edges along y and z to the nodes.
   pure subroutine add_ends(y, z, sums)
      real(wp), intent(in) :: y(edges)                       !! (along x, z) Values of edges along y
      real(wp), intent(in) :: z(2, 2)                        !! (along x, y) Values of edges along z
      real(wp), intent(inout) :: sums(edges, 2)              !! (along x and z, y)
      integer :: e, n

      !$omp simd
      do e = 1, edges
         sums(e, 1) = sums(e, 1) + y(e)
         sums(e, 2) = sums(e, 2) - y(e)
      end do
      do n = 1, 2
         do e = 1, 2
            sums(e, n) = sums(e, n) + z(e, n)
            sums(2 + e, n) = sums(2 + e, n) - z(e, n)
         end do
      end do
   end subroutine add_ends
end module transfer_scatter_space
