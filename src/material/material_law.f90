! SPDX-License-Identifier: BSD-3-Clause
!> What a law of strength is: it corrects the deviator of the stress after an elastic trial.
module material_law
   use base_deck_group, only: group_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use material_effects, only: effects_t
   use material_kinematics, only: predict_deviator
   use material_matter, only: deformation_t, matter_t
   use material_wishes, only: wishes_t
   implicit none
   private

   public :: equivalent_stress, law_t

   !> A law of strength. The material holds none if it has no strength.
   type, abstract :: law_t
      real(wp) :: shear = 0.0_wp                     !! Shear modulus [Pa]
   contains
      procedure :: declare => law_declare            !! Declares its keys, if it has any
      procedure :: read => law_read                  !! Reads its keys
      procedure :: plastic => law_plastic            !! True if it flows plastically
      procedure(request_i), deferred :: request      !! Asks for the fields it needs
      procedure :: predict => law_predict            !! Trial deviator of the step
      procedure(update_i), deferred :: update        !! Corrects the trial deviator
   end type law_t

   abstract interface
      pure subroutine request_i(self, wishes)
         import :: law_t, wishes_t
         implicit none
         class(law_t), intent(in) :: self
         class(wishes_t), intent(inout) :: wishes              !! Fields to be carried
      end subroutine request_i

      !> On entry the stress holds the trial deviator, on return the deviator. Plastic increment and
      !! plastic work are zero on entry.
      pure subroutine update_i(self, matter, deformation, first, last, dt)
         import :: deformation_t, law_t, matter_t, wp
         implicit none
         class(law_t), intent(in) :: self
         type(matter_t), intent(inout) :: matter               !! State of the store
         type(deformation_t), intent(inout) :: deformation     !! Step of the range
         integer, intent(in) :: first                          !! First particle of the range
         integer, intent(in) :: last                           !! Last particle of the range
         real(wp), intent(in) :: dt                            !! Time step [s]
      end subroutine update_i
   end interface

contains

   !> Declare the keys of &material that belong to the law. Most laws override this.
   subroutine law_declare(self, schema)
      class(law_t), intent(in) :: self                         !! The law
      type(schema_t), intent(inout) :: schema                  !! Keys of the deck
   end subroutine law_declare

   !> Read the keys that belong to the law. The shear modulus is set by the material.
   pure subroutine law_read(self, group, effects)
      class(law_t), intent(inout) :: self                      !! The law
      type(group_t), intent(in) :: group                       !! &material
      type(effects_t), intent(in) :: effects                   !! What is asked for
   end subroutine law_read

   !> True if the law flows plastically, which damage by plastic strain needs.
   pure logical function law_plastic(self) result(plastic)
      class(law_t), intent(in) :: self                         !! The law

      plastic = .true.
   end function law_plastic

   !> Elastic trial of the deviator with constant shear modulus and Jaumann rate, and the volume.
   pure subroutine law_predict(self, matter, deformation, first, last)
      class(law_t), intent(in) :: self                         !! The law
      type(matter_t), intent(inout) :: matter                  !! State of the store
      type(deformation_t), intent(inout) :: deformation        !! Step of the range
      integer, intent(in) :: first                             !! First particle of the range
      integer, intent(in) :: last                              !! Last particle of the range

      call predict_deviator(first, last, self%shear, deformation%gradient, matter%volume, &
         matter%stress, deformation%old_volume, deformation%dilatation, deformation%pressure)
   end subroutine law_predict

   !> Equivalent stress of von Mises of deviators: sqrt(3/2 s:s).
   pure subroutine equivalent_stress(first, last, stress, equivalent)
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), contiguous, intent(in) :: stress(:, :)         !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: equivalent(:)     !! (range) [Pa]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         equivalent(i) = sqrt(1.5_wp*(stress(k, 1)**2 + stress(k, 2)**2 + stress(k, 3)**2 &
            + 2.0_wp*(stress(k, 4)**2 + stress(k, 5)**2 + stress(k, 6)**2)))
      end do
   end subroutine equivalent_stress
end module material_law
