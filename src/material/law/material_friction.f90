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
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   use material_tension, only: add_intact_shear_speed
   implicit none
   private

   public :: angles_t, declare_angles, angle_fault, frictional_t, add_dilation, &
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
   pure function angle_fault(group, eos) result(text)
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
            brief(anint(friction*1800.0_wp/pi)/10.0_wp)//" deg)?"
      else if (dilation > friction) then
         text = "dilation_angle must not be above friction_angle, otherwise flow would "// &
            "generate energy"
      else if (dilation > 0.0_wp .and. .not. linear) then
         text = "dilation_angle needs eos_model = 'linear', because other models depend only "// &
            "on the density"
      else if (.not. (friction > 0.0_wp .or. cohesion > 0.0_wp)) then
         text = "friction_angle or cohesion must be above 0; for a fluid set elastic = 'none'"
      end if
   end function angle_fault

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
   !! speed does not grow with its volume, otherwise a cloud of debris would shorten the time step.
   pure subroutine frictional_add_wave_speed(self, state, deformation, first, last)
      class(frictional_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      if (allocated(state%failed)) then
         call add_intact_shear_speed(first, last, self%shear, state%failed, state%mass, &
            state%volume, deformation%wave_speed)
      else
         call add_joined_shear_speed(first, last, self%shear, self%bulk, self%apex, state%mass, &
            state%volume, deformation%pressure, deformation%wave_speed)
      end if
   end subroutine frictional_add_wave_speed

   !> Kernel of the above. At the least pressure, where material may be separated, the square of the
   !! wave speed increases at most by the fraction 4/3 G/K.
   pure subroutine add_joined_shear_speed(first, last, shear, bulk, apex, mass, volume, pressure, &
      wave_speed)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: bulk                   !! Bulk modulus of the reference state [Pa]
      real(wp), intent(in) :: apex                   !! Least pressure [Pa]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(in) :: pressure(:)        !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: wave_speed(:)   !! Its square (range) [m2/s2]
      real(wp), parameter :: least = 1.0e-12_wp      ! of the shear modulus, for a divisor
      real(wp) :: share
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         share = 4.0_wp/3.0_wp*shear*volume(k)/mass(k)
         wave_speed(i) = wave_speed(i) + merge(share, &
            min(share, 4.0_wp/3.0_wp*shear/max(bulk, least*shear, tiny(least))*wave_speed(i)), &
            pressure(i) > apex)
      end do
   end subroutine add_joined_shear_speed

   !> Remove the dilatant volume from the pressure: p + rho c**2 (exp(gained) - 1), exact for p = K
   !! (rho/rho0 - 1). The dilatancy of the step, x times the volume gained before, then increases
   !! the pressure by exactly rho c**2 exp(gained) x. Equation (Y.27) of doc/theory/strength.md.
   pure subroutine add_dilation_pressure(first, last, gained, mass, volume, wave_speed, pressure, &
      tangent)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: gained(:)  !! Logarithm of the volume gained (store) [1]
      real(wp), contiguous, intent(in) :: mass(:)    !! (store) [kg]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(in) :: wave_speed(:) !! Square of the wave speed (range) [m2/s2]
      real(wp), contiguous, intent(inout) :: pressure(:)   !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: tangent(:)    !! c**2 exp(gained) (range) [m2/s2]
      integer :: i, k

      tangent(1:last - first + 1) = gained(first:last)
      call take_exponentials(last - first + 1, tangent)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         tangent(i) = wave_speed(i)*tangent(i)
         pressure(i) = pressure(i) + mass(k)/volume(k)*(tangent(i) - wave_speed(i))
      end do
   end subroutine add_dilation_pressure

   !> Add the dilatancy of a step, as a fraction of the volume gained before. Equation (Y.27).
   pure subroutine add_dilation(first, last, share, gained)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(inout) :: share(:) !! Of the step; overwritten (range) [1]
      real(wp), contiguous, intent(inout) :: gained(:) !! Logarithm of the volume (store) [1]
      integer :: i

      do concurrent (i=1:last - first + 1)
         share(i) = 1.0_wp + share(i)
      end do
      call take_logarithms(last - first + 1, share)
      do concurrent (i=1:last - first + 1)
         gained(first - 1 + i) = gained(first - 1 + i) + share(i)
      end do
   end subroutine add_dilation
end module material_friction
