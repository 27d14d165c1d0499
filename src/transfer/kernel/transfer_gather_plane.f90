! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles with the linear functions of the cell in scenes of one and two dimensions.
!!
!! Vectors lie in the plane of x and z, or along x: components along y are zero and are not used.
!! Between its nodes a field is a polynomial (u1 + u2 x) + (u3 + u4 x) z of the local coordinates;
!! on a line u3 and u4 are zero. Four particles of a cell at a time are the lanes. Gradients are
!! also computed for the lanes after the last particle of a cell, as in `transfer_gather`.
!! Velocity and position must not be, so the last particles of a cell move one by one: a vectorised
!! loop of unknown length costs more than the work in it.
module transfer_gather_plane
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: dual_gradient_plane, linear_gradient_plane, motion_plane

   integer, parameter :: terms = 4                   !! Number of terms of a polynomial
   integer, parameter :: vector = 3                  !! Components of a vector
   integer, parameter :: tensor = 9                  !! Number of components of a tensor
   integer, parameter :: in_plane(2) = [1, 3]        !! Components of a vector in the plane
   integer, parameter :: in_tensor(4) = [1, 3, 7, 9] !! Components of a tensor: xx, zx, xz, zz
   !> Components of a tensor with y, which are zero: yx, xy, yy, zy, yz.
   integer, parameter :: out_of_plane(5) = [2, 4, 5, 6, 8]

contains

   !> Scaled velocity gradient of the plain method: gradient_kl = scale sum u_k dS/dx_l.
   pure subroutine linear_gradient_plane(grid, start, local, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: gradient(:, :)
      real(wp) :: u(vector, size(nodes, 2), terms)
      integer :: cell, node, k

      call clear_columns(start(grid%tile_cells), gradient)
      call find_terms(vector*grid%stride(1), vector*grid%stride(3), size(nodes), nodes, &
         scale/grid%spacing, u)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         node = grid%first_node(cell)
         do k = 1, 3, 2
            call find_slopes(start(cell) + 1, start(cell + 1), u(k, node, 2), u(k, node, 3), &
               u(k, node, 4), local(:, 1), local(:, 3), gradient(:, k), gradient(:, k + 6))
         end do
      end do
   end subroutine linear_gradient_plane

   !> The gradient of the cell, blended with that of the nodes:
   !! gradient_kl = alpha_l scale sum u_k dS/dx_l + (1 - alpha_l) scale sum S_j (grad u)_j,kl.
   pure subroutine dual_gradient_plane(grid, start, local, alpha, velocity, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Weight alpha
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (9, node) Node gradient [1/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      integer :: cell, node, x, z

      call clear_columns(start(grid%tile_cells), gradient)
      x = grid%stride(1)
      z = grid%stride(3)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         node = grid%first_node(cell)
         call blend_slopes(start(cell) + 1, start(cell + 1), scale/grid%spacing, &
            velocity(:, node), velocity(:, node + x), velocity(:, node + z), &
            velocity(:, node + x + z), scale, nodes(:, node), nodes(:, node + x), &
            nodes(:, node + z), nodes(:, node + x + z), local(:, 1), local(:, 3), alpha(:, 1), &
            alpha(:, 3), gradient(:, 1), gradient(:, 3), gradient(:, 7), gradient(:, 9))
      end do
   end subroutine dual_gradient_plane

   !> Velocity and position together: velocity = f velocity + sum S_i increment_i, position =
   !! position + dt sum S_i advection_i, f the flip fraction.
   pure subroutine motion_plane(grid, start, first, local, increment, advection, flip_fraction, &
      dt, velocity, position)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      real(wp), contiguous, intent(in) :: increment(:, :)    !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: advection(:, :)    !! (3, node) [m/s]
      real(wp), intent(in) :: flip_fraction                  !! Fraction of the old velocity [1]
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]
      real(wp) :: u(vector, size(increment, 2), terms), c(vector, size(increment, 2), terms)
      integer :: cell, node

      call find_terms(vector*grid%stride(1), vector*grid%stride(3), size(increment), increment, &
         1.0_wp, u)
      call find_terms(vector*grid%stride(1), vector*grid%stride(3), size(advection), advection, &
         dt, c)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         node = grid%first_node(cell)
         call move_cell(start(cell) + 1, start(cell + 1), first - 1, size(increment, 2), node, u, &
            c, flip_fraction, local(:, 1), local(:, 3), velocity(:, 1), velocity(:, 3), &
            position(:, 1), position(:, 3))
      end do
   end subroutine motion_plane

   !> Set the out-of-plane components of gradients to zero.
   pure subroutine clear_columns(count, gradient)
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      integer :: k

      do k = 1, size(out_of_plane)
         gradient(:count, out_of_plane(k)) = 0.0_wp
      end do
   end subroutine clear_columns

   !> Coefficients of the polynomials of all cells of a tile on their first nodes, by differences,
   !! so that a uniform field has slopes of exactly zero. The node field is a one-dimensional array.
   pure subroutine find_terms(along_x, along_z, numbers, nodes, scale, u)
      integer, intent(in) :: along_x                 !! Numbers to the next node along x
      integer, intent(in) :: along_z                 !! Offset to the next node along z
      integer, intent(in) :: numbers                 !! Number of array elements of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(numbers, terms)   !! (component and node, term)
      real(wp) :: u1, u2, u3
      integer :: n

      !$omp simd private(u1, u2, u3)
      do n = 1, numbers - along_x - along_z
         u1 = scale*nodes(n)
         u2 = scale*nodes(n + along_x) - u1
         u3 = scale*nodes(n + along_z)
         u(n, 1) = u1
         u(n, 2) = u2
         u(n, 3) = u3 - u1
         u(n, 4) = (scale*nodes(n + along_x + along_z) - u3) - u2
      end do
   end subroutine find_terms

   !> Slopes of a polynomial at the particles of a cell.
   ! The coefficients are scalars, so that they stay in registers.
   pure subroutine find_slopes(low, high, u2, u3, u4, x, z, along_x, along_z)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last index
      real(wp), intent(in) :: u2, u3, u4                     !! Coefficients
      real(wp), contiguous, intent(in) :: x(:), z(:)         !! (particle) Local coordinates [1]
      real(wp), contiguous, intent(inout) :: along_x(:)      !! (particle)
      real(wp), contiguous, intent(inout) :: along_z(:)      !! (particle)
      integer :: p, lane

      do p = low, high, 4
         !$omp simd
         do lane = p, p + 3
            along_x(lane) = u2 + u4*z(lane)
            along_z(lane) = u3 + u4*x(lane)
         end do
      end do
   end subroutine find_slopes

   !> Slopes of two polynomials at the particles of a cell, blended with four other polynomials.
   pure subroutine blend_slopes(low, high, slope_scale, ua, ub, uc, ud, scale, wa, wb, wc, wd, x, &
      z, ax, az, xx, zx, xz, zz)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last index
      real(wp), intent(in) :: slope_scale                    !! Factor of velocities
      !> Velocity on the first node, the next along x, along z, and along both
      real(wp), intent(in) :: ua(vector), ub(vector), uc(vector), ud(vector)
      real(wp), intent(in) :: scale                          !! Factor of its node gradients
      !> Node gradients on the same nodes
      real(wp), intent(in) :: wa(tensor), wb(tensor), wc(tensor), wd(tensor)
      real(wp), contiguous, intent(in) :: x(:), z(:)         !! (particle) Local coordinates [1]
      real(wp), contiguous, intent(in) :: ax(:), az(:)       !! (particle) Weights alpha [1]
      real(wp), contiguous, intent(inout) :: xx(:), zx(:)    !! (particle) Slopes along x
      real(wp), contiguous, intent(inout) :: xz(:), zz(:)    !! (particle) Slopes along z
      real(wp) :: u(terms, 2), w(terms, 4)
      integer :: p, lane, k

      do k = 1, 2
         call take_terms(slope_scale, ua(in_plane(k)), ub(in_plane(k)), uc(in_plane(k)), &
            ud(in_plane(k)), u(:, k))
      end do
      do k = 1, 4
         call take_terms(scale, wa(in_tensor(k)), wb(in_tensor(k)), wc(in_tensor(k)), &
            wd(in_tensor(k)), w(:, k))
      end do
      do p = low, high, 4
         !$omp simd
         do lane = p, p + 3
            xx(lane) = ax(lane)*(u(2, 1) + u(4, 1)*z(lane)) + (1.0_wp - ax(lane)) &
               *((w(1, 1) + w(2, 1)*x(lane)) + (w(3, 1) + w(4, 1)*x(lane))*z(lane))
            zx(lane) = ax(lane)*(u(2, 2) + u(4, 2)*z(lane)) + (1.0_wp - ax(lane)) &
               *((w(1, 2) + w(2, 2)*x(lane)) + (w(3, 2) + w(4, 2)*x(lane))*z(lane))
            xz(lane) = az(lane)*(u(3, 1) + u(4, 1)*x(lane)) + (1.0_wp - az(lane)) &
               *((w(1, 3) + w(2, 3)*x(lane)) + (w(3, 3) + w(4, 3)*x(lane))*z(lane))
            zz(lane) = az(lane)*(u(3, 2) + u(4, 2)*x(lane)) + (1.0_wp - az(lane)) &
               *((w(1, 4) + w(2, 4)*x(lane)) + (w(3, 4) + w(4, 4)*x(lane))*z(lane))
         end do
      end do
   end subroutine blend_slopes

   !> Coefficients of a polynomial from the values on the four nodes of a cell.
   pure subroutine take_terms(scale, a, b, c, d, u)
      real(wp), intent(in) :: scale                          !! Factor
      real(wp), intent(in) :: a, b, c, d                     !! First node, next along x, z, both
      real(wp), intent(inout) :: u(terms)                    !! Coefficients

      u(1) = scale*a
      u(2) = scale*b - u(1)
      u(3) = scale*c - u(1)
      u(4) = (scale*d - scale*c) - u(2)
   end subroutine take_terms

   !> Move the particles of a cell.
   pure subroutine move_cell(low, high, before, nodes, node, u, c, flip_fraction, x, z, vx, vz, &
      px, pz)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last index
      integer, intent(in) :: before                          !! Particles before those of the tile
      integer, intent(in) :: nodes                           !! Nodes of the tile
      integer, intent(in) :: node                            !! First node of the cell
      real(wp), intent(in) :: u(vector, nodes, terms)        !! (component, node, term) Gain [m/s]
      real(wp), intent(in) :: c(vector, nodes, terms) !! (component, node, term) Displacement [m]
      real(wp), intent(in) :: flip_fraction                  !! Fraction of the old velocity [1]
      real(wp), contiguous, intent(in) :: x(:), z(:)         !! Local coordinates [1]
      real(wp), contiguous, intent(inout) :: vx(:), vz(:)    !! (particle) Velocity [m/s]
      real(wp), contiguous, intent(inout) :: px(:), pz(:)    !! (particle) Position [m]
      integer :: p, lane

      do p = low, high - 3, 4
         !$omp simd
         do lane = p, p + 3
            vx(before + lane) = flip_fraction*vx(before + lane) + ((u(1, node, 1) &
               + u(1, node, 2)*x(lane)) + (u(1, node, 3) + u(1, node, 4)*x(lane))*z(lane))
            vz(before + lane) = flip_fraction*vz(before + lane) + ((u(3, node, 1) &
               + u(3, node, 2)*x(lane)) + (u(3, node, 3) + u(3, node, 4)*x(lane))*z(lane))
            px(before + lane) = px(before + lane) + ((c(1, node, 1) &
               + c(1, node, 2)*x(lane)) + (c(1, node, 3) + c(1, node, 4)*x(lane))*z(lane))
            pz(before + lane) = pz(before + lane) + ((c(3, node, 1) &
               + c(3, node, 2)*x(lane)) + (c(3, node, 3) + c(3, node, 4)*x(lane))*z(lane))
         end do
      end do
      !GCC$ novector
      do lane = p, high
         vx(before + lane) = flip_fraction*vx(before + lane) + ((u(1, node, 1) &
            + u(1, node, 2)*x(lane)) + (u(1, node, 3) + u(1, node, 4)*x(lane))*z(lane))
         vz(before + lane) = flip_fraction*vz(before + lane) + ((u(3, node, 1) &
            + u(3, node, 2)*x(lane)) + (u(3, node, 3) + u(3, node, 4)*x(lane))*z(lane))
         px(before + lane) = px(before + lane) + ((c(1, node, 1) &
            + c(1, node, 2)*x(lane)) + (c(1, node, 3) + c(1, node, 4)*x(lane))*z(lane))
         pz(before + lane) = pz(before + lane) + ((c(3, node, 1) &
            + c(3, node, 2)*x(lane)) + (c(3, node, 3) + c(3, node, 4)*x(lane))*z(lane))
      end do
   end subroutine move_cell
end module transfer_gather_plane
