! SPDX-License-Identifier: BSD-3-Clause
!> Ductile damage of Johnson and Cook (1985): the sum of plastic increments over the strain to
!! failure (D1 + D2 exp(D3 s)) (1 + D4 ln(rate/rate0)) (1 + D5 T*), with s the ratio of mean
!! stress, positive in tension, to equivalent stress. Equations (A.10) and (A.11) of
!! doc/theory/matter.md.
module damage_johnson_cook
   use base_elementary, only: take_exponentials, take_logarithms
   use base_constants, only: most_lanes
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_heat, only: homologous_temperature, melting_range_t, read_melting_range
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: damage_johnson_cook_t

   !> Floor of the least strain to failure, for sets without strain in shear.
   real(wp), parameter :: smallest_strain = 1.0e-6_wp
   !> Default of the least strain to failure over that in shear. Fits with negative D1 fall below 0
   !! in tension: the floor exceeds the plastic strain between yield and spall in plane waves,
   !! 2/3 spall over bulk modulus, so that the spall strength decides there.
   real(wp), parameter :: least_over_shear = 0.03_wp
   !> Bounds of the triaxiality: the fit ends at 1.5, and below -10 the exponential would overflow.
   real(wp), parameter :: least_triaxiality = -10.0_wp, most_triaxiality = 1.5_wp

   !> Lanes are filled up to a multiple of it.
   integer, parameter :: width = 8

   !> Damage model of Johnson and Cook. Without rate dependence the fourth coefficient is 0.
   type, extends(damage_t) :: damage_johnson_cook_t
      real(wp) :: coefficient(5) = 0.0_wp            !! D1 to D5 [1]
      real(wp) :: least = smallest_strain            !! Least strain to failure [1]
      real(wp) :: reference_rate = 1.0_wp            !! Rate of the static strain [1/s]
      type(melting_range_t), allocatable :: range    !! Allocated if temperature has an effect
   contains
      procedure :: declare => johnson_cook_declare   !! Declares its keys
      procedure :: uses_jc_rate => johnson_cook_uses_jc_rate !! Returns true
      procedure :: read => johnson_cook_read         !! Reads its keys
      procedure :: request => johnson_cook_request   !! Requests damage and temperature
      procedure :: update => johnson_cook_update     !! Increases the damage
      procedure :: failure_strain => johnson_cook_failure_strain !! Strain to failure of a state
   end type damage_johnson_cook_t

contains

   !> Declare the keys of the model.
   subroutine johnson_cook_declare(self, schema)
      class(damage_johnson_cook_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call schema%real("material", "jcd(5)", "Johnson-Cook D1 to D5, failure strain", &
         owner="effects.damage & damage_model = johnson_cook")
      call schema%require("material", "jcd")
      call schema%real("material", "jcd_min", "least strain to failure, where the fit gives "// &
         "less or is negative, as in tension; default: 0.03 (D1 + D2)", range="> 0", &
         owner="effects.damage & damage_model = johnson_cook")
   end subroutine johnson_cook_declare

   !> The strain to failure depends on the rate.
   pure logical function johnson_cook_uses_jc_rate(self) result(uses)
      class(damage_johnson_cook_t), intent(in) :: self

      uses = .true.
   end function johnson_cook_uses_jc_rate

   !> Read the keys of the model.
   pure subroutine johnson_cook_read(self, group, effects)
      class(damage_johnson_cook_t), intent(inout) :: self
      type(group_t), intent(in) :: group                  !! &material
      type(effects_t), intent(in) :: effects

      call group%get("jcd", self%coefficient)
      self%least = max(smallest_strain, least_over_shear*sum(self%coefficient(:2)))
      if (group%given("jcd_min")) call group%get("jcd_min", self%least)
      if (effects%rate) then
         call group%get("jc_rate", self%reference_rate)
      else
         self%coefficient(4) = 0.0_wp
      end if
      if (effects%thermal .and. abs(self%coefficient(5)) > 0.0_wp) &
         call read_melting_range(group, self%range)
   end subroutine johnson_cook_read

   !> Damage grows with the plastic strain; the strain to failure may depend on temperature.
   pure subroutine johnson_cook_request(self, requests)
      class(damage_johnson_cook_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model johnson_cook", 1)
      if (allocated(self%range)) call requests%add("temperature", "damage model johnson_cook", 1)
   end subroutine johnson_cook_request

   !> Strain to failure [1] of a state.
   pure real(wp) function johnson_cook_failure_strain(self, triaxiality, rate, homologous) &
      result(strain)
      class(damage_johnson_cook_t), intent(in) :: self
      real(wp), intent(in) :: triaxiality              !! Mean stress over equivalent stress [1]
      real(wp), intent(in) :: rate                     !! Rate of plastic strain [1/s]
      real(wp), intent(in) :: homologous               !! Homologous temperature, 0 to 1 [1]
      real(wp) :: lanes(most_lanes), rates(most_lanes)

      lanes(1) = triaxiality
      rates(1) = rate
      call find_failure_strains(self, 1, rates, lanes)
      strain = max(self%least, lanes(1)*(1.0_wp + self%coefficient(5)*homologous))
   end function johnson_cook_failure_strain

   !> Strains to failure at the reference temperature.
   pure subroutine find_failure_strains(model, count, rate, strain)
      class(damage_johnson_cook_t), intent(in) :: model
      integer, intent(in) :: count                         !! States
      real(wp), intent(inout) :: rate(most_lanes)    !! Plastic strain rate, overwritten [1/s]
      !> Mean over equivalent stress in, strain to failure out [1].
      real(wp), intent(inout) :: strain(most_lanes)
      integer :: l

      !$omp simd
      do l = 1, count
         strain(l) = model%coefficient(3)*min(most_triaxiality, max(least_triaxiality, strain(l)))
         rate(l) = max(rate(l)/model%reference_rate, 1.0_wp)
      end do
      call take_exponentials(count, strain)
      if (abs(model%coefficient(4)) > 0.0_wp) then
         call take_logarithms(count, rate)
      else
         rate(:count) = 0.0_wp
      end if
      !$omp simd
      do l = 1, count
         strain(l) = (model%coefficient(1) + model%coefficient(2)*strain(l)) &
            *(1.0_wp + model%coefficient(4)*rate(l))
      end do
   end subroutine find_failure_strains

   !> Let the damage of flowing particles grow, group by group.
   pure subroutine johnson_cook_update(self, state, deformation, first, last, dt)
      class(damage_johnson_cook_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: place(most_lanes), i, lanes, offset, most

      call homologous_temperature(self%range, state, deformation, first, last)
      do offset = 0, last - first, most_lanes
         most = min(offset + most_lanes, last - first + 1)
         if (count(deformation%plastic_increment(offset + 1:most) > 0.0_wp) == 0) cycle
         lanes = 0
         do i = offset + 1, most
            if (.not. deformation%plastic_increment(i) > 0.0_wp) cycle
            lanes = lanes + 1
            place(lanes) = i
         end do
         call grow_lanes(self, lanes, place, first - 1, dt, state, deformation)
      end do
   end subroutine johnson_cook_update

   !> Add the damage increment of the step of a group of particles that flow.
   pure subroutine grow_lanes(model, count, place, before, dt, state, deformation)
      class(damage_johnson_cook_t), intent(in) :: model
      integer, intent(in) :: count                         !! Particles of the group
      integer, intent(inout) :: place(most_lanes)          !! In the range, of a lane
      integer, intent(in) :: before !! Number of particles of the store before the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      real(wp) :: strain(most_lanes), rate(most_lanes), flow(most_lanes), mean
      integer :: filled, k, l

      ! filled up to whole vectors
      filled = width*((count + width - 1)/width)
      place(count + 1:filled) = place(1)
      do l = 1, filled
         k = before + place(l)
         flow(l) = state%stress(k, 1)**2 + state%stress(k, 2)**2 + state%stress(k, 3)**2 &
            + 2.0_wp*(state%stress(k, 4)**2 + state%stress(k, 5)**2 + state%stress(k, 6)**2)
         strain(l) = deformation%pressure(place(l))
         rate(l) = deformation%plastic_increment(place(l))/dt
      end do
      !$omp simd private(mean)
      do l = 1, filled
         flow(l) = sqrt(1.5_wp*flow(l))
         ! Clipped before the division, which could overflow for a particle about to melt.
         mean = min(max(-strain(l), least_triaxiality*flow(l)), most_triaxiality*flow(l))
         strain(l) = mean/max(flow(l), tiny(1.0_wp))
      end do
      call find_failure_strains(model, filled, rate, strain)
      do l = 1, count
         k = before + place(l)
         strain(l) = max(model%least, strain(l)*(1.0_wp + model%coefficient(5) &
            *deformation%strength%homologous(place(l))))
         state%damage(k) = min(1.0_wp, state%damage(k) + deformation%plastic_increment(place(l)) &
            /strain(l))
      end do
   end subroutine grow_lanes
end module damage_johnson_cook
