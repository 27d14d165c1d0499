! SPDX-License-Identifier: BSD-3-Clause
!> The loops over tiles of bench_offload, around the kernels of the program. Each loop runs on a
!! device, or in threads of the host if `on_device` is false.
!!
!! gfortran 12 to 14 cannot map objects with allocatable components to a device. So the grid and the
!! tiles are variables that exist on both, and their tables are filled on both.
module bench_offload_step
   use base_kinds, only: wp
   use constitutive_kinematics, only: centre_gradient, predict_deviator
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, clear_patch, combine
   use mesh_tiles, only: neighbors, tiles_t
   use step_node_sums, only: divide_motion
   use transfer_gather, only: gather_gradient, gather_motion
   use transfer_scatter_space, only: space_force, space_motion
   use transfer_shape_data, only: find_local, spare
   implicit none
   private

   public :: find_nodes, grid, move_particles, push_nodes, put_tables, tiles

   integer, parameter, public :: columns = 7         !! Of a patch: mass, momentum, force
   real(wp), parameter, public :: density = 1.0_wp   !! [kg/m3]
   real(wp), parameter :: bulk = 5.0_wp/9.0_wp, shear = 1.0_wp/3.0_wp !! Moduli [Pa]
   real(wp), parameter :: dt = 0.1_wp                !! Time step [s]
   real(wp), parameter :: flip_fraction = 0.999_wp   !! Of the old velocity [1]

   type(grid_t) :: grid                              !! Here and on the device
   type(tiles_t) :: tiles                            !! Here and on the device
   !$omp declare target (grid, tiles)

contains

   !> Fill the grid and the tiles of a cube, here and on the device.
   subroutine put_tables(across)
      integer, intent(in) :: across                  !! Tiles along each edge
      integer :: x, y, z, tile, place, at(3)

      grid%dimensions = 3
      grid%spacing = 1.0_wp
      grid%upper = 6.0_wp*real(across, wp)
      call grid%start(6)
      tiles%own = across**3
      tiles%all = across**3
      allocate (tiles%coordinate(3, tiles%all), tiles%neighbor(neighbors, tiles%all))
      do tile = 1, tiles%all
         x = mod(tile - 1, across)
         y = mod((tile - 1)/across, across)
         z = (tile - 1)/across**2
         tiles%coordinate(:, tile) = [x, y, z]
         do place = 1, neighbors
            at = [x + mod(place - 1, 3), y + mod((place - 1)/3, 3), z + (place - 1)/9] - 1
            tiles%neighbor(place, tile) = 0
            if (all(at >= 0 .and. at < across)) tiles%neighbor(place, tile) = &
               1 + at(1) + across*(at(2) + across*at(3))
         end do
      end do
      call fill_device(grid%tile_cells, tiles%all, grid%first_node, tiles%coordinate, &
         tiles%neighbor, grid%cells, grid%width, grid%stride, grid%lane_offset, grid%tile_nodes)
   end subroutine put_tables

   !> The same on the device, from plain copies. On the host both share the memory.
   subroutine fill_device(cells, number, first_node, coordinate, neighbor, grid_cells, width, &
      stride, lane_offset, tile_nodes)
      integer, intent(in) :: cells                   !! Cells of a tile
      integer, intent(in) :: number                  !! Tiles
      integer, intent(in) :: first_node(0:cells - 1), coordinate(3, number)
      integer, intent(in) :: neighbor(neighbors, number)
      integer, intent(in) :: grid_cells(3), width(3), stride(3), lane_offset(8), tile_nodes

      !$omp target map(to: first_node, coordinate, neighbor, grid_cells, width, stride, lane_offset)
      grid%dimensions = 3
      grid%spacing = 1.0_wp
      grid%active = .true.
      grid%lower = 0.0_wp
      grid%tile_cells = cells
      grid%tile_nodes = tile_nodes
      grid%cells = grid_cells
      grid%width = width
      grid%stride = stride
      grid%lane_offset = lane_offset
      if (.not. allocated(grid%first_node)) allocate (grid%first_node(0:cells - 1))
      if (.not. allocated(tiles%coordinate)) allocate (tiles%coordinate(3, number))
      if (.not. allocated(tiles%neighbor)) allocate (tiles%neighbor(neighbors, number))
      grid%first_node(0:) = first_node
      tiles%coordinate(:, :) = coordinate
      tiles%neighbor(:, :) = neighbor
      !$omp end target
   end subroutine fill_device

   !> Particles to nodes: mass, momentum and force of each tile.
   subroutine push_nodes(on_device, number, particles, start, mass, volume, position, velocity, &
      stress, local, patch)
      logical, intent(in) :: on_device
      integer, intent(in) :: number                  !! Tiles
      integer, intent(in) :: particles               !! Of a tile
      integer, contiguous, intent(in) :: start(0:)   !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: mass(:), volume(:) !! (particle) [kg], [m3]
      real(wp), contiguous, intent(in) :: position(:, :), velocity(:, :) !! (particle, 3)
      real(wp), contiguous, intent(in) :: stress(:, :) !! (particle, 6) [Pa]
      real(wp), contiguous, intent(inout) :: local(:, :, :) !! (particle of a tile, 3, tile)
      real(wp), contiguous, intent(inout) :: patch(:, :, :) !! (column, node, tile)
      integer :: tile, first

      !$omp target teams distribute parallel do private(first) if(target: on_device) &
      !$omp map(to: start, mass, volume, position, velocity, stress) map(tofrom: local, patch)
      do tile = 1, number
         first = 1 + (tile - 1)*particles
         call find_local(grid, first, particles, position, local(:, :, tile))
         call clear_patch(patch(:, :, tile))
         call space_motion(grid, start, first, local(:, :, tile), mass, velocity, &
            patch(:, :, tile))
         call space_force(grid, start, first, local(:, :, tile), volume, stress, &
            patch(:, :, tile))
      end do
      !$omp end target teams distribute parallel do
   end subroutine push_nodes

   !> Velocity and acceleration of the nodes, and the velocity that strains.
   subroutine find_nodes(on_device, number, patch, sums, mass, velocity, acceleration, &
      strain, increment)
      logical, intent(in) :: on_device
      integer, intent(in) :: number                  !! Tiles
      real(wp), contiguous, intent(in) :: patch(:, :, :) !! (column, node, tile)
      real(wp), contiguous, intent(inout) :: sums(:, :, :) !! (column, node, tile)
      real(wp), contiguous, intent(inout) :: mass(:, :, :) !! (1, node, tile) [kg]
      real(wp), contiguous, intent(inout) :: velocity(:, :, :) !! (3, node, tile) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :, :) !! (3, node, tile) [m/s2]
      real(wp), contiguous, intent(inout) :: strain(:, :, :) !! (3, node, tile) [m/s]
      real(wp), contiguous, intent(inout) :: increment(:, :, :) !! (3, node, tile) [m/s]
      integer :: tile, node, k

      !$omp target teams distribute parallel do private(node, k) if(target: on_device) &
      !$omp map(to: patch) map(tofrom: sums, mass, velocity, acceleration, strain, increment)
      do tile = 1, number
         call assemble(grid, tiles, patch, tile, sums(:, :, tile))
         do node = 1, grid%tile_nodes
            mass(1, node, tile) = sums(1, node, tile)
            do k = 1, 3
               velocity(k, node, tile) = sums(1 + k, node, tile)
               acceleration(k, node, tile) = sums(4 + k, node, tile)
            end do
         end do
         call divide_motion(mass(:, :, tile), velocity(:, :, tile), acceleration(:, :, tile))
         call combine(1.0_wp, velocity(:, :, tile), dt, acceleration(:, :, tile), &
            strain(:, :, tile))
         ! increment of particles that keep a fraction of their own velocity
         call combine(dt, acceleration(:, :, tile), 1.0_wp - flip_fraction, &
            velocity(:, :, tile), increment(:, :, tile))
      end do
      !$omp end target teams distribute parallel do
   end subroutine find_nodes

   !> Nodes to particles: strain, stress, velocity and position.
   subroutine move_particles(on_device, number, particles, start, mass, local, increment, strain, &
      gradient, work, volume, position, velocity, stress)
      logical, intent(in) :: on_device
      integer, intent(in) :: number                  !! Tiles
      integer, intent(in) :: particles               !! Of a tile
      integer, contiguous, intent(in) :: start(0:)   !! (0:cells) Particles before a cell
      real(wp), contiguous, intent(in) :: mass(:)    !! (particle) [kg]
      real(wp), contiguous, intent(in) :: local(:, :, :) !! (particle of a tile, 3, tile)
      real(wp), contiguous, intent(in) :: increment(:, :, :) !! (3, node, tile) [m/s]
      real(wp), contiguous, intent(in) :: strain(:, :, :) !! (3, node, tile) [m/s]
      real(wp), contiguous, intent(inout) :: gradient(:, :, :) !! (particle of a tile, 9, tile)
      real(wp), contiguous, intent(inout) :: work(:, :, :) !! (particle of a tile, 3, tile)
      real(wp), contiguous, intent(inout) :: volume(:) !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: position(:, :), velocity(:, :) !! (particle, 3)
      real(wp), contiguous, intent(inout) :: stress(:, :) !! (particle, 6) [Pa]
      integer :: tile, first, p, k

      !$omp target teams distribute parallel do private(first, p, k) if(target: on_device) &
      !$omp map(to: start, mass, local, increment, strain) &
      !$omp map(tofrom: gradient, work, volume, position, velocity, stress)
      do tile = 1, number
         first = 1 + (tile - 1)*particles
         call gather_gradient(grid, start, local(:, :, tile), strain(:, :, tile), dt, &
            gradient(:, :, tile))
         call centre_gradient(particles, .false., gradient(:, :, tile))
         call predict_deviator(first, first + particles - 1, .false., shear, &
            gradient(:, :, tile), volume, stress, work(:, 1, tile), work(:, 2, tile), &
            work(:, 3, tile))
         ! linear equation of state: its kernel is bound to an object that cannot be mapped
         do k = 1, 3
            do p = 1, particles
               stress(first + p - 1, k) = stress(first + p - 1, k) - bulk*(mass(first + p - 1) &
                  /(density*volume(first + p - 1)) - 1.0_wp)
            end do
         end do
         call gather_motion(grid, start, first, local(:, :, tile), increment(:, :, tile), &
            strain(:, :, tile), flip_fraction, dt, velocity, position)
      end do
      !$omp end target teams distribute parallel do
   end subroutine move_particles
end module bench_offload_step
