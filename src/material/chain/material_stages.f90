! SPDX-License-Identifier: BSD-3-Clause
!> Stages of the material update in their order, and the entry of &effects for each.
module material_stages
   implicit none
   private

   public :: effect_names

   integer, parameter, public :: effect_strength = 1, effect_eos = 2, effect_voids = 3, &
      effect_damage = 4, effect_thermal = 5, effect_viscosity = 6
   integer, parameter, public :: effect_count = 6    !! Effects that are timed one by one
   !> Their names, as in &effects
   character(len=20), parameter :: effect_names(effect_count) = [character(len=20) :: &
      "strength", "eos", "voids", "damage", "thermal", "artificial_viscosity"]

   integer, parameter, public :: &
      stage_restore_stress = 1, &  ! stress without cracks; failed particles gathered for their law
      stage_dilatation = 2, &      ! fraction of the dilatation in material with voids
      stage_trial = 3, &           ! volume after the step and elastic trial of the deviator
      stage_voids = 4, &           ! solid fraction after the step
      stage_pressure = 5, &        ! pressure and sound speed
      stage_failed_law = 6, &      ! law of failed material
      stage_deviator = 7, &        ! law of strength
      stage_failure = 8, &         ! cracks, damage, limits of tension
      stage_viscous_work = 9, &    ! work of the viscous pressure of the step
      stage_temperature = 10, &
      stage_viscosity = 11, &      ! viscous pressure of the next step, wave speed from its square
      stage_stress = 12, &         ! stress from deviator and pressure
      stage_remove_stress = 13     ! failed particles without any stress
   integer, parameter, public :: stage_count = 13    !! Stages of a time step

   !> Effect of a stage
   integer, parameter, public :: effect_of_stage(stage_count) = [effect_damage, effect_voids, &
      effect_strength, effect_voids, effect_eos, effect_damage, effect_strength, effect_damage, &
      effect_viscosity, effect_thermal, effect_viscosity, effect_strength, effect_damage]
end module material_stages
