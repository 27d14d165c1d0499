! SPDX-License-Identifier: BSD-3-Clause
!> A copy of the stress that gives the nodal forces of the particles of a tile, for methods that
!! modify it.
module transfer_pushed_stress
   use base_kinds, only: wp
   implicit none
   private

   public :: pushed_stress_t

   !> Place, volume and stress of the particles of a tile.
   type :: pushed_stress_t
      real(wp), allocatable :: position(:, :)        !! (particle of the tile, 3) [m]
      real(wp), allocatable :: volume(:)             !! (particle of the tile) [m3]
      real(wp), allocatable :: stress(:, :)          !! (particle of the tile, 6) [Pa]
      !> Of loads on surfaces, if there are any: (particle of the tile, 6) [Pa]
      real(wp), allocatable :: load(:, :)
      real(wp), allocatable :: density(:, :) !! (particle of the tile, 3) Force of the stress [N/m3]
   contains
      procedure :: reserve_load => pushed_reserve_load !! Ensure capacity for loads
      procedure :: copy => pushed_copy               !! From the particles of a store
      procedure :: make_unit => pushed_make_unit     !! Give all unit stress
      procedure :: subtract => pushed_subtract       !! Subtract a stress
   end type pushed_stress_t

contains

   !> Copy the particles of a tile.
   pure subroutine pushed_copy(self, first, count, position, volume, stress)
      class(pushed_stress_t), intent(inout) :: self
      integer, intent(in) :: first                           !! First particle of the tile
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) [m]
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) [Pa]
      integer :: p, k

      if (allocated(self%volume)) then
         if (size(self%volume) < count) deallocate (self%position, self%volume, self%stress)
      end if
      if (.not. allocated(self%volume)) &
         allocate (self%position(count, 3), self%volume(count), self%stress(count, 6))
      do p = 1, count
         self%volume(p) = volume(first + p - 1)
      end do
      do k = 1, 3
         do p = 1, count
            self%position(p, k) = position(first + p - 1, k)
         end do
      end do
      do k = 1, 6
         do p = 1, count
            self%stress(p, k) = stress(first + p - 1, k)
         end do
      end do
   end subroutine pushed_copy

   !> Ensure capacity for the loads at the particles of a tile.
   pure subroutine pushed_reserve_load(self, count)
      class(pushed_stress_t), intent(inout) :: self
      integer, intent(in) :: count                           !! Particles of the tile

      if (allocated(self%density)) then
         if (size(self%density, 1) >= count) return
         deallocate (self%load, self%density)
      end if
      allocate (self%load(count, 6), self%density(count, 3))
   end subroutine pushed_reserve_load

   !> Give each particle unit stress.
   pure subroutine pushed_make_unit(self, count)
      class(pushed_stress_t), intent(inout) :: self
      integer, intent(in) :: count                           !! Particles of the tile
      integer :: p, k

      do k = 1, 6
         do p = 1, count
            self%stress(p, k) = merge(1.0_wp, 0.0_wp, k <= 3)
         end do
      end do
   end subroutine pushed_make_unit

   !> Subtract some components of a stress from that of each particle.
   pure subroutine pushed_subtract(self, count, rows, values)
      class(pushed_stress_t), intent(inout) :: self
      integer, intent(in) :: count                           !! Particles of the tile
      integer, contiguous, intent(in) :: rows(:)             !! Components
      !> (particle of the tile, component or more) [Pa]
      real(wp), contiguous, intent(in) :: values(:, :)
      integer :: p, k

      do k = 1, size(rows)
         do p = 1, count
            self%stress(p, rows(k)) = self%stress(p, rows(k)) - values(p, k)
         end do
      end do
   end subroutine pushed_subtract
end module transfer_pushed_stress
