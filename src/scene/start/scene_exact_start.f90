! SPDX-License-Identifier: BSD-3-Clause
!> The first state of a run that follows an exact solution.
module scene_exact_start
   use base_error, only: error_t, exit_input, fail
   use base_kinds, only: wp
   use base_matrix, only: determinant, inverse
   use exact_solution, only: exact_t
   use particle_place, only: place_tile
   use particle_store, only: moved_out, store_t
   use step_simulation, only: simulation_t
   use step_sort_particles, only: sort_particles
   use transfer_affine, only: keep_affine
   implicit none
   private

   public :: place_exact, strain_exact

contains

   !> Move the particles from their lattice to the initial positions of the solution, set their
   !! velocities, and send them to their tiles and ranks. The lattice remains their reference.
   subroutine place_exact(simulation, error)
      type(simulation_t), intent(inout) :: simulation !! The run, particles on their lattice
      type(error_t), allocatable, intent(out) :: error !! Some particle would be outside of the box
      integer :: index, tile, p
      logical :: outside
      real(wp) :: point(3), position(3), velocity(3)

      if (.not. allocated(simulation%effects%exact)) return
      outside = .false.
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index), holder => &
            simulation%effects%exact%material(index))
            if (.not. allocated(holder%solution)) cycle
            do tile = 1, simulation%space%tiles%own
               ! the lattice remains as reference
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  point = store%position(p, :)
                  call holder%solution%place(point, 0.0_wp, position, velocity)
                  store%origin%reference(p, :) = point
                  store%position(p, :) = position
                  store%velocity(p, :) = velocity
               end do
               call place_tile(simulation%space%grid, simulation%space%boundary, &
                  simulation%space%tiles%coordinate(:, tile), store, tile)
               outside = outside .or. any(store%home(store%first(tile):store%first(tile) &
                  + store%count(tile) - 1) == moved_out)
            end do
         end associate
      end do
      if (simulation%machine%communicator%any(outside)) then
         call fail(error, exit_input, "&exact moves particles out of the grid; enlarge "// &
            "&grid [D352]")
         return
      end if
      call sort_particles(simulation)
   end subroutine place_exact

   !> Give the particles volume and stress of the solution.
   subroutine strain_exact(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run, particles in place
      real(wp) :: gradient(3, 3), stress(6), point(3)
      integer :: index, tile, p

      if (.not. allocated(simulation%effects%exact)) return
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index), holder => &
            simulation%effects%exact%material(index))
            if (.not. allocated(holder%solution)) cycle
            do tile = 1, simulation%space%tiles%own
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  point = store%origin%reference(p, :)
                  call holder%solution%gradient(point, 0.0_wp, gradient)
                  call holder%solution%stress(gradient, stress)
                  store%state%stress(p, :) = stress
                  store%state%volume(p) = determinant(gradient)*store%state%volume(p)
                  if (allocated(store%state%deformation_gradient)) &
                     store%state%deformation_gradient(p, :) = reshape(gradient, [9])
               end do
               if (simulation%scheme%method%transfer%affine()) call slope_tile(holder%solution, &
                  store, &
                  tile, 0.1_wp*simulation%space%grid%spacing &
                  /simulation%materials(index)%reference_speed())
               ! quantities that follow from these by the laws, such as the pressure of an equation
               ! of state
               call simulation%materials(index)%find_rest_stress(store%state, store%first(tile), &
                  store%first(tile) + store%count(tile) - 1)
            end do
         end associate
      end do
   end subroutine strain_exact

   !> Linear velocity fields of the particles of a tile.
   subroutine slope_tile(solution, store, tile, dt)
      class(exact_t), intent(in) :: solution
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! A short time [s]
      real(wp) :: slopes(store%count(tile), 9), point(3)
      integer :: p

      do p = 1, store%count(tile)
         point = store%origin%reference(store%first(tile) + p - 1, :)
         slopes(p, :) = velocity_gradient(solution, point, dt)
      end do
      call keep_affine(store, tile, 1.0_wp, slopes)
   end subroutine slope_tile

   !> Velocity gradient of the solution at the start, dF/dt F**-1, component (k, l) at k + 3 (l -
   !! 1).
   pure function velocity_gradient(solution, point, dt) result(slopes)
      class(exact_t), intent(in) :: solution
      real(wp), intent(in) :: point(3)               !! Position at rest [m]
      real(wp), intent(in) :: dt                     !! Over which F is compared, a step [s]
      real(wp) :: slopes(9), before(3, 3), after(3, 3), now(3, 3), product(3, 3)

      call solution%gradient(point, -0.5_wp*dt, before)
      call solution%gradient(point, 0.5_wp*dt, after)
      call solution%gradient(point, 0.0_wp, now)
      after = (after - before)/dt
      now = inverse(now)
      ! arguments that are variables make gfortran inline the product: matmul of its library has
      ! other last bits on other processors
      product = matmul(after, now)
      slopes = reshape(product, [9])
   end function velocity_gradient
end module scene_exact_start
