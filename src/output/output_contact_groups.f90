! SPDX-License-Identifier: BSD-3-Clause
!> Groups of material that can be in one fragment: the bodies of a velocity field, and of fields
!! that bonds join.
module output_contact_groups
   use sample_fragments, only: fragments_t
   use step_simulation, only: simulation_t
   use transfer_contact, only: contact_bonded
   implicit none
   private

   public :: separate_bodies_in_contact

contains

   !> Set the groups of the stores whose cells are not connected: bodies in contact have separate
   !! velocities. Without contact all material is one group.
   pure subroutine separate_bodies_in_contact(simulation, fragments)
      type(simulation_t), intent(in) :: simulation
      type(fragments_t), intent(inout) :: fragments
      integer :: group(size(simulation%fields)), a, b

      if (.not. allocated(simulation%effects%contact)) return
      if (allocated(fragments%group)) return
      group = [(a - 1, a=1, size(group))]
      do b = 2, size(group)
         do a = 1, b - 1
            if (simulation%effects%contact%law(a, b)%kind == contact_bonded) &
               where (group == group(b)) group = group(a)
         end do
      end do
      allocate (fragments%group(size(simulation%stores)), source=0)
      do a = 1, size(group)
         fragments%group(simulation%fields(a)%first_store:simulation%fields(a)%last_store) = &
            group(a)
      end do
   end subroutine separate_bodies_in_contact
end module output_contact_groups
