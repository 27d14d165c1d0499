! SPDX-License-Identifier: BSD-3-Clause
!> Longitudinal vibration of a bar along x in one mode, optionally with a uniform velocity; small
!! strain.
!!
!! v = V + v_0 s(X) cos(w t), w = k c, c = sqrt((lambda + 2 mu)/rho), which is sqrt(E/rho) where
!! Poisson's ratio is 0. Fixed at the origin: s = sin(k X), k = (n - 1/2) pi/L; free at both ends:
!! s = cos(k X), k = n pi/L.
module exact_bar_mode
   use base_constants, only: pi
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use exact_solution, only: exact_t
   implicit none
   private

   public :: exact_bar_mode_t

   !> A mode of a bar.
   type, extends(exact_t) :: exact_bar_mode_t
      real(wp) :: length = 1.0_wp                    !! L [m]
      integer :: mode = 1                            !! n
      logical :: held = .true.                       !! Is the end at the origin fixed?
      real(wp) :: amplitude = 0.0_wp                 !! v_0 [m/s]
      real(wp) :: flight = 0.0_wp                    !! V [m/s]
   contains
      procedure :: declare => bar_mode_declare       !! Length, mode, ends, speeds
      procedure :: read => bar_mode_read             !! Reads the keys
      procedure :: fault => bar_mode_fault           !! A fixed bar has no uniform velocity
      procedure :: place => bar_mode_place           !! Position and velocity
      procedure :: gradient => bar_mode_gradient     !! Deformation gradient
      procedure :: wave => bar_mode_wave             !! Wave number
      procedure :: frequency => bar_mode_frequency   !! Angular frequency
   end type exact_bar_mode_t

contains

   !> Declare the keys.
   subroutine bar_mode_declare(self, schema)
      class(exact_bar_mode_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      character(len=*), parameter :: owner = "solution = bar_mode"

      call schema%real("exact", "bar_length", "length of the bar, which starts at the origin", &
         unit="m", range="> 0", owner=owner)
      call schema%text("exact", "ends", "end conditions at the origin and at the other end", &
         default="fixed_free", words="fixed_free free_free", owner=owner)
      call schema%integer("exact", "mode", "mode number", default="1", range="> 0", owner=owner)
      call schema%real("exact", "mode_speed", "velocity amplitude of the vibration", unit="m/s", &
         range="> 0", owner=owner)
      call schema%real("exact", "flight_speed", &
         "uniform velocity along x, for a bar with free ends", unit="m/s", default="0.0", &
         owner=owner)
      call schema%require("exact", "bar_length mode_speed")
   end subroutine bar_mode_declare

   !> Read the keys.
   subroutine bar_mode_read(self, group)
      class(exact_bar_mode_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &exact
      character(len=:), allocatable :: ends

      call group%get("bar_length", self%length)
      call group%get("ends", ends)
      self%held = ends == "fixed_free"
      call group%get("mode", self%mode)
      call group%get("mode_speed", self%amplitude)
      call group%get("flight_speed", self%flight)
   end subroutine bar_mode_read

   !> A bar with a fixed end has no uniform velocity.
   pure function bar_mode_fault(self) result(text)
      class(exact_bar_mode_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
      if (self%held .and. abs(self%flight) > 0.0_wp) &
         text = "has a flight_speed only with ends = 'free_free'; remove flight_speed or "// &
         "free the ends [D343]"
   end function bar_mode_fault

   !> Wave number k of the mode [1/m].
   pure real(wp) function bar_mode_wave(self) result(wave)
      class(exact_bar_mode_t), intent(in) :: self
      wave = (real(self%mode, wp) - merge(0.5_wp, 0.0_wp, self%held))*pi/self%length
   end function bar_mode_wave

   !> Angular frequency w of the mode [1/s].
   pure real(wp) function bar_mode_frequency(self) result(frequency)
      class(exact_bar_mode_t), intent(in) :: self
      frequency = self%wave()*sqrt((self%lambda + 2.0_wp*self%shear)/self%density)
   end function bar_mode_frequency

   !> Position and velocity.
   pure subroutine bar_mode_place(self, point, time, position, velocity)
      class(exact_bar_mode_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: position(3)           !! [m]
      real(wp), intent(out) :: velocity(3)           !! [m/s]
      real(wp) :: angle, shape, frequency

      angle = self%wave()*(point(1) - self%origin(1))
      shape = merge(sin(angle), cos(angle), self%held)
      frequency = self%frequency()
      position = point
      position(1) = point(1) + self%flight*time + self%amplitude*shape*sin(frequency*time)/frequency
      velocity = [self%flight + self%amplitude*shape*cos(frequency*time), 0.0_wp, 0.0_wp]
   end subroutine bar_mode_place

   !> Deformation gradient.
   pure subroutine bar_mode_gradient(self, point, time, gradient)
      class(exact_bar_mode_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: gradient(3, 3)        !! [1]
      real(wp) :: angle, slope, frequency
      integer :: k

      angle = self%wave()*(point(1) - self%origin(1))
      slope = self%wave()*merge(cos(angle), -sin(angle), self%held)
      frequency = self%frequency()
      gradient = 0.0_wp
      do k = 1, 3
         gradient(k, k) = 1.0_wp
      end do
      gradient(1, 1) = 1.0_wp + self%amplitude*slope*sin(frequency*time)/frequency
   end subroutine bar_mode_gradient
end module exact_bar_mode
