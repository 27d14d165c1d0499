! SPDX-License-Identifier: BSD-3-Clause
!> Scatter particles to the patches of nodes, tile by tile.
module step_particles_to_nodes
   use base_kinds, only: int64, wp
   use ddmp_dual, only: add_cell_moments
   use mesh_grid, only: grid_t
   use mesh_packed_patch, only: move_packed_patches
   use mesh_patch, only: clear_patch, empty_box, ensure_weights, widen_box
   use mesh_surface_load, only: add_loads
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_motion
   use step_method, only: method_t
   use step_node_fields, only: dual_layers, motion_nodes_t, nodes_t, stress_rows, tensor_rows, &
      vector_rows, whole_tiles
   use step_simulation, only: machine_t, scheme_t, scratch_t, simulation_effects_t, space_t, &
      velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_bbar, only: average_pressure
   use transfer_scatter, only: dual_columns, motion_columns
   use transfer_shape_data, only: shape_data_t
   use transfer_side_kernels, only: scatter_sides
   implicit none
   private

   public :: copy_stress, find_loads, locate_particles, locate_particles_plainly, &
      may_be_lean, nodes_seen, particles_to_nodes

   integer, parameter :: force_before = 4            !! Columns of a patch before the force

contains

   !> Scatter mass, momentum and force of all particles to the patches of their tiles, and exchange
   !! patches with other ranks.
   subroutine particles_to_nodes(space, stores, fields, scheme, effects, machine, scratches, field)
      type(space_t), intent(inout) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(inout) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(velocity_field_t), intent(inout) :: field
      integer, allocatable :: tiles(:)
      integer :: part, n, tile

      ! the sums of the other side are computed with those of the first
      if (field%last_store < field%first_store) return
      call machine%timer%start(machine%phase%scatter)
      call find_boxes(space, stores, scheme, effects, machine, field)
      call ensure_motion(space%grid, scheme%method, field%nodes)
      field%nodes%motion%layers = layers_needed(space, scheme, effects, field)
      if (scheme%weighs()) call ensure_weights(field%nodes%motion%covered, space%grid%tile_cells, &
         space%tiles%own)
      if (field%other > 0) then
         ! nodes of the other side of a field: those of tiles with parted nodes
         associate (touched => fields(field%other)%nodes%motion%touched)
            call touched%ensure(space%tiles%own)
            do tile = 1, space%tiles%own
               call empty_box(touched%box(:, :, tile))
               if (field%sides%cut(tile)) touched%box(:, :, tile) = &
                  field%nodes%motion%touched%box(:, :, tile)
            end do
            call touched%line_up(space%grid, space%tiles)
         end associate
         fields(field%other)%nodes%motion%lean = .false.
         call ensure_motion(space%grid, scheme%method, fields(field%other)%nodes)
      end if
      do part = edge_tiles, inner_tiles
         call next_tiles(space, machine%communicator, part, tiles)
         !$omp parallel do default(none) shared(space, stores, fields, scheme, effects, machine, &
         !$omp scratches, field, tiles) private(n) schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(machine, tiles(n))
            call scatter_tile(space, stores, fields, scheme, effects, field, &
               scratches(omp_get_thread_num()), tiles(n))
            call stop_cost(machine, tiles(n))
         end do
         !$omp end parallel do
         call send_motion(space, scheme%method, machine, field%nodes%motion, part)
      end do
      do part = edge_tiles, inner_tiles
         if (field%other > 0) call send_motion(space, scheme%method, machine, &
            fields(field%other)%nodes%motion, part)
      end do
      call machine%timer%stop(machine%phase%scatter)
   end subroutine particles_to_nodes

   !> Layers of cells of the tiles of other ranks, next to own tiles, that give the nodes of own
   !! tiles their values. The plain gradient needs the sums of the common nodes alone. The dual
   !! gradient of these nodes has contributions of one layer of cells; those come from velocities of
   !! the next nodes, whose force has contributions of a second layer; that comes from the stress of
   !! the nodes beyond, whose volume has contributions of a third one. Where nodes have more than
   !! that, the whole tiles are needed.
   pure integer function layers_needed(space, scheme, effects, field) result(layers)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(velocity_field_t), intent(in) :: field

      layers = whole_tiles
      if (space%grid%margin > 0 .or. allocated(effects%contact) .or. &
         allocated(effects%conduction) .or. allocated(effects%exact) .or. &
         allocated(space%rigid) .or. allocated(field%sides)) return
      layers = merge(dual_layers, 0, scheme%method%dual)
   end function layers_needed

   !> Nodes that the particles of own tiles touch. Where particles are few, node fields are kept for
   !! these nodes alone.
   subroutine find_boxes(space, stores, scheme, effects, machine, field)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(machine_t), intent(inout) :: machine
      type(velocity_field_t), intent(inout) :: field
      logical :: used(space%grid%tile_cells)
      integer :: tile, index

      associate (touched => field%nodes%motion%touched, grid => space%grid, own => space%tiles%own)
         call touched%ensure(own)
         !$omp parallel do default(none) shared(space, stores, machine, field) &
         !$omp private(tile, index, used) schedule(static)
         do tile = 1, space%tiles%own
            call start_cost(machine, tile)
            call empty_box(field%nodes%motion%touched%box(:, :, tile))
            do index = field%first_store, field%last_store
               associate (store => stores(index))
                  if (store%count(tile) == 0) cycle
                  used = store%cell_start(1:, tile) > store%cell_start(:space%grid%tile_cells - 1, &
                     tile)
               end associate
               call widen_box(space%grid, used, field%nodes%motion%touched%box(:, :, tile))
            end do
            call stop_cost(machine, tile)
         end do
         !$omp end parallel do
         call touched%line_up(grid, space%tiles)
         field%nodes%motion%lean = may_be_lean(scheme, effects) .and. &
            int(own, int64)*grid%tile_nodes > count_own(stores)
      end associate
   end subroutine find_boxes

   !> Number of particles of this rank. If its tiles have more nodes than this, node fields would
   !! dominate the memory.
   pure integer(int64) function count_own(stores) result(particles)
      type(store_t), intent(in) :: stores(:)
      integer :: index

      particles = 0
      do index = 1, size(stores)
         particles = particles + sum(stores(index)%count)
      end do
   end function count_own

   !> True if no effect needs the fields of all nodes after the step.
   pure logical function may_be_lean(scheme, effects) result(lean)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects

      associate (method => scheme%method)
         lean = .not. (scheme%keeps_nodes .or. allocated(effects%contact) .or. &
            allocated(effects%exact) .or. scheme%repacks .or. &
            allocated(scheme%normalises) .or. method%controlled() .or. method%remaps())
      end associate
   end function may_be_lean

   !> Allocate the packed patches of the motion. The node gradient of the previous step used the
   !! memory of the node stress.
   pure subroutine ensure_motion(grid, method, nodes)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(nodes_t), intent(inout) :: nodes

      associate (motion => nodes%motion, dual => method%dual)
         if (.not. allocated(motion%packed(1)%row)) then
            if (dual) then
               call motion%packed(1)%keep(motion_columns + 1, [.true., vector_rows(grid), &
                  vector_rows(grid), .true.])
               call motion%packed(2)%keep(dual_columns - motion_columns - 1, tensor_rows(grid))
            else
               call motion%packed(1)%keep(motion_columns, [.true., vector_rows(grid), &
                  vector_rows(grid)])
            end if
         end if
         call motion%packed(1)%ensure(motion%touched%nodes())
         if (.not. dual) return
         call move_packed_patches(nodes%dual%gradient, motion%packed(2))
         call motion%packed(2)%ensure(motion%touched%nodes())
      end associate
   end subroutine ensure_motion

   !> One tile.
   subroutine scatter_tile(space, stores, fields, scheme, effects, field, scratch, tile)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(inout) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp) :: patch(merge(dual_columns, motion_columns, scheme%method%dual), &
         space%grid%tile_nodes)
      real(wp) :: moments(0:3, space%grid%tile_cells)
      integer :: index

      call clear_patch(patch)
      moments = 0.0_wp
      do index = field%first_store, field%last_store
         if (stores(index)%count(tile) == 0) cycle
         call scatter_store(space, stores, scheme, effects, field, scratch, index, tile, patch)
         if (scheme%weighs()) call add_cell_moments(scratch%shape%start, &
            stores(index)%first(tile), scratch%shape%local, stores(index)%state%volume, moments)
      end do
      if (scheme%weighs()) call scheme%dual%find_covered(space%grid, &
         space%tiles%coordinate(:, tile), moments, field%nodes%motion%covered(:, tile))
      if (field%other > 0) call scatter_other(space, stores, fields, scheme, field, &
         scratch, tile, patch)
      associate (nodes => field%nodes)
         call nodes%motion%packed(1)%put(space%grid, nodes%motion%touched, tile, 1, patch)
         if (scheme%method%dual) call nodes%motion%packed(2)%put(space%grid, nodes%motion%touched, &
            tile, motion_columns + 2, patch)
      end associate
   end subroutine scatter_tile

   !> Sums of both sides of a field on the parted nodes of a tile.
   subroutine scatter_other(space, stores, fields, scheme, field, scratch, tile, patch)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(inout) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field    !! Field with two sides
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node) Patch of the first side
      real(wp) :: both(size(patch, 1), size(patch, 2), 0:1)
      integer :: n, node

      both = 0.0_wp
      if (field%sides%cut(tile)) then
         do n = 1, size(field%sides%store)
            associate (store => stores(field%sides%before + n))
               if (store%count(tile) == 0) cycle
               call locate_particles(space, scheme, field, scratch, store, tile)
               call scatter_sides(space%grid, scratch%shape, store, tile, &
                  field%sides%store(n)%other, field%sides%split(:, tile), both)
            end associate
         end do
         do node = 1, size(patch, 2)
            if (field%sides%split(node, tile)) patch(:, node) = both(:, node, 0)
         end do
      end if
      associate (nodes => fields(field%other)%nodes)
         call nodes%motion%packed(1)%put(space%grid, nodes%motion%touched, tile, 1, both(:, :, 1))
         if (scheme%method%dual) call nodes%motion%packed(2)%put(space%grid, nodes%motion%touched, &
            tile, motion_columns + 2, both(:, :, 1))
      end associate
   end subroutine scatter_other

   !> The particles of one material in a tile.
   subroutine scatter_store(space, stores, scheme, effects, field, scratch, index, tile, patch)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(simulation_effects_t), intent(in) :: effects
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      integer :: p, q, k

      associate (grid => space%grid, store => stores(index), method => scheme%method, &
         shape => scratch%shape, first => stores(index)%first(tile), state => stores(index)%state)
         call locate_particles(space, scheme, field, scratch, store, tile)
         if (allocated(store%affine)) then
            call method%basis%scatter_affine(grid, shape, first, state%mass, store%velocity, &
               store%affine, patch)
         else if (allocated(store%spin)) then
            call method%basis%scatter_turning(grid, shape, first, state%mass, store%velocity, &
               store%spin, patch)
         else
            call method%basis%scatter_motion(grid, shape, first, state%mass, store%velocity, patch)
         end if
         if (allocated(effects%loads)) call find_loads(space, effects, scratch, store, tile)
         if (method%even .or. method%controlled() .or. allocated(effects%loads) .or. &
            allocated(space%cell)) then
            call copy_stress(space, scheme%method, scratch, store, tile)
            if (method%controlled()) then
               call method%basis%gather_values(grid, shape, field%nodes%stress%star(:, :, tile), &
                  shape%values)
               call scratch%pushed%subtract(store%count(tile), stress_rows(grid), shape%values)
            end if
            if (allocated(effects%loads)) call scratch%pushed%subtract(store%count(tile), &
               [1, 2, 3, 4, 5, 6], scratch%pushed%load)
            call scatter_force(space%grid, scheme%method, shape, 1, scratch%pushed%position, &
               scratch%pushed%volume, scratch%pushed%stress, patch)
         else
            call scatter_force(space%grid, scheme%method, shape, first, store%position, &
               state%volume, state%stress, patch)
         end if
         if (allocated(effects%loads)) then
            ! force density of the loads on surfaces, to columns 5 to 7. Equation (O.3) of
            ! doc/theory/instruments.md
            do k = 1, 3
               do p = 1, store%count(tile)
                  q = store%first(tile) + p - 1
                  scratch%shape%vector(p, k) = store%state%volume(q)/store%state%mass(q) &
                     *scratch%pushed%density(p, k)
               end do
            end do
            call scheme%method%basis%scatter_product(space%grid, scratch%shape, store%first(tile), &
               store%state%mass, scratch%shape%vector, force_before, patch)
         end if
         if (allocated(effects%exact)) call add_body_force(space%grid, stores, scheme%method, &
            effects, scratch, index, tile, patch)
      end associate
   end subroutine scatter_store

   !> Copy the stress and the volume of the particles of a tile that make the force, where they may
   !! differ from those of the particles.
   subroutine copy_stress(space, method, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread; gets the copy
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      associate (pushed => scratch%pushed)
         call pushed%copy(store%first(tile), store%count(tile), store%position, &
            store%state%volume, store%state%stress)
         if (method%even) call average_pressure(space%grid, store%cell_start(:, tile), &
            pushed%volume, pushed%stress)
         if (allocated(space%cell)) call space%cell%pull_back(store%count(tile), pushed%volume, &
            pushed%stress)
      end associate
   end subroutine copy_stress

   !> Force of the stress of the particles of a tile.
   subroutine scatter_force(grid, method, shape, first, position, volume, stress, patch)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(shape_data_t), intent(inout) :: shape        !! Shape data of the tile
      integer, intent(in) :: first                   !! First particle of the tile in the arrays
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: volume(:)  !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :) !! (particle, 6) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)

      if (method%dual) then
         call method%quadrature%scatter_force(grid, shape, first, volume, stress, patch)
      else
         call method%basis%scatter_stress(grid, shape, first, volume, stress, patch)
      end if
      if (grid%axisymmetric) call method%basis%scatter_hoop(grid, shape, first, position, volume, &
         stress, patch)
   end subroutine scatter_force

   !> Loads on surfaces as a stress and a force density at the particles of a tile.
   pure subroutine find_loads(space, effects, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(simulation_effects_t), intent(in) :: effects
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread; receives them
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      call scratch%pushed%reserve_load(store%count(tile))
      call add_loads(effects%loads, space%grid, space%tiles%coordinate(:, tile), &
         store%first(tile), store%count(tile), store%position, store%body, store%origin%marks, &
         scratch%pushed%load, scratch%pushed%density)
   end subroutine find_loads

   !> Body force of an exact solution, to columns 5 to 7.
   subroutine add_body_force(grid, stores, method, effects, scratch, index, tile, patch)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(simulation_effects_t), intent(in) :: effects
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp) :: point(3), force(3)
      integer :: p, q, k

      associate (exact => effects%exact)
         if (.not. allocated(exact%material(index)%solution)) return
         associate (store => stores(index), solution => exact%material(index)%solution)
            if (.not. solution%forced()) return
            do p = 1, store%count(tile)
               q = store%first(tile) + p - 1
               do k = 1, 3
                  point(k) = store%origin%reference(q, k)
               end do
               call solution%body_force(point, exact%force_time, force)
               do k = 1, 3
                  scratch%shape%vector(p, k) = force(k)
               end do
            end do
            call method%basis%scatter_product(grid, scratch%shape, store%first(tile), &
               store%state%mass, scratch%shape%vector, force_before, patch)
         end associate
      end associate
   end subroutine add_body_force

   !> Compute the shape data of the particles of a tile for basis and modified gradient, with the
   !! factors of normalised sums of the velocity field.
   subroutine locate_particles(space, scheme, field, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      call locate_tile(space, scheme%method, scratch, store, tile)
      if (allocated(scheme%normalises)) &
         scratch%shape%factor = field%nodes%sums%factor(:, :, tile)
      if (allocated(field%sides)) call field%sides%take_cells(space%grid, tile, scratch%shape)
   end subroutine locate_particles

   !> The same without factors, for effects with separate sums or with sums of all velocity fields.
   subroutine locate_particles_plainly(space, method, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      call locate_tile(space, method, scratch, store, tile)
      if (allocated(scratch%shape%factor)) deallocate (scratch%shape%factor)
   end subroutine locate_particles_plainly

   !> Compute the shape data of the particles of a tile.
   subroutine locate_tile(space, method, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      associate (coordinate => space%tiles%coordinate(:, tile))
         call scratch%shape%reserve(store%count(tile))
         call method%basis%locate(space%grid, coordinate, store, tile, scratch%shape)
         if (method%dual) call method%quadrature%locate(space%grid, coordinate, store, tile, &
            scratch%shape)
      end associate
   end subroutine locate_tile

   !> First and last of the nodes that the particles of a tile use.
   pure subroutine nodes_seen(grid, motion, tile, low, high)
      type(grid_t), intent(in) :: grid
      type(motion_nodes_t), intent(in) :: motion
      integer, intent(in) :: tile                    !! An own tile
      integer, intent(out) :: low, high              !! First and last; 1 and 0 without particles

      low = 1
      high = 0
      associate (box => motion%touched%box(:, :, tile))
         if (any(box(:, 2) < box(:, 1))) return
         low = 1 + dot_product(box(:, 1) + merge(grid%margin, 0, grid%active), grid%stride)
         high = 1 + dot_product(box(:, 2) + merge(grid%margin, 0, grid%active), grid%stride)
      end associate
   end subroutine nodes_seen
end module step_particles_to_nodes
