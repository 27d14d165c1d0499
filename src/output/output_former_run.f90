! SPDX-License-Identifier: BSD-3-Clause
!> Files that a previous run of a case has left in a folder: found, so that they are not lost by
!! accident, and removed on request. The echo of that run names its streams.
module output_former_run
   use base_error, only: error_t
   use base_file, only: file_exists, join_path, list_folder, longest_name, read_file, real_path, &
      remove_file
   use base_text, only: append, text_t
   use deck_changes, only: echo_streams
   use output_catalogue, only: choose_stream, stream_names
   use output_stream, only: stream_file, stream_t
   implicit none
   private

   public :: find_former_run, former_run_t, is_own_checkpoint, remove_former_run

   character(len=*), parameter :: part = ".part"         !! Ending of a file that is being written
   character(len=*), parameter :: snapshot_ending = ".hdf", checkpoint_ending = ".h5"
   integer, parameter :: snapshot_digits = 6, checkpoint_digits = 1 !! Fewest in a name

   !> Files of a previous run.
   type :: former_run_t
      type(text_t), allocatable :: files(:)              !! Names in the folder
      logical :: results = .false.                       !! Are there files besides log and echo?
      logical :: checkpoints = .false.                   !! Is a checkpoint among them?
   end type former_run_t

contains

   !> Find the files of a run of this case. Local to the calling rank.
   subroutine find_former_run(folder, case, echo, former)
      character(len=*), intent(in) :: folder             !! Folder of the results
      character(len=*), intent(in) :: case               !! Prefix of all files
      character(len=*), intent(in) :: echo               !! All keys of the run that is to begin
      type(former_run_t), intent(out) :: former          !! Files found
      character(len=longest_name), allocatable :: names(:)
      character(len=:), allocatable :: old
      type(error_t), allocatable :: error
      integer :: known

      allocate (former%files(0))
      if (.not. file_exists(join_path(folder, "."))) return
      call list_folder(folder, case, "", names, error)
      if (allocated(error)) return
      call add_numbered_files(names, case//"_chk_", checkpoint_ending, checkpoint_digits, former)
      former%checkpoints = has_whole_file(former)
      call add_file(names, case//".summary.json", former)
      call add_stream_files(names, case//"_grains", .true., former)
      call add_stream_files(names, case//"_contacts", .true., former)
      call add_file(names, case//"_moduli.csv", former)
      call add_files_of_streams(names, case, echo, former)
      call read_file(join_path(folder, case//".echo.nml"), old, error)
      if (.not. allocated(error)) call add_files_of_streams(names, case, old, former)
      former%results = has_whole_file(former)
      call add_file(names, case//".echo.nml", former)
      call add_file(names, case//".log", former)
      do known = 1, size(former%files)
         call add_file(names, former%files(known)%text//part, former)
      end do
   end subroutine find_former_run

   !> Add the files of all streams of a deck, and those of a deck without &output.
   subroutine add_files_of_streams(names, case, echo, former)
      character(len=*), intent(in) :: names(:)       !! Names in the folder
      character(len=*), intent(in) :: case           !! Prefix of all files
      character(len=*), intent(in) :: echo           !! All keys of the deck
      type(former_run_t), intent(inout) :: former    !! Gets the files
      type(text_t), allocatable :: kind(:), name(:)
      class(stream_t), allocatable :: stream
      integer, allocatable :: number(:)
      integer :: n, form

      do n = 1, size(stream_names)
         call choose_stream(stream_names(n), stream)
         if (stream%default_count() > 0) call add_stream_files(names, stream_file(stream, case, &
            "", 1), &
            stream%has_series(), former)
      end do
      call echo_streams(echo, name, kind, number)
      do n = 1, size(name)
         call choose_stream(kind(n)%text, stream)
         if (.not. allocated(stream)) cycle
         ! the first of a kind is with its name if it is always named
         do form = number(n), max(number(n), 2)
            call add_stream_files(names, stream_file(stream, case, name(n)%text, form), &
               stream%has_series(), former)
         end do
      end do
   end subroutine add_files_of_streams

   !> Add the files of one stream.
   subroutine add_stream_files(names, file, is_series, former)
      character(len=*), intent(in) :: names(:)       !! Names in the folder
      character(len=*), intent(in) :: file           !! The table, or beginning of names
      logical, intent(in) :: is_series               !! A file for each time, not one table
      type(former_run_t), intent(inout) :: former    !! Gets the files

      call add_file(names, file, former)
      if (.not. is_series) return
      call add_numbered_files(names, file//"_", snapshot_ending, snapshot_digits, former)
      call add_file(names, file//".hdf.series", former)
      call add_file(names, file//".vtkhdf", former)
   end subroutine add_stream_files

   !> Add the files with a number between prefix and suffix of the name, complete or partial.
   subroutine add_numbered_files(names, begin, ending, digits, former)
      character(len=*), intent(in) :: names(:)           !! Names in the folder
      character(len=*), intent(in) :: begin              !! Prefix
      character(len=*), intent(in) :: ending             !! Suffix
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
            call add_file(names, trim(names(n)), former)
      end do
   end subroutine add_numbered_files

   !> True for the name of a partial file.
   pure logical function is_part(name) result(partial)
      character(len=*), intent(in) :: name               !! Name of a file

      partial = index(name, part, back=.true.) > max(len(name) - len(part), 0)
   end function is_part

   !> True if a complete file was found.
   pure logical function has_whole_file(former) result(has)
      type(former_run_t), intent(in) :: former
      integer :: n

      has = .false.
      do n = 1, size(former%files)
         has = has .or. .not. is_part(former%files(n)%text)
      end do
   end function has_whole_file

   !> Add a file if it exists and is not in the list.
   subroutine add_file(names, name, former)
      character(len=*), intent(in) :: names(:)           !! Names in the folder
      character(len=*), intent(in) :: name
      type(former_run_t), intent(inout) :: former        !! Gets the file
      integer :: n

      if (.not. any(names == name)) return
      do n = 1, size(former%files)
         if (former%files(n)%text == name) return
      end do
      call append(former%files, name)
   end subroutine add_file

   !> Remove the files of a previous run.
   subroutine remove_former_run(folder, former, error)
      character(len=*), intent(in) :: folder             !! Folder of the results
      type(former_run_t), intent(in) :: former           !! Files found
      type(error_t), allocatable, intent(out) :: error   !! One cannot be removed
      integer :: n

      do n = 1, size(former%files)
         call remove_file(join_path(folder, former%files(n)%text), error)
         if (allocated(error)) return
      end do
   end subroutine remove_former_run

   !> True if a checkpoint is one of those that this case writes.
   logical function is_own_checkpoint(folder, case, path) result(own)
      character(len=*), intent(in) :: folder             !! Folder of the results
      character(len=*), intent(in) :: case               !! Prefix of all files
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: place

      place = real_path(path)
      own = index(place, real_path(join_path(folder, "."))//"/"//case//"_chk_") == 1
   end function is_own_checkpoint
end module output_former_run
