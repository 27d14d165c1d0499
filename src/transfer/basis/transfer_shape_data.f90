! SPDX-License-Identifier: BSD-3-Clause
!> Data of the particles of a tile for the shape functions: cells, local coordinates, values of the
!! functions; scratch space of a thread.
!!
!! A particle q of the store has index q - first + 1 in its tile. Arrays that the method does not
!! need are not allocated.
module transfer_shape_data
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   implicit none
   private

   public :: find_local, shape_data_t, spline_data_t

   integer, parameter, public :: line = 4            !! Nodes along a line of an extended support
   !> Rows after the last particle that columns of a tile have at least: kernels with particles as
   !! lanes may write them
   integer, parameter, public :: spare = 8

   !> Functions with extended support, by direction.
   type :: spline_data_t
      integer :: reach = line                        !! Nodes along a line, from the first one on
      integer :: after = 0 !! Layers along z that a particle touches after the first one
      integer, allocatable :: node(:)                !! (particle) First node, in the tile
      !> (particle, node, direction) Functions of the nodes from the first one on along a line
      real(wp), allocatable :: weight(:, :, :)
      real(wp), allocatable :: slope(:, :, :)        !! Mean derivatives of the functions [1/m]
      !> (particle, 3) Local coordinate from the second of these nodes on, negative where the first
      !! of them is the first node of the cell [cells]
      real(wp), allocatable :: local(:, :)
      !> (particle, 3) Extent of functions beyond the cells adjacent to their node [cells]
      real(wp), allocatable :: overhang(:, :)
      integer, allocatable :: low(:, :)              !! (particle, 3) First node in use, 1 or 2
   contains
      procedure :: reserve => spline_reserve
      procedure :: take_cells => spline_take_cells   !! First nodes are those before the cells
      procedure :: touched => spline_touched         !! First and last node that particles touch
   end type spline_data_t

   !> Means of the dual gradient over sub-points, indices as of spline_data_t.
   type :: mean_data_t
      type(spline_data_t) :: spline                  !! Functions of the nodes
      real(wp), allocatable :: cell_slope(:, :, :)   !! alpha times derivative [1/m]
      real(wp), allocatable :: node_value(:, :, :)   !! (1 - alpha) times function
   contains
      procedure :: reserve => mean_reserve
   end type mean_data_t

   !> Corners of the parallelepipeds of particles.
   type :: corner_data_t
      real(wp), allocatable :: local(:, :, :)        !! (corner, direction, particle) In its cell
      integer, allocatable :: node(:, :)             !! (corner, particle) First node of that cell
      real(wp), allocatable :: edge(:, :)            !! (9, particle) Matrix of half edges
      real(wp), allocatable :: inverse(:, :)         !! (9, particle) Inverse matrix
   contains
      procedure :: reserve => corner_reserve
   end type corner_data_t

   !> Shape data of the particles of one tile.
   type :: shape_data_t
      integer :: count = 0                           !! Particles of the tile
      integer, allocatable :: start(:)               !! (0:cells) Particles before each cell
      real(wp), allocatable :: local(:, :)           !! (particle, 3) Local coordinates, 0 to 1
      real(wp), allocatable :: alpha(:, :)           !! (particle, 3) Weight alpha of the cell
      real(wp), allocatable :: blend(:, :)           !! (particle, 3) Smoothed local coordinates
      type(spline_data_t) :: spline
      type(mean_data_t) :: mean
      type(corner_data_t) :: corner
      !> (edge, cell) Factors of the part of the gradient on the cell, if sums are normalised [1]
      real(wp), allocatable :: factor(:, :)
      real(wp), allocatable :: vector(:, :)          !! (particle, 3) Mapped values
      real(wp), allocatable :: values(:, :)          !! (particle, 9) Between two steps of a map
      real(wp), allocatable :: affine(:, :)          !! (particle, 9) Linear velocity fields [1/s]
      real(wp), allocatable :: increments(:, :)      !! (particle, column) For `transfer_increments`
   contains
      procedure :: reserve => shape_reserve
      procedure :: reserve_affine => shape_reserve_affine
      procedure :: reserve_increments => shape_reserve_increments
      procedure :: take_tile => shape_take_tile      !! Cells and local coordinates of a tile
   end type shape_data_t

contains

   !> Reserve memory for a number of particles. Previous values are lost.
   pure subroutine shape_reserve(self, particles)
      class(shape_data_t), intent(inout) :: self
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      if (allocated(self%local)) then
         if (size(self%local, 1) >= particles + spare) return
         deallocate (self%local, self%alpha, self%blend, self%vector, self%values)
      end if
      n = column_length(particles)
      allocate (self%local(n, 3), self%alpha(n, 3), self%blend(n, 3), self%vector(n, 3), &
         self%values(n, 9))
   end subroutine shape_reserve

   !> Reserve memory for linear velocity fields. Previous values are lost.
   pure subroutine shape_reserve_affine(self, particles)
      class(shape_data_t), intent(inout) :: self
      integer, intent(in) :: particles               !! Most particles in a tile

      if (allocated(self%affine)) then
         if (size(self%affine, 1) >= particles + spare) return
         deallocate (self%affine)
      end if
      allocate (self%affine(column_length(particles), 9))
   end subroutine shape_reserve_affine

   !> Reserve memory for the values gathered from the nodes. Previous values are lost.
   pure subroutine shape_reserve_increments(self, particles, columns)
      class(shape_data_t), intent(inout) :: self
      integer, intent(in) :: particles               !! Most particles in a tile
      integer, intent(in) :: columns                 !! Columns, the multiple of three above counts

      if (allocated(self%increments)) then
         if (size(self%increments, 1) >= particles + spare .and. &
            size(self%increments, 2) >= columns + 2) return
         deallocate (self%increments)
      end if
      allocate (self%increments(column_length(particles), columns + 2))
   end subroutine shape_reserve_increments

   !> Reserve memory for functions with extended support. Previous values are lost.
   pure subroutine spline_reserve(self, particles)
      class(spline_data_t), intent(inout) :: self
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      if (allocated(self%weight)) then
         if (size(self%weight, 1) >= particles) return
         deallocate (self%weight, self%slope, self%local, self%overhang, self%low, self%node)
      end if
      n = column_length(particles)
      allocate (self%weight(n, line, 3), self%slope(n, line, 3), self%local(n, 3), &
         self%overhang(n, 3), self%low(n, 3), self%node(n))
   end subroutine spline_reserve

   !> First nodes of particles that are given four nodes along each direction.
   pure subroutine spline_take_cells(self, grid, start)
      class(spline_data_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: start(0:)   !! (0:cells) Particles before a cell
      integer :: cell, p, node

      self%reach = line
      self%after = merge(line - 1, 0, grid%active(3))
      do cell = 0, grid%tile_cells - 1
         node = grid%first_node(cell) - sum(grid%stride)
         do p = start(cell) + 1, start(cell + 1)
            self%node(p) = node
         end do
      end do
   end subroutine spline_take_cells

   !> First and last node that the particles of a tile touch in three dimensions; 1 and 0 without
   !! particles.
   pure subroutine spline_touched(self, grid, count, low, high)
      class(spline_data_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: count                   !! Particles of the tile
      integer, intent(out) :: low, high              !! First and last node
      integer :: p

      low = 1
      high = 0
      if (count == 0) return
      low = self%node(1)
      high = self%node(1)
      !$omp simd reduction(min: low) reduction(max: high)
      do p = 1, count
         low = min(low, self%node(p))
         high = max(high, self%node(p))
      end do
      high = high + (self%reach - 1)*sum(grid%stride)
   end subroutine spline_touched

   !> Reserve memory for means of the dual gradient. Previous values are lost.
   pure subroutine mean_reserve(self, particles)
      class(mean_data_t), intent(inout) :: self
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      call self%spline%reserve(particles)
      if (allocated(self%cell_slope)) then
         if (size(self%cell_slope, 1) >= particles) return
         deallocate (self%cell_slope, self%node_value)
      end if
      n = column_length(particles)
      allocate (self%cell_slope(n, line, 3), self%node_value(n, line, 3))
   end subroutine mean_reserve

   !> Reserve memory for the corners of particles. Previous values are lost.
   pure subroutine corner_reserve(self, particles, corners)
      class(corner_data_t), intent(inout) :: self
      integer, intent(in) :: particles               !! Most particles in a tile
      integer, intent(in) :: corners                 !! Corners of a particle
      integer :: n

      if (allocated(self%local)) then
         if (size(self%local, 3) >= particles) return
         deallocate (self%local, self%node, self%edge, self%inverse)
      end if
      n = column_length(particles)
      allocate (self%local(corners, 3, n), self%node(corners, n), self%edge(9, n), &
         self%inverse(9, n))
   end subroutine corner_reserve

   !> Length of columns for some particles. It is not a power of two, because such columns would map
   !! to few cache sets.
   pure integer function column_length(particles) result(length)
      integer, intent(in) :: particles               !! Particles of a tile

      length = 64*((particles + particles/4 + 63)/64) + spare
   end function column_length

   !> Copy the cells of the particles of a tile and find their local coordinates. Memory must have
   !! been reserved.
   pure subroutine shape_take_tile(self, grid, store, tile)
      class(shape_data_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer :: cell

      self%count = store%count(tile)
      if (allocated(self%start)) then
         if (ubound(self%start, 1) /= grid%tile_cells) deallocate (self%start)
      end if
      if (.not. allocated(self%start)) allocate (self%start(0:grid%tile_cells))
      do cell = 0, grid%tile_cells
         self%start(cell) = store%cell_start(cell, tile)
      end do
      call find_local(grid, store%first(tile), self%count, store%position, self%local)
      self%local(self%count + 1:self%count + spare, :) = 0.0_wp
   end subroutine shape_take_tile

   !> Local coordinates of each particle in its cell, 0 to 1 along each active direction. The same
   !! arithmetic as that which found the cell, so that both agree to the last bit.
   pure subroutine find_local(grid, first, count, position, local)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) [m]
      real(wp), contiguous, intent(inout) :: local(:, :)     !! (particle of the tile, 3)
      real(wp) :: inverse, lower, cells
      integer :: p, direction

      inverse = 1.0_wp/grid%spacing
      do direction = 1, 3
         if (.not. grid%active(direction)) then
            local(:count, direction) = 0.0_wp
            cycle
         end if
         lower = grid%lower(direction)
         do p = 1, count
            cells = (position(first + p - 1, direction) - lower)*inverse
            local(p, direction) = cells - real(int(cells), wp)
         end do
      end do
   end subroutine find_local
end module transfer_shape_data
