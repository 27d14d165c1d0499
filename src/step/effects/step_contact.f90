! SPDX-License-Identifier: BSD-3-Clause
!> Contact between bodies with separate velocity fields, on the nodes that several of them share.
!! See doc/theory/contact.md. Each node is treated on its own, in ghost tiles as well, so the result
!! does not depend on the number of ranks.
module step_contact
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble_greatest, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_contact_surface, only: direction_of, guess_area, reach_row
   use step_ledger, only: dissipated, ledger_t
   use step_method, only: method_t
   use step_node_fields, only: empty_mass, nodes_t
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_simulation, only: contact_t, guesses, machine_t, scheme_t, scratch_t, space_t, &
      velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
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
   subroutine apply_contact(space, fields, scheme, contact, ledger, machine, scratches, dt)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(inout) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(contact_t), intent(inout) :: contact
      type(ledger_t), intent(inout) :: ledger
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      integer :: tile, field

      call machine%timer%start(machine%phase%contact)
      do field = 1, size(fields)
         call ensure_patch(fields(field)%nodes%work%contact_heat, 1, space%grid%tile_nodes, &
            space%tiles%all)
         if (dissipation_after_remap(scheme)) &
            call ensure_patch(fields(field)%nodes%work%contact_impulse, 3, space%grid%tile_nodes, &
            space%tiles%all)
      end do
      if (contact%bonded) then
         ! allocate the bonds that break
         associate (all => space%tiles%all)
            if (allocated(contact%broken)) then
               if (size(contact%broken, 3) < all) deallocate (contact%broken)
            end if
            if (.not. allocated(contact%broken)) allocate (contact%broken(size(contact%law, 1), &
               space%grid%tile_nodes, all + all/16))
         end associate
      end if
      !$omp parallel do default(none) shared(space, fields, scheme, contact, ledger, machine, &
      !$omp scratches, dt) private(tile) schedule(dynamic, 1)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call touch_tile(space, fields, scheme, contact, ledger, scratches, tile, dt)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%contact)
   end subroutine apply_contact

   !> True if the dissipation of contact is found with the velocity that `musl` and `usavg` map
   !! again. If materials carry internal energy, energy and work both use the velocities of the
   !! forces.
   pure logical function dissipation_after_remap(scheme) result(later)
      type(scheme_t), intent(in) :: scheme

      later = scheme%method%remaps() .and. .not. scheme%carries_energy
   end function dissipation_after_remap

   !> One tile.
   subroutine touch_tile(space, fields, scheme, contact, ledger, scratches, tile, dt)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(inout) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(contact_t), intent(inout) :: contact
      type(ledger_t), intent(in) :: ledger
      type(scratch_t), intent(inout) :: scratches(0:)
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), allocatable :: greatest(:, :), own(:, :)
      integer :: who(size(fields)), node, field, here

      do field = 1, size(fields)
         fields(field)%nodes%work%contact_heat(:, :, tile) = 0.0_wp
         if (dissipation_after_remap(scheme)) &
            fields(field)%nodes%work%contact_impulse(:, :, tile) = 0.0_wp
      end do
      if (contact%bonded) contact%broken(:, :, tile) = .false.
      if (.not. contact%meets(tile)) return
      allocate (greatest(guesses*size(who)**2, space%grid%tile_nodes))
      call assemble_greatest(space%grid, space%tiles, contact%reach, tile, greatest)
      if (allocated(ledger%walls%total) .and. tile <= space%tiles%own) then
         ! mass that the particles of a tile give to its nodes
         allocate (own(space%grid%tile_nodes, size(fields)))
         do field = 1, size(fields)
            associate (nodes => fields(field)%nodes)
               call nodes%motion%own_mass(space%grid, tile, own(:, field))
            end associate
         end do
      end if
      do node = 1, space%grid%tile_nodes
         here = 0
         do field = 1, size(who)
            if (.not. fields(field)%nodes%motion%mass(1, node, tile) > empty_mass) cycle
            here = here + 1
            who(here) = field
         end do
         if (here > 1) call touch_node(space, fields, contact, scratches, tile, node, who(:here), &
            greatest(:, node), dt, own)
      end do
   end subroutine touch_tile

   !> One node where several fields have mass.
   subroutine touch_node(space, fields, contact, scratches, tile, node, who, reach, dt, own)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(inout) :: fields(:)
      type(contact_t), intent(inout) :: contact
      type(scratch_t), intent(inout) :: scratches(0:)
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

      call survey_node(space%grid, fields, contact, tile, node, who, reach, area, normal, state)
      if (all(state == state_open)) return
      associate (field => fields, law => contact%law(who, who))
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
               contact%broken(who(a), node, tile) = .true.
               contact%broken(who(b), node, tile) = .true.
               again = .true.
            end do
         end do
         if (again) call separate_bodies(mass, velocity, normal, state, law, push)
      end associate
      call give_push(fields, tile, node, who, mass, push, dt)
      if (allocated(own)) call record_pairs(space, scratches(omp_get_thread_num())%ledger, who, &
         own(node, who)/mass, push)
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
   subroutine survey_node(grid, fields, contact, tile, node, who, reach, area, normal, state)
      type(grid_t), intent(in) :: grid
      type(velocity_field_t), intent(in) :: fields(:)
      type(contact_t), intent(in) :: contact
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
      associate (spacing => grid%spacing)
         do b = 2, size(who)
            do a = 1, b - 1
               call choose_normal(grid, contact, tile, node, [who(a), who(b)], reach, &
                  area(:, a, b), normal(:, a, b), gap)
               if (gap <= slack*spacing) state(a, b) = state_closed
               if (contact%law(who(a), who(b))%kind /= contact_bonded) cycle
               if (gap <= bond_reach*spacing .and. bonds_hold(fields, contact, tile, node, who(a)) &
                  .and. bonds_hold(fields, contact, tile, node, who(b))) state(a, b) = state_bonded
            end do
         end do
      end associate
   end subroutine survey_node

   !> The normal along which two fields are farthest apart at a node. Equation (C.2).
   subroutine choose_normal(grid, contact, tile, node, pair, reach, area, normal, gap)
      type(grid_t), intent(in) :: grid
      type(contact_t), intent(in) :: contact
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
         trial = guess_area(contact, tile, node, pair(1), pair(2), guess)
         direction = direction_of(grid, trial)
         if (all(abs(direction) <= 0.0_wp)) cycle
         one = reach(reach_row(contact, pair(1), pair(2), guess))
         other = reach(reach_row(contact, pair(2), pair(1), guess))
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
   pure logical function bonds_hold(fields, contact, tile, node, field) result(most)
      type(velocity_field_t), intent(in) :: fields(:)
      type(contact_t), intent(in) :: contact
      integer, intent(in) :: tile
      integer, intent(in) :: node                    !! Index in the tile
      integer, intent(in) :: field                   !! Index of the velocity field

      most = contact%area(4*field, node, tile) > held*fields(field)%nodes%motion%mass(1, node, tile)
   end function bonds_hold

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
            if (allocated(nodes%work%contact_impulse)) nodes%work%contact_impulse(:, node, tile) = &
               total
         end associate
      end do
      do a = 1, size(who)
         fields(who(a))%nodes%work%contact_heat(1, node, tile) = lost/sum(mass)
      end do
   end subroutine give_push

   !> Dissipation of contact, after particle velocities were mapped again: particles receive these,
   !! not the node velocities. Equation (C.7) of doc/theory/contact.md.
   subroutine find_later_heat(space, fields, contact, machine)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(inout) :: fields(:)
      type(contact_t), intent(in) :: contact
      type(machine_t), intent(inout) :: machine
      real(wp) :: lost, mass
      integer :: tile, node, field

      !$omp parallel do default(none) shared(space, fields, contact, machine) &
      !$omp private(lost, mass, tile, node, field) schedule(dynamic, 1)
      do tile = 1, space%tiles%own
         if (.not. contact%meets(tile)) cycle
         call start_cost(machine, tile)
         do node = 1, space%grid%tile_nodes
            lost = 0.0_wp
            mass = 0.0_wp
            do field = 1, size(fields)
               associate (nodes => fields(field)%nodes)
                  if (.not. nodes%motion%mass(1, node, tile) > empty_mass) cycle
                  mass = mass + nodes%motion%mass(1, node, tile)
                  lost = lost - dot_product(nodes%work%contact_impulse(:, node, tile), &
                     0.5_wp*(nodes%motion%velocity(:, node, tile) &
                     + nodes%motion%strain(:, node, tile)))
               end associate
            end do
            if (.not. mass > 0.0_wp) cycle
            do field = 1, size(fields)
               fields(field)%nodes%work%contact_heat(1, node, tile) = lost/mass
            end do
         end do
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine find_later_heat

   !> Let the bonds of particles break whose nearest node broke in this step. The particles are at
   !! the positions at which they gave their masses to the nodes.
   subroutine break_bonds(space, stores, fields, method, contact, machine, scratches)
      type(space_t), intent(in) :: space
      type(store_t), intent(inout) :: stores(:)
      type(velocity_field_t), intent(in) :: fields(:)
      type(method_t), intent(in) :: method
      type(contact_t), intent(in) :: contact
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      integer :: tile, field, index

      !$omp parallel do default(none) shared(space, stores, fields, method, contact, machine, &
      !$omp scratches) private(tile, field, index) schedule(dynamic, 1)
      do tile = 1, space%tiles%own
         call start_cost(machine, tile)
         do field = 1, size(fields)
            if (.not. any(contact%broken(field, :, tile))) cycle
            do index = fields(field)%first_store, fields(field)%last_store
               if (.not. allocated(stores(index)%bond)) cycle
               call break_tile(space, method, scratches(omp_get_thread_num()), &
                  contact%broken(field, :, tile), tile, stores(index))
            end do
         end do
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine break_bonds

   !> One store in one tile.
   subroutine break_tile(space, method, scratch, broken, tile, store)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      logical, intent(in) :: broken(:)               !! (node)
      integer, intent(in) :: tile
      type(store_t), intent(inout) :: store
      integer :: cell, p, q, node, upper(3)

      call locate_particles_plainly(space, method, scratch, store, tile)
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
   subroutine add_contact_heat(grid, method, nodes, scratch, store, tile)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(nodes_t), intent(in) :: nodes
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      real(wp) :: lost
      integer :: p, q

      associate (rubbed => nodes%work%contact_heat(:, :, tile), shape => scratch%shape)
         if (.not. any(abs(rubbed) > 0.0_wp)) return
         call method%basis%gather_values(grid, shape, rubbed, shape%values)
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
