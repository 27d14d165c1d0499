! SPDX-License-Identifier: BSD-3-Clause
!> Voids between the grains or fragments of a particle. The volume V of a particle is that of the
!! motion; solid material of density rho fills the fraction theta of it, m = theta rho V.
!!
!! The dilatation of the material is alpha times that of the motion and B (D. Z. Zhang, X. Ma, B.
!! Jayaraman, LA-UR-11-06616), so that
!!
!!    d ln rho = -(alpha d ln V + B dt),   d ln theta = (alpha - 1) d ln V + B dt
!!
!! Only theta is stored. Where alpha is 0, theta V and rho are constant to round-off: voids open and
!! close without pressure, and closed voids do not change the pressure. Equation (F.25) of
!! doc/theory/failure.md.
module material_voids
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use material_eos, only: eos_t
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t, void_scratch_t
   implicit none
   private

   public :: declare_voids, expand_grains, expanded_fraction, voids_fault, voids_t

   !> Rules of the voids of a material.
   type :: voids_t
      logical :: opens = .true.                      !! Voids of loose material open and close
      logical :: crushes = .false.                   !! Compressed grains close them permanently
      logical :: loose = .false. !! All material is loose, not only failed material
      real(wp) :: start = 1.0_wp                     !! theta of the reference state [1]
      real(wp) :: critical = 1.0_wp                  !! theta from which on grains touch [1]
      real(wp) :: shearing = 0.0_wp !! Coefficient of rule B: -d ln theta per unit of shear [1]
      real(wp) :: expansion = 0.0_wp !! Coefficient of rule B: thermal expansion of volume [1/K]
   contains
      procedure :: read => voids_read                !! Reads the keys
      !> Fraction of the dilatation of the material itself
      procedure :: choose_fraction => voids_choose_fraction
      procedure :: update_solid_fraction => voids_update_solid_fraction  !! Opens and closes voids
      procedure :: to_solid_volume => voids_to_solid_volume !! Sets the volume to that of the solid
      procedure :: to_total_volume => voids_to_total_volume              !! And back again
      procedure :: to_solid_volumes => voids_to_solid_volumes !! The same before and after the step
   end type voids_t

contains

   !> Declare the keys.
   subroutine declare_voids(schema)
      type(schema_t), intent(inout) :: schema

      call schema%text("material", "alpha_m", "fraction of the dilatation that the material "// &
         "itself takes; voids take the rest: one, all; open_when_failed, none in failed or "// &
         "loose material that expands or whose grains do not touch, else all; crush, in "// &
         "addition a part only while grains under pressure close "// &
         "voids", default="open_when_failed", &
         words="one open_when_failed crush", owner="effects.voids")
      call schema%real("material", "solid_fraction", &
         "solid volume fraction in the reference state", default="1", range="> 0 <= 1", &
         owner="effects.voids")
      call schema%real("material", "critical_packing", &
         "solid volume fraction above which grains touch; default: solid_fraction", &
         range="> 0 <= 1", owner="effects.voids")
      call schema%real("material", "b_shear", "dilatancy: logarithmic volume of voids opened "// &
         "per shear strain in pressed loose material", default="0", range=">= 0", &
         owner="effects.voids")
      call schema%real("material", "b_thermal", &
         "volumetric thermal expansion of the grains, which closes voids", unit="1/K", &
         default="0", range=">= 0", owner="effects.voids & effects.thermal")
      call schema%allow_change("material", "alpha_m", changes_physics)
      call schema%forbid_change("material", "solid_fraction", "it is the initial state of the "// &
         "voids, which the particles have stored since")
   end subroutine declare_voids

   !> Error in the combination of the keys; empty if there is none.
   pure function voids_fault(group, eos, law) result(text)
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), intent(in) :: eos
      class(law_t), allocatable, intent(in) :: law   !! Law of strength, if there is one
      character(len=:), allocatable :: text
      character(len=:), allocatable :: word
      real(wp) :: dilation, fraction
      logical :: pores, solid

      text = ""
      solid = .false.
      pores = .false.
      if (allocated(law)) solid = .not. law%supports_voids()
      if (allocated(law)) pores = law%grows_pores()
      call group%get("solid_fraction", fraction)
      dilation = 0.0_wp
      if (group%given("dilation_angle")) call group%get("dilation_angle", dilation)
      if (eos%has_pores()) then
         call group%get("eos_model", word)
         text = "eos_model = '"//word//"' has pores of its own; remove it or &effects voids [D364]"
      else if (pores) then
         call group%get("strength_model", word)
         text = "strength_model = '"//word//"' has pores of its own; remove it or &effects "// &
            "voids [D439]"
      else if (dilation > 0.0_wp) then
         text = "with &effects voids shear opens them by b_shear, not by dilation_angle [D364]"
      else if (solid .and. fraction < 1.0_wp) then
         call group%get("strength_model", word)
         text = "strength_model = '"//word//"' is that of material without pores; remove "// &
            "solid_fraction [D364]"
      end if
   end function voids_fault

   !> Read the keys.
   pure subroutine voids_read(self, group)
      class(voids_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: rule

      call group%get("alpha_m", rule)
      self%opens = rule /= "one"
      self%crushes = rule == "crush"
      call group%get("solid_fraction", self%start)
      self%critical = self%start
      if (group%given("critical_packing")) call group%get("critical_packing", self%critical)
      call group%get("b_shear", self%shearing)
      call group%get("b_thermal", self%expansion)
   end subroutine voids_read

   !> Fraction of the dilatation of the material itself in the step, from the stress before it, with
   !! the voids that shear opens. Equations (F.27) and (F.28).
   pure subroutine voids_choose_fraction(self, state, deformation, first, last)
      class(voids_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count

      count = last - first + 1
      deformation%voids%loose(:count) = merge(1.0_wp, 0.0_wp, self%loose)
      if (allocated(state%failed)) deformation%voids%loose(:count) = &
         max(deformation%voids%loose(:count), real(state%failed(first:last), wp))
      deformation%voids%old_pressure(:count) = -(state%stress(first:last, 1) &
         + state%stress(first:last, 2) + state%stress(first:last, 3))/3.0_wp
      if (allocated(state%viscous_pressure)) deformation%voids%old_pressure(:count) = &
         deformation%voids%old_pressure(:count) - state%viscous_pressure(first:last)
      call find_fraction(self, state, deformation%gradient, first, last, deformation%voids)
   end subroutine voids_choose_fraction

   !> Kernel of the above.
   pure subroutine find_fraction(voids, state, gradient, first, last, scratch)
      type(voids_t), intent(in) :: voids
      type(material_state_t), intent(inout) :: state       !! State of the store
      real(wp), contiguous, intent(in) :: gradient(:, :)   !! dt du_k/dx_l (range, 9) [1]
      integer, intent(in) :: first, last                   !! Particles of the range
      type(void_scratch_t), intent(inout) :: scratch       !! Of the range
      real(wp) :: trace, mean, shear, theta, alpha, crushing
      integer :: i, k

      crushing = 0.0_wp
      if (voids%crushes .and. voids%critical < 1.0_wp) crushing = 1.0_wp/(1.0_wp - voids%critical)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trace = gradient(i, 1) + gradient(i, 5) + gradient(i, 9)
         mean = trace/3.0_wp
         shear = sqrt(2.0_wp*((gradient(i, 1) - mean)**2 + (gradient(i, 5) - mean)**2 &
            + (gradient(i, 9) - mean)**2) + (gradient(i, 2) + gradient(i, 4))**2 &
            + (gradient(i, 3) + gradient(i, 7))**2 + (gradient(i, 6) + gradient(i, 8))**2)
         theta = state%solid_fraction(k)
         ! Compressed grains dilate under shear down to the least solid fraction.
         theta = merge(max(min(theta, voids%critical), &
            theta/(1.0_wp + voids%shearing*shear*(1.0_wp + 0.5_wp*voids%shearing*shear))), theta, &
            scratch%loose(i) > 0.5_wp .and. scratch%old_pressure(i) > 0.0_wp)
         state%solid_fraction(k) = theta
         alpha = merge(min(1.0_wp, (theta - voids%critical)*crushing), 1.0_wp, &
            crushing > 0.0_wp .and. trace < 0.0_wp)
         alpha = merge(0.0_wp, alpha, (trace > 0.0_wp .and. scratch%old_pressure(i) <= 0.0_wp) &
            .or. (trace <= 0.0_wp .and. theta < voids%critical))
         scratch%alpha(i) = merge(alpha, 1.0_wp, voids%opens .and. scratch%loose(i) > 0.5_wp)
      end do
   end subroutine find_fraction

   !> Open and close voids, with the volume before and after the step. Compression beyond the
   !! contact of grains is that of the material. Equation (F.26).
   pure subroutine voids_update_solid_fraction(self, state, deformation, first, last)
      class(voids_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: critical, fraction, most, theta
      integer :: i, k

      critical = self%critical
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         fraction = deformation%voids%alpha(i)
         theta = state%solid_fraction(k)
         most = merge(critical, 1.0_wp, theta < critical .and. fraction <= 0.0_wp)
         state%solid_fraction(k) = merge(theta, min(theta*(fraction + (1.0_wp - fraction) &
            *(deformation%old_volume(i)/state%volume(k))), most), fraction >= 1.0_wp)
      end do
   end subroutine voids_update_solid_fraction

   !> Replace the volume by that of the solid, for the models of the material.
   pure subroutine voids_to_solid_volume(self, state, deformation, first, last)
      class(voids_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      deformation%voids%total_volume(:last - first + 1) = state%volume(first:last)
      state%volume(first:last) = state%volume(first:last)*state%solid_fraction(first:last)
   end subroutine voids_to_solid_volume

   !> Volumes before and after the step become those of the material itself, without the dilatation
   !! of voids. The volume with voids is stored in `total_volume`.
   pure subroutine voids_to_solid_volumes(self, state, deformation, first, last)
      class(voids_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      associate (volume => state%volume(first:last), old => deformation%old_volume( &
         :last - first + 1), fraction => deformation%voids%alpha(:last - first + 1))
         old = state%solid_fraction(first:last)*(volume + fraction*(old - volume))
      end associate
      call self%to_solid_volume(state, deformation, first, last)
   end subroutine voids_to_solid_volumes

   !> Restore the volume of the motion, and convert the pressure to that on the whole surface. While
   !! voids open or close the pressure is zero, because its round-off would stop the opening.
   pure subroutine voids_to_total_volume(self, state, deformation, first, last)
      class(voids_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      state%volume(first:last) = deformation%voids%total_volume(:last - first + 1)
      deformation%pressure(:last - first + 1) = merge(deformation%pressure(:last - first + 1) &
         *state%solid_fraction(first:last), 0.0_wp, deformation%voids%alpha(:last - first + 1) > &
            0.0_wp)
   end subroutine voids_to_total_volume

   !> Expand heated grains into voids: B = expansion dT/dt. Equation (F.28).
   pure subroutine expand_grains(expansion, state, deformation, first, last)
      real(wp), intent(in) :: expansion                    !! Thermal, of the volume [1/K]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         state%solid_fraction(k) = expanded_fraction(state%solid_fraction(k), &
            expansion*(state%temperature(k) - deformation%voids%old_temperature(i)))
      end do
   end subroutine expand_grains

   !> Volume fraction of grains that expand, theta exp(growth) but at most 1, with the positive Pade
   !! approximant of order (2, 2), which cooling reverses to round-off.
   pure real(wp) function expanded_fraction(solid_fraction, growth) result(fraction)
      real(wp), intent(in) :: solid_fraction         !! Before [1]
      real(wp), intent(in) :: growth !! Increment of the logarithm of their volume [1]

      fraction = min(1.0_wp, solid_fraction*(1.0_wp + growth*(0.5_wp + growth/12.0_wp)) &
         /(1.0_wp - growth*(0.5_wp - growth/12.0_wp)))
   end function expanded_fraction
end module material_voids
