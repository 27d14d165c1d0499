! SPDX-License-Identifier: BSD-3-Clause
!> Mirror planes.
module boundary_symmetry
   use boundary_slip, only: boundary_slip_t
   use mesh_boundary_condition, only: no, yes
   implicit none
   private

   public :: boundary_symmetry_t

   !> The material beyond is the image of that inside, and both are one body where they share nodes:
   !! nodes on the plane never leave it, as in a scene with both halves.
   type, extends(boundary_slip_t) :: boundary_symmetry_t
   contains
      procedure, nopass :: meaning => symmetry_meaning
      procedure, nopass :: waits => no
      procedure, nopass :: mirrors => yes
      procedure, nopass :: suits_part => no
   end type boundary_symmetry_t

contains

   !> One line for the help on the key `type`.
   pure function symmetry_meaning() result(text)
      character(len=:), allocatable :: text

      text = "a mirror plane"
   end function symmetry_meaning
end module boundary_symmetry
