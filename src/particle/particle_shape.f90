! SPDX-License-Identifier: BSD-3-Clause
!> Shapes of bodies: box, sphere, cylinder, and set operations on shapes.
!!
!! All procedures are pure, so threads may call them concurrently. Plane and axisymmetric scenes use
!! the section y = 0.
module particle_shape
   use base_constants, only: pi
   use base_kinds, only: wp
   use mesh_point_set, only: point_set_t
   implicit none
   private

   public :: box, combine_shapes, cylinder, rotation_matrix, sphere, transform_point

   integer, parameter, public :: set_union = 1        !! Points in any operand
   integer, parameter, public :: set_difference = 2   !! Points in the first operand alone
   integer, parameter, public :: set_intersection = 3 !! Points in all operands
   real(wp), parameter :: unturned(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
   real(wp), parameter :: unmoved(3) = 0.0_wp
   !> Bounds of an empty shape: the lower corner is above the upper one.
   real(wp), parameter :: empty_lower = 1.0_wp, empty_upper = -1.0_wp

   !> A set of points.
   type, abstract, extends(point_set_t), public :: shape_t
   contains
      procedure :: place => shape_place              !! Scale, rotate and translate
      procedure :: spans => shape_spans              !! Does it surely contain a whole box?
      procedure(transform_i), deferred :: transform  !! The same with a rotation matrix
   end type shape_t

   !> A shape of any kind, for arrays of shapes. Without a shape it holds no point.
   type, public :: shape_holder_t
      class(shape_t), allocatable :: shape
   contains
      procedure :: contains => holder_contains       !! True for a point inside
      procedure :: bounds => holder_bounds           !! A bounding box
      procedure :: spans => holder_spans             !! Does it surely contain a whole box?
      procedure :: set => holder_set                 !! Hold a copy of a shape
   end type shape_holder_t

   !> A box, half-open along its edges, so that adjacent boxes have no common point.
   type, extends(shape_t), public :: cuboid_t
      private
      real(wp) :: lower(3) = 0.0_wp !! Lower corner, in local coordinates, inside [m]
      real(wp) :: upper(3) = 0.0_wp !! Upper corner, in local coordinates, outside [m]
      logical :: turned = .false.                    !! Are local coordinates rotated?
      real(wp) :: origin(3) = 0.0_wp                 !! Origin of local coordinates [m]
      real(wp) :: rotation(3, 3) = unturned          !! Columns are the local directions [1]
   contains
      procedure :: contains => box_contains          !! True for a point inside
      procedure :: spans => box_spans                !! Does it surely contain a whole box?
      procedure :: bounds => box_bounds              !! A bounding box
      procedure :: transform => box_transform        !! Scale, rotate and translate
   end type cuboid_t

   !> A ball without its surface.
   type, extends(shape_t), public :: sphere_t
      private
      real(wp) :: centre(3) = 0.0_wp                 !! Centre [m]
      real(wp) :: radius = 0.0_wp                    !! Radius [m]
   contains
      procedure :: contains => sphere_contains       !! True for a point inside
      procedure :: bounds => sphere_bounds           !! A bounding box
      procedure :: transform => sphere_transform     !! Scale, rotate and translate
   end type sphere_t

   !> A solid cylinder without its lateral surface, half-open along its axis.
   type, extends(shape_t), public :: cylinder_t
      private
      real(wp) :: centre(3) = 0.0_wp                 !! Middle of the axis [m]
      real(wp) :: axis(3) = 0.0_wp                   !! Direction of length one [1]
      real(wp) :: radius = 0.0_wp                    !! Radius [m]
      real(wp) :: height = 0.0_wp                    !! Length of the axis [m]
   contains
      procedure :: contains => cylinder_contains     !! True for a point inside
      procedure :: bounds => cylinder_bounds         !! A bounding box
      procedure :: transform => cylinder_transform   !! Scale, rotate and translate
   end type cylinder_t

   !> A set operation on shapes.
   type, extends(shape_t), public :: combination_t
      private
      integer :: kind = set_union                    !! One of the constants above
      type(shape_holder_t), allocatable :: operand(:)
   contains
      procedure :: contains => combination_contains  !! True for a point inside
      procedure :: bounds => combination_bounds      !! A bounding box
      procedure :: transform => combination_transform !! Scale, rotate and translate
   end type combination_t

   abstract interface
      pure recursive subroutine transform_i(self, scale, rotation, translate)
         import :: shape_t, wp
         implicit none
         class(shape_t), intent(inout) :: self
         real(wp), intent(in) :: scale               !! Positive factor [1]
         real(wp), intent(in) :: rotation(3, 3)      !! Orthogonal, applied after the factor [1]
         real(wp), intent(in) :: translate(3)        !! Displacement, applied last [m]
      end subroutine transform_i
   end interface

contains

   !> Make a box with edges along the coordinates: lo <= x < hi.
   pure type(cuboid_t) function box(lo, hi) result(shape)
      real(wp), intent(in) :: lo(3)                  !! Lower corner, inside [m]
      real(wp), intent(in) :: hi(3)                  !! Upper corner, outside [m]

      shape%lower = lo
      shape%upper = hi
   end function box

   !> Make a ball.
   pure type(sphere_t) function sphere(centre, radius) result(shape)
      real(wp), intent(in) :: centre(3)              !! Centre [m]
      real(wp), intent(in) :: radius                 !! Radius [m]

      shape%centre = centre
      shape%radius = radius
   end function sphere

   !> Make a solid cylinder. It is empty if the axis has no length.
   pure type(cylinder_t) function cylinder(centre, axis, radius, height) result(shape)
      real(wp), intent(in) :: centre(3)              !! Middle of the axis [m]
      real(wp), intent(in) :: axis(3)                !! Direction, of any length
      real(wp), intent(in) :: radius                 !! Radius [m]
      real(wp), intent(in) :: height                 !! Length of the axis [m]
      real(wp) :: largest

      shape%centre = centre
      shape%radius = radius
      largest = maxval(abs(axis))
      if (.not. largest > 0.0_wp) return
      shape%height = height
      ! The first division keeps the squares of very long and very short axes in range.
      shape%axis = axis/largest
      shape%axis = shape%axis/sqrt(dot_product(shape%axis, shape%axis))
   end function cylinder

   !> Make a set operation on copies of shapes. A difference subtracts all others from the first.
   type(combination_t) function combine_shapes(kind, operands) result(shape)
      integer, intent(in) :: kind                    !! set_union, set_difference, set_intersection
      type(shape_holder_t), intent(in) :: operands(:)
      integer :: number

      shape%kind = kind
      allocate (shape%operand(size(operands)))
      do number = 1, size(operands)
         if (.not. allocated(operands(number)%shape)) cycle
         call shape%operand(number)%set(operands(number)%shape)
      end do
   end function combine_shapes

   !> Scale, then rotate about x, then y, then z, all about the origin of coordinates, then
   !! translate.
   pure subroutine shape_place(self, scale, rotate, translate)
      class(shape_t), intent(inout) :: self
      real(wp), intent(in) :: scale                  !! Positive factor [1]
      real(wp), intent(in) :: rotate(3)              !! Angles about the axes x, y, z [deg]
      real(wp), intent(in) :: translate(3)           !! Displacement [m]
      real(wp) :: rotation(3, 3)

      rotation = rotation_matrix(rotate)
      call self%transform(scale, rotation, translate)
   end subroutine shape_place

   !> Rotation about x, then y, then z; exact for right angles.
   pure function rotation_matrix(angle) result(rotation)
      real(wp), intent(in) :: angle(3)               !! About x, y and z [deg]
      real(wp) :: rotation(3, 3)                     !! Columns are the rotated directions [1]
      real(wp) :: turn(3, 3), cosine, sine
      integer :: axis, next, last

      rotation = unturned
      do axis = 1, 3
         next = 1 + mod(axis, 3)
         last = 1 + mod(next, 3)
         sine = sine_of_degrees(angle(axis))
         cosine = cosine_of_degrees(angle(axis))
         turn = unturned
         turn(next, next) = cosine
         turn(last, last) = cosine
         turn(last, next) = sine
         turn(next, last) = -sine
         call rotate_columns(turn, rotation)
      end do
   end function rotation_matrix

   !> Rotate the columns of a matrix.
   pure subroutine rotate_columns(rotation, columns)
      real(wp), intent(in) :: rotation(3, 3)         !! Orthogonal [1]
      real(wp), intent(inout) :: columns(3, 3)       !! Vectors
      integer :: column

      do column = 1, 3
         call transform_point(1.0_wp, rotation, unmoved, columns(:, column))
      end do
   end subroutine rotate_columns

   !> Scale, rotate and translate a point.
   pure subroutine transform_point(scale, rotation, translate, x)
      real(wp), intent(in) :: scale                  !! Factor [1]
      real(wp), intent(in) :: rotation(3, 3)         !! Orthogonal [1]
      real(wp), intent(in) :: translate(3)           !! Displacement [m]
      real(wp), intent(inout) :: x(3)                !! Point [m]
      real(wp) :: before(3)

      before = scale*x
      x = rotation(:, 1)*before(1) + rotation(:, 2)*before(2) + rotation(:, 3)*before(3) &
         + translate
   end subroutine transform_point

   !> Sine of an angle in degrees; multiples of 90 give exactly 0, 1 or -1.
   pure real(wp) function sine_of_degrees(angle) result(sine)
      real(wp), intent(in) :: angle                  !! Angle [deg]
      real(wp) :: rest

      rest = modulo(angle, 360.0_wp)
      sine = sin(rest*pi/180.0_wp)
      if (modulo(rest, 180.0_wp) <= 0.0_wp) sine = 0.0_wp
   end function sine_of_degrees

   !> Cosine of an angle in degrees; multiples of 90 give exactly 0, 1 or -1.
   pure real(wp) function cosine_of_degrees(angle) result(cosine)
      real(wp), intent(in) :: angle                  !! Angle [deg]
      real(wp) :: rest

      rest = modulo(angle, 360.0_wp)
      cosine = cos(rest*pi/180.0_wp)
      if (abs(modulo(rest, 180.0_wp) - 90.0_wp) <= 0.0_wp) cosine = 0.0_wp
   end function cosine_of_degrees

   !> True if a point is inside the held shape.
   pure recursive logical function holder_contains(self, x) result(inside)
      class(shape_holder_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! Point [m]

      inside = .false.
      if (allocated(self%shape)) inside = self%shape%contains(x)
   end function holder_contains

   !> A bounding box of the held shape.
   pure recursive subroutine holder_bounds(self, lo, hi)
      class(shape_holder_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)          !! Corners [m]

      lo = empty_lower
      hi = empty_upper
      if (allocated(self%shape)) call self%shape%bounds(lo, hi)
   end subroutine holder_bounds

   !> True if the held shape surely contains a box.
   pure logical function holder_spans(self, low, high) result(spans)
      class(shape_holder_t), intent(in) :: self
      real(wp), intent(in) :: low(3), high(3)        !! Corners, which count as points [m]

      spans = .false.
      if (allocated(self%shape)) spans = self%shape%spans(low, high)
   end function holder_spans

   !> True if a shape surely contains all points of a box; if false, each point must be tested.
   pure logical function shape_spans(self, low, high) result(spans)
      class(shape_t), intent(in) :: self
      real(wp), intent(in) :: low(3), high(3)        !! Corners [m]

      spans = .false.
   end function shape_spans

   !> True if a box along the coordinates contains all points of another one.
   pure logical function box_spans(self, low, high) result(spans)
      class(cuboid_t), intent(in) :: self
      real(wp), intent(in) :: low(3), high(3)        !! Corners [m]

      spans = .not. self%turned .and. all(low >= self%lower .and. high < self%upper)
   end function box_spans

   !> Store a copy of a shape.
   subroutine holder_set(self, shape)
      class(shape_holder_t), intent(inout) :: self
      class(shape_t), intent(in) :: shape
      class(shape_t), allocatable :: copy

      allocate (copy, source=shape)
      call move_alloc(copy, self%shape)
   end subroutine holder_set

   !> True if a point is inside the box, without any tolerance.
   pure recursive logical function box_contains(self, x) result(inside)
      class(cuboid_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! Point [m]
      real(wp) :: own(3), offset(3)
      integer :: direction

      own = x
      if (self%turned) then
         offset = x - self%origin
         do direction = 1, 3
            own(direction) = dot_product(self%rotation(:, direction), offset)
         end do
      end if
      inside = all(own >= self%lower .and. own < self%upper)
   end function box_contains

   !> A bounding box, exact up to rounding if the box is rotated.
   pure recursive subroutine box_bounds(self, lo, hi)
      class(cuboid_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)          !! Corners [m]
      real(wp) :: corner(3)
      integer :: number, direction

      if (any(self%lower >= self%upper)) then
         lo = empty_lower
         hi = empty_upper
         return
      end if
      lo = self%lower
      hi = self%upper
      if (.not. self%turned) return
      do number = 0, 7
         do direction = 1, 3
            corner(direction) = merge(self%upper(direction), self%lower(direction), &
               btest(number, direction - 1))
         end do
         call transform_point(1.0_wp, self%rotation, self%origin, corner)
         if (number == 0) then
            lo = corner
            hi = corner
         end if
         lo = min(lo, corner)
         hi = max(hi, corner)
      end do
   end subroutine box_bounds

   !> Scale, rotate and translate the box. If its edges are then along the coordinates, its corners
   !! are stored in global coordinates, so that it is half-open there and adjacent boxes leave no
   !! gap.
   pure recursive subroutine box_transform(self, scale, rotation, translate)
      class(cuboid_t), intent(inout) :: self
      real(wp), intent(in) :: scale                  !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)         !! Orthogonal [1]
      real(wp), intent(in) :: translate(3)           !! Displacement [m]
      real(wp) :: first(3), last(3)
      logical :: empty

      empty = any(self%lower >= self%upper)
      self%lower = scale*self%lower
      self%upper = scale*self%upper
      call transform_point(scale, rotation, translate, self%origin)
      call rotate_columns(rotation, self%rotation)
      self%turned = any(abs(self%rotation) > 0.0_wp .and. abs(self%rotation) < 1.0_wp)
      if (self%turned) return
      first = self%lower
      last = self%upper
      call transform_point(1.0_wp, self%rotation, self%origin, first)
      call transform_point(1.0_wp, self%rotation, self%origin, last)
      self%lower = min(first, last)
      self%upper = max(first, last)
      if (empty) self%upper = self%lower
      self%origin = 0.0_wp
      self%rotation = unturned
   end subroutine box_transform

   !> True if a point is inside the ball.
   pure recursive logical function sphere_contains(self, x) result(inside)
      class(sphere_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! Point [m]

      inside = self%radius > 0.0_wp .and. sum((x - self%centre)**2) < self%radius**2
   end function sphere_contains

   !> A bounding box of the ball.
   pure recursive subroutine sphere_bounds(self, lo, hi)
      class(sphere_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)          !! Corners [m]

      lo = empty_lower
      hi = empty_upper
      if (.not. self%radius > 0.0_wp) return
      lo = self%centre - self%radius
      hi = self%centre + self%radius
   end subroutine sphere_bounds

   !> Scale, rotate and translate the ball.
   pure recursive subroutine sphere_transform(self, scale, rotation, translate)
      class(sphere_t), intent(inout) :: self
      real(wp), intent(in) :: scale                  !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)         !! Orthogonal [1]
      real(wp), intent(in) :: translate(3)           !! Displacement [m]

      call transform_point(scale, rotation, translate, self%centre)
      self%radius = scale*self%radius
   end subroutine sphere_transform

   !> True if a point is inside the cylinder.
   pure recursive logical function cylinder_contains(self, x) result(inside)
      class(cylinder_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! Point [m]
      real(wp) :: offset(3), along, half

      offset = x - self%centre
      along = dot_product(offset, self%axis)
      half = 0.5_wp*self%height
      inside = self%radius > 0.0_wp .and. along >= -half .and. along < half
      if (.not. inside) return
      inside = sum((offset - along*self%axis)**2) < self%radius**2
   end function cylinder_contains

   !> A bounding box of the cylinder.
   pure recursive subroutine cylinder_bounds(self, lo, hi)
      class(cylinder_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)          !! Corners [m]
      real(wp) :: reach(3)

      lo = empty_lower
      hi = empty_upper
      if (.not. (self%radius > 0.0_wp .and. self%height > 0.0_wp)) return
      reach = 0.5_wp*self%height*abs(self%axis) &
         + self%radius*sqrt(max(1.0_wp - self%axis**2, 0.0_wp))
      lo = self%centre - reach
      hi = self%centre + reach
   end subroutine cylinder_bounds

   !> Scale, rotate and translate the cylinder.
   pure recursive subroutine cylinder_transform(self, scale, rotation, translate)
      class(cylinder_t), intent(inout) :: self
      real(wp), intent(in) :: scale                  !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)         !! Orthogonal [1]
      real(wp), intent(in) :: translate(3)           !! Displacement [m]

      call transform_point(scale, rotation, translate, self%centre)
      call transform_point(1.0_wp, rotation, unmoved, self%axis)
      self%radius = scale*self%radius
      self%height = scale*self%height
   end subroutine cylinder_transform

   !> True if a point is inside the combination.
   pure recursive logical function combination_contains(self, x) result(inside)
      class(combination_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! Point [m]
      integer :: number

      inside = .false.
      if (.not. allocated(self%operand)) return
      do number = 1, size(self%operand)
         ! a union stops at the first operand that contains the point, the others at one that
         ! excludes it
         if (number > 1 .and. (inside .eqv. self%kind == set_union)) return
         inside = self%operand(number)%contains(x)
         if (number > 1 .and. self%kind == set_difference) inside = .not. inside
      end do
   end function combination_contains

   !> A bounding box of the combination; for a difference, that of its first operand.
   pure recursive subroutine combination_bounds(self, lo, hi)
      class(combination_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)          !! Corners [m]
      real(wp) :: lower(3), upper(3)
      integer :: number

      lo = empty_lower
      hi = empty_upper
      if (.not. allocated(self%operand)) return
      if (size(self%operand) == 0) return
      call self%operand(1)%bounds(lo, hi)
      if (self%kind == set_difference) return
      do number = 2, size(self%operand)
         call self%operand(number)%bounds(lower, upper)
         if (self%kind == set_intersection) then
            lo = max(lo, lower)
            hi = min(hi, upper)
         else if (any(lo > hi)) then
            lo = lower
            hi = upper
         else if (all(lower <= upper)) then
            lo = min(lo, lower)
            hi = max(hi, upper)
         end if
      end do
      if (all(lo <= hi)) return
      lo = empty_lower
      hi = empty_upper
   end subroutine combination_bounds

   !> Scale, rotate and translate all operands.
   pure recursive subroutine combination_transform(self, scale, rotation, translate)
      class(combination_t), intent(inout) :: self
      real(wp), intent(in) :: scale                  !! Positive factor [1]
      real(wp), intent(in) :: rotation(3, 3)         !! Orthogonal [1]
      real(wp), intent(in) :: translate(3)           !! Displacement [m]
      integer :: number

      if (.not. allocated(self%operand)) return
      do number = 1, size(self%operand)
         if (.not. allocated(self%operand(number)%shape)) cycle
         call self%operand(number)%shape%transform(scale, rotation, translate)
      end do
   end subroutine combination_transform
end module particle_shape
