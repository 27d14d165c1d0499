! SPDX-License-Identifier: BSD-3-Clause
!> Action of the six boundaries of the domain on the nodes of a tile. The types are in
!! boundary_<type>; this module has the loops over boundaries, their parts and their nodes.
module mesh_boundary
   use base_kinds, only: wp
   use mesh_boundary_condition, only: inward_sign, normal_direction
   use mesh_boundary_nodes, only: boundary_nodes, has_boundary_nodes
   use mesh_boundary_walls, only: boundary_walls_t
   use mesh_grid, only: grid_t
   use mesh_wall, only: node_place
   implicit none
   private

   public :: boundary_t

   !> The conditions on the boundaries.
   type, extends(boundary_walls_t) :: boundary_t
      logical :: warm(6) = .false.                   !! (face) Has it a given temperature?
      real(wp) :: temperature(6) = 0.0_wp            !! (face) That temperature [K]
      !> (node, tile) Bit n - 1 = material has reached boundary n there, bit n + 5 = some is held by
      !! it; not allocated if no material approaches a boundary: then all has reached them
      integer, allocatable :: reached(:, :)
   contains
      procedure :: touches => boundary_touches       !! Does a tile have nodes on such a boundary?

      procedure :: add_forces => boundary_add_forces !! Forces of boundaries on nodes
      procedure :: constrain => boundary_constrain   !! Impose velocities on nodes
      procedure :: separates => boundary_separates   !! May material separate from some boundary?
      procedure :: press => boundary_press           !! Hold nodes that are pressed on boundaries
      procedure :: hold_pressed => boundary_hold_pressed !! Hold nodes that were pressed on them
      procedure :: mirror => boundary_mirror         !! Impose mirror symmetry on node tensors
      procedure :: insulate => boundary_insulate     !! No flux through boundaries
      procedure :: held_at => boundary_held_at       !! Prescribed temperatures of nodes
      procedure :: raise => boundary_raise !! Multiply values of nodes on closed boundaries
      procedure :: see_gaps => boundary_see_gaps     !! Gaps between material and closed boundaries
   end type boundary_t

   !> Nodes of a wall on which it acts: all, those that it holds, those that may separate from it.
   integer, parameter :: all_nodes = 0, held_nodes = 1, free_nodes = 2

contains

   !> True if a node of the tile is on a boundary that changes node velocities.
   pure logical function boundary_touches(self, grid, coordinate) result(touches)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer :: face

      touches = .false.
      do face = 1, 6
         if (.not. self%acts_on(face)) cycle
         touches = touches .or. has_boundary_nodes(grid, coordinate, face)
      end do
   end function boundary_touches

   !> Forces of boundaries on the nodes of a tile, as accelerations.
   pure subroutine boundary_add_forces(self, grid, coordinate, dt, velocity, acceleration, only)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer, intent(in), optional :: only          !! Wall that acts; default: all
      integer :: nodes(grid%tile_nodes), number, n

      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         if (present(only)) then
            if (n /= only) cycle
         end if
         if (.not. self%wall(n)%condition%absorbs_waves()) cycle
         call wall_nodes(self, grid, coordinate, 0, n, all_nodes, nodes, number)
         if (number > 0) call self%wall(n)%condition%add_forces(grid, coordinate, &
            self%wall(n)%face, nodes(:number), dt, velocity, acceleration)
      end do
   end subroutine boundary_add_forces

   !> Set the velocity of the nodes on boundaries and remove their acceleration, except those of the
   !! boundaries themselves.
   pure subroutine boundary_constrain(self, grid, coordinate, tile, velocity, acceleration, &
      at_end, only)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: tile                    !! Its index
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      logical, intent(in), optional :: at_end        !! Velocities are those after the step
      integer, intent(in), optional :: only          !! Wall that acts; default: all
      real(wp) :: lead
      integer :: nodes(grid%tile_nodes), number, n

      if (.not. allocated(self%wall)) return
      lead = 0.0_wp
      if (present(at_end)) lead = merge(self%kick, 0.0_wp, at_end)
      do n = 1, size(self%wall)
         if (present(only)) then
            if (n /= only) cycle
         end if
         if (.not. self%wall(n)%condition%acts_on_nodes()) cycle
         call wall_nodes(self, grid, coordinate, tile, n, held_nodes, nodes, number)
         if (number > 0) call self%wall(n)%condition%constrain(self%wall(n)%face, &
            nodes(:number), lead, velocity, acceleration)
         call wall_nodes(self, grid, coordinate, tile, n, free_nodes, nodes, number)
         if (number > 0) call self%wall(n)%condition%keep_out(self%wall(n)%face, &
            nodes(:number), velocity)
      end do
   end subroutine boundary_constrain

   !> True if material may separate from some boundary now.
   pure logical function boundary_separates(self) result(separates)
      class(boundary_t), intent(in) :: self
      integer :: n

      separates = .false.
      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         associate (condition => self%wall(n)%condition)
            separates = separates .or. (condition%waits() .and. &
               (allocated(self%reached) .or. .not. condition%keeps()))
         end associate
      end do
   end function boundary_separates

   !> Hold the nodes of a tile that forces press on boundaries from which they may separate.
   pure subroutine boundary_press(self, grid, coordinate, tile, dt, pic, free, velocity, &
      acceleration, only)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: tile                    !! Its index
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: pic                    !! Fraction of PIC in the transfer, 0 to 1
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) With the others [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      integer, intent(in), optional :: only          !! Wall that acts; default: all
      integer :: nodes(grid%tile_nodes), number, n

      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         if (present(only)) then
            if (n /= only) cycle
         end if
         if (.not. self%wall(n)%condition%waits()) cycle
         call wall_nodes(self, grid, coordinate, tile, n, free_nodes, nodes, number)
         if (number > 0) call self%wall(n)%condition%press(self%wall(n)%face, &
            nodes(:number), dt, pic, free, velocity, acceleration)
      end do
   end subroutine boundary_press

   !> Remove the normal velocity of nodes that were pressed on boundaries in the step, unless they
   !! separate.
   pure subroutine boundary_hold_pressed(self, grid, coordinate, tile, ended, velocity)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: tile                    !! Its index
      real(wp), contiguous, intent(in) :: ended(:, :) !! (3, node) Velocity after the step [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Changed [m/s]
      integer :: nodes(grid%tile_nodes), number, n

      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         if (.not. self%wall(n)%condition%waits()) cycle
         call wall_nodes(self, grid, coordinate, tile, n, free_nodes, nodes, number)
         if (number > 0) call self%wall(n)%condition%hold_pressed(self%wall(n)%face, &
            nodes(:number), ended, velocity)
      end do
   end subroutine boundary_hold_pressed

   !> On mirror planes the shear components of node tensors vanish, because they are odd.
   pure subroutine boundary_mirror(self, grid, coordinate, tensor)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      !> (9, node) Component (k, l) in row k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: tensor(:, :)
      integer :: nodes(grid%tile_nodes), number, n, wall, normal, other

      if (.not. allocated(self%wall)) return
      do wall = 1, size(self%wall)
         if (.not. self%wall(wall)%condition%mirrors()) cycle
         call wall_nodes(self, grid, coordinate, 0, wall, all_nodes, nodes, number)
         normal = normal_direction(self%wall(wall)%face)
         do other = 1, 3
            if (other == normal) cycle
            do n = 1, number
               tensor(normal + 3*(other - 1), nodes(n)) = 0.0_wp
               tensor(other + 3*(normal - 1), nodes(n)) = 0.0_wp
            end do
         end do
      end do
   end subroutine boundary_mirror

   !> No flux through boundaries: its component along the normal vanishes, except where the boundary
   !! is periodic or has a given temperature.
   pure subroutine boundary_insulate(self, grid, coordinate, tensor)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      !> (9, node) Flux along direction l in row 1 + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: tensor(:, :)
      integer :: nodes(grid%tile_nodes), number, n, face, row

      do face = 1, 6
         if (self%is_periodic(face) .or. self%warm(face)) cycle
         call boundary_nodes(grid, coordinate, face, nodes, number)
         row = 1 + 3*(normal_direction(face) - 1)
         do n = 1, number
            tensor(row, nodes(n)) = 0.0_wp
         end do
      end do
   end subroutine boundary_insulate

   !> Temperatures of the nodes of a tile on boundaries that have a given one; on edges that of the
   !! later boundary.
   pure subroutine boundary_held_at(self, grid, coordinate, held)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(out) :: held(:)               !! (node) Below 0 where none is given [K]
      integer :: nodes(grid%tile_nodes), number, n, face

      held = -1.0_wp
      do face = 1, 6
         if (.not. self%warm(face)) cycle
         call boundary_nodes(grid, coordinate, face, nodes, number)
         do n = 1, number
            held(nodes(n)) = self%temperature(face)
         end do
      end do
   end subroutine boundary_held_at

   !> Multiply values of the nodes on closed boundaries, once for each boundary of a node.
   pure subroutine boundary_raise(self, grid, coordinate, factor, values)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(in) :: factor                 !! Factor of a boundary
      real(wp), intent(inout) :: values(:)           !! (node)
      integer :: nodes(grid%tile_nodes), number, n, wall

      if (.not. allocated(self%wall)) return
      do wall = 1, size(self%wall)
         if (.not. self%wall(wall)%condition%is_closed()) cycle
         call wall_nodes(self, grid, coordinate, 0, wall, all_nodes, nodes, number)
         do n = 1, number
            values(nodes(n)) = factor*values(nodes(n))
         end do
      end do
   end subroutine boundary_raise

   !> Fill minus 1 of nodes on closed boundaries, where it is less than the fill of the next node
   !! inwards. Such a difference is a gap between the boundary and the material that presses on it,
   !! not a free surface of the material.
   pure subroutine boundary_see_gaps(self, grid, coordinate, tile, noise, filled, around, excess)
      class(boundary_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: tile                    !! Its index
      real(wp), intent(in) :: noise                  !! Fills that differ less from 1 count as 1 [1]
      real(wp), contiguous, intent(in) :: filled(:, :)    !! (1, node) Volume of particles [m3]
      real(wp), intent(in) :: around(:)              !! (node) Volume of the node [m3]
      real(wp), contiguous, intent(inout) :: excess(:, :) !! (1, node) Fill minus 1 [1]
      real(wp) :: fill
      integer :: nodes(grid%tile_nodes), number, n, wall, node, inner

      if (.not. allocated(self%wall)) return
      do wall = 1, size(self%wall)
         if (.not. self%wall(wall)%condition%is_closed()) cycle
         call wall_nodes(self, grid, coordinate, tile, wall, all_nodes, nodes, number)
         associate (face => self%wall(wall)%face)
            do n = 1, number
               node = nodes(n)
               inner = node + nint(inward_sign(face))*grid%stride(normal_direction(face))
               if (.not. min(around(node), around(inner)) > 0.0_wp) cycle
               fill = filled(1, node)/around(node)
               if (fill < filled(1, inner)/around(inner)) &
                  excess(1, node) = max(0.0_wp, fill - 1.0_wp - noise) &
                  + min(0.0_wp, fill - 1.0_wp + noise)
            end do
         end associate
      end do
   end subroutine boundary_see_gaps

   !> The nodes of a tile, its margin included, on which a wall acts now: all that material has
   !! reached, those that the wall holds because material began there, or those that may separate
   !! from it. Equation (R.13) of doc/theory/rigid.md.
   pure subroutine wall_nodes(boundary, grid, coordinate, tile, wall, which, nodes, number)
      type(boundary_t), intent(in) :: boundary
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: tile                    !! Its index; 0: also nodes not yet reached
      integer, intent(in) :: wall                    !! Index of the wall
      integer, intent(in) :: which                   !! all_nodes, held_nodes or free_nodes
      integer, intent(out) :: nodes(:)               !! The nodes; capacity for a tile
      integer, intent(out) :: number                 !! How many, 0 = none
      integer :: n, all
      logical :: seen, divided, keeps, began

      number = 0
      if (.not. boundary%wall(wall)%acts) return
      keeps = boundary%wall(wall)%condition%keeps()
      seen = tile > 0 .and. allocated(boundary%reached)
      if (seen) seen = boundary%waits_at(grid, wall)
      if (which == held_nodes .and. .not. keeps) return
      if (which == free_nodes .and. keeps .and. .not. seen) return
      associate (face => boundary%wall(wall)%face)
         call boundary_nodes(grid, coordinate, face, nodes, all)
         divided = boundary%is_divided(face)
         do n = 1, all
            if (seen) then
               if (.not. btest(boundary%reached(nodes(n), tile), face - 1)) cycle
               began = keeps .and. btest(boundary%reached(nodes(n), tile), face + 5)
               if (which /= all_nodes .and. (began .neqv. which == held_nodes)) cycle
            end if
            if (divided) then
               if (boundary%wall_at(face, node_place(grid, coordinate, nodes(n))) /= wall) cycle
            end if
            number = number + 1
            nodes(number) = nodes(n)
         end do
      end associate
   end subroutine wall_nodes
end module mesh_boundary
