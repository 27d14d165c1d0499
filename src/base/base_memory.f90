! SPDX-License-Identifier: BSD-3-Clause
!> Memory that this process may still use, from the files of the Linux kernel. On systems without
!! these files it is unlimited.
module base_memory
   use base_kinds, only: int64
   implicit none
   private

   public :: address_space, available_memory, kernel_number

   integer(int64), parameter, public :: unlimited = huge(1_int64) !! No limit, or none known
   integer(int64), parameter :: kilobyte = 1024_int64

contains

   !> Memory of this node that programs can still get without swapping, within the limits of the
   !! control groups of this process, such as those of a batch job or a container [byte].
   integer(int64) function available_memory() result(bytes)
      character(len=400) :: line, root
      integer :: unit, status, colon

      bytes = kernel_number("/proc/meminfo", "MemAvailable:")
      if (bytes < unlimited) bytes = kilobyte*bytes
      open (newunit=unit, file="/proc/self/cgroup", action="read", status="old", iostat=status)
      if (status /= 0) return
      do
         read (unit, "(a)", iostat=status) line
         if (status /= 0) exit
         ! a line is number:controllers:path; version 2 has no names of controllers
         root = line(index(line, ":") + 1:)
         colon = index(root, ":")
         if (colon == 1) then
            bytes = min(bytes, left_in_groups("/sys/fs/cgroup", trim(root(2:)), "memory.max", &
               "memory.current", "inactive_file"))
         else if (index(","//root(:max(colon, 1) - 1)//",", ",memory,") > 0) then
            bytes = min(bytes, left_in_groups("/sys/fs/cgroup/memory", trim(root(colon + 1:)), &
               "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"))
         end if
      end do
      close (unit)
   end function available_memory

   !> What a control group and those above it leave [byte]. Pages of files that are not in use count
   !! as used, but the kernel frees them when memory is needed.
   integer(int64) function left_in_groups(root, path, limit, usage, idle) result(bytes)
      character(len=*), intent(in) :: root               !! Where the groups are mounted
      character(len=*), intent(in) :: path               !! Path of the group below it
      character(len=*), intent(in) :: limit, usage       !! Names of files
      character(len=*), intent(in) :: idle               !! Row of memory.stat
      integer(int64) :: most, used, files
      integer :: last

      bytes = unlimited
      last = len(path)
      do
         most = kernel_number(root//path(:last)//"/"//limit, "")
         used = kernel_number(root//path(:last)//"/"//usage, "")
         files = kernel_number(root//path(:last)//"/memory.stat", idle)
         if (files == unlimited) files = 0
         if (most < unlimited .and. used < unlimited) &
            bytes = min(bytes, max(most - max(used - files, 0_int64), 0_int64))
         if (last == 0) return
         last = max(index(path(:last), "/", back=.true.) - 1, 0)
      end do
   end function left_in_groups

   !> Address space that this process may still reserve, from `ulimit -v` [byte].
   integer(int64) function address_space() result(bytes)
      integer(int64) :: used

      bytes = kernel_number("/proc/self/limits", "Max address space")
      used = kernel_number("/proc/self/status", "VmSize:")
      if (bytes < unlimited .and. used < unlimited) bytes = max(bytes - kilobyte*used, 0_int64)
   end function address_space

   !> The integer after the first word, or first words, of a row of a file; unlimited if there is no
   !! such file, row or integer.
   integer(int64) function kernel_number(file, row) result(number)
      character(len=*), intent(in) :: file               !! Path
      character(len=*), intent(in) :: row                !! Beginning of the row, empty: the first
      character(len=200) :: line
      integer :: unit, status

      number = unlimited
      open (newunit=unit, file=file, action="read", status="old", iostat=status)
      if (status /= 0) return
      do
         read (unit, "(a)", iostat=status) line
         if (status /= 0) exit
         if (index(line, row) /= 1) cycle
         read (line(len(row) + 1:), *, iostat=status) number
         if (status /= 0 .or. number < 0) number = unlimited
         exit
      end do
      close (unit)
   end function kernel_number
end module base_memory
