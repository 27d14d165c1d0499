! SPDX-License-Identifier: BSD-3-Clause
!> Declares the keys of materials.
module material_keys
   use deck_schema, only: changes_nothing, changes_physics, schema_t
   use material_catalogue, only: choose_damage, choose_eos, choose_law, damage_names, eos_names, &
      law_names
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_eos, only: eos_t
   use material_failed, only: declare_failed_law
   use material_law, only: law_t
   use material_presets, only: aluminium, explosives, glass, grains, metals, stones
   use material_voids, only: declare_voids
   implicit none
   private

   public :: declare_material_keys

contains

   !> Declare all keys of &material, and those of &effects and &method that concern materials.
   subroutine declare_material_keys(schema)
      type(schema_t), intent(inout) :: schema
      type(effects_t) :: effects

      call effects%declare(schema)
      call schema%group("run", "title, dimension and method")
      call schema%integer("run", "seed", "seed of all random numbers", default="12345", &
         range=">= 0")
      call schema%group("method", "numerical method")
      call schema%real("method", "bulk_q1", "linear coefficient of artificial viscosity; "// &
         "default: 0.7 with metals and other condensed material that has an internal energy, "// &
         "0.22 with solids that break and liquids without one, both with a "// &
         "viscosity_limiter, else 0.06", default="0.06", &
         range=">= 0", owner="effects.artificial_viscosity")
      call schema%real("method", "bulk_q2", "quadratic coefficient of artificial viscosity", &
         default="4.0", range=">= 0", owner="effects.artificial_viscosity")
      call schema%group("material", "one material; the prefix of a key gives its model", &
         many=.true.)
      call schema%text("material", "name", "name of the material, for bodies")
      call schema%text("material", "preset", "predefined material; it sets the keys that the "// &
         "deck leaves out (see scree --list materials, scree --explain NAME)", default="none", &
         words="none")
      call schema%preset("material", aluminium)
      call schema%preset("material", metals)
      call schema%preset("material", glass)
      call schema%preset("material", grains)
      call schema%preset("material", stones)
      call schema%preset("material", explosives)
      call schema%real("material", "bulk_q1", "linear coefficient of artificial viscosity in "// &
         "this material, instead of that of &method; default: 0.06 in gases and explosives "// &
         "beside condensed material", range=">= 0", owner="effects.artificial_viscosity")
      call declare_elasticity(schema)
      call declare_heat(schema)
      call declare_models(schema)
      call schema%require("material", "name density")
      call schema%forbid_change("run", "seed", "the random strengths and positions of the "// &
         "particles were drawn with it")
      call schema%allow_change("material", "#", changes_physics)
      ! the keys that a preset sets are compared themselves
      call schema%allow_change("material", "preset", changes_nothing)
      call schema%forbid_change("material", "name + -", "the particles of the checkpoint are "// &
         "stored by material")
      call schema%forbid_change("material", "density", "it gave the particles their masses")
      call schema%forbid_change("material", "elastic eos_model strength_model damage_model "// &
         "volume_from", "it decides which fields the particles of the checkpoint have")
   end subroutine declare_material_keys

   !> Declare density, moduli and the choice of models.
   subroutine declare_elasticity(schema)
      type(schema_t), intent(inout) :: schema

      call schema%real("material", "density", "density rho in the reference state", unit="kg/m3", &
         range="> 0")
      call schema%text("material", "elastic", "elastic deviator of stress; none: a fluid", &
         default="isotropic", words="isotropic none", owner="effects.strength")
      call schema%real("material", "young", "Young's modulus E, with poisson", unit="Pa", &
         range="> 0")
      call schema%real("material", "poisson", "Poisson's ratio nu, with young", range="> -1 < 0.5")
      call schema%explain_range("material", "poisson", "0.5 makes the wave speed infinite, "// &
         "nearly incompressible material has about 0.49 [D334]")
      call schema%real("material", "bulk", "bulk modulus K, with shear, instead of young and "// &
         "poisson", unit="Pa", range="> 0")
      call schema%real("material", "shear", &
         "shear modulus G, with bulk, or alone where the equation of state gives the bulk "// &
         "modulus", unit="Pa", range="> 0", owner="effects.strength & elastic = isotropic")
      call schema%text("material", "eos_model", "equation of state", default="linear", &
         owner="effects.eos")
      call schema%words("material", "eos_model", eos_names)
      call schema%text("material", "strength_model", "strength law", default="elastic", &
         owner="effects.strength & elastic = isotropic")
      call schema%words("material", "strength_model", law_names)
      call schema%text("material", "damage_model", "damage model", default="none", words="none", &
         owner="effects.damage")
      call schema%words("material", "damage_model", damage_names)
      call schema%real("material", "spall", "spall strength: greatest tension; with &effects "// &
         "damage a particle that reaches it fails", unit="Pa", range="> 0")
      call schema%real("material", "spall_time", "time in which the tension of a particle that "// &
         "has reached spall fades while pores grow; default: it fails at once", unit="s", &
         range="> 0", owner="effects.damage")
      call schema%forbid_change("material", "spall_time", "the particles store the share of "// &
         "the strength that has faded")
      call schema%text("material", "volume_from", "volume of loose material: motion, "// &
         "integrated from the velocity gradient; grid, corrected where the nodes have gaps or "// &
         "too many particles", default="motion", words="motion grid", &
         owner="effects.eos & effects.strength & strength_model = drucker_prager mohr_coulomb mu_i")
   end subroutine declare_elasticity

   !> Declare temperatures and the rate common to several models.
   subroutine declare_heat(schema)
      type(schema_t), intent(inout) :: schema

      call schema%real("material", "specific_heat", "specific heat at constant volume", &
         unit="J/(kg K)", range="> 0", owner="effects.thermal")
      call schema%require("material", "specific_heat")
      call schema%real("material", "conductivity", &
         "thermal conductivity; a material without it does not conduct heat", unit="W/(m "// &
         "K)", range="> 0", &
         owner="effects.thermal")
      call schema%real("material", "t_ref", "reference temperature, of full strength", unit="K", &
         default="293.0", range=">= 0", owner="effects.thermal")
      call schema%real("material", "t_melt", "melting temperature", unit="K", range="> 0", &
         owner="effects.thermal")
      call schema%real("material", "jc_rate", &
         "reference strain rate of the Johnson-Cook yield stress and failure strain", unit="1/s", &
         default="1.0", range="> 0", owner="effects.rate")
   end subroutine declare_heat

   !> Declare the keys that belong to the models of the catalogue.
   subroutine declare_models(schema)
      type(schema_t), intent(inout) :: schema
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
end module material_keys
