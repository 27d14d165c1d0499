! SPDX-License-Identifier: BSD-3-Clause
!> In AFLIP particles carry a linear velocity field to the nodes as with APIC and receive increments
!! as with FLIP: Y. Fei, Q. Guo, R. Wu, L. Huang, M. Gao, ACM Trans. Graph. 40 (2021) 109, but
!! without its treatment of separation. Equations (T.1) and (T.3) of doc/theory/transfers.md.
module velocity_aflip
   use deck_schema, only: schema_t
   use velocity_flip, only: velocity_flip_t
   implicit none
   private

   public :: velocity_aflip_t

   !> Increments, and a linear velocity field.
   type, extends(velocity_flip_t) :: velocity_aflip_t
   contains
      procedure :: declare => aflip_declare          !! No keys of its own
      procedure :: affine => aflip_affine            !! Particles carry a linear velocity field
   end type velocity_aflip_t

contains

   !> FLIP declares the fraction for both.
   subroutine aflip_declare(self, schema)
      class(velocity_aflip_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine aflip_declare

   !> Particles carry a linear velocity field.
   pure logical function aflip_affine(self) result(affine)
      class(velocity_aflip_t), intent(in) :: self

      affine = .true.
   end function aflip_affine
end module velocity_aflip
