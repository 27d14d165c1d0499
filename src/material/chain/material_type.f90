! SPDX-License-Identifier: BSD-3-Clause
!> A material of the scene, read from its &material.
module material_type
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   use material_catalogue, only: choose_damage, choose_eos, choose_law
   use material_checks, only: check_library, check_material
   use material_effects, only: effects_t
   use material_failed, only: choose_failed_law, keeps_no_stress
   use material_library, only: library_t
   use material_update, only: chain_t
   implicit none
   private

   public :: material_t

   !> One material: a chain of models that can be read from the deck.
   type, extends(chain_t) :: material_t
   contains
      procedure :: read => material_read             !! Creates it from its &material
   end type material_t

contains

   !> Make a material from its group and check the combination of its keys. The material is complete
   !! only if neither it nor the groups that it depends on have errors.
   subroutine material_read(self, deck, place, table, path, library)
      class(material_t), intent(out) :: self
      type(deck_t), intent(inout) :: deck
      integer, intent(in) :: place                   !! Number among the &material of the deck
      character(len=*), optional, intent(in) :: table !! Text of the file of eos_table, if it is set
      character(len=*), optional, intent(in) :: path !! Name of that file, for messages
      type(library_t), optional, intent(in) :: library !! Library of its law, if it has one
      character(len=14), parameter :: models(5) = [character(len=14) :: "elastic", "eos_model", &
         "strength_model", "damage_model", "preset"]
      character(len=:), allocatable :: fault, doubt
      type(effects_t) :: effects
      type(group_t) :: group

      call effects%read(deck%group("effects"))
      group = deck%group("material", place)
      call group%get("name", self%name)
      ! a misspelt model or preset is reported already; errors in its keys would only follow from it
      if (.not. group%valid(models)) return
      call choose_models(self, group, effects, deck, library)
      if (present(table) .and. allocated(self%eos)) then
         call self%eos%take_file(table, path, group, fault, doubt)
         if (len(doubt) > 0) call deck%warn(group, "eos_table: "//doubt, "eos_table")
         if (len(fault) > 0) call deck%add_error(group, "eos_table: "//fault, "eos_table")
      end if
      call check_material(self, group, effects, deck)
      if (present(library)) call check_library(self, group, effects, library%declared, deck)
      if (.not. (deck%sound("material", place) .and. deck%sound("effects") .and. &
         deck%sound("method") .and. deck%sound("run"))) return
      call group%get("density", self%density)
      call read_moduli(self, group)
      call read_models(self, group, effects)
      call read_failure(self, group, effects, deck%group("run"))
      if (deck%count("detonation") > 0 .and. self%is_gas_of_explosive()) then
         allocate (self%burn)
         call self%burn%read(group, self%eos)
      end if
      if (allocated(self%failure%softening) .and. .not. self%bulk > 0.0_wp) &
         call deck%add_error(group, "fracture_energy needs an eos_model with a bulk modulus at "// &
         "rest; a gas does not crack [D443]", "fracture_energy")
   end subroutine material_read

   !> Allocate the requested models.
   subroutine choose_models(material, group, effects, deck, library)
      class(material_t), intent(inout) :: material
      type(group_t), intent(in) :: group             !! Group &material
      type(effects_t), intent(in) :: effects
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(library_t), optional, intent(in) :: library !! Library of its law, if it has one
      type(text_t), allocatable :: faults(:)
      character(len=:), allocatable :: word
      integer :: n

      call group%get("elastic", word)
      if (effects%strength .and. word == "isotropic") then
         call group%get("strength_model", word)
         call choose_law(word, material%law)
         if (allocated(material%law)) call material%law%read_mode(group)
      end if
      ! before the other models, because the library says whether it gives the whole stress
      if (present(library) .and. allocated(material%law)) then
         call material%law%take_library(library, group, deck%system, faults)
         do n = 1, size(faults)
            call deck%add_error(group, faults(n)%text, "library_constants")
         end do
      end if
      call group%get("eos_model", word)
      if (effects%eos .and. .not. material%has_whole_stress()) call choose_eos(word, material%eos)
      if (allocated(material%law) .and. .not. effects%eos) &
         material%elastic_pressure = material%law%follows_density()
      if (material%elastic_pressure) call choose_eos("linear", material%eos)
      call group%get("volume_from", word)
      material%repacks = word == "grid"
      call group%get("damage_model", word)
      if (effects%damage) call choose_damage(word, material%damage)
   end subroutine choose_models

   !> Bulk and shear modulus from the given keys.
   subroutine read_moduli(material, group)
      class(material_t), intent(inout) :: material
      type(group_t), intent(in) :: group             !! Group &material
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
      if (.not. material%has_shear()) material%shear = 0.0_wp
   end subroutine read_moduli

   !> The models with their constants.
   subroutine read_models(material, group, effects)
      class(material_t), intent(inout) :: material
      type(group_t), intent(in) :: group             !! Group &material
      type(effects_t), intent(in) :: effects

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
         if (material%law%sets_bulk()) material%bulk = material%law%bulk
         ! Material without cohesion and tension is loose from the start.
         if (allocated(material%voids)) &
            material%voids%loose = material%law%least_pressure() >= 0.0_wp
      end if
      if (effects%viscosity) then
         allocate (material%viscosity)
      end if
      if (effects%thermal) then
         allocate (material%heat)
         call group%get("specific_heat", material%heat%specific_heat)
         call group%get("t_ref", material%heat%reference)
         if (group%given("conductivity")) &
            call group%get("conductivity", material%heat%conductivity)
      end if
      if (effects%melting .and. .not. (material%has_whole_stress() .or. &
         material%is_gas_of_explosive())) then
         allocate (material%melting)
         call group%get("t_melt", material%melting)
      end if
   end subroutine read_models

   !> Failure of the material, and its failed state.
   subroutine read_failure(material, group, effects, run_group)
      class(material_t), intent(inout) :: material
      type(group_t), intent(in) :: group             !! Group &material
      type(effects_t), intent(in) :: effects
      type(group_t), intent(in) :: run_group         !! &run
      integer :: seed

      if (allocated(material%damage)) then
         material%damage%shear = material%shear
         material%damage%bulk = material%bulk
         material%damage%density = material%density
         call material%damage%read(group, effects)
         if (group%given("fracture_energy")) then
            allocate (material%failure%softening)
            call material%failure%softening%read(group, material%shear, material%bulk)
         end if
      end if
      call run_group%get("seed", seed)
      material%failure%flaws%seed = int(seed, int64)
      if (group%given("weibull_size")) call group%get("weibull_size", material%failure%flaws%size)
      if (.not. effects%damage) then
         if (.not. group%given("spall")) return
         allocate (material%failure%spall)
         call group%get("spall", material%failure%spall%strength)
         return
      end if
      if (.not. (allocated(material%damage) .or. group%given("spall"))) return
      allocate (material%failure%fracture)
      if (group%given("spall_time")) then
         allocate (material%failure%fade)
         call group%get("spall", material%failure%fade%strength)
         call group%get("spall_time", material%failure%fade%time)
      else if (group%given("spall")) then
         call group%get("spall", material%failure%fracture%strength)
      end if
      call choose_failed_law(group, material%shear, material%bulk, material%density, &
         material%failure%failed_law)
      material%failure%fracture%leaves_nothing = keeps_no_stress(group)
      material%failure%fracture%leaves_strength = allocated(material%failure%failed_law)
      if (allocated(material%damage) .and. .not. group%given("failed_as")) &
         material%failure%fracture%leaves_strength = material%damage%leaves_strength()
   end subroutine read_failure
end module material_type
