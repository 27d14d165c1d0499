! SPDX-License-Identifier: BSD-3-Clause
!> The chain of laws that a time step of a material runs through, each link only if asked for.
module material_chain
   use base_kinds, only: int64, wp
   use material_damage, only: damage_t
   use material_eos, only: eos_t
   use material_heat, only: heat, heat_t, melt
   use material_kinematics, only: dilate
   use material_law, only: law_t
   use material_matter, only: deformation_t, matter_t
   use material_remains, only: remains_t, share_t, vanish
   use material_softening, only: softening_t
   use material_stress, only: assemble, assemble_isotropic, follow_rate, square_root
   use material_tension, only: break, cut_tension, drop_failed, drop_melted, fail, fracture_t, &
      open_voids, spall_t
   use material_viscosity, only: resist, viscosity_t, viscous_losses
   use material_voids, only: expand_grains, voids_t
   use material_wishes, only: wishes_t
   implicit none
   private

   public :: chain_t

   !> The models of one material. What is not allocated does not happen and costs nothing.
   type :: chain_t
      character(len=:), allocatable :: name          !! Name that bodies refer to
      real(wp) :: density = 0.0_wp                   !! Of the reference state [kg/m3]
      real(wp) :: bulk = 0.0_wp                      !! Bulk modulus of the reference state [Pa]
      real(wp) :: shear = 0.0_wp                     !! Shear modulus, 0 without strength [Pa]
      class(law_t), allocatable :: law               !! Strength; none: stress is pressure alone
      class(eos_t), allocatable :: eos               !! None: mean stress in rate form
      class(damage_t), allocatable :: damage         !! Lets damage grow
      type(softening_t), allocatable :: softening    !! Cracks open with an energy of their own
      type(viscosity_t), allocatable :: viscosity    !! Artificial viscosity
      type(spall_t), allocatable :: spall            !! Tension cut-off without memory
      type(fracture_t), allocatable :: fracture      !! Failure for good
      type(remains_t), allocatable :: remains        !! Law of failed matter
      type(voids_t), allocatable :: voids            !! Voids open and close
      logical :: repacks = .false.                   !! The fill of nodes corrects volumes
      integer(int64) :: seed = 0                     !! Of random strength
      type(heat_t), allocatable :: heat              !! Temperature follows the work
      real(wp), allocatable :: melting               !! Fluid from this temperature [K]
   contains
      procedure :: wishes => chain_wishes            !! Fields to be carried, and why
      procedure :: request => chain_request          !! Allocates these fields
      procedure :: start => chain_start              !! Initial state of particles
      procedure :: scatter => chain_scatter          !! Random strength of particles
      procedure :: settle => chain_settle            !! Stress of the state as it is
      procedure :: update => chain_update            !! One time step
      procedure :: signal_speed => chain_signal_speed         !! Fastest signal of a state
      procedure :: reference_speed => chain_reference_speed   !! Fastest signal at rest
      procedure :: bulk_in_rate_form => chain_bulk_in_rate_form !! Mean stress follows the volume
      procedure :: stored_energy => chain_stored_energy       !! Internal energy of particles
   end type chain_t

contains

   !> The fields that the chain needs its particles to carry.
   pure function chain_wishes(self) result(wishes)
      class(chain_t), intent(in) :: self             !! The material
      type(wishes_t) :: wishes

      call wishes%ask("mass", "every material", 1)
      call wishes%ask("volume", "every material", 1)
      call wishes%ask("stress", "every material", 6)
      if (allocated(self%viscosity)) call wishes%ask("viscous_pressure", "artificial viscosity", 1)
      if (allocated(self%eos)) call self%eos%request(wishes)
      if (allocated(self%law)) call self%law%request(wishes)
      if (allocated(self%damage)) call self%damage%request(wishes)
      if (allocated(self%voids)) call wishes%ask("solid_fraction", "voids", 1)
      if (allocated(self%heat)) call wishes%ask("temperature", "thermal effect", 1)
      if (allocated(self%fracture)) then
         call wishes%ask("damage", "failure", 1)
         call wishes%ask("failed", "failure", 1)
      end if
   end function chain_wishes

   !> Allocate exactly the fields that the chain needs.
   pure subroutine chain_request(self, matter, particles)
      class(chain_t), intent(in) :: self             !! The material
      type(matter_t), intent(out) :: matter          !! State of its particles
      integer, optional, intent(in) :: particles     !! Room for so many; none if not given
      type(wishes_t) :: wishes
      integer :: n

      n = 0
      if (present(particles)) n = particles
      wishes = self%wishes()
      allocate (matter%mass(n), matter%volume(n), matter%stress(n, 6))
      if (wishes%asked("viscous_pressure")) allocate (matter%viscous_pressure(n))
      if (wishes%asked("energy")) allocate (matter%energy(n))
      if (wishes%asked("temperature")) allocate (matter%temperature(n))
      if (wishes%asked("plastic_strain")) allocate (matter%plastic_strain(n))
      if (wishes%asked("plastic_rate")) allocate (matter%plastic_rate(n))
      if (wishes%asked("plastic_dilation")) allocate (matter%plastic_dilation(n))
      if (wishes%asked("distension")) allocate (matter%distension(n))
      if (wishes%asked("damage")) allocate (matter%damage(n))
      if (wishes%asked("scatter")) allocate (matter%scatter(n))
      if (wishes%asked("bulking")) allocate (matter%bulking(n))
      if (wishes%asked("solid_fraction")) allocate (matter%solid_fraction(n))
      if (wishes%asked("deformation_gradient")) allocate (matter%deformation_gradient(n, 9))
      if (wishes%asked("failed")) allocate (matter%failed(n))
   end subroutine chain_request

   !> Initial state of particles: at rest without stress. Mass and volume are set by the caller.
   pure subroutine chain_start(self, matter, first, last, temperature)
      class(chain_t), intent(in) :: self             !! The material
      type(matter_t), intent(inout) :: matter        !! State of the store
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), intent(in) :: temperature            !! Initial temperature [K]

      matter%stress(first:last, :) = 0.0_wp
      if (allocated(matter%viscous_pressure)) matter%viscous_pressure(first:last) = 0.0_wp
      if (allocated(matter%energy)) matter%energy(first:last) = 0.0_wp
      if (allocated(matter%temperature)) matter%temperature(first:last) = temperature
      if (allocated(matter%plastic_strain)) matter%plastic_strain(first:last) = 0.0_wp
      if (allocated(matter%plastic_rate)) matter%plastic_rate(first:last) = 0.0_wp
      if (allocated(matter%plastic_dilation)) matter%plastic_dilation(first:last) = 0.0_wp
      if (allocated(matter%distension)) matter%distension(first:last) = self%eos%distension
      if (allocated(matter%damage)) matter%damage(first:last) = 0.0_wp
      if (allocated(matter%scatter)) matter%scatter(first:last) = 1.0_wp
      if (allocated(matter%bulking)) matter%bulking(first:last) = 0.0_wp
      if (allocated(matter%solid_fraction)) matter%solid_fraction(first:last) = self%voids%start
      if (allocated(matter%deformation_gradient)) then
         matter%deformation_gradient(first:last, :) = 0.0_wp
         matter%deformation_gradient(first:last, [1, 5, 9]) = 1.0_wp
      end if
      if (allocated(matter%failed)) matter%failed(first:last) = 0
   end subroutine chain_start

   !> Random strength of new particles. Their mass is known, and who they are decides.
   pure subroutine chain_scatter(self, matter, identity, first, last)
      class(chain_t), intent(in) :: self             !! The material
      type(matter_t), intent(inout) :: matter        !! State of the store
      integer(int64), contiguous, intent(in) :: identity(:) !! Of the particles (store)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range

      if (allocated(matter%scatter)) call self%damage%draw(self%seed, identity, first, last, &
         matter%mass, matter%scatter)
   end subroutine chain_scatter

   !> Stress of particles at rest whose volume, energy, deformation gradient or deviator of stress
   !! were set from outside: a step without deformation that takes no time.
   pure subroutine chain_settle(self, matter, first, last)
      class(chain_t), intent(in) :: self             !! The material
      type(matter_t), intent(inout) :: matter        !! State of the store
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      ! Short beside every time of matter, and still a divisor that leaves numbers.
      real(wp), parameter :: instant = 1.0e-100_wp
      type(deformation_t) :: deformation

      if (last < first) return
      call deformation%reserve(last - first + 1)
      deformation%gradient = 0.0_wp
      call self%update(matter, deformation, first, last, instant, 1.0_wp)
   end subroutine chain_settle

   !> True if the mean stress follows the dilatation, without equation of state and without a law
   !! that gives the whole stress.
   pure logical function chain_bulk_in_rate_form(self) result(follows)
      class(chain_t), intent(in) :: self             !! The material

      follows = .not. allocated(self%eos)
      if (follows .and. allocated(self%law)) follows = .not. self%law%whole()
   end function chain_bulk_in_rate_form

   !> Fastest signal [m/s] in the reference state, for the first time step.
   pure real(wp) function chain_reference_speed(self) result(speed)
      class(chain_t), intent(in) :: self             !! The material

      speed = sqrt((self%bulk + 4.0_wp/3.0_wp*self%shear)/self%density)
   end function chain_reference_speed

   !> Fastest signal [m/s] of a range of particles in their present state, for the first time step
   !! of matter that does not start in the reference state.
   pure real(wp) function chain_signal_speed(self, matter, first, last) result(speed)
      class(chain_t), intent(in) :: self             !! The material
      type(matter_t), intent(in) :: matter           !! State of the store
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      type(deformation_t) :: deformation
      type(matter_t) :: squeezed
      integer :: count

      speed = 0.0_wp
      count = last - first + 1
      if (count < 1) return
      call deformation%reserve(count)
      deformation%wave_speed(:count) = 0.0_wp
      if (allocated(self%voids)) then
         squeezed = matter
         deformation%share(:count) = 1.0_wp
         call self%voids%squeeze(squeezed, deformation, first, last)
         call self%eos%update(squeezed, deformation, first, last)
         call self%voids%relax(squeezed, deformation, first, last)
      else if (allocated(self%eos)) then
         call self%eos%update(matter, deformation, first, last)
      else if (self%bulk_in_rate_form()) then
         deformation%wave_speed(:count) = self%bulk*matter%volume(first:last) &
            /matter%mass(first:last)
      end if
      if (allocated(self%law)) call self%law%stiffen(matter, deformation, first, last)
      speed = sqrt(maxval(deformation%wave_speed(:count)))
   end function chain_signal_speed

   !> One time step of a range of particles, with the gradient given and the work of the stress of
   !! the force already in the energy. The order of the chain is that of the calls here.
   pure subroutine chain_update(self, matter, deformation, first, last, dt, spacing)
      class(chain_t), intent(in) :: self                 !! The material
      type(matter_t), intent(inout) :: matter            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first                       !! First particle of the range
      integer, intent(in) :: last                        !! Last particle of the range
      real(wp), intent(in) :: dt                         !! Time step [s]
      real(wp), intent(in) :: spacing                    !! Cell size [m]
      type(share_t) :: share
      integer :: count

      count = last - first + 1
      if (count < 1) return
      if (allocated(self%softening)) call self%softening%recover(matter, first, last)
      if (allocated(self%remains)) &
         call self%remains%collect(matter, deformation, first, last, share)
      if (allocated(self%voids)) call self%voids%choose(matter, deformation, first, last)
      deformation%plastic_work(:count) = 0.0_wp
      deformation%viscous_work(:count) = 0.0_wp
      deformation%plastic_increment(:count) = 0.0_wp
      if (allocated(self%law)) then
         call self%law%predict(matter, deformation, first, last)
      else
         call dilate(first, last, deformation%gradient, matter%volume, deformation%old_volume, &
            deformation%dilatation)
      end if
      if (allocated(self%voids)) call self%voids%open(matter, deformation, first, last)
      call update_pressure(self, matter, deformation, first, last)
      if (allocated(self%remains)) &
         call self%remains%follow(matter, deformation, first, dt, share)
      if (allocated(self%law)) call update_deviator(self, matter, deformation, first, last, dt)
      if (allocated(self%remains)) &
         call self%remains%give_back(share, matter, deformation, first)
      if (allocated(self%softening)) &
         call self%softening%open(matter, deformation, first, last, spacing)
      if (allocated(self%damage)) call self%damage%update(matter, deformation, first, last, dt)
      call limit_tension(self, matter, deformation, first, last)
      if (allocated(self%viscosity)) call viscous_losses(first, last, matter%viscous_pressure, &
         deformation%old_volume, deformation%dilatation, deformation%viscous_work)
      if (allocated(self%heat)) call update_temperature(self, matter, deformation, first, last)
      if (allocated(self%viscosity)) then
         call resist(first, last, self%viscosity, dt, spacing, matter%mass, matter%volume, &
            deformation%dilatation, matter%viscous_pressure, deformation%pressure, &
            deformation%wave_speed)
      else
         call square_root(count, deformation%wave_speed)
      end if
      if (allocated(self%law)) then
         call self%law%damp(matter, deformation, first, last, spacing)
         call assemble(first, last, deformation%pressure, matter%stress)
      else
         call assemble_isotropic(first, last, deformation%pressure, matter%stress)
      end if
      if (.not. allocated(self%fracture)) return
      if (.not. self%fracture%leaves_nothing) return
      call vanish(first, last, matter%failed, matter%stress, deformation%wave_speed)
      if (allocated(self%viscosity)) matter%viscous_pressure(first:last) = &
         merge(0.0_wp, matter%viscous_pressure(first:last), matter%failed(first:last) /= 0)
   end subroutine chain_update

   !> Pressure of the material, and the square of its wave speed without strength.
   pure subroutine update_pressure(self, matter, deformation, first, last)
      class(chain_t), intent(in) :: self                 !! The material
      type(matter_t), intent(inout) :: matter            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first                       !! First particle of the range
      integer, intent(in) :: last                        !! Last particle of the range

      if (allocated(self%voids)) then
         call self%voids%squeeze(matter, deformation, first, last)
         call self%eos%update(matter, deformation, first, last)
         call add_bulking(matter, deformation, first, last)
         call self%voids%relax(matter, deformation, first, last)
      else if (allocated(self%eos)) then
         call self%eos%update(matter, deformation, first, last)
         call add_bulking(matter, deformation, first, last)
         call self%eos%remember(matter, deformation, first, last)
      else if (self%bulk_in_rate_form()) then
         if (allocated(self%viscosity)) deformation%pressure(:last - first + 1) = &
            deformation%pressure(:last - first + 1) - matter%viscous_pressure(first:last)
         call follow_rate(first, last, self%bulk, matter%mass, matter%volume, &
            deformation%dilatation, deformation%pressure, deformation%wave_speed)
      else
         deformation%wave_speed(:last - first + 1) = 0.0_wp
      end if
   end subroutine update_pressure

   !> Add the pressure that fracture made to that of the equation of state, where there is any.
   pure subroutine add_bulking(matter, deformation, first, last)
      type(matter_t), intent(in) :: matter               !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first                       !! First particle of the range
      integer, intent(in) :: last                        !! Last particle of the range

      if (allocated(matter%bulking)) deformation%pressure(:last - first + 1) = &
         deformation%pressure(:last - first + 1) + matter%bulking(first:last)
   end subroutine add_bulking

   !> Deviator of stress, and what strength adds to the square of the wave speed.
   pure subroutine update_deviator(self, matter, deformation, first, last, dt)
      class(chain_t), intent(in) :: self                 !! The material
      type(matter_t), intent(inout) :: matter            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first                       !! First particle of the range
      integer, intent(in) :: last                        !! Last particle of the range
      real(wp), intent(in) :: dt                         !! Time step [s]

      ! Before the law, so that what has no strength does not flow plastically.
      if (drops(self)) call drop_failed(first, last, matter%failed, matter%stress)
      if (allocated(self%melting)) &
         call drop_melted(first, last, self%melting, matter%temperature, matter%stress)
      call self%law%update(matter, deformation, first, last, dt)
      call self%law%stiffen(matter, deformation, first, last)
   end subroutine update_deviator

   !> True if the law of strength must not see failed matter.
   pure logical function drops(self) result(must_not)
      class(chain_t), intent(in) :: self                 !! The material

      must_not = .false.
      if (allocated(self%fracture)) must_not = allocated(self%remains) .or. &
         .not. self%fracture%leaves_strength
   end function drops

   !> Let particles fail.
   pure subroutine break_or_fail(self, matter, deformation, first, last)
      class(chain_t), intent(in) :: self                 !! The material
      type(matter_t), intent(inout) :: matter            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first                       !! First particle of the range
      integer, intent(in) :: last                        !! Last particle of the range

      if (self%fracture%leaves_strength) then
         call fail(first, last, self%fracture%strength, self%bulk, matter%volume, &
            deformation%pressure, deformation%pressure_floor, matter%damage, matter%failed, &
            deformation%plastic_work)
      else
         call break(first, last, self%fracture%strength, self%shear, self%bulk, matter%volume, &
            matter%stress, deformation%pressure, deformation%pressure_floor, matter%damage, &
            matter%failed, deformation%plastic_work)
      end if
   end subroutine break_or_fail

   !> Cut the tension or let particles fail.
   pure subroutine limit_tension(self, matter, deformation, first, last)
      class(chain_t), intent(in) :: self                 !! The material
      type(matter_t), intent(inout) :: matter            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first                       !! First particle of the range
      integer, intent(in) :: last                        !! Last particle of the range

      if (allocated(self%fracture)) then
         call break_or_fail(self, matter, deformation, first, last)
         if (.not. allocated(self%eos)) call open_voids(first, last, self%density, self%bulk, &
            matter%mass, matter%volume, matter%failed, deformation%pressure, &
            deformation%wave_speed)
      else if (allocated(self%spall)) then
         call cut_tension(first, last, self%spall%strength, deformation%pressure, &
            deformation%pressure_floor)
      else if (allocated(self%heat)) then
         deformation%pressure_floor(:last - first + 1) = -huge(1.0_wp)
      end if
      if (allocated(self%melting)) call melt(first, last, self%melting, matter%temperature, &
         deformation%pressure, deformation%pressure_floor)
   end subroutine limit_tension

   !> Temperature after the step.
   pure subroutine update_temperature(self, matter, deformation, first, last)
      class(chain_t), intent(in) :: self                 !! The material
      type(matter_t), intent(inout) :: matter            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first                       !! First particle of the range
      integer, intent(in) :: last                        !! Last particle of the range
      real(wp) :: gamma_density, gamma, share

      gamma_density = 0.0_wp
      gamma = 0.0_wp
      share = 0.9_wp
      if (allocated(self%eos)) then
         gamma_density = self%eos%gamma_density
         gamma = self%eos%constant_gamma
      end if
      if (allocated(self%law)) then
         share = self%law%heat_share
         deformation%pressure_floor(:last - first + 1) = max(self%law%least_pressure(), &
            deformation%pressure_floor(:last - first + 1))
      end if
      ! Nobody needs the homologous temperature any more in this step.
      if (allocated(self%voids)) &
         deformation%homologous(:last - first + 1) = matter%temperature(first:last)
      call heat(first, last, self%heat%specific_heat, gamma_density, gamma, share, matter%mass, &
         matter%volume, deformation%old_volume, deformation%pressure, deformation%pressure_floor, &
         deformation%plastic_work, deformation%viscous_work, matter%temperature)
      if (allocated(self%voids)) call expand_grains(first, last, self%voids%expansion, &
         matter%temperature, deformation%homologous, matter%solid_fraction)
   end subroutine update_temperature

   !> True if nothing is left of a particle that bears stress.
   pure logical function gone(self, matter, particle) result(is_gone)
      class(chain_t), intent(in) :: self             !! The material
      type(matter_t), intent(in) :: matter           !! State of the store
      integer, intent(in) :: particle                !! Which particle

      is_gone = .false.
      if (.not. allocated(self%fracture)) return
      is_gone = self%fracture%leaves_nothing .and. matter%failed(particle) /= 0
   end function gone

   !> Internal energy [J] of particles: the energy they carry, else what is stored elastically.
   pure subroutine chain_stored_energy(self, matter, first, last, energy)
      class(chain_t), intent(in) :: self             !! The material
      type(matter_t), intent(in) :: matter           !! State of the store
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      real(wp), contiguous, intent(inout) :: energy(:) !! (range) [J]
      real(wp) :: limit, pressure, volume
      integer :: i, k

      do i = 1, last - first + 1
         k = first - 1 + i
         if (allocated(matter%energy)) then
            energy(i) = matter%mass(k)*matter%energy(k)
            cycle
         end if
         energy(i) = 0.0_wp
         if (gone(self, matter, k)) cycle
         limit = -huge(1.0_wp)
         if (allocated(self%law)) then
            energy(i) = self%law%stored(matter, k)
            limit = self%law%least_pressure()
         end if
         if (allocated(self%eos)) then
            if (allocated(self%spall)) limit = max(limit, -self%spall%strength)
            if (allocated(matter%failed)) limit = merge(0.0_wp, limit, matter%failed(k) /= 0)
            volume = matter%volume(k)
            if (allocated(matter%solid_fraction)) volume = volume*matter%solid_fraction(k)
            if (allocated(matter%plastic_dilation)) volume = volume*exp(-matter%plastic_dilation(k))
            energy(i) = energy(i) + self%eos%stored(matter%mass(k), volume, limit)
         else if (self%bulk_in_rate_form()) then
            pressure = -sum(matter%stress(k, 1:3))/3.0_wp
            if (allocated(matter%viscous_pressure)) pressure = pressure - matter%viscous_pressure(k)
            energy(i) = energy(i) + matter%volume(k)*pressure**2/(2.0_wp*self%bulk)
         end if
         if (allocated(self%softening)) energy(i) = energy(i) &
            + self%softening%missing(matter, k, .not. allocated(self%eos))
      end do
   end subroutine chain_stored_energy
end module material_chain
