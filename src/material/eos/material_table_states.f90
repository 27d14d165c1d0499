! SPDX-License-Identifier: BSD-3-Clause
!> A table of states: pressure and energy over density and temperature, and its values in between.
!!
!! Values are bilinear in density and temperature, so the energy at a density increases piecewise
!! linearly with the temperature and is inverted exactly. Equations (E.16) to (E.19) of
!! doc/theory/equations_of_state.md.
module material_table_states
   use base_constants, only: most_lanes
   use base_kinds, only: wp
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   implicit none
   private

   public :: cell_lanes_t, state_table_t


   !> Values at the nodes. Node k of density i and temperature j is j + (i - 1) n, n the number of
   !! temperatures.
   type :: state_table_t
      real(wp), allocatable :: density(:)            !! Ascending [kg/m3]
      real(wp), allocatable :: temperature(:)        !! Ascending [K]
      real(wp), allocatable :: pressure(:)           !! (node) [Pa]
      real(wp), allocatable :: energy(:)             !! (node) [J/kg]
      real(wp), allocatable :: square(:)             !! Square of the sound speed (node) [m2/s2]
      real(wp) :: worst = 0.0_wp                     !! Greatest inconsistency of a cell [1]
      real(wp) :: worst_density = 0.0_wp             !! Density in the worst cell [kg/m3]
      real(wp) :: worst_temperature = 0.0_wp         !! Temperature in the worst cell [K]
   contains
      procedure :: complete => states_complete       !! Sound speeds and inconsistency
      procedure :: find_cells => states_find_cells !! Cells of states, and where in them
      procedure :: interpolate => states_interpolate !! Pressure and sound speed there
      procedure :: find_temperatures => states_find_temperatures !! Temperatures there
      procedure :: energy_of => states_energy_of     !! Energy of a density and a temperature
      procedure :: energy_range => states_energy_range !! Least and greatest at a density
   end type state_table_t

   !> States that are interpolated together, and their cells.
   type :: cell_lanes_t
      integer :: count = 0                           !! States in use
      real(wp) :: density(most_lanes)                !! (in) [kg/m3]
      real(wp) :: energy(most_lanes)                 !! (in) [J/kg]
      integer :: row(most_lanes)                     !! Density below it
      integer :: column(most_lanes)                  !! Temperature below it
      real(wp) :: across(most_lanes)                 !! Weight of the next density [1]
      real(wp) :: along(most_lanes)                  !! Weight of the next temperature [1]
   end type cell_lanes_t

   !> Tolerance of the weights for rounding at the edge of the table.
   real(wp), parameter :: slack = 1.0e-9_wp

contains

   !> Square of the sound speed at each node, and the inconsistency of each cell.
   pure subroutine states_complete(self)
      class(state_table_t), intent(inout) :: self    !! Other data are set
      integer :: i, j, k, n

      n = size(self%temperature)
      allocate (self%square(size(self%energy)))
      do i = 1, size(self%density)
         do j = 1, n
            k = j + (i - 1)*n
            self%square(k) = square_at(self, i, j)
         end do
      end do
      do i = 1, size(self%density) - 1
         do j = 1, n - 1
            call note_inconsistency(self, i, j)
         end do
      end do
   end subroutine states_complete

   !> Square of the sound speed at a node from differences of second order. Equation (E.18).
   pure real(wp) function square_at(self, i, j) result(square)
      class(state_table_t), intent(in) :: self
      integer, intent(in) :: i                       !! Index in the densities
      integer, intent(in) :: j                       !! Index in the temperatures
      real(wp) :: pressure_slope, energy_slope, heating, capacity
      integer :: n, k

      n = size(self%temperature)
      k = j + (i - 1)*n
      pressure_slope = slope(self%density, self%pressure(j::n), i)
      energy_slope = slope(self%density, self%energy(j::n), i)
      heating = slope(self%temperature, self%pressure((i - 1)*n + 1:i*n), j)
      capacity = slope(self%temperature, self%energy((i - 1)*n + 1:i*n), j)
      square = pressure_slope + heating/capacity*(self%pressure(k)/self%density(i)**2 &
         - energy_slope)
   end function square_at

   !> Derivative at a node: of the parabola through it and its neighbours, or of the first or last
   !! three nodes; of a straight line between two.
   pure real(wp) function slope(x, y, place) result(derivative)
      real(wp), intent(in) :: x(:)                   !! Ascending
      real(wp), intent(in) :: y(:)                   !! Values there
      integer, intent(in) :: place                   !! Node of the derivative
      real(wp) :: first, second, curvature
      integer :: middle

      if (size(x) == 2) then
         derivative = (y(2) - y(1))/(x(2) - x(1))
         return
      end if
      middle = min(max(place, 2), size(x) - 1)
      first = (y(middle) - y(middle - 1))/(x(middle) - x(middle - 1))
      second = (y(middle + 1) - y(middle))/(x(middle + 1) - x(middle))
      curvature = (second - first)/(x(middle + 1) - x(middle - 1))
      derivative = first + curvature*(2.0_wp*x(place) - x(middle) - x(middle - 1))
   end function slope

   !> Inconsistency of a cell: difference of rho**2 de/drho and p - T dp/dT in its middle, over the
   !! bulk modulus. The greatest one is kept. Equation (E.19).
   pure subroutine note_inconsistency(self, i, j)
      class(state_table_t), intent(inout) :: self
      integer, intent(in) :: i                       !! Density below the cell
      integer, intent(in) :: j                       !! Temperature below the cell
      real(wp) :: density, temperature, energy_slope, heating, pressure, bulk, miss
      integer :: n, k(4)

      n = size(self%temperature)
      ! Nodes of both densities at the lower temperature, then at the higher one.
      k = [j, j + n, j + 1, j + 1 + n] + (i - 1)*n
      density = 0.5_wp*(self%density(i) + self%density(i + 1))
      temperature = 0.5_wp*(self%temperature(j) + self%temperature(j + 1))
      energy_slope = 0.5_wp*(self%energy(k(2)) - self%energy(k(1)) + self%energy(k(4)) &
         - self%energy(k(3)))/(self%density(i + 1) - self%density(i))
      heating = 0.5_wp*(self%pressure(k(3)) - self%pressure(k(1)) + self%pressure(k(4)) &
         - self%pressure(k(2)))/(self%temperature(j + 1) - self%temperature(j))
      pressure = 0.25_wp*sum(self%pressure(k))
      bulk = density*0.25_wp*sum(abs(self%square(k)))
      if (.not. bulk > 0.0_wp) return
      miss = abs(density**2*energy_slope - pressure + temperature*heating)/bulk
      if (miss <= self%worst) return
      self%worst = miss
      self%worst_density = density
      self%worst_temperature = temperature
   end subroutine note_inconsistency

   !> Cells of states by bisection, all states together, and the local coordinates in them. A state
   !! outside has a coordinate below 0 or above 1 in a cell at the edge. Equations (E.16) and
   !! (E.17).
   pure subroutine states_find_cells(self, lanes)
      class(state_table_t), intent(in) :: self
      type(cell_lanes_t), intent(inout) :: lanes    !! Densities and energies in, cells out

      call find_rows(lanes%count, size(self%density), self%density, lanes)
      call find_columns(lanes%count, size(self%temperature), self%energy, lanes)
   end subroutine states_find_cells

   !> Last density that is not above that of each state, and the weight of the next one.
   pure subroutine find_rows(count, nodes, axis, lanes)
      integer, intent(in) :: count                   !! States
      integer, intent(in) :: nodes                   !! Densities of the table
      real(wp), contiguous, intent(in) :: axis(:)    !! [kg/m3]
      type(cell_lanes_t), intent(inout) :: lanes
      integer :: stride, next, l

      lanes%row(:count) = 1
      stride = first_stride(nodes)
      do while (stride > 0)
         !$omp simd private(next)
         do l = 1, count
            next = min(lanes%row(l) + stride, nodes - 1)
            lanes%row(l) = merge(next, lanes%row(l), axis(next) <= lanes%density(l))
         end do
         stride = stride/2
      end do
      !$omp simd
      do l = 1, count
         lanes%across(l) = (lanes%density(l) - axis(lanes%row(l))) &
            /(axis(lanes%row(l) + 1) - axis(lanes%row(l)))
      end do
   end subroutine find_rows

   !> Last temperature whose energy at the density of each state is not above that of the state, and
   !! the weight of the next one.
   pure subroutine find_columns(count, nodes, energy, lanes)
      integer, intent(in) :: count                   !! States
      integer, intent(in) :: nodes                   !! Temperatures of the table
      real(wp), contiguous, intent(in) :: energy(:)  !! (node) [J/kg]
      type(cell_lanes_t), intent(inout) :: lanes    !! With rows and weights of densities
      real(wp) :: low, high
      integer :: stride, next, k, l

      lanes%column(:count) = 1
      stride = first_stride(nodes)
      do while (stride > 0)
         !$omp simd private(next, k, low)
         do l = 1, count
            next = min(lanes%column(l) + stride, nodes - 1)
            k = next + (lanes%row(l) - 1)*nodes
            low = energy(k) + lanes%across(l)*(energy(k + nodes) - energy(k))
            lanes%column(l) = merge(next, lanes%column(l), low <= lanes%energy(l))
         end do
         stride = stride/2
      end do
      !$omp simd private(k, low, high)
      do l = 1, count
         k = lanes%column(l) + (lanes%row(l) - 1)*nodes
         low = energy(k) + lanes%across(l)*(energy(k + nodes) - energy(k))
         high = energy(k + 1) + lanes%across(l)*(energy(k + 1 + nodes) - energy(k + 1))
         lanes%along(l) = (lanes%energy(l) - low)/(high - low)
      end do
   end subroutine find_columns

   !> Power of two with which a bisection among nodes begins.
   pure integer function first_stride(nodes) result(stride)
      integer, intent(in) :: nodes

      stride = 1
      do while (2*stride < nodes)
         stride = 2*stride
      end do
   end function first_stride

   !> Pressure and square of the sound speed of states whose cells are known. Outside of the table
   !! both are NaN, at which a run stops and names the particle.
   pure subroutine states_interpolate(self, lanes, offset, pressure, square)
      class(state_table_t), intent(in) :: self
      type(cell_lanes_t), intent(in) :: lanes       !! Cells of the states
      integer, intent(in) :: offset                  !! The results of lane l go to offset + l
      real(wp), contiguous, intent(inout) :: pressure(:) !! (range) [Pa]
      real(wp), contiguous, intent(inout) :: square(:) !! Square of the sound speed (range) [m2/s2]

      call mix_nodes(lanes, size(self%temperature), offset, self%pressure, pressure)
      call mix_nodes(lanes, size(self%temperature), offset, self%square, square)
   end subroutine states_interpolate

   !> Values of states between those of nodes.
   pure subroutine mix_nodes(lanes, nodes, offset, value, mixed)
      type(cell_lanes_t), intent(in) :: lanes       !! Cells of the states
      integer, intent(in) :: nodes                   !! Temperatures of the table
      integer, intent(in) :: offset                  !! Lane l is stored at offset + l
      real(wp), contiguous, intent(in) :: value(:)   !! (node)
      real(wp), contiguous, intent(inout) :: mixed(:) !! (range)
      real(wp) :: low, high, none
      logical :: inside
      integer :: k, l

      none = ieee_value(none, ieee_quiet_nan)
      !$omp simd private(k, low, high, inside)
      do l = 1, lanes%count
         k = lanes%column(l) + (lanes%row(l) - 1)*nodes
         low = value(k) + lanes%across(l)*(value(k + nodes) - value(k))
         high = value(k + 1) + lanes%across(l)*(value(k + 1 + nodes) - value(k + 1))
         inside = abs(lanes%across(l) - 0.5_wp) <= 0.5_wp + slack .and. &
            abs(lanes%along(l) - 0.5_wp) <= 0.5_wp + slack
         mixed(offset + l) = merge(low + lanes%along(l)*(high - low), none, inside)
      end do
   end subroutine mix_nodes

   !> Temperatures of states whose cells are known.
   pure subroutine states_find_temperatures(self, lanes, offset, temperature)
      class(state_table_t), intent(in) :: self
      type(cell_lanes_t), intent(in) :: lanes       !! Cells of the states
      integer, intent(in) :: offset                  !! Lane l is stored at offset + l
      real(wp), contiguous, intent(inout) :: temperature(:) !! (store) [K]
      integer :: l

      !$omp simd
      do l = 1, lanes%count
         temperature(offset + l) = self%temperature(lanes%column(l)) + lanes%along(l) &
            *(self%temperature(lanes%column(l) + 1) - self%temperature(lanes%column(l)))
      end do
   end subroutine states_find_temperatures

   !> Energy [J/kg] of a density and a temperature of the table; the inverse finds the temperature
   !! again.
   pure real(wp) function states_energy_of(self, density, temperature) result(energy)
      class(state_table_t), intent(in) :: self
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: temperature            !! [K]
      real(wp) :: low, high
      integer :: j

      j = min(max(count(self%temperature <= temperature), 1), size(self%temperature) - 1)
      low = energy_at(self, density, j)
      high = energy_at(self, density, j + 1)
      energy = low + (temperature - self%temperature(j)) &
         /(self%temperature(j + 1) - self%temperature(j))*(high - low)
   end function states_energy_of

   !> Energy [J/kg] of a density at a temperature of the table.
   pure real(wp) function energy_at(self, density, j) result(energy)
      class(state_table_t), intent(in) :: self
      real(wp), intent(in) :: density                !! [kg/m3]
      integer, intent(in) :: j                       !! Index in the temperatures
      integer :: i, k

      i = min(max(count(self%density <= density), 1), size(self%density) - 1)
      k = j + (i - 1)*size(self%temperature)
      energy = self%energy(k) + (density - self%density(i))/(self%density(i + 1) &
         - self%density(i))*(self%energy(k + size(self%temperature)) - self%energy(k))
   end function energy_at

   !> Energies between which the table has states of a density.
   pure subroutine states_energy_range(self, density, least, greatest)
      class(state_table_t), intent(in) :: self
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(out) :: least                 !! [J/kg]
      real(wp), intent(out) :: greatest              !! [J/kg]

      least = energy_at(self, density, 1)
      greatest = energy_at(self, density, size(self%temperature))
   end subroutine states_energy_range
end module material_table_states
