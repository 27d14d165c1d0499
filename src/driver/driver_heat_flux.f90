! SPDX-License-Identifier: BSD-3-Clause
!> Artificial heat flux in shocks, against walls that are too hot (W. F. Noh, J. Comput. Phys. 72
!! (1987) 78): the flux of internal energy k grad e with k = flux h sqrt(rho q), where q is the
!! artificial viscosity. As q is rho h D (q2 h D + q1 c) this is the flux of Noh with the speed of
!! the viscosity, sqrt(q/rho), in place of a linear and a quadratic one, and none in expansion.
!!
!! Energies of a material go to the nodes weighted with mass. What the flux takes from a node it
!! gives to others, and particles get the changes of their nodes, so the sum is kept to round-off.
!! Materials do not heat each other, and no flux crosses surfaces and faces. Equation (M.23) of
!! doc/theory/method.md.
module driver_heat_flux
   use base_kinds, only: wp
   use driver_exchange, only: edge_tiles, inner_tiles, next_tiles, pass_patches
   use driver_node_sums, only: divide
   use driver_scatter, only: find_places
   use driver_simulation, only: scratch_t, simulation_t
   use mesh_patch, only: assemble, clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use transfer_scatter, only: motion_columns
   implicit none
   private

   public :: smear_heat

   integer, parameter :: mass = 1, content = 2       !! Rows: [kg], internal energy [J]
   integer, parameter :: pushed = 5                  !! Row of a force along x

contains

   !> Let the energy of all materials that carry one flow for one step.
   subroutine smear_heat(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! The run, with artificial viscosity
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer :: index, tile

      call simulation%timer%start(simulation%phase%grid)
      associate (nodes => simulation%nodes, number => simulation%grid%tile_nodes)
         call ensure_patch(nodes%heat, content, number, simulation%tiles%own)
         call ensure_patch(nodes%flux, 1, number, simulation%tiles%own)
         call ensure_patch(nodes%warmth, content, number, simulation%tiles%all)
      end associate
      do index = 1, size(simulation%stores)
         if (.not. flows(simulation, index)) cycle
         call each_own(simulation, index, dt, spread_energy, simulation%nodes%heat)
         !$omp parallel do default(none) shared(simulation) private(tile) schedule(static)
         do tile = 1, simulation%tiles%all
            call assemble(simulation%grid, simulation%tiles, simulation%nodes%heat, tile, &
               simulation%nodes%warmth(:, :, tile))
         end do
         !$omp end parallel do
         call each_own(simulation, index, dt, spread_flux, simulation%nodes%flux)
         !$omp parallel do default(none) shared(simulation, index, dt) private(tile) &
         !$omp schedule(dynamic, 1)
         do tile = 1, simulation%tiles%own
            if (simulation%stores(index)%count(tile) > 0) call give_energy(simulation, &
               simulation%scratch(omp_get_thread_num()), index, tile, dt)
         end do
         !$omp end parallel do
      end do
      call simulation%timer%stop(simulation%phase%grid)
   end subroutine smear_heat

   !> Does the energy of a material flow?
   pure logical function flows(simulation, index) result(yes)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: index                   !! Which material

      associate (matter => simulation%stores(index)%matter)
         yes = allocated(matter%energy) .and. allocated(matter%viscous_pressure)
      end associate
   end function flows

   !> Fill the patches of all own tiles, and bring those that other ranks hold.
   subroutine each_own(simulation, index, dt, work, patch)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer, intent(in) :: index                   !! Which material
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
         call next_tiles(simulation, part, tiles)
         !$omp parallel do default(none) shared(simulation, index, dt, tiles, patch) private(n) &
         !$omp schedule(dynamic, 1)
         do n = 1, size(tiles)
            call clear_patch(patch(:, :, tiles(n)))
            if (simulation%stores(index)%count(tiles(n)) > 0) call work(simulation, &
               simulation%scratch(omp_get_thread_num()), index, tiles(n), dt, patch(:, :, tiles(n)))
         end do
         !$omp end parallel do
         call pass_patches(simulation, part, patch)
      end do
   end subroutine each_own

   !> Mass and energy of the particles of a tile.
   subroutine spread_energy(simulation, scratch, index, tile, dt, patch)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      integer, intent(in) :: index                   !! Which material
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (row, node)
      integer :: p, q

      associate (store => simulation%stores(index), places => scratch%places)
         call find_places(simulation, scratch, store, tile)
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            places%values(p, mass) = store%matter%mass(q)
            places%values(p, content) = store%matter%mass(q)*store%matter%energy(q)
         end do
         call simulation%method%basis%spread(simulation%grid, store%cell_start(:, tile), places, &
            content, places%values, 0, patch)
      end associate
   end subroutine spread_energy

   !> Energy that flows to the nodes [W], as the force of a stress whose first line is the flux. A
   !! step does not take more than it can take and stay stable.
   subroutine spread_flux(simulation, scratch, index, tile, dt, patch)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      integer, intent(in) :: index                   !! Which material
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (1, node)
      integer, parameter :: first_line(3) = [1, 4, 6], full_line(3) = [1, 4, 7]
      real(wp) :: energy(3, size(patch, 2)), wide(motion_columns, size(patch, 2))
      real(wp) :: volume(simulation%stores(index)%count(tile))
      real(wp) :: flux(simulation%stores(index)%count(tile), 6), density, conductivity, most
      integer :: p, q, k

      call node_energy(simulation, tile, energy)
      call scratch%deformation%reserve(size(volume))
      associate (store => simulation%stores(index), places => scratch%places, &
         grid => simulation%grid, method => simulation%method, &
         gradient => scratch%deformation%gradient)
         call find_places(simulation, scratch, store, tile)
         call method%basis%collect_gradient(grid, store%cell_start(:, tile), places, energy, &
            1.0_wp, gradient)
         most = grid%spacing**2/(4.0_wp*real(grid%dimensions, wp)*dt)
         flux = 0.0_wp
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            volume(p) = store%matter%volume(q)
            density = store%matter%mass(q)/volume(p)
            conductivity = min(most*density, method%heat_flux*grid%spacing &
               *sqrt(density*max(store%matter%viscous_pressure(q), 0.0_wp)))
            do k = 1, 3
               flux(p, first_line(k)) = conductivity*gradient(p, full_line(k))
            end do
         end do
         wide = 0.0_wp
         call method%basis%spread_stress(grid, store%cell_start(:, tile), 1, places, volume, flux, &
            wide)
      end associate
      patch(1, :) = wide(pushed, :)
   end subroutine spread_flux

   !> Energy of the nodes of a tile as the first component of a vector.
   subroutine node_energy(simulation, tile, energy)
      type(simulation_t), intent(in) :: simulation   !! The run
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(out) :: energy(:, :)          !! (3, node) In row 1 [J/kg]

      energy = 0.0_wp
      energy(1, :) = simulation%nodes%warmth(content, :, tile)
      call divide(simulation%nodes%warmth(:, :, tile), mass, energy)
   end subroutine node_energy

   !> New energies of the particles of a tile.
   subroutine give_energy(simulation, scratch, index, tile, dt)
      type(simulation_t), intent(inout) :: simulation !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      integer, intent(in) :: index                   !! Which material
      integer, intent(in) :: tile                    !! Which tile
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: change(1, simulation%grid%tile_nodes)
      integer :: p, q

      call assemble(simulation%grid, simulation%tiles, simulation%nodes%flux, tile, change)
      change = dt*change
      call divide(simulation%nodes%warmth(:, :, tile), mass, change)
      associate (store => simulation%stores(index), places => scratch%places)
         call find_places(simulation, scratch, store, tile)
         call simulation%method%basis%collect(simulation%grid, store%cell_start(:, tile), places, &
            change, places%values)
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            store%matter%energy(q) = store%matter%energy(q) + places%values(p, 1)
            if (allocated(simulation%materials(index)%heat)) store%matter%temperature(q) = &
               store%matter%temperature(q) + places%values(p, 1) &
               /simulation%materials(index)%heat%specific_heat
         end do
      end associate
   end subroutine give_energy
end module driver_heat_flux
