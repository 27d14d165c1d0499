! SPDX-License-Identifier: BSD-3-Clause
!> Particles to nodes with the linear functions of the cell.
!!
!! The sums of a cell are taken over its particles in their order and then added to the patch of the
!! tile. Columns of the patch: 1 mass, 2-4 momentum, 5-7 internal force, and for the dual domain
!! method 8 volume, 9-17 stress that stays on the nodes. What is summed is the same in all
!! dimensions; how, is chosen here once a tile: nodes of missing directions are not worked on.
!! Equations (M.1), (M.4) and (M.5) of doc/theory/method.md.
module transfer_scatter
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_scatter_affine, only: space_affine, space_turning
   use transfer_scatter_plane, only: plane_affine, plane_dual_force, plane_force, plane_motion, &
      plane_turning, plane_values
   use transfer_scatter_space, only: space_dual_force, space_force, space_motion, space_values
   implicit none
   private

   public :: scatter_affine, scatter_dual_force, scatter_force, scatter_motion, &
      scatter_turning, scatter_values

   integer, parameter, public :: motion_columns = 7  !! Mass, momentum, force
   integer, parameter, public :: dual_columns = 17   !! With volume and node stress

contains

   !> Add mass and momentum to columns 1 to 4 of a patch. Equation (M.1).
   pure subroutine scatter_motion(grid, start, first, local, mass, velocity, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call space_motion(grid, start, first, local, mass, velocity, patch)
      else
         call plane_motion(grid, start, first, local, mass, velocity, patch)
      end if
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

      if (grid%dimensions == 3) then
         call space_values(grid, start, local, count, values, before, patch)
      else
         call plane_values(grid, start, local, count, values, before, patch)
      end if
   end subroutine scatter_values

   !> Add mass and momentum of linear velocity fields, sum m S_i (v + C (x_i - x)), to columns 1 to
   !! 4 of a patch (C. Jiang, C. Schroeder, A. Selle, J. Teran, A. Stomakhin, ACM Trans. Graph. 34
   !! (2015) 51). Equation (T.3) of doc/theory/transfers.md.
   pure subroutine scatter_affine(grid, start, first, local, mass, velocity, affine, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call space_affine(grid, start, first, local, mass, velocity, affine, patch)
      else
         call plane_affine(grid, start, first, local, mass, velocity, affine, patch)
      end if
   end subroutine scatter_affine

   !> Add mass and momentum of particles that turn, sum m S_i (v + w x (x_i - x)), to columns 1 to 4
   !! of a patch. Equation (T.4).
   pure subroutine scatter_turning(grid, start, first, local, mass, velocity, spin, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) w [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call space_turning(grid, start, first, local, mass, velocity, spin, patch)
      else
         call plane_turning(grid, start, first, local, mass, velocity, spin, patch)
      end if
   end subroutine scatter_turning

   !> Add the internal force of the plain method, - sum v sigma . grad S, to columns 5 to 7.
   !! Equation (M.4).
   pure subroutine scatter_force(grid, start, first, local, volume, stress, patch)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call space_force(grid, start, first, local, volume, stress, patch)
      else
         call plane_force(grid, start, first, local, volume, stress, patch)
      end if
   end subroutine scatter_force

   !> Add the part of the internal force that stays on the cell to columns 5 to 7, the volume to
   !! column 8, and the stress handed to the nodes, sum v (1 - alpha_l) sigma_kl S, to column
   !! 8 + k + 3 (l - 1).
   !!
   !! D. Z. Zhang, X. Ma, P. T. Giguere, J. Comput. Phys. 230 (2011) 6379, in the two-step form. The
   !! first sum of (M.4), and the sum of (M.5).
   pure subroutine scatter_dual_force(grid, start, first, local, alpha, volume, stress, patch, &
      factor)
      type(grid_t), intent(in) :: grid                       !! The grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle of tile, 3) Place in cell
      real(wp), contiguous, intent(in) :: alpha(:, :)        !! (particle of tile, 3) Share of cell
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp), contiguous, intent(in), optional :: factor(:, 0:) !! (edge, cell) Of the cell part

      if (grid%dimensions == 3) then
         call space_dual_force(grid, start, first, local, alpha, volume, stress, patch, &
            factor)
      else
         call plane_dual_force(grid, start, first, local, alpha, volume, stress, patch, &
            factor)
      end if
   end subroutine scatter_dual_force
end module transfer_scatter
