! SPDX-License-Identifier: BSD-3-Clause
!> Surfaces of bodies with separate velocity fields, on the nodes that several of them share. See
!! doc/theory/contact.md.
!!
!! The outward areas of the nodes, A_i = sum V_p grad S_i, vanish inside of a body. The extent of
!! the particles along the normals of these areas follows. Both are exchanged between ranks as
!! patches.
module step_contact_surface
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_method, only: method_t
   use step_node_fields, only: empty_mass
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_simulation, only: contact_t, guesses, machine_t, scratch_t, simulation_t, space_t, &
      velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_contact, only: find_reach, particle_widths
   use transfer_scatter, only: motion_columns
   use transfer_side_kernels, only: add_side_areas, find_side_reach
   implicit none
   private

   public :: area_rows, direction_of, find_contact_surfaces, guess_area, reach_row

   real(wp), parameter :: faint = 1.0e-9_wp          !! Areas below this have no direction, in faces

contains

   !> Outward areas of the bodies on the nodes, and the extent of the bodies there.
   subroutine find_contact_surfaces(simulation)
      type(simulation_t), intent(inout) :: simulation !! Fields have their masses
      integer :: fields, rows

      associate (space => simulation%space, machine => simulation%machine)
         fields = size(simulation%fields)
         rows = area_rows(simulation%effects%contact)*fields
         call machine%timer%start(machine%phase%contact)
         call find_meetings(space, simulation%fields, simulation%effects%contact, machine)
         associate (contact => simulation%effects%contact, number => space%grid%tile_nodes)
            call ensure_patch(contact%outward, rows, number, space%tiles%own)
            call sum_patches(simulation, scatter_areas, contact%outward)
            call ensure_patch(contact%area, rows, number, space%tiles%all)
            call sum_areas(space, simulation%effects%contact, machine)
            call ensure_patch(contact%reach, guesses*fields**2, number, space%tiles%own)
            call sum_patches(simulation, scatter_extents, contact%reach)
         end associate
         call machine%timer%stop(machine%phase%contact)
      end associate
   end subroutine find_contact_surfaces

   !> Rows of the patch of areas, for one field.
   pure integer function area_rows(contact) result(rows)
      type(contact_t), intent(in) :: contact         !! With bonds or without

      rows = merge(4, 3, contact%bonded)
   end function area_rows

   !> Own tiles with nodes that several fields share.
   subroutine find_meetings(space, fields, contact, machine)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: fields(:)
      type(contact_t), intent(inout) :: contact
      type(machine_t), intent(inout) :: machine
      integer :: tile, field
      integer :: here(space%grid%tile_nodes)

      if (allocated(contact%meets)) then
         if (size(contact%meets) < space%tiles%all) deallocate (contact%meets)
      end if
      if (.not. allocated(contact%meets)) &
         allocate (contact%meets(space%tiles%all + space%tiles%all/16))
      !$omp parallel do default(none) shared(space, fields, contact, machine) &
      !$omp private(tile, field, here) schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         here = 0
         do field = 1, size(fields)
            where (fields(field)%nodes%motion%mass(1, :, tile) > empty_mass) &
               here = here + 1
         end do
         contact%meets(tile) = any(here > 1)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine find_meetings

   !> Scatter a quantity of the particles to patches, and receive the patches of other ranks.
   subroutine sum_patches(simulation, work, patch)
      type(simulation_t), intent(inout) :: simulation
      interface
         subroutine work(simulation, scratch, tile, patch)
            import :: scratch_t, simulation_t, wp
            implicit none
            type(simulation_t), intent(in) :: simulation
            type(scratch_t), intent(inout) :: scratch
            integer, intent(in) :: tile
            real(wp), contiguous, intent(inout) :: patch(:, :)
         end subroutine work
      end interface
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (row, node, tile)
      integer, allocatable :: tiles(:)
      integer :: part, n

      do part = edge_tiles, inner_tiles
         call next_tiles(simulation%space, simulation%machine%communicator, part, tiles)
         !$omp parallel do default(none) shared(simulation, tiles, patch) private(n) &
         !$omp schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(simulation%machine, tiles(n))
            call work(simulation, simulation%scratch(omp_get_thread_num()), tiles(n), &
               patch(:, :, tiles(n)))
            call stop_cost(simulation%machine, tiles(n))
         end do
         !$omp end parallel do
         call send_patches(simulation%space, simulation%machine, part, patch)
      end do
   end subroutine sum_patches

   !> Outward areas of the particles of a tile: the node forces of unit pressure. With bonds, also
   !! the mass of the particles whose bonds hold. Equation (C.1).
   subroutine scatter_areas(simulation, scratch, tile, patch)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      real(wp) :: wide(motion_columns, simulation%space%grid%tile_nodes)
      integer :: field, index, rows, before

      associate (space => simulation%space, grid => simulation%space%grid, &
         contact => simulation%effects%contact, method => simulation%scheme%method, &
         fields => simulation%fields, stores => simulation%stores, pushed => scratch%pushed)
         call clear_patch(patch)
         if (.not. contact%meets(tile)) return
         rows = area_rows(contact)
         do field = 1, size(fields)
            before = rows*(field - 1)
            call clear_patch(wide)
            do index = fields(field)%first_store, fields(field)%last_store
               if (stores(index)%count(tile) == 0) cycle
               call locate_particles_plainly(space, method, scratch, stores(index), tile)
               call pushed%copy(stores(index)%first(tile), stores(index)%count(tile), &
                  stores(index)%position, stores(index)%state%volume, stores(index)%state%stress)
               call pushed%make_unit(stores(index)%count(tile))
               call method%basis%scatter_stress(grid, scratch%shape, 1, pushed%volume, &
                  pushed%stress, wide)
               if (grid%axisymmetric) call method%basis%scatter_hoop(grid, scratch%shape, 1, &
                  pushed%position, pushed%volume, pushed%stress, wide)
               if (allocated(stores(index)%bond)) then
                  call find_bonded_mass(stores(index), tile, scratch%shape%values)
                  call method%basis%scatter_values(grid, scratch%shape, 1, scratch%shape%values, &
                     before + 3, patch)
               end if
            end do
            if (fields(field)%other > 0) call area_of_side(space, stores, fields, method, scratch, &
               tile, field, wide(5:7, :))
            patch(before + 1:before + 3, :) = -wide(5:7, :)
         end do
      end associate
   end subroutine scatter_areas

   !> Areas of one of two sides at the parted nodes of a tile, in place of those of both together.
   subroutine area_of_side(space, stores, fields, method, scratch, tile, field, inward)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(in) :: fields(:)
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      integer, intent(in) :: field                   !! Index of the velocity field of the side
      real(wp), intent(inout) :: inward(:, :)        !! (3, node) The areas, inward [m2]
      real(wp) :: area(3, size(inward, 2))
      integer :: first, n, node, side

      side = side_of(fields, field)
      first = first_side(fields, field)
      associate (sides => fields(first)%sides)
         if (.not. sides%cut(tile)) return
         area = 0.0_wp
         do n = 1, size(sides%store)
            associate (store => stores(sides%before + n))
               if (store%count(tile) == 0) cycle
               call locate_particles_plainly(space, method, scratch, store, tile)
               call add_side_areas(space%grid, scratch%shape, store, tile, sides%store(n)%other, &
                  sides%split(:, tile), side, area)
            end associate
         end do
         do node = 1, size(area, 2)
            if (sides%split(node, tile)) inward(:, node) = -area(:, node)
         end do
      end associate
   end subroutine area_of_side

   !> The first of the two velocity fields of a body with two sides.
   pure integer function first_side(fields, field) result(first)
      type(velocity_field_t), intent(in) :: fields(:)
      integer, intent(in) :: field                   !! Index of either of them

      first = field
      if (.not. allocated(fields(field)%sides)) first = fields(field)%other
   end function first_side

   !> Side of a body that a velocity field belongs to: 0 for the first, 1 for the second.
   pure integer function side_of(fields, field) result(side)
      type(velocity_field_t), intent(in) :: fields(:)
      integer, intent(in) :: field                   !! Index of the velocity field

      side = merge(0, 1, allocated(fields(field)%sides))
   end function side_of

   !> Mass of the particles of a tile whose bonds hold, in the first column.
   pure subroutine find_bonded_mass(store, tile, values)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(inout) :: values(:, :)        !! (particle of the tile, column) [kg]
      integer :: p, q

      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         values(p, 1) = store%state%mass(q)*store%bond(q)
      end do
   end subroutine find_bonded_mass

   !> Areas of the nodes of all tiles; boundaries of the domain are not surfaces.
   subroutine sum_areas(space, contact, machine)
      type(space_t), intent(in) :: space
      type(contact_t), intent(inout) :: contact
      type(machine_t), intent(inout) :: machine
      integer :: tile

      !$omp parallel do default(none) shared(space, contact, machine) private(tile) schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call sum_tile(space, contact, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine sum_areas

   !> One tile.
   subroutine sum_tile(space, contact, tile)
      type(space_t), intent(in) :: space
      type(contact_t), intent(inout) :: contact
      integer, intent(in) :: tile
      real(wp) :: tensor(9, space%grid%tile_nodes)
      integer :: field, before, k

      if (.not. contact%meets(tile)) return
      call assemble(space%grid, space%tiles, contact%outward, tile, contact%area(:, :, tile))
      do field = 1, size(contact%law, 1)
         before = area_rows(contact)*(field - 1)
         tensor = 0.0_wp
         do k = 1, 3
            tensor(3*k - 2, :) = contact%area(before + k, :, tile)
         end do
         call space%boundary%insulate(space%grid, space%tiles%coordinate(:, tile), tensor)
         do k = 1, 3
            contact%area(before + k, :, tile) = tensor(3*k - 2, :)
         end do
      end do
   end subroutine sum_tile

   !> A candidate for the common area of two fields at a node, outward from the first [m2]: the area
   !! of one, of the other, or the mean of both. It changes its sign with the fields.
   pure function guess_area(contact, tile, node, a, b, guess) result(area)
      type(contact_t), intent(in) :: contact
      integer, intent(in) :: tile
      integer, intent(in) :: node                    !! Index in the tile
      integer, intent(in) :: a, b                    !! The fields, a < b
      integer, intent(in) :: guess                   !! 1 to 3
      real(wp) :: area(3)
      integer :: rows

      rows = area_rows(contact)
      associate (one => contact%area(rows*(a - 1) + 1:rows*(a - 1) + 3, node, tile), &
         other => contact%area(rows*(b - 1) + 1:rows*(b - 1) + 3, node, tile))
         select case (guess)
         case (1)
            area = one
         case (2)
            area = -other
         case default
            area = 0.5_wp*(one - other)
         end select
      end associate
   end function guess_area

   !> Row in which the extent of field a towards field b along a candidate normal is stored.
   pure integer function reach_row(contact, a, b, guess) result(row)
      type(contact_t), intent(in) :: contact
      integer, intent(in) :: a, b                    !! Indices of two velocity fields
      integer, intent(in) :: guess                   !! 1 to 3

      row = guesses*(size(contact%law, 1)*(a - 1) + b - 1) + guess
   end function reach_row

   !> Its direction; zero where the area is too small to have one.
   pure function direction_of(grid, area) result(normal)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: area(3)                !! [m2]
      real(wp) :: normal(3), length

      normal = 0.0_wp
      length = norm2(area)
      if (length > faint*grid%depth *grid%spacing**(grid%dimensions - 1)) normal = area/length
   end function direction_of

   !> Extent of the particles of a tile towards each other field.
   subroutine scatter_extents(simulation, scratch, tile, patch)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      real(wp) :: normal(3, simulation%space%grid%tile_nodes), &
         reach(simulation%space%grid%tile_nodes)
      integer :: a, b, guess

      associate (contact => simulation%effects%contact, fields => simulation%fields)
         patch = -huge(1.0_wp)
         if (.not. contact%meets(tile)) return
         do b = 2, size(fields)
            do a = 1, b - 1
               do guess = 1, guesses
                  call find_normals(simulation%space%grid, fields, contact, tile, a, b, &
                     guess, normal)
                  if (.not. any(abs(normal) > 0.0_wp)) cycle
                  reach = -huge(1.0_wp)
                  call reach_of_both(simulation%space, simulation%stores, fields, &
                     simulation%scheme%method, scratch, tile, a, normal, reach)
                  patch(reach_row(contact, a, b, guess), :) = reach
                  normal = -normal
                  reach = -huge(1.0_wp)
                  call reach_of_both(simulation%space, simulation%stores, fields, &
                     simulation%scheme%method, scratch, tile, b, normal, reach)
                  patch(reach_row(contact, b, a, guess), :) = reach
               end do
            end do
         end do
      end associate
   end subroutine scatter_extents

   !> Candidate normals from one field to another at the nodes of a tile where both have mass.
   subroutine find_normals(grid, fields, contact, tile, a, b, guess, normal)
      type(grid_t), intent(in) :: grid
      type(velocity_field_t), intent(in) :: fields(:)
      type(contact_t), intent(in) :: contact
      integer, intent(in) :: tile
      integer, intent(in) :: a, b                    !! From which field to which, a < b
      integer, intent(in) :: guess                   !! 1 to 3
      real(wp), intent(out) :: normal(:, :)          !! (3, node) 0 without contact [1]
      integer :: node

      normal = 0.0_wp
      do node = 1, size(normal, 2)
         if (.not. fields(a)%nodes%motion%mass(1, node, tile) > empty_mass) cycle
         if (.not. fields(b)%nodes%motion%mass(1, node, tile) > empty_mass) cycle
         normal(:, node) = direction_of(grid, guess_area(contact, tile, node, a, b, guess))
      end do
   end subroutine find_normals

   !> Extent of the particles of one field in a tile along the normals, of one side where nodes have
   !! parted.
   subroutine reach_of_both(space, stores, fields, method, scratch, tile, field, normal, reach)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(in) :: fields(:)
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      integer, intent(in) :: field                   !! Index of the velocity field
      real(wp), contiguous, intent(in) :: normal(:, :) !! (3, node) [1]
      real(wp), contiguous, intent(inout) :: reach(:)  !! (node) [m]
      real(wp) :: joint(3, size(reach))
      integer :: first, node, n

      if (fields(field)%other == 0) then
         call reach_of_field(space, stores, fields, scratch, tile, field, normal, reach)
         return
      end if
      first = first_side(fields, field)
      associate (sides => fields(first)%sides)
         joint = normal
         do node = 1, size(reach)
            if (sides%split(node, tile)) joint(:, node) = 0.0_wp
         end do
         call reach_of_field(space, stores, fields, scratch, tile, field, joint, reach)
         if (sides%cut(tile)) then
            ! the same of one side at the parted nodes
            do n = 1, size(sides%store)
               associate (store => stores(sides%before + n), grid => space%grid)
                  if (store%count(tile) == 0) cycle
                  call locate_particles_plainly(space, method, scratch, store, tile)
                  call particle_widths(grid, store%first(tile), store%count(tile), store%position, &
                     store%state%volume, scratch%shape%values(:, 1))
                  call find_side_reach(grid, scratch%shape, store%first(tile), &
                     sides%store(n)%other, sides%split(:, tile), side_of(fields, field), &
                     scratch%shape%values(:, 1), normal, reach)
               end associate
            end do
         end if
      end associate
   end subroutine reach_of_both

   !> Extent of the particles of one field in a tile along the normals.
   subroutine reach_of_field(space, stores, fields, scratch, tile, field, normal, reach)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(in) :: fields(:)
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      integer, intent(in) :: field                   !! Index of the velocity field
      real(wp), contiguous, intent(in) :: normal(:, :) !! (3, node) [1]
      real(wp), contiguous, intent(inout) :: reach(:)  !! (node) [m]
      integer :: index

      do index = fields(field)%first_store, fields(field)%last_store
         if (stores(index)%count(tile) == 0) cycle
         associate (store => stores(index), grid => space%grid, &
            start => stores(index)%cell_start(:, tile), &
            coordinate => space%tiles%coordinate(:, tile))
            call scratch%shape%reserve(store%count(tile))
            call particle_widths(grid, store%first(tile), store%count(tile), store%position, &
               store%state%volume, scratch%shape%values(:, 1))
            call find_reach(grid, grid%tile_corner(coordinate), start, store%first(tile), &
               store%position, scratch%shape%values(:, 1), normal, reach)
         end associate
      end do
   end subroutine reach_of_field
end module step_contact_surface
