! SPDX-License-Identifier: BSD-3-Clause
!> Periodic boundaries.
module boundary_periodic
   use mesh_boundary_condition, only: boundary_condition_t, no, yes
   implicit none
   private

   public :: boundary_periodic_t

   !> Material that leaves enters at the opposite boundary.
   type, extends(boundary_condition_t) :: boundary_periodic_t
   contains
      procedure, nopass :: meaning => periodic_meaning
      procedure, nopass :: joins_opposite => yes
      procedure, nopass :: acts_on_nodes => no
      procedure, nopass :: suits_part => no
   end type boundary_periodic_t

contains

   !> One line for the help on the key `type`.
   pure function periodic_meaning() result(text)
      character(len=:), allocatable :: text

      text = "joined to the opposite boundary"
   end function periodic_meaning
end module boundary_periodic
