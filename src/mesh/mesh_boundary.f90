! SPDX-License-Identifier: BSD-3-Clause
!> What holds on the six faces of the box.
module mesh_boundary
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_wall, only: face_absorbing, face_friction, face_outflow, face_periodic, face_slip, &
      face_stick, face_symmetry, face_velocity, node_place, rule_t, wall_t
   implicit none
   private

   public :: boundary_t, face_absorbing, face_friction, face_names, face_nodes, face_outflow, &
      face_periodic, face_slip, face_stick, face_symmetry, face_types, face_velocity, lets_out

   !> Names of the faces, two a direction, the lower first.
   character(len=3), parameter :: face_names(6) = ["xlo", "xhi", "ylo", "yhi", "zlo", "zhi"]
   !> Names of the types in the order of their numbers.
   character(len=9), parameter :: face_types(8) = [character(len=9) :: "outflow", "symmetry", &
      "slip", "stick", "periodic", "velocity", "friction", "absorbing"]

   !> The conditions on the faces.
   type :: boundary_t
      integer :: kind(6) = face_outflow              !! (face) One of the types above
      real(wp) :: velocity(3, 6) = 0.0_wp            !! (component, face) Of a moving face [m/s]
      real(wp) :: friction(6) = 0.0_wp               !! (face) Coefficient of friction [1]
      real(wp) :: gain(3, 6) = 0.0_wp                !! Acceleration of a moving face [m/s2]
      real(wp) :: kick = 0.0_wp                      !! Time for which it lasts [s]
      logical :: warm(6) = .false.                   !! (face) Is it held at a temperature?
      real(wp) :: temperature(6) = 0.0_wp            !! (face) Which one [K]
      logical :: divided(6) = .false.                !! (face) Has it parts of other types?
      !> Parts of faces, the later ones winning, and whole faces that move by a table or come and go
      type(wall_t), allocatable :: wall(:)
   contains
      procedure :: advance => boundary_advance       !! Bring moving walls to a time
      procedure :: kind_at => boundary_kind_at       !! What holds at a place of a face
      procedure :: whole => boundary_whole           !! What holds on a face without parts
      procedure :: rule_at => boundary_rule_at       !! What holds at a node of a face
      procedure :: ruled => boundary_ruled           !! Does a face rule velocities?
      procedure :: rubs => boundary_rubs             !! Is there friction on some face?
      procedure :: constrain => boundary_constrain   !! Impose velocities on nodes
      procedure :: keep => boundary_keep             !! Hold nodes that were held in the step
      procedure :: rub => boundary_rub               !! Walls with friction
      procedure :: mirror => boundary_mirror         !! Impose mirror symmetry on node tensors
      procedure :: insulate => boundary_insulate     !! No flux through the faces
      procedure :: held_at => boundary_held_at       !! Temperatures that faces give their nodes
      procedure :: touches => boundary_touches       !! Does a tile have nodes on a ruled face?
      procedure :: raise => boundary_raise           !! Multiply what nodes on closed faces have
      procedure :: see_gaps => boundary_see_gaps     !! Matter that thins out towards a closed face
   end type boundary_t

contains

   !> Bring walls that move, or come and go, to a time. A face without its wall is open.
   pure subroutine boundary_advance(self, time, lag, kick, switched)
      class(boundary_t), intent(inout) :: self       !! The conditions
      real(wp), intent(in) :: time                   !! Of the positions [s]
      real(wp), intent(in) :: lag                    !! By which velocities are behind them [s]
      real(wp), intent(in) :: kick                   !! Time that forces act, 0 = none [s]
      logical, intent(out) :: switched               !! Has one come or gone?
      logical :: acted
      integer :: n

      self%kick = kick
      switched = .false.
      do n = 1, size(self%wall)
         acted = self%wall(n)%acts
         call self%wall(n)%advance(time, lag, kick)
         associate (wall => self%wall(n))
            switched = switched .or. (acted .neqv. wall%acts)
            if (allocated(wall%region)) cycle
            self%kind(wall%face) = merge(wall%kind, face_outflow, wall%acts)
            self%velocity(:, wall%face) = wall%velocity
            self%gain(:, wall%face) = wall%gain
         end associate
      end do
   end subroutine boundary_advance

   !> What holds on a face where it has no parts.
   pure type(rule_t) function boundary_whole(self, face) result(rule)
      class(boundary_t), intent(in) :: self          !! The conditions
      integer, intent(in) :: face                    !! 1 to 6

      rule%kind = self%kind(face)
      rule%friction = self%friction(face)
      rule%velocity = self%velocity(:, face)
      rule%gain = self%gain(:, face)
   end function boundary_whole

   !> What holds at a node of a face with parts.
   pure type(rule_t) function boundary_rule_at(self, grid, coordinate, face, node) result(rule)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      integer, intent(in) :: node                    !! Node of the tile on that face
      integer :: n

      rule = self%whole(face)
      if (.not. self%divided(face)) return
      n = part_at(self, face, node_place(grid, coordinate, node))
      if (n > 0) rule = self%wall(n)%rule_t
   end function boundary_rule_at

   !> Type that holds at a place on a face.
   pure integer function boundary_kind_at(self, face, place) result(kind)
      class(boundary_t), intent(in) :: self          !! The conditions
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: place(3)               !! On the face [m]
      integer :: n

      kind = self%kind(face)
      if (.not. self%divided(face)) return
      n = part_at(self, face, place)
      if (n > 0) kind = self%wall(n)%kind
   end function boundary_kind_at

   !> Number of the last part of a face that covers a place, 0 = none.
   pure integer function part_at(boundary, face, place) result(part)
      class(boundary_t), intent(in) :: boundary      !! The conditions
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: place(3)               !! On the face [m]

      do part = size(boundary%wall), 1, -1
         associate (wall => boundary%wall(part))
            if (wall%face /= face .or. .not. allocated(wall%region)) cycle
            if (wall%covers(place)) return
         end associate
      end do
      part = 0
   end function part_at

   !> Whether particles leave through a face of a type.
   elemental logical function lets_out(kind) result(open)
      integer, intent(in) :: kind                    !! One of the types above

      open = kind == face_outflow .or. kind == face_absorbing
   end function lets_out

   !> Whether a face, or a part of it, rules velocities.
   elemental logical function boundary_ruled(self, face) result(ruled)
      class(boundary_t), intent(in) :: self          !! The conditions
      integer, intent(in) :: face                    !! 1 to 6

      ruled = self%divided(face) .or. &
         .not. (self%kind(face) == face_outflow .or. self%kind(face) == face_periodic)
   end function boundary_ruled

   !> Whether there is friction on some face.
   pure logical function boundary_rubs(self) result(rubs)
      class(boundary_t), intent(in) :: self          !! The conditions

      rubs = any(self%kind == face_friction) .or. any(self%divided)
   end function boundary_rubs

   !> True if some node of the tile lies on a face that rules velocities.
   pure logical function boundary_touches(self, grid, coordinate) result(touches)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer :: face, node, length(3)
      logical :: here

      touches = .false.
      do face = 1, 6
         if (.not. self%ruled(face)) cycle
         call face_box(grid, coordinate, face, here, node, length)
         touches = touches .or. here
      end do
   end function boundary_touches

   !> Set the velocity of the nodes on ruled faces and take away their acceleration, but for that
   !! of the faces themselves.
   pure subroutine boundary_constrain(self, grid, coordinate, velocity, acceleration, at_end)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      logical, intent(in), optional :: at_end        !! Velocities are those after the step
      type(rule_t) :: rule
      real(wp) :: lead
      integer :: nodes(grid%tile_nodes), number, n, face, node, normal

      lead = 0.0_wp
      if (present(at_end)) lead = merge(self%kick, 0.0_wp, at_end)
      do face = 1, 6
         if (.not. self%ruled(face)) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         normal = (face + 1)/2
         do n = 1, number
            node = nodes(n)
            rule = self%rule_at(grid, coordinate, face, node)
            select case (rule%kind)
            case (face_symmetry, face_slip)
               velocity(normal, node) = 0.0_wp
               acceleration(normal, node) = 0.0_wp
            case (face_friction)
               velocity(normal, node) = merge(max(velocity(normal, node), 0.0_wp), &
                  min(velocity(normal, node), 0.0_wp), mod(face, 2) == 1)
            case (face_velocity)
               velocity(:, node) = rule%velocity + lead*rule%gain
               acceleration(:, node) = merge(0.0_wp, rule%gain, lead > 0.0_wp)
            case (face_outflow, face_absorbing)
               cycle
            case default
               velocity(:, node) = 0.0_wp
               acceleration(:, node) = 0.0_wp
            end select
         end do
      end do
   end subroutine boundary_constrain

   !> Multiply values of the nodes on closed faces, once for each face that a node lies on.
   pure subroutine boundary_raise(self, grid, coordinate, factor, values)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(in) :: factor                 !! Of a face
      real(wp), intent(inout) :: values(:)           !! (node)
      type(rule_t) :: rule
      integer :: nodes(grid%tile_nodes), number, n, face

      do face = 1, 6
         if (.not. self%ruled(face)) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         do n = 1, number
            rule = self%rule_at(grid, coordinate, face, nodes(n))
            if (lets_out(rule%kind) .or. rule%kind == face_periodic) cycle
            values(nodes(n)) = factor*values(nodes(n))
         end do
      end do
   end subroutine boundary_raise

   !> Fill less 1 of nodes on closed faces, where it is less than that of the next node inwards:
   !! a gap between the face and matter that bears on it, not a surface of the matter.
   pure subroutine boundary_see_gaps(self, grid, coordinate, noise, filled, around, excess)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(in) :: noise                  !! Fills so near to 1 count as 1 [1]
      real(wp), contiguous, intent(in) :: filled(:, :)    !! (1, node) Volume of particles [m3]
      real(wp), intent(in) :: around(:)              !! (node) Volume of the node [m3]
      real(wp), contiguous, intent(inout) :: excess(:, :) !! (1, node) Fill less 1 [1]
      type(rule_t) :: rule
      real(wp) :: fill
      integer :: nodes(grid%tile_nodes), number, n, face, node, inner, normal

      do face = 1, 6
         if (.not. self%ruled(face)) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         normal = (face + 1)/2
         do n = 1, number
            node = nodes(n)
            rule = self%rule_at(grid, coordinate, face, node)
            if (lets_out(rule%kind)) cycle
            inner = node + merge(1, -1, mod(face, 2) == 1)*grid%stride(normal)
            if (.not. min(around(node), around(inner)) > 0.0_wp) cycle
            fill = filled(1, node)/around(node)
            if (fill < filled(1, inner)/around(inner)) &
               excess(1, node) = max(0.0_wp, fill - 1.0_wp - noise) &
               + min(0.0_wp, fill - 1.0_wp + noise)
         end do
      end do
   end subroutine boundary_see_gaps

   !> Walls with friction after Coulomb. Where the forces of a step press a node on such a wall, the
   !! wall takes its normal velocity and acceleration, and from its velocity along the wall at the
   !! end of the step up to mu times what it took, but no more than all of it: then the node sticks.
   !! A wall does not pull: a node that moves away is free. Equation (M.24) of doc/theory/method.md.
   pure subroutine boundary_rub(self, grid, coordinate, dt, share, free, velocity, acceleration)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(in) :: share                  !! Of PIC in the transfer, 0 to 1
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) With the others [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      type(rule_t) :: rule
      real(wp) :: along(3), side, taken, speed
      integer :: nodes(grid%tile_nodes), number, n, face, node, normal

      do face = 1, 6
         if (.not. (self%kind(face) == face_friction .or. self%divided(face))) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         normal = (face + 1)/2
         side = merge(1.0_wp, -1.0_wp, mod(face, 2) == 1)
         do n = 1, number
            node = nodes(n)
            rule = self%rule_at(grid, coordinate, face, node)
            if (rule%kind /= face_friction) cycle
            ! what particles gain through the node in velocity if the wall holds it
            taken = -side*(dt*acceleration(normal, node) + share*free(normal, node))
            if (.not. taken > 0.0_wp) cycle
            if (side*(free(normal, node) + dt*acceleration(normal, node)) > 0.0_wp) cycle
            velocity(normal, node) = 0.0_wp
            acceleration(normal, node) = 0.0_wp
            along = velocity(:, node) + dt*acceleration(:, node)
            if (.not. dt > 0.0_wp) cycle
            taken = rule%friction*taken
            speed = norm2(along)
            if (taken < speed) then
               taken = taken/speed
            else
               taken = 1.0_wp
            end if
            acceleration(:, node) = acceleration(:, node) - taken/dt*along
         end do
      end do
   end subroutine boundary_rub

   !> Take the normal velocity of nodes that walls with friction held in the step: those that did
   !! not leave.
   pure subroutine boundary_keep(self, grid, coordinate, ended, velocity)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), contiguous, intent(in) :: ended(:, :) !! (3, node) Velocity after the step [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Changed [m/s]
      type(rule_t) :: rule
      integer :: nodes(grid%tile_nodes), number, n, face, node, normal
      real(wp) :: side

      do face = 1, 6
         if (.not. (self%kind(face) == face_friction .or. self%divided(face))) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         normal = (face + 1)/2
         side = merge(1.0_wp, -1.0_wp, mod(face, 2) == 1)
         do n = 1, number
            node = nodes(n)
            rule = self%rule_at(grid, coordinate, face, node)
            if (rule%kind == face_friction .and. .not. side*ended(normal, node) > 0.0_wp) &
               velocity(normal, node) = 0.0_wp
         end do
      end do
   end subroutine boundary_keep

   !> On mirror planes the shear components of node tensors vanish, because they are odd.
   pure subroutine boundary_mirror(self, grid, coordinate, tensor)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      !> (9, node) Component (k, l) in row k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: tensor(:, :)
      type(rule_t) :: rule
      integer :: nodes(grid%tile_nodes), number, n, face, node, normal, other

      do face = 1, 6
         if (self%kind(face) /= face_symmetry) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         normal = (face + 1)/2
         do n = 1, number
            node = nodes(n)
            rule = self%rule_at(grid, coordinate, face, node)
            if (rule%kind /= face_symmetry) cycle
            do other = 1, 3
               if (other == normal) cycle
               tensor(normal + 3*(other - 1), node) = 0.0_wp
               tensor(other + 3*(normal - 1), node) = 0.0_wp
            end do
         end do
      end do
   end subroutine boundary_mirror

   !> No flux through the faces: its component along the normal vanishes, unless what leaves there
   !! comes in across, or the face is held at a temperature.
   pure subroutine boundary_insulate(self, grid, coordinate, tensor)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      !> (9, node) Flux along direction l in row 1 + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: tensor(:, :)
      integer :: nodes(grid%tile_nodes), number, n, face, row

      do face = 1, 6
         if (self%kind(face) == face_periodic .or. self%warm(face)) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         row = 1 + 3*((face - 1)/2)
         do n = 1, number
            tensor(row, nodes(n)) = 0.0_wp
         end do
      end do
   end subroutine boundary_insulate

   !> Temperatures of the nodes of a tile on faces that are held at one; of later faces on edges.
   pure subroutine boundary_held_at(self, grid, coordinate, held)
      class(boundary_t), intent(in) :: self          !! The conditions
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(out) :: held(:)               !! (node) Below 0 where none is given [K]
      integer :: nodes(grid%tile_nodes), number, n, face

      held = -1.0_wp
      do face = 1, 6
         if (.not. self%warm(face)) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         do n = 1, number
            held(nodes(n)) = self%temperature(face)
         end do
      end do
   end subroutine boundary_held_at

   !> The nodes of a tile, its margin included, that lie on a face, x running fastest.
   pure subroutine face_nodes(grid, coordinate, face, nodes, number)
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      integer, intent(out) :: nodes(:)               !! As many as there are; room for a tile
      integer, intent(out) :: number                 !! How many, 0 = the tile is not on the face
      integer :: first, length(3), x, y, z
      logical :: here

      number = 0
      call face_box(grid, coordinate, face, here, first, length)
      if (.not. here) return
      do z = 0, length(3)
         do y = 0, length(2)
            do x = 0, length(1)
               number = number + 1
               nodes(number) = first + x*grid%stride(1) + y*grid%stride(2) + z*grid%stride(3)
            end do
         end do
      end do
   end subroutine face_nodes

   !> The box of nodes of a tile, its margin included, that lies on a face.
   pure subroutine face_box(grid, coordinate, face, here, first, length)
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      logical, intent(out) :: here                   !! Does the tile touch the face?
      integer, intent(out) :: first                  !! First node of the box
      integer, intent(out) :: length(3)              !! Nodes of the box along a direction, less 1
      integer :: normal, place

      normal = (face + 1)/2
      first = 1
      length = merge(grid%tile_extent(coordinate) + 2*grid%margin, 0, grid%active)
      here = grid%active(normal)
      if (.not. here) return
      place = grid%margin - coordinate(normal)*grid%width(normal)
      if (mod(face, 2) == 0) place = place + grid%cells(normal)
      here = place >= 0 .and. place <= length(normal)
      if (.not. here) return
      first = 1 + place*grid%stride(normal)
      length(normal) = 0
   end subroutine face_box
end module mesh_boundary
