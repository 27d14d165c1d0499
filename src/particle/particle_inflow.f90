! SPDX-License-Identifier: BSD-3-Clause
!> Material that flows into the domain: copies of the particles of a body follow each other at the
!! length of the body, and each particle enters where its position passes the plane behind the body.
!! Equations (O.8) and (O.9) of doc/theory/instruments.md.
!!
!! The entered material follows from the time alone. A checkpoint stores the displacement, so that a
!! restart with another velocity continues from it. A rank
!! holds the particles of the tiles that it has counted; those that enter are sent to the
!! owners of their tiles.
module particle_inflow
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use mesh_motion, only: motion_t
   use particle_store, only: store_t
   implicit none
   private

   public :: fed_t, inflow_t

   !> An inflow.
   type :: inflow_t
      character(len=:), allocatable :: name          !! Name of its body
      integer :: body = 0                            !! Index of its body
      integer :: store = 1                           !! Index of its store
      integer :: wall = 0                            !! Index of the rigid region that holds it
      real(wp) :: mass_rate = 0.0_wp                 !! If given instead of a speed [kg/s]
      type(motion_t) :: motion                       !! Velocity, and end of the inflow
      integer :: axis = 1                            !! Direction of the flow
      real(wp) :: sense = 1.0_wp                     !! -1 = against the axis
      real(wp) :: plane = 0.0_wp                     !! Where material enters, along the axis [m]
      real(wp) :: length = 0.0_wp                    !! Length of the body along the flow [m]
      real(wp) :: ahead = 0.0_wp !! Displacement before a restart, less that of this motion [m]
      integer(int64) :: identities = 0               !! Added to an identity from copy to copy
      type(store_t) :: pattern                       !! Particles in the tiles of the body
      !> (3, particle of the pattern) Boxes that they fill at the start, if strength scatters [m]
      real(wp), allocatable :: low(:, :), high(:, :)
      real(wp), allocatable :: back(:) !! (same) Shift of its last copy along the axis [m]
      integer, allocatable :: particle(:)            !! (entry) Particle of the body
      integer(int64), allocatable :: identity(:)     !! (entry) First identity of the copies
      real(wp), allocatable :: origin(:)             !! (entry) Positions along the axis [m]
   contains
      procedure :: travel => inflow_travel           !! Displacement of the flow
      procedure :: enter => inflow_enter             !! Particles that enter in a step
      procedure :: find_box => inflow_find_box       !! Place of an entering particle at the start
      procedure :: state => inflow_state             !! Displacement, for a checkpoint
      procedure :: continue => inflow_continue       !! Continues from the displacement
   end type inflow_t

   !> Particles that enter a store, as rows of words.
   type :: fed_t
      integer :: store = 0                           !! Index of their store
      real(wp), allocatable :: position(:, :)        !! (row, 3) [m]
      integer(int64), allocatable :: rows(:, :)      !! (word, row) All fields
   end type fed_t

   real(wp), parameter :: inside = 1.0e-6_wp !! Fraction of a cell, least distance behind the plane

contains

   !> Distance that the material has moved at a time, d of (O.8) [m].
   pure real(wp) function inflow_travel(self, time) result(way)
      class(inflow_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]
      real(wp) :: shift(3)

      shift = self%motion%shift(time)
      way = self%sense*shift(self%axis) + self%ahead
   end function inflow_travel

   !> The two parts of the displacement at a time: of the motion, and before it [m].
   pure function inflow_state(self, time) result(parts)
      class(inflow_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]
      real(wp) :: parts(2), shift(3)

      shift = self%motion%shift(time)
      parts = [self%sense*shift(self%axis), self%ahead]
   end function inflow_state

   !> Continue from the displacement of a checkpoint, also with another motion. With the same motion
   !! the result has the same bits as without a restart.
   pure subroutine inflow_continue(self, time, parts)
      class(inflow_t), intent(inout) :: self
      real(wp), intent(in) :: time                   !! Time of the checkpoint [s]
      real(wp), intent(in) :: parts(2)               !! From `inflow_state` [m]
      real(wp) :: now(2)

      self%ahead = parts(2)
      now = self%state(time)
      if (abs(now(1) - parts(1)) > 0.0_wp) self%ahead = parts(1) + parts(2) - now(1)
   end subroutine inflow_continue

   !> List the particles that enter between two times by (O.9), and set their positions at the end
   !! of the interval. The displacement in a step is less than the length of the body, so a particle
   !! enters at most once.
   subroutine inflow_enter(self, grid, began, time, particle)
      class(inflow_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: began                  !! [s]
      real(wp), intent(in) :: time                   !! [s]
      integer, allocatable, intent(out) :: particle(:) !! Indices in the pattern
      real(wp) :: before, now, depth, speed(3)
      integer(int64) :: copy
      integer :: n, p, filled

      before = self%travel(began) - inside*grid%spacing
      now = self%travel(time) - inside*grid%spacing
      allocate (particle(size(self%origin)))
      filled = 0
      if (now > before) then
         speed = self%motion%velocity(time)
         do n = 1, size(self%origin)
            depth = self%sense*(self%origin(n) - self%plane)
            copy = floor((depth + now)/self%length, int64)
            if (copy == floor((depth + before)/self%length, int64)) cycle
            p = self%particle(n)
            filled = filled + 1
            particle(filled) = p
            self%pattern%identity(p) = self%identity(n) + copy*self%identities
            self%pattern%position(p, self%axis) = self%origin(n) + self%sense*(now &
               + inside*grid%spacing - real(copy, wp)*self%length)
            self%pattern%velocity(p, :) = speed
            if (allocated(self%back)) self%back(p) = -self%sense*real(copy, wp)*self%length
         end do
      end if
      particle = particle(:filled)
   end subroutine inflow_enter

   !> Box that a particle which enters filled at the start: the flow is one piece of material that
   !! moves into the domain, so the place of a copy is behind that of the body.
   pure subroutine inflow_find_box(self, p, low, high)
      class(inflow_t), intent(in) :: self
      integer, intent(in) :: p                       !! Index in the pattern
      real(wp), intent(out) :: low(3), high(3)       !! Corners of the box [m]

      low = self%low(:, p)
      high = self%high(:, p)
      low(self%axis) = low(self%axis) + self%back(p)
      high(self%axis) = high(self%axis) + self%back(p)
   end subroutine inflow_find_box
end module particle_inflow
