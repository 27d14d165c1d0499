! SPDX-License-Identifier: BSD-3-Clause
!> Reads voxels from files: a data set of HDF5, or MetaImage, which is a text header with raw bytes.
!!
!! The result is a mask of the voxels with the selected value, one bit per voxel. HDF5 data sets are
!! read in batches of layers.
module io_voxels
   use base_decimal, only: file_number
   use base_error, only: error_t, exit_file, fail
   use base_file, only: folder_of, join_path, read_file
   use base_kinds, only: int64, wp
   use base_text, only: join, lower, number, shortened, split, text_t
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use io_hdf5_read, only: hdf5_source_t
   use, intrinsic :: iso_fortran_env, only: int16, int32, int8, real32, real64
   use particle_voxels, only: mark_voxel
   implicit none
   private

   public :: read_voxels, voxel_file_t

   integer(int64), parameter :: batch = 16777216_int64   !! Voxels read at once, at least a layer
   integer, parameter :: shown = 40                      !! Characters of a wrong line in a message
   integer, parameter :: most_seen = 8                   !! Values listed in a message

   !> Types of voxels of MetaImage and their bytes.
   character(len=10), parameter :: types(10) = [character(len=10) :: "MET_CHAR", "MET_UCHAR", &
      "MET_SHORT", "MET_USHORT", "MET_INT", "MET_UINT", "MET_LONG", "MET_ULONG", "MET_FLOAT", &
      "MET_DOUBLE"]
   integer, parameter :: type_bytes(10) = [1, 1, 2, 2, 4, 4, 4, 4, 4, 8]

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

   !> Header of a MetaImage.
   type :: image_t
      integer :: kind = 0                                !! Index in the list of types
      integer(int64) :: skip = -1 !! Bytes before the voxels, -1: they end the file
      logical :: high_first = .false.                    !! Big-endian?
      character(len=:), allocatable :: data              !! File of the bytes, or LOCAL
      integer(int64) :: data_start = 0                   !! Length of the header
      logical :: sized = .false.                         !! Are the extents known?
      real(wp), allocatable :: middle(:)                 !! Middle of the first voxel, if known
   end type image_t

contains

   !> Read a file and keep the voxels of one value.
   subroutine read_voxels(path, dataset, value, voxels, error)
      character(len=*), intent(in) :: path               !! The file; .mhd and .mha are MetaImage
      character(len=*), intent(in) :: dataset            !! Name of the data set in HDF5
      integer, intent(in) :: value                       !! Selected value
      type(voxel_file_t), intent(out) :: voxels          !! Description of the data in the file
      type(error_t), allocatable, intent(out) :: error   !! Damaged, or without the value
      type(marker_t) :: marker
      character(len=:), allocatable :: ending

      marker%value = value
      ending = lower(path(max(len(path) - 3, 1):))
      if (ending == ".mhd" .or. ending == ".mha") then
         call read_image(path, marker, voxels, error)
      else
         call read_hdf5(path, dataset, marker, voxels, error)
      end if
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

   !> Voxels of a MetaImage.
   subroutine read_image(path, marker, voxels, error)
      character(len=*), intent(in) :: path               !! The file with the text
      type(marker_t), intent(inout) :: marker
      type(voxel_file_t), intent(inout) :: voxels
      type(error_t), allocatable, intent(out) :: error   !! If the file cannot be read
      character(len=:), allocatable :: text
      type(image_t) :: image
      integer(int64) :: bytes, voxel, start

      call read_file(path, text, error)
      if (allocated(error)) return
      call read_header(text, path, image, voxels, error)
      if (allocated(error)) return
      start = image%data_start
      if (image%data /= "LOCAL") then
         start = 0
         if (index(image%data, "/") /= 1) image%data = join_path(folder_of(path), image%data)
         call read_file(image%data, text, error)
         if (allocated(error)) return
      end if
      bytes = type_bytes(image%kind)*product(int(voxels%extent, int64))
      if (image%skip >= 0) start = start + image%skip
      if (image%skip < 0) start = max(start, len(text, kind=int64) - bytes)
      if (len(text, kind=int64) - start < bytes) then
         call fail_reading(error, path, &
            "its voxels need "//number(bytes)//" bytes, but there are "// &
            number(max(len(text, kind=int64) - start, 0_int64))//"; it is truncated")
         return
      end if
      call make_mask(path, voxels, error)
      if (allocated(error)) return
      do voxel = 0, product(int(voxels%extent, int64)) - 1
         call test_voxel(marker, value_at(text, start + voxel*type_bytes(image%kind), image), &
            voxel, &
            voxels%mask)
      end do
   end subroutine read_image

   !> Parse the header of a MetaImage.
   subroutine read_header(text, path, image, voxels, error)
      character(len=*), intent(in) :: text
      character(len=*), intent(in) :: path               !! For messages
      type(image_t), intent(inout) :: image
      type(voxel_file_t), intent(inout) :: voxels        !! Extents, edges, corner
      type(error_t), allocatable, intent(out) :: error   !! A line is wrong, or one is missing
      integer, parameter :: longest = 4095               ! letters of a line
      character(len=:), allocatable :: line
      integer :: row
      integer(int64) :: first, last
      logical :: fits

      image%data = ""
      allocate (image%middle(0))
      first = 1
      row = 0
      fits = .true.
      do while (first <= len(text, kind=int64) .and. image%data == "" .and. fits)
         last = first + index(text(first:min(first + longest, len(text, kind=int64)))// &
            new_line("a"), new_line("a")) - 2
         line = plain(text(first:last))
         first = last + 2
         row = row + 1
         if (line /= "") call read_line(line, image, voxels, fits)
      end do
      image%data_start = first - 1
      if (.not. fits) then
         call fail_reading(error, path, "line "//number(row)//": cannot use '"// &
            shortened(trim(line), shown)//"'; only uncompressed voxels of one number, "// &
            "without rotation, are supported")
      else if (image%kind == 0 .or. .not. image%sized .or. image%data == "") then
         call fail_reading(error, path, "it lacks one of NDims, DimSize, ElementType, "// &
            "ElementDataFile; is it a MetaImage?")
      end if
      if (allocated(error)) return
      call spread_numbers(image%middle, voxels%dimensions, voxels%corner, fits)
      ! positions in the header are middles of voxels
      if (size(image%middle) > 0) voxels%corner = voxels%corner - 0.5_wp*voxels%edge
   end subroutine read_header

   !> Parse one line of the header. Lines that do not describe the shape are skipped.
   subroutine read_line(line, image, voxels, fits)
      character(len=*), intent(in) :: line
      type(image_t), intent(inout) :: image
      type(voxel_file_t), intent(inout) :: voxels        !! Extents, edges
      logical, intent(out) :: fits                       !! Is the line supported?
      character(len=:), allocatable :: value
      real(wp), allocatable :: values(:)
      integer :: equals

      equals = index(line//"=", "=")
      value = trim(adjustl(line(min(equals + 1, len(line) + 1):)))
      fits = value /= ""
      call numbers_of(value, values)
      select case (trim(adjustl(line(:equals - 1))))
      case ("NDims")
         fits = value == "1" .or. value == "2" .or. value == "3"
         if (fits) voxels%dimensions = int(values(1))
      case ("DimSize")
         fits = size(values) == voxels%dimensions .and. all(values >= 1.0_wp .and. &
            values < 2.0e9_wp)
         image%sized = fits
         if (fits) voxels%extent = extent_in_space(nint(values))
      case ("ElementSpacing", "ElementSize")
         fits = size(values) == voxels%dimensions
         if (fits) call spread_numbers(values, voxels%dimensions, voxels%edge, fits)
      case ("Offset", "Origin", "Position")
         image%middle = values
         fits = size(values) == voxels%dimensions
      case ("ElementType")
         image%kind = size(types)
         do while (image%kind > 0)
            if (types(image%kind) == value) exit
            image%kind = image%kind - 1
         end do
         fits = image%kind > 0
      case ("HeaderSize")
         fits = size(values) == 1
         if (fits) image%skip = nint(values(1), int64)
      case ("BinaryDataByteOrderMSB", "ElementByteOrderMSB")
         image%high_first = lower(value) == "true"
      case ("TransformMatrix", "Rotation", "Orientation")
         fits = size(values) == voxels%dimensions**2
         if (fits) fits = all(abs(values - identity(voxels%dimensions)) <= 0.0_wp)
      case ("CompressedData")
         fits = lower(value) == "false"
      case ("ElementNumberOfChannels")
         fits = value == "1"
      case ("ElementDataFile")
         image%data = value
         fits = value /= "LIST"
      case default
         fits = equals <= len(line)
      end select
   end subroutine read_line

   !> The numbers of a line; an empty list if it has anything else.
   subroutine numbers_of(text, values)
      character(len=*), intent(in) :: text               !! Numbers separated by blanks
      real(wp), allocatable, intent(out) :: values(:)
      type(text_t), allocatable :: words(:)
      integer :: n
      logical :: sound

      call split(text, words)
      allocate (values(size(words)))
      values = 0.0_wp
      do n = 1, size(words)
         call file_number(words(n)%text, values(n), sound)
         if (.not. sound) then
            deallocate (values)
            allocate (values(0))
            return
         end if
      end do
   end subroutine numbers_of

   !> Identity matrix by rows: the orientation of a MetaImage that is not rotated.
   pure function identity(dimensions) result(matrix)
      integer, intent(in) :: dimensions                  !! Dimensions of the data
      real(wp) :: matrix(dimensions**2)

      matrix = 0.0_wp
      matrix(1::dimensions + 1) = 1.0_wp
   end function identity

   !> A line without tabs and carriage returns.
   pure function plain(line) result(clean)
      character(len=*), intent(in) :: line               !! Value
      character(len=len(line)) :: clean
      integer :: n

      do n = 1, len(line)
         clean(n:n) = merge(" ", line(n:n), iachar(line(n:n)) < iachar(" "))
      end do
   end function plain

   !> Convert bytes to a number.
   pure real(wp) function value_at(text, before, image) result(value)
      character(len=*), intent(in) :: text               !! Bytes
      integer(int64), intent(in) :: before               !! Bytes before the number
      type(image_t), intent(in) :: image
      character(len=8) :: letters
      integer :: bytes, n

      bytes = type_bytes(image%kind)
      do n = 1, bytes
         associate (from => before + merge(bytes + 1 - n, n, image%high_first))
            letters(n:n) = text(from:from)
         end associate
      end do
      select case (types(image%kind))
      case ("MET_CHAR")
         value = real(transfer(letters(:1), 0_int8), wp)
      case ("MET_UCHAR")
         value = real(iachar(letters(:1)), wp)
      case ("MET_SHORT")
         value = real(transfer(letters(:2), 0_int16), wp)
      case ("MET_USHORT")
         value = real(iand(int(transfer(letters(:2), 0_int16), int32), 65535_int32), wp)
      case ("MET_INT", "MET_LONG")
         value = real(transfer(letters(:4), 0_int32), wp)
      case ("MET_UINT", "MET_ULONG")
         value = real(iand(int(transfer(letters(:4), 0_int32), int64), 4294967295_int64), wp)
      case ("MET_FLOAT")
         value = real(transfer(letters(:4), 0.0_real32), wp)
      case default
         value = real(transfer(letters, 0.0_real64), wp)
      end select
   end function value_at
end module io_voxels
