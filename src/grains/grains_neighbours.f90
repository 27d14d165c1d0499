! SPDX-License-Identifier: BSD-3-Clause
!> Finds the pairs of grains that may touch soon, with linked cells in the coordinates of the cell.
module grains_neighbours
   use base_kinds, only: wp
   use grains_pairs, only: pairs_t
   use grains_state, only: grains_t
   use mesh_box, only: box_t
   implicit none
   private

   public :: find_pairs

   !> Bins of the cell, with the grains of each.
   type :: bins_t
      integer :: number(3) = 1                       !! Bins along each edge
      integer, allocatable :: start(:)               !! (bin + 1) First index in `row`
      integer, allocatable :: row(:)                 !! Rows, bin by bin
   end type bins_t

   !> Neighbours of the own rows, by identity.
   type :: neighbours_t
      integer, allocatable :: start(:)               !! (own row + 1) First index in `row`
      integer, allocatable :: row(:)                 !! Row of the neighbour
      real(wp), allocatable :: shift(:, :)           !! (axis, neighbour) Edges added to it
   end type neighbours_t

contains

   !> Find the pairs of the own rows whose surfaces are less than `skin` apart.
   subroutine find_pairs(grains, box, skin, pairs)
      type(grains_t), intent(in) :: grains           !! Coordinates of all rows in [0, 1)
      type(box_t), intent(in) :: box                 !! Heights > 2 search distances
      real(wp), intent(in) :: skin                   !! [m]
      type(pairs_t), intent(inout) :: pairs          !! Gets the pairs, without histories
      type(bins_t) :: bins
      type(neighbours_t) :: near
      real(wp) :: reach
      integer :: row, rows

      reach = 2.0_wp*maxval(grains%radius) + skin
      call fill_bins(grains, box, reach, bins)
      rows = grains%last - grains%first + 1
      allocate (near%start(rows + 1))
      near%start = 0
      !$omp parallel do default(none) shared(grains, box, skin, bins, near, rows) private(row) &
      !$omp schedule(static)
      do row = 1, rows
         call search_row(grains, box, skin, bins, grains%first + row - 1, near, .false.)
      end do
      !$omp end parallel do
      call accumulate(near%start)
      allocate (near%row(near%start(rows + 1) - 1), near%shift(3, near%start(rows + 1) - 1))
      !$omp parallel do default(none) shared(grains, box, skin, bins, near, rows) private(row) &
      !$omp schedule(static)
      do row = 1, rows
         call search_row(grains, box, skin, bins, grains%first + row - 1, near, .true.)
         call sort_neighbours(grains, near, row)
      end do
      !$omp end parallel do
      call make_pairs(grains, near, pairs)
   end subroutine find_pairs

   !> Convert counts, stored with an offset of one, to first indices.
   pure subroutine accumulate(start)
      integer, intent(inout) :: start(:)             !! Counts from 2 on
      integer :: n

      start(1) = 1
      do n = 2, size(start)
         start(n) = start(n - 1) + start(n)
      end do
   end subroutine accumulate

   !> Put all grains into bins at least as high as the reach; in a nearly empty cell the bins are
   !! wider, so that their number follows that of the grains.
   subroutine fill_bins(grains, box, reach, bins)
      type(grains_t), intent(in) :: grains
      type(box_t), intent(in) :: box
      real(wp), intent(in) :: reach                  !! [m]
      type(bins_t), intent(out) :: bins
      integer, allocatable :: bin(:), next(:)
      real(wp), parameter :: most = 64.0_wp, few = 1024.0_wp ! bins of a grain, and of few grains
      real(wp) :: height(3), wider
      integer :: row, axis

      height = box%heights()
      wider = product(height(:box%dimension)/reach)/(most*real(grains%count, wp) + few)
      wider = max(1.0_wp, wider**(1.0_wp/real(box%dimension, wp)))
      do axis = 1, box%dimension
         bins%number(axis) = max(1, int(height(axis)/(wider*reach)))
      end do
      allocate (bin(grains%count), bins%start(product(bins%number) + 1), bins%row(grains%count))
      bins%start = 0
      do row = 1, grains%count
         bin(row) = bin_of(bins%number, place_in(bins%number, grains%place(:, row)))
         bins%start(bin(row) + 1) = bins%start(bin(row) + 1) + 1
      end do
      call accumulate(bins%start)
      next = bins%start
      do row = 1, grains%count
         bins%row(next(bin(row))) = row
         next(bin(row)) = next(bin(row)) + 1
      end do
   end subroutine fill_bins

   !> Bin of coordinates along each edge, from 0.
   pure function place_in(number, place) result(cell)
      integer, intent(in) :: number(3)               !! Bins
      real(wp), intent(in) :: place(3)               !! Coordinates in [0, 1)
      integer :: cell(3)

      cell = min(max(int(place*real(number, wp)), 0), number - 1)
   end function place_in

   !> Number of a bin, from 1.
   pure integer function bin_of(number, cell) result(bin)
      integer, intent(in) :: number(3)               !! Bins along each edge
      integer, intent(in) :: cell(3)                 !! Index of the bin, from 0

      bin = 1 + cell(1) + number(1)*(cell(2) + number(2)*cell(3))
   end function bin_of

   !> Count or write the neighbours of a row. Fewer than three bins along an edge are all searched
   !! once.
   pure subroutine search_row(grains, box, skin, bins, row, near, write_them)
      type(grains_t), intent(in) :: grains
      type(box_t), intent(in) :: box
      real(wp), intent(in) :: skin                   !! [m]
      type(bins_t), intent(in) :: bins
      integer, intent(in) :: row                     !! An own row
      type(neighbours_t), intent(inout) :: near
      logical, intent(in) :: write_them              !! After they have been counted
      integer :: low(3), high(3), centre(3), bin, i, j, k, n, found, next, own
      real(wp) :: shift(3)
      logical :: is_near

      own = row - grains%first + 1
      centre = place_in(bins%number, grains%place(:, row))
      low = merge(-1, 0, bins%number > 1)
      high = merge(1, 0, bins%number > 2)
      found = 0
      if (write_them) next = near%start(own)
      do k = low(3), high(3)
         do j = low(2), high(2)
            do i = low(1), high(1)
               bin = bin_of(bins%number, modulo(centre + [i, j, k], bins%number))
               do n = bins%start(bin), bins%start(bin + 1) - 1
                  call compare(grains, box, skin, row, bins%row(n), shift, is_near)
                  if (.not. is_near) cycle
                  found = found + 1
                  if (.not. write_them) cycle
                  near%row(next) = bins%row(n)
                  near%shift(:, next) = shift
                  next = next + 1
               end do
            end do
         end do
      end do
      if (.not. write_them) near%start(own + 1) = found
   end subroutine search_row

   !> Decide whether two grains are within the search distance, and find the edges to add to the
   !! coordinates of the second one.
   pure subroutine compare(grains, box, skin, row, other, shift, is_near)
      type(grains_t), intent(in) :: grains
      type(box_t), intent(in) :: box
      real(wp), intent(in) :: skin                   !! [m]
      integer, intent(in) :: row, other              !! Rows
      real(wp), intent(out) :: shift(3)              !! Shift of the nearest image [1]
      logical, intent(out) :: is_near
      real(wp) :: apart(3)

      is_near = .false.
      shift = 0.0_wp
      if (row == other) return
      apart = grains%place(:, other) - grains%place(:, row)
      shift = merge(-1.0_wp, 0.0_wp, apart > 0.5_wp) + merge(1.0_wp, 0.0_wp, apart < -0.5_wp)
      apart = apart + shift
      associate (h => box%edges)
         apart(1) = h(1, 1)*apart(1) + h(1, 2)*apart(2) + h(1, 3)*apart(3)
         apart(2) = h(2, 2)*apart(2) + h(2, 3)*apart(3)
         apart(3) = h(3, 3)*apart(3)
      end associate
      is_near = apart(1)**2 + apart(2)**2 + apart(3)**2 < &
         (grains%radius(row) + grains%radius(other) + skin)**2
   end subroutine compare

   !> Sort the neighbours of a row by identity.
   pure subroutine sort_neighbours(grains, near, own)
      type(grains_t), intent(in) :: grains
      type(neighbours_t), intent(inout) :: near
      integer, intent(in) :: own                     !! Own row, from 1
      integer :: n, m, row
      real(wp) :: shift(3)

      do n = near%start(own) + 1, near%start(own + 1) - 1
         row = near%row(n)
         shift = near%shift(:, n)
         m = n - 1
         do while (m >= near%start(own))
            if (grains%identity(near%row(m)) < grains%identity(row)) exit
            near%row(m + 1) = near%row(m)
            near%shift(:, m + 1) = near%shift(:, m)
            m = m - 1
         end do
         near%row(m + 1) = row
         near%shift(:, m + 1) = shift
      end do
   end subroutine sort_neighbours

   !> Make pairs of the neighbours: a pair of two own rows once, with the row of the lower identity.
   subroutine make_pairs(grains, near, pairs)
      type(grains_t), intent(in) :: grains
      type(neighbours_t), intent(in) :: near
      type(pairs_t), intent(inout) :: pairs
      integer, allocatable :: number(:)
      integer :: own, n, rows, count

      rows = grains%last - grains%first + 1
      allocate (number(size(near%row)))
      count = 0
      do own = 1, rows
         do n = near%start(own), near%start(own + 1) - 1
            number(n) = 0
            if (.not. leads(grains, grains%first + own - 1, near%row(n))) cycle
            count = count + 1
            number(n) = count
         end do
      end do
      call pairs%allocate(count)
      pairs%start = near%start
      if (allocated(pairs%incident)) deallocate (pairs%incident)
      allocate (pairs%incident(size(near%row)))
      !$omp parallel do default(none) shared(grains, near, pairs, rows, number) private(own) &
      !$omp schedule(static)
      do own = 1, rows
         call link_row(grains, near, number, own, pairs)
      end do
      !$omp end parallel do
   end subroutine make_pairs

   !> True if this row makes the pair: the neighbour belongs to another rank or has the higher
   !! identity.
   pure logical function leads(grains, row, other) result(makes)
      type(grains_t), intent(in) :: grains
      integer, intent(in) :: row, other              !! Rows

      makes = other < grains%first .or. other > grains%last
      if (.not. makes) makes = grains%identity(row) < grains%identity(other)
   end function leads

   !> Write the pairs of a row, and link it to the pairs that other rows make.
   pure subroutine link_row(grains, near, number, own, pairs)
      type(grains_t), intent(in) :: grains
      type(neighbours_t), intent(in) :: near
      integer, intent(in) :: number(:)               !! (neighbour) Pair, 0: the other makes it
      integer, intent(in) :: own                     !! Own row, from 1
      type(pairs_t), intent(inout) :: pairs
      integer :: n, row, other, place
      logical :: lower

      row = grains%first + own - 1
      do n = near%start(own), near%start(own + 1) - 1
         other = near%row(n)
         lower = grains%identity(row) < grains%identity(other)
         if (number(n) > 0) then
            pairs%incident(n) = merge(number(n), -number(n), lower)
            pairs%first(number(n)) = merge(row, other, lower)
            pairs%second(number(n)) = merge(other, row, lower)
            pairs%shift(:, number(n)) = merge(near%shift(:, n), -near%shift(:, n), lower)
         else
            place = near%start(other - grains%first + 1)
            do while (near%row(place) /= row)
               place = place + 1
            end do
            pairs%incident(n) = -number(place)
         end if
      end do
   end subroutine link_row
end module grains_neighbours
