! SPDX-License-Identifier: BSD-3-Clause
!> The modified gradient at the particle, applied to the difference of its stress from a mean stress
!! of the nodes; the mean stress is a linear function in each cell and is integrated exactly on the
!! grid (a control variate). Particle positions then affect only the small difference, so quadrature
!! errors decrease with the cell size, and uniform stress gives no force inside a body for any
!! particle positions. Momentum is conserved exactly, as the sum over nodes of both parts vanishes;
!! the power of the force is not exactly that of the stress.
!!
!! The idea of a stress difference is that of A. Perez, M. Barclay, D. Z. Zhang, J. Comput. Phys.
!! (2023) 112681, whose form does not conserve momentum. Equation (Q.3) of
!! doc/theory/quadratures.md.
module quadrature_control
   use quadrature_point, only: quadrature_point_t
   implicit none
   private

   public :: quadrature_control_t

   !> Gradient at one point, with a control variate: the mean stress is subtracted.
   type, extends(quadrature_point_t) :: quadrature_control_t
   contains
      procedure :: margin => control_margin          !! Nodes beyond a tile that are used
      procedure :: controlled => control_controlled  !! The mean stress is subtracted
      procedure :: suits_cell => control_suits_cell  !! It integrates on a mesh at rest
   end type quadrature_control_t

contains

   !> A node is inside the body only if all nodes around it have material.
   pure integer function control_margin(self) result(margin)
      class(quadrature_control_t), intent(in) :: self

      margin = 1
   end function control_margin

   !> The mean stress is subtracted from the particles.
   pure logical function control_controlled(self) result(controlled)
      class(quadrature_control_t), intent(in) :: self

      controlled = .true.
   end function control_controlled

   !> The mean stress is integrated on a mesh at rest.
   pure logical function control_suits_cell(self) result(yes)
      class(quadrature_control_t), intent(in) :: self

      yes = .false.
   end function control_suits_cell
end module quadrature_control
