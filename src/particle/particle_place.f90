! SPDX-License-Identifier: BSD-3-Clause
!> Finds the cells of particles that moved and applies the boundaries of the domain to them.
module particle_place
   use base_kinds, only: wp
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use particle_store, only: moved_away, moved_out, store_t
   implicit none
   private

   public :: find_place, place_particle, place_tile

contains

   !> Find the new cells of the particles of a tile and count those that left it.
   pure subroutine place_tile(grid, boundary, coordinate, store, tile)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      integer :: p, first, last, leaving, changed, cells(3), owner(3)
      real(wp) :: position(3)
      logical :: lost

      first = store%first(tile)
      last = first + store%count(tile) - 1
      call find_homes(grid, coordinate, first, last, store%position, store%home, leaving, changed)
      store%leaving(tile) = leaving
      store%unsorted(tile) = store%unsorted(tile) .or. changed > 0
      if (leaving == 0) return
      do p = first, last
         if (store%home(p) >= 0) cycle
         position = [store%position(p, 1), store%position(p, 2), store%position(p, 3)]
         call find_place(grid, boundary, position, owner, cells, lost)
         if (lost) then
            store%home(p) = moved_out
         else
            call wrap_position(grid, boundary, store%position, p)
            if (all(owner == coordinate)) then
               store%home(p) = cells(1) + grid%width(1)*(cells(2) + grid%width(2)*cells(3))
               store%leaving(tile) = store%leaving(tile) - 1
            end if
         end if
      end do
   end subroutine place_tile

   !> Find the cell of one particle of a tile and count the particle if it left the tile.
   pure subroutine place_particle(grid, boundary, coordinate, store, tile, p)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      integer, intent(in) :: p                       !! A particle of the tile
      integer :: cells(3), owner(3)
      logical :: lost

      call find_place(grid, boundary, [store%position(p, 1), store%position(p, 2), &
         store%position(p, 3)], owner, cells, lost)
      store%home(p) = moved_out
      if (.not. lost) then
         call wrap_position(grid, boundary, store%position, p)
         store%home(p) = cells(1) + grid%width(1)*(cells(2) + grid%width(2)*cells(3))
         if (any(owner /= coordinate)) store%home(p) = moved_away
      end if
      if (store%home(p) < 0) store%leaving(tile) = store%leaving(tile) + 1
   end subroutine place_particle

   !> Find the cells of the particles of a tile, `moved_away` outside of it; without branches, so
   !! that the loop vectorises.
   pure subroutine find_homes(grid, coordinate, first, last, position, home, leaving, changed)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      integer, intent(in) :: first                   !! First particle
      integer, intent(in) :: last                    !! Last index
      real(wp), contiguous, intent(in) :: position(:, :) !! (particle, 3) [m]
      integer, contiguous, intent(inout) :: home(:)  !! (particle) Cell before and after the move
      integer, intent(out) :: leaving                !! Particles that left the tile
      integer, intent(out) :: changed                !! Particles that changed their cell
      real(wp) :: shift(3), scale(3), limit(3), lower(3), x, y, z
      integer :: p, cell, width, layer, inside

      lower = grid%lower
      limit = real(grid%tile_extent(coordinate), wp)
      ! a missing direction has a single cell for all positions
      scale = merge(1.0_wp/grid%spacing, 0.0_wp, grid%active)
      shift = merge(real(coordinate*grid%width, wp), 0.0_wp, grid%active)
      width = grid%width(1)
      layer = grid%width(1)*grid%width(2)
      leaving = 0
      changed = 0
      !$omp simd private(x, y, z, inside, cell) reduction(+:leaving, changed)
      do p = first, last
         x = (position(p, 1) - lower(1))*scale(1) - shift(1)
         y = (position(p, 2) - lower(2))*scale(2) - shift(2)
         z = (position(p, 3) - lower(3))*scale(3) - shift(3)
         ! separate comparisons vectorise, and each of them is false for NaN
         inside = merge(1, 0, x >= 0.0_wp)*merge(1, 0, x < limit(1)) &
            *merge(1, 0, y >= 0.0_wp)*merge(1, 0, y < limit(2)) &
            *merge(1, 0, z >= 0.0_wp)*merge(1, 0, z < limit(3))
         cell = int(min(max(x, 0.0_wp), limit(1))) + width*int(min(max(y, 0.0_wp), limit(2))) &
            + layer*int(min(max(z, 0.0_wp), limit(3)))
         cell = inside*cell + (1 - inside)*moved_away
         leaving = leaving + (1 - inside)
         changed = changed + merge(0, 1, cell == home(p))
         home(p) = cell
      end do
   end subroutine find_homes

   !> Tile of a position and cell in the tile. A position outside the domain is wrapped at a
   !! periodic boundary, clipped at a closed one, and lost at an open one.
   pure subroutine find_place(grid, boundary, position, owner, cells, lost)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      real(wp), intent(in) :: position(3)            !! [m]
      integer, intent(out) :: owner(3)               !! Tile, counted from 0
      integer, intent(out) :: cells(3)               !! Cell in the tile, counted from 0
      logical, intent(out) :: lost                   !! Did it leave through an open boundary?
      real(wp) :: y, inside(1, 3)
      integer :: direction, face, cell

      lost = .false.
      owner = 0
      cells = 0
      inside(1, :) = position
      call wrap_position(grid, boundary, inside, 1)
      do direction = 1, 3
         if (.not. grid%active(direction)) cycle
         y = (inside(1, direction) - grid%lower(direction))*(1.0_wp/grid%spacing)
         face = 0
         if (.not. y >= 0.0_wp) face = 2*direction - 1
         if (y >= real(grid%cells(direction), wp)) face = 2*direction
         if (face > 0) lost = lost .or. face_is_open(grid, boundary, face, inside(1, :))
         cell = min(max(floor(min(max(y, -1.0_wp), real(grid%cells(direction), wp))), 0), &
            grid%cells(direction) - 1)
         owner(direction) = cell/grid%width(direction)
         cells(direction) = mod(cell, grid%width(direction))
      end do
   end subroutine find_place

   !> Move a position back into the domain: through a periodic boundary, or just inside a closed
   !! one, which a particle crosses by rounding only. A position that rounds to the upper boundary
   !! counts as on it, so that a particle is never beyond the cell that contains it.
   pure subroutine wrap_position(grid, boundary, position, p)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      real(wp), contiguous, intent(inout) :: position(:, :) !! (particle, 3) [m]
      integer, intent(in) :: p
      real(wp), parameter :: inside = 1.0e-9_wp      ! of a cell, far above rounding
      real(wp) :: x, length, lower, upper, here(3)
      integer :: direction

      here = [position(p, 1), position(p, 2), position(p, 3)]
      do direction = 1, 3
         if (.not. grid%active(direction)) cycle
         lower = grid%lower(direction)
         upper = grid%upper(direction)
         x = position(p, direction)
         if (grid%periodic(direction)) then
            length = upper - lower
            if (x < lower) x = x + length
            if (x >= upper) x = x - length
         else if (x <= lower) then
            if (.not. face_is_open(grid, boundary, 2*direction - 1, here)) &
               x = lower + inside*grid%spacing
         end if
         if ((x - lower)*(1.0_wp/grid%spacing) >= real(grid%cells(direction), wp)) then
            if (.not. face_is_open(grid, boundary, 2*direction, here)) &
               x = upper - inside*grid%spacing
         end if
         position(p, direction) = x
         here(direction) = x
      end do
   end subroutine wrap_position

   !> True if a boundary is open where a particle reached it.
   pure logical function face_is_open(grid, boundary, face, position) result(open)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: position(3)            !! On or beyond the boundary [m]
      real(wp) :: place(3)
      integer :: normal

      normal = (face + 1)/2
      place = position
      place(normal) = merge(grid%lower(normal), grid%upper(normal), mod(face, 2) == 1)
      open = boundary%lets_out(face, place)
   end function face_is_open
end module particle_place
