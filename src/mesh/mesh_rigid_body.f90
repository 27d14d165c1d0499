! SPDX-License-Identifier: BSD-3-Clause
!> A rigid region that turns, or that forces move: its place, its velocities and its inertia.
!!
!! Velocities are at the time of the node velocities, the place at that of the positions. During
!! the time that forces act, the place is that of the start of the step, so the velocity of a point
!! of the body changes linearly. Equations (R.8) to (R.10) of doc/theory/rigid.md.
module mesh_rigid_body
   use base_elementary, only: cross
   use base_kinds, only: wp
   use mesh_free_rotation, only: product_of_turns, rotate_freely, matrix_of_turn, turn_by, &
      turned, turned_back
   implicit none
   private

   public :: rigid_body_t

   integer, parameter, public :: body_state_size = 29 !! Numbers in a checkpoint for each body

   real(wp), parameter :: straight(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

   !> A rigid body. Directions in which it is not free follow the motion of its wall.
   type :: rigid_body_t
      logical :: free(3) = .false.                   !! Directions in which forces move it
      logical :: free_spin = .false.                 !! Do torques change its rotation?
      logical :: plane = .false.                     !! Does it turn about y only?
      real(wp) :: mass = 0.0_wp                      !! [kg]
      real(wp) :: inertia(3, 3) = 0.0_wp             !! In its own frame, about its centre [kg m2]
      real(wp) :: mobility(3, 3) = 0.0_wp            !! Inverse of the inertia [1/(kg m2)]
      real(wp) :: force(3) = 0.0_wp                  !! External, besides gravity [N]
      real(wp) :: home(3) = 0.0_wp                   !! Centre at the start [m]
      real(wp) :: radius = huge(1.0_wp)              !! Distance of its farthest point [m]
      real(wp) :: centre(3) = 0.0_wp                 !! Centre of mass, or point of the axis [m]
      real(wp) :: turn(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp] !! Quaternion, body to space
      real(wp) :: frame(3, 3) = straight             !! Rotation matrix of the turn [1]
      real(wp) :: velocity(3) = 0.0_wp               !! Of the centre [m/s]
      real(wp) :: momentum(3) = 0.0_wp               !! Angular, about the centre [kg m2/s]
      real(wp) :: energy = 0.0_wp                    !! Of the free rotation [J]
      real(wp) :: spin(3) = 0.0_wp                   !! Angular velocity, in space [rad/s]
      real(wp) :: first_velocity(3) = 0.0_wp         !! At the start of the run [m/s]
      real(wp) :: first_spin(3) = 0.0_wp             !! At the start of the run [rad/s]
      real(wp) :: velocity_end(3) = 0.0_wp           !! After the forces of the step [m/s]
      real(wp) :: spin_end(3) = 0.0_wp               !! After the forces of the step [rad/s]
      real(wp) :: impulse(3) = 0.0_wp                !! Of the material, since the start [N s]
      real(wp) :: moment(3) = 0.0_wp                 !! About the centre, since the start [N m s]
      real(wp) :: work = 0.0_wp                      !! Of the material, since the start [J]
      real(wp) :: weight_work = 0.0_wp               !! Of gravity and the external force [J]
   contains
      procedure :: responds => body_responds         !! Do forces change its motion?
      procedure :: begin => body_begin               !! At the start of a run
      procedure :: own_place => body_own_place       !! Point of the body that is at a position
      procedure :: velocity_at => body_velocity_at   !! Velocity of a point, before the forces
      procedure :: gain_at => body_gain_at           !! Gain of velocity of a point by the forces
      procedure :: spin_of => body_spin_of           !! Angular velocity of an angular momentum
      procedure :: inertia_in_space => body_inertia  !! Inertia in space
      procedure :: receive => body_receive           !! Take the impulses of a step
      procedure :: advance => body_advance           !! Move and turn over a step
      procedure :: kinetic => body_kinetic           !! Kinetic energy
      procedure :: pack => body_pack                 !! State as numbers, for a checkpoint
      procedure :: unpack => body_unpack             !! State from these
   end type rigid_body_t

contains

   !> Whether forces change its motion.
   elemental logical function body_responds(self) result(responds)
      class(rigid_body_t), intent(in) :: self

      responds = any(self%free) .or. self%free_spin
   end function body_responds

   !> Set the state at the start: the centre at home, and the given velocities.
   pure subroutine body_begin(self, velocity, spin)
      class(rigid_body_t), intent(inout) :: self
      real(wp), intent(in) :: velocity(3)            !! Of the centre [m/s]
      real(wp), intent(in) :: spin(3)                !! [rad/s]

      self%centre = self%home
      self%velocity = velocity
      self%velocity_end = velocity
      self%spin = spin
      self%spin_end = spin
      self%first_velocity = velocity
      self%first_spin = spin
      if (.not. self%free_spin) return
      self%momentum = turned(self%inertia, spin)
      self%energy = 0.5_wp*dot_product(self%momentum, spin)
   end subroutine body_begin

   !> Where the point of the body that is at a position now was at the start [m].
   pure function body_own_place(self, x) result(place)
      class(rigid_body_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! [m]
      real(wp) :: place(3)

      place = self%home + turned_back(self%frame, x - self%centre)
   end function body_own_place

   !> Velocity of the point of the body at a position, before the forces of the step [m/s].
   pure function body_velocity_at(self, x) result(velocity)
      class(rigid_body_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! [m]
      real(wp) :: velocity(3)

      velocity = self%velocity + cross(self%spin, x - self%centre)
   end function body_velocity_at

   !> Gain of this velocity by the forces of the step [m/s].
   pure function body_gain_at(self, x) result(gain)
      class(rigid_body_t), intent(in) :: self
      real(wp), intent(in) :: x(3)                   !! [m]
      real(wp) :: gain(3)

      gain = self%velocity_end - self%velocity + cross(self%spin_end - self%spin, x - self%centre)
   end function body_gain_at

   !> Angular velocity, in space, of an angular momentum [rad/s].
   pure function body_spin_of(self, momentum) result(spin)
      class(rigid_body_t), intent(in) :: self
      real(wp), intent(in) :: momentum(3)            !! In space [kg m2/s]
      real(wp) :: spin(3)

      spin = turned(self%frame, turned(self%mobility, turned_back(self%frame, momentum)))
   end function body_spin_of

   !> Inertia in space [kg m2].
   pure function body_inertia(self) result(inertia)
      class(rigid_body_t), intent(in) :: self
      real(wp) :: inertia(3, 3)
      real(wp) :: unit(3)
      integer :: k

      do k = 1, 3
         unit = 0.0_wp
         unit(k) = 1.0_wp
         inertia(:, k) = turned(self%frame, turned(self%inertia, turned_back(self%frame, unit)))
      end do
   end function body_inertia

   !> Take the impulses of a step. Free directions get the new velocity from the impulses, the
   !! others have that of the motion, `velocity_end`, and the support exerts what is missing.
   pure subroutine body_receive(self, impulse, moment, weight, support, given, hold)
      class(rigid_body_t), intent(inout) :: self
      real(wp), intent(in) :: impulse(3)             !! Of the material [N s]
      real(wp), intent(in) :: moment(3)              !! Its moment about the centre [N m s]
      real(wp), intent(in) :: weight(3)              !! Of gravity and the force [N s]
      real(wp), intent(out) :: support(3)            !! Impulse of the support [N s]
      real(wp), intent(out) :: given                 !! Work of all three, and of the next [J]
      real(wp), intent(out) :: hold(3)               !! Moment of the support [N m s]
      real(wp) :: middle(3), spin(3), work, own(3)

      where (self%free) self%velocity_end = self%velocity + (impulse + weight)/max(self%mass, &
         tiny(1.0_wp))
      support = 0.0_wp
      where (.not. self%free) support = self%mass*(self%velocity_end - self%velocity) - impulse &
         - weight
      middle = 0.5_wp*(self%velocity + self%velocity_end)
      hold = -moment
      spin = self%spin
      if (self%free_spin) then
         hold = 0.0_wp
         if (self%plane) hold([1, 3]) = -moment([1, 3])
         if (maxval(abs(moment + hold)) > 0.0_wp) then
            self%momentum = self%momentum + (moment + hold)
            self%spin_end = self%spin_of(self%momentum)
            own = turned_back(self%frame, self%momentum)
            self%energy = 0.5_wp*dot_product(own, turned(self%mobility, own))
         else
            self%spin_end = self%spin
         end if
         spin = 0.5_wp*(self%spin + self%spin_end)
      end if
      work = dot_product(impulse, middle) + dot_product(moment, spin)
      self%impulse = self%impulse + impulse
      self%moment = self%moment + moment
      self%work = self%work + work
      self%weight_work = self%weight_work + dot_product(weight, middle)
      given = work + dot_product(weight, middle) + dot_product(support, middle) &
         + dot_product(hold, spin)
      self%velocity = self%velocity_end
      self%spin = self%spin_end
   end subroutine body_receive

   !> Move and turn with the velocities after the forces.
   pure subroutine body_advance(self, time, place)
      class(rigid_body_t), intent(inout) :: self
      real(wp), intent(in) :: time                   !! Length of the step [s]
      real(wp), intent(in) :: place(3)               !! After it, for directions without freedom [m]

      where (self%free)
         self%centre = self%centre + time*self%velocity
      else where
         self%centre = place
      end where
      if (self%free_spin) then
         call rotate_freely(self%mobility, self%momentum, self%energy, time, self%turn)
         self%frame = matrix_of_turn(self%turn)
         self%spin = self%spin_of(self%momentum)
      else if (maxval(abs(self%spin)) > 0.0_wp) then
         self%turn = product_of_turns(turn_by(time*self%spin), self%turn)
         self%turn = self%turn/norm2(self%turn)
         self%frame = matrix_of_turn(self%turn)
      end if
      self%spin_end = self%spin
   end subroutine body_advance

   !> Kinetic energy [J].
   pure real(wp) function body_kinetic(self) result(energy)
      class(rigid_body_t), intent(in) :: self

      energy = 0.5_wp*self%mass*sum(self%velocity**2) + 0.5_wp*dot_product(self%momentum, self%spin)
   end function body_kinetic

   !> State as numbers.
   pure function body_pack(self) result(numbers)
      class(rigid_body_t), intent(in) :: self
      real(wp) :: numbers(body_state_size)

      numbers = [self%centre, self%turn, self%velocity, self%momentum, self%energy, self%spin, &
         self%home, self%impulse, self%moment, self%work, self%weight_work, self%mass]
   end function body_pack

   !> State from numbers. The mass is that of the deck.
   pure subroutine body_unpack(self, numbers)
      class(rigid_body_t), intent(inout) :: self
      real(wp), intent(in) :: numbers(body_state_size) !! From `pack`

      self%centre = numbers(1:3)
      self%turn = numbers(4:7)
      self%frame = matrix_of_turn(self%turn)
      self%velocity = numbers(8:10)
      self%momentum = numbers(11:13)
      self%energy = numbers(14)
      self%spin = numbers(15:17)
      self%impulse = numbers(21:23)
      self%moment = numbers(24:26)
      self%work = numbers(27)
      self%weight_work = numbers(28)
      self%velocity_end = self%velocity
      self%spin_end = self%spin
   end subroutine body_unpack
end module mesh_rigid_body
