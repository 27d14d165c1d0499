! SPDX-License-Identifier: BSD-3-Clause
!> Scatter particles to the patches of nodes, tile by tile.
module step_particles_to_nodes
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use mesh_packed_patch, only: move_packed_patches
   use mesh_patch, only: clear_patch, empty_box, widen_box
   use mesh_surface_load, only: add_loads
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_motion
   use step_simulation, only: scheme_t, scratch_t, simulation_effects_t, simulation_t, space_t, &
      velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   use transfer_bbar, only: average_pressure
   use transfer_scatter, only: dual_columns, motion_columns
   use transfer_shape_data, only: shape_data_t
   use transfer_side_kernels, only: scatter_sides
   implicit none
   private

   public :: find_loads, locate_particles, locate_particles_plainly, may_be_lean, nodes_seen, &
      particles_to_nodes, &
      tensor_rows, &
      vector_rows

   integer, parameter :: force_before = 4            !! Columns of a patch before the force

contains

   !> Scatter mass, momentum and force of all particles to the patches of their tiles, and exchange
   !! patches with other ranks.
   subroutine particles_to_nodes(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer, allocatable :: tiles(:)
      integer :: part, n
      real(wp) :: began

      ! the sums of the other side are computed with those of the first
      if (field%last_store < field%first_store) return
      call simulation%machine%timer%start(simulation%machine%phase%scatter)
      call find_boxes(simulation, field)
      call ensure_motion(simulation%space, simulation%scheme, field)
      if (field%other > 0) call find_other_boxes(simulation, field, simulation%fields(field%other))
      do part = edge_tiles, inner_tiles
         call next_tiles(simulation, part, tiles)
         !$omp parallel do default(none) shared(simulation, field, tiles) private(n, began) &
         !$omp schedule(dynamic, 1)
         do n = 1, size(tiles)
            began = cost_clock(simulation%machine)
            call scatter_tile(simulation, field, simulation%scratch(omp_get_thread_num()), tiles(n))
            call record_cost(simulation%machine, tiles(n), began)
         end do
         !$omp end parallel do
         call send_motion(simulation, field, part)
      end do
      do part = edge_tiles, inner_tiles
         if (field%other > 0) call send_motion(simulation, simulation%fields(field%other), part)
      end do
      call simulation%machine%timer%stop(simulation%machine%phase%scatter)
   end subroutine particles_to_nodes

   !> Nodes that the particles of own tiles touch. Where particles are few, node fields are kept for
   !! these nodes alone.
   subroutine find_boxes(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp) :: began
      logical :: used(simulation%space%grid%tile_cells)
      integer :: tile, index

      associate (touched => field%nodes%motion%touched, grid => simulation%space%grid, &
         own => simulation%space%tiles%own)
         call touched%ensure(own)
         !$omp parallel do default(none) shared(simulation, field) &
         !$omp private(began, tile, index, used) schedule(static)
         do tile = 1, simulation%space%tiles%own
            began = cost_clock(simulation%machine)
            call empty_box(field%nodes%motion%touched%box(:, :, tile))
            do index = field%first_store, field%last_store
               associate (store => simulation%stores(index))
                  if (store%count(tile) == 0) cycle
                  used = store%cell_start(1:, tile) &
                     > store%cell_start(:simulation%space%grid%tile_cells - 1, tile)
               end associate
               call widen_box(simulation%space%grid, used, field%nodes%motion%touched%box(:, :, &
                  tile))
            end do
            call record_cost(simulation%machine, tile, began)
         end do
         !$omp end parallel do
         call touched%line_up(grid, simulation%space%tiles)
         field%nodes%motion%lean = may_be_lean(simulation%scheme, simulation%effects) .and. &
            int(own, int64)*grid%tile_nodes > count_own(simulation%stores)
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
            allocated(scheme%normalises) .or. &
            method%transfer%sweeps() > 0 .or. method%controlled() .or. method%differing() .or. &
            method%remaps())
      end associate
   end function may_be_lean

   !> Allocate the packed patches of the motion. The node gradient of the previous step used the
   !! memory of the node stress.
   pure subroutine ensure_motion(space, scheme, field)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(inout) :: field

      associate (nodes => field%nodes, grid => space%grid, dual => scheme%method%dual)
         if (.not. allocated(nodes%motion%packed(1)%row)) then
            if (dual) then
               call nodes%motion%packed(1)%keep(motion_columns + 1, [.true., vector_rows(grid), &
                  vector_rows(grid), .true.])
               call nodes%motion%packed(2)%keep(dual_columns - motion_columns - 1, &
                  tensor_rows(grid))
            else
               call nodes%motion%packed(1)%keep(motion_columns, [.true., vector_rows(grid), &
                  vector_rows(grid)])
            end if
         end if
         call nodes%motion%packed(1)%ensure(nodes%motion%touched%nodes())
         if (.not. dual) return
         call move_packed_patches(nodes%dual%gradient, nodes%motion%packed(2))
         call nodes%motion%packed(2)%ensure(nodes%motion%touched%nodes())
      end associate
   end subroutine ensure_motion

   !> Components of a vector that can be nonzero.
   pure function vector_rows(grid) result(kept)
      type(grid_t), intent(in) :: grid
      logical :: kept(3)

      kept = grid%active
   end function vector_rows

   !> The same of a tensor whose component (k, l) is in row k + 3 (l - 1).
   pure function tensor_rows(grid) result(kept)
      type(grid_t), intent(in) :: grid
      logical :: kept(9)
      integer :: l

      do l = 1, 3
         kept(3*l - 2:3*l) = grid%active .and. grid%active(l)
      end do
   end function tensor_rows

   !> One tile.
   subroutine scatter_tile(simulation, field, scratch, tile)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp) :: patch(merge(dual_columns, motion_columns, simulation%scheme%method%dual), &
         simulation%space%grid%tile_nodes)
      integer :: index

      call clear_patch(patch)
      do index = field%first_store, field%last_store
         if (simulation%stores(index)%count(tile) == 0) cycle
         call scatter_store(simulation, field, scratch, index, tile, patch)
      end do
      if (field%other > 0) call scatter_other(simulation, field, scratch, tile, patch)
      associate (nodes => field%nodes)
         call nodes%motion%packed(1)%put(simulation%space%grid, nodes%motion%touched, tile, 1, &
            patch)
         if (simulation%scheme%method%dual) call nodes%motion%packed(2)%put(simulation%space%grid, &
            nodes%motion%touched, &
            tile, motion_columns + 2, patch)
      end associate
   end subroutine scatter_tile

   !> Nodes of the other side of a field: those of tiles with parted nodes.
   subroutine find_other_boxes(simulation, field, other)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field    !! Its sides and boxes are known
      type(velocity_field_t), intent(inout) :: other !! Field of the other side
      integer :: tile

      associate (touched => other%nodes%motion%touched)
         call touched%ensure(simulation%space%tiles%own)
         do tile = 1, simulation%space%tiles%own
            call empty_box(touched%box(:, :, tile))
            if (field%sides%cut(tile)) touched%box(:, :, tile) = &
               field%nodes%motion%touched%box(:, :, tile)
         end do
         call touched%line_up(simulation%space%grid, simulation%space%tiles)
      end associate
      other%nodes%motion%lean = .false.
      call ensure_motion(simulation%space, simulation%scheme, other)
   end subroutine find_other_boxes

   !> Sums of both sides of a field on the parted nodes of a tile.
   subroutine scatter_other(simulation, field, scratch, tile, patch)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field    !! Field with two sides
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node) Patch of the first side
      real(wp) :: both(size(patch, 1), size(patch, 2), 0:1)
      integer :: n, node

      both = 0.0_wp
      if (field%sides%cut(tile)) then
         do n = 1, size(field%sides%store)
            associate (store => simulation%stores(field%sides%before + n))
               if (store%count(tile) == 0) cycle
               call locate_particles(simulation%space, simulation%scheme, field, scratch, store, &
                  tile)
               call scatter_sides(simulation%space%grid, scratch%shape, store, tile, &
                  field%sides%store(n)%other, field%sides%split(:, tile), both)
            end associate
         end do
         do node = 1, size(patch, 2)
            if (field%sides%split(node, tile)) patch(:, node) = both(:, node, 0)
         end do
      end if
      associate (nodes => simulation%fields(field%other)%nodes)
         call nodes%motion%packed(1)%put(simulation%space%grid, nodes%motion%touched, tile, 1, &
            both(:, :, 1))
         if (simulation%scheme%method%dual) call nodes%motion%packed(2)%put( &
            simulation%space%grid, nodes%motion%touched, tile, motion_columns + 2, both(:, :, 1))
      end associate
   end subroutine scatter_other

   !> The particles of one material in a tile.
   subroutine scatter_store(simulation, field, scratch, index, tile, patch)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)

      associate (grid => simulation%space%grid, store => simulation%stores(index), &
         method => simulation%scheme%method, shape => scratch%shape, &
         start => simulation%stores(index)%cell_start(:, tile), &
         first => simulation%stores(index)%first(tile), state => simulation%stores(index)%state)
         call locate_particles(simulation%space, simulation%scheme, field, scratch, store, tile)
         if (allocated(store%affine)) then
            call method%basis%scatter_affine(grid, shape, first, state%mass, store%velocity, &
               store%affine, patch)
         else if (allocated(store%spin)) then
            call method%basis%scatter_turning(grid, shape, first, state%mass, store%velocity, &
               store%spin, patch)
         else
            call method%basis%scatter_motion(grid, shape, first, state%mass, store%velocity, patch)
         end if
         if (allocated(simulation%effects%loads)) call find_loads(simulation, scratch, store, tile)
         if (method%even .or. method%controlled() .or. allocated(simulation%effects%loads) .or. &
            allocated(simulation%space%cell)) then
            call change_stress(simulation%space, simulation%scheme, field, scratch, store, tile)
            if (allocated(simulation%effects%loads)) call scratch%pushed%subtract( &
               store%count(tile), scratch%pushed%load)
            call push_nodes(simulation, shape, 1, scratch%pushed%position, scratch%pushed%volume, &
               scratch%pushed%stress, patch)
         else
            call push_nodes(simulation, shape, first, store%position, state%volume, state%stress, &
               patch)
         end if
         if (allocated(simulation%effects%loads)) call add_load_force(simulation, scratch, store, &
            tile, patch)
         if (allocated(simulation%effects%exact)) call add_body_force(simulation, scratch, index, &
            tile, &
            patch)
      end associate
   end subroutine scatter_store

   !> The stress that the particles of a tile scatter to the nodes, where it differs from the
   !! particle stress.
   subroutine change_stress(space, scheme, field, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      associate (grid => space%grid, start => store%cell_start(:, tile), &
         pushed => scratch%pushed, shape => scratch%shape)
         call pushed%copy(store%first(tile), store%count(tile), store%position, &
            store%state%volume, store%state%stress)
         if (scheme%method%even) call average_pressure(grid, start, pushed%volume, pushed%stress)
         if (scheme%method%controlled()) then
            call scheme%method%basis%gather_values(grid, shape, &
               field%nodes%stress%star(:, :, tile), shape%values)
            call pushed%subtract(store%count(tile), shape%values)
         end if
         if (allocated(space%cell)) call space%cell%pull_back(store%count(tile), pushed%volume, &
            pushed%stress)
      end associate
   end subroutine change_stress

   !> Force of the stress of the particles of a tile.
   subroutine push_nodes(simulation, shape, first, position, volume, stress, patch)
      type(simulation_t), intent(in) :: simulation
      type(shape_data_t), intent(inout) :: shape        !! Shape data of the tile
      integer, intent(in) :: first                   !! First particle of the tile in the arrays
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: volume(:)  !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :) !! (particle, 6) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)

      associate (grid => simulation%space%grid, method => simulation%scheme%method)
         if (method%dual) then
            call method%quadrature%scatter_force(grid, shape, first, volume, stress, patch)
         else
            call method%basis%scatter_stress(grid, shape, first, volume, stress, patch)
         end if
         if (grid%axisymmetric) call method%basis%scatter_hoop(grid, shape, first, position, &
            volume, stress, patch)
      end associate
   end subroutine push_nodes

   !> Loads on surfaces as a stress and a force density at the particles of a tile.
   pure subroutine find_loads(simulation, scratch, store, tile)
      type(simulation_t), intent(in) :: simulation   !! With loads
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread; receives them
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      call scratch%pushed%reserve_load(store%count(tile))
      call add_loads(simulation%effects%loads, simulation%space%grid, &
         simulation%space%tiles%coordinate(:, tile), store%first(tile), store%count(tile), &
         store%position, store%body, store%origin%marks, scratch%pushed%load, &
         scratch%pushed%density)
   end subroutine find_loads

   !> Force density of the loads on surfaces, to columns 5 to 7. Equation (O.3) of
   !! doc/theory/instruments.md.
   subroutine add_load_force(simulation, scratch, store, tile, patch)
      type(simulation_t), intent(in) :: simulation   !! With loads
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      integer :: p, q, k

      do k = 1, 3
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            scratch%shape%vector(p, k) = store%state%volume(q)/store%state%mass(q) &
               *scratch%pushed%density(p, k)
         end do
      end do
      call simulation%scheme%method%basis%scatter_product(simulation%space%grid, scratch%shape, &
         store%first(tile), store%state%mass, scratch%shape%vector, force_before, patch)
   end subroutine add_load_force

   !> Body force of an exact solution, to columns 5 to 7.
   subroutine add_body_force(simulation, scratch, index, tile, patch)
      type(simulation_t), intent(in) :: simulation   !! With an exact solution
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp) :: point(3), force(3)
      integer :: p, q, k

      if (.not. allocated(simulation%effects%exact%material(index)%solution)) return
      associate (store => simulation%stores(index), &
         solution => simulation%effects%exact%material(index)%solution)
         if (.not. solution%forced()) return
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            do k = 1, 3
               point(k) = store%origin%reference(q, k)
            end do
            call solution%body_force(point, simulation%effects%exact%force_time, force)
            do k = 1, 3
               scratch%shape%vector(p, k) = force(k)
            end do
         end do
         call simulation%scheme%method%basis%scatter_product(simulation%space%grid, scratch%shape, &
            store%first(tile), store%state%mass, scratch%shape%vector, force_before, patch)
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

      call locate_tile(space, scheme, scratch, store, tile)
      if (allocated(scheme%normalises)) &
         scratch%shape%factor = field%nodes%sums%factor(:, :, tile)
      if (allocated(field%sides)) call field%sides%take_cells(space%grid, tile, scratch%shape)
   end subroutine locate_particles

   !> The same without factors, for effects with separate sums or with sums of all velocity fields.
   subroutine locate_particles_plainly(space, scheme, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      call locate_tile(space, scheme, scratch, store, tile)
      if (allocated(scratch%shape%factor)) deallocate (scratch%shape%factor)
   end subroutine locate_particles_plainly

   !> Compute the shape data of the particles of a tile.
   subroutine locate_tile(space, scheme, scratch, store, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile

      associate (coordinate => space%tiles%coordinate(:, tile))
         call scratch%shape%reserve(store%count(tile))
         call scheme%method%basis%locate(space%grid, coordinate, store, tile, &
            scratch%shape)
         if (scheme%method%dual) call scheme%method%quadrature%locate(space%grid, &
            coordinate, store, tile, scratch%shape)
      end associate
   end subroutine locate_tile

   !> First and last of the nodes that the particles of a tile use.
   pure subroutine nodes_seen(space, field, tile, low, high)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile                    !! An own tile
      integer, intent(out) :: low, high              !! First and last; 1 and 0 without particles

      low = 1
      high = 0
      associate (grid => space%grid, box => field%nodes%motion%touched%box(:, :, tile))
         if (any(box(:, 2) < box(:, 1))) return
         low = 1 + dot_product(box(:, 1) + merge(grid%margin, 0, grid%active), grid%stride)
         high = 1 + dot_product(box(:, 2) + merge(grid%margin, 0, grid%active), grid%stride)
      end associate
   end subroutine nodes_seen
end module step_particles_to_nodes
