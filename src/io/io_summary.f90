! SPDX-License-Identifier: BSD-3-Clause
!> Writes JSON, for the summary of a run.
module io_summary
   use base_error, only: error_t
   use base_file, only: write_file
   use base_kinds, only: int32, int64, wp
   use base_text, only: exponent_text, number
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   implicit none
   private

   public :: json_quoted, json_t

   !> An object to which members are added. Objects may be nested.
   type :: json_t
      character(len=:), allocatable, private :: body     !! Members so far
      integer, private :: depth = 1                      !! Objects that are open
      logical, private :: first = .true.                 !! The open object has no member yet
   contains
      procedure :: begin => json_begin                   !! Begin a nested object
      procedure :: end => json_end                       !! End that object
      procedure :: text => json_text                     !! Text of the object
      procedure :: write => json_write                   !! Write it to a file
      procedure, private :: add_text, add_real, add_integer, add_short, add_logical, add_reals, &
         add_texts, add_raw
      !> Add a member.
      generic :: add => add_text, add_real, add_integer, add_short, add_logical, add_reals, &
         add_texts
   end type json_t

contains

   !> A text in quotes.
   pure function json_quoted(text) result(line)
      character(len=*), intent(in) :: text               !! Text
      character(len=:), allocatable :: line
      character(len=*), parameter :: digits = "0123456789abcdef"
      integer :: code, letter

      line = """"
      do letter = 1, len(text)
         code = iachar(text(letter:letter))
         select case (code)
         case (34)
            line = line//"\"""
         case (92)
            line = line//"\\"
         case (10)
            line = line//"\n"
         case (0:9, 11:31)
            line = line//"\u00"//digits(code/16 + 1:code/16 + 1)// &
               digits(mod(code, 16) + 1:mod(code, 16) + 1)
         case default
            line = line//text(letter:letter)
         end select
      end do
      line = line//""""
   end function json_quoted

   !> A number, or null if it is not finite.
   function number_text(number) result(text)
      real(wp), intent(in) :: number                     !! Number
      character(len=:), allocatable :: text

      text = "null"
      if (ieee_is_finite(number)) text = exponent_text(number)
   end function number_text

   !> Add a member whose value is JSON text.
   subroutine add_raw(self, name, value)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      character(len=*), intent(in) :: value              !! Value

      if (.not. allocated(self%body)) self%body = ""
      if (.not. self%first) self%body = self%body//","
      self%body = self%body//new_line("a")//repeat("  ", self%depth)//json_quoted(name)//": "//value
      self%first = .false.
   end subroutine add_raw

   !> Begin a nested object.
   subroutine json_begin(self, name)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member

      call self%add_raw(name, "{")
      self%depth = self%depth + 1
      self%first = .true.
   end subroutine json_begin

   !> Close the innermost open object.
   subroutine json_end(self)
      class(json_t), intent(inout) :: self

      if (self%depth == 1) return
      self%depth = self%depth - 1
      if (.not. self%first) self%body = self%body//new_line("a")//repeat("  ", self%depth)
      self%body = self%body//"}"
      self%first = .false.
   end subroutine json_end

   !> Text of the object; open nested objects are closed.
   pure function json_text(self) result(text)
      class(json_t), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: depth

      text = "{"
      if (allocated(self%body)) text = text//self%body
      do depth = self%depth - 1, 0, -1
         text = text//new_line("a")//repeat("  ", depth)//"}"
      end do
      text = text//new_line("a")
   end function json_text

   !> Write the object to a file.
   subroutine json_write(self, path, error)
      class(json_t), intent(in) :: self
      character(len=*), intent(in) :: path               !! Path
      type(error_t), allocatable, intent(out) :: error   !! Cannot be written

      call write_file(path, self%text(), error)
   end subroutine json_write

   !> Add a text.
   subroutine add_text(self, name, value)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      character(len=*), intent(in) :: value              !! Value

      call self%add_raw(name, json_quoted(value))
   end subroutine add_text

   !> Add a real.
   subroutine add_real(self, name, value)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      real(wp), intent(in) :: value                      !! Value

      call self%add_raw(name, number_text(value))
   end subroutine add_real

   !> Add an integer.
   subroutine add_integer(self, name, value)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      integer(int64), intent(in) :: value                !! Value

      call self%add_raw(name, number(value))
   end subroutine add_integer

   !> Add a 32-bit integer.
   subroutine add_short(self, name, value)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      integer(int32), intent(in) :: value                !! Value

      call self%add_raw(name, number(value))
   end subroutine add_short

   !> Add a condition.
   subroutine add_logical(self, name, value)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      logical, intent(in) :: value                       !! Value

      if (value) then
         call self%add_raw(name, "true")
      else
         call self%add_raw(name, "false")
      end if
   end subroutine add_logical

   !> Add an array of reals.
   subroutine add_reals(self, name, values)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      real(wp), intent(in) :: values(:)                  !! Value
      character(len=:), allocatable :: line
      integer :: index

      line = "["
      do index = 1, size(values)
         if (index > 1) line = line//", "
         line = line//number_text(values(index))
      end do
      call self%add_raw(name, line//"]")
   end subroutine add_reals

   !> Add an array of texts, without trailing blanks.
   subroutine add_texts(self, name, values)
      class(json_t), intent(inout) :: self
      character(len=*), intent(in) :: name               !! Name of the member
      character(len=*), intent(in) :: values(:)          !! Value
      character(len=:), allocatable :: line
      integer :: index

      line = "["
      do index = 1, size(values)
         if (index > 1) line = line//", "
         line = line//json_quoted(trim(values(index)))
      end do
      call self%add_raw(name, line//"]")
   end subroutine add_texts
end module io_summary
