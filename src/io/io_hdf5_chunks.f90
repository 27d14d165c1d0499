! SPDX-License-Identifier: BSD-3-Clause
!> Compresses the chunks of a data set in threads and writes them to an HDF5 file.
!!
!! HDF5 compresses one chunk after another in one thread. Here the same filters, shuffle and gzip,
!! are applied by all threads, and the library only stores the result, so a file has the bytes that
!! the library would write. For one rank: HDF5 1.10 stores filtered chunks of several ranks only
!! through its own filters.
! allow(C071): the offset of a chunk has as many numbers as the data set has dimensions
module io_hdf5_chunks
   use base_kinds, only: int32, int64
   use hdf5, only: h5tget_size_f, hid_t, hsize_t, size_t
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_int, c_int32_t, c_int64_t, c_loc, &
      c_long, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8
   use omp_lib, only: omp_get_max_threads
   implicit none
   private

   public :: write_chunks

   integer, parameter :: share = 2                       !! Chunks of a thread between two writes
   integer(c_int64_t), parameter :: no_list = 0          !! H5P_DEFAULT

   interface
      !> C function that has no Fortran interface in HDF5 1.10.
      function c_write_chunk(data_set, transfer_list, skipped, offset, bytes, buffer) &
         bind(c, name="H5Dwrite_chunk") result(status)
         import :: c_int, c_int32_t, c_int64_t, c_ptr, c_size_t
         implicit none
         integer(c_int64_t), value :: data_set            !! Open data set
         integer(c_int64_t), value :: transfer_list       !! Property list
         integer(c_int32_t), value :: skipped             !! Bit mask of filters not applied
         integer(c_int64_t), intent(in) :: offset(*)      !! First element, slowest index first
         integer(c_size_t), value :: bytes                !! Length after the filters
         type(c_ptr), value :: buffer                     !! Filtered chunk
         integer(c_int) :: status
      end function c_write_chunk

      !> Function of zlib: compress a block of memory.
      function c_compress(packed, packed_bytes, plain, plain_bytes, level) &
         bind(c, name="compress2") result(status)
         import :: c_int, c_long, c_ptr
         implicit none
         type(c_ptr), value :: packed                     !! Destination
         integer(c_long), intent(inout) :: packed_bytes   !! Capacity in, length out
         type(c_ptr), value :: plain                      !! Source
         integer(c_long), value :: plain_bytes            !! Length of the data
         integer(c_int), value :: level                   !! 1 to 9
         integer(c_int) :: status                         !! 0 on success
      end function c_compress
   end interface

contains

   !> Compress and write all chunks of a data set whose rows are all on this rank.
   subroutine write_chunks(data_set, kind, extent, chunk, level, address, status)
      integer(hid_t), intent(in) :: data_set             !! The open data set
      integer(hid_t), intent(in) :: kind                 !! Type in memory and file
      integer(hsize_t), intent(in) :: extent(:)          !! Components (if any) and rows
      integer(int64), intent(in) :: chunk                !! Rows of a chunk
      integer, intent(in) :: level                       !! gzip level
      type(c_ptr), intent(in) :: address                 !! First row
      integer, intent(out) :: status                     !! < 0: not written
      integer(int8), pointer, contiguous :: plain(:)
      integer(int8), allocatable, target :: packed(:, :)
      integer(c_long), allocatable :: length(:)
      integer(int64) :: row_bytes, chunks, before, n
      integer(c_int64_t) :: offset(size(extent))
      integer(size_t) :: width
      integer :: batch

      call h5tget_size_f(kind, width, status)
      row_bytes = product(extent(:size(extent) - 1))*width
      call c_f_pointer(address, plain, [extent(size(extent))*row_bytes])
      chunks = (extent(size(extent)) + chunk - 1_int64)/chunk
      batch = int(min(chunks, int(share*omp_get_max_threads(), int64)))
      allocate (packed(packed_bound(chunk*row_bytes), batch), length(batch))
      do before = 0, chunks - 1, batch
         call pack_batch(plain, int(width), chunk*row_bytes, before, level, packed, length)
         offset = 0
         do n = 1, min(int(batch, int64), chunks - before)
            offset(1) = (before + n - 1)*chunk
            if (length(n) <= 0_c_long) status = -1
            if (status >= 0) status = c_write_chunk(data_set, no_list, 0_c_int32_t, offset, &
               int(length(n), c_size_t), c_loc(packed(1, n)))
            if (status < 0) return
         end do
      end do
   end subroutine write_chunks

   !> Capacity for a compressed chunk, the same as that of HDF5: 0.1 % and 12 bytes more [byte].
   pure function packed_bound(bytes) result(bound)
      integer(int64), intent(in) :: bytes                !! Before compression [byte]
      integer(int64) :: bound
      integer(int64), parameter :: part = 1000, least = 12

      bound = bytes + (bytes + part - 1)/part + least
   end function packed_bound

   !> Apply the filters to chunks that follow each other, in threads.
   subroutine pack_batch(plain, width, chunk_bytes, before, level, packed, length)
      integer(int8), contiguous, intent(in) :: plain(:)  !! All rows
      integer, intent(in) :: width                       !! Bytes of a number
      integer(int64), intent(in) :: chunk_bytes          !! Bytes of a chunk
      integer(int64), intent(in) :: before               !! Chunks before the first of these
      integer, intent(in) :: level                       !! gzip level
      integer(int8), contiguous, target, intent(inout) :: packed(:, :) !! (byte, chunk)
      integer(c_long), intent(inout) :: length(:)        !! (chunk) Bytes, 0 = failed or no chunk
      integer(int8), allocatable, target :: whole(:), shuffled(:)
      integer(int64) :: first, last
      integer(c_int) :: state
      integer :: n

      !$omp parallel default(none) private(n, first, last, state, whole, shuffled) &
      !$omp shared(plain, width, chunk_bytes, before, level, packed, length)
      allocate (whole(chunk_bytes), shuffled(chunk_bytes))
      !$omp do schedule(dynamic)
      do n = 1, size(length)
         first = (before + n - 1)*chunk_bytes
         last = min(first + chunk_bytes, size(plain, kind=int64))
         length(n) = 0
         if (first >= last) cycle
         if (last - first == chunk_bytes) then
            call shuffle(plain(first + 1:last), width, shuffled)
         else
            ! the last chunk is filled up with zeros
            whole = 0_int8
            whole(:last - first) = plain(first + 1:last)
            call shuffle(whole, width, shuffled)
         end if
         length(n) = size(packed, 1, kind=c_long)
         state = c_compress(c_loc(packed(1, n)), length(n), c_loc(shuffled), &
            int(chunk_bytes, c_long), int(level, c_int))
         if (state /= 0_c_int) length(n) = 0
      end do
      !$omp end do
      !$omp end parallel
   end subroutine pack_batch

   !> Sort the bytes of numbers by their significance: all first bytes, then all second ones, ...
   pure subroutine shuffle(plain, width, shuffled)
      integer(int8), contiguous, intent(in) :: plain(:)  !! Numbers, byte by byte
      integer, intent(in) :: width                       !! Bytes of a number
      integer(int8), contiguous, intent(inout) :: shuffled(:) !! The same bytes
      integer :: numbers

      numbers = int(size(plain, kind=int64)/width)
      select case (width)
      case (4)
         call shuffle_numbers(4, numbers, plain, shuffled)
      case (8)
         call shuffle_numbers(8, numbers, plain, shuffled)
      case default
         call shuffle_numbers(width, numbers, plain, shuffled)
      end select
   end subroutine shuffle

   !> Sort the bytes of numbers; the width is a constant where this is inlined.
   pure subroutine shuffle_numbers(width, numbers, plain, shuffled)
      integer, intent(in) :: width                       !! Bytes of a number
      integer, intent(in) :: numbers                     !! Number of numbers
      integer(int8), intent(in) :: plain(width, numbers) !! (byte, number)
      integer(int8), intent(inout) :: shuffled(numbers, width) !! (number, byte)
      integer :: n, byte

      do byte = 1, width
         !$omp simd
         do n = 1, numbers
            shuffled(n, byte) = plain(byte, n)
         end do
      end do
   end subroutine shuffle_numbers
end module io_hdf5_chunks
