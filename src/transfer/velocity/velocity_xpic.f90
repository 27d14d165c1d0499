! SPDX-License-Identifier: BSD-3-Clause
!> XPIC of order k: the node velocity before the forces is replaced by the sum of k terms of the
!! series, so that particles lose only the components that nodes cannot represent; the acceleration
!! is added to it. C. Hammerquist, J. A. Nairn, Comput. Methods Appl. Mech. Eng. 318 (2017) 724; but
!! the position moves with the new node velocity, because velocities are defined midway between
!! positions. Equation (T.6) of doc/theory/transfers.md.
module velocity_xpic
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use transfer_velocity_series, only: velocity_series_t
   implicit none
   private

   public :: velocity_xpic_t

   !> Series of the velocity before the forces.
   type, extends(velocity_series_t) :: velocity_xpic_t
   contains
      procedure :: declare => xpic_declare           !! Order
      procedure :: read => xpic_read                 !! Reads it
      procedure :: loss_weight => xpic_loss_weight   !! Weight of terms in the lost energy
      procedure :: heat_fields => xpic_heat_fields   !! Node fields of the lost energy
      procedure :: mixing => xpic_mixing             !! Factors of gathered fields in it
   end type velocity_xpic_t

contains

   !> Declare the order, for all transfers that have one.
   subroutine xpic_declare(self, schema)
      class(velocity_xpic_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call schema%integer("method", "order_k", &
         "order of the velocity filter, the number of terms of its series; at least 2 for xpic", &
         default="2", range=">= 1 <= 100", owner="transfer = xpic fmpm")
   end subroutine xpic_declare

   !> Read the order. The first one is PIC.
   subroutine xpic_read(self, deck, group)
      class(velocity_xpic_t), intent(inout) :: self
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group

      call group%get("order_k", self%order)
      if (self%order < 2) call deck%add_error(group, "xpic of order 1 is the same as pic; "// &
         "write transfer = "// &
         "'pic' or order_k = 2", "order_k")
      self%order = max(self%order, 2)
   end subroutine xpic_read

   !> The lost energy is the sum of all terms from power k to 2 k - 1.
   pure real(wp) function xpic_loss_weight(self, power) result(weight)
      class(velocity_xpic_t), intent(in) :: self
      integer, intent(in) :: power                           !! Power of A

      weight = merge(1.0_wp, 0.0_wp, power >= self%order .and. power < 2*self%order - 1)
   end function xpic_loss_weight

   !> With y the last term, r = v - S w, a for a dt, and var and cov of node values at a particle:
   !! 1/2 r**2 + 1/2 var(a) + cov(a, y) + var(y) and the terms of the nodes. Equation (T.11).
   ! gate: long kernel because it uses all node fields
   pure subroutine xpic_heat_fields(self, dt, velocity, acceleration, filtered, last, loss, &
      fields, scalar)
      class(velocity_xpic_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series w [m/s]
      real(wp), contiguous, intent(in) :: last(:, :) !! (3, node) Last term y of the series [m/s]
      real(wp), contiguous, intent(in) :: loss(:, :)         !! (1, node) Dissipated energy [J/kg]
      real(wp), allocatable, intent(inout) :: fields(:, :)   !! (9, node) w, a dt, y
      real(wp), allocatable, intent(inout) :: scalar(:, :)   !! (1, node) [J/kg]

      if (.not. allocated(fields)) &
         allocate (fields(9, size(velocity, 2)), scalar(1, size(velocity, 2)))
      fields(1:3, :) = filtered
      fields(4:6, :) = dt*acceleration
      fields(7:9, :) = last
      scalar(1, :) = loss(1, :) + 0.5_wp*dt**2*sum(acceleration**2, dim=1) &
         + sum(last*(last + dt*acceleration), dim=1)
   end subroutine xpic_heat_fields

   !> Of a.a, y.y, a.y and a.w.
   pure function xpic_mixing(self) result(factors)
      class(velocity_xpic_t), intent(in) :: self
      real(wp) :: factors(4)

      factors = [0.5_wp, 1.0_wp, 1.0_wp, 0.0_wp]
   end function xpic_mixing
end module velocity_xpic
