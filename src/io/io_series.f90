! SPDX-License-Identifier: BSD-3-Clause
!> The files that make one series of many snapshots: the list .hdf.series and the index .vtkhdf.
!!
!! They are rewritten from the content of the snapshots, so a restart finds the series on the disk.
module io_series
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: join_path, list_folder, longest_name, name_of, write_file
   use base_text, only: exponent_text
   use io_hdf5_index, only: read_snapshot_info, snapshot_info_t, write_index
   use io_summary, only: json_quoted
   implicit none
   private

   public :: series_t

   integer, parameter :: often = 50 !! Up to this number of snapshots each one updates the index

   !> A series of snapshots.
   type :: series_t
      character(len=:), allocatable :: folder            !! Folder of the files
      character(len=:), allocatable :: prefix            !! As "CASE_p"
      logical :: of_grids = .false.                      !! Fields on the grid: no index is written
      type(snapshot_info_t), allocatable, private :: steps(:) !! On rank 0 only
   contains
      procedure :: open => series_open                   !! Find the snapshots of an earlier run
      procedure :: path => series_path                   !! Path of a snapshot
      procedure :: add => series_add                     !! A snapshot has been written
      procedure :: close => series_close                 !! Bring the index up to date
   end type series_t

contains

   !> Start a series, with the snapshots of a previous run before a number. Unreadable ones are
   !! omitted, because the run does not need them to continue. Collective.
   subroutine series_open(self, communicator, folder, prefix, next_number, note, error)
      class(series_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: folder             !! Folder of the files
      character(len=*), intent(in) :: prefix             !! As "CASE_p"
      integer, intent(in) :: next_number                 !! Number of the next snapshot
      character(len=:), allocatable, intent(out) :: note !! Rank 0: omitted files, or empty
      type(error_t), allocatable, intent(out) :: error   !! The folder cannot be read
      character(len=longest_name), allocatable :: names(:)
      integer :: length

      note = ""
      self%folder = folder
      self%prefix = prefix
      if (allocated(self%steps)) deallocate (self%steps)
      allocate (self%steps(0))
      if (communicator%rank == 0 .and. next_number > 0) then
         call list_folder(folder, prefix//"_", ".hdf", names, error)
         if (.not. allocated(error)) then
            ! numbers of seven digits come after those of six
            do length = len(prefix) + len("_000000.hdf"), len(name_of(self%path(next_number)))
               call collect(self, names, length, next_number, note)
            end do
         end if
      end if
      if (len(note) > 0) note = note// &
         "omitted from the series; the run continues [F121]"//new_line("a")
      call agree(communicator, error)
   end subroutine series_open

   !> Add the snapshots with names of a given length and with numbers below a limit.
   subroutine collect(series, names, length, next_number, note)
      type(series_t), intent(inout) :: series            !! Gets the snapshots
      character(len=*), intent(in) :: names(:)           !! Names in the folder, sorted
      integer, intent(in) :: length                      !! Length of the collected names
      integer, intent(in) :: next_number                 !! Number of the next snapshot
      character(len=:), allocatable, intent(inout) :: note !! Omitted files
      type(snapshot_info_t) :: info
      type(error_t), allocatable :: error
      integer :: index

      do index = 1, size(names)
         if (len_trim(names(index)) /= length) cycle
         if (verify(names(index)(len(series%prefix) + 2:length - len(".hdf")), "0123456789") > 0) &
            cycle
         if (.not. comes_before(join_path(series%folder, trim(names(index))), &
            series%path(next_number))) cycle
         call read_snapshot_info(join_path(series%folder, trim(names(index))), info, error, &
            series%of_grids)
         if (allocated(error)) then
            note = note//error%message//new_line("a")
         else
            call append(series%steps, info)
         end if
      end do
   end subroutine collect

   !> True if a snapshot of a series is before another one: of two numbers with at least six digits
   !! the longer one is greater.
   pure logical function comes_before(path, other) result(before)
      character(len=*), intent(in) :: path               !! Path of the file
      character(len=*), intent(in) :: other              !! Path of the other one

      before = len(path) < len(other) .or. (len(path) == len(other) .and. llt(path, other))
   end function comes_before

   !> Path of a snapshot.
   function series_path(self, number) result(path)
      class(series_t), intent(in) :: self
      integer, intent(in) :: number                      !! Counted from 0
      character(len=:), allocatable :: path
      character(len=16) :: digits

      write (digits, "(i0.6)") number
      path = join_path(self%folder, self%prefix//"_"//trim(digits)//".hdf")
   end function series_path

   !> Record a snapshot that has been written. Collective.
   subroutine series_add(self, communicator, path, error)
      class(series_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path
      type(error_t), allocatable, intent(out) :: error   !! The series cannot be written
      type(snapshot_info_t) :: info
      character(len=:), allocatable :: base
      integer :: count

      if (communicator%rank == 0) then
         call read_snapshot_info(path, info, error, self%of_grids)
         if (.not. allocated(error)) then
            call append(self%steps, info)
            count = size(self%steps)
            base = join_path(self%folder, self%prefix)
            call write_file(base//".hdf.series", series_text(self%steps), error)
            if (.not. (allocated(error) .or. self%of_grids) .and. &
               (count <= often .or. mod(count, often) == 0)) &
               call write_index(base//".vtkhdf", self%steps, error)
         end if
      end if
      call agree(communicator, error)
   end subroutine series_add

   !> Update the index at the end of a run. Collective.
   subroutine series_close(self, communicator, error)
      class(series_t), intent(inout) :: self
      type(communicator_t), intent(in) :: communicator
      type(error_t), allocatable, intent(out) :: error   !! The index cannot be written

      if (communicator%rank == 0 .and. allocated(self%steps)) then
         if (size(self%steps) > 0 .and. .not. self%of_grids) &
            call write_index(join_path(self%folder, self%prefix//".vtkhdf"), self%steps, error)
      end if
      call agree(communicator, error)
   end subroutine series_close

   !> Add a snapshot to the list. Listed snapshots of the same or a later number are of an earlier
   !! run and are removed from the list.
   subroutine append(steps, info)
      type(snapshot_info_t), allocatable, intent(inout) :: steps(:)
      type(snapshot_info_t), intent(in) :: info          !! A further one
      type(snapshot_info_t), allocatable :: larger(:)
      integer :: index, kept

      kept = size(steps)
      do while (kept > 0)
         if (comes_before(steps(kept)%path, info%path)) exit
         kept = kept - 1
      end do
      allocate (larger(kept + 1))
      do index = 1, kept
         larger(index) = steps(index)
      end do
      larger(size(larger)) = info
      call move_alloc(larger, steps)
   end subroutine append

   !> The list of files and times that ParaView reads.
   function series_text(steps) result(text)
      type(snapshot_info_t), intent(in) :: steps(:)
      character(len=:), allocatable :: text
      integer :: step

      text = "{"//new_line("a")//"  ""file-series-version"": ""1.0"","//new_line("a")// &
         "  ""files"": ["
      do step = 1, size(steps)
         if (step > 1) text = text//","
         text = text//new_line("a")//"    {""name"": "//json_quoted(name_of(steps(step)%path))// &
            ", ""time"": "//exponent_text(steps(step)%time)//"}"
      end do
      text = text//new_line("a")//"  ]"//new_line("a")//"}"//new_line("a")
   end function series_text
end module io_series
