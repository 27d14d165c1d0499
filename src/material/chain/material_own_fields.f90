! SPDX-License-Identifier: BSD-3-Clause
!> The fields that single models of the catalogue request and describe.
module material_own_fields
   use material_catalogue, only: choose_damage, choose_eos, choose_law, damage_names, eos_names, &
      law_names
   use material_damage, only: damage_t
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_t
   use material_tension, only: request_fading
   implicit none
   private

   public :: own_fields

contains

   !> Own fields of all models, each once, with those that request them as reason.
   function own_fields() result(own)
      type(field_requests_t) :: own
      type(field_requests_t) :: requests
      class(law_t), allocatable :: law
      class(eos_t), allocatable :: eos
      class(damage_t), allocatable :: damage
      integer :: i

      do i = 1, size(eos_names)
         call choose_eos(trim(eos_names(i)), eos)
         call eos%request(requests)
      end do
      do i = 1, size(law_names)
         call choose_law(trim(law_names(i)), law)
         call law%request(requests)
      end do
      do i = 1, size(damage_names)
         call choose_damage(trim(damage_names(i)), damage)
         call damage%request(requests)
      end do
      call request_fading(requests)
      do i = 1, size(requests%entries)
         associate (entry => requests%entries(i))
            if (entry%own) call own%add_own(entry%field, entry%unit, entry%meaning, entry%reason)
         end associate
      end do
   end function own_fields
end module material_own_fields
