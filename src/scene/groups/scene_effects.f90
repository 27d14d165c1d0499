! SPDX-License-Identifier: BSD-3-Clause
!> The group &effects: its keys that do not belong to materials, gravity, and the list of effects
!! and models of a simulation with their reasons: named by the deck, or by default.
module scene_effects
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_physics, key_t, kind_logical, kind_real, schema_t
   use io_motion, only: of_gravity
   use scene_dimension, only: axis_names, check_plane
   use scene_motion_table, only: read_motion_table
   use step_body_force, only: update_gravity
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_effects, declare_effects, effects_text, read_effects

   integer, parameter :: models = 4                  !! Keys of &material that choose one
   character(len=20), parameter :: model_names(models) = [character(len=20) :: &
      "strength_model", "eos_model", "damage_model", "conductivity"]

contains

   !> Declare the part of &effects that does not concern materials.
   subroutine declare_effects(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("effects", &
         "physics switches; an effect that is off costs nothing, and its keys are errors")
      call schema%logical("effects", "gravity", &
         "acceleration of all material: gravity_vector, or also gravity_table", default=".false.")
      call schema%real("effects", "gravity_vector(3)", "the acceleration", unit="m/s2", &
         default="0 0 -9.80665", owner="gravity")
      call schema%text("effects", "gravity_table", "file with lines t, gx, gy, gz in the units "// &
         "of the deck, interpolated linearly and added to gravity_vector; path relative to the "// &
         "deck", owner="gravity")
      call schema%real("effects", "damping", "damping rate for finding states at rest: the "// &
         "force on a particle is -rate * mass * velocity; twice the lowest angular frequency "// &
         "of a body brings it to rest fastest", unit="1/s", default="0.0", range=">= 0")
      call schema%logical("effects", "contact", &
         "contact between bodies: each body has its own velocity field", default=".false.")
      call schema%logical("effects", "erosion", "failed particles are removed and recorded", &
         default=".false.", owner="effects.damage")
      call schema%allow_change("effects", "gravity gravity_vector gravity_table damping erosion", &
         changes_physics)
      call schema%forbid_change("effects", "contact", "the particles of the checkpoint are "// &
         "stored by velocity fields")
   end subroutine declare_effects

   !> Check that gravity has no component outside of the directions of the scene.
   subroutine check_effects(deck)
      type(deck_t), intent(inout) :: deck                !! Collects errors

      call check_plane(deck, deck%group("effects"), "gravity_vector")
   end subroutine check_effects

   !> Read erosion and gravity. Collective.
   subroutine read_effects(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation
      type(group_t) :: group
      logical :: acts
      integer :: k

      group = deck%group("effects", 1)
      call group%get("erosion", simulation%scheme%erosion)
      call group%get("damping", simulation%effects%damping)
      ! gravity, if it acts
      call group%get("gravity", acts)
      if (.not. acts) return
      allocate (simulation%effects%gravity(3))
      call group%get("gravity_vector", simulation%effects%gravity)
      where (.not. simulation%space%grid%active) simulation%effects%gravity = 0.0_wp
      if (.not. group%given("gravity_table")) return
      allocate (simulation%effects%shaking)
      simulation%effects%shaking%steady = simulation%effects%gravity
      call read_motion_table(deck, simulation%machine%communicator, group, "gravity_table", &
         of_gravity, &
         "m/s2", simulation%effects%shaking)
      if (.not. allocated(simulation%effects%shaking%speed)) return
      do k = 1, 3
         if (simulation%space%grid%active(k)) cycle
         if (.not. any(abs(simulation%effects%shaking%speed(k, :)) > 0.0_wp)) cycle
         call deck%add_error(group, "gravity_table: the table must be 0 in "//axis_names(k)// &
            ", as the scene does not have this direction [D361]", "gravity_table")
      end do
      call update_gravity(simulation%effects, simulation%clock)
   end subroutine read_effects

   !> The effects that are on, the models of each material and the method, all with their reasons.
   !! Costs are in doc/reference/effects.md; the fields that they add are listed with their bytes
   !! elsewhere.
   function effects_text(schema, deck) result(text)
      type(schema_t), intent(in) :: schema           !! Declares the effects
      type(deck_t), intent(in) :: deck               !! Read and checked
      character(len=:), allocatable :: text, named, usual
      type(group_t) :: group
      integer :: n

      group = deck%group("effects", 1)
      named = effects_on(schema, group, .true.)
      usual = effects_on(schema, group, .false.)
      text = "effects    "
      if (len(named) > 0) text = text//"by the deck: "//named
      if (len(named)*len(usual) > 0) text = text//"; "
      if (len(usual) > 0) text = text//"by default: "//usual
      if (len(named) + len(usual) == 0) text = text//"none"
      text = text//new_line("a")
      do n = 1, deck%count("material")
         text = text//material_line(deck%group("material", n), group)
      end do
      text = text//"           doc/reference/effects.md lists their costs per particle and step"// &
         new_line("a")//method_line(deck)
   end function effects_text

   !> The choices of &method whose defaults follow from the scene.
   function method_line(deck) result(text)
      type(deck_t), intent(in) :: deck               !! Read and checked
      character(len=:), allocatable :: text, word
      character(len=17), parameter :: keys(4) = [character(len=17) :: "transfer", "stress_update", &
         "quadrature", "viscosity_limiter"]
      type(group_t) :: group
      integer :: n

      group = deck%group("run", 1)
      call group%get("method", word)
      text = "method     "//word
      group = deck%group("method", 1)
      do n = 1, size(keys)
         if (.not. group%known(trim(keys(n)))) cycle
         call group%get(trim(keys(n)), word)
         text = text//", "//choice(group, trim(keys(n)), word)
      end do
      text = text//new_line("a")
   end function method_line

   !> A key with its value, and whether this is the default.
   function choice(group, key, word) result(text)
      type(group_t), intent(in) :: group             !! Has the key
      character(len=*), intent(in) :: key, word      !! Key and its value
      character(len=:), allocatable :: text

      text = key//" "//word
      if (.not. group%given(key)) text = text//" (default)"
   end function choice

   !> Names of the effects that are on, in the order of their declaration: either those that the
   !! deck gives, or those that are on by default.
   function effects_on(schema, group, named) result(text)
      type(schema_t), intent(in) :: schema
      type(group_t), intent(in) :: group             !! &effects
      logical, intent(in) :: named                   !! Only effects that the deck gives?
      character(len=:), allocatable :: text
      integer :: n, rule

      text = ""
      rule = schema%find("effects")
      do n = 1, size(schema%groups(rule)%keys)
         associate (key => schema%groups(rule)%keys(n))
            if (.not. group%known(key%name)) cycle
            if (group%given(key%name) .neqv. named) cycle
            if (.not. is_on(key, group)) cycle
            if (len(text) > 0) text = text//", "
            text = text//key%name
         end associate
      end do
   end function effects_on

   !> Is a key of &effects an effect that is on? Switches are effects, and so are numbers that do
   !! not belong to a switch, unless they are 0.
   logical function is_on(key, group) result(on)
      type(key_t), intent(in) :: key                 !! Applies in this deck
      type(group_t), intent(in) :: group             !! &effects
      real(wp) :: rate

      on = .false.
      if (key%kind == kind_logical) call group%get(key%name, on)
      if (key%kind /= kind_real .or. size(key%owners) > 0) return
      call group%get(key%name, rate)
      on = abs(rate) > 0.0_wp
   end function is_on

   !> The models of a material.
   function material_line(group, effects) result(text)
      type(group_t), intent(in) :: group             !! &material
      type(group_t), intent(in) :: effects           !! &effects
      character(len=:), allocatable :: text, word, named
      integer :: n

      call group%get("name", word)
      text = "           "//word//":"
      named = ""
      do n = 1, models
         if (.not. group%known(trim(model_names(n)))) cycle
         if (.not. group%given(trim(model_names(n))) .and. idle(n, group, effects)) cycle
         word = "on"
         if (model_names(n) /= "conductivity") call group%get(trim(model_names(n)), word)
         if (word == "none") cycle
         named = named//" "//choice(group, trim(model_names(n)), word)//","
      end do
      if (len(named) > 0) named = named(:len(named) - 1)
      text = text//named//new_line("a")
   end function material_line

   !> True if a default model has no effect, because its effect is off.
   logical function idle(model, group, effects) result(nothing)
      integer, intent(in) :: model                   !! In `model_names`
      type(group_t), intent(in) :: group             !! &material
      type(group_t), intent(in) :: effects           !! &effects
      character(len=:), allocatable :: word
      logical :: on

      on = .true.
      if (model_names(model) == "strength_model") call effects%get("strength", on)
      if (model_names(model) == "eos_model") call effects%get("eos", on)
      nothing = .not. on
      if (model_names(model) == "strength_model" .and. group%known("elastic")) then
         call group%get("elastic", word)
         nothing = nothing .or. word == "none"
      end if
   end function idle
end module scene_effects
