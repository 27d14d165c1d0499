! SPDX-License-Identifier: BSD-3-Clause
!> Expected number of steps of a run, from the first time step and from the impacts that follow from
!! the velocities of the bodies. Section "Number of steps" of doc/theory/time_step.md.
module run_expected_steps
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use material_state, only: material_state_t
   use material_type, only: material_t
   use mesh_moving_cell, only: moving_cell_t
   use particle_body, only: body_t
   use run_limits, only: limits_t
   use step_bounds, only: rule_conduction
   use step_simulation, only: simulation_t
   use step_time_step, only: find_stable_step
   implicit none
   private

   public :: expected_steps, find_first_stable_step, find_first_step, meetings_text

   integer, parameter :: spans = 600                 !! Equal intervals of the time of a run
   real(wp), parameter :: slope = 1.5_wp !! d(shock speed)/d(velocity jump), typical of metals

   !> Bounding boxes of the bodies, and the first impact of each.
   type :: flight_t
      real(wp), allocatable :: low(:, :), high(:, :) !! (3, body) Corners of the boxes [m]
      real(wp), allocatable :: extent(:, :)          !! (3, body) With mirror images [m]
      real(wp), allocatable :: velocity(:, :) !! (3, body) Bodies of one velocity never meet [m/s]
      real(wp), allocatable :: met(:)                !! (body) Time of its first impact [s]
      logical, allocatable :: passes(:)              !! (body) Does it perforate the target?
   end type flight_t

   !> Impact of two bodies.
   type :: meeting_t
      real(wp) :: time = huge(1.0_wp)                !! When their boxes touch, huge = never [s]
      real(wp) :: speed = 0.0_wp                     !! Relative speed [m/s]
      real(wp) :: path(2) = 0.0_wp !! Through each body along the relative velocity [m]
      real(wp) :: fresh = 0.0_wp                     !! Duration of fresh contact [s]
      real(wp) :: lasts = 0.0_wp                     !! Duration of the shock [s]
      integer :: striker = 1                         !! The smaller body: 1 or 2
   end type meeting_t

contains

   !> Expected number of steps.
   pure real(wp) function expected_steps(simulation, bodies, limits) result(steps)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(limits_t), intent(in) :: limits           !! End of the run
      real(wp), parameter :: countless = 1.0e18_wp   ! fits a 64-bit integer
      character(len=:), allocatable :: cause
      real(wp) :: dt, signal(spans)

      call find_first_step(simulation, bodies, limits, dt, cause)
      steps = 0.0_wp
      if (dt > 0.0_wp .and. dt < huge(dt)) then
         signal = 0.0_wp
         if (.not. limits%dt_fixed > 0.0_wp) call find_impacts(simulation, bodies, &
            limits%time_end, signal)
         steps = sum(max(1.0_wp/dt, &
            signal/(simulation%scheme%method%cfl*simulation%space%grid%spacing))) &
            *limits%time_end/real(spans, wp)
         steps = min(steps, countless)
      end if
      if (limits%max_steps < huge(1_int64)) steps = min(steps, real(limits%max_steps, wp))
   end function expected_steps

   !> Fastest signal of impacts in each interval of time, 0 without an impact [m/s].
   pure subroutine find_impacts(simulation, bodies, time_end, signal)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      real(wp), intent(in) :: time_end               !! [s]
      real(wp), intent(inout) :: signal(:)           !! (interval) Raised [m/s]
      type(flight_t) :: flight
      type(meeting_t) :: meeting
      integer :: one, other

      call set_boxes(simulation, bodies, flight)
      do other = 2, size(bodies)
         do one = 1, other - 1
            if (.not. any(abs(flight%velocity(:, one) - flight%velocity(:, other)) > 0.0_wp)) cycle
            meeting = meeting_of(simulation, bodies, flight, one, other)
            if (meeting%time < time_end) call record_first_impact(simulation, bodies, flight, &
               meeting, &
               one, other)
         end do
      end do
      do other = 2, size(bodies)
         do one = 1, other - 1
            if (.not. any(abs(flight%velocity(:, one) - flight%velocity(:, other)) > 0.0_wp)) cycle
            meeting = meeting_of(simulation, bodies, flight, one, other)
            if (meeting%time < time_end) call add_impact(simulation, bodies, flight, meeting, one, &
               other, time_end, signal)
         end do
      end do
      do one = 1, size(bodies)
         call add_wall_impact(simulation, bodies(one), flight%low(:, one), flight%high(:, one), &
            flight%extent(:, one), time_end, signal)
      end do
   end subroutine find_impacts

   !> Bodies without contact that touch or collide slowly: they have one velocity field, so they
   !! stick. In an impact near the speed of sound this has little effect.
   function meetings_text(simulation, bodies, time_end) result(text)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      real(wp), intent(in) :: time_end               !! [s]
      character(len=:), allocatable :: text
      real(wp), parameter :: slow = 0.5_wp           ! fraction of the speed of sound
      type(flight_t) :: flight
      type(meeting_t) :: meeting
      real(wp) :: sound
      integer :: one, other

      text = ""
      if (allocated(simulation%effects%contact)) return
      call set_boxes(simulation, bodies, flight)
      do other = 2, size(bodies)
         do one = 1, other - 1
            if (.not. any(abs(flight%velocity(:, one) - flight%velocity(:, other)) > 0.0_wp)) cycle
            meeting = meeting_of(simulation, bodies, flight, one, other)
            if (.not. meeting%time < time_end) cycle
            sound = min(shocked_sound(simulation%materials(bodies(one)%store), 0.0_wp), &
               shocked_sound(simulation%materials(bodies(other)%store), 0.0_wp))
            if (meeting%speed > slow*sound) cycle
            text = "contact    '"//bodies(one)%name//"' and '"//bodies(other)%name// &
               "' may meet at "//brief(meeting%time)//" s and would then stick together; "// &
               "with &effects contact = .true. they can slide and separate"//new_line("a")
            return
         end do
      end do
   end function meetings_text

   !> Set the boxes of the bodies within the grid.
   pure subroutine set_boxes(simulation, bodies, flight)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(flight_t), intent(out) :: flight          !! Boxes
      logical :: mirrors(6)
      integer :: n, k

      mirrors = [(simulation%space%boundary%mirrors(k), k=1, 6)]
      mirrors(1) = mirrors(1) .or. simulation%space%grid%axisymmetric
      allocate (flight%low(3, size(bodies)), flight%high(3, size(bodies)))
      allocate (flight%velocity(3, size(bodies)))
      allocate (flight%met(size(bodies)), source=huge(1.0_wp))
      allocate (flight%passes(size(bodies)), source=.false.)
      do n = 1, size(bodies)
         call bodies(n)%shape%bounds(flight%low(:, n), flight%high(:, n))
         flight%velocity(:, n) = bodies(n)%velocity
         flight%low(:, n) = max(flight%low(:, n), simulation%space%grid%lower)
         flight%high(:, n) = min(flight%high(:, n), simulation%space%grid%upper)
      end do
      flight%extent = flight%high - flight%low
      do k = 1, 3
         where (flight%low(k, :) <= simulation%space%grid%lower(k) .and. mirrors(2*k - 1)) &
            flight%extent(k, :) = 2.0_wp*flight%extent(k, :)
         where (flight%high(k, :) >= simulation%space%grid%upper(k) .and. mirrors(2*k)) &
            flight%extent(k, :) = 2.0_wp*flight%extent(k, :)
      end do
   end subroutine set_boxes

   !> Time and conditions of the impact of two bodies, from their bounding boxes.
   pure type(meeting_t) function meeting_of(simulation, bodies, flight, one, other) &
      result(meeting)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(flight_t), intent(in) :: flight           !! Boxes
      integer, intent(in) :: one                     !! Body
      integer, intent(in) :: other                   !! Body
      real(wp) :: coming(3), begin, end, gap(2), volume(2), size_of(2), width, slide
      integer :: k, axis, striker

      coming = bodies(one)%velocity - bodies(other)%velocity
      where (.not. simulation%space%grid%active) coming = 0.0_wp
      meeting%speed = norm2(coming)
      if (.not. meeting%speed > 0.0_wp) return
      begin = 0.0_wp
      end = huge(end)
      volume = 1.0_wp
      meeting%path = huge(1.0_wp)
      axis = maxloc(abs(coming), dim=1)
      do k = 1, 3
         if (.not. simulation%space%grid%active(k)) cycle
         size_of = [flight%extent(k, one), flight%extent(k, other)]
         volume = volume*size_of
         ! lower side of the other from the upper one of this body, and the reverse
         gap = [flight%low(k, other) - flight%high(k, one), &
            flight%high(k, other) - flight%low(k, one)]
         if (abs(coming(k)) > 1.0e-12_wp*meeting%speed) then
            gap = gap/coming(k)
            ! the boxes first touch across the axis whose gap closes last
            if (minval(gap) > begin) axis = k
            begin = max(begin, minval(gap))
            end = min(end, maxval(gap))
            meeting%path = min(meeting%path, size_of*meeting%speed/abs(coming(k)))
         else if (gap(1) >= 0.0_wp .or. gap(2) <= 0.0_wp) then
            return
         end if
      end do
      if (.not. end > begin) return
      ! overlapping boxes belong to bodies in contact, which may be separating
      if (.not. begin > 0.0_wp .and. .not. dot_product(coming, flight%low(:, other) &
         + flight%high(:, other) - flight%low(:, one) - flight%high(:, one)) > 0.0_wp) return
      meeting%time = begin
      meeting%striker = merge(2, 1, volume(2) < volume(1))
      striker = merge(other, one, meeting%striker == 2)
      width = minval(flight%extent(:, striker), mask=simulation%space%grid%active)
      ! a body that slides along the surface makes fresh contact over its whole length
      slide = sqrt(max(1.0_wp - (coming(axis)/meeting%speed)**2, 0.0_wp)) &
         *flight%extent(axis, striker)
      meeting%fresh = 0.5_wp*(width + slide)/abs(coming(axis))
      meeting%lasts = (min(width, 0.5_wp*width + flight%extent(axis, one + other - striker)) &
         + slide)/abs(coming(axis))
   end function meeting_of

   !> Record the first impact of the striker. It perforates the target if it has more mass per area
   !! along its path.
   pure subroutine record_first_impact(simulation, bodies, flight, meeting, one, other)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(flight_t), intent(inout) :: flight        !! Changed
      type(meeting_t), intent(in) :: meeting         !! Meeting of the two bodies
      integer, intent(in) :: one                     !! Body
      integer, intent(in) :: other                   !! Body
      real(wp) :: mass(2)
      integer :: striker

      striker = merge(one, other, meeting%striker == 1)
      if (meeting%time >= flight%met(striker)) return
      flight%met(striker) = meeting%time
      mass = meeting%path*[simulation%materials(bodies(one)%store)%density, &
         simulation%materials(bodies(other)%store)%density]
      flight%passes(striker) = mass(meeting%striker) > mass(3 - meeting%striker)
   end subroutine record_first_impact

   !> Raise the signal for the duration of an impact of two bodies. Equation (S.5).
   pure subroutine add_impact(simulation, bodies, flight, meeting, one, other, time_end, signal)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(flight_t), intent(in) :: flight           !! First meetings
      type(meeting_t), intent(in) :: meeting         !! Meeting of the two bodies
      integer, intent(in) :: one                     !! Body
      integer, intent(in) :: other                   !! Body
      real(wp), intent(in) :: time_end               !! [s]
      real(wp), intent(inout) :: signal(:)           !! (interval) Raised [m/s]
      real(wp), parameter :: stretch = 2.0_wp/3.0_wp ! length of a debris cloud over its path
      real(wp) :: coming(3), impedance(2), share(2), moving(3), later, contact, shock
      integer :: body(2), k, striker

      body = [one, other]
      striker = body(meeting%striker)
      later = 0.0_wp
      if (meeting%time > flight%met(striker)) then
         if (.not. flight%passes(striker)) return
         later = stretch*(meeting%time - flight%met(striker))
      end if
      do k = 1, 2
         associate (material => simulation%materials(bodies(body(k))%store))
            impedance(k) = material%density*material%reference_speed()
         end associate
      end do
      share = impedance(2:1:-1)/max(sum(impedance), tiny(1.0_wp))
      coming = bodies(one)%velocity - bodies(other)%velocity
      contact = 0.0_wp
      shock = 0.0_wp
      do k = 1, 2
         ! velocity in the middle of the jump
         moving = bodies(body(k))%velocity - merge(0.5_wp, -0.5_wp, k == 1)*share(k)*coming
         associate (material => simulation%materials(bodies(body(k))%store), &
            jump => share(k)*meeting%speed)
            contact = max(contact, norm2(moving) + contact_signal(material, meeting%speed, jump))
            shock = max(shock, norm2(moving) + shock_signal(material, jump))
         end associate
      end do
      call raise_signal(meeting%time, meeting%fresh + later, contact, time_end, signal)
      call raise_signal(meeting%time, meeting%lasts + later, shock, time_end, signal)
   end subroutine add_impact
   !> Raise the signal for the impact of a body on closed boundaries or a rigid region.
   pure subroutine add_wall_impact(simulation, body, low, high, extent, time_end, signal)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: body
      real(wp), intent(in) :: low(3)                 !! Corner of its box [m]
      real(wp), intent(in) :: high(3)                !! The opposite corner [m]
      real(wp), intent(in) :: extent(3)              !! With mirror images [m]
      real(wp), intent(in) :: time_end               !! [s]
      real(wp), intent(inout) :: signal(:)           !! (interval) Raised [m/s]
      real(wp) :: speed, gap, moving
      integer :: k, face

      associate (material => simulation%materials(body%store))
         if (allocated(simulation%space%rigid)) then
            speed = norm2(body%velocity)
            if (speed > 0.0_wp) call raise_signal(0.0_wp, time_end, &
               0.5_wp*speed + shock_signal(material, speed), time_end, signal)
         end if
         do k = 1, 3
            if (.not. simulation%space%grid%active(k)) cycle
            speed = abs(body%velocity(k))
            if (.not. speed > 0.0_wp) cycle
            face = merge(2*k - 1, 2*k, body%velocity(k) < 0.0_wp)
            if (.not. simulation%space%boundary%is_closed(face)) cycle
            if (simulation%space%boundary%moves(face)) cycle
            gap = merge(low(k) - simulation%space%grid%lower(k), simulation%space%grid%upper(k) - &
               high(k), &
               body%velocity(k) < 0.0_wp)
            moving = norm2(body%velocity) - 0.5_wp*speed
            call raise_signal(gap/speed, 0.5_wp*minval(extent, &
               mask=simulation%space%grid%active)/speed, &
               moving + contact_signal(material, speed, speed), time_end, signal)
            call raise_signal(gap/speed, (high(k) - low(k))/speed, &
               moving + shock_signal(material, speed), time_end, signal)
         end do
      end associate
   end subroutine add_wall_impact

   !> Raise the signal in an interval of time.
   pure subroutine raise_signal(begin, lasts, fastest, time_end, signal)
      real(wp), intent(in) :: begin                  !! [s]
      real(wp), intent(in) :: lasts                  !! [s]
      real(wp), intent(in) :: fastest                !! Signal in this interval [m/s]
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(inout) :: signal(:)           !! (interval) [m/s]
      integer :: first, last

      if (.not. begin < time_end) return
      first = int(max(begin, 0.0_wp)/time_end*real(size(signal), wp)) + 1
      last = nint(min(begin + lasts, time_end)/time_end*real(size(signal), wp))
      last = min(max(last, first), size(signal))
      signal(first:last) = max(signal(first:last), fastest)
   end subroutine raise_signal

   !> Wave speed with artificial viscosity where surfaces collide [m/s]. Equation (S.5).
   pure real(wp) function contact_signal(material, closing, jump) result(speed)
      type(material_t), intent(in) :: material
      real(wp), intent(in) :: closing                !! Impact speed of the surfaces [m/s]
      real(wp), intent(in) :: jump                   !! Velocity jump of this material [m/s]
      real(wp), parameter :: width = 3.0_wp          ! over which the velocity changes [cells]
      real(wp) :: damping, sound

      sound = shocked_sound(material, jump)
      speed = sound
      if (.not. allocated(material%viscosity)) return
      associate (q1 => material%viscosity%linear, q2 => material%viscosity%quadratic)
         if (.not. q1 + q2 > 0.0_wp) return
         damping = q1*sound + 2.0_wp*q2*closing/width
      end associate
      speed = damping + sqrt(damping**2 + sound**2)
   end function contact_signal

   !> Wave speed with artificial viscosity in the middle of a steady shock [m/s]. Equation (S.4).
   pure real(wp) function shock_signal(material, jump) result(speed)
      type(material_t), intent(in) :: material
      real(wp), intent(in) :: jump                   !! Velocity jump of this material [m/s]
      real(wp) :: damping, sound

      sound = shocked_sound(material, jump)
      speed = sound
      if (.not. allocated(material%viscosity)) return
      associate (q1 => material%viscosity%linear, q2 => material%viscosity%quadratic)
         if (.not. q1 + q2 > 0.0_wp) return
         ! 2 q2 h D of the steady profile, whose q has its maximum rho slope jump^2/2 in the middle
         damping = sqrt((q1*sound)**2 + 2.0_wp*q2*slope*jump**2)
      end associate
      speed = damping + sqrt(damping**2 + sound**2)
   end function shock_signal

   !> Wave speed halfway up a shock [m/s].
   pure real(wp) function shocked_sound(material, jump) result(sound)
      type(material_t), intent(in) :: material
      real(wp), intent(in) :: jump                   !! Velocity jump of this material [m/s]

      sound = material%reference_speed() + (slope - 0.5_wp)*jump
   end function shocked_sound

   !> Find the first time step.
   pure subroutine find_first_step(simulation, bodies, limits, dt, cause)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(limits_t), intent(in) :: limits           !! Bounds of the step
      real(wp), intent(out) :: dt                    !! [s]
      !> Limit of the step, empty for the wave speed
      character(len=:), allocatable, intent(out) :: cause

      call find_first_stable_step(simulation, bodies, simulation%scheme%method%cfl, &
         simulation%clock%guard%bounds%strain_max, dt, cause)
      if (limits%dt_fixed > 0.0_wp) then
         dt = limits%dt_fixed
         cause = " (dt_fixed)"
      end if
      dt = min(dt, limits%dt_max)
   end subroutine find_first_step

   !> Stable time step of the first state, as `first_step` of scene_particles finds it from the
   !! particles.
   pure subroutine find_first_stable_step(simulation, bodies, courant, strain, dt, cause)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      real(wp), intent(in) :: courant                !! Courant number
      real(wp), intent(in) :: strain                 !! Greatest strain of a cell in a step [1]
      real(wp), intent(out) :: dt                    !! [s]
      !> Limit of the step, empty for the wave speed
      character(len=:), allocatable, intent(out) :: cause
      type(moving_cell_t) :: cell
      type(material_state_t) :: state
      real(wp) :: densest, fastest, diffusivity, greatest, signal, stable
      integer :: n, rule

      densest = 0.0_wp
      fastest = 0.0_wp
      greatest = 0.0_wp
      diffusivity = 0.0_wp
      do n = 1, size(bodies)
         associate (material => simulation%materials(bodies(n)%store))
            call material%allocate_state(state, 1)
            state%mass = material%density
            state%volume = 1.0_wp
            call material%start(state, 1, 1, bodies(n)%temperature)
            if (bodies(n)%energy > 0.0_wp .and. allocated(state%energy)) &
               state%energy = bodies(n)%energy
            signal = material%signal_speed(state, 1, 1)
            densest = max(densest, material%density)
            greatest = max(greatest, signal)
            fastest = max(fastest, signal + norm2(bodies(n)%velocity))
            if (allocated(material%heat)) diffusivity = max(diffusivity, &
               material%heat%conductivity/(material%density*material%heat%specific_heat))
         end associate
      end do
      call find_stable_step(simulation%space, courant, fastest, diffusivity, dt, rule)
      cause = ""
      if (rule == rule_conduction) cause = " (heat conduction)"
      if (.not. allocated(simulation%space%cell)) return
      ! the mass is only used where a servo holds the stress
      cell = simulation%space%cell
      cell%speed = greatest
      cell%mass = densest*cell%box%volume()
      stable = dt
      call cell%begin(strain, dt)
      if (dt < stable) cause = " (strain of the cell)"
   end subroutine find_first_stable_step
end module run_expected_steps
