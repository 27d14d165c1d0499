! SPDX-License-Identifier: BSD-3-Clause
!> The reduction at the end of a step, in which the ranks agree on the next time step and on
!! requests. Meanwhile the particles that change ranks are on the way: the end of the reduction is
!! also the end of their exchange.
module step_agreement
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use particle_inflow, only: inflow_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: agree_with_ranks, extremes_t

   !> Extremes over the particles of this rank, or of all ranks.
   type :: extremes_t
      real(wp) :: fastest = 0.0_wp                   !! Greatest speed of signal and motion [m/s]
      real(wp) :: diffusivity = 0.0_wp               !! Greatest diffusivity [m2/s]
      real(wp) :: rate = 0.0_wp                      !! Steepest velocity gradient [1/s]
      real(wp) :: load_work = 0.0_wp !! Greatest work of loads on a particle in the step [J/kg]
      logical :: retired = .false.                   !! Have particles been removed?
      logical :: approached = .false.                !! Are particles near walls not yet reached?
   contains
      procedure :: sound => extremes_sound           !! Are all values in their bounds?
   end type extremes_t

contains

   !> True unless some value is NaN or infinite, which is an infinite speed.
   pure logical function extremes_sound(self) result(sound)
      class(extremes_t), intent(in) :: self

      sound = self%fastest < huge(self%fastest)
   end function extremes_sound

   !> Agree with the other ranks on the extremes and on requests, and send the particles that left
   !! their tiles; `sort_particles` takes those that arrive. Particles that will be halved are sent
   !! afterwards. After an error the particles are as before, and those on the way are dropped.
   subroutine agree_with_ranks(simulation, began, extremes)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: began                  !! Begin of the step [s]
      type(extremes_t), intent(inout) :: extremes    !! Of this rank in, of all ranks out
      real(wp) :: values(12)
      logical :: feeds

      if (simulation%machine%communicator%size == 1) return
      associate (requests => simulation%machine%requests, machine => simulation%machine, &
         guard => simulation%clock%guard, leavers => simulation%leavers)
         leavers%sent = .false.
         if (.not. allocated(simulation%scheme%method%splitting)) &
            call send_leavers(simulation, extremes%sound())
         call find_feeding(simulation%space%grid, simulation%effects%inflows, began, &
            simulation%clock%time, feeds)
         values = [extremes%fastest, requests%leave, requests%line, requests%checkpoint, &
            extremes%diffusivity, extremes%rate, flag(extremes%retired), requests%present, &
            extremes%load_work, flag(leavers%renew), flag(feeds), &
            flag(extremes%approached)]
         call machine%timer%start(machine%phase%wait)
         if (leavers%sent) then
            call leavers%receive(machine%communicator, simulation%stores, values)
         else
            call machine%communicator%maxima(values)
         end if
         call machine%timer%stop(machine%phase%wait)
         extremes%fastest = values(1)
         requests%leave = values(2)
         requests%line = values(3)
         requests%checkpoint = values(4)
         extremes%diffusivity = values(5)
         if (extremes%rate < values(6)) guard%steepest = huge(1_int64)
         extremes%rate = values(6)
         extremes%retired = values(7) > 0.0_wp
         requests%present = values(8)
         extremes%load_work = values(9)
         leavers%renew = values(10) > 0.0_wp
         leavers%further = values(11) > 0.0_wp
         extremes%approached = values(12) > 0.0_wp
      end associate
   end subroutine agree_with_ranks

   !> Send the particles that left their tiles to other ranks. If values of this rank are not sound,
   !! positions may not be either; the step will fail, and none are sent.
   subroutine send_leavers(simulation, sound)
      type(simulation_t), intent(inout) :: simulation
      logical, intent(in) :: sound                   !! Are the values of this rank?

      associate (machine => simulation%machine, space => simulation%space, &
         leavers => simulation%leavers)
         call machine%timer%start(machine%phase%sort)
         if (sound) then
            call leavers%send(machine%communicator, space%grid, space%boundary, space%tiles, &
               simulation%stores, space%halo%links)
         else
            call leavers%send_none(machine%communicator, simulation%stores)
         end if
         leavers%sent = .true.
         call machine%timer%stop(machine%phase%sort)
      end associate
   end subroutine send_leavers

   !> Find whether particles will enter on this rank at the end of the step.
   subroutine find_feeding(grid, inflows, began, time, feeds)
      type(grid_t), intent(in) :: grid
      type(inflow_t), allocatable, intent(inout) :: inflows(:) !! Their particles get positions
      real(wp), intent(in) :: began                  !! Begin of the step [s]
      real(wp), intent(in) :: time                   !! Its end [s]
      logical, intent(out) :: feeds
      integer, allocatable :: particle(:)
      integer :: n

      feeds = .false.
      if (.not. allocated(inflows)) return
      do n = 1, size(inflows)
         call inflows(n)%enter(grid, began, time, particle)
         feeds = feeds .or. size(particle) > 0
      end do
   end subroutine find_feeding

   !> A condition as a number, for a maximum.
   elemental real(wp) function flag(condition) result(number)
      logical, intent(in) :: condition

      number = merge(1.0_wp, 0.0_wp, condition)
   end function flag
end module step_agreement
