! SPDX-License-Identifier: BSD-3-Clause
!> The group &grid: its keys, their checks, and the grid that they describe.
module scene_grid
   use base_kinds, only: wp
   use base_text, only: brief, number
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use mesh_grid, only: grid_t
   use scene_dimension, only: axis_names, read_dimension
   implicit none
   private

   public :: check_grid, check_periodic, declare_grid, read_grid, tile_edge

   real(wp), parameter :: most_cells = 1.0e6_wp          !! Cells along one direction
   real(wp), parameter :: tolerance = 1.0e-9_wp          !! Relative error of a number of cells
   integer, parameter :: most_block = 16             !! Cells along a tile in three dimensions

contains

   !> Declare &grid.
   subroutine declare_grid(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("grid", "background grid")
      call schema%real("grid", "lo(3)", "lower corner", unit="m")
      call schema%real("grid", "hi(3)", "upper corner", unit="m")
      call schema%real("grid", "dx", &
         "cell size, the spacing of the nodes; (hi-lo)/dx must be an integer", unit="m", &
         range="> 0")
      call schema%integer("grid", "cells(3)", "number of cells along x, y, z, instead of dx", &
         range="> 0")
      call schema%integer("grid", "block", &
         "cells along the edge of a tile, 0 = automatic; at most 16 in 3-D", default="0", &
         range=">= 0 <= 64")
      call schema%require("grid", "lo hi")
      call schema%forbid_change("grid", "*", "the particles of the checkpoint belong to the "// &
         "cells of this grid")
   end subroutine declare_grid

   !> Check corners and cells.
   subroutine check_grid(deck)
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: dimension
      type(group_t) :: grid
      real(wp) :: lo(3), hi(3), cells, dx
      logical :: active(3), needed(3)
      integer :: k, edge

      grid = deck%group("grid")
      if (.not. (grid%known("lo") .and. grid%known("hi"))) return
      call grid%get("lo", lo)
      call grid%get("hi", hi)
      call read_dimension(deck, dimension, active)
      if (dimension == "") return
      needed = active .or. dimension /= "axisymmetric"
      do k = 1, 3
         if (.not. needed(k) .or. hi(k) > lo(k)) cycle
         if (active(k)) then
            call deck%add_error(grid, "hi must be above lo in "//axis_names(k)//" [D408]", "hi")
         else
            call deck%add_error(grid, "hi must be above lo in "//axis_names(k)//" too; in "// &
               dimension// &
               " the difference is the thickness [D408]", "hi")
         end if
         return
      end do
      if (dimension == "axisymmetric" .and. abs(lo(1)) > 0.0_wp) call deck%add_error(grid, &
         "axisymmetric needs lo(1) = 0, the axis [D402]", "lo")
      call grid%get("block", edge)
      if (count(active) == 3 .and. edge > most_block) call deck%add_error(grid, &
         "tiles of more than 16 cells along an edge are too large for the stack of a thread in "// &
         "three dimensions; write block = 0 or at most 16 [D406]", "block")
      if (grid%given("cells")) then
         call check_cells(deck, grid, lo, hi, active)
      else if (.not. grid%given("dx")) then
         call deck%add_error(grid, "dx or cells must be given [D401]")
      else if (grid%known("dx")) then
         ! an integer number of cells along each edge
         call grid%get("dx", dx)
         do k = 1, 3
            if (.not. active(k)) cycle
            cells = (hi(k) - lo(k))/dx
            if (cells > most_cells) then
               call deck%add_error(grid, "(hi-lo)/dx = "//brief(cells)//" in "//axis_names(k)// &
                  " is more than a million cells [D405]", "dx")
               return
            end if
            if (abs(cells - anint(cells)) <= tolerance*max(cells, 1.0_wp) .and. &
               cells > 0.5_wp) cycle
            call deck%add_error(grid, "(hi-lo)/dx = "//brief(cells)//" is not an integer in "// &
               axis_names(k)// &
               "; nearest: hi = "//deck%shown(lo(k) + max(anint(cells), 1.0_wp)*dx, "m")// &
               " or dx = "// &
               deck%shown((hi(k) - lo(k))/max(anint(cells), 1.0_wp), "m")//" [D404]", "dx")
         end do
      end if
   end subroutine check_grid

   !> Check that cells given by their number are cubes.
   subroutine check_cells(deck, grid, lo, hi, active)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: grid
      real(wp), intent(in) :: lo(3)                      !! Lower corner [m]
      real(wp), intent(in) :: hi(3)                      !! Upper corner [m]
      logical, intent(in) :: active(3)                   !! The scene has this direction
      real(wp) :: edge(3)
      integer :: cells(3)
      integer :: k

      if (grid%given("dx")) then
         call deck%add_error(grid, "dx and cells are both given; keep one [D307]", "cells")
         return
      end if
      if (.not. grid%known("cells")) return
      call grid%get("cells", cells)
      do k = 1, 3
         if (.not. active(k) .or. cells(k) <= nint(most_cells)) cycle
         call deck%add_error(grid, "cells = "//number(cells(k))//" in "//axis_names(k)// &
            " is more than a million cells [D405]", "cells")
         return
      end do
      edge = (hi - lo)/real(cells, wp)
      do k = 2, 3
         if (.not. active(k)) cycle
         if (abs(edge(k) - edge(1)) <= tolerance*edge(1)) cycle
         call deck%add_error(grid, "cells must be cubes, but these are "//deck%shown(edge(1), &
            "m")// &
            " in x and "//deck%shown(edge(k), "m")//" in "//axis_names(k)//" [D407]", "cells")
         return
      end do
   end subroutine check_cells

   !> Read corners, spacing and dimensions.
   subroutine read_grid(deck, grid)
      type(deck_t), intent(in) :: deck
      type(grid_t), intent(inout) :: grid            !! Gets corners, spacing and dimensions
      type(group_t) :: group
      character(len=:), allocatable :: word
      integer :: cells(3)

      group = deck%group("run", 1)
      call group%get("dimension", word)
      select case (word)
      case ("1d")
         grid%dimensions = 1
      case ("plane_strain", "axisymmetric")
         grid%dimensions = 2
      case default
         grid%dimensions = 3
      end select
      grid%axisymmetric = word == "axisymmetric"
      group = deck%group("grid", 1)
      call group%get("lo", grid%lower)
      call group%get("hi", grid%upper)
      if (group%given("cells")) then
         call group%get("cells", cells)
         grid%spacing = (grid%upper(1) - grid%lower(1))/real(cells(1), wp)
      else
         call group%get("dx", grid%spacing)
      end if
      ! a direction without cells counts with its full extent, or with a unit if it has
      ! none
      if (grid%dimensions < 3 .and. .not. grid%upper(2) > grid%lower(2)) &
         grid%upper(2) = grid%lower(2) + merge(0.0_wp, 1.0_wp, grid%axisymmetric)
      if (grid%dimensions < 2 .and. .not. grid%upper(3) > grid%lower(3)) &
         grid%upper(3) = grid%lower(3) + 1.0_wp
   end subroutine read_grid

   !> Cells along the edge of a tile, 0 = automatic.
   integer function tile_edge(deck) result(edge)
      type(deck_t), intent(in) :: deck
      type(group_t) :: group

      group = deck%group("grid", 1)
      call group%get("block", edge)
   end function tile_edge

   !> Check that shape functions with extended support do not overlap themselves across a periodic
   !! grid.
   subroutine check_periodic(deck, grid)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      integer, parameter :: least = 4                ! nodes that a particle may touch along a line
      type(group_t) :: group
      character(len=:), allocatable :: basis
      integer :: direction

      if (grid%margin == 0) return
      group = deck%group("method", 1)
      call group%get("basis", basis)
      do direction = 1, 3
         if (.not. (grid%active(direction) .and. grid%periodic(direction))) cycle
         if (grid%cells(direction) >= least) cycle
         call deck%add_error(group, "basis = '"//basis//"' needs at least 4 cells along "// &
            axis_names(direction)//", which is periodic, but there are "// &
            achar(iachar("0") + grid%cells(direction))//"; use smaller cells or basis = "// &
            "'linear' [D311]", "basis")
      end do
   end subroutine check_periodic
end module scene_grid
