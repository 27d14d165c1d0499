! SPDX-License-Identifier: BSD-3-Clause
!> Abstract equation of state: pressure and sound speed from density and energy. Equations (E.1)
!! and (E.2) of doc/theory/equations_of_state.md.
module material_eos
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_t, take_gruneisen

   !> An equation of state. A material has none if its mean stress follows a rate equation.
   type, abstract :: eos_t
      real(wp) :: density = 0.0_wp                   !! Density of the reference state [kg/m3]
      real(wp) :: distension = 1.0_wp !! Initial distension, solid density over density [1]
      real(wp) :: bulk = 0.0_wp                      !! Bulk modulus of the reference state [Pa]
   contains
      procedure :: declare => eos_declare            !! Declares its keys, if it has any
      procedure :: fault => eos_fault                !! Error in the combination of its keys
      procedure :: take_file => eos_take_file        !! Receives the text of its file, if any
      procedure :: read => eos_read                  !! Reads its keys, if it has any
      procedure :: sets_bulk => eos_sets_bulk        !! True if its keys give the bulk modulus
      procedure :: has_pores => eos_has_pores        !! True if its material is porous
      procedure :: request => eos_request            !! Requests the fields it needs
      procedure :: keep_state => eos_keep_state      !! Stores the changes of its state
      procedure(update_i), deferred :: update        !! Pressure and square of the sound speed
      procedure :: find_gruneisen => eos_find_gruneisen !! Grueneisen number times density
      procedure :: stored_energy => eos_stored_energy !! Energy stored in the change of volume
      procedure :: gives_temperature => eos_gives_temperature !! True if it gives the temperature
      procedure :: find_temperature => eos_find_temperature !! Temperature, if it gives it
      !> True if material at rest has energy
      procedure :: starts_with_energy => eos_starts_with_energy
      procedure :: cold_temperature => eos_cold_temperature !! Of the energy of the start
      procedure :: start_energy => eos_start_energy  !! Energy of the reference state
      procedure :: report => eos_report              !! Note for the user
      procedure :: fault_of_state => eos_fault_of_state !! Why a state has no pressure
      procedure :: is_gas => eos_is_gas              !! True without cohesion at zero energy
      procedure :: detonates => eos_detonates        !! True for the products of an explosive
      procedure :: detonation => eos_detonation      !! Speed, and volume behind the front
      !> Chapman-Jouguet speed of the products
      procedure :: chapman_jouguet_speed => eos_chapman_jouguet_speed
   end type eos_t

   abstract interface
      !> The wave speed returns the square of the bulk sound speed [m2/s2].
      pure subroutine update_i(self, state, deformation, first, last)
         import :: deformation_t, eos_t, material_state_t
         implicit none
         class(eos_t), intent(in) :: self
         type(material_state_t), intent(in) :: state                  !! State of the store
         type(deformation_t), intent(inout) :: deformation     !! Step of the range
         integer, intent(in) :: first, last                    !! Particles of the range
      end subroutine update_i
   end interface

contains

   !> Declare the keys of &material that belong to the equation of state. Most override this.
   subroutine eos_declare(self, schema)
      class(eos_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine eos_declare

   !> Read the keys that belong to the equation of state. The material sets the density before this
   !! call, and the bulk modulus after it unless the keys of the equation of state give it.
   pure subroutine eos_read(self, group)
      class(eos_t), intent(inout) :: self
      type(group_t), intent(in) :: group                       !! &material
   end subroutine eos_read

   !> Error in the combination of the keys of the equation of state; empty if there is none.
   pure function eos_fault(self, group) result(text)
      class(eos_t), intent(in) :: self
      type(group_t), intent(in) :: group                       !! &material
      character(len=:), allocatable :: text

      text = ""
   end function eos_fault

   !> Receive the text of the file of the equation of state, before its keys are read.
   subroutine eos_take_file(self, text, path, group, fault, doubt)
      class(eos_t), intent(inout) :: self
      character(len=*), intent(in) :: text                     !! Content of the file
      character(len=*), intent(in) :: path                     !! For messages
      type(group_t), intent(in) :: group                       !! &material
      character(len=:), allocatable, intent(out) :: fault      !! Error message, or empty
      character(len=:), allocatable, intent(out) :: doubt      !! Warning, or empty

      fault = ""
      doubt = ""
   end subroutine eos_take_file

   !> True if the keys of the equation of state give the bulk modulus.
   pure logical function eos_sets_bulk(self) result(sets)
      class(eos_t), intent(in) :: self

      sets = .true.
   end function eos_sets_bulk

   !> True if the equation of state is that of porous material.
   pure logical function eos_has_pores(self) result(has)
      class(eos_t), intent(in) :: self

      has = .false.
   end function eos_has_pores

   !> Request the fields that it needs: none if the pressure depends on the density alone.
   pure subroutine eos_request(self, requests)
      class(eos_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests
   end subroutine eos_request

   !> Grueneisen parameter times density at the middle of the step, for the temperature. It is 0
   !! where the pressure does not depend on energy.
   pure subroutine eos_find_gruneisen(self, state, deformation, first, last)
      class(eos_t), intent(in) :: self
      type(material_state_t), intent(in) :: state                     !! State of the store
      type(deformation_t), intent(inout) :: deformation        !! Step of the range
      integer, intent(in) :: first, last                       !! Particles of the range

      deformation%gruneisen(:last - first + 1) = 0.0_wp
   end subroutine eos_find_gruneisen

   !> The same for a constant Grueneisen parameter.
   pure subroutine take_gruneisen(number, state, deformation, first, last)
      real(wp), intent(in) :: number                           !! Grueneisen parameter [1]
      type(material_state_t), intent(in) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation        !! Step of the range
      integer, intent(in) :: first, last                       !! Particles of the range
      integer :: i, k

      do i = 1, last - first + 1
         k = first - 1 + i
         deformation%gruneisen(i) = number*2.0_wp*state%mass(k) &
            /(state%volume(k) + deformation%old_volume(i))
      end do
   end subroutine take_gruneisen

   !> Stored energy [J] of a particle whose material has no internal energy variable: work of the
   !! pressure from the reference state, with the pressure bounded from below [Pa]; 0 if particles
   !! carry the energy.
   pure real(wp) function eos_stored_energy(self, mass, volume, limit) result(energy)
      class(eos_t), intent(in) :: self
      real(wp), intent(in) :: mass                             !! [kg]
      real(wp), intent(in) :: volume                           !! [m3]
      real(wp), intent(in) :: limit                            !! Least pressure [Pa]

      energy = 0.0_wp
   end function eos_stored_energy

   !> True if the equation of state gives the temperature of density and energy.
   pure logical function eos_gives_temperature(self) result(gives)
      class(eos_t), intent(in) :: self

      gives = .false.
   end function eos_gives_temperature

   !> Temperature after the step, of an equation of state that gives it.
   pure subroutine eos_find_temperature(self, state, first, last)
      class(eos_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state                  !! State of the store
      integer, intent(in) :: first, last                       !! Particles of the range
   end subroutine eos_find_temperature

   !> True if material at rest has an energy, and with it perhaps a pressure.
   pure logical function eos_starts_with_energy(self) result(does)
      class(eos_t), intent(in) :: self

      does = .false.
   end function eos_starts_with_energy

   !> Temperature [K] at which material of the reference density has the energy `start_energy`;
   !! negative if the pressure does not depend on it, or the equation of state gives it.
   pure real(wp) function eos_cold_temperature(self, reference) result(temperature)
      class(eos_t), intent(in) :: self
      real(wp), intent(in) :: reference             !! Reference temperature of the material [K]

      temperature = -1.0_wp
   end function eos_cold_temperature

   !> Internal energy of the reference density [J/kg].
   pure real(wp) function eos_start_energy(self, temperature) result(energy)
      class(eos_t), intent(in) :: self
      real(wp), optional, intent(in) :: temperature !! Temperature of the reference [K]

      energy = 0.0_wp
   end function eos_start_energy

   !> True for a gas: the reference state, without energy, has no stiffness.
   pure logical function eos_is_gas(self) result(is_gas)
      class(eos_t), intent(in) :: self

      is_gas = .not. self%bulk > 0.0_wp
   end function eos_is_gas

   !> True if the equation of state is that of the products of an explosive.
   pure logical function eos_detonates(self) result(does)
      class(eos_t), intent(in) :: self

      does = .false.
   end function eos_detonates

   !> Speed of a detonation, and the relative volume behind the front.
   pure subroutine eos_detonation(self, speed, relative)
      class(eos_t), intent(in) :: self
      real(wp), intent(out) :: speed                           !! [m/s]
      real(wp), intent(out) :: relative                        !! [1]

      speed = 0.0_wp
      relative = 1.0_wp
   end subroutine eos_detonation

   !> Speed of the Chapman-Jouguet state of the products [m/s].
   pure real(wp) function eos_chapman_jouguet_speed(self) result(speed)
      class(eos_t), intent(in) :: self

      speed = 0.0_wp
   end function eos_chapman_jouguet_speed

   !> Note on the equation of state for the user, in one line; empty if there is none.
   function eos_report(self) result(text)
      class(eos_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
   end function eos_report

   !> Why a state has no pressure, for the message that names its particle; empty if it has one.
   function eos_fault_of_state(self, density, energy) result(text)
      class(eos_t), intent(in) :: self
      real(wp), intent(in) :: density                          !! [kg/m3]
      real(wp), intent(in) :: energy                           !! [J/kg]
      character(len=:), allocatable :: text

      text = ""
   end function eos_fault_of_state

   !> Store the changes of the step in the state of the equation of state, after `update`.
   pure subroutine eos_keep_state(self, state, deformation, first, last)
      class(eos_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state                  !! State of the store
      type(deformation_t), intent(in) :: deformation           !! Step of the range
      integer, intent(in) :: first, last                       !! Particles of the range
   end subroutine eos_keep_state
end module material_eos
