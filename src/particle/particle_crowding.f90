! SPDX-License-Identifier: BSD-3-Clause
!> Measures of crowding and of pressure noise: the particle volume in excess of the nodal volume,
!! and the difference of their pressures from nodal means.
!!
!! Both use the nodes in the interior of a tile, with linear shape functions for every method: this
!! sample does not depend on the number of ranks and needs no exchange.
module particle_crowding
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lane_bit
   use particle_store, only: store_t
   implicit none
   private

   public :: add_to_nodes, measure_claims, measure_noise, nodes_alone

contains

   !> Nodes of a tile with all adjacent cells inside the tile or outside the domain.
   pure function nodes_alone(grid, coordinate) result(alone)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      logical :: alone(grid%tile_nodes)
      integer :: node, k, place(3), extent(3)

      extent = grid%tile_extent(coordinate)
      do node = 1, grid%tile_nodes
         place = grid%node_position(node)
         alone(node) = .true.
         do k = 1, 3
            if (.not. grid%active(k)) cycle
            if (place(k) > 0 .and. place(k) < extent(k)) cycle
            alone(node) = alone(node) .and. .not. grid%periodic(k) .and. &
               ((place(k) == 0 .and. coordinate(k) == 0) .or. (place(k) == extent(k) .and. &
               coordinate(k)*grid%width(k) + extent(k) == grid%cells(k)))
         end do
      end do
   end function nodes_alone

   !> Add volume, and volume times pressure, of the particles of a tile to its nodes. A failed
   !! particle counts with at most the volume of its mass at rest: the remainder is void.
   pure subroutine add_to_nodes(grid, coordinate, store, tile, density, loose, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: density                !! Density of their material at rest [kg/m3]
      logical, intent(in) :: loose                   !! Can the material separate?
      real(wp), intent(inout) :: patch(:, :)         !! (2, node) [m3], [m3 Pa]
      real(wp) :: weight(8), volume
      integer :: node(8), lane, p

      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         call find_nodes(grid, coordinate, store, p, node, weight)
         volume = claimed_volume(store, p, density, loose)
         do lane = 1, 2**grid%dimensions
            patch(1, node(lane)) = patch(1, node(lane)) + weight(lane)*volume
            patch(2, node(lane)) = patch(2, node(lane)) &
               + weight(lane)*volume*pressure_of(store, p)
         end do
      end do
   end subroutine add_to_nodes

   !> Volume that a particle occupies [m3].
   pure real(wp) function claimed_volume(store, p, density, loose) result(volume)
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp), intent(in) :: density                !! Density of its material at rest [kg/m3]
      logical, intent(in) :: loose                   !! Can the material separate?
      logical :: open

      open = loose
      if (allocated(store%state%failed)) open = open .or. store%state%failed(p) /= 0
      volume = store%state%volume(p)
      if (open) volume = min(volume, store%state%mass(p)/density)
   end function claimed_volume

   !> Volume of the particles at nodes, and the part of it within the nodal volume. Equation (L.8)
   !! of doc/theory/ledger.md.
   pure subroutine measure_claims(grid, coordinate, alone, patch, claimed, occupied)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      logical, intent(in) :: alone(:)                !! (node) Do its sums hold all particles?
      real(wp), intent(in) :: patch(:, :)            !! (2, node) Sums over all materials
      real(wp), intent(out) :: claimed               !! Sum of the volumes of particles [m3]
      real(wp), intent(out) :: occupied              !! The same, at most the nodes' volumes [m3]
      real(wp) :: around(size(alone))
      integer :: node

      call grid%node_volume(coordinate, around)
      claimed = 0.0_wp
      occupied = 0.0_wp
      do node = 1, size(alone)
         if (.not. alone(node)) cycle
         claimed = claimed + patch(1, node)
         occupied = occupied + min(patch(1, node), around(node))
      end do
   end subroutine measure_claims

   !> Sums over the particles of a tile for the noise of the pressure, equation (L.9): volume;
   !! squares of the stress that resists and of the kinetic energy density; squares of the
   !! differences of pressures from nodal means. Only cells whose nodes are all complete count.
   !! Failed particles have neither stress nor noise.
   pure subroutine measure_noise(grid, coordinate, alone, store, tile, locks, patch, sums)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      logical, intent(in) :: alone(:)                !! (node) Do its sums hold all particles?
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      logical, intent(in) :: locks                   !! May the material lock?
      real(wp), intent(in) :: patch(:, :)            !! (2, node) As above, of this store
      !> Volume [m3]; times squares of stress and of difference [m3 Pa2]
      real(wp), intent(inout) :: sums(3)
      real(wp) :: weight(8), mean, pressure, kinetic
      integer :: node(8), lane, lanes_used, p

      lanes_used = 2**grid%dimensions
      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         call find_nodes(grid, coordinate, store, p, node, weight)
         if (.not. all(alone(node(:lanes_used)))) cycle
         mean = 0.0_wp
         do lane = 1, lanes_used
            if (patch(1, node(lane)) > 0.0_wp) &
               mean = mean + weight(lane)*patch(2, node(lane))/patch(1, node(lane))
         end do
         sums(1) = sums(1) + store%state%volume(p)
         kinetic = 0.5_wp*store%state%mass(p)*(store%velocity(p, 1)**2 &
            + store%velocity(p, 2)**2 + store%velocity(p, 3)**2)
         sums(2) = sums(2) + kinetic**2/store%state%volume(p)
         if (allocated(store%state%failed)) then
            if (store%state%failed(p) /= 0) cycle
         end if
         pressure = pressure_of(store, p)
         sums(2) = sums(2) + store%state%volume(p)*merge(deviator_square(store, p), &
            pressure**2, locks)
         sums(3) = sums(3) + store%state%volume(p)*(pressure - mean)**2
      end do
   end subroutine measure_noise

   !> Pressure of a particle, with its viscous part [Pa].
   pure real(wp) function pressure_of(store, p) result(pressure)
      type(store_t), intent(in) :: store
      integer, intent(in) :: p

      pressure = -(store%state%stress(p, 1) + store%state%stress(p, 2) &
         + store%state%stress(p, 3))/3.0_wp
   end function pressure_of

   !> Square of the deviatoric stress of a particle, s:s [Pa2].
   pure real(wp) function deviator_square(store, p) result(square)
      type(store_t), intent(in) :: store
      integer, intent(in) :: p

      associate (s => store%state%stress)
         square = sum((s(p, :3) + pressure_of(store, p))**2) + 2.0_wp*sum(s(p, 4:)**2)
      end associate
   end function deviator_square

   !> Nodes of the cell of a particle and their linear shape functions there.
   pure subroutine find_nodes(grid, coordinate, store, p, node, weight)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      integer, intent(out) :: node(8)                !! (lane) Nodes of the tile
      real(wp), intent(out) :: weight(8)             !! (lane) Sum 1
      real(wp) :: corner(3), place
      integer :: k, lane, extent(3), cell(3)
      real(wp) :: share(0:1, 3)

      corner = grid%tile_corner(coordinate)
      extent = grid%tile_extent(coordinate)
      cell = 0
      share(0, :) = 1.0_wp
      share(1, :) = 0.0_wp
      do k = 1, 3
         if (.not. grid%active(k)) cycle
         place = (store%position(p, k) - corner(k))/grid%spacing
         cell(k) = max(0, min(extent(k) - 1, int(place)))
         share(1, k) = max(0.0_wp, min(1.0_wp, place - real(cell(k), wp)))
         share(0, k) = 1.0_wp - share(1, k)
      end do
      node(1) = 1 + dot_product(cell + merge(grid%margin, 0, grid%active), grid%stride)
      do lane = 1, 8
         node(lane) = node(1) + grid%lane_offset(lane)
         weight(lane) = share(ibits(lane - 1, lane_bit(1), 1), 1) &
            *share(ibits(lane - 1, lane_bit(2), 1), 2)*share(ibits(lane - 1, lane_bit(3), 1), 3)
      end do
   end subroutine find_nodes
end module particle_crowding
