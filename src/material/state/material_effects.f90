! SPDX-License-Identifier: BSD-3-Clause
!> Switches of &effects that concern materials.
module material_effects
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   implicit none
   private

   public :: effects_t, in_order

   !> The switches. They are used only while materials are read; afterwards an effect that is on is
   !! an allocated component of the material.
   type :: effects_t
      logical :: strength = .true.                   !! Stress has a deviator
      logical :: eos = .true. !! Pressure from an equation of state, else from the bulk modulus
      logical :: damage = .false.                    !! Particles fail permanently
      logical :: size_scatter = .false.              !! Strength of particles scatters
      logical :: voids = .false.                     !! Volume includes voids
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

      call schema%group("effects", &
         "physics switches; an effect that is off costs nothing, and its keys are errors")
      call schema%logical("effects", "strength", &
         "stress has a deviator; .false.: all material is a fluid", default=".true.")
      call schema%logical("effects", "eos", "pressure from an equation of state; .false.: bulk "// &
         "modulus times compression, without energy", default=".true.")
      call schema%logical("effects", "damage", "material damage and failure, without healing", &
         default=".false.")
      call schema%logical("effects", "size_scatter", "Weibull scatter of the strength of "// &
         "particles, with a mean that decreases with their volume", default=".false.", &
         owner="effects.damage")
      call schema%logical("effects", "voids", "voids open and close between grains and fragments", &
         default=".false.", owner="effects.eos")
      call schema%logical("effects", "thermal", "heating by plastic work and compression", &
         default=".false.")
      call schema%logical("effects", "melting", &
         "above t_melt a material has no strength and supports no tension", default=".false.", &
         owner="effects.thermal")
      call schema%logical("effects", "artificial_viscosity", "viscous pressure in shocks", &
         default=".true.")
      call schema%logical("effects", "rate", "strength depends on the strain rate", &
         default=".true.")
      call schema%allow_change("effects", "melting artificial_viscosity rate", changes_physics)
      call schema%forbid_change("effects", "strength eos damage size_scatter voids thermal", &
         "it decides which fields the particles of the checkpoint have")
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

   !> True if the value of a key is below that of another one, or one of them has none. Limits that
   !! may be equal are in order too.
   pure logical function in_order(group, low, high, equal) result(right)
      type(group_t), intent(in) :: group             !! &material
      character(len=*), intent(in) :: low            !! Key of the smaller value
      character(len=*), intent(in) :: high           !! Key of the greater value
      logical, optional, intent(in) :: equal         !! True: they may be equal
      real(wp) :: one, other

      right = .true.
      if (.not. (group%known(low) .and. group%known(high))) return
      call group%get(low, one)
      call group%get(high, other)
      right = one < other .or. (present(equal) .and. .not. other < one)
   end function in_order
end module material_effects
