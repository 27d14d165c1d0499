! SPDX-License-Identifier: BSD-3-Clause
!> Fills bodies with particles, on a lattice that divides the cells of the grid or as given.
!!
!! The identity of a particle is the number of its site in the whole domain, offset by the body; so
!! neither identity nor position depends on ranks. Where bodies overlap, the later one has priority.
module particle_fill
   use base_communicator, only: communicator_t
   use base_constants, only: pi
   use base_kinds, only: int64, wp
   use base_random, only: random_uniform
   use base_sort, only: sort_order
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_key
   use particle_body, only: belongs, body_t, cell_of, find_boxes, find_near, site_position, &
      tile_sites
   use particle_candidates, only: candidates_t
   use particle_store, only: store_t
   implicit none
   private

   public :: body_t, fill_bodies, site_volume, survey_bodies

contains

   !> Count the particles of each body, and those of each tile assigned to this rank. Each tile is
   !! on the list of exactly one rank; no rank has a list of all. Collective.
   subroutine survey_bodies(communicator, grid, bodies, key, particles, body_count)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer(int64), allocatable, intent(out) :: key(:)       !! Tiles with particles, ascending
      integer(int64), allocatable, intent(out) :: particles(:) !! (tile) Number of particles
      integer(int64), intent(out) :: body_count(:)    !! (body) Particles of each, on all ranks
      type(candidates_t) :: candidates
      integer(int64), allocatable :: own(:), pairs(:, :)
      integer, allocatable :: order(:)
      real(wp), allocatable :: low(:, :), high(:, :)
      integer(int64) :: round, found
      integer :: coordinate(3), filled
      logical :: dealt

      call candidates%find(grid, bodies)
      call find_boxes(grid, bodies, low, high)
      allocate (key(0), particles(0))
      body_count = 0
      !$omp parallel default(none) private(round, coordinate, dealt, own, pairs, filled, found) &
      !$omp shared(communicator, grid, bodies, low, high, candidates, key, particles, body_count)
      allocate (own(size(bodies)), pairs(64, 2))
      own = 0
      filled = 0
      !$omp do schedule(dynamic, 16)
      do round = 1, candidates%rounds(communicator)
         call candidates%deal(communicator, round, coordinate, dealt)
         if (.not. dealt) cycle
         call count_tile(grid, bodies, low, high, coordinate, own, found)
         if (found > 0) call append_pair(hilbert_key(coordinate, grid%dimensions), found, pairs, &
            filled)
      end do
      !$omp end do nowait
      !$omp critical (survey_counts)
      body_count = body_count + own
      key = [key, pairs(:filled, 1)]
      particles = [particles, pairs(:filled, 2)]
      !$omp end critical (survey_counts)
      !$omp end parallel
      call communicator%total(body_count)
      order = sort_order(key)
      key = key(order)
      particles = particles(order)
   end subroutine survey_bodies

   !> Append a tile and its particles to a list, which grows as needed.
   pure subroutine append_pair(key, particles, pairs, filled)
      integer(int64), intent(in) :: key               !! Position of the tile on the curve
      integer(int64), intent(in) :: particles         !! Particles in it
      integer(int64), allocatable, intent(inout) :: pairs(:, :) !! (entry, 2) The list
      integer, intent(inout) :: filled                !! Entries in use
      integer(int64), allocatable :: larger(:, :)

      if (filled == size(pairs, 1)) then
         allocate (larger(2*filled, 2))
         larger(:filled, :) = pairs
         call move_alloc(larger, pairs)
      end if
      filled = filled + 1
      pairs(filled, :) = [key, particles]
   end subroutine append_pair

   !> Count the particles of all bodies in a tile.
   pure subroutine count_tile(grid, bodies, low, high, coordinate, body_count, particles)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), contiguous, intent(in) :: low(:, :)   !! (direction, body) Boxes of the bodies [m]
      real(wp), contiguous, intent(in) :: high(:, :)  !! (direction, body) [m]
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer(int64), intent(inout) :: body_count(:)  !! (body) Grows by its particles
      integer(int64), intent(out) :: particles        !! Number of particles of all bodies
      integer(int64) :: found
      integer :: near(size(bodies)), number, n

      call find_near(grid, low, high, coordinate, near, number)
      particles = 0
      do n = 1, number
         found = count_sites(grid, bodies, near(n), near(n + 1:number), coordinate)
         body_count(near(n)) = body_count(near(n)) + found
         particles = particles + found
      end do
   end subroutine count_tile

   !> Count the particles that a body has in a tile.
   pure integer(int64) function count_sites(grid, bodies, body, later, coordinate) result(number)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer :: sites(3), x, y, z
      real(wp) :: low(3), high(3), edge(3), position(3), share

      number = 0
      if (allocated(bodies(body)%given)) then
         number = count_given(grid, bodies, body, later, coordinate)
         return
      end if
      call bodies(body)%shape%bounds(low, high)
      edge = grid%tile_corner(coordinate)
      if (any(grid%active .and. (edge > high .or. edge + grid%width*grid%spacing < low))) return
      sites = tile_sites(grid, bodies(body), coordinate)
      do z = 0, sites(3) - 1
         do y = 0, sites(2) - 1
            do x = 0, sites(1) - 1
               call measure_site(grid, bodies, body, later, site_position(grid, bodies(body), &
                  coordinate, [x, y, z]), share, position)
               if (share > 0.0_wp) number = number + 1
            end do
         end do
      end do
   end function count_sites

   !> Count the given particles that a body has in a tile.
   pure integer(int64) function count_given(grid, bodies, body, later, coordinate) result(particles)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      real(wp), allocatable :: position(:, :), volume(:)
      integer(int64), allocatable :: number(:)
      integer :: n

      particles = 0
      call bodies(body)%given%collect(grid, coordinate, position, volume, number)
      do n = 1, size(number)
         if (belongs(bodies, body, position(:, n), later)) particles = particles + 1
      end do
   end function count_given

   !> Fraction of a lattice site inside a body, and the centre of that part. Without cutting, the
   !! fraction is 1 if the middle of the site is inside the body.
   pure subroutine measure_site(grid, bodies, body, later, middle, share, position)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      real(wp), intent(in) :: middle(3)               !! Centre of the site [m]
      real(wp), intent(out) :: share                  !! 0 to 1
      real(wp), intent(out) :: position(3) !! Of the particle, if the fraction is > 0 [m]
      integer :: x, y, z, corners
      logical :: inside

      position = middle
      inside = belongs(bodies, body, middle, later)
      share = merge(1.0_wp, 0.0_wp, inside)
      if (.not. bodies(body)%cut) return
      corners = 0
      do z = -1, 1, 2
         do y = -1, 1, 2
            do x = -1, 1, 2
               if (belongs(bodies, body, middle + 0.5_wp*real([x, y, z], wp) &
                  *site_edge(grid, bodies(body)), later)) corners = corners + 1
            end do
         end do
      end do
      if ((inside .and. corners == 8) .or. (.not. inside .and. corners == 0)) return
      call cut_site(grid, bodies, body, later, middle, share, position)
   end subroutine measure_site

   !> Fraction of a site and its centre by sampling. Fractions below 1/50 are dropped, because a
   !! particle of so small a mass would be accelerated without bound by adjacent ones.
   pure subroutine cut_site(grid, bodies, body, later, middle, share, position)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      real(wp), intent(in) :: middle(3)               !! Centre of the site [m]
      real(wp), intent(out) :: share                  !! 0 to 1
      real(wp), intent(inout) :: position(3) !! Of the particle, if the fraction is > 0 [m]
      integer, parameter :: samples(3) = [64, 12, 6]  ! along an edge, by dimensions
      real(wp), parameter :: least = 0.02_wp
      real(wp) :: place(3), edge(3), weight, whole, part, moment(3)
      integer :: number(3), x, y, z

      number = merge(samples(grid%dimensions), 1, grid%active)
      edge = site_edge(grid, bodies(body))
      whole = 0.0_wp
      part = 0.0_wp
      moment = 0.0_wp
      do z = 1, number(3)
         do y = 1, number(2)
            do x = 1, number(1)
               place = middle + edge*((real([x, y, z], wp) - 0.5_wp)/real(number, wp) - 0.5_wp)
               weight = merge(place(1), 1.0_wp, grid%axisymmetric)
               whole = whole + weight
               if (.not. belongs(bodies, body, place, later)) cycle
               part = part + weight
               moment = moment + weight*(place - middle)
            end do
         end do
      end do
      share = part/whole
      if (share < least) share = 0.0_wp
      if (share > 0.0_wp .and. share < 1.0_wp) position = middle + moment/part
   end subroutine cut_site

   !> Edges of a lattice site [m]; 0 along a missing direction.
   pure function site_edge(grid, body) result(edge)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      real(wp) :: edge(3)

      edge = merge(grid%spacing/real(body%per_cell, wp), 0.0_wp, grid%active)
   end function site_edge

   !> Make the particles of the tiles of this rank. The store has empty tiles; its particles are not
   !! sorted yet.
   subroutine fill_bodies(grid, bodies, coordinates, index, store)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, contiguous, intent(in) :: coordinates(:, :) !! (3, tile) Tiles of this rank
      integer, intent(in) :: index                    !! Index of the store
      type(store_t), intent(inout) :: store
      integer, allocatable :: near(:), new_count(:)
      real(wp), allocatable :: low(:, :), high(:, :)
      integer :: tile, n, number

      call find_boxes(grid, bodies, low, high)
      allocate (new_count(size(store%count)))
      new_count = 0
      !$omp parallel default(none) private(tile, near, n, number) &
      !$omp shared(grid, bodies, low, high, coordinates, index, new_count)
      allocate (near(size(bodies)))
      !$omp do schedule(dynamic, 16)
      do tile = 1, size(new_count)
         call find_near(grid, low, high, coordinates(:, tile), near, number)
         do n = 1, number
            if (bodies(near(n))%store == index) new_count(tile) = new_count(tile) &
               + int(count_sites(grid, bodies, near(n), near(n + 1:number), coordinates(:, tile)))
         end do
      end do
      !$omp end do
      !$omp end parallel
      call store%layout(new_count)
      !$omp parallel default(none) private(tile, near, n, number) &
      !$omp shared(grid, bodies, low, high, coordinates, index, store, new_count)
      allocate (near(size(bodies)))
      !$omp do schedule(dynamic, 16)
      do tile = 1, size(new_count)
         call find_near(grid, low, high, coordinates(:, tile), near, number)
         do n = 1, number
            if (bodies(near(n))%store == index) call fill_tile(grid, bodies, near(n), &
               near(n + 1:number), coordinates(:, tile), tile, store)
         end do
         store%unsorted(tile) = .true.
      end do
      !$omp end do
      !$omp end parallel
   end subroutine fill_bodies

   !> Make the particles of one body in one tile.
   subroutine fill_tile(grid, bodies, body, later, coordinate, tile, store)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer, intent(in) :: tile                     !! Index
      type(store_t), intent(inout) :: store
      integer :: sites(3), x, y, z, cell(3)
      integer(int64) :: number(3), all_sites(3), identity
      real(wp) :: middle(3), position(3), share

      if (allocated(bodies(body)%given)) then
         call fill_given(grid, bodies, body, later, coordinate, tile, store)
         return
      end if
      associate (it => bodies(body))
         sites = tile_sites(grid, it, coordinate)
         all_sites = it%sites(grid)
         do z = 0, sites(3) - 1
            do y = 0, sites(2) - 1
               do x = 0, sites(1) - 1
                  middle = site_position(grid, it, coordinate, [x, y, z])
                  call measure_site(grid, bodies, body, later, middle, share, position)
                  if (.not. share > 0.0_wp) cycle
                  number = [x, y, z] + merge(int(coordinate*grid%width, int64)*it%per_cell, &
                     0_int64, grid%active)
                  cell = merge([x, y, z]/it%per_cell, 0, grid%active)
                  identity = it%first_identity + number(1) + all_sites(1)*(number(2) &
                     + all_sites(2)*number(3))
                  if (it%jitter) position = position + random_shift(identity)*site_edge(grid, it)
                  call add_particle(bodies, body, tile, identity, cell_number(grid, cell), &
                     position, &
                     share*site_volume(grid, it, middle), store)
                  call set_size(0.5_wp*site_edge(grid, it), &
                     store%first(tile) + store%count(tile) - 1, store)
               end do
            end do
         end do
      end associate
   end subroutine fill_tile

   !> Make the given particles of one body in one tile, as cubes of their volume.
   subroutine fill_given(grid, bodies, body, later, coordinate, tile, store)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer, intent(in) :: tile                     !! Index
      type(store_t), intent(inout) :: store
      real(wp), allocatable :: position(:, :), volume(:)
      integer(int64), allocatable :: number(:)
      real(wp) :: depth, half(3)
      integer :: n

      associate (it => bodies(body))
         call it%given%collect(grid, coordinate, position, volume, number)
         do n = 1, size(number)
            if (.not. belongs(bodies, body, position(:, n), later)) cycle
            call add_particle(bodies, body, tile, it%first_identity + number(n) - 1, &
               cell_number(grid, cell_of(grid, position(:, n)) - coordinate*grid%width), &
               position(:, n), it%share*volume(n), store)
            depth = merge(2.0_wp*pi*position(1, n), grid%depth, grid%axisymmetric)
            half = merge(0.5_wp*(it%share*volume(n)/depth)**(1.0_wp/real(grid%dimensions, wp)), &
               0.0_wp, grid%active)
            call set_size(half, store%first(tile) + store%count(tile) - 1, store)
         end do
      end associate
   end subroutine fill_given

   !> Append a particle to those of a tile.
   subroutine add_particle(bodies, body, tile, identity, home, position, volume, store)
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: tile
      integer(int64), intent(in) :: identity          !! Identity of the particle
      integer, intent(in) :: home                     !! Cell of the particle in the tile, from 0
      real(wp), intent(in) :: position(3)             !! [m]
      real(wp), intent(in) :: volume                  !! [m3]
      type(store_t), intent(inout) :: store
      integer :: p

      p = store%first(tile) + store%count(tile)
      store%count(tile) = store%count(tile) + 1
      store%identity(p) = identity
      if (allocated(store%body)) store%body(p) = body
      store%home(p) = home
      store%position(p, :) = position
      store%velocity(p, :) = bodies(body)%velocity
      store%state%volume(p) = volume
      store%state%mass(p) = bodies(body)%density*volume
   end subroutine add_particle

   !> Number of a cell in its tile, from 0.
   pure integer function cell_number(grid, cell) result(home)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell(3)                  !! In the tile, counted from 0

      home = cell(1) + grid%width(1)*(cell(2) + grid%width(2)*cell(3))
   end function cell_number

   !> Random displacement of a particle from the middle of its site, in edges of the site, up to a
   !! quarter to either side. It depends on the identity alone.
   pure function random_shift(identity) result(shift)
      integer(int64), intent(in) :: identity          !! Identity of the particle
      real(wp) :: shift(3)
      integer(int64), parameter :: seed = 12345_int64
      integer :: k

      do k = 1, 3
         shift(k) = 0.5_wp*random_uniform(seed, identity, int(k, int64)) - 0.25_wp
      end do
   end function random_shift

   !> Set the initial size and velocity gradient of a particle, as far as the store has them. Along
   !! a missing direction its size is 0.
   pure subroutine set_size(half, p, store)
      real(wp), intent(in) :: half(3)                 !! Half its edges [m]
      integer, intent(in) :: p
      type(store_t), intent(inout) :: store
      integer :: k

      if (allocated(store%extent)) store%extent(p, :) = half
      if (allocated(store%domain)) then
         store%domain(p, :) = 0.0_wp
         do k = 1, 3
            store%domain(p, 4*k - 3) = half(k)
         end do
      end if
      if (allocated(store%affine)) store%affine(p, :) = 0.0_wp
      if (allocated(store%origin%marks)) store%origin%marks(p, :) = 0.0_wp
      if (allocated(store%spin)) store%spin(p, :) = 0.0_wp
      if (allocated(store%ahead)) store%ahead(p, :) = 0.0_wp
      if (allocated(store%bond)) store%bond(p) = 1.0_wp
   end subroutine set_size

   !> Volume of a lattice site [m3]; in axisymmetry, of the ring.
   pure real(wp) function site_volume(grid, body, position) result(volume)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      real(wp), intent(in) :: position(3)             !! [m]
      integer :: direction

      volume = grid%depth
      if (grid%axisymmetric) volume = 2.0_wp*pi*position(1)
      do direction = 1, 3
         if (grid%active(direction)) &
            volume = volume*grid%spacing/real(body%per_cell(direction), wp)
      end do
   end function site_volume
end module particle_fill
