! SPDX-License-Identifier: BSD-3-Clause
!> Error of a run against its exact solution.
module step_exact_error
   use base_error, only: error_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: wp
   use exact_solution, only: exact_t
   use io_state, only: state_t
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use step_simulation, only: simulation_effects_t, simulation_t
   implicit none
   private

   public :: load_errors, save_errors, measure_errors

   integer, parameter :: errors = 3                  !! Displacement, velocity, stress
   !> Columns of a history.
   character(len=23), parameter, public :: error_columns(errors) = [character(len=23) :: &
      "displacement_error [m]", "velocity_error [m/s]", "stress_error [Pa]"]

contains

   !> Root mean squares, weighted by mass, over all particles that have a solution. Sums of tiles
   !! are exact, so they are the same for any ranks. Once a step. Collective.
   !!
   !! Velocities may be behind positions, and the stress that is updated before the force is that of
   !! the last step; each is compared with the solution at its own time.
   subroutine measure_errors(simulation)
      type(simulation_t), intent(inout) :: simulation !! With an exact solution
      type(exact_sum_t) :: sums(errors + 1)
      real(wp) :: part(errors + 1), farthest, times(errors)
      integer :: index, tile, n

      associate (clock => simulation%clock, method => simulation%scheme%method, &
         space => simulation%space, communicator => simulation%machine%communicator, &
         case => simulation%effects%exact)
         if (case%seen == clock%step) return
         times = clock%time
         times(2) = clock%time - method%lag(clock%dt)
         if (method%strains_first()) times(3) = clock%time - clock%dt
         farthest = 0.0_wp
         do index = 1, size(simulation%stores)
            if (.not. allocated(case%material(index)%solution)) cycle
            do tile = 1, space%tiles%own
               call sum_tile(space%grid, case%material(index)%solution, simulation%stores(index), &
                  tile, times, part, farthest)
               do n = 1, errors + 1
                  call sums(n)%add(part(n))
               end do
            end do
         end do
         do n = 1, errors + 1
            call sums(n)%over_ranks(communicator)
         end do
         case%error = 0.0_wp
         if (sums(errors + 1)%value() > 0.0_wp) then
            do n = 1, errors
               case%error(n) = sqrt(sums(n)%value()/sums(errors + 1)%value())
            end do
         end if
         case%greatest_error = max(case%greatest_error, case%error(1))
         case%greatest_motion = max(case%greatest_motion, communicator%maximum(farthest))
         case%seen = clock%step
      end associate
   end subroutine measure_errors

   !> Sums over the particles of one tile in their order.
   subroutine sum_tile(grid, solution, store, tile, times, sums, farthest)
      type(grid_t), intent(in) :: grid               !! For its periods
      class(exact_t), intent(in) :: solution
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: times(errors)          !! Times of position, velocity, stress [s]
      real(wp), intent(out) :: sums(:)               !! Mass times squares, and mass
      real(wp), intent(inout) :: farthest            !! Greatest displacement of the solution [m]
      real(wp) :: point(3), position(3), velocity(3), gradient(3, 3), stress(6), square(errors)
      real(wp) :: shift, length, other(3)
      integer :: p, k

      sums = 0.0_wp
      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         point = [store%origin%reference(p, 1), store%origin%reference(p, 2), &
            store%origin%reference(p, 3)]
         call solution%place(point, times(2), position, velocity)
         call solution%place(point, times(1), position, other)
         call solution%gradient(point, times(3), gradient)
         call solution%stress(gradient, stress)
         farthest = max(farthest, norm2(position - point))
         square = 0.0_wp
         do k = 1, 3
            shift = store%position(p, k) - position(k)
            length = grid%upper(k) - grid%lower(k)
            if (grid%periodic(k)) shift = shift - length*anint(shift/length)
            square(1) = square(1) + shift**2
            square(2) = square(2) + (store%velocity(p, k) - velocity(k))**2
            square(3) = square(3) + (store%state%stress(p, k) - stress(k))**2 &
               + 2.0_wp*(store%state%stress(p, k + 3) - stress(k + 3))**2
         end do
         sums = sums + store%state%mass(p)*[square, 1.0_wp]
      end do
   end subroutine sum_tile

   !> Write the extremes to the state of a checkpoint.
   subroutine save_errors(effects, state)
      type(simulation_effects_t), intent(in) :: effects
      type(state_t), intent(inout) :: state          !! State of the checkpoint

      if (.not. allocated(effects%exact)) return
      call state%set("exact_errors", [effects%exact%greatest_error, effects%exact%greatest_motion])
   end subroutine save_errors

   !> Read them from a checkpoint, if it has them.
   subroutine load_errors(effects, state)
      type(simulation_effects_t), intent(inout) :: effects
      type(state_t), intent(in) :: state             !! State of the checkpoint
      real(wp), allocatable :: numbers(:)
      type(error_t), allocatable :: error

      if (.not. allocated(effects%exact)) return
      call state%get("exact_errors", numbers, error)
      if (allocated(error)) return
      effects%exact%greatest_error = numbers(1)
      effects%exact%greatest_motion = numbers(2)
   end subroutine load_errors
end module step_exact_error
