! SPDX-License-Identifier: BSD-3-Clause
!> Switches of &effects that concern materials.
module constitutive_effects
   use base_deck_group, only: group_t
   use base_schema, only: schema_t
   implicit none
   private

   public :: effects_t

   !> The switches. They are used while materials are read only; an effect that is on is an
   !! allocated component of the material afterwards.
   type :: effects_t
      logical :: strength = .true.                   !! Stress has a deviator
      logical :: eos = .true. !! Pressure from an equation of state, else of the bulk modulus
      logical :: damage = .false.                    !! Particles fail permanently
      logical :: size_scatter = .false.              !! Their strength scatters
      logical :: voids = .false.                     !! Volume is more than that of the material
      logical :: thermal = .false.                   !! Temperature follows the work
      logical :: melting = .false.                   !! No strength when melted
      logical :: viscosity = .true.                  !! Artificial viscosity of shocks
      logical :: rate = .true.                       !! Strength depends on the rate
   contains
      procedure, nopass :: declare => effects_declare !! Declares the switches
      procedure :: read => effects_read              !! Reads the switches
   end type effects_t

contains

   !> Declare the switches.
   subroutine effects_declare(schema)
      type(schema_t), intent(inout) :: schema

      call schema%group("effects", "physics switches; a switched-off effect costs nothing and "// &
         "its keys are refused")
      call schema%logical("effects", "strength", "stress has a deviator", default=".true.")
      call schema%logical("effects", "eos", "pressure from an equation of state; else of the "// &
         "elastic moduli, the bulk modulus times the compression, without energy", default=".true.")
      call schema%logical("effects", "damage", "particles fail for good", default=".false.")
      call schema%logical("effects", "size_scatter", "the strength of particles scatters after "// &
         "Weibull and falls with their size", default=".false.", owner="effects.damage")
      call schema%logical("effects", "voids", "voids between grains and fragments open and close", &
         default=".false.", owner="effects.eos")
      call schema%logical("effects", "thermal", "work and compression heat", default=".false.")
      call schema%logical("effects", "melting", "no strength and no tension above t_melt", &
         default=".false.", owner="effects.thermal")
      call schema%logical("effects", "artificial_viscosity", "viscous pressure in shocks", &
         default=".true.")
      call schema%logical("effects", "rate", "strength depends on the rate of strain", &
         default=".true.")
   end subroutine effects_declare

   !> Read the switches.
   pure subroutine effects_read(self, group)
      class(effects_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &effects

      call group%get("strength", self%strength)
      call group%get("eos", self%eos)
      call group%get("damage", self%damage)
      call group%get("size_scatter", self%size_scatter)
      call group%get("voids", self%voids)
      call group%get("thermal", self%thermal)
      call group%get("melting", self%melting)
      call group%get("artificial_viscosity", self%viscosity)
      call group%get("rate", self%rate)
   end subroutine effects_read
end module constitutive_effects
