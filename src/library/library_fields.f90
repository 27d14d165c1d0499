! SPDX-License-Identifier: BSD-3-Clause
!> Fields of particles for an external caller: their names, and direct access to their memory.
module library_fields
   use base_field_worker, only: field_reader_t, field_worker_t
   use base_kinds, only: int64, wp
   use base_text, only: number
   use, intrinsic :: iso_c_binding, only: c_int, c_int64_t, c_loc, c_null_ptr, c_ptr
   use particle_store, only: store_t
   implicit none
   private

   public :: field_list, field_view_t, find_field

   !> Memory of a field. Component k of particle p, both from 0, is element p + k stride.
   type, bind(c) :: field_view_t
      type(c_ptr) :: address = c_null_ptr              !! First particle, null without particles
      integer(c_int64_t) :: particles = 0              !! Number of particles of this rank
      integer(c_int64_t) :: stride = 0                 !! Elements from component to component
      integer(c_int) :: components = 0                 !! 1 for a scalar, 0 = there is no such field
      integer(c_int) :: whole = 0                      !! 1 = integers of 8 bytes, 0 = real numbers
      integer(c_int) :: writable = 0                   !! 1 = may be changed between steps
   end type field_view_t

   !> Fields that cells, tiles, the ledger or files depend on: read-only.
   character(len=9), parameter :: protected_fields(7) = [character(len=9) :: "identity", "body", &
      "position", "mass", "extent", "domain", "reference"]

   !> Finds the memory of a field.
   type, extends(field_worker_t) :: finder_t
      character(len=:), allocatable :: name            !! Field to find
      type(field_view_t) :: view                       !! Gets the memory of the field
   contains
      procedure :: scalar => finder_scalar             !! Real numbers
      procedure :: vector => finder_vector             !! Vectors and tensors
      procedure :: whole => finder_whole               !! Integers
   end type finder_t

   !> Lists the fields, one per line: name, unit, components, 1 for integers, 1 if writable.
   type, extends(field_reader_t) :: lister_t
      character(len=:), allocatable :: text            !! Lines so far
   contains
      procedure :: reals => lister_reals               !! Real numbers
      procedure :: integers => lister_integers         !! Integers
   end type lister_t

contains

   !> The fields of a store, one per line: name, unit, components, 1 for integers, 1 if writable.
   function field_list(store) result(text)
      type(store_t), intent(in) :: store
      character(len=:), allocatable :: text
      type(lister_t) :: lister

      lister%text = ""
      call store%show(lister)
      text = lister%text
   end function field_list

   !> Memory of a field, in which the particles of this rank are contiguous. It is valid until the
   !! next step.
   subroutine find_field(store, name, view)
      type(store_t), intent(inout) :: store            !! Its particles are made contiguous
      character(len=*), intent(in) :: name             !! Name of the field
      type(field_view_t), intent(out) :: view
      type(finder_t) :: finder

      call store%pack()
      finder%name = name
      call store%walk(finder)
      view = finder%view
      view%particles = int(store%particles(), c_int64_t)
      if (view%particles == 0) view%address = c_null_ptr
   end subroutine find_field

   !> Whether a caller may change a field.
   pure integer(c_int) function is_writable(name) result(writable)
      character(len=*), intent(in) :: name

      writable = merge(0_c_int, 1_c_int, any(protected_fields == name))
   end function is_writable

   !> Address of the first of some real numbers.
   function address_of(values) result(address)
      real(wp), contiguous, target, intent(in) :: values(:)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values(1))
   end function address_of

   !> Address of the first of some vectors or tensors.
   function address_of_vectors(values) result(address)
      real(wp), contiguous, target, intent(in) :: values(:, :)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values(1, 1))
   end function address_of_vectors

   !> Address of the first of some integers.
   function address_of_integers(values) result(address)
      integer(int64), contiguous, target, intent(in) :: values(:)
      type(c_ptr) :: address

      address = c_null_ptr
      if (size(values) > 0) address = c_loc(values(1))
   end function address_of_integers

   subroutine finder_scalar(self, name, unit, values)
      class(finder_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:)

      if (name /= self%name) return
      self%view = field_view_t(address=address_of(values), components=1_c_int, &
         stride=size(values, kind=c_int64_t), writable=is_writable(name))
   end subroutine finder_scalar

   subroutine finder_vector(self, name, unit, values)
      class(finder_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :)

      if (name /= self%name) return
      self%view = field_view_t(address=address_of_vectors(values), &
         components=size(values, 2, c_int), stride=size(values, 1, c_int64_t), &
         writable=is_writable(name))
   end subroutine finder_vector

   subroutine finder_whole(self, name, unit, values)
      class(finder_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:)

      if (name /= self%name) return
      self%view = field_view_t(address=address_of_integers(values), components=1_c_int, &
         stride=size(values, kind=c_int64_t), whole=1_c_int, writable=is_writable(name))
   end subroutine finder_whole

   subroutine lister_reals(self, name, unit, is_scalar, values)
      class(lister_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)

      call add_line(self%text, name, unit, size(values, 2), 0)
   end subroutine lister_reals

   subroutine lister_integers(self, name, unit, values)
      class(lister_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)

      call add_line(self%text, name, unit, 1, 1)
   end subroutine lister_integers

   !> Add the line of a field.
   pure subroutine add_line(text, name, unit, components, whole)
      character(len=:), allocatable, intent(inout) :: text
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer, intent(in) :: components
      integer, intent(in) :: whole                     !! 1 = integers

      text = text//name//" "//unit//" "//number(components)//" "//number(whole)//" "// &
         number(int(is_writable(name)))//new_line("a")
   end subroutine add_line
end module library_fields
