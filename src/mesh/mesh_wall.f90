! SPDX-License-Identifier: BSD-3-Clause
!> A wall: what holds on a face, on a part of one, or on the nodes in a rigid region.
module mesh_wall
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_motion, only: motion_t
   use mesh_point_set, only: point_set_t
   implicit none
   private

   public :: node_place, rule_t, wall_t

   integer, parameter, public :: face_outflow = 1    !! Particles leave and are booked
   integer, parameter, public :: face_symmetry = 2   !! Mirror plane
   integer, parameter, public :: face_slip = 3       !! Rigid wall without friction
   integer, parameter, public :: face_stick = 4      !! Rigid wall that holds on
   integer, parameter, public :: face_periodic = 5   !! Joined to the face across
   integer, parameter, public :: face_velocity = 6   !! Nodes move with a given velocity
   integer, parameter, public :: face_friction = 7   !! Rigid wall with friction
   integer, parameter, public :: face_absorbing = 8  !! Open, and waves leave through it

   !> What holds at a node now.
   type :: rule_t
      integer :: kind = face_outflow                 !! One of the types above
      real(wp) :: friction = 0.0_wp                  !! Coefficient of friction [1]
      real(wp) :: velocity(3) = 0.0_wp               !! At the time of the velocities [m/s]
      real(wp) :: gain(3) = 0.0_wp                   !! Its acceleration in this step [m/s2]
   end type rule_t

   !> A wall that moves, comes and goes, or covers the nodes in a region only.
   type, extends(rule_t) :: wall_t
      character(len=64) :: name = ""                 !! Of its region, for pictures
      integer :: face = 0                            !! The face on which it lies, 0 = a body
      type(motion_t) :: motion                       !! How it moves, and while it is there
      class(point_set_t), allocatable :: region      !! Where it is, if not everywhere
      logical :: acts = .true.                       !! Is it there now?
      real(wp) :: shift(3) = 0.0_wp                  !! Way of the region so far [m]
   contains
      procedure :: advance => wall_advance           !! Bring it to a time
      procedure :: covers => wall_covers             !! Is a place in it now?
      procedure :: meets => wall_meets               !! May it touch a box?
   end type wall_t

contains

   !> Bring place and velocity of the wall to a time.
   pure subroutine wall_advance(self, time, lag, kick)
      class(wall_t), intent(inout) :: self           !! The wall
      real(wp), intent(in) :: time                   !! Of the positions [s]
      real(wp), intent(in) :: lag                    !! By which velocities are behind them [s]
      real(wp), intent(in) :: kick                   !! Time that forces act, 0 = none [s]

      self%acts = self%motion%acts(time)
      ! a part of a face stays where it is
      if (self%face == 0) self%shift = self%motion%shift(time)
      self%velocity = self%motion%velocity(time - lag)
      self%gain = 0.0_wp
      if (kick > 0.0_wp) &
         self%gain = (self%motion%velocity(time - lag + kick) - self%velocity)/kick
   end subroutine wall_advance

   !> Whether a place belongs to the wall where it is now; it is there.
   pure logical function wall_covers(self, x) result(covers)
      class(wall_t), intent(in) :: self              !! The wall
      real(wp), intent(in) :: x(3)                   !! [m]

      covers = self%acts
      if (covers .and. allocated(self%region)) covers = self%region%contains(x - self%shift)
   end function wall_covers

   !> Whether the box around the wall meets another box.
   pure logical function wall_meets(self, low, high) result(meets)
      class(wall_t), intent(in) :: self              !! The wall
      real(wp), intent(in) :: low(3)                 !! Lower corner [m]
      real(wp), intent(in) :: high(3)                !! Upper corner [m]
      real(wp) :: own_low(3), own_high(3)

      meets = self%acts
      if (.not. meets .or. .not. allocated(self%region)) return
      call self%region%bounds(own_low, own_high)
      meets = all(own_low + self%shift <= high .and. own_high + self%shift >= low)
   end function wall_meets

   !> Place of a node, the same bits in every tile that has it [m]. Along directions that the scene
   !! lacks it is where the particles are.
   pure function node_place(grid, coordinate, node) result(place)
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: node                    !! Node of the tile, counted from 1
      real(wp) :: place(3)

      place = grid%lower + grid%spacing*real(coordinate*grid%width + grid%node_position(node), wp)
      where (.not. grid%active) place = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), &
         grid%axisymmetric)
   end function node_place
end module mesh_wall
