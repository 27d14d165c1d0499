! SPDX-License-Identifier: BSD-3-Clause
!> The second map of particle velocities to the nodes within a step, which strains with `musl`.
module step_velocity_remap
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_dual_gradient, only: node_gradient
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_method, only: method_t
   use step_node_fields, only: whole_tiles
   use step_particles_to_nodes, only: locate_particles, nodes_seen
   use step_simulation, only: machine_t, scheme_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_affine, only: turn_only
   use transfer_basis, only: expand_spin
   use transfer_shape_data, only: shape_data_t, spare
   implicit none
   private

   public :: find_slopes, remap_momentum

contains

   !> Scatter the momentum of the new particle velocities, or of their gain, to a second patch, at
   !! the old positions. The particles themselves get these velocities later.
   subroutine remap_momentum(space, stores, scheme, machine, scratches, field, dt)
      type(space_t), intent(inout) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer, allocatable :: tiles(:)
      integer :: part, n, layers

      call machine%timer%start(machine%phase%scatter)
      ! velocities need two layers of cells less than volumes
      layers = field%nodes%motion%layers
      if (layers /= whole_tiles) layers = max(layers - 2, 0)
      call ensure_patch(field%nodes%remap, merge(4, 3, scheme%method%transfer%affine() &
         .and. .not. scheme%method%averages()), space%grid%tile_nodes, space%tiles%own)
      do part = edge_tiles, inner_tiles
         call next_tiles(space, machine%communicator, part, tiles)
         !$omp parallel do default(none) shared(space, stores, scheme, machine, scratches, field, &
         !$omp dt, tiles) private(n) schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(machine, tiles(n))
            call scatter_tile(space, stores, scheme, field, scratches(omp_get_thread_num()), &
               tiles(n), dt, field%nodes%remap(:, :, tiles(n)))
            call stop_cost(machine, tiles(n))
         end do
         !$omp end parallel do
         call send_patches(space, machine, part, field%nodes%remap, layers)
      end do
      call machine%timer%stop(machine%phase%scatter)
   end subroutine remap_momentum

   !> One tile: momentum, or mass and momentum of linear velocity fields.
   subroutine scatter_tile(space, stores, scheme, field, scratch, tile, dt, patch)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp) :: push(3, space%grid%tile_nodes)
      real(wp), allocatable :: after(:, :), gradient(:, :)
      real(wp) :: keep
      integer :: index, low, high

      associate (method => scheme%method, motion => field%nodes%motion)
         call clear_patch(patch)
         if (method%dual .and. method%transfer%affine() .and. .not. method%averages()) &
            call node_gradient(space, field%nodes, tile, field%nodes%dual%gradient, gradient)
         call nodes_seen(space%grid, motion, tile, low, high)
         push = 0.0_wp
         call method%transfer%velocity_increment(dt, motion%velocity(:, low:high, tile), &
            motion%acceleration(:, low:high, tile), push(:, low:high))
         keep = method%transfer%flip_fraction()
         if (method%averages()) then
            ! gain of the particles; the PIC fraction acts after the strain of the step, which does
            ! not include it, and rotations do not change
            if (keep > 0.0_wp) push = dt*motion%acceleration(:, :, tile)
            keep = merge(0.0_wp, -1.0_wp, keep > 0.0_wp)
         end if
         if (method%transfer%affine()) after = motion%velocity(:, :, tile) &
            + dt*motion%acceleration(:, :, tile)
         do index = field%first_store, field%last_store
            if (stores(index)%count(tile) == 0) cycle
            associate (grid => space%grid, store => stores(index), basis => method%basis, &
               shape => scratch%shape)
               call locate_particles(space, scheme, field, scratch, store, tile)
               call basis%gather_values(grid, shape, push, shape%vector)
               if (abs(keep) > 0.0_wp) call keep_velocity(store, tile, keep, shape%vector)
               if (method%transfer%affine() .and. .not. method%averages()) then
                  call scatter_affine_fields(grid, method, scratch, store, tile, after, &
                     gradient, patch)
               else
                  call basis%scatter_product(grid, shape, store%first(tile), store%state%mass, &
                     shape%vector, 0, patch)
               end if
            end associate
         end do
      end associate
   end subroutine scatter_tile

   !> Slopes of a node velocity around the particles of a tile: with the dual domain method its
   !! modified gradient, which leaves out nodes without mass, as they have no velocity.
   subroutine find_slopes(grid, method, shape, velocity, gradient, slopes)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(shape_data_t), intent(inout) :: shape        !! Shape data of the tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :) !! (9, node) Node gradient, if dual [1/s]
      real(wp), contiguous, intent(inout) :: slopes(:, :) !! (particle of the tile, 9) [1/s]

      ! with normalised sums the modified gradient of a linear field is not uniform
      if (method%dual .and. .not. allocated(shape%factor)) then
         call method%quadrature%gather_gradient(grid, shape, velocity, gradient, 1.0_wp, slopes)
      else
         call method%basis%gather_affine(grid, shape, velocity, slopes)
      end if
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

   !> Mass and momentum of the linear velocity fields of particles with their new velocities.
   subroutine scatter_affine_fields(grid, method, scratch, store, tile, after, gradient, patch)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, velocities set
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), allocatable, intent(in) :: after(:, :) !! (3, node) Velocity after the step [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :) !! (9, node) Its gradient, if dual [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (4, node)
      real(wp) :: mass(store%count(tile))

      call scratch%deformation%reserve(store%count(tile) + spare)
      associate (slopes => scratch%deformation%gradient)
         if (method%smooth_turn) then
            call expand_spin(store%first(tile), store%count(tile), store%spin, slopes)
         else
            call find_slopes(grid, method, scratch%shape, after, gradient, slopes)
            if (method%transfer%turning()) call turn_only(store%count(tile), slopes)
         end if
         mass = store%state%mass(store%first(tile):store%first(tile) + store%count(tile) - 1)
         call method%basis%scatter_affine(grid, scratch%shape, 1, mass, scratch%shape%vector, &
            slopes, patch)
      end associate
   end subroutine scatter_affine_fields
end module step_velocity_remap
