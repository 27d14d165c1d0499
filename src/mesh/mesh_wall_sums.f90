! SPDX-License-Identifier: BSD-3-Clause
!> Action of each wall on the material since the start: its impulse, and the work at the velocity of
!! the wall. Equation (O.2) of doc/theory/instruments.md. The rows after those of the walls are the
!! impulses of contact between the velocity fields.
module mesh_wall_sums
   use base_exact_sum, only: exact_sum_t, exact_sum_words
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: wall_push_t, wall_sums_t

   integer, parameter, public :: wall_entries = 4        !! Impulse along x, y, z [N s], work [J]
   integer, parameter, public :: body_entries = 6        !! Impulse [N s] and its moment [N m s]

   !> Sums of all walls: boundaries and their parts, then rigid regions, then pairs of velocity
   !! fields. Not allocated unless an output shows forces.
   type :: wall_sums_t
      type(exact_sum_t), allocatable :: total(:, :)  !! (entry, wall)
   contains
      procedure :: start => sums_start               !! Allocate them
      procedure :: add => sums_add                   !! Add the action of a wall in a step
      procedure :: merge => sums_merge               !! Add others
      procedure :: clear => sums_clear               !! Set to zero
      procedure :: words => sums_words               !! As integers, for a checkpoint
      procedure :: set_words => sums_set_words       !! From these
   end type wall_sums_t

   !> Velocities that each wall gives to the nodes of a tile in a step.
   type :: wall_push_t
      real(wp), allocatable :: gain(:, :, :)         !! (3, node, wall) [m/s]
      real(wp), allocatable :: velocity(:, :)        !! (3, node) As the last wall left them [m/s]
      real(wp), allocatable :: acceleration(:, :)    !! (3, node) The same [m/s2]
      real(wp) :: dt = 0.0_wp                        !! Time that forces act [s]
      real(wp) :: share = 0.0_wp                     !! Share of PIC in the transfer, 0 to 1
   contains
      procedure :: begin => push_begin               !! Before walls act
      procedure :: note => push_note                 !! A wall has acted
      procedure :: note_nodes => push_note_nodes     !! Records changes of velocity by walls
   end type wall_push_t

contains

   !> Allocate the sums, 0.
   pure subroutine sums_start(self, walls)
      class(wall_sums_t), intent(inout) :: self
      integer, intent(in) :: walls                   !! Number of walls

      if (allocated(self%total)) deallocate (self%total)
      allocate (self%total(wall_entries, walls))
   end subroutine sums_start

   !> Add force, impulse and work of a wall in a step.
   pure subroutine sums_add(self, wall, impulse, velocity)
      class(wall_sums_t), intent(inout) :: self
      integer, intent(in) :: wall                    !! Index
      real(wp), intent(in) :: impulse(3)             !! On the material [N s]
      real(wp), intent(in) :: velocity(3) !! Velocity of the wall in the middle of the step [m/s]
      integer :: k

      do k = 1, 3
         call self%total(k, wall)%add(impulse(k))
      end do
      call self%total(wall_entries, wall)%add(dot_product(impulse, velocity))
   end subroutine sums_add

   !> Add the sums of others, such as those of a thread.
   pure subroutine sums_merge(self, other)
      class(wall_sums_t), intent(inout) :: self
      class(wall_sums_t), intent(in) :: other
      integer :: n, wall

      if (.not. allocated(other%total) .or. .not. allocated(self%total)) return
      do wall = 1, size(self%total, 2)
         do n = 1, wall_entries
            call self%total(n, wall)%merge(other%total(n, wall))
         end do
      end do
   end subroutine sums_merge

   !> Set all sums to zero.
   pure subroutine sums_clear(self)
      class(wall_sums_t), intent(inout) :: self
      integer :: n, wall

      if (.not. allocated(self%total)) return
      do wall = 1, size(self%total, 2)
         do n = 1, wall_entries
            call self%total(n, wall)%clear()
         end do
      end do
   end subroutine sums_clear

   !> The sums of this rank as integers, which add up over ranks.
   pure function sums_words(self) result(words)
      class(wall_sums_t), intent(in) :: self
      integer(int64), allocatable :: words(:)
      type(exact_sum_t) :: sum
      integer :: first, n, wall

      allocate (words(exact_sum_words*size(self%total)))
      first = 1
      do wall = 1, size(self%total, 2)
         do n = 1, wall_entries
            sum = self%total(n, wall)
            call sum%save(words(first:first + exact_sum_words - 1))
            first = first + exact_sum_words
         end do
      end do
   end function sums_words

   !> Set the sums from integers; sums for a different number of walls are ignored.
   pure subroutine sums_set_words(self, words)
      class(wall_sums_t), intent(inout) :: self
      integer(int64), intent(in) :: words(:)         !! From sums_words
      integer(int64) :: one(exact_sum_words)
      integer :: first, n, wall

      if (size(words) /= exact_sum_words*size(self%total)) return
      first = 1
      do wall = 1, size(self%total, 2)
         do n = 1, wall_entries
            call self%total(n, wall)%clear()
            one = words(first:first + exact_sum_words - 1)
            call self%total(n, wall)%load(one)
            first = first + exact_sum_words
         end do
      end do
   end subroutine sums_set_words

   !> Before walls act on a tile.
   pure subroutine push_begin(self, walls, dt, share, velocity, acceleration)
      class(wall_push_t), intent(inout) :: self
      integer, intent(in) :: walls                   !! Number of walls
      real(wp), intent(in) :: dt                     !! Time that forces act [s]
      real(wp), intent(in) :: share                  !! Share of PIC in the transfer, 0 to 1
      real(wp), intent(in) :: velocity(:, :)         !! (3, node) [m/s]
      real(wp), intent(in) :: acceleration(:, :)     !! (3, node) [m/s2]

      if (allocated(self%gain)) deallocate (self%gain)
      allocate (self%gain(3, size(velocity, 2), walls), source=0.0_wp)
      self%velocity = velocity
      self%acceleration = acceleration
      self%dt = dt
      self%share = share
   end subroutine push_begin

   !> Record the action of a wall: all changes since the previous wall.
   pure subroutine push_note(self, wall, velocity, acceleration)
      class(wall_push_t), intent(inout) :: self
      integer, intent(in) :: wall                    !! Index
      real(wp), intent(in) :: velocity(:, :)         !! (3, node) [m/s]
      real(wp), intent(in) :: acceleration(:, :)     !! (3, node) [m/s2]

      self%gain(:, :, wall) = self%gain(:, :, wall) + self%dt*(acceleration - self%acceleration) &
         + self%share*(velocity - self%velocity)
      self%velocity = velocity
      self%acceleration = acceleration
   end subroutine push_note

   !> Record the changes of node velocities by walls; each wall changes separate nodes.
   pure subroutine push_note_nodes(self, before, nodes, walls, velocity, acceleration)
      class(wall_push_t), intent(inout) :: self
      integer, intent(in) :: before                  !! Walls before the first of these
      integer, intent(in) :: nodes(:)                !! Nodes of the tile
      integer, intent(in) :: walls(:)                !! The wall of each
      real(wp), intent(in) :: velocity(:, :)         !! (3, node of the tile) [m/s]
      real(wp), intent(in) :: acceleration(:, :)     !! (3, node of the tile) [m/s2]
      integer :: n

      do n = 1, size(nodes)
         associate (node => nodes(n), gain => self%gain(:, nodes(n), before + walls(n)))
            gain = gain + self%dt*(acceleration(:, node) - self%acceleration(:, node)) &
               + self%share*(velocity(:, node) - self%velocity(:, node))
         end associate
      end do
      self%velocity = velocity
      self%acceleration = acceleration
   end subroutine push_note_nodes
end module mesh_wall_sums
