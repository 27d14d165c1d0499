! SPDX-License-Identifier: BSD-3-Clause
!> The particles of one material on one rank, as a structure of arrays.
!!
!! The particles of a tile lie together in a range of the arrays with room to grow. A tile that
!! outgrows its range gets a new one at the end; when the end is reached all tiles are packed anew.
!! In a range the particles are in the order of their cells and in a cell in the order of their
!! identities, so no sum depends on how particles came there.
module particle_store
   use base_field_worker, only: field_worker_t
   use base_kinds, only: int64, wp
   use constitutive_state, only: material_state_t
   implicit none
   private

   public :: store_t, traits_t

   integer, parameter, public :: moved_away = -1      !! Home of a particle that left its tile
   integer, parameter, public :: moved_out = -2       !! Home of a particle that left the box
   integer, parameter, public :: moved_off = -3       !! Home of a particle that is taken out

   !> Fields that a method or a scene asks of all particles.
   type :: traits_t
      logical :: body = .false.                       !! Which body a particle belongs to
      logical :: extent = .false.                     !! Half the edges of its box
      logical :: stretching = .false.                 !! These follow the stretch of the material
      logical :: domain = .false.                     !! Half the edges of its parallelepiped
      logical :: affine = .false.                     !! Linear velocity field round it
      logical :: spin = .false.                       !! Rotation of the velocity round it
      logical :: averaged = .false.                   !! Half of a strain, taken ahead
   end type traits_t

   !> Particles of one material.
   type :: store_t
      character(len=:), allocatable :: name           !! Name of the material
      integer :: material = 1                         !! Number of the &material in the deck
      integer(int64), allocatable :: identity(:)      !! Unique in the run, given at the start
      integer(int64), allocatable :: body(:)          !! Index of the body (only if asked for)
      real(wp), allocatable :: position(:, :)         !! (particle, 3) [m]
      real(wp), allocatable :: velocity(:, :)         !! (particle, 3) [m/s]
      logical :: stretching = .false.                 !! Do boxes follow the stretch?
      real(wp), allocatable :: extent(:, :)           !! (particle, 3) Half edges of its box [m]
      !> (particle, 9) Half edges of its parallelepiped, edge k in columns 3 k - 2 to 3 k [m]
      real(wp), allocatable :: domain(:, :)
      !> (particle, 9) Slope (k, l) of the velocity round it in column k + 3 (l - 1) [1/s]
      real(wp), allocatable :: affine(:, :)
      real(wp), allocatable :: spin(:, :)             !! (particle, 3) Rotation round it [1/s]
      !> (particle, 9) Half of the strain of the last step, taken ahead of the move [1]
      real(wp), allocatable :: ahead(:, :)
      real(wp), allocatable :: bond(:)                !! 1 = bonds to other bodies hold, 0 = broken
      real(wp), allocatable :: reference(:, :) !! (particle, 3) Position at rest (if asked for) [m]
      !> Rate at which the longest edge grows, from the strain of a step to its end only [1/s]
      real(wp), allocatable :: opening(:)
      type(material_state_t) :: state                        !! State that the laws see
      integer, allocatable :: home(:)                 !! Cell after the move, < 0 = left the tile
      integer, allocatable :: first(:)                !! (tile) First particle of the range
      integer, allocatable :: count(:)                !! (tile) Particles in the range
      integer, allocatable :: room(:)                 !! (tile) Particles that would fit
      logical, allocatable :: restless(:)             !! (tile) Has a particle changed its cell?
      integer, allocatable :: leaving(:)              !! (tile) Particles that left it
      !> (0:cells, tile) Particles of the range before each cell; cell c of the tile, counted from
      !! 0, holds particles first + start(c) to first + start(c + 1) - 1.
      integer, allocatable :: cell_start(:, :)
      integer :: used = 0                             !! End of the last range
   contains
      procedure :: start => store_start               !! An empty store
      procedure :: clear => store_clear               !! Forget all tiles
      procedure :: unsettle => store_unsettle         !! Let all particles look for their tiles
      procedure :: walk => store_walk                 !! Shows each allocated field to a worker
      procedure :: particles => store_particles       !! Number of particles on this rank
      procedure :: words => store_words               !! Numbers that a particle carries
      procedure :: layout => store_layout             !! Give each tile a range
      procedure :: remap => store_remap               !! Renumber the tiles
      procedure :: fits => store_fits                 !! Can new counts do without new arrays?
      procedure :: line_up => store_line_up           !! Plan ranges one after another
      procedure :: reserve => store_reserve           !! Make sure that new counts fit
   end type store_t

   !> Counts the numbers of one particle.
   type, extends(field_worker_t) :: counter_t
      integer :: words = 0                            !! Numbers of 8 bytes
   contains
      procedure :: scalar => counter_scalar           !! One number
      procedure :: vector => counter_vector           !! Several numbers
      procedure :: whole => counter_whole             !! One number
   end type counter_t

   !> Moves ranges of particles to new places in new arrays.
   type, extends(field_worker_t) :: mover_t
      integer, allocatable :: from(:)                 !! (tile) Old first particle
      integer, allocatable :: to(:)                   !! (tile) New first particle
      integer, allocatable :: count(:)                !! (tile) Particles
      integer :: size = 0                             !! New size of the arrays
   contains
      procedure :: scalar => mover_scalar             !! Moves numbers
      procedure :: vector => mover_vector             !! Moves vectors
      procedure :: whole => mover_whole               !! Moves whole numbers
   end type mover_t

contains

   !> Make an empty store without tiles. The fields of the matter were asked for before.
   subroutine store_start(self, name, cells, traits)
      class(store_t), intent(inout) :: self
      character(len=*), intent(in) :: name            !! Name of the material
      integer, intent(in) :: cells                    !! Cells of a tile
      type(traits_t), intent(in) :: traits            !! What particles carry besides their matter

      self%name = name
      allocate (self%identity(0), self%position(0, 3), self%velocity(0, 3), self%home(0))
      if (traits%body) allocate (self%body(0))
      if (traits%extent) allocate (self%extent(0, 3))
      self%stretching = traits%extent .and. traits%stretching
      if (traits%domain) allocate (self%domain(0, 9))
      if (traits%affine) allocate (self%affine(0, 9))
      if (traits%spin) allocate (self%spin(0, 3))
      if (traits%averaged) allocate (self%ahead(0, 9))
      call self%clear(cells)
   end subroutine store_start

   !> Forget all tiles.
   pure subroutine store_clear(self, cells)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: cells                    !! Cells of a tile

      if (allocated(self%first)) deallocate (self%first, self%count, self%room, self%restless, &
         self%leaving, self%cell_start)
      allocate (self%first(0), self%count(0), self%room(0), self%restless(0), self%leaving(0))
      allocate (self%cell_start(0:cells, 0))
      self%used = 0
   end subroutine store_clear

   !> Particles that were just read lie in one range: let all of them look for their tiles.
   pure subroutine store_unsettle(self, cells)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: cells                    !! Cells of a tile

      if (allocated(self%home)) deallocate (self%home)
      if (allocated(self%leaving)) deallocate (self%leaving, self%restless)
      if (allocated(self%cell_start)) deallocate (self%cell_start)
      allocate (self%home(size(self%identity)), self%leaving(size(self%count)))
      allocate (self%restless(size(self%count)), self%cell_start(0:cells, size(self%count)))
      self%home = moved_away
      self%leaving = self%count
      self%restless = .true.
      self%cell_start = 0
   end subroutine store_unsettle

   !> Show every allocated field to a worker, always in the same order.
   subroutine store_walk(self, worker)
      class(store_t), intent(inout) :: self
      class(field_worker_t), intent(inout) :: worker  !! What is to be done

      call worker%whole("identity", "1", self%identity)
      if (allocated(self%body)) call worker%whole("body", "1", self%body)
      call worker%vector("position", "m", self%position)
      call worker%vector("velocity", "m/s", self%velocity)
      if (allocated(self%extent)) call worker%vector("extent", "m", self%extent)
      if (allocated(self%domain)) call worker%vector("domain", "m", self%domain)
      if (allocated(self%affine)) call worker%vector("affine", "1/s", self%affine)
      if (allocated(self%spin)) call worker%vector("spin", "1/s", self%spin)
      if (allocated(self%ahead)) call worker%vector("ahead", "1", self%ahead)
      if (allocated(self%bond)) call worker%scalar("bond", "1", self%bond)
      if (allocated(self%reference)) call worker%vector("reference", "m", self%reference)
      call self%state%walk(worker)
   end subroutine store_walk

   !> Number of particles on this rank.
   pure integer function store_particles(self) result(particles)
      class(store_t), intent(in) :: self

      particles = 0
      if (allocated(self%count)) particles = sum(self%count)
   end function store_particles

   !> Numbers of 8 bytes that a particle carries.
   integer function store_words(self) result(words)
      class(store_t), intent(inout) :: self
      type(counter_t) :: counter

      call self%walk(counter)
      words = counter%words
   end function store_words

   !> Give each tile a range for the wished count with room to grow, moving what is there.
   subroutine store_layout(self, wish)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: wish(:)                  !! (tile) Particles that must fit
      type(mover_t) :: mover
      integer, allocatable :: home(:)
      integer :: tile

      mover%from = self%first
      mover%count = self%count
      call self%line_up(max(wish, self%count), mover%to, mover%size)
      call self%walk(mover)
      allocate (home(mover%size))
      home = 0
      do tile = 1, size(wish)
         home(mover%to(tile):mover%to(tile) + self%count(tile) - 1) = &
            self%home(self%first(tile):self%first(tile) + self%count(tile) - 1)
      end do
      call move_alloc(home, self%home)
      self%first = mover%to
   end subroutine store_layout

   !> Renumber the tiles. The particles stay where they are.
   subroutine store_remap(self, old, cells)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: old(:)                   !! (tile) Former index, 0 = new
      integer, intent(in) :: cells                    !! Cells of a tile
      integer, allocatable :: first(:), count(:), room(:), leaving(:), cell_start(:, :)
      logical, allocatable :: restless(:)
      integer :: tile

      allocate (first(size(old)), count(size(old)), room(size(old)), restless(size(old)))
      allocate (leaving(size(old)))
      allocate (cell_start(0:cells, size(old)))
      do tile = 1, size(old)
         if (old(tile) > 0) then
            first(tile) = self%first(old(tile))
            count(tile) = self%count(old(tile))
            room(tile) = self%room(old(tile))
            restless(tile) = self%restless(old(tile))
            leaving(tile) = self%leaving(old(tile))
            cell_start(:, tile) = self%cell_start(:, old(tile))
         else
            first(tile) = self%used + 1
            count(tile) = 0
            room(tile) = 0
            restless(tile) = .true.
            leaving(tile) = 0
            cell_start(:, tile) = 0
         end if
      end do
      call move_alloc(first, self%first)
      call move_alloc(count, self%count)
      call move_alloc(room, self%room)
      call move_alloc(restless, self%restless)
      call move_alloc(leaving, self%leaving)
      call move_alloc(cell_start, self%cell_start)
   end subroutine store_remap

   !> Can each tile have its coming count without new arrays?
   pure logical function store_fits(self, wish) result(fits)
      class(store_t), intent(in) :: self
      integer, intent(in) :: wish(:)                  !! (tile) Coming counts
      integer :: tile, used

      used = self%used
      do tile = 1, size(wish)
         if (wish(tile) > self%room(tile)) used = used + with_room(wish(tile))
      end do
      fits = used <= size(self%identity)
   end function store_fits

   !> Places of a range for a number of particles: a thirty-second to spare.
   elemental integer function with_room(number) result(places)
      integer, intent(in) :: number                   !! Particles

      places = number + number/32
   end function with_room

   !> Give the tiles ranges one after another for coming counts, and say how long arrays must be.
   !! Nothing is moved yet.
   subroutine store_line_up(self, wish, first, length)
      class(store_t), intent(inout) :: self           !! The particles; get the new room
      integer, intent(in) :: wish(:)                  !! (tile) Coming counts
      integer, allocatable, intent(out) :: first(:)   !! (tile) First places
      integer, intent(out) :: length                  !! Of the arrays
      integer :: tile

      allocate (first(size(wish)))
      self%used = 0
      do tile = 1, size(wish)
         first(tile) = self%used + 1
         self%room(tile) = with_room(wish(tile))
         self%used = self%used + self%room(tile)
      end do
      length = self%used + self%used/32 + 64
   end subroutine store_line_up

   !> Make sure that each tile has room for its coming count; the new first particles may differ
   !! from where the particles are now, which is returned.
   subroutine store_reserve(self, wish, now)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: wish(:)                  !! (tile) Coming counts
      integer, intent(out) :: now(:)                  !! (tile) First particle as they lie now
      integer :: tile

      if (.not. self%fits(wish)) call self%layout(wish)
      now = self%first
      do tile = 1, size(wish)
         if (wish(tile) <= self%room(tile)) cycle
         self%first(tile) = self%used + 1
         self%room(tile) = with_room(wish(tile))
         self%used = self%used + self%room(tile)
      end do
   end subroutine store_reserve

   subroutine counter_scalar(self, name, unit, values)
      class(counter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:)

      self%words = self%words + 1
   end subroutine counter_scalar

   subroutine counter_vector(self, name, unit, values)
      class(counter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :)

      self%words = self%words + size(values, 2)
   end subroutine counter_vector

   subroutine counter_whole(self, name, unit, values)
      class(counter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:)

      self%words = self%words + 1
   end subroutine counter_whole

   subroutine mover_scalar(self, name, unit, values)
      class(mover_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:)
      real(wp), allocatable :: moved(:)
      integer :: tile, n

      allocate (moved(self%size))
      moved = 0.0_wp
      do tile = 1, size(self%count)
         n = self%count(tile)
         moved(self%to(tile):self%to(tile) + n - 1) = &
            values(self%from(tile):self%from(tile) + n - 1)
      end do
      call move_alloc(moved, values)
   end subroutine mover_scalar

   subroutine mover_vector(self, name, unit, values)
      class(mover_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :)
      real(wp), allocatable :: moved(:, :)
      integer :: tile, n, component

      allocate (moved(self%size, size(values, 2)))
      moved = 0.0_wp
      do component = 1, size(values, 2)
         do tile = 1, size(self%count)
            n = self%count(tile)
            moved(self%to(tile):self%to(tile) + n - 1, component) = &
               values(self%from(tile):self%from(tile) + n - 1, component)
         end do
      end do
      call move_alloc(moved, values)
   end subroutine mover_vector

   subroutine mover_whole(self, name, unit, values)
      class(mover_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:)
      integer(int64), allocatable :: moved(:)
      integer :: tile, n

      allocate (moved(self%size))
      moved = 0
      do tile = 1, size(self%count)
         n = self%count(tile)
         moved(self%to(tile):self%to(tile) + n - 1) = &
            values(self%from(tile):self%from(tile) + n - 1)
      end do
      call move_alloc(moved, values)
   end subroutine mover_whole
end module particle_store
