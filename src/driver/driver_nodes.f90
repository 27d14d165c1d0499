! SPDX-License-Identifier: BSD-3-Clause
!> What happens on the nodes in a step. Every tile, own or ghost, works on all its nodes; nodes that
!! several tiles share get the same bits on each of them.
module driver_nodes
   use base_kinds, only: wp
   use driver_cost, only: book_cost, cost_clock
   use driver_ledger, only: cross, external_work, impulse, ledger_t, torque
   use driver_light_nodes, only: calm_light_nodes
   use driver_method, only: stress_after
   use driver_reach, only: look_at_tile, worse
   use driver_scatter, only: nodes_seen, tensor_rows, vector_rows
   use driver_simulation, only: empty_mass, nodes_t, reach_t, scratch_t, simulation_t
   use mesh_boundary, only: face_friction
   use mesh_patch, only: assemble, clear_patch, empty_box, ensure_patch, ensure_weights, widen_box
   use mesh_pieces, only: move_pieces, pieces_t
   use omp_lib, only: omp_get_thread_num
   use transfer_scatter, only: motion_columns
   implicit none
   private

   public :: book_push, divide, dual_fields, finish_nodes, move_nodes, node_gradient, recall_seen, &
      remap_nodes, renew_sums, start_nodes, strain_nodes

contains

   !> Weights and volumes of the dual gradient, and the force of the stress on the nodes.
   subroutine dual_fields(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: tile
      real(wp) :: began

      call simulation%timer%start(simulation%phase%grid)
      call ensure_dual(simulation)
      !$omp parallel do default(none) shared(simulation) private(tile, began) schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         call weigh_tile(simulation, tile)
         call book_cost(simulation, tile, began)
      end do
      !$omp end parallel do
      associate (nodes => simulation%nodes)
         call nodes%weighted%line_up(simulation%grid, simulation%tiles)
         call nodes%share%ensure(nodes%weighted%nodes())
         call nodes%force%ensure(nodes%weighted%nodes())
      end associate
      !$omp parallel do default(none) shared(simulation) private(tile, began) schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         call share_tile(simulation, tile)
         call book_cost(simulation, tile, began)
      end do
      !$omp end parallel do
      !$omp parallel do default(none) shared(simulation) private(tile, began) schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         call force_tile(simulation, tile)
         call book_cost(simulation, tile, began)
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine dual_fields

   !> Make room for the fields of the dual gradient, but for pieces whose boxes are not known yet.
   pure subroutine ensure_dual(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run

      associate (nodes => simulation%nodes, grid => simulation%grid, all => simulation%tiles%all)
         call ensure_sums(simulation)
         call ensure_weights(nodes%weight, grid%tile_cells, all)
         call nodes%weighted%ensure(all)
         call ensure_patch(nodes%volume, 1, grid%tile_nodes, slots(simulation))
         if (simulation%repacks) call ensure_patch(nodes%filled, 1, grid%tile_nodes, all)
         if (allocated(nodes%share%row)) return
         call nodes%share%keep(1, [.true.])
         call nodes%force%keep(3, vector_rows(grid))
         call nodes%gradient%keep(9, tensor_rows(grid))
         call nodes%middle%keep(9, tensor_rows(grid))
      end associate
   end subroutine ensure_dual

   !> Places for the fields of tiles that are worked on.
   pure integer function slots(simulation) result(number)
      type(simulation_t), intent(in) :: simulation   !! The run

      number = simulation%tiles%all
      if (simulation%nodes%lean) number = size(simulation%scratch)
   end function slots

   !> Make room for the sums over the particles around the nodes.
   pure subroutine ensure_sums(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run

      associate (nodes => simulation%nodes, number => simulation%grid%tile_nodes)
         call ensure_patch(nodes%mass, 1, number, slots(simulation))
         call ensure_patch(nodes%velocity, 3, number, slots(simulation))
         call ensure_patch(nodes%acceleration, 3, number, slots(simulation))
      end associate
   end subroutine ensure_sums

   !> Find the sums of the nodes of a tile: mass, momentum where the velocity will be, force where
   !! the acceleration will be.
   pure subroutine find_sums(simulation, tile, slot)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      integer, intent(in) :: slot                    !! Where its fields are
      real(wp) :: sums(simulation%nodes%motion(1)%rows, simulation%grid%tile_nodes)

      call simulation%nodes%motion(1)%assemble(simulation%grid, simulation%tiles, &
         simulation%nodes%touched, tile, sums)
      call keep_sums(simulation%nodes, slot, sums)
   end subroutine find_sums

   !> Keep the sums of the nodes of a tile.
   pure subroutine keep_sums(nodes, slot, sums)
      type(nodes_t), intent(inout) :: nodes          !! Gets them
      integer, intent(in) :: slot                    !! Where the fields of the tile are
      real(wp), intent(in) :: sums(:, :)             !! (column, node) Mass, momentum, force, more

      nodes%mass(1, :, slot) = sums(1, :)
      nodes%velocity(:, :, slot) = sums(2:4, :)
      nodes%acceleration(:, :, slot) = sums(5:7, :)
   end subroutine keep_sums

   !> Sums over the particles around the nodes as before the nodes were moved, if they are kept.
   subroutine renew_sums(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: tile

      if (simulation%nodes%lean) return
      !$omp parallel do default(none) shared(simulation) private(tile) schedule(static)
      do tile = 1, simulation%tiles%all
         call find_sums(simulation, tile, tile)
      end do
      !$omp end parallel do
   end subroutine renew_sums

   !> Weights of the cells of a tile.
   subroutine weigh_tile(simulation, tile)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      integer, parameter :: filled = 8               ! row of the patch
      real(wp) :: around(simulation%grid%tile_nodes)
      real(wp) :: sums(filled, simulation%grid%tile_nodes)
      logical :: weighs(simulation%grid%tile_cells)

      associate (grid => simulation%grid, nodes => simulation%nodes, &
         coordinate => simulation%tiles%coordinate(:, tile))
         call nodes%motion(1)%assemble(grid, simulation%tiles, nodes%touched, tile, sums)
         if (.not. nodes%lean) call keep_sums(nodes, tile, sums)
         if (simulation%repacks) nodes%filled(1, :, tile) = sums(filled, :)
         call grid%node_volume(coordinate, around)
         call simulation%dual%cell_weights(grid, sums, filled, around, nodes%weight(:, tile))
         call empty_box(nodes%weighted%box(:, :, tile))
         weighs = nodes%weight(:, tile) > 0.0_wp
         call widen_box(grid, weighs, nodes%weighted%box(:, :, tile))
      end associate
   end subroutine weigh_tile

   !> Share of the cells of a tile in the volumes of the nodes.
   subroutine share_tile(simulation, tile)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp) :: patch(1, simulation%grid%tile_nodes)

      associate (grid => simulation%grid, nodes => simulation%nodes)
         call clear_patch(patch)
         call simulation%dual%add_volume(grid, simulation%tiles%coordinate(:, tile), &
            nodes%weight(:, tile), patch)
         call nodes%share%put(grid, nodes%weighted, tile, 1, patch)
      end associate
   end subroutine share_tile

   !> Volumes of the nodes of a tile.
   pure subroutine find_volumes(simulation, tile, slot)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      integer, intent(in) :: slot                    !! Where its fields are

      associate (nodes => simulation%nodes)
         call nodes%share%assemble(simulation%grid, simulation%tiles, nodes%weighted, tile, &
            nodes%volume(:, :, slot))
      end associate
   end subroutine find_volumes

   !> Force of the node stress of the cells of a tile.
   subroutine force_tile(simulation, tile)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp) :: stress(9, simulation%grid%tile_nodes), force(3, simulation%grid%tile_nodes)
      integer :: slot

      associate (grid => simulation%grid, nodes => simulation%nodes, &
         coordinate => simulation%tiles%coordinate(:, tile))
         slot = nodes%slot(tile)
         call find_volumes(simulation, tile, slot)
         call nodes%motion(2)%assemble(grid, simulation%tiles, nodes%touched, tile, stress)
         call divide(nodes%volume(:, :, slot), 1, stress)
         if (simulation%method%controlled()) call add_star(nodes%star(:, :, tile), stress)
         call simulation%boundary%mirror(grid, coordinate, stress)
         call clear_patch(force)
         call simulation%dual%add_force(grid, coordinate, nodes%weight(:, tile), stress, force)
         call nodes%force%put(grid, nodes%weighted, tile, 1, force)
      end associate
   end subroutine force_tile

   !> Give back on the nodes the mean stress that was taken out of the particles.
   pure subroutine add_star(star, stress)
      real(wp), contiguous, intent(in) :: star(:, :)       !! (6, node) [Pa]
      real(wp), contiguous, intent(inout) :: stress(:, :)  !! (9, node) (k, l) in row k + 3 (l - 1)
      integer, parameter :: component(9) = [1, 4, 6, 4, 2, 5, 6, 5, 3]
      integer :: node, k

      do node = 1, size(stress, 2)
         do k = 1, 9
            stress(k, node) = stress(k, node) + star(component(k), node)
         end do
      end do
   end subroutine add_star

   !> Divide node values by a volume or mass; nodes without any get zero.
   pure subroutine divide(by, row, values)
      real(wp), contiguous, intent(in) :: by(:, :)         !! (component, node)
      integer, intent(in) :: row                           !! Component that divides
      real(wp), contiguous, intent(inout) :: values(:, :)  !! (component, node)
      real(wp) :: inverse(size(by, 2))
      integer :: node

      do node = 1, size(by, 2)
         inverse(node) = merge(1.0_wp/max(by(row, node), empty_mass), 0.0_wp, &
            by(row, node) > empty_mass)
      end do
      ! numbers that the compiler knows make the components one vector
      select case (size(values, 1))
      case (3)
         call multiply_nodes(3, size(by, 2), inverse, values)
      case (9)
         call multiply_nodes(9, size(by, 2), inverse, values)
      case default
         call multiply_nodes(size(values, 1), size(by, 2), inverse, values)
      end select
   end subroutine divide

   !> Multiply the components of nodes by a number of each node.
   pure subroutine multiply_nodes(components, nodes, factor, values)
      integer, intent(in) :: components              !! Numbers a node
      integer, intent(in) :: nodes                   !! Nodes of the tile
      real(wp), intent(in) :: factor(nodes)          !! (node)
      real(wp), intent(inout) :: values(components, nodes) !! (component, node)
      integer :: node, component

      do node = 1, nodes
         do component = 1, components
            values(component, node) = values(component, node)*factor(node)
         end do
      end do
   end subroutine multiply_nodes

   !> Velocity and acceleration of the nodes, the velocity that strains the particles, and its node
   !! gradient. Without a time step the nodes stay as they were: the velocity before the step
   !! strains.
   subroutine move_nodes(simulation, dt, whole)
      type(simulation_t), intent(inout) :: simulation !! The run
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      !> Time step, if it is to be told how far the nodes go and their fields are not kept [s]
      real(wp), intent(in), optional :: whole
      integer :: tile
      real(wp) :: began

      call simulation%timer%start(simulation%phase%grid)
      call ensure_moved(simulation)
      simulation%scratch%reach = reach_t()
      simulation%nodes%acting = dt
      !$omp parallel do default(none) shared(simulation, dt, whole) private(tile, began) &
      !$omp schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         associate (scratch => simulation%scratch(omp_get_thread_num()))
            call start_tile(simulation, scratch, tile, dt)
            call finish_tile(simulation, tile, dt)
            if (simulation%nodes%lean .and. tile <= simulation%tiles%own) &
               call keep_seen(simulation, scratch, tile, whole)
         end associate
         call book_cost(simulation, tile, began)
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine move_nodes

   !> Keep what the particles of a tile will see, and tell how far its nodes go.
   subroutine keep_seen(simulation, scratch, tile, whole)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in), optional :: whole        !! Time step [s]
      type(reach_t) :: reach
      integer :: slot

      associate (nodes => simulation%nodes, grid => simulation%grid)
         slot = nodes%slot(tile)
         call nodes%seen(1)%put(grid, nodes%touched, tile, 1, nodes%velocity(:, :, slot))
         call nodes%seen(2)%put(grid, nodes%touched, tile, 1, nodes%acceleration(:, :, slot))
         if (.not. present(whole)) return
         call look_at_tile(simulation, tile, slot, whole, reach)
         if (worse(reach, scratch%reach)) scratch%reach = reach
      end associate
   end subroutine keep_seen

   !> Put back what the particles of a tile see, if it is kept as pieces.
   subroutine recall_seen(simulation, tile)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      integer :: slot

      associate (nodes => simulation%nodes, grid => simulation%grid)
         if (.not. nodes%lean) return
         slot = nodes%slot(tile)
         call nodes%seen(1)%get(grid, nodes%touched, tile, nodes%velocity(:, :, slot))
         call nodes%seen(2)%get(grid, nodes%touched, tile, nodes%acceleration(:, :, slot))
         if (simulation%method%dual) call find_volumes(simulation, tile, slot)
         ! with the same numbers as before, so to the same bits where the particles see it
         nodes%strain(:, :, slot) = nodes%velocity(:, :, slot) &
            + nodes%acting*nodes%acceleration(:, :, slot)
         call calm_tile(simulation, tile, slot, nodes%acting)
      end associate
   end subroutine recall_seen

   !> The first part of the same, for a velocity field that other bodies may change.
   subroutine start_nodes(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run, the velocity field at hand
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile
      real(wp) :: began

      call simulation%timer%start(simulation%phase%grid)
      call ensure_moved(simulation)
      call ensure_patch(simulation%nodes%push, 3, simulation%grid%tile_nodes, simulation%tiles%own)
      !$omp parallel do default(none) shared(simulation, dt) private(tile, began) schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         if (tile <= simulation%tiles%own) call clear_patch(simulation%nodes%push(:, :, tile))
         call start_tile(simulation, simulation%scratch(omp_get_thread_num()), tile, dt)
         call book_cost(simulation, tile, began)
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine start_nodes

   !> The second part, after contact: books and gradients.
   subroutine finish_nodes(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run, the velocity field at hand
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile
      real(wp) :: began

      call simulation%timer%start(simulation%phase%grid)
      !$omp parallel do default(none) shared(simulation, dt) private(tile, began) schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         if (dt > 0.0_wp .and. tile <= simulation%tiles%own) &
            call book_tile(simulation, simulation%scratch(omp_get_thread_num()), tile, dt)
         call finish_tile(simulation, tile, dt)
         call book_cost(simulation, tile, began)
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine finish_nodes

   !> Book what faces and gravity did to the nodes of a tile, at the velocity after contact.
   subroutine book_tile(simulation, scratch, tile, dt)
      type(simulation_t), intent(in) :: simulation   !! The run, the velocity field at hand
      type(scratch_t), intent(inout) :: scratch      !! Of this thread, for its ledger
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp) :: centre(3, simulation%grid%tile_nodes)

      associate (nodes => simulation%nodes)
         centre = nodes%velocity(:, :, tile) + 0.5_wp*dt*nodes%acceleration(:, :, tile)
         call book_push(simulation, scratch%ledger, tile, nodes%push(:, :, tile), centre)
      end associate
   end subroutine book_tile

   !> Make room for what moves and strains the particles. The node stress is no longer needed, so
   !! the gradient takes its memory.
   subroutine ensure_moved(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: n, held

      associate (nodes => simulation%nodes, grid => simulation%grid)
         if (.not. simulation%method%dual) call ensure_sums(simulation)
         call ensure_patch(nodes%strain, 3, grid%tile_nodes, slots(simulation))
         held = 0
         if (nodes%lean) held = nodes%touched%before(simulation%tiles%own + 1)
         do n = 1, size(nodes%seen)
            if (.not. allocated(nodes%seen(n)%row)) call nodes%seen(n)%keep(3, vector_rows(grid))
            call nodes%seen(n)%ensure(held)
         end do
         if (.not. simulation%method%dual) return
         call move_pieces(nodes%motion(2), nodes%gradient)
         call nodes%gradient%ensure(nodes%weighted%nodes())
         if (simulation%carries_energy) call nodes%middle%ensure(nodes%weighted%nodes())
      end associate
   end subroutine ensure_moved

   !> Velocity and acceleration of the nodes of a tile, and the velocity that strains.
   subroutine start_tile(simulation, scratch, tile, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread, for its ledger
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp) :: force(3, simulation%grid%tile_nodes)
      integer :: component, slot

      slot = simulation%nodes%slot(tile)
      if (simulation%nodes%lean .or. .not. simulation%method%dual) &
         call find_sums(simulation, tile, slot)
      associate (grid => simulation%grid, nodes => simulation%nodes, &
         velocity => simulation%nodes%velocity(:, :, slot), &
         acceleration => simulation%nodes%acceleration(:, :, slot), &
         mass => simulation%nodes%mass(1, :, slot))
         if (simulation%method%dual) then
            call nodes%force%assemble(grid, simulation%tiles, nodes%weighted, tile, force)
            acceleration = acceleration + force
         end if
         if (simulation%method%differing()) &
            acceleration = acceleration + nodes%difference(:, :, tile)
         call divide(nodes%mass(:, :, slot), 1, velocity)
         call divide(nodes%mass(:, :, slot), 1, acceleration)
         if (allocated(simulation%gravity)) then
            do component = 1, 3
               where (mass > empty_mass) acceleration(component, :) = &
                  acceleration(component, :) + simulation%gravity(component)
            end do
         end if
         call constrain_tile(simulation, scratch, tile, dt, mass, velocity, acceleration)
         nodes%strain(:, :, slot) = velocity + dt*acceleration
      end associate
   end subroutine start_tile

   !> Bound what light nodes of a tile gain in the velocity that strains.
   pure subroutine calm_tile(simulation, tile, slot, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      integer, intent(in) :: slot                    !! Where its fields are
      real(wp), intent(in) :: dt                     !! Time the forces act [s]

      if (.not. (simulation%method%dual .and. simulation%method%stress == stress_after)) return
      associate (nodes => simulation%nodes)
         call calm_light_nodes(simulation%grid, simulation%tiles%coordinate(:, tile), &
            nodes%volume(1, :, slot), dt, nodes%velocity(:, :, slot), &
            nodes%acceleration(:, :, slot), nodes%strain(:, :, slot))
      end associate
   end subroutine calm_tile

   !> Gradients of the velocities that strain the particles of a tile.
   subroutine finish_tile(simulation, tile, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp) :: centre(3, simulation%grid%tile_nodes)
      integer :: slot

      if (.not. simulation%method%dual) return
      slot = simulation%nodes%slot(tile)
      if (simulation%nodes%lean .and. simulation%method%stress == stress_after) &
         call find_volumes(simulation, tile, slot)
      call calm_tile(simulation, tile, slot, dt)
      associate (nodes => simulation%nodes)
         call put_gradient(simulation, tile, nodes%strain(:, :, slot), nodes%gradient)
         if (.not. simulation%carries_energy) return
         centre = nodes%velocity(:, :, slot) + 0.5_wp*dt*nodes%acceleration(:, :, slot)
         call put_gradient(simulation, tile, centre, nodes%middle)
      end associate
   end subroutine finish_tile

   !> Share of the cells of a tile in the node gradient of a velocity.
   pure subroutine put_gradient(simulation, tile, velocity, gradient)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      type(pieces_t), intent(inout) :: gradient      !! Gets it [m3/s]
      real(wp) :: patch(9, simulation%grid%tile_nodes)

      call clear_patch(patch)
      call simulation%dual%add_gradient(simulation%grid, simulation%tiles%coordinate(:, tile), &
         simulation%nodes%weight(:, tile), velocity, patch)
      call gradient%put(simulation%grid, simulation%nodes%weighted, tile, 1, patch)
   end subroutine put_gradient

   !> Impose the faces of the box and book what they and gravity do. A tile books its own particles'
   !! share of each node, so that all shares add up to the node.
   subroutine constrain_tile(simulation, scratch, tile, dt, mass, velocity, acceleration)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread, for its ledger
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp), intent(in) :: mass(:)                !! (node) [kg]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: free_velocity(3, size(mass)), free_acceleration(3, size(mass))
      logical :: ruled

      ruled = simulation%boundary%touches(simulation%grid, simulation%tiles%coordinate(:, tile))
      if (ruled) then
         free_velocity = velocity
         free_acceleration = acceleration
         call simulation%boundary%constrain(simulation%grid, simulation%tiles%coordinate(:, tile), &
            velocity, acceleration)
         if (any(simulation%boundary%kind == face_friction) .and. dt > 0.0_wp) &
            call simulation%boundary%rub(simulation%grid, simulation%tiles%coordinate(:, tile), &
            dt, 1.0_wp - simulation%method%transfer%keep(), free_velocity, velocity, acceleration)
         ! what the particles will gain in velocity through each node because of the faces
         free_velocity = dt*(acceleration - free_acceleration) &
            + (1.0_wp - simulation%method%transfer%keep())*(velocity - free_velocity)
      else
         free_velocity = 0.0_wp
      end if
      if (tile > simulation%tiles%own .or. .not. dt > 0.0_wp) return
      if (allocated(simulation%gravity)) then
         free_velocity(1, :) = free_velocity(1, :) + dt*simulation%gravity(1)
         free_velocity(2, :) = free_velocity(2, :) + dt*simulation%gravity(2)
         free_velocity(3, :) = free_velocity(3, :) + dt*simulation%gravity(3)
      else if (.not. ruled) then
         return
      end if
      if (allocated(simulation%nodes%push)) then
         ! contact will change the velocities with which it works
         simulation%nodes%push(:, :, tile) = free_velocity
         return
      end if
      call book_push(simulation, scratch%ledger, tile, free_velocity, &
         velocity + 0.5_wp*dt*acceleration)
   end subroutine constrain_tile

   !> Book impulse, its moment, and work of a push on the nodes of a tile.
   subroutine book_push(simulation, ledger, tile, push, velocity)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(ledger_t), intent(inout) :: ledger        !! Of this thread
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: push(:, :)             !! (3, node) Gain of velocity [m/s]
      real(wp), intent(in) :: velocity(:, :)         !! (3, node) In the middle of the step [m/s]
      real(wp) :: own(simulation%nodes%motion(1)%rows, size(push, 2))
      real(wp) :: total(3), turn(3), work, part(3), corner(3), place(3)
      integer :: node, k

      total = 0.0_wp
      turn = 0.0_wp
      work = 0.0_wp
      corner = simulation%grid%tile_corner(simulation%tiles%coordinate(:, tile))
      call simulation%nodes%motion(1)%get(simulation%grid, simulation%nodes%touched, tile, own)
      do node = 1, size(push, 2)
         if (.not. own(1, node) > 0.0_wp) cycle
         part = own(1, node)*push(:, node)
         place = corner + simulation%grid%spacing*real(simulation%grid%node_position(node), wp)
         total = total + part
         turn = turn + cross(place, part)
         work = work + dot_product(part, velocity(:, node))
      end do
      do k = 1, 3
         call ledger%sums(impulse + k - 1)%add(total(k))
         call ledger%sums(torque + k - 1)%add(turn(k))
      end do
      call ledger%sums(external_work)%add(work)
   end subroutine book_push

   !> Node velocities from the momentum that was mapped a second time, as the velocity that strains
   !! the particles, where no other body may change it.
   subroutine remap_nodes(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      real(wp) :: none(3, simulation%grid%tile_nodes)
      real(wp) :: momentum(size(simulation%nodes%extra, 1), simulation%grid%tile_nodes)
      integer :: tile

      call simulation%timer%start(simulation%phase%grid)
      !$omp parallel do default(none) shared(simulation) private(tile, none, momentum) &
      !$omp schedule(static)
      do tile = 1, simulation%tiles%all
         associate (strain => simulation%nodes%strain(:, :, tile), &
            coordinate => simulation%tiles%coordinate(:, tile))
            call assemble(simulation%grid, simulation%tiles, simulation%nodes%extra, tile, momentum)
            ! linear velocity fields bring the mass along, in front
            strain = momentum(size(momentum, 1) - 2:, :)
            call divide(simulation%nodes%mass(:, :, tile), 1, strain)
            none = 0.0_wp
            call simulation%boundary%constrain(simulation%grid, coordinate, strain, none)
         end associate
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
      call strain_nodes(simulation)
   end subroutine remap_nodes

   !> Node gradient of the velocity that strains the particles, which was mapped anew.
   subroutine strain_nodes(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: tile

      if (.not. simulation%method%dual) return
      call simulation%timer%start(simulation%phase%grid)
      !$omp parallel do default(none) shared(simulation) private(tile) schedule(static)
      do tile = 1, simulation%tiles%all
         call put_gradient(simulation, tile, simulation%nodes%strain(:, :, tile), &
            simulation%nodes%gradient)
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine strain_nodes

   !> Sum of the pieces of a node gradient, divided by the volumes of the nodes.
   subroutine node_gradient(simulation, tile, pieces, gradient)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      type(pieces_t), intent(in) :: pieces           !! Shares of the cells [m3/s]
      !> (9, node) [1/s]; only where the particles of the tile see it
      real(wp), allocatable, intent(inout) :: gradient(:, :)
      integer :: low, high

      if (.not. allocated(gradient)) allocate (gradient(9, simulation%grid%tile_nodes))
      call pieces%assemble(simulation%grid, simulation%tiles, simulation%nodes%weighted, tile, &
         gradient)
      call nodes_seen(simulation, tile, low, high)
      call divide(simulation%nodes%volume(:, low:high, simulation%nodes%slot(tile)), 1, &
         gradient(:, low:high))
      call simulation%boundary%mirror(simulation%grid, simulation%tiles%coordinate(:, tile), &
         gradient)
   end subroutine node_gradient
end module driver_nodes
