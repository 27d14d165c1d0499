! SPDX-License-Identifier: BSD-3-Clause
!> A disc in plane strain that rotates steadily about its axis, with the strain of the centrifugal
!! force; small strain.
!!
!! S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, sec. 32, for plane stress: u =
!! (1 - n) rho w^2 r/(8 E) [(3 + n) R^2 - (1 + n) r^2]; in plane strain with E/(1 - nu^2) for E and
!! n = nu/(1 - nu). The density is that at rest.
module exact_spinning_disc
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use exact_solution, only: exact_t
   implicit none
   private

   public :: exact_spinning_disc_t

   !> A disc in equilibrium with its rotation about y, from z to x.
   type, extends(exact_t) :: exact_spinning_disc_t
      real(wp) :: spin = 0.0_wp                      !! Angular velocity w [rad/s]
      real(wp) :: radius = 1.0_wp                    !! R [m]
   contains
      procedure :: declare => disc_declare           !! Spin and radius
      procedure :: read => disc_read                 !! Reads the keys
      procedure :: fault => disc_fault               !! Plane strain only
      procedure :: place => disc_place               !! Position and velocity
      procedure :: gradient => disc_gradient         !! Deformation gradient
      procedure :: stretch => disc_stretch           !! u/r and its derivative by r^2
   end type exact_spinning_disc_t

contains

   !> Declare the keys.
   subroutine disc_declare(self, schema)
      class(exact_spinning_disc_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      character(len=*), parameter :: owner = "solution = spinning_disc"

      call schema%real("exact", "angular_speed", &
         "angular velocity about the y axis through the origin, in radians per time", unit="1/s", &
         owner=owner)
      call schema%real("exact", "disc_radius", "radius of the undeformed disc", unit="m", &
         range="> 0", owner=owner)
      call schema%require("exact", "angular_speed disc_radius")
   end subroutine disc_declare

   !> Read the keys.
   subroutine disc_read(self, group)
      class(exact_spinning_disc_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &exact

      call group%get("angular_speed", self%spin)
      call group%get("disc_radius", self%radius)
   end subroutine disc_read

   !> The rotation is in the plane x, z.
   pure function disc_fault(self) result(text)
      class(exact_spinning_disc_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
      if (self%dimensions /= 2) text = "needs dimension = 'plane_strain' of &run [D365]"
   end function disc_fault

   !> Displacement divided by radius, u/r = a - b r^2, and b.
   pure subroutine disc_stretch(self, square, stretch, slope)
      class(exact_spinning_disc_t), intent(in) :: self
      real(wp), intent(in) :: square                 !! r^2 [m2]
      real(wp), intent(out) :: stretch               !! u/r [1]
      real(wp), intent(out) :: slope                 !! b [1/m2]
      real(wp) :: poisson, ratio, scale

      poisson = 0.5_wp*self%lambda/(self%lambda + self%shear)
      ratio = poisson/(1.0_wp - poisson)
      scale = (1.0_wp - ratio)*(1.0_wp - poisson**2)*self%density*self%spin**2 &
         /(8.0_wp*self%young())
      slope = scale*(1.0_wp + ratio)
      stretch = scale*(3.0_wp + ratio)*self%radius**2 - slope*square
   end subroutine disc_stretch

   !> Position and velocity.
   pure subroutine disc_place(self, point, time, position, velocity)
      class(exact_spinning_disc_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: position(3)           !! [m]
      real(wp), intent(out) :: velocity(3)           !! [m/s]
      real(wp) :: arm(3), stretch, slope, c, s

      arm = point - self%origin
      call self%stretch(arm(1)**2 + arm(3)**2, stretch, slope)
      c = cos(self%spin*time)
      s = sin(self%spin*time)
      arm = (1.0_wp + stretch)*[c*arm(1) + s*arm(3), 0.0_wp, c*arm(3) - s*arm(1)]
      position = [self%origin(1) + arm(1), point(2), self%origin(3) + arm(3)]
      velocity = self%spin*[arm(3), 0.0_wp, -arm(1)]
   end subroutine disc_place

   !> Deformation gradient F = Q [(1 + u/r) 1 - 2 b X X^T] in the plane.
   pure subroutine disc_gradient(self, point, time, gradient)
      class(exact_spinning_disc_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: gradient(3, 3)        !! [1]
      real(wp) :: x, z, stretch, slope, c, s, radial(2, 2), rotation(2, 2)

      x = point(1) - self%origin(1)
      z = point(3) - self%origin(3)
      call self%stretch(x**2 + z**2, stretch, slope)
      radial(1, :) = [1.0_wp + stretch - 2.0_wp*slope*x*x, -2.0_wp*slope*x*z]
      radial(2, :) = [-2.0_wp*slope*x*z, 1.0_wp + stretch - 2.0_wp*slope*z*z]
      c = cos(self%spin*time)
      s = sin(self%spin*time)
      rotation(1, :) = [c, s]
      rotation(2, :) = [-s, c]
      gradient = 0.0_wp
      gradient(1:3:2, 1:3:2) = matmul(rotation, radial)
      gradient(2, 2) = 1.0_wp
   end subroutine disc_gradient
end module exact_spinning_disc
