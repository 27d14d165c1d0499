! SPDX-License-Identifier: BSD-3-Clause
!> Hints to the MPI library for files that several ranks write together, by the file system of their
!! folder.
!!
!! Names and values of the hints `romio_*`: users' guide of ROMIO; `striping_factor` and
!! `striping_unit`: MPI 3.1, 13.2.8. Values for Lustre: stripes of 4 MiB and more of them for large
!! files that many clients write (wiki.lustre.org, Lustre Striping Best Practices), 8, 24 and 72 for
!! files of 1, 10 and 100 GB (docs.nersc.gov, Lustre). Data sieving in writes reads a block, changes
!! it and writes it back under a lock of the file system, which collective buffering makes
!! superfluous and which is slow on Lustre (users' guide of ROMIO, romio_lustre_ds_in_coll).
module io_hints
   use base_kinds, only: int64, wp
   use base_libc, only: c_statfs
   use base_text, only: append, number, text_t
   use, intrinsic :: iso_c_binding, only: c_null_char
   implicit none
   private

   public :: add_hint, file_system_of, hints_for, hints_t

   integer, parameter :: status_words = 64               !! More than the 15 of struct statfs

   !> Names and values of hints.
   type :: hints_t
      type(text_t), allocatable :: names(:)
      type(text_t), allocatable :: values(:)             !! One for each name
   contains
      procedure :: report => hints_report                !! name=value, ...
   end type hints_t

   !> A file system and the number by which statfs(2) identifies it.
   type :: file_system_t
      character(len=6) :: name
      integer(int64) :: magic
   end type file_system_t

   !> File systems of several nodes. Numbers: statfs(2); GPFS and BeeGFS: stat of GNU coreutils.
   type(file_system_t), parameter :: shared_systems(5) = [ &
      file_system_t("lustre", int(z"0BD00BD0", int64)), &
      file_system_t("gpfs  ", int(z"47504653", int64)), &
      file_system_t("nfs   ", int(z"6969", int64)), &
      file_system_t("beegfs", int(z"19830326", int64)), &
      file_system_t("ceph  ", int(z"00C36400", int64))]

contains

   !> Name of the file system of a folder, if several nodes may write to it, else empty.
   function file_system_of(folder) result(name)
      character(len=*), intent(in) :: folder             !! Existing folder
      character(len=:), allocatable :: name
      integer(int64), parameter :: low_half = int(z"FFFFFFFF", int64)
      integer(int64) :: status(status_words)
      integer :: n

      name = ""
      status = 0
      if (c_statfs(folder//c_null_char, status) /= 0) return
      do n = 1, size(shared_systems)
         ! some architectures have a type of 32 bits
         if (iand(status(1), low_half) == shared_systems(n)%magic) &
            name = trim(shared_systems(n)%name)
      end do
   end function file_system_of

   !> Hints for a file system; none for a local one, whose defaults are suitable.
   subroutine hints_for(file_system, bytes, hints)
      character(len=*), intent(in) :: file_system        !! From `file_system_of`
      real(wp), intent(in) :: bytes                      !! Size of a large file of the run
      type(hints_t), intent(out) :: hints
      integer :: stripes

      allocate (hints%names(0), hints%values(0))
      if (file_system == "") return
      call add_hint(hints, "romio_cb_write", "enable")
      call add_hint(hints, "romio_ds_write", "disable")
      if (file_system /= "lustre") return
      call add_hint(hints, "romio_lustre_ds_in_coll", "disable")
      stripes = stripes_for(bytes)
      if (stripes == 1) return
      call add_hint(hints, "striping_factor", number(stripes))
      call add_hint(hints, "striping_unit", "4194304")
   end subroutine hints_for

   !> Number of stripes of a file on Lustre; 1: leave the default of the folder.
   pure integer function stripes_for(bytes) result(stripes)
      real(wp), intent(in) :: bytes                      !! Its size
      real(wp), parameter :: gigabyte = 1.0e9_wp

      stripes = 1
      if (bytes >= gigabyte) stripes = 8
      if (bytes >= 10.0_wp*gigabyte) stripes = 24
      if (bytes >= 100.0_wp*gigabyte) stripes = 72
   end function stripes_for

   !> Add a hint, or replace its value.
   subroutine add_hint(hints, name, value)
      type(hints_t), intent(inout) :: hints
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: value              !! Replaces an earlier one
      integer :: n

      do n = 1, size(hints%names)
         if (hints%names(n)%text /= name) cycle
         hints%values(n)%text = value
         return
      end do
      call append(hints%names, name)
      call append(hints%values, value)
   end subroutine add_hint

   !> The hints in one line; empty without hints.
   pure function hints_report(self) result(text)
      class(hints_t), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      do n = 1, size(self%names)
         if (n > 1) text = text//", "
         text = text//self%names(n)%text//"="//self%values(n)%text
      end do
   end function hints_report
end module io_hints
