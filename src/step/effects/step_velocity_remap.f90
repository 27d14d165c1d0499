! SPDX-License-Identifier: BSD-3-Clause
!> Further transfers between nodes and particles within a step: the terms of the series that filters
!! node velocities, and the map of the new particle velocities that strains with `musl`.
module step_velocity_remap
   use base_kinds, only: wp
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use mesh_wall_sums, only: wall_push_t
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_dual_gradient, only: node_gradient
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_node_sums, only: divide
   use step_particles_to_nodes, only: locate_particles, nodes_seen
   use step_simulation, only: scheme_t, scratch_t, simulation_t, space_t, velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   use step_walls, only: record_push, record_walls, remove_wall_components, walls_touch
   use transfer_affine, only: turn_only
   use transfer_basis, only: expand_spin
   use transfer_shape_data, only: shape_data_t, spare
   implicit none
   private

   public :: filter_velocities, find_filtered, find_slopes, remap_momentum

contains

   !> The series of node velocities that the transfer requests, on the own tiles.
   subroutine filter_velocities(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: began
      integer :: sweep, tile

      associate (nodes => field%nodes, number => simulation%space%grid%tile_nodes, &
         own => simulation%space%tiles%own)
         call ensure_patch(nodes%series%filtered, 3, number, own)
         call ensure_patch(nodes%series%term, 3, number, own)
         call ensure_patch(nodes%series%loss, 1, number, own)
      end associate
      !$omp parallel do default(none) shared(simulation, field, dt) private(began, tile) &
      !$omp schedule(static)
      do tile = 1, simulation%space%tiles%own
         began = cost_clock(simulation%machine)
         call simulation%scheme%method%transfer%first_term(dt, field%nodes%motion%velocity(:, :, &
            tile), &
            field%nodes%motion%acceleration(:, :, tile), field%nodes%series%term(:, :, tile))
         field%nodes%series%filtered(:, :, tile) = field%nodes%series%term(:, :, tile)
         field%nodes%series%loss(:, :, tile) = 0.0_wp
         call record_cost(simulation%machine, tile, began)
      end do
      !$omp end parallel do
      do sweep = 1, simulation%scheme%method%transfer%sweeps()
         call spread_terms(simulation, field)
         call simulation%machine%timer%start(simulation%machine%phase%grid)
         !$omp parallel do default(none) shared(simulation, field, dt, sweep) private(began, tile) &
         !$omp schedule(static)
         do tile = 1, simulation%space%tiles%own
            began = cost_clock(simulation%machine)
            call add_term(simulation, field, simulation%scratch(omp_get_thread_num()), tile, &
               sweep, dt)
            call record_cost(simulation%machine, tile, began)
         end do
         !$omp end parallel do
         call simulation%machine%timer%stop(simulation%machine%phase%grid)
      end do
   end subroutine filter_velocities

   !> Scatter the momentum of the present term at the particles to a second patch.
   subroutine spread_terms(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp) :: began
      integer, allocatable :: tiles(:)
      integer :: part, n

      call simulation%machine%timer%start(simulation%machine%phase%scatter)
      call ensure_patch(field%nodes%series%extra, 3, simulation%space%grid%tile_nodes, &
         simulation%space%tiles%own)
      do part = edge_tiles, inner_tiles
         call next_tiles(simulation, part, tiles)
         !$omp parallel do default(none) shared(simulation, field, tiles) private(began, n) &
         !$omp schedule(dynamic, 1)
         do n = 1, size(tiles)
            began = cost_clock(simulation%machine)
            call spread_tile(simulation, field, simulation%scratch(omp_get_thread_num()), &
               tiles(n), &
               field%nodes%series%term(:, :, tiles(n)), field%nodes%series%extra(:, :, tiles(n)))
            call record_cost(simulation%machine, tiles(n), began)
         end do
         !$omp end parallel do
         call send_patches(simulation, part, field%nodes%series%extra)
      end do
      call simulation%machine%timer%stop(simulation%machine%phase%scatter)
   end subroutine spread_terms

   !> One tile.
   subroutine spread_tile(simulation, field, scratch, tile, term, patch)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: term(:, :) !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (3, node) [kg m/s]
      integer :: index

      call clear_patch(patch)
      do index = field%first_store, field%last_store
         if (simulation%stores(index)%count(tile) == 0) cycle
         associate (grid => simulation%space%grid, store => simulation%stores(index), &
            basis => simulation%scheme%method%basis, shape => scratch%shape, &
            start => simulation%stores(index)%cell_start(:, tile))
            call locate_particles(simulation%space, simulation%scheme, field, scratch, store, tile)
            call basis%gather_values(grid, shape, term, shape%vector)
            call basis%scatter_product(grid, shape, store%first(tile), store%state%mass, &
               shape%vector, 0, patch)
         end associate
      end do
   end subroutine spread_tile

   !> The next term, y - S^+ S y, without the components that walls hold in this step; it is added
   !! to the sum. Particles do not get what walls remove, so it is recorded, with the velocity at
   !! the end of the step. Equation (L.12) of doc/theory/ledger.md: this needs the same orthogonal
   !! projection for all terms, so the held components must not depend on the term.
   subroutine add_term(simulation, field, scratch, tile, sweep, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, for its ledger
      integer, intent(in) :: tile
      integer, intent(in) :: sweep                   !! Number of the term, 1 for the second one
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: again(3, simulation%space%grid%tile_nodes), free(3, &
         simulation%space%grid%tile_nodes)
      real(wp) :: ended(3, simulation%space%grid%tile_nodes)
      type(wall_push_t) :: each

      associate (grid => simulation%space%grid, nodes => field%nodes, &
         term => field%nodes%series%term(:, :, tile), transfer => simulation%scheme%method%transfer)
         call assemble(grid, simulation%space%tiles, nodes%series%extra, tile, again)
         call divide(nodes%motion%mass(:, :, tile), 1, again)
         again = term - again
         if (walls_touch(simulation, tile)) then
            ended = nodes%motion%velocity(:, :, tile) + dt*nodes%motion%acceleration(:, :, tile)
            free = again
            if (allocated(scratch%ledger%walls%total)) then
               call remove_wall_components(simulation, tile, &
                  nodes%motion%velocity(:, :, tile), again, each)
               ! the push below is recorded with the velocity at the end of the step
               each%dt = 2.0_wp*dt
               call record_walls(simulation%space, field, scratch%ledger, tile, each)
            else
               call remove_wall_components(simulation, tile, &
                  nodes%motion%velocity(:, :, tile), again)
            end if
            free = again - free
            call record_push(simulation%space, field, scratch%ledger, tile, free, ended)
         end if
         if (simulation%scheme%carries_energy) nodes%series%loss(1, :, tile) = &
            nodes%series%loss(1, :, tile) &
            + transfer%loss_weight(2*sweep - 1)*sum(term*again, dim=1) &
            + transfer%loss_weight(2*sweep)*sum(again**2, dim=1)
         term = again
         nodes%series%filtered(:, :, tile) = nodes%series%filtered(:, :, tile) + again
      end associate
   end subroutine add_term

   !> Sum of the series of node velocities, or its only term, at the nodes that particles use.
   subroutine find_filtered(space, scheme, field, tile, low, high, dt, filtered)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      integer, intent(in) :: low, high               !! First and last node
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), allocatable, intent(inout) :: filtered(:, :) !! (3, node) [m/s]
      integer :: slot

      slot = field%nodes%slot(tile)
      if (.not. allocated(filtered)) &
         allocate (filtered(3, space%grid%tile_nodes), source=0.0_wp)
      if (scheme%method%transfer%sweeps() > 0) then
         filtered(:, low:high) = field%nodes%series%filtered(:, low:high, tile)
      else
         call scheme%method%transfer%first_term(dt, &
            field%nodes%motion%velocity(:, low:high, slot), &
            field%nodes%motion%acceleration(:, low:high, slot), filtered(:, low:high))
      end if
   end subroutine find_filtered

   !> Scatter the momentum of the new particle velocities, or of their gain, to a second patch, at
   !! the old positions. The particles themselves get these velocities later.
   subroutine remap_momentum(simulation, field, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: began
      integer, allocatable :: tiles(:)
      integer :: part, n

      call simulation%machine%timer%start(simulation%machine%phase%scatter)
      call ensure_patch(field%nodes%series%extra, merge(4, 3, &
         simulation%scheme%method%transfer%affine() &
         .and. .not. simulation%scheme%method%averages()), &
         simulation%space%grid%tile_nodes, simulation%space%tiles%own)
      do part = edge_tiles, inner_tiles
         call next_tiles(simulation, part, tiles)
         !$omp parallel do default(none) shared(simulation, field, dt, tiles) private(began, n) &
         !$omp schedule(dynamic, 1)
         do n = 1, size(tiles)
            began = cost_clock(simulation%machine)
            call scatter_tile(simulation, field, simulation%scratch(omp_get_thread_num()), &
               tiles(n), dt, &
               field%nodes%series%extra(:, :, tiles(n)))
            call record_cost(simulation%machine, tiles(n), began)
         end do
         !$omp end parallel do
         call send_patches(simulation, part, field%nodes%series%extra)
      end do
      call simulation%machine%timer%stop(simulation%machine%phase%scatter)
   end subroutine remap_momentum

   !> One tile: momentum, or mass and momentum of linear velocity fields.
   subroutine scatter_tile(simulation, field, scratch, tile, dt, patch)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp) :: push(3, simulation%space%grid%tile_nodes)
      real(wp), allocatable :: after(:, :), filtered(:, :), gradient(:, :)
      real(wp) :: keep
      integer :: index, low, high

      call clear_patch(patch)
      if (simulation%scheme%method%dual .and. simulation%scheme%method%transfer%affine() .and. &
         .not. &
         simulation%scheme%method%averages()) call node_gradient(simulation%space, field, tile, &
         field%nodes%dual%gradient, gradient)
      call nodes_seen(simulation%space, field, tile, low, high)
      push = 0.0_wp
      call find_filtered(simulation%space, simulation%scheme, field, tile, low, high, dt, filtered)
      call simulation%scheme%method%transfer%velocity_increment(dt, field%nodes%motion% &
         acceleration(:, low:high, tile), filtered(:, low:high), push(:, low:high))
      keep = simulation%scheme%method%transfer%flip_fraction()
      if (simulation%scheme%method%averages()) then
         ! gain of the particles; the PIC fraction acts after the strain of the step, which does
         ! not include it, and rotations do not change
         if (keep > 0.0_wp) push = dt*field%nodes%motion%acceleration(:, :, tile)
         keep = merge(0.0_wp, -1.0_wp, keep > 0.0_wp)
      end if
      if (simulation%scheme%method%transfer%affine()) after = &
         field%nodes%motion%velocity(:, :, tile) + dt*field%nodes%motion%acceleration(:, :, tile)
      do index = field%first_store, field%last_store
         if (simulation%stores(index)%count(tile) == 0) cycle
         associate (grid => simulation%space%grid, store => simulation%stores(index), &
            basis => simulation%scheme%method%basis, shape => scratch%shape, &
            start => simulation%stores(index)%cell_start(:, tile))
            call locate_particles(simulation%space, simulation%scheme, field, scratch, store, tile)
            call basis%gather_values(grid, shape, push, shape%vector)
            if (abs(keep) > 0.0_wp) call keep_velocity(store, tile, keep, shape%vector)
            if (simulation%scheme%method%averages()) then
               call basis%scatter_product(grid, shape, store%first(tile), store%state%mass, &
                  shape%vector, 0, patch)
            else if (simulation%scheme%method%transfer%affine()) then
               call scratch%deformation%reserve(store%count(tile) + spare)
               if (simulation%scheme%method%smooth_turn) then
                  call expand_spin(store%first(tile), store%count(tile), store%spin, &
                     scratch%deformation%gradient)
               else
                  call find_slopes(simulation, shape, after, gradient, scratch%deformation%gradient)
                  if (simulation%scheme%method%transfer%turning()) &
                     call turn_only(store%count(tile), scratch%deformation%gradient)
               end if
               call spread_fields(simulation%space, simulation%scheme, scratch, store, tile, patch)
            else
               call basis%scatter_product(grid, shape, store%first(tile), store%state%mass, &
                  shape%vector, 0, patch)
            end if
         end associate
      end do
   end subroutine scatter_tile

   !> Slopes of a node velocity around the particles of a tile: with the dual domain method its
   !! modified gradient, which leaves out nodes without mass, as they have no velocity.
   subroutine find_slopes(simulation, shape, velocity, gradient, slopes)
      type(simulation_t), intent(in) :: simulation
      type(shape_data_t), intent(inout) :: shape        !! Shape data of the tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :) !! (9, node) Node gradient, if dual [1/s]
      real(wp), contiguous, intent(inout) :: slopes(:, :) !! (particle of the tile, 9) [1/s]

      associate (grid => simulation%space%grid, method => simulation%scheme%method)
         ! with normalised sums the modified gradient of a linear field is not uniform
         if (method%dual .and. .not. allocated(shape%factor)) then
            call method%quadrature%gather_gradient(grid, shape, velocity, gradient, 1.0_wp, slopes)
         else
            call method%basis%gather_affine(grid, shape, velocity, slopes)
         end if
      end associate
   end subroutine find_slopes

   !> Add a fraction of their own velocity to the new velocity of particles.
   pure subroutine keep_velocity(store, tile, keep, vector)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: keep                   !! Fraction kept [1]
      real(wp), contiguous, intent(inout) :: vector(:, :) !! (particle of the tile, 3) [m/s]
      integer :: p, k

      associate (before => store%first(tile) - 1, velocity => store%velocity)
         do k = 1, 3
            !$omp simd
            do p = 1, store%count(tile)
               vector(p, k) = keep*velocity(before + p, k) + vector(p, k)
            end do
         end do
      end associate
   end subroutine keep_velocity

   !> Mass and momentum of linear velocity fields that are in the scratch space.
   subroutine spread_fields(space, scheme, scratch, store, tile, patch)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(scratch_t), intent(inout) :: scratch !! Private to this thread, velocity and slopes set
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (4, node)
      real(wp) :: mass(store%count(tile))

      mass = store%state%mass(store%first(tile):store%first(tile) + store%count(tile) - 1)
      call scheme%method%basis%scatter_affine(space%grid, scratch%shape, 1, mass, &
         scratch%shape%vector, scratch%deformation%gradient, patch)
   end subroutine spread_fields
end module step_velocity_remap
