! SPDX-License-Identifier: BSD-3-Clause
!> Files that a previous run of a case has left in a folder: found, so that they are not lost by
!! accident, and removed on request. The echo of that run names its streams.
module output_former_run
   use base_error, only: error_t
   use base_text, only: append, text_t
   use io_deck_changes, only: echo_streams
   use io_file, only: file_exists, join_path, list_folder, longest_name, read_file, real_path, &
      remove_file
   use output_catalogue, only: choose_stream, stream_names
   use output_stream, only: stream_file, stream_t
   implicit none
   private

   public :: find_former_run, former_run_t, is_own_checkpoint, remove_former_run

   character(len=*), parameter :: part = ".part"         !! Ending of a file that is being written
   character(len=*), parameter :: snapshot_ending = ".hdf", checkpoint_ending = ".h5"
   integer, parameter :: snapshot_digits = 6, checkpoint_digits = 1 !! Fewest in a name

   !> What a former run left.
   type :: former_run_t
      type(text_t), allocatable :: files(:)              !! Names in the folder
      logical :: results = .false.                       !! More than a log and an echo
      logical :: checkpoints = .false.                   !! A checkpoint is among them
   end type former_run_t

contains

   !> Look for the files of a run of this case. Concerns the calling rank alone.
   subroutine find_former_run(folder, case, echo, former)
      character(len=*), intent(in) :: folder             !! Folder of the results
      character(len=*), intent(in) :: case               !! Prefix of all files
      character(len=*), intent(in) :: echo               !! All keys of the run that is to begin
      type(former_run_t), intent(out) :: former          !! Its files
      character(len=longest_name), allocatable :: names(:)
      character(len=:), allocatable :: old
      type(error_t), allocatable :: error
      integer :: known

      allocate (former%files(0))
      if (.not. file_exists(join_path(folder, "."))) return
      call list_folder(folder, case, "", names, error)
      if (allocated(error)) return
      call take_numbered(names, case//"_chk_", checkpoint_ending, checkpoint_digits, former)
      former%checkpoints = has_whole_file(former)
      call take(names, case//".summary.json", former)
      call take_streams(names, case, echo, former)
      call read_file(join_path(folder, case//".echo.nml"), old, error)
      if (.not. allocated(error)) call take_streams(names, case, old, former)
      former%results = has_whole_file(former)
      call take(names, case//".echo.nml", former)
      call take(names, case//".log", former)
      do known = 1, size(former%files)
         call take(names, former%files(known)%text//part, former)
      end do
   end subroutine find_former_run

   !> Take the files of all streams of a deck, and those of a deck without &output.
   subroutine take_streams(names, case, echo, former)
      character(len=*), intent(in) :: names(:)       !! Names in the folder
      character(len=*), intent(in) :: case           !! Prefix of all files
      character(len=*), intent(in) :: echo           !! All keys of the deck
      type(former_run_t), intent(inout) :: former    !! Gets the files
      type(text_t), allocatable :: kind(:), name(:)
      class(stream_t), allocatable :: stream
      integer, allocatable :: number(:)
      integer :: n

      do n = 1, size(stream_names)
         call choose_stream(stream_names(n), stream)
         if (stream%default_count() > 0) call take_stream(names, stream_file(stream, case, "", 1), &
            stream%has_series(), former)
      end do
      call echo_streams(echo, name, kind, number)
      do n = 1, size(name)
         call choose_stream(kind(n)%text, stream)
         if (allocated(stream)) call take_stream(names, stream_file(stream, case, name(n)%text, &
            number(n)), stream%has_series(), former)
      end do
   end subroutine take_streams

   !> Take the files of one stream.
   subroutine take_stream(names, file, is_series, former)
      character(len=*), intent(in) :: names(:)       !! Names in the folder
      character(len=*), intent(in) :: file           !! The table, or beginning of names
      logical, intent(in) :: is_series               !! A file for each time, not one table
      type(former_run_t), intent(inout) :: former    !! Gets the files

      call take(names, file, former)
      if (.not. is_series) return
      call take_numbered(names, file//"_", snapshot_ending, snapshot_digits, former)
      call take(names, file//".hdf.series", former)
      call take(names, file//".vtkhdf", former)
   end subroutine take_stream

   !> Take the files whose names have a number between a beginning and an end, whole or not.
   subroutine take_numbered(names, begin, ending, digits, former)
      character(len=*), intent(in) :: names(:)           !! Names in the folder
      character(len=*), intent(in) :: begin              !! Before the number
      character(len=*), intent(in) :: ending             !! After it
      integer, intent(in) :: digits                      !! Fewest digits
      type(former_run_t), intent(inout) :: former        !! Gets the files
      character(len=:), allocatable :: name
      integer :: last, n

      do n = 1, size(names)
         name = trim(names(n))
         if (is_part(name)) name = name(:len(name) - len(part))
         last = len(name) - len(ending)
         if (index(name, begin) /= 1 .or. last < len(begin) + digits) cycle
         if (name(last + 1:) /= ending) cycle
         if (verify(name(len(begin) + 1:last), "0123456789") == 0) &
            call take(names, trim(names(n)), former)
      end do
   end subroutine take_numbered

   !> True for the name of a file that was being written.
   pure logical function is_part(name) result(partial)
      character(len=*), intent(in) :: name               !! Name of a file

      partial = index(name, part, back=.true.) > max(len(name) - len(part), 0)
   end function is_part

   !> True if a file was found that is complete.
   pure logical function has_whole_file(former) result(has)
      type(former_run_t), intent(in) :: former           !! The files
      integer :: n

      has = .false.
      do n = 1, size(former%files)
         has = has .or. .not. is_part(former%files(n)%text)
      end do
   end function has_whole_file

   !> Take a file if it is there and not yet taken.
   subroutine take(names, name, former)
      character(len=*), intent(in) :: names(:)           !! Names in the folder
      character(len=*), intent(in) :: name               !! The file
      type(former_run_t), intent(inout) :: former        !! Gets it
      integer :: n

      if (.not. any(names == name)) return
      do n = 1, size(former%files)
         if (former%files(n)%text == name) return
      end do
      call append(former%files, name)
   end subroutine take

   !> Remove what a former run left.
   subroutine remove_former_run(folder, former, error)
      character(len=*), intent(in) :: folder             !! Folder of the results
      type(former_run_t), intent(in) :: former           !! Its files
      type(error_t), allocatable, intent(out) :: error   !! One cannot be removed
      integer :: n

      do n = 1, size(former%files)
         call remove_file(join_path(folder, former%files(n)%text), error)
         if (allocated(error)) return
      end do
   end subroutine remove_former_run

   !> True if a checkpoint lies where this case writes its own.
   logical function is_own_checkpoint(folder, case, path) result(own)
      character(len=*), intent(in) :: folder             !! Folder of the results
      character(len=*), intent(in) :: case               !! Prefix of all files
      character(len=*), intent(in) :: path               !! The checkpoint
      character(len=:), allocatable :: place

      place = real_path(path)
      own = index(place, real_path(join_path(folder, "."))//"/"//case//"_chk_") == 1
   end function is_own_checkpoint
end module output_former_run
