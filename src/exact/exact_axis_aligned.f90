! SPDX-License-Identifier: BSD-3-Clause
!> Standing waves along the axes of a cube with sliding faces; a manufactured solution.
!!
!! P. C. Wallstedt, J. E. Guilkey, J. Comput. Phys. 227 (2008) 9628: u_k = A sin(pi X_k/L) sin(pi c
!! t/L + phase_k) with c = sqrt(E/rho). The phases differ, so that the directions are not at rest at
!! the same time: one wave in 1-D, two in plane strain with phases pi apart.
module exact_axis_aligned
   use base_constants, only: pi
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use exact_solution, only: exact_t
   implicit none
   private

   public :: exact_axis_aligned_t

   !> Waves along the axes.
   type, extends(exact_t) :: exact_axis_aligned_t
      real(wp) :: amplitude = 0.0_wp                 !! A [m]
      real(wp) :: edge = 1.0_wp                      !! Edge L of the cube [m]
   contains
      procedure :: declare => axis_aligned_declare   !! Amplitude and edge
      procedure :: read => axis_aligned_read         !! Reads the keys
      procedure :: law => axis_aligned_law           !! Neo-Hooke
      procedure :: place => axis_aligned_place       !! Position and velocity
      procedure :: gradient => axis_aligned_gradient !! Deformation gradient, diagonal
      procedure :: forced => axis_aligned_forced     !! True
      procedure :: body_force => axis_aligned_force  !! Acceleration - div(stress)/density
      procedure, private :: motion => axis_aligned_motion !! Displacement and its derivatives
   end type exact_axis_aligned_t

contains

   !> Declare the keys.
   subroutine axis_aligned_declare(self, schema)
      class(exact_axis_aligned_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      character(len=*), parameter :: owner = "solution = axis_aligned"

      call schema%real("exact", "amplitude", "displacement amplitude along an axis", unit="m", &
         range="> 0", owner=owner)
      call schema%real("exact", "edge", "edge of the cube, whose lower corner is at the origin", &
         unit="m", default="1.0", range="> 0", owner=owner)
      call schema%require("exact", "amplitude")
   end subroutine axis_aligned_declare

   !> Read the keys.
   subroutine axis_aligned_read(self, group)
      class(exact_axis_aligned_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &exact

      call group%get("amplitude", self%amplitude)
      call group%get("edge", self%edge)
   end subroutine axis_aligned_read

   !> The law for which the body force is derived.
   pure function axis_aligned_law(self) result(law)
      class(exact_axis_aligned_t), intent(in) :: self
      character(len=:), allocatable :: law

      law = "neo_hookean"
   end function axis_aligned_law

   !> A manufactured solution.
   pure logical function axis_aligned_forced(self) result(forced)
      class(exact_axis_aligned_t), intent(in) :: self
      forced = .true.
   end function axis_aligned_forced

   !> Displacement, velocity and stretch along each axis.
   pure subroutine axis_aligned_motion(self, point, time, displacement, rate, stretch)
      class(exact_axis_aligned_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: displacement(3)       !! [m]
      real(wp), intent(out) :: rate(3)               !! [m/s]
      real(wp), intent(out) :: stretch(3)            !! [1]
      integer, parameter :: axes(3, 3) = reshape([1, 0, 0, 1, 3, 0, 1, 2, 3], [3, 3])
      real(wp) :: wave, turn, frequency, angle
      integer :: n, k

      displacement = 0.0_wp
      rate = 0.0_wp
      stretch = 1.0_wp
      wave = pi/self%edge
      frequency = wave*sqrt(self%young()/self%density)
      !GCC$ novector
      do n = 1, self%dimensions
         k = axes(n, self%dimensions)
         turn = frequency*time + 2.0_wp*pi*real(n - 1, wp)/real(self%dimensions, wp)
         angle = wave*(point(k) - self%origin(k))
         displacement(k) = self%amplitude*sin(angle)*sin(turn)
         rate(k) = frequency*self%amplitude*sin(angle)*cos(turn)
         stretch(k) = 1.0_wp + wave*self%amplitude*cos(angle)*sin(turn)
      end do
   end subroutine axis_aligned_motion

   !> Position and velocity.
   pure subroutine axis_aligned_place(self, point, time, position, velocity)
      class(exact_axis_aligned_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: position(3)           !! [m]
      real(wp), intent(out) :: velocity(3)           !! [m/s]
      real(wp) :: displacement(3), stretch(3)

      call self%motion(point, time, displacement, velocity, stretch)
      position = point + displacement
   end subroutine axis_aligned_place

   !> Deformation gradient.
   pure subroutine axis_aligned_gradient(self, point, time, gradient)
      class(exact_axis_aligned_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: gradient(3, 3)        !! [1]
      real(wp) :: displacement(3), rate(3), stretch(3)
      integer :: k

      call self%motion(point, time, displacement, rate, stretch)
      gradient = 0.0_wp
      do k = 1, 3
         gradient(k, k) = stretch(k)
      end do
   end subroutine axis_aligned_gradient

   !> Body force b_k = (pi/L)^2 u_k [mu/rho - c^2 - (lambda (ln J - 1) - mu)/(rho F_kk^2)].
   pure subroutine axis_aligned_force(self, point, time, force)
      class(exact_axis_aligned_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: force(3)              !! Per mass [m/s2]
      real(wp) :: displacement(3), rate(3), stretch(3), volume

      call self%motion(point, time, displacement, rate, stretch)
      volume = stretch(1)*stretch(2)*stretch(3)
      force = (pi/self%edge)**2*displacement*((self%shear - self%young())/self%density &
         - (self%lambda*(log(volume) - 1.0_wp) - self%shear)/(self%density*stretch**2))
   end subroutine axis_aligned_force
end module exact_axis_aligned
