! SPDX-License-Identifier: BSD-3-Clause
!> Interfaces to functions of the C library for files. Constants and layouts are those of 64-bit
!! Linux.
! allow(C071, C072): the texts of C have no length of their own
module base_libc
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int32_t, &
      c_int64_t, c_long, c_null_char, c_ptr, c_size_t
   implicit none
   private

   public :: c_access, c_close, c_creat, c_dlopen, c_dlsym, c_dup2, c_fallocate, c_fsync, &
      c_getpid, c_kill, c_lseek, c_memfd_create, c_mkdir, c_mkdtemp, c_open, c_read, c_readlink, &
      c_realpath, c_rename, c_rmdir, c_time, c_truncate, c_unlink, c_usleep, c_write, &
      clear_failure, failure_number, failure_text, folder_entries, loading_failure, text_at

   integer, parameter, public :: longest_name = 255              !! Longest file name
   integer(c_int), parameter, public :: load_now = 2     !! RTLD_NOW: all symbols at once
   integer, parameter :: name_offset = 19                !! Bytes before the name in a dirent

   interface
      function c_access(path, mode) bind(c, name="access") result(status)
         import :: c_char, c_int
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int), value :: mode                    !! 0: test for existence
         integer(c_int) :: status
      end function c_access

      function c_creat(path, mode) bind(c, name="creat") result(descriptor)
         import :: c_char, c_int, c_int32_t
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int32_t), value :: mode                !! Permissions
         integer(c_int) :: descriptor
      end function c_creat

      function c_open(path, flags, mode) bind(c, name="open") result(descriptor)
         import :: c_char, c_int, c_int32_t
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int), value :: flags                   !! Access mode
         integer(c_int32_t), value :: mode                !! Permissions
         integer(c_int) :: descriptor
      end function c_open

      function c_close(descriptor) bind(c, name="close") result(status)
         import :: c_int
         implicit none
         integer(c_int), value :: descriptor              !! Open file
         integer(c_int) :: status
      end function c_close

      function c_read(descriptor, buffer, bytes) bind(c, name="read") result(got)
         import :: c_int, c_ptr, c_size_t
         implicit none
         integer(c_int), value :: descriptor              !! Open file
         type(c_ptr), value :: buffer                     !! Destination
         integer(c_size_t), value :: bytes                !! Number of bytes
         integer(c_size_t) :: got
      end function c_read

      function c_readlink(path, buffer, capacity) bind(c, name="readlink") result(length)
         import :: c_char, c_ptr, c_size_t
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         type(c_ptr), value :: buffer                     !! Destination, not null terminated
         integer(c_size_t), value :: capacity                 !! Characters
         integer(c_size_t) :: length
      end function c_readlink

      function c_realpath(path, buffer) bind(c, name="realpath") result(found)
         import :: c_char, c_ptr
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         type(c_ptr), value :: buffer                     !! Destination, null terminated
         type(c_ptr) :: found                             !! Null: there is no such file
      end function c_realpath

      function c_write(descriptor, buffer, bytes) bind(c, name="write") result(got)
         import :: c_int, c_ptr, c_size_t
         implicit none
         integer(c_int), value :: descriptor              !! Open file
         type(c_ptr), value :: buffer                     !! Source
         integer(c_size_t), value :: bytes                !! Number of bytes
         integer(c_size_t) :: got
      end function c_write

      function c_lseek(descriptor, offset, whence) bind(c, name="lseek") result(place)
         import :: c_int, c_int64_t
         implicit none
         integer(c_int), value :: descriptor              !! Open file
         integer(c_int64_t), value :: offset                  !! Bytes
         integer(c_int), value :: whence                  !! 2: from the end
         integer(c_int64_t) :: place
      end function c_lseek

      function c_memfd_create(name, flags) bind(c, name="memfd_create") result(descriptor)
         import :: c_char, c_int
         implicit none
         character(kind=c_char), intent(in) :: name(*)    !! Null-terminated
         integer(c_int), value :: flags                   !! 0
         integer(c_int) :: descriptor
      end function c_memfd_create

      function c_dlopen(path, flags) bind(c, name="dlopen") result(library)
         import :: c_char, c_int, c_ptr
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int), value :: flags                   !! `load_now`
         type(c_ptr) :: library                           !! Null: cannot be loaded
      end function c_dlopen

      function c_dlerror() bind(c, name="dlerror") result(text)
         import :: c_ptr
         implicit none
         type(c_ptr) :: text                              !! Null: there was no failure
      end function c_dlerror

      function c_dlsym(library, name) bind(c, name="dlsym") result(address)
         import :: c_char, c_ptr
         implicit none
         type(c_ptr), value :: library                    !! Null: all libraries of the program
         character(kind=c_char), intent(in) :: name(*)    !! Null-terminated
         type(c_ptr) :: address                           !! Null: there is no such symbol
      end function c_dlsym

      function c_dup2(old, new) bind(c, name="dup2") result(descriptor)
         import :: c_int
         implicit none
         integer(c_int), value :: old                     !! Open file
         integer(c_int), value :: new                     !! Descriptor that is to mean this file
         integer(c_int) :: descriptor
      end function c_dup2

      function c_fsync(descriptor) bind(c, name="fsync") result(status)
         import :: c_int
         implicit none
         integer(c_int), value :: descriptor              !! Open file
         integer(c_int) :: status
      end function c_fsync

      function c_fallocate(descriptor, mode, offset, bytes) bind(c, name="fallocate") &
         result(status)
         import :: c_int, c_int64_t
         implicit none
         integer(c_int), value :: descriptor              !! Open file
         integer(c_int), value :: mode                    !! 0: also set the length
         integer(c_int64_t), value :: offset                  !! Start
         integer(c_int64_t), value :: bytes                   !! Length
         integer(c_int) :: status
      end function c_fallocate

      function c_truncate(path, bytes) bind(c, name="truncate") result(status)
         import :: c_char, c_int, c_int64_t
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int64_t), value :: bytes                   !! New length
         integer(c_int) :: status
      end function c_truncate

      function c_rename(old, new) bind(c, name="rename") result(status)
         import :: c_char, c_int
         implicit none
         character(kind=c_char), intent(in) :: old(*)     !! Null-terminated
         character(kind=c_char), intent(in) :: new(*)     !! Null-terminated
         integer(c_int) :: status
      end function c_rename

      function c_unlink(path) bind(c, name="unlink") result(status)
         import :: c_char, c_int
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int) :: status
      end function c_unlink

      function c_mkdir(path, mode) bind(c, name="mkdir") result(status)
         import :: c_char, c_int, c_int32_t
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int32_t), value :: mode                !! Permissions
         integer(c_int) :: status
      end function c_mkdir

      function c_rmdir(path) bind(c, name="rmdir") result(status)
         import :: c_char, c_int
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         integer(c_int) :: status
      end function c_rmdir

      function c_getpid() bind(c, name="getpid") result(process)
         import :: c_int
         implicit none
         integer(c_int) :: process                        !! Number of this process
      end function c_getpid

      function c_kill(process, signal) bind(c, name="kill") result(status)
         import :: c_int
         implicit none
         integer(c_int), value :: process                 !! Number of a process
         integer(c_int), value :: signal                  !! 0: test for existence
         integer(c_int) :: status
      end function c_kill

      function c_time(unused) bind(c, name="time") result(seconds)
         import :: c_long, c_ptr
         implicit none
         type(c_ptr), value :: unused                     !! Null
         integer(c_long) :: seconds                       !! Since 1970
      end function c_time

      function c_usleep(microseconds) bind(c, name="usleep") result(status)
         import :: c_int
         implicit none
         integer(c_int), value :: microseconds            !! Below a million
         integer(c_int) :: status
      end function c_usleep

      function c_mkdtemp(path) bind(c, name="mkdtemp") result(made)
         import :: c_ptr
         implicit none
         type(c_ptr), value :: path                       !! Ends with XXXXXX and a null
         type(c_ptr) :: made                              !! Null: cannot be made
      end function c_mkdtemp

      function c_opendir(path) bind(c, name="opendir") result(stream)
         import :: c_char, c_ptr
         implicit none
         character(kind=c_char), intent(in) :: path(*)    !! Null-terminated
         type(c_ptr) :: stream
      end function c_opendir

      function c_readdir(stream) bind(c, name="readdir") result(entry)
         import :: c_ptr
         implicit none
         type(c_ptr), value :: stream                     !! Open folder
         type(c_ptr) :: entry
      end function c_readdir

      function c_closedir(stream) bind(c, name="closedir") result(status)
         import :: c_int, c_ptr
         implicit none
         type(c_ptr), value :: stream                     !! Open folder
         integer(c_int) :: status
      end function c_closedir

      function c_strerror(number) bind(c, name="strerror") result(text)
         import :: c_int, c_ptr
         implicit none
         integer(c_int), value :: number                  !! Error number
         type(c_ptr) :: text
      end function c_strerror

      function c_errno_location() bind(c, name="__errno_location") result(address)
         import :: c_ptr
         implicit none
         type(c_ptr) :: address
      end function c_errno_location
   end interface

contains

   !> Error number of the last failed call of the C library.
   integer(c_int) function failure_number() result(number)
      integer(c_int), pointer :: here

      call c_f_pointer(c_errno_location(), here)
      number = here
   end function failure_number

   !> Reset the error number.
   subroutine clear_failure()
      integer(c_int), pointer :: here

      call c_f_pointer(c_errno_location(), here)
      here = 0
   end subroutine clear_failure

   !> Message of the last failure.
   function failure_text() result(text)
      character(len=:), allocatable :: text
      character(kind=c_char), pointer :: letters(:)
      integer, parameter :: longest_text = 1024

      call c_f_pointer(c_strerror(failure_number()), letters, [longest_text])
      text = text_until_null(letters)
   end function failure_text

   !> Message of the last failure to load a library or to find a symbol in it.
   function loading_failure() result(text)
      character(len=:), allocatable :: text
      integer, parameter :: longest_text = 1024

      text = text_at(c_dlerror(), longest_text)
   end function loading_failure

   !> Text at an address, empty if that is null.
   function text_at(address, most) result(text)
      type(c_ptr), intent(in) :: address                  !! Null-terminated text
      integer, intent(in) :: most                         !! Longest text; the rest is left out
      character(len=:), allocatable :: text
      character(kind=c_char), pointer :: letters(:)

      text = ""
      if (.not. c_associated(address)) return
      call c_f_pointer(address, letters, [most])
      text = text_until_null(letters)
   end function text_at

   !> Text of characters up to the null.
   pure function text_until_null(letters) result(text)
      character(kind=c_char), intent(in) :: letters(:)    !! Null-terminated
      character(len=:), allocatable :: text
      integer :: length

      text = ""
      do length = 1, size(letters)
         if (letters(length) == c_null_char) return
         text = text//letters(length)
      end do
   end function text_until_null

   !> Names in a folder with a given beginning and end, in alphabetical order.
   subroutine folder_entries(folder, prefix, suffix, names, readable)
      character(len=*), intent(in) :: folder              !! Folder
      character(len=*), intent(in) :: prefix              !! Prefix of names
      character(len=*), intent(in) :: suffix              !! Suffix of names
      character(len=longest_name), allocatable, intent(out) :: names(:) !! Padded with blanks
      logical, intent(out) :: readable                    !! The folder could be read
      character(len=longest_name), allocatable :: found(:), larger(:)
      character(len=:), allocatable :: name
      integer :: count
      type(c_ptr) :: stream
      integer(c_int) :: status

      allocate (found(64))
      count = 0
      stream = c_opendir(folder//c_null_char)
      readable = c_associated(stream)
      if (readable) then
         do
            call next_entry(stream, name)
            if (len(name) == 0) exit
            if (len(name) < len(prefix) + len(suffix)) cycle
            if (index(name, prefix) /= 1 .or. name(len(name) - len(suffix) + 1:) /= suffix) cycle
            if (count == size(found)) then
               allocate (larger(2*count))
               larger(:count) = found
               call move_alloc(larger, found)
            end if
            call insert(found, count, name)
         end do
         status = c_closedir(stream)
      end if
      allocate (names(count))
      names(:) = found(:count)
   end subroutine folder_entries

   !> Next name of a folder, empty at the end.
   subroutine next_entry(stream, name)
      type(c_ptr), intent(in) :: stream                   !! Open folder
      character(len=:), allocatable, intent(out) :: name  !! Empty at the end
      character(kind=c_char), pointer :: record(:)
      type(c_ptr) :: entry

      name = ""
      entry = c_readdir(stream)
      if (.not. c_associated(entry)) return
      call c_f_pointer(entry, record, [name_offset + longest_name + 1])
      name = text_until_null(record(name_offset + 1:))
   end subroutine next_entry

   !> Insert a name in alphabetical order.
   pure subroutine insert(names, count, name)
      character(len=*), intent(inout) :: names(:)         !! Sorted names
      integer, intent(inout) :: count                     !! Number of bytes
      character(len=*), intent(in) :: name                !! A further one
      integer :: place

      place = count
      do while (place > 0)
         if (llt(names(place), name)) exit
         names(place + 1) = names(place)
         place = place - 1
      end do
      names(place + 1) = name
      count = count + 1
   end subroutine insert
end module base_libc
