! SPDX-License-Identifier: BSD-3-Clause
!> The loops over grains of a time step, (G.2): velocity Verlet for velocities relative to the cell,
!! m du/dt = F - m L u with the velocity gradient L of the cell, which is upper triangular.
!!
!! Equations of doc/theory/grains.md.
module grains_motion
   use base_kinds, only: wp
   use base_matrix, only: inverse
   use grains_state, only: block_rows, grains_t
   implicit none
   private

   public :: finish_velocities, move_grains, start_velocities

contains

   !> First half of the change of the velocities.
   subroutine start_velocities(grains, g, dt)
      type(grains_t), intent(inout) :: grains
      real(wp), intent(in) :: g(3, 3)                !! Velocity gradient [1/s]
      real(wp), intent(in) :: dt                     !! [s]
      real(wp) :: half, factor, u(3)
      integer :: row

      half = 0.5_wp*dt
      !$omp parallel do default(none) shared(grains, g, half) private(row, factor, u) &
      !$omp schedule(static)
      do row = grains%first, grains%last
         factor = half/grains%mass(row)
         u = grains%velocity(:, row)
         grains%velocity(1, row) = u(1) + factor*grains%force(1, row) &
            - half*(g(1, 1)*u(1) + g(1, 2)*u(2) + g(1, 3)*u(3))
         grains%velocity(2, row) = u(2) + factor*grains%force(2, row) &
            - half*(g(2, 2)*u(2) + g(2, 3)*u(3))
         grains%velocity(3, row) = u(3) + factor*grains%force(3, row) - half*g(3, 3)*u(3)
         factor = half/grains%inertia(row)
         grains%spin(:, row) = grains%spin(:, row) + factor*grains%torque(:, row)
      end do
      !$omp end parallel do
   end subroutine start_velocities

   !> Move the own grains, and find the greatest displacement since the last neighbour search.
   subroutine move_grains(grains, h, from, m, dt, travel)
      type(grains_t), intent(inout) :: grains
      real(wp), intent(in) :: h(3, 3)                !! Edges at the end of the step [m]
      real(wp), intent(in) :: from(:, :) !! (axis, row) Coordinates when pairs were found
      real(wp), intent(in) :: m(3, 3)                !! Inverse of the mean edges [1/m]
      real(wp), intent(in) :: dt                     !! [s]
      real(wp), intent(out) :: travel                !! [m]
      real(wp) :: d(3), farthest
      integer :: row

      farthest = 0.0_wp
      !$omp parallel do default(none) shared(grains, h, m, from, dt) private(row, d) &
      !$omp schedule(static) reduction(max:farthest)
      do row = grains%first, grains%last
         d = grains%velocity(:, row)
         grains%place(1, row) = grains%place(1, row) &
            + dt*(m(1, 1)*d(1) + m(1, 2)*d(2) + m(1, 3)*d(3))
         grains%place(2, row) = grains%place(2, row) + dt*(m(2, 2)*d(2) + m(2, 3)*d(3))
         grains%place(3, row) = grains%place(3, row) + dt*m(3, 3)*d(3)
         d = grains%place(:, row)
         grains%position(1, row) = h(1, 1)*d(1) + h(1, 2)*d(2) + h(1, 3)*d(3)
         grains%position(2, row) = h(2, 2)*d(2) + h(2, 3)*d(3)
         grains%position(3, row) = h(3, 3)*d(3)
         d = d - from(:, row)
         d(1) = h(1, 1)*d(1) + h(1, 2)*d(2) + h(1, 3)*d(3)
         d(2) = h(2, 2)*d(2) + h(2, 3)*d(3)
         d(3) = h(3, 3)*d(3)
         farthest = max(farthest, d(1)**2 + d(2)**2 + d(3)**2)
      end do
      !$omp end parallel do
      travel = sqrt(farthest)
   end subroutine move_grains

   !> Second half of the change of the velocities, the adjoint of the first one, and the sums of
   !! m u u over blocks of rows.
   subroutine finish_velocities(grains, g, dt, squares)
      type(grains_t), intent(inout) :: grains
      real(wp), intent(in) :: g(3, 3)                !! Velocity gradient [1/s]
      real(wp), intent(in) :: dt                     !! [s]
      real(wp), intent(out) :: squares(:, :) !! (xx yy zz xy xz yz, own block) [J]
      real(wp) :: half, factor, d(3, 3), dual(3, 3), u(3), sums(6)
      integer :: block, row, first, last

      half = 0.5_wp*dt
      d = half*g
      do row = 1, 3
         d(row, row) = d(row, row) + 1.0_wp
      end do
      dual = inverse(d)
      !$omp parallel do default(none) shared(grains, dual, half, squares) &
      !$omp private(block, row, factor, u, sums, first, last) schedule(static)
      do block = 1, size(squares, 2)
         sums = 0.0_wp
         first = grains%first + (block - 1)*block_rows
         last = min(first + block_rows - 1, grains%last)
         do row = first, last
            factor = half/grains%mass(row)
            u = grains%velocity(:, row) + factor*grains%force(:, row)
            u(1) = dual(1, 1)*u(1) + dual(1, 2)*u(2) + dual(1, 3)*u(3)
            u(2) = dual(2, 2)*u(2) + dual(2, 3)*u(3)
            u(3) = dual(3, 3)*u(3)
            grains%velocity(:, row) = u
            factor = half/grains%inertia(row)
            grains%spin(:, row) = grains%spin(:, row) + factor*grains%torque(:, row)
            sums = sums + grains%mass(row)*[u(1)*u(1), u(2)*u(2), u(3)*u(3), u(1)*u(2), &
               u(1)*u(3), u(2)*u(3)]
         end do
         squares(:, block) = sums
      end do
      !$omp end parallel do
   end subroutine finish_velocities
end module grains_motion
