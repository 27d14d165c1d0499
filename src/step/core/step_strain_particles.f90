! SPDX-License-Identifier: BSD-3-Clause
!> Gradients of node velocities at the particles of a tile, their strain, and the update of their
!! material.
module step_strain_particles
   use base_kinds, only: wp
   use material_kinematics, only: centre_backward, centre_gradient
   use mesh_grid, only: grid_t
   use particle_split, only: find_opening
   use particle_store, only: store_t
   use particle_stretch, only: stretch_tile
   use step_bounds, only: find_steepest
   use step_dissipation, only: record_losses
   use step_method, only: method_t, stress_before
   use step_node_fields, only: gradient_rows
   use step_node_view, only: view_t
   use step_pressure_relaxation, only: has_normalised_sums, relax_pressures, &
      relaxation_of, relaxes_pressure
   use step_simulation, only: scheme_t, scratch_t, simulation_t, space_t, velocity_field_t
   use step_strain_average, only: average_strain, keep_earlier
   use transfer_affine, only: keep_affine
   use transfer_bbar, only: average_dilatation
   use transfer_shock_compression, only: limit_compression, find_jump
   use transfer_side_kernels, only: add_other_gradient
   use transfer_sides, only: sides_t
   implicit none
   private

   public :: add_gradient, affine_from_strain, find_gradient, gather_rate, strain_particles

contains

   !> Strain the particles of a tile and update the stress of their material.
   subroutine strain_particles(simulation, field, scratch, index, tile, view, dt, fastest)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time of the strain [s]
      real(wp), intent(out) :: fastest               !! Fastest signal and motion [m/s]
      integer :: p, first, n

      first = simulation%stores(index)%first(tile)
      n = simulation%stores(index)%count(tile)
      associate (grid => simulation%space%grid, scheme => simulation%scheme, &
         method => simulation%scheme%method, store => simulation%stores(index), &
         motion => field%nodes%motion, deformation => scratch%deformation)
         deformation%plane = grid%dimensions < 3
         if (method%averages()) then
            call find_gradient(simulation%space, method, scratch, store, tile, &
               motion%velocity(:, :, view%slot), view%gradient_before, view%surplus_before, &
               simulation%clock%dt, .false.)
            call centre_backward(n, deformation%plane, deformation%gradient)
            call keep_earlier(n, deformation%gradient, scratch%half_strain)
         end if
         call find_strain(simulation, field, scratch, index, tile, view, dt)
         if (.not. view%limits_nothing) call find_steepest(deformation%gradient, &
            store%identity(first:first + n - 1), dt, view%limiting_rate, scratch%steepest, &
            scratch%steepest_identity)
         if (method%transfer%affine() .and. affine_from_strain(scheme, index) .and. &
            .not. view%particles_moved) call keep_affine(store, tile, 1.0_wp/dt, &
            deformation%gradient)
         call stretch_tile(store, tile, deformation%gradient)
         if (allocated(store%opening)) call find_opening(method%splitting, grid%spacing, &
            store, tile, deformation%gradient, dt)
         if (view%particles_moved .and. method%leapfrog) then
            call centre_backward(n, deformation%plane, deformation%gradient)
         else
            call centre_gradient(n, deformation%plane, deformation%gradient)
         end if
         if (method%averages()) call average_strain(store, tile, scratch%half_strain, &
            deformation%gradient)
         if (method%limited) call find_jump(grid, store%cell_start(:, tile), &
            motion%strain(:, :, view%slot), view%gradient, method%slack, deformation%gradient, &
            deformation%jump)
         if (has_normalised_sums(scheme, index)) call limit_compression(grid, &
            store%cell_start(:, tile), motion%strain(:, :, view%slot), dt, &
            deformation%gradient, deformation%jump)
         call scratch%laps%update(simulation%materials(index), store%state, deformation, first, &
            first + n - 1, dt, grid%spacing)
         if (relaxes_pressure(method, store)) call relax_pressures(relaxation_of(scheme, &
            simulation%materials(index), index, dt), grid, store, tile, scratch%shape%local, &
            deformation%wave_speed, motion%acceleration(:, :, view%slot), &
            simulation%effects%gravity)
         fastest = 0.0_wp
         do p = 1, n
            fastest = max(fastest, deformation%wave_speed(p) &
               + sqrt(store%velocity(first + p - 1, 1)**2 + store%velocity(first + p - 1, 2)**2 &
               + store%velocity(first + p - 1, 3)**2))
         end do
         call record_losses(scratch%ledger, simulation%materials(index), store%state, &
            deformation, n)
      end associate
   end subroutine strain_particles

   !> Gradient of the velocity that strains times the time step, of both sides if the field has two.
   subroutine find_strain(simulation, field, scratch, index, tile, view, dt)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch !! Scratch memory of this thread; gets the gradient
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), allocatable :: difference(:, :)

      associate (space => simulation%space, stores => simulation%stores, &
         mine => field%nodes%motion)
         call find_gradient(space, simulation%scheme%method, scratch, stores(index), tile, &
            mine%strain(:, :, view%slot), view%gradient, view%surplus, dt, .false.)
         if (.not. field%other > 0) return
         associate (theirs => simulation%fields(field%other)%nodes%motion)
            difference = theirs%strain(:, :, tile) - mine%strain(:, :, tile)
            call add_gradient(space%grid, stores, field%sides, scratch, index, tile, difference, dt)
         end associate
      end associate
   end subroutine find_strain

   !> Velocity gradient times the time step at the particles of a tile.
   subroutine find_gradient(space, method, scratch, store, tile, velocity, gradient, surplus, dt, &
      works)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Gets the gradient
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :)   !! (3, node) [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :)  !! (9, node) Node gradient, if dual [1/s]
      !> (component of `gradient_rows`, node) What its means have too much, if any [1/s]
      real(wp), allocatable, intent(in) :: surplus(:, :)
      real(wp), intent(in) :: dt                     !! Time step [s]
      logical, intent(in) :: works                   !! For the work of the stress, not the strain?
      integer, allocatable :: rows(:)
      integer :: p, k

      associate (grid => space%grid, shape => scratch%shape, start => store%cell_start(:, tile))
         call gather_rate(grid, method, scratch, store, tile, velocity, gradient, dt)
         if (method%controlled()) then
            call method%basis%gather_values(grid, shape, surplus, shape%values)
            allocate (rows, source=gradient_rows(grid))
            do k = 1, size(rows)
               do p = 1, store%count(tile)
                  scratch%deformation%gradient(p, rows(k)) = &
                     scratch%deformation%gradient(p, rows(k)) - dt*shape%values(p, k)
               end do
            end do
         end if
         if (allocated(space%cell)) then
            if (works) then
               call space%cell%place_work(store%count(tile), dt, scratch%deformation%gradient)
            else
               call space%cell%place_strain(store%count(tile), scratch%deformation%gradient)
            end if
         end if
         if (method%even) call average_dilatation(grid, start, store%first(tile), &
            store%state%volume, scratch%deformation%gradient)
      end associate
   end subroutine find_gradient

   !> The same before the means of the nodes are exact, on a mesh at rest.
   subroutine gather_rate(grid, method, scratch, store, tile, velocity, gradient, dt)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Gets the gradient
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :)   !! (3, node) [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :)  !! (9, node) Node gradient, if dual [1/s]
      real(wp), intent(in) :: dt                     !! Time step [s]

      if (method%dual) then
         call method%quadrature%gather_gradient(grid, scratch%shape, velocity, gradient, dt, &
            scratch%deformation%gradient)
      else
         call method%basis%gather_gradient(grid, scratch%shape, velocity, dt, &
            scratch%deformation%gradient)
      end if
      if (grid%axisymmetric) call method%basis%gather_hoop(grid, scratch%shape, &
         store%first(tile), store%position, velocity, dt, scratch%deformation%gradient)
   end subroutine gather_rate

   !> Add the difference between the sides of nodes to a velocity gradient times the time step.
   subroutine add_gradient(grid, stores, sides, scratch, index, tile, difference, dt)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: stores(:)
      type(sides_t), intent(in) :: sides
      type(scratch_t), intent(inout) :: scratch !! Scratch memory of this thread, with the gradient
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(in) :: difference(:, :)       !! (3, node) Difference of the velocities [m/s]
      real(wp), intent(in) :: dt                     !! Time step [s]

      if (.not. sides%cut(tile)) return
      associate (store => stores(index))
         call add_other_gradient(grid, scratch%shape, store, tile, &
            sides%store(index - sides%before)%other, sides%split(:, tile), dt, difference, &
            scratch%deformation%gradient)
      end associate
   end subroutine add_gradient

   !> Do linear velocity fields come from the strain of the step? The modified gradient is less
   !! noisy than that of the cell, and after the step it is the gradient of the new velocities. With
   !! normalised sums it is not used: there the modified gradient of a linear field is not uniform.
   pure logical function affine_from_strain(scheme, index) result(renewed)
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: index                   !! Index of the material and of its store

      renewed = scheme%method%dual .and. scheme%method%stress /= stress_before
      if (renewed .and. allocated(scheme%normalises)) renewed = .not. scheme%normalises(index)
   end function affine_from_strain
end module step_strain_particles
