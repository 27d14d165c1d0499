! SPDX-License-Identifier: BSD-3-Clause
!> Ranges of the particles of each tile in the arrays of a store.
!!
!! The particles of a tile are contiguous, followed by spare capacity. A tile that outgrows its
!! range gets a new one at the end of the arrays; when these are full, all ranges are laid out
!! again.
module particle_tile_ranges
   implicit none
   private

   public :: tile_ranges_t

   !> Where the particles of each tile are, and which of them changed cell or tile.
   type :: tile_ranges_t
      integer, allocatable :: home(:)                 !! Cell after the move, < 0 = left the tile
      integer, allocatable :: first(:)                !! (tile) First particle of the range
      integer, allocatable :: count(:)                !! (tile) Particles in the range
      integer, allocatable :: capacity(:)             !! (tile) Particles that the range can hold
      logical, allocatable :: unsorted(:)             !! (tile) Has a particle changed its cell?
      integer, allocatable :: leaving(:)              !! (tile) Particles that left it
      !> (0:cells, tile) Particles of the range before each cell; cell c of the tile, counted from
      !! 0, holds particles first + start(c) to first + start(c + 1) - 1.
      integer, allocatable :: cell_start(:, :)
      integer :: used = 0                             !! End of the last range
   contains
      procedure :: clear => ranges_clear              !! Remove all tiles
      procedure :: particles => ranges_particles      !! Number of particles on this rank
      procedure :: remap => ranges_remap              !! Renumber the tiles
      procedure :: plan_ranges => ranges_plan         !! Plan ranges for new counts
      procedure :: is_packed => ranges_is_packed      !! Is there no spare capacity?
      procedure :: pack_ranges => ranges_pack         !! Plan ranges without spare capacity
      procedure :: extend => ranges_extend            !! Move ranges that are too short to the end
      procedure :: fit_into => ranges_fit_into        !! Do new counts fit into the arrays?
   end type tile_ranges_t

contains

   !> Remove all tiles.
   pure subroutine ranges_clear(self, cells)
      class(tile_ranges_t), intent(inout) :: self
      integer, intent(in) :: cells                    !! Cells of a tile

      if (allocated(self%first)) deallocate (self%first, self%count, self%capacity, &
         self%unsorted, self%leaving, self%cell_start)
      allocate (self%first(0), self%count(0), self%capacity(0), self%unsorted(0), self%leaving(0))
      allocate (self%cell_start(0:cells, 0))
      self%used = 0
   end subroutine ranges_clear

   !> Number of particles on this rank.
   pure integer function ranges_particles(self) result(particles)
      class(tile_ranges_t), intent(in) :: self

      particles = 0
      if (allocated(self%count)) particles = sum(self%count)
   end function ranges_particles

   !> Renumber the tiles. The particles are not moved.
   subroutine ranges_remap(self, old, cells)
      class(tile_ranges_t), intent(inout) :: self
      integer, intent(in) :: old(:)                   !! (tile) Old index, 0 = new tile
      integer, intent(in) :: cells                    !! Cells of a tile
      integer, allocatable :: first(:), count(:), capacity(:), leaving(:), cell_start(:, :)
      logical, allocatable :: unsorted(:)
      integer :: tile

      allocate (first(size(old)), count(size(old)), capacity(size(old)), unsorted(size(old)))
      allocate (leaving(size(old)))
      allocate (cell_start(0:cells, size(old)))
      do tile = 1, size(old)
         if (old(tile) > 0) then
            first(tile) = self%first(old(tile))
            count(tile) = self%count(old(tile))
            capacity(tile) = self%capacity(old(tile))
            unsorted(tile) = self%unsorted(old(tile))
            leaving(tile) = self%leaving(old(tile))
            cell_start(:, tile) = self%cell_start(:, old(tile))
         else
            first(tile) = self%used + 1
            count(tile) = 0
            capacity(tile) = 0
            unsorted(tile) = .true.
            leaving(tile) = 0
            cell_start(:, tile) = 0
         end if
      end do
      call move_alloc(first, self%first)
      call move_alloc(count, self%count)
      call move_alloc(capacity, self%capacity)
      call move_alloc(unsorted, self%unsorted)
      call move_alloc(leaving, self%leaving)
      call move_alloc(cell_start, self%cell_start)
   end subroutine ranges_remap

   !> Capacity of a range for a number of particles: 1/32 more.
   elemental integer function with_spare(number) result(capacity)
      integer, intent(in) :: number                   !! Particles

      capacity = number + number/32
   end function with_spare

   !> Give the tiles consecutive ranges for new counts and return the array length that these need.
   !! No particle is moved.
   subroutine ranges_plan(self, new_count, first, length)
      class(tile_ranges_t), intent(inout) :: self
      integer, intent(in) :: new_count(:)             !! (tile)
      integer, allocatable, intent(out) :: first(:)   !! (tile) First particle of the new range
      integer, intent(out) :: length                  !! Length of the arrays
      integer :: tile

      allocate (first(size(new_count)))
      self%used = 0
      do tile = 1, size(new_count)
         first(tile) = self%used + 1
         self%capacity(tile) = with_spare(new_count(tile))
         self%used = self%used + self%capacity(tile)
      end do
      length = self%used + self%used/32 + 64
   end subroutine ranges_plan

   !> True if the particles fill the arrays from the beginning without gaps.
   pure logical function ranges_is_packed(self) result(packed)
      class(tile_ranges_t), intent(in) :: self

      packed = self%used == self%particles()
   end function ranges_is_packed

   !> Give the tiles consecutive ranges without spare capacity. No particle is moved.
   pure subroutine ranges_pack(self, first)
      class(tile_ranges_t), intent(inout) :: self
      integer, allocatable, intent(out) :: first(:)   !! (tile) First particle of the new range
      integer :: tile

      allocate (first(size(self%count)))
      self%used = 0
      do tile = 1, size(self%count)
         first(tile) = self%used + 1
         self%capacity(tile) = self%count(tile)
         self%used = self%used + self%count(tile)
      end do
   end subroutine ranges_pack

   !> Give tiles whose new count exceeds their capacity a new range at the end.
   pure subroutine ranges_extend(self, new_count)
      class(tile_ranges_t), intent(inout) :: self
      integer, intent(in) :: new_count(:)             !! (tile)
      integer :: tile

      do tile = 1, size(new_count)
         if (new_count(tile) <= self%capacity(tile)) cycle
         self%first(tile) = self%used + 1
         self%capacity(tile) = with_spare(new_count(tile))
         self%used = self%used + self%capacity(tile)
      end do
   end subroutine ranges_extend

   !> True if `extend` fits into arrays of a given length.
   pure logical function ranges_fit_into(self, length, new_count) result(fits)
      class(tile_ranges_t), intent(in) :: self
      integer, intent(in) :: length                   !! Length of the arrays
      integer, intent(in) :: new_count(:)             !! (tile)
      integer :: tile, used

      used = self%used
      do tile = 1, size(new_count)
         if (new_count(tile) > self%capacity(tile)) used = used + with_spare(new_count(tile))
      end do
      fits = used <= length
   end function ranges_fit_into
end module particle_tile_ranges
