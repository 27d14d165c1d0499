! SPDX-License-Identifier: BSD-3-Clause
!> Coefficients of the polynomials that node fields are within a cell, with linear functions.
!!
!! The terms are 1, x, z, xz, y, xy, yz, xyz of the local coordinates, in a plane the first four.
!! They are found as differences, so a uniform field has slopes of exactly zero. Four components of
!! the field are the lanes, whatever the number of particles in the cell.
module transfer_cell_terms
   use base_kinds, only: wp
   use mesh_grid, only: lanes
   implicit none
   private

   public :: find_plane_terms, find_terms

   integer, parameter, public :: plane_terms = 4     !! Terms in a plane

contains

   !> Coefficients of the polynomials of the components of a field in a cell, the terms being
   !! 1, x, z, xz, y, xy, yz, xyz. The nodes come as one row of numbers, of which four are the
   !! lanes: those of the next node fill the row up to a multiple of four, and have no meaning.
   pure subroutine find_terms(components, rows, node, ways, numbers, nodes, scale, u)
      integer, intent(in) :: components              !! Numbers a node
      integer, intent(in) :: rows                    !! The same, a multiple of four
      integer, intent(in) :: node                    !! First node of the cell
      integer, intent(in) :: ways(lanes)             !! Numbers from there to those of a node
      integer, intent(in) :: numbers                 !! Of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(rows, lanes)      !! (component, term)
      integer :: part, before

      before = components*(node - 1)
      if (before + ways(lanes) + rows > numbers) then
         call find_last_terms(components, rows, before, ways, numbers, nodes, scale, u)
         return
      end if
      do part = 0, rows - 1, 4
         call take_differences(before + part, ways, numbers, nodes, scale, rows, u(part + 1, 1))
      end do
   end subroutine find_terms

   !> The same for a cell with the last node of the tile, which nothing follows.
   pure subroutine find_last_terms(components, rows, before, ways, numbers, nodes, scale, u)
      integer, intent(in) :: components              !! Numbers a node
      integer, intent(in) :: rows                    !! The same, a multiple of four
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(lanes)             !! Numbers from there to those of a node
      integer, intent(in) :: numbers                 !! Of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      real(wp), intent(inout) :: u(rows, lanes)      !! (component, term)
      real(wp) :: padded(rows, lanes)
      integer :: part, lane

      padded = 0.0_wp
      do lane = 1, lanes
         padded(:components, lane) = nodes(before + ways(lane) + 1:before + ways(lane) + components)
      end do
      do part = 0, rows - 1, 4
         call take_differences(part, [(rows*(lane - 1), lane=1, lanes)], size(padded), padded, &
            scale, rows, u(part + 1, 1))
      end do
   end subroutine find_last_terms

   !> From the values on the eight nodes of a cell to the coefficients of its polynomial:
   !! differences along x, then z, then y. Four components are the lanes.
   pure subroutine take_differences(before, ways, numbers, nodes, scale, rows, u)
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(lanes)             !! Numbers from there to those of a node
      integer, intent(in) :: numbers                 !! Of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(in) :: scale                  !! Factor
      integer, intent(in) :: rows                    !! From term to term
      real(wp), intent(inout) :: u(rows*(lanes - 1) + 4) !! (component and term)
      real(wp) :: u1, u2, u3, u4, u5, u6, u7, u8
      integer :: c

      !$omp simd private(u1, u2, u3, u4, u5, u6, u7, u8)
      do c = 1, 4
         u1 = scale*nodes(before + c)
         u2 = scale*nodes(before + ways(2) + c) - u1
         u3 = scale*nodes(before + ways(3) + c)
         u4 = scale*nodes(before + ways(4) + c) - u3
         u5 = scale*nodes(before + ways(5) + c)
         u6 = scale*nodes(before + ways(6) + c) - u5
         u7 = scale*nodes(before + ways(7) + c)
         u8 = scale*nodes(before + ways(8) + c) - u7
         u3 = u3 - u1
         u4 = u4 - u2
         u7 = u7 - u5
         u8 = u8 - u6
         u(c) = u1
         u(rows + c) = u2
         u(2*rows + c) = u3
         u(3*rows + c) = u4
         u(4*rows + c) = u5 - u1
         u(5*rows + c) = u6 - u2
         u(6*rows + c) = u7 - u3
         u(7*rows + c) = u8 - u4
      end do
   end subroutine take_differences

   !> The same in a plane or on a line: the terms 1, x, z, xz, of which a line uses the first two.
   pure subroutine find_plane_terms(components, rows, node, ways, numbers, nodes, u)
      integer, intent(in) :: components              !! Numbers a node
      integer, intent(in) :: rows                    !! The same, a multiple of four
      integer, intent(in) :: node                    !! First node of the cell
      integer, intent(in) :: ways(plane_terms)       !! Numbers from there to those of a node
      integer, intent(in) :: numbers                 !! Of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      real(wp), intent(inout) :: u(rows, plane_terms) !! (component, term)
      real(wp) :: padded(rows, plane_terms)
      integer :: part, before, lane

      before = components*(node - 1)
      if (before + ways(plane_terms) + rows > numbers) then
         padded = 0.0_wp
         do lane = 1, plane_terms
            padded(:components, lane) = nodes(before + ways(lane) + 1:before + ways(lane) &
               + components)
         end do
         do part = 0, rows - 1, 4
            call take_plane_differences(part, [0, rows, 2*rows, 3*rows], size(padded), padded, &
               rows, u(part + 1, 1))
         end do
         return
      end if
      do part = 0, rows - 1, 4
         call take_plane_differences(before + part, ways, numbers, nodes, rows, u(part + 1, 1))
      end do
   end subroutine find_plane_terms

   !> Differences along x, then z. Four components are the lanes.
   pure subroutine take_plane_differences(before, ways, numbers, nodes, rows, u)
      integer, intent(in) :: before                  !! Numbers before those of the first node
      integer, intent(in) :: ways(plane_terms)       !! Numbers from there to those of a node
      integer, intent(in) :: numbers                 !! Of the tile
      real(wp), intent(in) :: nodes(numbers)         !! (component and node)
      integer, intent(in) :: rows                    !! From term to term
      real(wp), intent(inout) :: u(rows*(plane_terms - 1) + 4) !! (component and term)
      real(wp) :: u1, u2, u3
      integer :: c

      !$omp simd private(u1, u2, u3)
      do c = 1, 4
         u1 = nodes(before + c)
         u2 = nodes(before + ways(2) + c) - u1
         u3 = nodes(before + ways(3) + c)
         u(c) = u1
         u(rows + c) = u2
         u(2*rows + c) = u3 - u1
         u(3*rows + c) = (nodes(before + ways(4) + c) - u3) - u2
      end do
   end subroutine take_plane_differences
end module transfer_cell_terms
