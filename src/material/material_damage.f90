! SPDX-License-Identifier: BSD-3-Clause
!> What a damage model is: it lets the damage of a particle grow from 0 to 1.
module material_damage
   use base_deck_group, only: group_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use material_effects, only: effects_t
   use material_matter, only: deformation_t, matter_t
   use material_wishes, only: wishes_t
   implicit none
   private

   public :: damage_t

   !> A damage model. The flag of failure is set by the material where damage has reached 1.
   type, abstract :: damage_t
   contains
      procedure(declare_i), deferred :: declare      !! Declares its keys
      procedure(read_i), deferred :: read            !! Reads its keys
      procedure(request_i), deferred :: request      !! Asks for the fields it needs
      procedure(update_i), deferred :: update        !! Lets the damage grow
   end type damage_t

   abstract interface
      subroutine declare_i(self, schema)
         import :: damage_t, schema_t
         implicit none
         class(damage_t), intent(in) :: self
         type(schema_t), intent(inout) :: schema               !! Keys of the deck
      end subroutine declare_i

      pure subroutine read_i(self, group, effects)
         import :: damage_t, effects_t, group_t
         implicit none
         class(damage_t), intent(inout) :: self
         type(group_t), intent(in) :: group                    !! &material
         type(effects_t), intent(in) :: effects                !! What is asked for
      end subroutine read_i

      pure subroutine request_i(self, wishes)
         import :: damage_t, wishes_t
         implicit none
         class(damage_t), intent(in) :: self
         class(wishes_t), intent(inout) :: wishes              !! Fields to be carried
      end subroutine request_i

      !> On entry the stress holds the deviator after the law, and pressure and plastic increment
      !! are those after the step.
      pure subroutine update_i(self, matter, deformation, first, last, dt)
         import :: damage_t, deformation_t, matter_t, wp
         implicit none
         class(damage_t), intent(in) :: self
         type(matter_t), intent(inout) :: matter               !! State of the store
         type(deformation_t), intent(inout) :: deformation     !! Step of the range
         integer, intent(in) :: first                          !! First particle of the range
         integer, intent(in) :: last                           !! Last particle of the range
         real(wp), intent(in) :: dt                            !! Time step [s]
      end subroutine update_i
   end interface
end module material_damage
