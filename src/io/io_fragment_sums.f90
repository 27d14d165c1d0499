! SPDX-License-Identifier: BSD-3-Clause
!> What fragments hold: sums over the particles of a cell, and over the cells of a fragment.
!!
!! Angular momenta are taken about the middle of a cell first and then moved to that of the
!! fragment, so that little is lost where a small fragment flies fast and far from the origin.
module io_fragment_sums
   use base_kinds, only: int64, wp
   use io_cells, only: cells_t
   use io_fields, only: picks_t
   use particle_store, only: store_t
   implicit none
   private

   public :: add_fragment, cell_sums

   !> Sums of a cell: 1 particles, 2 mass, 3 volume, 4 to 6 mass times position, 7 to 9 momentum, 10
   !! kinetic energy, 11 to 13 angular momentum about its middle, 14 to 16 lower and 17 to 19 upper
   !! corner of its particles, 20 failed mass, 21 least identity.
   integer, parameter, public :: sum_words = 21
   !> Columns of a fragment: 1 number, 2 particles, 3 mass, 4 volume, 5 to 7 centre, 8 to 10
   !! velocity, 11 to 13 angular momentum, 14 kinetic energy, 15 to 17 lower and 18 to 20 upper
   !! corner, 21 share of failed mass, 22 least identity.
   integer, parameter, public :: fragment_words = 22

contains

   !> Sums over the particles of each cell, in their order.
   pure subroutine cell_sums(stores, picks, cells, sums)
      type(store_t), intent(in) :: stores(:)             !! The particles
      type(picks_t), intent(in) :: picks(:)              !! (store) Which of them
      type(cells_t), intent(in) :: cells                 !! Their cells
      real(wp), allocatable, intent(out) :: sums(:, :)   !! (sum, cell)
      integer :: filled, p, row, store

      allocate (sums(sum_words, cells%count), source=0.0_wp)
      sums(14:16, :) = huge(1.0_wp)
      sums(17:19, :) = -huge(1.0_wp)
      sums(21, :) = huge(1.0_wp)
      filled = 0
      do store = 1, size(stores)
         do row = 1, size(picks(store)%order)
            filled = filled + 1
            call add_particle(stores(store), picks(store)%order(row), &
               sums(:, cells%of_row(filled)))
         end do
      end do
      ! angular momentum is about the centres of mass of cells, which are known now
      filled = 0
      do store = 1, size(stores)
         do row = 1, size(picks(store)%order)
            filled = filled + 1
            p = picks(store)%order(row)
            associate (total => sums(:, cells%of_row(filled)))
               total(11:13) = total(11:13) + stores(store)%state%mass(p)*cross( &
                  vector_of(stores(store)%position, p) - total(4:6)/total(2), &
                  vector_of(stores(store)%velocity, p) - total(7:9)/total(2))
            end associate
         end do
      end do
   end subroutine cell_sums

   !> Components of a vector of a particle.
   pure function vector_of(field, p) result(vector)
      real(wp), intent(in) :: field(:, :)                !! (particle, component)
      integer, intent(in) :: p                           !! Index of the particle
      real(wp) :: vector(3)

      vector = [field(p, 1), field(p, 2), field(p, 3)]
   end function vector_of

   !> Add a particle to its cell.
   pure subroutine add_particle(store, p, total)
      type(store_t), intent(in) :: store                 !! The particles
      integer, intent(in) :: p                           !! Index of the particle
      real(wp), intent(inout) :: total(:)                !! Sums of the cell
      real(wp) :: position(3), velocity(3)

      position = vector_of(store%position, p)
      velocity = vector_of(store%velocity, p)
      associate (state => store%state)
         total(1) = total(1) + 1.0_wp
         total(2) = total(2) + state%mass(p)
         total(3) = total(3) + state%volume(p)
         total(4:6) = total(4:6) + state%mass(p)*position
         total(7:9) = total(7:9) + state%mass(p)*velocity
         total(10) = total(10) + 0.5_wp*state%mass(p)*sum(velocity**2)
         total(14:16) = min(total(14:16), position)
         total(17:19) = max(total(17:19), position)
         total(21) = min(total(21), real(store%identity(p), wp))
         if (allocated(state%failed)) total(20) = total(20) &
            + state%mass(p)*real(min(state%failed(p), 1_int64), wp)
      end associate
   end subroutine add_particle

   !> What a fragment holds, from its cells in their order.
   pure subroutine add_fragment(sums, image, box, axisymmetric, columns)
      real(wp), intent(in) :: sums(:, :)                 !! (sum, cell)
      integer, intent(in) :: image(:, :)                 !! (3, cell) Boxes that it is moved by
      real(wp), intent(in) :: box(3)                     !! Edges of the box [m]
      logical, intent(in) :: axisymmetric                !! Rings have no angular momentum here
      real(wp), intent(out) :: columns(:)                !! As fragment_words says
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
      real(wp), intent(in) :: a(3)                       !! One vector
      real(wp), intent(in) :: b(3)                       !! Another vector
      real(wp) :: c(3)

      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross
end module io_fragment_sums
