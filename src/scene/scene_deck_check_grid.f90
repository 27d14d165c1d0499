! SPDX-License-Identifier: BSD-3-Clause
!> Checks of the grid of a deck, and of vectors against the dimension of the scene.
module scene_deck_check_grid
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use base_text, only: brief, number
   implicit none
   private

   public :: check_grid, check_plane, dimension_of

   character(len=1), parameter, public :: axis_names(3) = ["x", "y", "z"]
   real(wp), parameter :: most = 1.0e6_wp                !! Cells along one direction
   real(wp), parameter :: whole = 1.0e-9_wp              !! Greatest error of a number of cells

contains

   !> Corners, cells and gravity.
   subroutine check_grid(deck)
      type(deck_t), intent(inout) :: deck                !! The deck
      character(len=:), allocatable :: dimension
      type(group_t) :: grid
      real(wp) :: lo(3), hi(3)
      logical :: active(3), needed(3)
      integer :: k

      call check_plane(deck, deck%group("effects"), "gravity_vector")
      grid = deck%group("grid")
      if (.not. (grid%known("lo") .and. grid%known("hi"))) return
      call grid%get("lo", lo)
      call grid%get("hi", hi)
      call dimension_of(deck, dimension, active)
      if (dimension == "") return
      needed = active .or. dimension /= "axisymmetric"
      do k = 1, 3
         if (.not. needed(k) .or. hi(k) > lo(k)) cycle
         if (active(k)) then
            call deck%complain(grid, "hi must be above lo in "//axis_names(k), "hi")
         else
            call deck%complain(grid, "hi must be above lo in "//axis_names(k)//" too; in "// &
               dimension// &
               " the difference is the thickness", "hi")
         end if
         return
      end do
      if (dimension == "axisymmetric" .and. abs(lo(1)) > 0.0_wp) call deck%complain(grid, &
         "axisymmetric needs lo(1) = 0, the axis", "lo")
      if (grid%given("cells")) then
         call check_cells(deck, grid, lo, hi, active)
      else if (.not. grid%given("dx")) then
         call deck%complain(grid, "dx or cells must be given")
      else if (grid%known("dx")) then
         call check_integer(deck, grid, lo, hi, active)
      end if
   end subroutine check_grid

   !> Dimension of the scene, empty if it is wrong, and the directions that it has.
   subroutine dimension_of(deck, dimension, active)
      type(deck_t), intent(in) :: deck                   !! The deck
      character(len=:), allocatable, intent(out) :: dimension !! As in the deck
      logical, intent(out) :: active(3)                  !! It has this direction
      type(group_t) :: run

      run = deck%group("run")
      call run%get("dimension", dimension)
      active = [.true., dimension == "3d", dimension /= "1d"]
   end subroutine dimension_of

   !> The edges must be whole numbers of cells.
   subroutine check_integer(deck, grid, lo, hi, active)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: grid                  !! The grid
      real(wp), intent(in) :: lo(3)                      !! Lower corner [m]
      real(wp), intent(in) :: hi(3)                      !! Upper corner [m]
      logical, intent(in) :: active(3)                   !! The scene has this direction
      real(wp) :: cells, dx
      integer :: k

      call grid%get("dx", dx)
      do k = 1, 3
         if (.not. active(k)) cycle
         cells = (hi(k) - lo(k))/dx
         if (cells > most) then
            call deck%complain(grid, "(hi-lo)/dx = "//brief(cells)//" in "//axis_names(k)// &
               " is more than a million cells", "dx")
            return
         end if
         if (abs(cells - anint(cells)) <= whole*max(cells, 1.0_wp) .and. cells > 0.5_wp) cycle
         call deck%complain(grid, "(hi-lo)/dx = "//brief(cells)//" is not whole in "// &
            axis_names(k)// &
            "; nearest: hi = "//deck%shown(lo(k) + max(anint(cells), 1.0_wp)*dx, "m")// &
            " or dx = "// &
            deck%shown((hi(k) - lo(k))/max(anint(cells), 1.0_wp), "m"), "dx")
      end do
   end subroutine check_integer

   !> Cells given by number must be cubes.
   subroutine check_cells(deck, grid, lo, hi, active)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: grid                  !! The grid
      real(wp), intent(in) :: lo(3)                      !! Lower corner [m]
      real(wp), intent(in) :: hi(3)                      !! Upper corner [m]
      logical, intent(in) :: active(3)                   !! The scene has this direction
      real(wp) :: edge(3)
      integer :: cells(3)
      integer :: k

      if (grid%given("dx")) then
         call deck%complain(grid, "dx and cells are both given; keep one", "cells")
         return
      end if
      if (.not. grid%known("cells")) return
      call grid%get("cells", cells)
      do k = 1, 3
         if (.not. active(k) .or. cells(k) <= nint(most)) cycle
         call deck%complain(grid, "cells = "//number(cells(k))//" in "//axis_names(k)// &
            " is more than a million cells", "cells")
         return
      end do
      edge = (hi - lo)/real(cells, wp)
      do k = 2, 3
         if (.not. active(k)) cycle
         if (abs(edge(k) - edge(1)) <= whole*edge(1)) cycle
         call deck%complain(grid, "cells must be cubes, but these are "//deck%shown(edge(1), &
            "m")// &
            " in x and "//deck%shown(edge(k), "m")//" in "//axis_names(k), "cells")
         return
      end do
   end subroutine check_cells

   !> A vector must not leave the directions of the scene.
   subroutine check_plane(deck, group, key)
      type(deck_t), intent(inout) :: deck                !! The deck
      type(group_t), intent(in) :: group                 !! The group
      character(len=*), intent(in) :: key                !! The vector
      character(len=:), allocatable :: dimension
      logical :: active(3)
      real(wp) :: vector(3)
      integer :: k

      if (.not. (group%given(key) .and. group%known(key))) return
      call dimension_of(deck, dimension, active)
      if (dimension == "") return
      call group%get(key, vector)
      do k = 1, 3
         if (active(k) .or. abs(vector(k)) <= 0.0_wp) cycle
         call deck%complain(group, key//" must be 0 in "//axis_names(k)//", as dimension = '"// &
            dimension//"'", key)
      end do
   end subroutine check_plane
end module scene_deck_check_grid
