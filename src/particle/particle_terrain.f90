! SPDX-License-Identifier: BSD-3-Clause
!> What lies below a surface of heights, or a layer of given thickness on this surface.
module particle_terrain
   use base_kinds, only: wp
   use particle_framed, only: framed_t
   use particle_raster, only: raster_t
   implicit none
   private

   public :: set_terrain, terrain_t

   real(wp), parameter :: far = 1.0e30_wp            !! Depth of the ground [m]

   !> Ground, without its surface, or a layer with its lower surface and without the upper one: a
   !! point belongs to one of both. There is no ground where the height is not known, and no layer
   !! where height or thickness are not known.
   type, extends(framed_t) :: terrain_t
      type(raster_t) :: ground                       !! Heights of the surface
      type(raster_t), allocatable :: layer           !! Thicknesses; without it, the ground is meant
      real(wp), private :: low(3) = 1.0_wp           !! Corner of a bounding box [m]
      real(wp), private :: high(3) = -1.0_wp         !! The other corner [m]
   contains
      procedure :: holds => terrain_holds            !! Is a point in local coordinates inside?
      procedure :: own_bounds => terrain_own_bounds  !! A bounding box in local coordinates
   end type terrain_t

contains

   !> Make the ground below a surface, or a layer on it.
   pure subroutine set_terrain(shape, ground, layer)
      type(terrain_t), intent(out) :: shape
      type(raster_t), intent(in) :: ground           !! Heights
      type(raster_t), intent(in), optional :: layer  !! Thicknesses
      real(wp) :: low(2), high(2), least, greatest, thickest

      shape%ground = ground
      low = ground%corner
      high = ground%upper()
      if (present(layer)) then
         shape%layer = layer
         call find_extent(layer, low, high)
      end if
      if (any(low >= high)) return
      call ground%extremes(low, high, least, greatest)
      if (least > greatest) return
      shape%low = [low, -far]
      shape%high = [high, greatest]
      if (present(layer)) then
         shape%low(3) = least
         call layer%extremes(low, high, least, thickest)
         shape%high(3) = greatest + thickest
      end if
      if (.not. ground%profile) return
      shape%low(2) = -far
      shape%high(2) = far
   end subroutine set_terrain

   !> The rectangle in which a layer has a thickness above 0; without one its corners are the wrong
   !! way round.
   pure subroutine find_extent(layer, low, high)
      type(raster_t), intent(in) :: layer            !! Thicknesses
      real(wp), intent(out) :: low(2), high(2)       !! Corners [m]
      real(wp) :: place(2)
      integer :: i, j

      low = layer%upper()
      high = layer%corner
      do j = 1, size(layer%value, 2)
         do i = 1, size(layer%value, 1)
            if (.not. layer%value(i, j) > 0.0_wp) cycle
            ! interpolation ends at the middle of the next cell
            place = layer%middle(i - 1, j - 1)
            low = min(low, place)
            place = layer%middle(i + 1, j + 1)
            high = max(high, place)
         end do
      end do
   end subroutine find_extent

   !> True if a point in local coordinates is inside.
   pure logical function terrain_holds(self, own) result(inside)
      class(terrain_t), intent(in) :: self
      real(wp), intent(in) :: own(3)                 !! Local coordinates [m]
      real(wp) :: height, thickness

      call self%ground%find(own(1), own(2), height, inside)
      if (.not. inside) return
      if (allocated(self%layer)) then
         call self%layer%find(own(1), own(2), thickness, inside)
         inside = inside .and. own(3) >= height .and. own(3) < height + thickness
      else
         inside = own(3) < height
      end if
   end function terrain_holds

   !> A bounding box; the ground has no lower end.
   pure subroutine terrain_own_bounds(self, lo, hi)
      class(terrain_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)          !! Corners [m]

      lo = self%low
      hi = self%high
   end subroutine terrain_own_bounds
end module particle_terrain
