! SPDX-License-Identifier: BSD-3-Clause
!> Strength of brittle material after Johnson and Holmquist (JH-2), see material_jh2. Damage is
!! that of damage_model = 'jh2'; without it material stays intact. Damaged material supports less
!! tension, T (1
!! - D). Equations (F.12) and (F.13) of doc/theory/failure.md.
module law_jh2
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_jh2, only: jh2_t
   use material_law, only: equivalent_stress, law_t, return_radially, strain_trial
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_jh2_t, strain_rate

   !> Law of Johnson and Holmquist.
   type, extends(law_t) :: law_jh2_t
      type(jh2_t) :: constants                       !! Constants of strength
   contains
      procedure :: declare => law_jh2_declare        !! Declares its keys
      procedure :: fault => law_jh2_fault            !! Checks its constants
      procedure :: read => law_jh2_read              !! Reads its keys
      procedure :: needs_eos => law_jh2_needs_eos    !! Returns true
      procedure :: supports_voids => law_jh2_supports_voids !! Returns false
      procedure :: softens_by_damage => law_jh2_softens_by_damage !! Returns true
      procedure :: request => law_jh2_request        !! Requests the energy field
      procedure :: update => law_jh2_update          !! Radial return
      procedure :: add_wave_speed => law_jh2_add_wave_speed !! Fractured material is stiff too
      procedure :: least_pressure => law_jh2_least_pressure !! That of the tension
   end type law_jh2_t

contains

   !> Declare the keys of the law.
   subroutine law_jh2_declare(self, schema)
      class(law_jh2_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call self%constants%declare(schema)
   end subroutine law_jh2_declare

   !> The Hugoniot elastic limit includes a deviator, so it must exceed the pressure at the limit.
   pure function law_jh2_fault(self, group, eos) result(text)
      class(law_jh2_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text
      real(wp) :: limit, pressure

      text = ""
      if (.not. (group%given("jh2_hel") .and. group%given("jh2_phel"))) return
      call group%get("jh2_hel", limit)
      call group%get("jh2_phel", pressure)
      if (limit <= pressure) text = "jh2_hel must be above jh2_phel"
   end function law_jh2_fault

   !> Read the keys of the law.
   pure subroutine law_jh2_read(self, group, effects)
      class(law_jh2_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects

      call self%constants%read(group, effects)
   end subroutine law_jh2_read

   !> Strength follows a pressure that depends on the density.
   pure logical function law_jh2_needs_eos(self) result(needs)
      class(law_jh2_t), intent(in) :: self

      needs = .true.
   end function law_jh2_needs_eos

   !> Its constants are those of material without pores.
   pure logical function law_jh2_supports_voids(self) result(supports)
      class(law_jh2_t), intent(in) :: self

      supports = .false.
   end function law_jh2_supports_voids

   !> Its strength decreases from intact to fractured with the damage.
   pure logical function law_jh2_softens_by_damage(self) result(softens)
      class(law_jh2_t), intent(in) :: self

      softens = .true.
   end function law_jh2_softens_by_damage

   !> The pressure made by fracture is not a function of the density, so particles carry their
   !! energy.
   pure subroutine law_jh2_request(self, requests)
      class(law_jh2_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "strength model jh2", 1)
   end subroutine law_jh2_request

   !> Return to the yield surface, which does not change in the step.
   pure subroutine law_jh2_update(self, state, deformation, first, last, dt)
      class(law_jh2_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: count

      count = last - first + 1
      if (allocated(state%damage)) then
         deformation%strength%old_damage(:count) = state%damage(first:last)
      else
         deformation%strength%old_damage(:count) = 0.0_wp
      end if
      call strain_trial(first, last, deformation%gradient, state%stress, deformation%plastic_work)
      call equivalent_stress(first, last, state%stress, deformation%plastic_increment)
      call strain_rate(count, deformation%gradient, dt, deformation%strength%strain_rate)
      associate (limit => deformation%strength%tangent, increment => deformation%strength%dilation)
         call bound_tension(last - first + 1, self%constants%tension, &
            deformation%strength%old_damage, deformation%pressure)
         call self%constants%find_strengths(last - first + 1, deformation%pressure, &
            deformation%strength%strain_rate, deformation%strength%old_damage, limit)
         call find_increments(last - first + 1, self%shear, deformation%plastic_increment, limit, &
            increment)
         call return_radially(first, last, self%shear, limit, increment, state%volume, &
            state%stress, deformation%plastic_increment, deformation%plastic_work)
      end associate
   end subroutine law_jh2_update

   !> Equivalent rate of strain, sqrt(2/3 d:d) of its deviator.
   pure subroutine strain_rate(count, gradient, dt, rate)
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), contiguous, intent(in) :: gradient(:, :)  !! dt du_k/dx_l (range, 9) [1]
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: rate(:) !! (range) [1/s]
      real(wp) :: mean
      integer :: i

      do concurrent (i=1:count)
         mean = (gradient(i, 1) + gradient(i, 5) + gradient(i, 9))/3.0_wp
         rate(i) = sqrt(2.0_wp/3.0_wp*((gradient(i, 1) - mean)**2 + (gradient(i, 5) - mean)**2 &
            + (gradient(i, 9) - mean)**2 + 0.5_wp*((gradient(i, 2) + gradient(i, 4))**2 &
            + (gradient(i, 3) + gradient(i, 7))**2 + (gradient(i, 6) + gradient(i, 8))**2)))/dt
      end do
   end subroutine strain_rate

   !> Keep the pressure above the tension that damaged material supports.
   pure subroutine bound_tension(count, tension, damage, pressure)
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), intent(in) :: tension                !! T of intact material [Pa]
      real(wp), contiguous, intent(in) :: damage(:)  !! Before the step (range) [1]
      real(wp), contiguous, intent(inout) :: pressure(:)   !! (range) [Pa]
      integer :: i

      do concurrent (i=1:count)
         pressure(i) = max(pressure(i), -tension*(1.0_wp - damage(i)))
      end do
   end subroutine bound_tension

   !> Increments of plastic strain of a return to known strengths. Equation (Y.2) of
   !! doc/theory/strength.md.
   pure subroutine find_increments(count, shear, trial, limit, increment)
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), contiguous, intent(in) :: trial(:)   !! Equivalent trial stress (range) [Pa]
      real(wp), contiguous, intent(in) :: limit(:)   !! Equivalent stress at yield (range) [Pa]
      real(wp), contiguous, intent(inout) :: increment(:) !! (range) [1]
      real(wp) :: softness
      integer :: i

      softness = 1.0_wp/(3.0_wp*shear)
      do concurrent (i=1:count)
         increment(i) = max(0.0_wp, trial(i) - limit(i))*softness
      end do
   end subroutine find_increments

   !> Add the shear modulus to the square of the wave speed, for intact and fractured material. It
   !! does not increase with the volume, otherwise a cloud of fragments would shorten the time step.
   pure subroutine law_jh2_add_wave_speed(self, state, deformation, first, last)
      class(law_jh2_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%wave_speed(i) = deformation%wave_speed(i) + 4.0_wp/3.0_wp*self%shear &
            *min(state%volume(k)/state%mass(k), 1.0_wp/self%density)
      end do
   end subroutine law_jh2_add_wave_speed

   !> Least pressure that the law supports [Pa].
   pure real(wp) function law_jh2_least_pressure(self) result(pressure)
      class(law_jh2_t), intent(in) :: self

      pressure = -self%constants%tension
   end function law_jh2_least_pressure
end module law_jh2
