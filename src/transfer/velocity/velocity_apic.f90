! SPDX-License-Identifier: BSD-3-Clause
!> APIC is PIC, but particles carry a linear velocity field to the nodes, so that linear fields and
!! angular momentum are kept: C. Jiang, C. Schroeder, A. Selle, J. Teran, A. Stomakhin, ACM Trans.
!! Graph. 34 (2015) 51. Equations (T.1) and (T.3) of doc/theory/transfers.md.
module velocity_apic
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: velocity_apic_t

   !> Node velocities, and a linear velocity field.
   type, extends(velocity_t) :: velocity_apic_t
   contains
      procedure :: affine => apic_affine             !! Particles carry a linear velocity field
   end type velocity_apic_t

contains

   !> Particles carry a linear velocity field.
   pure logical function apic_affine(self) result(affine)
      class(velocity_apic_t), intent(in) :: self

      affine = .true.
   end function apic_affine
end module velocity_apic
