! SPDX-License-Identifier: BSD-3-Clause
!> The uniform Cartesian grid: cells, tiles of cells, and the constants of a cell's nodes.
!!
!! The code is the same in one, two and three dimensions: a cell always has eight lanes, one per
!! node, and the bits of the lane number less 1 are the positions along each direction. An inactive
!! direction has one layer of cells and nodes; its upper lanes have weight zero and coincide with
!! the lower ones.
module mesh_grid
   use base_constants, only: pi
   use base_kinds, only: wp
   use mesh_domain, only: domain_t
   implicit none
   private

   public :: grid_t

   integer, parameter, public :: lanes = 8                     !! Nodes of a cell
   !> Bit of a direction in the number of a lane: inactive directions have the high bits, so that
   !! the lanes with weight come first.
   integer, parameter, public :: lane_bit(3) = [0, 2, 1]
   integer, parameter :: least_width = 4                       !! Layers of cells before the halo
   integer, parameter :: default_width(3) = [64, 5, 6]         !! Cells along a tile, by dimensions

   !> The grid: the domain, its tiles, and the tables of a tile.
   type, extends(domain_t) :: grid_t
      integer :: width(3) = 1                        !! Cells along a tile
      integer :: tiles(3) = 1                        !! Tiles along each direction
      integer :: tile_cells = 1                      !! Cells of a tile
      integer :: margin = 0                          !! Layers of nodes beyond the faces of a tile
      !> Transfers that need the margin between exchanges of patches: to the nodes, and with the
      !! dual gradient also back
      integer :: reaches = 1
      integer :: tile_nodes = 1                      !! Nodes of a tile, with faces and margin
      integer :: stride(3) = 0                       !! Step in the node index of a tile
      integer :: lane_offset(lanes) = 0              !! Node index of a lane above the cell's first
      !> Weight of lane a at local coordinate xi of direction k: constant(a, k) + slope(a, k) xi.
      real(wp) :: lane_constant(lanes, 3) = 0.0_wp
      real(wp) :: lane_slope(lanes, 3) = 0.0_wp
      integer, allocatable :: cell_position(:, :)    !! (3, 0:cells - 1) Position in the tile
      integer, allocatable :: first_node(:)          !! (0:cells - 1) Its first node in the tile
      !> (node of the grid, 3) Integral of the function of a node along each direction [m, m2]
      real(wp), allocatable :: line(:, :)
   contains
      procedure :: start => grid_start               !! Derive everything from corners and spacing
      procedure :: tile_extent => grid_tile_extent   !! Cells of one tile along each direction
      procedure :: tile_corner => grid_tile_corner   !! Lower corner of a tile
      procedure :: node_position => grid_node_position !! Position of a node in its tile
      procedure :: node_volume => grid_node_volume   !! Volume around each node of a tile
   end type grid_t

contains

   !> Derive counts, tiles and lane constants from dimensions, corners, spacing, periodicity and
   !! margin.
   pure subroutine grid_start(self, block)
      class(grid_t), intent(inout) :: self           !! Corners, spacing, dimensions are set
      integer, intent(in) :: block                   !! Cells along a tile, 0 = by dimensions
      integer :: direction, lane, bit

      self%active = [.true., self%dimensions == 3, self%dimensions >= 2]
      self%cells = 1
      where (self%active) self%cells = nint((self%upper - self%lower)/self%spacing)
      self%width = 1
      do direction = 1, 3
         if (.not. self%active(direction)) cycle
         self%width(direction) = tile_width(self%cells(direction), self%periodic(direction), &
            merge(block, default_width(self%dimensions), block > 0), least_width &
            + self%reaches*self%margin)
      end do
      self%tiles = (self%cells + self%width - 1)/self%width
      self%tile_cells = product(self%width)
      self%stride = 0
      self%tile_nodes = 1
      do direction = 1, 3
         if (.not. self%active(direction)) cycle
         self%stride(direction) = self%tile_nodes
         self%tile_nodes = self%tile_nodes*(self%width(direction) + 1 + 2*self%margin)
      end do
      self%depth = 1.0_wp
      if (self%axisymmetric) then
         self%depth = 2.0_wp*pi
      else
         do direction = 1, 3
            if (.not. self%active(direction)) &
               self%depth = self%depth*(self%upper(direction) - self%lower(direction))
         end do
      end if
      self%lane_offset = 0
      self%lane_slope = 0.0_wp
      do direction = 1, 3
         do lane = 1, lanes
            bit = ibits(lane - 1, lane_bit(direction), 1)
            self%lane_constant(lane, direction) = 1 - bit
            if (.not. self%active(direction)) cycle
            self%lane_slope(lane, direction) = 2*bit - 1
            self%lane_offset(lane) = self%lane_offset(lane) + bit*self%stride(direction)
         end do
      end do
      call number_cells(self)
      call integrate_lines(self)
   end subroutine grid_start

   !> Cells along a tile. The halo must not reach the next tile but one, so in a periodic direction
   !! the last tile must be at least as thick as the halo.
   pure integer function tile_width(cells, periodic, preferred, least) result(width)
      integer, intent(in) :: cells                   !! Cells along the direction
      logical, intent(in) :: periodic                !! Is the direction periodic?
      integer, intent(in) :: preferred               !! Preferred width
      integer, intent(in) :: least                   !! Layers that the halo needs
      integer :: trial, rest

      width = max(min(preferred, cells), min(least, cells))
      if (.not. periodic) return
      do trial = 0, cells
         if (cells <= least) exit
         width = max(preferred, least) + merge(trial/2, -(trial/2), mod(trial, 2) == 0)
         if (width < least .or. width > cells) cycle
         rest = mod(cells, width)
         if (rest == 0 .or. rest >= least) return
      end do
      width = cells
   end function tile_width

   !> Cells of one tile along each direction; the last tile may be thinner than the others.
   pure function grid_tile_extent(self, coordinate) result(extent)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer :: extent(3)

      extent = min(self%width, self%cells - coordinate*self%width)
   end function grid_tile_extent

   !> Lower corner of a tile [m].
   pure function grid_tile_corner(self, coordinate) result(corner)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp) :: corner(3)

      corner = self%lower + real(coordinate*self%width, wp)*self%spacing
   end function grid_tile_corner

   !> Tables of the cells of a tile.
   pure subroutine number_cells(grid)
      class(grid_t), intent(inout) :: grid
      integer :: cell

      if (allocated(grid%first_node)) deallocate (grid%first_node, grid%cell_position)
      allocate (grid%cell_position(3, 0:grid%tile_cells - 1), &
         grid%first_node(0:grid%tile_cells - 1))
      do cell = 0, grid%tile_cells - 1
         grid%cell_position(1, cell) = mod(cell, grid%width(1))
         grid%cell_position(2, cell) = mod(cell/grid%width(1), grid%width(2))
         grid%cell_position(3, cell) = cell/(grid%width(1)*grid%width(2))
         grid%first_node(cell) = 1 + dot_product(grid%cell_position(:, cell) + grid%margin, &
            grid%stride)
      end do
   end subroutine number_cells

   !> Integrals of the functions of all nodes along each direction, those of the margin included.
   pure subroutine integrate_lines(grid)
      class(grid_t), intent(inout) :: grid
      real(wp) :: weight(0:1)
      integer :: direction, cell, most

      most = maxval(grid%cells) + grid%margin
      if (allocated(grid%line)) deallocate (grid%line)
      allocate (grid%line(-grid%margin:most, 3), source=0.0_wp)
      do direction = 1, 3
         if (.not. grid%active(direction)) then
            grid%line(0, direction) = 1.0_wp
            cycle
         end if
         do cell = -grid%margin - 1, grid%cells(direction) + grid%margin
            if (.not. grid%periodic(direction) .and. &
               (cell < 0 .or. cell >= grid%cells(direction))) cycle
            weight = grid%line_weight(direction, cell)
            if (cell >= -grid%margin) grid%line(cell, direction) = grid%line(cell, direction) &
               + weight(0)
            if (cell < grid%cells(direction) + grid%margin) grid%line(cell + 1, direction) = &
               weight(1)
         end do
      end do
   end subroutine integrate_lines

   !> Position of a node in its tile along each direction, 0 on the lower face, less in the margin.
   pure function grid_node_position(self, node) result(position)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: node                    !! Node of a tile, counted from 1
      integer :: position(3)
      integer :: direction

      position = 0
      do direction = 1, 3
         if (self%active(direction)) position(direction) = &
            mod((node - 1)/self%stride(direction), self%width(direction) + 1 + 2*self%margin) &
            - self%margin
      end do
   end function grid_node_position

   !> Volume of each node of a tile: the integral of its shape function over the domain [m3].
   pure subroutine grid_node_volume(self, coordinate, volume)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(out) :: volume(:)             !! (node of the tile) [m3]
      real(wp) :: area
      integer :: extent(3), first(3), last(3), at(3), node, x, y, z

      extent = self%tile_extent(coordinate)
      volume = 0.0_wp
      first = merge(-self%margin, 0, self%active)
      last = merge(extent + self%margin, 0, self%active)
      at = merge(coordinate*self%width, 0, self%active)
      do z = first(3), last(3)
         do y = first(2), last(2)
            area = self%depth*self%line(at(2) + y, 2)*self%line(at(3) + z, 3)
            node = (y - first(2))*self%stride(2) + (z - first(3))*self%stride(3)
            do x = first(1), last(1)
               node = node + 1
               volume(node) = area*self%line(at(1) + x, 1)
            end do
         end do
      end do
   end subroutine grid_node_volume
end module mesh_grid
