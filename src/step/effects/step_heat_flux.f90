! SPDX-License-Identifier: BSD-3-Clause
!> Artificial heat flux in shocks, against walls that are too hot (W. F. Noh, J. Comput. Phys. 72
!! (1987) 78): the flux of internal energy k grad e with k = flux h sqrt(rho q), where q is the
!! artificial viscosity. As q is rho h D (q2 h D + q1 c) this is the flux of Noh with the speed of
!! the viscosity, sqrt(q/rho), in place of a linear and a quadratic one, and zero in expansion.
!!
!! Energies of a material are averaged to the nodes with the mass as weight, and flow along the
!! edges of the cells from node to node, so the sum is kept to round-off. Conductances of edges are
!! positive and a node gives at most the energy that it has. The gain of a node is distributed to
!! the particles around it by mass, its loss by energy, so no particle gives more than it has.
!! Energy below zero, as in cold material in tension, does not flow. Materials do not heat each
!! other, and no flux crosses surfaces and boundaries. Equation (M.23) of doc/theory/method.md.
module step_heat_flux
   use base_kinds, only: wp
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_method, only: method_t
   use step_node_fields, only: empty_mass
   use step_node_sums, only: divide_nodes
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_simulation, only: heat_flux_t, scratch_t, simulation_t, space_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: add_artificial_heat_flux

   integer, parameter :: mass = 1, content = 2       !! Rows: [kg], internal energy [J]
   integer, parameter :: passed = 3 !! Row: fraction of its flux that a node can supply

contains

   !> Apply the flux for one step to all materials that carry an internal energy.
   subroutine add_artificial_heat_flux(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! With artificial viscosity
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer :: index, tile

      associate (space => simulation%space, machine => simulation%machine, &
         heat => simulation%effects%heat_flux)
         call machine%timer%start(machine%phase%grid)
         associate (number => space%grid%tile_nodes)
            call ensure_patch(heat%content, content, number, space%tiles%own)
            call ensure_patch(heat%flux, 1, number, space%tiles%own)
            call ensure_patch(heat%total, passed, number, space%tiles%own)
         end associate
         do index = 1, size(simulation%stores)
            if (.not. has_heat_flux(simulation%stores(index))) cycle
            call sum_patches(simulation, index, dt, scatter_energy, heat%content)
            !$omp parallel do default(none) shared(simulation) private(tile) schedule(static)
            do tile = 1, simulation%space%tiles%own
               call start_cost(simulation%machine, tile)
               call find_energy(simulation%space, simulation%effects%heat_flux, tile)
               call stop_cost(simulation%machine, tile)
            end do
            !$omp end parallel do
            call sum_patches(simulation, index, dt, scatter_conductance, heat%flux)
            !$omp parallel do default(none) shared(simulation, dt) private(tile) schedule(static)
            do tile = 1, simulation%space%tiles%own
               call start_cost(simulation%machine, tile)
               call find_passed(simulation%space, simulation%effects%heat_flux, tile, dt)
               call stop_cost(simulation%machine, tile)
            end do
            !$omp end parallel do
            call sum_patches(simulation, index, dt, scatter_flux, heat%flux)
            !$omp parallel do default(none) shared(simulation, index, dt) private(tile) &
            !$omp schedule(dynamic, 1)
            do tile = 1, simulation%space%tiles%own
               call start_cost(simulation%machine, tile)
               if (simulation%stores(index)%count(tile) > 0) call give_energy(simulation%space, &
                  simulation%materials(index), simulation%stores(index), simulation%scheme%method, &
                  simulation%effects%heat_flux, simulation%scratch(omp_get_thread_num()), tile, dt)
               call stop_cost(simulation%machine, tile)
            end do
            !$omp end parallel do
         end do
         call machine%timer%stop(machine%phase%grid)
      end associate
   end subroutine add_artificial_heat_flux

   !> Does the energy of a material flow?
   pure logical function has_heat_flux(store) result(yes)
      type(store_t), intent(in) :: store

      associate (state => store%state)
         yes = allocated(state%energy) .and. allocated(state%viscous_pressure)
      end associate
   end function has_heat_flux

   !> Fill the patches of all own tiles, and receive those of other ranks.
   subroutine sum_patches(simulation, index, dt, work, patch)
      type(simulation_t), intent(inout) :: simulation
      integer, intent(in) :: index                   !! Index of the material and of its store
      real(wp), intent(in) :: dt                     !! Time step [s]
      interface
         subroutine work(simulation, scratch, index, tile, dt, patch)
            import :: scratch_t, simulation_t, wp
            implicit none
            type(simulation_t), intent(in) :: simulation
            type(scratch_t), intent(inout) :: scratch
            integer, intent(in) :: index
            integer, intent(in) :: tile
            real(wp), intent(in) :: dt
            real(wp), contiguous, intent(inout) :: patch(:, :)
         end subroutine work
      end interface
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (row, node, tile)
      integer, allocatable :: tiles(:)
      integer :: part, n

      do part = edge_tiles, inner_tiles
         call next_tiles(simulation%space, simulation%machine%communicator, part, tiles)
         !$omp parallel do default(none) shared(simulation, index, dt, tiles, patch) private(n) &
         !$omp schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(simulation%machine, tiles(n))
            call clear_patch(patch(:, :, tiles(n)))
            if (simulation%stores(index)%count(tiles(n)) > 0) call work(simulation, &
               simulation%scratch(omp_get_thread_num()), index, tiles(n), dt, patch(:, :, tiles(n)))
            call stop_cost(simulation%machine, tiles(n))
         end do
         !$omp end parallel do
         call send_patches(simulation%space, simulation%machine, part, patch)
      end do
   end subroutine sum_patches

   !> Mass, and energy above zero, of the particles of a tile.
   subroutine scatter_energy(simulation, scratch, index, tile, dt, patch)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      integer :: p, q

      associate (space => simulation%space, method => simulation%scheme%method, &
         store => simulation%stores(index), shape => scratch%shape)
         call locate_particles_plainly(space, method, scratch, store, tile)
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            shape%values(p, mass) = store%state%mass(q)
            shape%values(p, content) = store%state%mass(q)*max(store%state%energy(q), 0.0_wp)
         end do
         call method%basis%scatter_values(space%grid, shape, content, shape%values, 0, patch)
      end associate
   end subroutine scatter_energy

   !> Mass and energy of the nodes of a tile.
   subroutine find_energy(space, heat, tile)
      type(space_t), intent(in) :: space
      type(heat_flux_t), intent(inout) :: heat
      integer, intent(in) :: tile
      real(wp) :: sums(content, space%grid%tile_nodes)

      call assemble(space%grid, space%tiles, heat%content, tile, sums)
      heat%total(:content, :, tile) = sums
   end subroutine find_energy

   !> Conductance of all edges of the cells that end in a node [W kg/J].
   subroutine scatter_conductance(simulation, scratch, index, tile, dt, patch)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (1, node)
      real(wp) :: weight(4), place(3), conductance
      integer :: low(4), p, cell, direction, edges

      associate (store => simulation%stores(index), grid => simulation%space%grid)
         call locate_particles_plainly(simulation%space, simulation%scheme%method, &
            scratch, store, tile)
         do cell = 0, grid%tile_cells - 1
            do p = store%cell_start(cell, tile) + 1, store%cell_start(cell + 1, tile)
               conductance = conductance_of(simulation%space%grid, simulation%scheme%method, &
                  simulation%stores(index), store%first(tile) + p - 1, dt)
               if (.not. conductance > 0.0_wp) cycle
               place = scratch%shape%local(p, :)
               do direction = 1, 3
                  if (.not. grid%active(direction)) cycle
                  call find_edges(grid, cell, direction, place, edges, low, weight)
                  call add_conductance(grid%stride(direction), low(:edges), weight(:edges), &
                     conductance, patch)
               end do
            end do
         end do
      end associate
   end subroutine scatter_conductance

   !> Conductance of a particle to both ends of the edges around it.
   pure subroutine add_conductance(stride, low, weight, conductance, patch)
      integer, intent(in) :: stride                  !! From the lower end of an edge to the other
      integer, intent(in) :: low(:)                  !! (edge) Node at the lower end
      real(wp), intent(in) :: weight(:)              !! (edge) At the particle
      real(wp), intent(in) :: conductance            !! Conductance of the particle [W kg/J]
      real(wp), intent(inout) :: patch(:, :)         !! (1, node)
      integer :: edge, high

      do edge = 1, size(low)
         high = low(edge) + stride
         patch(1, low(edge)) = patch(1, low(edge)) + conductance*weight(edge)
         patch(1, high) = patch(1, high) + conductance*weight(edge)
      end do
   end subroutine add_conductance

   !> Fraction of the flux that each node of a tile can supply: it gives no more than its energy.
   subroutine find_passed(space, heat, tile, dt)
      type(space_t), intent(in) :: space
      type(heat_flux_t), intent(inout) :: heat
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: given(1, space%grid%tile_nodes)
      integer :: node

      call assemble(space%grid, space%tiles, heat%flux, tile, given)
      associate (total => heat%total(:, :, tile))
         do node = 1, size(given, 2)
            total(passed, node) = merge(1.0_wp, 0.0_wp, total(mass, node) > empty_mass)
            if (dt*given(1, node) > total(mass, node)) &
               total(passed, node) = total(mass, node)/(dt*given(1, node))
         end do
      end associate
   end subroutine find_passed

   !> Energy that flows to the nodes [W].
   subroutine scatter_flux(simulation, scratch, index, tile, dt, patch)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (1, node)
      real(wp) :: energy(1, size(patch, 2)), weight(4), place(3), conductance
      integer :: low(4), p, cell, direction, edges

      associate (grid => simulation%space%grid, method => simulation%scheme%method, &
         store => simulation%stores(index), total => simulation%effects%heat_flux%total(:, :, tile))
         energy(1, :) = total(content, :)
         call divide_nodes(total, mass, energy)
         call locate_particles_plainly(simulation%space, method, scratch, store, tile)
         do cell = 0, grid%tile_cells - 1
            do p = store%cell_start(cell, tile) + 1, store%cell_start(cell + 1, tile)
               conductance = conductance_of(grid, method, &
                  store, store%first(tile) + p - 1, dt)
               if (.not. conductance > 0.0_wp) cycle
               place = scratch%shape%local(p, :)
               do direction = 1, 3
                  if (.not. grid%active(direction)) cycle
                  call find_edges(grid, cell, direction, place, edges, low, weight)
                  call add_flux(grid%stride(direction), low(:edges), weight(:edges), &
                     conductance, total(passed, :), energy, patch)
               end do
            end do
         end do
      end associate
   end subroutine scatter_flux

   !> Energy that flows along the edges around a particle, from the warmer to the colder end [W].
   pure subroutine add_flux(stride, low, weight, conductance, share, energy, patch)
      integer, intent(in) :: stride                  !! From the lower end of an edge to the other
      integer, intent(in) :: low(:)                  !! (edge) Node at the lower end
      real(wp), intent(in) :: weight(:)              !! (edge) At the particle
      real(wp), intent(in) :: conductance            !! Conductance of the particle [W kg/J]
      real(wp), intent(in) :: share(:)               !! (node) Transmitted fraction of its flux [1]
      real(wp), intent(in) :: energy(:, :)           !! (1, node) [J/kg]
      real(wp), intent(inout) :: patch(:, :)         !! (1, node)
      real(wp) :: flow
      integer :: edge, high

      do edge = 1, size(low)
         high = low(edge) + stride
         flow = conductance*weight(edge)*min(share(low(edge)), share(high)) &
            *(energy(1, high) - energy(1, low(edge)))
         patch(1, low(edge)) = patch(1, low(edge)) + flow
         patch(1, high) = patch(1, high) - flow
      end do
   end subroutine add_flux

   !> Conductance that a particle gives the edges around it along each direction [W kg/J]. The bound
   !! keeps an explicit step in full cells stable.
   pure real(wp) function conductance_of(grid, method, store, q, dt) result(conductance)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(store_t), intent(in) :: store
      integer, intent(in) :: q                       !! Index of the particle
      real(wp), intent(in) :: dt                     !! Time step [s]

      associate (state => store%state)
         conductance = min(state%mass(q)/(4.0_wp*real(grid%dimensions, wp)*dt), &
            method%heat_flux/grid%spacing*sqrt(state%mass(q)*state%volume(q) &
            *max(state%viscous_pressure(q), 0.0_wp)))
      end associate
   end function conductance_of

   !> Edges of a cell along a direction, and the linear functions of the other directions, which sum
   !! to one: sum of weight ((e_high - e_low)/h)**2 is the square of a gradient.
   pure subroutine find_edges(grid, cell, direction, local, edges, low, weight)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                    !! Which cell of a tile, from 0
      integer, intent(in) :: direction               !! Direction of the edges
      real(wp), intent(in) :: local(3)               !! Local coordinate, 0 to 1
      integer, intent(out) :: edges                  !! Number of edges: 1, 2 or 4
      integer, intent(out) :: low(4)                 !! Node at their lower end
      real(wp), intent(out) :: weight(4)             !! At the position
      integer :: across, edge

      edges = 1
      low(1) = grid%first_node(cell)
      weight(1) = 1.0_wp
      do across = 1, 3
         if (across == direction .or. .not. grid%active(across)) cycle
         do edge = 1, edges
            low(edges + edge) = low(edge) + grid%stride(across)
            weight(edges + edge) = weight(edge)*local(across)
            weight(edge) = weight(edge)*(1.0_wp - local(across))
         end do
         edges = 2*edges
      end do
   end subroutine find_edges

   !> New energies of the particles of a tile.
   subroutine give_energy(space, material, store, method, heat, scratch, tile, dt)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: material
      type(store_t), intent(inout) :: store
      type(method_t), intent(in) :: method
      type(heat_flux_t), intent(in) :: heat
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: flow(1, space%grid%tile_nodes), change(2, space%grid%tile_nodes), given
      integer :: node, p, q

      call assemble(space%grid, space%tiles, heat%flux, tile, flow)
      change = 0.0_wp
      associate (total => heat%total(:, :, tile))
         do node = 1, size(change, 2)
            ! gains by mass, losses by energy
            if (flow(1, node) > 0.0_wp) then
               change(1, node) = dt*flow(1, node)/total(mass, node)
            else if (flow(1, node) < 0.0_wp) then
               change(2, node) = dt*flow(1, node)/total(content, node)
            end if
         end do
      end associate
      associate (shape => scratch%shape)
         call locate_particles_plainly(space, method, scratch, store, tile)
         call method%basis%gather_values(space%grid, shape, change, shape%values)
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            given = shape%values(p, 1) + shape%values(p, 2)*max(store%state%energy(q), 0.0_wp)
            store%state%energy(q) = store%state%energy(q) + given
            if (allocated(material%heat)) store%state%temperature(q) = store%state%temperature(q) &
               + given/material%heat%specific_heat
         end do
      end associate
   end subroutine give_energy
end module step_heat_flux
