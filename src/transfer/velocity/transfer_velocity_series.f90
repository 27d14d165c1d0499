! SPDX-License-Identifier: BSD-3-Clause
!> Velocity transfers that filter the node velocity with a series, and the kinetic energy that they
!! lose.
!!
!! With the inner product of node masses A = 1 - S^+ S has <y, A y> = sum m_p var_p(y) >= 0, var_p
!! the variance of node values under the functions at a particle. The whole loss then consists of
!! <y_0, A**n y_0> with integer n: products of neighbouring terms of the series, which are sums over
!! nodes, and for the greatest n = 2 k - 1 the variance of the last term, which needs the particles.
!! None depends on a uniform velocity. Terms that only carry energy from particle to particle, and
!! add up to zero, are left out. (Derived for this program; with k = 1 it is `gather_heat` of PIC.)
!! Equations (T.11) and (T.12) of doc/theory/transfers.md.
module transfer_velocity_series
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use mesh_grid, only: grid_t
   use transfer_basis, only: basis_t
   use transfer_shape_data, only: shape_data_t
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: velocity_series_t

   !> A transfer with a series.
   type, abstract, extends(velocity_t) :: velocity_series_t
      integer :: order = 2                           !! Number k of terms, the first one included
   contains
      procedure :: read => series_read               !! Order
      procedure :: sweeps => series_sweeps           !! All terms but the first
      procedure :: heat => series_heat               !! Lost kinetic energy
      procedure(mixing_i), deferred :: mixing        !! Factors of gathered fields in `heat`
   end type velocity_series_t

   abstract interface
      !> Factors of squares and products of a dt and y_(k-1) at a particle that are subtracted from
      !! the heat: a.a, y.y, a.y, and a.x with the first field.
      pure function mixing_i(self) result(factors)
         import :: velocity_series_t, wp
         implicit none
         class(velocity_series_t), intent(in) :: self
         real(wp) :: factors(4)
      end function mixing_i
   end interface

contains

   !> Read the order.
   subroutine series_read(self, deck, group)
      class(velocity_series_t), intent(inout) :: self
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group

      call group%get("order_k", self%order)
   end subroutine series_read

   !> Terms after the first one.
   pure integer function series_sweeps(self) result(sweeps)
      class(velocity_series_t), intent(in) :: self

      sweeps = self%order - 1
   end function series_sweeps

   !> Heat 1/2 |v - S x|**2 + S scalar - (factors of squares and products at the particle).
   ! gate: long kernel because columns of a tile are arguments of their own
   pure subroutine series_heat(self, grid, basis, shape, first, fields, scalar, velocity, energy)
      class(velocity_series_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      class(basis_t), intent(in) :: basis
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: fields(:, :)       !! (9, node) x, a dt, y_(k-1) [m/s]
      real(wp), contiguous, intent(in) :: scalar(:, :)       !! (1, node) [J/kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) Before the step [m/s]
      real(wp), contiguous, intent(inout) :: energy(:)       !! (particle) [J/kg]
      real(wp) :: factors(4), gain, last, rest, heat
      integer :: p, q, k

      factors = self%mixing()
      call basis%gather_values(grid, shape, scalar, shape%vector)
      call basis%gather_values(grid, shape, fields, shape%values)
      do p = 1, shape%count
         q = first + p - 1
         heat = shape%vector(p, 1)
         do k = 1, 3
            rest = velocity(q, k) - shape%values(p, k)
            gain = shape%values(p, 3 + k)
            last = shape%values(p, 6 + k)
            heat = heat + 0.5_wp*rest*rest - factors(1)*gain*gain - factors(2)*last*last &
               - factors(3)*gain*last - factors(4)*gain*shape%values(p, k)
         end do
         energy(q) = energy(q) + heat
      end do
   end subroutine series_heat
end module transfer_velocity_series
