! SPDX-License-Identifier: BSD-3-Clause
!> B-bar method against volumetric locking: the particles of a material in a cell use the mean of
!! their dilatations, and the mean of their pressures in the nodal forces. Linear functions cannot
!! satisfy a separate volume constraint for each particle of a cell, so nearly incompressible
!! material would be too stiff (T. J. R. Hughes, Int. J. Numer. Methods Eng. 15 (1980) 1413, for
!! elements; W. M. Coombs and others, Comput. Methods Appl. Mech. Eng. 333 (2018) 115, for material
!! points).
!!
!! Both means are weighted with the volume, so the power of the averaged stress with the original
!! gradient is that of the original stress with the averaged gradient. Equation (M.20) of
!! doc/theory/method.md.
module transfer_bbar
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: average_dilatation, average_pressure

contains

   !> Give the particles of each cell the mean of their dilatations.
   pure subroutine average_dilatation(grid, start, first, volume, gradient)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      call average_trace(grid, start, first - 1, [1, 5, 9], volume, gradient)
   end subroutine average_dilatation

   !> Give the particles of each cell the mean of their pressures.
   pure subroutine average_pressure(grid, start, volume, stress)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle of the tile) [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :)    !! (particle of the tile, 6) [Pa]

      call average_trace(grid, start, 0, [1, 2, 3], volume, stress)
   end subroutine average_pressure

   !> Give the particles of each cell the mean of the traces of their tensors. A change is
   !! distributed over the directions of the plane in plane strain, otherwise over all active ones.
   pure subroutine average_trace(grid, start, before, column, volume, tensor)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)           !! (0:cells) Particles before a cell
      integer, intent(in) :: before                          !! Volumes before those of the tile
      integer, intent(in) :: column(3)                       !! Columns of the diagonal
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: tensor(:, :)    !! (particle of the tile, component)
      real(wp) :: total, whole, shift
      logical :: share(3)
      integer :: cell, p, k

      share = grid%active .or. grid%axisymmetric
      do cell = 0, grid%tile_cells - 1
         total = 0.0_wp
         whole = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            whole = whole + volume(before + p)
            do k = 1, 3
               if (share(k)) total = total + volume(before + p)*tensor(p, column(k))
            end do
         end do
         do p = start(cell) + 1, start(cell + 1)
            shift = total/whole
            do k = 1, 3
               if (share(k)) shift = shift - tensor(p, column(k))
            end do
            shift = shift/real(count(share), wp)
            do k = 1, 3
               if (share(k)) tensor(p, column(k)) = tensor(p, column(k)) + shift
            end do
         end do
      end do
   end subroutine average_trace
end module transfer_bbar
