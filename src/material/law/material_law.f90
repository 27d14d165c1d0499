! SPDX-License-Identifier: BSD-3-Clause
!> Abstract law of strength: it corrects the deviator of the stress after an elastic trial, or gives
!! the whole stress itself.
module material_law
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_kinematics, only: predict_deviator
   use material_state, only: deformation_t, material_state_t
   use material_tension, only: add_intact_shear_speed, add_shear_speed
   implicit none
   private

   public :: equivalent_stress, law_add_wave_speed, law_stored_energy, law_t, mean_work, &
      return_radially, strain_trial

   !> A law of strength. The material holds none if it has no strength.
   type, abstract :: law_t
      real(wp) :: shear = 0.0_wp                     !! Shear modulus [Pa]
      real(wp) :: bulk = 0.0_wp                      !! Bulk modulus of the reference state [Pa]
      real(wp) :: density = 0.0_wp                   !! Density of the reference state [kg/m3]
      real(wp) :: heat_share = 0.9_wp !! Heated by plastic work (Taylor, Quinney 1934) [1]
   contains
      procedure :: declare => law_declare            !! Declares its keys, if it has any
      procedure :: read_mode => law_read_mode        !! Reads keys that decide on other models
      procedure :: fault => law_fault                !! Error in the combination of its keys
      procedure :: read => law_read                  !! Reads its keys
      procedure :: gives_whole_stress => law_gives_whole_stress !! True if it gives the whole stress
      procedure :: has_shear => law_has_shear        !! True if it has a shear modulus
      procedure :: needs_eos => law_needs_eos        !! True if it needs an equation of state
      procedure :: supports_voids => law_supports_voids !! True if its material may be porous
      procedure :: grows_pores => law_grows_pores    !! True if the law has pores
      procedure :: initial_porosity => law_initial_porosity !! Porosity of the reference state
      procedure :: softens_by_damage => law_softens_by_damage !! True if damage lowers its strength
      procedure :: uses_jc_rate => law_uses_jc_rate  !! True if it reads the key jc_rate
      procedure :: follows_density => law_follows_density !! True if its pressure must follow it
      procedure :: has_grains => law_has_grains      !! True if it has an inertial number
      procedure :: is_plastic => law_is_plastic      !! True if it flows and so dissipates
      procedure(request_i), deferred :: request      !! Requests the fields it needs
      procedure :: predict_trial => law_predict_trial !! Trial deviator of the step
      procedure(update_i), deferred :: update        !! Corrects the trial deviator
      procedure :: add_wave_speed => law_add_wave_speed !! Contribution to the squared wave speed
      !> Wave speed added by its viscosity
      procedure :: add_viscous_speed => law_add_viscous_speed
      procedure :: stored_energy => law_stored_energy !! Energy stored in a particle
      procedure :: least_pressure => law_least_pressure !! Least pressure it supports
   end type law_t

   abstract interface
      pure subroutine request_i(self, requests)
         import :: law_t, field_requests_t
         implicit none
         class(law_t), intent(in) :: self
         class(field_requests_t), intent(inout) :: requests
      end subroutine request_i

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

   !> Porosity of the reference state [1].
   pure real(wp) function law_initial_porosity(self) result(porosity)
      class(law_t), intent(in) :: self

      porosity = 0.0_wp
   end function law_initial_porosity

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

   !> Elastic trial of the deviator with constant shear modulus and Jaumann rate, and the volume.
   pure subroutine law_predict_trial(self, state, deformation, first, last)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state                  !! State of the store
      type(deformation_t), intent(inout) :: deformation        !! Step of the range
      integer, intent(in) :: first, last                       !! Particles of the range

      call predict_deviator(first, last, deformation%plane, self%shear, deformation%gradient, &
         state%volume, state%stress, deformation%old_volume, deformation%dilatation, &
         deformation%pressure)
   end subroutine law_predict_trial

   !> Add the contribution of the law to the square of the wave speed. For a law that gives the
   !! whole stress the input is 0 and the result is the square of its fastest wave speed.
   pure subroutine law_add_wave_speed(self, state, deformation, first, last)
      class(law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                     !! State of the store
      type(deformation_t), intent(inout) :: deformation        !! Step of the range
      integer, intent(in) :: first, last                       !! Particles of the range

      if (allocated(state%failed)) then
         call add_intact_shear_speed(first, last, self%shear, state%failed, state%mass, &
            state%volume, deformation%wave_speed)
      else
         call add_shear_speed(first, last, self%shear, state%mass, state%volume, &
            deformation%wave_speed)
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

   !> Equivalent stress of von Mises of deviators: sqrt(3/2 s:s).
   pure subroutine equivalent_stress(first, last, stress, equivalent)
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), contiguous, intent(in) :: stress(:, :)         !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: equivalent(:)     !! (range) [Pa]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         equivalent(i) = sqrt(1.5_wp*(stress(k, 1)**2 + stress(k, 2)**2 + stress(k, 3)**2 &
            + 2.0_wp*(stress(k, 4)**2 + stress(k, 5)**2 + stress(k, 6)**2)))
      end do
   end subroutine equivalent_stress

   !> Trial deviator times strain increment, s* : e. Laws need it for the work on the plastic strain
   !! of the mean of the stresses s before and s' after the step, (s + s') : (s* - s')/(4 G), where
   !! s = s* - 2 G e except for the rotation. With s' alone in place of the mean, grains that come
   !! into contact without stress would lose energy.
   pure subroutine strain_trial(first, last, gradient, stress, product_of_both)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: gradient(:, :)  !! dt du_k/dx_l (range, 9) [1]
      real(wp), contiguous, intent(in) :: stress(:, :)    !! Trial deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: product_of_both(:) !! (range) [Pa]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         product_of_both(i) = stress(k, 1)*gradient(i, 1) + stress(k, 2)*gradient(i, 5) &
            + stress(k, 3)*gradient(i, 9) + stress(k, 4)*(gradient(i, 2) + gradient(i, 4)) &
            + stress(k, 5)*(gradient(i, 6) + gradient(i, 8)) &
            + stress(k, 6)*(gradient(i, 3) + gradient(i, 7))
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

   !> Radial return to equivalent stresses, and its work. Equations (Y.1) and (Y.2).
   pure subroutine return_radially(first, last, shear, limit, increment, volume, stress, &
      plastic_increment, plastic_work)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: shear                  !! Shear modulus of the trial [Pa]
      real(wp), contiguous, intent(in) :: limit(:)   !! Equivalent stress at yield (range) [Pa]
      real(wp), contiguous, intent(in) :: increment(:) !! Plastic strain (range) [1]
      real(wp), contiguous, intent(in) :: volume(:)  !! (store) [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :)          !! Deviator (store, 6) [Pa]
      !> Equivalent trial stress [Pa] in, plastic increment [1] out (range).
      real(wp), contiguous, intent(inout) :: plastic_increment(:)
      !> Trial deviator times strain increment [Pa] in, plastic work [J] out (range).
      real(wp), contiguous, intent(inout) :: plastic_work(:)
      real(wp) :: trial, scaling
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trial = plastic_increment(i)
         plastic_increment(i) = increment(i)
         plastic_work(i) = volume(k)*mean_work(shear, trial, limit(i), increment(i), &
            plastic_work(i))
         ! the factor is 1 if the particle does not flow
         scaling = limit(i)/max(trial, limit(i), tiny(1.0_wp))
         stress(k, 1) = scaling*stress(k, 1)
         stress(k, 2) = scaling*stress(k, 2)
         stress(k, 3) = scaling*stress(k, 3)
         stress(k, 4) = scaling*stress(k, 4)
         stress(k, 5) = scaling*stress(k, 5)
         stress(k, 6) = scaling*stress(k, 6)
      end do
   end subroutine return_radially
end module material_law
