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
   use ddmp_dual, only: dual_t
   use material_kinds, only: is_fluid, is_gas
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch, ensure_weights
   use mesh_wall, only: node_place
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_ledger, only: ledger_t
   use step_node_fields, only: empty_mass, nodes_t, normalised_nodes_t
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_simulation, only: clock_t, machine_t, scheme_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   use step_walls, only: start_walls
   use transfer_cut_cells, only: cut_cells, ramp
   use transfer_edges, only: add_edge_sums, cell_edges, edge_integrals, edges
   use transfer_hoop, only: add_hoop_sums, hoop_edges
   use transfer_scatter, only: scatter_values
   implicit none
   private

   public :: choose_normalised, counted_columns, find_edge_factors, find_full, normal_columns

   !> Columns of the sums: mass, volume, volume times 1 - alpha of three directions, volume of
   !! materials without normalised sums
   integer, parameter :: mass = 1, volume = 2, unblended = 2, foreign = 6
   integer, parameter :: normal_columns = 7          !! Columns of node stress
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
   subroutine choose_normalised(grid, materials, scheme)
      type(grid_t), intent(in) :: grid
      type(material_t), intent(inout) :: materials(:)
      type(scheme_t), intent(inout) :: scheme
      integer :: n

      associate (method => scheme%method)
         if (.not. method%dual) return
         if (method%normalise == "none") return
         scheme%flows = [(is_fluid(materials(n)), n=1, size(materials))]
         scheme%normalises = scheme%flows .or. method%normalise == "all"
         if (method%normalise == "gases") scheme%normalises = &
            [(is_gas(materials(n)), n=1, size(materials))]
         if (.not. any(scheme%normalises)) then
            deallocate (scheme%normalises, scheme%flows)
            return
         end if
         do n = 1, size(materials)
            if (scheme%normalises(n) .and. allocated(materials(n)%viscosity)) &
               materials(n)%viscosity%limited = .true.
         end do
         scheme%mean_alpha = mean_alpha(method%quadrature%alpha, method%quadrature%alpha_centre, &
            grid%dimensions)
      end associate
   end subroutine choose_normalised

   !> Columns of the sums.
   pure integer function counted_columns(scheme) result(columns)
      type(scheme_t), intent(in) :: scheme

      columns = merge(foreign - 1, foreign, all(scheme%normalises))
   end function counted_columns

   !> Factors of all edges and nodes for the current particles.
   subroutine find_edge_factors(space, stores, scheme, clock, ledger, machine, scratches, field)
      type(space_t), intent(inout) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(clock_t), intent(in) :: clock
      type(ledger_t), intent(inout) :: ledger
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(velocity_field_t), intent(inout) :: field
      integer, allocatable :: tiles(:)
      integer :: tile, part, n

      associate (nodes => field%nodes, number => space%grid%tile_nodes, own => space%tiles%own, &
         all => space%tiles%all)
         call machine%timer%start(machine%phase%scatter)
         call ensure_patch(nodes%sums%counted, counted_columns(scheme), number, own)
         call ensure_patch(nodes%sums%factor, cell_edges, space%grid%tile_cells, own)
         do part = edge_tiles, inner_tiles
            call next_tiles(space, machine%communicator, part, tiles)
            !$omp parallel do default(none) private(n) schedule(dynamic, 1) &
            !$omp shared(space, stores, scheme, machine, scratches, field, tiles)
            do n = 1, size(tiles)
               call start_cost(machine, tiles(n))
               call count_tile(space, stores, scheme, field, scratches(omp_get_thread_num()), &
                  tiles(n), field%nodes%sums%counted(:, :, tiles(n)), &
                  field%nodes%sums%factor(:, :, tiles(n)))
               call stop_cost(machine, tiles(n))
            end do
            !$omp end parallel do
            call send_patches(space, machine, part, nodes%sums%counted)
         end do
         call machine%timer%stop(machine%phase%scatter)
         call machine%timer%start(machine%phase%grid)
         ! positions of walls do not depend on how long forces act; all tiles are known by now
         if (allocated(space%rigid)) call start_walls(space, scheme%method, clock, ledger, &
            machine, scratches, 0.0_wp)
         call ensure_weights(nodes%dual%weight, space%grid%tile_cells, all)
         call ensure_patch(nodes%sums%covered, 1, number, all)
         if (allocated(space%rigid)) call ensure_patch(nodes%sums%present, 1, number, all)
         call ensure_patch(nodes%sums%normal, normal_columns, number, all)
         !$omp parallel do default(none) shared(space, scheme, machine, field) private(tile) &
         !$omp schedule(static)
         do tile = 1, space%tiles%all
            call start_cost(machine, tile)
            call judge_cells(space, scheme, field%nodes, tile)
            call stop_cost(machine, tile)
         end do
         !$omp end parallel do
         !$omp parallel do default(none) shared(space, scheme, machine, field) private(tile) &
         !$omp schedule(static)
         do tile = 1, space%tiles%all
            call start_cost(machine, tile)
            call find_node_factors(space, scheme, field%nodes%sums, tile)
            call stop_cost(machine, tile)
         end do
         !$omp end parallel do
         call machine%timer%stop(machine%phase%grid)
      end associate
   end subroutine find_edge_factors

   !> Cells whose nodes count as full, of a material without strength; in other cells particles are
   !! not split.
   subroutine find_full(space, scheme, machine, normalised, index, full)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(normalised_nodes_t), intent(in) :: normalised
      integer, intent(in) :: index                   !! Index of the material and of its store
      logical, allocatable, intent(out) :: full(:, :) !! (0:cells - 1, tile)
      integer :: tile, cell, lane

      if (.not. allocated(scheme%flows)) return
      if (.not. scheme%flows(index)) return
      allocate (full(0:space%grid%tile_cells - 1, space%tiles%own), source=.true.)
      !$omp parallel do default(none) shared(space, scheme, machine, normalised, full) &
      !$omp private(tile, cell, lane) schedule(static)
      do tile = 1, space%tiles%own
         call start_cost(machine, tile)
         do cell = 0, space%grid%tile_cells - 1
            do lane = 1, 2**space%grid%dimensions
               full(cell, tile) = full(cell, tile) .and. normalised%normal(4, &
                  space%grid%first_node(cell) + space%grid%lane_offset(lane), tile) > 0.0_wp
            end do
         end do
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine find_full

   !> Sums of the particles of a tile around its nodes and the edges of its cells.
   subroutine count_tile(space, stores, scheme, field, scratch, tile, patch, sums)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp), contiguous, intent(inout) :: sums(:, :)  !! (edge, cell) [m3]
      integer :: index, p, l, first, count

      call clear_patch(patch)
      sums = 0.0_wp
      do index = field%first_store, field%last_store
         count = stores(index)%count(tile)
         if (count == 0) cycle
         first = stores(index)%first(tile)
         associate (store => stores(index), grid => space%grid, shape => scratch%shape, &
            start => stores(index)%cell_start(:, tile))
            call locate_particles_plainly(space, scheme%method, scratch, store, tile)
            shape%values(:count, 1) = store%state%mass(first:first + count - 1)
            call scatter_values(grid, start, shape%local, 1, shape%values, mass - 1, patch)
            shape%values(:count, 1) = store%state%volume(first:first + count - 1)
            do l = 1, 3
               do p = 1, count
                  shape%values(p, 1 + l) = shape%values(p, 1)*(1.0_wp - shape%alpha(p, l))
               end do
            end do
            call scatter_values(grid, start, shape%blend, 4, shape%values, volume - 1, patch)
            if (.not. scheme%normalises(index)) call scatter_values(grid, start, shape%blend, 1, &
               shape%values, foreign - 1, patch)
            call add_edge_sums(grid, start, first, shape%blend, shape%alpha, &
               store%state%volume, sums)
            if (grid%axisymmetric) call add_hoop_sums(grid, start, first, shape%local, &
               store%position, store%state%volume, sums)
         end associate
      end do
   end subroutine count_tile

   !> Fill of the cells of a tile, and the factors of their edges. Where a cell has a weight below
   !! 1, the edges take the rest of the node part.
   subroutine judge_cells(space, scheme, nodes, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      real(wp) :: sums(size(nodes%sums%counted, 1), space%grid%tile_nodes)
      real(wp) :: filled(volume, space%grid%tile_nodes), around(space%grid%tile_nodes)
      real(wp) :: shares(cell_edges, space%grid%tile_cells)
      real(wp) :: weight(space%grid%tile_cells), full(space%grid%tile_cells)
      real(wp) :: own(space%grid%tile_cells)
      real(wp) :: ring(size(hoop_edges), space%grid%tile_cells)
      integer :: cell

      associate (grid => space%grid, coordinate => space%tiles%coordinate(:, tile))
         call assemble(grid, space%tiles, nodes%sums%counted, tile, sums)
         nodes%sums%normal(:3, :, tile) = sums(unblended + 1:unblended + 3, :)
         call grid%node_volume(coordinate, around)
         call scheme%dual%cell_weights(grid, sums, volume, around, weight)
         ! from the fill alone, with the same density everywhere
         filled(mass, :) = around
         nodes%sums%normal(5, :, tile) = 1.0_wp
         own = 1.0_wp
         if (.not. all(scheme%normalises)) then
            nodes%sums%normal(5, :, tile) = max(0.0_wp, 1.0_wp - clear*sums(foreign, :) &
               /max(sums(volume, :), empty_mass))
            filled(volume, :) = scheme%dual%enough*nodes%sums%normal(5, :, tile)*around
            call scheme%dual%cell_weights(grid, filled, volume, around, own)
         end if
         filled(volume, :) = nodes%sums%normal(5, :, tile)*sums(volume, :)
         call find_fill(space, scheme%dual, tile, around, filled(volume, :), full)
         call clear_patch(nodes%sums%covered(:, :, tile))
         call scheme%dual%add_volume(grid, coordinate, full, nodes%sums%covered(:, :, tile))
         shares = 1.0_wp
         ring = 1.0_wp
         if (allocated(space%rigid)) then
            ! of nodes in rigid regions only existing cells count: others hold no particles
            call add_present(space, scheme%dual, nodes%sums, tile, around)
            if (allocated(space%rigid%held(tile)%node)) call cut_cells(grid, coordinate, &
               space%rigid, tile, scheme%method%quadrature%smooth, shares, ring)
            ! cells of a node must not have more weight than their free volume
            do cell = 1, size(full)
               weight(cell) = min(weight(cell), minval(shares(:, cell)))
            end do
         end if
         nodes%dual%weight(:size(weight), tile) = weight
         if (tile > space%tiles%own) return
         call find_cell_factors(space, nodes%sums, tile, full, own, &
            (1.0_wp - scheme%mean_alpha)*weight, shares, ring)
      end associate
   end subroutine judge_cells

   !> How far cells are full: from half of the volume around their nodes on, like the weights of
   !! cells of doc/theory/method.md in a plane.
   subroutine find_fill(space, dual, tile, around, volumes, full)
      type(space_t), intent(in) :: space
      type(dual_t), intent(in) :: dual
      integer, intent(in) :: tile
      real(wp), intent(in) :: around(:)              !! (node) Volume around a node [m3]
      real(wp), intent(in) :: volumes(:)             !! (node) That of particles in the scope [m3]
      real(wp), intent(out) :: full(:)               !! (cell) 0 to 1
      real(wp) :: filled(volume, size(around)), place(3)
      integer :: cell, node

      associate (grid => space%grid, coordinate => space%tiles%coordinate(:, tile))
         filled(mass, :) = around
         filled(volume, :) = 2.0_wp*dual%enough*volumes
         if (grid%axisymmetric) then
            ! the halves of a node are the volumes on either side of it: inside of its radius this
            ! is less than half of its volume, by a third of a cell over the radius
            do node = 1, size(filled(volume, :))
               place = node_place(grid, coordinate, node)
               if (place(1) > 0.5_wp*grid%spacing) filled(volume, node) = filled(volume, node) &
                  /(1.0_wp - grid%spacing/(3.0_wp*place(1)))
            end do
         end if
         call space%boundary%raise(grid, coordinate, beside, filled(volume, :))
         if (allocated(space%rigid)) then
            ! nodes in rigid regions count as full: the free part of a cut cell carries the pressure
            ! of the whole cell and is compressed as fast as its walls approach each other, in
            ! agreement with the integrals over the whole cell
            if (allocated(space%rigid%held(tile)%node)) filled(volume, &
               space%rigid%held(tile)%node) = around(space%rigid%held(tile)%node)
         end if
         call dual%cell_weights(grid, filled, volume, around, full)
         do cell = 1, size(full)
            full(cell) = ramp(2.0_wp*full(cell) - 1.0_wp)
         end do
      end associate
   end subroutine find_fill

   !> Factors of the edges of the cells of a tile.
   subroutine find_cell_factors(space, normalised, tile, full, own, node_part, shares, ring)
      type(space_t), intent(in) :: space
      type(normalised_nodes_t), intent(inout) :: normalised
      integer, intent(in) :: tile
      real(wp), intent(in) :: full(:)                !! (cell) Fill, 0 to 1
      real(wp), intent(in) :: own(:)                 !! (cell) Degree of normalisation, 0 to 1
      real(wp), intent(in) :: node_part(:)           !! (cell) Fraction transmitted by nodes [1]
      real(wp), intent(in) :: shares(:, :)           !! (edge, cell) Fraction outside of walls [1]
      real(wp), intent(in) :: ring(:, :) !! (lane, cell) Factor of hoop terms at walls [1]
      real(wp) :: whole(cell_edges), rest(cell_edges)
      integer :: cell

      associate (grid => space%grid, factor => normalised%factor(:, :, tile))
         whole = edge_integrals(grid, 0)
         do cell = 1, size(full)
            rest = node_part(cell)
            if (grid%axisymmetric) then
               whole = edge_integrals(grid, space%tiles%coordinate(1, tile)*grid%width(1) &
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

   !> Volume of the cells of a tile around its nodes in rigid regions.
   subroutine add_present(space, dual, normalised, tile, around)
      type(space_t), intent(in) :: space
      type(dual_t), intent(in) :: dual
      type(normalised_nodes_t), intent(inout) :: normalised
      integer, intent(in) :: tile
      real(wp), intent(in) :: around(:)              !! (node) Volume around a node [m3]
      real(wp) :: one(space%grid%tile_cells), whole(volume, size(around))

      call clear_patch(normalised%present(:, :, tile))
      if (.not. space%rigid%holds(tile)) return
      ! all cells of the tile that are in the box
      whole = spread(around, 1, volume)
      call dual%cell_weights(space%grid, whole, volume, around, one)
      call dual%add_volume(space%grid, space%tiles%coordinate(:, tile), one, &
         normalised%present(:, :, tile))
   end subroutine add_present

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
   subroutine find_node_factors(space, scheme, normalised, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(normalised_nodes_t), intent(inout) :: normalised
      integer, intent(in) :: tile
      real(wp) :: covered(1, space%grid%tile_nodes), around(space%grid%tile_nodes)
      real(wp) :: due(space%grid%tile_nodes)
      real(wp) :: whole, cells, own, ratio
      integer :: node, l

      associate (grid => space%grid)
         call assemble(grid, space%tiles, normalised%covered, tile, covered)
         call grid%node_volume(space%tiles%coordinate(:, tile), around)
         ! a cell without material ends the region, and next to the axis also the cell with the
         ! smaller fraction
         cells = merge(6.0_wp, real(2**grid%dimensions, wp), grid%axisymmetric)
         call find_due(space, normalised, tile, around, due)
         do node = 1, size(around)
            associate (normal => normalised%normal(:, node, tile))
               own = normal(5)
               normal(4) = 0.0_wp
               normal(5:7) = 0.0_wp
               if (.not. around(node) > empty_mass) cycle
               normal(4) = max(0.0_wp, 1.0_wp - cells*(due(node) - covered(1, node))/around(node))
               whole = (1.0_wp - scheme%mean_alpha)*around(node)
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
   pure subroutine find_due(space, normalised, tile, around, due)
      type(space_t), intent(in) :: space
      type(normalised_nodes_t), intent(in) :: normalised
      integer, intent(in) :: tile
      real(wp), intent(in) :: around(:)              !! (node) Volume around a node [m3]
      real(wp), intent(out) :: due(:)                !! (node) [m3]
      real(wp) :: present(1, size(due))

      due = around
      if (.not. allocated(space%rigid)) return
      if (.not. space%rigid%holds(tile)) return
      call assemble(space%grid, space%tiles, normalised%present, tile, present)
      associate (node => space%rigid%held(tile)%node)
         due(node) = present(1, node)
      end associate
   end subroutine find_due
end module step_normalised_sums
