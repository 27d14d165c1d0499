! SPDX-License-Identifier: BSD-3-Clause
!> Walls of a scene as a VTKHDF file, for ParaView and for pictures: the boundaries with their
!! types and the surfaces of rigid regions.
module io_walls
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int32, int64, wp
   use deck_units, only: system_si
   use io_hdf5, only: hdf5_file_t
   use io_hdf5_write, only: rows_of_root, rows_t, write_bytes, write_data, write_names
   use io_snapshot, only: snapshot_header_t, write_provenance, write_units
   implicit none
   private

   public :: walls_t, walls_write

   character(len=*), parameter :: root = "/VTKHDF"       !! Group that viewers read
   character(len=*), parameter :: group = "/walls"       !! Names and types of the walls
   integer, parameter, public :: wall_name_length = 96   !! Longest name of a wall
   real(wp), parameter, public :: never = 1.0e30_wp      !! Stands for infinite time [s]
   integer, parameter :: cell_types(4) = [1, 3, 5, 9]    !! VTK vertex, line, triangle, quad

   !> Walls. The same on all ranks.
   type :: walls_t
      real(wp), allocatable :: point(:, :)               !! (3, point) [m]
      integer, allocatable :: corners(:)                 !! (cell) Corners of the cell, in order
      integer, allocatable :: wall(:)                    !! (cell) Wall of the cell, from 1
      character(len=wall_name_length), allocatable :: name(:) !! (wall) Region, or face
      character(len=wall_name_length), allocatable :: kind(:) !! (wall) Type of boundary
      integer, allocatable :: face(:)                    !! (wall) 1 to 6, 0 = rigid region
      real(wp), allocatable :: begin(:)                  !! (wall) Start of the time interval [s]
      real(wp), allocatable :: end(:)                    !! (wall) End of the time interval [s]
      real(wp), allocatable :: time(:)                   !! (entry) If any moves: when [s]
      real(wp), allocatable :: shift(:, :, :)            !! (3, wall, entry) Displacement [m]
   contains
      procedure :: name_wall => walls_name_wall          !! Number of a wall, new or known
      procedure :: add => walls_add                      !! Add a cell
   end type walls_t

contains

   !> Number of the wall with a given name, type and time; a new wall if none exists. Each rigid
   !! region is a separate wall.
   pure subroutine walls_name_wall(self, name, kind, face, begin, end, wall)
      class(walls_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Region or face
      character(len=*), intent(in) :: kind               !! Type of boundary
      integer, intent(in) :: face                        !! 1 to 6, 0 = rigid region
      real(wp), intent(in) :: begin                      !! Start of the time interval [s]
      real(wp), intent(in) :: end                        !! End of the time interval [s]
      integer, intent(out) :: wall                       !! Number
      character(len=wall_name_length) :: padded

      if (.not. allocated(self%name)) allocate (self%name(0), self%kind(0), self%face(0), &
         self%begin(0), self%end(0), self%point(3, 0), self%corners(0), self%wall(0))
      do wall = 1, size(self%name)
         if (face == 0 .or. self%name(wall) /= name .or. self%kind(wall) /= kind) cycle
         if (abs(self%begin(wall) - begin) > 0.0_wp .or. abs(self%end(wall) - end) > 0.0_wp) cycle
         return
      end do
      padded = name
      self%name = [self%name, padded]
      padded = kind
      self%kind = [self%kind, padded]
      self%face = [self%face, face]
      self%begin = [self%begin, begin]
      self%end = [self%end, end]
   end subroutine walls_name_wall

   !> Add cells of one kind to a wall.
   pure subroutine walls_add(self, wall, piece)
      class(walls_t), intent(inout) :: self
      integer, intent(in) :: wall                        !! Index
      real(wp), intent(in) :: piece(:, :, :)             !! (3, corner, cell) [m]
      real(wp), allocatable :: longer(:, :)
      integer :: before, corner, n

      before = size(self%point, 2)
      allocate (longer(3, before + size(piece, 2)*size(piece, 3)))
      longer(:, :before) = self%point
      do n = 1, size(piece, 3)
         do corner = 1, size(piece, 2)
            longer(:, before + (n - 1)*size(piece, 2) + corner) = piece(:, corner, n)
         end do
      end do
      call move_alloc(longer, self%point)
      self%corners = [self%corners, spread(size(piece, 2), 1, size(piece, 3))]
      self%wall = [self%wall, spread(wall, 1, size(piece, 3))]
   end subroutine walls_add

   !> Write the walls. Collective.
   subroutine walls_write(communicator, path, walls, header, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path
      type(walls_t), intent(in) :: walls                 !! Walls to write
      type(snapshot_header_t), intent(in) :: header      !! Units and origin
      type(error_t), allocatable, intent(out) :: error   !! Not written; partial file removed
      type(hdf5_file_t) :: file

      call file%create(communicator, path, greatest_length(walls, header), error)
      if (allocated(error)) return
      call write_cells(file, walls, header)
      call write_table(file, walls, header)
      call write_provenance(file, header)
      call file%finish(error)
   end subroutine walls_write

   !> Greatest length that the file can get [byte].
   pure function greatest_length(walls, header) result(bytes)
      type(walls_t), intent(in) :: walls                 !! Walls to write
      type(snapshot_header_t), intent(in) :: header      !! Texts
      integer(int64) :: bytes
      integer(int64), parameter :: heading = 196608, point = 32, cell = 32, entry = 32

      bytes = heading + point*size(walls%point, 2) + cell*size(walls%wall) &
         + 3_int64*wall_name_length*size(walls%name)
      if (allocated(walls%time)) bytes = bytes + entry*size(walls%shift)
      if (allocated(header%deck)) bytes = bytes + len(header%deck)
      if (allocated(header%echo)) bytes = bytes + len(header%echo)
   end function greatest_length

   !> Write points and cells, with the numbers of wall and face as cell data.
   subroutine write_cells(file, walls, header)
      type(hdf5_file_t), intent(inout) :: file
      type(walls_t), intent(in) :: walls                 !! Walls to write
      type(snapshot_header_t), intent(in) :: header      !! Units
      type(rows_t) :: cells, points
      integer(int64), allocatable :: numbers(:)
      integer(int64) :: many(1)
      integer(int32), allocatable :: shorts(:)
      real(wp), allocatable :: place(:, :)
      character(len=:), allocatable :: letters
      integer :: n

      cells = rows_of_root(file%communicator, size(walls%wall))
      points = rows_of_root(file%communicator, size(walls%point, 2))
      call file%group(root)
      call file%attribute(root, "Version", [1_int32, 0_int32])
      call file%attribute(root, "Type", "UnstructuredGrid")
      many = size(walls%point, 2)
      call write_data(file, root//"/NumberOfPoints", rows_of_root(file%communicator, 1), many)
      call write_data(file, root//"/NumberOfConnectivityIds", rows_of_root(file%communicator, 1), &
         many)
      many = size(walls%wall)
      call write_data(file, root//"/NumberOfCells", rows_of_root(file%communicator, 1), many)
      place = walls%point
      if (header%units%system /= system_si) place(:, :) = header%units%shown(walls%point, "m")
      call write_data(file, root//"/Points", points, place)
      call write_units(file, root//"/Points", "position", "m", header%units)
      numbers = [(int(n - 1, int64), n=1, size(walls%point, 2))]
      call write_data(file, root//"/Connectivity", points, numbers)
      deallocate (numbers)
      allocate (numbers(size(walls%wall) + 1))
      numbers(1) = 0
      letters = repeat(" ", size(walls%wall))
      do n = 1, size(walls%wall)
         numbers(n + 1) = numbers(n) + walls%corners(n)
         letters(n:n) = achar(cell_types(walls%corners(n)))
      end do
      call write_data(file, root//"/Offsets", rows_of_root(file%communicator, size(numbers)), &
         numbers)
      call write_bytes(file, root//"/Types", cells, letters)
      call file%group(root//"/CellData")
      shorts = int(walls%wall, int32)
      call write_data(file, root//"/CellData/wall", cells, shorts)
      shorts = int(walls%face(walls%wall), int32)
      call write_data(file, root//"/CellData/face", cells, shorts)
   end subroutine write_cells

   !> Write kinds, time intervals and motions of the walls.
   subroutine write_table(file, walls, header)
      type(hdf5_file_t), intent(inout) :: file
      type(walls_t), intent(in) :: walls                 !! Walls to write
      type(snapshot_header_t), intent(in) :: header      !! Units
      type(rows_t) :: rows
      integer(int32), allocatable :: shorts(:)
      real(wp), allocatable :: numbers(:), ways(:, :)

      rows = rows_of_root(file%communicator, size(walls%name))
      call file%group(group)
      call write_names(file, group//"/name", walls%name)
      call write_names(file, group//"/type", walls%kind)
      shorts = int(walls%face, int32)
      call write_data(file, group//"/face", rows, shorts)
      numbers = header%units%shown(walls%begin, "s")
      call write_data(file, group//"/begin", rows, numbers)
      call write_units(file, group//"/begin", "begin", "s", header%units)
      numbers = header%units%shown(walls%end, "s")
      call write_data(file, group//"/end", rows, numbers)
      call write_units(file, group//"/end", "end", "s", header%units)
      if (.not. allocated(walls%time)) return
      numbers = header%units%shown(walls%time, "s")
      call write_data(file, group//"/time", rows_of_root(file%communicator, size(numbers)), numbers)
      call write_units(file, group//"/time", "time", "s", header%units)
      ways = header%units%shown(reshape(walls%shift, [3*size(walls%name), size(walls%time)]), "m")
      call write_data(file, group//"/shift", rows_of_root(file%communicator, size(numbers)), ways)
      call write_units(file, group//"/shift", "shift", "m", header%units)
   end subroutine write_table
end module io_walls
