! SPDX-License-Identifier: BSD-3-Clause
!> The models of one material, and the fields that its particles carry.
module material_models
   use base_kinds, only: int64, wp
   use material_burn, only: burn_t, burnt_before
   use material_damage, only: damage_t
   use material_eos, only: eos_t
   use material_failed, only: failure_t
   use material_field_requests, only: field_requests_t
   use material_flaws, only: flaw_blocks_t
   use material_heat, only: heat_t
   use material_law, only: law_t
   use material_record, only: record_t
   use material_stages, only: effect_damage, effect_eos, effect_strength, effect_thermal, &
      effect_viscosity, effect_voids
   use material_state, only: material_state_t
   use material_tension, only: request_fading
   use material_viscosity, only: viscosity_t
   use material_voids, only: voids_t
   implicit none
   private

   public :: models_t

   !> The models of one material. A model that is not allocated costs nothing.
   type :: models_t
      character(len=:), allocatable :: name          !! Name that bodies refer to
      real(wp) :: density = 0.0_wp                   !! Density of the reference state [kg/m3]
      real(wp) :: bulk = 0.0_wp                      !! Bulk modulus of the reference state [Pa]
      real(wp) :: shear = 0.0_wp                     !! Shear modulus, 0 without strength [Pa]
      class(law_t), allocatable :: law               !! Strength; none: stress is pressure alone
      class(eos_t), allocatable :: eos               !! None: mean stress in rate form
      class(damage_t), allocatable :: damage         !! Growth of damage
      type(viscosity_t), allocatable :: viscosity    !! Artificial viscosity
      type(failure_t) :: failure                     !! Limits of tension, and failed material
      type(voids_t), allocatable :: voids            !! Voids open and close
      logical :: elastic_pressure = .false. !! The eos is K (rho/rho0 - 1) as the effect is off
      logical :: repacks = .false.                   !! The fill of nodes corrects volumes
      type(record_t) :: record                       !! Fields that outputs request
      type(heat_t), allocatable :: heat              !! Temperature follows the work
      real(wp), allocatable :: melting               !! Fluid from this temperature [K]
      type(burn_t), allocatable :: burn              !! Detonations light it
   contains
      procedure :: field_requests => models_field_requests !! Requested fields, with reasons
      procedure :: allocate_state => models_allocate_state !! Allocates these fields
      procedure :: carries_energy => models_carries_energy !! True if it has an internal energy
      procedure :: start => models_start             !! Initial state of particles
      procedure :: draw_strength => models_draw_strength       !! Random strength of a particle
      procedure :: start_energy => models_start_energy !! Internal energy at the start
      procedure :: temperature_of => models_temperature_of !! Temperature of an energy at the start
      procedure :: starts_with_stress => models_starts_with_stress !! True if it may have one then
      procedure :: is_gas_of_explosive => models_is_gas_of_explosive !! Products of a detonation
      procedure :: has_shear => models_has_shear     !! True if it has a shear modulus
      procedure :: has_whole_stress => models_has_whole_stress !! True if the law gives all stress
      procedure :: has => models_has                 !! True if an effect is on
      procedure :: reference_speed => models_reference_speed   !! Fastest signal at rest
      procedure :: bulk_in_rate_form => models_bulk_in_rate_form !! Mean stress follows the volume
   end type models_t

contains

   !> Fields that the models request.
   pure function models_field_requests(self) result(requests)
      class(models_t), intent(in) :: self
      type(field_requests_t) :: requests

      call requests%add("mass", "every material", 1)
      call requests%add("volume", "every material", 1)
      call requests%add("stress", "every material", 6)
      if (allocated(self%viscosity)) call requests%add("viscous_pressure", &
         "artificial viscosity", 1)
      if (allocated(self%eos)) call self%eos%request(requests)
      if (allocated(self%law)) call self%law%request(requests)
      if (allocated(self%damage)) call self%damage%request(requests)
      if (allocated(self%voids)) call requests%add("solid_fraction", "voids", 1)
      if (allocated(self%burn)) call requests%add("burn_time", "detonation", 1)
      if (allocated(self%heat)) call requests%add("temperature", "thermal effect", 1)
      if (allocated(self%failure%fracture)) then
         call requests%add("damage", "failure", 1)
         call requests%add("failed", "failure", 1)
      end if
      if (allocated(self%failure%fade)) call request_fading(requests)
      if (self%record%strain) call requests%add("equivalent_strain", "output", 1)
      if (self%record%inertia .and. allocated(self%law)) then
         if (self%law%has_grains()) call requests%add("inertial_number", "output", 1)
      end if
   end function models_field_requests

   !> True if its particles carry an internal energy.
   pure logical function models_carries_energy(self) result(carries)
      class(models_t), intent(in) :: self
      type(field_requests_t) :: requests

      requests = self%field_requests()
      carries = requests%has("energy")
   end function models_carries_energy

   !> Allocate the requested fields.
   pure subroutine models_allocate_state(self, state, particles)
      class(models_t), intent(in) :: self
      type(material_state_t), intent(out) :: state          !! State of its particles
      integer, optional, intent(in) :: particles            !! Capacity; 0 if not given
      type(field_requests_t) :: requests
      integer, allocatable :: own(:)
      integer :: i, n

      n = 0
      if (present(particles)) n = particles
      requests = self%field_requests()
      own = pack([(i, i=1, size(requests%entries))], requests%entries%own)
      allocate (state%own(size(own)))
      do i = 1, size(own)
         associate (entry => requests%entries(own(i)), field => state%own(i))
            field%name = entry%field
            field%unit = entry%unit
            field%start = entry%start
            allocate (field%values(n))
         end associate
      end do
      allocate (state%mass(n), state%volume(n), state%stress(n, 6))
      if (requests%has("viscous_pressure")) allocate (state%viscous_pressure(n))
      if (requests%has("energy")) allocate (state%energy(n))
      if (requests%has("burn_time")) allocate (state%burn_time(n))
      if (requests%has("temperature")) allocate (state%temperature(n))
      if (requests%has("plastic_strain")) allocate (state%plastic_strain(n))
      if (requests%has("plastic_dilation")) allocate (state%plastic_dilation(n))
      if (requests%has("porosity")) allocate (state%porosity(n))
      if (requests%has("damage")) allocate (state%damage(n))
      if (requests%has("scatter")) allocate (state%brittle%scatter(n))
      if (requests%has("overload")) allocate (state%brittle%overload(n))
      if (requests%has("bulking")) allocate (state%brittle%bulking(n))
      if (requests%has("solid_fraction")) allocate (state%solid_fraction(n))
      if (requests%has("deformation_gradient")) allocate (state%deformation_gradient(n, 9))
      if (requests%has("equivalent_strain")) allocate (state%recorded%equivalent_strain(n))
      if (requests%has("inertial_number")) allocate (state%recorded%inertial_number(n))
      if (requests%has("failed")) allocate (state%failed(n))
   end subroutine models_allocate_state

   !> Initial state of particles: at rest without stress. Mass and volume are set by the caller.
   pure subroutine models_start(self, state, first, last, temperature)
      class(models_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state        !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: temperature            !! Initial temperature [K]
      integer :: i

      state%stress(first:last, :) = 0.0_wp
      do i = 1, size(state%own)
         state%own(i)%values(first:last) = state%own(i)%start
      end do
      if (allocated(state%viscous_pressure)) state%viscous_pressure(first:last) = 0.0_wp
      if (allocated(state%energy)) state%energy(first:last) = &
         self%start_energy(temperature)
      if (allocated(state%burn_time)) state%burn_time(first:last) = burnt_before
      if (allocated(state%temperature)) state%temperature(first:last) = temperature
      if (allocated(state%plastic_strain)) state%plastic_strain(first:last) = 0.0_wp
      if (allocated(state%plastic_dilation)) state%plastic_dilation(first:last) = 0.0_wp
      if (allocated(state%porosity)) state%porosity(first:last) = self%law%porosity
      if (allocated(state%damage)) state%damage(first:last) = 0.0_wp
      if (allocated(state%brittle%scatter)) state%brittle%scatter(first:last) = 1.0_wp
      if (allocated(state%brittle%overload)) state%brittle%overload(first:last) = -1.0_wp
      if (allocated(state%brittle%bulking)) state%brittle%bulking(first:last) = 0.0_wp
      if (allocated(state%solid_fraction)) state%solid_fraction(first:last) = self%voids%start
      if (allocated(state%deformation_gradient)) then
         state%deformation_gradient(first:last, :) = 0.0_wp
         state%deformation_gradient(first:last, [1, 5, 9]) = 1.0_wp
      end if
      if (allocated(state%recorded%equivalent_strain)) &
         state%recorded%equivalent_strain(first:last) = 0.0_wp
      if (allocated(state%recorded%inertial_number)) state%recorded%inertial_number(first:last) = &
         0.0_wp
      if (allocated(state%failed)) state%failed(first:last) = 0
   end subroutine models_start

   !> Internal energy of material at the start [J/kg]: an explosive holds its chemical energy, a
   !! table has an energy for each temperature, and other laws whose pressure depends on the energy
   !! have that of the reference plus c_v times the difference to its temperature.
   pure real(wp) function models_start_energy(self, temperature) result(energy)
      class(models_t), intent(in) :: self
      real(wp), optional, intent(in) :: temperature  !! Used if the material has one [K]
      real(wp) :: cold

      energy = 0.0_wp
      if (.not. allocated(self%eos)) return
      if (.not. (allocated(self%heat) .and. present(temperature))) then
         energy = self%eos%start_energy()
         return
      end if
      energy = self%eos%start_energy(temperature)
      cold = self%eos%cold_temperature(self%heat%reference)
      if (cold >= 0.0_wp) energy = energy + self%heat%specific_heat*(temperature - cold)
   end function models_start_energy

   !> Temperature at the start of material of the reference density with an energy, the inverse of
   !! `start_energy` [K]; negative if the two are independent, or the equation of state finds it.
   pure real(wp) function models_temperature_of(self, energy) result(temperature)
      class(models_t), intent(in) :: self
      real(wp), intent(in) :: energy                 !! [J/kg]

      temperature = -1.0_wp
      if (.not. (allocated(self%eos) .and. allocated(self%heat))) return
      temperature = self%eos%cold_temperature(self%heat%reference)
      if (temperature >= 0.0_wp) temperature = max(0.0_wp, temperature + (energy &
         - self%eos%start_energy())/self%heat%specific_heat)
   end function models_temperature_of

   !> True if material at rest may have a stress: from an energy, or from its law.
   pure logical function models_starts_with_stress(self) result(does)
      class(models_t), intent(in) :: self

      does = .false.
      if (allocated(self%eos)) does = self%eos%starts_with_energy()
      if (allocated(self%law)) does = does .or. self%law%starts_with_stress()
   end function models_starts_with_stress

   !> True for the products of an explosive, which do not melt and have no strength.
   pure logical function models_is_gas_of_explosive(self) result(is_gas)
      class(models_t), intent(in) :: self

      is_gas = .false.
      if (allocated(self%eos)) is_gas = self%eos%detonates()
   end function models_is_gas_of_explosive

   !> Random strength of a new particle, if strength scatters: that of the weakest flaw in the box
   !! that it fills in the reference state.
   pure subroutine models_draw_strength(self, state, particle, low, high, blocks)
      class(models_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state        !! State of the store
      integer, intent(in) :: particle                !! Index in the store
      real(wp), intent(in) :: low(3), high(3)        !! Corners of the box [m]
      !> Blocks of flaws that cover it; default: found here
      type(flaw_blocks_t), optional, intent(in) :: blocks

      if (allocated(state%brittle%scatter)) state%brittle%scatter(particle) = &
         self%damage%strength_of(self%failure%flaws%weakest(low, high, blocks))
   end subroutine models_draw_strength

   !> True if the mean stress follows the dilatation, without equation of state and without a law
   !! that gives the whole stress.
   pure logical function models_bulk_in_rate_form(self) result(follows)
      class(models_t), intent(in) :: self

      follows = .not. allocated(self%eos)
      if (follows .and. allocated(self%law)) follows = .not. self%law%gives_whole_stress()
   end function models_bulk_in_rate_form

   !> True if the material has a shear modulus.
   pure logical function models_has_shear(self) result(has)
      class(models_t), intent(in) :: self

      has = .false.
      if (allocated(self%law)) has = self%law%has_shear()
   end function models_has_shear

   !> True if the law gives the whole stress.
   pure logical function models_has_whole_stress(self) result(has)
      class(models_t), intent(in) :: self

      has = .false.
      if (allocated(self%law)) has = self%law%gives_whole_stress()
   end function models_has_whole_stress

   !> Fastest signal [m/s] in the reference state, for the first time step.
   pure real(wp) function models_reference_speed(self) result(speed)
      class(models_t), intent(in) :: self

      ! Properties of a material with an error in the deck are unknown.
      speed = 0.0_wp
      if (.not. self%density > 0.0_wp) return
      speed = sqrt((self%bulk + 4.0_wp/3.0_wp*self%shear)/self%density)
   end function models_reference_speed

   !> True if an effect is on in this material.
   pure logical function models_has(self, effect) result(is_on)
      class(models_t), intent(in) :: self
      integer, intent(in) :: effect                  !! One of those of the stages

      select case (effect)
      case (effect_strength)
         is_on = allocated(self%law)
      case (effect_eos)
         is_on = allocated(self%eos) .and. .not. self%elastic_pressure
      case (effect_voids)
         is_on = allocated(self%voids)
      case (effect_damage)
         is_on = allocated(self%failure%fracture) .or. allocated(self%failure%spall)
      case (effect_thermal)
         is_on = allocated(self%heat)
      case (effect_viscosity)
         is_on = allocated(self%viscosity)
      case default
         is_on = .false.
      end select
   end function models_has
end module material_models
