! SPDX-License-Identifier: BSD-3-Clause
!> Failed material: rubble without deviator and tension, material without stress, or material with a
!! separate law.
!!
!! The law of failed material is called for the failed particles of a range only. Their state is
!! gathered into contiguous arrays, and a range without failed particles costs only the test of the
!! flags. The stress at failure is the initial stress of that law, which returns it to its yield
!! surface.
module material_failed
   use base_constants, only: pi
   use base_kinds, only: int64, wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use law_drucker_prager, only: law_drucker_prager_t
   use law_granular, only: inverse_key, law_granular_t
   use material_flaws, only: flaws_t
   use material_friction, only: angles_t
   use material_law, only: law_t
   use material_softening, only: softening_t
   use material_state, only: deformation_t, material_state_t
   use material_tension, only: fade_t, fracture_t, remove_failed_deviator, spall_t
   implicit none
   private

   public :: choose_failed_law, declare_failed_law, failed_law_fault, failed_law_t, &
      failed_subset_t, failure_t, keeps_no_stress, remove_failed_stress

   !> The law of failed material.
   type :: failed_law_t
      class(law_t), allocatable :: law
   contains
      procedure :: gather => failed_law_gather          !! Gathers the failed particles of a range
      procedure :: update => failed_law_update          !! Updates them by the law
      procedure :: scatter => failed_law_scatter        !! Scatters them back
   end type failed_law_t

   !> Failure of the particles of a material.
   type :: failure_t
      type(spall_t), allocatable :: spall            !! Limit of tension without failure
      type(fracture_t), allocatable :: fracture      !! Permanent failure
      type(fade_t), allocatable :: fade              !! Tensile strength fades in a time
      type(softening_t), allocatable :: softening    !! Cracks open with an energy of their own
      type(failed_law_t), allocatable :: failed_law  !! Law of failed material
      type(flaws_t) :: flaws                         !! Flaws on which strength depends
   end type failure_t

   !> The failed particles of a range.
   type :: failed_subset_t
      integer :: count = 0                              !! Number of particles
      integer, allocatable :: position(:) !! Positions of failed particles in the range
      real(wp), allocatable :: released(:) !! Work released by the loss of the deviator [J]
      type(material_state_t) :: state                       !! State of the failed particles
      type(deformation_t) :: deformation             !! Deformation of the failed particles
   end type failed_subset_t

contains

   !> Declare the keys.
   subroutine declare_failed_law(schema)
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & failed_as = "

      call schema%text("material", "failed_as", "law of failed material: rubble has neither "// &
         "deviator nor tension, nothing has zero stress, the others follow that strength law; "// &
         "default: rubble, with damage_model = 'jh2' or 'hjc' the strength of its law", &
         words="rubble nothing granular drucker_prager", owner="effects.damage")
      call schema%forbid_change("material", "failed_as", "it decides which fields the "// &
         "particles of the checkpoint have")
      call schema%real("material", "failed_friction_angle", &
         "angle of internal friction of failed material", unit="deg", range="> 0 < 90", &
         owner=owner//"drucker_prager")
      call schema%require("material", "failed_friction_angle")
      call schema%real("material", "failed_tau", &
         "relaxation time of the stress of failed material at rest", unit="s", range="> 0", &
         owner=owner//"granular")
      call schema%real("material", "failed_gamma_c", &
         "strain at which contacts of failed material are lost", range="> 0", owner=owner// &
         "granular")
   end subroutine declare_failed_law

   !> Error in the combination of the keys; empty if there is none.
   pure function failed_law_fault(group, fails, has_shear) result(text)
      type(group_t), intent(in) :: group             !! &material
      logical, intent(in) :: fails                   !! True if its particles can fail
      logical, intent(in) :: has_shear               !! True if it has a shear modulus
      character(len=:), allocatable :: text
      character(len=:), allocatable :: word

      text = ""
      if (.not. group%given("failed_as")) return
      call group%get("failed_as", word)
      if (.not. fails) then
         text = "failed_as is given but the material cannot fail; give damage_model or spall [D362]"
      else if (word == "granular" .and. .not. (group%given("failed_tau") .or. &
         group%given("failed_gamma_c"))) then
         text = "failed_as = 'granular' needs failed_tau [s], failed_gamma_c or both [D362]"
      else if ((word == "granular" .or. word == "drucker_prager") .and. .not. has_shear) then
         text = "failed_as = 'granular' and 'drucker_prager' need a shear modulus [D362]"
      end if
   end function failed_law_fault

   !> True if failed particles keep no stress at all.
   pure logical function keeps_no_stress(group) result(none)
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: word

      call group%get("failed_as", word)
      none = word == "nothing"
   end function keeps_no_stress

   !> Law of failed material; not allocated for rubble and nothing.
   subroutine choose_failed_law(group, shear, bulk, density, failed_law)
      type(group_t), intent(in) :: group             !! &material
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: bulk                   !! Bulk modulus [Pa]
      real(wp), intent(in) :: density                !! Density of the reference state [kg/m3]
      type(failed_law_t), allocatable, intent(out) :: failed_law !! Not allocated: no such law
      type(law_granular_t) :: granular
      type(law_drucker_prager_t) :: frictional
      type(angles_t) :: angles
      character(len=:), allocatable :: word

      call group%get("failed_as", word)
      select case (word)
      case ("granular")
         granular%relaxation_rate = inverse_key(group, "failed_tau")
         granular%inverse_contact_strain = inverse_key(group, "failed_gamma_c")
         allocate (failed_law)
         allocate (failed_law%law, source=granular)
      case ("drucker_prager")
         call group%get("failed_friction_angle", angles%friction)
         angles%friction = angles%friction*pi/180.0_wp
         call frictional%set(angles, "compression")
         allocate (failed_law)
         allocate (failed_law%law, source=frictional)
      case default
         return
      end select
      failed_law%law%shear = shear
      failed_law%law%bulk = bulk
      failed_law%law%density = density
   end subroutine choose_failed_law

   !> Gather the failed particles of a range before the step, and make the elastic trial of their
   !! law.
   pure subroutine failed_law_gather(self, state, deformation, first, last, subset)
      class(failed_law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      type(failed_subset_t), intent(out) :: subset         !! Failed particles
      integer :: i, n, column

      n = int(sum(state%failed(first:last)))
      subset%count = n
      if (n == 0) return
      allocate (subset%position(n), subset%released(n), subset%state%mass(n), &
         subset%state%volume(n), subset%state%stress(n, 6))
      call subset%deformation%reserve(n)
      n = 0
      do i = 1, last - first + 1
         if (state%failed(first - 1 + i) == 0) cycle
         n = n + 1
         subset%position(n) = i
      end do
      subset%state%mass(:) = state%mass(first - 1 + subset%position)
      subset%state%volume(:) = state%volume(first - 1 + subset%position)
      do column = 1, 6
         subset%state%stress(:, column) = state%stress(first - 1 + subset%position, column)
      end do
      do column = 1, 9
         subset%deformation%gradient(:n, column) = deformation%gradient(subset%position, column)
      end do
      call find_release(n, self%law%shear, subset%state%volume, subset%state%stress, &
         subset%deformation%gradient, subset%released)
      call self%law%predict_trial(subset%state, subset%deformation, 1, n)
   end subroutine failed_law_gather

   !> Energy released by a deviator of stress that drops to zero in the step: the stored energy, and
   !! the work of the mean of the old stress and zero. The elastic trial of the step does none.
   pure subroutine find_release(count, shear, volume, stress, gradient, released)
      integer, intent(in) :: count                   !! Particles
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: volume(:)              !! [m3]
      real(wp), intent(in) :: stress(:, :)           !! (particle, 6) Before the step [Pa]
      real(wp), intent(in) :: gradient(:, :)         !! (particle, 9) dt du_k/dx_l [1]
      real(wp), intent(out) :: released(:)           !! [J]
      real(wp) :: s(6), mean, work
      integer :: i, k

      do i = 1, count
         mean = (stress(i, 1) + stress(i, 2) + stress(i, 3))/3.0_wp
         do k = 1, 3
            s(k) = stress(i, k) - mean
            s(k + 3) = stress(i, k + 3)
         end do
         work = s(1)*gradient(i, 1) + s(2)*gradient(i, 5) + s(3)*gradient(i, 9) &
            + s(4)*(gradient(i, 2) + gradient(i, 4)) + s(5)*(gradient(i, 6) + gradient(i, 8)) &
            + s(6)*(gradient(i, 3) + gradient(i, 7))
         released(i) = volume(i)*max(0.0_wp, 0.5_wp*work + 0.25_wp/shear*(s(1)**2 + s(2)**2 &
            + s(3)**2 + 2.0_wp*(s(4)**2 + s(5)**2 + s(6)**2)))
      end do
   end subroutine find_release

   !> Update the failed particles by their law, with volume, pressure and wave speed after the
   !! step.
   pure subroutine failed_law_update(self, state, deformation, first, dt, subset)
      class(failed_law_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      type(failed_subset_t), intent(inout) :: subset       !! Failed particles
      integer :: i

      if (subset%count == 0) return
      do i = 1, subset%count
         subset%state%volume(i) = state%volume(first - 1 + subset%position(i))
         subset%deformation%pressure(i) = max(0.0_wp, deformation%pressure(subset%position(i)))
         subset%deformation%wave_speed(i) = deformation%wave_speed(subset%position(i))
         subset%deformation%plastic_increment(i) = 0.0_wp
         subset%deformation%plastic_work(i) = 0.0_wp
      end do
      call self%law%update(subset%state, subset%deformation, 1, subset%count, dt)
      call remove_loose_deviator(subset%count, subset%released, subset%deformation%pressure, &
         subset%state%stress, subset%deformation%plastic_work)
      call self%law%add_wave_speed(subset%state, subset%deformation, 1, subset%count)
   end subroutine failed_law_update

   !> Failed material that is not pressed has separated and supports no shear. The energy of the
   !! deviator that it had is recorded as plastic work.
   pure subroutine remove_loose_deviator(count, released, pressure, stress, plastic_work)
      integer, intent(in) :: count                   !! Particles
      real(wp), contiguous, intent(in) :: released(:)          !! Energy of the deviator [J]
      real(wp), contiguous, intent(in) :: pressure(:)          !! [Pa]
      real(wp), contiguous, intent(inout) :: stress(:, :)      !! Deviator (:, 6) [Pa]
      real(wp), contiguous, intent(inout) :: plastic_work(:)   !! Plastic work of the step [J]
      integer :: i, column

      do i = 1, count
         if (pressure(i) > 0.0_wp) cycle
         plastic_work(i) = released(i)
         do column = 1, 6
            stress(i, column) = 0.0_wp
         end do
      end do
   end subroutine remove_loose_deviator

   !> Copy the failed particles back to their range.
   pure subroutine failed_law_scatter(self, subset, state, deformation, first)
      class(failed_law_t), intent(in) :: self
      type(failed_subset_t), intent(in) :: subset          !! Failed particles
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer :: i

      do i = 1, subset%count
         state%stress(first - 1 + subset%position(i), :) = subset%state%stress(i, :)
      end do
      do i = 1, subset%count
         deformation%pressure(subset%position(i)) = subset%deformation%pressure(i)
         deformation%wave_speed(subset%position(i)) = subset%deformation%wave_speed(i)
         deformation%plastic_increment(subset%position(i)) = subset%deformation%plastic_increment(i)
         deformation%plastic_work(subset%position(i)) = subset%deformation%plastic_work(i)
      end do
   end subroutine failed_law_scatter

   !> Set the stress of failed particles to zero.
   pure subroutine remove_failed_stress(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call remove_failed_deviator(state, first, last)
      deformation%wave_speed(:last - first + 1) = merge(0.0_wp, &
         deformation%wave_speed(:last - first + 1), state%failed(first:last) /= 0)
      if (allocated(state%viscous_pressure)) state%viscous_pressure(first:last) = &
         merge(0.0_wp, state%viscous_pressure(first:last), state%failed(first:last) /= 0)
   end subroutine remove_failed_stress
end module material_failed
