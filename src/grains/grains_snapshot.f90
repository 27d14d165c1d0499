! SPDX-License-Identifier: BSD-3-Clause
!> Snapshots of a cell as VTKHDF files, which ParaView opens: the grains as points with a radius,
!! and the contacts as lines with a force.
module grains_snapshot
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int32, int64, wp
   use grains_cell, only: cell_t
   use grains_exchange, only: gather_rows
   use grains_histories, only: collect_records, record_words, share_records
   use grains_measures, only: count_contacts
   use grains_pairs, only: birth_strain, birth_time, dashpot_loss, overlap, pairs_t, push_branch, &
      push_force, slip_loss, slips
   use grains_state, only: grains_t
   use io_hdf5, only: hdf5_file_t
   use io_hdf5_write, only: rows_of_root, rows_t, write_bytes, write_data
   use io_snapshot, only: snapshot_header_t, write_provenance, write_units
   implicit none
   private

   public :: write_contacts, write_grains

   character(len=*), parameter :: root = "/VTKHDF"
   integer, parameter :: vertex = 1, line = 3        !! Types of cells in VTK
   integer, parameter :: contact_words = 15          !! Values per contact sent to all ranks

contains

   !> Write the grains. Collective.
   subroutine write_grains(cell, path, header, error)
      type(cell_t), intent(inout) :: cell            !! Not changed but for rows of other ranks
      character(len=*), intent(in) :: path
      type(snapshot_header_t), intent(in) :: header  !! Time, units, provenance
      type(error_t), allocatable, intent(out) :: error
      type(hdf5_file_t) :: file
      real(wp), allocatable :: points(:, :), flow(:, :), counts(:, :)
      integer :: row

      call gather_state(cell, counts)
      associate (grains => cell%grains)
         allocate (points(3, grains%count), flow(3, grains%count))
         do row = 1, grains%count
            points(:, row) = matmul(cell%box%edges, grains%place(:, row) - floor(grains%place(:, &
               row)))
            flow(:, row) = grains%velocity(:, row) + matmul(cell%box%gradient, points(:, row))
         end do
         if (cell%box%dimension == 2) points(3, :) = 0.0_wp
         call begin_file(cell, path, header, grains%count, grains%count, file, error)
         if (allocated(error)) return
         call write_points(file, header, points, vertex, 1)
         call file%group(root//"/PointData")
         call write_number(file, header, "radius", "m", grains%radius)
         call write_vector(file, header, "velocity", "m/s", flow)
         call write_vector(file, header, "fluctuation", "m/s", grains%velocity)
         call write_vector(file, header, "spin", "1/s", grains%spin)
         call write_number(file, header, "contacts", "1", counts(1, :))
         call write_number(file, header, "identity", "1", real(grains%identity, wp))
      end associate
      call end_file(cell, header, file, error)
   end subroutine write_grains

   !> Give all ranks the grains, and the contacts of each. Collective.
   subroutine gather_state(cell, counts)
      type(cell_t), intent(inout) :: cell
      real(wp), allocatable, intent(out) :: counts(:, :) !! (1, row)
      integer, allocatable :: contacts(:)

      associate (grains => cell%grains, c => cell%communicator)
         call gather_rows(c, grains%first, grains%last, grains%place)
         call gather_rows(c, grains%first, grains%last, grains%velocity)
         call gather_rows(c, grains%first, grains%last, grains%spin)
         allocate (counts(1, grains%count))
         call count_contacts(grains, cell%pairs, contacts)
         counts(1, grains%first:grains%last) = real(contacts, wp)
         call gather_rows(c, grains%first, grains%last, counts)
      end associate
   end subroutine gather_state

   !> Write the contacts: lines from centre to centre. Collective.
   subroutine write_contacts(cell, path, header, error)
      type(cell_t), intent(in) :: cell
      character(len=*), intent(in) :: path
      type(snapshot_header_t), intent(in) :: header  !! Time, units, provenance
      type(error_t), allocatable, intent(out) :: error
      type(hdf5_file_t) :: file
      real(wp), allocatable :: contacts(:, :), points(:, :)
      integer :: n, count

      call list_contacts(cell, contacts)
      count = size(contacts, 2)
      allocate (points(3, 2*count))
      do n = 1, count
         points(:, 2*n - 1) = contacts(1:3, n)
         points(:, 2*n) = contacts(1:3, n) + contacts(4:6, n)
      end do
      call begin_file(cell, path, header, 2*count, count, file, error)
      if (allocated(error)) return
      call write_points(file, header, points, line, 2)
      call file%group(root//"/CellData")
      call write_vector(file, header, "force", "N", contacts(7:9, :))
      call write_number(file, header, "normal_force", "N", contacts(10, :))
      call write_number(file, header, "overlap", "m", contacts(11, :))
      call write_number(file, header, "age", "s", cell%time - contacts(12, :))
      call write_number(file, header, "age_strain", "1", cell%box%strain - contacts(13, :))
      call write_number(file, header, "sliding", "1", contacts(14, :))
      call write_number(file, header, "lost_energy", "J", contacts(15, :))
      call end_file(cell, header, file, error)
   end subroutine write_contacts

   !> All contacts on all ranks: centre of the first grain, branch, force on the second one, normal
   !! force, overlap, birth in time and strain, sliding, energy lost. Collective.
   subroutine list_contacts(cell, contacts)
      type(cell_t), intent(in) :: cell
      real(wp), allocatable, intent(out) :: contacts(:, :)
      real(wp), allocatable :: own(:, :)
      real(wp) :: centre(3)
      integer(int64), allocatable :: words(:), whole(:)
      integer :: pair, n, i

      allocate (own(contact_words, cell%pairs%count))
      n = 0
      associate (grains => cell%grains, pairs => cell%pairs)
         do pair = 1, pairs%count
            i = pairs%first(pair)
            if (.not. pairs%touches(pair) .or. i < grains%first .or. i > grains%last) cycle
            n = n + 1
            centre = grains%place(:, i) - floor(grains%place(:, i))
            own(1:3, n) = matmul(cell%box%edges, centre)
            own(4:6, n) = pairs%push(push_branch:push_branch + 2, pair)
            own(7:9, n) = pairs%push(push_force:push_force + 2, pair)
            if (cell%box%dimension == 2) own([3, 6, 9], n) = 0.0_wp
            own(10, n) = dot_product(own(7:9, n), own(4:6, n))/norm2(own(4:6, n))
            own(11:, n) = [pairs%history([overlap, birth_time, birth_strain, slips], pair), &
               sum(pairs%history(dashpot_loss:slip_loss, pair))]
         end do
      end associate
      words = transfer(own(:, :n), words)
      call cell%communicator%gather(words, whole)
      allocate (contacts(contact_words, size(whole)/contact_words))
      contacts = reshape(transfer(whole, contacts), shape(contacts))
   end subroutine list_contacts

   !> Create a file with its counts. Collective.
   subroutine begin_file(cell, path, header, points, cells, file, error)
      type(cell_t), intent(in) :: cell
      character(len=*), intent(in) :: path
      type(snapshot_header_t), intent(in) :: header
      integer, intent(in) :: points, cells           !! Numbers of them
      type(hdf5_file_t), intent(inout) :: file
      type(error_t), allocatable, intent(out) :: error
      integer(int64), parameter :: heading = 131072, width = 256
      integer(int64) :: bytes

      bytes = heading + width*(points + cells)
      if (allocated(header%deck)) bytes = bytes + len(header%deck)
      if (allocated(header%echo)) bytes = bytes + len(header%echo)
      call file%create(cell%communicator, path, bytes, error)
      if (allocated(error)) return
      call file%group(root)
      call file%attribute(root, "Version", [1_int32, 0_int32])
      call file%attribute(root, "Type", "UnstructuredGrid")
   end subroutine begin_file

   !> Write points, and cells of one or two of them each.
   subroutine write_points(file, header, points, kind, each)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_header_t), intent(in) :: header
      real(wp), intent(in) :: points(:, :)           !! (axis, point) [m]
      integer, intent(in) :: kind                    !! Type of a cell in VTK
      integer, intent(in) :: each                    !! Points of a cell
      real(wp), allocatable :: shown(:, :)
      integer(int64) :: number(1), n, total

      total = size(points, 2)
      number = total
      call write_data(file, root//"/NumberOfPoints", rows_of_root(file%communicator, 1), number)
      call write_data(file, root//"/NumberOfConnectivityIds", &
         rows_of_root(file%communicator, 1), number)
      number = total/each
      call write_data(file, root//"/NumberOfCells", rows_of_root(file%communicator, 1), number)
      call write_data(file, root//"/Offsets", rows_of_root(file%communicator, &
         int(total/each) + 1), [(each*n, n=0, total/each)])
      call write_data(file, root//"/Connectivity", rows_of_root(file%communicator, int(total)), &
         [(n, n=0, total - 1)])
      call write_bytes(file, root//"/Types", rows_of_root(file%communicator, int(total/each)), &
         repeat(achar(kind), int(total/each)))
      shown = header%units%shown(points, "m")
      call write_data(file, root//"/Points", rows_of_root(file%communicator, int(total)), shown)
      call write_units(file, root//"/Points", "position", "m", header%units)
   end subroutine write_points

   !> Write a number of each point or cell.
   subroutine write_number(file, header, name, unit, values)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_header_t), intent(in) :: header
      character(len=*), intent(in) :: name, unit
      real(wp), intent(in) :: values(:)              !! [SI]
      character(len=:), allocatable :: path
      real(wp), allocatable :: shown(:)

      path = place_of(file, name)
      shown = values*header%units%shown(1.0_wp, unit)
      call write_data(file, path, rows_of_root(file%communicator, size(shown)), shown)
      call write_units(file, path, name, unit, header%units)
   end subroutine write_number

   !> Write a vector of each point or cell.
   subroutine write_vector(file, header, name, unit, values)
      type(hdf5_file_t), intent(inout) :: file
      type(snapshot_header_t), intent(in) :: header
      character(len=*), intent(in) :: name, unit
      real(wp), intent(in) :: values(:, :)           !! (axis, row) [SI]
      character(len=:), allocatable :: path
      real(wp), allocatable :: shown(:, :)

      path = place_of(file, name)
      shown = values*header%units%shown(1.0_wp, unit)
      call write_data(file, path, rows_of_root(file%communicator, size(shown, 2)), shown)
      call write_units(file, path, name, unit, header%units)
   end subroutine write_vector

   !> VTK location of a field: contacts are cells, grains are points.
   pure function place_of(file, name) result(path)
      type(hdf5_file_t), intent(in) :: file
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: path

      path = root//"/PointData/"//name
      if (index(file%path, "_contacts_") > 0) path = root//"/CellData/"//name
   end function place_of

   !> Write time, edges and provenance, and complete the file. Collective.
   subroutine end_file(cell, header, file, error)
      type(cell_t), intent(in) :: cell
      type(snapshot_header_t), intent(in) :: header
      type(hdf5_file_t), intent(inout) :: file
      type(error_t), allocatable, intent(out) :: error
      real(wp) :: times(1), edges(3, 3)

      times = header%units%shown(cell%time, "s")
      call file%attribute(root, "Time", times(1))
      edges = header%units%shown(cell%box%edges, "m")
      call file%group(root//"/FieldData")
      call write_data(file, root//"/FieldData/TimeValue", rows_of_root(file%communicator, 1), times)
      call write_units(file, root//"/FieldData/TimeValue", "time", "s", header%units)
      call write_data(file, root//"/FieldData/edges", rows_of_root(file%communicator, 3), edges)
      call write_units(file, root//"/FieldData/edges", "edges_of_the_cell", "m", header%units)
      call write_provenance(file, header)
      call file%finish(error)
   end subroutine end_file
end module grains_snapshot
