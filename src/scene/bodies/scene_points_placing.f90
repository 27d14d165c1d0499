! SPDX-License-Identifier: BSD-3-Clause
!> Scales, rotates and translates points of a file with all their fields, as if the run that wrote
!! it had been scaled, rotated and translated as a whole.
!!
!! Scaling does not change velocities, stresses and densities, so masses grow with volumes, times
!! with lengths, and rates fall.
module scene_points_placing
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use io_points, only: point_list_t
   use mesh_grid, only: grid_t
   use particle_shape, only: rotation_matrix, transform_point
   implicit none
   private

   public :: components_of, placing_t, read_placing

   !> Placement of the points of a region.
   type :: placing_t
      real(wp) :: scale = 1.0_wp                     !! Factor, applied first [1]
      real(wp) :: volume_scale = 1.0_wp              !! Factor of volumes [1]
      real(wp) :: rotation(3, 3) = 0.0_wp            !! Orthogonal, applied after the factor [1]
      real(wp) :: translate(3) = 0.0_wp              !! Applied last [m]
      logical :: changes = .false.                   !! Are there a factor or angles?
   contains
      procedure :: keeps => placing_keeps            !! Can a field be rotated?
      procedure :: move => placing_move              !! Positions, volumes, velocities of a list
      procedure :: turn => placing_turn              !! Values of a field
   end type placing_t

contains

   !> Read it. A rotation out of the plane or line of the scene is refused.
   subroutine read_placing(deck, grid, group, placing)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Active directions
      type(group_t), intent(in) :: group
      type(placing_t), intent(out) :: placing
      real(wp), parameter :: little = 1.0e-12_wp
      real(wp) :: angles(3)
      logical :: leaves
      integer :: k

      call group%get("scale", placing%scale)
      call group%get("rotate", angles)
      call group%get("translate", placing%translate)
      placing%changes = abs(placing%scale - 1.0_wp) > 0.0_wp .or. any(abs(angles) > 0.0_wp)
      placing%rotation = rotation_matrix(angles)
      placing%volume_scale = placing%scale**merge(3, grid%dimensions, grid%axisymmetric)
      leaves = .false.
      do k = 1, 3
         if (grid%active(k)) cycle
         leaves = leaves .or. abs(abs(placing%rotation(k, k)) - 1.0_wp) > little
      end do
      if (leaves) call deck%add_error(group, "this rotation moves points out of the plane or "// &
         "line of the scene; in a plane only the second angle may differ from 0 [D415]", "rotate")
      if (leaves .or. .not. grid%axisymmetric) return
      if (placing%rotation(1, 1) < 1.0_wp - little) call deck%add_error(group, "points are "// &
         "rings around the axis, which cannot be rotated; write rotate = 0 0 0 [D416]", "rotate")
   end subroutine read_placing

   !> False for boxes along the coordinates that are rotated by other than right angles.
   pure logical function placing_keeps(self, name) result(keeps)
      class(placing_t), intent(in) :: self           !! Placement of points
      character(len=*), intent(in) :: name
      real(wp), parameter :: little = 1.0e-12_wp

      keeps = .true.
      if (name == "extent" .and. self%changes) &
         keeps = all(min(abs(self%rotation), abs(1.0_wp - abs(self%rotation))) <= little)
   end function placing_keeps

   !> Move the points of a list to their positions.
   pure subroutine placing_move(self, grid, list)
      class(placing_t), intent(in) :: self           !! Placement of points
      type(grid_t), intent(in) :: grid               !! Active directions
      type(point_list_t), intent(inout) :: list      !! Changed
      real(wp) :: middle(3)
      integer :: n

      middle = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
      do n = 1, size(list%position, 2)
         if (self%changes) then
            where (.not. grid%active) list%position(:, n) = 0.0_wp
            call transform_point(self%scale, self%rotation, self%translate, list%position(:, n))
         else
            list%position(:, n) = list%position(:, n) + self%translate
         end if
         where (.not. grid%active) list%position(:, n) = middle
      end do
      if (.not. self%changes) return
      list%lag = self%scale*list%lag
      list%dt_next = self%scale*list%dt_next
      if (allocated(list%volume)) list%volume = self%volume_scale*list%volume
      if (allocated(list%velocity)) call self%turn("velocity", list%velocity)
   end subroutine placing_move

   !> Scale and turn the values of a field.
   pure subroutine placing_turn(self, name, values)
      class(placing_t), intent(in) :: self           !! Placement of points
      character(len=*), intent(in) :: name
      real(wp), intent(inout) :: values(:, :)        !! (component, row)
      integer :: n, k

      if (.not. self%changes) return
      select case (name)
      case ("mass")
         values = self%volume_scale*values
      case ("velocity", "spin")
         do n = 1, size(values, 2)
            values(:, n) = matmul(self%rotation, [values(1, n), values(2, n), values(3, n)])
         end do
         if (name == "spin") values = values/self%scale
      case ("extent")
         do n = 1, size(values, 2)
            values(:, n) = self%scale*matmul(abs(self%rotation), values(:, n))
         end do
      case ("domain")
         do n = 1, size(values, 2)
            do k = 1, 7, 3
               values(k:k + 2, n) = self%scale*matmul(self%rotation, values(k:k + 2, n))
            end do
         end do
      case ("affine", "deformation_gradient", "ahead")
         do n = 1, size(values, 2)
            values(:, n) = reshape(turned(self%rotation, reshape(values(:, n), [3, 3])), [9])
         end do
         if (name == "affine") values = values/self%scale
      case ("stress")
         do n = 1, size(values, 2)
            values(:, n) = six_of(turned(self%rotation, nine_of(values(:, n))))
         end do
      case default
         continue
      end select
   end subroutine placing_turn

   !> Components of a field that belong to directions, 1 for all others.
   pure integer function components_of(name) result(components)
      character(len=*), intent(in) :: name

      select case (name)
      case ("velocity", "spin", "extent")
         components = 3
      case ("stress")
         components = 6
      case ("domain", "affine", "deformation_gradient", "ahead")
         components = 9
      case default
         components = 1
      end select
   end function components_of

   !> A tensor in turned coordinates.
   pure function turned(rotation, tensor) result(seen)
      real(wp), intent(in) :: rotation(3, 3)         !! Orthogonal [1]
      real(wp), intent(in) :: tensor(3, 3)           !! Tensor of any unit
      real(wp) :: seen(3, 3)

      seen = matmul(rotation, matmul(tensor, transpose(rotation)))
   end function turned

   !> The tensor of six components.
   pure function nine_of(six) result(tensor)
      real(wp), intent(in) :: six(:)                 !! xx, yy, zz, xy, yz, xz
      real(wp) :: tensor(3, 3)

      tensor = reshape([six(1), six(4), six(6), six(4), six(2), six(5), six(6), six(5), six(3)], &
         [3, 3])
   end function nine_of

   !> The six components of a symmetric tensor.
   pure function six_of(tensor) result(six)
      real(wp), intent(in) :: tensor(3, 3)           !! Symmetric but for rounding
      real(wp) :: six(6)

      six = [tensor(1, 1), tensor(2, 2), tensor(3, 3), 0.5_wp*(tensor(1, 2) + tensor(2, 1)), &
         0.5_wp*(tensor(2, 3) + tensor(3, 2)), 0.5_wp*(tensor(1, 3) + tensor(3, 1))]
   end function six_of
end module scene_points_placing
