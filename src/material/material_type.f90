! SPDX-License-Identifier: BSD-3-Clause
!> A material of the scene, and its keys in the deck.
module material_type
   use base_deck, only: deck_t, group_t
   use base_kinds, only: int64, wp
   use base_schema, only: schema_t
   use constitutive_damage, only: damage_t
   use constitutive_effects, only: effects_t
   use constitutive_eos, only: eos_t
   use constitutive_law, only: law_t
   use constitutive_softening, only: softening_fault
   use material_catalogue, only: choose_damage, choose_eos, choose_law, damage_names, eos_names, &
      law_names
   use material_failed, only: choose_failed_law, declare_failed_law
   use material_presets, only: aluminium, glass, grains, metals
   use material_update, only: chain_t
   use material_voids, only: declare_voids, voids_t
   implicit none
   private

   public :: declare_material_keys, material_t

   !> One material: a chain of models that can be read from the deck.
   type, extends(chain_t) :: material_t
   contains
      procedure :: read => material_read             !! Makes it from its &material
   end type material_t

contains

   !> Declare all keys of &material, and those of &effects and &method that concern materials.
   subroutine declare_material_keys(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      type(effects_t) :: effects

      call effects%declare(schema)
      call schema%group("run", "identity and problem class")
      call schema%integer("run", "seed", "all random numbers derive from it", default="12345", &
         range=">= 0")
      call schema%group("method", "numerical method")
      call schema%real("method", "bulk_q1", "linear coefficient of artificial viscosity", &
         default="0.06", range=">= 0", owner="effects.artificial_viscosity")
      call schema%real("method", "bulk_q2", "quadratic coefficient of artificial viscosity", &
         default="4.0", range=">= 0", owner="effects.artificial_viscosity")
      call schema%group("material", "one material; flat keys, prefix = model", many=.true.)
      call schema%text("material", "name", "what bodies refer to")
      call schema%text("material", "preset", "material of the library; it gives the keys that "// &
         "the deck does not (scree --list materials, scree --explain NAME)", default="none", &
         words="none")
      call schema%preset("material", aluminium)
      call schema%preset("material", metals)
      call schema%preset("material", glass)
      call schema%preset("material", grains)
      call declare_elasticity(schema)
      call declare_heat(schema)
      call declare_models(schema)
      call schema%require("material", "name density")
   end subroutine declare_material_keys

   !> Declare density, moduli and the choice of models.
   subroutine declare_elasticity(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%real("material", "density", "density of the reference state", unit="kg/m3", &
         range="> 0")
      call schema%text("material", "elastic", "none: no deviator of stress, a fluid", &
         default="isotropic", words="isotropic none", owner="effects.strength")
      call schema%real("material", "young", "Young's modulus, with poisson", unit="Pa", range="> 0")
      call schema%real("material", "poisson", "Poisson's ratio, with young", range="> -1 < 0.5")
      call schema%explain_range("material", "poisson", "0.5 makes the wave speed infinite, "// &
         "matter that hardly changes its volume has about 0.49")
      call schema%real("material", "bulk", "bulk modulus, with shear, instead of young and "// &
         "poisson", unit="Pa", range="> 0")
      call schema%real("material", "shear", "shear modulus, with bulk or where the equation of "// &
         "state gives the bulk modulus", unit="Pa", range="> 0", &
         owner="effects.strength & elastic = isotropic")
      call schema%text("material", "eos_model", "equation of state", default="linear", &
         owner="effects.eos")
      call schema%words("material", "eos_model", eos_names)
      call schema%text("material", "strength_model", "law of strength", default="elastic", &
         owner="effects.strength & elastic = isotropic")
      call schema%words("material", "strength_model", law_names)
      call schema%text("material", "damage_model", "how damage grows", default="none", &
         words="none", owner="effects.damage")
      call schema%words("material", "damage_model", damage_names)
      call schema%real("material", "spall", "greatest tension; with &effects damage a particle "// &
         "that reaches it fails", unit="Pa", range="> 0")
      call schema%text("material", "volume_from", "volume of loose matter: motion, that of its "// &
         "motion; grid, corrected where nodes see gaps or too many particles", &
         default="motion", words="motion grid", owner="effects.eos & "// &
         "effects.strength & strength_model = drucker_prager mohr_coulomb mu_i")
   end subroutine declare_elasticity

   !> Declare temperatures and the rate that several models share.
   subroutine declare_heat(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%real("material", "specific_heat", "at constant volume", unit="J/(kg K)", &
         range="> 0", owner="effects.thermal")
      call schema%require("material", "specific_heat")
      call schema%real("material", "conductivity", "of heat, which then flows between points; "// &
         "none without it", unit="W/(m K)", range="> 0", owner="effects.thermal")
      call schema%real("material", "t_ref", "temperature of full strength", unit="K", &
         default="293.0", range=">= 0", owner="effects.thermal")
      call schema%real("material", "t_melt", "temperature of melting", unit="K", range="> 0", &
         owner="effects.thermal")
      call schema%real("material", "jc_rate", "rate of the static yield stress and strain to "// &
         "failure of Johnson and Cook", unit="1/s", default="1.0", range="> 0", &
         owner="effects.rate")
   end subroutine declare_heat

   !> Declare the keys that belong to the models of the catalogue.
   subroutine declare_models(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      class(law_t), allocatable :: law
      class(eos_t), allocatable :: eos
      class(damage_t), allocatable :: damage
      integer :: i

      do i = 1, size(law_names)
         call choose_law(law_names(i), law)
         call law%declare(schema)
      end do
      do i = 1, size(eos_names)
         call choose_eos(eos_names(i), eos)
         call eos%declare(schema)
      end do
      do i = 1, size(damage_names)
         call choose_damage(damage_names(i), damage)
         call damage%declare(schema)
      end do
      call declare_failed_law(schema)
      call declare_voids(schema)
   end subroutine declare_models

   !> Make a material from its group. What the single keys cannot tell is checked here; the material
   !> is complete only if neither it nor what it depends on has errors.
   subroutine material_read(self, deck, place)
      class(material_t), intent(out) :: self         !! The material
      type(deck_t), intent(inout) :: deck            !! The deck, notes what is wrong
      integer, intent(in) :: place                   !! Number among the &material of the deck
      character(len=14), parameter :: models(5) = [character(len=14) :: "elastic", "eos_model", &
         "strength_model", "damage_model", "preset"]
      type(effects_t) :: effects
      type(group_t) :: group
      character(len=:), allocatable :: fault

      call effects%read(deck%group("effects"))
      group = deck%group("material", place)
      call group%get("name", self%name)
      ! a misspelt model or preset is reported already; its keys would only be follow-up errors
      if (.not. group%valid(models)) return
      call choose_models(self, group, effects)
      call check_moduli(self, group, deck)
      call check_models(self, group, effects, deck)
      if (.not. (deck%sound("material", place) .and. deck%sound("effects") .and. &
         deck%sound("method") .and. deck%sound("run"))) return
      call group%get("density", self%density)
      call read_moduli(self, group)
      call read_models(self, group, effects, deck%group("method"))
      call read_failure(self, group, effects, deck%group("run"), deck%group("method"))
      if (.not. (allocated(self%softening) .and. deck%sound("grid"))) return
      fault = self%softening%band_fault(deck%group("run"), deck%group("grid"))
      if (len(fault) > 0) call deck%complain(group, fault, "fracture_energy")
   end subroutine material_read

   !> Allocate the models that are asked for.
   subroutine choose_models(material, group, effects)
      class(material_t), intent(inout) :: material   !! The material
      type(group_t), intent(in) :: group             !! Its &material
      type(effects_t), intent(in) :: effects         !! What is asked for
      character(len=:), allocatable :: word

      call group%get("elastic", word)
      if (effects%strength .and. word == "isotropic") then
         call group%get("strength_model", word)
         call choose_law(word, material%law)
         if (allocated(material%law)) call material%law%select(group)
      end if
      call group%get("eos_model", word)
      if (effects%eos .and. .not. gives_integer(material)) call choose_eos(word, material%eos)
      if (allocated(material%law) .and. .not. effects%eos) &
         material%elastic_pressure = material%law%follows_density()
      if (material%elastic_pressure) call choose_eos("linear", material%eos)
      call group%get("volume_from", word)
      material%repacks = word == "grid"
      call group%get("damage_model", word)
      if (effects%damage) call choose_damage(word, material%damage)
   end subroutine choose_models

   !> True if the law gives the whole stress.
   pure logical function gives_integer(material) result(whole)
      class(material_t), intent(in) :: material      !! The material with its law chosen

      whole = .false.
      if (allocated(material%law)) whole = material%law%whole()
   end function gives_integer

   !> True if the material has a shear modulus.
   pure logical function has_shear(material) result(has)
      class(material_t), intent(in) :: material      !! The material with its law chosen

      has = .false.
      if (allocated(material%law)) has = material%law%has_shear()
   end function has_shear

   !> Exactly one way to give the moduli, and nothing that is not used.
   subroutine check_moduli(material, group, deck)
      class(material_t), intent(in) :: material      !! The material with its models chosen
      type(group_t), intent(in) :: group             !! Its &material
      type(deck_t), intent(inout) :: deck            !! Notes what is wrong
      logical :: young, poisson, bulk, shear, derived, strong

      young = group%given("young")
      poisson = group%given("poisson")
      bulk = group%given("bulk")
      shear = group%given("shear")
      strong = has_shear(material)
      derived = .false.
      if (allocated(material%eos)) derived = material%eos%sets_bulk()
      if ((young .or. poisson) .and. (bulk .or. shear)) then
         call deck%complain(group, "young/poisson and bulk/shear are both given; keep one pair")
         return
      end if
      if (young .and. .not. poisson) call deck%complain(group, &
         "poisson must be set (above -1, below 0.5), as young is given", "young")
      if (poisson .and. .not. young) call deck%complain(group, &
         "young must be set [Pa], as poisson is given", "poisson")
      if (derived .and. bulk) call deck%complain(group, &
         "bulk is not used, as the equation of state gives it; remove it", "bulk")
      if (shear .and. .not. strong) call deck%complain(group, &
         "shear is not used by a material without strength; remove it", "shear")
      if (derived .and. young .and. .not. strong) call deck%complain(group, &
         "young and poisson are not used by a material without strength; remove them", "young")
      if (young .or. poisson) return
      if (.not. derived .and. .not. bulk) call deck%complain(group, &
         "bulk must be set [Pa], or young [Pa] and poisson")
      if (strong .and. .not. shear) call deck%complain(group, &
         "shear must be set [Pa], or young [Pa] and poisson")
   end subroutine check_moduli

   !> Models that fit each other and the effects.
   subroutine check_models(material, group, effects, deck)
      class(material_t), intent(in) :: material      !! The material with its models chosen
      type(group_t), intent(in) :: group             !! Its &material
      type(effects_t), intent(in) :: effects         !! What is asked for
      type(deck_t), intent(inout) :: deck            !! Notes what is wrong
      character(len=:), allocatable :: strength, damage, fault
      type(voids_t) :: no_voids
      real(wp) :: rate, reference, melting
      logical :: plastic

      plastic = .false.
      if (allocated(material%law)) plastic = material%law%plastic()
      call check_failure(material, group, effects, plastic, deck)
      call check_packing(material, group, effects, deck)
      if (effects%voids .and. allocated(material%eos)) then
         fault = no_voids%fault(group)
         if (len(fault) > 0) call deck%complain(group, fault)
      end if
      if (.not. allocated(material%law) .and. .not. effects%eos) call deck%complain(group, &
         "a material without strength needs &effects eos = .true.")
      if (allocated(material%law)) then
         fault = material%law%fault(group)
         if (len(fault) > 0) call deck%complain(group, fault)
      end if
      if (allocated(material%eos)) then
         fault = material%eos%fault(group)
         if (len(fault) > 0) call deck%complain(group, fault)
      end if
      if (allocated(material%law) .and. .not. effects%eos) then
         if (material%law%needs_eos()) call deck%complain(group, &
            "this strength_model needs &effects eos = .true.", "strength_model")
      end if
      call group%get("strength_model", strength)
      call group%get("damage_model", damage)
      ! The default itself is let pass, as the echo of a deck holds it for every material.
      call group%get("jc_rate", rate)
      if (group%given("jc_rate") .and. abs(rate - 1.0_wp) > 0.0_wp .and. &
         strength /= "johnson_cook" .and. damage /= "johnson_cook") &
         call deck%complain(group, "jc_rate is given but no model of Johnson and Cook", "jc_rate")
      if (gives_integer(material)) then
         call check_integer(material, group, deck)
         return
      end if
      if (.not. effects%thermal) return
      if (group%given("t_melt")) then
         if (.not. (group%known("t_melt") .and. group%known("t_ref"))) return
         call group%get("t_melt", melting)
         call group%get("t_ref", reference)
         if (melting <= reference) &
            call deck%complain(group, "t_melt must be above t_ref", "t_melt")
      else if (effects%melting .or. needs_melting(material, group)) then
         call deck%complain(group, "t_melt must be set [K]")
      end if
   end subroutine check_models

   !> Only grains that nothing holds together can be as dense as the nodes find them.
   subroutine check_packing(material, group, effects, deck)
      class(material_t), intent(in) :: material      !! The material with its models chosen
      type(group_t), intent(in) :: group             !! Its &material
      type(effects_t), intent(in) :: effects         !! What is asked for
      type(deck_t), intent(inout) :: deck            !! Notes what is wrong
      real(wp) :: cohesion

      if (.not. material%repacks) return
      if (effects%voids) call deck%complain(group, "&effects voids has volumes of its own; "// &
         "remove volume_from = 'grid' or voids", "volume_from")
      if (.not. group%given("cohesion")) return
      call group%get("cohesion", cohesion)
      if (cohesion > 0.0_wp) call deck%complain(group, "volume_from = 'grid' is for grains "// &
         "without cohesion; remove one of both", "volume_from")
   end subroutine check_packing

   !> Failure that fits the law and the effects.
   subroutine check_failure(material, group, effects, plastic, deck)
      class(material_t), intent(in) :: material      !! The material with its models chosen
      type(group_t), intent(in) :: group             !! &material
      type(effects_t), intent(in) :: effects         !! What is asked for
      logical, intent(in) :: plastic                 !! The law flows
      type(deck_t), intent(inout) :: deck            !! Notes what is wrong
      character(len=:), allocatable :: fault, word
      logical :: scatters

      scatters = .false.
      if (allocated(material%damage)) then
         scatters = material%damage%takes_scatter()
         fault = material%damage%fault(group)
         if (len(fault) > 0) call deck%complain(group, fault, "damage_model")
         if (material%damage%needs_flow() .and. .not. plastic) call deck%complain(group, &
            "this damage_model counts plastic strain and needs a strength_model that flows", &
            "damage_model")
         if (.not. has_shear(material)) call deck%complain(group, &
            "damage_model needs a material with a shear modulus", "damage_model")
      end if
      call group%get("damage_model", word)
      if ((effects%size_scatter .and. scatters .or. word == "grady_kipp") .and. &
         .not. group%given("weibull_m")) call deck%complain(group, "weibull_m must be given")
      if (group%given("weibull_m") .and. effects%damage .and. &
         .not. (effects%size_scatter .or. word == "grady_kipp")) &
         call deck%complain(group, "weibull_m needs &effects size_scatter = .true.", "weibull_m")
      fault = softening_fault(group)
      if (len(fault) > 0 .and. allocated(material%damage)) call deck%complain(group, fault)
      if (.not. (group%given("failed_as") .and. effects%damage)) return
      if (.not. (allocated(material%damage) .or. group%given("spall"))) call deck%complain(group, &
         "failed_as is given but nothing fails; give damage_model or spall", "failed_as")
      call group%get("failed_as", word)
      if (word == "granular" .and. .not. (group%given("failed_tau") .or. &
         group%given("failed_gamma_c"))) call deck%complain(group, &
         "failed_as = 'granular' needs failed_tau [s], failed_gamma_c or both", "failed_as")
      if ((word == "granular" .or. word == "drucker_prager") .and. .not. has_shear(material)) &
         call deck%complain(group, "failed matter with a law of its own needs a shear modulus", &
         "failed_as")
   end subroutine check_failure

   !> A law that gives the whole stress stands alone.
   subroutine check_integer(material, group, deck)
      class(material_t), intent(in) :: material      !! The material with its models chosen
      type(group_t), intent(in) :: group             !! &material
      type(deck_t), intent(inout) :: deck            !! Notes what is wrong
      character(len=:), allocatable :: strength, eos

      call group%get("strength_model", strength)
      call group%get("eos_model", eos)
      ! The default itself is let pass, as the echo of a deck holds it for every material.
      if (group%given("eos_model") .and. eos /= "linear") call deck%complain(group, &
         "eos_model is not used, as strength_model = '"//strength//"' gives the whole stress; "// &
         "remove it", "eos_model")
      if (allocated(material%damage)) then
         if (material%law%plastic() .or. .not. material%damage%needs_flow()) &
            call deck%complain(group, "damage_model is not used by strength_model = '"// &
            strength//"'; remove it", "damage_model")
      end if
      if (group%given("spall")) call deck%complain(group, &
         "spall is not used by strength_model = '"//strength//"'; remove it", "spall")
      if (group%given("t_melt")) call deck%complain(group, "t_melt is not used by "// &
         "strength_model = '"//strength//"', which does not melt; remove it", "t_melt")
   end subroutine check_integer

   !> True if strength or damage follows the temperature up to melting.
   logical function needs_melting(material, group) result(needed)
      class(material_t), intent(in) :: material      !! The material with its models chosen
      type(group_t), intent(in) :: group             !! Its &material
      real(wp) :: coefficient(5)

      needed = group%given("jc_m")
      if (.not. allocated(material%damage) .or. group%count("jcd") < 5) return
      call group%get("jcd", coefficient)
      needed = needed .or. abs(coefficient(5)) > 0.0_wp
   end function needs_melting

   !> Bulk and shear modulus from what is given.
   subroutine read_moduli(material, group)
      class(material_t), intent(inout) :: material   !! The material
      type(group_t), intent(in) :: group             !! Its &material
      real(wp) :: young, poisson

      if (group%given("young")) then
         call group%get("young", young)
         call group%get("poisson", poisson)
         material%bulk = young/(3.0_wp*(1.0_wp - 2.0_wp*poisson))
         material%shear = young/(2.0_wp*(1.0_wp + poisson))
      else
         if (group%given("bulk")) call group%get("bulk", material%bulk)
         if (group%given("shear")) call group%get("shear", material%shear)
      end if
      if (.not. has_shear(material)) material%shear = 0.0_wp
   end subroutine read_moduli

   !> The models with their constants.
   subroutine read_models(material, group, effects, method_group)
      class(material_t), intent(inout) :: material   !! The material
      type(group_t), intent(in) :: group             !! Its &material
      type(effects_t), intent(in) :: effects         !! What is asked for
      type(group_t), intent(in) :: method_group      !! &method

      if (effects%voids .and. allocated(material%eos)) then
         allocate (material%voids)
         call material%voids%read(group)
      end if
      if (allocated(material%eos)) then
         material%eos%density = material%density
         if (allocated(material%voids)) &
            material%eos%density = material%density/material%voids%start
         material%eos%bulk = material%bulk
         call material%eos%read(group)
         material%bulk = material%eos%bulk
      end if
      if (allocated(material%law)) then
         material%law%shear = material%shear
         material%law%bulk = material%bulk
         material%law%density = material%density
         call material%law%read(group, effects)
         ! What has neither cohesion nor tension is loose from the start.
         if (allocated(material%voids)) &
            material%voids%loose = material%law%least_pressure() >= 0.0_wp
      end if
      if (effects%viscosity) then
         allocate (material%viscosity)
         call method_group%get("bulk_q1", material%viscosity%linear)
         call method_group%get("bulk_q2", material%viscosity%quadratic)
      end if
      if (effects%thermal) then
         allocate (material%heat)
         call group%get("specific_heat", material%heat%specific_heat)
         if (group%given("conductivity")) &
            call group%get("conductivity", material%heat%conductivity)
      end if
      if (effects%melting .and. .not. gives_integer(material)) then
         allocate (material%melting)
         call group%get("t_melt", material%melting)
      end if
   end subroutine read_models

   !> How the material fails, and what is left then.
   subroutine read_failure(material, group, effects, run_group, method_group)
      class(material_t), intent(inout) :: material   !! The material
      type(group_t), intent(in) :: group             !! Its &material
      type(effects_t), intent(in) :: effects         !! What is asked for
      type(group_t), intent(in) :: run_group         !! &run
      type(group_t), intent(in) :: method_group      !! &method
      character(len=:), allocatable :: word
      integer :: seed

      if (allocated(material%damage)) then
         material%damage%shear = material%shear
         material%damage%bulk = material%bulk
         material%damage%density = material%density
         call material%damage%read(group, effects)
         if (group%given("fracture_energy")) then
            allocate (material%softening)
            call material%softening%read(group, run_group, method_group, material%shear, &
               material%bulk)
         end if
      end if
      call run_group%get("seed", seed)
      material%seed = int(seed, int64)
      if (.not. effects%damage) then
         if (.not. group%given("spall")) return
         allocate (material%spall)
         call group%get("spall", material%spall%strength)
         return
      end if
      if (.not. (allocated(material%damage) .or. group%given("spall"))) return
      allocate (material%fracture)
      if (group%given("spall")) call group%get("spall", material%fracture%strength)
      call group%get("failed_as", word)
      call choose_failed_law(group, material%shear, material%bulk, material%density, &
         material%remains)
      material%fracture%leaves_nothing = word == "nothing"
      material%fracture%leaves_strength = allocated(material%remains)
      if (allocated(material%damage) .and. .not. group%given("failed_as")) &
         material%fracture%leaves_strength = material%damage%leaves_strength()
   end subroutine read_failure
end module material_type
