! SPDX-License-Identifier: BSD-3-Clause
!> Reads rasters from ESRI ASCII grids: a header of names and numbers, then the values of rows from
!! north to south.
module io_raster
   use base_decimal, only: file_number
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: int64, wp
   use base_text, only: lower, number, shortened
   use particle_raster, only: no_data, raster_t
   implicit none
   private

   public :: read_raster

   integer, parameter :: shown = 40                  !! Characters of a wrong word in a message
   real(wp), parameter :: limit = 1.0e30_wp          !! Of lengths; ratios of lengths stay finite
   real(wp), parameter :: same = 1.0e-5_wp           !! Difference of two texts of one number [1]
   integer(int64), parameter :: most_cells = 2_int64**28 !! Cells of a raster
   integer, parameter :: is_columns = 1, is_rows = 2, is_x = 3, is_y = 4, is_edge = 5, is_void = 6
   character(len=12), parameter :: keys(8) = [character(len=12) :: "ncols", "nrows", "xllcorner", &
      "yllcorner", "cellsize", "nodata_value", "xllcenter", "yllcenter"]

   !> Words of a text, one after the other.
   type :: scanner_t
      integer :: first = 1                           !! First letter of a word
      integer :: last = 0                            !! Its last letter, below the first at the end
      integer :: line = 1                            !! Its line
   end type scanner_t

   !> Header of a raster.
   type :: header_t
      real(wp) :: value(6) = 0.0_wp                  !! In the order of the first keys
      logical :: given(6) = .false.                  !! Is it in the file?
      logical :: middle(2) = .false.                 !! Is the position that of the middle?
   end type header_t

contains

   !> Read a raster. Lengths are those of the file.
   subroutine read_raster(text, path, raster, error)
      character(len=*), intent(in) :: text           !! Content of the file
      character(len=*), intent(in) :: path           !! For messages
      type(raster_t), intent(out) :: raster
      type(error_t), allocatable, intent(out) :: error !! Not a valid raster
      type(scanner_t) :: scanner
      type(header_t) :: header
      character(len=:), allocatable :: fault
      integer :: cells(2), status

      call read_header(text, scanner, header, fault)
      if (fault == "") call check_header(header, fault)
      if (fault == "") then
         cells = nint(header%value([is_columns, is_rows]))
         call check_count(text, scanner, cells, fault)
      end if
      if (fault == "") then
         allocate (raster%value(cells(1), cells(2)), stat=status)
         if (status /= 0) fault = "there is no memory for its cells"
      end if
      if (fault == "") call read_values(text, scanner, header, raster%value, fault)
      if (fault /= "") then
         call fail(error, exit_file, "cannot read the raster of '"//path//"': "//fault//" [F129]")
         return
      end if
      raster%edge = header%value(is_edge)
      raster%corner = header%value([is_x, is_y]) - merge(0.5_wp, 0.0_wp, header%middle)*raster%edge
   end subroutine read_raster

   !> Find the next word.
   pure subroutine next_word(text, scanner)
      character(len=*), intent(in) :: text           !! Content of the file
      type(scanner_t), intent(inout) :: scanner
      integer :: n

      n = scanner%last + 1
      do while (n <= len(text))
         if (text(n:n) > " ") exit
         if (text(n:n) == new_line("a")) scanner%line = scanner%line + 1
         n = n + 1
      end do
      scanner%first = n
      do while (n <= len(text))
         if (text(n:n) <= " ") exit
         n = n + 1
      end do
      scanner%last = n - 1
   end subroutine next_word

   !> Read the lines of the header. The scanner stops at the first value.
   subroutine read_header(text, scanner, header, fault)
      character(len=*), intent(in) :: text           !! Content of the file
      type(scanner_t), intent(inout) :: scanner
      type(header_t), intent(inout) :: header
      character(len=:), allocatable, intent(out) :: fault !! Error message, or empty
      character(len=:), allocatable :: word
      integer :: key
      logical :: sound

      fault = ""
      do
         call next_word(text, scanner)
         word = lower(text(scanner%first:scanner%last))
         if (verify(word(:min(len(word), 1)), "abcdefghijklmnopqrstuvwxyz") > 0) return
         if (word == "" .or. word == "nan") return
         do key = 1, size(keys)
            if (keys(key) == word) exit
         end do
         if (key > size(keys)) then
            fault = "line "//number(scanner%line)//": '"//shortened(word, shown)//"' is no key "// &
               "of an ESRI ASCII grid, which has ncols, nrows, xllcorner or xllcenter, "// &
               "yllcorner or yllcenter, cellsize and nodata_value"
            return
         end if
         if (key > is_void) then
            key = key - 4
            header%middle(key - 2) = .true.
         end if
         if (header%given(key)) then
            fault = "line "//number(scanner%line)//": "//word//" is given twice"
            return
         end if
         header%given(key) = .true.
         call next_word(text, scanner)
         call file_number(text(scanner%first:scanner%last), header%value(key), sound)
         ! GDAL writes nan as the value of cells without data
         if (key == is_void .and. .not. sound) then
            sound = is_nan(text(scanner%first:scanner%last))
            header%value(key) = no_data
         end if
         if (.not. sound) then
            fault = "line "//number(scanner%line)//": "//word//" must be a number, not '"// &
               shortened(text(scanner%first:scanner%last), shown)//"'"
            return
         end if
      end do
   end subroutine read_header

   !> True for a NaN as C libraries print it.
   pure logical function is_nan(word) result(yes)
      character(len=*), intent(in) :: word

      yes = index(lower(word), "nan") == verify(word//" ", "+-")
   end function is_nan

   !> Check that the header is complete and describes a raster.
   pure subroutine check_header(header, fault)
      type(header_t), intent(in) :: header
      character(len=:), allocatable, intent(out) :: fault !! Error message, or empty
      integer :: key

      fault = ""
      do key = 1, is_edge
         if (header%given(key)) cycle
         fault = "its header has no "//trim(keys(key))
         return
      end do
      do key = is_columns, is_rows
         if (header%value(key) >= 1.0_wp .and. header%value(key) <= 1.0e9_wp .and. &
            .not. abs(header%value(key) - anint(header%value(key))) > 0.0_wp) cycle
         fault = trim(keys(key))//" = "//number(header%value(key))//" must be an integer above 0"
         return
      end do
      if (.not. header%value(is_edge) > 0.0_wp) fault = "cellsize = "// &
         number(header%value(is_edge))//" must be above 0"
      if (maxval(abs(header%value(is_x:is_edge))) > limit .or. (fault == "" .and. &
         header%value(is_edge) < 1.0_wp/limit)) fault = "a length of its header is out of range"
      if (product(header%value(:2)) > real(most_cells, wp)) fault = "it has more than "// &
         number(most_cells)//" cells; coarsen it"
   end subroutine check_header

   !> Check the number of values, before memory is allocated for a damaged number of cells.
   pure subroutine check_count(text, scanner, cells, fault)
      character(len=*), intent(in) :: text           !! Content of the file
      type(scanner_t), intent(in) :: scanner         !! At the first value
      integer, intent(in) :: cells(2)                !! Columns and rows
      character(len=:), allocatable, intent(out) :: fault !! Error message, or empty
      type(scanner_t) :: next
      integer(int64) :: found, wanted
      integer :: line, in_line, odd

      fault = ""
      next = scanner
      found = 0
      line = next%line
      in_line = 0
      odd = 0
      do
         if (next%line /= line .or. next%last < next%first) then
            if (in_line /= cells(1) .and. odd == 0) odd = line
            line = next%line
            in_line = 0
         end if
         if (next%last < next%first) exit
         found = found + 1
         in_line = in_line + 1
         call next_word(text, next)
      end do
      wanted = product(int(cells, int64))
      if (found == wanted) return
      fault = "ncols = "//number(cells(1))//" and nrows = "//number(cells(2))//" make "// &
         number(wanted)//" values, but there are "//number(found)
      if (odd > 0) fault = fault//"; the first line that has not "//number(cells(1))// &
         " of them is "//number(odd)
   end subroutine check_count

   !> Read the values; the first row of the file is the last one of the raster.
   subroutine read_values(text, scanner, header, value, fault)
      character(len=*), intent(in) :: text           !! Content of the file
      type(scanner_t), intent(inout) :: scanner      !! At the first value
      type(header_t), intent(in) :: header
      real(wp), contiguous, intent(out) :: value(:, :) !! (column, row from south)
      character(len=:), allocatable, intent(out) :: fault !! Error message, or empty
      real(wp) :: void
      integer :: i, j

      fault = ""
      void = -9999.0_wp
      if (header%given(is_void)) void = header%value(is_void)
      do j = size(value, 2), 1, -1
         do i = 1, size(value, 1)
            call read_value(text(scanner%first:scanner%last), void, value(i, j), fault)
            if (fault /= "") then
               fault = "line "//number(scanner%line)//": "//fault
               return
            end if
            call next_word(text, scanner)
         end do
      end do
   end subroutine read_values

   !> Read one value.
   pure subroutine read_value(word, void, value, fault)
      character(len=*), intent(in) :: word
      real(wp), intent(in) :: void                   !! Value of cells without data
      real(wp), intent(out) :: value                 !! The number, or `no_data`
      character(len=:), allocatable, intent(out) :: fault !! Error message, or empty
      logical :: sound

      fault = ""
      call file_number(word, value, sound)
      if (.not. sound) then
         value = no_data
         if (.not. is_nan(word)) fault = "expected a number, not '"//shortened(word, shown)//"'"
      else if (void > no_data .and. abs(value - void) <= same*abs(void)) then
         value = no_data
      else if (abs(value) > limit) then
         fault = shortened(word, shown)//" is out of range; if it is the value of cells "// &
            "without data, write it as nodata_value into the header"
      end if
   end subroutine read_value
end module io_raster
