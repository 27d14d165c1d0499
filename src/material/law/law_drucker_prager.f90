! SPDX-License-Identifier: BSD-3-Clause
!> Material with friction and cohesion after D. C. Drucker and W. Prager (Q. Appl. Math. 10 (1952)
!! 157): the equivalent stress q is not above M p + k, which ends in an apex at the pressure -k/M.
!!
!! Plastic flow dilates by b per equivalent plastic strain. M, k and b are those of the cone that
!! touches the Mohr-Coulomb surface at the position selected by dp_cone. Equation (Y.23) of
!! doc/theory/strength.md.
module law_drucker_prager
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use material_effects, only: effects_t
   use material_friction, only: add_dilation, add_dilation_pressure, angles_t, &
      declare_angles, frictional_t, read_angles
   use material_law, only: equivalent_stress, strain_trial
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_drucker_prager_t

   !> Law of Drucker and Prager.
   type, extends(frictional_t) :: law_drucker_prager_t
      real(wp) :: slope = 0.0_wp                     !! M [1]
      real(wp) :: strength = 0.0_wp                  !! k, without pressure [Pa]
      real(wp) :: dilation_slope = 0.0_wp            !! b [1]
   contains
      procedure :: declare => drucker_prager_declare !! Declares its keys
      procedure :: read => drucker_prager_read       !! Reads its keys
      procedure :: set => drucker_prager_set         !! Cone from the angles
      procedure :: update => drucker_prager_update   !! Return to cone or apex
   end type law_drucker_prager_t

contains

   !> Declare the keys of the law.
   subroutine drucker_prager_declare(self, schema)
      class(law_drucker_prager_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call declare_angles(schema)
      call schema%text("material", "dp_cone", "where the Drucker-Prager cone meets the "// &
         "Mohr-Coulomb surface; the plane_strain cone lies inside of it everywhere", &
         default="compression", words="compression extension plane_strain", &
         owner="effects.strength & strength_model = drucker_prager")
      call schema%allow_change("material", "dp_cone", changes_physics)
   end subroutine drucker_prager_declare

   !> Read the keys of the law.
   pure subroutine drucker_prager_read(self, group, effects)
      class(law_drucker_prager_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects
      type(angles_t) :: angles
      character(len=:), allocatable :: where_cone

      call read_angles(group, angles)
      call group%get("dp_cone", where_cone)
      call self%set(angles, where_cone)
   end subroutine drucker_prager_read

   !> Cone of the angles. All frictional work becomes heat.
   pure subroutine drucker_prager_set(self, angles, where_cone)
      class(law_drucker_prager_t), intent(inout) :: self
      type(angles_t), intent(in) :: angles
      character(len=*), intent(in) :: where_cone     !! Where it touches Mohr-Coulomb

      self%slope = cone(angles%friction, where_cone)
      ! The apex of the cone is that of Mohr and Coulomb, c/tan(phi).
      self%apex = -huge(1.0_wp)
      if (self%slope > 0.0_wp) then
         self%strength = angles%cohesion*self%slope/tan(angles%friction)
         self%apex = -self%strength/self%slope
      else if (where_cone == "plane_strain") then
         self%strength = sqrt(3.0_wp)*angles%cohesion
      else
         self%strength = 2.0_wp*angles%cohesion
      end if
      self%dilation_slope = cone(angles%dilation, where_cone)
      self%dilates = self%dilation_slope > 0.0_wp
      self%heat_share = 1.0_wp
   end subroutine drucker_prager_set

   !> Slope of the cone of an angle. Equation (Y.24).
   pure real(wp) function cone(angle, where_cone) result(slope)
      real(wp), intent(in) :: angle                  !! Angle of friction or dilation [rad]
      character(len=*), intent(in) :: where_cone     !! Where it touches Mohr-Coulomb

      select case (where_cone)
      case ("extension")
         slope = 6.0_wp*sin(angle)/(3.0_wp + sin(angle))
      case ("plane_strain")
         slope = 3.0_wp*tan(angle)/sqrt(3.0_wp + 4.0_wp*tan(angle)**2)
      case default
         slope = 6.0_wp*sin(angle)/(3.0_wp - sin(angle))
      end select
   end function cone

   !> Return to cone or apex (E. A. de Souza Neto, D. Peric, D. R. J. Owen, "Computational methods
   !! for plasticity", 2008, section 8.3). Flow dilates only on the cone, because separated grains
   !! do not climb over each other. The work uses the mean pressure (p + p')/2 of the step, where
   !! the pressure before it is that of the trial less the change by the strain. Equation (Y.25).
   pure subroutine drucker_prager_update(self, state, deformation, first, last, dt)
      class(law_drucker_prager_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: shear, slope, strength, dilating, apex, softness
      real(wp) :: bulk, trial, flow, equivalent, scaling, least, before
      logical :: apart
      integer :: i, k

      call add_dilation_pressure(state, deformation, first, last)
      call equivalent_stress(state, deformation, first, last)
      call strain_trial(state, deformation, first, last)
      shear = self%shear
      slope = self%slope
      strength = self%strength
      dilating = self%dilation_slope
      apex = self%apex
      softness = 1.0_wp/(3.0_wp*shear)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trial = deformation%plastic_increment(i)
         bulk = deformation%strength%tangent(i)*state%mass(k)/state%volume(k)
         before = max(apex, deformation%pressure(i) + bulk*deformation%dilatation(i))
         flow = max(0.0_wp, trial - slope*deformation%pressure(i) - strength) &
            /(3.0_wp*shear + slope*bulk*dilating)
         equivalent = trial - 3.0_wp*shear*flow
         apart = equivalent <= 0.0_wp .and. flow > 0.0_wp
         deformation%strength%dilation(i) = merge(0.0_wp, dilating*flow, apart)
         least = deformation%pressure(i) + bulk*deformation%strength%dilation(i)
         deformation%pressure(i) = merge(apex, least, apart)
         equivalent = merge(0.0_wp, min(equivalent, trial), apart)
         deformation%plastic_increment(i) = (trial - equivalent)*softness
         scaling = equivalent/max(trial, tiny(1.0_wp))
         scaling = merge(scaling, 1.0_wp, flow > 0.0_wp)
         deformation%plastic_work(i) = state%volume(k)*max(0.0_wp, (1.0_wp - scaling) &
            *((1.0_wp + scaling)*trial**2*(0.5_wp*softness) - 0.5_wp*deformation%plastic_work(i)) &
            - 0.5_wp*(before + deformation%pressure(i))*deformation%strength%dilation(i))
         state%stress(k, 1:6) = scaling*state%stress(k, 1:6)
      end do
      call add_dilation(state, deformation, first, last)
   end subroutine drucker_prager_update
end module law_drucker_prager
