! SPDX-License-Identifier: BSD-3-Clause
!> Common parts of laws whose strength grows with the pressure.
!!
!! The pressure is that of the equation of state and follows the density: separated material
!! supports no stress until its density is restored. With an angle of dilation, shear increases the
!! volume permanently; this volume is a state variable and does not enter the pressure.
module material_friction
   use base_constants, only: pi
   use base_elementary, only: take_exponentials, take_logarithms
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use eos_linear, only: eos_linear_t
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_add_wave_speed, law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: angles_t, declare_angles, frictional_t, add_dilation, &
      add_dilation_pressure, read_angles

   !> Constants of cohesive material with friction.
   type :: angles_t
      real(wp) :: friction = 0.0_wp                  !! Angle of friction [rad]
      real(wp) :: dilation = 0.0_wp                  !! Angle of dilation [rad]
      real(wp) :: cohesion = 0.0_wp                  !! [Pa]
   end type angles_t

   !> A law whose strength grows with the pressure.
   type, abstract, extends(law_t) :: frictional_t
      real(wp) :: apex = 0.0_wp                      !! Least pressure, at the apex [Pa]
      logical :: dilates = .false.                   !! Shear increases the volume
   contains
      procedure :: fault => frictional_fault         !! Invalid combination of angles
      procedure :: follows_density => frictional_follows_density !! Its pressure does
      procedure :: request => frictional_request     !! Requests the volume gained by shear
      !> Shear modulus, where material is not separated
      procedure :: add_wave_speed => frictional_add_wave_speed
      procedure :: least_pressure => frictional_least_pressure !! That of the apex
   end type frictional_t

contains

   !> Declare the keys common to several laws.
   subroutine declare_angles(schema)
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = "// &
         "drucker_prager mohr_coulomb"

      call schema%real("material", "friction_angle", "angle of internal friction", unit="deg", &
         range=">= 0 < 90", owner=owner)
      call schema%real("material", "cohesion", "cohesion: shear strength at zero pressure", &
         unit="Pa", default="0", range=">= 0", owner=owner//" mu_i")
      call schema%real("material", "dilation_angle", "dilation angle: shear increases the volume", &
         unit="deg", default="0", range=">= 0 < 90", owner=owner)
      call schema%require("material", "friction_angle")
   end subroutine declare_angles

   !> Read them.
   pure subroutine read_angles(group, angles)
      type(group_t), intent(in) :: group             !! &material
      type(angles_t), intent(out) :: angles

      call group%get("friction_angle", angles%friction)
      call group%get("dilation_angle", angles%dilation)
      call group%get("cohesion", angles%cohesion)
      angles%friction = angles%friction*pi/180.0_wp
      angles%dilation = angles%dilation*pi/180.0_wp
   end subroutine read_angles

   !> Error in the combination of the angles; empty if there is none.
   pure function frictional_fault(self, group, eos) result(text)
      class(frictional_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text
      real(wp) :: friction, dilation, cohesion
      logical :: linear

      text = ""
      if (.not. (group%known("friction_angle") .and. group%known("dilation_angle") .and. &
         group%known("cohesion"))) return
      call group%get("friction_angle", friction)
      call group%get("dilation_angle", dilation)
      call group%get("cohesion", cohesion)
      linear = .true.
      if (allocated(eos)) then
         select type (eos)
         type is (eos_linear_t)
         class default
            linear = .false.
         end select
      end if
      if (friction > 0.0_wp .and. friction < 0.5_wp*pi) then
         text = "friction_angle = "//brief(friction)//" deg: did you mean radians ("// &
            brief(anint(friction*1800.0_wp/pi)/10.0_wp)//" deg)? [D506]"
      else if (dilation > friction) then
         text = "dilation_angle must not be above friction_angle, otherwise flow would "// &
            "generate energy [D363]"
      else if (dilation > 0.0_wp .and. .not. linear) then
         text = "dilation_angle needs eos_model = 'linear', because other models depend only "// &
            "on the density [D364]"
      else if (.not. (friction > 0.0_wp .or. cohesion > 0.0_wp)) then
         text = "friction_angle or cohesion must be above 0; for a fluid set elastic = "// &
            "'none' [D363]"
      end if
   end function frictional_fault

   !> The pressure must follow the density.
   pure logical function frictional_follows_density(self) result(follows)
      class(frictional_t), intent(in) :: self

      follows = .true.
   end function frictional_follows_density

   !> Volume gained by shear, if shear increases it.
   pure subroutine frictional_request(self, requests)
      class(frictional_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      if (self%dilates) call requests%add("plastic_dilation", "dilation_angle", 1)
   end subroutine frictional_request

   !> Least pressure that the law supports [Pa].
   pure real(wp) function frictional_least_pressure(self) result(pressure)
      class(frictional_t), intent(in) :: self

      pressure = self%apex
   end function frictional_least_pressure

   !> Shear modulus in the square of the wave speed. Separated material supports no shear; its wave
   !! speed does not grow with its volume, otherwise a cloud of debris would shorten the time step:
   !! at the least pressure, where material may be separated, the square of the wave speed increases
   !! at most by the fraction 4/3 G/K.
   pure subroutine frictional_add_wave_speed(self, state, deformation, first, last)
      class(frictional_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), parameter :: least = 1.0e-12_wp      ! of the shear modulus, for a divisor
      real(wp) :: share, joined, shear, bulk, apex
      integer :: i, k

      if (allocated(state%failed)) then
         call law_add_wave_speed(self, state, deformation, first, last)
         return
      end if
      shear = self%shear
      bulk = self%bulk
      apex = self%apex
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         share = 4.0_wp/3.0_wp*shear*state%volume(k)/state%mass(k)
         joined = 4.0_wp/3.0_wp*shear/max(bulk, least*shear, tiny(least))*deformation%wave_speed(i)
         deformation%wave_speed(i) = deformation%wave_speed(i) &
            + merge(share, min(share, joined), deformation%pressure(i) > apex)
      end do
   end subroutine frictional_add_wave_speed

   !> Remove the dilatant volume, if there is one, from the pressure: p + rho c**2 (exp(gained) -
   !! 1), exact for p = K (rho/rho0 - 1). The dilatancy of the step, x times the volume gained
   !! before, then increases the pressure by exactly rho c**2 exp(gained) x; `strength%tangent` gets
   !! c**2 exp(gained). Equation (Y.30) of doc/theory/strength.md.
   pure subroutine add_dilation_pressure(state, deformation, first, last)
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count, i, k

      count = last - first + 1
      if (.not. allocated(state%plastic_dilation)) then
         deformation%strength%tangent(:count) = deformation%wave_speed(:count)
         return
      end if
      deformation%strength%tangent(:count) = state%plastic_dilation(first:last)
      call take_exponentials(count, deformation%strength%tangent)
      do concurrent (i=1:count)
         k = first - 1 + i
         deformation%strength%tangent(i) = deformation%wave_speed(i)*deformation%strength%tangent(i)
         deformation%pressure(i) = deformation%pressure(i) + state%mass(k)/state%volume(k) &
            *(deformation%strength%tangent(i) - deformation%wave_speed(i))
      end do
   end subroutine add_dilation_pressure

   !> Add the dilatancy of a step, a fraction of the volume gained before, if there is a dilatant
   !! volume. Equation (Y.30).
   pure subroutine add_dilation(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count

      if (.not. allocated(state%plastic_dilation)) return
      count = last - first + 1
      deformation%strength%dilation(:count) = 1.0_wp + deformation%strength%dilation(:count)
      call take_logarithms(count, deformation%strength%dilation)
      state%plastic_dilation(first:last) = state%plastic_dilation(first:last) &
         + deformation%strength%dilation(:count)
   end subroutine add_dilation
end module material_friction
