! SPDX-License-Identifier: BSD-3-Clause
!> Tensile strength that falls while a crack opens, so that the crack dissipates the same energy per
!! area for every cell size: crack bands (Z. P. Bazant, B. H. Oh, Mater. Struct. 16 (1983) 155).
!!
!! A crack opens in a band as wide as a cell, L in the direction of the greatest principal stress.
!! With the elastic strain e of the material without cracks, D e is the opening of cracks
!! over L, and the rest of the stress s without cracks is bounded by
!!
!!    (1 - D) s = f (1 - D e/e_u),        e_u = 2 Gf/(f L)   (linear), or
!!    (1 - D) s = f exp(-D e/e_u),        e_u = Gf/(f L)     (exponential).
!!
!! The integral of f over the opening is Gf for any lateral stress. D never falls, so material
!! unloads to the origin. It weakens the positive principal stresses alone (J. Lemaitre, R.
!! Desmorat, "Engineering Damage Mechanics", 2005, on cracks that close): a closed crack supports
!! pressure.
!!
!! Particles carry the stress reduced by cracks. Division gives the stress without cracks before the
!! trial stress of a step, so that no particle stores a second stress. The law of strength sees the
!! trial reduced by the cracks: its apex would otherwise bound the stress without cracks, and the
!! cracks would never open further. Equations (F.8), (F.9) and (F.10) of doc/theory/failure.md.
module material_softening
   use base_elementary, only: exponential
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use material_brittle, only: bound_deviator
   use material_law, only: law_t
   use material_principal, only: compose, principal
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: crack_damage, cracked, declare_softening, softening_fault, softening_t

   !> Softening of the strength of a material.
   type :: softening_t
      real(wp) :: energy = 0.0_wp                    !! Gf, of a crack per area [J/m2]
      real(wp) :: strength = 0.0_wp                  !! Principal stress that opens cracks [Pa]
      real(wp) :: limit = 0.0_wp !! Principal strain; 0 with a stress criterion [1]
      !> Width of the band that opens across an edge of the grid, set by the scene: one cell if the
      !! gradient of a cell uses its own nodes only, more for smoother gradients [cells]
      real(wp) :: width = 1.0_wp
      logical :: exponential = .false.               !! The curve; else linear
      real(wp) :: shear = 0.0_wp                     !! Shear modulus of the material [Pa]
      real(wp) :: bulk = 0.0_wp                      !! Bulk modulus of the reference state [Pa]
   contains
      procedure :: read => softening_read            !! Reads its keys
      procedure :: band_fault => softening_band_fault !! Error in the cell size
      !> Stress without cracks, before the trial
      procedure :: restore_uncracked_stress => softening_restore_stress
      procedure :: reduce_trial => softening_reduce_trial !! Trial with the cracks before the step
      procedure :: open_cracks => softening_open_cracks !! Opens cracks and reduces the stress
      procedure :: stored_energy => softening_stored_energy !! Elastic energy with open cracks
   end type softening_t

contains

   !> Declare the keys.
   subroutine declare_softening(schema)
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = principal_stress "// &
         "principal_strain"

      call schema%real("material", "fracture_energy", "energy per area of a crack: tensile "// &
         "strength decreases as the crack opens, at a rate that depends on dx; without it "// &
         "strength is lost at once", unit="J/m2", range="> 0", owner=owner)
      call schema%text("material", "softening", &
         "decrease of strength with the opening of a crack that has a fracture_energy", &
         default="linear", words="linear exponential", owner=owner)
      call schema%allow_change("material", "softening", changes_physics)
   end subroutine declare_softening

   !> Read the keys.
   pure subroutine softening_read(self, group, shear, bulk)
      class(softening_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: bulk                   !! Bulk modulus [Pa]
      character(len=:), allocatable :: word

      self%shear = shear
      self%bulk = bulk
      call group%get("fracture_energy", self%energy)
      if (group%given("failure_stress")) call group%get("failure_stress", self%strength)
      if (group%given("failure_strain")) call group%get("failure_strain", self%limit)
      call group%get("softening", word)
      self%exponential = word == "exponential"
   end subroutine softening_read

   !> Error in the combination of the keys; empty if there is none.
   pure function softening_fault(group, law) result(text)
      type(group_t), intent(in) :: group             !! &material
      class(law_t), allocatable, intent(in) :: law   !! Law of strength, if there is one
      character(len=:), allocatable :: text
      character(len=:), allocatable :: word
      real(wp) :: delay

      text = ""
      call group%get("softening", word)
      if (word == "exponential" .and. .not. group%given("fracture_energy")) &
         text = "softening = 'exponential' needs fracture_energy [J/m2] [D364]"
      if (.not. group%given("fracture_energy")) return
      if (allocated(law)) then
         call group%get("strength_model", word)
         if (law%softens_by_damage()) text = "fracture_energy is not used by strength_model = '" &
            //word//"', which has its own softening; remove it [D364]"
      end if
      if (.not. (group%given("failure_delay") .and. group%known("failure_delay"))) return
      call group%get("failure_delay", delay)
      if (delay > 0.0_wp) text = "fracture_energy and failure_delay are both given; keep "// &
         "one: the strength decreases with the crack opening or with time [D441]"
   end function softening_fault

   !> Error in moduli and cell size; empty if none. If the cell is too large, its elastic energy
   !! exceeds the energy that the crack dissipates, so the stress would snap back. The limit is that
   !! of uniaxial stress and cracks in any direction of the scene. Equation (F.11).
   pure function softening_band_fault(self, spacing, dimensions) result(text)
      class(softening_t), intent(in) :: self
      real(wp), intent(in) :: spacing                !! Cell size [m]
      integer, intent(in) :: dimensions              !! Active directions
      character(len=:), allocatable :: text
      real(wp) :: young, strength, greatest

      text = ""
      young = 9.0_wp*self%bulk*self%shear/(3.0_wp*self%bulk + self%shear)
      strength = self%strength
      if (self%limit > 0.0_wp) strength = young*self%limit
      greatest = merge(1.0_wp, 2.0_wp, self%exponential)*young*self%energy/strength**2/self%width
      if (dimensions > 1) greatest = greatest/sqrt(real(dimensions, wp))
      if (spacing <= greatest) return
      text = "cells of "//brief(spacing)//" m are too large for this fracture_energy: a cell "// &
         "that cracks would snap back; dx must be at most "//brief(greatest)//" m [D440]"
   end function softening_band_fault

   !> Damage D of a state. Equation (F.8).
   elemental real(wp) function crack_damage(curved, strength, band_strain, stress, strain) &
      result(damage)
      logical, intent(in) :: curved                  !! Exponential curve; else linear
      real(wp), intent(in) :: strength               !! f [Pa]
      real(wp), intent(in) :: band_strain            !! e_u [1]
      real(wp), intent(in) :: stress                 !! s, without cracks, at least f [Pa]
      real(wp), intent(in) :: strain                 !! e, without cracks, above 0 [1]
      ! Fraction of the strength below which a crack counts as fully open.
      real(wp), parameter :: least = 0.005_wp
      integer, parameter :: most_steps = 50
      real(wp) :: opening, slope, change
      integer :: step

      damage = 1.0_wp
      slope = stress/strain
      if (strength >= slope*band_strain) return
      if (.not. curved) then
         if (strain < band_strain) damage = (stress - strength) &
            /(stress - strength*strain/band_strain)
         return
      end if
      ! The opening is a zero of a concave function that falls there: steps of Newton from above
      ! never pass it.
      opening = strain
      do step = 1, most_steps
         damage = strength*exponential(-opening/band_strain)
         change = (stress - slope*opening - damage)/(damage/band_strain - slope)
         opening = opening - change
         if (abs(change) <= 1.0e-15_wp*strain) exit
      end do
      damage = opening/strain
      if (exponential(-opening/band_strain) < least) damage = 1.0_wp
   end function crack_damage

   !> Stress that material with open cracks would have without them. The viscous pressure is not a
   !! stress of the material and is not changed. The elastic energy and half of the work of the
   !! stress before the step are kept.
   pure subroutine softening_restore_stress(self, state, deformation, first, last)
      class(softening_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state     !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range
      real(wp) :: tensor(6), values(3), axes(3, 3), viscous
      integer :: i, k

      do i = 1, last - first + 1
         k = first - 1 + i
         if (.not. cracked(state%damage(k))) cycle
         viscous = 0.0_wp
         if (allocated(state%viscous_pressure)) viscous = state%viscous_pressure(k)
         tensor(:) = state%stress(k, 1:6)
         tensor(1:3) = tensor(1:3) + viscous
         call principal(tensor, values, axes)
         values = without_cracks(values, state%damage(k))
         deformation%damage%work(i) = state%volume(k)*(elastic_energy(self, values, &
            state%damage(k)) + 0.5_wp*work_density(tensor, deformation, i))
         deformation%damage%mean(i) = sum(values)/3.0_wp
         if (.not. values(1) > 0.0_wp) cycle
         tensor = compose(values, axes)
         tensor(1:3) = tensor(1:3) - viscous
         state%stress(k, :) = tensor
      end do
   end subroutine softening_restore_stress

   !> Principal stress without cracks.
   pure function without_cracks(values, damage) result(whole)
      real(wp), intent(in) :: values(3)              !! Principal stress [Pa]
      real(wp), intent(in) :: damage                 !! Below 1 [1]
      real(wp) :: whole(3)

      whole = merge(values/(1.0_wp - damage), values, values > 0.0_wp)
   end function without_cracks

   !> Principal stress that cracks leave.
   pure function with_cracks(values, damage) result(reduced)
      real(wp), intent(in) :: values(3)              !! Principal stress without cracks [Pa]
      real(wp), intent(in) :: damage                 !! [1]
      real(wp) :: reduced(3)

      reduced = merge((1.0_wp - damage)*values, values, values > 0.0_wp)
   end function with_cracks

   !> Work of a stress in a step, per volume [J/m3].
   pure real(wp) function work_density(stress, deformation, i) result(work)
      real(wp), intent(in) :: stress(6)              !! [Pa]
      type(deformation_t), intent(in) :: deformation !! Step of the range
      integer, intent(in) :: i                       !! Index in the range

      associate (gradient => deformation%gradient)
         work = stress(1)*gradient(i, 1) + stress(2)*gradient(i, 5) + stress(3)*gradient(i, 9) &
            + stress(4)*(gradient(i, 2) + gradient(i, 4)) + stress(5)*(gradient(i, 6) &
            + gradient(i, 8)) + stress(6)*(gradient(i, 3) + gradient(i, 7))
      end associate
   end function work_density

   !> Elastic energy per volume [J/m3] of a state, with the energy of the pressure p**2/2K.
   pure real(wp) function elastic_energy(softening, values, damage) result(energy)
      type(softening_t), intent(in) :: softening
      real(wp), intent(in) :: values(3)              !! Principal stress without cracks [Pa]
      real(wp), intent(in) :: damage                 !! [1]
      real(wp) :: mean

      mean = sum(values)/3.0_wp
      energy = 0.5_wp*sum(with_cracks(values, damage)*(0.5_wp*(values - mean)/softening%shear &
         + mean/(3.0_wp*softening%bulk)))
   end function elastic_energy

   !> Has a particle cracks that can open further?
   elemental logical function cracked(damage) result(yes)
      real(wp), intent(in) :: damage                 !! [1]

      yes = damage > 0.0_wp .and. damage < 1.0_wp
   end function cracked

   !> Reduce the trial deviator and pressure by the cracks that were open before the step.
   pure subroutine softening_reduce_trial(self, state, deformation, first, last)
      class(softening_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state     !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range
      real(wp) :: tensor(6), values(3), axes(3, 3)
      integer :: i, k

      do i = 1, last - first + 1
         k = first - 1 + i
         if (.not. cracked(state%damage(k))) cycle
         tensor(:) = state%stress(k, 1:6)
         call principal(tensor, values, axes)
         values = values - deformation%pressure(i)
         if (values(1) > 0.0_wp) call set_reduced(values, axes, state%damage(k), state%stress, k, &
            deformation%pressure(i))
      end do
   end subroutine softening_reduce_trial

   !> Deviator and pressure of a stress without cracks, reduced by them.
   pure subroutine set_reduced(values, axes, damage, stress, particle, pressure)
      real(wp), intent(in) :: values(3)                  !! Principal stress without cracks [Pa]
      real(wp), intent(in) :: axes(3, 3)                 !! Its directions
      real(wp), intent(in) :: damage                     !! [1]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! Deviator (store, 6) [Pa]
      integer, intent(in) :: particle                    !! Index in the store
      real(wp), intent(out) :: pressure                  !! [Pa]
      real(wp) :: reduced(3), mean

      reduced = with_cracks(values, damage)
      mean = sum(reduced)/3.0_wp
      stress(particle, :) = compose(reduced - mean, axes)
      pressure = -mean
   end subroutine set_reduced

   !> Open cracks and reduce the tension of cracked particles. On entry deviator and pressure have
   !! the cracks before the step, on return those after it. The energy of cracks is recorded as
   !! plastic work.
   pure subroutine softening_open_cracks(self, state, deformation, first, last, spacing)
      class(softening_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state            !! State of the store
      type(deformation_t), intent(inout) :: deformation  !! Step of the range
      integer, intent(in) :: first, last                 !! Particles of the range
      real(wp), intent(in) :: spacing                    !! Cell size [m]
      real(wp) :: greatest, factor
      integer :: i, k
      logical :: before, near

      call bound_deviator(first, last, state%stress, deformation%damage%bound)
      factor = 1.0_wp
      do i = 1, last - first + 1
         k = first - 1 + i
         if (state%damage(k) >= 1.0_wp) cycle
         if (allocated(state%brittle%scatter)) factor = state%brittle%scatter(k)
         greatest = deformation%damage%bound(i)
         if (self%limit > 0.0_wp) then
            near = 0.5_wp*greatest/self%shear - deformation%pressure(i)/(3.0_wp*self%bulk) &
               >= self%limit*factor
         else
            near = greatest - deformation%pressure(i) >= self%strength*factor
         end if
         before = state%damage(k) > 0.0_wp
         if (.not. (near .or. before)) cycle
         call crack(self, factor, spacing, state%volume(k), state%stress, k, &
            deformation%pressure(i), state%damage(k), deformation%plastic_work(i))
         if (before .and. state%damage(k) < 1.0_wp) call find_loss(self, state, deformation, i, k)
      end do
   end subroutine softening_open_cracks

   !> One particle that is near its strength or has cracks. Equations (F.9) and (F.10).
   pure subroutine crack(softening, factor, spacing, volume, stress, particle, pressure, damage, &
      plastic_work)
      type(softening_t), intent(in) :: softening
      real(wp), intent(in) :: factor                     !! Strength factor of the particle [1]
      real(wp), intent(in) :: spacing                    !! Cell size [m]
      real(wp), intent(in) :: volume                     !! [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! Deviator (store, 6) [Pa]
      integer, intent(in) :: particle                    !! Index in the store
      real(wp), intent(inout) :: pressure                !! [Pa]
      real(wp), intent(inout) :: damage                  !! [1]
      real(wp), intent(inout) :: plastic_work            !! Plastic work of the step [J]
      real(wp) :: tensor(6), values(3), axes(3, 3), strain(3), strength, width, grown, mean

      tensor(:) = stress(particle, :)
      call principal(tensor, values, axes)
      values = values - pressure
      if (.not. values(1) > 0.0_wp) return
      values = without_cracks(values, damage)
      mean = sum(values)/3.0_wp
      strain = 0.5_wp*(values - mean)/softening%shear + mean/(3.0_wp*softening%bulk)
      grown = damage
      strength = softening%strength*factor
      if (softening%limit > 0.0_wp) strength = values(1)/max(strain(1), tiny(1.0_wp)) &
         *softening%limit*factor
      if (values(1) > strength .and. strain(1) > 0.0_wp) then
         width = softening%width*spacing*sum(abs(axes(:, 1)))
         grown = max(damage, crack_damage(softening%exponential, strength, &
            merge(1.0_wp, 2.0_wp, softening%exponential)*softening%energy/(strength*width), &
            values(1), strain(1)))
      end if
      plastic_work = plastic_work + (grown - damage)*volume &
         *0.5_wp*sum(max(values, 0.0_wp)*strain)
      damage = grown
      ! The law of failed material sets the stress of failed particles.
      call set_reduced(values, axes, damage, stress, particle, pressure)
   end subroutine crack

   !> Plastic work of a particle with cracks: the work of the mean stress less what is stored. The
   !! stress has no potential where some principal values are tension and others pressure, and the
   !! law of strength knows nothing of cracks. Of a step in compression the part of the pressure
   !! counts neither as work nor as stored: the equation of state stores it, not p**2/2K. Equation
   !! (F.9).
   pure subroutine find_loss(softening, state, deformation, i, particle)
      type(softening_t), intent(in) :: softening
      type(material_state_t), intent(in) :: state          !! State of the store; deviator
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: i                             !! Index in the range
      integer, intent(in) :: particle                      !! Index in the store
      real(wp) :: tensor(6), values(3), axes(3, 3), mean, loss

      tensor(:) = state%stress(particle, 1:6)
      tensor(1:3) = tensor(1:3) - deformation%pressure(i)
      call principal(tensor, values, axes)
      values = without_cracks(values, state%damage(particle))
      loss = 0.5_wp*work_density(tensor, deformation, i) - elastic_energy(softening, values, &
         state%damage(particle))
      mean = sum(values)/3.0_wp
      associate (before => deformation%damage%mean(i), gradient => deformation%gradient)
         if (mean < 0.0_wp .and. before < 0.0_wp) loss = loss + 0.5_wp*((mean**2 - before**2) &
            /softening%bulk - (mean + before)*(gradient(i, 1) + gradient(i, 5) + gradient(i, 9)))
      end associate
      deformation%plastic_work(i) = deformation%damage%work(i) + state%volume(particle)*loss
   end subroutine find_loss

   !> Elastic energy [J] of a particle with open cracks. In tension that of the pressure is p**2/2K,
   !! as the energy of cracks supposes: the difference to the energy of an equation of state is a
   !! small part of that without cracks, but not of the small rest that cracks leave.
   pure real(wp) function softening_stored_energy(self, state, particle, of_volume) result(energy)
      class(softening_t), intent(in) :: self
      type(material_state_t), intent(in) :: state    !! State of the store
      integer, intent(in) :: particle                !! Index in the store
      real(wp), intent(in) :: of_volume              !! Energy of the equation of state [J]
      real(wp) :: tensor(6), values(3), axes(3, 3), mean

      tensor(:) = state%stress(particle, 1:6)
      if (allocated(state%viscous_pressure)) tensor(1:3) = tensor(1:3) &
         + state%viscous_pressure(particle)
      call principal(tensor, values, axes)
      values = without_cracks(values, state%damage(particle))
      mean = sum(values)/3.0_wp
      energy = state%volume(particle)*elastic_energy(self, values, state%damage(particle))
      if (mean < 0.0_wp) energy = energy + of_volume &
         - state%volume(particle)*mean**2/(2.0_wp*self%bulk)
   end function softening_stored_energy
end module material_softening
