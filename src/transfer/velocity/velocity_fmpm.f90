! SPDX-License-Identifier: BSD-3-Clause
!> FMPM of order k: the node velocity after the forces is replaced by the sum of k terms of the
!! series, which approximates the inverse of the full mass matrix. J. A. Nairn, C. C. Hammerquist,
!! Comput. Methods Appl. Mech. Eng. 377 (2021) 113667; but the position moves with the new velocity,
!! because velocities are defined midway between positions. Equation (T.7) of
!! doc/theory/transfers.md.
module velocity_fmpm
   use base_kinds, only: wp
   use deck_schema, only: schema_t
   use transfer_velocity_series, only: velocity_series_t
   implicit none
   private

   public :: velocity_fmpm_t

   !> Series of the velocity after the forces.
   type, extends(velocity_series_t) :: velocity_fmpm_t
   contains
      procedure :: declare => fmpm_declare           !! No keys of its own
      procedure :: first_term => fmpm_first_term     !! Velocity after the forces
      procedure :: loss_weight => fmpm_loss_weight   !! Weight of terms in the lost energy
      procedure :: velocity_increment => fmpm_increment !! Velocity increment
      procedure :: advection_velocity => fmpm_advection !! Advection velocity
      procedure :: heat_fields => fmpm_heat_fields   !! Node fields of the lost energy
      procedure :: mixing => fmpm_mixing             !! Factors of gathered fields in it
   end type velocity_fmpm_t

contains

   !> The order is declared by XPIC for both.
   subroutine fmpm_declare(self, schema)
      class(velocity_fmpm_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine fmpm_declare

   !> Velocity after the forces.
   pure subroutine fmpm_first_term(self, dt, velocity, acceleration, term)
      class(velocity_fmpm_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(inout) :: term(:, :)      !! (3, node) [m/s]

      term = velocity + dt*acceleration
   end subroutine fmpm_first_term

   !> Half the sum of the powers from k to 2 k - 1, less half of that from 1 to k - 1, which the
   !! transfer back gains; the loss in the transfer to the nodes outweighs it. The first power is a
   !! variance of the velocity itself and would include a uniform velocity on the nodes, so the
   !! particles compute it.
   pure real(wp) function fmpm_loss_weight(self, power) result(weight)
      class(velocity_fmpm_t), intent(in) :: self
      integer, intent(in) :: power                           !! Power of A

      weight = merge(0.5_wp, 0.0_wp, power < 2*self%order - 1)
      if (power < self%order) weight = -0.5_wp
      if (power == 1) weight = 0.0_wp
   end function fmpm_loss_weight

   !> The new velocity is the sum of the series alone.
   pure subroutine fmpm_increment(self, dt, acceleration, filtered, increment)
      class(velocity_fmpm_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series w [m/s]
      real(wp), contiguous, intent(inout) :: increment(:, :) !! (3, node) [m/s]

      increment = filtered
   end subroutine fmpm_increment

   !> The new velocity of the particles.
   pure subroutine fmpm_advection(self, dt, velocity, acceleration, filtered, advection)
      class(velocity_fmpm_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series w [m/s]
      real(wp), contiguous, intent(inout) :: advection(:, :) !! (3, node) [m/s]

      advection = filtered
   end subroutine fmpm_advection

   !> With y the last term, r = v - S u, a for a dt, and var and cov of node values at a particle:
   !! 1/2 r**2 in the transfer to the nodes, 1/2 var(u) - 1/2 var(u + a) there and back, 1/2 var(y)
   !! and the terms of the nodes. Order 1 is PIC and loses both variances. Equation (T.12).
   ! gate: long kernel because it uses all node fields
   pure subroutine fmpm_heat_fields(self, dt, velocity, acceleration, filtered, last, loss, &
      fields, scalar)
      class(velocity_fmpm_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series w [m/s]
      real(wp), contiguous, intent(in) :: last(:, :) !! (3, node) Last term y of the series [m/s]
      real(wp), contiguous, intent(in) :: loss(:, :)         !! (1, node) Dissipated energy [J/kg]
      real(wp), allocatable, intent(inout) :: fields(:, :)   !! (9, node) u, a dt, y
      real(wp), allocatable, intent(inout) :: scalar(:, :)   !! (1, node) [J/kg]

      if (.not. allocated(fields)) &
         allocate (fields(9, size(velocity, 2)), scalar(1, size(velocity, 2)))
      fields(1:3, :) = velocity
      fields(4:6, :) = dt*acceleration
      if (self%order == 1) then
         fields(7:9, :) = velocity
         scalar(1, :) = 0.5_wp*dt**2*sum(acceleration**2, dim=1) &
            + sum(velocity*(velocity + dt*acceleration), dim=1)
      else
         fields(7:9, :) = last
         scalar(1, :) = loss(1, :) + 0.5_wp*sum(last**2, dim=1) &
            - dt*sum(acceleration*(velocity + 0.5_wp*dt*acceleration), dim=1)
      end if
   end subroutine fmpm_heat_fields

   !> Of a.a, y.y, a.y and a.u. Order 1 is PIC, with u for y.
   pure function fmpm_mixing(self) result(factors)
      class(velocity_fmpm_t), intent(in) :: self
      real(wp) :: factors(4)

      if (self%order == 1) then
         factors = [0.5_wp, 1.0_wp, 1.0_wp, 0.0_wp]
      else
         factors = [-0.5_wp, 0.5_wp, 0.0_wp, -1.0_wp]
      end if
   end function fmpm_mixing
end module velocity_fmpm
