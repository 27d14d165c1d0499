! SPDX-License-Identifier: BSD-3-Clause
!> Equation of state given as a table of pressures and energies over density and temperature.
!!
!! Particles carry their energy, from which the table finds the temperature and with it the
!! pressure. A run stores each table once. Equations (E.16) to (E.19) of
!! doc/theory/equations_of_state.md.
module eos_table
   use base_constants, only: most_lanes
   use base_error, only: error_t
   use base_kinds, only: wp
   use base_text, only: brief, number
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   use material_table_states, only: cell_lanes_t, state_table_t
   use material_table_text, only: read_states
   implicit none
   private

   public :: eos_table_t

   !> Inconsistency of a table above which the user is warned. Interpolation of steep curves between
   !! few nodes causes part of it.
   real(wp), parameter :: most_inconsistent = 0.02_wp

   !> Equation of state of a table.
   type, extends(eos_t) :: eos_table_t
      type(state_table_t) :: table                   !! Values
      real(wp) :: reference = 293.0_wp               !! Temperature of the reference state [K]
   contains
      procedure :: declare => table_declare          !! Declares its keys
      procedure :: take_file => table_take_file      !! Its table from the text of a file
      procedure :: read => table_read                !! Reads its keys
      procedure :: request => table_request          !! Requests the energy field
      procedure :: update => table_update            !! Pressure and square of the sound speed
      procedure :: gives_temperature => table_gives_temperature !! Returns true
      procedure :: find_temperature => table_find_temperature !! From density and energy
      procedure :: starts_with_energy => table_starts_with_energy !! Returns true
      procedure :: start_energy => table_start_energy !! That of the temperature
      procedure :: is_gas => table_is_gas            !! From pressure and stiffness of the reference
      procedure :: report => table_report            !! Extent and inconsistency
      procedure :: fault_of_state => table_fault_of_state !! Why a state has no pressure
   end type eos_table_t

contains

   !> Declare the keys of the equation of state.
   subroutine table_declare(self, schema)
      class(eos_table_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.eos & eos_model = table"

      call schema%text("material", "eos_table", "file of the equation of state: lines of "// &
         "density, temperature, pressure and energy in SI units; path relative to the deck", &
         owner=owner)
      ! contents of files are not compared, only paths
      call schema%allow_change("material", "eos_table", changes_physics)
      call schema%real("material", "table_temperature", "temperature of the reference state, "// &
         "for the bulk modulus; also the initial temperature of bodies without &effects thermal", &
         unit="K", default="293", range=">= 0", owner=owner)
      call schema%forbid_change("material", "table_temperature", "it gave the particles their "// &
         "first energy")
      call schema%require("material", "eos_table")
   end subroutine table_declare

   !> Make the table from the text of its file, and check that it contains the reference state.
   subroutine table_take_file(self, text, path, group, fault, doubt)
      class(eos_table_t), intent(inout) :: self
      character(len=*), intent(in) :: text           !! Content of the file
      character(len=*), intent(in) :: path           !! For messages
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      character(len=:), allocatable, intent(out) :: doubt !! Empty if there is none
      type(error_t), allocatable :: error
      real(wp) :: density, temperature

      fault = ""
      doubt = ""
      call read_states(text, path, self%table, error)
      if (allocated(error)) then
         fault = error%message
         return
      end if
      if (self%table%worst > most_inconsistent) doubt = "pressure and energy of the table '"// &
         path//"' are inconsistent: rho**2 de/drho and p - T dp/dT differ by "// &
         brief(self%table%worst)//" of the bulk modulus at "//brief(self%table%worst_density)// &
         " kg/m3, "//brief(self%table%worst_temperature)//" K [F119]"
      if (.not. (group%known("density") .and. group%known("table_temperature"))) return
      call group%get("density", density)
      call group%get("table_temperature", temperature)
      associate (table => self%table, last => size(self%table%density), &
         hottest => size(self%table%temperature))
         if (density < table%density(1) .or. density > table%density(last)) then
            fault = "density = "//brief(density)//" kg/m3 lies outside of the table '"//path// &
               "', which has "//brief(table%density(1))//" to "//brief(table%density(last))// &
               " [F119]"
         else if (temperature < table%temperature(1) .or. &
            temperature > table%temperature(hottest)) then
            fault = "table_temperature = "//brief(temperature)//" K lies outside of the table '" &
               //path//"', which has "//brief(table%temperature(1))//" to "// &
               brief(table%temperature(hottest))//" [F119]"
         end if
      end associate
   end subroutine table_take_file

   !> Read the keys of the equation of state; the table is already read.
   pure subroutine table_read(self, group)
      class(eos_table_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      real(wp) :: pressure, square

      call group%get("table_temperature", self%reference)
      call find_state(self, self%density, self%table%energy_of(self%density, self%reference), &
         pressure, square)
      self%bulk = self%density*square
   end subroutine table_read

   !> The pressure depends on energy.
   pure subroutine table_request(self, requests)
      class(eos_table_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "equation of state table", 1)
   end subroutine table_request

   !> Pressure and square of the sound speed.
   pure subroutine table_update(self, state, deformation, first, last)
      class(eos_table_t), intent(in) :: self
      type(material_state_t), intent(in) :: state    !! State of the store
      type(deformation_t), intent(inout) :: deformation !! Step of the range
      integer, intent(in) :: first, last             !! Particles of the range
      type(cell_lanes_t) :: lanes
      integer :: begin

      do begin = first, last, most_lanes
         call find_lanes(self, state, begin, min(begin + most_lanes - 1, last), lanes)
         call self%table%interpolate(lanes, begin - first, deformation%pressure, &
            deformation%wave_speed)
      end do
   end subroutine table_update

   !> Densities and energies of some particles, and their cells of the table.
   pure subroutine find_lanes(eos, state, first, last, lanes)
      class(eos_table_t), intent(in) :: eos
      type(material_state_t), intent(in) :: state    !! State of the store
      integer, intent(in) :: first, last             !! First and last particle
      type(cell_lanes_t), intent(inout) :: lanes
      integer :: l

      lanes%count = last - first + 1
      !$omp simd
      do l = 1, lanes%count
         lanes%density(l) = state%mass(first - 1 + l)/state%volume(first - 1 + l)
         lanes%energy(l) = state%energy(first - 1 + l)
      end do
      call eos%table%find_cells(lanes)
   end subroutine find_lanes

   !> Pressure and square of the sound speed of one state.
   pure subroutine find_state(eos, density, energy, pressure, square)
      class(eos_table_t), intent(in) :: eos
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: energy                 !! [J/kg]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp), intent(out) :: square                !! Square of the sound speed [m2/s2]
      type(cell_lanes_t) :: lanes
      real(wp) :: found(1), speed(1)

      lanes%count = 1
      lanes%density(1) = density
      lanes%energy(1) = energy
      call eos%table%find_cells(lanes)
      call eos%table%interpolate(lanes, 0, found, speed)
      pressure = found(1)
      square = speed(1)
   end subroutine find_state

   !> The table gives a temperature for each density and energy.
   pure logical function table_gives_temperature(self) result(gives)
      class(eos_table_t), intent(in) :: self

      gives = .true.
   end function table_gives_temperature

   !> Temperature of density and energy after the step.
   pure subroutine table_find_temperature(self, state, first, last)
      class(eos_table_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state !! State of the store
      integer, intent(in) :: first, last             !! Particles of the range
      type(cell_lanes_t) :: lanes
      integer :: begin

      do begin = first, last, most_lanes
         call find_lanes(self, state, begin, min(begin + most_lanes - 1, last), lanes)
         call self%table%find_temperatures(lanes, begin - 1, state%temperature)
      end do
   end subroutine table_find_temperature

   !> Material starts with the energy of its temperature, and with its pressure.
   pure logical function table_starts_with_energy(self) result(does)
      class(eos_table_t), intent(in) :: self

      does = .true.
   end function table_starts_with_energy

   !> Internal energy of the reference density [J/kg], at a temperature or at that of the reference.
   pure real(wp) function table_start_energy(self, temperature) result(energy)
      class(eos_table_t), intent(in) :: self
      real(wp), optional, intent(in) :: temperature  !! [K]
      real(wp) :: warmth

      warmth = self%reference
      if (present(temperature)) warmth = temperature
      energy = self%table%energy_of(self%density, warmth)
   end function table_start_energy

   !> A gas holds its density by its pressure, of which the bulk modulus of the reference state is
   !! a small multiple (the heat capacity ratio, if it is ideal); in liquids and solids that
   !! multiple is thousands, or the pressure is 0.
   pure logical function table_is_gas(self) result(is_gas)
      class(eos_table_t), intent(in) :: self
      real(wp), parameter :: most = 10.0_wp          !! Of the bulk modulus over the pressure [1]
      real(wp) :: pressure, square

      is_gas = .false.
      if (.not. self%bulk > 0.0_wp) return
      call find_state(self, self%density, self%start_energy(), pressure, square)
      is_gas = self%bulk < most*pressure
   end function table_is_gas

   !> Range of the table, its pressure in the reference state, and its inconsistency.
   function table_report(self) result(text)
      class(eos_table_t), intent(in) :: self
      character(len=:), allocatable :: text
      real(wp) :: pressure, square

      call find_state(self, self%density, self%start_energy(), pressure, square)
      associate (table => self%table)
         text = number(size(table%density))//" densities "//brief(table%density(1))//" to "// &
            brief(table%density(size(table%density)))//" kg/m3, "// &
            number(size(table%temperature))//" temperatures "//brief(table%temperature(1))// &
            " to "//brief(table%temperature(size(table%temperature)))//" K; reference state "// &
            brief(pressure)//" Pa, sound speed "//brief(sqrt(square))//" m/s; inconsistency "// &
            brief(table%worst)//" at "//brief(table%worst_density)//" kg/m3, "// &
            brief(table%worst_temperature)//" K"
      end associate
   end function table_report

   !> Why a state has no pressure; empty if it has one.
   function table_fault_of_state(self, density, energy) result(text)
      class(eos_table_t), intent(in) :: self
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: energy                 !! [J/kg]
      character(len=:), allocatable :: text
      real(wp) :: pressure, square, least, greatest

      text = ""
      call find_state(self, density, energy, pressure, square)
      if (.not. ieee_is_nan(pressure)) return
      associate (axis => self%table%density)
         text = "it left its eos_table: density "//brief(density)//" kg/m3 [R104]"
         if (density < axis(1) .or. density > axis(size(axis))) then
            text = text//", which has "//brief(axis(1))//" to "//brief(axis(size(axis)))
         else
            call self%table%energy_range(density, least, greatest)
            text = text//" and energy "//brief(energy)//" J/kg, which has "//brief(least)// &
               " to "//brief(greatest)//" there"
         end if
      end associate
   end function table_fault_of_state
end module eos_table
