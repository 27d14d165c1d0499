! SPDX-License-Identifier: BSD-3-Clause
!> Contact of bodies with separate velocity fields: their contact forces at one node, and the gap
!! there.
!!
!! At a node where two bodies a and b touch, with the normal n from a to b, an impulse p on b and -p
!! on a prevents b from approaching a at the end of the step. Its normal part is compressive. Its
!! tangential part stops the slip, up to mu times the normal part (S. G. Bardenhagen, J. U.
!! Brackbill, D. Sulsky, Comput. Methods Appl. Mech. Eng. 187 (2000) 529; S. G. Bardenhagen et al.,
!! CMES 2 (2001) 509). Where more than two bodies meet, pairs are treated in turn in a fixed order
!! until no force changes. The gap at a node follows from the particles, not from shape functions,
!! which extend across a cell: the greatest position along n of the particles of a in the cells
!! around, with half their width, and the least of b (compare J. A. Nairn, C. C. Hammerquist, G. D.
!! Smith, Comput. Methods Appl. Mech. Eng. 362 (2020) 112859).
module transfer_contact
   use base_elementary, only: take_fast_powers
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lane_bit
   implicit none
   private

   public :: bond_traction, pair_law_t, particle_widths, separate_bodies, find_reach

   integer, parameter, public :: contact_friction = 1    !! Coulomb
   integer, parameter, public :: contact_stick = 2       !! No slip while pressed together
   integer, parameter, public :: contact_frictionless = 3 !! Slips freely
   integer, parameter, public :: contact_bonded = 4      !! One body until the bond breaks
   !> Names of the laws in the order of their numbers.
   character(len=12), parameter, public :: contact_names(4) = [character(len=12) :: "friction", &
      "stick", "frictionless", "bonded"]

   integer, parameter, public :: state_open = 0          !! The bodies are apart
   integer, parameter, public :: state_closed = 1        !! True if the bodies touch
   integer, parameter, public :: state_bonded = 2        !! True if a bond holds

   integer, parameter :: most_turns = 50 !! Largest number of rounds over the pairs at a node
   real(wp), parameter :: enough = 1.0e-12_wp        !! Relative gain for convergence

   !> Contact law of a pair of bodies.
   type :: pair_law_t
      integer :: kind = contact_friction             !! One of the kinds above
      real(wp) :: friction = 0.0_wp                  !! Coefficient of friction [1]
      real(wp) :: strength = huge(1.0_wp)            !! Strength of a bond [Pa]
   end type pair_law_t

contains

   !> Contact impulses that keep the bodies at a node from approaching. The sum of the impulses of a
   !! pair is zero to the last bit. Equation (C.3) of doc/theory/contact.md.
   pure subroutine separate_bodies(mass, velocity, normal, state, law, push)
      real(wp), intent(in) :: mass(:)                !! (body) Mass at the node [kg]
      real(wp), intent(in) :: velocity(:, :) !! (3, body) Velocity at the end of the step [m/s]
      real(wp), contiguous, intent(in) :: normal(:, :, :) !! (3, a, b) From a to b, for a < b [1]
      integer, intent(in) :: state(:, :)             !! (a, b) Gap, for a < b
      type(pair_law_t), intent(in) :: law(:, :)      !! (a, b) Contact law
      real(wp), contiguous, intent(out) :: push(:, :, :) !! (3, a, b) On b, for a < b [kg m/s]
      real(wp) :: now(3, size(mass)), change(3), wanted(3), gain, scale
      integer :: a, b, turn, pairs

      now = velocity
      push = 0.0_wp
      pairs = count(state /= state_open)
      scale = 0.0_wp
      do a = 1, size(mass)
         scale = max(scale, maxval(abs(velocity(:, a))))
      end do
      do turn = 1, merge(1, most_turns, pairs < 2)
         gain = 0.0_wp
         do b = 2, size(mass)
            do a = 1, b - 1
               if (state(a, b) == state_open) cycle
               wanted = push(:, a, b) &
                  - mass(a)*(mass(b)/(mass(a) + mass(b)))*(now(:, b) - now(:, a))
               if (state(a, b) == state_closed) call restrict(law(a, b), normal(:, a, b), wanted)
               change = wanted - push(:, a, b)
               push(:, a, b) = wanted
               now(:, a) = now(:, a) - change/mass(a)
               now(:, b) = now(:, b) + change/mass(b)
               gain = max(gain, maxval(abs(change))*(1.0_wp/mass(a) + 1.0_wp/mass(b)))
            end do
         end do
         if (gain <= enough*scale) exit
      end do
   end subroutine separate_bodies

   !> Limit the impulse that would stop all relative motion to the contact law: no tension, and
   !! along the surface at most friction. Equation (C.4).
   pure subroutine restrict(law, normal, push)
      type(pair_law_t), intent(in) :: law            !! Contact law
      real(wp), intent(in) :: normal(3)              !! Normal to the body that is pushed [1]
      real(wp), intent(inout) :: push(3)             !! [kg m/s]
      real(wp) :: along(3), pressed, slip

      pressed = dot_product(push, normal)
      if (.not. pressed > 0.0_wp) then
         push = 0.0_wp
         return
      end if
      if (law%kind == contact_stick) return
      along = push - pressed*normal
      push = pressed*normal
      if (law%kind == contact_frictionless) return
      slip = norm2(along)
      if (slip > law%friction*pressed) along = along*(law%friction*pressed/slip)
      push = push + along
   end subroutine restrict

   !> Tensile and shear stress [Pa] of an impulse on a bond; pressure does not count.
   !! Equation (C.5).
   pure real(wp) function bond_traction(push, normal, area, dt) result(stress)
      real(wp), intent(in) :: push(3) !! Impulse on the body that n points to [kg m/s]
      real(wp), intent(in) :: normal(3)              !! [1]
      real(wp), intent(in) :: area(3)                !! Area vector of the surface at the node [m2]
      real(wp), intent(in) :: dt                     !! Duration [s]
      real(wp) :: pressed, sheared

      pressed = dot_product(push, normal)
      sheared = norm2(push - pressed*normal)
      stress = hypot(min(pressed, 0.0_wp), sheared)/(norm2(area)*dt)
   end function bond_traction

   !> Half the width of the particles of a tile [m], as if they were cubes.
   pure subroutine particle_widths(grid, first, count, position, volume, half)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                   !! First particle of the tile
      integer, intent(in) :: count                   !! Particles of the tile
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: volume(:)  !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: half(:) !! (particle of the tile) [m]
      integer :: p, q

      do p = 1, count
         q = first + p - 1
         half(p) = volume(q)/grid%depth
         if (grid%axisymmetric) half(p) = half(p)/position(q, 1)
         if (grid%dimensions == 2) half(p) = sqrt(half(p))
      end do
      if (grid%dimensions == 3) call take_fast_powers(count, 1.0_wp/3.0_wp, half)
      do p = 1, count
         half(p) = 0.5_wp*half(p)
      end do
   end subroutine particle_widths

   !> Extent of the particles of a tile along the normals of its nodes: the greatest position of
   !! those in the cells around, relative to the node. Nodes without a normal are skipped. One side
   !! of (C.2).
   pure subroutine find_reach(grid, corner, start, first, position, half, normal, reach)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: corner(3)              !! Lower corner of the tile [m]
      integer, contiguous, intent(in) :: start(0:)   !! (0:cells) Particles before a cell
      integer, intent(in) :: first                   !! First particle of the tile
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) [m]
      real(wp), contiguous, intent(in) :: half(:)    !! (particle of the tile) Half its width [m]
      real(wp), contiguous, intent(in) :: normal(:, :) !! (3, node) [1]
      real(wp), contiguous, intent(inout) :: reach(:)  !! (node) So far [m]
      real(wp) :: place(3), farthest
      integer :: cell, lane, node, p, q, k

      do cell = 0, grid%tile_cells - 1
         if (start(cell + 1) == start(cell)) cycle
         do lane = 1, 2**grid%dimensions
            node = grid%first_node(cell) + grid%lane_offset(lane)
            if (all(abs(normal(:, node)) <= 0.0_wp)) cycle
            do k = 1, 3
               place(k) = corner(k) + grid%spacing*real(grid%cell_position(k, cell) &
                  + merge(ibits(lane - 1, lane_bit(k), 1), 0, grid%active(k)), wp)
            end do
            farthest = reach(node)
            do p = start(cell) + 1, start(cell + 1)
               q = first + p - 1
               farthest = max(farthest, (position(q, 1) - place(1))*normal(1, node) &
                  + (position(q, 2) - place(2))*normal(2, node) &
                  + (position(q, 3) - place(3))*normal(3, node) + half(p))
            end do
            reach(node) = farthest
         end do
      end do
   end subroutine find_reach
end module transfer_contact
