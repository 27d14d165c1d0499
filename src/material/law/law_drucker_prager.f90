! SPDX-License-Identifier: BSD-3-Clause
!> Material with friction and cohesion after D. C. Drucker and W. Prager (Q. Appl. Math. 10 (1952)
!! 157): the equivalent stress q is not above M p + k, which ends in an apex at the pressure -k/M.
!!
!! Plastic flow dilates by b per equivalent plastic strain. M, k and b are those of the cone that
!! touches the Mohr-Coulomb surface at the position selected by dp_cone. Equation (Y.20) of
!! doc/theory/strength.md.
module law_drucker_prager
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use material_effects, only: effects_t
   use material_eos, only: eos_t
   use material_friction, only: add_dilation, add_dilation_pressure, angle_fault, angles_t, &
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
      procedure :: fault => drucker_prager_fault     !! Invalid combination of angles
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

   !> Error in the combination of the angles; empty if there is none.
   pure function drucker_prager_fault(self, group, eos) result(text)
      class(law_drucker_prager_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text

      text = angle_fault(group, eos)
   end function drucker_prager_fault

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

   !> Slope of the cone of an angle. Equation (Y.21).
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

   !> Return to cone or apex.
   pure subroutine drucker_prager_update(self, state, deformation, first, last, dt)
      class(law_drucker_prager_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]

      if (allocated(state%plastic_dilation)) call add_dilation_pressure(first, last, &
         state%plastic_dilation, state%mass, state%volume, deformation%wave_speed, &
         deformation%pressure, deformation%strength%tangent)
      call equivalent_stress(first, last, state%stress, deformation%plastic_increment)
      call strain_trial(first, last, deformation%gradient, state%stress, deformation%plastic_work)
      deformation%strength%dilation(:last - first + 1) = deformation%dilatation(:last - first + 1)
      if (allocated(state%plastic_dilation)) then
         call return_to_cone(first, last, self, state%mass, state%volume, &
            deformation%strength%tangent, state%stress, deformation%pressure, &
            deformation%plastic_increment, deformation%plastic_work, &
            deformation%strength%dilation)
         call add_dilation(first, last, deformation%strength%dilation, state%plastic_dilation)
      else
         call return_to_cone(first, last, self, state%mass, state%volume, deformation%wave_speed, &
            state%stress, deformation%pressure, deformation%plastic_increment, &
            deformation%plastic_work, deformation%strength%dilation)
      end if
   end subroutine drucker_prager_update

   !> Kernel of the above (E. A. de Souza Neto, D. Peric, D. R. J. Owen, "Computational methods for
   !! plasticity", 2008, section 8.3). Flow dilates only on the cone, because separated grains do
   !! not climb over each other. The work uses the mean pressure (p + p')/2 of the step, where the
   !! pressure before it is that of the trial less the change by the strain. Equation (Y.22).
   pure subroutine return_to_cone(first, last, law, mass, volume, tangent, stress, pressure, &
      plastic_increment, plastic_work, dilation)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      type(law_drucker_prager_t), intent(in) :: law  !! Constants
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(in) :: tangent(:) !! K/rho of pressure and flow (range) [m2/s2]
      real(wp), contiguous, intent(inout) :: stress(:, :)  !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: pressure(:)   !! (range) [Pa]
      !> Equivalent trial stress [Pa] in, plastic increment [1] out (range).
      real(wp), contiguous, intent(inout) :: plastic_increment(:)
      !> Trial deviator times strain [Pa] in, plastic work [J] out (range).
      real(wp), contiguous, intent(inout) :: plastic_work(:)
      !> Trace of the strain [1] in, fraction of the volume gained by flow [1] out (range).
      real(wp), contiguous, intent(inout) :: dilation(:)
      real(wp) :: bulk, trial, flow, equivalent, scaling, least, softness, apex, before
      logical :: apart
      integer :: i, k

      softness = 1.0_wp/(3.0_wp*law%shear)
      apex = law%apex
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trial = plastic_increment(i)
         bulk = tangent(i)*mass(k)/volume(k)
         before = max(apex, pressure(i) + bulk*dilation(i))
         flow = max(0.0_wp, trial - law%slope*pressure(i) - law%strength) &
            /(3.0_wp*law%shear + law%slope*bulk*law%dilation_slope)
         equivalent = trial - 3.0_wp*law%shear*flow
         apart = equivalent <= 0.0_wp .and. flow > 0.0_wp
         dilation(i) = merge(0.0_wp, law%dilation_slope*flow, apart)
         least = pressure(i) + bulk*dilation(i)
         pressure(i) = merge(apex, least, apart)
         equivalent = merge(0.0_wp, min(equivalent, trial), apart)
         plastic_increment(i) = (trial - equivalent)*softness
         scaling = equivalent/max(trial, tiny(1.0_wp))
         scaling = merge(scaling, 1.0_wp, flow > 0.0_wp)
         plastic_work(i) = volume(k)*max(0.0_wp, (1.0_wp - scaling)*((1.0_wp + scaling)*trial**2 &
            *(0.5_wp*softness) - 0.5_wp*plastic_work(i)) - 0.5_wp*(before + pressure(i)) &
            *dilation(i))
         stress(k, 1) = scaling*stress(k, 1)
         stress(k, 2) = scaling*stress(k, 2)
         stress(k, 3) = scaling*stress(k, 3)
         stress(k, 4) = scaling*stress(k, 4)
         stress(k, 5) = scaling*stress(k, 5)
         stress(k, 6) = scaling*stress(k, 6)
      end do
   end subroutine return_to_cone
end module law_drucker_prager
