! SPDX-License-Identifier: BSD-3-Clause
!> The second map of particle velocities to the nodes within a step, which strains with `musl`.
module step_velocity_remap
   use base_kinds, only: wp
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_dual_gradient, only: node_gradient
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_particles_to_nodes, only: locate_particles, nodes_seen
   use step_simulation, only: scheme_t, scratch_t, simulation_t, space_t, velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   use transfer_affine, only: turn_only
   use transfer_basis, only: expand_spin
   use transfer_shape_data, only: shape_data_t, spare
   implicit none
   private

   public :: find_slopes, remap_momentum

contains

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
      call ensure_patch(field%nodes%remap, merge(4, 3, &
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
               field%nodes%remap(:, :, tiles(n)))
            call record_cost(simulation%machine, tiles(n), began)
         end do
         !$omp end parallel do
         call send_patches(simulation, part, field%nodes%remap)
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
      real(wp), allocatable :: after(:, :), gradient(:, :)
      real(wp) :: keep
      integer :: index, low, high

      call clear_patch(patch)
      if (simulation%scheme%method%dual .and. simulation%scheme%method%transfer%affine() .and. &
         .not. &
         simulation%scheme%method%averages()) call node_gradient(simulation%space, field, tile, &
         field%nodes%dual%gradient, gradient)
      call nodes_seen(simulation%space, field, tile, low, high)
      push = 0.0_wp
      associate (motion => field%nodes%motion)
         call simulation%scheme%method%transfer%velocity_increment(dt, &
            motion%velocity(:, low:high, tile), motion%acceleration(:, low:high, tile), &
            push(:, low:high))
      end associate
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
            if (simulation%scheme%method%transfer%affine() .and. &
               .not. simulation%scheme%method%averages()) then
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
