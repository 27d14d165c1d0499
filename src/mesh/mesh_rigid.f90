! SPDX-License-Identifier: BSD-3-Clause
!> Rigid regions: bodies without particles that set the velocity of the nodes inside of them.
module mesh_rigid
   use base_kinds, only: int64, wp
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use mesh_surface_normal, only: find_surface_normal, touches
   use mesh_wall, only: node_place, wall_t
   implicit none
   private

   public :: held_t, press_t, rigid_t

   !> Nodes of a tile that rigid regions constrain.
   type :: held_t
      integer :: coordinate(3) = -1                  !! The tile for which they were found
      logical :: moves = .false.                     !! Does a moving region overlap the tile?
      integer, allocatable :: node(:)                !! Nodes of the tile
      integer, allocatable :: wall(:)                !! The region of each
      real(wp), allocatable :: normal(:, :)          !! (3, held) Out of it, 0 = the node sticks [1]
      real(wp), allocatable :: place(:, :)           !! (3, held) Positions of the nodes [m]
   end type held_t

   !> How a region presses a node that may slide along it.
   type :: press_t
      logical :: pressed = .false.                   !! Is it pressed?
      logical :: sticks = .false.                    !! Does friction stop it?
      real(wp) :: gain = 0.0_wp                      !! Velocity gained along the normal [m/s]
      real(wp) :: along(3) = 0.0_wp                  !! Relative to the region, frictionless [m/s]
      real(wp) :: friction = 0.0_wp                  !! Coefficient [1]
   end type press_t

   !> All rigid regions of a scene.
   type :: rigid_t
      type(wall_t), allocatable :: wall(:)           !! The regions; later ones take precedence
      type(held_t), allocatable :: held(:)           !! (tile) The nodes in them
      logical :: switched = .true. !! Has one started or stopped since nodes were found?
      real(wp) :: kick = 0.0_wp                      !! Time that forces act in this step [s]
      integer(int64) :: looked = -1                  !! Step for which the nodes were found
   contains
      procedure :: add => rigid_add                  !! Add a region
      procedure :: advance => rigid_advance          !! Bring the regions to a time
      procedure :: hold => rigid_find_nodes          !! Find the nodes of a tile in them
      procedure :: holds => rigid_has_nodes          !! Is a node of a tile in one of them?
      procedure :: constrain => rigid_constrain      !! Impose velocities on these nodes
      procedure :: constrain_node => rigid_constrain_node !! One of them
      procedure :: keep => rigid_impose_normal       !! Hold nodes that were held in the step
      procedure :: rub => rigid_apply_friction       !! Friction of regions
      procedure :: press => rigid_press              !! Press a node on its region
      procedure :: responds => rigid_responds        !! Do forces move a region?
      procedure :: has_bodies => rigid_has_bodies    !! Does a region turn, or do forces move one?
      procedure :: meets_body => rigid_meets_body    !! Is a node of a tile in such a region?
   end type rigid_t

contains

   !> Add a region.
   subroutine rigid_add(self, wall)
      class(rigid_t), intent(inout) :: self
      type(wall_t), intent(in) :: wall
      type(wall_t), allocatable :: longer(:)
      integer :: n

      allocate (longer(size(self%wall) + 1))
      do n = 1, size(self%wall)
         longer(n) = self%wall(n)
      end do
      longer(size(longer)) = wall
      call move_alloc(longer, self%wall)
   end subroutine rigid_add

   !> Bring the regions to a time.
   pure subroutine rigid_advance(self, time, lag, kick)
      class(rigid_t), intent(inout) :: self
      real(wp), intent(in) :: time                   !! Time of the positions [s]
      real(wp), intent(in) :: lag                    !! Lag of velocities behind positions [s]
      real(wp), intent(in) :: kick                   !! Time that forces act, 0 = none [s]
      logical :: acted
      integer :: n

      self%kick = kick
      do n = 1, size(self%wall)
         acted = self%wall(n)%acts
         call self%wall(n)%advance(time, lag, kick)
         self%switched = self%switched .or. (acted .neqv. self%wall(n)%acts)
      end do
   end subroutine rigid_advance

   !> Find the nodes of a tile in the regions, unless they are known and cannot have changed.
   pure subroutine rigid_find_nodes(self, grid, boundary, coordinate, held)
      class(rigid_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary       !! Boundaries of the domain
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      type(held_t), intent(inout) :: held            !! In: previous nodes
      real(wp), parameter :: near = 4.0_wp           ! maximum search distance [cells]
      real(wp) :: low(3), high(3)
      logical :: moves, meets
      integer :: n

      low = grid%tile_corner(coordinate) - real(near + grid%margin, wp)*grid%spacing
      high = low + real(grid%width + 2*grid%margin, wp)*grid%spacing + 2.0_wp*near*grid%spacing
      where (.not. grid%active)
         low = -huge(low)
         high = huge(high)
      end where
      moves = .false.
      meets = .false.
      do n = 1, size(self%wall)
         if (.not. self%wall(n)%meets(low, high)) cycle
         meets = .true.
         moves = moves .or. self%wall(n)%moves()
      end do
      if (all(held%coordinate == coordinate) .and. .not. (self%switched .or. moves &
         .or. held%moves)) return
      held%coordinate = coordinate
      held%moves = moves
      if (allocated(held%node)) deallocate (held%node, held%wall, held%normal, held%place)
      if (meets) call find_nodes(self, grid, boundary, coordinate, held)
   end subroutine rigid_find_nodes

   !> Nodes of a tile in the regions, and the directions out.
   pure subroutine find_nodes(self, grid, boundary, coordinate, held)
      class(rigid_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary       !! Boundaries of the domain
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      type(held_t), intent(inout) :: held            !! Receives them
      integer :: owner(grid%tile_nodes), node, count

      do node = 1, grid%tile_nodes
         owner(node) = owner_of(self, grid, node_place(grid, coordinate, node))
      end do
      count = sum(merge(1, 0, owner > 0))
      if (count == 0) return
      allocate (held%node(count), held%wall(count), held%normal(3, count), held%place(3, count))
      held%node = pack([(node, node=1, grid%tile_nodes)], owner > 0)
      held%wall = owner(held%node)
      held%normal = 0.0_wp
      do node = 1, count
         held%place(:, node) = node_place(grid, coordinate, held%node(node))
         if (self%wall(held%wall(node))%condition%slides()) call find_normal(self, grid, boundary, &
            coordinate, held%node(node), held%place(:, node), held%normal(:, node))
      end do
   end subroutine find_nodes

   !> The last region that contains a node, 0 = none.
   pure integer function owner_of(self, grid, place) result(owner)
      class(rigid_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: place(3)               !! [m]

      do owner = size(self%wall), 1, -1
         if (touches(self%wall(owner), grid, place)) return
      end do
      owner = 0
   end function owner_of

   !> Direction out of the regions at a node. On a closed boundary it is parallel to the boundary:
   !! both conditions apply there.
   pure subroutine find_normal(self, grid, boundary, coordinate, node, place, normal)
      class(rigid_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary       !! Boundaries of the domain
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: node                    !! Node of the tile
      real(wp), intent(in) :: place(3)               !! Position of the node [m]
      real(wp), intent(out) :: normal(3)             !! Unit normal, or 0 if the node sticks [1]
      real(wp), parameter :: least = 1.0e-3_wp       ! a boundary and a region side by side
      integer :: k, wall, face, global(3)
      logical :: found, on_face(3), sticks

      on_face = .false.
      sticks = .false.
      global = coordinate*grid%width + grid%node_position(node)
      do k = 1, 3
         if (.not. grid%active(k)) cycle
         face = 0
         if (global(k) == 0) face = 2*k - 1
         if (global(k) == grid%cells(k)) face = 2*k
         if (face == 0) cycle
         wall = boundary%wall_at(face, place)
         if (wall == 0) cycle
         on_face(k) = boundary%wall(wall)%condition%is_closed()
         sticks = sticks .or. (on_face(k) .and. .not. boundary%wall(wall)%condition%slides())
      end do
      normal = 0.0_wp
      if (sticks) return
      call find_surface_normal(self%wall, grid, place, on_face, normal, found)
      if (.not. found) normal = 0.0_wp
      where (on_face) normal = 0.0_wp
      if (norm2(normal) > least) then
         normal = normal/norm2(normal)
      else
         normal = 0.0_wp
      end if
   end subroutine find_normal

   !> True if a node of the tile is inside a region.
   pure logical function rigid_has_nodes(self, tile) result(holds)
      class(rigid_t), intent(in) :: self
      integer, intent(in) :: tile                    !! Index of the tile

      holds = allocated(self%held(tile)%node)
   end function rigid_has_nodes

   !> True if forces move some region.
   pure logical function rigid_responds(self) result(responds)
      class(rigid_t), intent(in) :: self
      integer :: n

      responds = .false.
      do n = 1, size(self%wall)
         if (allocated(self%wall(n)%body)) responds = responds .or. self%wall(n)%body%responds()
      end do
   end function rigid_responds

   !> True if some region turns, or forces move it.
   pure logical function rigid_has_bodies(self) result(has)
      class(rigid_t), intent(in) :: self
      integer :: n

      has = .false.
      do n = 1, size(self%wall)
         has = has .or. allocated(self%wall(n)%body)
      end do
   end function rigid_has_bodies

   !> True if a node of the tile is inside such a region.
   pure logical function rigid_meets_body(self, tile) result(meets)
      class(rigid_t), intent(in) :: self
      integer, intent(in) :: tile                    !! Index of the tile
      integer :: n

      meets = .false.
      if (.not. self%holds(tile)) return
      associate (owner => self%held(tile)%wall)
         do n = 1, size(owner)
            meets = allocated(self%wall(owner(n))%body)
            if (meets) return
         end do
      end associate
   end function rigid_meets_body

   !> Set the velocity of the nodes in sticking regions, and stop motion into others. Equation (R.1)
   !! of doc/theory/rigid.md.
   pure subroutine rigid_constrain(self, tile, velocity, acceleration, at_end)
      class(rigid_t), intent(in) :: self
      integer, intent(in) :: tile                    !! Index of the tile
      real(wp), contiguous, intent(inout) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      logical, intent(in) :: at_end                  !! Velocities are those after the step
      integer :: n

      if (.not. self%holds(tile)) return
      associate (held => self%held(tile))
         do n = 1, size(held%node)
            call self%constrain_node(held, n, at_end, velocity(:, held%node(n)), &
               acceleration(:, held%node(n)))
         end do
      end associate
   end subroutine rigid_constrain

   !> One node.
   pure subroutine rigid_constrain_node(self, held, n, at_end, velocity, acceleration)
      class(rigid_t), intent(in) :: self
      type(held_t), intent(in) :: held               !! Nodes of a tile
      integer, intent(in) :: n                       !! Which of them
      logical, intent(in) :: at_end                  !! Is the velocity that after the step?
      real(wp), intent(inout) :: velocity(3)         !! [m/s]
      real(wp), intent(inout) :: acceleration(3)     !! [m/s2]
      real(wp) :: wall_velocity(3), pull(3), into

      associate (wall => self%wall(held%wall(n)), normal => held%normal(:, n))
         pull = wall%acceleration_at(held%place(:, n), self%kick)
         wall_velocity = wall%velocity_at(held%place(:, n))
         if (at_end) wall_velocity = wall_velocity + self%kick*pull
         if (maxval(abs(normal)) > 0.0_wp) then
            into = dot_product(velocity - wall_velocity, normal)
            if (into < 0.0_wp) velocity = velocity - into*normal
         else
            velocity = wall_velocity
            acceleration = merge(0.0_wp, pull, at_end)
         end if
      end associate
   end subroutine rigid_constrain_node

   !> Friction of regions after Coulomb, as of boundaries: see boundary_friction. The velocities are
   !! those relative to the region. Equations (R.2) and (R.3).
   pure subroutine rigid_apply_friction(self, tile, dt, share, free, velocity, acceleration)
      class(rigid_t), intent(in) :: self
      integer, intent(in) :: tile                    !! Index of the tile
      real(wp), intent(in) :: dt                     !! Time step, above 0 [s]
      real(wp), intent(in) :: share                  !! Share of PIC in the transfer, 0 to 1
      real(wp), contiguous, intent(in) :: free(:, :) !! (3, node) Velocity without walls [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Velocity after walls [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      type(press_t) :: press
      integer :: n, node

      if (.not. self%holds(tile)) return
      associate (held => self%held(tile))
         do n = 1, size(held%node)
            node = held%node(n)
            call self%press(held, n, dt, share, free(:, node), velocity(:, node), &
               acceleration(:, node), press)
         end do
      end associate
   end subroutine rigid_apply_friction

   !> Press a node on its region, unless it sticks anyway, or moves away.
   pure subroutine rigid_press(self, held, n, dt, share, free, velocity, acceleration, press)
      class(rigid_t), intent(in) :: self
      type(held_t), intent(in) :: held               !! Nodes of a tile
      integer, intent(in) :: n                       !! Which of them
      real(wp), intent(in) :: dt                     !! Time step, above 0 [s]
      real(wp), intent(in) :: share                  !! Share of PIC in the transfer, 0 to 1
      real(wp), intent(in) :: free(3)                !! Velocity without walls [m/s]
      real(wp), intent(inout) :: velocity(3)         !! Velocity after walls [m/s]
      real(wp), intent(inout) :: acceleration(3)     !! [m/s2]
      type(press_t), intent(out) :: press            !! How it was pressed
      real(wp) :: wall_velocity(3), pull(3), along(3), change(3), seen(3), taken, speed

      associate (wall => self%wall(held%wall(n)), normal => held%normal(:, n))
         if (.not. maxval(abs(normal)) > 0.0_wp) return
         wall_velocity = wall%velocity_at(held%place(:, n))
         pull = wall%acceleration_at(held%place(:, n), self%kick)
         seen = free - wall_velocity
         change = dt*(acceleration - pull)
         taken = -dot_product(change + share*seen, normal)
         if (.not. taken > 0.0_wp) return
         if (dot_product(seen + change, normal) > 0.0_wp) return
         velocity = velocity - dot_product(velocity - wall_velocity, normal)*normal
         acceleration = acceleration - dot_product(change, normal)/dt*normal
         along = velocity + dt*acceleration - wall_velocity - dt*pull
         press%pressed = .true.
         press%gain = taken
         press%along = along
         press%friction = wall%condition%friction
         taken = press%friction*taken
         speed = norm2(along)
         press%sticks = press%friction > 0.0_wp .and. .not. taken < speed
         if (taken < speed) then
            taken = taken/speed
         else
            taken = 1.0_wp
         end if
         if (press%friction > 0.0_wp) acceleration = acceleration - taken/dt*along
      end associate
   end subroutine rigid_press

   !> Set the normal velocity of nodes that regions constrained in the step to that of the region,
   !! unless the node separates.
   pure subroutine rigid_impose_normal(self, tile, ended, velocity)
      class(rigid_t), intent(in) :: self
      integer, intent(in) :: tile                    !! Index of the tile
      real(wp), contiguous, intent(in) :: ended(:, :) !! (3, node) Velocity after the step [m/s]
      real(wp), contiguous, intent(inout) :: velocity(:, :) !! (3, node) Changed [m/s]
      real(wp) :: wall_velocity(3)
      integer :: n, node

      if (.not. self%holds(tile)) return
      associate (held => self%held(tile))
         do n = 1, size(held%node)
            node = held%node(n)
            associate (wall => self%wall(held%wall(n)), normal => held%normal(:, n))
               if (.not. maxval(abs(normal)) > 0.0_wp) cycle
               wall_velocity = wall%velocity_at(held%place(:, n)) &
                  + self%kick*wall%acceleration_at(held%place(:, n), self%kick)
               if (.not. stays(wall_velocity, normal, ended(:, node))) cycle
               velocity(:, node) = velocity(:, node) &
                  - dot_product(velocity(:, node) - wall_velocity, normal)*normal
            end associate
         end do
      end associate
   end subroutine rigid_impose_normal

   !> True if a node does not move out of a region.
   pure logical function stays(wall, normal, velocity) result(held)
      real(wp), intent(in) :: wall(3)                !! Velocity of the region [m/s]
      real(wp), intent(in) :: normal(3)              !! Outward
      real(wp), intent(in) :: velocity(3)            !! Velocity of the node [m/s]
      real(wp), parameter :: little = 1.0e-12_wp     ! remainder of a removed velocity

      held = .not. dot_product(velocity - wall, normal) > little*(norm2(velocity) + norm2(wall))
   end function stays
end module mesh_rigid
