! SPDX-License-Identifier: BSD-3-Clause
!> Abstract law of strength: it corrects the deviator of the stress after an elastic trial, or gives
!! the whole stress itself.
module material_law
   use base_kinds, only: wp
   use base_text, only: text_t
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_kinematics, only: predict_deviator
   use material_library, only: library_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: equivalent_stress, law_add_wave_speed, law_stored_energy, law_t, mean_work, &
      return_radially, strain_trial

   !> A law of strength. The material holds none if it has no strength.
   type, abstract :: law_t
      real(wp) :: shear = 0.0_wp                     !! Shear modulus [Pa]
      real(wp) :: bulk = 0.0_wp                      !! Bulk modulus of the reference state [Pa]
      real(wp) :: density = 0.0_wp                   !! Density of the reference state [kg/m3]
      real(wp) :: porosity = 0.0_wp                  !! Porosity of the reference state [1]
      real(wp) :: heat_share = 0.9_wp !! Heated by plastic work (Taylor, Quinney 1934) [1]
   contains
      procedure :: declare => law_declare            !! Declares its keys, if it has any
      procedure :: take_library => law_take_library  !! Gets its library, if it is in one
      procedure :: is_in_library => law_is_in_library !! True for a law of the user
      procedure :: report => law_report              !! What a user may want to know about it
      procedure :: read_mode => law_read_mode        !! Reads keys that decide on other models
      procedure :: fault => law_fault                !! Error in the combination of its keys
      procedure :: read => law_read                  !! Reads its keys
      procedure :: gives_whole_stress => law_gives_whole_stress !! True if it gives the whole stress
      procedure :: sets_bulk => law_sets_bulk        !! True if it gives the bulk modulus
      procedure :: starts_with_stress => law_starts_with_stress !! True if it has one at rest
      !> True if it finds the state that belongs to a stress
      procedure :: finds_rest_state => law_finds_rest_state
      procedure :: find_rest_state => law_find_rest_state !! State at rest under a given stress
      procedure :: has_shear => law_has_shear        !! True if it has a shear modulus
      procedure :: needs_eos => law_needs_eos        !! True if it needs an equation of state
      procedure :: supports_voids => law_supports_voids !! True if its material may be porous
      procedure :: grows_pores => law_grows_pores    !! True if the law has pores
      procedure :: softens_by_damage => law_softens_by_damage !! True if damage lowers its strength
      procedure :: uses_jc_rate => law_uses_jc_rate  !! True if it reads the key jc_rate
      procedure :: follows_density => law_follows_density !! True if its pressure must follow it
      procedure :: has_grains => law_has_grains      !! True if it has an inertial number
      procedure :: is_loose => law_is_loose          !! True if it is that of loose grains
      procedure :: is_plastic => law_is_plastic      !! True if it flows and so dissipates
      procedure :: request => law_request            !! Requests the fields it needs
      procedure :: predict_trial => law_predict_trial !! Trial deviator of the step
      procedure(update_i), deferred :: update        !! Corrects the trial deviator
      procedure :: add_wave_speed => law_add_wave_speed !! Contribution to the squared wave speed
      !> Wave speed added by its viscosity
      procedure :: add_viscous_speed => law_add_viscous_speed
      procedure :: stored_energy => law_stored_energy !! Energy stored in a particle
      procedure :: least_pressure => law_least_pressure !! Least pressure it supports
      procedure :: fault_of_state => law_fault_of_state !! Why a particle has no stress
   end type law_t

   abstract interface
      !> On entry the stress holds the trial deviator, on return the deviator. Plastic increment and
      !! plastic work are zero on entry. The pressure is that after the step, the wave speed holds
      !! the square of the bulk sound speed. A law that gives the whole stress sets the pressure.
      pure subroutine update_i(self, state, deformation, first, last, dt)
         import :: deformation_t, law_t, material_state_t, wp
         implicit none
         class(law_t), intent(in) :: self
         type(material_state_t), intent(inout) :: state               !! State of the store
         type(deformation_t), intent(inout) :: deformation     !! Step of the range
         integer, intent(in) :: first, last                    !! Particles of the range
         real(wp), intent(in) :: dt                            !! Time step [s]
      end subroutine update_i
   end interface

contains

   !> Declare the keys of &material that belong to the law. Most laws override this.
   subroutine law_declare(self, schema)
      class(law_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine law_declare

   !> Read the keys that belong to the law. The shear modulus is set by the material.
   pure subroutine law_read(self, group, effects)
      class(law_t), intent(inout) :: self
      type(group_t), intent(in) :: group                       !! &material
      type(effects_t), intent(in) :: effects
   end subroutine law_read

   !> Get the library with the law, and read its constants. Only a law in a library has one.
   subroutine law_take_library(self, library, group, system, faults)
      class(law_t), intent(inout) :: self
      type(library_t), intent(in) :: library                   !! As loaded
      type(group_t), intent(in) :: group                       !! &material
      integer, intent(in) :: system                            !! Units of the deck
      type(text_t), allocatable, intent(out) :: faults(:)      !! Errors in its constants

      allocate (faults(0))
   end subroutine law_take_library

   !> True if the law is in a shared library of the user.
   pure logical function law_is_in_library(self) result(is_in)
      class(law_t), intent(in) :: self

      is_in = .false.
   end function law_is_in_library

   !> Properties of the law that are not in the deck; empty if there are none.
   function law_report(self) result(text)
      class(law_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
   end function law_report

   !> Read the words that decide which other models the material has, before the deck is checked.
   pure subroutine law_read_mode(self, group)
      class(law_t), intent(inout) :: self
      type(group_t), intent(in) :: group                       !! &material
   end subroutine law_read_mode

   !> Error in the combination of the keys of the law, beyond those of single keys;
   !! empty if there is none.
   pure function law_fault(self, group, eos) result(text)
      class(law_t), intent(in) :: self
      type(group_t), intent(in) :: group                       !! &material
      class(eos_t), allocatable, intent(in) :: eos             !! Equation of state, if there is one
      character(len=:), allocatable :: text

      text = ""
   end function law_fault

   !> True if the law gives the whole stress. Then the material has no equation of state and no
   !! limit of tension, and the law computes its own trial stress, if any.
   pure logical function law_gives_whole_stress(self) result(whole)
      class(law_t), intent(in) :: self

      whole = .false.
   end function law_gives_whole_stress

   !> True if the bulk modulus follows from the keys of the law and is no key of the material.
   pure logical function law_sets_bulk(self) result(sets)
      class(law_t), intent(in) :: self

      sets = .false.
   end function law_sets_bulk

   !> True if the material has a stress in its reference state, which a law that gives the whole
   !! stress computes.
   pure logical function law_starts_with_stress(self) result(starts)
      class(law_t), intent(in) :: self

      starts = .false.
   end function law_starts_with_stress

   !> True if the law finds its state under the stress of a weight. Only a law that gives the whole
   !! stress does; otherwise the pressure is that of the density.
   pure logical function law_finds_rest_state(self) result(finds)
      class(law_t), intent(in) :: self

      finds = .false.
   end function law_finds_rest_state

   !> Set mass and fields of a particle so that the stress that it has is that of its state.
   pure subroutine law_find_rest_state(self, state, particle)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state           !! With stress and volume
      integer, intent(in) :: particle                          !! Index in the store
   end subroutine law_find_rest_state

   !> True if the law has a shear modulus.
   pure logical function law_has_shear(self) result(has)
      class(law_t), intent(in) :: self

      has = .true.
   end function law_has_shear

   !> True if the law needs more than a mean stress in rate form. Without an equation of state it
   !! then gets p = K (rho/rho0 - 1) with the bulk modulus of the material.
   pure logical function law_follows_density(self) result(follows)
      class(law_t), intent(in) :: self

      follows = .false.
   end function law_follows_density

   !> True if the law has the size and density of grains, which give the inertial number.
   pure logical function law_has_grains(self) result(has)
      class(law_t), intent(in) :: self

      has = .false.
   end function law_has_grains

   !> True if the law is that of loose grains, which separate without tension or flow at any stress.
   pure logical function law_is_loose(self) result(loose)
      class(law_t), intent(in) :: self

      loose = self%has_grains() .or. self%least_pressure() >= 0.0_wp
   end function law_is_loose

   !> True if the law needs an equation of state of a special kind.
   pure logical function law_needs_eos(self) result(needs)
      class(law_t), intent(in) :: self

      needs = .false.
   end function law_needs_eos

   !> True if the material of the law may have voids or pores.
   pure logical function law_supports_voids(self) result(supports)
      class(law_t), intent(in) :: self

      supports = .true.
   end function law_supports_voids

   !> True if the law has a porosity that flow changes.
   pure logical function law_grows_pores(self) result(grows)
      class(law_t), intent(in) :: self

      grows = .false.
   end function law_grows_pores

   !> True if the law itself lowers the strength of damaged material.
   pure logical function law_softens_by_damage(self) result(softens)
      class(law_t), intent(in) :: self

      softens = .false.
   end function law_softens_by_damage

   !> True if the law reads the key jc_rate, common to several models.
   pure logical function law_uses_jc_rate(self) result(uses)
      class(law_t), intent(in) :: self

      uses = .false.
   end function law_uses_jc_rate

   !> True if the law flows plastically: it dissipates energy, and damage by plastic strain is
   !! possible.
   pure logical function law_is_plastic(self) result(plastic)
      class(law_t), intent(in) :: self

      plastic = .true.
   end function law_is_plastic

   !> Request the fields that the law needs: none if the stress is its only state variable.
   pure subroutine law_request(self, requests)
      class(law_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests
   end subroutine law_request

   !> Elastic trial of the deviator with constant shear modulus and Jaumann rate, and the volume.
   pure subroutine law_predict_trial(self, state, deformation, first, last)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state                  !! State of the store
      type(deformation_t), intent(inout) :: deformation        !! Step of the range
      integer, intent(in) :: first, last                       !! Particles of the range

      call predict_deviator(self%shear, state, deformation, first, last)
   end subroutine law_predict_trial

   !> Add the contribution of the law to the square of the wave speed, where the material has not
   !! failed: for failed particles it would shorten the time step of a dispersing cloud of rubble
   !! without need. For a law that gives the whole stress the input is 0 and the result is the
   !! square of its fastest wave speed. Equation (A.5) of doc/theory/matter.md.
   pure subroutine law_add_wave_speed(self, state, deformation, first, last)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: shear, share
      integer :: i, k

      shear = self%shear
      if (.not. shear > 0.0_wp) return
      if (allocated(state%failed)) then
         do concurrent (i=1:last - first + 1)
            k = first - 1 + i
            share = 4.0_wp/3.0_wp*shear*state%volume(k)/state%mass(k)
            deformation%wave_speed(i) = deformation%wave_speed(i) &
               + merge(0.0_wp, share, state%failed(k) /= 0)
         end do
      else
         do concurrent (i=1:last - first + 1)
            k = first - 1 + i
            deformation%wave_speed(i) = deformation%wave_speed(i) &
               + 4.0_wp/3.0_wp*shear*state%volume(k)/state%mass(k)
         end do
      end if
   end subroutine law_add_wave_speed

   !> Raise the wave speed that limits the time step where the law has a viscosity.
   pure subroutine law_add_viscous_speed(self, state, deformation, first, last, spacing)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                     !! State of the store
      type(deformation_t), intent(inout) :: deformation        !! Step of the range
      integer, intent(in) :: first, last                       !! Particles of the range
      real(wp), intent(in) :: spacing                          !! Cell size [m]
   end subroutine law_add_viscous_speed

   !> Energy [J] stored in the deviator of the stress of one particle; in the whole stress for a law
   !! that gives it.
   pure real(wp) function law_stored_energy(self, state, particle) result(energy)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                     !! State of the store
      integer, intent(in) :: particle                                 !! Index in the store
      real(wp) :: mean

      energy = 0.0_wp
      if (self%shear <= 0.0_wp) return
      mean = sum(state%stress(particle, 1:3))/3.0_wp
      energy = state%volume(particle)*(sum((state%stress(particle, 1:3) - mean)**2) &
         + 2.0_wp*sum(state%stress(particle, 4:6)**2))/(4.0_wp*self%shear)
   end function law_stored_energy

   !> Least pressure that the law supports [Pa].
   pure real(wp) function law_least_pressure(self) result(pressure)
      class(law_t), intent(in) :: self

      pressure = -huge(1.0_wp)
   end function law_least_pressure

   !> Why a particle has no finite stress; empty if the law does not know.
   function law_fault_of_state(self, state, particle) result(text)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state              !! State of the store
      integer, intent(in) :: particle                          !! Index in the store
      character(len=:), allocatable :: text

      text = ""
   end function law_fault_of_state

   !> Equivalent stress of von Mises of the trial deviators, sqrt(3/2 s:s), in place of the plastic
   !! increments.
   pure subroutine equivalent_stress(state, deformation, first, last)
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%plastic_increment(i) = sqrt(1.5_wp*(state%stress(k, 1)**2 + state%stress(k, &
            2)**2 + state%stress(k, 3)**2 + 2.0_wp*(state%stress(k, 4)**2 + state%stress(k, 5)**2 &
            + state%stress(k, 6)**2)))
      end do
   end subroutine equivalent_stress

   !> Trial deviator times strain increment, s* : e, in place of the plastic work. Laws need it for
   !! the work on the plastic strain of the mean of the stresses s before and s' after the step, (s
   !! + s') : (s* - s')/(4 G), where s = s* - 2 G e except for the rotation. With s' alone in place
   !! of the mean, grains that come into contact without stress would lose energy.
   pure subroutine strain_trial(state, deformation, first, last)
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%plastic_work(i) = state%stress(k, 1)*deformation%gradient(i, 1) &
            + state%stress(k, 2)*deformation%gradient(i, 5) + state%stress(k, 3) &
            *deformation%gradient(i, 9) + state%stress(k, 4)*(deformation%gradient(i, 2) &
            + deformation%gradient(i, 4)) + state%stress(k, 5)*(deformation%gradient(i, 6) &
            + deformation%gradient(i, 8)) + state%stress(k, 6)*(deformation%gradient(i, 3) &
            + deformation%gradient(i, 7))
      end do
   end subroutine strain_trial

   !> Work per volume of a radial return on the plastic strain: that of the mean of the stresses
   !! before and after the step, (s + s') : (s* - s')/(4 G), so that the energy balance is of second
   !! order. Negative work is replaced by 0; otherwise softening material under a rotating load
   !! would gain energy. Equation (Y.2) of doc/theory/strength.md.
   elemental real(wp) function mean_work(shear, trial, limit, increment, product_of_both) &
      result(work)
      real(wp), intent(in) :: shear                        !! Shear modulus of the trial [Pa]
      real(wp), intent(in) :: trial                        !! Equivalent trial stress [Pa]
      real(wp), intent(in) :: limit                        !! Equivalent stress after the step [Pa]
      real(wp), intent(in) :: increment                    !! Increment of the plastic strain [1]
      real(wp), intent(in) :: product_of_both              !! s* : e, of `strain_trial` [Pa]

      work = increment*max(0.0_wp, 0.5_wp*(trial + limit) &
         - 1.5_wp*shear*product_of_both/max(trial, tiny(1.0_wp)))
   end function mean_work

   !> Radial return of the trial deviators to yield stresses that grow linearly in the step, and its
   !! work (M. L. Wilkins, "Calculation of elastic-plastic flow", 1964; closed form). The yield
   !! stresses before the step are in `strength%tangent`, the equivalent trial stress and the
   !! product of `strain_trial` in place of plastic increment and plastic work. Equations (Y.1),
   !! (Y.2) and (Y.3).
   pure subroutine return_radially(shear, hardening, state, deformation, first, last)
      real(wp), intent(in) :: shear                        !! Shear modulus of the trial [Pa]
      real(wp), intent(in) :: hardening                    !! Slope of the yield stress [Pa]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: trial, limit, flow, softness, scaling
      integer :: i, k

      softness = 1.0_wp/(3.0_wp*shear + hardening)
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trial = deformation%plastic_increment(i)
         flow = max(trial - deformation%strength%tangent(i), 0.0_wp)*softness
         limit = deformation%strength%tangent(i) + hardening*flow
         deformation%plastic_increment(i) = flow
         deformation%plastic_work(i) = state%volume(k)*mean_work(shear, trial, limit, flow, &
            deformation%plastic_work(i))
         ! the factor is 1 if the particle does not flow
         scaling = limit/max(trial, limit, tiny(1.0_wp))
         state%stress(k, 1:6) = scaling*state%stress(k, 1:6)
      end do
   end subroutine return_radially
end module material_law
