! SPDX-License-Identifier: BSD-3-Clause
!> HDF5 files: creation and completion, groups and attributes. Only `io_hdf5`, `io_hdf5_chunks`,
!! `io_hdf5_write`, `io_hdf5_read`, `io_hdf5_index` and `io_hdf5_ranks` use HDF5.
!!
!! All ranks write a file collectively under a name ending in .part and rename it when it is
!! complete, so a file without that ending is complete. A failure on one rank becomes the error of
!! all ranks before the next collective call. The bytes of a file do not depend on the number of
!! ranks.
!!
!! The library is initialised with the first file and not closed again, because each pair of
!! h5open_f and h5close_f leaks the types of HDF5's Fortran interface, 2.8 kB in version 1.10. No
!! handle outlives its file.
module io_hdf5
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail, without_code
   use base_file, only: divert_file, folder_of, output_file_t, remove_file, rename_file, &
      reserve_file, sync_file, sync_folder
   use base_kinds, only: int32, int64, wp
   use base_libc, only: c_dlsym, clear_failure, failure_number, failure_text
   use hdf5, only: h5aclose_f, h5acreate_f, h5awrite_f, h5dont_atexit_f, h5eset_auto_f, &
      h5f_acc_trunc_f, h5f_libver_earliest_f, h5f_libver_latest_f, h5f_obj_all_f, h5f_obj_file_f, &
      h5f_scope_global_f, h5fclose_f, h5fcreate_f, h5fflush_f, h5fget_obj_count_f, h5gclose_f, &
      h5gcreate_f, h5iis_valid_f, h5oclose_f, h5oopen_f, h5open_f, h5p_file_access_f, &
      h5p_file_create_f, h5pclose_f, h5pcreate_f, h5pset_libver_bounds_f, h5s_scalar_f, &
      h5sclose_f, h5screate_f, h5screate_simple_f, &
      h5t_fortran_s1, h5t_native_double, h5t_std_i32le, h5t_std_i64le, h5tclose_f, h5tcopy_f, &
      h5tset_size_f, hid_t, hsize_t, size_t
   use io_hdf5_ranks, only: open_on_all_ranks
   use io_seal, only: write_seal
   use, intrinsic :: iso_c_binding, only: c_associated, c_bool, c_f_pointer, c_int, c_int64_t, &
      c_loc, c_null_char, c_null_ptr, c_ptr
   use, intrinsic :: iso_fortran_env, only: error_unit
   implicit none
   private

   public :: hdf5_file_t, leave_library, start_library, text_type

   real(wp), parameter :: patience = 30.0_wp             !! For ranks that have not failed [s]
   integer, parameter :: trial_bytes = 65536             !! Written to find the reason of a failure
   integer(c_int), parameter :: never_again = 3          !! H5F_FSPACE_STRATEGY_NONE

   interface
      !> C function that has no Fortran interface in HDF5 1.10.
      function c_file_space_strategy(plan, strategy, persist, threshold) &
         bind(c, name="H5Pset_file_space_strategy") result(status)
         import :: c_bool, c_int, c_int64_t
         implicit none
         integer(c_int64_t), value :: plan                !! File creation property list
         integer(c_int), value :: strategy                !! 3: free space is not reused
         logical(c_bool), value :: persist                !! Keep a list of free space
         integer(c_int64_t), value :: threshold           !! Least size in that list
         integer(c_int) :: status
      end function c_file_space_strategy
   end interface

   !> A file that all ranks write collectively.
   type :: hdf5_file_t
      character(len=:), allocatable :: path               !! Final name
      integer(hid_t) :: id = -1                           !! The open file
      type(communicator_t) :: communicator
      type(error_t), allocatable :: problem               !! First failure, the same on all ranks
      integer :: status = 0                               !! Failures of this rank, not shared yet
      character(len=:), allocatable :: seal !! Title of the seal; none if not allocated
   contains
      procedure :: create => hdf5_create                  !! Create a file
      procedure :: finish => hdf5_finish                  !! Complete the file, or remove it
      procedure :: group => hdf5_group                    !! Create a group
      procedure :: share_status => hdf5_share_status !! Make a failure common to all ranks
      procedure :: works => hdf5_works                    !! True without a failure so far
      procedure, private :: attach_text, attach_real, attach_reals, attach_shorts, &
         attach_integer, attach
      !> Attach an attribute to a group or data set. Must be the same on all ranks.
      generic :: attribute => attach_text, attach_real, attach_reals, attach_shorts, attach_integer
   end type hdf5_file_t

contains

   !> Initialise the library if this has not been done, without error printing and without an exit
   !! handler.
   subroutine start_library(status)
      integer, intent(out) :: status                      !! 0 on success
      logical :: started

      call h5dont_atexit_f(status)
      ! a type of the Fortran interface, which h5open_f makes
      call h5iis_valid_f(h5t_fortran_s1, started, status)
      if (.not. started) call h5open_f(status)
      if (status == 0) call h5eset_auto_f(0, status)
      call clear_failure()
   end subroutine start_library

   !> After an error, before the end of message passing: the library then closes all files that are
   !! open, and crashes at one that it could not close before. Its flag is set as if it had ended.
   subroutine leave_library()
      logical(c_bool), pointer :: is_started
      integer(size_t) :: files
      integer :: status
      type(c_ptr) :: address

      call start_library(status)
      call h5fget_obj_count_f(int(h5f_obj_all_f, hid_t), h5f_obj_file_f, files, status)
      if (status < 0 .or. files == 0) return
      address = c_dlsym(c_null_ptr, "H5_libinit_g"//c_null_char)
      if (.not. c_associated(address)) return
      call c_f_pointer(address, is_started)
      is_started = .false.
   end subroutine leave_library

   !> Reserve space for a file and create it. Collective.
   subroutine hdf5_create(self, communicator, path, bytes, error)
      class(hdf5_file_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path                !! Final name
      integer(int64), intent(in) :: bytes                 !! Upper bound of its length [byte]
      type(error_t), allocatable, intent(out) :: error    !! Cannot be written; no file remains
      integer(hid_t) :: access_list, plan
      integer :: status

      self%path = path
      self%communicator = communicator
      self%status = 0
      if (allocated(self%problem)) deallocate (self%problem)
      if (communicator%rank == 0) then
         call remove_file(part_of(self))
         call reserve_file(part_of(self), bytes, error)
         ! MPI applies hints on striping only to a file that it creates itself
         if (allocated(error) .or. communicator%size > 1) call remove_file(part_of(self))
      end if
      call agree_plainly(communicator, error)
      if (allocated(error)) return
      call start_library(status)
      call h5pcreate_f(h5p_file_access_f, access_list, status)
      call open_on_all_ranks(communicator, access_list)
      ! HDF5 2 by default writes groups that older versions do not read, with positions that differ
      ! between one rank and several
      call h5pset_libver_bounds_f(access_list, h5f_libver_earliest_f, h5f_libver_latest_f, status)
      call h5pcreate_f(h5p_file_create_f, plan, status)
      ! if HDF5 reused free space, the position of a moved chunk would depend on the ranks
      status = c_file_space_strategy(plan, never_again, .false._c_bool, 1_hsize_t)
      call h5fcreate_f(part_of(self), h5f_acc_trunc_f, self%id, status, creation_prp=plan, &
         access_prp=access_list)
      call self%share_status("cannot create", "", status)
      call h5pclose_f(access_list, status)
      call h5pclose_f(plan, status)
      if (self%works() .and. communicator%size > 1) then
         ! this is a new file, so space is reserved again
         if (communicator%rank == 0) call reserve_file(part_of(self), bytes, error)
         call agree_plainly(communicator, error)
         if (allocated(error)) self%problem = error
      end if
      if (.not. self%works()) call self%finish(error)
   end subroutine hdf5_create

   !> Name of an incomplete file.
   pure function part_of(self) result(path)
      class(hdf5_file_t), intent(in) :: self
      character(len=:), allocatable :: path

      path = self%path//".part"
   end function part_of

   !> Make an error of rank 0 common to all ranks, without the rank in its text.
   subroutine agree_plainly(communicator, error)
      type(communicator_t), intent(in) :: communicator
      type(error_t), allocatable, intent(inout) :: error  !! Local error in, common error out
      character(len=*), parameter :: label = "rank 0: "

      call agree(communicator, error)
      if (.not. allocated(error)) return
      if (index(error%message, label) == 1) error%message = error%message(len(label) + 1:)
   end subroutine agree_plainly

   !> Complete the file and rename it; after a failure remove it. Collective.
   subroutine hdf5_finish(self, error)
      class(hdf5_file_t), intent(inout) :: self
      type(error_t), allocatable, intent(out) :: error    !! Not written; no file remains
      integer :: status
      logical :: stuck

      stuck = .false.
      if (self%works()) then
         call h5fflush_f(self%id, h5f_scope_global_f, status)
         call self%share_status("cannot complete", "", status)
         stuck = .not. self%works()
      end if
      if (.not. self%works()) then
         ! the library writes once more before it closes a file, which must not fail; after a failed
         ! flush it can never close it
         call divert_file(part_of(self))
         call self%communicator%barrier()
      end if
      if (self%id >= 0 .and. .not. stuck) call h5fclose_f(self%id, status)
      self%id = -1
      if (self%works()) call self%share_status("cannot close", "", status)
      if (self%works() .and. allocated(self%seal)) then
         call write_seal(self%communicator, part_of(self), self%seal, error)
         if (allocated(error)) call move_alloc(error, self%problem)
      end if
      if (self%works() .and. self%communicator%rank == 0) then
         call sync_file(part_of(self), error)
         if (.not. allocated(error)) call rename_file(part_of(self), self%path, error)
         if (.not. allocated(error)) call sync_folder(folder_of(self%path))
      end if
      call agree_plainly(self%communicator, error)
      if (.not. self%works()) error = self%problem
      if (allocated(error) .and. self%communicator%rank == 0) call remove_file(part_of(self))
      call self%communicator%barrier()
   end subroutine hdf5_finish

   !> True until a failure on some rank.
   pure logical function hdf5_works(self) result(works)
      class(hdf5_file_t), intent(in) :: self

      works = .not. allocated(self%problem)
   end function hdf5_works

   !> Make a failure of any rank, here or in earlier attributes, common to all. Collective.
   subroutine hdf5_share_status(self, action, object, status)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: action              !! As in "cannot write", before the name
      character(len=*), intent(in) :: object              !! Object in the file, or empty
      integer, intent(in) :: status                       !! Status of the library on this rank
      type(error_t), allocatable :: error
      character(len=:), allocatable :: message

      if (status < 0 .or. self%status < 0) then
         message = action//" '"//self%path//"'"
         if (len(object) > 0) message = message//" at '"//object//"'"
         if (failure_number() == 0_c_int) call try_to_write(part_of(self))
         if (failure_number() /= 0_c_int) then
            message = message//": "//failure_text()
         else
            message = message//": the HDF5 library gave up"
         end if
         call fail(error, exit_file, message//" [F103]")
      end if
      if (.not. self%communicator%meets(allocated(error), patience)) &
         call give_up(self%communicator, error%message)
      call agree(self%communicator, error)
      if (allocated(error) .and. self%works()) call move_alloc(error, self%problem)
   end subroutine hdf5_share_status

   !> End the run where the other ranks cannot learn of an error: they wait for this rank inside
   !! of a write that has failed here.
   subroutine give_up(communicator, message)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: message

      write (error_unit, "(a)") "error: "//without_code(message)//"; other ranks are still in "// &
         "this call, so the run ends at once [F103]"
      flush (error_unit)
      call communicator%abort(exit_file)
   end subroutine give_up

   !> Write to the end of a file that is given up: MPI does not return the error number.
   subroutine try_to_write(path)
      character(len=*), intent(in) :: path                !! Incomplete file
      type(output_file_t) :: file
      type(error_t), allocatable :: error

      call file%append(path, error)
      if (.not. allocated(error)) call file%write(repeat(" ", trial_bytes), error)
      if (.not. allocated(error)) call file%sync(error)
      if (.not. allocated(error)) call clear_failure()
      call file%close()
   end subroutine try_to_write

   !> Create a group. Collective.
   subroutine hdf5_group(self, name)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: name                !! Path from the root
      integer(hid_t) :: group
      integer :: status

      if (.not. self%works()) return
      call h5gcreate_f(self%id, name, group, status)
      if (status >= 0) call h5gclose_f(group, status)
      call self%share_status("cannot write", name, status)
   end subroutine hdf5_group

   !> Make a type for texts of a given length. The caller closes it.
   subroutine text_type(length, kind)
      integer, intent(in) :: length                       !! Characters
      integer(hid_t), intent(out) :: kind                !! Handle of the type
      integer :: status

      call h5tcopy_f(h5t_fortran_s1, kind, status)
      call h5tset_size_f(kind, int(max(length, 1), size_t), status)
   end subroutine text_type

   !> Attach a value of any type to an object.
   subroutine attach(self, object, name, kind, length, address)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Path of a group or data set
      character(len=*), intent(in) :: name                !! Name of the attribute
      integer(hid_t), intent(in) :: kind                  !! Type in memory and file
      integer, intent(in) :: length                       !! Number of values, 0: one, no array
      type(c_ptr), intent(in) :: address
      integer(hid_t) :: attribute, place, space
      integer(hsize_t) :: extent(1)
      integer :: ignored, status

      if (.not. self%works()) return
      extent = length
      call h5oopen_f(self%id, object, place, status)
      if (status >= 0) then
         if (length == 0) call h5screate_f(h5s_scalar_f, space, status)
         if (length > 0) call h5screate_simple_f(1, extent, space, status)
         call h5acreate_f(place, name, kind, space, attribute, status)
         if (status >= 0) then
            call h5awrite_f(attribute, kind, address, status)
            call h5aclose_f(attribute, ignored)
         end if
         call h5sclose_f(space, ignored)
         call h5oclose_f(place, ignored)
      end if
      self%status = min(self%status, status)
   end subroutine attach

   !> Attach a text.
   subroutine attach_text(self, object, name, text)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Path of a group or data set
      character(len=*), intent(in) :: name                !! Name of the attribute
      character(len=*), intent(in) :: text                !! Value
      character(len=:), allocatable, target :: letters
      integer(hid_t) :: kind
      integer :: status

      if (.not. self%works()) return
      letters = text
      if (len(text) == 0) letters = " "
      call text_type(len(letters), kind)
      call self%attach(object, name, kind, 0, c_loc(letters(1:1)))
      call h5tclose_f(kind, status)
   end subroutine attach_text

   !> Attach a real.
   subroutine attach_real(self, object, name, value)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Path of a group or data set
      character(len=*), intent(in) :: name                !! Name of the attribute
      real(wp), intent(in) :: value                       !! Value
      real(wp), target :: copy

      copy = value
      call self%attach(object, name, h5t_native_double, 0, c_loc(copy))
   end subroutine attach_real

   !> Attach a row of reals.
   subroutine attach_reals(self, object, name, values)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Path of a group or data set
      character(len=*), intent(in) :: name                !! Name of the attribute
      real(wp), intent(in) :: values(:)                   !! Values
      real(wp), allocatable, target :: copy(:)

      allocate (copy, source=values)
      call self%attach(object, name, h5t_native_double, size(copy), c_loc(copy))
   end subroutine attach_reals

   !> Attach a row of 32-bit integers.
   subroutine attach_shorts(self, object, name, values)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Path of a group or data set
      character(len=*), intent(in) :: name                !! Name of the attribute
      integer(int32), intent(in) :: values(:)             !! Values
      integer(int32), allocatable, target :: copy(:)

      allocate (copy(size(values)))
      copy(:) = values
      call self%attach(object, name, h5t_std_i32le, size(copy), c_loc(copy))
   end subroutine attach_shorts

   !> Attach an integer.
   subroutine attach_integer(self, object, name, value)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Path of a group or data set
      character(len=*), intent(in) :: name                !! Name of the attribute
      integer(int64), intent(in) :: value                 !! Value
      integer(int64), target :: copy

      copy = value
      call self%attach(object, name, h5t_std_i64le, 0, c_loc(copy))
   end subroutine attach_integer
end module io_hdf5
