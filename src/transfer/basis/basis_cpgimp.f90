! SPDX-License-Identifier: BSD-3-Clause
!> Linear functions averaged over the box of a particle, whose edges follow the stretch along the
!! directions of the grid (cpGIMP): S. G. Bardenhagen, E. M. Kober, Comput. Model. Eng. Sci. 5
!! (2004) 477; P. C. Wallstedt, J. E. Guilkey, J. Comput. Phys. 227 (2008) 9628. Equations (N.2) and
!! (N.3) of doc/theory/node_functions.md.
module basis_cpgimp
   use basis_gimp, only: basis_gimp_t
   use particle_store, only: traits_t
   implicit none
   private

   public :: basis_cpgimp_t

   !> Means of the linear functions over boxes that stretch.
   type, extends(basis_gimp_t) :: basis_cpgimp_t
   contains
      procedure :: request => cpgimp_request         !! Particles carry a size that changes
      procedure :: suits_cell => cpgimp_suits_cell   !! Not with boxes that stretch along the axes
   end type basis_cpgimp_t

contains

   !> Particles carry half the edges of their boxes, and these stretch.
   pure subroutine cpgimp_request(self, traits)
      class(basis_cpgimp_t), intent(in) :: self
      type(traits_t), intent(inout) :: traits

      traits%extent = .true.
      traits%stretching = .true.
   end subroutine cpgimp_request

   !> The boxes stretch along the axes of space, not along those of the mesh.
   pure logical function cpgimp_suits_cell(self) result(yes)
      class(basis_cpgimp_t), intent(in) :: self

      yes = .false.
   end function cpgimp_suits_cell
end module basis_cpgimp
