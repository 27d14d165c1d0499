! SPDX-License-Identifier: BSD-3-Clause
!> Open boundaries.
module boundary_outflow
   use mesh_boundary_condition, only: boundary_condition_t, no, yes
   implicit none
   private

   public :: boundary_outflow_t

   !> Particles leave the domain, and the ledger records them.
   type, extends(boundary_condition_t) :: boundary_outflow_t
   contains
      procedure, nopass :: meaning => outflow_meaning
      procedure, nopass :: lets_out => yes
      procedure, nopass :: acts_on_nodes => no
   end type boundary_outflow_t

contains

   !> One line for the help on the key `type`.
   pure function outflow_meaning() result(text)
      character(len=:), allocatable :: text

      text = "particles leave, and the balance records them"
   end function outflow_meaning
end module boundary_outflow
