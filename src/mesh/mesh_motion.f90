! SPDX-License-Identifier: BSD-3-Clause
!> Motion of a wall, and the time interval in which it acts. Its position follows from the time
!! alone, so it is not in checkpoints.
module mesh_motion
   use base_kinds, only: wp
   implicit none
   private

   public :: motion_t

   !> A constant velocity, and one from a table that is added to it.
   type :: motion_t
      real(wp) :: steady(3) = 0.0_wp                 !! Constant velocity [m/s]
      real(wp) :: begin = 0.0_wp                     !! The wall acts from this time on [s]
      real(wp) :: end = huge(1.0_wp)                 !! The wall acts until this time [s]
      real(wp), allocatable :: time(:)               !! Times of the table, ascending [s]
      real(wp), allocatable :: speed(:, :)           !! (3, entry) Velocities at these times [m/s]
   contains
      procedure :: acts => motion_acts               !! Does the wall act?
      procedure :: velocity => motion_velocity       !! Velocity at a time
      procedure :: shift => motion_shift             !! Displacement since the wall began
      procedure :: mean => motion_mean               !! Mean velocity over a time interval
      procedure :: moves => motion_moves             !! Does it move at all?
      procedure :: steer => motion_steer             !! Change the velocity from a time on
   end type motion_t

contains

   !> Whether the wall acts.
   elemental logical function motion_acts(self, time) result(acts)
      class(motion_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]

      acts = time >= self%begin .and. time < self%end
   end function motion_acts

   !> Whether the wall moves at some time.
   pure logical function motion_moves(self) result(moves)
      class(motion_t), intent(in) :: self

      moves = any(abs(self%steady) > 0.0_wp)
      if (allocated(self%time)) moves = moves .or. any(abs(self%speed) > 0.0_wp)
   end function motion_moves

   !> Velocity at a time: straight lines between the entries of the table, constant before the
   !! first one and after the last one.
   pure function motion_velocity(self, time) result(velocity)
      class(motion_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]
      real(wp) :: velocity(3)
      integer :: entry

      velocity = self%steady
      if (.not. allocated(self%time)) return
      entry = entry_before(self, time)
      velocity = velocity + value_at(self, entry, time)
   end function motion_velocity

   !> Displacement from the time at which the wall began, or from 0, to another time: the integral
   !! of the velocity, exact but for rounding [m]. Equation (R.4) of doc/theory/rigid.md.
   pure function motion_shift(self, time) result(shift)
      class(motion_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]
      real(wp) :: shift(3)
      real(wp) :: from, until

      from = max(self%begin, 0.0_wp)
      until = min(time, self%end)
      shift = 0.0_wp
      if (.not. until > from) return
      shift = (until - from)*self%steady
      if (allocated(self%time)) shift = shift + table_displacement(self, from, until)
   end function motion_shift

   !> Mean of the velocity over a time interval, whether the wall acts or not: the integral of the
   !! straight lines divided by the interval [m/s].
   pure function motion_mean(self, from, length) result(mean)
      class(motion_t), intent(in) :: self
      real(wp), intent(in) :: from                   !! Begin of the time [s]
      real(wp), intent(in) :: length                 !! Length of the interval, above 0 [s]
      real(wp) :: mean(3)

      mean = self%steady
      if (allocated(self%time)) mean = mean + table_displacement(self, from, from + length)/length
   end function motion_mean

   !> Change the velocity from a given time on: linear over an interval and constant after it. Later
   !! entries of the table are replaced; the displacement so far is kept.
   pure subroutine motion_steer(self, from, over, velocity)
      class(motion_t), intent(inout) :: self
      real(wp), intent(in) :: from                   !! Start of the change [s]
      real(wp), intent(in) :: over                   !! Length of the change, above 0 [s]
      real(wp), intent(in) :: velocity(3)            !! After the change [m/s]
      real(wp) :: now(3)
      integer :: kept

      now = self%velocity(from) - self%steady
      if (.not. allocated(self%time)) allocate (self%time(0), self%speed(3, 0))
      kept = count(self%time < from)
      self%speed = reshape([self%speed(:, :kept), now, velocity - self%steady], [3, kept + 2])
      self%time = [self%time(:kept), from, from + over]
   end subroutine motion_steer

   !> Displacement by the velocity of the table alone [m].
   pure function table_displacement(self, from, until) result(way)
      class(motion_t), intent(in) :: self
      real(wp), intent(in) :: from                   !! [s]
      real(wp), intent(in) :: until                  !! Not before that [s]
      real(wp) :: way(3)
      real(wp) :: left, right
      integer :: entry

      way = 0.0_wp
      ! the intervals before the first entry, between entries, and after the last one
      do entry = 0, size(self%time)
         left = from
         right = until
         if (entry > 0) left = max(left, self%time(entry))
         if (entry < size(self%time)) right = min(right, self%time(entry + 1))
         if (.not. right > left) cycle
         way = way + 0.5_wp*(right - left)*(value_at(self, entry, left) &
            + value_at(self, entry, right))
      end do
   end function table_displacement

   !> Last entry of the table that is not after a time; 0 if all are.
   pure integer function entry_before(self, time) result(entry)
      class(motion_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]
      integer :: low, high, middle

      low = 0
      high = size(self%time) + 1
      do while (high - low > 1)
         middle = (low + high)/2
         if (self%time(middle) <= time) then
            low = middle
         else
            high = middle
         end if
      end do
      entry = low
   end function entry_before

   !> Velocity of the table at a time that follows an entry [m/s].
   pure function value_at(self, entry, time) result(value)
      class(motion_t), intent(in) :: self
      integer, intent(in) :: entry                   !! The one before, 0 = none
      real(wp), intent(in) :: time                   !! [s]
      real(wp) :: value(3)
      real(wp) :: share

      if (entry == 0) then
         value = self%speed(:, 1)
      else if (entry == size(self%time)) then
         value = self%speed(:, entry)
      else
         share = (time - self%time(entry))/(self%time(entry + 1) - self%time(entry))
         value = (1.0_wp - share)*self%speed(:, entry) + share*self%speed(:, entry + 1)
      end if
   end function value_at
end module mesh_motion
