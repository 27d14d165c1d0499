! SPDX-License-Identifier: BSD-3-Clause
!> Linear elasticity in rate form: the deviator is the elastic trial.
module law_elastic
   use base_kinds, only: wp
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_elastic_t

   !> Elastic law with Jaumann rate.
   type, extends(law_t) :: law_elastic_t
   contains
      procedure :: is_plastic => elastic_is_plastic  !! False: there is no flow
      procedure :: update => elastic_update          !! Keeps the trial
   end type law_elastic_t

contains

   !> An elastic law does not flow.
   pure logical function elastic_is_plastic(self) result(plastic)
      class(law_elastic_t), intent(in) :: self

      plastic = .false.
   end function elastic_is_plastic

   !> The trial deviator is already the result.
   pure subroutine elastic_update(self, state, deformation, first, last, dt)
      class(law_elastic_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
   end subroutine elastic_update
end module law_elastic
