! SPDX-License-Identifier: BSD-3-Clause
!> Values in the middle of equal cells of a horizontal plane, with bilinear interpolation.
module particle_raster
   use base_kinds, only: wp
   implicit none
   private

   public :: raster_t, row_of_raster

   !> Value of a cell without data. It is no NaN, whose comparisons are trapped in checked builds.
   real(wp), parameter, public :: no_data = -huge(1.0_wp)
   real(wp), parameter :: slack = 1.0e-6_wp !! Rounding of positions at the edge [cells]

   !> A raster. Half a cell wide, its margin continues the outermost four values.
   type :: raster_t
      real(wp) :: corner(2) = 0.0_wp                 !! Lower corner along x and y [m]
      real(wp) :: edge = 1.0_wp                      !! Edge of a cell [m]
      logical :: profile = .false.                   !! One row that is the same for all y?
      real(wp), allocatable :: value(:, :)           !! (column, row) Along x and y [m], or no_data
   contains
      procedure :: find => raster_find               !! Value at a position
      procedure :: middle => raster_middle           !! Middle of a cell
      procedure :: upper => raster_upper             !! Upper corner
      procedure :: extremes => raster_extremes       !! Least and greatest value in a rectangle
   end type raster_t

contains

   !> Value at a position. It is not known outside the raster, and where one of the four cells
   !! around it has no data.
   pure subroutine raster_find(self, x, y, value, known)
      class(raster_t), intent(in) :: self
      real(wp), intent(in) :: x, y                   !! [m]
      real(wp), intent(out) :: value                 !! [m], 0 if it is not known
      logical, intent(out) :: known                  !! Has the position a value?
      integer :: i, j, right, upper
      real(wp) :: f, g
      logical :: covered(2)

      value = 0.0_wp
      covered(2) = .true.
      j = 1
      g = 0.0_wp
      call find_cell(x, self%corner(1), self%edge, size(self%value, 1), i, f, covered(1))
      if (.not. self%profile) &
         call find_cell(y, self%corner(2), self%edge, size(self%value, 2), j, g, covered(2))
      known = all(covered)
      if (.not. known) return
      right = min(i + 1, size(self%value, 1))
      upper = min(j + 1, size(self%value, 2))
      known = min(self%value(i, j), self%value(right, j), self%value(i, upper), &
         self%value(right, upper)) > no_data
      if (.not. known) return
      value = (1.0_wp - g)*((1.0_wp - f)*self%value(i, j) + f*self%value(right, j)) &
         + g*((1.0_wp - f)*self%value(i, upper) + f*self%value(right, upper))
   end subroutine raster_find

   !> The cell whose middle is before a position, and the distance to it.
   pure subroutine find_cell(x, corner, edge, cells, cell, share, covered)
      real(wp), intent(in) :: x                      !! [m]
      real(wp), intent(in) :: corner                 !! Start of the raster [m]
      real(wp), intent(in) :: edge                   !! Edge of a cell [m]
      integer, intent(in) :: cells                   !! Number of cells
      integer, intent(out) :: cell                   !! 1 to cells - 1, or 1
      real(wp), intent(out) :: share                 !! Distance from its middle [cells]
      logical, intent(out) :: covered                !! Is the position in the raster?
      real(wp) :: place

      ! far positions are not integers
      place = min(max((x - corner)/edge, -1.0_wp), real(cells, wp) + 1.0_wp)
      covered = place >= -slack .and. place <= real(cells, wp) + slack
      cell = 1 + min(max(floor(place - 0.5_wp), 0), max(cells - 2, 0))
      share = place - real(cell, wp) + 0.5_wp
      if (cells == 1) share = 0.0_wp
   end subroutine find_cell

   !> Middle of a cell; with an index of 0 or one above the last, the edge of the raster.
   pure function raster_middle(self, i, j) result(place)
      class(raster_t), intent(in) :: self
      integer, intent(in) :: i, j                    !! Column and row, from 1
      real(wp) :: place(2)                           !! [m]

      place = self%corner + self%edge*min(max(real([i, j], wp) - 0.5_wp, 0.0_wp), &
         real(shape(self%value), wp))
   end function raster_middle

   !> Upper corner along x and y.
   pure function raster_upper(self) result(corner)
      class(raster_t), intent(in) :: self
      real(wp) :: corner(2)                          !! [m]

      corner = self%corner + self%edge*real(shape(self%value), wp)
   end function raster_upper

   !> Least and greatest value in a rectangle, or one cell around it: bounds of all interpolated
   !! values. Least is above greatest if none is known.
   pure subroutine raster_extremes(self, low, high, least, greatest)
      class(raster_t), intent(in) :: self
      real(wp), intent(in) :: low(2), high(2)        !! Corners of the rectangle [m]
      real(wp), intent(out) :: least, greatest       !! [m]
      real(wp) :: place(2), value
      integer :: i, j
      logical :: known, aside(2)

      least = huge(least)
      greatest = -huge(greatest)
      do j = 0, size(self%value, 2) + 1
         do i = 0, size(self%value, 1) + 1
            place = self%middle(i, j)
            aside = place < low - self%edge .or. place > high + self%edge
            if (aside(1) .or. (aside(2) .and. .not. self%profile)) cycle
            if (min(i, j) > 0 .and. all([i, j] <= shape(self%value))) then
               value = self%value(i, j)
               known = value > no_data
            else
               call self%find(place(1), place(2), value, known)
            end if
            if (.not. known) cycle
            least = min(least, value)
            greatest = max(greatest, value)
         end do
      end do
   end subroutine raster_extremes

   !> A profile of a raster: the values along a line of constant y.
   pure type(raster_t) function row_of_raster(raster, y) result(row)
      type(raster_t), intent(in) :: raster
      real(wp), intent(in) :: y                      !! Inside the raster [m]
      integer :: i
      real(wp) :: place(2)
      logical :: known

      row%corner = raster%corner
      row%edge = raster%edge
      row%profile = .true.
      allocate (row%value(size(raster%value, 1), 1))
      do i = 1, size(raster%value, 1)
         place = raster%middle(i, 1)
         call raster%find(place(1), y, row%value(i, 1), known)
         if (.not. known) row%value(i, 1) = no_data
      end do
   end function row_of_raster
end module particle_raster
