! SPDX-License-Identifier: BSD-3-Clause
!> Reads voxels from a data set of HDF5, in batches of layers.
!!
!! The result is a mask of the voxels with the selected value, one bit per voxel.
module io_voxels
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: int64, wp
   use base_text, only: join, number, text_t
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use io_hdf5_read, only: hdf5_source_t
   use particle_voxels, only: mark_voxel
   implicit none
   private

   public :: read_voxels, voxel_file_t

   integer(int64), parameter :: batch = 16777216_int64   !! Voxels read at once, at least a layer
   integer, parameter :: most_seen = 8                   !! Values listed in a message

   !> Contents of a file of voxels, lengths in the unit of the file.
   type :: voxel_file_t
      integer :: extent(3) = 1                           !! Voxels along x, y and z
      integer :: dimensions = 3                          !! 2: along x and z; 1: along x
      real(wp) :: edge(3) = 1.0_wp                       !! Edges of a voxel
      real(wp) :: corner(3) = 0.0_wp                     !! Lower corner of the first one
      character(len=:), allocatable :: mask              !! Voxels with the selected value
   end type voxel_file_t

   !> Marks voxels, and lists other values for the message that no voxel has the selected one.
   type :: marker_t
      integer :: value = 1                               !! Selected value
      integer(int64) :: marked = 0                       !! Voxels with this value
      integer(int64) :: seen(most_seen) = 0              !! Other values
      integer :: others = 0                              !! Number of other values
   end type marker_t

contains

   !> Read a file and keep the voxels of one value.
   subroutine read_voxels(path, dataset, value, voxels, error)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: dataset            !! Name of the data set in HDF5
      integer, intent(in) :: value                       !! Selected value
      type(voxel_file_t), intent(out) :: voxels          !! Description of the data in the file
      type(error_t), allocatable, intent(out) :: error   !! Damaged, or without the value
      type(marker_t) :: marker

      marker%value = value
      call read_hdf5(path, dataset, marker, voxels, error)
      if (allocated(error)) return
      if (.not. all(ieee_is_finite(voxels%edge)) .or. .not. all(ieee_is_finite(voxels%corner))) then
         call fail_reading(error, path, "its spacing or origin is not a number")
      else if (.not. all(voxels%edge > 0.0_wp)) then
         call fail_reading(error, path, "the edges of a voxel must be above 0")
      else if (marker%marked == 0) then
         call fail_reading(error, path, "no voxel has the value "//number(value)//"; there are "// &
            values_text(marker))
      end if
   end subroutine read_voxels

   !> Make the error message on a file.
   subroutine fail_reading(error, path, what)
      type(error_t), allocatable, intent(out) :: error
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: what               !! Error message

      call fail(error, exit_file, "cannot read the voxels of '"//path//"': "//what//" [F114]")
   end subroutine fail_reading

   !> List of the other values, for a message.
   function values_text(marker) result(text)
      type(marker_t), intent(in) :: marker
      character(len=:), allocatable :: text
      type(text_t) :: words(most_seen)
      integer :: n

      do n = 1, marker%others
         words(n)%text = number(marker%seen(n))
      end do
      text = join(words(:marker%others), ", ")
      if (marker%others == most_seen) text = text//", ..."
      if (marker%others == 0) text = "only values that are not finite"
   end function values_text

   !> Expand values of a file to x, y, z: one for all directions, one per direction of the data, or
   !! three.
   subroutine spread_numbers(given, dimensions, values, fits)
      real(wp), intent(in) :: given(:)                   !! As in the file
      integer, intent(in) :: dimensions                  !! Dimensions of the data
      real(wp), intent(inout) :: values(3)               !! Along x, y, z
      logical, intent(out) :: fits                       !! The number is sufficient

      fits = .true.
      if (size(given) == 0) return
      if (size(given) == 3) then
         values = given
      else if (size(given) == 2 .and. dimensions == 2) then
         values(1) = given(1)
         values(3) = given(2)
      else
         fits = size(given) == 1
         if (fits) values = given(1)
      end if
   end subroutine spread_numbers

   !> Voxels along x, y and z: data of two directions are in the plane of x and z.
   pure function extent_in_space(extent) result(whole)
      integer, intent(in) :: extent(:)                   !! The fastest first
      integer :: whole(3)

      whole = 1
      whole(1) = extent(1)
      if (size(extent) == 2) whole(3) = extent(2)
      if (size(extent) == 3) whole = extent
   end function extent_in_space

   !> An empty mask for all voxels. A damaged file may have any extents.
   subroutine make_mask(path, voxels, error)
      character(len=*), intent(in) :: path
      type(voxel_file_t), intent(inout) :: voxels        !! Extents are known
      type(error_t), allocatable, intent(out) :: error   !! Too many voxels
      integer(int64) :: letters
      integer :: status

      letters = (product(int(voxels%extent, int64)) + 7)/8
      allocate (character(len=letters) :: voxels%mask, stat=status)
      if (status /= 0) then
         call fail_reading(error, path, "there is no memory for "//number(8*letters)// &
            " voxels; is the file damaged?")
         return
      end if
      voxels%mask(:) = repeat(achar(0), len(voxels%mask))
   end subroutine make_mask

   !> Mark a voxel if it has the selected value. Reals are rounded to the nearest integer.
   pure subroutine test_voxel(marker, value, voxel, mask)
      type(marker_t), intent(inout) :: marker
      real(wp), intent(in) :: value                      !! Value of the voxel
      integer(int64), intent(in) :: voxel                !! Number of the voxel, from 0
      character(len=:), allocatable, intent(inout) :: mask !! Mask of all voxels
      real(wp), parameter :: most = 9.0e18_wp            ! integers end there

      if (.not. ieee_is_finite(value)) return
      if (abs(value - real(marker%value, wp)) < 0.5_wp) then
         marker%marked = marker%marked + 1
         call mark_voxel(mask, voxel)
      else if (marker%marked == 0 .and. marker%others < most_seen .and. abs(value) < most) then
         if (any(marker%seen(:marker%others) == nint(value, int64))) return
         marker%others = marker%others + 1
         marker%seen(marker%others) = nint(value, int64)
      end if
   end subroutine test_voxel

   !> Voxels of a data set.
   subroutine read_hdf5(path, dataset, marker, voxels, error)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: dataset            !! Name of the data set
      type(marker_t), intent(inout) :: marker
      type(voxel_file_t), intent(inout) :: voxels
      type(error_t), allocatable, intent(out) :: error   !! If the file cannot be read
      type(hdf5_source_t) :: source
      integer, allocatable :: extent(:)
      real(wp), allocatable :: edge(:), corner(:)
      logical :: fit(2)

      call source%open(path, error)
      if (allocated(error)) return
      call source%extents(dataset, extent, error)
      if (.not. allocated(error)) call source%list(dataset, "spacing", edge, error)
      if (.not. allocated(error)) call source%list(dataset, "origin", corner, error)
      if (.not. allocated(error)) then
         voxels%dimensions = size(extent)
         voxels%extent = extent_in_space(extent)
         call spread_numbers(edge, size(extent), voxels%edge, fit(1))
         call spread_numbers(corner, size(extent), voxels%corner, fit(2))
         if (any(extent < 1)) then
            call fail_reading(error, path, "it holds no voxel")
         else if (.not. all(fit)) then
            call fail_reading(error, path, "the attributes spacing and origin of '"//dataset// &
               "' must have one number or one a direction")
         else
            call make_mask(path, voxels, error)
            if (.not. allocated(error)) &
               call read_layers(source, dataset, extent, marker, voxels%mask, error)
         end if
      end if
      call source%close()
   end subroutine read_hdf5

   !> Read a data set in batches of layers.
   subroutine read_layers(source, dataset, extent, marker, mask, error)
      type(hdf5_source_t), intent(in) :: source          !! The open file
      character(len=*), intent(in) :: dataset            !! Name of the data set
      integer, intent(in) :: extent(:) !! Extents of the data, the fastest index first
      type(marker_t), intent(inout) :: marker
      character(len=:), allocatable, intent(inout) :: mask !! Mask of all voxels
      type(error_t), allocatable, intent(out) :: error   !! If the file cannot be read
      real(wp), allocatable :: values(:)
      integer :: wanted(size(extent)), layers, before, n
      integer(int64) :: layer

      layers = extent(size(extent))
      layer = product(int(extent, int64))/layers
      do before = 0, layers - 1, int(max(batch/layer, 1_int64))
         wanted = extent
         wanted(size(extent)) = min(int(max(batch/layer, 1_int64)), layers - before)
         if (allocated(values)) deallocate (values)
         allocate (values(product(wanted)))
         call source%layers(dataset, before, wanted, values, error)
         if (allocated(error)) return
         do n = 1, size(values)
            call test_voxel(marker, values(n), layer*before + n - 1, mask)
         end do
      end do
   end subroutine read_layers
end module io_voxels
