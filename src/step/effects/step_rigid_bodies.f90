! SPDX-License-Identifier: BSD-3-Clause
!> Rigid bodies that forces move: their velocities at the end of a step, together with the impulses
!! of the nodes that they hold, and their motion over the step.
!!
!! The impulse of a node depends on the velocity of the body after the forces, so both are solved
!! together: then a light body in heavy material is as stable as a heavy one. Equations (R.9) and
!! (R.10) of doc/theory/rigid.md.
module step_rigid_bodies
   use base_elementary, only: cross
   use base_exact_sum, only: exact_sum_t
   use base_exact_totals, only: totals_over_ranks
   use base_kinds, only: wp
   use base_small_system, only: solve_small
   use mesh_rigid, only: press_t, rigid_t
   use mesh_rigid_body, only: rigid_body_t
   use mesh_wall_sums, only: body_entries
   use omp_lib, only: omp_get_thread_num
   use step_ledger, only: ledger_t
   use step_move_nodes, only: ensure_moved, find_free_motion
   use step_node_sums, only: find_sums
   use step_simulation, only: simulation_t, velocity_field_t
   use step_walls, only: apply_boundaries, start_walls
   implicit none
   private

   public :: describe_bodies, move_bodies, solve_bodies, start_bodies

   integer, parameter :: unknowns = 6                !! Velocity and angular velocity
   integer, parameter :: terms = unknowns*(unknowns + 1) !! Impulses, and their derivatives
   integer, parameter :: rounds = 25                 !! Most Newton iterations
   integer, parameter :: patient = 10                !! Those without damping
   real(wp), parameter :: converged = 1.0e-14_wp     !! Relative change of the velocities

   !> Nodes of a tile in rigid regions, before these act.
   type :: free_tile_t
      integer :: tile = 0                            !! Index
      real(wp), allocatable :: own(:)                !! (held) Mass of own particles [kg]
      real(wp), allocatable :: seen(:, :)            !! (3, held) Velocity without any wall [m/s]
      real(wp), allocatable :: velocity(:, :)        !! (3, held) After boundaries [m/s]
      real(wp), allocatable :: acceleration(:, :)    !! (3, held) After boundaries [m/s2]
   end type free_tile_t

contains

   !> Allocate the sums of the threads, empty, for the impulses of a step.
   subroutine start_bodies(simulation)
      type(simulation_t), intent(inout) :: simulation
      integer :: k, n, thread

      if (.not. allocated(simulation%space%rigid)) return
      if (.not. simulation%space%rigid%has_bodies()) return
      do thread = 0, ubound(simulation%scratch, 1)
         associate (scratch => simulation%scratch(thread))
            if (.not. allocated(scratch%bodies)) &
               allocate (scratch%bodies(body_entries, size(simulation%space%rigid%wall)))
            do n = 1, size(scratch%bodies, 2)
               do k = 1, body_entries
                  call scratch%bodies(k, n)%clear()
               end do
            end do
         end associate
      end do
   end subroutine start_bodies

   !> Find the velocities of the bodies after the forces of the step. Collective.
   subroutine solve_bodies(simulation, kick)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      type(free_tile_t), allocatable :: tiles(:)
      type(rigid_body_t), allocatable :: before(:), best(:)
      real(wp), allocatable :: values(:, :)
      real(wp) :: share, change, least
      integer :: n, round

      if (.not. allocated(simulation%space%rigid)) return
      if (.not. simulation%space%rigid%responds() .or. .not. kick > 0.0_wp) return
      share = 1.0_wp - simulation%scheme%method%transfer%flip_fraction()
      call start_walls(simulation%space, simulation%scheme%method, simulation%clock, &
         simulation%balance%ledger, simulation%machine, simulation%scratch, kick)
      allocate (tiles(0))
      do n = 1, size(simulation%fields)
         call find_free_tiles(simulation, simulation%fields(n), kick, tiles)
      end do
      call guess(simulation, kick)
      associate (rigid => simulation%space%rigid)
         allocate (before(size(rigid%wall)), best(size(rigid%wall)))
         least = huge(least)
         do round = 1, rounds
            call sum_impulses(simulation, tiles, kick, share, values)
            change = 0.0_wp
            do n = 1, size(rigid%wall)
               if (.not. allocated(rigid%wall(n)%body)) cycle
               before(n) = rigid%wall(n)%body
               call improve(rigid%wall(n)%body, values(:, n), &
                  gain_of(simulation, rigid%wall(n)%body, kick), &
                  merge(1.0_wp, 0.5_wp, round <= patient), change)
            end do
            if (.not. change > converged) return
            if (.not. change < least) cycle
            least = change
            best = before
         end do
         ! a node that is pressed or not, whichever is assumed: the velocities closest to a solution
         do n = 1, size(rigid%wall)
            if (.not. allocated(rigid%wall(n)%body)) cycle
            rigid%wall(n)%body%velocity_end = best(n)%velocity_end
            rigid%wall(n)%body%spin_end = best(n)%spin_end
         end do
      end associate
   end subroutine solve_bodies

   !> Velocity that gravity and the external force on a body give it in the step [m/s].
   pure function gain_of(simulation, body, kick) result(gain)
      type(simulation_t), intent(in) :: simulation
      type(rigid_body_t), intent(in) :: body
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      real(wp) :: gain(3)

      gain = 0.0_wp
      if (allocated(simulation%effects%gravity)) gain = kick*simulation%effects%gravity
      if (body%mass > 0.0_wp) gain = gain + kick/body%mass*body%force
   end function gain_of

   !> Velocities after the step of bodies on which only gravity and their external force act.
   pure subroutine guess(simulation, kick)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      real(wp) :: gain(3)
      integer :: n

      do n = 1, size(simulation%space%rigid%wall)
         if (.not. allocated(simulation%space%rigid%wall(n)%body)) cycle
         gain = gain_of(simulation, simulation%space%rigid%wall(n)%body, kick)
         associate (body => simulation%space%rigid%wall(n)%body)
            where (body%free) body%velocity_end = body%velocity + gain
            body%spin_end = body%spin
         end associate
      end do
   end subroutine guess

   !> Keep the motion, before rigid regions act, of the own tiles that have nodes in bodies.
   subroutine find_free_tiles(simulation, field, kick, tiles)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      type(free_tile_t), allocatable, intent(inout) :: tiles(:) !! Gets those of this field
      type(free_tile_t), allocatable :: longer(:)
      integer, allocatable :: number(:)
      integer :: n, before

      call ensure_moved(simulation%space, simulation%scheme, simulation%scratch, field%nodes)
      number = pack([(n, n=1, simulation%space%tiles%own)], &
         [(simulation%space%rigid%meets_body(n), n=1, simulation%space%tiles%own)])
      before = size(tiles)
      allocate (longer(before + size(number)))
      longer(:before) = tiles
      call move_alloc(longer, tiles)
      !$omp parallel do default(none) shared(simulation, field, kick, tiles, number, before) &
      !$omp private(n) schedule(static)
      do n = 1, size(number)
         tiles(before + n)%tile = number(n)
         call find_free_tile(simulation, field, kick, tiles(before + n))
      end do
      !$omp end parallel do
   end subroutine find_free_tiles

   !> One tile.
   subroutine find_free_tile(simulation, field, kick, free)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      type(free_tile_t), intent(inout) :: free       !! Its index in, the rest out
      real(wp) :: own(simulation%space%grid%tile_nodes)
      real(wp) :: velocity(3, size(own)), acceleration(3, size(own))
      integer :: slot

      associate (space => simulation%space, motion => field%nodes%motion, &
         scheme => simulation%scheme)
         slot = motion%slot(free%tile)
         if (motion%lean .or. .not. scheme%method%dual) call find_sums(space, motion, free%tile, &
            slot)
         velocity = motion%velocity(:, :, slot)
         acceleration = motion%acceleration(:, :, slot)
         call find_free_motion(space, scheme, simulation%effects, field%nodes%dual, free%tile, &
            motion%mass(:, :, slot), velocity, acceleration)
         call motion%own_mass(space%grid, free%tile, own)
         associate (node => space%rigid%held(free%tile)%node)
            free%own = own(node)
            free%seen = velocity(:, node)
            call apply_boundaries(space, scheme%method, simulation%clock, free%tile, kick, &
               velocity, acceleration)
            free%velocity = velocity(:, node)
            free%acceleration = acceleration(:, node)
         end associate
      end associate
   end subroutine find_free_tile

   !> Impulses on the material of each region, their moments, and their derivatives with respect to
   !! the velocities after the forces. The same on all ranks. Collective.
   subroutine sum_impulses(simulation, tiles, kick, share, values)
      type(simulation_t), intent(inout) :: simulation
      type(free_tile_t), intent(in) :: tiles(:)
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      real(wp), intent(in) :: share                  !! Share of PIC in the transfer, 0 to 1
      real(wp), allocatable, intent(inout) :: values(:, :) !! (term, region)
      type(exact_sum_t), allocatable :: total(:)
      real(wp), allocatable :: part(:, :, :)
      integer :: k, n, regions, tile

      regions = size(simulation%space%rigid%wall)
      allocate (total(terms*regions), part(terms, regions, size(tiles)))
      !$omp parallel do default(none) shared(simulation, tiles, kick, share, part) private(tile) &
      !$omp schedule(static)
      do tile = 1, size(tiles)
         call sum_tile(simulation%space%rigid, tiles(tile), kick, share, part(:, :, tile))
      end do
      !$omp end parallel do
      do tile = 1, size(tiles)
         do n = 1, regions
            do k = 1, terms
               if (abs(part(k, n, tile)) > 0.0_wp) &
                  call total(k + terms*(n - 1))%add(part(k, n, tile))
            end do
         end do
      end do
      if (allocated(values)) deallocate (values)
      allocate (values(terms, regions))
      block
         real(wp) :: numbers(terms*regions)
         call totals_over_ranks(simulation%machine%communicator, total, numbers)
         values = reshape(numbers, shape(values))
      end block
   end subroutine sum_impulses

   !> Those of the nodes of a tile, in their order.
   pure subroutine sum_tile(rigid, free, kick, share, part)
      type(rigid_t), intent(in) :: rigid
      type(free_tile_t), intent(in) :: free
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      real(wp), intent(in) :: share                  !! Share of PIC in the transfer, 0 to 1
      real(wp), intent(out) :: part(:, :)            !! (term, region)
      real(wp) :: velocity(3), acceleration(3), gain(3), derivative(3, 3), arm(3)
      integer :: n

      part = 0.0_wp
      associate (held => rigid%held(free%tile))
         do n = 1, size(held%node)
            if (.not. free%own(n) > 0.0_wp) cycle
            if (.not. allocated(rigid%wall(held%wall(n))%body)) cycle
            velocity = free%velocity(:, n)
            acceleration = free%acceleration(:, n)
            call act_on_node(rigid, free%tile, n, kick, share, free%seen(:, n), velocity, &
               acceleration, derivative)
            gain = kick*(acceleration - free%acceleration(:, n)) + share*(velocity &
               - free%velocity(:, n))
            arm = held%place(:, n) - rigid%wall(held%wall(n))%body%centre
            call add_node(arm, free%own(n)*gain, free%own(n)*derivative, part(:, held%wall(n)))
         end do
      end associate
   end subroutine sum_tile

   !> Velocity and acceleration that a body gives to a node, and the derivative of the velocity
   !! gained with respect to that of the body after the forces.
   pure subroutine act_on_node(rigid, tile, n, kick, share, seen, velocity, acceleration, &
      derivative)
      type(rigid_t), intent(in) :: rigid
      integer, intent(in) :: tile                    !! Index
      integer, intent(in) :: n                       !! Which of its held nodes
      real(wp), intent(in) :: kick                   !! Time that the forces act [s]
      real(wp), intent(in) :: share                  !! Share of PIC in the transfer, 0 to 1
      real(wp), intent(in) :: seen(3)                !! Velocity without any wall [m/s]
      real(wp), intent(inout) :: velocity(3)         !! After boundaries in [m/s]
      real(wp), intent(inout) :: acceleration(3)     !! After boundaries in [m/s2]
      real(wp), intent(out) :: derivative(3, 3)      !! (gain, velocity) [1]
      type(press_t) :: press
      real(wp) :: along(3), across(3, 3), speed
      integer :: k

      call rigid%constrain_node(rigid%held(tile), n, .false., velocity, acceleration)
      call rigid%press(rigid%held(tile), n, kick, share, seen, velocity, acceleration, press)
      derivative = 0.0_wp
      associate (normal => rigid%held(tile)%normal(:, n))
         if (press%sticks .or. .not. maxval(abs(normal)) > 0.0_wp) then
            do k = 1, 3
               derivative(k, k) = 1.0_wp
            end do
            return
         end if
         if (.not. press%pressed) return
         do k = 1, 3
            derivative(:, k) = normal(k)*normal
         end do
         speed = norm2(press%along)
         if (.not. press%friction*speed > 0.0_wp) return
         ! sliding: the friction follows the pressure and the direction of sliding
         along = press%along/speed
         across = -derivative
         do k = 1, 3
            across(k, k) = across(k, k) + 1.0_wp
            across(:, k) = across(:, k) - along(k)*along
            derivative(:, k) = derivative(:, k) - press%friction*normal(k)*along
         end do
         derivative = derivative + press%friction*press%gain/speed*across
      end associate
   end subroutine act_on_node

   !> Add a node: impulse and moment, and their derivatives with respect to velocity and angular
   !! velocity, column by column.
   pure subroutine add_node(arm, push, derivative, part)
      real(wp), intent(in) :: arm(3)                 !! From the centre to the node [m]
      real(wp), intent(in) :: push(3)                !! Impulse [N s]
      real(wp), intent(in) :: derivative(3, 3)       !! Of the impulse by the velocity there [kg]
      real(wp), intent(inout) :: part(:)             !! (term) Of its body
      real(wp) :: unit(3), gain(3), column(3)
      integer :: k, first

      part(1:3) = part(1:3) + push
      part(4:6) = part(4:6) + cross(arm, push)
      do k = 1, unknowns
         unit = 0.0_wp
         unit(1 + mod(k - 1, 3)) = 1.0_wp
         gain = unit
         if (k > 3) gain = cross(unit, arm)
         column = derivative(:, 1)*gain(1) + derivative(:, 2)*gain(2) + derivative(:, 3)*gain(3)
         first = unknowns*k
         part(first + 1:first + 3) = part(first + 1:first + 3) + column
         part(first + 4:first + 6) = part(first + 4:first + 6) + cross(arm, column)
      end do
   end subroutine add_node

   !> A Newton iteration for the velocities of a body after the forces.
   pure subroutine improve(body, values, gain, damping, change)
      type(rigid_body_t), intent(inout) :: body
      real(wp), intent(in) :: values(:)              !! (term) Impulses and derivatives
      real(wp), intent(in) :: gain(3)                !! By gravity and force [m/s]
      real(wp), intent(in) :: damping                !! Part of the change that is made
      real(wp), intent(inout) :: change              !! Greatest relative change of all bodies
      real(wp) :: matrix(unknowns, unknowns), missing(unknowns), inertia(3, 3), scale
      logical :: free(unknowns)
      integer :: k

      if (.not. body%responds()) return
      inertia = body%inertia_in_space()
      matrix = reshape(values(unknowns + 1:), [unknowns, unknowns])
      missing = -values(:unknowns)
      do k = 1, 3
         matrix(k, k) = matrix(k, k) + body%mass
         missing(k) = missing(k) - body%mass*(body%velocity_end(k) - body%velocity(k) - gain(k))
         matrix(4:, 3 + k) = matrix(4:, 3 + k) + inertia(:, k)
         missing(4:) = missing(4:) - inertia(:, k)*(body%spin_end(k) - body%spin(k))
      end do
      free = [body%free, spread(body%free_spin, 1, 3)]
      if (body%plane) free([4, 6]) = .false.
      ! directions without freedom do not change
      do k = 1, unknowns
         if (free(k)) cycle
         matrix(k, :) = 0.0_wp
         matrix(:, k) = 0.0_wp
         matrix(k, k) = 1.0_wp
         missing(k) = 0.0_wp
      end do
      call solve_small(matrix, missing)
      body%velocity_end = body%velocity_end + damping*missing(:3)
      body%spin_end = body%spin_end + damping*missing(4:)
      scale = norm2(body%velocity_end) + norm2(body%velocity) + norm2(gain) &
         + body%radius*(norm2(body%spin_end) + norm2(body%spin))
      if (scale > 0.0_wp) change = max(change, (norm2(missing(:3)) &
         + body%radius*norm2(missing(4:)))/scale)
   end subroutine improve

   !> Give the bodies the impulses that the particles have received, and move them over the step.
   !! Collective.
   subroutine move_bodies(simulation, dt)
      type(simulation_t), intent(inout) :: simulation !! At the start of the step, nodes moved
      real(wp), intent(in) :: dt                     !! Length of the step [s]
      type(exact_sum_t), allocatable :: total(:)
      real(wp), allocatable :: values(:)
      real(wp) :: support(3), hold(3), weight(3), work
      integer :: first, n, thread

      if (.not. allocated(simulation%space%rigid)) return
      if (.not. simulation%space%rigid%has_bodies()) return
      associate (rigid => simulation%space%rigid, ledger => simulation%balance%ledger, &
         kick => simulation%clock%kick, communicator => simulation%machine%communicator)
         allocate (total(body_entries*size(rigid%wall)), values(body_entries*size(rigid%wall)))
         do thread = 0, ubound(simulation%scratch, 1)
            do n = 1, size(total)
               call total(n)%merge(simulation%scratch(thread)%bodies( &
                  1 + mod(n - 1, body_entries), 1 + (n - 1)/body_entries))
            end do
         end do
         call totals_over_ranks(communicator, total, values)
         do n = 1, size(rigid%wall)
            if (.not. allocated(rigid%wall(n)%body)) cycle
            first = body_entries*(n - 1)
            associate (body => rigid%wall(n)%body, push => -values(first + 1:first + 3), &
               moment => -values(first + 4:first + 6))
               weight = body%mass*gain_of(simulation, body, kick)
               call body%receive(push, moment, weight, support, work, hold)
               if (communicator%rank == 0 .and. body%mass > 0.0_wp) call ledger%record_impulse( &
                  push + weight + support, cross(body%centre, push + weight + support) &
                  + moment + hold, work)
               call body%advance(dt, body%home &
                  + rigid%wall(n)%displacement(simulation%clock%time + dt))
            end associate
         end do
      end associate
   end subroutine move_bodies

   !> Momentum, angular momentum and kinetic energy of all bodies with a mass, for the ledger.
   pure subroutine describe_bodies(rigid, ledger)
      type(rigid_t), intent(in) :: rigid
      type(ledger_t), intent(inout) :: ledger
      real(wp) :: way
      integer :: n

      ledger%bodies = 0.0_wp
      ledger%body_scales = 0.0_wp
      do n = 1, size(rigid%wall)
         if (.not. allocated(rigid%wall(n)%body)) cycle
         associate (body => rigid%wall(n)%body)
            if (.not. body%mass > 0.0_wp) cycle
            ledger%has_bodies = .true.
            ledger%bodies(1:3) = ledger%bodies(1:3) + body%mass*body%velocity
            ledger%bodies(4:6) = ledger%bodies(4:6) + body%momentum &
               + body%mass*cross(body%centre, body%velocity)
            ledger%bodies(7) = ledger%bodies(7) + body%kinetic()
            way = body%mass*norm2(body%velocity)
            ledger%body_scales = ledger%body_scales + [way, way*norm2(body%centre) &
               + norm2(body%momentum)]
         end associate
      end do
   end subroutine describe_bodies
end module step_rigid_bodies
