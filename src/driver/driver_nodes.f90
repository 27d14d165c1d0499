! SPDX-License-Identifier: BSD-3-Clause
!> What happens on the nodes in a step. Every tile, own or ghost, works on all its nodes; nodes that
!! several tiles share get the same bits on each of them.
module driver_nodes
   use base_kinds, only: wp
   use driver_cost, only: book_cost, cost_clock
   use driver_ledger, only: cross, external_work, impulse, ledger_t, torque
   use driver_light_nodes, only: calm_light_nodes
   use driver_method, only: stress_after
   use driver_scatter, only: nodes_seen
   use driver_simulation, only: nodes_t, scratch_t, simulation_t
   use driver_walls, only: impose_walls, stand_walls, stop_at_walls, walls_touch
   use mesh_patch, only: assemble, clear_patch, empty_box, ensure_boxes, ensure_patch, &
      ensure_weights, widen_box
   use omp_lib, only: omp_get_thread_num
   use transfer_scatter, only: motion_columns
   implicit none
   private

   public :: node_gradient, book_push, divide, dual_fields, finish_nodes, &
      move_nodes, remap_nodes, renew_sums, start_nodes, strain_nodes

   integer, parameter, public :: stress_before_it = 8 !! Rows of the motion before node stress

   !> Nodes with less mass or volume than this are empty: below any share of any mass, and what it
   !! divides stays finite.
   real(wp), parameter, public :: empty_mass = 1.0e-290_wp

contains

   !> Weights and volumes of the dual gradient, and the force of the stress on the nodes.
   subroutine dual_fields(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: tile
      real(wp) :: began

      call simulation%timer%start(simulation%phase%grid)
      associate (nodes => simulation%nodes, number => simulation%grid%tile_nodes, &
         all => simulation%tiles%all)
         call ensure_sums(simulation)
         call ensure_weights(nodes%weight, simulation%grid%tile_cells, all)
         call ensure_boxes(nodes%weighted, all)
         call ensure_patch(nodes%share, 1, number, all)
         call ensure_patch(nodes%volume, 1, number, all)
         call ensure_patch(nodes%force, 3, number, all)
         call ensure_patch(nodes%gradient, 9, number, all)
         if (simulation%repacks) call ensure_patch(nodes%filled, 1, number, all)
      end associate
      !$omp parallel do default(none) shared(simulation) private(tile, began) schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         call weigh_tile(simulation, tile)
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

   !> Make room for the sums over the particles around the nodes.
   pure subroutine ensure_sums(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run

      associate (nodes => simulation%nodes, number => simulation%grid%tile_nodes, &
         all => simulation%tiles%all)
         call ensure_patch(nodes%mass, 1, number, all)
         call ensure_patch(nodes%velocity, 3, number, all)
         call ensure_patch(nodes%acceleration, 3, number, all)
      end associate
   end subroutine ensure_sums

   !> Keep the sums of the nodes of a tile: momentum where the velocity will be, force where the
   !! acceleration will be.
   pure subroutine keep_sums(nodes, tile, sums)
      type(nodes_t), intent(inout) :: nodes          !! Gets them
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: sums(:, :)             !! (column, node) Mass, momentum, force, more

      nodes%mass(1, :, tile) = sums(1, :)
      nodes%velocity(:, :, tile) = sums(2:4, :)
      nodes%acceleration(:, :, tile) = sums(5:7, :)
   end subroutine keep_sums

   !> Sums over the particles around the nodes as before the nodes were moved.
   subroutine renew_sums(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      real(wp) :: sums(size(simulation%nodes%motion, 1), simulation%grid%tile_nodes)
      integer :: tile

      !$omp parallel do default(none) shared(simulation) private(tile, sums) schedule(static)
      do tile = 1, simulation%tiles%all
         call assemble(simulation%grid, simulation%tiles, simulation%nodes%motion, tile, sums, &
            simulation%nodes%touched)
         call keep_sums(simulation%nodes, tile, sums)
      end do
      !$omp end parallel do
   end subroutine renew_sums

   !> Weights of the cells of a tile and their share of the volumes of the nodes.
   subroutine weigh_tile(simulation, tile)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      integer, parameter :: filled = 8               ! row of the patch
      integer, parameter :: first = 9, last = 17     ! rows of the stress
      real(wp) :: around(simulation%grid%tile_nodes)
      real(wp) :: sums(last, simulation%grid%tile_nodes)
      logical :: weighs(simulation%grid%tile_cells)

      associate (grid => simulation%grid, nodes => simulation%nodes, dual => simulation%dual, &
         coordinate => simulation%tiles%coordinate(:, tile))
         call assemble(grid, simulation%tiles, nodes%motion, tile, sums, nodes%touched)
         call keep_sums(nodes, tile, sums)
         nodes%gradient(:, :, tile) = sums(first:last, :)
         if (simulation%repacks) nodes%filled(1, :, tile) = sums(filled, :)
         call grid%node_volume(coordinate, around)
         call dual%cell_weights(grid, sums, filled, around, nodes%weight(:, tile))
         call empty_box(nodes%weighted(:, :, tile))
         weighs = nodes%weight(:, tile) > 0.0_wp
         call widen_box(grid, weighs, nodes%weighted(:, :, tile))
         call clear_patch(nodes%share(:, :, tile))
         call dual%add_volume(grid, coordinate, nodes%weight(:, tile), nodes%share(:, :, tile))
      end associate
   end subroutine weigh_tile

   !> Force of the node stress of the cells of a tile.
   subroutine force_tile(simulation, tile)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp) :: stress(9, simulation%grid%tile_nodes)

      associate (grid => simulation%grid, nodes => simulation%nodes, &
         coordinate => simulation%tiles%coordinate(:, tile))
         call assemble(grid, simulation%tiles, nodes%share, tile, nodes%volume(:, :, tile), &
            nodes%weighted)
         stress = nodes%gradient(:, :, tile)
         call divide(nodes%volume(:, :, tile), 1, stress)
         if (simulation%method%controlled()) call add_star(nodes%star(:, :, tile), stress)
         call simulation%boundary%mirror(grid, coordinate, stress)
         call clear_patch(nodes%force(:, :, tile))
         call simulation%dual%add_force(grid, coordinate, nodes%weight(:, tile), stress, &
            nodes%force(:, :, tile))
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
   subroutine move_nodes(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile
      real(wp) :: began

      call simulation%timer%start(simulation%phase%grid)
      call ensure_moved(simulation)
      call stand_walls(simulation, dt)
      !$omp parallel do default(none) shared(simulation, dt) private(tile, began) schedule(static)
      do tile = 1, simulation%tiles%all
         began = cost_clock(simulation)
         call start_tile(simulation, simulation%scratch(omp_get_thread_num()), tile, dt)
         call finish_tile(simulation, tile, dt)
         call book_cost(simulation, tile, began)
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine move_nodes

   !> The first part of the same, for a velocity field that other bodies may change.
   subroutine start_nodes(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run, the velocity field at hand
      real(wp), intent(in) :: dt                     !! Time the forces act, 0 = none [s]
      integer :: tile
      real(wp) :: began

      call simulation%timer%start(simulation%phase%grid)
      call ensure_moved(simulation)
      call stand_walls(simulation, dt)
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

   !> Make room for what moves and strains the particles.
   subroutine ensure_moved(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run

      associate (nodes => simulation%nodes, number => simulation%grid%tile_nodes, &
         all => simulation%tiles%all)
         if (.not. simulation%method%dual) call ensure_sums(simulation)
         call ensure_patch(nodes%strain, 3, number, all)
      end associate
   end subroutine ensure_moved

   !> Velocity and acceleration of the nodes of a tile, and the velocity that strains.
   subroutine start_tile(simulation, scratch, tile, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread, for its ledger
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp) :: force(3, simulation%grid%tile_nodes)
      real(wp) :: sums(motion_columns, simulation%grid%tile_nodes)
      integer :: component

      associate (grid => simulation%grid, nodes => simulation%nodes, &
         coordinate => simulation%tiles%coordinate(:, tile), &
         velocity => simulation%nodes%velocity(:, :, tile), &
         acceleration => simulation%nodes%acceleration(:, :, tile), &
         mass => simulation%nodes%mass(1, :, tile))
         if (.not. simulation%method%dual) then
            call assemble(grid, simulation%tiles, nodes%motion, tile, sums, nodes%touched)
            call keep_sums(nodes, tile, sums)
         else
            call assemble(grid, simulation%tiles, nodes%force, tile, force, nodes%weighted)
            acceleration = acceleration + force
         end if
         if (simulation%method%differing()) &
            acceleration = acceleration + nodes%difference(:, :, tile)
         call divide(nodes%mass(:, :, tile), 1, velocity)
         call divide(nodes%mass(:, :, tile), 1, acceleration)
         if (allocated(simulation%gravity)) then
            do component = 1, 3
               where (mass > empty_mass) acceleration(component, :) = &
                  acceleration(component, :) + simulation%gravity(component)
            end do
         end if
         call constrain_tile(simulation, scratch, tile, dt, mass, velocity, acceleration)
         nodes%strain(:, :, tile) = velocity + dt*acceleration
      end associate
   end subroutine start_tile

   !> Gradients of the velocities that strain the particles of a tile.
   subroutine finish_tile(simulation, tile, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp) :: centre(3, simulation%grid%tile_nodes), middle(9, simulation%grid%tile_nodes)

      if (.not. simulation%method%dual) return
      associate (grid => simulation%grid, nodes => simulation%nodes, &
         coordinate => simulation%tiles%coordinate(:, tile), &
         velocity => simulation%nodes%velocity(:, :, tile), &
         acceleration => simulation%nodes%acceleration(:, :, tile))
         if (simulation%method%stress == stress_after) &
            call calm_light_nodes(grid, coordinate, nodes%volume(1, :, tile), dt, velocity, &
            acceleration, nodes%strain(:, :, tile))
         call clear_patch(nodes%gradient(:, :, tile))
         call simulation%dual%add_gradient(grid, coordinate, nodes%weight(:, tile), &
            nodes%strain(:, :, tile), nodes%gradient(:, :, tile))
         if (.not. simulation%carries_energy) return
         call clear_patch(middle)
         centre = velocity + 0.5_wp*dt*acceleration
         call simulation%dual%add_gradient(grid, coordinate, nodes%weight(:, tile), centre, &
            middle)
         ! the sums of the stresses have been taken from there
         nodes%motion(stress_before_it + 1:, :, tile) = middle
      end associate
   end subroutine finish_tile

   !> Impose the walls and book what they and gravity do. A tile books its own particles'
   !! share of each node, so that all shares add up to the node.
   subroutine constrain_tile(simulation, scratch, tile, dt, mass, velocity, acceleration)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread, for its ledger
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time the forces act [s]
      real(wp), intent(in) :: mass(:)                !! (node) [kg]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: push(3, size(mass)), work(size(mass))
      logical :: ruled

      ruled = walls_touch(simulation, tile)
      push = 0.0_wp
      work = 0.0_wp
      if (ruled) call impose_walls(simulation, tile, dt, velocity, acceleration, push, work)
      if (tile > simulation%tiles%own .or. .not. dt > 0.0_wp) return
      if (allocated(simulation%gravity)) then
         push(1, :) = push(1, :) + dt*simulation%gravity(1)
         push(2, :) = push(2, :) + dt*simulation%gravity(2)
         push(3, :) = push(3, :) + dt*simulation%gravity(3)
      else if (.not. ruled) then
         return
      end if
      if (allocated(simulation%nodes%push)) then
         ! contact will change the velocities with which it works
         simulation%nodes%push(:, :, tile) = push
         return
      end if
      call book_push(simulation, scratch%ledger, tile, push, &
         velocity + 0.5_wp*dt*acceleration, work)
   end subroutine constrain_tile

   !> Book impulse, its moment, and work of a push on the nodes of a tile.
   subroutine book_push(simulation, ledger, tile, push, velocity, more)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(ledger_t), intent(inout) :: ledger        !! Of this thread
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: push(:, :)             !! (3, node) Gain of velocity [m/s]
      real(wp), intent(in) :: velocity(:, :)         !! (3, node) In the middle of the step [m/s]
      real(wp), intent(in), optional :: more(:)      !! (node) Work besides that of the push [J/kg]
      real(wp) :: total(3), turn(3), work, part(3), corner(3), place(3)
      integer :: node, k

      total = 0.0_wp
      turn = 0.0_wp
      work = 0.0_wp
      corner = simulation%grid%tile_corner(simulation%tiles%coordinate(:, tile))
      do node = 1, size(push, 2)
         ! faces push few of the nodes
         if (.not. abs(push(1, node)) + abs(push(2, node)) + abs(push(3, node)) > 0.0_wp) cycle
         if (.not. simulation%nodes%motion(1, node, tile) > 0.0_wp) cycle
         part = simulation%nodes%motion(1, node, tile)*push(:, node)
         place = corner + simulation%grid%spacing*real(simulation%grid%node_position(node), wp)
         total = total + part
         turn = turn + cross(place, part)
         work = work + dot_product(part, velocity(:, node))
         if (present(more)) work = work + simulation%nodes%motion(1, node, tile)*more(node)
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
         associate (strain => simulation%nodes%strain(:, :, tile))
            call assemble(simulation%grid, simulation%tiles, simulation%nodes%extra, tile, momentum)
            ! linear velocity fields bring the mass along, in front
            strain = momentum(size(momentum, 1) - 2:, :)
            call divide(simulation%nodes%mass(:, :, tile), 1, strain)
            none = 0.0_wp
            call stop_at_walls(simulation, tile, strain, none)
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
         call clear_patch(simulation%nodes%gradient(:, :, tile))
         call simulation%dual%add_gradient(simulation%grid, simulation%tiles%coordinate(:, tile), &
            simulation%nodes%weight(:, tile), simulation%nodes%strain(:, :, tile), &
            simulation%nodes%gradient(:, :, tile))
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine strain_nodes

   !> Sum of the patches of a node gradient, divided by the volumes of the nodes.
   subroutine node_gradient(simulation, tile, patch, gradient, before)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(in) :: patch(:, :, :)   !! (row, node, tile)
      !> (9, node) [1/s]; only where the particles of the tile see it
      real(wp), allocatable, intent(inout) :: gradient(:, :)
      integer, intent(in), optional :: before        !! Rows before those of the gradient, if any
      integer :: low, high

      if (.not. allocated(gradient)) allocate (gradient(9, simulation%grid%tile_nodes))
      call assemble(simulation%grid, simulation%tiles, patch, tile, gradient, &
         simulation%nodes%weighted, before)
      call nodes_seen(simulation, tile, low, high)
      call divide(simulation%nodes%volume(:, low:high, tile), 1, gradient(:, low:high))
      call simulation%boundary%mirror(simulation%grid, simulation%tiles%coordinate(:, tile), &
         gradient)
   end subroutine node_gradient
end module driver_nodes
