! SPDX-License-Identifier: BSD-3-Clause
!> The numerical method of a run, as plain numbers.
module driver_method
   use base_kinds, only: wp
   use ddmp_alpha, only: alpha_split
   implicit none
   private

   public :: method_t

   integer, parameter, public :: stress_after = 1    !! usl: with the new node velocities
   integer, parameter, public :: stress_before = 2   !! usf: before the force
   integer, parameter, public :: stress_remapped = 3 !! musl: with node velocities mapped anew
   character(len=4), parameter, public :: stress_names(3) = ["usl ", "usf ", "musl"]

   integer, parameter, public :: transfer_flip = 1   !! Increments, with a share of pic
   integer, parameter, public :: transfer_pic = 2    !! Values
   integer, parameter, public :: transfer_xpic = 3   !! Values without the loss of the smooth part
   character(len=4), parameter, public :: transfer_names(3) = ["flip", "pic ", "xpic"]

   !> Choices of the numerical method.
   type :: method_t
      logical :: dual = .true.                       !! Dual domain gradient, else the plain one
      integer :: alpha = alpha_split                 !! Form of alpha
      real(wp) :: alpha_centre = 1.0_wp              !! alpha at the centre of a cell [1]
      integer :: stress = stress_after               !! When the stress is updated
      integer :: transfer = transfer_flip            !! How velocities come back to particles
      real(wp) :: flip = 0.999_wp                    !! Share of increments in flip [1]
      real(wp) :: cfl = 0.4_wp !! Share of the time a signal needs for a cell [1]
      real(wp) :: step_growth = 1.1_wp               !! Greatest ratio of successive time steps [1]
   contains
      procedure :: keep => method_keep               !! Share of its velocity that a particle keeps
      procedure :: lead => method_lead !! Share of a step by which stress is ahead of velocity
   end type method_t

contains

   !> Share of its own velocity that a particle keeps in a step.
   pure real(wp) function method_keep(self) result(keep)
      class(method_t), intent(in) :: self            !! The method

      select case (self%transfer)
      case (transfer_flip)
         keep = self%flip
      case default
         keep = 0.0_wp
      end select
   end function method_keep

   !> Share of a step by which the time of the stress is ahead of that of position and velocity.
   !!
   !! The stress takes the strain of a whole step at once, with the velocity at its end (usl, musl)
   !! or its beginning (usf): that is the velocity in the middle of the time over which the stress
   !! goes on only if stress and velocity are half a step apart.
   pure real(wp) function method_lead(self) result(lead)
      class(method_t), intent(in) :: self            !! The method

      lead = merge(-0.5_wp, 0.5_wp, self%stress == stress_before)
   end function method_lead
end module driver_method
