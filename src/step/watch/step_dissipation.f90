! SPDX-License-Identifier: BSD-3-Clause
!> Records the kinetic energy that artificial viscosity, plastic flow, the PIC fraction and the
!! strain dissipate in a step.
module step_dissipation
   use base_kinds, only: wp
   use material_state, only: deformation_t, material_state_t
   use material_type, only: material_t
   use particle_store, only: store_t
   use step_ledger, only: damped, dissipated, ledger_t, plastic, viscous
   use step_method, only: method_t, stress_after
   implicit none
   private

   public :: record_damped, record_damping, record_losses, record_unresolved, measures_damping, &
      measures_update

contains

   !> Record the work of artificial viscosity and plastic flow.
   subroutine record_losses(ledger, material, state, deformation, count)
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      type(material_t), intent(in) :: material       !! Materials with dissipation
      type(material_state_t), intent(in) :: state           !! Existing fields
      type(deformation_t), intent(in) :: deformation !! The step of the particles
      integer, intent(in) :: count                   !! Particles
      real(wp) :: losses(2)
      logical :: flows

      losses = 0.0_wp
      flows = allocated(material%failure%fracture)
      if (allocated(material%law)) flows = flows .or. material%law%is_plastic()
      if (allocated(material%viscosity)) then
         losses(1) = sum(deformation%viscous_work(:count))
         call ledger%sums(viscous)%add(losses(1))
      end if
      if (flows) then
         losses(2) = sum(deformation%plastic_work(:count))
         call ledger%sums(plastic)%add(losses(2))
      end if
      ! materials with an internal energy include this work in it
      if (.not. allocated(state%energy)) call ledger%sums(dissipated)%add(losses(1) + losses(2))
   end subroutine record_losses

   !> Does the PIC fraction dissipate kinetic energy that is not recorded elsewhere, and can this
   !! loss be measured?
   pure logical function measures_damping(method, carries) result(measurable)
      type(method_t), intent(in) :: method           !! Method with its transfer
      logical, intent(in) :: carries                 !! Is there an internal energy?

      ! with musl the strain uses the damped velocity, so this energy is not lost
      measurable = .not. carries .and. (method%averages() .or. .not. method%remaps()) &
         .and. method%leapfrog &
         .and. method%transfer%flip_fraction() > 0.0_wp &
         .and. method%transfer%flip_fraction() < 1.0_wp
   end function measures_damping

   !> Record the kinetic energy that the PIC fraction removes from the particles of a tile. With the
   !! advection velocity c, FLIP alone would give them the velocity (v - (1 - f) c)/f, which is
   !! larger by (1 - f)/f (v - c). Equation (L.12) of doc/theory/ledger.md.
   subroutine record_damping(ledger, store, tile, moved, keep)
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      type(store_t), intent(in) :: store             !! The particles after the step
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: moved(:, :) !! (particle of the tile, 3) c [m/s]
      real(wp), intent(in) :: keep                   !! FLIP fraction f [1]
      real(wp) :: taken(3), lost
      integer :: p, q, k

      taken = 0.0_wp
      do k = 1, 3
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            lost = (1.0_wp - keep)/keep*(store%velocity(q, k) - moved(p, k))
            taken(k) = taken(k) + store%state%mass(q)*lost*(store%velocity(q, k) + 0.5_wp*lost)
         end do
      end do
      call record_damped(ledger, sum(taken))
   end subroutine record_damping

   !> Can the energy that the strain dissipates be measured? It is recorded in scenes with loose
   !! grains, whose default update is chosen for this damping. Elsewhere it is an error of the
   !! energy.
   pure logical function measures_update(method, carries) result(measurable)
      type(method_t), intent(in) :: method           !! Method with its transfer
      logical, intent(in) :: carries                 !! Is there an internal energy?

      measurable = .not. carries .and. method%stress == stress_after .and. method%leapfrog &
         .and. method%transfer%flip_fraction() > 0.0_wp
      ! particles with a whole linear velocity field resolve more than their gain
      if (method%transfer%affine()) measurable = measurable .and. method%transfer%turning()
   end function measures_update

   !> Record the work of the stress on the gain of the nodes that the particles of a tile do not
   !! get: the variance of the gain over the nodes around each particle. Equation (L.13) of
   !! doc/theory/ledger.md.
   subroutine record_unresolved(ledger, store, tile, axes, gain)
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer, intent(in) :: axes                    !! Active directions
      !> (particle of the tile, axes + 1) Gain of the particle [m/s]; mean product of the gain of
      !! its nodes and that in their strain [m2/s2]
      real(wp), contiguous, intent(in) :: gain(:, :)
      real(wp) :: lost, part
      integer :: p, k

      lost = 0.0_wp
      do p = 1, store%count(tile)
         part = gain(p, axes + 1)
         do k = 1, axes
            part = part - gain(p, k)**2
         end do
         lost = lost + store%state%mass(store%first(tile) + p - 1)*part
      end do
      call record_damped(ledger, lost)
   end subroutine record_unresolved

   !> Record energy of motion that nodes or particles do not resolve.
   subroutine record_damped(ledger, energy)
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      real(wp), intent(in) :: energy                 !! [J]

      call ledger%sums(damped)%add(energy)
      call ledger%sums(dissipated)%add(energy)
   end subroutine record_damped
end module step_dissipation
