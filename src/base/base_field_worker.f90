! SPDX-License-Identifier: BSD-3-Clause
!> Base types of operations on all fields of a particle store.
!!
!! A store passes each allocated field of its registry to a worker. Resizing, sorting and restart
!! are workers; packing, output, checkpoints and digests are readers, which the compiler keeps from
!! changing a field. So a new field is one component and one line.
module base_field_worker
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: field_reader_t, field_worker_t

   !> One operation on all fields.
   type, abstract :: field_worker_t
   contains
      procedure(scalar_i), deferred :: scalar   !! Works on a field of real numbers
      procedure(vector_i), deferred :: vector   !! Works on a field of vectors or tensors
      procedure(whole_i), deferred :: whole     !! Works on a field of integers
   end type field_worker_t

   !> One operation that reads all fields, for `show` of a store.
   type, abstract, extends(field_worker_t) :: field_reader_t
   contains
      procedure :: scalar => reader_scalar      !! Passes the numbers on
      procedure :: vector => reader_vector      !! Passes the components on
      procedure :: whole => reader_whole        !! Passes the integers on
      procedure(reals_i), deferred :: reals     !! Reads a field of real numbers
      procedure(integers_i), deferred :: integers !! Reads a field of integers
   end type field_reader_t

   abstract interface
      subroutine scalar_i(self, name, unit, values)
         import :: field_worker_t, wp
         implicit none
         class(field_worker_t), intent(inout) :: self
         character(len=*), intent(in) :: name               !! Name in files
         character(len=*), intent(in) :: unit               !! SI unit, "1" without dimension
         real(wp), allocatable, intent(inout) :: values(:)  !! (particle)
      end subroutine scalar_i

      subroutine vector_i(self, name, unit, values)
         import :: field_worker_t, wp
         implicit none
         class(field_worker_t), intent(inout) :: self
         character(len=*), intent(in) :: name                  !! Name in files
         character(len=*), intent(in) :: unit                  !! SI unit, "1" without dimension
         real(wp), allocatable, intent(inout) :: values(:, :)  !! (particle, component)
      end subroutine vector_i

      subroutine whole_i(self, name, unit, values)
         import :: field_worker_t, int64
         implicit none
         class(field_worker_t), intent(inout) :: self
         character(len=*), intent(in) :: name                     !! Name in files
         character(len=*), intent(in) :: unit                     !! SI unit, "1" without dimension
         integer(int64), allocatable, intent(inout) :: values(:)  !! (particle)
      end subroutine whole_i

      subroutine reals_i(self, name, unit, is_scalar, values)
         import :: field_reader_t, wp
         implicit none
         class(field_reader_t), intent(inout) :: self
         character(len=*), intent(in) :: name               !! Name in files
         character(len=*), intent(in) :: unit               !! SI unit, "1" without dimension
         logical, intent(in) :: is_scalar                   !! One number a particle?
         real(wp), contiguous, intent(in) :: values(:, :)   !! (particle, component)
      end subroutine reals_i

      subroutine integers_i(self, name, unit, values)
         import :: field_reader_t, int64
         implicit none
         class(field_reader_t), intent(inout) :: self
         character(len=*), intent(in) :: name               !! Name in files
         character(len=*), intent(in) :: unit               !! SI unit, "1" without dimension
         integer(int64), contiguous, intent(in) :: values(:) !! (particle)
      end subroutine integers_i
   end interface

contains

   !> Read a field of numbers.
   subroutine reader_scalar(self, name, unit, values)
      class(field_reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:)  !! (particle)

      call pass_column(self, name, unit, size(values), values)
   end subroutine reader_scalar

   !> Pass a field of numbers on as an array with one column.
   subroutine pass_column(reader, name, unit, particles, values)
      class(field_reader_t), intent(inout) :: reader
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer, intent(in) :: particles                   !! Size of the field
      real(wp), intent(in) :: values(particles, 1)       !! (particle, 1)

      call reader%reals(name, unit, .true., values)
   end subroutine pass_column

   !> Read a field of vectors or tensors.
   subroutine reader_vector(self, name, unit, values)
      class(field_reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :) !! (particle, component)

      call self%reals(name, unit, .false., values)
   end subroutine reader_vector

   !> Read a field of integers.
   subroutine reader_whole(self, name, unit, values)
      class(field_reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:) !! (particle)

      call self%integers(name, unit, values)
   end subroutine reader_whole
end module base_field_worker
