! SPDX-License-Identifier: BSD-3-Clause
!> Particles at random positions, none closer to another than a least distance (Poisson disks).
!!
!! Dart throwing: random points are added one by one, and a point too close to an earlier one is
!! dropped (R. L. Cook, ACM Trans. Graph. 5 (1986) 51). The grid is cut into blocks of cells, so
!! that a tile can be filled without data of other ranks. One pattern is generated on a periodic
!! block. Every block has the points of the pattern within half the least distance of its faces; the
!! points in its interior are at least half the distance away from the faces and use separate random
!! numbers. So the blocks differ, fit together, and can be filled independently.
module particle_disks
   use base_kinds, only: int64, wp
   use base_random, only: random_uniform
   use mesh_grid, only: grid_t
   use particle_body, only: cell_of, given_t
   implicit none
   private

   public :: disks_t, start_disks

   !> Fraction of space that balls with the least distance as diameter fill after `trials` random
   !! points per expected particle, by dimensions; measured by counting. For infinitely many trials
   !! it is 0.748, 0.547 and 0.384: A. Rényi (1958), J. Feder, J. Theor. Biol. 87 (1980) 237.
   real(wp), parameter :: filled(3) = [0.71_wp, 0.461_wp, 0.277_wp]
   !> Volume of a ball of diameter one, by dimensions.
   real(wp), parameter :: ball(3) = [1.0_wp, 0.785398163397448_wp, 0.523598775598299_wp]
   integer, parameter :: trials = 16                  !! Random points per particle expected
   integer, parameter :: block_cells(3) = [64, 10, 6] !! Cells along a block, by dimensions
   integer(int64), parameter :: pattern_key = -1      !! Key of the random numbers of the pattern

   !> Particles in Poisson disks.
   type, extends(given_t) :: disks_t
      integer(int64) :: seed = 0                      !! Random seed of the run
      integer(int64) :: key = 0                       !! Differs between bodies
      real(wp) :: distance = 0.0_wp                   !! Least distance [cells]
      integer :: width(3) = 1                         !! Cells along a block
      integer :: wanted = 1                           !! Target number of points of a block
      real(wp), allocatable :: frame(:, :)            !! (3, point) Pattern near the faces [cells]
   contains
      procedure :: numbers => disks_numbers           !! Number of possible identities
      procedure :: collect => disks_collect           !! The particles of a tile
   end type disks_t

   !> Points of a block, sorted into bins with edges of at least the least distance.
   type :: thrown_t
      integer :: count = 0                            !! Points so far
      real(wp), allocatable :: place(:, :)            !! (3, point) [cells]
      integer, allocatable :: next(:)                 !! (point) Next point of its bin, 0 = none
      integer, allocatable :: first(:)                !! (bin) First point, 0 = none
      integer :: bins(3) = 1                          !! Along each direction
      integer :: width(3) = 1                         !! Cells along the block
   end type thrown_t

contains

   !> Choose distance and blocks, and generate the pattern.
   pure subroutine start_disks(disks, grid, per_cell, seed, key)
      type(disks_t), intent(out) :: disks
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: per_cell                 !! Particles of a cell
      integer(int64), intent(in) :: seed              !! Seed of the run
      integer(int64), intent(in) :: key               !! Key of the body
      type(thrown_t) :: thrown
      integer :: k, n
      logical, allocatable :: near(:)

      disks%seed = seed
      disks%key = key
      disks%distance = (filled(grid%dimensions)/(ball(grid%dimensions)*real(per_cell, wp))) &
         **(1.0_wp/real(grid%dimensions, wp))
      do k = 1, 3
         if (grid%active(k)) disks%width(k) = block_width(grid%cells(k), grid%periodic(k), &
            block_cells(grid%dimensions))
      end do
      disks%wanted = per_cell*product(disks%width)
      call start_block(thrown, disks)
      call throw_points(disks, grid, pattern_key, .true., thrown)
      allocate (near(thrown%count))
      do n = 1, thrown%count
         near(n) = any(grid%active .and. (thrown%place(:, n) < 0.5_wp*disks%distance .or. &
            thrown%place(:, n) > real(disks%width, wp) - 0.5_wp*disks%distance))
      end do
      allocate (disks%frame(3, count(near)))
      do k = 1, 3
         disks%frame(k, :) = pack(thrown%place(k, :thrown%count), near)
      end do
   end subroutine start_disks

   !> Cells along a block. In a periodic direction the blocks must divide the domain.
   pure integer function block_width(cells, periodic, usual) result(width)
      integer, intent(in) :: cells                    !! Number of cells of the grid
      logical, intent(in) :: periodic
      integer, intent(in) :: usual                     !! Usual width
      integer :: trial

      width = usual
      if (.not. periodic) return
      width = cells
      do trial = min(2*usual, cells), max(usual/2, 2), -1
         if (mod(cells, trial) == 0 .and. abs(trial - usual) < abs(width - usual)) width = trial
      end do
   end function block_width

   !> Make an empty block.
   pure subroutine start_block(thrown, disks)
      type(thrown_t), intent(out) :: thrown
      class(disks_t), intent(in) :: disks              !! Disks with distance and width

      thrown%width = disks%width
      thrown%bins = max(int(real(disks%width, wp)/disks%distance), 1)
      where (disks%width == 1) thrown%bins = 1
      allocate (thrown%first(product(thrown%bins)))
      allocate (thrown%place(3, 16*disks%wanted + 64), thrown%next(16*disks%wanted + 64))
      thrown%first = 0
   end subroutine start_block

   !> Add random points to a block.
   pure subroutine throw_points(disks, grid, key, closed, thrown)
      class(disks_t), intent(in) :: disks
      type(grid_t), intent(in) :: grid                !! For its directions
      integer(int64), intent(in) :: key               !! Key of the random numbers
      logical, intent(in) :: closed                   !! Is the block periodic?
      type(thrown_t), intent(inout) :: thrown         !! Gets the points
      real(wp) :: place(3), margin, extent(3)
      integer(int64) :: owner
      integer :: n, k

      owner = 2*disks%key + 1 + 1048576_int64*(key + 1)
      extent = real(disks%width, wp)
      margin = merge(0.0_wp, 0.5_wp*disks%distance, closed)
      place = 0.5_wp
      do n = 0, trials*disks%wanted - 1
         do k = 1, 3
            if (grid%active(k)) place(k) = margin + (extent(k) - 2.0_wp*margin) &
               *random_uniform(disks%seed, owner, int(3*n + k, int64))
         end do
         if (.not. crowded(thrown, grid, disks%distance, closed, place)) call add_point(thrown, &
            place)
      end do
   end subroutine throw_points

   !> Bin of a position; positions outside the block belong to its outermost bins.
   pure function bin_of(thrown, place) result(bin)
      type(thrown_t), intent(in) :: thrown
      real(wp), intent(in) :: place(3)                !! [cells]
      integer :: bin(3)

      bin = min(max(int(place*real(thrown%bins, wp)/real(thrown%width, wp)), 0), thrown%bins - 1)
   end function bin_of

   !> Add a point.
   pure subroutine add_point(thrown, place)
      type(thrown_t), intent(inout) :: thrown
      real(wp), intent(in) :: place(3)                !! [cells]
      integer :: bin(3), index

      bin = bin_of(thrown, place)
      index = 1 + bin(1) + thrown%bins(1)*(bin(2) + thrown%bins(2)*bin(3))
      thrown%count = thrown%count + 1
      thrown%place(:, thrown%count) = place
      thrown%next(thrown%count) = thrown%first(index)
      thrown%first(index) = thrown%count
   end subroutine add_point

   !> True if a position is too close to a point.
   pure logical function crowded(thrown, grid, distance, closed, place) result(near)
      type(thrown_t), intent(in) :: thrown
      type(grid_t), intent(in) :: grid                !! For its directions
      real(wp), intent(in) :: distance                !! Least distance [cells]
      logical, intent(in) :: closed                   !! Is the block periodic?
      real(wp), intent(in) :: place(3)                !! [cells]
      integer :: bin(3), at(3), x, y, z, point
      real(wp) :: offset(3), extent(3)

      near = .true.
      extent = real(thrown%width, wp)
      bin = bin_of(thrown, place)
      do z = -1, 1
         if (z /= 0 .and. .not. grid%active(3)) cycle
         do y = -1, 1
            if (y /= 0 .and. .not. grid%active(2)) cycle
            do x = -1, 1
               at = bin + [x, y, z]
               if (closed) then
                  at = modulo(at, thrown%bins)
               else if (any(at < 0 .or. at >= thrown%bins)) then
                  cycle
               end if
               point = thrown%first(1 + at(1) + thrown%bins(1)*(at(2) + thrown%bins(2)*at(3)))
               do while (point > 0)
                  offset = thrown%place(:, point) - place
                  if (closed) offset = offset - extent*anint(offset/extent)
                  if (sum(merge(offset, 0.0_wp, grid%active)**2) < distance**2) return
                  point = thrown%next(point)
               end do
            end do
         end do
      end do
      near = .false.
   end function crowded

   !> Points of a block: first those near its faces, then the interior ones. Points of adjacent
   !! blocks near the common faces keep the interior ones at a distance and are not returned.
   pure subroutine make_block(disks, grid, block, place, points)
      class(disks_t), intent(in) :: disks
      type(grid_t), intent(in) :: grid                !! For its directions
      integer, intent(in) :: block(3)                 !! Block, from 0
      real(wp), allocatable, intent(out) :: place(:, :) !! (3, point) In the block [cells]
      integer, intent(out) :: points                  !! Number of points
      type(thrown_t) :: thrown
      integer :: n, x, y, z, beyond, blocks(3)
      real(wp) :: extent(3), image(3)
      integer(int64) :: key

      call start_block(thrown, disks)
      extent = real(disks%width, wp)
      do n = 1, size(disks%frame, 2)
         call add_point(thrown, disks%frame(:, n))
      end do
      do z = -1, 1
         do y = -1, 1
            do x = -1, 1
               if (all([x, y, z] == 0) .or. any([x, y, z] /= 0 .and. .not. grid%active)) cycle
               do n = 1, size(disks%frame, 2)
                  image(1) = disks%frame(1, n) + extent(1)*real(x, wp)
                  image(2) = disks%frame(2, n) + extent(2)*real(y, wp)
                  image(3) = disks%frame(3, n) + extent(3)*real(z, wp)
                  if (all(image > -0.5_wp*disks%distance .and. image < extent &
                     + 0.5_wp*disks%distance)) call add_point(thrown, image)
               end do
            end do
         end do
      end do
      beyond = thrown%count
      blocks = blocks_of(disks, grid)
      key = block(1) + int(blocks(1), int64)*(block(2) + int(blocks(2), int64)*block(3))
      call throw_points(disks, grid, key, .false., thrown)
      points = size(disks%frame, 2) + thrown%count - beyond
      allocate (place(3, points))
      place(:, :size(disks%frame, 2)) = disks%frame
      place(:, size(disks%frame, 2) + 1:) = thrown%place(:, beyond + 1:thrown%count)
   end subroutine make_block

   !> Blocks along each direction.
   pure function blocks_of(disks, grid) result(blocks)
      class(disks_t), intent(in) :: disks              !! Disks with their width
      type(grid_t), intent(in) :: grid
      integer :: blocks(3)

      blocks = (grid%cells + disks%width - 1)/disks%width
   end function blocks_of

   !> Upper bound of the points of a block: balls fill at most 1, 0.91 and 0.74 of space, and those
   !! centred in the block may extend beyond it.
   pure integer(int64) function most_points(disks) result(most)
      class(disks_t), intent(in) :: disks

      most = 8_int64*disks%wanted
   end function most_points

   !> Number of possible identities of particles.
   pure function disks_numbers(self, grid) result(numbers)
      class(disks_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer(int64) :: numbers(3)

      numbers = blocks_of(self, grid)
      numbers(1) = numbers(1)*most_points(self)
   end function disks_numbers

   !> The particles of a tile. Their volumes are relative weights: 1, or the radius of a ring.
   pure subroutine disks_collect(self, grid, coordinate, position, volume, number)
      class(disks_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      real(wp), allocatable, intent(out) :: position(:, :) !! (3, particle) [m]
      real(wp), allocatable, intent(out) :: volume(:) !! (particle) 1, or radius [1, m]
      integer(int64), allocatable, intent(out) :: number(:) !! (particle) From 1, each once
      real(wp), allocatable :: place(:, :), all_positions(:, :)
      real(wp) :: spot(3)
      integer(int64), allocatable :: all_numbers(:)
      integer :: first(3), last(3), low(3), high(3), blocks(3), x, y, z, n, points, found

      low = coordinate*grid%width
      high = low + grid%tile_extent(coordinate) - 1
      first = low/self%width
      last = high/self%width
      blocks = blocks_of(self, grid)
      allocate (all_positions(3, int(product(last - first + 1)*most_points(self))))
      allocate (all_numbers(size(all_positions, 2)))
      found = 0
      do z = first(3), last(3)
         do y = first(2), last(2)
            do x = first(1), last(1)
               call make_block(self, grid, [x, y, z], place, points)
               do n = 1, points
                  spot = in_space(self, grid, [x, y, z], place(:, n))
                  if (any(cell_of(grid, spot) < low .or. cell_of(grid, spot) > high)) cycle
                  if (any(grid%active .and. spot >= grid%upper)) cycle
                  found = found + 1
                  all_positions(:, found) = spot
                  all_numbers(found) = n + most_points(self)*(x + blocks(1)*(y &
                     + int(blocks(2), int64)*z))
               end do
            end do
         end do
      end do
      position = all_positions(:, :found)
      number = all_numbers(:found)
      allocate (volume(found))
      volume = 1.0_wp
      if (grid%axisymmetric) volume = position(1, :)
   end subroutine disks_collect

   !> Position of a point [m]; along missing directions that of all particles.
   pure function in_space(disks, grid, block, place) result(position)
      class(disks_t), intent(in) :: disks              !! Width of blocks
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: block(3)                 !! Block, from 0
      real(wp), intent(in) :: place(3)                !! In the block [cells]
      real(wp) :: position(3)

      position = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
      where (grid%active) position = grid%lower + grid%spacing*(real(block*disks%width, wp) + place)
   end function in_space
end module particle_disks
