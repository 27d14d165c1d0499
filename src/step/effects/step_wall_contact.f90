! SPDX-License-Identifier: BSD-3-Clause
!> Contact of material with boundaries of the domain. A wall acts on a node from the time on at
!! which particles in the cells around it have reached the wall; (R.13) of doc/theory/rigid.md. The
!! functions of the nodes reach further, so without this test it would stop material up to a cell
!! before it arrives. Solids that arrive may leave again; what began on a wall that keeps it may
!! not.
module step_wall_contact
   use base_kinds, only: int64, wp
   use mesh_boundary, only: boundary_t
   use mesh_boundary_condition, only: inward_sign, normal_direction
   use mesh_boundary_nodes, only: has_boundary_nodes
   use mesh_grid, only: grid_t
   use mesh_patch, only: clear_patch, ensure_patch, extent_of
   use mesh_tiles, only: neighbors, shift_to
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_simulation, only: simulation_t, space_t
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_contact, only: particle_widths
   implicit none
   private

   public :: approaches_walls, find_reached_walls

   !> A particle touches a wall at this distance of its surface, in cells: material at rest on a
   !! wall must not leave it by rounding.
   real(wp), parameter :: touch = 1.0e-3_wp
   !> Cells beside a reached one along the wall whose nodes are reached with it. Nodes at the edge
   !! of a contact have little mass; without the wall they would be pushed through it.
   integer, parameter :: beside = 1
   !> Nearest that the middle of a particle comes to a wall before the wall acts, in half edges.
   real(wp), parameter :: nearest = 0.25_wp
   !> Marks of particles: bit n - 1 = has reached wall n, bit n + 5 = began on it.
   integer(int64), parameter :: reached_bits = 63, began_bits = 63*64, marks_end = 4096

contains

   !> Mark the particles that have reached a wall, and find the nodes of walls around them. Nothing
   !! is exchanged between ranks, and walls act everywhere, while all particles next to walls have
   !! reached them.
   subroutine find_reached_walls(simulation, dt)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer, allocatable :: tiles(:)
      integer :: part, n, tile

      associate (space => simulation%space, machine => simulation%machine)
         if (.not. walls_wait(simulation)) return
         call machine%timer%start(machine%phase%scatter)
         call ensure_patch(space%arrived, 1, space%grid%tile_nodes, space%tiles%own)
         do part = edge_tiles, inner_tiles
            call next_tiles(space, machine%communicator, part, tiles)
            !$omp parallel do default(none) shared(simulation, tiles, dt) private(n, tile) &
            !$omp schedule(dynamic, 1)
            do n = 1, size(tiles)
               tile = tiles(n)
               call start_cost(simulation%machine, tile)
               call mark_particles(simulation%space, simulation%clock%step, dt, tile, &
                  simulation%stores, simulation%space%arrived(:, :, tile))
               call stop_cost(simulation%machine, tile)
            end do
            !$omp end parallel do
            if (space%approached) call send_patches(space, machine, part, space%arrived)
         end do
         if (allocated(space%boundary%reached)) deallocate (space%boundary%reached)
         if (space%approached) then
            allocate (space%boundary%reached(space%grid%tile_nodes, space%tiles%all))
            !$omp parallel do default(none) shared(simulation) private(tile) schedule(static)
            do tile = 1, simulation%space%tiles%all
               call find_reached_nodes(simulation%space, tile, &
                  simulation%space%boundary%reached(:, tile))
            end do
            !$omp end parallel do
         end if
         call machine%timer%stop(machine%phase%scatter)
      end associate
   end subroutine find_reached_walls

   !> True if particles are marked, because some wall waits for them.
   pure logical function walls_wait(simulation) result(wait)
      type(simulation_t), intent(in) :: simulation

      wait = .false.
      if (size(simulation%stores) > 0) wait = allocated(simulation%stores(1)%touched)
   end function walls_wait

   !> Mark the particles of a tile that have reached a wall: those that touch it, those that had
   !! reached it and are still in the cells next to it, and all others in the same cell. Those of
   !! the first step began on it; fluids are taken for such from their arrival on, because they wet
   !! it.
   pure subroutine mark_particles(space, step, dt, tile, stores, arrived)
      type(space_t), intent(in) :: space
      integer(int64), intent(in) :: step             !! Steps done
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer, intent(in) :: tile
      type(store_t), intent(inout) :: stores(:)
      real(wp), contiguous, intent(inout) :: arrived(:, :) !! (1, node) At first nodes of cells
      integer(int64) :: marks, begun
      integer :: cell, index, p, layer(6)
      integer, parameter :: normal(6) = [1, 1, 2, 2, 3, 3]
      logical :: near(6), here(6)

      call clear_patch(arrived)
      call find_layers(space%grid, space%boundary, space%tiles%coordinate(:, tile), near, layer)
      if (.not. any(near)) return
      do cell = 0, space%grid%tile_cells - 1
         here = near .and. layer == space%grid%cell_position(normal, cell)
         if (.not. any(here)) cycle
         marks = 0
         do index = 1, size(stores)
            associate (store => stores(index), at => stores(index)%first(tile) - 1)
               do p = at + store%cell_start(cell, tile) + 1, at + store%cell_start(cell + 1, tile)
                  marks = ior(marks, marks_of(space%grid, here, step, dt, store, p))
               end do
            end associate
         end do
         if (marks == 0) cycle
         do index = 1, size(stores)
            associate (store => stores(index), at => stores(index)%first(tile) - 1)
               if (store%cell_start(cell + 1, tile) == store%cell_start(cell, tile)) cycle
               begun = 0
               if (step == 0 .or. store%wets) begun = shiftl(iand(marks, reached_bits), 6)
               marks = ior(marks, begun)
               do p = at + store%cell_start(cell, tile) + 1, at + store%cell_start(cell + 1, tile)
                  store%touched(p) = marks_end*(step + 1) + ior(iand(marks, reached_bits), &
                     ior(begun, iand(iand(marks, began_bits), &
                     marks_before(step, store%touched(p)))))
               end do
            end associate
         end do
         arrived(1, space%grid%first_node(cell)) = real(marks, wp)
      end do
   end subroutine mark_particles

   !> The layers of cells of a tile next to walls that wait.
   pure subroutine find_layers(grid, boundary, coordinate, near, layer)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      logical, intent(out) :: near(6)                !! (face) Has the tile such a layer?
      integer, intent(out) :: layer(6)               !! (face) Its place in the tile, from 0
      integer :: face, normal

      layer = 0
      near = .false.
      do face = 1, 6
         normal = normal_direction(face)
         layer(face) = merge(0, grid%cells(normal) - 1, mod(face, 2) == 1) &
            - coordinate(normal)*grid%width(normal)
         if (boundary%waits(grid, face)) near(face) = has_boundary_nodes(grid, coordinate, face)
      end do
   end subroutine find_layers

   !> Marks that a particle got in the last step, 0 if it was not next to a wall then.
   elemental integer(int64) function marks_before(step, touched) result(marks)
      integer(int64), intent(in) :: step             !! Steps done
      integer(int64), intent(in) :: touched          !! Marks of the particle, with their step

      marks = 0
      if (touched/marks_end == step) marks = mod(touched, marks_end)
   end function marks_before

   !> Marks of a particle at walls next to its cell; (R.13) of doc/theory/rigid.md.
   pure integer(int64) function marks_of(grid, near, step, dt, store, p) result(marks)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: near(6)                 !! (face) Is its cell next to the wall?
      integer(int64), intent(in) :: step             !! Steps done
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(store_t), intent(in) :: store
      integer, intent(in) :: p                       !! Particle
      real(wp) :: half(1), way
      integer :: face, k

      marks = marks_before(step, store%touched(p))
      call particle_widths(grid, p, 1, store%position, store%state%volume, half)
      do face = 1, 6
         if (.not. near(face)) then
            marks = ibclr(ibclr(marks, face - 1), face + 5)
            cycle
         end if
         k = normal_direction(face)
         way = max(0.0_wp, -inward_sign(face)*store%velocity(p, k)*dt)
         if (distance(grid, face, store%position(p, k)) <= touch*grid%spacing &
            + max(half(1) + 0.5_wp*way, nearest*half(1) + way)) marks = ibset(marks, face - 1)
      end do
   end function marks_of

   !> Distance of a position from a boundary [m].
   elemental real(wp) function distance(grid, face, place) result(length)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: place                  !! Coordinate along its normal [m]

      length = inward_sign(face)*(place - merge(grid%lower(normal_direction(face)), &
         grid%upper(normal_direction(face)), mod(face, 2) == 1))
   end function distance

   !> Nodes of a tile, its margin included, at which a wall acts: those of cells with marked
   !! particles, and of the cells beside them along the wall.
   pure subroutine find_reached_nodes(space, tile, reached)
      type(space_t), intent(in) :: space
      integer, intent(in) :: tile
      integer, intent(inout) :: reached(:)           !! (node) Bits
      integer :: place, other, cell, extent(3), origin(3), layer(6)
      logical :: near(6)

      reached = 0
      associate (grid => space%grid, tiles => space%tiles)
         ! most tiles have no nodes on a wall
         call find_layers(grid, space%boundary, tiles%coordinate(:, tile), near, layer)
         if (.not. any(near)) return
         extent = extent_of(grid, tiles, tile)
         do place = 1, neighbors
            other = tiles%neighbor(place, tile)
            if (other == 0) cycle
            call find_layers(grid, space%boundary, tiles%coordinate(:, other), near, layer)
            if (.not. any(near)) cycle
            origin = merge(extent, merge(-extent_of(grid, tiles, other), 0, &
               shift_to(:, place) == -1), shift_to(:, place) == 1)
            do cell = 0, grid%tile_cells - 1
               associate (marks => space%arrived(1, grid%first_node(cell), other))
                  if (marks > 0.0_wp) call reach_nodes(grid, extent, &
                     origin + grid%cell_position(:, cell), nint(marks), reached)
               end associate
            end do
         end do
      end associate
   end subroutine find_reached_nodes

   !> Mark the nodes around a cell.
   pure subroutine reach_nodes(grid, extent, cell, marks, reached)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: extent(3)               !! Cells of the tile
      integer, intent(in) :: cell(3)                 !! The cell, from the corner of the tile
      integer, intent(in) :: marks                   !! Boundaries that its particles have reached
      integer, intent(inout) :: reached(:)           !! (node) Bits
      integer :: face, normal, low(3), high(3), margin(3), x, y, z, node, found

      margin = merge(grid%margin, 0, grid%active)
      do face = 1, 6
         if (.not. btest(marks, face - 1)) cycle
         found = shiftl(merge(65, 1, btest(marks, face + 5)), face - 1)
         normal = normal_direction(face)
         low = cell - beside
         high = cell + 1 + beside
         low(normal) = cell(normal) + merge(0, 1, mod(face, 2) == 1)
         high(normal) = low(normal)
         low = merge(max(low, -margin), 0, grid%active)
         high = merge(min(high, extent + margin), 0, grid%active)
         do z = low(3), high(3)
            do y = low(2), high(2)
               do x = low(1), high(1)
                  node = 1 + dot_product([x, y, z] + margin, grid%stride)
                  reached(node) = ior(reached(node), found)
               end do
            end do
         end do
      end do
   end subroutine reach_nodes

   !> True if a particle of this rank may be near a wall in the next step that it has not reached,
   !! or on which it did not begin. Any answer gives the same results; a wrong no would not.
   logical function approaches_walls(simulation) result(near)
      type(simulation_t), intent(in) :: simulation
      integer :: tile

      near = .false.
      if (.not. walls_wait(simulation)) return
      near = allocated(simulation%scheme%method%splitting) .or. &
         allocated(simulation%effects%inflows)
      !$omp parallel do default(none) shared(simulation) private(tile) reduction(.or.: near) &
      !$omp schedule(static)
      do tile = 1, simulation%space%tiles%own
         if (near) cycle
         near = tile_approaches(simulation%space%grid, simulation%space%boundary, &
            simulation%space%tiles%coordinate(:, tile), simulation%clock%step, tile, &
            simulation%stores)
      end do
      !$omp end parallel do
   end function approaches_walls

   !> True if a particle of a tile is nearer to a wall than the functions of its nodes reach,
   !! without the marks of this step that material has which the wall holds.
   pure logical function tile_approaches(grid, boundary, coordinate, step, tile, stores) &
      result(near)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer(int64), intent(in) :: step             !! Steps done
      integer, intent(in) :: tile                    !! Its index
      type(store_t), intent(in) :: stores(:)
      real(wp) :: reach
      integer(int64) :: needed
      integer :: face, index, p, normal, first, from_wall

      near = .false.
      reach = grid%spacing*(1 + grid%margin)
      do face = 1, 6
         if (.not. boundary%waits(grid, face)) cycle
         normal = normal_direction(face)
         needed = shiftl(merge(65_int64, 1_int64, boundary%keeps(grid, face)), face - 1)
         ! in a step particles move by less than a cell
         first = coordinate(normal)*grid%width(normal)
         from_wall = first
         if (mod(face, 2) == 0) from_wall = grid%cells(normal) &
            - min(first + grid%width(normal), grid%cells(normal))
         if (from_wall > 1 + grid%margin) cycle
         do index = 1, size(stores)
            associate (store => stores(index))
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (distance(grid, face, store%position(p, normal)) > reach) cycle
                  near = iand(marks_before(step, store%touched(p)), needed) /= needed
                  if (near) return
               end do
            end associate
         end do
      end do
   end function tile_approaches
end module step_wall_contact
