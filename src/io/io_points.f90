! SPDX-License-Identifier: BSD-3-Clause
!> Reads lists of points: CSV texts with one line per point, or snapshots of particles of another
!! run.
module io_points
   use base_decimal, only: file_number
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: int64, wp
   use base_text, only: append, closest, line_end, number, shortened, text_t
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use io_hdf5_read, only: data_info_t, hdf5_source_t
   implicit none
   private

   public :: data_group, factor_of, point_list_t, read_point_text, read_snapshot

   character(len=*), parameter :: root = "/VTKHDF"       !! Group of the particles in a snapshot
   character(len=*), parameter :: data_group = root//"/PointData" !! Group of their fields
   character(len=8), parameter :: columns(8) = [character(len=8) :: "x", "y", "z", "volume", "vx", &
      "vy", "vz", "material"]
   integer, parameter :: shown = 40                      !! Characters of a wrong line in a message

   !> Points of a list. Values of a text are in the units of the text, values of a snapshot in SI.
   type :: point_list_t
      real(wp), allocatable :: position(:, :)            !! (3, row)
      real(wp), allocatable :: volume(:)                 !! (row) If given
      real(wp), allocatable :: velocity(:, :)            !! (3, row) If given; of texts only
      integer, allocatable :: line(:)                    !! (row) Line of a text
      integer(int64), allocatable :: material(:)         !! (row) Index of the name, if given
      type(text_t), allocatable :: material_names(:)     !! Names of materials
      integer(int64), allocatable :: body(:)             !! (row) Index of the name, if given
      type(text_t), allocatable :: body_names(:)         !! Names of bodies
      type(text_t), allocatable :: fields(:)             !! Other fields of a snapshot
      real(wp) :: lag = 0.0_wp                           !! Lag of velocities behind positions [s]
      real(wp) :: dt_next = 0.0_wp                       !! Next time step of its run, or 0 [s]
   end type point_list_t

contains

   !> Make the error message on a file.
   subroutine fail_reading(error, path, what)
      type(error_t), allocatable, intent(out) :: error
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: what               !! Error message

      call fail(error, exit_file, "cannot read the points of '"//path//"': "//what//" [F115]")
   end subroutine fail_reading

   !> Parse the points of a text. Empty lines and lines that begin with # are skipped.
   subroutine read_point_text(text, path, list, error)
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: path               !! For messages
      type(point_list_t), intent(out) :: list
      type(error_t), allocatable, intent(out) :: error   !! A line is not valid
      type(text_t), allocatable :: words(:)
      integer, allocatable :: column(:)
      character(len=:), allocatable :: line, fault
      integer :: row, lines, first, last

      allocate (list%material_names(0), list%body_names(0), list%fields(0))
      lines = 0
      row = 0
      first = 1
      do while (first <= len(text))
         last = line_end(text, first)
         line = plain(text(first:last))
         first = last + 2
         lines = lines + 1
         if (line == "" .or. index(adjustl(line), "#") == 1) cycle
         call cells_of(line, words)
         if (.not. allocated(column)) then
            call read_heading(words, column, fault)
            if (fault == "") call allocate_rows(text, column, list)
         else
            row = row + 1
            call read_row(words, column, row, list, fault)
            if (fault == "") list%line(row) = lines
         end if
         if (fault /= "") then
            call fail_reading(error, path, "line "//number(lines)//": "//fault)
            return
         end if
      end do
      if (row == 0) then
         call fail_reading(error, path, "it has no points; its first line must be such as "// &
            "x,y,z,volume, and each further line a point")
         return
      end if
      call trim_rows(list, row)
   end subroutine read_point_text

   !> A line without tabs and carriage returns.
   pure function plain(line) result(clean)
      character(len=*), intent(in) :: line               !! Value
      character(len=len(line)) :: clean
      integer :: n

      do n = 1, len(line)
         clean(n:n) = merge(" ", line(n:n), iachar(line(n:n)) < iachar(" "))
      end do
   end function plain

   !> Split a line at its commas.
   pure subroutine cells_of(line, words)
      character(len=*), intent(in) :: line               !! A line
      type(text_t), allocatable, intent(out) :: words(:) !! Without leading and trailing blanks
      integer :: n, first, last

      allocate (words(1 + count([(line(n:n) == ",", n=1, len(line))])))
      first = 1
      do n = 1, size(words)
         last = first + index(line(first:)//",", ",") - 2
         words(n)%text = trim(adjustl(line(first:last)))
         first = last + 2
      end do
   end subroutine cells_of

   !> Find the columns by the names in the first line.
   subroutine read_heading(words, column, fault)
      type(text_t), intent(in) :: words(:)               !! Names
      integer, allocatable, intent(out) :: column(:)     !! (name) Number of its column, 0: none
      character(len=:), allocatable, intent(out) :: fault !! Error message, or empty
      type(text_t) :: known(size(columns))
      character(len=:), allocatable :: near
      integer :: n, k

      fault = ""
      allocate (column(size(columns)))
      column = 0
      do n = 1, size(words)
         do k = 1, size(columns)
            if (columns(k) /= words(n)%text) cycle
            if (column(k) > 0) fault = "the column '"//words(n)%text//"' is there twice"
            column(k) = n
            exit
         end do
         if (k <= size(columns)) cycle
         do k = 1, size(columns)
            known(k)%text = trim(columns(k))
         end do
         fault = "unknown column '"//shortened(words(n)%text, shown)//"'; there are x, y, z, "// &
            "volume, vx, vy, vz, material"
         near = closest(words(n)%text, known)
         if (near /= "") fault = fault//"; did you mean '"//near//"'?"
         return
      end do
      if (fault /= "") return
      if (any(column(:3) == 0)) then
         fault = "the first line must name the columns x, y, z"
      else if (any(column(5:7) == 0) .and. any(column(5:7) > 0)) then
         fault = "a velocity needs all of vx, vy, vz"
      end if
   end subroutine read_heading

   !> Allocate a row for each line of the text.
   subroutine allocate_rows(text, column, list)
      character(len=*), intent(in) :: text               !! Content of the file
      integer, intent(in) :: column(:)                   !! (name) Number of its column, 0: none
      type(point_list_t), intent(inout) :: list
      integer :: rows, n

      rows = 1
      do n = 1, len(text)
         if (text(n:n) == new_line("a")) rows = rows + 1
      end do
      allocate (list%position(3, rows), list%line(rows))
      if (column(4) > 0) allocate (list%volume(rows))
      if (column(5) > 0) allocate (list%velocity(3, rows))
      if (column(8) > 0) allocate (list%material(rows))
   end subroutine allocate_rows

   !> Parse one point.
   subroutine read_row(words, column, row, list, fault)
      type(text_t), intent(in) :: words(:)               !! Words of its line
      integer, intent(in) :: column(:)                   !! (name) Number of its column, 0: none
      integer, intent(in) :: row
      type(point_list_t), intent(inout) :: list
      character(len=:), allocatable, intent(out) :: fault !! Error message, or empty
      real(wp) :: values(7)
      integer :: k
      logical :: sound

      fault = ""
      if (size(words) /= count(column > 0)) then
         fault = "expected "//number(count(column > 0))//" columns as in the first line, not "// &
            number(size(words))
         return
      end if
      values = 0.0_wp
      do k = 1, 7
         if (column(k) == 0) cycle
         associate (word => words(column(k))%text)
            call file_number(word, values(k), sound)
            if (.not. sound) then
               fault = trim(columns(k))//" = '"//shortened(word, shown)//"' is not a number"
               return
            end if
         end associate
      end do
      list%position(:, row) = values(:3)
      if (column(5) > 0) list%velocity(:, row) = values(5:7)
      if (column(4) > 0) then
         list%volume(row) = values(4)
         if (.not. values(4) > 0.0_wp) fault = "the volume of a point must be above 0"
      end if
      if (column(8) > 0) call number_material(words(column(8))%text, row, list)
   end subroutine read_row

   !> Set the material number of a point by its name.
   subroutine number_material(name, row, list)
      character(len=*), intent(in) :: name               !! Name of the material
      integer, intent(in) :: row
      type(point_list_t), intent(inout) :: list
      integer :: n

      do n = 1, size(list%material_names)
         if (list%material_names(n)%text == name) exit
      end do
      if (n > size(list%material_names)) call append(list%material_names, name)
      list%material(row) = n
   end subroutine number_material

   !> Shorten the arrays to the rows that were read.
   subroutine trim_rows(list, rows)
      type(point_list_t), intent(inout) :: list
      integer, intent(in) :: rows                        !! Number of points

      list%position = list%position(:, :rows)
      list%line = list%line(:rows)
      if (allocated(list%volume)) list%volume = list%volume(:rows)
      if (allocated(list%velocity)) list%velocity = list%velocity(:, :rows)
      if (allocated(list%material)) list%material = list%material(:rows)
   end subroutine trim_rows

   !> Read the points of a snapshot; its other fields are listed and read where they are needed.
   subroutine read_snapshot(source, list, error)
      type(hdf5_source_t), intent(in) :: source          !! The open file
      type(point_list_t), intent(out) :: list
      type(error_t), allocatable, intent(out) :: error   !! Not a snapshot, or damaged
      type(data_info_t), allocatable :: members(:)
      type(data_info_t) :: info
      integer :: n, status
      logical :: whole

      whole = source%has(root)
      if (whole) whole = source%has(root//"/Points")
      if (whole) whole = source%has(data_group)
      if (.not. whole) then
         call fail_reading(error, source%path, "it is not a snapshot of particles")
         return
      end if
      call source%info(root//"/Points", info, error)
      if (.not. allocated(error)) call source%members(data_group, members, error)
      if (allocated(error)) return
      allocate (list%position(3, info%rows), stat=status)
      if (status /= 0) then
         call fail_reading(error, source%path, "there is no memory for "//number(info%rows)// &
            " points; is the file damaged?")
         return
      end if
      allocate (list%fields(0))
      call read_vectors(source, root//"/Points", list%position, error)
      if (allocated(error)) return
      do n = 1, size(members)
         if (.not. members(n)%is_data .or. members(n)%rows /= info%rows) cycle
         ! not by a structure constructor: gfortran 13 loses the length of the text
         call append(list%fields, trim(members(n)%name))
         if (members(n)%name == "volume") then
            allocate (list%volume(info%rows))
            call read_numbers(source, data_group//"/volume", list%volume, error)
         else if (members(n)%name == "material") then
            allocate (list%material(info%rows))
            call source%read(data_group//"/material", 0_int64, list%material, error)
         else if (members(n)%name == "body") then
            allocate (list%body(info%rows))
            call source%read(data_group//"/body", 0_int64, list%body, error)
         end if
         if (allocated(error)) return
      end do
      call read_names(source, "/bodies/name", list%body_names, error)
      if (.not. allocated(error)) &
         call read_names(source, "/bodies/material_name", list%material_names, error)
      if (allocated(error)) return
      if (size(list%material_names) == 0 .and. allocated(list%material)) deallocate (list%material)
      if (size(list%body_names) == 0 .and. allocated(list%body)) deallocate (list%body)
      call read_clock(source, list)
      call check_snapshot(source%path, list, error)
   end subroutine read_snapshot

   !> Read the lag of velocities behind positions and the next time step. Snapshots without these
   !! are those of leapfrog steps of constant length.
   subroutine read_clock(source, list)
      type(hdf5_source_t), intent(in) :: source          !! The open file
      type(point_list_t), intent(inout) :: list

      if (.not. source%has("/provenance")) return
      list%lag = provenance_value("velocity_lag", 0.5_wp*provenance_value("dt", 0.0_wp))
      list%dt_next = provenance_value("dt_next", 0.0_wp)

   contains

      !> Value of an attribute, if it exists and is valid.
      real(wp) function provenance_value(name, without) result(time)
         character(len=*), intent(in) :: name            !! Name of the attribute
         real(wp), intent(in) :: without                 !! Default value [s]
         type(error_t), allocatable :: error
         real(wp), allocatable :: values(:)

         time = without
         call source%list("/provenance", name, values, error)
         if (allocated(error)) return
         if (size(values) /= 1) return
         if (values(1) >= 0.0_wp .and. ieee_is_finite(values(1))) time = values(1)
      end function provenance_value
   end subroutine read_clock

   !> Reject points with invalid values.
   subroutine check_snapshot(path, list, error)
      character(len=*), intent(in) :: path
      type(point_list_t), intent(in) :: list
      type(error_t), allocatable, intent(out) :: error   !! A value is invalid
      integer :: n

      do n = 1, size(list%position, 2)
         if (.not. all(ieee_is_finite(list%position(:, n)))) then
            call fail_reading(error, path, "row "//number(n)//": the position is not a number")
            return
         end if
         if (.not. allocated(list%volume)) cycle
         if (list%volume(n) > 0.0_wp .and. ieee_is_finite(list%volume(n))) cycle
         call fail_reading(error, path, "row "//number(n)//": the volume must be above 0")
         return
      end do
   end subroutine check_snapshot

   !> Factor that converts a data set to SI.
   real(wp) function factor_of(source, name) result(factor)
      type(hdf5_source_t), intent(in) :: source          !! The open file
      character(len=*), intent(in) :: name               !! Path from the root
      type(error_t), allocatable :: error
      real(wp), allocatable :: values(:)

      call source%list(name, "unitSI", values, error)
      factor = 1.0_wp
      if (allocated(error) .or. size(values) /= 1) return
      factor = values(1)
   end function factor_of

   !> Read vectors and convert them to SI.
   subroutine read_vectors(source, name, values, error)
      type(hdf5_source_t), intent(in) :: source          !! The open file
      character(len=*), intent(in) :: name               !! Path from the root
      real(wp), contiguous, intent(out) :: values(:, :)  !! (component, row)
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read

      call source%read(name, 0_int64, values, error)
      values = factor_of(source, name)*values
   end subroutine read_vectors

   !> Read scalars and convert them to SI.
   subroutine read_numbers(source, name, values, error)
      type(hdf5_source_t), intent(in) :: source          !! The open file
      character(len=*), intent(in) :: name               !! Path from the root
      real(wp), contiguous, intent(out) :: values(:)     !! (row)
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read

      call source%read(name, 0_int64, values, error)
      values = factor_of(source, name)*values
   end subroutine read_numbers

   !> Read names, if there are any.
   subroutine read_names(source, name, names, error)
      type(hdf5_source_t), intent(in) :: source          !! The open file
      character(len=*), intent(in) :: name               !! Path from the root
      type(text_t), allocatable, intent(out) :: names(:) !! Without trailing blanks
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      character(len=:), allocatable :: texts, one
      integer :: n, length

      allocate (names(0))
      if (.not. source%has("/bodies")) return
      if (.not. source%has(name)) return
      call source%names(name, length, texts, error)
      if (allocated(error)) return
      do n = 1, len(texts), length
         one = texts(n:n + length - 1)
         call append(names, trim(one(:index(one//achar(0), achar(0)) - 1)))
      end do
   end subroutine read_names
end module io_points
