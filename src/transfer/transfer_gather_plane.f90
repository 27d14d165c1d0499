! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles with the linear functions of the cell in scenes of one and two dimensions.
!!
!! Vectors lie in the plane of x and z, or along x: what nodes and particles have along y is zero
!! and is not looked at. Between its nodes a field is a polynomial (u1 + u2 x) + (u3 + u4 x) z of
!! the place in the cell; on a line u3 and u4 are zero. The particles of a cell are the lanes.
module transfer_gather_plane
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: dual_gradient_plane, gradient_plane, motion_plane

   integer, parameter :: terms = 4                   !! Of a polynomial
   integer, parameter :: vector = 4                  !! Components, one without meaning
   integer, parameter :: tensor = 12                 !! The same, three without meaning
   !> Components of a tensor with y, which are zero: yx, xy, yy, zy, yz.
   integer, parameter :: out_of_plane(5) = [2, 4, 5, 6, 8]

contains

   !> Scaled velocity gradient of the plain method: gradient_kl = scale sum u_k dS/dx_l.
   pure subroutine gradient_plane(grid, start, local, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: gradient(:, :)
      real(wp) :: u(vector, terms)
      integer :: cell

      call clear_columns(start(grid%tile_cells), gradient)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         call find_terms(3, vector, grid%first_node(cell), grid%stride, size(nodes), nodes, &
            scale/grid%spacing, u)
         call find_slopes(start(cell) + 1, start(cell + 1), u, local(:, 1), local(:, 3), &
            gradient(:, 1), gradient(:, 3), gradient(:, 7), gradient(:, 9))
      end do
   end subroutine gradient_plane

   !> The gradient of the cell, blended with that of the nodes:
   !! gradient_kl = alpha_l scale sum u_k dS/dx_l + (1 - alpha_l) scale sum S_j (grad u)_j,kl.
   pure subroutine dual_gradient_plane(grid, start, local, alpha, velocity, nodes, scale, gradient)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Share of cell
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (9, node) Node gradient [1/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: u(vector, terms), w(tensor, terms)
      integer :: cell, node

      call clear_columns(start(grid%tile_cells), gradient)
      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         node = grid%first_node(cell)
         call find_terms(3, vector, node, grid%stride, size(velocity), velocity, &
            scale/grid%spacing, u)
         call find_terms(9, tensor, node, grid%stride, size(nodes), nodes, scale, w)
         call blend_slopes(start(cell) + 1, start(cell + 1), u, w, local(:, 1), &
            local(:, 3), alpha(:, 1), alpha(:, 3), gradient(:, 1), gradient(:, 3), &
            gradient(:, 7), gradient(:, 9))
      end do
   end subroutine dual_gradient_plane

   !> Velocity and position at once: velocity = keep velocity + sum S_i push_i, position = position
   !! + dt sum S_i carry_i.
   ! gate: long kernel because two fields go to two others
   pure subroutine motion_plane(grid, start, first, local, push, carry, keep, dt, velocity, &
      position)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: push(:, :)         !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: carry(:, :)        !! (3, node) [m/s]
      real(wp), intent(in) :: keep                           !! Share of the old velocity
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]
      real(wp) :: u(vector, terms), c(vector, terms)
      integer :: cell, node

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         node = grid%first_node(cell)
         call find_terms(3, vector, node, grid%stride, size(push), push, 1.0_wp, u)
         call find_terms(3, vector, node, grid%stride, size(carry), carry, dt, c)
         call move_cell(start(cell) + 1, start(cell + 1), first - 1, u, c, keep, &
            local(:, 1), local(:, 3), velocity(:, 1), velocity(:, 3), position(:, 1), &
            position(:, 3))
      end do
   end subroutine motion_plane

   !> Set the components of gradients that leave the plane to zero.
   pure subroutine clear_columns(count, gradient)
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      integer :: k

      do k = 1, size(out_of_plane)
         gradient(:count, out_of_plane(k)) = 0.0_wp
      end do
   end subroutine clear_columns

   !> Coefficients of the polynomials of the components of a field in a cell, by differences, so
   !! that a uniform field has slopes of exactly zero. The nodes come as one row of numbers, of
   !! which four are the lanes: those of the next node fill the row up to a multiple of four.
   ! gate: long kernel because a field is told by its numbers
   pure subroutine find_terms(components, rows, node, stride, numbers, nodes, scale, u)
      integer, intent(in) :: components              !! Numbers a node
      integer, intent(in) :: rows                    !! The same, a multiple of four
      integer, intent(in) :: node                    !! First node of the cell
      integer, intent(in) :: stride(3)               !! Nodes to the next one along a direction
      integer, intent(in) :: numbers                 !! Of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(rows, terms)      !! (component, term)
      real(wp) :: padded(tensor, terms)
      integer :: part, at(terms), term

      at(1) = components*(node - 1)
      at(2) = at(1) + components*stride(1)
      at(3) = at(1) + components*stride(3)
      at(4) = at(2) + components*stride(3)
      if (at(4) + rows <= numbers) then
         do part = 0, rows - 1, 4
            call take_differences(at, part, numbers, nodes, scale, rows, u(part + 1, 1))
         end do
         return
      end if
      ! nothing follows the last node of the tile
      padded = 0.0_wp
      do term = 1, terms
         padded(:components, term) = nodes(at(term) + 1:at(term) + components)
         at(term) = tensor*(term - 1)
      end do
      do part = 0, rows - 1, 4
         call take_differences(at, part, size(padded), padded, scale, rows, u(part + 1, 1))
      end do
   end subroutine find_terms

   !> From the values on the four nodes of a cell to the coefficients of its polynomial, for four
   !! components.
   pure subroutine take_differences(at, part, numbers, nodes, scale, rows, u)
      integer, intent(in) :: at(terms)               !! Numbers before those of a node
      integer, intent(in) :: part                    !! Components before the four
      integer, intent(in) :: numbers                 !! Of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      integer, intent(in) :: rows                    !! From term to term
      real(wp), intent(inout) :: u(rows*(terms - 1) + 4) !! (component and term)
      real(wp) :: u1, u2, u3
      integer :: c

      !$omp simd private(u1, u2, u3)
      do c = 1, 4
         u1 = scale*nodes(at(1) + part + c)
         u2 = scale*nodes(at(2) + part + c) - u1
         u3 = scale*nodes(at(3) + part + c)
         u(c) = u1
         u(rows + c) = u2
         u(2*rows + c) = u3 - u1
         u(3*rows + c) = (scale*nodes(at(4) + part + c) - u3) - u2
      end do
   end subroutine take_differences

   !> Slopes of two polynomials at the particles of a cell.
   ! gate: long kernel because components are columns of their own
   pure subroutine find_slopes(low, high, u, x, z, xx, zx, xz, zz)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last one
      real(wp), intent(in) :: u(vector, terms)               !! (component, term) Velocity
      real(wp), contiguous, intent(in) :: x(:), z(:)         !! Places in the cell [1]
      real(wp), contiguous, intent(inout) :: xx(:), zx(:)    !! Slopes along x
      real(wp), contiguous, intent(inout) :: xz(:), zz(:)    !! Slopes along z
      integer :: p

      !$omp simd
      do p = low, high
         xx(p) = u(1, 2) + u(1, 4)*z(p)
         zx(p) = u(3, 2) + u(3, 4)*z(p)
         xz(p) = u(1, 3) + u(1, 4)*x(p)
         zz(p) = u(3, 3) + u(3, 4)*x(p)
      end do
   end subroutine find_slopes

   !> Slopes of two polynomials at the particles of a cell, blended with four other polynomials.
   ! gate: long kernel because components are columns of their own
   pure subroutine blend_slopes(low, high, u, w, x, z, ax, az, xx, zx, xz, zz)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last one
      real(wp), intent(in) :: u(vector, terms)               !! (component, term) Velocity
      real(wp), intent(in) :: w(tensor, terms)               !! (component, term) Node gradient
      real(wp), contiguous, intent(in) :: x(:), z(:)         !! Places in the cell [1]
      real(wp), contiguous, intent(in) :: ax(:), az(:)       !! Shares of the slopes of the cell
      real(wp), contiguous, intent(inout) :: xx(:), zx(:)    !! Slopes along x
      real(wp), contiguous, intent(inout) :: xz(:), zz(:)    !! Slopes along z
      integer :: p

      !$omp simd
      do p = low, high
         xx(p) = ax(p)*(u(1, 2) + u(1, 4)*z(p)) &
            + (1.0_wp - ax(p))*((w(1, 1) + w(1, 2)*x(p)) + (w(1, 3) + w(1, 4)*x(p))*z(p))
         zx(p) = ax(p)*(u(3, 2) + u(3, 4)*z(p)) &
            + (1.0_wp - ax(p))*((w(3, 1) + w(3, 2)*x(p)) + (w(3, 3) + w(3, 4)*x(p))*z(p))
         xz(p) = az(p)*(u(1, 3) + u(1, 4)*x(p)) &
            + (1.0_wp - az(p))*((w(7, 1) + w(7, 2)*x(p)) + (w(7, 3) + w(7, 4)*x(p))*z(p))
         zz(p) = az(p)*(u(3, 3) + u(3, 4)*x(p)) &
            + (1.0_wp - az(p))*((w(9, 1) + w(9, 2)*x(p)) + (w(9, 3) + w(9, 4)*x(p))*z(p))
      end do
   end subroutine blend_slopes

   !> Move the particles of a cell.
   ! gate: long kernel because components are columns of their own
   pure subroutine move_cell(low, high, before, u, c, keep, x, z, vx, vz, px, pz)
      integer, intent(in) :: low                             !! First particle of the cell
      integer, intent(in) :: high                            !! Last one
      integer, intent(in) :: before                          !! Particles before those of the tile
      real(wp), intent(in) :: u(vector, terms)               !! (component, term) Gain [m/s]
      real(wp), intent(in) :: c(vector, terms)               !! (component, term) Way [m]
      real(wp), intent(in) :: keep                           !! Share of the old velocity
      real(wp), contiguous, intent(in) :: x(:), z(:)         !! Places in the cell [1]
      real(wp), contiguous, intent(inout) :: vx(:), vz(:)    !! Velocity [m/s]
      real(wp), contiguous, intent(inout) :: px(:), pz(:)    !! Position [m]
      integer :: p

      !$omp simd
      do p = low, high
         vx(before + p) = keep*vx(before + p) &
            + ((u(1, 1) + u(1, 2)*x(p)) + (u(1, 3) + u(1, 4)*x(p))*z(p))
         vz(before + p) = keep*vz(before + p) &
            + ((u(3, 1) + u(3, 2)*x(p)) + (u(3, 3) + u(3, 4)*x(p))*z(p))
         px(before + p) = px(before + p) &
            + ((c(1, 1) + c(1, 2)*x(p)) + (c(1, 3) + c(1, 4)*x(p))*z(p))
         pz(before + p) = pz(before + p) &
            + ((c(3, 1) + c(3, 2)*x(p)) + (c(3, 3) + c(3, 4)*x(p))*z(p))
      end do
   end subroutine move_cell
end module transfer_gather_plane
