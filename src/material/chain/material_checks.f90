! SPDX-License-Identifier: BSD-3-Clause
!> Checks of combinations of keys of a material: compatible models, the moduli and the effects.
module material_checks
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use material_effects, only: effects_t, in_order
   use material_failed, only: failed_law_fault
   use material_field_requests, only: field_requests_t
   use material_library_text, only: library_fields_text, library_text_t
   use material_models, only: models_t
   use material_softening, only: softening_fault
   use material_voids, only: voids_fault
   implicit none
   private

   public :: check_library, check_material

contains

   !> Report all errors of a material whose models are chosen.
   subroutine check_material(material, group, effects, deck)
      class(models_t), intent(in) :: material        !! With its models, not read yet
      type(group_t), intent(inout) :: group          !! Group &material
      type(effects_t), intent(in) :: effects
      type(deck_t), intent(inout) :: deck

      call check_moduli(material, group, deck)
      call check_failure(material, group, effects, deck)
      call check_packing(material, group, effects, deck)
      call check_models(material, group, effects, deck)
      call check_rate(material, group, deck)
      if (material%has_whole_stress()) then
         call check_whole_stress(material, group, deck)
      else if (effects%thermal) then
         call check_melting(material, group, effects, deck)
      end if
   end subroutine check_material

   !> Check that the moduli are given by exactly one pair of keys, without unused ones.
   subroutine check_moduli(material, group, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(inout) :: group          !! Group &material
      type(deck_t), intent(inout) :: deck
      logical :: young, poisson, bulk, shear, derived, strong

      derived = .false.
      if (allocated(material%eos)) derived = material%eos%sets_bulk()
      if (allocated(material%law)) derived = derived .or. material%law%sets_bulk()
      if (derived) call deck%take_back(group, "bulk")
      young = group%given("young")
      poisson = group%given("poisson")
      bulk = group%given("bulk")
      shear = group%given("shear")
      strong = material%has_shear()
      if ((young .or. poisson) .and. (bulk .or. shear)) then
         call deck%add_error(group, "young/poisson and bulk/shear are both given; keep one "// &
            "pair [D307]")
         return
      end if
      if (young .and. .not. poisson) call deck%add_error(group, &
         "poisson must be set (above -1, below 0.5), as young is given [D302]", "young")
      if (poisson .and. .not. young) call deck%add_error(group, &
         "young must be set [Pa], as poisson is given [D302]", "poisson")
      if (derived .and. bulk) call deck%add_error(group, &
         "bulk is not used, as "//trim(merge("the equation of state", "strength_model       ", &
         allocated(material%eos)))//" gives it; remove it [D349]", "bulk")
      if (shear .and. .not. strong) call deck%add_error(group, &
         "shear is not used by a material without strength; remove it [D349]", "shear")
      if (derived .and. young .and. .not. strong) call deck%add_error(group, &
         "young and poisson are not used by a material without strength; remove them [D349]", &
         "young")
      if (young .or. poisson) return
      if (.not. derived .and. .not. bulk) call deck%add_error(group, &
         "bulk must be set [Pa], or young [Pa] and poisson [D302]")
      if (strong .and. .not. shear) call deck%add_error(group, &
         "shear must be set [Pa], or young [Pa] and poisson [D302]")
   end subroutine check_moduli

   !> Check that models are compatible with each other and with the effects.
   subroutine check_models(material, group, effects, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(in) :: group             !! Group &material
      type(effects_t), intent(in) :: effects
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: fault

      if (effects%voids .and. allocated(material%eos)) then
         fault = voids_fault(group, material%eos, material%law)
         if (len(fault) > 0) call deck%add_error(group, fault)
      end if
      if (.not. allocated(material%law) .and. .not. effects%eos) call deck%add_error(group, &
         "a material without strength needs &effects eos = .true. [D306]")
      if (allocated(material%law)) then
         fault = material%law%fault(group, material%eos)
         if (len(fault) > 0) call deck%add_error(group, fault)
      end if
      if (allocated(material%eos)) then
         fault = material%eos%fault(group)
         if (len(fault) > 0) call deck%add_error(group, fault)
         if (material%is_gas_of_explosive() .and. allocated(material%law)) &
            call deck%add_error(group, "detonation products are a gas without strength; write "// &
            "elastic = 'none' [D320]", "elastic")
      end if
      if (allocated(material%law) .and. .not. effects%eos) then
         if (material%law%needs_eos()) call deck%add_error(group, &
            "this strength_model needs &effects eos = .true. [D306]", "strength_model")
      end if
   end subroutine check_models

   !> Check that some model uses the rate of Johnson and Cook if it is given. The default value is
   !! always accepted, because the echo of a deck gives it for every material.
   subroutine check_rate(material, group, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(in) :: group             !! Group &material
      type(deck_t), intent(inout) :: deck
      real(wp) :: rate
      logical :: used

      if (.not. group%given("jc_rate")) return
      call group%get("jc_rate", rate)
      used = .not. abs(rate - 1.0_wp) > 0.0_wp
      if (allocated(material%law)) used = used .or. material%law%uses_jc_rate()
      if (allocated(material%damage)) used = used .or. material%damage%uses_jc_rate()
      if (.not. used) call deck%add_error(group, &
         "jc_rate is given but no model of Johnson and Cook [D309]", "jc_rate")
   end subroutine check_rate

   !> Check that melting material has a melting temperature.
   subroutine check_melting(material, group, effects, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(in) :: group             !! Group &material
      type(effects_t), intent(in) :: effects
      type(deck_t), intent(inout) :: deck

      if (material%is_gas_of_explosive()) then
         if (group%given("t_melt")) call deck%add_error(group, "t_melt is not used by "// &
            "detonation products, which are a gas; remove it [D320]", "t_melt")
      else if (group%given("t_melt")) then
         if (.not. in_order(group, "t_ref", "t_melt")) &
            call deck%add_error(group, "t_melt must be above t_ref [D308]", "t_melt")
      else if (effects%melting .or. needs_melting(material, group)) then
         call deck%add_error(group, "t_melt must be set [K] [D302]")
      end if
   end subroutine check_melting

   !> Only material without cohesion can get its density from the nodes.
   subroutine check_packing(material, group, effects, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(in) :: group             !! Group &material
      type(effects_t), intent(in) :: effects
      type(deck_t), intent(inout) :: deck
      real(wp) :: cohesion

      if (.not. material%repacks) return
      if (effects%voids) call deck%add_error(group, "&effects voids computes the volumes too; "// &
         "remove volume_from = 'grid' or voids [D350]", "volume_from")
      if (.not. group%given("cohesion")) return
      call group%get("cohesion", cohesion)
      if (cohesion > 0.0_wp) call deck%add_error(group, "volume_from = 'grid' is for grains "// &
         "without cohesion; remove volume_from or cohesion [D317]", "volume_from")
   end subroutine check_packing

   !> Check that the failure model is compatible with the law and the effects.
   subroutine check_failure(material, group, effects, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(inout) :: group          !! &material
      type(effects_t), intent(in) :: effects
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: fault
      logical :: plastic, weibull

      if (.not. effects%damage) return
      plastic = .false.
      if (allocated(material%law)) plastic = material%law%is_plastic()
      weibull = .false.
      if (allocated(material%damage)) then
         weibull = material%damage%needs_weibull(effects%size_scatter)
         fault = material%damage%fault(group, material%law)
         if (len(fault) > 0) call deck%add_error(group, fault, "damage_model")
         if (material%damage%needs_flow() .and. .not. plastic) call deck%add_error(group, &
            "this damage_model uses the plastic strain and needs a strength_model with "// &
            "plastic flow [D351]", &
            "damage_model")
         if (.not. material%has_shear()) call deck%add_error(group, &
            "damage_model needs a material with a shear modulus [D351]", "damage_model")
         fault = softening_fault(group, material%law)
         if (len(fault) > 0) call deck%add_error(group, fault)
      end if
      if (weibull .and. .not. group%given("weibull_m")) &
         call deck%add_error(group, "weibull_m must be given [D301]")
      if (group%given("weibull_m") .and. .not. (effects%size_scatter .or. weibull)) &
         call deck%add_error(group, "weibull_m needs &effects size_scatter = .true. [D306]", &
         "weibull_m")
      call check_fading(material, group, deck)
      fault = failed_law_fault(group, allocated(material%damage) .or. group%given("spall"), &
         material%has_shear())
      if (len(fault) > 0) call deck%add_error(group, fault, "failed_as")
   end subroutine check_failure

   !> Tension that fades needs a strength, and an internal energy that takes up its work.
   subroutine check_fading(material, group, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(inout) :: group          !! &material, changed if a preset gives it
      type(deck_t), intent(inout) :: deck
      logical :: stores

      stores = material%carries_energy()
      if (.not. stores) call deck%take_back(group, "spall_time")
      if (.not. group%given("spall_time")) return
      if (.not. group%given("spall")) call deck%add_error(group, "spall_time needs spall, the "// &
         "tension that fades [D364]", "spall_time")
      if (.not. stores) call deck%add_error(group, "spall_time needs an eos_model with an "// &
         "internal energy, which takes up the work of the tension; remove spall_time, or "// &
         "choose such an eos_model [D364]", "spall_time")
   end subroutine check_fading

   !> A law that gives the whole stress excludes other models.
   subroutine check_whole_stress(material, group, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(in) :: group             !! &material
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: strength

      call group%get("strength_model", strength)
      if (deck%departs(group, "eos_model")) call deck%add_error(group, &
         "eos_model is not used, as strength_model = '"//strength//"' gives the whole stress; "// &
         "remove it [D349]", "eos_model")
      if (allocated(material%damage)) then
         if (material%law%is_plastic() .or. .not. material%damage%needs_flow()) &
            call deck%add_error(group, "damage_model is not used by strength_model = '"// &
            strength//"'; remove it [D349]", "damage_model")
      end if
      if (group%given("spall")) call deck%add_error(group, &
         "spall is not used by strength_model = '"//strength//"'; remove it [D349]", "spall")
      if (group%given("t_melt")) call deck%add_error(group, "t_melt is not used by "// &
         "strength_model = '"//strength//"', which does not melt; remove it [D349]", "t_melt")
   end subroutine check_whole_stress

   !> Check that a law in a library gets what it needs, and that no other model has its fields.
   subroutine check_library(material, group, effects, declared, deck)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects
      type(library_text_t), intent(in) :: declared   !! Declaration of the library
      type(deck_t), intent(inout) :: deck
      type(field_requests_t) :: others
      character(len=:), allocatable :: fields
      integer :: n

      call group%get("library_fields", fields)
      if (.not. group%given("library_fields")) then
         call deck%set_default("material", group%place, "library_fields", &
            library_fields_text(declared))
      else if (fields /= library_fields_text(declared)) then
         call deck%add_error(group, "the fields of the library are '"// &
            library_fields_text(declared)//"', not '"//fields//"'; use the library for which "// &
            "the deck was written, or remove library_fields [D377]", "library_fields")
      end if
      if (declared%needs_temperature .and. .not. effects%thermal) call deck%add_error(group, &
         "the law '"//declared%name//"' of the library needs temperatures; set &effects "// &
         "thermal = .true. [D377]", "library")
      if (allocated(material%eos)) call material%eos%request(others)
      if (allocated(material%damage)) call material%damage%request(others)
      do n = 1, size(declared%fields)
         if (declared%fields(n)%name == "plastic_strain") cycle
         if (others%has(declared%fields(n)%name)) call deck%add_error(group, "field '"// &
            declared%fields(n)%name//"' of the library is also one of eos_model or "// &
            "damage_model; rename that of the library [D377]", "library")
      end do
   end subroutine check_library

   !> True if strength or damage follows the temperature up to melting.
   logical function needs_melting(material, group) result(needed)
      class(models_t), intent(in) :: material        !! Material whose models are chosen
      type(group_t), intent(in) :: group             !! Group &material
      real(wp) :: coefficient(5)

      needed = group%given("jc_m")
      if (.not. allocated(material%damage) .or. group%count("jcd") < 5) return
      call group%get("jcd", coefficient)
      needed = needed .or. abs(coefficient(5)) > 0.0_wp
   end function needs_melting
end module material_checks
