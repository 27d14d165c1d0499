! SPDX-License-Identifier: BSD-3-Clause
!> The state of a periodic cell of grains, with its stress and energy.
!!
!! Equations of doc/theory/grains.md.
module grains_cell
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use grains_exchange, only: grain_halo_t
   use grains_law, only: contact_law_t
   use grains_pairs, only: pairs_t
   use grains_state, only: grains_t
   use mesh_box, only: box_t
   use mesh_drive, only: drive_t
   implicit none
   private

   public :: cell_t, interval_means_t

   !> Losses that are summed over pairs: dashpots, friction, length of the step.
   integer, parameter, public :: losses = 3

   !> Sums of stresses over time.
   type :: interval_means_t
      real(wp) :: time = 0.0_wp                      !! Time interval of the means [s]
      real(wp) :: contact(9) = 0.0_wp !! Sum of forces times branch vectors, times dt [J s]
      real(wp) :: kinetic(9) = 0.0_wp                !! Sum of m u u, times dt [J s]
   end type interval_means_t

   !> The coordinates at which the current pairs were found.
   type :: reference_t
      real(wp), allocatable :: place(:, :)           !! (axis, row)
      real(wp) :: edges(3, 3) = 0.0_wp               !! [m]
      real(wp) :: sorted = -1.0_wp !! Shear strain when rows were sorted; < 0: never
   end type reference_t

   !> The cell.
   type :: cell_t
      type(communicator_t) :: communicator
      type(box_t) :: box
      type(grains_t) :: grains
      type(contact_law_t) :: law
      type(drive_t) :: drive
      type(pairs_t) :: pairs
      type(grain_halo_t) :: halo
      type(reference_t) :: reference
      integer(int64) :: step = 0
      integer(int64) :: searches = 0                 !! Number of neighbour searches
      real(wp) :: time = 0.0_wp                      !! [s]
      real(wp) :: dt = 0.0_wp                        !! [s]
      real(wp) :: collision = 0.0_wp                 !! Duration of the shortest collision [s]
      real(wp) :: skin = 0.0_wp !! Gap of surfaces up to which pairs are found [m]
      real(wp) :: diameter = 0.0_wp                  !! Mean diameter [m]
      real(wp) :: density = 0.0_wp                   !! Density of the grains [kg/m3]
      real(wp) :: solid = 0.0_wp                     !! Volume of all grains [m3]
      real(wp) :: contact(9) = 0.0_wp                !! Sum of forces times branches [J]
      real(wp) :: kinetic(9) = 0.0_wp                !! Sum of m u u [J]
      real(wp) :: work = 0.0_wp                      !! Work of the stress on the cell so far [J]
      real(wp) :: lost_before(losses) = 0.0_wp       !! Losses before the energy balance [J]
      type(exact_sum_t) :: lost(losses)              !! By separated pairs, on this rank [J]
      type(interval_means_t) :: mean                           !! Since the last row of the history
   contains
      procedure :: stress => cell_stress             !! Stress of sums
      procedure :: pressure => cell_pressure         !! Mean pressure
      procedure :: volume_fraction => cell_volume_fraction !! Solid volume over cell volume
      procedure :: inertial_number => cell_inertial_number !! For the given shear and pressure
   end type cell_t

contains

   !> Stress, tension positive: -(sum of F r + sum of m u u)/V, (G.1) [Pa].
   pure function cell_stress(self, contact, kinetic) result(stress)
      class(cell_t), intent(in) :: self
      real(wp), intent(in) :: contact(9), kinetic(9) !! Sums [J]
      real(wp) :: stress(3, 3)

      stress = -reshape(contact + kinetic, [3, 3])/self%box%volume()
   end function cell_stress

   !> Mean pressure now [Pa].
   pure real(wp) function cell_pressure(self) result(pressure)
      class(cell_t), intent(in) :: self
      real(wp) :: stress(3, 3)
      integer :: axis

      stress = self%stress(self%contact, self%kinetic)
      pressure = 0.0_wp
      do axis = 1, self%box%dimension
         pressure = pressure - stress(axis, axis)
      end do
      pressure = pressure/real(self%box%dimension, wp)
   end function cell_pressure

   !> Solid fraction of the volume, overlaps counted twice [1].
   pure real(wp) function cell_volume_fraction(self) result(fraction)
      class(cell_t), intent(in) :: self

      fraction = self%solid/self%box%volume()
   end function cell_volume_fraction

   !> Inertial number, rate of shear times diameter times sqrt(density/pressure) [1].
   pure real(wp) function cell_inertial_number(self, pressure) result(number)
      class(cell_t), intent(in) :: self
      real(wp), intent(in) :: pressure               !! [Pa]

      number = 0.0_wp
      if (pressure > 0.0_wp) number = abs(self%box%gradient(1, 2))*self%diameter &
         *sqrt(self%density/pressure)
   end function cell_inertial_number
end module grains_cell
