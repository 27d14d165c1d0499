! SPDX-License-Identifier: BSD-3-Clause
!> The particles of one material on one rank, as a structure of arrays.
!!
!! Each tile has a range of the arrays (particle_tile_ranges). In a range the particles are sorted
!! by cell and within a cell by identity, so no sum depends on the order in which they arrived.
module particle_store
   use base_field_worker, only: field_reader_t, field_worker_t
   use base_kinds, only: int64, wp
   use material_state, only: material_state_t
   use particle_tile_ranges, only: tile_ranges_t
   implicit none
   private

   public :: store_t, traits_t

   integer, parameter, public :: moved_away = -1      !! Home of a particle that left its tile
   integer, parameter, public :: moved_out = -2       !! Home of a particle that left the box
   integer, parameter, public :: moved_off = -3       !! Home of a removed particle

   !> Half strain of particles from a snapshot without the field `ahead` [1]
   real(wp), parameter, public :: unknown_strain = 1.0e20_wp

   !> Fields that the method or the scene requests of all particles.
   type :: traits_t
      logical :: body = .false.                       !! Body of each particle
      logical :: arrives = .false.                    !! Walls that it has reached
      logical :: extent = .false.                     !! Half the edges of its box
      logical :: stretching = .false.                 !! These follow the stretch of the material
      logical :: domain = .false.                     !! Half the edges of its parallelepiped
      logical :: splits = .false.                     !! Are long particles halved?
      logical :: affine = .false.                     !! Linear velocity field around it
      logical :: spin = .false.                       !! Rotation of the velocity around it
      logical :: averaged = .false.                   !! Half of a strain, applied in advance
   end type traits_t

   !> What particles keep from the start.
   type :: origin_t
      real(wp), allocatable :: reference(:, :) !! (particle, 3) Initial position, on request [m]
      !> (particle, 4 loads) Function f and its gradient of the loads that follow the material, see
      !! mesh_surface_load [1, 1/m]
      real(wp), allocatable :: marks(:, :)
   end type origin_t

   !> Particles of one material.
   type, extends(tile_ranges_t) :: store_t
      character(len=:), allocatable :: name           !! Name of the material
      integer :: material = 1                         !! Number of the &material in the deck
      integer(int64), allocatable :: identity(:)      !! Unique in the run, given at the start
      integer(int64), allocatable :: body(:)          !! Index of the body, on request
      real(wp), allocatable :: position(:, :)         !! (particle, 3) [m]
      real(wp), allocatable :: velocity(:, :)         !! (particle, 3) [m/s]
      logical :: stretching = .false.                 !! Do boxes follow the stretch?
      real(wp), allocatable :: extent(:, :)           !! (particle, 3) Half edges of its box [m]
      !> (particle, 9) Half edges of its parallelepiped, edge k in columns 3 k - 2 to 3 k [m]
      real(wp), allocatable :: domain(:, :)
      !> (particle, 9) Velocity gradient (k, l) around it in column k + 3 (l - 1) [1/s]
      real(wp), allocatable :: affine(:, :)
      real(wp), allocatable :: spin(:, :)             !! (particle, 3) Rotation around it [1/s]
      !> (particle, 9) Half of the strain of the last step, applied before the move [1]
      real(wp), allocatable :: ahead(:, :)
      logical :: wets = .false.                       !! Does it stay on walls that it reaches?
      !> 4096 times the steps done when it was last next to a boundary that it has reached, and bit
      !! n - 1 for boundary n, bit n + 5 if it began there
      integer(int64), allocatable :: touched(:)
      real(wp), allocatable :: bond(:)                !! 1 = bonds to other bodies hold, 0 = broken
      type(origin_t) :: origin                        !! What is known of the start
      !> Rate at which the longest edge grows, from the strain of a step to its end only, else of
      !! size 0; not allocated if long particles are not halved [1/s]
      real(wp), allocatable :: opening(:)
      type(material_state_t) :: state                 !! State of the constitutive laws
   contains
      procedure :: start => store_start               !! Make an empty store
      procedure :: mark_all_leaving => store_mark_all_leaving !! All particles have left their tiles
      procedure :: walk => store_walk                 !! Pass each allocated field to a worker
      procedure :: show => store_show                 !! Pass each allocated field to a reader
      procedure :: words => store_words               !! Words of 8 bytes of a particle
      procedure :: bytes => store_bytes               !! Bytes of a particle
      procedure :: layout => store_layout             !! Give each tile a new range
      procedure :: pack => store_pack                 !! Leave no spare capacity between tiles
      procedure :: fits => store_fits                 !! Do new counts fit into the arrays?
      procedure :: reserve => store_reserve           !! Make new counts fit
   end type store_t

   !> Counts the words of one particle.
   type, extends(field_reader_t) :: counter_t
      integer :: words = 0                            !! Words of 8 bytes
   contains
      procedure :: reals => counter_reals             !! One word per component
      procedure :: integers => counter_integers       !! One word
   end type counter_t

   !> Moves ranges of particles into new arrays.
   type, extends(field_worker_t) :: mover_t
      integer, allocatable :: from(:)                 !! (tile) Old first particle
      integer, allocatable :: to(:)                   !! (tile) New first particle
      integer, allocatable :: count(:)                !! (tile) Particles
      integer :: size = 0                             !! New size of the arrays
   contains
      procedure :: scalar => mover_scalar             !! Moves a scalar field
      procedure :: vector => mover_vector             !! Moves a vector or tensor field
      procedure :: whole => mover_whole               !! Moves an integer field
   end type mover_t

contains

   !> Make an empty store without tiles. The fields of the material must be allocated.
   subroutine store_start(self, name, cells, traits)
      class(store_t), intent(inout) :: self
      character(len=*), intent(in) :: name            !! Name of the material
      integer, intent(in) :: cells                    !! Cells of a tile
      type(traits_t), intent(in) :: traits            !! Fields other than those of the material

      self%name = name
      allocate (self%identity(0), self%position(0, 3), self%velocity(0, 3), self%home(0))
      if (traits%body) allocate (self%body(0))
      if (traits%arrives) allocate (self%touched(0))
      if (traits%extent) allocate (self%extent(0, 3))
      self%stretching = traits%extent .and. traits%stretching
      if (traits%splits) allocate (self%opening(0))
      if (traits%domain) allocate (self%domain(0, 9))
      if (traits%affine) allocate (self%affine(0, 9))
      if (traits%spin) allocate (self%spin(0, 3))
      if (traits%averaged) allocate (self%ahead(0, 9))
      call self%clear(cells)
   end subroutine store_start

   !> Mark all particles as having left their tiles, because those just read are in one range.
   pure subroutine store_mark_all_leaving(self, cells)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: cells                    !! Cells of a tile

      if (allocated(self%home)) deallocate (self%home)
      if (allocated(self%leaving)) deallocate (self%leaving, self%unsorted)
      if (allocated(self%cell_start)) deallocate (self%cell_start)
      allocate (self%home(size(self%identity)), self%leaving(size(self%count)))
      allocate (self%unsorted(size(self%count)), self%cell_start(0:cells, size(self%count)))
      self%home = moved_away
      self%leaving = self%count
      self%unsorted = .true.
      self%cell_start = 0
   end subroutine store_mark_all_leaving

   !> Pass every allocated field to a worker, always in the same order.
   subroutine store_walk(self, worker)
      class(store_t), intent(inout) :: self
      class(field_worker_t), intent(inout) :: worker  !! Worker that visits each field

      call worker%whole("identity", "1", self%identity)
      if (allocated(self%body)) call worker%whole("body", "1", self%body)
      if (allocated(self%touched)) call worker%whole("touched", "1", self%touched)
      call worker%vector("position", "m", self%position)
      call worker%vector("velocity", "m/s", self%velocity)
      if (allocated(self%extent)) call worker%vector("extent", "m", self%extent)
      if (allocated(self%domain)) call worker%vector("domain", "m", self%domain)
      if (allocated(self%affine)) call worker%vector("affine", "1/s", self%affine)
      if (allocated(self%spin)) call worker%vector("spin", "1/s", self%spin)
      if (allocated(self%ahead)) call worker%vector("ahead", "1", self%ahead)
      if (allocated(self%bond)) call worker%scalar("bond", "1", self%bond)
      if (allocated(self%origin%reference)) call worker%vector("reference", "m", &
         self%origin%reference)
      if (allocated(self%origin%marks)) call worker%vector("load_marks", "1", self%origin%marks)
      call self%state%walk(worker)
   end subroutine store_walk

   !> Pass every allocated field to a reader, in the same order.
   subroutine store_show(self, reader)
      class(store_t), target, intent(in) :: self
      class(field_reader_t), intent(inout) :: reader  !! Reader that visits each field
      class(store_t), pointer :: fields

      ! the list of fields is that of `walk`; a reader gets each of them with intent(in)
      fields => self
      call fields%walk(reader)
   end subroutine store_show

   !> Words of 8 bytes that a particle has.
   integer function store_words(self) result(words)
      class(store_t), intent(in) :: self
      type(counter_t) :: counter

      call self%show(counter)
      words = counter%words
   end function store_words

   !> Bytes of a particle: all fields, and the index of its cell.
   integer function store_bytes(self) result(bytes)
      class(store_t), intent(in) :: self

      bytes = 8*self%words() + storage_size(self%home)/8
   end function store_bytes

   !> Give each tile a range with spare capacity for a new count, and move its particles there.
   subroutine store_layout(self, new_count)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: new_count(:)             !! (tile)
      type(mover_t) :: mover
      integer, allocatable :: home(:)
      integer :: tile

      mover%from = self%first
      mover%count = self%count
      call self%plan_ranges(max(new_count, self%count), mover%to, mover%size)
      call self%walk(mover)
      allocate (home(mover%size))
      home = 0
      do tile = 1, size(new_count)
         home(mover%to(tile):mover%to(tile) + self%count(tile) - 1) = &
            self%home(self%first(tile):self%first(tile) + self%count(tile) - 1)
      end do
      call move_alloc(home, self%home)
      self%first = mover%to
   end subroutine store_layout

   !> Move the particles to the beginning of the arrays, so that external readers get one contiguous
   !! array. Tiles that grow then get ranges at the end; no result depends on it.
   subroutine store_pack(self)
      class(store_t), intent(inout) :: self
      type(mover_t) :: mover
      integer, allocatable :: home(:)
      integer :: tile, n

      if (self%is_packed()) return
      mover%from = self%first
      mover%count = self%count
      mover%size = size(self%identity)
      call self%pack_ranges(mover%to)
      call self%walk(mover)
      allocate (home(mover%size))
      home = 0
      do tile = 1, size(self%count)
         n = self%count(tile)
         home(mover%to(tile):mover%to(tile) + n - 1) = &
            self%home(self%first(tile):self%first(tile) + n - 1)
      end do
      call move_alloc(home, self%home)
      self%first = mover%to
   end subroutine store_pack

   !> True if each tile can have its new count without longer arrays.
   pure logical function store_fits(self, new_count) result(fits)
      class(store_t), intent(in) :: self
      integer, intent(in) :: new_count(:)             !! (tile)

      fits = self%fit_into(size(self%identity), new_count)
   end function store_fits

   !> Make the new count of each tile fit. Ranges may change before their particles are moved:
   !! `now` holds their current indices.
   subroutine store_reserve(self, new_count, now)
      class(store_t), intent(inout) :: self
      integer, intent(in) :: new_count(:)             !! (tile)
      integer, intent(out) :: now(:)                  !! (tile) Present first particle

      if (.not. self%fits(new_count)) call self%layout(new_count)
      now = self%first
      call self%extend(new_count)
   end subroutine store_reserve

   subroutine counter_reals(self, name, unit, is_scalar, values)
      class(counter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)

      self%words = self%words + size(values, 2)
   end subroutine counter_reals

   subroutine counter_integers(self, name, unit, values)
      class(counter_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)

      self%words = self%words + 1
   end subroutine counter_integers

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
