! SPDX-License-Identifier: BSD-3-Clause
!> A wall: a boundary of the domain, a part of one, or a rigid region.
module mesh_wall
   use base_kinds, only: wp
   use mesh_boundary_condition, only: boundary_condition_t
   use mesh_grid, only: grid_t
   use mesh_motion, only: motion_t
   use mesh_point_set, only: point_set_t
   use mesh_rigid_body, only: rigid_body_t
   implicit none
   private

   public :: node_place, wall_t

   !> A boundary condition with its region, its motion, and the time interval in which it acts.
   type :: wall_t
      character(len=64) :: name = ""                 !! Name of its region, for pictures
      integer :: face = 0                            !! Boundary of the domain, 0 = a rigid region
      class(boundary_condition_t), allocatable :: condition !! Condition; open without one
      class(point_set_t), allocatable :: region      !! Region of the wall, if not everywhere
      type(motion_t) :: motion                       !! Motion, and time interval of action
      logical :: acts = .true.                       !! Does it act now?
      logical :: stays = .false. !! Is the region fixed although it has a velocity?
      real(wp) :: shift(3) = 0.0_wp                  !! Displacement of the region so far [m]
      type(rigid_body_t), allocatable :: body        !! If the region turns, or forces move it
   contains
      procedure :: advance => wall_advance           !! Set position and velocity at a time
      procedure :: displacement => wall_displacement !! Displacement of a region since its start
      procedure :: moves => wall_moves               !! Does the region move at some time?
      procedure :: velocity_at => wall_velocity_at   !! Velocity at a position, before the forces
      procedure :: acceleration_at => wall_acceleration_at !! Its change in the step over the time
      procedure :: covers => wall_covers             !! Does it hold at a position now?
      procedure :: meets => wall_meets               !! Do its bounds overlap a box?
   end type wall_t

contains

   !> Set position and velocity of the wall at a time.
   pure subroutine wall_advance(self, time, lag, kick)
      class(wall_t), intent(inout) :: self
      real(wp), intent(in) :: time                   !! Time of the positions [s]
      real(wp), intent(in) :: lag                    !! Lag of velocities behind positions [s]
      real(wp), intent(in) :: kick                   !! Time that forces act, 0 = none [s]

      self%acts = self%motion%acts(time)
      ! a part of a boundary does not change its position
      if (self%face == 0) self%shift = self%displacement(time)
      associate (condition => self%condition)
         condition%velocity = self%motion%velocity(time - lag)
         condition%acceleration = 0.0_wp
         if (kick > 0.0_wp) condition%acceleration = (self%motion%velocity(time - lag + kick) &
            - condition%velocity)/kick
         if (.not. allocated(self%body)) return
         ! forces give the free directions their velocities; the others follow the motion
         where (.not. self%body%free)
            self%body%velocity = condition%velocity
            self%body%velocity_end = condition%velocity + kick*condition%acceleration
         end where
         condition%velocity = self%body%velocity
         condition%acceleration = 0.0_wp
         if (kick > 0.0_wp) condition%acceleration = (self%body%velocity_end &
            - self%body%velocity)/kick
      end associate
   end subroutine wall_advance

   !> Whether the region moves at some time.
   pure logical function wall_moves(self) result(moves)
      class(wall_t), intent(in) :: self

      moves = self%motion%moves() .or. allocated(self%body)
   end function wall_moves

   !> Velocity of the wall at a position, at the time of the node velocities [m/s].
   pure function wall_velocity_at(self, x) result(velocity)
      class(wall_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! [m]
      real(wp) :: velocity(3)

      if (allocated(self%body)) then
         velocity = self%body%velocity_at(x)
      else
         velocity = self%condition%velocity
      end if
   end function wall_velocity_at

   !> Acceleration of the wall at a position, over the time that forces act [m/s2].
   pure function wall_acceleration_at(self, x, kick) result(acceleration)
      class(wall_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! [m]
      real(wp), intent(in) :: kick                   !! Time that forces act, 0 = none [s]
      real(wp) :: acceleration(3)

      acceleration = self%condition%acceleration
      if (allocated(self%body) .and. kick > 0.0_wp) acceleration = self%body%gain_at(x)/kick
   end function wall_acceleration_at

   !> Displacement of a region at a time [m].
   pure function wall_displacement(self, time) result(shift)
      class(wall_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]
      real(wp) :: shift(3)

      shift = 0.0_wp
      if (.not. self%stays) shift = self%motion%shift(time)
   end function wall_displacement

   !> Whether the wall acts now and holds at a position.
   pure logical function wall_covers(self, x) result(covers)
      class(wall_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! [m]

      covers = self%acts
      if (.not. (covers .and. allocated(self%region))) return
      if (allocated(self%body)) then
         covers = self%region%contains(self%body%own_place(x))
      else
         covers = self%region%contains(x - self%shift)
      end if
   end function wall_covers

   !> Whether the bounds of the wall overlap a box.
   pure logical function wall_meets(self, low, high) result(meets)
      class(wall_t), intent(in) :: self
      real(wp), intent(in) :: low(3)                 !! Lower corner [m]
      real(wp), intent(in) :: high(3)                !! Upper corner [m]
      real(wp) :: own_low(3), own_high(3)

      meets = self%acts
      if (.not. meets .or. .not. allocated(self%region)) return
      if (allocated(self%body)) then
         ! whatever its rotation
         associate (body => self%body)
            if (body%radius < huge(body%radius)) meets = all(body%centre - body%radius <= high &
               .and. body%centre + body%radius >= low)
         end associate
         return
      end if
      call self%region%bounds(own_low, own_high)
      meets = all(own_low + self%shift <= high .and. own_high + self%shift >= low)
   end function wall_meets

   !> Position of a node, the same bits in every tile that has it [m]. Along inactive directions it
   !! is that of the particles.
   pure function node_place(grid, coordinate, node) result(place)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: node                    !! Node of the tile, counted from 1
      real(wp) :: place(3)

      place = grid%lower + grid%spacing*real(coordinate*grid%width + grid%node_position(node), wp)
      where (.not. grid%active) place = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), &
         grid%axisymmetric)
   end function node_place
end module mesh_wall
