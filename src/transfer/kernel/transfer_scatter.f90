! SPDX-License-Identifier: BSD-3-Clause
!> Particles to nodes with the linear functions of the cell: common code of basis and quadrature.
!!
!! The sums of a cell run over its particles in their order and are then added to the patch of the
!! tile. Columns of the patch: 1 mass, 2-4 momentum, 5-7 internal force, and for the dual domain
!! method 8 volume, 9-17 node stress. Equations (M.1), (M.4) and (M.5) of doc/theory/method.md.
module transfer_scatter
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_scatter_plane, only: plane_dual_force, plane_values
   use transfer_scatter_space, only: space_dual_force, space_values
   implicit none
   private

   public :: scatter_dual_force, scatter_values

   integer, parameter, public :: motion_columns = 7  !! Mass, momentum, force
   integer, parameter, public :: dual_columns = 17   !! With volume and node stress

contains

   !> Add sum S_i value to columns of a patch.
   pure subroutine scatter_values(grid, start, local, count, values, before, patch)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: local(:, :)        !! (particle, 3) Local coordinates
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      if (grid%dimensions == 3) then
         call space_values(grid, start, local, count, values, before, patch)
      else
         call plane_values(grid, start, local, count, values, before, patch)
      end if
   end subroutine scatter_values

   !> Add the part of the internal force on the cell to columns 5 to 7, the volume to column 8, and
   !! the stress mapped to the nodes, sum v (1 - alpha_l) sigma_kl S, to column 8 + k + 3 (l - 1).
   !!
   !! D. Z. Zhang, X. Ma, P. T. Giguere, J. Comput. Phys. 230 (2011) 6379, in the two-step form. The
   !! first sum of (M.4), and the sum of (M.5).
   pure subroutine scatter_dual_force(grid, start, first, local, alpha, volume, stress, patch, &
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

      ! gfortran reads the address of an absent factor that is handed on
      if (grid%dimensions == 3) then
         if (present(factor)) then
            call space_dual_force(grid, start, first, local, alpha, volume, stress, patch, factor)
         else
            call space_dual_force(grid, start, first, local, alpha, volume, stress, patch)
         end if
      else if (present(factor)) then
         call plane_dual_force(grid, start, first, local, alpha, volume, stress, patch, factor)
      else
         call plane_dual_force(grid, start, first, local, alpha, volume, stress, patch)
      end if
   end subroutine scatter_dual_force
end module transfer_scatter
