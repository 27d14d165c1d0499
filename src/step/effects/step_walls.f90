! SPDX-License-Identifier: BSD-3-Clause
!> Walls on the nodes of a tile: boundaries of the domain and rigid regions. Impulse and work of
!! walls and of gravity.
module step_walls
   use base_elementary, only: cross
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_boundary, only: boundary_t
   use mesh_hilbert, only: hilbert_key
   use mesh_rigid, only: held_t
   use mesh_wall, only: wall_t
   use mesh_wall_sums, only: wall_entries, wall_push_t
   use step_body_impulses, only: record_bodies, record_turning
   use step_dissipation, only: measures_damping, record_damped
   use step_ledger, only: ledger_t
   use step_method, only: method_t
   use step_node_fields, only: motion_nodes_t, nodes_t
   use step_simulation, only: clock_t, machine_t, scheme_t, scratch_t, simulation_effects_t, space_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: apply_boundaries, apply_walls, constrain_tile, hold_at_walls, pair_row, record_push, &
      record_stopped, record_unbalanced, record_walls, start_walls, &
      stop_at_walls, walls_touch

   !> Stages of the action of walls on nodes, in this order: forces, prescribed velocities,
   !! contact with friction.
   integer, parameter :: forcing = 1, holding = 2, rubbing = 3, stages = 3

contains

   !> Set walls that move, or act for a time, at the time of the step, and find the nodes in rigid
   !! regions.
   subroutine start_walls(space, method, clock, ledger, machine, scratches, kick)
      type(space_t), intent(inout) :: space
      type(method_t), intent(in) :: method
      type(clock_t), intent(in) :: clock
      type(ledger_t), intent(inout) :: ledger
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      real(wp), intent(in) :: kick                   !! Time that forces act, 0 = none [s]
      real(wp) :: lag
      logical :: switched

      call start_sums(ledger, scratches)
      switched = .false.
      lag = method%lag(clock%dt)
      if (allocated(space%boundary%wall)) call space%boundary%advance(clock%time, lag, &
         kick, switched)
      if (.not. allocated(space%rigid)) return
      space%rigid%switched = space%rigid%switched .or. switched
      call space%rigid%advance(clock%time, lag, kick)
      if (space%rigid%looked == clock%step) return
      space%rigid%looked = clock%step
      call find_held(space, machine)
   end subroutine start_walls

   !> Clear the sum of unbalanced forces, and allocate the sums of the threads, if an output shows
   !! wall forces.
   pure subroutine start_sums(ledger, scratches)
      type(ledger_t), intent(inout) :: ledger
      type(scratch_t), intent(inout) :: scratches(0:)
      integer :: thread

      do thread = 0, ubound(scratches, 1)
         if (allocated(scratches(thread)%unbalanced)) call scratches(thread)%unbalanced%clear()
      end do
      if (.not. allocated(ledger%walls%total)) return
      if (allocated(scratches(0)%ledger%walls%total)) return
      do thread = 0, ubound(scratches, 1)
         call scratches(thread)%ledger%walls%start(size(ledger%walls%total, 2))
      end do
   end subroutine start_sums

   !> Find the nodes in rigid regions.
   subroutine find_held(space, machine)
      type(space_t), intent(inout) :: space
      type(machine_t), intent(inout) :: machine
      type(held_t), allocatable :: longer(:)
      integer :: tile

      associate (rigid => space%rigid, all => space%tiles%all)
         if (.not. allocated(rigid%held)) allocate (rigid%held(0))
         if (size(rigid%held) < all) then
            allocate (longer(all + all/4))
            longer(:size(rigid%held)) = rigid%held
            call move_alloc(longer, rigid%held)
         end if
      end associate
      call follow_tiles(space)
      !$omp parallel do default(none) shared(space, machine) private(tile) schedule(dynamic)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call space%rigid%hold(space%grid, space%boundary, space%tiles%coordinate(:, tile), &
            space%rigid%held(tile))
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      ! nodes of tiles that may come back are not those of the regions that act now
      if (space%rigid%switched) then
         do tile = space%tiles%all + 1, size(space%rigid%held)
            space%rigid%held(tile)%coordinate = -1
         end do
      end if
      space%rigid%switched = .false.
   end subroutine find_held

   !> Move the nodes in rigid regions to the new numbers of their tiles: to find their normals takes
   !! longer than many steps, and a new tile changes the numbers of all tiles behind it.
   subroutine follow_tiles(space)
      type(space_t), intent(inout) :: space
      type(held_t), allocatable :: moved(:)
      integer :: former, tile

      associate (held => space%rigid%held, tiles => space%tiles)
         do tile = 1, tiles%all
            if (any(held(tile)%coordinate /= tiles%coordinate(:, tile))) exit
         end do
         if (tile > tiles%all) return
         allocate (moved(size(held)))
         do former = 1, size(held)
            if (any(held(former)%coordinate < 0)) cycle
            tile = tiles%table%find(hilbert_key(held(former)%coordinate, space%grid%dimensions))
            if (tile == 0) cycle
            moved(tile)%coordinate = held(former)%coordinate
            moved(tile)%moves = held(former)%moves
            call move_alloc(held(former)%node, moved(tile)%node)
            call move_alloc(held(former)%wall, moved(tile)%wall)
            call move_alloc(held(former)%normal, moved(tile)%normal)
            call move_alloc(held(former)%place, moved(tile)%place)
         end do
      end associate
      call move_alloc(moved, space%rigid%held)
   end subroutine follow_tiles

   !> True if a wall acts on some node of a tile.
   pure logical function walls_touch(space, tile) result(touch)
      type(space_t), intent(in) :: space
      integer, intent(in) :: tile

      touch = space%boundary%touches(space%grid, space%tiles%coordinate(:, tile))
      if (touch .or. .not. allocated(space%rigid)) return
      touch = space%rigid%holds(tile)
   end function walls_touch

   !> Impose the walls on the velocities of a tile, and compute the velocity that particles gain
   !! from each node because of them. Equation (R.5) of doc/theory/rigid.md. Equation (L.3) of
   !! doc/theory/ledger.md.
   pure subroutine apply_walls(space, method, clock, tile, dt, velocity, acceleration, &
      push, work, each)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(clock_t), intent(in) :: clock
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp), intent(out) :: push(:, :)            !! (3, node) [m/s]
      real(wp), intent(out) :: work(:) !! (node) Besides that of the force [J/kg]
      type(wall_push_t), intent(inout), optional :: each !! Force of each wall, if requested
      real(wp) :: free_velocity(3, size(push, 2)), free_acceleration(3, size(push, 2)), share
      integer :: stage, wall

      share = 1.0_wp - method%transfer%flip_fraction()
      free_velocity = velocity
      free_acceleration = acceleration
      if (present(each)) call each%begin(number_of_walls(space), dt, share, velocity, acceleration)
      do stage = 1, stages
         if (.not. stage_acts(space%boundary, clock, stage, dt)) cycle
         if (present(each)) then
            if (allocated(space%boundary%wall)) then
               do wall = 1, size(space%boundary%wall)
                  call apply_boundary(space, method, clock, tile, stage, dt, free_velocity, &
                     velocity, acceleration, wall)
                  call each%note(wall, velocity, acceleration)
               end do
            end if
         else
            call apply_boundary(space, method, clock, tile, stage, dt, free_velocity, &
               velocity, acceleration)
         end if
         if (.not. allocated(space%rigid)) cycle
         ! apply a stage of rigid regions
         if (stage == holding) call space%rigid%constrain(tile, velocity, acceleration, &
            at_end=.false.)
         if (stage == rubbing) call space%rigid%rub(tile, merge(dt, clock%dt, dt > 0.0_wp), &
            1.0_wp - method%transfer%flip_fraction(), free_velocity, velocity, acceleration)
         if (.not. present(each)) cycle
         if (space%rigid%holds(tile)) call each%note_nodes(number_of_walls(space) &
            - size(space%rigid%wall), space%rigid%held(tile)%node, space%rigid%held(tile)%wall, &
            velocity, acceleration)
      end do
      push = dt*(acceleration - free_acceleration) + share*(velocity - free_velocity)
      ! particles get the gain of a node relative to the velocity that they brought to it, not to
      ! that of the wall
      work = (1.0_wp - 0.5_wp*share)*dt*sum(acceleration*(free_velocity - velocity), dim=1)
   end subroutine apply_walls

   !> Impose the walls and record the work of walls and gravity. A tile records the part due to its
   !! own particles at each node, so that all parts add up to the value of the node.
   subroutine constrain_tile(space, scheme, effects, clock, nodes, scratch, tile, dt, &
      velocity, acceleration)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(clock_t), intent(in) :: clock
      type(nodes_t), intent(inout) :: nodes
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: push(3, size(velocity, 2)), work(size(velocity, 2))
      real(wp), allocatable :: brought(:, :), drag(:, :)
      type(wall_push_t) :: each
      logical :: keeps, ruled

      ruled = walls_touch(space, tile)
      if (.not. (ruled .or. allocated(effects%gravity) .or. effects%damping > 0.0_wp)) return
      push = 0.0_wp
      work = 0.0_wp
      keeps = ruled .and. dt > 0.0_wp .and. tile <= space%tiles%own .and. &
         allocated(nodes%work%velocity_removed)
      if (keeps) nodes%work%velocity_removed(:, :, tile) = velocity
      if (effects%damping > 0.0_wp) drag = -dt*effects%damping*velocity
      if (ruled .and. dt > 0.0_wp .and. tile <= space%tiles%own .and. &
         measures_damping(scheme%method, scheme%carries_energy) .and. .not. keeps) &
         brought = velocity
      if (ruled .and. dt > 0.0_wp .and. tile <= space%tiles%own .and. &
         (allocated(scratch%ledger%walls%total) .or. allocated(scratch%bodies))) then
         call apply_walls(space, scheme%method, clock, tile, dt, velocity, acceleration, &
            push, work, each)
         if (allocated(scratch%ledger%walls%total)) &
            call record_walls(space, nodes%motion, scratch%ledger, tile, each)
         if (allocated(scratch%bodies)) then
            if (space%rigid%meets_body(tile)) &
               call record_bodies(space, nodes%motion, number_of_walls(space) &
               - size(space%rigid%wall), scratch%bodies, tile, each)
         end if
      else if (ruled) then
         call apply_walls(space, scheme%method, clock, tile, dt, velocity, acceleration, push, work)
      end if
      if (allocated(brought)) call record_stopped(space%grid, scheme%method, nodes%motion, &
         scratch%ledger, tile, velocity - brought, velocity + dt*acceleration)
      if (keeps) nodes%work%velocity_removed(:, :, tile) = nodes%work%velocity_removed(:, :, tile) &
         - velocity
      if (tile > space%tiles%own .or. .not. dt > 0.0_wp) return
      if (allocated(drag)) push = push + drag
      if (allocated(effects%gravity)) then
         push(1, :) = push(1, :) + dt*effects%gravity(1)
         push(2, :) = push(2, :) + dt*effects%gravity(2)
         push(3, :) = push(3, :) + dt*effects%gravity(3)
      end if
      if (allocated(nodes%work%velocity_change)) then
         ! contact and musl will change the velocities of this work
         nodes%work%velocity_change(:, :, tile) = push
         return
      end if
      call record_push(space, nodes%motion, scratch%ledger, tile, push, &
         velocity + 0.5_wp*dt*acceleration, work)
   end subroutine constrain_tile

   !> Number of walls: boundaries and their parts, and rigid regions.
   pure integer function number_of_walls(space) result(number)
      type(space_t), intent(in) :: space

      number = 0
      if (allocated(space%boundary%wall)) number = size(space%boundary%wall)
      if (allocated(space%rigid)) number = number + size(space%rigid%wall)
   end function number_of_walls

   !> Row of the contact of two velocity fields a < b among the sums of walls. With n fields there
   !! are pair_row(space, 0, n + 1) rows.
   pure integer function pair_row(space, a, b) result(row)
      type(space_t), intent(in) :: space
      integer, intent(in) :: a, b                    !! Indices of the velocity fields

      row = number_of_walls(space) + ((b - 1)*(b - 2))/2 + a
   end function pair_row

   !> True if walls may act in a stage. Friction also acts in the strain before the forces, from the
   !! second step on: nodes that were pressed on a wall must not move away from it.
   pure logical function stage_acts(boundary, clock, stage, dt) result(acts)
      type(boundary_t), intent(in) :: boundary
      type(clock_t), intent(in) :: clock
      integer, intent(in) :: stage
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]

      select case (stage)
      case (forcing)
         acts = dt > 0.0_wp .and. boundary%absorbs_waves()
      case (rubbing)
         acts = dt > 0.0_wp .or. clock%dt > 0.0_wp
      case default
         acts = .true.
      end select
   end function stage_acts

   !> Impose on a tile what acts before the rigid regions: forces and velocities of boundaries.
   pure subroutine apply_boundaries(space, method, clock, tile, dt, velocity, acceleration)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(clock_t), intent(in) :: clock
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: free(3, size(velocity, 2))
      integer :: stage

      free = velocity
      do stage = forcing, holding
         if (stage_acts(space%boundary, clock, stage, dt)) call apply_boundary(space, method, &
            clock, tile, stage, dt, free, velocity, acceleration)
      end do
   end subroutine apply_boundaries

   !> Apply a stage of boundaries, all of them or one.
   pure subroutine apply_boundary(space, method, clock, tile, stage, dt, free, velocity, &
      acceleration, only)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(clock_t), intent(in) :: clock
      integer, intent(in) :: tile
      integer, intent(in) :: stage                   !! forcing, holding or rubbing
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer, intent(in), optional :: only          !! Wall that acts; default: all

      associate (coordinate => space%tiles%coordinate(:, tile), grid => space%grid, &
         boundary => space%boundary)
         select case (stage)
         case (forcing)
            call boundary%add_forces(grid, coordinate, dt, velocity, acceleration, only)
         case (rubbing)
            if (boundary%separates()) call boundary%press(grid, coordinate, tile, &
               merge(dt, clock%dt, dt > 0.0_wp), 1.0_wp - method%transfer%flip_fraction(), free, &
               velocity, acceleration, only)
         case default
            call boundary%constrain(grid, coordinate, tile, velocity, acceleration, &
               only=only)
         end select
      end associate
   end subroutine apply_boundary

   !> Record the impulse and work of each wall on the nodes of a tile. Equation (O.2) of
   !! doc/theory/instruments.md.
   subroutine record_walls(space, motion, ledger, tile, each)
      type(space_t), intent(in) :: space
      type(motion_nodes_t), intent(in) :: motion
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: tile
      type(wall_push_t), intent(in) :: each          !! Force of each wall
      real(wp) :: own(size(each%velocity, 2))
      real(wp) :: total(3)
      integer :: before, node, wall

      call motion%own_mass(space%grid, tile, own)
      before = 0
      if (allocated(space%boundary%wall)) before = size(space%boundary%wall)
      do wall = 1, size(each%gain, 3)
         total = 0.0_wp
         do node = 1, size(own)
            if (.not. own(node) > 0.0_wp) cycle
            total = total + own(node)*each%gain(:, node, wall)
         end do
         if (.not. maxval(abs(total)) > 0.0_wp) cycle
         if (wall > before) call record_turning(space%rigid%held(tile), own, &
            each%gain(:, :, wall), wall - before, space%rigid%wall(wall - before), &
            ledger%walls%total(wall_entries, wall))
         if (wall <= before) then
            call ledger%walls%add(wall, total, middle_velocity(space%boundary%wall(wall), each%dt))
         else
            call ledger%walls%add(wall, total, &
               middle_velocity(space%rigid%wall(wall - before), each%dt))
         end if
      end do
   end subroutine record_walls

   !> Record the unbalanced force of the nodes of a tile: the part due to its own particles, by
   !! their mass times acceleration. Equation (O.7) of doc/theory/instruments.md.
   subroutine record_unbalanced(grid, motion, scratch, tile, acceleration)
      type(grid_t), intent(in) :: grid
      type(motion_nodes_t), intent(in) :: motion
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: acceleration(:, :)     !! (3, node) [m/s2]
      real(wp) :: own(size(acceleration, 2)), total
      integer :: node

      call motion%own_mass(grid, tile, own)
      total = 0.0_wp
      do node = 1, size(own)
         if (own(node) > 0.0_wp) total = total + own(node)*norm2(acceleration(:, node))
      end do
      call scratch%unbalanced%add(total)
   end subroutine record_unbalanced

   !> Velocity of a wall in the middle of the step [m/s].
   pure function middle_velocity(wall, dt) result(velocity)
      type(wall_t), intent(in) :: wall
      real(wp), intent(in) :: dt                     !! Time that forces act [s]
      real(wp) :: velocity(3)

      velocity = wall%condition%velocity + 0.5_wp*dt*wall%condition%acceleration
   end function middle_velocity

   !> Where a wall from which material may separate pressed on a node in the step, it also
   !! constrains the straining velocity after the step. A one-sided condition would let the noise of
   !! particles lift pressed material off the wall, step by step.
   pure subroutine hold_at_walls(space, clock, motion, tile, velocity)
      type(space_t), intent(in) :: space
      type(clock_t), intent(in) :: clock
      type(motion_nodes_t), intent(in) :: motion
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Mapped again [m/s]
      real(wp) :: ended(3, size(velocity, 2))

      if (.not. (space%boundary%separates() .or. allocated(space%rigid))) return
      if (.not. walls_touch(space, tile)) return
      ended = motion%velocity(:, :, tile) + clock%kick*motion%acceleration(:, :, tile)
      if (space%boundary%separates()) call space%boundary%hold_pressed(space%grid, &
         space%tiles%coordinate(:, tile), tile, ended, velocity)
      if (allocated(space%rigid)) call space%rigid%keep(tile, ended, velocity)
   end subroutine hold_at_walls

   !> Impose the walls on the velocities after the step, and correct the change of the velocities
   !! accordingly.
   pure subroutine stop_at_walls(space, tile, velocity, change)
      type(space_t), intent(in) :: space
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: change(:, :)   !! (3, node) [m/s2] or [m/s]

      call space%boundary%constrain(space%grid, space%tiles%coordinate(:, tile), tile, velocity, &
         change, at_end=.true.)
      if (allocated(space%rigid)) call space%rigid%constrain(tile, velocity, change, at_end=.true.)
   end subroutine stop_at_walls

   !> The energy that walls remove through the PIC fraction is part of their work and also of the
   !! recorded dissipation of the PIC fraction, so it is subtracted from the work. Equation (L.12)
   !! of doc/theory/ledger.md.
   subroutine record_stopped(grid, method, motion, ledger, tile, change, velocity)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(motion_nodes_t), intent(in) :: motion
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: change(:, :)           !! (3, node) Change by walls [m/s]
      real(wp), intent(in) :: velocity(:, :) !! (3, node) Velocity for the recorded work [m/s]
      real(wp) :: own(size(change, 2)), stopped
      integer :: node

      call motion%own_mass(grid, tile, own)
      stopped = 0.0_wp
      do node = 1, size(change, 2)
         stopped = stopped + own(node)*dot_product(change(:, node), velocity(:, node))
      end do
      call record_damped(ledger, (1.0_wp - method%transfer%flip_fraction())*stopped)
   end subroutine record_stopped

   !> Record impulse, its moment, and work of an impulse on the nodes of a tile.
   subroutine record_push(space, motion, ledger, tile, push, velocity, more)
      type(space_t), intent(in) :: space
      type(motion_nodes_t), intent(in) :: motion
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: push(:, :)             !! (3, node) Gain of velocity [m/s]
      real(wp), intent(in) :: velocity(:, :)         !! (3, node) In the middle of the step [m/s]
      real(wp), intent(in), optional :: more(:) !! (node) Work besides that of the force [J/kg]
      real(wp) :: own(size(push, 2))
      real(wp) :: total(3), turn(3), work, part(3), corner(3), place(3)
      integer :: node

      total = 0.0_wp
      turn = 0.0_wp
      work = 0.0_wp
      corner = space%grid%tile_corner(space%tiles%coordinate(:, tile))
      call motion%own_mass(space%grid, tile, own)
      do node = 1, size(push, 2)
         ! faces push few of the nodes
         if (.not. abs(push(1, node)) + abs(push(2, node)) + abs(push(3, node)) > 0.0_wp) cycle
         if (.not. own(node) > 0.0_wp) cycle
         part = own(node)*push(:, node)
         place = corner + space%grid%spacing*real(space%grid%node_position(node), wp)
         total = total + part
         turn = turn + cross(place, part)
         work = work + dot_product(part, velocity(:, node))
         if (present(more)) work = work + own(node)*more(node)
      end do
      call ledger%record_impulse(total, turn, work)
   end subroutine record_push
end module step_walls
