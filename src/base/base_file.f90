! SPDX-License-Identifier: BSD-3-Clause
!> File operations with the reason of the system when they fail.
!!
!! Fortran cannot rename, synchronise or list files, and its runtime hides why a write failed, so
!! these procedures call the C library. They are local to the calling rank. `longest_name` is public
!! here as well: it is the length of the names that `list_folder` returns.
module base_file
   use base_error, only: code_length, error_t, exit_file, fail
   use base_kinds, only: int64, wp
   use base_libc, only: c_access, c_close, c_creat, c_dup2, c_fallocate, c_fsync, c_lseek, &
      c_memfd_create, c_mkdir, c_mkdtemp, c_open, c_read, c_readlink, c_realpath, c_rename, &
      c_rmdir, c_truncate, c_unlink, c_write, failure_number, failure_text, folder_entries, &
      longest_name
   use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_int32_t, c_loc, c_null_char, &
      c_size_t
   use, intrinsic :: iso_fortran_env, only: output_unit
   implicit none
   private

   public :: divert_file, file_exists, file_size, folder_of, join_path, list_folder, longest_name, &
      make_folder, make_temporary_folder, name_of, occupy_streams, output_file_t, print_text, &
      program_path, read_file, real_path, remove_file, remove_folder, rename_file, reserve_file, &
      sync_file, sync_folder, truncate_file, write_file

   integer, parameter, public :: longest_path = 1024     !! Characters of a path
   integer(c_int32_t), parameter :: file_mode = int(o"666", c_int32_t)
   integer(c_int32_t), parameter :: folder_mode = int(o"777", c_int32_t)
   integer(c_int), parameter :: exists_mode = 0, write_only = 1, read_only = 0
   integer(c_int), parameter :: output_stream = 1, last_stream = 2 !! Standard streams
   integer(c_int), parameter :: append_to = 1024         !! O_APPEND of Linux
   integer(c_int), parameter :: create_new = 64 + 128    !! O_CREAT and O_EXCL: no link is followed
   integer(c_int), parameter :: not_there = 2            !! ENOENT
   integer(c_int), parameter :: is_folder = 21           !! EISDIR
   integer(c_int), parameter :: no_such_call = 38, not_supported = 95 !! ENOSYS, EOPNOTSUPP

   !> A file that is written without buffering.
   type :: output_file_t
      character(len=:), allocatable :: path
      integer(c_int), private :: descriptor = -1         !! The open file
   contains
      procedure :: create => output_create               !! Create an empty file
      procedure :: append => output_append               !! Open to append
      procedure :: write => output_write                 !! Write a text
      procedure :: sync => output_sync                   !! Synchronise with the disk
      procedure :: close => output_close                 !! Close
   end type output_file_t

contains

   !> Allocate an error that names a path and the system's reason.
   subroutine fail_path(error, action, path)
      type(error_t), allocatable, intent(out) :: error
      character(len=*), intent(in) :: action             !! As in "cannot write [F103]"
      character(len=*), intent(in) :: path               !! File or folder

      associate (last => len(action) - code_length)
         call fail(error, exit_file, action(:last)//" '"//path//"': "//failure_text()// &
            action(last + 1:))
      end associate
   end subroutine fail_path

   !> True if there is a file or folder of this name.
   logical function file_exists(path) result(exists)
      character(len=*), intent(in) :: path               !! File or folder

      exists = c_access(path//c_null_char, exists_mode) == 0
   end function file_exists

   !> Length of a file, -1 if there is none [byte].
   function file_size(path) result(bytes)
      character(len=*), intent(in) :: path               !! File
      integer(int64) :: bytes
      integer(c_int), parameter :: from_end = 2
      integer(c_int) :: descriptor, status

      bytes = -1
      descriptor = c_open(path//c_null_char, read_only, file_mode)
      if (descriptor < 0) return
      bytes = c_lseek(descriptor, 0_int64, from_end)
      status = c_close(descriptor)
   end function file_size

   !> Folder part of a path, "." if there is none.
   pure function folder_of(path) result(folder)
      character(len=*), intent(in) :: path               !! Path of a file
      character(len=:), allocatable :: folder
      integer :: slash

      slash = index(path, "/", back=.true.)
      if (slash == 0) then
         folder = "."
      else if (slash == 1) then
         folder = "/"
      else
         folder = path(:slash - 1)
      end if
   end function folder_of

   !> Last part of a path.
   pure function name_of(path) result(name)
      character(len=*), intent(in) :: path               !! Path of a file
      character(len=:), allocatable :: name

      name = path(index(path, "/", back=.true.) + 1:)
   end function name_of

   !> Path of a file in a folder; an empty folder is the current one.
   pure function join_path(folder, name) result(path)
      character(len=*), intent(in) :: folder             !! Folder, with or without slash
      character(len=*), intent(in) :: name               !! Name of the file
      character(len=:), allocatable :: path

      if (len(folder) == 0 .or. folder == ".") then
         path = name
      else if (folder(len(folder):) == "/") then
         path = folder//name
      else
         path = folder//"/"//name
      end if
   end function join_path

   !> Path of the running program; empty if the system does not report it.
   function program_path() result(path)
      character(len=:), allocatable :: path

      path = link_target("/proc/self/exe")
   end function program_path

   !> Target of a link, empty if it cannot be read.
   function link_target(path) result(target_path)
      character(len=*), intent(in) :: path               !! Path of a symbolic link
      character(len=:), allocatable :: target_path
      character(len=longest_path), target :: letters
      integer(c_size_t) :: length

      length = c_readlink(path//c_null_char, c_loc(letters(1:1)), int(longest_path, c_size_t))
      target_path = letters(:max(int(length), 0))
   end function link_target

   !> Let all open descriptors of a file mean a new file in memory: what a library still writes
   !! before it closes the file goes there, and does not fail.
   subroutine divert_file(path)
      character(len=*), intent(in) :: path               !! File
      character(len=*), parameter :: descriptors = "/proc/self/fd"
      character(len=longest_name), allocatable :: names(:)
      character(len=:), allocatable :: whole
      integer(c_int) :: descriptor, memory, status
      logical :: readable
      integer :: n

      whole = real_path(path)
      call folder_entries(descriptors, "", "", names, readable)
      do n = 1, size(names)
         if (link_target(join_path(descriptors, trim(names(n)))) /= whole) cycle
         read (names(n), "(i10)", iostat=status) descriptor
         memory = c_memfd_create("scree"//c_null_char, 0_c_int)
         if (status /= 0 .or. memory < 0) cycle
         status = c_dup2(memory, descriptor)
         status = c_close(memory)
      end do
   end subroutine divert_file

   !> Absolute path without links and dots; unchanged if there is no such file.
   function real_path(path) result(whole)
      character(len=*), intent(in) :: path               !! File or folder
      character(len=:), allocatable :: whole
      integer, parameter :: longest = 4096               ! PATH_MAX of Linux
      character(len=longest), target :: letters

      whole = path
      if (.not. c_associated(c_realpath(path//c_null_char, c_loc(letters(1:1))))) return
      whole = letters(:index(letters, c_null_char) - 1)
   end function real_path

   !> Make a folder and its parents; existing ones are not an error.
   subroutine make_folder(path, error)
      character(len=*), intent(in) :: path               !! Folder
      type(error_t), allocatable, intent(out) :: error   !! Cannot be made
      integer :: last

      do last = 1, len(path)
         if (last < len(path)) then
            if (path(last + 1:last + 1) /= "/") cycle
         end if
         if (path(last:last) == "/") cycle
         if (file_exists(path(:last)//"/")) cycle
         if (c_mkdir(path(:last)//c_null_char, folder_mode) == 0) cycle
         ! another program may have made it meanwhile; if not, the second attempt gives the reason
         if (file_exists(path(:last)//"/")) cycle
         if (c_mkdir(path(:last)//c_null_char, folder_mode) == 0) cycle
         call fail_path(error, "cannot make the folder [F102]", path(:last))
         return
      end do
   end subroutine make_folder

   !> Make a new folder with a unique name in TMPDIR of the environment, or in /tmp. Only the user
   !! can read it.
   subroutine make_temporary_folder(prefix, path, error)
      character(len=*), intent(in) :: prefix             !! Beginning of its name
      character(len=:), allocatable, intent(out) :: path !! With its parents
      type(error_t), allocatable, intent(out) :: error   !! Cannot be made
      character(len=longest_path) :: parent
      character(len=:), allocatable, target :: letters
      integer :: status

      call get_environment_variable("TMPDIR", parent, status=status)
      if (status /= 0 .or. parent == "") parent = "/tmp"
      letters = join_path(trim(parent), prefix//"XXXXXX")//c_null_char
      path = letters(:len(letters) - 1)
      if (c_associated(c_mkdtemp(c_loc(letters(1:1))))) then
         path = letters(:len(letters) - 1)
      else
         call fail_path(error, "cannot make the folder [F102]", path)
      end if
   end subroutine make_temporary_folder

   !> Remove a folder with all files and folders in it; links are removed and not followed.
   recursive subroutine remove_folder(path, error)
      character(len=*), intent(in) :: path               !! Folder
      type(error_t), allocatable, intent(out) :: error   !! Cannot be removed
      character(len=longest_name), allocatable :: names(:)
      character(len=:), allocatable :: entry
      integer :: n

      call list_folder(path, "", "", names, error)
      if (allocated(error)) return
      do n = 1, size(names)
         if (names(n) == "." .or. names(n) == "..") cycle
         entry = join_path(path, trim(names(n)))
         if (c_unlink(entry//c_null_char) == 0) cycle
         if (failure_number() == is_folder) then
            call remove_folder(entry, error)
         else
            call fail_path(error, "cannot remove [F103]", entry)
         end if
         if (allocated(error)) return
      end do
      if (c_rmdir(path//c_null_char) /= 0) &
         call fail_path(error, "cannot remove the folder [F103]", path)
   end subroutine remove_folder

   !> Rename a file; an existing file of the new name is replaced atomically.
   subroutine rename_file(old, new, error)
      character(len=*), intent(in) :: old                !! Present path
      character(len=*), intent(in) :: new                !! Future path
      type(error_t), allocatable, intent(out) :: error   !! Cannot be renamed

      if (c_rename(old//c_null_char, new//c_null_char) /= 0) &
         call fail_path(error, "cannot rename '"//old//"' to [F103]", new)
   end subroutine rename_file

   !> Remove a file; a missing one is no error.
   subroutine remove_file(path, error)
      character(len=*), intent(in) :: path               !! File
      type(error_t), allocatable, intent(out), optional :: error !! Cannot be removed

      if (c_unlink(path//c_null_char) == 0) return
      if (failure_number() == not_there) return
      if (present(error)) call fail_path(error, "cannot remove [F103]", path)
   end subroutine remove_file

   !> Truncate a file.
   subroutine truncate_file(path, bytes, error)
      character(len=*), intent(in) :: path               !! File
      integer(int64), intent(in) :: bytes                !! New length [byte]
      type(error_t), allocatable, intent(out) :: error   !! Cannot be cut

      if (c_truncate(path//c_null_char, bytes) /= 0) &
         call fail_path(error, "cannot shorten [F103]", path)
   end subroutine truncate_file

   !> Wait until a file is on disk.
   subroutine sync_file(path, error)
      character(len=*), intent(in) :: path               !! File
      type(error_t), allocatable, intent(out) :: error   !! Not all of it reached the disk
      integer(c_int) :: descriptor, status

      descriptor = c_open(path//c_null_char, read_only, file_mode)
      if (descriptor < 0) then
         call fail_path(error, "cannot open [F103]", path)
         return
      end if
      if (c_fsync(descriptor) /= 0) call fail_path(error, "cannot write [F103]", path)
      status = c_close(descriptor)
   end subroutine sync_file

   !> Wait until the entries of a folder are on disk. Systems that cannot do this are tolerated.
   subroutine sync_folder(path)
      character(len=*), intent(in) :: path               !! Folder
      integer(c_int) :: descriptor, status

      descriptor = c_open(path//c_null_char, read_only, file_mode)
      if (descriptor < 0) return
      status = c_fsync(descriptor)
      status = c_close(descriptor)
   end subroutine sync_folder

   !> Reserve disk space for a file, which is created if missing and then has this length.
   !!
   !! MPI libraries can hang, or report success, when the disk fills up during a collective
   !! write (observed with Open MPI 4.1.4), so space is reserved before. File systems that
   !! cannot reserve space are tolerated.
   subroutine reserve_file(path, bytes, error)
      character(len=*), intent(in) :: path               !! File
      integer(int64), intent(in) :: bytes                !! Upper bound of its length [byte]
      type(error_t), allocatable, intent(out) :: error   !! Not enough space
      character(len=24) :: megabytes
      integer(c_int) :: descriptor, reason, status

      if (file_exists(path)) then
         descriptor = c_open(path//c_null_char, write_only, file_mode)
      else
         descriptor = c_creat(path//c_null_char, file_mode)
      end if
      if (descriptor < 0) then
         call fail_path(error, "cannot write [F103]", path)
         return
      end if
      if (c_fallocate(descriptor, 0_c_int, 0_int64, bytes) /= 0) then
         reason = failure_number()
         if (reason /= not_supported .and. reason /= no_such_call) then
            write (megabytes, "(f24.3)") 1.0e-6_wp*real(bytes, wp)
            call fail_path(error, "cannot reserve "//trim(adjustl(megabytes))// &
               " MB for [F103]", path)
         end if
      end if
      status = c_close(descriptor)
   end subroutine reserve_file

   !> Names in a folder with a given beginning and end, in alphabetical order.
   subroutine list_folder(folder, prefix, suffix, names, error)
      character(len=*), intent(in) :: folder             !! Folder
      character(len=*), intent(in) :: prefix             !! Prefix of names
      character(len=*), intent(in) :: suffix             !! Suffix of names
      character(len=longest_name), allocatable, intent(out) :: names(:) !! Filled with blanks
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      logical :: readable

      call folder_entries(folder, prefix, suffix, names, readable)
      if (.not. readable) call fail_path(error, "cannot read the folder [F104]", folder)
   end subroutine list_folder

   !> Write a file atomically: at any time either the old or the new one exists.
   subroutine write_file(path, text, error)
      character(len=*), intent(in) :: path               !! File
      character(len=*), intent(in) :: text               !! Whole content
      type(error_t), allocatable, intent(out) :: error   !! Cannot be written, old one intact
      type(output_file_t) :: part

      ! a link of this name may lead to a file elsewhere, which must not change
      call remove_file(path//".part")
      call part%create(path//".part", error, new=.true.)
      if (allocated(error)) return
      call part%write(text, error)
      if (.not. allocated(error)) call part%sync(error)
      call part%close()
      if (.not. allocated(error)) call rename_file(path//".part", path, error)
      if (allocated(error)) call remove_file(path//".part")
   end subroutine write_file

   !> Read a whole file.
   subroutine read_file(path, text, error)
      character(len=*), intent(in) :: path               !! File
      character(len=:), allocatable, intent(out), target :: text !! Whole content
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer(c_int) :: descriptor, status
      integer(c_size_t) :: bytes, done, got
      character(len=:), allocatable, target :: longer
      integer(c_size_t), parameter :: block = 65536

      ! a pipe has no length
      bytes = max(file_size(path), 0_int64)
      allocate (character(len=bytes) :: text)
      descriptor = c_open(path//c_null_char, read_only, file_mode)
      if (descriptor < 0) then
         call fail_path(error, "cannot read [F106]", path)
         return
      end if
      done = 0
      got = 0
      do
         if (done == len(text)) then
            if (bytes > 0) exit
            allocate (character(len=done + max(done, block)) :: longer)
            longer(:done) = text
            call move_alloc(longer, text)
         end if
         got = c_read(descriptor, c_loc(text(done + 1:done + 1)), len(text, c_size_t) - done)
         if (got <= 0) exit
         done = done + got
      end do
      if (got < 0 .or. done < bytes) call fail_path(error, "cannot read [F106]", path)
      if (done < len(text)) text = text(:done)
      status = c_close(descriptor)
   end subroutine read_file

   !> Give the numbers of standard streams that are closed to a file that refuses all writing. A
   !! file that is opened later would get such a number, and what is printed would be written to it.
   subroutine occupy_streams()
      integer(c_int) :: descriptor, status

      do
         descriptor = c_open("/dev/null"//c_null_char, read_only, file_mode)
         if (descriptor > last_stream) status = c_close(descriptor)
         if (descriptor > last_stream .or. descriptor < 0) exit
      end do
   end subroutine occupy_streams

   !> Print a text that is the result of the program; Fortran does not report if this fails.
   subroutine print_text(text, error)
      character(len=*), intent(in) :: text               !! Line ends included
      type(error_t), allocatable, intent(out) :: error   !! A full disk, a closed stream
      type(output_file_t) :: stream

      flush (output_unit)
      stream%path = "standard output"
      stream%descriptor = output_stream
      call stream%write(text, error)
   end subroutine print_text

   !> Create an empty file, which replaces the content of an existing one.
   subroutine output_create(self, path, error, new)
      class(output_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path               !! Path
      type(error_t), allocatable, intent(out) :: error   !! Cannot be written
      logical, intent(in), optional :: new               !! An existing file or link is an error

      call self%close()
      self%path = path
      if (present(new)) then
         self%descriptor = c_open(path//c_null_char, write_only + create_new, file_mode)
      else
         self%descriptor = c_creat(path//c_null_char, file_mode)
      end if
      if (self%descriptor < 0) call fail_path(error, "cannot write [F103]", path)
   end subroutine output_create

   !> Open an existing file to append to it.
   subroutine output_append(self, path, error)
      class(output_file_t), intent(inout) :: self
      character(len=*), intent(in) :: path               !! Path
      type(error_t), allocatable, intent(out) :: error   !! Cannot be written

      call self%close()
      self%path = path
      self%descriptor = c_open(path//c_null_char, write_only + append_to, file_mode)
      if (self%descriptor < 0) call fail_path(error, "cannot write [F103]", path)
   end subroutine output_append

   !> Write a text.
   subroutine output_write(self, text, error)
      class(output_file_t), intent(in) :: self
      character(len=*), intent(in) :: text               !! Line ends included
      type(error_t), allocatable, intent(out) :: error   !! Not all was written
      character(len=:), allocatable, target :: letters
      integer(c_size_t) :: done, got

      letters = text
      done = 0
      do while (done < len(text))
         got = c_write(self%descriptor, c_loc(letters(done + 1:done + 1)), len(text) - done)
         if (got <= 0) then
            call fail_path(error, "cannot write [F103]", self%path)
            return
         end if
         done = done + got
      end do
   end subroutine output_write

   !> Wait until the file is on disk.
   subroutine output_sync(self, error)
      class(output_file_t), intent(in) :: self
      type(error_t), allocatable, intent(out) :: error   !! Not all of it reached the disk

      if (c_fsync(self%descriptor) /= 0) call fail_path(error, "cannot write [F103]", self%path)
   end subroutine output_sync

   !> Close the file, if it is open.
   subroutine output_close(self)
      class(output_file_t), intent(inout) :: self
      integer(c_int) :: status

      if (self%descriptor < 0) return
      status = c_close(self%descriptor)
      self%descriptor = -1
   end subroutine output_close
end module base_file
