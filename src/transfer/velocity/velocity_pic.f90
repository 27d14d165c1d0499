! SPDX-License-Identifier: BSD-3-Clause
!> With PIC particles receive the velocity of the nodes (F. H. Harlow, Methods Comput. Phys. 3
!! (1964) 319), with a second-order update of the position. Equations (T.1) and (T.2) of
!! doc/theory/transfers.md.
module velocity_pic
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: velocity_pic_t

   !> The default of all transfers.
   type, extends(velocity_t) :: velocity_pic_t
   end type velocity_pic_t
end module velocity_pic
