! SPDX-License-Identifier: BSD-3-Clause
!> Writes the index of a series: one small file with virtual data sets that refer to those of the
!! snapshots. Viewers with VTKHDF 2 open it as one data set in time. Written by one rank.
module io_hdf5_index
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_file, only: name_of
   use base_kinds, only: int32, int64, wp
   use hdf5, only: h5dclose_f, h5dcreate_f, h5p_dataset_create_f, h5pclose_f, h5pcreate_f, &
      h5pset_obj_track_times_f, h5pset_virtual_f, h5s_select_set_f, h5sclose_f, &
      h5screate_simple_f, h5sselect_all_f, h5sselect_hyperslab_f, h5t_ieee_f32le, h5t_ieee_f64le, &
      h5t_std_i32le, h5t_std_i64le, h5t_std_u8le, hid_t, hsize_t
   use io_hdf5, only: hdf5_file_t
   use io_hdf5_read, only: data_info_t, hdf5_source_t
   use io_hdf5_write, only: rows_of_root, write_data
   implicit none
   private

   public :: read_snapshot_info, snapshot_info_t, write_index

   character(len=*), parameter :: root = "/VTKHDF"       !! Group that viewers read

   !> Contents of a snapshot.
   type :: snapshot_info_t
      character(len=:), allocatable :: path
      real(wp) :: time = 0.0_wp                          !! Simulated time [s]
      integer(int64) :: points = 0                       !! Number of particles
      type(data_info_t), allocatable :: fields(:)        !! Fields of the particles
   end type snapshot_info_t

contains

   !> Read the contents of a snapshot.
   subroutine read_snapshot_info(path, info, error, of_grid)
      character(len=*), intent(in) :: path
      type(snapshot_info_t), intent(out) :: info
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      logical, intent(in) :: of_grid                     !! True for a grid, false for particles
      type(hdf5_source_t) :: source
      real(wp) :: times(1)
      integer(int64) :: counts(1)

      counts = 0
      info%path = path
      call source%open(path, error)
      if (.not. allocated(error)) then
         if (of_grid) then
            call source%attribute(root, "Time", times(1), error)
         else
            call source%read(root//"/FieldData/TimeValue", 0_int64, times, error)
         end if
      end if
      if (.not. (allocated(error) .or. of_grid)) &
         call source%read(root//"/NumberOfPoints", 0_int64, counts, error)
      if (.not. (allocated(error) .or. of_grid)) &
         call source%members(root//"/PointData", info%fields, error)
      call source%close()
      if (allocated(error)) return
      info%time = times(1)
      info%points = counts(1)
      if (info%points >= 0 .and. abs(info%time) <= huge(1.0_wp)) return
      call fail(error, exit_file, &
         path//" is damaged: its time is not finite or its number of particles is negative [F108]")
   end subroutine read_snapshot_info

   !> Write the index of a series. Fields that not all snapshots have are left out.
   subroutine write_index(path, steps, error)
      character(len=*), intent(in) :: path
      type(snapshot_info_t), intent(in) :: steps(:)      !! The snapshots, in order
      type(error_t), allocatable, intent(out) :: error   !! Cannot be written
      integer(int64), parameter :: base_bytes = 1048576, bytes_per_step = 8192
      type(communicator_t) :: alone
      type(hdf5_file_t) :: file
      integer(int64), allocatable :: counts(:), starts(:)
      integer :: step

      call file%create(alone, path, base_bytes + bytes_per_step*size(steps), error)
      if (allocated(error)) return
      allocate (counts(size(steps)), starts(size(steps)))
      do step = 1, size(steps)
         counts(step) = steps(step)%points
         starts(step) = sum(counts(:step - 1))
      end do
      call file%group(root)
      call file%attribute(root, "Version", [2_int32, 0_int32])
      call file%attribute(root, "Type", "UnstructuredGrid")
      call write_numbers(file, root//"/NumberOfPoints", counts)
      call write_numbers(file, root//"/NumberOfCells", counts)
      call write_numbers(file, root//"/NumberOfConnectivityIds", counts)
      call write_window(file, steps, "Points", plain("Points", 3, .true., 8), 0)
      call write_window(file, steps, "Connectivity", plain("Connectivity", 1, .false., 8), 0)
      call write_window(file, steps, "Offsets", plain("Offsets", 1, .false., 8), 1)
      call write_window(file, steps, "Types", plain("Types", 1, .false., 1), 0)
      call write_fields(file, steps)
      call write_steps(file, steps, starts)
      call file%finish(error)
   end subroutine write_index

   !> Description of a data set that is not a field.
   pure function plain(name, components, is_real, bytes) result(info)
      character(len=*), intent(in) :: name               !! Name
      integer, intent(in) :: components                  !! Number of components of a row
      logical, intent(in) :: is_real                     !! Real, not integer
      integer, intent(in) :: bytes                       !! Bytes of a value
      type(data_info_t) :: info

      info%name = name
      info%components = components
      info%dimensions = merge(1, 2, components == 1)
      info%is_real = is_real
      info%bytes = bytes
   end function plain

   !> Write the fields that all snapshots have in the same form.
   subroutine write_fields(file, steps)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_info_t), intent(in) :: steps(:)
      integer :: field

      call file%group(root//"/PointData")
      do field = 1, size(steps(1)%fields)
         if (everywhere(steps, steps(1)%fields(field))) call write_window(file, steps, &
            "PointData/"//trim(steps(1)%fields(field)%name), steps(1)%fields(field), 0)
      end do
   end subroutine write_fields

   !> True if all snapshots have a field in the same form.
   pure logical function everywhere(steps, field) result(found)
      type(snapshot_info_t), intent(in) :: steps(:)
      type(data_info_t), intent(in) :: field
      integer :: step

      found = .true.
      do step = 1, size(steps)
         associate (fields => steps(step)%fields)
            found = found .and. any(fields%name == field%name .and. &
               (fields%is_real .eqv. field%is_real) .and. fields%bytes == field%bytes .and. &
               fields%components == field%components)
         end associate
      end do
   end function everywhere

   !> Write the times and the offsets of each time.
   subroutine write_steps(file, steps, starts)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_info_t), intent(in) :: steps(:)
      integer(int64), contiguous, intent(in) :: starts(:) !! (snapshot) Points of earlier ones
      character(len=*), parameter :: group = root//"/Steps"
      integer(int64) :: numbers(size(steps)), column(1, size(steps))
      real(wp) :: times(size(steps))
      integer :: field, step

      do step = 1, size(steps)
         times(step) = steps(step)%time
         numbers(step) = step - 1
      end do
      column(1, :) = starts
      call file%group(group)
      call file%attribute(group, "NSteps", int(size(steps), int64))
      call write_data(file, group//"/Values", rows_of_root(file%communicator, size(steps)), times)
      call write_numbers(file, group//"/PartOffsets", numbers)
      numbers = 1
      call write_numbers(file, group//"/NumberOfParts", numbers)
      call write_numbers(file, group//"/PointOffsets", starts)
      call write_column(file, group//"/CellOffsets", column)
      call write_column(file, group//"/ConnectivityIdOffsets", column)
      call file%group(group//"/PointDataOffsets")
      do field = 1, size(steps(1)%fields)
         if (everywhere(steps, steps(1)%fields(field))) call write_numbers(file, group// &
            "/PointDataOffsets/"//trim(steps(1)%fields(field)%name), starts)
      end do
   end subroutine write_steps

   !> Write a row of integers.
   subroutine write_numbers(file, name, numbers)
      type(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      integer(int64), contiguous, intent(in) :: numbers(:)

      call write_data(file, name, rows_of_root(file%communicator, size(numbers)), numbers)
   end subroutine write_numbers

   !> Write a column of integers, one a row.
   subroutine write_column(file, name, numbers)
      type(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      integer(int64), contiguous, intent(in) :: numbers(:, :) !! (1, row)

      call write_data(file, name, rows_of_root(file%communicator, size(numbers, 2)), numbers)
   end subroutine write_column

   !> Write a virtual data set that joins those of all snapshots.
   subroutine write_window(file, steps, name, info, extra)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_info_t), intent(in) :: steps(:)
      character(len=*), intent(in) :: name               !! From the group that viewers read
      type(data_info_t), intent(in) :: info              !! Its form
      integer, intent(in) :: extra                       !! Rows beyond those of the points
      integer(hid_t) :: data_set, piece, plan, space
      integer(hsize_t) :: extent(2), rows(2), start(2)
      integer :: dimensions, ignored, status, step

      if (.not. file%works()) return
      dimensions = info%dimensions
      rows = info%components
      start = 0
      extent = info%components
      extent(dimensions) = sum(steps%points) + int(extra, int64)*size(steps)
      call h5screate_simple_f(dimensions, extent(:dimensions), space, status)
      call h5pcreate_f(h5p_dataset_create_f, plan, status)
      call h5pset_obj_track_times_f(plan, .false., status)
      do step = 1, size(steps)
         rows(dimensions) = steps(step)%points + extra
         if (rows(dimensions) == 0) cycle
         call h5screate_simple_f(dimensions, rows(:dimensions), piece, status)
         call h5sselect_hyperslab_f(space, h5s_select_set_f, start(:dimensions), &
            rows(:dimensions), status)
         call h5pset_virtual_f(plan, space, name_of(steps(step)%path), root//"/"//name, piece, &
            status)
         call h5sclose_f(piece, ignored)
         start(dimensions) = start(dimensions) + rows(dimensions)
      end do
      call h5sselect_all_f(space, status)
      call h5dcreate_f(file%id, root//"/"//name, type_of(info), space, data_set, status, &
         dcpl_id=plan)
      if (status >= 0) call h5dclose_f(data_set, ignored)
      call h5pclose_f(plan, ignored)
      call h5sclose_f(space, ignored)
      call file%share_status("cannot write", root//"/"//name, status)
   end subroutine write_window

   !> HDF5 type of a data set.
   integer(hid_t) function type_of(info) result(kind)
      type(data_info_t), intent(in) :: info              !! Its form

      if (info%is_real) then
         kind = h5t_ieee_f64le
         if (info%bytes == 4) kind = h5t_ieee_f32le
      else
         kind = h5t_std_i64le
         if (info%bytes == 4) kind = h5t_std_i32le
         if (info%bytes == 1) kind = h5t_std_u8le
      end if
   end function type_of
end module io_hdf5_index
