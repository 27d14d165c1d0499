! SPDX-License-Identifier: BSD-3-Clause
!> Contact between bodies with separate velocity fields, on the nodes that several of them share.
!! See doc/theory/contact.md. Each node is treated on its own, in ghost tiles as well, so the result
!! does not depend on the number of ranks.
module step_contact
   use base_kinds, only: wp
   use mesh_patch, only: assemble_greatest, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_contact_surface, only: direction_of, guess_area, reach_row
   use step_ledger, only: dissipated, ledger_t
   use step_node_fields, only: empty_mass
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_simulation, only: guesses, scheme_t, scratch_t, simulation_effects_t, simulation_t, &
      space_t, velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   use step_walls, only: pair_row
   use transfer_contact, only: bond_traction, contact_bonded, separate_bodies, state_bonded, &
      state_closed, state_open
   implicit none
   private

   public :: add_contact_heat, apply_contact, break_bonds, find_later_heat, dissipation_after_remap

   real(wp), parameter :: slack = 1.0e-3_wp            !! Gap that counts as none, in cells
   real(wp), parameter :: bond_reach = 0.5_wp        !! Widest gap of a bond, in cells
   real(wp), parameter :: held = 0.5_wp              !! Least bonded mass fraction of a bond

contains

   !> Exchange contact forces between the bodies at all nodes that they share. This changes their
   !! accelerations and the velocities that strain.
   subroutine apply_contact(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! Surfaces are known
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp) :: began
      integer :: tile, field

      call simulation%machine%timer%start(simulation%machine%phase%contact)
      do field = 1, size(simulation%fields)
         call ensure_patch(simulation%fields(field)%nodes%work%rubbed, 1, &
            simulation%space%grid%tile_nodes, simulation%space%tiles%all)
         if (dissipation_after_remap(simulation%scheme)) &
            call ensure_patch(simulation%fields(field)%nodes%work%pressed, 3, &
            simulation%space%grid%tile_nodes, simulation%space%tiles%all)
      end do
      if (simulation%effects%contact%bonded) call ensure_broken(simulation%space, &
         simulation%effects)
      !$omp parallel do default(none) shared(simulation, dt) private(tile, began) &
      !$omp schedule(dynamic, 1)
      do tile = 1, simulation%space%tiles%all
         began = cost_clock(simulation%machine)
         call touch_tile(simulation, tile, dt)
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
      call simulation%machine%timer%stop(simulation%machine%phase%contact)
   end subroutine apply_contact

   !> True if the dissipation of contact is found with the velocity that `musl` and `usavg` map
   !! again. If materials carry internal energy, energy and work both use the velocities of the
   !! forces.
   pure logical function dissipation_after_remap(scheme) result(later)
      type(scheme_t), intent(in) :: scheme

      later = scheme%method%remaps() .and. .not. scheme%carries_energy
   end function dissipation_after_remap

   !> Allocate the bonds that break.
   subroutine ensure_broken(space, effects)
      type(space_t), intent(in) :: space
      type(simulation_effects_t), intent(inout) :: effects

      associate (contact => effects%contact, all => space%tiles%all)
         if (allocated(contact%broken)) then
            if (size(contact%broken, 3) < all) deallocate (contact%broken)
         end if
         if (.not. allocated(contact%broken)) allocate (contact%broken(size(contact%law, 1), &
            space%grid%tile_nodes, all + all/16))
      end associate
   end subroutine ensure_broken

   !> One tile.
   subroutine touch_tile(simulation, tile, dt)
      type(simulation_t), intent(inout) :: simulation
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), allocatable :: greatest(:, :), own(:, :)
      integer :: who(size(simulation%fields)), node, field, here

      do field = 1, size(simulation%fields)
         simulation%fields(field)%nodes%work%rubbed(:, :, tile) = 0.0_wp
         if (dissipation_after_remap(simulation%scheme)) &
            simulation%fields(field)%nodes%work%pressed(:, :, tile) = 0.0_wp
      end do
      if (simulation%effects%contact%bonded) simulation%effects%contact%broken(:, :, tile) = .false.
      if (.not. simulation%effects%contact%meets(tile)) return
      allocate (greatest(guesses*size(who)**2, simulation%space%grid%tile_nodes))
      call assemble_greatest(simulation%space%grid, simulation%space%tiles, &
         simulation%effects%contact%reach, tile, &
         greatest)
      if (allocated(simulation%balance%ledger%walls%total) .and. &
         tile <= simulation%space%tiles%own) call find_own_mass(simulation, tile, own)
      do node = 1, simulation%space%grid%tile_nodes
         here = 0
         do field = 1, size(who)
            if (.not. simulation%fields(field)%nodes%motion%mass(1, node, tile) > empty_mass) cycle
            here = here + 1
            who(here) = field
         end do
         if (here > 1) call touch_node(simulation, tile, node, who(:here), &
            greatest(:, node), dt, own)
      end do
   end subroutine touch_tile

   !> Mass that the particles of a tile give to its nodes.
   subroutine find_own_mass(simulation, tile, own)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      real(wp), allocatable, intent(out) :: own(:, :) !! (node, field) [kg]
      real(wp), allocatable :: rows(:, :)
      integer :: field

      associate (nodes => simulation%space%grid%tile_nodes)
         allocate (own(nodes, size(simulation%fields)))
         do field = 1, size(simulation%fields)
            associate (motion => simulation%fields(field)%nodes%motion)
               allocate (rows(motion%packed(1)%rows, nodes))
               call motion%packed(1)%get(simulation%space%grid, motion%touched, tile, rows)
               own(:, field) = rows(1, :)
               deallocate (rows)
            end associate
         end do
      end associate
   end subroutine find_own_mass

   !> One node where several fields have mass.
   subroutine touch_node(simulation, tile, node, who, reach, dt, own)
      type(simulation_t), intent(inout) :: simulation
      integer, intent(in) :: tile
      integer, intent(in) :: node                    !! Index in the tile
      integer, intent(in) :: who(:)                  !! The fields, ascending
      real(wp), intent(in) :: reach(:)               !! (pair) Extent of bodies [m]
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), allocatable, intent(in) :: own(:, :) !! (node, field) If forces are recorded [kg]
      real(wp) :: mass(size(who)), velocity(3, size(who)), push(3, size(who), size(who))
      real(wp) :: area(3, size(who), size(who)), normal(3, size(who), size(who))
      integer :: state(size(who), size(who)), a, b
      logical :: again

      call survey_node(simulation, tile, node, who, reach, area, normal, state)
      if (all(state == state_open)) return
      associate (field => simulation%fields, law => simulation%effects%contact%law(who, who))
         do a = 1, size(who)
            mass(a) = field(who(a))%nodes%motion%mass(1, node, tile)
            velocity(:, a) = field(who(a))%nodes%motion%strain(:, node, tile)
         end do
         call separate_bodies(mass, velocity, normal, state, law, push)
         again = .false.
         do b = 2, size(who)
            do a = 1, b - 1
               if (state(a, b) /= state_bonded) cycle
               if (.not. bond_traction(push(:, a, b), normal(:, a, b), area(:, a, b), dt) &
                  > law(a, b)%strength) cycle
               state(a, b) = state_closed
               simulation%effects%contact%broken(who(a), node, tile) = .true.
               simulation%effects%contact%broken(who(b), node, tile) = .true.
               again = .true.
            end do
         end do
         if (again) call separate_bodies(mass, velocity, normal, state, law, push)
      end associate
      call give_push(simulation%fields, tile, node, who, mass, push, dt)
      if (allocated(own)) call record_pairs(simulation%space, &
         simulation%scratch(omp_get_thread_num())%ledger, who, own(node, who)/mass, push)
   end subroutine touch_node

   !> Record the contact impulses of the pairs of fields at a node. A tile records the part of its
   !! own particles, so that all parts add up to the impulse. Equation (C.16).
   subroutine record_pairs(space, ledger, who, part, push)
      type(space_t), intent(in) :: space
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: who(:)                  !! Indices of the velocity fields, ascending
      real(wp), intent(in) :: part(:)                !! (field) Mass of own particles over all [1]
      real(wp), intent(in) :: push(:, :, :)          !! (3, a, b) Impulse on b, for a < b [kg m/s]
      integer :: a, b

      do b = 2, size(who)
         do a = 1, b - 1
            if (.not. maxval(abs(push(:, a, b)))*part(b) > 0.0_wp) cycle
            call ledger%walls%add(pair_row(space, who(a), who(b)), part(b)*push(:, a, b), &
               [0.0_wp, 0.0_wp, 0.0_wp])
         end do
      end do
   end subroutine record_pairs

   !> Normals between the fields at a node. Of the candidate normals the one is used along which two
   !! bodies are farthest apart: the normal of a plane between them, if there is one. At an edge the
   !! outward area of a body is inclined, and along it the bodies would overlap.
   subroutine survey_node(simulation, tile, node, who, reach, area, normal, state)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      integer, intent(in) :: node                    !! Index in the tile
      integer, intent(in) :: who(:)                  !! The fields, ascending
      real(wp), intent(in) :: reach(:)               !! (row) Extent of bodies [m]
      real(wp), contiguous, intent(out) :: area(:, :, :) !! (3, a, b) Between two, for a < b [m2]
      real(wp), contiguous, intent(out) :: normal(:, :, :) !! (3, a, b) Normal vector [1]
      integer, intent(out) :: state(:, :)            !! (a, b) Gap, for a < b
      real(wp) :: gap
      integer :: a, b

      state = state_open
      area = 0.0_wp
      normal = 0.0_wp
      associate (contact => simulation%effects%contact, spacing => simulation%space%grid%spacing)
         do b = 2, size(who)
            do a = 1, b - 1
               call choose_normal(simulation, tile, node, [who(a), who(b)], reach, area(:, a, b), &
                  normal(:, a, b), gap)
               if (gap <= slack*spacing) state(a, b) = state_closed
               if (contact%law(who(a), who(b))%kind /= contact_bonded) cycle
               if (gap <= bond_reach*spacing .and. holds(simulation, tile, node, who(a)) .and. &
                  holds(simulation, tile, node, who(b))) state(a, b) = state_bonded
            end do
         end do
      end associate
   end subroutine survey_node

   !> The normal along which two fields are farthest apart at a node. Equation (C.2).
   subroutine choose_normal(simulation, tile, node, pair, reach, area, normal, gap)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      integer, intent(in) :: node                    !! Index in the tile
      integer, intent(in) :: pair(2)                 !! The fields, ascending
      real(wp), intent(in) :: reach(:)               !! (row) Extent of bodies [m]
      real(wp), intent(out) :: area(3)               !! Common area [m2]
      real(wp), intent(out) :: normal(3)             !! Normal vector [1]
      real(wp), intent(out) :: gap                   !! Gap; infinite if none is found [m]
      real(wp) :: trial(3), direction(3), wide, one, other
      integer :: guess

      area = 0.0_wp
      normal = 0.0_wp
      gap = huge(gap)
      wide = -huge(wide)
      do guess = 1, guesses
         trial = guess_area(simulation%effects%contact, tile, node, pair(1), pair(2), guess)
         direction = direction_of(simulation%space, trial)
         if (all(abs(direction) <= 0.0_wp)) cycle
         one = reach(reach_row(simulation%effects%contact, pair(1), pair(2), guess))
         other = reach(reach_row(simulation%effects%contact, pair(2), pair(1), guess))
         ! not in contact here: with extended support the mass belongs to particles farther away
         if (min(one, other) <= -huge(gap)) cycle
         if (-(one + other) <= wide) cycle
         wide = -(one + other)
         gap = wide
         area = trial
         normal = direction
      end do
   end subroutine choose_normal

   !> Do the bonds of most of the mass of a field at a node hold?
   pure logical function holds(simulation, tile, node, field) result(most)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      integer, intent(in) :: node                    !! Index in the tile
      integer, intent(in) :: field                   !! Index of the velocity field

      most = simulation%effects%contact%area(4*field, node, tile) > &
         held*simulation%fields(field)%nodes%motion%mass(1, node, tile)
   end function holds

   !> Apply the contact forces to the fields at a node. The kinetic energy that they dissipate
   !! becomes heat, the same per mass for all fields. Equation (C.6).
   subroutine give_push(fields, tile, node, who, mass, push, dt)
      type(velocity_field_t), intent(inout) :: fields(:)
      integer, intent(in) :: tile
      integer, intent(in) :: node                    !! Index in the tile
      integer, intent(in) :: who(:)                  !! Indices of the velocity fields
      real(wp), intent(in) :: mass(:)                !! (field) Masses [kg]
      real(wp), intent(in) :: push(:, :, :)          !! (3, a, b) Impulse on b, for a < b [kg m/s]
      real(wp), intent(in) :: dt                     !! Duration [s]
      real(wp) :: total(3), lost
      integer :: a, b

      lost = 0.0_wp
      do a = 1, size(who)
         total = 0.0_wp
         do b = 1, size(who)
            if (b < a) total = total + push(:, b, a)
            if (b > a) total = total - push(:, a, b)
         end do
         associate (nodes => fields(who(a))%nodes)
            nodes%motion%strain(:, node, tile) = nodes%motion%strain(:, node, tile) + total/mass(a)
            nodes%motion%acceleration(:, node, tile) = nodes%motion%acceleration(:, node, tile) &
               + total/(dt*mass(a))
            lost = lost - dot_product(total, nodes%motion%velocity(:, node, tile) &
               + 0.5_wp*dt*nodes%motion%acceleration(:, node, tile))
            if (allocated(nodes%work%pressed)) nodes%work%pressed(:, node, tile) = total
         end associate
      end do
      do a = 1, size(who)
         fields(who(a))%nodes%work%rubbed(1, node, tile) = lost/sum(mass)
      end do
   end subroutine give_push

   !> Dissipation of contact, after particle velocities were mapped again: particles receive these,
   !! not the node velocities. Equation (C.7) of doc/theory/contact.md.
   subroutine find_later_heat(simulation)
      type(simulation_t), intent(inout) :: simulation !! With contact forces and velocities
      real(wp) :: began, lost, mass
      integer :: tile, node, field

      !$omp parallel do default(none) shared(simulation) &
      !$omp private(began, lost, mass, tile, node, field) schedule(dynamic, 1)
      do tile = 1, simulation%space%tiles%own
         began = cost_clock(simulation%machine)
         if (.not. simulation%effects%contact%meets(tile)) cycle
         do node = 1, simulation%space%grid%tile_nodes
            lost = 0.0_wp
            mass = 0.0_wp
            do field = 1, size(simulation%fields)
               associate (nodes => simulation%fields(field)%nodes)
                  if (.not. nodes%motion%mass(1, node, tile) > empty_mass) cycle
                  mass = mass + nodes%motion%mass(1, node, tile)
                  lost = lost - dot_product(nodes%work%pressed(:, node, tile), &
                     0.5_wp*(nodes%motion%velocity(:, node, tile) + nodes%motion%strain(:, node, &
                     tile)))
               end associate
            end do
            if (.not. mass > 0.0_wp) cycle
            do field = 1, size(simulation%fields)
               simulation%fields(field)%nodes%work%rubbed(1, node, tile) = lost/mass
            end do
         end do
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
   end subroutine find_later_heat

   !> Let the bonds of particles break whose nearest node broke in this step. The particles are at
   !! the positions at which they gave their masses to the nodes.
   subroutine break_bonds(simulation)
      type(simulation_t), intent(inout) :: simulation !! Bonds can break
      real(wp) :: began
      integer :: tile, field, index

      !$omp parallel do default(none) shared(simulation) private(began, tile, field, index) &
      !$omp schedule(dynamic, 1)
      do tile = 1, simulation%space%tiles%own
         began = cost_clock(simulation%machine)
         do field = 1, size(simulation%fields)
            if (.not. any(simulation%effects%contact%broken(field, :, tile))) cycle
            do index = simulation%fields(field)%first_store, simulation%fields(field)%last_store
               if (.not. allocated(simulation%stores(index)%bond)) cycle
               call break_tile(simulation%space, simulation%scheme, &
                  simulation%scratch(omp_get_thread_num()), &
                  simulation%effects%contact%broken(field, :, tile), tile, simulation%stores(index))
            end do
         end do
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
   end subroutine break_bonds

   !> One store in one tile.
   subroutine break_tile(space, scheme, scratch, broken, tile, store)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      logical, intent(in) :: broken(:)               !! (node)
      integer, intent(in) :: tile
      type(store_t), intent(inout) :: store
      integer :: cell, p, q, node, upper(3)

      call locate_particles_plainly(space, scheme, scratch, store, tile)
      ! cells are counted from 0, but an array section would count them from 1
      associate (grid => space%grid)
         do cell = 0, grid%tile_cells - 1
            do p = store%cell_start(cell, tile) + 1, store%cell_start(cell + 1, tile)
               q = store%first(tile) + p - 1
               upper = merge(1, 0, grid%active .and. scratch%shape%local(p, :) > 0.5_wp)
               node = grid%first_node(cell) + dot_product(upper, grid%stride)
               if (broken(node)) store%bond(q) = 0.0_wp
            end do
         end do
      end associate
   end subroutine break_tile

   !> Heat of contact to the particles of a tile; material that carries no internal energy records
   !! it.
   subroutine add_contact_heat(space, scheme, field, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      real(wp) :: lost
      integer :: p, q

      associate (rubbed => field%nodes%work%rubbed(:, :, tile), shape => scratch%shape)
         if (.not. any(abs(rubbed) > 0.0_wp)) return
         call scheme%method%basis%gather_values(space%grid, shape, &
            rubbed, shape%values)
      end associate
      lost = 0.0_wp
      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         if (allocated(store%state%energy)) then
            store%state%energy(q) = store%state%energy(q) + scratch%shape%values(p, 1)
         else
            lost = lost + store%state%mass(q)*scratch%shape%values(p, 1)
         end if
      end do
      call scratch%ledger%sums(dissipated)%add(lost)
   end subroutine add_contact_heat
end module step_contact
