! SPDX-License-Identifier: BSD-3-Clause
!> Writes data sets of HDF5 files collectively; each rank writes its own rows.
module io_hdf5_write
   use base_communicator, only: communicator_t
   use base_kinds, only: int32, int64, wp
   use base_libc, only: clear_failure
   use hdf5, only: h5d_alloc_time_early_f, h5d_fill_time_never_f, h5dclose_f, h5dcreate_f, &
      h5dwrite_f, h5p_dataset_create_f, h5p_dataset_xfer_f, h5pclose_f, &
      h5pcreate_f, h5pset_alloc_time_f, h5pset_chunk_f, h5pset_deflate_f, &
      h5pset_fill_time_f, h5pset_obj_track_times_f, h5pset_shuffle_f, h5s_select_or_f, &
      h5s_select_set_f, h5sclose_f, h5screate_simple_f, h5sselect_hyperslab_f, h5sselect_none_f, &
      h5t_ieee_f32le, h5t_ieee_f64le, h5t_std_i32le, h5t_std_i64le, h5t_std_u8le, h5tclose_f, &
      hid_t, hsize_t
   use io_hdf5, only: hdf5_file_t, text_type
   use io_hdf5_chunks, only: write_chunks
   use io_hdf5_ranks, only: write_on_all_ranks
   use, intrinsic :: iso_c_binding, only: c_loc, c_null_ptr, c_ptr
   use, intrinsic :: iso_fortran_env, only: real32
   implicit none
   private

   public :: data_bytes, even_rows, rows_of_root, rows_t, write_bytes, write_data, write_names, &
      write_planes

   integer(int64), parameter, public :: chunk_rows = 65536 !! Rows that are compressed together
   integer, parameter :: plain(0) = 0                    !! Extents of a row that is a scalar

   !> The rows of a data set and the ranges of rows of this rank.
   type :: rows_t
      integer(int64) :: total = 0                        !! Rows on all ranks
      integer(int64), allocatable :: before(:)           !! (range) Rows before it in the file
      integer(int64), allocatable :: count(:)            !! (range) Its rows, in file order
      integer :: compress = 0                            !! gzip level, 0: contiguous, uncompressed
      integer(int64) :: chunk = chunk_rows               !! Rows that are compressed together
   end type rows_t

   !> Write a data set: scalars (row) or vectors and tensors (component, row). Collective.
   interface write_data
      module procedure write_reals, write_vectors, write_singles, write_single_vectors
      module procedure write_integers, write_whole_vectors, write_shorts
   end interface write_data

   !> Write a data set of more dimensions: (all of a row, row). Collective.
   interface write_planes
      module procedure write_real_planes, write_single_planes
   end interface write_planes

contains

   !> Rows that are all on rank 0.
   pure function rows_of_root(communicator, total) result(rows)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: total                       !! Rows
      type(rows_t) :: rows

      rows%total = total
      allocate (rows%before(1), rows%count(1))
      rows%before = 0
      rows%count = 0
      if (communicator%rank == 0) rows%count = total
   end function rows_of_root

   !> Rows distributed evenly over the ranks.
   pure function even_rows(communicator, total) result(rows)
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(in) :: total                !! Rows
      type(rows_t) :: rows
      integer(int64) :: least, rank, spare

      least = total/communicator%size
      spare = mod(total, int(communicator%size, int64))
      rank = communicator%rank
      rows%total = total
      allocate (rows%before(1), rows%count(1))
      rows%before = rank*least + min(rank, spare)
      rows%count = least
      if (rank < spare) rows%count = least + 1
   end function even_rows

   !> Upper bound of the length of a data set in a file, with its header [byte].
   pure function data_bytes(rows, bytes_per_row) result(bytes)
      type(rows_t), intent(in) :: rows                   !! Rows and compression
      integer(int64), intent(in) :: bytes_per_row        !! Bytes of a row before compression
      integer(int64) :: bytes
      ! a chunk first occupies the space of compressed zeros, which is not reused
      integer(int64), parameter :: heading = 8192, chunk_heading = 1024, zeros_ratio = 200
      integer(int64) :: chunks, length

      bytes = rows%total*bytes_per_row + heading
      if (rows%compress == 0 .or. rows%total == 0) return
      length = min(rows%total, rows%chunk)
      chunks = (rows%total + length - 1)/length
      bytes = chunks*(length*bytes_per_row*(zeros_ratio + 1)/zeros_ratio + chunk_heading) + heading
   end function data_bytes

   !> Write one data set of any type. Collective.
   subroutine write_any(file, name, rows, inner, kind, address)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      integer, intent(in) :: inner(:)                    !! Extents of a row; empty: a scalar
      integer(hid_t), intent(in) :: kind                 !! Type in memory and file
      type(c_ptr), intent(in) :: address
      integer(hid_t) :: data_set, plan, space
      integer(hsize_t) :: extent(size(inner) + 1)
      integer :: ignored, status

      if (.not. file%works()) return
      extent(:size(inner)) = inner
      extent(size(extent)) = rows%total
      call h5screate_simple_f(size(extent), extent, space, status)
      call creation_plan(rows, extent, plan)
      call h5dcreate_f(file%id, name, kind, space, data_set, status, dcpl_id=plan)
      call h5pclose_f(plan, ignored)
      call file%share_status("cannot write", name, status)
      if (file%works() .and. rows%total > 0) then
         if (rows%compress > 0 .and. file%communicator%size == 1) then
            call clear_failure()
            call write_chunks(data_set, kind, extent, min(rows%total, rows%chunk), &
               rows%compress, address, status)
         else
            call write_ranges(file, data_set, space, rows, extent, kind, address, status)
         end if
         call file%share_status("cannot write", name, status)
      end if
      if (data_set >= 0) call h5dclose_f(data_set, ignored)
      call h5sclose_f(space, ignored)
   end subroutine write_any

   !> Make the creation property list of a data set: no time stamps, space allocated early.
   subroutine creation_plan(rows, extent, plan)
      type(rows_t), intent(in) :: rows                   !! Rows and compression
      integer(hsize_t), intent(in) :: extent(:)          !! Components (if any) and rows
      integer(hid_t), intent(out) :: plan                !! Property list; the caller closes it
      integer(hsize_t) :: chunk(size(extent))
      integer :: status

      call h5pcreate_f(h5p_dataset_create_f, plan, status)
      call h5pset_obj_track_times_f(plan, .false., status)
      call h5pset_alloc_time_f(plan, h5d_alloc_time_early_f, status)
      call h5pset_fill_time_f(plan, h5d_fill_time_never_f, status)
      if (rows%compress == 0 .or. rows%total == 0) return
      chunk = extent
      chunk(size(chunk)) = min(rows%total, rows%chunk)
      call h5pset_chunk_f(plan, size(chunk), chunk, status)
      call h5pset_shuffle_f(plan, status)
      call h5pset_deflate_f(plan, rows%compress, status)
   end subroutine creation_plan

   !> Write the rows of this rank. Collective.
   subroutine write_ranges(file, data_set, space, rows, extent, kind, address, status)
      class(hdf5_file_t), intent(in) :: file
      integer(hid_t), intent(in) :: data_set             !! The open data set
      integer(hid_t), intent(in) :: space                !! Data space of the attribute or data set
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      integer(hsize_t), intent(in) :: extent(:)          !! Components (if any) and rows
      integer(hid_t), intent(in) :: kind                 !! Type in memory and file
      type(c_ptr), intent(in) :: address
      integer, intent(out) :: status                     !! Status of the library
      integer(hid_t) :: memory, transfer_list
      integer(hsize_t) :: count(size(extent)), start(size(extent))
      integer :: ignored, operation, piece

      call h5sselect_none_f(space, status)
      operation = h5s_select_set_f
      count = extent
      start = 0
      do piece = 1, size(rows%count)
         if (rows%count(piece) == 0) cycle
         start(size(start)) = rows%before(piece)
         count(size(count)) = rows%count(piece)
         call h5sselect_hyperslab_f(space, operation, start, count, status)
         operation = h5s_select_or_f
      end do
      count(size(count)) = max(sum(rows%count), 1_int64)
      call h5screate_simple_f(size(count), count, memory, status)
      if (sum(rows%count) == 0) call h5sselect_none_f(memory, status)
      call h5pcreate_f(h5p_dataset_xfer_f, transfer_list, status)
      call write_on_all_ranks(file%communicator, transfer_list)
      call clear_failure()
      call h5dwrite_f(data_set, kind, address, status, mem_space_id=memory, file_space_id=space, &
         xfer_prp=transfer_list)
      call h5pclose_f(transfer_list, ignored)
      call h5sclose_f(memory, ignored)
   end subroutine write_ranges

   !> Write reals.
   subroutine write_reals(file, name, rows, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      real(wp), contiguous, target, intent(in) :: values(:) !! (row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, plain, h5t_ieee_f64le, address)
   end subroutine write_reals

   !> Write vectors or tensors of reals.
   subroutine write_vectors(file, name, rows, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      real(wp), contiguous, target, intent(in) :: values(:, :) !! (component, row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, [size(values, 1)], h5t_ieee_f64le, address)
   end subroutine write_vectors

   !> Write reals in single precision.
   subroutine write_singles(file, name, rows, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      real(real32), contiguous, target, intent(in) :: values(:) !! (row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, plain, h5t_ieee_f32le, address)
   end subroutine write_singles

   !> Write vectors or tensors in single precision.
   subroutine write_single_vectors(file, name, rows, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      real(real32), contiguous, target, intent(in) :: values(:, :) !! (component, row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, [size(values, 1)], h5t_ieee_f32le, address)
   end subroutine write_single_vectors

   !> Write integers.
   subroutine write_integers(file, name, rows, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      integer(int64), contiguous, target, intent(in) :: values(:) !! (row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, plain, h5t_std_i64le, address)
   end subroutine write_integers

   !> Write vectors of integers.
   subroutine write_whole_vectors(file, name, rows, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      integer(int64), contiguous, target, intent(in) :: values(:, :) !! (component, row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, [size(values, 1)], h5t_std_i64le, address)
   end subroutine write_whole_vectors

   !> Write 32-bit integers.
   subroutine write_shorts(file, name, rows, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      integer(int32), contiguous, target, intent(in) :: values(:) !! (row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, plain, h5t_std_i32le, address)
   end subroutine write_shorts

   !> Write rows of several dimensions.
   subroutine write_real_planes(file, name, rows, inner, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      integer, intent(in) :: inner(:)                    !! Extents of a row, the fastest first
      real(wp), contiguous, target, intent(in) :: values(:, :) !! (all of a row, row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, inner, h5t_ieee_f64le, address)
   end subroutine write_real_planes

   !> Write rows of several dimensions in single precision.
   subroutine write_single_planes(file, name, rows, inner, values)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      integer, intent(in) :: inner(:)                    !! Extents of a row, the fastest first
      real(real32), contiguous, target, intent(in) :: values(:, :) !! (all of a row, row)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values)
      call write_any(file, name, rows, inner, h5t_ieee_f32le, address)
   end subroutine write_single_planes

   !> Write bytes, given as characters. Collective.
   subroutine write_bytes(file, name, rows, letters)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Bytes of this rank
      character(len=*), intent(in) :: letters            !! Their values
      character(len=:), allocatable, target :: copy

      copy = letters//" "
      call write_any(file, name, rows, plain, h5t_std_u8le, c_loc(copy(1:1)))
   end subroutine write_bytes

   !> Write a table of texts, the same on all ranks. Collective.
   subroutine write_names(file, name, names)
      class(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      character(len=*), intent(in) :: names(:)           !! The same on all ranks
      character(len=:), allocatable, target :: joined
      integer(hid_t) :: kind
      integer :: index, status

      if (.not. file%works()) return
      joined = ""
      do index = 1, size(names)
         joined = joined//names(index)
      end do
      joined = joined//" "
      call text_type(len(names), kind)
      call write_any(file, name, rows_of_root(file%communicator, size(names)), plain, kind, &
         c_loc(joined(1:1)))
      call h5tclose_f(kind, status)
   end subroutine write_names
end module io_hdf5_write
