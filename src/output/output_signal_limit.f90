! SPDX-License-Identifier: BSD-3-Clause
!> Detects a few fast or stiff particles that shorten the steps of a run.
!!
!! A step is limited by the greatest sum of wave speed and speed of any particle. Where at most one
!! particle in a hundred is faster than a fraction 1/f of it, all others would allow steps f times
!! longer; the greatest such f of a list is found. Wave speeds are those of the state at the end,
!! without artificial viscosity.
module output_signal_limit
   use base_kinds, only: int64, wp
   use base_log, only: log_t
   use base_text, only: number
   use io_summary, only: json_t
   use step_bounds, only: rule_signal
   use step_offending_particle, only: name_limiting
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: add_signal_limit, find_signal_limit, signal_limit_t

   real(wp), parameter :: factors(7) = [1.25_wp, 1.5_wp, 2.0_wp, 3.0_wp, 5.0_wp, 10.0_wp, 30.0_wp]
   integer, parameter :: hundred = 100               !! Few: at most one particle in this number

   !> Cost of few particles that limit the steps.
   type :: signal_limit_t
      integer(int64) :: particles = 0                !! That limit the steps; 0 if many
      integer(int64) :: all = 0                      !! Total number
      real(wp) :: factor = 1.0_wp                    !! Ratio of step lengths without them [1]
   end type signal_limit_t

contains

   !> Find whether few particles limit the steps, and name the fastest one if so. Collective.
   subroutine find_signal_limit(simulation, log, limit)
      type(simulation_t), intent(in) :: simulation   !! The run at its end
      type(log_t), intent(inout) :: log              !! Receives a line if they do
      type(signal_limit_t), intent(out) :: limit     !! Cost of the few particles
      character(len=:), allocatable :: text

      call count_few(simulation, limit)
      if (limit%particles == 0) return
      call signal_text(simulation, limit, text)
      call log%info(text)
   end subroutine find_signal_limit

   !> Count the particles that limit the steps.
   subroutine count_few(simulation, limit)
      type(simulation_t), intent(in) :: simulation
      type(signal_limit_t), intent(out) :: limit
      real(wp), allocatable :: wave(:, :), bound(:, :)
      real(wp) :: fastest
      integer(int64) :: counts(2)
      integer :: n

      associate (guard => simulation%clock%guard)
         if (2*guard%steps(rule_signal) <= sum(guard%steps)) return
      end associate
      call find_bounds(simulation, wave, bound)
      fastest = simulation%machine%communicator%maximum(fastest_particle(simulation, wave, bound))
      if (.not. (fastest > 0.0_wp .and. fastest < huge(1.0_wp))) return
      counts = 0
      do n = 1, size(simulation%stores)
         counts(2) = counts(2) + sum(int(simulation%stores(n)%count, int64))
      end do
      call simulation%machine%communicator%total(counts)
      do n = 1, size(factors)
         counts(1) = count_faster(simulation, wave, bound, fastest/factors(n), counts(2)/hundred)
         call simulation%machine%communicator%total(counts(1:1))
         if (hundred*counts(1) > counts(2)) return
         limit = signal_limit_t(counts(1), counts(2), factors(n))
      end do
   end subroutine count_few

   !> Greatest wave speed in each tile, and bounds of wave speed and speed of its particles [m/s].
   subroutine find_bounds(simulation, wave, bound)
      type(simulation_t), intent(in) :: simulation
      real(wp), allocatable, intent(out) :: wave(:, :)  !! (tile, store)
      real(wp), allocatable, intent(out) :: bound(:, :) !! (tile, store)
      integer :: index, tile, first, last

      allocate (wave(simulation%space%tiles%own, size(simulation%stores)), source=0.0_wp)
      allocate (bound, source=wave)
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            do tile = 1, size(bound, 1)
               if (store%count(tile) == 0) cycle
               first = store%first(tile)
               last = first + store%count(tile) - 1
               wave(tile, index) = simulation%materials(index)%signal_speed(store%state, first, &
                  last)
               bound(tile, index) = wave(tile, index) + sqrt(maxval(store%velocity(first:last, &
                  1)**2 + store%velocity(first:last, 2)**2 + store%velocity(first:last, 3)**2))
            end do
         end associate
      end do
   end subroutine find_bounds

   !> Wave speed plus speed of a particle. The wave speed of one particle is costly, so it is added
   !! only if the sum can exceed a given speed by the bound of the tile; otherwise the result is the
   !! speed alone.
   pure real(wp) function signal_of(simulation, index, p, wave, above) result(signal)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: p                       !! Index of the particle
      real(wp), intent(in) :: wave                   !! Greatest wave speed in its tile [m/s]
      real(wp), intent(in) :: above !! Speed that the sum must be able to exceed [m/s]

      associate (velocity => simulation%stores(index)%velocity)
         signal = norm2([velocity(p, 1), velocity(p, 2), velocity(p, 3)])
      end associate
      if (signal + wave > above) signal = signal &
         + simulation%materials(index)%signal_speed(simulation%stores(index)%state, p, p)
   end function signal_of

   !> Greatest signal speed of the particles of this rank [m/s].
   real(wp) function fastest_particle(simulation, wave, bound) result(fastest)
      type(simulation_t), intent(in) :: simulation
      real(wp), intent(in) :: wave(:, :)             !! (tile, store) [m/s]
      real(wp), intent(in) :: bound(:, :)            !! (tile, store) [m/s]
      integer :: index, tile, p

      fastest = 0.0_wp
      do index = 1, size(bound, 2)
         associate (store => simulation%stores(index))
            do tile = 1, size(bound, 1)
               if (.not. bound(tile, index) > fastest) cycle
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  fastest = max(fastest, signal_of(simulation, index, p, wave(tile, index), &
                     fastest))
               end do
            end do
         end associate
      end do
   end function fastest_particle

   !> Number of particles of this rank with a greater signal speed. The count ends when it exceeds
   !! the number that counts as few.
   integer(int64) function count_faster(simulation, wave, bound, speed, few) result(number)
      type(simulation_t), intent(in) :: simulation
      real(wp), intent(in) :: wave(:, :)             !! (tile, store) [m/s]
      real(wp), intent(in) :: bound(:, :)            !! (tile, store) [m/s]
      real(wp), intent(in) :: speed                  !! [m/s]
      integer(int64), intent(in) :: few              !! Greatest number that counts as few
      integer :: index, tile, p

      number = 0
      do index = 1, size(bound, 2)
         associate (store => simulation%stores(index))
            do tile = 1, size(bound, 1)
               if (.not. bound(tile, index) > speed) cycle
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (signal_of(simulation, index, p, wave(tile, index), speed) > speed) &
                     number = number + 1
               end do
               if (number > few) return
            end do
         end associate
      end do
   end function count_faster

   !> Line for the end table, with the fastest particle. Collective.
   subroutine signal_text(simulation, limit, text)
      type(simulation_t), intent(in) :: simulation   !! The run at its end
      type(signal_limit_t), intent(in) :: limit      !! The same on all ranks
      character(len=:), allocatable, intent(out) :: text
      character(len=:), allocatable :: particle
      character(len=16) :: factor

      call name_limiting(simulation, particle)
      write (factor, "(f16.2)") limit%factor
      text = "signals   "//number(limit%particles)//" of "//number(limit%all)// &
         " particles make the steps at the end "//trim(adjustl(factor))// &
         " times shorter or more; the fastest: "//particle//"; see doc/guide/running.md"
   end subroutine signal_text

   !> The same for scripts.
   subroutine add_signal_limit(json, limit)
      type(json_t), intent(inout) :: json
      type(signal_limit_t), intent(in) :: limit      !! Counts to report

      call json%begin("steps_limited_by_few")
      call json%add("particles", limit%particles)
      call json%add("factor", limit%factor)
      call json%end()
   end subroutine add_signal_limit
end module output_signal_limit
