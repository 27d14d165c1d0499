! SPDX-License-Identifier: BSD-3-Clause
!> The modified gradient at the particle, applied to the difference of its stress from a mean stress
!! of the nodes; the mean stress is a linear function in each cell and is integrated exactly on the
!! grid (a control variate). Particle positions then affect only the small difference, so quadrature
!! errors decrease with the cell size, and uniform stress gives no force inside a body for any
!! particle positions. Momentum is conserved exactly, as the sum over nodes of both parts vanishes.
!! The strain is the adjoint of the force (`src/step/core/step_mean_strain.f90`), so its power is
!! that of the stress, and the volumes of particles in full cells change by those of the space.
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
      procedure :: controlled => control_controlled  !! The mean stress is subtracted
   end type quadrature_control_t

contains

   !> The mean stress is subtracted from the particles.
   pure logical function control_controlled(self) result(controlled)
      class(quadrature_control_t), intent(in) :: self

      controlled = .true.
   end function control_controlled
end module quadrature_control
