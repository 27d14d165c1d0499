! SPDX-License-Identifier: BSD-3-Clause
!> Base type of operations on all fields of a particle store.
!!
!! A store passes each allocated field of its registry to a worker. Resizing, sorting, packing,
!! output and restart are workers, so a new field is one component and one line.
module base_field_worker
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: field_worker_t

   !> One operation on all fields.
   type, abstract :: field_worker_t
   contains
      procedure(scalar_i), deferred :: scalar   !! Works on a field of real numbers
      procedure(vector_i), deferred :: vector   !! Works on a field of vectors or tensors
      procedure(whole_i), deferred :: whole     !! Works on a field of integers
   end type field_worker_t

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
   end interface
end module base_field_worker
