! SPDX-License-Identifier: BSD-3-Clause
!> Properties of fragments: sums over the particles of a cell, and over the cells of a fragment.
!!
!! Angular momenta are summed about the centre of mass of a cell and then transformed to that of the
!! fragment, which limits cancellation for a small, fast fragment far from the origin.
module sample_fragment_sums
   use base_kinds, only: int64, wp
   use particle_store, only: store_t
   use sample_cells, only: cells_t
   use sample_fields, only: picks_t
   implicit none
   private

   public :: add_fragment, cell_sums

   !> Sums of a cell: 1 particles, 2 mass, 3 volume, 4 to 6 mass times position, 7 to 9 momentum, 10
   !! kinetic energy, 11 to 13 angular momentum about its centre of mass, 14 to 16 lower and 17 to
   !! 19 upper corner of its particles, 20 failed mass, 21 least identity.
   integer, parameter, public :: sum_words = 21
   !> Columns of a fragment: 1 number, 2 particles, 3 mass, 4 volume, 5 to 7 centre, 8 to 10
   !! velocity, 11 to 13 angular momentum, 14 kinetic energy, 15 to 17 lower and 18 to 20 upper
   !! corner, 21 failed mass fraction, 22 least identity.
   integer, parameter, public :: fragment_words = 22

contains

   !> Sums over the particles of each cell, in their order.
   pure subroutine cell_sums(stores, picks, cells, sums)
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(cells_t), intent(in) :: cells
      real(wp), allocatable, intent(out) :: sums(:, :)   !! (sum, cell)
      real(wp) :: position(3), velocity(3)
      integer :: filled, p, row, store, pass

      allocate (sums(sum_words, cells%count), source=0.0_wp)
      sums(14:16, :) = huge(1.0_wp)
      sums(17:19, :) = -huge(1.0_wp)
      sums(21, :) = huge(1.0_wp)
      do pass = 1, 2
         filled = 0
         do store = 1, size(stores)
            do row = 1, size(picks(store)%order)
               p = picks(store)%order(row)
               position = [stores(store)%position(p, 1), stores(store)%position(p, 2), &
                  stores(store)%position(p, 3)]
               velocity = [stores(store)%velocity(p, 1), stores(store)%velocity(p, 2), &
                  stores(store)%velocity(p, 3)]
               filled = filled + 1
               if (pass == 1) then
                  call add_particle(stores(store), p, position, velocity, &
                     sums(:, cells%of_row(filled)))
               else
                  call add_angular_momentum(stores(store)%state%mass(p), position, velocity, &
                     sums(:, cells%of_row(filled)))
               end if
            end do
         end do
      end do
   end subroutine cell_sums

   !> Add the angular momentum of a particle about the centre of mass of its cell.
   pure subroutine add_angular_momentum(mass, position, velocity, total)
      real(wp), intent(in) :: mass                       !! [kg]
      real(wp), intent(in) :: position(3)                !! [m]
      real(wp), intent(in) :: velocity(3)                !! [m/s]
      real(wp), intent(inout) :: total(:)                !! Sums of the cell

      total(11:13) = total(11:13) + mass*cross(position - total(4:6)/total(2), &
         velocity - total(7:9)/total(2))
   end subroutine add_angular_momentum

   !> Add a particle to its cell.
   pure subroutine add_particle(store, p, position, velocity, total)
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp), intent(in) :: position(3)                !! [m]
      real(wp), intent(in) :: velocity(3)                !! [m/s]
      real(wp), intent(inout) :: total(:)                !! Sums of the cell

      associate (mass => store%state%mass(p), volume => store%state%volume(p))
         total(1) = total(1) + 1.0_wp
         total(2) = total(2) + mass
         total(3) = total(3) + volume
         total(4:6) = total(4:6) + mass*position
         total(7:9) = total(7:9) + mass*velocity
         total(10) = total(10) + 0.5_wp*mass*sum(velocity**2)
         total(14:16) = min(total(14:16), position)
         total(17:19) = max(total(17:19), position)
      end associate
      total(21) = min(total(21), real(store%identity(p), wp))
      if (allocated(store%state%failed)) total(20) = total(20) &
         + store%state%mass(p)*real(min(store%state%failed(p), 1_int64), wp)
   end subroutine add_particle

   !> Sum the cells of a fragment in their order.
   pure subroutine add_fragment(sums, image, box, axisymmetric, columns)
      real(wp), intent(in) :: sums(:, :)                 !! (sum, cell)
      integer, intent(in) :: image(:, :)                 !! (3, cell) Periods by which it is shifted
      real(wp), intent(in) :: box(3)                     !! Edges of the domain [m]
      logical, intent(in) :: axisymmetric                !! If so, angular momentum is 0
      real(wp), intent(out) :: columns(:)                !! Columns as in fragment_words
      real(wp) :: total(sum_words), shift(3), centre(3), velocity(3), angular(3)
      integer :: cell

      total = 0.0_wp
      total(14:16) = huge(1.0_wp)
      total(17:19) = -huge(1.0_wp)
      total(21) = huge(1.0_wp)
      do cell = 1, size(sums, 2)
         shift = real(image(:, cell), wp)*box
         associate (part => sums(:, cell))
            total(:3) = total(:3) + part(:3)
            total(4:6) = total(4:6) + (part(4:6) + part(2)*shift)
            total(7:10) = total(7:10) + part(7:10)
            total(14:16) = min(total(14:16), part(14:16) + shift)
            total(17:19) = max(total(17:19), part(17:19) + shift)
            total(20) = total(20) + part(20)
            total(21) = min(total(21), part(21))
         end associate
      end do
      centre = total(4:6)/total(2)
      velocity = total(7:9)/total(2)
      angular = 0.0_wp
      do cell = 1, size(sums, 2)
         shift = real(image(:, cell), wp)*box
         associate (part => sums(:, cell))
            angular = angular + (part(11:13) + part(2)*cross( &
               part(4:6)/part(2) + shift - centre, part(7:9)/part(2) - velocity))
         end associate
      end do
      if (axisymmetric) angular = 0.0_wp
      columns = [0.0_wp, total(:3), centre, velocity, angular, total(10), total(14:19), &
         total(20)/total(2), total(21)]
   end subroutine add_fragment

   !> Cross product.
   pure function cross(a, b) result(c)
      real(wp), intent(in) :: a(3)
      real(wp), intent(in) :: b(3)
      real(wp) :: c(3)

      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross
end module sample_fragment_sums
