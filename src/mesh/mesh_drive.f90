! SPDX-License-Identifier: BSD-3-Clause
!> How a periodic cell is driven: the velocity gradient of a stage of the deck, and the axes with
!! prescribed stress. Equation (G.3) of doc/theory/grains.md.
module mesh_drive
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use mesh_box, only: box_t
   implicit none
   private

   public :: drive_t, read_drive, stage_duration

   real(wp), parameter :: waves = 3.0_wp             !! Servo rate over the rate of a wave
   real(wp), parameter :: part = 0.2_wp              !! Servo rate over the greatest shear rate
   real(wp), parameter :: most = 0.25_wp !! Greatest relative change of a held stress in a step

   !> How the cell is driven.
   type :: drive_t
      real(wp) :: gradient(3, 3) = 0.0_wp            !! Given velocity gradient [1/s]
      logical :: servo(3) = .false.                  !! Axes with prescribed stress
      logical :: isotropic = .false. !! Same rate on all axes, mean pressure controlled
      real(wp) :: pressure = 0.0_wp                  !! Held [Pa]
      real(wp) :: servo_rate = 0.0_wp                !! Strain rate at an error of 1 [1/s]
      real(wp) :: haste = 20.0_wp !! Factor of the rate in a cell without stress [1]
   contains
      procedure :: set_rate => drive_set_rate        !! Rate of the servo
      procedure :: steer => drive_steer              !! Velocity gradient of the next step
   end type drive_t

contains

   !> Read the gradient, the held axes and the pressure of a stage.
   subroutine read_drive(deck, stage, active, drive)
      type(deck_t), intent(in) :: deck
      type(group_t), intent(in) :: stage             !! &stage
      logical, intent(in) :: active(3)               !! Directions that the cell has
      type(drive_t), intent(out) :: drive
      type(group_t) :: parent
      character(len=:), allocatable :: servo
      real(wp) :: rate(6)
      integer :: axis

      parent = deck%group("cell")
      call stage%get("servo", servo)
      drive%isotropic = servo == "isotropic"
      do axis = 1, 3
         if (.not. active(axis)) cycle
         drive%servo(axis) = drive%isotropic .or. index(servo, "xyz"(axis:axis)) > 0
      end do
      call parent%get("pressure", drive%pressure)
      if (stage%given("pressure")) call stage%get("pressure", drive%pressure)
      call stage%get("rate", rate)
      do axis = 1, 3
         drive%gradient(axis, axis) = rate(axis)
      end do
      drive%gradient(1, 2) = rate(4)
      drive%gradient(1, 3) = rate(5)
      drive%gradient(2, 3) = rate(6)
   end subroutine read_drive

   !> Duration of a stage, by its key `duration` or by `strain` and the greatest rate [s].
   real(wp) function stage_duration(stage, drive) result(duration)
      type(group_t), intent(in) :: stage             !! &stage
      type(drive_t), intent(in) :: drive             !! That of the stage
      real(wp) :: strain

      duration = huge(1.0_wp)
      if (stage%given("duration")) call stage%get("duration", duration)
      if (.not. stage%given("strain")) return
      call stage%get("strain", strain)
      duration = min(duration, strain/maxval(abs(drive%gradient)))
   end function stage_duration

   !> Set the rate of the servo, (G.3): the sum of three times the rate at which a wave crosses the
   !! cell and a fifth of the greatest shear rate. With a given time step it is bounded such that
   !! the prescribed stress changes by at most a quarter of its error per step; stiff material then
   !! does not oscillate.
   pure subroutine drive_set_rate(self, density, speed, height, dt)
      class(drive_t), intent(inout) :: self
      real(wp), intent(in) :: density                !! [kg/m3]
      real(wp), intent(in) :: speed                  !! Wave speed [m/s]
      real(wp), intent(in) :: height                 !! Greatest distance of faces [m]
      real(wp), intent(in), optional :: dt           !! Time step [s]

      self%servo_rate = waves*self%pressure/(density*speed*height) &
         + part*maxval(abs(self%gradient))
      if (present(dt)) self%servo_rate = min(self%servo_rate, &
         most*self%pressure/(density*speed**2*dt))
   end subroutine drive_set_rate

   !> Velocity gradient of the next step: the given one, and on servo axes the rate that brings the
   !! stress to its target. Far below the target the cell shrinks faster.
   pure subroutine drive_steer(self, stress, box)
      class(drive_t), intent(in) :: self
      real(wp), intent(in) :: stress(3, 3)           !! Mean of the cell, tension positive [Pa]
      type(box_t), intent(inout) :: box              !! Gets the gradient
      real(wp) :: pressure
      integer :: axis

      box%gradient = self%gradient
      if (.not. any(self%servo)) return
      pressure = 0.0_wp
      do axis = 1, 3
         if (self%servo(axis)) pressure = pressure - stress(axis, axis)
      end do
      pressure = pressure/real(count(self%servo), wp)
      do axis = 1, 3
         if (.not. self%servo(axis)) cycle
         if (.not. self%isotropic) pressure = -stress(axis, axis)
         box%gradient(axis, axis) = response(self, pressure)
      end do
   end subroutine drive_steer

   !> Strain rate of a held axis, (G.3) [1/s].
   pure real(wp) function response(drive, pressure) result(strain_rate)
      type(drive_t), intent(in) :: drive
      real(wp), intent(in) :: pressure               !! Pressure on the axis, or mean pressure [Pa]
      real(wp), parameter :: greatest = 20.0_wp, far = 0.1_wp
      real(wp) :: error

      error = pressure/drive%pressure - 1.0_wp
      strain_rate = drive%servo_rate*min(error, greatest)
      if (pressure < far*drive%pressure) strain_rate = strain_rate &
         *(1.0_wp + (drive%haste - 1.0_wp)*(1.0_wp - pressure/(far*drive%pressure)))
   end function response
end module mesh_drive
