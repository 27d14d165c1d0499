! SPDX-License-Identifier: BSD-3-Clause
!> The sides of failed material of bodies that have contact with themselves, determined at the start
!! of each step: four sums over the particles, each exchanged between ranks as patches. See section
!! "Failed material" of doc/theory/contact.md.
module step_sides
   use base_kinds, only: wp
   use mesh_patch, only: assemble, clear_patch, ensure_patch, ensure_weights
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_method, only: method_t
   use step_node_fields, only: empty_mass
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_simulation, only: machine_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_sides, only: add_cell_slopes, choose_sides, find_axis, is_split, join_sides, &
      measure_intact, part_rows, product_rows, set_products, sides_t, weigh_sides
   implicit none
   private

   public :: find_sides

   integer, parameter :: sum_intact = 1              !! Intact volume
   integer, parameter :: sum_slope = 2               !! Gradient of the intact volume
   integer, parameter :: sum_axis = 3                !! Sums for the axes of the nodes
   integer, parameter :: sum_parts = 4               !! Sums for the separation of sides
   !> Rows of the sums
   integer, parameter :: rows(4) = [2, 6, product_rows, part_rows]

contains

   !> Find the sides of the particles of all fields that have two.
   subroutine find_sides(space, stores, fields, method, machine, scratches)
      type(space_t), intent(inout) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(inout) :: fields(:)
      type(method_t), intent(in) :: method
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      integer :: n, kind

      do n = 1, size(fields)
         if (.not. allocated(fields(n)%sides)) cycle
         call machine%timer%start(machine%phase%contact)
         call reserve_sides(space, stores, fields(n))
         do kind = 1, size(rows)
            call add_sums(space, stores, method, machine, scratches, fields(n)%sides, kind)
            call evaluate_sums(space, machine, fields(n)%sides, kind)
         end do
         call join_unsplit_sides(space, stores, machine, fields(n)%sides)
         call machine%timer%stop(machine%phase%contact)
      end do
   end subroutine find_sides

   !> Memory for the sides of the particles of a field and of the nodes.
   subroutine reserve_sides(space, stores, field)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(inout) :: field
      integer :: n, particles

      associate (sides => field%sides, own => space%tiles%own, nodes => space%grid%tile_nodes)
         sides%before = field%first_store - 1
         call ensure_weights(sides%intact, nodes, own)
         call ensure_patch(sides%slope, 3, nodes, own)
         call ensure_patch(sides%axis, 3, nodes, own)
         if (.not. allocated(sides%store)) allocate (sides%store(field%last_store &
            - field%first_store + 1))
         do n = 1, size(sides%store)
            particles = size(stores(sides%before + n)%home)
            if (allocated(sides%store(n)%other)) then
               if (size(sides%store(n)%other) == particles) cycle
               deallocate (sides%store(n)%other)
            end if
            allocate (sides%store(n)%other(particles))
         end do
      end associate
   end subroutine reserve_sides

   !> Sum over the particles of own tiles, and receive the sums of other ranks.
   subroutine add_sums(space, stores, method, machine, scratches, sides, kind)
      type(space_t), intent(inout) :: space
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(sides_t), intent(inout) :: sides          !! The two sides of a field
      integer, intent(in) :: kind                    !! One of the sums above
      integer, allocatable :: tiles(:)
      integer :: part, n

      call ensure_patch(sides%patch, rows(kind), space%grid%tile_nodes, space%tiles%own)
      do part = edge_tiles, inner_tiles
         call next_tiles(space, machine%communicator, part, tiles)
         !$omp parallel do default(none) shared(space, stores, method, machine, scratches, sides, &
         !$omp kind, tiles) private(n) schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(machine, tiles(n))
            call add_tile(space, stores, method, sides, scratches(omp_get_thread_num()), &
               kind, tiles(n))
            call stop_cost(machine, tiles(n))
         end do
         !$omp end parallel do
         call send_patches(space, machine, part, sides%patch)
      end do
   end subroutine add_sums

   !> One tile.
   subroutine add_tile(space, stores, method, sides, scratch, kind, tile)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(sides_t), intent(inout) :: sides          !! The two sides of a field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: kind                    !! One of the sums above
      integer, intent(in) :: tile
      integer :: n

      call clear_patch(sides%patch(:, :, tile))
      if (kind == sum_slope) then
         call add_cell_slopes(space%grid, sides%intact(:, tile), sides%patch(:, :, tile))
         return
      end if
      do n = 1, size(sides%store)
         associate (store => stores(sides%before + n), grid => space%grid, basis => method%basis, &
            shape => scratch%shape)
            if (store%count(tile) == 0) cycle
            call locate_particles_plainly(space, method, scratch, store, tile)
            if (kind == sum_parts) then
               call basis%gather_values(grid, shape, sides%slope(:, :, tile), shape%vector)
               call choose_sides(grid, shape, store%first(tile), shape%vector, &
                  sides%axis(:, :, tile), sides%store(n)%other)
               call weigh_sides(grid, shape, store, tile, sides%axis(:, :, tile), &
                  sides%store(n)%other, sides%patch(:, :, tile))
               cycle
            end if
            select case (kind)
            case (sum_intact)
               call measure_intact(store, tile, shape%values)
            case default
               call basis%gather_values(grid, shape, sides%slope(:, :, tile), shape%vector)
               call set_products(store, tile, shape%vector, shape%values)
            end select
            call basis%scatter_values(grid, shape, min(8, rows(kind)), shape%values, 0, &
               sides%patch(:, :, tile))
            if (kind == sum_axis) call basis%scatter_product(grid, shape, store%first(tile), &
               store%state%volume, shape%vector, 8, sides%patch(:, :, tile))
         end associate
      end do
   end subroutine add_tile

   !> Evaluate the sums on the nodes of all tiles that need it.
   subroutine evaluate_sums(space, machine, sides, kind)
      type(space_t), intent(in) :: space
      type(machine_t), intent(inout) :: machine
      type(sides_t), intent(inout) :: sides          !! Sums are known
      integer, intent(in) :: kind                    !! One of the sums above
      integer :: tile

      ! weights of cells are found in tiles of other ranks too, which are known after an exchange
      call sides%reserve(space%grid%tile_nodes, space%tiles%all)
      !$omp parallel do default(none) shared(space, machine, sides, kind) private(tile) &
      !$omp schedule(static)
      do tile = 1, merge(space%tiles%all, space%tiles%own, kind == sum_parts)
         call start_cost(machine, tile)
         call evaluate_tile(space, sides, kind, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine evaluate_sums

   !> One tile.
   subroutine evaluate_tile(space, sides, kind, tile)
      type(space_t), intent(in) :: space
      type(sides_t), intent(inout) :: sides          !! Sums are known
      integer, intent(in) :: kind                    !! One of the sums above
      integer, intent(in) :: tile
      real(wp) :: sums(rows(kind), space%grid%tile_nodes), around(space%grid%tile_nodes)
      integer :: node

      call assemble(space%grid, space%tiles, sides%patch, tile, sums)
      call space%grid%node_volume(space%tiles%coordinate(:, tile), around)
      select case (kind)
      case (sum_intact)
         do node = 1, size(around)
            sides%intact(node, tile) = -1.0_wp
            if (sums(2, node) > empty_mass) sides%intact(node, tile) = sums(1, node)/sums(2, node)
         end do
      case (sum_slope)
         sides%slope(:, :, tile) = sums(1:3, :)/max(1.0_wp, sums(4:6, :))
      case (sum_axis)
         do node = 1, size(around)
            sides%axis(:, node, tile) = find_axis(sums(:, node), around(node))
         end do
      case default
         do node = 1, size(around)
            sides%split(node, tile) = is_split(sums(:, node))
         end do
         sides%cut(tile) = any(sides%split(:, tile))
      end select
   end subroutine evaluate_tile

   !> Assign particles to the first side again at nodes whose sides have not separated.
   subroutine join_unsplit_sides(space, stores, machine, sides)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(machine_t), intent(inout) :: machine
      type(sides_t), intent(inout) :: sides          !! The two sides of a field
      integer :: tile, n

      !$omp parallel do default(none) shared(space, stores, machine, sides) private(tile, n) &
      !$omp schedule(static)
      do tile = 1, space%tiles%own
         call start_cost(machine, tile)
         do n = 1, size(sides%store)
            associate (store => stores(sides%before + n))
               if (store%count(tile) > 0) call join_sides(space%grid, store%cell_start(:, tile), &
                  store%first(tile), sides%split(:, tile), sides%store(n)%other)
            end associate
         end do
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine join_unsplit_sides
end module step_sides
