! SPDX-License-Identifier: BSD-3-Clause
!> Snapshots of the particles as VTKHDF files, which ParaView opens.
!!
!! One part with one vertex cell per particle, for any number of ranks. Particles of a material that
!! lacks a field have 0.
module io_snapshot
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int32, int64, wp
   use deck_units, only: dimension_of, output_units_t, system_si
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use io_hdf5, only: hdf5_file_t
   use io_hdf5_write, only: data_bytes, rows_of_root, rows_t, write_bytes, write_data, write_names
   use io_level, only: even_chunks, level_integers, level_reals, level_rows
   use io_rows, only: store_rows
   use, intrinsic :: iso_fortran_env, only: real32
   use particle_store, only: store_t
   use sample_fields, only: choose_columns, column_t, fill_integers, fill_reals, picks_t
   use sample_fragments, only: labels_t
   use sample_pick, only: pick_rule_t
   implicit none
   private

   public :: rounded, snapshot_format_t, snapshot_header_t, snapshot_write, write_bodies, &
      write_provenance, write_units

   character(len=*), parameter :: root = "/VTKHDF"       !! Group that viewers read
   character(len=*), parameter :: about = "/provenance"  !! Origin of the file
   integer, parameter, public :: body_name_length = 64   !! Longest name of a body

   !> Format of a snapshot.
   type, extends(pick_rule_t) :: snapshot_format_t
      logical :: single = .true.                         !! Fields in single precision
      integer :: compress = 1                            !! gzip level, 0: off
   end type snapshot_format_t

   !> Content of a snapshot other than the particles. The same on all ranks. Texts that are not
   !! allocated and counts that are 0 are left out; without host, date, ranks, threads and wall time
   !! equal runs give equal bytes.
   ! Each component is an attribute of the file.
   type :: snapshot_header_t
      character(len=:), allocatable :: code              !! Name of the program
      character(len=:), allocatable :: version           !! Version of the program
      character(len=:), allocatable :: git               !! Revision of the sources
      character(len=:), allocatable :: compiler          !! Compiler and options of the program
      character(len=:), allocatable :: flags             !! Compiler flags of the program
      character(len=:), allocatable :: host              !! Host
      character(len=:), allocatable :: date              !! When the file was written
      character(len=:), allocatable :: case              !! Prefix of all files
      character(len=:), allocatable :: title             !! Line from the deck
      character(len=:), allocatable :: dimension         !! "3d", "axisymmetric", ...
      character(len=:), allocatable :: symmetry          !! Faces with mirrors, such as "xlo ylo"
      character(len=:), allocatable :: deck              !! Text of the deck
      character(len=:), allocatable :: echo              !! All keys with their values
      integer :: ranks = 0                               !! Ranks of the run
      integer :: threads = 0                             !! Threads of a rank
      real(wp) :: wall_seconds = 0.0_wp                  !! Wall time so far [s]
      real(wp) :: time = 0.0_wp                          !! Simulated time [s]
      real(wp) :: dt = 0.0_wp                            !! Time step [s]
      real(wp) :: dt_next = 0.0_wp                       !! Next stable time step [s]
      real(wp) :: velocity_lag = 0.0_wp                  !! Lag of velocities behind positions [s]
      integer(int64) :: step = 0                         !! Steps done
      !> (3, 4) In a cell that deforms: its deformation, and the fixed corner [m]
      real(wp), allocatable :: stretch(:, :)
      logical :: axisymmetric = .false.                  !! Points are (radius, 0, height)
      type(output_units_t) :: units                      !! Units of all data sets
      character(len=body_name_length), allocatable :: body_names(:) !! (body)
      integer, allocatable :: body_materials(:)          !! (body) Material of the body
      character(len=body_name_length), allocatable :: material_names(:) !! (material)
   end type snapshot_header_t

contains

   !> Write a snapshot. Collective.
   subroutine snapshot_write(communicator, path, stores, fields, format, header, error, labels)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path
      type(store_t), intent(in) :: stores(:)             !! Particles
      character(len=*), intent(in) :: fields(:)          !! Fields to write, ["default"]
      type(snapshot_format_t), intent(in) :: format      !! Format of the file
      type(snapshot_header_t), intent(in) :: header      !! Attributes of the file
      type(error_t), allocatable, intent(out) :: error   !! Not written; partial file removed
      type(labels_t), intent(in), optional :: labels(:)  !! (store) Fragments, 0 without them
      type(column_t), allocatable :: columns(:)
      type(picks_t), allocatable :: picks(:)
      type(hdf5_file_t) :: file
      type(rows_t) :: rows
      integer(int64) :: counts(size(stores))
      real(wp) :: times(1)
      integer :: index

      times = header%units%shown(header%time, "s")
      call choose_columns(stores, fields, columns, error)
      if (allocated(error)) return
      allocate (picks(size(stores)))
      do index = 1, size(stores)
         call format%pick(stores(index), picks(index)%order)
         if (present(labels)) picks(index)%fragment = labels(index)%fragment(picks(index)%order)
         counts(index) = size(picks(index)%order)
      end do
      rows = store_rows(communicator, counts, format%compress)
      call file%create(communicator, path, greatest_length(rows, columns, header), error)
      if (allocated(error)) return
      call write_cells(file, rows)
      call write_points(file, stores, picks, rows, header)
      call file%group(root//"/PointData")
      do index = 1, size(columns)
         call write_column(file, stores, picks, rows, columns(index), format%single, &
            header%units)
      end do
      call file%group(root//"/FieldData")
      call write_data(file, root//"/FieldData/TimeValue", rows_of_root(communicator, 1), times)
      call write_units(file, root//"/FieldData/TimeValue", "time", "s", header%units)
      call write_provenance(file, header)
      call write_bodies(file, header)
      call file%finish(error)
   end subroutine snapshot_write

   !> Greatest length that the file can get [byte].
   pure function greatest_length(rows, columns, header) result(bytes)
      type(rows_t), intent(in) :: rows
      type(column_t), intent(in) :: columns(:)           !! Fields of the snapshot
      type(snapshot_header_t), intent(in) :: header      !! Texts
      integer(int64) :: bytes
      integer(int64), parameter :: heading = 98304, number = 8, cell = 17, point = 24
      integer :: index

      bytes = heading + data_bytes(rows, point) + data_bytes(rows, cell)
      do index = 1, size(columns)
         bytes = bytes + data_bytes(rows, number*columns(index)%components)
      end do
      if (allocated(header%deck)) bytes = bytes + len(header%deck)
      if (allocated(header%echo)) bytes = bytes + len(header%echo)
      if (allocated(header%body_names)) &
         bytes = bytes + 2_int64*size(header%body_names)*(body_name_length + number)
   end function greatest_length

   !> Write the root with its counts, and one vertex cell for each point.
   subroutine write_cells(file, points)
      type(hdf5_file_t), intent(inout) :: file
      type(rows_t), intent(in) :: points
      type(rows_t) :: one, rows
      integer(int64) :: count(1), index
      integer(int64), allocatable :: numbers(:)

      call file%group(root)
      call file%attribute(root, "Version", [1_int32, 0_int32])
      call file%attribute(root, "Type", "UnstructuredGrid")
      one = rows_of_root(file%communicator, 1)
      count = points%total
      call write_data(file, root//"/NumberOfPoints", one, count)
      call write_data(file, root//"/NumberOfCells", one, count)
      call write_data(file, root//"/NumberOfConnectivityIds", one, count)
      rows = even_chunks(file%communicator, points%total + 1_int64, points%compress)
      allocate (numbers(rows%count(1)))
      do index = 1, rows%count(1)
         numbers(index) = rows%before(1) + index - 1_int64
      end do
      call write_data(file, root//"/Offsets", rows, numbers)
      deallocate (numbers)
      rows = even_chunks(file%communicator, points%total, points%compress)
      allocate (numbers(rows%count(1)))
      do index = 1, rows%count(1)
         numbers(index) = rows%before(1) + index - 1_int64
      end do
      call write_data(file, root//"/Connectivity", rows, numbers)
      call write_bytes(file, root//"/Types", rows, repeat(achar(1), int(rows%count(1))))
   end subroutine write_cells

   !> Write the positions.
   subroutine write_points(file, stores, picks, rows, header)
      type(hdf5_file_t), intent(inout) :: file
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(rows_t), intent(in) :: rows                   !! Rows of the particles
      type(snapshot_header_t), intent(in) :: header      !! Axes and units
      type(rows_t) :: even
      real(wp), allocatable :: points(:, :)
      integer :: filled, store

      allocate (points(3, sum(rows%count)))
      filled = 0
      do store = 1, size(stores)
         call fill_positions(stores(store), picks(store)%order, filled, points)
         filled = filled + size(picks(store)%order)
      end do
      if (header%axisymmetric) points(2, :) = 0.0_wp
      if (allocated(header%stretch)) call stretch_points(header%stretch, points)
      if (header%units%system /= system_si) points(:, :) = header%units%shown(points, "m")
      even = level_rows(file%communicator, rows)
      call level_reals(file%communicator, rows, even, points)
      call write_data(file, root//"/Points", even, points)
      call write_units(file, root//"/Points", "position", "m", header%units)
   end subroutine write_points

   !> Positions in space of those on the mesh of a cell that deforms.
   pure subroutine stretch_points(stretch, points)
      real(wp), intent(in) :: stretch(:, :)              !! (3, 4) Deformation [1] and corner [m]
      real(wp), contiguous, intent(inout) :: points(:, :) !! (component, row) [m]
      real(wp) :: x(3)
      integer :: row, k

      do row = 1, size(points, 2)
         x = points(:, row) - stretch(:, 4)
         do k = 1, 3
            points(k, row) = stretch(k, 4) + (stretch(k, 1)*x(1) + stretch(k, 2)*x(2) &
               + stretch(k, 3)*x(3))
         end do
      end do
   end subroutine stretch_points

   !> Copy the positions of some particles of a store.
   subroutine fill_positions(store, order, before, points)
      type(store_t), intent(in) :: store
      integer, contiguous, intent(in) :: order(:)        !! Indices of the particles
      integer, intent(in) :: before                      !! Rows before the first
      real(wp), contiguous, intent(inout) :: points(:, :) !! (component, row) [m]
      integer :: row

      !$omp parallel do default(none) shared(store, order, before, points) private(row) &
      !$omp schedule(static)
      do row = 1, size(order)
         points(1, before + row) = store%position(order(row), 1)
         points(2, before + row) = store%position(order(row), 2)
         points(3, before + row) = store%position(order(row), 3)
      end do
      !$omp end parallel do
   end subroutine fill_positions

   !> Write one field.
   subroutine write_column(file, stores, picks, rows, column, single, units)
      type(hdf5_file_t), intent(inout) :: file
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(rows_t), intent(in) :: rows                   !! Rows of the particles
      type(column_t), intent(in) :: column
      logical, intent(in) :: single                      !! In single precision
      type(output_units_t), intent(in) :: units          !! Units of the file
      type(rows_t) :: even
      character(len=:), allocatable :: name
      integer(int32), allocatable :: shorts(:)
      integer(int64), allocatable :: integers(:)
      real(wp), allocatable :: numbers(:), reals(:, :)

      name = root//"/PointData/"//trim(column%name)
      even = level_rows(file%communicator, rows)
      if (.not. column%is_real) then
         allocate (integers(sum(rows%count)))
         call fill_integers(stores, picks, column, integers)
         call level_integers(file%communicator, rows, even, integers)
         if (column%name == "identity") then
            call write_data(file, name, even, integers)
         else
            allocate (shorts(size(integers)))
            shorts(:) = int(integers, int32)
            call write_data(file, name, even, shorts)
         end if
      else
         allocate (reals(column%components, sum(rows%count)))
         call fill_reals(stores, picks, column, reals)
         if (units%system /= system_si) reals(:, :) = units%shown(reals, trim(column%unit))
         call level_reals(file%communicator, rows, even, reals)
         if (single) then
            call write_single(file, name, even, reals)
         else if (column%components == 1) then
            allocate (numbers(size(reals, 2)))
            numbers(:) = reals(1, :)
            call write_data(file, name, even, numbers)
         else
            call write_data(file, name, even, reals)
         end if
      end if
      call write_units(file, name, trim(column%name), trim(column%unit), units)
      if (column%components == 6) call file%attribute(name, "components", "xx yy zz xy yz xz")
      if (column%components == 9) call file%attribute(name, "components", &
         "xx yx zx xy yy zy xz yz zz")
   end subroutine write_column

   !> Write real numbers in single precision.
   subroutine write_single(file, name, rows, reals)
      type(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      type(rows_t), intent(in) :: rows                   !! Rows of this rank
      real(wp), intent(in) :: reals(:, :)                !! (component, row)
      real(real32), allocatable :: numbers(:), singles(:, :)
      integer :: component, row

      if (size(reals, 1) == 1) then
         allocate (numbers(size(reals, 2)))
         !$omp parallel do default(none) shared(numbers, reals) private(row) schedule(static)
         do row = 1, size(reals, 2)
            numbers(row) = rounded(reals(1, row))
         end do
         !$omp end parallel do
         call write_data(file, name, rows, numbers)
      else
         allocate (singles(size(reals, 1), size(reals, 2)))
         !$omp parallel do default(none) shared(singles, reals) private(row, component) &
         !$omp schedule(static)
         do row = 1, size(reals, 2)
            do component = 1, size(reals, 1)
               singles(component, row) = rounded(reals(component, row))
            end do
         end do
         !$omp end parallel do
         call write_data(file, name, rows, singles)
      end if
   end subroutine write_single

   !> The nearest number in single precision; values out of range become its limits.
   pure elemental function rounded(number) result(single)
      real(wp), intent(in) :: number                     !! Number
      real(real32) :: single
      real(wp), parameter :: most = real(huge(1.0_real32), wp)

      if (ieee_is_nan(number)) then
         single = ieee_value(single, ieee_quiet_nan)
      else
         single = real(max(-most, min(most, number)), real32)
      end if
   end function rounded

   !> Write the unit of a data set.
   subroutine write_units(file, name, long_name, unit, units)
      type(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      character(len=*), intent(in) :: long_name          !! With underscores for blanks
      character(len=*), intent(in) :: unit               !! SI unit
      type(output_units_t), intent(in) :: units          !! Units of the file
      character(len=:), allocatable :: words
      integer :: letter

      words = long_name
      do letter = 1, len(words)
         if (words(letter:letter) == "_") words(letter:letter) = " "
      end do
      call file%attribute(name, "units", units%label(unit))
      call file%attribute(name, "long_name", words)
      call file%attribute(name, "unitSI", units%factor(unit))
      if (units%system /= system_si) call file%attribute(name, "unitNameSI", unit)
      call file%attribute(name, "unitDimension", dimension_of(unit))
   end subroutine write_units

   !> Write the provenance of the file.
   subroutine write_provenance(file, header)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_header_t), intent(in) :: header      !! Header of the snapshot

      call file%group(about)
      call file%attribute(about, "schema", "scree-1")
      call write_fact(file, "code", header%code)
      call write_fact(file, "version", header%version)
      call write_fact(file, "git", header%git)
      call write_fact(file, "compiler", header%compiler)
      call write_fact(file, "flags", header%flags)
      call write_fact(file, "host", header%host)
      call write_fact(file, "date", header%date)
      call write_fact(file, "case", header%case)
      call write_fact(file, "title", header%title)
      call write_fact(file, "dimension", header%dimension)
      call write_fact(file, "symmetry", header%symmetry)
      if (header%ranks > 0) call file%attribute(about, "ranks", int(header%ranks, int64))
      if (header%threads > 0) call file%attribute(about, "threads", int(header%threads, int64))
      if (header%wall_seconds > 0.0_wp) call file%attribute(about, "wall_s", header%wall_seconds)
      call file%attribute(about, "step", header%step)
      call file%attribute(about, "time", header%time)
      call file%attribute(about, "dt", header%dt)
      call file%attribute(about, "dt_next", header%dt_next)
      call file%attribute(about, "velocity_lag", header%velocity_lag)
      call write_text(file, about//"/deck", header%deck)
      call write_text(file, about//"/deck_echo", header%echo)
   end subroutine write_provenance

   !> Write a text that may be missing as an attribute.
   subroutine write_fact(file, name, text)
      type(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Name of the attribute
      character(len=:), allocatable, intent(in) :: text  !! Value

      if (allocated(text)) call file%attribute(about, name, text)
   end subroutine write_fact

   !> Write a text that may be missing as a data set.
   subroutine write_text(file, name, text)
      type(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name               !! Path from the root
      character(len=:), allocatable, intent(in) :: text

      if (allocated(text)) &
         call write_bytes(file, name, rows_of_root(file%communicator, len(text)), text)
   end subroutine write_text

   !> Write the names of bodies and materials.
   subroutine write_bodies(file, header)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_header_t), intent(in) :: header      !! Names
      integer(int32), allocatable :: colours(:)
      integer :: body

      if (.not. allocated(header%body_names)) return
      call file%group("/bodies")
      call write_names(file, "/bodies/name", header%body_names)
      allocate (colours(size(header%body_names)))
      do body = 1, size(colours)
         colours(body) = body
      end do
      call write_data(file, "/bodies/colour", rows_of_root(file%communicator, size(colours)), &
         colours)
      if (allocated(header%body_materials)) call write_data(file, "/bodies/material", &
         rows_of_root(file%communicator, size(header%body_materials)), header%body_materials)
      if (allocated(header%material_names)) &
         call write_names(file, "/bodies/material_name", header%material_names)
   end subroutine write_bodies
end module io_snapshot
