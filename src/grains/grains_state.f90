! SPDX-License-Identifier: BSD-3-Clause
!> The grains of a periodic cell: discs of 1 m thickness, or spheres.
!!
!! Rows are the order in memory and follow a space-filling curve from time to time; identities are
!! the numbers of the grains at the start. Every rank holds all rows; it moves its own ones and gets
!! those around from other ranks.
module grains_state
   use base_constants, only: pi
   use base_kinds, only: wp
   use mesh_box, only: box_t
   implicit none
   private

   public :: block_rows, grain_mass, grains_t

   integer, parameter :: block_rows = 32             !! Rows whose sums are added together

   !> The grains.
   type :: grains_t
      integer :: count = 0                           !! Number of grains on all ranks
      integer :: first = 1                           !! First own row
      integer :: last = 0                            !! Last own row
      integer, allocatable :: identity(:)            !! (row) 1 to count
      real(wp), allocatable :: radius(:)             !! (row) [m]
      real(wp), allocatable :: mass(:)               !! (row) [kg]
      real(wp), allocatable :: inertia(:)            !! (row) Moment of inertia [kg m2]
      real(wp), allocatable :: place(:, :)           !! (axis, row) Coordinates in the cell [1]
      real(wp), allocatable :: position(:, :)        !! (axis, row) The cell's edges times these [m]
      real(wp), allocatable :: velocity(:, :)        !! (axis, row) Relative to the cell [m/s]
      real(wp), allocatable :: spin(:, :)            !! (axis, row) Angular velocity [rad/s]
      real(wp), allocatable :: force(:, :)           !! (axis, row) [N]
      real(wp), allocatable :: torque(:, :)          !! (axis, row) [N m]
   contains
      procedure :: allocate => grains_allocate       !! Reserve memory for grains
      procedure :: locate => grains_locate           !! Positions from coordinates
      procedure :: solid_volume => grains_solid_volume !! Volume of all grains [m3]
   end type grains_t

contains

   !> Allocate grains at rest.
   pure subroutine grains_allocate(self, count)
      class(grains_t), intent(inout) :: self
      integer, intent(in) :: count                   !! Their number
      integer :: row

      self%count = count
      self%first = 1
      self%last = count
      allocate (self%identity(count), self%radius(count), self%mass(count), self%inertia(count))
      allocate (self%place(3, count), self%position(3, count), self%velocity(3, count))
      allocate (self%spin(3, count), self%force(3, count), self%torque(3, count))
      self%identity = [(row, row=1, count)]
      self%place = 0.0_wp
      self%position = 0.0_wp
      self%velocity = 0.0_wp
      self%spin = 0.0_wp
      self%force = 0.0_wp
      self%torque = 0.0_wp
   end subroutine grains_allocate

   !> Positions of some rows from their coordinates.
   pure subroutine grains_locate(self, box, first, last)
      class(grains_t), intent(inout) :: self
      type(box_t), intent(in) :: box
      integer, intent(in) :: first, last             !! Rows
      integer :: row

      associate (h => box%edges, s => self%place)
         do row = first, last
            self%position(1, row) = h(1, 1)*s(1, row) + h(1, 2)*s(2, row) + h(1, 3)*s(3, row)
            self%position(2, row) = h(2, 2)*s(2, row) + h(2, 3)*s(3, row)
            self%position(3, row) = h(3, 3)*s(3, row)
         end do
      end associate
   end subroutine grains_locate

   !> Volume of all grains, the same on all ranks, in the order of identities [m3].
   pure real(wp) function grains_solid_volume(self, dimension) result(volume)
      class(grains_t), intent(in) :: self
      integer, intent(in) :: dimension               !! 2: discs of 1 m thickness
      real(wp) :: radius(self%count)
      integer :: n

      radius(self%identity) = self%radius
      volume = 0.0_wp
      do n = 1, self%count
         if (dimension == 2) then
            volume = volume + pi*radius(n)**2
         else
            volume = volume + 4.0_wp/3.0_wp*pi*radius(n)**3
         end if
      end do
   end function grains_solid_volume

   !> Mass [kg] and moment of inertia [kg m2] of a grain.
   pure subroutine grain_mass(dimension, density, radius, mass, inertia)
      integer, intent(in) :: dimension               !! 2: discs of 1 m thickness
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: radius                 !! [m]
      real(wp), intent(out) :: mass                  !! [kg]
      real(wp), intent(out) :: inertia               !! [kg m2]

      if (dimension == 2) then
         mass = density*pi*radius**2
         inertia = 0.5_wp*mass*radius**2
      else
         mass = density*4.0_wp/3.0_wp*pi*radius**3
         inertia = 0.4_wp*mass*radius**2
      end if
   end subroutine grain_mass
end module grains_state
