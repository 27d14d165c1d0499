! SPDX-License-Identifier: BSD-3-Clause
!> This process: its environment variables, the cores and ranks of its node, the processors on which
!! it may run, its restart.
! allow(C071): texts of C have no length
module base_process
   use base_kinds, only: int64
   use base_memory, only: kernel_number, unlimited
   use base_text, only: text_t
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t, c_loc, c_long, c_null_char, &
      c_null_ptr, c_ptr, c_size_t
   use omp_lib, only: omp_get_num_places, omp_get_num_procs, omp_get_place_num_procs, &
      omp_get_place_proc_ids
   implicit none
   private

   public :: allowed_processors, cores_here, is_set, node_name, peak_memory, prefer_romio, &
      private_memory, processors_online, ranks_here, ranks_of_launcher, restart_process, set_default

   integer(c_int), parameter :: cores_online = 84        !! _SC_NPROCESSORS_ONLN of Linux
   integer, parameter :: mask_words = 128                !! 8192 processors

   interface
      !> Set an environment variable of this process, unless it is set and `overwrite` is 0.
      function c_setenv(name, value, overwrite) bind(c, name="setenv") result(status)
         import :: c_char, c_int
         implicit none
         character(kind=c_char), intent(in) :: name(*)   !! Null-terminated
         character(kind=c_char), intent(in) :: value(*)  !! Null-terminated
         integer(c_int), value :: overwrite              !! 0: keep the old value
         integer(c_int) :: status
      end function c_setenv

      !> Replace the program of this process, which keeps its number, files and environment.
      function c_execv(path, arguments) bind(c, name="execv") result(status)
         import :: c_char, c_int, c_ptr
         implicit none
         character(kind=c_char), intent(in) :: path(*)   !! Null-terminated
         type(c_ptr), intent(in) :: arguments(*)         !! Null terminated, a null pointer last
         integer(c_int) :: status
      end function c_execv

      !> A limit of the system.
      function c_sysconf(name) bind(c, name="sysconf") result(value)
         import :: c_int, c_long
         implicit none
         integer(c_int), value :: name                   !! Name
         integer(c_long) :: value
      end function c_sysconf

      !> Processors on which a thread may run.
      function c_sched_getaffinity(thread, bytes, mask) bind(c, name="sched_getaffinity") &
         result(status)
         import :: c_int, c_int64_t, c_size_t
         implicit none
         integer(c_int), value :: thread                 !! 0: this one
         integer(c_size_t), value :: bytes               !! Number of bytes of the mask
         integer(c_int64_t), intent(inout) :: mask(*)    !! Bit n: processor n
         integer(c_int) :: status
      end function c_sched_getaffinity

      !> Set the processors on which a thread may run.
      function c_sched_setaffinity(thread, bytes, mask) bind(c, name="sched_setaffinity") &
         result(status)
         import :: c_int, c_int64_t, c_size_t
         implicit none
         integer(c_int), value :: thread                 !! 0: this one
         integer(c_size_t), value :: bytes               !! Number of bytes of the mask
         integer(c_int64_t), intent(in) :: mask(*)       !! Bit n: processor n
         integer(c_int) :: status
      end function c_sched_setaffinity
   end interface

contains

   !> True if an environment variable is set and not empty.
   logical function is_set(name) result(found)
      character(len=*), intent(in) :: name               !! Name of the variable
      integer :: length, status

      call get_environment_variable(name, length=length, status=status)
      found = status == 0 .and. length > 0
   end function is_set

   !> Set an environment variable, unless the user has set it. It remains unset if no memory is
   !! available.
   subroutine set_default(name, value)
      character(len=*), intent(in) :: name               !! Name of the variable
      character(len=*), intent(in) :: value              !! Value
      integer(c_int) :: ignored

      ignored = c_setenv(name//c_null_char, value//c_null_char, 0_c_int)
   end subroutine set_default

   !> Have Open MPI write files with ROMIO, unless the user has set these variables. Its own OMPIO
   !! creates a shared file pointer for each file and sometimes blocks on its semaphore: about once
   !! in thirty files with two ranks and Open MPI 4.1.4 (issues 9656 of Open MPI and 1227 of HDF5).
   subroutine prefer_romio()
      character(len=*), parameter :: words(2) = [character(len=31) :: &
         "OMPI_MCA_io_romio321_priority", "OMPI_MCA_io_romio341_priority"]
      integer :: n

      do n = 1, size(words)
         call set_default(trim(words(n)), "90")
      end do
   end subroutine prefer_romio

   !> Memory of this process that no other shares: heap and stacks [byte]. 0 if the system does not
   !! report it.
   integer(int64) function private_memory() result(bytes)
      bytes = status_of("RssAnon:")
   end function private_memory

   !> Greatest resident memory of this process so far, with the pages of libraries and the buffers
   !! that it shares with other ranks [byte]. 0 if the system does not report it.
   integer(int64) function peak_memory() result(bytes)
      bytes = status_of("VmHWM:")
   end function peak_memory

   !> Value of a row of the status of this process, which the system gives in kB [byte].
   integer(int64) function status_of(row) result(bytes)
      character(len=*), intent(in) :: row                !! First word of the row

      bytes = kernel_number("/proc/self/status", row)
      bytes = merge(0_int64, 1024_int64*bytes, bytes == unlimited)
   end function status_of

   !> Number of ranks on this node from the environment of the launcher, before MPI starts; else 1.
   integer function ranks_here() result(ranks)
      ranks = count_of([character(len=26) :: "OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"])
   end function ranks_here

   !> Number of ranks that the launcher has started on all nodes, from its environment; else 1. In a
   !! batch job of Slurm without `srun` there is one process, whatever the job has.
   integer function ranks_of_launcher() result(ranks)
      ranks = count_of([character(len=20) :: "OMPI_COMM_WORLD_SIZE", "PMI_SIZE", &
         "SLURM_STEP_NUM_TASKS"])
   end function ranks_of_launcher

   !> The first environment variable that is a positive number; else 1.
   integer function count_of(words) result(ranks)
      character(len=*), intent(in) :: words(:)           !! Names of the variables
      character(len=16) :: value
      integer :: n, status

      do n = 1, size(words)
         call get_environment_variable(trim(words(n)), value, status=status)
         if (status /= 0) cycle
         read (value, *, iostat=status) ranks
         if (status == 0 .and. ranks > 0) return
      end do
      ranks = 1
   end function count_of

   !> Number of cores for all ranks on this node. A rank that the launcher has bound has access only
   !! to its own cores; then all cores of the node are counted.
   integer function cores_here() result(cores)
      cores = omp_get_num_procs()
      if (is_set("OMPI_MCA_orte_bound_at_launch")) cores = max(cores, int(c_sysconf(cores_online)))
   end function cores_here

   !> Number of processors of this node. A core with two hardware threads counts as two.
   integer function processors_online() result(processors)
      processors = int(c_sysconf(cores_online))
   end function processors_online

   !> Processors on which the threads of this rank may run: bit n, counted through the words, is
   !! processor n. All zero if they are not known. With `OMP_PROC_BIND` OpenMP binds the first
   !! thread to one entry of its place list. The mask of this thread is then smaller than that of
   !! the rank, which is the union of all entries of the list.
   function allowed_processors() result(mask)
      integer(int64), allocatable :: mask(:)
      integer, allocatable :: members(:)
      integer :: n, place

      allocate (mask(mask_words), source=0_int64)
      do place = 0, omp_get_num_places() - 1
         allocate (members(omp_get_place_num_procs(place)))
         call omp_get_place_proc_ids(place, members)
         do n = 1, size(members)
            associate (word => mask(members(n)/64 + 1))
               word = ibset(word, mod(members(n), 64))
            end associate
         end do
         deallocate (members)
      end do
      if (omp_get_num_places() > 0) return
      if (c_sched_getaffinity(0_c_int, int(8*mask_words, c_size_t), mask) /= 0) mask = 0
   end function allowed_processors

   !> Identity of this node, the same for all its processes: the boot identifier of its kernel.
   !! Empty if it is not known.
   function node_name() result(name)
      character(len=64) :: name
      integer :: status, unit

      name = ""
      open (newunit=unit, file="/proc/sys/kernel/random/boot_id", action="read", status="old", &
         iostat=status)
      if (status /= 0) return
      read (unit, "(a)", iostat=status) name
      close (unit)
      if (status /= 0) name = ""
   end function node_name

   !> Restart this program in the same process, so that its libraries read the environment again.
   !! Returns only if that is not possible. The new program inherits the processors of the first
   !! thread; with `OMP_PROC_BIND` these are one entry of the OpenMP place list, to which all
   !! threads of the new program would be bound.
   subroutine restart_process(path, name, arguments)
      character(len=*), intent(in) :: path               !! Path of the program
      character(len=*), intent(in) :: name               !! Name under which it was called
      type(text_t), intent(in) :: arguments(:)           !! Arguments of the command line
      character(len=:), allocatable, target :: letters
      type(c_ptr), allocatable :: pointers(:)
      integer, allocatable :: first(:)
      integer :: n
      integer(c_int) :: ignored

      allocate (pointers(size(arguments) + 2), first(size(arguments) + 1))
      letters = name//c_null_char
      first(1) = 1
      do n = 1, size(arguments)
         first(n + 1) = len(letters) + 1
         letters = letters//arguments(n)%text//c_null_char
      end do
      do n = 1, size(first)
         pointers(n) = c_loc(letters(first(n):first(n)))
      end do
      pointers(size(pointers)) = c_null_ptr
      associate (mask => allowed_processors())
         if (any(mask /= 0)) &
            ignored = c_sched_setaffinity(0_c_int, int(8*mask_words, c_size_t), mask)
      end associate
      ignored = c_execv(path//c_null_char, pointers)
   end subroutine restart_process
end module base_process
