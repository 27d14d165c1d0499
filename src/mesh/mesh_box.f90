! SPDX-License-Identifier: BSD-3-Clause
!> A periodic cell whose edges are columns of a matrix that follows a uniform velocity gradient.
!!
!! Positions are r = h s with the edges h and coordinates s in [0, 1). The cell is sheared by
!! tilting its edges (A. W. Lees, S. F. Edwards, J. Phys. C 5 (1972) 1921, in coordinates that move
!! along); an edge that tilts by more than half of another one is replaced by the equivalent edge on
!! the other side.
module mesh_box
   use base_kinds, only: wp
   use base_matrix, only: determinant, inverse
   implicit none
   private

   public :: box_t

   !> The cell. In two dimensions it is 1 m thick and the third edge never changes.
   type :: box_t
      integer :: dimension = 3                       !! 2 or 3
      integer :: normal = 2                          !! Axis across which x is sheared
      real(wp) :: edges(3, 3) = 0.0_wp               !! (component, edge), upper triangular [m]
      real(wp) :: gradient(3, 3) = 0.0_wp            !! du_i/dx_j, upper triangular [1/s]
      real(wp) :: strain = 0.0_wp                    !! Integral of the sizes of shear rates [1]
   contains
      procedure :: volume => box_volume              !! Volume of the cell [m3]
      procedure :: heights => box_heights            !! Distances of its faces [m]
      procedure :: advance => box_advance            !! Deform it for a time step
      procedure :: reduce => box_reduce              !! Replace an edge that tilts too far
   end type box_t

contains

   !> Volume of the cell [m3].
   pure real(wp) function box_volume(self) result(volume)
      class(box_t), intent(in) :: self

      volume = self%edges(1, 1)*self%edges(2, 2)*self%edges(3, 3)
   end function box_volume

   !> Distances between opposite faces; those of a direction that does not exist are huge [m].
   pure function box_heights(self) result(height)
      class(box_t), intent(in) :: self
      real(wp) :: height(3)
      real(wp) :: dual(3, 3)
      integer :: axis

      dual = inverse(self%edges)
      height = huge(1.0_wp)
      do axis = 1, self%dimension
         height(axis) = 1.0_wp/norm2(dual(axis, :))
      end do
   end function box_heights

   !> Deform the cell by its velocity gradient L for a time step. With
   !! h1 = (1 - L dt/2)^-1 (1 + L dt/2) h0 and the mean h of both, the change of the edges is
   !! dt L h: work of the stress on the cell and on the grains then agree to second order.
   pure subroutine box_advance(self, dt, mean_dual)
      class(box_t), intent(inout) :: self
      real(wp), intent(in) :: dt                     !! [s]
      real(wp), intent(out) :: mean_dual(3, 3)       !! Inverse of the mean edges [1/m]
      real(wp) :: half(3, 3), unit(3, 3), former(3, 3), dual(3, 3)
      integer :: axis

      unit = 0.0_wp
      do axis = 1, 3
         unit(axis, axis) = 1.0_wp
      end do
      half = 0.5_wp*dt*self%gradient
      former = self%edges
      dual = inverse(unit - half)
      half = matmul(unit + half, former)
      self%edges = matmul(dual, half)
      former = 0.5_wp*(former + self%edges)
      mean_dual = inverse(former)
      self%strain = self%strain + (abs(self%gradient(1, 2)) + abs(self%gradient(1, 3)) &
         + abs(self%gradient(2, 3)))*dt
   end subroutine box_advance

   !> Replace edges that tilt by more than half of a lower one. Coordinates change by
   !! s_lower = s_lower + steps(lower, upper) s_upper, in the order of `upper` from 3 to 2 and
   !! `lower` from upper - 1 to 1.
   pure subroutine box_reduce(self, steps)
      class(box_t), intent(inout) :: self
      real(wp), intent(out) :: steps(3, 3)           !! Subtracted whole edges
      integer :: lower, upper

      steps = 0.0_wp
      do upper = self%dimension, 2, -1
         do lower = upper - 1, 1, -1
            if (abs(self%edges(lower, upper)) <= 0.5_wp*self%edges(lower, lower)) cycle
            steps(lower, upper) = anint(self%edges(lower, upper)/self%edges(lower, lower))
            self%edges(:, upper) = self%edges(:, upper) - steps(lower, upper)*self%edges(:, lower)
         end do
      end do
   end subroutine box_reduce
end module mesh_box
