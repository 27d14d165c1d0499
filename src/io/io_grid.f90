! SPDX-License-Identifier: BSD-3-Clause
!> Fields on the cells of the grid as VTKHDF ImageData, which ParaView opens: only the smallest
!! block of cells that holds all material is written.
!!
!! The points of the image are the middles of cells. VTK 9.2, and so ParaView 5.11, cannot read the
!! following parts of the format: data of cells, data of the whole field, such as the time, and
!! images without thickness. So times are in the series and in /provenance, and a single layer of
!! cells has points on its two faces. Ranks send their cells to the owners of the planes of the box,
!! so no rank holds all of it.
module io_grid
   use base_communicator, only: communicator_t
   use base_constants, only: pi
   use base_error, only: error_t
   use base_kinds, only: int32, int64, wp
   use deck_units, only: output_units_t
   use io_hdf5, only: hdf5_file_t
   use io_hdf5_write, only: chunk_rows, data_bytes, rows_t, write_planes
   use io_level, only: even_chunks, owner_of
   use io_snapshot, only: rounded, snapshot_format_t, snapshot_header_t, write_bodies, &
      write_provenance, write_units
   use, intrinsic :: iso_fortran_env, only: real32
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use sample_cells, only: cells_t, find_cells
   use sample_fields, only: picks_t
   use sample_means, only: added, by_volume, fill_mean, mean_t, volume_fraction
   implicit none
   private

   public :: grid_write

   character(len=*), parameter :: root = "/VTKHDF"       !! Group that viewers read

   !> A block of cells, and its planes written by one rank.
   type :: box_t
      integer :: first(3) = 0                            !! First cell, from 0
      logical :: layer(3) = .false.                      !! Is there one layer of cells?
      integer :: extent(3) = 1                           !! Points along each direction
      type(rows_t) :: planes                             !! Planes across z
   end type box_t

contains

   !> Write one file. Collective.
   subroutine grid_write(communicator, path, grid, tiles, stores, means, format, header, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)     !! (3, tile) Tiles of this rank, from 0
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(mean_t), intent(in) :: means(:)               !! Means to write
      type(snapshot_format_t), intent(in) :: format      !! How, and of which particles
      type(snapshot_header_t), intent(in) :: header      !! Attributes of the file
      type(error_t), allocatable, intent(out) :: error   !! Not written; partial file removed
      type(picks_t), allocatable :: picks(:)
      type(cells_t) :: cells
      type(box_t) :: box
      type(hdf5_file_t) :: file
      real(wp), allocatable :: values(:, :)
      integer :: n

      allocate (picks(size(stores)))
      do n = 1, size(stores)
         call format%pick(stores(n), picks(n)%order)
      end do
      call find_cells(grid, tiles, stores, picks, cells)
      call find_box(communicator, cells, format%compress, box)
      call file%create(communicator, path, greatest_length(box, means, header), error)
      if (allocated(error)) return
      call write_frame(file, grid, box, header)
      call file%group(root//"/PointData")
      do n = 1, size(means)
         call cell_means(grid, stores, picks, cells, means(n), values)
         values(:, :) = header%units%shown(values, trim(means(n)%column%unit))
         call write_field(file, box, cells, means(n), values, format%single, header%units)
      end do
      call write_provenance(file, header)
      call write_bodies(file, header)
      call file%finish(error)
   end subroutine grid_write

   !> The smallest block around the cells of all ranks, and the rank that writes each plane.
   subroutine find_box(communicator, cells, compress, box)
      type(communicator_t), intent(in) :: communicator
      type(cells_t), intent(in) :: cells                 !! Part of this rank
      integer, intent(in) :: compress                    !! gzip level
      type(box_t), intent(out) :: box
      integer(int64) :: edges(6)

      edges = huge(edges)
      if (cells%count > 0) edges = [minval(cells%place, dim=2), -maxval(cells%place, dim=2)]
      call communicator%least(edges)
      ! without material one empty cell is written
      if (edges(1) == huge(edges)) edges = 0
      box%first = int(edges(:3))
      box%extent = int(-edges(4:) - edges(:3)) + 1
      box%layer = box%extent == 1
      where (box%layer) box%extent = 2
      ! the two points of a layer must be on the same rank
      box%planes = even_chunks(communicator, int(box%extent(3), int64), compress, &
         max(chunk_rows/product(int(box%extent(:2), int64)), &
         merge(2_int64, 1_int64, box%layer(3))))
   end subroutine find_box

   !> Greatest length that the file can get [byte].
   pure function greatest_length(box, means, header) result(bytes)
      type(box_t), intent(in) :: box
      type(mean_t), intent(in) :: means(:)               !! Their fields
      type(snapshot_header_t), intent(in) :: header      !! Texts
      integer(int64) :: bytes
      integer(int64), parameter :: heading = 131072, number = 8
      integer :: n

      bytes = heading
      do n = 1, size(means)
         bytes = bytes + data_bytes(box%planes, number*means(n)%column%components &
            *product(int(box%extent(:2), int64)))
      end do
      if (allocated(header%deck)) bytes = bytes + len(header%deck)
      if (allocated(header%echo)) bytes = bytes + len(header%echo)
      if (allocated(header%body_names)) bytes = bytes &
         + 2_int64*size(header%body_names)*(len(header%body_names) + number)
   end function greatest_length

   !> Write origin and spacing of the cells.
   subroutine write_frame(file, grid, box, header)
      type(hdf5_file_t), intent(inout) :: file
      type(grid_t), intent(in) :: grid
      type(box_t), intent(in) :: box
      type(snapshot_header_t), intent(in) :: header      !! Time and units
      real(wp), parameter :: straight(9) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 1.0_wp]
      real(wp) :: origin(3), spacing(3), first(3)

      spacing = grid%spacing
      where (.not. grid%active) spacing = grid%upper - grid%lower
      origin = grid%lower
      if (grid%axisymmetric) then
         ! the half plane of an axis has no thickness
         spacing(2) = grid%spacing
         origin(2) = -0.5_wp*grid%spacing
      end if
      call file%group(root)
      call file%attribute(root, "Version", [1_int32, 0_int32])
      call file%attribute(root, "Type", "ImageData")
      call file%attribute(root, "WholeExtent", [0_int32, int(box%extent(1) - 1, int32), 0_int32, &
         int(box%extent(2) - 1, int32), 0_int32, int(box%extent(3) - 1, int32)])
      first = real(box%first, wp) + merge(0.0_wp, 0.5_wp, box%layer)
      origin = origin + first*spacing
      call file%attribute(root, "Origin", header%units%shown(origin, "m"))
      call file%attribute(root, "Spacing", header%units%shown(spacing, "m"))
      call file%attribute(root, "Direction", straight)
      call file%attribute(root, "units", header%units%label("m"))
      call file%attribute(root, "unitSI", header%units%factor("m"))
      call file%attribute(root, "Time", header%units%shown(header%time, "s"))
   end subroutine write_frame

   !> Means of one field over the particles of each cell.
   subroutine cell_means(grid, stores, picks, cells, mean, values)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(cells_t), intent(in) :: cells                 !! Their cells
      type(mean_t), intent(in) :: mean
      real(wp), allocatable, intent(out) :: values(:, :) !! (component, cell)
      real(wp), allocatable :: rows(:, :), weight(:), total(:, :)
      type(mean_t) :: other
      integer :: cell

      allocate (values(mean%column%components, cells%count), total(1, cells%count))
      other = mean
      select case (mean%column%name)
      case ("density", volume_fraction)
         ! content of a cell over its volume
         other%column%derived = .false.
         other%column%name = merge("mass  ", "volume", mean%column%name == "density")
         call fill_mean(stores, picks, other%column, rows)
         allocate (weight(size(rows, 2)), source=1.0_wp)
         call cells%sum(rows, weight, values)
         do cell = 1, cells%count
            values(:, cell) = values(:, cell)/cell_volume(grid, cells%place(:, cell))
         end do
      case default
         call particle_weights(stores, picks, mean%weight, weight)
         call fill_mean(stores, picks, mean%column, rows)
         call cells%sum(rows, weight, values)
         if (mean%weight == added) return
         rows = reshape(weight, [1, size(weight)])
         weight = 1.0_wp
         call cells%sum(rows, weight, total)
         do cell = 1, cells%count
            values(:, cell) = values(:, cell)/total(1, cell)
         end do
      end select
   end subroutine cell_means

   !> Weight of each particle in a mean.
   subroutine particle_weights(stores, picks, kind, weight)
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      integer, intent(in) :: kind                        !! added, by_mass, by_volume
      real(wp), allocatable, intent(out) :: weight(:)    !! (row)
      integer :: filled, row, store

      filled = 0
      do store = 1, size(stores)
         filled = filled + size(picks(store)%order)
      end do
      allocate (weight(filled), source=1.0_wp)
      if (kind == added) return
      filled = 0
      do store = 1, size(stores)
         do row = 1, size(picks(store)%order)
            associate (p => picks(store)%order(row), state => stores(store)%state)
               if (kind == by_volume) then
                  weight(filled + row) = state%volume(p)
               else
                  weight(filled + row) = state%mass(p)
               end if
            end associate
         end do
         filled = filled + size(picks(store)%order)
      end do
   end subroutine particle_weights

   !> Volume of a cell [m3]; that of the ring in axisymmetry.
   pure real(wp) function cell_volume(grid, place) result(volume)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: place(3)                    !! The cell, from 0

      volume = grid%depth*grid%spacing**grid%dimensions
      if (grid%axisymmetric) volume = 2.0_wp*pi*grid%spacing**2 &
         *(grid%lower(1) + (real(place(1), wp) + 0.5_wp)*grid%spacing)
   end function cell_volume

   !> Write one field: send the cells to the owners of their planes; cells without particles have 0.
   subroutine write_field(file, box, cells, mean, values, single, units)
      type(hdf5_file_t), intent(inout) :: file
      type(box_t), intent(in) :: box                     !! All cells of the file
      type(cells_t), intent(in) :: cells                 !! Part of this rank
      type(mean_t), intent(in) :: mean
      real(wp), intent(in) :: values(:, :)               !! (component, cell)
      logical, intent(in) :: single                      !! In single precision
      type(output_units_t), intent(in) :: units          !! Units of the file
      real(wp), allocatable :: dense(:, :)
      real(real32), allocatable :: short(:, :)
      integer, allocatable :: inner(:)
      character(len=:), allocatable :: name

      name = root//"/PointData/"//trim(mean%column%name)
      inner = box%extent(:2)
      if (mean%column%components > 1) inner = [mean%column%components, inner]
      call send_planes(file%communicator, box, cells, values, dense)
      if (single) then
         allocate (short(size(dense, 1), size(dense, 2)))
         short(:, :) = rounded(dense)
         call write_planes(file, name, box%planes, inner, short)
      else
         call write_planes(file, name, box%planes, inner, dense)
      end if
      call write_units(file, name, trim(mean%column%name), trim(mean%column%unit), units)
      if (mean%column%components == 6) &
         call file%attribute(name, "components", "xx yy zz xy yz xz")
   end subroutine write_field

   !> Send the values of cells to the ranks that write their planes. Collective.
   subroutine send_planes(communicator, box, cells, values, dense)
      type(communicator_t), intent(in) :: communicator
      type(box_t), intent(in) :: box                     !! All cells of the file
      type(cells_t), intent(in) :: cells                 !! Part of this rank
      real(wp), intent(in) :: values(:, :)               !! (component, cell)
      real(wp), allocatable, intent(out) :: dense(:, :)  !! (component and cell of a plane, plane)
      type(communicator_t) :: ranks
      integer(int64), allocatable :: outgoing(:, :), incoming(:)
      integer, allocatable :: rank(:)
      integer :: n, parts, words, place(3), at, row

      parts = size(values, 1)
      words = 2 + parts
      allocate (rank(cells%count), outgoing(words, cells%count))
      do n = 1, cells%count
         place = cells%place(:, n) - box%first
         rank(n) = owner_of(communicator, box%planes, int(place(3), int64))
         outgoing(1, n) = place(1) + box%extent(1)*place(2)
         outgoing(2, n) = place(3)
         outgoing(3:, n) = transfer(values(:, n), outgoing, parts)
      end do
      ranks = communicator
      call ranks%send_rows(rank, outgoing, incoming)
      allocate (dense(parts*product(box%extent(:2)), box%planes%count(1)), source=0.0_wp)
      do at = 0, size(incoming) - words, words
         row = int(incoming(at + 2) - box%planes%before(1)) + 1
         associate (first => parts*int(incoming(at + 1)))
            dense(first + 1:first + parts, row) = transfer(incoming(at + 3:at + words), dense, &
               parts)
         end associate
      end do
      call copy_layers(box, parts, dense)
   end subroutine send_planes

   !> For a single layer of cells copy the values to the points of its other face.
   pure subroutine copy_layers(box, parts, dense)
      type(box_t), intent(in) :: box                     !! All cells of the file
      integer, intent(in) :: parts                       !! Components
      real(wp), intent(inout) :: dense(:, :)             !! (component and cell of a plane, plane)
      integer :: line, row, n

      line = parts*box%extent(1)
      do row = 1, size(dense, 2)
         if (box%layer(1)) then
            do n = 0, box%extent(2) - 1
               dense(n*line + parts + 1:(n + 1)*line, row) = dense(n*line + 1:n*line + parts, row)
            end do
         end if
         if (box%layer(2)) dense(line + 1:, row) = dense(:line, row)
      end do
      if (box%layer(3) .and. size(dense, 2) == 2) dense(:, 2) = dense(:, 1)
   end subroutine copy_layers
end module io_grid
