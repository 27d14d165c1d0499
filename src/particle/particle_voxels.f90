! SPDX-License-Identifier: BSD-3-Clause
!> Solids made of voxels: equal boxes on a lattice, each of which is filled or empty.
module particle_voxels
   use base_kinds, only: int64, wp
   use particle_framed, only: framed_t
   implicit none
   private

   public :: mark_voxel, set_voxels, voxels_t

   !> A solid. It contains the points of its filled voxels; a voxel includes its lower faces.
   type, extends(framed_t) :: voxels_t
      integer, private :: extent(3) = 0                  !! Voxels along each direction
      real(wp), private :: edge(3) = 1.0_wp              !! Edges of a voxel [m]
      real(wp), private :: corner(3) = 0.0_wp            !! Lower corner of the first voxel [m]
      integer(int64) :: filled = 0                       !! Number of filled voxels
      integer, private :: first(3) = 0                   !! First layers with filled voxels, from 0
      integer, private :: last(3) = -1                   !! Last layers with filled voxels
      character(len=:), allocatable, private :: mask     !! One bit per voxel, x fastest
   contains
      procedure :: holds => voxels_hold                  !! Is a point in local coordinates inside?
      procedure :: own_bounds => voxels_own_bounds       !! A bounding box in local coordinates
   end type voxels_t

contains

   !> Make a solid from the mask of its voxels, which is moved into it.
   pure subroutine set_voxels(shape, extent, edge, corner, mask)
      type(voxels_t), intent(out) :: shape
      integer, intent(in) :: extent(3)                   !! Voxels along x, y and z
      real(wp), intent(in) :: edge(3)                    !! Edges of a voxel [m]
      real(wp), intent(in) :: corner(3)                  !! Lower corner of the first voxel [m]
      character(len=:), allocatable, intent(inout) :: mask !! As `mark_voxel` makes it
      integer :: place(3), x, y, z

      shape%extent = extent
      shape%edge = edge
      shape%corner = corner
      call move_alloc(mask, shape%mask)
      shape%first = extent
      do z = 0, extent(3) - 1
         do y = 0, extent(2) - 1
            do x = 0, extent(1) - 1
               place = [x, y, z]
               if (.not. marked(shape, place)) cycle
               shape%filled = shape%filled + 1
               shape%first = min(shape%first, place)
               shape%last = max(shape%last, place)
            end do
         end do
      end do
   end subroutine set_voxels

   !> Mark a voxel as filled. The mask has eight voxels a character and is zero at first.
   pure subroutine mark_voxel(mask, voxel)
      character(len=:), allocatable, intent(inout) :: mask !! Mask of all voxels
      integer(int64), intent(in) :: voxel                !! From 0, x fastest
      integer(int64) :: letter

      letter = voxel/8 + 1
      mask(letter:letter) = achar(ibset(iachar(mask(letter:letter)), int(mod(voxel, 8_int64))))
   end subroutine mark_voxel

   !> True if a voxel is filled.
   pure logical function marked(self, place) result(yes)
      class(voxels_t), intent(in) :: self
      integer, intent(in) :: place(3)                    !! Voxel, from 0
      integer(int64) :: voxel, letter

      voxel = place(1) + self%extent(1)*(place(2) + int(self%extent(2), int64)*place(3))
      letter = voxel/8 + 1
      yes = btest(iachar(self%mask(letter:letter)), int(mod(voxel, 8_int64)))
   end function marked

   !> True if a point in local coordinates is inside.
   pure logical function voxels_hold(self, own) result(inside)
      class(voxels_t), intent(in) :: self
      real(wp), intent(in) :: own(3)                     !! Local coordinates [m]
      real(wp) :: place(3)

      place = (own - self%corner)/self%edge
      inside = all(place >= 0.0_wp .and. place < real(self%extent, wp))
      if (inside) inside = marked(self, int(place))
   end function voxels_hold

   !> A bounding box of the filled voxels.
   pure subroutine voxels_own_bounds(self, lo, hi)
      class(voxels_t), intent(in) :: self
      real(wp), intent(out) :: lo(3), hi(3)              !! Corners [m]

      lo = self%corner + self%edge*real(self%first, wp)
      hi = self%corner + self%edge*real(self%last + 1, wp)
      if (self%filled > 0) return
      lo = 1.0_wp
      hi = -1.0_wp
   end subroutine voxels_own_bounds
end module particle_voxels
