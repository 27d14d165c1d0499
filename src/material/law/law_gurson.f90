! SPDX-License-Identifier: BSD-3-Clause
!> Ductile metal with pores (A. L. Gurson, J. Eng. Mater. Technol. 99 (1977) 2; V. Tvergaard, Int.
!! J. Fract. 17 (1981) 389; V. Tvergaard, A. Needleman, Acta Metall. 32 (1984) 157).
!!
!! The yield surface of a metal with the porosity f depends on the pressure. Plastic flow opens and
!! closes pores, plastic strain nucleates new ones, and above a critical porosity they coalesce.
!! Equations (D.1) to (D.11) of doc/theory/ductile.md.
module law_gurson
   use base_constants, only: most_lanes, pi
   use base_elementary, only: take_exponentials, take_logarithms
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: effects_t
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_law, only: equivalent_stress, law_t, strain_trial
   use material_porous_flow, only: find_excess, pore_lanes_t, porous_t, solve_flow
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_gurson_t

   !> Excess of the yield function above which a particle flows: tolerance for rounding [1]
   real(wp), parameter :: rounding = 1.0e-13_wp

   !> New pores: their greatest porosity, and the strain at which they appear with its scatter.
   type :: nucleation_t
      real(wp) :: porosity = 0.0_wp                  !! f_N [1]
      real(wp) :: strain = 0.3_wp                    !! e_N [1]
      real(wp) :: scatter = 0.1_wp                   !! s_N [1]
   end type nucleation_t

   !> Law of Gurson, Tvergaard and Needleman.
   type, extends(law_t) :: law_gurson_t
      type(porous_t) :: porous                       !! Yield surface
      type(nucleation_t), allocatable :: nucleation  !! Only if pores appear
      real(wp) :: yield = 0.0_wp !! Yield stress of the matrix without strain [Pa]
   contains
      procedure :: declare => gurson_declare         !! Declares its keys
      procedure :: fault => gurson_fault             !! Keys that do not go together
      procedure :: read => gurson_read               !! Reads its keys
      procedure :: follows_density => gurson_follows_density !! Returns true
      procedure :: supports_voids => gurson_supports_voids !! Returns false
      procedure :: grows_pores => gurson_grows_pores !! Returns true
      procedure :: request => gurson_request         !! Requests porosity, volume gained and strain
      procedure :: update => gurson_update           !! Return to the yield surface
   end type law_gurson_t

contains

   !> Declare the keys of the law; yield and hardening are those of von_mises.
   subroutine gurson_declare(self, schema)
      class(law_gurson_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = gurson"

      call schema%real("material", "gtn_f0", "initial porosity", default="0", range=">= 0 < 0.5", &
         owner=owner)
      call schema%forbid_change("material", "gtn_f0", "the particles store their "// &
         "porosity since the start")
      call schema%real("material", "gtn_q1", "Tvergaard's q1, factor on the porosity", &
         default="1.5", range="> 0 <= 3", owner=owner)
      call schema%real("material", "gtn_q2", "Tvergaard's q2, factor on the pressure", &
         default="1.0", range="> 0 <= 3", owner=owner)
      call schema%real("material", "gtn_fc", &
         "porosity at which voids begin to coalesce, with gtn_ff", range="> 0 < 1", owner=owner)
      call schema%real("material", "gtn_ff", "porosity at which no strength is left; with "// &
         "damage_model = 'porosity' the material fails", range="> 0 < 1", owner=owner)
      call schema%real("material", "gtn_fn", "porosity nucleated by plastic strain in tension", &
         default="0", range=">= 0 < 0.5", owner=owner)
      call schema%real("material", "gtn_en", "mean plastic strain of nucleation", default="0.3", &
         range=">= 0", owner=owner)
      call schema%real("material", "gtn_sn", "standard deviation of the strain of nucleation", &
         default="0.1", range="> 0", owner=owner)
      call schema%real("material", "gtn_least", &
         "least porosity: pores do not close below it, or below gtn_f0 if that is smaller", &
         default="1.0e-6", range=">= 1e-12 < 0.5", owner=owner)
   end subroutine gurson_declare

   !> Error in the combination of the keys; empty if there is none.
   pure function gurson_fault(self, group, eos) result(text)
      class(law_gurson_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), allocatable, intent(in) :: eos   !! Equation of state, if there is one
      character(len=:), allocatable :: text
      real(wp) :: start, critical, final, q1

      text = ""
      if (allocated(eos)) then
         if (eos%has_pores()) text = "strength_model = 'gurson' has pores of its own; choose "// &
            "an eos_model without them [D439]"
      end if
      if (group%given("gtn_fc") .and. .not. group%given("gtn_ff")) text = &
         "gtn_fc needs gtn_ff, the porosity without strength [D439]"
      if (len(text) > 0 .or. .not. (group%known("gtn_f0") .and. group%known("gtn_q1"))) return
      call group%get("gtn_f0", start)
      call group%get("gtn_q1", q1)
      final = 1.0_wp/q1
      critical = final
      if (group%given("gtn_ff")) then
         if (.not. group%known("gtn_ff")) return
         call group%get("gtn_ff", final)
         critical = final
      end if
      if (group%given("gtn_fc")) then
         if (.not. group%known("gtn_fc")) return
         call group%get("gtn_fc", critical)
         if (critical >= min(final, 1.0_wp/q1)) text = &
            "gtn_fc must be below gtn_ff and below 1/gtn_q1 [D439]"
      end if
      if (len(text) == 0 .and. start >= min(critical, 1.0_wp/q1)) text = &
         "gtn_f0 must be below gtn_fc, gtn_ff and 1/gtn_q1, otherwise the material has no "// &
         "strength [D439]"
   end function gurson_fault

   !> Read the keys of the law.
   pure subroutine gurson_read(self, group, effects)
      class(law_gurson_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects
      real(wp) :: final

      call group%get("yield", self%yield)
      call group%get("hardening", self%porous%hardening)
      call group%get("gtn_f0", self%porosity)
      self%porous%shear = self%shear
      call group%get("gtn_q1", self%porous%q1)
      call group%get("gtn_q2", self%porous%q2)
      call group%get("gtn_least", self%porous%least)
      if (group%given("gtn_fc")) then
         call group%get("gtn_fc", self%porous%critical)
         call group%get("gtn_ff", final)
         self%porous%joining = (1.0_wp/self%porous%q1 - self%porous%critical) &
            /(final - self%porous%critical)
      end if
      call group%get("gtn_fn", final)
      if (.not. final > 0.0_wp) return
      allocate (self%nucleation)
      self%nucleation%porosity = final
      call group%get("gtn_en", self%nucleation%strain)
      call group%get("gtn_sn", self%nucleation%scatter)
   end subroutine gurson_read

   !> The pressure is that of the density of the matrix.
   pure logical function gurson_follows_density(self) result(follows)
      class(law_gurson_t), intent(in) :: self

      follows = .true.
   end function gurson_follows_density

   !> Its pores are not those of &effects voids.
   pure logical function gurson_supports_voids(self) result(supports)
      class(law_gurson_t), intent(in) :: self

      supports = .false.
   end function gurson_supports_voids

   !> It has pores that grow.
   pure logical function gurson_grows_pores(self) result(grows)
      class(law_gurson_t), intent(in) :: self

      grows = .true.
   end function gurson_grows_pores

   !> Porosity, the volume that pores gained, and the strain that hardens or nucleates pores.
   pure subroutine gurson_request(self, requests)
      class(law_gurson_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("porosity", "strength model gurson", 1)
      call requests%add("plastic_dilation", "strength model gurson", 1)
      call requests%add("plastic_strain", "strength model gurson", 1)
   end subroutine gurson_request

   !> Return to the yield surface, in groups of particles.
   pure subroutine gurson_update(self, state, deformation, first, last, dt)
      class(law_gurson_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(pore_lanes_t) :: group, lanes
      real(wp) :: excess(most_lanes)
      integer :: offset, count

      call strain_trial(state, deformation, first, last)
      call equivalent_stress(state, deformation, first, last)
      do offset = 0, last - first, most_lanes
         count = min(most_lanes, last - first + 1 - offset)
         call read_group(self, offset, count, first - 1 + offset, state, deformation, group)
         call find_excess(self%porous, count, group, excess)
         call collect(offset, count, group, excess, deformation, lanes)
         if (lanes%count == 0) cycle
         call find_new_pores(self, first - 1 + offset, state, lanes)
         call solve_flow(self%porous, lanes)
         call move_results(self, offset, first - 1 + offset, lanes, state, deformation)
      end do
   end subroutine gurson_update

   !> Trial stresses, porosity and strength of a group.
   pure subroutine read_group(law, offset, count, before, state, deformation, group)
      type(law_gurson_t), intent(in) :: law
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: count                   !! Particles of the group
      integer, intent(in) :: before                  !! Index offset in the store
      type(material_state_t), intent(in) :: state    !! State of the store
      type(deformation_t), intent(in) :: deformation !! Step of the range
      type(pore_lanes_t), intent(inout) :: group
      real(wp), parameter :: softest = 0.1_wp        ! least remaining fraction of the modulus
      real(wp) :: modulus, yield, hardening
      integer :: n

      yield = law%yield
      hardening = law%porous%hardening
      do concurrent (n=1:count)
         modulus = deformation%wave_speed(offset + n)*state%mass(before + n) &
            /state%volume(before + n)
         group%trial(n) = deformation%plastic_increment(offset + n)
         group%trial_pressure(n) = deformation%pressure(offset + n)
         group%bulk(n) = max(modulus - deformation%pressure(offset + n), softest*modulus)
         group%porosity(n) = state%porosity(before + n)
         group%strength(n) = yield + hardening*state%plastic_strain(before + n)
      end do
   end subroutine read_group

   !> Collect the particles of a group that flow. The others have no increments.
   pure subroutine collect(offset, count, group, excess, deformation, lanes)
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: count                   !! Particles of the group
      type(pore_lanes_t), intent(in) :: group
      real(wp), intent(in) :: excess(most_lanes)     !! Over the yield surface [1]
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      type(pore_lanes_t), intent(inout) :: lanes     !! Lanes that flow
      integer :: i, l, n

      lanes%count = 0
      do n = 1, count
         i = offset + n
         deformation%strength%dilation(i) = 0.0_wp
         deformation%plastic_increment(i) = 0.0_wp
         if (excess(n) > rounding) then
            l = lanes%count + 1
            lanes%count = l
            lanes%particle(l) = n
            lanes%trial(l) = group%trial(n)
            lanes%trial_pressure(l) = group%trial_pressure(n)
            lanes%bulk(l) = group%bulk(n)
            lanes%porosity(l) = group%porosity(n)
            lanes%strength(l) = group%strength(n)
         else
            deformation%plastic_work(i) = 0.0_wp
         end if
      end do
   end subroutine collect

   !> Stress, pressure, porosity, strain and work of the particles that flow. The work is that of
   !! the mean of the stresses before and after the step. Equations (D.9) and (D.11).
   pure subroutine move_results(law, offset, before, lanes, state, deformation)
      type(law_gurson_t), intent(in) :: law
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: before                  !! Index offset in the store
      type(pore_lanes_t), intent(inout) :: lanes
      type(material_state_t), intent(inout) :: state !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      real(wp) :: opened(most_lanes), shear_work, pressure
      integer :: component, i, k, l

      do l = 1, lanes%count
         opened(l) = 1.0_wp - lanes%gained(l)
      end do
      call take_logarithms(lanes%count, opened)
      do l = 1, lanes%count
         i = offset + lanes%particle(l)
         k = before + lanes%particle(l)
         associate (scaling => lanes%scaling(l))
            shear_work = (1.0_wp - scaling)*((1.0_wp + scaling)*lanes%trial(l)**2 &
               /(6.0_wp*law%shear) - 0.5_wp*deformation%plastic_work(i))
            pressure = 0.5_wp*(lanes%trial_pressure(l) + (lanes%bulk(l) &
               + lanes%trial_pressure(l))*deformation%dilatation(i) + lanes%pressure(l))
            deformation%plastic_work(i) = max(0.0_wp, 0.5_wp*(state%volume(k) &
               + deformation%old_volume(i))*shear_work - state%volume(k)*pressure*lanes%gained(l))
            do component = 1, 6
               state%stress(k, component) = scaling*state%stress(k, component)
            end do
         end associate
         deformation%pressure(i) = lanes%pressure(l)
         deformation%strength%dilation(i) = lanes%gained(l)
         deformation%plastic_increment(i) = lanes%strain(l)
         state%plastic_strain(k) = state%plastic_strain(k) + lanes%strain(l)
         state%plastic_dilation(k) = state%plastic_dilation(k) - opened(l)
         state%porosity(k) = lanes%porosity(l) + lanes%making_later(l)*lanes%strain(l)
      end do
   end subroutine move_results

   !> Porosity nucleated per unit of strain in tension, at the strain before the step (C. C. Chu, A.
   !! Needleman, J. Eng. Mater. Technol. 102 (1980) 249). Equation (D.10).
   pure subroutine find_new_pores(law, before, state, lanes)
      type(law_gurson_t), intent(in) :: law
      integer, intent(in) :: before                  !! Index offset in the store
      type(material_state_t), intent(in) :: state    !! State of the store
      type(pore_lanes_t), intent(inout) :: lanes
      real(wp) :: distance
      integer :: l

      lanes%making(:lanes%count) = 0.0_wp
      lanes%making_later(:lanes%count) = 0.0_wp
      if (.not. allocated(law%nucleation)) return
      associate (source => law%nucleation)
         do l = 1, lanes%count
            distance = (state%plastic_strain(before + lanes%particle(l)) - source%strain) &
               /source%scatter
            lanes%making(l) = -0.5_wp*distance**2
         end do
         call take_exponentials(lanes%count, lanes%making)
         do l = 1, lanes%count
            lanes%making(l) = merge(source%porosity/(source%scatter*sqrt(2.0_wp*pi)) &
               *lanes%making(l), 0.0_wp, lanes%trial_pressure(l) < 0.0_wp)
            lanes%making_later(l) = merge(lanes%making(l), 0.0_wp, &
               lanes%porosity(l) < law%porous%least)
            lanes%making(l) = lanes%making(l) - lanes%making_later(l)
         end do
      end associate
   end subroutine find_new_pores
end module law_gurson
