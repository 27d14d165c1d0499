! SPDX-License-Identifier: BSD-3-Clause
!> One material point that is driven along a path, without grid, with the same update as particles.
!!
!! The energy, if carried, increases by the work of the mean of the stresses before and after a
!! step.
module material_point
   use base_kinds, only: wp
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use material_state, only: deformation_t, has_energy, material_state_t
   use material_update, only: chain_t
   implicit none
   private

   public :: point_t

   !> A material point and its strain path.
   type :: point_t
      character(len=:), allocatable :: path          !! Word of the deck
      real(wp) :: rate = 1.0_wp                      !! Rate of strain or shear [1/s]
      real(wp) :: strain = 0.0_wp                    !! At the end, logarithmic or of shear [1]
      integer :: steps = 100                         !! From the start to it
      logical :: returns = .false.                   !! And back again, in as many steps
      real(wp) :: confinement = 0.0_wp               !! Pressure from the sides [Pa]
      real(wp) :: direction(9) = 0.0_wp !! Velocity gradient over the rate, k + 3 (l - 1) [1]
      real(wp) :: speed = 0.0_wp                     !! Greatest particle speed of shocks [m/s]
      real(wp) :: temperature = 293.0_wp             !! Temperature at the start [K]
      real(wp) :: volume = 1.0e-9_wp                 !! Volume at the start [m3]
      type(material_state_t) :: state                       !! State
      type(deformation_t) :: deformation             !! Step
   contains
      procedure :: start => point_start              !! Sets the point to rest
      procedure :: run => point_run                  !! Drives it along its path
      procedure :: header => point_header            !! Names of the columns
      procedure, private :: row => point_row         !! State as numbers
   end type point_t

   integer, parameter :: most_iterations = 100

contains

   !> Put the point at rest.
   pure subroutine point_start(self, chain)
      class(point_t), intent(inout) :: self
      class(chain_t), intent(in) :: chain

      call chain%allocate_state(self%state, 1)
      call self%deformation%reserve(1)
      self%state%volume = self%volume
      self%state%mass = chain%free_density(self%temperature)*self%volume
      call chain%start(self%state, 1, 1, self%temperature)
      if (chain%starts_with_stress() .or. has_energy(self%state, 1, 1)) &
         call chain%find_rest_stress(self%state, 1, 1)
      self%deformation%gradient = 0.0_wp
      self%deformation%wave_speed(1) = chain%signal_speed(self%state, 1, 1)
      select case (self%path)
      case ("uniaxial_strain", "triaxial")
         self%direction = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      case ("hydrostatic")
         self%direction = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp] &
            /3.0_wp
      case ("shear")
         self%direction = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      case default
      end select
   end subroutine point_start

   !> Drive the point; a row of the table for the start and one for each step.
   pure subroutine point_run(self, chain, table)
      class(point_t), intent(inout) :: self
      class(chain_t), intent(in) :: chain
      real(wp), allocatable, intent(out) :: table(:, :) !! (column, row)
      real(wp) :: increment, dt, lateral, done
      integer :: step, steps

      call self%start(chain)
      if (self%path == "hugoniot") then
         call shock(self, chain, table)
         return
      end if
      lateral = 0.0_wp
      if (self%path == "triaxial") call confine(self, chain)
      steps = merge(2, 1, self%returns)*self%steps
      allocate (table(size(self%row(0.0_wp, 0.0_wp)), steps + 1))
      dt = abs(self%strain/(self%rate*real(self%steps, wp)))
      table(:, 1) = self%row(0.0_wp, 0.0_wp)
      done = 0.0_wp
      do step = 1, steps
         increment = self%strain/real(self%steps, wp)
         if (step > self%steps) increment = -increment
         if (self%path == "triaxial") then
            call balance(self, chain, increment*self%direction, [5, 9], dt, lateral)
         else
            call advance(chain, increment*self%direction, dt, self%state, self%deformation)
         end if
         done = done + increment
         table(:, step + 1) = self%row(real(step, wp)*dt, done)
      end do
   end subroutine point_run

   !> One step with a gradient that refers to its middle.
   pure subroutine advance(chain, gradient, dt, state, deformation)
      class(chain_t), intent(in) :: chain
      real(wp), intent(in) :: gradient(9)                !! dt du_k/dx_l [1]
      real(wp), intent(in) :: dt                         !! Time step [s]
      type(material_state_t), intent(inout) :: state            !! State of the point
      type(deformation_t), intent(inout) :: deformation  !! Step of the point
      real(wp), parameter :: spacing = 1.0e-3_wp !! Cell size, for the width of cracks [m]
      type(material_state_t) :: before
      real(wp) :: volume, power
      integer :: pass

      before = state
      volume = before%volume(1)*(1.0_wp + 0.5_wp*(gradient(1) + gradient(5) + gradient(9)))
      do pass = 1, 4
         if (pass > 1 .and. .not. allocated(state%energy)) exit
         power = 0.5_wp*(work(before%stress(1, :), gradient) + work(state%stress(1, :), gradient))
         state = before
         if (allocated(state%energy)) &
            state%energy(1) = before%energy(1) + volume*power/state%mass(1)
         deformation%gradient(1, :) = gradient
         call chain%update(state, deformation, 1, 1, dt, spacing)
      end do
   end subroutine advance

   !> Stress times gradient.
   pure real(wp) function work(stress, gradient) result(product_of_both)
      real(wp), intent(in) :: stress(:)                  !! [Pa]
      real(wp), intent(in) :: gradient(9)                !! [1]

      product_of_both = stress(1)*gradient(1) + stress(2)*gradient(5) + stress(3)*gradient(9) &
         + stress(4)*(gradient(2) + gradient(4)) + stress(5)*(gradient(6) + gradient(8)) &
         + stress(6)*(gradient(3) + gradient(7))
   end function work

   !> One step in which some diagonal components of the gradient, all the same, hold the lateral
   !! pressure: secant method, with bisection where it leaves the bracket.
   pure subroutine balance(point, chain, gradient, components, dt, lateral)
      type(point_t), intent(inout) :: point
      class(chain_t), intent(in) :: chain
      real(wp), intent(in) :: gradient(9)            !! The other components [1]
      integer, intent(in) :: components(:)           !! Components to find
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), intent(inout) :: lateral             !! Last and new value [1]
      type(material_state_t) :: before
      real(wp) :: whole(9), low, high, excess, width, slope
      integer :: iteration

      before = point%state
      whole = gradient
      slope = chain%bulk + 4.0_wp/3.0_wp*chain%shear
      width = 4.0_wp*(maxval(abs(gradient)) + abs(lateral)) &
         + 4.0_wp*abs(before%stress(1, 2) + point%confinement)/slope
      low = lateral - width
      high = lateral + width
      do iteration = 1, most_iterations
         lateral = 0.5_wp*(low + high)
         whole(components) = lateral
         point%state = before
         call advance(chain, whole, dt, point%state, point%deformation)
         excess = point%state%stress(1, 2) + point%confinement
         if (abs(excess) <= 1.0e-12_wp*slope*width) exit
         if (excess > 0.0_wp) then
            high = lateral
         else
            low = lateral
         end if
      end do
   end subroutine balance

   !> Load the point from all sides, from the pressure that it has.
   pure subroutine confine(point, chain)
      type(point_t), intent(inout) :: point
      class(chain_t), intent(in) :: chain
      integer, parameter :: steps = 50
      real(wp) :: lateral, whole, none(9), from
      integer :: step

      if (.not. point%confinement > 0.0_wp) return
      lateral = 0.0_wp
      none = 0.0_wp
      whole = point%confinement
      from = -sum(point%state%stress(1, 1:3))/3.0_wp
      do step = 1, steps
         point%confinement = from + (whole - from)*real(step, wp)/real(steps, wp)
         call balance(point, chain, none, [1, 5, 9], 1.0_wp/point%rate, lateral)
      end do
   end subroutine confine

   !> States behind shocks of growing speed u in material at rest: p = rho0 u**2/(1 - r) and e =
   !! u**2/2 with r = rho0/rho, where p is that of the material update.
   pure subroutine shock(point, chain, table)
      type(point_t), intent(inout) :: point
      class(chain_t), intent(in) :: chain
      real(wp), allocatable, intent(out) :: table(:, :) !! (column, row)
      real(wp), parameter :: densest = 0.02_wp       ! least ratio of the densities
      real(wp) :: low, high, ratio, speed, pressure, density
      integer :: step, iteration

      allocate (table(5, point%steps))
      do step = 1, point%steps
         speed = point%speed*real(step, wp)/real(point%steps, wp)
         low = densest
         high = 1.0_wp
         do iteration = 1, most_iterations
            ratio = 0.5_wp*(low + high)
            call point%start(chain)
            density = point%state%mass(1)/point%volume
            point%state%volume = point%volume*ratio
            if (allocated(point%state%energy)) point%state%energy = &
               chain%start_energy(point%temperature) + 0.5_wp*speed**2
            call chain%find_rest_stress(point%state, 1, 1)
            pressure = -sum(point%state%stress(1, 1:3))/3.0_wp
            ! Outside its range a table has no pressure; such a state counts as too dense.
            if (ieee_is_nan(pressure)) then
               low = ratio
            else if (pressure*(1.0_wp - ratio) > density*speed**2) then
               low = ratio
            else
               high = ratio
            end if
         end do
         ! no state has the pressure of this speed
         if (ratio < 1.001_wp*densest) pressure = ieee_value(pressure, ieee_quiet_nan)
         table(:, step) = [speed, speed/(1.0_wp - ratio), pressure, density/ratio, &
            0.5_wp*speed**2]
      end do
   end subroutine shock

   !> Names of the columns, with commas between them.
   pure function point_header(self) result(text)
      class(point_t), intent(in) :: self             !! The point, started
      character(len=:), allocatable :: text
      integer :: i

      if (self%path == "hugoniot") then
         text = "particle_speed,shock_speed,pressure,density,energy"
         return
      end if
      text = "time,strain,density,xx,yy,zz,xy,yz,xz,pressure,mises,wave_speed"
      if (allocated(self%state%energy)) text = text//",energy"
      if (allocated(self%state%temperature)) text = text//",temperature"
      if (allocated(self%state%plastic_strain)) text = text//",plastic_strain"
      if (allocated(self%state%damage)) text = text//",damage"
      if (allocated(self%state%failed)) text = text//",failed"
      do i = 1, size(self%state%own)
         text = text//","//trim(self%state%own(i)%name)
      end do
      if (allocated(self%state%porosity)) text = text//",porosity"
      if (allocated(self%state%solid_fraction)) text = text//",solid_fraction"
   end function point_header

   !> The state as numbers.
   pure function point_row(self, time, strain) result(row)
      class(point_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(in) :: strain                 !! [1]
      real(wp), allocatable :: row(:)
      real(wp) :: pressure, mises
      integer :: i

      associate (state => self%state)
         pressure = -sum(state%stress(1, 1:3))/3.0_wp
         mises = sqrt(1.5_wp*(sum((state%stress(1, 1:3) + pressure)**2) &
            + 2.0_wp*sum(state%stress(1, 4:6)**2)))
         row = [time, strain, state%mass(1)/state%volume(1), state%stress(1, :), pressure, &
            mises, self%deformation%wave_speed(1)]
         if (allocated(state%energy)) row = [row, state%energy(1)]
         if (allocated(state%temperature)) row = [row, state%temperature(1)]
         if (allocated(state%plastic_strain)) row = [row, state%plastic_strain(1)]
         if (allocated(state%damage)) row = [row, state%damage(1)]
         if (allocated(state%failed)) row = [row, real(state%failed(1), wp)]
         do i = 1, size(state%own)
            row = [row, state%own(i)%values(1)]
         end do
         if (allocated(state%porosity)) row = [row, state%porosity(1)]
         if (allocated(state%solid_fraction)) row = [row, state%solid_fraction(1)]
      end associate
   end function point_row
end module material_point
