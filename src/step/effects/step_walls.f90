! SPDX-License-Identifier: BSD-3-Clause
!> Walls on the nodes of a tile: boundaries of the domain and rigid regions. Impulse and work of
!! walls and of gravity.
module step_walls
   use base_elementary, only: cross
   use base_kinds, only: wp
   use mesh_rigid, only: held_t
   use mesh_wall, only: wall_t
   use mesh_wall_sums, only: wall_push_t
   use step_dissipation, only: damps, record_damped
   use step_ledger, only: external_work, impulse, ledger_t, torque
   use step_simulation, only: scheme_t, scratch_t, simulation_t, space_t, velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   implicit none
   private

   public :: apply_walls, constrain_tile, hold_at_walls, number_of_walls, pair_row, record_push, &
      record_stopped, record_unbalanced, record_walls, remove_wall_components, start_walls, &
      stop_at_walls, walls_touch

   !> Stages of the action of walls on nodes, in this order: forces, prescribed velocities,
   !! friction.
   integer, parameter :: forcing = 1, holding = 2, rubbing = 3, stages = 3

contains

   !> Set walls that move, or act for a time, at the time of the step, and find the nodes in rigid
   !! regions.
   subroutine start_walls(simulation, kick)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: kick                   !! Time that forces act, 0 = none [s]
      real(wp) :: lag
      logical :: switched

      call start_sums(simulation)
      switched = .false.
      lag = simulation%scheme%method%lag(simulation%clock%dt)
      if (allocated(simulation%space%boundary%wall)) &
         call simulation%space%boundary%advance(simulation%clock%time, lag, kick, switched)
      if (.not. allocated(simulation%space%rigid)) return
      simulation%space%rigid%switched = simulation%space%rigid%switched .or. switched
      call simulation%space%rigid%advance(simulation%clock%time, lag, kick)
      if (simulation%space%rigid%looked == simulation%clock%step) return
      simulation%space%rigid%looked = simulation%clock%step
      call find_held(simulation)
   end subroutine start_walls

   !> Clear the sum of unbalanced forces, and allocate the sums of the threads, if an output shows
   !! wall forces.
   pure subroutine start_sums(simulation)
      type(simulation_t), intent(inout) :: simulation
      integer :: thread

      do thread = 0, ubound(simulation%scratch, 1)
         if (allocated(simulation%scratch(thread)%unbalanced)) &
            call simulation%scratch(thread)%unbalanced%clear()
      end do
      if (.not. allocated(simulation%balance%ledger%walls%total)) return
      if (allocated(simulation%scratch(0)%ledger%walls%total)) return
      do thread = 0, ubound(simulation%scratch, 1)
         call simulation%scratch(thread)%ledger%walls%start( &
            size(simulation%balance%ledger%walls%total, 2))
      end do
   end subroutine start_sums

   !> Find the nodes in rigid regions.
   subroutine find_held(simulation)
      type(simulation_t), intent(inout) :: simulation !! Has rigid regions
      type(held_t), allocatable :: longer(:)
      real(wp) :: began
      integer :: tile

      associate (rigid => simulation%space%rigid, all => simulation%space%tiles%all)
         if (.not. allocated(rigid%held)) allocate (rigid%held(0))
         if (size(rigid%held) < all) then
            allocate (longer(all + all/4))
            longer(:size(rigid%held)) = rigid%held
            call move_alloc(longer, rigid%held)
         end if
      end associate
      !$omp parallel do default(none) shared(simulation) private(began, tile) schedule(dynamic)
      do tile = 1, simulation%space%tiles%all
         began = cost_clock(simulation%machine)
         call simulation%space%rigid%hold(simulation%space%grid, simulation%space%boundary, &
            simulation%space%tiles%coordinate(:, tile), simulation%space%rigid%held(tile))
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
      simulation%space%rigid%switched = .false.
   end subroutine find_held

   !> True if a wall acts on some node of a tile.
   pure logical function walls_touch(simulation, tile) result(touch)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile

      touch = simulation%space%boundary%touches(simulation%space%grid, &
         simulation%space%tiles%coordinate(:, tile))
      if (touch .or. .not. allocated(simulation%space%rigid)) return
      touch = simulation%space%rigid%holds(tile)
   end function walls_touch

   !> Impose the walls on the velocities of a tile, and compute the velocity that particles gain
   !! from each node because of them. Equation (R.5) of doc/theory/rigid.md. Equation (L.3) of
   !! doc/theory/ledger.md.
   pure subroutine apply_walls(simulation, tile, dt, velocity, acceleration, push, &
      work, each)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp), intent(out) :: push(:, :)            !! (3, node) [m/s]
      real(wp), intent(out) :: work(:) !! (node) Besides that of the force [J/kg]
      type(wall_push_t), intent(inout), optional :: each !! Force of each wall, if requested
      real(wp) :: free_velocity(3, size(push, 2)), free_acceleration(3, size(push, 2)), share
      integer :: stage, wall

      share = 1.0_wp - simulation%scheme%method%transfer%flip_fraction()
      free_velocity = velocity
      free_acceleration = acceleration
      if (present(each)) call each%begin(number_of_walls(simulation%space), dt, share, velocity, &
         acceleration)
      do stage = 1, stages
         if (.not. stage_acts(simulation, stage, dt)) cycle
         if (present(each)) then
            if (allocated(simulation%space%boundary%wall)) then
               do wall = 1, size(simulation%space%boundary%wall)
                  call apply_boundary(simulation, tile, stage, dt, free_velocity, velocity, &
                     acceleration, wall)
                  call each%note(wall, velocity, acceleration)
               end do
            end if
         else
            call apply_boundary(simulation, tile, stage, dt, free_velocity, velocity, acceleration)
         end if
         if (.not. allocated(simulation%space%rigid)) cycle
         call apply_rigid(simulation, tile, stage, dt, free_velocity, velocity, acceleration)
         if (.not. present(each)) cycle
         if (simulation%space%rigid%holds(tile)) call each%note_nodes( &
            number_of_walls(simulation%space) - size(simulation%space%rigid%wall), &
            simulation%space%rigid%held(tile)%node, simulation%space%rigid%held(tile)%wall, &
            velocity, acceleration)
      end do
      push = dt*(acceleration - free_acceleration) + share*(velocity - free_velocity)
      ! particles get the gain of a node relative to the velocity that they brought to it, not to
      ! that of the wall
      work = (1.0_wp - 0.5_wp*share)*dt*sum(acceleration*(free_velocity - velocity), dim=1)
   end subroutine apply_walls

   !> Impose the walls and record the work of walls and gravity. A tile records the part due to its
   !! own particles at each node, so that all parts add up to the value of the node.
   subroutine constrain_tile(simulation, field, scratch, tile, dt, mass, velocity, acceleration)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), intent(in) :: mass(:)                !! (node) [kg]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: push(3, size(mass)), work(size(mass))
      real(wp), allocatable :: brought(:, :), drag(:, :)
      type(wall_push_t) :: each
      logical :: keeps, ruled

      ruled = walls_touch(simulation, tile)
      if (.not. (ruled .or. allocated(simulation%effects%gravity) .or. &
         simulation%effects%damping > 0.0_wp)) return
      push = 0.0_wp
      work = 0.0_wp
      keeps = ruled .and. dt > 0.0_wp .and. tile <= simulation%space%tiles%own &
         .and. allocated(field%nodes%work%taken)
      if (keeps) field%nodes%work%taken(:, :, tile) = velocity
      if (simulation%effects%damping > 0.0_wp) drag = -dt*simulation%effects%damping*velocity
      if (ruled .and. dt > 0.0_wp .and. tile <= simulation%space%tiles%own .and. &
         damps(simulation%scheme%method, simulation%scheme%carries_energy) .and. .not. keeps) &
            brought = velocity
      if (ruled .and. dt > 0.0_wp .and. tile <= simulation%space%tiles%own .and. &
         allocated(scratch%ledger%walls%total)) then
         call apply_walls(simulation, tile, dt, velocity, acceleration, push, work, each)
         call record_walls(simulation%space, field, scratch%ledger, tile, each)
      else if (ruled) then
         call apply_walls(simulation, tile, dt, velocity, acceleration, push, work)
      end if
      if (allocated(brought)) call record_stopped(simulation%space, simulation%scheme, field, &
         scratch%ledger, tile, &
         velocity - brought, velocity + dt*acceleration)
      if (keeps) field%nodes%work%taken(:, :, tile) = field%nodes%work%taken(:, :, tile) - velocity
      if (tile > simulation%space%tiles%own .or. .not. dt > 0.0_wp) return
      if (allocated(drag)) push = push + drag
      if (allocated(simulation%effects%gravity)) then
         push(1, :) = push(1, :) + dt*simulation%effects%gravity(1)
         push(2, :) = push(2, :) + dt*simulation%effects%gravity(2)
         push(3, :) = push(3, :) + dt*simulation%effects%gravity(3)
      end if
      if (allocated(field%nodes%work%push)) then
         ! contact and musl will change the velocities of this work
         field%nodes%work%push(:, :, tile) = push
         return
      end if
      call record_push(simulation%space, field, scratch%ledger, tile, push, &
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
   pure logical function stage_acts(simulation, stage, dt) result(acts)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: stage
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]

      select case (stage)
      case (forcing)
         acts = dt > 0.0_wp .and. simulation%space%boundary%absorbs_waves()
      case (rubbing)
         acts = dt > 0.0_wp .or. simulation%clock%dt > 0.0_wp
      case default
         acts = .true.
      end select
   end function stage_acts

   !> Apply a stage of boundaries, all of them or one.
   pure subroutine apply_boundary(simulation, tile, stage, dt, free, velocity, acceleration, only)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      integer, intent(in) :: stage                   !! forcing, holding or rubbing
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer, intent(in), optional :: only          !! Wall that acts; default: all

      associate (coordinate => simulation%space%tiles%coordinate(:, tile), &
         grid => simulation%space%grid, boundary => simulation%space%boundary)
         select case (stage)
         case (forcing)
            call boundary%add_forces(grid, coordinate, dt, velocity, acceleration, only)
         case (rubbing)
            if (boundary%has_friction()) call boundary%apply_friction(grid, coordinate, &
               merge(dt, simulation%clock%dt, dt > 0.0_wp), &
               1.0_wp - simulation%scheme%method%transfer%flip_fraction(), free, velocity, &
               acceleration, only)
         case default
            call boundary%constrain(grid, coordinate, velocity, acceleration, only=only)
         end select
      end associate
   end subroutine apply_boundary

   !> Apply a stage of rigid regions.
   pure subroutine apply_rigid(simulation, tile, stage, dt, free, velocity, acceleration)
      type(simulation_t), intent(in) :: simulation   !! Has rigid regions
      integer, intent(in) :: tile
      integer, intent(in) :: stage                   !! forcing, holding or rubbing
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]

      if (stage == holding) call simulation%space%rigid%constrain(tile, velocity, acceleration, &
         at_end=.false.)
      if (stage == rubbing) call simulation%space%rigid%rub(tile, merge(dt, simulation%clock%dt, &
         dt > 0.0_wp), 1.0_wp - simulation%scheme%method%transfer%flip_fraction(), free, velocity, &
         acceleration)
   end subroutine apply_rigid

   !> Record the impulse and work of each wall on the nodes of a tile. Equation (O.2) of
   !! doc/theory/instruments.md.
   subroutine record_walls(space, field, ledger, tile, each)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: field
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: tile
      type(wall_push_t), intent(in) :: each          !! Force of each wall
      real(wp) :: own(field%nodes%motion%packed(1)%rows, size(each%velocity, 2))
      real(wp) :: total(3)
      integer :: before, node, wall

      call field%nodes%motion%packed(1)%get(space%grid, field%nodes%motion%touched, tile, own)
      before = 0
      if (allocated(space%boundary%wall)) before = size(space%boundary%wall)
      do wall = 1, size(each%gain, 3)
         total = 0.0_wp
         do node = 1, size(own, 2)
            if (.not. own(1, node) > 0.0_wp) cycle
            total = total + own(1, node)*each%gain(:, node, wall)
         end do
         if (.not. maxval(abs(total)) > 0.0_wp) cycle
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
   subroutine record_unbalanced(space, field, scratch, tile, acceleration)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: acceleration(:, :)     !! (3, node) [m/s2]
      real(wp) :: own(field%nodes%motion%packed(1)%rows, size(acceleration, 2)), total
      integer :: node

      call field%nodes%motion%packed(1)%get(space%grid, field%nodes%motion%touched, tile, own)
      total = 0.0_wp
      do node = 1, size(own, 2)
         if (own(1, node) > 0.0_wp) total = total + own(1, node)*norm2(acceleration(:, node))
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

   !> Where a wall with friction, or a rigid region, constrained a node in the step, it also
   !! constrains the straining velocity after the step. A one-sided condition would let the noise of
   !! particles lift pressed material off the wall, step by step.
   pure subroutine hold_at_walls(simulation, field, tile, velocity)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Mapped again [m/s]
      real(wp) :: ended(3, size(velocity, 2))

      if (.not. (simulation%space%boundary%has_friction() .or. &
         allocated(simulation%space%rigid))) return
      if (.not. walls_touch(simulation, tile)) return
      ended = field%nodes%motion%velocity(:, :, tile) &
         + simulation%clock%kick*field%nodes%motion%acceleration(:, :, tile)
      if (simulation%space%boundary%has_friction()) call &
         simulation%space%boundary%hold_pressed(simulation%space%grid, &
         simulation%space%tiles%coordinate(:, tile), ended, velocity)
      if (allocated(simulation%space%rigid)) call simulation%space%rigid%keep(tile, ended, velocity)
   end subroutine hold_at_walls

   !> Impose the walls on the velocities after the step, and correct the change of the velocities
   !! accordingly.
   pure subroutine stop_at_walls(simulation, tile, velocity, change)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: change(:, :)   !! (3, node) [m/s2] or [m/s]

      call simulation%space%boundary%constrain(simulation%space%grid, &
         simulation%space%tiles%coordinate(:, tile), &
         velocity, change, at_end=.true.)
      if (allocated(simulation%space%rigid)) &
         call simulation%space%rigid%constrain(tile, velocity, change, at_end=.true.)
   end subroutine stop_at_walls

   !> Remove from a change of node velocities the components that walls prescribed or changed before
   !! the forces act: an orthogonal projection. A wall that prescribes the velocity of a node in a
   !! step does so from the start of the step.
   pure subroutine remove_wall_components(simulation, tile, velocity, change, each)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :)  !! (3, node) Before forces act [m/s]
      real(wp), contiguous, intent(inout) :: change(:, :) !! (3, node) [m/s]
      type(wall_push_t), intent(inout), optional :: each !! Change by each wall, if requested
      real(wp) :: moved(3, size(change, 2)), open(3, size(change, 2))
      integer :: wall

      moved = velocity
      open = 1.0_wp
      if (present(each)) then
         call each%begin(number_of_walls(simulation%space), 1.0_wp, 0.0_wp, moved, change)
         if (allocated(simulation%space%boundary%wall)) then
            do wall = 1, size(simulation%space%boundary%wall)
               call close_components(simulation%space, tile, velocity, moved, open, wall)
               call each%note(wall, moved, change*open)
            end do
         end if
      else
         call close_components(simulation%space, tile, velocity, moved, open)
      end if
      change = change*open
      if (.not. allocated(simulation%space%rigid)) return
      call simulation%space%rigid%take(tile, velocity, open, change)
      if (.not. present(each)) return
      if (simulation%space%rigid%holds(tile)) call each%note_nodes( &
         number_of_walls(simulation%space) - size(simulation%space%rigid%wall), &
         simulation%space%rigid%held(tile)%node, simulation%space%rigid%held(tile)%wall, moved, &
         change)
   end subroutine remove_wall_components

   !> Clear the mask of velocity components that boundaries prescribe, all boundaries or one.
   pure subroutine close_components(space, tile, velocity, moved, open, only)
      type(space_t), intent(in) :: space
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) Before forces act [m/s]
      real(wp), contiguous, intent(inout) :: moved(:, :) !! (3, node) Velocity with walls [m/s]
      real(wp), contiguous, intent(inout) :: open(:, :)  !! (3, node) Set to 0 where prescribed
      integer, intent(in), optional :: only          !! Wall that acts; default: all

      associate (coordinate => space%tiles%coordinate(:, tile))
         call space%boundary%constrain(space%grid, coordinate, moved, open, at_end=.true., &
            only=only)
         if (space%boundary%has_friction()) call space%boundary%hold_pressed(space%grid, &
            coordinate, velocity, open, only)
      end associate
   end subroutine close_components

   !> The energy that walls remove through the PIC fraction is part of their work and also of the
   !! recorded dissipation of the PIC fraction, so it is subtracted from the work. Equation (L.13)
   !! of doc/theory/ledger.md.
   subroutine record_stopped(space, scheme, field, ledger, tile, change, velocity)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: change(:, :)           !! (3, node) Change by walls [m/s]
      real(wp), intent(in) :: velocity(:, :) !! (3, node) Velocity for the recorded work [m/s]
      real(wp) :: own(field%nodes%motion%packed(1)%rows, size(change, 2)), stopped
      integer :: node

      call field%nodes%motion%packed(1)%get(space%grid, field%nodes%motion%touched, tile, own)
      stopped = 0.0_wp
      do node = 1, size(change, 2)
         stopped = stopped + own(1, node)*dot_product(change(:, node), velocity(:, node))
      end do
      call record_damped(ledger, (1.0_wp - scheme%method%transfer%flip_fraction())*stopped)
   end subroutine record_stopped

   !> Record impulse, its moment, and work of an impulse on the nodes of a tile.
   subroutine record_push(space, field, ledger, tile, push, velocity, more)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: field
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: push(:, :)             !! (3, node) Gain of velocity [m/s]
      real(wp), intent(in) :: velocity(:, :)         !! (3, node) In the middle of the step [m/s]
      real(wp), intent(in), optional :: more(:) !! (node) Work besides that of the force [J/kg]
      real(wp) :: own(field%nodes%motion%packed(1)%rows, size(push, 2))
      real(wp) :: total(3), turn(3), work, part(3), corner(3), place(3)
      integer :: node, k

      total = 0.0_wp
      turn = 0.0_wp
      work = 0.0_wp
      corner = space%grid%tile_corner(space%tiles%coordinate(:, tile))
      call field%nodes%motion%packed(1)%get(space%grid, field%nodes%motion%touched, tile, own)
      do node = 1, size(push, 2)
         ! faces push few of the nodes
         if (.not. abs(push(1, node)) + abs(push(2, node)) + abs(push(3, node)) > 0.0_wp) cycle
         if (.not. own(1, node) > 0.0_wp) cycle
         part = own(1, node)*push(:, node)
         place = corner + space%grid%spacing*real(space%grid%node_position(node), wp)
         total = total + part
         turn = turn + cross(place, part)
         work = work + dot_product(part, velocity(:, node))
         if (present(more)) work = work + own(1, node)*more(node)
      end do
      do k = 1, 3
         call ledger%sums(impulse + k - 1)%add(total(k))
         call ledger%sums(torque + k - 1)%add(turn(k))
      end do
      call ledger%sums(external_work)%add(work)
   end subroutine record_push
end module step_walls
