! SPDX-License-Identifier: BSD-3-Clause
!> Do a few fast or stiff particles make the steps of a run short?
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
   integer, parameter :: hundred = 100               !! One particle in so many is few

   !> What few particles cost.
   type :: signal_limit_t
      integer(int64) :: particles = 0                !! How many limit the steps, 0: they are many
      integer(int64) :: all = 0                      !! Of how many
      real(wp) :: factor = 1.0_wp                    !! Longer steps without them [1]
   end type signal_limit_t

contains

   !> Find whether few particles limit the steps, and name the fastest one if so. Collective.
   subroutine find_signal_limit(simulation, log, limit)
      type(simulation_t), intent(in) :: simulation   !! The run at its end
      type(log_t), intent(inout) :: log              !! Gets a line if they do
      type(signal_limit_t), intent(out) :: limit     !! What they cost
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
      real(wp), allocatable :: bound(:, :)
      real(wp) :: fastest
      integer(int64) :: counts(2)
      integer :: n

      associate (guard => simulation%clock%guard)
         if (2*guard%steps(rule_signal) <= sum(guard%steps)) return
      end associate
      call find_bounds(simulation, bound)
      fastest = 0.0_wp
      if (size(bound) > 0) fastest = fastest_particle(simulation, bound, maxval(bound))
      fastest = simulation%machine%communicator%maximum(fastest)
      if (.not. (fastest > 0.0_wp .and. fastest < huge(1.0_wp))) return
      do n = 1, size(factors)
         counts = count_faster(simulation, bound, fastest/factors(n))
         call simulation%machine%communicator%total(counts)
         if (hundred*counts(1) > counts(2)) return
         limit = signal_limit_t(counts(1), counts(2), factors(n))
      end do
   end subroutine count_few

   !> Bounds of wave speed and speed of the particles of each tile [m/s].
   subroutine find_bounds(simulation, bound)
      type(simulation_t), intent(in) :: simulation
      real(wp), allocatable, intent(out) :: bound(:, :) !! (tile, store)
      integer :: index, tile, first, last

      allocate (bound(simulation%space%tiles%own, size(simulation%stores)), source=0.0_wp)
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            do tile = 1, size(bound, 1)
               if (store%count(tile) == 0) cycle
               first = store%first(tile)
               last = first + store%count(tile) - 1
               bound(tile, index) = simulation%materials(index)%signal_speed(store%state, first, &
                  last) + sqrt(maxval(store%velocity(first:last, 1)**2 &
                  + store%velocity(first:last, 2)**2 + store%velocity(first:last, 3)**2))
            end do
         end associate
      end do
   end subroutine find_bounds

   !> Wave speed plus speed of a particle [m/s].
   pure real(wp) function signal_of(simulation, index, p) result(signal)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: p                       !! Index of the particle

      associate (store => simulation%stores(index))
         signal = simulation%materials(index)%signal_speed(store%state, p, p) &
            + norm2(store%velocity(p, :))
      end associate
   end function signal_of

   !> Greatest signal of this rank. Tiles are taken in the order of their bounds, until no other one
   !! can hold a faster particle.
   real(wp) function fastest_particle(simulation, bound, highest) result(fastest)
      type(simulation_t), intent(in) :: simulation
      real(wp), intent(in) :: bound(:, :)            !! (tile, store) [m/s]
      real(wp), intent(in) :: highest                !! Greatest bound [m/s]
      real(wp) :: below
      integer :: at(2), p

      fastest = 0.0_wp
      below = 2.0_wp*highest
      do
         if (.not. any(bound > fastest .and. bound < below)) exit
         at = maxloc(bound, mask=bound < below)
         below = bound(at(1), at(2))
         associate (store => simulation%stores(at(2)))
            do p = store%first(at(1)), store%first(at(1)) + store%count(at(1)) - 1
               fastest = max(fastest, signal_of(simulation, at(2), p))
            end do
         end associate
      end do
   end function fastest_particle

   !> Particles of this rank with a greater signal, and all particles. The signals of others are not
   !! found where the bound of their tile is low.
   function count_faster(simulation, bound, speed) result(counts)
      type(simulation_t), intent(in) :: simulation
      real(wp), intent(in) :: bound(:, :)            !! (tile, store) [m/s]
      real(wp), intent(in) :: speed                  !! [m/s]
      integer(int64) :: counts(2)
      integer :: index, tile, p

      counts = 0
      do index = 1, size(bound, 2)
         associate (store => simulation%stores(index))
            counts(2) = counts(2) + sum(int(store%count, int64))
            do tile = 1, size(bound, 1)
               if (.not. bound(tile, index) > speed) cycle
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (signal_of(simulation, index, p) > speed) counts(1) = counts(1) + 1
               end do
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
      type(signal_limit_t), intent(in) :: limit      !! What was found

      call json%begin("steps_limited_by_few")
      call json%add("particles", limit%particles)
      call json%add("factor", limit%factor)
      call json%end()
   end subroutine add_signal_limit
end module output_signal_limit
