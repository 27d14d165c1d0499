! SPDX-License-Identifier: BSD-3-Clause
!> Strain of two velocities (`stress_update = 'usavg'`): one half with the velocity that particles
!! get from the nodes in a step, one half with the velocity that they bring to the nodes after they
!! have moved.
!!
!! Stress and motion then work with the same mean velocities, so one gains the energy that the other
!! loses (J. A. Nairn, Comput. Model. Eng. Sci. 4 (2003) 649). The second half is known only when
!! the particles have moved, after the force of the next step. So each step predicts it at the
!! present positions and keeps it, and the next step replaces it by the computed one. Equation
!! (T.9) of doc/theory/transfers.md.
module step_strain_average
   use base_kinds, only: wp
   use particle_store, only: store_t, unknown_strain
   implicit none
   private

   public :: average_strain, keep_earlier

   !> Greatest correction of a half strain [1]; in regularly filled cells it is far smaller, and
   !! where streams of particles cross it must not invert them
   real(wp), parameter :: most = 0.1_wp

contains

   !> Keep half of the strain of the particle velocities on the nodes as a prediction. Both
   !! strains refer to the middle of their step: positions are those at the end of the first and at
   !! the begin of the second.
   pure subroutine keep_earlier(count, gradient, earlier)
      integer, intent(in) :: count                   !! Particles of the tile
      real(wp), contiguous, intent(in) :: gradient(:, :) !! (particle of the tile, 9) [1]
      real(wp), allocatable, intent(inout) :: earlier(:, :) !! (particle of the tile, 9) [1]
      integer :: p, k

      if (allocated(earlier)) then
         if (size(earlier, 1) < count) deallocate (earlier)
      end if
      if (.not. allocated(earlier)) allocate (earlier(size(gradient, 1), 9))
      do k = 1, 9
         do p = 1, count
            earlier(p, k) = 0.5_wp*gradient(p, k)
         end do
      end do
   end subroutine keep_earlier

   !> Correct the predicted half strain of the last step, unless it is unknown, and predict that of
   !! this step.
   pure subroutine average_strain(store, tile, earlier, gradient)
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: earlier(:, :) !! (particle of the tile, 9) Half strain [1]
      !> (particle of the tile, 9) In: strain of the advection velocity; out: strain of the step [1]
      real(wp), contiguous, intent(inout) :: gradient(:, :)
      real(wp) :: half, error
      integer :: p, q, k

      do k = 1, 9
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            half = 0.5_wp*gradient(p, k)
            error = merge(0.0_wp, earlier(p, k) - store%ahead(q, k), &
               abs(store%ahead(q, k)) >= unknown_strain)
            gradient(p, k) = gradient(p, k) + min(most, max(-most, error))
            store%ahead(q, k) = half
         end do
      end do
   end subroutine average_strain
end module step_strain_average
