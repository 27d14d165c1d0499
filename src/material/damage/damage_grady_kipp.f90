! SPDX-License-Identifier: BSD-3-Clause
!> Brittle failure by the growth of flaws (D. E. Grady, M. E. Kipp, Int. J. Rock Mech. Min. Sci. 17
!! (1980) 147; W. Benz, E. Asphaug, Comput. Phys. Commun. 87 (1995) 253). A volume V holds k V e**m
!! flaws that grow at an elastic tensile strain below e. With n of them growing at the speed g
!!
!!    d D**(1/3)/dt = n**(1/3) g/R,   R the radius of a sphere of the volume V
!!
!! The weakest flaw of each particle is that of its place (`material_flaws`). Further flaws are
!! counted by their mean number. Damage does not weaken a particle before it is complete. V is the
!! volume of the particle, in plane strain with the thickness of the grid, in axisymmetry of the
!! ring. Equations (F.6) and (F.7) of doc/theory/failure.md.
module damage_grady_kipp
   use base_constants, only: pi
   use base_elementary, only: power
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_brittle, only: bound_deviator, find_extremes
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: damage_grady_kipp_t

   !> Growth of flaws.
   type, extends(damage_t) :: damage_grady_kipp_t
      real(wp) :: flaws = 0.0_wp                     !! k [1/m3]
      real(wp) :: exponent = 1.0_wp                  !! m [1]
      real(wp) :: share = 0.4_wp                     !! Speed of cracks over that of sound [1]
      logical :: scatters = .false.                  !! Is the weakest flaw of a particle random?
   contains
      procedure :: declare => grady_kipp_declare     !! Declares its keys
      procedure :: needs_flow => grady_kipp_needs_flow !! Returns false
      procedure :: needs_weibull => grady_kipp_needs_weibull !! Always, for the flaws
      procedure :: read => grady_kipp_read           !! Reads its keys
      procedure :: request => grady_kipp_request     !! Requests damage and scatter
      procedure :: strength_of => grady_kipp_strength_of !! Strain at which a flaw grows
      procedure :: update => grady_kipp_update       !! Grows the flaws
   end type damage_grady_kipp_t

contains

   !> Declare the keys of the model.
   subroutine grady_kipp_declare(self, schema)
      class(damage_grady_kipp_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = grady_kipp"

      call schema%real("material", "weibull_k", &
         "Grady-Kipp k: number of flaws per volume active at strain e is k e**m", unit="1/m3", &
         range="> 0", owner=owner)
      call schema%forbid_change("material", "weibull_k", "the flaws of the particles were "// &
         "drawn with it")
      call schema%real("material", "crack_speed", "crack speed over the longitudinal wave speed", &
         default="0.4", range="> 0 <= 1", owner=owner)
      call schema%require("material", "weibull_k")
   end subroutine grady_kipp_declare

   !> It does not use the plastic strain.
   pure logical function grady_kipp_needs_flow(self) result(needs)
      class(damage_grady_kipp_t), intent(in) :: self

      needs = .false.
   end function grady_kipp_needs_flow

   !> The Weibull modulus is always needed: it is the exponent m of the number of flaws.
   pure logical function grady_kipp_needs_weibull(self, scatter) result(needs)
      class(damage_grady_kipp_t), intent(in) :: self
      logical, intent(in) :: scatter                 !! Switch size_scatter of &effects

      needs = .true.
   end function grady_kipp_needs_weibull

   !> Read the keys of the model.
   pure subroutine grady_kipp_read(self, group, effects)
      class(damage_grady_kipp_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call group%get("weibull_k", self%flaws)
      if (group%given("weibull_m")) call group%get("weibull_m", self%exponent)
      call group%get("crack_speed", self%share)
      self%scatters = effects%size_scatter
   end subroutine grady_kipp_read

   !> Request the damage and, if strength scatters, the strain of the weakest flaw.
   pure subroutine grady_kipp_request(self, requests)
      class(damage_grady_kipp_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model grady_kipp", 1)
      if (self%scatters) call requests%add("scatter", "size_scatter", 1)
   end subroutine grady_kipp_request

   !> Elastic tensile strain at which a flaw begins to grow [1].
   pure real(wp) function grady_kipp_strength_of(self, level) result(strength)
      class(damage_grady_kipp_t), intent(in) :: self
      real(wp), intent(in) :: level                        !! Number of weaker flaws [1/m3]

      strength = power(level/self%flaws, 1.0_wp/self%exponent)
   end function grady_kipp_strength_of

   !> Let the flaws of strained particles grow.
   pure subroutine grady_kipp_update(self, state, deformation, first, last, dt)
      class(damage_grady_kipp_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp), parameter :: third = 1.0_wp/3.0_wp
      real(wp) :: strain, speed, volume, number, radius, weakest, greatest, least
      integer :: i, k

      call bound_deviator(first, last, state%stress, deformation%damage%bound)
      ! A gas has no bulk modulus at rest and no elastic strain.
      if (.not. self%bulk > 0.0_wp) return
      speed = self%share*sqrt((self%bulk + 4.0_wp/3.0_wp*self%shear)/self%density)
      ! Mean number of flaws at which the weakest one grows.
      weakest = 1.0_wp
      associate (pressure => deformation%pressure, damage => state%damage)
         do i = 1, last - first + 1
            k = first - 1 + i
            strain = 0.5_wp*deformation%damage%bound(i)/self%shear &
               - pressure(i)/(3.0_wp*self%bulk)
            if (strain <= 0.0_wp .or. damage(k) >= 1.0_wp) cycle
            volume = state%mass(k)/self%density
            if (self%scatters) then
               if (strain < state%brittle%scatter(k)) cycle
               weakest = self%flaws*volume*power(state%brittle%scatter(k), self%exponent)
            end if
            if (self%flaws*volume*power(strain, self%exponent) < weakest) cycle
            call find_extremes(state%stress, k, greatest, least)
            strain = 0.5_wp*greatest/self%shear - pressure(i)/(3.0_wp*self%bulk)
            number = self%flaws*volume*power(max(strain, 0.0_wp), self%exponent) &
               - weakest + 1.0_wp
            if (number < 1.0_wp) cycle
            radius = power(0.75_wp*volume/pi, third)
            damage(k) = min(1.0_wp, (power(damage(k), third) &
               + power(number, third)*speed*dt/radius)**3)
         end do
      end associate
   end subroutine grady_kipp_update
end module damage_grady_kipp
