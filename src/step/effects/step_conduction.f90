! SPDX-License-Identifier: BSD-3-Clause
!> Conduction of heat on the grid, for materials that have a conductivity.
!!
!! Temperatures are averaged to the nodes with the heat capacity as weight. The heat flow uses the
!! same modified gradient and its adjoint as strain and force, so it only smooths, and the sum of m
!! c T is kept to rounding. Particles receive the changes of their nodes, which adds no diffusion.
!! Differences between the particles of a cell, which nodes do not resolve, decay at the rate of the
!! shortest resolved wave, by a second-order term without effect on the nodes, as in the filtered
!! transfers of C. C. Hammerquist, J. A. Nairn, Comput. Methods Appl. Mech. Eng. 318 (2017) 724. See
!! doc/theory/matter.md.
module step_conduction
   use base_constants, only: pi
   use base_kinds, only: wp
   use material_type, only: material_t
   use material_voids, only: expanded_fraction
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch, ensure_weights
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_heat_boundaries, only: hold_temperature, take_heat
   use step_ledger, only: dissipated
   use step_method, only: method_t
   use step_node_sums, only: divide_nodes
   use step_particles_to_nodes, only: locate_particles_plainly
   use step_simulation, only: conduction_t, machine_t, scheme_t, scratch_t, space_t, &
      velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_scatter, only: dual_columns, motion_columns
   use transfer_shape_data, only: shape_data_t, spare
   implicit none
   private

   public :: bulk_volume, conduct_heat, conducts_heat

   integer, parameter :: capacity = 1                !! Row of heat capacity [J/K]
   integer, parameter :: content = 2                 !! Row of heat [J]
   integer, parameter :: filled = 3                  !! Row of volume [m3]
   integer, parameter :: hidden = 2                  !! Row of heat that nodes do not resolve [J]
   integer, parameter :: fluxes = 3                  !! Row of flux times volume, by direction
   !> Columns of the first row of a tensor, xx, xy and xz: of a symmetric tensor, and of a full one
   integer, parameter :: first_line(3) = [1, 4, 6], full_line(3) = [1, 4, 7]
   real(wp), parameter :: fade = pi*pi !! Rate of the shortest wave, over diffusivity/spacing**2 [1]
   real(wp), parameter :: fade_most = 0.5_wp         !! Greatest part that fades in a step [1]

contains

   !> Conduct heat for one step. Particles are at the positions at which the forces were computed.
   subroutine conduct_heat(space, materials, stores, fields, scheme, heat, machine, scratches, dt)
      type(space_t), intent(inout) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(inout) :: stores(:)
      type(velocity_field_t), intent(in) :: fields(:) !! Know how far particles cover cells
      type(scheme_t), intent(in) :: scheme
      type(conduction_t), intent(inout) :: heat
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer :: tile

      call machine%timer%start(machine%phase%conduction)
      call find_temperature(space, materials, stores, fields, scheme, heat, machine, scratches)
      call find_flow(space, materials, stores, scheme, heat, machine, scratches, dt)
      !$omp parallel do default(none) shared(space, materials, stores, scheme, heat, machine, &
      !$omp scratches, dt) private(tile) schedule(dynamic, 1)
      do tile = 1, space%tiles%own
         call start_cost(machine, tile)
         call give_heat(space, materials, stores, scheme%method, heat, &
            scratches(omp_get_thread_num()), tile, dt)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%conduction)
   end subroutine conduct_heat

   !> Temperature of the nodes, and its gradient for the dual gradient.
   subroutine find_temperature(space, materials, stores, fields, scheme, heat, machine, scratches)
      type(space_t), intent(inout) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(velocity_field_t), intent(in) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(conduction_t), intent(inout) :: heat
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      integer, allocatable :: tiles(:)
      integer :: part, n, rows

      rows = merge(filled, content, scheme%method%dual)
      associate (nodes => space%grid%tile_nodes)
         call ensure_patch(heat%content, rows, nodes, space%tiles%own)
         do part = edge_tiles, inner_tiles
            call next_tiles(space, machine%communicator, part, tiles)
            !$omp parallel do default(none) private(n) schedule(dynamic, 1) &
            !$omp shared(space, materials, stores, scheme, heat, machine, scratches, tiles)
            do n = 1, size(tiles)
               call start_cost(machine, tiles(n))
               call spread_content(space, materials, stores, scheme%method, &
                  scratches(omp_get_thread_num()), tiles(n), heat%content(:, :, tiles(n)))
               call stop_cost(machine, tiles(n))
            end do
            !$omp end parallel do
            call send_patches(space, machine, part, heat%content)
         end do
         call ensure_patch(heat%total, rows, nodes, space%tiles%all)
         call ensure_patch(heat%temperature, 1, nodes, space%tiles%all)
      end associate
      if (scheme%method%dual) then
         call ensure_dual(space, heat)
         call add_covers(fields, heat%weight(:, :space%tiles%all))
      end if
      call each_tile(space, scheme, heat, machine, average_tile)
      if (scheme%method%dual) call each_tile(space, scheme, heat, machine, slope_tile)
   end subroutine find_temperature

   !> Heat that flows to the nodes, from the cells and, with the dual gradient, between nodes.
   subroutine find_flow(space, materials, stores, scheme, heat, machine, scratches, dt)
      type(space_t), intent(inout) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(conduction_t), intent(inout) :: heat
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer, allocatable :: tiles(:)
      integer :: part, n

      call ensure_patch(heat%flow, merge(fluxes + 2, hidden, scheme%method%dual), &
         space%grid%tile_nodes, space%tiles%own)
      do part = edge_tiles, inner_tiles
         call next_tiles(space, machine%communicator, part, tiles)
         !$omp parallel do default(none) shared(space, materials, stores, scheme, heat, machine, &
         !$omp scratches, tiles, dt) private(n) schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(machine, tiles(n))
            call spread_flow(space, materials, stores, scheme%method, heat, &
               scratches(omp_get_thread_num()), tiles(n), dt, heat%flow(:, :, tiles(n)))
            call stop_cost(machine, tiles(n))
         end do
         !$omp end parallel do
         call send_patches(space, machine, part, heat%flow)
      end do
      if (scheme%method%dual) call each_tile(space, scheme, heat, machine, push_tile)
   end subroutine find_flow

   !> Does the material conduct heat?
   pure logical function conducts_heat(material) result(yes)
      type(material_t), intent(in) :: material

      yes = .false.
      if (allocated(material%heat)) yes = material%heat%conductivity > 0.0_wp
   end function conducts_heat

   !> Volume [m3] that conducts: that of the material, without voids.
   pure real(wp) function bulk_volume(store, particle) result(volume)
      type(store_t), intent(in) :: store
      integer, intent(in) :: particle                !! Index of the particle

      volume = store%state%volume(particle)
      if (allocated(store%state%solid_fraction)) &
         volume = volume*store%state%solid_fraction(particle)
   end function bulk_volume

   !> Part of each cell that the particles of all velocity fields cover; 1 if it is not known.
   pure subroutine add_covers(fields, covered)
      type(velocity_field_t), intent(in) :: fields(:)
      real(wp), intent(out) :: covered(:, :)         !! (cell, tile)
      integer :: n
      logical :: known

      covered = 0.0_wp
      known = .false.
      do n = 1, size(fields)
         associate (motion => fields(n)%nodes%motion)
            if (.not. allocated(motion%covered)) cycle
            covered = covered + motion%covered(:, :size(covered, 2))
            known = .true.
         end associate
      end do
      if (.not. known) covered = 1.0_wp
   end subroutine add_covers

   !> Allocate the fields of the dual gradient.
   subroutine ensure_dual(space, heat)
      type(space_t), intent(in) :: space
      type(conduction_t), intent(inout) :: heat

      associate (nodes => space%grid%tile_nodes, all => space%tiles%all)
         call ensure_weights(heat%weight, space%grid%tile_cells, all)
         call ensure_patch(heat%share, 1, nodes, all)
         call ensure_patch(heat%volume, 1, nodes, all)
         call ensure_patch(heat%slope, 9, nodes, all)
         call ensure_patch(heat%node_heat, 3, nodes, all)
      end associate
   end subroutine ensure_dual

   !> Call a procedure for every tile, ghosts included.
   subroutine each_tile(space, scheme, heat, machine, work)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(conduction_t), intent(inout) :: heat
      type(machine_t), intent(inout) :: machine
      interface
         subroutine work(space, scheme, heat, tile)
            import :: conduction_t, scheme_t, space_t
            implicit none
            type(space_t), intent(in) :: space
            type(scheme_t), intent(in) :: scheme
            type(conduction_t), intent(inout) :: heat
            integer, intent(in) :: tile
         end subroutine work
      end interface
      integer :: tile

      !$omp parallel do default(none) shared(space, scheme, heat, machine) private(tile) &
      !$omp schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call work(space, scheme, heat, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine each_tile

   !> Heat capacity, heat and volume of the particles of a tile.
   subroutine spread_content(space, materials, stores, method, scratch, tile, patch)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      integer :: index, p, q

      call clear_patch(patch)
      do index = 1, size(stores)
         if (stores(index)%count(tile) == 0 .or. .not. conducts_heat(materials(index))) cycle
         associate (store => stores(index), shape => scratch%shape, &
            specific_heat => materials(index)%heat%specific_heat)
            call locate_particles_plainly(space, method, scratch, store, tile)
            do p = 1, store%count(tile)
               q = store%first(tile) + p - 1
               shape%values(p, capacity) = specific_heat*store%state%mass(q)
               shape%values(p, content) = shape%values(p, capacity)*store%state%temperature(q)
               shape%values(p, filled) = store%state%volume(q)
            end do
            call method%basis%scatter_values(space%grid, shape, size(patch, 1), &
               shape%values, 0, patch)
         end associate
      end do
   end subroutine spread_content

   !> Temperature of the nodes of a tile; weights of its cells, where conducting material is, from
   !! the covers that are in their place.
   subroutine average_tile(space, scheme, heat, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(conduction_t), intent(inout) :: heat
      integer, intent(in) :: tile
      real(wp) :: around(space%grid%tile_nodes), covered(space%grid%tile_cells)

      associate (grid => space%grid, coordinate => space%tiles%coordinate(:, tile))
         call assemble(grid, space%tiles, heat%content, tile, heat%total(:, :, tile))
         heat%temperature(1, :, tile) = heat%total(content, :, tile)
         call divide_nodes(heat%total(:, :, tile), capacity, heat%temperature(:, :, tile))
         call hold_temperature(space, heat, tile)
         if (.not. scheme%method%dual) return
         call grid%node_volume(coordinate, around)
         covered = heat%weight(:, tile)
         call scheme%dual%cell_weights(grid, heat%total(:, :, tile), filled, around, &
            heat%weight(:, tile), covered)
         call clear_patch(heat%share(:, :, tile))
         call scheme%dual%add_volume(grid, coordinate, heat%weight(:, tile), &
            heat%share(:, :, tile))
      end associate
   end subroutine average_tile

   !> Contribution of the cells of a tile to the node gradient of temperature.
   subroutine slope_tile(space, scheme, heat, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(conduction_t), intent(inout) :: heat
      integer, intent(in) :: tile
      real(wp) :: values(3, space%grid%tile_nodes)

      call assemble(space%grid, space%tiles, heat%share, tile, heat%volume(:, :, tile))
      call as_vector(heat%temperature(:, :, tile), values)
      call clear_patch(heat%slope(:, :, tile))
      call scheme%dual%add_gradient(space%grid, space%tiles%coordinate(:, tile), &
         heat%weight(:, tile), values, heat%slope(:, :, tile))
   end subroutine slope_tile

   !> A scalar as the first component of a vector, for the maps of velocities.
   pure subroutine as_vector(scalar, vector)
      real(wp), contiguous, intent(in) :: scalar(:, :) !! (1, node)
      real(wp), intent(out) :: vector(:, :)          !! (3, node)

      vector = 0.0_wp
      vector(1, :) = scalar(1, :)
   end subroutine as_vector

   !> Contribution of the particles of a tile to the nodes: heat, and heat that nodes do not
   !! resolve: (A.15).
   subroutine spread_flow(space, materials, stores, method, heat, scratch, tile, dt, patch)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(conduction_t), intent(in) :: heat
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      real(wp) :: values(3, space%grid%tile_nodes)
      real(wp), allocatable :: slope(:, :), wide(:, :)
      integer :: index, p, k

      call clear_patch(patch)
      call as_vector(heat%temperature(:, :, tile), values)
      if (method%dual) then
         ! gradient of temperature on the nodes of a tile
         allocate (slope(9, space%grid%tile_nodes))
         call assemble(space%grid, space%tiles, heat%slope, tile, slope)
         call divide_nodes(heat%volume(:, :, tile), 1, slope)
         call space%boundary%insulate(space%grid, space%tiles%coordinate(:, tile), slope)
      end if
      allocate (wide(merge(dual_columns, motion_columns, method%dual), space%grid%tile_nodes))
      wide = 0.0_wp
      do index = 1, size(stores)
         if (stores(index)%count(tile) == 0 .or. .not. conducts_heat(materials(index))) cycle
         associate (store => stores(index), shape => scratch%shape, &
            specific_heat => materials(index)%heat%specific_heat)
            call locate_particles_plainly(space, method, scratch, store, tile)
            call push_particles(space%grid, materials(index), stores(index), method, scratch, &
               tile, values, slope, wide)
            call find_hidden(space%grid, materials(index), stores(index), method, heat, &
               scratch, tile, dt)
            do p = 1, store%count(tile)
               shape%values(p, 1) = specific_heat*store%state%mass(store%first(tile) + p - 1) &
                  *shape%vector(p, 1)
            end do
            call method%basis%scatter_values(space%grid, shape, 1, shape%values, hidden - 1, patch)
         end associate
      end do
      patch(1, :) = wide(5, :)
      if (.not. method%dual) return
      do k = 1, 3
         patch(fluxes + k - 1, :) = wide(8 + full_line(k), :)
      end do
   end subroutine spread_flow

   !> Heat flow of the particles of a tile, stored as the first row of a stress.
   subroutine push_particles(grid, material, store, method, scratch, tile, values, slope, patch)
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: material
      type(store_t), intent(in) :: store
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: values(:, :)    !! (3, node) Temperature in row 1 [K]
      real(wp), allocatable, intent(in) :: slope(:, :)    !! (9, node) Node gradient, if dual [K/m]
      real(wp), contiguous, intent(inout) :: patch(:, :)  !! (column, node)
      real(wp), allocatable :: volume(:), flux(:, :)
      integer :: p, k

      associate (shape => scratch%shape)
         call scratch%deformation%reserve(store%count(tile) + spare)
         if (method%dual) then
            call method%quadrature%gather_gradient(grid, shape, values, slope, 1.0_wp, &
               scratch%deformation%gradient)
         else
            call method%basis%gather_gradient(grid, shape, values, 1.0_wp, &
               scratch%deformation%gradient)
         end if
         allocate (volume(store%count(tile)), flux(store%count(tile), 6))
         flux = 0.0_wp
         do p = 1, store%count(tile)
            volume(p) = bulk_volume(store, store%first(tile) + p - 1)
            do k = 1, 3
               flux(p, first_line(k)) = material%heat%conductivity &
                  *scratch%deformation%gradient(p, full_line(k))
            end do
         end do
         if (method%dual) then
            call method%quadrature%scatter_force(grid, shape, 1, volume, flux, patch)
         else
            call method%basis%scatter_stress(grid, shape, 1, volume, flux, patch)
         end if
      end associate
   end subroutine push_particles

   !> The part of the particle temperatures that nodes do not resolve and that decays in this step,
   !! in the first column of the scratch vector [K]. The second of (A.16).
   subroutine find_hidden(grid, material, store, method, heat, scratch, tile, dt)
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: material
      type(store_t), intent(in) :: store
      type(method_t), intent(in) :: method
      type(conduction_t), intent(in) :: heat
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: rate
      integer :: p, q

      associate (shape => scratch%shape, thermal => material%heat)
         call method%basis%gather_values(grid, shape, heat%temperature(:, :, tile), shape%values)
         rate = fade*dt*thermal%conductivity/(thermal%specific_heat*grid%spacing**2)
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            shape%vector(p, 1) = min(fade_most, rate*bulk_volume(store, q) &
               /store%state%mass(q))*(store%state%temperature(q) - shape%values(p, 1))
         end do
      end associate
   end subroutine find_hidden

   !> Heat that the flux on the nodes of the cells of a tile carries.
   subroutine push_tile(space, scheme, heat, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(conduction_t), intent(inout) :: heat
      integer, intent(in) :: tile
      real(wp) :: total(fluxes + 2, space%grid%tile_nodes)
      real(wp) :: flux(9, space%grid%tile_nodes)
      integer :: k

      associate (coordinate => space%tiles%coordinate(:, tile))
         call assemble(space%grid, space%tiles, heat%flow, tile, total)
         flux = 0.0_wp
         do k = 1, 3
            flux(full_line(k), :) = total(fluxes + k - 1, :)
         end do
         call divide_nodes(heat%volume(:, :, tile), 1, flux)
         call space%boundary%insulate(space%grid, coordinate, flux)
         call clear_patch(heat%node_heat(:, :, tile))
         call scheme%dual%add_force(space%grid, coordinate, heat%weight(:, tile), flux, &
            heat%node_heat(:, :, tile))
      end associate
   end subroutine push_tile

   !> New temperatures of the particles of a tile. The heat gained or lost by material without
   !! internal energy is recorded, so that the energy balance closes. The first of (A.16).
   subroutine give_heat(space, materials, stores, method, heat, scratch, tile, dt)
      type(space_t), intent(in) :: space
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(inout) :: stores(:)
      type(method_t), intent(in) :: method
      type(conduction_t), intent(in) :: heat
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: total(size(heat%flow, 1), space%grid%tile_nodes), rise
      real(wp) :: push(3, space%grid%tile_nodes), change(1, space%grid%tile_nodes)
      real(wp) :: recorded
      integer :: index, p, q

      call assemble(space%grid, space%tiles, heat%flow, tile, total)
      push = 0.0_wp
      if (method%dual) call assemble(space%grid, space%tiles, heat%node_heat, tile, push)
      change(1, :) = dt*(total(1, :) + push(1, :)) + total(hidden, :)
      call divide_nodes(heat%total(:, :, tile), capacity, change)
      call take_heat(space, heat, scratch%ledger, tile, capacity, change)
      do index = 1, size(stores)
         if (stores(index)%count(tile) == 0 .or. .not. conducts_heat(materials(index))) cycle
         call locate_particles_plainly(space, method, scratch, stores(index), tile)
         call find_hidden(space%grid, materials(index), stores(index), method, heat, &
            scratch, tile, dt)
         call method%basis%gather_values(space%grid, scratch%shape, change, scratch%shape%values)
         ! warm the particles of a tile
         recorded = 0.0_wp
         do p = 1, stores(index)%count(tile)
            q = stores(index)%first(tile) + p - 1
            rise = scratch%shape%values(p, 1) - scratch%shape%vector(p, 1)
            stores(index)%state%temperature(q) = stores(index)%state%temperature(q) + rise
            if (allocated(stores(index)%state%energy)) then
               stores(index)%state%energy(q) = stores(index)%state%energy(q) &
                  + materials(index)%heat%specific_heat*rise
            else
               recorded = recorded &
                  + materials(index)%heat%specific_heat*stores(index)%state%mass(q)*rise
            end if
         end do
         if (allocated(materials(index)%voids)) &
            call expand_grains(materials(index)%voids%expansion, tile, scratch%shape, stores(index))
         call scratch%ledger%sums(dissipated)%add(recorded)
      end do
   end subroutine give_heat

   !> Let the grains of a tile expand thermally into their voids.
   pure subroutine expand_grains(expansion, tile, shape, store)
      real(wp), intent(in) :: expansion              !! Thermal, of the volume [1/K]
      integer, intent(in) :: tile
      !> (particle) Change from the nodes, and the part that decays [K]
      type(shape_data_t), intent(in) :: shape
      type(store_t), intent(inout) :: store
      integer :: p, q

      do p = 1, store%count(tile)
         q = store%first(tile) + p - 1
         store%state%solid_fraction(q) = expanded_fraction(store%state%solid_fraction(q), &
            expansion*(shape%values(p, 1) - shape%vector(p, 1)))
      end do
   end subroutine expand_grains
end module step_conduction
