! SPDX-License-Identifier: BSD-3-Clause
!> Update of a material in a time step: a chain of models, each only if requested. Its links are
!! equations (A.1) to (A.14) of doc/theory/matter.md and those of the laws.
module material_update
   use base_elementary, only: exponential
   use base_kinds, only: int64, wp
   use material_expanded, only: count_expanded, cut_expanded_tension, &
      keep_expanded_speed, remove_expanded_deviator
   use material_failed, only: failed_subset_t, remove_failed_stress
   use material_heat, only: cut_melted_tension, heat_particles
   use material_kinematics, only: dilate
   use material_models, only: models_t
   use material_pore_volume, only: take_matrix_pressure, to_matrix_volume, to_matrix_volumes
   use material_record, only: add_strain
   use material_softening, only: cracked
   use material_stages, only: stage_count, stage_deviator, stage_dilatation, stage_failed_law, &
      stage_failure, stage_pressure, stage_remove_stress, stage_restore_stress, stage_stress, &
      stage_temperature, stage_trial, stage_viscosity, stage_viscous_work, stage_voids
   use material_state, only: deformation_t, material_state_t
   use material_tension, only: cut_tension, drop_loose_pressure, fade_tension, &
      fail_particles, remove_failed_deviator, remove_melted_deviator
   use material_viscosity, only: add_viscous_pressure
   use material_voids, only: expand_grains
   implicit none
   private

   public :: chain_t

   !> The models, in the order of their update in a time step.
   type, extends(models_t) :: chain_t
   contains
      procedure :: find_rest_stress => chain_find_rest_stress !! Stress of a given state at rest
      procedure :: free_density => chain_free_density         !! Density at a temperature, unloaded
      procedure :: update => chain_update            !! One time step
      procedure :: run_stage => chain_run_stage               !! One stage of it
      procedure :: signal_speed => chain_signal_speed         !! Fastest signal of a state
      procedure :: stored_energy => chain_stored_energy       !! Internal energy of particles
   end type chain_t

contains

   !> Stress of particles at rest whose volume, energy, deformation gradient or deviator of stress
   !! were set from outside: a step of zero length without deformation.
   pure subroutine chain_find_rest_stress(self, state, first, last)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state        !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range
      ! Shorter than any time scale of the material, but still a valid divisor.
      real(wp), parameter :: instant = 1.0e-100_wp
      type(deformation_t) :: deformation

      if (last < first) return
      call deformation%reserve(last - first + 1)
      deformation%gradient = 0.0_wp
      deformation%jump = 0.0_wp
      call self%update(state, deformation, first, last, instant, 1.0_wp)
   end subroutine chain_find_rest_stress

   !> Density of unloaded material at a temperature [kg/m3]: it has expanded since t_ref until its
   !! pressure was zero. That of the reference state where the pressure does not follow the
   !! temperature, for gases, explosives, tables and porous material, and if there is none, as above
   !! boiling. Equation (E.3) of doc/theory/equations_of_state.md, by the secant method.
   pure real(wp) function chain_free_density(self, temperature) result(density)
      class(chain_t), intent(in) :: self
      real(wp), intent(in) :: temperature            !! [K]
      integer, parameter :: rounds = 40
      real(wp), parameter :: lightest = 0.5_wp       ! of the reference state, less has boiled [1]
      real(wp) :: share, before, found, earlier, step
      integer :: round

      density = self%density
      if (.not. (allocated(self%eos) .and. allocated(self%heat)) .or. allocated(self%voids)) return
      if (.not. self%reference_speed() > 0.0_wp .or. self%eos%starts_with_energy() &
         .or. self%eos%has_pores() .or. self%eos%cold_temperature(self%heat%reference) < 0.0_wp) &
         return
      if (.not. self%carries_energy()) return
      if (allocated(self%law)) then
         if (self%law%grows_pores()) return
      end if
      before = 1.0_wp
      call find_pressure(before, earlier)
      share = 1.0_wp - earlier/self%bulk
      do round = 1, rounds
         if (share < lightest .or. share > 1.0_wp/lightest) return
         call find_pressure(share, found)
         if (.not. abs(found - earlier) > 0.0_wp) exit
         step = found*(share - before)/(found - earlier)
         before = share
         earlier = found
         share = share - step
         if (abs(step) <= epsilon(1.0_wp)) exit
      end do
      if (abs(found) <= 1.0e-9_wp*self%bulk) density = share*self%density

   contains

      !> Pressure at a fraction of the density of reference.
      pure subroutine find_pressure(share, pressure)
         real(wp), intent(in) :: share               !! [1]
         real(wp), intent(out) :: pressure           !! [Pa]
         type(material_state_t) :: state

         call self%allocate_state(state, 1)
         state%volume = 1.0_wp
         state%mass = self%density*share
         call self%start(state, 1, 1, temperature)
         call self%find_rest_stress(state, 1, 1)
         pressure = -(state%stress(1, 1) + state%stress(1, 2) + state%stress(1, 3))/3.0_wp
      end subroutine find_pressure
   end function chain_free_density

   !> Fastest signal [m/s] of a range of particles in their present state, for the first time step
   !! of material that does not start in the reference state.
   pure real(wp) function chain_signal_speed(self, state, first, last) result(speed)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range
      type(deformation_t) :: deformation
      type(material_state_t) :: solid
      integer :: count

      speed = 0.0_wp
      count = last - first + 1
      if (count < 1) return
      call deformation%reserve(count)
      deformation%wave_speed(:count) = 0.0_wp
      if (allocated(self%voids)) then
         solid = state
         deformation%voids%alpha(:count) = 1.0_wp
         call self%voids%to_solid_volume(solid, deformation, first, last)
         call self%eos%update(solid, deformation, first, last)
         call self%voids%to_total_volume(solid, deformation, first, last)
      else if (allocated(state%porosity)) then
         solid = state
         call to_matrix_volume(solid, deformation, first, last)
         call self%eos%update(solid, deformation, first, last)
      else if (allocated(self%eos)) then
         call self%eos%update(state, deformation, first, last)
      else if (self%bulk_in_rate_form()) then
         deformation%wave_speed(:count) = self%bulk*state%volume(first:last) &
            /state%mass(first:last)
         deformation%pressure(:count) = -(state%stress(first:last, 1) &
            + state%stress(first:last, 2) + state%stress(first:last, 3))/3.0_wp
         if (allocated(state%viscous_pressure)) deformation%pressure(:count) = &
            deformation%pressure(:count) - state%viscous_pressure(first:last)
      end if
      if (allocated(self%law)) call self%law%add_wave_speed(state, deformation, first, last)
      speed = sqrt(maxval(deformation%wave_speed(:count)))
   end function chain_signal_speed

   !> One time step of a range of particles, with the gradient given and the work of the stress of
   !! the force already in the energy: all stages in their order.
   pure subroutine chain_update(self, state, deformation, first, last, dt, spacing)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range
      real(wp), intent(in) :: dt                         !! Time step [s]
      real(wp), intent(in) :: spacing                    !! Cell size [m]
      type(failed_subset_t) :: subset
      integer :: stage

      if (last < first) return
      do stage = 1, stage_count
         call self%run_stage(stage, state, deformation, first, last, dt, spacing, subset)
      end do
   end subroutine chain_update

   !> One stage of a time step, so that a caller can time the stages.
   ! All stages have one interface.
   pure subroutine chain_run_stage(self, stage, state, deformation, first, last, dt, spacing, &
      subset)
      class(chain_t), intent(in) :: self
      integer, intent(in) :: stage                       !! One of those of material_stages
      type(material_state_t), intent(inout) :: state     !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range, not empty
      real(wp), intent(in) :: dt                         !! Time step [s]
      real(wp), intent(in) :: spacing                    !! Cell size [m]
      type(failed_subset_t), intent(inout) :: subset     !! Failed particles, kept between stages

      select case (stage)
      case (stage_restore_stress)
         if (allocated(self%failure%softening)) &
            call self%failure%softening%restore_uncracked_stress(state, deformation, &
            first, last)
         if (allocated(self%failure%failed_law)) &
            call self%failure%failed_law%gather(state, deformation, first, last, subset)
      case (stage_dilatation)
         if (allocated(self%voids)) call self%voids%choose_fraction(state, deformation, first, last)
      case (stage_trial)
         call predict_trial(self, state, deformation, first, last)
      case (stage_voids)
         if (allocated(self%voids)) &
            call self%voids%update_solid_fraction(state, deformation, first, last)
      case (stage_pressure)
         call update_pressure(self, state, deformation, first, last)
      case (stage_failed_law)
         if (allocated(self%failure%failed_law)) &
            call self%failure%failed_law%update(state, deformation, first, dt, subset)
      case (stage_deviator)
         if (allocated(self%failure%softening)) &
            call self%failure%softening%reduce_trial(state, deformation, first, last)
         if (allocated(self%law)) call update_deviator(self, state, deformation, first, last, dt)
      case (stage_failure)
         if (allocated(self%failure%failed_law)) &
            call self%failure%failed_law%scatter(subset, state, deformation, first)
         if (allocated(self%failure%softening)) &
            call self%failure%softening%open_cracks(state, deformation, first, last, spacing)
         if (allocated(self%damage)) call self%damage%update(state, deformation, first, last, dt)
         call limit_tension(self, state, deformation, first, last, dt)
      case (stage_viscous_work)
         if (allocated(self%viscosity)) call find_viscous_work(state, deformation, first, last)
      case (stage_temperature)
         if (allocated(self%heat)) call update_temperature(self, state, deformation, first, last)
      case (stage_viscosity)
         call find_wave_speed(self, state, deformation, first, last, spacing/dt)
      case (stage_stress)
         call assemble_stress(self, state, deformation, first, last, spacing)
      case (stage_remove_stress)
         if (allocated(self%failure%fracture)) then
            if (self%failure%fracture%leaves_nothing) &
               call remove_failed_stress(state, deformation, first, last)
         end if
      case default
      end select
   end subroutine chain_run_stage

   !> Volume after the step, and the elastic trial of the deviator.
   pure subroutine predict_trial(self, state, deformation, first, last)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count

      count = last - first + 1
      deformation%plastic_work(:count) = 0.0_wp
      deformation%viscous_work(:count) = 0.0_wp
      deformation%plastic_increment(:count) = 0.0_wp
      if (allocated(state%recorded%equivalent_strain)) call add_strain(first, last, &
         deformation%plane, deformation%gradient, state%recorded%equivalent_strain)
      if (allocated(self%law)) then
         call self%law%predict_trial(state, deformation, first, last)
      else
         call dilate(state, deformation, first, last)
      end if
   end subroutine predict_trial

   !> Viscous pressure of the next step, and the wave speed from its square.
   pure subroutine find_wave_speed(self, state, deformation, first, last, rate)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: rate                         !! Cell size over time step [m/s]
      integer :: i

      if (.not. allocated(self%viscosity)) then
         do concurrent (i=1:last - first + 1)
            deformation%wave_speed(i) = sqrt(deformation%wave_speed(i))
         end do
      else if (self%viscosity%limited) then
         call add_viscous_pressure(self%viscosity, rate, deformation%jump, state, deformation, &
            first, last)
      else
         call add_viscous_pressure(self%viscosity, rate, deformation%dilatation, state, &
            deformation, first, last)
      end if
   end subroutine find_wave_speed

   !> Stress from deviator and pressure, and the contribution of the viscosity of a law to the wave
   !! speed. Equation (A.6).
   pure subroutine assemble_stress(self, state, deformation, first, last, spacing)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: spacing                      !! Cell size [m]
      integer :: i, k

      if (allocated(self%law)) then
         call self%law%add_viscous_speed(state, deformation, first, last, spacing)
         do concurrent (i=1:last - first + 1)
            k = first - 1 + i
            state%stress(k, 1) = state%stress(k, 1) - deformation%pressure(i)
            state%stress(k, 2) = state%stress(k, 2) - deformation%pressure(i)
            state%stress(k, 3) = state%stress(k, 3) - deformation%pressure(i)
         end do
      else
         do concurrent (i=1:last - first + 1)
            k = first - 1 + i
            state%stress(k, 1) = -deformation%pressure(i)
            state%stress(k, 2) = -deformation%pressure(i)
            state%stress(k, 3) = -deformation%pressure(i)
         end do
      end if
   end subroutine assemble_stress

   !> Work of the viscous pressure that was part of the force of the step, so that it balances the
   !! work that the force did. It can be negative for the one step in which compression ends.
   !! Equation (L.4) of doc/theory/ledger.md.
   pure subroutine find_viscous_work(state, deformation, first, last)
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i

      do concurrent (i=1:last - first + 1)
         deformation%viscous_work(i) = -state%viscous_pressure(first - 1 + i) &
            *deformation%dilatation(i)*deformation%old_volume(i)
      end do
   end subroutine find_viscous_work

   !> Pressure of the material, and the square of its wave speed without strength. Without equation
   !! of state the mean stress has a rate form, dp = -K tr(strain). Equation (A.4) of
   !! doc/theory/matter.md.
   pure subroutine update_pressure(self, state, deformation, first, last)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      if (allocated(self%voids)) then
         call self%voids%to_solid_volume(state, deformation, first, last)
         call self%eos%update(state, deformation, first, last)
         call add_bulking(state, deformation, first, last)
         call self%voids%to_total_volume(state, deformation, first, last)
      else if (allocated(state%porosity)) then
         call to_matrix_volume(state, deformation, first, last)
         call self%eos%update(state, deformation, first, last)
         call take_matrix_pressure(state, deformation, first, last)
      else if (allocated(self%eos)) then
         call self%eos%update(state, deformation, first, last)
         if (allocated(self%burn)) call self%burn%apply(state, deformation, first, last)
         call add_bulking(state, deformation, first, last)
         call self%eos%keep_state(state, deformation, first, last)
      else if (self%bulk_in_rate_form()) then
         if (allocated(self%viscosity)) deformation%pressure(:last - first + 1) = &
            deformation%pressure(:last - first + 1) - state%viscous_pressure(first:last)
         associate (bulk => self%bulk)
            do concurrent (i=1:last - first + 1)
               k = first - 1 + i
               deformation%pressure(i) = deformation%pressure(i) - bulk*deformation%dilatation(i)
               deformation%wave_speed(i) = bulk*state%volume(k)/state%mass(k)
            end do
         end associate
      else
         deformation%wave_speed(:last - first + 1) = 0.0_wp
      end if
   end subroutine update_pressure

   !> Add the pressure made by fracture, if any, to that of the equation of state.
   pure subroutine add_bulking(state, deformation, first, last)
      type(material_state_t), intent(in) :: state               !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range

      if (allocated(state%brittle%bulking)) deformation%pressure(:last - first + 1) = &
         deformation%pressure(:last - first + 1) + state%brittle%bulking(first:last)
   end subroutine add_bulking

   !> Deviator of stress, and the contribution of strength to the square of the wave speed.
   pure subroutine update_deviator(self, state, deformation, first, last, dt)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range
      real(wp), intent(in) :: dt                         !! Time step [s]
      real(wp), allocatable :: square(:)                 ! of the speed of sound, if some are vapour

      ! Before the law, so that material without strength does not flow plastically.
      if (allocated(self%failure%failed_law)) then
         call remove_failed_deviator(state, first, last)
      else if (allocated(self%failure%fracture)) then
         if (.not. self%failure%fracture%leaves_strength) &
            call remove_failed_deviator(state, first, last)
      end if
      if (allocated(self%melting)) call remove_melted_deviator(self%melting, state, first, last)
      if (some_expanded(self, state, first, last)) then
         square = deformation%wave_speed(:last - first + 1)
         call remove_expanded_deviator(self%density, state, first, last)
      end if
      call self%law%update(state, deformation, first, last, dt)
      call self%law%add_wave_speed(state, deformation, first, last)
      if (allocated(square)) call keep_expanded_speed(self%density, state, square, deformation, &
         first, last)
   end subroutine update_deviator

   !> Cut the tension or let particles fail.
   pure subroutine limit_tension(self, state, deformation, first, last, dt)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range
      real(wp), intent(in) :: dt                         !! Time step [s]

      if (allocated(self%failure%fracture)) then
         call fail_particles(self%failure%fracture, self%shear, self%bulk, state, deformation, &
            first, last)
         if (allocated(self%failure%fade)) call fade_tension(self%failure%fade, state, &
            deformation, first, last, dt)
         if (.not. allocated(self%eos)) call drop_loose_pressure(self%density, self%bulk, state, &
            deformation, first, last)
      else if (allocated(self%failure%spall)) then
         call cut_tension(self%failure%spall%strength, deformation, last - first + 1)
      else if (allocated(self%heat)) then
         deformation%pressure_floor(:last - first + 1) = -huge(1.0_wp)
      end if
      if (allocated(self%melting)) &
         call cut_melted_tension(self%melting, state, deformation, first, last)
      if (some_expanded(self, state, first, last)) call cut_expanded_tension(self%density, state, &
         deformation, first, last)
   end subroutine limit_tension

   !> Has solid material of a range expanded to a fluid? Porous material and grains have their own
   !! rules.
   pure logical function some_expanded(self, state, first, last) result(some)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      integer, intent(in) :: first, last                   !! Particles of the range

      some = allocated(self%eos) .and. allocated(state%energy) .and. &
         .not. (allocated(self%voids) .or. allocated(state%porosity))
      if (some) some = count_expanded(self%density, state, first, last) > 0
   end function some_expanded

   !> Temperature after the step.
   pure subroutine update_temperature(self, state, deformation, first, last)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range
      real(wp) :: plastic_share
      logical :: given

      plastic_share = 0.9_wp
      if (allocated(self%law)) then
         plastic_share = self%law%heat_share
         deformation%pressure_floor(:last - first + 1) = max(self%law%least_pressure(), &
            deformation%pressure_floor(:last - first + 1))
      end if
      if (allocated(self%voids)) &
         deformation%voids%old_temperature(:last - first + 1) = state%temperature(first:last)
      if (allocated(self%voids)) call self%voids%to_solid_volumes(state, deformation, first, last)
      if (allocated(state%porosity)) &
         call to_matrix_volumes(state, deformation, first, last)
      given = .false.
      if (allocated(self%eos)) given = self%eos%gives_temperature()
      if (given) then
         call self%eos%find_temperature(state, first, last)
      else
         deformation%gruneisen(:last - first + 1) = 0.0_wp
         if (allocated(self%eos)) call self%eos%find_gruneisen(state, deformation, first, last)
         call heat_particles(self%heat%specific_heat, plastic_share, state, deformation, first, &
            last)
      end if
      if (allocated(state%porosity) .or. allocated(self%voids)) &
         state%volume(first:last) = deformation%voids%total_volume(:last - first + 1)
      if (allocated(self%voids)) call expand_grains(self%voids%expansion, state, deformation, &
         first, last)
   end subroutine update_temperature

   !> Internal energy [J] of particles: the energy field if there is one, otherwise the elastic
   !! energy. Equation (L.2) of doc/theory/ledger.md.
   pure subroutine chain_stored_energy(self, state, first, last, energy)
      class(chain_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(inout) :: energy(:) !! (range) [J]
      real(wp) :: limit, pressure, volume
      integer :: i, k

      do i = 1, last - first + 1
         k = first - 1 + i
         if (allocated(state%energy)) then
            energy(i) = state%mass(k)*state%energy(k)
            cycle
         end if
         energy(i) = 0.0_wp
         if (allocated(self%failure%fracture)) then
            if (self%failure%fracture%leaves_nothing .and. state%failed(k) /= 0) cycle
         end if
         limit = -huge(1.0_wp)
         if (allocated(self%law)) limit = self%law%least_pressure()
         if (allocated(self%eos)) then
            if (allocated(self%failure%spall)) limit = max(limit, -self%failure%spall%strength)
            if (allocated(state%failed)) limit = merge(0.0_wp, limit, state%failed(k) /= 0)
            volume = state%volume(k)
            if (allocated(state%solid_fraction)) volume = volume*state%solid_fraction(k)
            if (allocated(state%plastic_dilation)) volume = volume &
               *exponential(-state%plastic_dilation(k))
            energy(i) = self%eos%stored_energy(state%mass(k), volume, limit)
         else if (self%bulk_in_rate_form()) then
            pressure = -sum(state%stress(k, 1:3))/3.0_wp
            if (allocated(state%viscous_pressure)) pressure = pressure - state%viscous_pressure(k)
            energy(i) = state%volume(k)*pressure**2/(2.0_wp*self%bulk)
         end if
         if (allocated(self%failure%softening)) then
            if (cracked(state%damage(k))) then
               energy(i) = self%failure%softening%stored_energy(state, k, energy(i))
               cycle
            end if
         end if
         if (allocated(self%law)) energy(i) = energy(i) + self%law%stored_energy(state, k)
      end do
   end subroutine chain_stored_energy
end module material_update
