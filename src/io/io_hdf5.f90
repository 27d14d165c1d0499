! SPDX-License-Identifier: BSD-3-Clause
!> HDF5 files: how they begin and end, groups and attributes. With `io_hdf5_write`, `io_hdf5_read`
!! and `io_hdf5_index` the only code that sees HDF5.
!!
!! A file is written by all ranks together under a name ending in .part and renamed when it is
!! complete, so a file without that ending is whole. What goes wrong on one rank becomes the error
!! of all before the next collective call. The bytes of a file do not depend on the number of ranks.
!!
!! The library is started and ended with each file, so no handle outlives its file.
module io_hdf5
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: int32, int64, wp
   use hdf5, only: h5aclose_f, h5acreate_f, h5awrite_f, h5close_f, h5dont_atexit_f, &
      h5eset_auto_f, h5f_acc_trunc_f, h5f_scope_global_f, h5fclose_f, h5fcreate_f, h5fflush_f, &
      h5gclose_f, h5gcreate_f, h5oclose_f, h5oopen_f, h5open_f, h5p_file_access_f, &
      h5p_file_create_f, h5pclose_f, h5pcreate_f, h5pset_all_coll_metadata_ops_f, &
      h5pset_coll_metadata_write_f, h5pset_fapl_mpio_f, h5s_scalar_f, h5sclose_f, h5screate_f, &
      h5screate_simple_f, h5t_fortran_s1, h5t_native_double, h5t_std_i32le, h5t_std_i64le, &
      h5tclose_f, h5tcopy_f, h5tset_size_f, hid_t, hsize_t, size_t
   use io_file, only: folder_of, remove_file, rename_file, reserve_file, sync_file, sync_folder, &
      truncate_file
   use io_libc, only: clear_failure, failure_number, failure_text
   use io_seal, only: write_seal
   use, intrinsic :: iso_c_binding, only: c_bool, c_int, c_int64_t, c_loc, c_ptr
   implicit none
   private

   public :: hdf5_file_t, start_library, text_type

   integer(c_int), parameter :: never_again = 3          !! H5F_FSPACE_STRATEGY_NONE

   interface
      !> Part of the C library that the Fortran library of HDF5 1.10 lacks.
      function c_file_space_strategy(plan, strategy, persist, threshold) &
         bind(c, name="H5Pset_file_space_strategy") result(status)
         import :: c_bool, c_int, c_int64_t
         implicit none
         integer(c_int64_t), value :: plan                !! How the file will be made
         integer(c_int), value :: strategy                !! 3: space is never used again
         logical(c_bool), value :: persist                !! Keep a list of free space
         integer(c_int64_t), value :: threshold           !! Least size in that list
         integer(c_int) :: status
      end function c_file_space_strategy
   end interface

   !> A file that all ranks write.
   type :: hdf5_file_t
      character(len=:), allocatable :: path               !! Name when complete
      integer(hid_t) :: id = -1                           !! The open file
      type(communicator_t) :: communicator
      type(error_t), allocatable :: problem               !! First thing that failed, on all ranks
      integer :: status = 0                               !! Failures of this rank not yet shared
      character(len=:), allocatable :: seal               !! Title of a seal at the end, if wanted
   contains
      procedure :: create => hdf5_create                  !! Begin a file
      procedure :: finish => hdf5_finish                  !! Complete it, or take it away
      procedure :: group => hdf5_group                    !! Make a group
      procedure :: settle => hdf5_settle                  !! Share what went wrong
      procedure :: works => hdf5_works                    !! Nothing has gone wrong
      procedure, private :: attach_text, attach_real, attach_reals, attach_shorts, &
         attach_integer, attach
      !> Attach an attribute to a group or data set. Must be the same on all ranks.
      generic :: attribute => attach_text, attach_real, attach_reals, attach_shorts, attach_integer
   end type hdf5_file_t

contains

   !> Start the library, mute and without a hand in the end of the program.
   subroutine start_library(status)
      integer, intent(out) :: status                      !! 0 if it runs

      call h5dont_atexit_f(status)
      call h5open_f(status)
      if (status == 0) call h5eset_auto_f(0, status)
      call clear_failure()
   end subroutine start_library

   !> Begin a file, once its space is sure. Collective.
   subroutine hdf5_create(self, communicator, path, bytes, error)
      class(hdf5_file_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path                !! Name when complete
      integer(int64), intent(in) :: bytes                 !! Greatest length it may get [byte]
      type(error_t), allocatable, intent(out) :: error    !! It cannot be written; nothing is left
      integer(hid_t) :: access_list, plan
      integer :: status

      self%path = path
      self%communicator = communicator
      self%status = 0
      if (allocated(self%problem)) deallocate (self%problem)
      if (communicator%rank == 0) then
         call remove_file(part_of(self))
         call reserve_file(part_of(self), bytes, error)
         if (allocated(error)) call remove_file(part_of(self))
      end if
      call agree_plainly(communicator, error)
      if (allocated(error)) return
      call start_library(status)
      call h5pcreate_f(h5p_file_access_f, access_list, status)
      if (communicator%size > 1) call set_parallel(communicator, access_list)
      call h5pcreate_f(h5p_file_create_f, plan, status)
      ! Where HDF5 puts a chunk that it moves depends on the ranks if it fills gaps of the file.
      status = c_file_space_strategy(plan, never_again, .false._c_bool, 1_hsize_t)
      call h5fcreate_f(part_of(self), h5f_acc_trunc_f, self%id, status, creation_prp=plan, &
         access_prp=access_list)
      call self%settle("create", "", status)
      call h5pclose_f(access_list, status)
      call h5pclose_f(plan, status)
      if (self%works() .and. communicator%size > 1) then
         ! The library has emptied the file, so its space is taken once more.
         if (communicator%rank == 0) call reserve_file(part_of(self), bytes, error)
         call agree_plainly(communicator, error)
         if (allocated(error)) self%problem = error
      end if
      if (.not. self%works()) call self%finish(error)
   end subroutine hdf5_create

   !> Name of a file while it is not complete.
   pure function part_of(self) result(path)
      class(hdf5_file_t), intent(in) :: self
      character(len=:), allocatable :: path

      path = self%path//".part"
   end function part_of

   !> Share an error of rank 0, which speaks for all.
   subroutine agree_plainly(communicator, error)
      type(communicator_t), intent(in) :: communicator
      type(error_t), allocatable, intent(inout) :: error  !! Own error in, common error out
      character(len=*), parameter :: label = "rank 0: "

      call agree(communicator, error)
      if (.not. allocated(error)) return
      if (index(error%message, label) == 1) error%message = error%message(len(label) + 1:)
   end subroutine agree_plainly

   !> Let all ranks write to the file.
   subroutine set_parallel(communicator, access_list)
      type(communicator_t), intent(in) :: communicator
      integer(hid_t), intent(in) :: access_list           !! How the file will be opened
      integer :: group, hints, status

      call communicator%native(group, hints)
      call h5pset_fapl_mpio_f(access_list, group, hints, status)
      call h5pset_all_coll_metadata_ops_f(access_list, .true., status)
      call h5pset_coll_metadata_write_f(access_list, .true., status)
   end subroutine set_parallel

   !> Complete the file and give it its name; if anything went wrong take it away. Collective.
   subroutine hdf5_finish(self, error)
      class(hdf5_file_t), intent(inout) :: self
      type(error_t), allocatable, intent(out) :: error    !! It was not written; nothing is left
      type(error_t), allocatable :: ignored
      integer :: status

      if (self%works()) then
         call h5fflush_f(self%id, h5f_scope_global_f, status)
         call self%settle("complete", "", status)
      end if
      if (.not. self%works()) then
         ! An empty file frees the space that the library needs to close without complaint.
         if (self%communicator%rank == 0) call truncate_file(part_of(self), 0_int64, ignored)
         call self%communicator%barrier()
      end if
      if (self%id >= 0) call h5fclose_f(self%id, status)
      self%id = -1
      if (self%works()) call self%settle("close", "", status)
      call h5close_f(status)
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

   !> True until something goes wrong on some rank.
   pure logical function hdf5_works(self) result(works)
      class(hdf5_file_t), intent(in) :: self

      works = .not. allocated(self%problem)
   end function hdf5_works

   !> Share what went wrong on any rank, here or at attributes before. Collective.
   subroutine hdf5_settle(self, action, object, status)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: action              !! As in "cannot ACTION the file"
      character(len=*), intent(in) :: object              !! What in the file, or empty
      integer, intent(in) :: status                       !! Answer of the library on this rank
      type(error_t), allocatable :: error
      character(len=:), allocatable :: message

      if (status < 0 .or. self%status < 0) then
         message = "cannot "//action//" '"//self%path//"'"
         if (len(object) > 0) message = message//" at '"//object//"'"
         if (failure_number() /= 0_c_int) then
            message = message//": "//failure_text()
         else
            message = message//": the HDF5 library gave up"
         end if
         call fail(error, exit_file, message)
      end if
      call agree(self%communicator, error)
      if (allocated(error) .and. self%works()) call move_alloc(error, self%problem)
   end subroutine hdf5_settle

   !> Make a group. Collective.
   subroutine hdf5_group(self, name)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: name                !! From the root
      integer(hid_t) :: group
      integer :: status

      if (.not. self%works()) return
      call h5gcreate_f(self%id, name, group, status)
      if (status >= 0) call h5gclose_f(group, status)
      call self%settle("write", name, status)
   end subroutine hdf5_group

   !> A type for texts of a given length. The caller closes it.
   subroutine text_type(length, kind)
      integer, intent(in) :: length                       !! Letters
      integer(hid_t), intent(out) :: kind
      integer :: status

      call h5tcopy_f(h5t_fortran_s1, kind, status)
      call h5tset_size_f(kind, int(max(length, 1), size_t), status)
   end subroutine text_type

   !> Attach a value of any type to an object.
   subroutine attach(self, object, name, kind, length, address)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Group or data set, from the root
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
      character(len=*), intent(in) :: object              !! Group or data set, from the root
      character(len=*), intent(in) :: name                !! Name of the attribute
      character(len=*), intent(in) :: text                !! Its value
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

   !> Attach a real number.
   subroutine attach_real(self, object, name, value)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Group or data set, from the root
      character(len=*), intent(in) :: name                !! Name of the attribute
      real(wp), intent(in) :: value                       !! Its value
      real(wp), target :: copy

      copy = value
      call self%attach(object, name, h5t_native_double, 0, c_loc(copy))
   end subroutine attach_real

   !> Attach a row of real numbers.
   subroutine attach_reals(self, object, name, values)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Group or data set, from the root
      character(len=*), intent(in) :: name                !! Name of the attribute
      real(wp), intent(in) :: values(:)                   !! Its values
      real(wp), allocatable, target :: copy(:)

      allocate (copy, source=values)
      call self%attach(object, name, h5t_native_double, size(copy), c_loc(copy))
   end subroutine attach_reals

   !> Attach a row of short whole numbers.
   subroutine attach_shorts(self, object, name, values)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Group or data set, from the root
      character(len=*), intent(in) :: name                !! Name of the attribute
      integer(int32), intent(in) :: values(:)             !! Its values
      integer(int32), allocatable, target :: copy(:)

      allocate (copy(size(values)))
      copy(:) = values
      call self%attach(object, name, h5t_std_i32le, size(copy), c_loc(copy))
   end subroutine attach_shorts

   !> Attach a whole number.
   subroutine attach_integer(self, object, name, value)
      class(hdf5_file_t), intent(inout) :: self
      character(len=*), intent(in) :: object              !! Group or data set, from the root
      character(len=*), intent(in) :: name                !! Name of the attribute
      integer(int64), intent(in) :: value                 !! Its value
      integer(int64), target :: copy

      copy = value
      call self%attach(object, name, h5t_std_i64le, 0, c_loc(copy))
   end subroutine attach_integer
end module io_hdf5
