! SPDX-License-Identifier: BSD-3-Clause
!> Fields that the particles of a material carry, each with the models that request it.
module material_field_requests
   use base_kinds, only: wp
   implicit none
   private

   public :: field_request_t, field_requests_t

   !> One field.
   type :: field_request_t
      character(len=:), allocatable :: field         !! Name of the field in files
      character(len=:), allocatable :: reason        !! Models that request it
      integer :: bytes = 0                           !! Bytes a particle
      logical :: own = .false.                       !! Described by the model that requests it
      character(len=:), allocatable :: unit          !! SI unit of an own field
      character(len=:), allocatable :: meaning       !! Of an own field, for the user
      real(wp) :: start = 0.0_wp                     !! Own field of new particles
   end type field_request_t

   !> All fields, each once.
   type :: field_requests_t
      type(field_request_t), allocatable :: entries(:) !! In the order of requests
   contains
      procedure :: add => requests_add                 !! Request a field
      procedure :: add_own => requests_add_own         !! Request a field of one model
      procedure :: has => requests_has                 !! True if a field is requested
      procedure :: bytes => requests_bytes             !! Bytes per particle of all fields
      procedure :: report => requests_report           !! Table for the user
   end type field_requests_t

contains

   !> Request a field. A further request of the same field adds its reason.
   pure subroutine requests_add(self, field, reason, components)
      class(field_requests_t), intent(inout) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      character(len=*), intent(in) :: reason         !! Model that requests it
      integer, intent(in) :: components              !! Numbers a particle
      type(field_request_t), allocatable :: longer(:)
      integer :: i, known

      known = 0
      if (allocated(self%entries)) known = size(self%entries)
      do i = 1, known
         if (self%entries(i)%field /= field) cycle
         self%entries(i)%reason = self%entries(i)%reason//", "//reason
         return
      end do
      allocate (longer(known + 1))
      do i = 1, known
         longer(i) = self%entries(i)
      end do
      longer(known + 1)%field = field
      longer(known + 1)%reason = reason
      longer(known + 1)%bytes = components*storage_size(1.0_wp)/8
      call move_alloc(longer, self%entries)
   end subroutine requests_add

   !> Request a field that belongs to one model. This call is its whole declaration: the field is
   !! allocated, sorted, sent, stored in checkpoints, and allowed in `fields` of outputs. A model
   !! requests its own fields for all values of its keys, so that they can be listed.
   pure subroutine requests_add_own(self, field, unit, meaning, reason, start)
      class(field_requests_t), intent(inout) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      character(len=*), intent(in) :: unit           !! SI unit, "1" without dimension
      character(len=*), intent(in) :: meaning        !! For the user
      character(len=*), intent(in) :: reason         !! Model that requests it
      real(wp), optional, intent(in) :: start        !! Value of new particles; 0 if not given

      call self%add(field, reason, 1)
      associate (entry => self%entries(size(self%entries)))
         entry%own = .true.
         entry%unit = unit
         entry%meaning = meaning
         if (present(start)) entry%start = start
      end associate
   end subroutine requests_add_own

   !> True if a field is requested.
   pure logical function requests_has(self, field) result(found)
      class(field_requests_t), intent(in) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      integer :: i

      found = .false.
      if (.not. allocated(self%entries)) return
      do i = 1, size(self%entries)
         if (self%entries(i)%field == field) found = .true.
      end do
   end function requests_has

   !> Bytes a particle of all fields.
   pure integer function requests_bytes(self) result(bytes)
      class(field_requests_t), intent(in) :: self

      bytes = 0
      if (allocated(self%entries)) bytes = sum(self%entries%bytes)
   end function requests_bytes

   !> One line per field: name, bytes per particle, the models that request it.
   pure function requests_report(self) result(text)
      class(field_requests_t), intent(in) :: self
      character(len=:), allocatable :: text
      character(len=20) :: name
      character(len=32) :: line
      integer :: i

      text = ""
      if (.not. allocated(self%entries)) return
      do i = 1, size(self%entries)
         name = self%entries(i)%field
         write (line, "(a20, i6, a6)") name, self%entries(i)%bytes, " bytes"
         text = text//line//"  "//self%entries(i)%reason//new_line("a")
      end do
   end function requests_report
end module material_field_requests
