! SPDX-License-Identifier: BSD-3-Clause
!> Normalised sums (`&method normalise`): the two parts of the dual gradient are averages over
!! particles. They are divided by the sums of their weights and multiplied by exact integrals.
!!
!! Each edge of a cell and each node, direction by direction, has a factor: the integral of its
!! weight over the sum of the weight times the volumes of the particles. Force, strain and work use
!! the same factors, so the power of the force stays that of the stress and forces on nodes still
!! add up to zero; and in full cells uniform stress makes no force, for any positions of the
!! particles. Factors tend to one towards free surfaces, and where material without normalisation
!! contributes. Equations (Q.7), (Q.8) and (Q.9) of doc/theory/quadratures.md.
module step_normalised_sums
   use base_kinds, only: wp
   use ddmp_alpha, only: mean_alpha
   use material_kinds, only: is_fluid
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch, ensure_weights
   use mesh_rigid, only: held_t
   use mesh_wall, only: node_place
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_node_fields, only: empty_mass
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_pressure_relaxation, only: relaxes_pressure
   use step_simulation, only: machine_t, scheme_t, scratch_t, simulation_t, space_t, &
      velocity_field_t
   use step_tile_cost, only: cost_clock, record_cost
   use step_walls, only: start_walls
   use transfer_cut_cells, only: cut_cells, ramp
   use transfer_edges, only: add_edge_sums, cell_edges, edge_integrals, edges
   use transfer_hoop, only: add_hoop_sums, hoop_edges
   use transfer_moments, only: add_moments, divide_moments, moments
   use transfer_scatter, only: scatter_values
   implicit none
   private

   public :: choose_normalised, counted_columns, find_edge_factors, find_full, normal_columns

   !> Columns of the sums: mass, volume, volume times 1 - alpha of three directions, volume of
   !! materials without normalised sums
   integer, parameter :: mass = 1, volume = 2, unblended = 2, foreign = 6
   integer, parameter :: rows = 7                    !! Columns of node stress, and moments - 1
   real(wp), parameter :: least = 0.02_wp            !! Smallest factor [1]
   real(wp), parameter :: greatest = 50.0_wp         !! Largest factor [1]
   !> Bound on the mean of the factors of a direction. A few particles that represent a whole cell
   !! are stiffer by this factor, and a step of 0.4 h/c is stable up to 1/0.4^2 [1]
   real(wp), parameter :: stiffest = 6.0_wp
   !> Weight of the fill of nodes on closed boundaries. Half as many particles surround such a node,
   !! so random fluctuations bring its fill below a bound more often [1]
   real(wp), parameter :: beside = 1.5_wp
   real(wp), parameter :: clear = 4.0_wp !! Ratio to the accepted fraction of other material [1]

contains

   !> Select the materials whose sums are normalised; without any, nothing is allocated.
   subroutine choose_normalised(simulation)
      type(simulation_t), intent(inout) :: simulation !! With materials and method
      integer :: n

      associate (method => simulation%scheme%method)
         if (.not. method%dual) return
         if (method%normalise == "none") return
         simulation%scheme%flows = [(is_fluid(simulation%materials(n)), n=1, &
            size(simulation%materials))]
         simulation%scheme%normalises = simulation%scheme%flows .or. method%normalise == "all"
         if (method%normalise == "gases") simulation%scheme%normalises = simulation%scheme%flows &
            .and. &
            [(simulation%materials(n)%carries_energy(), n=1, size(simulation%materials))]
         if (.not. any(simulation%scheme%normalises)) then
            deallocate (simulation%scheme%normalises, simulation%scheme%flows)
            return
         end if
         do n = 1, size(simulation%materials)
            if (simulation%scheme%normalises(n) .and. &
               allocated(simulation%materials(n)%viscosity)) &
               simulation%materials(n)%viscosity%limited = .true.
         end do
         simulation%scheme%mean_alpha = mean_alpha(method%quadrature%alpha, &
            method%quadrature%alpha_centre, simulation%space%grid%dimensions)
      end associate
   end subroutine choose_normalised

   !> Columns of the sums before the moments of pressure.
   pure integer function plain_columns(scheme) result(columns)
      type(scheme_t), intent(in) :: scheme

      columns = merge(foreign - 1, foreign, all(scheme%normalises))
   end function plain_columns

   !> Columns of the sums, with the moments of pressure where some material needs them.
   pure integer function counted_columns(scheme, stores) result(columns)
      type(scheme_t), intent(in) :: scheme
      type(store_t), intent(in) :: stores(:)

      columns = plain_columns(scheme) + merge(moments, 0, relaxes_any(scheme, stores))
   end function counted_columns

   !> Columns of the factors of nodes, with the slopes of pressure where some material needs them.
   pure integer function normal_columns(scheme, stores) result(columns)
      type(scheme_t), intent(in) :: scheme
      type(store_t), intent(in) :: stores(:)

      columns = rows + merge(moments - 1, 0, relaxes_any(scheme, stores))
   end function normal_columns

   !> Are the pressures of some material relaxed?
   pure logical function relaxes_any(scheme, stores) result(yes)
      type(scheme_t), intent(in) :: scheme
      type(store_t), intent(in) :: stores(:)
      integer :: index

      yes = any([(relaxes_pressure(scheme, stores, index), index=1, size(stores))])
   end function relaxes_any

   !> Factors of all edges and nodes for the current particles.
   subroutine find_edge_factors(simulation, field)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp) :: began
      integer, allocatable :: tiles(:)
      integer :: tile, part, n

      associate (nodes => field%nodes, number => simulation%space%grid%tile_nodes)
         call simulation%machine%timer%start(simulation%machine%phase%scatter)
         call ensure_patch(nodes%sums%counted, counted_columns(simulation%scheme, &
            simulation%stores), number, simulation%space%tiles%own)
         call ensure_patch(nodes%sums%factor, cell_edges, simulation%space%grid%tile_cells, &
            simulation%space%tiles%own)
         do part = edge_tiles, inner_tiles
            call next_tiles(simulation, part, tiles)
            !$omp parallel do default(none) shared(simulation, field, tiles) private(began, n) &
            !$omp schedule(dynamic, 1)
            do n = 1, size(tiles)
               began = cost_clock(simulation%machine)
               call count_tile(simulation, field, simulation%scratch(omp_get_thread_num()), &
                  tiles(n), field%nodes%sums%counted(:, :, tiles(n)), &
                  field%nodes%sums%factor(:, :, tiles(n)))
               call record_cost(simulation%machine, tiles(n), began)
            end do
            !$omp end parallel do
            call send_patches(simulation, part, nodes%sums%counted)
         end do
         call simulation%machine%timer%stop(simulation%machine%phase%scatter)
         call simulation%machine%timer%start(simulation%machine%phase%grid)
         ! positions of walls do not depend on how long the forces act; all tiles are known by now
         if (allocated(simulation%space%rigid)) call start_walls(simulation, 0.0_wp)
         call ensure_weights(nodes%dual%weight, simulation%space%grid%tile_cells, &
            simulation%space%tiles%all)
         call ensure_patch(nodes%sums%covered, 1, number, simulation%space%tiles%all)
         if (allocated(simulation%space%rigid)) call ensure_patch(nodes%sums%present, 1, number, &
            simulation%space%tiles%all)
         call ensure_patch(nodes%sums%normal, normal_columns(simulation%scheme, &
            simulation%stores), number, simulation%space%tiles%all)
         !$omp parallel do default(none) shared(simulation, field) private(began, tile) &
         !$omp schedule(static)
         do tile = 1, simulation%space%tiles%all
            began = cost_clock(simulation%machine)
            call judge_cells(simulation, field, tile)
            call record_cost(simulation%machine, tile, began)
         end do
         !$omp end parallel do
         !$omp parallel do default(none) shared(simulation, field) private(began, tile) &
         !$omp schedule(static)
         do tile = 1, simulation%space%tiles%all
            began = cost_clock(simulation%machine)
            call find_node_factors(simulation, field, tile)
            call record_cost(simulation%machine, tile, began)
         end do
         !$omp end parallel do
         call simulation%machine%timer%stop(simulation%machine%phase%grid)
      end associate
   end subroutine find_edge_factors

   !> Cells whose nodes count as full, of a material without strength; in other cells particles are
   !! not split.
   subroutine find_full(space, scheme, machine, field, index, full)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: index                   !! Index of the material and of its store
      logical, allocatable, intent(out) :: full(:, :) !! (0:cells - 1, tile)
      real(wp) :: began
      integer :: tile, cell, lane

      if (.not. allocated(scheme%flows)) return
      if (.not. scheme%flows(index)) return
      allocate (full(0:space%grid%tile_cells - 1, space%tiles%own), source=.true.)
      !$omp parallel do default(none) shared(space, scheme, machine, field, full) &
      !$omp private(began, tile, cell, lane) schedule(static)
      do tile = 1, space%tiles%own
         began = cost_clock(machine)
         do cell = 0, space%grid%tile_cells - 1
            do lane = 1, 2**space%grid%dimensions
               full(cell, tile) = full(cell, tile) .and. field%nodes%sums%normal(4, &
                  space%grid%first_node(cell) + space%grid%lane_offset(lane), &
                  tile) > 0.0_wp
            end do
         end do
         call record_cost(machine, tile, began)
      end do
      !$omp end parallel do
   end subroutine find_full

   !> Sums of the particles of a tile around its nodes and the edges of its cells.
   subroutine count_tile(simulation, field, scratch, tile, patch, sums)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp), contiguous, intent(inout) :: sums(:, :)  !! (edge, cell) [m3]
      integer :: index, p, l, first, count

      call clear_patch(patch)
      sums = 0.0_wp
      do index = field%first_store, field%last_store
         count = simulation%stores(index)%count(tile)
         if (count == 0) cycle
         first = simulation%stores(index)%first(tile)
         associate (store => simulation%stores(index), grid => simulation%space%grid, &
            shape => scratch%shape, start => simulation%stores(index)%cell_start(:, tile))
            call locate_particles_plainly(simulation%space, simulation%scheme, scratch, store, tile)
            shape%values(:count, 1) = store%state%mass(first:first + count - 1)
            call scatter_values(grid, start, shape%local, 1, shape%values, mass - 1, patch)
            shape%values(:count, 1) = store%state%volume(first:first + count - 1)
            do l = 1, 3
               do p = 1, count
                  shape%values(p, 1 + l) = shape%values(p, 1)*(1.0_wp - shape%alpha(p, l))
               end do
            end do
            call scatter_values(grid, start, shape%blend, 4, shape%values, volume - 1, patch)
            if (.not. simulation%scheme%normalises(index)) call scatter_values(grid, start, &
               shape%blend, 1, shape%values, foreign - 1, patch)
            call add_edge_sums(grid, start, first, shape%blend, shape%alpha, &
               store%state%volume, sums)
            if (grid%axisymmetric) call add_hoop_sums(grid, start, first, shape%local, &
               store%position, store%state%volume, sums)
            if (relaxes_pressure(simulation%scheme, simulation%stores, index)) call &
               add_moments(grid, start, first, &
               shape%local, store%state%volume, store%state%stress, &
                  plain_columns(simulation%scheme), &
               patch)
         end associate
      end do
   end subroutine count_tile

   !> Fill of the cells of a tile, and the factors of their edges. Where a cell has a weight below
   !! 1, the edges take the rest of the node part.
   subroutine judge_cells(simulation, field, tile)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      real(wp) :: sums(size(field%nodes%sums%counted, 1), simulation%space%grid%tile_nodes)
      real(wp) :: filled(volume, simulation%space%grid%tile_nodes), &
         around(simulation%space%grid%tile_nodes)
      real(wp) :: shares(cell_edges, simulation%space%grid%tile_cells)
      real(wp) :: weight(simulation%space%grid%tile_cells), full(simulation%space%grid%tile_cells)
      real(wp) :: own(simulation%space%grid%tile_cells)
      real(wp) :: ring(size(hoop_edges), simulation%space%grid%tile_cells)
      integer :: cell

      associate (grid => simulation%space%grid, nodes => field%nodes, &
         coordinate => simulation%space%tiles%coordinate(:, tile))
         call assemble(grid, simulation%space%tiles, nodes%sums%counted, tile, sums)
         nodes%sums%normal(:3, :, tile) = sums(unblended + 1:unblended + 3, :)
         call grid%node_volume(coordinate, around)
         call simulation%scheme%dual%cell_weights(grid, sums, volume, around, weight)
         ! from the fill alone, with the same density everywhere
         filled(mass, :) = around
         nodes%sums%normal(5, :, tile) = 1.0_wp
         own = 1.0_wp
         if (size(nodes%sums%normal, 1) > rows) call &
            divide_moments(sums(plain_columns(simulation%scheme) &
            + 1:, :), nodes%sums%normal(rows + 1:, :, tile))
         if (.not. all(simulation%scheme%normalises)) then
            nodes%sums%normal(5, :, tile) = max(0.0_wp, 1.0_wp - clear*sums(foreign, :) &
               /max(sums(volume, :), empty_mass))
            filled(volume, :) = simulation%scheme%dual%enough*nodes%sums%normal(5, :, tile)*around
            call simulation%scheme%dual%cell_weights(grid, filled, volume, around, own)
         end if
         filled(volume, :) = nodes%sums%normal(5, :, tile)*sums(volume, :)
         call find_fill(simulation%space, simulation%scheme, tile, around, filled(volume, :), full)
         call clear_patch(nodes%sums%covered(:, :, tile))
         call simulation%scheme%dual%add_volume(grid, coordinate, full, nodes%sums%covered(:, :, &
            tile))
         shares = 1.0_wp
         ring = 1.0_wp
         if (allocated(simulation%space%rigid)) then
            ! of nodes in rigid regions only existing cells count: others hold no particles
            call add_present(simulation%space, simulation%scheme, field, tile, around)
            if (allocated(simulation%space%rigid%held(tile)%node)) call cut_cells(grid, &
               coordinate, &
               simulation%space%rigid, tile, simulation%scheme%method%quadrature%smooth, shares, &
                  ring)
            ! cells of a node must not have more weight than their free volume
            do cell = 1, size(full)
               weight(cell) = min(weight(cell), minval(shares(:, cell)))
            end do
         end if
         nodes%dual%weight(:size(weight), tile) = weight
         if (tile > simulation%space%tiles%own) return
         call find_cell_factors(simulation, field, tile, full, own, weight, shares, ring)
      end associate
   end subroutine judge_cells

   !> How far cells are full: from half of the volume around their nodes on, like the weights of
   !! cells of doc/theory/method.md in a plane.
   subroutine find_fill(space, scheme, tile, around, volumes, full)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: tile
      real(wp), intent(in) :: around(:)              !! (node) Volume around a node [m3]
      real(wp), intent(in) :: volumes(:)             !! (node) That of particles in the scope [m3]
      real(wp), intent(out) :: full(:)               !! (cell) 0 to 1
      real(wp) :: filled(volume, size(around))
      integer :: cell

      associate (grid => space%grid, coordinate => space%tiles%coordinate(:, tile))
         filled(mass, :) = around
         filled(volume, :) = 2.0_wp*scheme%dual%enough*volumes
         if (grid%axisymmetric) call count_inner(grid, coordinate, filled(volume, :))
         call space%boundary%raise(grid, coordinate, beside, filled(volume, :))
         if (allocated(space%rigid)) call fill_held(space%rigid%held(tile), around, &
            filled(volume, :))
         call scheme%dual%cell_weights(grid, filled, volume, around, full)
         do cell = 1, size(full)
            full(cell) = ramp(2.0_wp*full(cell) - 1.0_wp)
         end do
      end associate
   end subroutine find_fill

   !> Factors of the edges of the cells of a tile.
   subroutine find_cell_factors(simulation, field, tile, full, own, weight, shares, ring)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      real(wp), intent(in) :: full(:)                !! (cell) Fill, 0 to 1
      real(wp), intent(in) :: own(:)                 !! (cell) Degree of normalisation, 0 to 1
      real(wp), intent(in) :: weight(:)              !! (cell) Weight of its part on the nodes
      real(wp), intent(in) :: shares(:, :)           !! (edge, cell) Fraction outside of walls [1]
      real(wp), intent(in) :: ring(:, :) !! (lane, cell) Factor of hoop terms at walls [1]
      real(wp) :: whole(cell_edges), rest(cell_edges)
      integer :: cell

      associate (grid => simulation%space%grid, factor => field%nodes%sums%factor(:, :, tile))
         whole = edge_integrals(grid, 0)
         do cell = 1, size(full)
            rest = (1.0_wp - simulation%scheme%mean_alpha)*weight(cell)
            if (grid%axisymmetric) then
               whole = edge_integrals(grid, simulation%space%tiles%coordinate(1, &
                  tile)*grid%width(1) &
                  + mod(cell - 1, grid%width(1)))
               ! no part of the hoop terms is on nodes
               rest(hoop_edges) = 0.0_wp
            end if
            call find_edges(full(cell), own(cell), whole, rest, shares(:, cell), &
               grid%axisymmetric, factor(:, cell))
            if (grid%axisymmetric) factor(hoop_edges, cell) = factor(hoop_edges, cell)*ring(:, cell)
         end do
      end associate
   end subroutine find_cell_factors

   !> The halves of a node are the volumes on either side of it: inside of its radius this is less
   !! than half of its volume, by a third of a cell over the radius.
   pure subroutine count_inner(grid, coordinate, filled)
      type(grid_t), intent(in) :: grid               !! The grid, axisymmetric
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      real(wp), intent(inout) :: filled(:)           !! (node) Volume of particles [m3]
      real(wp) :: place(3)
      integer :: node

      do node = 1, size(filled)
         place = node_place(grid, coordinate, node)
         if (place(1) > 0.5_wp*grid%spacing) filled(node) = filled(node) &
            /(1.0_wp - grid%spacing/(3.0_wp*place(1)))
      end do
   end subroutine count_inner

   !> Volume of the cells of a tile around its nodes in rigid regions.
   subroutine add_present(space, scheme, field, tile, around)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      real(wp), intent(in) :: around(:)              !! (node) Volume around a node [m3]
      real(wp) :: one(space%grid%tile_cells), whole(volume, size(around))

      call clear_patch(field%nodes%sums%present(:, :, tile))
      if (.not. space%rigid%holds(tile)) return
      ! all cells of the tile that are in the box
      whole = spread(around, 1, volume)
      call scheme%dual%cell_weights(space%grid, whole, volume, around, one)
      call scheme%dual%add_volume(space%grid, space%tiles%coordinate(:, tile), one, &
         field%nodes%sums%present(:, :, tile))
   end subroutine add_present

   !> Nodes in rigid regions count as full: the free part of a cut cell carries the pressure of the
   !! whole cell and is compressed as fast as its walls approach each other, in agreement with the
   !! integrals over the whole cell.
   pure subroutine fill_held(held, around, filled)
      type(held_t), intent(in) :: held               !! Nodes of the tile in rigid regions
      real(wp), intent(in) :: around(:)              !! (node) Volume around a node [m3]
      real(wp), intent(inout) :: filled(:)           !! (node) That of particles [m3]

      if (allocated(held%node)) filled(held%node) = around(held%node)
   end subroutine fill_held

   !> Factors of the edges of a cell from their sums. Less material than volume may be a free
   !! surface; more material than volume is always an error. Equation (Q.7).
   pure subroutine find_edges(full, own, whole, rest, share, axisymmetric, factor)
      real(wp), intent(in) :: full                   !! Filled fraction of the cell, 0 to 1
      real(wp), intent(in) :: own                    !! Fraction of its material in the scope
      real(wp), intent(in) :: whole(:)               !! (edge) Integral of its weight [m3]
      real(wp), intent(in) :: rest(:)                !! (edge) Fraction transmitted by nodes [1]
      real(wp), intent(in) :: share(:)               !! (edge) Fraction outside of walls [1]
      logical, intent(in) :: axisymmetric            !! Are there rings?
      real(wp), intent(inout) :: factor(:)           !! (edge) Sums [m3] in, factors [1] out
      real(wp) :: target(size(factor)), ratio, most, stiff
      integer :: e

      target = whole*max(share - rest, 0.0_wp)
      do e = 1, size(factor)
         ! the weight of a ring is the shape function of its node, so its sum scales with the square
         ! of the free cell fraction
         most = greatest
         if (axisymmetric .and. any(hoop_edges == e)) most = greatest**2
         if (mod(e - 1, edges) == 0) then
            associate (group => [e, e + 1, e + 2, e + 3])
               stiff = 1.0_wp
               if (minval(share) >= 1.0_wp .and. sum(target(group)) > stiffest*sum(factor(group))) &
                  stiff = stiffest*sum(factor(group))/sum(target(group))
            end associate
         end if
         ratio = 0.0_wp
         if (target(e) > 0.0_wp) ratio = stiff*target(e)/min(max(factor(e), target(e)/most), &
            target(e)/least)
         factor(e) = 1.0_wp + merge(own, full, ratio < 1.0_wp)*(ratio - 1.0_wp)
      end do
   end subroutine find_edges

   !> Factors of the node stress and the node gradient along each direction where the cells around
   !! are full, and how full these are. Equation (Q.8).
   subroutine find_node_factors(simulation, field, tile)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      real(wp) :: covered(1, simulation%space%grid%tile_nodes), &
         around(simulation%space%grid%tile_nodes)
      real(wp) :: due(simulation%space%grid%tile_nodes)
      real(wp) :: whole, cells, own, ratio
      integer :: node, l

      associate (grid => simulation%space%grid, nodes => field%nodes)
         call assemble(grid, simulation%space%tiles, nodes%sums%covered, tile, covered)
         call grid%node_volume(simulation%space%tiles%coordinate(:, tile), around)
         ! a cell without material ends the region, and next to the axis also the cell with the
         ! smaller fraction
         cells = merge(6.0_wp, real(2**grid%dimensions, wp), grid%axisymmetric)
         call find_due(simulation%space, field, tile, around, due)
         do node = 1, size(around)
            associate (normal => nodes%sums%normal(:, node, tile))
               own = normal(5)
               normal(4) = 0.0_wp
               normal(5:7) = 0.0_wp
               if (.not. around(node) > empty_mass) cycle
               normal(4) = max(0.0_wp, 1.0_wp - cells*(due(node) - covered(1, node))/around(node))
               whole = (1.0_wp - simulation%scheme%mean_alpha)*around(node)
               do l = 1, 3
                  ratio = whole/min(max(normal(l), whole/greatest), whole/least)
                  normal(4 + l) = (1.0_wp - normal(4))*(1.0_wp + own*(min(1.0_wp, ratio) - 1.0_wp))
                  normal(l) = normal(4)*ratio/around(node)
               end do
            end associate
         end do
      end associate
   end subroutine find_node_factors

   !> Volume that must be filled for a node to count as full: that around the node, for nodes in
   !! rigid regions that of existing cells.
   pure subroutine find_due(space, field, tile, around, due)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      real(wp), intent(in) :: around(:)              !! (node) Volume around a node [m3]
      real(wp), intent(out) :: due(:)                !! (node) [m3]
      real(wp) :: present(1, size(due))

      due = around
      if (.not. allocated(space%rigid)) return
      if (.not. space%rigid%holds(tile)) return
      call assemble(space%grid, space%tiles, field%nodes%sums%present, tile, present)
      associate (node => space%rigid%held(tile)%node)
         due(node) = present(1, node)
      end associate
   end subroutine find_due
end module step_normalised_sums
