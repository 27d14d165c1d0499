! SPDX-License-Identifier: BSD-3-Clause
!> Reads HDF5 files. Every rank reads independently; no procedure is collective.
module io_hdf5_read
   use base_error, only: error_t, exit_file, fail
   use base_file, only: file_exists
   use base_kinds, only: int64, wp
   use base_libc, only: failure_text
   use hdf5, only: h5aclose_f, h5aexists_by_name_f, h5aget_space_f, h5aopen_by_name_f, h5aread_f, &
      h5dclose_f, h5dget_space_f, h5dget_type_f, h5dopen_f, h5dread_f, h5f_acc_rdonly_f, &
      h5fclose_f, h5fopen_f, h5g_dataset_f, h5gget_obj_info_idx_f, h5gn_members_f, h5lexists_f, &
      h5s_select_set_f, h5sclose_f, h5screate_simple_f, &
      h5sget_simple_extent_dims_f, h5sget_simple_extent_ndims_f, h5sget_simple_extent_npoints_f, &
      h5sselect_hyperslab_f, h5t_float_f, h5t_integer_f, h5t_native_double, h5t_std_i64le, &
      h5t_std_u8le, h5tclose_f, h5tget_class_f, h5tget_size_f, hid_t, hsize_t, size_t
   use io_hdf5, only: start_library
   use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
   implicit none
   private

   public :: data_info_t, hdf5_source_t

   integer, parameter :: name_length = 64                !! Longest name of a data set

   !> Description of a data set.
   type :: data_info_t
      character(len=name_length) :: name = ""            !! Name in its group
      logical :: is_data = .false.                       !! A data set, not a group
      logical :: is_real = .false.                       !! Real, not integer
      integer :: bytes = 0                               !! Bytes of a value
      integer :: components = 1                          !! Values of a row
      integer :: dimensions = 0                          !! 1: scalars, 2: vectors or tensors
      integer(int64) :: rows = 0                         !! Number of rows
   end type data_info_t

   !> An HDF5 file that is open for reading.
   type :: hdf5_source_t
      character(len=:), allocatable :: path
      integer(hid_t) :: id = -1                          !! The open file
   contains
      procedure :: open => source_open                   !! Open
      procedure :: close => source_close                 !! Close
      procedure :: has => source_has                     !! Is there an object of this name?
      procedure :: info => source_info                   !! Describe a data set
      procedure :: members => source_members             !! List the members of a group
      procedure :: text => source_text                   !! Read bytes of a data set as text
      procedure :: extents => source_extents             !! Extents of a data set
      procedure :: layers => source_layers               !! Read layers of a data set
      procedure :: list => source_list                   !! Read the values of an attribute
      procedure :: names => source_names                 !! Read the texts of a data set
      procedure, private :: source_real, source_integer, source_reals, source_vectors, &
         source_integers
      !> Read an attribute.
      generic :: attribute => source_real, source_integer
      !> Read rows of a data set.
      generic :: read => source_reals, source_vectors, source_integers
   end type hdf5_source_t

contains

   !> Open a file.
   subroutine source_open(self, path, error)
      class(hdf5_source_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      type(error_t), allocatable, intent(out) :: error   !! Missing, unreadable, cut short
      integer :: status

      self%path = path
      self%id = -1
      if (.not. file_exists(path)) then
         call fail(error, exit_file, "cannot read '"//path//"': "//failure_text()//" [F106]")
         return
      end if
      call start_library(status)
      call h5fopen_f(path, h5f_acc_rdonly_f, self%id, status)
      if (status >= 0) return
      self%id = -1
      call fail(error, exit_file, "cannot read '"//path//"': not an HDF5 file, or truncated [F122]")
   end subroutine source_open

   !> Close the file, if it is open.
   subroutine source_close(self)
      class(hdf5_source_t), intent(inout) :: self
      integer :: status

      if (self%id < 0) return
      call h5fclose_f(self%id, status)
      self%id = -1
   end subroutine source_close

   !> Allocate an error about something in the file.
   subroutine fail_at(self, name, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Object in the file
      type(error_t), allocatable, intent(out) :: error

      call fail(error, exit_file, "'"//self%path//"' is damaged: cannot read '"//name//"' [F108]")
   end subroutine fail_at

   !> True if there is an object of this name; the groups above it must exist.
   logical function source_has(self, name) result(there)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer :: status

      call h5lexists_f(self%id, name, there, status)
      if (status < 0) there = .false.
   end function source_has

   !> Description of a data set.
   subroutine source_info(self, name, info, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      type(data_info_t), intent(out) :: info             !! Description for messages
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer(hid_t) :: data_set, kind, space
      integer(hsize_t) :: extent(2), most(2)
      integer(size_t) :: bytes
      integer :: class, ignored, status

      call h5dopen_f(self%id, name, data_set, status)
      if (status < 0) then
         call fail_at(self, name, error)
         return
      end if
      call h5dget_space_f(data_set, space, status)
      call h5sget_simple_extent_ndims_f(space, info%dimensions, status)
      if (info%dimensions == 1 .or. info%dimensions == 2) then
         call h5sget_simple_extent_dims_f(space, extent(:info%dimensions), &
            most(:info%dimensions), status)
         info%rows = extent(info%dimensions)
         if (info%dimensions == 2) info%components = int(extent(1))
         call h5dget_type_f(data_set, kind, status)
         call h5tget_class_f(kind, class, status)
         call h5tget_size_f(kind, bytes, status)
         info%is_data = .true.
         info%is_real = class == h5t_float_f
         info%bytes = int(bytes)
         info%name = name(index(name, "/", back=.true.) + 1:)
         call h5tclose_f(kind, ignored)
      end if
      call h5sclose_f(space, ignored)
      call h5dclose_f(data_set, ignored)
      if (status < 0 .or. .not. info%is_data) call fail_at(self, name, error)
   end subroutine source_info

   !> List the members of a group in alphabetical order.
   subroutine source_members(self, group, members, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: group              !! Path from the root
      type(data_info_t), allocatable, intent(out) :: members(:) !! Data sets and groups
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      character(len=name_length) :: name
      integer :: count, index, kind, status

      call h5gn_members_f(self%id, group, count, status)
      if (status < 0) then
         call fail_at(self, group, error)
         return
      end if
      allocate (members(count))
      do index = 1, count
         call h5gget_obj_info_idx_f(self%id, group, index - 1, name, kind, status)
         if (status < 0) then
            call fail_at(self, group, error)
            return
         end if
         if (kind == h5g_dataset_f) then
            call self%info(group//"/"//trim(name), members(index), error)
            if (allocated(error)) return
         end if
         members(index)%name = name
      end do
   end subroutine source_members

   !> Read an attribute of any type.
   subroutine read_attribute(self, object, name, kind, address, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: object             !! Group or data set, from the root
      character(len=*), intent(in) :: name               !! Name of the attribute
      integer(hid_t), intent(in) :: kind                 !! Type in memory
      type(c_ptr), intent(in) :: address                 !! Destination
      type(error_t), allocatable, intent(out) :: error   !! Missing or unreadable
      integer(hid_t) :: attribute
      integer :: ignored, status
      logical :: there
      type(c_ptr) :: buffer

      buffer = address
      call h5aexists_by_name_f(self%id, object, name, there, status)
      if (status < 0) there = .false.
      if (there) then
         call h5aopen_by_name_f(self%id, object, name, attribute, status)
         if (status >= 0) then
            call h5aread_f(attribute, kind, buffer, status)
            call h5aclose_f(attribute, ignored)
         end if
         there = status >= 0
      end if
      if (.not. there) call fail_at(self, object//" attribute "//name, error)
   end subroutine read_attribute

   !> Read a real attribute.
   subroutine source_real(self, object, name, value, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: object             !! Group or data set, from the root
      character(len=*), intent(in) :: name               !! Name of the attribute
      real(wp), intent(out) :: value                     !! Value
      type(error_t), allocatable, intent(out) :: error   !! Missing or unreadable
      real(wp), target :: copy

      copy = 0.0_wp
      call read_attribute(self, object, name, h5t_native_double, c_loc(copy), error)
      value = copy
   end subroutine source_real

   !> Read an integer attribute.
   subroutine source_integer(self, object, name, value, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: object             !! Group or data set, from the root
      character(len=*), intent(in) :: name               !! Name of the attribute
      integer(int64), intent(out) :: value               !! Value
      type(error_t), allocatable, intent(out) :: error   !! Missing or unreadable
      integer(int64), target :: copy

      copy = 0
      call read_attribute(self, object, name, h5t_std_i64le, c_loc(copy), error)
      value = copy
   end subroutine source_integer

   !> Read rows of a data set of any type. The data set must have the requested rows.
   subroutine read_any(self, name, before, extent, kind, address, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer(int64), intent(in) :: before               !! Rows before the first requested
      integer, intent(in) :: extent(:)                   !! Components (if any) and rows
      integer(hid_t), intent(in) :: kind                 !! Type in memory
      type(c_ptr), intent(in) :: address                 !! Destination
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer(hid_t) :: data_set, memory, space
      integer(hsize_t) :: count(size(extent)), start(size(extent))
      integer :: ignored, status
      type(c_ptr) :: buffer

      buffer = address
      count = extent
      start = 0
      start(size(start)) = before
      call h5dopen_f(self%id, name, data_set, status)
      if (status >= 0 .and. .not. has_sound_type(data_set)) then
         status = -1
         call h5dclose_f(data_set, ignored)
      end if
      if (status < 0) then
         call fail_at(self, name, error)
         return
      end if
      call h5dget_space_f(data_set, space, status)
      call h5sselect_hyperslab_f(space, h5s_select_set_f, start, count, status)
      call h5screate_simple_f(size(count), count, memory, status)
      call h5dread_f(data_set, kind, buffer, status, mem_space_id=memory, file_space_id=space)
      call h5sclose_f(memory, ignored)
      call h5sclose_f(space, ignored)
      call h5dclose_f(data_set, ignored)
      if (status < 0) call fail_at(self, name, error)
   end subroutine read_any

   !> False for numbers of more bytes than any processor has. HDF5 1.10 does not refuse such a type
   !! of a damaged file, and reads beyond its own buffers.
   logical function has_sound_type(data_set) result(sound)
      integer(hid_t), intent(in) :: data_set             !! An open data set
      integer(size_t), parameter :: most_bytes = 16_size_t ! of a number
      integer(hid_t) :: kind
      integer(size_t) :: bytes
      integer :: class, ignored, status

      call h5dget_type_f(data_set, kind, status)
      sound = status >= 0
      if (.not. sound) return
      call h5tget_class_f(kind, class, status)
      call h5tget_size_f(kind, bytes, status)
      if (class == h5t_integer_f .or. class == h5t_float_f) sound = bytes <= most_bytes
      call h5tclose_f(kind, ignored)
   end function has_sound_type

   !> Check the form of a data set, so that reading cannot overrun it.
   subroutine check_form(self, name, dimensions, components, last_row, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer, intent(in) :: dimensions                  !! 1: scalars, 2: vectors or tensors
      integer, intent(in) :: components                  !! Number of components of a row
      integer(int64), intent(in) :: last_row             !! Least number of rows
      type(error_t), allocatable, intent(out) :: error   !! The form is another
      type(data_info_t) :: info

      call self%info(name, info, error)
      if (allocated(error)) return
      if (info%dimensions /= dimensions .or. info%components /= components .or. &
         info%rows < last_row) call fail_at(self, name, error)
   end subroutine check_form

   !> Read reals.
   subroutine source_reals(self, name, before, values, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer(int64), intent(in) :: before               !! Rows before the first requested
      real(wp), contiguous, target, intent(out) :: values(:) !! (row)
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer :: extent(1)

      call check_form(self, name, 1, 1, before + size(values), error)
      if (size(values) == 0 .or. allocated(error)) return
      extent(1) = size(values, 1)
      call read_any(self, name, before, extent, h5t_native_double, c_loc(values), error)
   end subroutine source_reals

   !> Read vectors or tensors.
   subroutine source_vectors(self, name, before, values, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer(int64), intent(in) :: before               !! Rows before the first requested
      real(wp), contiguous, target, intent(out) :: values(:, :) !! (component, row)
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer :: extent(2)

      call check_form(self, name, 2, size(values, 1), before + size(values, 2), error)
      if (size(values) == 0 .or. allocated(error)) return
      extent(1) = size(values, 1)
      extent(2) = size(values, 2)
      call read_any(self, name, before, extent, h5t_native_double, c_loc(values), error)
   end subroutine source_vectors

   !> Read integers.
   subroutine source_integers(self, name, before, values, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer(int64), intent(in) :: before               !! Rows before the first requested
      integer(int64), contiguous, target, intent(out) :: values(:) !! (row)
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer :: extent(1)

      call check_form(self, name, 1, 1, before + size(values), error)
      if (size(values) == 0 .or. allocated(error)) return
      extent(1) = size(values, 1)
      call read_any(self, name, before, extent, h5t_std_i64le, c_loc(values), error)
   end subroutine source_integers

   !> Read the bytes of a data set as a text.
   subroutine source_text(self, name, text, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      character(len=:), allocatable, intent(out), target :: text
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      type(data_info_t) :: info
      integer :: extent(1)

      text = ""
      call self%info(name, info, error)
      if (allocated(error) .or. info%rows == 0) return
      deallocate (text)
      allocate (character(len=info%rows) :: text)
      extent = len(text)
      call read_any(self, name, 0_int64, extent, h5t_std_u8le, c_loc(text(1:1)), error)
   end subroutine source_text

   !> Extents of a data set of one to three dimensions, the fastest first.
   subroutine source_extents(self, name, extent, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer, allocatable, intent(out) :: extent(:)     !! (direction)
      type(error_t), allocatable, intent(out) :: error   !! No such data set, or of another form
      integer(hid_t) :: data_set, space
      integer(hsize_t) :: numbers(3), most(3)
      integer :: dimensions, ignored, status

      call h5dopen_f(self%id, name, data_set, status)
      if (status < 0) then
         call fail(error, exit_file, "'"//self%path//"' has no data set '"//name//"' [F124]")
         return
      end if
      call h5dget_space_f(data_set, space, status)
      call h5sget_simple_extent_ndims_f(space, dimensions, status)
      if (dimensions >= 1 .and. dimensions <= 3) then
         call h5sget_simple_extent_dims_f(space, numbers(:dimensions), most(:dimensions), status)
         extent = int(numbers(:dimensions))
      end if
      call h5sclose_f(space, ignored)
      call h5dclose_f(data_set, ignored)
      if (.not. allocated(extent)) call fail(error, exit_file, "'"//name//"' of '"//self%path// &
         "' must have one to three dimensions [F124]")
   end subroutine source_extents

   !> Read layers of a data set along its slowest direction.
   subroutine source_layers(self, name, before, extent, values, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer, intent(in) :: before                      !! Layers before the first requested
      integer, intent(in) :: extent(:)                   !! Requested extents, the fastest first
      real(wp), contiguous, target, intent(out) :: values(:) !! Values, fastest direction first
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read

      call read_any(self, name, int(before, int64), extent, h5t_native_double, c_loc(values), &
         error)
   end subroutine source_layers

   !> Read an attribute with one or more values; an empty list if there is no such attribute.
   subroutine source_list(self, object, name, values, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: object             !! Group or data set, from the root
      character(len=*), intent(in) :: name               !! Name of the attribute
      real(wp), allocatable, intent(out) :: values(:)    !! Values
      type(error_t), allocatable, intent(out) :: error   !! If it exists and cannot be read
      real(wp), allocatable, target :: copy(:)
      integer(hid_t) :: attribute, space
      integer(hsize_t) :: numbers
      integer :: ignored, status
      logical :: there

      allocate (values(0))
      call h5aexists_by_name_f(self%id, object, name, there, status)
      if (status < 0 .or. .not. there) return
      numbers = 0
      call h5aopen_by_name_f(self%id, object, name, attribute, status)
      if (status >= 0) then
         call h5aget_space_f(attribute, space, status)
         call h5sget_simple_extent_npoints_f(space, numbers, status)
         call h5sclose_f(space, ignored)
         call h5aclose_f(attribute, ignored)
      end if
      if (numbers < 1) then
         call fail_at(self, object//" attribute "//name, error)
         return
      end if
      allocate (copy(numbers))
      copy = 0.0_wp
      call read_attribute(self, object, name, h5t_native_double, c_loc(copy), error)
      values = copy
   end subroutine source_list

   !> Read the texts of a data set, all of one length, concatenated.
   subroutine source_names(self, name, length, names, error)
      class(hdf5_source_t), intent(in) :: self
      character(len=*), intent(in) :: name               !! Path from the root
      integer, intent(out) :: length                     !! Length of a text
      character(len=:), allocatable, intent(out), target :: names !! Concatenated
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      type(data_info_t) :: info
      integer(hid_t) :: data_set, kind
      integer :: extent(1), ignored, status

      names = ""
      call self%info(name, info, error)
      length = info%bytes
      if (allocated(error) .or. info%rows == 0) return
      names = repeat(" ", length*int(info%rows))
      call h5dopen_f(self%id, name, data_set, status)
      call h5dget_type_f(data_set, kind, status)
      extent = int(info%rows)
      call read_any(self, name, 0_int64, extent, kind, c_loc(names(1:1)), error)
      call h5tclose_f(kind, ignored)
      call h5dclose_f(data_set, ignored)
   end subroutine source_names
end module io_hdf5_read
