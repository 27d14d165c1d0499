! SPDX-License-Identifier: BSD-3-Clause
!> Limits of tension, and the remaining strength of failed and melted particles.
!!
!! A failed particle is rubble: it keeps mass and volume, has no deviator and supports no tension.
module material_tension
   use base_kinds, only: wp
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: cut_tension, drop_loose_pressure, fade_tension, fade_t, fail_particles, &
      fracture_t, remove_failed_deviator, remove_melted_deviator, request_fading, spall_t

   !> Field with the share of the tensile strength that has faded.
   character(len=*), parameter :: faded_field = "spall_faded"

   !> Tension cut-off without failure.
   type :: spall_t
      real(wp) :: strength = huge(1.0_wp)            !! Greatest tension [Pa]
   end type spall_t

   !> Tensile strength that fades in a time.
   type :: fade_t
      real(wp) :: strength = huge(1.0_wp)            !! Tension at which pores begin to grow [Pa]
      real(wp) :: time = 0.0_wp                      !! Time in which no tension is left [s]
   end type fade_t

   !> Permanent failure, by damage and by tension.
   type :: fracture_t
      real(wp) :: strength = huge(1.0_wp)            !! Tension at failure [Pa]
      logical :: leaves_strength = .false.           !! Failed material follows a law
      logical :: leaves_nothing = .false.            !! Failed material has no stress
   end type fracture_t

contains

   !> Set the deviator of failed particles to zero.
   pure subroutine remove_failed_deviator(state, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: column, i

      if (.not. allocated(state%failed)) return
      if (sum(state%failed(first:last)) == 0) return
      do column = 1, 6
         do concurrent (i=first:last)
            state%stress(i, column) = merge(0.0_wp, state%stress(i, column), state%failed(i) /= 0)
         end do
      end do
   end subroutine remove_failed_deviator

   !> Set the deviator of melted particles to zero.
   pure subroutine remove_melted_deviator(melting, state, first, last)
      real(wp), intent(in) :: melting                      !! Temperature of melting [K]
      type(material_state_t), intent(inout) :: state       !! State of the store
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: column, i

      if (count(state%temperature(first:last) >= melting) == 0) return
      do column = 1, 6
         do concurrent (i=first:last)
            state%stress(i, column) = merge(0.0_wp, state%stress(i, column), &
               state%temperature(i) >= melting)
         end do
      end do
   end subroutine remove_melted_deviator

   !> Keep the pressure above a limit.
   pure subroutine cut_tension(strength, deformation, count)
      real(wp), intent(in) :: strength                     !! Greatest tension [Pa]
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: count                         !! Particles of the range
      integer :: i

      do concurrent (i=1:count)
         deformation%pressure_floor(i) = -strength
         deformation%pressure(i) = merge(-strength, deformation%pressure(i), &
            deformation%pressure(i) < -strength)
      end do
   end subroutine cut_tension

   !> Mark particles with complete damage or with tension at the limit as failed, and turn them into
   !! rubble, unless a law of failed material updates their deviator. The elastic energy that a
   !! particle loses on failing is recorded as plastic work. The least pressure of failed particles
   !! is 0 and their tension is removed; that of the others is minus the tensile strength. Equations
   !! (A.7) and (A.9) of doc/theory/matter.md.
   pure subroutine fail_particles(fracture, shear, bulk, state, deformation, first, last)
      type(fracture_t), intent(in) :: fracture
      real(wp), intent(in) :: shear                        !! Shear modulus, 0: no deviator [Pa]
      real(wp), intent(in) :: bulk                         !! Bulk modulus, 0 for a gas [Pa]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: cut, least
      integer :: i, k

      least = -fracture%strength
      ! Usually no particle fails now.
      if (count(state%failed(first:last) == 0 .and. .not. (state%damage(first:last) < 1.0_wp .and. &
         deformation%pressure(:last - first + 1) > least)) > 0) then
         do i = 1, last - first + 1
            k = first - 1 + i
            if (state%failed(k) /= 0 .or. &
               (state%damage(k) < 1.0_wp .and. deformation%pressure(i) > least)) cycle
            state%failed(k) = 1
            state%damage(k) = 1.0_wp
            if (bulk > 0.0_wp) deformation%plastic_work(i) = deformation%plastic_work(i) &
               + state%volume(k)*0.5_wp*min(deformation%pressure(i), 0.0_wp)**2/bulk
            if (fracture%leaves_strength) cycle
            if (shear > 0.0_wp) deformation%plastic_work(i) = deformation%plastic_work(i) &
               + state%volume(k)*0.25_wp/shear*(state%stress(k, 1)**2 + state%stress(k, 2)**2 &
               + state%stress(k, 3)**2 + 2.0_wp*(state%stress(k, 4)**2 + state%stress(k, 5)**2 &
               + state%stress(k, 6)**2))
            state%stress(k, :) = 0.0_wp
         end do
      end if
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         cut = merge(0.0_wp, deformation%pressure(i), deformation%pressure(i) < 0.0_wp)
         deformation%pressure_floor(i) = merge(0.0_wp, least, state%failed(k) /= 0)
         deformation%pressure(i) = merge(cut, deformation%pressure(i), state%failed(k) /= 0)
      end do
   end subroutine fail_particles

   !> Request the share of the strength that has faded.
   pure subroutine request_fading(requests)
      class(field_requests_t), intent(inout) :: requests

      call requests%add_own(faded_field, "1", "share of the spall strength that has faded", &
         "spall_time")
   end subroutine request_fading

   !> Cut the tension of particles that have not failed at what is left of their strength. The rest
   !! fades at a constant rate while tension is at the limit; without rest the damage is complete.
   !! Equation (A.8) of doc/theory/matter.md.
   pure subroutine fade_tension(fade, state, deformation, first, last, dt)
      type(fade_t), intent(in) :: fade
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: faded, least, share
      logical :: pulled
      integer :: i, k, own

      share = dt/fade%time
      own = state%own_index(faded_field)
      associate (before => state%own(own)%values)
         do i = 1, last - first + 1
            k = first - 1 + i
            if (state%failed(k) /= 0) cycle
            least = -fade%strength*(1.0_wp - before(k))
            pulled = deformation%pressure(i) < least
            faded = min(1.0_wp, before(k) + merge(share, 0.0_wp, pulled))
            before(k) = faded
            least = -fade%strength*(1.0_wp - faded)
            deformation%pressure_floor(i) = least
            deformation%pressure(i) = max(deformation%pressure(i), least)
            state%damage(k) = merge(1.0_wp, state%damage(k), faded >= 1.0_wp)
         end do
      end associate
   end subroutine fade_tension

   !> Without equation of state the mean stress does not depend on voids: rubble less dense than the
   !! material supports no pressure, and its wave speed is at most that of the material.
   pure subroutine drop_loose_pressure(density, bulk, state, deformation, first, last)
      real(wp), intent(in) :: density                      !! Of the reference state [kg/m3]
      real(wp), intent(in) :: bulk                         !! Bulk modulus [Pa]
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: excess, limit
      integer :: i, k

      limit = bulk/density
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         excess = state%mass(k) - density*state%volume(k)
         excess = merge(excess, 0.0_wp, state%failed(k) /= 0)
         deformation%pressure(i) = merge(0.0_wp, deformation%pressure(i), excess < 0.0_wp)
         deformation%wave_speed(i) = merge(limit, deformation%wave_speed(i), excess < 0.0_wp)
      end do
   end subroutine drop_loose_pressure
end module material_tension
