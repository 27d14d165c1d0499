! SPDX-License-Identifier: BSD-3-Clause
!> The elastic block of bench_offload: its particles and node fields, and one step.
module bench_offload_block
   use base_hash, only: add_hash, digest_text, hash_reals
   use base_kinds, only: int64, wp
   use bench_offload_step, only: columns, density, find_nodes, grid, move_particles, push_nodes, &
      tiles
   use omp_lib, only: omp_get_wtime
   use transfer_shape_data, only: spare
   implicit none
   private

   public :: block_t

   !> The particles of a block, tile by tile and cell by cell, and the node fields.
   type :: block_t
      integer :: particles = 0                       !! Of a tile
      integer, allocatable :: start(:)               !! (0:cells) Particles before a cell
      real(wp), allocatable :: mass(:)               !! (particle) [kg]
      real(wp), allocatable :: volume(:)             !! (particle) [m3]
      real(wp), allocatable :: position(:, :)        !! (particle, 3) [m]
      real(wp), allocatable :: velocity(:, :)        !! (particle, 3) [m/s]
      real(wp), allocatable :: stress(:, :)          !! (particle, 6) [Pa]
      real(wp), allocatable :: local(:, :, :)        !! (particle of a tile, 3, tile)
      real(wp), allocatable :: patch(:, :, :)        !! (column, node, tile)
      real(wp), allocatable :: sums(:, :, :)         !! (column, node, tile)
      real(wp), allocatable :: node_mass(:, :, :)    !! (1, node, tile) [kg]
      real(wp), allocatable :: node_velocity(:, :, :) !! (3, node, tile) [m/s]
      real(wp), allocatable :: acceleration(:, :, :) !! (3, node, tile) [m/s2]
      real(wp), allocatable :: increment(:, :, :)    !! (3, node, tile) Of the velocity [m/s]
      real(wp), allocatable :: strain(:, :, :)       !! (3, node, tile) Velocity that strains [m/s]
      real(wp), allocatable :: gradient(:, :, :)     !! (particle of a tile, 9, tile)
      real(wp), allocatable :: work(:, :, :)         !! (particle of a tile, 3, tile) Of the law
   contains
      procedure :: start_wave => block_start_wave    !! Particles on a lattice, in a wave
      procedure :: advance => block_advance          !! One step
      procedure :: to_device => block_to_device      !! Copy to the device
      procedure :: from_device => block_from_device  !! Copy the particles back
      procedure :: inside => block_inside            !! Are all particles in their cells?
      procedure :: digest => block_digest            !! Of all fields of the particles
   end type block_t

contains

   !> Eight particles a cell at rest on a lattice, with a velocity that varies along x.
   subroutine block_start_wave(self)
      class(block_t), intent(inout) :: self
      integer :: tile, cell, lane, p, direction, cells, number, total, rows

      cells = grid%tile_cells
      number = tiles%all
      self%particles = 8*cells
      total = self%particles*number
      rows = self%particles + spare
      self%start = [(8*cell, cell=0, cells)]
      ! kernels with particles as lanes may write up to some rows after the last particle
      allocate (self%mass(total + spare), self%volume(total + spare))
      allocate (self%position(total + spare, 3), self%velocity(total + spare, 3))
      allocate (self%stress(total + spare, 6))
      allocate (self%local(rows, 3, number), self%gradient(rows, 9, number))
      allocate (self%work(rows, 3, number))
      allocate (self%patch(columns, grid%tile_nodes, number))
      allocate (self%sums(columns, grid%tile_nodes, number))
      allocate (self%node_mass(1, grid%tile_nodes, number))
      allocate (self%node_velocity(3, grid%tile_nodes, number))
      allocate (self%acceleration(3, grid%tile_nodes, number))
      allocate (self%increment(3, grid%tile_nodes, number))
      allocate (self%strain(3, grid%tile_nodes, number))
      self%mass = density/8.0_wp
      self%volume = 1.0_wp/8.0_wp
      self%position = 0.0_wp
      self%velocity = 0.0_wp
      self%stress = 0.0_wp
      self%local = 0.0_wp
      self%gradient = 0.0_wp
      self%work = 0.0_wp
      p = 0
      do tile = 1, number
         do cell = 0, cells - 1
            do lane = 0, 7
               p = p + 1
               do direction = 1, 3
                  self%position(p, direction) = real(6*tiles%coordinate(direction, tile) &
                     + grid%cell_position(direction, cell), wp) &
                     + 0.25_wp + 0.5_wp*real(ibits(lane, direction - 1, 1), wp)
               end do
               self%velocity(p, 1) = 0.02_wp*sin(0.7_wp*self%position(p, 1))
               self%velocity(p, 2) = 0.02_wp*cos(0.4_wp*self%position(p, 1))
            end do
         end do
      end do
   end subroutine block_start_wave

   !> One step. The seconds of its three parts are added.
   subroutine block_advance(self, on_device, seconds)
      class(block_t), intent(inout) :: self
      logical, intent(in) :: on_device
      real(wp), intent(inout) :: seconds(3)          !! Particles to nodes, nodes, and back [s]
      real(wp) :: times(4)

      times(1) = omp_get_wtime()
      call push_nodes(on_device, tiles%all, self%particles, self%start, self%mass, self%volume, &
         self%position, self%velocity, self%stress, self%local, self%patch)
      times(2) = omp_get_wtime()
      call find_nodes(on_device, tiles%all, self%patch, self%sums, self%node_mass, &
         self%node_velocity, self%acceleration, self%strain, self%increment)
      times(3) = omp_get_wtime()
      call move_particles(on_device, tiles%all, self%particles, self%start, self%mass, &
         self%local, self%increment, self%strain, self%gradient, self%work, self%volume, &
         self%position, self%velocity, self%stress)
      times(4) = omp_get_wtime()
      seconds = seconds + times(2:4) - times(1:3)
   end subroutine block_advance

   !> Copy all fields to the device.
   subroutine block_to_device(self)
      class(block_t), intent(inout) :: self

      call enter(self%start, self%mass, self%volume, self%position, self%velocity, self%stress, &
         self%local, self%patch, self%sums)
      call enter_more(self%node_mass, self%node_velocity, self%acceleration, self%increment, &
         self%strain, self%gradient, self%work)
   end subroutine block_to_device

   !> Copy fields to the device.
   subroutine enter(start, mass, volume, position, velocity, stress, local, patch, sums)
      integer, contiguous, intent(in) :: start(:)
      real(wp), contiguous, intent(in) :: mass(:), volume(:), position(:, :), velocity(:, :)
      real(wp), contiguous, intent(in) :: stress(:, :), local(:, :, :), patch(:, :, :)
      real(wp), contiguous, intent(in) :: sums(:, :, :)

      !$omp target enter data map(to: start, mass, volume, position, velocity, stress, local) &
      !$omp map(to: patch, sums)
   end subroutine enter

   !> Copy further fields to the device.
   subroutine enter_more(mass, velocity, acceleration, increment, strain, gradient, work)
      real(wp), contiguous, intent(in) :: mass(:, :, :), velocity(:, :, :)
      real(wp), contiguous, intent(in) :: acceleration(:, :, :), increment(:, :, :)
      real(wp), contiguous, intent(in) :: strain(:, :, :), gradient(:, :, :), work(:, :, :)

      !$omp target enter data map(to: mass, velocity, acceleration, increment, strain) &
      !$omp map(to: gradient, work)
   end subroutine enter_more

   !> Copy the particles back.
   subroutine block_from_device(self)
      class(block_t), intent(inout) :: self

      call leave(self%volume, self%position, self%velocity, self%stress)
   end subroutine block_from_device

   !> Copy fields back.
   subroutine leave(volume, position, velocity, stress)
      real(wp), contiguous, intent(inout) :: volume(:), position(:, :), velocity(:, :)
      real(wp), contiguous, intent(inout) :: stress(:, :)

      !$omp target update from(volume, position, velocity, stress)
   end subroutine leave

   !> True if all particles are in the cells in which they began.
   logical function block_inside(self) result(inside)
      class(block_t), intent(in) :: self
      integer :: tile, cell, p

      inside = .true.
      p = 0
      do tile = 1, tiles%all
         do cell = 0, grid%tile_cells - 1
            inside = inside .and. all(int(self%position(p + 1:p + 8, :)) == spread( &
               6*tiles%coordinate(:, tile) + grid%cell_position(:, cell), 1, 8))
            p = p + 8
         end do
      end do
   end function block_inside

   !> Digest of volume, position, velocity and stress.
   function block_digest(self) result(text)
      class(block_t), intent(in) :: self
      character(len=16) :: text
      integer(int64), allocatable :: owners(:)
      integer(int64) :: hash
      integer :: p, k, n

      n = self%particles*tiles%all
      allocate (owners(n))
      do p = 1, n
         owners(p) = int(p, int64)
      end do
      hash = hash_reals(0_int64, owners, self%volume(:n))
      do k = 1, 3
         hash = add_hash(hash, hash_reals(int(k, int64), owners, self%position(:n, k)))
         hash = add_hash(hash, hash_reals(int(3 + k, int64), owners, self%velocity(:n, k)))
      end do
      do k = 1, 6
         hash = add_hash(hash, hash_reals(int(6 + k, int64), owners, self%stress(:n, k)))
      end do
      text = digest_text(hash)
   end function block_digest
end module bench_offload_block
