! SPDX-License-Identifier: BSD-3-Clause
!> In RFLIP particles carry the rotation of the velocity around them to the nodes, as with the rigid
!! particles of C. Jiang, C. Schroeder, A. Selle, J. Teran, A. Stomakhin, ACM Trans. Graph. 34
!! (2015) 51, and receive increments as with FLIP. Three numbers per particle conserve the spin of
!! a body and remove noise at its surface; unlike a full linear field they do not keep stretching
!! particles without stress. Equations (T.1) and (T.4) of doc/theory/transfers.md.
module velocity_rflip
   use velocity_aflip, only: velocity_aflip_t
   implicit none
   private

   public :: velocity_rflip_t

   !> Increments, and a rotation.
   type, extends(velocity_aflip_t) :: velocity_rflip_t
   contains
      procedure :: turning => rflip_turning          !! Particles carry a rotation only
   end type velocity_rflip_t

contains

   !> Particles carry a rotation only.
   pure logical function rflip_turning(self) result(turning)
      class(velocity_rflip_t), intent(in) :: self

      turning = .true.
   end function rflip_turning
end module velocity_rflip
