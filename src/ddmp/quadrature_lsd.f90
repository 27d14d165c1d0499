! SPDX-License-Identifier: BSD-3-Clause
!> The modified gradient at the particle, with the local stress difference: the error of the force
!! of a uniform stress for the given particle positions is subtracted from the force of each node,
!! with the mean stress there (A. Perez, M. Barclay, D. Z. Zhang, J. Comput. Phys. (2023) 112681).
!! Momentum is not conserved exactly, because the mean stress differs from node to node. Equation
!! (Q.4) of doc/theory/quadratures.md.
module quadrature_lsd
   use quadrature_point, only: quadrature_point_t
   implicit none
   private

   public :: quadrature_lsd_t

   !> The gradient at one point, with a force that is exact for uniform stress.
   type, extends(quadrature_point_t) :: quadrature_lsd_t
   contains
      procedure :: differing => lsd_differing        !! The force is of stress differences
   end type quadrature_lsd_t

contains

   !> The force is of stress differences.
   pure logical function lsd_differing(self) result(differing)
      class(quadrature_lsd_t), intent(in) :: self

      differing = .true.
   end function lsd_differing
end module quadrature_lsd
