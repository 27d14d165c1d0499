! SPDX-License-Identifier: BSD-3-Clause
!> Fills bodies with particles, on a lattice that divides the cells of the grid or as given.
!!
!! The identity of a particle is the number of its site in the whole domain, offset by the body; so
!! neither identity nor position depends on ranks. Where bodies overlap, the later one has priority.
module particle_fill
   use base_constants, only: pi
   use base_kinds, only: int64, wp
   use base_random, only: random_uniform
   use mesh_grid, only: grid_t
   use particle_body, only: belongs, body_t, cell_of, find_boxes, find_near, site_position, &
      tile_sites
   use particle_store, only: store_t
   implicit none
   private

   public :: count_sites, fill_bodies, site_volume

contains

   !> Count the particles that a body has in a tile, and sum their volumes.
   pure subroutine count_sites(grid, bodies, body, later, coordinate, number, volume)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer(int64), intent(out) :: number           !! Particles
      real(wp), intent(out) :: volume                 !! [m3]
      integer :: sites(3), x, y, z
      real(wp) :: low(3), high(3), edge(3), middle(3), position(3), share

      number = 0
      volume = 0.0_wp
      if (allocated(bodies(body)%given)) then
         call count_given(grid, bodies, body, later, coordinate, number, volume)
         return
      end if
      call bodies(body)%shape%bounds(low, high)
      edge = grid%tile_corner(coordinate)
      if (any(grid%active .and. (edge > high .or. edge + grid%width*grid%spacing < low))) return
      sites = tile_sites(grid, bodies(body), coordinate)
      if (is_full(grid, bodies(body), coordinate, sites) .and. size(later) == 0) then
         number = product(int(sites, int64))
         volume = real(number, wp)*site_volume(grid, bodies(body), edge)
         return
      end if
      do z = 0, sites(3) - 1
         do y = 0, sites(2) - 1
            do x = 0, sites(1) - 1
               middle = site_position(grid, bodies(body), coordinate, [x, y, z])
               call measure_site(grid, bodies, body, later, middle, share, position)
               if (.not. share > 0.0_wp) cycle
               number = number + 1
               volume = volume + share*site_volume(grid, bodies(body), middle)
            end do
         end do
      end do
   end subroutine count_sites

   !> True if a body surely contains all its sites in a tile. Around an axis their volumes differ.
   pure logical function is_full(grid, body, coordinate, sites) result(full)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer, intent(in) :: sites(3)                 !! Sites of the tile

      full = .false.
      if (grid%axisymmetric) return
      associate (margin => merge(0.5_wp, 0.0_wp, body%cut)*site_edge(grid, body))
         full = body%shape%spans(site_position(grid, body, coordinate, [0, 0, 0]) - margin, &
            site_position(grid, body, coordinate, sites - 1) + margin)
      end associate
   end function is_full

   !> Count the given particles that a body has in a tile, and sum their volumes.
   pure subroutine count_given(grid, bodies, body, later, coordinate, particles, sum_volume)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      integer, intent(in) :: later(:)                 !! Later bodies, which replace this one
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer(int64), intent(out) :: particles
      real(wp), intent(out) :: sum_volume             !! [m3]
      real(wp), allocatable :: position(:, :), volume(:)
      integer(int64), allocatable :: number(:)
      integer :: n

      particles = 0
      sum_volume = 0.0_wp
      call bodies(body)%given%collect(grid, coordinate, position, volume, number)
      do n = 1, size(number)
         if (.not. belongs(bodies, body, position(:, n), later)) cycle
         particles = particles + 1
         sum_volume = sum_volume + bodies(body)%share*volume(n)
      end do
   end subroutine count_given

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
      real(wp) :: volume
      integer(int64) :: found
      integer :: tile, n, number

      call find_boxes(grid, bodies, low, high)
      allocate (new_count(size(store%count)))
      new_count = 0
      !$omp parallel default(none) private(tile, near, n, number, found, volume) &
      !$omp shared(grid, bodies, low, high, coordinates, index, new_count)
      allocate (near(size(bodies)))
      !$omp do schedule(dynamic, 16)
      do tile = 1, size(new_count)
         call find_near(grid, low, high, coordinates(:, tile), near, number)
         do n = 1, number
            if (bodies(near(n))%store /= index) cycle
            call count_sites(grid, bodies, near(n), near(n + 1:number), coordinates(:, tile), &
               found, volume)
            new_count(tile) = new_count(tile) + int(found)
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
                  if (allocated(store%touched) .and. share >= 1.0_wp) &
                     store%touched(store%first(tile) + store%count(tile) - 1) = &
                     boundaries_at(grid, middle, 0.5_wp*site_edge(grid, it))
               end do
            end do
         end do
      end associate
   end subroutine fill_tile

   !> Boundaries of the domain on which a site lies, boundary n as bit n - 1. Displaced particles
   !! belong to their sites.
   pure integer(int64) function boundaries_at(grid, middle, half) result(bits)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: middle(3)               !! [m]
      real(wp), intent(in) :: half(3)                 !! Half the edges of the site [m]
      real(wp), parameter :: touch = 1.0e-6_wp        !! Rounding of positions, in cells
      integer :: k

      bits = 0
      do k = 1, 3
         if (.not. grid%active(k)) cycle
         if (middle(k) - half(k) - grid%lower(k) <= touch*grid%spacing) &
            bits = ibset(bits, 2*k - 2)
         if (grid%upper(k) - middle(k) - half(k) <= touch*grid%spacing) &
            bits = ibset(bits, 2*k - 1)
      end do
   end function boundaries_at

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
      if (allocated(store%touched)) store%touched(p) = 0
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
