! SPDX-License-Identifier: BSD-3-Clause
!> Reads facets from STL files, binary or text: the corners of triangles, in any unit of length.
module io_stl
   use base_decimal, only: file_number
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: int64, wp
   use base_text, only: line_end, number, shortened, split, text_t
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_fortran_env, only: real32
   implicit none
   private

   public :: read_stl

   integer, parameter :: heading = 84                    !! Bytes before the first facet
   integer, parameter :: facet_bytes = 50                !! Normal, three corners, two further bytes
   integer, parameter :: shown = 40                      !! Characters of a wrong line in a message

contains

   !> Read the facets of a file.
   subroutine read_stl(text, path, corner, error)
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: path               !! For messages
      real(wp), allocatable, intent(out) :: corner(:, :, :) !! (3, corner, facet)
      type(error_t), allocatable, intent(out) :: error   !! Not a valid STL file
      integer(int64) :: count

      ! files of either kind may begin with the word solid, but only a binary file has this length
      count = -1
      if (len(text) >= heading) count = whole_at(text, heading - 4)
      if (heading + facet_bytes*count == len(text, kind=int64)) then
         call read_binary(text, path, int(count), corner, error)
      else if (index(adjustl(text(:min(len(text), shown))), "solid") == 1 .and. &
         index(text, "facet") > 0) then
         call read_text(text, path, corner, error)
      else if (len(text) >= heading) then
         call fail_reading(error, path, "its header gives "//number(count)// &
            " facets, but it has "//number((len(text) - heading)/facet_bytes)// &
            "; it is truncated, or not an STL file")
      else
         call fail_reading(error, path, "it is too short for an STL file")
      end if
      if (allocated(error)) return
      if (size(corner, 3) == 0) call fail_reading(error, path, "it has no facets")
   end subroutine read_stl

   !> Make the error message on a file.
   subroutine fail_reading(error, path, what)
      type(error_t), allocatable, intent(out) :: error
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: what               !! Error message

      call fail(error, exit_file, "cannot read the facets of '"//path//"': "//what//" [F113]")
   end subroutine fail_reading

   !> Four bytes as an unsigned integer, little-endian.
   pure integer(int64) function whole_at(text, before) result(whole)
      character(len=*), intent(in) :: text               !! Bytes
      integer, intent(in) :: before                      !! Bytes before the first
      integer :: k

      whole = 0
      do k = 4, 1, -1
         whole = 256*whole + ichar(text(before + k:before + k))
      end do
   end function whole_at

   !> Facets of a binary file.
   subroutine read_binary(text, path, count, corner, error)
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: path               !! For messages
      integer, intent(in) :: count                       !! Facets
      real(wp), allocatable, intent(out) :: corner(:, :, :) !! (3, corner, facet)
      type(error_t), allocatable, intent(out) :: error   !! A coordinate is not finite
      real(real32) :: value
      integer :: facet, k, n, before

      allocate (corner(3, 3, count))
      do facet = 1, count
         do n = 1, 3
            do k = 1, 3
               ! the normal precedes the corners and is ignored: it follows from their order
               before = heading + facet_bytes*(facet - 1) + 12*n + 4*(k - 1)
               value = transfer(text(before + 1:before + 4), value)
               if (.not. ieee_is_finite(value)) then
                  call fail_reading(error, path, "facet "//number(facet)// &
                     " has a corner that is not finite")
                  return
               end if
               corner(k, n, facet) = real(value, wp)
            end do
         end do
      end do
   end subroutine read_binary

   !> Facets of a text: three lines with `vertex` and three numbers for each facet.
   subroutine read_text(text, path, corner, error)
      character(len=*), intent(in) :: text               !! Content of the file
      character(len=*), intent(in) :: path               !! For messages
      real(wp), allocatable, intent(out) :: corner(:, :, :) !! (3, corner, facet)
      type(error_t), allocatable, intent(out) :: error   !! A line is not valid
      type(text_t), allocatable :: words(:)
      character(len=:), allocatable :: line
      real(wp), allocatable :: corners_read(:, :, :)
      real(wp) :: values(3)
      integer :: first, last, row, corners, facets, k
      logical :: sound(3)

      allocate (corners_read(3, 3, facets_of(text)))
      first = 1
      row = 0
      facets = 0
      corners = 3
      do while (first <= len(text))
         last = line_end(text, first)
         line = text(first:last)
         first = last + 2
         row = row + 1
         call split(plain(line), words)
         if (size(words) == 0) cycle
         select case (words(1)%text)
         case ("vertex")
            if (size(words) /= 4 .or. corners == 3) exit
            do k = 1, 3
               call file_number(words(k + 1)%text, values(k), sound(k))
            end do
            if (.not. all(sound)) exit
            corners = corners + 1
            corners_read(:, corners, facets) = values
         case ("facet")
            if (corners /= 3) exit
            facets = facets + 1
            corners = 0
         case ("solid", "outer", "endloop", "endfacet", "endsolid")
            continue
         case default
            exit
         end select
         line = ""
      end do
      if (len(line) > 0) then
         call fail_reading(error, path, "line "//number(row)//": expected a facet with three "// &
            "vertices of three numbers, not '"//shortened(trim(adjustl(plain(line))), shown)//"'")
      else if (corners /= 3 .or. index(text, "endsolid") == 0) then
         call fail_reading(error, path, "it ends within a solid, in line "//number(row)// &
            "; it is truncated")
      end if
      if (allocated(error)) return
      allocate (corner(3, 3, facets))
      corner(:, :, :) = corners_read(:, :, :facets)
   end subroutine read_text

   !> A line without tabs and carriage returns.
   pure function plain(line) result(clean)
      character(len=*), intent(in) :: line               !! Value
      character(len=len(line)) :: clean
      integer :: n

      do n = 1, len(line)
         clean(n:n) = merge(" ", line(n:n), iachar(line(n:n)) < iachar(" "))
      end do
   end function plain

   !> Occurrences of the word facet in a text: an upper bound of the number of facets.
   pure integer function facets_of(text) result(facets)
      character(len=*), intent(in) :: text               !! Content of the file
      integer :: found, from

      facets = 0
      from = 1
      do
         found = index(text(from:), "facet")
         if (found == 0) return
         facets = facets + 1
         from = from + found
      end do
   end function facets_of
end module io_stl
