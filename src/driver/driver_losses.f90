! SPDX-License-Identifier: BSD-3-Clause
!> What artificial viscosity and plastic flow take from motion in a step, in the books.
module driver_losses
   use base_kinds, only: wp
   use driver_ledger, only: dissipated, ledger_t, plastic, viscous
   use material_matter, only: deformation_t, matter_t
   use material_type, only: material_t
   implicit none
   private

   public :: book_losses

contains

   !> Book what artificial viscosity and plastic flow took.
   subroutine book_losses(ledger, material, matter, deformation, count)
      type(ledger_t), intent(inout) :: ledger        !! Of this thread
      type(material_t), intent(in) :: material       !! What can lose at all
      type(matter_t), intent(in) :: matter           !! Which fields there are
      type(deformation_t), intent(in) :: deformation !! The step of the particles
      integer, intent(in) :: count                   !! Particles
      real(wp) :: losses(2)
      logical :: flows

      losses = 0.0_wp
      flows = allocated(material%fracture)
      if (allocated(material%law)) flows = flows .or. material%law%plastic()
      if (allocated(material%viscosity)) then
         losses(1) = sum(deformation%viscous_work(:count))
         call ledger%sums(viscous)%add(losses(1))
      end if
      if (flows) then
         losses(2) = sum(deformation%plastic_work(:count))
         call ledger%sums(plastic)%add(losses(2))
      end if
      ! with an internal energy these are a part of it
      if (.not. allocated(matter%energy)) call ledger%sums(dissipated)%add(losses(1) + losses(2))
   end subroutine book_losses
end module driver_losses
