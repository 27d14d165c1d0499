! SPDX-License-Identifier: BSD-3-Clause
!> Particles at the positions of a list.
module particle_points
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_key
   use particle_body, only: cell_of, given_t
   use particle_shape, only: shape_t, transform_point
   implicit none
   private

   public :: cloud, cloud_t, points_t, set_points

   !> Region of the points of a list. It has no volume, so it contains no position.
   type, extends(shape_t) :: cloud_t
      private
      real(wp) :: lower(3) = 1.0_wp                      !! Lower corner of the bounding box [m]
      real(wp) :: upper(3) = -1.0_wp                     !! Upper corner [m]
   contains
      procedure :: contains => cloud_contains            !! Is a point inside? Never
      procedure :: bounds => cloud_bounds                !! A bounding box
      procedure :: transform => cloud_transform          !! Scale, rotate and translate
   end type cloud_t

   !> Particles of a list, sorted by tile.
   type, extends(given_t) :: points_t
      integer(int64) :: rows = 0                         !! Rows of the list, of all bodies
      real(wp), allocatable, private :: position(:, :)   !! (3, particle) [m]
      real(wp), allocatable, private :: volume(:)        !! (particle) [m3]
      integer(int64), allocatable, private :: row(:)     !! (particle) From 1
      integer(int64), allocatable, private :: key(:)     !! (particle) Key of its tile, ascending
   contains
      procedure :: numbers => points_numbers             !! Number of possible identities
      procedure :: collect => points_collect             !! The particles of a tile
      procedure :: positions => points_positions               !! Positions of all
   end type points_t

contains

   !> Positions of all particles of the list.
   pure function points_positions(self) result(position)
      class(points_t), intent(in) :: self
      real(wp) :: position(3, size(self%position, 2))    !! (3, particle) [m]

      position = self%position
   end function points_positions

   !> Make the cloud of some points.
   pure type(cloud_t) function cloud(position) result(shape)
      real(wp), intent(in) :: position(:, :)             !! (3, point) [m]

      if (size(position, 2) == 0) return
      shape%lower = minval(position, dim=2)
      shape%upper = maxval(position, dim=2)
   end function cloud

   !> Always false, as a cloud contains no position.
   pure recursive logical function cloud_contains(self, x) result(inside)
      class(cloud_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                       !! Point [m]

      ! false for all values; it uses both arguments, so that the compiler does not warn
      inside = any(x < self%lower .and. x > self%upper .and. self%lower <= self%upper)
   end function cloud_contains

   !> A bounding box of the cloud.
   pure recursive subroutine cloud_bounds(self, lo, hi)
      class(cloud_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)              !! Corners [m]

      lo = self%lower
      hi = self%upper
   end subroutine cloud_bounds

   !> Scale, rotate and translate the bounding box; a rotation enlarges it.
   pure recursive subroutine cloud_transform(self, scale, rotation, translate)
      class(cloud_t), intent(inout) :: self
      real(wp), intent(in) :: scale                      !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)             !! Orthogonal [1]
      real(wp), intent(in) :: translate(3)               !! Displacement [m]
      real(wp) :: middle(3), half(3)

      middle = 0.5_wp*(self%lower + self%upper)
      half = scale*matmul(abs(rotation), 0.5_wp*(self%upper - self%lower))
      call transform_point(scale, rotation, translate, middle)
      self%lower = middle - half
      self%upper = middle + half
   end subroutine cloud_transform

   !> Make particles from a list.
   pure subroutine set_points(points, grid, position, volume, row, rows)
      type(points_t), intent(out) :: points
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: position(:, :) !! (3, particle) In the grid [m]
      real(wp), intent(in) :: volume(:)                  !! (particle) [m3]
      integer(int64), intent(in) :: row(:)               !! (particle) Row of the list
      integer(int64), intent(in) :: rows                 !! Rows of the list
      integer(int64), allocatable :: key(:)
      integer, allocatable :: order(:)
      integer :: n

      points%clipped = .false.
      points%rows = rows
      allocate (key(size(row)))
      do n = 1, size(row)
         key(n) = hilbert_key(cell_of(grid, position(:, n))/grid%width, grid%dimensions)
      end do
      order = sort_order(key)
      allocate (points%position(3, size(row)))
      do n = 1, size(row)
         points%position(:, n) = position(:, order(n))
      end do
      points%volume = volume(order)
      points%row = row(order)
      points%key = key(order)
   end subroutine set_points

   !> Number of possible identities of particles: the rows of the list.
   pure function points_numbers(self, grid) result(numbers)
      class(points_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer(int64) :: numbers(3)

      numbers = merge(1_int64, 0_int64, grid%cells > 0)
      numbers(1) = self%rows
   end function points_numbers

   !> The particles of a tile.
   pure subroutine points_collect(self, grid, coordinate, position, volume, number)
      class(points_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)               !! Tile, counted from 0
      real(wp), allocatable, intent(out) :: position(:, :) !! (3, particle) [m]
      real(wp), allocatable, intent(out) :: volume(:)    !! (particle) [m3]
      integer(int64), allocatable, intent(out) :: number(:) !! (particle) Row of the list
      integer(int64) :: key
      integer :: first, last

      key = hilbert_key(coordinate, grid%dimensions)
      first = before(self%key, key)
      last = before(self%key, key + 1)
      position = self%position(:, first + 1:last)
      volume = self%volume(first + 1:last)
      number = self%row(first + 1:last)
   end subroutine points_collect

   !> Number of keys below a bound.
   pure integer function before(key, bound) result(number)
      integer(int64), intent(in) :: key(:)               !! Ascending
      integer(int64), intent(in) :: bound
      integer :: above, middle

      number = 0
      above = size(key) + 1
      do while (above - number > 1)
         middle = number + (above - number)/2
         if (key(middle) < bound) then
            number = middle
         else
            above = middle
         end if
      end do
   end function before
end module particle_points
