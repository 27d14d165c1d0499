! SPDX-License-Identifier: BSD-3-Clause
!> Effect of the linear velocity fields of particles on the kinetic energy.
!!
!! They add a motion to the nodes that the kinetic energy of the particles, 1/2 sum m v**2, does not
!! include. With B(u) = sum S_i u_i (x_i - x)^T, the PIC fraction g and the increment a dt of nodes,
!! a particle gets (1 - g) C : B(a dt) - g C : B(u) more than `gather_heat` gives it; so the sum of
!! kinetic and internal energy is conserved to round-off. (Derived for this program from sum m_p S
!! (v_p + C_p (x_i - x_p)) = m_i u_i; the heat may be negative where the linear field gains energy.)
!! Equation (T.7) of doc/theory/transfers.md.
module transfer_affine
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use transfer_basis, only: basis_t
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: gather_affine_heat, keep_affine, moment_fields, turn_only

contains

   !> Products of a node vector and the position of the node in its tile, (k, l) in row k + 3 (l -
   !! 1).
   pure subroutine moment_fields(grid, nodes, moments)
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: moments(:, :)   !! (9, node) [m2/s]
      real(wp) :: place(3)
      integer :: node, k, l

      do node = 1, size(nodes, 2)
         place = grid%spacing*real(grid%node_position(node), wp)
         do l = 1, 3
            do k = 1, 3
               moments(k + 3*(l - 1), node) = nodes(k, node)*place(l)
            end do
         end do
      end do
   end subroutine moment_fields

   !> Heat - C : B(nodes), for the vector g u - (1 - g) a dt on the nodes.
   pure subroutine gather_affine_heat(grid, basis, shape, first, nodes, moments, energy)
      type(grid_t), intent(in) :: grid
      class(basis_t), intent(in) :: basis
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape !! Shape data of the tile, with C before the step
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: moments(:, :) !! (9, node) From `moment_fields` [m2/s]
      real(wp), contiguous, intent(inout) :: energy(:)       !! (particle) [J/kg]
      real(wp) :: corner(3), place, heat
      integer :: cell, p, q, k, l

      call basis%gather_values(grid, shape, nodes, shape%vector)
      call basis%gather_values(grid, shape, moments, shape%values)
      do cell = 0, grid%tile_cells - 1
         corner = real(grid%cell_position(:, cell), wp)
         do p = shape%start(cell) + 1, shape%start(cell + 1)
            q = first + p - 1
            heat = 0.0_wp
            do l = 1, 3
               place = grid%spacing*(corner(l) + shape%local(p, l))
               do k = 1, 3
                  heat = heat - shape%affine(p, k + 3*(l - 1))*(shape%values(p, k + 3*(l - 1)) &
                     - place*shape%vector(p, k))
               end do
            end do
            energy(q) = energy(q) + heat
         end do
      end do
   end subroutine gather_affine_heat

   !> Keep the linear velocity fields of a tile in its store, or their rotation only.
   pure subroutine keep_affine(store, tile, scale, affine)
      type(store_t), intent(inout) :: store                  !! Gets the fields that it has
      integer, intent(in) :: tile                            !! Index of the tile
      real(wp), intent(in) :: scale                          !! Factor, such as one over the step
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle of the tile, 9)
      integer :: p, q, k

      if (allocated(store%affine)) then
         do k = 1, 9
            do p = 1, store%count(tile)
               q = store%first(tile) + p - 1
               store%affine(q, k) = scale*affine(p, k)
            end do
         end do
      end if
      if (.not. allocated(store%spin)) return
      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         store%spin(q, 1) = 0.5_wp*scale*(affine(p, 6) - affine(p, 8))
         store%spin(q, 2) = 0.5_wp*scale*(affine(p, 7) - affine(p, 3))
         store%spin(q, 3) = 0.5_wp*scale*(affine(p, 2) - affine(p, 4))
      end do
   end subroutine keep_affine

   !> Remove all but the rotation from linear velocity fields.
   pure subroutine turn_only(count, affine)
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(inout) :: affine(:, :)    !! (particle of the tile, 9)
      real(wp) :: half
      integer :: p, k, l

      do k = 1, 3
         do p = 1, count
            affine(p, 4*k - 3) = 0.0_wp
         end do
         do l = k + 1, 3
            do p = 1, count
               half = 0.5_wp*(affine(p, k + 3*(l - 1)) - affine(p, l + 3*(k - 1)))
               affine(p, k + 3*(l - 1)) = half
               affine(p, l + 3*(k - 1)) = -half
            end do
         end do
      end do
   end subroutine turn_only
end module transfer_affine
