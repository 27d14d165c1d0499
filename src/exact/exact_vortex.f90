! SPDX-License-Identifier: BSD-3-Clause
!> Generalised vortex: the circles of a ring rotate back and forth, the middle one most and the rims
!! not at all; a manufactured solution.
!!
!! K. Kamojjala, R. Brannon, A. Sadeghirad, J. Guilkey, Eng. with Computers 31 (2015) 193: a point
!! at radius R rotates by g(t) h(R), g = A sin(2 pi f t), h = (1 - 4 s^2)^2 with s = (R - R_m)/w
!! from -1/2 to 1/2 over the width w. Volumes are constant; rotations and shear are large.
module exact_vortex
   use base_constants, only: pi
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use exact_solution, only: exact_t
   implicit none
   private

   public :: exact_vortex_t

   !> The generalised vortex, in the plane of x and z.
   type, extends(exact_t) :: exact_vortex_t
      real(wp) :: twist = 1.0_wp                     !! Greatest angle A of the middle [rad]
      real(wp) :: frequency = 0.0_wp                 !! f [1/s]
      real(wp) :: inner = 0.75_wp                    !! Radius of the inner rim [m]
      real(wp) :: outer = 1.25_wp                    !! Radius of the outer rim [m]
   contains
      procedure :: declare => vortex_declare         !! Twist, frequency, radii
      procedure :: read => vortex_read               !! Reads the keys
      procedure :: law => vortex_law                 !! Neo-Hooke
      procedure :: fault => vortex_fault             !! Plane strain only
      procedure :: place => vortex_place             !! Position and velocity
      procedure :: gradient => vortex_gradient       !! Deformation gradient
      procedure :: forced => vortex_forced           !! True
      procedure :: body_force => vortex_force        !! Acceleration - div(stress)/density
      procedure, private :: shape => vortex_shape    !! h and its derivatives
   end type exact_vortex_t

contains

   !> Declare the keys.
   subroutine vortex_declare(self, schema)
      class(exact_vortex_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      character(len=*), parameter :: owner = "solution = vortex"

      call schema%real("exact", "twist", &
         "greatest rotation of the middle of the ring, in radians", default="1.0", range="> 0", &
         owner=owner)
      call schema%real("exact", "frequency", "oscillations per time", unit="1/s", range="> 0", &
         owner=owner)
      call schema%real("exact", "inner_radius", "inner radius of the ring, which does not move", &
         unit="m", default="0.75", range="> 0", owner=owner)
      call schema%real("exact", "outer_radius", "outer radius of the ring, which does not move", &
         unit="m", default="1.25", range="> 0", owner=owner)
      call schema%require("exact", "frequency")
   end subroutine vortex_declare

   !> Read the keys.
   subroutine vortex_read(self, group)
      class(exact_vortex_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &exact

      call group%get("twist", self%twist)
      call group%get("frequency", self%frequency)
      call group%get("inner_radius", self%inner)
      call group%get("outer_radius", self%outer)
   end subroutine vortex_read

   !> The law for which the body force is derived.
   pure function vortex_law(self) result(law)
      class(exact_vortex_t), intent(in) :: self
      character(len=:), allocatable :: law

      law = "neo_hookean"
   end function vortex_law

   !> The rotation is in the plane x, z.
   pure function vortex_fault(self) result(text)
      class(exact_vortex_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
      if (self%dimensions /= 2) text = "needs dimension = 'plane_strain' of &run [D365]"
      if (self%outer <= self%inner) text = "needs outer_radius above inner_radius [D365]"
   end function vortex_fault

   !> A manufactured solution.
   pure logical function vortex_forced(self) result(forced)
      class(exact_vortex_t), intent(in) :: self
      forced = .true.
   end function vortex_forced

   !> Radius and angle of a point, and h with its first and second derivative by the radius.
   pure subroutine vortex_shape(self, point, radius, angle, shape)
      class(exact_vortex_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(out) :: radius                !! From the origin [m]
      real(wp), intent(out) :: angle                 !! From x to z [rad]
      real(wp), intent(out) :: shape(0:2)            !! h [1], h' [1/m], h'' [1/m2]
      real(wp) :: s, width

      radius = hypot(point(1) - self%origin(1), point(3) - self%origin(3))
      angle = 0.0_wp
      if (radius > 0.0_wp) angle = atan2(point(3) - self%origin(3), point(1) - self%origin(1))
      width = self%outer - self%inner
      s = (radius - 0.5_wp*(self%inner + self%outer))/width
      shape = 0.0_wp
      if (abs(s) >= 0.5_wp) return
      shape = [(1.0_wp - 4.0_wp*s**2)**2, -16.0_wp*s*(1.0_wp - 4.0_wp*s**2)/width, &
         (192.0_wp*s**2 - 16.0_wp)/width**2]
   end subroutine vortex_shape

   !> Position and velocity.
   pure subroutine vortex_place(self, point, time, position, velocity)
      class(exact_vortex_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: position(3)           !! [m]
      real(wp), intent(out) :: velocity(3)           !! [m/s]
      real(wp) :: radius, angle, shape(0:2), pace, speed

      call self%shape(point, radius, angle, shape)
      pace = 2.0_wp*pi*self%frequency
      angle = angle + self%twist*sin(pace*time)*shape(0)
      speed = radius*self%twist*pace*cos(pace*time)*shape(0)
      position = [self%origin(1) + radius*cos(angle), point(2), self%origin(3) + radius*sin(angle)]
      velocity = speed*[-sin(angle), 0.0_wp, cos(angle)]
   end subroutine vortex_place

   !> Deformation gradient F = Q (1 + R a' e_theta e_r) with the rotation Q by a = g h.
   pure subroutine vortex_gradient(self, point, time, gradient)
      class(exact_vortex_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: gradient(3, 3)        !! [1]
      real(wp) :: radius, angle, shape(0:2), turn, shear, after

      call self%shape(point, radius, angle, shape)
      turn = self%twist*sin(2.0_wp*pi*self%frequency*time)
      shear = radius*turn*shape(1)
      turn = turn*shape(0)
      after = angle + turn
      gradient = 0.0_wp
      gradient(1, 1) = cos(turn) - shear*sin(after)*cos(angle)
      gradient(3, 1) = sin(turn) + shear*cos(after)*cos(angle)
      gradient(1, 3) = -sin(turn) - shear*sin(after)*sin(angle)
      gradient(3, 3) = cos(turn) + shear*cos(after)*sin(angle)
      gradient(2, 2) = 1.0_wp
   end subroutine vortex_gradient

   !> Body force b_r = R [mu/rho (g h')^2 - (g. h)^2], b_theta = R g.. h - mu/rho (3 g h' + R g h'')
   !! along the current radius and normal to it.
   pure subroutine vortex_force(self, point, time, force)
      class(exact_vortex_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: force(3)              !! Per mass [m/s2]
      real(wp) :: radius, angle, shape(0:2), pace, turn, rate, stiffness, out, across

      call self%shape(point, radius, angle, shape)
      pace = 2.0_wp*pi*self%frequency
      turn = self%twist*sin(pace*time)
      rate = self%twist*pace*cos(pace*time)
      stiffness = self%shear/self%density
      angle = angle + turn*shape(0)
      out = radius*(stiffness*(turn*shape(1))**2 - (rate*shape(0))**2)
      across = -radius*pace**2*turn*shape(0) - stiffness*turn*(3.0_wp*shape(1) + radius*shape(2))
      force = out*[cos(angle), 0.0_wp, sin(angle)] + across*[-sin(angle), 0.0_wp, cos(angle)]
   end subroutine vortex_force
end module exact_vortex
