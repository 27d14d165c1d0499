! SPDX-License-Identifier: BSD-3-Clause
!> Which effects and models a run has and why: because the deck names them, or by default.
module scene_effects
   use base_deck, only: deck_t, group_t
   implicit none
   private

   public :: effects_text

   integer, parameter :: switches = 9 !! Effects that can be on; `rate` is a part of laws
   character(len=20), parameter :: switch_names(switches) = [character(len=20) :: "strength", &
      "eos", "artificial_viscosity", "gravity", "damage", "size_scatter", "voids", "thermal", &
      "melting"]
   integer, parameter :: models = 4                  !! Keys of &material that choose one
   character(len=20), parameter :: model_names(models) = [character(len=20) :: &
      "strength_model", "eos_model", "damage_model", "conductivity"]

contains

   !> The effects that are on, then the models of each material, all with their reasons. What each
   !! costs stands in the guide; fields that they add are listed with their bytes elsewhere.
   function effects_text(deck) result(text)
      type(deck_t), intent(in) :: deck               !! Read and checked
      character(len=:), allocatable :: text, named, usual
      type(group_t) :: group
      integer :: n

      group = deck%group("effects", 1)
      named = switches_on(group, .true.)
      usual = switches_on(group, .false.)
      text = "effects    "
      if (len(named) > 0) text = text//"by the deck: "//named
      if (len(named)*len(usual) > 0) text = text//"; "
      if (len(usual) > 0) text = text//"by default: "//usual
      if (len(named) + len(usual) == 0) text = text//"none"
      text = text//new_line("a")
      do n = 1, deck%count("material")
         text = text//material_line(deck%group("material", n), group)
      end do
      text = text//"           doc/guide/effects.md tells what each costs a particle and step"// &
         new_line("a")
   end function effects_text

   !> Names of the effects that are on, and that the deck names or does not name.
   function switches_on(group, named) result(text)
      type(group_t), intent(in) :: group             !! &effects
      logical, intent(in) :: named                   !! By the deck?
      character(len=:), allocatable :: text
      logical :: on
      integer :: n

      text = ""
      do n = 1, switches
         if (group%given(trim(switch_names(n))) .neqv. named) cycle
         if (.not. group%known(trim(switch_names(n)))) cycle
         call group%get(trim(switch_names(n)), on)
         if (.not. on) cycle
         if (len(text) > 0) text = text//", "
         text = text//trim(switch_names(n))
      end do
   end function switches_on

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
         named = named//" "//trim(model_names(n))//" "//word
         if (.not. group%given(trim(model_names(n)))) named = named//" (default)"
         named = named//","
      end do
      if (len(named) > 0) named = named(:len(named) - 1)
      text = text//named//new_line("a")
   end function material_line

   !> Has a model that the deck does not name nothing to do, as what it belongs to is off?
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
