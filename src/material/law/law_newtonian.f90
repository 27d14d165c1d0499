! SPDX-License-Identifier: BSD-3-Clause
!> Viscous fluid of Newton: the deviator of the stress is 2 eta times that of the rate of strain.
!! Equation (Y.16) of doc/theory/strength.md.
module law_newtonian
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_kinematics, only: dilate
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   use material_tension, only: remove_failed_deviator
   implicit none
   private

   public :: law_newtonian_t

   !> Law of Newton.
   type, extends(law_t) :: law_newtonian_t
      real(wp) :: viscosity = 0.0_wp                 !! eta [Pa s]
   contains
      procedure :: declare => newtonian_declare      !! Declares its key
      procedure :: read => newtonian_read            !! Reads its key
      procedure :: has_shear => newtonian_has_shear  !! It has no shear modulus
      procedure :: follows_density => newtonian_follows_density !! Its pressure has no rate form
      procedure :: predict_trial => newtonian_predict_trial !! Volume, there is no trial
      procedure :: update => newtonian_update        !! Viscous stress
      !> Limit of the time step by diffusion
      procedure :: add_viscous_speed => newtonian_add_viscous_speed
   end type law_newtonian_t

contains

   !> Declare the key of the law.
   subroutine newtonian_declare(self, schema)
      class(law_newtonian_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call schema%real("material", "viscosity", "viscosity of a Newtonian fluid", unit="Pa s", &
         range=">= 0", owner="effects.strength & strength_model = newtonian")
      call schema%require("material", "viscosity")
   end subroutine newtonian_declare

   !> Read the key of the law. All viscous work becomes heat.
   pure subroutine newtonian_read(self, group, effects)
      class(law_newtonian_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call group%get("viscosity", self%viscosity)
      self%heat_share = 1.0_wp
   end subroutine newtonian_read

   !> A fluid has no shear modulus: shear diffuses, has no wave speed and stores nothing.
   pure logical function newtonian_has_shear(self) result(has)
      class(law_newtonian_t), intent(in) :: self

      has = .false.
   end function newtonian_has_shear

   !> The stress is not a state variable, so it does not give the pressure of the previous step.
   pure logical function newtonian_follows_density(self) result(follows)
      class(law_newtonian_t), intent(in) :: self

      follows = .true.
   end function newtonian_follows_density

   !> Volume after the step.
   pure subroutine newtonian_predict_trial(self, state, deformation, first, last)
      class(law_newtonian_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call dilate(state, deformation, first, last)
   end subroutine newtonian_predict_trial

   !> Viscous stress and viscous work.
   pure subroutine newtonian_update(self, state, deformation, first, last, dt)
      class(law_newtonian_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: factor, mean, xx, yy, zz, xy, yz, xz, square
      integer :: i, k

      factor = self%viscosity/dt
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         mean = (deformation%gradient(i, 1) + deformation%gradient(i, 5) &
            + deformation%gradient(i, 9))/3.0_wp
         xx = deformation%gradient(i, 1) - mean
         yy = deformation%gradient(i, 5) - mean
         zz = deformation%gradient(i, 9) - mean
         xy = 0.5_wp*(deformation%gradient(i, 2) + deformation%gradient(i, 4))
         yz = 0.5_wp*(deformation%gradient(i, 6) + deformation%gradient(i, 8))
         xz = 0.5_wp*(deformation%gradient(i, 3) + deformation%gradient(i, 7))
         state%stress(k, 1) = 2.0_wp*factor*xx
         state%stress(k, 2) = 2.0_wp*factor*yy
         state%stress(k, 3) = 2.0_wp*factor*zz
         state%stress(k, 4) = 2.0_wp*factor*xy
         state%stress(k, 5) = 2.0_wp*factor*yz
         state%stress(k, 6) = 2.0_wp*factor*xz
         square = xx**2 + yy**2 + zz**2 + 2.0_wp*(xy**2 + yz**2 + xz**2)
         deformation%plastic_increment(i) = sqrt(2.0_wp/3.0_wp*square)
         deformation%plastic_work(i) = 2.0_wp*factor*square*state%volume(k)
      end do
      call remove_failed_deviator(state, first, last)
   end subroutine newtonian_update

   !> Explicit steps with a viscosity eta along a wave, here 4/3 of that of shear, are stable up to
   !! h/(Q + sqrt(Q**2 + c**2)) with Q = eta/(rho h), as for the artificial viscosity. Together both
   !! are at least the previous wave speed plus 2 Q. Equation (Y.17).
   pure subroutine newtonian_add_viscous_speed(self, state, deformation, first, last, spacing)
      class(law_newtonian_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: spacing                      !! Cell size [m]
      real(wp) :: factor
      integer :: i, k

      factor = 8.0_wp/3.0_wp*self%viscosity/spacing
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%wave_speed(i) = deformation%wave_speed(i) + factor*state%volume(k) &
            /state%mass(k)
      end do
   end subroutine newtonian_add_viscous_speed
end module law_newtonian
